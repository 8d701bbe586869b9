"""Directional lights with an apparent size: quadrature over the disk, penumbrae in closed form, the path tracer."""

from __future__ import annotations

import math

import area_oracle as oracle
import mpmath as mp
import numpy as np
import pytest
import pyvista as pv
from rays.rooms import wall
from strategies import unit

import pvphong as ph

SUN = 0.533
ANGLES = (1e-6, SUN, 10.0, 90.0)
OPEN = ph.LightModel(ambient=0.0, clamp=False)
MATT = ph.Material(ambient=0.0, diffuse=1.0)


def shaded(light, normals, material=MATT, viewer=None, precision="float64", **options):
    scene = ph.Scene([light], viewer or ph.Viewer(), OPEN)
    found = ph.evaluate(np.zeros((len(normals), 3)), normals, scene, material, precision=precision, **options)
    return found.rgb[:, 0]


def over_disk(count=400):
    """Return Gauss-Legendre nodes over the unit disk: fractions of its area, angles, and weights of mean 1."""
    t, w = np.polynomial.legendre.leggauss(count)
    share, phi = (t + 1.0) / 2.0, np.arange(count) * 2.0 * math.pi / count
    return np.repeat(share, count), np.tile(phi, count), np.repeat(w / 2.0 / count, count)


def over_patch(angle, towards, function):
    """Integrate a function of directions over a patch of the sky, times 1/(π sin² α)."""
    share, phi, weight = over_disk()
    alpha = math.radians(angle / 2.0)
    less = 2.0 * math.sin(alpha / 2.0) ** 2 * share  # 1 − cos
    aside = np.sqrt(less * (2.0 - less))
    x = unit(np.cross(towards, (0.3, 0.4, -0.9)))
    ways = (1 - less)[:, None] * towards + aside[:, None] * (
        np.cos(phi)[:, None] * x + np.sin(phi)[:, None] * np.cross(towards, x)
    )
    return (function(ways) * weight).sum() * 2.0 / (1.0 + math.cos(alpha))


@pytest.mark.parametrize("angle", ANGLES)
def test_a_facing_surface_gets_the_intensity_at_any_angle(angle):
    light = ph.DirectionalLight((0.3, -0.2, -1.0), angle, intensity=700.0)
    assert shaded(light, [(-0.3, 0.2, 1.0)])[0] == pytest.approx(700.0, rel=1e-13)


@pytest.mark.parametrize("angle", ANGLES)
def test_diffuse_light_is_the_integral_over_the_disk(angle):
    """The sun high, low, half set, and set: the horizon cuts it within its radius."""
    towards, alpha = unit(np.array([0.2, -0.3, 0.8])), angle / 2.0
    across = unit(np.cross(towards, (1.0, 0.0, 0.0)))
    for altitude in (80.0, 2.0 * alpha if alpha < 40 else 50.0, 0.5 * alpha, 0.0, -0.5 * alpha, -1.01 * alpha, -60.0):
        turn = math.radians(altitude)
        n = math.sin(turn) * towards + math.cos(turn) * across
        exact = over_patch(angle, towards, lambda ways, n=n: np.maximum(ways @ n, 0.0))
        found = shaded(ph.DirectionalLight(-towards, angle), [n])[0]
        assert found == pytest.approx(exact, rel=2e-4, abs=2e-5 * math.sin(math.radians(alpha))), altitude


