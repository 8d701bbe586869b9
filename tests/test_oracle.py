"""The oracle against closed forms worked out by hand: what it and the evaluators that it judges could both misread."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy as np
import pytest
from judging import FIELDS as SHADING_FIELDS
from judging import STEP, bounds, conditioning, judge
from oracle import as_array, blinn_phong, ctx, exact, phong, shade, vtk_tier
from strategies import Dice, moderate_case

from pvphong import DirectionalLight, LightModel, Material, PointLight, Scene, SpotLight, Viewer

UP, ORIGIN = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
material_of = partial(Material, ambient=0.0, diffuse=0.0)


def one(*lights: Any, material: Any, eye: Any = (0.0, 0.0, 5.0), focal: Any = ORIGIN, **given: Any) -> Any:
    """A vertex in the origin with a normal along z, if `given` says nothing else, under a dark light model."""
    matrix = given.pop("matrix", None)
    p, n, up = given.pop("p", ORIGIN), given.pop("n", UP), given.pop("up", (0.0, 1.0, 0.0))
    viewer = Viewer(eye, focal, up, parallel=given.pop("parallel", False))
    model = LightModel.vtk(two_sided=False) if given.pop("vtk", False) else LightModel(0.0)
    (only,) = shade([p], [n], Scene(lights, viewer, replace(model, **given)), material, matrix=matrix)
    return only


def near(value: float, rel: float = 1e-15) -> Any:
    return pytest.approx(value, rel=rel, abs=0)


def mirror(shininess: float) -> Material:
    return material_of(specular=1.0, shininess=shininess)


def matrix_of(linear: Any, offset: Any = ORIGIN, w: float = 1.0) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3], matrix[3, 3] = linear, offset, w
    return matrix


def above(axis: Any, cone_angle: float, exponent: float, **fields: Any) -> SpotLight:
    """A spot straight above the origin."""
    return SpotLight((0.0, 0.0, 4.0), axis, cone_angle=cone_angle, exponent=exponent, **fields)


MATT = material_of(diffuse=1.0)
ALL = material_of(ambient=0.5, diffuse=1.0, specular=1.0, shininess=2.0, emission=0.0625)
ALL_WHITE = material_of(ambient=1.0, diffuse=1.0, specular=1.0, shininess=9.0)
GLOWING = material_of(ambient=0.25, diffuse=0.5, specular=1.0, emission=0.125)
SQUARED = material_of(diffuse=1.0, specular=1.0, shininess=2.0)

ZENITH, NADIR = DirectionalLight((0.0, 0.0, -1.0)), DirectionalLight((0.0, 0.0, 1.0))
SLANTED = DirectionalLight((-3.0, 0.0, -4.0))  # r = (−3, 0, 4)/5, and v = (0, 0, 1) from straight above: r·v = 4/5
DIAGONAL = DirectionalLight((-1.0, 0.0, -1.0))
OFF, BLACK = replace(ZENITH, on=False), replace(ZENITH, intensity=0.0)
HEAD = DirectionalLight(frame="headlight", intensity=0.5)
ODD = replace(DIAGONAL, specular=0.0, ambient=1.0)  # VTK ignores both
ALL_THREE = PointLight((0.0, 0.0, 2.0), attenuation=(0.0, 1.0, 0.0), ambient=0.5, diffuse=0.25, specular=0.125)
ON_IT = PointLight(ORIGIN, attenuation=(4.0, 1.0, 1.0), ambient=1.0)
TO_THE_AXIS = (3.0, 0.0, -4.0)  # the axis of a spot, 4/5 from the way to the origin
BELOW = {"eye": (0.0, 0.0, -5.0)}
BESIDE = {"eye": (9.0, 0.0, 1.0)}
FAR = {"p": (1e3, -1e3, 0.0)}
BLINN = {"reflection": "blinn-phong"}
MIRRORED, FLAT = matrix_of(np.diag([1.0, 1.0, -1.0])), matrix_of(np.diag([2.0, 3.0, 0.0]))
SHEAR = matrix_of([[1.0, 0.0, 2.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])

# What the unclamped grey is, or fields are, under which lights and what else `one` takes.
CASES: dict[str, tuple[Any, list[Any], dict[str, Any]]] = {
    **{
        f"Lambert's law at {angle} degrees": (
            pytest.approx(math.cos(x), abs=2e-16),
            [DirectionalLight((-math.sin(x), 0.0, -math.cos(x)))],
            {},
        )
        for angle, x in ((angle, math.radians(angle)) for angle in (0, 30, 60, 85))
    },
    "light from behind": (0, [NADIR], {"material": ALL_WHITE}),
    "attenuation at distance 7": (
        near(6 / 7 / (1 + 14 + 147)),
        [PointLight((2.0, 3.0, 6.0), attenuation=(1.0, 2.0, 3.0))],
        {},
    ),
    "a power of the cosine": (near(0.64), [above(TO_THE_AXIS, 60.0, 2.0)], {}),
    "outside the cone, ambient too": (0, [above(TO_THE_AXIS, 36.0, 1.0, ambient=1.0)], {"material": ALL_WHITE}),
    # --- highlights
    "the mirror direction": (1, [DirectionalLight(TO_THE_AXIS)], {"eye": (3.0, 0.0, 4.0), "material": mirror(1e300)}),
    "a power of r·v": (near(0.8**7, 1e-13), [SLANTED], {"material": mirror(7.0)}),
    "half the angle, cos² x = 9/10": (near(0.81), [SLANTED], {**BLINN, "material": mirror(4.0)}),
    "opposite light and viewer": (0, [ZENITH], {**BLINN, **BELOW, "material": mirror(1e-3)}),
    "opposite light and viewer, 0": (1, [ZENITH], {**BLINN, **BELOW, "material": mirror(0.0)}),
    "shininess 0 across": (1, [DIAGONAL], {"eye": (1.0, 0.0, 1.0), "material": mirror(0.0)}),
    "shininess 0 at the horizon": (0, [DirectionalLight((-1.0, 0.0, 0.0))], {"material": mirror(0.0)}),
    "the mirror direction looks away": (0, [DIAGONAL], {**BESIDE, "material": mirror(1e-3)}),
    "a viewer at infinity": (near(0.8**3), [SLANTED], {**FAR, "local_viewer": False, "material": mirror(3.0)}),
    "a parallel viewer": (near(0.8**3), [SLANTED], {**FAR, "parallel": True, "material": mirror(3.0)}),
    # --- special vertices
    "a light on the vertex leaves its ambient over c": (0.5 / 4 + 0.0625, [ON_IT], {"material": ALL}),
    "a spot on the vertex has a cosine of 0": (
        0,
        [SpotLight(cone_angle=59.0, exponent=0.0, ambient=1.0)],
        {"material": ALL_WHITE},
    ),
    "a spot on the vertex with it on its edge": (
        1,
        [SpotLight(cone_angle=90.0, exponent=0.0, ambient=1.0)],
        {"material": ALL_WHITE},
    ),
    "a zero normal keeps ambient and emission": (
        0.5 * (0.5 + 0.25) + 0.0625,
        [replace(ZENITH, ambient=0.25)],
        {"ambient": 0.5, "two_sided": True, "material": ALL, "n": ORIGIN},
    ),
    "an eye on the vertex": (
        {"diffuse": 1.0, "specular": 0.0},
        [ZENITH],
        {"eye": ORIGIN, "focal": (0.0, 0.0, 9.0), "two_sided": True, "material": ALL},
    ),
    "two-sided": (2, [NADIR], {**BELOW, "two_sided": True, "material": ALL_WHITE}),
    # --- matrices: x' = x + 2z turns the normal of x = 0 into (1, 0, −2)
    "a shear by the inverse-transpose": (near(2 / math.sqrt(5)), [NADIR], {"n": (1.0, 0.0, 0.0), "matrix": SHEAR}),
    "a mirror, lit from below": (1, [NADIR], {"matrix": MIRRORED}),
    "a mirror aside": (1, [ZENITH], {"matrix": matrix_of(np.diag([-1.0, 1.0, 1.0]))}),
    "w < 0, lit from below": (1, [NADIR], {"matrix": matrix_of(5.0 * np.eye(3), w=-2.0)}),
    "points are divided by w, lights stay": (
        0.5,  # (1, 0, 0) goes to (1.5, 0, 0)
        [PointLight((1.5, 0.0, 2.0), attenuation=(0.0, 1.0, 0.0))],
        {"p": (1.0, 0.0, 0.0), "matrix": matrix_of(np.eye(3), (2.0, 0.0, 0.0), 2.0)},
    ),
    "flattened, the cofactors' direction": (1, [ZENITH], {"n": (0.6, 0.0, 0.8), "matrix": FLAT}),
    # --- colours
    "intensity and attenuation multiply all three colours": (
        {"ambient": 1.0, "diffuse": 0.5, "specular": 0.25, "per_light": [1.75]},
        [replace(ALL_THREE, intensity=4.0)],
        {"material": ALL_WHITE},
    ),
    "a light that is off keeps its row": ({"per_light": [0.0, 1.0]}, [OFF, ZENITH], {}),
    "one clamp at the end": (
        {"unclamped": (3.5, 2.0, 0.75), "color": (1.0, 1.0, 0.75)},
        [replace(ZENITH, intensity=3.0)],
        {"ambient": 0.5, "material": material_of(ambient=1.0, diffuse=(1.0, 0.5, 0.0), emission=(0.0, 0.0, 0.25))},
    ),
    "albedo tints ambient and diffuse only": (
        {"ambient": (0.25, 0.0, 0.5), "diffuse": (0.5, 0.0, 1.0), "specular": 1.0, "emission": 0.0625},
        [ZENITH],
        {"ambient": 1.0, "material": replace(ALL, albedo=[[0.5, math.nan, 300.0]])},
    ),
    # --- VTK
    "vtk: a local viewer in parallel projection": (
        1,
        [SLANTED],
        {"vtk": True, "eye": (-3.0, 0.0, 4.0), "focal": (-3.0, 0.0, 0.0), "parallel": True, "material": mirror(3.0)},
    ),
    "vtk: a cone of 90 degrees is none": (1, [above(UP, 90.0, 2.0)], {"vtk": True}),
    "vtk: shininess ends at 128": (near(0.8**128, 1e-13), [SLANTED], {"vtk": True, "material": mirror(1e6)}),
    "vtk: exponents end at 128": (near(0.8**128, 1e-13), [above(TO_THE_AXIS, 60.0, 1e6)], {"vtk": True}),
    "vtk: turned to the eye": (1, [NADIR], {"vtk": True, "two_sided": True, "focal": (0.0, 0.0, -9.0), **BELOW}),
    "vtk: in parallel to the view plane": (
        0,
        [NADIR],
        {"vtk": True, "two_sided": True, "parallel": True, "focal": (0.0, 0.0, -9.0), **BELOW},
    ),
    # Seen in VTK's own pictures: 179/255 for 0.3 + 0.4 on white, against 76/255 for a light of intensity 0.
    "vtk: with a light that is off, ambient + diffuse": (0.875, [OFF], {"vtk": True, "material": GLOWING}),
    "vtk: with a black light": (0.375, [BLACK], {"vtk": True, "material": GLOWING}),
    "vtk: tier 1 ignores the eye's place": (
        {"ambient": 0.0, "diffuse": near(0.4), "specular": near(0.32)},
        [HEAD],
        {"vtk": True, "eye": (9.0, 9.0, 5.0), "focal": (9.0, 9.0, 0.0), "material": SQUARED, "n": (3.0, 0.0, 4.0)},
    ),
    "vtk: tier 1 never goes dark": (
        {"diffuse": near(0.5e-6), "specular": near(0.5e-12)},
        [HEAD],
        {"vtk": True, "material": SQUARED, "n": (0.0, 0.0, -1.0)},
    ),
    "vtk: tier 2 floors the mirror cosine": (
        {"ambient": 0.0, "specular": near(1e-5**0.1)},
        [ODD],
        {"vtk": True, **BESIDE, "material": mirror(0.1)},
    ),
    "vtk: tier 2 has no floor behind": (0, [DIAGONAL], {"vtk": True, "material": mirror(0.1), "n": (0.0, 0.0, -1.0)}),
    "vtk: tier 3 attenuates diffuse and specular": (
        {"per_light": [near(0.2 * (0.8 + 0.64)), 2.0]},
        [PointLight((0.0, 3.0, 4.0), attenuation=(0.0, 1.0, 0.0)), ZENITH],
        {"vtk": True, "material": SQUARED},
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_the_colours_are(case: str) -> None:
    expected, lights, options = CASES[case]
    got = one(*lights, **{"material": MATT, **options})
    for name, value in (expected if isinstance(expected, dict) else {"unclamped": expected}).items():
        if name == "per_light":
            assert as_array([got], name).tolist() == [[[c] * 3] for c in value]
        else:
            assert as_array([got], name)[0].tolist() == (list(value) if isinstance(value, tuple) else [value] * 3), name


@pytest.mark.parametrize(("axis", "cone_angle"), [((1.0, 0.0, -1.0), 45.0), ((1.0, 1.0, 0.0), 90.0)])
def test_the_edge_of_the_cone_is_inside(axis: Any, cone_angle: float) -> None:
    on_it, outside = (
        one(above(axis, angle, 0.0, ambient=1.0), material=material_of(ambient=1.0))
        for angle in (cone_angle, math.nextafter(cone_angle, 0.0))
    )
    assert (float(on_it.ambient[0]), float(outside.ambient[0])) == (1.0, 0.0)
    assert abs(on_it.lights[0].cone_margin) < 1e-70


@pytest.mark.parametrize(
    ("rides", "stays"),
    [
        (PointLight((1.0, 2.0, -3.0), frame="camera"), PointLight((1.0, -2.0, 2.0))),
        (DirectionalLight((0.25, 0.5, -1.0), frame="camera"), DirectionalLight((0.25, 1.0, 0.5))),
        (SpotLight((9.0, 9.0, 9.0), (9.0, 9.0, 9.0), frame="headlight"), SpotLight((0.0, -5.0, 0.0), (0.0, 1.0, 0.0))),
    ],
)
def test_lights_ride_along_with_the_viewer(rides: Any, stays: Any) -> None:
    """From (0, −5, 0) looking along +y with z up: right is +x, so eye (1, 2, −3) is world (1, −2, 2)."""
    aside = {"eye": (0.0, -5.0, 0.0), "focal": (0.0, 7.0, 0.0), "up": (0.0, 3.0, 2.0)}
    for normal in (UP, (0.0, -1.0, 0.0), (0.0, -1.0, -4.0), (-1.0, 0.0, 0.0)):
        there, here = (one(light, material=ALL, n=normal, **aside).unclamped[0] for light in (rides, stays))
        assert float(there) == near(float(here))


def test_vtk_tiers_follow_the_lights_that_vtk_counts() -> None:
    lamp = PointLight(UP)
    for tier, *lights in (
        (0,),
        (0, OFF),
        (1, HEAD),
        (1, OFF, HEAD),
        (2, HEAD, OFF),
        (2, HEAD, BLACK),
        (2, DirectionalLight(frame="camera")),
        (3, HEAD, replace(lamp, on=False)),
        (3, HEAD, replace(lamp, intensity=0.0)),
        (3, SpotLight(frame="headlight")),
    ):
        assert vtk_tier(lights) == tier


# --- the forms that do not cancel, against the plain formulas at 900 digits ---


def plain_lobes(n: Any, to_light: Any, v: Any, shininess: float) -> list[Any]:
    """Phong and Blinn-Phong exactly as the page writes them, with every vector normalised first."""
    many = mpmath.MPContext()
    many.dps = 900

    def dot(a: Any, b: Any) -> Any:
        return sum(x * y for x, y in zip(a, b, strict=True))

    def unit(w: Any) -> list[Any]:
        length = many.sqrt(dot(w, w))
        return [x / length for x in w]

    n, to_light, v = (unit([many.mpf(x) for x in w]) for w in (n, to_light, v))
    r = [2 * dot(n, to_light) * a - b for a, b in zip(n, to_light, strict=True)]
    h = unit([a + b for a, b in zip(to_light, v, strict=True)])
    return [max(cosine, 0) ** many.mpf(shininess) for cosine in (dot(r, v), dot(n, h))]


@pytest.mark.parametrize("spread", [0, 250])
def test_lobes_agree_with_the_plain_formulas(spread: int) -> None:
    dice = random.Random(spread)
    for _ in range(40):
        n, to_light, v = (
            tuple(math.ldexp(dice.uniform(-1, 1), dice.randint(-spread, spread)) for _ in range(3)) for _ in range(3)
        )
        v = dice.choice((v, v, v, to_light, tuple(-x * (1 + 1e-15 * dice.random()) for x in to_light)))
        shininess = 10.0 ** dice.uniform(-2, 5)
        expected = plain_lobes(n, to_light, v, shininess)
        got = [lobe(exact(n), exact(to_light), exact(v), shininess)[1] for lobe in (phong, blinn_phong)]
        for a, b in zip(got, expected, strict=True):
            assert abs(a - ctx.mpf(b)) <= ctx.mpf("1e-65") * ctx.mpf(b), (n, to_light, v, shininess)


@pytest.mark.parametrize("precision", STEP)
@pytest.mark.parametrize("name", SHADING_FIELDS)
def test_the_judge_finds_a_wrong_last_digit(name: str, precision: str) -> None:
    """A colour that is off by a hundred times its bound is reported, whichever field it is in."""
    case = replace(moderate_case(Dice(5), "standard"), matrix=None, albedo=None).stored_in(np.dtype(precision).type)
    shades = shade(*case.arguments)
    honest = {name: as_array(shades, of_oracle) for name, of_oracle in SHADING_FIELDS.items()}
    assert judge(case, SimpleNamespace(**honest), precision).worst <= 1
    bound = bounds(case, shades, STEP[precision], conditioning(case))
    honest[name][..., 0, 1] += 100 * bound[0]
    judgement = judge(case, SimpleNamespace(**honest), precision)
    assert judgement.worst > 10
    assert judgement.report.startswith(name)
