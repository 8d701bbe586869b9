"""What stands before the vertices: shadows, and ambient occlusion."""

from __future__ import annotations

from dataclasses import replace

from pvphong.base.types import Vector
from pvphong.shading.equation import Equation, LightTerm
from pvphong.shading.plan.draft import Change, Decision, Draft, Effect, Note, decision, every_term, for_each_term

_SHADOW, _OCCLUSION = "shadow", "occlusion"
_NO_SHADOWS, _NO_OCCLUSION = "the light model has no shadows", "the light model has no ambient occlusion"


def _unshadowed(term: LightTerm, _point: Vector) -> LightTerm:
    return replace(term, is_shadowed=False)


def _leave_out_shadow(draft: Draft, term: LightTerm) -> Change:
    if not term.is_shadowed:
        return None
    why = "" if draft.screen is None else draft.screen.why_clear(term.index)
    if not term.needs_normals:
        why = "adds ambient light alone"
    return (replace(term, is_shadowed=False), Note(_SHADOW, term.label, why)) if why else None


def _decide_shadow(draft: Draft) -> Decision:
    return decision(draft, _SHADOW, lambda term: term.is_shadowed, _NO_SHADOWS)


def _leave_out_occlusion(draft: Draft) -> Draft:
    equation = draft.equation
    if not equation.is_occluded:
        return draft
    why = "" if draft.screen is None else draft.screen.why_open()
    if not (any(equation.ambient) or any(any(term.ambient) for term in equation.terms)):
        why = "there is no ambient light"
    if not why:
        return draft
    open_sky = replace(equation, is_occluded=False)
    return replace(draft, equation=open_sky, notes=(*draft.notes, Note(_OCCLUSION, "", why)))


def _decide_occlusion(draft: Draft) -> Decision:
    if draft.equation.is_occluded:
        return Decision(True, "ambient light, times the open part of the sky")
    return Decision(False, draft.because(_OCCLUSION) or _NO_OCCLUSION)


def _open_sky(equation: Equation, _point: Vector) -> Equation:
    return replace(equation, is_occluded=False)


# Of reading what the vertices see: casting the rays is done once for all materials and colours of lights.
SHADOW = Effect(
    _SHADOW, ("points", "normals"), for_each_term(_leave_out_shadow), _decide_shadow, every_term(_unshadowed), each=0.2
)
OCCLUSION = Effect(_OCCLUSION, ("points", "normals"), _leave_out_occlusion, _decide_occlusion, _open_sky, once=0.2)
