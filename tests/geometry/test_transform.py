"""Transforms of points, vectors and normals. Sections A, B and F of the catalogue are in tests/stability."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import pyvista as pv
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import Placement

from pvphong.geometry.transform import (
    SingularMatrixWarning,
    normal_matrix,
    normalize,
    transform_normals,
    transform_points,
    transform_vectors,
)

U = 2.0**-53

few = settings(max_examples=60, derandomize=True, deadline=None)


def affine(linear=None, translation=(0.0, 0.0, 0.0), w=1.0):
    matrix = np.eye(4)
    matrix[:3, :3] = np.eye(3) if linear is None else linear
    matrix[:3, 3] = translation
    matrix[3, 3] = w
    return matrix


RNG = np.random.default_rng(1)
LINEAR = RNG.normal(size=(3, 3))
SHAPED = affine(LINEAR, (10.0, -20.0, 30.0))
ROWS = RNG.normal(size=(40, 3))
EVALUATORS = {
    "normalize": normalize,
    "transform_points": lambda rows: transform_points(rows, SHAPED),
    "transform_vectors": lambda rows: transform_vectors(rows, SHAPED),
    "transform_normals": lambda rows: transform_normals(rows, SHAPED),
    "transform_normals-wide": lambda rows: transform_normals(rows, np.diag([1e200, 1.0, 1e-200, 1.0]) @ SHAPED),
    "transform_points-wide": lambda rows: transform_points(rows, affine(1e300 * LINEAR, w=1e40)),
}
every_evaluator = pytest.mark.parametrize("evaluator", EVALUATORS.values(), ids=EVALUATORS)


@st.composite
def wide_floats(draw, lowest=-1074, highest=1023):
    """Draw floats with exponents uniform over float64's whole range, and zeros."""
    mantissa = draw(st.floats(0.5, 1.0, exclude_max=True))
    sign = draw(st.sampled_from([-1.0, 1.0, 0.0]))
    return float(np.ldexp(sign * mantissa, draw(st.integers(lowest, highest + 1))))


def rows_of(elements):
    return st.lists(st.tuples(*[elements] * 3), min_size=1, max_size=6).map(lambda rows: np.array(rows, np.float64))


@every_evaluator
@pytest.mark.parametrize("size", [1.0, 2.0**-1060, 2.0**1000], ids=["size=1", "tiny", "huge"])
def test_rows_do_not_hear_of_their_neighbours_and_stay_as_they_are(evaluator, size):
    rows = ROWS * size
    rows[3], rows[5], rows[7, 0], rows[9] = 0.0, np.nan, np.inf, (3.0, -4.0, 5.0)
    before, expected = rows.copy(), evaluator(rows)
    alone = np.concatenate([evaluator(rows[[index]]) for index in range(len(rows))])
    assert np.array_equal(alone, expected, equal_nan=True)
    assert np.array_equal(rows, before, equal_nan=True)
    assert evaluator(rows[:0]).shape == (0, 3)


# --- matrices ---

TAKERS = [lambda matrix, call=call: call(ROWS, matrix) for call in (transform_points, transform_vectors)]
TAKERS += [lambda matrix: transform_normals(ROWS, matrix), normal_matrix]
every_taker = pytest.mark.parametrize("taker", TAKERS, ids=["points", "vectors", "normals", "normal_matrix"])


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.eye(3), "a 4x4 matrix of real numbers"),
        (affine(np.diag([1.0, np.nan, 1.0])), "a 4x4 matrix of finite numbers"),
        (np.eye(4)[[0, 1, 3, 2]], r"an affine 4x4 matrix, .* last row \(0.0, 0.0, 1.0, 0.0\)\. Pass only the model"),
        (np.diag([1.0, 1.0, 1.0, 0.0]), "an affine 4x4 matrix, .* w != 0"),
        (np.eye(4) + np.outer(np.eye(4)[3], [1e-3, 0.0, 0.0, 0.0]), "an affine 4x4 matrix"),
    ],
)
@every_taker
def test_a_matrix_must_be_affine_and_4x4(taker, matrix, message):
    with pytest.raises(ValueError, match=f"^matrix must be {message}"):
        taker(matrix)


@pytest.mark.parametrize("linear", [np.zeros((3, 3)), np.diag([1.0, 0.0, 0.0]), np.outer([1.0, 2, 3], [4.0, 5, 6])])
@pytest.mark.parametrize("taker", TAKERS[2:], ids=["normals", "normal_matrix"])
def test_normals_need_two_dimensions(taker, linear):
    with pytest.raises(
        ValueError, match=r"^matrix must be a 4x4 matrix that keeps at least two dimensions; got rank <= 1"
    ):
        taker(affine(linear))


# --- normals ---


