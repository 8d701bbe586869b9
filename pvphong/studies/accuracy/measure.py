"""Measurement of every variant's error and time within a time budget, the most important variants first."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.types import Float64Array, MatrixLike
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.lit import Setting, vertices_of
from pvphong.meshes.point_data import surface_and_maps
from pvphong.meshes.surfaces import FeatureAngle
from pvphong.optics.maps import Map
from pvphong.optics.material import Material, as_material
from pvphong.rays.visibility import Visibility
from pvphong.scene.scene import SceneLike, light_labels
from pvphong.shading import kernel
from pvphong.shading.plan.effects import EFFECTS
from pvphong.shading.plan.state import PlanState
from pvphong.studies.accuracy import physics
from pvphong.studies.accuracy.interpolation import (
    AS_IT_IS,
    Interpolation,
    interpolation,
    least_seconds,
    seconds_of_rays,
)
from pvphong.studies.accuracy.peers import PER_PIXEL, TEXTBOOK, textbook, vtk_frames
from pvphong.studies.accuracy.report import Tradeoff, circumstances
from pvphong.studies.accuracy.result import NO_ERROR, Errors, LedgerEntry, PredictedBound, Row, Timing, with_fronts
from pvphong.studies.accuracy.timing import FEWEST_REPEATS, Clock, Run, interleaved, progress, timed
from pvphong.studies.accuracy.variants import (
    REFERENCE,
    WITHOUT,
    SampledRows,
    Subject,
    Variant,
    plan_name,
    sampling,
    variants,
)

# Fraction of the time budget held in reserve.
_SPARE = 0.05

# Fraction of the time budget reserved for interleaved timing. Largest fractions of the remaining time: for rays; for
# errors inside triangles, refined meshes included.
_FOR_ROUNDS, _FOR_SAMPLING, _FOR_INSIDE = 0.4, 0.4, 0.5

# Time to prepare a measurement and compute its errors, as a multiple of the time of a float64 evaluation. Measurements:
# a variant, or the equation without an effect; the predicted error bounds; the textbook formula.
_FOR_VARIANT, _FOR_BOUNDS, _FOR_TEXTBOOK = 2.0, 6.0, 6.0

# When light models are compared, the fraction of their time that path tracing takes.
_FOR_TRUTH = 0.7

# Seconds that VTK needs to open two windows, and that software rendering needs for a frame's pixels and for each face.
_FOR_WINDOWS, _PER_FRAME, _PER_FACE = 1.5, 0.1, 2e-6


def tradeoff(
    mesh: pv.DataSet,
    scene: SceneLike | None,
    material: Material | str,
    *,
    tolerance: float = 1.0 / 255.0,
    seconds: float = 20.0,
    matrix: MatrixLike | None = None,
    feature_angle: FeatureAngle = None,
    occluders: Any = (),
    visibility: Visibility | None = None,
    truth: bool = False,
) -> Tradeoff:
    """Measure accuracy against time on a mesh and scene.

    Variants are ways to light the mesh, from the float64 reference to coarse light models. They are timed in
    interleaved rounds, as often as the time budget allows. So a machine that becomes slower slows all variants alike.
    Kinds of errors are measured separately:

    - Arithmetic: colours at the vertices compared with the same equation in float64.
    - Light model: a simpler equation compared with the full one at the vertices, both in float64.
    - Interpolation: colours blended across triangles compared with per-pixel shading, both in float64. Rays are cast
      inside triangles if there is time.
    - Sampling, if there are shadows or ambient occlusion: colours with few rays per vertex compared with colours with
      4096 rays, at random vertices. The sampling error includes an error of highlights of partly hidden area lights.
      Such a highlight is multiplied by the fraction of the light that is visible to diffuse reflection, although the
      highlight may come from another part of the light.

    Arithmetic and light-model errors are measured with the same visibility on both sides.

    Parameters
    ----------
    mesh : pyvista.DataSet
        Dataset with a surface; it is not modified.
    scene : Scene, light, sequence of lights, or None
        Lights, viewer and light model; by default the scene of `pvphong.default_scene`.
    material : Material or str
        Material of the surface.
    tolerance : float, default 1/255
        Largest allowed absolute colour error, > 0; the default is one step of a display.
    seconds : float, default 20
        Time budget, > 0. To keep it, variants of large meshes are left out, and the report gives the reasons. Three
        variants are always measured: the float64 reference, the equation simplified within the tolerance, and the
        evaluator that is used by default. Compilation of the kernel, once per installation, does not count.
    matrix : array_like, optional
        (4, 4) model matrix.
    feature_angle : float, "auto" or None, default None
        An edge is sharp if the normals of its two faces differ by more than this angle, in degrees. Points are
        duplicated along sharp edges. "auto" is 30 if the mesh has no point normals, and None if it has. None splits
        nothing.
    occluders : sequence, optional
        Other meshes that block light, each as a mesh or a pair of a mesh and a 4x4 matrix.
    visibility : Visibility, optional
        Result of `mesh.phong.visibility`. A plain array is not enough, because the measurement casts the rays again.
    truth : bool, default False
        Also compare light models with path tracing. The models range from constant ambient light to all bounces. This
        takes about `seconds` more. Not available in VTK's convention, which has no bounces.

    Returns
    -------
    Tradeoff
        `.rows`, `.best(tolerance)`, `.ledger`, `.predicted_bounds`, `.table()`, `.plot(path)`, `.to_csv(path)`,
        `.to_json(path)`; print it for the recommendation, and `.explain()` for everything.

    Raises
    ------
    ValueError
        If an argument has the wrong shape, type or range, or the mesh has nothing to light.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> report = ph.tradeoff(pv.Sphere(), ph.DirectionalLight(), "gold", seconds=0.2)
    >>> len(report.rows) > 0
    True
    """
    material, truth = as_material(material), check.flag("truth", truth)
    given: Any = visibility  # type not checked yet
    if not isinstance(given, Visibility | None):
        remedy = "Omit visibility to cast rays in this call."
        check.refuse("visibility", type(given).__name__, "a result of mesh.phong.visibility", remedy)
    tolerance = check.number("tolerance", tolerance, above=0.0)
    clock = Clock((1.0 - _SPARE) * check.number("seconds", seconds, above=0.0))
    source, maps, tangents = surface_and_maps(mesh, material, feature_angle)
    scene = scene_for(source, scene, matrix)
    if truth and scene.light_model.convention != "standard":
        remedy = "VTK's shader has no bounces; use the standard convention: LightModel()."
        check.refuse("truth", True, "False in VTK's convention", remedy)
    bounces, scene = scene.light_model.bounces, replace(scene, light_model=replace(scene.light_model, bounces=0))
    placed = None if matrix is None else check.matrix4("matrix", matrix)
    setting = Setting(placed, feature_angle, occluders, visibility, tolerance=tolerance)
    vertices = vertices_of(source, maps, tangents, scene, setting)
    arrays: dict[str, Any] = {name: values.rows for name, values in vertices.maps.items()}
    if material.reflectance is not None and "tangents" in material.reflectance.needs:
        arrays = arrays | {"tangents": vertices.tangents}
    lit = replace(material, tangents=None).with_values({name: Map(rows) for name, rows in arrays.items()})
    seen = vertices.visibility  # None if nothing casts a shadow
    assert seen is None or isinstance(seen, Visibility)
    subject = Subject(vertices.points, vertices.normals, scene, lit, placed, seen)
    with progress(clock, "measuring"), ExitStack() as stack:
        clock.say("loading the evaluator")
        clock.seconds += kernel.seconds_compiling(lambda: subject.has_kernel)
        measurement = _Measurement(source, subject, tolerance, clock, stack)
        if bounces and not truth:
            measurement.left_out["bounces"] = "only direct light is measured"
        if truth and scene.light_model.two_sided:
            measurement.left_out["bounces"] = "the light model is two-sided"
        report = measurement.run()
    if not truth:
        return report
    clock = Clock(seconds)
    with progress(clock, "light models"):
        found = physics.measure(mesh, scene, material, setting, budget=_FOR_TRUTH * seconds, say=clock.say)
    return replace(report, physics=found)


class _Measurement:
    """State of a measurement.

    Attributes
    ----------
    rows : dict of str to Row
        Rows measured so far, not yet timed.
    runs, estimates : dict
        Functions to time, and estimates of their seconds, both by the name of the run.
    left_out : dict of str to str
        Variants that are not measured, and the reasons.
    """

    def __init__(self, mesh: pv.PolyData, subject: Subject, tolerance: float, clock: Clock, stack: ExitStack) -> None:
        self.mesh, self.subject, self.tolerance, self.clock, self.stack = mesh, subject, tolerance, clock, stack
        self.rows: dict[str, Row] = {}
        self.runs: dict[str, Run] = {}
        self.estimates: dict[str, float] = {}
        self.left_out: dict[str, str] = {}
        self.for_rounds = _FOR_ROUNDS * clock.left
        # A report needs these variants. The cost of an effect is the time that removing it from the baseline saves.
        self.baseline = "float32 kernel" if subject.backend_for(subject.equation) == "numba" else "float32 NumPy"
        self.needed = {REFERENCE, self.baseline, plan_name(tolerance)}

    def run(self) -> Tradeoff:
        """Measure everything in order of importance, as long as there is time."""
        s, clock = self.subject, self.clock
        clock.say(REFERENCE)
        _, self.exact_seconds = timed(lambda: s.truth)
        if self.exact_seconds < 0.01 * clock.left:
            _, self.exact_seconds = timed(lambda: s.exact(s.equation))  # warm
        sampled = self._cast_rays()
        lighting = self._light_vertices()
        bounds: tuple[PredictedBound, ...] = ()
        if self._has_time_for("predicted error bounds", _FOR_BOUNDS * self.exact_seconds):
            bounds = predicted_bounds(s, self.tolerance)
        inside = self._refine()
        errors_without = self._drop_effects()
        self._light_by_peers()

        times = interleaved(self.runs, self.estimates, clock, self.needed)
        self.left_out |= {name: "there was no time to repeat it" for name in self.runs if name not in times}
        baseline = times[self.baseline]
        rows = [replace(row, time=Timing.of(times[name])) for name, row in self.rows.items() if name in times]
        measured = (
            f"{len(baseline)} interleaved rounds after a warm-up, slow runs in some of them only; "
            "a sample is the minimum of up to 7 short runs"
        )
        return Tradeoff(
            tolerance=self.tolerance,
            rows=with_fronts([*rows, *sampled.rows]),
            ledger=self._ledger(errors_without, times, sampled.costs),
            baseline=self.baseline,
            predicted_bounds=bounds,
            left_out=self.left_out,
            facts=circumstances(self.mesh, s.scene, s.material) | {"measured": measured},
            inside_errors=inside.errors,
            inside_areas=inside.areas,
            surface=self.mesh,
            scene=s.scene,
            matrix=s.matrix,
            reference_colors=s.truth,
            _lighting={variant.row.name: variant.run for variant in lighting},
        )

    def _left(self) -> float:
        """Return the seconds that are left to prepare more variants.

        The time to repeat all variants found so far is already subtracted.
        """
        return self.clock.left - max(self.for_rounds, FEWEST_REPEATS * sum(self.estimates.values()))

    def _has_time_for(self, what: str, seconds: float) -> bool:
        """Return True if `seconds` are left to prepare `what`. If not, add `what` to `left_out` and return False."""
        fits = seconds <= self._left()
        if not fits:
            self.left_out[what] = "there was no time for it"
        return fits

    def _add(self, row: Row, run: Run, seconds: float) -> None:
        """Add a variant that has been run once to the runs to time, if there is time to repeat it.

        A variant that the report needs is always added. A short run is timed again, because the first one was the
        warm-up.

        Parameters
        ----------
        row : Row
            Row of the variant.
        run : callable
            Function that lights the mesh.
        seconds : float
            Time of the first run.
        """
        if seconds < 0.01 * self.clock.left:
            seconds = min(seconds, timed(run)[1])
        if row.name not in self.needed and self.clock.left < FEWEST_REPEATS * (sum(self.estimates.values()) + seconds):
            self.left_out[row.name] = "there was no time to repeat it"
            return
        self.rows[row.name], self.runs[row.name], self.estimates[row.name] = row, run, seconds

    def _add_all(self, found: list[Variant]) -> None:
        """Run each of the variants `found` once, and add it to the runs to time."""
        for row, run, _ in found:
            self._add(row, run, timed(run)[1])

    # -- measurements

    def _cast_rays(self) -> SampledRows:
        visibility = self.subject.visibility
        if visibility is None or not self._has_time_for("rays", 2.0 * visibility.seconds):
            return SampledRows([], {}, {})
        found = sampling(self.subject, visibility, self.tolerance, self.clock.part(_FOR_SAMPLING * self._left()))
        self.left_out |= found.left_out
        return found

    def _light_vertices(self) -> list[Variant]:
        """Measure the errors of every variant at the vertices, and time each variant once.

        Variants for which there is no time are not measured. Return all variants, including these.
        """
        s = self.subject
        found, reasons = variants(s, self.tolerance)
        self.left_out |= reasons
        for row, run, equation in found:
            if row.name not in self.needed and not self._has_time_for(row.name, _FOR_VARIANT * self.exact_seconds):
                continue
            self.clock.say(row.name)
            colors, seconds = timed(run)
            float64_colors, light_model = s.truth, NO_ERROR
            if equation is not None and equation is not s.equation:
                float64_colors = s.exact(equation)
                light_model = Errors.at_vertices(float64_colors, s.truth)
            arithmetic = Errors.at_vertices(colors, float64_colors)
            self._add(replace(row, arithmetic=arithmetic, light_model=light_model), run, seconds)
        return found

    def _refine(self) -> Interpolation:
        s, model = self.subject, self.subject.scene.light_model
        if not self._has_time_for("inside triangles", least_seconds(self.mesh, self.exact_seconds) / _FOR_INSIDE):
            return Interpolation([], np.zeros(0), np.zeros(0), {})
        rays = seconds_of_rays(s, self.tolerance)
        clock = self.clock.part(_FOR_INSIDE * self._left())
        if rays and least_seconds(self.mesh, self.exact_seconds + rays) > clock.left:
            why = "there was no time for rays there; interpolation is measured without them"
            self.left_out["shadows and occlusion inside triangles"], rays = why, 0.0
        if model.needs_rays and not rays:
            s = replace(s, scene=replace(s.scene, light_model=model.without_rays()), visibility=None)
        found = interpolation(self.mesh, s, self.tolerance, self.exact_seconds + rays, clock)
        self.left_out |= found.left_out
        self._add_all(found.variants)
        return found

    def _drop_effects(self) -> dict[str, float]:
        """Measure the light-model error without each effect, and without each light.

        Return the largest error by the name of the effect or light. For each, a run without the effect or light is
        added to the runs to time.
        """
        s, whole, errors = self.subject, self.subject.assembled, dict[str, float]()
        effects, (middle, _) = s.plan().effects, s.sphere
        without = {name: drop(whole, middle) for name, drop in WITHOUT.items() if effects[name].on}
        if len(s.equation.terms) > 1:
            for index in dict.fromkeys(term.index for term in s.equation.terms):
                others = tuple(term for term in whole.terms if term.index != index)
                without[f"light {light_labels(s.scene)[index]}"] = replace(whole, terms=others)
        for effect, equation in without.items():
            if not self._has_time_for(f"ledger: {effect}", _FOR_VARIANT * self.exact_seconds):
                continue
            name = f"without {effect}"
            self.clock.say(name)
            errors[effect] = Errors.at_vertices(s.exact(equation), s.truth).largest
            gone = {term.index for term in whole.terms} - {term.index for term in equation.terms}
            lights = tuple(light for index, light in enumerate(s.scene.lights) if index not in gone)
            scene = replace(s.scene, lights=lights) if gone else None  # a removed light is not assembled either
            run = s.run_of(equation, scene=scene)
            self.runs[name], self.estimates[name] = run, min(timed(run)[1] for _ in range(2))
        return errors

    def _ledger(
        self, errors: dict[str, float], times: dict[str, Float64Array], casting: dict[str, float]
    ) -> tuple[LedgerEntry, ...]:
        """Return an entry for every effect, such as shadows, and for every light whose error was measured.

        The cost of an effect is the difference between the times with and without it, plus the time of its rays.

        Parameters
        ----------
        errors : dict
            Largest error without each effect or light, by its name, from `_drop_effects`.
        times : dict
            Seconds of the repeats of each run, by the run's name.
        casting : dict
            Seconds to cast the rays of each effect, by the effect's name.
        """
        plan = self.subject.plan(self.tolerance)
        kept = {term.index for term in plan.equation.terms}
        choices = {name: (choice.on, choice.why) for name, choice in plan.effects.items()}
        for index, label in enumerate(light_labels(self.subject.scene)):
            if f"light {label}" in errors:
                choices[f"light {label}"] = index in kept, "" if index in kept else "left out, see lights"

        def cost(effect: str) -> Timing | None:
            without = times.get(f"without {effect}")
            return None if without is None else Timing.of(times[self.baseline] - without + casting.get(effect, 0.0))

        return tuple(LedgerEntry(name, cost(name), errors.get(name), *choice) for name, choice in choices.items())

    def _light_by_peers(self) -> None:
        s, frame = self.subject, _PER_FRAME + self.mesh.n_cells * _PER_FACE
        lit_error = self.rows[AS_IT_IS].error if AS_IT_IS in self.rows else None
        peers: list[tuple[str, float, Callable[[], list[Variant]]]] = [
            (TEXTBOOK, _FOR_TEXTBOOK * self.exact_seconds, lambda: [textbook(s)]),
            (PER_PIXEL, _FOR_WINDOWS + 4 * frame, lambda: vtk_frames(self.mesh, s, self.stack, lit_error)),
        ]
        for name, to_get_ready, make in peers:
            if not self._has_time_for(name, to_get_ready):
                continue
            self.clock.say(name)
            try:
                found = make()
            except ValueError as error:
                self.left_out[name] = str(error)
                continue
            self._add_all(found)


def predicted_bounds(subject: Subject, tolerance: float) -> tuple[PredictedBound, ...]:
    """Return a bound and the largest measured error for each simplification of the equation at a tolerance."""
    state, found = PlanState.first(subject.assembled, tolerance, subject.vertices), []
    for effect in EFFECTS:
        before, state = state, effect.simplify(state)
        notes = [note for note in state.simplifications[len(before.simplifications) :] if note.bound]
        if notes:
            measured = Errors.at_vertices(subject.exact(state.equation), subject.exact(before.equation)).largest
            why = "; ".join(f"{note.light}: {note.why}".removeprefix(": ") for note in notes)
            bound = sum(note.bound for note in notes) ** (1.0 / subject.assembled.gamma)  # of colours, not of light
            found.append(PredictedBound(effect.name, why, bound, measured))
    return tuple(found)
