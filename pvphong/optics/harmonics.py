"""Spherical harmonics: an image all around in bands, what lobes make of it, and how much the bands left out hold.

The real harmonics Y are orthonormal; in band l there are 2l + 1. By Funk and Hecke, a function f(w·u) is a factor to
a band: ∫ f(w·u) Y(u) du = 2π M Y(w), with M = ∫ f(t) P_l(t) dt over [−1, 1] (for Lambert's cosine: R. Ramamoorthi and
P. Hanrahan, "An efficient representation for irradiance environment maps", 2001).

Symbols: c, the image's coefficients, are those of Q(z) · ρᵐ cos mφ and sin mφ for a unit vector (x, y, z) with
x + iy = ρ exp(iφ): Q is what of Y is a polynomial in z alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache

import numpy as np

from pvphong.base.types import Float64Array

BANDS = 32
"""So many bands are kept of an image, at most."""

# Directions that are looked in at once, so that the numbers of all bands stay in the processor's caches.
_AT_ONCE = 512

# Nodes for a row of texels, beside those that its height asks for.
_NODES = 14


@cache
def _recurrences(l: int) -> tuple[Float64Array, Float64Array]:
    """The a and b in Q_l = a (z Q_{l−1} − b Q_{l−2}), for all m < l, (l, 1) each."""
    square = np.arange(l)[:, None] ** 2.0
    below = (l - 1.0) ** 2
    return np.sqrt((4.0 * l * l - 1.0) / (l * l - square)), np.sqrt((below - square) / (4.0 * below - 1.0))


@cache
def _first(m: int) -> float:
    """Q for l = m, with the √2 of cosines and sines."""
    constant = math.sqrt(0.25 / math.pi) * math.sqrt(2.0 if m else 1.0)
    return constant * math.prod(math.sqrt((2.0 * k + 1.0) / (2.0 * k)) for k in range(1, m + 1))


def _polynomials(z: Float64Array, start: Float64Array) -> Iterator[Float64Array]:
    """Q of band after band, for all m there are, (l + 1, n); times what `start`, (bands, n), is to the first of each m.

    Bands are as many as `start` has rows.
    """
    before, here = start[:0], start[:1]
    yield here
    for l in range(1, len(start)):
        a, b = _recurrences(l)
        more = a * z * here
        more[:-1] -= a[:-1] * b[:-1] * before
        before, here = here, np.concatenate([more, start[l : l + 1]])
        yield here


def projected(image: Float64Array, bands: int) -> Float64Array:
    """Coefficients c of an image (h, w, 3), each texel one colour: (3, bands, bands, 2), [channel, l, m, cos or sin].

    Exact but for rounding: along a row cosines are integrated as they are, across it by Gauss and Legendre's nodes.
    """
    height, width, _ = image.shape
    count = _NODES + 2 * bands // height
    nodes, weights = np.polynomial.legendre.leggauss(count)
    half = 0.5 * math.pi / height
    theta = (half * (2.0 * np.arange(height)[:, None] + 1.0 + nodes)).ravel()
    z, rho = np.cos(theta), np.sin(theta)
    edges = np.linspace(-math.pi, math.pi, width + 1)
    waves = np.array([_along(edges, m) for m in range(bands)])  # (bands, 2, w)
    along = (image.transpose(0, 2, 1).reshape(-1, width) @ waves.reshape(-1, width).T).reshape(height, 3, bands, 2)
    result = np.zeros((3, bands, bands, 2))
    start = np.array([_first(m) * rho ** (m + 1) for m in range(bands)])
    for l, q in enumerate(_polynomials(z, start)):
        across = half * q.reshape(l + 1, height, count) @ weights
        result[:, l, : l + 1] = np.einsum("mh,hcmt->cmt", across, along[:, :, : l + 1])
    return result


def _along(edges: Float64Array, m: int) -> tuple[Float64Array, Float64Array]:
    """∫ cos mφ dφ and ∫ sin mφ dφ between edges."""
    if not m:
        return np.diff(edges), np.zeros(len(edges) - 1)
    return np.diff(np.sin(m * edges)) / m, -np.diff(np.cos(m * edges)) / m


def energies(coefficients: Float64Array) -> Float64Array:
    """∫ of the square of what each band adds to each channel, shape (3, bands)."""
    return np.asarray((coefficients**2).sum(axis=(2, 3)))


def lit_by(coefficients: Float64Array, directions: Float64Array) -> Float64Array:
    """The sum of harmonics in directions (3, n), for the coefficients (bands, bands, 2) of one channel."""
    result = np.empty(directions.shape[1])
    for begin in range(0, len(result), _AT_ONCE):
        result[begin : begin + _AT_ONCE] = _lit_by(coefficients, directions[:, begin : begin + _AT_ONCE])
    return result


def _lit_by(coefficients: Float64Array, directions: Float64Array) -> Float64Array:
    (x, y, z), bands = directions, len(coefficients)
    around = np.empty((bands, 2, len(x)))  # ρᵐ cos mφ, ρᵐ sin mφ
    around[0] = [np.ones_like(x), np.zeros_like(x)]
    for m in range(1, bands):
        cosine, sine = around[m - 1]
        around[m] = x * cosine - y * sine, x * sine + y * cosine
    sums = np.zeros_like(around)
    start = np.array([[_first(m)] for m in range(bands)]) * np.ones_like(z)
    for l, q in enumerate(_polynomials(z, start)):
        for kind in range(2):
            if coefficients[l, :, kind].any():
                sums[: l + 1, kind] += coefficients[l, : l + 1, kind, None] * q
    return np.asarray(np.einsum("mkn,mkn->n", sums, around))


def moments(power: float, bands: int) -> Float64Array:
    """M for the function max(t, 0)ᵏ, k the power: of each band."""
    found = [1.0 / (power + 1.0), 1.0 / (power + 2.0)]
    for l in range(2, bands):
        found.append(found[l - 2] * (power - l + 2.0) / (power + l + 1.0))
    return np.array(found[:bands])


def moments_left(power: float, bands: int) -> float:
    """√(Σ (2l + 1) M²) over the bands that are not among the first so many, by Parseval's theorem; rounded up."""
    kept = moments(power, bands)
    return math.sqrt(max(2.0 / (2.0 * power + 1.0) - float((2.0 * np.arange(bands) + 1.0) @ kept**2), 0.0) + 1e-15)
