"""Lights from PyVista, VTK and homogeneous positions, and back: nothing rounded, nothing modified."""

import dataclasses
import math

import numpy as np
import pytest
import pyvista as pv
import vtk
from hypothesis import given, settings
from hypothesis import strategies as st

from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight, light_from_homogeneous
from pvphong.scene.viewer import Viewer
from pvphong.vtk.lights import as_light, write_light

THIRD, SEVENTH = 1 / 3, 1 / 7
COLORS = {
    "diffuse": (0.1, THIRD, 0.7),
    "specular": (SEVENTH, 0.2, 3.0),
    "ambient": (1e-9, 0.3, 1 / 255 + 1e-6),
    "intensity": 1.2345678901234567,
    "on": False,
}
QUICK = settings(max_examples=60, derandomize=True, deadline=None, database=None)
FRAMES = ["world", "camera", "headlight"]
every_frame = pytest.mark.parametrize("frame", FRAMES)


def readings(light):
    """Everything that can be read off a VTK light, its time of modification included."""
    names = [name for name in dir(vtk.vtkLight) if name.startswith(("Get", "LightTypeIs"))]
    result = {}
    for name in names:
        try:
            result[name] = getattr(light, name)()
        except TypeError:  # needs arguments
            continue
    matrix = light.GetTransformMatrix()
    result["matrix"] = None if matrix is None else [matrix.GetElement(i, j) for i in range(4) for j in range(4)]
    return {name: value for name, value in result.items() if isinstance(value, (int, float, tuple, list, type(None)))}


def renderer_with(light, viewer):
    renderer = vtk.vtkRenderer()
    renderer.AddLight(light)
    camera = renderer.GetActiveCamera()
    camera.SetPosition(viewer.position)
    camera.SetFocalPoint(viewer.focal_point)
    camera.SetViewUp(viewer.up)
    return renderer


def random_viewer(seed):
    rng = np.random.default_rng(seed)
    position = rng.normal(size=3) * 10.0 ** rng.uniform(-2, 4)
    away = rng.normal(size=3) * 10.0 ** rng.uniform(-2, 4)
    return Viewer(position=position, focal_point=position + away, up=rng.normal(size=3))


# --- homogeneous positions ---


def test_w_zero_is_a_directional_light_from_there():
    light = light_from_homogeneous((1, -2, 3, 0), diffuse="red", name="sun")
    assert light == DirectionalLight(direction=(-1, 2, -3), diffuse="red", name="sun")


@pytest.mark.parametrize("w", [1.0, 2.0, -4.0, 0.125])
def test_other_w_is_a_point_light_at_the_quotient(w):
    light = light_from_homogeneous((1, -2, 3, w), attenuation=(0, 0, 1), intensity=2)
    assert light == PointLight(position=(1 / w, -2 / w, 3 / w), attenuation=(0, 0, 1), intensity=2)


def test_tiny_w_tends_to_the_directional_light():
    place = np.array([[0.3], [0.2], [0.1]])
    far = light_from_homogeneous((1, -2, 3, 1e-12)).arrival(place).direction
    np.testing.assert_allclose(far, light_from_homogeneous((1, -2, 3, 0)).arrival(place).direction, atol=1e-11)


@pytest.mark.parametrize("bad", [(0, 0, 0, 0), (1, 2, 3), (1, 2, 3, math.nan), "1230", None])
def test_homogeneous_position_is_refused_by_name(bad):
    with pytest.raises(ValueError, match=r"^position"):
        light_from_homogeneous(bad)


@pytest.mark.parametrize("w", [1e-320, -1e-310])
def test_homogeneous_position_beyond_the_floats_is_refused_by_name(w):
    with pytest.raises(ValueError, match=r"^position"):
        light_from_homogeneous((1, 2, 3, w))


def test_homogeneous_light_passes_bad_fields_on():
    with pytest.raises(ValueError, match=r"^intensity"):
        light_from_homogeneous((1, 2, 3, 1), intensity=-1)
    with pytest.raises(TypeError, match="attenuation"):
        light_from_homogeneous((1, 2, 3, 0), attenuation=(1, 0, 0))


# --- from PyVista and VTK ---


def test_own_lights_come_back_as_they_are():
    for light in (DirectionalLight(), PointLight(), SpotLight(frame="headlight")):
        assert as_light(light) is light


@pytest.mark.parametrize("bad", [None, "headlight", 5, vtk.vtkCamera(), {"position": (0, 0, 0)}, pv.Sphere()])
def test_what_is_no_light_is_refused(bad):
    with pytest.raises(ValueError, match=r"^light must be a pvphong light, a pyvista\.Light or a vtkLight; got "):
        as_light(bad)


