"""`plotter.phong.scene`: what is on the screen, as a scene."""

import dataclasses

import pytest
import pyvista as pv

import pvphong  # noqa: F401 registers plotter.phong wherever PyVista's own discovery is not installed
from pvphong.scene import Scene
from pvphong.viewer import Viewer


@pytest.fixture
def plotter():
    shown = pv.Plotter(off_screen=True)
    yield shown
    shown.close()


def test_scene_is_a_snapshot_of_what_is_shown(plotter):
    assert plotter.phong.scene == Scene.from_plotter(plotter)
    before = plotter.phong.scene
    plotter.camera.position = (1.0, 2.0, 3.0)
    after = plotter.phong.scene
    assert after.viewer == Viewer.from_camera(plotter.camera)
    assert before.viewer != after.viewer
    assert [light.diffuse for light in before.lights] == [light.diffuse for light in after.lights]


def test_scene_is_frozen(plotter):
    with pytest.raises(dataclasses.FrozenInstanceError):
        plotter.phong.scene.lights = ()


def test_each_plotter_has_its_own(plotter):
    other = pv.Plotter(off_screen=True, lighting="none")
    assert len(other.phong.scene.lights) == 0
    assert len(plotter.phong.scene.lights) == 5
    other.close()


def test_closing_a_plotter_needs_nothing_more():
    shown = pv.Plotter(off_screen=True)
    assert shown.phong.scene.lights
    shown.close()
    shown.close()
