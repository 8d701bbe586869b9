"""The sphere light: its nodes against the closed form of a sphere's irradiance."""

import math

import numpy as np
import pytest

from pvphong import LightModel, Material, Scene, evaluate
from pvphong.optics.lights import PointLight, SphereLight
from pvphong.optics.lights.sphere import INVERSE_SQUARE

WHITE = Material(ambient=0.0, diffuse=1.0)


def irradiance(distance, radius, tilt):
    """Of a white patch at the origin, its normal tilted against the way to a sphere of intensity 1.

    J. Snyder: Area light sources for real-time graphics (1996): π s² cos θ over the sphere's own colour 1/r² where all
    of it is above the horizon, s the sine of its angular radius.
    """
    s, cosine = radius / distance, math.cos(tilt)
    if cosine >= s:
        return s * s * cosine / radius**2
    if cosine <= -s:
        return 0.0
    sine = math.sin(tilt)
    x = math.sqrt(1.0 / (s * s) - 1.0)
    y = -x * cosine / sine
    q = sine * math.sqrt(1.0 - y * y)
    return ((cosine * math.acos(y) - x * q) * s * s + math.atan(q / x)) / math.pi / radius**2


def patch(light, tilt):
    normal = [[math.sin(tilt), 0.0, math.cos(tilt)]]
    return float(evaluate([[0, 0, 0]], normal, Scene([light]), WHITE, precision="float64").rgb[0, 0])


@pytest.mark.parametrize(("distance", "off"), [(1.5, 0.03), (2.0, 0.015), (5.0, 0.0025), (30.0, 1e-4), (1e6, 1e-12)])
@pytest.mark.parametrize("tilt", [0.0, 0.4, 0.8, 1.2, 1.5])
@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e6])
def test_its_nodes_light_a_patch_as_the_sphere_does(distance, off, tilt, scale):
    light = SphereLight((0, 0, distance * scale), 1.0 * scale, intensity=0.5 * (distance * scale) ** 2)
    exact = 0.5 * distance**2 * irradiance(distance, 1.0, tilt)
    assert patch(light, tilt) == pytest.approx(exact, abs=0.5 * off)


def test_a_point_in_its_place_would_be_wrong():
    exact = irradiance(1.5, 1.0, 1.5)
    point = patch(PointLight((0, 0, 1.5), INVERSE_SQUARE), 1.5)
    assert point < 0.4 * exact
    assert patch(SphereLight((0, 0, 1.5)), 1.5) == pytest.approx(exact, rel=0.02)


def test_more_nodes_come_nearer():
    tilts = np.linspace(0.0, 1.5, 16)
    exact = [irradiance(1.5, 1.0, tilt) for tilt in tilts]
    normals = np.stack([np.sin(tilts), np.zeros(16), np.cos(tilts)], axis=1)
    errors = []
    for count in (1, 16, 256, 4096):
        scene = Scene(SphereLight((0, 0, 1.5)).nodes(count), light_model=LightModel(clamp=False))
        got = evaluate(np.zeros((16, 3)), normals, scene, WHITE, precision="float64").rgb[:, 0]
        errors.append(np.sqrt(np.mean((got - exact) ** 2)))
    assert errors[3] < 0.3 * errors[2] < 0.1 * errors[1]
    assert errors[3] < 1e-3


def test_its_nodes_glow_as_the_derivation_says():
    """(2t − sin 2t)/π of them are within sin t of the middle, for any t."""
    distances = np.linalg.norm([node.position for node in SphereLight(radius=2.0).nodes(4000)], axis=1) / 2.0
    for t in np.linspace(0.2, 1.5, 7):
        share = (2 * t - math.sin(2 * t)) / math.pi
        assert np.mean(distances <= math.sin(t)) == pytest.approx(share, abs=2e-3)
    np.testing.assert_allclose(np.mean([node.position for node in SphereLight().nodes(64)], axis=0), 0, atol=1e-15)
