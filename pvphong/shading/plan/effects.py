"""The effects that a scene may call for: how each is left out, when it is on and why, and the equation without it.

An effect is a class here and its row in `EFFECTS`, at the end, which plans and the accuracy report read. One that
lights call for, and `lights.py` says how to do without, is a row alone, of `LightEffect`.

In order: what an effect is; the surface (matrix, emission, ambient light, light that bounces); lights (whether one
shines at all, its position, attenuation and cone, its size, its bands); reflection; the viewer; visibility.
"""

# Methods do what `Effect` says of them; not every effect reads all that it is given.
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
from pvphong.shading.plan.draft import BOUNCES, Decision, Draft, Note
from pvphong.shading.plan.lights import ATTENUATION, CONE, POSITION, SIZE, SKY, effects, merged_nodes, simpler, without

_LIGHTS = "lights"
_NO_LIGHT = "no light reaches the mesh"


Change = tuple[tuple[LightTerm, ...], tuple[Note, ...]]
"""A light's term without an effect, or none where the light adds nothing, and why, at what error."""


@dataclass(frozen=True)
class Effect:
    """An effect that is left out light by light, and is on where a light that is left has it.

    Parameters
    ----------
    name : str
        Its name in a plan.
    inputs : tuple of str
        What it reads of each vertex, or of the scene: "points", "normals", "viewer".
    absent : str
        Why it is off where a scene does not call for it.
    neutral : mapping
        Fields of the equation, with the values that they have without the effect. Without any, it is left out of each
        light's term.
    once, each : float
        About how many nanoseconds per vertex it takes, whatever the lights, and for each light it runs for: rounded
        differences of runs with and without it of the compiled evaluator in float32, on one core of a server's
        processor of 2022 at 3.7 GHz.
    """

    name: str
    inputs: tuple[str, ...]
    absent: str
    neutral: Mapping[str, Any] = field(default_factory=dict)
    once: float = 0.0
    each: float = 0.0

    def simplify(self, draft: Draft) -> Draft:
        """The draft without the effect where it can be left out; each light sees the bounds taken before it."""
        if type(self).leave_out is Effect.leave_out:
            return draft
        terms: list[LightTerm] = []
        exact: list[Note] = []
        changes = False
        for term in draft.equation.terms:
            change = self.leave_out(draft, term)
            if change is None:
                terms.append(term)
                continue
            changes = True
            left, notes = change
            terms += left
            exact += notes
            if any(note.bound for note in notes):
                # exact ones can wait: a draft for each of many would take long
                draft, exact = draft.rewritten(draft.equation, *exact), []
        return draft.rewritten(replace(draft.equation, terms=tuple(terms)), *exact) if changes else draft

    def leave_out(self, draft: Draft, term: LightTerm) -> Change | None:
        """One light's term without the effect; None where it cannot be left out."""
        return None

    def has(self, equation: Equation, term: LightTerm) -> bool:
        """Whether the effect runs for a light."""
        return False

    def decide(self, draft: Draft) -> Decision:
        """Whether the effect is left in a finished draft.

        It is off for the reasons noted, or because there is no light, or none that has it.
        """
        noted, bound = draft.why_without(self.name), draft.bound_of(self.name)
        having = [term for term in draft.equation.terms if self.has(draft.equation, term)]
        if having:
            why = ", ".join(term.label for term in having) + (f" (left out: {noted})" if noted else "")
            return Decision(True, why, bound, _evaluated(draft.equation, having))
        return Decision(False, noted or (self.absent if draft.equation.terms else _NO_LIGHT), bound)

    def without(self, equation: Equation, point: Vector) -> Equation:
        """The equation without the effect, whatever the error; what varies is taken as it is at the point.

        What the accuracy report measures the effect by; no plan does this.
        """
        if self.neutral:
            return replace(equation, **self.neutral)
        return replace(equation, terms=tuple(self.term_without(equation, term, point) for term in equation.terms))

    def term_without(self, equation: Equation, term: LightTerm, point: Vector) -> LightTerm:
        """One light's term without it, for effects that are of lights."""
        return term

    def nanoseconds(self, decision: Decision) -> float:
        """About what it takes per vertex; 0 where it does not run."""
        return self.once + self.each * decision.lights if decision.on else 0.0


