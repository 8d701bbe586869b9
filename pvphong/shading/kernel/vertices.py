"""A block of vertices: its memory layout, loading, and the directions to a position.

A block's values are in scratch memory, row after row, in the type of the arithmetic. Points are there too if that type
holds them, else in separate float64 memory. Vectors may have any length. If their squares could leave the range of
floats, each vector is first scaled by a power of two. That is exact, so a vertex has the same bits in any unit of
length. Vectors that are zero or not finite become zero vectors, on which light is 0.

Arguments that functions here, in `stages` and in `driver` share:

- `rows`: pointer to the block's rows. `NX`, for example, is the offset of a row, and `rows[NX + i]` its entry for
  vertex `i` of the block
- `first`, `count`: index of the block's first vertex among all vertices, and number of vertices in the block
- `s`, `t`: record of the settings, of type `records.SETTINGS`; and of one light, of type `records.TERM`
- `points`: pointer to three rows in float64 with the block's points; null if the rows `PX` to `PZ` have the points
- `wide`: pointer to three rows in float64 for temporary values
- `channels`: pointer to numbers of all vertices, channel after channel, `s.channel_length` apart
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from pvphong.base.formulas import LEAST_SQUARE, ONE, ZERO, cross, dot, inverse_length, square, times
from pvphong.shading.kernel.arithmetic import as_type_of, compiled, inlined, is_nowhere, shifted

# --- rows


# Vertices in a block: a multiple of every vector length, and few enough that the rows in use fit into 32 KiB of
# first-level cache.
BLOCK = 128

# Colour. If maps of colours multiply parts of it, R, G and B hold the light that albedo and diffuse multiply, and the
# rows OTHER hold the rest.
R, G, B, OTHER_R, OTHER_G, OTHER_B = range(0, 6 * BLOCK, BLOCK)

# Factors of one light's lobes, and its strength. Stages also use these rows for temporaries.
FIRST, SECOND, THIRD, STRENGTH = range(6 * BLOCK, 10 * BLOCK, BLOCK)

# Normals n, with 1/|n|.
NX, NY, NZ, INVERSE_NORMAL = range(10 * BLOCK, 14 * BLOCK, BLOCK)

# Unit vectors v to the viewer.
VX, VY, VZ = range(14 * BLOCK, 17 * BLOCK, BLOCK)

# Vectors D to a light or to the eye, with 1/|D|; |D| is first in the row of strengths.
DX, DY, DZ, INVERSE_DISTANCE = range(17 * BLOCK, 21 * BLOCK, BLOCK)

# Ambient light, if maps multiply the colour's parts; unit tangents orthogonal to n, if the reflectance needs them.
AMBIENT_R, AMBIENT_G, AMBIENT_B, TX, TY, TZ = range(21 * BLOCK, 27 * BLOCK, BLOCK)

# VISIBLE and SKY: visible parts of one light and of the sky. FIELD: the map of the reflectance's field. DECLINED: not 0
# for a vertex that the reference must light. UNMAPPED: light that no map multiplies, if maps multiply the light in
# OTHER. SIDE: -1 if n was turned towards the viewer, else 1.
VISIBLE, SKY, FIELD, DECLINED, UNMAPPED_R, UNMAPPED_G, UNMAPPED_B, SIDE = range(27 * BLOCK, 35 * BLOCK, BLOCK)

# Points, unless they are in separate memory.
PX, PY, PZ = range(35 * BLOCK, 38 * BLOCK, BLOCK)

# For separate shares, which the colour's rows hold in turn: sums of the current light, and of the components.
LIGHT_R, LIGHT_G, LIGHT_B, COMPONENTS = range(38 * BLOCK, 42 * BLOCK, BLOCK)

# Length of all rows.
ROWS = COMPONENTS + 4 * 3 * BLOCK


# --- loading

_LINE = 64


def _prefetch(is_written: bool) -> Any:
    """Return a function for compiled code that prefetches a block of vectors.

    It prefetches for writing if `is_written`, else for reading. LLVM's hint is safe for any address. The processor's
    own prefetching works only during steady access, but a block is read and written in bursts, with much arithmetic
    between them. Prefetching a block ahead saves some 5 % of the total time.
    """

    @intrinsic
    def prefetch(_typing: Any, array: Any, first: Any) -> Any:  # noqa: ARG001 Numba reads its name
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


# Squared lengths between these lose no bits to underflow, in float32 and in float64.
_LEAST_MODERATE, _MOST_MODERATE = np.float32(2.0**-80), np.float32(2.0**120)

# The product of a matrix with a vector between 1/2 and 1 is less than this only if entries nearly cancel, or if
# coordinates underflow because they are so small relative to the largest.
_SMALL = 2.0**-500

# Range of distances for which float32 holds the attenuation.
_NEAREST, _FARTHEST = np.float32(2.0**-110), np.float32(2.0**120)


@inlined
def in_type(vector: Any, rows: Any) -> tuple[Any, Any, Any]:
    """Return the three numbers of a vector or colour in the type of `rows`."""
    return as_type_of(rows, vector[0]), as_type_of(rows, vector[1]), as_type_of(rows, vector[2])


@inlined
def vector(rows: Any, i: int) -> tuple[Any, Any, Any]:
    """Return the vector of vertex `i` of a block; `rows` begins with the three rows of its coordinates."""
    return rows[i], rows[BLOCK + i], rows[2 * BLOCK + i]


@inlined
def put(rows: Any, i: int, w: tuple[Any, Any, Any]) -> None:
    """Write the vector `w` of vertex `i` of a block; `rows` begins with the three rows of its coordinates."""
    rows[i], rows[BLOCK + i], rows[2 * BLOCK + i] = w


@inlined
def is_moderate(squared: Any) -> bool:
    """Return True if a vector with the squared length `squared` can be used without scaling; False for NaN."""
    return (squared >= _LEAST_MODERATE) & (squared <= _MOST_MODERATE)  # `and` would be a branch


@inlined
def transformed(matrix: Any, w: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return the product of the left 3 × 3 part of a matrix and the vector `w`."""
    return (
        matrix[0, 0] * w[0] + matrix[0, 1] * w[1] + matrix[0, 2] * w[2],
        matrix[1, 0] * w[0] + matrix[1, 1] * w[1] + matrix[1, 2] * w[2],
        matrix[2, 0] * w[0] + matrix[2, 1] * w[1] + matrix[2, 2] * w[2],
    )


