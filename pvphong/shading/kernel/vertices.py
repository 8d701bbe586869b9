"""Vertices in a block: where their values stand, how they are loaded, and their directions to positions and the viewer.

A block's values stand in scratch memory, row after row. Vectors of any length are taken: where squares of them could
leave the range of floats, they are first scaled by powers of two, each by its own. That is exact, so a vertex has the
same bits in any unit of length. What is zero or not finite becomes a zero vector, and light on it 0. `points` are
float64 where they stand beside rows of float32, else nowhere, and then in the rows themselves.

Read from top to bottom: lengths of vectors; the rows; loading points, normals and channels; differences D from vertices
to a position; directions to the viewer.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pvphong.shading.kernel.arithmetic import inlined, is_nowhere, like, multiply_add, plain, shifted

_ZERO, _ONE, _TWO = np.float32(0.0), np.float32(1.0), np.float32(2.0)

# Squared lengths between these have lost no bit to underflow, in float32 as in float64.
_LEAST_SQUARE, _MOST_SQUARE = np.float32(2.0**-80), np.float32(2.0**120)

ZERO_SQUARE = np.float32(2.0**-126)
"""Stands in for the square of a zero vector, which then remains zero when it is made unit length."""

NO_LENGTH = np.float32(2.0**62)
"""The inverse length of a normal that is not there is more."""


@inlined
def in_type(vector: Any, rows: Any) -> tuple[Any, Any, Any]:
    """A vector or colour of a record, in the type of rows."""
    return like(rows, vector[0]), like(rows, vector[1]), like(rows, vector[2])


@inlined
def is_moderate(square: Any) -> bool:
    """Whether a vector of that squared length can be used as it is; False for NaN."""
    return (square >= _LEAST_SQUARE) & (square <= _MOST_SQUARE)  # `and` would be a branch


@inlined
def dot(ax: Any, ay: Any, az: Any, bx: Any, by: Any, bz: Any) -> Any:
    """Dot product, summed in the order x, y, z; not fused, for what cancels exactly is to be 0."""
    return ax * bx + ay * by + az * bz


@inlined
def square_of(x: Any, y: Any, z: Any) -> Any:
    """Squared length, summed in the order x, y, z."""
    return multiply_add(z, z, multiply_add(y, y, x * x))


@inlined
def root(square: Any) -> Any:
    """The length of a vector of that squared length."""
    return np.sqrt(square)


@inlined
def inverse_root(square: Any) -> Any:
    """What makes a vector of that squared length unit length."""
    return _ONE / np.sqrt(max(square, ZERO_SQUARE))


# --- rows


# Vertices in a block: a multiple of every vector's length, and few enough that the rows in use stay in 32 KiB
# of first-level cache.
BLOCK = 128

# Vertices in a group, the least that a thread is given.
GROUP = 32 * BLOCK

# Bytes in a line of the processor's caches, and in its longest vectors.
LINE = 64

# Colour; and the part of it that the albedo does not multiply, where there is an albedo.
R, G, B, HR, HG, HB = range(0, 6 * BLOCK, BLOCK)

# Factors of one light's lobes, and its strength. Until a stage is done, these are for its own use too.
FIRST, SECOND, THIRD, STRENGTH = range(6 * BLOCK, 10 * BLOCK, BLOCK)

# Normals n, with 1/|n|.
NX, NY, NZ, INVERSE = range(10 * BLOCK, 14 * BLOCK, BLOCK)

# Unit vectors v to the viewer, with n·v; the axis to the viewer.
VX, VY, VZ, FACING, AX, AY, AZ = range(14 * BLOCK, 21 * BLOCK, BLOCK)

# Differences D to a light or to the eye, with 1/|D|. Where |D| itself was wanted, it stands in the row of strengths.
DX, DY, DZ, NEARNESS = range(21 * BLOCK, 25 * BLOCK, BLOCK)

# Points, unless they stand in float64 beside rows of float32.
PX, PY, PZ = range(25 * BLOCK, 28 * BLOCK, BLOCK)

# Not 0 for a vertex that is left to the reference.
DECLINED = 28 * BLOCK

# Albedo.
ALBEDO_R, ALBEDO_G, ALBEDO_B = range(29 * BLOCK, 32 * BLOCK, BLOCK)

# How a light with a size is seen: sine and cosine of its angular radius, n·l; for its stage's own use.
SINE, COSINE, TILT, OWN = range(32 * BLOCK, 36 * BLOCK, BLOCK)

# Arcs of great circles, and rims, along which integrals over lights with a size are taken.
ARC, RIM = OWN + 8 * BLOCK, OWN + 14 * BLOCK

# Parts of one light, and of the ambient light, that nothing blocks.
VISIBLE, SKY = range(RIM + 16 * BLOCK, RIM + 18 * BLOCK, BLOCK)

# Unit tangents across n, where the reflectance needs them; and the length of all rows.
TX, TY, TZ, ROWS = range(RIM + 18 * BLOCK, RIM + 22 * BLOCK, BLOCK)

# What threads that light the same vertices share: how many are at it, how often one of them had to leave vertices to
# the reference; then for each range of vertices, of which there are as many as threads, how many were begun with.
AT_WORK, LEFT, BEGUN = range(3)


# --- loading vertices


# Products of a matrix with a vector between 1/2 and 1 that are less have come of entries that nearly cancel, or of
# coordinates so small beside the largest that they were lost.
_SMALL = 2.0**-500


@plain
def unmark(rows: Any) -> None:
    """No vertex is declined yet."""
    for i in range(BLOCK):
        rows[DECLINED + i] = 0.0


@plain
def split(array: Any, start: int, count: int, rows: Any) -> None:
    """Vectors that stand one after the other into the first three rows; the last one fills up the block."""
    part = shifted(array, 3 * start)
    for i in range(count):
        rows[i] = part[3 * i]
        rows[BLOCK + i] = part[3 * i + 1]
        rows[2 * BLOCK + i] = part[3 * i + 2]
    for i in range(count, BLOCK):
        rows[i] = part[3 * count - 3]
        rows[BLOCK + i] = part[3 * count - 2]
        rows[2 * BLOCK + i] = part[3 * count - 1]


@plain
def take(channel: Any, start: int, count: int, rows: Any) -> None:
    """Numbers of one channel into the first row; the block is filled up with 0."""
    part = shifted(channel, start)
    for i in range(count):
        rows[i] = part[i]
    for i in range(count, BLOCK):
        rows[i] = 0.0


@plain
def transform(matrix: Any, w: float, points: Any) -> None:
    """(L p + t) / w for float64 points and a (3, 4) matrix (L | t)."""
    for i in range(BLOCK):
        x, y, z = points[i], points[BLOCK + i], points[2 * BLOCK + i]
        points[i] = (matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z + matrix[0, 3]) / w
        points[BLOCK + i] = (matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z + matrix[1, 3]) / w
        points[2 * BLOCK + i] = (matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z + matrix[2, 3]) / w


@inlined
def _product(matrix: Any, x: float, y: float, z: float) -> tuple[float, float, float]:
    return (
        matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z,
        matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z,
        matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z,
    )


@plain
def rotate_normals(matrix: Any, wide: Any, rows: Any) -> None:
    """(3, 3) matrix times float64 normals."""
    for i in range(BLOCK):
        x, y, z = _product(matrix, wide[i], wide[BLOCK + i], wide[2 * BLOCK + i])
        rows[NX + i], rows[NY + i], rows[NZ + i] = x, y, z


@plain
def measure_normals(rows: Any) -> bool:
    """1/|n|; gives whether all can be used as they are."""
    good = True
    for i in range(BLOCK):
        square = square_of(rows[NX + i], rows[NY + i], rows[NZ + i])
        rows[INVERSE + i] = inverse_root(square)
        good = good & is_moderate(square)
    return good


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


@plain
def scale_normals(wide: Any, matrix: Any, turns: bool, rows: Any) -> bool:
    """Bring float64 normals to moderate lengths, after the matrix if it turns them; whether none is declined."""
    good = True
    for i in range(BLOCK):
        if is_moderate(square_of(rows[NX + i], rows[NY + i], rows[NZ + i])):
            continue
        x, y, z = wide[i], wide[BLOCK + i], wide[2 * BLOCK + i]
        if not is_finite(x, y, z) or (x == 0.0 and y == 0.0 and z == 0.0):
            x, y, z = 0.0, 0.0, 0.0
        else:
            x, y, z = scaled(x, y, z, exponent_of(x, y, z))
            if turns:
                x, y, z = _product(matrix, x, y, z)
                if not max(abs(x), max(abs(y), abs(z))) > _SMALL:
                    rows[DECLINED + i] = 1.0
                    good = False
                x, y, z = scaled(x, y, z, exponent_of(x, y, z))
        rows[NX + i], rows[NY + i], rows[NZ + i] = x, y, z
    return good


# --- differences D from vertices to a position, and directions made of them


# Distances between which float32 holds what light weakens by; and the most that it is strengthened.
_NEAREST, _FARTHEST, _STRONGEST = np.float32(2.0**-110), np.float32(2.0**120), np.float32(2.0**126)


@inlined
def normal_dot(rows: Any, i: int, x: Any, y: Any, z: Any) -> Any:
    """N·(x, y, z)."""
    return dot(rows[NX + i], rows[NY + i], rows[NZ + i], x, y, z)


@inlined
def unit_normal(rows: Any, i: int) -> tuple[Any, Any, Any]:
    """N as a unit vector; 0 where there is none."""
    shrink = rows[INVERSE + i]
    return rows[NX + i] * shrink, rows[NY + i] * shrink, rows[NZ + i] * shrink


@inlined
def mirrored_viewer(rows: Any, i: int) -> tuple[Any, Any, Any]:
    """The direction to the viewer mirrored at n, as a unit vector."""
    nx, ny, nz = unit_normal(rows, i)
    vx, vy, vz = rows[VX + i], rows[VY + i], rows[VZ + i]
    twice = _TWO * dot(nx, ny, nz, vx, vy, vz)
    x, y, z = twice * nx - vx, twice * ny - vy, twice * nz - vz
    unit = inverse_root(square_of(x, y, z))
    return x * unit, y * unit, z * unit


@inlined
def _wide_difference(rows: Any, points: Any, i: int, x: float, y: float, z: float) -> tuple[Any, Any, Any]:
    return like(rows, x - points[i]), like(rows, y - points[BLOCK + i]), like(rows, z - points[2 * BLOCK + i])


@inlined
def _in_two(rows: Any, x: float) -> tuple[Any, Any]:
    """A coordinate as a sum of two numbers of the rows' type."""
    high = like(rows, x)
    return high, like(rows, x - np.float64(high))