def _evaluated(equation: Equation, terms: list[LightTerm]) -> int:
    """How many lights are evaluated for some terms: the parts of a light that has a size count each for itself."""
    return len(in_parts(replace(equation, terms=tuple(terms))).terms)


# --- the surface


class NormalTransform(Effect):
    """The model matrix: the identity goes altogether, and some matrices leave normals as they are."""

    def simplify(self, draft: Draft) -> Draft:
        equation = draft.equation
        if equation.matrix is None:
            return draft
        if np.array_equal(equation.matrix, np.eye(4)):
            return replace(draft, equation=replace(equation, matrix=None, turns_normals=False))
        return replace(draft, equation=replace(equation, turns_normals=not class_of(equation.matrix).keeps_normals))

    def decide(self, draft: Draft) -> Decision:
        equation = draft.equation
        if equation.matrix is None:
            return Decision(False, self.absent)
        if not equation.needs_normals:
            return Decision(False, "nothing depends on the normal")
        kind = class_of(equation.matrix).value
        why = kind if equation.turns_normals else f"{kind} leaves normals as they are"
        return Decision(equation.turns_normals, why)


class Emission(Effect):
    """Light that the surface itself sends."""

    def decide(self, draft: Draft) -> Decision:
        if any(draft.equation.emission):
            return Decision(True, "one constant for all vertices")
        return Decision(False, self.absent)


class Ambient(Effect):
    """Ambient light: the light model's, and that of lights, which is a constant too where they have no position."""

    def decide(self, draft: Draft) -> Decision:
        equation = draft.equation
        sources = ["one constant for all vertices"] * any(equation.ambient)
        if lights := [term for term in equation.terms if any(term.ambient)]:
            sources.append(f"of {', '.join(term.label for term in lights)}")
        varying = [term for term in lights if not term.light.is_even]
        if not sources:
            return Decision(False, self.absent)
        return Decision(True, "; ".join(sources), lights=_evaluated(equation, varying))


class Bounces(Effect):
    """Light that goes on from surface to surface: as many bounces as can be seen.

    What bounces k times is at most rᵏ s, for direct light of at most s, where r is the largest product of an albedo
    and a part of the hemisphere that is filled; what is left of ambient light a after n bounces is at most rⁿ a.

    Among several meshes a plan of one knows neither what others send nor their albedos: all bounces are kept. Nor does
    it know what their plans leave out; but that is at most half of the tolerance, for r is at most 1, over the number
    of terms, and so is all of it that arrives here.
    """

    def simplify(self, draft: Draft) -> Draft:
        equation = draft.equation
        if not equation.bounces:
            return draft
        count, transport = equation.bounces, draft.transport
        is_shared = transport is not None and transport.is_shared
        sent, ambient = most_sent(draft), most_ambient(draft)
        why = "" if transport is None else transport.why_nothing()
        if not (sent or ambient or is_shared):
            why = "nothing sends light"
        if not any(map(any, diffuse_white(equation))):
            why = "the surface reflects no light diffusely"
        if why:
            return draft.rewritten(replace(without_ambient(equation), bounces=0), Note(self.name, "", why))
        if is_shared:
            bound = draft.tolerance / 2.0
            said = f"; what is left out of others at most {bound:.2g}" if bound else ""
            note = Note(self.name, "", f"all {count}, among meshes that light each other{said}", bound)
            return replace(draft.rewritten(equation, note), gain=1.0 + count)
        ratio = most_scattered(equation) * (1.0 if transport is None else transport.most()) * ROUNDED_UP
        held = [ratio**k * sent for k in range(1, min(count, _BOUNCES_SAID) + 1)]
        said = f"at most {', '.join(f'{each:.2g}' for each in held)}{', …' if count > len(held) else ''}"
        bounds = (
            (fewer, most_left(ratio, fewer, count, sent, ambient)) for fewer in range(count if draft.tolerance else 0)
        )
        enough = ((fewer, bound) for fewer, bound in bounds if bound <= draft.tolerance / 2.0)
        kept, bound = next(enough, (count, 0.0))
        why = f"each holds {said}"
        if kept < count:
            equation, why = without_ambient(equation), f"{kept} of {count}, the others at most {bound:.2g}; {why}"
        gain = 1.0 + most_left(ratio, 0, kept, 1.0, 0.0)
        rewritten = draft.rewritten(replace(equation, bounces=kept), Note(self.name, "", why, bound))
        return replace(rewritten, gain=min(gain, BRIGHTEST))

    def decide(self, draft: Draft) -> Decision:
        why = draft.why_without(self.name) or self.absent
        return Decision(draft.equation.bounces > 0, why, draft.bound_of(self.name))


