"""VTK's own fragment lighting as an oracle: run once per vertex and read back in float32.

A screenshot has 8 bits and is interpolated, which is too coarse for a proof. Here VTK draws the mesh as points with its
unmodified fragment shader. Lines added at the end of the *vertex* shader send vertex number ``gl_VertexID`` to the
pixel of that number. So every vertex has exactly one fragment, and a float32 framebuffer stores the shader's output
without clamping or interpolation.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkCommonCore import VTK_FLOAT
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkRenderingCore import vtkCamera, vtkLight, vtkProperty, vtkRenderer, vtkRenderWindow
from vtkmodules.vtkRenderingOpenGL2 import (
    vtkFramebufferPass,
    vtkOpenGLActor,
    vtkOpenGLPolyDataMapper,
    vtkRenderStepsPass,
    vtkTextureObject,
)

from pvphong.base import check
from pvphong.base.types import ByteArray, FloatArray, MatrixLike, rgb
from pvphong.base.vectors import is_direction
from pvphong.meshes.pictures import drawing_window, preferring
from pvphong.meshes.point_data import surface_and_maps
from pvphong.meshes.surfaces import point_normals, surface
from pvphong.optics.lights import Light, vtk_values
from pvphong.optics.maps import Map, map_values
from pvphong.optics.material import Material, as_material, nearest_in_vtk, refuse_maps_in_vtk
from pvphong.optics.reflectances.likeness import in_vtk
from pvphong.optics.reflectances.pbr import is_physical, physical_of
from pvphong.optics.reflectances.vtk import HIGHEST_POWER
from pvphong.scene.viewer import Viewer
from pvphong.vtk.lights import write_light

SIDE = 2048
"""Width and largest height of the framebuffer, which holds 2048² vertices in 64 MiB. More vertices take more passes."""

_TO_PIXEL = """//VTK::CustomEnd::Impl
  int place = gl_VertexID - firstVertex;
  vec2 pixel = vec2(float(place % framebufferSize.x), float(place / framebufferSize.x)) + 0.5;
  gl_Position = vec4(2.0 * pixel / vec2(framebufferSize) - 1.0, 0.0, 1.0);
  if (place < 0) { gl_Position.x = 2.0; }  // an earlier pass has shaded it; a later pass's lie above the top
