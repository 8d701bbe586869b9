"""A block of vertices: where their values are, how they are loaded, and the directions from them to a position.

A block's values are in scratch memory, row after row, in the type of the arithmetic. Points are there too where that
type holds them, else beside them in float64. Vectors of any length are taken: where squares of them could leave the
range of floats, they are first scaled by powers of two, each by its own. That is exact, so a vertex has the same bits
in any unit of length. What is zero or not finite becomes a zero vector, and light on it 0.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from pvphong.base.formulas import LEAST_SQUARE, ONE, ZERO, cross, dot, inverse_length, square, times
from pvphong.shading.kernel.arithmetic import compiled, inlined, is_nowhere, like, shifted

# --- rows


# Vertices in a block: a multiple of every vector's length, and few enough that the rows in use stay in 32 KiB
# of first-level cache.
BLOCK = 128

# Colour. Where maps of colours multiply its parts: what takes albedo and diffuse, and the rest of what lights add.
R, G, B, OTHER_R, OTHER_G, OTHER_B = range(0, 6 * BLOCK, BLOCK)

# Factors of one light's lobes, and its strength. Until a stage is done, these are for its own use too.
FIRST, SECOND, THIRD, STRENGTH = range(6 * BLOCK, 10 * BLOCK, BLOCK)

# Normals n, with 1/|n|.
NX, NY, NZ, INVERSE_NORMAL = range(10 * BLOCK, 14 * BLOCK, BLOCK)

# Unit vectors v to the viewer.
VX, VY, VZ = range(14 * BLOCK, 17 * BLOCK, BLOCK)

# Differences D to a light or to the eye, with 1/|D|; |D| is in the row of strengths at first.
DX, DY, DZ, INVERSE_DISTANCE = range(17 * BLOCK, 21 * BLOCK, BLOCK)

# Ambient light, where maps multiply the colour's parts; unit tangents across n, where the reflectance needs them.
AMBIENT_R, AMBIENT_G, AMBIENT_B, TX, TY, TZ = range(21 * BLOCK, 27 * BLOCK, BLOCK)

# Parts of one light, and of the ambient light, that nothing blocks; what a map has in place of the reflectance's field;
# not 0 for a vertex that is left to the reference; light that no map multiplies, beside OTHER; -1 where n is turned to
# the viewer, else 1.
VISIBLE, SKY, FIELD, DECLINED, UNMAPPED_R, UNMAPPED_G, UNMAPPED_B, SIDE = range(27 * BLOCK, 35 * BLOCK, BLOCK)

# Points, where they are not beside the rows.
PX, PY, PZ = range(35 * BLOCK, 38 * BLOCK, BLOCK)

# Where shares are wanted apart, one after the other in the colour's rows: their light so far, and the components.
LIGHT_R, LIGHT_G, LIGHT_B, COMPONENTS = range(38 * BLOCK, 42 * BLOCK, BLOCK)

# The length of all rows.
ROWS = COMPONENTS + 4 * 3 * BLOCK


# --- loading

_LINE = 64


def _prefetch(is_written: bool) -> Any:
    """Compiled code that asks for a block's vectors from one on; LLVM's hint, which no address makes fail.

    A processor guesses how memory goes on only while it is read, and a block is read and written in bursts with much
    arithmetic between them: where it is asked for a block ahead, all takes some 5 % less.
    """

    @intrinsic
    def prefetch(_typing: Any, array: Any, first: Any) -> Any:  # noqa: ARG001 Numba wants it by name
        size = array.dtype.bitwidth // 8

        def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            byte, i32 = ir.IntType(8).as_pointer(), ir.IntType(32)
            hint = ir.FunctionType(ir.VoidType(), [byte, i32, i32, i32])
            function = builder.module.declare_intrinsic("llvm.prefetch", [byte], hint)
            vectors, vector = arguments
            start = builder.bitcast(builder.gep(vectors, [builder.mul(vector, vector.type(3))]), byte)
            nearest_cache, is_data = i32(3), i32(1)
            for offset in range(0, 3 * BLOCK * size, _LINE):
                line = builder.gep(start, [vector.type(offset)])
                builder.call(function, [line, i32(int(is_written)), nearest_cache, is_data])
            return context.get_dummy_value()

        return types.void(array, types.intp), generate

    return prefetch


prefetch_to_read, prefetch_to_write = _prefetch(False), _prefetch(True)


# Squared lengths between these have lost no bit to underflow, in float32 as in float64.
_LEAST_MODERATE, _MOST_MODERATE = np.float32(2.0**-80), np.float32(2.0**120)

# Products of a matrix with a vector between 1/2 and 1 that are less have come of entries that nearly cancel, or of
# coordinates so small beside the largest that they were lost.
_SMALL = 2.0**-500

# Distances between which float32 holds what light weakens by.
_NEAREST, _FARTHEST = np.float32(2.0**-110), np.float32(2.0**120)


@inlined
def in_type(vector: Any, rows: Any) -> tuple[Any, Any, Any]:
    """A vector or colour of a record, in the type of rows."""
    return like(rows, vector[0]), like(rows, vector[1]), like(rows, vector[2])


@inlined
def vector(rows: Any, i: int) -> tuple[Any, Any, Any]:
    """The vector in the first three of some rows."""
    return rows[i], rows[BLOCK + i], rows[2 * BLOCK + i]


@inlined
def put(rows: Any, i: int, w: tuple[Any, Any, Any]) -> None:
    """Write a vector into the first three of some rows."""
    rows[i], rows[BLOCK + i], rows[2 * BLOCK + i] = w


@inlined
def is_moderate(squared: Any) -> bool:
    """Whether a vector of that squared length can be used as it is; False for NaN."""
    return (squared >= _LEAST_MODERATE) & (squared <= _MOST_MODERATE)  # `and` would be a branch


@inlined
def transformed(matrix: Any, w: tuple[float, float, float]) -> tuple[float, float, float]:
    """The first three columns of a matrix times a vector."""
    return (
        matrix[0, 0] * w[0] + matrix[0, 1] * w[1] + matrix[0, 2] * w[2],
        matrix[1, 0] * w[0] + matrix[1, 1] * w[1] + matrix[1, 2] * w[2],
        matrix[2, 0] * w[0] + matrix[2, 1] * w[1] + matrix[2, 2] * w[2],
    )


@inlined
def exponent_of(x: float, y: float, z: float) -> int:
    """The power of two that takes the largest of three numbers to [0.5, 1); 0 for zeros."""
    return math.frexp(max(abs(x), max(abs(y), abs(z))))[1]


@inlined
def is_finite(x: float, y: float, z: float) -> bool:
    """Whether all three are."""
    return math.isfinite(x) and math.isfinite(y) and math.isfinite(z)


@inlined
def scaled(x: float, y: float, z: float, exponent: int) -> tuple[float, float, float]:
    """A vector over a power of two."""
    return math.ldexp(x, -exponent), math.ldexp(y, -exponent), math.ldexp(z, -exponent)


@compiled
def load_vectors(array: Any, first: int, count: int, rows: Any) -> None:
    """Vectors, one after the other in memory, into the first three rows; the last one fills up the block."""
    part = shifted(array, 3 * first)
    for i in range(count):
        rows[i] = part[3 * i]
        rows[BLOCK + i] = part[3 * i + 1]
        rows[2 * BLOCK + i] = part[3 * i + 2]
    for i in range(count, BLOCK):
        put(rows, i, vector(rows, count - 1))


@compiled
def load_channel(channels: Any, first: int, count: int, row: Any) -> None:
    """One number of each vertex into a row; the block is filled up with 0."""
    part = shifted(channels, first)
    for i in range(count):
        row[i] = part[i]
    for i in range(count, BLOCK):
        row[i] = 0.0


@compiled
def load_seen(channels: Any, channel: int, first: int, count: int, s: Any, rows: Any, target: int) -> None:
    """What is seen of a light or of the sky into a row: by the side of each vertex that the viewer sees.

    Mostly he sees the same one of all in a block, and then the other's channel is not read.
    """
    front = shifted(channels, channel * s.channel_length)
    behind = shifted(front, s.behind * s.channel_length)
    any_front, any_behind = s.behind == 0, False
    if s.behind:
        for i in range(BLOCK):
            any_front = any_front | (rows[SIDE + i] > ZERO)
            any_behind = any_behind | (rows[SIDE + i] < ZERO)
    if any_front and any_behind:
        own, other = shifted(front, first), shifted(behind, first)
        for i in range(count):
            seen, seen_behind = own[i], other[i]
            rows[target + i] = seen_behind if rows[SIDE + i] < ZERO else seen
        for i in range(count, BLOCK):
            rows[target + i] = 0.0
    else:
        load_channel(front if any_front else behind, first, count, shifted(rows, target))


@compiled
def load_points(array: Any, first: int, count: int, s: Any, rows: Any, points: Any) -> None:
    """(L p + t) / w for the matrix (L | t) and w of the settings, in float64; p in rows, if those are nowhere."""
    if is_nowhere(points):
        load_vectors(array, first, count, shifted(rows, PX))
        return
    load_vectors(array, first, count, points)
    if s.moves_points:
        for i in range(BLOCK):
            x, y, z = transformed(s.matrix, vector(points, i))
            t = s.matrix[0, 3], s.matrix[1, 3], s.matrix[2, 3]
            put(points, i, ((x + t[0]) / s.w, (y + t[1]) / s.w, (z + t[2]) / s.w))


@inlined
def _in_two(rows: Any, x: float) -> tuple[Any, Any]:
    """A number in the type of rows, and what is left of it."""
    rounded = like(rows, x)
    return rounded, like(rows, x - np.float64(rounded))


@compiled
def _measure_normals(rows: Any) -> bool:
    """1/|n|; gives whether all can be used as they are."""
    good = True
    for i in range(BLOCK):
        squared = square(vector(shifted(rows, NX), i))
        rows[INVERSE_NORMAL + i] = inverse_length(squared)
        good = good & is_moderate(squared)
    return good


@compiled
def load_normals(array: Any, first: int, count: int, s: Any, rows: Any, wide: Any) -> bool:
    """Normals, turned by the settings' matrix, and 1/|n|; whether no vertex is declined. `wide` is scratch memory."""
    normals = shifted(rows, NX)
    if s.turns_normals:
        load_vectors(array, first, count, wide)
        for i in range(BLOCK):
            put(normals, i, transformed(s.normal_matrix, vector(wide, i)))
    else:
        load_vectors(array, first, count, normals)
    if _measure_normals(rows):
        return True
    good = True
    load_vectors(array, first, count, wide)
    for i in range(BLOCK):
        if is_moderate(square(vector(normals, i))):
            continue
        x, y, z = vector(wide, i)
        if not is_finite(x, y, z) or (x == 0.0 and y == 0.0 and z == 0.0):
            x, y, z = 0.0, 0.0, 0.0
        else:
            x, y, z = scaled(x, y, z, exponent_of(x, y, z))
            if s.turns_normals:
                x, y, z = transformed(s.normal_matrix, (x, y, z))
                if not max(abs(x), max(abs(y), abs(z))) > _SMALL:
                    rows[DECLINED + i] = 1.0
                    good = False
                x, y, z = scaled(x, y, z, exponent_of(x, y, z))
        put(normals, i, (x, y, z))
    _measure_normals(rows)
    return good


