"""The oracle against closed forms worked out by hand, and against the plain formulas at 900 digits.

It is tried on plain namespaces, so that it is known to read the public fields and nothing else.
"""

from __future__ import annotations

import math
import random
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy as np
import pytest
from judging import FIELDS as SHADING_FIELDS
from judging import STEP, bounds, conditioning, judge
from oracle import Shade, as_array, blinn_phong, ctx, exact, phong, shade, sum_of_roots, vtk_tier
from strategies import Dice, moderate_case

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


def near(value: float, rel: float = TIGHT) -> Any:
    return pytest.approx(value, rel=rel, abs=0)


def mirror(shininess: float) -> SimpleNamespace:
    return material_of(specular=1.0, shininess=shininess)


def matrix_of(linear: Any, offset: Any = ORIGIN, w: float = 1.0) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3], matrix[3, 3] = linear, offset, w
    return matrix


def above(axis: Any, cone_angle: float, exponent: float, **fields: Any) -> SimpleNamespace:
    """A spot straight above the origin."""
    return spot((0.0, 0.0, 4.0), axis, cone_angle, exponent, **fields)


def tilted(degrees: float, cone_angle: float, exponent: float, **fields: Any) -> SimpleNamespace:
    tilt = math.radians(degrees)
    return above((math.sin(tilt), 0.0, -math.cos(tilt)), cone_angle, exponent, **fields)


MATT = material_of(diffuse=1.0)
ALL = material_of(ambient=0.5, diffuse=1.0, specular=1.0, shininess=2.0, emission=0.0625)
ALL_WHITE = material_of(ambient=1.0, diffuse=1.0, specular=1.0, shininess=9.0)
GLOWING = material_of(ambient=0.25, diffuse=0.5, specular=1.0, emission=0.125)

