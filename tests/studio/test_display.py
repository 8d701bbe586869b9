"""Exposure and tone curve in windows: the lit colours, transformed, and nothing is lit again without need."""

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.studio.web.mix import colors_of

BALL = pv.Sphere(theta_resolution=30, phi_resolution=30)
SHINY = ph.Material(diffuse=(0.8, 0.5, 0.3), specular=0.6, shininess=20)
LOOKS = ph.Display(-1.5), ph.Display(0.5, "filmic"), ph.Display(overlay="clipping"), ph.Display(overlay="false color")


@pytest.fixture
def plotter(new_plotter):
    plotter = new_plotter()
    plotter.phong.add_light(ph.PointLight(position=(1, 1, 2), intensity=4.0, name="lamp"))
    plotter.phong.add_mesh(BALL, SHINY)
    return plotter


def shown(plotter):
    """Return the drawn bytes after a refresh, and the number of evaluations so far."""
    lit = plotter.phong._subplot.lit
    lit.refresh()
    (mesh,) = lit.meshes
    return colors_of(mesh).copy(), mesh.evaluations


@pytest.mark.parametrize("display", LOOKS)
@pytest.mark.parametrize("bounces", [0, 2])
def test_windows_show_the_unclamped_colours_through_the_display(plotter, display, bounces):
    plotter.phong.light_model = ph.LightModel(bounces=bounces)
    plain, _ = shown(plotter)
    plotter.phong.display = display
    model = ph.LightModel(bounces=bounces, clamp=False)
    lit = BALL.phong.shade(ph.Scene(plotter.phong.lights, plotter.phong.scene.viewer, model), SHINY)
    assert lit["phong"].max() > 1.5
    difference = np.abs(shown(plotter)[0].astype(int) - display(lit["phong"]))
    assert np.mean(difference > 1) < 0.01  # rounding may move a colour into the next band
    assert (shown(plotter)[0] != plain).any()
    plotter.phong.display = ph.Display()
    np.testing.assert_array_equal(shown(plotter)[0], plain)


def test_a_change_of_exposure_lights_nothing_again(plotter):
    plotter.phong.exposure = -1.0
    first, before = shown(plotter)
    for exposure in (0.3, 2.0, -1.0):
        plotter.phong.exposure = exposure
        last, after = shown(plotter)
        assert after == before
    np.testing.assert_array_equal(first, last)
    plotter.phong.set_light("lamp", intensity=1.0)
    assert shown(plotter)[1] == before + 1


def test_it_holds_for_all_subplots_also_for_later_ones():
    plotter = pv.Plotter(off_screen=True, shape=(1, 2), window_size=(60, 40), lighting="none")
    plotter.phong.exposure = 1.0
    for column in range(2):
        plotter.subplot(0, column)
        plotter.phong.add_light(ph.DirectionalLight(direction=(0, 0, -1)))
        plotter.phong.add_mesh(BALL, ph.Material(ambient=0.0, diffuse=0.25))
    drawn = [colors_of(subplot.lit.meshes[0]).max() for subplot in plotter.phong._subplots]
    assert drawn == [128, 128]
    plotter.phong.exposure = 0.0
    for subplot in plotter.phong._subplots:
        subplot.lit.refresh()
    assert [colors_of(subplot.lit.meshes[0]).max() for subplot in plotter.phong._subplots] == [64, 64]
    plotter.close()


def test_a_refined_picture_is_shown_anew_and_not_made_anew(new_plotter):
    plotter = new_plotter()
    plotter.phong.add_light(ph.SpotLight(position=(0, 0, 2), direction=(0, 0, -1), cone_angle=10, intensity=3.0))
    plotter.phong.add_mesh(pv.Plane(i_resolution=6, j_resolution=6), SHINY, refine=0.05)
    plotter.phong.exposure = -1.0
    lit = plotter.phong._subplot.lit
    (refining,) = lit.refining.values()
    colors = []
    for exposure in (-1.0, 0.5, -1.0):
        plotter.phong.exposure = exposure
        lit.refresh(waits=True)
        picture = lit.meshes[0].actor.mapper.dataset
        colors.append(np.array(picture["phong"]))
        assert picture.n_points > lit.meshes[0].drawn.n_points
        assert refining.pictures == 1
    np.testing.assert_array_equal(colors[0], colors[2])
    assert colors[1].mean() > colors[0].mean()


@pytest.mark.parametrize("given", [1.0, "filmic", None])
def test_another_value_than_a_display_is_refused(plotter, given):
    with pytest.raises(ValueError, match=r"^display must be a Display; got"):
        plotter.phong.display = given
    with pytest.raises(ValueError, match=r"^exposure must be a finite number"):
        plotter.phong.exposure = "bright"
    assert plotter.phong.display == ph.Display()
