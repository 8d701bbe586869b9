"""What highlights are functions of, vertex by vertex: s = l + v against the normal."""

from __future__ import annotations

from typing import Any

from pvphong.shading.kernel import rows as at
from pvphong.shading.kernel.arithmetic import inlined, multiply_add
from pvphong.shading.kernel.vectors import dot, square_of


@inlined
def halfway_sines(rows: Any, i: int) -> tuple[Any, Any, Any]:
    """N·l for the raw n, |n × s|² likewise, and |s|²."""
    nx, ny, nz = rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i]
    dx, dy, dz = rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i]
    inverse = rows[at.NEARNESS + i]
    n_l = dot(nx, ny, nz, dx, dy, dz) * inverse
    sx = multiply_add(dx, inverse, rows[at.VX + i])
    sy = multiply_add(dy, inverse, rows[at.VY + i])
    sz = multiply_add(dz, inverse, rows[at.VZ + i])
    across = square_of(
        multiply_add(ny, sz, -(nz * sy)),
        multiply_add(nz, sx, -(nx * sz)),
        multiply_add(nx, sy, -(ny * sx)),
    )
    return n_l, across, square_of(sx, sy, sz)


@inlined
def mirror_chord(rows: Any, i: int) -> tuple[Any, Any, Any]:
    """N·l, |s|², and |C|² of the chord C = 2(n·l)n − l − v.

    |C|² = |n × s|² + (n·l − n·v)² is next to 0 where n = l = v, and leaves out the rounding of |n|.
    """
    shrink = rows[at.INVERSE + i]
    n_l, across, middle = halfway_sines(rows, i)
    along = n_l - rows[at.FACING + i]
    return n_l * shrink, middle, multiply_add(along, along, across) * (shrink * shrink)
