"""What lights with a size have in common: how they are seen from far away, and flat ones altogether.

A flat light glows like a Lambertian surface: a part dA of its area A sends the intensity I dA/A · cos θ', θ' the angle
off its normal, which is a spot light's with a cone of 90° and the exponent 1, weakened by 1/d².
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pvphong.base.types import Float64Array, Vector
from pvphong.base.vectors import directions_to, dot
from pvphong.geometry.extent import ROUNDED_UP, Extent, Sight
from pvphong.optics.attenuation import INVERSE_SQUARE, attenuate, strength_at
from pvphong.optics.light import (
    NODES,
    POSITION_EFFECT,
    SIZE_EFFECT,
    Arrival,
    Integral,
    Light,
    Reach,
    Stage,
    StandIn,
)
from pvphong.optics.lights.point import parallel_at
from pvphong.optics.lights.spot import SpotLight
from pvphong.optics.spherical import CosinePower

EFFECTS = frozenset({POSITION_EFFECT, SIZE_EFFECT})

# VTK has no cone of 90°.
_NEARLY_90 = 89.999

# For compiled code: what it takes for nothing, powers that it leaves to the readable evaluator, and what is small
# against a lobe's width.
_NOTHING, _LOW, _FRACTION = 1e-7, 4.0, 0.3
LEAST_SIZE = 1e-6
"""For the squares of sizes between this and one over it has compiled code room."""


def in_float32(forms: Sequence[CosinePower | None]) -> tuple[float, float, float]:
    """For compiled code: the highlight's power n, the 1 − z from which zⁿ⁺¹ is nothing, what is small against it."""
    power = next((form.power for form in forms if form is not None and form.around == "mirror"), _LOW)
    return power, -math.expm1(math.log(_NOTHING) / (power + 1.0)), _FRACTION / math.sqrt(power + 1.0)


def is_rough(forms: Sequence[CosinePower | None]) -> bool:
    """Whether a highlight is too rough on its equator for compiled code."""
    return any(form is not None and form.around == "mirror" and form.power < _LOW for form in forms)


def rows_of(toolkit: Any, forms: Sequence[CosinePower | None]) -> tuple[int, int]:
    """In which rows compiled code wants Lambert's cosine, and the highlight's power; −1: it is not wanted."""
    rows = {form.around: row for form, row in zip(forms, toolkit.LOBES, strict=False) if form is not None}
    return rows.get("normal", -1), rows.get("mirror", -1)


def reach_within(center: Vector, radius: float, extent: Extent) -> Reach:
    """Of a light within a sphere, whose parts weaken by 1/d²: the nearest may be as near as the sphere."""
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
        What stands in, with the intensity 1.
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
    return StandIn((light,), why, spread=off, turn=turn, strongest=middle + off)


