"""The kernel's loops over caps of the unit sphere, as which sphere lights are seen; formulas as in `optics.spherical`.

In float32. A power's integral is taken around the cap's edge, with χ in sin χ/2 = √q sin φ, and q such that the power
shows up to there: 10 nodes in φ are exact to 7e-7. Caps that are small against the lobe lose digits that way; for them,
seven points on the cap are exact to 1e-7. A cap that the horizon cuts is a disk across its middle, to `rims`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.shading.kernel import rims
from pvphong.shading.kernel import vertices as at
from pvphong.shading.kernel.angles32 import angle_above, less_arctan
from pvphong.shading.kernel.arithmetic import exp2, exp2_less_one32, inlined, like, log2_power, multiply_add, plain
from pvphong.shading.kernel.vertices import BLOCK, mirrored_viewer, normal_dot, square_of

_F = np.float32
_ZERO, _HALF, _ONE, _TWO = _F(0.0), _F(0.5), _F(1.0), _F(2.0)
_PI, _HALF_PI = _F(math.pi), _F(0.5 * math.pi)
_TINY = _F(2.0**-126)

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(10)
_PHI = 0.25 * math.pi * (_NODES + 1.0)
_SQUARES = tuple(_F(x) for x in np.sin(_PHI) ** 2)
_SHARES = tuple(_F(x) for x in 0.25 * math.pi * _WEIGHTS * np.cos(_PHI))

# From here on a window is opened to the whole circle: near its end it would be steep.
_WIDE = _F(0.7)
# Of the hexagon on a cap whose seven points have all its moments up to the fifth degree: cos 30°, and its 1 − cos α
# over that of the edge.
_COS_30, _INWARD = _F(math.sqrt(0.75)), _F(2.0 / 3.0)
_QUARTER = _F(0.25)


@inlined
def reaches(less: Any, s: Any, nothing: Any) -> bool:
    """Whether a lobe shows on a cap.

    Parameters
    ----------
    less
        1 − z for the cap's middle.
    s
        Sine of its angular radius, which is less than 90°.
    nothing
        The 1 − z from which the lobe is nothing.
    """
    sine, cosine = np.sqrt(less * (_TWO - less)), np.sqrt(max(_ONE - s * s, _ZERO))
    off, near = sine * cosine - (_ONE - less) * s, (_ONE - less) * cosine + sine * s
    nearest = off * off / (_ONE + near) if near > _ZERO else _ONE - near
    return (nearest < nothing) | (off < _ZERO)


@plain
def see_cap(rows: Any, radius: float) -> None:
    """Sine and cosine of a sphere's angular radius, and n·l, for distances in the row of strengths; 0 inside it."""
    r = like(rows, radius)
    for i in range(BLOCK):
        distance = rows[at.STRENGTH + i]
        sine = min(r / distance, _ONE)
        outside = max(distance - r, _ZERO)
        rows[at.SINE + i] = sine if outside > _ZERO else _ZERO
        rows[at.COSINE + i] = np.sqrt(outside / distance * (_ONE + sine))
        n_d = normal_dot(rows, i, rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i])
        rows[at.TILT + i] = n_d * (rows[at.NEARNESS + i] * rows[at.INVERSE + i])


@plain
def cap_cosine(rows: Any, target: int) -> None:
    """∫ max(n·u, 0) du / (π s²) into a row."""
    is_cut = False
    for i in range(BLOCK):
        c, s = rows[at.TILT + i], rows[at.SINE + i]
        rows[target + i] = max(c, _ZERO) if s > _ZERO else _ZERO
        is_cut = is_cut | (abs(c) < s)
    if not is_cut:
        return
    for i in range(BLOCK):
        c, s, cosine = rows[at.TILT + i], rows[at.SINE + i], max(rows[at.COSINE + i], _TINY)
        w = np.sqrt(max((s - c) * (s + c), _ZERO))
        least = max(s, _TINY)
        t = min(w, cosine) / max(w, cosine)
        p = less_arctan(t * t)
        turned = t - t * (t * t * p)
        ratio = w / (least * cosine)
        small = t * (_ONE - p * (ratio * ratio))
        large = (_HALF_PI - turned - cosine * w) / (least * least)
        cut = (multiply_add(c, angle_above(w, -cosine * c), small if w <= cosine else large)) * _F(1.0 / math.pi)
        has_normal = rows[at.INVERSE + i] > _ZERO
        is_lit = square_of(rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i]) > _ZERO
        cut = cut if has_normal & is_lit else _ZERO
        rows[target + i] = cut if abs(c) < s else rows[target + i]