_BOUNCES_SAID = 3


# --- lights


class Lights(Effect):
    """Whether a light shines at all: one that is black goes, and one that is too weak for the tolerance."""

    def leave_out(self, draft: Draft, term: LightTerm) -> Change | None:
        if term.is_black:
            why = "adds black: its colour, intensity or the material's is 0"
            return (), (Note(self.name, term.label, why),)
        if not draft.allowance:
            return None
        bound = term.gain * draft.reach(term).strongest * most_color(draft, term)
        if bound <= draft.allowance:
            why = f"too weak to be seen, at most {bound:.2g}"
            return (), (Note(self.name, term.label, why, bound),)
        return None

    def has(self, equation: Equation, term: LightTerm) -> bool:
        return True


class LightEffect(Effect):
    """An effect that some lights call for: `lights.py` says which cheaper lights may replace one, and how wrong they
    are; this class decides whether that is within the tolerance.
    """

    def leave_out(self, draft: Draft, term: LightTerm) -> Change | None:
        if self.name not in effects(term.light):
            return None
        choice = simpler(term.light, self.name, draft.extent, exactly=not draft.allowance)
        if choice is None:
            return None
        if choice.make is None:  # it is dark here
            return (), (Note(self.name, term.label, choice.why), Note(_LIGHTS, term.label, choice.why))
        bound, gain = stand_in_error(draft, term, choice), term.gain * choice.factor
        if not bound <= draft.allowance or not 1.0 / BRIGHTEST < gain < BRIGHTEST:
            return None
        note = Note(self.name, term.label, choice.why.format(bound=bound), bound)
        return (replace(term, light=choice.make()[0], gain=gain),), (note,)

    def has(self, equation: Equation, term: LightTerm) -> bool:
        return self.name in effects(term.light)

    def term_without(self, equation: Equation, term: LightTerm, point: Vector) -> LightTerm:
        light, factor = without(term.light, self.name, point)
        return replace(term, light=light, gain=term.gain * factor)