def fewer_nodes(light: Light, count: int, extent: Extent) -> StandIn | None:
    """At most so many nodes that may stand in for `NODES`; None where no bound is known.

    Nodes that stand together are one in their middle. At the distance d, 1/d² changes by at most 2/d³ along a way of
    length 1, and so does h/d³, the field of a dipole, with which a flat light weakens at the height h over its plane.

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
    return StandIn(tuple(found), spread=spread, turn=turn, strongest=strongest)


def _halved(places: Float64Array, count: int) -> list[Float64Array]:
    """Groups of places, at most so many: halved across where they are longest, again and again."""
    if count < 2 or len(places) < 2:
        return [places]
    order = np.argsort(places[:, int(np.argmax(np.ptp(places, axis=0)))], kind="stable")
    return [part for half in np.array_split(places[order], 2) for part in _halved(half, count // 2)]


class Flat:
    """A light with a front, and perhaps a back, that glow like Lambertian surfaces. For kinds of `Light`."""

    two_sided: Any

    @property
    def center(self) -> Vector:
        """The middle of its area."""
        raise NotImplementedError  # pragma: no cover every kind has its own

    @property
    def normal(self) -> Vector:
        """Unit vector off its front."""
        raise NotImplementedError  # pragma: no cover

    @property
    def reach_radius(self) -> float:
        """Of a sphere around its middle that holds it."""
        raise NotImplementedError  # pragma: no cover

    def spots(self, count: int) -> Float64Array:
        """Points evenly spread over it, shape (count, 3); one is its middle."""
        raise NotImplementedError  # pragma: no cover

    def over(self, form: CosinePower, axis: Any, n: Any, middle: Any, exponents: Any) -> Any:
        """1/area · ∫ max(a·u, 0)ᵏ du, seen from either side; lengths are over powers of two."""
        raise NotImplementedError  # pragma: no cover

    def nodes(self, count: int) -> tuple[SpotLight, ...]:
        """Spot lights of 90° with the exponent 1, evenly spread; on two sides, pairs of them."""
        sides = 2 if self.two_sided else 1
        places = self.spots(max(count // sides, 1))
        return tuple(
            _part(place, sign, self.normal, 1.0 / len(places))
            for place in places.tolist()
            for sign in (1.0, -1.0)[:sides]
        )

    def arrival(self, points: Float64Array, real: Any = np.float64) -> Arrival:
        """What its middle sends."""
        x, y, z = self.center
        ways, inverse, distance = directions_to((x, y, z), points, real)
        cosine = -dot(np.array(self.normal, real)[:, None], ways) * inverse
        shown = np.abs(cosine) if self.two_sided else np.maximum(cosine, real(0.0))
        return Arrival(ways, attenuate(distance, INVERSE_SQUARE) * shown, inverse)

    def closed(self, form: CosinePower) -> Integral:
        """Over what is seen of it above the horizon."""

        def integral(points: Float64Array, surface: Any) -> Float64Array:
            result = np.zeros(points.shape[1])
            with np.errstate(all="ignore"):
                ways = np.array(self.center)[:, None] - points
                exponents = np.frexp(np.maximum(np.abs(ways).max(axis=0), self.reach_radius))[1]
                middle = np.ldexp(ways, -exponents)
                behind = dot(np.array(self.normal)[:, None], middle)
                is_lit = ((behind < 0.0) | (self.two_sided and behind > 0.0)) & np.isfinite(ways).all(axis=0)
                (rows,) = np.nonzero(is_lit)
                n, axis = surface.exact_normals[:, rows], surface.exact_normals[:, rows]
                if form.around == "mirror":
                    axis = surface.mirrored[:, rows]
                seen = self.over(form, axis, n, middle[:, rows], exponents[rows])
                result[rows] = np.minimum(np.ldexp(seen, -2 * exponents[rows]), np.finfo(np.float64).max)
            return result

        return integral

    def cubature(self) -> tuple[Float64Array, Float64Array] | None:
        """Offsets from its middle to its corners and then to nodes of the fifth degree, (k, 3), and the nodes' weights.

        None if it has no corners.
        """
        return None

    def closed_parameters(self, forms: Sequence[CosinePower | None]) -> tuple[float, ...]:
        """Its middle, coefficients of 1/d², a power with where it shows and what is small against it; its shape.

        The shape is what `pvphong.shading.kernel.sides` has of it.
        """
        parts = self.cubature()
        if parts is None:
            return ()
        offsets, weights = parts
        shape = (*self.normal, float(self.two_sided), 1.0 / self.area, self.reach_radius)
        counts = len(offsets) - len(weights), len(weights)
        numbers = (*shape, *counts, *offsets.ravel().tolist(), *weights.tolist())
        return (*self.center, *INVERSE_SQUARE, *in_float32(forms), *numbers)

    def closed_stage(self, toolkit: Any, forms: Sequence[CosinePower | None]) -> Stage | None:
        """Along its sides, where it has some. Low powers, which are rough, are left to the readable evaluator."""
        is_measurable = self.cubature() is not None and LEAST_SIZE < self.reach_radius < 1.0 / LEAST_SIZE
        if not is_measurable or is_rough(forms):
            return None
        return Stage(_sides(toolkit, *rows_of(toolkit, forms)), divisors=slice(3, 6), most_gain=math.inf)

    @property
    def area(self) -> float:
        """Its own."""
        raise NotImplementedError  # pragma: no cover

    @property
    def effects(self) -> frozenset[str]:
        """Its position, and its size."""
        return EFFECTS

    @property
    def stand_in(self) -> SpotLight:
        """A spot light in its middle, with a cone that VTK has."""
        return SpotLight(self.center, _times(self.normal, 1.0), _NEARLY_90, 1.0, INVERSE_SQUARE)

    def reach(self, extent: Extent) -> Reach:
        """Its parts are within a sphere."""
        return reach_within(self.center, self.reach_radius, extent)

    def simpler(self, effect: str, extent: Extent, *, exactly: bool) -> StandIn | None:
        """As a spot light in its middle; off where the mesh is behind it.

        H over its plane, a part sends h/d³: with s the sine of its angular radius, a mean around its middle is off by
        half the largest second derivative, 12 h/d⁵, times the square of its radius at most: 6 s²/(1 − s)⁵ of 1/d².
        """
        seen = extent.sight(self.center) if effect == SIZE_EFFECT else None
        if seen is None:
            return None
        height = -seen.distance * sum(a * b for a, b in zip(seen.direction, self.normal, strict=True))
        clear = seen.radius * ROUNDED_UP + 1e-9 * (seen.distance + self.reach_radius)
        if height <= -clear and not self.two_sided:
            return StandIn((), "mesh lies behind it")
        if exactly or (self.two_sided and abs(height) < clear):
            return None
        part = _part(self.center, math.copysign(1.0, height) if self.two_sided else 1.0, self.normal, 1.0)
        return as_point(seen, self.reach_radius, part, lambda s: 6.0 * s * s / (1.0 - s) ** 5)

    def without(self, effect: str, point: Vector) -> tuple[Light, float]:
        """As a spot light in its middle, or as parallel light."""
        if effect == SIZE_EFFECT:
            height = sum(n * (p - c) for n, p, c in zip(self.normal, point, self.center, strict=True))
            return _part(self.center, -1.0 if self.two_sided and height < 0.0 else 1.0, self.normal, 1.0), 1.0
        this: Any = self
        return parallel_at(this, point)


def _sides(toolkit: Any, cosine: int, power: int) -> Any:
    """Writes the factors of Lambert's cosine and of the power into two rows; −1 for one that is not wanted."""

    def polygon(numbers: Any, rows: Any, points: Any) -> bool:
        good = toolkit.approach_measured(rows, points, numbers[0], numbers[1], numbers[2])
        shape = toolkit.shifted(numbers, 9)
        good = toolkit.see_polygon(rows, shape) & good
        if cosine >= 0:
            good = toolkit.polygon_cosine(rows, shape, cosine) & good
        if power >= 0:
            good = toolkit.polygon_power(rows, shape, power, numbers[6], numbers[7], numbers[8]) & good
        toolkit.attenuate(rows, numbers[3], numbers[4], numbers[5])
        return good

    return polygon


def _part(place: Sequence[float], sign: float, normal: Vector, intensity: float) -> SpotLight:
    x, y, z = place
    return SpotLight((x, y, z), _times(normal, sign), 90.0, 1.0, INVERSE_SQUARE, intensity=intensity)


def _times(vector: Vector, factor: float) -> Vector:
    x, y, z = vector
    return factor * x, factor * y, factor * z


def lattice(count: int) -> Float64Array:
    """Points evenly spread over the unit square, shape (count, 2); one is its middle."""
    k = np.arange(count)
    return np.stack([(k + 0.5) / count, (0.5 + k * (math.sqrt(5.0) - 1.0) / 2.0) % 1.0], axis=1)
