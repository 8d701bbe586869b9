"""What the long hunts found, cut down to one scene each."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from oracle import as_array, shade
from stability.evaluators import BACKENDS, EVALUATORS, UNLIT, Evaluator

from pvphong import DirectionalLight, Material, PointLight, Scene, SpotLight, Viewer, evaluate
from pvphong.geometry.transform import transform_points
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices

UP = np.array([[0.0, 0.0, 1.0]])
ABOVE = Viewer(position=(0.0, 0.0, 4.0))
WHITE = Material(ambient=1.0, diffuse=1.0, specular=1.0, shininess=10.0)
DOWN = (0.0, 0.0, -1.0)


def planned(points, normals, scene, material, **options):
    return Plan.of(scene, material, Vertices(points, normals), **options)


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
    expected = planned(*arguments, tolerance=1e-3)
    got = planned(arguments[0], normals * size, *arguments[2:], tolerance=1e-3)
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
    got = planned(np.zeros((1, 3)), UP, scene, WHITE, matrix=turned)
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


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
@pytest.mark.parametrize("material", [WHITE, Material(ambient=0.0, diffuse=0.9)], ids=["shiny", "dull"])
@pytest.mark.parametrize("constant", [3.0, 0.7, 1e-5, 1e8])
def test_a_cone_that_one_vertex_leaves_changes_no_bit_of_the_others(
    evaluator: Evaluator, constant: float, material: Material
) -> None:
    """A plan leaves out a cone that holds all vertices; the kernel then multiplied by the strength in other places."""
    rng = np.random.default_rng(1)
    points = rng.uniform(-0.5, 0.5, (300, 3))
    spot = SpotLight(position=(0.0, 0.0, 3.0), cone_angle=60.0, exponent=0.0, attenuation=(constant, 0.0, 0.0))
    assert "inside the cone" in planned(points, None, Scene([spot], ABOVE), material).effects["cone"].why
    inside = colors(evaluator, spot, material, points)
    for place in ((50.0, 0.0, 0.0), (np.nan, 0.0, 0.0)):
        changed = points.copy()
        changed[7] = place
        got = colors(evaluator, spot, material, changed)
        assert np.array_equal(np.delete(got, 7, axis=0), np.delete(inside, 7, axis=0))


# --- what a plan leaves out for these vertices, and what the others may not notice of it ---

AWAY: dict[str, Any] = {"position": (0.0, 0.0, 50.0), "direction": (0.0, 0.0, 1.0), "cone_angle": 30.0}
"""A spot that shines away from the mesh, so that a plan leaves it out; not so if a vertex is not finite."""
GLOW = PointLight(position=(0.3, 1.1, 2.7), diffuse=0.0, ambient=0.9, attenuation=(0.1, 0.3, 0.2))
"""It needs no normals; all else does."""


def assert_independent(
    evaluator: Callable[..., Any], lights: Any, types: tuple[Any, Any] = (float, float), **options: Any
) -> None:
    """The last vertex may be spoiled without a change of the others' bits."""
    points, normals = np.random.default_rng(0).normal(size=(2, 200, 3))
    spoiled = points.copy()
    spoiled[-1] = np.nan
    scene = Scene(lights, ABOVE, UNLIT)
    before, after = (
        evaluator(p.astype(types[0]), normals.astype(types[1]), scene, WHITE, **options).rgb[:-1]
        for p in (points, spoiled)
    )
    assert before.any()
    assert np.array_equal(before, after)


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
@pytest.mark.parametrize("types", [(np.float32, np.float64), (np.float64, np.float32), (np.float32, np.float32)])
def test_who_needs_normals_does_not_choose_the_others_arithmetic(evaluator: Evaluator, types: tuple[Any, Any]) -> None:
    """Without normals the reference fell back on float64, and the kernel on the type of the points alone."""
    assert_independent(evaluator, [SpotLight(**AWAY), GLOW], types)
    albedo = np.random.default_rng(1).random((200, 3))
    everywhere = DirectionalLight(diffuse=0.0, ambient=0.1)
    assert_independent(evaluator, [SpotLight(**AWAY), everywhere], types, albedo=albedo)


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("beyond", [{"attenuation": (1.0, 0.0, 1e-31)}, {"attenuation": (1e31, 0.0, 1.0)}, {}])
def test_a_light_that_is_left_out_does_not_choose_the_evaluator(precision: str, beyond: dict[str, Any]) -> None:
    """The kernel declines such lights, also where its plan would leave them out."""

    def asked_for(*arguments: Any, **options: Any) -> Any:
        return evaluate(*arguments, **options, backend=BACKENDS[-1], precision=precision)

    spot = AWAY | (beyond or {"position": (0.0, 0.0, 1e31)})
    assert_independent(asked_for, [SpotLight(**spot), PointLight(position=(0.3, 1.1, 2.7))])


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
@pytest.mark.parametrize("eye", [(5.0, 5.0, 5.0), (0.1, 0.2, 0.3)])
@pytest.mark.parametrize("others", [[], [PointLight(position=(0.1, 0.2, 0.3), intensity=0.0)]], ids=["alone", "black"])
def test_a_lamp_on_the_image_of_a_vertex_stays_on_it(evaluator: Evaluator, eye: Any, others: Any) -> None:
    """The offset of the matrix was taken out of all where an eye or a black light stood at its very place."""
    matrix = np.eye(4)
    matrix[:3, 3] = (0.1, 0.2, 0.3)
    points = np.round(np.random.default_rng(4).uniform(-3.0, 3.0, (100, 3)), 1)
    for point in points:
        lamp = PointLight(position=transform_points(point[None], matrix)[0], attenuation=(0.0, 0.0, 1.0))
        scene = Scene([lamp, *others], Viewer(position=eye, focal_point=(9.0, 8.0, 7.0)), UNLIT)
        assert not evaluator(point[None], np.ones((1, 3)), scene, Material(), matrix=matrix).rgb.any()


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
@pytest.mark.parametrize("far", [1e6, 1e9, 1e12, 1e15])
def test_a_black_light_far_out_takes_no_digit(evaluator: Evaluator, far: float) -> None:
    """Stored far out and brought back by a matrix: the sums are exact, and differences to its offset are not."""
    offset = np.array([-far, far / 2, far / 4])
    points = np.round(np.random.default_rng(5).normal(size=(50, 3)) * 8.0) / 8.0 - offset
    normals = np.random.default_rng(6).normal(size=(50, 3))
    matrix = np.eye(4)
    matrix[:3, 3] = offset
    lamp, viewer = PointLight(position=(0.3, 0.7, 9.1)), Viewer(position=(3.0, 4.0, 20.0))
    black = PointLight(position=offset, intensity=0.0)
    usual, got = (
        evaluator(points, normals, Scene(lights, viewer, UNLIT), WHITE, matrix=matrix).rgb
        for lights in ([lamp], [lamp, black])
    )
    assert np.array_equal(got, usual)


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
@pytest.mark.parametrize("height", [1e-18, 1e-20, 1e-25, 1e-30])
def test_a_half_way_direction_may_be_short(evaluator: Evaluator, height: float) -> None:
    """l and v are opposite but for a component that is exact: its square underflowed, and with it the highlight."""
    light = PointLight(position=(1.0, height, 0.0))
    viewer = Viewer(position=(-1.0, height, 0.0))
    model = replace(UNLIT, reflection="blinn-phong")
    material = Material(ambient=0.0, diffuse=0.0, specular=1.0, shininess=1.0)
    got = evaluator(np.zeros((1, 3)), np.array([[1.0, 1.0, 0.0]]), Scene([light], viewer, model), material).rgb
    assert np.abs(got - math.sqrt(0.5)).max() <= 14 * evaluator.step


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_the_falloff_brings_a_glaring_spot_down_again(backend: str, precision: str) -> None:
    """The kernel cut its strength off before the falloff; now it leaves such a spot to the reference."""
    spot = SpotLight(
        position=(0.0, 0.0, 1.0), direction=(0.0, -1.0, -1.0), cone_angle=60, exponent=1e3, intensity=2.0**501
    )
    arguments = (np.zeros((1, 3)), UP, Scene([spot], ABOVE, UNLIT), Material(ambient=0.0, diffuse=1.0))
    got = evaluate(*arguments, precision=precision, backend=backend).rgb
    assert np.abs(got - 2.0).max() <= 2.0 * 1000.0 * 4 * Evaluator(backend, precision).step  # of a small power, n·4u


