"""Classes of model matrices, as far as they concern normals.

Points, vectors and normals under a 4x4 affine model matrix, and the normalising of vectors.

A model matrix M = [[L, t], [0, 0, 0, w]] takes a point p to (L p + t) / w and a vector v to L v / w. A normal n
goes by the inverse-transpose of L / w, which is its cofactor matrix up to a positive factor and the sign of
its determinant. The three transforms stand side by side so that nobody takes the wrong one.

Every row of a result depends on that row of the input and on the matrix alone: not on the other rows, nor
on the memory layout. Rows that float64's exponent range would spoil are computed again with exponents kept
apart, which gives the same bits wherever both ways are open.
"""

from __future__ import annotations

import warnings
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from pvphong.base import check
from pvphong.base.float_range import common_integers, mantissas_and_exponents, scaled_floats, wide_sums
from pvphong.base.types import BoolArray, Float64Array, FloatArray, MatrixLike


class MatrixClass(Enum):
    """What a matrix does to the directions of normals; the value says it to people."""

    TRANSLATION = "a translation"
    UNIFORM_SCALE = "a uniform scale"
    SIMILAR = "rigid or similar: the inverse-transpose is the matrix itself, but for its scale"
    GENERAL = "general: normals need the inverse-transpose"

    @property
    def keeps_normals(self) -> bool:
        """Whether normals point where they did."""
        return self in {MatrixClass.TRANSLATION, MatrixClass.UNIFORM_SCALE}


def class_of(matrix: Float64Array) -> MatrixClass:
    """Of a (4, 4) affine matrix; what keeps normals is exact, what is similar is so to 1e-12."""
    linear, w = matrix[:3, :3], matrix[3, 3]
    if np.array_equal(linear, np.eye(3) * linear[0, 0]) and np.sign(linear[0, 0]) == np.sign(w):
        return MatrixClass.TRANSLATION if linear[0, 0] == w else MatrixClass.UNIFORM_SCALE
    scaled = np.ldexp(linear, -np.frexp(np.abs(linear).max())[1])  # so that no product overflows
    gram = scaled.T @ scaled
    if np.allclose(gram, np.eye(3) * gram[0, 0], rtol=0.0, atol=1e-12):
        return MatrixClass.SIMILAR
    return MatrixClass.GENERAL


# --- transform


# Squared lengths between these carry no underflow and no overflow into their last bit.
_LEAST_SQUARE, _MOST_SQUARE = 2.0**-900, 2.0**900

# Cofactors more powers of two apart could lose bits in a long normal that comes out short.
_WIDEST_COFACTORS = 500

# Dividing by a w further from 1 could take a sum that underflowed back into the range.
_MOST_W = 2.0**30


class SingularMatrixWarning(UserWarning):
    """A model matrix flattens space onto a plane; normals follow the limit of ever flatter matrices."""


def normal_matrix(matrix: MatrixLike) -> Float64Array:
    """Matrix that takes normals where `matrix` takes points: the inverse-transpose, up to a positive factor.

    It is computed in exact arithmetic from the stored numbers and rounded once, so that it is right for every
    condition number, and its sign is right for mirrors (det < 0) and for a negative last entry (w < 0).

    Parameters
    ----------
    matrix : array_like or vtkMatrix4x4
        Shape (4, 4), a model matrix as on a PyVista actor. Its last row is (0, 0, 0, w) with w != 0.

    Returns
    -------
    ndarray
        Shape (3, 3), float64; its largest entry lies between 0.5 and 1 in magnitude. Entries less than 5e-324
        of the largest are zero; `transform_normals` keeps those too.

    Raises
    ------
    ValueError
        If the matrix is not finite, its last row is projective, or it flattens space onto a line or a point
        (rank <= 1), where no normal has an image.

    Warns
    -----
    SingularMatrixWarning
        If the matrix flattens space onto a plane (rank 2). The result is then the cofactor matrix with its own
        sign: the limit of matrices that flatten ever more without mirroring.

    Notes
    -----
    The inverse-transpose of a 3x3 matrix is its cofactor matrix over its determinant; see K. Turkowski,
    "Properties of surface-normal transformations", Graphics Gems (1990), 539-547.
    """
    return scaled_floats(_cofactors(matrix)).reshape(3, 3)


