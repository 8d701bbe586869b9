"""Bounds on each kind of light, and the cheaper lights that may replace it in a plan.

These rules decide whether a light reaches the mesh; a light that does not is removed. Black lights, and those too weak
for the tolerance, are removed by `effects.Lights`.

Four functions dispatch on the kind of light. `effects` returns the names of its effects: position, attenuation, cone,
size, sky. `reach` returns bounds on its contribution. `simpler` returns a cheaper light without one of the effects, and
a bound on the error. `without` returns a light without one of the effects, whatever the error. Kinds that are not
registered have no bounds, so they run unchanged.

In order: these functions; lights with a position and falloff, and cones; area lights; environment lights.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import singledispatch
from typing import Any, NamedTuple

import numpy as np

from pvphong.base.types import Float64Array, Vector, VectorLike
from pvphong.base.vectors import angle_between, unit_vector
from pvphong.geometry.extent import ROUNDED_UP, TURN_SLACK, BoundingCone, MeshBounds
from pvphong.optics.attenuation import INVERSE_SQUARE, NONE, attenuate, strength_at
from pvphong.optics.light import NODES, Light
from pvphong.optics.lights import (
    DirectionalLight,
    EnvironmentLight,
    PhotometricLight,
    PointLight,
    SphereLight,
    SpotLight,
)
from pvphong.optics.lights.point import Weakening
from pvphong.optics.lights.sized import Flat

POSITION, ATTENUATION, CONE, SIZE, SKY = "position", "attenuation", "cone", "size", "sky"
"""Names of the effects of lights."""

# Least distance, in radii of the vertices' sphere, at which a light's direction may be replaced by a constant.
_FAR = 2
# Uncertainty of angles in radians: arc cosines lose half the digits near 0.
_SLACK = 1e-6
# Bound on the overshoot of a harmonic expansion relative to its image.
_OVERSHOOT = 2.0


class LightBounds(NamedTuple):
    """Bounds on a light's contribution to the vertices inside a sphere. By default, nothing is known."""

    strongest: float = math.inf
    """Largest strength at any vertex, rounded up; infinite if there is no bound."""

    direction: Vector | None = None
    """Unit vector to the light from the sphere's centre; None if unknown."""

    turn: float = 0.0
    """Largest angle in radians between `direction` and the direction to the light at a vertex."""


class Approximation(NamedTuple):
    """Cheaper lights that may replace a light, and bounds on the error."""

    make: Callable[[], tuple[Light, ...]] | None
    """Function that returns the cheaper lights; None if the original does not reach the mesh. Only position and falloff
    of a cheaper light are used; colours and intensity are those of the original. If several lights replace an area
    light's nodes, their diffuse colours and intensities multiply those of the original."""

    why: str = ""
    """Reason for the replacement. The text `{bound}` in it is replaced by the colour error."""

    factor: float = 1.0
    """Factor that multiplies the cheaper lights' strength."""

    spread: float = 0.0
    """Largest error of the sum of the cheaper lights' strengths."""

    turn: float | None = None
    """Largest error of the direction to the light, in radians; None if the direction is exact."""

    strongest: float = 1.0
    """Largest sum of strengths at any vertex, over all parts of an area light. It is used if the direction has an
    error."""


# --- functions that dispatch on the kind of light


@singledispatch
def effects(light: Any) -> frozenset[str]:
    """Return the names of a light's effects.

    By default: the position, and the size if the light has a size. A uniform light has no effects.
    """
    if light.is_uniform:
        return frozenset()
    return frozenset({POSITION, SIZE} if light.has_size else {POSITION})


@singledispatch
def reach(light: Any, extent: MeshBounds) -> LightBounds:  # noqa: ARG001 no bounds
    """Return bounds on a light's contribution to the vertices in `extent`."""
    return LightBounds()


@singledispatch
def simpler(light: Any, effect: str, extent: MeshBounds, *, exactly: bool) -> Approximation | None:  # noqa: ARG001 there is none
    """Return a cheaper light that may replace a light, without one of its effects; None if there is none.

    Parameters
    ----------
    light : Light
        The light to replace.
    effect : str
        The effect to remove, one of the names that `effects` returns.
    extent : MeshBounds
        Bounds on the vertices. They are slow to compute, so use them only if necessary.
    exactly : bool
        True if the replacement must give the same colours to the last bit.
    """
    return None


@singledispatch
def without(light: Any, effect: str, point: Vector) -> tuple[Light, float]:  # noqa: ARG001 there is none
    """Return a light without one of its effects, whatever the error, and a factor for its strength.

    `effect` is one of the names that `effects` returns. Only position and falloff of the returned light are used;
    colours and intensity are those of the original. A value that varies over the mesh is replaced by its value at
    `point`.
    """
    return light, 1.0