def test_a_vtk_scene_light_is_directional():
    light = vtk.vtkLight()
    light.SetLightTypeToSceneLight()
    light.SetPosition(0.1, 0.2, 0.3)
    light.SetFocalPoint(1, 1, 1)
    assert as_light(light) == DirectionalLight(direction=(1 - 0.1, 1 - 0.2, 1 - 0.3))


def test_a_positional_light_with_a_cone_is_a_spot():
    light = pv.Light(position=(1, 2, 3), focal_point=(1, 2, 0), positional=True, cone_angle=25, exponent=THIRD)
    light.attenuation_values = (0.1, 0.2, 0.3)
    converted = as_light(light)
    assert isinstance(converted, SpotLight)
    assert (converted.position, converted.direction) == ((1.0, 2.0, 3.0), (0.0, 0.0, -3.0))
    assert (converted.cone_angle, converted.exponent) == (25.0, THIRD)
    assert converted.attenuation == (0.1, 0.2, 0.3)


@pytest.mark.parametrize("cone_angle", [90, 91, 180])
def test_a_positional_light_without_a_cone_is_a_point_light(cone_angle):
    light = pv.Light(position=(1, 2, 3), positional=True, cone_angle=cone_angle, exponent=5)
    assert as_light(light) == PointLight(position=(1, 2, 3))


@every_frame
def test_every_float_is_taken_over_exactly(frame):
    light = pv.Light(light_type={"world": "scene light", "camera": "camera light", "headlight": "headlight"}[frame])
    light.SetDiffuseColor(COLORS["diffuse"])
    light.SetSpecularColor(COLORS["specular"])
    light.SetAmbientColor(COLORS["ambient"])
    light.SetIntensity(COLORS["intensity"])
    light.SetSwitch(False)
    converted = as_light(light)
    assert {field: getattr(converted, field) for field in COLORS} == COLORS
    assert converted.frame == frame


def test_one_colour_for_both_is_the_unset_specular():
    light = vtk.vtkLight()
    light.SetDiffuseColor(0.1, 0.2, 0.3)
    light.SetSpecularColor(0.1, 0.2, 0.3)
    assert as_light(light).specular is None
    light.SetSpecularColor(0.1, 0.2, 0.3000000000001)
    assert as_light(light).specular == (0.1, 0.2, 0.3000000000001)


@pytest.mark.parametrize("positional", [False, True])
def test_a_transform_matrix_is_applied_to_scene_lights(positional):
    light = pv.Light(position=(1, 2, 3), focal_point=(1, 0, 0), positional=positional, cone_angle=40)
    matrix = np.array([[0, -2, 0, 5], [2, 0, 0, 6], [0, 0, 2, 7], [0, 0, 0, 1]], float)
    light.transform_matrix = matrix
    position, focal = matrix @ (1, 2, 3, 1), matrix @ (1, 0, 0, 1)
    converted = as_light(light)
    assert converted.direction == tuple((focal - position)[:3])
    assert not positional or converted.position == tuple(position[:3])
    assert converted.frame == "world"


@pytest.mark.parametrize(
    ("setting", "value", "field"),
    [
        ("SetConeAngle", -5.0, "cone_angle"),
        ("SetConeAngle", 0.0, "cone_angle"),
        ("SetAttenuationValues", (0, 0, 0), "attenuation"),
        ("SetAttenuationValues", (-1, 0, 1), "attenuation"),
        ("SetIntensity", -1.0, "intensity"),
        ("SetFocalPoint", (0, 0, 1), "direction"),
        ("SetDiffuseColor", (-1, 0, 0), "diffuse"),
    ],
)
def test_what_pvphong_does_not_allow_is_refused_by_name(setting, value, field):
    light = vtk.vtkLight()
    light.SetPositional(True)
    getattr(light, setting)(value)
    with pytest.raises(ValueError, match=rf"^{field}"):
        as_light(light)


@pytest.mark.parametrize("viewer", [None, Viewer(position=(3, 4, 5), focal_point=(1, 1, 1))])
@pytest.mark.parametrize("kind", ["scene light", "camera light", "headlight"])
@pytest.mark.parametrize("positional", [False, True])
def test_the_light_is_not_modified(kind, positional, viewer):
    light = pv.Light(position=(1, 2, 3), focal_point=(0, 1, 0), color="tomato", light_type=kind, positional=positional)
    if kind != "headlight" or viewer is not None:
        light.transform_matrix = np.diag([2.0, 3, 4, 1])
    before = readings(light)
    as_light(light, viewer)
    assert readings(light) == before
    assert before["GetMTime"] == light.GetMTime()


