"""What the long hunts of `test_properties.py` found, cut down to one scene each."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from oracle import as_array, shade
from stability.evaluators import BACKENDS, EVALUATORS, UNLIT, Evaluator

from pvphong import DirectionalLight, Material, PointLight, Scene, SpotLight, Viewer
from pvphong.planning import make_plan

UP = np.array([[0.0, 0.0, 1.0]])
ABOVE = Viewer(position=(0.0, 0.0, 4.0))
WHITE = Material(ambient=1.0, diffuse=1.0, specular=1.0, shininess=10.0)
DOWN = (0.0, 0.0, -1.0)


def colors(evaluator: Evaluator, light: Any, material: Material = WHITE, points: Any = None, **options: Any) -> Any:
    points = np.zeros((1, 3)) if points is None else points
    return evaluator(points, np.broadcast_to(UP, points.shape), Scene([light], ABOVE), material, **options).rgb


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
def test_a_light_of_intensity_0_is_black_however_bright_its_colours(evaluator: Evaluator) -> None:
    """Reflectance times colour is infinite, and infinity times 0 was NaN."""
    glaring = Material(ambient=0.0, diffuse=1e200, specular=1e200)
    light = DirectionalLight(direction=DOWN, diffuse=1e200, intensity=0.0)
    assert not colors(evaluator, light, glaring).any()


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
@pytest.mark.parametrize("colour", [1e30, 1e60, 1e200, 1e308])
def test_a_light_too_bright_for_float32_is_white(evaluator: Evaluator, colour: float) -> None:
    """Its strength was infinite in the kernel's float32, and infinity times an n·l of 0 NaN."""
    light = DirectionalLight(direction=(0.0, -1.0, -1.0), diffuse=colour)
    scene, turned = Scene([light], ABOVE), np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    got = evaluator(np.zeros((2, 3)), turned, scene, Material(ambient=0.0, diffuse=1.0, specular=1.0)).rgb
    assert got.tolist() == [[1.0] * 3, [0.0] * 3]


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
@pytest.mark.parametrize("attenuation", [(0.0, 5e-324, 0.0), (1e-310, 0.0, 0.0), (0.0, 0.0, 1e-310)])
def test_outside_its_cone_a_spot_gives_nothing_however_little_it_weakens(
    evaluator: Evaluator, attenuation: Any
) -> None:
    """1 over a subnormal number is infinite, and infinity times the spot factor 0 was NaN, with a warning."""
    spot = SpotLight(position=(0.0, 0.0, 0.5), direction=(1.0, 0.0, 0.0), attenuation=attenuation, ambient=1.0)
    unattenuated = SpotLight(position=(0.0, 0.0, 0.5), direction=(1.0, 0.0, 0.0), ambient=1.0)
    plain = Evaluator("numpy", evaluator.precision)  # the kernel leaves such attenuations to it
    assert np.array_equal(colors(plain, spot), colors(evaluator, unattenuated))


@pytest.mark.parametrize("size", [1e-300, 1e-170, 1e-160, 1e160, 1e300])
def test_a_plan_judges_normals_of_any_length(size: float) -> None:
    """Squares of the normals overflowed, with a warning, or underflowed, and the cone of normals came out wrong."""
    rng = np.random.default_rng(5)
    normals = UP + 0.3 * rng.normal(size=(50, 3))
    scene = Scene([DirectionalLight(direction=(-1.0, -0.2, -1.0))], ABOVE)
    arguments = (rng.normal(size=(50, 3)), normals, scene, WHITE)
    expected = make_plan(*arguments, None, 1e-3)
    got = make_plan(arguments[0], normals * size, *arguments[2:], None, 1e-3)
    assert math.isclose(got.error_bound, expected.error_bound, rel_tol=1e-9)
    assert {name: choice.on for name, choice in got.effects.items()} == {
        name: choice.on for name, choice in expected.effects.items()
    }


