"""Diffuse and specular reflection of each light."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from pvphong.base.types import Vector
from pvphong.geometry.extent import ROUNDED_UP
from pvphong.optics.light import Reach
from pvphong.optics.reflectance import Component
from pvphong.shading.equation import Equation, LightTerm
from pvphong.shading.plan.bounds import sightline
from pvphong.shading.plan.draft import Change, Decision, Draft, Effect, Note, decision, for_each_term, unchanged


def _decide(component: Component) -> Callable[[Draft], Decision]:
    def decide(draft: Draft) -> Decision:
        return decision(draft, component, lambda term: draft.equation.has(term, component), f"black {component} colour")

    return decide


def _without(component: Component) -> Callable[[Equation, Vector], Equation]:
    def without(equation: Equation, _point: Vector) -> Equation:
        return replace(equation, terms=tuple(equation.without(term, component) for term in equation.terms))

    return without


def _leave_out_highlight(draft: Draft, term: LightTerm) -> Change:
    equation = draft.equation
    if not draft.allowance:
        return None
    peak = sum([max(term.colors[k]) * equation.largest[k] for k in equation.lobes_of("specular")])
    if not peak:
        return None
    reach = draft.reach(term)
    anywhere = term.gain * reach.strongest * peak * ROUNDED_UP
    is_weak = anywhere <= draft.allowance
    bound = anywhere if is_weak else anywhere * _reached(draft, term, reach) * ROUNDED_UP
    if not bound <= draft.allowance:
        return None
    why = f"its highlight {'is too weak to be seen' if is_weak else 'hardly reaches a vertex'}, at most {bound:.2g}"
    return equation.without(term, "specular"), Note("specular", term.label, why, bound, here=not is_weak)


def _reached(draft: Draft, term: LightTerm, reach: Reach) -> float:
    """The largest part of a highlight that normals and directions allow: 1 where nothing is known."""
    equation = draft.equation
    known = None if equation.is_flipped or equation.fields_with_maps else sightline(draft, reach)
    if known is None:
        return 1.0
    reflectance = equation.reflectance
    return max(
        reflectance.most(k, known) / reflectance.most(k) for k in equation.lobes_of("specular") if any(term.colors[k])
    )


# A black diffuse product is a zero coefficient of its term, which every evaluator skips: nothing is rewritten.
DIFFUSE = Effect("diffuse", ("normals",), unchanged, _decide("diffuse"), _without("diffuse"), once=0.5, each=0.2)
SPECULAR = Effect(
    "specular",
    ("normals", "viewer"),
    for_each_term(_leave_out_highlight),
    _decide("specular"),
    _without("specular"),
    each=1.4,
)
