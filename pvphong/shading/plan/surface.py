"""What belongs to the surface and not to a light: ambient light, emission, and the model matrix."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pvphong.geometry.transform import class_of
from pvphong.shading.equation import BLACK
from pvphong.shading.plan.draft import Decision, Draft, Effect, unchanged


def _decide_ambient(draft: Draft) -> Decision:
    """The light model's, and that of lights, which is a constant too where they have no position."""
    shines_everywhere = any(draft.equation.ambient)
    lights = draft.labels_where(lambda term: any(term.ambient))
    if not (shines_everywhere or lights):
        return Decision(False, "black ambient light or ambient reflectance")
    sources = ["one constant for all vertices"] * shines_everywhere + [f"of {', '.join(lights)}"] * bool(lights)
    varying = draft.lights_where(lambda term: any(term.ambient) and not term.light.is_even)
    return Decision(True, "; ".join(sources), lights=varying)


def _decide_emission(draft: Draft) -> Decision:
    if any(draft.equation.emission):
        return Decision(True, "one constant for all vertices")
    return Decision(False, "black emission")


AMBIENT = Effect(
    "ambient", (), unchanged, _decide_ambient, lambda equation, _: replace(equation, ambient=BLACK), each=0.3
)
EMISSION = Effect("emission", (), unchanged, _decide_emission, lambda equation, _: replace(equation, emission=BLACK))


def _leave_out_transform(draft: Draft) -> Draft:
    """The identity goes altogether; a matrix that turns and shears nothing leaves normals as they are."""
    equation = draft.equation
    if equation.matrix is None:
        return draft
    if np.array_equal(equation.matrix, np.eye(4)):
        return replace(draft, equation=replace(equation, matrix=None, turns_normals=False))
    return replace(draft, equation=replace(equation, turns_normals=not class_of(equation.matrix).keeps_normals))


def _decide_transform(draft: Draft) -> Decision:
    equation = draft.equation
    if equation.matrix is None:
        return Decision(False, "no matrix, or the identity")
    if not equation.needs_normals:
        return Decision(False, "nothing depends on the normal")
    kind = class_of(equation.matrix).value
    return Decision(equation.turns_normals, kind if equation.turns_normals else f"{kind} leaves normals as they are")


NORMAL_TRANSFORM = Effect(
    "normal transform",
    ("normals",),
    _leave_out_transform,
    _decide_transform,
    lambda equation, _: replace(equation, turns_normals=False),
    once=0.7,
)