@inlined
def _difference(rows: Any, i: int, x: Any, y: Any, z: Any) -> tuple[Any, Any, Any]:
    """Right to the last bit that matters: the first difference is exact wherever the second number counts."""
    return (x[0] - rows[PX + i]) + x[1], (y[0] - rows[PY + i]) + y[1], (z[0] - rows[PZ + i]) + z[1]


@inlined
def _keep(rows: Any, i: int, dx: Any, dy: Any, dz: Any) -> bool:
    square = square_of(dx, dy, dz)
    rows[DX + i], rows[DY + i], rows[DZ + i] = dx, dy, dz
    rows[NEARNESS + i] = inverse_root(square)
    return is_moderate(square)


@inlined
def _keep_measured(rows: Any, i: int, dx: Any, dy: Any, dz: Any) -> bool:
    square = square_of(dx, dy, dz)
    distance = np.sqrt(max(square, ZERO_SQUARE))
    rows[DX + i], rows[DY + i], rows[DZ + i] = dx, dy, dz
    rows[NEARNESS + i] = _ONE / distance
    rows[STRENGTH + i] = distance
    return is_moderate(square)


@plain
def _approach(rows: Any, points: Any, x: float, y: float, z: float) -> bool:
    good = True
    if is_nowhere(points):
        two_x, two_y, two_z = _in_two(rows, x), _in_two(rows, y), _in_two(rows, z)
        for i in range(BLOCK):
            good = good & _keep(rows, i, *_difference(rows, i, two_x, two_y, two_z))
    else:
        for i in range(BLOCK):
            good = good & _keep(rows, i, *_wide_difference(rows, points, i, x, y, z))
    return good


