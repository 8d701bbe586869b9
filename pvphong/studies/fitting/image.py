"""Colours at vertices, read back from a picture: a rendering or a photograph."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple, get_args

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from pvphong.base import check
from pvphong.base.color import linear_from_srgb
from pvphong.base.processes import reading
from pvphong.base.types import Float64Array, IntArray, MatrixLike
from pvphong.geometry.projection import project
from pvphong.meshes.blocks import datasets
from pvphong.meshes.files import read_texture
from pvphong.meshes.saving import Encoding
from pvphong.meshes.surfaces import point_normals, surface
from pvphong.meshes.visibility import checked_occluders, receiver_of
from pvphong.optics.maps import is_image_path
from pvphong.rays.casting import Occluders
from pvphong.rays.rays import Receiver
from pvphong.scene.viewer import Viewer

# Largest distance from a vertex to what its pixels show, in pixels on a surface that faces the viewer.
_NEAR = 3.0
# Least cosine between a vertex's normal and the direction to the viewer, and least cosine between the normal and the
# faces that its pixels show.
_GRAZING, _SAME_SIDE = 0.2, 0.7


def colors_from_image(
    mesh: Any,
    image: Any,
    camera: Any,
    *,
    encoding: Encoding = "linear",
    occluders: Any = (),
    matrix: MatrixLike | None = None,
) -> Any:
    """Read the colours of a mesh's points from a picture of it.

    A point gets a colour if the four pixels nearest to it show the surface around it. A point gets no colour if it is
    hidden, outside the picture or at a silhouette, or if its surface is seen at an angle below 12°. Colours are
    interpolated between the centres of pixels. The result is a target for `mesh.phong.fit`.

    Parameters
    ----------
    mesh : pyvista.DataSet or pyvista.MultiBlock
        The mesh or meshes in the picture; they are not modified.
    image : array_like or str
        Shape (height, width, 3 or 4), the first row at the top, as from ``plotter.screenshot``: uint8, or floats from 0
        to 1; or the path of a .png or .jpg file. A fourth channel is ignored.
    camera : Viewer or pyvista.Camera
        The picture's camera. The picture shows its view completely.
    encoding : {"linear", "srgb"}
        Meaning of the numbers: "linear" for VTK's pictures, "srgb" for photographs and files of most other programs.
    occluders : sequence, optional
        Other meshes in the picture, which may hide points, as for `mesh.phong.shade`.
    matrix : array_like, optional
        (4, 4) model matrix of the mesh.

    Returns
    -------
    ndarray or dict
        Shape (n_points, 3), float64, linear; NaN where the picture does not show a point, such as inside a volume. For
        a MultiBlock, a dictionary of such arrays by path. Either is a target for `mesh.phong.fit`.

    Raises
    ------
    ValueError
        If the image has another shape or type, the camera is neither a Viewer nor a pyvista.Camera, or no point is
        visible.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> plotter = pv.Plotter(off_screen=True, window_size=(200, 200))
    >>> actor = plotter.add_mesh(pv.Sphere(), color="orange", smooth_shading=True)
    >>> picture = plotter.screenshot(return_img=True)
    >>> seen = ph.colors_from_image(pv.Sphere(), picture, plotter.camera)
    >>> seen.shape
    (842, 3)
    """
    viewer = camera if isinstance(camera, Viewer) else Viewer.from_camera(camera)
    pixels = _pixels(image, check.choice("encoding", encoding, get_args(Encoding)))
    if not isinstance(mesh, pv.DataSet | pv.MultiBlock):
        check.refuse("mesh", type(mesh).__name__, "a pyvista.DataSet or a pyvista.MultiBlock")
    parts = dict(datasets(mesh)) if isinstance(mesh, pv.MultiBlock) else {"": mesh}
    surfaces = {path: surface(part) for path, part in parts.items()}
    receivers = [receiver_of(each, partial(point_normals, each), matrix, 0) for each in surfaces.values()]
    blocking = [each.faces for each in receivers if each.part is not None]
    if not blocking:
        check.refuse("mesh", "a mesh without faces", "a mesh with faces, which hide the points behind them")
    occluding = Occluders([*blocking, *checked_occluders(occluders)])
    found = {
        path: _of_points(parts[path], surfaces[path], _read(each, occluding, viewer, pixels))
        for path, each in zip(surfaces, receivers, strict=True)
    }
    if all(np.isnan(colors).all() for colors in found.values()):
        remedy = "Pass the camera with which the picture was made, and the whole picture."
        check.refuse("camera", repr(viewer), "a camera whose picture shows points of the mesh", remedy)
    return found if isinstance(mesh, pv.MultiBlock) else found[""]


def _of_points(mesh: pv.DataSet, outside: pv.PolyData, colors: Float64Array) -> Float64Array:
    """Return colours for all points of `mesh`, NaN for points inside. `colors` are those of its surface `outside`."""
    if isinstance(mesh, pv.PolyData | pv.PointSet):
        return colors
    found = np.full((mesh.n_points, 3), np.nan)
    found[np.asarray(outside.point_data["vtkOriginalPointIds"])] = colors
    return found


def _pixels(image: Any, encoding: str) -> Float64Array:
    """Return a picture's linear colours, shape (height, width, 3), with the first row at the bottom.

    `image` is an array or a path, and `encoding` is "linear" or "srgb".
    """
    allowed = "an array of shape (height, width, 3), uint8 or floats, or the path of a picture"
    if isinstance(image, str) or hasattr(image, "__fspath__"):
        if not is_image_path(str(image)):
            check.refuse("image", image, "the path of a picture, such as view.png")
        with reading(str(image)):
            image = read_texture(str(image), "image").to_array()
    given = check.real_array("image", image, allowed)
    if given.ndim != 3 or given.shape[2] not in (3, 4) or min(given.shape[:2]) < 2:
        check.refuse("image", f"an array of shape {given.shape}", allowed)
    if given.dtype != np.uint8 and given.dtype.kind != "f":
        check.refuse("image", f"an array of {given.dtype}", allowed, "Convert 0-255 values to uint8.")
    colors = given[::-1, :, :3].astype(np.float64)
    if given.dtype == np.uint8:
        colors /= 255.0
    return linear_from_srgb(colors) if encoding == "srgb" else colors


class _Around(NamedTuple):
    """The four pixels nearest to each of n places in a picture, for bilinear interpolation.

    All arrays have shape (4, n).
    """

    rows: IntArray
    columns: IntArray
    weights: Float64Array


def _around(places: Float64Array, shape: Sequence[int]) -> _Around:
    x, y = places[:, 0] - 0.5, places[:, 1] - 0.5
    column, row = np.floor(x).astype(np.intp), np.floor(y).astype(np.intp)
    u, v = x - column, y - row
    rows, columns = np.stack([row, row, row + 1, row + 1]), np.stack([column, column + 1, column, column + 1])
    weights = np.stack([(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v])
    return _Around(rows.clip(0, shape[0] - 1), columns.clip(0, shape[1] - 1), weights)


def _read(receiver: Receiver, occluders: Occluders, viewer: Viewer, pixels: Float64Array) -> Float64Array:
    """Return the colours (n, 3) of a surface's vertices, NaN where the picture does not show them.

    `receiver` has the vertices. `pixels` has the picture's colours, first row at the bottom. `occluders` are all meshes
    that may hide vertices.
    """
    height, width, _ = pixels.shape
    points, normals = receiver.points, receiver.unit_normals
    found = np.full(points.shape, np.nan)
    places = project(points, viewer, (width, height))[:, :2]
    with np.errstate(invalid="ignore"):
        inside = (places >= 0.5).all(axis=1) & (places <= np.array([width, height]) - 0.5).all(axis=1)
    some = np.flatnonzero(inside)
    if not len(some):
        return found
    around, p, n = _around(places[some], pixels.shape), points[some], normals[some]
    # each pixel that is needed gets one ray
    numbers, of = np.unique(around.rows * width + around.columns, return_inverse=True)
    origins, directions = _rays(viewer, numbers % width + 0.5, numbers // width + 0.5, width, height)
    hits = occluders.first(origins, directions, np.full(len(numbers), np.inf))
    is_met = hits.triangles >= 0
    where = origins + np.where(is_met, hits.distances, 0.0)[:, None] * directions
    corners = occluders.points[occluders.triangles.corners[hits.triangles]].astype(np.float64)
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    faces /= np.maximum(np.linalg.norm(faces, axis=1), np.finfo(float).tiny)[:, None]
    of = of.reshape(4, -1)
    if viewer.parallel:
        to_viewer, size = np.broadcast_to(-np.array(viewer.view_direction), p.shape), 2.0 * viewer.parallel_scale
    else:
        to_viewer = np.array(viewer.position) - p
        distance = np.linalg.norm(to_viewer, axis=1)
        to_viewer = to_viewer / distance[:, None]
        size = 2.0 * np.tan(np.radians(0.5 * viewer.view_angle)) * distance
    facing = np.abs((to_viewer * n).sum(axis=1))
    near = _NEAR * size / height / np.maximum(facing, _GRAZING)
    shown = facing >= _GRAZING
    for pixel in of:
        shown &= is_met[pixel] & (np.linalg.norm(where[pixel] - p, axis=1) <= near)
        shown &= np.abs((faces[pixel] * n).sum(axis=1)) >= _SAME_SIDE
    colors = (pixels[around.rows, around.columns] * around.weights[..., None]).sum(axis=0)
    found[some[shown]] = colors[shown]
    return found


def _rays(
    viewer: Viewer, x: NDArray[Any], y: NDArray[Any], width: int, height: int
) -> tuple[Float64Array, Float64Array]:
    """Return the origins and unit directions of camera rays.

    `x` and `y` are places in a picture of `width` by `height` pixels, measured in pixels from its lower left corner.
    """
    right, up = (2.0 * x - width) / height, (2.0 * y - height) / height
    if viewer.parallel:
        offsets = np.stack([right, up, np.zeros_like(up)], axis=1) * viewer.parallel_scale
        directions = np.broadcast_to(np.array(viewer.view_direction), offsets.shape)
        return np.array(viewer.position) + offsets @ viewer.axes, np.ascontiguousarray(directions)
    slope = np.tan(np.radians(0.5 * viewer.view_angle))
    towards = np.stack([right * slope, up * slope, np.full_like(up, -1.0)], axis=1)
    towards /= np.linalg.norm(towards, axis=1)[:, None]
    return np.broadcast_to(np.array(viewer.position), towards.shape).copy(), towards @ viewer.axes
