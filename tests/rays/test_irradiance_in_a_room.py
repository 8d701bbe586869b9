"""Irradiance in a room with a table under a rectangle light, against Radiance's rtrace, direct and bounced."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import pyvista as pv
from radiance import irradiance, polygon

import pvphong as ph

ALBEDO, POWER = 0.6, 1000.0
LAMP = ph.RectangleLight((1.5, 1.2, 2.4), (0, 0, -1), (0, 1, 0), width=0.9, height=0.6, intensity=POWER, name="lamp")


def box(low, high, side, cells):
    """Return a box whose six sides share no points, and its normals: inwards for the side −1, outwards for 1."""
    mesh = pv.Box(np.stack([low, high], axis=1).ravel(), level=cells - 1).triangulate()
    mesh.clear_data()
    away = np.where(np.isclose(mesh.points, low), -1.0, np.isclose(mesh.points, high))
    split = mesh.compute_normals(cell_normals=False, split_vertices=True, feature_angle=30, auto_orient_normals=False)
    direction = np.abs(split.point_data["Normals"]) > 0.5
    split.point_data.active_normals = side * direction * away[split.point_data["pyvistaOriginalPointIds"]]
    return split


ROOM, TABLE = box((0, 0, 0), (3.0, 2.5, 2.6), -1.0, 16), box((0.4, 0.5, 0.7), (1.4, 1.5, 0.75), 1.0, 12)


def in_radiance(mesh, name):
    """Return a box in Radiance's format."""
    bounds, found = np.reshape(mesh.bounds, (3, 2)), ""
    for axis, side in itertools.product(range(3), (0, 1)):
        corners = np.tile(bounds[:, side], (4, 1))
        corners[:, (axis + 1) % 3] = bounds[(axis + 1) % 3][[0, 1, 1, 0]]
        corners[:, (axis + 2) % 3] = bounds[(axis + 2) % 3][[0, 0, 1, 1]]
        found += polygon("matt", f"{name}{axis}{side}", corners)
    return found


def of_radiance(folder, points, normals, bounces):
    """Return Radiance's irradiance in lux; one bounce is sampled by 16,384 rays from each point, without a cache."""
    radiance = POWER / LAMP.area  # of a Lambertian surface with this intensity along its normal
    scene = f"void plastic matt\n0\n0\n5 {ALBEDO} {ALBEDO} {ALBEDO} 0 0\n\n"
    scene += f"void light lamp\n0\n0\n3 {radiance} {radiance} {radiance}\n\n" + polygon("lamp", "panel", LAMP.outline)
    scene += in_radiance(ROOM, "room") + in_radiance(TABLE, "table")
    bounced = "-ab", str(bounces), "-aa", "0", "-ad", "16384", "-lw", "1e-9"
    direct = "-ds", "0.02", "-dj", "0.7", "-dt", "0", "-dc", "1"
    return irradiance(folder, scene, points, normals, *bounced, *direct).mean(axis=1)


@pytest.mark.parametrize("bounces", [0, 1])
def test_a_room_has_radiances_irradiance(bounces, tmp_path):
    scene = ph.Scene([LAMP], light_model=ph.LightModel(shadows=True, bounces=bounces))
    blocks = pv.MultiBlock({"room": ROOM, "table": TABLE})
    transport = blocks.phong.transport(samples=1024) if bounces else None
    found = blocks.phong.irradiance(scene, albedo=ALBEDO, transport=transport)
    random, errors, values = np.random.default_rng(4), [], []
    for name, count in (("room", 60), ("table", 60)):
        points, normals = found[name].points.astype(float), np.asarray(blocks[name].point_data.active_normals, float)
        low, high = np.reshape(found[name].bounds, (3, 2)).T
        is_inside = ((points > low + 0.03) & (points < high - 0.03)).sum(
            axis=1
        ) == 2  # not at an edge, or on a thin side
        rows = random.choice(np.flatnonzero(is_inside), count, replace=False)
        expected = of_radiance(tmp_path, points[rows] + 1e-4 * normals[rows], normals[rows], bounces)
        errors.append(np.asarray(found[name]["irradiance"])[rows, 0] - expected)
        values.append(expected)
    error, value = np.concatenate(errors), np.concatenate(values)
    assert value.mean() > 50.0
    assert abs(error.sum()) < 0.01 * value.sum()
    assert np.sqrt((error**2).mean()) < 0.03 * value.mean()
