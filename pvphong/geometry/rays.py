"""Rays in coordinates where all triangles are from −1 to 1, as single precision has them with the same resolution."""

from __future__ import annotations

from typing import Any

from pvphong.base.formulas import dot, formula, maximum

NEAR = 4.0
"""Rays begin at most so far from the middle, along each axis; those from further away where they come as near."""

LONGEST = 4.0 * NEAR
"""No ray that begins there meets anything further on."""


@formula
def begun_near(start: Any, direction: Any, length: Any) -> Any:
    """A ray's start moved on to where it is nearest to the middle, less what triangles reach, and the length left."""
    ahead = maximum(-dot(start, direction) - NEAR / 2, 0.0)
    x, y, z = (start[0] + ahead * direction[0], start[1] + ahead * direction[1], start[2] + ahead * direction[2])
    return (x, y, z), length - ahead


@formula
def is_near(start: Any, most: Any) -> Any:
    """Whether no coordinate is more than so much; not where one is none."""
    x, y, z = start
    return (x <= most) & (x >= -most) & (y <= most) & (y >= -most) & (z <= most) & (z >= -most)
