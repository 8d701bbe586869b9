"""Checks for `pvphong.diagnose`, on plain arrays: faces, edges, duplicates, and the model matrix."""

from __future__ import annotations

import math
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pvphong.base import threads
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray, MatrixLike, Vector
from pvphong.geometry.fit import Areas
from pvphong.geometry.normals import FaceBlock, Faces
from pvphong.geometry.transform import affine_matrix, common_integers

# The normal of a face is uncertain if rounding of the corners may turn it by more than this angle, in radians. By
# Lambert's law, this may change a colour by one of 255 steps.
_UNCERTAIN = 1 / 255

# A determinant may be a rounding error if it is at most 2**-50 of the sum of its terms' magnitudes: each term has 3
# roundings of 2**-53, and there is a margin.
_ROUNDING_BITS = 50

# Edges per range of a thread: their arrays stay in its caches.
_AT_ONCE = 2**16


class FaceChecks(NamedTuple):
    """Result of `check_faces`: indices of the faces with each kind of fault, in ascending order.

    Parameters
    ----------
    degenerate : ndarray
        Faces without an area, or with a repeated corner.
    far : ndarray
        Faces whose normal is uncertain because coordinates are rounded. At the origin, the normal would be certain.
    thin : ndarray
        Faces whose normal would be uncertain even at the origin.
    folded : ndarray
        Faces with fewer than three corners. Also faces with a repeated corner that have no area, or have a point that
        is not finite. The edges of folded faces contain no information about neighbours.
    areas : ndarray
        Areas of all faces, in a unit that avoids overflow.
    offset : tuple of 3 floats or None
        The middle of the mesh, rounded to the fewest decimals that resolve a tenth of the mesh's size. None if no face
        is far, or if some faces would still be far after subtracting it.
    """

    degenerate: IntArray
    far: IntArray
    thin: IntArray
    folded: IntArray
    areas: Float64Array
    offset: Vector | None


def check_faces(points: FloatArray, faces: Faces) -> FaceChecks:
    """Find faces without an area, and faces with an uncertain normal. Skip faces with a point that is not finite.

    Rounding of the coordinates may turn a normal by step · magnitude / height radians. The step is the relative spacing
    of the coordinates' float type. The magnitude is the face's largest absolute coordinate. The height is measured from
    the face's longest edge.
    """
    finite, wide = finite_rows(points), points.astype(np.float64)
    all_finite = bool(finite.all())
    used = wide if all_finite else wide[finite]
    low, high = np.array([[column.min(), column.max()] for column in used.T]).T if len(used) else np.zeros((2, 3))
    with np.errstate(all="ignore"):
        middle, size = low / 2 + high / 2, math.hypot(*(high - low))
        typical = size / math.sqrt(max(faces.count, 1))  # typical size of a face, used for collapsed faces
    step = float(np.finfo(points.dtype).eps)
    # A face at least this high is not blurred: no edge, and no distance from the middle, is 4 times the largest number.
    certain = 4.0 * step * float(np.maximum(high, -low).max()) / _UNCERTAIN

    small = np.flatnonzero(faces.sizes < 3)
    degenerate, far, thin, folded, centred_too = [small], list[IntArray](), list[IntArray](), [small], list[IntArray]()
    areas = Areas(faces)

    def look(block: FaceBlock) -> None:
        with np.errstate(all="ignore"):  # errstate is local to the thread
            vectors = block.area_vectors()
            twice = np.sqrt(np.square(vectors).sum(axis=0))
            areas.put(block, twice / 2.0)
            usable = np.ones(len(twice), bool) if all_finite else finite[block.corners.T].all(axis=0)
            flat = ~(vectors[0].astype(bool) | vectors[1].astype(bool) | vectors[2].astype(bool))
            repeated = _has_twice(block.corners)
            degenerate.append(block.faces[usable & (flat | repeated)])
            folded.append(block.faces[(flat | ~usable) & repeated])

            longest = np.sqrt(np.square(block.edges).sum(axis=0).max(axis=0))
            # The height is twice the area divided by the longest edge, in units of 2**exponents.
            height = twice / longest
            some = np.flatnonzero(~(np.ldexp(height, block.exponents) > certain))
            height, longest, exponents = height[some], longest[some], block.exponents[some]
            collapsed = ~(height > 0)
            height[collapsed] = np.ldexp(typical, -exponents[collapsed])
            corners = wide[block.corners[some]]
            as_it_lies, about_the_middle = (
                np.ldexp(np.abs(corners - origin).max(axis=(1, 2)), -exponents) for origin in (0.0, middle)
            )
            # True if rounding makes the normal uncertain: for the face at its position, for coordinates relative to the
            # mesh's middle, and for coordinates relative to the face.
            here, centred, own = (
                np.where(magnitude > 0, step * magnitude / height, 0.0) > _UNCERTAIN
                for magnitude in (as_it_lies, about_the_middle, longest)
            )
            whole = (usable & ~repeated)[some]
            is_far = whole & here & ~own
            centred_too.append(block.faces[some[is_far & centred]])
            far.append(block.faces[some[is_far]])
            thin.append(block.faces[some[whole & ~flat[some] & own]])

    faces.in_blocks(look)
    nothing = np.empty(0, np.intp)
    all_degenerate, all_far, all_thin, all_folded = (
        np.sort(np.concatenate([nothing, *parts])) for parts in (degenerate, far, thin, folded)
    )
    offset = None
    if len(all_far) and not any(map(len, centred_too)):
        with np.errstate(over="ignore"):
            edge = float((high - low).max())
        if 0 < edge < math.inf:
            digits = math.ceil(1 - math.log10(edge))
            middle = np.array([round(value, digits) for value in middle.tolist()])
        x, y, z = middle.tolist()
        offset = x, y, z
    return FaceChecks(all_degenerate, all_far, all_thin, all_folded, areas.in_one_unit, offset)


