"""The NumPy evaluator against the oracle, and the model's claims one by one."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from judging import STEP, coefficient, judge
from oracle import shade
from strategies import MATRIX_CLASSES, Case, Dice, hard_case, hunt, matrix_of, moderate_case

from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.optics.material import Material
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading.evaluation import evaluate

CONVENTIONS = ("standard", "vtk")
PRECISIONS = ("float64", "float32")
EXAMPLES = 60  # of each convention in each precision
MANY = 10_000
FLATTENED = pytest.mark.filterwarnings("ignore:The matrix flattens")

ORIGIN = np.zeros((1, 3))
UP = np.array([[0.0, 0.0, 1.0]])
ABOVE = Viewer(position=(0.0, 0.0, 5.0))
DARK = LightModel(ambient=0.0)


def evaluated(case: Case, precision: str, *, components: bool = True) -> Any:
    return evaluate(*case.arguments, **case.options, precision=precision, backend="numpy", components=components)


@dataclass
class Tally:
    vertices: int = 0
    left_out: int = 0

    def judge(self, case: Case, precision: str, **options: float) -> None:
        judgement = judge(case, evaluated(case, precision), precision, **options)
        assert judgement.worst <= 1, judgement.report
        self.vertices += judgement.vertices
        self.left_out += judgement.left_out


# --- every ordinary scene ---


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_ordinary_scenes_agree_with_the_oracle(convention: str, precision: str) -> None:
    _agrees_with_the_oracle(convention, precision, EXAMPLES)


@pytest.mark.long
@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_very_many_ordinary_scenes_agree_with_the_oracle(convention: str, precision: str) -> None:
    _agrees_with_the_oracle(convention, precision, MANY)


def _agrees_with_the_oracle(convention: str, precision: str, examples: int) -> None:
    """The bound and what is left out are stated in `judging`."""
    tally = Tally()
    dtype = np.dtype(precision).type
    hunt(
        lambda dice: moderate_case(dice, convention),
        lambda case: tally.judge(case.stored_in(dtype), precision),
        examples,
    )
    assert tally.vertices > examples
    assert tally.left_out < 0.05 * tally.vertices


# --- hard scenes ---


@FLATTENED
@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_hard_scenes_stay_finite(convention: str, precision: str) -> None:
    hunt(lambda dice: hard_case(dice, convention), lambda case: _stays_finite(case, precision), EXAMPLES)


@FLATTENED
@pytest.mark.long
@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_very_many_hard_scenes_stay_finite(convention: str, precision: str) -> None:
    hunt(lambda dice: hard_case(dice, convention), lambda case: _stays_finite(case, precision), MANY)


def _stays_finite(case: Case, precision: str) -> None:
    rgb = evaluated(case, precision, components=False).rgb
    assert rgb.dtype == precision
    assert np.isfinite(rgb).all()
    assert (rgb >= 0).all()
    assert not case.scene.light_model.clamp or (rgb <= 1).all()


@FLATTENED
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_hard_scenes_agree_with_the_oracle_where_they_are_well_posed(convention: str) -> None:
    """Coordinates over 240 binary orders of magnitude, lights of ordinary strength.

    Rows with a NaN or an infinity are judged by what they leave alone: all other vertices. A vertex whose geometry
    is conditioned worse than 10⁶, or that lies in an undecidable band, is left out.
    """
    tally = Tally()

    def check(case: Case) -> None:
        finite = np.isfinite(case.points).all(axis=1) & np.isfinite(case.normals).all(axis=1)
        if not finite.any():
            return
        lights = [_of_ordinary_strength(light) for light in case.scene.lights]
        case = replace(case, scene=replace(case.scene, lights=lights))
        everything = evaluated(case, "float64")
        kept = {name: _rows(getattr(everything, name), finite) for name in everything.__dataclass_fields__}
        case = replace(case, points=case.points[finite], normals=case.normals[finite])
        judgement = judge(case, replace(everything, **kept), "float64", badly_posed=1e6)
        assert judgement.worst <= 1, judgement.report
        tally.vertices += judgement.vertices
        tally.left_out += judgement.left_out

    hunt(lambda dice: hard_case(dice, convention, reach=120), check, 2 * EXAMPLES)
    assert tally.vertices - tally.left_out > EXAMPLES


def _rows(a: np.ndarray | None, keep: np.ndarray) -> np.ndarray | None:
    return None if a is None else a[..., keep, :]


def _of_ordinary_strength(light: Any) -> Any:
    light = replace(light, intensity=1.0)
    return replace(light, attenuation=(1.0, 0.25, 0.0)) if hasattr(light, "attenuation") else light


# --- OpenGL's equation ---


def one(scene: Scene, material: Material, precision: str = "float64", n: np.ndarray = UP, **options: Any) -> Any:
    """A vertex at the origin, with components."""
    return evaluate(ORIGIN, n, scene, material, precision=precision, backend="numpy", components=True, **options)


@pytest.mark.parametrize("precision", PRECISIONS)
def test_attenuation_and_spot_multiply_the_lights_ambient_too(precision: str) -> None:
    """OpenGL 2.1, section 2.14.1: the sum over lights of att · spot · (ambient + diffuse + specular)."""
    lamp = SpotLight(
        position=(0.0, 0.0, 2.0),
        direction=(3.0, 0.0, -4.0),  # the axis is tilted by acos(4/5)
        cone_angle=60.0,
        exponent=2.0,
        attenuation=(1.0, 1.0, 0.25),  # 1/4 at distance 2
        ambient=0.5,
        diffuse=0.25,
        specular=0.75,
        intensity=2.0,
    )
    got = one(Scene([lamp], ABOVE, DARK), Material(ambient=1.0, diffuse=1.0, specular=1.0, shininess=7.0), precision)
    reaching = 2.0 * 0.64 / 4
    for name, light in (("ambient", 0.5), ("diffuse", 0.25), ("specular", 0.75)):
        assert getattr(got, name) == pytest.approx(reaching * light, rel=8 * STEP[precision], abs=0)
    outside = replace(lamp, cone_angle=36.0)
    assert not one(Scene([outside], ABOVE, DARK), Material(ambient=1.0, specular=1.0), precision).per_light.any()


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("reflection", ["phong", "blinn-phong"])
def test_red_light_on_a_green_surface_is_exactly_black(reflection: str, precision: str) -> None:
    red = DirectionalLight(direction=(0.0, 0.0, -1.0), diffuse=(1.0, 0.0, 0.0), ambient=(1.0, 0.0, 0.0))
    green = Material(ambient=(0.0, 1.0, 0.0), diffuse=(0.0, 1.0, 0.0), specular=(0.0, 1.0, 0.0), shininess=9.0)
    model = LightModel(ambient=(1.0, 0.0, 1.0), reflection=reflection)
    assert one(Scene([red], ABOVE, model), green, precision).rgb.tolist() == [[0.0, 0.0, 0.0]]


@pytest.mark.parametrize("precision", PRECISIONS)
def test_the_sum_is_clamped_once_and_only_if_asked(precision: str) -> None:
    """A light brighter than 1 lights a dark surface in full: clamped before the product, red would be 0.375."""
    bright = DirectionalLight(direction=(0.0, 0.0, -1.0), diffuse=(2.5, 0.25, 0.0))
    material = Material(ambient=0.25, diffuse=0.25, emission=(0.0, 0.0, 0.125))
    for count, free in ((1, [0.75, 0.1875, 0.25]), (2, [1.375, 0.25, 0.25])):
        for clamp in (True, False):
            scene = Scene([bright] * count, ABOVE, LightModel(ambient=0.5, clamp=clamp))
            got = one(scene, material, precision)
            assert got.rgb.tolist() == [[min(c, 1.0) for c in free] if clamp else free]
            total = got.ambient + got.diffuse + got.specular + got.emission
            assert total.tolist() == [free]
            assert got.per_light[:, 0].tolist() == [[0.625, 0.0625, 0.0]] * count


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_components_and_lights_add_up_to_the_unclamped_colour(convention: str) -> None:
    """Within four float32 steps of the largest summand."""

    def check(case: Case) -> None:
        case = replace(case, scene=replace(case.scene, light_model=replace(case.scene.light_model, clamp=False)))
        got = evaluated(case.stored_in(np.float32), "float32")
        size = np.max([np.ones_like(got.rgb), got.ambient, got.diffuse, got.specular, got.rgb], axis=0)
        by_kind = got.ambient + got.diffuse + got.specular + got.emission
        assert (np.abs(by_kind - got.rgb) <= 4 * 2.0**-23 * size).all()
        by_light = got.base + got.per_light.sum(axis=0)
        assert (np.abs(by_light - got.rgb) <= 4 * 2.0**-23 * size).all()

    hunt(lambda dice: moderate_case(dice, convention), check, EXAMPLES)


def test_without_components_there_is_the_colour_alone() -> None:
    case = sample_case(3)
    got = evaluated(case, "float32", components=False)
    assert (got.rgb == evaluated(case, "float32").rgb).all()
    assert got.ambient is got.diffuse is got.specular is got.emission is got.per_light is None


# --- frames ---

# From (0, −5, 0) looking along +y with z up, right is +x: eye coordinates (x, y, z) are the world's (x, −5 − z, y).
ASIDE = Viewer(position=(0.0, -5.0, 0.0), focal_point=(0.0, 7.0, 0.0), up=(0.0, 3.0, 2.0))
SHINY = Material(ambient=0.5, diffuse=0.75, specular=0.5, shininess=3.0)


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize(
    ("riding", "standing"),
    [
        (
            SpotLight(position=(1.0, 2.0, -3.0), direction=(0.5, 1.0, -2.0), cone_angle=70.0, frame="camera"),
            SpotLight(position=(1.0, -2.0, 2.0), direction=(0.5, 2.0, 1.0), cone_angle=70.0),
        ),
        (
            DirectionalLight(direction=(0.5, 1.0, -2.0), frame="camera"),
            DirectionalLight(direction=(0.5, 2.0, 1.0)),
        ),
        (
            PointLight(position=(9.0, 9.0, 9.0), attenuation=(1.0, 0.25, 0.0), frame="headlight"),
            PointLight(position=(0.0, -5.0, 0.0), attenuation=(1.0, 0.25, 0.0)),
        ),
        (
            SpotLight(position=(9.0, 9.0, 9.0), direction=(9.0, 9.0, 9.0), cone_angle=40.0, frame="headlight"),
            SpotLight(position=(0.0, -5.0, 0.0), direction=(0.0, 1.0, 0.0), cone_angle=40.0),
        ),
        (
            DirectionalLight(direction=(9.0, 9.0, 9.0), frame="headlight"),
            DirectionalLight(direction=(0.0, 1.0, 0.0)),
        ),
    ],
    ids=lambda light: f"{type(light).__name__}-{light.frame}",
)
def test_lights_ride_along_with_the_viewer(riding: Any, standing: Any, precision: str) -> None:
    points = np.array([[0.5, 1.0, -0.5], [-0.25, 2.0, 1.0]])
    normals = np.array([[0.25, -1.0, 0.125], [0.5, -0.25, 0.75]])
    got, expected = (
        evaluate(points, normals, Scene([light], ASIDE, DARK), SHINY, precision=precision, backend="numpy").rgb
        for light in (riding, standing)
    )
    assert expected.max() > 0.1
    np.testing.assert_allclose(got, expected, rtol=0, atol=32 * STEP[precision])


# --- the same bits ---


def sample_case(seed: int, count: int = 64) -> Case:
    """A cloud of vertices under three lights, with a matrix and an albedo."""
    dice = np.random.default_rng(seed)
    lights = [
        DirectionalLight(direction=(-1.0, -2.0, -3.0), diffuse=0.5),
        PointLight(position=(2.0, 1.0, 2.0), attenuation=(0.5, 0.25, 0.125), frame="camera"),
        SpotLight(position=(0.0, 3.0, 3.0), direction=(0.0, -1.0, -1.0), cone_angle=60.0, exponent=4.0),
    ]
    scene = Scene(lights, Viewer(position=(1.0, 2.0, 6.0)), LightModel(two_sided=True))
    matrix = np.array([[1.0, 0.25, 0.0, 0.5], [0.0, -1.5, 0.0, 0.0], [0.125, 0.0, 1.0, -0.5], [0.0, 0.0, 0.0, 1.0]])
    points, normals = dice.normal(size=(2, count, 3))
    material = Material(specular=(0.25, 0.5, 0.75), shininess=20.0)
    return Case(points, normals, scene, material, matrix, dice.uniform(size=(count, 3)))


def bits(case: Case, precision: str) -> bytes:
    return bytes(evaluated(case, precision, components=False).rgb.tobytes())


@pytest.mark.parametrize("precision", PRECISIONS)
def test_strided_and_read_only_inputs_give_the_same_bits_and_stay_as_they_were(precision: str) -> None:
    case = sample_case(1)
    expected = bits(case, precision)
    for change in (np.asfortranarray, _strided, _reversed_view, _read_only):
        changed = replace(case, points=change(case.points), normals=change(case.normals), albedo=change(case.albedo))
        assert bits(changed, precision) == expected, change.__name__
        for name in ("points", "normals", "albedo"):
            assert (getattr(changed, name) == getattr(case, name)).all()


def _strided(a: np.ndarray) -> np.ndarray:
    wide = np.full((2 * len(a), 7), np.nan)
    wide[::2, 1::2] = a
    return wide[::2, 1::2]


def _reversed_view(a: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(a[::-1, ::-1])[::-1, ::-1]


def _read_only(a: np.ndarray) -> np.ndarray:
    copy = a.copy()
    copy.setflags(write=False)
    return copy


@pytest.mark.parametrize("precision", PRECISIONS)
def test_permuted_vertices_give_the_same_bits(precision: str) -> None:
    case = sample_case(2)
    order = np.random.default_rng(0).permutation(len(case.points))
    assert case.albedo is not None
    permuted = replace(case, points=case.points[order], normals=case.normals[order], albedo=case.albedo[order])
    expected = evaluated(case, precision).rgb[order]
    assert bits(permuted, precision) == expected.tobytes()


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("exponent", [-40, -3, 5, 40])
def test_scaling_by_a_power_of_two_changes_no_bit(exponent: int, precision: str) -> None:
    """The whole scene, with the attenuation per length and per area scaled to match; normals by another power."""
    case = sample_case(4)
    scale = 2.0**exponent
    lights = []
    for light in case.scene.lights:
        if hasattr(light, "attenuation"):
            c, linear, quadratic = light.attenuation
            position = tuple(scale * x for x in light.position)
            light = replace(light, position=position, attenuation=(c, linear / scale, quadratic / scale**2))
        lights.append(light)
    viewer = replace(
        case.scene.viewer,
        position=tuple(scale * x for x in case.scene.viewer.position),
        focal_point=tuple(scale * x for x in case.scene.viewer.focal_point),
    )
    assert case.matrix is not None
    matrix = case.matrix.copy()
    matrix[:3, 3] *= scale
    scene = Scene(lights, viewer, case.scene.light_model)
    scaled = replace(case, points=case.points * scale, normals=case.normals / scale, scene=scene, matrix=matrix)
    assert bits(scaled, precision) == bits(case, precision)


@pytest.mark.parametrize("kind", MATRIX_CLASSES)
def test_an_identity_matrix_or_a_unit_albedo_changes_nothing(kind: str) -> None:
    plain = replace(sample_case(5), matrix=matrix_of(Dice(5), kind), albedo=None)
    assert bits(plain, "float64") == bits(replace(plain, albedo=np.ones_like(plain.points)), "float64")
    if kind == "none":
        assert bits(plain, "float64") == bits(replace(plain, matrix=np.eye(4)), "float64")


# --- vertices on which something sits ---


GLOWING = Material(ambient=0.5, diffuse=1.0, specular=1.0, shininess=4.0, emission=0.0625)


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("reflection", ["phong", "blinn-phong"])
def test_a_light_on_the_vertex_leaves_its_ambient_over_c(reflection: str, precision: str) -> None:
    model = LightModel(ambient=0.0, reflection=reflection)
    for attenuation, expected in (((4.0, 1.0, 1.0), 0.5 / 4), ((0.0, 0.0, 1.0), 0.0), ((0.0, 1.0, 0.0), 0.0)):
        lamp = PointLight(position=(0.0, 0.0, 0.0), attenuation=attenuation, ambient=1.0)
        got = one(Scene([lamp], ABOVE, model), GLOWING, precision)
        assert got.per_light.tolist() == [[[expected] * 3]]
        assert got.rgb.tolist() == [[expected + 0.0625] * 3]


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize(("cone_angle", "exponent"), [(20.0, 1.0), (75.0, 2.0), (90.0, 2.0)])
def test_a_spot_on_the_vertex_does_not_shine_on_it(cone_angle: float, exponent: float, precision: str) -> None:
    """There l is the zero vector, so the cosine with the axis is 0: outside the cone, or on its edge with 0ⁿ = 0."""
    lamp = SpotLight(
        position=(0.0, 0.0, 0.0), direction=(0.0, 0.0, -1.0), cone_angle=cone_angle, exponent=exponent, ambient=1.0
    )
    assert not one(Scene([lamp], ABOVE, DARK), GLOWING, precision).per_light.any()


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize(
    ("height", "attenuation"),
    [(1e-170, (0.0, 0.0, 1.0)), (1e-200, (0.0, 1e-200, 0.0)), (1.0, (1e-310, 0.0, 0.0))],
    ids=["distance-squared-underflows", "linear-term-underflows", "inverse-overflows"],
)
def test_an_attenuation_beyond_the_floats_is_white_inside_the_cone_and_dark_outside(
    height: float, attenuation: tuple[float, float, float], precision: str
) -> None:
    """1/(c + l·d + q·d²) overflows there; times the 0 of a spot's outside it must not become NaN."""
    points = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.0, height]])
    normals = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]])
    above = {"position": (0.0, 0.0, height), "attenuation": attenuation}
    matte = Material(ambient=0.0, diffuse=1.0)
    for light, expected in ((PointLight(**above), 1.0), (SpotLight(direction=(1.0, 0.0, 0.0), **above), 0.0)):
        scene = Scene([light], ABOVE, DARK)
        got = evaluate(points, normals, scene, matte, precision=precision, backend="numpy").rgb
        assert np.isfinite(got).all()
        assert got[0].tolist() == [expected] * 3


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("reflection", ["phong", "blinn-phong"])
def test_an_eye_on_the_vertex_sees_diffuse_light_and_no_highlight(reflection: str, precision: str) -> None:
    for shininess in (0.0, 4.0):
        model = LightModel(ambient=0.0, two_sided=True, reflection=reflection)
        eye = Viewer(position=(0.0, 0.0, 0.0), focal_point=(0.0, 0.0, 1.0))
        scene = Scene([DirectionalLight(direction=(0.0, 0.0, -1.0), diffuse=0.5)], eye, model)
        got = one(scene, replace(GLOWING, shininess=shininess), precision)
        assert got.diffuse.tolist() == [[0.5] * 3]
        assert got.specular.tolist() == [[0.0] * 3]


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_a_zero_normal_keeps_ambient_and_emission(convention: str, precision: str) -> None:
    model = replace(LightModel.vtk() if convention == "vtk" else LightModel(two_sided=True), ambient=0.5)
    lights = [
        DirectionalLight(direction=(0.0, 0.0, -1.0), ambient=0.25),
        PointLight(position=(0.0, 0.0, 2.0), ambient=0.125),
    ]
    got = one(Scene(lights, ABOVE, model), GLOWING, precision, n=np.zeros((1, 3)))
    ambient = 0.5 if convention == "vtk" else 0.5 * (0.5 + 0.25 + 0.125)
    assert got.ambient.tolist() == [[ambient] * 3]
    assert not got.diffuse.any()
    assert not got.specular.any()
    assert got.rgb.tolist() == [[ambient + 0.0625] * 3]


