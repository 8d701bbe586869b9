"""The kernel's loops that bring vertices into the rows of a block: as they are, or as a model matrix puts them.

Normals of any length are taken: where squares of theirs could leave the range of floats, they are first scaled by
powers of two, each by its own. That is exact, so a vertex has the same bits in any unit of length. What is zero or
not finite becomes a zero vector, and light on it 0.
"""

from __future__ import annotations

import math
from typing import Any

from pvphong.shading.kernel import rows as at
from pvphong.shading.kernel.arithmetic import inlined, plain
from pvphong.shading.kernel.pointers import shifted
from pvphong.shading.kernel.rows import BLOCK
from pvphong.shading.kernel.vectors import inverse_root, is_moderate, square_of

# Products of a matrix with a vector between 1/2 and 1 that are less have come of entries that nearly cancel, or of
# coordinates so small beside the largest that they were lost.
_SMALL = 2.0**-500


@plain
def unmark(rows: Any) -> None:
    """No vertex is declined yet."""
    for i in range(BLOCK):
        rows[at.DECLINED + i] = 0.0


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
        rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i] = x, y, z


@plain
def measure_normals(rows: Any) -> bool:
    """1/|n|; gives whether all can be used as they are."""
    good = True
    for i in range(BLOCK):
        square = square_of(rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i])
        rows[at.INVERSE + i] = inverse_root(square)
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
        if is_moderate(square_of(rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i])):
            continue
        x, y, z = wide[i], wide[BLOCK + i], wide[2 * BLOCK + i]
        if not is_finite(x, y, z) or (x == 0.0 and y == 0.0 and z == 0.0):
            x, y, z = 0.0, 0.0, 0.0
        else:
            x, y, z = scaled(x, y, z, exponent_of(x, y, z))
            if turns:
                x, y, z = _product(matrix, x, y, z)
                if not max(abs(x), max(abs(y), abs(z))) > _SMALL:
                    rows[at.DECLINED + i] = 1.0
                    good = False
                x, y, z = scaled(x, y, z, exponent_of(x, y, z))
        rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i] = x, y, z
    return good
