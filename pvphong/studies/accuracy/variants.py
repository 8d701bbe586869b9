"""The mesh and scene to measure, and variants: ways to light the vertices, with different arithmetic, light models and
rays.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from pvphong.base.types import Backend, Float64Array, FloatArray, IntArray, Precision
from pvphong.geometry.extent import Sphere
from pvphong.optics.light import Light
from pvphong.optics.material import Material
from pvphong.optics.reflectances.likeness import counterpart_of, stand_in
from pvphong.optics.roles import Place
from pvphong.rays.sampling import MOST_RAYS
from pvphong.rays.visibility import Visibility
from pvphong.scene.scene import Scene
from pvphong.shading import kernel, reference
from pvphong.shading.equation import BLACK, Equation, as_nodes, in_parts, relative_to_mesh
from pvphong.shading.plan.effects import EFFECTS
from pvphong.shading.plan.lights import POSITION
from pvphong.shading.plan.plan import Plan, is_worth_loading
from pvphong.shading.reference import Shading
from pvphong.shading.vertices import Vertices
from pvphong.studies.accuracy.result import NO_ERROR, Errors, Row, Timing
from pvphong.studies.accuracy.timing import Clock, timed

REFERENCE = "float64 reference"

WITHOUT = {effect.name: effect.without for effect in EFFECTS}
"""Name of each of the plan's effects → function that returns an equation without the effect. The function's arguments
are the equation and the middle of the mesh.
"""

# Numbers of point lights that are tried in place of a light with a size.
_NODES = 1, 4, 16, 64

# Least distance of a light, in radii of the mesh, at which the plan tests whether it may be treated as directional.
_FAR = 2.0

# Numbers of rays per vertex that are tried, and the smallest number when rays are cast to a tolerance.
_RAYS, _FEWEST_RAYS = (4, 16, 64, 256), 16

# Largest fraction of the time budget for reference colours by MOST_RAYS rays, and the smallest number of vertices where
# they are computed.
_FOR_ALL_RAYS, _FEWEST_CHECKED = 0.2, 100

# Number of nodes, each with its own ray, that replace a light with a size to compute reference highlights.
_NODES_OF_HIGHLIGHT = 256

# Largest number of repeats of a sampling row, and their largest fraction of the remaining time.
_REPEATS, _FOR_REPEATS = 5, 0.1


@dataclass(frozen=True, eq=False)
class Subject:
    """A mesh, scene and material to measure, as checked arrays.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3).
    scene : Scene
        Lights, viewer and light model.
    material : Material
        Material, whose maps are arrays.
    matrix : ndarray or None
        (4, 4) model matrix; None for the identity.
    visibility : Visibility, optional
        Visibility at the points, if the scene has shadows or ambient occlusion.
    """

    points: FloatArray
    normals: FloatArray
    scene: Scene
    material: Material
    matrix: Float64Array | None
    visibility: Visibility | None = None

    @cached_property
    def vertices(self) -> Vertices:
        """Points, normals and the other per-vertex data for the evaluators."""
        return self.vertices_that_see(self.visibility)

    def vertices_that_see(self, visibility: Visibility | None) -> Vertices:
        """Return the vertices for the evaluators, with the given visibility instead of the subject's own."""
        material = self.material
        return Vertices(self.points, self.normals, material.maps, visibility, tangents=material.tangents)

    def plan(self, tolerance: float = 0.0) -> Plan:
        """Return a plan: the lighting equation of this mesh and scene, simplified within a tolerance.

        The tolerance is the largest absolute colour error that the simplifications may make.
        """
        return Plan.of(self.scene, self.material, self.vertices, matrix=self.matrix, tolerance=tolerance)

    @cached_property
    def assembled(self) -> Equation:
        """Lighting equation with all terms, before a plan simplifies it.

        As in plans, the equation is relative to the mesh if the mesh is far from the origin.
        """
        return relative_to_mesh(self.vertices.equation(self.scene, self.material, self.matrix))

    @cached_property
    def equation(self) -> Equation:
        """Lighting equation without terms that are exactly zero."""
        return self.plan().equation

    @cached_property
    def truth(self) -> Float64Array:
        """Colours of the float64 reference, shape (n, 3)."""
        return self.exact(self.equation)

    def exact(
        self, equation: Equation, rows: IntArray | None = None, channels: FloatArray | None = None
    ) -> Float64Array:
        """Return the colours that the float64 reference computes for an equation, shape (m, 3).

        Parameters
        ----------
        equation : Equation
            Equation to evaluate.
        rows : ndarray, optional
            Shape (m,): indices of the vertices; by default all of them.
        channels : ndarray, optional
            Visibility at these vertices, from `Visibility.channels`, shape (k, m): a row for each light, then a row for
            the sky; if back sides are lit, the same rows for these follow. It is used only with `rows`.
        """
        part: Any = slice(None) if rows is None else rows
        points, normals = self.points[part], self.normals[part]
        seen = self.vertices.channels(equation) if rows is None else channels
        if rows is not None and set(equation.channels) - {"visibility"}:
            terms = tuple(replace(term, is_shadowed=False) for term in equation.terms)
            others = self.vertices.channels(replace(equation, terms=terms, is_occluded=False))
            assert others is not None, "it has other channels"
            seen = others[:, rows] if seen is None else np.concatenate([seen, others[:, rows]])
        result = Shading(np.empty((len(points), 3)))
        tints = {name: tint.at(part) for name, tint in self.vertices.tints(equation).items()}
        reference.shade(points, normals, in_parts(equation), tints, result, seen)
        return result.rgb

    def highlights_beyond_shares(self, seen: Visibility, rows: IntArray) -> Float64Array:
        """Return a correction to the highlights of partly hidden area lights, shape (m, 3).

        Evaluators multiply a highlight by the fraction of its light that is visible to diffuse reflection. This method
        replaces the light by many small ones, and casts a ray to each of them. It returns the highlight of the visible
        small lights minus the evaluators' highlight.

        Parameters
        ----------
        seen : Visibility
            Visibility at the vertices `rows`.
        rows : ndarray
            Shape (m,): indices of the vertices.
        """
        whole, lights = self.vertices.equation(self.scene, self.material, self.matrix), self.equation.shadowed
        result = np.zeros((len(rows), 3))
        for term in whole.terms:
            if term.index not in lights or not term.light.has_size or not whole.has(term, "specular"):
                continue
            alone = replace(whole, terms=(whole.without(term, "diffuse"),), ambient=BLACK, emission=BLACK, clamp=False)
            alone = as_nodes(replace(alone, is_occluded=False), _NODES_OF_HIGHLIGHT)
            terms = [node for node in alone.terms if any(node.shines)]
            nodes = replace(alone, terms=tuple(replace(each, index=k) for k, each in enumerate(terms)))
            nodes = replace(nodes, lights=len(terms))
            own = seen.for_lights([each.light for each in terms], [str(k) for k in range(len(terms))])
            of_node = own.channels(range(len(terms)), sky=False, behind=nodes.is_flipped)
            share = seen.channels([term.index], sky=False, behind=nodes.is_flipped)
            parts = share.reshape(-1, len(seen.lights) + 1, len(rows))[:, term.index]
            of_all = np.broadcast_to(parts[:, None], (len(parts), len(terms) + 1, len(rows))).reshape(of_node.shape)
            result += self.exact(nodes, rows, of_node) - self.exact(nodes, rows, of_all)
        return result

    @cached_property
    def sphere(self) -> Sphere:
        """Bounding sphere of the mesh in world coordinates; a point at the origin if the sphere is unknown."""
        return self.vertices.extent(self.assembled.matrix).sphere or Sphere((0.0, 0.0, 0.0), 0.0)

    @cached_property
    def has_kernel(self) -> bool:
        """True if the kernel, that is, compiled code, is available and supports the equation.

        The first access compiles it for the subject's types.
        """
        seen = self.vertices.channels(self.equation)
        first = None if seen is None else seen[:, :1]
        tints = {name: tint.at(slice(1)) for name, tint in self.vertices.tints(self.equation).items()}
        arrays, compiled = (self.points[:1], self.normals[:1], self.equation, tints), kernel.evaluator()
        results = (Shading(np.empty((1, 3), real)) for real in ("float32", "float64"))
        return compiled is not None and all(compiled(*arrays, result, channels=first) for result in results)

    def backend_for(self, equation: Equation, count: int | None = None) -> Backend:
        """Return the default evaluator for an equation and `count` vertices; by default, for all vertices."""
        count = len(self.points) if count is None else count
        return "numba" if self.has_kernel and is_worth_loading(count, equation) else "numpy"

    def run_of(
        self,
        equation: Equation,
        precision: Precision = "float32",
        *,
        backend: Backend | None = None,
        scene: Scene | None = None,
    ) -> Callable[[], FloatArray]:
        """Return a function that lights the subject as `evaluate` does: it assembles, plans and evaluates an equation.

        Parameters
        ----------
        equation : Equation
            Equation to plan and evaluate: the assembled equation, or a rewritten one.
        precision : {"float32", "float64"}
            Type of the colours.
        backend : str, optional
            Evaluator; by default the one that `evaluate` uses.
        scene : Scene, optional
            The function also assembles the equation of this scene, so that its time includes that step. By default, it
            is the subject's scene.
        """

        def run() -> FloatArray:
            relative_to_mesh(self.vertices.equation(scene or self.scene, self.material, self.matrix))
            chosen = backend or self.backend_for(equation)
            return Plan.of_equation(equation, self.vertices).run(self.vertices, precision=precision, backend=chosen).rgb

        return run


