"""Light from infinitely far away: one direction for the whole scene (OpenGL's w = 0)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, Vector, VectorLike
from pvphong.base.vectors import moderate_vector
from pvphong.optics.light import Arrival, EyeSpace, Light

if TYPE_CHECKING:
    import pyvista as pv


@dataclass(frozen=True)
class DirectionalLight(Light):
    """Parallel light, as from the sun.

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
    """

    direction: VectorLike = (0.0, 0.0, -1.0)

    def _check_geometry(self) -> None:
        self._set("direction", check.direction("direction", self.direction))

    def in_world(self, viewer: EyeSpace) -> DirectionalLight:
        """This light with its direction in the world, as `viewer` makes it."""
        if self.frame == "camera":
            x, y, z = self.direction
            return replace(self, direction=viewer.vector_to_world((x, y, z)), frame="world")
        if self.frame == "headlight":
            return replace(self, direction=viewer.view_direction, frame="world")
        return self

    def arrival(self, points: Float64Array, real: Any = np.float64) -> Arrival:  # noqa: ARG002 the same everywhere
        """The direction against the light's travel, shape (3, 1), and strength 1."""
        way, inverse_length = self.way
        return Arrival(np.array(way, dtype=real)[:, None], 1.0, inverse_length)

    @cached_property
    def way(self) -> tuple[Vector, float]:
        """To the light, in its own frame: the direction given, but for a power of two and the sign; and 1/length."""
        (x, y, z), inverse_length = moderate_vector(self.direction)
        return (-x, -y, -z), inverse_length

    @cached_property
    def to_light(self) -> Vector:
        """Unit vector to the light, in its own frame."""
        (x, y, z), inverse_length = self.way
        return x * inverse_length, y * inverse_length, z * inverse_length

    def _place(self, light: pv.Light, distance: float) -> None:  # noqa: ARG002 infinitely far away
        x, y, z = self.direction
        light.SetPositional(False)
        light.SetPosition(-x, -y, -z)
        light.SetFocalPoint(0.0, 0.0, 0.0)
