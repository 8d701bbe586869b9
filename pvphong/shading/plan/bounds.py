"""Bounds on a light's contribution, and on its change when the light or viewer turns. They hold for every normal.

A term is one light in the equation. A state has the equation and bounds on the vertices.
"""

from __future__ import annotations

import contextlib
import math

from pvphong.base.types import Vector
from pvphong.base.vectors import angle_between
from pvphong.geometry.extent import ROUNDED_UP, TURN_SLACK
from pvphong.optics.reflectance import LAMBERT, AngleBounds
from pvphong.shading.equation import Equation, LightTerm
from pvphong.shading.limits import change
from pvphong.shading.plan.lights import Approximation
from pvphong.shading.plan.state import PlanState

Cone = tuple[Vector, float]
"""Cone of directions: its axis, a unit vector, and the largest angle from the axis to the direction at any vertex, in
radians."""


def most_color(state: PlanState, term: LightTerm) -> float:
    """Return a bound on a colour channel that a term adds to any vertex, if the term's light has strength 1."""
    red, green, blue = term.ambient
    for color, largest in zip(term.colors, state.equation.largest, strict=True):
        red += color[0] * largest
        green += color[1] * largest
        blue += color[2] * largest
    return max(red, green, blue)


def most_sent(state: PlanState) -> float:
    """Return a bound on any channel of the light that a vertex sends: emission and diffusely reflected direct light."""
    equation = state.equation
    sent = [
        term.gain * state.reach(term).strongest * max(term.colors[k]) * equation.largest[k]
        for term in equation.terms
        for k in equation.lobes_of["diffuse"]
        if any(term.colors[k])
    ]
    return (math.fsum(sent) + max(equation.emission)) * ROUNDED_UP


def most_ambient(state: PlanState) -> float:
    """Return a bound on any channel of the ambient light that a vertex reflects."""
    terms = [term for term in state.equation.terms if any(term.ambient)]
    lights = math.fsum(term.gain * state.reach(term).strongest * max(term.ambient) for term in terms)
    return (lights + max(state.equation.ambient)) * ROUNDED_UP


def most_scattered(equation: Equation) -> float:
    """Return a bound on the diffuse albedo, the reflection of a uniform white sky.

    Lambert's reflectance has the albedo 1. The albedo of any other reflectance is at most twice its largest factor.
    """
    shares = [
        max(equation.colors[k]) * (1.0 if equation.reflectance.lobes[k] is LAMBERT else 2.0 * equation.largest[k])
        for k in equation.lobes_of["diffuse"]
    ]
    return math.fsum(shares) * ROUNDED_UP


def most_left(ratio: float, kept: int, count: int, sent: float, ambient: float) -> float:
    """Return a bound on the light that is lost if only the first `kept` of `count` bounces are computed.

    The lost light is the light of the other bounces, and the ambient light that remains after all bounces.

    Parameters
    ----------
    ratio : float
        Largest factor by which one bounce multiplies light.
    kept, count : int
        Number of bounces that are kept, and of all bounces.
    sent, ambient : float
        Results of `most_sent` and `most_ambient`.
    """
    if ratio == 1.0:
        return (count - kept) * sent + ambient
    with contextlib.suppress(OverflowError):
        series = (ratio ** (kept + 1) - ratio ** (count + 1)) / (1.0 - ratio)  # sum of rᵏ from kept + 1 to count
        return (series * sent + ratio**count * ambient) * ROUNDED_UP**2
    return math.inf


def stand_in_error(state: PlanState, term: LightTerm, choice: Approximation) -> float:
    """Return the largest colour error if `choice`, a cheaper light, replaces the light of a term."""
    bound = most_color(state, term) * choice.spread
    if choice.turn is not None:
        bound += largest_change(state, term, choice.turn, light_moves=True) * choice.strongest
    return bound * term.gain * ROUNDED_UP if bound else 0.0


def largest_change(state: PlanState, term: LightTerm, turn: float, *, light_moves: bool) -> float:
    """Return the largest change of a term's colour, for a light of strength 1, when the light or the viewer turns.

    Parameters
    ----------
    state : PlanState
        The equation, and bounds on the vertices.
    term : LightTerm
        The term.
    turn : float
        Angle in radians by which the direction to the light or to the viewer turns.
    light_moves : bool
        True if the light turns, False if the viewer turns.
    """
    reach = state.reach(term)
    if reach.direction is None:
        return math.inf
    psi = widest_to_viewer(state, (reach.direction, max(reach.turn, turn) if light_moves else reach.turn))
    return sum(
        max(color) * sum([change(each, k, turn, psi, light_moves=light_moves) for each in state.equation.extremes])
        for k, color in enumerate(term.colors)
        if any(color)
    )


def viewer_seen(state: PlanState, eye: Vector | None) -> Cone | None:
    """Return a cone that contains the directions from all vertices to the viewer; None if no bound is known.

    The viewer is at the position `eye`. If `eye` is None, the viewer is at infinity along the view axis.
    """
    if eye is None:
        return state.equation.to_eye, TURN_SLACK
    seen = state.extent.sight(eye)
    return None if seen is None else (seen.direction, seen.turn + TURN_SLACK)


def widest_to_viewer(state: PlanState, light: Cone) -> float:
    """Return a bound on the angle between the directions to a light and to the viewer, over all vertices, in radians.

    `light` is the cone of directions to the light.
    """
    viewer = viewer_seen(state, state.equation.eye)
    if viewer is None:
        return math.pi
    (to_viewer, viewer_spread), (to_light, light_spread) = viewer, light
    return min(angle_between(to_viewer, to_light) + (light_spread + viewer_spread) * ROUNDED_UP, math.pi)


def sightline(state: PlanState, term: LightTerm) -> AngleBounds | None:
    """Return bounds, over all vertices, on the angles between the normal, the term's light and the viewer.

    Return None if the direction of the normal, to the light or to the viewer has no known bound.
    """
    reach, normals = state.reach(term), state.extent.normal_cone
    viewer = viewer_seen(state, state.equation.eye) if normals and reach.direction else None
    if normals is None or reach.direction is None or viewer is None:
        return None
    (axis, opening), light = normals, (reach.direction, reach.turn)
    theta, phi = (max(angle_between(axis, d) - opening - spread, 0.0) for d, spread in (light, viewer))
    return AngleBounds(theta, phi, widest_to_viewer(state, light))
