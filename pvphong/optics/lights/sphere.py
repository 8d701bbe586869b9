"""Light from a sphere that emits uniformly in all directions."""

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
    """Sphere light: `diffuse` · `intensity` is its intensity, so from far away it acts as a point light.

    A white patch that faces it at a large distance d receives the light's colour divided by d²; the sphere's own
    radiance is the colour divided by radius². Diffuse reflection and Phong's highlight are exact; a vertex inside the
    sphere receives nothing. For other reflectances, 64 point lights inside the sphere approximate the sphere; they also
    light vertices inside it. For a patch that faces the sphere, the error of this approximation is at most 3 % at 1.5
    radii from the centre, 1.5 % at two radii and 0.25 % at five.

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
        """Return `count` point lights inside the sphere that approximate the sphere; they do not occlude each other.

        Consider a ball of radius R that emits with a density proportional to 1/√(R² − r²) at the distance r from its
        centre. Along a chord at the distance b from the centre, the integral ∫ 2 r dr / (√(R² − r²) √(r² − b²)) from b
        to R is π for every b. So the ball has the same radiance along every line through it, and emits the same light
        as the sphere. The fraction of the emission up to r = R sin t is (2t − sin 2t)/π. The emission is divided evenly
        among the lights.
        """
        return _nodes(self.places[0], self.radius, count)

    def analytic_integral(self, form: CosinePower) -> Integral:
        """Return the exact integral over the visible part of the sphere, weighted by `form`, a power of a cosine."""
        formula = sphere_irradiance if form.around == "normal" else sphere_highlight
        return Integral(formula, self.places[0], self.radius, (self.radius,))

    @property
    def sampling(self) -> Sampling:
        """Uniform sampling of the cone of directions in which the sphere is seen."""
        return Sampling(sphere_frame, sphere_sample, sphere_seen, (*self.places[0], self.radius))

    def radiance(self, directions: Float64Array) -> Float64Array:  # noqa: ARG002 the same from everywhere
        """Return 1 over the square of the radius: the radiance at intensity 1, which is the same in all directions."""
        return np.full((3, 1), 1.0 / self.radius / self.radius)


@lru_cache(maxsize=32)
def _nodes(center: Vector, radius: float, count: int) -> tuple[PointLight, ...]:
    places = np.array(center) + radius * _ball(count)
    return tuple(PointLight(place, INVERSE_SQUARE, intensity=1.0 / count) for place in places)


@cache
def _ball(count: int) -> Float64Array:
    """Return the positions of `count` nodes in the unit sphere, shape (count, 3).

    The nodes are pairs of opposite points; if `count` is odd, the last one is at the centre. Directions follow golden
    angles (Vogel 1979). Radii follow multiples of √2, so that they are uncorrelated with the directions.
    """
    pairs = count // 2
    k = np.arange(pairs)
    height, around = 1.0 - (k + 0.5) / max(pairs, 1), k * math.pi * (3.0 - math.sqrt(5.0))
    level = np.sqrt(1.0 - height * height)
    directions = np.stack([level * np.cos(around), level * np.sin(around), height], axis=1)
    shares = (k * math.sqrt(2.0) + 0.5) % 1.0
    low, high = np.zeros(pairs), np.full(pairs, math.pi / 2)
    for _ in range(53):  # bisect for the t at which (2t − sin 2t)/π, which is monotonic, equals each share
        middle = 0.5 * (low + high)
        is_low = (2.0 * middle - np.sin(2.0 * middle)) / math.pi < shares
        low, high = np.where(is_low, middle, low), np.where(is_low, high, middle)
    half = directions * np.sin(low)[:, None]
    return np.concatenate([half, -half, np.zeros((count % 2, 3))])
