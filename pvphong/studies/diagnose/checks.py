"""The measurements behind `pvphong.diagnose`, on plain arrays."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pvphong.base import check
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray, MatrixLike, Vector
from pvphong.geometry.normals import FaceBlock, Faces
from pvphong.geometry.transform import common_integers, transform_points

# A normal is uncertain where the rounding of its corners may turn it further (radians): by Lambert's law
# that may change a colour by one of 255 steps.
_UNCERTAIN = 1 / 255

# A determinant 2**-50 of its terms or less may be rounding alone: 3 roundings of 2**-53 in each, and some more.
_ROUNDING_BITS = 50


@dataclass(frozen=True)
class FaceChecks:
    """Which faces light badly, in rising order.

    Attributes
    ----------
    degenerate : ndarray
        Without an area, or with a corner that comes twice.
    far : ndarray
        The coordinates' rounding blurs the normal, and would not if the face lay at the origin.
    thin : ndarray
        The coordinates' rounding blurs the normal wherever the face lies.
    folded : ndarray
        Without an area and with a corner that comes twice: its edges say nothing about its neighbours.
    one_offset_helps : bool
        Whether no face would be far if the middle of the mesh lay at the origin.
    """

    degenerate: IntArray
    far: IntArray
    thin: IntArray
    folded: IntArray
    one_offset_helps: bool


@dataclass(frozen=True)
class _Blur:
    """How far the rounding of coordinates may turn the normals of faces: step · magnitude / height."""

    step: float  # relative spacing of the coordinates' float type
    here: Float64Array  # (n,) largest magnitude of each point's coordinates
    centred: Float64Array  # the same about the middle of the mesh
    extent: float  # a typical face's size, for faces that have collapsed

    def of(self, block: FaceBlock, areas: Float64Array) -> tuple[Float64Array, Float64Array, Float64Array]:
        """Radians for the faces of a block: as they lie, about the middle of the mesh, and about their own."""
        longest = np.sqrt(_squares(block.edges).max(axis=0))
        height = np.sqrt(_squares(areas)) / longest  # twice the area over the base, in units of 2**exponents
        collapsed = ~(height > 0)
        height[collapsed] = np.ldexp(self.extent, -block.exponents[collapsed])
        here, centred = (
            np.ldexp(magnitudes[block.corners.T].max(axis=0), -block.exponents)
            for magnitudes in (self.here, self.centred)
        )
        return self._angle(here, height), self._angle(centred, height), self._angle(longest, height)

    def _angle(self, magnitude: Float64Array, height: Float64Array) -> Float64Array:
        return np.where(magnitude > 0, self.step * magnitude / height, 0.0)


def check_faces(points: FloatArray, faces: Faces) -> FaceChecks:
    """Look at every face by itself; those with a point that is not finite are passed over."""
    finite = finite_rows(points)
    blur = _blur(points, finite, faces.count)
    small = np.flatnonzero(np.diff(faces.offsets) < 3)
    degenerate, far, thin, folded, one_offset_helps = [small], [], [], [small], True
    with np.errstate(all="ignore"):
        for block in faces.blocks():
            areas = block.area_vectors()
            usable = finite[block.corners.T].all(axis=0)
            flat = ~areas.any(axis=0)
            corners = np.sort(block.corners, axis=1)
            repeated = (corners[:, 1:] == corners[:, :-1]).any(axis=1)
            here, centred, own = blur.of(block, areas)
            degenerate.append(block.faces[usable & (flat | repeated)])
            folded.append(block.faces[(flat | ~usable) & repeated])
            usable &= ~repeated
            is_far = usable & (here > _UNCERTAIN) & (own <= _UNCERTAIN)
            one_offset_helps &= not (is_far & (centred > _UNCERTAIN)).any()
            far.append(block.faces[is_far])
            thin.append(block.faces[usable & ~flat & (own > _UNCERTAIN)])
    return FaceChecks(_joined(degenerate), _joined(far), _joined(thin), _joined(folded), one_offset_helps)


def _joined(parts: list[IntArray]) -> IntArray:
    """Of blocks, in rising order."""
    return np.sort(np.concatenate([np.empty(0, dtype=np.intp), *parts]))


def _blur(points: FloatArray, finite: BoolArray, n_faces: int) -> _Blur:
    step = float(np.finfo(points.dtype).eps)
    wide = points.astype(np.float64)
    low, high = bounds(wide[finite])
    with np.errstate(all="ignore"):
        middle, size = low / 2 + high / 2, math.hypot(*(high - low))
        here, centred = _largest(wide), _largest(wide - middle)
    return _Blur(step, here, centred, size / math.sqrt(max(n_faces, 1)))


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


def bounds(points: FloatArray) -> tuple[Float64Array, Float64Array]:
    """The lowest and the highest coordinates; zeros where there are no points."""
    if not len(points):
        return np.zeros(3), np.zeros(3)
    return points.min(axis=0).astype(np.float64), points.max(axis=0).astype(np.float64)


def offset_to_origin(points: FloatArray) -> Vector:
    """The middle of the finite points, as few digits as keep it within a tenth of the mesh's size."""
    low, high = bounds(points[finite_rows(points)])
    with np.errstate(over="ignore"):
        middle, size = low / 2 + high / 2, float((high - low).max())
    if 0 < size < math.inf:
        digits = math.ceil(1 - math.log10(size))
        middle = np.array([round(value, digits) for value in middle.tolist()])
    x, y, z = middle.tolist()
    return x, y, z


