"""Regressions found by the long random tests, reduced to one scene each."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain, product, starmap
from typing import Any, NamedTuple

import numpy as np
import pytest
from stability.evaluators import EVALUATORS, UNLIT, Evaluator
from stability.hunting import FLATTENING_IS_NO_FAILURE, on_every_evaluator

from pvphong import DirectionalLight, LightModel, Material, Plan, PointLight, Scene, SpotLight, Viewer, evaluate
from pvphong.shading.vertices import Vertices

pytestmark = FLATTENING_IS_NO_FAILURE

UP = np.array([[0.0, 0.0, 1.0]])
ABOVE = Viewer(position=(0.0, 0.0, 4.0))
WHITE = Material(ambient=1.0, diffuse=1.0, specular=1.0, shininess=10.0)
DULL = Material(ambient=0.0, diffuse=1.0)
DOWN = (0.0, 0.0, -1.0)
FLAT = np.diag([2.0, 3.0, 0.0, 1.0])


def planned(points, normals, scene, material, **options):
    return Plan.of(scene, material, Vertices(points, normals), **options)


# --- one vertex under one light ---


class Seen(NamedTuple):
    """The expected grey of a vertex, exact or within a relative error in steps of the precision."""

    expected: float
    light: Any
    material: Material = DULL
    steps: float = 0.0
    n: Any = (0.0, 0.0, 1.0)
    p: Any = (0.0, 0.0, 0.0)
    viewer: Viewer = ABOVE
    model: LightModel = replace(UNLIT, clamp=True)
    matrix: Any = None
    is_declined: bool = False  # the kernel delegates to the reference


def all_but_even(height: float, attenuation: Any) -> Iterator[Seen]:
    """1 over an underflow is infinite, and infinity times a spot factor of 0 was NaN, with a warning."""
    fields = {"position": (0.0, 0.0, height), "attenuation": attenuation}
    yield Seen(1.0, PointLight(**fields), is_declined=True)
    yield Seen(0.0, SpotLight(**fields, direction=(1.0, 0.0, 0.0), ambient=1.0), WHITE, is_declined=True)


def too_bright_for_float32(color: float) -> Iterator[Seen]:
    """The strength was infinite in the kernel's float32, and infinity times n·l = 0 was NaN."""
    light, material = DirectionalLight((0.0, -1.0, -1.0), diffuse=color), replace(WHITE, ambient=0.0)
    yield Seen(1.0, light, material)
    yield Seen(0.0, light, material, n=(0.0, 0.0, -1.0))


def spot_on_the_vertex(angle: float, exponent: float) -> Seen:
    """A zero direction has a chord of 1 from the axis, like 60°; its cosine must count as 0."""
    expected = float(angle == 90.0 and exponent == 0.0)
    return Seen(expected, SpotLight(cone_angle=angle, exponent=exponent, ambient=1.0), WHITE)


def as_near_as_can_be(gap: float) -> Seen:
    """Scaled to the gap, the coordinate shared by vertex and light overflowed in the kernel."""
    return Seen(0.8, PointLight((1.0, 0.0, gap)), steps=8, n=(0.0, 3.0, 4.0), p=(1.0, 0.0, 0.0))


def dim_and_near(intensity: float, distance: float) -> Seen:
    """In the kernel's float32 both strength and squared distance were 0, and 0 / 0 was NaN."""
    lamp = PointLight((0.0, 0.0, distance), attenuation=(0.0, 0.0, 5e-5), intensity=intensity)
    return Seen(min(intensity / 5e-5 / distance / distance, 1.0), lamp, steps=8)


def as_bright_as_far(intensity: float) -> Seen:
    return Seen(1.0, PointLight((0.0, 0.0, 1e20), attenuation=(0.0, 0.0, 1.0), intensity=intensity), steps=8)


def short_half_way(height: float) -> Seen:
    """l and v are opposite except for one exact component. Its square underflowed, and the highlight was lost."""
    light, viewer, model = (
        PointLight((1.0, height, 0.0)),
        Viewer((-1.0, height, 0.0)),
        LightModel(0.0, reflection=BLINN),
    )
    material = Material(ambient=0.0, diffuse=0.0, specular=1.0, shininess=1.0)
    return Seen(math.sqrt(0.5), light, material, 14, (1.0, 1.0, 0.0), viewer=viewer, model=model)


BLINN = "blinn-phong"
FAR = PointLight((0.0, 0.0, 2.0**60), attenuation=(0.0, 0.0, 1.0), intensity=2.0**119)
BLACK = DirectionalLight(DOWN, diffuse=1e200, intensity=0.0)
GLARING = SpotLight((0.0, 0.0, 1.0), (0.0, -1.0, -1.0), cone_angle=60, exponent=1e3, intensity=2.0**501)
FOUND = [
    # Reflectance times colour overflows, and infinity times 0 was NaN.
    Seen(0.0, BLACK, Material(ambient=0.0, diffuse=1e200, specular=1e200)),
    *chain(*map(too_bright_for_float32, (1e30, 1e60, 1e200, 1e308))),
    *chain(*(all_but_even(0.5, weak) for weak in ((0.0, 5e-324, 0.0), (1e-310, 0.0, 0.0), (0.0, 0.0, 1e-310)))),
    *chain(all_but_even(1e-170, (0.0, 0.0, 1.0)), all_but_even(1e-200, (0.0, 1e-200, 0.0))),
    *starmap(spot_on_the_vertex, product((20.0, 59.0, 61.0, 90.0), (0.0, 1.0, 2.0))),
    Seen(0.5, FAR),  # bright, to compensate for the distance; must not be clipped
    *map(as_bright_as_far, (1e40, 1e300)),
    *map(as_near_as_can_be, (1e-323, 1e-310, 1e-200, 1e-40, 1e-30)),
    *starmap(dim_and_near, product((1e-300, 1e-150, 1e-40, 1e-20), (1e-120, 1e-24, 1e-12))),
    *map(short_half_way, (1e-18, 1e-20, 1e-25, 1e-30)),
    # The kernel clipped the strength before the falloff. The error is that of a small power, n·4u.
    Seen(2.0, GLARING, steps=4000, model=UNLIT, is_declined=True),
    # The matrix keeps only the component of the normal that underflowed when the normal was normalised first.
    Seen(0.5, DirectionalLight(DOWN), replace(DULL, diffuse=0.5), 4, (-1e31, -1e185, 1e-221), matrix=FLAT),
]


