"""The oracle against closed forms worked out by hand, and against the plain formulas at 900 digits.

It is tried on plain namespaces, so that it is known to read the public fields and nothing else.
"""

from __future__ import annotations

import math
import random
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy as np
import pytest
from oracle import Shade, as_array, blinn_phong, ctx, exact, phong, shade, sum_of_roots, vtk_tier

COMMON = {"diffuse": (1.0, 1.0, 1.0), "specular": None, "ambient": 0.0, "intensity": 1.0, "on": True, "frame": "world"}
UP = (0.0, 0.0, 1.0)
ORIGIN = (0.0, 0.0, 0.0)
TIGHT = 1e-15  # the oracle's 80 digits rounded to float64, against a float64 literal


def directional(direction: Any, **fields: Any) -> SimpleNamespace:
    return SimpleNamespace(direction=direction, **(COMMON | fields))


def point(position: Any, attenuation: Any = (1.0, 0.0, 0.0), **fields: Any) -> SimpleNamespace:
    return SimpleNamespace(position=position, attenuation=attenuation, **(COMMON | fields))


def spot(position: Any, direction: Any, cone_angle: float, exponent: float, **fields: Any) -> SimpleNamespace:
    given = {"attenuation": (1.0, 0.0, 0.0)} | COMMON | fields
    return SimpleNamespace(position=position, direction=direction, cone_angle=cone_angle, exponent=exponent, **given)


def scene_of(
    *lights: Any, eye: Any = (0.0, 0.0, 5.0), focal: Any = ORIGIN, up: Any = (0.0, 1.0, 0.0), **model: Any
) -> Any:
    parallel = model.pop("parallel", False)
    defaults = {
        "ambient": 0.0,
        "local_viewer": True,
        "two_sided": False,
        "reflection": "phong",
        "clamp": True,
        "convention": "standard",
    }
    return SimpleNamespace(
        lights=lights,
        viewer=SimpleNamespace(position=eye, focal_point=focal, up=up, parallel=parallel),
        light_model=SimpleNamespace(**(defaults | model)),
    )


def material_of(**fields: Any) -> SimpleNamespace:
    defaults = {"ambient": 0.0, "diffuse": 0.0, "specular": 0.0, "shininess": 0.0, "emission": 0.0}
    return SimpleNamespace(**(defaults | fields))


def one(scene: Any, material: Any, p: Any = ORIGIN, n: Any = UP, **options: Any) -> Shade:
    (only,) = shade([p], [n], scene, material, **options)
    return only


def grey(scene: Any, material: Any, **options: Any) -> float:
    """The unclamped colour of one vertex, asserted to be grey."""
    red, green, blue = one(scene, material, **options).unclamped
    assert red == green == blue
    return float(red)


MATT = material_of(diffuse=1.0)
MIRROR = material_of(specular=1.0, shininess=3.0)


# --- diffuse ---


@pytest.mark.parametrize("degrees", [0, 30, 60, 85])
def test_lamberts_law(degrees: float) -> None:
    angle = math.radians(degrees)
    sun = directional((-math.sin(angle), 0.0, -math.cos(angle)))
    assert grey(scene_of(sun), MATT) == pytest.approx(math.cos(angle), abs=2e-16)


def test_light_from_behind_gives_nothing() -> None:
    assert grey(scene_of(directional((0.0, 0.0, 1.0))), material_of(diffuse=1.0, specular=1.0)) == 0


def test_lengths_of_directions_and_normals_do_not_matter() -> None:
    sun = directional((-3e-200, 0.0, -4e-200))
    assert grey(scene_of(sun), MATT, n=(0.0, 0.0, 1e200)) == pytest.approx(0.8, rel=TIGHT, abs=0)


def test_attenuation_at_pythagorean_distance() -> None:
    lamp = point((2.0, 3.0, 6.0), attenuation=(1.0, 2.0, 3.0))  # at distance 7, with n·l = 6/7
    assert grey(scene_of(lamp), MATT) == pytest.approx(6 / 7 / (1 + 14 + 147), rel=TIGHT, abs=0)