def test_a_headlight_with_a_matrix_has_no_place_without_a_viewer():
    light = pv.Light(light_type="headlight")
    light.transform_matrix = np.diag([2.0, 3, 4, 1])
    with pytest.raises(
        ValueError, match=r"light must be a headlight without a transform matrix.*as_light\(light, viewer\)"
    ):
        as_light(light)


def test_subclasses_of_vtk_lights_are_lights():
    class Lamp(vtk.vtkLight):
        pass

    assert as_light(Lamp()) == as_light(vtk.vtkLight())


# --- camera lights and headlights in the world ---


@pytest.mark.parametrize("positional", [False, True])
@pytest.mark.parametrize("seed", range(12))
def test_a_camera_light_is_where_vtk_puts_it(seed, positional):
    rng = np.random.default_rng(seed + 500)
    viewer = random_viewer(seed)
    light = pv.Light(light_type="camera light", positional=positional, cone_angle=60)
    light.position, light.focal_point = rng.normal(size=3), rng.normal(size=3)
    ours = as_light(light, viewer)
    renderer_with(light, viewer).UpdateLightsGeometryToFollowCamera()
    position, focal = (np.array(p) for p in (light.GetTransformedPosition(), light.GetTransformedFocalPoint()))
    assert ours.frame == "world"
    size = np.abs(position).max() + np.abs(focal).max()
    kept, expected = (np.array(v) / np.linalg.norm(v) for v in (ours.direction, focal - position))
    np.testing.assert_allclose(kept, expected, atol=1e-12 * (1 + size / np.linalg.norm(focal - position)))
    if positional:
        np.testing.assert_allclose(ours.position, position, atol=1e-13 * (size + viewer.distance))


@pytest.mark.parametrize("positional", [False, True])
@pytest.mark.parametrize("seed", range(6))
def test_a_camera_light_in_eye_space_becomes_the_same_light_in_the_world(seed, positional):
    viewer = random_viewer(seed)
    light = pv.Light(light_type="camera light", positional=positional, cone_angle=60)
    light.position, light.focal_point = (0.3, -0.2, 1.4), (0.1, 0.1, -1)
    placed = as_light(light, viewer)
    renderer_with(light, viewer).UpdateLightsGeometryToFollowCamera()  # tells the light the camera's distance
    riding = as_light(light)
    assert riding.frame == "camera"
    again = riding.in_world(viewer)
    size = np.linalg.norm(viewer.position) + viewer.distance
    for field in ("position", "direction")[not positional :]:
        np.testing.assert_allclose(getattr(again, field), getattr(placed, field), atol=1e-13 * size)


def test_a_camera_light_that_vtk_has_not_placed_yet_counts_in_units():
    light = pv.Light(position=(0.5, 0.25, 1), light_type="camera light", positional=True, cone_angle=180)
    light = as_light(light)
    assert (light.position, light.frame) == ((0.5, 0.25, 0.0), "camera")  # VTK's eye is at (0, 0, 1)


def test_stale_camera_lights_are_placed_by_the_viewer_given():
    light = pv.Light(position=(1, 2, 3), light_type="camera light", positional=True)
    first, second = random_viewer(1), random_viewer(2)
    fresh = as_light(light, second)
    renderer_with(light, first).UpdateLightsGeometryToFollowCamera()
    assert as_light(light, second) == fresh
    assert as_light(light, first) != fresh


@pytest.mark.parametrize("positional", [False, True])
def test_a_headlight_has_the_viewers_coordinates(positional):
    viewer = random_viewer(5)
    light = pv.Light(position=(9, 9, 9), light_type="headlight", positional=positional)
    ours = as_light(light, viewer)
    assert ours.frame == "headlight"
    renderer_with(light, viewer).UpdateLightsGeometryToFollowCamera()
    along = np.subtract(light.GetFocalPoint(), light.GetPosition())
    np.testing.assert_allclose(ours.direction, along / np.linalg.norm(along), rtol=1e-12)
    assert not positional or ours.position == light.GetPosition()


# --- there and back ---

