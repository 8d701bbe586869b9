"""Light from one point, weaker with distance (OpenGL's w ≠ 0)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, Vector, VectorLike
from pvphong.base.vectors import ways_to
from pvphong.optics.light import Arrival, EyeSpace, Light, place_for_vtk

if TYPE_CHECKING:
    import pyvista as pv


def check_attenuation(value: VectorLike) -> Vector:
    """Constant, linear and quadratic coefficient: all >= 0 and not all zero."""
    constant, linear, quadratic = check.numbers_in("attenuation", value, 3)
    if min(constant, linear, quadratic) < 0.0 or not (constant or linear or quadratic):
        check.refuse(
            "attenuation",
            value,
            "three numbers >= 0 (constant, linear, quadratic) that are not all zero",
            "(1, 0, 0) is a light that does not weaken with distance.",
        )
    return constant, linear, quadratic


def attenuate(distance: Float64Array, attenuation: VectorLike) -> Float64Array:
    """1 / (c + l·d + q·d²) at distances d (OpenGL 2.1 specification, section 2.14.1); at most the largest float.

    Where the point is not finite (d is NaN) nothing arrives. On the light itself (d = 0) it is 1/c,
    and 0 where c = 0: the light cannot be seen from inside itself.
    """
    constant, linear, quadratic = attenuation
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        # Horner's form; without a quadratic term d² must not come up, it may overflow where 0·d² is 0.
        weakening = distance * linear if not quadratic else (distance * quadratic + linear) * distance
        weakening += constant
        strength: Float64Array = np.divide(1.0, weakening, out=weakening)
    if constant < np.finfo(np.float64).tiny:  # the sum may have underflowed; finite, so that 0 times it is 0
        np.minimum(strength, np.finfo(np.float64).max, out=strength)
    if not distance.min(initial=1.0) > 0.0:  # a NaN, or a vertex on the light
        strength[np.isnan(distance)] = 0.0
        if not constant:
            strength[distance == 0.0] = 0.0
    return strength


@dataclass(frozen=True)
class PointLight(Light):
    """Light from a position, in all directions.

    Parameters
    ----------
    position : sequence of float, default (0, 0, 0)
        Where it stands, in the mesh's unit.
    attenuation : sequence of float, default (1, 0, 0)
        Constant c, linear l and quadratic q in 1 / (c + l·d + q·d²), d the distance; >= 0, not all zero.
    **common
        The fields of every light: `diffuse`, `specular`, `ambient`, `intensity`, `on`, `frame`, `name`.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.
    """

    position: VectorLike = (0.0, 0.0, 0.0)
    attenuation: VectorLike = (1.0, 0.0, 0.0)

    def _check_geometry(self) -> None:
        self._set("position", check.vector("position", self.position))
        self._set("attenuation", check_attenuation(self.attenuation))

    def in_world(self, viewer: EyeSpace) -> PointLight:
        """This light with its position in the world, as `viewer` makes it."""
        if self.frame == "camera":
            x, y, z = self.position
            return replace(self, position=viewer.point_to_world((x, y, z)), frame="world")
        if self.frame == "headlight":
            return replace(self, position=viewer.position, frame="world")
        return self

    def arrival(self, points: Float64Array, real: Any = np.float64) -> Arrival:
        """Direction to the light, shape (3, n), and attenuation, shape (n,), at points (3, n)."""
        x, y, z = self.position
        ways, inverse_length, distance = ways_to((x, y, z), points, real)
        return Arrival(ways, attenuate(distance, self.attenuation), inverse_length)

    def _place(self, light: pv.Light, distance: float) -> None:
        x, y, z = self.position
        light.SetPositional(True)
        light.SetConeAngle(90.0)  # VTK's point light is a spot without a cone
        light.SetAttenuationValues(*self.attenuation)
        light.SetPosition(place_for_vtk((x, y, z), self.frame, distance))
        light.SetFocalPoint(place_for_vtk((x, y, z - 1.0), self.frame, distance))
