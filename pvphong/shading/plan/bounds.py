"""Bounds on what a light can contribute, and on how much a small turn can change it. All hold for every normal."""

from __future__ import annotations

import math

from pvphong.base.types import Vector
from pvphong.base.vectors import angle_between
from pvphong.geometry.extent import ROUNDED_UP
from pvphong.optics.light import StandIn
from pvphong.optics.reflectance import Sightline
from pvphong.shading.equation import LightTerm
from pvphong.shading.plan.draft import Draft

# Radians by which a direction may be off in float64.
_SLACK = 1e-7

Cone = tuple[Vector, float]
"""Directions: a unit vector, and the angle in radians by which one at a vertex may be off it."""


def most_color(draft: Draft, term: LightTerm) -> float:
    """The largest sum of a term's colours, for strength 1."""
    red, green, blue = term.ambient
    for color, largest in zip(term.colors, draft.equation.largest, strict=True):
        red += color[0] * largest
        green += color[1] * largest
        blue += color[2] * largest
    return max(red, green, blue)


def stand_in_error(draft: Draft, term: LightTerm, choice: StandIn) -> float:
    """The largest error in a colour where something cheaper replaces a term's light."""
    bound = most_color(draft, term) * choice.spread
    if choice.turn is not None:
        bound += largest_change(draft, term, choice.turn, light_moves=True) * choice.strongest
    return bound * term.gain * ROUNDED_UP if bound else 0.0


def largest_change(draft: Draft, term: LightTerm, turn: float, *, light_moves: bool) -> float:
    """The largest change of a term's colour, for strength 1, when light or viewer turns by an angle.

    Parameters
    ----------
    draft : Draft
        What else is known.
    term : LightTerm
        Whose colours count.
    turn : float
        In radians.
    light_moves : bool
        Whether the light turns, rather than the viewer.
    """
    reach = draft.reach(term)
    if reach.direction is None:
        return math.inf
    psi = widest_to_viewer(draft, (reach.direction, max(reach.turn, turn) if light_moves else reach.turn))
    return sum(
        max(color) * sum([each.change(k, turn, psi, light_moves=light_moves) for each in draft.equation.extremes])
        for k, color in enumerate(term.colors)
        if any(color)
    )


def viewer_seen(draft: Draft, eye: Vector | None) -> Cone | None:
    """Where the viewer is seen, at infinity where there is no eye; None where nothing is known."""
    if eye is None:
        return draft.equation.to_eye, _SLACK
    seen = draft.extent.sight(eye)
    return None if seen is None else (seen.direction, seen.turn + _SLACK)


def widest_to_viewer(draft: Draft, light: Cone) -> float:
    """The greatest angle from light to viewer over all vertices, in radians."""
    viewer = viewer_seen(draft, draft.equation.eye)
    if viewer is None:
        return math.pi
    (to_viewer, viewer_spread), (to_light, light_spread) = viewer, light
    return min(angle_between(to_viewer, to_light) + (light_spread + viewer_spread) * ROUNDED_UP, math.pi)


def sightline(draft: Draft, term: LightTerm) -> Sightline | None:
    """What is known of the angles between normals, a light and the viewer; None where too little is known."""
    reach, normals = draft.reach(term), draft.extent.normal_cone
    viewer = viewer_seen(draft, draft.equation.eye) if normals and reach.direction else None
    if normals is None or reach.direction is None or viewer is None:
        return None
    (axis, opening), light = normals, (reach.direction, reach.turn)
    theta, phi = (max(angle_between(axis, d) - opening - spread, 0.0) for d, spread in (light, viewer))
    return Sightline(theta, phi, widest_to_viewer(draft, light))
