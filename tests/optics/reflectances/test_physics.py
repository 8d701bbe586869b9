"""Reciprocity and energy conservation of reflectances, by quadrature over the hemisphere, and their exceptions."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from strategies import LIGHT_SHAPES, REFLECTANCE_SHAPES, Dice

from pvphong import (
    GGX,
    PBR,
    LightModel,
    Material,
    ModifiedPhong,
    OrenNayar,
    PointLight,
    Retro,
    Scene,
    Viewer,
    Ward,
    evaluate,
)
from pvphong.optics.light import Arrival
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.optics.reflectances.likeness import stand_in
from pvphong.optics.surface import Surface
from pvphong.shading import kernel
from pvphong.shading.plan.plan import Plan
from pvphong.shading.reference import lobe_factors
from pvphong.shading.vertices import Vertices

COMPILED = "numba" if kernel.is_available() else "auto"
RECIPROCAL = [
    *(ModifiedPhong(s) for s in (0.0, 4.0, 60.0)),
    *(Retro(s) for s in (0.0, 4.0, 60.0)),
    *(OrenNayar(s) for s in (0.0, 20.0, 90.0)),
    *(Ward(a, b) for a, b in ((0.2, 0.2), (0.15, 0.8), (1.0, 1.0))),
    *(GGX(r, 0.5) for r in (0.1, 0.5, 1.0)),
    *(PBR(m, r) for m in (0.0, 0.5, 1.0) for r in (0.2, 1.0)),
]
CONSERVING = [
    *RECIPROCAL[:6],
    *RECIPROCAL[9:12],
    *(GGX(r, f) for r in (0.25, 0.5, 1.0) for f in (0.0, 0.04, 0.5, 1.0)),
    OrenNayar(0.0),
]
TOWARDS = [10.0, 70.0, 88.0]


def of_white(reflectance):
    """Resolve a reflectance with a material whose diffuse, specular and shininess are 1."""
    return reflectance.of(SimpleNamespace(diffuse=1.0, specular=1.0, shininess=1.0))


def reflected(reflectance, l, v, diffuse=0.5, specular=0.5):
    """Return the reflected part of red light, for unit vectors (3, k)."""
    bound = of_white(reflectance)
    count = np.broadcast(l, v).shape[1]
    x, _, z = np.eye(3)[:, :, None] * np.ones(count)
    surface = Surface(z, np.ones(count), v * np.ones(count), x)
    with np.errstate(divide="ignore", under="ignore", over="ignore"):  # as evaluators do
        factors = lobe_factors(bound, surface, Arrival(l * np.ones(count), 1.0), [True] * 3)
    own = {"diffuse": diffuse, "specular": specular}
    return sum(
        lobe.color[0] * (1.0 if lobe.is_own else own[lobe.component]) * factor
        for lobe, factor in zip(bound.lobes, factors, strict=True)
    )


def direction(theta, phi=0.0):
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi])


def hemisphere(count=120):
    """Return directions (3, k) and solid angles; nodes are dense at the horizon and around the plane of incidence."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    t, phi = 0.5 * (nodes + 1.0), np.pi * nodes**3
    theta = 0.5 * np.pi * (1.0 - (1.0 - t) ** 2)
    of_theta = 0.5 * weights * np.pi * (1.0 - t) * np.sin(theta)
    solid = np.outer(of_theta, weights * 3.0 * np.pi * nodes**2)
    angles = np.meshgrid(theta, phi, indexing="ij")
    return direction(angles[0].ravel(), angles[1].ravel()), solid.ravel()


def albedo(reflectance, theta, **colors):
    """Return the reflected part of light from the direction θ, by reciprocity; the integrand has n·l of the other."""
    l, solid = hemisphere()
    v = direction(np.array([math.radians(theta)]), np.array([math.pi]))
    return float((reflected(reflectance, l, v, **colors) * solid).sum() / np.pi)


@pytest.mark.parametrize("reflectance", RECIPROCAL, ids=repr)
def test_reciprocal(reflectance):
    random = np.random.default_rng(1)
    l, v = (direction(*random.uniform(0.0, (1.55, 6.28), (500, 2)).T) for _ in range(2))
    both = reflected(reflectance, l, v) / l[2], reflected(reflectance, v, l) / v[2]
    np.testing.assert_allclose(*both, rtol=1e-9)


@pytest.mark.parametrize("reflectance", CONSERVING, ids=repr)
@pytest.mark.parametrize("theta", TOWARDS)
def test_no_more_light_leaves_than_comes(reflectance, theta):
    colors = {"diffuse": 1.0} if isinstance(reflectance, GGX) else {}
    found = albedo(reflectance, theta, **colors)
    assert 0.0 < found <= 1.0 + 1e-4


