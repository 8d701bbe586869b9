"""Whether each light shines at all: switched on, of some colour, strong enough to be seen."""

from __future__ import annotations

from pvphong.effects._bounds import strongest, whole
from pvphong.effects._draft import Decision, Draft, Effect, Note, for_each_term
from pvphong.equation import LightTerm

NAME = "lights"


def _leave_out(draft: Draft, term: LightTerm) -> Draft:
    label, brightness = draft.label(term), whole(term)
    if brightness == 0.0:
        return draft.with_term(
            term, None, Note(NAME, label, "adds black: its colour, intensity or the material's is 0")
        )
    if not draft.allowance:
        return draft
    bound = strongest(draft, term) * brightness
    if bound <= draft.allowance:
        why = f"too weak to be seen, at most {bound:.2g}"
        return draft.with_term(term, None, Note(NAME, label, why, bound))
    return draft


def _decide(draft: Draft) -> Decision:
    shining = [draft.label(term) for term in draft.equation.terms]
    left_out = draft.because(NAME)
    if shining:
        return Decision(
            True, ", ".join(shining) + (f" (left out: {left_out})" if left_out else ""), draft.bound_of(NAME)
        )
    return Decision(False, left_out or "no light is on", draft.bound_of(NAME))


EFFECT = Effect(NAME, (), for_each_term(_leave_out), _decide)
