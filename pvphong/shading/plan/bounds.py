"""Bounds on what a light can contribute, and on how much a small turn can change it.

Symbols: δ the largest angle by which a direction may be off, n the shininess, ψ the angle between the
directions to light and viewer. All bounds hold for every normal.
"""

from __future__ import annotations

import math

from pvphong.base.types import Vector, VectorLike
from pvphong.geometry.extent import ROUNDED_UP, sight
from pvphong.optics.lights import DirectionalLight, Light, PointLight, SpotLight
from pvphong.shading.equation import Equation, LightTerm
from pvphong.shading.plan.draft import Draft


def attenuation(coefficients: VectorLike, distance: float) -> float:
    """1 / (c + l·d + q·d²)."""
    constant, linear, quadratic = coefficients
    weakening = constant + distance * (linear + distance * quadratic)
    return 1.0 / weakening if weakening > 0.0 else math.inf


def strongest(draft: Draft, term: LightTerm) -> float:
    """The largest attenuation times gain that can reach a vertex; infinite where nothing is known."""
    if isinstance(term.light, DirectionalLight):
        return term.gain
    if not isinstance(term.light, (PointLight, SpotLight)):
        return math.inf
    seen = sight(term.light.position, draft.extent)
    if seen is None:
        return math.inf
    nearest = max(seen.distance - seen.radius, 0.0) / ROUNDED_UP
    return term.gain * attenuation(term.light.attenuation, nearest) * ROUNDED_UP


def whole(term: LightTerm) -> float:
    """The largest sum of a term's colours, for strength 1."""
    channels = zip(term.ambient, term.diffuse, term.specular, strict=True)
    return max(a + d + s for a, d, s in channels)


def steepness(shininess: float) -> float:
    """The largest slope of cosⁿ θ: √n · ((n − 1)/n)^((n − 1)/2) for n >= 1; unbounded below 1, except at 0."""
    if shininess == 0.0:
        return 0.0
    if shininess < 1.0:
        return math.inf
    if shininess == 1.0:
        return 1.0
    return math.sqrt(shininess) * ((shininess - 1.0) / shininess) ** ((shininess - 1.0) / 2.0)


def angle(a: VectorLike, b: VectorLike) -> float:
    """Between two unit vectors, in radians; right to 1e-7, for arc cosines lose half the digits near 0 and π."""
    return math.acos(max(-1.0, min(1.0, a[0] * b[0] + a[1] * b[1] + a[2] * b[2])))


def light_seen(draft: Draft, light: Light) -> tuple[VectorLike, float] | None:
    """Direction to a light, and the angle by which it may be off at a vertex; None where nothing is known."""
    if isinstance(light, DirectionalLight):
        return light.to_light, 1e-7
    if not isinstance(light, (PointLight, SpotLight)):
        return None
    seen = sight(light.position, draft.extent)
    return None if seen is None else (seen.direction, seen.turn + 1e-7)


def viewer_seen(draft: Draft, eye: Vector | None) -> tuple[Vector, float] | None:
    """Direction to the viewer, at infinity where there is no eye, and the angle by which it may be off at a vertex."""
    if eye is None:
        return draft.equation.to_eye, 1e-7
    seen = sight(eye, draft.extent)
    return None if seen is None else (seen.direction, seen.turn + 1e-7)


def widest_to_viewer(draft: Draft, direction: VectorLike, light_angle: float) -> float:
    """The greatest ψ over all vertices, for a light that is seen within an angle of a direction."""
    seen = viewer_seen(draft, draft.equation.eye)
    if seen is None:
        return math.pi
    v, spread = seen
    return min(angle(v, direction) + (light_angle + spread) * ROUNDED_UP, math.pi)


def highlight_change(equation: Equation, turn: float, most: float, light_moves: bool) -> float:
    """The largest change of the highlight factor when l or v turns by `turn`, for ψ of at most `most`.

    Phong: r turns as much as l does, and (r·v)ⁿ changes by no more than `steepness` times the turn. Where
    the light moves, a vertex may also change sides: there n·l is at most sin δ, so r·v = 2(n·l)(n·v) − l·v
    is at most 2 sin δ − cos ψ, and the highlight that is switched is at most that to the n.

    Blinn-Phong: h is the middle of the arc from l to v and turns by at most turn / (2 cos ψ/2); at n·l ≈ 0,
    n·h = (n·l + n·v) / (2 cos ψ/2) is at most sin ψ/2 + sin δ / cos ψ/2.
    """
    n, delta = equation.shininess, math.sin(min(turn, math.pi / 2))
    middle = math.cos(min(most + turn, math.pi) / 2.0)
    if equation.reflection == "blinn-phong":
        if middle <= 1e-6:
            return 1.0
        change, switched = steepness(n) * turn / (2.0 * middle), math.sin(most / 2.0) + delta / middle
    else:
        change, switched = steepness(n) * turn, 2.0 * delta - math.cos(min(most + turn, math.pi))
    if light_moves:
        floored = max(switched, equation.cosine_floor, 0.0)
        change += min(floored, 1.0) ** n
    return min(change * ROUNDED_UP, 1.0)
