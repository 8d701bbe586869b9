"""The diagnosis: each kind of fault by itself, real meshes, and independent counts on random ones."""

import dataclasses
import io
from collections import Counter, defaultdict
from fractions import Fraction

import numpy as np
import pytest
import pyvista as pv
from pyvista import examples
from rich.console import Console

from pvphong.geometry.normals import polygon_normals
from pvphong.meshes.surfaces import polygons, surface
from pvphong.studies.diagnose.diagnosis import Diagnosis, diagnose
from pvphong.studies.diagnose.kinds import FLAGS, KINDS

SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
ROOF = SQUARE + np.array([(0, 0, 0), (0, 0, 1), (0, 0, 0), (0, 0, 2)])  # not flat: opposite normals do not cancel


def mesh_of(points, *faces):
    connectivity = [index for face in faces for index in face]
    offsets = np.cumsum([0, *(len(face) for face in faces)])
    mesh = pv.PolyData()
    mesh.points = np.asarray(points)
    mesh.SetPolys(pv.CellArray.from_arrays(offsets, np.array(connectivity, dtype=np.int64), deep=True))
    return mesh


def faults(diagnosis):
    """What was found, as a dictionary of lists."""
    return {finding.name: np.asarray(getattr(diagnosis, finding.name)).tolist() for finding in diagnosis.findings}


def tetrahedron():
    return mesh_of([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], (0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))


# one fault at a time


def test_a_sound_mesh_is_ok():
    found = diagnose(tetrahedron())
    assert faults(found) == {}
    assert found.ok
    assert (found.n_points, found.n_faces, found.stored_normals, found.offset) == (4, 4, False, None)


@pytest.mark.parametrize(
    ("mesh", "expected", "ok"),
    [
        (mesh_of(SQUARE, (0, 1, 2), (0, 2, 9), (0, -1, 3)), {"invalid_cells": [1, 2], "unused_points": [3]}, False),
        (mesh_of(SQUARE, (0, 1, 2, 3), (0, 2, 2)), {"degenerate_faces": [1]}, False),
        (mesh_of(SQUARE, (0, 1, 2, 3), (0, 2)), {"degenerate_faces": [1]}, False),
        (mesh_of([*SQUARE, (2, 2, 0)], (0, 1, 2, 3), (0, 2, 4)), {"degenerate_faces": [1], "unlit_points": [4]}, False),
        (
            mesh_of([*SQUARE, (1, 1, 0), (0, 1, 1)], (0, 1, 2, 3), (2, 4, 5)),
            {"degenerate_faces": [1], "duplicate_points": [4], "unlit_points": [4, 5]},
            False,
        ),
        (mesh_of(SQUARE, (0, 1, 2), (0, 2, 1)), {"unlit_points": [0, 1, 2], "unused_points": [3]}, False),
        (mesh_of([*SQUARE[:3], (0, np.nan, 0)], (0, 1, 2), (0, 2, 3)), {"non_finite_points": [3]}, False),
        (mesh_of([*SQUARE[:3], (0, np.inf, 0)], (0, 1, 2), (0, 2, 3)), {"non_finite_points": [3]}, False),
        (mesh_of(SQUARE, (0, 1, 2), (0, 3, 2)), {"inconsistent_edges": [[0, 2]], "unlit_points": [0, 2]}, False),
        (mesh_of([*SQUARE, (0, 0, 1)], (0, 1, 2), (0, 2, 3), (2, 0, 4)), {"non_manifold_edges": [[0, 2]]}, True),
        (
            mesh_of(SQUARE, (0, 1, 2), (0, 2, 3), (2, 0, 1), (1, 2, 0)),
            {"duplicate_faces": [2, 3], "non_manifold_edges": [[0, 1], [0, 2], [1, 2]]},
            False,
        ),
        (mesh_of(SQUARE, (0, 1, 2, 3), (1, 2, 3, 0)), {"duplicate_faces": [1]}, False),
        (mesh_of(ROOF, (0, 1, 2, 3), (0, 1, 3, 2)), {"inconsistent_edges": [[0, 1]]}, False),
        (mesh_of([*SQUARE, *SQUARE[1:3]], (0, 1, 2, 3)), {"duplicate_points": [4, 5], "unused_points": [4, 5]}, True),
        (mesh_of([*SQUARE, (7, 7, 7)], (0, 1, 2, 3)), {"unused_points": [4]}, True),
        (mesh_of(SQUARE * (1, 1e-15, 1), (0, 1, 2, 3)), {"thin_faces": [0]}, True),
        (mesh_of(1e16 + SQUARE * 8, (0, 1, 2, 3)), {"far_faces": [0]}, False),
        (pv.PolyData(SQUARE), {"nothing_to_light": True}, False),
        (pv.PolyData(), {"nothing_to_light": True}, False),
        (pv.Line(), {"nothing_to_light": True}, False),
        (pv.PolyData(SQUARE, strips=[2, 0, 1]), {"nothing_to_light": True}, False),
        (pv.ImageData(dimensions=(3, 1, 1)), {"nothing_to_light": True}, False),
        (pv.UnstructuredGrid(), {"nothing_to_light": True}, False),
        (pv.PointSet(SQUARE), {"nothing_to_light": True}, False),
    ],
)
def test_each_fault_is_found_and_nothing_else(mesh, expected, ok):
    found = diagnose(mesh)
    assert faults(found) == expected
    assert found.ok is ok


