"""The kernel's loops over one block of vertices. Each is simple enough for LLVM to vectorise.

Symbols: p a vertex, n its normal (of any length), v the unit vector to the viewer, D = the way from p to a
light, l = D/|D|; C the chord of a highlight or a cone, whose squared length is 2(1 − cosine).

A block's values stand row after row in flat arrays: the x of all vertices, then all y, then all z. Rows at
fixed distances from each other are what LLVM needs to know that they do not overlap. Literals are float32: a
Python float would widen float32 arithmetic, and these are widened, exactly, where the rows are float64.

There is no fast-math here: each vertex's bits are what IEEE arithmetic makes of its own numbers.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pvphong._kernel_math import inlined, plain, power
from pvphong.equation import BRIGHTEST

# Measured: 128 to 256 vertices keep all rows within 32 KiB of first-level cache; a multiple of every vector's length.
BLOCK = 256

X, Y, Z = 0, BLOCK, 2 * BLOCK
"""Rows of vectors, and of colours."""

INVERSE, MIRROR = 3 * BLOCK, 4 * BLOCK
"""Further rows of the normals: 1/|n| and 2/|n|²."""

COSINE, SHINE, STRENGTH = 0, BLOCK, 2 * BLOCK
"""Rows of one light's factors: n·l; the highlight's squared chord, then its fⁿ; attenuation times spot factor."""

# Squared lengths between these have lost no bit to underflow, in float32 as in float64.
_LEAST_SQUARE, _MOST_SQUARE = np.float32(2.0**-80), np.float32(2.0**120)

_INFINITE = np.float32(np.inf)

# Stands in for the square of a zero vector, which then remains zero when it is made unit length.
_ZERO_SQUARE = np.float32(2.0**-126)

_ZERO, _ONE, _TWO, _BRIGHTEST = np.float32(0.0), np.float32(1.0), np.float32(2.0), np.float32(BRIGHTEST)

# Adding it rounds to an integer, which then stands in the last bits of the mantissa.
_WHOLE = np.float32(1.5 * 2**23)


@inlined
def square_of(rows: Any, i: int) -> Any:
    """Squared length of a row's vector."""
    return rows[X + i] * rows[X + i] + rows[Y + i] * rows[Y + i] + rows[Z + i] * rows[Z + i]


@inlined
def _inverse_length(rows: Any, i: int) -> Any:
    return _ONE / np.sqrt(max(square_of(rows, i), _ZERO_SQUARE))


@inlined
def _dot(a: Any, b: Any, i: int) -> Any:
    return a[X + i] * b[X + i] + a[Y + i] * b[Y + i] + a[Z + i] * b[Z + i]


@inlined
def is_moderate(square: Any) -> bool:
    """Whether a vector of that squared length needs no rescue; False for NaN."""
    return square >= _LEAST_SQUARE and square <= _MOST_SQUARE


@plain
def split(array: Any, rows: Any) -> None:
    """Vectors one after the other into rows; the last one fills up the block."""
    count = len(array) // 3
    for i in range(count):
        rows[X + i] = array[3 * i]
        rows[Y + i] = array[3 * i + 1]
        rows[Z + i] = array[3 * i + 2]
    for i in range(count, BLOCK):
        rows[X + i] = rows[X + count - 1]
        rows[Y + i] = rows[Y + count - 1]
        rows[Z + i] = rows[Z + count - 1]


@plain
def fill(rows: Any, x: float, y: float, z: float) -> None:
    """The same vector everywhere."""
    for i in range(BLOCK):
        rows[X + i] = x
        rows[Y + i] = y
        rows[Z + i] = z


@plain
def measure(normals: Any) -> int:
    """Fill in the further rows of the normals; gives the number of normals that need a rescue."""
    rare = 0
    for i in range(BLOCK):
        inverse = _inverse_length(normals, i)
        normals[INVERSE + i] = inverse
        normals[MIRROR + i] = _TWO * inverse * inverse
        rare += not is_moderate(square_of(normals, i))
    return rare


