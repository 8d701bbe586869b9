"""Reversed faces, found by comparison with their neighbours."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.geometry.normals import Faces
from pvphong.studies.diagnose.checks import edges_of, owners_of
from pvphong.studies.diagnose.shells import connected, fan


class TurnedFaces(NamedTuple):
    """Faces to turn so that neighbours agree about their front.

    Attributes
    ----------
    faces : ndarray
        Indices of the faces.
    is_one_sided : bool
        True if a part cannot be oriented, like a Möbius strip.
    is_closed : bool
        True if each edge belongs to exactly two faces.
    """

    faces: IntArray
    is_one_sided: bool
    is_closed: bool


def turned_faces(points: FloatArray, faces: Faces, areas: Float64Array, weightless: IntArray) -> TurnedFaces:
    """Return the faces that are reversed, compared with their neighbours.

    Two faces are neighbours if they share an edge that has no third face. The faces of a connected part can be oriented
    consistently in two ways. For a closed part, the right way is the one with outward fronts. For an open part, the
    right way is the one that turns the smaller area. Faces that must be turned to get the right way are reversed.

    Parameters
    ----------
    points : ndarray
        Shape (n, 3).
    faces : Faces
        All faces with valid indices.
    areas : ndarray
        Shape (n_faces,): areas of the faces.
    weightless : ndarray
        Faces that are skipped.
    """
    (begin, end), owner = edges_of(faces), owners_of(faces)
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

    # In a graph, each face has two nodes: as it is, and turned. Neighbours that agree connect nodes of the same kind,
    # other neighbours connect nodes of opposite kinds.
    count = faces.count
    other, other_turned = np.where(agree, two, two + count), np.where(agree, two + count, two)
    labels = connected(2 * count, np.concatenate([one, one + count]), np.concatenate([other, other_turned]))
    as_it_is, turned = labels[:count], labels[count:]
    part, is_turned = np.minimum(as_it_is, turned), as_it_is > turned

    # Per part, positive if this orientation is right: the area of the faces that are kept minus the area of the turned
    # faces, or the volume of a closed part.
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