@inlined
def _unit(w: tuple[Any, Any, Any]) -> tuple[Any, Any, Any]:
    return times(w, inverse_length(square(w)))


@compiled
def load_tangents(channels: Any, stride: int, first: int, count: int, rows: Any) -> None:
    """Unit tangents across n, (n × t) × n; zero where they are along n."""
    tangents = shifted(rows, TX)
    for axis in range(3):
        load_channel(shifted(channels, axis * stride), first, count, shifted(tangents, axis * BLOCK))
    for i in range(BLOCK):
        n = times(vector(shifted(rows, NX), i), rows[INVERSE_NORMAL + i])
        put(tangents, i, _unit(cross(_unit(cross(n, vector(tangents, i))), n)))


# --- directions to positions, and to the viewer


@inlined  # LLVM leaves out what is not measured
def approach(rows: Any, points: Any, x: float, y: float, z: float, measures: bool) -> bool:
    """Vectors D to a position, 1/|D|, and |D| in the row of strengths if it is measured; whether no vertex is declined.

    Declined is a vertex on the position, not finite, or whose measured distance is out of range.
    """
    offsets, good = shifted(rows, DX), True
    (x0, x1), (y0, y1), (z0, z1) = _in_two(rows, x), _in_two(rows, y), _in_two(rows, z)
    is_in_rows = is_nowhere(points)
    for i in range(BLOCK):
        if is_in_rows:
            d = (x0 - rows[PX + i]) + x1, (y0 - rows[PY + i]) + y1, (z0 - rows[PZ + i]) + z1
        else:
            d = like(rows, x - points[i]), like(rows, y - points[BLOCK + i]), like(rows, z - points[2 * BLOCK + i])
        squared = square(d)
        distance = np.sqrt(max(squared, LEAST_SQUARE))
        put(offsets, i, d)
        rows[INVERSE_DISTANCE + i] = ONE / distance
        if measures:
            rows[STRENGTH + i] = distance
        good = good & is_moderate(squared)
    if good:
        return True
    good = True
    for i in range(BLOCK):
        if is_moderate(square(vector(offsets, i))):
            continue
        px, py, pz = vector(shifted(rows, PX), i) if is_nowhere(points) else vector(points, i)
        dx, dy, dz = x - px, y - py, z - pz
        exponent = exponent_of(dx, dy, dz) if is_finite(dx, dy, dz) else 0
        dx, dy, dz = scaled(dx, dy, dz, exponent)
        put(offsets, i, (dx, dy, dz))
        squared = square(vector(offsets, i))
        distance = like(rows, math.ldexp(np.float64(np.sqrt(squared)), exponent))
        rows[INVERSE_DISTANCE + i] = inverse_length(squared)
        is_there = is_moderate(squared)
        if measures:
            rows[STRENGTH + i] = distance
            is_there = is_there and distance >= _NEAREST and distance <= _FARTHEST
        if not is_there:
            rows[DECLINED + i] = 1.0
            good = False
    return good


@compiled
def look_at_viewer(s: Any, rows: Any, points: Any) -> bool:
    """Writes v, and n turned to the viewer, as far as the settings want them; whether no vertex is declined."""
    good, normals, viewer = True, shifted(rows, NX), shifted(rows, VX)
    if s.needs_eye:
        good = approach(rows, points, s.eye[0], s.eye[1], s.eye[2], False)
        for i in range(BLOCK):
            put(viewer, i, times(vector(shifted(rows, DX), i), rows[INVERSE_DISTANCE + i]))
    if s.is_flipped:
        axis, is_local = in_type(s.to_eye, rows), s.has_local_facing
        for i in range(BLOCK):
            n = vector(normals, i)
            toward = vector(viewer, i) if is_local else axis
            # a product is quicker than a store under a mask
            side = -ONE if dot(n, toward) < ZERO else ONE
            put(normals, i, times(n, side))
            rows[SIDE + i] = side
    return good
