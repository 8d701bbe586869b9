"""Bounds on what a light can contribute, and on how much a small turn can change it. All hold for every normal."""

from __future__ import annotations

import math
from typing import NamedTuple

from pvphong.base.types import Vector
from pvphong.base.vectors import angle_between
from pvphong.geometry.extent import ROUNDED_UP
from pvphong.optics.light import Reach
from pvphong.optics.reflectance import Sightline
from pvphong.shading.equation import LightTerm
from pvphong.shading.plan.draft import Draft

# Radians by which a direction may be off in float64.
_SLACK = 1e-7


class ApparentDirection(NamedTuple):
    """Where something is seen from the vertices."""

    direction: Vector
    """Unit vector from their middle."""

    spread: float
    """The angle by which it may be off at a vertex, in radians."""


def most_color(draft: Draft, term: LightTerm) -> float:
    """The largest sum of a term's colours, for strength 1."""
    red, green, blue = term.ambient
    for color, largest in zip(term.colors, draft.equation.largest, strict=True):
        red += color[0] * largest
        green += color[1] * largest
        blue += color[2] * largest
    return max(red, green, blue)


def viewer_seen(draft: Draft, eye: Vector | None) -> ApparentDirection | None:
    """Where the viewer is seen, at infinity where there is no eye; None where nothing is known."""
    if eye is None:
        return ApparentDirection(draft.equation.to_eye, _SLACK)
    seen = draft.extent.sight(eye)
    return None if seen is None else ApparentDirection(seen.direction, seen.turn + _SLACK)


def widest_to_viewer(draft: Draft, light: ApparentDirection) -> float:
    """The greatest angle from light to viewer over all vertices."""
    seen = viewer_seen(draft, draft.equation.eye)
    if seen is None:
        return math.pi
    apart = angle_between(seen.direction, light.direction)
    return min(apart + (light.spread + seen.spread) * ROUNDED_UP, math.pi)


def sightline(draft: Draft, reach: Reach) -> Sightline | None:
    """What is known of the angles between normals, a light and the viewer; None where too little is known."""
    cone = draft.extent.normal_cone
    viewer = viewer_seen(draft, draft.equation.eye) if cone and reach.direction else None
    if cone is None or reach.direction is None or viewer is None:
        return None
    (axis, opening), seen = cone, ApparentDirection(reach.direction, reach.turn)
    theta, phi = (max(angle_between(axis, d) - opening - spread, 0.0) for d, spread in (seen, viewer))
    return Sightline(theta, phi, widest_to_viewer(draft, seen))


def largest_change(draft: Draft, term: LightTerm, light: ApparentDirection, turn: float, *, light_moves: bool) -> float:
    """The largest change of a term's colour, for strength 1, when light or viewer turns by an angle.

    Parameters
    ----------
    draft : Draft
        What else is known.
    term : LightTerm
        Whose colours count.
    light : ApparentDirection
        Where the light is.
    turn : float
        In radians.
    light_moves : bool
        Whether the light turns, rather than the viewer.
    """
    psi = widest_to_viewer(draft, light)
    return sum(
        max(color) * sum([each.change(k, turn, psi, light_moves=light_moves) for each in draft.equation.extremes])
        for k, color in enumerate(term.colors)
        if any(color)
    )
