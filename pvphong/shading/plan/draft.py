"""What an effect gets to see, and what it gives back.

An effect that a scene does not call for is left out by rewriting the equation into a cheaper one: a black
term goes, a spot whose cone holds the whole mesh becomes a point light. The evaluators know nothing of plans;
they run the equation that is left.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

from pvphong.base.types import Vector
from pvphong.geometry.extent import ANYWHERE, ROUNDED_UP, Extent
from pvphong.optics.light import NOTHING_KNOWN, Light, Reach
from pvphong.shading.equation import Equation, LightTerm
from pvphong.shading.parts import in_parts
from pvphong.shading.screen import Screen


@dataclass(frozen=True)
class Decision:
    """Whether an effect runs, and why.

    Attributes
    ----------
    on : bool
        Whether it runs.
    why : str
        The reason, for people.
    bound : float
        The largest absolute colour error of leaving it out, altogether or for some lights; 0 where that is exact.
    lights : int
        For how many lights it runs, of those it is about.
    """

    on: bool
    why: str
    bound: float = 0.0
    lights: int = 0


class Note(NamedTuple):
    """One rewriting of the equation: which effect was left out, for which light, why, at what error.

    `here`: it holds for the viewer as it is now; for another one the effect may have to run.
    """

    effect: str
    light: str
    why: str
    bound: float = 0.0
    here: bool = False


@dataclass(frozen=True)
class Draft:
    """An equation on its way to what is left of it.

    Parameters
    ----------
    equation : Equation
        As it stands.
    shining : int
        How many of its lights add anything; the tolerance is divided among them.
    extent : Extent
        Where the vertices are.
    tolerance : float
        The colour error that may be taken in all.
    notes : tuple of Note
        What has been left out so far.
    screen : Screen or None
        What stands before the vertices, where that is known.
    """

    equation: Equation
    shining: int
    extent: Extent
    tolerance: float
    notes: tuple[Note, ...] = ()
    screen: Screen | None = None
    _reaches: dict[int, tuple[Light, Reach]] = field(default_factory=dict)

    @classmethod
    def first(cls, equation: Equation, extent: Extent, tolerance: float, screen: Screen | None = None) -> Draft:
        """Of an equation as it was assembled."""
        shining = sum(not term.is_black for term in equation.terms)
        notes = tuple(Note("lights", label, "switched off") for label in equation.off)
        return cls(equation, shining, extent, tolerance, notes, screen)

    def kept(self) -> Draft:
        """What decisions are told from: without the vertices, which a plan that is kept does not keep."""
        return Draft(self.equation, self.shining, ANYWHERE, self.tolerance, self.notes)

    def reach(self, term: LightTerm) -> Reach:
        """What of a light can reach the vertices; several effects ask."""
        light, reach = self._reaches.get(term.index, (None, NOTHING_KNOWN))
        if light is not term.light:
            reach = term.light.reach(self.extent)
            self._reaches[term.index] = term.light, reach
        return reach

    @cached_property
    def error_bound(self) -> float:
        """Sum of the bounds taken so far."""
        return math.fsum(note.bound for note in self.notes) * (ROUNDED_UP if self.notes else 1.0)

    @cached_property
    def allowance(self) -> float:
        """The error that the next approximation may take: its share, or what is left of the tolerance."""
        if not self.tolerance:
            return 0.0
        share = self.tolerance / (2 * max(self.shining, 1))
        return min(share, max(self.tolerance - self.error_bound, 0.0) / ROUNDED_UP**2)

    @cached_property
    def _notes_by_effect(self) -> dict[str, list[Note]]:
        found = defaultdict[str, list[Note]](list)
        for note in self.notes:
            found[note.effect].append(note)
        return dict(found)

    def because(self, effect: str) -> str:
        """The reasons noted for leaving an effect out, each with its lights."""
        reasons = defaultdict[str, list[str]](list)
        for note in self._notes_by_effect.get(effect, ()):
            reasons[note.why].append(note.light)
        return "; ".join(
            f"{', '.join(filter(None, lights))}: {why}".removeprefix(": ") for why, lights in reasons.items()
        )

    def bound_of(self, effect: str) -> float:
        """Sum of the bounds taken by leaving out an effect."""
        return math.fsum(note.bound for note in self._notes_by_effect.get(effect, ()))

    def lights_where(self, holds: Callable[[LightTerm], bool]) -> int:
        """How many lights with some property are evaluated, the parts of those that have a size each for itself."""
        chosen = tuple(term for term in self.equation.terms if holds(term))
        return len(in_parts(replace(self.equation, terms=chosen)).terms)

    def labels_where(self, holds: Callable[[LightTerm], bool]) -> list[str]:
        """Names of the lights whose terms have some property."""
        return [term.label for term in self.equation.terms if holds(term)]


@dataclass(frozen=True)
class Effect:
    """One effect that a scene may call for.

    Parameters
    ----------
    name : str
        Its name in a plan.
    inputs : tuple of str
        What it reads of each vertex, or of the scene: "points", "normals", "viewer".
    simplify : callable
        Draft → Draft: leaves the effect out where it can be.
    decide : callable
        Finished draft → Decision: whether it is still there.
    without : callable
        Equation, point → the equation without the effect, whatever the error; what varies is taken as it is there.
        What the accuracy report measures the effect by; no plan does this.
    once, each : float
        About how many nanoseconds per vertex it takes, whatever the lights, and for each light it runs for.
    """

    name: str
    inputs: tuple[str, ...]
    simplify: Callable[[Draft], Draft]
    decide: Callable[[Draft], Decision]
    without: Callable[[Equation, Vector], Equation]
    once: float = 0.0
    each: float = 0.0

    def nanoseconds(self, choice: Decision) -> float:
        """Per vertex, in the compiled evaluator and in float32 on one core: 0 where it does not run.

        Rounded differences of runs with and without it, measured on a server's processor of 2022 at 3.7 GHz.
        """
        return self.once + self.each * choice.lights if choice.on else 0.0


def unchanged(draft: Draft) -> Draft:
    """For an effect that is left out by others, or never."""
    return draft


Change = tuple[LightTerm | None, *tuple[Note, ...]] | None
"""What is left of a light's term, None for nothing, and why; or None where the term stays as it is."""


