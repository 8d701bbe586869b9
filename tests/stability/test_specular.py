"""Section D of the catalogue of hard cases: highlights, against the oracle's 80 digits on the stored floats."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from oracle import as_array, shade
from stability import naive
from stability.bounds import assert_within
from stability.evaluators import EVALUATORS, UNLIT, Evaluator

from pvphong import DirectionalLight, LightModel, Material, PointLight, Scene, Viewer

REFLECTIONS = ["phong", "blinn-phong"]
PEAKED = (1e2, 1e4, 1e6)


def chord(shininess: float, step: float) -> float:
    """Return the catalogue's bound on a power of r·v computed from chords."""
    return (4 * math.sqrt(shininess) + 10) * step


def highlight_of(shininess: float) -> Material:
    return Material(ambient=0.0, diffuse=0.0, specular=1.0, shininess=shininess)


def scene_of(to_light: Any, to_viewer: Any, reflection: str = "phong") -> Scene:
    """Return a scene with light and viewer at infinity, so that l and v are these stored vectors."""
    model = LightModel(ambient=0.0, clamp=False, local_viewer=False, reflection=reflection)
    light = DirectionalLight(direction=tuple(-np.asarray(to_light, dtype=float)))
    return Scene([light], Viewer(position=to_viewer, focal_point=(0.0, 0.0, 0.0)), model)


def specular(evaluator: Evaluator, normals: Any, scene: Scene, shininess: float) -> Any:
    shading = evaluator(np.zeros_like(normals), normals, scene, highlight_of(shininess))
    return shading.rgb[:, 0].astype(np.float64)


def exactly(normals: Any, scene: Scene, shininess: float) -> Any:
    return as_array(shade(np.zeros_like(normals), normals, scene, highlight_of(shininess)), "unclamped")[:, 0]


def directions(rng: Any, count: int) -> Any:
    return naive.unit(rng.normal(size=(count, 3)))


def in_highlights(shininess: float, real: Any, reflection: str = "phong", count: int = 40) -> Any:
    """Draw light and viewer in 20 directions, and for each stored normals of any length within the highlight."""
    rng = np.random.default_rng(32)
    for to_light in directions(rng, 20):
        to_viewer = naive.unit(to_light + rng.normal(size=3) * 0.7)
        spread = rng.uniform(0, 1, (count, 1)) / math.sqrt(1.0 + shininess)
        normals = naive.unit(to_light + to_viewer) + spread * rng.normal(size=(count, 3))
        normals = (normals * 10.0 ** rng.uniform(-2, 2, (count, 1))).astype(real)
        yield normals, to_light, to_viewer, scene_of(to_light, to_viewer, reflection)


# --- 32: near the peak ---


def near_the_peak(evaluator: Evaluator, shininess: float, reflection: str = "phong") -> None:
    """The relative error is bounded down to half of the peak, the absolute error everywhere."""
    bound, label = chord(shininess, evaluator.step), f"32 n={shininess:.0e} {reflection}"
    relative, absolute, broken = [], [], 0
    for normals, to_light, to_viewer, scene in in_highlights(shininess, evaluator.real, reflection):
        truth, observed = exactly(normals, scene, shininess), specular(evaluator, normals, scene, shininess)
        near = truth > 0.5
        absolute += list(abs(observed - truth))
        relative += list(abs(observed - truth)[near] / truth[near])
        by_cosine = naive.highlight(normals, *np.array([[to_light], [to_viewer]], evaluator.real), shininess)
        broken += np.count_nonzero(abs(by_cosine - truth)[near] > bound * truth[near])
    assert len(relative) > 120
    assert_within(label, relative, bound)
    assert_within(f"{label} absolute", absolute, bound)
    assert reflection != "phong" or broken > 0.05 * len(relative), "the cosine is no comparison here"


# --- 33: the peak itself ---


def at_the_peak(evaluator: Evaluator, shininess: float, reflection: str = "phong") -> None:
    """For N = L = V and normals of any length, the lobe is exactly 1, with light and viewer near or far."""
    rng = np.random.default_rng(33)
    stored = (directions(rng, 300) * 10.0 ** rng.uniform(-3, 3, (300, 1))).astype(evaluator.real)
    observed = []
    for n in stored:
        ahead = n.astype(float)
        local = LightModel(ambient=0.0, clamp=False, reflection=reflection)
        near = Scene([PointLight(position=8.0 * ahead)], Viewer(position=2.0 * ahead), local)
        for scene in (scene_of(ahead, ahead, reflection), near):
            observed += list(specular(evaluator, n[None], scene, shininess))
    assert_within(f"33 n={shininess:.0e} {reflection}", np.abs(np.array(observed) - 1.0), 0.0)
    by_cosine = naive.highlight(stored, stored, stored, shininess)
    assert np.mean(by_cosine > 1.0) > 0.1, "the cosine is no comparison here"
    if evaluator.precision == "float32" and shininess == 1e6:
        assert by_cosine.max() > 1.3


# --- 35: subnormal results ---