@inlined
def exponent_of(x: float, y: float, z: float) -> int:
    """Return the binary exponent of the largest of three absolute values, as `math.frexp` does; 0 for zeros."""
    return math.frexp(max(abs(x), max(abs(y), abs(z))))[1]


@inlined
def is_finite(x: float, y: float, z: float) -> bool:
    """Return True if all three numbers are finite."""
    return math.isfinite(x) and math.isfinite(y) and math.isfinite(z)


@inlined
def scaled(x: float, y: float, z: float, exponent: int) -> tuple[float, float, float]:
    """Return the vector (x, y, z) divided by 2 to the power `exponent`."""
    return math.ldexp(x, -exponent), math.ldexp(y, -exponent), math.ldexp(z, -exponent)


@compiled
def load_vectors(array: Any, first: int, count: int, rows: Any) -> None:
    """Copy `count` vectors of `array`, starting at index `first`, into the three rows at `rows`: x, y and z.

    Copies of the last vector fill the rest of the block.
    """
    part = shifted(array, 3 * first)
    for i in range(count):
        rows[i] = part[3 * i]
        rows[BLOCK + i] = part[3 * i + 1]
        rows[2 * BLOCK + i] = part[3 * i + 2]
    for i in range(count, BLOCK):
        put(rows, i, vector(rows, count - 1))


@compiled
def load_channel(channels: Any, first: int, count: int, row: Any) -> None:
    """Copy `count` numbers of `channels`, starting at index `first`, into `row`; zeros fill the rest of the row."""
    part = shifted(channels, first)
    for i in range(count):
        row[i] = part[i]
    for i in range(count, BLOCK):
        row[i] = 0.0


