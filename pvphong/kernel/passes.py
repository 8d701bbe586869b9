"""The kernel's loops that light one block of vertices. Each is simple enough for LLVM to vectorise.

Symbols: p a vertex, n its normal (of any length), v the unit vector to the viewer, D the way from p to a light,
l = D/|D|; C the chord of a highlight or a cone, whose squared length is 2(1 − cosine).

A block's values stand row after row in one flat array: rows at fixed distances are what LLVM needs to know that
they do not overlap, and counting references to many arrays would cost as much as the arithmetic. Literals are
float32: a Python float would widen float32 arithmetic, and these are widened, exactly, where rows are float64.

There is no fast-math here: each vertex's bits are what IEEE arithmetic makes of its own numbers.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pvphong.equation import BRIGHTEST
from pvphong.kernel import rows as at
from pvphong.kernel.arithmetic import inlined, plain, power
from pvphong.kernel.rows import BLOCK
from pvphong.kernel.vectors import ZERO_SQUARE, inverse_root, is_moderate, square_of

_ZERO, _ONE, _TWO, _BRIGHTEST = np.float32(0.0), np.float32(1.0), np.float32(2.0), np.float32(BRIGHTEST)


@inlined
def ray_square(rows: Any, i: int) -> Any:
    """|D|²."""
    return square_of(rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i])


@inlined
def _normal_dot(rows: Any, i: int, x: Any, y: Any, z: Any) -> Any:
    return rows[at.NX + i] * x + rows[at.NY + i] * y + rows[at.NZ + i] * z


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


@plain
def approach(rows: Any, x: Any, y: Any, z: Any, x_low: Any, y_low: Any, z_low: Any) -> bool:
    """D towards a position; gives whether none needs a rescue.

    With the position as a sum of two numbers of the points' type, D is right to the last bit that matters: the
    difference to the first number is exact wherever it is so small that the second one counts.
    """
    good = True
    for i in range(BLOCK):
        dx, dy, dz = _ray(rows, i, x, y, z, x_low, y_low, z_low)
        rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i] = dx, dy, dz
        good = good & is_moderate(square_of(dx, dy, dz))
    return good


@plain
def approach_wide(wide: Any, x: float, y: float, z: float, rows: Any) -> bool:
    """`approach` from points that are float64 where the rows are float32."""
    good = True
    for i in range(BLOCK):
        rows[at.DX + i] = x - wide[i]
        rows[at.DY + i] = y - wide[BLOCK + i]
        rows[at.DZ + i] = z - wide[2 * BLOCK + i]
        good = good & is_moderate(ray_square(rows, i))
    return good


@plain
def look(rows: Any) -> None:
    """V along rays to the eye; zero remains zero."""
    for i in range(BLOCK):
        inverse = inverse_root(ray_square(rows, i))
        rows[at.VX + i] = rows[at.DX + i] * inverse
        rows[at.VY + i] = rows[at.DY + i] * inverse
        rows[at.VZ + i] = rows[at.DZ + i] * inverse


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
    x, y, z = rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i]
    rows[at.NX + i] = -x if is_away else x
    rows[at.NY + i] = -y if is_away else y
    rows[at.NZ + i] = -z if is_away else z


@inlined
def _lambert(rows: Any, i: int, x: Any, y: Any, z: Any, square: Any) -> None:
    n_l = _normal_dot(rows, i, x, y, z) * (inverse_root(square) * rows[at.INVERSE + i])
    rows[at.COSINE + i] = max(n_l, _ZERO)


@plain
def lambert(rows: Any) -> None:
    """max(n·l, 0)."""
    for i in range(BLOCK):
        x, y, z = rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i]
        _lambert(rows, i, x, y, z, square_of(x, y, z))


@plain
def lambert_near(rows: Any, x: Any, y: Any, z: Any, x_low: Any, y_low: Any, z_low: Any) -> bool:
    """`approach` and `lambert` in one, without the rays; if any of them needs a rescue the result is useless."""
    good = True
    for i in range(BLOCK):
        dx, dy, dz = _ray(rows, i, x, y, z, x_low, y_low, z_low)
        square = square_of(dx, dy, dz)
        _lambert(rows, i, dx, dy, dz, square)
        good = good & is_moderate(square)
    return good


@plain
def lambert_parallel(rows: Any, x: Any, y: Any, z: Any) -> None:
    """max(n·l, 0) for the same unit vector l everywhere."""
    for i in range(BLOCK):
        rows[at.COSINE + i] = max(_normal_dot(rows, i, x, y, z) * rows[at.INVERSE + i], _ZERO)


@inlined
def _phong(rows: Any, i: int, dx: Any, dy: Any, dz: Any, square: Any, dark: Any) -> bool:
    nx, ny, nz, shrink = rows[at.NX + i], rows[at.NY + i], rows[at.NZ + i], rows[at.INVERSE + i]
    vx, vy, vz = rows[at.VX + i], rows[at.VY + i], rows[at.VZ + i]
    inverse = inverse_root(square)
    lx, ly, lz = dx * inverse, dy * inverse, dz * inverse
    n_l = (nx * dx + ny * dy + nz * dz) * (inverse * shrink)
    sx, sy, sz = lx + vx, ly + vy, lz + vz
    across = square_of(ny * sz - nz * sy, nz * sx - nx * sz, nx * sy - ny * sx)
    along = nx * (lx - vx) + ny * (ly - vy) + nz * (lz - vz)
    chord = (across + along * along) * (shrink * shrink)
    rows[at.COSINE + i] = max(n_l, _ZERO)
    rows[at.SHINE + i] = chord
    return (n_l > _ZERO) & (chord < dark)


@plain
def phong(rows: Any, dark: Any) -> bool:
    """max(n·l, 0) and |C|² for C = 2(n·l)n − l − v; gives whether any vertex is lit with |C|² below `dark`.

    |C|² = |n × (l + v)|² + (n·(l − v))² is exactly 0 where n = l = v, and leaves out the rounding of |n|.
    """
    shines = False
    for i in range(BLOCK):
        x, y, z = rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i]
        shines = shines | _phong(rows, i, x, y, z, square_of(x, y, z), dark)
    return shines


@plain
def phong_near(rows: Any, dark: Any, x: Any, y: Any, z: Any, x_low: Any, y_low: Any, z_low: Any) -> tuple[bool, bool]:
    """`approach` and `phong` in one, without the rays; if any of them needs a rescue the result is useless."""
    good, shines = True, False
    for i in range(BLOCK):
        dx, dy, dz = _ray(rows, i, x, y, z, x_low, y_low, z_low)
        square = square_of(dx, dy, dz)
        shines = shines | _phong(rows, i, dx, dy, dz, square, dark)
        good = good & is_moderate(square)
    return good, shines


@plain
def blinn_phong(rows: Any, dark: Any) -> bool:
    """As `phong`, for C = h − n, h the unit vector of l + v; |C|² is 2 where l = −v and there is no h."""
    shines = False
    for i in range(BLOCK):
        dx, dy, dz = rows[at.DX + i], rows[at.DY + i], rows[at.DZ + i]
        inverse, shrink = inverse_root(square_of(dx, dy, dz)), rows[at.INVERSE + i]
        n_l = _normal_dot(rows, i, dx, dy, dz) * (inverse * shrink)
        hx, hy, hz = dx * inverse + rows[at.VX + i], dy * inverse + rows[at.VY + i], dz * inverse + rows[at.VZ + i]
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
        inverse, shrink = inverse_root(square_of(x, y, z)), rows[at.INVERSE + i]
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
    """The power of 1 − |C|²/2 in place of |C|²; 0 from the squared chord `dark` on."""
    for i in range(BLOCK):
        square = rows[at.SHINE + i]
        raised = power(square, exponent, least)
        rows[at.SHINE + i] = raised if square < dark else _ZERO


@inlined
def strength(square: Any, constant: Any, linear: Any, quadratic: Any, gain: Any) -> Any:
    """Gain / (c + l·d + q·d²) for d², at most `BRIGHTEST`."""
    distance = np.sqrt(square)
    weakening = (quadratic * distance + linear) * distance + constant
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
        inverse = inverse_root(ray_square(rows, i))
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
    """Multiply both factors by the strength."""
    for i in range(BLOCK):
        rows[at.COSINE + i] *= rows[at.STRENGTH + i]
        rows[at.SHINE + i] *= rows[at.STRENGTH + i]


@plain
def add_strength(rows: Any, red: Any, green: Any, blue: Any) -> None:
    """Add a colour times the light's strength."""
    for i in range(BLOCK):
        factor = rows[at.STRENGTH + i]
        rows[at.R + i] += red * factor
        rows[at.G + i] += green * factor
        rows[at.B + i] += blue * factor


