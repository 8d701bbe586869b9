"""Section E once more, for light from all around: images, directions and lobes that are hard for its harmonics.

The oracle (`sky_oracle`) takes from the lobe what is beyond 32 bands, and integrates what is left over the image by
mpmath. Bounds are roundings, times slopes, in units of what the image would light if all of it stood where the lobe is
highest; a lobe has no slope beyond that of its last band. The part of a lobe above the horizon is known to 1e-11.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache, partial
from itertools import product
from typing import Any

import area_oracle
import mpmath as mp
import numpy as np
import pytest
import sky_oracle as oracle
from stability.bounds import assert_bits, assert_within
from stability.evaluators import EVALUATORS, STEPS, UNLIT, Evaluator
from stability.naive import in_harmonics, least_excess

from pvphong import EnvironmentLight, Material, Scene, Viewer
from pvphong.optics.area.lobes import CosinePower

POWERS = {"diffuse": 1.0, "highlight": 20.0, "mirror": 1e6, "low": 0.7, "flat": 0.0}


def material_of(look: str, power: float | None = None) -> Material:
    if look == "diffuse":
        return Material(ambient=0.0, diffuse=1.0)
    return Material(ambient=0.0, diffuse=0.0, specular=1.0, shininess=POWERS[look] if power is None else power)


def lit(evaluator: Evaluator, normals: Any, light: Any, material: Material, eye: Any, points: Any = None) -> Any:
    points = np.zeros_like(normals, dtype=float) if points is None else points
    scene = Scene([light], Viewer(eye, np.subtract(eye, (0.0, 0.0, 1.0))), UNLIT)
    stored = np.asarray(points, evaluator.real), np.asarray(normals, evaluator.real)
    return evaluator(*stored, scene, material).rgb.astype(float)


def texels(height: int, width: int, seed: int) -> Any:
    return np.random.default_rng(seed).uniform(0.0, 1.0, (height, width, 3))


def sun(brightness: float, rest: float, height: int = 7, width: int = 9) -> Any:
    image = np.full((height, width, 3), rest)
    image[1, 3] = brightness
    return image


SKIES = {
    "one row": EnvironmentLight(texels(1, 5, 1), (0, 1, 0), 37.5),
    "one column": EnvironmentLight(texels(3, 1, 2), (1, 0, 0), 20.0),
    "odd": EnvironmentLight(texels(3, 5, 3).astype(np.float32), (1, 2, -2), -170.0),
    "even": EnvironmentLight(texels(2, 4, 4), (0, 0, 1)),
    "upside down": EnvironmentLight(texels(2, 4, 5), (-3e-4, -1, 0), 90.0),
    "half dark": EnvironmentLight(np.array([1.0, 0.0]).reshape(2, 1, 1) * (1.0, 0.5, 0.25), (0, 0, -4e9)),
    "sun": EnvironmentLight(sun(1e6, 1.0), (0, 1e-9, 1)),
    "sun of 1e30": EnvironmentLight(sun(1e30, 1.0), (-1, 0, 0), 200.0),
    "sun in the dark": EnvironmentLight(sun(1.0, 0.0), (2, 1, 1), 10.0),
}
# A corner of texels where there are four columns and two rows, both poles, and none of these.
WAYS = (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (0.5, -0.25, 1.0)


@cache
def in_bands(sky: str, way: Any, power: float) -> Any:
    light = SKIES[sky]
    with mp.workdps(oracle.DIGITS):
        way = area_oracle.unit(area_oracle.exact_vector(way))
        return oracle.in_bands(light.image.image, light.up, light.rotation, way, power)


def bound(evaluator: Evaluator, light: EnvironmentLight, power: float) -> Any:
    """Of a lobe in bands, which is no higher than the sum of these is in its middle."""
    highest = min(1.0, oracle.BANDS**2 / (2.0 * power + 2.0))
    slope = 2.0 * min(math.sqrt(power), oracle.BANDS) + 16.0
    return 2.0 * evaluator.step * slope * highest * light.panorama.total


def hidden(evaluator: Evaluator, power: float) -> float:
    """Of the part of a lobe above the horizon."""
    return max((math.sqrt(power) + 4.0) * evaluator.step, 1e-11)


def as_its_bands_are(evaluator: Evaluator, sky: str, look: str) -> None:
    """At the normals, and at mirrored viewers, that the ways are."""
    light, power, material = SKIES[sky], POWERS[look], material_of(look)
    for way in WAYS:
        exact = np.array([max(float(x), 0.0) for x in in_bands(sky, way, power)])
        got = lit(evaluator, [way], light, material, np.multiply(way, 4.0))[0]
        assert_within(f"E sky {look}", abs(got - exact), bound(evaluator, light, power))


UP, CAP = (0.0, 0.0, 1.0), (0.25, 0.5, 1.0)
EYES = (0.0, 0.0, 4.0), (3.0, 0.0, 4.0), (4.0, 0.0, 0.004), (4.0, 0.0, 0.0), (4.0, 0.0, -0.25)


@cache
def over_caps(eye: Any, power: float, caps: Any) -> float:
    """1/π · ∫ of the lobe around the mirrored viewer over what caps have in common above the horizon."""
    with mp.workdps(20):
        n, *middles = (area_oracle.unit(area_oracle.exact_vector(x)) for x in (UP, *caps))
        w = area_oracle.mirrored(n, area_oracle.unit(area_oracle.exact_vector(eye)))
        return float(area_oracle.power_over(w, power, [(x, mp.mpf(0)) for x in (n, *middles)]) / mp.pi)


def one_colour(evaluator: Evaluator, power: float) -> None:
    """The furnace: what is above the horizon of a lobe, wherever that cuts it; and of Lambert's cosine, all."""
    light = EnvironmentLight((0.5, 1.0, 0.25), CAP, 20.0)
    for eye in EYES:
        exact = over_caps(eye, power, ()) * np.array(light.image)
        got = lit(evaluator, [UP], light, material_of("", power), eye)[0]
        assert_within("E one colour", abs(got - exact), hidden(evaluator, power) * exact)
    got = lit(evaluator, WAYS, light, material_of("diffuse"), EYES[0])
    assert_within("E furnace", abs(got - light.image), 4 * evaluator.step)


