"""Misfit normals, reversed faces, severity by share, and remedies that repair their faults."""

import numpy as np
import pytest
import pyvista as pv
from pyvista import examples
from soups import mesh_of

from pvphong.geometry.fit import BEYOND, MISFIT
from pvphong.studies.diagnose.diagnosis import diagnose

NAN = np.nan
SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
ROOF = SQUARE + np.array([(0, 0, 0), (0, 0, 1), (0, 0, 0), (0, 0, 2)])


def bare(mesh):
    mesh = mesh.copy()
    mesh.clear_data()
    return mesh


def moved(mesh, change):
    """Return a mesh whose points were changed after its normals were stored, a common mistake."""
    mesh = mesh.copy()
    change(mesh.points)
    return mesh


def stretched(points):
    points[:, 2] *= 10


def sheared(points):
    points[:, 0] += 3 * points[:, 2]


def with_normals(mesh, normals):
    mesh = mesh.copy()
    mesh.point_data.active_normals = np.resize(np.asarray(normals, dtype=float), (mesh.n_points, 3))
    return mesh


def grid(x, y, z):
    return pv.StructuredGrid(x, y, z)


def flipped_faces(mesh, *numbers):
    """Return a mesh of quads or triangles with some faces reversed."""
    mesh = mesh.copy()
    faces = mesh.regular_faces.copy()
    faces[list(numbers)] = faces[list(numbers), ::-1]
    mesh.regular_faces = faces
    return mesh


def isosurface(contour="contour"):
    volume = pv.ImageData(dimensions=(20, 20, 20), origin=(-1, -1, -1), spacing=(2 / 19,) * 3)
    volume["distance"] = np.linalg.norm(volume.points, axis=1)
    return volume.contour([0.5], scalars="distance", method=contour)


X, Y = np.meshgrid(np.linspace(-10, 10, 20), np.linspace(-10, 10, 20))
TERRAIN = grid(X, Y, np.sin(np.hypot(X, Y)))
BOWL = moved(bare(pv.Plane()), lambda points: np.square(points[:, :2]).sum(axis=1, out=points[:, 2]))
SPHERE, HILLS, PLANE = pv.Sphere(), examples.load_random_hills(), bare(pv.Plane())
BALL = bare(SPHERE)
BEAM = examples.load_tetbeam()

FAULTS = {
    "a NaN": ("non_finite_points", mesh_of([*SQUARE[:3], (0, NAN, 0), (0, 2, 0)], (0, 1, 2), (0, 2, 3), (0, 2, 4))),
    "a zero normal": ("zero_normals", with_normals(PLANE, (0, 0, 0))),
    "a normal of NaN": ("non_finite_normals", with_normals(PLANE, (0, 0, NAN))),
    "a stretched ball": ("misfit_normals", moved(SPHERE, stretched)),
    "stretched hills": ("misfit_normals", moved(HILLS, stretched)),
    "sheared hills": ("misfit_normals", moved(HILLS, sheared)),
    "a turned ball": ("misfit_normals", SPHERE.flip_faces()),
    "turned hills": ("misfit_normals", HILLS.flip_faces()),
    "a mirrored ball": ("misfit_normals", SPHERE.reflect((1, 0, 0))),
    "normals that look inwards": ("misfit_normals", with_normals(SPHERE, -SPHERE.point_data.active_normals)),
    "normals of something else": ("misfit_normals", with_normals(TERRAIN, (1, 0, 0))),
    "coincident opposite faces": ("unlit_points", mesh_of(SQUARE, (0, 1, 2), (0, 2, 1))),
    "faces without an area": ("unlit_points", mesh_of([*SQUARE, (2, 2, 0)], (0, 1, 2, 3), (0, 2, 4))),
    "a face without an area": ("degenerate_faces", mesh_of(SQUARE, (0, 1, 2, 3), (0, 2, 2))),
    "one behind a line": (
        "degenerate_faces",
        pv.PolyData(SQUARE, faces=[4, 0, 1, 2, 3, 3, 0, 2, 2], lines=[2, 0, 1], verts=[1, 0]),
    ),
    "a face twice": ("duplicate_faces", mesh_of(SQUARE, (0, 1, 2, 3), (1, 2, 3, 0))),
    "a strip twice": ("duplicate_faces", pv.PolyData(SQUARE, faces=[3, 0, 1, 3], strips=[4, 0, 1, 3, 2])),
    "a turned neighbour": ("inconsistent_edges", mesh_of(ROOF, (0, 2, 1), (0, 2, 3))),
    "turned cells": ("inconsistent_edges", flipped_faces(BOWL, *range(30))),
    "turned cells that are not the first": ("inconsistent_edges", flipped_faces(BOWL, *range(70, 100))),
    "turned triangles of a ball": ("inconsistent_edges", flipped_faces(BALL, *range(500))),
    "thin letters": ("inconsistent_edges", pv.Text3D("x", depth=0.05)),
    "an isosurface": ("inside_out_faces", isosurface()),
    "a ball of strips": ("inside_out_faces", bare(BALL.flip_faces().strip())),
    "one ball of two": ("inside_out_faces", pv.merge([BALL, BALL.flip_faces().translate((3, 0, 0))])),
    "inverted tetrahedra": ("inside_out_faces", BEAM),
    "normals and faces inwards": ("inside_out_faces", pv.ParametricEllipsoid()),
    "a terrain": ("downward_faces", TERRAIN),
    "a terrain with normals": ("downward_faces", with_normals(PLANE.flip_faces(), (0, 0, -1))),
}


