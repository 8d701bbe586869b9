"""The effects that a scene may need, such as shadows or attenuation.

Each knows when it can be removed, why it is on or off, and the equation without it.
An effect is a class in this module, and a row in the table `EFFECTS` at the end. Plans and the accuracy report read the
table. If `lights.py` defines the lights without an effect, the effect needs only a row, of class `LightEffect`.

In order: the base class; the surface (matrix, emission, ambient light, bounces); lights (contribution, position,
attenuation and cone, size, bands); reflection; the viewer; visibility.
"""

# Methods are documented in `Effect`, and not every effect uses all arguments.
# ruff: noqa: D102, ARG002

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pvphong.base.formulas import BRIGHTEST
from pvphong.base.types import Vector
from pvphong.base.vectors import angle_between
from pvphong.geometry.extent import ROUNDED_UP
from pvphong.geometry.transform import class_of
from pvphong.optics.area.harmonics import BANDS
from pvphong.optics.light import NODES
from pvphong.optics.reflectance import Component
from pvphong.shading.equation import BLACK, Equation, LightTerm, by_closed_form, in_parts
from pvphong.shading.interreflection import diffuse_white, without_ambient
from pvphong.shading.limits import most
from pvphong.shading.plan.bounds import (
    largest_change,
    most_ambient,
    most_color,
    most_left,
    most_scattered,
    most_sent,
    sightline,
    stand_in_error,
    viewer_seen,
)
from pvphong.shading.plan.lights import ATTENUATION, CONE, POSITION, SIZE, SKY, effects, merged_nodes, simpler, without
from pvphong.shading.plan.state import BOUNCES, Decision, PlanState, Simplification

_LIGHTS = "lights"
_NO_LIGHT = "no light reaches the mesh"


Change = tuple[tuple[LightTerm, ...], tuple[Simplification, ...]]
"""Terms that replace the term of one light, and the simplifications that led to them, with error bounds. There are no
terms if the light contributes nothing."""


@dataclass(frozen=True)
class Effect:
    """An effect. It is removed light by light, and is on if any light keeps it.

    Parameters
    ----------
    name : str
        The effect's name in a plan.
    inputs : tuple of str
        Inputs that the effect reads: some of "points", "normals", "viewer".
    absent : str
        Reason in a plan if the scene does not need the effect.
    neutral : mapping
        Fields of the equation and their values without the effect. If empty, the effect is removed from each light's
        term.
    once, each : float
        Approximate cost in nanoseconds per vertex: `once` for all lights together, plus `each` for every light for
        which the effect runs. The costs are rounded differences of the times with and without the effect, by the
        compiled evaluator in float32, on one core of a server's processor of 2022 at 3.7 GHz.
    """

    name: str
    inputs: tuple[str, ...]
    absent: str
    neutral: Mapping[str, Any] = field(default_factory=dict)
    once: float = 0.0
    each: float = 0.0

    def simplify(self, state: PlanState) -> PlanState:
        """Remove the effect from each light for which the error is allowed, and return the new state.

        Lights are tried in order. The error bound of each removal reduces the error that is allowed for later lights.
        """
        if type(self).try_remove is Effect.try_remove:
            return state
        terms: list[LightTerm] = []
        exact: list[Simplification] = []
        changes = False
        for term in state.equation.terms:
            change = self.try_remove(state, term)
            if change is None:
                terms.append(term)
                continue
            changes = True
            left, simplifications = change
            terms += left
            exact += simplifications
            if any(note.bound for note in simplifications):
                # exact simplifications are added later, because a new state for each of many lights is slow
                state, exact = state.rewritten(state.equation, *exact), []
        return state.rewritten(replace(state.equation, terms=tuple(terms)), *exact) if changes else state

    def try_remove(self, state: PlanState, term: LightTerm) -> Change | None:
        """Return the terms that replace a light's term to remove the effect, and the simplifications with bounds.

        Return None if the term must stay as it is.
        """
        return None

    def has(self, equation: Equation, term: LightTerm) -> bool:
        """Return True if the effect runs for a term's light."""
        return False

    def decide(self, state: PlanState) -> Decision:
        """Return the decision on the effect in a finished state: on or off, the reason, and the error bound.

        An effect is off because simplifications have removed it, because no light remains, or because no light has it.
        """
        noted, bound = state.why_without(self.name), state.bound_of(self.name)
        having = [term for term in state.equation.terms if self.has(state.equation, term)]
        if having:
            why = ", ".join(term.label for term in having) + (f" (left out: {noted})" if noted else "")
            return Decision(True, why, bound, _evaluated(state.equation, having))
        return Decision(False, noted or (self.absent if state.equation.terms else _NO_LIGHT), bound)

    def without(self, equation: Equation, point: Vector) -> Equation:
        """Return the equation without the effect, regardless of the error.

        A value that varies over the mesh is replaced by its value at `point`. The accuracy report calls this to compare
        colours with and without the effect. Plans do not call it.
        """
        if self.neutral:
            return replace(equation, **self.neutral)
        return replace(equation, terms=tuple(self.term_without(equation, term, point) for term in equation.terms))

    def term_without(self, equation: Equation, term: LightTerm, point: Vector) -> LightTerm:
        """Return one light's term without the effect, regardless of the error. Effects of lights override this method.

        A value that varies over the mesh is replaced by its value at `point`. By default, the term is returned
        unchanged.
        """
        return term

    def nanoseconds(self, decision: Decision) -> float:
        """Return the approximate cost of the effect in nanoseconds per vertex; 0 if the decision is off."""
        return self.once + self.each * decision.lights if decision.on else 0.0


