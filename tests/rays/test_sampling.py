"""How many rays a place gets: against parts that are known, of rays that are made up."""

import numpy as np
import pytest

from pvphong.rays.sampling import Cast, look
from pvphong.shading.visibility import Around, Goal

NO_FACES = np.zeros((0, 3), np.int64)


def numbers(begin, end):
    """Van der Corput's sequence, shifted: the first 2ᵐ are alone in intervals of equal length."""
    bits = (np.arange(begin, end)[:, None] >> np.arange(12)) & 1
    return (bits @ 0.5 ** np.arange(1, 13) + 0.37) % 1.0


def looking(hidden, triangles=NO_FACES, **options):
    """What places see of which such a part of all is hidden, and how many rays each of them took."""
    hidden, taken = np.asarray(hidden), np.zeros(len(hidden), int)

    def cast(vertices, begin, end):
        taken[vertices] += end - begin
        sent = np.ones((end - begin, len(vertices)), np.float32)
        seen = sent * (numbers(begin, end)[:, None] >= hidden[vertices])
        return Cast(sent, seen, np.ones(len(vertices)), sent.size)

    how = {"tolerance": 1e-3, "samples": None, "brightness": 1.0, "least": 16, "rays_at_once": 2**17}
    return look(len(hidden), cast, triangles, **how | options), taken


def test_rays_that_agree_are_enough_where_nothing_else_is_seen_around():
    alone, taken = looking([0.0, 0.004, 1.0])
    np.testing.assert_array_equal(alone.part, [1, 1, 0])
    assert (not alone.error.any(), taken.tolist()) == (True, [64] * 3)
    faces = np.array([[0, 1, 2]])
    within, taken = looking([0.0, 0.004, 0.0], faces)
    np.testing.assert_array_equal(within.part, 1.0)
    assert taken.tolist() == [16] * 3


@pytest.mark.parametrize("hidden", [0.004, 0.996])
def test_rays_that_agree_beside_others_go_on_until_the_last_part_is_found(hidden):
    around = Around(np.array([0.0, 1.0, 0.0]), np.array([1.0, 1.0, 0.0]))
    found, taken = looking([hidden] * 3, around=around)
    assert taken[0] >= 256
    assert 0.0 < abs(found.part[0] - (1.0 - hidden)) < 3.0 * found.error[0] < 0.01
    same = 1 if hidden < 0.5 else 2  # around which the same is seen as from there
    assert (taken[same], found.error[same]) == (64, 0.0)
    vertices, _ = looking([hidden, 0.5, hidden], np.array([[0, 1, 2]]))
    assert np.abs(vertices.part[::2] - (1.0 - hidden)).max() < 0.004


def test_what_so_many_rays_may_have_missed_is_an_error_where_others_are_around():
    around = Around(np.zeros(2), np.array([1.0, 0.0]))
    found, taken = looking([0.0, 0.0], around=around, tolerance=1 / 500)
    assert found.part.tolist() == [1, 1]
    np.testing.assert_allclose(found.error, 0.5 / 256)
    assert taken.tolist() == [256] * 2
    within, taken = looking([0.0, 1.0, 0.5], np.array([[0, 1, 2]]), tolerance=1 / 500)
    assert within.error[:2].tolist() == [0, 0]  # as it is told of vertices
    assert (taken[:2] == 16 + 256).all()


def test_rays_end_where_a_colour_is_within_what_is_allowed_and_not_before():
    """Off by nothing, by a little less than what is allowed, and by more than that."""
    count, step = 3, 0.1
    allowed = np.full(count, 0.02)
    off = np.array([0.0, 0.019, 0.05])[:, None] - 0.5 * step * np.ones((count, 3))
    goal = Goal(off, np.full((count, 3), step), allowed)
    around = Around(np.zeros(count), np.ones(count), goal)
    found, taken = looking([0.5 + 1e-4] * count, around=around, tolerance=1e-4)
    assert taken[0] == 64
    assert taken[1] > 64
    assert taken[2] == 1024
    for row in range(count):
        color = off[row] + found.part[row] * step
        reached = np.abs(color).max() + 2 * found.error[row] * step <= 0.02
        assert reached == (row < 2)
    without, taken_without = looking([0.5 + 1e-4] * count, tolerance=1e-4)
    assert (taken_without == 1024).all()
    assert without.part[2] == found.part[2]
    rows = np.array([2, 0])
    np.testing.assert_array_equal(around.at(rows).goal.if_hidden, off[rows])
    np.testing.assert_array_equal(Around(np.zeros(3), np.ones(3)).at(rows).most, 1.0)
