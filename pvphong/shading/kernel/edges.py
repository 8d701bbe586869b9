"""Splitting a mesh's points along its sharp edges, compiled: the splitting of VTK's vtkSplitSharpEdgesPolyData.

The faces around a point form fans: two neighbouring faces are in the same fan if the edge between them is smooth. The
first fan keeps the point, and each other fan gets a new point. Fans, their order and the rounding of normals are as in
VTK's filter.

Each call of `find_fans` computes a range of points, and writes only for these points. So the result depends neither on
the ranges nor on the threads.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from pvphong.base import threads
from pvphong.base.types import FloatArray
from pvphong.shading.kernel import code
from pvphong.shading.kernel.arithmetic import inlined
from pvphong.shading.kernel.code import Library, NotCompiled
from pvphong.shading.kernel.evaluation import address, as_contiguous
from pvphong.shading.kernel.normals import CHUNK, FaceArrays, survey_code

# Entries of a slot of the hash table, for the list of faces around one point: another point, or −1 in an empty slot;
# the number of faces in the list that have this other point; the sum of these faces' indices in the list; and the last
# of these indices.
KEY, COUNT, SUM, NEWEST, SLOT = range(5)

# Odd factor of the hash: 2⁶⁴ divided by the golden ratio, without the first bit. It spreads consecutive numbers.
_SPREAD = 0x1E3779B97F4A7C15


# --- compiled functions


@inlined
def _edge(points: Any, origin: int, end: int) -> tuple[float, float, float]:
    """Return the vector from point number `origin` to point number `end`, subtracted in the points' own precision."""
    a, b = 3 * origin, 3 * end
    x, y, z = points[b] - points[a], points[b + 1] - points[a + 1], points[b + 2] - points[a + 2]
    return np.float64(x), np.float64(y), np.float64(z)


def find_face_normals(points: Any, corners: Any, offsets: Any, first: int, last: int, normals: Any) -> int:
    """Compute unit normals of the faces from number `first` (inclusive) to `last` (exclusive), in float32.

    `points` holds the coordinates of all points; `corners` and `offsets` are the connectivity and the offsets of all
    faces. The arithmetic is that of `vtkPolygon::ComputeNormal` of VTK 9.7. The normal of a face without an area is
    zero. Return the largest number of corners of a face, or 0 if a face has fewer than three.
    """
    largest = 0
    for face in range(first, last):
        start, size = offsets[face], offsets[face + 1] - offsets[face]
        if size < 3:
            return 0
        largest = max(largest, size)
        # triangles that share the first corner, or the first corner with an edge that is longer than 0
        origin, place = corners[start], start + 1
        ax, ay, az = _edge(points, origin, corners[place])
        while not ax * ax + ay * ay + az * az > 0.0 and place < start + size - 1:
            origin, place = corners[place], place + 1
            ax, ay, az = _edge(points, origin, corners[place])
        x, y, z = 0.0, 0.0, 0.0
        for after in range(place + 1, start + size):
            bx, by, bz = _edge(points, origin, corners[after])
            x += ay * bz - az * by
            y += az * bx - ax * bz
            z += ax * by - ay * bx
            ax, ay, az = bx, by, bz
        length = math.sqrt(x * x + y * y + z * z)
        divisor = length if length != 0.0 else 1.0
        normals[3 * face] = np.float32(x / divisor)
        normals[3 * face + 1] = np.float32(y / divisor)
        normals[3 * face + 2] = np.float32(z / divisor)
    return largest


@inlined
def _touches(surveyed: Any, chunk: int, first: int, last: int) -> bool:
    """Return True if a chunk of faces may contain a point of the range `first` (inclusive) to `last` (exclusive).

    `surveyed` has the least and the greatest point index of each chunk; `chunk` is the chunk's number.
    """
    return (surveyed[2 * chunk] < last) & (surveyed[2 * chunk + 1] >= first)