def _evaluated(equation: Equation, terms: list[LightTerm]) -> int:
    """Return the number of lights that evaluators run for some terms. Each part of an area light counts as a light."""
    return len(in_parts(replace(equation, terms=tuple(terms))).terms)


# --- the surface


class NormalTransform(Effect):
    """Transform of normals by the model matrix; off for matrices that do not change the directions of normals."""

    def simplify(self, state: PlanState) -> PlanState:
        equation = state.equation
        if equation.matrix is None:
            return state
        if np.array_equal(equation.matrix, np.eye(4)):
            return replace(state, equation=replace(equation, matrix=None, turns_normals=False))
        return replace(state, equation=replace(equation, turns_normals=not class_of(equation.matrix).keeps_normals))

    def decide(self, state: PlanState) -> Decision:
        equation = state.equation
        if equation.matrix is None:
            return Decision(False, self.absent)
        if not equation.needs_normals:
            return Decision(False, "nothing depends on the normal")
        kind = class_of(equation.matrix).value
        why = kind if equation.turns_normals else f"{kind} does not change normals"
        return Decision(equation.turns_normals, why)


class Emission(Effect):
    """Emission of the surface."""

    def decide(self, state: PlanState) -> Decision:
        if any(state.equation.emission):
            return Decision(True, "one constant for all vertices")
        return Decision(False, self.absent)


class Ambient(Effect):
    """Ambient light of the light model and of the lights.

    Ambient light of a light without a position is the same at all vertices.
    """

    def decide(self, state: PlanState) -> Decision:
        equation = state.equation
        sources = ["one constant for all vertices"] * any(equation.ambient)
        if lights := [term for term in equation.terms if any(term.ambient)]:
            sources.append(f"from {', '.join(term.label for term in lights)}")
        varying = [term for term in lights if not term.light.is_uniform]
        if not sources:
            return Decision(False, self.absent)
        return Decision(True, "; ".join(sources), lights=_evaluated(equation, varying))


