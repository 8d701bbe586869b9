import numpy as np
import pytest
import pyvista as pv

from pvphong import Material, Viewer, default_scene
from pvphong.meshes.lit import shade_mesh
from pvphong.pipeline import project

MESHES = {
    "long": pv.Cube(x_length=10, y_length=1, z_length=1),
    "tall": pv.Cube(x_length=1, y_length=1, z_length=10),
    "flat": pv.Plane(i_size=3),
    "far": pv.Cube(center=(1e5, -2e5, 3e5)),
    "large": pv.Cube(x_length=1e12, y_length=1e12, z_length=1e12),
    "small": pv.Cube(x_length=1e-12, y_length=1e-12, z_length=1e-12),
    "round": pv.Sphere(radius=3, center=(10, 0, 0)),
}


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@pytest.mark.parametrize("aspect", [0.5, 1.0, 4 / 3, 3.0])
def test_the_mesh_fills_the_picture_and_lies_within_it_and_the_clipping_range(mesh, aspect):
    """The view direction is PyVista's default; test_in_a_hurry tests `framing`."""
    viewer, framing = default_scene(mesh, aspect).viewer, Viewer.framing(mesh.bounds)
    assert viewer.view_direction == pytest.approx(framing.view_direction)
    assert (viewer.focal_point, viewer.up) == (pytest.approx(framing.focal_point), framing.up)
    x, y, depth = project(mesh.points, viewer, (2 * aspect, 2)).T - [[aspect], [1], [0]]
    extent = max(np.abs(x).max() / aspect, np.abs(y).max())
    is_round = mesh is MESHES["round"]
    assert (0.4 if is_round else 0.9) < extent < 1.0  # the bounding box fills the image
    slack = 0.0 if is_round else 1e-9  # two of a box's corners lie on the clipping planes
    assert depth.min() >= -slack
    assert depth.max() <= 1.0 + slack


def test_blocks_have_the_scene_of_their_meshes_and_tables_change_nothing():
    meshes = pv.MultiBlock([pv.Cube(), pv.Plane(center=(3, 0, 0))])
    expected, table = default_scene(meshes), pv.Table({"x": np.zeros(3)})
    meshes.append(table)
    assert default_scene(pv.MultiBlock([table, meshes, pv.PolyData()])) == expected


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((1e12, 0.0, -3e15), (1e12, 0.0, -3e15)),
        ((np.inf, 0.0, 0.0), (0.5, 0.5, 0.5)),  # the centre of a unit box
        ((0.0, -np.inf, 0.0), (0.5, 0.5, 0.5)),
    ],
)
def test_a_single_point_and_a_mesh_without_finite_bounds_can_be_looked_at(point, expected):
    cloud = pv.PolyData(np.array([point]))
    cloud.point_data.active_normals = np.array([[0.0, 0.0, 1.0]])
    assert default_scene(cloud).viewer.focal_point == pytest.approx(expected)


def test_key_is_brightest_and_nothing_is_lost_in_white():
    scene = default_scene(pv.Sphere())
    lit = shade_mesh(pv.Sphere(), scene, Material(), components=True)
    assert not scene.light_model.two_sided
    assert default_scene(pv.MultiBlock([pv.Sphere(), None, pv.Plane()])).light_model.two_sided  # the plane is open
    brightness = {light.name: lit[f"phong_light_{light.name}"].max() for light in scene.lights}
    assert max(brightness, key=brightness.get) == "key"
    assert 0.7 < lit["phong"].max() < 1.0


MOVES = {
    "far away": pv.Transform().translate(0, 0, 100),
    "turned": pv.Transform().rotate_x(130).scale(3, 1, 0.2).translate(-5, 2, 1e6),
    "mirrored": pv.Transform().reflect((1, 2, 0)),
}
WAYS = {
    "shade": lambda mesh, **how: mesh.phong.shade(**how)["phong"],
    "shade blocks": lambda mesh, **how: pv.MultiBlock([mesh, mesh]).phong.shade(**how)[0]["phong"],
    "truth": lambda mesh, **how: mesh.phong.truth(samples=16, max_bounces=0, **how).rgb,
    "validate": lambda mesh, **how: mesh.phong.validate(**how).pvphong,
    "refine": lambda mesh, **how: mesh.phong.refine(tolerance=0.1, **how)["phong"],
}


@pytest.mark.parametrize("move", MOVES.values(), ids=MOVES)
def test_a_model_matrix_gives_the_scene_of_the_moved_mesh(move):
    mesh = MESHES["flat"].copy()
    before = mesh.points.copy()
    mesh.points = before.astype(float)
    moved = mesh.transform(move, inplace=False)
    expected = default_scene(moved)
    for given, there in ((mesh, moved), (pv.MultiBlock([mesh, None]), pv.MultiBlock([moved]))):
        scene = default_scene(given, matrix=move.matrix)
        assert scene.viewer.position == pytest.approx(expected.viewer.position, rel=1e-12)
        assert scene.viewer.position == pytest.approx(default_scene(there).viewer.position, rel=1e-12)
        assert scene.lights == expected.lights
    assert np.array_equal(mesh.points, before)


@pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)
def test_a_mesh_under_a_matrix_is_lit_by_default_as_the_moved_mesh_is(way):
    mesh, matrix = MESHES["flat"], MOVES["far away"].matrix
    moved = mesh.transform(matrix, inplace=False)
    assert way(mesh, matrix=matrix) == pytest.approx(way(moved), abs=1e-4)
