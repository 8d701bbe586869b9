"""Environment lights against dense sums over the image, closed forms of simple skies, and their error bounds."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest
import pyvista as pv
from sky_oracle import texels
from strategies import Dice

from pvphong import GGX, EnvironmentLight, LightModel, Material, Scene, Viewer, evaluate, plan
from pvphong.optics.area.lobes import CosinePower
from pvphong.shading import kernel

WHITE = Material(ambient=0.0, diffuse=1.0)
MIRRORING = Material(ambient=0.0, diffuse=0.0, specular=1.0)
DIFFUSE = CosinePower("normal", 1.0)
BACKENDS = ("numpy", pytest.param("numba", marks=pytest.mark.skipif(not kernel.is_available(), reason="no Numba")))


def normals_of(seed, count=40):
    found = np.random.default_rng(seed).normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def lit(light, normals, material=WHITE, eye=(0.0, 0.0, 9.0), **options):
    scene = Scene([light], Viewer(eye, (0, 0, 0), (0, 1, 0)), LightModel(ambient=0.0, clamp=False))
    options = {"precision": "float64", "backend": "numpy"} | options
    return evaluate(np.zeros_like(normals), normals, scene, material, **options).rgb


def sky(seed, height=4, width=6, **fields):
    dice = Dice(seed)
    image = np.random.default_rng(seed).uniform(0.0, 1.0, (height, width, 3))
    up = tuple(dice.vector().tolist())
    return EnvironmentLight(image, up, dice.uniform(-180, 180), **fields)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_under_a_white_sky_a_white_patch_is_white_wherever_it_faces(precision, backend):
    """The white furnace test, with one colour and with an image of many texels."""
    normals = normals_of(1, 500)
    for image in (1.0, np.ones((90, 180, 3)), np.ones((3, 4, 3), np.float32)):
        got = lit(EnvironmentLight(image), normals, precision=precision, backend=backend)
        np.testing.assert_allclose(got, 1.0, atol=1e-6)
    half = lit(EnvironmentLight((0.5, 0.2, 0.0), intensity=2.0, diffuse=(1, 1, 0.5)), normals)
    np.testing.assert_allclose(half, np.broadcast_to((1.0, 0.4, 0.0), half.shape), atol=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_it_lights_a_patch_as_its_image_does_within_what_the_bands_beyond_hold(seed):
    light, normals = sky(seed), normals_of(seed)
    ways, areas, colors = texels(light, (48, 48))
    exact = np.array([np.maximum(ways @ n, 0.0) * areas @ colors for n in normals]) / math.pi
    off = np.abs(lit(light, normals) - exact).max()
    assert off <= light.error_without_bands(DIFFUSE, light.bands) + 1e-5 < 2e-3
    few = [np.abs(lit_by_nodes(light, normals, count) - exact).max() for count in (1, 64, 1024)]
    assert few[0] > 5 * few[1] > 10 * few[2] > 20 * off


def lit_by_nodes(light, normals, count, material=WHITE):
    scene = Scene(light.nodes(count), Viewer((0, 0, 9), (0, 0, 0), (0, 1, 0)), LightModel(ambient=0.0, clamp=False))
    return evaluate(np.zeros_like(normals), normals, scene, material, precision="float64", backend="numpy").rgb


@pytest.mark.parametrize("shininess", [4.0, 20.0, 60.0])
def test_its_highlight_is_its_image_blurred_by_the_lobe(shininess):
    light = sky(3)
    ways, areas, colors = texels(light, (48, 48))
    for spread, cut in ((0.25, 1e-4 if shininess > 5 else 0.02), (3.0, 0.5 / (shininess + 1.0))):  # up to the horizon
        normals = normals_of(3) * spread + (0.0, 0.0, 1.0)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        mirrored = 2.0 * normals[:, 2:] * normals - (0.0, 0.0, 1.0)
        lobes = np.maximum(mirrored @ ways.T, 0.0) ** shininess * (normals @ ways.T > 0.0)
        exact = lobes * areas @ colors / math.pi
        off = np.abs(lit(light, normals, dataclasses.replace(MIRRORING, shininess=shininess)) - exact).max()
        assert off <= light.error_without_bands(CosinePower("mirror", shininess), light.bands) + cut


@pytest.mark.parametrize("seed", range(8))
def test_no_band_that_is_left_out_holds_more_than_is_said(seed):
    dice = Dice(seed)
    image = np.random.default_rng(seed).uniform(0.0, 1.0, (dice.randint(1, 20), dice.randint(1, 30), 3))
    image *= np.random.default_rng(seed).random(image.shape) ** dice.choice((0.0, 3.0, 30.0))
    light = EnvironmentLight(image)
    normals = np.concatenate([normals_of(seed, 60), texels(light, (1, 1))[0]])
    material = Material(ambient=0.0, diffuse=0.5, specular=0.5, shininess=dice.choice((0.5, 3.0, 20.0, 500.0)))
    exact = lit(light, normals, material)
    for tolerance in (0.1, 1 / 255, 1e-3):
        scene = Scene([light], Viewer((0, 0, 9), (0, 0, 0), (0, 1, 0)), LightModel(ambient=0.0, clamp=False))
        promised = plan(np.zeros_like(normals), scene, material, tolerance=tolerance).error_bound
        assert promised <= tolerance
        assert np.abs(lit(light, normals, material, tolerance=tolerance) - exact).max() <= promised + 1e-12


def test_a_plan_says_how_many_bands_it_takes():
    light, points = sky(1, name="sky"), np.zeros((1, 3))
    why = {t: plan(points, [light], WHITE, tolerance=t).effects["sky"].why for t in (0.0, 0.05)}
    assert why[0.0].startswith("sky: 32 bands, those beyond 32 add at most 0.000")
    assert "bands from 3 on, at most 0.0" in why[0.05]
    assert plan(points, [EnvironmentLight()], WHITE).effects["sky"].why == "no environment light varies"
    even = plan(points, [sky(1, intensity=1e-3, name="sky")], WHITE, tolerance=0.05).effects
    assert not even["sky"].on


def mirrored_by_facets(light, normals, roughness):
    """Sum D·V·F·n·l over texels (Walter et al. 2007, Heitz 2014) for facets with F = 1, seen from +z."""
    ways, areas, colors = texels(light, (48, 48))
    square, view = roughness**4, np.array([0.0, 0.0, 1.0])
    half = (ways + view) / np.linalg.norm(ways + view, axis=1, keepdims=True)
    result = []
    for n in normals:
        x, y, z = np.maximum(ways @ n, 0.0), n @ view, half @ n
        d = square / (np.pi * (z * z * (square - 1.0) + 1.0) ** 2)
        v = 0.5 / (x * np.sqrt(square + (1 - square) * y * y) + y * np.sqrt(square + (1 - square) * x * x))
        result.append((d * v * x * areas) @ colors)
    return np.array(result)


@pytest.mark.parametrize(("roughness", "most"), [(0.4, 0.02), (0.5, 0.03), (0.7, 0.02), (1.0, 0.03)])
def test_facets_mirror_it_by_as_many_nodes_as_their_lobe_is_narrow(roughness, most):
    """For narrow lobes, 64 nodes are not enough."""
    light, material = sky(4), Material(ambient=0.0, diffuse=0.0, reflectance=GGX(roughness, (1.0, 1.0, 1.0)))
    normals = normals_of(4, 200) * 0.5 + (0.0, 0.0, 1.0)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    exact = mirrored_by_facets(light, normals, roughness)
    found, few = lit(light, normals, material, eye=(0, 0, 1e6)), lit_by_nodes(light, normals, 64, material)

    def off(colors):
        return np.sqrt(np.square(colors - exact).mean()) / exact.mean()

    assert off(found) < most
    assert (off(few) > 5 * most) == (roughness < 0.5)
    assert light.nodes_for(0.0) == light.nodes_for(1.0) == 256
    assert light.nodes_for(1e9) == 1024


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
def test_a_rig_keeps_its_texels_to_the_bit(dtype, tmp_path):
    image = np.random.default_rng(1).uniform(0.0, 3.0, (5, 7, 3)).astype(dtype)
    scene = Scene([EnvironmentLight(image)])
    scene.save(tmp_path / "rig.json")
    (again,) = Scene.load(tmp_path / "rig.json").lights
    np.testing.assert_array_equal(again.image.image, image)
    entry = json.loads((tmp_path / "rig.json").read_text())
    for change, named in (
        ({"width": 8}, "texels"),
        ({"texels": "no"}, "texels"),
        ({"type": "uint8"}, "type"),
        ({"height": 0}, "height"),
    ):
        bad = json.loads(json.dumps(entry))
        bad["lights"][0]["image"] |= change
        (tmp_path / "bad.json").write_text(json.dumps(bad))
        with pytest.raises(ValueError, match=rf"^lights\[0\]\.image\.{named} must be"):
            Scene.load(tmp_path / "bad.json")


def test_a_texture_that_says_it_is_srgb_is_made_linear():
    values = np.array([[[0, 128, 255]]], np.uint8)
    texture = pv.Texture(values)
    texture.SetUseSRGBColorSpace(True)
    light = EnvironmentLight(texture)
    np.testing.assert_allclose(light.image.image[0, 0], (0.0, 0.21586, 1.0), atol=1e-5)
