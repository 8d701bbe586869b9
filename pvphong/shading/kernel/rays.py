"""Rays made in compiled code, sixteen at a time, and tested by Embree through addresses of its functions.

There are no arrays of rays: sixteen are in memory that a thread keeps, as Embree's `RTCRay16` has them, and what comes
out of them is written for each vertex. In reading order: the memory; `_begin`, which brings rays from anywhere to the
coordinates of a caster; `_test`, whether they meet anything, and `_find`, what they meet first; `look_at_part`, many
rays from each vertex to a light with a size or to the sky, chosen by its two stages; `look_at_point`, one ray from each
vertex to a light without one; `look_around`, many rays from each vertex to what is around it; `test` and `find`, rays
that are given; and the functions of Python's that share out memory and call them.
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
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray
from pvphong.geometry.rays import LONGEST, NEAR, begun_near, is_near
from pvphong.optics.area.sampling import Sampling, length_and_direction
from pvphong.shading.kernel.arithmetic import call_stage, inlined, shifted
from pvphong.shading.kernel.code import Library
from pvphong.shading.kernel.evaluation import address

LANES = 16
"""So many rays are tested at once."""

# Sixteen rays as Embree has them: the origin, where they begin, the direction, the time, where they end, a mask, a
# number and flags; and what they meet: the triangle's normal, the weights of its second and third corner, its number,
# the number of the geometry, of the instance and of its part.
X, Y, Z, BEGIN, DX, DY, DZ, TIME, END, MASK, NUMBER, FLAGS = range(0, 12 * LANES, LANES)
NX, NY, NZ, SECOND, THIRD, TRIANGLE, GEOMETRY, INSTANCE, INSTANCE_PART = range(12 * LANES, 21 * LANES, LANES)
# Then u and v of each, the length as a share and the weight that are chosen, 1 where nothing has been met; the triangle
# that is met first, in all casters, the weights of its second and third corner, and the cosine between the ray and its
# normal, but for a factor; and what the frame of a vertex has.
U, V, SHARE, WEIGHT, OPEN, MET, MET_SECOND, MET_THIRD, MET_COSINE, FRAME = range(21 * LANES, 31 * LANES, LANES)
_MOST_IN_FRAME = 30
_ROWS = FRAME + 2 * LANES

# In float64: origins and lengths of sixteen rays in the world, and by how much they are shorter in a caster than there;
# a vertex's origin and normal, and its length and factor.
OX, OY, OZ, LENGTH, SHORTER, VERTEX = range(0, 6 * LANES, LANES)
_REACH, _SCALE = 6, 7
_WIDE = VERTEX + LANES


@intrinsic
def _cast(_typing: Any, function: Any, valid: Any, scene: Any, rays: Any) -> Any:  # noqa: ARG001
    """Call `rtcOccluded16` or `rtcIntersect16`, without options."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        target, which, handle, sixteen = arguments
        octets = ir.IntType(8).as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [octets] * 4)
        pointers = builder.bitcast(which, octets), builder.inttoptr(handle, octets), builder.bitcast(sixteen, octets)
        builder.call(builder.inttoptr(target, kind.as_pointer()), [*pointers, ir.Constant(octets, None)])
        return ir.Constant(ir.IntType(64), 0)

    return types.intp(types.intp, valid, types.intp, rays), generate


@inlined
def _prepare(rows: Any, marks: Any) -> None:
    """What is the same for all rays."""
    for j in range(LANES):
        rows[BEGIN + j] = ZERO
        rows[TIME + j] = ZERO
        marks[MASK + j] = np.int32(-1)
        marks[NUMBER + j] = np.int32(0)
        marks[FLAGS + j] = np.int32(0)


