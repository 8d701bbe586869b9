"""Fields of lights, materials and reflectances: defaults, canonical forms, and refused values.

A field is tested in every kind that has a field of its name, so a new kind needs no entry here.
"""

import dataclasses
import inspect
import math

import numpy as np
import pytest
import pyvista as pv
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import REFLECTANCE_SHAPES, Dice

from pvphong import DirectionalLight, Light, Material, PointLight, SphereLight, SpotLight
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.maps import NamedColor
from pvphong.optics.reflectances import REFLECTANCES, OrenNayar, Phong

LIGHTS = tuple(LIGHT_TYPES.values())
COLOURED = (*LIGHTS, Material)
ALL = (*COLOURED, *REFLECTANCES.values())
MADE = [kind() for kind in COLOURED] + [kind(**REFLECTANCE_SHAPES[k](Dice(0))) for k, kind in REFLECTANCES.items()]
COLOURS = ("ambient", "diffuse", "specular", "emission")
QUICK = settings(max_examples=60, derandomize=True, deadline=None, database=None)
every_light = pytest.mark.parametrize("kind", LIGHTS)
every_coloured = pytest.mark.parametrize("kind", COLOURED)


def values(thing, *, kw_only):
    """Return pairs of field and value in order, of the keyword-only fields or of the others."""
    return [(f.name, getattr(thing, f.name)) for f in dataclasses.fields(thing) if f.kw_only == kw_only]


def having(names, kinds=ALL):
    """Return pairs of a kind and a name, for each kind with a field of that name."""
    owned = {kind: {field.name for field in dataclasses.fields(kind)} for kind in kinds}
    return [(kind, name) for kind in kinds for name in names if name in owned[kind]]


# --- defaults ---


@pytest.mark.parametrize(
    ("kind", "defaults"),
    [
        (DirectionalLight, {"direction": (0.0, 0.0, -1.0), "angle": 0.0}),
        (PointLight, {"position": (0.0, 0.0, 0.0), "attenuation": (1.0, 0.0, 0.0)}),
        (SphereLight, {"position": (0.0, 0.0, 0.0), "radius": 1.0}),
        (
            SpotLight,
            {"position": (0.0, 0.0, 0.0), "direction": (0.0, 0.0, -1.0)}
            | {"cone_angle": 30.0, "exponent": 1.0, "attenuation": (1.0, 0.0, 0.0)},
        ),
    ],
)
def test_defaults_in_the_order_of_the_arguments(kind, defaults):
    assert values(kind(), kw_only=False) == list(defaults.items())


def test_a_materials_fields_are_given_by_keyword_and_have_opengls_defaults_but_for_the_shininess():
    expected = {"ambient": 0.2, "diffuse": 0.8, "specular": 0.0, "shininess": 30.0, "emission": 0.0}
    expected |= {"albedo": 1.0, "tangents": None, "reflectance": None}
    assert values(Material(), kw_only=False) == []
    assert values(Material(), kw_only=True) == list(expected.items())


@every_light
def test_what_all_lights_share_has_one_default_and_is_given_by_keyword(kind):
    assert dict(values(kind(), kw_only=True)) == {
        "diffuse": (1.0, 1.0, 1.0),
        "specular": None,
        "ambient": (0.0, 0.0, 0.0),
        "intensity": 1.0,
        "on": True,
        "casts_shadows": True,
        "frame": "world",
        "name": "",
    }


# --- canonical forms ---


@pytest.mark.parametrize(
    ("kind", "field", "given", "kept"),
    [
        (kind, field, given, kept)
        for fields, given, kept in [
            (COLOURS, "tomato", (255 / 255, 99 / 255, 71 / 255)),
            (COLOURS, 1, 1.0),
            (["intensity"], 0, 0.0),
            (["on", "casts_shadows"], np.False_, False),
            *((["frame"], frame, frame) for frame in ("world", "camera", "headlight")),
            (["position", "direction"], np.array([1, 2, 3]), (1.0, 2.0, 3.0)),
            (["attenuation"], [0, 1, np.float32(0.5)], (0.0, 1.0, 0.5)),
            (["cone_angle"], 90, 90.0),
            (["exponent"], 1e9, 1e9),
            *((["shininess"], n, float(n)) for n in (5e-324, 0.5, np.float32(200), 1e6, 1e308)),
        ]
        for kind, field in having(fields, COLOURED)
    ],
)
def test_canonical_form(kind, field, given, kept):
    found = getattr(kind(**{field: given}), field)
    if isinstance(found, NamedColor):  # a field that takes maps
        assert found.name == given
        found = tuple(found)
    assert (type(found), found) == (type(kept), kept)


