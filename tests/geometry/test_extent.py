"""Bounds of vertices, views of targets, and the convexity test."""

import itertools
import math

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.geometry.extent import MeshBounds, is_convex
from pvphong.geometry.transform import normalize


@pytest.mark.parametrize("distance", [1.001, 1.5, 30.0])
def test_a_target_is_seen_off_its_direction_by_no_more_and_hardly_less_than_is_said(distance):
    """The bound holds for any point in the sphere around the vertices; a tangent ray has the largest angle."""
    corners = np.array([(3.0, 1.0, -2.0), (4.0, 3.0, 0.0)])
    center, radius = MeshBounds(corners, None, None).sphere
    assert (center, radius) == ((3.5, 2.0, -1.0), pytest.approx(1.5, rel=1e-8))
    target = np.array(center) + distance * radius * np.array([0.6, 0.0, 0.8])
    seen = MeshBounds(corners, None, None).sight(target)
    assert (seen.direction, seen.distance) == (pytest.approx((0.6, 0, 0.8)), pytest.approx(distance * radius))
    u = np.random.default_rng(3).normal(size=(20000, 3))
    places = center + radius * u / np.linalg.norm(u, axis=1, keepdims=True)
    off = np.arccos(normalize(target - places) @ seen.direction)
    assert 0.99 * seen.turn < off.max() <= seen.turn
    assert MeshBounds(corners, None, None).sight(center) is None
    assert MeshBounds(np.full((1, 3), 1.7e308), None, None).sphere.center == (1.7e308,) * 3
    for count in (1, 513, 1025):  # rows are reduced in blocks
        points = np.random.default_rng(count).normal(size=(count, 3)).cumsum(axis=0)
        np.testing.assert_array_equal(MeshBounds(points, None, None).box, [points.min(axis=0), points.max(axis=0)])


def test_normals_lie_in_a_cone_that_is_hardly_wider_than_they_need():
    for axis, slope in itertools.product(np.eye(3), (1e-3, 0.3, 3.0)):
        normals = 5.0 * axis + 5.0 * slope * (1.0 - axis) * np.array(list(itertools.product((-1, 1), repeat=3)))
        middle, angle = MeshBounds(normals, lambda normals=normals: normals, None).normal_cone
        np.testing.assert_allclose(middle, axis, atol=1e-15)
        assert math.atan(slope * math.sqrt(2.0)) <= angle <= math.atan(slope * math.sqrt(2.0)) + 2e-7


def judged(mesh, normals=None):
    mesh = mesh.triangulate()
    normals = ph.pipeline.vertex_normals(mesh) if normals is None else normals
    return is_convex(mesh.points, normals, mesh.faces.reshape(-1, 4)[:, 1:])


def dented():
    mesh = pv.Sphere()
    mesh.points[300] *= 0.99
    return mesh


def great_dodecahedron():
    """Twelve pentagons that intersect each other."""
    body = pv.PlatonicSolid("icosahedron").triangulate()
    triangles, pentagons = body.faces.reshape(-1, 4)[:, 1:], []
    for apex in range(12):
        edges = {face[k - 2]: face[k - 1] for face in triangles.tolist() for k in range(3) if face[k] == apex}
        around = [next(iter(edges))]
        while len(around) < 5:
            around.append(edges[around[-1]])
        pentagons.append([5, *around])
    return pv.PolyData(body.points, np.ravel(pentagons))


def wound_twice(count=4001):
    """A double cone with convex edges, whose rim winds around twice before it closes."""
    angles = 2.0 * np.pi * np.arange(count) / count
    rim = np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles])
    here = np.arange(count)
    there, top = (here + 2) % count, np.full(count, count)
    sides = np.concatenate([np.column_stack([here, there, top]), np.column_stack([there, here, top + 1])])
    return pv.PolyData.from_regular_faces(np.vstack([rim, (0, 0, 1), (0, 0, -1)]), sides)


CONVEX = {
    "ball": pv.Sphere,
    "cube": pv.Cube,
    "cube of flat parts": lambda: pv.Box(level=5),
    "cone": pv.Cone,
    "cylinder": pv.Cylinder,
    "tetrahedron": pv.Tetrahedron,
    "ellipsoid": lambda: pv.Sphere().scale((1, 2, 3)),
}
OTHERS = {
    "torus": pv.ParametricTorus,
    "half a ball": lambda: pv.Sphere(end_theta=180),
    "plane": pv.Plane,
    "dented": dented,
    "inside out": lambda: pv.Sphere().flip_faces(),
    "two": lambda: pv.merge([pv.Sphere(), pv.Sphere(center=(3, 0, 0))]),
    "one inside the other": lambda: pv.merge([pv.Sphere(), pv.Sphere(radius=0.2)]),
    "twice the same": lambda: pv.merge([pv.Sphere(), pv.Sphere()], merge_points=False),
    "through each other": great_dodecahedron,
    "wound twice": wound_twice,
    "ant": pv.examples.load_ant,
}


@pytest.mark.parametrize("name", CONVEX)
@pytest.mark.parametrize("place", [(0, 0, 0), (1e3, -2e3, 5e3)])
def test_convex_bodies_are_known(name, place):
    mesh = CONVEX[name]()
    mesh.points = mesh.points.astype(np.float64) * 1e-3 + place
    assert judged(mesh)


@pytest.mark.parametrize("name", OTHERS)
def test_nothing_else_is_taken_for_one(name):
    assert not judged(OTHERS[name]())


def test_normals_that_do_not_point_out_of_it_are_not_taken():
    ball = pv.Sphere()
    normals = ph.pipeline.vertex_normals(ball)
    assert not judged(ball, -normals)
    normals[7] = normals[400]
    assert not judged(ball, normals)
    normals[7] = 0.0
    assert not judged(ball, normals)
    ball.points[5] = np.nan
    assert not judged(ball, ph.pipeline.vertex_normals(pv.Sphere()))
