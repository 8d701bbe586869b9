"""pvphong's colours against VTK's own shader."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.types import BoolArray, Float64Array, FloatArray, MatrixLike
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.lit import point_normals
from pvphong.meshes.surfaces import surface
from pvphong.optics.material import Material, check_material
from pvphong.scene.scene import Scene, SceneLike
from pvphong.shading.evaluation import evaluate
from pvphong.studies.validate.comparison import Comparison
from pvphong.vtk.oracle import driver, vtk_shade
from pvphong.vtk.rounding import Pose, allowed_error, limits
from pvphong.vtk.scenes import in_vtk_terms, refuse_inexpressible, seen_from_infinity, shining

_DOUBTFUL_FACING = 2.0**-40
"""Cosines between normal and viewer below this have no certain sign in float64."""

_OFF_CENTER = 10.0
"""In sizes of the mesh: float32 loses digits of a mesh that lies farther than this from its own origin."""


def validate(
    mesh: pv.DataSet, scene: SceneLike | None, material: Material, *, matrix: MatrixLike | None = None
) -> Comparison:
    """Compare pvphong's colours with those of VTK's own shader, vertex by vertex.

    pvphong's are `evaluate`'s, in its float32 default, before they are clamped. VTK's are `vtk_shade`'s.
    The scene is compared as it is, in its own convention, whatever VTK needs to be told for it: ambient light and
    emission as the material's unlit ambient, a viewer at infinity as an eye far away, two-sided lighting
    as normals turned to the viewer, a mesh far from the origin around its middle. `Comparison.conversions` says what.

    Left out are vertices where float32 leaves VTK's colour open: those where a highlight begins at n·l = 0, those
    on the edge of a cone, those whose normals turn to the viewer at n·v = 0, those where VTK's own rounding of places
    and directions may cost more than the bound, and, in the standard convention, those where VTK's floor of 1e-5
    under a cosine shows (at powers of 1 and less). `Comparison.left_out` counts them.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface. Its active point normals are used, computed ones where it has none.
    scene : Scene, light, sequence of lights, or None
        None is the scene of `pvphong.default_scene`. Lights, viewer and light model, in either convention.
    material : Material
        The surface's reflectances.
    matrix : array_like, optional
        (4, 4) model matrix.

    Returns
    -------
    Comparison
        `.passed`, `.max_error`, `.worst` and more; print it for the verdict, `.explain()` for all of it.

    Raises
    ------
    InexpressibleError
        A ValueError: for a scene that VTK's shader cannot draw (lights with an ambient colour of their own or
        highlights in another than their diffuse colour, Blinn-Phong, `PBR` in the standard convention, a viewer at
        infinity beside lights with a position, powers above 128, a matrix that flattens or scales beyond 1e-18 to
        1e18, a mirrored surface as VTK turns it), where it would have an effect. It holds the nearest scene that VTK
        can draw.
    ValueError
        As `evaluate`, or for a mesh with nothing to light.

    See Also
    --------
    pvphong.vtk.oracle.vtk_shade : VTK's colours alone.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> ph.validate(pv.Sphere(), ph.Scene(lights=[ph.DirectionalLight()]), ph.Material()).passed
    True
    """
    check_material(material)
    source = surface(mesh)
    scene = scene_for(source, scene, matrix)
    given = None if matrix is None else check.matrix4("matrix", matrix)
    refuse_inexpressible(scene, material, given)
    points, normals = check.array("points", source.points), check.array("normals", point_normals(source))
    unclamped = replace(scene, light_model=replace(scene.light_model, clamp=False))
    own = evaluate(points, normals, unclamped, material, matrix=given).rgb
    lit = np.logical_and.reduce(np.isfinite(points) & np.isfinite(normals), axis=1) & (normals != 0.0).any(axis=1)
    placed = _placed(points[lit], normals[lit], scene, np.eye(4) if given is None else given / given[3, 3])
    judgement = _judge(placed, scene, material, _tolerance(scene, material))
    return _comparison(source, lit, own, placed, judgement)


class _Placed(NamedTuple):
    """The vertices that can be lit, as VTK is given them."""

    pose: Pose
    doubtful: BoolArray
    """Where it is not certain to which side a normal turns."""
    conversions: tuple[str, ...]


class _Judgement(NamedTuple):
    """What VTK says of the vertices that can be lit."""

    colors: FloatArray
    scale: Float64Array
    open: dict[str, BoolArray]
    tier: int
    conversions: tuple[str, ...]
    tolerance: float


def _placed(points: FloatArray, normals: FloatArray, scene: Scene, matrix: Float64Array) -> _Placed:
    """Around their middle, with unit normals, which a two-sided scene turns to the viewer."""
    said = []
    center, size = _box(points.astype(np.float64))
    if np.abs(center).max() > _OFF_CENTER * size:
        said.append(f"the mesh around its middle, ({', '.join(f'{c:.6g}' for c in center)})")
    around = matrix.copy()
    around[:3, 3] += matrix[:3, :3] @ center
    scaled = normals / np.abs(normals).max(axis=1, keepdims=True).astype(np.float64)
    pose = Pose(points - center, scaled / np.linalg.norm(scaled, axis=1)[:, None], around)
    if not scene.light_model.two_sided:
        return _Placed(pose, np.zeros(len(points), dtype=bool), tuple(said))
    positions, directions = pose.in_world()
    to_viewer = np.array(scene.viewer.position) - positions
    if seen_from_infinity(scene):
        to_viewer = np.broadcast_to(-np.array(scene.viewer.view_direction), positions.shape)
    facing = np.einsum("ij,ij->i", directions, to_viewer)
    away = facing < 0.0
    if away.any():
        said.append(f"{np.count_nonzero(away)} normals turned to the viewer")
    doubtful = np.abs(facing) <= _DOUBTFUL_FACING * np.linalg.norm(to_viewer, axis=1)
    turned = np.where(away[:, None], -pose.normals, pose.normals)
    return _Placed(pose._replace(normals=turned), doubtful, tuple(said))


def _box(points: Float64Array) -> tuple[Float64Array, float]:
    """The middle of the points' bounding box and its largest edge."""
    if not len(points):
        return np.zeros(3), 0.0
    low, high = points.min(axis=0), points.max(axis=0)
    return low + 0.5 * (high - low), float((high - low).max())


