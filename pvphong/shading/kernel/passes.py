"""The kernel's loops that light one block of vertices. Each is simple enough for LLVM to vectorise.

Symbols: p a vertex, n its normal (of any length), v the unit vector to the viewer, D the way from p to a light,
l = D/|D|; C the chord of a highlight or a cone, whose squared length is 2(1 − cosine).

A block's values stand row after row in one flat array: rows at fixed distances are what LLVM needs to know that
they do not overlap, and counting references to many arrays would cost as much as the arithmetic. Literals are
float32: a Python float would widen float32 arithmetic, and these are widened, exactly, where rows are float64.

There is no fast-math here: each vertex's bits are what IEEE arithmetic makes of its own numbers. Products and sums
are fused by `multiply_add` alone, and so alike in every loop; where terms that cancel exactly must leave 0 they are
not fused.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pvphong.base.ranges import BRIGHTEST
from pvphong.shading.kernel import rows as at
from pvphong.shading.kernel.arithmetic import exp2, inlined, log2_power, multiply_add, plain
from pvphong.shading.kernel.rows import BLOCK
from pvphong.shading.kernel.vectors import ZERO_SQUARE, dot, inverse_root, is_moderate, square_of

_ZERO, _ONE, _TWO, _BRIGHTEST = np.float32(0.0), np.float32(1.0), np.float32(2.0), np.float32(BRIGHTEST)
_NEVER = np.float32(-np.inf)

# Makes room below for the square of l + v where they are nearly opposite; a power of two, so that it changes no bit.
_LARGER = np.float32(2.0**60)


@inlined
def ray_square(rows: Any, i: int) -> Any:
    """|D|²."""
    return square_of(rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i])


@inlined
def _normal_dot(rows: Any, i: int, x: Any, y: Any, z: Any) -> Any:
    return dot(rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i], x, y, z)


@plain
def fill(rows: Any, x: Any, y: Any, z: Any) -> None:
    """The same vector or colour in the first three rows."""
    for i in range(BLOCK):
        rows[i] = x
        rows[BLOCK + i] = y
        rows[2 * BLOCK + i] = z


@inlined
def _ray(rows: Any, i: int, x: Any, y: Any, z: Any, x_low: Any, y_low: Any, z_low: Any) -> tuple[Any, Any, Any]:
    return (x - rows[at.PX + i]) + x_low, (y - rows[at.PY + i]) + y_low, (z - rows[at.PZ + i]) + z_low


@inlined
def _keep_ray(rows: Any, i: int, x: Any, y: Any, z: Any) -> bool:
    """Note D with 1/|D|; gives whether it needs no rescue."""
    square = square_of(x, y, z)
    rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i] = x, y, z
    rows[at.NEARNESS + i] = inverse_root(square)
    return is_moderate(square)


@plain
def approach(rows: Any, x: Any, y: Any, z: Any, x_low: Any, y_low: Any, z_low: Any) -> bool:
    """D towards a position; gives whether none needs a rescue.

    With the position as a sum of two numbers of the points' type, D is right to the last bit that matters: the
    difference to the first number is exact wherever it is so small that the second one counts.
    """
    good = True
    for i in range(BLOCK):
        good = good & _keep_ray(rows, i, *_ray(rows, i, x, y, z, x_low, y_low, z_low))
    return good


@plain
def approach_wide(wide: Any, x: float, y: float, z: float, rows: Any) -> bool:
    """`approach` from points that are float64 where the rows are float32."""
    real = rows.dtype.type
    good = True
    for i in range(BLOCK):
        good = good & _keep_ray(rows, i, real(x - wide[i]), real(y - wide[BLOCK + i]), real(z - wide[2 * BLOCK + i]))
    return good


@plain
def measure_rays(rows: Any) -> None:
    """1/|D| for D that did not come from `approach`."""
    for i in range(BLOCK):
        rows[at.NEARNESS + i] = inverse_root(ray_square(rows, i))


@plain
def look(rows: Any) -> None:
    """V along rays to the eye; zero remains zero."""
    for i in range(BLOCK):
        inverse = rows[at.NEARNESS + i]
        rows[at.VX + i] = rows[at.DX + i] * inverse
        rows[at.VY + i] = rows[at.DY + i] * inverse
        rows[at.VZ + i] = rows[at.DZ + i] * inverse


@plain
def face(rows: Any) -> None:
    """n·v."""
    for i in range(BLOCK):
        rows[at.FACING + i] = _normal_dot(rows, i, rows[at.VX + i], rows[at.VY + i], rows[at.VZ + i])


@plain
def turn_to_viewer(rows: Any) -> None:
    """Replace n by −n where it points away from v."""
    for i in range(BLOCK):
        _turn(rows, i, _normal_dot(rows, i, rows[at.VX + i], rows[at.VY + i], rows[at.VZ + i]) < _ZERO)


@plain
def turn_to_axis(rows: Any) -> None:
    """Replace n by −n where it points away from the axis to the viewer."""
    for i in range(BLOCK):
        _turn(rows, i, _normal_dot(rows, i, rows[at.AX + i], rows[at.AY + i], rows[at.AZ + i]) < _ZERO)


@inlined
def _turn(rows: Any, i: int, is_away: bool) -> None:
    sign = -_ONE if is_away else _ONE  # a product is quicker than a store under a mask
    rows[at.NX + i] *= sign
    rows[at.NY + i] *= sign
    rows[at.NZ + i] *= sign


@inlined
def _lambert(rows: Any, i: int) -> Any:
    n_d = _normal_dot(rows, i, rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i])
    return max(n_d * (rows[at.NEARNESS + i] * rows[at.INVERSE + i]), _ZERO)


@inlined
def _add(rows: Any, i: int, factor: Any, red: Any, green: Any, blue: Any) -> None:
    rows[at.R + i] = multiply_add(red, factor, rows[at.R + i])
    rows[at.G + i] = multiply_add(green, factor, rows[at.G + i])
    rows[at.B + i] = multiply_add(blue, factor, rows[at.B + i])


@plain
def add_lambert(rows: Any, red: Any, green: Any, blue: Any) -> None:
    """Add a colour times max(n·l, 0)."""
    for i in range(BLOCK):
        _add(rows, i, _lambert(rows, i), red, green, blue)


@plain
def add_weakened(rows: Any, red: Any, green: Any, blue: Any) -> None:
    """`add_lambert`, times the strength."""
    for i in range(BLOCK):
        _add(rows, i, _lambert(rows, i) * rows[at.STRENGTH + i], red, green, blue)


@plain
def add_parallel(rows: Any, red: Any, green: Any, blue: Any, x: Any, y: Any, z: Any) -> None:
    """`add_lambert` for the same way (x, y, z) to the light everywhere, whose inverse length is in the colour."""
    for i in range(BLOCK):
        n_l = max(_normal_dot(rows, i, x, y, z) * rows[at.INVERSE + i], _ZERO)
        _add(rows, i, n_l, red, green, blue)


@plain
def phong(rows: Any, dark: Any) -> bool:
    """max(n·l, 0) and |C|² for C = 2(n·l)n − l − v; gives whether any vertex is lit with |C|² below `dark`.

    |C|² = |n × (l + v)|² + (n·l − n·v)² is next to 0 where n = l = v, and leaves out the rounding of |n|.
    """
    shines = False
    for i in range(BLOCK):
        nx, ny, nz, shrink = rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i], rows[at.INVERSE + i]
        dx, dy, dz, inverse = rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i], rows[at.NEARNESS + i]
        n_l = dot(nx, ny, nz, dx, dy, dz) * inverse
        sx = multiply_add(dx, inverse, rows[at.VX + i])
        sy = multiply_add(dy, inverse, rows[at.VY + i])
        sz = multiply_add(dz, inverse, rows[at.VZ + i])
        across = square_of(
            multiply_add(ny, sz, -(nz * sy)),
            multiply_add(nz, sx, -(nx * sz)),
            multiply_add(nx, sy, -(ny * sx)),
        )
        along = n_l - rows[at.FACING + i]
        chord = multiply_add(along, along, across) * (shrink * shrink)
        rows[at.COSINE + i] = max(n_l * shrink, _ZERO)
        rows[at.SHINE + i] = chord
        shines = shines | ((n_l > _ZERO) & (chord < dark))
    return shines


@plain
def blinn_phong(rows: Any, dark: Any) -> bool:
    """As `phong`, for C = h − n, h the unit vector of l + v; |C|² is 2 where l = −v and there is no h."""
    shines = False
    for i in range(BLOCK):
        dx, dy, dz = rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i]
        inverse, shrink = rows[at.NEARNESS + i], rows[at.INVERSE + i]
        n_l = _normal_dot(rows, i, dx, dy, dz) * (inverse * shrink)
        hx = multiply_add(dx, inverse, rows[at.VX + i]) * _LARGER
        hy = multiply_add(dy, inverse, rows[at.VY + i]) * _LARGER
        hz = multiply_add(dz, inverse, rows[at.VZ + i]) * _LARGER
        square = square_of(hx, hy, hz)
        unit = inverse_root(square)
        chord = square_of(
            hx * unit - rows[at.NX + i] * shrink,
            hy * unit - rows[at.NY + i] * shrink,
            hz * unit - rows[at.NZ + i] * shrink,
        )
        chord = chord if square > ZERO_SQUARE else _TWO
        rows[at.COSINE + i] = max(n_l, _ZERO)
        rows[at.SHINE + i] = chord
        shines = shines | ((n_l > _ZERO) & (chord < dark))
    return shines


@plain
def headlight(rows: Any, floor: Any) -> None:
    """max(n·l, floor), but 0 where there is no n, and |C|² for C = n − l: VTK's first tier."""
    for i in range(BLOCK):
        x, y, z = rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i]
        inverse, shrink = rows[at.NEARNESS + i], rows[at.INVERSE + i]
        nx, ny, nz = rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i]
        n_l = max(_normal_dot(rows, i, x, y, z) * (inverse * shrink), floor)
        rows[at.COSINE + i] = n_l if square_of(nx, ny, nz) > _ZERO else _ZERO
        rows[at.SHINE + i] = square_of(
            nx * shrink - x * inverse,
            ny * shrink - y * inverse,
            nz * shrink - z * inverse,
        )


