"""The numbers beside a handle that is dragged."""

import dataclasses

import pytest
from views import KINDS, Globe, example, role_of, scenery, view

from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.studio.gizmos.handles import handles
from pvphong.studio.gizmos.readout import readout


@pytest.mark.parametrize(
    ("light", "handle", "expected"),
    [
        (
            PointLight(position=(0, 0, 2), attenuation=(1, 0, 0.25), intensity=3, name="lamp"),
            "position",
            [
                "lamp: position",
                "position (0, 0, 2)",
                "attenuation (1, 0, 0.25)",
                "1.5 arriving at the scene's middle",
                "luminance 1.5",
            ],
        ),
        (
            SpotLight(position=(1, 0, 2), direction=(0, 0, -2), cone_angle=22.25, exponent=3, attenuation=(1, 0.5, 0)),
            "cone",
            [
                "cone",
                "position (1, 0, 2)",
                "target (1, 0, 0)",
                "distance 2, cone 22.2°",
                "0.5 arriving at the target",
                "luminance 0.5",
            ],
        ),
        (
            DirectionalLight(direction=(0, 2, -2), name="sun", intensity=0.5, diffuse=(1, 0, 0)),
            "target",
            [
                "sun: target",
                "direction (0, 0.7071, -0.7071)",
                "azimuth 90.0°, elevation -45.0°",
                "0.5 arriving everywhere",
                "luminance 0.106",
            ],
        ),
        (
            DirectionalLight(direction=(0, 2, -2), name="sun"),
            "origin",
            [
                "sun: origin",
                "direction (0, 0.7071, -0.7071)",
                "azimuth -90.0°, elevation 45.0°",
                "1 arriving everywhere",
                "luminance 1",
            ],
        ),
        (
            Globe(position=(1, 0, 2), radius=0.25, on=False),
            "radius",
            ["radius", "position (1, 0, 2)", "radius 0.25", "0 arriving at the scene's middle", "luminance 0"],
        ),
    ],
)
def test_the_numbers_of_each_kind(light, handle, expected):
    assert readout(light, handle, scenery()).splitlines() == expected


@pytest.mark.parametrize("kind", KINDS)
def test_every_field_with_a_handle_is_named(kind):
    light = example(kind)
    for handle in handles(light, scenery(), view()):
        first, *lines, last, _ = readout(light, handle, scenery()).splitlines()
        assert first == handle
        _, field = role_of(kind, handle)
        assert any(f"{name} " in line for line in lines for name in (handle, field))
        off = readout(dataclasses.replace(light, on=False), handle, scenery())
        assert off.splitlines()[-2].startswith("0 arriving")
        assert not last.startswith("0 ")