@pytest.mark.parametrize("scale", [1e-200, 1e-170, 1e170, 1e300])
def test_a_plan_judges_matrices_of_any_scale(scale: float) -> None:
    """Products of the matrix with itself overflowed, with a warning."""
    turned = np.eye(4)
    turned[:3, :3] = np.linalg.qr(np.random.default_rng(6).normal(size=(3, 3)))[0] * scale
    scene = Scene([DirectionalLight(direction=DOWN)], ABOVE)
    got = make_plan(np.zeros((1, 3)), UP, scene, WHITE, turned, 0.0)
    assert got.effects["normal transform"].why.startswith("rigid or similar")


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("exponent", [1e-16, 1e-17, 3e5])
def test_a_bad_vertex_does_not_decide_how_the_others_see_a_spot(backend: str, exponent: float) -> None:
    """A cone that held the whole mesh with the same factor to the last bit went into the light's colours."""
    rng = np.random.default_rng(7)
    points = 0.01 * rng.normal(size=(40, 3))
    spoiled = points.copy()
    spoiled[3, 1] = np.nan
    spot = SpotLight(position=(0.2, 0.1, 1.0), direction=DOWN, cone_angle=40.0, exponent=exponent, diffuse=0.3)
    before, after = (colors(Evaluator(backend, "float64"), spot, points=p) for p in (points, spoiled))
    assert np.array_equal(np.delete(before, 3, axis=0), np.delete(after, 3, axis=0))


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
@pytest.mark.parametrize("cone_angle", [59.0, 61.0, 90.0])
@pytest.mark.parametrize("exponent", [0.0, 2.0])
def test_a_spot_on_a_vertex_takes_its_cosine_to_be_0(evaluator: Evaluator, cone_angle: float, exponent: float) -> None:
    """The chord from the axis to no direction at all is 1 long, and so is that of 60°."""
    spot = SpotLight(position=(0.0, 0.0, 0.0), cone_angle=cone_angle, exponent=exponent, ambient=1.0)
    scene = Scene([spot], ABOVE, UNLIT)
    truth = as_array(shade(np.zeros((1, 3)), UP, scene, WHITE), "unclamped")
    got = evaluator(np.zeros((1, 3)), UP, scene, WHITE).rgb
    assert got.tolist() == truth.tolist() == [[float(cone_angle == 90.0 and exponent == 0.0)] * 3]


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
def test_a_light_that_is_bright_because_it_is_far_away_is_not_cut_off(evaluator: Evaluator) -> None:
    lamp = PointLight(position=(0.0, 0.0, 2.0**60), attenuation=(0.0, 0.0, 1.0), intensity=2.0**119)
    assert colors(evaluator, lamp, Material(ambient=0.0, diffuse=1.0)).tolist() == [[0.5] * 3]


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
@pytest.mark.parametrize("gap", [1e-323, 1e-310, 1e-200, 1e-40, 1e-30])
def test_a_light_may_be_as_near_as_floats_can_be(evaluator: Evaluator, gap: float) -> None:
    """Scaled so that the gap counted, the coordinate that vertex and light share overflowed in the kernel."""
    points, normals = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 3.0, 4.0]])
    scene = Scene([PointLight(position=(1.0, 0.0, gap))], ABOVE)
    got = evaluator(points, normals, scene, Material(ambient=0.0, diffuse=1.0)).rgb
    assert np.abs(got - 0.8).max() <= 8 * evaluator.step


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
@pytest.mark.parametrize("intensity", [1e-300, 1e-150, 1e-40, 1e-20])
@pytest.mark.parametrize("distance", [1e-120, 1e-24, 1e-12])
def test_a_dim_light_may_weaken_with_a_tiny_distance(evaluator: Evaluator, distance: float, intensity: float) -> None:
    """In the kernel's float32 both its strength and the square of its distance were 0, and 0 / 0 is NaN."""
    lamp = PointLight(position=(0.0, 0.0, distance), attenuation=(0.0, 0.0, 5e-5), intensity=intensity)
    got = colors(evaluator, lamp, Material(ambient=0.0, diffuse=1.0))
    truth = min(intensity / 5e-5 / distance / distance, 1.0)
    assert np.abs(got - truth).max() <= 8 * evaluator.step * truth + 1e-40