@plain
def _approach_measured(rows: Any, points: Any, x: float, y: float, z: float) -> bool:
    good = True
    if is_nowhere(points):
        two_x, two_y, two_z = _in_two(rows, x), _in_two(rows, y), _in_two(rows, z)
        for i in range(BLOCK):
            good = good & _keep_measured(rows, i, *_difference(rows, i, two_x, two_y, two_z))
    else:
        for i in range(BLOCK):
            good = good & _keep_measured(rows, i, *_wide_difference(rows, points, i, x, y, z))
    return good


@inlined
def _scaled_difference(rows: Any, target: float, coordinate: float, exponent: int, is_wide: bool) -> Any:
    """Target − coordinate over 2^exponent, rounded where `_difference` or `_wide_difference` rounds it."""
    if not is_wide:
        high, low = _in_two(rows, target)
        scaled_high = like(rows, math.ldexp(np.float64(high), -exponent))
        scaled_low = like(rows, math.ldexp(np.float64(low), -exponent))
        scaled = (scaled_high - like(rows, math.ldexp(coordinate, -exponent))) + scaled_low
        if math.isfinite(scaled):
            return scaled
        # so near each other that coordinates scaled like their difference overflow; the difference is exact then
    return like(rows, math.ldexp(target - coordinate, -exponent))


