"""The local viewer, and the turning of normals to it."""

from __future__ import annotations

import math
from dataclasses import replace

from pvphong.base.types import Vector
from pvphong.base.vectors import angle_between
from pvphong.geometry.extent import ROUNDED_UP
from pvphong.shading.equation import Equation, LightTerm
from pvphong.shading.plan.bounds import ApparentDirection, largest_change, viewer_seen
from pvphong.shading.plan.draft import Decision, Draft, Effect, Note

NAME = "local viewer"
# Float32 knows which side of a surface the viewer is on unless he is within this many radians of its plane.
_SLACK = 1e-4


def _leave_out(draft: Draft) -> Draft:
    equation = draft.equation
    if equation.eye is None or not equation.has_highlights or equation.is_flipped or not draft.allowance:
        return draft
    seen = draft.extent.sight(equation.eye)
    if seen is None or seen.distance < 2 * seen.radius:
        return draft
    delta = seen.turn
    bound = (
        math.fsum(_change(draft, term, delta) for term in equation.terms if equation.needs_viewer(term)) * ROUNDED_UP
    )
    if not bound <= draft.allowance:
        return draft
    why = f"far away: its direction is the same to {bound:.2g}"
    return replace(
        draft,
        equation=replace(equation, eye=None, to_eye=seen.direction, local_facing=False),
        notes=(*draft.notes, Note(NAME, "", why, bound, here=True)),
    )


def _change(draft: Draft, term: LightTerm, delta: float) -> float:
    reach = draft.reach(term)
    if reach.direction is None:
        return math.inf
    change = largest_change(draft, term, ApparentDirection(reach.direction, reach.turn), delta, light_moves=False)
    return term.gain * reach.strongest * change if change else 0.0


def _decide(draft: Draft) -> Decision:
    equation = draft.equation
    if equation.needs_eye:
        return Decision(True, _what_reads_it(equation))
    if draft.because(NAME):
        return Decision(False, draft.because(NAME), draft.bound_of(NAME))
    if equation.has_highlights:
        return Decision(False, "the viewer is at infinity")
    return Decision(False, "no highlight is left that depends on it")


def _what_reads_it(equation: Equation) -> str:
    if not equation.has_highlights:
        return "normals are turned to it"
    return "highlights" if any(equation.has(term, "specular") for term in equation.terms) else "diffuse reflection"


def _without(equation: Equation, _point: Vector) -> Equation:
    """The viewer at infinity, along the view axis: what `LightModel(local_viewer=False)` asks for."""
    return replace(equation, eye=None, local_facing=False)


LOCAL_VIEWER = Effect(NAME, ("points", "viewer"), _leave_out, _decide, _without, once=0.6)


def _leave_out_flip(draft: Draft) -> Draft:
    """Where no vertex faces away. A closed mesh seen from outside hides the others, but their colours are data too."""
    equation = draft.equation
    cone = draft.extent.normal_cone if equation.is_flipped else None
    seen = viewer_seen(draft, equation.eye if equation.local_facing else None) if cone else None
    if cone is None or seen is None:
        return draft
    (axis, opening), (v, spread) = cone, seen
    if angle_between(axis, v) + opening + spread > math.pi / 2 - _SLACK:
        return draft
    note = Note("two-sided", "", "no vertex faces away from the viewer", here=True)
    return replace(draft, equation=replace(equation, two_sided=False), notes=(*draft.notes, note))


def _decide_flip(draft: Draft) -> Decision:
    if draft.equation.is_flipped:
        return Decision(True, "vertices that face away are lit with the opposite normal")
    if draft.because("two-sided"):
        return Decision(False, draft.because("two-sided"))
    if draft.equation.two_sided:
        return Decision(False, "nothing depends on the normal")
    return Decision(False, "the light model is one-sided")


TWO_SIDED = Effect(
    "two-sided",
    ("normals", "viewer"),
    _leave_out_flip,
    _decide_flip,
    lambda equation, _: replace(equation, two_sided=False),
    once=0.5,
)
