"""Importance sampling of lights: mean weights equal the exact integrals, and all points are on the light."""

import math

import numpy as np
import pytest

import pvphong as ph
from pvphong.base import sobol
from pvphong.optics.area.lobes import CosinePower, lobe_numbers

RANDOM = np.random.default_rng(5)
LIGHTS = {
    "sphere": ph.SphereLight((0.3, 0.2, 2.5), radius=0.7),
    "sphere far away": ph.SphereLight((3e5, 2e5, 2.5e6), radius=0.7),
    "rectangle": ph.RectangleLight((0, 0, 1.5), (0.3, 0.1, -1), width=1.5, height=0.5),
    "near rectangle": ph.RectangleLight((0, 0, 1.1), (0.1, 0.1, -1), width=9.0, height=4.0),
    "two sides": ph.RectangleLight((0, 0, 0.2), (0.3, 0.1, -1), two_sided=True),
    "disk": ph.DiskLight((0, 0.2, 1.5), (0.3, 0.1, -1), radius=0.8),
    "near disk": ph.DiskLight((0, 0, 1.1), (0.1, 0.1, -1), radius=3.0),
    "polygon": ph.PolygonLight([(0, 0, 2), (0, 1, 2), (0.4, 0.4, 2), (1, 0, 2)]),
    "polygon with a corner on a side": ph.PolygonLight([(0, 0, 2), (0, 1, 2), (1, 0, 2), (0.5, 0, 2)]),
    "one colour": ph.EnvironmentLight(0.5),
    "sky": ph.EnvironmentLight(
        np.linspace(0.2, 1.0, 16)[:, None, None] * np.ones((16, 32, 3)), up=(0, 0.2, 1), rotation=30
    ),
}
POINTS = RANDOM.uniform(-1, 1, (60, 3))
NORMALS = RANDOM.normal(size=(60, 3)) + np.array([0, 0, 1])
NORMALS /= np.linalg.norm(NORMALS, axis=1)[:, None]


def frame_of(light, real=np.float64):
    """Return a light's sampling, numbers, reach and scale, and the frame at each point."""
    sampling, numbers = light.sampling, np.asarray(light.sampling.numbers, float)
    with np.errstate(all="ignore"):
        reach, scale, *frame = sampling.frame(numbers, POINTS.T, NORMALS.T)
    return sampling, numbers, reach, scale, [np.broadcast_to(np.asarray(each, real), len(POINTS)) for each in frame]


def sampled(light, count=4096):
    """Return colours at intensity 1, directions (3, k, n), lengths and weights (k, n)."""
    sampling, numbers, reach, scale, frame = frame_of(light, np.float32)
    first, second = sobol.seeds(np.arange(len(POINTS)))
    u = sobol.coordinate(np.arange(count, dtype=np.uint32)[:, None], first)
    v = sobol.coordinate(sobol.SECOND[:count, None], second)
    with np.errstate(all="ignore"):
        direction, share, weight = sampling.sample(numbers, frame, u, v)
    assert {each.dtype for each in (*direction, np.asarray(share), weight)} == {np.dtype(np.float32)}
    return scale * weight.mean(axis=0), np.array(direction), np.float64(share) * reach, weight


def exact(light):
    """Return the colour of a white diffuse surface, by the light's closed form."""
    found = np.zeros(len(POINTS))
    for tint, part in light.tints():
        integral = part.analytic_integral(CosinePower("normal", 1.0))
        d = np.array(integral.place)[:, None] - POINTS.T
        numbers = np.array(integral.numbers), np.array(lobe_numbers(1.0))
        with np.errstate(all="ignore"):
            found += np.mean(tint) * integral.formula(*numbers, d, NORMALS.T, NORMALS.T)
    return found


@pytest.mark.parametrize("name", LIGHTS)
def test_the_mean_of_weights_is_what_arrives(name):
    light = LIGHTS[name]
    expected, (found, direction, _, weight) = exact(light), sampled(light)
    np.testing.assert_allclose(found, expected, atol=3e-3 * expected.max())
    np.testing.assert_allclose((direction**2).sum(axis=0), 1.0, atol=1e-6)
    assert (weight >= 0.0).all()


@pytest.mark.parametrize("name", [name for name, light in LIGHTS.items() if not light.is_uniform])
def test_rays_end_on_the_light(name):
    light = LIGHTS[name]
    _, direction, length, weight = sampled(light, 64)
    ends = np.where(
        weight > 0.0, POINTS.T[:, None, :] + direction * length, np.array(light.places).mean(axis=0)[:, None, None]
    )
    integral = light.analytic_integral(CosinePower("normal", 1.0))
    off, size = ends - np.array(integral.place)[:, None, None], np.linalg.norm(integral.place) + 1.0
    if hasattr(light, "normal"):
        assert np.abs(np.tensordot(light.normal, off, 1)).max() < 1e-6 * size
        assert np.linalg.norm(off, axis=0).max() <= integral.radius + 1e-6 * size
    else:
        distance = np.linalg.norm(off, axis=0)[weight > 0.0]
        np.testing.assert_allclose(distance, light.radius, atol=1e-6 * size)


