"""Columns as vectors: right over the whole exponent range, and each column for itself."""

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pvphong.base.vectors import columns, dot, moderate, towards, unit, unit_vector

U = 2.0**-53
LARGEST = np.finfo(np.float64).max
QUICK = settings(max_examples=150, derandomize=True, deadline=None, database=None)
any_float = st.floats(allow_nan=False, allow_infinity=False)
vectors = st.tuples(any_float, any_float, any_float)
both_types = pytest.mark.parametrize(("real", "step"), [(np.float32, 2.0**-24), (np.float64, U)])


def exact_unit(vector):
    with mpmath.workdps(60):
        parts = [mpmath.mpf(x) for x in vector]
        length = mpmath.sqrt(mpmath.fsum(x * x for x in parts))
        return np.array([float(x / length) for x in parts]), float(min(length, mpmath.mpf(LARGEST)))


def column(vector):
    return np.array(vector, dtype=np.float64)[:, None]


def spread(count=200, seed=0, low=-1070, high=1020):
    """Columns whose exponents are even over the range."""
    rng = np.random.default_rng(seed)
    return np.ldexp(rng.normal(size=(3, count)), rng.integers(low, high, count))


def test_dot_sums_in_the_order_x_y_z():
    a, b = np.array([[1e16], [1.0], [-1e16]]), np.ones((3, 1))
    assert dot(a, b).tolist() == [(1e16 + 1.0) - 1e16]
    assert dot(np.float32([[1], [2], [3]]), np.float32([[4], [5], [6]])).dtype == np.float32


def test_dot_broadcasts_one_column():
    a, b = np.arange(12.0).reshape(3, 4), column((1, 2, 3))
    np.testing.assert_array_equal(dot(a, b), [1 * i + 2 * (i + 4) + 3 * (i + 8) for i in range(4)])


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_columns_is_a_contiguous_float64_copy(real):
    rows = np.arange(12, dtype=real).reshape(4, 3)
    result = columns(rows)
    assert (result.dtype, result.shape) == (np.float64, (3, 4))
    assert result.flags.c_contiguous
    assert not np.shares_memory(result, rows)
    np.testing.assert_array_equal(result, rows.T)


@given(vectors.filter(any))
@QUICK
def test_unit_over_the_whole_range(vector):
    direction, length = unit(column(vector))
    expected, exact_length = exact_unit(vector)
    np.testing.assert_allclose(direction[:, 0], expected, rtol=0, atol=4 * U)
    if not math.isinf(length[0]):
        assert length[0] == pytest.approx(exact_length, rel=4 * U, abs=5e-324)
    else:
        assert exact_length == LARGEST


@pytest.mark.parametrize(
    "vector", [(0, 0, 0), (0.0, -0.0, 0.0), (math.nan, 0, 1), (math.inf, 0, 0), (1, -math.inf, math.nan)]
)
def test_unit_of_what_has_no_direction_is_zero(vector):
    direction, length = unit(np.hstack([column(vector), column((0, 0, -4))]))
    np.testing.assert_array_equal(direction, [[0, 0], [0, 0], [0, -1]])
    assert length.tolist() == [0.0, 4.0]


@pytest.mark.parametrize("function", [unit, moderate])
def test_each_column_for_itself(function):
    w = spread()
    w[:, ::17] = 0.0
    w[1, 5] = np.nan
    together = function(w)
    for index in range(w.shape[1]):
        alone = function(w[:, [index]])
        for whole, part in zip(together, alone, strict=True):
            assert whole[..., [index]].tobytes() == part.tobytes()


@pytest.mark.parametrize("power", [-900, -100, -1, 1, 100, 900])
def test_a_power_of_two_changes_no_bit_of_the_direction(power):
    w = np.random.default_rng(1).normal(size=(3, 100))
    assert unit(w)[0].tobytes() == unit(np.ldexp(w, power))[0].tobytes()


@given(vectors.filter(any))
@QUICK
def test_a_single_unit_vector_has_the_bits_of_a_column(vector):
    assert unit_vector(vector) == tuple(unit(column(vector))[0][:, 0])


def test_unit_leaves_its_argument_alone():
    for w in (np.random.default_rng(2).normal(size=(3, 5)), spread(5)):
        before = w.copy()
        unit(w)
        np.testing.assert_array_equal(w, before)


@both_types
def test_moderate_keeps_directions_and_gives_the_inverse_lengths(real, step):
    w = spread()
    scaled, inverse = moderate(w, real)
    assert scaled.dtype == inverse.dtype == real
    square = dot(scaled, scaled)
    assert square.min() >= 2.0**-61
    assert square.max() <= 2.0**61
    np.testing.assert_allclose(scaled * inverse, unit(w)[0], rtol=0, atol=4 * step)