@plain
def approach(points: Any, x: float, y: float, z: float, ray: Any) -> int:
    """D towards (x, y, z), a float64 position; gives the number of vertices that need a rescue.

    With the position as a sum of two numbers of the points' own type, both differences are right to the last
    bit that matters: the first is exact wherever it is so small that the second counts.
    """
    real = points.dtype.type
    x_high, y_high, z_high = real(x), real(y), real(z)
    x_low, y_low, z_low = real(x - np.float64(x_high)), real(y - np.float64(y_high)), real(z - np.float64(z_high))
    rare = 0
    for i in range(BLOCK):
        ray[X + i] = (x_high - points[X + i]) + x_low
        ray[Y + i] = (y_high - points[Y + i]) + y_low
        ray[Z + i] = (z_high - points[Z + i]) + z_low
        rare += not is_moderate(square_of(ray, i))
    return rare


@plain
def approach_wide(points: Any, x: float, y: float, z: float, ray: Any) -> int:
    """`approach` for points that are float64 where the rays are float32."""
    rare = 0
    for i in range(BLOCK):
        ray[X + i] = x - points[X + i]
        ray[Y + i] = y - points[Y + i]
        ray[Z + i] = z - points[Z + i]
        rare += not is_moderate(square_of(ray, i))
    return rare


@plain
def copy(source: Any, rows: Any) -> None:
    """Vectors from rows of one type into rows of another."""
    for i in range(BLOCK):
        rows[X + i] = source[X + i]
        rows[Y + i] = source[Y + i]
        rows[Z + i] = source[Z + i]


@plain
def transform(matrix: Any, w: float, rows: Any) -> int:
    """(L p + t) / w for float64 points and a (3, 4) matrix (L | t); gives the number of those that are not finite."""
    rare = 0
    for i in range(BLOCK):
        x, y, z = rows[X + i], rows[Y + i], rows[Z + i]
        rows[X + i] = (matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z + matrix[0, 3]) / w
        rows[Y + i] = (matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z + matrix[1, 3]) / w
        rows[Z + i] = (matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z + matrix[2, 3]) / w
        rare += not square_of(rows, i) < _INFINITE
    return rare


@plain
def rotate(matrix: Any, rows: Any) -> None:
    """(3, 3) matrix times float64 vectors."""
    for i in range(BLOCK):
        x, y, z = rows[X + i], rows[Y + i], rows[Z + i]
        rows[X + i] = matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z
        rows[Y + i] = matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z
        rows[Z + i] = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z


@plain
def make_unit(rows: Any) -> None:
    """Divide by lengths; zero remains zero."""
    for i in range(BLOCK):
        inverse = _inverse_length(rows, i)
        rows[X + i] *= inverse
        rows[Y + i] *= inverse
        rows[Z + i] *= inverse


@plain
def turn(normals: Any, facing: Any) -> None:
    """Replace n by −n where it points away from `facing`."""
    for i in range(BLOCK):
        away = _dot(normals, facing, i) < _ZERO
        normals[X + i] = -normals[X + i] if away else normals[X + i]
        normals[Y + i] = -normals[Y + i] if away else normals[Y + i]
        normals[Z + i] = -normals[Z + i] if away else normals[Z + i]


@plain
def lambert(normals: Any, ray: Any, factors: Any) -> None:
    """max(n·l, 0)."""
    for i in range(BLOCK):
        n_l = _dot(normals, ray, i) * (_inverse_length(ray, i) * normals[INVERSE + i])
        factors[COSINE + i] = max(n_l, _ZERO)


@plain
def lambert_parallel(normals: Any, x: Any, y: Any, z: Any, factors: Any) -> None:
    """max(n·l, 0) for the same unit l everywhere."""
    for i in range(BLOCK):
        n_l = (normals[X + i] * x + normals[Y + i] * y + normals[Z + i] * z) * normals[INVERSE + i]
        factors[COSINE + i] = max(n_l, _ZERO)


