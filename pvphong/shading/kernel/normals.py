"""Normals of a mesh's points, `pvphong.geometry.normals.point_normals`, compiled.

Each call of `find_normals` computes the points of one range. It skips faces without a point in the range, and adds the
other faces in their order in the mesh. So a point's bits depend neither on the ranges nor on the threads, and no two
threads write to the same element. Faces with the same number of corners form blocks. A block's values are in rows,
corner after corner, so that loops over them vectorise. `point_normals` distributes ranges of points over threads.

Faces with a point that is not finite have no weight. In two rare cases, the code declines the whole mesh, and NumPy
computes it. In the first, the square of an edge or area leaves the range of floats in every unit of length. In the
second, a face has very many corners.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, Self, get_args

import numpy as np
from numba import types
from numpy.typing import NDArray

from pvphong.base import threads
from pvphong.base.formulas import arctan2, dot
from pvphong.base.types import Float64Array, FloatArray, Weighting
from pvphong.geometry.normals import LEAST_SPAN, MOST_SPAN, NOISE_OF_AREA, NOISE_OF_SUM
from pvphong.shading.kernel import code
from pvphong.shading.kernel.arithmetic import compiled, inlined
from pvphong.shading.kernel.code import Library, NotCompiled
from pvphong.shading.kernel.evaluation import address, as_contiguous

# Number of corners in a block, and so the largest number of a face's corners.
CORNERS = 384

# Largest number of faces in a block.
FACES = CORNERS // 3

# Rows of corners: points, edges from each to the next, weights.
PX, PY, PZ, EX, EY, EZ, WEIGHT, _END = range(0, 8 * CORNERS, CORNERS)

# Rows of faces: vectors of twice the area, later unit normals; the sums of their terms' magnitudes; the vectors'
# lengths; 1, or 0 for a face without a normal. ROWS is the length of all rows.
NX, NY, NZ, TX, TY, TZ, AREA, HAS_NORMAL, ROWS = range(_END, _END + 9 * FACES, FACES)

# Number of faces in a chunk, whose least and greatest index are known.
CHUNK = 4096

# Number of sums of a point: x, y, z, and the weights' magnitudes.
SUMS = 4

# The weightings; compiled code gets an index.
WEIGHTINGS = get_args(Weighting)
_BY_ANGLE, _BY_AREA = map(WEIGHTINGS.index, ("angle", "area"))

# Exponents of the largest coordinate, between −_LARGE and _LARGE, for which a mesh is not scaled.
_LARGE = 50
_LEAST_SQUARE, _MOST_SQUARE = 2.0**-900, 2.0**900
_LEAST_PRODUCT = float(np.finfo(np.float64).tiny)


# --- least and greatest point of faces


def survey(connectivity: Any, offsets: Any, first: int, last: int, corners: int, found: Any) -> bool:
    """Find the least and greatest point index in each chunk of faces.

    Parameters
    ----------
    connectivity, offsets
        Point indices of all faces, and the index in this array at which each face begins.
    first, last : int
        Numbers of the first face, a multiple of `CHUNK`, and of the face after the last.
    corners : int
        Length of the connectivity.
    found
        Output: two numbers for each chunk, the least and the greatest index; 0 and −1 in a chunk without an index.

    Returns
    -------
    bool
        True if the offsets ascend and are at most `corners`, and every face fits in a block.
    """
    for chunk in range(first // CHUNK, (last + CHUNK - 1) // CHUNK):
        begin, stop = chunk * CHUNK, min((chunk + 1) * CHUNK, last)
        good = (offsets[begin] >= 0) & (offsets[begin] <= offsets[stop]) & (offsets[stop] <= corners)
        for face in range(begin, stop):
            size = offsets[face + 1] - offsets[face]
            good = good & (size >= 0) & (size <= CORNERS)
        if not good:
            return False
        low, high = np.int64(0), np.int64(-1)
        if offsets[stop] > offsets[begin]:
            low = high = connectivity[offsets[begin]]
        for place in range(offsets[begin], offsets[stop]):
            low, high = min(low, connectivity[place]), max(high, connectivity[place])
        found[2 * chunk], found[2 * chunk + 1] = low, high
    return True


# --- sums over faces


@inlined
def _corner(rows: Any, start: int, k: int) -> tuple[float, float, float]:
    """Return the k-th vector of the three consecutive rows x, y and z, which begin at offset `start`."""
    return rows[start + k], rows[start + CORNERS + k], rows[start + 2 * CORNERS + k]


@inlined
def _cross(a: tuple[float, float, float], b: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return the cross product a × b, with every product rounded as in NumPy."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def _is_usable(span: float) -> bool:
    """Return True if the squares of a face's edges are in range. `span` is the largest coordinate of an edge vector."""
    return (span == 0.0) | ((span >= LEAST_SPAN) & (span <= MOST_SPAN))