def test_a_collapsed_quad_is_degenerate_but_its_edges_count():
    mesh = mesh_of(ROOF, (0, 1, 2, 2), (0, 3, 2))
    assert faults(diagnose(mesh)) == {"degenerate_faces": [0], "inconsistent_edges": [[0, 2]]}


def test_a_face_folded_onto_itself_says_nothing_about_its_neighbours():
    mesh = mesh_of(SQUARE, (0, 1, 2), (0, 2, 3), (0, 2, 0))
    assert faults(diagnose(mesh)) == {"degenerate_faces": [2]}


def test_stored_normals_are_looked_at():
    mesh = tetrahedron()
    mesh.point_data.active_normals = np.array([(0, 0, 0), (1, np.nan, 0), (0, 3, 0), (0, 0, -np.inf)])
    found = diagnose(mesh)
    assert faults(found) == {"zero_normals": [0], "non_finite_normals": [1, 3]}
    assert found.stored_normals
    assert not found.ok


def test_normals_on_the_back_of_the_faces_are_noted():
    mesh = tetrahedron()
    mesh.point_data.active_normals = np.array([(1, 1, 1), (1, 0, 0), (0, -1, 0), (0, 0, 1e200)], dtype=float)
    found = diagnose(mesh)
    assert faults(found) == {"opposed_normals": [0, 2]}
    assert found.ok


def test_cancelling_faces_do_no_harm_where_normals_are_stored():
    mesh = mesh_of(SQUARE, (0, 1, 2, 3), (3, 2, 1, 0))
    assert not diagnose(mesh).ok
    mesh.point_data.active_normals = np.tile([0.0, 0, 1], (4, 1))
    found = diagnose(mesh)
    assert faults(found) == {"unlit_points": [0, 1, 2, 3]}
    assert found.ok


def test_a_cloud_with_normals_is_ok():
    cloud = pv.PolyData(SQUARE)
    cloud.point_data.active_normals = np.tile([0.0, 0, 1], (4, 1))
    found = diagnose(cloud)
    assert found.ok
    assert faults(found) == {}
    bare = pv.PointSet(SQUARE)
    bare.point_data.active_normals = np.tile([0.0, 0, 1], (4, 1))
    assert diagnose(bare).ok


def test_strips_lines_and_vertices_are_taken_for_what_they_are():
    stripped = pv.Sphere().strip()
    found = diagnose(stripped)
    assert stripped.n_strips > 0
    assert (found.n_faces, faults(found)) == (1680, {})
    mesh = mesh_of(SQUARE, (0, 1, 2, 3))
    mesh.SetLines(pv.CellArray.from_arrays([0, 2], [0, 99], deep=True))
    assert faults(diagnose(mesh)) == {"invalid_cells": [0]}  # the line comes before the face


@pytest.mark.parametrize("dtype", [np.int32, np.float32, np.float64])
def test_points_of_any_type_are_read(dtype):
    assert diagnose(mesh_of((SQUARE * 8).astype(dtype), (0, 1, 2, 3))).ok


# the matrix

TURN = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
TURN = TURN * np.sign(np.linalg.det(TURN))


