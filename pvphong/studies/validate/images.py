"""Lit colours on the screen beside VTK's own lighting of the same mesh, pixel by pixel.

A picture has 8 bits and shows colours interpolated between vertices, where VTK lights every pixel: this is coarser
than `pvphong.studies.validate.validation`, which is the judge. It says whether what is drawn is what was computed.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkFloatArray, vtkUnsignedCharArray
from vtkmodules.vtkRenderingCore import vtkCamera, vtkLight, vtkProperty, vtkRenderer, vtkRenderWindow
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLActor, vtkOpenGLPolyDataMapper

from pvphong.base import check
from pvphong.base.types import BoolArray, Float64Array
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.files import refuse_suffix
from pvphong.meshes.lit import point_normals, shade_mesh
from pvphong.meshes.pictures import refuse_size, save_picture
from pvphong.meshes.surfaces import has_faces, shallow_copy, surface
from pvphong.optics.material import Material, check_material
from pvphong.scene.scene import Scene, SceneLike
from pvphong.scene.viewer import Viewer
from pvphong.vtk.oracle import off_screen_window, vtk_camera, vtk_light, vtk_property
from pvphong.vtk.scenes import Terms, in_vtk_terms, refuse_inexpressible

Image = NDArray[np.uint8]

_ARRAY = "phong"

_AMPLIFIED = 16
"""Grey levels of the difference picture for each step of a display."""

_STEEPEST = 6.0
"""Slope against the picture's plane from which a surface counts as its own silhouette: seen at 80° and more."""


@dataclass(frozen=True, eq=False, repr=False)
class ImageComparison:
    """Two pictures of one mesh from one camera: its lit colours drawn without lighting, and VTK's lighting.

    Attributes
    ----------
    ours, vtks : ndarray
        Shape (height, width, 3), uint8, on white.
    difference : ndarray
        Shape (height, width, 3), int16: ours minus VTK's, in steps of a display.
    inside : ndarray
        Shape (height, width), bool: pixels wholly inside the silhouette. They and their eight neighbours are
        covered, by a surface that is nowhere there about to turn away: a torus has contours inside its outline.
    """

    ours: Image
    vtks: Image
    difference: NDArray[np.int16]
    inside: BoolArray

    @property
    def max_difference(self) -> int:
        """The largest difference of any channel inside the silhouette, in steps of 1/255."""
        return int(self._largest.max())

    @property
    def p99(self) -> float:
        """What 99 % of the differences inside the silhouette stay below, each pixel's that of its worst channel."""
        return float(np.percentile(self._largest, 99))

    @property
    def _largest(self) -> NDArray[np.int16]:
        largest: NDArray[np.int16] = np.abs(self.difference[self.inside]).max(axis=1)
        return largest

    def __repr__(self) -> str:
        pixels = np.count_nonzero(self.inside)
        return f"<ImageComparison: at most {self.max_difference}/255, 99 % {self.p99:.3g}/255, {pixels} pixels>"

    def side_by_side(self) -> Image:
        """Ours, VTK's, and the difference inside the silhouette: grey is none, a step of a display is 16 levels."""
        amplified = np.clip(128 + _AMPLIFIED * self.difference, 0, 255).astype(np.uint8)
        return np.hstack([self.ours, self.vtks, np.where(self.inside[:, :, None], amplified, np.uint8(255))])

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write `side_by_side` as a .png file, whole or not at all.

        Raises
        ------
        ValueError
            If the suffix is another, or the file cannot be written.
        """
        refuse_suffix(Path(path), "a picture", (".png",))
        save_picture(self.side_by_side(), Path(path))


def compare_images(
    mesh: pv.DataSet, scene: SceneLike | None, material: Material, *, size: tuple[int, int] = (400, 300)
) -> ImageComparison:
    """Draw a mesh with its lit colours, and lit by VTK per pixel, and compare the pictures.

    Both are drawn by the scene's viewer without multisampling. The lit colours are interpolated across faces, VTK
    interpolates normals: expect differences of the mesh's interpolation error (`pvphong.interpolation_error`)
    beside the two roundings to 8 bits. VTK lights the backs of surfaces too, whatever the scene says: compare on
    closed meshes.

    Parameters
    ----------
    mesh : pyvista.DataSet
        With faces. Its active point normals are used, computed ones where it has none.
    scene : Scene
        Its viewer must see the mesh.
    material : Material
        The surface's reflectances.
    size : tuple of int, default (400, 300)
        Width and height in pixels.

    Returns
    -------
    ImageComparison
        `.max_difference`, `.p99`, the pictures and `.save`.

    Raises
    ------
    ValueError
        As `pvphong.validate`; also for highlights seen from infinity, which VTK draws from a place far away only,
        for a mesh without faces or out of view, and where this machine cannot draw.
    """
    check_material(material)
    refuse_size(size)
    source = surface(mesh)
    scene = scene_for(source, scene)
    if not has_faces(source):
        check.refuse("mesh", f"{source.n_points} points and no faces", "a mesh with faces")
    terms = _terms(source, scene, material)
    lit = shade_mesh(source, scene, material, name=_ARRAY)
    ours, distances = _drawn(_colored(lit), scene.viewer, [], size)
    vtks, _ = _drawn(_lit_by_vtk(source, terms.material), scene.viewer, _lights(terms), size)
    inside = _inside(distances, scene.viewer)
    if not inside.any():
        check.refuse("viewer", scene.viewer, "one who sees the mesh", "Its picture is empty.")
    return ImageComparison(ours, vtks, ours.astype(np.int16) - vtks, inside)


def _terms(source: pv.PolyData, scene: Scene, material: Material) -> Terms:
    refuse_inexpressible(scene, material, None)
    terms = in_vtk_terms(scene, material, np.array(source.center), source.length)
    if terms.viewer != scene.viewer:
        remedy = "local_viewer=True and parallel=False, or a material without specular."
        got = "highlights for a viewer at infinity, which VTK draws from far away only"
        check.refuse("scene", got, "one that VTK can draw from the viewer's place", remedy)
    return terms


def _lights(terms: Terms) -> list[vtkLight]:
    return [vtk_light(light, terms.viewer) for light in terms.lights]


def _colored(lit: pv.PolyData) -> vtkOpenGLActor:
    """The lit colours as they are."""
    lit.set_active_scalars(_ARRAY, preference="point")
    mapper = vtkOpenGLPolyDataMapper()
    mapper.SetInputData(lit)
    mapper.SetScalarModeToUsePointData()
    mapper.SetColorModeToDirectScalars()
    appearance = vtkProperty()
    appearance.LightingOff()
    return _actor(mapper, appearance)


def _lit_by_vtk(source: pv.PolyData, material: Material) -> vtkOpenGLActor:
    """The surface with smooth shading, as VTK lights it."""
    smooth = shallow_copy(source)
    smooth.point_data.active_normals = point_normals(source)
    mapper = vtkOpenGLPolyDataMapper()
    mapper.SetInputData(smooth)
    mapper.ScalarVisibilityOff()
    appearance = vtk_property(material)
    appearance.SetRepresentationToSurface()
    return _actor(mapper, appearance)


def _actor(mapper: vtkOpenGLPolyDataMapper, appearance: vtkProperty) -> vtkOpenGLActor:
    actor = vtkOpenGLActor()
    actor.SetMapper(mapper)
    actor.SetProperty(appearance)
    return actor


def _drawn(
    actor: vtkOpenGLActor, viewer: Viewer, lights: Sequence[vtkLight], size: tuple[int, int]
) -> tuple[Image, Float64Array]:
    """The picture, and how far away along the view axis each pixel is; infinite for the background."""
    with off_screen_window(*size) as window:
        renderer = vtkRenderer()
        renderer.AutomaticLightCreationOff()
        renderer.SetBackground(1.0, 1.0, 1.0)
        renderer.SetActiveCamera(_camera(viewer))
        for light in lights:
            renderer.AddLight(light)
        renderer.AddActor(actor)
        renderer.ResetCameraClippingRange()
        window.AddRenderer(renderer)
        window.Render()
        return _colors(window, size), _distances(window, size, renderer.GetActiveCamera())


def _camera(viewer: Viewer) -> vtkCamera:
    camera = vtk_camera(viewer, rides=True)
    camera.SetViewAngle(viewer.view_angle)
    camera.SetParallelScale(viewer.parallel_scale)
    return camera


def _colors(window: vtkRenderWindow, size: tuple[int, int]) -> Image:
    """VTK's rows start below."""
    width, height = size
    colors = vtkUnsignedCharArray()
    window.GetPixelData(0, 0, width - 1, height - 1, 0, colors, 0)
    return vtk_to_numpy(colors).reshape(height, width, 3)[::-1].copy()


