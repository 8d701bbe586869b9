"""Conversion of lights from PyVista, VTK and homogeneous positions, and back, without rounding or modification."""

import dataclasses
import math

import numpy as np
import pytest
import pyvista as pv
import vtk
from strategies import LIGHT_SHAPES, Dice, triple

from pvphong.optics.lights import (
    LIGHT_TYPES,
    DirectionalLight,
    PointLight,
    SpotLight,
    is_in_vtk,
    light_from_homogeneous,
)
from pvphong.scene.viewer import Viewer
from pvphong.vtk.lights import as_light, write_light

FRAMES = {"headlight": 1, "camera": 2, "world": 3}  # VTK's light types
every_frame = pytest.mark.parametrize("frame", FRAMES)
either = pytest.mark.parametrize("positional", [False, True])


def lamp(frame="world", **values):
    """Make a vtkLight with values set by name, such as `ConeAngle` with `SetConeAngle`."""
    light = vtk.vtkLight()
    light.SetLightType(FRAMES[frame])
    for name, value in values.items():
        getattr(light, f"Set{name}")(value)
    return light


def matrix_of(rows):
    return pv.vtkmatrix_from_array(np.array(rows, float))


STRETCH = matrix_of(np.diag([2.0, 3, 4, 1]))


def place_as_vtk_does(light, viewer):
    """Update the light's transformed coordinates for a viewer, as VTK does when it renders."""
    renderer = vtk.vtkRenderer()
    renderer.AddLight(light)
    camera = renderer.GetActiveCamera()
    camera.SetPosition(viewer.position)
    camera.SetFocalPoint(viewer.focal_point)
    camera.SetViewUp(viewer.up)
    renderer.UpdateLightsGeometryToFollowCamera()


def random_viewer(seed):
    rng = np.random.default_rng(seed)
    position = rng.normal(size=3) * 10.0 ** rng.uniform(-2, 4)
    away = rng.normal(size=3) * 10.0 ** rng.uniform(-2, 4)
    return Viewer(position=position, focal_point=position + away, up=rng.normal(size=3))


# --- homogeneous positions ---


@pytest.mark.parametrize("w", [1.0, 2.0, -4.0, 0.125])
def test_w_zero_is_a_directional_light_from_there_and_other_w_a_point_light_at_the_quotient(w):
    sun = light_from_homogeneous((1, -2, 3, 0), diffuse="red", name="sun")
    assert sun == DirectionalLight((-1, 2, -3), diffuse="red", name="sun")
    lamp = light_from_homogeneous((1, -2, 3, w), attenuation=(0, 0, 1), intensity=2)
    assert lamp == PointLight((1 / w, -2 / w, 3 / w), (0, 0, 1), intensity=2)


NO_PLACES = [(0, 0, 0, 0), (1, 2, 3), (1, 2, 3, math.nan), "1230", None, (1, 2, 3, 1e-320), (1, 2, 3, -1e-310)]


@pytest.mark.parametrize(
    ("position", "fields", "error", "message"),
    [
        *((bad, {}, ValueError, "^position") for bad in NO_PLACES),
        ((1, 2, 3, 1), {"intensity": -1}, ValueError, "^intensity"),
        ((1, 2, 3, 0), {"attenuation": (1, 0, 0)}, TypeError, "attenuation"),
    ],
)
def test_bad_homogeneous_positions_and_fields_are_refused_by_name(position, fields, error, message):
    with pytest.raises(error, match=message):
        light_from_homogeneous(position, **fields)


# --- from PyVista and VTK ---

VTKS = {
    "DiffuseColor": (0.1, 1 / 3, 0.7),
    "SpecularColor": (1 / 7, 0.2, 3.0),
    "AmbientColor": (1e-9, 0.3, 1 / 255 + 1e-6),
    "Intensity": 1.2345678901234567,
    "Switch": False,
}
OURS = dict(zip(("diffuse", "specular", "ambient", "intensity", "on"), VTKS.values(), strict=True))
PLACED = {"Positional": True, "Position": (1, 2, 3)}
CONE = {"FocalPoint": (1, 2, 0), "ConeAngle": 25, "Exponent": 1 / 3, "AttenuationValues": (0.1, 0.2, 0.3)}
GREY = (0.1, 0.2, 0.3)


@pytest.mark.parametrize(
    ("values", "light"),
    [
        *(({"frame": frame, **VTKS}, DirectionalLight(frame=frame, **OURS)) for frame in FRAMES),
        ({"DiffuseColor": GREY, "SpecularColor": GREY}, DirectionalLight(diffuse=GREY)),
        ({"SpecularColor": (1, 1, 1 + 1e-13)}, DirectionalLight(specular=(1, 1, 1 + 1e-13))),
        ({"Position": (0.1, 0.2, 0.3), "FocalPoint": (1, 1, 1)}, DirectionalLight((1 - 0.1, 1 - 0.2, 1 - 0.3))),
        ({"ShadowAttenuation": 0.0}, DirectionalLight(casts_shadows=False)),
        ({"ShadowAttenuation": 0.25}, DirectionalLight()),  # partly dark
        (PLACED | CONE, SpotLight((1, 2, 3), (0, 0, -3), 25, 1 / 3, (0.1, 0.2, 0.3))),
        *((PLACED | {"ConeAngle": cone, "Exponent": 5}, PointLight((1, 2, 3))) for cone in (90, 91, 180)),
        (  # VTK's eye is at (0, 0, 1); the light does not store its distance from the focal point
            PLACED | {"frame": "camera", "Position": (0.5, 0.25, 1), "ConeAngle": 180},
            PointLight((0.5, 0.25, 0.0), frame="camera"),
        ),
    ],
)
def test_every_value_of_vtks_is_taken_over_exactly(values, light):
    assert as_light(lamp(**values)) == light


