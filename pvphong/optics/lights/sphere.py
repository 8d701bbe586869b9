"""Light from a sphere that shines evenly in all directions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import ClassVar

import numpy as np

from pvphong.base.types import Float64Array, Vector, VectorLike
from pvphong.optics.area.disk import sphere_highlight, sphere_irradiance
from pvphong.optics.area.lobes import CosinePower
from pvphong.optics.area.sampling import Sampling, sphere_frame, sphere_sample, sphere_seen
from pvphong.optics.attenuation import INVERSE_SQUARE
from pvphong.optics.light import Integral, Light
from pvphong.optics.lights.point import PointLight
from pvphong.optics.roles import MESH_UNIT, length, place


@dataclass(frozen=True)
class SphereLight(Light):
    """A glowing sphere: `diffuse` · `intensity` is its intensity, so that it lights as a point light far away.

    A facing white patch at a great distance d gets the colour of the light over d², and the sphere shows itself in
    that colour over radius². What matt surfaces scatter, and Phong's highlight, are exact; a vertex inside gets
    nothing. What other reflectances make of it is that of 64 point lights inside it. Of what a facing patch gets, that
    is off by at most 3 % at 1.5 radii from its centre, 1.5 % at two and 0.25 % at five; vertices inside are lit by
    those too.

    Parameters
    ----------
    position : sequence of float, default (0, 0, 0)
        Its centre, in the mesh's unit.
    radius : float, default 1
        Its radius > 0, in the mesh's unit.
    **common
        The fields of every light: `diffuse`, `specular`, `ambient`, `intensity`, `on`, `frame`, `name`.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> lamp = ph.SphereLight(position=(2, -1, 2), radius=0.5, intensity=4)
    >>> lit = pv.Sphere().phong.shade(lamp)
    """

    position: VectorLike = place()
    radius: float = length(1.0, "radius", "A light without a size is a PointLight with attenuation=(0, 0, 1).")

    intensity_unit: ClassVar[str] = f"{MESH_UNIT}²"

    def nodes(self, count: int) -> tuple[PointLight, ...]:
        """Point lights inside the sphere.

        They glow through each other. A ball whose glow at a distance r from its centre is in proportion to
        1/√(R² − r²), R its radius, is equally bright along every line through it, from wherever it is seen: along a
        chord that passes the centre at b, ∫ 2 r dr / (√(R² − r²) √(r² − b²)) from b to R is π for every b. So it is the
        sphere. The share of the glow up to r = R sin t is (2t − sin 2t)/π, which is divided evenly among the nodes.
        """
        return _nodes(self.places[0], self.radius, count)

    def closed(self, form: CosinePower) -> Integral:
        """Over the cap as which it is seen."""
        formula = sphere_irradiance if form.around == "normal" else sphere_highlight
        return Integral(formula, self.places[0], self.radius, (self.radius,))

    @property
    def sampling(self) -> Sampling:
        """Evenly within the cone in which it is seen."""
        return Sampling(sphere_frame, sphere_sample, sphere_seen, (*self.places[0], self.radius))

    def radiance(self, directions: Float64Array) -> Float64Array:  # noqa: ARG002 the same from everywhere
        """One over the square of its radius."""
        return np.full((3, 1), 1.0 / self.radius / self.radius)


@lru_cache(maxsize=32)
def _nodes(center: Vector, radius: float, count: int) -> tuple[PointLight, ...]:
    places = np.array(center) + radius * _ball(count)
    return tuple(PointLight(place, INVERSE_SQUARE, intensity=1.0 / count) for place in places)


@cache
def _ball(count: int) -> Float64Array:
    """Places of the nodes in a sphere of radius 1, shape (count, 3): opposite pairs, and the middle if one is left.

    Directions go around in golden angles (Vogel 1979), radii in steps of √2, which has nothing to do with them.
    """
    pairs = count // 2
    k = np.arange(pairs)
    height, around = 1.0 - (k + 0.5) / max(pairs, 1), k * math.pi * (3.0 - math.sqrt(5.0))
    level = np.sqrt(1.0 - height * height)
    directions = np.stack([level * np.cos(around), level * np.sin(around), height], axis=1)
    shares = (k * math.sqrt(2.0) + 0.5) % 1.0
    low, high = np.zeros(pairs), np.full(pairs, math.pi / 2)
    for _ in range(53):  # halves the range of the t with (2t − sin 2t)/π equal to each share: it grows with t
        middle = 0.5 * (low + high)
        is_low = (2.0 * middle - np.sin(2.0 * middle)) / math.pi < shares
        low, high = np.where(is_low, middle, low), np.where(is_low, high, middle)
    half = directions * np.sin(low)[:, None]
    return np.concatenate([half, -half, np.zeros((count % 2, 3))])