def test_moderate_scales_by_powers_of_two():
    w = spread()
    scaled, _ = moderate(w)
    ratio = np.divide(scaled, w, where=np.abs(w) > 1e-300, out=np.ones_like(w))
    assert (np.frexp(ratio[:, np.abs(w).min(axis=0) > 1e-290])[0] == 0.5).all()


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_moderate_only_rounds_comfortable_columns(real):
    w = np.random.default_rng(3).normal(size=(3, 9))
    assert moderate(w, real)[0].tobytes() == w.astype(real).tobytes()


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_moderate_leaves_its_argument_alone(real):
    w = spread()
    before = w.copy()
    moderate(w, real)
    np.testing.assert_array_equal(w, before)


def test_nothing_at_all():
    nothing = np.zeros((3, 0))
    assert unit(nothing)[0].shape == (3, 0)
    assert moderate(nothing)[1].shape == (0,)
    assert towards((1.0, 2.0, 3.0), nothing)[1].shape == (0,)


@both_types
@given(target=vectors, point=vectors)
@QUICK
def test_towards_over_the_whole_range(real, step, target, point):
    direction, distance = towards(target, column(point), real)
    assert direction.dtype == real
    difference = [Fraction(t) - Fraction(p) for t, p in zip(target, point, strict=True)]
    if not any(difference):
        assert (direction.tolist(), distance.tolist()) == ([[0.0]] * 3, [0.0])
        return
    with mpmath.workdps(60):
        parts = [mpmath.mpf(x.numerator) / x.denominator for x in difference]
        length = mpmath.sqrt(mpmath.fsum(x * x for x in parts))
        expected = [float(x / length) for x in parts]
        far = float(min(length, mpmath.mpf(LARGEST)))
    # each component of the difference is rounded once more than in `unit`
    np.testing.assert_allclose(direction[:, 0], expected, rtol=0, atol=6 * step)
    assert distance[0] == pytest.approx(far, rel=6 * step, abs=1e-323)
    assert distance[0] <= LARGEST


def test_towards_of_points_that_are_not_finite():
    points = np.array([[np.nan, np.inf, 0.0, 1.0], [0.0] * 4, [0.0] * 4])
    direction, distance = towards((1.0, 0.0, 0.0), points)
    np.testing.assert_array_equal(direction[0], [0, 0, 1, 0])
    np.testing.assert_array_equal(distance, [np.nan, np.nan, 1, 0])


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_towards_of_points_whose_difference_is_beyond_floats(real):
    direction, distance = towards((-1.5e308, 0.0, 1.5e308), column((1.5e308, 0.0, -1.5e308)), real)
    np.testing.assert_allclose(direction[:, 0], np.array([-1.0, 0.0, 1.0]) / np.sqrt(2), rtol=4 * np.finfo(real).eps)
    assert distance[0] == LARGEST


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_towards_each_column_for_itself(real):
    points = spread()
    points[:, 7] = 1.0, 2.0, 3.0
    points[0, 9] = np.inf
    direction, distance = towards((1.0, 2.0, 3.0), points, real)
    for index in range(points.shape[1]):
        alone, near = towards((1.0, 2.0, 3.0), points[:, [index]], real)
        assert direction[:, [index]].tobytes() == alone.tobytes()
        assert distance[[index]].tobytes() == near.tobytes()


def test_towards_leaves_the_points_alone():
    points = spread()
    before = points.copy()
    towards((1.0, 2.0, 3.0), points)
    np.testing.assert_array_equal(points, before)


def test_towards_in_float32_of_points_whose_difference_float32_does_not_hold():
    points = np.array([[1e12 + 0.25, 1e200, 1e-200], [1e12, -1e200, 0.0], [-1e12, 0.0, 0.0]])
    direction, distance = towards((1e12, 1e12, -1e12), points[:, :1], np.float32)
    assert (direction[:, 0].tolist(), distance.tolist()) == ([-1.0, 0.0, 0.0], [0.25])
    direction, distance = towards((0.0, 0.0, 0.0), points[:, 1:], np.float32)
    half = math.sqrt(0.5)
    np.testing.assert_allclose(direction, [[-half, -1.0], [half, 0.0], [0.0, 0.0]], rtol=0, atol=6 * 2.0**-24)
    np.testing.assert_allclose(distance, [2e200 * half, 1e-200], rtol=6 * 2.0**-24)
