"""The compiled search for the box around vertices finds what NumPy finds."""

from __future__ import annotations

import numpy as np
import pytest

import pvphong as ph
from pvphong.shading import kernel
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices

pytest.importorskip("numba", reason="the extra `fast` is not installed")
pytestmark = pytest.mark.skipif(not kernel.is_available(), reason="Numba cannot run here")

SHINY = ph.Material(ambient=0.3, diffuse=0.5, specular=0.4, shininess=25)


@pytest.fixture(autouse=True)
def _kernel_has_run():
    ph.evaluate(np.ones((9, 3)), np.ones((9, 3)), ph.Scene(), SHINY, backend="numba")
    for stored in ("float32", "float64"):
        from pvphong.shading.kernel.normals import extremes_code

        extremes_code(kernel._library(), stored)


@pytest.mark.parametrize("count", [2**15, 2**15 + 1, 2**15 + 130, 2**17 + 5, 300_000])
@pytest.mark.parametrize("stored", ["f4", "f8"])
def test_they_are_numpys(stored, count):
    random = np.random.default_rng(count)
    rows = (random.normal(size=(count, 3)) * (1.0, 1e3, 1e-20) + (5.0, 0.0, 1e-19)).astype(stored)
    rows[-1] = -7.0, 1e4, 1.0
    low, high = kernel.find_bounds(rows)
    np.testing.assert_array_equal(low, rows.min(axis=0))
    np.testing.assert_array_equal(high, rows.max(axis=0))
    rows[count // 2, 1] = random.choice((np.nan, np.inf, -np.inf))
    assert np.isnan(kernel.find_bounds(rows)).all()


def test_they_are_left_to_numpy_where_they_would_take_longer():
    rows = np.ones((2**15, 3), np.float32)
    assert kernel.find_bounds(rows) is not None
    assert kernel.find_bounds(rows[1:]) is None
    assert kernel.find_bounds(np.ones((2**15, 6), np.float32)[:, ::2]) is None
    assert kernel.find_bounds(rows.astype(np.float16)) is None


def test_they_are_left_to_numpy_before_anything_else_was_compiled(monkeypatch):
    monkeypatch.setattr(kernel._Process, "has_run", False)
    assert kernel.find_bounds(np.ones((2**15, 3), np.float32)) is None


@pytest.mark.parametrize("distance", [6.0, 60.0])
def test_a_plan_is_the_same_by_the_bounds_of_either(distance, monkeypatch):
    random = np.random.default_rng(3)
    points = (random.uniform(-1, 1, size=(2**15, 3)) * (1.0, 0.3, 0.05) + (4.0, -2.0, 1.0)).astype(np.float32)
    normals = (np.abs(points) * (0.01, 0.02, 1.0)).astype(np.float32)
    lights = [
        ph.PointLight(position=(4, -2, distance), attenuation=(1, 0, 0.01)),
        ph.PointLight(position=(4 - 9 * distance, -2, distance)),
        ph.SpotLight(position=(4, -2, distance), direction=(0.1, 0, -1), cone_angle=25, exponent=1),
    ]
    scene = ph.Scene(lights, ph.Viewer(position=(4, -2 - 30 * distance, 3)), ph.LightModel(two_sided=True))
    asked, find_bounds = [], kernel.find_bounds

    def compiled(rows):
        asked.append(find_bounds(rows))
        return asked[-1]

    plans = []
    for search in (lambda _: None, compiled, lambda rows: tuple(2 * x for x in find_bounds(rows))):
        monkeypatch.setattr(kernel, "find_bounds", search)
        plans.append(Plan.of(scene, SHINY, Vertices(points, normals), tolerance=0.2))
    assert len(asked) == 2
    assert all(found is not None for found in asked)
    assert plans[0].explain() == plans[1].explain()
    assert plans[0].error_bound == plans[1].error_bound > 0.0
    assert plans[2].error_bound != plans[0].error_bound
