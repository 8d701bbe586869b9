"""Comparison of stored normals with the faces of a mesh."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pvphong.base import threads
from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.geometry.normals import FaceBlock, Faces

MISFIT = 22.5
"""Threshold in degrees: a stored normal with a larger angle to the computed one does not fit the faces.

VTK weights faces differently. This alone gives a mean angle of 10° in a mesh with sharp edges. If an eighth of a
surface has reversed normals, the mean angle is 22.5° (180°/8), and the lighting of this eighth is wrong.
"""
BEYOND = 60.0
"""Threshold of `NormalsFit.beyond_60`, in degrees: at this angle Lambert's law gives half of the light."""


class NormalsFit(NamedTuple):
    """Angles in degrees between stored normals and the normals of the faces around their points.

    Attributes
    ----------
    mean : float
        Mean angle, weighted by the area around each point.
    worst : float
        Largest angle.
    beyond_60 : float
        Fraction of the area, 0 to 1, where the angle is more than 60°.
    """

    mean: float
    worst: float
    beyond_60: float


# Normals per range of a thread: their arrays stay in its caches.
_AT_ONCE = 2**14


class Areas:
    """Areas of a mesh's faces, stored block by block. The areas of each block have their own unit."""

    def __init__(self, faces: Faces) -> None:
        self._found, self._exponents = np.zeros(faces.count), np.zeros(faces.count, np.int32)

    def put(self, block: FaceBlock, areas: Float64Array) -> None:
        """Store the areas of a block's faces, given in units of 2**(2 * block.exponents)."""
        self._found[block.faces], self._exponents[block.faces] = areas, block.exponents

    @property
    def in_one_unit(self) -> Float64Array:
        """Areas of all faces, shape (n_faces,), in one unit. The unit is chosen so that no area overflows."""
        if not self._exponents.any():
            return self._found
        found: Float64Array = np.ldexp(self._found, 2 * (self._exponents - self._exponents.max()))
        return found


def areas_of(faces: Faces) -> Float64Array:
    """Return the areas of all faces, shape (n_faces,), in one unit. The unit is chosen so that no area overflows."""
    areas = Areas(faces)
    faces.in_blocks(lambda block: areas.put(block, np.sqrt(np.square(block.area_vectors()).sum(axis=0)) / 2.0))
    return areas.in_one_unit


def weights_of(faces: Faces, areas: Float64Array) -> Float64Array:
    """Return the area that belongs to each point, shape (n_points,).

    `areas` has the area of each face. Each face divides its area evenly among its corners.
    """
    shares = np.repeat(areas / np.maximum(faces.sizes, 1), faces.sizes)
    return np.bincount(faces.connectivity, shares, faces.n_points).astype(np.float64, copy=False)


def fit_of(stored: FloatArray, computed: Float64Array, weights: Float64Array) -> tuple[NormalsFit | None, IntArray]:
    """Compare stored normals with computed ones.

    Parameters
    ----------
    stored : ndarray
        Shape (n, 3), stored normals of n points, of any length.
    computed : ndarray
        Shape (n, 3), unit normals from the faces, or zero.
    weights : ndarray
        Shape (n,), the area that belongs to each point.

    Returns
    -------
    fit : NormalsFit or None
        Angles between the normals. A point is ignored if one of its two normals is missing or its weight is 0. None if
        all points are ignored.
    misfits : ndarray
        Indices of the points where the angle is larger than `MISFIT`.
    """
    cosines = np.empty(len(stored))

    def compare(first: int, last: int) -> None:
        with np.errstate(all="ignore"):
            wide = stored[first:last].astype(np.float64)
            x, y, z = np.abs(wide.T)
            wide /= np.maximum(np.maximum(x, y), z)[:, None]  # squares must not overflow
            lengths = np.sqrt(np.einsum("ij,ij->i", wide, wide))
            cosines[first:last] = np.einsum("ij,ij->i", wide, computed[first:last]) / lengths

    threads.run(compare, len(stored), _AT_ONCE)
    known = np.flatnonzero(np.isfinite(cosines) & np.logical_or.reduce(computed.T != 0.0) & (weights > 0.0))
    if not len(known):
        return None, known
    angles, shares = np.degrees(np.arccos(np.clip(cosines[known], -1.0, 1.0))), weights[known] / weights[known].sum()
    fit = NormalsFit(float(angles @ shares), float(angles.max()), float(shares[angles > BEYOND].sum()))
    return fit, known[angles > MISFIT]
