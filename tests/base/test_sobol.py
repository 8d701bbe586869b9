"""Sobol's sequence: equality with SciPy, and the properties of its nets."""

import itertools

import numpy as np
import pytest
from scipy.stats import qmc

from pvphong.base import sobol

EXPONENTS = range(1, 9)


def coordinates(count, numbers):
    """Return coordinates, scrambled for each number, shape (count, numbers)."""
    points = np.arange(count, dtype=np.uint32)[:, None]
    first, second = sobol.seeds(np.asarray(numbers))
    return sobol.coordinate(points, first), sobol.coordinate(sobol.SECOND[:count, None], second)


def test_digits_are_those_of_scipy():
    """The order of the points differs, and digits are reversed."""
    mirrored = [
        [int(f"{digits:032b}"[::-1], 2) / 2**32 for digits in column.tolist()]
        for column in (np.arange(256), sobol.SECOND[:256])
    ]
    expected = qmc.Sobol(2, scramble=False).random(256)
    assert set(zip(*mirrored, strict=True)) == set(map(tuple, expected.tolist()))


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_points_are_alone_in_rectangles_of_equal_size_and_any_shape(exponent):
    count = 2**exponent
    u, v = coordinates(2 * count, range(20))
    assert u.dtype == v.dtype == np.float32
    for begin in (0, count):  # the following points too
        for across in range(exponent + 1):
            columns, rows = 2**across, 2 ** (exponent - across)
            square = np.floor(u[begin:][:count] * columns) * rows + np.floor(v[begin:][:count] * rows)
            assert (np.sort(square, axis=0) == np.arange(count)[:, None]).all()


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_neighbours_share_a_square_or_half_of_one(exponent):
    count, apart = 2**exponent, sobol.NEIGHBOURS[exponent]
    u, v = coordinates(count, range(20))
    columns, rows = 2 ** (exponent // 2), 2 ** (exponent - 1 - exponent // 2)
    square = np.floor(u * columns) * rows + np.floor(v * rows)
    np.testing.assert_array_equal(square, square[np.arange(count) ^ apart])
    assert (np.sort(square, axis=0)[::2] == np.sort(square, axis=0)[1::2]).all()
    assert (np.diff(np.sort(square, axis=0)[::2], axis=0) > 0).all()


@pytest.mark.parametrize("exponent", EXPONENTS)
@pytest.mark.parametrize("together", [2, 8, 16])
def test_points_in_squares_remain_together_when_they_are_scrambled(exponent, together):
    count = 2**exponent
    for begin in (0, count):
        first, second = sobol.in_squares(begin, begin + count, together)
        numbers = np.arange(begin, begin + count)
        np.testing.assert_array_equal(np.unique(first), numbers)
        np.testing.assert_array_equal(second, sobol.SECOND[first])
        assert len(first) == -(-count // together) * together
        seeds = sobol.seeds(np.arange(20))[:, :, None]
        u, v = sobol.coordinate(first, seeds[0]), sobol.coordinate(second, seeds[1])
        apart = max(exponent - together.bit_length() + 1, 0)
        square = np.floor(u * 2 ** -(-apart // 2)) * count + np.floor(v * 2 ** (apart // 2))
        assert (np.ptp(square.reshape(20, -1, together), axis=2) == 0).all()


def test_each_point_is_evenly_distributed_over_seeds_and_depends_on_nothing_else():
    u, v = coordinates(4, range(20_000))
    for each in (*u, *v):
        counts = np.histogram(each, 50, (0.0, 1.0))[0]
        assert ((counts - 400.0) ** 2 / 400.0).sum() < 49 + 5 * np.sqrt(98)  # chi squared
    assert abs(np.corrcoef(u[0], v[0])[0, 1]) < 0.04
    np.testing.assert_array_equal(coordinates(4, [77, 3])[0][:, 1], u[:, 3])


def test_streams_have_nothing_to_do_with_each_other():
    numbers = np.arange(4096)
    both = [sobol.seeds(numbers, stream) for stream in (0, 1, 2, 2**31)]
    assert len({int(seed) for seeds in both for seed in seeds.ravel()}) > 8 * 4096 - 40  # few collide in 32 bits
    for a, b in itertools.combinations(both, 2):
        assert abs(np.corrcoef(a[0].astype(np.float64), b[0].astype(np.float64))[0, 1]) < 4 / 64


def test_random_numbers_are_even_and_do_not_depend_on_each_other():
    """Frequencies in 16 bins, by each argument, are those of random numbers, and so are those of pairs."""
    numbers, seeds = np.meshgrid(np.arange(256, dtype=np.uint32), sobol.seeds(np.arange(256))[0])
    found = sobol.random(numbers, seeds)
    assert found.dtype == np.float32
    assert found.min() >= 0.0
    assert found.max() < 1.0
    for pairs in (found[:, ::2], found[:, 1::2]), (found[::2], found[1::2]):
        places = (pairs[0] * 16).astype(int) * 16 + (pairs[1] * 16).astype(int)
        counts = np.bincount(places.ravel(), minlength=256)
        chi_square = ((counts - counts.mean()) ** 2).sum() / counts.mean()
        assert abs(chi_square - 255) < 4 * np.sqrt(2 * 255)
