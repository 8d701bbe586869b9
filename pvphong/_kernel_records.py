"""An equation as two arrays of records, the form in which compiled code takes it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pvphong._types import Vector
from pvphong._vectors import unit
from pvphong.equation import BRIGHTEST, Equation, LightTerm
from pvphong.lights import DirectionalLight, Light, PointLight, SpotLight
from pvphong.transform import normal_matrix

NO_HIGHLIGHT, PHONG, BLINN_PHONG, HEADLIGHT = range(4)
"""Kinds of highlight."""

SETTINGS = np.dtype(
    [
        ("needs_normals", "?"),
        ("needs_points", "?"),
        ("needs_eye", "?"),
        ("is_flipped", "?"),
        ("has_local_facing", "?"),
        ("has_matrix", "?"),
        ("is_wide", "?"),
        ("eye", "3f8"),
        ("to_eye", "3f8"),
        ("matrix", "(3,4)f8"),
        ("w", "f8"),
        ("normal_matrix", "(3,3)f8"),
        ("shininess", "f8"),
        ("floor", "f8"),
        ("dark", "f8"),
        ("base", "3f8"),
        ("emission", "3f8"),
        ("low", "f8"),
        ("high", "f8"),
    ],
    align=True,
)
"""What all lights share. `dark`: from this squared chord on, a highlight is 0."""

TERM = np.dtype(
    [
        ("is_parallel", "?"),
        ("varies", "?"),
        ("has_cone", "?"),
        ("has_ambient", "?"),
        ("needs_normals", "?"),
        ("highlight", "i8"),
        ("position", "3f8"),
        ("axis", "3f8"),
        ("edge", "f8"),
        ("exponent", "f8"),
        ("dark", "f8"),
        ("constant", "f8"),
        ("linear", "f8"),
        ("quadratic", "f8"),
        ("gain", "f8"),
        ("ambient", "3f8"),
        ("diffuse", "3f8"),
        ("specular", "3f8"),
    ],
    align=True,
)
"""One light. `position`: for parallel light the unit vector towards it. `varies`: whether its strength is taken
at each vertex; else the strength is in the colours."""