class Variant(NamedTuple):
    """One way to light the mesh, to be measured.

    Parameters
    ----------
    row : Row
        Row of the report, not yet timed.
    run : callable
        Function that lights the mesh once. A run at the vertices returns the colours, shape (n, 3).
    equation : Equation, optional
        Equation that the run evaluates; None if the errors at the vertices are known already.
    """

    row: Row
    run: Callable[[], Any]
    equation: Equation | None = None


def plan_name(tolerance: float) -> str:
    """Return the name of the variant that evaluates the plan, the equation simplified within a tolerance."""
    return f"plan at {_in_steps(tolerance)}"


def _in_steps(tolerance: float) -> str:
    """Return a tolerance as text: a multiple of 1/255 (a display step) if it is one, else a number."""
    steps = tolerance * 255.0
    whole = round(steps)
    return f"{whole}/255" if whole and abs(steps - whole) < 1e-9 else f"{tolerance:.3g}"


def variants(subject: Subject, tolerance: float) -> tuple[list[Variant], dict[str, str]]:
    """Return pvphong's ways to light the subject's vertices, and the names of those left out with the reasons.

    The evaluators and precisions come first. Simpler light models follow, in float32 by the default evaluator, and
    finally the plan at the tolerance.
    """
    whole, count, reasons, found = subject.assembled, len(subject.points), dict[str, str](), list[Variant]()
    computed: list[tuple[str, Backend, Precision]] = [
        (REFERENCE, "numpy", "float64"),
        ("float32 NumPy", "numpy", "float32"),
        ("float64 kernel", "numba", "float64"),
        ("float32 kernel", "numba", "float32"),
    ]
    if not subject.has_kernel:
        reasons["kernel"] = "Numba is not installed, or has no code for this scene"
        computed = computed[:2]
    for name, backend, precision in computed:
        run = subject.run_of(whole, precision, backend=backend)
        found.append(Variant(Row(name, "arithmetic", backend, precision, count), run, subject.equation))
    for name, equation, reason in _simpler_models(subject):
        if reason:
            reasons[name] = reason
            continue
        backend = subject.backend_for(Plan.of_equation(equation, subject.vertices).equation)
        row = Row(name, "light model", backend, "float32", count)
        found.append(Variant(row, subject.run_of(equation), equation))
    plan = subject.plan(tolerance)
    backend = subject.backend_for(plan.equation)
    row = Row(plan_name(tolerance), "light model", backend, "float32", count, error_bound=plan.error_bound)

    def run_plan() -> FloatArray:
        return subject.plan(tolerance).run(subject.vertices, backend=backend).rgb

    found.append(Variant(row, run_plan, plan.equation))
    return found, reasons


