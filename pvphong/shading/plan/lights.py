"""Knowledge of a plan about each kind of light: what of it reaches a mesh, and which cheaper light may replace it.

The answer to "why was my light left out?". Four questions, each a function with an answer by kind: the `effects` that
a light calls for, its `reach`, the `simpler` light that may replace it, and the light `without` an effect. A kind that
is not here runs as it is: nothing is known of it, and it is never left out.

In order: the questions; lights with a place that weaken, and cones; lights with a size; light from all around.
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
from pvphong.geometry.extent import ROUNDED_UP, TURN_SLACK, Extent, Sight
from pvphong.optics.attenuation import INVERSE_SQUARE, NONE, attenuate, strength_at
from pvphong.optics.light import NODES, Light
from pvphong.optics.lights import DirectionalLight, EnvironmentLight, PointLight, SphereLight, SpotLight
from pvphong.optics.lights.point import Weakening
from pvphong.optics.lights.sized import Flat

POSITION, ATTENUATION, CONE, SIZE, SKY = "position", "attenuation", "cone", "size", "sky"
"""Effects that lights call for."""

# In radii of the vertices' sphere: nearer than this a light's direction is never taken for the same everywhere.
_FAR = 2
# Angles are known to this many radians: arc cosines lose half the digits near 0.
_SLACK = 1e-6
# What harmonics may have more than the image that they are of.
_OVERSHOOT = 2.0


class Reach(NamedTuple):
    """What of a light can reach the vertices inside a sphere; nothing is known by default, and it is never left out."""

    strongest: float = math.inf
    """No vertex gets more strength, rounded up; infinite where there is no bound."""

    direction: Vector | None = None
    """Unit vector to the light from the sphere's centre; None where it is not known."""

    turn: float = 0.0
    """The largest angle in radians by which the direction at a vertex may be off that one."""


class StandIn(NamedTuple):
    """Cheaper lights that may replace one, and how large the error is."""

    make: Callable[[], tuple[Light, ...]] | None
    """Gives them; only what arrives from them counts: colours and intensity stay. None: the one is dark here."""

    why: str = ""
    """The reason; `{bound}` in it is replaced by the error in a colour."""

    factor: float = 1.0
    """Their strength is multiplied by it."""

    spread: float = 0.0
    """The largest error of the strength."""

    turn: float | None = None
    """The largest error of the direction, in radians; None where it stays."""

    strongest: float = 1.0
    """Where the direction is off, no vertex gets more strength, of all parts of a light that has a size."""


# --- the questions


@singledispatch
def effects(light: Any) -> frozenset[str]:
    """The effects that a light calls for: its position's unless it is even, and its size's."""
    if light.is_even:
        return frozenset()
    return frozenset({POSITION, SIZE} if light.has_size else {POSITION})


@singledispatch
def reach(light: Any, extent: Extent) -> Reach:  # noqa: ARG001 nothing is known
    """What of a light can reach the vertices."""
    return Reach()


@singledispatch
def simpler(light: Any, effect: str, extent: Extent, *, exactly: bool) -> StandIn | None:  # noqa: ARG001 there is none
    """A cheaper light that could replace one for the vertices; None where there is none.

    Parameters
    ----------
    light : Light
        The light.
    effect : str
        One of its effects, which the other does not call for.
    extent : Extent
        Where the vertices are; finding that takes time, so it is asked only where it counts.
    exactly : bool
        Whether only a light will do that is the same to the last bit.
    """
    return None


@singledispatch
def without(light: Any, effect: str, point: Vector) -> tuple[Light, float]:  # noqa: ARG001 there is none
    """The light with one of its effects left out, whatever the error, and the factor of its strength.

    What varies is then taken as it is at a point. Only what arrives counts: colours and intensity stay.
    """
    return light, 1.0


def _parallel_at(light: Any, point: Vector) -> tuple[Light, float]:
    """A light taken as it is at a point: parallel light, and its strength."""
    arrival = light.arrival(np.array(point)[:, None])
    x, y, z = (-arrival.direction[:, 0]).tolist()
    if not (x or y or z):  # it is at that very point, where its light comes from nowhere
        return light, 1.0
    return DirectionalLight(direction=(x, y, z)), float(np.broadcast_to(arrival.strength, 1)[0])


# --- lights without a size


@reach.register
def _(light: DirectionalLight, extent: Extent) -> Reach:  # noqa: ARG001 the same everywhere
    """Strength 1 from one direction."""
    x, y, z = unit_vector(light.direction)
    return Reach(1.0, (-x, -y, -z), TURN_SLACK)


@effects.register
def _(light: Weakening) -> frozenset[str]:
    """Its position, and its attenuation if it weakens."""
    return frozenset({POSITION} if tuple(light.attenuation) == NONE else {POSITION, ATTENUATION})