@compiled
def _add_faces(
    points: Any,
    corners: Any,
    starts: Any,
    count: int,
    size: int,
    weighting: int,
    rows: Any,
    first: int,
    last: int,
    sums: Any,
) -> bool:
    """Add a block of faces with the same number of corners to the sums at their points.

    Return False to decline the mesh.

    Parameters
    ----------
    points, corners
        Coordinates of all points, and connectivity of all faces.
    starts
        For each face of the block, the index in `corners` at which it begins.
    count, size : int
        Number of faces in the block, and number of corners of each.
    weighting : int
        Index in `WEIGHTINGS`.
    rows
        Scratch memory, of length `ROWS`.
    first, last : int
        Number of the first point whose sums are wanted, and of the point after the last.
    sums
        `SUMS` numbers for each of these points; the faces' weighted normals are added to them.
    """
    for i in range(count):
        for corner in range(size):
            place, to = 3 * corners[starts[i] + corner], corner * count + i
            rows[PX + to] = points[place]
            rows[PY + to] = points[place + 1]
            rows[PZ + to] = points[place + 2]
        rows[TX + i], rows[TY + i] = 0.0, 0.0
    # edges; their largest coordinate is in TX
    for corner in range(size):
        here, after = corner * count, (corner + 1) % size * count
        for i in range(count):
            x = rows[PX + after + i] - rows[PX + here + i]
            y = rows[PY + after + i] - rows[PY + here + i]
            z = rows[PZ + after + i] - rows[PZ + here + i]
            rows[EX + here + i], rows[EY + here + i], rows[EZ + here + i] = x, y, z
            rows[TX + i] = max(rows[TX + i], max(abs(x), max(abs(y), abs(z))))
            rows[TY + i] += (x - x) + (y - y) + (z - z)  # NaN if a coordinate is not finite; `max` may ignore it
    good = True
    for i in range(count):
        good = good & _is_usable(rows[TX + i]) & (rows[TY + i] == 0.0)
    if not good:
        for i in range(count):
            are_finite = True
            for k in range(i, size * count, count):
                x, y, z = _corner(rows, PX, k)
                are_finite = are_finite and math.isfinite(x) and math.isfinite(y) and math.isfinite(z)
            if are_finite and not _is_usable(rows[TX + i]):
                return False
            for k in range(i, size * count, count):
                for row in range(PX, WEIGHT, CORNERS):
                    rows[row + k] = rows[row + k] if are_finite else 0.0  # no edges, no area
    # vectors of twice the areas, and the magnitudes of their terms, as in `FaceBlock.area_vectors`
    for row in range(NX, AREA, FACES):
        for i in range(count):
            rows[row + i] = 0.0
    for corner in range(1, size - 1):
        is_last = corner == size - 2
        spoke, side = corner * count, (size - 1 if is_last else corner) * count
        sign = -1.0 if is_last else 1.0
        for i in range(count):
            ax, bx = rows[PX + spoke + i] - rows[PX + i], sign * rows[EX + side + i]
            ay, by = rows[PY + spoke + i] - rows[PY + i], sign * rows[EY + side + i]
            az, bz = rows[PZ + spoke + i] - rows[PZ + i], sign * rows[EZ + side + i]
            rows[NX + i] += ay * bz - az * by
            rows[NY + i] += az * bx - ax * bz
            rows[NZ + i] += ax * by - ay * bx
            rows[TX + i] += abs(ay * bz) + abs(az * by)
            rows[TY + i] += abs(az * bx) + abs(ax * bz)
            rows[TZ + i] += abs(ax * by) + abs(ay * bx)
    # unit normals of areas larger than rounding errors
    good = True
    for i in range(count):
        x, y, z = rows[NX + i], rows[NY + i], rows[NZ + i]
        is_noise = (
            (abs(x) <= NOISE_OF_AREA * rows[TX + i])
            & (abs(y) <= NOISE_OF_AREA * rows[TY + i])
            & (abs(z) <= NOISE_OF_AREA * rows[TZ + i])
        )
        squared = dot((x, y, z), (x, y, z))
        is_moderate = (squared >= _LEAST_SQUARE) & (squared <= _MOST_SQUARE)
        good = good & (is_noise | is_moderate)
        factor, length = 0.0 if is_noise else 1.0, np.sqrt(squared)
        divisor = length if is_moderate else 1.0
        rows[NX + i], rows[NY + i], rows[NZ + i] = factor * x / divisor, factor * y / divisor, factor * z / divisor
        rows[AREA + i], rows[HAS_NORMAL + i] = factor * length, factor
    if not good:
        return False
    # weights of corners; zero in a face without a normal
    for corner in range(size):
        before, here = (corner + size - 1) % size * count, corner * count
        for i in range(count):
            a, b = _corner(rows, EX, before + i), _corner(rows, EX, here + i)
            c = _cross(a, b)
            sine = np.sqrt(dot(c, c))  # times the two edges' lengths, like the cosine
            if size > 3:  # a reflex corner turns against the face's normal; a triangle has none
                turn = dot(c, (rows[NX + i], rows[NY + i], rows[NZ + i]))
                sine = -sine if turn < 0.0 else sine
            if weighting == _BY_ANGLE:
                cosine = dot(a, b)
                weight = arctan2(sine, -cosine)
                weight = weight + 2.0 * math.pi if weight < 0.0 else weight
                weight = math.pi if (sine == 0.0) & (cosine == 0.0) else weight  # at a doubled point
            elif weighting == _BY_AREA:
                weight = rows[AREA + i]
            else:
                product = dot(a, a) * dot(b, b)
                weight = sine / max(product, _LEAST_PRODUCT) if product >= _LEAST_PRODUCT else 0.0
            rows[WEIGHT + here + i] = weight * rows[HAS_NORMAL + i]
    for i in range(count):
        x, y, z = rows[NX + i], rows[NY + i], rows[NZ + i]
        for corner in range(size):
            point = corners[starts[i] + corner]
            if first <= point < last:
                weight, to = rows[WEIGHT + corner * count + i], SUMS * (point - first)
                sums[to] += weight * x
                sums[to + 1] += weight * y
                sums[to + 2] += weight * z
                sums[to + 3] += abs(weight)
    return True


