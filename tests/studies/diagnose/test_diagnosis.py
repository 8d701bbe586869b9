"""Diagnosis: each kind of fault alone, real meshes, and independent counts on random meshes."""

import io
from collections import Counter, defaultdict

import numpy as np
import pytest
import pyvista as pv
from pyvista import examples
from rich.console import Console
from soups import faces_of, mesh_of, state
from stability import exact_normals as exact

from pvphong.geometry.normals import polygon_normals
from pvphong.meshes.surfaces import polygons
from pvphong.studies.diagnose.diagnosis import FLAGS, Diagnosis, diagnose

SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
ROOF = SQUARE + np.array([(0, 0, 0), (0, 0, 1), (0, 0, 0), (0, 0, 2)])  # not flat: opposite normals do not cancel
CORNERS = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
SIDES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
TETRAHEDRON = mesh_of(CORNERS, *SIDES)
INSIDE_OUT = mesh_of(CORNERS, *(side[::-1] for side in SIDES))
NAN, INF = np.nan, np.inf


def faults(diagnosis):
    """Return the findings as a dictionary of lists."""
    return {finding.name: np.asarray(getattr(diagnosis, finding.name)).tolist() for finding in diagnosis.findings}


def with_normals(mesh, *normals):
    mesh = mesh.copy()
    mesh.point_data.active_normals = np.resize(np.array(normals, dtype=float), (mesh.n_points, 3))
    return mesh


