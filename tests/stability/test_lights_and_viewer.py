"""Section E of the catalogue of hard cases: lights and viewer, against the oracle's exact decisions and 80 digits.

Rows 43 and 46, invalid lights, are in optics/test_fields.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pytest
from oracle import as_array, shade
from stability import naive
from stability.bounds import V, assert_within
from stability.evaluators import EVALUATORS, UNLIT, Evaluator

from pvphong import DirectionalLight, LightModel, Material, PointLight, Scene, SpotLight, Viewer

MATT = Material(ambient=0.0, diffuse=1.0)
SHINY = Material(ambient=0.0, diffuse=0.0, specular=1.0, shininess=20.0)
GLOSSY = Material(ambient=0.0, diffuse=0.5, specular=0.5, shininess=20.0)
REFLECTIONS = ["phong", "blinn-phong"]
ATTENUATIONS = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.5, 0.25, 0.125)]


def lit(
    evaluator: Evaluator, points: Any, normals: Any, lights: Any, eye: Any, material: Material, **model: Any
) -> Any:
    """Return unclamped greys, evaluated and exact."""
    model = replace(UNLIT, **model)
    scene = Scene(lights, Viewer(position=eye, focal_point=np.add(eye, (0.0, 0.0, 1.0))), model)
    stored = (np.asarray(points, evaluator.real), np.asarray(normals, evaluator.real), scene, material)
    return evaluator(*stored).rgb[:, 0].astype(float), as_array(shade(*stored), "unclamped")[:, 0]


# --- 41: the horizon ---


def grazing(evaluator: Evaluator, positional: bool) -> None:
    """n·l is exactly 0 in the stored integers, so there is neither diffuse light nor a highlight.

    The bound alone would allow a little diffuse light from rounding, and with it a full highlight. But products of
    integers are exact, so an evaluator that tests these returns 0. One that normalises first lights a quarter.
    """
    rng = np.random.default_rng(41)
    too_bright, mirrored = [], []
    for _ in range(300):
        a, b = rng.integers(-9, 10, (2, 3))
        n, to_light = np.cross(a, b), a
        if not n.any():
            continue
        assert n @ to_light == 0  # exact in integers
        light = PointLight(position=to_light) if positional else DirectionalLight(direction=-to_light)
        eye = 0.01 * n - to_light  # near −l, the mirror direction of n·l = 0
        scene = Scene([light], Viewer(position=eye, focal_point=np.add(eye, (0.0, 0.0, 1.0))), UNLIT)
        stored = np.zeros((1, 3), evaluator.real), n[None].astype(evaluator.real)
        diffuse, specular = (float(evaluator(*stored, scene, material).rgb[0, 0]) for material in (MATT, SHINY))
        too_bright.append(diffuse)
        mirrored.append(specular)
    assert_within(f"41 {'point' if positional else 'directional'}", too_bright, 4 * evaluator.step)
    assert not any(too_bright)
    assert not any(mirrored), "a highlight without a light above the horizon"


# --- 42: the edge of the cone ---


def cone_edge(evaluator: Evaluator, cone_angle: float) -> None:
    """Vertices within 1e-5 radians of the edge must be correct outside a band of 4v in the angle (4u in float64).

    In the cosine the band is 4v · sin of the cone's angle. The catalogue's 4v would accept anything in a narrow cone.
    """
    rng = np.random.default_rng(42)
    margins, sides = [], []
    for _ in range(12):
        position, axis, other = rng.normal(size=(3, 3))
        axis = naive.unit(axis)
        side = naive.unit(np.cross(axis, other))
        close = 10.0 ** rng.uniform(math.log10(evaluator.step), -5.0, 40)
        off = math.radians(cone_angle) + rng.choice((-1, 1), 40) * close
        rays = np.cos(off)[:, None] * axis + np.sin(off)[:, None] * side
        points = (position + rays * rng.uniform(0.5, 4.0, (40, 1))).astype(evaluator.real)
        spot = SpotLight(position=position, direction=axis, cone_angle=cone_angle, exponent=0.0, ambient=1.0)
        scene, material = Scene([spot], Viewer(), UNLIT), Material(ambient=1.0, diffuse=0.0)
        inside = evaluator(points, -rays, scene, material).rgb[:, 0] > 0.0
        margin = np.array([float(s.lights[0].cone_margin) for s in shade(points, -rays, scene, material)])
        margins += list(np.where(inside != (margin >= 0.0), abs(margin), 0.0))
        sides += list(margin >= 0.0)
    assert 0.2 < np.mean(sides) < 0.8
    bound = 4 * evaluator.step * math.sin(math.radians(cone_angle))
    assert_within(f"42 cone={cone_angle:g}", margins, bound)


# --- 44, 45: zero distance between vertex and light, or vertex and eye ---


def light_on_the_vertex(evaluator: Evaluator, attenuation: Any, at: Any) -> None:
    """A light at a vertex gives it neither diffuse light nor a highlight; another light does."""
    normals = np.array([[0.0, 0.0, 1.0], [1.0, -2.0, 0.5]])
    points = np.array([at, np.add(at, (2.0, 0.0, 0.0))])
    sun = DirectionalLight(direction=(0.0, 0.0, -1.0), diffuse=0.5)
    eye, material = np.add(at, (0.0, 0.0, 4.0)), Material(ambient=1.0, diffuse=0.5, specular=0.5, shininess=20.0)
    for shape, ambient, reflection in product((PointLight, SpotLight), (0.0, 1.0), REFLECTIONS):
        lamp = shape(position=at, attenuation=attenuation, ambient=ambient)
        (alone, truth), (both, _), (other, _) = (
            lit(evaluator, points, normals, lights, eye, material, reflection=reflection)
            for lights in ([lamp], [lamp, sun], [sun])
        )
        # The vertex is outside a spot's cone; a point light's ambient light arrives as 1/c.
        arrives = ambient / attenuation[0] if shape is PointLight and attenuation[0] else 0.0
        assert_within(f"44 {shape.__name__}", abs(alone[0] - arrives), 0.0)
        assert_within("44 the neighbour", abs(alone - truth)[1], (4 * math.sqrt(20.0) + 16) * 2 * evaluator.step)
        assert_within("44 another light", abs(both[0] - arrives - other[0]), 0.0)


def eye_on_the_vertex(evaluator: Evaluator, reflection: str, two_sided: bool) -> None:
    """There is diffuse light and no highlight."""
    rng = np.random.default_rng(45)
    model = LightModel(ambient=0.0, clamp=False, reflection=reflection, two_sided=two_sided)
    label = f"45 {reflection}{' two-sided' if two_sided else ''}"
    for _ in range(50):
        p, n, away = rng.normal(size=(3, 3))
        p, n = p[None].astype(evaluator.real), n[None].astype(evaluator.real)
        lamp = PointLight(position=p[0] + np.sign(n[0] @ away) * away)
        scene = Scene([lamp], Viewer(position=p[0], focal_point=p[0] + away), model)
        truth = as_array(shade(p, n, scene, MATT), "unclamped")
        assert_within(label, abs(evaluator(p, n, scene, MATT).rgb - truth), 10 * evaluator.step)
        for material in (SHINY, replace(SHINY, shininess=0.0)):
            assert_within(label, abs(evaluator(p, n, scene, material).rgb), 0.0)


# --- 47: far from the origin ---


def far_out(evaluator: Evaluator, offset: float, stored: Any) -> None:
    """The exact result is for the stored points; light and eye stay float64."""
    rng = np.random.default_rng(47)
    centre = offset * np.array([1.0, -0.7, 0.4])
    points = (centre + rng.uniform(-0.5, 0.5, (200, 3))).astype(stored)
    normals = naive.unit(rng.normal((0.0, 0.0, 2.0), size=(200, 3))).astype(stored)
    lamp, eye = PointLight(position=np.add(centre, (0.43, 0.31, 1.27))), np.add(centre, (-0.33, 0.21, 1.57))
    scene = Scene([lamp], Viewer(position=eye, focal_point=centre), UNLIT)
    truth = as_array(shade(points, normals, scene, GLOSSY), "unclamped")[:, 0]
    got = evaluator(points, normals, scene, GLOSSY).rgb[:, 0].astype(float)
    label = f"47 {offset:.0e} {np.dtype(stored).name}"
    assert_within(label, abs(got - truth), 1e-5 * evaluator.step / V)
    with np.errstate(all="ignore"):
        in_float32 = naive.shade(points, normals, lamp.position, eye, GLOSSY, np.float32).astype(float)
    broken = ~(abs(in_float32 - truth) <= 1e-5)
    assert np.mean(broken) > 0.05, "float32 throughout is no comparison here"


def moved_far_out(evaluator: Evaluator, offset: float, w: float) -> None:
    """The model matrix moves, turns and stretches the mesh; another lamp stays at the mesh's old place."""
    rng = np.random.default_rng(47)
    centre, matrix = offset * np.array([1.0, -0.7, 0.4]), np.eye(4)
    matrix[:3] = np.c_[[[0.36, -0.8, 0.48], [0.48, 0.6, 0.64], [-0.96, 0.0, 0.72]], centre]
    matrix *= w
    points = rng.uniform(-0.5, 0.5, (200, 3))
    normals = naive.unit(rng.normal((0.0, 0.0, 2.0), size=(200, 3)))
    lamp, eye = np.add(centre, [(0.43, 0.31, 1.27), (-0.33, 0.21, 1.57)])
    lamps = [PointLight(position=lamp), PointLight(position=(0.0, 1.0, 0.0), intensity=0.3)]
    scene = Scene(lamps, Viewer(position=eye, focal_point=centre), UNLIT)
    truth = as_array(shade(points, normals, scene, GLOSSY, matrix=matrix), "unclamped")
    got = evaluator(points, normals, scene, GLOSSY, matrix=matrix).rgb.astype(float)
    assert_within(f"47 matrix {offset:.0e} w={w:g}", abs(got - truth), 1e-5)


OFFSETS = [1e3, 1e6, 1e9, 1e12]
ROWS = {
    f"{row}-{evaluator}": partial(check, evaluator, *arguments)
    for row, check, *arguments in [
        ("41-directional", grazing, False),
        ("41-point", grazing, True),
        *((f"42-cone={angle:g}", cone_edge, angle) for angle in (0.01, 0.3, 1.0, 10.0, 45.0, 90.0)),
        *((f"44-{a}-{at}", light_on_the_vertex, a, at) for a in ATTENUATIONS for at in ((0, 0, 0), (1024, -4096, 3))),
        *((f"45-{r}-two-sided={two}", eye_on_the_vertex, r, two) for r in REFLECTIONS for two in (False, True)),
        *((f"47-{far:.0e}-{t.__name__}", far_out, far, t) for far in OFFSETS for t in (np.float32, np.float64)),
        *((f"47-{far:.0e}-by-matrix-w={w:g}", moved_far_out, far, w) for far in OFFSETS for w in (1.0, -0.3)),
    ]
    for evaluator in EVALUATORS
}


@pytest.mark.parametrize("case", ROWS)
def test_row(case: str) -> None:
    ROWS[case]()
