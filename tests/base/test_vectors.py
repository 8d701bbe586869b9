"""Vectors as columns: accuracy over the whole exponent range, and independence of the columns."""

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


def column(vector):
    return np.array(vector, dtype=np.float64)[:, None]


def spread():
    """Return columns with uniformly distributed exponents, some zero, some not finite."""
    rng = np.random.default_rng(0)
    w = np.ldexp(rng.normal(size=(3, 200)), rng.integers(-1070, 1020, 200))
    w[:, ::17] = 0.0
    w[1, 5], w[0, 9] = np.nan, np.inf
    return w


def exact(parts):
    """Return the unit vector of fractions, and their length, at most the largest float."""
    with mpmath.workdps(60):
        parts = [mpmath.mpf(part.numerator) / part.denominator for part in parts]
        length = mpmath.sqrt(mpmath.fsum(part * part for part in parts))
        return [float(part / length) for part in parts], float(min(length, mpmath.mpf(LARGEST)))


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


# --- towards a target ---


@both_types
@given(target=vectors, point=vectors)
@example((1e12, 1e12, -1e12), (1e12 + 0.25, 1e12, -1e12))  # float32 cannot distinguish these
@example((0.0, 0.0, 0.0), (1e200, -1e200, 0.0))  # nor represent these
@example((0.0, 0.0, 0.0), (1e-200, 0.0, 0.0))
@example((-1e308, 0.0, 0.0), (1e308, 0.0, 0.0))  # float64 cannot represent their difference
@QUICK
def test_towards_over_the_whole_range(real, step, target, point):
    direction, distance = towards(target, column(point), real)
    assert direction.dtype == real
    difference = [Fraction(t) - Fraction(p) for t, p in zip(target, point, strict=True)]
    if not any(difference):
        assert (direction.tolist(), distance.tolist()) == ([[0.0]] * 3, [0.0])
        return
    expected, far = exact(difference)
    # each component of the difference has one more rounding than in `unit`
    np.testing.assert_allclose(direction[:, 0], expected, rtol=0, atol=6 * step)
    assert distance[0] == pytest.approx(far, rel=6 * step, abs=1e-323)
    assert distance[0] <= LARGEST


def test_towards_of_points_that_are_not_finite():
    points = np.array([[np.nan, np.inf, 0.0, 1.0], [0.0] * 4, [0.0] * 4])
    direction, distance = towards((1.0, 0.0, 0.0), points)
    np.testing.assert_array_equal(direction[0], [0, 0, 1, 0])
    np.testing.assert_array_equal(distance, [np.nan, np.nan, 1, 0])
