"""The directional light: one direction everywhere, strength 1."""

import math

import mpmath
import numpy as np
import pytest

from pvphong.optics.lights import DirectionalLight
from pvphong.scene.viewer import Viewer

VIEWER = Viewer(position=(3, -2, 5), focal_point=(1, 1, 1), up=(0.2, 0.3, 1))


def exact_unit(vector):
    with mpmath.workdps(50):
        square = mpmath.fsum(mpmath.mpf(x) ** 2 for x in vector)
        return np.array([float(mpmath.mpf(x) / mpmath.sqrt(square)) for x in vector])


def test_defaults():
    assert DirectionalLight().direction == (0.0, 0.0, -1.0)


def test_direction_is_the_first_argument_and_keeps_its_length():
    assert DirectionalLight((1, 2, 3)).direction == (1.0, 2.0, 3.0)


@pytest.mark.parametrize("bad", [(0, 0, 0), (0, math.nan, 1), (math.inf, 0, 0), (1, 2), "down", None, 5])
def test_direction_is_refused_by_name(bad):
    with pytest.raises(ValueError, match=r"^direction"):
        DirectionalLight(direction=bad)


@pytest.mark.parametrize(
    "direction", [(0, 0, -1), (1, -2, 3), (1e-320, 0, 3e-320), (1e308, -1e308, 5), (1e-200, 1e200, 0)]
)
def test_arrives_against_its_travel_as_a_unit_vector(direction):
    arrival = DirectionalLight(direction=direction).arrival(np.zeros((3, 7)))
    assert arrival.strength == 1.0
    np.testing.assert_allclose(arrival.direction, -exact_unit(direction)[:, None], rtol=0, atol=4 * 2.0**-53)


def test_arrives_the_same_everywhere():
    points = np.array([[0.0, 1e300, np.nan], [0.0, -1e300, 0.0], [0.0, 0.0, np.inf]])
    arrival = DirectionalLight(direction=(1, 2, 2)).arrival(points)
    np.testing.assert_array_equal(np.broadcast_to(arrival.direction, (3, 3)), np.tile([[-1], [-2], [-2]], 3) / 3)


def test_in_world_leaves_a_world_light_alone():
    light = DirectionalLight(direction=(1, 2, 3))
    assert light.in_world(VIEWER) is light


def test_in_world_of_a_camera_light_turns_with_the_eye():
    back = np.subtract(VIEWER.position, VIEWER.focal_point)
    back = back / np.linalg.norm(back)
    right = np.cross(VIEWER.up, back)
    right /= np.linalg.norm(right)
    light = DirectionalLight(direction=(2, -3, 5), frame="camera", name="sun").in_world(VIEWER)
    np.testing.assert_allclose(light.direction, 2 * right - 3 * np.cross(back, right) + 5 * back, rtol=1e-14)
    assert (light.frame, light.name) == ("world", "sun")


def test_in_world_of_a_headlight_shines_along_the_view():
    light = DirectionalLight(direction=(1, 0, 0), frame="headlight").in_world(VIEWER)
    along = np.subtract(VIEWER.focal_point, VIEWER.position)
    np.testing.assert_allclose(light.direction, along / np.linalg.norm(along), rtol=1e-15)
    assert light.frame == "world"


@pytest.mark.parametrize("frame", ["world", "camera", "headlight"])
def test_to_pyvista_keeps_the_direction_exactly(frame):
    direction = (0.1, -1e-9, 1e9 / 3)
    light = DirectionalLight(direction=direction, frame=frame).to_pyvista(VIEWER)
    assert tuple(np.subtract(light.GetFocalPoint(), light.GetPosition())) == direction
