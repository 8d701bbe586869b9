"""Rays that compiled code generates, sixteen at a time, and tests by calling Embree's functions at their addresses.

There are no arrays of rays. A thread keeps sixteen rays in memory, as an `RTCRay16` of Embree, and writes results per
vertex. A caster is an Embree scene with some of the occluders. In reading order: the memory; `bring_near`, which
transforms rays to the coordinates of a caster; `_test`, the occlusion test; `look_at_part`, which samples many rays
from each vertex to an area light or the sky by two stages; `look_at_point`, which casts one ray from each vertex to a
light without a size; `test`, which tests given rays; and the Python functions that allocate memory and call these.
First hits are in `hits`.

Arguments that functions here and in `hits` share:

- `rows`, `marks`: pointers to the same scratch memory of a thread, as float32 and as int32. `X`, for example, is the
  offset of a row, and `rows[X + j]` its entry for ray `j` of the sixteen
- `wide`: pointer to rows in float64; `valid`: sixteen flags, −1 for rays that Embree tests, else 0
- `casters`, `function`, `scenes`, `places`: number of casters, address of Embree's function, and the fields `scenes`
  and `numbers` of `Casters`
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from pvphong.base import sobol
from pvphong.base.formulas import ONE, ZERO, dot
from pvphong.base.types import BoolArray, Float64Array, FloatArray
from pvphong.geometry.rays import LONGEST, NEAR, begun_near, is_near
from pvphong.optics.area.sampling import Sampling, length_and_direction
from pvphong.shading.kernel.arithmetic import call_stage, inlined, shifted
from pvphong.shading.kernel.code import Library
from pvphong.shading.kernel.evaluation import address

RAYS = 16
"""Number of rays that are tested at once."""

# Sixteen rays in Embree's layout: origin, near end, direction, time, far end, mask, index and flags; and their hits:
# the triangle's normal, the weights of its second and third corner, and the indices of the triangle, the geometry, the
# instance and its part.
X, Y, Z, BEGIN, DX, DY, DZ, TIME, END, MASK, NUMBER, FLAGS = range(0, 12 * RAYS, RAYS)
NX, NY, NZ, SECOND, THIRD, TRIANGLE, GEOMETRY, INSTANCE, INSTANCE_PART = range(12 * RAYS, 21 * RAYS, RAYS)
# Then u and v of each ray, and its sampled relative length and weight. OPEN is 1 for an open ray, which is cast and has
# no hit so far, else 0. MET is the first triangle hit among all casters; then follow the weights of its second and
# third corner, and the cosine between the ray and its normal, up to a factor. FRAME is a vertex's frame: the numbers
# that a light's `frame` returns.
U, V, SHARE, WEIGHT, OPEN, MET, MET_SECOND, MET_THIRD, MET_COSINE, FRAME = range(21 * RAYS, 31 * RAYS, RAYS)
_MOST_IN_FRAME = 30
# Embree's arguments for coherent rays: the flag, all features, and no context or functions.
QUERY = FRAME + 2 * RAYS
_COHERENT, _ALL_FEATURES = np.int32(1 << 16), np.int32(-1)
_ROWS = QUERY + RAYS

NARROW_SHADOWS, NARROW_HITS = np.float32(2.0**-10), np.float32(2.0**-6)
"""Largest spread of sixteen rays for which Embree's traversal of coherent rays is used, in occlusion tests and for
first hits. The spread is that of `are_narrow`; it is half the squared angle of a cone. So the cones' half-angles are
2.5° and 10°: below, this traversal was measured to be faster."""

# In float64: origins and lengths of sixteen rays in the world, and the length by which they are shortened in a caster;
# a vertex's origin and normal, and its ray length and factor.
OX, OY, OZ, LENGTH, SHORTER, VERTEX = range(0, 6 * RAYS, RAYS)
_REACH, _SCALE = 6, 7
_WIDE = VERTEX + RAYS


@intrinsic
def cast_rays(_typing: Any, function: Any, valid: Any, scene: Any, rays: Any, is_narrow: Any) -> Any:  # noqa: ARG001
    """Call Embree's function at the address `function`, `rtcOccluded16` or `rtcIntersect16`.

    It tests the sixteen rays in `rays` with `scene`, the handle of a scene. The flag of a ray in `valid` is −1 if it is
    tested, else 0. If `is_narrow` is True, Embree traverses the scene with the frustum of all rays, which finds the
    same hits.
    """

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        target, which, handle, sixteen, narrow = arguments
        octets, bits = ir.IntType(8).as_pointer(), ir.IntType(64)
        kind = ir.FunctionType(ir.VoidType(), [octets] * 4)
        pointers = builder.bitcast(which, octets), builder.inttoptr(handle, octets), builder.bitcast(sixteen, octets)
        query = builder.bitcast(builder.gep(sixteen, [ir.Constant(bits, QUERY)]), octets)
        options = builder.select(builder.trunc(narrow, ir.IntType(1)), query, ir.Constant(octets, None))
        builder.call(builder.inttoptr(target, kind.as_pointer()), [*pointers, options])
        return ir.Constant(bits, 0)

    return types.intp(types.intp, valid, types.intp, rays, types.boolean), generate


@inlined
def prepare(rows: Any, marks: Any) -> None:
    """Write the fields of Embree's sixteen rays that never change, such as the near end and the mask.

    Write Embree's arguments for coherent rays too.

    `rows` and `marks` point to the same memory, as float32 and as int32.
    """
    for j in range(RAYS):
        rows[BEGIN + j] = ZERO
        rows[TIME + j] = ZERO
        marks[MASK + j] = np.int32(-1)
        marks[NUMBER + j] = np.int32(0)
        marks[FLAGS + j] = np.int32(0)
        marks[QUERY + j] = np.int32(0)
    marks[QUERY], marks[QUERY + 1] = _COHERENT, _ALL_FEATURES


@inlined
def bring_near(numbers: Any, c: int, rows: Any, wide: Any, valid: Any) -> None:
    """Transform sixteen rays from world coordinates to the coordinates of caster number `c`, for Embree.

    Origins and lengths of the rays are read from `wide`, directions from `rows`. `numbers` has four numbers for each
    caster: its centre and scale. An entry of `valid` becomes −1 for an open ray that can hit the caster's triangles,
    else 0. A ray that begins far from the triangles is moved towards them; `wide` receives the length that the ray
    loses.
    """
    mx, my, mz, scale = numbers[4 * c], numbers[4 * c + 1], numbers[4 * c + 2], numbers[4 * c + 3]
    all_near = True
    for j in range(RAYS):
        start = (wide[OX + j] - mx) * scale, (wide[OY + j] - my) * scale, (wide[OZ + j] - mz) * scale
        length = wide[LENGTH + j] * scale
        near = is_near(start, NEAR)
        is_open = rows[OPEN + j] > ZERO
        all_near = all_near & (near | (not is_open))
        rows[X + j], rows[Y + j], rows[Z + j] = np.float32(start[0]), np.float32(start[1]), np.float32(start[2])
        rows[END + j] = np.float32(min(length, LONGEST))
        wide[SHORTER + j] = 0.0
        valid[j] = np.int32(-1) if is_open & near & (length > 0.0) else np.int32(0)
    if not all_near:
        for j in range(RAYS):
            start = (wide[OX + j] - mx) * scale, (wide[OY + j] - my) * scale, (wide[OZ + j] - mz) * scale
            if (rows[OPEN + j] > ZERO) & (not is_near(start, NEAR)):
                direction = np.float64(rows[DX + j]), np.float64(rows[DY + j]), np.float64(rows[DZ + j])
                wide[SHORTER + j] = -begun_near(start, direction, 0.0)[1]
                start, length = begun_near(start, direction, wide[LENGTH + j] * scale)
                rows[X + j], rows[Y + j], rows[Z + j] = (
                    np.float32(start[0]),
                    np.float32(start[1]),
                    np.float32(start[2]),
                )
                rows[END + j] = np.float32(min(length, LONGEST))
                valid[j] = np.int32(-1) if is_near(start, 2.0 * NEAR) & (length > 0.0) else np.int32(0)


@inlined
def given(origins: Any, directions: Any, lengths: Any, first: int, count: int, rows: Any, wide: Any) -> int:
    """Load up to sixteen of `count` given rays, starting with ray number `first`. Return how many were loaded.

    Lengths and origins are written into `wide`, directions into `rows`. A ray whose direction is not finite is not
    open.
    """
    lanes = min(RAYS, count - first)
    for j in range(RAYS):
        i = first + min(j, lanes - 1)
        wide[OX + j], wide[OY + j], wide[OZ + j] = origins[3 * i], origins[3 * i + 1], origins[3 * i + 2]
        wide[LENGTH + j] = lengths[i]
        x, y, z = directions[3 * i], directions[3 * i + 1], directions[3 * i + 2]
        rows[DX + j], rows[DY + j], rows[DZ + j] = x, y, z
        rows[OPEN + j] = ONE if np.isfinite(x + y + z) & (j < lanes) else ZERO
    return lanes


@inlined
def are_narrow(rows: Any, most: Any) -> bool:
    """Return True if sixteen rays that a vertex casts to neighbouring points lie in a cone narrower than `most`.

    The points are ordered along a Morton curve. So one ray of each four gives the spread of all: the mean squared sine
    of the angle to their mean direction. The result depends on the rays of this vertex alone.
    """
    x = (rows[DX] + rows[DX + 5]) + (rows[DX + 10] + rows[DX + 15])
    y = (rows[DY] + rows[DY + 5]) + (rows[DY + 10] + rows[DY + 15])
    z = (rows[DZ] + rows[DZ + 5]) + (rows[DZ + 10] + rows[DZ + 15])
    return x * x + y * y + z * z > np.float32(16.0) * (ONE - most)


@inlined
def _test(
    count: int, function: int, scenes: Any, numbers: Any, rows: Any, wide: Any, valid: Any, is_narrow: bool
) -> None:
    """Test sixteen rays with all casters, and set the entry of the row `OPEN` to 0 for each ray that hits something.

    `count` is the number of casters, and `function` the address of `rtcOccluded16`. `scenes` and `numbers` are fields
    of `Casters`. `is_narrow` is as for `cast_rays`. The other arguments are scratch memory that holds the rays.
    """
    for c in range(count):
        bring_near(numbers, c, rows, wide, valid)
        cast_rays(function, valid, scenes[c], rows, is_narrow)
        for j in range(RAYS):  # Embree sets the far end of an occluded ray to −∞
            if (valid[j] != np.int32(0)) & (rows[END + j] < ZERO):
                rows[OPEN + j] = ZERO


# --- the stages of an area light


def frame_stage(frame: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function for compiled code that calls a light's `frame` for one vertex and writes the result.

    Its arguments are `numbers`, `rows` and `wide`. It reads the vertex's origin and normal from `wide`. It writes the
    first two results, the ray length and the factor, into `wide`, and the others into the row `FRAME`. It returns the
    number of results.
    """

    def compute(numbers: Any, rows: Any, wide: Any) -> int:
        p = wide[VERTEX], wide[VERTEX + 1], wide[VERTEX + 2]
        n = wide[VERTEX + 3], wide[VERTEX + 4], wide[VERTEX + 5]
        found = frame(numbers, p, n)
        wide[VERTEX + _REACH], wide[VERTEX + _SCALE] = found[0], found[1]
        for k in range(2, len(found)):
            rows[FRAME + k - 2] = np.float32(found[k])
        return len(found)

    return compute