def test_intensity_and_attenuation_multiply_all_three_colours() -> None:
    lamp = point((0.0, 0.0, 2.0), (0.0, 1.0, 0.0), ambient=0.5, diffuse=0.25, specular=0.125, intensity=4.0)
    got = one(scene_of(lamp, eye=(0.0, 0.0, 2.0)), material_of(ambient=1.0, diffuse=1.0, specular=1.0, shininess=9.0))
    assert [float(c[0]) for c in (got.ambient, got.diffuse, got.specular)] == [1.0, 0.5, 0.25]
    assert float(got.per_light[0][0]) == 1.75


def test_specular_none_takes_the_diffuse_colour() -> None:
    sun = directional((0.0, 0.0, -1.0), diffuse=(0.5, 0.25, 0.125))
    assert as_array([one(scene_of(sun), MIRROR)], "specular").tolist() == [[0.5, 0.25, 0.125]]


def test_a_light_that_is_off_keeps_its_row_and_gives_nothing() -> None:
    got = one(scene_of(directional((0.0, 0.0, -1.0), on=False), directional((0.0, 0.0, -1.0))), MATT)
    assert [float(rgb[0]) for rgb in got.per_light] == [0.0, 1.0]
    assert as_array([got], "per_light").shape == (2, 1, 3)


def test_red_light_on_green_surface_is_exactly_black() -> None:
    red = directional((0.0, 0.0, -1.0), diffuse=(1.0, 0.0, 0.0))
    got = one(scene_of(red), material_of(diffuse=(0.0, 1.0, 0.0), specular=(0.0, 1.0, 0.0), shininess=5.0))
    assert as_array([got], "unclamped").tolist() == [[0.0, 0.0, 0.0]]


# --- spots ---


def spot_at(degrees: float, cone_angle: float, exponent: float, **fields: Any) -> Any:
    """A spot straight above the origin whose axis is tilted by an angle."""
    tilt = math.radians(degrees)
    return spot((0.0, 0.0, 4.0), (math.sin(tilt), 0.0, -math.cos(tilt)), cone_angle, exponent, **fields)


def test_spot_falls_off_as_a_power_of_the_cosine() -> None:
    lamp = spot((0.0, 0.0, 4.0), (3.0, 0.0, -4.0), 60.0, 2.0)
    assert grey(scene_of(lamp), MATT) == pytest.approx(0.64, rel=TIGHT, abs=0)


def test_outside_the_cone_even_the_lights_ambient_is_gone() -> None:
    material = material_of(ambient=1.0, diffuse=1.0, specular=1.0)
    assert grey(scene_of(spot_at(31, 30.0, 1.0, ambient=1.0)), material) == 0
    assert grey(scene_of(spot_at(29, 30.0, 0.0, ambient=1.0)), material) > 2.9


@pytest.mark.parametrize(
    ("axis", "cone_angle", "expected"),
    [((1.0, 0.0, -1.0), 45.0, 0.5), ((1.0, 1.0, 0.0), 90.0, 0.0)],
)
def test_the_edge_of_the_cone_is_inside(axis: Any, cone_angle: float, expected: float) -> None:
    got = one(scene_of(spot((0.0, 0.0, 4.0), axis, cone_angle, 2.0, ambient=1.0)), material_of(ambient=1.0))
    assert float(got.ambient[0]) == pytest.approx(expected, rel=TIGHT, abs=0)
    assert abs(got.lights[0].cone_margin) < 1e-70
    steeper = spot((0.0, 0.0, 4.0), axis, math.nextafter(cone_angle, 0.0), 2.0, ambient=1.0)
    assert float(one(scene_of(steeper), material_of(ambient=1.0)).ambient[0]) == 0


def test_a_spot_that_points_away_is_dark_however_narrow() -> None:
    assert grey(scene_of(spot((0.0, 0.0, 4.0), (0.0, 0.0, 1.0), 20.0, 0.0)), MATT) == 0


def test_right_angled_cone_with_exponent_zero_is_one_on_its_edge() -> None:
    lamp = spot((0.0, 0.0, 4.0), (1.0, 0.0, 0.0), 90.0, 0.0)
    assert grey(scene_of(lamp), MATT) == 1.0


