"""Tangents from texture coordinates, compared with a plain loop over triangles."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pvphong.geometry.normals import point_normals, point_tangents


def one_by_one(points, triangles, uv, normals):
    """Compute tangents with M. S. Mikkelsen's weights in plain Python, solving for ∂p/∂u."""

    def across(w, n):
        w = w - (w @ n) * n
        return w / math.sqrt(w @ w)

    sums = np.zeros((len(points), 3))
    for triangle in triangles:
        a, b, c = triangle
        along = np.linalg.solve(uv[[b, c]] - uv[a], points[[b, c]] - points[a])[0]
        for here, after, before in ((a, b, c), (b, c, a), (c, a, b)):
            n = normals[here]
            one, two = across(points[after] - points[here], n), across(points[before] - points[here], n)
            sums[here] += math.acos(max(-1.0, min(1.0, one @ two))) * across(along, n)
    return sums / np.linalg.norm(sums, axis=1)[:, None]


@pytest.fixture
def bumpy():
    """A bumpy sheet of triangles with slanted texture coordinates."""
    random = np.random.default_rng(5)
    x, y = np.meshgrid(np.arange(6.0), np.arange(5.0), indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), 0.4 * random.normal(size=30)], axis=1)
    uv = points[:, :2] @ np.array([[0.2, 0.1], [-0.05, 0.3]]) + 0.01 * random.normal(size=(30, 2))
    cells = [(5 * i + j, 5 * i + j + 5, 5 * i + j + 6, 5 * i + j + 1) for i in range(5) for j in range(4)]
    triangles = np.array([t for a, b, c, d in cells for t in ((a, b, c), (a, c, d))])
    return points, triangles, uv, point_normals(points, triangles.ravel(), np.arange(0, 121, 3))


@pytest.mark.parametrize("unit", [1e-200, 1.0, 1e200])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_it_is_mikkelsens_in_any_unit_and_for_mirrored_pictures(bumpy, unit, way):
    points, triangles, uv, normals = bumpy
    uv = uv * (way, 1.0)
    found = point_tangents(unit * points, triangles.ravel(), np.arange(0, 121, 3), uv, 3.0 * normals)
    np.testing.assert_allclose(found, one_by_one(points, triangles, uv, normals), atol=1e-12)


def test_where_there_is_none_it_is_zero():
    """A fan around a pole, whose tangents cancel; a face without area in the texture; a point without faces."""
    ring = [(math.cos(a), math.sin(a), 0.0) for a in np.linspace(0, 2 * np.pi, 8, endpoint=False)]
    points = np.array([(0.0, 0.0, 0.0), *ring, (5, 5, 5)])
    around = np.arange(8) / 8
    faces = np.array([(0, 1 + k, 1 + (k + 1) % 8) for k in range(8)])
    uv = np.array([(0.5, 1.0), *((u, 0.0) for u in around), (0.0, 0.0)])
    found = point_tangents(points, faces.ravel(), np.arange(0, 25, 3), np.zeros((10, 2)), [(0, 0, 1)] * 10)
    assert not found.any()
    found = point_tangents(points, faces[:7].ravel(), np.arange(0, 22, 3), uv, [(0, 0, 1)] * 10)
    assert not found[9].any()
    assert np.isfinite(found).all()
