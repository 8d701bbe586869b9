"""Visibility of lights and sky: converts meshes to triangles that block rays, and to vertices that receive light."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import repeat
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes

from pvphong.base import check
from pvphong.base.types import BoolArray, FloatArray, MatrixLike, rgb
from pvphong.geometry.transform import transform_normals, transform_points
from pvphong.meshes.blocks import datasets, leaves
from pvphong.meshes.cells import cells, refuse_invalid
from pvphong.meshes.surfaces import has_faces, outer_surface, polygons, surface
from pvphong.rays.casting import BlockingFaces, Occluders
from pvphong.rays.rays import Receiver
from pvphong.rays.sampling import MOST_RAYS
from pvphong.rays.visibility import Tracer, Visibility
from pvphong.scene.scene import Scene, light_labels

_AS_FINE_AS_A_DISPLAY = 1.0 / 255.0


def triangles_of(mesh: pv.PolyData) -> NDArray[np.int64]:
    """Return the point indices of a surface's triangles, shape (m, 3).

    Other faces are triangulated, and hidden cells are skipped.
    """
    connectivity, offsets = polygons(mesh)
    sizes, shown = np.diff(offsets), _shown(mesh)
    if not shown.all():
        connectivity, sizes = connectivity[np.repeat(shown, sizes)], sizes[shown]
        offsets = np.concatenate([[0], np.cumsum(sizes)])
    if (sizes == 3).all():
        return connectivity.reshape(-1, 3)
    if sizes.max(initial=0) > 4:  # a fan of triangles may extend outside a concave face
        bare = pv.PolyData()
        bare.SetPoints(mesh.GetPoints())  # `bare.points = …` would mark the mesh's points as modified
        bare.faces = pv.CellArray.from_arrays(offsets, connectivity)
        return polygons(bare.triangulate())[0].reshape(-1, 3)
    first, quads = offsets[:-1][sizes >= 3], offsets[:-1][sizes == 4]
    fans = np.concatenate([first[:, None] + [0, 1, 2], quads[:, None] + [0, 2, 3]])
    return connectivity[fans]


def _shown(mesh: pv.PolyData) -> BoolArray:
    """Return a mask of the faces that `polygons` returns. It is False for faces of cells that VTK's ghost array hides.

    Without a ghost array, the mask is [True], which broadcasts to all faces.
    """
    ghosts = mesh.cell_data.get("vtkGhostType")
    if ghosts is None:
        return np.ones(1, bool)
    shown = (np.asarray(ghosts) & vtkDataSetAttributes.HIDDENCELL) == 0
    _, _, faces, strips = cells(mesh)
    of_faces, of_strips = (shown[each.first : each.first + each.count] for each in (faces, strips))
    return np.concatenate([of_faces, np.repeat(of_strips, np.maximum(np.diff(strips.offsets) - 2, 0))])


class KnownOccluders(NamedTuple):
    """Occluders with known triangles, and the index of one mesh among them."""

    occluders: Occluders
    own_index: int | None
    """Index of the mesh among the occluders; None if it is not among them."""
    first: int = 0
    """Index of the mesh's first vertex, if the mesh is a piece of a larger one."""


def world_faces(source: pv.PolyData, matrix: MatrixLike | None = None) -> BlockingFaces:
    """Return the triangles of a surface in world coordinates. The points are copied.

    `matrix` is the surface's model matrix; None is the identity.
    """
    points = source.points.astype(np.float64) if matrix is None else transform_points(source.points, matrix)
    return BlockingFaces(points, triangles_of(source))


def receiver_of(
    source: pv.PolyData, normals: Callable[[], FloatArray], matrix: MatrixLike | None, part: int
) -> Receiver:
    """Return the vertices of a surface, in world coordinates, as receivers of light.

    Parameters
    ----------
    source : pyvista.PolyData
        The surface.
    normals : callable
        Function that returns the surface's point normals; it is called when the normals are needed.
    matrix : array_like or None
        Model matrix; None is the identity.
    part : int
        Index of the surface among the occluders, if it has faces.
    """
    faces = world_faces(source, matrix)
    world_normals = normals if matrix is None else lambda: transform_normals(normals(), matrix)
    return Receiver(faces, world_normals, part if len(faces) else None)


