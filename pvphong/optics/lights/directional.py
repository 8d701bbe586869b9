"""Light from infinitely far away: one direction for the whole scene (OpenGL's w = 0)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any, ClassVar, Self

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, Vector, VectorLike
from pvphong.base.vectors import moderate_vector, unit_vector
from pvphong.optics.area.disk import patch_highlight, patch_irradiance
from pvphong.optics.area.lobes import CosinePower
from pvphong.optics.area.sampling import Sampling, patch_frame, sphere_sample, sphere_seen
from pvphong.optics.light import NODES, Arrival, Integral, Light
from pvphong.optics.lights.sized import across
from pvphong.optics.roles import Width, aim, direction_from, meaning

# Largest apparent diameter, in degrees.
_WIDEST = 90.0
# Nodes by the square of the light's angular radius and the sharpness of a highlight, for an error of 0.1 % of its peak;
# and their least number.
_NODES_IN_LOBES, _LEAST_NODES = 250.0, 8


def _sine_and_cosine(degrees: float) -> tuple[float, float]:
    """Return the sine and cosine of an angle, exact for multiples of 90°."""
    turns, rest = divmod(degrees, 90.0)
    sine, cosine = math.sin(math.radians(rest)), math.cos(math.radians(rest))
    return ((sine, cosine), (cosine, -sine), (-sine, -cosine), (-cosine, sine))[int(turns) % 4]


@dataclass(frozen=True)
class DirectionalLight(Light):
    """Directional light: parallel rays, or with an `angle` light from a round patch of the sky, as from the sun.

    `diffuse` · `intensity` is the irradiance of a surface that faces the light, whatever the angle: light of a larger
    angle comes from a larger patch with a lower radiance. With an angle, shadows and highlights are soft. Diffuse
    reflection and Phong's highlight are exact; for other reflectances, 8 to 64 parallel lights approximate the patch.

    Parameters
    ----------
    direction : sequence of float, default (0, 0, -1)
        The direction in which the light travels, of any length. OpenGL's default light shines along −z.
    angle : float, default 0
        Apparent diameter in degrees, 0 <= angle <= 90. The sun's is 0.533; it varies by 1.7 % over the year. 0 is light
        without a size.
    **common
        The fields of every light: `diffuse`, `specular`, `ambient`, `intensity`, `on`, `frame`, `name`.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> sun = ph.DirectionalLight(direction=(1, -1, -2), diffuse="#fff0d0")
    >>> lit = pv.Sphere().phong.shade(sun)
    >>> real_sun = ph.DirectionalLight(direction=(1, -1, -2), angle=0.533)
    """

    direction: VectorLike = aim()
    angle: float = meaning(
        Width(
            partial(check.number, at_least=0.0, at_most=_WIDEST, remedy="A wider light is an EnvironmentLight."),
            "width",
        ),
        0.0,
    )

    is_uniform: ClassVar[bool] = True

    @classmethod
    def at(cls, position: VectorLike, *, target: VectorLike, **fields: Any) -> Self:
        """Make a light that shines from the direction of `position`, as seen from `target`.

        Parameters
        ----------
        position, target : sequence of float
            Two different points.
        **fields
            The other fields of the light.

        Raises
        ------
        ValueError
            If a field is out of range, or the points are the same.
        """
        return cls(direction=direction_from(position, target), **fields)

    @classmethod
    def from_angles(cls, azimuth: float, elevation: float, **fields: Any) -> Self:
        """Make sunlight, given the sun's compass direction and its height above the horizon.

        North is +y, east +x, and up +z, as in maps and terrains.

        Parameters
        ----------
        azimuth : float
            Direction of the sun, in degrees clockwise from north: 90 is in the east, 315 in the north-west.
        elevation : float
            Angle of the sun above the horizon in degrees, from -90 to 90.
        **fields
            The other fields of the light.

        Raises
        ------
        ValueError
            If a field or an angle is out of range, or an angle is not a number.

        Examples
        --------
        >>> import pvphong as ph
        >>> ph.DirectionalLight.from_angles(90, 0).direction  # from the east, towards the west
        (-1.0, 0.0, 0.0)
        """
        azimuth = check.number("azimuth", azimuth)
        elevation = check.number("elevation", elevation, at_least=-90.0, at_most=90.0)
        east, north = _sine_and_cosine(azimuth)
        up, across = _sine_and_cosine(elevation)
        return cls(direction=(0.0 - east * across, 0.0 - north * across, 0.0 - up), **fields)

    def arrival(self, points: Float64Array, real: Any = np.float64) -> Arrival:  # noqa: ARG002 the same everywhere
        """Return the light that arrives at `points`, shape (3, n): one direction, and the strength 1, for all of them.

        The direction to the light is the reversed `direction` of the light, in the float type `real`.
        """
        direction, inverse_length = moderate_vector(self.direction)
        return Arrival(-np.array(direction, dtype=real)[:, None], 1.0, inverse_length)

    # -- with an apparent size

    @property
    def has_size(self) -> bool:
        """True if the angle is larger than 0."""
        return self.angle > 0.0

    @property
    def angular_radius(self) -> float:
        """Half the angle, in radians."""
        return math.radians(0.5 * self.angle)

    def nodes(self, count: int) -> tuple[DirectionalLight, ...]:
        """Return `count` parallel lights, evenly spread over the round patch; a single light is at the patch's middle.

        A single light has the intensity 1. The total intensity of several is 2 / (1 + cos α), with α the angular
        radius. This is 1 divided by their mean cosine with the middle. So a surface that faces the light gets its full
        irradiance. A light without a size returns only itself.
        """
        if not self.has_size:
            return (self,)
        x, y, z = self.direction
        return _nodes((x, y, z), self.angular_radius, count)

    def nodes_for(self, sharpness: float) -> int:
        """Return the number of parallel lights for a reflectance of this sharpness, a power of two.

        The lights are then close together compared with the width of the highlight.
        """
        several = 2 ** math.ceil(math.log2(max(_NODES_IN_LOBES * sharpness * self.angular_radius**2, 1.0)))
        return min(max(several, _LEAST_NODES), NODES)

    def analytic_integral(self, form: CosinePower) -> Integral:
        """Return the exact integral over the visible part of the patch, weighted by `form`, a power of a cosine."""
        formula = patch_irradiance if form.around == "normal" else patch_highlight
        return Integral(formula, (0.0, 0.0, 0.0), math.inf, (math.sin(self.angular_radius), *self._to_light))

    @property
    def sampling(self) -> Sampling | None:
        """Uniform sampling of the patch; None for a light without a size."""
        if not self.has_size:
            return None
        numbers = *self._to_light, math.sin(self.angular_radius), math.inf
        return Sampling(patch_frame, sphere_sample, sphere_seen, numbers)

    def radiance(self, directions: Float64Array) -> Float64Array:  # noqa: ARG002 the same from everywhere
        """Return the radiance at intensity 1, shape (3, 1): 1 / sin² α, with α the angular radius.

        The radiance is constant, so `directions` is not read.
        """
        return np.full((3, 1), 1.0 / math.sin(self.angular_radius) ** 2)

    @property
    def _to_light(self) -> Vector:
        x, y, z = unit_vector(self.direction)
        return -x, -y, -z


@lru_cache(maxsize=32)
def _nodes(direction: Vector, radius: float, count: int) -> tuple[DirectionalLight, ...]:
    if count == 1:
        return (DirectionalLight(direction),)
    k = np.arange(count)
    less = 2.0 * math.sin(0.5 * radius) ** 2 * (k + 0.5) / count  # 1 − cos of the angles off the middle
    aside, around = np.sqrt(less * (2.0 - less)), k * math.pi * (3.0 - math.sqrt(5.0))  # golden angles (Vogel 1979)
    axis = np.array(unit_vector(direction))
    ways = (aside * np.stack([np.cos(around), np.sin(around)])).T @ across(axis) + (1.0 - less)[:, None] * axis
    intensity = 2.0 / (1.0 + math.cos(radius)) / count
    return tuple(DirectionalLight(way, intensity=intensity) for way in ways.tolist())