@inlined
def _begin(numbers: Any, c: int, rows: Any, wide: Any, valid: Any) -> None:
    """Bring open rays to the coordinates of a caster, and mark those that can meet it."""
    mx, my, mz, scale = numbers[4 * c], numbers[4 * c + 1], numbers[4 * c + 2], numbers[4 * c + 3]
    all_near = True
    for j in range(LANES):
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
        for j in range(LANES):
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
def _test(count: int, function: int, scenes: Any, numbers: Any, rows: Any, wide: Any, valid: Any) -> None:
    """Close rays that are open and meet something."""
    for c in range(count):
        _begin(numbers, c, rows, wide, valid)
        _cast(function, valid, scenes[c], rows)
        for j in range(LANES):  # Embree marks what is met by an end at minus infinity
            if (valid[j] != np.int32(0)) & (rows[END + j] < ZERO):
                rows[OPEN + j] = ZERO


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
) -> None:
    """Find what open rays meet first: `MET` and what follows it, −1 for nothing; `LENGTH` becomes how far that is."""
    for j in range(LANES):
        marks[MET + j] = np.int32(-1)
    for c in range(count):
        _begin(numbers, c, rows, wide, valid)
        for j in range(LANES):
            marks[GEOMETRY + j] = np.int32(-1)
            marks[INSTANCE + j] = np.int32(-1)
            marks[INSTANCE_PART + j] = np.int32(-1)
        _cast(function, valid, scenes[c], rows)
        for j in range(LANES):
            if (valid[j] != np.int32(0)) & (marks[GEOMETRY + j] != np.int32(-1)):
                # divided twice, for a scale may have no reciprocal
                wide[LENGTH + j] = rows[END + j] / numbers[4 * c + 3] + wide[SHORTER + j] / numbers[4 * c + 3]
                marks[MET + j] = np.int32(triangles[firsts[c] + marks[TRIANGLE + j]])
                rows[MET_SECOND + j], rows[MET_THIRD + j] = rows[SECOND + j], rows[THIRD + j]
                towards = rows[NX + j] * rows[DX + j] + rows[NY + j] * rows[DY + j] + rows[NZ + j] * rows[DZ + j]
                rows[MET_COSINE + j] = towards


# --- the stages of a light with a size