@every_coloured
@given(color=st.tuples(*[st.floats(0, allow_infinity=False).filter(lambda c: not 16 < c <= 255)] * 3))
@QUICK
def test_colours_are_kept_to_the_bit(kind, color):
    for _, field in having(COLOURS, [kind]):
        assert [c.hex() for c in getattr(kind(**{field: color}), field)] == [c.hex() for c in color]
        assert getattr(kind(**{field: color[0]}), field).hex() == color[0].hex()


@every_coloured
def test_equal_and_hashed_by_value(kind):
    one = kind(diffuse="red", specular=(1, 1, 1))
    for same in (kind(diffuse=(1.0, 0.0, 0.0), specular=np.ones(3)), kind(diffuse=[1, 0, 0], specular="white")):
        assert one == same
        assert hash(one) == hash(same)
    assert len({one, kind(), kind(diffuse="blue", specular=(1, 1, 1)), kind(diffuse="red")}) == 4


@pytest.mark.parametrize("made", MADE)
def test_no_field_can_be_assigned(made):
    for field in dataclasses.fields(made):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(made, field.name, getattr(made, field.name))


@every_light
def test_highlights_have_the_diffuse_colour_unless_told(kind):
    assert kind(diffuse=(0.1, 0.2, 0.3)).specular_color == (0.1, 0.2, 0.3)
    assert kind(diffuse=0.5, specular=None).specular_color == (0.5, 0.5, 0.5)
    assert kind(diffuse=0.5, specular=0.0).specular_color == (0.0, 0.0, 0.0)
    assert kind(diffuse=0.5, specular="blue").specular_color == (0.0, 0.0, 1.0)


# --- refused values ---


@every_light
def test_a_lights_colour_by_pyvistas_name_is_refused_with_its_own(kind):
    message = rf"^color must be given as diffuse=; got red\. Use {kind.__name__}\(diffuse='red'\)\.$"
    with pytest.raises(ValueError, match=message):
        kind(color="red")


@every_coloured
def test_a_signature_names_the_fields(kind):
    assert set(inspect.signature(kind).parameters) == {field.name for field in dataclasses.fields(kind)}


