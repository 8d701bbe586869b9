"""Light from one point, attenuated with distance (OpenGL's w ≠ 0)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pvphong.base.types import VectorLike
from pvphong.optics.attenuation import COEFFICIENTS, NONE
from pvphong.optics.light import Light, PunctualParameters
from pvphong.optics.roles import meaning, place


class Weakening:
    """Mixin for lights with `position` and `attenuation`."""

    position: Any
    attenuation: Any

    @property
    def placement(self) -> PunctualParameters:
        """Position and attenuation of the light."""
        return PunctualParameters(self.position, self.attenuation)


@dataclass(frozen=True)
class PointLight(Weakening, Light):
    """Point light: from a position, in all directions.

    Parameters
    ----------
    position : sequence of float, default (0, 0, 0)
        Its position, in the mesh's unit.
    attenuation : sequence of float, default (1, 0, 0)
        Constant c, linear l and quadratic q in 1 / (c + l·d + q·d²), d the distance; >= 0, not all zero.
    **common
        The fields of every light: `diffuse`, `specular`, `ambient`, `intensity`, `on`, `frame`, `name`.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> bulb = ph.PointLight(position=(2, -1, 2), attenuation=(1, 0, 0.1))
    >>> lit = pv.Sphere().phong.shade(bulb)
    """

    position: VectorLike = place()
    attenuation: VectorLike = meaning(COEFFICIENTS, NONE)