@plain
def cap_power(rows: Any, target: int, exponent: float, shown: float, small: float) -> bool:
    """∫ max(w·u, 0)ⁿ du / (π s²) above the horizon into a row; whether no vertex is declined.

    `shown` is the 1 − z from which zⁿ⁺¹ is nothing, `small` the sine below which a cap is small against the lobe.
    """
    nothing, tiny = like(rows, shown), like(rows, small)
    any_small, any_large, any_cut = False, False, False
    for i in range(BLOCK):
        # the mirrored viewer's way off l, by its chord
        shrink, inverse = rows[at.INVERSE + i], rows[at.NEARNESS + i]
        nx, ny, nz = rows[at.NX + i] * shrink, rows[at.NY + i] * shrink, rows[at.NZ + i] * shrink
        sx = multiply_add(rows[at.DX + i], inverse, rows[at.VX + i])
        sy = multiply_add(rows[at.DY + i], inverse, rows[at.VY + i])
        sz = multiply_add(rows[at.DZ + i], inverse, rows[at.VZ + i])
        across = square_of(
            multiply_add(ny, sz, -(nz * sy)), multiply_add(nz, sx, -(nx * sz)), multiply_add(nx, sy, -(ny * sx))
        )
        c, s, cosine = rows[at.TILT + i], rows[at.SINE + i], rows[at.COSINE + i]
        along = c - rows[at.FACING + i] * shrink
        less = min(_HALF * multiply_add(along, along, across), _TWO)
        sine = np.sqrt(less * (_TWO - less))
        off = sine * cosine - (_ONE - less) * s  # sin(γ − a)
        near = (_ONE - less) * cosine + sine * s
        nearest = off * off / (_ONE + near) if near > _ZERO else _ONE - near
        is_reached = (s > _ZERO) & (c > -s) & ((nearest < nothing) | (off < _ZERO)) & (shrink > _ZERO)
        is_cut = is_reached & (c < s)
        is_small = s < tiny
        any_small = any_small | (is_reached & is_small)
        any_large = any_large | (is_reached & (not is_small))
        any_cut = any_cut | is_cut
        rows[target + i] = _ONE if is_reached else _ZERO
        rows[at.OWN + i], rows[at.OWN + BLOCK + i] = less, sine
        rows[at.OWN + 2 * BLOCK + i], rows[at.OWN + 3 * BLOCK + i] = nearest, off
    if any_large:
        _around(rows, like(rows, exponent) + _ONE, nothing)
    if any_small:
        _on_points(rows, like(rows, exponent))
    good = _cut_power(rows, target, exponent, shown, small) if any_cut else True
    for i in range(BLOCK):
        is_small = rows[at.SINE + i] < tiny
        found = rows[at.OWN + 7 * BLOCK + i] if is_small else rows[at.OWN + 6 * BLOCK + i]
        found = rows[rims.FOUND + i] if rows[at.TILT + i] < rows[at.SINE + i] else found
        rows[target + i] = max(found, _ZERO) if rows[target + i] > _ZERO else _ZERO
    return good