@pytest.mark.parametrize("precision", PRECISIONS)
def test_a_zero_normal_is_unlit_under_vtks_single_headlight_too(precision: str) -> None:
    """Tier 1's floor of 10⁻⁶ is for normals that look away, not for those that do not exist (catalogue row 17)."""
    scene = Scene([DirectionalLight(frame="headlight")], ABOVE, LightModel.vtk())
    got = one(scene, GLOWING, precision, n=np.zeros((1, 3)))
    assert got.rgb.tolist() == [[0.5 + 0.0625] * 3]


# --- highlights ---


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("reflection", ["phong", "blinn-phong"])
def test_normal_light_and_viewer_in_one_direction_shine_at_exactly_one(reflection: str, precision: str) -> None:
    """Naively 22 % of float32 directions give a mirror cosine above 1, and up to 2.045 at a shininess of 10⁶."""
    dice = np.random.default_rng(7)
    for normal in dice.normal(size=(50, 3)).astype(precision).astype(np.float64):
        viewer = Viewer(position=tuple(normal), focal_point=(0.0, 0.0, 0.0))
        model = LightModel(ambient=0.0, reflection=reflection, local_viewer=False)
        scene = Scene([DirectionalLight(direction=tuple(-normal))], viewer, model)
        material = Material(diffuse=0.0, ambient=0.0, specular=1.0, shininess=1e6)
        got = one(scene, material, precision, n=normal[None].astype(precision))
        assert got.specular.tolist() == [[1.0, 1.0, 1.0]]


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("reflection", ["phong", "blinn-phong"])
def test_shininess_zero_is_one_where_the_light_reaches(reflection: str, precision: str) -> None:
    model = LightModel(ambient=0.0, reflection=reflection)
    matte = Material(diffuse=0.0, ambient=0.0, specular=1.0, shininess=0.0)
    for direction, expected in (((-1.0, 0.0, -1.0), 1.0), ((0.0, 0.0, 1.0), 0.0), ((1.0, 0.0, 0.0), 0.0)):
        viewer = Viewer(position=(1.0, 0.0, 1.0))  # the mirror direction of the first light is at a right angle
        scene = Scene([DirectionalLight(direction=direction)], viewer, model)
        assert one(scene, matte, precision).rgb.tolist() == [[expected] * 3]


