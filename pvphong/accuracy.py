"""What accuracy costs in time: rungs that are measured on one's own mesh and scene."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, field, replace

import numpy as np
import pyvista as pv

from pvphong import _check
from pvphong._types import Float64Array, MatrixLike
from pvphong.accuracy_facts import facts
from pvphong.accuracy_inside import AS_IT_IS, Refined, inside
from pvphong.accuracy_ledger import Without, dropped, ledger, promises, withouts
from pvphong.accuracy_progress import progress
from pvphong.accuracy_report import Tradeoff
from pvphong.accuracy_rows import NO_ERROR, Errors, Promise, Row, Timing, vertex_errors, with_fronts
from pvphong.accuracy_rungs import REFERENCE, Rung, Subject, colors, plan_name, rungs
from pvphong.accuracy_timing import Clock, Run, fitting, interleaved, once
from pvphong.material import Material
from pvphong.mesh import point_normals
from pvphong.planning import check_scene_and_material, make_plan
from pvphong.scene import Scene
from pvphong.surface import surface

PER_PIXEL, LIT_ARRAY = "VTK per pixel", "VTK drawing lit array"

# Parts of the time budget: for meshes that are refined, and left over so that it is kept.
_FOR_INSIDE, _SPARE = 0.4, 0.05

# Seconds that VTK needs to open two windows, and per face of a frame drawn by the processor.
_FOR_WINDOWS, _PER_FACE = 2.0, 1e-6


def tradeoff(
    mesh: pv.DataSet,
    scene: Scene,
    material: Material,
    *,
    tolerance: float = 1.0 / 255.0,
    seconds: float = 20.0,
    matrix: MatrixLike | None = None,
) -> Tradeoff:
    """Measure what accuracy costs in time on a mesh and a scene of one's own.

    Rungs from the float64 reference down to coarse light models are run in turns, so that a machine that drifts
    favours none, as often as the time budget allows. Their errors are of three kinds, which are measured apart:
    arithmetic (against the same equation in float64) and light model (between two equations in float64), both at the
    vertices, and interpolation (colours blended across triangles against per-pixel shading, in float64).

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface; it is not modified.
    scene : Scene
        Lights, viewer and light model.
    material : Material
        The surface's reflectances.
    tolerance : float, default 1/255
        The largest absolute colour error that is to be allowed, > 0; the default is one step of a display.
    seconds : float, default 20
        What it may take, > 0. On large meshes rungs are left out to keep it, with the reason given. Compiling the
        kernel, once per installation, is not counted.
    matrix : array_like, optional
        (4, 4) model matrix.

    Returns
    -------
    Tradeoff
        `.rows`, `.best(tolerance)`, `.ledger`, `.promises`, `.table()`, `.plot(path)`, `.to_csv(path)`,
        `.to_json(path)`; print it for all of it.

    Raises
    ------
    ValueError
        If an argument has the wrong shape, type or range, or the mesh has nothing that can be lit.
    """
    check_scene_and_material(scene, material)
    tolerance = _check.number("tolerance", tolerance, above=0.0)
    seconds = _check.number("seconds", seconds, above=0.0)
    source = surface(mesh)
    placed = None if matrix is None else _check.matrix4("matrix", matrix)
    points, normals = _check.array("points", source.points), _check.array("normals", point_normals(source))
    subject = Subject(points, normals, scene, material, placed)
    with progress("measuring") as report, ExitStack() as stack:
        report(0.0, f"the evaluator is {subject.backend}")  # which compiles the kernel, once per installation
        measurement = _Measurement(source, subject, tolerance, Clock(seconds * (1.0 - _SPARE), report), stack)
        return measurement.run()


@dataclass(frozen=True)
class _Candidate:
    """A run with its errors, before it is timed."""

    row: Row
    run: Run
    estimate: float


@dataclass
class _Measurement:
    """One report in the making."""

    source: pv.PolyData
    subject: Subject
    tolerance: float
    clock: Clock
    stack: ExitStack
    candidates: dict[str, _Candidate] = field(default_factory=dict)
    missing: list[Without] = field(default_factory=list)
    promised: tuple[Promise, ...] = ()
    left_out: dict[str, str] = field(default_factory=dict)
    inside_errors: Float64Array = field(default_factory=lambda: np.zeros(0))
    exact_seconds: float = 0.0

    @property
    def baseline(self) -> str:
        """The rung against which effects are left out."""
        return "float32 kernel" if self.subject.backend == "numba" else "float32 NumPy"

    @property
    def needed(self) -> set[str]:
        """Rungs without which there is no report."""
        return {REFERENCE, self.baseline, plan_name(self.tolerance)}

    def run(self) -> Tradeoff:
        """Everything in the order of its importance, as long as there is time."""
        self.clock.say("float64 reference")
        self.exact_seconds = once(lambda: self.subject.truth)
        self._at_vertices()
        if self._has_time_for("promises", 8):
            self.promised = promises(self.subject, self.tolerance)
        self._inside()
        self._per_pixel()
        self._effects()
        return self._report(self._times())

    def _has_time_for(self, what: str, exact_runs: int) -> bool:
        """Whether half of the time that is left holds some float64 evaluations; what has none is noted."""
        fits = exact_runs * self.exact_seconds <= 0.5 * self.clock.left
        if not fits:
            self.left_out[what] = "there was no time for it"
        return fits

    def _at_vertices(self) -> None:
        found, reasons = rungs(self.subject, self.tolerance)
        self.left_out |= reasons
        for rung in found:
            if rung.name in self.needed or self._has_time_for(rung.name, 6):
                self.clock.say(rung.name)
                self._add(_row(rung, *_errors(self.subject, rung)), rung.run)

    def _inside(self) -> None:
        if not self._has_time_for("inside triangles", 10):
            return
        clock = Clock(_FOR_INSIDE * self.clock.left, lambda _, what: self.clock.say(what))
        refined, self.inside_errors, reasons = inside(self.source, self.subject, self.tolerance, clock)
        self.left_out |= reasons
        for one in refined:
            self._add(self._refined_row(one), self._refined_run(one))

    def _refined_row(self, one: Refined) -> Row:
        return Row(
            name=one.name,
            kind="interpolation",
            time=_UNTIMED,
            arithmetic=None,
            light_model=None,
            interpolation=one.errors,
            points=len(one.points),
            backend=self.subject.backend_for(len(one.points)),
            precision="float32",
            preparation=one.preparation,
            note=one.note,
        )

    def _refined_run(self, one: Refined) -> Run:
        s = self.subject
        backend = s.backend_for(len(one.points))

        def run() -> object:
            equation = make_plan(one.points, one.normals, s.scene, s.material, s.matrix, 0.0).equation
            return colors(one.points, one.normals, equation, backend, "float32")

        return run

    def _per_pixel(self) -> None:
        faces = self.source.n_cells
        if 2.0 * (_FOR_WINDOWS + faces * _PER_FACE) > self.clock.left:
            self.left_out[PER_PIXEL] = "there was no time for it"
            return
        from pvphong.peers import FRAME, vtk_frames

        s = self.subject
        self.clock.say(PER_PIXEL)
        try:
            frames = self.stack.enter_context(vtk_frames(self.source, s.truth, s.scene, s.material, s.matrix))
        except ValueError as error:
            self.left_out[PER_PIXEL] = str(error)
            return
        note = f"a frame of {FRAME[0]} × {FRAME[1]} pixels, {frames.driver}"
        given = f"drawn {frames.changed}" if frames.changed else "its error is 0 by definition"
        self._add(self._frame_row(PER_PIXEL, NO_ERROR, f"{note}; {given}"), frames.per_pixel)
        own = self.candidates.get(AS_IT_IS)
        if own is not None:
            self._add(self._frame_row(LIT_ARRAY, own.row.error, f"{note}; not evaluated anew"), frames.lit_array)

    def _frame_row(self, name: str, error: Errors, note: str) -> Row:
        points = self.source.n_points
        return Row(
            name, "interpolation", _UNTIMED, None, None, error, points, "VTK", "float32", is_peer=True, note=note
        )

    def _effects(self) -> None:
        for effect, equation in withouts(self.subject).items():
            if self._has_time_for(f"ledger: {effect}", 4):
                self.clock.say(f"without {effect}")
                self.missing.append(dropped(self.subject, effect, equation))

    def _add(self, row: Row, run: Run) -> None:
        """Every run is warmed up here: once, and again if that was short."""
        estimate = once(run)
        if estimate < 0.05 * self.clock.left:
            estimate = min(estimate, once(run))
        self.candidates[row.name] = _Candidate(row, run, estimate)

    def _times(self) -> dict[str, Float64Array]:
        runs = {name: candidate.run for name, candidate in self.candidates.items()}
        estimates = {name: candidate.estimate for name, candidate in self.candidates.items()}
        for without in self.missing:
            name = _without(without.effect)
            runs[name], estimates[name] = without.run, estimates[self.baseline]
        kept = fitting(estimates, self.needed, self.clock.left)
        self.left_out |= {name: "there was no time to repeat it" for name in runs if name not in kept}
        return interleaved({name: run for name, run in runs.items() if name in kept}, estimates, self.clock)

    def _report(self, times: dict[str, Float64Array]) -> Tradeoff:
        s, baseline = self.subject, times[self.baseline]
        rows = [
            replace(candidate.row, time=Timing.of(times[name]))
            for name, candidate in self.candidates.items()
            if name in times
        ]
        costs = {
            without.effect: baseline - times[_without(without.effect)]
            for without in self.missing
            if _without(without.effect) in times
        }
        repeats = len(baseline)
        told = facts(self.source, s.scene, s.material)
        told["measured"] = f"{repeats} rounds in turns after a warm-up; a sample is the least of up to 7 short runs"
        return Tradeoff(
            tolerance=self.tolerance,
            rows=with_fronts(rows),
            ledger=ledger(s, s.plan(self.tolerance), self.missing, costs),
            promises=self.promised,
            left_out=self.left_out,
            facts=told,
            inside_errors=self.inside_errors,
            surface=self.source,
            _subject=s,
        )


_UNTIMED = Timing(0.0, 0.0, 0.0, 0)


def _without(effect: str) -> str:
    return f"without {effect}"


def _errors(subject: Subject, rung: Rung) -> tuple[Errors, Errors]:
    """Arithmetic and light-model error."""
    own, light_model = subject.truth, NO_ERROR
    if rung.equation is not subject.equation:
        own = subject.exact(rung.equation)
        light_model = vertex_errors(own, subject.truth)
    return vertex_errors(rung.run(), own), light_model


def _row(rung: Rung, arithmetic: Errors, light_model: Errors) -> Row:
    return Row(
        name=rung.name,
        kind=rung.kind,
        time=_UNTIMED,
        arithmetic=arithmetic,
        light_model=light_model,
        interpolation=None,
        points=arithmetic.count,
        backend=rung.backend,
        precision=rung.precision,
        promised=rung.promised,
        is_peer=rung.is_peer,
        note=rung.note,
    )
