"""Lights of a renderer: exact undo, order, names, and VTK's light objects."""

import dataclasses

import pytest
import pyvista as pv
import vtk
from views import KINDS, example

from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.studio.window_lights import WindowLights

LAMP = PointLight(position=(0.1, 0.2, 1 / 3), diffuse=(0.3, 1 / 3, 0.7), attenuation=(1, 0.1, 0.01), name="lamp")
SPOT = SpotLight(position=(1, 2, 3), direction=(-1, -2, -2.9), cone_angle=17.3, exponent=300.5, name="spot")
SUN = DirectionalLight(direction=(-1, -2, -3), name="sun")


@pytest.fixture
def renderer(new_plotter):
    return new_plotter().renderer


@pytest.fixture
def lights(renderer):
    return WindowLights(renderer)


def raw(light):
    """Return all fields of a VTK light, from its getters."""
    ends = ("Color", "Position", "FocalPoint", "Intensity", "Switch", "Cone", "Exponent", "AttenuationValues", "Type")
    ends += ("ShadowAttenuation",)
    ends += ("GetPositional", "GetConeAngle")
    return {name: getattr(light, name)() for name in dir(light) if name.startswith("Get") and name.endswith(ends)}


def lights_of_pyvista():
    turned = pv.Light(position=(1, 2, 3), positional=True, cone_angle=35)
    turned.transform_matrix = pv.Transform().rotate_x(30).translate((1, 2, 3)).matrix
    return {
        "scene": pv.Light(position=(1, 2, 3), focal_point=(0.1, 0, 0), color=(0.3, 0.5, 0.7), light_type="scene light"),
        "spot": pv.Light(position=(1, 2, 3), positional=True, cone_angle=20, exponent=7, light_type="scene light"),
        "point": pv.Light(position=(1, 2, 3), focal_point=(5, 6, 7), positional=True, cone_angle=123),
        "camera": pv.Light(position=(1, 2, 3), light_type="camera light"),
        "headlight": pv.Light(light_type="headlight"),
        "transformed": turned,
    }


@pytest.mark.parametrize("kind", lights_of_pyvista())
@pytest.mark.parametrize("value", [example(kind, 1 / 3, casts_shadows=False) for kind in KINDS], ids=list(KINDS))
def test_restoring_is_exact_to_the_bit(lights, kind, value):
    light = lights_of_pyvista()[kind]
    handle = lights.add(light)
    before, matrix = raw(light), light.GetTransformMatrix()
    elements, value_before = None if matrix is None else matrix.GetData(), handle.light(lights.viewer)
    state = lights.state
    handle.set(value, lights.viewer)
    assert handle.light(lights.viewer) == value
    now = lights.state
    lights.revert(now, state)
    assert raw(light) == before
    assert light.GetTransformMatrix() is matrix
    assert elements is None or matrix.GetData() == elements
    assert handle.light(lights.viewer) == value_before
    lights.revert(state, now)
    assert handle.light(lights.viewer) == value


def test_what_pvphong_alone_knows_comes_back_too(lights):
    handle = lights.add(SPOT)
    state = lights.state
    handle.set(dataclasses.replace(SPOT, name="other", exponent=2), lights.viewer)
    lights.revert(lights.state, state)
    assert lights.values == (SPOT,)
    assert lights.find("spot") is handle
    handle.vtk_light.SetIntensity(0.5)
    assert lights.values[0].name == "spot"


def test_a_moved_light_of_pyvista_keeps_what_does_not_matter(lights):
    light = lights_of_pyvista()["point"]
    handle = lights.add(light)
    handle.set(dataclasses.replace(handle.light(lights.viewer), position=(9, 8, 7)), lights.viewer)
    assert light.position == (9, 8, 7)
    assert (light.focal_point, light.cone_angle) == ((5, 6, 7), 123)
    sun = lights_of_pyvista()["scene"]
    handle = lights.add(sun)
    handle.set(dataclasses.replace(handle.light(lights.viewer), direction=(0, 0, -2)), lights.viewer)
    assert (sun.position, sun.focal_point) == ((1, 2, 3), (1, 2, 1))
    assert handle.light(lights.viewer).direction == (0, 0, -2)


