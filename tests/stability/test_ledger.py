from __future__ import annotations

import math

import numpy as np
import pytest
from stability import ledger


@pytest.fixture(autouse=True)
def _own_entries(monkeypatch):
    monkeypatch.setattr(ledger, "entries", [])


def test_the_worst_ratio_is_kept_with_its_sample():
    ledger.record("1", "normalize", "float64", [1.0, 3.0, 2.0], [4.0, 4.0, 2.5])
    assert ledger.entries == [ledger.Entry("1", "normalize", "float64", 2.0, 2.5, 0.8)]


def test_a_sample_over_its_bound_fails_and_is_named():
    with pytest.raises(AssertionError, match=r"row 7, f in float32: 1 of 3 samples .* sample 1, has 5 where 4"):
        ledger.record("7", "f", "float32", [1.0, 5.0, 2.0], 4.0)
    assert ledger.entries[0].ratio == 1.25


@pytest.mark.parametrize("observed", [math.nan, math.inf, 1e-300])
def test_nothing_but_zero_meets_a_bound_of_zero(observed):
    with pytest.raises(AssertionError):
        ledger.record("9", "f", "float64", observed, 0.0)


def test_nan_meets_no_bound():
    with pytest.raises(AssertionError, match="1 of 2 samples"):
        ledger.record("9", "f", "float64", [math.nan, 0.0], 1.0)


def test_zero_meets_a_bound_of_zero():
    ledger.record("9", "f", "float64", 0.0, 0.0)
    assert ledger.entries[0].ratio == 0.0


def test_no_samples_are_no_evidence():
    with pytest.raises(AssertionError, match="nothing was measured"):
        ledger.record("9", "f", "float64", [], 1.0)


def test_a_promise_without_a_measure_is_held():
    with ledger.held("raises ValueError", "10", "f"), pytest.raises(ValueError, match="no"):
        raise ValueError("no")
    assert [(entry.bound, entry.ratio) for entry in ledger.entries] == [("raises ValueError", None)]


def test_a_broken_promise_is_noted_and_fails():
    with pytest.raises(AssertionError), ledger.held("raises ValueError", "10", "f"):
        raise AssertionError
    assert ledger.entries[0].ratio == math.inf


def test_the_same_bits_are_no_difference():
    ledger.same_bits("55", "f", "float64", [0.0, math.nan], [0.0, math.nan])
    assert (ledger.entries[0].observed, ledger.entries[0].ratio) == (0.0, 0.0)


def test_a_zero_of_the_other_sign_has_other_bits():
    with pytest.raises(AssertionError, match="1 of 2 numbers differ"):
        ledger.same_bits("55", "f", "float64", [0.0, 1.0], [-0.0, 1.0])
    assert ledger.entries[0].ratio == math.inf


def test_arrays_of_two_types_do_not_have_the_same_bits():
    with pytest.raises(AssertionError, match=r"float64 .* is no float32"):
        ledger.same_bits("55", "f", "float64", np.zeros(2), np.zeros(2, np.float32))
