"""Ready-made lights, compared with PyVista's and VTK's."""

from importlib.util import find_spec

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
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


SETUPS = [
    pytest.param(name, marks=pytest.mark.skipif(name == "sun" and not find_spec("pvlib"), reason="needs pvlib"))
    for name in ph.setups
]

BALL = pv.Sphere(radius=2.0, center=(7, -3, 5), theta_resolution=60, phi_resolution=60)
WHITE = ph.Material(ambient=0.0, diffuse=1.0)


@pytest.mark.parametrize("name", SETUPS)
@pytest.mark.parametrize("viewer", [None, VIEWER, Viewer((7, -3, 60), (7, -3, 5), (0, 1e-9, 1))])
def test_set_ups_light_a_white_ball_well_and_clip_nothing(name, viewer):
    lights = ph.setups[name](BALL, viewer)
    assert len({light.name for light in lights}) == len(lights) > 1
    seen = viewer or Viewer.framing(BALL.bounds)
    lit = BALL.phong.shade(ph.Scene(lights, seen, ph.LightModel(ambient=0.0, clamp=False)), WHITE)["phong"]
    assert 0.3 < lit.max() <= 1.1
    assert lit.mean() > 0.05


@pytest.mark.parametrize("name", SETUPS)
def test_a_set_up_moves_and_grows_with_its_mesh(name):
    """Colours do not depend on the mesh's unit and place."""
    near, far = BALL.translate(-np.array(BALL.center)), BALL.scale(100.0)
    colors = [
        mesh.phong.shade(ph.Scene(ph.setups[name](mesh), Viewer.framing(mesh.bounds)), WHITE)["phong"]
        for mesh in (near, far)
    ]
    np.testing.assert_allclose(*colors, atol=1e-4)


def test_softboxes_are_above_the_horizon_of_a_viewer_who_looks_down():
    for name in ("product", "two softboxes", "rim"):
        for light in ph.setups[name](pv.Sphere(), Viewer((5, 5, 8), up=(0, 0, 1))):
            assert light.position[2] > 0.3, (name, light.name)
            assert np.dot(light.direction, light.position) < 0.0  # towards the centre


@pytest.mark.parametrize("name", SETUPS)
@pytest.mark.parametrize("mesh", [pv.PolyData(), (0, 0, 1, 1, 2, 2), "sphere"])
def test_set_ups_refuse_what_has_no_size(name, mesh):
    with pytest.raises(ValueError, match=r"^bounds must be"):
        ph.setups[name](mesh)


def test_an_unknown_set_up_is_refused_and_all_are_named():
    assert list(ph.setups) == ["three-point", "product", "two softboxes", "rim", "sky", "sun"]
    assert "portrait" not in ph.setups
    with pytest.raises(ValueError, match=r"^name must be one of .*; got portrait"):
        ph.setups["portrait"]
