"""What formulas are written with, so that each stands once: NumPy runs it on arrays, compiled code on one vertex.

A formula is a function of components that gives components. It is marked by `formula`, calls only the operations of
this module and other formulas, and has no branches: `where` chooses, and both sides are computed. Vectors are anything
with three entries: a tuple of numbers in compiled code, an array (3, n) in NumPy.

Its numbers may be float32 or float64. A Python float would widen float32 in compiled code; so small constants are
float32, which every type holds (`ZERO`, `HALF`, `ONE`, `TWO`), and others are written `like(x, 0.3)`: as x is.

The compiled form of each operation is in `pvphong.shading.kernel.arithmetic`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

Function = TypeVar("Function", bound=Callable[..., Any])

FORMULAS: list[Callable[..., Any]] = []
"""Every function that `formula` has marked."""

ZERO, HALF, ONE, TWO = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(2.0)

LEAST_SQUARE = np.float32(2.0**-126)
"""Stands in for the square of a zero vector, which then remains zero when it is made unit length."""


def formula(function: Function) -> Function:
    """Mark a function as one that compiled code may call too."""
    FORMULAS.append(function)
    return function


# --- operations: here as NumPy has them


def sqrt(x: Any) -> Any:
    """√x."""
    return np.sqrt(x)


def minimum(a: Any, b: Any) -> Any:
    """The lesser of two numbers."""
    return np.minimum(a, b)


def maximum(a: Any, b: Any) -> Any:
    """The greater of two numbers."""
    return np.maximum(a, b)


def where(condition: Any, a: Any, b: Any) -> Any:
    """`a` where the condition holds, else `b`; conditions are combined by `&`, `|` and `~`."""
    return np.where(condition, a, b)


def multiply_add(a: Any, b: Any, c: Any) -> Any:
    """a·b + c; in compiled code rounded once."""
    return a * b + c


def like(x: Any, value: Any) -> Any:
    """A number in the type of x."""
    return x.dtype.type(value)


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
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@formula
def inverse_length(squared: Any) -> Any:
    """What makes a vector of that squared length unit length; a zero vector stays zero."""
    return ONE / sqrt(maximum(squared, LEAST_SQUARE))