COLOUR_MIX_UPS = [(255, 128, 0), (200, 100, 50), np.array([0, 0, 200], np.uint8)]
NO_COLOURS = [-0.1, (0.5, -0.1, 0), math.nan, (0.1, math.nan, 0.1), math.inf, (1.0, 1.0), True]
NO_POWERS = [-1e-300, math.nan, math.inf]
NO_MAPS = ["1", (1, 2, 3)]
NO_VECTORS = [(0, 0), (0, math.nan, 0), (math.inf, 0, 0), "here", None, 5]
NO_WEAKENING = [(0, 0, 0), (-1e-300, 0, 1), (1, -1, 0), (1, 0, -1)]
NO_HALF_OPENINGS = [0, -5, 90.00000000000001, 180, math.nan, math.inf, "30", None, True]
WEAKENING = r" must be three numbers >= 0 .*; got .*Use \(1, 0, 0\) for a light without falloff\."
HALF_OPENING = " must be a finite number > 0 and <= 90; got .*half the opening.*PointLight"
RADIUS = " must be a finite number > 0; got .*PointLight with attenuation"
AT_LEAST_0 = " must be a finite number >= 0; got "
REFUSED = [
    (COLOURED, COLOURS, COLOUR_MIX_UPS, " must be .*divide them by 255"),
    (COLOURED, [*COLOURS, "albedo"], NO_COLOURS, ""),
    (LIGHTS, COLOURS, ["colourless"], ""),
    ([Material], ["ambient"], ["colourless"], ""),  # in other fields, this is the name of a point array
    (LIGHTS, ["diffuse", "ambient"], [None], " must be"),  # specular may be None
    ([Material], [*COLOURS, "albedo"], [None], " must be"),
    (LIGHTS, ["intensity"], [*NO_POWERS, *NO_MAPS, None, True], AT_LEAST_0),
    (LIGHTS, ["on", "casts_shadows"], [1], " must be True or False; got 1"),
    (LIGHTS, ["frame"], ["cam"], " must be one of 'world', 'camera', 'headlight'; got cam"),
    (LIGHTS, ["name"], [3], " must be a string; got 3"),
    (LIGHTS, ["position", "direction", "attenuation"], NO_VECTORS, ""),
    (LIGHTS, ["direction"], [(0, 0, 0)], " must be a direction, .*not all zero"),
    (LIGHTS, ["attenuation"], NO_WEAKENING, WEAKENING),
    (LIGHTS, ["cone_angle"], NO_HALF_OPENINGS, HALF_OPENING),
    (LIGHTS, ["exponent"], [*NO_POWERS, *NO_MAPS, None], AT_LEAST_0),
    (LIGHTS, ["radius"], [0, -1, math.nan, math.inf, "1", None], RADIUS),
    ([Material], COLOURS[:3], [255.0, (255.0, 128.0, 0.0)], " must be a reflectance, .* divide them by 255"),
    ([Material], ["albedo"], [1.5, (0.0, 1.1, 0.0)], r" must be a reflectance of at most 1\.0, .*; got"),
    ([Material], ["shininess"], [*NO_POWERS, None], AT_LEAST_0),
    ([Material], ["reflectance"], ["phong", Phong, 3], " must be a reflectance, or None"),
    (LIGHTS, ["width", "height"], [0.0, math.nan], " must be a finite number > 0"),
    (LIGHTS, ["up"], [(0, 0, 0)], " must be a direction"),
    (LIGHTS, ["two_sided"], [1], " must be True or False"),
    (LIGHTS, ["rotation"], [math.inf], " must be a finite number"),
    (LIGHTS, ["corners"], [[(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1.5, 0)]], " must be .*Sides cross"),
    (LIGHTS, ["corners"], [[(0, 0, 0), (1, 0, 0), (1, 1, 0.1), (0, 1, 0)]], " must be .*not in one plane"),
    (LIGHTS, ["corners"], [[(0, 0, 0), (1, 1, 1), (2, 2, 2)]], " must be .*no area"),
    (LIGHTS, ["corners"], [[(0, 0, 0), (1, 0, 0)], [(0, 0, 0), (1, 0, 0), (0, math.nan, 0)]], " must be three or more"),
    (LIGHTS, ["corners"], ["square"], " must be"),
    (LIGHTS, ["image"], [np.full((4, 8, 3), math.nan)], " must be .*nan.*np.nan_to_num"),
    (LIGHTS, ["image"], [np.full((4, 8, 3), math.inf)], " must be .*inf.*Use a DirectionalLight for the sun"),
    (LIGHTS, ["image"], [np.full((4, 8, 3), -0.1)], " must be .*-0.1.*clip"),
    (LIGHTS, ["image"], [np.ones((4, 8)), np.ones((0, 8, 3))], " must be .*shape "),
    (LIGHTS, ["image"], [np.ones((4, 8, 4))], " must be .*Remove the opacity"),
    (LIGHTS, ["image"], [np.full((4, 8, 3), 200, np.uint8)], " must be .*8-bit.*255"),
    (LIGHTS, ["image"], [pv.Texture(np.full((4, 8, 3), 200, np.uint8))], " must be .*SetUseSRGB"),
    (LIGHTS, ["image"], ["sky.hdr"], " must be a colour, a pv.Texture, or an .*pv.read_texture"),
    ([OrenNayar], ["sigma"], [-1, 90.1, math.nan, "20", None], " must be a finite number >= 0 and <= 90"),
]


@pytest.mark.parametrize(
    ("kind", "field", "bad", "message"),
    [
        (kind, field, bad, message)
        for kinds, fields, all_bad, message in REFUSED
        for kind, field in having(fields, kinds)
        for bad in all_bad
    ],
)
def test_refused_by_name(kind, field, bad, message):
    with pytest.raises(ValueError, match=rf"^{field}{message}"):
        kind(**{field: bad})


def test_light_itself_cannot_be_made():
    with pytest.raises(TypeError, match=r"^Light is abstract"):
        Light()