@intrinsic
def _frame_of(_typing: Any, rows: Any) -> Any:
    """Return the numbers that `frame_stage` has stored in `rows`, as a tuple of `_MOST_IN_FRAME`.

    The numbers after the end of a shorter frame are not used.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        values = [
            builder.load(builder.gep(arguments[0], [ir.Constant(ir.IntType(64), FRAME + k)]))
            for k in range(_MOST_IN_FRAME)
        ]
        return context.make_tuple(builder, signature.return_type, values)

    return types.UniTuple(rows.dtype, _MOST_IN_FRAME)(rows), generate


def sample_stage(sample: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function for compiled code that samples sixteen rays from a vertex to a light, and returns 1.

    Its arguments are `numbers`, `rows` and `wide`. It reads the vertex's frame and the sixteen pairs u, v of sample
    coordinates from `rows`. It writes directions, relative lengths and weights of the rays into `rows`.
    """

    def choose(numbers: Any, rows: Any, _wide: Any) -> int:
        frame = _frame_of(rows)
        for j in range(RAYS):
            direction, share, weight = sample(numbers, frame, rows[U + j], rows[V + j])
            rows[DX + j], rows[DY + j], rows[DZ + j] = direction
            rows[SHARE + j], rows[WEIGHT + j] = share, weight
        return 1

    return choose