@pytest.mark.parametrize(("name", "mesh"), FAULTS.values(), ids=FAULTS)
def test_the_remedy_works_when_it_is_pasted(name, mesh):
    (finding,) = (each for each in diagnose(mesh).findings if each.name == name)
    assert finding.code
    assert all(len(line) <= 74 for line in finding.code)
    assert finding.remedy.endswith((":", "from within."))
    space = {"mesh": mesh.copy()}
    exec("\n".join(finding.code), space)
    after = diagnose(space["mesh"])
    assert not len(getattr(after, name))
    assert after.ok
    assert after.n_faces
    if name == "inconsistent_edges":  # most faces keep their orientation
        assert not len(after.downward_faces)


@pytest.mark.parametrize("mesh", [moved(SPHERE, stretched), moved(HILLS, stretched), moved(HILLS, sheared),
                                  SPHERE.flip_faces(), moved(SPHERE, sheared)])  # fmt: skip
def test_normals_that_no_longer_fit_spoil_and_say_by_how_much(mesh):
    found = diagnose(mesh)
    finding = found.findings[0]
    assert not found.ok
    assert (finding.name, finding.spoils) == ("misfit_normals", True)
    stored, true = np.asarray(mesh.point_data.active_normals, float), mesh.phong.normals("angle")
    angles = np.degrees(np.arccos(np.clip(np.einsum("ij,ij->i", stored, true), -1, 1)))
    areas = np.zeros(mesh.n_points)
    np.add.at(areas, mesh.regular_faces, np.repeat(mesh.compute_cell_sizes()["Area"][:, None] / 3, 3, axis=1))
    np.testing.assert_allclose(found.normals_fit.mean, np.average(angles, weights=areas), rtol=1e-4)
    np.testing.assert_allclose(found.normals_fit.worst, angles.max(), rtol=1e-4)
    np.testing.assert_allclose(found.normals_fit.beyond_60, areas[angles > BEYOND].sum() / areas.sum(), rtol=1e-4)
    assert found.misfit_normals.tolist() == np.flatnonzero(angles > MISFIT).tolist()
    assert f"{found.normals_fit.mean:.0f}° off" in finding.meaning
    assert found.to_dict()["normals_fit"] == found.normals_fit._asdict()


FITTING = [
    pv.Sphere, pv.Cube, pv.Cylinder, pv.Plane, pv.Capsule, pv.Tube, pv.ParametricTorus, pv.ParametricKlein,
    pv.ParametricMobius, pv.Superquadric, examples.load_random_hills, lambda: SPHERE.scale((1, 1, 10)),
    lambda: examples.load_airplane().compute_normals(), lambda: examples.load_ant().compute_normals(),
    lambda: pv.Text3D("pvphong").compute_normals(), lambda: examples.load_nut().compute_normals().smooth(n_iter=50),
]  # fmt: skip


