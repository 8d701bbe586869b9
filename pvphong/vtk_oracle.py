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

from pvphong import _check
from pvphong._types import BoolArray, FloatArray, MatrixLike, rgb
from pvphong._vertex_bench import driver, shade_vertices
from pvphong.lights import Light, SpotLight
from pvphong.material import Material
from pvphong.scene import Viewer

__all__ = ["HIGHEST_POWER", "driver", "vtk_shade"]

HIGHEST_POWER = 128.0
"""``vtkProperty`` clamps the specular power, and ``vtkLight`` the spot exponent, to this."""


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
        Of a property, the ambient, diffuse and specular coefficients and colours, the specular power and the
        lighting switch count, nothing else.
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
        VTK has no place for (emission, powers above 128); for anything that is no light, material or viewer.

    Notes
    -----
    Points and light positions reach the GPU in float32, with VTK's own shift and scale and no other: large
    world coordinates show VTK's own loss. The formulas are those of VTK's ``vtkOpenGLPolyDataMapper.cxx``
    (``ReplaceShaderLight``), which simulates headlights, directional and positional lights in three tiers.
    """
    points, normals = _points_and_normals(mesh)
    camera = _camera(viewer)
    copies = [_copied(light, viewer) for light in _listed(lights)]
    appearance = _appearance(property_or_material)
    user_matrix = None if matrix is None else _vtk_matrix(_check.matrix4("matrix", matrix))
    drawable = _drawable(points, normals)
    colors = np.full((len(points), 3), np.nan, dtype=np.float32)
    if drawable.any():
        colors[drawable] = shade_vertices(points[drawable], normals[drawable], copies, appearance, camera, user_matrix)
    return colors
