"""What formulas are written with, so that each stands once: NumPy runs it on arrays, compiled code on vertices.

A formula is a function of components that gives components. It is marked by `formula`, calls only the operations of
this module and other formulas. Most have no branches: `select` chooses, and both sides are computed. Those of lights
with a size also have loops, and skip with `if any_of(...)` what no vertex needs. Vectors are anything with three
entries: a tuple of numbers in compiled code, an array (3, n) in NumPy.

Its numbers may be float32 or float64. A Python float would widen float32 in compiled code; so small constants are
float32, which every type holds (`ZERO`, `HALF`, `ONE`, `TWO`), and others are written `as_type_of(x, 0.3)`: as x is.

The compiled form of each operation for one vertex is in `pvphong.shading.kernel.arithmetic`; formulas of lights with a
size run on eight vertices at once, by `pvphong.shading.kernel.lanes`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numpy as np

Function = TypeVar("Function", bound=Callable[..., Any])

FORMULAS: list[Callable[..., Any]] = []
"""Every function that `formula` has marked."""

ZERO, HALF, ONE, TWO = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(2.0)

BRIGHTEST = 2.0**100
"""Strengths, colours and exponents are capped here, so that nothing overflows float32; anything near it is white.

(The kernel caps a spot's attenuation before its falloff: where the attenuation has no constant, and so near to the
light that this matters, 2⁻⁵⁰ of the distance where it is 1, a spot may be darker outside the middle of its cone.)"""

FAINTEST = 2.0**-126
"""The least normal number of float32."""

FARTHEST = 2.0**1000
"""The most that a light's colours may be before its attenuation, which may bring them down again."""

LEAST_SQUARE = np.float32(FAINTEST)
"""Stands in for the square of a zero vector, which then remains zero when it is made unit length."""


def formula(function: Function) -> Function:
    """Mark a function as one that compiled code may call too."""
    FORMULAS.append(function)
    return function


# --- operations: here as NumPy has them


def sqrt(x: Any) -> Any:
    """The square root √x."""
    return np.sqrt(x)


def minimum(a: Any, b: Any) -> Any:
    """The lesser of two numbers."""
    return np.minimum(a, b)


def maximum(a: Any, b: Any) -> Any:
    """The greater of two numbers."""
    return np.maximum(a, b)


def select(condition: Any, a: Any, b: Any) -> Any:
    """`a` where the condition holds, else `b`; conditions are combined by `&`, `|` and `~`."""
    return np.where(condition, a, b)


def multiply_add(a: Any, b: Any, c: Any) -> Any:
    """a·b + c; in compiled code rounded once."""
    return a * b + c


def as_type_of(x: Any, value: Any) -> Any:
    """A number in the type of x."""
    return x.dtype.type(value)


def single(x: Any) -> Any:
    """A number as float32."""
    return x.astype(np.float32)


def wrapped(x: Any) -> Any:
    """A whole number without the digits beyond those of uint32."""
    return x.astype(np.uint32, copy=False)


def index(x: Any) -> Any:
    """The whole number next below x >= 0, to look up a formula's number with."""
    return x.astype(np.int64)


def nearest(x: Any) -> Any:
    """The nearest whole number."""
    return np.rint(x)


def over_its_size(x: Any) -> Any:
    """The power of two that brings x > 0 to [1, 2); for more than 2¹⁰⁰⁰, that of 2¹⁰⁰⁰."""
    return np.ldexp(1.0, 1 - np.frexp(np.minimum(x, 2.0**1000))[1])


def arctan2(y: Any, x: Any) -> Any:
    """The angle of a point, in [−π, π]; 0 at the origin."""
    return np.arctan2(y, x)


def sine(x: Any) -> Any:
    """The sine of x, for some turns of the circle."""
    return np.sin(x)


def cosine(x: Any) -> Any:
    """The cosine of x, to the last digits of 1."""
    return np.cos(x)


def log1p(x: Any) -> Any:
    """The natural logarithm of 1 + x."""
    return np.log1p(x)


