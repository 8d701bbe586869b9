"""Sharp edges: splitting of a cube and a prism, with known results."""

import numpy as np
import pytest
import pyvista as pv
from pyvista import examples
from soups import state

import pvphong as ph
from pvphong.meshes.surfaces import ORIGINAL_POINT, polygons, split_sharp_edges
from pvphong.studio.lit_mesh import LitMesh

SUN = ph.Scene([ph.DirectionalLight(direction=(-1.0, -2.0, -3.0))], ph.Viewer(position=(2.0, 3.0, 4.0)))
DULL = ph.Material(ambient=0.1)
TINT = np.linspace(0.0, 1.0, 24).reshape(8, 3)


def bare(mesh):
    mesh = mesh.clean()
    mesh.clear_data()
    return mesh


def cube():
    """Eight points and six squares, with arrays."""
    mesh = bare(pv.Cube())
    mesh["number"], mesh["tint"] = np.arange(8.0), TINT
    return mesh


def nut():
    """A prism with six sides and one point per corner."""
    return bare(pv.Cylinder(resolution=6, height=0.5, direction=(0, 0, 1)).triangulate())


# --- splitting ---


@pytest.mark.parametrize(
    ("angle", "count"), [(None, 8), ("auto", 24), (0, 24), (89.9, 24), (90.1, 8), (180, 8)], ids=str
)
def test_a_cubes_edges_are_sharp_below_90_degrees(angle, count):
    assert cube().phong.shade(SUN, DULL, feature_angle=angle).n_points == count
    ball = bare(pv.Sphere(theta_resolution=40, phi_resolution=40))
    assert split_sharp_edges(ball, "auto") == (ball, None)  # nothing sharp
    for none in ("sharp", -1, 181, np.nan, [30]):
        with pytest.raises(ValueError, match=r"^feature_angle must be "):
            cube().phong.shade(SUN, DULL, feature_angle=none)


@pytest.mark.parametrize(
    "mesh",
    [pv.Sphere(), pv.Plane(), pv.Cylinder(), pv.Sphere().strip(), examples.load_airplane()],
    ids=["poles", "one plane", "caps", "strips", "airplane"],
)
def test_each_face_has_points_of_its_own_at_angle_0(mesh):
    """This includes coplanar neighbours, which no angle separates."""
    mesh.cell_data["number"] = np.arange(mesh.n_cells)
    split, points = split_sharp_edges(mesh, 0)
    assert sorted(np.concatenate([cell.point_ids for cell in split.cell])) == list(range(split.n_points))
    np.testing.assert_array_equal(split.points, mesh.points[points])
    np.testing.assert_array_equal(polygons(split)[1], polygons(mesh)[1])
    np.testing.assert_array_equal(points[polygons(split)[0]], polygons(mesh)[0])
    assert list(np.unique(split.cell_data["number"])) == list(range(mesh.n_cells))  # also for triangles of strips
    mesh.cell_data["paint"] = np.random.default_rng(3).integers(0, 256, (mesh.n_cells, 3)).astype(np.uint8)
    lit = mesh.phong.shade(SUN, ph.Material(albedo="paint"), feature_angle=0)
    assert lit.n_points == split.n_points


@pytest.mark.parametrize("albedo", ["tint", TINT], ids=["name", "array"])
def test_arrays_are_carried_and_points_know_which_they_were(albedo):
    mesh = cube()
    mesh["Normals"] = np.arange(8)  # an array with this name that holds no normals
    mesh["pyvistaOriginalPointIds"] = np.arange(8)  # from an earlier operation
    mesh.cell_data["face"] = np.arange(6)
    lit = mesh.phong.shade(SUN, ph.Material(ambient=1, diffuse=0, albedo=albedo), feature_angle="auto")
    again = lit.phong.shade(SUN, DULL, feature_angle=10)  # a mesh that was split before keeps its original points
    for split in (lit, again):
        np.testing.assert_array_equal(split[ORIGINAL_POINT], split["number"])
    for name in ("Normals", "pyvistaOriginalPointIds"):
        np.testing.assert_array_equal(lit[name], lit["number"])
    np.testing.assert_array_equal(lit.points, mesh.points[lit[ORIGINAL_POINT]])
    np.testing.assert_array_equal(lit.cell_data["face"], np.arange(6))
    np.testing.assert_allclose(lit["phong"], 0.2 * TINT[lit[ORIGINAL_POINT]], atol=1e-6)
    # the input is not modified
    assert mesh.array_names == ["number", "tint", "Normals", "pyvistaOriginalPointIds", "face"]
    assert mesh.n_points == 8


def test_auto_leaves_the_normals_that_a_mesh_brings():
    mesh = cube().compute_normals(cell_normals=False, split_vertices=False)
    assert split_sharp_edges(mesh, "auto")[0] is mesh
    named = mesh.phong.shade(SUN, DULL, feature_angle=30)
    assert named.n_points == 24
    assert "Normals" not in named.point_data  # they belong to the points before splitting


def test_faces_keep_their_sides():
    """By default VTK's filter reverses a face to agree with its neighbours."""
    mesh = nut()
    mesh.regular_faces = np.vstack([mesh.regular_faces[:1, ::-1], mesh.regular_faces[1:]])
    split, _ = split_sharp_edges(mesh, "auto")
    np.testing.assert_array_equal(split.points[split.regular_faces], mesh.points[mesh.regular_faces])


def test_strips_lines_and_vertices():
    strips = nut().strip()
    lit = strips.phong.shade(SUN, DULL, feature_angle="auto")
    assert lit.n_strips == 0
    assert lit.n_points == nut().phong.shade(SUN, DULL, feature_angle="auto").n_points
    cloud = pv.PolyData(np.eye(3))
    cloud.point_data.active_normals = np.eye(3)
    assert cloud.phong.shade(SUN, DULL, feature_angle=30).n_points == 3