# --- compiled functions


def look_at_part(
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
    margin: Any,
    casters: int,
    function: int,
    scenes: Any,
    places: Any,
    sent: Any,
    seen: Any,
    scales: Any,
    rows: Any,
    marks: Any,
    wide: Any,
    valid: Any,
) -> int:
    """Cast rays from each vertex to the sample points of a light, from number `begin` (inclusive) to `end` (exclusive).

    For each ray, two numbers are written: its weight; and its weight again, or 0 if the ray is blocked.

    Parameters
    ----------
    frame, sample
        Addresses of the light's stages, which read `numbers`.
    origins, normals
        Consecutive vectors of all vertices.
    seeds
        Result of `sobol.seeds`: two seeds for each vertex.
    count : int
        Number of vertices.
    points
        Result of `sobol.in_squares`: the sample points' digits, ordered so that neighbouring rays are cast together.
    margin
        Pointer to the length by which rays end before the light.
    casters, function, scenes, places
        Number of casters, address of `rtcOccluded16`, and the fields `scenes` and `numbers` of `Casters`.
    sent, seen
        Output, shape (end − begin, count): weights, and weights of the rays that are not blocked.
    scales
        Output, shape (count,): factors from mean weights to colours.
    rows, marks, wide, valid
        Scratch memory; `rows` and `marks` are the same memory, as float32 and as int32.

    Returns
    -------
    int
        Number of rays that were cast.
    """
    prepare(rows, marks)
    seconds = shifted(points, (end - begin + RAYS - 1) // RAYS * RAYS)
    cast = 0
    for i in range(count):
        for axis in range(3):
            wide[VERTEX + axis], wide[VERTEX + 3 + axis] = origins[3 * i + axis], normals[3 * i + axis]
        call_stage(frame, numbers, rows, wide)
        scales[i] = wide[VERTEX + _SCALE]
        reach, less, seed, other_seed = wide[VERTEX + _REACH], margin[0], seeds[i], seeds[count + i]
        for first in range(0, end - begin, RAYS):
            lanes, own, other = min(RAYS, end - begin - first), shifted(points, first), shifted(seconds, first)
            for j in range(RAYS):
                rows[U + j] = sobol.coordinate(own[j], seed)
                rows[V + j] = sobol.coordinate(other[j], other_seed)
            call_stage(sample, numbers, rows, wide)
            open_rays = 0
            x, y, z = wide[VERTEX], wide[VERTEX + 1], wide[VERTEX + 2]
            for j in range(RAYS):
                is_sent = (rows[WEIGHT + j] > ZERO) & (j < lanes)
                rows[OPEN + j] = ONE if is_sent else ZERO
                rows[WEIGHT + j] = rows[WEIGHT + j] if is_sent else ZERO
                open_rays += 1 if is_sent else 0
                wide[OX + j], wide[OY + j], wide[OZ + j] = x, y, z
                wide[LENGTH + j] = reach * rows[SHARE + j] - less
            if open_rays > 0:
                _test(casters, function, scenes, places, rows, wide, valid, are_narrow(rows, NARROW_SHADOWS))
            cast += open_rays
            for j in range(lanes):
                place = (np.intp(own[j]) - begin) * count + i
                sent[place], seen[place] = rows[WEIGHT + j], rows[WEIGHT + j] * rows[OPEN + j]
    return cast


def look_at_point(
    points: Any,
    origins: Any,
    origins_behind: Any,
    normals: Any,
    count: int,
    light: Any,
    casters: int,
    function: int,
    scenes: Any,
    places: Any,
    seen: Any,
    behind: Any,
    rows: Any,
    marks: Any,
    wide: Any,
    valid: Any,
    chosen: Any,
) -> int:
    """Cast a ray from each vertex to a light without a size, and write 1 if it arrives, or 0 if it is blocked.

    Vertices that face away from the light get 0 without a ray. Return the number of rays.

    Parameters
    ----------
    points, origins, origins_behind, normals
        Vectors of all vertices. Rays start at the origins; the points determine which vertices face the light.
    light
        Seven numbers: the light's position or the direction to the light; 1 for a position, 0 for a direction; 1 if
        vertices are two-sided, else 0; the height of the rays' start above the origins; the length by which the rays
        end before the light.
    seen, behind
        Output for the vertices' front sides and back sides. `behind` is written only if vertices are two-sided.
    chosen
        Scratch memory for the vertices of sixteen rays, and for the vertices' sides.
    others
        As for `look_at_part`.
    """
    prepare(rows, marks)
    has_place, two_sided, above, margin = light[3] > 0.0, light[4] > 0.0, light[5], light[6]
    lanes = 0
    cast = 0
    for i in range(count):
        n = normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]
        p = points[3 * i], points[3 * i + 1], points[3 * i + 2]
        to_light = light[0], light[1], light[2]
        if has_place:
            to_light = light[0] - p[0], light[1] - p[1], light[2] - p[2]
        facing = dot(n, to_light)
        seen[i] = 0.0
        if two_sided:
            behind[i] = 0.0
        side = 1.0 if facing > 0.0 else (-1.0 if (facing < 0.0) & two_sided else 0.0)
        if side != 0.0:
            begin = origins if side > 0.0 else origins_behind
            x = begin[3 * i] + above * side * n[0]
            y = begin[3 * i + 1] + above * side * n[1]
            z = begin[3 * i + 2] + above * side * n[2]
            length = np.inf
            direction = light[0], light[1], light[2]
            if has_place:
                length, direction = length_and_direction((light[0] - x, light[1] - y, light[2] - z))
            wide[OX + lanes], wide[OY + lanes], wide[OZ + lanes], wide[LENGTH + lanes] = x, y, z, length - margin
            rows[DX + lanes], rows[DY + lanes], rows[DZ + lanes] = (
                np.float32(direction[0]),
                np.float32(direction[1]),
                np.float32(direction[2]),
            )
            rows[OPEN + lanes] = ONE
            chosen[lanes], chosen[RAYS + lanes] = i, np.intp(side)
            lanes += 1
        if (lanes == RAYS) | ((i == count - 1) & (lanes > 0)):
            for j in range(lanes, RAYS):
                rows[OPEN + j] = ZERO
            _test(casters, function, scenes, places, rows, wide, valid, False)
            for j in range(lanes):
                if chosen[RAYS + j] > 0:
                    seen[chosen[j]] = rows[OPEN + j]
                else:
                    behind[chosen[j]] = rows[OPEN + j]
            cast += lanes
            lanes = 0
    return cast