def repeated_faces(faces: Faces, weightless: IntArray) -> IntArray:
    """Faces that go round the same points in the same order as one with a lower index, in rising order.

    The weightless ones are passed over: they count for nothing, however often they come.
    """
    sizes = np.diff(faces.offsets)
    sizes[weightless] = 0
    found = [np.empty(0, dtype=np.intp)]
    for size in np.unique(sizes[sizes >= 3]).tolist():
        alike = np.flatnonzero(sizes == size)
        corners = faces.connectivity[faces.offsets[alike][:, None] + np.arange(size)]
        turns = (corners.argmin(axis=1)[:, None] + np.arange(size)) % size  # so that each begins with its lowest point
        found.append(alike[_repeats(np.take_along_axis(corners, turns, axis=1))])
    return np.sort(np.concatenate(found))


def check_edges(faces: Faces, folded: IntArray, repeated: IntArray) -> tuple[IntArray, IntArray]:
    """Edges with more than two faces, and edges whose two faces disagree about their front.

    Two neighbours with the same orientation run along their common edge in opposite directions. A face that is
    repeated counts as one more at its edges, but does not disagree with itself.

    Returns
    -------
    non_manifold, inconsistent : ndarray
        (m, 2) point indices, the lower first.
    """
    non_manifold, inconsistent = _odd_edges(faces, folded)
    if len(repeated):
        _, inconsistent = _odd_edges(faces, np.concatenate([folded, repeated]))
    return non_manifold, inconsistent


def _odd_edges(faces: Faces, silent: IntArray) -> tuple[IntArray, IntArray]:
    """`check_edges` without some faces."""
    keys = np.sort(_directed_edges(faces, silent))
    undirected = keys >> 1
    starts = np.flatnonzero(np.diff(undirected, prepend=-1))
    counts = np.diff(starts, append=len(keys))
    pairs = starts[counts == 2]
    agree = keys[pairs] != keys[pairs + 1]
    return _ends(undirected[starts[counts > 2]], faces), _ends(undirected[pairs[~agree]], faces)


def _directed_edges(faces: Faces, silent: IntArray) -> NDArray[np.int64]:
    """One integer for each side of each face: its lower point, its higher point, its direction."""
    begin = faces.connectivity.astype(np.int64, copy=False)
    end = np.empty_like(begin)
    end[:-1] = begin[1:]
    sizes = np.diff(faces.offsets)
    some = sizes > 0
    end[faces.offsets[1:][some] - 1] = begin[faces.offsets[:-1][some]]
    real = begin != end
    heard = np.ones(faces.count, dtype=bool)
    heard[silent] = False
    if len(silent):
        real &= np.repeat(heard, sizes)
    low, high = np.minimum(begin, end), np.maximum(begin, end)
    keys: NDArray[np.int64] = (low * faces.n_points + high) * 2 + (begin < end)
    return keys[real]


def _ends(undirected: NDArray[np.int64], faces: Faces) -> IntArray:
    return np.stack(np.divmod(undirected, max(faces.n_points, 1)), axis=1).astype(np.intp, copy=False)


def duplicates(points: FloatArray) -> IntArray:
    """Finite points that lie exactly where a point with a lower index lies, in rising order."""
    finite = np.flatnonzero(finite_rows(points))
    return np.sort(finite[_repeats(points[finite])])


def _repeats(rows: NDArray[Any]) -> IntArray:
    """Rows equal to one with a lower index."""
    order = np.lexsort(rows.T)  # stable: equal rows stay in the order of their indices
    same = (rows[order[1:]] == rows[order[:-1]]).all(axis=1)
    return order[1:][same]


def check_matrix(matrix: MatrixLike) -> tuple[bool, bool, bool]:
    """Whether a model matrix is singular, or nearly so, and whether it mirrors; decided in exact arithmetic.

    It counts as nearly singular where its determinant is no larger than what the rounding of its entries leaves
    of a zero: a flattening that was multiplied with a rotation is found, a small scale is not blamed.

    Raises
    ------
    ValueError
        If it is no finite affine 4x4 matrix.
    """
    transform_points(np.empty((0, 3)), matrix)  # refuses what is no model matrix
    values = check.matrix4("matrix", matrix)
    a, b, c, d, e, f, g, h, i = common_integers(values[:3, :3].ravel().tolist())
    terms = (a * e * i, b * f * g, c * d * h, -a * f * h, -b * d * i, -c * e * g)
    determinant = sum(terms)
    rounded = abs(determinant) << _ROUNDING_BITS <= sum(map(abs, terms))
    mirrors = not rounded and (determinant > 0) != bool(values[3, 3] > 0)
    return determinant == 0, rounded and determinant != 0, mirrors


def _squares(vectors: Float64Array) -> Float64Array:
    return vectors[0] * vectors[0] + vectors[1] * vectors[1] + vectors[2] * vectors[2]
