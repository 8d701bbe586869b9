"""What lights with a size have in common: how they are seen from far away, and flat ones altogether.

A flat light glows like a Lambertian surface: a part dA of its area A sends the intensity I dA/A · cos θ', θ' the angle
off its normal, which is a spot light's with a cone of 90° and the exponent 1, weakened by 1/d².
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from pvphong.base.formulas import times
from pvphong.base.types import Float64Array, Vector
from pvphong.base.vectors import directions_to, dot, unit_vector
from pvphong.geometry.extent import ROUNDED_UP, Extent, Sight
from pvphong.optics.area.lobes import CosinePower
from pvphong.optics.area.polygon import polygon_highlight, polygon_irradiance
from pvphong.optics.area.sampling import Sampling, flat_frame
from pvphong.optics.attenuation import INVERSE_SQUARE, attenuate, strength_at
from pvphong.optics.light import (
    NODES,
    SIZE_EFFECT,
    Arrival,
    Integral,
    Light,
    Reach,
    StandIn,
)
from pvphong.optics.lights.point import parallel_at
from pvphong.optics.lights.spot import SpotLight
from pvphong.optics.roles import MESH_UNIT

# VTK has no cone of 90°.
_NEARLY_90 = 89.999


def reach_within(center: Vector, radius: float, extent: Extent) -> Reach:
    """The reach of a light within a sphere, whose parts weaken by 1/d²: the nearest may be as near as the sphere."""
    seen = extent.sight(center)
    if seen is None:
        return Reach()
    nearest, wide = max(seen.distance - seen.radius - radius, 0.0) / ROUNDED_UP, seen.radius + radius
    turn = math.asin(wide / seen.distance) * ROUNDED_UP if wide < seen.distance else math.pi
    return Reach(strength_at(nearest, INVERSE_SQUARE) * ROUNDED_UP, seen.direction, turn)


def as_point(seen: Sight | None, radius: float, light: Light, spread: Any) -> StandIn | None:
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


def _halved(places: Float64Array, count: int) -> list[Float64Array]:
    """Groups of places, at most so many: halved across where they are longest, again and again."""
    if count < 2 or len(places) < 2:
        return [places]
    order = np.argsort(places[:, int(np.argmax(np.ptp(places, axis=0)))], kind="stable")
    return [part for half in np.array_split(places[order], 2) for part in _halved(half, count // 2)]


def over_polygon(
    form: CosinePower, center: Vector, normal: Vector, two_sided: bool, area: float, offsets: Float64Array
) -> Integral:
    """The integral over a polygon whose corners have these offsets, shape (k, 3), from its middle."""
    size = float(np.linalg.norm(offsets, axis=1).max())
    numbers = (*normal, float(two_sided), math.sqrt(area), size, float(len(offsets)), *offsets.ravel().tolist())
    return Integral(polygon_irradiance if form.around == "normal" else polygon_highlight, center, size, numbers)


class Flat:
    """A light with a front, and perhaps a back, that glow like Lambertian surfaces. For kinds of `Light`."""

    position: Any
    direction: Any
    two_sided: Any
    outline: Any
    area: Any

    intensity_unit: ClassVar[str] = f"{MESH_UNIT}²"

    @cached_property
    def center(self) -> Vector:
        """The middle of its area: its position, where it has one."""
        x, y, z = self.position
        return x, y, z

    @cached_property
    def normal(self) -> Vector:
        """Unit vector off its front: its direction, where it has one."""
        return unit_vector(self.direction)

    @cached_property
    def reach_radius(self) -> float:
        """The radius of a sphere around its middle that holds it."""
        return float(np.linalg.norm(self.outline - np.array(self.center), axis=1).max()) * ROUNDED_UP

    def spots(self, count: int) -> Float64Array:
        """Points evenly spread over it, shape (count, 3); one is its middle."""
        raise NotImplementedError  # pragma: no cover every kind has its own

    def nodes(self, count: int) -> tuple[SpotLight, ...]:
        """Spot lights of 90° with the exponent 1, evenly spread; on two sides, pairs of them."""
        sides = 2 if self.two_sided else 1
        places = self.spots(max(count // sides, 1))
        return tuple(
            _part(place, sign, self.normal, 1.0 / len(places))
            for place in places.tolist()
            for sign in (1.0, -1.0)[:sides]
        )

    def sampled(
        self, sample: Callable[..., Any], seen: Callable[..., Any], sides: Float64Array, corner: float
    ) -> Sampling:
        """How points on it are chosen, of two half sides as rows; `corner` as `flat_frame` has it."""
        numbers = *self.center, *self.normal, *sides.ravel().tolist(), float(self.two_sided), corner
        return Sampling(flat_frame, sample, seen, numbers)

    def radiance(self, directions: Float64Array) -> Float64Array:  # noqa: ARG002 the same from everywhere
        """The number π over its area."""
        return np.full((3, 1), math.pi / self.area)

    def arrival(self, points: Float64Array, real: Any = np.float64) -> Arrival:
        """What its middle sends."""
        x, y, z = self.center
        to_light, inverse, distance = directions_to((x, y, z), points, real)
        cosine = -dot(np.array(self.normal, real)[:, None], to_light) * inverse
        shown = np.abs(cosine) if self.two_sided else np.maximum(cosine, real(0.0))
        return Arrival(to_light, attenuate(distance, INVERSE_SQUARE) * shown, inverse)

    @property
    def nearest_in_vtk(self) -> SpotLight:
        """A spot light in its middle, with a cone that VTK has."""
        return SpotLight(self.center, self.normal, _NEARLY_90, 1.0, INVERSE_SQUARE)

    def reach(self, extent: Extent) -> Reach:
        """Its parts are within a sphere."""
        return reach_within(self.center, self.reach_radius, extent)

    def simpler(self, effect: str, extent: Extent, *, exactly: bool) -> StandIn | None:
        """A spot light in its middle; off where the mesh is behind it.

        At the height h over its plane, a part sends h/d³: with s the sine of its angular radius, a mean around its
        middle is off by half the largest second derivative, 12 h/d⁵, times the square of its radius at most: 6 s²/(1 −
        s)⁵ of 1/d².
        """
        seen = extent.sight(self.center) if effect == SIZE_EFFECT else None
        if seen is None:
            return None
        height = -seen.distance * sum(a * b for a, b in zip(seen.direction, self.normal, strict=True))
        clear = seen.radius * ROUNDED_UP + 1e-9 * (seen.distance + self.reach_radius)
        if height <= -clear and not self.two_sided:
            return StandIn(None, "mesh lies behind it")
        if exactly or (self.two_sided and abs(height) < clear):
            return None
        part = _part(self.center, math.copysign(1.0, height) if self.two_sided else 1.0, self.normal, 1.0)
        return as_point(seen, self.reach_radius, part, lambda s: 6.0 * s * s / (1.0 - s) ** 5)

    def without(self, effect: str, point: Vector) -> tuple[Light, float]:
        """A spot light in its middle, or parallel light."""
        if effect == SIZE_EFFECT:
            height = sum(n * (p - c) for n, p, c in zip(self.normal, point, self.center, strict=True))
            return _part(self.center, -1.0 if self.two_sided and height < 0.0 else 1.0, self.normal, 1.0), 1.0
        this: Any = self
        return parallel_at(this, point)


def _part(place: Sequence[float], sign: float, normal: Vector, intensity: float) -> SpotLight:
    x, y, z = place
    return SpotLight((x, y, z), times(normal, sign), 90.0, 1.0, INVERSE_SQUARE, intensity=intensity)


def across(normal: Vector | Float64Array) -> Float64Array:
    """Two unit vectors at right angles to a normal and to each other, as rows: counter-clockwise around it."""
    first = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)])


def lattice(count: int) -> Float64Array:
    """Points evenly spread over the unit square, shape (count, 2); one is its middle."""
    k = np.arange(count)
    return np.stack([(k + 0.5) / count, (0.5 + k * (math.sqrt(5.0) - 1.0) / 2.0) % 1.0], axis=1)