def test(
    origins: Any,
    directions: Any,
    lengths: Any,
    count: int,
    casters: int,
    function: int,
    scenes: Any,
    places: Any,
    blocked: Any,
    rows: Any,
    marks: Any,
    wide: Any,
    valid: Any,
) -> int:
    """Test `count` rays for occlusion by all casters, and return `count`.

    Parameters
    ----------
    origins, directions, lengths
        The rays: three numbers for each origin, three for each direction, and one for each length.
    count : int
        Number of rays.
    casters, function, scenes, places
        Number of casters, address of `rtcOccluded16`, and the fields `scenes` and `numbers` of `Casters`.
    blocked
        Output: a byte per ray, 1 if it is blocked, 0 if it is not or if its direction is not finite.
    rows, marks, wide, valid
        Scratch memory.
    """
    prepare(rows, marks)
    for first in range(0, count, RAYS):
        lanes = given(origins, directions, lengths, first, count, rows, wide)
        _test(casters, function, scenes, places, rows, wide, valid, False)
        for j in range(lanes):
            is_finite = np.isfinite(rows[DX + j] + rows[DY + j] + rows[DZ + j])
            blocked[first + j] = (rows[OPEN + j] == ZERO) & is_finite
    return count


# --- from Python


class _Memory(threading.local):
    """Scratch memory of each thread, aligned as Embree requires."""

    def __init__(self) -> None:
        self._memory = np.zeros(4 * _ROWS + 8 * _WIDE + 20 * RAYS + 64, np.uint8)
        rows = address(self._memory) + -address(self._memory) % 64
        wide, valid = rows + 4 * _ROWS, rows + 4 * _ROWS + 8 * _WIDE
        self.addresses = rows, rows, wide, valid
        self.chosen = valid + 4 * RAYS


