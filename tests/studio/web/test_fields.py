"""Forms: the inputs are derived from the classes that the studio edits."""

import json
import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from pvphong.base import check
from pvphong.optics.light import Light, PunctualParameters
from pvphong.optics.lights import LIGHT_TYPES, EnvironmentLight, PhotometricLight, PointLight
from pvphong.optics.material import Material
from pvphong.optics.photometry import Photometry
from pvphong.optics.reflectances import PBR, REFLECTANCES
from pvphong.optics.roles import angle, place
from pvphong.scene.light_model import LightModel
from pvphong.studio.web.fields import edited, fields_of, form_of, hex_of, number_in
from pvphong.studio.web.kinds import new_reflectance
from pvphong.studio.web.settings import Accuracy

EDITED = [kind() for kind in LIGHT_TYPES.values()]
EDITED += [new_reflectance(name) for name in REFLECTANCES]
EDITED += [Material(), Material.named("gold"), LightModel(), LightModel(ambient_occlusion=2.5)]
edited_ones = pytest.mark.parametrize("value", EDITED, ids=lambda value: type(value).__name__)


@dataclass(frozen=True)
class Torch(Light):
    """A new kind of light.

    Parameters
    ----------
    position : sequence of float, default (0, 0, 0)
        Position of the flame.
    spread : float, default 20
        Angle of the beam, in degrees.
    smokes : bool, default False
        True if it *smokes*.
    """

    position: tuple[float, float, float] = place()
    spread: float = angle(20.0, "cone", above=0.0, at_most=90.0)
    smokes: bool = check.field(check.flag, False)

    is_uniform: ClassVar[bool] = False

    @property
    def placement(self):
        return PunctualParameters(self.position, (1.0, 0.0, 0.0))


def inputs(value, middles=None):
    """Return field name → its entry in the form."""
    return {entry["name"]: entry for entry in form_of(value, "light.1", {} if middles is None else middles)}


def test_a_new_kind_of_light_has_its_form():
    form = inputs(Torch())
    assert list(form)[:4] == ["position", "spread", "smokes", "diffuse"]
    assert form["spread"] | {"slide": 20.0, "from": 0.45, "to": 90.0} == form["spread"]
    assert (form["spread"]["unit"], form["position"]["unit"]) == ("°", "mesh unit")
    assert form["position"]["labels"] == ("x", "y", "z")
    assert form["smokes"]["help"] == "True if it smokes."
    assert edited(Torch(), "position", "2,5", [1]).position == (0.0, 2.5, 0.0)


def test_a_measured_lamp_shows_what_it_is_and_takes_a_number():
    lamp = PhotometricLight(Photometry("C", "0 90", "0", ("10 0.1",)))
    form = inputs(lamp)
    assert form["photometry"]["map"] == "<photometry of type C, 2 x 1 angles, 10 cd>"
    assert "value" not in form["photometry"]
    assert edited(lamp, "photometry", "5").photometry == 5.0
    with pytest.raises(ValueError, match=r"^photometry must be a number; got /etc/passwd"):
        edited(lamp, "photometry", "/etc/passwd")  # paths would be those of the server
    assert form["intensity"]["unit"] == "× measured"


def test_units_are_those_of_the_formulas():
    forms = {name: inputs(kind()) for name, kind in LIGHT_TYPES.items()}
    units = {name: {field: entry["unit"] for field, entry in form.items()} for name, form in forms.items()}
    sized = {name for name, of in units.items() if of["intensity"] == "mesh unit²"}  # divided by the squared distance
    assert sized == {name for name, kind in LIGHT_TYPES.items() if kind().has_size and not kind().is_uniform}
    assert units["directional"]["intensity"] == units["spot"]["exponent"] == ""
    assert units["spot"]["attenuation"] == units["point"]["attenuation"] == "1, 1/mesh unit, 1/mesh unit²"
    assert [field.unit for field in fields_of(Accuracy)] == ["of 1", "of 1"]


@edited_ones
def test_every_field_has_an_input_that_says_what_it_means(value):
    entries = form_of(value, "light.1", {})
    assert [entry["name"] for entry in entries] == [field.name for field in fields_of(type(value))]
    for entry in entries:
        assert entry["help"]
        assert entry["key"] == f"light.1.{entry['name']}"
        assert len(entry["labels"]) in (0, 3)
        if "slide" in entry:
            assert entry["from"] <= entry["slide"] <= entry["to"]
    json.dumps(entries, allow_nan=False)  # plain values


