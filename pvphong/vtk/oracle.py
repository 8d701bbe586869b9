"""VTK's own fragment lighting as an oracle: run once per vertex and read back in float32.

A screenshot is 8 bits and interpolated: good for looking, too coarse for proof. Here VTK draws the mesh as
points with its unmodified fragment shader. Lines added at the end of the *vertex* shader send vertex number
``gl_VertexID`` to the pixel of that number, so every vertex gets exactly one fragment, and a float32 framebuffer
keeps what the shader wrote: unclamped, uninterpolated.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkRenderingCore import vtkCamera, vtkLight, vtkProperty

from pvphong.base import check
from pvphong.base.types import BoolArray, Float64Array, FloatArray, MatrixLike, rgb
from pvphong.meshes.lit import point_normals
from pvphong.meshes.surfaces import surface
from pvphong.optics.lights import Light
from pvphong.optics.material import Material, nearest_in_vtk
from pvphong.optics.reflectances.pbr import is_physical, physical_of
from pvphong.optics.reflectances.vtk import HIGHEST_POWER
from pvphong.scene.viewer import Viewer
from pvphong.vtk.lights import write_light
from pvphong.vtk.vertex_window import driver, shade_vertices

__all__ = ["driver", "vtk_shade"]


def vtk_shade(
    mesh: pv.DataSet,
    lights: Iterable[Light | vtkLight],
    property_or_material: vtkProperty | Material,
    viewer: Viewer | vtkCamera,
    *,
    matrix: MatrixLike | None = None,
) -> NDArray[np.float32]:
    """Colours that VTK's own fragment shader gives a mesh, one per vertex.

    Nothing is interpolated, clamped or rounded to 8 bits, and nothing of the shader's lighting is changed. The
    mesh is drawn as points, which VTK never turns to the viewer: every vertex is lit with its normal as it stands.

    Parameters
    ----------
    mesh : pyvista.DataSet
        Its point normals are used as they are; without any they are computed, weighted by angle. Of a dataset
        that is no ``PolyData`` the surface is taken.
    lights : iterable of pvphong lights, pyvista.Light or vtkLight
        Lit by copies: the lights given are neither modified nor attached to anything. VTK ignores a light's
        ambient colour, and lights highlights with its diffuse colour. When no light is on, VTK draws
        unlit, in full ambient plus full diffuse colour, and so does this function.
    property_or_material : pyvista.Property, vtkProperty or Material
        Of a property, the ambient, diffuse and specular coefficients and colours, the specular power, the lighting
        switch, and with physically based shading its metallic and roughness count, nothing else.
    viewer : Viewer, pyvista.Camera or vtkCamera
        Where the mesh is seen from.
    matrix : array_like, shape (4, 4), optional
        The model matrix, as an actor's user matrix; the identity when left out.

    Returns
    -------
    numpy.ndarray
        Shape (n_points, 3), float32. Rows whose point or normal is not finite in float32, or whose normal is
        zero, are NaN: what a GPU makes of them differs from driver to driver.

    Raises
    ------
    ValueError
        For a mesh without points, or without normals and faces to compute them from; for a material or light that
        VTK has no place for (emission, powers above 128, reflectances but `PBR`); for anything that is no light,
        material or viewer; if VTK cannot draw on this machine.

    Notes
    -----
    Points and light positions reach the GPU in float32, with VTK's own shift and scale and no other: large
    world coordinates show VTK's own loss. The formulas are those of VTK's ``vtkOpenGLPolyDataMapper.cxx``
    (``ReplaceShaderLight``), which simulates headlights, directional and positional lights in three tiers.
    """
    source = surface(mesh)
    points, normals = check.array("points", source.points), check.array("normals", point_normals(source))
    placed = None if matrix is None else _vtk_matrix(check.matrix4("matrix", matrix))
    given = _listed(lights)
    camera = vtk_camera(viewer, rides=any(getattr(light, "frame", "") == "camera" for light in given))
    copies = [vtk_light(light, Viewer.from_camera(camera)) for light in given]
    appearance = vtk_property(property_or_material)
    colors = np.full(points.shape, np.nan, dtype=np.float32)
    drawable = _drawable(points, normals)
    if drawable.any():
        shown = points[drawable], normals[drawable]
        colors[drawable] = shade_vertices(*shown, copies, appearance, camera, placed)
    return colors


def _drawable(points: FloatArray, normals: FloatArray) -> BoolArray:
    """Rows that are finite in float32 and have a normal there."""
    with np.errstate(over="ignore"):
        p, n = points.astype(np.float32), normals.astype(np.float32)
    drawable: BoolArray = np.logical_and.reduce(np.isfinite(p) & np.isfinite(n), axis=1)
    return drawable & np.logical_or.reduce(n != 0.0, axis=1)


def _listed(lights: Any) -> list[Any]:
    if not isinstance(lights, Iterable) or isinstance(lights, (str, bytes, dict)):
        check.refuse("lights", lights, "a sequence of lights", "Put a single light into a list.")
    return list(lights)


def vtk_light(light: Any, viewer: Viewer) -> vtkLight:
    """A copy that the renderer may move. Its floats are kept, where `pyvista.Light.copy` rounds colours to 8 bits."""
    copy = vtkLight()
    if isinstance(light, Light):
        if light.on:
            _within_vtk("exponent", light.as_vtk().exponent)
        write_light(light, copy, viewer)
    elif isinstance(light, vtkLight):
        copy.DeepCopy(light)
    else:
        check.refuse("lights", light, "pvphong lights, pyvista.Light or vtkLight objects")
    return copy


def _within_vtk(name: str, power: float) -> None:
    if power > HIGHEST_POWER:
        remedy = f"VTK clamps it: judge the scene with {name}={HIGHEST_POWER:g}."
        check.refuse(name, power, f"at most {HIGHEST_POWER:g} in VTK", remedy)


def vtk_property(property_or_material: Any) -> vtkProperty:
    """What the lighting takes from a property or material, on points of one pixel."""
    appearance = vtkProperty()
    if isinstance(property_or_material, Material):
        write_material(property_or_material, appearance)
    elif isinstance(property_or_material, vtkProperty):
        _write_property(property_or_material, appearance)
    else:
        allowed = "a Material, a pyvista.Property or a vtkProperty"
        check.refuse("property_or_material", property_or_material, allowed)
    appearance.SetRepresentationToPoints()
    appearance.SetPointSize(1.0)
    return appearance


def write_material(material: Material, appearance: vtkProperty) -> None:
    """A material in VTK's terms; raises ``ValueError`` for what VTK has no place for."""
    physical = material.reflectance
    if physical is None:
        appearance.SetInterpolationToPhong()
        _within_vtk("shininess", material.shininess)
    elif (values := physical.in_vtk()) is None:
        check.refuse("reflectance", physical, "None or PBR in VTK", nearest_in_vtk(material))
    else:
        appearance.SetInterpolationToPBR()
        appearance.SetMetallic(values.metallic)
        appearance.SetRoughness(values.roughness)
    if any(rgb(material.emission)):
        remedy = "VTK's shading has none. Without any light, ambient is the same: add it there."
        check.refuse("emission", material.emission, "0 in VTK", remedy)
    appearance.SetAmbient(1.0)
    appearance.SetDiffuse(1.0)
    appearance.SetSpecular(1.0)
    appearance.SetAmbientColor(rgb(material.ambient))
    appearance.SetDiffuseColor(rgb(material.diffuse))
    appearance.SetSpecularColor(rgb(material.specular))
    appearance.SetSpecularPower(material.shininess)