def _simpler_models(subject: Subject) -> Iterator[tuple[str, Equation, str]]:
    """Yield three items for each simpler light model: its name, its equation, and the reason to leave it out.

    The reason is "" if the model applies to the scene.
    """
    whole, needed, (middle, radius) = subject.assembled, subject.equation, subject.sphere
    no_highlight = "" if needed.has_highlights else "there is no highlight that depends on the viewer"
    at_infinity = "" if needed.eye is not None else "the viewer is at infinity already"
    yield "infinite viewer", WITHOUT["local viewer"](whole, middle), no_highlight or at_infinity

    if other := counterpart_of(whole.reflectance):
        name, reflectance = other
        yield name, replace(whole, reflectance=reflectance), no_highlight
    has_maps = bool(subject.material.maps)  # the replacement is a single material without maps
    if whole.gamma == 1.0 and not has_maps and (simpler := stand_in(whole.reflectance, subject.material)):
        name, material = simpler
        yield name, replace(subject, material=material).assembled, ""

    def is_far(light: Light) -> bool:
        places = light.values(Place)
        return bool(places) and all(math.dist(place, middle) > _FAR * radius for place in places)

    directional = WITHOUT[POSITION](whole, middle).terms
    terms = tuple(b if is_far(a.light) else a for a, b in zip(whole.terms, directional, strict=True))
    all_near = "no light with a position is farther away than the mesh's diameter"
    any_far = any(is_far(term.light) for term in needed.terms)
    yield "far lights directional", replace(whole, terms=terms), "" if any_far else all_near

    has_size = any(term.light.has_size for term in whole.terms)
    for count in _NODES:
        name = f"lights with a size as {count} nodes" if count > 1 else "lights with a size as points"
        yield name, as_nodes(whole, count), "" if has_size else "no light has a size"
    highlighted = any(needed.has(term, "specular") for term in needed.terms)
    yield "no highlights", WITHOUT["specular"](whole, middle), "" if highlighted else "the scene has no highlights"


