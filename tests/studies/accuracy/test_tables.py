"""The sentences and tables of a report: what they call noise, and what is left out for one reason."""

import pytest

from pvphong.studies.accuracy.rows import Timing
from pvphong.studies.accuracy.tables import by_reason, is_noise


@pytest.mark.parametrize(
    ("cost", "noise"),
    [
        (Timing(5e-6, 4e-6, 6e-6, 20), False),
        (Timing(5e-6, -1e-6, 6e-6, 20), True),
        (Timing(-5e-6, -6e-6, -4e-6, 20), True),  # nothing costs less than nothing
        (Timing(5e-6, 4e-6, 6e-6, 2), True),  # quartiles of two numbers say nothing
    ],
)
def test_a_cost_is_noise_where_it_cannot_be_told_from_none(cost, noise):
    assert is_noise(cost) is noise


def test_what_is_left_out_for_one_reason_is_one_line():
    assert by_reason({"a": "no time", "b": "no highlight", "c": "no time"}) == [
        ("a, c", "no time"),
        ("b", "no highlight"),
    ]
