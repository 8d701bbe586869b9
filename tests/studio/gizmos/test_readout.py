"""The numbers beside a handle that is dragged."""

import dataclasses

from views import place

from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.studio.gizmos.readout import readout


def test_a_point_light():
    light = PointLight(position=(0, 0, 2), attenuation=(1, 0, 0.25), intensity=3, name="lamp")
    assert readout(light, "position", place()).splitlines() == [
        "lamp: position",
        "position (0, 0, 2)",
        "attenuation (1, 0, 0.25)",
        "1.5 arriving at the scene's middle",
    ]


def test_a_spot_light():
    light = SpotLight(position=(1, 0, 2), direction=(0, 0, -2), cone_angle=22.25, exponent=3, attenuation=(1, 0.5, 0))
    assert readout(light, "cone", place()).splitlines() == [
        "cone",
        "position (1, 0, 2)",
        "target (1, 0, 0)",
        "distance 2, cone 22.2°",
        "0.5 arriving at the target",
    ]


def test_a_directional_light():
    light = DirectionalLight(direction=(0, 2, -2), name="sun", intensity=0.5)
    assert readout(light, "target", place()).splitlines() == [
        "sun: target",
        "direction (0, 0.7071, -0.7071)",
        "azimuth 90.0°, elevation -45.0°",
        "0.5 arriving everywhere",
    ]


def test_a_light_that_is_off_sends_nothing():
    light = dataclasses.replace(DirectionalLight(), on=False)
    assert readout(light, "target", place()).endswith("0 arriving everywhere")