def half_a_sky(evaluator: Evaluator, power: float) -> None:
    """As the docstring says of images: but for the bands beyond, and for what the horizon cuts off a lobe."""
    color = np.array([0.5, 1.0, 0.25])
    light = EnvironmentLight(np.array([1.0, 0.0]).reshape(2, 1, 1) * color, CAP)
    for eye in EYES:
        exact = over_caps(eye, power, (CAP,)) * color
        cut = color / (2.0 * (power + 1.0))
        allowed = bound(evaluator, light, power) + cut + light.left_out(CosinePower("mirror", power), light.bands)
        got = lit(evaluator, [UP], light, material_of("", power), eye)[0]
        assert_within("E half a sky", abs(got - exact), allowed)


@cache
def irradiance(sky: str, way: Any) -> Any:
    light = SKIES[sky]
    with mp.workdps(15):
        way = area_oracle.unit(area_oracle.exact_vector(way))
        return np.array(oracle.irradiance(light.image.image, light.up, light.rotation, way), float)


def left_out(evaluator: Evaluator, sky: str) -> None:
    """Against all bands: off by no more than what the others hold."""
    light = SKIES[sky]
    for way in WAYS:
        exact = irradiance(sky, way)
        allowed = light.left_out(DIFFUSE, light.bands) + bound(evaluator, light, 1.0)
        got = lit(evaluator, [way], light, material_of("diffuse"), EYES[0])[0]
        assert_within("E left out", abs(got - exact), allowed)


def energy(evaluator: Evaluator, sky: str) -> None:
    """White patches all around scatter a quarter of it on average, but for what is cut off below 0."""
    light = SKIES[sky]
    z, weights = np.polynomial.legendre.leggauss(oracle.BANDS)
    around = np.arange(2 * oracle.BANDS) * math.pi / oracle.BANDS
    ring = np.stack([np.cos(around), np.sin(around), np.zeros_like(around)], axis=1)
    ways = np.sqrt(1.0 - z * z)[:, None, None] * ring + z[:, None, None] * np.array([0.0, 0.0, 1.0])
    got = lit(evaluator, ways.reshape(-1, 3), light, material_of("diffuse"), EYES[0])
    assert np.isfinite(got).all()
    assert (got >= 0.0).all()
    mean = weights @ got.reshape(*ways.shape).mean(axis=1) / 2.0
    total = light.panorama.total
    allowed = light.left_out(DIFFUSE, light.bands) + bound(evaluator, light, 1.0)
    assert_within("E energy", abs(mean - total / 4.0), allowed)
    nodes = sum(node.intensity * np.array(node.diffuse) for node in light.nodes(64))
    assert_within("E energy", abs(nodes - total), 64 * STEPS["float64"] * total)


def in_other_units(evaluator: Evaluator, look: str, power: int) -> None:
    """An image times a power of two gives colours times that, to the bit."""
    light = SKIES["odd"]
    brighter = replace(light, image=light.image.image.astype(float) * 2.0**power)
    light = replace(light, image=light.image.image.astype(float))
    got, once = (lit(evaluator, WAYS, x, material_of(look), (1.0, 2.0, 3.0)) for x in (brighter, light))
    assert_bits(f"E sky times 2^k {look}", got, once * 2.0**power)