memory = _Memory()

SINGLES, DOUBLES, INTEGERS = map(types.CPointer, (types.float32, types.float64, types.intp))
WORDS, MARKS, _BYTES = map(types.CPointer, (types.uint32, types.int32, types.uint8))
SCRATCH = SINGLES, MARKS, DOUBLES, MARKS
CASTERS = types.intp, types.intp


def part_code(library: Library) -> Callable[..., int]:
    """Return the compiled `look_at_part`."""
    stages, integers = (types.intp, types.intp, DOUBLES), (types.intp,) * 2
    vertices = DOUBLES, DOUBLES, WORDS, types.intp, WORDS
    results = SINGLES, SINGLES, DOUBLES
    kinds = *stages, *vertices, *integers, DOUBLES, *CASTERS, INTEGERS, DOUBLES, *results, *SCRATCH
    return library.call(look_at_part, lambda: types.intp(*kinds))


def point_code(library: Library) -> Callable[..., int]:
    """Return the compiled `look_at_point`."""
    vertices = DOUBLES, DOUBLES, DOUBLES, DOUBLES, types.intp
    kinds = *vertices, DOUBLES, *CASTERS, INTEGERS, DOUBLES, DOUBLES, DOUBLES, *SCRATCH, INTEGERS
    return library.call(look_at_point, lambda: types.intp(*kinds))


