"""Normals by compiled code: threads and ranges change no bit, and large faces are left to NumPy.

geometry/test_normals and stability/test_mesh_normals test that both forms are correct.
"""

from __future__ import annotations

import numpy as np
import pytest
from soups import bumpy, soup

from pvphong.base import threads
from pvphong.geometry.normals import point_normals
from pvphong.shading import kernel
from pvphong.shading.kernel.normals import CHUNK, CORNERS

WEIGHTINGS = ["angle", "area", "max"]
POINTS, FACES = bumpy(110, quads=True)
ORDERS = {
    "in order": np.arange(len(POINTS)),
    "backwards": np.arange(len(POINTS))[::-1],
    "shuffled": np.random.default_rng(1).permutation(len(POINTS)),
}


@pytest.mark.parametrize("order", ORDERS.values(), ids=ORDERS)
@pytest.mark.parametrize("weighting", WEIGHTINGS)
def test_ranges_and_threads_change_no_bit(order, weighting, monkeypatch):
    """The order of the points does not matter either."""
    assert len(FACES) > 3 * CHUNK
    mesh = soup(*(order[list(face)] for face in FACES))
    points = np.empty_like(POINTS)
    points[order] = POINTS
    expected = kernel.point_normals(POINTS, *soup(*FACES), weighting)
    assert np.abs(expected - point_normals(POINTS, *soup(*FACES), weighting)).max() <= 8 * 2.0**-53
    for length, most in ((10**6, 1), (100, 1), (333, 2), (4096, 2)):
        monkeypatch.setattr("pvphong.shading.kernel.normals._RANGE", length)
        monkeypatch.setattr("pvphong.shading.kernel.normals._MOST_POINTS", 2 * length)
        with threads.limited(most):
            assert np.array_equal(kernel.point_normals(points, *mesh, weighting)[order], expected), (length, most)


def ring(count):
    turn = 2 * np.pi * np.arange(count) / count
    return np.stack([np.cos(turn), np.sin(turn), 0.1 * np.cos(9 * turn)], axis=1), np.arange(count), [0, count]


@pytest.mark.parametrize("count", [CORNERS // 2 + 1, CORNERS, CORNERS + 1])
@pytest.mark.parametrize("weighting", WEIGHTINGS)
def test_a_face_has_as_many_corners_as_a_block_or_is_left_to_numpy(count, weighting):
    points, connectivity, offsets = ring(count)
    found = kernel.point_normals(points, connectivity, np.array(offsets), weighting)
    if count > CORNERS:
        assert found is None
    else:
        assert np.abs(found - point_normals(points, connectivity, offsets, weighting)).max() <= 8 * 2.0**-53
