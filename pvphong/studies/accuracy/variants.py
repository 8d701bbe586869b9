"""The subject, and variants of lighting its vertices: arithmetic, light models, and numbers of rays."""

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
"""Name of each of the plan's effects → equation, point → the equation without it."""

# Numbers of point lights that are tried in place of a light with a size.
_NODES = 1, 4, 16, 64

# Distance from which the plan tests if a light may be treated as directional, in radii of the mesh.
_FAR = 2.0

# Numbers of rays that are tried, and the smallest number when rays are cast to a tolerance.
_RAYS, _FEWEST_RAYS = (4, 16, 64, 256), 16

# Largest fraction of the time budget for colours by all rays, and the smallest number of vertices with them.
_FOR_ALL_RAYS, _FEWEST_CHECKED = 0.2, 100

# Number of nodes per light with a size, each with a ray of its own, in the truth of highlights.
_NODES_OF_HIGHLIGHT = 256

# Largest number of repeats of a sampling row, and their largest fraction of the remaining time.
_REPEATS, _FOR_REPEATS = 5, 0.1


@dataclass(frozen=True, eq=False)
class Subject:
    """Mesh, scene and material to light, as checked arrays.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3).
    scene, material, matrix
        As for `evaluate`; the material's maps are arrays.
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
        """Points and normals for the evaluators."""
        return self.vertices_that_see(self.visibility)

    def vertices_that_see(self, visibility: Visibility | None) -> Vertices:
        """Return the vertices with another visibility."""
        material = self.material
        return Vertices(self.points, self.normals, material.maps, visibility, tangents=material.tangents)

    def plan(self, tolerance: float = 0.0) -> Plan:
        """Return the plan at a tolerance."""
        return Plan.of(self.scene, self.material, self.vertices, matrix=self.matrix, tolerance=tolerance)

    @cached_property
    def assembled(self) -> Equation:
        """Whole lighting equation, as in plans: relative to the mesh if that is very far from the origin."""
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
        """Evaluate an equation by the float64 reference, shape (m, 3).

        Parameters
        ----------
        equation : Equation
            Equation to evaluate.
        rows : ndarray, optional
            Shape (m,): the vertices; all of them if not given.
        channels : ndarray, optional
            Shape (k, m): visibility at these vertices, from `Visibility.channels`.
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
        """Excess of area lights' highlights over their visible share, (m, 3).

        Evaluators multiply a highlight by the visible part of its light for diffuse reflection. This function computes
        the highlight by nodes, each with a ray of its own, and returns the difference.

        Parameters
        ----------
        seen : Visibility
            Visibility at these vertices.
        rows : ndarray
            Shape (m,): the vertices.
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
        """Bounding sphere of the mesh in the world; of radius 0 at the origin if unknown."""
        return self.vertices.extent(self.assembled.matrix).sphere or Sphere((0.0, 0.0, 0.0), 0.0)

    @cached_property
    def has_kernel(self) -> bool:
        """True if the kernel is available and supports the equation; the first access compiles it for these types."""
        seen = self.vertices.channels(self.equation)
        first = None if seen is None else seen[:, :1]
        tints = {name: tint.at(slice(1)) for name, tint in self.vertices.tints(self.equation).items()}
        arrays, compiled = (self.points[:1], self.normals[:1], self.equation, tints), kernel.evaluator()
        results = (Shading(np.empty((1, 3), real)) for real in ("float32", "float64"))
        return compiled is not None and all(compiled(*arrays, result, channels=first) for result in results)

    def backend_for(self, equation: Equation, count: int | None = None) -> Backend:
        """Return the default evaluator for an equation and a number of vertices; None for all of them."""
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
        """Return a run with the steps of `evaluate`: assemble the scene's equation, plan it and evaluate it.

        Parameters
        ----------
        equation : Equation
            The whole equation, or one that was rewritten from it.
        precision : {"float32", "float64"}
            Type of the colours.
        backend : str, optional
            Evaluator; by default that of `evaluate`.
        scene : Scene, optional
            Scene from which the equation is assembled, because this time counts; by default the whole scene.
        """

        def run() -> FloatArray:
            relative_to_mesh(self.vertices.equation(scene or self.scene, self.material, self.matrix))
            chosen = backend or self.backend_for(equation)
            return Plan.of_equation(equation, self.vertices).run(self.vertices, precision=precision, backend=chosen).rgb

        return run


class Variant(NamedTuple):
    """One lighting of the mesh, to be measured.

    Parameters
    ----------
    row : Row
        Its row of the report, not yet measured.
    run : callable
        Lights the mesh once; a run at the vertices returns the colours (n, 3).
    equation : Equation, optional
        Its equation, if its errors at the vertices are still to be computed.
    """

    row: Row
    run: Callable[[], Any]
    equation: Equation | None = None


def plan_name(tolerance: float) -> str:
    """Return the name of the plan's variant."""
    return f"plan at {_in_steps(tolerance)}"


def _in_steps(tolerance: float) -> str:
    """Format a tolerance in display steps if it is a whole number of them, else as a number."""
    steps = tolerance * 255.0
    whole = round(steps)
    return f"{whole}/255" if whole and abs(steps - whole) < 1e-9 else f"{tolerance:.3g}"


def variants(subject: Subject, tolerance: float) -> tuple[list[Variant], dict[str, str]]:
    """Return all variants of pvphong that apply to the scene, and the reasons why others are left out.

    The evaluators and precisions come first, then simpler light models in float32 by the default evaluator, and the
    plan at the tolerance.
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
    """Yield name, equation, and the reason to leave it out, or an empty string."""
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
    yield "no highlights", WITHOUT["specular"](whole, middle), "" if highlighted else "there are none"


class SampledRows(NamedTuple):
    """Shadows and occlusion by few rays and by many.

    Parameters
    ----------
    rows : list of Row
        Timed rows with their sampling errors.
    costs : dict of str to float
        Seconds of casting to the tolerance, by effect.
    left_out : dict of str to str
        Rows that are left out, and the reasons.
    """

    rows: list[Row]
    costs: dict[str, float]
    left_out: dict[str, str]


def sampling(subject: Subject, visibility: Visibility, tolerance: float, clock: Clock) -> SampledRows:
    """Measure shadows and occlusion by few rays and many, and by as many as the tolerance needs.

    A row's time includes casting its rays and lighting the vertices with them, but not work that is shared by all rays,
    such as building the tree of the occluders' triangles. Its errors are differences from colours by 4096 rays, at
    random vertices. In the latter, the highlight of a partly hidden area light is that of its visible nodes, not the
    visible share of the whole highlight, which evaluators use.

    Parameters
    ----------
    subject : Subject
        Mesh, scene and material.
    visibility : Visibility
        Visibility at its vertices, cast to the tolerance before.
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
