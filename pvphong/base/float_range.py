"""The ends of the floats' range: caps that keep results within it, and exact arithmetic for what is beyond it.

Exact: floats become integers in the same proportions, or mantissas with their exponents kept apart.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pvphong.base.types import Float64Array, FloatArray

BRIGHTEST = 2.0**100
"""Strengths, colours and exponents are capped here, so that nothing overflows float32; anything near it is white.

(The kernel caps a spot's attenuation before its falloff: where the attenuation has no constant, and so near to the
light that this matters, 2⁻⁵⁰ of the distance where it is 1, a spot may be darker outside the middle of its cone.)"""

FAINTEST = 2.0**-126
"""The least normal number of float32."""

FARTHEST = 2.0**1000
"""The most that a light's colours may be before its attenuation, which may bring them down again."""

# The exponent given to a product that is zero: below every other, and far from the int32 range's end.
_NO_EXPONENT = -(2**20)


def common_integers(values: Sequence[float]) -> list[int]:
    """Integers in exactly the proportions of some finite floats: each float times one common power of two."""
    ratios = [value.as_integer_ratio() for value in values]
    shift = max(below for _, below in ratios).bit_length()
    return [above << (shift - below.bit_length()) for above, below in ratios]


def scaled_floats(integers: Sequence[int]) -> Float64Array:
    """Floats in the proportions of some integers, the largest between 0.5 and 1, each rounded once.

    Python divides integers with one correct rounding; what is less than 5e-324 of the largest becomes zero.
    """
    unit = 1 << max(abs(entry) for entry in integers).bit_length()
    return np.array([entry / unit for entry in integers])


def mantissas_and_exponents(integers: Sequence[int]) -> tuple[Float64Array, NDArray[np.int32]]:
    """Floats as `scaled_floats`, but as mantissas below 1 and exponents, so that none becomes zero."""
    exponents = [abs(entry).bit_length() for entry in integers]
    mantissas = [entry / (1 << exponent) for entry, exponent in zip(integers, exponents, strict=True)]
    return np.array(mantissas), np.array(exponents, dtype=np.int32) - max(exponents)


def wide_sums(
    rows: FloatArray, mantissas: Float64Array, exponents: NDArray[np.int32]
) -> tuple[Float64Array, NDArray[np.int32]]:
    """Linear images of rows, in which nothing overflows, and nothing underflows that counts.

    Products and sums are rounded as in plain float64 arithmetic, in the order of the columns.

    Parameters
    ----------
    rows : ndarray
        Shape (n, 3).
    mantissas, exponents : ndarray
        Shape (k, 3), or (k, 4) with a last column that is added as it stands. The coefficients are
        mantissas * 2**exponents.

    Returns
    -------
    sums, exponents : ndarray
        Shape (n, k): the images are sums * 2**exponents.
    """
    if mantissas.shape[1] == 4:
        rows = np.column_stack([rows, np.ones(len(rows))])
    parts, powers = np.frexp(rows.astype(np.float64, copy=False))
    terms = parts[:, None, :] * mantissas
    levels = np.where(terms == 0.0, _NO_EXPONENT, powers[:, None, :] + exponents)
    top = levels.max(axis=2)
    terms = np.ldexp(terms, levels - top[:, :, None])
    total = terms[:, :, 0]
    for column in range(1, terms.shape[2]):
        total = total + terms[:, :, column]
    return total, top