@reach.register
def _(light: Weakening, extent: Extent) -> Reach:
    """The nearest vertex gets most; the direction turns as its position is seen."""
    seen = extent.sight(light.position)
    if seen is None:
        return Reach()
    return Reach(_strongest(seen, light.attenuation), seen.direction, seen.turn + TURN_SLACK)


def _strongest(seen: Sight, attenuation: VectorLike) -> float:
    """No vertex gets more from a position that is so seen."""
    return strength_at(max(seen.distance - seen.radius, 0.0) / ROUNDED_UP, attenuation) * ROUNDED_UP


def _evenly_strong(light: Any, extent: Extent, *, exactly: bool) -> StandIn | None:
    """A light that does not weaken."""
    constant, linear, quadratic = light.attenuation

    def even() -> tuple[Light]:
        return (replace(light, attenuation=NONE),)

    if not linear and not quadratic:
        return StandIn(even, f"constant, {1.0 / constant:g}", 1.0 / constant)
    seen = None if exactly else extent.sight(light.position)
    if seen is None or seen.distance <= seen.radius:
        return None
    radius, why = seen.radius * ROUNDED_UP, "even over the mesh to {bound:.2g}"
    near, far = (strength_at(seen.distance + offset, light.attenuation) for offset in (-radius, radius))
    return StandIn(even, why, (near + far) / 2, (near - far) / 2)


@simpler.register
def _(light: PointLight, effect: str, extent: Extent, *, exactly: bool) -> StandIn | None:
    """One that does not weaken; where it does not weaken itself, parallel light."""
    if effect == ATTENUATION:
        return _evenly_strong(light, extent, exactly=exactly)
    if effect != POSITION or exactly or tuple(light.attenuation) != NONE:
        return None
    seen = extent.sight(light.position)
    if seen is None or seen.distance < _FAR * seen.radius:
        return None
    x, y, z = seen.direction
    why = "far away: its direction is the same to {bound:.2g}"
    return StandIn(lambda: (DirectionalLight(direction=(-x, -y, -z)),), why, turn=seen.turn)


@without.register
def _(light: Weakening, effect: str, point: Vector) -> tuple[Light, float]:
    """Taken as it is at a point: its strength, or with it its direction too."""
    this: Any = light
    if effect == ATTENUATION:
        distance = np.array([math.dist(light.position, point)])
        return replace(this, attenuation=NONE), float(attenuate(distance, light.attenuation)[0])
    return _parallel_at(light, point) if effect == POSITION else (this, 1.0)


@effects.register
def _(light: SpotLight) -> frozenset[str]:
    """A point light's, and its cone."""
    return effects.dispatch(Weakening)(light) | {CONE}


@simpler.register
def _(light: SpotLight, effect: str, extent: Extent, *, exactly: bool) -> StandIn | None:
    """Off outside its cone, a point light inside it; or as one that does not weaken."""
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
        return StandIn(None, f"mesh lies outside the cone by {shown}°")
    if most >= edge - _SLACK or (exactly and light.exponent):
        return None
    found = StandIn(lambda: (_without_cone(light),), "mesh lies inside the cone")
    if light.exponent == 0.0:
        return found
    angles = max(least - _SLACK, 0.0), most + _SLACK
    brightest, darkest = (max(math.cos(off_axis), 0.0) ** light.exponent for off_axis in angles)
    why = f"{found.why}, whose light is even to {{bound:.2g}}"
    spread = _strongest(seen, light.attenuation) * (brightest - darkest) / 2
    return found._replace(why=why, factor=(brightest + darkest) / 2, spread=spread)


@without.register
def _(light: SpotLight, effect: str, point: Vector) -> tuple[Light, float]:
    """A point light, parallel light, or as strong everywhere as at a point."""
    return (_without_cone(light), 1.0) if effect == CONE else without.dispatch(Weakening)(light, effect, point)


def _without_cone(light: SpotLight) -> PointLight:
    return PointLight(position=light.position, attenuation=light.attenuation)


# --- lights with a size, whose parts weaken by 1/d²


@reach.register
def _(light: SphereLight, extent: Extent) -> Reach:
    """Its surface may be as near as that; it is seen as far off as its edge is."""
    return _reach_within(light.places[0], light.radius, extent)


@reach.register
def _(light: Flat, extent: Extent) -> Reach:
    """Its parts are within a sphere."""
    return _reach_within(light.center, light.reach_radius, extent)


def _reach_within(center: Vector, radius: float, extent: Extent) -> Reach:
    """Of a light within a sphere: the nearest part may be as near as the sphere."""
    seen = extent.sight(center)
    if seen is None:
        return Reach()
    nearest, wide = max(seen.distance - seen.radius - radius, 0.0) / ROUNDED_UP, seen.radius + radius
    turn = math.asin(wide / seen.distance) * ROUNDED_UP if wide < seen.distance else math.pi
    return Reach(strength_at(nearest, INVERSE_SQUARE) * ROUNDED_UP, seen.direction, turn)


