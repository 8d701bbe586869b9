from __future__ import annotations

import time
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

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


@st.composite
def wide_floats(draw, lowest=-1074, highest=1023):
    """Floats whose exponents are spread evenly over float64's whole range, and zeros."""
    mantissa = draw(st.floats(0.5, 1.0, exclude_max=True))
    sign = draw(st.sampled_from([-1.0, 1.0, 0.0]))
    return float(np.ldexp(sign * mantissa, draw(st.integers(lowest, highest + 1))))


def rows_of(elements, least=1, most=6):
    row = st.tuples(elements, elements, elements)
    return st.lists(row, min_size=least, max_size=most).map(lambda rows: np.array(rows, dtype=np.float64))


def layouts(rows):
    """The same rows as they may lie in memory."""
    strided = np.full((2 * len(rows), 5), np.nan)
    strided[::2, 1:4] = rows
    read_only = rows.copy()
    read_only.flags.writeable = False
    return {
        "fortran": np.asfortranarray(rows),
        "strided": strided[::2, 1:4],
        "reversed": rows[::-1].copy()[::-1],
        "read-only": read_only,
        "one-by-one": [rows[i : i + 1] for i in range(len(rows))],
    }


EVALUATORS = {
    "normalize": normalize,
    "transform_points": lambda rows: transform_points(rows, SHAPED),
    "transform_vectors": lambda rows: transform_vectors(rows, SHAPED),
    "transform_normals": lambda rows: transform_normals(rows, SHAPED),
    "transform_normals-wide": lambda rows: transform_normals(rows, np.diag([1e200, 1.0, 1e-200, 1.0]) @ SHAPED),
    "transform_points-wide": lambda rows: transform_points(rows, affine(1e300 * LINEAR, w=1e40)),
}


# What every evaluator of rows holds to.


@pytest.mark.parametrize("name", EVALUATORS)
@pytest.mark.parametrize("size", [1.0, 2.0**-1060, 2.0**1000], ids=["size=1", "tiny", "huge"])
def test_neither_layout_nor_neighbours_change_a_bit(name, size):
    rows = ROWS * size
    rows[3] = 0.0
    rows[5] = np.nan
    rows[7, 0] = np.inf
    rows[9] = 3.0, -4.0, 5.0
    expected = EVALUATORS[name](rows)
    for layout, other in layouts(rows).items():
        blocks = other if isinstance(other, list) else [other]
        observed = np.concatenate([EVALUATORS[name](block) for block in blocks])
        assert np.array_equal(observed, expected, equal_nan=True), layout
    order = np.random.default_rng(2).permutation(len(rows))
    assert np.array_equal(EVALUATORS[name](rows[order]), expected[order], equal_nan=True)


@pytest.mark.parametrize("name", EVALUATORS)
def test_the_result_is_new_contiguous_float64_and_the_input_is_kept(name):
    rows = ROWS.copy()
    observed = EVALUATORS[name](rows)
    assert observed.dtype == np.float64
    assert observed.flags.c_contiguous
    assert not np.shares_memory(observed, rows)
    assert np.array_equal(rows, ROWS)
    assert EVALUATORS[name](np.empty((0, 3))).shape == (0, 3)


@pytest.mark.parametrize("name", EVALUATORS)
@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.longdouble, np.int32, np.uint8])
def test_every_real_type_is_widened(name, dtype):
    rows = np.arange(30).reshape(10, 3).astype(dtype)
    assert np.array_equal(EVALUATORS[name](rows), EVALUATORS[name](rows.astype(np.float64)))


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("vectors", normalize),
        ("points", lambda rows: transform_points(rows, np.eye(4))),
        ("vectors", lambda rows: transform_vectors(rows, np.eye(4))),
        ("normals", lambda rows: transform_normals(rows, np.eye(4))),
    ],
)
@pytest.mark.parametrize("rows", [np.ones((4, 2)), np.ones(3), np.ones((2, 3), complex), [["a", "b", "c"]]])
def test_what_is_no_array_of_rows_is_refused(name, call, rows):
    with pytest.raises(ValueError, match=rf"^{name} must be an \(n, 3\) array of real numbers; got"):
        call(rows)


@pytest.mark.parametrize("call", [transform_points, transform_vectors, transform_normals])
def test_a_matrix_must_be_affine_and_4x4(call):
    with pytest.raises(ValueError, match="matrix must be a 4x4 matrix of real numbers"):
        call(ROWS, np.eye(3))
    with pytest.raises(ValueError, match="matrix must be a 4x4 matrix of finite numbers"):
        call(ROWS, affine(np.diag([1.0, np.nan, 1.0])))
    projection = np.eye(4)
    projection[3] = 0.0, 0.0, -1.0, 0.0
    with pytest.raises(ValueError, match=r"matrix must be an affine 4x4 matrix, .* last row \(0.0, 0.0, -1.0, 0.0\)"):
        call(ROWS, projection)


class FakeVtkMatrix:
    """What `vtkMatrix4x4` offers."""

    def __init__(self, rows):
        self.rows = rows

    def GetElement(self, row, column):
        return self.rows[row][column]