def frame_stage(frame: Callable[..., Any]) -> Callable[..., Any]:
    """(numbers, rows, wide) → int: writes what a light's `frame` gives of a vertex."""

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
    """The frame in a row, as a tuple."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        values = [
            builder.load(builder.gep(arguments[0], [ir.Constant(ir.IntType(64), FRAME + k)]))
            for k in range(_MOST_IN_FRAME)
        ]
        return context.make_tuple(builder, signature.return_type, values)

    return types.UniTuple(rows.dtype, _MOST_IN_FRAME)(rows), generate


def sample_stage(sample: Callable[..., Any]) -> Callable[..., Any]:
    """(numbers, rows, wide) → int: writes directions, shares of the length, and weights of sixteen rays."""

    def choose(numbers: Any, rows: Any, _wide: Any) -> int:
        frame = _frame_of(rows)
        for j in range(LANES):
            direction, share, weight = sample(numbers, frame, rows[U + j], rows[V + j])
            rows[DX + j], rows[DY + j], rows[DZ + j] = direction
            rows[SHARE + j], rows[WEIGHT + j] = share, weight
        return 1

    return choose


# --- what is compiled


def look_at_part(
    frame: int,
    sample: int,
    numbers: Any,
    origins: Any,
    normals: Any,
    seeds: Any,
    second: Any,
    count: int,
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
    """What vertices get from points with the numbers from `begin` to `end` of a light, and what of it they see.

    Parameters
    ----------
    frame, sample
        Addresses of the light's stages, which read `numbers`.
    origins, normals
        Vectors of all vertices, one after the other.
    seeds, second
        What `sobol.seeds` gives, and `sobol.SECOND`.
    count : int
        Of vertices.
    margin
        A pointer to the length by which rays end before the light.
    casters, function, scenes, places
        How many casters, and what `Casters` has.
    sent, seen
        Shape (end − begin, count), filled in.
    scales
        Shape (count,), filled in: factors that make means of weights colours.
    rows, marks, wide, valid
        Scratch memory; the first two are the same.

    Returns
    -------
    int
        How many rays were cast.
    """
    _prepare(rows, marks)
    cast = 0
    for i in range(count):
        for axis in range(3):
            wide[VERTEX + axis], wide[VERTEX + 3 + axis] = origins[3 * i + axis], normals[3 * i + axis]
        call_stage(frame, numbers, rows, wide)
        scales[i] = wide[VERTEX + _SCALE]
        reach, less, seed, other_seed = wide[VERTEX + _REACH], margin[0], seeds[i], seeds[count + i]
        for first in range(begin, end, LANES):
            lanes, own = min(LANES, end - first), shifted(second, first)
            for j in range(LANES):
                rows[U + j] = sobol.coordinate(np.uint32(first + j), seed)
                rows[V + j] = sobol.coordinate(own[j], other_seed)
            call_stage(sample, numbers, rows, wide)
            open_rays = 0
            x, y, z = wide[VERTEX], wide[VERTEX + 1], wide[VERTEX + 2]
            for j in range(LANES):
                is_sent = (rows[WEIGHT + j] > ZERO) & (j < lanes)
                rows[OPEN + j] = ONE if is_sent else ZERO
                rows[WEIGHT + j] = rows[WEIGHT + j] if is_sent else ZERO
                open_rays += 1 if is_sent else 0
                wide[OX + j], wide[OY + j], wide[OZ + j] = x, y, z
                wide[LENGTH + j] = reach * rows[SHARE + j] - less
            if open_rays > 0:
                _test(casters, function, scenes, places, rows, wide, valid)
            cast += open_rays
            for j in range(lanes):
                place = (first - begin + j) * count + i
                sent[place], seen[place] = rows[WEIGHT + j], rows[WEIGHT + j] * rows[OPEN + j]
    return cast


def look_at_point(
    points: Any,
    origins: Any,
    normals: Any,
    count: int,
    light: Any,
    casters: int,
    function: int,
    scenes: Any,
    places: Any,
    seen: Any,
    rows: Any,
    marks: Any,
    wide: Any,
    valid: Any,
    chosen: Any,
) -> int:
    """Whether vertices see a light without a size, one ray each: 1 or 0; 0 where they face away. It gives the rays.

    Parameters
    ----------
    points, origins, normals
        Vectors of all vertices; rays begin at origins, and whether a vertex faces the light is decided at its point.
    light
        The light's place, or the direction to it; 1 if it is a place; 1 if vertices see from both sides; how far above
        the origins rays begin; by what length they end before the light.
    seen
        Filled in.
    chosen
        Scratch memory for the vertices of sixteen rays.
    others
        As for `look_at_part`.
    """
    _prepare(rows, marks)
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
        side = 1.0 if facing > 0.0 else (-1.0 if (facing < 0.0) & two_sided else 0.0)
        if side != 0.0:
            x = origins[3 * i] + above * side * n[0]
            y = origins[3 * i + 1] + above * side * n[1]
            z = origins[3 * i + 2] + above * side * n[2]
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
            chosen[lanes] = i
            lanes += 1
        if (lanes == LANES) | ((i == count - 1) & (lanes > 0)):
            for j in range(lanes, LANES):
                rows[OPEN + j] = ZERO
            _test(casters, function, scenes, places, rows, wide, valid)
            for j in range(lanes):
                seen[chosen[j]] = rows[OPEN + j]
            cast += lanes
            lanes = 0
    return cast


def look_around(
    frame: int,
    sample: int,
    numbers: Any,
    origins: Any,
    normals: Any,
    seeds: Any,
    second: Any,
    count: int,
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
    """Which vertices see which: of the triangle that a ray meets one corner, by chance, as often as its weight says.

    Parameters
    ----------
    frame, sample
        Addresses of the sky's stages, which read `numbers`.
    seeds
        Two for the points, and one for the corners.
    begin, end : int
        Numbers of points, multiples of 16.
    casters, function, scenes, places, firsts, triangles
        How many casters, the address of `rtcIntersect16`, what `Casters` has, and the numbers of their triangles.
    sides
        For each triangle 1 or −1, as its front is where its corners go round to the left or to the right; 0 where it
        has none.
    corners
        Numbers of the three vertices of each.
    met
        Shape (count, end − begin), filled in: the number of a vertex; −1 where nothing is met, −2 where it is a back.
    others
        As for `look_at_part`.

    Returns
    -------
    int
        How many rays were cast.
    """
    _prepare(rows, marks)
    cast = 0
    for i in range(count):
        for axis in range(3):
            wide[VERTEX + axis], wide[VERTEX + 3 + axis] = origins[3 * i + axis], normals[3 * i + axis]
        call_stage(frame, numbers, rows, wide)
        for first in range(begin, end, LANES):
            own = shifted(second, first)
            for j in range(LANES):
                rows[U + j] = sobol.coordinate(np.uint32(first + j), seeds[i])
                rows[V + j] = sobol.coordinate(own[j], seeds[count + i])
            call_stage(sample, numbers, rows, wide)
            for j in range(LANES):
                is_sent = rows[WEIGHT + j] > ZERO
                rows[OPEN + j] = ONE if is_sent else ZERO
                cast += 1 if is_sent else 0
                wide[OX + j], wide[OY + j], wide[OZ + j] = wide[VERTEX], wide[VERTEX + 1], wide[VERTEX + 2]
                wide[LENGTH + j] = np.inf
            _find(casters, function, scenes, places, firsts, triangles, rows, marks, wide, valid)
            for j in range(LANES):
                found = np.int32(-1)
                triangle = np.intp(marks[MET + j])
                if triangle >= 0:
                    chance = sobol.random(np.uint32(first + j), seeds[2 * count + i])
                    b, c = rows[MET_SECOND + j], rows[MET_THIRD + j]
                    corner = 1 if chance < b else (2 if chance < b + c else 0)
                    is_front = rows[MET_COSINE + j] * np.float32(sides[triangle]) < ZERO
                    found = np.int32(corners[3 * triangle + corner]) if is_front else np.int32(-2)
                met[(end - begin) * i + first - begin + j] = found
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
    """Whether given rays are blocked."""
    _prepare(rows, marks)
    for first in range(0, count, LANES):
        lanes = min(LANES, count - first)
        for j in range(LANES):
            i = first + min(j, lanes - 1)
            wide[OX + j], wide[OY + j], wide[OZ + j] = origins[3 * i], origins[3 * i + 1], origins[3 * i + 2]
            wide[LENGTH + j] = lengths[i]
            x, y, z = directions[3 * i], directions[3 * i + 1], directions[3 * i + 2]
            rows[DX + j], rows[DY + j], rows[DZ + j] = x, y, z
            rows[OPEN + j] = ONE if np.isfinite(x + y + z) & (j < lanes) else ZERO
        _test(casters, function, scenes, places, rows, wide, valid)
        for j in range(lanes):
            is_finite = np.isfinite(rows[DX + j] + rows[DY + j] + rows[DZ + j])
            blocked[first + j] = (rows[OPEN + j] == ZERO) & is_finite
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
    """What given rays meet first: triangles, weights of their second and third corners; lengths are filled in too."""
    _prepare(rows, marks)
    for first in range(0, count, LANES):
        lanes = min(LANES, count - first)
        for j in range(LANES):
            i = first + min(j, lanes - 1)
            wide[OX + j], wide[OY + j], wide[OZ + j] = origins[3 * i], origins[3 * i + 1], origins[3 * i + 2]
            wide[LENGTH + j] = lengths[i]
            x, y, z = directions[3 * i], directions[3 * i + 1], directions[3 * i + 2]
            rows[DX + j], rows[DY + j], rows[DZ + j] = x, y, z
            rows[OPEN + j] = ONE if np.isfinite(x + y + z) & (j < lanes) else ZERO
        _find(casters, function, scenes, places, firsts, triangles, rows, marks, wide, valid)
        for j in range(lanes):
            met[first + j] = np.int64(marks[MET + j])
            if marks[MET + j] >= np.int32(0):
                lengths[first + j] = wide[LENGTH + j]
                weights[2 * (first + j)], weights[2 * (first + j) + 1] = rows[MET_SECOND + j], rows[MET_THIRD + j]
    return count


# --- from Python


class _Memory(threading.local):
    """Scratch memory, each thread's own, which starts where Embree wants it to."""

    def __init__(self) -> None:
        self._memory = np.zeros(4 * _ROWS + 8 * _WIDE + 12 * LANES + 64, np.uint8)
        rows = address(self._memory) + -address(self._memory) % 64
        wide, valid = rows + 4 * _ROWS, rows + 4 * _ROWS + 8 * _WIDE
        self.addresses = rows, rows, wide, valid
        self.chosen = valid + 4 * LANES