class SampledRows(NamedTuple):
    """Rows of the report for shadows and occlusion, with few rays per vertex and with many.

    Parameters
    ----------
    rows : list of Row
        Timed rows with their sampling errors.
    costs : dict of str to float
        Seconds to cast the rays of each effect to the tolerance, by the effect's name.
    left_out : dict of str to str
        Rows that are left out, and the reasons.
    """

    rows: list[Row]
    costs: dict[str, float]
    left_out: dict[str, str]


def sampling(subject: Subject, visibility: Visibility, tolerance: float, clock: Clock) -> SampledRows:
    """Measure shadows and occlusion by few rays per vertex, by many, and by as many as the tolerance needs.

    A row's time includes casting its rays and lighting the vertices with them. It does not include work for all rays
    together, such as building the tree of the occluders' triangles. A row's errors are differences from reference
    colours by 4096 rays, at random vertices. The reference includes `Subject.highlights_beyond_shares`, which
    evaluators lack.

    Parameters
    ----------
    subject : Subject
        Mesh, scene and material.
    visibility : Visibility
        Visibility at the subject's vertices, already cast to the tolerance.
    tolerance : float
        Largest standard error of the colours.
    clock : Clock
        Time budget.
    """
    equation, effects, count = subject.equation, subject.plan().effects, len(subject.points)
    if not equation.needs_visibility:
        why = dict.fromkeys(effects[name].why for name in ("shadow", "occlusion"))
        return SampledRows([], {}, {"rays": "; ".join(why)})
    clock.say("casting rays")
    costs, seen, how = {}, visibility.afresh(), {"sky": equation.is_occluded, "behind": equation.is_flipped}
    if equation.shadowed:
        _, costs["shadow"] = timed(lambda: seen.channels(equation.shadowed, sky=False, behind=equation.is_flipped))
    if equation.is_occluded:
        _, costs["occlusion"] = timed(lambda: seen.channels((), sky=True, behind=equation.is_flipped))
    sampled = equation.is_occluded + len({t.index for t in equation.terms if t.is_shadowed and t.light.has_size})

    checked: IntArray = np.zeros(0, np.intp)
    truth = np.zeros((0, 3))
    if sampled:
        per_vertex = MOST_RAYS * sampled * sum(costs.values()) / max(seen.rays, 1)
        some = min(max(int(_FOR_ALL_RAYS * clock.left / per_vertex), _FEWEST_CHECKED), count)
        checked = np.sort(np.random.default_rng(0).choice(count, some, replace=False))
        everything = visibility.afresh(samples=MOST_RAYS, rows=checked)
        channels = everything.channels(equation.shadowed, **how)
        truth = subject.exact(replace(equation, clamp=False), checked, channels)
        truth += subject.highlights_beyond_shares(everything, checked)
        truth = np.clip(truth, 0.0, 1.0) if equation.clamp else truth

    def row(name: str, samples: int | None) -> Row:
        clock.say(name)
        seconds, most = list[float](), _FOR_REPEATS * clock.left
        backend = subject.backend_for(equation)
        while not seconds or (len(seconds) < _REPEATS and sum(seconds) < most):
            cast = visibility.afresh(samples=samples)
            vertices = subject.vertices_that_see(cast)
            plan = Plan.of_equation(equation, vertices)
            seconds.append(timed(partial(plan.run, vertices, backend=backend))[1])
        errors, note = NO_ERROR, f"{cast.rays / count:.3g} rays per vertex"
        if sampled:
            channels = cast.channels(equation.shadowed, **how)[:, checked]
            errors = Errors.at_vertices(subject.exact(equation, checked, channels), truth)
            note += f"; compared with {MOST_RAYS} rays at {len(checked)} of {count} vertices"
        time = Timing.of(seconds)
        return Row(name, "sampling", backend, "float32", count, time, sampling=errors, note=note)

    if not sampled:
        return SampledRows([row("one ray for each light", None)], costs, {})
    rows, left_out = [row(f"rays to {_in_steps(tolerance)}", None)], {}
    for rays in _RAYS:
        name = f"{rays} rays"
        if rows[-1].time.low * (1 if rays <= _FEWEST_RAYS else 4) > clock.left:
            left_out[name] = "there was no time for it"
        else:
            rows.append(row(name, rays))
    return SampledRows(rows, costs, left_out)
