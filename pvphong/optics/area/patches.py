"""Division of the sky into patches, and rays to all of them.

The patches are those of P. Tregenza, "Subdivision of the sky hemisphere for luminance measurements" (1987): seven rows
of the same height and a cap around the zenith, 145 patches of nearly equal size. C. Reinhart's subdivision divides each
patch outside the cap into four, 577 in all.

Coordinates are local: x east, y north, z up. Azimuths are clockwise from north.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from pvphong.base.formulas import ONE, ZERO, cosine, dot, formula, index, maximum, minimum, sine, single, sqrt
from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.optics.area.sampling import Sampling

_IN_ROWS = 30, 30, 24, 24, 18, 12, 6
# Index of the patches' bounds among the numbers that formulas read.
_TABLE = 10
# Number of points along each side of a patch at which a sky's radiance is sampled.
_INSIDE = 3


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
        """Sines of the least and greatest altitude, and the first azimuth and the width in radians, shape (k, 4)."""
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

        A patch of radiance 1 gives the irradiance n · ∫ u du to a surface with the normal n, if it is above the
        surface's tangent plane.
        """
        low, high, start, width = self.bounds.T
        first, last = np.arcsin(low), np.arcsin(high)
        level = 0.5 * (last - first) + 0.25 * (np.sin(2.0 * last) - np.sin(2.0 * first))
        east, north = np.cos(start) - np.cos(start + width), np.sin(start + width) - np.sin(start)
        return np.stack([level * east, level * north, 0.5 * (high**2 - low**2) * width], axis=1)

    @cached_property
    def half_height(self) -> float:
        """Half the range of a patch's cosines with a direction to its side: exact for the zenith and the lowest row."""
        return 0.5 * math.sin(0.5 * math.pi / (len(_IN_ROWS) * self.finer + 0.5))

    @cached_property
    def inside(self) -> Float64Array:
        """Unit vectors to points spread evenly in each patch, shape (k, m, 3)."""
        low, high, start, width = (each[:, None, None] for each in self.bounds.T)
        part = (np.arange(_INSIDE) + 0.5) / _INSIDE
        height, around = low + part[:, None] * (high - low), start + part * width
        return _directions(*np.broadcast_arrays(height, around)).reshape(len(self), -1, 3)

    def seen_from(self, normals: Float64Array) -> Float64Array:
        """Return the integrals of the cosine over all patches, for normals of shape (n, 3); shape (n, k).

        They are exact for patches that are completely above or below a tangent plane. In a patch that is cut by the
        plane, the cosine is taken as evenly spread: that changes the sum over all patches by at most 0.01 % of π.
        """
        half = self.half_height
        mean = normals @ (self.moments / self.areas[:, None]).T
        partly = np.clip(mean + half, 0.0, 2.0 * half)
        return (partly * partly * (0.25 / half) + np.maximum(mean - half, 0.0)) * self.areas

    # -- rays

    def sampling(self, axes: Float64Array, side: float = 1.0) -> Sampling:
        """Return a sampling that casts equally many rays to each patch; weights are cosines.

        The first coordinate of the square chooses the patch and the altitude, and the second the azimuth.

        Parameters
        ----------
        axes : ndarray
            Unit vectors to the east, to the north and up, as rows.
        side : float, default 1
            -1 for the mirror image of the sky below the horizon, which is where the ground is seen.
        """
        bounds = self.bounds * (side, side, 1.0, 1.0)
        return Sampling(patch_frame, patch_sample, None, np.concatenate([[len(self)], axes.ravel(), bounds.ravel()]))

    def chosen(self, u: FloatArray) -> IntArray:
        """Return the patch that each first coordinate, float32, chooses."""
        return np.minimum((u * np.float32(len(self))).astype(np.int64), len(self) - 1)


def _directions(height: Float64Array, around: Float64Array) -> Float64Array:
    """Return unit vectors by the sines of their altitudes and by their azimuths."""
    level = np.sqrt(1.0 - height * height)
    return np.stack([level * np.sin(around), level * np.cos(around), height], axis=-1)


@formula
def patch_frame(_numbers: Any, _p: Any, n: Any) -> Any:
    """Compute the frame of the sky's patches: the reach, the factor 1, and the normal."""
    return math.inf, 1.0, *n


@formula
def patch_sample(numbers: Any, frame: Any, u: Any, v: Any) -> Any:
    """Sample all patches equally, and evenly by solid angle in each; the weight is the cosine.

    Numbers: the number of patches; the axes to the east, to the north and up; and the bounds of each patch.
    """
    place = u * single(numbers[0])
    patch = minimum(index(place), int(numbers[0]) - 1)
    at = _TABLE + 4 * patch
    low = numbers[at]
    height = low + (place - patch) * (numbers[at + 1] - low)
    around = numbers[at + 2] + v * numbers[at + 3]
    level = sqrt(maximum(1.0 - height * height, 0.0))
    east, north = level * sine(around), level * cosine(around)
    direction = (
        single(east * numbers[1] + north * numbers[4] + height * numbers[7]),
        single(east * numbers[2] + north * numbers[5] + height * numbers[8]),
        single(east * numbers[3] + north * numbers[6] + height * numbers[9]),
    )
    return direction, ONE, maximum(dot(frame[0:3], direction), ZERO)