numbers = st.floats(-1e6, 1e6)
vectors = st.tuples(numbers, numbers, numbers)
directions = vectors.filter(lambda v: max(map(abs, v)) > 1e-6)
colors = st.tuples(*[st.floats(0, 1e3)] * 3)
commons = st.fixed_dictionaries(
    {
        "diffuse": colors,
        "specular": st.none() | colors,
        "ambient": colors,
        "intensity": st.floats(0, 1e3),
        "on": st.booleans(),
        "frame": st.sampled_from(FRAMES),
    }
)
attenuations = st.tuples(*[st.floats(0, 1e3)] * 3).filter(any)


def as_vtk_keeps(light):
    """VTK stores both colours, and no coordinates of headlights: in eye space they are always the same."""
    changes = {"specular": None} if light.specular == light.diffuse else {}
    if light.frame == "headlight":
        eye = {"position": (0.0, 0.0, 0.0), "direction": (0.0, 0.0, -1.0)}
        changes |= {field: value for field, value in eye.items() if hasattr(light, field)}
    return dataclasses.replace(light, **changes)


@given(directions, commons)
@QUICK
def test_directional_lights_come_back_exactly(direction, common):
    light = DirectionalLight(direction=direction, **common)
    assert as_light(light.to_pyvista()) == as_vtk_keeps(light)


@given(vectors, attenuations, commons)
@QUICK
def test_point_lights_come_back_exactly(position, attenuation, common):
    light = as_vtk_keeps(PointLight(position=position, attenuation=attenuation, **common))
    back = as_light(light.to_pyvista())
    if light.frame == "camera":  # VTK measures from one unit before the eye
        np.testing.assert_allclose(back.position, light.position, rtol=2.0**-52, atol=2.0**-52)
        back = dataclasses.replace(back, position=light.position)
    assert back == light


@given(vectors, directions, st.floats(1e-3, 89.9), st.floats(0, 128), attenuations, commons)
@QUICK
def test_spot_lights_come_back_but_for_the_rounding_of_the_focal_point(
    position, direction, cone_angle, exponent, attenuation, common
):
    light = as_vtk_keeps(SpotLight(position, direction, cone_angle, exponent, attenuation, **common))
    back = as_light(light.to_pyvista())
    far = max(map(abs, light.position + light.direction)) + 1
    np.testing.assert_allclose(back.position, light.position, atol=2.0**-52 * far)
    np.testing.assert_allclose(back.direction, light.direction, atol=2.0**-51 * far)
    assert light.frame == "camera" or back.position == light.position
    assert dataclasses.replace(back, position=light.position, direction=light.direction) == light


def test_exponents_end_where_vtks_do():
    assert as_light(SpotLight(exponent=1000).to_pyvista()).exponent == 128.0


@pytest.mark.parametrize("kind", [PointLight, SpotLight])
@pytest.mark.parametrize("seed", range(6))
def test_positional_camera_lights_come_back_with_the_viewers_distance(kind, seed):
    viewer = random_viewer(seed)
    light = kind(position=(0.3, -0.7, -2.5), frame="camera")
    there = light.to_pyvista(viewer)
    placed, expected = as_light(there, viewer), light.in_world(viewer)
    size = np.linalg.norm(viewer.position) + viewer.distance
    np.testing.assert_allclose(placed.position, expected.position, atol=1e-13 * size)
    renderer_with(there, viewer).UpdateLightsGeometryToFollowCamera()
    np.testing.assert_allclose(there.GetTransformedPosition(), expected.position, atol=1e-13 * size)
    np.testing.assert_allclose(as_light(there).position, light.position, atol=1e-13 * (1 + viewer.distance))


@every_frame
@pytest.mark.parametrize("kind", [DirectionalLight, PointLight, SpotLight])
def test_an_existing_light_can_be_given_the_values(kind, frame):
    light = kind(frame=frame, diffuse=(0.1, 0.2, 0.3), intensity=0.5)
    for other in (vtk.vtkLight(), pv.Light(position=(9, 8, 7), positional=True, cone_angle=10, light_type="headlight")):
        other.SetTransformMatrix(pv.vtkmatrix_from_array(np.diag([2.0, 3, 4, 1])))
        write_light(light, other)
        assert as_light(other) == as_light(light.to_pyvista()) == light
        assert other.GetTransformMatrix() is None


@every_frame
@pytest.mark.parametrize("kind", [DirectionalLight, PointLight, SpotLight])
def test_to_pyvista_leaves_the_light_alone(kind, frame):
    light = kind(frame=frame, diffuse=(0.1, 0.2, 0.3))
    before = dataclasses.asdict(light)
    light.to_pyvista().SetDiffuseColor(1, 1, 1)
    assert dataclasses.asdict(light) == before
