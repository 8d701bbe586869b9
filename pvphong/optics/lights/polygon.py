"""Light from a glowing polygon."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, Vector
from pvphong.base.vectors import unit_vector
from pvphong.optics.area.lobes import CosinePower
from pvphong.optics.area.sampling import Sampling, polygon_sample, polygon_seen
from pvphong.optics.light import Integral, Light
from pvphong.optics.lights.sized import Flat, across, lattice, over_polygon
from pvphong.optics.roles import Corners, Role, meaning

_SQUARE = ((-0.5, -0.5, 0.0), (-0.5, 0.5, 0.0), (0.5, 0.5, 0.0), (0.5, -0.5, 0.0))
_ALLOWED = "three or more points in one plane, joined by sides that do not cross"

# Largest distance of a corner from the plane, relative to the polygon's size; least area, relative to its square.
_OFF_PLANE, _NO_AREA = 1e-6, 1e-12


def _checked(name: str, value: Any) -> tuple[Vector, ...]:
    """Check the corners of a polygon, and return them as a tuple of points.

    The polygon must be planar, have an area, and not cross itself. `name` is the argument's name in messages.
    """
    points = check.array(name, value, allowed="(k, 3) real numbers").astype(np.float64)
    corners = tuple((x, y, z) for x, y, z in points.tolist())
    if len(corners) < 3 or not np.isfinite(points).all():
        check.refuse(name, value, _ALLOWED)
    offsets = points - points.mean(axis=0)
    size = float(np.abs(offsets).max())
    normal = _vector_area(offsets / (size or 1.0))
    length = float(np.linalg.norm(normal))
    if not length > _NO_AREA:
        remedy = "The polygon has no area: its corners are in a line, or its sides cross."
        check.refuse(name, value, _ALLOWED, remedy)
    if np.abs(offsets @ (normal / length)).max() > _OFF_PLANE * size:
        check.refuse(name, value, _ALLOWED, "The corners are not in one plane; split the polygon into triangles.")
    if _crosses((offsets / size) @ across(normal / length).T):
        check.refuse(name, value, _ALLOWED, "Sides cross; give the corners in order around the polygon.")
    return corners


@dataclass(frozen=True)
class PolygonLight(Flat, Light):
    """Polygon light with Lambertian emission: `diffuse` · `intensity` is its intensity along its normal.

    A white patch that faces it at a large distance d receives the light's colour divided by d². Diffuse reflection and
    Phong's highlight are exact; for other reflectances, 64 spot lights approximate the polygon. If the light is a
    headlight, its corners are in eye space.

    Parameters
    ----------
    corners : sequence of points, default a unit square around the origin that faces along −z
        Shape (k, 3), k >= 3, in the mesh's unit, in order around the polygon, counter-clockwise as seen from its front.
        The corners must be in one plane, and no two sides may cross.
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
    >>> corners = [(0, 0, 2), (0, 1, 2), (1, 0, 2)]  # its front is below
    >>> lit = pv.Sphere().phong.shade(ph.PolygonLight(corners, intensity=4))
    """

    corners: Any = meaning(Corners(_checked, "position"), _SQUARE)
    two_sided: bool = meaning(Role(check.flag), False)

    @cached_property
    def triangles(self) -> Float64Array:
        """Triangles that make up the polygon, shape (k − 2, 3, 3): triangle, corner, coordinate.

        Coordinates are offsets from the polygon's first corner.
        """
        offsets = self.outline - self.outline[0]
        flat = offsets @ across(self.normal).T
        return np.array([offsets[list(ears)] for ears in _ears(flat)])

    @cached_property
    def area(self) -> float:
        """Area of the polygon."""
        return float(_areas(self.triangles).sum())

    @cached_property
    def center(self) -> Vector:
        """Centroid of the polygon's area."""
        triangles = self.triangles
        x, y, z = self.outline[0] + _areas(triangles) @ triangles.mean(axis=1) / self.area
        return float(x), float(y), float(z)

    @cached_property
    def normal(self) -> Vector:
        """Unit normal of the front, by the right-hand rule around the corners."""
        return unit_vector(_vector_area(self.outline - self.outline[0]).tolist())

    @cached_property
    def outline(self) -> Float64Array:
        """Corners of the polygon, shape (k, 3)."""
        return np.array(self.corners)

    def spots(self, count: int) -> Float64Array:
        """Return `count` points evenly spread over the polygon, shape (count, 3).

        A lattice is distributed over the polygon's triangles.
        """
        if count == 1:
            return np.array([self.center])
        areas = _areas(self.triangles)
        ends, shares = np.cumsum(areas) / self.area, areas / self.area
        along, across = lattice(count).T
        which = np.minimum(np.searchsorted(ends, along), len(ends) - 1)
        along = (along - (ends - shares)[which]) / shares[which]
        a, b, c = np.moveaxis(self.triangles[which], 1, 0)
        far = np.sqrt(along)[:, None]
        return self.outline[0] + a + far * (b - a) + far * across[:, None] * (c - b)

    @property
    def sampling(self) -> Sampling:
        """Importance sampling of the polygon's points."""
        sides = self.reach_radius * across(self.normal)
        flat = (self.triangles + self.outline[0] - np.array(self.center)) @ (sides / self.reach_radius**2).T
        shares = _areas(self.triangles) / self.area
        flat[:, 1:] -= flat[:, :1]
        rows = np.column_stack([shares.cumsum(), shares, flat.reshape(-1, 6)])[shares > 0.0]
        of_all = self.sampled(polygon_sample, polygon_seen, sides, 1.0)
        return of_all._replace(numbers=(*of_all.numbers, float(len(rows)), *rows.ravel().tolist()))

    def analytic_integral(self, form: CosinePower) -> Integral:
        """Return the exact integral over the visible part of the polygon, weighted by `form`, a power of a cosine."""
        offsets = self.outline - np.array(self.center)
        return over_polygon(form, self.center, self.normal, self.two_sided, self.area, offsets)