def dressed(mesh):
    """With an array of every kind, each active for what it can be."""
    rng, result = np.random.default_rng(1), mesh.copy()
    result["tint"], result["flag"] = rng.random((mesh.n_points, 3)), rng.random(mesh.n_points) < 0.5
    result["label"] = [f"p{number}" for number in range(mesh.n_points)]
    result["wave"] = rng.random(mesh.n_points) + 1j
    result.point_data.active_texture_coordinates = rng.random((mesh.n_points, 2))
    result["wind"] = rng.random((mesh.n_points, 3))
    result.point_data.active_vectors_name = "wind"
    result.cell_data["Normals"], result.cell_data["fine"] = np.arange(mesh.n_cells), np.arange(mesh.n_cells) % 2 == 0
    result.field_data["note"] = np.arange(3)
    result.set_active_scalars("tint")
    return result


@pytest.mark.parametrize(
    "make", [cube, nut, lambda: bare(pv.Plane()), lambda: nut().strip()], ids=["cube", "nut", "plane", "strips"]
)
@pytest.mark.parametrize("worth", [0, 10**9], ids=["compiled", "VTK"])
@pytest.mark.parametrize("angle", [0, 30])
def test_every_array_goes_with_its_point_or_face(make, worth, angle, monkeypatch):
    monkeypatch.setattr("pvphong.meshes.surfaces._WORTH_LOADING", worth)
    mesh = dressed(make())
    before = state(mesh)
    split, points = split_sharp_edges(mesh, angle)
    assert state(mesh) == before
    for name in mesh.point_data:
        np.testing.assert_array_equal(split.point_data[name], mesh.point_data[name][points])
        assert split.point_data[name].dtype == mesh.point_data[name].dtype
    faces = np.arange(mesh.n_cells).repeat([cell.n_points - 2 if mesh.n_strips else 1 for cell in mesh.cell])
    for name in mesh.cell_data:
        np.testing.assert_array_equal(split.cell_data[name], mesh.cell_data[name][faces])
        assert split.cell_data[name].dtype == mesh.cell_data[name].dtype
    np.testing.assert_array_equal(split.field_data["note"], np.arange(3))
    assert split.active_scalars_name == "tint"
    assert split.point_data.active_vectors_name == "wind"
    texture = mesh.point_data.active_texture_coordinates_name
    assert split.point_data.active_texture_coordinates_name == texture


def rounded_box(kind, worth, monkeypatch):
    monkeypatch.setattr("pvphong.meshes.surfaces._WORTH_LOADING", worth)
    mesh = pv.ParametricSuperEllipsoid(n1=0.3, n2=0.3, u_res=12, v_res=12)
    mesh.clear_data()
    mesh.points = mesh.points.astype(kind)
    return split_sharp_edges(mesh, 20)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_compiled_code_and_vtk_give_the_same_mesh(kind, monkeypatch):
    (one, points), (two, others) = (rounded_box(kind, worth, monkeypatch) for worth in (0, 10**9))
    assert one.n_points > len(np.unique(points))
    np.testing.assert_array_equal(points, others)
    np.testing.assert_array_equal(one.points, two.points)
    np.testing.assert_array_equal(one.faces, two.faces)
    assert one.points.dtype == two.points.dtype == kind


def test_only_faces_decide_where_edges_are_sharp():
    """VTK's filter would also ask lines along an edge, and normals that the cells brought."""
    flat = pv.PolyData(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float), faces=[3, 0, 1, 2, 3, 0, 2, 3])
    flat.lines = [2, 0, 2]
    flat.cell_data.active_normals = np.float32([[1, 0, 0], [0, 1, 0], [0, 0, 1]])
    split, _ = split_sharp_edges(flat, 30)
    assert split.n_points == 4
    np.testing.assert_array_equal(split.lines, flat.lines)
    np.testing.assert_array_equal(split.cell_data.active_normals, flat.cell_data.active_normals)


def test_a_plan_is_that_of_the_split_surface():
    """The split surface has computed normals; the mesh's own face away from the light."""
    mesh = cube()
    mesh.point_data.active_normals = np.tile((0.0, 0.0, -1.0), (8, 1))
    lit, shiny = mesh.phong.shade(SUN, DULL, feature_angle=30), ph.Material(specular=0.5, shininess=20)
    planned = mesh.phong.plan(SUN, shiny, tolerance=0.01, feature_angle=30).explain()
    assert planned == lit.phong.plan(SUN, shiny, tolerance=0.01).explain()
    assert planned != mesh.phong.plan(SUN, shiny, tolerance=0.01).explain()


# --- live ---


def drawn_in(live):
    live.refresh(SUN)
    return live.drawn


def test_live_meshes_follow_what_becomes_sharp():
    folded = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0, 1], [1, 1, 1]], float)
    hinge = pv.PolyData(folded, faces=[4, 0, 1, 2, 3, 4, 1, 4, 5, 2])
    hinge["tint"] = TINT[:6]
    live = LitMesh(hinge, ph.Material(ambient=1, diffuse=0, albedo="tint"), feature_angle="auto")
    assert drawn_in(live).n_points == 8
    np.testing.assert_array_equal(live.drawn["phong"], np.round(0.2 * 255 * TINT[live.drawn[ORIGINAL_POINT]]))
    hinge.points = np.where(hinge.points[:, 2:] > 0, np.add(hinge.points, (1, 0, -1)), hinge.points)
    assert drawn_in(live).n_points == 6
    hinge.points = folded
    assert drawn_in(live).n_points == 8