class Size(LightEffect):
    """A point in place of a light with a size; or as few nodes as do, for lobes without a closed form."""

    def leave_out(self, draft: Draft, term: LightTerm) -> Change | None:
        change = super().leave_out(draft, term)
        if change is not None or not (draft.allowance and term.light.has_size):
            return change
        _, summed = by_closed_form(term, draft.equation.forms)
        part = replace(term, ambient=BLACK, colors=summed)
        for count in () if part.is_black else (1, 4, 16):
            choice = merged_nodes(term.light, count, draft.extent)
            bound = math.inf if choice is None else stand_in_error(draft, part, choice)
            if choice is not None and choice.make is not None and bound <= draft.allowance:
                why = f"{NODES - count} of {NODES} nodes, at most {bound:.2g}"
                note = Note(self.name, term.label, why, bound)
                return (replace(term, nodes=choice.make()),), (note,)
        return None

    def decide(self, draft: Draft) -> Decision:
        """Its reason also says how lobes are integrated over the lights: exactly, or by nodes.

        What it takes is for each integral; nodes are lights like others.
        """
        decision, equation, integrals = super().decide(draft), draft.equation, 0
        by_method: dict[str, list[str]] = {}
        for component, lobes in equation.lobes_of.items():
            for term in equation.terms:
                if self.has(equation, term) and equation.has(term, component):
                    exact, summed = by_closed_form(term, equation.forms)
                    integrals += sum(any(exact[k]) for k in lobes)
                    is_summed = any(any(summed[k]) for k in lobes)
                    method = f"by {NODES if term.nodes is None else len(term.nodes)} nodes" if is_summed else "exact"
                    by_method.setdefault(method, []).append(component)
        said = ", ".join(f"{' and '.join(dict.fromkeys(found))} {method}" for method, found in by_method.items())
        return replace(decision, why=f"{decision.why}: {said}", lights=integrals) if said else decision


class Sky(Effect):
    """How finely light from all around is resolved: in how many bands of spherical harmonics."""

    def leave_out(self, draft: Draft, term: LightTerm) -> Change | None:
        """The fewest bands that do."""
        for bands in range(1, _bands(term)) if draft.allowance else ():
            bound = _error_without_bands(draft.equation, term, bands)
            if bound <= draft.allowance:
                note = Note(self.name, term.label, f"bands from {bands} on, at most {bound:.2g}", bound)
                return (replace(term, bands=bands),), (note,)
        return None

    def has(self, equation: Equation, term: LightTerm) -> bool:
        return _bands(term) > 1

    def decide(self, draft: Draft) -> Decision:
        """Its reason also says how much the bands beyond the last one hold at most."""
        decision, equation = super().decide(draft), draft.equation
        terms = [term for term in equation.terms if self.has(equation, term)]
        if not terms:
            return decision
        count = max(map(_bands, terms))
        beyond = max(_error_without_bands(equation, term, term.light.bands) for term in terms)
        labels, noted = ", ".join(term.label for term in terms), draft.why_without(self.name)
        why = f"{labels}: {count} bands, those beyond {BANDS} hold at most {beyond:.2g}"
        return replace(decision, why=f"{why} (left out: {noted})" if noted else why)

    def term_without(self, equation: Equation, term: LightTerm, point: Vector) -> LightTerm:
        return replace(term, bands=1) if _bands(term) > 1 else term


def _bands(term: LightTerm) -> int:
    return term.light.bands if term.bands is None else term.bands


def _error_without_bands(equation: Equation, term: LightTerm, bands: int) -> float:
    """The largest error in a colour without a light's bands from one on."""
    errors = [
        max(color) * term.light.error_without_bands(form, bands)
        for form, color in zip(equation.forms, term.colors, strict=True)
        if form is not None and any(color)
    ]
    return term.gain * sum(errors) * ROUNDED_UP


# --- reflection


class Reflection(Effect):
    """A component of what the surface reflects.

    Where it is black it is a zero coefficient of a light's term, which every evaluator skips: nothing is rewritten.
    """

    name: Component

    def has(self, equation: Equation, term: LightTerm) -> bool:
        return equation.has(term, self.name)

    def term_without(self, equation: Equation, term: LightTerm, point: Vector) -> LightTerm:
        return equation.without(term, self.name)


