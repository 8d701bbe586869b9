"""Shortest blend of three vectors, compared with a dense set of blends."""

from __future__ import annotations

import numpy as np
import pytest

from pvphong.shading.inside import places
from pvphong.shading.inside.places import lattice

WEIGHTS = np.concatenate([np.eye(3), lattice(60)])


@pytest.mark.parametrize("far", [0.0, 1.0, 5.0, 30.0])
def test_no_blend_is_shorter_and_what_is_called_a_corner_is_one(far):
    rng = np.random.default_rng(int(far))
    at_corners = rng.normal(size=(400, 3, 3)) + far * rng.normal(size=(400, 1, 3))
    found = places._shortest(at_corners)
    np.testing.assert_allclose(found.sum(axis=1), 1.0, rtol=1e-12)
    length = np.linalg.norm(np.einsum("ki,kij->kj", found, at_corners), axis=1)
    lengths = np.linalg.norm(np.einsum("si,kij->ksj", WEIGHTS, at_corners), axis=2)
    assert (length <= lengths.min(axis=1) * (1 + 1e-12)).all()
    is_at_corner = places._is_at_corner(at_corners)
    assert (lengths[is_at_corner].argmin(axis=1) < 3).all()
    np.testing.assert_array_equal(is_at_corner, found.max(axis=1) > 1.0 - places._AT_CORNER)
    assert 0 < is_at_corner.sum() < 400
