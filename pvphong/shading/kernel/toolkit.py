"""What the stages of lights and reflectances are written with: `Light.stage` and `Reflectance.stage` are given it.

A stage lights a block of `BLOCK` vertices at once. Its loops run over i in range(BLOCK), are simple enough for LLVM to
vectorise (no branch, `min`, `max` and choices between two numbers at hand), and read and write `rows[ROW + i]` for the
rows named here. Literals must be float32 (`ZERO`, `ONE`, `TWO`, or `like(rows, x)`), for a Python float widens the
arithmetic; sums that are not to be rounded twice are written with `multiply_add`. None of it can be called from Python.
"""

from __future__ import annotations

import numpy as np

from pvphong.shading.kernel.arithmetic import exp2, like, multiply_add, shifted
from pvphong.shading.kernel.caps import cap_cosine, cap_power, see_cap
from pvphong.shading.kernel.disks import disk_cosine, disk_power, see_disk
from pvphong.shading.kernel.harmonics import add_harmonics, hide_below, look_around, not_below
from pvphong.shading.kernel.sides import polygon_cosine, polygon_power, see_polygon
from pvphong.shading.kernel.vertices import (
    BLOCK,
    DX,
    DY,
    DZ,
    FACING,
    FIRST,
    INVERSE,
    NEARNESS,
    NO_LENGTH,
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
    ZERO_SQUARE,
    approach,
    approach_measured,
    attenuate,
    dot,
    inverse_root,
    normal_dot,
    root,
    square_of,
)

ZERO, ONE, TWO = np.float32(0.0), np.float32(1.0), np.float32(2.0)

LOBES = FIRST, SECOND, THIRD
"""The rows of lobes' factors, in their order."""

__all__ = [
    "BLOCK",
    "DX",
    "DY",
    "DZ",
    "FACING",
    "FIRST",
    "INVERSE",
    "LOBES",
    "NEARNESS",
    "NO_LENGTH",
    "NX",
    "NY",
    "NZ",
    "ONE",
    "SECOND",
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
    "approach",
    "approach_measured",
    "attenuate",
    "cap_cosine",
    "cap_power",
    "disk_cosine",
    "disk_power",
    "dot",
    "exp2",
    "hide_below",
    "inverse_root",
    "like",
    "look_around",
    "multiply_add",
    "normal_dot",
    "not_below",
    "polygon_cosine",
    "polygon_power",
    "root",
    "see_cap",
    "see_disk",
    "see_polygon",
    "shifted",
    "square_of",
]