@plain
def phong(normals: Any, viewer: Any, ray: Any, factors: Any) -> None:
    """max(n·l, 0) and |C|² for C = 2(n·l)n − l − v."""
    for i in range(BLOCK):
        inverse = _inverse_length(ray, i)
        n_l = _dot(normals, ray, i) * inverse
        twice = n_l * normals[MIRROR + i]
        x = twice * normals[X + i] - ray[X + i] * inverse - viewer[X + i]
        y = twice * normals[Y + i] - ray[Y + i] * inverse - viewer[Y + i]
        z = twice * normals[Z + i] - ray[Z + i] * inverse - viewer[Z + i]
        factors[COSINE + i] = max(n_l * normals[INVERSE + i], _ZERO)
        factors[SHINE + i] = x * x + y * y + z * z


@plain
def blinn_phong(normals: Any, viewer: Any, ray: Any, factors: Any) -> None:
    """max(n·l, 0) and |C|² for C = h − n, h the unit vector of l + v; where l = −v there is none, and |C|² is 2."""
    for i in range(BLOCK):
        inverse, shrink = _inverse_length(ray, i), normals[INVERSE + i]
        n_l = _dot(normals, ray, i) * inverse
        x = ray[X + i] * inverse + viewer[X + i]
        y = ray[Y + i] * inverse + viewer[Y + i]
        z = ray[Z + i] * inverse + viewer[Z + i]
        square = x * x + y * y + z * z
        unit = _ONE / np.sqrt(max(square, _ZERO_SQUARE))
        x = x * unit - normals[X + i] * shrink
        y = y * unit - normals[Y + i] * shrink
        z = z * unit - normals[Z + i] * shrink
        factors[COSINE + i] = max(n_l * shrink, _ZERO)
        factors[SHINE + i] = x * x + y * y + z * z if square > _ZERO_SQUARE else _TWO


@plain
def headlight(normals: Any, ray: Any, floor: Any, factors: Any) -> None:
    """max(n·l, floor) and |C|² for C = n − l: VTK's first tier."""
    for i in range(BLOCK):
        inverse, shrink = _inverse_length(ray, i), normals[INVERSE + i]
        x = normals[X + i] * shrink - ray[X + i] * inverse
        y = normals[Y + i] * shrink - ray[Y + i] * inverse
        z = normals[Z + i] * shrink - ray[Z + i] * inverse
        factors[COSINE + i] = max(_dot(normals, ray, i) * (inverse * shrink), floor)
        factors[SHINE + i] = x * x + y * y + z * z


@plain
def raise_shine(factors: Any, exponent: Any, most: Any, dark: Any) -> None:
    """The power of 1 − |C|²/2, in place of |C|²; 0 from the squared chord `dark` on."""
    for i in range(BLOCK):
        square = factors[SHINE + i]
        raised = power(square, exponent, most)
        factors[SHINE + i] = raised if square < dark else _ZERO


@inlined
def strength(square: Any, constant: Any, linear: Any, quadratic: Any, gain: Any) -> Any:
    """Gain / (c + l·d + q·d²) for d², at most `BRIGHTEST`."""
    distance = np.sqrt(square)
    weakening = (quadratic * distance + linear) * distance + constant
    return min(gain / weakening, _BRIGHTEST)


@plain
def attenuate(ray: Any, constant: Any, linear: Any, quadratic: Any, gain: Any, factors: Any) -> None:
    """Strength at the ends of the rays."""
    for i in range(BLOCK):
        factors[STRENGTH + i] = strength(square_of(ray, i), constant, linear, quadratic, gain)


