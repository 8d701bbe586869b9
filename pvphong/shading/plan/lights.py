"""Effects of lights: whether each shines at all, its position, its attenuation, its cone, and what else a light has.

Which cheaper lights may stand in for one, and how wrong they are, is the light's to say (`Light.simpler`); whether that
is within the tolerance is decided here.
"""

from __future__ import annotations

import math
from dataclasses import replace

from pvphong.base.float_range import BRIGHTEST
from pvphong.base.types import Vector
from pvphong.geometry.extent import ROUNDED_UP
from pvphong.optics import attenuation
from pvphong.optics.light import NODES, POSITION_EFFECT, SIZE_EFFECT, Fewer, Simpler
from pvphong.optics.reflectance import Component
from pvphong.shading.equation import BLACK, Equation, LightTerm
from pvphong.shading.parts import by_closed_form
from pvphong.shading.plan.bounds import ApparentDirection, largest_change, most_color
from pvphong.shading.plan.draft import (
    NO_LIGHT,
    Change,
    Decision,
    Draft,
    Effect,
    Note,
    decision,
    every_term,
    for_each_term,
)

_LIGHTS = "lights"
# Of nodes, that may do in place of all.
_COUNTS = 1, 4, 16
_COMPONENTS: tuple[Component, ...] = "diffuse", "specular"


def light_effect(name: str, nobody: str, *, once: float = 0.0, each: float = 0.0) -> Effect:
    """An effect that some lights call for (`Light.effects`) and can say how to do without.

    Parameters
    ----------
    name : str
        As lights call it.
    nobody : str
        Why it is off where no light has it.
    once, each : float
        Nanoseconds, as for every effect.
    """

    def leave_out(draft: Draft, term: LightTerm) -> Change:
        if name not in term.light.effects:
            return None
        choice = term.light.simpler(name, draft.extent, exactly=not draft.allowance)
        return None if choice is None else _replaced(draft, term, name, choice)

    def without(term: LightTerm, point: Vector) -> LightTerm:
        light, factor = term.light.without(name, point)
        return replace(term, light=light, gain=term.gain * factor)

    return Effect(
        name,
        ("points",),
        for_each_term(leave_out),
        lambda draft: decision(draft, name, lambda term: name in term.light.effects, nobody),
        every_term(without),
        once,
        each,
    )


def _replaced(draft: Draft, term: LightTerm, effect: str, choice: Simpler) -> Change:
    """The term with a cheaper light, if that is within the allowance."""
    if choice.make is None:
        note = Note(effect, term.label, choice.why)
        return None, note, note._replace(effect=_LIGHTS)
    bound, gain = _bound(draft, term, choice), term.gain * choice.factor
    if not bound <= draft.allowance or not 1.0 / BRIGHTEST < gain < BRIGHTEST:
        return None
    return replace(term, light=choice.make(), gain=gain), Note(
        effect, term.label, choice.why.format(bound=bound), bound
    )


def _bound(draft: Draft, term: LightTerm, choice: Simpler | Fewer) -> float:
    """The largest error in a colour."""
    bound = most_color(draft, term) * choice.spread
    if choice.turn is not None:
        direction, turn = draft.reach(term).direction, draft.reach(term).turn
        if direction is None:
            return float("inf")
        change = largest_change(
            draft, term, ApparentDirection(direction, max(turn, choice.turn)), choice.turn, light_moves=True
        )
        bound += change * choice.strongest
    return bound * term.gain * ROUNDED_UP if bound else 0.0


def _leave_out(draft: Draft, term: LightTerm) -> Change:
    label = term.label
    if term.is_black:
        return None, Note(_LIGHTS, label, "adds black: its colour, intensity or the material's is 0")
    if not draft.allowance:
        return None
    bound = term.gain * draft.reach(term).strongest * most_color(draft, term)
    if bound <= draft.allowance:
        return None, Note(_LIGHTS, label, f"too weak to be seen, at most {bound:.2g}", bound)
    return None


def _dark(equation: Equation, _point: Vector) -> Equation:
    return replace(equation, terms=())


LIGHTS = Effect(
    _LIGHTS,
    (),
    for_each_term(_leave_out),
    lambda draft: decision(draft, _LIGHTS, lambda _: True, NO_LIGHT),
    _dark,
)


def _take_fewer_nodes(draft: Draft, term: LightTerm) -> Change:
    """For lobes without a closed form: the fewest nodes that do."""
    if not (draft.allowance and term.light.has_size):
        return None
    _, summed = by_closed_form(term, draft.equation.forms)
    part = replace(term, ambient=BLACK, colors=summed)
    for count in _COUNTS if not part.is_black else ():
        choice = term.light.fewer(count, draft.extent)
        bound = math.inf if choice is None else _bound(draft, part, choice)
        if choice is not None and bound <= draft.allowance:
            why = f"{NODES - count} of {NODES} nodes, at most {bound:.2g}"
            return replace(term, nodes=choice.nodes), Note(SIZE_EFFECT, term.label, why, bound)
    return None


def _decide_size(draft: Draft) -> Decision:
    """With how lobes are integrated over the lights: exactly, or by nodes."""
    decided = _ANY_SIZE.decide(draft)
    found: dict[str, list[str]] = {}
    for component in _COMPONENTS if decided.on else ():
        lobes = draft.equation.lobes_of(component)
        for term in draft.equation.terms:
            if SIZE_EFFECT in term.light.effects and draft.equation.has(term, component):
                _, summed = by_closed_form(term, draft.equation.forms)
                count = NODES if term.nodes is None else len(term.nodes)
                how = f"by {count} nodes" if any(any(summed[k]) for k in lobes) else "exact"
                found.setdefault(how, []).append(component)
    said = ", ".join(f"{' and '.join(dict.fromkeys(components))} {how}" for how, components in found.items())
    return replace(decided, why=f"{decided.why}: {said}") if said else decided


_ANY_SIZE = light_effect(SIZE_EFFECT, "no light has a size")
SIZE = replace(
    _ANY_SIZE,
    simplify=lambda draft: for_each_term(_take_fewer_nodes)(_ANY_SIZE.simplify(draft)),
    decide=_decide_size,
)
CONE = light_effect("cone", "no spot light", each=1.6)
ATTENUATION = light_effect(attenuation.EFFECT, "no light weakens with distance", each=0.7)
POSITION = light_effect(POSITION_EFFECT, "every light is directional", once=0.5, each=0.2)
