"""The point light: attenuation by its closed form, over the whole range of distances."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pvphong.optics.lights import PointLight
from pvphong.scene.viewer import Viewer

U = 2.0**-53
LARGEST = np.finfo(np.float64).max
QUICK = settings(max_examples=150, derandomize=True, deadline=None, database=None)
VIEWER = Viewer(position=(3, -2, 5), focal_point=(1, 1, 1), up=(0.2, 0.3, 1))


def arrival_along_x(distances, **fields):
    """What arrives on the x axis at some distances from a light in the origin."""
    points = np.zeros((3, len(distances)))
    points[0] = distances
    return PointLight(**fields).arrival(points)


def wide_floats(lowest=-300, highest=300):
    return st.tuples(st.floats(1, 2, exclude_max=True), st.integers(lowest, highest)).map(lambda x: math.ldexp(*x))


def test_defaults():
    light = PointLight()
    assert (light.position, light.attenuation) == ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))


def test_geometry_in_canonical_form():
    light = PointLight(np.array([1, 2, 3]), attenuation=[0, 1, np.float32(0.5)])
    assert (light.position, light.attenuation) == ((1.0, 2.0, 3.0), (0.0, 1.0, 0.5))


@pytest.mark.parametrize("bad", [(0, 0), (0, math.nan, 0), (math.inf, 0, 0), "here", None])
def test_position_is_refused_by_name(bad):
    with pytest.raises(ValueError, match=r"^position"):
        PointLight(position=bad)


@pytest.mark.parametrize("bad", [(0, 0, 0), (-1e-300, 0, 1), (1, -1, 0), (1, 0, -1)])
def test_attenuation_is_not_negative_and_not_all_zero(bad):
    with pytest.raises(
        ValueError,
        match=r"^attenuation must be three numbers >= 0 .*; got .*\(1, 0, 0\) is a light that does not weaken",
    ):
        PointLight(attenuation=bad)


@pytest.mark.parametrize("bad", [(math.nan, 0, 1), (1, math.inf, 0), (1, 0), 1.0, None, "none"])
def test_attenuation_is_three_finite_numbers(bad):
    with pytest.raises(ValueError, match=r"^attenuation"):
        PointLight(attenuation=bad)


@pytest.mark.parametrize("attenuation", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (2, 3, 0), (0.5, 0, 7), (1, 0.25, 0.125)])
@given(distance=wide_floats())
@QUICK
def test_attenuation_is_the_closed_form(attenuation, distance):
    c, linear, quadratic = (Fraction(x) for x in attenuation)
    d = Fraction(distance)
    expected = float(1 / (c + linear * d + quadratic * d * d))
    strength = float(arrival_along_x([distance], attenuation=attenuation).strength[0])
    # five roundings; a denominator beyond float64 arrives as nothing
    assert strength == pytest.approx(expected, rel=8 * U, abs=4 / LARGEST)


def test_inverse_square():
    strength = arrival_along_x([1.0, 2.0, 10.0], attenuation=(0, 0, 1)).strength
    np.testing.assert_array_equal(strength, [1.0, 0.25, 0.01])


@pytest.mark.parametrize(
    ("attenuation", "expected"), [((1, 0, 0), 1.0), ((4, 1, 1), 0.25), ((0, 1, 0), 0.0), ((0, 0, 1), 0.0)]
)
def test_on_the_light_itself(attenuation, expected):
    arrival = arrival_along_x([0.0], attenuation=attenuation)
    assert arrival.strength.tolist() == [expected]
    assert not arrival.direction.any()


@pytest.mark.parametrize(
    "attenuation", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1e300, 1e300, 1e300), (1e-300, 1e-300, 1e-300)]
)
@pytest.mark.parametrize("distance", [5e-324, 1e-310, 1e-160, 1e160, 1e300, LARGEST])
def test_extreme_distances_have_a_direction_and_no_nan(attenuation, distance):
    arrival = arrival_along_x([distance, -distance], attenuation=attenuation)
    np.testing.assert_array_equal(arrival.direction, [[-1, 1], [0, 0], [0, 0]])
    assert not np.isnan(arrival.strength).any()
    assert (arrival.strength >= 0).all()


def test_a_distance_beyond_float64_is_taken_for_its_largest():
    light = PointLight(position=(LARGEST, 0, 0), attenuation=(0, 1, 0))
    arrival = light.arrival(np.array([[-LARGEST], [0.0], [0.0]]))
    assert arrival.direction.tolist() == [[1.0], [0.0], [0.0]]
    assert arrival.strength[0] == 1.0 / LARGEST


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_nothing_arrives_at_a_point_that_is_not_finite(bad):
    arrival = arrival_along_x([bad, 1.0])
    assert arrival.strength.tolist() == [0.0, 1.0]
    assert arrival.direction[:, 0].tolist() == [0.0, 0.0, 0.0]


def test_a_point_does_not_depend_on_its_neighbours():
    points = np.random.default_rng(3).normal(size=(3, 6)) * [1, 1e-200, 1e200, np.nan, 0, 1e5]
    light = PointLight(position=(0.1, 0.2, 0.3), attenuation=(0.1, 0.2, 0.3))
    together = light.arrival(points)
    for column in range(6):
        alone = light.arrival(points[:, [column]])
        assert alone.direction.tobytes() == together.direction[:, [column]].tobytes()
        assert alone.strength.tobytes() == together.strength[[column]].tobytes()


def test_in_world():
    light = PointLight(position=(1, 2, 3))
    assert light.in_world(VIEWER) is light
    riding = PointLight(position=(0, 0, -VIEWER.distance), frame="camera", attenuation=(1, 2, 3)).in_world(VIEWER)
    np.testing.assert_allclose(riding.position, VIEWER.focal_point, rtol=1e-14)
    assert (riding.frame, riding.attenuation) == ("world", (1.0, 2.0, 3.0))
    head = PointLight(position=(9, 9, 9), frame="headlight").in_world(VIEWER)
    assert (head.frame, head.position) == ("world", VIEWER.position)


def test_to_pyvista_is_positional_without_a_cone():
    light = PointLight(position=(0.1, 1e9 / 3, -1e-9), attenuation=(1 / 3, 0.1, 1e-7)).to_pyvista()
    assert light.GetPosition() == (0.1, 1e9 / 3, -1e-9)
    assert light.GetAttenuationValues() == (1 / 3, 0.1, 1e-7)
    assert light.GetPositional()
    assert light.GetConeAngle() >= 90.0