def test_tiny_cones_are_decided_by_the_sine() -> None:
    tilt = 1e-150
    inside = math.nextafter(math.degrees(tilt), 1.0) * (1 + 1e-12)
    outside = math.degrees(tilt) * (1 - 1e-12)
    for cone_angle, expected in ((inside, 1.0), (outside, 0.0)):
        lamp = spot((0.0, 0.0, 4.0), (tilt, 0.0, -1.0), cone_angle, 1.0)
        assert grey(scene_of(lamp), MATT) == expected


# --- highlights ---


def test_mirror_direction_is_exactly_one() -> None:
    sun = directional((3.0, 0.0, -4.0))
    scene = scene_of(sun, eye=(3.0, 0.0, 4.0))
    assert grey(scene, material_of(specular=1.0, shininess=1e300)) == 1.0


@pytest.mark.parametrize("shininess", [0.5, 1.0, 7.0, 200.0])
def test_phong_is_the_power_of_the_mirror_cosine(shininess: float) -> None:
    sun = directional((-3.0, 0.0, -4.0))  # r = (−3, 0, 4)/5 and v = (0, 0, 1): the cosine is 4/5
    got = grey(scene_of(sun), material_of(specular=1.0, shininess=shininess))
    assert got == pytest.approx(0.8**shininess, rel=1e-13, abs=0)


def test_blinn_phong_sees_half_the_angle() -> None:
    sun = directional((-3.0, 0.0, -4.0))  # cos 2x = 4/5, so cos² x = 9/10
    got = grey(scene_of(sun, reflection="blinn-phong"), material_of(specular=1.0, shininess=4.0))
    assert got == pytest.approx(0.81, rel=TIGHT, abs=0)


def test_blinn_phong_with_opposite_light_and_viewer_takes_the_cosine_as_zero() -> None:
    """Only reachable with n·l > 0 where the viewer is behind the surface."""
    sun = directional((0.0, 0.0, -1.0))
    scene = scene_of(sun, eye=(0.0, 0.0, -7.0), reflection="blinn-phong")
    assert grey(scene, material_of(specular=1.0, shininess=1e-3)) == 0
    assert grey(scene, material_of(specular=1.0, shininess=0.0)) == 1


@pytest.mark.parametrize("reflection", ["phong", "blinn-phong"])
def test_shininess_zero_is_one_wherever_the_light_reaches(reflection: str) -> None:
    material = material_of(specular=1.0, shininess=0.0)
    facing = directional((-1.0, 0.0, -1.0))
    assert grey(scene_of(facing, eye=(1.0, 0.0, 1.0), reflection=reflection), material) == 1.0  # r·v = 0 exactly
    grazing = directional((-1.0, 0.0, 0.0))
    assert grey(scene_of(grazing, reflection=reflection), material) == 0.0
    assert grey(scene_of(directional((0.0, 0.0, 1.0)), reflection=reflection), material) == 0.0


def test_no_highlight_where_the_mirror_direction_looks_away() -> None:
    sun = directional((-1.0, 0.0, -1.0))
    assert grey(scene_of(sun, eye=(9.0, 0.0, 1.0)), material_of(specular=1.0, shininess=1e-3)) == 0.0


def test_infinite_and_parallel_viewers_are_constant() -> None:
    sun = directional((-3.0, 0.0, -4.0))
    for model in ({"local_viewer": False}, {"parallel": True}):
        scene = scene_of(sun, eye=(0.0, 0.0, 5.0), **model)
        got = grey(scene, MIRROR, p=(1e3, -1e3, 0.0))
        assert got == pytest.approx(0.8**3, rel=TIGHT, abs=0)
    local = grey(scene_of(sun), MIRROR, p=(1e3, -1e3, 0.0))
    assert abs(local - 0.8**3) > 0.1


# --- special vertices ---


ALL = material_of(ambient=0.5, diffuse=1.0, specular=1.0, shininess=2.0, emission=0.0625)


def test_zero_normal_keeps_ambient_and_emission_only() -> None:
    got = one(scene_of(directional((0.0, 0.0, -1.0), ambient=0.25), ambient=0.5, two_sided=True), ALL, n=ORIGIN)
    assert float(got.unclamped[0]) == 0.5 * (0.5 + 0.25) + 0.0625
    assert got.lights[0].n_dot_l is None