@pytest.mark.parametrize("name", LIGHTS)
def test_what_is_seen_along_a_direction_is_the_point_that_gave_it(name):
    """`seen` returns the distance of `sample`; radiance over its density gives the weight."""
    light = LIGHTS[name]
    sampling, numbers, _, scale, frame = frame_of(light)
    with np.errstate(all="ignore"):
        u, v = RANDOM.random((2, 256, len(POINTS)))
        chosen, share, weight = sampling.sample(numbers, frame, u, v)
        direction = np.stack([np.broadcast_to(each, u.shape) for each in chosen]).astype(float)
        found, density = sampling.seen(numbers, frame, direction)
        radiance = np.broadcast_to(light.radiance(direction.reshape(3, -1)), (3, u.size)).mean(axis=0).reshape(u.shape)
        cosine = np.maximum((NORMALS.T[:, None, :] * direction).sum(axis=0), 0.0)
        expected = radiance * cosine / (math.pi * density) / scale
        beside = sampling.seen(numbers, frame, -direction)
    sent = weight > 0.0
    assert sent.any()
    np.testing.assert_allclose(expected[sent], weight[sent], rtol=1e-5)
    np.testing.assert_allclose(*(np.broadcast_to(each, u.shape)[sent] for each in (found, share)), rtol=1e-6)
    if not light.is_uniform:
        assert not beside[1].any()


@pytest.mark.parametrize("name", ["rectangle", "near rectangle", "disk", "polygon", "sphere", "one colour", "sky"])
def test_densities_are_of_all_directions_to_a_light(name):
    (sampling, numbers, *_, frame), count = frame_of(LIGHTS[name]), 2**14
    u, v = RANDOM.random((2, count, len(POINTS)))
    z, around = 2.0 * u - 1.0, 2.0 * math.pi * v
    level = np.sqrt(1.0 - z * z)
    with np.errstate(all="ignore"):
        density = sampling.seen(numbers, frame, np.stack([level * np.cos(around), level * np.sin(around), z]))[1]
    whole, error = 4.0 * math.pi * density.mean(axis=0), 4.0 * math.pi * density.std(axis=0) / math.sqrt(count)
    assert (np.abs(whole - 1.0) < 5.0 * error + 1e-6).all()


def test_the_edge_of_a_far_sphere_is_not_lost_to_rounding():
    """The cone's 1 − cos is 8e-14. As a difference in float32 it is 0, and all rays go to the centre."""
    light = LIGHTS["sphere far away"]
    _, direction, _, _ = sampled(light, 256)
    middle = np.array(light.position)[:, None] - POINTS.T
    distance = np.linalg.norm(middle, axis=0)
    off = np.linalg.norm(direction - (middle / distance)[:, None, :], axis=0) * distance / light.radius
    assert 0.1 < off.std() < 0.5  # directions round by 6e-8 of 2.5e6 units
    naive = np.sqrt(np.float32(1) - np.float32(light.radius / distance) ** 2)
    assert (naive == 1.0).all()


def test_a_vertex_inside_a_sphere_sees_it_all_around():
    light = ph.SphereLight((0.1, 0.2, 0.3), radius=4.0)
    _, direction, length, _ = sampled(light, 1024)
    ends = POINTS.T[:, None, :] + direction * length - np.array(light.position)[:, None, None]
    np.testing.assert_allclose(np.linalg.norm(ends, axis=0), 4.0, rtol=1e-5)
    np.testing.assert_allclose(direction.mean(axis=1), 0.0, atol=0.02)


def test_by_energy_and_by_cosine_weights_vary_less_than_by_the_cosine_alone():
    """A small sun in a dim sky; without importance sampling, few directions hit it."""
    image = np.full((64, 128, 3), 0.1)
    image[10, 30] = 500.0
    light = ph.EnvironmentLight(image, up=(0, 0, 1))
    weight, by_cosine = sampled(light, 1024)[3], sampled(ph.EnvironmentLight(0.1), 1024)[1]
    rows = np.minimum(np.arccos(np.clip(by_cosine[2], -1, 1)) / math.pi * 64, 63).astype(int)
    columns = ((np.arctan2(-by_cosine[1], by_cosine[0]) / (2 * math.pi) + 0.5) * 128).astype(int) % 128
    naive = image[rows, columns, 0]
    for_sun = weight.mean(axis=0) > 0.15
    assert for_sun.mean() > 0.3
    exact = sampled(light, 4096)[0][for_sun]
    off, naive_off = (np.median(np.abs(each.mean(axis=0)[for_sun] / exact - 1.0)) for each in (weight, naive))
    assert off < 0.01
    assert naive_off > 0.3