def find_normals(
    points: Any,
    corners: Any,
    offsets: Any,
    faces: int,
    surveyed: Any,
    weighting: int,
    first: int,
    last: int,
    starts: Any,
    rows: Any,
    sums: Any,
    normals: Any,
) -> bool:
    """Compute the normals of a range of points. Return False if NumPy must compute them.

    Parameters
    ----------
    points
        Coordinates of all points.
    corners, offsets, faces, surveyed
        `FaceArrays.addresses`: connectivity, offsets, number of faces, and least and greatest index in each chunk.
    weighting : int
        Index in `WEIGHTINGS`.
    first, last : int
        Number of the first point, and of the point after the last.
    starts, rows, sums
        Scratch memory. `sums`, of `SUMS` numbers for each point, must contain zeros.
    normals
        Output: a unit vector for each of these points; zero for a point without a normal.
    """
    count, size = 0, 0
    for chunk in range((faces + CHUNK - 1) // CHUNK):
        if surveyed[2 * chunk] >= last or surveyed[2 * chunk + 1] < first:
            continue
        for face in range(chunk * CHUNK, min((chunk + 1) * CHUNK, faces)):
            start, stop = offsets[face], offsets[face + 1]
            touches = False
            for place in range(start, stop):
                touches = touches | ((corners[place] >= first) & (corners[place] < last))
            if stop - start < 3 or not touches:
                continue
            if stop - start != size or (count + 1) * size > CORNERS:
                if not _add_faces(points, corners, starts, count, size, weighting, rows, first, last, sums):
                    return False
                count, size = 0, stop - start
            starts[count] = start
            count += 1
    if not _add_faces(points, corners, starts, count, size, weighting, rows, first, last, sums):
        return False
    for i in range(last - first):  # unit vectors of the sums; zero if rounding errors dominate them
        x, y, z = sums[SUMS * i], sums[SUMS * i + 1], sums[SUMS * i + 2]
        noise = NOISE_OF_SUM * sums[SUMS * i + 3]
        length = 1.0
        if abs(x) <= noise and abs(y) <= noise and abs(z) <= noise:
            x, y, z = 0.0, 0.0, 0.0
        else:
            squared = dot((x, y, z), (x, y, z))
            if not (squared >= _LEAST_SQUARE and squared <= _MOST_SQUARE):
                return False
            length = math.sqrt(squared)
        normals[3 * i], normals[3 * i + 1], normals[3 * i + 2] = x / length, y / length, z / length
    return True


# --- on threads


# Number of faces that a thread surveys at a time.
_SURVEYED = 32 * CHUNK

# Number of points in a range: their sums fit in the second-level cache.
_RANGE = 2**14
# Largest number of points in the ranges of all threads together, if ranges must be longer: their sums take 64 MiB.
_MOST_POINTS = 2**21

_FLOATS, _INDICES = types.CPointer(types.float64), types.CPointer(types.int64)


def survey_code(library: Library) -> Any:
    """Return `survey`, compiled."""
    return library.call(survey, lambda: types.boolean(_INDICES, _INDICES, *(types.intp,) * 3, _INDICES))


def normals_code(library: Library, stored: str) -> Any:
    """Return `find_normals`, compiled for points of the type `stored`."""
    mesh = _INDICES, _INDICES, types.intp, _INDICES, types.intp
    own = types.intp, types.intp, _INDICES, _FLOATS, _FLOATS, _FLOATS
    return library.call(find_normals, lambda kind: types.boolean(types.CPointer(kind), *mesh, *own), stored)


class FaceArrays(NamedTuple):
    """Checked faces of a mesh, in the form for compiled code.

    Attributes
    ----------
    corners, starts : ndarray
        Connectivity and offsets, int64 and C-contiguous.
    spans : ndarray
        Shape (chunks, 2): least and greatest index in each chunk of faces.
    """

    corners: NDArray[np.int64]
    starts: NDArray[np.int64]
    spans: NDArray[np.int64]

    @classmethod
    def checked(
        cls, look_over: Callable[..., int], connectivity: NDArray[Any], offsets: NDArray[Any], n_points: int
    ) -> Self | None:
        """Check the faces of a mesh, and return them in the form that compiled code reads.

        Return None if compiled code cannot process them.

        Parameters
        ----------
        look_over : callable
            Compiled `survey`.
        connectivity, offsets : ndarray
            Point indices of all faces, face after face; and the index in this array at which each face begins, followed
            by the array's length.
        n_points : int
            Number of points. If a face has an index outside the points, None is returned.
        """
        if any(array.ndim != 1 or array.dtype.kind not in "iu" for array in (connectivity, offsets)):
            return None
        corners, starts = (np.require(array, np.int64, ["C", "A"]) for array in (connectivity, offsets))
        if len(starts) == 0 or (starts[0], starts[-1]) != (0, len(corners)):
            return None
        count, are_good = len(starts) - 1, True
        spans = np.empty((-(-count // CHUNK), 2), np.int64)

        def look(first: int, last: int) -> None:
            nonlocal are_good
            if not look_over(address(corners), address(starts), first, last, len(corners), address(spans)):
                are_good = False

        threads.run(look, count, _SURVEYED)
        if not are_good or spans[:, 0].min(initial=0) < 0 or spans[:, 1].max(initial=-1) >= n_points:
            return None
        return cls(corners, starts, spans)

    @property
    def addresses(self) -> tuple[int, int, int, int]:
        """The faces as arguments of compiled functions: three addresses, and the number of faces.

        In order: address of `corners`, address of `starts`, number of faces, address of `spans`.
        """
        return address(self.corners), address(self.starts), len(self.starts) - 1, address(self.spans)

    def points_at_once(self, n_points: int, least: int, most: int) -> int:
        """Return the number of points that one call of compiled code should process.

        The number begins with `least` and is doubled until one of two conditions holds. First, a chunk of faces has
        points in at most two ranges of this many points, on average, so that few chunks are read repeatedly. Second,
        the ranges of all threads together have `most` points, or all points of the mesh.
        """
        length = least
        while length * threads.count() < min(n_points, most):
            looks = (self.spans[:, 1] // length - self.spans[:, 0] // length + 1).sum()
            if looks <= 2 * len(self.spans):
                break
            length *= 2
        return length


def point_normals(
    library: Library, points: FloatArray, connectivity: NDArray[Any], offsets: NDArray[Any], weighting: Weighting
) -> Float64Array | None:
    """Compute normals of a mesh's points; see `pvphong.shading.kernel.point_normals`.

    Return None if NumPy must compute the normals, or if the mesh is invalid: NumPy then raises the error.
    """
    stored = np.dtype(np.float32 if points.dtype == np.float32 else np.float64)
    try:
        look_over, find = survey_code(library), normals_code(library, stored.name)
    except NotCompiled as missing:
        code.ask_for(missing.key, None, library.lock)
        return None
    faces = FaceArrays.checked(look_over, connectivity, offsets, len(points))
    if faces is None:
        return None
    corners, n_points, declined = faces.corners, len(points), list[int]()
    places, result = as_contiguous(points, stored), np.empty((n_points, 3))
    mesh = address(places), *faces.addresses, WEIGHTINGS.index(weighting)

    def sum_up(first: int, last: int) -> None:
        scratch = np.empty(FACES, np.int64), np.empty(ROWS), np.zeros((last - first, SUMS))
        if not declined and not find(*mesh, first, last, *map(address, (*scratch, result[first:]))):
            declined.append(first)

    threads.run(sum_up, n_points, faces.points_at_once(n_points, _RANGE, _MOST_POINTS))
    if not declined:
        return result
    # Squares of very long or short edges leave the range of floats. Scaling by a power of two can bring them back into
    # range, and changes no bit unless it underflows.
    used = places[corners].astype(np.float64)
    exponent = int(np.frexp(np.abs(used[np.isfinite(used)]).max(initial=0.0))[1])
    is_exact = np.array_equal(np.ldexp(np.ldexp(used, -exponent), exponent), used, equal_nan=True)
    if abs(exponent) <= _LARGE or not is_exact:
        return None
    with np.errstate(over="ignore"):  # of points without a face
        return point_normals(library, np.ldexp(places.astype(np.float64), -exponent), connectivity, offsets, weighting)
