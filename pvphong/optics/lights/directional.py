"""Light from infinitely far away: one direction for the whole scene (OpenGL's w = 0)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, VectorLike
from pvphong.base.vectors import moderate_vector
from pvphong.optics.light import Arrival, Light
from pvphong.optics.roles import aim, direction_from


def _sine_and_cosine(degrees: float) -> tuple[float, float]:
    """Return the sine and cosine of an angle, exact for multiples of 90°."""
    turns, rest = divmod(degrees, 90.0)
    sine, cosine = math.sin(math.radians(rest)), math.cos(math.radians(rest))
    return ((sine, cosine), (cosine, -sine), (-sine, -cosine), (-cosine, sine))[int(turns) % 4]


@dataclass(frozen=True)
class DirectionalLight(Light):
    """Directional light: parallel rays, as from the sun.

    Parameters
    ----------
    direction : sequence of float, default (0, 0, -1)
        The direction in which the light travels, of any length. OpenGL's default light shines along −z.
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
    """

    direction: VectorLike = aim()

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