def model(linear, w=1.0):
    matrix = np.eye(4)
    matrix[:3, :3] = linear
    matrix[:3, 3] = 3, 1, 4
    matrix[3, 3] = w
    return matrix


@pytest.mark.parametrize(
    ("matrix", "expected"),
    [
        (np.eye(4), set()),
        (model(TURN), set()),
        (model(np.diag([1e-150, 1, 1e150])), set()),
        (model(np.diag([1, 1e-30, 1e-60])), set()),
        (model(-TURN), {"mirrored_matrix"}),
        (model(TURN, w=-2), {"mirrored_matrix"}),
        (model(-TURN, w=-2), set()),
        (model(TURN @ np.diag([1, 1e-9, -1]) @ TURN), {"mirrored_matrix"}),
        (model(np.diag([1, 1, 0])), {"singular_matrix"}),
        (model(np.diag([1, 0, 0])), {"singular_matrix"}),
        (model(np.zeros((3, 3))), {"singular_matrix"}),
        (model(TURN @ np.diag([1, 1, 0]) @ TURN), {"nearly_singular_matrix"}),
        (model(TURN @ np.diag([1e-200, 1e-200, 0]) @ TURN), {"nearly_singular_matrix"}),
        (model(TURN @ np.diag([1, 1e-10, 1e-20]) @ TURN), {"nearly_singular_matrix"}),
        (model([[1, 2.0**26, 0], [2.0**26, 2.0**52 + 1, 0], [0, 0, 1]]), {"nearly_singular_matrix"}),
        (model(np.outer([1, 2, 3], [3, 1, 4])), {"singular_matrix"}),
    ],
)
def test_the_matrix_is_looked_at(matrix, expected):
    found = diagnose(tetrahedron(), matrix=matrix)
    assert set(faults(found)) == expected
    assert found.ok is ("singular_matrix" not in expected)


def test_a_vtk_matrix_will_do():
    matrix = pv.vtkmatrix_from_array(np.diag([1.0, 1, -1, 1]))
    assert diagnose(tetrahedron(), matrix=matrix).mirrored_matrix


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.full((4, 4), np.nan), "matrix must be a 4x4 matrix of finite numbers"),
        (np.eye(3), "matrix must be a 4x4 matrix of real numbers; got an array of shape"),
        (np.ones((4, 4)), "matrix must be an affine 4x4 matrix"),
    ],
)
def test_what_is_no_model_matrix_is_refused(matrix, message):
    with pytest.raises(ValueError, match=message):
        diagnose(tetrahedron(), matrix=matrix)


@pytest.mark.parametrize("mesh", [None, pv.MultiBlock(), pv.Table(), SQUARE])
def test_what_is_no_dataset_is_refused(mesh):
    with pytest.raises(ValueError, match=r"mesh must be a pyvista.DataSet; got .*of a MultiBlock diagnose each block"):
        diagnose(mesh)


# real meshes: the counts were read off each file once, and agree with what VTK and brute force say below


@pytest.mark.parametrize(
    ("load", "n_faces", "expected"),
    [
        (examples.load_airplane, 2452, {"non_manifold_edges": [[1002, 1003]]}),
        (examples.load_ant, 912, {}),
        (examples.load_nut, 1046, {}),
        (examples.load_hexbeam, 88, {}),
        (examples.load_tetbeam, 176, {}),
        (examples.load_uniform, 486, {}),
        (examples.load_random_hills, 19602, {}),
    ],
)
def test_bundled_meshes_are_ok(load, n_faces, expected):
    found = diagnose(load())
    assert found.ok
    assert (found.n_faces, faults(found)) == (n_faces, expected)


def test_the_globe_has_collapsed_faces_at_its_poles():
    globe = examples.load_globe()
    found = diagnose(globe)
    assert {finding.name for finding in found.findings} == {"unlit_points", "degenerate_faces", "thin_faces"}
    assert not found.ok
    blamed = polygons_of(globe, [*found.degenerate_faces, *found.thin_faces])
    polar = np.abs(globe.points[:, 2]) > 0.999 * np.abs(globe.points[:, 2]).max()
    assert all(polar[face].sum() >= 2 for face in blamed)


def test_text_has_sides_that_face_inwards():
    text = pv.Text3D("ab")
    found = diagnose(text)
    assert len(found.inconsistent_edges) > 0
    cured = text.compute_normals(consistent_normals=True, auto_orient_normals=True, split_vertices=False)
    assert len(diagnose(cured).inconsistent_edges) == 0


