"""`mesh.phong.fit` and `blocks.phong.fit`: lights that give a mesh the colours that it should have."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.types import Backend, Float64Array, FloatArray, MatrixLike
from pvphong.geometry.extent import Sphere, box_of, sphere_around
from pvphong.geometry.transform import normal_matrix
from pvphong.meshes.blocks import datasets, of_each
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.lit import Setting, vertices_of
from pvphong.meshes.point_data import surface_and_maps
from pvphong.meshes.surfaces import ORIGINAL_POINT, FeatureAngle, shallow_copy
from pvphong.meshes.transport import Exchanging, checked_transport
from pvphong.meshes.visibility import KnownOccluders, checked_occluders, receiver_of, tracer_of
from pvphong.optics.material import Material, as_material
from pvphong.rays.casting import Occluders
from pvphong.rays.transport import Transport
from pvphong.rays.visibility import Visibility
from pvphong.scene.scene import Scene, SceneLike
from pvphong.shading import kernel
from pvphong.shading.vertices import Vertices
from pvphong.shading.visibility import checked_visibility
from pvphong.studies.fitting import choosing, search
from pvphong.studies.fitting.columns import Columns, Subject, point_areas
from pvphong.studies.fitting.linear import Problem, refuse_without_scipy
from pvphong.studies.fitting.result import Analysis, Fit
from pvphong.studies.fitting.target import Wanted, checked_target, checked_weights, wanted_of
from pvphong.studies.fitting.variation import Variation, variations

# Number of evaluations of a search, about.
_EVALUATIONS = 1000

TRIES = 12
"""Default number of starts."""


def fit(
    mesh: pv.DataSet,
    scene: SceneLike | None,
    material: Material | str,
    target: Any,
    vary: Any,
    *,
    weights: Any = None,
    max_lights: int | None = None,
    tolerance: float = 0.0,
    tries: int = TRIES,
    seed: int = 0,
    matrix: MatrixLike | None = None,
    feature_angle: FeatureAngle = None,
    occluders: Any = (),
    visibility: Visibility | None = None,
    transport: Transport | None = None,
    backend: Backend = "auto",
) -> Fit:
    """Find the lights with which a mesh gets the colours that it should have.

    The error is the weighted sum of squared differences from the target, over points and channels; a point's weight is
    its area times the given weight. Intensities and colours are the solution of a bounded linear problem: if nothing
    else varies, no other values have a smaller error, except where clamping at 1 changes a colour whose target is below
    1. Directions, positions, cones, sizes and exponents are searched from several starts, so a better solution may
    exist. The light model counts: shadows, occlusion and bounces are computed, and colours are clamped.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface; it is not modified.
    scene : Scene, light, sequence of lights, or None
        Lights, viewer and light model. The search begins at its lights.
    material : Material or str
        The surface's material, or the name of one.
    target : array_like, str or float
        Colours (n_points, 3) or luminances (n_points,) that the points should have, linear, 1 for white; or the name of
        such a point array; or one luminance for all. NaN where any colour is allowed. If the light model clamps, 1 or
        more means "at least 1". `pvphong.target` makes one from selections.
    vary : mapping or str
        A light's name, or its index if it has none → the fields that vary, as in
        ``{"key": "intensity diffuse direction"}``; or the fields that vary in all lights that are on. The fields are
        "intensity", "diffuse", "specular", "ambient", and those of the kind of light: "direction", "position",
        "cone_angle", "exponent", "radius", "width", "height", "up", "rotation". All other fields keep exactly their
        values. If intensity and colours vary, the largest channel of the colours is kept.
    weights : array_like or str, optional
        Importance of each point, >= 0, shape (n_points,), or the name of a point array. By default, all points with a
        target have the same weight.
    max_lights : int, optional
        Choose at most this number of the lights that vary, and only as many as the tolerance needs; all others are
        switched off. Lights are chosen one by one, and chosen lights are exchanged for others while the error falls.
        Only intensities and colours can then vary.
    tolerance : float, default 0
        Root mean square of the differences that is small enough. When it is reached, no more starts are tried, and no
        more lights are added towards `max_lights`.
    tries : int, default 12
        Number of starts of the search. A larger number finds better solutions if many lights move.
    seed : int, default 0
        Seed of the starts and of the vertices that the search uses. With a named backend, equal calls give equal bits,
        for any number of threads.
    matrix, feature_angle, occluders, visibility, transport, backend
        As for `mesh.phong.shade`. With `visibility`, directions, positions and sizes cannot vary.

    Returns
    -------
    Fit
        `.scene` with the lights that were found, `.lit`, `.error`; `print(fit)` is the report, `.plot()` shows target,
        result and difference. Interrupted with Ctrl-C, the search returns the best lights so far.

    Raises
    ------
    ValueError
        If an argument is invalid, no light varies, a light lacks a field or reaches no point of the target, nothing is
        asked for, or fewer numbers are asked for than vary; or if SciPy is missing.

    References
    ----------
    C. Lawson and R. Hanson, "Solving Least Squares Problems", 1974 (linear part). G. Golub and V. Pereyra, SIAM J.
    Numer. Anal. 10 (1973) 413 (variable projection). C. Schoeneman et al., "Painting with light", 1993 (its use for
    lights).

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> ball = pv.Sphere()
    >>> ball["wanted"] = ball.phong.shade(ph.DirectionalLight(direction=(1, 0, -1), intensity=0.6))["phong"]
    >>> lamp = ph.DirectionalLight(name="lamp")
    >>> fit = ball.phong.fit(lamp, ph.Material(), "wanted", {"lamp": "intensity direction"})
    >>> round(fit.scene.lights[0].intensity, 4), fit.error.rms < 1e-6
    (0.6, True)
    """
    options = Options(weights, max_lights, tolerance, tries, seed)
    setting = Setting(matrix, feature_angle, occluders, visibility, transport, 0.0, backend)
    if isinstance(target, Mapping):
        check.refuse("target", "a mapping", "an array, its name or a number", "ph.target(mesh, {...}) makes an array.")
    begun = time.perf_counter()
    part = _Part.of("", mesh, material, setting)
    framed = scene_for(part.source, scene, matrix)

    def light(found: Scene) -> Any:
        how: dict[str, Any] = {"matrix": matrix, "feature_angle": feature_angle, "occluders": occluders}
        how |= {"visibility": visibility, "transport": transport, "backend": backend}
        return mesh.phong.shade(found, material, **how)

    return _fitted([part], framed, target, vary, setting, options, light, begun)


def fit_blocks(
    blocks: pv.MultiBlock,
    scene: Scene,
    materials: Sequence[Material],
    target: Any,
    vary: Any,
    options: dict[str, Any],
    light: Callable[[Scene], Any],
) -> Fit:
    """Find the lights with which several meshes get the colours that they should have; see `fit`.

    Parameters
    ----------
    blocks : pyvista.MultiBlock
        The meshes.
    scene : Scene
        The scene, with a viewer.
    materials : sequence of Material
        The material of each dataset, in order.
    target : mapping or float
        Path of a dataset → its target. A dataset without an entry may have any colours. A number is the luminance of
        all points.
    vary, options
        As for `fit`; weights are a mapping too.
    light : callable
        Returns the lit blocks for a scene.
    """
    begun = time.perf_counter()
    own = {each.name for each in fields(Options)}
    wishes = Options(**{name: value for name, value in options.items() if name in own})
    setting = Setting(**{name: value for name, value in options.items() if name not in own})
    paths = [path for path, _ in datasets(blocks)]
    of_block = iter(zip(paths, materials, strict=True))

    def part_of(block: pv.DataSet) -> _Part:
        path, material = next(of_block)
        return _Part.of(path, block, material, setting)

    parts = of_each(blocks, part_of)
    for name, mapping in (("target", target), ("weights", wishes.weights)):
        if isinstance(mapping, Mapping):
            for path in mapping:
                if path not in paths:
                    check.refuse(name, f"a mapping with {path!r}", f"a mapping whose keys are paths of blocks: {paths}")
        elif mapping is not None and np.ndim(mapping):
            or_number = ", or one number" * (name == "target")
            check.refuse(name, type(mapping).__name__, f"a mapping from paths of blocks to arrays{or_number}")
    return _fitted(parts, scene, target, vary, setting, wishes, light, begun)


def _whole_or_none(name: str, value: Any) -> int | None:
    return None if value is None else check.whole(name, value, at_least=1)


@dataclass(frozen=True)
class Options:
    """Options of a fit that do not concern the lighting. The fields are those parameters of `fit`."""

    weights: Any = None
    max_lights: int | None = check.field(_whole_or_none, None)
    tolerance: float = check.field(functools.partial(check.number, at_least=0.0), 0.0)
    tries: int = check.field(functools.partial(check.whole, at_least=1), TRIES)
    seed: int = check.field(functools.partial(check.whole, at_least=0), 0)

    def __post_init__(self) -> None:
        check.fields(self)


@dataclass(frozen=True, eq=False)
class _Part:
    """One mesh of a fit.

    `path` is its path in the blocks ("" for a single mesh), and `source` its surface. `maps` and `tangents` are the
    material's maps and the tangents at the surface's points. `rows` are the mesh's points that the surface has.
    """

    path: str
    mesh: pv.DataSet
    source: pv.PolyData
    maps: dict[str, Any]
    tangents: Any
    material: Material
    rows: Any

    @classmethod
    def of(cls, path: str, mesh: pv.DataSet, material: Material | str, setting: Setting) -> _Part:
        now = shallow_copy(mesh) if isinstance(mesh, pv.PolyData) else mesh
        material = as_material(material)
        source, maps, tangents = surface_and_maps(now, material, setting.feature_angle)
        rows: Any = slice(None)
        if not isinstance(mesh, pv.PolyData | pv.PointSet):
            rows = np.asarray(source.point_data["vtkOriginalPointIds"])
        elif source is not now and source.n_points != mesh.n_points:
            rows = np.asarray(source.point_data[ORIGINAL_POINT])
        return cls(path, mesh, source, maps, tangents, material, rows)

    def vertices(self, scene: Scene, setting: Setting) -> Vertices:
        plain = replace(scene, light_model=scene.light_model.without_rays())
        direct = Setting(matrix=setting.matrix, backend=setting.backend)
        return vertices_of(self.source, self.maps, self.tangents, plain, direct)

    def given(self, value: Any) -> Any:
        """Return `value`, or its entry for this mesh if it is a mapping from paths."""
        return value.get(self.path) if isinstance(value, Mapping) else value


def _fitted(
    parts: Sequence[_Part],
    scene: Scene,
    target: Any,
    vary: Any,
    setting: Setting,
    options: Options,
    light: Callable[[Scene], Any],
    begun: float,
) -> Fit:
    """Fit lights to the targets of all meshes.

    `parts` are the meshes, and `vary` is as for `fit`. `setting` has the options of the lighting, and `light` lights
    the meshes with a scene. `begun` is the time at which the fit began, in seconds.
    """
    refuse_without_scipy()
    kernel.check_backend(setting.backend)
    if setting.matrix is not None:
        normal_matrix(setting.matrix)
    vertices = [part.vertices(scene, setting) for part in parts]
    for part, each in zip(parts, vertices, strict=True):
        if each.equation(scene, part.material, setting.matrix).gamma != 1.0:
            remedy = "Use LightModel(), or another reflectance."
            check.refuse(
                "material", "PBR in VTK's convention", "a material without a gamma, so that light adds up", remedy
            )
    around = _around(vertices, setting.matrix)
    varied = variations(scene, vary, around)
    wanted = _wanted(parts, vertices, target, options.weights, setting.matrix, clamps=scene.light_model.clamp)
    _refuse_conflicts(varied, wanted, setting, options)
    moves = any(one.count for one in varied)
    columns = _columns(parts, vertices, scene, setting, _EVALUATIONS if moves else len(varied))
    goal, most = options.tolerance**2, options.max_lights
    how: dict[str, Any] = {"tries": options.tries, "seed": options.seed, "goal": goal}
    found, point, interrupted = search.find(columns, varied, wanted, around, **how)
    _refuse_dark(varied, point, wanted)
    problem = Problem.of(found.base, varied, point.shares, wanted)
    off = list[Variation]()
    given, shares = found, point.shares
    if most is not None:
        chosen, problem, solution = choosing.choose(point, problem, varied, most, goal)
        off = [one for number, one in enumerate(varied) if number not in chosen]
        found = replace(found, varied=[varied[number] for number in chosen])
        kept = [point.lights[number] for number in chosen], [point.shares[number] for number in chosen]
        point = search.Point(tuple(kept[0]), tuple(kept[1]), solution)
    lights, first = list(scene.lights), 0
    is_known = (point.solution.x > 0.0) | (np.diag(point.solution.normal.matrix) > 0.0)
    for one in off:
        lights[one.index] = replace(one.light, on=False)
    for one, shaped in zip(found.varied, point.lights, strict=True):
        last = first + len(one.unknowns)
        lights[one.index] = one.solved(shaped, point.solution.x[first:last], is_known[first:last])
        first = last
    analysis = Analysis(found, problem, point, given, shares, off)
    rows = dict(zip([part.path for part in parts], _split([len(each) for each in vertices]), strict=True))
    return Fit.of(
        replace(scene, lights=lights),
        analysis,
        light,
        rows,
        interrupted,
        time.perf_counter() - begun,
        options.tolerance,
    )


def _refuse_conflicts(varied: Sequence[Variation], wanted: Wanted, setting: Setting, options: Options) -> None:
    """Raise ValueError if the fields that vary do not go together with the target or the options.

    `varied` are the lights with the fields that vary, `wanted` is the target, and `setting` has the options of the
    lighting.
    """
    moves = any(one.count for one in varied)
    if options.max_lights is not None and moves:
        remedy = "Fit directions, positions and sizes first, without max_lights."
        check.refuse("vary", "directions, positions or sizes", "intensities and colours if max_lights is given", remedy)
    for one in varied if options.max_lights is not None else ():
        if one.rest(one.light) is not None:
            remedy = "A light that is not chosen must go out completely."
            check.refuse(
                "vary",
                f"only some colours of {one.label!r}",
                "an intensity, or all colours, of each light if max_lights is given",
                remedy,
            )
    if setting.visibility is not None and moves:
        remedy = "Leave it out: rays are then cast for each move of a light."
        check.refuse("visibility", "a Visibility", "None if directions, positions or sizes vary", remedy)
    if wanted.is_luminance and any(one.colors for one in varied):
        remedy = "Vary only intensities, or pass colours as the target."
        check.refuse("target", "luminances, which determine no hue", "colours if colours of lights vary", remedy)
    count, asked = sum(len(one.unknowns) + one.count for one in varied), int((wanted.roots > 0.0).sum())
    if asked < count:
        got = f"a target with {asked} numbers"
        allowed = f"a target with at least {count} numbers, because {count} numbers of lights vary"
        check.refuse("target", got, allowed, "Vary fewer fields.")


def _refuse_dark(varied: Sequence[Variation], point: search.Point, wanted: Wanted) -> None:
    """Raise ValueError if one of the lights that vary gives no light to any point of the target.

    `point` is the result of the search.
    """
    lengths, first = np.diag(point.solution.normal.matrix), 0
    for one, share in zip(varied, point.shares, strict=True):
        last = first + len(one.unknowns)
        # columns are 0 for a dark light, and where all colours are clamped
        if one.linear and not lengths[first:last].any() and not any(c[wanted.counts].any() for c in share.columns):
            remedy = "Move or turn this light, vary its direction or position, or leave it out."
            got = f"{one.label!r}, which lights none of these points"
            check.refuse("vary", got, "lights that light points of the target", remedy)
        first = last


def _split(counts: Sequence[int]) -> list[slice]:
    ends = np.cumsum(counts).tolist()
    return [slice(end - count, end) for count, end in zip(counts, ends, strict=True)]


def _around(vertices: Sequence[Vertices], matrix: MatrixLike | None) -> Sphere:
    """Return a sphere around all finite vertices in the world."""
    bounds = [each.bounds(matrix) for each in vertices]
    corners = np.concatenate([[each[::2], each[1::2]] for each in bounds])
    corners = corners[np.isfinite(corners).all(axis=1)]
    if not len(corners):
        check.refuse("mesh", "a mesh without finite points", "a mesh with points to light")
    found = sphere_around(box_of(corners))
    return found if found.radius > 0.0 else found._replace(radius=1.0)


def _wanted(
    parts: Sequence[_Part],
    vertices: Sequence[Vertices],
    target: Any,
    weights: Any,
    matrix: MatrixLike | None,
    *,
    clamps: bool,
) -> Wanted:
    values, areas = list[Float64Array](), list[Float64Array]()
    for part, each in zip(parts, vertices, strict=True):
        given = part.given(target)
        asked = checked_target(np.nan if given is None else given, part.mesh)
        own = checked_weights(None if given is None else part.given(weights), asked, part.mesh)
        values.append(asked[part.rows])
        areas.append(own[part.rows] * point_areas(part.source, matrix))
        finite = np.isfinite(each.points)
        if not finite.all():
            areas[-1][~finite.all(axis=1)] = 0.0
    if len({each.shape[1] for each in values if not np.isnan(each).all()}) > 1:
        got, remedy = "luminances of some blocks and colours of others", "For grey, repeat each luminance 3 times."
        check.refuse("target", got, "all luminances, or all colours", remedy)
    if len({each.shape[1] for each in values}) > 1:  # a block of which nothing is asked has either shape
        values = [np.broadcast_to(each, (len(each), 3)) for each in values]
    return wanted_of(np.concatenate(values), np.concatenate(areas), clamps)


def _columns(
    parts: Sequence[_Part], vertices: Sequence[Vertices], scene: Scene, setting: Setting, expected: int
) -> Columns:
    model, matrix = scene.light_model, setting.matrix
    transport = None
    if model.bounces:
        surfaces = [
            Exchanging(part.source, functools.partial(_normals_of, each), matrix)
            for part, each in zip(parts, vertices, strict=True)
        ]
        transport = checked_transport(setting.transport, surfaces, setting.occluders)
    tracers: list[Any] = [None] * len(parts)
    if model.needs_rays and setting.visibility is None:
        receivers = [
            receiver_of(part.source, functools.partial(_normals_of, each), matrix, number)
            for number, (part, each) in enumerate(zip(parts, vertices, strict=True))
        ]
        blocking = [each for each in receivers if each.part is not None]
        occluders = Occluders([*(each.faces for each in blocking), *checked_occluders(setting.occluders)])
        places = [next((k for k, other in enumerate(blocking) if other is each), None) for each in receivers]
        tracers = [
            tracer_of(receiver, scene, KnownOccluders(occluders, place))
            for receiver, place in zip(receivers, places, strict=True)
        ]
    subjects = []
    for part, each, tracer in zip(parts, vertices, tracers, strict=True):
        given = part.given(setting.visibility)
        seen = None if given is None else checked_visibility("visibility", given, each.points, matrix, scene)
        subjects.append(Subject(each, part.material, tracer, seen if model.needs_rays else None, matrix))
    return Columns(subjects, scene, transport, setting.backend, expected)


def _normals_of(vertices: Vertices) -> FloatArray:
    return vertices.normals