@simpler.register
def _(light: SphereLight, effect: str, extent: Extent, *, exactly: bool) -> StandIn | None:
    """A point light in its middle.

    It is seen as a disk of one colour, s the sine of its angular radius, that sends 2 / (1 + √(1 − s²)) times 1/d².
    """
    if exactly or effect != SIZE:
        return None
    return _as_point(extent.sight(light.places[0]), light.radius, light.nodes(1)[0], lambda s: s * s / 2.0)


@simpler.register
def _(light: Flat, effect: str, extent: Extent, *, exactly: bool) -> StandIn | None:
    """A spot light in its middle; off where the mesh is behind it.

    At the height h over its plane, a part sends h/d³: with s the sine of its angular radius, a mean around its middle
    is off by half the largest second derivative, 12 h/d⁵, times the square of its radius at most: 6 s²/(1 − s)⁵ of
    1/d².
    """
    seen = extent.sight(light.center) if effect == SIZE else None
    if seen is None:
        return None
    radius = light.reach_radius
    height = -seen.distance * sum(a * b for a, b in zip(seen.direction, light.normal, strict=True))
    clear = seen.radius * ROUNDED_UP + 1e-9 * (seen.distance + radius)
    if height <= -clear and not light.two_sided:
        return StandIn(None, "mesh lies behind it")
    if exactly or (light.two_sided and abs(height) < clear):
        return None
    part = light.part(light.center, math.copysign(1.0, height) if light.two_sided else 1.0, 1.0)
    return _as_point(seen, radius, part, lambda s: 6.0 * s * s / (1.0 - s) ** 5)


def _as_point(seen: Sight | None, radius: float, light: Light, spread: Any) -> StandIn | None:
    """A light without a size in place of one within a sphere.

    Parameters
    ----------
    seen : Sight
        Of its middle.
    radius : float
        The sphere's.
    light : Light
        What replaces it, with the intensity 1.
    spread : callable
        From the sine of the sphere's angular radius to how far the sum of its parts' strengths may be off that of the
        middle, which is 1/d².
    """
    nearest = 0.0 if seen is None else (seen.distance - seen.radius) / ROUNDED_UP
    if nearest <= 2.0 * radius:
        return None
    sine, middle = radius / nearest, strength_at(nearest, INVERSE_SQUARE) * ROUNDED_UP
    why = "small: as a point it is the same to {bound:.2g}"
    off, turn = middle * spread(sine), math.asin(sine) * ROUNDED_UP
    return StandIn(lambda: (light,), why, spread=off, turn=turn, strongest=middle + off)


@without.register
def _(light: SphereLight, effect: str, point: Vector) -> tuple[Light, float]:
    """A point light in its middle, or parallel light."""
    return (light.nodes(1)[0], 1.0) if effect == SIZE else _parallel_at(light, point)


@without.register
def _(light: Flat, effect: str, point: Vector) -> tuple[Light, float]:
    """A spot light in its middle, or parallel light."""
    if effect != SIZE:
        return _parallel_at(light, point)
    height = sum(n * (p - c) for n, p, c in zip(light.normal, point, light.center, strict=True))
    return light.part(light.center, -1.0 if light.two_sided and height < 0.0 else 1.0, 1.0), 1.0


def merged_nodes(light: Light, count: int, extent: Extent) -> StandIn | None:
    """At most so many nodes that may replace the `NODES`; None where no bound is known.

    Nodes that are close together become one in their middle. At the distance d, 1/d² changes by at most 2/d³ on a path
    of length 1, and so does h/d³, the field of a dipole, with which a flat light weakens at the height h over its
    plane.

    Parameters
    ----------
    light : Light
        One whose nodes have the same intensity.
    count : int
        So many at most.
    extent : Extent
        Where the vertices are.
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
    return StandIn(lambda: tuple(found), spread=spread, turn=turn, strongest=strongest)


def _halved(places: Float64Array, count: int) -> Sequence[Float64Array]:
    """Groups of places, at most so many: halved across where they are longest, again and again."""
    if count < 2 or len(places) < 2:
        return [places]
    order = np.argsort(places[:, int(np.argmax(np.ptp(places, axis=0)))], kind="stable")
    return [part for half in np.array_split(places[order], 2) for part in _halved(half, count // 2)]


# --- light from all around


@effects.register
def _(light: EnvironmentLight) -> frozenset[str]:
    """Its bands."""
    return frozenset({SKY}) if light.bands > 1 else frozenset()


@reach.register
def _(light: EnvironmentLight, extent: Extent) -> Reach:  # noqa: ARG001 the same everywhere
    """It comes from everywhere; no lobe makes more of it than a factor of 1 does."""
    strongest = max(1.0, _OVERSHOOT * float(light.panorama.total.max())) * ROUNDED_UP
    return Reach(strongest, None, 0.0)
