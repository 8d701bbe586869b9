"""Highlights as powers of a cosine f: by chords, and what bounds their change.

With the chord D = 2(n·l)n − l − v, the difference of mirror direction and viewer, r·v = 1 − ½|D|²; with D = h − n,
n·h = 1 − ½|D|². Near the peak |D| is small and known to full precision, while a cosine near 1 has lost the digits that
a high shininess asks for. The first D is taken apart, across n and along it: |D|² = |n × (l + v)|² + (n·(l − v))². Then
nothing is left of it where n = l = v, and a rounding of n's length does not count elsewhere.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.base.float_range import BRIGHTEST
from pvphong.base.types import FloatArray
from pvphong.base.vectors import dot, square_of_cross
from pvphong.geometry.extent import ROUNDED_UP
from pvphong.optics.surface import Surface

# Powers below e to this are 0 in float64: NumPy's exp takes up to fifty times as long from there on.
_DARK = -707.5

# Makes room for the square of l + v where it is less than this, for they are nearly opposite; a power of two, so that
# it changes no bit of the others.
_LARGER, _SMALL = 2.0**60, 2.0**-60


def square(w: FloatArray) -> FloatArray:
    """|w|² of columns."""
    return dot(w, w)


def mirror_distance(surface: Surface, l: FloatArray, raw_n_l: FloatArray) -> FloatArray:
    """½|D|² = 1 − r·v."""
    real = surface.raw.dtype.type
    along = raw_n_l - surface.facing
    along *= along
    along += square_of_cross(surface.raw, l + surface.to_viewer)
    along *= real(0.5) * surface.inverse_length * surface.inverse_length
    return along


def halfway_distance(surface: Surface, l: FloatArray) -> FloatArray:
    """½|D|² = 1 − n·h; opposite l and v have no half-way direction, and no highlight."""
    real = surface.raw.dtype.type
    h = l + surface.to_viewer
    lengths = square(h)
    least = lengths.min(initial=1.0)
    if least < _SMALL:
        h *= real(_LARGER)
        lengths = square(h)
    h *= real(1.0) / np.sqrt(np.maximum(lengths, np.finfo(real).tiny))
    distance = real(0.5) * square(h - surface.normals)
    if least < _SMALL:
        np.copyto(distance, 1.0, where=lengths == 0.0)
    return distance


def power(distance: FloatArray, shininess: Any, floor: float) -> Any:
    """max(f, floor)ⁿ for f = 1 − distance, one n or an array of them; 1 for n = 0, also where f is 0."""
    real = distance.dtype.type
    is_flat = np.equal(shininess, 0.0)
    if is_flat.all():
        return real(1.0)
    logarithm = _log1p_of_negative(np.minimum(distance, real(1.0), out=distance))
    if floor:  # here, because 1 − floor would be rounded by far more than the floor's own last bit
        np.maximum(logarithm, real(math.log(floor)), out=logarithm)
    logarithm *= np.clip(shininess, float(np.finfo(real).tiny), BRIGHTEST).astype(real)
    if real is np.float32:
        result = np.exp(logarithm, out=logarithm)
    else:
        shows = logarithm > _DARK
        np.maximum(logarithm, _DARK, out=logarithm)
        result = np.exp(logarithm, out=logarithm)
        result *= shows
    np.copyto(result, 1.0, where=is_flat)
    return result


def _log1p_of_negative(d: FloatArray) -> Any:
    """log(1 − d) for 0 <= d <= 1, to full precision also near 0, in place of NumPy's slower log1p.

    With f the rounded 1 − d and e = (f − 1) + d its error, log(1 − d) = log(f − e) = log f − e/f + O(e²);
    f − 1 is exact (Sterbenz), or e is far below the last bit.
    """
    f = 1.0 - d
    error = f - 1.0
    error += d
    error /= np.maximum(f, np.finfo(f.dtype).tiny)
    logarithm = np.log(f, out=f)
    logarithm -= error
    return logarithm


def steepness(shininess: float) -> float:
    """The largest slope of cosⁿ θ: √n · ((n − 1)/n)^((n − 1)/2) for n >= 1; unbounded below 1, except at 0."""
    if shininess == 0.0:
        return 0.0
    if shininess < 1.0:
        return math.inf
    if shininess == 1.0:
        return 1.0
    return math.sqrt(shininess) * ((shininess - 1.0) / shininess) ** ((shininess - 1.0) / 2.0)


def mirror_change(shininess: float, floor: float, turn: float, psi: float, *, light_moves: bool) -> float:
    """The largest change of (r·v)ⁿ when l or v turns by `turn`, for an angle of at most ψ from light to viewer.

    R turns as much as l does, and (r·v)ⁿ changes by no more than `steepness` times the turn. Where the light moves, a
    vertex may also change sides: there n·l is at most sin δ, so r·v = 2(n·l)(n·v) − l·v is at most 2 sin δ − cos ψ, and
    the highlight that is switched is at most that to the n.
    """
    delta = math.sin(min(turn, math.pi / 2))
    switched = 2.0 * delta - math.cos(min(psi + turn, math.pi))
    return _with_switch(steepness(shininess) * turn, switched, shininess, floor, light_moves)


def halfway_change(shininess: float, turn: float, psi: float, *, light_moves: bool) -> float:
    """`mirror_change` for (n·h)ⁿ.

    H is the middle of the arc from l to v and turns by at most turn / (2 cos ψ/2); at n·l ≈ 0,
    n·h = (n·l + n·v) / (2 cos ψ/2) is at most sin ψ/2 + sin δ / cos ψ/2.
    """
    delta = math.sin(min(turn, math.pi / 2))
    middle = math.cos(min(psi + turn, math.pi) / 2.0)
    if middle <= 1e-6:
        return 1.0
    switched = math.sin(psi / 2.0) + delta / middle
    return _with_switch(steepness(shininess) * turn / (2.0 * middle), switched, shininess, 0.0, light_moves)


def _with_switch(change: float, switched: float, shininess: float, floor: float, light_moves: bool) -> float:
    if light_moves:
        change += min(max(switched, floor, 0.0), 1.0) ** shininess
    return min(change * ROUNDED_UP, 1.0)


def largest_power(cosine: float, shininess: float, floor: float) -> float:
    """Of a cosine that is at most so much: at most so much to the n."""
    return float(max(min(cosine * ROUNDED_UP, 1.0), floor, 0.0) ** shininess)
