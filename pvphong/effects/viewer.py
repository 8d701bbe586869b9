"""The local viewer, and the turning of normals to it."""

from __future__ import annotations

import math
from dataclasses import replace

from pvphong.effects._bounds import highlight_change, strongest, widest_to_viewer
from pvphong.effects._draft import ROUNDED_UP, Decision, Draft, Effect, Note, peak, sight, turn, unchanged
from pvphong.equation import LightTerm
from pvphong.lights import DirectionalLight, PointLight, SpotLight

NAME = "local viewer"


def _leave_out(draft: Draft) -> Draft:
    equation = draft.equation
    if equation.eye is None or not equation.has_highlights or equation.is_flipped or not draft.allowance:
        return draft
    seen = sight(equation.eye, draft)
    if seen is None or seen[1] < 2 * seen[2]:
        return draft
    delta = turn(seen[1], seen[2])
    bound = math.fsum(_change(draft, term, delta) for term in equation.terms if any(term.specular)) * ROUNDED_UP
    if not bound <= draft.allowance:
        return draft
    why = f"far away: its direction is the same to {bound:.2g}"
    return replace(
        draft,
        equation=replace(equation, eye=None, to_eye=seen[0], local_facing=False),
        notes=(*draft.notes, Note(NAME, "", why, bound)),
    )


def _change(draft: Draft, term: LightTerm, delta: float) -> float:
    light, angle = term.light, 0.0
    if isinstance(light, DirectionalLight):
        x, y, z = light.arrival(draft.extent.nowhere).direction[:, 0].tolist()
        direction = (x, y, z)
    else:
        assert isinstance(light, (PointLight, SpotLight))
        seen = sight(light.position, draft)
        if seen is None:
            return math.inf
        direction, angle = seen[0], turn(seen[1], seen[2])
    change = highlight_change(draft.equation, delta, widest_to_viewer(draft, direction, angle), light_moves=False)
    return strongest(draft, term) * peak(term.specular) * change


def _decide(draft: Draft) -> Decision:
    equation = draft.equation
    if equation.needs_eye:
        return Decision(True, "highlights" if equation.has_highlights else "normals are turned to it")
    if draft.because(NAME):
        return Decision(False, draft.because(NAME), draft.bound_of(NAME))
    if equation.has_highlights:
        return Decision(False, "the viewer is at infinity")
    return Decision(False, "no highlight is left that depends on it")


LOCAL_VIEWER = Effect(NAME, ("points", "viewer"), _leave_out, _decide)


def _decide_flip(draft: Draft) -> Decision:
    if draft.equation.is_flipped:
        return Decision(True, "vertices that face away are lit with the opposite normal")
    if draft.equation.two_sided:
        return Decision(False, "nothing depends on the normal")
    return Decision(False, "the light model is one-sided")


TWO_SIDED = Effect("two-sided", ("normals", "viewer"), unchanged, _decide_flip)
