"""Sharp edges split by compiled code, compared with VTK's filter and with fans that Python grows edge by edge."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
import pyvista as pv
from soups import bumpy, soup

from pvphong.base import threads
from pvphong.meshes.surfaces import polygons
from pvphong.shading import kernel
from pvphong.shading.kernel.normals import CHUNK, CORNERS


def split_by_vtk(points, connectivity, offsets, angle):
    """Return the connectivity after PyVista's filter, and the original point of each new one."""
    mesh = pv.PolyData()
    mesh.points = points
    mesh.faces = pv.CellArray.from_arrays(offsets, connectivity, deep=True)
    how = dict.fromkeys(("cell_normals", "consistent_normals", "auto_orient_normals", "non_manifold_traversal"), False)
    split = mesh.compute_normals(split_vertices=True, feature_angle=angle, **how)
    faces = pv.convert_array(split.GetPolys().GetConnectivityArray())
    return faces, split["pyvistaOriginalPointIds"][mesh.n_points :]


def as_by_vtk(points, mesh, angle):
    """Split a mesh by compiled code, and check that the result equals the filter's, with new points in its order."""
    found, expected = kernel.split_points(points, *mesh, angle), split_by_vtk(points, *mesh, angle)
    for ours, theirs in zip(found, expected, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    return found


def fans_of(points, mesh, angle):
    """Return the fans around each point, sets of faces connected by smooth edges, by definition.

    An edge connects two faces if both have it, no other face has both of its ends, and their normals are close enough.
    """
    faces = [mesh[0][a:b].tolist() for a, b in pairwise(mesh[1])]
    normals = []
    for face in faces:
        corners = points[face].astype(float)
        normal = sum(np.cross(one - corners[0], two - corners[0]) for one, two in pairwise(corners[1:]))
        normals.append(normal / np.linalg.norm(normal))
    found = set()
    for point in range(len(points)):
        around = [face for face, corners in enumerate(faces) if point in corners]
        owner = {face: {face} for face in around}
        for one in around:
            corners = faces[one]
            place = corners.index(point)
            for other in (corners[place - 1], corners[(place + 1) % len(corners)]):
                both = [face for face in around if other in faces[face] and face != one]
                if len(both) == 1 and normals[one] @ normals[both[0]] > math.cos(math.radians(angle)):
                    joined = owner[one] | owner[both[0]]
                    for face in joined:
                        owner[face] = joined
        found |= {(point, frozenset(fan)) for fan in owner.values()}
    return found


def fans_after(points, mesh, found):
    """Return the fans after a split: the faces of each point."""
    connectivity, added = found
    origins = np.concatenate([np.arange(len(points)), added])
    owners = np.repeat(np.arange(len(mesh[1]) - 1), np.diff(mesh[1]))
    np.testing.assert_array_equal(origins[connectivity], mesh[0])
    around = {}
    for point, face in zip(connectivity.tolist(), owners.tolist(), strict=True):
        around.setdefault(point, set()).add(face)
    assert set(around) >= set(range(len(points), len(origins)))  # each new point has a face
    return {(int(origins[point]), frozenset(fan)) for point, fan in around.items()}


def random_grid(seed, kind):
    """Return a rough grid of triangles or quads, with smooth and sharp edges, some faces reversed and some missing."""
    rng = np.random.default_rng(seed)
    points, faces = bumpy(12, quads=bool(seed % 2))
    points[:, 2] *= rng.choice([0.2, 0.6, 2.0])
    faces = [face[::-1] if rng.random() < 0.1 else face for face in faces if rng.random() < 0.9]
    order = rng.permutation(len(points))
    moved = np.empty_like(points)
    moved[order] = points
    return moved.astype(kind), soup(*(order[list(face)] for face in faces))


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("seed", range(12))
def test_random_grids_are_split_as_by_vtk_and_by_definition(seed, kind):
    points, mesh = random_grid(seed, kind)
    for angle in (10.0, 30.0, 75.0, 120.0):
        found = as_by_vtk(points, mesh, angle)
        if not seed % 2:  # `fans_of` has other normals for quads that are not flat
            assert fans_after(points, mesh, found) == fans_of(points, mesh, angle)


@pytest.mark.parametrize("seed", range(20))
def test_faces_at_random_are_split_as_by_vtk(seed):
    """Edges with many faces, repeated points in faces, doubled faces, polygons that are not flat, unused points."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(14, 3)).astype(np.float32)
    points[12:] = points[:2]  # coincide with others
    faces = [rng.integers(0, 13, rng.integers(3, 7)).tolist() for _ in range(30)]
    faces = [[*face, face[0]] if rng.random() < 0.1 else face for face in faces] + faces[:2]
    for angle in (1.0, 60.0, 100.0, 180.0):
        as_by_vtk(points, soup(*faces), angle)


@pytest.mark.parametrize("make", [pv.Cube, pv.Cylinder, pv.Cone, pv.Sphere, pv.Icosahedron, pv.Octahedron])
@pytest.mark.parametrize("angle", [30.0, 60.0, 90.0, 120.0])
def test_an_angle_that_is_just_an_edges_is_decided_as_by_vtk(make, angle):
    """A cube's edges have 90° and those of a prism with 12 sides 30°: rounding must agree with the filter's."""
    shape = make(resolution=12) if make in (pv.Cylinder, pv.Cone) else make()
    for mesh in (shape.clean(), shape.triangulate().clean(), shape.rotate_vector((1, 2, 3), 40).clean()):
        as_by_vtk(mesh.points, polygons(mesh), angle)


def fan(count, *, height=1.0):
    """Return a cone of triangles around a point, with random heights of the ring."""
    rng = np.random.default_rng(2)
    turn = 2.0 * np.pi * np.arange(count) / count
    ring = np.stack([np.cos(turn), np.sin(turn), rng.uniform(0.0, height, count)], axis=1)
    faces = np.stack([np.zeros(count, int), 1 + np.arange(count), 1 + (1 + np.arange(count)) % count], axis=1)
    return np.concatenate([[[0.0, 0.0, 2.0]], ring]), soup(*rng.permutation(faces))


@pytest.mark.parametrize("count", [3, 4, 7, 8, 400])
def test_a_pole(count):
    for angle in (5.0, 40.0, 179.0):
        as_by_vtk(*fan(count), angle)


def test_a_pole_of_very_many_faces_takes_no_time_squared():
    """Comparing all pairs of faces would take hours."""
    points, mesh = fan(400_000, height=0.0)
    found, added = kernel.split_points(points, *mesh, 30.0)
    assert not len(added)
    np.testing.assert_array_equal(found, mesh[0])
    _, added = kernel.split_points(points, *mesh, 1e-9)
    assert (added == 0).sum() == 400_000 - 1


@pytest.mark.parametrize("spoil", [np.nan, np.inf, 1e30, -0.0])
def test_points_that_are_not_finite_and_faces_without_an_area(spoil):
    points, mesh = random_grid(4, np.float32)
    points[[5, 40, 41]] = spoil
    points[60] = points[61]
    for angle in (30.0, 100.0):
        as_by_vtk(points, mesh, angle)


@pytest.mark.parametrize(("offset", "scale"), [(1e7, 1.0), (0.0, 1e-30), (0.0, 1e150), (0.0, 1e-170)])
def test_far_from_the_origin_tiny_and_huge(offset, scale):
    points, mesh = random_grid(6, np.float64)
    as_by_vtk(scale * points + offset, mesh, 30.0)


ORDERS = {"in order": lambda n: np.arange(n), "shuffled": np.random.default_rng(1).permutation}


@pytest.mark.parametrize("order", ORDERS.values(), ids=ORDERS)
def test_ranges_and_threads_change_no_bit(order, monkeypatch):
    points, faces = bumpy(110, quads=True)
    assert len(faces) > 3 * CHUNK
    numbers = order(len(points))
    moved = np.empty_like(points)
    moved[numbers] = points
    mesh = soup(*(numbers[list(face)] for face in faces))
    expected = as_by_vtk(moved, mesh, 30.0)
    assert len(expected[1]) > 10_000
    for length, most in ((10**6, 1), (100, 1), (333, 2), (4096, 2)):
        monkeypatch.setattr("pvphong.shading.kernel.edges._RANGE", length)
        monkeypatch.setattr("pvphong.shading.kernel.edges._MOST_POINTS", 2 * length)
        monkeypatch.setattr("pvphong.shading.kernel.edges._FACES", length)
        with threads.limited(most):
            for ours, theirs in zip(kernel.split_points(moved, *mesh, 30.0), expected, strict=True):
                assert np.array_equal(ours, theirs), (length, most)


def test_the_form_of_the_arrays_does_not_matter():
    points, (connectivity, offsets) = random_grid(3, np.float64)
    expected, before = kernel.split_points(points, connectivity, offsets, 30.0), connectivity.copy()
    wide = np.zeros((len(points), 5))
    wide[:, 1:4] = points
    for given in (points.copy("F"), wide[:, 1:4]):
        found = kernel.split_points(given, connectivity.astype(np.int32), offsets.astype(np.uint16), 30.0)
        np.testing.assert_array_equal(found[0], expected[0])
        np.testing.assert_array_equal(found[1], expected[1])
    np.testing.assert_array_equal(connectivity, before)


def test_what_is_left_to_vtk():
    points = np.random.default_rng(1).normal(size=(CORNERS + 2, 3))
    assert kernel.split_points(points, *soup(range(CORNERS)), 30.0) is not None
    for faces in ([range(CORNERS + 1)], [(0, 1, 2), (1, 2)], [(0, 1, 2), ()], [(0, 1, CORNERS + 2)], [(0, 1, -1)], []):
        assert kernel.split_points(points, *soup(*faces), 30.0) is None
