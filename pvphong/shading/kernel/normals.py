"""Normals of a mesh's points, `pvphong.geometry.normals.point_normals`, compiled; and the box around its points.

Each call of `find_normals` does the points of one range, whatever else there is: it passes over the faces that touch
none of them, and adds the others in the order in which they stand in the mesh. So a point's bits depend neither on the
ranges nor on who does them, and no two threads write to one place. Faces are taken in blocks of equally many corners,
whose values stand in rows, corner after corner, so that loops over them vectorise. At the end, `point_normals` shares
ranges of points out to threads.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from pvphong.base import threads
from pvphong.base.types import Float64Array, FloatArray, Weighting
from pvphong.shading.kernel import code
from pvphong.shading.kernel.arithmetic import contracted, inlined, is_nowhere, plain, shifted
from pvphong.shading.kernel.code import Library, NotCompiled
from pvphong.shading.kernel.evaluation import Memory, address, name_of
from pvphong.shading.kernel.vertices import dot, exponent_of, is_finite, scaled

# Corners in a block, and so the most that a face may have.
CORNERS = 384

# Faces in a block at most.
FACES = CORNERS // 3

# Rows of corners: points, edges from each to the next, weights.
PX, PY, PZ, EX, EY, EZ, WEIGHT, _END = range(0, 8 * CORNERS, CORNERS)

# Rows of faces: vectors as long as twice the area, then unit normals; the magnitudes of what those are summed of; the
# lengths; 1, or 0 for a face without a normal; and the length of all rows.
NX, NY, NZ, TX, TY, TZ, AREA, HAS_NORMAL, ROWS = range(_END, _END + 9 * FACES, FACES)

# Faces in a chunk, of which the least and the greatest index are known.
CHUNK = 4096

# Numbers in the sums of a point: x, y, z, and the weights' magnitudes.
SUMS = 4

# The weightings; compiled code gets the place of one.
WEIGHTINGS = "angle", "area", "max"


# --- the angle of a direction in the plane
#
# In a form that vectorises: libm's `atan2` keeps loops from that. One division takes the ratio of the smaller to the
# larger coordinate, or of their difference to their sum, to between -tan(π/8) and tan(π/8), where
# atan(u) = u + u³·P(u²), P of degree 10: 5e-18 by `mpmath.chebyfit`, highest power first. Measured against mpmath:
# within 1.5 · 2⁻⁵² of the angle.


_ATAN = (
    -0.019176887119062166, 0.039231658295587106, -0.05085449737940256, 0.05858148912802209, -0.06664511447381948,
    0.07692183190826087, -0.09090904578123903, 0.11111111015256361, -0.14285714284666542, 0.1999999999999552,
    -0.3333333333333333,
)  # fmt: skip

_STEEPEST = math.tan(math.pi / 8)


@contracted
def _series(z: float) -> float:
    total = _ATAN[0]
    for k in range(1, len(_ATAN)):
        total = total * z + _ATAN[k]
    return total


@inlined
def angle_of(y: float, x: float) -> float:
    """atan2(y, x), from -π to π, in float64; π where x is zero of either sign and y too."""
    a, b = abs(x), abs(y)
    less, more = min(a, b), max(a, b)
    is_steep = less > _STEEPEST * more
    over = less + more if is_steep else more
    u = (less - more if is_steep else less) / (over if over > 0.0 else 1.0)
    angle = (math.pi / 4 if is_steep else 0.0) + (u + u * (u * u) * _series(u * u))
    angle = math.pi / 2 - angle if b > a else angle
    angle = angle if x > 0.0 else math.pi - angle
    return -angle if y < 0.0 else angle


# --- sums over faces


_BY_ANGLE, _BY_AREA = map(WEIGHTINGS.index, ("angle", "area"))

# As in geometry.normals.
_LEAST_SPAN, _MOST_SPAN = 2.0**-100, 2.0**100
_NOISE_OF_AREA, _NOISE_OF_SUM = 4 * 2.0**-53, 16 * 2.0**-53
_LEAST_SQUARE, _MOST_SQUARE = 2.0**-900, 2.0**900
_LEAST_PRODUCT = float(np.finfo(np.float64).tiny)


def survey(connectivity: Any, offsets: Any, first: int, last: int, corners: int, found: Any) -> bool:
    """Least and greatest index in each chunk of some faces; gives whether offsets and sizes are as they should be.

    They are if the offsets rise within the connectivity's so many `corners`, and no face has more than a block. Of a
    chunk without an index 0 and -1 are found.
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


