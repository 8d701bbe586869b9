"""The checks behind `pvphong.diagnose`, on plain arrays: faces, edges, duplicates, and the model matrix."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray, MatrixLike, Vector
from pvphong.geometry.normals import Faces
from pvphong.geometry.transform import affine_matrix, common_integers

# A normal is uncertain where the rounding of its corners may turn it further (radians): by Lambert's law
# that may change a colour by one of 255 steps.
_UNCERTAIN = 1 / 255

# A determinant 2**-50 of its terms or less may be rounding alone: 3 roundings of 2**-53 in each, and some more.
_ROUNDING_BITS = 50


class FaceChecks(NamedTuple):
    """Which faces light badly, in rising order.

    Parameters
    ----------
    degenerate : ndarray
        Without an area, or with a corner that comes twice.
    far : ndarray
        The coordinates' rounding blurs the normal, and would not if the face lay at the origin.
    thin : ndarray
        The coordinates' rounding blurs the normal wherever the face lies.
    folded : ndarray
        Without an area and with a corner that comes twice: its edges say nothing about its neighbours.
    offset : tuple of 3 floats or None
        The middle of the mesh, as few digits as keep it within a tenth of the mesh's size, where no face would be far
        if that lay at the origin; None where no face is far, or some would still be.
    """

    degenerate: IntArray
    far: IntArray
    thin: IntArray
    folded: IntArray
    offset: Vector | None


def check_faces(points: FloatArray, faces: Faces) -> FaceChecks:
    """Look at every face by itself; those with a point that is not finite are passed over.

    The rounding of coordinates may turn a normal by step · magnitude / height radians: the relative spacing of the
    coordinates' float type, the face's largest coordinate, and its height over its longest edge.
    """
    finite, wide = finite_rows(points), points.astype(np.float64)
    used = wide[finite]
    low, high = (used.min(axis=0), used.max(axis=0)) if len(used) else (np.zeros(3), np.zeros(3))
    with np.errstate(all="ignore"):
        middle, size = low / 2 + high / 2, math.hypot(*(high - low))
        typical = size / math.sqrt(max(faces.count, 1))  # size of a face, for those that have collapsed
        magnitudes = _largest(wide), _largest(wide - middle)
    step = float(np.finfo(points.dtype).eps)

    small = np.flatnonzero(faces.sizes < 3)
    degenerate, far, thin, folded, one_offset_helps = [small], [], [], [small], True
    with np.errstate(all="ignore"):
        for block in faces.blocks():
            areas = block.area_vectors()
            usable = finite[block.corners.T].all(axis=0)
            flat = ~areas.any(axis=0)
            corners = np.sort(block.corners, axis=1)
            repeated = (corners[:, 1:] == corners[:, :-1]).any(axis=1)
            degenerate.append(block.faces[usable & (flat | repeated)])
            folded.append(block.faces[(flat | ~usable) & repeated])

            longest = np.sqrt(np.square(block.edges).sum(axis=0).max(axis=0))
            # Twice the area over the base, in units of 2**exponents.
            height = np.sqrt(np.square(areas).sum(axis=0)) / longest
            collapsed = ~(height > 0)
            height[collapsed] = np.ldexp(typical, -block.exponents[collapsed])
            as_it_lies, about_the_middle = (
                np.ldexp(magnitude[block.corners.T].max(axis=0), -block.exponents) for magnitude in magnitudes
            )
            # Whether rounding blurs the normal: where it lies, about the middle of the mesh, and about its own.
            here, centred, own = (
                np.where(magnitude > 0, step * magnitude / height, 0.0) > _UNCERTAIN
                for magnitude in (as_it_lies, about_the_middle, longest)
            )
            usable &= ~repeated
            is_far = usable & here & ~own
            one_offset_helps &= not (is_far & centred).any()
            far.append(block.faces[is_far])
            thin.append(block.faces[usable & ~flat & own])

    nothing = np.empty(0, np.intp)
    all_degenerate, all_far, all_thin, all_folded = (
        np.sort(np.concatenate([nothing, *parts])) for parts in (degenerate, far, thin, folded)
    )
    offset = None
    if len(all_far) and one_offset_helps:
        with np.errstate(over="ignore"):
            edge = float((high - low).max())
        if 0 < edge < math.inf:
            digits = math.ceil(1 - math.log10(edge))
            middle = np.array([round(value, digits) for value in middle.tolist()])
        x, y, z = middle.tolist()
        offset = x, y, z
    return FaceChecks(all_degenerate, all_far, all_thin, all_folded, offset)


def finite_rows(points: NDArray[Any]) -> BoolArray:
    """Which rows have no NaN and no infinity."""
    finite = np.isfinite(points)
    rows: BoolArray = finite[:, 0] & finite[:, 1] & finite[:, 2]  # three times as fast as all(axis=1)
    return rows


def _largest(points: Float64Array) -> Float64Array:
    """The largest magnitude in each row."""
    sizes = np.abs(points)
    rows: Float64Array = np.maximum(np.maximum(sizes[:, 0], sizes[:, 1]), sizes[:, 2])
    return rows


def first_alike(rows: NDArray[Any]) -> IntArray:
    """For each row the lowest index of one that equals it; a NaN equals nothing."""
    order = np.lexsort(rows.T)  # stable: equal rows stay in the order of their indices
    is_new = np.ones(len(rows), dtype=bool)
    is_new[1:] = (rows[order[1:]] != rows[order[:-1]]).any(axis=1)
    first = np.empty(len(rows), dtype=np.intp)
    first[order] = order[is_new][np.cumsum(is_new) - 1]
    return first


def repeated_faces(faces: Faces, weightless: IntArray) -> IntArray:
    """Faces that go round the same points in the same order as one with a lower index, in rising order.

    The weightless ones are passed over: they count for nothing, however often they come.
    """
    sizes = faces.sizes.copy()
    sizes[weightless] = 0
    found = [np.empty(0, dtype=np.intp)]
    for size in np.unique(sizes[sizes >= 3]).tolist():
        alike = np.flatnonzero(sizes == size)
        corners = faces.connectivity[faces.offsets[alike][:, None] + np.arange(size)]
        turns = (corners.argmin(axis=1)[:, None] + np.arange(size)) % size  # so that each begins with its lowest point
        first = first_alike(np.take_along_axis(corners, turns, axis=1))
        found.append(alike[first != np.arange(len(alike))])
    return np.sort(np.concatenate(found))


def edges_of(faces: Faces) -> tuple[IntArray, IntArray, IntArray]:
    """Where each edge of each face begins and ends, and the face's number; a face of n corners has n edges."""
    begin = faces.connectivity
    end = np.empty_like(begin)
    end[:-1] = begin[1:]
    some = faces.sizes > 0
    end[faces.offsets[1:][some] - 1] = begin[faces.offsets[:-1][some]]
    return begin, end, np.repeat(np.arange(faces.count), faces.sizes)


