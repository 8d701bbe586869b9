"""Boundary integrals over caps against quadrature over their areas by mpmath."""

import math

import area_oracle as oracle
import mpmath as mp
import numpy as np
import pytest

from pvphong.optics.spherical import cap_cosine, cap_power, great_arc

POWERS = (0.0, 0.3, 1.0, 2.5, 20.0, 100.7, 1e3, 1e6)
SINES = (1e-9, 1e-6, 1e-4, 0.01, 0.3, 0.9, 0.9999)


def direction(random):
    vector = random.normal(size=3)
    return vector / np.linalg.norm(vector)


def aside(random, axis, angle):
    """At an angle from an axis."""
    across = np.cross(axis, random.normal(size=3))
    return math.cos(angle) * axis + math.sin(angle) * across / np.linalg.norm(across)


def throw(power, sine, is_cut, seed=0):
    """The axis w near the cap, the normal, the cap's axis."""
    random = np.random.default_rng([int(10 * power), int(-math.log(sine) * 100), is_cut, seed])
    l = direction(random)
    tilt = math.pi / 2 + random.uniform(-0.95, 0.95) * math.asin(sine) if is_cut else random.uniform(0, 0.99)
    n = aside(random, l, tilt if is_cut else tilt * (math.pi / 2 - math.asin(sine)))
    w = aside(random, l, random.uniform(0.0, 1.2) * (math.asin(sine) + 1.0 / math.sqrt(power + 1.0)))
    return w, n, l


def cosine_of(sine):
    return math.sqrt((1.0 - sine) * (1.0 + sine))


def column(vector):
    return np.asarray(vector)[:, None]


def of_cap(w, n, l, sine, power):
    return float(cap_power(column(w), column(n), column(l), np.array([sine]), np.array([cosine_of(sine)]), power)[0])


def exact_of_cap(w, n, l, sine, power):
    with mp.workdps(40):
        w, n, l = (oracle.unit(oracle.exact_vector(x)) for x in (w, n, l))
        edge = mp.sqrt(1 - mp.mpf(sine) ** 2)
        return float(oracle.power_over(w, power, [(n, mp.mpf(0)), (l, edge)]) / (mp.pi * mp.mpf(sine) ** 2))


@pytest.mark.parametrize("is_cut", [False, True])
@pytest.mark.parametrize("sine", SINES)
@pytest.mark.parametrize("power", POWERS)
def test_a_power_over_a_cap(power, sine, is_cut):
    w, n, l = throw(power, sine, is_cut)
    # where the horizon is in the cap is known to a rounding of n·l
    off = 1e-9 + is_cut * 2.0**-52 / sine
    assert of_cap(w, n, l, sine, power) == pytest.approx(exact_of_cap(w, n, l, sine, power), abs=off)


@pytest.mark.parametrize("is_cut", [False, True])
@pytest.mark.parametrize("sine", SINES)
def test_lamberts_cosine_over_a_cap(sine, is_cut):
    _, n, l = throw(1.0, sine, is_cut)
    got = float(cap_cosine(np.array([n @ l]), np.array([sine]), np.array([cosine_of(sine)]))[0])
    assert got == pytest.approx(exact_of_cap(n, n, l, sine, 1.0), rel=1e-9 if sine > 1e-8 else 1e-6)
    assert got == pytest.approx(of_cap(n, n, l, sine, 1.0), abs=1e-9)


def test_the_textbooks_form_for_a_cap_at_the_horizon_cancels():
    """Snyder's formula as it is printed, for a cap of the angular radius 1e-8 whose middle is on the horizon."""
    s, c = 1e-8, 0.0
    x = math.sqrt(1 / s**2 - 1)
    y = -x * c
    q = math.sqrt(1 - y * y)
    printed = ((c * math.acos(y) - x * q) * s**2 + math.atan(q / x)) / (math.pi * s**2)
    got = float(cap_cosine(np.array([c]), np.array([s]), np.array([1.0]))[0])
    assert got == pytest.approx(2 * s / (3 * math.pi), rel=1e-14)
    assert abs(printed - got) > 0.1 * got


def test_an_axis_on_the_edge_is_no_special_case():
    """W on the circle, on the horizon, on a corner of both; and 1e-15 beside them."""
    n, l, sine = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), 0.6
    corner = np.array([0.8, 0.6, 0.0])
    for w in (corner, np.array([0.8, 0.0, 0.6]), l):
        for power in (5.0, 400.0):
            exact = exact_of_cap(w, n, l, sine, power)
            for shift in (0.0, 1e-15, -1e-15, 1e-9, -1e-9):
                beside = w + shift * np.array([-0.6, 0.8, 1.0])
                got = of_cap(beside / np.linalg.norm(beside), n, l, sine, power)
                assert got == pytest.approx(exact, abs=1e-9 + 10 * math.sqrt(power) * abs(shift))


def test_an_arc_on_the_equator_of_w_is_an_angle():
    """There is no point of it next to w: any basis serves."""
    for middle in (0.0, 1.0, 3.0, -2.5):
        for sign in (1.0, -1.0):
            turned = great_arc(np.array([sign]), np.array([0.0]), np.array([middle]), np.array([0.4]), 21.0)
            np.testing.assert_allclose(turned, [0.8 * sign], rtol=1e-14)


def test_without_a_normal_there_is_no_horizon_and_no_light():
    assert of_cap([0, 0, 1], [0, 0, 0], [0, 0, 1], 0.5, 3.0) == 0.0
