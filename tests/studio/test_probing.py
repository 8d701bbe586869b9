"""The probe, against all vertices lit with components."""

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.geometry.transform import SingularMatrixWarning

BALL = pv.Sphere(theta_resolution=16, phi_resolution=16)
LIGHTS = [
    ph.DirectionalLight(direction=(-1, -0.5, -2), diffuse=(1, 0.8, 0.6), name="sun"),
    ph.SphereLight(position=(1.5, -1, 2), radius=0.3, intensity=4, name="lamp"),
    ph.SpotLight(position=(0, 2, 3), direction=(0, -2, -3), cone_angle=40, on=False),
]
SHINY = ph.Material(ambient=0.2, diffuse=(0.6, 0.5, 0.4), specular=0.4, shininess=30)


def drawn(new_plotter, mesh, material=SHINY, model=None, **options):
    """Return a plotter that draws a mesh, and the actor."""
    plotter = new_plotter((64, 48))
    plotter.camera_position = [(0, -5, 3), (0, 0, 0), (0, 0, 1)]
    for light in LIGHTS:
        plotter.phong.add_light(light)
    plotter.phong.light_model = model or ph.LightModel()
    actor = plotter.phong.add_mesh(mesh, material, **options)
    plotter.show(auto_close=False)
    return plotter, actor


def ball_over_floor():
    """Return one mesh in which a ball shadows a floor, with an array of colours."""
    floor = pv.Plane(center=(0, 0, -0.6), i_size=3, j_size=3, i_resolution=6, j_resolution=6)
    mesh = BALL.append_polydata(floor)
    mesh["tint"] = np.random.default_rng(3).random((mesh.n_points, 3)).astype(np.float32)
    return mesh


MODELS = {
    "plain": ph.LightModel(),
    "two-sided": ph.LightModel(two_sided=True),
    "shadows": ph.LightModel(shadows=True, ambient_occlusion=True),
    "bounces": ph.LightModel(bounces=1),
    "unclamped": ph.LightModel(clamp=False),
}


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize(
    "material", [SHINY, ph.Material(albedo="tint", diffuse=0.9, reflectance=ph.GGX(roughness=0.4))]
)
def test_shares_are_those_of_the_lit_mesh(new_plotter, model, material):
    mesh = ball_over_floor()
    plotter, _ = drawn(new_plotter, mesh, material, MODELS[model], name="mesh")
    lit = mesh.phong.shade(plotter.phong.scene, material, components=True)
    for row in (0, 7, 100, mesh.n_points - 20, mesh.n_points - 1):
        found = plotter.phong.probe(mesh.points[row])
        assert (found.mesh, found.point_id) == ("mesh", row)
        np.testing.assert_allclose(found.position, mesh.points[row])
        np.testing.assert_allclose(found.color, lit["phong"][row], atol=2e-6)
        np.testing.assert_allclose(found.base, lit["phong_base"][row], atol=2e-6)
        assert list(found.shares) == ["sun", "lamp", "2"]
        for name, share in found.shares.items():
            np.testing.assert_allclose(share, lit[f"phong_light_{name}"][row], atol=2e-6, err_msg=name)
        bounced = lit["phong_bounced"][row] if model == "bounces" else np.zeros(3)
        np.testing.assert_allclose(found.bounced, bounced, atol=2e-6)


def test_a_moved_mesh_is_read_where_it_is_drawn(new_plotter):
    plotter, actor = drawn(new_plotter, BALL)
    actor.user_matrix = np.diag([2.0, 2.0, 2.0, 1.0]) + np.outer([5.0, 0, 0, 0], [0, 0, 0, 1])
    row = 40
    found = plotter.phong.probe(2.0 * BALL.points[row] + [5.0, 0, 0])
    assert found.point_id == row
    lit = BALL.phong.shade(plotter.phong.scene, SHINY, components=True, matrix=actor.user_matrix)
    np.testing.assert_allclose(found.shares["lamp"], lit["phong_light_lamp"][row], atol=2e-6)


def test_a_mesh_that_its_actor_flattens_is_read(new_plotter):
    plotter = new_plotter((100, 80))
    plotter.phong.add_light(ph.DirectionalLight(name="sun"))
    actor = plotter.phong.add_mesh(BALL.copy(), name="flat")
    actor.user_matrix = np.diag([1.0, 1.0, 0.0, 1.0])
    with pytest.warns(SingularMatrixWarning):
        plotter.show(auto_close=False)
    with pytest.warns(SingularMatrixWarning):
        found = plotter.phong.probe((0, 0, 0))
    assert found.mesh == "flat"


def test_the_nearest_surface_is_read_and_not_the_nearest_vertex(new_plotter):
    plotter, floor = drawn(new_plotter, pv.Plane(center=(0, 0, -0.7), i_size=4, j_size=4), name="floor")
    ball = plotter.phong.add_mesh(BALL, name="ball")
    assert plotter.phong.probe((0, 0, -0.65)).mesh == "floor"  # 0.05 from its only face, 2 from its corners
    assert plotter.phong.probe((0, 0, -0.55)).mesh == "ball"
    assert plotter.phong.probe((0, 0, -0.55), floor).mesh == "floor"
    ball.visibility = False
    assert plotter.phong.probe((0, 0, 9)).mesh == "floor"


def test_an_edit_is_followed(new_plotter):
    plotter, _ = drawn(new_plotter, BALL)
    before = plotter.phong.probe((0, 0, 0.5))
    plotter.phong.set_light("sun", intensity=0.5)
    after = plotter.phong.probe((0, 0, 0.5))
    np.testing.assert_allclose(after.shares["sun"], 0.5 * np.array(before.shares["sun"]), rtol=1e-5)
    assert after.shares["lamp"] == before.shares["lamp"]
    plotter.phong.exposure = 2
    assert plotter.phong.probe((0, 0, 0.5)).color == pytest.approx(after.color)  # data, not display


def test_what_cannot_be_probed_is_refused(new_plotter):
    plotter = new_plotter()
    with pytest.raises(ValueError, match=r"actor must be a visible mesh from .*; got none\. Call add_mesh first\."):
        plotter.phong.probe((0, 0, 0))
    plotter.phong.add_mesh(BALL)
    with pytest.raises(ValueError, match="point must be 3 finite numbers"):
        plotter.phong.probe((0, 0))