@plain
def add_matt(rows: Any, red: Any, green: Any, blue: Any) -> None:
    """Add a colour times n·l."""
    for i in range(BLOCK):
        factor = rows[at.COSINE + i]
        rows[at.R + i] += red * factor
        rows[at.G + i] += green * factor
        rows[at.B + i] += blue * factor


@inlined
def _lit_shine(rows: Any, i: int) -> Any:
    return rows[at.SHINE + i] if rows[at.COSINE + i] > _ZERO else _ZERO


@plain
def add_highlight(rows: Any, red: Any, green: Any, blue: Any) -> None:
    """Add, apart from the matt part, a colour times the highlight where n·l is positive."""
    for i in range(BLOCK):
        factor = _lit_shine(rows, i)
        rows[at.HR + i] += red * factor
        rows[at.HG + i] += green * factor
        rows[at.HB + i] += blue * factor


@plain
def add_both(rows: Any, red: Any, green: Any, blue: Any, shiny_red: Any, shiny_green: Any, shiny_blue: Any) -> None:
    """Both at half the traffic, where no albedo keeps them apart."""
    for i in range(BLOCK):
        matt, shine = rows[at.COSINE + i], _lit_shine(rows, i)
        rows[at.R + i] += red * matt + shiny_red * shine
        rows[at.G + i] += green * matt + shiny_green * shine
        rows[at.B + i] += blue * matt + shiny_blue * shine