@plain
def _scale_differences(rows: Any, points: Any, x: float, y: float, z: float, is_measured: bool) -> bool:
    """Bring D to moderate lengths; whether no vertex is declined: on the position, not finite, or |D| out of range."""
    good, is_wide = True, not is_nowhere(points)
    for i in range(BLOCK):
        if is_moderate(square_of(rows[DX + i], rows[DY + i], rows[DZ + i])):
            continue
        px, py, pz = np.float64(rows[PX + i]), np.float64(rows[PY + i]), np.float64(rows[PZ + i])
        if is_wide:
            px, py, pz = points[i], points[BLOCK + i], points[2 * BLOCK + i]
        exponent = exponent_of(x - px, y - py, z - pz) if is_finite(x - px, y - py, z - pz) else 0
        rows[DX + i] = _scaled_difference(rows, x, px, exponent, is_wide)
        rows[DY + i] = _scaled_difference(rows, y, py, exponent, is_wide)
        rows[DZ + i] = _scaled_difference(rows, z, pz, exponent, is_wide)
        square = square_of(rows[DX + i], rows[DY + i], rows[DZ + i])
        rows[NEARNESS + i] = inverse_root(square)
        is_there = is_moderate(square)
        if is_measured:
            distance = like(rows, math.ldexp(np.float64(np.sqrt(square)), exponent))
            rows[STRENGTH + i] = distance
            is_there = is_there and distance >= _NEAREST and distance <= _FARTHEST
        if not is_there:
            rows[DECLINED + i] = 1.0
            good = False
    return good


@plain
def approach(rows: Any, points: Any, x: float, y: float, z: float) -> bool:
    """D towards a position, with 1/|D|; whether no vertex is declined."""
    return _approach(rows, points, x, y, z) or _scale_differences(rows, points, x, y, z, False)


@plain
def approach_measured(rows: Any, points: Any, x: float, y: float, z: float) -> bool:
    """`approach`, with |D| in the row of strengths."""
    return _approach_measured(rows, points, x, y, z) or _scale_differences(rows, points, x, y, z, True)


@plain
def attenuate(rows: Any, constant: float, linear: float, quadratic: float) -> None:
    """1 / (c + l·d + q·d²) in place of d in the row of strengths; finite where the sum has underflowed."""
    c, l, q = like(rows, constant), like(rows, linear), like(rows, quadratic)
    for i in range(BLOCK):
        distance = rows[STRENGTH + i]
        weakening = multiply_add(multiply_add(q, distance, l), distance, c)
        rows[STRENGTH + i] = min(_ONE / weakening, _STRONGEST)


@plain
def measure_differences(rows: Any) -> None:
    """1/|D| for D that did not come from `approach`."""
    for i in range(BLOCK):
        rows[NEARNESS + i] = inverse_root(square_of(rows[DX + i], rows[DY + i], rows[DZ + i]))


@plain
def look(rows: Any) -> None:
    """V along D to the eye."""
    for i in range(BLOCK):
        inverse = rows[NEARNESS + i]
        rows[VX + i] = rows[DX + i] * inverse
        rows[VY + i] = rows[DY + i] * inverse
        rows[VZ + i] = rows[DZ + i] * inverse


@plain
def face(rows: Any) -> None:
    """N·v."""
    for i in range(BLOCK):
        rows[FACING + i] = normal_dot(rows, i, rows[VX + i], rows[VY + i], rows[VZ + i])


@inlined
def _unit_cross(ax: Any, ay: Any, az: Any, bx: Any, by: Any, bz: Any) -> tuple[Any, Any, Any]:
    x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    inverse = inverse_root(square_of(x, y, z))
    return x * inverse, y * inverse, z * inverse


@plain
def straighten_tangents(rows: Any) -> None:
    """Tangents that are not quite across n made so, (n × t) × n, and unit length; zero where they are along n."""
    for i in range(BLOCK):
        inverse = rows[INVERSE + i]
        nx, ny, nz = rows[NX + i] * inverse, rows[NY + i] * inverse, rows[NZ + i] * inverse
        bx, by, bz = _unit_cross(nx, ny, nz, rows[TX + i], rows[TY + i], rows[TZ + i])
        rows[TX + i], rows[TY + i], rows[TZ + i] = _unit_cross(bx, by, bz, nx, ny, nz)


@plain
def turn_normals(rows: Any, by_axis: bool) -> None:
    """Replace n by −n where it points away from v, or from the axis to the viewer."""
    toward = AX if by_axis else VX
    for i in range(BLOCK):
        x, y, z = rows[toward + i], rows[toward + BLOCK + i], rows[toward + 2 * BLOCK + i]
        # a product is quicker than a store under a mask
        sign = -_ONE if normal_dot(rows, i, x, y, z) < _ZERO else _ONE
        rows[NX + i] *= sign
        rows[NY + i] *= sign
        rows[NZ + i] *= sign