ZENITH, NADIR = directional((0.0, 0.0, -1.0)), directional((0.0, 0.0, 1.0))
SLANTED = directional((-3.0, 0.0, -4.0))  # r = (−3, 0, 4)/5, and v = (0, 0, 1) from straight above: r·v = n·l = 4/5
DIAGONAL = directional((-1.0, 0.0, -1.0))
OFF = directional((0.0, 0.0, -1.0), on=False)
BELOW = {"eye": (0.0, 0.0, -5.0)}
TO_THE_AXIS = (3.0, 0.0, -4.0)  # the axis of a spot, 4/5 from the way to the origin
NARROW = 1e-150  # radians
ON_IT, UNEVEN = point(ORIGIN, (4.0, 1.0, 1.0), ambient=1.0), point(ORIGIN, (0.0, 0.0, 1.0), ambient=1.0)
SHEAR = matrix_of([[1.0, 0.0, 2.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
# From (0, −5, 0) looking along +y with z up: right is +x, so eye (1, 2, −3) is world (1, −2, 2).
ASIDE = {"eye": (0.0, -5.0, 0.0), "focal": (0.0, 7.0, 0.0), "up": (0.0, 3.0, 2.0)}
# Seen by the eye (3, 0, 4) the origin is 4/5 off the axis of view.
DOWNWARD = {"eye": (3.0, 0.0, 4.0), "focal": (3.0, 0.0, -1.0)}
NINES = (9.0, 9.0, 9.0)


def lit(expected: Any, *lights: Any, material: Any = MATT, p: Any = ORIGIN, **given: Any) -> Any:
    """What is expected of a vertex with a normal and a matrix, under some lights and what else `scene_of` takes."""
    options = {name: given.pop(name) for name in ("n", "matrix", "albedo") if name in given}
    return expected, scene_of(*lights, **given), material, {"p": p} | options


VTK = {"convention": "vtk"}
BLINN = {"reflection": "blinn-phong"}
MIRRORED, UPSIDE_DOWN = matrix_of(np.diag([1.0, 1.0, -1.0])), matrix_of(np.diag([5.0, 5.0, 5.0]), w=-2.0)
MIRRORED_ASIDE, FLAT = matrix_of(np.diag([-1.0, 1.0, 1.0])), matrix_of(np.diag([2.0, 3.0, 0.0]))

GREYS: dict[str, Any] = {
    **{
        f"Lambert's law at {round(math.degrees(x))} degrees": lit(
            pytest.approx(math.cos(x), abs=2e-16), directional((-math.sin(x), 0.0, -math.cos(x)))
        )
        for x in map(math.radians, (0, 30, 60, 85))
    },
    "light from behind": lit(0, NADIR, material=ALL_WHITE),
    "lengths do not matter": lit(near(0.8), directional((-3e-200, 0.0, -4e-200)), n=(0.0, 0.0, 1e200)),
    # at distance 7, with n·l = 6/7
    "attenuation": lit(near(6 / 7 / (1 + 14 + 147)), point((2.0, 3.0, 6.0), (1.0, 2.0, 3.0))),
    # --- spots
    "a power of the cosine": lit(near(0.64), above(TO_THE_AXIS, 60.0, 2.0)),
    "outside the cone, ambient too": lit(0, tilted(31, 30.0, 1.0, ambient=1.0), material=ALL_WHITE),
    "just inside the cone": lit(pytest.approx(2.95, abs=0.05), tilted(29, 30.0, 0.0, ambient=1.0), material=ALL_WHITE),
    "a spot that points away": lit(0, above((0.0, 0.0, 1.0), 20.0, 0.0)),
    "the edge of a right angle": lit(1, above((1.0, 0.0, 0.0), 90.0, 0.0)),
    "inside a tiny cone": lit(1, above((NARROW, 0.0, -1.0), math.degrees(NARROW) * (1 + 1e-12), 1.0)),
    "outside a tiny cone": lit(0, above((NARROW, 0.0, -1.0), math.degrees(NARROW) * (1 - 1e-12), 1.0)),
    # --- highlights
    "the mirror direction": lit(1, directional((3.0, 0.0, -4.0)), eye=(3.0, 0.0, 4.0), material=mirror(1e300)),
    **{
        f"r·v to the power of {n}": lit(near(0.8**n, 1e-13), SLANTED, material=mirror(n))
        for n in (0.5, 1.0, 7.0, 200.0)
    },
    # cos 2x = 4/5, so cos² x = 9/10
    "half the angle": lit(near(0.81), SLANTED, **BLINN, material=mirror(4.0)),
    # only reachable with n·l > 0 where the viewer is behind the surface
    "opposite light and viewer": lit(0, ZENITH, **BLINN, eye=(0.0, 0.0, -7.0), material=mirror(1e-3)),
    "opposite light and viewer, 0": lit(1, ZENITH, **BLINN, eye=(0.0, 0.0, -7.0), material=mirror(0.0)),
    # r·v = 0 exactly, n·l = 0, and light from behind
    **{
        f"shininess 0, {reflection}, {eye}, {sun.direction}": lit(
            expected, sun, reflection=reflection, eye=eye, material=mirror(0.0)
        )
        for reflection in ("phong", "blinn-phong")
        for expected, sun, eye in (
            (1, DIAGONAL, (1.0, 0.0, 1.0)),
            (0, directional((-1.0, 0.0, 0.0)), (0.0, 0.0, 5.0)),
            (0, NADIR, (0.0, 0.0, 5.0)),
        )
    },
    "the mirror direction looks away": lit(0, DIAGONAL, eye=(9.0, 0.0, 1.0), material=mirror(1e-3)),
    "a viewer at infinity": lit(near(0.8**3), SLANTED, local_viewer=False, material=mirror(3.0), p=(1e3, -1e3, 0.0)),
    "a parallel viewer": lit(near(0.8**3), SLANTED, parallel=True, material=mirror(3.0), p=(1e3, -1e3, 0.0)),
    # --- special vertices
    "a light on the vertex leaves its ambient over c": lit(0.5 / 4 + 0.0625, ON_IT, material=ALL),
    "a spot on the vertex has a cosine of 0": lit(0, spot(ORIGIN, UP, 59.0, 0.0, ambient=1.0), material=ALL_WHITE),
    "a spot on the vertex with it on its edge": lit(1, spot(ORIGIN, UP, 90.0, 0.0, ambient=1.0), material=ALL_WHITE),
    "a light on the vertex without c": lit(0.0625, UNEVEN, material=ALL),
    "two-sided": lit(2, NADIR, two_sided=True, **BELOW, material=ALL_WHITE),
    "one-sided": lit(0.0625, NADIR, **BELOW, material=ALL),
    "two-sided, seen from infinity": lit(1, NADIR, focal=(0.0, 0.0, 9.0), two_sided=True, local_viewer=False),
    # --- frames: a headlight's own place and direction do not matter
    "a spot as headlight": lit(near(0.64), spot(NINES, NINES, 60.0, 1.0, frame="headlight"), **DOWNWARD),
    "a sun as headlight": lit(1, directional(NINES, frame="headlight"), **DOWNWARD),
    "a lamp as headlight": lit(near(0.8), point(NINES, frame="headlight"), **DOWNWARD),
    # --- matrices: x' = x + 2z turns the normal of the plane z = 0 not at all, and that of x = 0 into (1, 0, −2)
    "a shear by the inverse-transpose": lit(near(2 / math.sqrt(5)), NADIR, n=(1.0, 0.0, 0.0), matrix=SHEAR),
    "a plane that a shear keeps": lit(1, ZENITH, matrix=SHEAR),
    "a mirror, lit from below": lit(1, NADIR, matrix=MIRRORED),
    "a mirror, lit from above": lit(0, ZENITH, matrix=MIRRORED),
    "w < 0, lit from below": lit(1, NADIR, matrix=UPSIDE_DOWN),
    "w < 0, lit from above": lit(0, ZENITH, matrix=UPSIDE_DOWN),
    "a mirror aside": lit(1, ZENITH, matrix=MIRRORED_ASIDE),
    # (1, 0, 0) goes to (1.5, 0, 0)
    "points are divided by w, lights stay": lit(
        0.5,
        point((1.5, 0.0, 2.0), (0.0, 1.0, 0.0)),
        p=(1.0, 0.0, 0.0),
        matrix=matrix_of(np.eye(3), (2.0, 0.0, 0.0), 2.0),
    ),
    **{
        f"a quarter turn, {size:g} as large": lit(
            near(0.6),
            SLANTED,
            n=(0.0, -1.0, 0.0),
            matrix=matrix_of(size * np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])),
        )
        for size in (1e-200, 1e-110, 1e110, 1e200)
    },
    "flattened, the cofactors' direction": lit(1, ZENITH, n=(0.6, 0.0, 0.8), matrix=FLAT),
    # --- VTK
    "vtk: a local viewer in parallel projection": lit(
        1, SLANTED, eye=(-3.0, 0.0, 4.0), focal=(-3.0, 0.0, 0.0), parallel=True, **VTK, **BLINN, material=mirror(3.0)
    ),
    "vtk: a spot": lit(near(0.64), above(TO_THE_AXIS, 40.0, 2.0), **VTK),
    "vtk: outside its cone": lit(0, above(TO_THE_AXIS, 36.0, 2.0), **VTK),
    "vtk: a cone of 90 degrees is none": lit(1, above((0.0, 0.0, 1.0), 90.0, 2.0), **VTK),
    "vtk: shininess ends at 128": lit(near(0.8**128, 1e-13), SLANTED, **VTK, material=mirror(1e6)),
    "vtk: exponents end at 128": lit(near(0.8**128, 1e-13), above(TO_THE_AXIS, 60.0, 1e6), **VTK),
    "vtk: one-sided": lit(0, NADIR, **VTK, **BELOW),
    "vtk: two-sided": lit(1, NADIR, **VTK, two_sided=True, **BELOW),
    "vtk: turned to the eye": lit(1, NADIR, **VTK, two_sided=True, focal=(0.0, 0.0, -9.0), **BELOW),
    "vtk: in parallel to the view plane": lit(
        0, NADIR, **VTK, two_sided=True, parallel=True, focal=(0.0, 0.0, -9.0), **BELOW
    ),
    # Seen in VTK's own pictures: 179/255 for 0.3 + 0.4 on white, against 76/255 for a light of intensity 0.
    "vtk: without lights, ambient + diffuse": lit(0.875, **VTK, material=GLOWING),
    "vtk: with a light that is off": lit(0.875, OFF, **VTK, material=GLOWING),
    "vtk: with a black light": lit(0.375, directional((0.0, 0.0, -1.0), intensity=0.0), **VTK, material=GLOWING),
}


@pytest.mark.parametrize("case", GREYS)
def test_the_grey_is(case: str) -> None:
    expected, scene, material, options = GREYS[case]
    red, green, blue = one(scene, material, **options).unclamped
    assert red == green == blue
    assert float(red) == expected


DAYLIGHT = directional((0.0, 0.0, -1.0), ambient=0.25)
ON_THE_VERTEX = {"eye": ORIGIN, "focal": (0.0, 0.0, 9.0)}
RGB = (0.5, 0.25, 0.125)
SQUARED = material_of(diffuse=1.0, specular=1.0, shininess=2.0)
GREEN = material_of(diffuse=(0.0, 1.0, 0.0), specular=(0.0, 1.0, 0.0), shininess=5.0)
THREEFOLD = material_of(ambient=1.0, diffuse=(1.0, 0.5, 0.0), emission=(0.0, 0.0, 0.25))
HEAD = directional(UP, frame="headlight", intensity=0.5)
BRIGHT = directional((0.0, 0.0, -1.0), intensity=3.0)
ALL_THREE = point((0.0, 0.0, 2.0), (0.0, 1.0, 0.0), ambient=0.5, diffuse=0.25, specular=0.125, intensity=4.0)
ODD = directional((-1.0, 0.0, -1.0), specular=0.0, ambient=1.0)  # VTK ignores both
FIELDS: dict[str, Any] = {
    "intensity and attenuation multiply all three colours": lit(
        {"ambient": 1.0, "diffuse": 0.5, "specular": 0.25, "per_light": [1.75]}, ALL_THREE, material=ALL_WHITE
    ),
    "specular None takes the diffuse colour": lit(
        {"specular": RGB}, directional((0.0, 0.0, -1.0), diffuse=RGB), material=mirror(3.0)
    ),
    "a light that is off keeps its row": lit({"per_light": [0.0, 1.0]}, OFF, ZENITH),
    "red light on a green surface": lit(
        {"unclamped": 0.0}, directional((0.0, 0.0, -1.0), diffuse=(1.0, 0.0, 0.0)), material=GREEN
    ),
    "a zero normal keeps ambient and emission": lit(
        {"unclamped": 0.5 * (0.5 + 0.25) + 0.0625, "n_dot_l": None},
        DAYLIGHT,
        ambient=0.5,
        two_sided=True,
        material=ALL,
        n=ORIGIN,
    ),
    "an eye on the vertex keeps diffuse and never flips": lit(
        {"diffuse": 1.0, "specular": 0.0, "n_dot_v": None}, ZENITH, **ON_THE_VERTEX, two_sided=True, material=ALL
    ),
    "one clamp at the end": lit(
        {"unclamped": (3.5, 2.0, 0.75), "color": (1.0, 1.0, 0.75)}, BRIGHT, ambient=0.5, material=THREEFOLD
    ),
    "no clamp": lit({"color": (3.5, 2.0, 0.75)}, BRIGHT, ambient=0.5, clamp=False, material=THREEFOLD),
    "albedo tints ambient and diffuse only": lit(
        {"ambient": (0.25, 0.0, 0.5), "diffuse": (0.5, 0.0, 1.0), "specular": 1.0, "emission": 0.0625},
        ZENITH,
        ambient=1.0,
        material=ALL,
        albedo=[[0.5, math.nan, 300.0]],
    ),
    "vtk: albedo tints ambient and diffuse only": lit(
        {"unclamped": (1.0625 + 0.75, 1.0625 + 0.375, 1.0625 + 1.5)},
        ZENITH,
        **VTK,
        material=ALL,
        albedo=[[0.5, 0.25, 1]],
    ),
    "vtk: tier 1 ignores the eye's place": lit(
        {"ambient": 0.0, "diffuse": near(0.4), "specular": near(0.32)},
        HEAD,
        eye=(9.0, 9.0, 5.0),
        focal=(9.0, 9.0, 0.0),
        material=SQUARED,
        n=(3.0, 0.0, 4.0),
        **VTK,
    ),
    "vtk: tier 1 never goes dark": lit(
        {"diffuse": near(0.5e-6), "specular": near(0.5e-12)}, HEAD, **VTK, material=SQUARED, n=(0.0, 0.0, -1.0)
    ),
    "vtk: tier 1 keeps the material's ambient": lit({"ambient": 0.25}, HEAD, **VTK, material=GLOWING),
    "vtk: tier 2 floors the mirror cosine": lit(
        {"specular": near(1e-5**0.1)}, ODD, eye=(9.0, 0.0, 1.0), **VTK, material=mirror(0.1)
    ),
    "vtk: tier 2 keeps the material's ambient": lit({"ambient": 0.25}, ODD, **VTK, material=GLOWING),
    "vtk: tier 2 has no floor behind": lit(
        {"specular": 0.0}, DIAGONAL, **VTK, material=mirror(0.1), n=(0.0, 0.0, -1.0)
    ),
    "vtk: tier 3 attenuates diffuse and specular": lit(
        {"per_light": [near(0.2 * (0.8 + 0.64)), 2.0]},
        *(point((0.0, 3.0, 4.0), (0.0, 1.0, 0.0)), ZENITH),
        **VTK,
        material=SQUARED,
    ),
}


@pytest.mark.parametrize("case", FIELDS)
def test_the_fields_are(case: str) -> None:
    expected, scene, material, options = FIELDS[case]
    got = one(scene, material, **options)
    for name, value in expected.items():
        if value is None:
            assert (got.n_dot_v if name == "n_dot_v" else got.lights[0].n_dot_l) is None
        elif name == "per_light":
            assert as_array([got], name).tolist() == [[[c] * 3] for c in value]
        else:
            assert as_array([got], name)[0].tolist() == (list(value) if isinstance(value, tuple) else [value] * 3), name


# --- what is no table ---


def test_a_local_viewer_does_not_see_what_one_at_infinity_sees() -> None:
    local = float(one(scene_of(SLANTED), mirror(3.0), p=(1e3, -1e3, 0.0)).unclamped[0])
    assert abs(local - 0.8**3) > 0.1


@pytest.mark.parametrize(
    ("axis", "cone_angle", "expected"),
    [((1.0, 0.0, -1.0), 45.0, 0.5), ((1.0, 1.0, 0.0), 90.0, 0.0)],
)
def test_the_edge_of_the_cone_is_inside(axis: Any, cone_angle: float, expected: float) -> None:
    on_it, outside = (
        one(scene_of(above(axis, angle, 2.0, ambient=1.0)), material_of(ambient=1.0))
        for angle in (cone_angle, math.nextafter(cone_angle, 0.0))
    )
    assert float(on_it.ambient[0]) == near(expected)
    assert abs(on_it.lights[0].cone_margin) < 1e-70
    assert float(outside.ambient[0]) == 0


@pytest.mark.parametrize(
    ("rides", "stays", "material"),
    [
        (point((1.0, 2.0, -3.0), (1.0, 2.0, 3.0), frame="camera"), point((1.0, -2.0, 2.0), (1.0, 2.0, 3.0)), ALL),
        (directional((0.25, 0.5, -1.0), frame="camera"), directional((0.25, 1.0, 0.5)), MATT),
    ],
)
def test_camera_frame_rides_along(rides: Any, stays: Any, material: Any) -> None:
    for normal in (UP, (0.0, -1.0, 0.0), (0.0, -1.0, -4.0), (-1.0, 0.0, 0.0)):
        there, here = (one(scene_of(light, **ASIDE), material, n=normal).unclamped[0] for light in (rides, stays))
        assert float(there) == near(float(here))


def test_vtk_tiers_follow_the_lights_that_vtk_counts() -> None:
    head, off = directional(UP, frame="headlight"), directional(UP, on=False)
    for tier, *lights in (
        (0,),
        (0, off),
        (1, head),
        (1, off, head),
        (2, head, off),
        (2, head, directional(UP, diffuse=0.0)),
        (2, directional((0.0, 0.0, -1.0), frame="camera")),
        (3, head, point(UP, on=False)),
        (3, head, point(UP, intensity=0.0)),
        (3, spot(UP, UP, 20.0, 1.0, frame="headlight")),
    ):
        assert vtk_tier(lights) == tier


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_non_finite_vertices_are_refused(bad: float) -> None:
    with pytest.raises((ValueError, OverflowError)):
        shade([(bad, 0.0, 0.0)], [UP], scene_of(), MATT)


def test_a_matrix_that_leaves_no_plane_is_refused() -> None:
    with pytest.raises(ValueError, match="rank"):
        shade([ORIGIN], [UP], scene_of(), MATT, matrix=matrix_of(np.diag([1.0, 0.0, 0.0])))


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


# --- the judge itself can find fault ---


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
