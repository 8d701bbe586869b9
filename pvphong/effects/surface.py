"""What belongs to the surface and not to a light: ambient light, emission, and the model matrix."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pvphong._types import Float64Array
from pvphong.effects._draft import Decision, Draft, Effect, unchanged


def _decide_ambient(draft: Draft) -> Decision:
    if any(draft.equation.ambient):
        return Decision(True, "one constant for all vertices")
    return Decision(False, "black ambient light or ambient reflectance")


def _decide_emission(draft: Draft) -> Decision:
    if any(draft.equation.emission):
        return Decision(True, "one constant for all vertices")
    return Decision(False, "black emission")


AMBIENT = Effect("ambient", (), unchanged, _decide_ambient)
EMISSION = Effect("emission", (), unchanged, _decide_emission)


def _leave_out_transform(draft: Draft) -> Draft:
    """The identity goes altogether; a matrix that turns and shears nothing leaves normals as they are."""
    equation = draft.equation
    if equation.matrix is None:
        return draft
    if np.array_equal(equation.matrix, np.eye(4)):
        return replace(draft, equation=replace(equation, matrix=None, turns_normals=False))
    return replace(draft, equation=replace(equation, turns_normals=_kind(equation.matrix) not in _KEEPING))


_KEEPING = ("a translation", "a uniform scale")


def _kind(matrix: Float64Array) -> str:
    """The class of an affine matrix, as far as it concerns normals; equality is exact."""
    linear, w = matrix[:3, :3], matrix[3, 3]
    if np.array_equal(linear, np.eye(3) * linear[0, 0]) and np.sign(linear[0, 0]) == np.sign(w):
        return "a translation" if linear[0, 0] == w else "a uniform scale"
    scaled = np.ldexp(linear, -np.frexp(np.abs(linear).max())[1])  # so that no product overflows
    gram = scaled.T @ scaled
    if np.allclose(gram, np.eye(3) * gram[0, 0], rtol=0.0, atol=1e-12):
        return "rigid or similar: the inverse-transpose is the matrix itself, but for its scale"
    return "general: normals need the inverse-transpose"


def _decide_transform(draft: Draft) -> Decision:
    equation = draft.equation
    if equation.matrix is None:
        return Decision(False, "no matrix, or the identity")
    if not equation.needs_normals:
        return Decision(False, "nothing depends on the normal")
    kind = _kind(equation.matrix)
    return Decision(equation.turns_normals, kind if equation.turns_normals else f"{kind} leaves normals as they are")


NORMAL_TRANSFORM = Effect("normal transform", ("normals",), _leave_out_transform, _decide_transform, once=0.7)