def polygons_of(mesh, numbers):
    connectivity, offsets = polygons(surface(mesh))
    return [connectivity[offsets[number] : offsets[number + 1]] for number in numbers]


@pytest.mark.parametrize("load", [examples.load_airplane, examples.load_nut, pv.ParametricMobius])
def test_non_manifold_edges_are_vtks(load):
    mesh = load()
    edges = mesh.extract_feature_edges(
        boundary_edges=False, feature_edges=False, manifold_edges=False, non_manifold_edges=True
    )
    assert len(diagnose(mesh).non_manifold_edges) == edges.n_lines


# against brute force


def by_brute_force(points, faces):
    """The faults of small meshes, one face and one edge after the other, areas in fractions."""
    exact = [[Fraction(float(x)) for x in point] for point in points]
    degenerate, duplicate, edges, once, before = [], [], defaultdict(Counter), defaultdict(Counter), set()
    for number, face in enumerate(faces):
        area = [Fraction(0)] * 3
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            for axis in range(3):
                one, two = (axis + 1) % 3, (axis + 2) % 3
                area[axis] += exact[a][one] * exact[b][two] - exact[a][two] * exact[b][one]
        repeated = len(set(face)) < len(face)
        if repeated or not any(area):
            degenerate.append(number)
        elif tuple(face) in before:
            duplicate.append(number)
        before |= {tuple(face[turn:] + face[:turn]) for turn in range(len(face))}
        if not (repeated and not any(area)):
            for a, b in zip(face, face[1:] + face[:1], strict=True):
                if a != b:
                    edges[min(a, b), max(a, b)][a < b] += 1
                    once[min(a, b), max(a, b)][a < b] += number not in duplicate
    used = {index for face in faces for index in face}
    places = [tuple(point) for point in points]
    return {
        "degenerate_faces": degenerate,
        "duplicate_faces": duplicate,
        "non_manifold_edges": sorted(list(edge) for edge, sides in edges.items() if sides.total() > 2),
        "inconsistent_edges": sorted(
            list(edge) for edge, sides in once.items() if 2 in sides.values() and sides.total() == 2
        ),
        "duplicate_points": [index for index, place in enumerate(places) if place in places[:index]],
        "unused_points": [index for index in range(len(points)) if index not in used],
    }


@pytest.mark.parametrize("seed", range(40))
def test_random_soups_agree_with_brute_force(seed):
    rng = np.random.default_rng(seed)
    points = rng.integers(-2, 3, (rng.integers(4, 12), 3)).astype(float)  # small integers: areas are exact
    faces = [rng.integers(0, len(points), rng.integers(3, 6)).tolist() for _ in range(rng.integers(1, 15))]
    faces += [np.roll(faces[number], 1).tolist() for number in rng.integers(0, len(faces), 3)]
    found = diagnose(mesh_of(points, *faces))
    expected = by_brute_force(points, faces)
    assert {name: getattr(found, name).tolist() for name in expected} == expected


@pytest.mark.parametrize("offset", [0, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8])
def test_normals_are_fine_where_no_face_is_blamed(offset):
    airplane = examples.load_airplane()
    connectivity, offsets = polygons(airplane)
    true = np.asarray(airplane.points, dtype=float)
    stored = (true + offset).astype(np.float32)
    found = diagnose(mesh_of(stored, *polygons_of(airplane, range(airplane.n_faces))))
    wanted, got = polygon_normals(true, connectivity, offsets), polygon_normals(stored, connectivity, offsets)
    angle = np.linalg.norm(wanted - got, axis=1)
    blamed = np.zeros(airplane.n_faces, dtype=bool)
    for faces in (found.far_faces, found.thin_faces, found.degenerate_faces):
        blamed[faces] = True
    assert (angle[~blamed] <= 2 / 255).all()  # 1/255 by its estimate: both ends of a height are rounded
    assert blamed.any() == (offset >= 1e4)
    assert offset < 1e8 or blamed.all()
    assert found.ok is (not blamed.any())