def finite_rows(points: NDArray[Any]) -> BoolArray:
    """Return a mask of the rows of an array (n, 3) that have no NaN and no infinity, shape (n,)."""
    finite = np.isfinite(points)
    rows: BoolArray = finite[:, 0] & finite[:, 1] & finite[:, 2]  # three times as fast as all(axis=1)
    return rows


def nonzero_rows(vectors: FloatArray) -> BoolArray:
    """Return a mask of the rows of an array (n, 3) that have an entry other than 0, shape (n,)."""
    x, y, z = vectors.T != 0.0
    return np.asarray(x | y | z)


def _has_twice(corners: IntArray) -> BoolArray:
    """Return a mask of the faces that have a corner twice, shape (m,).

    `corners` has the point indices of m faces with k corners, shape (m, k).
    """
    if corners.shape[1] == 3:
        a, b, c = corners.T
        return np.asarray((a == b) | (b == c) | (a == c))
    ordered = np.sort(corners, axis=1)
    return np.asarray((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))


def first_alike(rows: NDArray[Any]) -> IntArray:
    """Return the lowest index of an equal row, for each row of a two-dimensional array. A NaN equals nothing.

    Rows are sorted by a hash, which takes a fifth of the time of sorting by all entries. If different rows share a
    hash, all rows are sorted by their entries instead.
    """
    numbers = _hashes(rows)
    order = np.argsort(numbers)
    shared = numbers[order[1:]] == numbers[order[:-1]]
    first = np.arange(len(rows))
    if not shared.any():
        return first
    is_new = np.ones(len(rows), dtype=bool)
    is_new[1:] = (rows[order[1:]] != rows[order[:-1]]).any(axis=1)
    if (shared & is_new[1:]).any():  # a collision, or a NaN
        order = np.lexsort(rows.T)
        is_new[1:] = (rows[order[1:]] != rows[order[:-1]]).any(axis=1)
    starts = np.flatnonzero(is_new)
    first[order] = np.repeat(np.minimum.reduceat(order, starts), np.diff(starts, append=len(rows)))
    return first


def _hashes(rows: NDArray[Any]) -> NDArray[np.uint64]:
    """Return a hash of each row of a two-dimensional array, shape (n,); the entries 0 and −0 have the same hash.

    Method: the finaliser of S. Vigna's splitmix64.
    """
    result = np.zeros(len(rows), np.uint64)
    for column in rows.T:
        wide = column.astype(np.float64 if rows.dtype.kind == "f" else np.int64)
        result += (wide + 0).view(np.uint64)
        for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
            result ^= result >> np.uint64(shift)
            result *= np.uint64(factor)
        result ^= result >> np.uint64(31)
    return result