Z = (0.0, 0.0, 1.0)
SOUND = [
    TETRAHEDRON,
    *[mesh_of(CORNERS * scale, *SIDES) for scale in (1e-320, 1e-200, 1e-30, 1e30, 1e200, 1e307)],  # of any size
    *[mesh_of((SQUARE * 8).astype(kind), (0, 1, 2, 3)) for kind in (np.int32, np.float32, np.float64)],
    *[with_normals(cloud, Z) for cloud in (pv.PolyData(SQUARE), pv.PointSet(SQUARE))],
    pv.Sphere().strip(),
]
SPOILING = [
    (mesh_of(SQUARE, (0, 1, 2), (0, 2, 9), (0, -1, 3)), {"invalid_cells": [1, 2], "unused_points": [3]}),
    (pv.PolyData(SQUARE, faces=[4, 0, 1, 2, 3], lines=[2, 0, 99]), {"invalid_cells": [0]}),  # the line is first
    (pv.UnstructuredGrid([4, 0, 1, 2, 3, 4, 0, 1, 2, 99], [10, 10], CORNERS), {"invalid_cells": [1]}),  # no surface
    # The edges of a collapsed quad count; those of a face folded onto itself do not.
    (mesh_of(ROOF, (0, 1, 2, 2), (0, 3, 2)), {"degenerate_faces": [0], "inconsistent_edges": [[0, 2]]}),
    (mesh_of(SQUARE, (0, 1, 2), (0, 2, 1)), {"unlit_points": [0, 1, 2], "unused_points": [3]}),
    (mesh_of([*ROOF, (-1, 2, 3)], (0, 1, 2), (2, 1, 0), (0, 3, 4)), {"unlit_points": [1, 2]}),
    (mesh_of([*SQUARE[:3], (0, NAN, 0)], (0, 1, 2), (0, 2, 3)), {"non_finite_points": [3]}),
    (mesh_of([*SQUARE[:3], (0, INF, 0)], (0, 1, 2), (0, 2, 3)), {"non_finite_points": [3]}),
    (mesh_of(np.full((3, 3), NAN), (0, 1, 2)), {"non_finite_points": [0, 1, 2]}),
    (mesh_of(SQUARE, (0, 1, 2), (0, 3, 2)), {"inconsistent_edges": [[0, 2]], "unlit_points": [0, 2]}),
    (mesh_of(ROOF, (0, 1, 2), (0, 3, 2)), {"inconsistent_edges": [[0, 2]]}),
    (mesh_of(SQUARE, (0, 1, 2, 3), (1, 2, 3, 0)), {"duplicate_faces": [1]}),
    (mesh_of(SQUARE, (0, 1, 2), (0, 2, 3), (2, 0, 1), (1, 2, 0)),
     {"duplicate_faces": [2, 3], "non_manifold_edges": [[0, 1], [0, 2], [1, 2]]}),
    (mesh_of(1e16 + SQUARE * 8, (0, 1, 2, 3)), {"far_faces": [0]}),
    # Faces without a height, or of coincident points, are far if other faces of the mesh would be.
    (mesh_of(1e16 + 8 * np.array([*SQUARE, (0.5, 0.5, 0), (1, 0, 0), (1, 0, 0)]), (0, 1, 2, 3), (0, 2, 4), (1, 5, 6)),
     {"far_faces": [0, 1, 2], "degenerate_faces": [1, 2], "duplicate_points": [5, 6], "unlit_points": [4, 5, 6]}),
    (with_normals(TETRAHEDRON, (0, 0, 0), (1, NAN, 0), (-1, 3, -1), (0, 0, -INF)),
     {"zero_normals": [0], "non_finite_normals": [1, 3]}),
    (with_normals(mesh_of(SQUARE, (0, 1, 2), (0, 3, 2)), Z),
     {"inconsistent_edges": [[0, 2]], "unlit_points": [0, 2], "misfit_normals": [3]}),
    (with_normals(INSIDE_OUT, Z), {"misfit_normals": [0, 1, 2, 3], "inside_out_faces": [0, 1, 2, 3]}),
    (with_normals(TETRAHEDRON, (1, 1, 1), (1, 0, 0), (0, -1, 0), (0, 0, 1e200)), {"misfit_normals": [0, 1, 2, 3]}),
    *[(mesh, {"nothing_to_light": True}) for mesh in (
        pv.PolyData(SQUARE), pv.PolyData(), pv.Line(), pv.PolyData(SQUARE, strips=[2, 0, 1]),
        pv.ImageData(dimensions=(3, 1, 1)), pv.UnstructuredGrid(), pv.PointSet(SQUARE))],
]  # fmt: skip
NOTED = [
    (mesh_of(SQUARE, (0, 1, 2, 3), (0, 2, 2)), {"degenerate_faces": [1]}),
    (mesh_of(SQUARE, (0, 1, 2, 3), (0, 2)), {"degenerate_faces": [1]}),
    (mesh_of([*SQUARE, (2, 2, 0)], (0, 1, 2, 3), (0, 2, 4)), {"degenerate_faces": [1], "unlit_points": [4]}),
    (mesh_of([*SQUARE, (1, 1, 0), (0, 1, 1)], (0, 1, 2, 3), (2, 4, 5)),
     {"degenerate_faces": [1], "duplicate_points": [4], "unlit_points": [4, 5]}),
    (mesh_of(SQUARE, (0, 1, 2), (0, 2, 3), (0, 2, 0)), {"degenerate_faces": [2]}),
    (mesh_of([*SQUARE, (0.5, 0.5, 0), (1, 0, 0), (1, 0, 0)], (0, 1, 2, 3), (0, 2, 4), (1, 5, 6)),
     {"degenerate_faces": [1, 2], "duplicate_points": [5, 6], "unlit_points": [4, 5, 6]}),
    (mesh_of([*SQUARE, (0, 0, 1)], (0, 1, 2), (0, 2, 3), (2, 0, 4)), {"non_manifold_edges": [[0, 2]]}),
    (mesh_of([*SQUARE, *SQUARE[1:3]], (0, 1, 2, 3)), {"duplicate_points": [4, 5], "unused_points": [4, 5]}),
    (mesh_of([*SQUARE, (7, 7, 7)], (0, 1, 2, 3)), {"unused_points": [4]}),
    (mesh_of(SQUARE * (1, 1e-15, 1), (0, 1, 2, 3)), {"thin_faces": [0]}),
    # With stored normals, no face spoils the lighting.
    (with_normals(mesh_of(SQUARE, (0, 1, 2, 3), (3, 2, 1, 0)), Z), {"unlit_points": [0, 1, 2, 3]}),
    (with_normals(mesh_of(SQUARE, (0, 1, 2, 3), (0, 2, 2)), Z), {"degenerate_faces": [1]}),
    (with_normals(mesh_of(SQUARE, (0, 1, 2, 3), (1, 2, 3, 0)), Z), {"duplicate_faces": [1]}),
    (with_normals(mesh_of(1e16 + SQUARE * 8, (0, 1, 2, 3)), Z), {"far_faces": [0]}),
]  # fmt: skip


