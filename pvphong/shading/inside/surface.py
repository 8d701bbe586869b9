"""Triangles with lit vertices, and the attributes of new vertices."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray
from pvphong.geometry.transform import normalize
from pvphong.shading.inside.lighting import INTO_TRIANGLE, Lighting, LitVertices, seen_at
from pvphong.shading.inside.triangles import Triangles


class Added(NamedTuple):
    """Vertices added by one split or cut."""

    parents: IntArray
    """The two vertices of which each new vertex is a blend, shape (k, 2)."""
    along: Float64Array
    """Position as a fraction of the way from the first parent to the second, shape (k,)."""


class LitSurface:
    """Triangles that can be bisected and cut, with lit vertices.

    Parameters
    ----------
    points : ndarray
        Shape (n, 3), float32 or float64; new points are rounded to the same type.
    normals : ndarray
        Shape (n, 3), of any length.
    corners : ndarray of int
        Shape (m, 3).
    lighting : Lighting
        The scene, the material and the model matrix.
    smooth : bool
        True to move new vertices to a smooth surface, False to leave them in the triangle.

    Attributes
    ----------
    triangles : Triangles
        Current triangles.
    vertices : LitVertices
        Current vertices; the given vertices come first.
    added : list of Added
        Records of all splits and cuts, in order.
    diagonal : float
        Diagonal of the bounding box.
    """

    def __init__(
        self, points: FloatArray, normals: FloatArray, corners: IntArray, lighting: Lighting, smooth: bool
    ) -> None:
        self.lighting, self.real, self._smooth = lighting, points.dtype, smooth
        self.vertices = lighting.vertices(points, normals)
        p = self.vertices.points
        with np.errstate(invalid="ignore", over="ignore"):
            lengths = np.linalg.norm(np.roll(p[corners], -1, axis=1) - p[corners], axis=2)
        self.triangles = Triangles(corners, len(p), lengths)
        self.added: list[Added] = []
        finite = p[np.isfinite(p).all(axis=1)]
        self.diagonal = float(np.linalg.norm(np.ptp(finite, axis=0))) if len(finite) else 0.0

    def split(self, marks: BoolArray) -> IntArray:
        """Split the marked sides of triangles, and light the new vertices at the sides' middles.

        `marks` is the result of `Triangles.marks`: True for each side to split. Return the indices of the triangles
        that are new or changed.

        On a smooth surface, the vertices are moved to the middles of cubic curves. Each curve joins a side's ends and
        is perpendicular to the ends' normals. Such curves are the sides of PN triangles (A. Vlachos, J. Peters, C.
        Boyd, J. L. Mitchell: Curved PN triangles. Symposium on Interactive 3D Graphics (2001), 159-166). On a circle,
        the error of the middles is of fourth order in the angle.
        """
        curved = (self._triangles_of[marks] == 2) & self._smooth  # not on a boundary or where several sheets meet
        opposite = self._opposite(np.flatnonzero(marks))
        parents, rows = self.triangles.split(marks)
        self._add(parents, np.full(len(parents), 0.5), curved, opposite)
        return rows

    def cut(self, light: int, signs: IntArray, crossed: BoolArray, along: Float64Array, inner: IntArray) -> None:
        """Cut along the edge of a light's shadow or cone, and light the new vertices.

        `light` is the light's index. The other arguments are as for `Triangles.cut`. A cut parts the surface into two
        sheets. Vertices on sheet 1 see the light; vertices on sheet -1 do not.
        """
        opposite = np.repeat(self._opposite(np.flatnonzero(crossed)), 2)
        cut = self.triangles.cut(signs, crossed, along, inner)
        old = len(self.vertices.points)
        opposite = np.concatenate([opposite, np.full(len(cut.parents) - len(opposite), -1)])
        self._add(cut.parents, cut.along, np.zeros(len(opposite), bool), opposite, (light, cut.sheets[old:] > 0))
        on_line = np.flatnonzero((signs == 0) & (cut.sheets[:old] != 0))
        now = self.vertices
        now.seen[on_line, light] = cut.sheets[on_line] > 0
        rows = (each[on_line] for each in (now.points, now.normals, now.maps, now.seen))
        now.colors[on_line] = self.lighting.colors(*rows)

    @property
    def _triangles_of(self) -> IntArray:
        """Number of triangles that share each side, shape (s,)."""
        return np.bincount(self.triangles.sides.ravel(), minlength=len(self.triangles.ends))

    def _opposite(self, sides: IntArray) -> IntArray:
        """Return the corner opposite to each of `sides` in its triangle, shape (k,); -1 for a shared side."""
        corners = np.full(len(self.triangles.ends), -1)
        corners[self.triangles.sides] = np.roll(self.triangles.corners, 1, axis=1)
        corners[self._triangles_of != 1] = -1
        return corners[sides]

    def seen_on_sides(self, light: int, sides: IntArray, along: Float64Array) -> Float64Array:
        """Return the visible part, 0 or 1, of a light without a size from s places along each of k sides, shape (k, s).

        `light` is the light's index. `along` has the places as fractions of the sides, measured from the first end,
        shape (k, s) or (s,). If a side belongs to a single triangle, the rays begin slightly inside this triangle.
        """
        return self._seen_between(light, self.triangles.ends[sides], along, self._opposite(sides))[0]

    def _seen_between(
        self, light: int, ends: IntArray, along: Float64Array, opposite: IntArray
    ) -> tuple[Float64Array, Float64Array]:
        t, is_shared = np.broadcast_to(along, (len(ends), np.shape(along)[-1])), opposite < 0
        into = np.where(is_shared, 0.0, INTO_TRIANGLE)[:, None]
        third = np.broadcast_to(into / 3.0, t.shape)
        weights = np.stack([(1.0 - t) * (1.0 - into) + third, t * (1.0 - into) + third, third], axis=2)
        corners = np.column_stack([ends, np.where(is_shared, ends[:, 0], opposite)])
        return seen_at(light, self.vertices, corners, weights)

    def _add(
        self,
        parents: IntArray,
        along: Float64Array,
        curved: BoolArray,
        opposite: IntArray,
        cut: tuple[int, BoolArray] | None = None,
    ) -> None:
        old, (a, b), t = self.vertices, parents.T, along[:, None]
        points = (1.0 - t) * old.points[a] + t * old.points[b]
        p, q = old.points[a[curved]], old.points[b[curved]]
        n, m = normalize(old.normals[a[curved]]), normalize(old.normals[b[curved]])
        rise, fall = (np.einsum("ki,ki->k", q - p, normal)[:, None] for normal in (n, m))
        points[curved] += (fall * m - rise * n) / 8.0
        points = points.astype(self.real).astype(np.float64)
        normals = (1.0 - t) * old.normals[a] + t * old.normals[b]
        lengths = np.stack([np.linalg.norm(old.stored[ends], axis=1) for ends in (a, b)])
        mean = np.where(lengths.min(axis=0) > 0.0, lengths.mean(axis=0), lengths.max(axis=0))
        stored = normalize(normals) * mean[:, None]  # unit normals between unit normals
        level = (1.0 - along) * old.level[a] + along * old.level[b]
        seen = (1.0 - t) * old.seen[a] + t * old.seen[b]
        errors = np.zeros_like(seen)
        for k in self.lighting.sharp + self.lighting.soft:
            if cut is not None and cut[0] == k:
                seen[:, k] = cut[1]
                continue
            asked = np.arange(len(parents))
            if k in self.lighting.settled:
                asked = np.flatnonzero(old.seen[a, k] != old.seen[b, k])
            if len(asked):
                part, error = self._seen_between(k, parents[asked], along[asked, None], opposite[asked])
                seen[asked, k], errors[asked, k] = part[:, 0], error[:, 0]
        if self._smooth:
            length = np.linalg.norm(normals, axis=1)
            level *= np.linalg.norm(stored, axis=1) / np.where(length > 0.0, length, 1.0)
            normals = stored
        maps = (1.0 - t) * old.maps[a] + t * old.maps[b]
        added = (points, normals, stored, maps, seen, level, *self.lighting.lit(points, normals, maps, seen, errors))
        _, *known = vars(old).values()
        self.vertices = LitVertices(self.lighting, *map(np.concatenate, zip(known, added, strict=True)))
        self.added.append(Added(parents, along))
