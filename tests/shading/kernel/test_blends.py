import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.base import threads
from pvphong.shading import kernel
from pvphong.shading.inside import lighting

RANDOM = np.random.default_rng(5)
CORNERS = RANDOM.integers(0, 50, (40, 3))
SHARED = RANDOM.dirichlet(np.ones(3), 7)
OWN = RANDOM.dirichlet(np.ones(3), (40, 7))


def blends_of(values, weights, low=-np.inf, high=np.inf, faces=CORNERS):
    """Blend one place after the other, with Python's floats."""
    rows = []
    for triangle, corners in enumerate(faces):
        for place in weights if weights.ndim == 2 else weights[triangle]:
            at_corners = [[min(max(x, low), high) for x in values[corner]] for corner in corners]
            rows.append(
                [sum(w * x for w, x in zip(place, column, strict=True)) for column in zip(*at_corners, strict=True)]
            )
    return np.array(rows)


@pytest.mark.parametrize("weights", [SHARED, OWN], ids=["shared", "own"])
@pytest.mark.parametrize("width", [1, 3, 8])
@pytest.mark.parametrize("limits", [(), (-0.5, 0.25)])
def test_blends_are_sums_of_corners(weights, width, limits):
    values = RANDOM.normal(size=(50, 2 * width))[:, ::2]  # not contiguous
    found = kernel.blending().blended(values, CORNERS, weights, *limits)
    np.testing.assert_allclose(found, blends_of(values, weights, *limits), rtol=0, atol=1e-15)


def test_along_sides_there_are_two_corners():
    values, weights = RANDOM.normal(size=(50, 3)), RANDOM.dirichlet(np.ones(2), (40, 5))
    found = kernel.blending().blended(values, CORNERS[:, :2], weights)
    np.testing.assert_allclose(found, blends_of(values, weights, faces=CORNERS[:, :2]), rtol=0, atol=1e-15)


def test_the_form_without_compiled_code_is_the_same(monkeypatch):
    values = RANDOM.normal(size=(50, 3))
    compiled = lighting.blended(values, CORNERS, OWN, 0.0, 1.0), lighting.difference(values, values[::-1])
    monkeypatch.setattr(kernel, "blending", lambda: None)
    np.testing.assert_allclose(lighting.blended(values, CORNERS, OWN, 0.0, 1.0), compiled[0], rtol=0, atol=1e-15)
    assert np.array_equal(lighting.difference(values, values[::-1]), compiled[1])


def test_what_is_not_finite_stays_so():
    values = np.ones((50, 3))
    values[0], values[1] = np.nan, np.inf
    found = kernel.blending().blended(values, np.array([[0, 2, 3], [1, 2, 3], [4, 2, 3]]), SHARED, 0.0, 1.0)
    assert np.isnan(found[:7]).all()
    assert np.array_equal(found[7:], blends_of(np.ones((50, 3)), SHARED)[:14]) or abs(found[7:] - 1.0).max() < 1e-15
    others = np.zeros((4, 3))
    colors = np.array([[0, 1, 2], [np.nan, 5, 6], [7, np.nan, 1], [-3, 2, np.nan]], float)
    np.testing.assert_array_equal(kernel.blending().differences(colors, others), [2.0, np.nan, np.nan, np.nan])


SCENE = ph.Scene([ph.PointLight(position=(1, 1, 2)), ph.SpotLight.at((0, -1, 2), target=(0, 0, 0), cone_angle=20)])
SHINY = ph.Material(specular=0.6, shininess=40)


def test_errors_inside_triangles_are_those_of_numpy_to_rounding(monkeypatch):
    ball = pv.Sphere(theta_resolution=120, phi_resolution=120)
    errors = [ball.phong.interpolation_error(SCENE, SHINY).active_scalars]
    with threads.limited(1):
        again = ball.phong.interpolation_error(SCENE, SHINY).active_scalars
    assert np.array_equal(errors[0], again), "must not depend on the number of threads"
    monkeypatch.setattr(kernel, "blending", lambda: None)
    monkeypatch.setattr(lighting, "_PLACES_PER_VERTEX", 0)  # NumPy evaluates
    errors.append(ball.phong.interpolation_error(SCENE, SHINY).active_scalars)
    assert errors[0].max() > 0.01
    np.testing.assert_allclose(errors[0], errors[1], rtol=0, atol=1e-12)