def _distances(window: vtkRenderWindow, size: tuple[int, int], camera: vtkCamera) -> Float64Array:
    """From the depth buffer, where 0 is the near plane and 1 the far plane."""
    width, height = size
    depths = vtkFloatArray()
    window.GetZbufferData(0, 0, width - 1, height - 1, depths)
    depth = vtk_to_numpy(depths).reshape(height, width)[::-1].astype(np.float64)
    near, far = camera.GetClippingRange()
    parallel = camera.GetParallelProjection()
    distances = near + depth * (far - near) if parallel else near * far / (far - depth * (far - near))
    return np.where(depth < 1.0, distances, np.inf)


def _inside(distances: Float64Array, viewer: Viewer) -> BoolArray:
    """Pixels around which the distance changes by less than `_STEEPEST` pixels' widths from one to the next."""
    nearest, farthest = _around(np.minimum, distances), _around(np.maximum, distances)
    covered = np.isfinite(farthest)
    half_height = viewer.parallel_scale if viewer.parallel else np.tan(np.radians(0.5 * viewer.view_angle)) * nearest
    pixel = 2.0 * half_height / len(distances)
    inside: BoolArray = np.where(covered, farthest, 0.0) - np.where(covered, nearest, 0.0) < 2.0 * _STEEPEST * pixel
    return inside & covered


def _around(extreme: np.ufunc, distances: Float64Array) -> Float64Array:
    """The least or greatest of each pixel and its eight neighbours; nothing covers what lies beyond the border."""
    padded = np.pad(distances, 1, constant_values=np.inf)
    windows = np.lib.stride_tricks.sliding_window_view(padded, (3, 3))
    around: Float64Array = extreme.reduce(windows, axis=(2, 3))
    return around