@edited_ones
def test_what_is_shown_changes_nothing_when_it_is_given_back(value):
    for entry in form_of(value, "", {}):
        if entry["kind"] in ("numbers", "color") and entry.get("value") and not entry["map"]:
            for index, number in enumerate(entry["value"]):
                assert edited(value, entry["name"], number, [index]) == value
        if entry["kind"] == "color" and entry["set"]:
            assert edited(value, entry["name"], entry["hex"]) is value
        elif entry["kind"] in ("number", "flag", "choice") and entry["set"]:
            given = entry["value"] if entry.get("number") is None else entry["number"]
            assert edited(value, entry["name"], given) == value


@pytest.mark.parametrize(
    ("value", "name", "given", "index", "message"),
    [
        (PointLight(), "intensity", "a lot", (), "intensity must be a number; got a lot"),
        (PointLight(), "intensity", math.nan, (), "intensity must be a finite number"),
        (PointLight(), "intensity", -1, (), "intensity must be a finite number >= 0"),
        (PointLight(), "intensity", True, (), "intensity must be a finite number"),
        (PointLight(), "intensity", None, (), "intensity must be set; got an empty input"),
        (PointLight(), "position", 1.0, (3,), "index of position must be a whole number below 3"),
        (PointLight(), "position", 1.0, (-1,), "index of position"),
        (PointLight(), "position", [1.0], (), "position must be 3 finite numbers"),
        (PointLight(), "attenuation", 0, (0,), "not all zero"),
        (PointLight(), "frame", "moon", (), "frame must be one of"),
        (PointLight(), "diffuse", "gren", (), "Did you mean 'green'"),
        (PointLight(), "on", "yes", (), "on must be True or False"),
        (PointLight(), "__class__", 1, (), "field must be one of"),
        (LightModel(), "ambient_occlusion", -2, (), "ambient_occlusion"),
        (PBR(), "roughness", 0, (), "roughness"),
    ],
)
def test_what_is_not_allowed_is_refused_by_name(value, name, given, index, message):
    with pytest.raises(ValueError, match=message):
        edited(value, name, given, index)


def test_what_is_optional_can_be_left_out():
    tinted = PointLight(specular="red")
    assert edited(tinted, "specular", None) == PointLight()
    entry = inputs(PointLight())["specular"]
    assert (entry["optional"], entry["set"]) == (True, False)


def test_an_array_and_an_image_are_named_not_shown():
    assert inputs(EnvironmentLight(image=np.ones((4, 8, 3))))["image"]["map"] == "image 8 × 4"
    assert inputs(Material(albedo="scan"))["albedo"]["map"] == "array 'scan'"


def test_a_slider_without_ends_spans_four_stops_to_either_side_and_stays_during_a_drag():
    for intensity, middle in ((1.0, 0.0), (200.0, np.log2(200.0)), (0.0, 0.0)):
        middles = {}
        entry = inputs(PointLight(intensity=intensity), middles)["intensity"]
        assert (entry["from"], entry["to"]) == (middle - 4.0, middle + 4.0)
        assert 2.0 ** entry["slide"] == pytest.approx(intensity or 2.0**-4)
        dragged = inputs(PointLight(intensity=3.0 * intensity), middles)["intensity"]
        assert (dragged["from"], dragged["to"]) == (middle - 4.0, middle + 4.0)


def test_hex_strings_are_what_a_display_shows():
    assert hex_of((1.5, 0.5, 0.0)) == "#ff8000"
    assert edited(PointLight(), "diffuse", "#ff8000").diffuse == (1.0, 128 / 255, 0.0)
    bright = replace(PointLight(), diffuse=(3.0, 0.2, 0.1))
    assert edited(bright, "diffuse", hex_of(bright.diffuse)) == bright


@pytest.mark.parametrize(
    ("typed", "number"), [("2,5", 2.5), ("0,125", 0.125), ("1000", 1e3), ("−1,25", -1.25), ("1,0000", 1.0)]
)
def test_a_comma_may_begin_the_fraction(typed, number):
    assert number_in("width", typed) == number


@pytest.mark.parametrize("typed", ["1,000", "-1,000", "12,345.5", "1,000,000"])
def test_commas_that_may_be_between_thousands_are_refused(typed):
    with pytest.raises(ValueError, match=rf"^width must be a number without thousands .*; got {typed}\. Write 1000 or"):
        number_in("width", typed)


@pytest.mark.parametrize(
    ("typed", "said"), [("abc", "abc"), ("1.5.2", "1.5.2"), ("", "an empty input"), ("  ", "an empty input")]
)
def test_what_is_no_number_is_refused(typed, said):
    with pytest.raises(ValueError, match=f"^width must be a number; got {said}\\.$"):
        number_in("width", typed)