def _tolerance(scene: Scene, material: Material) -> float:
    """16 · power · 2⁻²⁴ + 1e-6, see `pvphong.vtk.oracle`; and `allowed_error` where shading is physically based."""
    exponents = [light.as_vtk().exponent for light in shining(scene)]
    physical = material.reflectance and material.reflectance.in_vtk()
    shininess, more = (0.0, allowed_error(physical.roughness)) if physical else (material.shininess, 1e-6)
    return 16.0 * max(shininess, *exponents, 0.0) * 2.0**-24 + more


def _judge(placed: _Placed, scene: Scene, material: Material, tolerance: float) -> _Judgement:
    pose = placed.pose
    _, size = _box(pose.in_world()[0])
    terms = in_vtk_terms(scene, material, pose.matrix[:3, 3], size)
    colors = np.zeros((0, 3), dtype=np.float32)
    if len(pose.points):
        cloud = pv.PolyData(pose.points)
        cloud.point_data.active_normals = pose.normals
        colors = vtk_shade(cloud, terms.lights, terms.material, terms.viewer, matrix=pose.matrix)
    known = limits(pose, terms, tolerance, has_floors=scene.light_model.convention == "vtk")
    reasons = {"n·v = 0": placed.doubtful} | known.open
    reasons["float32"] = known.open["float32"] | ~np.isfinite(colors).all(axis=1)
    said = placed.conversions + terms.conversions
    return _Judgement(colors, known.scale, reasons, terms.tier, said, tolerance)


def _comparison(
    source: pv.PolyData, lit: BoolArray, own: FloatArray, placed: _Placed, judgement: _Judgement
) -> Comparison:
    rows = np.flatnonzero(lit)
    vtk, positions, normals = np.full((3, len(lit), 3), np.nan)
    vtk[rows] = judgement.colors
    positions[rows], normals[rows] = placed.pose.in_world()
    compared = ~np.logical_or.reduce(list(judgement.open.values()), axis=0)
    errors = (own[rows].astype(np.float64) - judgement.colors) / judgement.scale[:, None]
    left_out = {reason: rows[mask] for reason, mask in judgement.open.items()}
    left_out["no place or normal"] = np.flatnonzero(~lit)
    return Comparison(
        tolerance=judgement.tolerance,
        tier=judgement.tier,
        conversions=judgement.conversions,
        driver=driver(),
        vertices=rows[compared],
        errors=errors[compared],
        left_out={reason: points for reason, points in left_out.items() if len(points)},
        pvphong=own,
        vtk=vtk.astype(np.float32),
        _surface=source,
        _positions=positions,
        _normals=normals,
    )