_memory = _Memory()

_SINGLES, _DOUBLES, _INTEGERS = map(types.CPointer, (types.float32, types.float64, types.intp))
_WORDS, _MARKS, _BYTES, _SIDES = map(types.CPointer, (types.uint32, types.int32, types.uint8, types.int8))
_SCRATCH = _SINGLES, _MARKS, _DOUBLES, _MARKS
_CASTERS = types.intp, types.intp


def part_code(library: Library) -> Callable[..., int]:
    """`look_at_part`, compiled."""
    stages, integers = (types.intp, types.intp, _DOUBLES), (types.intp,) * 3
    vertices = _DOUBLES, _DOUBLES, _WORDS, _WORDS
    results = _SINGLES, _SINGLES, _DOUBLES
    kinds = *stages, *vertices, *integers, _DOUBLES, *_CASTERS, _INTEGERS, _DOUBLES, *results, *_SCRATCH
    return library.call(look_at_part, lambda: types.intp(*kinds))


def point_code(library: Library) -> Callable[..., int]:
    """`look_at_point`, compiled."""
    vertices = _DOUBLES, _DOUBLES, _DOUBLES, types.intp
    kinds = *vertices, _DOUBLES, *_CASTERS, _INTEGERS, _DOUBLES, _DOUBLES, *_SCRATCH, _INTEGERS
    return library.call(look_at_point, lambda: types.intp(*kinds))