def test_pvphongs_own_lights_are_lights():
    assert as_light(vtk.vtkLight()) == as_light(pv.Light())
    for light in (DirectionalLight(), PointLight(), SpotLight(frame="headlight")):
        assert as_light(light) is light


@either
def test_a_transform_matrix_is_applied_to_scene_lights(positional):
    rows = np.array([[0, -2, 0, 5], [2, 0, 0, 6], [0, 0, 2, 7], [0, 0, 0, 1]], float)
    values = {"Position": (1, 2, 3), "FocalPoint": (1, 0, 0), "ConeAngle": 40, "TransformMatrix": matrix_of(rows)}
    position, focal = rows @ (1, 2, 3, 1), rows @ (1, 0, 0, 1)
    converted = as_light(lamp(Positional=positional, **values))
    assert converted.direction == tuple((focal - position)[:3])
    assert not positional or converted.position == tuple(position[:3])
    assert converted.frame == "world"


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        *(
            (bad, r"^light must be a pvphong light, a pyvista\.Light or a vtkLight; got ")
            for bad in (None, "headlight", 5, vtk.vtkCamera(), {"position": (0, 0, 0)}, pv.Sphere())
        ),
        (lamp(ConeAngle=-5.0, Positional=True), "^cone_angle"),
        (lamp(ConeAngle=0.0, Positional=True), "^cone_angle"),
        (lamp(AttenuationValues=(0, 0, 0), Positional=True), "^attenuation"),
        (lamp(AttenuationValues=(-1, 0, 1), Positional=True), "^attenuation"),
        (lamp(Intensity=-1.0), "^intensity"),
        (lamp(Position=(0, 0, 1), FocalPoint=(0, 0, 1)), "^direction"),
        (lamp(DiffuseColor=(-1, 0, 0)), "^diffuse"),
        (
            lamp("headlight", TransformMatrix=STRETCH),  # it has no position without a viewer
            r"^light must be a headlight without a transform matrix.*as_light\(light, viewer\)",
        ),
    ],
)
def test_what_pvphong_does_not_allow_is_refused_by_name(bad, message):
    with pytest.raises(ValueError, match=message):
        as_light(bad)


@either
@every_frame
@pytest.mark.parametrize("viewer", [None, Viewer(position=(3, 4, 5), focal_point=(1, 1, 1))])
def test_the_light_is_not_modified(frame, positional, viewer):
    light = lamp(frame, Position=(1, 2, 3), FocalPoint=(0, 1, 0), DiffuseColor=(1, 0.4, 0.3), Positional=positional)
    if frame != "headlight" or viewer is not None:
        light.SetTransformMatrix(STRETCH)
    before = str(light)  # all its values, and the time of its last modification
    as_light(light, viewer)
    assert str(light) == before


# --- camera lights and headlights in the world ---


@either
@pytest.mark.parametrize("seed", range(12))
def test_a_camera_light_is_where_vtk_puts_it(seed, positional):
    """Placed by a viewer directly, or read in eye space after VTK has stored the camera's distance, and then placed."""
    rng = np.random.default_rng(seed + 500)
    viewer = random_viewer(seed)
    values = {"Position": rng.normal(size=3), "FocalPoint": rng.normal(size=3), "Positional": positional}
    light = lamp("camera", ConeAngle=60, **values)
    placed = as_light(light, viewer)
    place_as_vtk_does(light, viewer)
    riding = as_light(light)
    assert (placed.frame, riding.frame) == ("world", "camera")
    position, focal = (np.array(p) for p in (light.GetTransformedPosition(), light.GetTransformedFocalPoint()))
    size = np.abs(position).max() + np.abs(focal).max()
    kept, expected = (np.array(v) / np.linalg.norm(v) for v in (placed.direction, focal - position))
    np.testing.assert_allclose(kept, expected, atol=1e-12 * (1 + size / np.linalg.norm(focal - position)))
    if positional:
        np.testing.assert_allclose(placed.position, position, atol=1e-13 * (size + viewer.distance))
    again = riding.in_world(viewer)
    for field in ("position", "direction")[not positional :]:
        far = np.linalg.norm(viewer.position) + viewer.distance
        np.testing.assert_allclose(getattr(again, field), getattr(placed, field), atol=1e-13 * far)


