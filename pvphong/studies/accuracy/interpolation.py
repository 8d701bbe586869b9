"""Interpolation errors inside triangles, for the original mesh and for uniformly and adaptively refined meshes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv

from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.geometry.transform import transform_points
from pvphong.meshes.point_data import given_maps
from pvphong.meshes.surfaces import has_faces, has_only_triangles, shallow_copy
from pvphong.meshes.visibility import KnownOccluders
from pvphong.optics.maps import Map, fractions
from pvphong.optics.material import Material
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices
from pvphong.shading.visibility import GivenVisibility
from pvphong.studies.accuracy.result import Errors, Row
from pvphong.studies.accuracy.timing import Clock, timed
from pvphong.studies.accuracy.variants import Subject, Variant
from pvphong.studies.refine import OF_RAYS, interpolation_error, refine

AS_IT_IS = "as it is"
ADAPTIVE = "refined adaptively"
UNIFORM = "refined {}×"

_ERROR = "phong_interpolation_error"
_HIDDEN = "_pvphong_"
_LEVELS = (1, 2, 3)
_MOST_POINTS = 5_000_000

# Generous estimate of the seconds to split a triangle of a large mesh.
_PER_SPLIT = 4e-6

# Smallest and largest number of triangles in which errors are searched, and the largest fraction of the remaining time
# that the search may take. The triangles of a large mesh are chosen at random. Uniformly refined meshes are searched in
# fewer places: in the _WORST worst triangles of the original mesh, and in _OTHERS of its other triangles, chosen at
# random.
_FEWEST_SEARCHED, _MOST_SEARCHED, _FOR_SEARCH = 2_000, 50_000, 0.3
_WORST, _OTHERS = 400, 300

# Measured: evaluations per searched triangle.
_EVALUATIONS = 40.0

# Measured: positions per triangle from which rays are cast, and the power p in "the standard error of n rays falls as
# n**-p". Rays inside triangles are always cast to a standard error of a quarter of a display step. Their time is
# estimated from rays at up to _PROBED vertices.
_PLACES, _FALLS, _PROBED = 15.0, 3.0 / 4.0, 500

# Measured, with a margin: seconds to search a whole surface for the edges of one light's hard shadows.
_PER_EDGE = 1.0

# Measured: the time per point that refinement adds, as a multiple of the time to search one triangle, and its minimum
# in seconds.
_SEARCHES_PER_POINT, _LEAST_PER_POINT = 3.0, 5e-5

# Reason why the refinement stopped → the note of the variant, and the reason for leaving it out if no point was added.
_STOPPED = {
    "tolerance": ("reached the tolerance", "the original mesh is within the tolerance"),
    "max_points": ("stopped by the time budget", "there was no time to split a triangle"),
    "jump": ("within the tolerance except at jumps of the colour", "only jumps of the colour are left to split"),
    "resolution": ("within the tolerance except in the smallest triangles", "its triangles are as small as possible"),
}


class Triangles(NamedTuple):
    """Some triangles of a surface, with the data to light them.

    Parameters
    ----------
    points, normals : ndarray
        Points of the triangles and the normals there, shape (n, 3), in the mesh's type, float32 or float64.
    corners : ndarray
        Shape (m, 3), indices of points.
    areas : ndarray
        Shape (m,): the fraction of the surface's area that each triangle represents.
    material : Material
        Material, with maps for the points.
    """

    points: FloatArray
    normals: FloatArray
    corners: IntArray
    areas: Float64Array
    material: Material


class Interpolation(NamedTuple):
    """Measurements inside the triangles of a mesh and of its refinements.

    Parameters
    ----------
    variants : list of Variant
        The original and the refined meshes, with their interpolation errors.
    errors, areas : ndarray
        Shape (m,): the largest error in each searched triangle, and each triangle's fraction of the area of all
        searched triangles.
    left_out : dict of str to str
        Variants that are left out, and the reasons.
    """

    variants: list[Variant]
    errors: Float64Array
    areas: Float64Array
    left_out: dict[str, str]


def seconds_of_rays(subject: Subject, tolerance: float) -> float:
    """Estimate the seconds that rays inside triangles take in addition to a float64 evaluation of all vertices.

    The search of a triangle evaluates about _EVALUATIONS points, and casts rays from _PLACES of them. If the scene
    needs no rays, the result is 0.

    Parameters
    ----------
    subject : Subject
        Mesh, scene and material.
    tolerance : float
        Standard error to which the colours at the vertices were sampled by rays.
    """
    equation, visibility = subject.equation, subject.visibility
    if visibility is None or not equation.needs_visibility:
        return 0.0
    lights, rows = subject.scene.world_lights, np.arange(0, len(subject.points), len(subject.points) // _PROBED + 1)
    probe = visibility.afresh(rows=rows)
    how = {"sky": equation.is_occluded, "behind": equation.is_flipped}
    _, seconds = timed(lambda: probe.channels(equation.shadowed, **how))
    is_sampled = equation.is_occluded or any(lights[k].has_size for k in equation.shadowed)
    more = (tolerance / (OF_RAYS / 255.0)) ** (1.0 / _FALLS) if is_sampled else 1.0
    return seconds * more / len(rows) * len(subject.points) * _PLACES / _EVALUATIONS


def least_seconds(mesh: pv.PolyData, exact_seconds: float) -> float:
    """Estimate the least time that `interpolation` needs for a mesh, in seconds.

    `exact_seconds` is the time of a float64 evaluation of all vertices.
    """
    return _EVALUATIONS * exact_seconds * min(mesh.n_cells, _FEWEST_SEARCHED) / mesh.n_points


def interpolation(
    mesh: pv.PolyData, subject: Subject, tolerance: float, exact_seconds: float, clock: Clock
) -> Interpolation:
    """Measure the errors of colours that are interpolated inside triangles, for the original mesh and refined meshes.

    Parameters
    ----------
    mesh : pyvista.PolyData
        A checked surface.
    subject : Subject
        The mesh's points, normals, scene and material. If the subject has a visibility, rays are cast inside triangles.
    tolerance : float
        Largest colour error inside triangles that the adaptive refinement leaves.
    exact_seconds : float
        Seconds of a float64 evaluation of all vertices, rays included.
    clock : Clock
        Time budget.
    """
    if not has_faces(mesh):
        return Interpolation([], np.zeros(0), np.zeros(0), {"inside triangles": "point clouds have no triangles"})
    triangles = mesh if has_only_triangles(mesh) else mesh.triangulate()
    corners = triangles.regular_faces.astype(np.intp, copy=False)

    clock.say("errors inside triangles")
    affordable = _FOR_SEARCH * clock.left * mesh.n_points / (_EVALUATIONS * exact_seconds)
    most, searched = int(np.clip(affordable, _FEWEST_SEARCHED, _MOST_SEARCHED)), corners
    if len(corners) > most:
        searched = corners[np.sort(np.random.default_rng(0).choice(len(corners), most, replace=False))]
    areas = _areas(subject, subject.points, searched)
    errors, seconds = timed(lambda: _errors(subject, _with_own_corners(subject, searched, areas)))
    some = "" if len(searched) == len(corners) else f"searched in {len(searched)} of {len(corners)} triangles"
    as_it_is = Triangles(subject.points, subject.normals, corners, np.zeros(len(corners)), subject.material)
    found = [_variant(subject, AS_IT_IS, as_it_is, Errors.inside_triangles(errors, areas), some)]
    left_out: dict[str, str] = {}

    budget = clock.part(0.5 * clock.left)
    adaptive = _adaptive(mesh, subject, tolerance, seconds / len(searched), len(corners), budget)
    if isinstance(adaptive, str):
        left_out[ADAPTIVE] = adaptive
    else:
        found.append(adaptive)

    # Uniform refinement: search the worst triangles, and a random sample that represents the others.
    order = np.argsort(-errors, kind="stable")
    worst, others = order[:_WORST], order[_WORST:]
    chosen = others
    if len(others) > _OTHERS:
        chosen = np.random.default_rng(0).choice(others, _OTHERS, replace=False)
    represented = areas[chosen] * (areas[others].sum() / (areas[chosen].sum() or 1.0))
    rows = np.concatenate([worst, chosen])
    sample = _with_own_corners(subject, searched[rows], np.concatenate([areas[worst], represented]))
    whole = as_it_is
    preparation, spent = 0.0, seconds * len(rows) / len(searched)  # seconds to search the sample before it is split
    for level in _LEVELS:
        name = UNIFORM.format(level)
        count = len(whole.points) + 3 * len(whole.corners) // 2  # one point per edge of a closed mesh
        if count > _MOST_POINTS:
            left_out[name] = f"it would have {count / 1e6:.1f} million points"
            continue
        if clock.left < max(4.2 * spent, len(whole.corners) * _PER_SPLIT):
            left_out[name] = "there was no time for it"
            continue
        clock.say(name)
        start = clock.spent
        whole = split(whole)
        preparation += clock.spent - start
        sample = split(sample)
        left = Errors.inside_triangles(_errors(subject, sample), sample.areas)
        spent = clock.spent - start
        found.append(_variant(subject, name, whole, left, "", preparation))
    return Interpolation(found, errors, areas, left_out)


def _variant(
    subject: Subject, name: str, whole: Triangles, errors: Errors, note: str, preparation: float = 0.0
) -> Variant:
    """Return a variant that lights the points of an original or refined mesh.

    Parameters
    ----------
    subject : Subject
        The original mesh with scene and material.
    name : str
        Name of the variant.
    whole : Triangles
        The mesh whose points are lit.
    errors : Errors
        Interpolation errors of that mesh.
    note : str
        Remark for the row.
    preparation : float
        Seconds that it took to make the mesh.
    """
    backend = subject.backend_for(subject.equation, len(whole.points))
    seen = None
    if subject.visibility is not None:  # given, so that no rays are cast; its values do not affect the time
        seen = GivenVisibility("visibility", np.ones((subject.equation.lights + 1, len(whole.points)), np.float32))

    def run() -> FloatArray:
        vertices = Vertices(whole.points, whole.normals, whole.material.maps, seen, tangents=whole.material.tangents)
        plan = Plan.of(subject.scene, whole.material, vertices, matrix=subject.matrix)
        return plan.run(vertices, backend=backend).rgb

    row = Row(
        name, "interpolation", backend, "float32", len(whole.points),
        interpolation=errors, preparation=preparation, note=note,
    )  # fmt: skip
    return Variant(row, run)


def _areas(subject: Subject, points: FloatArray, corners: IntArray) -> Float64Array:
    """Return the fraction of the total area that each triangle has in world coordinates, shape (m,).

    `points`, shape (n, 3), are the triangles' points, and `corners`, shape (m, 3), their point indices. `subject` has
    the model matrix. The fraction is 0 for a triangle with a point that is not finite.
    """
    placed = points.astype(np.float64)
    if subject.assembled.matrix is not None:
        placed = transform_points(placed, subject.assembled.matrix)
    scale = np.abs(placed[np.isfinite(placed)]).max(initial=0.0) or 1.0  # prevents overflow of squares
    a, b, c = (placed / scale)[corners].transpose(1, 0, 2)
    with np.errstate(invalid="ignore"):
        double = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    double[~np.isfinite(double)] = 0.0
    return double / (double.sum() or 1.0)


def _with_own_corners(subject: Subject, corners: IntArray, areas: Float64Array) -> Triangles:
    """Return triangles that share no points, so that each can be searched and split separately.

    Parameters
    ----------
    subject : Subject
        The mesh.
    corners : ndarray
        Point indices of the triangles in the mesh, shape (m, 3).
    areas : ndarray
        Fraction of the surface's area that each triangle represents, shape (m,).
    """
    own, points = np.arange(corners.size).reshape(-1, 3), corners.ravel()
    material = _with_maps(subject.material, lambda values: values[points])
    return Triangles(subject.points[points], subject.normals[points], own, areas, material)


def _with_maps(material: Material, change: Callable[[Any], Any]) -> Material:
    """Return a material whose maps are the results of `change`, a function of an array.

    The maps are converted to floats first, because integers would round interpolated values.
    """
    maps = given_maps(material).items()
    return material.with_values({name: Map(change(fractions(name, np.asarray(each)))) for name, each in maps})


def _errors(subject: Subject, triangles: Triangles) -> Float64Array:
    """Return the largest interpolation error in each of m triangles, shape (m,).

    `subject` has the scene and, for shadows, the whole mesh.
    """
    mesh = pv.PolyData.from_regular_faces(triangles.points, triangles.corners)
    mesh.point_data.active_normals = triangles.normals
    options: dict[str, Any] = {"matrix": subject.matrix}
    if subject.visibility is not None:  # the whole mesh blocks light, not only these triangles
        options["occluders"] = KnownOccluders(subject.visibility.blocking[0], None)
    result = interpolation_error(mesh, subject.scene, triangles.material, **options)
    return np.asarray(result.cell_data[_ERROR], np.float64)


def _adaptive(
    mesh: pv.PolyData, subject: Subject, tolerance: float, seconds_each: float, count: int, clock: Clock
) -> Variant | str:
    """Return an adaptively refined mesh as a variant. It is refined to the tolerance, or as far as time allows.

    If time is too short, or no triangle is split, return the reason instead.

    Parameters
    ----------
    mesh : pyvista.PolyData
        The mesh.
    subject : Subject
        The mesh's points, normals, scene and material.
    tolerance : float
        Tolerance of the refinement.
    seconds_each : float
        Seconds to search one triangle for errors.
    count : int
        Number of triangles of the mesh.
    clock : Clock
        Time budget.
    """
    left = clock.left
    edges = 0
    if subject.visibility is not None:
        lights = subject.scene.world_lights
        edges = sum(not lights[k].has_size for k in subject.equation.shadowed)
    search = count * seconds_each + edges * _PER_EDGE
    if search + count * seconds_each > left:
        return f"searching {count} triangles takes about {search:.2g} s; {left:.2g} s were left"
    per_point = max(_SEARCHES_PER_POINT * seconds_each, _LEAST_PER_POINT)
    most = mesh.n_points + max(int((left - search) / per_point), 0)
    clock.say(ADAPTIVE)
    named, carrier = subject.material, shallow_copy(mesh)
    for name, each in given_maps(subject.material).items():  # as point arrays, so that refinement interpolates them
        carrier.point_data[f"{_HIDDEN}{name}"] = fractions(name, np.asarray(each))
        named = named.with_values({name: f"{_HIDDEN}{name}"})
    options: dict[str, Any] = {"tolerance": tolerance, "max_points": most, "matrix": subject.matrix}
    if subject.visibility is not None:
        options["occluders"] = KnownOccluders(*subject.visibility.blocking)
    result, seconds = timed(lambda: refine(carrier, subject.scene, named, **options))
    note, nothing_added = _STOPPED[str(result.field_data["phong_refinement_stopped"])]
    if result.n_points == mesh.n_points:
        return nothing_added
    normals, points = np.asarray(result.point_data.active_normals), np.asarray(result.points)
    left_over = np.asarray(result.cell_data[_ERROR], np.float64)
    errors = Errors.inside_triangles(left_over, _areas(subject, points, result.regular_faces))
    maps = {name: Map(np.asarray(result.point_data[f"{_HIDDEN}{name}"])) for name in given_maps(named)}
    whole = Triangles(points, normals, result.regular_faces, np.zeros(0), subject.material.with_values(maps))
    return _variant(subject, ADAPTIVE, whole, errors, note, seconds)


def split(triangles: Triangles) -> Triangles:
    """Split every triangle into four at the midpoints of its sides. Neighbouring triangles share the midpoints.

    Normals at midpoints are not normalised. Interpolating them is then the same as interpolating the corners' normals,
    so per-pixel shading of the split mesh equals that of the original.
    """
    corners, count = triangles.corners, len(triangles.points)
    sides = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    keys, places = np.unique(sides[:, 0] * count + sides[:, 1], return_inverse=True)
    low, high = np.divmod(keys, count)
    ab, bc, ca = (places.reshape(-1, 3) + count).T
    a, b, c = corners.T
    four = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3)

    def with_middles(array: Any) -> Any:
        half = array.dtype.type(0.5)
        return np.concatenate([array, array[low] * half + array[high] * half])

    points, normals = map(with_middles, (triangles.points, triangles.normals))
    areas = np.repeat(triangles.areas / 4.0, 4)
    return Triangles(points, normals, four, areas, _with_maps(triangles.material, with_middles))