def _parallel_at(light: Any, point: Vector) -> tuple[Light, float]:
    """Return the parallel light that replaces a light, and the strength of the parallel light.

    Direction and strength are those with which the light arrives at `point`.
    """
    arrival = light.arrival(np.array(point)[:, None])
    x, y, z = (-arrival.direction[:, 0]).tolist()
    if not (x or y or z):  # the light is at the point, so that there is no direction
        return light, 1.0
    return DirectionalLight(direction=(x, y, z)), float(np.broadcast_to(arrival.strength, 1)[0])


# --- directional lights


@effects.register
def _(light: DirectionalLight) -> frozenset[str]:
    """Return the names of a directional light's effects: the size, if it has an angle."""
    return frozenset({SIZE} if light.has_size else ())


@reach.register
def _(light: DirectionalLight, extent: MeshBounds) -> LightBounds:  # noqa: ARG001 the same everywhere
    """Return the bounds of a directional light: its strength, its direction and, with an angle, its angular radius.

    The strength is 1. With an angle, it is the sum over all parts of the light.
    """
    x, y, z = unit_vector(light.direction)
    if not light.has_size:
        return LightBounds(1.0, (-x, -y, -z), TURN_SLACK)
    return LightBounds(_of_all_parts(light), (-x, -y, -z), light.angular_radius * ROUNDED_UP + TURN_SLACK)


def _of_all_parts(light: DirectionalLight) -> float:
    """Return the sum of the strengths of all parts (nodes) of a directional light with an angle, rounded up."""
    return 2.0 / (1.0 + math.cos(light.angular_radius)) * ROUNDED_UP


@simpler.register
def _(light: DirectionalLight, effect: str, extent: MeshBounds, *, exactly: bool) -> Approximation | None:  # noqa: ARG001 the same everywhere
    """Return the parallel light from the middle of a directional light with an angle.

    Return None for other effects than "size". Return None also if `exactly` is True: the colours must then stay the
    same to the last bit.
    """
    if exactly or effect != SIZE:
        return None
    why, strongest = "small: equal to parallel light to within {bound:.2g}", _of_all_parts(light)
    turn = light.angular_radius * ROUNDED_UP
    return Approximation(lambda: light.nodes(1), why, spread=strongest - 1.0, turn=turn, strongest=strongest)


@without.register
def _(light: DirectionalLight, effect: str, point: Vector) -> tuple[Light, float]:  # noqa: ARG001 the same everywhere
    """Return a directional light without the effect `effect`, and the factor 1.

    Without the size, it is parallel light from the middle of the light.
    """
    return (light.nodes(1)[0] if effect == SIZE else light), 1.0


# --- lights without a size, at a position


@effects.register
def _(light: Weakening) -> frozenset[str]:
    """Return the names of a point light's effects: the position and, unless it is constant 1, the attenuation."""
    return frozenset({POSITION} if tuple(light.attenuation) == NONE else {POSITION, ATTENUATION})


@reach.register
def _(light: Weakening, extent: MeshBounds) -> LightBounds:
    """Return the bounds of a light with attenuation, for the vertices in `extent`.

    The largest strength is the strength at the smallest possible distance.
    """
    seen = extent.sight(light.position)
    if seen is None:
        return LightBounds()
    return LightBounds(_strongest(seen, light.attenuation), seen.direction, seen.turn + TURN_SLACK)


def _strongest(seen: BoundingCone, attenuation: VectorLike) -> float:
    """Return the largest strength at any vertex of a light with this attenuation.

    `seen` bounds the directions and distances from the vertices to the light.
    """
    return strength_at(max(seen.distance - seen.radius, 0.0) / ROUNDED_UP, attenuation) * ROUNDED_UP


def _evenly_strong(light: Any, extent: MeshBounds, *, exactly: bool) -> Approximation | None:
    """Return the same light without attenuation; None if there is no bound on the error.

    `extent` bounds the vertices. If `exactly` is True, the colours must stay the same to the last bit, so a light is
    returned only if the attenuation is constant. If it is False, the attenuation may vary, but no vertex may be at the
    light's position, because the error has no bound there.
    """
    constant, linear, quadratic = light.attenuation

    def even() -> tuple[Light]:
        return (replace(light, attenuation=NONE),)

    if not linear and not quadratic:
        return Approximation(even, f"constant, {1.0 / constant:g}", 1.0 / constant)
    seen = None if exactly else extent.sight(light.position)
    if seen is None or seen.distance <= seen.radius:
        return None
    radius, why = seen.radius * ROUNDED_UP, "constant over the mesh to within {bound:.2g}"
    near, far = (strength_at(seen.distance + offset, light.attenuation) for offset in (-radius, radius))
    return Approximation(even, why, (near + far) / 2, (near - far) / 2)


