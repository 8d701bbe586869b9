"""Stages: where they are, which side is their front, and how close their points are."""

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.meshes.pictures import aim

KINDS = "ground", "backdrop", "plinth"
BALL = pv.Sphere(radius=2.0, center=(7, -3, 5))
SIZE = BALL.length
VIEWERS = {
    (0, 0, 1): ph.Viewer((20, 10, 20), BALL.center, up=(0, 0, 1)),
    (0, 1, 0): ph.Viewer((-4, 8, 20), BALL.center, up=(0, 1, 0.1)),
    (0, 0, -1): ph.Viewer((20, 10, -20), BALL.center, up=(0, 0, -1)),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("up", VIEWERS)
def test_the_mesh_stands_on_it_and_its_front_is_seen(kind, up):
    viewer = VIEWERS[up]
    made, up = ph.stage(BALL, kind, viewer), np.array(up)
    heights = (made.points - BALL.center) @ up
    below = np.linalg.norm((made.points - BALL.center) - heights[:, None] * up, axis=1) < 1.0
    bottom = ((BALL.points - BALL.center) @ up).min()
    assert bottom - 1e-3 * SIZE < heights[below].max() < bottom
    made = made.compute_normals(point_normals=False, auto_orient_normals=False, consistent_normals=False)
    normals, centers = made["Normals"], made.cell_centers().points - BALL.center
    if kind == "plinth":  # its side faces outwards
        upwards = (normals @ up > 0.99) | (np.einsum("ij,ij->i", normals, centers) > 0.0)
    else:
        upwards = (normals @ up > -1e-6) & (normals @ (np.array(viewer.position) - BALL.center) > 0.0)
    assert upwards.all()
    found = made.phong.diagnose()
    assert not any(map(len, (found.degenerate_faces, found.non_manifold_edges, found.inconsistent_edges)))


def test_the_wall_of_a_backdrop_is_behind_the_mesh():
    viewer = VIEWERS[0, 0, 1]
    made = ph.stage(BALL, "backdrop", viewer)
    top = made.points[made.points[:, 2] > made.bounds[5] - 0.01]
    to_viewer = np.array(viewer.position) - BALL.center
    assert ((top - BALL.center) @ (to_viewer * (1, 1, 0)) < 0.0).all()
    heights = made.points[:, 2]
    assert (heights.max() - heights.min()) / SIZE == pytest.approx(1.8, abs=0.01)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("spacing", [1 / 80, 1 / 20])
def test_points_are_as_close_as_asked_for_below_the_mesh(kind, spacing):
    made = ph.stage(BALL, kind, VIEWERS[0, 0, 1], spacing=spacing)
    centers = made.cell_centers().points
    near = np.linalg.norm(centers - (7, -3, BALL.bounds[4]), axis=1) < 0.25 * SIZE
    areas = made.compute_cell_sizes(length=False, volume=False)["Area"]
    assert near.sum() > 15
    assert areas[near].max() < (1.7 * spacing * SIZE) ** 2


@pytest.mark.parametrize("kind", KINDS)
def test_it_does_not_depend_on_the_unit(kind):
    small, large = ph.stage(pv.Sphere(), kind), ph.stage(pv.Sphere(radius=500.0), kind)
    np.testing.assert_allclose(large.points, 1000.0 * small.points, atol=1e-2)
    np.testing.assert_array_equal(large.faces, small.faces)


@pytest.mark.parametrize("kind", KINDS)
def test_a_plotter_draws_it_below_its_meshes_with_their_shadow(new_plotter, kind):
    plotter = new_plotter((120, 90))
    plotter.phong.add_light(ph.DirectionalLight(direction=(0, 0, -1)))
    plotter.phong.add_mesh(pv.Sphere(theta_resolution=20, phi_resolution=20), "gold")
    camera = plotter.camera_position
    plotter.phong.light_model = ph.LightModel(shadows=True)
    actors = [plotter.phong.add_stage(kind) for _ in range(2)]  # the second one replaces the first
    assert plotter.camera_position == camera
    assert len(plotter.phong._subplot.lit.shown) == 2
    assert actors[0].bounds == actors[1].bounds  # its own size does not count
    drawn = actors[1].mapper.dataset
    assert drawn["phong"].min() < 0.5 * drawn["phong"].max()
    plotter.phong.mesh(actors[1]).material = "jade"
    plotter.remove_actor("stage")
    assert len(plotter.phong._subplot.lit.shown) == 1


def test_a_picture_of_all_stages_shows_no_hole():
    for kind in KINDS:
        plotter = pv.Plotter(off_screen=True, window_size=(90, 60), lighting="none")
        plotter.set_background("red")
        aim(plotter, VIEWERS[0, 0, 1])
        made = ph.stage(BALL, kind, VIEWERS[0, 0, 1])
        plotter.phong.add_mesh(made, ph.Material(ambient=1.0, emission=0.4), culling="back")
        plotter.reset_camera_clipping_range()
        picture = plotter.screenshot(return_img=True)
        plotter.close()
        assert picture[30:, 20:70, 1].min() > 50, kind  # the lower half is covered by fronts


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"kind": "table"}, r"^kind must be one of 'ground', 'backdrop', 'plinth'; got table"),
        ({"mesh": pv.PolyData()}, r"^bounds must be"),
        ({"spacing": 0}, r"^spacing must be a finite number >= 0\.001 and <= 0\.5"),
        ({"viewer": (0, 0, 1)}, r"^viewer must be a Viewer"),
    ],
)
def test_bad_arguments_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        ph.stage(**{"mesh": BALL} | arguments)


def test_a_stage_needs_a_mesh(new_plotter):
    plotter = new_plotter()
    with pytest.raises(ValueError, match=r"^plotter must be a plotter that shows a lit mesh; got one without"):
        plotter.phong.add_stage()
    plotter.phong.add_mesh(BALL)
    with pytest.raises(ValueError, match=r"^kind must be one of"):
        plotter.phong.add_stage("table")