def test_light_on_the_vertex_leaves_its_ambient_over_c() -> None:
    lamp = point(ORIGIN, (4.0, 1.0, 1.0), ambient=1.0)
    assert grey(scene_of(lamp), ALL) == 0.5 / 4 + 0.0625
    assert grey(scene_of(point(ORIGIN, (0.0, 0.0, 1.0), ambient=1.0)), ALL) == 0.0625


def test_eye_on_the_vertex_keeps_diffuse_and_never_flips() -> None:
    sun = directional((0.0, 0.0, -1.0))
    got = one(scene_of(sun, eye=ORIGIN, focal=(0.0, 0.0, 9.0), two_sided=True), ALL)
    assert float(got.diffuse[0]) == 1.0
    assert float(got.specular[0]) == 0.0
    assert got.n_dot_v is None


def test_two_sided_lights_the_back_with_the_turned_normal() -> None:
    below = directional((0.0, 0.0, 1.0))
    scene = scene_of(below, eye=(0.0, 0.0, -5.0), two_sided=True)
    assert grey(scene, material_of(diffuse=1.0, specular=1.0, shininess=9.0)) == 2.0
    assert grey(scene_of(below, eye=(0.0, 0.0, -5.0)), ALL) == 0.0625
    infinite = scene_of(below, eye=(0.0, 0.0, 5.0), focal=(0.0, 0.0, 9.0), two_sided=True, local_viewer=False)
    assert grey(infinite, MATT) == 1.0


# --- colours ---


def test_one_clamp_at_the_end() -> None:
    material = material_of(ambient=1.0, diffuse=(1.0, 0.5, 0.0), emission=(0.0, 0.0, 0.25))
    got = one(scene_of(directional((0.0, 0.0, -1.0), intensity=3.0), ambient=0.5), material)
    assert [float(c) for c in got.unclamped] == [3.5, 2.0, 0.75]
    assert [float(c) for c in got.color] == [1.0, 1.0, 0.75]
    free = one(scene_of(directional((0.0, 0.0, -1.0), intensity=3.0), ambient=0.5, clamp=False), material)
    assert [float(c) for c in free.color] == [3.5, 2.0, 0.75]


def test_albedo_tints_ambient_and_diffuse_only() -> None:
    sun = directional((0.0, 0.0, -1.0))
    got = one(scene_of(sun, ambient=1.0), ALL, albedo=np.array([[0.5, np.nan, 300.0]]))
    assert as_array([got], "ambient").tolist() == [[0.25, 0.0, 0.5]]
    assert as_array([got], "diffuse").tolist() == [[0.5, 0.0, 1.0]]
    assert as_array([got], "specular").tolist() == [[1.0, 1.0, 1.0]]
    assert as_array([got], "emission").tolist() == [[0.0625] * 3]


# --- frames ---


def test_camera_frame_rides_along() -> None:
    """From (0, −5, 0) looking along +y with z up: right is +x, so eye (1, 2, −3) is world (1, −2, 2)."""
    looks = {"eye": (0.0, -5.0, 0.0), "focal": (0.0, 7.0, 0.0), "up": (0.0, 3.0, 2.0)}
    rides = point((1.0, 2.0, -3.0), (1.0, 2.0, 3.0), frame="camera")
    stays = point((1.0, -2.0, 2.0), (1.0, 2.0, 3.0))
    assert grey(scene_of(rides, **looks), ALL) == pytest.approx(grey(scene_of(stays, **looks), ALL), rel=TIGHT, abs=0)
    sun = directional((0.25, 0.5, -1.0), frame="camera")
    still = directional((0.25, 1.0, 0.5))
    for normal in ((0.0, -1.0, 0.0), (0.0, -1.0, -4.0), (-1.0, 0.0, 0.0)):
        moving = grey(scene_of(sun, **looks), MATT, n=normal)
        assert moving == pytest.approx(grey(scene_of(still, **looks), MATT, n=normal), rel=TIGHT, abs=0)


def test_headlight_shines_from_the_viewer() -> None:
    looks = {"eye": (3.0, 0.0, 4.0), "focal": (3.0, 0.0, -1.0)}
    lamp = spot((9.0, 9.0, 9.0), (9.0, 9.0, 9.0), 60.0, 1.0, frame="headlight")  # its own fields do not matter
    assert grey(scene_of(lamp, **looks), MATT) == pytest.approx(0.8 * 0.8, rel=TIGHT, abs=0)
    assert grey(scene_of(directional((9.0, 9.0, 9.0), frame="headlight"), **looks), MATT) == 1.0
    assert grey(scene_of(point((9.0, 9.0, 9.0), frame="headlight"), **looks), MATT) == pytest.approx(
        0.8, rel=TIGHT, abs=0
    )