@simpler.register
def _(light: PointLight, effect: str, extent: MeshBounds, *, exactly: bool) -> Approximation | None:
    """Return the light that may replace a point light without the effect `effect`; None if there is none.

    `extent` bounds the vertices. If `exactly` is True, the colours must stay the same to the last bit.

    Without the attenuation, it is a point light of constant strength. Without the position, it is parallel light.
    Parallel light replaces only a point light without attenuation that is far away, and never if `exactly` is True.
    """
    if effect == ATTENUATION:
        return _evenly_strong(light, extent, exactly=exactly)
    if effect != POSITION or exactly or tuple(light.attenuation) != NONE:
        return None
    seen = extent.sight(light.position)
    if seen is None or seen.distance < _FAR * seen.radius:
        return None
    x, y, z = seen.direction
    why = "far away: its direction is constant to within {bound:.2g}"
    return Approximation(lambda: (DirectionalLight(direction=(-x, -y, -z)),), why, turn=seen.turn)


@without.register
def _(light: Weakening, effect: str, point: Vector) -> tuple[Light, float]:
    """Return a light with attenuation without the effect `effect`, and a factor for its strength.

    Without the attenuation, the factor is the strength at `point`. Without the position, it is parallel light with the
    direction and the strength at `point`.
    """
    this: Any = light
    if effect == ATTENUATION:
        distance = np.array([math.dist(light.position, point)])
        return replace(this, attenuation=NONE), float(attenuate(distance, light.attenuation)[0])
    return _parallel_at(light, point) if effect == POSITION else (this, 1.0)


@reach.register
def _(light: PhotometricLight, extent: MeshBounds) -> LightBounds:
    """Return the bounds of a photometric light: those of a point light with the lamp's largest intensity."""
    return reach.dispatch(Weakening)(light, extent)


@without.register
def _(light: PhotometricLight, effect: str, point: Vector) -> tuple[Light, float]:
    """Return a photometric light without the effect `effect`, and a factor for its strength.

    Without the position, it is parallel light with the direction and the strength at `point`.
    """
    return _parallel_at(light, point) if effect == POSITION else (light, 1.0)


@effects.register
def _(light: SpotLight) -> frozenset[str]:
    """Return the names of a spot light's effects: those of a point light, and the cone."""
    return effects.dispatch(Weakening)(light) | {CONE}


@simpler.register
def _(light: SpotLight, effect: str, extent: MeshBounds, *, exactly: bool) -> Approximation | None:
    """Return the light that may replace a spot light without the effect `effect`; None if there is none.

    `extent` bounds the vertices. If `exactly` is True, the colours must stay the same to the last bit.

    Without the attenuation, it is a spot light of constant strength. Without the cone, it is a point light if the mesh
    is inside the cone. If the mesh is outside, the result says that the light does not reach the mesh. The position is
    never removed.
    """
    if effect == ATTENUATION:
        return _evenly_strong(light, extent, exactly=exactly)
    seen = extent.sight(light.position) if effect == CONE else None
    if seen is None:
        return None
    middle, edge = math.pi - angle_between(seen.direction, light.axis), math.radians(light.cone_angle)
    least, most = max(middle - seen.turn, 0.0), min(middle + seen.turn, math.pi)
    if least > edge + _SLACK:
        margin = math.degrees(least - edge)
        shown = f"{margin:.0f}" if margin >= 1.0 else f"{margin:.1g}"
        return Approximation(None, f"mesh lies outside the cone by {shown}°")
    if most >= edge - _SLACK or (exactly and light.exponent):
        return None
    found = Approximation(lambda: (_without_cone(light),), "mesh lies inside the cone")
    if light.exponent == 0.0:
        return found
    angles = max(least - _SLACK, 0.0), most + _SLACK
    brightest, darkest = (max(math.cos(off_axis), 0.0) ** light.exponent for off_axis in angles)
    why = f"{found.why}, whose light is constant to within {{bound:.2g}}"
    spread = _strongest(seen, light.attenuation) * (brightest - darkest) / 2
    return found._replace(why=why, factor=(brightest + darkest) / 2, spread=spread)