@pytest.mark.parametrize("offset", [(1e6, 0, 0), (1e7, -2e8, 5e7)])
def test_the_offset_cures_faces_far_from_the_origin(offset):
    airplane = examples.load_airplane()
    faces = polygons_of(airplane, range(airplane.n_faces))
    world = np.asarray(airplane.points, dtype=float) + offset
    found = diagnose(mesh_of(world.astype(np.float32), *faces))
    assert len(found.far_faces) > 0
    assert "Subtract an offset" in str(found)
    assert "({:.17g}, {:.17g}, {:.17g})".format(*found.offset) in str(found)
    cured = diagnose(mesh_of((world - found.offset).astype(np.float32), *faces))
    assert cured.ok
    assert cured.offset is None


def test_a_part_far_from_the_others_is_far_and_the_others_are_not_thin():
    both = pv.merge([pv.Sphere(), pv.Sphere(center=(1e5, 0, 0))], merge_points=False)
    both.clear_data()
    found = diagnose(both)
    assert found.far_faces.tolist() == list(range(1680, 3360))
    assert len(found.thin_faces) == 0
    assert found.offset is None  # none brings both parts to the origin
    assert "of parts far apart, each its own" in str(found)


def test_with_stored_normals_no_face_spoils_anything():
    sphere = pv.Sphere()
    faces = sphere.regular_faces.copy()
    faces[5], faces[9] = faces[5][::-1], faces[9][[0, 0, 1]]
    turned = pv.PolyData.from_regular_faces(sphere.points + np.float32(1e5), faces)
    bare, turned.point_data.active_normals = turned.copy(), sphere.point_normals
    for mesh, ok in ((bare, False), (turned, True)):
        found = diagnose(mesh)
        assert found.ok is ok
        assert len(found.inconsistent_edges) > 0
        assert len(found.far_faces) > 0
        assert found.degenerate_faces.tolist() == [9]


def test_a_mesh_that_collapsed_far_away_is_blamed_on_its_place():
    tiny = tetrahedron()
    found = diagnose(mesh_of(np.full((4, 3), 1e8, dtype=np.float32) + tiny.points.astype(np.float32), *FACES))
    assert found.far_faces.tolist() == [0, 1, 2, 3]
    assert found.offset == (1e8, 1e8, 1e8)
    here = diagnose(mesh_of(np.zeros((4, 3)), *FACES))
    assert here.far_faces.tolist() == []


FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))


@pytest.mark.parametrize("scale", [1e-320, 1e-200, 1e-30, 1e30, 1e200, 1e307])
def test_size_alone_is_no_fault(scale):
    assert faults(diagnose(mesh_of(tetrahedron().points * scale, *FACES))) == {}


def test_the_mesh_stays_as_it_is():
    mesh = examples.load_airplane()
    before = mesh.copy()
    diagnose(mesh, matrix=np.eye(4)).to_mesh()
    assert mesh == before


# the report


def test_the_value_is_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        diagnose(tetrahedron()).n_points = 3


def test_the_text_names_every_finding_and_its_remedy():
    mesh = mesh_of([*ROOF, *ROOF], (0, 1, 2), (0, 3, 2), (4, 5, 9))
    found = diagnose(mesh, matrix=np.diag([1, 1, -1, 1]))
    text = str(found)
    assert text.splitlines()[0] == "Diagnosis of 8 points and 3 faces: 2 kinds of fault, 3 notes"
    assert repr(found) == f"<{text.splitlines()[0]}>"
    assert "  spoils: 1 cell with an index that no point has" in text
    assert "  spoils: 1 edge whose two faces have opposite fronts" in text
    assert "(0, 2)" in text
    assert "  note: 4 points in the place of an earlier one" in text
    assert "    4, 5, 6, 7\n" in text
    assert "  note: the matrix mirrors" in text
    for finding in found.findings:
        assert finding.remedy in text
    assert str(diagnose(tetrahedron())) == "Diagnosis of 4 points and 4 faces: ok"


def test_long_lists_are_cut_short():
    found = diagnose(pv.PolyData(np.zeros((20, 3))).glyph(geom=pv.Sphere(), scale=False, orient=False))
    duplicate = next(finding for finding in found.findings if finding.name == "duplicate_points")
    assert duplicate.count == 19 * 842
    assert duplicate.first == (842, 843, 844, 845, 846, 847)
    assert "842, 843, 844, 845, 846, 847, …" in str(found)


def test_what_spoils_comes_first():
    mesh = mesh_of([*ROOF, *ROOF[1:3]], (0, 1, 2), (0, 3, 2))
    spoils = [finding.spoils for finding in diagnose(mesh).findings]
    assert spoils == [True, False, False]