def test_a_removed_light_returns_to_its_place(lights, renderer):
    for light in (SUN, LAMP, SPOT):
        lights.add(light)
    before = lights.state
    lights.remove("lamp")
    after = lights.state
    late = pv.Light()
    renderer.add_light(late)
    lights.revert(after, before)
    assert lights.values[:3] == (SUN, LAMP, SPOT)
    assert list(renderer.GetLights())[3] is late
    assert len(renderer.lights) == 4


@pytest.fixture
def removed(lights):
    """Remove one of three lights; return the states before and after."""
    for light in (SUN, LAMP, SPOT):
        lights.add(light)
    before = lights.state
    lights.remove("lamp")
    return before, lights.state


def test_a_light_that_returns_leaves_later_changes_of_others(lights, removed):
    before, after = removed
    dimmed, turned = dataclasses.replace(SUN, intensity=0.3), dataclasses.replace(SPOT, cone_angle=30)
    lights.find("sun").set(dimmed, lights.viewer)
    lights.find("spot").set(turned, lights.viewer)
    lights.revert(after, before)
    assert lights.values == (dimmed, LAMP, turned)


def test_a_light_that_was_removed_since_stays_away_when_another_returns(lights, removed):
    before, after = removed
    lights.remove("sun")
    lights.revert(after, before)
    assert lights.values == (LAMP, SPOT)


def test_a_light_that_was_put_in_again_since_does_not_return_twice(lights, renderer):
    light = pv.Light(position=(0, 0, 3))
    lights.add(light)
    then = lights.state
    lights.remove(light)
    now = lights.state
    renderer.add_light(light)
    lights.revert(now, then)
    assert list(renderer.GetLights()) == [light]


def test_replacing_takes_all_lights_out_and_is_undone(lights, renderer):
    renderer.add_light(pv.Light(intensity=0.4))
    lights.add(LAMP)
    before = lights.state
    lights.replace([SPOT, SUN])
    assert lights.values == (SPOT, SUN)
    lights.revert(lights.state, before)
    assert lights.state == before


def test_what_has_changed_since_otherwise_is_left(lights):
    lights.add(SUN)
    handle = lights.add(LAMP)
    before = lights.state
    lights.find("sun").set(dataclasses.replace(SUN, intensity=0.5), lights.viewer)
    after = lights.state
    handle.vtk_light.SetPosition(7, 7, 7)
    lights.revert(after, before)
    assert lights.values[0] == SUN
    assert lights.values[1].position == (7, 7, 7)


def test_a_light_of_vtk_or_of_others_is_followed_itself(lights, renderer):
    light = vtk.vtkLight()
    assert lights.add(light).vtk_light is light
    light.SetIntensity(0.3)
    assert lights.values[0].intensity == 0.3
    lights.remove(light)
    assert lights.values == ()
    for intensity in (0.4, 0.6):
        light = pv.Light(intensity=intensity)
        renderer.add_light(light)
        assert [each.intensity for each in lights.values] == [intensity]
        renderer.RemoveLight(light)
        assert lights.values == ()


def test_an_edited_transform_is_followed_and_removing_takes_the_lights_actor_too(lights, renderer):
    light = lights_of_pyvista()["transformed"]
    handle = lights.add(light)
    handle.light(lights.viewer)
    light.GetTransformMatrix().SetElement(0, 3, 9.0)
    assert handle.light(lights.viewer).position == light.world_position
    assert handle.light(lights.viewer).position[0] == pytest.approx(10.0)
    renderer.add_actor(light.actor)
    lights.remove(handle)
    assert not renderer.HasViewProp(light.actor)
    assert not renderer._lights