def transform_points(points: ArrayLike, matrix: MatrixLike) -> Float64Array:
    """Images of points under a model matrix: (L p + t) / w.

    Parameters
    ----------
    points : array_like
        Shape (n, 3), any real type.
    matrix : array_like or vtkMatrix4x4
        Shape (4, 4) with last row (0, 0, 0, w), w != 0.

    Returns
    -------
    ndarray
        Shape (n, 3), float64. Coordinates beyond float64's range are infinite; a point that is not finite has
        an image that is not finite.

    Raises
    ------
    ValueError
        For a matrix that is not finite or whose last row is projective, or for another shape or type.
    """
    affine = _affine(matrix)
    return _product(check.array("points", points), affine[:3], float(affine[3, 3]))


def transform_vectors(vectors: ArrayLike, matrix: MatrixLike) -> Float64Array:
    """Images of vectors (differences of points) under a model matrix: L v / w, without its translation.

    Parameters, result and errors are those of `transform_points`; lengths are kept as they come.
    """
    affine = _affine(matrix)
    return _product(check.array("vectors", vectors), affine[:3, :3], float(affine[3, 3]))


def transform_normals(normals: ArrayLike, matrix: MatrixLike) -> Float64Array:
    """Images of normals under a model matrix, by its inverse-transpose, made unit length.

    Parameters
    ----------
    normals : array_like
        Shape (n, 3), any real type and any length.
    matrix : array_like or vtkMatrix4x4
        Shape (4, 4) with last row (0, 0, 0, w), w != 0.

    Returns
    -------
    ndarray
        Shape (n, 3), float64, unit length. A zero normal is unlit: it comes back as zero, and so do a normal
        with a NaN or infinity and a normal that a flattening matrix takes to zero.

    Raises
    ------
    ValueError
        As `normal_matrix`, or for another shape or type of `normals`.

    Warns
    -----
    SingularMatrixWarning
        As `normal_matrix`.
    """
    rows = check.array("normals", normals)
    cofactors = _cofactors(matrix)
    coefficients = scaled_floats(cofactors).reshape(3, 3)
    lengths = [abs(entry).bit_length() for entry in cofactors if entry]
    with np.errstate(all="ignore"):
        result = _sums(rows.astype(np.float64, copy=False), coefficients)
        square, rare = _squares(result.T)
        _divide(result.T, np.sqrt(square), result.T)
        if max(lengths) - min(lengths) > _WIDEST_COFACTORS:
            rare[:] = True
        if rare.any():
            mantissas, powers = mantissas_and_exponents(cofactors)
            images, exponents = wide_sums(rows[rare], mantissas.reshape(3, 3), powers.reshape(3, 3))
            result[rare] = normalize(np.ldexp(images, exponents - exponents.max(axis=1, keepdims=True)))
    return result


def normalize(vectors: ArrayLike) -> Float64Array:
    """Unit vectors of the same directions, for every length that float32 or float64 can hold.

    Parameters
    ----------
    vectors : array_like
        Shape (n, 3), any real type.

    Returns
    -------
    ndarray
        Shape (n, 3), float64, C-contiguous, within 4 roundings (4 * 2**-53) of the exact unit vector. A row
        of zeros, or with a NaN or infinity, comes back as zero.
    """
    rows = check.array("vectors", vectors).astype(np.float64, copy=False)
    result = np.empty(rows.shape)
    normalize_columns(rows.T, result.T)
    return result


def normalize_columns(vectors: Float64Array, out: Float64Array) -> None:
    """`normalize` the columns of a (3, n) array into another, which may be the same."""
    with np.errstate(all="ignore"):
        square, rare = _squares(vectors)
        odd = vectors[:, rare]
        _divide(vectors, np.sqrt(square), out)
        if odd.size:
            odd = np.ldexp(odd, -np.frexp(np.abs(odd).max(axis=0))[1])
            square, lost = _squares(odd)  # what is still out of range is zero or not finite
            out[:, rare] = np.where(lost, 0.0, odd / np.sqrt(square))