@plain
def raise_shine(rows: Any, exponent: Any, least: Any, dark: Any) -> None:
    """The power of 1 − |C|²/2 in place of |C|²; 0 from the squared chord `dark` on.

    In two loops, because a processor sees no further ahead than some hundred steps, and each step of a polynomial
    waits for the one before: a third less time than in one.
    """
    for i in range(BLOCK):
        square = rows[at.SHINE + i]
        raised = log2_power(square, exponent, least)
        rows[at.SHINE + i] = raised if square < dark else _NEVER
    for i in range(BLOCK):
        y = rows[at.SHINE + i]
        rows[at.SHINE + i] = exp2(y) if y > _NEVER else _ZERO


@inlined
def strength(square: Any, constant: Any, linear: Any, quadratic: Any, gain: Any) -> Any:
    """Gain / (c + l·d + q·d²) for d², at most `BRIGHTEST`."""
    distance = np.sqrt(square)
    weakening = multiply_add(multiply_add(quadratic, distance, linear), distance, constant)
    return min(gain / weakening, _BRIGHTEST)


@plain
def attenuate(rows: Any, constant: Any, linear: Any, quadratic: Any, gain: Any) -> None:
    """Strength at the ends of the rays."""
    for i in range(BLOCK):
        rows[at.STRENGTH + i] = strength(ray_square(rows, i), constant, linear, quadratic, gain)