def repeated_faces(faces: Faces, edges: Edges, weightless: IntArray) -> IntArray:
    """Return the faces that repeat a face with a lower index, in ascending order.

    Two faces are the same if they have the same points in the same cyclic order.

    Parameters
    ----------
    faces : Faces
        All faces.
    edges : Edges
        Their edges.
    weightless : ndarray
        Indices of faces without weight in normals. They are skipped, because repeating them has no effect.
    """
    if (edges.forth < 2).all():  # repeated faces run forth along an edge twice
        return np.empty(0, dtype=np.intp)
    sizes = faces.sizes.copy()
    sizes[weightless] = 0
    found = [np.empty(0, dtype=np.intp)]
    for size in np.unique(sizes[sizes >= 3]).tolist():
        alike = np.flatnonzero(sizes == size)
        if faces.are_triangles:
            corners = faces.connectivity.reshape(-1, 3)
            corners = corners if len(alike) == faces.count else corners[alike]
        else:
            corners = faces.connectivity[faces.offsets[alike][:, None] + np.arange(size)]
        first = first_alike(_from_their_lowest(corners))
        found.append(alike[first != np.arange(len(alike))])
    return np.sort(np.concatenate(found))


def _from_their_lowest(corners: IntArray) -> IntArray:
    """Return the corners of faces, shape (m, k), rotated so that each face begins with its lowest point index."""
    if corners.shape[1] == 3:
        a, b, c = corners.T
        at_b, at_c = (b < a) & (b <= c), (c < a) & (c < b)
        turned = [np.where(at_b, y, np.where(at_c, z, x)) for x, y, z in ((a, b, c), (b, c, a), (c, a, b))]
        return np.stack(turned, axis=1)
    size = corners.shape[1]
    turns = (corners.argmin(axis=1)[:, None] + np.arange(size)) % size
    return np.take_along_axis(corners, turns, axis=1)


def edges_of(faces: Faces) -> tuple[IntArray, IntArray]:
    """Return the points at which the edges of all faces begin and end, shape (m,) each.

    A face of n corners has n edges in the result, even if it shares them with other faces.
    """
    begin = faces.connectivity
    if faces.are_triangles:
        end = np.roll(begin.reshape(-1, 3), -1, axis=1).ravel()
        return begin, end
    end = np.empty_like(begin)
    end[:-1] = begin[1:]
    some = faces.sizes > 0
    end[faces.offsets[1:][some] - 1] = begin[faces.offsets[:-1][some]]
    return begin, end


def owners_of(faces: Faces) -> IntArray:
    """Return the index of the face to which each edge from `edges_of` belongs, shape (m,)."""
    return np.repeat(np.arange(faces.count), faces.sizes)


