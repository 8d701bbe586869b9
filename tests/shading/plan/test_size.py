"""The plan's effect "size": error bounds of a point light in place of an area light."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import pvphong as ph

VIEWERS = {"phong": 30.0, "blinn-phong": 60.0}


def direction(random):
    vector = random.normal(size=3)
    return vector / np.linalg.norm(vector)


def thrown(seed):
    """Return a random area light far from or near a cluster of vertices, with normals around its direction."""
    random = np.random.default_rng(seed)
    points = 0.5 * random.uniform(-1, 1, (40, 3)) * random.choice([1.0, 0.1])
    away, size = direction(random), 10.0 ** random.uniform(-4, 0)
    place = away * max(10.0 ** random.uniform(0, 3), 2.5 * size)
    aim = -away + random.choice([0.0, 0.5, 3.0]) * direction(random)
    two_sided, square = bool(random.integers(2)), float(place @ place)
    light = random.choice(
        [
            ph.SphereLight(place, size, intensity=square),
            ph.DiskLight(place, aim, size, two_sided, intensity=square),
            ph.RectangleLight(place, aim, direction(random), size, 0.3 * size, two_sided, intensity=square),
        ]
    )
    normals = away + random.choice([0.1, 1.0, 3.0]) * random.normal(size=(40, 3))
    scene = ph.Scene(
        [light], ph.Viewer(4 * direction(random)), ph.LightModel(reflection=random.choice(list(VIEWERS)), clamp=False)
    )
    material = ph.Material(diffuse=0.5, specular=0.5, shininess=random.choice([0.0, 1.0, 20.0]))
    return points, normals, scene, material


def test_no_scene_exceeds_the_bound():
    tolerances = (1 / 255, 0.05, 0.3)
    left_out = dict.fromkeys(tolerances, 0)
    for seed in range(120):
        arguments = thrown(seed)
        exact = ph.evaluate(*arguments, precision="float64", backend="numpy").rgb
        for tolerance in tolerances:
            plan = ph.plan(arguments[0], *arguments[2:], tolerance=tolerance)
            got = ph.evaluate(*arguments, precision="float64", backend="numpy", tolerance=tolerance).rgb
            assert np.abs(got - exact).max() <= plan.error_bound + 1e-9 <= tolerance + 1e-9, (seed, tolerance)
            left_out[tolerance] += not plan.effects["size"].on
    assert min(left_out.values()) > 20


def summed(seed):
    """Return a case like `thrown`, with a light that is large at its distance and summed over nodes."""
    points, normals, scene, material = thrown(seed)
    random = np.random.default_rng(seed)
    (light,) = scene.lights
    size = light.radius if hasattr(light, "radius") else light.width
    place = size * random.uniform(3.0, 12.0) * np.array(light.position) / np.linalg.norm(light.position)
    points = points * size * random.choice([0.1, 1.0])
    near = replace(light, position=place, intensity=10.0 ** random.uniform(-2, 0) * float(place @ place))
    sigma, power = random.uniform(1.0, 90.0), random.choice([1.0, 5.0, 40.0])
    reflectance = random.choice([ph.OrenNayar(sigma), ph.BlinnPhong(power)])
    scene = replace(scene, lights=[near], viewer=ph.Viewer(4 * size * direction(random)))
    return points, normals, scene, replace(material, specular=0.5, reflectance=reflectance)


RECORDED = {
    29: (16, 0.033), 53: (16, 0.041), 90: (4, 0.026), 101: (16, 0.037), 138: (4, 0.047), 179: (16, 0.019),
    197: (16, 0.038), 232: (4, 0.048), 238: (16, 0.046), 247: (16, 0.049), 267: (16, 0.047), 268: (16, 0.043),
    298: (4, 0.046),
}  # fmt: skip
"""Seed → number of nodes, and the bound. Errors are far below, so they would not reveal a bound that is too small."""


def test_no_scene_exceeds_the_bound_of_fewer_nodes():
    found = {}
    for seed in range(300):
        arguments = summed(seed)
        plan = ph.plan(arguments[0], *arguments[2:], tolerance=0.1)
        size = plan.effects["size"]
        count = next((count for count in (4, 16) if f"by {count} nodes" in size.why), 64)
        if count == 64:
            continue
        exact = ph.evaluate(*arguments, precision="float64", backend="numpy").rgb
        got = ph.evaluate(*arguments, precision="float64", backend="numpy", tolerance=0.1).rgb
        assert np.abs(got - exact).max() <= plan.error_bound + 1e-9 <= 0.1 + 1e-9, seed
        found[seed] = count, float(f"{size.bound:.2g}")
    assert found == RECORDED


@pytest.mark.parametrize(
    ("material", "integrals"),
    [
        (ph.Material(), 1),
        (ph.Material(specular=0.5, shininess=20), 2),
        (ph.Material(reflectance=ph.GGX(0.4)), 0),  # nodes count as lights
        (ph.Material(diffuse=0.0, specular=0.5, shininess=20), 1),
    ],
)
def test_each_integral_takes_its_time(material, integrals):
    lamps = [ph.SphereLight((0, 0, 3), 0.5), ph.PointLight((3, 0, 0)), ph.RectangleLight((0, 3, 0), (0, -1, 0))]
    scene = ph.Scene(lamps, ph.Viewer())
    plan = ph.plan([[0.0, 0.0, 0.0]], scene, material)
    assert plan.effects["size"].lights == 2 * integrals
    (cost,) = (row[-1] for row in plan._rows if row[0] == "size")
    assert float(cost or 0) == 2 * integrals * 20.0
