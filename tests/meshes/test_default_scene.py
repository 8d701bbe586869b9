import numpy as np
import pytest
import pyvista as pv

from pvphong import Material, Viewer, default_scene, project
from pvphong.meshes.lit import shade_mesh

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
    """From where PyVista's camera looks at first: test_in_a_hurry has it that `framing` is there."""
    viewer, framing = default_scene(mesh, aspect).viewer, Viewer.framing(mesh.bounds)
    assert viewer.view_direction == pytest.approx(framing.view_direction)
    assert (viewer.focal_point, viewer.up) == (pytest.approx(framing.focal_point), framing.up)
    x, y, depth = project(mesh.points, viewer, (2 * aspect, 2)).T - [[aspect], [1], [0]]
    extent = max(np.abs(x).max() / aspect, np.abs(y).max())
    is_round = mesh is MESHES["round"]
    assert (0.4 if is_round else 0.9) < extent < 1.0  # the bounding box fills it
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
        ((np.inf, 0.0, 0.0), (0.5, 0.5, 0.5)),  # the middle of a unit box
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
    assert default_scene(pv.MultiBlock([pv.Sphere(), None, pv.Plane()])).light_model.two_sided  # for it is open
    brightness = {light.name: lit[f"phong_light_{light.name}"].max() for light in scene.lights}
    assert max(brightness, key=brightness.get) == "key"
    assert 0.7 < lit["phong"].max() < 1.0