class Bounces(Effect):
    """Light that bounces from surface to surface: as many bounces as the tolerance needs.

    If direct light is at most s, the light of the k-th bounce is at most rᵏ s. Here r is the largest product of an
    albedo and the fraction of the hemisphere that surfaces fill. If the reflected ambient light is at most a, what
    remains of it after n bounces is at most rⁿ a.

    With several meshes, the plan of one mesh does not know the light and albedos of the others, so it keeps all
    bounces. It does not know the errors of their plans either. But each plan limits the error of its direct light to
    half the tolerance, divided by 1 + n, the number of terms of the series. Since r is at most 1, the errors that
    arrive at this mesh are at most half the tolerance.
    """

    def simplify(self, state: PlanState) -> PlanState:
        equation = state.equation
        if not equation.bounces:
            return state
        count, transport = equation.bounces, state.transport
        is_shared = transport is not None and transport.is_shared
        sent, ambient = most_sent(state), most_ambient(state)
        why = "" if transport is None else transport.why_nothing()
        if not (sent or ambient or is_shared):
            why = "nothing sends light"
        if not any(map(any, diffuse_white(equation))):
            why = "the surface reflects no light diffusely"
        if why:
            return state.rewritten(replace(without_ambient(equation), bounces=0), Simplification(self.name, "", why))
        if is_shared:
            bound = state.tolerance / 2.0
            said = f"; errors of the other meshes add at most {bound:.2g}" if bound else ""
            note = Simplification(self.name, "", f"all {count}, among meshes that light each other{said}", bound)
            return replace(state.rewritten(equation, note), gain=1.0 + count)
        ratio = most_scattered(equation) * (1.0 if transport is None else transport.most()) * ROUNDED_UP
        held = [ratio**k * sent for k in range(1, min(count, _BOUNCES_SAID) + 1)]
        said = f"at most {', '.join(f'{each:.2g}' for each in held)}{', …' if count > len(held) else ''}"
        bounds = (
            (fewer, most_left(ratio, fewer, count, sent, ambient)) for fewer in range(count if state.tolerance else 0)
        )
        enough = ((fewer, bound) for fewer, bound in bounds if bound <= state.tolerance / 2.0)
        kept, bound = next(enough, (count, 0.0))
        why = f"the bounces add {said}"
        if kept < count:
            equation, why = without_ambient(equation), f"{kept} of {count}, the others add at most {bound:.2g}; {why}"
        gain = 1.0 + most_left(ratio, 0, kept, 1.0, 0.0)
        rewritten = state.rewritten(replace(equation, bounces=kept), Simplification(self.name, "", why, bound))
        return replace(rewritten, gain=min(gain, BRIGHTEST))

    def decide(self, state: PlanState) -> Decision:
        why = state.why_without(self.name) or self.absent
        return Decision(state.equation.bounces > 0, why, state.bound_of(self.name))


_BOUNCES_SAID = 3


# --- lights


class Lights(Effect):
    """Contribution of a light. Black lights are removed, and lights that are too weak for the tolerance.

    `LightEffect` removes lights that do not reach the mesh.
    """

    def try_remove(self, state: PlanState, term: LightTerm) -> Change | None:
        if term.is_black:
            why = "adds black: its colour, intensity or the material's is 0"
            return (), (Simplification(self.name, term.label, why),)
        if not state.allowance:
            return None
        bound = term.gain * state.reach(term).strongest * most_color(state, term)
        if bound <= state.allowance:
            why = f"too weak to be seen, at most {bound:.2g}"
            return (), (Simplification(self.name, term.label, why, bound),)
        return None

    def has(self, equation: Equation, term: LightTerm) -> bool:
        return True


class LightEffect(Effect):
    """An effect that only some kinds of light have. It is removed by replacing the light with a cheaper one.

    `lights.py` defines the cheaper lights and their errors. This class compares the errors with the tolerance. It also
    removes a light that does not reach the mesh.
    """

    def try_remove(self, state: PlanState, term: LightTerm) -> Change | None:
        if self.name not in effects(term.light):
            return None
        choice = simpler(term.light, self.name, state.extent, exactly=not state.allowance)
        if choice is None:
            return None
        if choice.make is None:  # the light does not reach the mesh
            return (), tuple(Simplification(name, term.label, choice.why) for name in (self.name, _LIGHTS))
        bound, gain = stand_in_error(state, term, choice), term.gain * choice.factor
        if not bound <= state.allowance or not 1.0 / BRIGHTEST < gain < BRIGHTEST:
            return None
        note = Simplification(self.name, term.label, choice.why.format(bound=bound), bound)
        return (replace(term, light=choice.make()[0], gain=gain),), (note,)

    def has(self, equation: Equation, term: LightTerm) -> bool:
        return self.name in effects(term.light)

    def term_without(self, equation: Equation, term: LightTerm, point: Vector) -> LightTerm:
        light, factor = without(term.light, self.name, point)
        return replace(term, light=light, gain=term.gain * factor)


