"""How stored normals fit the faces, and which faces have the wrong side for their front."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.geometry.normals import Faces
from pvphong.studies.diagnose.checks import edges_of
from pvphong.studies.diagnose.shells import connected, fan

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


class TurnedFaces(NamedTuple):
    """Faces to turn so that neighbours agree about their front.

    Attributes
    ----------
    faces : ndarray
        Their numbers.
    is_one_sided : bool
        Whether there are parts where no turning helps, as of a Möbius strip.
    is_closed : bool
        Whether each edge has two faces.
    """

    faces: IntArray
    is_one_sided: bool
    is_closed: bool


def turned_faces(points: FloatArray, faces: Faces, areas: Float64Array, weightless: IntArray) -> TurnedFaces:
    """Find the faces that disagree with most about their front.

    Neighbours share an edge that no third face has. Of a part that is closed those are turned whose fronts then look
    inwards, of another one those that cover less.

    Parameters
    ----------
    points : ndarray
        (n, 3).
    faces : Faces
        All with indices of points.
    areas : ndarray
        (n_faces,), of the faces.
    weightless : ndarray
        Faces that are passed over.
    """
    begin, end, owner = edges_of(faces)
    counted = np.ones(faces.count, dtype=bool)
    counted[weightless] = False
    some = (begin != end) & counted[owner]
    begin, end, owner = begin[some], end[some], owner[some]
    undirected = np.minimum(begin, end) * faces.n_points + np.maximum(begin, end)
    order = np.argsort(undirected, kind="stable")
    starts = np.flatnonzero(np.diff(undirected[order], prepend=-1))
    counts = np.diff(starts, append=len(order))
    pairs = starts[counts == 2]
    first, second = order[pairs], order[pairs + 1]
    agree = (begin[first] < end[first]) != (begin[second] < end[second])
    one, two = owner[first], owner[second]

    # Each face twice, as it is and turned: one that agrees with a neighbour goes with it, else with its turned self.
    count = faces.count
    other, other_turned = np.where(agree, two, two + count), np.where(agree, two + count, two)
    labels = connected(2 * count, np.concatenate([one, one + count]), np.concatenate([other, other_turned]))
    as_it_is, turned = labels[:count], labels[count:]
    part, is_turned = np.minimum(as_it_is, turned), as_it_is > turned

    # Of each part the area of the turned ones, less that of the others, or its volume where it is closed
    sign = np.where(is_turned, -1.0, 1.0)
    preferred = np.bincount(part, sign * areas, 2 * count)
    is_open = np.zeros(2 * count, dtype=bool)
    is_open[part[owner[order[np.repeat(counts != 2, counts)]]]] = True
    finite = np.isfinite(points).all(axis=1)
    triangles, face = fan(faces)
    wide = points.astype(np.float64)
    wide = np.ldexp(wide, -int(np.frexp(np.abs(wide[finite]).max(initial=0.0))[1]))
    with np.errstate(all="ignore"):
        p, q, r = (wide[triangles] - wide[faces.connectivity[faces.offsets[part[face]]]][:, None]).transpose(1, 0, 2)
        each = sign[face] * np.einsum("ij,ij->i", p, np.cross(q, r))
    volume = np.bincount(part[face], each, 2 * count)
    decides = ~is_open & np.isfinite(volume) & (volume != 0.0)
    preferred[decides] = volume[decides]
    wrong = np.where(preferred[part] < 0.0, ~is_turned, is_turned)
    mixed = np.bincount(part, is_turned, 2 * count)[part] > 0.0
    one_sided = as_it_is == turned
    return TurnedFaces(np.flatnonzero(wrong & mixed & ~one_sided), bool(one_sided.any()), bool((counts == 2).all()))