def _vector_area(offsets: Float64Array) -> Float64Array:
    return 0.5 * np.cross(offsets, np.roll(offsets, -1, axis=0)).sum(axis=0)


def _areas(triangles: Float64Array) -> Any:
    """Return the areas, shape (m,), of triangles, shape (m, 3 corners, 3)."""
    return 0.5 * np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)


def _turn(a: Any, b: Any, c: Any) -> float:
    """Return twice the signed area of the plane triangle of the points a, b and c; positive if counter-clockwise."""
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _crosses(flat: Float64Array) -> bool:
    """Return True if two sides of a polygon cross in their interiors.

    `flat` has its corners in the plane, shape (k, 2).
    """
    sides = [(flat[k - 1], flat[k]) for k in range(len(flat))]
    return any(
        _turn(a, b, c) * _turn(a, b, d) < 0.0 and _turn(c, d, a) * _turn(c, d, b) < 0.0
        for k, (a, b) in enumerate(sides)
        for c, d in sides[:k]
    )


def _ears(flat: Float64Array) -> Iterator[tuple[int, int, int]]:
    """Triangulate a polygon by ear clipping; yield the indices of each triangle's corners.

    `flat` has the polygon's corners in the plane, shape (k, 2), counter-clockwise.
    """
    left = list(range(len(flat)))
    while len(left) > 3:
        ear = max(range(len(left)), key=lambda k: _goodness(flat, left, k))
        yield left[ear - 1], left[ear], left[(ear + 1) % len(left)]
        del left[ear]
    yield left[0], left[1], left[2]


def _goodness(flat: Float64Array, left: list[int], k: int) -> tuple[bool, float]:
    """Return a pair that ranks a corner as a candidate for clipping.

    The corner with the greatest pair is clipped first. The first entry is True if the corner can be clipped as an ear.
    The second is twice the signed area of the triangle of the corner and its two neighbours.

    Parameters
    ----------
    flat : ndarray
        Corners of the polygon in the plane, shape (k, 2).
    left : list of int
        Indices of the corners that have not been clipped yet, in order.
    k : int
        Index in `left` of the corner.
    """
    a, b, c = (flat[left[j % len(left)]] for j in (k - 1, k, k + 1))
    turn = _turn(a, b, c)
    is_empty = not any(min(_turn(a, b, p), _turn(b, c, p), _turn(c, a, p)) > 0.0 for p in (flat[j] for j in left))
    return turn >= 0.0 and is_empty, turn
