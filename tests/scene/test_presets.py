"""Ready-made lights, compared with PyVista's and VTK's."""

import numpy as np
import pytest
import pyvista as pv

from pvphong import Viewer, three_point
from pvphong.vtk.lights import from_vtk, light_kit

VIEWER = Viewer(position=(3, -8, 4), focal_point=(0, 0, 0), up=(0, 0, 1))


def test_the_light_kit_is_what_a_plotter_has(new_plotter):
    renderer = new_plotter(lighting="light kit").renderer
    ours, pyvistas = light_kit(), [from_vtk(light, 1.0) for light in renderer.GetLights()]
    assert len({light.name for light in ours}) == len(ours) == len(pyvistas)
    for light, expected in zip(ours, pyvistas, strict=True):
        assert (light.frame, light.on) == (expected.frame, expected.on)
        np.testing.assert_allclose(light.direction, expected.direction, atol=1e-12)
        np.testing.assert_allclose(light.diffuse, expected.diffuse, atol=0.51 / 255)  # PyVista keeps 8 bits
        assert light.intensity == pytest.approx(expected.intensity)


def test_three_point_stands_as_a_photographer_puts_it():
    mesh = pv.Cube(center=(10, 20, 30))
    viewer = Viewer(position=(10, 12, 30), focal_point=(10, 20, 30), up=(0, 0, 1))
    key, fill, rim = three_point(mesh, viewer)
    assert [light.name for light in (key, fill, rim)] == ["key", "fill", "rim"]
    seen = {light.name: viewer.axes @ (np.array(light.position) - mesh.center) for light in (key, fill, rim)}
    right, up, back = seen["key"]
    assert right < 0 < up
    assert back > 0
    assert np.degrees(np.arctan2(-right, back)) == pytest.approx(45)
    assert np.degrees(np.arcsin(up / np.linalg.norm(seen["key"]))) == pytest.approx(30)
    assert seen["fill"][0] > 0
    assert seen["rim"][2] < 0 < seen["rim"][1]
    assert key.intensity / fill.intensity == pytest.approx(4)
    for way in seen.values():
        assert np.linalg.norm(way) == pytest.approx(np.sqrt(3.0))  # a diagonal of the bounds


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"mesh": pv.PolyData()}, "bounds must be"),
        ({"mesh": (0, 0, 1, 1, 2, 2)}, "bounds must be the bounds of a mesh with at least two different points"),
        ({"mesh": (1, 0, 0, 1, 0, 1)}, "bounds must be"),
        ({"mesh": "sphere"}, "bounds must be 6 finite numbers"),
        ({"viewer": (0, 0, 1)}, "viewer must be a Viewer"),
        *(({"ratio": bad}, "ratio must be a finite number >= 1") for bad in (0.5, 0, -1, float("nan"), "4")),
    ],
)
def test_what_cannot_be_lit(arguments, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        three_point(**{"mesh": pv.Sphere(), "viewer": VIEWER} | arguments)
