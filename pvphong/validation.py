"""pvphong's colours against VTK's own shader."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pyvista as pv

from pvphong import _check
from pvphong._types import BoolArray, Float64Array, MatrixLike
from pvphong.comparison import Comparison
from pvphong.evaluation import evaluate
from pvphong.lights import SpotLight
from pvphong.material import Material
from pvphong.mesh import point_normals
from pvphong.planning import check_scene_and_material
from pvphong.scene import Scene
from pvphong.surface import surface
from pvphong.transform import normalize, transform_points
from pvphong.vtk_limits import Pose, limits
from pvphong.vtk_obstacles import refuse_inexpressible, seen_from_infinity
from pvphong.vtk_oracle import driver, vtk_shade
from pvphong.vtk_terms import Terms, in_vtk_terms

_DOUBTFUL_FACING = 2.0**-40
"""Cosines between normal and viewer below this have no certain sign in float64."""


def validate(mesh: pv.DataSet, scene: Scene, material: Material, *, matrix: MatrixLike | None = None) -> Comparison:
    """Compare pvphong's colours with those of VTK's own shader, vertex by vertex.

    pvphong's are `evaluate`'s, in its float32 default, before they are clamped. VTK's are `vtk_shade`'s.
    The scene is compared as it is, in its own convention, whatever VTK needs to be told for it: ambient light and
    emission as the material's unlit ambient, a viewer at infinity as an eye far away, two-sided lighting
    as normals turned to the viewer, a mesh far from the origin around its middle. `Comparison.conversions` says what.

    Left out are vertices where float32 leaves VTK's colour open: those where a highlight begins at n·l = 0, those
    on the edge of a cone, those whose normals turn to the viewer at n·v = 0, those where VTK's own rounding of places
    and directions may cost more than the bound, and, in the standard convention, those where VTK's floor of 1e-5
    under a cosine shows (at powers below 1). `Comparison.left_out` counts them.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface. Its active point normals are used, computed ones where it has none.
    scene : Scene
        Lights, viewer and light model, in either convention.
    material : Material
        The surface's reflectances.
    matrix : array_like, optional
        (4, 4) model matrix.

    Returns
    -------
    Comparison
        `.passed`, `.max_error`, `.worst` and more; print it for a table.

    Raises
    ------
    InexpressibleError
        A ValueError: for a scene that VTK's shader cannot draw (lights with an ambient colour of their own or
        highlights in another than their diffuse colour, Blinn-Phong, a viewer at infinity beside lights with a
        position, powers above 128, a matrix that flattens or scales beyond 1e-18 to 1e18, a mirrored surface as
        VTK turns it), where it would have an effect. It holds the nearest scene that VTK can draw.
    ValueError
        As `evaluate`, or for a mesh with nothing to light.

    See Also
    --------
    pvphong.vtk_oracle.vtk_shade : VTK's colours alone.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> ph.validate(pv.Sphere(), ph.Scene(lights=[ph.DirectionalLight()]), ph.Material()).passed
    True
    """
    check_scene_and_material(scene, material)
    source = surface(mesh)
    given = None if matrix is None else _check.matrix4("matrix", matrix)
    refuse_inexpressible(scene, material, given)
    points, normals = _check.array("points", source.points), _check.array("normals", point_normals(source))
    unclamped = replace(scene, light_model=replace(scene.light_model, clamp=False))
    own = evaluate(points, normals, unclamped, material, matrix=given).rgb
    lit = _lit(points, normals)
    judged = _judge(points[lit], normals[lit], scene, material, np.eye(4) if given is None else given / given[3, 3])
    return judged.compare(source, own, np.flatnonzero(lit))