# --- matrices ---


def matrix_of(linear: Any, offset: Any = ORIGIN, w: float = 1.0) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3], matrix[3, 3] = linear, offset, w
    return matrix


def test_shear_bends_normals_by_the_inverse_transpose() -> None:
    """x' = x + 2z turns the plane z = 0's normal not at all and x = 0's into (1, 0, −2)."""
    shear = matrix_of([[1.0, 0.0, 2.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    sun = directional((0.0, 0.0, 1.0))
    assert grey(scene_of(sun), MATT, n=(1.0, 0.0, 0.0), matrix=shear) == pytest.approx(
        2 / math.sqrt(5), rel=TIGHT, abs=0
    )
    assert grey(scene_of(directional((0.0, 0.0, -1.0))), MATT, matrix=shear) == 1.0


def test_mirrors_and_negative_w_keep_the_inverse_transposes_sign() -> None:
    for matrix in (matrix_of(np.diag([1.0, 1.0, -1.0])), matrix_of(np.diag([5.0, 5.0, 5.0]), w=-2.0)):
        assert grey(scene_of(directional((0.0, 0.0, 1.0))), MATT, matrix=matrix) == 1.0
        assert grey(scene_of(directional((0.0, 0.0, -1.0))), MATT, matrix=matrix) == 0.0
    side = matrix_of(np.diag([-1.0, 1.0, 1.0]))
    assert grey(scene_of(directional((0.0, 0.0, -1.0))), MATT, matrix=side) == 1.0


def test_points_are_divided_by_w_and_lights_stay() -> None:
    matrix = matrix_of(np.eye(3), (2.0, 0.0, 0.0), w=2.0)  # (1, 0, 0) goes to (1.5, 0, 0)
    lamp = point((1.5, 0.0, 2.0), (0.0, 1.0, 0.0))
    assert grey(scene_of(lamp), MATT, p=(1.0, 0.0, 0.0), matrix=matrix) == 0.5


@pytest.mark.parametrize("size", [1e-200, 1e-110, 1e110, 1e200])
def test_extreme_scales_only_turn_normals(size: float) -> None:
    quarter_turn = np.array([[0.0, -size, 0.0], [size, 0.0, 0.0], [0.0, 0.0, size]])
    sun = directional((-3.0, 0.0, -4.0))
    assert grey(scene_of(sun), MATT, n=(0.0, -1.0, 0.0), matrix=matrix_of(quarter_turn)) == pytest.approx(
        0.6, rel=TIGHT
    )


def test_flattened_mesh_takes_the_cofactor_direction() -> None:
    flat = matrix_of(np.diag([2.0, 3.0, 0.0]))
    assert grey(scene_of(directional((0.0, 0.0, -1.0))), MATT, n=(0.6, 0.0, 0.8), matrix=flat) == 1.0
    with pytest.raises(ValueError, match="rank"):
        shade([ORIGIN], [UP], scene_of(), MATT, matrix=matrix_of(np.diag([1.0, 0.0, 0.0])))


# --- VTK's tiers ---


def vtk_scene(*lights: Any, **model: Any) -> Any:
    return scene_of(*lights, convention="vtk", **model)


def test_vtk_tiers_follow_the_lights_that_vtk_counts() -> None:
    head = directional(UP, frame="headlight")
    black = directional(UP, diffuse=0.0)
    assert vtk_tier([]) == 0
    assert vtk_tier([directional(UP, on=False)]) == 0
    assert vtk_tier([head]) == 1
    assert vtk_tier([head, point(UP, on=False)]) == 3
    assert vtk_tier([head, directional(UP, on=False)]) == 2
    assert vtk_tier([directional(UP, on=False), head]) == 1
    assert vtk_tier([head, black]) == 2
    assert vtk_tier([directional((0.0, 0.0, -1.0), frame="camera")]) == 2
    assert vtk_tier([head, point(UP, intensity=0.0)]) == 3
    assert vtk_tier([spot(UP, UP, 20.0, 1.0, frame="headlight")]) == 3


def test_vtk_tier_1_ignores_the_eyes_place_and_never_goes_dark() -> None:
    head = directional(UP, frame="headlight", intensity=0.5)
    material = material_of(ambient=0.25, diffuse=1.0, specular=1.0, shininess=2.0)
    got = one(vtk_scene(head, eye=(9.0, 9.0, 5.0), focal=(9.0, 9.0, 0.0)), material, n=(3.0, 0.0, 4.0))
    assert float(got.ambient[0]) == 0.25
    assert float(got.diffuse[0]) == pytest.approx(0.4, rel=TIGHT, abs=0)
    assert float(got.specular[0]) == pytest.approx(0.32, rel=TIGHT, abs=0)
    behind = one(vtk_scene(head), material, n=(0.0, 0.0, -1.0))
    assert float(behind.diffuse[0]) == pytest.approx(0.5e-6, rel=TIGHT, abs=0)
    assert float(behind.specular[0]) == pytest.approx(0.5e-12, rel=TIGHT, abs=0)


def test_vtk_tier_2_floors_the_mirror_cosine() -> None:
    sun = directional((-1.0, 0.0, -1.0), specular=0.0, ambient=1.0)  # both ignored by VTK
    material = material_of(ambient=0.5, specular=1.0, shininess=0.1)
    got = one(vtk_scene(sun, eye=(9.0, 0.0, 1.0)), material)
    assert float(got.specular[0]) == pytest.approx(1e-5**0.1, rel=TIGHT, abs=0)
    assert float(got.ambient[0]) == 0.5
    assert float(one(vtk_scene(sun), material, n=(0.0, 0.0, -1.0)).specular[0]) == 0


def test_vtk_keeps_a_local_viewer_in_parallel_projection() -> None:
    sun = directional((-3.0, 0.0, -4.0))
    scene = vtk_scene(sun, eye=(-3.0, 0.0, 4.0), focal=(-3.0, 0.0, 0.0), parallel=True, reflection="blinn-phong")
    assert grey(scene, MIRROR) == 1.0


def test_vtk_tier_3_attenuates_diffuse_and_specular() -> None:
    lamp = point((0.0, 3.0, 4.0), (0.0, 1.0, 0.0))
    got = one(vtk_scene(lamp, directional((0.0, 0.0, -1.0))), material_of(diffuse=1.0, specular=1.0, shininess=2.0))
    assert float(got.per_light[0][0]) == pytest.approx(0.2 * (0.8 + 0.64), rel=TIGHT, abs=0)
    assert float(got.per_light[1][0]) == 2.0


def test_vtk_albedo_tints_ambient_and_diffuse_only() -> None:
    got = one(vtk_scene(directional((0.0, 0.0, -1.0))), ALL, albedo=np.array([[0.5, 0.25, 1.0]]))
    assert as_array([got], "unclamped").tolist() == [[1.0625 + 0.75, 1.0625 + 0.375, 1.0625 + 1.5]]


def test_vtk_spots() -> None:
    scene = vtk_scene(spot((0.0, 0.0, 4.0), (3.0, 0.0, -4.0), 40.0, 2.0))
    assert grey(scene, MATT) == pytest.approx(0.64, rel=TIGHT, abs=0)
    assert grey(vtk_scene(spot((0.0, 0.0, 4.0), (3.0, 0.0, -4.0), 36.0, 2.0)), MATT) == 0
    assert grey(vtk_scene(spot((0.0, 0.0, 4.0), (0.0, 0.0, 1.0), 90.0, 2.0)), MATT) == 1.0  # a point light


def test_vtk_clamps_powers_to_128() -> None:
    sun = directional((-3.0, 0.0, -4.0))
    material = material_of(specular=1.0, shininess=1e6)
    assert grey(vtk_scene(sun), material) == pytest.approx(0.8**128, rel=1e-13, abs=0)
    lamp = spot((0.0, 0.0, 4.0), (3.0, 0.0, -4.0), 60.0, 1e6)
    assert grey(vtk_scene(lamp), MATT) == pytest.approx(0.8**128, rel=1e-13, abs=0)


def test_vtk_two_sided_turns_to_the_eye_or_to_the_view_plane() -> None:
    sun = directional((0.0, 0.0, 1.0))
    assert grey(vtk_scene(sun, eye=(0.0, 0.0, -5.0), two_sided=True), MATT) == 1.0
    assert grey(vtk_scene(sun, eye=(0.0, 0.0, -5.0)), MATT) == 0.0
    aside = {"eye": (0.0, 0.0, -5.0), "focal": (0.0, 0.0, -9.0), "two_sided": True}
    assert grey(vtk_scene(sun, **aside), MATT) == 1.0
    assert grey(vtk_scene(sun, parallel=True, **aside), MATT) == 0.0


def test_vtk_without_lights_is_unlit_ambient_plus_diffuse() -> None:
    """Seen in VTK's own pictures: 179/255 for 0.3 + 0.4 on white, against 76/255 for a light of intensity 0."""
    material = material_of(ambient=0.25, diffuse=0.5, specular=1.0, emission=0.125)
    for lights in ((), (directional((0.0, 0.0, -1.0), on=False),)):
        assert grey(vtk_scene(*lights), material) == 0.875
    assert grey(vtk_scene(directional((0.0, 0.0, -1.0), intensity=0.0)), material) == 0.375


# --- the forms that do not cancel, against the plain formulas at 900 digits ---


def plain_lobes(n: Any, to_light: Any, v: Any, shininess: float) -> tuple[Any, Any]:
    """Phong and Blinn-Phong exactly as the page writes them, with every vector normalised first."""
    many = mpmath.MPContext()
    many.dps = 900
    n, to_light, v = (_normalized(many, w) for w in (n, to_light, v))
    n_dot_l = sum(a * b for a, b in zip(n, to_light, strict=True))
    r = [2 * n_dot_l * a - b for a, b in zip(n, to_light, strict=True)]
    h = _normalized(many, [a + b for a, b in zip(to_light, v, strict=True)])
    cosines = (sum(a * b for a, b in zip(r, v, strict=True)), sum(a * b for a, b in zip(n, h, strict=True)))
    phong_lobe, blinn_lobe = (max(c, 0) ** many.mpf(shininess) for c in cosines)
    return phong_lobe, blinn_lobe


def _normalized(many: Any, w: Any) -> list[Any]:
    w = [many.mpf(x) for x in w]
    length = many.sqrt(sum(x * x for x in w))
    return [x / length for x in w]


def random_vector(dice: random.Random, spread: int) -> tuple[float, float, float]:
    x, y, z = (math.ldexp(dice.uniform(-1, 1), dice.randint(-spread, spread)) for _ in range(3))
    return x, y, z


@pytest.mark.parametrize("spread", [0, 20, 250])
def test_lobes_agree_with_the_plain_formulas(spread: int) -> None:
    dice = random.Random(spread)
    for _ in range(40):
        n, to_light = random_vector(dice, spread), random_vector(dice, spread)
        v = to_light if dice.random() < 0.2 else random_vector(dice, spread)
        if dice.random() < 0.2:
            v = tuple(-x * (1 + 1e-15 * dice.random()) for x in to_light)
        shininess = 10.0 ** dice.uniform(-2, 5)
        expected = plain_lobes(n, to_light, v, shininess)
        got = [lobe(exact(n), exact(to_light), exact(v), shininess)[1] for lobe in (phong, blinn_phong)]
        for a, b in zip(got, expected, strict=True):
            assert abs(a - ctx.mpf(b)) <= ctx.mpf("1e-65") * ctx.mpf(b), (n, to_light, v, shininess)


def test_sums_of_roots_survive_cancellation() -> None:
    a, b = Fraction(10**40 + 1), Fraction(-(10**40))
    many = mpmath.MPContext()
    many.dps = 300
    expected = many.mpf(int(a)) / many.sqrt(2) + many.mpf(int(b)) / many.sqrt(2)
    got = sum_of_roots(a, Fraction(2), b, Fraction(2))
    assert abs(got - ctx.mpf(expected)) < ctx.mpf("1e-75")


def test_non_finite_vertices_are_refused() -> None:
    for bad in (math.nan, math.inf):
        with pytest.raises((ValueError, OverflowError)):
            shade([(bad, 0.0, 0.0)], [UP], scene_of(), MATT)
