"""One report in the making: what is measured, in the order of its importance, as long as there is time."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field, replace

import numpy as np
import pyvista as pv

from pvphong.base.types import Backend, Float64Array
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices
from pvphong.studies.accuracy.facts import facts
from pvphong.studies.accuracy.hillshade import height_field, hillshading
from pvphong.studies.accuracy.inside import AS_IT_IS, Inside, Refined, inside, least_seconds
from pvphong.studies.accuracy.ledger import Without, dropped, ledger, promises, withouts
from pvphong.studies.accuracy.report import Tradeoff
from pvphong.studies.accuracy.rows import NO_ERROR, UNTIMED, Errors, Promise, Row, Timing, vertex_errors, with_fronts
from pvphong.studies.accuracy.sampling import Sampling, sampling
from pvphong.studies.accuracy.subject import Subject
from pvphong.studies.accuracy.timing import FEWEST_REPEATS, Clock, Run, fitting, interleaved, timed
from pvphong.studies.accuracy.variants import REFERENCE, Variant, peers, plan_name, variants

PER_PIXEL, LIT_ARRAY = "VTK per pixel", "VTK drawing lit array"
LIGHT_SOURCE = "Matplotlib LightSource"

# Parts of the time budget: the least that is kept for measuring in turns, and, of what is left for getting ready,
# for rays and for meshes that are refined.
_FOR_ROUNDS, _FOR_SAMPLING, _FOR_INSIDE = 0.4, 0.4, 0.5

# Float64 evaluations that it takes to get ready to measure, with errors: a variant, the promises, an effect, a peer.
_FOR_VARIANT, _FOR_PROMISES, _FOR_EFFECT, _FOR_PEER = 2.0, 6.0, 2.0, 6.0

# Seconds that VTK needs to open two windows, and for a frame drawn by the processor: its pixels, and each face.
_FOR_WINDOWS, _PER_FRAME, _PER_FACE = 1.5, 0.1, 2e-6


@dataclass
class Measurement:
    """One report in the making.

    Attributes
    ----------
    rows : dict of str to Row
        What was found so far, before it is timed.
    runs, estimates : dict
        What is to be timed, by name, and the seconds that it took once.
    left_out : dict of str to str
        What is not measured, and why.
    """

    source: pv.PolyData
    subject: Subject
    tolerance: float
    clock: Clock
    stack: ExitStack
    rows: dict[str, Row] = field(default_factory=dict)
    runs: dict[str, Run] = field(default_factory=dict)
    estimates: dict[str, float] = field(default_factory=dict)
    missing: list[Without] = field(default_factory=list)
    promised: tuple[Promise, ...] = ()
    left_out: dict[str, str] = field(default_factory=dict)
    found_inside: Inside = field(default_factory=lambda: Inside([], np.zeros(0), np.zeros(0), {}))
    sampled: Sampling = field(default_factory=lambda: Sampling([], {}, {}))
    exact_seconds: float = 0.0

    def __post_init__(self) -> None:
        self._for_rounds = _FOR_ROUNDS * self.clock.left

    @property
    def baseline(self) -> str:
        """The variant against which effects are left out."""
        return "float32 kernel" if self.subject.backend == "numba" else "float32 NumPy"

    @property
    def needed(self) -> set[str]:
        """Variants without which there is no report."""
        return {REFERENCE, self.baseline, plan_name(self.tolerance)}

    def run(self) -> Tradeoff:
        """Everything in the order of its importance, as long as there is time."""
        self.clock.say(REFERENCE)
        _, self.exact_seconds = timed(lambda: self.subject.truth)
        if self.exact_seconds < 0.01 * self.clock.left:
            _, self.exact_seconds = timed(lambda: self.subject.exact(self.subject.equation))  # warm
        self._sampling()
        self._at_vertices()
        if self._has_time_for("promises", _FOR_PROMISES * self.exact_seconds):
            self.promised = promises(self.subject, self.tolerance)
        self._inside()
        self._effects()
        self._peers()
        return self._report(self._times())

    # -- time

    def _left(self, frame: float = 0.0) -> float:
        """Seconds that are left for getting ready: all that is found, and one more run, must still be repeated."""
        rounds = FEWEST_REPEATS * (sum(self.estimates.values()) + frame)
        return self.clock.left - max(self._for_rounds, rounds)

    def _has_time_for(self, what: str, seconds: float, frame: float = 0.0) -> bool:
        """Whether there is time to get something ready; what has none is noted."""
        fits = seconds <= self._left(frame)
        if not fits:
            self.left_out[what] = "there was no time for it"
        return fits

    def _add(self, row: Row, run: Run, seconds: float) -> None:
        """What ran once, which warmed it up; again if that was short. What cannot be repeated is left out."""
        if seconds < 0.01 * self.clock.left:
            seconds = min(seconds, timed(run)[1])
        if row.name not in self.needed and self.clock.left < FEWEST_REPEATS * (sum(self.estimates.values()) + seconds):
            self.left_out[row.name] = "there was no time to repeat it"
            return
        self.rows[row.name], self.runs[row.name], self.estimates[row.name] = row, run, seconds

    # -- what is measured

    def _at_vertices(self) -> None:
        found, reasons = variants(self.subject, self.tolerance)
        self.left_out |= reasons
        for variant in found:
            if variant.name in self.needed or self._has_time_for(variant.name, _FOR_VARIANT * self.exact_seconds):
                self._add_variant(variant)

    def _add_variant(self, variant: Variant) -> None:
        self.clock.say(variant.name)
        colors, seconds = timed(variant.run)
        own, light_model = self.subject.truth, NO_ERROR
        if variant.equation is not self.subject.equation:
            own = self.subject.exact(variant.equation)
            light_model = vertex_errors(own, self.subject.truth)
        self._add(variant.row(vertex_errors(colors, own), light_model), variant.run, seconds)

    def _sampling(self) -> None:
        screen = self.subject.screen
        if screen is None or not self._has_time_for("rays", 2.0 * screen.seconds):
            return
        clock = self.clock.part(_FOR_SAMPLING * self._left())
        self.sampled = sampling(self.subject, screen, self.tolerance, clock)
        self.left_out |= self.sampled.left_out

    def _inside(self) -> None:
        if not self._has_time_for("inside triangles", least_seconds(self.source, self.exact_seconds)):
            return
        if self.subject.unshadowed is not self.subject:
            why = "no rays are cast there; interpolation is measured without them"
            self.left_out["shadows and occlusion inside triangles"] = why
        clock = self.clock.part(_FOR_INSIDE * self._left())
        self.found_inside = inside(self.source, self.subject.unshadowed, self.tolerance, self.exact_seconds, clock)
        self.left_out |= self.found_inside.left_out
        for one in self.found_inside.refined:
            backend = self.subject.backend_for(len(one.points), self.subject.unshadowed.equation)
            run = self._refined_run(one, backend)
            self._add(one.row(backend), run, timed(run)[1])

    def _refined_run(self, one: Refined, backend: Backend) -> Run:
        s = self.subject.unshadowed

        def run() -> object:
            vertices = Vertices(one.points, one.normals)
            return Plan.of(s.scene, s.material, vertices, matrix=s.matrix).run(vertices, backend=backend)

        return run

    def _effects(self) -> None:
        for effect, equation in withouts(self.subject).items():
            if not self._has_time_for(f"ledger: {effect}", _FOR_EFFECT * self.exact_seconds):
                continue
            self.clock.say(f"without {effect}")
            without = dropped(self.subject, effect, equation)
            name = _without(effect)
            self.missing.append(without)
            self.runs[name], self.estimates[name] = without.run, min(timed(without.run)[1] for _ in range(2))

    # -- peers, which may take long

    def _peers(self) -> None:
        found, reasons = peers(self.subject)
        self.left_out |= reasons
        for variant in found:
            if self._has_time_for(variant.name, _FOR_PEER * self.exact_seconds):
                self._add_variant(variant)
        if self._has_time_for(LIGHT_SOURCE, _FOR_PEER * self.exact_seconds):
            self._unless_refused(LIGHT_SOURCE, self._light_source)
        frame = _PER_FRAME + self.source.n_cells * _PER_FACE
        if self._has_time_for(PER_PIXEL, _FOR_WINDOWS + 4.0 * frame, 2.0 * frame):
            self._unless_refused(PER_PIXEL, self._per_pixel)

    def _unless_refused(self, name: str, measure: Callable[[], None]) -> None:
        self.clock.say(name)
        try:
            measure()
        except ValueError as error:
            self.left_out[name] = str(error)

    def _light_source(self) -> None:
        s = self.subject
        field = height_field(s.points, s.normals, s.matrix)
        run = hillshading(field, s.equation)
        shown, seconds = timed(run)
        errors = vertex_errors(shown.reshape(-1, 3), s.truth[field.vertices.ravel()])
        note = "its own normals, from differences of heights; brightness stretched from the least to the greatest"
        row = Row(
            LIGHT_SOURCE, "light model", UNTIMED, None, errors, None, len(s.points), "Matplotlib", "float64",
            is_peer=True, note=note,
        )  # fmt: skip
        self._add(row, run, seconds)

    def _per_pixel(self) -> None:
        from pvphong.studies.accuracy.frames import FRAME, vtk_frames

        s = self.subject
        frames = self.stack.enter_context(vtk_frames(self.source, s.truth, s.scene, s.material, s.matrix))
        note = f"a frame of {FRAME[0]} × {FRAME[1]} pixels, {frames.driver}"
        given = f"drawn {frames.changed}" if frames.changed else "its error is 0 by definition"
        self._add_frame(PER_PIXEL, NO_ERROR, f"{note}; {given}", frames.per_pixel)
        own = self.rows.get(AS_IT_IS)
        if own is not None:
            self._add_frame(LIT_ARRAY, own.error, f"{note}; not evaluated anew", frames.lit_array)

    def _add_frame(self, name: str, error: Errors, note: str, draw: Run) -> None:
        row = Row(
            name, "interpolation", UNTIMED, None, None, error, self.source.n_points, "VTK", "float32",
            is_peer=True, note=note,
        )  # fmt: skip
        self._add(row, draw, timed(draw)[1])

    # -- the result

    def _times(self) -> dict[str, Float64Array]:
        kept = fitting(self.estimates, self.needed, self.clock.left)
        self.left_out |= {name: "there was no time to repeat it" for name in self.runs if name not in kept}
        return interleaved({name: run for name, run in self.runs.items() if name in kept}, self.estimates, self.clock)

    def _report(self, times: dict[str, Float64Array]) -> Tradeoff:
        s, baseline = self.subject, times[self.baseline]
        rows = [replace(row, time=Timing.of(times[name])) for name, row in self.rows.items() if name in times]
        costs = {
            without.effect: baseline - times[_without(without.effect)] + self.sampled.costs.get(without.effect, 0.0)
            for without in self.missing
            if _without(without.effect) in times
        }
        told = facts(self.source, s.scene, s.material)
        told["measured"] = (
            f"{len(baseline)} rounds in turns after a warm-up, slow runs in some of them only; "
            "a sample is the least of up to 7 short runs"
        )
        return Tradeoff(
            tolerance=self.tolerance,
            rows=with_fronts([*rows, *self.sampled.rows]),
            ledger=ledger(s, s.plan(self.tolerance), self.missing, costs),
            baseline=self.baseline,
            promises=self.promised,
            left_out=self.left_out,
            facts=told,
            inside_errors=self.found_inside.errors,
            inside_areas=self.found_inside.areas,
            surface=self.source,
            _subject=s,
        )


def _without(effect: str) -> str:
    return f"without {effect}"