def test_blinn_phong_gives_nothing_where_light_and_viewer_are_opposite() -> None:
    """h does not exist there; n·l > 0 because one-sided lighting shows the back as the front is lit.

    Shininess 0 is 1 wherever n·l > 0, as everywhere (catalogue row 36).
    """
    scene = Scene(
        [DirectionalLight(direction=(0.0, 0.0, -1.0))],
        Viewer(position=(0.0, 0.0, -3.0)),
        LightModel(ambient=0.0, reflection="blinn-phong"),
    )
    for shininess, expected in ((0.0, 1.0), (0.01, 0.0), (3.0, 0.0)):
        got = one(scene, Material(ambient=0.0, specular=1.0, shininess=shininess))
        assert got.specular.tolist() == [[expected] * 3]
        assert got.diffuse.tolist() == [[0.8] * 3]


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("shininess", [0.01, 0.1, 0.5])
def test_vtks_floor_under_the_mirror_cosine_is_the_stated_one(shininess: float, precision: str) -> None:
    """Catalogue row 37: within 10 half steps of (10⁻⁵)ⁿ."""
    scene = Scene(
        [DirectionalLight(direction=(-1.0, 0.0, -1.0))],
        Viewer(position=(9.0, 0.0, 1.0)),  # the mirror direction looks away
        LightModel.vtk(two_sided=False),
    )
    got = one(scene, Material(ambient=0.0, diffuse=0.0, specular=1.0, shininess=shininess), precision)
    assert np.abs(got.rgb - 1e-5**shininess).max() <= 10 * STEP[precision]
    standard = replace(scene, light_model=DARK)
    assert not one(standard, Material(diffuse=0.0, specular=1.0, shininess=shininess), precision).rgb.any()