@on_every_evaluator
@pytest.mark.parametrize("seen", FOUND, ids=lambda seen: f"{type(seen.light).__name__} {seen.expected:.2g}")
def test_a_vertex_is_grey(seen: Seen, evaluator: Evaluator) -> None:
    arguments = [seen.p], [seen.n], Scene([seen.light], seen.viewer, seen.model), seen.material
    if seen.is_declined:
        options = {"precision": evaluator.precision, "backend": evaluator.backend}
        got = evaluate(*arguments, **options, matrix=seen.matrix).rgb
    else:
        got = evaluator(*arguments, matrix=seen.matrix).rgb
    allowed = seen.steps * evaluator.step * seen.expected + (1e-40 if seen.steps else 0.0)
    assert np.abs(got - seen.expected).max() <= allowed


@pytest.mark.parametrize("evaluator", EVALUATORS[:2], ids=str)
def test_products_with_a_short_way_may_be_as_small_as_floats_can_be(evaluator: Evaluator) -> None:
    """N·D was rounded to the smallest float, which depended on the unit of length."""
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


# --- plans ---


@pytest.mark.parametrize("size", [1e-300, 1e-170, 1e-160, 1e160, 1e300])
def test_a_plan_judges_normals_of_any_length(size: float) -> None:
    """Squares of the normals overflowed, with a warning, or underflowed, and the cone of normals was wrong."""
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


# --- moving the last vertex changes no bit of the others ---

AWAY: dict[str, Any] = {"position": (0.0, 0.0, 50.0), "direction": (0.0, 0.0, 1.0), "cone_angle": 30.0}
"""A spot that shines away from the mesh. A plan removes it, unless a vertex is not finite."""
GLOW = PointLight(position=(0.3, 1.1, 2.7), diffuse=0.0, ambient=0.9, attenuation=(0.1, 0.3, 0.2))
"""The only material here that needs no normals."""
EVERYWHERE = DirectionalLight(diffuse=0.0, ambient=0.1)
LAMP = PointLight(position=(0.3, 1.1, 2.7))
CLOUD, NORMALS = np.random.default_rng(0).normal(size=(2, 200, 3))
NARROW, WIDE = np.float32, np.float64
COLOURED = replace(WHITE, albedo=np.random.default_rng(1).random((200, 3)))


class Independent(NamedTuple):
    lights: list[Any]
    material: Material = WHITE
    points: Any = CLOUD
    normals: Any = NORMALS
    types: tuple[Any, Any] = (WIDE, WIDE)
    place: Any = np.nan


INDEPENDENT = [
    # Without normals the reference used float64, and the kernel the type of the points.
    *(
        Independent([SpotLight(**AWAY), light], material, types=types)
        for light, material in ((GLOW, WHITE), (EVERYWHERE, COLOURED))
        for types in ((NARROW, WIDE), (WIDE, NARROW), (NARROW, NARROW))
    ),
    # The kernel declines such lights, even if its plan would remove them.
    *(
        Independent([SpotLight(**AWAY | beyond), LAMP])
        for beyond in ({"attenuation": (1, 0, 1e-31)}, {"attenuation": (1e31, 0, 1)}, {"position": (0, 0, 1e31)})
    ),
    # A cone that contains the mesh, with the same factor to the last bit, was folded into the light's colours.
    *(
        Independent([SpotLight((0.2, 0.1, 1.0), DOWN, 40.0, exponent, diffuse=0.3), LAMP], WHITE, 0.01 * CLOUD, UP)
        for exponent in (1e-16, 1e-17, 3e5)
    ),
    # A plan removes a cone that contains all vertices; the kernel then multiplied by the strength at another point.
    *(
        Independent(
            [SpotLight((0.0, 0.0, 3.0), DOWN, 60.0, 0.0, (c, 0.0, 0.0))], material, 0.1 * CLOUD, UP, place=place
        )
        for c in (3.0, 0.7, 1e-5, 1e8)
        for material in (WHITE, replace(DULL, diffuse=0.9))
        for place in ((50.0, 0.0, 0.0), np.nan)
    ),
]


@on_every_evaluator
@pytest.mark.parametrize("case", INDEPENDENT, ids=lambda case: type(case.lights[-1]).__name__)
def test_no_vertex_depends_on_where_the_last_one_is(case: Independent, evaluator: Evaluator) -> None:
    elsewhere = case.points.copy()
    elsewhere[-1] = case.place
    normals = np.broadcast_to(case.normals, case.points.shape).astype(case.types[1])
    scene, options = Scene(case.lights, ABOVE, UNLIT), {"backend": evaluator.backend, "precision": evaluator.precision}
    before, after = (
        evaluate(points.astype(case.types[0]), normals, scene, case.material, **options).rgb[:-1]
        for points in (case.points, elsewhere)
    )
    assert before.any()
    assert np.array_equal(before, after)
