"""The cone of a spot light: left out where the whole mesh lies inside or outside it."""

from __future__ import annotations

import math
from dataclasses import replace

from pvphong.geometry.extent import ROUNDED_UP, sight
from pvphong.optics.lights import PointLight, SpotLight
from pvphong.shading.equation import BRIGHTEST, LightTerm
from pvphong.shading.plan.bounds import angle, strongest, whole
from pvphong.shading.plan.draft import Change, Draft, Effect, Note, decision, for_each_term

NAME = "cone"
# Angles are known to this many radians: arc cosines lose half the digits near 0.
_SLACK = 1e-6


def _leave_out(draft: Draft, term: LightTerm) -> Change:
    if not isinstance(term.light, SpotLight):
        return None
    angles = _angles(draft, term.light)
    if angles is None:
        return None
    least, most = angles
    edge, label = math.radians(term.light.cone_angle), draft.label(term)
    if least > edge + _SLACK:
        margin = math.degrees(least - edge)
        why = f"mesh lies outside the cone by {f'{margin:.0f}' if margin >= 1.0 else f'{margin:.1g}'}°"
        return None, Note(NAME, label, why), Note("lights", label, why)
    if most < edge - _SLACK:
        return _leave_out_falloff(draft, term, term.light, least, most)
    return None


def _leave_out_falloff(draft: Draft, term: LightTerm, spot: SpotLight, least: float, most: float) -> Change:
    """Of a spot that holds the whole mesh."""
    if spot.exponent and not draft.allowance:
        return None  # even where nothing of it is seen: a vertex's last bit is not to depend on the other vertices
    brightest, darkest = (
        max(math.cos(off_axis), 0.0) ** spot.exponent for off_axis in (max(least - _SLACK, 0.0), most + _SLACK)
    )
    middle = (brightest + darkest) / 2
    bound = strongest(draft, term) * whole(term) * (brightest - darkest) / 2 * ROUNDED_UP
    if spot.exponent == 0.0:
        middle, bound = 1.0, 0.0
    if not bound <= draft.allowance or term.gain * middle > BRIGHTEST:
        return None
    point = PointLight(position=spot.position, attenuation=spot.attenuation)
    why = "mesh lies inside the cone" + ("" if not bound else f", whose light is even to {bound:.2g}")
    return replace(term, light=point, gain=term.gain * middle), Note(NAME, draft.label(term), why, bound)


def _angles(draft: Draft, spot: SpotLight) -> tuple[float, float] | None:
    """Least and greatest angle off the axis at which the spot sees the vertices' sphere."""
    seen = sight(spot.position, draft.extent)
    if seen is None:
        return None
    middle, spread = math.pi - angle(seen.direction, spot.axis), seen.turn
    return max(middle - spread, 0.0), min(middle + spread, math.pi)


EFFECT = Effect(
    NAME,
    ("points",),
    for_each_term(_leave_out),
    lambda draft: decision(
        draft, NAME, draft.labels_where(lambda term: isinstance(term.light, SpotLight)), "no spot light"
    ),
    each=1.6,
)
