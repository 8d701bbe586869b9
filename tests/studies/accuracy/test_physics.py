"""Light models against path tracing: known errors, noise, the sentence, the panel."""

import json

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph

GREY = ph.Material(ambient=0.6, diffuse=0.6, specular=0.0)


@pytest.fixture(scope="module")
def report():
    """Measure a sphere of albedo 0.6 that emits light inwards: the truth and each model's error are known."""
    ball = pv.Icosphere(nsub=2)
    ball.point_data.active_normals = -ball.points
    glowing = ph.Material(ambient=0.6, diffuse=0.6, specular=0.0, emission=0.2)
    scene = ph.Scene(viewer=ph.Viewer((0, 0, 3)), light_model=ph.LightModel(ambient=0.1))
    return ball.phong.tradeoff(scene, glowing, seconds=1.0, truth=True)


def test_errors_are_what_each_model_misses(report):
    """B = e/(1 − ρ) = 0.5; direct light is 0.2, and bounces are a geometric series."""
    physics = report.physics
    models = {each.name: each for each in physics.models}
    np.testing.assert_allclose(physics.truth.rgb.mean(), 0.5, atol=5 * physics.noise + 1e-3)
    assert models["a constant"].error.mean() == pytest.approx(0.26 - 0.5, abs=0.01)
    assert models["fitted constant 0.5"].rms < 0.02
    constant = 0.5
    left = {1: 0.2 + 0.6 * (0.2 + 0.6 * constant), 2: 0.2 + 0.6 * (0.2 + 0.6 * (0.2 + 0.6 * constant))}
    for name, bounces in (("one bounce", 1), ("two bounces", 2)):
        assert models[name].colors.mean() == pytest.approx(left[bounces], abs=0.01)
    np.testing.assert_allclose(models["all bounces"].colors, 0.5, atol=2e-3)
    assert all(each.seconds > 0.0 for each in physics.models)
    assert next(iter(models)) == "a constant"
    assert len(models) == 7


def test_it_says_what_to_use(report):
    physics = report.physics
    assert physics.sentence() in str(report).replace("\n  ", " ").replace("\n", " ")
    assert physics.sentence().startswith("The constant is off by up to 0.")
    assert physics.cheapest.rms <= 1.25 * max(min(each.rms for each in physics.models), physics.noise / 4)
    assert "all bounces" in report.explain()
    assert "path tracing, ±" in report.explain()
    numbers = json.loads(json.dumps(report.to_dict()))["physics"]
    assert [each["name"] for each in numbers["models"]] == [each.name for each in physics.models]
    assert "Physics of 7" in repr(physics)


def test_the_panel_is_drawn_alone_and_in_the_figure(report, tmp_path):
    pytest.importorskip("matplotlib")
    report.physics.plot(tmp_path / "panel.png")
    report.plot(tmp_path / "report.png")
    panel, figure = (pv.read(tmp_path / name) for name in ("panel.png", "report.png"))
    assert panel.dimensions[:2] == (1600, 550)
    assert figure.dimensions[1] == 1900
    assert len(np.unique(panel.active_scalars[:, :3] @ (2**16, 2**8, 1))) > 500
    with pytest.raises(ValueError, match="suffix of path"):
        report.physics.plot(tmp_path / "panel.bmp")


def test_noise_is_no_error():
    """Without bounces, constant ambient light is wrong, and direct light is right up to noise."""
    lamp = ph.SphereLight((0, 0, 2), radius=0.5, intensity=3)
    scene = ph.Scene([lamp], light_model=ph.LightModel(ambient=0.0))
    physics = (
        pv.Sphere(theta_resolution=12, phi_resolution=12).phong.tradeoff(scene, GREY, seconds=0.5, truth=True).physics
    )
    assert max(each.rms for each in physics.models) <= 3 * physics.noise + 2e-3


def test_scenes_without_bounces_and_two_sides_say_so():
    plane = pv.Plane(i_resolution=3, j_resolution=3)
    two = ph.Scene([ph.DirectionalLight()], light_model=ph.LightModel(two_sided=True))
    report = plane.phong.tradeoff(two, GREY, seconds=0.3, truth=True)
    assert report.left_out["bounces"] == "the light model is two-sided"
    assert len(report.physics.models) == 4
    with pytest.raises(ValueError, match=r"^truth must be False in VTK's convention"):
        plane.phong.tradeoff(ph.Scene(light_model=ph.LightModel.vtk()), GREY, seconds=0.3, truth=True)
    bounces = ph.Scene([ph.DirectionalLight()], light_model=ph.LightModel(bounces=2))
    assert "bounces" in plane.phong.tradeoff(bounces, GREY, seconds=0.3).left_out
    assert plane.phong.tradeoff(bounces, GREY, seconds=0.3).physics is None