def _write_property(source: vtkProperty, appearance: vtkProperty) -> None:
    appearance.SetInterpolationToPhong()
    if is_physical(source):
        physical_of(source)  # refuses what it has not
        appearance.SetInterpolationToPBR()
        appearance.SetMetallic(source.GetMetallic())
        appearance.SetRoughness(source.GetRoughness())
    appearance.SetAmbient(source.GetAmbient())
    appearance.SetDiffuse(source.GetDiffuse())
    appearance.SetSpecular(source.GetSpecular())
    appearance.SetAmbientColor(source.GetAmbientColor())
    appearance.SetDiffuseColor(source.GetDiffuseColor())
    appearance.SetSpecularColor(source.GetSpecularColor())
    appearance.SetSpecularPower(source.GetSpecularPower())
    appearance.SetLighting(source.GetLighting())


def vtk_camera(viewer: Any, *, rides: bool) -> vtkCamera:
    """A camera that the renderer may adjust; `rides` says whether a light depends on the viewer's `up`."""
    camera = vtkCamera()
    if isinstance(viewer, Viewer):
        direction = viewer.view_direction
        level = any(np.cross(viewer.up, direction))
        camera.SetPosition(*viewer.position)
        camera.SetFocalPoint(*viewer.focal_point)
        camera.SetViewUp(viewer.axes[1] if level or rides else np.eye(3)[np.argmin(np.abs(direction))])
        camera.SetParallelProjection(viewer.parallel)
    elif isinstance(viewer, vtkCamera):
        camera.DeepCopy(viewer)
    else:
        check.refuse("viewer", viewer, "a Viewer, a pyvista.Camera or a vtkCamera")
    return camera


def _vtk_matrix(matrix: Float64Array) -> vtkMatrix4x4:
    result = vtkMatrix4x4()
    result.DeepCopy(matrix.ravel().tolist())
    return result