def test_code(library: Library) -> Callable[..., int]:
    """Return the compiled `test`."""
    rays = DOUBLES, SINGLES, DOUBLES, types.intp
    return library.call(test, lambda: types.intp(*rays, *CASTERS, INTEGERS, DOUBLES, _BYTES, *SCRATCH))


def stages_of(library: Library, sampling: Sampling) -> tuple[int, int]:
    """Return the addresses of the compiled functions `frame` and `sample` of a light's sampling."""
    stages = frame_stage(sampling.frame), sample_stage(sampling.sample)
    frame, sample = (library.stage(stage, "float32") for stage in stages)
    return frame, sample


def as_float64(*arrays: Any) -> list[Float64Array]:
    """Return the arrays as C-contiguous float64, which compiled code reads."""
    return [np.ascontiguousarray(array, np.float64) for array in arrays]


def _testing(casters: Any) -> tuple[int, ...]:
    """Return the arguments `casters`, `function`, `scenes` and `places` of compiled occlusion tests.

    They are taken from the fields of `casters`.
    """
    return len(casters.scenes), casters.occluded, address(casters.scenes), address(casters.numbers)


def part_seen(
    library: Library,
    stages: tuple[int, int],
    numbers: Float64Array,
    origins: Float64Array,
    normals: Float64Array,
    seeds: NDArray[np.uint32],
    begin: int,
    end: int,
    margin: float,
    casters: Any,
) -> tuple[FloatArray, FloatArray, Float64Array, int]:
    """Cast rays from m vertices to the sample points of an area light or of the sky.

    Parameters
    ----------
    library : Library
        Source of compiled code.
    stages
        Result of `stages_of`.
    numbers
        Numbers that the light's formulas read.
    origins, normals
        Origins of rays, and unit normals of the vertices, shape (m, 3).
    seeds
        Shape (2, m): result of `sobol.seeds` for the vertices.
    begin, end : int
        Number of the first sample point, and of the point after the last, up to `sobol.MOST`. `begin` is a multiple of
        16. If further points follow, so is `end`.
    margin : float
        Length by which rays end before the light.
    casters : Casters
        Occluders.

    Returns
    -------
    sent, seen : ndarray
        Shape (end − begin, m), float32: the weight of each ray; and the weight again, or 0 if the ray is blocked.
    scales : ndarray
        Shape (m,): factors from mean weights to colours.
    rays : int
        Number of rays that were cast.
    """
    count, seeds = len(origins), np.ascontiguousarray(seeds)
    numbers, origins, normals = as_float64(numbers, origins, normals)
    sent, seen = np.empty((end - begin, count), np.float32), np.empty((end - begin, count), np.float32)
    scales = np.empty(count)
    ends, points = np.array([margin]), sobol.in_squares(begin, end, RAYS)
    of_vertices = *map(address, (numbers, origins, normals, seeds)), count, address(points), begin, end, address(ends)
    results = map(address, (sent, seen, scales))
    rays = part_code(library)(*stages, *of_vertices, *_testing(casters), *results, *memory.addresses)
    return sent, seen, scales, rays


