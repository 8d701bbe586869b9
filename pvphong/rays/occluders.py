"""What can block light: parts, each the triangles of one mesh."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from pvphong.base import check
from pvphong.base.processes import available_memory
from pvphong.base.types import BoolArray, FloatArray
from pvphong.rays.casting import BYTES_PER_TRIANGLE, Caster, rays_each
from pvphong.rays.faces import Ball, BlockingFaces

# A part so many times smaller than the others is not put into one caster with them, whose resolution is too coarse for
# it: single precision tells 2⁻²⁴ of the whole apart.
_ALIKE = 2.0**8


class Occluders:
    """Parts that block light together.

    Parameters
    ----------
    parts : sequence of BlockingFaces
        In the world.
    """

    def __init__(self, parts: Sequence[BlockingFaces]) -> None:
        self._parts = tuple(parts)

    def __len__(self) -> int:
        return len(self._parts)

    @property
    def count(self) -> int:
        """Of triangles."""
        return sum(map(len, self._parts))

    @property
    def memory(self) -> int:
        """Bytes that casting rays takes for them, about."""
        return self.count * BYTES_PER_TRIANGLE

    @cached_property
    def balls(self) -> list[Ball | None]:
        """Around each part; None for one without a triangle."""
        return [part.ball for part in self._parts]

    @cached_property
    def _groups(self) -> list[list[int]]:
        """Parts that share a caster: those of nearly the size of the largest, then those of the next sizes."""
        left = [(ball.radius, index) for index, ball in enumerate(self.balls) if ball is not None]
        left.sort(reverse=True)
        groups: list[list[int]] = []
        while left:
            alike = [index for radius, index in left if radius * _ALIKE >= left[0][0]]
            groups.append(alike)
            left = left[len(alike) :]
        return groups

    @cached_property
    def casters(self) -> list[Caster]:
        """Built when rays are first cast.

        Raises
        ------
        ValueError
            If they would take more memory than there is.
        """
        available = available_memory()
        if available is not None and self.memory > available:
            got = f"{self.count:,} triangles, which take about {self.memory / 1e9:.3g} GB"
            allowed = f"as many as fit into the {available / 1e9:.3g} GB of memory that are free"
            check.refuse("occluders", got, allowed, "Fewer will do for shadows: mesh.decimate(0.9) takes nine in ten.")
        return [Caster(BlockingFaces.joined([self._parts[index] for index in group])) for group in self._groups]

    def resolution(self, part: int | None) -> float:
        """The length below which nothing is told apart at a part, or else at the finest one; 0 without any."""
        if not self.casters:
            return 0.0
        own = [caster for group, caster in zip(self._groups, self.casters, strict=True) if part in group]
        return (own or self.casters)[-1].resolution

    def blocked(self, origins: FloatArray, directions: FloatArray, distances: FloatArray) -> BoolArray:
        """As `Caster.blocked`, by any part."""
        found = np.zeros(len(directions), bool)
        for caster in self.casters:
            if not found.any():
                found = caster.blocked(origins, directions, distances)
                continue
            free = np.flatnonzero(~found)
            some = origins[free // rays_each(origins, directions)]
            found[free] = caster.blocked(some, directions[free], distances[free])
        return found
