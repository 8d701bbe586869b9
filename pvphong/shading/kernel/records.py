"""An equation as records and numbers, packed into bytes: the form in which compiled code takes it."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np

from pvphong.base.formulas import FORMULAS
from pvphong.base.types import Vector
from pvphong.geometry.transform import normal_matrix
from pvphong.shading.equation import Equation
from pvphong.shading.kernel.stages import LEAST_NUMBERS, reflectance_numbers
from pvphong.shading.kernel.terms import (
    MOST_LOBES,
    Coder,
    Codes,
    Record,
    Stages,
    are_in_range,
    codes_of_lights,
    holds,
    joined,
    layout_of,
    sum_of,
)

SETTINGS = np.dtype(
    [
        ("needs_normals", "?"),
        ("needs_points", "?"),
        ("needs_eye", "?"),
        ("is_flipped", "?"),
        ("has_local_facing", "?"),
        ("has_lobes_of_viewer", "?"),
        ("moves_points", "?"),
        ("is_wide", "?"),
        ("turns_normals", "?"),
        ("has_albedo", "?"),
        ("is_display", "?"),
        ("is_sunlit", "?"),
        ("is_even", "?"),
        ("count", "i8"),
        ("stride", "i8"),
        ("sky", "i8"),
        ("tangents", "i8"),
        ("channel_length", "i8"),
        ("takes_albedo", "i8"),
        ("eye", "3f8"),
        ("to_eye", "3f8"),
        ("matrix", "(3,4)f8"),
        ("w", "f8"),
        ("normal_matrix", "(3,3)f8"),
        ("base", "3f8"),
        ("own", "3f8"),
        ("emission", "3f8"),
        ("exponent", "f8"),
        ("low", "f8"),
        ("high", "f8"),
    ],
    align=True,
)
"""What all lights share. `is_sunlit`: there is just one light, even and with Lambert's factor alone, no albedo, and
normals are used as they come. `is_even`: every vertex has the same colour. `count`: of lights. `stride`: how many
numbers each stage has. `sky`, `tangents`: the channel with the open part of the sky, and the first of three with
tangents, or -1. `channel_length`: from one channel to the next. `own`: a colour beside `base` that the sky has no part
in. `is_wide`: points are float64 beside rows of float32. `takes_albedo`: lobes that do, as the sum of 1, 2 and 4.
`exponent`: the sum of all light is raised to it."""

_LAYOUT = layout_of(SETTINGS)

_ORIGIN = (0.0, 0.0, 0.0)
_NO_MATRIX: tuple[Sequence[float], float, Sequence[float]] = (0.0,) * 12, 1.0, (0.0,) * 9


class Records(NamedTuple):
    """What the driver reads of an equation."""

    settings: bytes
    """One of type `SETTINGS`."""
    terms: bytes
    """Of type `TERM`, one for each light."""
    numbers: bytes
    """Floats of the reflectance's stage, then of each light's; a row each, filled up with zeros."""


def codes_of(equation: Equation, real: str, *, has_albedo: bool) -> Codes | None:
    """The code of each of its lights; None where compiled code cannot take the equation.

    It can if all lights and the reflectance have stages, and numbers are within its range.
    """
    lobes = equation.reflectance.lobes
    if equation.maps or (has_albedo and any(lobe.tint for lobe in lobes)):
        return None
    if len(lobes) > MOST_LOBES or type(equation.reflectance).factors not in FORMULAS:
        return None
    if equation.matrix is not None:
        matrix = equation.matrix
        if matrix[3, :3].any() or matrix[3, 3] == 0.0:
            return None  # the reference says what is wrong with it
        if not holds(np.abs(matrix).ravel().tolist()):
            return None
    return codes_of_lights(equation, real) if are_in_range(equation.eye or ()) else None


def records_of(
    equation: Equation,
    codes: Codes,
    stages: Stages,
    real: str,
    *,
    is_wide: bool,
    has_albedo: bool,
    is_display: bool,
    channel_length: int = 0,
) -> Records:
    """An equation for rows of a type; `is_wide` if vertices are stored in a wider one.

    Codes are those of this equation, or of the whole one of which a plan has left it.
    """
    matrix, w, normals_matrix = _NO_MATRIX
    turns_normals = equation.matrix is not None and equation.needs_normals and equation.turns_normals
    if equation.matrix is not None:
        matrix, w = equation.matrix[:3].ravel().tolist(), equation.matrix[3, 3]
        if turns_normals:
            normals_matrix = normal_matrix(equation.matrix).ravel().tolist()
    coder = Coder(equation, codes, stages, real)
    base, numbers = equation.ambient, [reflectance_numbers(equation.reflectance)]
    lights: list[Record] = []
    for term in equation.terms:
        record, own = coder.record(term)
        if record.is_even:
            base = _plus(base, record.ambient)
        lights.append(record)
        numbers.append(own)
    stride = max(LEAST_NUMBERS, *map(len, numbers))
    scalars = {
        "needs_normals": equation.needs_normals,
        "needs_points": equation.needs_points,
        "needs_eye": equation.needs_eye,
        "is_flipped": equation.is_flipped,
        "has_local_facing": equation.local_facing,
        "has_lobes_of_viewer": equation.has_highlights,
        "moves_points": equation.matrix is not None,
        "is_wide": equation.needs_points and (is_wide or equation.matrix is not None),
        "turns_normals": turns_normals,
        "has_albedo": has_albedo,
        "is_display": is_display,
        "is_sunlit": (
            [(each.is_even, each.wanted, each.reflects, each.visible) for each in lights] == [(True, 1, 0, -1)]
            and not (turns_normals or equation.is_flipped or equation.is_occluded or has_albedo or is_display)
        ),
        "is_even": not (equation.needs_normals or equation.needs_points or equation.is_occluded or has_albedo),
        "count": len(lights),
        "stride": stride,
        "sky": equation.lights if equation.is_occluded else -1,
        "tangents": equation.channels["tangents"].start if equation.needs_tangents else -1,
        "channel_length": channel_length,
        "takes_albedo": sum_of(lobe.takes_albedo for lobe in equation.reflectance.lobes),
    }
    vectors = {
        "eye": equation.eye or _ORIGIN,
        "to_eye": equation.to_eye,
        "matrix": matrix,
        "w": (w,),
        "normal_matrix": normals_matrix,
        "base": base if has_albedo or equation.is_occluded else _plus(base, equation.emission),
        "own": _ORIGIN if has_albedo else equation.emission,
        "emission": equation.emission,
        "exponent": (1.0 / equation.gamma,),
        "low": (0.0 if equation.clamp else -math.inf,),
        "high": (1.0 if equation.clamp else math.inf,),
    }
    rows = [number for own in numbers for number in (*own, *(0.0,) * (stride - len(own)))]
    settings = _LAYOUT.pack(*scalars.values(), *chain.from_iterable(vectors.values()))
    return Records(settings, joined(lights), struct.pack(f"{len(rows)}d", *rows))


def _plus(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]
