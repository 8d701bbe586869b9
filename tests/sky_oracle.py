"""What surfaces make of an image all around, by mpmath, from what `EnvironmentLight` documents and no harmonics.

To keep an image's first bands is to keep those of the lobe, for ∫ (P L) f du = ∫ L (P f) du, P the projection on them.
Of a lobe f(w·u) they are a polynomial in w·u, Σ (2l + 1)/2 · M P_l with M = ∫ f P_l dt, power by power in 40 digits.
Along a circle around the image's top it is a sum of cosines mφ, exactly that of its values at Chebyshev's points;
texels are integrated as cosines along rows, and by Gauss and Legendre's nodes across them.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from operator import mul
from typing import Any

import area_oracle as oracle
import mpmath as mp
from area_oracle import cross, dot, exact_vector, minus, unit

DIGITS, BANDS = 40, 32
BITS = 160
"""After the binary point of whole numbers that stand for these digits, where there is much to compute."""


def axes(up: Sequence[float], rotation: float) -> tuple[list[Any], list[Any], list[Any]]:
    """To the image's middle, right of it, and its top."""
    top = unit(exact_vector(up))
    along = [0, 0, 1] if top[1] == top[2] == 0 else [1, 0, 0]
    ahead = unit(minus(along, [dot(along, top) * x for x in top]))
    turn = mp.radians(mp.mpf(rotation))
    ahead = [mp.cos(turn) * x + mp.sin(turn) * y for x, y in zip(ahead, cross(top, ahead), strict=True)]
    return ahead, cross(ahead, top), top


def around_top(w: Sequence[Any], up: Sequence[float], rotation: float) -> tuple[Any, Any]:
    """A direction's angles: from the image's top, and around it from the middle to the right."""
    ahead, right, top = axes(up, rotation)
    return oracle.angle(w, top), mp.atan2(dot(w, right), dot(w, ahead))


def _fixed(x: Any) -> int:
    return int(mp.nint(mp.ldexp(x, BITS)))


@cache
def _legendre() -> list[list[Any]]:
    """Coefficients of tʲ in each P_l."""
    rows = [[mp.mpf(j == l) for j in range(BANDS)] for l in range(2)]
    for l in range(1, BANDS - 1):
        up = [mp.mpf(0), *rows[l][:-1]]
        rows.append([((2 * l + 1) * a - l * b) / (l + 1) for a, b in zip(up, rows[l - 1], strict=True)])
    return rows


@cache
def _kept(power: float) -> list[int]:
    """The first bands of a lobe tᵏ, as coefficients of powers of the cosine t; ∫ tᵏ tʲ dt = 1/(k + j + 1)."""
    total = [mp.mpf(0)] * BANDS
    for l, row in enumerate(_legendre()):
        moment = mp.fsum(x / (mp.mpf(power) + j + 1) for j, x in enumerate(row))
        total = [t + (l + mp.mpf(0.5)) * moment * x for t, x in zip(total, row, strict=True)]
    return [_fixed(x) for x in total]


@cache
def _cosines() -> list[list[int]]:
    """cos mψ at Chebyshev's points ψ, for each m."""
    return [[_fixed(mp.cos(m * mp.pi * (j + mp.mpf(0.5)) / BANDS)) for j in range(BANDS)] for m in range(BANDS)]


def in_bands(image: Any, up: Any, rotation: float, w: Any, power: float) -> list[Any]:
    """1/π · ∫ L max(w·u, 0)ᵏ du of each channel, in its first bands; w of length 1. Not cut off below 0."""
    with mp.workdps(DIGITS):
        theta_w, phi_w = around_top(w, up, rotation)
        height, width, channels = image.shape
        ground = image[-1, -1]  # of one colour everywhere, the integral is that of the first band
        result = [2 * mp.mpf(float(x)) / (mp.mpf(power) + 1) for x in ground]
        waves = [_waves(2 * mp.pi * (mp.mpf(j) / width - mp.mpf(0.5)) - phi_w) for j in range(width + 1)]
        for i in range(height):
            if (image[i] == ground).all():
                continue
            across = _across_row(i, height, theta_w, power)
            texels = [mp.fdot(across, [b - a for a, b in zip(*ends, strict=True)]) for ends in pairwise(waves)]
            for c in range(channels):
                more = [mp.mpf(float(x)) - mp.mpf(float(ground[c])) for x in image[i, :, c]]
                result[c] += mp.fdot(texels, more) / mp.pi
        return result


def _waves(angle: Any) -> list[Any]:
    """∫ cos mφ dφ from 0."""
    return [angle, *(mp.sin(m * angle) / m for m in range(1, BANDS))]


def _across_row(i: int, height: int, theta_w: Any, power: float) -> list[Any]:
    """∫ of each cosine's coefficient · sin θ dθ over a row."""
    kept, cosines = _kept(power)[::-1], _cosines()
    sums = [mp.mpf(0)] * BANDS
    for theta, weight in oracle.nodes_between(mp.pi * i / height, mp.pi * (i + 1) / height, 24 + BANDS // height):
        level, aside = _fixed(mp.cos(theta) * mp.cos(theta_w)), _fixed(mp.sin(theta) * mp.sin(theta_w))
        values = [_horner(kept, level + (aside * c >> BITS)) for c in cosines[1]]
        weight *= mp.ldexp(mp.sin(theta) / BANDS, -2 * BITS)
        sums = [
            s + weight * (2 if m else 1) * sum(map(mul, values, row))
            for m, (s, row) in enumerate(zip(sums, cosines, strict=True))
        ]
    return sums


def _horner(coefficients: list[int], t: int) -> int:
    value = 0
    for coefficient in coefficients:
        value = (value * t >> BITS) + coefficient
    return value