@pytest.mark.parametrize(
    ("mesh", "expected", "ok"),
    [*[(mesh, {}, True) for mesh in SOUND], *[(*row, False) for row in SPOILING], *[(*row, True) for row in NOTED]],
)
def test_each_fault_is_found_and_nothing_else(mesh, expected, ok):
    before = state(mesh)[1:]
    found = diagnose(mesh, matrix=np.eye(4))
    assert faults(found) == expected
    assert found.ok is ok
    assert (str(found).endswith(": ok")) is (not expected)
    assert found.stored_normals is (mesh.point_data.active_normals is not None)
    flags = found.to_mesh().point_data["diagnosis"]
    assert (found.n_points, len(flags)) == (mesh.n_points, mesh.n_points)
    assert flags.any() == any(finding.where in ("points", "edges") for finding in found.findings)
    assert state(mesh)[1:] == before


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
        (model(-TURN, w=-2), set()),
        (model(-TURN), {"mirrored_matrix"}),
        (model(TURN, w=-2), {"mirrored_matrix"}),
        (pv.vtkmatrix_from_array(np.diag([1.0, 1, -1, 1])), {"mirrored_matrix"}),
        (model(TURN @ np.diag([1, 1e-9, -1]) @ TURN), {"mirrored_matrix"}),
        (model(np.diag([1, 1, 0])), {"singular_matrix"}),
        (model(np.diag([1, 0, 0])), {"singular_matrix"}),
        (model(np.zeros((3, 3))), {"singular_matrix"}),
        (model(np.outer([1, 2, 3], [3, 1, 4])), {"singular_matrix"}),
        (model(TURN @ np.diag([1, 1, 0]) @ TURN), {"nearly_singular_matrix"}),
        (model(TURN @ np.diag([1e-200, 1e-200, 0]) @ TURN), {"nearly_singular_matrix"}),
        (model(TURN @ np.diag([1, 1e-10, 1e-20]) @ TURN), {"nearly_singular_matrix"}),
        (model([[1, 2.0**26, 0], [2.0**26, 2.0**52 + 1, 0], [0, 0, 1]]), {"nearly_singular_matrix"}),
    ],
)
def test_the_matrix_is_looked_at(matrix, expected):
    found = diagnose(TETRAHEDRON, matrix=matrix)
    assert set(faults(found)) == expected
    assert found.ok is ("singular_matrix" not in expected)


NO_MESH = r"mesh must be a pyvista.DataSet; got .*diagnose each block of a MultiBlock"


