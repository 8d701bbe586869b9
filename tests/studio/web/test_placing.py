"""A light's azimuth, elevation and distance about its target."""

from dataclasses import replace

import numpy as np
import pytest

import pvphong as ph
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.roles import Place
from pvphong.studio.gizmos.handles import LightInScene
from pvphong.studio.gizmos.view import Scenery
from pvphong.studio.web.placing import Placing, placed, placing_of

CENTER = (1.0, 2.0, 3.0)
SCENERY = Scenery(CENTER, 2.0, CENTER, 3.0)
TARGET = (1.5, 2.0, 3.5)


def lights():
    """Return a light of each kind that can be placed, which shines on a target if it has an aim."""
    found = []
    for kind in LIGHT_TYPES.values():
        if kind is ph.EnvironmentLight:
            continue
        if kind is ph.PolygonLight:
            corners = [(0, 0, 6), (1, 0, 6), (1, 1, 6.5)]
            found.append(kind(corners=corners))
        else:
            light = kind()
            if light.values(Place):
                light = light.with_values(Place, (4.0, 0.0, 6.0))
            aim = tuple(np.subtract(TARGET, (4.0, 0.0, 6.0)))
            found.append(replace(light, direction=aim) if "direction" in light.roles else light)
    return found


@pytest.mark.parametrize("light", lights(), ids=lambda light: type(light).__name__)
def test_a_light_is_where_its_angles_and_its_distance_say(light):
    shown = LightInScene(light, SCENERY)
    before = placing_of(shown)
    same = placed(shown, before)
    for name in light.roles:
        np.testing.assert_allclose(getattr(same, name), getattr(light, name), atol=1e-9)
    target = TARGET if "direction" in light.roles else CENTER
    distance = None if before.distance is None else 5.0
    for azimuth, elevation, unit in (
        (90.0, 0.0, (1, 0, 0)),
        (0.0, 0.0, (0, 1, 0)),
        (-90.0, 0.0, (-1, 0, 0)),
        (30.0, 90.0, (0, 0, 1)),
        (180.0, -30.0, (0, -(0.75**0.5), -0.5)),
    ):
        moved = LightInScene(placed(shown, Placing(azimuth, elevation, distance)), SCENERY)
        if distance is not None:
            np.testing.assert_allclose(moved.origin, np.add(target, np.multiply(distance, unit)), atol=1e-9)
        if moved.along is not None:
            np.testing.assert_allclose(moved.along, np.negative(unit), atol=1e-9)
        again = placing_of(moved)
        assert again.elevation == pytest.approx(elevation, abs=1e-6)
        assert abs(elevation) == 90.0 or abs(again.azimuth) == pytest.approx(abs(azimuth), abs=1e-6)


def test_a_sun_has_the_azimuth_and_the_elevation_that_made_it():
    sun = ph.DirectionalLight.from_angles(315.0, 20.0)
    placing = placing_of(LightInScene(sun, SCENERY))
    assert (placing.azimuth, placing.elevation) == (pytest.approx(-45.0), pytest.approx(20.0))
    assert placing.distance is None
    assert Placing(315.0).azimuth == -45.0
    for frame, kind in (("headlight", ph.SpotLight), ("world", ph.EnvironmentLight)):
        assert placing_of(LightInScene(kind(frame=frame), SCENERY)) is None
    with pytest.raises(ValueError, match="distance must be > 0"):
        placed(LightInScene(ph.PointLight((4, 4, 4)), SCENERY), Placing(0.0, 0.0, 0.0))


def test_a_polygon_that_is_moved_keeps_its_shape_and_faces_its_target():
    polygon = next(light for light in lights() if type(light) is ph.PolygonLight)
    moved = placed(LightInScene(polygon, SCENERY), Placing(120.0, 10.0, 4.0))

    def sides(light):
        corners = np.array(light.corners)
        return np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)

    np.testing.assert_allclose(sides(moved), sides(polygon))
    before, after = (LightInScene(light, SCENERY) for light in (polygon, moved))
    facing = [each.normal @ (CENTER - each.origin) / np.linalg.norm(CENTER - each.origin) for each in (before, after)]
    assert facing[1] == pytest.approx(facing[0])
