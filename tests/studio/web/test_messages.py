"""Errors in the page's words, and the buttons of their remedies."""

import math

import pytest

from pvphong.base import check
from pvphong.optics.lights import PointLight
from pvphong.optics.reflectances import PBR
from pvphong.studio.web.fields import edited, number_in
from pvphong.studio.web.messages import in_page_words, remedies
from pvphong.studio.web.settings import Accuracy, Surfaces


def error_of(act, *args):
    """Return the error message of a call."""
    with pytest.raises(ValueError) as error:  # noqa: PT011 the message is tested by the caller
        act(*args)
    return str(error.value)


@pytest.mark.parametrize(
    ("act", "args", "said", "buttons"),
    [
        (edited, (PointLight(), "intensity", "-3"), "Brightness: -3 is out of range. Enter 0 or more.", ["0"]),
        (edited, (PointLight(), "intensity", "a lot"), "Brightness: “a lot” is not a number.", []),
        (edited, (PointLight(), "intensity", None), "Brightness: enter a value.", []),
        (edited, (PointLight(), "intensity", " "), "Brightness: enter a value.", []),
        (
            edited,
            (PointLight(), "intensity", "1,000"),
            "Brightness: “1,000” is ambiguous, because the comma may separate thousands or decimals.",
            ["1000", "1"],
        ),
        (edited, (PBR(), "roughness", 0), "Roughness: 0 is out of range. Enter a number above 0, up to 1.", []),
        (edited, (Accuracy(), "tolerance", 2), "Tolerance: 2 is out of range. Enter a number from 0 to 0.1.", ["0.1"]),
        (
            edited,
            (Surfaces(), "feature_angle", 181),
            "Sharp edges from: 181 is out of range. Enter a number from 0 to 180.",
            ["180"],
        ),
        (edited, (PointLight(), "on", "yes"), "On must be on or off, not yes.", []),
    ],
)
def test_errors_are_in_the_words_of_the_page(act, args, said, buttons):
    message = error_of(act, *args)
    assert in_page_words(message) == said
    found = remedies(message, "edit", ["light.1.intensity", "x", [1]])
    assert [each.label for each in found] == [f"Use {value}" for value in buttons]
    assert [each.calls for each in found] == [[["edit", ["light.1.intensity", value, [1]]]] for value in buttons]


@pytest.mark.parametrize("message", ["The connection was lost.", "", "nothing to undo"])
def test_other_messages_stay_as_they_are(message):
    assert in_page_words(message) == message
    assert remedies(message, "edit", ["light.1.intensity", 1]) == []


def test_similar_names_are_buttons():
    message = error_of(edited, PointLight(), "diffuse", "gren")
    first, *_ = remedies(message, "edit", ["light.1.diffuse", "gren"])
    assert first == ("Use green", [["edit", ["light.1.diffuse", "green"]]])


def test_thousands_with_a_fraction_have_one_reading():
    message = error_of(number_in, "width", "12,345.5")
    assert [each.label for each in remedies(message, "type_number", ["width", "12,345.5"])] == ["Use 12345.5"]


def test_a_mix_is_possible_after_bounces_are_off_and_bounces_after_the_mix():
    message = error_of(check.refuse, "bounces", 2, "0 in a mix", "Bounced light cannot be assigned to single lights.")
    (button,) = remedies(message, "start_mix", [True])
    assert button.calls == [["edit", ["model.bounces", 0]], ["start_mix", [True]]]
    (button,) = remedies(message, "edit", ["model.bounces", 2])
    assert button.calls == [["start_mix", [False]], ["edit", ["model.bounces", 2]]]


def test_not_a_number_has_no_nearest_limit():
    message = error_of(edited, PointLight(), "intensity", math.nan)
    assert remedies(message, "edit", ["light.1.intensity", math.nan]) == []
