"""The sphere light's nodes; its closed forms are judged in tests/stability/test_lights_with_a_size.py."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pvphong import Material, Scene, evaluate
from pvphong.optics.lights import SphereLight

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


def patch(lights, tilt):
    normal = [[math.sin(tilt), 0.0, math.cos(tilt)]]
    return float(evaluate([[0, 0, 0]], normal, Scene(lights), WHITE, precision="float64").rgb[0, 0])


@pytest.mark.parametrize(("distance", "off"), [(1.5, 0.03), (2.0, 0.015), (5.0, 0.0025), (30.0, 1e-4), (1e6, 1e-12)])
@pytest.mark.parametrize("tilt", [0.0, 0.4, 0.8, 1.2, 1.5])
@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e6])
def test_its_nodes_light_a_patch_as_the_sphere_does(distance, off, tilt, scale):
    light = SphereLight((0, 0, distance * scale), 1.0 * scale, intensity=0.5 * (distance * scale) ** 2)
    exact = 0.5 * distance**2 * irradiance(distance, 1.0, tilt)
    nodes = [replace(node, intensity=light.intensity * node.intensity) for node in light.nodes(64)]
    assert patch(nodes, tilt) == pytest.approx(exact, abs=0.5 * off)


def test_its_nodes_glow_as_the_derivation_says():
    """(2t − sin 2t)/π of them are within sin t of the middle, for any t."""
    distances = np.linalg.norm([node.position for node in SphereLight(radius=2.0).nodes(4000)], axis=1) / 2.0
    for t in np.linspace(0.2, 1.5, 7):
        share = (2 * t - math.sin(2 * t)) / math.pi
        assert np.mean(distances <= math.sin(t)) == pytest.approx(share, abs=2e-3)
    np.testing.assert_allclose(np.mean([node.position for node in SphereLight().nodes(64)], axis=0), 0, atol=1e-15)
