"""The kernel's loops that bring vertices into the rows of a block: as they are, or as a model matrix puts them."""

from __future__ import annotations

from typing import Any

import numpy as np

from pvphong.shading.kernel import rows as at
from pvphong.shading.kernel.arithmetic import plain
from pvphong.shading.kernel.rows import BLOCK
from pvphong.shading.kernel.vectors import inverse_root, is_moderate, square_of


@plain
def split(array: Any, start: int, count: int, rows: Any) -> None:
    """Vectors that stand one after the other into the first three rows; the last one fills up the block."""
    part = array[3 * start : 3 * (start + count)]
    for i in range(count):
        rows[i] = part[3 * i]
        rows[BLOCK + i] = part[3 * i + 1]
        rows[2 * BLOCK + i] = part[3 * i + 2]
    for i in range(count, BLOCK):
        rows[i] = part[3 * count - 3]
        rows[BLOCK + i] = part[3 * count - 2]
        rows[2 * BLOCK + i] = part[3 * count - 1]


@plain
def transform(matrix: Any, w: float, wide: Any) -> bool:
    """(L p + t) / w for float64 points and a (3, 4) matrix (L | t); gives whether all are finite."""
    good = True
    for i in range(BLOCK):
        x, y, z = wide[i], wide[BLOCK + i], wide[2 * BLOCK + i]
        x, y, z = (
            (matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z + matrix[0, 3]) / w,
            (matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z + matrix[1, 3]) / w,
            (matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z + matrix[2, 3]) / w,
        )
        wide[i], wide[BLOCK + i], wide[2 * BLOCK + i] = x, y, z
        good = good & np.isfinite(x) & np.isfinite(y) & np.isfinite(z)
    return good


@plain
def rotate_normals(matrix: Any, wide: Any, rows: Any) -> None:
    """(3, 3) matrix times float64 normals."""
    for i in range(BLOCK):
        x, y, z = wide[i], wide[BLOCK + i], wide[2 * BLOCK + i]
        rows[at.NX + i] = matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z
        rows[at.NY + i] = matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z
        rows[at.NZ + i] = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z


@plain
def measure_normals(rows: Any) -> bool:
    """1/|n|; gives whether none needs a rescue."""
    good = True
    for i in range(BLOCK):
        square = square_of(rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i])
        rows[at.INVERSE + i] = inverse_root(square)
        good = good & is_moderate(square)
    return good