def count_corners(
    corners: Any, offsets: Any, faces: int, surveyed: Any, first: int, last: int, starts: Any, most: Any
) -> int:
    """Count the corners of faces at each point from number `first` (inclusive) to `last` (exclusive).

    Parameters
    ----------
    corners, offsets, faces, surveyed
        `FaceArrays.addresses`: connectivity, offsets, number of faces, and least and greatest index in each chunk.
    starts
        Output: for each point, the sum of the counts before it. It has one more entry than there are points, and must
        contain zeros.
    most
        Output: the largest count.

    Returns
    -------
    int
        The sum of all counts.
    """
    for chunk in range((faces + CHUNK - 1) // CHUNK):
        if _touches(surveyed, chunk, first, last):
            for place in range(offsets[chunk * CHUNK], offsets[min((chunk + 1) * CHUNK, faces)]):
                if first <= corners[place] < last:
                    starts[corners[place] - first + 1] += 1
    most[0] = 0
    for i in range(last - first):
        most[0] = max(most[0], starts[i + 1])
        starts[i + 1] += starts[i]
    return starts[last - first]


@inlined
def _list_faces(
    corners: Any, offsets: Any, faces: int, surveyed: Any, first: int, last: int, starts: Any, ends: Any, around: Any
) -> None:
    """List the faces around each point from number `first` (inclusive) to `last` (exclusive).

    The faces of a list are in the mesh's order, each face once. `around` receives the lists, point after point. The
    list of a point begins at its entry of `starts`, from `count_corners`. `ends` receives the ends of the lists. The
    other arguments are as for `count_corners`.
    """
    for i in range(last - first):
        ends[i] = starts[i]
    for chunk in range((faces + CHUNK - 1) // CHUNK):
        if _touches(surveyed, chunk, first, last):
            for face in range(chunk * CHUNK, min((chunk + 1) * CHUNK, faces)):
                for place in range(offsets[face], offsets[face + 1]):
                    if first <= corners[place] < last:
                        i = corners[place] - first
                        if ends[i] == starts[i] or around[ends[i] - 1] != face:  # a face may have a point twice
                            around[ends[i]] = face
                            ends[i] += 1


@inlined
def _enter(table: Any, mask: int, point: int, place: int) -> int:
    """Record in the hash table that a face contains point number `point`; return the offset of the point's slot.

    `place` is the index of the face in the list of faces around a point, and `mask` the number of slots minus 1.
    """
    slot = SLOT * (((point * _SPREAD) >> 32) & mask)
    while table[slot + KEY] != point and table[slot + KEY] >= 0:
        slot = (slot + SLOT) & (SLOT * mask + SLOT - 1)
    if table[slot + KEY] < 0:
        table[slot + KEY], table[slot + COUNT], table[slot + SUM], table[slot + NEWEST] = point, 0, 0, -1
    if table[slot + NEWEST] != place:
        table[slot + COUNT] += 1
        table[slot + SUM] += place
        table[slot + NEWEST] = place
    return slot


@inlined
def _look_around(
    corners: Any, offsets: Any, point: int, around: Any, begin: int, count: int, table: Any, sides: Any
) -> None:
    """Enter the points of all faces around one point into the hash table.

    Parameters
    ----------
    corners, offsets
        Connectivity and offsets of the mesh.
    point : int
        Number of the point.
    around, begin, count
        The point's list of faces: `count` entries of `around`, from `begin` on.
    table
        The hash table, which is overwritten.
    sides
        Output: for each face of the list, the slots of the point's two neighbours in the face.
    """
    others = 0
    for i in range(count):
        others += offsets[around[begin + i] + 1] - offsets[around[begin + i]] - 1
    slots = 1
    while slots <= others:
        slots *= 2
    for slot in range(0, SLOT * slots, SLOT):
        table[slot + KEY] = -1
    own, mask = SLOT * slots, slots - 1  # the point itself has a slot outside the hash table: all faces have it
    table[own + COUNT], table[own + SUM] = count, count * (count - 1) // 2
    for i in range(count):
        start, stop = offsets[around[begin + i]], offsets[around[begin + i] + 1]
        place = start
        while corners[place] != point:
            place += 1
        is_last = place == stop - 1
        before, after = corners[place - 1 if place > start else stop - 1], corners[start if is_last else place + 1]
        before = _enter(table, mask, before, i) if before != point else own
        after = _enter(table, mask, after, i) if after != point else own
        sides[2 * i], sides[2 * i + 1] = before if is_last else after, after if is_last else before
        for other in range(start, stop if stop - start > 3 else start):
            if corners[other] != point:
                _enter(table, mask, corners[other], i)


@inlined
def _are_alike(normals: Any, one: int, two: int, cosine: Any) -> bool:
    """Return True if the edge between the faces `one` and `two` is smooth; False for NaN.

    The edge is smooth if the dot product of the faces' unit normals exceeds the number at the pointer `cosine`.
    """
    a, b = 3 * one, 3 * two
    product = normals[a] * normals[b] + normals[a + 1] * normals[b + 1] + normals[a + 2] * normals[b + 2]
    return product > cosine[0]


@inlined
def _number_fans(
    normals: Any, cosine: Any, around: Any, begin: int, count: int, table: Any, sides: Any, fans: Any
) -> int:
    """Assign the faces around one point to fans, and return the number of fans.

    A fan grows from its first face in both directions, across smooth edges.

    Parameters
    ----------
    normals, cosine
        Unit normals of all faces. An edge is smooth if the dot product of its faces' normals exceeds `cosine`.
    around, begin, count, table, sides
        As for `_look_around`, which has filled `table` and `sides`.
    fans
        Output: number of the fan of each face in the list.
    """
    for i in range(count):
        fans[i] = -1
    found = 0
    for seed in range(count):
        if fans[seed] >= 0:
            continue
        fans[seed] = found
        for side in range(2 * seed, 2 * seed + 2):
            here, edge = seed, sides[side]
            while table[edge + COUNT] == 2:  # exactly one other face has both points of the edge
                there = table[edge + SUM] - here
                if fans[there] >= 0 or not _are_alike(normals, around[begin + here], around[begin + there], cosine):
                    break
                fans[there] = found
                here, edge = there, sides[2 * there + 1] if sides[2 * there] == edge else sides[2 * there]
        found += 1
    return found


def find_fans(
    corners: Any,
    offsets: Any,
    faces: int,
    surveyed: Any,
    normals: Any,
    cosine: Any,
    first: int,
    last: int,
    starts: Any,
    ends: Any,
    around: Any,
    sides: Any,
    fans: Any,
    table: Any,
    numbers: Any,
    extra: Any,
) -> int:
    """Number the fans of faces around each point from number `first` (inclusive) to `last` (exclusive).

    Parameters
    ----------
    corners, offsets, faces, surveyed
        As for `count_corners`.
    normals, cosine
        Normals from `find_face_normals`. An edge is smooth if the cosine between its faces exceeds `cosine`.
    starts
        Sums from `count_corners`.
    ends, around, sides, fans, table
        Scratch memory. `around` holds the lists of the faces around all points, and `ends` the ends of the lists. For
        each face in one point's list, `sides` holds two slots, and `fans` the number of its fan. `table` holds the
        slots.
    numbers
        Output: number of the fan of each corner. Only written where it is not 0.
    extra
        Output: number of fans of each point beyond the first. Only written where it is not 0.

    Returns
    -------
    int
        The sum of `extra` over these points.
    """
    _list_faces(corners, offsets, faces, surveyed, first, last, starts, ends, around)
    total = 0
    for point in range(first, last):
        begin, count = starts[point - first], ends[point - first] - starts[point - first]
        if count < 2:
            continue
        _look_around(corners, offsets, point, around, begin, count, table, sides)
        found = _number_fans(normals, cosine, around, begin, count, table, sides, fans)
        if found < 2:
            continue
        extra[point] = found - 1
        total += found - 1
        for i in range(count):
            if fans[i] > 0:
                for place in range(offsets[around[begin + i]], offsets[around[begin + i] + 1]):
                    if corners[place] == point:
                        numbers[place] = np.int32(fans[i])
    return total


# --- on threads


# Number of faces whose normals a thread computes at a time.
_FACES = 2**15

# Number of points in a range: the data of their faces fits in the second-level cache. If a mesh is in random order, its
# ranges are longer, but still short enough for an interrupt to take effect soon.
_RANGE, _MOST_POINTS = 2**13, 2**18

_NORMALS, _INDICES = types.CPointer(types.float32), types.CPointer(types.int64)
_MESH = _INDICES, _INDICES, types.intp, _INDICES


def normals_code(library: Library, stored: str) -> Any:
    """Return `find_face_normals`, compiled for points of the type `stored`."""
    faces = _INDICES, _INDICES, types.intp, types.intp, _NORMALS
    return library.call(find_face_normals, lambda kind: types.intp(types.CPointer(kind), *faces), stored)


def count_code(library: Library) -> Any:
    """Return `count_corners`, compiled."""
    return library.call(count_corners, lambda: types.intp(*_MESH, types.intp, types.intp, _INDICES, _INDICES))


def fans_code(library: Library) -> Any:
    """Return `find_fans`, compiled."""
    faces = *_MESH, _NORMALS, types.CPointer(types.float64)
    own = types.intp, types.intp, *[_INDICES] * 6, types.CPointer(types.int32), _INDICES
    return library.call(find_fans, lambda: types.intp(*faces, *own))


def split_points(
    library: Library, points: FloatArray, connectivity: NDArray[Any], offsets: NDArray[Any], angle: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
    """Split a mesh's points along sharp edges, as `pvphong.shading.kernel.split_points` describes."""
    stored = np.dtype(np.float32 if points.dtype == np.float32 else np.float64)
    try:
        look_over, find_normals = survey_code(library), normals_code(library, stored.name)
        count, find = count_code(library), fans_code(library)
    except NotCompiled as missing:
        code.ask_for(missing.key, None, library.lock)
        return None
    faces = FaceArrays.checked(look_over, connectivity, offsets, len(points))
    if faces is None:
        return None
    corners, places = faces.corners, as_contiguous(points, stored)
    normals, largest = np.empty((len(faces.starts) - 1, 3), np.float32), list[int]()

    def compute(first: int, last: int) -> None:
        largest.append(find_normals(*map(address, (places, corners, faces.starts)), first, last, address(normals)))

    threads.run(compute, len(normals), _FACES)
    if min(largest, default=0) == 0:
        return None
    cosine = np.array([math.cos(math.radians(angle))])
    numbers, extra = np.zeros(len(corners), np.int32), np.zeros(len(points), np.int64)
    mesh = *faces.addresses, address(normals), address(cosine)

    def split(first: int, last: int) -> None:
        starts, most = np.zeros(last - first + 1, np.int64), np.empty(1, np.int64)
        total = count(*faces.addresses, first, last, address(starts), address(most))
        slots = 2 ** int(most[0] * (max(largest) - 1)).bit_length() + 1
        lengths = last - first, total, 2 * most[0], most[0], SLOT * slots
        scratch = [np.empty(length, np.int64) for length in lengths]
        find(*mesh, first, last, *map(address, (starts, *scratch, numbers, extra)))

    threads.run(split, len(points), faces.points_at_once(len(points), _RANGE, _MOST_POINTS))
    added = np.repeat(np.arange(len(points)), extra)
    if not len(added):
        return corners, added
    moved = np.flatnonzero(numbers)
    before = len(points) - 1 + np.cumsum(extra) - extra
    result = corners.copy()
    result[moved] = before[corners[moved]] + numbers[moved]
    return result, added
