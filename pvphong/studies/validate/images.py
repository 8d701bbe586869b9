"""Pixel-by-pixel comparison of a mesh drawn with its lit colours and the same mesh lit by VTK.

This is coarser than `pvphong.studies.validate.validation`, because an image has 8 bits and shows colours interpolated
between vertices, while VTK lights every pixel. The comparison of images verifies that the computed colours are drawn
unchanged.
"""

from __future__ import annotations

import os
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from pvphong.base import check
from pvphong.base.types import BoolArray, Float64Array
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.files import refuse_suffix
from pvphong.meshes.lit import shade_mesh
from pvphong.meshes.pictures import aim, drawing_window, preferring, refuse_size, save_picture
from pvphong.meshes.surfaces import drawable, has_faces, point_normals, shallow_copy, surface
from pvphong.optics.material import Material, as_material, without_maps
from pvphong.scene.scene import SceneLike
from pvphong.scene.viewer import Viewer
from pvphong.vtk.oracle import vtk_light, write_material
from pvphong.vtk.scenes import Terms, in_vtk_terms, refuse_inexpressible

Image = NDArray[np.uint8]

_ARRAY = "phong"

_AMPLIFIED = 16
"""Number of grey levels that stand for one display step in the picture of differences."""

_STEEPEST = 6.0
"""Least slope, relative to the image plane, at which a surface counts as part of the silhouette; about 80°."""