@pytest.mark.parametrize(
    ("mesh", "matrix", "message"),
    [
        (TETRAHEDRON, np.full((4, 4), NAN), "matrix must be a 4x4 matrix of finite numbers"),
        (TETRAHEDRON, np.ones((4, 4)), "matrix must be an affine 4x4 matrix"),
        *[(mesh, None, NO_MESH) for mesh in (None, pv.MultiBlock(), pv.Table(), SQUARE)],
    ],
)
def test_what_is_no_dataset_or_no_model_matrix_is_refused(mesh, matrix, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        diagnose(mesh, matrix=matrix)


# --- real meshes: recorded counts, which agree with VTK and brute force below ---


@pytest.mark.parametrize(
    ("load", "n_faces", "expected"),
    [
        (examples.load_airplane, 2452, {"non_manifold_edges": [[1002, 1003]]}),
        (examples.load_ant, 912, {}),
        (examples.load_nut, 1046, {}),
        (examples.load_hexbeam, 88, {}),
        (examples.load_uniform, 486, {}),
        (examples.load_random_hills, 19602, {}),
        (lambda: pv.Sphere().strip(), 1680, {}),
    ],
)
def test_bundled_meshes_are_ok(load, n_faces, expected):
    found = diagnose(load())
    assert found.ok
    assert (found.n_faces, faults(found)) == (n_faces, expected)


def test_the_beam_of_tetrahedra_is_inside_out():
    """VTK also reports a negative volume for each of its cells."""
    beam = examples.load_tetbeam()
    assert (beam.compute_cell_sizes()["Volume"] < 0).all()
    assert faults(diagnose(beam)) == {"inside_out_faces": list(range(176))}


def test_the_globe_has_collapsed_faces_at_its_poles():
    globe = examples.load_globe()
    found = diagnose(globe)
    assert set(faults(found)) == {"unlit_points", "degenerate_faces", "thin_faces"}
    assert found.ok  # they have no area
    polar = np.abs(globe.points[:, 2]) > 0.999 * np.abs(globe.points[:, 2]).max()
    faces = faces_of(globe)
    assert all(polar[faces[number]].sum() >= 2 for number in [*found.degenerate_faces, *found.thin_faces])


def by_brute_force(points, faces):
    """Return the faults of a small mesh by a loop over faces and edges, with areas as fractions."""
    degenerate, duplicate, edges, once, before = [], [], defaultdict(Counter), defaultdict(Counter), set()
    for number, face in enumerate(faces):
        flat = not any(exact.area_vector(points[face]))
        repeated = len(set(face)) < len(face)
        if repeated or flat:
            degenerate.append(number)
        elif tuple(face) in before:
            duplicate.append(number)
        before |= {tuple(face[turn:] + face[:turn]) for turn in range(len(face))}
        if not (repeated and flat):
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
            list(edge) for edge, sides in once.items() if sorted(sides.values()) in ([2], [0, 2])
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


# --- far from the origin, row 21 of the catalogue of hard cases ---


@pytest.mark.parametrize("offset", [0, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, (1e6, 0, 0), (1e7, -2e8, 5e7)])
def test_normals_are_fine_where_no_face_is_blamed_and_where_one_is_an_offset_that_cures_is_told(offset):
    airplane = examples.load_airplane()
    mesh, faces, world = polygons(airplane), faces_of(airplane), np.asarray(airplane.points, dtype=float) + offset
    true, stored = polygon_normals(airplane.points, *mesh), world.astype(np.float32)
    found = diagnose(mesh_of(stored, *faces))
    error = np.linalg.norm(true - polygon_normals(stored, *mesh), axis=1)
    blamed = np.zeros(airplane.n_faces, dtype=bool)
    for numbers in (found.far_faces, found.thin_faces, found.degenerate_faces):
        blamed[numbers] = True
    assert (error[~blamed] <= 2 / 255).all()  # twice the estimate, 1/255: both ends of a height are rounded
    is_far = np.abs(offset).max() >= 1e4
    assert [blamed.any(), len(found.far_faces) > 0, found.offset is not None] == [is_far] * 3
    assert found.ok is not (np.abs(offset).max() >= 1e6)  # at smaller offsets it is 1/1000 of the surface
    assert np.abs(offset).max() < 1e8 or blamed.all()
    if is_far:  # the offset brings the middle to within a tenth of the mesh's size of the origin
        low, high = stored.min(axis=0), stored.max(axis=0)
        assert np.abs((low + high) / 2 - found.offset).max() <= 0.1 * (high - low).max()
        assert "Subtract an offset" in found.explain()
        assert "({:.17g}, {:.17g}, {:.17g})".format(*found.offset) in found.explain()
        moved = (world - found.offset).astype(np.float32)
        assert np.linalg.norm(polygon_normals(moved, *mesh) - true, axis=1).max() < 1e-4 < 2e-3 < error.max()
        assert diagnose(mesh_of(moved, *faces)).ok
    assert diagnose(mesh_of(world, *faces)).ok  # float64 is precise enough


def test_a_part_far_from_the_others_is_far_and_the_others_are_not_thin():
    both = pv.merge([pv.Sphere(), pv.Sphere(center=(1e5, 0, 0))], merge_points=False)
    both.clear_data()
    found = diagnose(both)
    assert found.far_faces.tolist() == list(range(1680, 3360))
    assert len(found.thin_faces) == 0
    assert found.offset is None  # no single offset brings both parts to the origin
    assert "a separate one for each of several distant parts" in " ".join(found.explain().split())


MANY_FAULTS = diagnose(mesh_of([*ROOF, *ROOF], (0, 1, 2), (0, 3, 2), (4, 5, 9)), matrix=np.diag([1, 1, -1, 1]))


def test_the_text_names_every_finding_and_its_remedy():
    text = MANY_FAULTS.explain()
    assert text.splitlines()[0] == "Diagnosis of 8 points and 3 faces: 2 kinds of fault, 3 notes"
    assert repr(MANY_FAULTS) == f"<{text.splitlines()[0]}>"
    assert [finding.spoils for finding in MANY_FAULTS.findings] == [True, True, False, False, False]  # faults first
    for line in (
        "  spoils: 1 cell with an index out of range",
        "  spoils: 1 edge (37 % of the surface) whose two faces have opposite fronts",
        "    (0, 2)\n",
        "  note: 4 points at the position of an earlier point",
        "    4, 5, 6, 7\n",
        "  note: the matrix mirrors",
    ):
        assert line in text
    words = " ".join(text.split())
    for finding in MANY_FAULTS.findings:
        assert " ".join(finding.remedy.split()) in words
        assert all(f"      {line}\n" in text for line in finding.code)
    assert str(diagnose(TETRAHEDRON)) == diagnose(TETRAHEDRON).explain() == "Diagnosis of 4 points and 4 faces: ok"


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


def test_to_mesh_flags_points_and_faces():
    mesh = mesh_of([*ROOF, (9, 9, 9)], (0, 1, 2), (0, 77, 1), (0, 3, 2), (0, 2, 2))
    found = diagnose(mesh)
    shown = found.to_mesh()
    assert shown.n_points == 5
    assert shown.cell_data["face"].tolist() == [0, 2, 3]
    assert shown.cell_data["diagnosis"].tolist() == [0, 0, FLAGS["degenerate_faces"]]
    split, unused = FLAGS["inconsistent_edges"], FLAGS["unused_points"]
    assert shown.point_data["diagnosis"].tolist() == [split, 0, split, 0, unused]
    assert shown.cell_data["severity"].tolist() == [0, 0, 1]
    assert shown.point_data["severity"].tolist() == [2, 0, 2, 0, 1]
    assert shown.active_scalars_name == "severity"
    assert Diagnosis.FLAGS is FLAGS
    np.testing.assert_array_equal(shown.points, mesh.points)
    flags = MANY_FAULTS.to_mesh().point_data["diagnosis"]  # points with several findings have the bits of all
    for finding in MANY_FAULTS.findings:
        if finding.where in ("points", "edges"):
            assert (flags[getattr(MANY_FAULTS, finding.name)] & FLAGS[finding.name]).all()


# --- closed parts that are inside out: by the sign of their volume; cavities and open parts are left alone ---


def bare(mesh):
    mesh.clear_data()
    return mesh


def ball(radius=1.0, center=(0.0, 0.0, 0.0), *, turned=False):
    mesh = bare(pv.Sphere(radius=radius, center=center, theta_resolution=8, phi_resolution=8))
    return mesh.flip_faces() if turned else mesh


CLOSED = [
    ball(),
    bare(pv.Cube()),
    bare(pv.ParametricTorus(u_res=12, v_res=12).clean()),
    bare(pv.Cylinder(resolution=5)),
]


@pytest.mark.parametrize("where", [0.0, 1e6])
@pytest.mark.parametrize("size", [1e-30, 1.0, 1e30])
@pytest.mark.parametrize("mesh", CLOSED, ids=["ball", "six squares that share no points", "torus", "wedge"])
def test_a_closed_surface_is_found_when_it_is_turned_and_only_then(mesh, size, where):
    mesh = mesh.copy()
    mesh.points = (mesh.points.astype(float) + where) * size
    right, wrong = mesh, mesh.flip_faces()
    if diagnose(right).inside_out_faces.size:  # the orientation that PyVista chooses is not tested here
        right, wrong = wrong, right
    assert not len(diagnose(right).inside_out_faces)
    assert len(diagnose(wrong).inside_out_faces) == mesh.n_cells
    assert not diagnose(wrong).ok


RING = bare(pv.ParametricTorus(ringradius=3, crosssectionradius=0.5, u_res=24, v_res=12).clean())
RING = RING.flip_faces() if diagnose(RING).inside_out_faces.size else RING
TURNED = ball(turned=True)


@pytest.mark.parametrize(
    ("parts", "wrong"),
    [
        ([TURNED.remove_cells([3])], []),
        ([bare(pv.Plane())], []),
        ([ball(), ball(center=(5, 0, 0), turned=True), ball(center=(9, 0, 0))], [1]),
        ([ball(2.0), TURNED], []),  # the wall of a cavity
        ([ball(2.0, turned=True), ball()], [0]),
        ([ball(2.0), ball()], []),
        ([RING, ball(0.2, turned=True)], [1]),  # in its box and its hole, but not inside it
        ([RING, ball(0.2, center=(3, 0, 0), turned=True)], []),
    ],
)
def test_of_parts_all_faces_are_found_or_none(parts, wrong):
    faces = diagnose(pv.merge(parts, merge_points=False)).inside_out_faces
    owner = np.repeat(np.arange(len(parts)), [part.n_cells for part in parts])
    assert faces.tolist() == np.flatnonzero(np.isin(owner, wrong)).tolist()


def test_points_without_faces_count_by_their_number():
    cloud = pv.PolyData(np.eye(4)[:, :3])
    cloud.point_data.active_normals = np.float32([(0, 0, 1), (0, 0, 1), (0, 0, 0), (0, 1, 0)])
    (finding,) = (each for each in diagnose(cloud).findings if each.name == "zero_normals")
    assert finding.share == 0.25


def test_a_face_that_comes_three_times_is_repeated_twice():
    points = np.float32([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)])
    faces = [(0, 1, 2), (1, 3, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)]
    assert diagnose(pv.PolyData.from_regular_faces(points, faces)).duplicate_faces.tolist() == [2, 3]


def test_a_diagnosis_keeps_its_faces_when_the_mesh_is_edited_in_place():
    mesh = pv.Sphere(theta_resolution=8, phi_resolution=8)
    found = mesh.phong.diagnose()
    before = found.to_mesh().regular_faces.copy()
    mesh.GetPolys().GetConnectivityArray().FillValue(0)
    np.testing.assert_array_equal(found.to_mesh().regular_faces, before)