def check_edges(faces: Faces, folded: IntArray, repeated: IntArray) -> tuple[IntArray, IntArray]:
    """Edges with more than two faces, and edges whose two faces disagree about their front.

    Two neighbours with the same orientation run along their common edge in opposite directions. A face that is
    repeated counts as one more at its edges, but does not disagree with itself.

    Returns
    -------
    non_manifold, inconsistent : ndarray
        (m, 2) point indices, the lower first.
    """
    begin, end, owner = edges_of(faces)
    # One integer for each edge of each face: its lower point, its higher point, its direction.
    directed = (np.minimum(begin, end) * faces.n_points + np.maximum(begin, end)) * 2 + (begin < end)

    def irregular(without: IntArray) -> tuple[IntArray, IntArray]:
        counted = np.ones(faces.count, dtype=bool)
        counted[without] = False
        keys = np.sort(directed[(begin != end) & counted[owner]])
        undirected = keys >> 1
        starts = np.flatnonzero(np.diff(undirected, prepend=-1))
        counts = np.diff(starts, append=len(keys))
        pairs = starts[counts == 2]
        disagree = keys[pairs] == keys[pairs + 1]
        many, inconsistent = (
            np.stack(np.divmod(undirected[some], max(faces.n_points, 1)), axis=1)
            for some in (starts[counts > 2], pairs[disagree])
        )
        return many, inconsistent

    non_manifold, inconsistent = irregular(folded)
    if len(repeated):
        _, inconsistent = irregular(np.concatenate([folded, repeated]))
    return non_manifold, inconsistent


def check_matrix(matrix: MatrixLike) -> tuple[bool, bool, bool]:
    """Whether a model matrix is singular, or nearly so, and whether it mirrors; decided in exact arithmetic.

    It counts as nearly singular where its determinant is no larger than what the rounding of its entries leaves
    of a zero: a flattening that was multiplied with a rotation is found, a small scale is not blamed.

    Raises
    ------
    ValueError
        If it is no finite affine 4x4 matrix.
    """
    values = affine_matrix(matrix)
    a, b, c, d, e, f, g, h, i = common_integers(values[:3, :3].ravel().tolist())
    terms = (a * e * i, b * f * g, c * d * h, -a * f * h, -b * d * i, -c * e * g)
    determinant = sum(terms)
    rounded = abs(determinant) << _ROUNDING_BITS <= sum(map(abs, terms))
    mirrors = not rounded and (determinant > 0) != bool(values[3, 3] > 0)
    return determinant == 0, rounded and determinant != 0, mirrors
