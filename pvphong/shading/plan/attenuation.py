"""Attenuation with distance: left out where it is, or nearly is, the same for all vertices."""

from __future__ import annotations

from dataclasses import replace

from pvphong.geometry.extent import ROUNDED_UP, sight
from pvphong.optics.lights import PointLight, SpotLight
from pvphong.shading.equation import BRIGHTEST, LightTerm
from pvphong.shading.plan.bounds import attenuation, whole
from pvphong.shading.plan.draft import Change, Draft, Effect, Note, decision, for_each_term

NAME = "attenuation"
_NONE = (1.0, 0.0, 0.0)


def _attenuated(term: LightTerm) -> bool:
    return isinstance(term.light, (PointLight, SpotLight)) and tuple(term.light.attenuation) != _NONE


def _leave_out(draft: Draft, term: LightTerm) -> Change:
    light = term.light
    if not isinstance(light, (PointLight, SpotLight)) or not _attenuated(term):
        return None
    constant, linear, quadratic = light.attenuation
    if not linear and not quadratic:
        return _fold(draft, term, light, 1.0 / constant, f"constant, {1.0 / constant:g}", 0.0)
    seen = sight(light.position, draft.extent)
    if not draft.allowance or seen is None or seen.distance <= seen.radius:
        return None
    reach = seen.radius * ROUNDED_UP
    near, far = (attenuation(light.attenuation, seen.distance + way) for way in (-reach, reach))
    bound = term.gain * whole(term) * (near - far) / 2 * ROUNDED_UP
    if not bound <= draft.allowance:
        return None
    return _fold(draft, term, light, (near + far) / 2, f"even over the mesh to {bound:.2g}", bound)


def _fold(
    draft: Draft, term: LightTerm, light: PointLight | SpotLight, factor: float, why: str, bound: float
) -> Change:
    """The attenuation as a factor of the light's colours."""
    if not 1.0 / BRIGHTEST < term.gain * factor < BRIGHTEST:
        return None
    even = replace(term, light=replace(light, attenuation=_NONE), gain=term.gain * factor)
    return even, Note(NAME, draft.label(term), why, bound)


EFFECT = Effect(
    NAME,
    ("points",),
    for_each_term(_leave_out),
    lambda draft: decision(draft, NAME, draft.labels_where(_attenuated), "no light weakens with distance"),
    each=0.7,
)
