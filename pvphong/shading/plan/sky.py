"""How finely a light from all around is taken: in how many bands of spherical harmonics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from pvphong.base.types import Vector
from pvphong.geometry.extent import ROUNDED_UP
from pvphong.optics.harmonics import BANDS
from pvphong.optics.spherical import CosinePower
from pvphong.shading.equation import Equation, LightTerm
from pvphong.shading.plan.draft import Change, Decision, Draft, Effect, Note, decision, every_term, for_each_term

_SKY = "sky"


def _bands(term: LightTerm) -> int:
    return term.light.bands if term.bands is None else term.bands


def _varies(term: LightTerm) -> bool:
    return _bands(term) > 1


def _leave_out(draft: Draft, term: LightTerm) -> Change:
    """The fewest bands that do."""
    if not draft.allowance:
        return None
    for bands in range(1, _bands(term)):
        bound = _sum(draft.equation, term, partial(term.light.left_out, bands=bands))
        if bound <= draft.allowance:
            why = f"bands from {bands} on, at most {bound:.2g}"
            return replace(term, bands=bands), Note(_SKY, term.label, why, bound)
    return None


def _sum(equation: Equation, term: LightTerm, off: Callable[[CosinePower], float]) -> float:
    """The largest error in a colour, from what a lobe may be off."""
    errors = [
        max(color) * off(form)
        for form, color in zip(equation.forms, term.colors, strict=True)
        if form is not None and any(color)
    ]
    return term.gain * sum(errors) * ROUNDED_UP


def _decide(draft: Draft) -> Decision:
    """With what the bands hold at most that no light has."""
    decided = decision(draft, _SKY, _varies, "no light from all around varies")
    terms = [term for term in draft.equation.terms if _varies(term)]
    if not terms:
        return decided
    count, off = max(map(_bands, terms)), max(_sum(draft.equation, term, term.light.unknown) for term in terms)
    said = f"{', '.join(term.label for term in terms)}: {count} bands, those beyond {BANDS} hold at most {off:.2g}"
    noted = draft.because(_SKY)
    return replace(decided, why=f"{said} (left out: {noted})" if noted else said)


def _as_one_color(term: LightTerm, _point: Vector) -> LightTerm:
    return replace(term, bands=1) if _varies(term) else term


# For each channel, with about nine bands.
SKY = Effect(_SKY, ("normals",), for_each_term(_leave_out), _decide, every_term(_as_one_color), each=13.0)