@compiled
def load_seen(channels: Any, channel: int, first: int, count: int, s: Any, rows: Any, target: int) -> None:
    """Load the visible part of a light or of the sky into a row, for the side of each vertex that faces the viewer.

    If the viewer sees the same side of all vertices of the block, the other side's channel is not read.

    Parameters
    ----------
    channels, first, count, s, rows
        As in the module's description.
    channel : int
        Number of the channel with the visible part from the vertices' front sides.
    target : int
        Offset of the row to write.
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
    """Load the points of a block: `count` vectors of `array`, starting at index `first`.

    If `points` is null, the vectors are copied into the rows `PX` to `PZ`. If it is not null, they are written into the
    three rows at `points`, in float64. A model matrix, if there is one, transforms them first: a point p becomes (L p +
    t) / w, where L is the left 3 × 3 part of `s.matrix`, t is its last column, and w is `s.w`.
    """
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
    """Return `x` rounded to the type of `rows`, and the rest of `x` in the same type."""
    rounded = as_type_of(rows, x)
    return rounded, as_type_of(rows, x - np.float64(rounded))


@compiled
def _measure_normals(rows: Any) -> bool:
    """Write 1/|n| of a block's normals n into the row `INVERSE_NORMAL`.

    Return True if all normals can be used without scaling.
    """
    good = True
    for i in range(BLOCK):
        squared = square(vector(shifted(rows, NX), i))
        rows[INVERSE_NORMAL + i] = inverse_length(squared)
        good = good & is_moderate(squared)
    return good


@compiled
def load_normals(array: Any, first: int, count: int, s: Any, rows: Any, wide: Any) -> bool:
    """Load the normals of a block, and write 1/|n|. Return True if no vertex of the block is declined.

    The normals are `count` vectors of `array`, starting at index `first`. If `s.turns_normals`, they are multiplied by
    `s.normal_matrix`. A vertex is declined, so that the reference lights it, if this product nearly vanishes. `wide` is
    scratch memory: three rows in float64.
    """
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
    """Load a block's tangents t as unit vectors orthogonal to the normals n, along (n × t) × n; 0 if t is along n.

    `channels` begins with the channel of the tangents' x. Those of y and z are `stride` and 2 · `stride` further on.
    `first` and `count` are as in the module's description.
    """
    tangents = shifted(rows, TX)
    for axis in range(3):
        load_channel(shifted(channels, axis * stride), first, count, shifted(tangents, axis * BLOCK))
    for i in range(BLOCK):
        n = times(vector(shifted(rows, NX), i), rows[INVERSE_NORMAL + i])
        put(tangents, i, _unit(cross(_unit(cross(n, vector(tangents, i))), n)))


# --- directions to positions, and to the viewer


@inlined  # LLVM removes the distance if it is not measured
def approach(rows: Any, points: Any, x: float, y: float, z: float, measures: bool) -> bool:
    """Write the vectors D from a block's vertices to the position (x, y, z), and 1/|D|.

    If `measures`, also write |D| into the row of strengths. `points` is as in the module's description. Return True if
    no vertex of the block is declined, that is, left to the reference. A vertex is declined if it is at the position or
    not finite; and, if `measures`, if |D| is out of range.
    """
    offsets, good = shifted(rows, DX), True
    (x0, x1), (y0, y1), (z0, z1) = _in_two(rows, x), _in_two(rows, y), _in_two(rows, z)
    is_in_rows = is_nowhere(points)
    for i in range(BLOCK):
        if is_in_rows:
            d = (x0 - rows[PX + i]) + x1, (y0 - rows[PY + i]) + y1, (z0 - rows[PZ + i]) + z1
        else:
            dx, dy, dz = x - points[i], y - points[BLOCK + i], z - points[2 * BLOCK + i]
            d = as_type_of(rows, dx), as_type_of(rows, dy), as_type_of(rows, dz)
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
        distance = as_type_of(rows, math.ldexp(np.float64(np.sqrt(squared)), exponent))
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
    """Write the unit vectors v to a local viewer, and turn a block's normals towards the viewer.

    v is written only if `s.needs_eye`, and normals are turned only if `s.is_flipped`, for two-sided lighting. Return
    True if no vertex of the block is declined. The reference lights declined vertices, such as a vertex at the eye.
    """
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
            # a product is faster than a masked store
            side = -ONE if dot(n, toward) < ZERO else ONE
            put(normals, i, times(n, side))
            rows[SIDE + i] = side
    return good