def subnormal(evaluator: Evaluator, shininess: float) -> None:
    """Powers around and below the least normal number of the precision."""
    tiny = float(np.finfo(evaluator.real).tiny)
    bound = 2e-38 if evaluator.precision == "float32" else 3.0 * tiny
    cosines = np.exp((math.log(tiny) + np.linspace(2.0, -20.0, 200)) / shininess)
    half = np.arccos(cosines) / 2.0
    normals = np.stack([np.sin(half), 0.0 * half, np.cos(half)], axis=1).astype(evaluator.real)
    scene = scene_of((0.0, 0.0, 1.0), (0.0, 0.0, 1.0))
    truth, observed = exactly(normals, scene, shininess), specular(evaluator, normals, scene, shininess)
    assert (truth > tiny).any()
    assert ((truth > 0.0) & (truth < tiny)).any()
    assert_within(f"35 n={shininess:.0e}", abs(observed - truth), bound)


# --- 36: 0 to the power of 0 ---

UPWARD = np.array([[0.0, 0.0, 1.0]])
# Vectors to light and viewer with r·v (Phong) or n·h (Blinn-Phong) exactly 0 or negative, and their n·l. Opposite
# vectors have no h.
OPPOSITE = ((0, 0, 1), (0, 0, -1), 1)
PERPENDICULAR = {
    "phong": [
        ((1, 0, 1), (1, 0, 1), 1),
        ((3, 0, 4), (4, 0, 3), 1),
        ((0, 0, 1), (0, 1, 0), 1),
        ((1, 0, 0), (0, 0, 1), 0),
    ],
    "blinn-phong": [OPPOSITE, ((1, 0, 2), (0, 1, -2), 1), ((3, 0, 4), (0, 3, -4), 1), ((1, 0, 0), (0, 1, 0), 0)],
}


def zero_to_the_zero(evaluator: Evaluator, reflection: str) -> None:
    """Shininess 0 gives 1 for any viewer if the light is above the horizon, else 0."""
    wrong, upward = [], UPWARD.astype(evaluator.real)
    for to_light, to_viewer, above in PERPENDICULAR[reflection]:
        for side in (1, -1):  # the light above and below the horizon
            scene = scene_of(np.array(to_light) * (1, 1, side), to_viewer, reflection)
            expected = float(above and side == 1)
            wrong += list(specular(evaluator, upward, scene, 0.0) != expected)
    for shininess in (0.01, 3.0):
        wrong += list(specular(evaluator, upward, scene_of(*OPPOSITE[:2], "blinn-phong"), shininess) != 0.0)
    assert_within(f"36 {reflection}", wrong, 0.0)


# --- 37: powers below 1 ---


def turned_away(evaluator: Evaluator, shininess: float, convention: str) -> None:
    """The mirror direction points away from the viewer, and the light still reaches the vertex."""
    rng = np.random.default_rng(37)
    expected = 1e-5**shininess if convention == "vtk" else 0.0
    model = replace(LightModel.vtk(two_sided=False), clamp=False) if convention == "vtk" else UNLIT
    errors = []
    for _ in range(100):
        n, to_light, to_viewer = directions(rng, 3)
        to_light *= np.sign(n @ to_light)
        mirrored = 2.0 * (n @ to_light) * n - to_light
        to_viewer *= -np.sign(mirrored @ to_viewer)
        if min(n @ to_light, -mirrored @ to_viewer) < 1e-3:
            continue
        # A second, black light: VTK has a special code path for a single light.
        lights = [DirectionalLight(direction=-to_light), DirectionalLight(intensity=0.0)]
        scene = Scene(lights, Viewer(position=to_viewer * 4.0), model)
        errors += list(specular(evaluator, n[None].astype(evaluator.real), scene, shininess) - expected)
    assert_within(f"37 n={shininess:g} {convention}", np.abs(errors), 10 * evaluator.step)


# --- 38: any shininess; invalid values are in optics/test_fields ---


def large(evaluator: Evaluator, shininess: float) -> None:
    """The lobe is 1 at the peak and exact off the peak, down to 0 far from it."""
    scene = scene_of((0.0, 0.0, 1.0), (0.0, 0.0, 1.0))
    tilts = np.array([0.0, 0.1, 1.0, 3.0, 1e3]) / math.sqrt(shininess)
    normals = np.stack([tilts, 0.0 * tilts, np.ones_like(tilts)], axis=1).astype(evaluator.real)
    truth, observed = exactly(normals, scene, shininess), specular(evaluator, normals, scene, shininess)
    assert_within(f"38 n={shininess:.0e}", abs(observed - truth), chord(shininess, evaluator.step))
    assert observed[0] == 1.0


ROWS = {
    f"{row}-{evaluator}": partial(check, evaluator, *arguments)
    for row, check, *arguments in [
        *((f"32-n={n:.0e}-{r}", near_the_peak, n, r) for n in PEAKED for r in REFLECTIONS),
        *((f"33-n={n:.0e}", at_the_peak, n) for n in PEAKED),
        ("33-n=1e+06-blinn-phong", at_the_peak, 1e6, "blinn-phong"),
        *((f"35-n={n:.0e}", subnormal, n) for n in (1e2, 1e4)),
        *((f"36-{r}", zero_to_the_zero, r) for r in REFLECTIONS),
        *((f"37-n={n:g}-{c}", turned_away, n, c) for n in (0.01, 0.1, 0.5, 0.9) for c in ("standard", "vtk")),
        *((f"38-n={n:.0e}", large, n) for n in (1e3, 1e6, 1e9)),
    ]
    for evaluator in EVALUATORS
}


@pytest.mark.parametrize("case", ROWS)
def test_row(case: str) -> None:
    ROWS[case]()
