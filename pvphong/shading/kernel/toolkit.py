"""What the stages of lights and reflectances are written with: `Light.stage` and `Reflectance.stage` are given it.

A stage lights a block of `BLOCK` vertices at once. Its loops run over i in range(BLOCK), are simple enough for LLVM to
vectorise (no branch, `min`, `max` and choices between two numbers at hand), and read and write `rows[ROW + i]` for the
rows named here. Literals must be float32 (`ZERO`, `ONE`, `TWO`, or `like(rows, x)`), for a Python float widens the
arithmetic; sums that are not to be rounded twice are written with `multiply_add`. None of it can be called from Python.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from pvphong.shading.kernel.adding import lambert
from pvphong.shading.kernel.arithmetic import exp2, multiply_add, plain
from pvphong.shading.kernel.caps import cap_cosine, cap_power, see_cap
from pvphong.shading.kernel.disks import disk_cosine, disk_power, see_disk
from pvphong.shading.kernel.halfway import halfway_sines, mirror_chord
from pvphong.shading.kernel.harmonics import add_harmonics, hide_below, look_around, not_below
from pvphong.shading.kernel.pointers import like, shifted
from pvphong.shading.kernel.powers import raise_second
from pvphong.shading.kernel.rows import (
    BLOCK,
    DX,
    DY,
    DZ,
    FACING,
    FIRST,
    INVERSE,
    NEARNESS,
    NX,
    NY,
    NZ,
    SECOND,
    STRENGTH,
    THIRD,
    TX,
    TY,
    TZ,
    VX,
    VY,
    VZ,
)
from pvphong.shading.kernel.sides import polygon_cosine, polygon_power, see_polygon
from pvphong.shading.kernel.vectors import NO_LENGTH, ZERO_SQUARE, dot, inverse_root, root, square_of
from pvphong.shading.kernel.ways import approach, approach_measured, attenuate, normal_dot

ZERO, ONE, TWO = np.float32(0.0), np.float32(1.0), np.float32(2.0)

LOBES = FIRST, SECOND, THIRD
"""The rows of lobes' factors, in their order."""

# Numbers further from 1 are left to the reference: float32 could not hold their products.
LARGEST, SMALLEST = 2.0**100, 2.0**-100


def holds(numbers: Iterable[Any]) -> bool:
    """Whether float32 holds products of numbers >= 0: each is 0, or not further than 2¹⁰⁰ from 1."""
    for x in numbers:  # noqa: SIM110 as for `are_in_range`: a third of the time
        if x and not SMALLEST <= x <= LARGEST:
            return False
    return True


@plain
def only_lambert(numbers: Any, rows: Any, _points: Any) -> int:  # noqa: ARG001 as any stage's
    """The stage of a reflectance of which Lambert's factor alone is wanted; the driver has it in faster loops."""
    for i in range(BLOCK):
        rows[FIRST + i] = lambert(rows, i)
    return 1


def already_there(_numbers: Any, _rows: Any, _points: Any) -> int:
    """In place of a reflectance's stage, where that of a light with a size has written the factors."""
    return 7


__all__ = [
    "BLOCK",
    "DX",
    "DY",
    "DZ",
    "FACING",
    "FIRST",
    "INVERSE",
    "LARGEST",
    "LOBES",
    "NEARNESS",
    "NO_LENGTH",
    "NX",
    "NY",
    "NZ",
    "ONE",
    "SECOND",
    "SMALLEST",
    "STRENGTH",
    "THIRD",
    "TWO",
    "TX",
    "TY",
    "TZ",
    "VX",
    "VY",
    "VZ",
    "ZERO",
    "ZERO_SQUARE",
    "add_harmonics",
    "already_there",
    "approach",
    "approach_measured",
    "attenuate",
    "cap_cosine",
    "cap_power",
    "disk_cosine",
    "disk_power",
    "dot",
    "exp2",
    "halfway_sines",
    "hide_below",
    "holds",
    "inverse_root",
    "like",
    "look_around",
    "mirror_chord",
    "multiply_add",
    "normal_dot",
    "not_below",
    "only_lambert",
    "polygon_cosine",
    "polygon_power",
    "raise_second",
    "root",
    "see_cap",
    "see_disk",
    "see_polygon",
    "shifted",
    "square_of",
]