# --- VTK's tiers ---


@pytest.mark.parametrize("precision", PRECISIONS)
def test_a_black_second_light_changes_vtks_tier(precision: str) -> None:
    """Tier 1 takes the viewer at infinity, tier 2 at the eye; so a highlight seen from aside differs."""
    head = DirectionalLight(frame="headlight")
    black = DirectionalLight(direction=(1.0, 0.0, 0.0), diffuse=0.0)
    off = replace(black, on=False)
    viewer = Viewer(position=(3.0, 0.0, 4.0), focal_point=(3.0, 0.0, 0.0))
    material = Material(ambient=0.0, diffuse=0.0, specular=1.0, shininess=2.0)
    got = [
        float(one(Scene(lights, viewer, LightModel.vtk()), material, precision).rgb[0, 0])
        for lights in ([head], [head, black], [head, off], [off, head])
    ]
    # VTK counts a light that is off, too, if it comes after the headlight
    assert got == pytest.approx([1.0, 0.64, 0.64, 1.0], rel=8 * STEP[precision], abs=0)


@pytest.mark.parametrize("precision", PRECISIONS)
def test_vtk_draws_a_mesh_without_lights_unlit(precision: str) -> None:
    """Measured: ambient 0.3 and diffuse 0.4 on white draw 179/255."""
    for lights in ([], [DirectionalLight(on=False)]):
        got = one(Scene(lights, ABOVE, LightModel.vtk()), Material(ambient=0.25, diffuse=0.5), precision)
        assert got.rgb.tolist() == [[0.75] * 3]


# --- the judge itself can find fault ---


@pytest.mark.parametrize("precision", PRECISIONS)
def test_the_judge_finds_a_wrong_last_digit(precision: str) -> None:
    """A colour that is off by a hundred times its bound is reported, whichever field it is in."""
    dice = random.Random(5)
    case = replace(sample_case(6, count=5), albedo=None).stored_in(np.dtype(precision).type)
    honest = evaluated(case, precision)
    assert judge(case, honest, precision).worst <= 1
    size = max(coefficient(case, s.lights) for s in shade(*case.arguments, **case.options))
    bound = (4 * math.sqrt(case.material.shininess) + 16) * 4 * size * STEP[precision]
    for name in ("rgb", "ambient", "diffuse", "specular", "emission", "per_light"):
        spoiled = np.array(getattr(honest, name), dtype=np.float64)
        spoiled[..., dice.randrange(5), dice.randrange(3)] += 100 * bound
        judgement = judge(case, replace(honest, **{name: spoiled}), precision)
        assert judgement.worst > 10
        assert judgement.report.startswith(name)