@dataclass(frozen=True, eq=False, repr=False)
class ImageComparison:
    """Two images of a mesh from one camera: its lit colours drawn without lighting, and VTK's lighting.

    Attributes
    ----------
    ours, vtks : ndarray
        Shape (height, width, 3), uint8, on white.
    difference : ndarray
        Shape (height, width, 3), int16: ours minus VTK's, in steps of a display.
    inside : ndarray
        Shape (height, width), bool: pixels inside the silhouette. A pixel is inside if it and its eight neighbours show
        the surface, and the surface is not nearly edge-on there. So pixels at contours inside the outline, as on a
        torus, are excluded too.
    """

    ours: Image
    vtks: Image
    difference: NDArray[np.int16]
    inside: BoolArray

    @property
    def max_difference(self) -> int:
        """Largest difference of any channel inside the silhouette, as a number of steps of 1/255."""
        return int(np.abs(self.difference[self.inside]).max())

    @property
    def p99(self) -> float:
        """99th percentile of the pixels' differences inside the silhouette.

        The difference of a pixel is the largest of its channels.
        """
        return float(np.percentile(np.abs(self.difference[self.inside]).max(axis=1), 99))

    def __repr__(self) -> str:
        pixels = np.count_nonzero(self.inside)
        return f"<ImageComparison: at most {self.max_difference}/255, 99 % {self.p99:.3g}/255, {pixels} pixels>"

    def side_by_side(self) -> Image:
        """Return one image of three pictures in a row: ours, VTK's, and their difference inside the silhouette.

        In the difference, medium grey is 0, and each display step is 16 grey levels.
        """
        amplified = np.clip(128 + _AMPLIFIED * self.difference, 0, 255).astype(np.uint8)
        return np.hstack([self.ours, self.vtks, np.where(self.inside[:, :, None], amplified, np.uint8(255))])

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write `side_by_side` as a .png file; a failed write leaves no partial file.

        Raises
        ------
        ValueError
            If the suffix is not ``.png``, or the file cannot be written.
        """
        refuse_suffix(Path(path), "a picture", (".png",))
        save_picture(self.side_by_side(), Path(path))


def compare_images(
    mesh: pv.DataSet, scene: SceneLike | None, material: Material, *, size: tuple[int, int] = (400, 300)
) -> ImageComparison:
    """Draw a mesh with its lit colours, draw it lit by VTK per pixel, and compare the images.

    Both images are drawn from the scene's viewer without multisampling. The lit colours are interpolated across faces,
    while VTK interpolates normals. So expect differences up to the mesh's interpolation error
    (`pvphong.interpolation_error`), plus two roundings to 8 bits. VTK lights back faces in every scene, so compare
    closed meshes.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with faces. Its active point normals are used, or computed ones if it has none.
    scene : Scene
        Scene whose viewer sees the mesh.
    material : Material
        Material of the surface.
    size : tuple of int, default (400, 300)
        Width and height in pixels.

    Returns
    -------
    ImageComparison
        `.max_difference`, `.p99`, the pictures and `.save`.

    Raises
    ------
    ValueError
        If an argument is invalid, or VTK's shader cannot draw the scene, for a reason of `pvphong.validate`. Also if
        the scene has highlights and a viewer at infinity, because VTK has only viewers at a finite distance; if the
        mesh has no faces or is out of view; or if VTK cannot draw on this machine.
    """
    material = without_maps(as_material(material), "for a comparison of pictures")
    refuse_size(size)
    source = surface(mesh)
    scene = scene_for(source, scene)
    if not has_faces(source):
        check.refuse("mesh", f"{source.n_points} points and no faces", "a mesh with faces")
    refuse_inexpressible(scene, material, None)
    terms = in_vtk_terms(scene, material, np.array(source.center), source.length)
    if terms.viewer != scene.viewer:
        remedy = "Use local_viewer=True and parallel=False, or a material without specular."
        got = "highlights seen by a viewer at infinity"
        check.refuse("scene", got, "a scene that VTK can draw from the viewer's position", remedy)

    colored = shade_mesh(source, scene, material, name=_ARRAY)
    with (
        closing(window_of_colors(colored, scene.viewer, size)) as ours,
        closing(window_lit_by_vtk(source, terms, size)) as vtks,
    ):
        for window in (ours, vtks):
            window.disable_anti_aliasing()
        lit, lit_by_vtk = (np.asarray(window.screenshot(return_img=True)) for window in (ours, vtks))
        distances = -ours.get_image_depth(fill_value=-np.inf).astype(np.float64)  # along the view axis
    inside = _inside(distances, scene.viewer)
    if not inside.any():
        check.refuse("viewer", scene.viewer, "a viewer that sees the mesh", "Its image is empty.")
    return ImageComparison(lit, lit_by_vtk, lit.astype(np.int16) - lit_by_vtk, inside)


def window_of_colors(
    lit: pv.PolyData, viewer: Viewer, size: tuple[int, int], matrix: Float64Array | None = None, *, name: str = _ARRAY
) -> pv.Plotter:
    """Return an offscreen window that shows the colours of the mesh `lit` unchanged, without lighting.

    The colours are the point array `name`. `size` is in pixels, and `matrix` is the mesh's model matrix.
    """
    window, _ = _window(drawable(lit, name), viewer, size, matrix, scalars=name, rgb=True, lighting=False)
    return window


def window_lit_by_vtk(
    mesh: pv.PolyData, terms: Terms, size: tuple[int, int], matrix: Float64Array | None = None
) -> pv.Plotter:
    """Return an offscreen window in which VTK lights a mesh per pixel.

    The mesh's active normals are used, or computed ones. `terms` has lights, material and viewer, `size` is in pixels,
    and `matrix` is the model matrix.
    """
    smooth = shallow_copy(mesh)
    smooth.clear_data()
    smooth.point_data.active_normals = point_normals(mesh)
    window, actor = _window(smooth, terms.viewer, size, matrix)
    write_material(terms.material, actor.prop)
    for light in terms.lights:
        window.renderer.AddLight(vtk_light(light, terms.viewer))
    return window


def _window(
    mesh: pv.PolyData, viewer: Viewer, size: tuple[int, int], matrix: Float64Array | None, **options: Any
) -> tuple[pv.Plotter, pv.Actor]:
    """Return an offscreen window that shows a mesh on white, without lights, and the mesh's actor.

    `size` is in pixels, and `matrix` is the mesh's model matrix. `options` are passed to `Plotter.add_mesh`.
    """
    with preferring(drawing_window()), pv.vtk_verbosity("off"):
        plotter = pv.Plotter(off_screen=True, window_size=list(size), lighting="none")
    plotter.set_background("white")
    actor = plotter.add_mesh(mesh, copy_mesh=False, **options)
    actor.user_matrix = matrix if matrix is not None else np.eye(4)
    aim(plotter, viewer)
    plotter.renderer.ResetCameraClippingRange()
    return plotter, actor


def _inside(distances: Float64Array, viewer: Viewer) -> BoolArray:
    """Return the mask of the pixels well inside the mesh's silhouette, shape (height, width).

    `distances` has the distance of each pixel's surface along the view axis, infinite for pixels without a surface.
    At a pixel of the mask, the distance changes by less than `_STEEPEST` pixel widths per pixel. Neighbours beyond the
    border of the image count as pixels without a surface.
    """
    padded = np.pad(distances, 1, constant_values=np.inf)
    around = np.lib.stride_tricks.sliding_window_view(padded, (3, 3))
    nearest, farthest = around.min(axis=(2, 3)), around.max(axis=(2, 3))
    covered = np.isfinite(farthest)
    half_height = viewer.parallel_scale if viewer.parallel else np.tan(np.radians(0.5 * viewer.view_angle)) * nearest
    pixel = 2.0 * half_height / len(distances)
    inside: BoolArray = np.where(covered, farthest, 0.0) - np.where(covered, nearest, 0.0) < 2.0 * _STEEPEST * pixel
    return inside & covered
