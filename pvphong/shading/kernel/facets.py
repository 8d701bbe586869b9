"""Normals of points, summed over the faces around them: `pvphong.geometry.normals.point_normals`, compiled.

Each call does the points of one range, whatever else there is: it passes over the faces that touch none of them, and
adds the others in the order in which they stand in the mesh. So a point's bits depend neither on the ranges nor on
who does them, and no two threads write to one place. Faces are taken in blocks of equally many corners, whose values
stand in rows, corner after corner, so that loops over them vectorise.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.shading.kernel import face_rows as at
from pvphong.shading.kernel.angles import angle_of
from pvphong.shading.kernel.arithmetic import inlined, plain
from pvphong.shading.kernel.face_rows import CHUNK, CORNERS, FACES, SUMS, WEIGHTINGS
from pvphong.shading.kernel.loading import exponent_of, is_finite, scaled
from pvphong.shading.kernel.pointers import is_nowhere
from pvphong.shading.kernel.vectors import dot

_BY_ANGLE, _BY_AREA = map(WEIGHTINGS.index, ("angle", "area"))

# As in geometry.faces, geometry.normals and geometry.transform.
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
            rows[at.PX + to] = points[place]
            rows[at.PY + to] = points[place + 1]
            rows[at.PZ + to] = points[place + 2]


@inlined
def _find_edges(rows: Any, count: int, size: int) -> bool:
    """Edges of a block; gives whether all are between the least and the most span, as nearly all are."""
    for i in range(count):
        rows[at.TX + i], rows[at.TY + i] = 0.0, 0.0
    for corner in range(size):
        here, after = corner * count, (corner + 1) % size * count
        for i in range(count):
            x = rows[at.PX + after + i] - rows[at.PX + here + i]
            y = rows[at.PY + after + i] - rows[at.PY + here + i]
            z = rows[at.PZ + after + i] - rows[at.PZ + here + i]
            rows[at.EX + here + i], rows[at.EY + here + i], rows[at.EZ + here + i] = x, y, z
            rows[at.TX + i] = max(rows[at.TX + i], max(abs(x), max(abs(y), abs(z))))
            rows[at.TY + i] += (x - x) + (y - y) + (z - z)  # NaN if one is not finite, which `max` may overlook
    good = True
    for i in range(count):
        span = rows[at.TX + i]
        good = good & (span >= _LEAST_SPAN) & (span <= _MOST_SPAN) & (rows[at.TY + i] == 0.0)
    return good


@plain
def _drop(rows: Any, count: int, size: int) -> bool:
    """Faces with a point that is not finite lose their edges; gives whether that leaves none with odd ones."""
    good = True
    for i in range(count):
        are_finite = True
        for k in range(i, size * count, count):
            are_finite = are_finite and is_finite(rows[at.PX + k], rows[at.PY + k], rows[at.PZ + k])
        if not are_finite:
            for k in range(i, size * count, count):
                rows[at.PX + k], rows[at.PY + k], rows[at.PZ + k] = 0.0, 0.0, 0.0
                rows[at.EX + k], rows[at.EY + k], rows[at.EZ + k] = 0.0, 0.0, 0.0
        elif rows[at.TX + i] != 0.0:
            good = good and rows[at.TX + i] >= _LEAST_SPAN and rows[at.TX + i] <= _MOST_SPAN
    return good


@inlined
def _find_areas(rows: Any, count: int, size: int) -> None:
    """Vectors as long as twice the areas, and the magnitudes of their terms, as `Block.area_vectors` has them."""
    for row in range(at.NX, at.AREA, FACES):
        for i in range(count):
            rows[row + i] = 0.0
    for corner in range(1, size - 1):
        is_last = corner == size - 2
        spoke, side = corner * count, (size - 1 if is_last else corner) * count
        sign = -1.0 if is_last else 1.0
        for i in range(count):
            ax, bx = rows[at.PX + spoke + i] - rows[at.PX + i], sign * rows[at.EX + side + i]
            ay, by = rows[at.PY + spoke + i] - rows[at.PY + i], sign * rows[at.EY + side + i]
            az, bz = rows[at.PZ + spoke + i] - rows[at.PZ + i], sign * rows[at.EZ + side + i]
            rows[at.NX + i] += ay * bz - az * by
            rows[at.NY + i] += az * bx - ax * bz
            rows[at.NZ + i] += ax * by - ay * bx
            rows[at.TX + i] += abs(ay * bz) + abs(az * by)
            rows[at.TY + i] += abs(az * bx) + abs(ax * bz)
            rows[at.TZ + i] += abs(ax * by) + abs(ay * bx)


@inlined
def _find_normals(rows: Any, count: int) -> bool:
    """Unit normals of areas that are more than rounding; gives whether none had to be left to `_rescue`."""
    good = True
    for i in range(count):
        x, y, z = rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i]
        is_noise = (
            (abs(x) <= _NOISE_OF_AREA * rows[at.TX + i])
            & (abs(y) <= _NOISE_OF_AREA * rows[at.TY + i])
            & (abs(z) <= _NOISE_OF_AREA * rows[at.TZ + i])
        )
        square = dot(x, y, z, x, y, z)
        is_moderate = (square >= _LEAST_SQUARE) & (square <= _MOST_SQUARE)
        good = good & (is_noise | is_moderate)
        length = np.sqrt(square)
        factor = 0.0 if is_noise else 1.0
        divisor = length if is_moderate else 1.0
        rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i] = (
            factor * x / divisor,
            factor * y / divisor,
            factor * z / divisor,
        )
        rows[at.AREA + i], rows[at.HAS_NORMAL + i] = factor * length, factor
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
        rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i] = _unit(rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i])


@inlined
def _weigh(rows: Any, count: int, size: int, weighting: int) -> None:
    """Weights of a block's corners; zero in a face without a normal."""
    for corner in range(size):
        before, here = (corner + size - 1) % size * count, corner * count
        for i in range(count):
            ax, ay, az = rows[at.EX + before + i], rows[at.EY + before + i], rows[at.EZ + before + i]
            bx, by, bz = rows[at.EX + here + i], rows[at.EY + here + i], rows[at.EZ + here + i]
            cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            sine = np.sqrt(dot(cx, cy, cz, cx, cy, cz))  # times the two edges' lengths, as is the cosine
            if size > 3:  # a reflex corner turns against the face's normal; a triangle has none
                turn = dot(cx, cy, cz, rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i])
                sine = -sine if turn < 0.0 else sine
            if weighting == _BY_ANGLE:
                weight = angle_of(sine, -dot(ax, ay, az, bx, by, bz))
                weight = weight + 2.0 * math.pi if weight < 0.0 else weight
            elif weighting == _BY_AREA:
                weight = rows[at.AREA + i]
            else:
                product = dot(ax, ay, az, ax, ay, az) * dot(bx, by, bz, bx, by, bz)
                weight = sine / max(product, _LEAST_PRODUCT) if product >= _LEAST_PRODUCT else 0.0
            rows[at.WEIGHT + here + i] = weight * rows[at.HAS_NORMAL + i]


@inlined
def _scatter(corners: Any, starts: Any, count: int, size: int, rows: Any, first: int, last: int, sums: Any) -> None:
    for i in range(count):
        x, y, z = rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i]
        for corner in range(size):
            point = corners[starts[i] + corner]
            if first <= point < last:
                weight, to = rows[at.WEIGHT + corner * count + i], SUMS * (point - first)
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
