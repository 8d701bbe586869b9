"""Diffuse and specular reflection of each light."""

from __future__ import annotations

import math
from dataclasses import replace

from pvphong.geometry.extent import ROUNDED_UP
from pvphong.shading.equation import LightTerm
from pvphong.shading.plan.bounds import angle, light_seen, strongest, viewer_seen, widest_to_viewer
from pvphong.shading.plan.draft import Change, Draft, Effect, Note, decision, for_each_term, peak, unchanged

_BLACK = (0.0, 0.0, 0.0)

# A black diffuse product is a zero coefficient of its term, which every evaluator skips: nothing is rewritten.
DIFFUSE = Effect(
    "diffuse",
    ("normals",),
    unchanged,
    lambda draft: decision(
        draft, "diffuse", draft.labels_where(lambda term: any(term.diffuse)), "black diffuse colour"
    ),
    once=0.5,
    each=0.2,
)


def _leave_out_highlight(draft: Draft, term: LightTerm) -> Change:
    if not any(term.specular) or not draft.allowance:
        return None
    anywhere = strongest(draft, term) * peak(term.specular) * ROUNDED_UP
    is_weak = anywhere <= draft.allowance
    bound = anywhere if is_weak else anywhere * _reach(draft, term) * ROUNDED_UP
    if not bound <= draft.allowance:
        return None
    why = f"its highlight {'is too weak to be seen' if is_weak else 'hardly reaches a vertex'}, at most {bound:.2g}"
    return replace(term, specular=_BLACK), Note("specular", draft.label(term), why, bound, here=not is_weak)


def _reach(draft: Draft, term: LightTerm) -> float:
    """The largest highlight factor fⁿ that normals and directions allow: 1 where nothing is known.

    With θ the angle from n to l, φ from n to v and ψ from l to v: r·v = 2 cos θ cos φ − cos ψ, and
    n·h = (cos θ + cos φ) / (2 cos ψ/2); both grow with smaller θ and φ and greater ψ.
    """
    equation, cone = draft.equation, draft.extent.normal_cone
    if equation.headlight_only or equation.is_flipped or equation.shininess == 0.0 or cone is None:
        return 1.0
    axis, opening = cone
    light, viewer = light_seen(draft, term.light), viewer_seen(draft, draft.equation.eye)
    if light is None or viewer is None:
        return 1.0
    theta, phi = (max(angle(axis, d) - opening - spread, 0.0) for d, spread in (light, viewer))
    if theta >= math.pi / 2:
        return 0.0
    most = widest_to_viewer(draft, light[0], light[1])
    if equation.reflection == "blinn-phong":
        middle = 2.0 * math.cos(most / 2.0)
        cosine = (math.cos(theta) + math.cos(phi)) / middle if middle > 1e-6 else 1.0
    else:
        cosine = 2.0 * math.cos(theta) * max(math.cos(phi), 0.0) - math.cos(most)
    cosine = max(min(cosine * ROUNDED_UP, 1.0), equation.cosine_floor, 0.0)
    return cosine**equation.shininess


SPECULAR = Effect(
    "specular",
    ("normals", "viewer"),
    for_each_term(_leave_out_highlight),
    lambda draft: decision(
        draft, "specular", draft.labels_where(lambda term: any(term.specular)), "black specular colour"
    ),
    each=1.4,
)