@pytest.mark.parametrize("linear", [LINEAR, np.diag([2.0, 4.0, 8.0]), np.diag([-3.0, 1.0, 7.0])])
def test_the_entries_of_a_normal_matrix_are_exact_cofactors_rounded_once(linear):
    """They are scaled by a power of two and the determinant's sign; a translation and a positive w change nothing."""
    observed = normal_matrix(affine(linear))
    assert 0.5 <= np.abs(observed).max() <= 1.0
    assert np.array_equal(normal_matrix(affine(linear, (1e9, -1e300, 7.0), w=8.0)), observed)
    placement = Placement(affine(linear))
    truth = np.array(placement.cofactors).ravel() * placement.sign
    assert not observed.ravel()[truth == 0].any()
    ratios = [Fraction(found) / entry for found, entry in zip(observed.ravel().tolist(), truth, strict=True) if entry]
    power = Fraction(2) ** round(np.log2(float(ratios[0])))
    assert all(abs(ratio / power - 1) <= U for ratio in ratios)


def test_flattening_warns_and_gives_the_planes_normal_or_zero():
    flat = affine(np.diag([1.0, 1.0, 0.0]))
    with pytest.warns(SingularMatrixWarning, match=r"flattens space onto a plane .* Use a small scale") as caught:
        observed = transform_normals([(0.6, 0.0, 0.8), (0.0, 0.6, -0.8), (1.0, 0.0, 0.0)], flat)
    assert np.array_equal(observed, [(0, 0, 1), (0, 0, -1), (0, 0, 0)])
    assert caught[0].filename == __file__


@few
@given(rows=rows_of(wide_floats()), entries=st.lists(wide_floats(), min_size=9, max_size=9), w=wide_floats())
@pytest.mark.filterwarnings("ignore::pvphong.geometry.transform.SingularMatrixWarning")
def test_normals_come_back_unit_or_zero_or_the_matrix_is_refused(rows, entries, w):
    matrix = affine(np.reshape(entries, (3, 3)), w=w)
    try:
        observed = transform_normals(rows, matrix)
    except ValueError as error:
        assert "rank <= 1" in str(error) or "last row" in str(error)  # noqa: PT017 - both outcomes are allowed
        return
    lengths = np.linalg.norm(observed, axis=1)
    assert np.all((lengths == 0.0) | (np.abs(lengths - 1.0) <= 4 * U))


# --- points and vectors ---


@few
@given(
    rows=rows_of(wide_floats(-1000, 900)),
    entries=st.lists(wide_floats(-1000, 1000), min_size=12, max_size=12),
    w=wide_floats(-1000, 1000).filter(bool),
)
def test_points_and_vectors_against_fractions_over_the_whole_range(rows, entries, w):
    """The error is at most 5 roundings of the terms' magnitudes: 3 for sums, 1 for products, 1 for the division."""
    matrix = affine(np.reshape(entries[:9], (3, 3)), entries[9:], w)
    coefficients = [[Fraction(entry) / Fraction(w) for entry in row] for row in matrix[:3].tolist()]
    for call, last in ((transform_points, 1), (transform_vectors, 0)):
        for row, image in zip(rows.tolist(), call(rows, matrix).tolist(), strict=True):
            for observed, factors in zip(image, coefficients, strict=True):
                terms = [a * Fraction(b) for a, b in zip(factors, [*row, last], strict=True)]
                error = 5 * Fraction(U) * sum(map(abs, terms)) + Fraction(2) ** -1040
                if np.isfinite(observed):
                    assert abs(Fraction(observed) - sum(terms)) <= error
                else:
                    assert abs(sum(terms)) + error >= Fraction(2) ** 1023
                    assert (observed > 0) == (sum(terms) > 0)


# --- normalising ---


@pytest.mark.parametrize("spread", [1, 300, 520, 1000])
def test_normals_through_any_stretch_have_the_bits_of_the_stretched_normal(spread):
    matrix = np.diag([2.0**spread, 1.0, 2.0**-spread, 1.0])
    normals = np.ldexp(ROWS, np.array([spread // 2, 0, -(spread // 2)]))
    expected = normalize(np.ldexp(normals, np.array([-spread, 0, spread])))
    assert np.array_equal(transform_normals(normals, matrix), expected)
    long = np.diag([2.0**-535, 2.0**535 * 1.1, 2.0**535 * 1.3, 1.0])  # two small cofactors would lose bits
    assert np.array_equal(transform_normals([(0.0, 2.0**900, 2.0**900)], long), normalize([(0.0, 1.3, 1.1)]))


def test_a_transform_stands_for_its_matrix():
    turned = pv.Transform().rotate_x(30).translate(1, 2, 3)
    points = np.random.default_rng(0).normal(size=(5, 3))
    for matrix in (turned, turned.GetMatrix()):
        assert np.array_equal(transform_points(points, matrix), transform_points(points, turned.matrix))