@pytest.mark.parametrize("make", FITTING)
def test_normals_that_fit_are_left_alone(make):
    found = diagnose(make())
    assert found.normals_fit.mean < 0.5 * MISFIT
    assert not any(finding.name == "misfit_normals" and finding.spoils for finding in found.findings)


ORDINARY = [
    lambda: pv.Wavelet().contour(), lambda: pv.Text3D("x"), lambda: pv.Text3D("pvphong"),
    lambda: pv.Wavelet().threshold(100), lambda: SPHERE.clip("x"), lambda: BALL.clip_closed_surface(),
    lambda: BALL.decimate(0.5), lambda: HILLS.warp_by_scalar(), lambda: examples.load_uniform().contour(),
    examples.load_globe, lambda: pv.ParametricSuperEllipsoid(),
]  # fmt: skip


@pytest.mark.parametrize("make", ORDINARY)
def test_ordinary_surfaces_are_ok(make):
    assert diagnose(make()).ok


def test_slivers_of_an_isosurface_are_notes_that_say_to_leave_them():
    found = diagnose(pv.Wavelet().contour())
    finding = next(each for each in found.findings if each.name == "far_faces")
    assert 0 < finding.share < 1e-4
    assert not finding.spoils
    assert finding.remedy.startswith("They cover little and can stay.")
    assert f"{finding.count} faces (" in finding.sentence


def test_the_largest_share_comes_first():
    found = diagnose(pv.merge([BALL.flip_faces(), pv.Wavelet().contour().scale(0.001)]))
    assert [each.spoils for each in found.findings] == sorted([each.spoils for each in found.findings], reverse=True)
    for spoils in (True, False):
        shares = [each.share for each in found.findings if each.spoils is spoils]
        assert shares == sorted(shares, reverse=True)
    assert found.findings[0].name == "inside_out_faces"
    assert found.findings[0].share > 0.99


def shares_of_turned(mesh):
    return [each.share for each in diagnose(mesh).findings if each.name == "inconsistent_edges"]


@pytest.mark.parametrize("count", [1, 5, 20, 49])
def test_the_share_of_turned_faces_is_theirs(count):
    np.testing.assert_allclose(shares_of_turned(flipped_faces(PLANE, *range(count))), count / 100, rtol=1e-6)
    np.testing.assert_allclose(shares_of_turned(flipped_faces(PLANE, *range(count, 100))), count / 100, rtol=1e-6)
    assert [each.spoils for each in diagnose(flipped_faces(PLANE, *range(count))).findings][-1:] == [count > 12]


def test_of_a_closed_part_those_that_look_inwards_are_turned_also_where_they_are_most():
    few, most = (flipped_faces(BALL, *range(*ends)) for ends in ((0, 600), (600, 1680)))
    np.testing.assert_allclose(sum(shares_of_turned(few) + shares_of_turned(most)), 1.0, rtol=1e-6)
    areas = BALL.compute_cell_sizes()["Area"]
    np.testing.assert_allclose(shares_of_turned(few), areas[:600].sum() / areas.sum(), rtol=1e-5)


def test_a_surface_with_one_side_is_told_to_light_both():
    (finding,) = (each for each in diagnose(bare(pv.ParametricBoy())).findings if each.name == "inconsistent_edges")
    assert not finding.code
    assert "LightModel(two_sided=True)" in finding.remedy


def test_a_terrain_made_upside_down_is_noted_and_one_that_is_not_is_not():
    upside_down, right = diagnose(TERRAIN), diagnose(grid(X.T, Y.T, np.sin(np.hypot(X, Y)).T))
    assert [finding.name for finding in upside_down.findings] == ["downward_faces"]
    assert len(upside_down.downward_faces) == upside_down.n_faces
    assert upside_down.ok
    assert not right.findings


def test_stored_normals_that_look_outwards_make_up_for_faces_that_look_inwards():
    found = diagnose(SPHERE.flip_faces())
    (finding,) = (each for each in found.findings if each.name == "inside_out_faces")
    assert not finding.spoils
    assert "the stored normals point outwards and are used" in finding.meaning
    (finding,) = (each for each in diagnose(pv.ParametricEllipsoid()).findings if each.name == "inside_out_faces")
    assert finding.spoils
