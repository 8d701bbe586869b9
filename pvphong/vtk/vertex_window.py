"""The off-screen window behind `pvphong.vtk.oracle`: one pixel per vertex, kept in float32."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import VTK_FLOAT, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkRenderingCore import vtkCamera, vtkLight, vtkProperty, vtkRenderer, vtkRenderWindow
from vtkmodules.vtkRenderingOpenGL2 import (
    vtkFramebufferPass,
    vtkOpenGLActor,
    vtkOpenGLPolyDataMapper,
    vtkRenderStepsPass,
    vtkTextureObject,
)

from pvphong.base.types import FloatArray
from pvphong.meshes.pictures import drawing_window, preferring

SIDE = 2048
"""Width of the framebuffer and its greatest height: one pass shades up to 2048² vertices in 64 MiB."""

_TO_PIXEL = """//VTK::CustomEnd::Impl
  int place = gl_VertexID - firstVertex;
  vec2 pixel = vec2(float(place % framebufferSize.x), float(place / framebufferSize.x)) + 0.5;
  gl_Position = vec4(2.0 * pixel / vec2(framebufferSize) - 1.0, 0.0, 1.0);
  if (place < 0) { gl_Position.x = 2.0; }  // an earlier pass has shaded it; a later pass's lie above the top
"""


def shade_vertices(
    points: FloatArray,
    normals: FloatArray,
    lights: Sequence[vtkLight],
    appearance: vtkProperty,
    camera: vtkCamera,
    matrix: vtkMatrix4x4 | None,
) -> NDArray[np.float32]:
    """What VTK's fragment shader makes of each vertex.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3), float32 or float64, n >= 1; finite, the normals not zero.
    lights : sequence of vtkLight
        Moved along with the camera by the renderer where they are camera lights: give it copies.
    appearance : vtkProperty
        Its representation must be points of size 1, its interpolation Phong.
    camera : vtkCamera
        Its clipping range is adjusted by the renderer: give it a copy.
    matrix : vtkMatrix4x4, optional
        The actor's user matrix.

    Returns
    -------
    ndarray
        Shape (n, 3), float32.

    Raises
    ------
    ValueError
        If VTK cannot draw on this machine.
    RuntimeError
        If the driver left vertices undrawn.
    """
    width, height = SIDE, min(-(-len(points) // SIDE), SIDE)
    colors = np.empty((len(points), 3), dtype=np.float32)
    actor = _actor(_point_cloud(points, normals), appearance, matrix)
    uniforms = actor.GetShaderProperty().GetVertexCustomUniforms()
    uniforms.SetUniform2i("framebufferSize", (width, height))
    with off_screen_window(width, height) as window:
        renderer, framebuffer = _renderer(lights, camera)
        renderer.AddActor(actor)
        window.AddRenderer(renderer)
        for first in range(0, len(points), width * height):
            uniforms.SetUniformi("firstVertex", first)
            window.Render()
            part = colors[first : first + width * height]
            part[:] = _drawn(framebuffer, len(part))
    return colors


@functools.cache
def driver() -> str:
    """Name and version of the graphics driver that VTK draws with, for reports; asked once per process."""
    with off_screen_window(1, 1) as window:
        window.AddRenderer(vtkRenderer())
        window.Render()
        lines = [line.split(":", 1) for line in window.ReportCapabilities().splitlines() if ":" in line]
    known = {name.strip(): value.strip() for name, value in lines}
    return ", ".join(known[f"OpenGL {part} string"] for part in ("vendor", "renderer", "version"))


@contextmanager
def off_screen_window(width: int, height: int) -> Iterator[vtkRenderWindow]:
    """An off-screen window that is empty and closed again on leaving, whatever happened inside.

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


def _renderer(lights: Sequence[vtkLight], camera: vtkCamera) -> tuple[vtkRenderer, vtkFramebufferPass]:
    """A renderer into a float32 texture, with these lights and no others."""
    renderer = vtkRenderer()
    renderer.AutomaticLightCreationOff()
    renderer.GetCullers().RemoveAllItems()  # a mesh outside the view must be drawn all the same
    renderer.SetActiveCamera(camera)
    for light in lights:
        renderer.AddLight(light)
    framebuffer = vtkFramebufferPass()
    framebuffer.SetColorFormat(vtkTextureObject.Float32)
    framebuffer.SetDelegatePass(vtkRenderStepsPass())
    renderer.SetPass(framebuffer)
    return renderer, framebuffer


def _actor(cloud: vtkPolyData, appearance: vtkProperty, matrix: vtkMatrix4x4 | None) -> vtkOpenGLActor:
    """The cloud as VTK lights it, with each vertex sent to its own pixel."""
    mapper = vtkOpenGLPolyDataMapper()
    mapper.SetInputData(cloud)
    mapper.ScalarVisibilityOff()
    actor = vtkOpenGLActor()
    actor.SetMapper(mapper)
    actor.SetProperty(appearance)
    actor.SetUserMatrix(matrix)
    actor.GetShaderProperty().AddVertexShaderReplacement("//VTK::CustomEnd::Impl", True, _TO_PIXEL, False)
    return actor


def _point_cloud(points: FloatArray, normals: FloatArray) -> vtkPolyData:
    """Points in their own precision, each one a vertex cell, with their normals."""
    count = len(points)
    cloud = vtkPolyData()
    vertices = vtkPoints()
    vertices.SetData(numpy_to_vtk(points, deep=True))
    cloud.SetPoints(vertices)
    cloud.GetPointData().SetNormals(numpy_to_vtk(normals, deep=True))
    cells = vtkCellArray()
    cells.SetData(1, numpy_to_vtk(np.arange(count), deep=True))
    cloud.SetVerts(cells)
    return cloud


def _drawn(framebuffer: vtkFramebufferPass, count: int) -> NDArray[np.float32]:
    """The first `count` pixels of the framebuffer, red, green and blue, shape (count, 3)."""
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