def everywhere(evaluator: Evaluator, look: str, offset: float) -> None:
    """It is infinitely far away."""
    shift = np.round(np.array([1.0, -0.7, 0.4]) * offset / 1024.0) * 1024.0
    points = np.array([(0.0, 0.0, 0.0), (1024.0, 0.0, 0.0), (0.0, -2048.0, 1024.0)])
    eye = np.array((4096.0, 1024.0, 8192.0))
    here, there = (
        lit(evaluator, WAYS, SKIES["odd"], material_of(look), eye + x, points + x) for x in (np.zeros(3), shift)
    )
    assert_bits(f"E sky far out {look}", there, here)


def no_normal(evaluator: Evaluator, look: str) -> None:
    """Dark; and what is lit where a vertex is nowhere is a number."""
    none = [(0.0, 0.0, 0.0), (math.nan, 0.0, 1.0), (0.0, 0.0, math.inf)]
    for sky in ("odd", "sun"):
        got = lit(evaluator, none, SKIES[sky], material_of(look), EYES[1])
        assert_within(f"E sky, no normal {look}", abs(got), 0.0)
        nowhere = [(math.nan, 0.0, 0.0), (0.0, math.inf, 0.0), EYES[1]]  # the last is the viewer's
        assert np.isfinite(lit(evaluator, [UP] * 3, SKIES[sky], material_of(look), EYES[1], nowhere)).all()


def black(evaluator: Evaluator, look: str) -> None:
    light = EnvironmentLight(np.zeros((3, 5, 3)))
    assert_within(f"E black sky {look}", lit(evaluator, WAYS, light, material_of(look), EYES[1]), 0.0)


DIFFUSE = CosinePower("normal", 1.0)
LOBES = (0.0, 0.7, 3.0, 50.0, 1e6)
ROWS = {
    " ".join(map(str, (name, *arguments, evaluator))): partial(check, evaluator, *arguments)
    for name, check, choices in [
        ("bands", as_its_bands_are, [*product(SKIES, ("diffuse", "highlight")), *product(("even",), POWERS)]),
        ("one colour", one_colour, product(LOBES)),
        ("half", half_a_sky, product(LOBES)),
        ("left out", left_out, product(("one row", "odd", "sun", "half dark"))),
        ("energy", energy, product(SKIES)),
        ("scale", in_other_units, product(("diffuse", "highlight", "mirror"), (-60, 40, 90))),
        ("far out", everywhere, product(("diffuse", "highlight", "mirror"), (1e3, 1e9))),
        ("no normal", no_normal, product(POWERS)),
        ("black", black, product(POWERS)),
    ]
    for arguments in choices
    for evaluator in EVALUATORS
}


@pytest.mark.parametrize("case", ROWS)
def test_row(case: str) -> None:
    ROWS[case]()


def in_points(sky: str) -> tuple[Any, Any]:
    """A sky's texels in 64 parts each: ways to these (k, 3), and what of the first channel each emits, L du."""
    light = SKIES[sky]
    image = light.image.image[..., 0].astype(float).repeat(8, axis=0).repeat(8, axis=1)
    height, width = image.shape
    theta = (np.arange(height) + 0.5)[:, None] * math.pi / height
    phi = ((np.arange(width) + 0.5) / width - 0.5) * 2.0 * math.pi
    local = np.broadcast_arrays(np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta))
    frame = np.array([[float(x) for x in axis] for axis in oracle.axes(light.up, light.rotation)])
    du = 2.0 * math.pi / width * (np.cos(theta - 0.5 * math.pi / height) - np.cos(theta + 0.5 * math.pi / height))
    return np.stack(local, axis=-1).reshape(-1, 3) @ frame, (image * du).ravel()


def naive_excess(sky: str, bands: int, real: Any) -> float:
    light, ways = SKIES[sky], np.array(WAYS) / np.linalg.norm(WAYS, axis=1)[:, None]
    exact = np.array([irradiance(sky, way)[0] for way in WAYS])
    with np.errstate(all="ignore"):
        got = in_harmonics(*in_points(sky), ways, bands, real)
    allowed = light.left_out(DIFFUSE, light.bands) + bound(EVALUATORS[0], light, 1.0)[0]
    return least_excess(abs(got - exact), allowed)


def test_nine_coefficients_are_too_few_for_a_sun() -> None:
    assert naive_excess("sun", 3, np.float64) > 1.0


def test_functions_that_are_not_normalised_leave_float32() -> None:
    """Legendre's of the last bands are beyond 1e38; in float64 the same formula holds."""
    assert naive_excess("odd", 32, np.float64) < 1.0
    assert naive_excess("odd", 32, np.float32) == math.inf