@plain
def find_cone(rows: Any, x: Any, y: Any, z: Any, edge: Any) -> None:
    """|C|² for C = l + axis; and, in the row of n·l, 1 inside the cone's edge and 0 outside."""
    for i in range(BLOCK):
        inverse = rows[at.NEARNESS + i]
        square = square_of(
            rows[at.DX + i] * inverse + x,
            rows[at.DY + i] * inverse + y,
            rows[at.DZ + i] * inverse + z,
        )
        rows[at.SHINE + i] = square
        rows[at.COSINE + i] = _ONE if square <= edge else _ZERO


@plain
def apply_cone(rows: Any) -> None:
    """Multiply the strength by what `find_cone` and `raise_shine` left."""
    for i in range(BLOCK):
        rows[at.STRENGTH + i] *= rows[at.COSINE + i] * rows[at.SHINE + i]


@plain
def apply_strength(rows: Any) -> None:
    """Multiply both factors of a light with highlights by the strength."""
    for i in range(BLOCK):
        rows[at.COSINE + i] *= rows[at.STRENGTH + i]
        rows[at.SHINE + i] *= rows[at.STRENGTH + i]


@plain
def add_strength(rows: Any, red: Any, green: Any, blue: Any) -> None:
    """Add a colour times the light's strength."""
    for i in range(BLOCK):
        _add(rows, i, rows[at.STRENGTH + i], red, green, blue)


@plain
def add_matt(rows: Any, red: Any, green: Any, blue: Any) -> None:
    """Add a colour times n·l."""
    for i in range(BLOCK):
        _add(rows, i, rows[at.COSINE + i], red, green, blue)


@inlined
def _lit_shine(rows: Any, i: int) -> Any:
    shine = rows[at.SHINE + i]  # read whether it is needed or not, for reading under a mask takes longer
    return shine if rows[at.COSINE + i] > _ZERO else _ZERO


@plain
def add_highlight(rows: Any, red: Any, green: Any, blue: Any) -> None:
    """Add, apart from the matt part, a colour times the highlight where n·l is positive."""
    for i in range(BLOCK):
        factor = _lit_shine(rows, i)
        rows[at.HR + i] = multiply_add(red, factor, rows[at.HR + i])
        rows[at.HG + i] = multiply_add(green, factor, rows[at.HG + i])
        rows[at.HB + i] = multiply_add(blue, factor, rows[at.HB + i])


@plain
def add_both(rows: Any, red: Any, green: Any, blue: Any, shiny_red: Any, shiny_green: Any, shiny_blue: Any) -> None:
    """Both at half the traffic, where no albedo keeps them apart."""
    for i in range(BLOCK):
        matt, shine = rows[at.COSINE + i], _lit_shine(rows, i)
        rows[at.R + i] = multiply_add(shiny_red, shine, multiply_add(red, matt, rows[at.R + i]))
        rows[at.G + i] = multiply_add(shiny_green, shine, multiply_add(green, matt, rows[at.G + i]))
        rows[at.B + i] = multiply_add(shiny_blue, shine, multiply_add(blue, matt, rows[at.B + i]))
