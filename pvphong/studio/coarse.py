"""Coarse pictures of large meshes, drawn while something moves.

Without a graphics card, drawing a mesh takes a time proportional to its triangles, far longer than lighting it: 150 ms
for a million triangles on two cores. So all vertices in a small cube are merged to one vertex. The mesh is drawn with
this fraction of its triangles until nothing has changed for a moment. Colours are those of the remaining vertices.
"""

from __future__ import annotations

import weakref
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv

from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.meshes.visibility import triangles_of
from pvphong.studio.background import Job
from pvphong.studio.lit_actors import LitActors
from pvphong.studio.lit_mesh import ARRAY, LitMesh

_MANY = 150_000  # triangles of a mesh that is worth it
_CUBES = 200.0  # along the diagonal of the mesh's box: three to five pixels each in a usual view
_AFTER_MIX = 0.25  # observer priority: after the colours are computed


class Clustered(NamedTuple):
    """A mesh with fewer vertices, as from `clustered`."""

    rows: IntArray
    """Index of each remaining vertex in the whole mesh."""
    triangles: IntArray
    """Vertices of each triangle, shape (m, 3)."""


def clustered(points: Float64Array, normals: FloatArray, triangles: IntArray, cubes: float) -> Clustered:
    """Merge vertices that are in the same small cube and whose normals have the same signs.

    The comparison of signs keeps the two sides of a thin plate apart. Triangles with fewer than three different corners
    are removed. This is the uniform grid of J. Rossignac and P. Borrel, "Multi-resolution 3D approximations" (1993).

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3). Points that are not finite count as the lower corner of the points' bounding box.
    triangles : ndarray
        Corners, shape (m, 3).
    cubes : float
        Number of cubes along the diagonal of the bounding box.
    """
    finite = np.where(np.isfinite(points).all(axis=1, keepdims=True), points, np.nan)
    low, high = np.nanmin(finite, axis=0), np.nanmax(finite, axis=0)
    side = np.linalg.norm(high - low) / cubes or 1.0
    places = np.nan_to_num((finite - low) / side).astype(np.int64)
    counts = places.max(axis=0) + 1
    keys = (places[:, 0] * counts[1] + places[:, 1]) * counts[2] + places[:, 2]
    keys = 8 * keys + (normals > 0.0) @ np.array([1, 2, 4])
    _, rows, which = np.unique(keys, return_index=True, return_inverse=True)
    merged = which[triangles]  # their order, which decides what is the front, stays
    ordered = np.sort(merged, axis=1)
    kept = np.flatnonzero((ordered[:, 0] != ordered[:, 1]) & (ordered[:, 1] != ordered[:, 2]))
    ordered = ordered[kept]
    _, first = np.unique((ordered[:, 0] * len(rows) + ordered[:, 1]) * len(rows) + ordered[:, 2], return_index=True)
    return Clustered(rows, merged[kept[first]])


class _Picture(NamedTuple):
    rows: IntArray
    mesh: pv.PolyData


class CoarsePictures:
    """Coarse pictures of a renderer's lit meshes. Each is made in the background when it is first needed.

    Meshes with few triangles, with refined pictures, with edges or with an opacity for each vertex have no coarse
    picture.

    Parameters
    ----------
    renderer : pyvista.Renderer
        The renderer.
    lit : LitActors
        Its lit meshes.
    """

    def __init__(self, renderer: pv.Renderer, lit: LitActors) -> None:
        self.are_wanted = False
        """True while something moves; can be set at any time."""
        self._renderer, self._lit = renderer, lit
        self._jobs = weakref.WeakKeyDictionary[LitMesh, tuple[Any, Job[Clustered]]]()
        self._made = weakref.WeakKeyDictionary[LitMesh, tuple[Any, _Picture]]()
        pictures = weakref.ref(self)

        def before_frame(_renderer: Any, _event: str) -> None:
            if (alive := pictures()) is not None:
                alive.update()

        self._tag = renderer.AddObserver("StartEvent", before_frame, _AFTER_MIX)

    def update(self) -> None:
        """Show a coarse picture of each mesh that has one, if `are_wanted` is set. Show all other meshes themselves."""
        refined = self._lit.refining
        for mesh in self._lit.shown:
            picture = self._picture(mesh) if self._is_large(mesh) and mesh not in refined else None
            assert mesh.actor is not None
            mapper = mesh.actor.mapper
            if picture is not None and self.are_wanted:
                picture.mesh.point_data[ARRAY] = np.asarray(mesh.drawn.point_data[ARRAY])[picture.rows]
                picture.mesh.set_active_scalars(ARRAY, preference="point")
                mapper.dataset = picture.mesh
            elif mesh in self._made and mapper.dataset is self._made[mesh][1].mesh:
                mapper.dataset = mesh.drawn

    @staticmethod
    def _is_large(mesh: LitMesh) -> bool:
        actor, drawn = mesh.actor, mesh.drawn
        is_plain = actor is not None and not actor.prop.show_edges and mesh.shown_array == ARRAY
        return is_plain and drawn.n_cells >= _MANY and not drawn.n_verts + drawn.n_lines

    def _picture(self, mesh: LitMesh) -> _Picture | None:
        """Return the mesh's coarse picture. If it is not made yet, start to make it and return None."""
        stamp, (known, picture) = mesh.geometry()[0], self._made.get(mesh, (None, None))
        if known == stamp:
            return picture
        of, job = self._jobs.get(mesh, (None, None))
        if job is None or of != stamp:
            if job is not None:
                job.stop()
            own = np.array(mesh.drawn.points, np.float64), np.array(mesh.normals), triangles_of(mesh.drawn).copy()
            self._jobs[mesh] = stamp, Job("clustering", partial(clustered, *own, _CUBES))
        elif job.is_done and job.result is not None:
            rows, triangles = job.result
            coarse = pv.PolyData.from_regular_faces(np.asarray(mesh.drawn.points)[rows], triangles)
            self._made[mesh] = stamp, _Picture(rows, coarse)
            del self._jobs[mesh]
            return self._made[mesh][1]
        return None

    @property
    def are_shown(self) -> bool:
        """True if a coarse picture is shown."""
        return any(
            mesh.actor is not None and mesh.actor.mapper.dataset is made.mesh for mesh, (_, made) in self._made.items()
        )

    def release(self) -> None:
        """Detach from the renderer, and show the meshes themselves."""
        self._renderer.RemoveObserver(self._tag)
        for _, job in self._jobs.values():
            job.stop()
        self._lit.show_own_vertices()
