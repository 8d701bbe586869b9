"""Operations for formulas. Each formula is written once: NumPy runs it on arrays, compiled code on single vertices.

A formula is a function of numbers and vectors that returns numbers and vectors. A number is a float in compiled code,
and an array (n,) in NumPy. A vector is anything with three entries: a tuple of numbers in compiled code, an array
(3, n) in NumPy.

A formula is marked by `formula`, and calls only operations of this module and other formulas. Most formulas have no
branches: `select` chooses, and both sides are computed. Formulas of lights with a size also have loops, and
`if any_of(...)` to skip work that no vertex needs.

Numbers may be float32 or float64. A Python float would widen float32 in compiled code. So the constants `ZERO`, `HALF`,
`ONE` and `TWO` are float32, which is exact in either type, and other constants are written `as_type_of(x, 0.3)`.

The compiled form of each operation for one vertex is in `pvphong.shading.kernel.arithmetic`. Formulas of lights with a
size run on eight vertices at once, with `pvphong.shading.kernel.lanes`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numpy as np

Function = TypeVar("Function", bound=Callable[..., Any])

FORMULAS: list[Callable[..., Any]] = []
"""All functions marked by `formula`."""

ZERO, HALF, ONE, TWO = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(2.0)

BRIGHTEST = 2.0**100
"""Upper limit of strengths, colours and exponents, so that nothing overflows float32; values near it are white.

(The kernel caps a spot's attenuation before its falloff. If the attenuation has no constant term, a spot may be too
dark off its axis, but only at distances below 2⁻⁵⁰ times the distance at which the attenuation is 1.)"""

FAINTEST = 2.0**-126
"""The smallest normal float32."""

FARTHEST = 2.0**1000
"""Upper limit of a light's colours before attenuation. Attenuation may reduce such colours to float32's range."""

LEAST_SQUARE = np.float32(FAINTEST)
"""Replacement for the square of a zero vector, so that normalization keeps the vector zero."""


def formula(function: Function) -> Function:
    """Mark a function as a formula, which compiled code can call too; return the function unchanged."""
    FORMULAS.append(function)
    return function


# --- operations, in their NumPy form


def sqrt(x: Any) -> Any:
    """Return the square root √x."""
    return np.sqrt(x)


def minimum(a: Any, b: Any) -> Any:
    """Return the smaller of two numbers."""
    return np.minimum(a, b)


def maximum(a: Any, b: Any) -> Any:
    """Return the larger of two numbers."""
    return np.maximum(a, b)


def select(condition: Any, a: Any, b: Any) -> Any:
    """Return `a` where the condition holds, else `b`. Combine conditions with `&`, `|` and `~`."""
    return np.where(condition, a, b)


def multiply_add(a: Any, b: Any, c: Any) -> Any:
    """Return a·b + c. Compiled code rounds the result once, NumPy rounds product and sum."""
    return a * b + c


def as_type_of(x: Any, value: Any) -> Any:
    """Convert the number `value` to the float type of x."""
    return x.dtype.type(value)


def single(x: Any) -> Any:
    """Convert a number to float32."""
    return x.astype(np.float32)


def wrapped(x: Any) -> Any:
    """Convert a whole number to uint32, modulo 2³²."""
    return x.astype(np.uint32, copy=False)


def index(x: Any) -> Any:
    """Round x >= 0 down to an integer, to be used as an index of a table."""
    return x.astype(np.int64)


def floor(x: Any) -> Any:
    """Return the greatest whole number that is at most x."""
    return np.floor(x)


def nearest(x: Any) -> Any:
    """Return the nearest whole number."""
    return np.rint(x)


def over_its_size(x: Any) -> Any:
    """Return the power of two whose product with x is in [1, 2), for 0 < x <= 2¹⁰⁰⁰.

    For greater x, return the result for 2¹⁰⁰⁰.
    """
    return np.ldexp(1.0, 1 - np.frexp(np.minimum(x, 2.0**1000))[1])


def arctan2(y: Any, x: Any) -> Any:
    """Return the angle of the point (x, y) from the x axis, in [−π, π]; 0 at the origin."""
    return np.arctan2(y, x)


def sine(x: Any) -> Any:
    """Return the sine of x in radians; accurate if |x| is at most a few full turns."""
    return np.sin(x)


def cosine(x: Any) -> Any:
    """Return the cosine of x in radians. The absolute error is a few units in the last place of the number 1."""
    return np.cos(x)


def log1p(x: Any) -> Any:
    """Return the natural logarithm of 1 + x."""
    return np.log1p(x)


def power_less_one(less: Any, exponent: Any) -> Any:
    """Return zᵖ − 1 for z = max(1 − `less`, 0) and p = `exponent`; 0⁰ is 1.

    The result is accurate near z = 1 too.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(exponent > 0.0, np.expm1(exponent * np.log1p(-np.minimum(less, 1.0))), 0.0)


