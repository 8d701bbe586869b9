"""The sphere light: its closed forms and its nodes against a sphere's irradiance, and its highlight by mpmath."""

import math
from dataclasses import replace

import area_oracle as oracle
import mpmath as mp
import numpy as np
import pytest

from pvphong import LightModel, Material, Scene, Viewer, evaluate
from pvphong.optics.attenuation import INVERSE_SQUARE
from pvphong.optics.lights import PointLight, SphereLight

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


@pytest.mark.parametrize("distance", [1.0001, 1.5, 5.0, 1e4])
@pytest.mark.parametrize("tilt", [0.0, 0.8, 1.5, 1.7, 2.5])
@pytest.mark.parametrize("scale", [2.0**-200, 1.0, 2.0**200])
def test_it_lights_a_patch_as_the_sphere_does(distance, tilt, scale):
    light = SphereLight((0, 0, distance * scale), scale, intensity=0.5 * (distance * scale) ** 2)
    assert patch([light], tilt) == pytest.approx(0.5 * distance**2 * irradiance(distance, 1.0, tilt), abs=1e-11)


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("shininess", [0.0, 7.3, 300.0])
def test_its_highlight_is_the_lobes_integral(shininess, precision):
    radius, place, eye = 0.7, np.array([0.6, -0.3, 1.5]), np.array([-1.0, 0.8, 2.0])
    normals = np.array([[0.0, 0.0, 1.0], [0.3, 0.2, 1.0], [-1.0, 1.0, 0.3]])
    scene = Scene([SphereLight(place, radius, ambient=0.5)], Viewer(eye, (0, 0, 0)), LightModel(clamp=False))
    material = Material(ambient=1.0, diffuse=0.0, specular=1.0, shininess=shininess)
    lit = evaluate(np.zeros((3, 3)), normals, scene, material, precision=precision, components=True)
    ambient = 1.0 * 0.5 / (place @ place)
    np.testing.assert_allclose(lit.ambient, ambient + scene.light_model.ambient, rtol=1e-6)
    for normal, got in zip(normals, lit.specular[:, 0], strict=True):
        n, v, l = (oracle.unit(oracle.exact_vector(x)) for x in (normal, eye, place))
        edge = mp.sqrt(1 - mp.mpf(radius) ** 2 / oracle.dot(place, place))
        exact = oracle.power_over(oracle.mirrored(n, v), shininess, [(n, mp.mpf(0)), (l, edge)])
        step = {"float64": 2.0**-53, "float32": 2.0**-24}[precision]
        bound = max(1e-10, (4 * math.sqrt(shininess) + 16) * step)
        assert got == pytest.approx(float(exact / (mp.pi * radius**2)), abs=bound)


def test_inside_it_nothing_arrives():
    scene = Scene([SphereLight((0, 0, 0), 2.0)], Viewer((0, 0, 9)), LightModel(ambient=0.0))
    lit = evaluate([[0, 0, 0], [0, 0, 1.5], [0, 0, 2]], [[0, 0, 1]] * 3, scene, Material(specular=1.0)).rgb
    assert not lit.any()


@pytest.mark.parametrize(("distance", "off"), [(1.5, 0.03), (2.0, 0.015), (5.0, 0.0025), (30.0, 1e-4), (1e6, 1e-12)])
@pytest.mark.parametrize("tilt", [0.0, 0.4, 0.8, 1.2, 1.5])
@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e6])
def test_its_nodes_light_a_patch_as_the_sphere_does(distance, off, tilt, scale):
    light = SphereLight((0, 0, distance * scale), 1.0 * scale, intensity=0.5 * (distance * scale) ** 2)
    exact = 0.5 * distance**2 * irradiance(distance, 1.0, tilt)
    nodes = [replace(node, intensity=light.intensity * node.intensity) for node in light.nodes(64)]
    assert patch(nodes, tilt) == pytest.approx(exact, abs=0.5 * off)


def test_a_point_in_its_place_would_be_wrong():
    exact = irradiance(1.5, 1.0, 1.5)
    point = patch([PointLight((0, 0, 1.5), INVERSE_SQUARE)], 1.5)
    assert point < 0.4 * exact
    assert patch([SphereLight((0, 0, 1.5))], 1.5) == pytest.approx(exact, rel=1e-12)


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
