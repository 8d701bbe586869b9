"""`mesh.phong.truth` against results known without path tracing: furnaces, integrating spheres, evaluators."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import pyvista as pv
from ray_backends import BACKENDS
from rays.rooms import hollow, room

import pvphong as ph
from pvphong.base import threads
from pvphong.base.text import listening
from pvphong.optics.light import Arrival
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.panorama import directions, row_areas
from pvphong.optics.photometry import Photometry
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.optics.surface import Surface
from pvphong.rays import casting
from pvphong.shading.reference import lobe_factors

RANDOM = np.random.default_rng(1)
MODEL = ph.LightModel(ambient=0.0, clamp=False)
EYE = ph.Viewer(position=(0.5, -1.5, 4.0))
SKY = np.full((8, 16, 3), 0.1)
SKY[1, 4], SKY[4:] = (3.0, 2.0, 1.0), 0.2

LIGHTS = {
    "directional": ph.DirectionalLight((-1, -1, -2)),
    "disk": ph.DiskLight((0.5, -0.5, 2), (-0.2, 0.1, -1), 0.6, intensity=2.0),
    "environment": ph.EnvironmentLight(SKY, up=(0, 0.3, 1), rotation=20.0),
    "photometric": ph.PhotometricLight(Photometry("C", "0 60 180", "0 90", ("9 5 1", "9 7 2")), (0.5, -0.5, 2)),
    "point": ph.PointLight((1, 1, 3)),
    "polygon": ph.PolygonLight([(0, 0, 2), (0.2, 1, 2), (1, 0.3, 2)], two_sided=True),
    "rectangle": ph.RectangleLight((0.5, -0.5, 2), (-0.2, 0.1, -1), width=1.5, height=0.7),
    "sphere": ph.SphereLight((0.5, -0.5, 2), 0.6, diffuse=(1.0, 0.5, 0.2), specular=(0.2, 0.5, 1.0)),
    "spot": ph.SpotLight.at((1, 1, 3), target=(0, 0, 0), cone_angle=40.0),
}
SHINY = {
    "blinn-phong": ph.BlinnPhong(40.0),
    "ggx": ph.GGX(0.4, (1.0, 0.8, 0.3)),
    "metal": ph.Metal((1.0, 0.8, 0.3), 20.0),
    "modified-phong": ph.ModifiedPhong(20.0),
    "oren-nayar": ph.OrenNayar(25.0),
    "pbr": ph.PBR(0.5, 0.4),
    "phong": ph.Phong(20.0),
    "retro": ph.Retro(10.0),
    "ward": ph.Ward(0.15, 0.4),
}


def patches(count=24):
    """Return points below the lights with roughly upward normals, and tangents."""
    normals = RANDOM.normal(size=(count, 3)) * 0.5 + (0.0, 0.0, 1.0)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    cloud = pv.PolyData(RANDOM.uniform(-0.5, 0.5, (count, 3)))
    cloud.point_data.active_normals = normals
    return cloud, np.cross(normals, RANDOM.normal(size=(count, 3)))


PATCHES, TANGENTS = patches()


def scene(*lights, **model):
    return ph.Scene(lights, EYE, replace(MODEL, **model))


def floor(height=0.0, up=1.0, size=2.0, cells=4):
    sizes = {"i_size": size, "j_size": size, "i_resolution": cells, "j_resolution": cells}
    return pv.Plane(center=(0, 0, height), direction=(0, 0, up), **sizes)


def assert_agrees(truth, expected, most=5.0, slack=0.0):
    """Assert agreement within a number of standard errors, at each vertex and on average."""
    off = truth.rgb - expected
    error = np.hypot(truth.standard_error, slack) + 1e-12
    assert np.abs(off / error).max() < most
    together = math.sqrt((truth.standard_error**2).sum()) / truth.rgb.size
    assert abs(off.mean()) < 4.0 * together * math.sqrt(3.0) + slack + 1e-12  # the channels share their paths


# --- bounced light


@pytest.mark.parametrize("shape", [hollow, room])
@pytest.mark.parametrize("rho", [0.2, 0.8, 0.95])
def test_inside_of_a_furnace_it_is_equally_bright(shape, rho):
    """B = e + ρB."""
    material = ph.Material(diffuse=(rho, 0.5 * rho, 0.0), emission=(0.3, 0.2, 0.1))
    truth = shape().phong.truth(scene(), material, samples=128)
    expected = np.array([0.3, 0.2, 0.1]) / (1.0 - np.array([rho, 0.5 * rho, 0.0]))
    np.testing.assert_allclose(truth.rgb.mean(axis=0), expected, rtol=0.02)
    off = (truth.rgb - expected)[:, :2] / truth.standard_error[:, :2]
    assert np.abs(np.mean(off)) < 0.3
    assert np.abs(off).max() < 8.0


@pytest.mark.parametrize("bounces", [0, 1, 2, None])
def test_an_integrating_sphere_is_lit_evenly_by_what_it_reflects(bounces):
    """All parts of a sphere receive the same from each other: ρ(D + (ρ + ρ² + …) I/R²), D the direct light."""
    ball, rho, intensity = hollow(4), 0.6, 2.0
    lamp = ph.PointLight((0.3, 0.2, 0.1), (0, 0, 1), intensity=intensity)
    truth = ball.phong.truth(scene(lamp), ph.Material(diffuse=rho), samples=16, max_bounces=bounces)
    to_lamp = np.array(lamp.position) - ball.points
    direct = -intensity * (ball.points * to_lamp).sum(axis=1) / np.linalg.norm(to_lamp, axis=1) ** 3
    bounced = sum(rho**k for k in range(1, (60 if bounces is None else bounces) + 1)) * intensity
    assert truth.rgb.mean() == pytest.approx(rho * (direct.mean() + bounced), rel=5e-3)
    if bounces == 0:
        np.testing.assert_allclose(truth.rgb[:, 0], rho * direct, rtol=1e-6)
        assert not truth.standard_error.any()
        assert truth.rays == ball.n_points


def test_bounces_are_those_that_transport_gathers():
    """Transport between vertices is equal, except for details finer than triangles."""
    mesh, lamp = room(8), ph.RectangleLight((0, 0, 0.4), width=0.3, height=0.2, intensity=0.3)
    material = ph.Material(diffuse=(0.7, 0.5, 0.3), emission=0.02)
    for bounces in (1, 3):
        lights = scene(lamp, shadows=True, bounces=bounces)
        truth = mesh.phong.truth(lights, material, samples=64, max_bounces=bounces).rgb
        gathered = mesh.phong.shade(lights, material)["phong"]
        np.testing.assert_allclose(gathered.mean(axis=0), truth.mean(axis=0), rtol=0.02)
        assert np.abs(gathered - truth).mean() < 0.05 * truth.mean()


def test_no_light_is_lost_or_made():
    """The power that a room absorbs, ∫ (1 − ρ)/ρ B dA, equals the power of its lamp, 4πI."""
    mesh, rho = room(12), np.array([0.8, 0.5, 0.2])
    lamp = ph.SphereLight((0.1, 0.05, -0.2), 0.1, intensity=1.5)
    truth = mesh.phong.truth(scene(lamp), ph.Material(diffuse=tuple(rho)), samples=64)
    corners = mesh.faces.reshape(-1, 4)[:, 1:]
    received = (truth.rgb / rho)[corners].mean(axis=1).sum(axis=0) / (2 * 12**2)
    np.testing.assert_allclose(received * (1.0 - rho), 4.0 * math.pi * 1.5, rtol=0.01)


def test_standard_errors_are_honest():
    """Vertices at one point have independent paths, so their spread must match their standard errors."""
    place = pv.PolyData(np.tile((0.1, 0.2, -0.5), (600, 1)))
    place.point_data.active_normals = np.tile((0.0, 0.0, 1.0), (600, 1))
    material = ph.Material(diffuse=0.5, specular=0.3, shininess=10.0)
    mesh = pv.MultiBlock({"place": place, "": room(1)})
    lights = scene(ph.SphereLight((0.1, 0.05, -0.2), 0.1, intensity=0.1), ph.PointLight((0.2, 0, 0.2), (0, 0, 1)))
    few, more = (mesh.phong.truth(lights, material, samples=count, max_bounces=2)["place"] for count in (32, 256))
    for truth in (few, more):
        assert (truth.standard_error**2).mean() == pytest.approx(truth.rgb.var(), rel=0.2)
    assert few.rgb.mean() == pytest.approx(more.rgb.mean(), abs=5.0 * few.rgb.std() / math.sqrt(600))
    assert more.standard_error.mean() < 0.5 * few.standard_error.mean()
    scores = (more.rgb - more.rgb.mean()) / more.standard_error
    assert 1.0 < scores.std() < 1.2  # 1.07 by Student's distribution, for 16 rounds
    assert (np.abs(scores) < 2.13).mean() == pytest.approx(0.95, abs=0.02)
    other = mesh.phong.truth(lights, material, samples=32, max_bounces=2, seed=1)["place"]
    assert abs(np.corrcoef(few.rgb[:, 0], other.rgb[:, 0])[0, 1]) < 0.15


def test_walls_seen_from_behind_block_and_are_black():
    ground, lamp = floor(), ph.PointLight((0, 0, 0.5), (0, 0, 1))
    white = ph.Material(diffuse=0.8)
    for up, two_sided, is_lit in ((-1.0, False, True), (1.0, False, False), (1.0, True, True)):
        stage = pv.MultiBlock({"ground": ground, "ceiling": floor(1.0, up)})
        lights = scene(lamp, two_sided=two_sided)
        truth = stage.phong.truth(lights, white, max_bounces=1, samples=64)
        direct = ground.phong.truth(lights, white, max_bounces=0)
        bounced = truth["ground"].rgb - direct.rgb
        assert (bounced > 0.02).all() if is_lit else not bounced.any()
    sun = scene(ph.DirectionalLight((0, 0, -1)))
    shaded = pv.MultiBlock({"ground": ground, "ceiling": floor(1.0, -1.0)}).phong.truth(sun, white, max_bounces=0)
    assert not shaded["ground"].rgb.any()


def test_occluders_are_black_and_blocks_are_not():
    ground, lamp, red = floor(), ph.PointLight((0, 0, 0.5), (0, 0, 1)), ph.Material(diffuse=(0.8, 0.0, 0.0))
    white = ph.Material(diffuse=0.8)
    alone = ground.phong.truth(scene(lamp), white, max_bounces=1, samples=16)
    under = ground.phong.truth(scene(lamp), white, max_bounces=1, samples=16, occluders=[floor(1.0, -1.0)])
    np.testing.assert_array_equal(under.rgb, alone.rgb)
    assert not under.standard_error.any()
    stage = pv.MultiBlock({"ground": ground, "ceiling": floor(1.0, -1.0)})
    truth = stage.phong.truth(scene(lamp), {"ground": white, "ceiling": red}, max_bounces=1, samples=128)
    assert (truth["ground"].rgb[:, 0] > alone.rgb[:, 0] + 0.02).all()
    np.testing.assert_array_equal(truth["ground"].rgb[:, 1:], alone.rgb[:, 1:])
    assert set(truth) == {"ground", "ceiling"}


def test_albedo_is_interpolated_where_paths_meet_a_surface():
    """Patches close under a triangle with a colour at each corner receive the interpolated colour above them."""
    corners = np.array([(0, 0, 0), (0, 10, 0), (10, 0, 0)], float)
    ceiling = pv.PolyData(corners, [3, 0, 1, 2])
    ceiling.point_data.active_normals = np.tile((0.0, 0.0, -1.0), (3, 1))
    ceiling["paint"] = np.eye(3)
    weights = np.array([(0.8, 0.1, 0.1), (0.1, 0.8, 0.1), (0.1, 0.1, 0.8), (0.2, 0.3, 0.5)])
    patches = pv.PolyData(weights @ corners - (0, 0, 1e-2))
    patches.point_data.active_normals = np.tile((0.0, 0.0, 1.0), (4, 1))
    stage, white = pv.MultiBlock({"patches": patches, "ceiling": ceiling}), ph.Material(diffuse=1.0)
    lamp, paint = ph.PointLight((3, 1, -3), (0, 0, 1), intensity=9.0), ph.Material(diffuse=1.0, albedo="paint")
    truth = stage.phong.truth(scene(lamp), {"patches": white, "ceiling": paint}, max_bounces=1, samples=256)["patches"]
    lit = 27.0 / np.linalg.norm(weights @ corners - lamp.position, axis=1) ** 3
    np.testing.assert_allclose(truth.rgb, weights * lit[:, None], atol=0.02 * lit.max())
    assert lit.max() > 2.0 * lit.min()


def test_a_surface_reflects_towards_where_the_path_comes_from():
    """A retroreflecting ceiling over a lamp beneath a patch: (s + 2)/2 · I/π ∫ cos⁴ θ du over the ceiling."""
    patch = pv.PolyData(np.tile((0.0, 0.0, 0.0), (100, 1)))
    patch.point_data.active_normals = np.tile((0.0, 0.0, 1.0), (100, 1))
    stage = pv.MultiBlock({"patch": patch, "ceiling": floor(1.0, -1.0, size=50.0)})
    back = ph.Material(diffuse=0.0, specular=1.0, reflectance=ph.Retro(20.0))
    lamp = ph.PointLight((0, 0, -1e-3), (0, 0, 1), intensity=0.1)
    materials = {"patch": ph.Material(diffuse=0.5), "ceiling": back}
    truth = stage.phong.truth(scene(lamp), materials, max_bounces=1, samples=64)["patch"]
    assert truth.rgb.mean() == pytest.approx(0.5 * 0.1 * 22.0 / 5.0, rel=0.01)


# --- direct light


@cache
def arriving(name):
    """Return directions (3, k, n) from the patches to parts of a light, and the arriving colours (3, k, n)."""
    light, points = LIGHTS[name], PATCHES.points.T.astype(np.float64)
    if name == "environment":
        cells = SKY.repeat(12, axis=0).repeat(12, axis=1)
        to_sky = (directions(96, 192) @ light.axes).reshape(-1, 3).T
        colors = (cells * row_areas(96, 192)[:, None, None] / math.pi).reshape(-1, 3).T
        return tuple(np.repeat(each[:, :, None], points.shape[1], axis=2) for each in (to_sky, colors))
    nodes = light.nodes(2048)
    found = [node.arrival(points) for node in nodes]
    shape = 3, len(nodes), len(PATCHES.points)
    to_light = np.stack([np.broadcast_to(each.direction, points.shape) for each in found], axis=1)
    strength = [each.strength * node.intensity * np.ones(shape[2]) for each, node in zip(found, nodes, strict=True)]
    return to_light, np.broadcast_to(light.intensity * np.stack(strength), shape)


def by_parts(reflectance, name, diffuse, specular):
    """Return the light that patches reflect, as a sum over many parts of the light."""
    to_light, arrives = arriving(name)
    bound, shape = reflectance.of(ph.Material(diffuse=diffuse)), to_light.shape
    n, t = PATCHES.point_data.active_normals.T.astype(np.float64), TANGENTS.T.astype(np.float64)
    v = np.array(EYE.position)[:, None] - PATCHES.points.T
    n, t, v = (np.broadcast_to(w[:, None, :], shape).reshape(3, -1) for w in (n, t, v / np.linalg.norm(v, axis=0)))
    with np.errstate(all="ignore"):
        surface = Surface(n, np.ones(n.shape[1]), v, t)
        factors = lobe_factors(bound, surface, Arrival(to_light.reshape(3, -1), 1.0), [True] * 3)
    colors = {"diffuse": (diffuse, LIGHTS[name].diffuse), "specular": (specular, LIGHTS[name].specular_color)}
    total = np.zeros((3, shape[2]))
    for lobe, factor in zip(bound.lobes, factors, strict=True):
        own, shining = colors[lobe.component]
        color = np.array(lobe.color) * (1.0 if lobe.is_own else own) * shining
        total += color[:, None] * (factor.reshape(shape[1:]) * arrives).sum(axis=1)
    return total.T


def test_every_light_and_every_reflectance_is_here():
    assert LIGHTS.keys() == LIGHT_TYPES.keys()
    assert SHINY.keys() == REFLECTANCES.keys()


@pytest.mark.parametrize("light", LIGHTS)
@pytest.mark.parametrize("name", SHINY)
def test_direct_light_is_the_sum_over_parts_of_lights(name, light):
    material = ph.Material(diffuse=(0.6, 0.5, 0.4), specular=0.4, reflectance=SHINY[name], tangents=TANGENTS)
    truth = PATCHES.phong.truth(scene(LIGHTS[light]), material, samples=512, max_bounces=0)
    expected = by_parts(SHINY[name], light, (0.6, 0.5, 0.4), 0.4)
    if LIGHTS[light].has_size:
        assert_agrees(truth, expected, slack=2e-3 * expected.max())
        assert 0.0 < truth.standard_error.max() < 0.2 * expected.max()
    else:
        np.testing.assert_allclose(truth.rgb, expected, rtol=1e-9, atol=1e-12)
        assert not truth.standard_error.any()


MAPS = {
    "colours": {
        "diffuse": RANDOM.random((24, 3)),
        "specular": RANDOM.random((24, 3)),
        "shininess": 9.0 * RANDOM.random(24),
    },
    "both": {"diffuse": RANDOM.random((24, 3)), "albedo": RANDOM.random((24, 3))},
    "albedo": {"albedo": RANDOM.random((24, 3)), "emission": RANDOM.random((24, 3)), "specular": 0.3, "shininess": 5.0},
    "roughness": {"reflectance": ph.GGX(0.1 + 0.8 * RANDOM.random(24), 0.5), "albedo": RANDOM.random((24, 3))},
    "metallic": {"reflectance": ph.PBR(RANDOM.random(24), 0.4), "albedo": RANDOM.random((24, 3))},
}
MODELS = {
    "standard": {},
    "two-sided": {"two_sided": True},
    "parallel": {"local_viewer": False, "two_sided": True},
    "blinn": {"reflection": "blinn-phong"},
}


@pytest.mark.parametrize("maps", MAPS)
@pytest.mark.parametrize("model", MODELS)
def test_what_varies_from_vertex_to_vertex_and_with_the_light_model_is_that_of_evaluators(maps, model):
    lights, material = scene(LIGHTS["spot"], LIGHTS["directional"], **MODELS[model]), ph.Material(**MAPS[maps])
    cloud = PATCHES.copy()
    cloud.point_data.active_normals = PATCHES.point_data.active_normals * np.repeat((1, -1), 12)[:, None]
    arrays = cloud.points, cloud.point_data.active_normals
    expected = ph.evaluate(*arrays, lights, material, precision="float64", backend="numpy").rgb
    np.testing.assert_allclose(cloud.phong.truth(lights, material, max_bounces=0).rgb, expected, rtol=1e-9, atol=1e-12)
    assert (expected[:, 0] > 0.0).any()


@pytest.mark.parametrize("away", [1e3, 1e8])
@pytest.mark.parametrize("kind", [ph.SphereLight, ph.DiskLight])
def test_a_light_far_away_is_a_point(kind, away):
    light, point = kind((0, 0, away), intensity=away**2), ph.PointLight((0, 0, away), (0, 0, 1), intensity=away**2)
    material = ph.Material(diffuse=0.5, specular=0.4, shininess=20.0)
    truth, expected = (PATCHES.phong.truth(scene(each), material, max_bounces=0, samples=16) for each in (light, point))
    np.testing.assert_allclose(truth.rgb, expected.rgb, atol=2e-3)


@pytest.mark.parametrize("light", [name for name, light in LIGHTS.items() if light.has_size])
def test_direct_light_of_lights_with_a_size_is_exact(light):
    """Closed forms of Lambert's and Phong's reflection, with small and large lights."""
    material = ph.Material(diffuse=(0.6, 0.5, 0.4), specular=0.4, shininess=30.0)
    for each in (LIGHTS[light], replace(LIGHTS[light], radius=1e-3) if light in ("sphere", "disk") else LIGHTS[light]):
        truth = PATCHES.phong.truth(scene(each), material, samples=1024, max_bounces=0)
        points, normals = PATCHES.points, PATCHES.point_data.active_normals
        exact = ph.evaluate(points, normals, scene(each), material, precision="float64", backend="numpy").rgb
        assert_agrees(truth, exact, slack=1e-5 if light != "environment" else 1e-2)
        if light != "environment":  # sampling the light dominates
            assert truth.standard_error.mean() < 2e-3 * exact.mean()


@pytest.mark.parametrize("light", [name for name, light in LIGHTS.items() if light.has_size])
def test_a_light_behind_a_wall_is_hidden_however_it_is_found(light):
    material = ph.Material(diffuse=0.5, specular=0.4, shininess=5.0)
    given = scene(LIGHTS[light]), material
    truth = PATCHES.phong.truth(
        *given, samples=64, max_bounces=0, occluders=[pv.Cube(x_length=2, y_length=2, z_length=2)]
    )
    assert not truth.rgb.any()


def test_a_light_that_lies_on_a_wall_is_not_hidden_by_it():
    light, material = ph.RectangleLight((0, 0, 2), width=1.5), ph.Material(diffuse=0.5, specular=0.4, shininess=5.0)
    free, on_wall = (
        PATCHES.phong.truth(scene(light), material, samples=64, max_bounces=0, occluders=occluders)
        for occluders in ([], [floor(2.0, size=9.0)])
    )
    np.testing.assert_allclose(on_wall.rgb, free.rgb, rtol=1e-4)
    assert free.rgb.any()


def test_a_mirror_shows_a_light_that_only_its_reflection_finds():
    """Smooth facets and a small light; points sampled on the light contribute almost nothing."""
    light = ph.SphereLight((0.0, 0.0, 3.0), 0.5)
    middle = pv.PolyData(np.zeros((1, 3)))
    middle.point_data.active_normals = np.array([[0.0, 0.0, 1.0]])
    truth = middle.phong.truth(
        ph.Scene([light], ph.Viewer(position=(0, 0, 5)), MODEL),
        ph.Material(diffuse=0.0, reflectance=ph.GGX(0.02, 1.0)),
        max_bounces=0,
    )
    np.testing.assert_allclose(truth.rgb, 4.0, rtol=0.01)  # the light's radiance, I/r²
    assert truth.standard_error.max() < 0.1


@pytest.mark.parametrize("name", SHINY)
def test_directions_are_chosen_with_the_density_that_is_told(name):
    reflectance, rows = SHINY[name].of(ph.Material(diffuse=0.5, shininess=9.0)), 256
    height, around = np.meshgrid(
        (np.arange(rows) + 0.5) * 2.0 / rows - 1.0, (np.arange(2 * rows) + 0.5) * math.pi / rows, indexing="ij"
    )
    height, around, count = height.ravel(), around.ravel(), 2 * rows * rows
    level = np.sqrt(1.0 - height * height)
    anywhere = np.stack([level * np.cos(around), level * np.sin(around), height])
    n, v, t = (np.array(w)[:, None] * np.ones(count) for w in ((0.0, 0, 1), (0.6, 0, 0.8), (0.8, 0.6, 0)))
    surface = Surface(n, np.ones(count), v, t)
    found = reflectance.directions(surface)
    if found is None:
        assert not any(lobe.component == "specular" for lobe in reflectance.lobes)
        return
    chosen = found.sample(*np.random.default_rng(3).random((2, count)))
    assert {round(float(length), 6) for length in np.linalg.norm(chosen, axis=0)} <= {0.0, 1.0}
    lost = (np.linalg.norm(chosen, axis=0) == 0.0).mean()
    density = found.density(anywhere) * (4.0 * math.pi)
    assert density.mean() == pytest.approx(1.0 - lost, abs=3e-3)
    np.testing.assert_allclose((density * anywhere).mean(axis=1), chosen.mean(axis=1), atol=5e-3)
    factors = np.stack(lobe_factors(reflectance, surface, Arrival(chosen, 1.0), [True] * 3)[1:])
    assert np.isfinite(factors).all()
    assert (found.density(chosen)[factors.max(axis=0) > 1e-9] > 0.0).all()


# --- difficult input


@pytest.mark.parametrize("backend", BACKENDS)
def test_whoever_casts_the_rays(backend, monkeypatch):
    mesh, lamp = room(2), scene(ph.SphereLight((0.1, 0.05, -0.2), 0.1, intensity=0.1))
    expected = mesh.phong.truth(lamp, ph.Material(diffuse=0.5), samples=16)
    monkeypatch.setattr(casting, "ray_backend", lambda: (BACKENDS[backend], ""))
    truth = mesh.phong.truth(lamp, ph.Material(diffuse=0.5), samples=16)
    assert np.median(np.abs(truth.rgb - expected.rgb)) < 1e-4  # rays that hit edges may differ
    assert truth.rgb.mean() == pytest.approx(expected.rgb.mean(), rel=0.05)


def test_equal_calls_give_equal_bits_whatever_the_number_of_threads(monkeypatch):
    monkeypatch.setattr(casting.Occluders, "rays_at_once", 2**13)
    mesh = room(3)
    lights = scene(ph.RectangleLight((0, 0, 0.4), width=0.3, height=0.3), ph.PointLight((0, 0.2, 0)))
    material = ph.Material(diffuse=0.5, specular=0.2, shininess=5.0)
    seen = []
    with listening(lambda what, part: seen.append((what, part))):
        truth = mesh.phong.truth(lights, material, samples=64)
    assert seen[-1] == ("paths of light", 1.0)
    assert len(seen) > 1
    with threads.limited(1):
        again = mesh.phong.truth(lights, material, samples=50)  # rounded up to a power of two
    for name in ("rgb", "standard_error", "rays"):
        np.testing.assert_array_equal(getattr(again, name), getattr(truth, name))
    other = mesh.phong.truth(lights, material, samples=64, seed=1)
    assert (other.rgb != truth.rgb).all()
    assert repr(truth).startswith("<Truth of 96 vertices, standard error 0.")


def test_an_interrupted_call_is_over_at_once():
    def stop(_what, part):
        if part > 0.1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), listening(stop):
        room(8).phong.truth(scene(ph.SphereLight()), samples=64, max_bounces=0)


@pytest.mark.parametrize("offset", [0.0, 1e7])
def test_a_matrix_moves_mesh_and_normals(offset):
    mesh, matrix = room(2), np.diag([2.0, 2.0, -2.0, 1.0])
    matrix[:3, 3] = offset
    lamp = ph.PointLight(tuple(matrix[:3, :3] @ (0.1, 0.2, 0.3) + offset), (0, 0, 0.25))
    material = ph.Material(diffuse=0.5)
    expected = mesh.phong.truth(scene(ph.PointLight((0.1, 0.2, 0.3), (0, 0, 1))), material, samples=64)
    moved = mesh.phong.truth(scene(lamp), material, samples=64, matrix=matrix)
    assert_agrees(replace(moved, standard_error=np.hypot(moved.standard_error, expected.standard_error)), expected.rgb)


def test_spoiled_vertices_have_finite_colours_and_harm_no_other():
    mesh = room(2)
    material = ph.Material(diffuse=0.5, specular=0.3, shininess=5.0, emission=0.1)
    lights = scene(ph.SphereLight((0, 0, 0), 0.1), ph.EnvironmentLight(), ph.PointLight((0.2, 0.2, 0.2)))
    mesh.points = mesh.points.astype(np.float64)
    normals = np.array(mesh.point_data.active_normals)
    mesh.points[0], normals[5] = np.nan, 0.0
    mesh.point_data.active_normals = normals
    truth = mesh.phong.truth(lights, material, samples=16)
    assert np.isfinite(truth.rgb).all()
    assert np.isfinite(truth.standard_error).all()
    np.testing.assert_allclose(truth.rgb[5], 0.1)
    for broken in (pv.PolyData(np.zeros((3, 3)), [3, 0, 1, 2]), pv.PolyData(np.full((3, 3), np.nan), [3, 0, 1, 2])):
        broken.point_data.active_normals = np.tile((0.0, 0.0, 1.0), (3, 1))
        assert np.isfinite(broken.phong.truth(lights, material, samples=16).rgb).all()


def test_a_vertex_inside_of_a_sphere_that_glows_gets_nothing_of_it():
    truth = floor().phong.truth(scene(ph.SphereLight((0, 0, 0), 5.0)), samples=16, max_bounces=0)
    assert not truth.rgb.any()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"samples": 0}, r"^samples must be a finite number >= 1 and <= 65536; got 0\.$"),
        ({"samples": 1e9}, r"^samples must be a finite number >= 1"),
        ({"max_bounces": -1}, r"^max_bounces must be a finite number >= 0; got -1\.$"),
        ({"seed": -1}, r"^seed must be a finite number >= 0"),
        ({"occluders": pv.Sphere()}, r"^occluders must be a sequence of meshes.*Put a single mesh into a list"),
        ({"material": ph.Material(diffuse=1.2)}, r"^diffuse must be at most 1 in each channel.*got up to 1\.2 of"),
        ({"material": ph.Material(reflectance=ph.Ward(0.1, 0.2))}, r"^tangents must be known for this reflectance"),
        ({"scene": ph.Scene(light_model=ph.LightModel.vtk())}, r"^light_model must be in the standard .*vtk"),
    ],
)
def test_bad_input_is_refused(options, message):
    mesh = pv.Plane()
    mesh.clear_data()
    with pytest.raises(ValueError, match=message):
        mesh.phong.truth(**options)


def test_more_than_all_is_scattered_where_it_does_not_bounce():
    mesh = floor()
    mesh["paint"] = np.full((mesh.n_points, 3), 0.5)
    bright = ph.Material(diffuse=1.5)
    sun = scene(ph.DirectionalLight((0, 0, -1)))
    np.testing.assert_allclose(mesh.phong.truth(sun, bright, max_bounces=0).rgb, 1.5)
    np.testing.assert_allclose(mesh.phong.truth(sun, replace(bright, albedo="paint"), samples=16).rgb, 0.75)