@without.register
def _(light: SpotLight, effect: str, point: Vector) -> tuple[Light, float]:
    """Return a spot light without the effect `effect`, and a factor for its strength.

    Without the cone, it is a point light. Without attenuation, it is a spot light with the constant strength at
    `point`. Without the position, it is parallel light with the direction and the strength at `point`.
    """
    return (_without_cone(light), 1.0) if effect == CONE else without.dispatch(Weakening)(light, effect, point)


def _without_cone(light: SpotLight) -> PointLight:
    return PointLight(position=light.position, attenuation=light.attenuation)


# --- area lights, whose parts have 1/d² falloff


@reach.register
def _(light: SphereLight, extent: MeshBounds) -> LightBounds:
    """Return the bounds of a sphere light, for the vertices in `extent`.

    They hold for all points of the light's surface.
    """
    return _reach_within(light.places[0], light.radius, extent)


@reach.register
def _(light: Flat, extent: MeshBounds) -> LightBounds:
    """Return the bounds of a flat area light, for the vertices in `extent`.

    They hold for all points of a sphere around the light.
    """
    return _reach_within(light.center, light.reach_radius, extent)


def _reach_within(center: Vector, radius: float, extent: MeshBounds) -> LightBounds:
    """Return the bounds of a light inside a sphere, for the vertices in `extent`.

    `center` and `radius` are those of the sphere.
    The sphere's nearest point bounds the distance of the light. The sphere's outline bounds its direction.
    """
    seen = extent.sight(center)
    if seen is None:
        return LightBounds()
    nearest, wide = max(seen.distance - seen.radius - radius, 0.0) / ROUNDED_UP, seen.radius + radius
    turn = math.asin(wide / seen.distance) * ROUNDED_UP if wide < seen.distance else math.pi
    return LightBounds(strength_at(nearest, INVERSE_SQUARE) * ROUNDED_UP, seen.direction, turn)


@simpler.register
def _(light: SphereLight, effect: str, extent: MeshBounds, *, exactly: bool) -> Approximation | None:
    """Return the point light at the centre that may replace a sphere light; None if the error has no bound.

    `extent` bounds the vertices. Only the effect "size" can be removed. If `exactly` is True, the colours must stay the
    same to the last bit, so None is returned.

    The sphere's image is a uniform disk. Its strength is 2 / (1 + √(1 − s²)) times 1/d², with s the sine of the disk's
    angular radius, and d the distance.
    """
    if exactly or effect != SIZE:
        return None
    return _as_point(extent.sight(light.places[0]), light.radius, light.nodes(1)[0], lambda s: s * s / 2.0)


@simpler.register
def _(light: Flat, effect: str, extent: MeshBounds, *, exactly: bool) -> Approximation | None:
    """Return the spot light at the centre that may replace a flat light; None if the error has no bound.

    `extent` bounds the vertices. Only the effect "size" can be removed. If the mesh is behind the light, the result
    says that the light does not reach the mesh. If `exactly` is True, the colours must stay the same to the last bit,
    so no spot light is returned.

    At height h above the light's plane and distance d, a part of the light has the strength h/d³. The mean over the
    light differs from the value at its centre by at most half the largest second derivative, 12 h/d⁵, times the square
    of the light's radius. With s the sine of the light's angular radius, this difference is 6 s²/(1 − s)⁵ times 1/d².
    """
    seen = extent.sight(light.center) if effect == SIZE else None
    if seen is None:
        return None
    radius = light.reach_radius
    height = -seen.distance * sum(a * b for a, b in zip(seen.direction, light.normal, strict=True))
    clear = seen.radius * ROUNDED_UP + 1e-9 * (seen.distance + radius)
    if height <= -clear and not light.two_sided:
        return Approximation(None, "mesh lies behind it")
    if exactly or (light.two_sided and abs(height) < clear):
        return None
    part = light.part(light.center, math.copysign(1.0, height) if light.two_sided else 1.0, 1.0)
    return _as_point(seen, radius, part, lambda s: 6.0 * s * s / (1.0 - s) ** 5)


def _as_point(seen: BoundingCone | None, radius: float, light: Light, spread: Any) -> Approximation | None:
    """Return a light without a size that replaces a light inside a sphere.

    Return None if the sphere is near, or nothing is known about the vertices.

    Parameters
    ----------
    seen : BoundingCone or None
        Bounds on the directions from the vertices to the sphere's centre.
    radius : float
        Radius of the sphere.
    light : Light
        The replacement, with intensity 1.
    spread : callable
        Function of the sine of the sphere's angular radius. It returns the largest difference between two strengths:
        the sum over the light's parts, and 1/d², the strength from the centre. The difference is in units of 1/d².
    """
    nearest = 0.0 if seen is None else (seen.distance - seen.radius) / ROUNDED_UP
    if nearest <= 2.0 * radius:
        return None
    sine, middle = radius / nearest, strength_at(nearest, INVERSE_SQUARE) * ROUNDED_UP
    why = "small: equal to a point light to within {bound:.2g}"
    off, turn = middle * spread(sine), math.asin(sine) * ROUNDED_UP
    return Approximation(lambda: (light,), why, spread=off, turn=turn, strongest=middle + off)


