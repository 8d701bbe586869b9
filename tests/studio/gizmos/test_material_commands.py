"""Keys for materials."""

import numpy as np
import pytest
import pyvista as pv
from mouse import Mouse

import pvphong  # noqa: F401 registers plotter.phong wherever PyVista's own discovery is not installed
from pvphong.base.types import rgb
from pvphong.optics.lights import PointLight
from pvphong.optics.material import Material
from pvphong.optics.reflectances import OrenNayar
from pvphong.studio.gizmos import commands

GOLD = Material.named("gold")
LEFT, RIGHT = (-0.7, 0.0, 0.0), (0.7, 0.0, 0.0)


@pytest.fixture
def mouse():
    plotter = pv.Plotter(off_screen=True, window_size=(400, 300), lighting="none")
    plotter.phong.add_light(PointLight(position=(0, -3, 3), name="lamp"))
    for name, center in (("left", LEFT), ("right", RIGHT)):
        plotter.phong.add_mesh(pv.Sphere(center=center), GOLD, name=name)
    plotter.camera_position = [(0, -6, 0), (0, 0, 0), (0, 0, 1)]
    plotter.show(auto_close=False)
    plotter.phong.add_gizmos()
    yield Mouse(plotter)
    plotter.close()


def materials(plotter):
    return [plotter.phong.mesh(plotter.renderer.actors[name]).material for name in ("left", "right")]


def colors(plotter):
    plotter.render()
    return [np.asarray(plotter.renderer.actors[name].mapper.dataset["phong"]).copy() for name in ("left", "right")]


@pytest.mark.parametrize("key", [key for command in commands._OF_MATERIALS for key in command.keys])
def test_a_key_changes_the_material_under_the_cursor_or_all_in_one_step(mouse, key):
    plotter = mouse.plotter
    before = colors(plotter)
    for place, changed in ((LEFT, [True, False]), (RIGHT, [False, True]), ((0, 0, 1.2), [True, True])):
        mouse.move(mouse.at(place))
        mouse.key(key)
        assert [material != GOLD for material in materials(plotter)] == changed
        assert [(a != b).any() for a, b in zip(colors(plotter), before, strict=True)] == changed
        mouse.key("z")
        assert materials(plotter) == [GOLD, GOLD]
        np.testing.assert_array_equal(colors(plotter), before)
        mouse.key("y")
        assert [material != GOLD for material in materials(plotter)] == changed
        mouse.key("z")


NAMES = [name for name in Material.names() if name != "brushed steel"]  # it needs tangents
OWN = [name for name in NAMES if Material.named(name).reflectance]


def test_presets_come_in_turn_and_keep_a_reflectance_unless_they_have_one(mouse):
    plotter = mouse.plotter
    actor = plotter.renderer.actors["left"]
    plotter.phong.mesh(actor).material = Material(diffuse=0.3, reflectance=OrenNayar(20))
    mouse.move(mouse.at(LEFT))
    seen = []
    for name in (*NAMES, NAMES[0]):
        mouse.key("M")
        seen.append(materials(plotter)[0])
        assert plotter.phong._pane.board.notice == f"material: {name}"
    assert len(set(map(repr, seen))) == len(NAMES) + 1
    plain = len(NAMES) - len(OWN)
    assert {material.reflectance for material in seen[:plain]} == {OrenNayar(20)}
    assert seen[plain:-1] == [Material.named(name) for name in OWN]
    assert seen[-1].reflectance is None
    mouse.key("K")
    assert plotter.phong._pane.board.notice == f"material: {NAMES[-1]}"


def test_shininess_and_highlight_go_down_to_nothing_and_up_again(mouse):
    plotter = mouse.plotter
    mouse.move(mouse.at(LEFT))
    for key in "57":
        for _ in range(20):
            mouse.key(key)
    (dull, _) = materials(plotter)
    assert (dull.shininess, rgb(dull.specular)) == (0.0, (0.0, 0.0, 0.0))
    for _ in range(20):
        mouse.key("8")
    for key, shininess in (("6", 1.0), ("6", 2**0.5), ("6", 2.0), ("5", 2**0.5)):
        mouse.key(key)
        assert materials(plotter)[0].shininess == shininess
    assert rgb(materials(plotter)[0].specular) == (1.0, 1.0, 1.0)


def test_without_a_mesh_that_is_said(mouse):
    for name in ("left", "right"):
        mouse.plotter.remove_actor(name)
    mouse.key("M")
    assert mouse.plotter.phong._pane.board.notice == "no lit mesh"
    assert not mouse.plotter.phong.undo()
