"""Daylight in national coordinates, millions of metres from the origin, at any size, and on degenerate faces."""

from __future__ import annotations

import math

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph

pandas = pytest.importorskip("pandas")
pytest.importorskip("pvlib")

MUNICH = ph.Place(48.14, 11.58)
DAY = pandas.date_range("2026-06-21T00:30", periods=24, freq="h", tz="Europe/Berlin")
RESULTS = "sun_hours", "direct", "diffuse", "reflected", "total", "standard_error"


def town(scale=1.0, offset=(0.0, 0.0, 0.0)):
    """Return streets, walls and roofs in float64."""
    ground = pv.Plane(i_size=40, j_size=40, i_resolution=20, j_resolution=20).triangulate()
    houses = [pv.Box((x, x + 6, y, y + 5, 0, h)).triangulate() for x, y, h in ((-12, -8, 9), (3, -9, 6), (-4, 4, 12))]
    mesh = pv.merge([ground, *houses], merge_points=False)
    mesh.points = mesh.points.astype(np.float64) * scale + offset
    return mesh


@pytest.mark.parametrize(
    ("scale", "offset"),
    [(1.0, (692_000.0, 5_335_000.0, 520.0)), (1e3, (0, 0, 0)), (2.0**-40, (0, 0, 0)), (2.0**40, (0, 0, 0))],
)
def test_results_do_not_depend_on_units_and_origins(scale, offset):
    plain, moved = (each.phong.daylight(DAY, MUNICH, feature_angle=30) for each in (town(), town(scale, offset)))
    # rays that graze an edge may change
    for name in RESULTS:
        ours, theirs = getattr(plain, name), getattr(moved, name)
        assert np.isclose(ours, theirs, rtol=1e-6, atol=1e-6 * ours.max()).mean() > 0.97, name
        assert theirs.sum() == pytest.approx(ours.sum(), rel=2e-3), name


def test_degenerate_and_spoiled_faces():
    mesh = town()
    count = mesh.n_points
    extra = pv.PolyData(
        np.array([(0, 0, 20), (0, 0, 20), (1, 1, 20), (math.nan, 0, 5)]), faces=[3, 0, 1, 2, 3, 0, 2, 3]
    )
    spoiled = pv.merge([mesh, extra], merge_points=False)
    light, plain = (each.phong.daylight(DAY, MUNICH) for each in (spoiled, mesh))
    for name in RESULTS:
        values = getattr(light, name)
        assert np.isfinite(values).all()
        assert (values >= 0.0).all()
        np.testing.assert_allclose(values[:count], getattr(plain, name), rtol=1e-6, atol=1e-3 * values.max())


@pytest.mark.parametrize("height", [-1e-9, 0.0, 1e-9])
def test_points_on_and_below_the_ground_plane(height):
    """Light is between none and that of an open place, on both sides of a floor."""
    floor = pv.Plane(i_size=40, j_size=40)
    cloud = pv.PolyData(np.array([(1.0, 2.0, height)] * 3))
    cloud.point_data.active_normals = np.array([(0, 0, 1), (0, 0, -1), (1, 0, 0)], float)
    light = cloud.phong.daylight(DAY, MUNICH, occluders=[floor])
    open_air = cloud.phong.daylight(DAY, MUNICH)
    assert (light.total <= open_air.total * (1.0 + 1e-9)).all()
    assert np.isfinite(light.total).all()
