"""Lights with a place and a direction, made from two places."""

from __future__ import annotations

from typing import Any, Self

from pvphong.base.types import VectorLike
from pvphong.optics.roles import direction_from


class Aimed:
    """A light with the fields `position` and `direction`. For kinds of `Light`."""

    @classmethod
    def at(cls, position: VectorLike, *, target: VectorLike, **fields: Any) -> Self:
        """A light at a place, which shines at another.

        Parameters
        ----------
        position, target : sequence of float
            Two places that differ.
        **fields
            The other fields of the light.

        Raises
        ------
        ValueError
            As for the light itself, or if the places are the same.
        """
        kind: Any = cls
        made: Self = kind(position=position, direction=direction_from(position, target), **fields)
        return made
