"""Base of flat area lights, and helpers for area lights.

A flat light of intensity I emits like a Lambertian surface. An element dA of its area A has the intensity
I dA/A · cos θ', where θ' is the angle off its normal. So it acts as a spot light with a cone of 90°, the exponent 1 and
1/d² falloff.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from pvphong.base.formulas import times
from pvphong.base.types import Float64Array, Vector
from pvphong.base.vectors import directions_to, dot, unit_vector
from pvphong.geometry.extent import ROUNDED_UP
from pvphong.optics.area.lobes import CosinePower
from pvphong.optics.area.polygon import polygon_highlight, polygon_irradiance
from pvphong.optics.area.sampling import Sampling, flat_frame
from pvphong.optics.attenuation import INVERSE_SQUARE, attenuate
from pvphong.optics.light import Arrival, Integral
from pvphong.optics.lights.spot import SpotLight
from pvphong.optics.roles import MESH_UNIT


def over_polygon(
    form: CosinePower, center: Vector, normal: Vector, two_sided: bool, area: float, offsets: Float64Array
) -> Integral:
    """Return the exact integral over the visible part of a polygon, weighted by a power of a cosine.

    Parameters
    ----------
    form : CosinePower
        The power of the cosine: the factor of a part of a surface's reflectance.
    center, normal : tuple of float
        Centre of the polygon, and unit normal of its front.
    two_sided : bool
        True if the back emits too.
    area : float
        Area of the polygon.
    offsets : ndarray
        Corners relative to the centre, shape (k, 3).
    """
    size = float(np.linalg.norm(offsets, axis=1).max())
    numbers = (*normal, float(two_sided), math.sqrt(area), size, float(len(offsets)), *offsets.ravel().tolist())
    return Integral(polygon_irradiance if form.around == "normal" else polygon_highlight, center, size, numbers)


class Flat:
    """Mixin for flat lights whose front, and optionally also their back, emits like a Lambertian surface."""

    position: Any
    direction: Any
    two_sided: Any
    outline: Any
    area: Any

    intensity_unit: ClassVar[str] = f"{MESH_UNIT}²"

    @cached_property
    def center(self) -> Vector:
        """Centroid of the light's area; by default its position."""
        x, y, z = self.position
        return x, y, z

    @cached_property
    def normal(self) -> Vector:
        """Unit normal of its front; by default its direction."""
        return unit_vector(self.direction)

    @cached_property
    def reach_radius(self) -> float:
        """Radius of a sphere around the light's centre that encloses the light."""
        return float(np.linalg.norm(self.outline - np.array(self.center), axis=1).max()) * ROUNDED_UP

    def spots(self, count: int) -> Float64Array:
        """Return points evenly spread over the light, shape (count, 3); a single point is the light's centre."""
        raise NotImplementedError  # pragma: no cover every kind has its own

    def nodes(self, count: int) -> tuple[SpotLight, ...]:
        """Return at most `count` spot lights, evenly spread, with cones of 90° and the exponent 1.

        A two-sided light has spot lights on both sides, at least one on each.
        """
        sides = 2 if self.two_sided else 1
        places = self.spots(max(count // sides, 1))
        return tuple(
            self.part(place, sign, 1.0 / len(places)) for place in places.tolist() for sign in (1.0, -1.0)[:sides]
        )

    def part(self, place: Sequence[float], sign: float, intensity: float) -> SpotLight:
        """Return a spot light at `place` with this intensity, an inverse-square falloff, and a cone of 90°.

        It shines to the front if `sign` is 1, and to the back if `sign` is −1.
        """
        x, y, z = place
        return SpotLight((x, y, z), times(self.normal, sign), 90.0, 1.0, INVERSE_SQUARE, intensity=intensity)

    def sampled(
        self, sample: Callable[..., Any], seen: Callable[..., Any], sides: Float64Array, corner: float
    ) -> Sampling:
        """Return the importance sampling of the light's points.

        Parameters
        ----------
        sample, seen : callable
            The formulas `sample` and `seen` of this kind of light; `pvphong.optics.area.sampling` describes both.
        sides : ndarray
            Two half sides of the light as rows, shape (2, 3).
        corner : float
            Fraction of the half sides at which `flat_frame` places its corners: 1 for a rectangle, √½ for a disk.
        """
        numbers = *self.center, *self.normal, *sides.ravel().tolist(), float(self.two_sided), corner
        return Sampling(flat_frame, sample, seen, numbers)

    def radiance(self, directions: Float64Array) -> Float64Array:  # noqa: ARG002 the same from everywhere
        """Return π over the light's area: the radiance at intensity 1, which is the same in all directions."""
        return np.full((3, 1), math.pi / self.area)

    def arrival(self, points: Float64Array, real: Any = np.float64) -> Arrival:
        """Return the light that arrives at `points`, shape (3, n), as if all light came from the centre.

        The vectors of the result have the float type `real`.
        """
        x, y, z = self.center
        to_light, inverse, distance = directions_to((x, y, z), points, real)
        cosine = -dot(np.array(self.normal, real)[:, None], to_light) * inverse
        shown = np.abs(cosine) if self.two_sided else np.maximum(cosine, real(0.0))
        return Arrival(to_light, attenuate(distance, INVERSE_SQUARE) * shown, inverse)


def across(normal: Vector | Float64Array) -> Float64Array:
    """Return two unit vectors that are orthogonal to a normal and to each other, as rows, shape (2, 3).

    From the first to the second is a counter-clockwise quarter turn around the normal.
    """
    first = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)])


def lattice(count: int) -> Float64Array:
    """Return points evenly spread over the unit square, shape (count, 2); a single point is the square's centre."""
    k = np.arange(count)
    return np.stack([(k + 0.5) / count, (0.5 + k * (math.sqrt(5.0) - 1.0) / 2.0) % 1.0], axis=1)
