"""What reflectances claim of reciprocity and energy, by quadrature over the hemisphere, and who breaks what."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from pvphong import GGX, PBR, BlinnPhong, Metal, ModifiedPhong, OrenNayar, Phong, Retro
from pvphong.optics.light import Arrival
from pvphong.optics.surface import Surface

RECIPROCAL = [
    *(ModifiedPhong(s) for s in (0.0, 4.0, 60.0)),
    *(Retro(s) for s in (0.0, 4.0, 60.0)),
    *(OrenNayar(s) for s in (0.0, 20.0, 90.0)),
    *(GGX(r, 0.5) for r in (0.1, 0.5, 1.0)),
    *(PBR(m, r) for m in (0.0, 0.5, 1.0) for r in (0.2, 1.0)),
]
CONSERVING = [*RECIPROCAL[:6], *(GGX(r, f) for r in (0.25, 0.5, 1.0) for f in (0.0, 0.04, 0.5, 1.0)), OrenNayar(0.0)]
TOWARDS = [10.0, 70.0, 88.0]


def of_white(reflectance):
    """The reflectance of a material that scatters or mirrors all light, as far as it takes that from a material."""
    return reflectance.of(SimpleNamespace(diffuse=1.0, specular=1.0, shininess=1.0))


def reflected(reflectance, l, v, diffuse=0.5, specular=0.5):
    """Of red light, from unit vectors (3, k)."""
    bound = of_white(reflectance)
    count = np.broadcast(l, v).shape[1]
    surface = Surface(np.array([[0.0], [0], [1]]) * np.ones(count), np.ones(count), v * np.ones(count))
    with np.errstate(divide="ignore", under="ignore", over="ignore"):  # as evaluators do
        factors = bound.factors(surface, Arrival(l * np.ones(count), 1.0), [True] * 3)
    own = {"diffuse": diffuse, "specular": specular}
    return sum(
        lobe.color[0] * (1.0 if lobe.is_own else own[lobe.component]) * factor
        for lobe, factor in zip(bound.lobes, factors, strict=True)
    )


def direction(theta, phi=0.0):
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi])


def hemisphere(count=120):
    """Directions (3, k) and solid angles; nodes crowd at the horizon and around the plane of incidence."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    t, phi = 0.5 * (nodes + 1.0), np.pi * nodes**3
    theta = 0.5 * np.pi * (1.0 - (1.0 - t) ** 2)
    of_theta = 0.5 * weights * np.pi * (1.0 - t) * np.sin(theta)
    solid = np.outer(of_theta, weights * 3.0 * np.pi * nodes**2)
    angles = np.meshgrid(theta, phi, indexing="ij")
    return direction(angles[0].ravel(), angles[1].ravel()), solid.ravel()


def albedo(reflectance, theta, **colors):
    """The part of the light from the direction θ that leaves it, by reciprocity; the integrand has n·l of the other."""
    l, solid = hemisphere()
    v = direction(np.array([math.radians(theta)]), np.array([math.pi]))
    return float((reflected(reflectance, l, v, **colors) * solid).sum() / np.pi)


@pytest.mark.parametrize("reflectance", RECIPROCAL, ids=repr)
def test_reciprocal(reflectance):
    random = np.random.default_rng(1)
    l, v = (direction(*random.uniform(0.0, (1.55, 6.28), (500, 2)).T) for _ in range(2))
    both = reflected(reflectance, l, v) / l[2], reflected(reflectance, v, l) / v[2]
    np.testing.assert_allclose(*both, rtol=1e-9)


@pytest.mark.parametrize("reflectance", [Phong(4.0), BlinnPhong(4.0), Metal(0.5, 4.0)], ids=repr)
def test_highlights_without_a_cosine_are_not_reciprocal_and_shine_too_much(reflectance):
    l, v = direction(np.array([0.4])), direction(np.array([1.2]), np.array([3.0]))
    one, other = reflected(reflectance, l, v) / l[2], reflected(reflectance, v, l) / v[2]
    assert abs(one - other) > 0.1 * one
    # as the quotient by n·l would have it, more leaves than comes from near the horizon
    l, solid = hemisphere()
    v = direction(np.array([1.56]), np.array([math.pi]))
    leaving = (reflected(reflectance, v * np.ones_like(l), l, diffuse=0.0, specular=1.0) / v[2] * l[2] * solid).sum()
    assert leaving / np.pi > 1.5


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
    a, _ = OrenNayar(30.0).coefficients
    assert albedo(OrenNayar(30.0), 0.0, diffuse=1.0) == pytest.approx(a, abs=1e-5)


def test_vtks_physically_based_white_shines_too_much_at_grazing_angles_and_oren_nayars_too():
    assert albedo(PBR(0.0, 0.3), 20.0) < 1.0
    assert albedo(PBR(0.0, 0.3), 85.0, diffuse=1.0) > 1.05
    assert 1.01 < max(albedo(OrenNayar(sigma), 89.0, diffuse=1.0) for sigma in (5.0, 10.0, 20.0, 45.0)) < 1.015


def test_a_smooth_surface_mirrors_all_that_schlicks_formula_says():
    for theta in (0.0, 45.0, 70.0):
        f = 0.3 + 0.7 * (1.0 - math.cos(math.radians(theta))) ** 5
        assert albedo(GGX(0.15, 0.3), theta, diffuse=0.0) == pytest.approx(f, abs=0.02)


def test_a_brdf_is_the_others_limit():
    l, v = direction(np.array([0.3, 0.8]), np.array([0.0, 2.0])), direction(np.array([0.5, 0.4]), np.array([3.0, 1.0]))
    np.testing.assert_allclose(reflected(OrenNayar(0.0), l, v), 0.5 * l[2], rtol=1e-14)
    np.testing.assert_allclose(reflected(Metal(1.0, 9.0), l, v), reflected(Phong(9.0), l, v, specular=1.0), rtol=1e-14)
