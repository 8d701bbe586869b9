"""Division of the sky into patches.

The patches are those of P. Tregenza, "Subdivision of the sky hemisphere for luminance measurements" (1987): seven rows
of the same height and a cap around the zenith, 145 patches of nearly equal size. C. Reinhart's subdivision divides each
patch outside the cap into four, 577 in all.

Coordinates are local: x east, y north, z up. Azimuths are clockwise from north.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pvphong.base import sobol
from pvphong.base.types import Float64Array
from pvphong.base.vectors import all_dots

_IN_ROWS = 30, 30, 24, 24, 18, 12, 6


@dataclass(frozen=True, eq=False)
class Patches:
    """Patches of the sky, each a range of altitudes and azimuths.

    Parameters
    ----------
    finer : int
        Number of parts into which the sides of Tregenza's patches are divided: 1 for 145 patches, 2 for 577.
    """

    finer: int = 1

    def __len__(self) -> int:
        return sum(_IN_ROWS) * self.finer**2 + 1

    @cached_property
    def bounds(self) -> Float64Array:
        """Bounds of the patches, shape (k, 4).

        The columns are the sine of the least altitude, the sine of the greatest altitude, the first azimuth and the
        width. Azimuth and width are in radians.
        """
        height = 0.5 * math.pi / (len(_IN_ROWS) * self.finer + 0.5)
        found = []
        for row in range(len(_IN_ROWS) * self.finer):
            count = _IN_ROWS[row // self.finer] * self.finer
            width, low, high = 2.0 * math.pi / count, math.sin(row * height), math.sin((row + 1) * height)
            found += [(low, high, (number - 0.5) * width, width) for number in range(count)]
        return np.array([*found, (math.cos(0.5 * height), 1.0, 0.0, 2.0 * math.pi)])

    @cached_property
    def areas(self) -> Float64Array:
        """Solid angles in steradians, shape (k,)."""
        low, high, _, width = self.bounds.T
        return (high - low) * width

    @cached_property
    def moments(self) -> Float64Array:
        """Integrals ∫ u du of the unit vectors u over the patches, shape (k, 3).

        A patch of radiance 1 that is above a surface's tangent plane gives the irradiance n · ∫ u du to the surface,
        with n its normal.
        """
        low, high, start, width = self.bounds.T
        first, last = np.arcsin(low), np.arcsin(high)
        level = 0.5 * (last - first) + 0.25 * (np.sin(2.0 * last) - np.sin(2.0 * first))
        east, north = np.cos(start) - np.cos(start + width), np.sin(start + width) - np.sin(start)
        return np.stack([level * east, level * north, 0.5 * (high**2 - low**2) * width], axis=1)

    @cached_property
    def half_height(self) -> float:
        """Half the range of the cosines between a normal and the directions in one patch; `seen_from` uses it.

        It is half the sine of a row's height. This is exact for the lowest row and a normal to the zenith.
        """
        return 0.5 * math.sin(0.5 * math.pi / (len(_IN_ROWS) * self.finer + 0.5))

    def points(self, count: int) -> Float64Array:
        """Return unit vectors to points in each patch, evenly distributed by area, shape (k, count, 3).

        The points of a patch are the first points of a Sobol sequence. Each patch has a different scrambling.
        """
        low, high, start, width = (each[:, None] for each in self.bounds.T)
        numbers, seeds = np.arange(count, dtype=np.uint32), sobol.seeds(np.arange(len(self)))[..., None]
        height = low + sobol.coordinate(numbers, seeds[0]).astype(np.float64) * (high - low)
        around = start + sobol.coordinate(sobol.SECOND[:count], seeds[1]) * width
        level = np.sqrt(1.0 - height * height)
        return np.stack([level * np.sin(around), level * np.cos(around), height], axis=-1)

    def seen_from(self, normals: Float64Array) -> Float64Array:
        """Return the integrals of the cosine over all patches, for normals of shape (n, 3); shape (n, k).

        A result is exact if the patch is completely above or below the tangent plane. If the plane cuts the patch, the
        cosines in the patch are taken as evenly distributed over a range. This changes the sum over all patches by at
        most 0.01 % of π.
        """
        half = self.half_height
        mean = all_dots(normals, self.moments / self.areas[:, None])
        partly = np.clip(mean + half, 0.0, 2.0 * half)
        return (partly * partly * (0.25 / half) + np.maximum(mean - half, 0.0)) * self.areas
