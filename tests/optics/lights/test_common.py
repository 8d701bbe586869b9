"""What every light shares: colours, switch, frame, name, and the way into `pyvista.Light`."""

import dataclasses
import math

import numpy as np
import pytest
import pyvista as pv
from hypothesis import given, settings
from hypothesis import strategies as st

from pvphong.optics.lights import LIGHT_TYPES, Light, PointLight, SpotLight

KINDS = list(LIGHT_TYPES.values())
every_kind = pytest.mark.parametrize("kind", KINDS)


@every_kind
def test_defaults_of_the_common_fields(kind):
    light = kind()
    assert (light.diffuse, light.specular, light.ambient) == ((1.0, 1.0, 1.0), None, (0.0, 0.0, 0.0))
    assert (light.intensity, light.on, light.frame, light.name) == (1.0, True, "world", "")


@every_kind
def test_is_frozen_and_hashable_by_value(kind):
    light = kind(name="sun", diffuse="red", specular=(1, 1, 1))
    assert light == kind(name="sun", diffuse=(1.0, 0.0, 0.0), specular=(1.0, 1.0, 1.0))
    assert hash(light) == hash(kind(name="sun", diffuse=[1, 0, 0], specular=np.ones(3)))
    assert light != kind(name="moon", diffuse="red", specular=(1, 1, 1))
    for field in dataclasses.fields(light):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(light, field.name, getattr(light, field.name))


def test_lights_of_different_kinds_are_different():
    assert PointLight() != SpotLight()
    assert len({kind() for kind in KINDS}) == len(KINDS)


def test_light_itself_cannot_be_made():
    with pytest.raises(TypeError, match=r"^Light is abstract"):
        Light()


@every_kind
def test_common_fields_are_keywords_only(kind):
    geometry = [field.name for field in dataclasses.fields(kind) if not field.kw_only]
    assert not {"diffuse", "specular", "ambient", "intensity", "on", "frame", "name"} & set(geometry)


@every_kind
@pytest.mark.parametrize("field", ["diffuse", "specular", "ambient"])
class TestColours:
    def test_in_canonical_form(self, kind, field):
        assert getattr(kind(**{field: "tomato"}), field) == (255 / 255, 99 / 255, 71 / 255)
        assert getattr(kind(**{field: np.array([1.5, 0, 0.1])}), field) == (1.5, 0.0, 0.1)
        assert getattr(kind(**{field: 1}), field) == 1.0

    @pytest.mark.parametrize("bad", [(255, 128, 0), np.array([0, 0, 200], np.uint8)])
    def test_0_to_255_is_refused(self, kind, field, bad):
        with pytest.raises(ValueError, match=rf"^{field} must be .*divide them by 255"):
            kind(**{field: bad})

    @pytest.mark.parametrize("bad", [-0.1, (0.5, -0.1, 0), math.nan, math.inf, "no such colour", (1.0, 1.0)])
    def test_others_are_refused_by_name(self, kind, field, bad):
        with pytest.raises(ValueError, match=rf"^{field}"):
            kind(**{field: bad})


@every_kind
@given(color=st.tuples(*[st.floats(0, allow_infinity=False)] * 3))
@settings(max_examples=30, derandomize=True, deadline=None, database=None)
def test_colours_are_kept_to_the_bit(kind, color):
    light = kind(diffuse=color, specular=color, ambient=color)
    for field in (light.diffuse, light.specular, light.ambient):
        assert [c.hex() for c in field] == [c.hex() for c in color]


@every_kind
def test_no_colour_is_refused_but_for_specular(kind):
    assert kind(specular=None).specular is None
    for field in ("diffuse", "ambient"):
        with pytest.raises(ValueError, match=rf"^{field} must be"):
            kind(**{field: None})


@every_kind
def test_highlights_have_the_diffuse_colour_unless_told(kind):
    assert kind(diffuse=(0.1, 0.2, 0.3)).specular_color == (0.1, 0.2, 0.3)
    assert kind(diffuse=0.5).specular_color == (0.5, 0.5, 0.5)
    assert kind(diffuse=0.5, specular=0.0).specular_color == (0.0, 0.0, 0.0)
    assert kind(diffuse=0.5, specular="blue").specular_color == (0.0, 0.0, 1.0)


@every_kind
@pytest.mark.parametrize("bad", [-1e-300, math.nan, math.inf, "1", None, True])
def test_intensity_is_a_number_from_0(kind, bad):
    with pytest.raises(ValueError, match=r"^intensity must be a finite number >= 0; got "):
        kind(intensity=bad)
    assert kind(intensity=0).intensity == 0.0
    assert kind(intensity=1e300).intensity == 1e300


@every_kind
def test_on_is_a_bool(kind):
    assert kind(on=np.False_).on is False
    with pytest.raises(ValueError, match=r"^on must be True or False; got 1"):
        kind(on=1)


@every_kind
def test_frame_is_one_of_three(kind):
    for frame in ("world", "camera", "headlight"):
        assert kind(frame=frame).frame == frame
    with pytest.raises(ValueError, match=r"^frame must be one of 'world', 'camera', 'headlight'; got cam"):
        kind(frame="cam")


@every_kind
def test_name_is_a_string(kind):
    with pytest.raises(ValueError, match=r"^name must be a string; got 3"):
        kind(name=3)


@every_kind
def test_unknown_fields_are_pythons_own_error(kind):
    with pytest.raises(TypeError, match="colour"):
        kind(colour="red")


@every_kind
def test_to_pyvista_does_not_round_to_8_bits(kind):
    color, third = (0.1, 1 / 3, 0.7071067811865476), (1.2345678901234567, 2.5, 1e-9)
    light = kind(diffuse=color, specular=third, ambient=color, intensity=1 / 7, on=False).to_pyvista()
    assert isinstance(light, pv.Light)
    assert light.GetDiffuseColor() == color
    assert light.GetSpecularColor() == third
    assert light.GetAmbientColor() == color
    assert light.GetIntensity() == 1 / 7
    assert light.GetSwitch() == 0


@every_kind
@pytest.mark.parametrize("frame", ["world", "camera", "headlight"])
def test_to_pyvista_keeps_the_frame(kind, frame):
    light = kind(frame=frame).to_pyvista()
    assert light.is_scene_light == (frame == "world")
    assert light.is_camera_light == (frame == "camera")
    assert light.is_headlight == (frame == "headlight")
    assert light.positional != kind.is_even


@every_kind
def test_to_pyvista_gives_a_new_light_every_time(kind):
    light = kind()
    assert light.to_pyvista() is not light.to_pyvista()