def any_of(conditions: Any) -> Any:
    """Return True if `conditions` is true for at least one vertex.

    With `if any_of(...)`, a formula skips work that no vertex needs.
    """
    return np.any(conditions)


def largest(x: Any) -> Any:
    """Return the largest of the whole numbers x >= 0 as an int.

    Formulas use it as the number of loop steps that suffices for all vertices.
    """
    return int(np.max(x, initial=0.0))


def exponential(x: Any) -> Any:
    """Return the exponential eˣ for x <= 0."""
    return np.exp(x)


def chord_power(squared: Any, exponent: Any, floor: float = 0.0) -> Any:
    """Return max(f, floor)ⁿ for a cosine f, given by the chord C of its angle: f = 1 − ½|C|².

    Parameters
    ----------
    squared : number
        The squared length |C|².
    exponent : number
        The exponent n. For n = 0 the result is 1.
    floor : float, default 0
        Least value of the cosine.

    Notes
    -----
    The power is computed as exp(n · log1p(−½|C|²)), which is accurate near f = 1.
    """
    real = squared.dtype.type
    is_flat = np.equal(exponent, 0.0)
    if is_flat.all():
        return real(1.0)
    d = np.minimum(real(0.5) * squared, real(1.0))
    # NumPy's log1p is slow, so compute log(1 − d): with f the rounded 1 − d and e = (f − 1) + d its error, which is
    # exact (Sterbenz) or far below the last bit, log(f − e) = log f − e/f + O(e²)
    f = 1.0 - d
    error = f - 1.0
    error += d
    error /= np.maximum(f, np.finfo(real).tiny)
    with np.errstate(divide="ignore"):  # the far hemisphere: log(0) = -inf, and the power is 0
        logarithm = np.log(f, out=f)
    logarithm -= error
    if floor:  # applied to the logarithm: rounding 1 − floor would lose most digits of a small floor
        np.maximum(logarithm, real(math.log(floor)), out=logarithm)
    logarithm *= np.clip(exponent, float(np.finfo(real).tiny), BRIGHTEST).astype(real)
    if real is np.float32:
        result = np.exp(logarithm, out=logarithm)
    else:  # NumPy's exp is up to 50 times slower for smaller numbers, whose power is set to 0
        shows = logarithm > -707.5
        np.maximum(logarithm, -707.5, out=logarithm)
        result = np.exp(logarithm, out=logarithm)
        result *= shows
    np.copyto(result, 1.0, where=is_flat)
    return result


class Power(NamedTuple):
    """A power of a cosine f: max(f, floor)ⁿ, with the exponent n."""

    exponent: Any
    """The exponent n >= 0: a number, or an array with an exponent for each vertex."""
    floor: float = 0.0

    @property
    def numbers(self) -> tuple[float, float, float]:
        """Three numbers by which compiled code computes the power.

        The first is n, limited to float32's range. The second is log2(floor). The third is a limit of the squared chord
        |C|², where f = 1 − ½|C|²: at this limit and above, the power is 0.
        """
        exponent = self.exponent and max(FAINTEST, min(self.exponent, BRIGHTEST))
        log_floor = math.log2(self.floor) if self.floor else -math.inf
        return exponent, log_floor, math.inf if self.floor or not self.exponent else 2.0


@formula
def horner(t: Any, coefficients: Any) -> Any:
    """Evaluate a polynomial in t. `coefficients` are constants, from the highest power to the lowest.

    Compilers unroll the loop for up to about a dozen terms.
    """
    total = coefficients[0]
    for k in range(1, len(coefficients)):
        total = total * t + coefficients[k]
    return total


# --- vectors


@formula
def dot(a: Any, b: Any) -> Any:
    """Return the dot product of two vectors, summed in the order x, y, z.

    Multiplications and additions are rounded separately, so that terms that cancel exactly give 0.
    """
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@formula
def square(w: Any) -> Any:
    """Return the squared length |w|² of a vector."""
    return multiply_add(w[2], w[2], multiply_add(w[1], w[1], w[0] * w[0]))


@formula
def add(a: Any, b: Any) -> Any:
    """Return the sum of two vectors."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@formula
def subtract(a: Any, b: Any) -> Any:
    """Return the difference a − b of two vectors."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@formula
def times(w: Any, factor: Any) -> Any:
    """Return the vector w times a number."""
    return w[0] * factor, w[1] * factor, w[2] * factor


@formula
def cross(a: Any, b: Any) -> Any:
    """Return the cross product of two vectors; it is exactly 0 for equal vectors."""
    return (
        multiply_add(a[1], b[2], -(a[2] * b[1])),
        multiply_add(a[2], b[0], -(a[0] * b[2])),
        multiply_add(a[0], b[1], -(a[1] * b[0])),
    )


@formula
def inverse_length(squared: Any) -> Any:
    """Return 1 divided by the length of a vector; `squared` is the squared length.

    For a zero vector, the result is a finite number.
    """
    return ONE / sqrt(maximum(squared, LEAST_SQUARE))
