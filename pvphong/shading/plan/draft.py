"""What effects rewrite: an equation, what is known of the vertices, and notes of what has been left out of it.

An effect that a scene does not call for is left out by rewriting the equation into a cheaper one: a black
term goes, a spot whose cone holds the whole mesh becomes a point light. The evaluators know nothing of plans;
they run the equation that is left.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

from pvphong.geometry.extent import ROUNDED_UP, Extent
from pvphong.optics.light import Light
from pvphong.shading.equation import Equation, LightTerm
from pvphong.shading.plan import lights
from pvphong.shading.plan.lights import Reach
from pvphong.shading.vertices import Vertices
from pvphong.shading.visibility import TransportLike, VisibilityLike

BOUNCES = "bounces"
"""The effect whose bounds are of colours; those of others are of direct light."""


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

    `only_for_this_viewer`: it holds for the viewer as it is now; for another one the effect may have to run.
    """

    effect: str
    light: str
    why: str
    bound: float = 0.0
    only_for_this_viewer: bool = False


@dataclass(frozen=True)
class Draft:
    """An equation while effects rewrite it.

    Parameters
    ----------
    equation : Equation
        What is left so far.
    shining : int
        How many of its lights add anything; the tolerance is divided among them.
    extent : Extent
        Where the vertices are.
    tolerance : float
        The error that may be taken in all, before the sum of light is raised to 1/gamma.
    notes : tuple of Note
        What has been left out so far.
    visibility : VisibilityLike or None
        What the vertices see, where that is known.
    transport : TransportLike or None
        What they see of each other, where that is known.
    gain : float
        By how much light that bounces makes an error of direct light larger.
    """

    equation: Equation
    shining: int
    extent: Extent
    tolerance: float
    notes: tuple[Note, ...] = ()
    visibility: VisibilityLike | None = None
    transport: TransportLike | None = None
    gain: float = 1.0
    _reaches: dict[int, tuple[Light, Reach]] = field(default_factory=dict)

    @classmethod
    def first(cls, equation: Equation, tolerance: float, vertices: Vertices) -> Draft:
        """The draft of an equation as it was assembled, with the tolerance of colours as that of sums of light."""
        # sums of light that differ by x differ by at most x^(1/gamma) when they are raised to 1/gamma
        allowed, extent = tolerance**equation.gamma, vertices.extent(equation.matrix)
        shining = sum(not term.is_black for term in equation.terms)
        notes = tuple(Note("lights", label, "switched off") for label in equation.off)
        return cls(equation, shining, extent, allowed, notes, vertices.visibility, vertices.transport)

    def reach(self, term: LightTerm) -> Reach:
        """What of a light can reach the vertices; kept, for several effects need it."""
        light, reach = self._reaches.get(term.index, (None, Reach()))
        if light is not term.light:
            reach = lights.reach(term.light, self.extent)
            self._reaches[term.index] = term.light, reach
        return reach

    @cached_property
    def error_bound(self) -> float:
        """Sum of the bounds taken so far."""
        return math.fsum(map(self._of_colors, self.notes)) * ROUNDED_UP

    def _of_colors(self, note: Note) -> float:
        """The error of the colours: that of direct light bounces with it."""
        return note.bound if note.effect == BOUNCES else note.bound * self.gain

    @cached_property
    def allowance(self) -> float:
        """The error that the next approximation may take: its share, or what is left of the tolerance."""
        if not self.tolerance:
            return 0.0
        share = self.tolerance / (2 * max(self.shining, 1))
        return min(share, max(self.tolerance - self.error_bound, 0.0) / ROUNDED_UP**2) / self.gain

    def rewritten(self, equation: Equation, *notes: Note) -> Draft:
        """The draft of another equation, and what more has been left out of it."""
        return replace(self, equation=equation, notes=(*self.notes, *notes))

    def why_without(self, effect: str) -> str:
        """The reasons noted for leaving an effect out, each with its lights; "" where there are none."""
        lights_by_reason = defaultdict[str, list[str]](list)
        for note in self.notes:
            if note.effect == effect:
                lights_by_reason[note.why].append(note.light)
        return "; ".join(
            f"{', '.join(filter(None, lights))}: {why}".removeprefix(": ") for why, lights in lights_by_reason.items()
        )

    def bound_of(self, effect: str) -> float:
        """Sum of the bounds taken by leaving out an effect."""
        return math.fsum(self._of_colors(note) for note in self.notes if note.effect == effect)
