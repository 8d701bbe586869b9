"""No computed number has moved since tests/bits.json was recorded; and the comparison can tell.

Where a change is meant to move numbers, `python tests/bits.py --record` makes a new record.
"""

from __future__ import annotations

from dataclasses import replace

import bits
import numpy as np
import pytest

# One light, ordinary numbers, 300 vertices, no approximation: little slack.
ORDINARY = 38
ELSEWHERE = "another machine"


@pytest.fixture(scope="module")
def case() -> bits.Case:
    return bits.draw(ORDINARY)


def test_no_number_has_moved() -> None:
    outcomes = [bits.compute(index) for index in range(bits.SCENES)]
    assert not bits.moved(bits.load(), outcomes, bits.machine())


@pytest.mark.parametrize("precision", bits.PRECISIONS)
def test_one_bit_of_one_colour_is_another_hash(case: bits.Case, precision: str) -> None:
    shading = bits.shade(case, "numpy", precision)
    before = bits.hashed(shading)
    shading.rgb[17, 1] = np.nextafter(shading.rgb[17, 1], 2, dtype=shading.rgb.dtype)
    assert bits.hashed(shading) != before


def test_a_component_is_hashed_too(case: bits.Case) -> None:
    shading = bits.shade(replace(case, components=True), "numpy", "float64")
    before = bits.hashed(shading)
    shading.per_light[0, 17, 1] *= -1.0  # of 0 too: the sign is a bit
    assert bits.hashed(shading) != before


@pytest.mark.parametrize(("precision", "change"), [("float32", 0.02), ("float64", 1e-9)])
def test_one_changed_colour_is_another_sum(case: bits.Case, precision: str, change: float) -> None:
    shading = bits.shade(case, "numpy", precision)
    before = bits.summed(shading)
    assert bits.agree(before, bits.summed(shading), bits.slack(case, shading))
    shading.rgb[17, 1] += change
    assert not bits.agree(before, bits.summed(shading), bits.slack(case, shading))


def test_a_colour_that_is_no_number_agrees_with_nothing(case: bits.Case) -> None:
    shading = bits.shade(case, "numpy", "float32")
    shading.rgb[17, 1] = np.nan
    assert not bits.agree(bits.summed(shading), bits.summed(shading), bits.slack(case, shading))


def test_what_moved_is_named() -> None:
    outcome = bits.compute(0)
    here = bits.machine()
    recorded = bits.record([outcome], here)
    assert not bits.moved(recorded, [outcome], here)
    other_bits = replace(outcome, bits=["0" * 12, *outcome.bits[1:]])
    assert [line.split(":")[0] for line in bits.moved(recorded, [other_bits], here)] == ["scene 0, numpy, float32"]
    # a machine that is not in the record is not asked for bits, but for sums and plans
    assert not bits.moved(recorded, [other_bits], ELSEWHERE)
    other_sums = replace(outcome, sums=[outcome.sums[0], (0.0, 1e9), *outcome.sums[2:]])
    assert [line.split(":")[0] for line in bits.moved(recorded, [other_sums], ELSEWHERE)] == ["scene 0, numpy, float64"]
    for machine in (here, ELSEWHERE):
        assert "plan" in bits.moved(recorded, [replace(outcome, plan="")], machine)[0]
    assert bits.moved(recorded, [outcome, outcome], here) == ["scene 1: not in the record"]