@inlined
def _gather(points: Any, corners: Any, starts: Any, count: int, size: int, rows: Any) -> None:
    for i in range(count):
        for corner in range(size):
            place, to = 3 * corners[starts[i] + corner], corner * count + i
            rows[PX + to] = points[place]
            rows[PY + to] = points[place + 1]
            rows[PZ + to] = points[place + 2]


@inlined
def _find_edges(rows: Any, count: int, size: int) -> bool:
    """Edges of a block; gives whether all are between the least and the most span, as nearly all are."""
    for i in range(count):
        rows[TX + i], rows[TY + i] = 0.0, 0.0
    for corner in range(size):
        here, after = corner * count, (corner + 1) % size * count
        for i in range(count):
            x = rows[PX + after + i] - rows[PX + here + i]
            y = rows[PY + after + i] - rows[PY + here + i]
            z = rows[PZ + after + i] - rows[PZ + here + i]
            rows[EX + here + i], rows[EY + here + i], rows[EZ + here + i] = x, y, z
            rows[TX + i] = max(rows[TX + i], max(abs(x), max(abs(y), abs(z))))
            rows[TY + i] += (x - x) + (y - y) + (z - z)  # NaN if one is not finite, which `max` may overlook
    good = True
    for i in range(count):
        span = rows[TX + i]
        good = good & (span >= _LEAST_SPAN) & (span <= _MOST_SPAN) & (rows[TY + i] == 0.0)
    return good


@plain
def _drop(rows: Any, count: int, size: int) -> bool:
    """Faces with a point that is not finite lose their edges; gives whether that leaves none with odd ones."""
    good = True
    for i in range(count):
        are_finite = True
        for k in range(i, size * count, count):
            are_finite = are_finite and is_finite(rows[PX + k], rows[PY + k], rows[PZ + k])
        if not are_finite:
            for k in range(i, size * count, count):
                rows[PX + k], rows[PY + k], rows[PZ + k] = 0.0, 0.0, 0.0
                rows[EX + k], rows[EY + k], rows[EZ + k] = 0.0, 0.0, 0.0
        elif rows[TX + i] != 0.0:
            good = good and rows[TX + i] >= _LEAST_SPAN and rows[TX + i] <= _MOST_SPAN
    return good


@inlined
def _find_areas(rows: Any, count: int, size: int) -> None:
    """Vectors as long as twice the areas, and the magnitudes of their terms, as `Block.area_vectors` has them."""
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


@inlined
def _find_normals(rows: Any, count: int) -> bool:
    """Unit normals of areas that are more than rounding; gives whether none had to be left to `_rescue`."""
    good = True
    for i in range(count):
        x, y, z = rows[NX + i], rows[NY + i], rows[NZ + i]
        is_noise = (
            (abs(x) <= _NOISE_OF_AREA * rows[TX + i])
            & (abs(y) <= _NOISE_OF_AREA * rows[TY + i])
            & (abs(z) <= _NOISE_OF_AREA * rows[TZ + i])
        )
        square = dot(x, y, z, x, y, z)
        is_moderate = (square >= _LEAST_SQUARE) & (square <= _MOST_SQUARE)
        good = good & (is_noise | is_moderate)
        length = np.sqrt(square)
        factor = 0.0 if is_noise else 1.0
        divisor = length if is_moderate else 1.0
        rows[NX + i], rows[NY + i], rows[NZ + i] = (
            factor * x / divisor,
            factor * y / divisor,
            factor * z / divisor,
        )
        rows[AREA + i], rows[HAS_NORMAL + i] = factor * length, factor
    return good


@inlined
def _unit(x: float, y: float, z: float) -> tuple[float, float, float]:
    """A unit vector; zero stays zero."""
    square = dot(x, y, z, x, y, z)
    if not (square >= _LEAST_SQUARE and square <= _MOST_SQUARE):
        if x == 0.0 and y == 0.0 and z == 0.0:
            return 0.0, 0.0, 0.0
        x, y, z = scaled(x, y, z, exponent_of(x, y, z))
        square = dot(x, y, z, x, y, z)
    length = math.sqrt(square)
    return x / length, y / length, z / length


@plain
def _rescue(rows: Any, count: int) -> None:
    """Unit normals of areas whose squares leave the range of floats."""
    for i in range(count):
        rows[NX + i], rows[NY + i], rows[NZ + i] = _unit(rows[NX + i], rows[NY + i], rows[NZ + i])