class Size(LightEffect):
    """Size of an area light. It is removed by replacing the light with a light at a point, if the error is allowed.

    A lobe without a closed form is summed over nodes, small lights at points of the area light. If a single light has
    too large an error, fewer nodes may replace these nodes.
    """

    def try_remove(self, state: PlanState, term: LightTerm) -> Change | None:
        change = super().try_remove(state, term)
        if change is not None or not (state.allowance and term.light.has_size):
            return change
        _, summed = by_closed_form(term, state.equation.forms)
        part = replace(term, ambient=BLACK, colors=summed)
        for count in () if part.is_black else (1, 4, 16):
            choice = merged_nodes(term.light, count, state.extent)
            bound = math.inf if choice is None else stand_in_error(state, part, choice)
            if choice is not None and choice.make is not None and bound <= state.allowance:
                why = f"{NODES - count} of {NODES} nodes, at most {bound:.2g}"
                note = Simplification(self.name, term.label, why, bound)
                return (replace(term, nodes=choice.make()),), (note,)
        return None

    def decide(self, state: PlanState) -> Decision:
        """Return the decision. Its reason says whether lobes are integrated over the lights exactly or by nodes.

        The decision counts only lights with an exact integral. The decisions of other effects count each node as a
        light.
        """
        decision, equation, integrals = super().decide(state), state.equation, 0
        by_method: dict[str, list[str]] = {}
        for component, lobes in equation.lobes_of.items():
            for term in equation.terms:
                if self.has(equation, term) and equation.has(term, component):
                    exact, summed = by_closed_form(term, equation.forms)
                    integrals += sum(any(exact[k]) for k in lobes)
                    is_summed = any(any(summed[k]) for k in lobes)
                    count = term.light.nodes_for(equation.sharpness) if term.nodes is None else len(term.nodes)
                    method = f"by {count} nodes" if is_summed else "exact"
                    by_method.setdefault(method, []).append(component)
        said = ", ".join(f"{' and '.join(dict.fromkeys(found))} {method}" for method, found in by_method.items())
        return replace(decision, why=f"{decision.why}: {said}", lights=integrals) if said else decision


class Sky(Effect):
    """Variation of an environment light with direction: its bands of spherical harmonics beyond the first."""

    def try_remove(self, state: PlanState, term: LightTerm) -> Change | None:
        """Return the term with the smallest number of bands whose error is allowed; None if all bands are needed."""
        for bands in range(1, _bands(term)) if state.allowance else ():
            bound = _error_without_bands(state.equation, term, bands)
            if bound <= state.allowance:
                note = Simplification(self.name, term.label, f"bands from {bands} on, at most {bound:.2g}", bound)
                return (replace(term, bands=bands),), (note,)
        return None

    def has(self, equation: Equation, term: LightTerm) -> bool:
        return _bands(term) > 1

    def decide(self, state: PlanState) -> Decision:
        """Return the decision. Its reason includes a bound on the contribution of the omitted bands."""
        decision, equation = super().decide(state), state.equation
        terms = [term for term in equation.terms if self.has(equation, term)]
        if not terms:
            return decision
        count = max(map(_bands, terms))
        beyond = max(_error_without_bands(equation, term, term.light.bands) for term in terms)
        labels, noted = ", ".join(term.label for term in terms), state.why_without(self.name)
        why = f"{labels}: {count} bands, those beyond {BANDS} add at most {beyond:.2g}"
        return replace(decision, why=f"{why} (left out: {noted})" if noted else why)

    def term_without(self, equation: Equation, term: LightTerm, point: Vector) -> LightTerm:
        return replace(term, bands=1) if _bands(term) > 1 else term


def _bands(term: LightTerm) -> int:
    return term.light.bands if term.bands is None else term.bands


def _error_without_bands(equation: Equation, term: LightTerm, bands: int) -> float:
    """Return the largest colour error if only `bands` bands of spherical harmonics are kept in a term's light."""
    errors = [
        max(color) * term.light.error_without_bands(form, bands)
        for form, color in zip(equation.forms, term.colors, strict=True)
        if form is not None and any(color)
    ]
    return term.gain * sum(errors) * ROUNDED_UP


# --- reflection


class Reflection(Effect):
    """One component of the reflected light, diffuse or specular.

    If the component is black, each light's term has zeros for its colours. Evaluators skip zeros, so the equation is
    not rewritten.
    """

    name: Component

    def has(self, equation: Equation, term: LightTerm) -> bool:
        return equation.has(term, self.name)

    def term_without(self, equation: Equation, term: LightTerm, point: Vector) -> LightTerm:
        return equation.without(term, self.name)