class Specular(Reflection):
    """A light's highlight, where it is too weak for the tolerance, or hardly reaches a vertex."""

    def leave_out(self, draft: Draft, term: LightTerm) -> Change | None:
        equation = draft.equation
        lobes = [k for k in equation.lobes_of["specular"] if any(term.colors[k])] if draft.allowance else []
        if not lobes:
            return None
        peak = sum(max(term.colors[k]) * equation.largest[k] for k in lobes)
        bound = term.gain * draft.reach(term).strongest * peak * ROUNDED_UP
        is_weak = bound <= draft.allowance
        if not is_weak and not (equation.is_flipped or equation.maps):
            known, reflectance = sightline(draft, term), equation.reflectance
            if known is not None:  # how much of a lobe normals and directions allow
                reached = max(most(reflectance, k, known) / most(reflectance, k) for k in lobes)
                bound *= reached * ROUNDED_UP
        if not bound <= draft.allowance:
            return None
        why = f"its highlight {'is too weak to be seen' if is_weak else 'hardly reaches a vertex'}, at most {bound:.2g}"
        note = Note(self.name, term.label, why, bound, only_for_this_viewer=not is_weak)
        return (equation.without(term, "specular"),), (note,)


# --- the viewer

# Float32 knows which side of a surface the viewer is on unless he is within this many radians of its plane.
_EDGE_ON = 1e-4


class TwoSided(Effect):
    """The turning of normals to the viewer, which is left out where no vertex faces away.

    A closed mesh seen from outside hides the others, but their colours are data too.
    """

    def simplify(self, draft: Draft) -> Draft:
        equation = draft.equation
        normals = draft.extent.normal_cone if equation.is_flipped else None
        viewer = viewer_seen(draft, equation.eye if equation.local_facing else None) if normals else None
        if normals is None or viewer is None:
            return draft
        (axis, opening), (to_viewer, spread) = normals, viewer
        if angle_between(axis, to_viewer) + opening + spread > math.pi / 2 - _EDGE_ON:
            return draft
        note = Note(self.name, "", "no vertex faces away from the viewer", only_for_this_viewer=True)
        return draft.rewritten(replace(equation, two_sided=False), note)

    def decide(self, draft: Draft) -> Decision:
        if draft.equation.is_flipped:
            return Decision(True, "vertices that face away are lit with the opposite normal")
        unused = "nothing depends on the normal" if draft.equation.two_sided else self.absent
        return Decision(False, draft.why_without(self.name) or unused)


class LocalViewer(Effect):
    """A viewer with a place, which may be taken at infinity where he is far away."""

    def simplify(self, draft: Draft) -> Draft:
        equation = draft.equation
        if equation.eye is None or not equation.has_highlights or equation.is_flipped or not draft.allowance:
            return draft
        if equation.bounces and equation.diffuse_needs_viewer:
            return draft  # what is bounced depends on him too, for which there is no bound
        seen = draft.extent.sight(equation.eye)
        if seen is None or seen.distance < 2 * seen.radius:
            return draft
        changes = [
            term.gain * draft.reach(term).strongest * change
            for term in equation.terms
            if equation.needs_viewer(term) and (change := largest_change(draft, term, seen.turn, light_moves=False))
        ]
        bound = math.fsum(changes) * ROUNDED_UP
        if not bound <= draft.allowance:
            return draft
        why = f"far away: its direction is the same to {bound:.2g}"
        far = replace(equation, eye=None, to_eye=seen.direction, local_facing=False)
        return draft.rewritten(far, Note(self.name, "", why, bound, only_for_this_viewer=True))

    def decide(self, draft: Draft) -> Decision:
        equation = draft.equation
        if equation.needs_eye:
            mirrors = any(equation.has(term, "specular") for term in equation.terms)
            read_by = "highlights" if mirrors else "diffuse reflection"
            return Decision(True, read_by if equation.has_highlights else "normals are turned to it")
        unused = "the viewer is at infinity" if equation.has_highlights else self.absent
        return Decision(False, draft.why_without(self.name) or unused, draft.bound_of(self.name))


# --- visibility


