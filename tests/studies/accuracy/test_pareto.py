"""Fronts are drawn for whatever was measured: many rows are in the figure of a whole report, here is one."""

from types import SimpleNamespace

import numpy as np
import pytest

from pvphong.studies.accuracy.pareto import draw_fronts
from pvphong.studies.accuracy.rows import Errors, Row, Timing, with_fronts

figure = pytest.importorskip("matplotlib.figure")


@pytest.mark.parametrize("error", [0.0, 1e-3, 1.0])
@pytest.mark.parametrize("seconds", [1e-4, 0.1, 0.11])
def test_one_row_of_any_time_has_room_in_both_directions(seconds, error):
    """A power of ten in ms, too, around which Matplotlib finds no limits."""
    errors = Errors(error, error, error, 10)
    row = Row("VTK per pixel", "interpolation", Timing.of([seconds]), None, None, errors, 10, "VTK", "float32")
    whole = figure.Figure(layout="constrained")
    draw_fronts(whole, SimpleNamespace(rows=with_fronts([row]), tolerance=1 / 255, chosen=()))
    whole.draw_without_rendering()
    (axes,) = whole.axes
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    assert left < 0.99 * seconds * 1e3 < 1.01 * seconds * 1e3 < right
    assert 0 < low < min(error or np.inf, 1 / 255) <= max(error, 1 / 255) < high
