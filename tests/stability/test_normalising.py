"""Section B of the catalogue of hard cases: unit vectors, against square roots in mpmath."""

from __future__ import annotations

import numpy as np
import pytest
from oracle import as_array, shade
from stability import exact_normals as exact
from stability import naive
from stability.bounds import U, V, assert_within
from stability.evaluators import EVALUATORS, UNLIT

from pvphong import DirectionalLight, LightModel, Material, PointLight, Scene, Viewer
from pvphong.geometry.transform import normalize, transform_normals
from pvphong.pipeline import implicit_normals

SAMPLES = 200


def directions(seed, samples=SAMPLES):
    """Return random directions and the axes; a third have one entry far smaller than the others."""
    rng = np.random.default_rng(seed)
    vectors = rng.normal(size=(samples, 3))
    vectors[::3, 1] *= 10.0 ** rng.uniform(-20, 0, len(vectors[::3]))
    return np.concatenate([vectors, np.eye(3), [[1.0, 1.0, 1.0]]])


def errors(observed, stored):
    return [exact.distance(o, exact.unit(exact.exact(s))) for o, s in zip(observed, stored, strict=True)]


LENGTHS = [(length, np.float32) for length in (1e-44, 1e-38, 1e-30, 1e-23, 1e-10, 1.0, 1e10, 1e30, 5e37)]
LENGTHS += [(length, np.float64) for length in (1e-322, 1e-308, 1e-200, 1e-170, 1e-162, 1e-160, 1e-100, 1.0)]
LENGTHS += [(length, np.float64) for length in (1e100, 1e160, 1e200, 1e307)]
every_length = pytest.mark.parametrize(
    ("length", "stored_as"), LENGTHS, ids=lambda of: f"{of:.0e}" if isinstance(of, float) else np.dtype(of).name
)


def row_of(length, stored_as):
    return f"{15 if stored_as == np.float32 else 16} {length:.0e}"


def stretched(vectors, length, stored_as):
    """Return the vectors scaled to a length, without those stored as zero."""
    stored = (vectors * length).astype(stored_as)
    return stored[stored.any(axis=1)]


NORMALISING = [
    normalize,
    lambda rows: transform_normals(rows, np.eye(4)),
    lambda rows: implicit_normals(lambda p: p, rows),
]


@every_length
def test_row_15_16(length, stored_as):
    stored = stretched(directions(15 if stored_as == np.float32 else 16), length, stored_as)
    for evaluator in NORMALISING:
        observed = evaluator(stored)
        assert_within(row_of(length, stored_as), errors(observed, stored), 4 * U)
        if stored_as == np.float32:
            assert_within(row_of(length, stored_as), errors(observed.astype(np.float32), stored), 4 * V)


@pytest.mark.parametrize(
    ("length", "factor"),
    [(1e-200, 1e15), (1e-162, 1e12), (1e-160, 1e7), (1e160, 1e15), (1e200, 1e15)],
    ids=lambda value: f"16-{value:.0e}",
)
def test_the_naive_way_breaks_the_bound_in_every_direction(length, factor):
    """At 1e-160 squares are subnormal and lose digits; beyond, they are 0 or infinite."""
    stored = directions(16) * length
    with np.errstate(all="ignore"):
        assert naive.least_excess(errors(naive.unit(stored), stored), 4 * U) > factor


ZEROS = [(0.0,) * 3, (-0.0,) * 3, (0.0, -0.0, 0.0)]
NOT_FINITE = [(np.nan, 0.0, 1.0), (1.0, np.inf, 0.0), (-np.inf, np.inf, np.nan), (np.nan,) * 3, (0.0, 0.0, np.inf)]


# --- in evaluators ---

SUN = DirectionalLight(direction=(-1.0, 2.0, -3.0))


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
@every_length
def test_row_15_16_as_lit(length, stored_as, evaluator):
    stored = stretched(directions(15, 12), length, stored_as)
    scene, matt = Scene([SUN], Viewer(), UNLIT), Material(ambient=0.0, diffuse=1.0)
    truth = as_array(shade(np.zeros_like(stored), stored, scene, matt), "unclamped")
    observed = evaluator(np.zeros_like(stored), stored, scene, matt).rgb
    assert_within(row_of(length, stored_as), np.abs(observed - truth), 10 * evaluator.step)


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
@pytest.mark.parametrize("bad", ZEROS + NOT_FINITE, ids=str)
def test_rows_17_18_as_lit(bad, evaluator):
    """Only ambient light and emission remain: 1/4 · 1/2 from the model, 1/4 · 1/8 from the lamp, and 1/16."""
    rng = np.random.default_rng(17)
    points, stored = rng.normal(size=(50, 3)), directions(17, 46)
    scene = Scene(
        [SUN, PointLight(position=(1.0, 2.0, 9.0), ambient=0.125)],
        Viewer(position=(0.0, 0.0, 9.0)),
        LightModel(ambient=0.5),
    )
    shiny = Material(ambient=0.25, diffuse=0.5, specular=0.5, shininess=3.0, emission=0.0625)
    spoilt = stored.copy()
    spoilt[7] = bad
    before, after = (evaluator(points, normals, scene, shiny).rgb for normals in (stored, spoilt))
    assert_within(f"{18 if any(bad) else 17}", np.abs(after[7] - 0.21875), 0.0)
    assert np.array_equal(np.delete(after, 7, axis=0), np.delete(before, 7, axis=0))
