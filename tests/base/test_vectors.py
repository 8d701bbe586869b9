"""Columns as vectors: right over the whole exponent range, and each column for itself."""

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from pvphong.base.vectors import dot, moderate, towards, unit, unit_vector

U, V = 2.0**-53, 2.0**-24
LARGEST = np.finfo(np.float64).max
QUICK = settings(max_examples=150, derandomize=True, deadline=None, database=None)
any_float = st.floats(allow_nan=False, allow_infinity=False)
vectors = st.tuples(any_float, any_float, any_float)
both_types = pytest.mark.parametrize(("real", "step"), [(np.float32, V), (np.float64, U)])

TARGET = (1.0, 2.0, 3.0)
FUNCTIONS = {
    "unit": unit,
    "moderate-float32": lambda w: moderate(w, np.float32),
    "moderate-float64": moderate,
    "towards-float32": lambda points: towards(TARGET, points, np.float32),
    "towards-float64": lambda points: towards(TARGET, points),
}
every_function = pytest.mark.parametrize("function", FUNCTIONS.values(), ids=FUNCTIONS)


def column(vector):
    return np.array(vector, dtype=np.float64)[:, None]


def spread():
    """Columns whose exponents are even over the range, some zero, one the target, some not finite."""
    rng = np.random.default_rng(0)
    w = np.ldexp(rng.normal(size=(3, 200)), rng.integers(-1070, 1020, 200))
    w[:, ::17] = 0.0
    w[:, 7] = TARGET
    w[1, 5], w[0, 9] = np.nan, np.inf
    return w


def exact(parts):
    """The unit vector of fractions, and their length, at most the largest float."""
    with mpmath.workdps(60):
        parts = [mpmath.mpf(part.numerator) / part.denominator for part in parts]
        length = mpmath.sqrt(mpmath.fsum(part * part for part in parts))
        return [float(part / length) for part in parts], float(min(length, mpmath.mpf(LARGEST)))


# --- what all of them hold to ---


@every_function
def test_each_column_is_for_itself_and_the_argument_is_left_alone(function):
    w = spread()
    together = function(w)
    np.testing.assert_array_equal(w, spread())
    for index in range(w.shape[1]):
        for whole, alone in zip(together, function(w[:, [index]]), strict=True):
            assert whole[..., [index]].tobytes() == alone.tobytes()


@every_function
def test_of_nothing_comes_nothing(function):
    assert [part.shape for part in function(np.zeros((3, 0)))] == [(3, 0), (0,)]


def test_dot_sums_in_the_order_x_y_z_and_broadcasts_one_column():
    a, b = np.array([[1e16], [1.0], [-1e16]]), np.ones((3, 1))
    assert dot(a, b).tolist() == [(1e16 + 1.0) - 1e16]
    assert dot(np.float32([[1], [2], [3]]), np.float32([[4], [5], [6]])).dtype == np.float32
    w = np.arange(12.0).reshape(3, 4)
    np.testing.assert_array_equal(dot(w, column((1, 2, 3))), [1 * i + 2 * (i + 4) + 3 * (i + 8) for i in range(4)])


# --- unit vectors ---


@given(vectors.filter(any))
@QUICK
def test_unit_over_the_whole_range(vector):
    direction, length = unit(column(vector))
    expected, exact_length = exact([Fraction(part) for part in vector])
    np.testing.assert_allclose(direction[:, 0], expected, rtol=0, atol=4 * U)
    if not math.isinf(length[0]):
        assert length[0] == pytest.approx(exact_length, rel=4 * U, abs=5e-324)
    else:
        assert exact_length == LARGEST
    assert unit_vector(vector) == tuple(direction[:, 0]), "a single vector has the bits of a column"


@pytest.mark.parametrize(
    "vector", [(0, 0, 0), (0.0, -0.0, 0.0), (math.nan, 0, 1), (math.inf, 0, 0), (1, -math.inf, math.nan)]
)
def test_unit_of_what_has_no_direction_is_zero(vector):
    direction, length = unit(np.hstack([column(vector), column((0, 0, -4))]))
    np.testing.assert_array_equal(direction, [[0, 0], [0, 0], [0, -1]])
    assert length.tolist() == [0.0, 4.0]


@pytest.mark.parametrize("power", [-900, -100, -1, 1, 100, 900])
def test_a_power_of_two_changes_no_bit_of_the_direction(power):
    w = np.random.default_rng(1).normal(size=(3, 100))
    assert unit(w)[0].tobytes() == unit(np.ldexp(w, power))[0].tobytes()


# --- moderate lengths ---


@both_types
def test_moderate_keeps_directions_and_gives_the_inverse_lengths(real, step):
    w = spread()
    scaled, inverse = moderate(w, real)
    assert scaled.dtype == inverse.dtype == real
    np.testing.assert_allclose(scaled * inverse, unit(w)[0], rtol=0, atol=4 * step)
    sound = np.isfinite(w).all(axis=0) & w.any(axis=0)
    square = dot(scaled, scaled)[sound]
    assert square.min() >= 2.0**-61
    assert square.max() <= 2.0**61
    assert not scaled[:, ~sound].any()
    assert not inverse[~sound].any()


def test_moderate_scales_by_powers_of_two():
    w = spread()
    w = w[:, np.isfinite(w).all(axis=0) & (np.abs(w).min(axis=0) > 1e-290)]  # subnormal results would be rounded
    assert (np.frexp(moderate(w)[0] / w)[0] == 0.5).all()
    assert w.shape[1] > 100


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_moderate_only_rounds_comfortable_columns(real):
    w = np.random.default_rng(3).normal(size=(3, 9))
    assert moderate(w, real)[0].tobytes() == w.astype(real).tobytes()


# --- towards a target ---


@both_types
@given(target=vectors, point=vectors)
@example((1e12, 1e12, -1e12), (1e12 + 0.25, 1e12, -1e12))  # float32 does not hold these apart
@example((0.0, 0.0, 0.0), (1e200, -1e200, 0.0))  # nor these at all
@example((0.0, 0.0, 0.0), (1e-200, 0.0, 0.0))
@example((-1e308, 0.0, 0.0), (1e308, 0.0, 0.0))  # nor float64 their difference
@QUICK
def test_towards_over_the_whole_range(real, step, target, point):
    direction, distance = towards(target, column(point), real)
    assert direction.dtype == real
    difference = [Fraction(t) - Fraction(p) for t, p in zip(target, point, strict=True)]
    if not any(difference):
        assert (direction.tolist(), distance.tolist()) == ([[0.0]] * 3, [0.0])
        return
    expected, far = exact(difference)
    # each component of the difference is rounded once more than in `unit`
    np.testing.assert_allclose(direction[:, 0], expected, rtol=0, atol=6 * step)
    assert distance[0] == pytest.approx(far, rel=6 * step, abs=1e-323)
    assert distance[0] <= LARGEST


def test_towards_of_points_that_are_not_finite():
    points = np.array([[np.nan, np.inf, 0.0, 1.0], [0.0] * 4, [0.0] * 4])
    direction, distance = towards((1.0, 0.0, 0.0), points)
    np.testing.assert_array_equal(direction[0], [0, 0, 1, 0])
    np.testing.assert_array_equal(distance, [np.nan, np.nan, 1, 0])