def test_code(library: Library) -> Callable[..., int]:
    """`test`, compiled."""
    rays = _DOUBLES, _SINGLES, _DOUBLES, types.intp
    return library.call(test, lambda: types.intp(*rays, *_CASTERS, _INTEGERS, _DOUBLES, _BYTES, *_SCRATCH))


_FINDERS = *_CASTERS, _INTEGERS, _DOUBLES, _INTEGERS, _INTEGERS


def around_code(library: Library) -> Callable[..., int]:
    """`look_around`, compiled."""
    vertices = types.intp, types.intp, _DOUBLES, _DOUBLES, _DOUBLES, _WORDS, _WORDS, *(types.intp,) * 3
    return library.call(look_around, lambda: types.intp(*vertices, *_FINDERS, _SIDES, _INTEGERS, _MARKS, *_SCRATCH))


def find_code(library: Library) -> Callable[..., int]:
    """`find`, compiled."""
    rays = _DOUBLES, _SINGLES, _DOUBLES, types.intp
    return library.call(find, lambda: types.intp(*rays, *_FINDERS, _INTEGERS, _SINGLES, *_SCRATCH))


def stages_of(library: Library, sampling: Sampling) -> tuple[int, int]:
    """Addresses of the code of a light's two formulas."""
    stages = frame_stage(sampling.frame), sample_stage(sampling.sample)
    frame, sample = (library.stage(stage, "float32") for stage in stages)
    return frame, sample


