"""Figure of a report: limits and labels of the fronts for any measurements, and visible colours of errors."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.studies.accuracy.figure import draw_fronts, error_scale, linked_pictures
from pvphong.studies.accuracy.result import Errors, Row, Timing, with_fronts

figure = pytest.importorskip("matplotlib.figure")


def drawn(rows):
    """Return the panel of the rows' kind."""
    whole = figure.Figure(layout="constrained")
    draw_fronts(whole, SimpleNamespace(rows=with_fronts(rows), tolerance=1 / 255, chosen=()))
    whole.draw_without_rendering()
    (axes,) = whole.axes
    return axes


@pytest.mark.parametrize("error", [0.0, 1e-3, 1.0])
@pytest.mark.parametrize("seconds", [1e-4, 0.1, 0.11])
def test_one_row_of_any_time_has_room_in_both_directions(seconds, error):
    """Matplotlib finds no limits around a single time that is a power of ten."""
    errors = Errors(error, error, error, 10)
    row = Row("VTK per pixel", "interpolation", "VTK", "float32", 10, Timing.of([seconds]), interpolation=errors)
    axes = drawn([row])
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    assert left < 0.99 * seconds * 1e3 < 1.01 * seconds * 1e3 < right
    assert 0 < low < min(error or np.inf, 1 / 255) <= max(error, 1 / 255) < high


def test_the_panel_of_interpolation_says_how_the_error_falls_with_the_points():
    def row(name, points, rms):
        errors = Errors(1.0, rms, 1.0, 10)
        return Row(name, "interpolation", "numpy", "float32", points, Timing.of([1e-3 * points]), interpolation=errors)

    rows = [row("as it is", 100, 0.16), row("refined 1×", 400, 0.11), row("refined 2×", 1600, 0.08)]
    rows.append(row("refined adaptively", 200, 0.016))
    assert drawn(rows).get_xlabel().split("\n")[1:] == [
        "refined n×: RMS falls as points$^{-0.25}$",
        "refined adaptively: RMS 10× less by 2× the points",
    ]


@pytest.fixture(scope="module")
def report():
    scene = ph.Scene([ph.PointLight(position=(1, 1, 2))], ph.Viewer(position=(0, 0, 3)))
    measured = ph.tradeoff(pv.Sphere(), scene, ph.Material(specular=0.3, shininess=20), seconds=1)
    # the cheapest row depends on the machine
    return replace(measured, rows=tuple(row for row in measured.rows if row.name == "float32 NumPy"))


def test_errors_inside_triangles_have_no_picture_where_some_are_strips(report):
    """A triangle and a strip of one triangle have one error per cell."""
    mesh = pv.PolyData(np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], float), faces=[3, 0, 1, 2])
    mesh.SetStrips(pv.CellArray([3, 2, 1, 3]))
    black = np.zeros((4, 3))
    row = replace(report.rows[0], name="black")
    fields = {"reference_colors": black, "inside_errors": np.zeros(2), "_lighting": {"black": lambda: black}}
    found = linked_pictures(replace(report, surface=mesh, rows=(row,), **fields))
    assert [picture.title for picture in found][3:] == []


def colored(pixels):
    """Return the fraction of the mesh's pixels that are not grey."""
    inside = pixels[(pixels != pixels[0, 0]).any(axis=2)].astype(int)
    return np.mean(np.ptp(inside, axis=1) > 30)


def test_the_signed_error_can_be_seen_when_it_is_that_of_rounding(report):
    pictures = {picture.title: picture for picture in linked_pictures(report)}
    assert set(pictures) == {
        "reference",
        f"chosen: {report.best().name}",
        "its signed error at the vertices",
        "interpolation error inside triangles",
    }
    shown = pictures["its signed error at the vertices"]
    largest = np.abs(report.chosen_colors - report.reference_colors).max()
    assert 0.0 < largest < 1e-5
    assert shown.scale.get_clim() == (-largest, largest)
    assert colored(shown.pixels) > 0.05
    assert colored(pictures["interpolation error inside triangles"].pixels) > 0.5
    assert colored(pictures["reference"].pixels) == 0.0
    assert pictures["reference"].scale is None


def test_signed_errors_are_those_of_the_worst_channel(report):
    wrong = report.reference_colors + np.array([0.1, -0.3, 0.2])
    pictures = linked_pictures(replace(report, _lighting={report.best().name: lambda: wrong}))
    assert pictures[2].scale.get_clim() == pytest.approx((-0.3, 0.3))


def test_red_is_above_and_blue_below_and_no_error_white():
    scale = error_scale(np.array([-2e-7, 0.0, 1e-7]))
    below, none, above = scale.to_rgba(np.array([-2e-7, 0.0, 2e-7]))[:, :3]
    assert below[2] > 2 * below[0]
    assert above[0] > 2 * above[2]
    assert none.min() > 0.95
    assert error_scale(np.zeros(3)).get_clim() == (-1 / 255, 1 / 255)


def test_powers_of_ten_reach_from_a_part_of_the_tolerance_to_the_largest_error():
    assert error_scale(np.array([0.5, 0.0]), 0.01).get_clim() == (1e-4, 0.5)
    assert error_scale(np.array([1e-6, 0.0]), 0.01).get_clim() == (1e-4, 0.01)
