"""Evenly distributed points in the unit square: the first two dimensions of Sobol's sequence, with Owen scrambling.

The sequence is a (0, 2)-sequence in base 2: of 2ᵐ consecutive points that begin at a multiple of 2ᵐ, exactly one is in
each of the 2ᵐ elementary rectangles of any shape (I. M. Sobol', "On the distribution of points in a cube and the
approximate evaluation of integrals", 1967). Scrambling keeps this property and makes each point uniformly distributed
(A. B. Owen, "Randomly permuted (t,m,s)-nets and (t,s)-sequences", 1995).

Scrambling is a hash of the digits (S. Laine and T. Karras, "Stratified sampling for stochastic transparency", 2011;
B. Burley, "Practical hash-based Owen scrambling", 2020; constants by N. Vegdahl). So a point depends only on its number
and a seed. Binary digits are stored in reverse order, which is the order that the hash needs.

(SciPy has the sequence too. But SciPy is an optional dependency, and the points must be the same without it.)
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pvphong.base.formulas import as_type_of, formula, single, wrapped

MOST = 4096
"""Number of available points; a power of two."""

_ONE, _TWO, _FOUR, _EIGHT, _SIXTEEN = (np.uint32(1 << k) for k in range(5))
_ODD, _PAIRS, _NIBBLES, _OCTETS = map(np.uint32, (0x55555555, 0x33333333, 0x0F0F0F0F, 0x00FF00FF))
_FIFTEEN, _SPREAD = np.uint32(15), np.uint32(0x9E3779B9)
_SHUFFLE = tuple(map(np.uint32, (0x7FEB352D, 0x846CA68B)))
_MIXERS = tuple(map(np.uint32, (0x3D20ADEA, 0x05526C56, 0x53A22864)))


def _second_coordinates() -> NDArray[np.uint32]:
    """Compute the second coordinates of all points as binary digits, shape (MOST,).

    Each digit of a point's number adds a row of Pascal's triangle modulo 2. The first coordinates need no table: their
    digits are those of the point's number.
    """
    numbers, row = np.arange(MOST, dtype=np.uint32), 1
    result = np.zeros(MOST, np.uint32)
    for bit in range(MOST.bit_length() - 1):
        result ^= (numbers >> np.uint32(bit) & _ONE) * np.uint32(row)
        row ^= row << 1
    return result


SECOND = _second_coordinates()
"""Digits of the second coordinates, shape (MOST,)."""


def _apart(exponent: int) -> int:
    numbers, across = np.arange(1, 2**exponent), exponent // 2
    down = exponent - 1 - across
    alike = (numbers % 2**across == 0) & (SECOND[1 : 2**exponent] % 2**down == 0)
    return int(numbers[alike][0])


NEIGHBOURS = (0, *(_apart(exponent) for exponent in range(1, MOST.bit_length())))
"""Differences, by xor, between the numbers of points that are close together. Entry m is for the first 2ᵐ points.

If the unit square is divided into 2ᵐ⁻¹ equal cells, squares or halves of squares, the points k and (k xor entry m) lie
in the same cell.
"""


@functools.lru_cache(maxsize=64)
def in_squares(begin: int, end: int, size: int) -> NDArray[np.uint32]:
    """Return the digits of both coordinates of consecutive points, ordered along a Morton curve.

    In this order, 2ᵐ consecutive points that begin at a multiple of 2ᵐ lie in one square, or in one half of a square.
    Scrambling keeps this property, because it only swaps halves of squares.

    Parameters
    ----------
    begin, end : int
        Numbers of the first point (inclusive) and the last (exclusive); at most `MOST`.
    size : int
        The last point is repeated until the number of points is a multiple of `size`.

    Returns
    -------
    ndarray
        Shape (2, n), uint32, C-contiguous; `coordinate` turns the digits into coordinates.
    """
    numbers = np.arange(begin, end, dtype=np.uint32)
    curve = np.zeros(len(numbers), np.uint32)  # Morton code: digits of both coordinates alternate, leading ones first
    for digit in range(MOST.bit_length() - 1):
        for column in (numbers, SECOND[begin:end]):
            curve = curve << _ONE | column >> np.uint32(digit) & _ONE
    order = np.pad(np.argsort(curve, kind="stable"), (0, -len(numbers) % size), "edge")
    return np.stack([numbers[order], SECOND[begin:end][order]])


def seeds(numbers: NDArray[np.integer[Any]], stream: int = 0) -> NDArray[np.uint32]:
    """Return two pseudo-random uint32 seeds for each integer in `numbers`, shape (2, n).

    Different streams, 0 to 2³¹, give independent seeds. Method: splitmix64 (G. L. Steele et al. 2014).
    """
    z = (numbers.astype(np.uint64) + np.uint64((stream << 32) + 1)) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z ^= z >> np.uint64(31)
    return np.stack([z.astype(np.uint32), (z >> np.uint64(32)).astype(np.uint32)])


@formula
def coordinate(digits: Any, seed: Any) -> Any:
    """Scramble the binary digits of a coordinate, and return the coordinate, float32, in [0, 1).

    `digits` is a uint32 from `in_squares` or `SECOND`, and `seed` a uint32 from `seeds`.
    """
    x = wrapped(digits ^ wrapped(digits * _MIXERS[0]))
    x = wrapped(x + seed)
    x = wrapped(x * wrapped(wrapped(seed >> _SIXTEEN) | _ONE))
    x = wrapped(x ^ wrapped(x * _MIXERS[1]))
    x = wrapped(x ^ wrapped(x * _MIXERS[2]))
    # reverse the digits
    x = wrapped(wrapped(wrapped(x >> _ONE) & _ODD) | wrapped(wrapped(x & _ODD) << _ONE))
    x = wrapped(wrapped(wrapped(x >> _TWO) & _PAIRS) | wrapped(wrapped(x & _PAIRS) << _TWO))
    x = wrapped(wrapped(wrapped(x >> _FOUR) & _NIBBLES) | wrapped(wrapped(x & _NIBBLES) << _FOUR))
    x = wrapped(wrapped(wrapped(x >> _EIGHT) & _OCTETS) | wrapped(wrapped(x & _OCTETS) << _EIGHT))
    x = wrapped(wrapped(x >> _SIXTEEN) | wrapped(x << _SIXTEEN))
    whole = single(wrapped(x >> _EIGHT))
    return whole * as_type_of(whole, 2.0**-24)


@formula
def random(number: Any, seed: Any) -> Any:
    """Hash a number and a seed, both uint32, to a pseudo-random float32 in [0, 1).

    Source: C. Wellons, "Hash prospector" (2018).
    """
    x = wrapped(wrapped(number * _SPREAD) ^ seed)
    x = wrapped(wrapped(x ^ wrapped(x >> _SIXTEEN)) * _SHUFFLE[0])
    x = wrapped(wrapped(x ^ wrapped(x >> _FIFTEEN)) * _SHUFFLE[1])
    x = wrapped(x ^ wrapped(x >> _SIXTEEN))
    whole = single(wrapped(x >> _EIGHT))
    return whole * as_type_of(whole, 2.0**-24)
