"""Rays in scaled coordinates: all triangles lie in [−1, 1], so that float32 resolves them evenly.

If a ray begins far away, its start is moved along the ray to a point near the triangles.
"""

from __future__ import annotations

from typing import Any

from pvphong.base.formulas import dot, formula, maximum

NEAR = 4.0
"""Largest coordinate of a ray's start, in magnitude. A start that is farther away is moved along its ray."""

LONGEST = 4.0 * NEAR
"""Upper limit of distances along a ray to a triangle, from a start with coordinates up to `NEAR`."""


@formula
def begun_near(start: Any, direction: Any, length: Any) -> Any:
    """Move a ray's start along the ray to a point near the triangles, if the ray begins far away.

    All triangles lie in [−1, 1].

    Parameters
    ----------
    start, direction : vector
        Start of the ray, and unit vector along it.
    length : number
        Length of the ray.

    Returns
    -------
    start, length
        The new start, and the remaining length.
    """
    ahead = maximum(-dot(start, direction) - NEAR / 2, 0.0)
    x, y, z = (start[0] + ahead * direction[0], start[1] + ahead * direction[1], start[2] + ahead * direction[2])
    return (x, y, z), length - ahead


@formula
def is_near(start: Any, most: Any) -> Any:
    """Return True if no coordinate of the vector `start` exceeds `most` in magnitude; False if a coordinate is NaN."""
    x, y, z = start
    return (x <= most) & (x >= -most) & (y <= most) & (y >= -most) & (z <= most) & (z >= -most)
