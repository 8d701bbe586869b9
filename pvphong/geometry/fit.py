"""How stored normals fit the faces of a mesh."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.geometry.normals import Faces

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


def areas_of(faces: Faces) -> tuple[Float64Array, Float64Array]:
    """The areas of faces, in units of their own that do not overflow, and of them what belongs to each point.

    A face shares its area evenly among its corners.
    """
    areas = np.zeros(faces.count)
    exponents = [block.exponents.max(initial=0) for block in faces.blocks()]
    for block in faces.blocks():
        twice = np.sqrt(np.square(block.area_vectors()).sum(axis=0))
        areas[block.faces] = np.ldexp(twice / 2.0, 2 * (block.exponents - max(exponents)))
    weights: Float64Array = np.zeros(faces.n_points)
    np.add.at(weights, faces.connectivity, np.repeat(areas / np.maximum(faces.sizes, 1), faces.sizes))
    return areas, weights


def fit_of(stored: FloatArray, computed: Float64Array, weights: Float64Array) -> tuple[NormalsFit | None, IntArray]:
    """How stored normals fit computed ones, and the points where they are off by more than `MISFIT`.

    Points without either, or without a weight, are passed over; there is no fit where none is left.
    """
    wide = stored.astype(np.float64)
    with np.errstate(all="ignore"):
        wide = wide / np.abs(wide).max(axis=1, keepdims=True)  # so that squares can be taken
        wide /= np.linalg.norm(wide, axis=1, keepdims=True)
        cosines = np.einsum("ij,ij->i", wide, computed)
    known = np.flatnonzero(np.isfinite(cosines) & computed.any(axis=1) & (weights > 0.0))
    if not len(known):
        return None, known
    angles, shares = np.degrees(np.arccos(np.clip(cosines[known], -1.0, 1.0))), weights[known] / weights[known].sum()
    fit = NormalsFit(float(angles @ shares), float(angles.max()), float(shares[angles > BEYOND].sum()))
    return fit, known[angles > MISFIT]
