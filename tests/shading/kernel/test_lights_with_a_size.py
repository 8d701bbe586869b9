"""Area lights in compiled code are within a bound of the float64 reference: near, far, cut and thin lights."""

from __future__ import annotations

import math

import numpy as np
import pytest
from strategies import LIGHT_SHAPES, Dice, triple

import pvphong as ph
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.shading import reference
from pvphong.shading.kernel import evaluation

COUNT = 300


def thrown(kind, seed):
    """Return a random light at any distance of random vertices, possibly among them."""
    dice, random = Dice(f"{kind} {seed}"), np.random.default_rng(seed)
    aim, place = (
        triple(-dice.unit_vector() + 0.5 * dice.vector()),
        triple(dice.unit_vector() * dice.choice((0.3, 0.7, 1.5, 3.0, 30.0, 1e3))),
    )
    intensity = max(float(np.dot(place, place)), 0.05)
    if kind == "sun":
        light = ph.DirectionalLight(aim, dice.choice((0.533, 5.0, 90.0)), intensity=intensity)
    else:
        light = LIGHT_TYPES[kind](**LIGHT_SHAPES[kind](dice, place, aim, 60.0), intensity=intensity)
    points = random.uniform(-1, 1, (COUNT, 3)) * dice.choice((1.0, 0.3))
    normals = dice.unit_vector() * dice.choice((0.0, 1.0, 3.0)) + random.normal(size=(COUNT, 3))
    power, specular = dice.choice((0.0, 0.5, 4.0, 5.5, 20.0, 300.0, 1e4, 1e6)), dice.choice((0.0, 0.5))
    material = ph.Material(ambient=0.0, diffuse=0.5, specular=specular, shininess=power)
    scene = ph.Scene([light], ph.Viewer(triple(3 * dice.unit_vector())), ph.LightModel(ambient=0, clamp=False))
    square = 1.0 if light.is_uniform else np.maximum(((points - place) ** 2).sum(axis=1), 1e-9)
    brightest = np.maximum(1.0, light.intensity / square * np.ones(COUNT))
    bound = (4 * math.sqrt(power if specular else 0.0) + 16) * 2.0**-24 * 2 * brightest
    return (points, normals, scene, material), bound[:, None]


def left_to_the_reference(monkeypatch, arguments):
    """Return the number of vertices that compiled code declines; COUNT if it declines the equation."""
    rows, original = [], reference.shade

    def counted(points, *others):
        rows.append(len(points))
        return original(points, *others)

    with monkeypatch.context() as patch:
        patch.setattr(evaluation, "shade_by_reference", counted)
        patch.setattr("pvphong.shading.plan.plan.reference.shade", counted)
        ph.evaluate(*arguments, backend="numba")
    return sum(rows)


@pytest.mark.parametrize("kind", ["disk", "environment", "sphere", "rectangle", "polygon", "sun"])
@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("count", [pytest.param(20, id="few"), pytest.param(600, id="many", marks=pytest.mark.long)])
def test_it_is_within_the_bound_of_the_reference_and_no_vertex_is_declined(kind, precision, count, monkeypatch):
    for seed in range(count):
        arguments, bound = thrown(kind, seed)
        exact = ph.evaluate(*arguments, precision="float64", backend="numpy").rgb
        got = ph.evaluate(*arguments, precision=precision, backend="numba").rgb
        allowed = 2 * bound if precision == "float32" else 1e-9 * np.maximum(bound / bound.min(), 1.0)
        assert (np.abs(got - exact) <= allowed).all(), (seed, np.abs(got - exact).max())
        assert left_to_the_reference(monkeypatch, arguments) == 0, seed


def test_vertices_that_see_all_of_a_light_are_taken_apart_from_those_whose_horizon_cuts_it():
    """Vertices 20 and 21 see the whole light. In one group with 0 to 4 and 27, the last is the first plus seven, as if
    the eight were consecutive.
    """
    cosines = np.full(28, -1.0)
    cosines[[20, 21]], cosines[[0, 1, 2, 3, 4, 27]] = np.linspace(0.8, 1.0, 2), np.linspace(-0.1, 0.1, 6)
    normals = np.stack([np.sqrt(1.0 - cosines**2), 0.0 * cosines, cosines], axis=1)
    light = ph.RectangleLight((0.0, 0.0, 2.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), 1.0, 1.0)
    arguments = np.zeros((28, 3)), normals, ph.Scene([light], ph.Viewer((0.0, 0.0, 9.0))), ph.Material(ambient=0.0)
    got, exact = (ph.evaluate(*arguments, precision="float64", backend=each).rgb for each in ("numba", "numpy"))
    np.testing.assert_allclose(got, exact, rtol=1e-12)
    assert (exact[:, 0] > 0.0).sum() == 8