def _plain(*arrays: Any) -> list[Float64Array]:
    """Numbers as compiled code reads them, one after the other."""
    return [np.ascontiguousarray(array, np.float64) for array in arrays]


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
    """What is sent and seen, (end − begin, m) each, float32, factors (m,), and the number of rays.

    Parameters
    ----------
    library : Library
        Compiles.
    stages
        What `stages_of` gives.
    numbers
        What the light's formulas read.
    origins, normals
        Shape (m, 3).
    seeds
        Shape (2, m).
    begin, end : int
        Numbers of points, multiples of 16 or the last, up to `sobol.MOST`.
    margin : float
        Rays end so far before the light.
    casters : Casters
        What blocks them.
    """
    count, seeds = len(origins), np.ascontiguousarray(seeds)
    numbers, origins, normals = _plain(numbers, origins, normals)
    sent, seen = np.empty((end - begin, count), np.float32), np.empty((end - begin, count), np.float32)
    scales = np.empty(count)
    ends = np.array([margin])
    of_vertices = *map(address, (numbers, origins, normals, seeds, sobol.SECOND)), count, begin, end, address(ends)
    among = len(casters.scenes), casters.function, address(casters.scenes), address(casters.numbers)
    results = map(address, (sent, seen, scales))
    rays = part_code(library)(*stages, *of_vertices, *among, *results, *_memory.addresses)
    return sent, seen, scales, rays


def point_seen(
    library: Library,
    points: Float64Array,
    origins: Float64Array,
    normals: Float64Array,
    light: Float64Array,
    casters: Any,
    seen: Float64Array,
) -> int:
    """Fill in which vertices see a light, `seen`, shape (m,), contiguous; the number of rays is given.

    Points, origins and normals have the shape (m, 3); numbers of the light are those that `look_at_point` reads.
    """
    given = _plain(points, origins, normals, light)
    vertices = *map(address, given[:3]), len(points), address(given[3])
    among = len(casters.scenes), casters.function, address(casters.scenes), address(casters.numbers)
    return point_code(library)(*vertices, *among, address(seen), *_memory.addresses, _memory.chosen)


def blocked(
    library: Library, origins: Float64Array, directions: FloatArray, lengths: Float64Array, casters: Any
) -> BoolArray:
    """Which of given rays are blocked."""
    found = np.zeros(len(directions), bool)
    if not len(found):
        return found
    origins, lengths = _plain(origins, lengths)
    given = origins, np.ascontiguousarray(directions, np.float32), lengths
    among = len(casters.scenes), casters.function, address(casters.scenes), address(casters.numbers)
    test_code(library)(*map(address, given), len(found), *among, address(found), *_memory.addresses)
    return found


def _among(casters: Any, first: Any) -> tuple[int, ...]:
    """Casters as `look_around` and `find` take them."""
    triangles = address(first.starts), address(first.numbers)
    return len(casters.scenes), casters.function_of_find, address(casters.scenes), address(casters.numbers), *triangles


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
    """Which vertices are met, shape (m, end − begin), as `look_around` has it, and the number of rays.

    Parameters
    ----------
    library, stages, numbers, origins, normals
        As for `part_seen`.
    seeds
        Shape (3, m).
    begin, end : int
        Numbers of points, multiples of 16, up to `sobol.MOST`.
    casters : Casters
        What is met.
    triangles : Triangles
        What is known of it.
    """
    count, seeds = len(origins), np.ascontiguousarray(seeds)
    numbers, origins, normals = _plain(numbers, origins, normals)
    met = np.empty((count, end - begin), np.int32)
    of_vertices = *map(address, (numbers, origins, normals, seeds, sobol.SECOND)), count, begin, end
    among = *_among(casters, triangles), address(triangles.sides), address(triangles.corners)
    rays = around_code(library)(*stages, *of_vertices, *among, address(met), *_memory.addresses)
    return met, rays


def hits(
    library: Library,
    origins: Float64Array,
    directions: FloatArray,
    lengths: Float64Array,
    casters: Any,
    triangles: Any,
) -> tuple[IntArray, FloatArray, Float64Array]:
    """What given rays meet first: numbers of triangles (n,), −1 for none; weights (n, 2), and how far (n,)."""
    met, weights = np.full(len(directions), -1), np.zeros((len(directions), 2), np.float32)
    origins, far = _plain(origins, np.array(lengths, np.float64))
    if len(met):
        given = origins, np.ascontiguousarray(directions, np.float32), far
        results = address(met), address(weights)
        find_code(library)(*map(address, given), len(met), *_among(casters, triangles), *results, *_memory.addresses)
    return met, weights, np.where(met >= 0, far, np.inf)