class Specular(Reflection):
    """Highlight of a light. It is removed if it is too weak for the tolerance, or reaches almost no vertex."""

    def try_remove(self, state: PlanState, term: LightTerm) -> Change | None:
        equation = state.equation
        lobes = [k for k in equation.lobes_of["specular"] if any(term.colors[k])] if state.allowance else []
        if not lobes:
            return None
        peak = sum(max(term.colors[k]) * equation.largest[k] for k in lobes)
        bound = term.gain * state.reach(term).strongest * peak * ROUNDED_UP
        is_weak = bound <= state.allowance
        if not is_weak and not (equation.is_flipped or equation.maps):
            known, reflectance = sightline(state, term), equation.reflectance
            if known is not None:  # fraction of a lobe's maximum that occurs within the bounds on angles
                reached = max(most(reflectance, k, known) / most(reflectance, k) for k in lobes)
                bound *= reached * ROUNDED_UP
        if not bound <= state.allowance:
            return None
        why = f"its highlight {'is too weak to be seen' if is_weak else 'hardly reaches a vertex'}, at most {bound:.2g}"
        note = Simplification(self.name, term.label, why, bound, only_for_this_viewer=not is_weak)
        return (equation.without(term, "specular"),), (note,)


# --- the viewer

# Least angle in radians between a surface and the direction to the viewer for which float32 determines reliably which
# side faces the viewer.
_EDGE_ON = 1e-4


class TwoSided(Effect):
    """Turning of normals towards the viewer. It is removed if no vertex faces away.

    Vertices on the back of a closed mesh count too: the viewer does not see them, but their colours are data.
    """

    def simplify(self, state: PlanState) -> PlanState:
        equation = state.equation
        normals = state.extent.normal_cone if equation.is_flipped else None
        viewer = viewer_seen(state, equation.eye if equation.local_facing else None) if normals else None
        if normals is None or viewer is None:
            return state
        (axis, opening), (to_viewer, spread) = normals, viewer
        if angle_between(axis, to_viewer) + opening + spread > math.pi / 2 - _EDGE_ON:
            return state
        note = Simplification(self.name, "", "no vertex faces away from the viewer", only_for_this_viewer=True)
        return state.rewritten(replace(equation, two_sided=False), note)

    def decide(self, state: PlanState) -> Decision:
        if state.equation.is_flipped:
            return Decision(True, "vertices that face away are lit with the opposite normal")
        unused = "nothing depends on the normal" if state.equation.two_sided else self.absent
        return Decision(False, state.why_without(self.name) or unused)


class LocalViewer(Effect):
    """Position of the viewer. If the viewer is far away, a viewer at infinity replaces it."""

    def simplify(self, state: PlanState) -> PlanState:
        equation = state.equation
        if equation.eye is None or not equation.has_highlights or equation.is_flipped or not state.allowance:
            return state
        if equation.bounces and equation.diffuse_needs_viewer:
            return state  # bounced light depends on the viewer too, without a bound
        seen = state.extent.sight(equation.eye)
        if seen is None or seen.distance < 2 * seen.radius:
            return state
        changes = [
            term.gain * state.reach(term).strongest * change
            for term in equation.terms
            if equation.needs_viewer(term) and (change := largest_change(state, term, seen.turn, light_moves=False))
        ]
        bound = math.fsum(changes) * ROUNDED_UP
        if not bound <= state.allowance:
            return state
        why = f"far away: its direction is constant to within {bound:.2g}"
        far = replace(equation, eye=None, to_eye=seen.direction, local_facing=False)
        return state.rewritten(far, Simplification(self.name, "", why, bound, only_for_this_viewer=True))

    def decide(self, state: PlanState) -> Decision:
        equation = state.equation
        if equation.needs_eye:
            mirrors = any(equation.has(term, "specular") for term in equation.terms)
            read_by = "highlights" if mirrors else "diffuse reflection"
            return Decision(True, read_by if equation.has_highlights else "normals are turned to it")
        unused = "the viewer is at infinity" if equation.has_highlights else self.absent
        return Decision(False, state.why_without(self.name) or unused, state.bound_of(self.name))


# --- visibility