@pytest.mark.parametrize("evaluator", [Evaluator("numpy", precision) for precision in ("float32", "float64")], ids=str)
def test_products_with_a_short_way_may_be_as_small_as_floats_can_be(evaluator: Evaluator) -> None:
    """N·D was rounded to the least float, and with ways in other units to another one."""
    tiny = float(np.finfo(evaluator.real).tiny) * 3.3
    normals, material = np.array([[-0.5, tiny, 0.0]]), Material(ambient=0.0, diffuse=1.0)
    lit = [
        evaluator(
            np.zeros((1, 3)), normals, Scene([PointLight(position=(0.0, 0.7 * unit, 0.0))], ABOVE, UNLIT), material
        )
        for unit in (1.0, 2.0**-20)
    ]
    assert lit[0].rgb.any()
    assert np.array_equal(lit[0].rgb, lit[1].rgb)


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
@pytest.mark.filterwarnings("ignore::pvphong.geometry.transform.SingularMatrixWarning")
def test_a_component_that_alone_is_left_may_be_small(evaluator: Evaluator) -> None:
    """The matrix keeps of the normal only what underflowed where its length was taken out first."""
    matrix = np.diag([2.0, 3.0, 0.0, 1.0])
    normal = np.array([[-1e31, -1e185, 1e-221]])
    scene = Scene([DirectionalLight(direction=DOWN)], ABOVE, UNLIT)
    stored_wide = evaluator(np.zeros((1, 3)), normal, scene, Material(ambient=0.0, diffuse=0.5), matrix=matrix)
    assert np.abs(stored_wide.rgb - 0.5).max() <= 4 * evaluator.step