@pytest.mark.parametrize("width", [60, 80, 120])
def test_the_table_says_everything_at_any_width(width):
    console = Console(width=width, record=True, file=io.StringIO())
    mesh = examples.load_globe()
    mesh.point_data.active_normals = np.zeros((mesh.n_points, 3))
    found = diagnose(mesh, matrix=np.diag([1, -1, 1, 1]))
    console.print(found.table())
    lines = console.export_text().splitlines()
    assert max(map(len, lines)) <= width
    names = max(len(finding.name) for finding in found.findings)
    said = "".join("".join(line[names + 3 :].split()) for line in lines)
    assert len(found.findings) > 3
    for finding in found.findings:
        assert any(line.split()[:1] == [finding.name] for line in lines)
        for text in (f"{finding.count} {finding.where}" * bool(finding.first), finding.meaning, finding.remedy):
            assert text.replace(" ", "") in said


def test_every_kind_has_its_field_and_its_bit():
    fields = {field.name for field in dataclasses.fields(Diagnosis)}
    assert set(KINDS) <= fields
    assert set(KINDS) | {"n_points", "n_faces", "stored_normals", "offset", "_points", "_faces"} == fields
    assert sorted(FLAGS.values()) == [1 << place for place in range(len(KINDS))]


def test_to_mesh_flags_points_and_faces():
    mesh = mesh_of([*ROOF, (9, 9, 9)], (0, 1, 2), (0, 77, 1), (0, 3, 2), (0, 2, 2))
    found = diagnose(mesh)
    shown = found.to_mesh()
    assert shown.n_points == 5
    assert shown.cell_data["face"].tolist() == [0, 2, 3]
    assert shown.cell_data["diagnosis"].tolist() == [0, 0, FLAGS["degenerate_faces"]]
    split, unused = FLAGS["inconsistent_edges"], FLAGS["unused_points"]
    assert shown.point_data["diagnosis"].tolist() == [split, 0, split, 0, unused]
    assert shown.cell_data["severity"].tolist() == [0, 0, 2]
    assert shown.point_data["severity"].tolist() == [2, 0, 2, 0, 1]
    assert shown.active_scalars_name == "severity"
    assert Diagnosis.FLAGS is FLAGS
    np.testing.assert_array_equal(shown.points, mesh.points)


@pytest.mark.parametrize("mesh", [pv.PolyData(), pv.PolyData(SQUARE), pv.Line(), pv.ImageData(dimensions=(3, 1, 1))])
def test_to_mesh_of_what_has_no_faces_shows_the_points(mesh):
    shown = diagnose(mesh).to_mesh()
    assert shown.n_points == mesh.n_points
    assert shown.n_faces == 0
    assert shown.point_data["diagnosis"].tolist() == [0] * mesh.n_points
    assert shown.point_data["severity"].tolist() == [0] * mesh.n_points


def test_to_mesh_can_be_drawn_with_a_nan_and_an_invalid_face():
    sphere = pv.Sphere()
    points = np.asarray(sphere.points).copy()
    points[100] = np.nan
    faces = sphere.regular_faces.copy()
    faces[7, 1] = 10**9
    shown = diagnose(mesh_of(points, *faces.tolist())).to_mesh()
    plotter = pv.Plotter(off_screen=True, window_size=(60, 60))
    plotter.add_mesh(shown)
    picture = plotter.screenshot(return_img=True)
    plotter.close()
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 1


def test_a_volume_is_diagnosed_by_its_surface():
    beam = examples.load_hexbeam()
    beam.points[0] = np.nan
    found = diagnose(beam)
    assert found.n_points == surface(beam).n_points < beam.n_points
    origins = surface(beam)["vtkOriginalPointIds"][found.non_finite_points]
    assert origins.tolist() == [0]


def test_a_volume_with_an_index_out_of_range_has_no_surface():
    grid = pv.UnstructuredGrid(
        np.array([4, 0, 1, 2, 3, 4, 0, 1, 2, 99]), np.array([10, 10]), tetrahedron().points.astype(float)
    )
    found = diagnose(grid)
    assert faults(found) == {"invalid_cells": [1]}
    assert (found.n_points, found.n_faces) == (4, 0)