def power_less_one(less: Any, exponent: Any) -> Any:
    """max(z, 0)ᵖ − 1 for less = 1 − z, to the last digits near z = 1 too; 0⁰ is 1."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(exponent > 0.0, np.expm1(exponent * np.log1p(-np.minimum(less, 1.0))), 0.0)


def any_of(conditions: Any) -> Any:
    """Whether any of them holds. `if any_of(...)` skips what none of the vertices needs."""
    return np.any(conditions)


def largest(x: Any) -> Any:
    """The largest of whole numbers >= 0, as an integer: a loop with that many steps serves all of them."""
    return int(np.max(x, initial=0.0))


def exponential(x: Any) -> Any:
    """The exponential eˣ for x <= 0."""
    return np.exp(x)


def chord_power(squared: Any, exponent: Any, floor: float = 0.0) -> Any:
    """max(f, floor)ⁿ for the cosine f = 1 − ½|C|² that a chord C of that squared length belongs to; 1 for n = 0.

    The exponent n is one number or an array of them. It is exp(n · log1p(−½|C|²)), which keeps its digits near f = 1.
    """
    real = squared.dtype.type
    is_flat = np.equal(exponent, 0.0)
    if is_flat.all():
        return real(1.0)
    d = np.minimum(real(0.5) * squared, real(1.0))
    # log(1 − d) in place of NumPy's slower log1p: with f the rounded 1 − d and e = (f − 1) + d its error, which is
    # exact (Sterbenz) or far below the last bit, it is log(f − e) = log f − e/f + O(e²)
    f = 1.0 - d
    error = f - 1.0
    error += d
    error /= np.maximum(f, np.finfo(real).tiny)
    with np.errstate(divide="ignore"):  # the far hemisphere: log of 0 gives 0 in the end
        logarithm = np.log(f, out=f)
    logarithm -= error
    if floor:  # on the logarithm, because 1 − floor would be rounded by far more than the floor's own last bit
        np.maximum(logarithm, real(math.log(floor)), out=logarithm)
    logarithm *= np.clip(exponent, float(np.finfo(real).tiny), BRIGHTEST).astype(real)
    if real is np.float32:
        result = np.exp(logarithm, out=logarithm)
    else:  # below e to this a power is 0: NumPy's exp takes up to fifty times as long from there on
        shows = logarithm > -707.5
        np.maximum(logarithm, -707.5, out=logarithm)
        result = np.exp(logarithm, out=logarithm)
        result *= shows
    np.copyto(result, 1.0, where=is_flat)
    return result


class Power(NamedTuple):
    """A power of a cosine: max(f, floor)ⁿ."""

    exponent: Any
    """The exponent n >= 0: a number, or an array of them vertex by vertex."""
    floor: float = 0.0

    @property
    def numbers(self) -> tuple[float, float, float]:
        """For compiled code: n in float32's range, log2 of the floor, and the |C|² from which on it is 0."""
        exponent = self.exponent and max(FAINTEST, min(self.exponent, BRIGHTEST))
        log_floor = math.log2(self.floor) if self.floor else -math.inf
        return exponent, log_floor, math.inf if self.floor or not self.exponent else 2.0


@formula
def horner(t: Any, coefficients: Any) -> Any:
    """A polynomial's value; coefficients highest power first. Compiled code has no loop for a dozen of them."""
    total = coefficients[0]
    for k in range(1, len(coefficients)):
        total = total * t + coefficients[k]
    return total


# --- vectors


@formula
def dot(a: Any, b: Any) -> Any:
    """Dot product, summed in the order x, y, z; no product is fused with a sum, so what cancels exactly gives 0."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@formula
def square(w: Any) -> Any:
    """|w|²."""
    return multiply_add(w[2], w[2], multiply_add(w[1], w[1], w[0] * w[0]))


@formula
def add(a: Any, b: Any) -> Any:
    """Sum of two vectors."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@formula
def subtract(a: Any, b: Any) -> Any:
    """Difference of two vectors."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@formula
def times(w: Any, factor: Any) -> Any:
    """A vector times a number."""
    return w[0] * factor, w[1] * factor, w[2] * factor


@formula
def cross(a: Any, b: Any) -> Any:
    """Cross product; exactly 0 where the vectors are equal."""
    return (
        multiply_add(a[1], b[2], -(a[2] * b[1])),
        multiply_add(a[2], b[0], -(a[0] * b[2])),
        multiply_add(a[0], b[1], -(a[1] * b[0])),
    )


@formula
def inverse_length(squared: Any) -> Any:
    """What makes a vector of that squared length unit length; a zero vector stays zero."""
    return ONE / sqrt(maximum(squared, LEAST_SQUARE))