def point_seen(
    library: Library,
    points: Float64Array,
    origins: Float64Array,
    origins_behind: Float64Array,
    normals: Float64Array,
    light: Float64Array,
    casters: Any,
    seen: Float64Array,
    behind: Float64Array,
) -> int:
    """Cast a ray from each of m vertices to a light without a size, and return the number of rays.

    Points, origins and normals have the shape (m, 3). `light` has the seven numbers that `look_at_point` reads. `seen`
    receives 1 for a vertex whose ray arrives, and 0 for a vertex whose ray is blocked or that faces away from the
    light. If the vertices are two-sided, `behind` receives the same for their back sides. Both outputs are contiguous
    arrays of shape (m,). `origins_behind` are the origins on the back sides, and `casters` the occluders.
    """
    *given, numbers = as_float64(points, origins, origins_behind, normals, light)
    vertices = *map(address, given), len(points), address(numbers)
    results = address(seen), address(behind), *memory.addresses, memory.chosen
    return point_code(library)(*vertices, *_testing(casters), *results)


def blocked(
    library: Library, origins: Float64Array, directions: FloatArray, lengths: Float64Array, casters: Any
) -> BoolArray:
    """Return True for each ray that a triangle of the casters blocks, shape (n,).

    `origins` and `directions` have the shape (n, 3), `lengths` has (n,). `casters` is a record of type `Casters`.
    """
    found = np.zeros(len(directions), bool)
    if not len(found):
        return found
    origins, lengths = as_float64(origins, lengths)
    given = origins, np.ascontiguousarray(directions, np.float32), lengths
    test_code(library)(*map(address, given), len(found), *_testing(casters), address(found), *memory.addresses)
    return found
