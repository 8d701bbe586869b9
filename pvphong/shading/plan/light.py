"""Whether each light shines at all: switched on, of some colour, strong enough to be seen."""

from __future__ import annotations

from pvphong.shading.equation import LightTerm
from pvphong.shading.plan.bounds import strongest, whole
from pvphong.shading.plan.draft import NO_LIGHT, Change, Draft, Effect, Note, decision, for_each_term

NAME = "lights"


def _leave_out(draft: Draft, term: LightTerm) -> Change:
    label = draft.label(term)
    if term.is_black:
        return None, Note(NAME, label, "adds black: its colour, intensity or the material's is 0")
    if not draft.allowance:
        return None
    bound = strongest(draft, term) * whole(term)
    if bound <= draft.allowance:
        return None, Note(NAME, label, f"too weak to be seen, at most {bound:.2g}", bound)
    return None


EFFECT = Effect(
    NAME,
    (),
    for_each_term(_leave_out),
    lambda draft: decision(draft, NAME, draft.labels_where(lambda _: True), NO_LIGHT),
)