class Shadow(Effect):
    """Shadows of a light. They are removed if nothing can block the light.

    If an area light is partly hidden, each lobe is multiplied by the visible part of the light's irradiance. This is
    exact for matt surfaces. A highlight may reflect only the hidden part of the light. So the highlight's error can be
    as large as its brightness. `tradeoff` measures this error.
    """

    def try_remove(self, state: PlanState, term: LightTerm) -> Change | None:
        if not term.is_shadowed:
            return None
        why = "" if state.visibility is None else state.visibility.why_clear(term.index)
        if not term.needs_normals:
            why = "adds ambient light alone"
        return ((replace(term, is_shadowed=False),), (Simplification(self.name, term.label, why),)) if why else None

    def has(self, equation: Equation, term: LightTerm) -> bool:
        return term.is_shadowed

    def decide(self, state: PlanState) -> Decision:
        """Return the decision. Its reason lists the lights whose partly hidden highlights are approximate."""
        decision, equation = super().decide(state), state.equation
        terms = [term for term in equation.terms if self.has(equation, term) and equation.has(term, "specular")]
        labels = [term.label for term in terms if term.light.has_size]
        if not labels:
            return decision
        return replace(
            decision,
            why=f"{decision.why}; a partly hidden light loses the same part of its highlight ({', '.join(labels)})",
        )

    def term_without(self, equation: Equation, term: LightTerm, point: Vector) -> LightTerm:
        return replace(term, is_shadowed=False)


class Occlusion(Effect):
    """Ambient occlusion. It is removed if nothing can hide the sky."""

    def simplify(self, state: PlanState) -> PlanState:
        equation = state.equation
        if not equation.is_occluded:
            return state
        why = "" if state.visibility is None else state.visibility.why_open()
        if not (any(equation.ambient) or any(any(term.ambient) for term in equation.terms)):
            why = "there is no ambient light"
        if not why:
            return state
        return state.rewritten(replace(equation, is_occluded=False), Simplification(self.name, "", why))

    def decide(self, state: PlanState) -> Decision:
        if state.equation.is_occluded:
            return Decision(True, "ambient light, times the open part of the sky")
        return Decision(False, state.why_without(self.name) or self.absent)


_FAR_AWAY, _OPEN_SKY = {"eye": None, "local_facing": False}, {"is_occluded": False}

# In the order in which they are removed, because early removals make later bounds cheaper to compute: first what
# contributes nothing at any tolerance, then whole lights, then effects of the remaining lights.
# The cost of visibility is the cost of reading it: rays are cast once for all materials and colours.
EFFECTS: tuple[Effect, ...] = (
    NormalTransform("normal transform", ("normals",), "no matrix, or the identity", {"turns_normals": False}, once=0.7),
    TwoSided("two-sided", ("normals", "viewer"), "the light model is one-sided", {"two_sided": False}, once=0.5),
    Emission("emission", (), "black emission", {"emission": BLACK}),
    Ambient("ambient", (), "black ambient light or ambient reflectance", {"ambient": BLACK}, each=0.3),
    Bounces(BOUNCES, ("points", "normals"), "the light model has no bounces", {"bounces": 0}),
    Lights(_LIGHTS, (), _NO_LIGHT, {"terms": ()}),
    Size(SIZE, ("points",), "no light has a size", each=20.0),
    Sky(SKY, ("normals",), "no environment light varies", each=13.0),  # for each channel, with about nine bands
    LightEffect(CONE, ("points",), "no spot light", each=1.6),
    Specular("specular", ("normals", "viewer"), "black specular colour", each=1.4),
    LightEffect(ATTENUATION, ("points",), "no light has attenuation", each=0.7),
    LightEffect(POSITION, ("points",), "every light is directional", once=0.5, each=0.2),
    # without it, the viewer is at infinity along the view axis, as with `LightModel(local_viewer=False)`
    LocalViewer("local viewer", ("points", "viewer"), "no remaining highlight depends on it", _FAR_AWAY, once=0.6),
    Reflection("diffuse", ("normals",), "black diffuse colour", once=0.5, each=0.2),
    Shadow("shadow", ("points", "normals"), "the light model has no shadows", each=0.2),
    Occlusion("occlusion", ("points", "normals"), "the light model has no ambient occlusion", _OPEN_SKY, once=0.2),
)
