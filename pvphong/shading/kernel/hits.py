"""Nearest hits of rays, found by Embree sixteen rays at a time, in compiled code. `rays` finds only whether rays hit.

In reading order: `_find` finds the nearest hits of open rays. `look_around` casts many rays from each vertex, for
bounced light, and `gather` averages the colours that they hit. `find` casts given rays. The functions that Python calls
follow.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from pvphong.base import sobol
from pvphong.base.formulas import ONE, ZERO
from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.shading.kernel.arithmetic import call_stage, inlined, shifted
from pvphong.shading.kernel.code import Library
from pvphong.shading.kernel.evaluation import address
from pvphong.shading.kernel.rays import (
    CASTERS,
    DOUBLES,
    DX,
    DY,
    DZ,
    END,
    GEOMETRY,
    INSTANCE,
    INSTANCE_PART,
    INTEGERS,
    LENGTH,
    MARKS,
    MET,
    MET_COSINE,
    MET_SECOND,
    MET_THIRD,
    NARROW_HITS,
    NX,
    NY,
    NZ,
    OPEN,
    OX,
    OY,
    OZ,
    RAYS,
    SCRATCH,
    SECOND,
    SHORTER,
    SINGLES,
    THIRD,
    TRIANGLE,
    VERTEX,
    WEIGHT,
    WORDS,
    U,
    V,
    are_narrow,
    as_float64,
    bring_near,
    cast_rays,
    given,
    memory,
    prepare,
)


@inlined
def _find(
    count: int,
    function: int,
    scenes: Any,
    numbers: Any,
    firsts: Any,
    triangles: Any,
    rows: Any,
    marks: Any,
    wide: Any,
    valid: Any,
    is_narrow: bool,
) -> None:
    """Find the nearest hit, among all casters, of each of sixteen rays. Rays whose entry `OPEN` is 0 are skipped.

    Write the triangle's number to the row `MET`, −1 for a miss; the weights of its second and third corners and the
    cosine, up to a factor, to the rows `MET_SECOND`, `MET_THIRD` and `MET_COSINE`; and the distance to the row
    `LENGTH`.

    Parameters
    ----------
    count, function, scenes, numbers
        Number of casters, address of `rtcIntersect16`, and the fields `scenes` and `numbers` of `Casters`.
    firsts, triangles
        Fields `starts` and `numbers` of `pvphong.rays.casting.Triangles`.
    rows, marks, wide, valid
        Scratch memory that holds the rays; see `rays`.
    is_narrow : bool
        As for `cast_rays`.
    """
    for j in range(RAYS):
        marks[MET + j] = np.int32(-1)
    for c in range(count):
        bring_near(numbers, c, rows, wide, valid)
        for j in range(RAYS):
            marks[GEOMETRY + j] = np.int32(-1)
            marks[INSTANCE + j] = np.int32(-1)
            marks[INSTANCE_PART + j] = np.int32(-1)
        cast_rays(function, valid, scenes[c], rows, is_narrow)
        for j in range(RAYS):
            if (valid[j] != np.int32(0)) & (marks[GEOMETRY + j] != np.int32(-1)):
                # divided twice: the reciprocal of the scale may overflow
                wide[LENGTH + j] = rows[END + j] / numbers[4 * c + 3] + wide[SHORTER + j] / numbers[4 * c + 3]
                marks[MET + j] = np.int32(triangles[firsts[c] + marks[TRIANGLE + j]])
                rows[MET_SECOND + j], rows[MET_THIRD + j] = rows[SECOND + j], rows[THIRD + j]
                towards = rows[NX + j] * rows[DX + j] + rows[NY + j] * rows[DY + j] + rows[NZ + j] * rows[DZ + j]
                rows[MET_COSINE + j] = towards


# --- compiled functions


def look_around(
    frame: int,
    sample: int,
    numbers: Any,
    origins: Any,
    normals: Any,
    seeds: Any,
    count: int,
    points: Any,
    begin: int,
    end: int,
    casters: int,
    function: int,
    scenes: Any,
    places: Any,
    firsts: Any,
    triangles: Any,
    sides: Any,
    corners: Any,
    met: Any,
    rows: Any,
    marks: Any,
    wide: Any,
    valid: Any,
) -> int:
    """Cast rays from vertices and choose, for each ray, a corner of the triangle that it hits.

    The corner is random, with its barycentric weight as the probability.

    Parameters
    ----------
    frame, sample
        Addresses of the sky's stages, which read `numbers`.
    seeds
        Two seeds per vertex for the sample points, and one for the corners.
    begin, end : int
        Number of the first sample point, and of the point after the last: multiples of 16.
    casters, function, scenes, places, firsts, triangles
        Number of casters, address of `rtcIntersect16`, `scenes` and `numbers` of `Casters`, and `starts` and `numbers`
        of `pvphong.rays.casting.Triangles`.
    sides
        For each triangle 1 if its corners are counter-clockwise seen from the front, −1 if clockwise; 0 without a
        front.
    corners
        Three vertices of each triangle.
    met
        Output, shape (count, end − begin): number of the chosen vertex; −1 if a ray hits nothing or the back of a
        triangle.
    others
        As for `rays.look_at_part`.

    Returns
    -------
    int
        Number of rays cast.
    """
    prepare(rows, marks)
    cast = 0
    for i in range(count):
        for axis in range(3):
            wide[VERTEX + axis], wide[VERTEX + 3 + axis] = origins[3 * i + axis], normals[3 * i + axis]
        call_stage(frame, numbers, rows, wide)
        for first in range(0, end - begin, RAYS):
            own, other = shifted(points, first), shifted(points, end - begin + first)
            for j in range(RAYS):
                rows[U + j] = sobol.coordinate(own[j], seeds[i])
                rows[V + j] = sobol.coordinate(other[j], seeds[count + i])
            call_stage(sample, numbers, rows, wide)
            for j in range(RAYS):
                is_sent = rows[WEIGHT + j] > ZERO
                rows[OPEN + j] = ONE if is_sent else ZERO
                cast += 1 if is_sent else 0
                wide[OX + j], wide[OY + j], wide[OZ + j] = wide[VERTEX], wide[VERTEX + 1], wide[VERTEX + 2]
                wide[LENGTH + j] = np.inf
            narrow = are_narrow(rows, NARROW_HITS)
            _find(casters, function, scenes, places, firsts, triangles, rows, marks, wide, valid, narrow)
            for j in range(RAYS):
                found = np.int32(-1)
                triangle = np.intp(marks[MET + j])
                if triangle >= 0:
                    chance = sobol.random(own[j], seeds[2 * count + i])
                    b, c = rows[MET_SECOND + j], rows[MET_THIRD + j]
                    corner = 1 if chance < b else (2 if chance < b + c else 0)
                    is_front = rows[MET_COSINE + j] * np.float32(sides[triangle]) < ZERO
                    found = np.int32(corners[3 * triangle + corner]) if is_front else np.int32(-1)
                met[(end - begin) * i + np.intp(own[j]) - begin] = found
    return cast


def gather(met: Any, count: int, samples: int, colors: Any, nothing: int, means: Any) -> int:
    """Compute the mean of the colours that the rays of each vertex hit; return `count`.

    Parameters
    ----------
    met
        Output of `look_around` for `count` vertices, with `samples` rays each.
    colors
        Colours of all vertices, then black at index `nothing`.
    means
        Output: mean colour of each vertex.
    """
    share = ONE / np.float32(samples)
    for i in range(count):
        x, y, z = ZERO, ZERO, ZERO
        for k in range(samples * i, samples * (i + 1)):
            vertex = np.intp(met[k])
            place = 3 * (vertex if vertex >= 0 else nothing)
            x, y, z = x + colors[place], y + colors[place + 1], z + colors[place + 2]
        means[3 * i], means[3 * i + 1], means[3 * i + 2] = share * x, share * y, share * z
    return count


def find(
    origins: Any,
    directions: Any,
    lengths: Any,
    count: int,
    casters: int,
    function: int,
    scenes: Any,
    places: Any,
    firsts: Any,
    triangles: Any,
    met: Any,
    weights: Any,
    rows: Any,
    marks: Any,
    wide: Any,
    valid: Any,
) -> int:
    """Find the nearest hit of each of `count` rays, and return `count`.

    Parameters
    ----------
    origins, directions, lengths
        The rays: three numbers for each origin, three for each direction, and one for each length. If a ray hits, the
        distance of the hit replaces the ray's length.
    count : int
        Number of rays.
    casters, function, scenes, places, firsts, triangles
        As for `look_around`.
    met
        Output: number of the triangle that each ray hits, −1 for a miss.
    weights
        Output: barycentric weights of the triangle's second and third corners; not written for a miss.
    rows, marks, wide, valid
        Scratch memory.
    """
    prepare(rows, marks)
    for first in range(0, count, RAYS):
        lanes = given(origins, directions, lengths, first, count, rows, wide)
        _find(casters, function, scenes, places, firsts, triangles, rows, marks, wide, valid, False)
        for j in range(lanes):
            met[first + j] = np.int64(marks[MET + j])
            if marks[MET + j] >= np.int32(0):
                lengths[first + j] = wide[LENGTH + j]
                weights[2 * (first + j)], weights[2 * (first + j) + 1] = rows[MET_SECOND + j], rows[MET_THIRD + j]
    return count


# --- from Python

_FINDERS = *CASTERS, INTEGERS, DOUBLES, INTEGERS, INTEGERS


def around_code(library: Library) -> Callable[..., int]:
    """Return `look_around`, compiled."""
    vertices = types.intp, types.intp, DOUBLES, DOUBLES, DOUBLES, WORDS, types.intp, WORDS, types.intp, types.intp
    return library.call(
        look_around, lambda: types.intp(*vertices, *_FINDERS, types.CPointer(types.int8), INTEGERS, MARKS, *SCRATCH)
    )


def gather_code(library: Library) -> Callable[..., int]:
    """Return `gather`, compiled."""
    return library.call(gather, lambda: types.intp(MARKS, types.intp, types.intp, SINGLES, types.intp, SINGLES))


def find_code(library: Library) -> Callable[..., int]:
    """Return `find`, compiled."""
    rays = DOUBLES, SINGLES, DOUBLES, types.intp
    return library.call(find, lambda: types.intp(*rays, *_FINDERS, INTEGERS, SINGLES, *SCRATCH))


def _finding(casters: Any, all_triangles: Any) -> tuple[int, ...]:
    """Return the arguments `casters`, `function`, `scenes`, `places`, `firsts` and `triangles` of compiled functions.

    They are taken from the fields of `casters`, and from the fields `starts` and `numbers` of `all_triangles`.
    """
    triangles = address(all_triangles.starts), address(all_triangles.numbers)
    return len(casters.scenes), casters.intersect, address(casters.scenes), address(casters.numbers), *triangles


def vertices_met(
    library: Library,
    stages: tuple[int, int],
    numbers: Float64Array,
    origins: Float64Array,
    normals: Float64Array,
    seeds: NDArray[np.uint32],
    begin: int,
    end: int,
    casters: Any,
    triangles: Any,
) -> tuple[NDArray[np.int32], int]:
    """Cast rays from m vertices. Return the vertex that each ray hits, and the number of rays.

    The first result has the shape (m, end − begin). If a ray hits a triangle, its entry is a random corner of the
    triangle, chosen with the corner's barycentric weight as probability. The entry is −1 if the ray hits nothing or the
    back of a triangle.

    Parameters
    ----------
    library, stages, numbers, origins, normals
        As for `rays.part_seen`.
    seeds
        Shape (3, m): two seeds per vertex for the sample points, and one for the corners.
    begin, end : int
        Number of the first sample point, and of the point after the last: multiples of 16, up to `sobol.MOST`.
    casters : Casters
        Geometry.
    triangles : SendingTriangles
        Vertices and front sides of the geometry's triangles.
    """
    count, seeds = len(origins), np.ascontiguousarray(seeds)
    numbers, origins, normals = as_float64(numbers, origins, normals)
    met = np.empty((count, end - begin), np.int32)
    points = sobol.in_squares(begin, end, RAYS)
    of_vertices = *map(address, (numbers, origins, normals, seeds)), count, address(points), begin, end
    among = *_finding(casters, triangles), address(triangles.sides), address(triangles.corners)
    rays = around_code(library)(*stages, *of_vertices, *among, address(met), *memory.addresses)
    return met, rays


def gathered(library: Library, met: NDArray[np.int32], colors: FloatArray) -> FloatArray:
    """Return the mean of the colours that the rays of each vertex hit, shape (m, 3).

    Parameters
    ----------
    library : Library
        Compiled functions.
    met
        Result of `vertices_met`, shape (m, samples), C-contiguous.
    colors
        Shape (n + 1, 3), C-contiguous: colours of the vertices, then black for no hit.
    """
    means = np.empty((len(met), 3), np.float32)
    gather_code(library)(address(met), *met.shape, address(colors), len(colors) - 1, address(means))
    return means


def hits(
    library: Library,
    origins: Float64Array,
    directions: FloatArray,
    lengths: Float64Array,
    casters: Any,
    triangles: Any,
) -> tuple[IntArray, FloatArray, Float64Array]:
    """Find the nearest hit of each ray.

    `origins` and `directions` have the shape (n, 3), `lengths` has (n,). `casters` is a record of type `Casters`, and
    `triangles`, of type `pvphong.rays.casting.Triangles`, numbers the casters' triangles.

    Returns
    -------
    met : ndarray of int
        Shape (n,): number of the triangle; −1 for a miss.
    weights : ndarray
        Shape (n, 2): barycentric weights of the triangle's second and third corners.
    distances : ndarray
        Shape (n,): distance of the hit; infinity for a miss.
    """
    met, weights = np.full(len(directions), -1), np.zeros((len(directions), 2), np.float32)
    origins, far = as_float64(origins, np.array(lengths, np.float64))
    if len(met):
        given = origins, np.ascontiguousarray(directions, np.float32), far
        results = address(met), address(weights)
        find_code(library)(*map(address, given), len(met), *_finding(casters, triangles), *results, *memory.addresses)
    return met, weights, np.where(met >= 0, far, np.inf)