class Shadow(Effect):
    """A light's shadows, which are left out where nothing can block it.

    Of a light with a size that is partly hidden, each lobe reflects a share of what it would of all: that of its light
    which reaches the vertex, as a matt surface receives it. That is exact for those; a highlight, which may see the
    hidden part alone, is off by up to its brightness. `tradeoff` measures by how much.
    """

    def leave_out(self, draft: Draft, term: LightTerm) -> Change | None:
        if not term.is_shadowed:
            return None
        why = "" if draft.visibility is None else draft.visibility.why_clear(term.index)
        if not term.needs_normals:
            why = "adds ambient light alone"
        return ((replace(term, is_shadowed=False),), (Note(self.name, term.label, why),)) if why else None

    def has(self, equation: Equation, term: LightTerm) -> bool:
        return term.is_shadowed

    def decide(self, draft: Draft) -> Decision:
        """Its reason also names lights whose highlights are a share, where they are partly hidden."""
        decision, equation = super().decide(draft), draft.equation
        terms = [term for term in equation.terms if self.has(equation, term) and equation.has(term, "specular")]
        labels = [term.label for term in terms if term.light.has_size]
        if not labels:
            return decision
        return replace(
            decision,
            why=f"{decision.why}; where a part is hidden, the same part of the highlight ({', '.join(labels)})",
        )

    def term_without(self, equation: Equation, term: LightTerm, point: Vector) -> LightTerm:
        return replace(term, is_shadowed=False)


class Occlusion(Effect):
    """Ambient light by how open the sky is, where something can hide it."""

    def simplify(self, draft: Draft) -> Draft:
        equation = draft.equation
        if not equation.is_occluded:
            return draft
        why = "" if draft.visibility is None else draft.visibility.why_open()
        if not (any(equation.ambient) or any(any(term.ambient) for term in equation.terms)):
            why = "there is no ambient light"
        if not why:
            return draft
        return draft.rewritten(replace(equation, is_occluded=False), Note(self.name, "", why))

    def decide(self, draft: Draft) -> Decision:
        if draft.equation.is_occluded:
            return Decision(True, "ambient light, times the open part of the sky")
        return Decision(False, draft.why_without(self.name) or self.absent)


_FAR_AWAY, _OPEN_SKY = {"eye": None, "local_facing": False}, {"is_occluded": False}

# In the order in which they are left out, for what goes early makes what follows cheaper to judge: first what adds
# nothing whatever the tolerance, then whole lights, then what each light that is left can do without.
# The cost of visibility is that of reading it: rays are cast once for all materials and colours.
EFFECTS: tuple[Effect, ...] = (
    NormalTransform("normal transform", ("normals",), "no matrix, or the identity", {"turns_normals": False}, once=0.7),
    TwoSided("two-sided", ("normals", "viewer"), "the light model is one-sided", {"two_sided": False}, once=0.5),
    Emission("emission", (), "black emission", {"emission": BLACK}),
    Ambient("ambient", (), "black ambient light or ambient reflectance", {"ambient": BLACK}, each=0.3),
    Bounces(BOUNCES, ("points", "normals"), "the light model has no bounces", {"bounces": 0}),
    Lights(_LIGHTS, (), _NO_LIGHT, {"terms": ()}),
    Size(SIZE, ("points",), "no light has a size", each=20.0),
    Sky(SKY, ("normals",), "no light from all around varies", each=13.0),  # for each channel, with about nine bands
    LightEffect(CONE, ("points",), "no spot light", each=1.6),
    Specular("specular", ("normals", "viewer"), "black specular colour", each=1.4),
    LightEffect(ATTENUATION, ("points",), "no light weakens with distance", each=0.7),
    LightEffect(POSITION, ("points",), "every light is directional", once=0.5, each=0.2),
    # without it he is at infinity along the view axis, as `LightModel(local_viewer=False)` has it
    LocalViewer("local viewer", ("points", "viewer"), "no highlight is left that depends on it", _FAR_AWAY, once=0.6),
    Reflection("diffuse", ("normals",), "black diffuse colour", once=0.5, each=0.2),
    Shadow("shadow", ("points", "normals"), "the light model has no shadows", each=0.2),
    Occlusion("occlusion", ("points", "normals"), "the light model has no ambient occlusion", _OPEN_SKY, once=0.2),
)
