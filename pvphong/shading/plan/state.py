"""The state of a plan: an equation that effects rewrite, bounds on the vertices, and the simplifications.

An effect that a scene does not need is removed by rewriting the equation into a cheaper one: a black term is deleted,
and a spot light whose cone contains the whole mesh becomes a point light. Evaluators run the resulting equation and do
not depend on plans.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

from pvphong.geometry.extent import ROUNDED_UP, MeshBounds
from pvphong.optics.light import Light
from pvphong.shading.equation import Equation, LightTerm
from pvphong.shading.plan import lights
from pvphong.shading.plan.lights import LightBounds
from pvphong.shading.vertices import Vertices
from pvphong.shading.visibility import TransportLike, VisibilityLike

BOUNCES = "bounces"
"""Name of the effect whose bounds are errors of the colours. Bounds of other effects are errors of direct light."""


@dataclass(frozen=True)
class Decision:
    """Decision on an effect, and its reason.

    Attributes
    ----------
    on : bool
        True if the effect runs.
    why : str
        Reason as text.
    bound : float
        Largest absolute colour error from omitting the effect for some or all lights; 0 if the colours stay exact.
    lights : int
        Number of lights for which the effect runs; 0 for an effect that does not concern lights.
    """

    on: bool
    why: str
    bound: float = 0.0
    lights: int = 0


class Simplification(NamedTuple):
    """One change of the equation: an effect was omitted, for one light or for all.

    `light` is the light's label, or "" if the effect does not concern one light. `bound` is the largest colour error.
    `only_for_this_viewer` is True if another viewer may need the effect.
    """

    effect: str
    light: str
    why: str
    bound: float = 0.0
    only_for_this_viewer: bool = False


@dataclass(frozen=True)
class PlanState:
    """The state of a plan while it is made: the equation so far, and bounds that decide which effects are removed.

    Parameters
    ----------
    equation : Equation
        The equation so far.
    shining : int
        Number of lights that contribute; the tolerance is divided among them.
    extent : MeshBounds
        Bounds on positions and normals of the vertices.
    tolerance : float
        Total error that is allowed in the sum of all light. The colour is this sum, raised to 1/gamma.
    simplifications : tuple of Simplification
        Changes of the equation so far.
    visibility : VisibilityLike or None
        Visibility from the vertices, if known.
    transport : TransportLike or None
        Light transport between the vertices, if known.
    gain : float
        Factor by which bounced light amplifies an error of direct light.
    """

    equation: Equation
    shining: int
    extent: MeshBounds
    tolerance: float
    simplifications: tuple[Simplification, ...] = ()
    visibility: VisibilityLike | None = None
    transport: TransportLike | None = None
    gain: float = 1.0
    _reaches: dict[int, tuple[Light, LightBounds]] = field(default_factory=dict)

    @classmethod
    def first(cls, equation: Equation, tolerance: float, vertices: Vertices) -> PlanState:
        """Return the state of an equation before any effect is removed.

        `tolerance` is the largest colour error. The state's tolerance is for the sum of all light, which is raised to
        1/gamma to give the colour.
        """
        # sums of light that differ by x differ by at most x^(1/gamma) when they are raised to 1/gamma
        allowed, extent = tolerance**equation.gamma, vertices.extent(equation.matrix)
        shining = sum(not term.is_black for term in equation.terms)
        off = (Simplification("lights", label, "switched off") for label in equation.off)
        unblocked = (Simplification("shadow", label, "casts no shadows") for label in equation.unblocked)
        notes = (*off, *unblocked)
        return cls(equation, shining, extent, allowed, notes, vertices.visibility, vertices.transport)

    def reach(self, term: LightTerm) -> LightBounds:
        """Return the bounds on the contribution of a term's light. They are cached: several effects need them."""
        light, reach = self._reaches.get(term.index, (None, LightBounds()))
        if light is not term.light:
            reach = lights.reach(term.light, self.extent)
            self._reaches[term.index] = term.light, reach
        return reach

    @cached_property
    def error_bound(self) -> float:
        """Bound on the error of a colour: the sum over the simplifications so far."""
        return math.fsum(map(self._of_colors, self.simplifications)) * ROUNDED_UP

    def _of_colors(self, note: Simplification) -> float:
        """Return the bound on the colour error of the simplification `note`.

        For direct light, it is multiplied by `gain`.
        """
        return note.bound if note.effect == BOUNCES else note.bound * self.gain

    @cached_property
    def allowance(self) -> float:
        """Error of direct light that the next approximation may add; 0 if no approximation is allowed.

        Each light may use the same fraction of the tolerance, or what remains of the tolerance if this is less.
        """
        if not self.tolerance:
            return 0.0
        share = self.tolerance / (2 * max(self.shining, 1))
        return min(share, max(self.tolerance - self.error_bound, 0.0) / ROUNDED_UP**2) / self.gain

    def rewritten(self, equation: Equation, *simplifications: Simplification) -> PlanState:
        """Return the state with another equation, and with `simplifications` appended."""
        return replace(self, equation=equation, simplifications=(*self.simplifications, *simplifications))

    def why_without(self, effect: str) -> str:
        """Return the reasons for omitting an effect so far, each with the lights that it concerns.

        Return "" if the effect was not omitted.
        """
        lights_by_reason = defaultdict[str, list[str]](list)
        for note in self.simplifications:
            if note.effect == effect:
                lights_by_reason[note.why].append(note.light)
        return "; ".join(
            f"{', '.join(filter(None, lights))}: {why}".removeprefix(": ") for why, lights in lights_by_reason.items()
        )

    def bound_of(self, effect: str) -> float:
        """Return the bound on the colour error from omitting `effect`: the sum over its simplifications."""
        return math.fsum(self._of_colors(note) for note in self.simplifications if note.effect == effect)
