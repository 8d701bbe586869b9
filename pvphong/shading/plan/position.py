"""A light's position: left out where the light is so far away that its direction hardly changes."""

from __future__ import annotations

from dataclasses import replace

from pvphong.geometry.extent import ROUNDED_UP, sight
from pvphong.optics.lights import DirectionalLight, PointLight
from pvphong.shading.equation import LightTerm
from pvphong.shading.plan.bounds import highlight_change, widest_to_viewer
from pvphong.shading.plan.draft import Change, Draft, Effect, Note, decision, for_each_term, peak

NAME = "position"


def _leave_out(draft: Draft, term: LightTerm) -> Change:
    light = term.light
    if not draft.allowance or not isinstance(light, PointLight) or tuple(light.attenuation) != (1.0, 0.0, 0.0):
        return None
    seen = sight(light.position, draft.extent)
    if seen is None or seen.distance < 2 * seen.radius:
        return None
    (x, y, z), delta = seen.direction, seen.turn
    bound = peak(term.diffuse) * delta
    if any(term.specular):
        most = widest_to_viewer(draft, (x, y, z), delta)
        bound += peak(term.specular) * highlight_change(draft.equation, delta, most, light_moves=True)
    bound *= term.gain * ROUNDED_UP
    if not bound <= draft.allowance:
        return None
    far = replace(term, light=DirectionalLight(direction=(-x, -y, -z)))
    why = f"far away: its direction is the same to {bound:.2g}"
    return far, Note(NAME, draft.label(term), why, bound)


EFFECT = Effect(
    NAME,
    ("points",),
    for_each_term(_leave_out),
    lambda draft: decision(
        draft,
        NAME,
        draft.labels_where(lambda term: not isinstance(term.light, DirectionalLight)),
        "every light is directional",
    ),
    once=0.5,
    each=0.2,
)
