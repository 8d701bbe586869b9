"""Transforms of points, vectors and normals by a 4x4 affine model matrix, and normalization of vectors.

A model matrix M = [[L, t], [0, 0, 0, w]] maps a point p to (L p + t) / w and a vector v to L v / w. A normal n is
multiplied by the inverse-transpose of L / w. The inverse-transpose of a matrix is its cofactor matrix, up to a positive
factor and the sign of its determinant.

Each row of a result depends only on the same row of the input and on the matrix, not on other rows or the memory
layout. Rows that would overflow or underflow are computed again with separate exponents. For a row that neither
overflows nor underflows, both ways give the same bits.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pvphong.base import check
from pvphong.base.types import BoolArray, Float64Array, FloatArray, MatrixLike
from pvphong.base.vectors import columns, unit


class MatrixClass(Enum):
    """Class of a matrix by its effect on the directions of normals; the values are phrases for reports."""

    TRANSLATION = "a translation"
    UNIFORM_SCALE = "a uniform scale"
    SIMILAR = "rigid or similar: the inverse-transpose is the matrix itself, up to scale"
    GENERAL = "general: normals need the inverse-transpose"

    @property
    def keeps_normals(self) -> bool:
        """True if a matrix of this class does not change the directions of normals."""
        return self in {MatrixClass.TRANSLATION, MatrixClass.UNIFORM_SCALE}


def class_of(matrix: Float64Array) -> MatrixClass:
    """Return the class of a (4, 4) affine matrix.

    A translation or a uniform scale is recognized only if it is exact. A similarity is recognized if it is accurate to
    1e-12.
    """
    linear, w = matrix[:3, :3], matrix[3, 3]
    if np.array_equal(linear, np.eye(3) * linear[0, 0]) and np.sign(linear[0, 0]) == np.sign(w):
        return MatrixClass.TRANSLATION if linear[0, 0] == w else MatrixClass.UNIFORM_SCALE
    scaled = np.ldexp(linear, -np.frexp(np.abs(linear).max())[1])  # products must not overflow
    gram = scaled.T @ scaled
    if np.allclose(gram, np.eye(3) * gram[0, 0], rtol=0.0, atol=1e-12):
        return MatrixClass.SIMILAR
    return MatrixClass.GENERAL


# Range of lengths whose squares neither overflow nor underflow in their last bit.
_LEAST_LENGTH, _MOST_LENGTH = 2.0**-450, 2.0**450

# Exponent of a zero product: below every other exponent, and far from int32 overflow.
_NO_EXPONENT = -(2**20)

_ROWS_AT_ONCE = 2**12

# If cofactors differ by more than this number of powers of two, a long normal that is mapped to a short one could lose
# bits.
_WIDEST_COFACTORS = 500

# Largest w by which plain sums are divided, and inverse of the least. Division by a w farther from 1 could bring an
# underflowed sum back into range, without its lost bits.
_MOST_W = 2.0**30


class SingularMatrixWarning(UserWarning):
    """Warning about a model matrix that flattens space onto a plane.

    The transformed normals are then the limit for matrices that flatten space more and more.

    Examples
    --------
    >>> import warnings, pvphong as ph
    >>> warnings.simplefilter("ignore", ph.SingularMatrixWarning)  # flat on purpose
    """


def normal_matrix(matrix: MatrixLike) -> Float64Array:
    """Return the matrix for normals of points transformed by `matrix`: the inverse-transpose, up to a positive factor.

    The result is computed in exact arithmetic from the stored numbers and rounded once. So it is accurate for any
    condition number, and its sign is right for mirrors (det < 0) and for a negative last entry (w < 0).

    Parameters
    ----------
    matrix : array_like or vtkMatrix4x4
        Shape (4, 4), a model matrix as on a PyVista actor. Its last row is (0, 0, 0, w) with w != 0.

    Returns
    -------
    ndarray
        Shape (3, 3), float64; the magnitude of its largest entry is between 0.5 and 1. Entries smaller than 5e-324
        times the largest are zero here, but not in `transform_normals`.

    Raises
    ------
    ValueError
        If the matrix is not finite, its last row is projective, or it flattens space onto a line or a point
        (rank <= 1), so that normals are undefined.

    Warns
    -----
    SingularMatrixWarning
        If the matrix flattens space onto a plane (rank 2). The result is then the cofactor matrix with its own
        sign: the limit of ever flatter matrices that do not mirror.

    Notes
    -----
    The inverse-transpose of a 3x3 matrix is its cofactor matrix over its determinant; see K. Turkowski,
    "Properties of surface-normal transformations", Graphics Gems (1990), 539-547.

    Examples
    --------
    >>> import numpy as np, pvphong as ph
    >>> normals = ph.pipeline.normal_matrix(np.diag([2.0, 1.0, 1.0, 1.0]))
    >>> normals / normals[1, 1]
    array([[0.5, 0. , 0. ],
           [0. , 1. , 0. ],
           [0. , 0. , 1. ]])
    """
    return _in_proportion(_cofactors(matrix))


def transform_points(points: ArrayLike, matrix: MatrixLike) -> Float64Array:
    """Transform points by a model matrix: (L p + t) / w.

    Parameters
    ----------
    points : array_like
        Shape (n, 3), any real type.
    matrix : array_like or vtkMatrix4x4
        Shape (4, 4) with last row (0, 0, 0, w), w != 0.

    Returns
    -------
    ndarray
        Shape (n, 3), float64. Coordinates that overflow are infinite; a point that is not finite stays not finite.

    Raises
    ------
    ValueError
        If the matrix is not finite, its last row is projective, or an argument has a wrong shape or type.

    Examples
    --------
    >>> import numpy as np, pvphong as ph
    >>> matrix = np.diag([2.0, 1.0, 1.0, 1.0])
    >>> ph.pipeline.transform_points([[1.0, 1.0, 0.0]], matrix)
    array([[2., 1., 0.]])
    """
    affine = affine_matrix(matrix)
    return _product(check.array("points", points), affine[:3], float(affine[3, 3]))


def transform_vectors(vectors: ArrayLike, matrix: MatrixLike) -> Float64Array:
    """Transform vectors (differences of points) by a model matrix: L v / w, without its translation.

    The vectors are not normalized.

    Parameters
    ----------
    vectors : array_like
        Shape (n, 3), any real type.
    matrix : array_like or vtkMatrix4x4
        Shape (4, 4) with last row (0, 0, 0, w), w != 0.

    Returns
    -------
    ndarray
        Shape (n, 3), float64. Components that overflow are infinite; a vector that is not finite stays not finite.

    Raises
    ------
    ValueError
        If the matrix is not finite, its last row is projective, or an argument has a wrong shape or type.

    Examples
    --------
    >>> import numpy as np, pvphong as ph
    >>> matrix = np.diag([2.0, 1.0, 1.0, 1.0])
    >>> ph.pipeline.transform_vectors([[1.0, 1.0, 0.0]], matrix)
    array([[2., 1., 0.]])
    """
    affine = affine_matrix(matrix)
    return _product(check.array("vectors", vectors), affine[:3, :3], float(affine[3, 3]))


def transform_normals(normals: ArrayLike, matrix: MatrixLike) -> Float64Array:
    """Transform normals by the inverse-transpose of a model matrix, and normalize them.

    Parameters
    ----------
    normals : array_like
        Shape (n, 3), any real type and any length.
    matrix : array_like or vtkMatrix4x4
        Shape (4, 4) with last row (0, 0, 0, w), w != 0.

    Returns
    -------
    ndarray
        Shape (n, 3), float64, unit length. The result is zero, which is unlit, for a zero normal, a normal with a NaN
        or infinity, and a normal that a flattening matrix maps to zero.

    Raises
    ------
    ValueError
        If the matrix is not finite, its last row is projective, it flattens space onto a line or a point, or an
        argument has a wrong shape or type.

    Warns
    -----
    SingularMatrixWarning
        If the matrix flattens space onto a plane. The normals are then the limit for ever flatter matrices.

    Examples
    --------
    >>> import numpy as np, pvphong as ph
    >>> matrix = np.diag([2.0, 1.0, 1.0, 1.0])
    >>> ph.pipeline.transform_normals([[1.0, 1.0, 0.0]], matrix).round(3)
    array([[0.447, 0.894, 0.   ]])
    """
    rows = check.array("normals", normals)
    cofactors = _cofactors(matrix)
    bits = [abs(entry).bit_length() for entry in cofactors if entry]
    with np.errstate(all="ignore"):
        result, lengths = _unit_rows(rows, _in_proportion(cofactors))
        rare = ~((lengths >= _LEAST_LENGTH) & (lengths <= _MOST_LENGTH))
        if max(bits) - min(bits) > _WIDEST_COFACTORS:
            rare[:] = True
        if rare.any():
            exponents = np.reshape([abs(entry).bit_length() for entry in cofactors], (3, 3))
            mantissas = np.reshape([entry / (1 << abs(entry).bit_length()) for entry in cofactors], (3, 3))
            images, levels = _wide_sums(rows[rare], mantissas, exponents - exponents.max())
            result[rare] = normalize(np.ldexp(images, levels - levels.max(axis=1, keepdims=True)))
    return result


def normalize(vectors: ArrayLike) -> Float64Array:
    """Normalize vectors of any length that float32 or float64 can represent.

    Parameters
    ----------
    vectors : array_like
        Shape (n, 3), any real type.

    Returns
    -------
    ndarray
        Shape (n, 3), float64, C-contiguous, within 4 roundings (4 * 2**-53) of the exact unit vector. A row of zeros,
        or with a NaN or infinity, gives zero.
    """
    return _unit_rows(check.array("vectors", vectors))[0]


def _unit_rows(rows: FloatArray, coefficients: Float64Array | None = None) -> tuple[Float64Array, Float64Array]:
    """Normalize the rows of an (n, 3) array, or the products of a (3, 3) matrix `coefficients` and each row.

    Return the unit vectors, shape (n, 3), and the lengths, shape (n,). Rows are processed in chunks that fit a core's
    cache.
    """
    result, lengths = np.empty(rows.shape), np.empty(len(rows))
    for start in range(0, len(rows), _ROWS_AT_ONCE):
        part = slice(start, start + _ROWS_AT_ONCE)
        wide = rows[part].astype(np.float64, copy=False)
        directions, lengths[part] = unit(columns(wide if coefficients is None else _sums(wide, coefficients)))
        result[part] = directions.T
    return result, lengths


def affine_matrix(matrix: MatrixLike) -> Float64Array:
    """Check a model matrix, and return it as a (4, 4) float64 array.

    Raises
    ------
    ValueError
        If the matrix is not finite or has another shape, or if its last row is projective.
    """
    result = check.matrix4("matrix", matrix)
    if result[3, :3].any() or result[3, 3] == 0.0:
        allowed = "an affine 4x4 matrix, with last row (0, 0, 0, w) and w != 0"
        remedy = "Pass only the model matrix, with last row (0, 0, 0, 1); the projection belongs to the camera."
        check.refuse("matrix", f"last row {tuple(result[3].tolist())}", allowed, remedy)
    return result


def _cofactors(matrix: MatrixLike) -> list[int]:
    """Return nine integers, row by row, that are exactly proportional to the inverse-transpose of L / w.

    L and w are the upper left 3x3 block and the last entry of the model matrix. If L has rank 2, the integers are the
    cofactors of L, and a SingularMatrixWarning is given.
    """
    affine = affine_matrix(matrix)
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
            "The matrix flattens space onto a plane (determinant exactly 0): all normals become the plane's normal, or "
            "zero. Use a small scale instead of 0 to keep the surface's own normals."
        )
        warnings.warn(message, SingularMatrixWarning, stacklevel=3)
        return cofactors
    return cofactors if (determinant > 0) == (affine[3, 3] > 0.0) else [-entry for entry in cofactors]


def _product(rows: FloatArray, coefficients: Float64Array, w: float) -> Float64Array:
    """Multiply each row of an (n, 3) array by a matrix, and divide by w: (coefficients @ row) / w, shape (n, 3).

    `coefficients` has the shape (3, 3) or (3, 4). A fourth column is added to the product before the division.
    """
    with np.errstate(all="ignore"):
        result = _sums(rows.astype(np.float64, copy=False), coefficients)
        if w != 1.0:
            result /= w
        rare: BoolArray = ~np.logical_and.reduce(np.isfinite(result), axis=1)
        if not 1.0 / _MOST_W <= abs(w) <= _MOST_W:
            rare[:] = True
        if rare.any():
            mantissa, exponent = np.frexp(w)
            sums, exponents = _wide_sums(rows[rare], *np.frexp(coefficients))
            result[rare] = np.ldexp(sums / mantissa, exponents - exponent)
    return result


def _sums(rows: Float64Array, coefficients: Float64Array) -> Float64Array:
    """Multiply each row of an (n, 3) array by a matrix: coefficients @ row, shape (n, 3).

    `coefficients` has the shape (3, 3) or (3, 4). A fourth column is added to the product. Terms are summed in the
    order x, y, z, 1; a product by BLAS would not guarantee this order.
    """
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


# --- exact arithmetic


def common_integers(values: Sequence[float]) -> list[int]:
    """Return integers that are exactly proportional to finite floats: the floats times one common power of two."""
    ratios = [value.as_integer_ratio() for value in values]
    shift = max(below for _, below in ratios).bit_length()
    return [above << (shift - below.bit_length()) for above, below in ratios]


def _in_proportion(integers: Sequence[int]) -> Float64Array:
    """Return a (3, 3) matrix of floats proportional to nine integers. Its largest magnitude is between 0.5 and 1.

    Each entry is rounded once, because Python divides integers with one correct rounding. Entries smaller than 5e-324
    times the largest become zero.
    """
    whole = 1 << max(abs(entry) for entry in integers).bit_length()
    return np.array([entry / whole for entry in integers]).reshape(3, 3)


def _wide_sums(
    rows: FloatArray, mantissas: Float64Array, exponents: NDArray[np.int32]
) -> tuple[Float64Array, NDArray[np.int32]]:
    """Multiply each row of an (n, 3) array by a matrix, with separate exponents to avoid overflow and underflow.

    Products and sums are rounded as in plain float64 arithmetic, in the order of the columns.

    Parameters
    ----------
    rows : ndarray
        Shape (n, 3).
    mantissas, exponents : ndarray
        The matrix is `mantissas * 2**exponents`, shape (k, 3) or (k, 4). A fourth column is added to the product.

    Returns
    -------
    total, top : ndarray
        Shape (n, k) each. The products are `total * 2**top`.
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