@pytest.mark.parametrize("wrap", [FakeVtkMatrix, np.ndarray.tolist, lambda m: m.astype(np.float32)])
def test_matrices_come_as_lists_arrays_and_vtk_matrices(wrap):
    matrix = affine([[0.0, -2.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 4.0]], (1.0, 2.0, 3.0))
    for call in (transform_points, transform_vectors, transform_normals):
        assert np.array_equal(call(ROWS, wrap(matrix)), call(ROWS, matrix))
    assert np.array_equal(normal_matrix(wrap(matrix)), normal_matrix(matrix))


# Normal matrices.


def test_normal_matrix_of_a_stretch_is_the_reciprocal_stretch():
    assert np.array_equal(normal_matrix(np.diag([2.0, 4.0, 8.0, 1.0])), np.diag([0.5, 0.25, 0.125]))


def test_normal_matrix_ignores_the_translation_and_a_positive_w():
    assert np.array_equal(normal_matrix(affine(LINEAR, (1e9, -1e300, 7.0), w=8.0)), normal_matrix(affine(LINEAR)))


def test_normal_matrix_entries_are_exact_cofactors_rounded_once():
    exact = [[Fraction(entry) for entry in row] for row in LINEAR.tolist()]
    observed = normal_matrix(affine(LINEAR))
    assert 0.5 <= np.abs(observed).max() <= 1.0
    ratios = set()
    for i in range(3):
        for j in range(3):
            (a, b), (c, d) = ([exact[(i + r) % 3][(j + s) % 3] for s in (1, 2)] for r in (1, 2))
            ratios.add(Fraction(observed[i, j].item()) / (a * d - b * c))
    common = min(ratios, key=abs)
    power = abs(Fraction(2) ** round(float(np.log2(float(abs(common))))))
    assert all(abs(abs(ratio) / power - 1) <= U for ratio in ratios)
    assert len({ratio > 0 for ratio in ratios}) == 1


def test_normals_stay_perpendicular_to_the_surface():
    tangents, normals = ROWS[::2], np.cross(ROWS[::2], ROWS[1::2])
    images = np.einsum("ij,ij->i", transform_vectors(tangents, SHAPED), transform_normals(normals, SHAPED))
    assert np.abs(images).max() < 1e-14


def test_a_mirror_keeps_normals_on_their_side():
    mirror = affine(np.diag([-1.0, 1.0, 1.0]))
    assert np.array_equal(transform_normals([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)], mirror), [(-1, 0, 0), (0, 1, 0)])


def test_flattening_warns_and_gives_the_planes_normal_or_zero():
    flat = affine(np.diag([1.0, 1.0, 0.0]))
    with pytest.warns(SingularMatrixWarning, match=r"flattens space onto a plane .* Use a small scale") as caught:
        observed = transform_normals([(0.6, 0.0, 0.8), (0.0, 0.6, -0.8), (1.0, 0.0, 0.0)], flat)
    assert np.array_equal(observed, [(0, 0, 1), (0, 0, -1), (0, 0, 0)])
    assert caught[0].filename == __file__


def test_normal_matrix_takes_less_than_a_millisecond():
    times = []
    for power in (0, -200, 150) * 10:
        start = time.perf_counter()
        normal_matrix(affine(np.diag([10.0**power, 1.0, 10.0**-power]) @ LINEAR))
        times.append(time.perf_counter() - start)
    assert min(times) < 1e-3