@pytest.mark.parametrize("angle", [SUN, 20.0])
@pytest.mark.parametrize("power", [3.0, 300.0, 1e5])
def test_a_highlight_is_the_power_over_the_disk(angle, power):
    """mpmath integrates over the cap: the light in the middle of the lobe, at its edge, and cut by the horizon."""
    towards, alpha = np.array([0.0, 0.0, 1.0]), math.radians(angle / 2.0)
    scale = math.pi * math.sin(alpha) ** 2
    for off, height in ((0.0, 0.9), (0.7 * alpha, 0.9), (2.0 * alpha, 0.5), (0.3 * alpha, math.sin(0.4 * alpha))):
        mirrored = np.array([math.sin(off), 0.0, math.cos(off)])
        n = unit(np.array([0.0, math.sqrt(1.0 - height**2), height]))
        eye = 2.0 * (mirrored @ n) * n - mirrored
        shiny = ph.Material(ambient=0.0, diffuse=0.0, specular=1.0, shininess=power)
        found = shaded(ph.DirectionalLight(-towards, angle), [n], shiny, ph.Viewer(1e6 * eye))[0]
        caps = [([mp.mpf(0), mp.mpf(0), mp.mpf(1)], mp.cos(alpha)), (oracle.unit(oracle.exact_vector(n)), mp.mpf(0))]
        with mp.workdps(20):
            exact = float(oracle.power_over(oracle.unit(oracle.exact_vector(mirrored)), power, caps)) / scale
        assert found == pytest.approx(exact, rel=1e-6, abs=1e-9), (off, height)


def test_without_an_angle_it_is_what_it_was_and_a_small_angle_joins_it():
    normals = np.random.default_rng(1).normal(size=(50, 3))
    way = (0.3, -0.2, -1.0)
    glossy = ph.Material(ambient=0.0, diffuse=0.6, specular=0.4, shininess=30.0)
    point = shaded(ph.DirectionalLight(way), normals, glossy)
    assert not ph.DirectionalLight(way).has_size
    np.testing.assert_array_equal(shaded(ph.DirectionalLight(way, 0.0), normals, glossy), point)
    for angle in (1e-9, 1e-3, 0.1):
        near = shaded(ph.DirectionalLight(way, angle), normals, glossy)
        np.testing.assert_allclose(near, point, atol=10.0 * math.radians(angle) ** 2 + 1e-9)


@pytest.mark.parametrize(
    "reflectance", [ph.GGX(roughness=0.3), ph.BlinnPhong(200.0), ph.OrenNayar(sigma=30.0)], ids=repr
)
def test_other_reflectances_see_a_patch_by_a_few_lights(reflectance):
    light = ph.DirectionalLight((0.0, 0.0, -1.0), SUN)
    assert light.nodes_for(reflectance.sharpness) <= 8
    glossy = ph.Material(ambient=0.0, specular=0.5, reflectance=reflectance)
    tilts = np.linspace(0.0, 1.5, 40)
    normals = np.stack([np.sin(tilts), 0.0 * tilts, np.cos(tilts)], axis=1)
    by_many = sum(
        node.intensity * shaded(ph.DirectionalLight(node.direction), normals, glossy) for node in light.nodes(1024)
    )
    np.testing.assert_allclose(shaded(light, normals, glossy), by_many, rtol=4e-3, atol=1e-4)


def test_a_straight_edge_has_a_penumbra_of_the_disks_segment():
    """Below an edge at height h, the visible part is that of a disk of radius h tan α beyond a straight line.

    A low sun's disk is projected to an ellipse, farther away: its radius is h α / sin² of the altitude.
    """
    height, alpha, altitude = 2.0, math.radians(SUN / 2.0), math.radians(40.0)
    roof = pv.Plane(center=(-2.0, 0, height), i_size=4.0, j_size=4.0)  # larger ones move the rays' origins
    for direction, reach, shift in (
        ((0, 0, -1), height * math.tan(alpha), 0.0),
        (
            (math.cos(altitude), 0, -math.sin(altitude)),
            height * alpha / math.sin(altitude) ** 2,
            height / math.tan(altitude),
        ),
    ):
        t = np.linspace(-1.2, 1.2, 97)
        floor = pv.PolyData(np.stack([shift + reach * t, 0.01 * np.sin(9 * t), 0.0 * t], axis=1))
        floor.point_data.active_normals = np.tile(np.float32((0, 0, 1)), (len(t), 1))
        seen = floor.phong.visibility(ph.DirectionalLight(direction, SUN), occluders=[roof], samples=1024)
        cut = np.clip(-t, -1.0, 1.0)  # of the disk, the part beyond a line at t radii is hidden
        exact = (np.arccos(cut) - cut * np.sqrt(1.0 - cut**2)) / math.pi
        np.testing.assert_allclose(seen.per_light[0], exact, atol=0.012)
        assert np.abs(seen.per_light[0] - exact).mean() < 0.003