class Edges(NamedTuple):
    """Unique edges of a mesh, with the number of faces that run along them in each direction."""

    lower: IntArray
    """Lower index of an edge's two points, shape (m,). `higher` has the higher index."""
    higher: IntArray
    forth: IntArray
    """Number of faces that run along the edge from the lower to the higher point, shape (m,). `back` counts the faces
    in the opposite direction."""
    back: IntArray

    @classmethod
    def between(cls, begin: IntArray, end: IntArray, n_points: int) -> Edges:
        """Return the unique edges of a mesh.

        `begin` and `end` are the ends of all faces' edges, from `edges_of`. An edge from a point to itself is left out.
        `n_points` is the number of the mesh's points.
        """
        # Encode each edge of a face as an integer: its lower point, its higher point, its direction.
        bits, keys = n_points.bit_length(), np.empty(len(begin), np.int64)

        def put(first: int, last: int) -> None:
            one, other, key = begin[first:last], end[first:last], keys[first:last]
            key[:] = np.minimum(one, other)
            key <<= bits
            key |= np.maximum(one, other)
            key <<= 1
            key |= one < other
            key[one == other] = -1

        threads.run(put, len(keys), _AT_ONCE)
        # Each thread takes the edges of a range of lower points, sorts them, and counts them piece by piece.
        count = threads.count() if len(keys) > _AT_ONCE else 1
        limits = [part * n_points // count << bits + 1 for part in range(count + 1)]
        found: list[list[Edges]] = [[]] * count

        def look(part: int, _: int) -> None:
            blocks = np.split(keys, range(_AT_ONCE, len(keys), _AT_ONCE))
            some = np.concatenate([each[(each >= limits[part]) & (each < limits[part + 1])] for each in blocks])
            some.sort()
            pieces, first = [cls._counted(some[:0], bits)], 0
            while first < len(some):
                last = int(np.searchsorted(some, some[first : first + _AT_ONCE][-1] | 1, side="right"))
                pieces.append(cls._counted(some[first:last], bits))
                first = last
            found[part] = pieces

        threads.run(look, count, 1)
        return cls(*map(np.concatenate, zip(*chain(*found), strict=True)))

    @classmethod
    def _counted(cls, keys: NDArray[np.int64], bits: int) -> Edges:
        """Return the unique edges among sorted keys of faces' edges. Each key has indices of `bits` bits."""
        undirected = keys >> 1
        is_first = np.ones(len(keys), bool)
        np.not_equal(undirected[1:], undirected[:-1], out=is_first[1:])
        starts = np.flatnonzero(is_first)
        once = undirected[starts]
        forth = np.add.reduceat(keys & 1, starts) if len(starts) else starts
        back = np.diff(starts, append=len(keys)) - forth
        return cls(once >> bits, once & ((1 << bits) - 1), forth, back)

    def ends(self, some: BoolArray) -> IntArray:
        """Return the two points of each edge for which the mask `some` is True, shape (k, 2), the lower index first."""
        return np.stack([self.lower[some], self.higher[some]], axis=1)


def check_edges(faces: Faces, whole: Edges, folded: IntArray, repeated: IntArray) -> tuple[IntArray, IntArray]:
    """Find the edges with more than two faces, and the edges whose two faces have opposite fronts.

    Two neighbours with the same orientation run along their common edge in opposite directions. A repeated face counts
    as a further face of its edges, but is not compared with its original.

    Parameters
    ----------
    faces : Faces
        All faces.
    whole : Edges
        Edges of all faces.
    folded : ndarray
        Indices of faces that are skipped.
    repeated : ndarray
        Indices of faces that repeat an earlier face.

    Returns
    -------
    non_manifold, inconsistent : ndarray
        Points of the edges, shape (m, 2), the lower index first.
    """

    def without(some: IntArray) -> Edges:
        if not len(some):
            return whole
        (begin, end), owner = edges_of(faces), owners_of(faces)
        counted = np.ones(faces.count, dtype=bool)
        counted[some] = False
        return Edges.between(begin[counted[owner]], end[counted[owner]], faces.n_points)

    edges = without(folded)
    non_manifold = edges.ends(edges.forth + edges.back > 2)
    if len(repeated):
        edges = without(np.concatenate([folded, repeated]))
    return non_manifold, edges.ends((edges.forth + edges.back == 2) & (edges.forth != 1))


def check_matrix(matrix: MatrixLike) -> tuple[bool, bool, bool]:
    """Check a model matrix in exact arithmetic.

    A matrix is nearly singular if its determinant would be zero without the rounding of its entries. An example is the
    rounded product of a rotation and a matrix that flattens. A matrix that only scales by a small factor is not nearly
    singular.

    Returns
    -------
    singular, nearly_singular, mirrors : bool
        True if the matrix has the property.

    Raises
    ------
    ValueError
        If `matrix` is not a finite affine 4x4 matrix.
    """
    values = affine_matrix(matrix)
    a, b, c, d, e, f, g, h, i = common_integers(values[:3, :3].ravel().tolist())
    terms = (a * e * i, b * f * g, c * d * h, -a * f * h, -b * d * i, -c * e * g)
    determinant = sum(terms)
    rounded = abs(determinant) << _ROUNDING_BITS <= sum(map(abs, terms))
    mirrors = not rounded and (determinant > 0) != bool(values[3, 3] > 0)
    return determinant == 0, rounded and determinant != 0, mirrors