@either
def test_a_headlight_has_the_viewers_coordinates(positional):
    viewer = random_viewer(5)
    light = lamp("headlight", Position=(9, 9, 9), Positional=positional)
    ours = as_light(light, viewer)
    assert ours.frame == "headlight"
    place_as_vtk_does(light, viewer)
    along = np.subtract(light.GetFocalPoint(), light.GetPosition())
    np.testing.assert_allclose(ours.direction, along / np.linalg.norm(along), rtol=1e-12)
    assert not positional or ours.position == light.GetPosition()


# --- round trips ---

EYE = {"position": (0.0, 0.0, 0.0), "direction": (0.0, 0.0, -1.0)}


def as_vtk_keeps(name, seed):
    """Return a random light that VTK supports; coordinates of headlights are the constant ones of eye space."""
    dice = Dice(f"{name} {seed}")
    position, aim, *colors = (triple(dice.vector() * dice.log_between(1e-10, 1e10)) for _ in range(5))
    diffuse, specular, ambient = (triple(np.abs(color)) for color in colors)
    common = {"diffuse": diffuse, "specular": None if dice.likely(30) else specular, "ambient": ambient}
    common |= {"intensity": dice.uniform(0, 1e3), "on": dice.likely(50), "frame": dice.choice([*FRAMES])}
    fields = LIGHT_SHAPES[name](dice, position, aim, dice.uniform(1e-3, 89.9))
    if common["frame"] == "headlight":
        fields |= {field: value for field, value in EYE.items() if field in fields}
    return LIGHT_TYPES[name](**fields, **common, casts_shadows=dice.likely(50))


@pytest.mark.parametrize("seed", range(60))
@pytest.mark.parametrize("kind", [name for name, kind in LIGHT_TYPES.items() if is_in_vtk(kind())])
def test_lights_come_back_but_for_the_rounding_of_vtks_focal_point_and_its_highest_exponent(kind, seed):
    light = as_vtk_keeps(kind, seed)
    back, kept = as_light(light.to_pyvista()), {}
    if light.frame == "camera" and not light.is_uniform:  # the origin of VTK's space is one unit in front of the eye
        np.testing.assert_allclose(back.position, light.position, rtol=2.0**-52, atol=2.0**-52)
        kept["position"] = light.position
    if isinstance(light, SpotLight):  # its focal point is farther ahead for larger coordinates
        ahead = 2.0 ** round(math.log2(np.linalg.norm(back.direction) / np.linalg.norm(light.direction)))
        assert ahead >= 1.0
        far = max(map(abs, light.position + light.direction)) + 1
        rounding = min(2.0**-51 * far, 2.0**-31 * max(map(abs, light.direction)))
        np.testing.assert_allclose(np.array(back.direction) / ahead, light.direction, rtol=0, atol=rounding)
        assert back.exponent == min(light.exponent, 128.0)
        kept |= {"direction": light.direction, "exponent": light.exponent}
    assert dataclasses.replace(back, **kept) == light


@pytest.mark.parametrize("kind", [PointLight, SpotLight])
@pytest.mark.parametrize("seed", range(6))
def test_positional_camera_lights_come_back_with_the_viewers_distance(kind, seed):
    viewer = random_viewer(seed)
    light = kind(position=(0.3, -0.7, -2.5), frame="camera")
    there = light.to_pyvista(viewer)
    placed, expected = as_light(there, viewer), light.in_world(viewer)
    size = np.linalg.norm(viewer.position) + viewer.distance
    np.testing.assert_allclose(placed.position, expected.position, atol=1e-13 * size)
    place_as_vtk_does(there, viewer)
    np.testing.assert_allclose(there.GetTransformedPosition(), expected.position, atol=1e-13 * size)
    np.testing.assert_allclose(as_light(there).position, light.position, atol=1e-13 * (1 + viewer.distance))


@every_frame
@pytest.mark.parametrize("kind", [DirectionalLight, PointLight, SpotLight])
def test_an_existing_light_can_be_given_the_values(kind, frame):
    light = kind(frame=frame, diffuse=(0.1, 0.2, 0.3), intensity=0.5)
    for other in (vtk.vtkLight(), lamp("headlight", **PLACED, ConeAngle=10)):
        other.SetTransformMatrix(STRETCH)
        write_light(light, other)
        assert as_light(other) == as_light(light.to_pyvista()) == light
        assert other.GetTransformMatrix() is None


def test_shadows_are_left_as_dark_as_they_are_or_switched_off_and_on():
    light = DirectionalLight()
    half = pv.Light(shadow_attenuation=0.5)
    write_light(light, half)
    assert half.shadow_attenuation == 0.5
    for casts, expected in ((False, 0.0), (True, 1.0)):
        write_light(dataclasses.replace(light, casts_shadows=casts), half)
        assert half.shadow_attenuation == expected
        assert dataclasses.replace(light, casts_shadows=casts).to_pyvista().shadow_attenuation == expected


@pytest.mark.parametrize("call", [as_light, lambda light, viewer: as_light(light).to_pyvista(viewer)])
def test_what_is_no_viewer_is_refused(call):
    with pytest.raises(ValueError, match=r"^viewer must be a Viewer; got 5\. .*Viewer\.from_camera"):
        call(pv.Light(light_type="camera light"), 5)