def checked_occluders(given: Any) -> list[BlockingFaces]:
    """Check the argument `occluders`, and return the triangles of each mesh in it, in world coordinates.

    Parameters
    ----------
    given : sequence
        Meshes, or pairs of a mesh and its 4x4 matrix.

    Raises
    ------
    ValueError
        If an element is neither a mesh nor such a pair, or a mesh is invalid.
    """
    allowed = "a sequence of meshes, or of pairs of a mesh and a 4x4 matrix"
    if isinstance(given, (pv.DataSet, pv.MultiBlock)):
        check.refuse("occluders", f"a {type(given).__name__}", allowed, "Put a single mesh into a list.")
    # an iterator can be read only once, but occluders are read whenever rays are cast
    if isinstance(given, str) or not isinstance(given, Sequence):
        check.refuse("occluders", given, allowed, "Convert an iterable with list(...).")
    parts: list[BlockingFaces] = []
    for index, one in enumerate(given):
        name = f"occluders[{index}]"
        mesh, matrix = one if isinstance(one, tuple) and len(one) == 2 else (one, None)
        if not isinstance(mesh, (pv.DataSet, pv.MultiBlock)):
            remedy = "Convert a VTK dataset with pyvista.wrap(...)."
            check.refuse(name, one, "a mesh, or a pair of a mesh and a 4x4 matrix", remedy)
        if matrix is not None:
            matrix = check.matrix4(f"{name}[1]", matrix)
        for each in leaves(mesh):
            try:
                refuse_invalid(each)
            except ValueError as error:
                raise ValueError(f"{name}: {error}") from error
            source = outer_surface(each) if each.n_points else pv.PolyData()
            if has_faces(source):
                parts.append(world_faces(source, matrix))
    return parts


def occluders_of_blocks(
    blocks: pv.MultiBlock, matrix: MatrixLike | None = None, occluders: Any = ()
) -> Iterator[KnownOccluders]:
    """Yield the occluders for each nonempty dataset of `blocks`, in order.

    The occluders are all datasets, moved by the model matrix `matrix`, and the meshes in `occluders`. The results share
    their triangles, and differ only in `own_index`.
    """
    parts = [world_faces(surface(block), matrix) for _, block in datasets(blocks)]
    together = Occluders([*parts, *checked_occluders(occluders)])
    return (KnownOccluders(together, index) for index in range(len(parts)))


def visibility_options(blocks: pv.MultiBlock, scene: Scene, options: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the options with which each nonempty dataset of `blocks` is lit, in order.

    Each result is a copy of `options` with one change. If `options` has the key "visibility", its value is a mapping
    from paths of datasets to visibilities, and is replaced by the dataset's entry. Without this key, if the scene needs
    rays, the occluders are replaced by the occluders for this dataset.

    Raises
    ------
    ValueError
        If `visibility` is not a mapping with an entry for each dataset.
    """
    given = options.get("visibility")
    if given is None:
        if not scene.light_model.needs_rays:
            return repeat(options)
        among = occluders_of_blocks(blocks, options.get("matrix"), options.get("occluders", ()))
        return (options | {"occluders": each} for each in among)
    paths = [path for path, _ in datasets(blocks)]
    if not isinstance(given, Mapping) or not given.keys() >= set(paths):
        remedy = "Compute it with blocks.phong.visibility(scene)."
        check.refuse("visibility", type(given).__name__, f"a mapping with the keys {', '.join(paths)}", remedy)
    return (options | {"visibility": given[path]} for path in paths)


def visibility_of(
    source: pv.PolyData,
    normals: Callable[[], FloatArray],
    scene: Scene,
    *,
    occluders: Any = (),
    samples: int | None = None,
    tolerance: float = _AS_FINE_AS_A_DISPLAY,
    matrix: MatrixLike | None = None,
) -> Visibility:
    """Return the visibility of lights and sky from the vertices of a surface.

    `normals` is a function that returns the surface's point normals. The other parameters are those of the method
    `mesh.phong.visibility` with the same names.
    """
    if samples is not None:
        samples = int(check.number("samples", samples, at_least=1.0, at_most=float(MOST_RAYS)))
    tolerance = check.number("tolerance", tolerance, at_least=0.0) or _AS_FINE_AS_A_DISPLAY
    known, receiver = occluders, receiver_of(source, normals, matrix, 0)
    if not isinstance(known, KnownOccluders):
        others = checked_occluders(occluders)
        own = [receiver.faces] if receiver.part is not None else []
        known = KnownOccluders(Occluders([*own, *others]), receiver.part)
    tracer = tracer_of(receiver, scene, known, tolerance, samples)
    return Visibility(tracer, scene.world_lights, light_labels(scene), two_sided=scene.light_model.two_sided)


def tracer_of(
    receiver: Receiver,
    scene: Scene,
    known: KnownOccluders,
    tolerance: float = _AS_FINE_AS_A_DISPLAY,
    samples: int | None = None,
) -> Tracer:
    """Return the tracer that casts rays from a surface's vertices to the lights and the sky of a scene.

    `known` are the meshes that block light. `samples` is the number of rays per vertex; None to cast rays until the
    standard error of the colours is at most `tolerance`.
    """
    model = scene.light_model
    ambient = max(rgb(model.ambient)) + sum(light.intensity * max(rgb(light.ambient)) for light in scene.lights)
    own = replace(receiver, part=known.own_index)
    return Tracer(own, known.occluders, model.occlusion_distance, tolerance, samples, ambient, known.first)
