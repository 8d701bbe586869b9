"""Light from a glowing rectangle: a softbox, a window, a panel."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, VectorLike
from pvphong.base.vectors import unit_vector
from pvphong.optics.area.lobes import CosinePower
from pvphong.optics.area.sampling import Sampling, rectangle_sample, rectangle_seen
from pvphong.optics.light import Integral, Light
from pvphong.optics.lights.aimed import Aimed
from pvphong.optics.lights.sized import Flat, across, lattice, over_polygon
from pvphong.optics.roles import Role, Up, aim, length, meaning, place

# Sine of the least angle between `up` and the normal; below it, `up` is ignored.
_LEAST = 1e-9


@dataclass(frozen=True)
class RectangleLight(Aimed, Flat, Light):
    """Rectangle light with Lambertian emission: `diffuse` · `intensity` is its intensity along its normal.

    A white patch that faces it at a large distance d receives the light's colour divided by d². Diffuse reflection and
    Phong's highlight are exact; for other reflectances, 64 spot lights approximate the rectangle.

    Parameters
    ----------
    position : sequence of float, default (0, 0, 0)
        Its centre, in the mesh's unit.
    direction : sequence of float, default (0, 0, -1)
        Normal of its front, the direction of its strongest emission; of any length.
    up : sequence of float, default (0, 1, 0)
        Direction of its height, of any length; the component along the normal is removed. If `up` is parallel to the
        normal, the coordinate axis farthest from the normal replaces it.
    width : float, default 1
        Size across `up`, > 0, in the mesh's unit.
    height : float, default 1
        Size along `up`, > 0, in the mesh's unit.
    two_sided : bool, default False
        True if its back emits too.
    **common
        The fields of every light: `diffuse`, `specular`, `ambient`, `intensity`, `on`, `frame`, `name`.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> softbox = ph.RectangleLight((0, 0, 2), (0, 0, -1), width=1, height=2, intensity=4)
    >>> lit = pv.Sphere().phong.shade(softbox)
    """

    position: VectorLike = place()
    direction: VectorLike = aim()
    up: VectorLike = meaning(Up(check.direction), (0.0, 1.0, 0.0))
    width: float = length(1.0, "width", share=0.5)
    height: float = length(1.0, "height", share=0.5, axis=1)
    two_sided: bool = meaning(Role(check.flag), False)

    @cached_property
    def axes(self) -> Float64Array:
        """Unit vectors as the rows of a (3, 3) array: along the light's normal, its width and its height."""
        normal = np.array(self.normal)
        side = np.cross(normal, unit_vector(self.up))
        if np.linalg.norm(side) < _LEAST:
            side = across(self.normal)[0]
        side /= np.linalg.norm(side)
        return np.stack([normal, side, np.cross(side, normal)])

    @property
    def area(self) -> float:
        """Area of the rectangle: width times height."""
        return self.width * self.height

    @property
    def sides(self) -> Float64Array:
        """Half the width and half the height, as vectors in space, shape (2, 3)."""
        return 0.5 * np.array([[self.width], [self.height]]) * self.axes[1:]

    @cached_property
    def corners(self) -> Float64Array:
        """Offsets of the corners from the centre, shape (4, 3); counter-clockwise as seen from the front."""
        width, height = self.sides
        return np.stack([-width - height, height - width, width + height, width - height])

    @property
    def outline(self) -> Float64Array:
        """Corners of the rectangle, shape (4, 3)."""
        return np.array(self.position) + self.corners

    def spots(self, count: int) -> Float64Array:
        """Return `count` points evenly spread over the rectangle, shape (count, 3): a lattice."""
        return np.array(self.position) + (2.0 * lattice(count) - 1.0) @ self.sides

    @property
    def sampling(self) -> Sampling:
        """Importance sampling of the rectangle's points."""
        return self.sampled(rectangle_sample, rectangle_seen, self.sides, 1.0)

    def analytic_integral(self, form: CosinePower) -> Integral:
        """Return the exact integral over the visible part of the rectangle, weighted by `form`, a power of a cosine."""
        return over_polygon(form, self.center, self.normal, self.two_sided, self.area, self.corners)
