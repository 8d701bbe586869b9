"""The oracle, other judges and the scenes that are judged.

The oracle is compared with closed forms worked out by hand, for definitions that both the oracle and the evaluators
could misread. Closed forms that evaluators are tested with elsewhere are not repeated, since the oracle agrees.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from judging import FIELDS as SHADING_FIELDS
from judging import STEP, bounds, conditioning, judge
from oracle import as_array, shade, vtk_tier
from stability.bounds import assert_bits, assert_within
from stability.hunting import rows_of
from strategies import Dice, hard_case, moderate_case

from pvphong import DirectionalLight, LightModel, Material, PointLight, Scene, SpotLight, Viewer

UP, ORIGIN = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
material_of = partial(Material, ambient=0.0, diffuse=0.0)


def one(*lights: Any, material: Any, eye: Any = (0.0, 0.0, 5.0), focal: Any = ORIGIN, **given: Any) -> Any:
    """Light a vertex under a dark light model, by default at the origin with a normal along z."""
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
    """Return a spot light above the origin."""
    return SpotLight((0.0, 0.0, 4.0), axis, cone_angle=cone_angle, exponent=exponent, **fields)


MATT = material_of(diffuse=1.0)
ALL = material_of(ambient=0.5, diffuse=1.0, specular=1.0, shininess=2.0, emission=0.0625)
ALL_WHITE = material_of(ambient=1.0, diffuse=1.0, specular=1.0, shininess=9.0)
GLOWING = material_of(ambient=0.25, diffuse=0.5, specular=1.0, emission=0.125)

ZENITH, NADIR = DirectionalLight((0.0, 0.0, -1.0)), DirectionalLight((0.0, 0.0, 1.0))
SLANTED = DirectionalLight((-3.0, 0.0, -4.0))  # r = (−3, 0, 4)/5, and v = (0, 0, 1) from straight above: r·v = 4/5
OFF, BLACK = replace(ZENITH, on=False), replace(ZENITH, intensity=0.0)
HEAD = DirectionalLight(frame="headlight", intensity=0.5)
TO_THE_AXIS = (3.0, 0.0, -4.0)  # the axis of a spot, 4/5 from the way to the origin
BELOW = {"eye": (0.0, 0.0, -5.0)}
FAR = {"p": (1e3, -1e3, 0.0)}
BLINN = {"reflection": "blinn-phong"}
SHEAR = matrix_of([[1.0, 0.0, 2.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])

# What the unclamped grey is, or fields are, under which lights and what else `one` takes.
CASES: dict[str, tuple[Any, list[Any], dict[str, Any]]] = {
    "Lambert's law": (near(0.8), [SLANTED], {}),
    "light from behind": (0, [NADIR], {"material": ALL_WHITE}),
    "outside the cone, ambient too": (0, [above(TO_THE_AXIS, 36.0, 1.0, ambient=1.0)], {"material": ALL_WHITE}),
    # --- highlights
    "the mirror direction": (1, [DirectionalLight(TO_THE_AXIS)], {"eye": (3.0, 0.0, 4.0), "material": mirror(1e300)}),
    "a power of r·v": (near(0.8**7, 1e-13), [SLANTED], {"material": mirror(7.0)}),
    "half the angle, cos² x = 9/10": (near(0.81), [SLANTED], {**BLINN, "material": mirror(4.0)}),
    "a viewer at infinity": (near(0.8**3), [SLANTED], {**FAR, "local_viewer": False, "material": mirror(3.0)}),
    "a parallel viewer": (near(0.8**3), [SLANTED], {**FAR, "parallel": True, "material": mirror(3.0)}),
    "two-sided": (2, [NADIR], {**BELOW, "two_sided": True, "material": ALL_WHITE}),
    # --- matrices: x' = x + 2z turns the normal of x = 0 into (1, 0, −2)
    "a shear by the inverse-transpose": (near(2 / math.sqrt(5)), [NADIR], {"n": (1.0, 0.0, 0.0), "matrix": SHEAR}),
    "a mirror, lit from below": (1, [NADIR], {"matrix": matrix_of(np.diag([1.0, 1.0, -1.0]))}),
    "a mirror aside": (1, [ZENITH], {"matrix": matrix_of(np.diag([-1.0, 1.0, 1.0]))}),
    "w < 0, lit from below": (1, [NADIR], {"matrix": matrix_of(5.0 * np.eye(3), w=-2.0)}),
    "points are divided by w, lights stay": (
        0.5,  # (1, 0, 0) goes to (1.5, 0, 0)
        [PointLight((1.5, 0.0, 2.0), attenuation=(0.0, 1.0, 0.0))],
        {"p": (1.0, 0.0, 0.0), "matrix": matrix_of(np.eye(3), (2.0, 0.0, 0.0), 2.0)},
    ),
    # --- colours
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
    # --- VTK, beyond what vtk/test_oracle sees in its colours
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


@pytest.mark.parametrize("precision", STEP)
@pytest.mark.parametrize("name", SHADING_FIELDS)
def test_the_judge_finds_a_wrong_last_digit(name: str, precision: str) -> None:
    """An error of a hundred times the bound is reported in every field."""
    case = replace(moderate_case(Dice(5), "standard"), matrix=None, albedo=None).stored_in(np.dtype(precision).type)
    shades = shade(*case.arguments)
    honest = {name: as_array(shades, of_oracle) for name, of_oracle in SHADING_FIELDS.items()}
    assert judge(case, SimpleNamespace(**honest), precision).worst <= 1
    bound = bounds(case, shades, STEP[precision], conditioning(case))
    honest[name][..., 0, 1] += 100 * bound[0]
    judgement = judge(case, SimpleNamespace(**honest), precision)
    assert judgement.worst > 10
    assert judgement.report.startswith(name)


@pytest.mark.parametrize(
    ("judge", "observed", "against", "message"),
    [
        (assert_within, [1.0, 5.0, 2.0], 4.0, "1 of 3 samples over the bound; the worst, sample 1, has 5 where 4"),
        (assert_within, [math.nan, 0.0], 1.0, "1 of 2 samples"),
        (assert_within, [1e-300, 0.0], 0.0, "1 of 2 samples"),
        (assert_within, [], 1.0, "nothing was measured"),
        (assert_bits, [0.0, 1.0], [-0.0, 1.0], "1 of 2 numbers differ"),
        (assert_bits, np.float32([-0.0, 1.0]), [-0.0, 1.0], "is no float64"),
        (assert_bits, [-0.0], [-0.0, 1.0], r"\(1,\) is no"),
    ],
)
def test_what_is_over_its_bound_or_has_other_bits_fails(judge: Any, observed: Any, against: Any, message: str) -> None:
    with pytest.raises(AssertionError, match=message):
        judge("9", observed, against)
    assert_within("9", [0.0, 2.0, -0.0], [0.0, 2.0, 1.0])
    assert_bits("9", [0.0, math.nan], [0.0, math.nan])


# --- the generated scenes cover their cases: dark scenes alone would prove nothing ---

EXAMPLES = 200


def shares(throw, facts_of):
    """Fact → share of the generated scenes that show it; the scenes are the same in every run."""
    counts = Counter()
    for seed in range(EXAMPLES):
        counts.update(facts_of(throw(Dice(seed))))
    return Counter({fact: count / EXAMPLES for fact, count in counts.items()})


def ordinary_facts(case):
    """Return facts of the vertex that the scene is built around, and of a neighbour."""
    case = rows_of(case, slice(2))
    shades, model = shade(*case.arguments, **case.options), case.scene.light_model
    is_shiny = as_array(shades, "specular").max() > 0.01
    margins = [f.cone_margin for s in shades for f in s.lights if f.cone_margin is not None]
    facts = {
        "dull": not np.any(case.material.specular),
        "highlight": is_shiny,
        "sharp highlight": is_shiny and case.material.shininess > 1e4,
        "clamped": as_array(shades, "unclamped").max() > 1,
        "flipped": model.two_sided and any(s.n_dot_v < 0 for s in shades),
        "in a cone": any(margin > 0 for margin in margins),
        "outside a cone": any(margin < 0 for margin in margins),
    }
    named = {name for light in case.scene.lights for name in (type(light).__name__, light.frame)}
    return {fact for fact, holds in facts.items() if holds} | named | {model.reflection}


@pytest.mark.parametrize("convention", ["standard", "vtk"])
def test_ordinary_scenes_are_lit(convention):
    share = shares(lambda dice: moderate_case(dice, convention), ordinary_facts)
    assert share["dull"] < 0.2
    more_than = {0.7: ["highlight"], 0.1: ["sharp highlight"], 0.2: ["DirectionalLight", "PointLight", "SpotLight"]}
    more_than[0.05] = "world", "camera", "headlight", "in a cone", "outside a cone", "clamped", "flipped", "dull"
    more_than[0.3] = ["phong", "blinn-phong"] if convention == "standard" else []
    for least, facts in more_than.items():
        for fact in facts:
            assert share[fact] > least, fact


def hard_facts(case):
    finite = {"point": np.isfinite(case.points).all(axis=1), "normal": np.isfinite(case.normals).all(axis=1)}
    good = rows_of(case, finite["point"] & finite["normal"])
    shades = shade(*good.arguments, **good.options)

    def any_light(name, within):
        found = [getattr(facts, name) for s in shades for facts in s.lights]
        return any(value is not None and abs(value) <= within for value in found)

    facts = {
        "zero normal": not case.normals.any(axis=1).all(),
        "light on a vertex": any_light("distance", 0.0),
        "grazing light": any_light("n_dot_l", 1e-15),
        "edge of a cone": any_light("cone_margin", 1e-14),
        "eye on a vertex or no normal": case.scene.light_model.local_viewer and any(s.n_dot_v is None for s in shades),
    } | {f"non-finite {name}": not rows.all() for name, rows in finite.items()}
    return {fact for fact, holds in facts.items() if holds} | {"a scene"}


def test_hard_scenes_are_hard():
    share = shares(lambda dice: hard_case(dice, "standard"), hard_facts)
    assert len(share) == 8, share
    assert min(share.values()) > 0.03, share