def test_albedos_that_are_known_in_closed_form():
    assert albedo(OrenNayar(0.0), 50.0, diffuse=1.0) == pytest.approx(1.0, abs=1e-5)
    for kind in (ModifiedPhong, Retro):
        for s in (0.0, 7.0, 100.0):
            assert albedo(kind(s), 0.0, diffuse=0.0, specular=1.0) == pytest.approx(1.0, abs=1e-4)
    # At α = 1 and normal incidence the facets' factor is c / 2(1 + c), whose integral is 1 − ln 2
    assert albedo(GGX(1.0, 1.0), 0.0, diffuse=0.0) == pytest.approx(1.0 - math.log(2.0), abs=1e-5)
    a, _ = OrenNayar(30.0).parameters({})
    assert albedo(OrenNayar(30.0), 0.0, diffuse=1.0) == pytest.approx(a, abs=1e-5)


def test_vtks_physically_based_white_shines_too_much_at_grazing_angles_and_oren_nayars_too():
    assert albedo(PBR(0.0, 0.3), 20.0) < 1.0
    assert albedo(PBR(0.0, 0.3), 85.0, diffuse=1.0) > 1.05
    assert 1.01 < max(albedo(OrenNayar(sigma), 89.0, diffuse=1.0) for sigma in (5.0, 10.0, 20.0, 45.0)) < 1.015


@pytest.mark.parametrize("reflectance", [OrenNayar(25.0), OrenNayar(60.0), GGX(0.5, 0.0)], ids=repr)
def test_what_stands_in_for_a_base_reflects_as_much_in_all(reflectance):
    nodes, weights = np.polynomial.legendre.leggauss(12)
    cosines, weights = 0.5 * (nodes + 1.0), weights * 0.5 * (nodes + 1.0)
    found = 0.0
    for cosine, weight in zip(cosines, weights, strict=True):
        theta = math.degrees(math.acos(cosine))
        found += weight * (albedo(reflectance, theta, diffuse=1.0) - albedo(reflectance, theta, diffuse=0.0))
    _, simpler = stand_in(reflectance, Material(diffuse=1.0))
    assert simpler.diffuse[0] == pytest.approx(found, abs=2e-3)


# --- in scenes ---


@pytest.mark.parametrize("light", LIGHT_TYPES)
@pytest.mark.parametrize("name", REFLECTANCES)
def test_every_light_lights_every_reflectance(name, light):
    dice = Dice(f"{name} {light}")
    aim = tuple(-dice.unit_vector())
    shape = LIGHT_SHAPES[light](dice, tuple(-3.0 * np.array(aim)), aim, 60.0)
    lamp = LIGHT_TYPES[light](**shape)
    reflectance = REFLECTANCES[name](**REFLECTANCE_SHAPES[name](Dice(6)))
    points = np.array([dice.unit_vector() for _ in range(150)])
    scene = Scene([lamp], Viewer((1, -2, 5)))
    material = Material(ambient=0.0, diffuse=0.5, specular=0.4, reflectance=reflectance)
    both = [
        evaluate(
            points, points, scene, replace(material, tangents=points[:, ::-1]), precision="float64", backend=backend
        ).rgb
        for backend in ("numpy", COMPILED)
    ]
    assert np.isfinite(both[0]).all()
    assert both[0].max() > 0.0
    np.testing.assert_allclose(*both, atol=1e-7)


def test_a_plan_keeps_its_promise_where_the_sum_of_all_light_is_raised_to_a_power():
    random = np.random.default_rng(5)
    points = random.uniform(-1.0, 1.0, (200, 3))
    material = Material(diffuse=0.5, reflectance=PBR(0.0, 0.8))
    taken = 0
    for k in range(12):
        lamps = [PointLight(tuple(10.0**k * random.normal(size=3) + 20.0), intensity=10.0 ** -random.uniform(0, 6))]
        scene = Scene([*lamps, PointLight((3, 2, 4))], Viewer((0, 0, 9)), LightModel.vtk(two_sided=False))
        vertices = Vertices(points, points)
        exact = Plan.of(scene, material, vertices).run(vertices, precision="float64").rgb
        plan = Plan.of(scene, material, vertices, tolerance=0.05)
        error = np.abs(plan.run(vertices, precision="float64").rgb - exact).max()
        assert error <= plan.error_bound + 1e-12 <= 0.05 + 1e-12
        taken += plan.error_bound > 0.0
    assert taken > 2
