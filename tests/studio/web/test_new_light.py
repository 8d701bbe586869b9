"""A new light raises the mean of the picture by a third of a stop."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.studio.web.document import Document
from pvphong.studio.web.new_light import brightened


@pytest.fixture
def plotter(new_plotter):
    plotter = new_plotter((300, 200))
    plotter.set_background("black")
    plotter.phong.add_mesh(pv.Sphere(theta_resolution=60, phi_resolution=60), ph.Material(diffuse=0.25))
    scene = ph.default_scene(pv.Sphere())
    for light in scene.lights:
        plotter.phong.add_light(light)
    plotter.phong.light_model = scene.light_model
    plotter.camera_position = [(2, 2, 2), (0, 0, 0), (0, 0, 1)]
    plotter.phong.add_gizmos()
    return plotter


def mean(plotter):
    """Return the mean of a picture without gizmos."""
    plotter.phong._subplot.interaction.gizmos.is_hidden = True
    return float(np.mean(plotter.screenshot(return_img=True)))


def test_a_picture_that_is_bright_already_gets_no_more_than_that(plotter):
    (ball,) = plotter.phong._subplot.lit.meshes
    ball.material = ph.Material.named("gold")
    document, before = Document(plotter.phong, plotter.phong._subplot, plotter.phong._history), mean(plotter)
    document.add("rectangle")
    assert 1.05 < mean(plotter) / before < 1.27


@pytest.mark.parametrize("kind", LIGHT_TYPES)
def test_a_new_light_raises_the_mean_by_a_third_of_a_stop(plotter, kind):
    document, before = Document(plotter.phong, plotter.phong._subplot, plotter.phong._history), mean(plotter)
    document.add(kind)
    if kind == "spot":  # it lights a small part of the ball
        assert 1.05 < mean(plotter) / before < 2 ** (1 / 3)
    else:
        assert mean(plotter) / before == pytest.approx(2 ** (1 / 3), abs=0.06)
    assert plotter.phong.lights[-1].name == kind


def test_the_first_light_is_as_bright_as_ever(plotter):
    document = Document(plotter.phong, plotter.phong._subplot, plotter.phong._history)
    for light in plotter.phong.lights:
        plotter.phong.set_light(light.name, on=False)
    document.add("point")
    assert plotter.phong.lights[-1].intensity == pytest.approx(0.6)


def test_a_light_that_reaches_nothing_is_left_as_it_is(plotter):
    mean(plotter)
    scene, meshes = plotter.phong.scene, plotter.phong._subplot.lit.shown
    away = ph.SpotLight(position=(3, 0, 0), direction=(1, 0, 0), cone_angle=10.0, intensity=7.0)
    assert brightened(away, scene, meshes) is away
    assert brightened(away, scene, []) is away
    assert brightened(away, replace(scene, viewer=None), meshes) is away