def for_each_term(rule: Callable[[Draft, LightTerm], Change]) -> Callable[[Draft], Draft]:
    """A simplification that looks at one light's term after the other; each rule sees the bounds taken before it."""

    def simplify(draft: Draft) -> Draft:
        before = draft.equation.terms
        terms: list[LightTerm] = []
        noted: list[Note] = []
        for term in before:
            change = rule(draft, term)
            if change is None:
                terms.append(term)
                continue
            left, *notes = change
            noted += notes
            if any(note.bound for note in notes):  # exact ones can wait: a draft for each of many would take long
                draft, noted = replace(draft, notes=(*draft.notes, *noted)), []
            if left is not None:
                terms.append(left)
        if noted:
            draft = replace(draft, notes=(*draft.notes, *noted))
        kept = tuple(terms)
        return draft if kept == before else replace(draft, equation=replace(draft.equation, terms=kept))

    return simplify


def every_term(change: Callable[[LightTerm, Vector], LightTerm]) -> Callable[[Equation, Vector], Equation]:
    """A way to leave out an effect that changes one light's term after the other."""

    def without(equation: Equation, point: Vector) -> Equation:
        return replace(equation, terms=tuple(change(term, point) for term in equation.terms))

    return without


NO_LIGHT = "no light reaches the mesh"


def decision(draft: Draft, name: str, has: Callable[[LightTerm], bool], off: str) -> Decision:
    """On where some lights have the effect; else off, for the reasons noted, or because there is no light, or `off`."""
    noted, lights = draft.because(name), draft.labels_where(has)
    if lights:
        why = ", ".join(lights) + (f" (left out: {noted})" if noted else "")
        return Decision(True, why, draft.bound_of(name), draft.lights_where(has))
    return Decision(False, noted or (off if draft.equation.terms else NO_LIGHT), draft.bound_of(name))