def test_the_path_tracer_agrees_in_shadow_and_in_highlights():
    """A ball above a glossy floor; the tracer samples the patch, and finds it by chance too."""
    floor = wall((0, 0, 0), (0, 0, 1), size=3.0, cells=10)
    ball = pv.Sphere(radius=0.4, center=(0.2, 0.1, 0.8), theta_resolution=60, phi_resolution=60)
    sun = ph.DirectionalLight((0.2, 0.1, -1.0), 15.0)
    viewer = ph.Viewer(position=(0.5, 0.3, 4.0))
    scene = ph.Scene([sun], viewer, ph.LightModel(ambient=0.0, clamp=False, shadows=True))
    glossy = ph.Material(ambient=0.0, diffuse=0.7, reflectance=ph.ModifiedPhong(20.0), specular=0.2)
    for material, allowed in ((MATT, 0.02), (glossy, 0.04)):
        found = floor.phong.shade(scene, material, occluders=[ball])["phong"][:, 0]
        truth = floor.phong.truth(scene, material, occluders=[ball], samples=256, max_bounces=0)
        assert found.min() < 0.3 < 0.6 < found.max()
        assert np.abs(found - truth.rgb[:, 0]).mean() < 0.5 * allowed
        # where the ball hides a part of the patch, its highlight is scaled as the diffuse light is
        assert np.quantile(np.abs(found - truth.rgb[:, 0]), 0.95) < 2.0 * allowed


def test_a_plan_takes_a_small_sun_as_parallel_light():
    ball = pv.Sphere()
    scene = ph.Scene([ph.DirectionalLight((1, 0, -1), SUN)])
    decision = ball.phong.plan(scene, MATT, tolerance=0.02).effects["size"]
    assert not decision.on
    assert "parallel light" in decision.why
    kept = ball.phong.plan(scene, MATT)
    assert kept.effects["size"].on
    assert kept.effects["size"].why.endswith("diffuse exact")
    glossy = ph.Material(reflectance=ph.GGX(0.3), specular=0.5)
    assert "by 8 nodes" in ball.phong.plan(scene, glossy).effects["size"].why


def test_nothing_that_is_off_the_way_to_the_patch_is_tested():
    """The plan leaves shadows out if no occluder is within the cones from the mesh to the patch, and only then."""
    floor = pv.Cube(center=(0, 0, -0.5)).triangulate()  # convex, so that it does not hide the light itself
    model = ph.LightModel(shadows=True)
    for x, angle, on in ((4.5, 20.0, False), (4.5, 90.0, True), (0.0, 0.5, True), (60.0, 10.0, False)):
        scene = ph.Scene([ph.DirectionalLight((0, 0, -1), angle)], light_model=model)
        beside = pv.Cube(center=(x, 0, 5.0))
        assert floor.phong.plan(scene, occluders=[beside]).effects["shadow"].on == on, (x, angle)


def test_visibility_of_another_angle_is_refused():
    floor, model = wall((0, 0, 0), (0, 0, 1)), ph.LightModel(shadows=True)
    suns = [ph.Scene([ph.DirectionalLight((0, 0, -1), angle)], light_model=model) for angle in (0.0, 0.5, 1.0)]
    for made, used in ((0, 1), (1, 0), (1, 2)):
        with pytest.raises(ValueError, match=r"^visibility must be computed for the current lights"):
            floor.phong.shade(suns[used], visibility=floor.phong.visibility(suns[made]))


@pytest.mark.parametrize("angle", [-1.0, 91.0, math.nan, "wide"])
def test_an_angle_out_of_range_is_refused(angle):
    with pytest.raises(ValueError, match=r"^angle must be a finite number >= 0 and <= 90"):
        ph.DirectionalLight(angle=angle)