@without.register
def _(light: SphereLight, effect: str, point: Vector) -> tuple[Light, float]:
    """Return a sphere light without the effect `effect`, and a factor for its strength.

    Without the size, it is a point light at the centre. Without the position, it is parallel light with the direction
    and the strength at `point`.
    """
    return (light.nodes(1)[0], 1.0) if effect == SIZE else _parallel_at(light, point)


@without.register
def _(light: Flat, effect: str, point: Vector) -> tuple[Light, float]:
    """Return a flat area light without the effect `effect`, and a factor for its strength.

    Without the size, it is a spot light at the centre. Without the position, it is parallel light with the direction
    and the strength at `point`.
    """
    if effect != SIZE:
        return _parallel_at(light, point)
    height = sum(n * (p - c) for n, p, c in zip(light.normal, point, light.center, strict=True))
    return light.part(light.center, -1.0 if light.two_sided and height < 0.0 else 1.0, 1.0), 1.0


def merged_nodes(light: Light, count: int, extent: MeshBounds) -> Approximation | None:
    """Return at most `count` nodes that may replace a light's `NODES` nodes; None if there is no bound on the error.

    The nodes of an area light are small lights at points of it; their sum replaces the area light. Nodes that are close
    together are merged at their mean position. At distance d, 1/d² changes by at most 2/d³ per unit of length. So does
    h/d³, the falloff of a flat light at height h above its plane (the field of a dipole).

    Parameters
    ----------
    light : Light
        A light whose nodes have the same intensity.
    count : int
        Largest number of nodes.
    extent : MeshBounds
        Bounds on the vertices.
    """
    nodes: tuple[Any, ...] = light.nodes(NODES)
    if not nodes[0].places:
        return None
    positions = np.array([node.position for node in nodes])
    x, y, z = positions.mean(axis=0).tolist()
    radius = float(np.linalg.norm(positions - (x, y, z), axis=1).max()) * ROUNDED_UP
    seen = extent.sight((x, y, z))
    nearest = 0.0 if seen is None else (seen.distance - seen.radius) / ROUNDED_UP - radius
    alike: dict[Any, list[Any]] = {}
    for node in nodes:
        alike.setdefault(replace(node, position=(0.0, 0.0, 0.0)), []).append(node.position)
    if not nearest > 0.0 or count < len(alike):
        return None
    found, farthest = [], 0.0
    for node, places in alike.items():
        for group in _halved(np.array(places), count // len(alike)):
            middle = group.mean(axis=0)
            farthest = max(farthest, float(np.linalg.norm(group - middle, axis=1).max()) * ROUNDED_UP)
            found.append(replace(node, position=middle, intensity=node.intensity * len(group)))
    if not farthest < nearest:
        return None
    strongest = strength_at(nearest, INVERSE_SQUARE) * ROUNDED_UP
    spread, turn = 2.0 * farthest / nearest * strongest, math.asin(farthest / nearest)
    return Approximation(lambda: tuple(found), spread=spread, turn=turn, strongest=strongest)


def _halved(places: Float64Array, count: int) -> Sequence[Float64Array]:
    """Split positions, shape (n, 3), into at most `count` groups of neighbours.

    Groups are halved repeatedly along their longest axis.
    """
    if count < 2 or len(places) < 2:
        return [places]
    order = np.argsort(places[:, int(np.argmax(np.ptp(places, axis=0)))], kind="stable")
    return [part for half in np.array_split(places[order], 2) for part in _halved(half, count // 2)]


# --- environment lights


@effects.register
def _(light: EnvironmentLight) -> frozenset[str]:
    """Return the names of an environment light's effects: "sky", unless the light is the same from all directions."""
    return frozenset({SKY}) if light.bands > 1 else frozenset()


@reach.register
def _(light: EnvironmentLight, extent: MeshBounds) -> LightBounds:  # noqa: ARG001 the same everywhere
    """Return the bounds of an environment light: a bound on its strength, and no direction.

    No lobe reflects more of this light than a constant factor of 1 would.
    """
    strongest = max(1.0, _OVERSHOOT * float(light.panorama.total.max())) * ROUNDED_UP
    return LightBounds(strongest, None, 0.0)
