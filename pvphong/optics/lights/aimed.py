"""Lights with a position and a direction, made from two points."""

from __future__ import annotations

from typing import Any, Self

from pvphong.base.types import VectorLike
from pvphong.optics.roles import direction_from


class Aimed:
    """Mixin for lights with the fields `position` and `direction`."""

    @classmethod
    def at(cls, position: VectorLike, *, target: VectorLike, **fields: Any) -> Self:
        """Make a light at `position` that shines towards `target`.

        Parameters
        ----------
        position, target : sequence of float
            Two different points.
        **fields
            The other fields of the light.

        Raises
        ------
        ValueError
            If a field is out of range, or the points are the same.
        """
        kind: Any = cls
        made: Self = kind(position=position, direction=direction_from(position, target), **fields)
        return made
