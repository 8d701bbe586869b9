"""Section V, shadows: hard cases for rays from vertices, compared with naive origins; see meshes/test_shadows.

Naive rays start a ten-thousandth of the mesh's size above a vertex, or inside its faces, and are cast in world
coordinates in single precision. Each row counts the vertices with a visibility that differs from exact geometry.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import pyvista as pv
from ray_backends import BACKENDS
from stability.bounds import assert_within

import pvphong as ph
from pvphong.rays import casting
from pvphong.rays.casting import Locator

SLANTED = ph.DirectionalLight(direction=(-3, 1, -0.2))
SUN = ph.DirectionalLight(direction=(0, 0, -1))


@pytest.fixture(params=BACKENDS, autouse=True)
def _backend(request: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr(casting, "ray_backend", lambda: (BACKENDS[request.param], ""))


def floor(cells: int = 30, **where: Any) -> pv.PolyData:
    return pv.Plane(i_size=4, j_size=4, i_resolution=cells, j_resolution=cells, **where).triangulate()


def put(mesh: pv.PolyData, unit: float, offset: float) -> pv.PolyData:
    result = mesh.copy()
    result.points = mesh.points.astype(np.float64) * unit + offset
    return result


def seen(mesh: pv.PolyData, light: Any, *occluders: pv.PolyData) -> Any:
    return mesh.phong.visibility([light], occluders=list(occluders)).per_light[0]


def naively(origins: Any, light: Any, *meshes: pv.PolyData) -> Any:
    """Return the visibility from origins, with rays in single-precision world coordinates."""
    whole = pv.merge([mesh.triangulate() for mesh in meshes], merge_points=False)
    faces = whole.points.astype(np.float32).astype(np.float64), whole.regular_faces.astype(np.int64)
    directions = np.tile(-np.array(light.direction, float) / np.linalg.norm(light.direction), (len(origins), 1))
    lengths = np.full(len(origins), 1e3)
    return ~Locator(*faces).blocked(origins.astype(np.float32).astype(np.float64), directions, lengths)


def wrong(found: Any, expected: Any) -> int:
    return int(np.count_nonzero(np.asarray(found, bool) != np.asarray(expected, bool)))


@pytest.mark.parametrize("resolution", [6, 8, 20])
@pytest.mark.parametrize("light", [SUN, SLANTED])
def test_terminator_of_a_coarse_ball(resolution: int, light: Any) -> None:
    """The normals define the terminator; naive rays from inside a face are blocked by its neighbours."""
    ball = pv.Sphere(theta_resolution=resolution, phi_resolution=resolution)
    speck = pv.Sphere(radius=0.01, center=(0, 0, -9))  # makes the scene non-convex, so that rays are cast
    normals = ball.phong.normals()
    facing = normals @ -np.array(light.direction)
    clear = np.abs(facing) > 1e-6
    ours = seen(pv.merge([ball, speck]), light)[: ball.n_points]
    assert_within(f"V terminator {resolution}", wrong(ours[clear], facing[clear] > 0), 0)
    if light is SLANTED:
        corners, weights = ball.regular_faces, np.random.default_rng(1).dirichlet([1, 1, 1], 40)
        inside, blended = (np.einsum("wk,fkx->wfx", weights, a[corners]).reshape(-1, 3) for a in (ball.points, normals))
        lit = blended @ -np.array(light.direction) > 1e-6
        assert wrong(naively((inside + 1e-4 * blended)[lit], light, ball), True) > 0.01 * np.count_nonzero(lit)


@pytest.mark.parametrize(("unit", "offset"), [(1e-20, 0.0), (1e15, 0.0), (1.0, 1e7), (1e-3, -1e4)])
def test_units_and_world_offsets(unit: float, offset: float) -> None:
    ground, hat = floor(), pv.Disc(center=(0.01, 0.02, 1.0), inner=0.0, outer=1.0, c_res=60)
    expected = seen(ground, SUN, hat)
    moved, above = put(ground, unit, offset), put(hat, unit, offset)
    row = f"V unit {unit:g}, offset {offset:g}"
    assert_within(row, wrong(seen(moved, SUN, above), expected), 0.002 * len(expected))
    if offset:
        origins = moved.points + np.array([0.0, 0.0, 4e-4 * unit])
        assert wrong(naively(origins, SUN, moved, above), expected) > 0.002 * len(expected)


def test_edges_of_a_closed_room() -> None:
    """Edge vertices of the floor are in the planes of the walls; a lamp outside lights none of them."""
    room = pv.Box(bounds=(-1, 1, -1, 1, 0, 2), level=6).flip_faces().rotate_z(10.0).rotate_x(3.0)
    room = room.compute_normals(split_vertices=True, feature_angle=30.0, auto_orient_normals=False)
    assert_within("V closed room", np.count_nonzero(seen(room, SUN)), 0)
    facing = room.point_normals[:, 2] > 1e-6
    assert wrong(naively((room.points + 2e-4 * room.point_normals)[facing], SUN, room), False) > 0
