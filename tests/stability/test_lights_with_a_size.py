"""Section E for area lights and environment lights: hard positions for them and for their evaluators.

Bounds are absolute, in units of the light's intensity over the squared distance to its centre, or of 1 if that is less:
1e-9 in float64, and the bound of `evaluate` in float32. The integrals themselves are tested in optics/test_area, also
for lights cut by the horizon and lobes that reach an edge; invalid lights are in optics/test_fields.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache, partial
from itertools import product
from typing import Any

import numpy as np
import pytest
import sky_oracle
from stability.bounds import assert_within
from stability.evaluators import EVALUATORS, UNLIT, Evaluator

from pvphong import DiskLight, EnvironmentLight, Material, PolygonLight, RectangleLight, Scene, SphereLight, Viewer

EYE = (0.3, -0.4, 5.0)
LOOKS = {"diffuse": (1.0, 0.0, 0.0), "highlight": (0.0, 1.0, 20.0), "mirror": (0.0, 1.0, 1e6), "flat": (0.0, 1.0, 0.0)}


def lit(
    evaluator: Evaluator, points: Any, normals: Any, light: Any, look: str, eye: Any = EYE, stored: Any = None
) -> Any:
    scene = Scene([light], Viewer(eye, np.add(eye, (0.0, 0.0, -1.0))), UNLIT)
    vertices = (np.asarray(each, stored or evaluator.real) for each in (points, normals))
    diffuse, specular, shininess = LOOKS[look]
    material = Material(ambient=0.0, diffuse=diffuse, specular=specular, shininess=shininess)
    return evaluator(*vertices, scene, material).rgb[:, 0].astype(float)


def bound(evaluator: Evaluator, look: str) -> float:
    return max((4 * math.sqrt(LOOKS[look][2]) + 16) * evaluator.step * 2, 1e-9)


MIDDLE = (0.4, 0.2, 1.5)
SPHERE = SphereLight(MIDDLE, 0.6)
SQUARE = RectangleLight(MIDDLE, (-0.2, -0.1, -1.0), (0.3, 1.0, 0.0), 1.0, 0.7)
DISK = DiskLight(MIDDLE, (-0.2, -0.1, -1.0), 0.6)
POLYGON = PolygonLight([(-1, -1, 1.2), (-1, 1, 1.2), (0.5, 1, 1.2), (1, 0.2, 1.2), (0.2, -1, 1.2)])


def in_another_unit(evaluator: Evaluator, light: Any, look: str, power: int) -> None:
    """Scaling by a power of two changes only 1/d²."""
    unit, scaled = 2.0**power, {}
    for field in light.roles:
        value = getattr(light, field)
        scaled[field] = (
            value
            if isinstance(value, bool)
            else tuple(map(tuple, np.multiply(value, unit)))
            if field == "corners"
            else np.multiply(value, unit).tolist()
        )
    there = replace(light, **scaled, intensity=unit**2)
    points, normals = np.array([(0.1, 0.2, 0.0), (-0.5, 0.3, 0.1)]), [(0.1, 0, 1), (1, 0.3, 0.2)]
    got = lit(evaluator, points * unit, normals, there, look, tuple(np.multiply(EYE, unit)))
    assert_within(f"E scale {look}", abs(got - lit(evaluator, points, normals, light, look)), 4 * evaluator.step)


def far_from_the_origin(evaluator: Evaluator, light: Any, look: str, offset: float) -> None:
    shift = np.round(np.array([1.0, -0.7, 0.4]) * offset)
    points, normals = np.array([(0.125, 0.25, 0.0), (-0.5, 0.375, 0.125)]), [(0.1, 0, 1), (1, 0.3, 0.2)]
    here = light.moved(lambda place: tuple((np.round(np.multiply(place, 16)) / 16).tolist()))
    there = here.moved(lambda place: tuple(np.add(place, shift).tolist()))
    eye = np.add((0.25, -0.5, 5.0), shift)
    a, b = (
        lit(evaluator, p, normals, each, look, e, stored=np.float64)
        for p, each, e in ((points + shift, there, eye), (points, here, (0.25, -0.5, 5.0)))
    )
    assert_within(f"E far out {look}", abs(a - b), bound(evaluator, look))


def nowhere_to_be_seen(evaluator: Evaluator, light: Any, look: str) -> None:
    """Vertices on, inside or behind the light, in its plane, without a normal or not finite are dark, never NaN.

    Environment lights have no position and light vertices anywhere.
    """
    places = [*map(np.array, light.places), np.array([math.nan, 0, 0]), np.array([0, math.inf, 0])]
    if hasattr(light, "normal"):
        middle, normal = np.array(light.center), np.array(light.normal)
        across = light.outline[0] - middle
        places += [middle - 1e-9 * normal, middle - 2.0 * normal]
        edge = lit(evaluator, [middle, middle + 0.25 * across, middle + 3.0 * across], [(0, 0, 1)] * 3, light, look)
        assert np.isfinite(edge).all()
    got = lit(evaluator, np.array(places), [(0.1, 0.2, 1.0)] * len(places), light, look)
    assert np.isfinite(got).all()
    assert not got[~np.isfinite(places).all(axis=1)].any() or light.is_uniform
    bad = lit(evaluator, [(0, 0, 0)] * 3, [(0, 0, 0), (math.nan, 0, 1), (0, 0, math.inf)], light, look)
    assert_within(f"E no normal {look}", abs(bad), 0.0)


# --- images of skies: a sun makes their harmonics hard

WAYS = (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (0.5, -0.25, 1.0)


def sun(brightness: float, rest: float) -> Any:
    image = np.full((7, 9, 3), rest)
    image[1, 3] = brightness
    return image


def texels(height: int, width: int) -> Any:
    return np.random.default_rng(height).uniform(0.0, 1.0, (height, width, 3))


# The directions are a corner of texels in a 4 × 2 image, both poles, and a general one.
SKIES = {
    "one row": EnvironmentLight(texels(1, 5), (0, 1, 0), 37.5),
    "one column": EnvironmentLight(texels(3, 1), (1, 0, 0), 20.0),
    "odd": EnvironmentLight(texels(3, 5).astype(np.float32), (1, 2, -2), -170.0),
    "even": EnvironmentLight(texels(2, 4), (0, 0, 1)),
    "upside down": EnvironmentLight(texels(2, 4), (-3e-4, -1, 0), 90.0),
    "half dark": EnvironmentLight(np.array([1.0, 0.0]).reshape(2, 1, 1) * (1.0, 0.5, 0.25), (0, 0, -4e9)),
    "sun": EnvironmentLight(sun(1e6, 1.0), (0, 1e-9, 1)),
    "sun of 1e30": EnvironmentLight(sun(1e30, 1.0), (-1, 0, 0), 200.0),
    "sun in the dark": EnvironmentLight(sun(1.0, 0.0), (2, 1, 1), 10.0),
}


@cache
def in_bands(sky: str, way: Any, power: float) -> float:
    return max(sky_oracle.in_bands(SKIES[sky], way, power)[0], 0.0)


def as_its_bands_are(evaluator: Evaluator, sky: str, look: str) -> None:
    """The directions are used as normals, and as mirror directions.

    The oracle truncates the lobe after 32 bands. A truncated lobe is not higher than the sum of its bands at its centre
    and not steeper than its last band.
    """
    power, bands = LOOKS[look][2] if LOOKS[look][1] else 1.0, sky_oracle.BANDS
    steep = min(1.0, bands**2 / (2.0 * power + 2.0)) * (2.0 * min(math.sqrt(power), bands) + 16.0)
    for way in WAYS:
        got = lit(evaluator, [(0, 0, 0)], [way], SKIES[sky], look, np.multiply(way, 4.0))[0]
        allowed = 2.0 * evaluator.step * steep * SKIES[sky].panorama.total[0]
        assert_within(f"E sky {look}", abs(got - in_bands(sky, way, power)), allowed)


def shown(argument: Any) -> str:
    """Return the test id of an argument; for a light the name of its class."""
    kind = argument if isinstance(argument, type) else type(argument)
    return str(argument) if kind in (str, float, int) else kind.__name__


BOTH, SIZED = ("diffuse", "highlight"), (SPHERE, SQUARE, POLYGON, DISK)
ROWS = {
    " ".join([name, *map(shown, arguments), str(evaluator)]): partial(check, evaluator, *arguments)
    for name, check, choices in [
        ("scale", in_another_unit, product(SIZED, BOTH, (-60, 40))),
        ("far out", far_from_the_origin, product((*SIZED, SKIES["odd"]), BOTH, (1e3, 1e9))),
        ("dark", nowhere_to_be_seen, product((SPHERE, SQUARE, POLYGON, DiskLight((0, 0, 1)), SKIES["sun"]), LOOKS)),
        ("bands", as_its_bands_are, [*product(SKIES, BOTH), *product(["even"], LOOKS)]),
    ]
    for arguments in choices
    for evaluator in EVALUATORS
}


@pytest.mark.parametrize("case", ROWS)
def test_row(case: str) -> None:
    ROWS[case]()