@inlined
def _weigh(rows: Any, count: int, size: int, weighting: int) -> None:
    """Weights of a block's corners; zero in a face without a normal."""
    for corner in range(size):
        before, here = (corner + size - 1) % size * count, corner * count
        for i in range(count):
            ax, ay, az = rows[EX + before + i], rows[EY + before + i], rows[EZ + before + i]
            bx, by, bz = rows[EX + here + i], rows[EY + here + i], rows[EZ + here + i]
            cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            sine = np.sqrt(dot(cx, cy, cz, cx, cy, cz))  # times the two edges' lengths, as is the cosine
            if size > 3:  # a reflex corner turns against the face's normal; a triangle has none
                turn = dot(cx, cy, cz, rows[NX + i], rows[NY + i], rows[NZ + i])
                sine = -sine if turn < 0.0 else sine
            if weighting == _BY_ANGLE:
                weight = angle_of(sine, -dot(ax, ay, az, bx, by, bz))
                weight = weight + 2.0 * math.pi if weight < 0.0 else weight
            elif weighting == _BY_AREA:
                weight = rows[AREA + i]
            else:
                product = dot(ax, ay, az, ax, ay, az) * dot(bx, by, bz, bx, by, bz)
                weight = sine / max(product, _LEAST_PRODUCT) if product >= _LEAST_PRODUCT else 0.0
            rows[WEIGHT + here + i] = weight * rows[HAS_NORMAL + i]


@inlined
def _scatter(corners: Any, starts: Any, count: int, size: int, rows: Any, first: int, last: int, sums: Any) -> None:
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