def _squares(columns: Float64Array) -> tuple[Float64Array, BoolArray]:
    """Squared lengths, and which of them are out of the range where they are right."""
    x, y, z = columns
    square: Float64Array = x * x
    square += y * y
    square += z * z
    return square, ~((square >= _LEAST_SQUARE) & (square <= _MOST_SQUARE))  # NaN is too


def _divide(columns: Float64Array, lengths: Float64Array, out: Float64Array) -> None:
    for axis in range(3):  # one after the other, for columns may be far from each other in memory
        np.divide(columns[axis], lengths, out=out[axis])


def _affine(matrix: MatrixLike) -> Float64Array:
    result = check.matrix4("matrix", matrix)
    if result[3, :3].any() or result[3, 3] == 0.0:
        allowed = "an affine 4x4 matrix, with last row (0, 0, 0, w) and w != 0"
        remedy = "A projection belongs to the camera: pass the model matrix alone, with last row (0, 0, 0, 1)."
        check.refuse("matrix", f"last row {tuple(result[3].tolist())}", allowed, remedy)
    return result


def _cofactors(matrix: MatrixLike) -> list[int]:
    """Nine integers in the exact proportions of the inverse-transpose of L / w, row by row; warns at rank 2."""
    affine = _affine(matrix)
    a, b, c, d, e, f, g, h, i = common_integers(affine[:3, :3].ravel().tolist())
    cofactors = [
        e * i - f * h, f * g - d * i, d * h - e * g,
        c * h - b * i, a * i - c * g, b * g - a * h,
        b * f - c * e, c * d - a * f, a * e - b * d,
    ]  # fmt: skip
    if not any(cofactors):
        allowed = "a 4x4 matrix that keeps at least two dimensions"
        remedy = "Look for a scale of 0, or for rows that are multiples of each other."
        check.refuse("matrix", f"rank <= 1 in {affine[:3, :3].tolist()}", allowed, remedy)
    determinant = a * cofactors[0] + b * cofactors[1] + c * cofactors[2]
    if determinant == 0:
        message = (
            "The matrix flattens space onto a plane (determinant exactly 0): every normal becomes the plane's or zero. "
            "Use a small scale in place of 0 to keep the surface's own normals."
        )
        warnings.warn(message, SingularMatrixWarning, stacklevel=3)
        return cofactors
    return cofactors if (determinant > 0) == (affine[3, 3] > 0.0) else [-entry for entry in cofactors]


def _product(rows: FloatArray, coefficients: Float64Array, w: float) -> Float64Array:
    """(coefficients @ row) / w for every row; a fourth column of coefficients is added as it stands."""
    with np.errstate(all="ignore"):
        result = _sums(rows.astype(np.float64, copy=False), coefficients)
        if w != 1.0:
            result /= w
        rare: BoolArray = ~np.logical_and.reduce(np.isfinite(result), axis=1)
        if not 1.0 / _MOST_W <= abs(w) <= _MOST_W:
            rare[:] = True
        if rare.any():
            mantissa, exponent = np.frexp(w)
            sums, exponents = wide_sums(rows[rare], *np.frexp(coefficients))
            result[rare] = np.ldexp(sums / mantissa, exponents - exponent)
    return result


def _sums(rows: Float64Array, coefficients: Float64Array) -> Float64Array:
    """Coefficients times every row, always summed in the order x, y, z, 1 (a BLAS product's order may vary)."""
    x, y, z = rows[:, 0], rows[:, 1], rows[:, 2]
    result = np.empty(rows.shape)
    for axis, factors in enumerate(coefficients.tolist()):
        total = factors[0] * x
        total += factors[1] * y
        total += factors[2] * z
        if len(factors) == 4:
            total += factors[3]
        result[:, axis] = total
    return result