@pytest.mark.parametrize("spread", [1, 100, 300, 480, 520, 1000])
def test_normals_through_stretches_of_every_spread_have_the_bits_of_the_stretched_normal(spread):
    matrix = np.diag([2.0**spread, 1.0, 2.0**-spread, 1.0])
    normals = np.ldexp(ROWS, np.array([spread // 2, 0, -(spread // 2)]))
    expected = normalize(np.ldexp(normals, np.array([-spread, 0, spread])))
    assert np.array_equal(transform_normals(normals, matrix), expected)


def test_a_normal_along_an_axis_survives_entries_that_float64_cannot_hold_side_by_side():
    matrix = np.diag([1e300, 1.0, 1e-300, 1.0])
    assert normal_matrix(matrix)[0, 0] == 0.0
    assert np.array_equal(transform_normals(np.eye(3), matrix), np.eye(3))
    assert np.array_equal(transform_normals([(2.0, 0.0, 0.0)], matrix), [(1.0, 0.0, 0.0)])


def test_cofactors_that_float64_cannot_hold_side_by_side_keep_their_proportions_in_long_normals():
    """The small two of diag(2¹⁰⁷⁰ · 1.43, 1.3, 1.1) would have a few bits left beside the large one."""
    matrix = np.diag([2.0**-535, 2.0**535 * 1.1, 2.0**535 * 1.3, 1.0])
    observed = transform_normals([(0.0, 2.0**900, 2.0**900)], matrix)
    assert np.array_equal(observed, normalize([(0.0, 1.3, 1.1)]))


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


@few
@given(power=st.integers(-900, 900), scale=st.integers(-900, 900))
def test_powers_of_two_in_normals_and_matrix_change_no_bit(power, scale):
    expected = transform_normals(ROWS, SHAPED)
    assert np.array_equal(transform_normals(np.ldexp(ROWS, power), affine(np.ldexp(LINEAR, scale))), expected)


# Points and vectors.


def test_points_are_turned_moved_and_divided_by_w():
    matrix = affine([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 3.0]], (10.0, 20.0, 30.0), w=2.0)
    assert np.array_equal(transform_points([(1.0, 2.0, 3.0)], matrix), [(4.0, 10.5, 19.5)])
    assert np.array_equal(transform_vectors([(1.0, 2.0, 3.0)], matrix), [(-1.0, 0.5, 4.5)])


def test_the_identity_changes_nothing():
    for call in (transform_points, transform_vectors):
        for size in (1.0, 1e-300, 1e300):
            assert np.array_equal(call(ROWS * size, np.eye(4)), ROWS * size)
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    assert np.array_equal(transform_normals(axes, np.eye(4)), axes)


@few
@given(
    rows=rows_of(wide_floats(-1000, 900)),
    entries=st.lists(wide_floats(-1000, 1000), min_size=12, max_size=12),
    w=wide_floats(-1000, 1000).filter(bool),
)
def test_points_and_vectors_against_fractions_over_the_whole_range(rows, entries, w):
    """Within 5 roundings of the terms' magnitudes: 3 for the sums, 1 for the product, 1 for the division."""
    matrix = affine(np.reshape(entries[:9], (3, 3)), entries[9:], w)
    exact = [[Fraction(entry) / Fraction(w) for entry in row] for row in matrix[:3].tolist()]
    for call, last in ((transform_points, 1), (transform_vectors, 0)):
        for row, image in zip(rows.tolist(), call(rows, matrix).tolist(), strict=True):
            for observed, factors in zip(image, exact, strict=True):
                terms = [a * Fraction(b) for a, b in zip(factors, [*row, last], strict=True)]
                error = 5 * Fraction(U) * sum(map(abs, terms)) + Fraction(2) ** -1040
                if np.isfinite(observed):
                    assert abs(Fraction(observed) - sum(terms)) <= error
                else:
                    assert abs(sum(terms)) + error >= Fraction(2) ** 1023
                    assert (observed > 0) == (sum(terms) > 0)


def test_points_beyond_float64_are_infinite_without_a_warning():
    observed = transform_points([(1e200, -1e200, 1.0), (1.0, 2.0, 3.0)], affine(np.diag([1e200, 1e200, 1.0])))
    assert np.array_equal(observed, [(np.inf, -np.inf, 1.0), (1e200, 2e200, 3.0)])


def test_sums_that_overflow_on_the_way_come_back():
    matrix = affine([[1e300, 1e300, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert np.array_equal(transform_points([(1e20, -1e20, 1.0)], matrix), [(0.0, 1e20, 1.0)])
    tiny = affine(np.eye(3) * 2.0**-700, w=2.0**-700)
    assert np.array_equal(transform_points(ROWS * 2.0**-700, tiny), ROWS * 2.0**-700)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("w", [1.0, 1e40])
def test_a_point_that_is_not_finite_has_an_image_that_is_not_finite(bad, w):
    rows = ROWS.copy()
    rows[4, 1] = bad
    matrix = affine(LINEAR, (1.0, 2.0, 3.0), w)
    observed = transform_points(rows, matrix)
    assert not np.isfinite(observed[4]).any()
    assert np.array_equal(np.delete(observed, 4, axis=0), np.delete(transform_points(ROWS, matrix), 4, axis=0))


# Normalising.


def test_normalize_gives_the_unit_vector():
    assert np.array_equal(normalize([(3.0, 0.0, 4.0), (0.0, -5e-324, 0.0), (0.0, 0.0, 0.0)])[0], [0.6, 0.0, 0.8])
    assert np.array_equal(normalize([(0.0, -5e-324, 0.0), (0.0, 0.0, 1.7e308)]), [(0, -1, 0), (0, 0, 1)])


@few
@given(rows=rows_of(wide_floats() | st.sampled_from([np.nan, np.inf, -np.inf])))
def test_normalize_gives_finite_unit_rows_or_zero_exactly_where_documented(rows):
    observed = normalize(rows)
    lengths = np.linalg.norm(observed, axis=1)
    sound = np.isfinite(rows).all(axis=1) & rows.any(axis=1)
    assert np.all(np.abs(lengths[sound] - 1.0) <= 4 * U)
    assert not observed[~sound].any()
    assert np.all((np.sign(observed[sound]) == np.sign(rows[sound])) | (observed[sound] == 0.0))


@few
@given(rows=rows_of(wide_floats(-40, 0)), power=st.integers(-1000, 1022))
def test_powers_of_two_change_no_bit_of_a_unit_vector(rows, power):
    scaled = np.ldexp(rows, power)
    exact = np.array_equal(np.ldexp(scaled, -power), rows)
    if exact:
        assert np.array_equal(normalize(scaled), normalize(rows))
