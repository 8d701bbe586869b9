"""What each effect costs on a mesh, what its absence would do, and what the plan promised against what came of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from pvphong.base.types import Float64Array, FloatArray
from pvphong.scene.scene import light_labels
from pvphong.shading.equation import Equation
from pvphong.shading.plan.draft import Draft
from pvphong.shading.plan.effects import EFFECTS
from pvphong.shading.plan.plan import Plan
from pvphong.studies.accuracy.rows import LedgerEntry, Promise, Timing, vertex_errors
from pvphong.studies.accuracy.simplifications import WITHOUT, without_light
from pvphong.studies.accuracy.subject import Subject


class Without(NamedTuple):
    """The equation without one effect or light."""

    effect: str
    equation: Equation
    run: Callable[[], FloatArray]
    error: float


def withouts(subject: Subject) -> dict[str, Equation]:
    """What each effect and light that is there leaves when it is dropped."""
    whole, needed, (middle, _) = subject.assembled, subject.equation, subject.sphere
    there = subject.plan().effects
    result = {name: drop(whole, middle) for name, drop in WITHOUT.items() if there[name].on}
    if len(needed.terms) > 1:
        labels = light_labels(subject.scene)
        result |= {f"light {labels[term.index]}": without_light(whole, term.index) for term in needed.terms}
    return result


def dropped(subject: Subject, effect: str, equation: Equation) -> Without:
    """One effect's absence, with the largest error that it makes."""
    error = vertex_errors(subject.exact(equation), subject.truth).largest
    kept = {term.index for term in equation.terms}
    gone = {term.index for term in subject.assembled.terms} - kept
    lights = tuple(light for index, light in enumerate(subject.scene.lights) if index not in gone)
    scene = replace(subject.scene, lights=lights) if gone else None  # what is not there is not assembled either
    return Without(effect, equation, subject.runner(equation, scene=scene), error)


def ledger(
    subject: Subject, plan: Plan, missing: list[Without], costs: dict[str, Float64Array]
) -> tuple[LedgerEntry, ...]:
    """An entry for every effect of the plan and every light.

    Parameters
    ----------
    subject : Subject
        What is lit.
    plan : Plan
        At the tolerance.
    missing : list of Without
        The effects and lights that are there.
    costs : dict of str to ndarray
        Seconds with minus seconds without, round by round, of those that were measured, and of casting their rays.
    """
    errors = {without.effect: without.error for without in missing}
    timings = {name: Timing.of(seconds) for name, seconds in costs.items()}
    entries = [
        LedgerEntry(name, timings.get(name), errors.get(name), choice.on, choice.why)
        for name, choice in plan.effects.items()
    ]
    kept = {term.index for term in plan.equation.terms}
    for index, label in enumerate(light_labels(subject.scene)):
        name = f"light {label}"
        if name in errors:
            why = "" if index in kept else "left out, see lights"
            entries.append(LedgerEntry(name, timings.get(name), errors[name], index in kept, why))
    return tuple(entries)


def promises(subject: Subject, tolerance: float) -> tuple[Promise, ...]:
    """Each approximation of the plan at a tolerance: the bound that it took, the difference that it makes."""
    extent = subject.vertices.extent(subject.assembled.matrix)
    draft = Draft.first(subject.assembled, extent, tolerance, subject.screen)
    found = []
    for effect in EFFECTS:
        before, draft = draft, effect.simplify(draft)
        notes = [note for note in draft.notes[len(before.notes) :] if note.bound]
        if notes:
            measured = vertex_errors(subject.exact(draft.equation), subject.exact(before.equation)).largest
            why = "; ".join(f"{note.light}: {note.why}".removeprefix(": ") for note in notes)
            found.append(Promise(effect.name, why, sum(note.bound for note in notes), measured))
    return tuple(found)