@plain
def cone(ray: Any, x: Any, y: Any, z: Any, edge: Any, factors: Any) -> None:
    """|C|² for C = l + axis, and, in the row of n·l, 1 inside the cone's edge and 0 outside."""
    for i in range(BLOCK):
        inverse = _inverse_length(ray, i)
        cx, cy, cz = ray[X + i] * inverse + x, ray[Y + i] * inverse + y, ray[Z + i] * inverse + z
        square = cx * cx + cy * cy + cz * cz
        factors[SHINE + i] = square
        factors[COSINE + i] = _ONE if square <= edge else _ZERO


@plain
def narrow(factors: Any) -> None:
    """Multiply the strength by what `cone` and `raise_shine` left."""
    for i in range(BLOCK):
        factors[STRENGTH + i] *= factors[COSINE + i] * factors[SHINE + i]


@plain
def dim(factors: Any) -> None:
    """Multiply both factors by the strength."""
    for i in range(BLOCK):
        factors[COSINE + i] *= factors[STRENGTH + i]
        factors[SHINE + i] *= factors[STRENGTH + i]


@plain
def add_strength(factors: Any, red: Any, green: Any, blue: Any, colors: Any) -> None:
    """Add a colour times the light's strength."""
    for i in range(BLOCK):
        factor = factors[STRENGTH + i]
        colors[X + i] += red * factor
        colors[Y + i] += green * factor
        colors[Z + i] += blue * factor


@plain
def add_matt(factors: Any, red: Any, green: Any, blue: Any, colors: Any) -> None:
    """Add a colour times n·l."""
    for i in range(BLOCK):
        factor = factors[COSINE + i]
        colors[X + i] += red * factor
        colors[Y + i] += green * factor
        colors[Z + i] += blue * factor


@plain
def add_shiny(factors: Any, red: Any, green: Any, blue: Any, colors: Any) -> None:
    """Add a colour times the highlight, where n·l is positive."""
    for i in range(BLOCK):
        factor = factors[SHINE + i] if factors[COSINE + i] > _ZERO else _ZERO
        colors[X + i] += red * factor
        colors[Y + i] += green * factor
        colors[Z + i] += blue * factor


@plain
def add_both(factors: Any, red: Any, green: Any, blue: Any, r: Any, g: Any, b: Any, colors: Any) -> None:
    """`add_matt` with red, green, blue and `add_shiny` with r, g, b, at half the traffic."""
    for i in range(BLOCK):
        matt = factors[COSINE + i]
        shiny = factors[SHINE + i] if matt > _ZERO else _ZERO
        colors[X + i] += red * matt + r * shiny
        colors[Y + i] += green * matt + g * shiny
        colors[Z + i] += blue * matt + b * shiny


@plain
def tint(colors: Any, albedo: Any, highlights: Any) -> None:
    """Colour times albedo plus highlights."""
    for i in range(BLOCK):
        colors[X + i] = colors[X + i] * albedo[X + i] + highlights[X + i]
        colors[Y + i] = colors[Y + i] * albedo[Y + i] + highlights[Y + i]
        colors[Z + i] = colors[Z + i] * albedo[Z + i] + highlights[Z + i]


@plain
def join(colors: Any, low: Any, high: Any, rgb: Any) -> None:
    """Colours, clipped to [low, high], one after the other."""
    for i in range(len(rgb) // 3):
        rgb[3 * i] = min(max(colors[X + i], low), high)
        rgb[3 * i + 1] = min(max(colors[Y + i], low), high)
        rgb[3 * i + 2] = min(max(colors[Z + i], low), high)


@inlined
def _byte(intensity: Any) -> Any:
    """0-255 for an intensity clipped to [0, 1], the nearest, and of two equally near the even one."""
    clipped = min(max(np.float32(intensity), _ZERO), _ONE)
    return np.uint8(np.float32(clipped * np.float32(255.0) + _WHOLE).view(np.int32))


@plain
def join_bytes(colors: Any, display: Any) -> None:
    """`join` for uint8."""
    for i in range(len(display) // 3):
        display[3 * i] = _byte(colors[X + i])
        display[3 * i + 1] = _byte(colors[Y + i])
        display[3 * i + 2] = _byte(colors[Z + i])