"""

_COLORS = "Ambient", "Diffuse", "Specular"
_OF_PROPERTY = (*_COLORS, *(f"{name}Color" for name in _COLORS), "SpecularPower", "Lighting")
"""Attributes that are read from a `vtkProperty`, in addition to those of physically based shading."""


def vtk_shade(
    mesh: pv.DataSet,
    lights: Iterable[Light | vtkLight],
    property_or_material: vtkProperty | Material | str,
    viewer: Viewer | vtkCamera,
    *,
    matrix: MatrixLike | None = None,
) -> NDArray[np.float32]:
    """Compute the colours of a mesh with VTK's own fragment shader, one per vertex.

    The colours are not interpolated, clamped or rounded to 8 bits, and the shader's lighting is unmodified. VTK draws
    the vertices as points. It never turns the normals of points towards the viewer.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface. Its point normals are used; if it has none, they are computed, weighted by angle.
    lights : iterable of pvphong lights, pyvista.Light or vtkLight
        Lights, which are not modified. VTK ignores a light's ambient colour, and uses its diffuse colour for
        highlights. If no light is on, VTK, and so this function, draws the mesh unlit, in the sum of the material's
        ambient and diffuse colours.
    property_or_material : pyvista.Property, vtkProperty, Material or str
        The material, as a pvphong material, a material's name or a property. Of a property, the ambient, diffuse and
        specular coefficients and colours, the specular power and the lighting switch are used. With physically based
        shading, metallic and roughness are used too. A material's albedo may be a uint8 map, which VTK draws as vertex
        colours, if the material's ambient and diffuse are grey.
    viewer : Viewer, pyvista.Camera or vtkCamera
        The viewer.
    matrix : array_like, shape (4, 4), optional
        Model matrix, like an actor's user matrix; defaults to the identity.

    Returns
    -------
    numpy.ndarray
        Shape (n_points, 3), float32. A row is NaN if the point or normal is not finite in float32, or the normal is
        zero, because GPU drivers treat such vertices differently.

    Raises
    ------
    ValueError
        For a mesh without points, or without normals and faces to compute them from; for a material or light that VTK
        does not support (emission, powers above 128, reflectances other than `PBR`); for an argument that is not a
        light, material or viewer; if VTK cannot draw on this machine.

    Notes
    -----
    Points and light positions are sent to the GPU in float32, after VTK's own shift and scale, so large world
    coordinates show VTK's loss of precision. The formulas are those of VTK's ``vtkOpenGLPolyDataMapper.cxx``
    (``ReplaceShaderLight``). They have three tiers: one for a single headlight, one for directional lights, and one for
    lights with a position.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> viewer = ph.Viewer(position=(0, 0, 5))
    >>> ph.vtk_shade(pv.Sphere(), [ph.DirectionalLight()], "gold", viewer).shape
    (842, 3)
    """
    source = surface(mesh)
    points, normals = check.array("points", source.points), check.array("normals", point_normals(source))
    placed = None if matrix is None else pv.vtkmatrix_from_array(check.matrix4("matrix", matrix))
    if not isinstance(lights, Iterable) or isinstance(lights, (str, bytes, dict)):
        check.refuse("lights", lights, "a sequence of lights", "Put a single light into a list.")
    given = list(lights)
    camera = vtk_camera(viewer, follows_viewer=any(getattr(light, "frame", "") == "camera" for light in given))
    copies = [vtk_light(light, Viewer.from_camera(camera)) for light in given]
    tints = None
    if isinstance(property_or_material, Material) and "albedo" in property_or_material.maps:
        _, maps, _ = surface_and_maps(mesh, Material(albedo=property_or_material.albedo))
        tints = map_values("albedo", maps["albedo"], len(points)).rows
        property_or_material = replace(property_or_material, albedo=Map(tints))
    appearance = vtk_property(property_or_material)
    with np.errstate(over="ignore"):
        p, n = points.astype(np.float32), normals.astype(np.float32)
    drawable = np.isfinite(p).all(axis=1) & is_direction(n.T)
    colors = np.full(points.shape, np.nan, dtype=np.float32)
    if drawable.any():
        tints = None if tints is None else np.broadcast_to(tints, points.shape)[drawable]
        shown = points[drawable], normals[drawable], tints
        colors[drawable] = _shade_vertices(*shown, copies, appearance, camera, placed)
    return colors


# --- inputs of VTK: copies of lights, material and camera ---


def vtk_light(light: Any, viewer: Viewer) -> vtkLight:
    """Convert a light to a new `vtkLight`. The renderer may move the new light.

    `viewer` places lights that move with the viewer. (`pyvista.Light.copy` is not used, because it rounds colours to 8
    bits.)
    """
    copy = vtkLight()
    if isinstance(light, Light):
        if light.on:
            _within_vtk("exponent", vtk_values(light).exponent)
        write_light(light, copy, viewer)
    elif isinstance(light, vtkLight):
        copy.DeepCopy(light)
    else:
        check.refuse("lights", light, "pvphong lights, pyvista.Light or vtkLight objects")
    return copy


def _within_vtk(name: str, power: float) -> None:
    if power > HIGHEST_POWER:
        remedy = f"VTK clamps it; use {name}={HIGHEST_POWER:g}."
        check.refuse(name, power, f"at most {HIGHEST_POWER:g} in VTK", remedy)


def vtk_property(property_or_material: Any) -> vtkProperty:
    """Return a new property that draws points of one pixel, lit as `property_or_material`.

    The argument is a pvphong material, a material's name, or a VTK property.
    """
    appearance = vtkProperty()
    if isinstance(property_or_material, Material | str):
        write_material(as_material(property_or_material), appearance)
    elif isinstance(property_or_material, vtkProperty):
        appearance.SetInterpolationToPhong()
        if is_physical(property_or_material):
            physical_of(property_or_material)  # raises for unsupported features
            appearance.SetInterpolationToPBR()
            appearance.SetMetallic(property_or_material.GetMetallic())
            appearance.SetRoughness(property_or_material.GetRoughness())
        for name in _OF_PROPERTY:
            getattr(appearance, f"Set{name}")(getattr(property_or_material, f"Get{name}")())
    else:
        allowed = "a Material, a pyvista.Property or a vtkProperty"
        check.refuse("property_or_material", property_or_material, allowed)
    appearance.SetRepresentationToPoints()
    appearance.SetPointSize(1.0)
    return appearance


def write_material(material: Material, appearance: vtkProperty) -> None:
    """Write a material to a VTK property, `appearance`.

    Raise ``ValueError`` for features of the material that VTK does not support.
    """
    refuse_maps_in_vtk(material)
    has_tints = "albedo" in material.maps
    material = material if has_tints else material.without_albedo()
    physical = material.reflectance
    if physical is None:
        appearance.SetInterpolationToPhong()
        _within_vtk("shininess", material.shininess)
    elif (values := in_vtk(physical)) is None:
        check.refuse("reflectance", physical, "None or PBR in VTK", nearest_in_vtk(material))
    else:
        appearance.SetInterpolationToPBR()
        appearance.SetMetallic(values.metallic)
        appearance.SetRoughness(values.roughness)
    if any(rgb(material.emission)):
        remedy = "VTK has no emission. Without lights, add it to ambient, which is equivalent."
        check.refuse("emission", material.emission, "0 in VTK", remedy)
    for part in _COLORS:
        color = rgb(getattr(material, part.lower()))
        is_tinted = has_tints and part != "Specular"
        getattr(appearance, f"Set{part}")(color[0] if is_tinted else 1.0)
        getattr(appearance, f"Set{part}Color")((1.0, 1.0, 1.0) if is_tinted else color)
    appearance.SetSpecularPower(material.shininess)


def vtk_camera(viewer: Any, *, follows_viewer: bool) -> vtkCamera:
    """Return a new camera with the position and direction of a viewer or camera; the renderer may modify it.

    If the viewer's `up` is parallel to the view axis, `follows_viewer` decides. True, for scenes with a light that
    depends on `up`, raises ValueError. With False, a coordinate axis replaces `up`.
    """
    camera = vtkCamera()
    if isinstance(viewer, Viewer):
        direction = viewer.view_direction
        level = any(np.cross(viewer.up, direction))
        camera.SetPosition(*viewer.position)
        camera.SetFocalPoint(*viewer.focal_point)
        camera.SetViewUp(viewer.axes[1] if level or follows_viewer else np.eye(3)[np.argmin(np.abs(direction))])
        camera.SetParallelProjection(viewer.parallel)
    elif isinstance(viewer, vtkCamera):
        camera.DeepCopy(viewer)
    else:
        check.refuse("viewer", viewer, "a Viewer, a pyvista.Camera or a vtkCamera")
    return camera


# --- the window: one pixel per vertex, in float32 ---


def _shade_vertices(
    points: FloatArray,
    normals: FloatArray,
    tints: ByteArray | None,
    lights: Sequence[vtkLight],
    appearance: vtkProperty,
    camera: vtkCamera,
    matrix: vtkMatrix4x4 | None,
) -> NDArray[np.float32]:
    """Run VTK's fragment shader, and return its colours of n >= 1 vertices, shape (n, 3).

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3). Points are finite, and normals not zero.
    tints : ndarray or None
        Shape (n, 3), uint8: colours that VTK uses in place of the ambient and the diffuse colour, if not None.
    lights : sequence of vtkLight
        The lights; the renderer may modify them.
    appearance : vtkProperty
        The material.
    camera : vtkCamera
        The viewer; the renderer may modify it.
    matrix : vtkMatrix4x4 or None
        Model matrix; None for the identity.

    Raises
    ------
    RuntimeError
        If the graphics driver left vertices undrawn.
    """
    count = len(points)
    cloud = pv.PolyData(points)  # keeps the precision of the points, and makes a vertex cell of each
    cloud.point_data.active_normals = normals
    mapper, actor, renderer = vtkOpenGLPolyDataMapper(), vtkOpenGLActor(), vtkRenderer()
    mapper.SetInputData(cloud)
    mapper.SetScalarVisibility(tints is not None)
    if tints is not None:  # the shader uses them as ambient and diffuse colours
        cloud.point_data["tints"] = tints
        cloud.set_active_scalars("tints")
        mapper.SetColorModeToDirectScalars()
    actor.SetMapper(mapper)
    actor.SetProperty(appearance)
    actor.SetUserMatrix(matrix)
    actor.GetShaderProperty().AddVertexShaderReplacement("//VTK::CustomEnd::Impl", True, _TO_PIXEL, False)
    renderer.AutomaticLightCreationOff()
    renderer.GetCullers().RemoveAllItems()  # a mesh outside the view must be drawn too
    renderer.SetActiveCamera(camera)
    renderer.AddActor(actor)
    for light in lights:
        renderer.AddLight(light)
    framebuffer = vtkFramebufferPass()
    framebuffer.SetColorFormat(vtkTextureObject.Float32)
    framebuffer.SetDelegatePass(vtkRenderStepsPass())
    renderer.SetPass(framebuffer)
    width, height = SIDE, min(-(-count // SIDE), SIDE)
    uniforms = actor.GetShaderProperty().GetVertexCustomUniforms()
    uniforms.SetUniform2i("framebufferSize", (width, height))
    colors = np.empty((count, 3), dtype=np.float32)
    with off_screen_window(width, height) as window:
        window.AddRenderer(renderer)
        for first in range(0, count, width * height):
            uniforms.SetUniformi("firstVertex", first)
            window.Render()
            part = colors[first : first + width * height]
            part[:] = _drawn(framebuffer, len(part))
    return colors


def _drawn(framebuffer: vtkFramebufferPass, count: int) -> NDArray[np.float32]:
    """Read the first `count` pixels of the framebuffer; return their red, green and blue, shape (count, 3).

    Raise ``RuntimeError`` if a pixel was not drawn.
    """
    texture = framebuffer.GetColorTexture()
    width, height, components = texture.GetWidth(), texture.GetHeight(), texture.GetComponents()
    pixels = np.empty(width * height * components, dtype=np.float32)
    buffer = texture.Download()
    buffer.Download2D(VTK_FLOAT, pixels, [width, height], components, [0, 0])
    pixels = pixels.reshape(-1, components)[:count]
    undrawn = int(count - np.count_nonzero(pixels[:, 3] == 1.0)) if components == 4 else count
    if undrawn or len(pixels) < count:
        msg = f"VTK's driver left {undrawn} of {count} vertices undrawn ({driver()})."
        raise RuntimeError(msg)
    return pixels[:, :3]


@functools.cache
def driver() -> str:
    """Return the vendor, renderer and version of VTK's graphics driver as text; queried once per process."""
    with off_screen_window(1, 1) as window:
        window.AddRenderer(vtkRenderer())
        window.Render()
        lines = [line.split(":", 1) for line in window.ReportCapabilities().splitlines() if ":" in line]
    known = {name.strip(): value.strip() for name, value in lines}
    return ", ".join(known[f"OpenGL {part} string"] for part in ("vendor", "renderer", "version"))


@contextmanager
def off_screen_window(width: int, height: int) -> Iterator[vtkRenderWindow]:
    """Return a context with an off-screen window of this size in pixels. At its end, the window is emptied and closed.

    Raises ``ValueError`` if VTK cannot draw on this machine.
    """
    with preferring(drawing_window()):
        window = vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(0)
    window.SetSize(width, height)
    try:
        yield window
    finally:
        for renderer in list(window.GetRenderers()):
            renderer.RemoveAllViewProps()
            renderer.RemoveAllLights()
            renderer.ReleaseGraphicsResources(window)
            window.RemoveRenderer(renderer)
        window.Finalize()
