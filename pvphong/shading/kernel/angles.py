"""The angle of a direction in the plane, in a form that vectorises: libm's `atan2` keeps loops from that.

One division takes the ratio of the smaller to the larger coordinate, or of their difference to their sum, to between
-tan(π/8) and tan(π/8), where atan(u) = u + u³·P(u²), P of degree 10: 5e-18 by `mpmath.chebyfit`, highest power
first. Measured against mpmath: within 1.5 · 2⁻⁵² of the angle.
"""

from __future__ import annotations

import math

from pvphong.shading.kernel.arithmetic import contracted, inlined

_ATAN = (
    -0.019176887119062166, 0.039231658295587106, -0.05085449737940256, 0.05858148912802209, -0.06664511447381948,
    0.07692183190826087, -0.09090904578123903, 0.11111111015256361, -0.14285714284666542, 0.1999999999999552,
    -0.3333333333333333,
)  # fmt: skip

_STEEPEST = math.tan(math.pi / 8)


@contracted
def _series(z: float) -> float:
    total = _ATAN[0]
    for k in range(1, len(_ATAN)):
        total = total * z + _ATAN[k]
    return total


@inlined
def angle_of(y: float, x: float) -> float:
    """atan2(y, x), from -π to π, in float64; π where x is zero of either sign and y too."""
    a, b = abs(x), abs(y)
    less, more = min(a, b), max(a, b)
    is_steep = less > _STEEPEST * more
    over = less + more if is_steep else more
    u = (less - more if is_steep else less) / (over if over > 0.0 else 1.0)
    angle = (math.pi / 4 if is_steep else 0.0) + (u + u * (u * u) * _series(u * u))
    angle = math.pi / 2 - angle if b > a else angle
    angle = angle if x > 0.0 else math.pi - angle
    return -angle if y < 0.0 else angle