@plain
def _add(
    points: Any,
    points32: Any,
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
    """Add a block of faces to the sums; gives whether that was possible."""
    if count == 0:
        return True
    if is_nowhere(points):
        _gather(points32, corners, starts, count, size, rows)
    else:
        _gather(points, corners, starts, count, size, rows)
    if not _find_edges(rows, count, size) and not _drop(rows, count, size):
        return False
    _find_areas(rows, count, size)
    if not _find_normals(rows, count):
        _rescue(rows, count)
    _weigh(rows, count, size, weighting)
    _scatter(corners, starts, count, size, rows, first, last, sums)
    return True


@inlined
def _touches(corners: Any, start: int, stop: int, first: int, last: int) -> bool:
    found = False
    for place in range(start, stop):
        found = found | ((corners[place] >= first) & (corners[place] < last))
    return found


@plain
def _finish(sums: Any, count: int, normals: Any) -> None:
    """Unit vectors of the sums; zero where they are made of rounding alone."""
    for i in range(count):
        x, y, z = sums[SUMS * i], sums[SUMS * i + 1], sums[SUMS * i + 2]
        noise = _NOISE_OF_SUM * sums[SUMS * i + 3]
        if abs(x) <= noise and abs(y) <= noise and abs(z) <= noise:
            x, y, z = 0.0, 0.0, 0.0
        normals[3 * i], normals[3 * i + 1], normals[3 * i + 2] = _unit(x, y, z)


def find_normals(
    points: Any,
    points32: Any,
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
    """Normals of the points from `first` to `last`; gives whether no face is too large or too small for that.

    Points are float64, or float32 where `points` is nowhere. Of scratch memory, `sums` are zeros at first.
    """
    count, size = 0, 0
    for chunk in range((faces + CHUNK - 1) // CHUNK):
        if surveyed[2 * chunk] >= last or surveyed[2 * chunk + 1] < first:
            continue
        for face in range(chunk * CHUNK, min((chunk + 1) * CHUNK, faces)):
            start, stop = offsets[face], offsets[face + 1]
            if stop - start < 3 or not _touches(corners, start, stop, first, last):
                continue
            if stop - start != size or (count + 1) * size > CORNERS:
                if not _add(points, points32, corners, starts, count, size, weighting, rows, first, last, sums):
                    return False
                count, size = 0, stop - start
            starts[count] = start
            count += 1
    if not _add(points, points32, corners, starts, count, size, weighting, rows, first, last, sums):
        return False
    _finish(sums, last - first, normals)
    return True


# --- least and greatest entries of vectors: the box around a mesh, which a plan asks for


# Entries that are compared at once, each in a place of its own: a multiple of three, so that x stays with x, and of
# the length of vectors. More of them would keep memory from being read one line after the other.
_LANES = 48

# Length of the scratch memory: the least and the greatest of each place.
LANES = 2 * _LANES

_ZERO = np.float32(0.0)


def _choosing(name: str) -> Any:
    """One of LLVM's choices between two numbers of a type; any number where one of them is NaN.

    The builtins' comparisons LLVM makes into stores under a mask, which cost some processors ten times as much.
    """

    @intrinsic
    def choose(_typing: Any, a: Any, b: Any) -> Any:
        def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            kind = arguments[0].type
            function = builder.module.declare_intrinsic(f"llvm.{name}", [kind], ir.FunctionType(kind, [kind] * 2))
            return builder.call(function, arguments, fastmath=("nnan", "nsz"))

        return a(a, b), generate

    return choose


_least, _most = _choosing("minnum"), _choosing("maxnum")


@inlined
def _widen_by_four(part: Any, low: Any, high: Any) -> bool:
    """As `_widen`, by four times as many entries: reading and writing the extremes takes longer than comparing."""
    good = True
    for i in range(_LANES):
        a, b, c, d = part[i], part[_LANES + i], part[2 * _LANES + i], part[3 * _LANES + i]
        low[i] = _least(low[i], _least(_least(a, b), _least(c, d)))
        high[i] = _most(high[i], _most(_most(a, b), _most(c, d)))
        good = good & ((a - a) + (b - b) == (c - c) + (d - d))
    return good


@inlined
def _widen(part: Any, count: int, low: Any, high: Any) -> bool:
    good = True
    for i in range(count):
        x = part[i]
        low[i] = _least(low[i], x)
        high[i] = _most(high[i], x)
        good = good & (x - x == _ZERO)
    return good


def find_extremes(array: Any, start: int, stop: int, rows: Any, found: Any) -> bool:
    """Least x, y, z and greatest x, y, z of some vectors; gives whether all entries are finite."""
    low, high = rows, shifted(rows, _LANES)
    for i in range(_LANES):
        low[i], high[i] = np.inf, -np.inf
    good = True
    in_fours = (stop - start) * 3 // (4 * _LANES) * 4 * _LANES
    for first in range(3 * start, 3 * start + in_fours, 4 * _LANES):
        good = good & _widen_by_four(shifted(array, first), low, high)
    for first in range(3 * start + in_fours, 3 * stop, _LANES):
        good = good & _widen(shifted(array, first), min(_LANES, 3 * stop - first), low, high)
    for k in range(3):
        found[k], found[3 + k] = low[k], high[k]
        for i in range(k + 3, _LANES, 3):
            found[k], found[3 + k] = min(found[k], np.float64(low[i])), max(found[3 + k], np.float64(high[i]))
    return good


# --- shared out to threads


# Faces that a thread surveys at a time.
_SURVEYED = 32 * CHUNK

# Vertices that a thread searches for bounds at a time.
_SEARCHED = 2**17

# Points in a range: few enough that their sums stay in the second-level cache.
_RANGE = 2**14
# Points in the ranges of all threads together where those have to be longer: their sums then take 64 MiB.
_MOST_POINTS = 2**21


def survey_code(library: Library) -> Callable[..., int]:
    """`survey`, compiled."""
    return library.call(survey, _signature_of_survey)


def normals_code(library: Library) -> Callable[..., int]:
    """`find_normals`, compiled."""
    return library.call(find_normals, _signature_of_normals)


def extremes_code(library: Library, stored: str) -> Callable[..., int]:
    """`find_extremes`, compiled, for vectors of a type."""
    return library.call(find_extremes, _signature_of_extremes, stored)


_FLOATS, _INDICES = types.CPointer(types.float64), types.CPointer(types.int64)


def _signature_of_survey() -> Any:
    return types.boolean(_INDICES, _INDICES, *(types.intp,) * 3, _INDICES)


def _signature_of_normals() -> Any:
    mesh = _FLOATS, types.CPointer(types.float32), _INDICES, _INDICES, types.intp, _INDICES, types.intp
    return types.boolean(*mesh, types.intp, types.intp, _INDICES, _FLOATS, _FLOATS, _FLOATS)


def _signature_of_extremes(stored: Any) -> Any:
    rows = types.CPointer(stored)
    return types.boolean(rows, types.intp, types.intp, rows, _FLOATS)


def find_bounds(library: Library, rows: FloatArray) -> tuple[Float64Array, Float64Array] | None:
    """As `pvphong.shading.kernel.find_bounds` has it."""
    if rows.dtype not in (np.float32, np.float64) or not rows.flags.c_contiguous:
        return None
    try:
        search = extremes_code(library.at_hand, name_of(rows.dtype))
    except NotCompiled as missing:
        code.ask_for(missing.key, None, library.lock)
        return None
    found = np.full((-(-len(rows) // _SEARCHED), 6), np.nan)

    def work(first: int, last: int) -> None:
        low_and_high = np.empty(6)
        if search(address(rows), first, last, Memory.of_thread().addresses[0], address(low_and_high)):
            found[first // _SEARCHED] = low_and_high

    threads.run(work, len(rows), _SEARCHED)
    return found[:, :3].min(axis=0), found[:, 3:].max(axis=0)


def point_normals(
    library: Library, points: FloatArray, connectivity: NDArray[Any], offsets: NDArray[Any], weighting: Weighting
) -> Float64Array | None:
    """As `pvphong.shading.kernel.point_normals` has it.

    None where NumPy is to do it: for what it refuses, such as an index that is none of a point's, for faces of more
    than `CORNERS` corners, and for faces of sizes so far apart that squares of their edges leave the range of floats.
    """
    try:
        look_over, find = survey_code(library), normals_code(library)
    except NotCompiled as missing:
        code.ask_for(missing.key, None, library.lock)
        return None
    if any(array.ndim != 1 or array.dtype.kind not in "iu" for array in (connectivity, offsets)):
        return None
    corners, starts = (np.require(array, np.int64, ["C", "A"]) for array in (connectivity, offsets))
    if len(starts) == 0 or (starts[0], starts[-1]) != (0, len(corners)):
        return None
    spans = _spans(corners, starts, look_over)
    if spans is None or spans[:, 0].min(initial=0) < 0 or spans[:, 1].max(initial=-1) >= len(points):
        return None
    mesh = corners, starts, spans, WEIGHTINGS.index(weighting)
    result = _normals(np.require(points, None, ["C", "A"]), *mesh, find)
    if result is None:
        scaled = _scaled(points, corners)
        return None if scaled is None else _normals(scaled, *mesh, find)
    return result


def _normals(
    points: FloatArray,
    corners: NDArray[np.int64],
    starts: NDArray[np.int64],
    spans: NDArray[np.int64],
    weighting: int,
    find: Callable[..., int],
) -> Float64Array | None:
    """None where faces are too large or too small."""
    result = np.empty((len(points), 3))
    wide_or_not = (points, None) if points.dtype == np.float64 else (None, points)
    mesh = *map(address, (*wide_or_not, corners, starts)), len(starts) - 1, address(spans), weighting
    declined: list[int] = []

    def work(first: int, last: int) -> None:
        scratch = np.empty(FACES, np.int64), np.empty(ROWS), np.zeros((last - first, SUMS))
        if not declined and not find(*mesh, first, last, *map(address, (*scratch, result[first:]))):
            declined.append(first)

    threads.run(work, len(points), _length_of_ranges(spans, len(points)))
    return None if declined else result


def _scaled(points: FloatArray, corners: NDArray[np.int64]) -> Float64Array | None:
    """Points over the power of two that takes the largest coordinate to [0.5, 1); None where that is not exact.

    What no face has or is not finite is NaN: it neither decides about the power nor keeps it from being exact.
    """
    counts = np.zeros(len(points), dtype=bool)
    counts[corners] = True
    counts &= np.isfinite(points).all(axis=1)
    rows = np.where(counts[:, None], points.astype(np.float64, copy=False), np.nan)
    exponent = np.frexp(np.fmax.reduce(np.abs(rows), axis=None, initial=0.0))[1]
    result: Float64Array = np.ldexp(rows, -exponent)
    return result if np.array_equal(np.ldexp(result, exponent), rows, equal_nan=True) else None


def _spans(
    corners: NDArray[np.int64], starts: NDArray[np.int64], look_over: Callable[..., int]
) -> NDArray[np.int64] | None:
    """(n, 2) least and greatest index in each chunk of faces; None where a face is not as it should be."""
    n_faces = len(starts) - 1
    found = np.empty((-(-n_faces // CHUNK), 2), np.int64)
    wrong: list[int] = []

    def work(first: int, last: int) -> None:
        if not look_over(address(corners), address(starts), first, last, len(corners), address(found)):
            wrong.append(first)

    threads.run(work, n_faces, _SURVEYED)
    return None if wrong else found


def _length_of_ranges(spans: NDArray[np.int64], n_points: int) -> int:
    """Points in a range, so many that few chunks of faces are looked at more than twice."""
    length = _RANGE
    while length * threads.count() < min(n_points, _MOST_POINTS):
        looks = (spans[:, 1] // length - spans[:, 0] // length + 1).sum()
        if looks <= 2 * len(spans):
            break
        length *= 2
    return length