@inlined
def _cut_power(rows: Any, reached: int, exponent: float, shown: float, small: float) -> bool:
    """The same where the horizon cuts a cap that the lobe reaches, into the row of `rims`."""
    for i in range(BLOCK):
        wx, wy, wz = mirrored_viewer(rows, i)
        rows[rims.WX + i], rows[rims.WY + i], rows[rims.WZ + i] = wx, wy, wz
        inverse = rows[at.NEARNESS + i]
        rows[rims.EX + i], rows[rims.EY + i] = rows[at.DX + i] * inverse, rows[at.DY + i] * inverse
        rows[rims.EZ + i] = rows[at.DZ + i] * inverse
        rows[rims.FORWARD + i], rows[rims.RADIUS + i] = rows[at.COSINE + i], rows[at.SINE + i]
        is_cut = (rows[reached + i] > _ZERO) & (rows[at.TILT + i] < rows[at.SINE + i])
        rows[rims.FOUND + i] = _ONE if is_cut else _ZERO
    return rims.power_within_rim(rows, exponent, shown, small, False)


@plain
def _around(rows: Any, power: Any, nothing: Any) -> None:
    """The integral along the edge, into the seventh row of a stage's own."""
    least = like(rows, -np.inf)
    for i in range(BLOCK):
        spread = _TWO * rows[at.OWN + BLOCK + i] * rows[at.SINE + i]
        nearest = rows[at.OWN + 2 * BLOCK + i]
        q = max((nothing - nearest) / max(spread, _TINY), _ZERO)
        rows[at.OWN + 4 * BLOCK + i] = _ONE if q > _WIDE else q
        rows[at.OWN + 5 * BLOCK + i] = spread
        rows[at.OWN + 6 * BLOCK + i] = _ZERO
    for k in range(len(_SQUARES)):
        for i in range(BLOCK):
            y = rows[at.OWN + 4 * BLOCK + i] * _SQUARES[k]
            off, cosine = rows[at.OWN + 3 * BLOCK + i], rows[at.COSINE + i]
            away = max(multiply_add(rows[at.OWN + 5 * BLOCK + i], y, rows[at.OWN + 2 * BLOCK + i]), _TINY)
            raised = log2_power(_TWO * away, power, least)
            shown = -exp2_less_one32(raised) if away < _ONE else _ONE
            step = multiply_add(rows[at.OWN + 5 * BLOCK + i] * cosine, y, -(rows[at.SINE + i] * off))
            density = shown * step / (away * (_TWO - away) * np.sqrt(_ONE - y))
            rows[at.OWN + 6 * BLOCK + i] = multiply_add(_SHARES[k], density, rows[at.OWN + 6 * BLOCK + i])
    for i in range(BLOCK):
        q, s, less = rows[at.OWN + 4 * BLOCK + i], rows[at.SINE + i], rows[at.OWN + i]
        root = np.sqrt(q)
        outward = -rows[at.OWN + 3 * BLOCK + i] - _TWO * s * (_ONE - less) * q
        sideways = _TWO * s * root * np.sqrt(max(_ONE - q, _ZERO))
        rest = angle_above(sideways, -outward) if q < _ONE else _ZERO
        turned = multiply_add(_TWO * root, rows[at.OWN + 6 * BLOCK + i], rest)
        rows[at.OWN + 6 * BLOCK + i] = turned * (_TWO / _PI) / (power * max(s * s, _TINY))


@inlined
def _power(less: Any, exponent: Any, least: Any) -> Any:
    """(1 − less)ⁿ, 0 where that is negative."""
    raised = log2_power(_TWO * max(less, _ZERO), exponent, least)
    return exp2(raised) if less < _ONE else _ZERO


@plain
def _on_points(rows: Any, exponent: Any) -> None:
    """The mean over the seven points, into the eighth row of a stage's own."""
    least = like(rows, -np.inf)
    for i in range(BLOCK):
        less, sine, s = rows[at.OWN + i], rows[at.OWN + BLOCK + i], rows[at.SINE + i]
        plus = _ONE + rows[at.COSINE + i]
        inward = _INWARD * (s * s / plus)
        level = less + inward - less * inward
        aside = _COS_30 * sine * np.sqrt(inward * (_TWO - inward))
        total = _power(less, exponent, least) + _power(level, exponent, least)
        total += _power(level - aside, exponent, least) + _power(level + aside, exponent, least)
        rows[at.OWN + 7 * BLOCK + i] = _QUARTER * total * (_TWO / plus)
