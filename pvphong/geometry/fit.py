"""How stored normals fit the faces of a mesh."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.geometry.normals import FaceBlock, Faces

MISFIT = 22.5
"""Degrees between a stored normal and the faces from which it is off them.

Vertices that VTK's own rules weigh otherwise are 10° off on average, in a mesh with sharp edges. Where an eighth of a
surface is turned round, normals are off by as much as this on average: the same share of a surface spoils its lighting
where its faces are turned.
"""
BEYOND = 60.0
"""Degrees: half of the light, by Lambert's law."""


class NormalsFit(NamedTuple):
    """How far stored normals are off those of the faces around their points, in degrees.

    Attributes
    ----------
    mean : float
        Weighted by the area around each point.
    worst : float
        The largest.
    beyond_60 : float
        The share of the area, 0 to 1, where it is more than 60.
    """

    mean: float
    worst: float
    beyond_60: float


class Areas:
    """The areas of faces as they are found, block by block."""

    def __init__(self, faces: Faces) -> None:
        self._found, self._exponents = np.zeros(faces.count), np.zeros(faces.count, np.int32)

    def put(self, block: FaceBlock, areas: Float64Array) -> None:
        """Those of a block, in units of 2**(2 * exponents)."""
        self._found[block.faces], self._exponents[block.faces] = areas, block.exponents

    @property
    def in_one_unit(self) -> Float64Array:
        """All of them, in a unit of their own in which none overflows."""
        if not self._exponents.any():
            return self._found
        found: Float64Array = np.ldexp(self._found, 2 * (self._exponents - self._exponents.max()))
        return found


def areas_of(faces: Faces) -> Float64Array:
    """The areas of faces, in a unit of their own in which none overflows."""
    areas = Areas(faces)
    faces.in_blocks(lambda block: areas.put(block, np.sqrt(np.square(block.area_vectors()).sum(axis=0)) / 2.0))
    return areas.in_one_unit


def weights_of(faces: Faces, areas: Float64Array) -> Float64Array:
    """Area of each point, shape (n_points,): a face shares its own evenly among its corners."""
    shares = np.repeat(areas / np.maximum(faces.sizes, 1), faces.sizes)
    return np.bincount(faces.connectivity, shares, faces.n_points).astype(np.float64, copy=False)


def fit_of(stored: FloatArray, computed: Float64Array, weights: Float64Array) -> tuple[NormalsFit | None, IntArray]:
    """How stored normals fit computed ones, and the points where they are off by more than `MISFIT`.

    Points without either, or without a weight, are passed over; there is no fit where none is left.
    """
    wide = stored.astype(np.float64)
    with np.errstate(all="ignore"):
        x, y, z = np.abs(wide.T)
        wide = wide / np.maximum(np.maximum(x, y), z)[:, None]  # so that squares can be taken
        wide /= np.sqrt(np.einsum("ij,ij->i", wide, wide))[:, None]
        cosines = np.einsum("ij,ij->i", wide, computed)
    known = np.flatnonzero(np.isfinite(cosines) & np.logical_or.reduce(computed.T != 0.0) & (weights > 0.0))
    if not len(known):
        return None, known
    angles, shares = np.degrees(np.arccos(np.clip(cosines[known], -1.0, 1.0))), weights[known] / weights[known].sum()
    fit = NormalsFit(float(angles @ shares), float(angles.max()), float(shares[angles > BEYOND].sum()))
    return fit, known[angles > MISFIT]
