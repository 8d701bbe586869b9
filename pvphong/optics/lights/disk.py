"""Light from a glowing disk."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, VectorLike
from pvphong.optics.area.disk import disk_highlight, disk_irradiance
from pvphong.optics.area.lobes import CosinePower
from pvphong.optics.area.sampling import Sampling, disk_sample, disk_seen
from pvphong.optics.light import Integral, Light
from pvphong.optics.lights.aimed import Aimed
from pvphong.optics.lights.sized import Flat, across
from pvphong.optics.roles import Role, aim, length, meaning, place


@dataclass(frozen=True)
class DiskLight(Aimed, Flat, Light):
    """Disk light with Lambertian emission: `diffuse` · `intensity` is its intensity along its normal.

    A white patch that faces it at a large distance d receives the light's colour divided by d². Diffuse reflection and
    Phong's highlight are exact; for other reflectances, 64 spot lights approximate the disk.

    Parameters
    ----------
    position : sequence of float, default (0, 0, 0)
        Its centre, in the mesh's unit.
    direction : sequence of float, default (0, 0, -1)
        Normal of its front, the direction of its strongest emission; of any length.
    radius : float, default 1
        Its radius > 0, in the mesh's unit.
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
    >>> disk = ph.DiskLight(position=(0, 0, 2), direction=(0, 0, -1), radius=0.5, intensity=4)
    >>> lit = pv.Sphere().phong.shade(disk)
    """

    position: VectorLike = place()
    direction: VectorLike = aim()
    radius: float = length(1.0, "radius", "A light without a size is a PointLight with attenuation=(0, 0, 1).")
    two_sided: bool = meaning(Role(check.flag), False)

    def spots(self, count: int) -> Float64Array:
        """Return `count` points evenly spread over the disk, shape (count, 3): a golden-angle spiral (Vogel 1979)."""
        k = np.arange(count)
        far = np.sqrt((k + 0.5) / count) * (count > 1)
        return self._at(far, k * math.pi * (3.0 - math.sqrt(5.0)))

    @property
    def outline(self) -> Float64Array:
        """Points on the disk's rim, shape (k, 3)."""
        return self._at(np.ones(64), np.arange(64) * math.pi / 32.0)

    def _at(self, far: Any, around: Any) -> Float64Array:
        """Return points of the disk, shape (k, 3).

        `far` are their distances from the centre as fractions of the radius, and `around` their angles in radians.
        """
        ways = np.stack([np.cos(around), np.sin(around)]).T @ across(self.normal)
        return np.array(self.position) + self.radius * far[:, None] * ways

    @property
    def area(self) -> float:
        """Area of the disk: π times the square of the radius."""
        return math.pi * self.radius * self.radius

    @property
    def sampling(self) -> Sampling:
        """Importance sampling of the disk's points."""
        return self.sampled(disk_sample, disk_seen, self.radius * across(self.normal), math.sqrt(0.5))

    def analytic_integral(self, form: CosinePower) -> Integral:
        """Return the exact integral over the visible part of the disk, weighted by `form`, a power of a cosine."""
        formula = disk_irradiance if form.around == "normal" else disk_highlight
        return Integral(formula, self.center, self.radius, (*self.normal, float(self.two_sided), self.radius))
