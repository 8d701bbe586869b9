"""Spherical harmonics: projection of an environment image, convolution with lobes, and bounds on omitted bands.

The real harmonics Y are orthonormal; band l has 2l + 1 of them. By the Funk-Hecke theorem, convolution with f(w·u)
scales each band: ∫ f(w·u) Y(u) du = 2π M Y(w), with M = ∫ f(t) P_l(t) dt over [−1, 1] (for Lambert's cosine: R.
Ramamoorthi and P. Hanrahan, "An efficient representation for irradiance environment maps", 2001).

Symbols: for a unit vector (x, y, z) with x + iy = ρ exp(iφ), the harmonics Y are Q(z) ρᵐ cos mφ and Q(z) ρᵐ sin mφ,
where Q is a polynomial in z alone. An image has a coefficient for each of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from pvphong.base.formulas import (
    any_of,
    arctan2,
    dot,
    formula,
    maximum,
    minimum,
    multiply_add,
    power_less_one,
    select,
    sine,
    sqrt,
)
from pvphong.base.types import Float64Array
from pvphong.optics.area.lobes import COUNT, NODES, POWER, WINDOW, lobe_numbers

BANDS = 32
"""Largest number of bands by which an image is represented."""

# Quadrature nodes per row of texels, in addition to the number that depends on the row's height.
_NODES = 14


@cache
def _recurrences(l: int) -> tuple[Float64Array, Float64Array]:
    """Return the coefficients a and b of a recurrence for the polynomials Q of band l.

    It is Q_l = a (z Q_{l−1} − b Q_{l−2}), for m = 0, …, l − 1. Both results have the shape (l, 1).
    """
    square = np.arange(l)[:, None] ** 2.0
    below = (l - 1.0) ** 2
    return np.sqrt((4.0 * l * l - 1.0) / (l * l - square)), np.sqrt((below - square) / (4.0 * below - 1.0))


@cache
def _first(m: int) -> float:
    """Return the polynomial Q of the order m in its first band, l = m, in which it is constant.

    The result includes the factor √2 that cosines and sines have for m > 0.
    """
    constant = math.sqrt(0.25 / math.pi) * math.sqrt(2.0 if m else 1.0)
    return constant * math.prod(math.sqrt((2.0 * k + 1.0) / (2.0 * k)) for k in range(1, m + 1))


def _polynomials(z: Float64Array, start: Float64Array) -> Iterator[Float64Array]:
    """Yield, for each band l, the values of the polynomials Q at n numbers z: an array (l + 1, n), a row for each m.

    Row m of `start`, shape (bands, n), has the polynomial of the order m in its first band, l = m. If a row of `start`
    is multiplied by a factor, all results for its m have this factor.
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
    """Project an image with constant texels, shape (h, w, 3), onto the harmonics of the first `bands` bands.

    The result has the shape (3, bands, bands, 2), with the indices [channel, l, m, 0 for cosine or 1 for sine]. The
    coefficients are exact up to rounding: integration is analytic along rows, and by Gauss-Legendre quadrature across
    them.
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
    """Return the integrals of cos mφ and of sin mφ over intervals of φ, an array of each.

    The intervals are those between consecutive angles in `edges`.
    """
    if not m:
        return np.diff(edges), np.zeros(len(edges) - 1)
    return np.diff(np.sin(m * edges)) / m, -np.diff(np.cos(m * edges)) / m


def energies(coefficients: Float64Array) -> Float64Array:
    """Return the integral of each band's square over the sphere, for each channel, shape (3, bands).

    `coefficients` is the result of `projected`.
    """
    return np.asarray((coefficients**2).sum(axis=(2, 3)))


# Layout of a sky's numbers:
# - three axes;
# - ½ / ∫ cosᵏ over a right angle, or 0 if the horizon does not cut the lobe off;
# - factors of x, y and z;
# - 1 if series are in z², 0 if they are in z;
# - the number of series;
# - for each series: 1 if it is multiplied by z, else 0; the number of steps; the first R;
# - for each step of a series: A, B and C, and the coefficients of cosine and sine.
_AXES, _PER_WHOLE, _LINEAR, _IN_SQUARES, _SERIES, _TERMS = 0, 9, 10, 13, 14, 15


def sky_numbers(axes: Float64Array, coefficients: Float64Array, hiding: float | None) -> tuple[float, ...]:
    """Return the numbers that the formula `sky` reads.

    For each order m, `sky` sums a series of polynomials Q in z. Convolution with a cosine lobe removes all odd bands
    except the first. Then only every other Q is evaluated: 1 or z times a polynomial R in z².

    Parameters
    ----------
    axes : ndarray
        Shape (3, 3): unit vectors to the image's middle, to its right and up, as rows.
    coefficients : ndarray
        Shape (bands, bands, 2): coefficients of one channel, as from `projected`, after convolution with the lobe.
    hiding : float or None
        Exponent of the lobe if the horizon may cut the lobe off; else None.
    """
    bands, linear = len(coefficients), (0.0, 0.0, 0.0)
    in_squares = bands > 3 and not coefficients[3::2].any()
    if in_squares:
        (up, _), (ahead, right) = coefficients[1, 0].tolist(), coefficients[1, 1].tolist()
        linear = _first(1) * ahead, _first(1) * right, math.sqrt(0.75 / math.pi) * up
    terms = [term for m in range(bands) for term in _series(m, coefficients, in_squares=in_squares)]
    per_whole = 0.0
    if hiding:
        per_whole = 0.5 / float(_up_to(lobe_numbers(hiding), np.array([0.5 * math.pi]))[0])
    return (*axes.ravel().tolist(), per_whole, *linear, float(in_squares), float(bands), *terms)


def _series(m: int, coefficients: Float64Array, *, in_squares: bool) -> list[float]:
    """Return the numbers of the series of the order m, in the layout that the comment above `sky_numbers` describes.

    The series satisfies R_l+1 = (A t + B) R_l − C R_l−1. If `in_squares`, t = z²; else t = z. `coefficients` has the
    shape (bands, bands, 2), as for `sky_numbers`.
    """
    bands = len(coefficients)
    a, b = [0.0] * bands, [0.0] * bands
    for l in range(m + 1, bands):
        a[l], b[l] = (float(factor[m, 0]) for factor in _recurrences(l))
    if not in_squares:
        steps = [(a[l], 0.0, a[l] * b[l], l) for l in range(m, bands)]
        return [0.0, float(len(steps)), _first(m), *_numbers_of(steps, m, coefficients)]
    first, steps = m + m % 2, list[tuple[float, float, float, int]]()
    for l in range(first, bands, 2):
        if l == first:
            steps.append((0.0, 0.0, 0.0, l))
            continue
        one, two, was = a[l - 1], a[l], a[l - 2]  # z Q_l−3 is written in terms of Q_l−2 and Q_l−4
        less = one * b[l - 1] / was if was else 0.0
        steps.append((two * one, -two * (less + b[l]), two * one * b[l - 1] * b[l - 2], l))
    start = _first(m) * (a[first] if m % 2 and first < bands else 1.0)
    return [float(m % 2), float(len(steps)), start, *_numbers_of(steps, m, coefficients)]


def _numbers_of(steps: list[tuple[float, float, float, int]], m: int, coefficients: Float64Array) -> list[float]:
    return [number for *step, l in steps for number in (*step, *coefficients[l, m].tolist())]


@formula
def sky(own: Any, lobe: Any, _d: Any, n: Any, a: Any) -> Any:
    """Return the light that a lobe reflects from a sky: a formula with the arguments of `Integral.formula`.

    The result is the sum of the sky's harmonics in the direction a, times the fraction of the lobe around a that is
    above the horizon. `own` is from `sky_numbers`, and `lobe` from `lobe_numbers`.
    """
    x, y, z = dot((own[0], own[1], own[2]), a), dot((own[3], own[4], own[5]), a), dot((own[6], own[7], own[8]), a)
    t = z * z if own[_IN_SQUARES] > 0.0 else z
    total = own[_LINEAR] * x + own[_LINEAR + 1] * y + own[_LINEAR + 2] * z
    even, odd, at = 1.0 + 0.0 * z, 0.0 * z, _TERMS  # ρᵐ cos mφ and sin mφ
    for m in range(int(own[_SERIES])):
        if m > 0:
            even, odd = x * even - y * odd, x * odd + y * even
        is_times_z, steps = own[at] > 0.0, int(own[at + 1])
        before, here, with_even, with_odd = 0.0 * z, own[at + 2] + 0.0 * z, 0.0 * z, 0.0 * z
        at += 3
        for k in range(steps):
            if k > 0:
                factor = multiply_add(own[at], t, own[at + 1])
                before, here = here, multiply_add(factor, here, -own[at + 2] * before)
            with_even = multiply_add(own[at + 3], here, with_even)
            with_odd = multiply_add(own[at + 4], here, with_odd)
            at += 5
        series = even * with_even + odd * with_odd
        total = total + (series * z if is_times_z else series)
    found = maximum(total, 0.0)
    if own[_PER_WHOLE] > 0.0:
        sine_above = minimum(maximum(dot(n, a), -1.0), 1.0)
        above = arctan2(sine_above, sqrt(1.0 - sine_above * sine_above))
        share, is_cut = 0.5 + 0.0 * z, abs(above) < lobe[WINDOW]
        if any_of(is_cut):
            share = select(is_cut, minimum(own[_PER_WHOLE] * _up_to(lobe, abs(above)), 0.5), 0.5)
        found = found * (0.5 + select(above < 0.0, -share, share))
    return select((dot(n, n) > 0.5) & (dot(a, a) > 0.5), found, 0.0)


@formula
def _up_to(lobe: Any, angle: Any) -> Any:
    """Integrate cosᵏ from 0 to an angle of at most 90°.

    `lobe` is from `lobe_numbers`; it contains k and the quadrature nodes. A gnomonic projection turns the lobe
    max(w·u, 0)ᵏ into Student's t distribution. Along a line, the density of this distribution is cosᵏ.
    """
    half, total = 0.5 * minimum(angle, lobe[WINDOW]), 0.0 * angle
    for k in range(int(lobe[COUNT])):
        height = sine(0.5 * half * (1.0 + lobe[NODES + 2 * k]))
        total = total + lobe[NODES + 2 * k + 1] * (1.0 + power_less_one(2.0 * height * height, lobe[POWER]))
    return total * half


def moments(power: float, bands: int) -> Float64Array:
    """Return the factors M by which a lobe max(t, 0)ᵏ scales the bands l = 0, …, `bands` − 1; k is `power`."""
    found = [1.0 / (power + 1.0), 1.0 / (power + 2.0)]
    for l in range(2, bands):
        found.append(found[l - 2] * (power - l + 2.0) / (power + l + 1.0))
    return np.array(found[:bands])


def moments_left(power: float, bands: int) -> float:
    """Return √(Σ (2l + 1) M²) over all l >= `bands`, rounded up; M are the factors that `moments` returns.

    By Parseval's theorem, this sum follows from the sum over the other bands.
    """
    kept = moments(power, bands)
    return math.sqrt(max(2.0 / (2.0 * power + 1.0) - float((2.0 * np.arange(bands) + 1.0) @ kept**2), 0.0) + 1e-15)
