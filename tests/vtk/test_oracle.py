"""VTK's shader, run per vertex, against a float64 formula of it that is written here and nowhere else."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from pyvista import examples
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkCommonTransforms import vtkTransform
from vtkmodules.vtkRenderingCore import vtkCamera, vtkLight, vtkProperty, vtkRenderWindow

from pvphong.meshes.surfaces import vertex_normals
from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.optics.material import Material
from pvphong.scene.viewer import Viewer
from pvphong.vtk import vertex_window as _vertex_bench
from pvphong.vtk.oracle import driver, vtk_shade

# --- the formula: VTK's three tiers in eye space, float64 -------------------------------------------------------


@dataclass(frozen=True)
class Lamp:
    """A light by its world coordinates, for the formula, and as a `vtkLight`."""

    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    intensity: float = 1.0
    position: tuple[float, float, float] = (0.0, 0.0, 1.0)
    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    positional: bool = False
    attenuation: tuple[float, float, float] = (1.0, 0.0, 0.0)
    cone: float = 90.0
    exponent: float = 1.0
    headlight: bool = False

    def vtk(self) -> vtkLight:
        light = vtkLight()
        if self.headlight:
            light.SetLightTypeToHeadlight()
        light.SetDiffuseColor(self.color)
        light.SetIntensity(self.intensity)
        light.SetPosition(self.position)
        light.SetFocalPoint(self.target)
        light.SetPositional(self.positional)
        light.SetAttenuationValues(self.attenuation)
        light.SetConeAngle(self.cone)
        light.SetExponent(self.exponent)
        return light


def eye_axes(viewer: Viewer) -> np.ndarray:
    """Eye space's x, y and z as rows."""
    back = np.subtract(viewer.position, viewer.focal_point)
    back /= np.linalg.norm(back)
    right = np.cross(viewer.up, back)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(back, right), back])


def in_eye_space(points: np.ndarray, normals: np.ndarray, viewer: Viewer, matrix: np.ndarray) -> tuple[np.ndarray, ...]:
    axes = eye_axes(viewer)
    world = points @ matrix[:3, :3].T + matrix[:3, 3]
    turned = normals @ np.linalg.inv(matrix[:3, :3]) @ axes.T  # rows times (M⁻ᵀ)ᵀ
    return (world - viewer.position) @ axes.T, turned / np.linalg.norm(turned, axis=1)[:, None]


def factors(lamp: Lamp, p: np.ndarray, n: np.ndarray, viewer: Viewer, power: float, tier: int) -> np.ndarray:
    """df and sf of one light at eye-space points p and unit normals n, shape (2, n)."""
    if tier == 1:
        df = np.maximum(1e-6, n[:, 2])
        return np.array([df, df**power])
    axes, eye = eye_axes(viewer), np.array(viewer.position)
    position, target = (axes @ (np.array(x) - eye) for x in (lamp.position, lamp.target))
    if lamp.headlight:
        position, target = np.zeros(3), np.array([0.0, 0.0, -1.0])
    axis = (target - position) / np.linalg.norm(target - position)
    travel, attenuation = np.broadcast_to(axis, p.shape), np.ones(len(p))
    if lamp.positional:
        distance = np.linalg.norm(p - position, axis=1)
        travel = (p - position) / distance[:, None]
        c, linear, quadratic = lamp.attenuation
        attenuation = 1.0 / (c + linear * distance + quadratic * distance**2)
        if lamp.cone < 90.0:
            along = travel @ axis
            inside = along >= math.cos(math.radians(lamp.cone))
            attenuation = attenuation * np.where(inside, np.abs(along) ** lamp.exponent, 0.0)
    df = np.maximum(0.0, -attenuation * (n * travel).sum(axis=1))
    reflected = travel - 2.0 * (n * travel).sum(axis=1)[:, None] * n
    to_eye = -p / np.linalg.norm(p, axis=1)[:, None]
    sf = np.sign(df) * attenuation * np.maximum(1e-5, (reflected * to_eye).sum(axis=1)) ** power
    return np.array([df, sf])


def formula(
    points: np.ndarray,
    normals: np.ndarray,
    lamps: list[Lamp],
    material: Material,
    viewer: Viewer,
    matrix: np.ndarray | None = None,
) -> np.ndarray:
    """Colours (n, 3) by the table of tiers."""
    tier = 3 if any(lamp.positional for lamp in lamps) else 2
    if len(lamps) == 1 and lamps[0].headlight and not lamps[0].positional:
        tier = 1
    p, n = in_eye_space(np.float64(points), np.float64(normals), viewer, np.eye(4) if matrix is None else matrix)
    ambient, diffuse, specular = (
        np.broadcast_to(k, 3) for k in (material.ambient, material.diffuse, material.specular)
    )
    color = np.zeros(p.shape) + ambient
    for lamp in lamps:
        df, sf = factors(lamp, p, n, viewer, material.shininess, tier)
        arriving = np.array(lamp.color) * lamp.intensity
        color += df[:, None] * arriving * diffuse + sf[:, None] * arriving * specular
    return color


def bound(material: Material) -> float:
    return 16.0 * material.shininess * 2.0**-24 + 1e-6


def cloud(seed: int = 1, count: int = 4000) -> pv.PolyData:
    """Points in a box of size 2 with unit normals in all directions."""
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(count, 3))
    mesh = pv.PolyData(rng.uniform(-1.0, 1.0, (count, 3)))
    mesh.point_data.active_normals = normals / np.linalg.norm(normals, axis=1)[:, None]
    return mesh


def largest_error(
    mesh: pv.PolyData, lamps: list[Lamp], lights: list, viewer: Viewer, matrix=None, material=None
) -> float:
    material = SHINY if material is None else material
    points, normals = np.asarray(mesh.points), np.asarray(mesh.point_data.active_normals)
    colors = vtk_shade(mesh, lights, material, viewer, matrix=matrix)
    assert colors.dtype == np.float32
    assert colors.shape == (mesh.n_points, 3)
    return float(np.abs(colors - formula(points, normals, lamps, material, viewer, matrix)).max())


SHINY = Material(ambient=(0.05, 0.1, 0.2), diffuse=(0.6, 0.5, 0.3), specular=(0.3, 0.4, 0.5), shininess=25.0)
VIEWER = Viewer(position=(3.0, -4.0, 2.5), focal_point=(0.1, 0.2, -0.1), up=(0.0, 0.2, 1.0))
SUN = Lamp(color=(1.0, 0.9, 0.8), position=(1.0, -2.0, 3.0))
SKY = Lamp(color=(0.1, 0.2, 0.4), intensity=0.7, position=(-3.0, 1.0, 0.5), target=(0.2, 0.0, 0.0))
BULB = Lamp(color=(0.9, 0.7, 0.5), position=(2.0, 1.5, 2.5), positional=True)
DIM_BULB = Lamp(position=(1.0, -2.5, 1.0), positional=True, intensity=2.0, attenuation=(0.5, 0.3, 0.2))
SPOT = Lamp(position=(0.5, -3.0, 3.0), positional=True, cone=24.0, exponent=7.0, attenuation=(0.8, 0.0, 0.02))
HEADLIGHT = Lamp(color=(0.9, 1.0, 0.8), headlight=True)
LAMP_ON_HEAD = Lamp(positional=True, headlight=True, cone=14.0, exponent=3.0)

SHEAR = np.array([[1.0, 0.8, 0.0, 0.5], [0.0, 1.2, -0.4, 0.0], [0.3, 0.0, 0.7, -0.2], [0.0, 0.0, 0.0, 1.0]])
MIRROR = np.diag([-1.0, 1.3, 0.6, 1.0]) @ SHEAR

LIGHTING = {
    "one headlight (tier 1)": [HEADLIGHT],
    "one directional": [SUN],
    "two directional": [SUN, SKY],
    "headlight and directional": [HEADLIGHT, SKY],
    "point": [BULB],
    "attenuated point": [DIM_BULB],
    "spot": [SPOT],
    "positional headlight": [LAMP_ON_HEAD],
    "mixed": [SUN, HEADLIGHT, BULB, SPOT, DIM_BULB],
}


@pytest.mark.parametrize("matrix", [None, SHEAR, MIRROR], ids=["world", "sheared", "mirrored"])
@pytest.mark.parametrize("lamps", LIGHTING.values(), ids=LIGHTING.keys())
def test_agrees_with_the_formula_of_the_tiers(lamps, matrix):
    assert largest_error(cloud(), lamps, [lamp.vtk() for lamp in lamps], VIEWER, matrix) <= bound(SHINY)


@pytest.mark.parametrize("power", [0.0, 0.5, 1.0, 8.0, 128.0])
def test_agrees_at_every_power(power):
    material = Material(ambient=0.1, diffuse=0.5, specular=0.4, shininess=power)
    lamps = [SUN, BULB]
    mesh = cloud()
    error = largest_error(mesh, lamps, [lamp.vtk() for lamp in lamps], VIEWER, material=material)
    # Below power 1 a float32 step of a small cosine moves its power by more: at r·v = 1e-4 by 4e-6 for 0.5.
    assert error <= bound(material) * (1.0 if power >= 1.0 or not power else 20.0)


@pytest.mark.parametrize("lamps", [LIGHTING["mixed"], LIGHTING["two directional"], LIGHTING["one headlight (tier 1)"]])
def test_parallel_projection_keeps_a_local_viewer(lamps):
    viewer = Viewer(position=VIEWER.position, focal_point=VIEWER.focal_point, up=VIEWER.up, parallel=True)
    assert largest_error(cloud(), lamps, [lamp.vtk() for lamp in lamps], viewer) <= bound(SHINY)


@pytest.mark.parametrize(
    ("load", "viewer"),
    [
        (
            examples.load_airplane,
            Viewer(position=(2500.0, -900.0, 1200.0), focal_point=(900.0, 650.0, 150.0), up=(0, 0, 1)),
        ),
        (examples.load_ant, Viewer(position=(40.0, 60.0, 30.0), focal_point=(0.0, 0.0, 0.0), up=(0.0, 0.0, 1.0))),
        (examples.load_nut, Viewer(position=(40.0, 30.0, 50.0), focal_point=(0.0, 0.0, 0.0))),
    ],
    ids=["airplane", "ant", "nut"],
)
def test_real_meshes_with_computed_normals(load, viewer):
    mesh = load()
    mesh.clear_data()
    size, center = mesh.length, np.array(mesh.center)
    lamps = [
        Lamp(color=(0.8, 0.7, 0.6), position=(1.0, 1.0, 2.0)),
        Lamp(
            position=tuple(center + size * np.array([0.3, 0.4, 0.9])),
            target=tuple(center),
            positional=True,
            cone=25.3,
            exponent=8.0,
            attenuation=(1.0, 0.0, 0.3 / size**2),
        ),
    ]
    colors = vtk_shade(mesh, [lamp.vtk() for lamp in lamps], SHINY, viewer)
    expected = formula(mesh.points, vertex_normals(mesh), lamps, SHINY, viewer)
    assert colors[:, 0].std() > 0.05  # there is something to see
    assert np.abs(colors - expected).max() <= bound(SHINY)


# --- lights -----------------------------------------------------------------------------------------------------


def test_camera_light_rides_with_the_camera():
    light = pv.Light(light_type="camera light", position=(0.5, 0.4, 1.2), focal_point=(0.0, 0.1, 0.0))
    light.SetPositional(True)
    light.SetConeAngle(90.0)
    axes, eye = eye_axes(VIEWER), np.array(VIEWER.position)
    distance = float(np.linalg.norm(np.subtract(VIEWER.focal_point, eye)))
    # The camera stands at (0, 0, 1) of camera-light space and looks at its origin.
    world = eye + axes.T @ (distance * np.array([0.5, 0.4, 1.2 - 1.0]))
    assert largest_error(cloud(), [Lamp(position=tuple(world), positional=True)], [light], VIEWER) <= bound(SHINY)


def test_transform_matrix_of_a_light_counts():
    transform = vtkTransform()
    transform.Translate(0.3, -0.2, 0.5)
    transform.RotateWXYZ(70.0, 1.0, 2.0, -1.0)
    light = SPOT.vtk()
    light.SetTransformMatrix(transform.GetMatrix())
    position, target = (transform.TransformPoint(x) for x in (SPOT.position, SPOT.target))
    lamp = Lamp(
        position=position, target=target, positional=True, cone=24.0, exponent=7.0, attenuation=SPOT.attenuation
    )
    assert largest_error(cloud(), [lamp, SUN], [light, SUN.vtk()], VIEWER) <= bound(SHINY)


def test_a_black_light_beside_a_headlight_changes_the_tier():
    lamps = [HEADLIGHT, Lamp(color=(0.0, 0.0, 0.0))]
    lights = [lamp.vtk() for lamp in lamps]
    alone = vtk_shade(cloud(), lights[:1], SHINY, VIEWER)
    together = vtk_shade(cloud(), lights, SHINY, VIEWER)
    assert np.abs(alone - together).max() > 0.2
    assert largest_error(cloud(), lamps, lights, VIEWER) <= bound(SHINY)


@pytest.mark.parametrize(
    ("off", "before", "same"),
    [(SUN, True, True), (SUN, False, False), (BULB, True, False), (BULB, False, False), (HEADLIGHT, False, True)],
)
def test_a_light_that_is_off_beside_a_headlight_changes_the_tier_too(off, before, same):
    """VTK lets a positional light, or one behind the headlight in the list, raise the tier before its switch counts."""
    dark = off.vtk()
    dark.SetSwitch(False)
    lights = [dark, HEADLIGHT.vtk()] if before else [HEADLIGHT.vtk(), dark]
    alone, together = (vtk_shade(cloud(), given, SHINY, VIEWER) for given in ([HEADLIGHT.vtk()], lights))
    assert np.array_equal(alone, together) is same


def test_without_any_light_vtk_draws_unlit_and_with_a_black_one_ambient():
    unlit = np.add(SHINY.ambient, SHINY.diffuse)
    off = SUN.vtk()
    off.SetSwitch(False)
    for lights in ([], [off]):
        np.testing.assert_allclose(vtk_shade(cloud(), lights, SHINY, VIEWER), np.tile(unlit, (4000, 1)), atol=1e-6)
    black = SUN.vtk()
    black.SetIntensity(0.0)
    dark = vtk_shade(cloud(), [black], SHINY, VIEWER)
    np.testing.assert_allclose(dark, np.tile(SHINY.ambient, (4000, 1)), atol=1e-6)


def test_ambient_and_specular_colors_of_lights_are_ignored():
    plain, colored = BULB.vtk(), BULB.vtk()
    colored.SetSpecularColor(0.0, 0.5, 0.1)
    colored.SetAmbientColor(0.9, 0.5, 0.1)
    np.testing.assert_array_equal(
        vtk_shade(cloud(), [plain], SHINY, VIEWER), vtk_shade(cloud(), [colored], SHINY, VIEWER)
    )


def test_a_cone_of_90_degrees_is_none():
    spot = Lamp(position=(0.5, 0.1, 0.2), positional=True, cone=90.0, exponent=50.0)
    bulb = Lamp(position=(0.5, 0.1, 0.2), positional=True)
    first, second = (vtk_shade(cloud(), [lamp.vtk()], SHINY, VIEWER) for lamp in (spot, bulb))
    np.testing.assert_array_equal(first, second)


def test_more_than_eight_lights():
    lamps = [Lamp(color=(0.1, 0.1, 0.05), position=(math.cos(k), math.sin(k), 0.2 * k)) for k in range(12)]
    assert largest_error(cloud(), lamps, [lamp.vtk() for lamp in lamps], VIEWER) <= bound(SHINY)


def test_own_light_values_are_lit_alike():
    own = [
        DirectionalLight(direction=(-1.0, 2.0, -3.0), diffuse=(1.0, 0.9, 0.8)),
        PointLight(position=(2.0, 1.5, 2.5), diffuse=(0.9, 0.7, 0.5)),
        SpotLight(
            position=(0.5, -3.0, 3.0),
            direction=(-0.5, 3.0, -3.0),
            cone_angle=24.0,
            exponent=7.0,
            attenuation=(0.8, 0.0, 0.02),
        ),
        DirectionalLight(frame="headlight", diffuse=(0.9, 1.0, 0.8)),
    ]
    assert largest_error(cloud(), [SUN, BULB, SPOT, HEADLIGHT], own, VIEWER) <= bound(SHINY)


def test_own_camera_light_is_placed_in_eye_space():
    axes, eye = eye_axes(VIEWER), np.array(VIEWER.position)
    lamp = Lamp(position=tuple(eye + axes.T @ np.array([1.0, 2.0, -3.0])), positional=True)
    own = PointLight(position=(1.0, 2.0, -3.0), frame="camera")
    camera = vtkCamera()
    camera.SetPosition(VIEWER.position)
    camera.SetFocalPoint(VIEWER.focal_point)
    camera.SetViewUp(VIEWER.up)
    assert largest_error(cloud(), [lamp], [own], VIEWER) <= bound(SHINY)
    np.testing.assert_array_equal(vtk_shade(cloud(), [own], SHINY, VIEWER), vtk_shade(cloud(), [own], SHINY, camera))


def test_colors_of_lights_are_not_rounded_to_8_bits():
    lamp = Lamp(color=(0.501, 0.3337, 1.75))  # pv.Light.copy gives 128/255, 85/255 and refuses 1.75
    light = lamp.vtk()
    assert largest_error(cloud(), [lamp], [light], VIEWER) <= bound(SHINY)


def test_what_is_passed_in_is_not_modified():
    lights = [HEADLIGHT.vtk(), SPOT.vtk(), pv.Light(light_type="camera light", position=(0.1, 0.2, 0.3))]
    camera = pv.Camera()
    camera.position, camera.focal_point, camera.clipping_range = VIEWER.position, VIEWER.focal_point, (0.5, 7.0)
    prop, mesh, matrix = pv.Property(specular=0.3), cloud(count=50), SHEAR.copy()
    before = [str(x) for x in (*lights, camera, prop)], mesh.points.copy(), [x.GetReferenceCount() for x in lights]
    vtk_shade(mesh, lights, prop, camera, matrix=matrix)
    after = [str(x) for x in (*lights, camera, prop)], mesh.points.copy(), [x.GetReferenceCount() for x in lights]
    assert before[0] == after[0]
    assert before[2] == after[2]
    np.testing.assert_array_equal(before[1], after[1])
    np.testing.assert_array_equal(matrix, SHEAR)
    assert mesh.point_data.keys() == ["Normals"]


# --- materials, viewers, meshes ---------------------------------------------------------------------------------


def test_property_and_material_agree():
    prop = pv.Property(ambient=0.3, diffuse=0.7, specular=0.4, specular_power=25.0)
    prop.SetAmbientColor(0.2, 0.4, 0.6)
    prop.SetDiffuseColor(0.9, 0.5, 0.1)
    prop.SetSpecularColor(1.0, 0.5, 0.5)
    prop.SetOpacity(0.3)  # and other things that are no lighting
    prop.SetInterpolationToFlat()
    prop.SetPointSize(7.0)
    prop.SetRepresentationToWireframe()
    lights = [SUN.vtk(), BULB.vtk()]
    by_property = vtk_shade(cloud(), lights, prop, VIEWER)
    by_material = vtk_shade(cloud(), lights, Material.from_property(prop), VIEWER)
    np.testing.assert_allclose(by_property, by_material, atol=2e-7)


def test_a_property_without_lighting_is_unlit():
    prop = vtkProperty()
    prop.SetLighting(False)
    prop.SetDiffuseColor(0.25, 0.5, 1.0)
    colors = vtk_shade(cloud(count=5), [SUN.vtk()], prop, VIEWER)
    np.testing.assert_allclose(colors, np.tile([0.25, 0.5, 1.0], (5, 1)), atol=1e-7)


def test_a_mesh_behind_the_viewer_is_shaded_too():
    away = Viewer(position=VIEWER.position, focal_point=(6.0, -8.0, 5.0), up=(0.0, 0.0, 1.0))
    assert largest_error(cloud(), [SUN, BULB], [SUN.vtk(), BULB.vtk()], away) <= bound(SHINY)


def test_a_viewer_looking_along_its_up_is_no_matter_unless_a_light_rides_with_it():
    upright = Viewer(position=(0.0, 0.0, 5.0), up=(0.0, 0.0, 1.0))
    level = Viewer(position=(0.0, 0.0, 5.0), up=(0.0, 1.0, 0.0))
    lights = [SUN.vtk(), BULB.vtk()]
    first, second = (vtk_shade(cloud(), lights, SHINY, viewer) for viewer in (upright, level))
    np.testing.assert_allclose(first, second, atol=bound(SHINY))
    with pytest.raises(ValueError, match=r"up must be off the view axis"):
        vtk_shade(cloud(), [PointLight(frame="camera")], SHINY, upright)


def test_odd_rows_are_nan_and_leave_the_others_alone():
    mesh = cloud(count=300)
    expected = vtk_shade(mesh, [SUN.vtk(), BULB.vtk()], SHINY, VIEWER)
    spoiled = mesh.copy()
    normals, points = np.array(spoiled.point_data.active_normals), np.array(spoiled.points)
    normals[3] = 0.0
    normals[50, 1] = np.nan
    points[120, 2] = np.inf
    points[299, 0] = 1e60  # more than float32 holds
    spoiled.points = points
    spoiled.point_data.active_normals = normals
    colors = vtk_shade(spoiled, [SUN.vtk(), BULB.vtk()], SHINY, VIEWER)
    odd = [3, 50, 120, 299]
    assert np.isnan(colors[odd]).all()
    np.testing.assert_array_equal(np.delete(colors, odd, axis=0), np.delete(expected, odd, axis=0))
    spoiled.point_data.active_normals = np.zeros((300, 3))
    assert np.isnan(vtk_shade(spoiled, [SUN.vtk()], SHINY, VIEWER)).all()


def test_a_volume_is_shaded_on_its_surface():
    grid = examples.load_hexbeam()
    colors = vtk_shade(grid, [SUN.vtk()], SHINY, VIEWER)
    outer = grid.extract_surface(algorithm=None)
    assert np.isfinite(colors).all()
    np.testing.assert_array_equal(colors, vtk_shade(outer, [SUN.vtk()], SHINY, VIEWER))


def test_shared_matrix_types():
    matrix = vtkMatrix4x4()
    matrix.DeepCopy(SHEAR.ravel().tolist())
    lights = [SUN.vtk()]
    first, second = (vtk_shade(cloud(), lights, SHINY, VIEWER, matrix=m) for m in (matrix, SHEAR.tolist()))
    np.testing.assert_array_equal(first, second)


def test_vertices_over_several_passes_are_the_same(monkeypatch):
    mesh, lights = cloud(count=5000), [SUN.vtk(), SPOT.vtk()]
    whole = vtk_shade(mesh, lights, SHINY, VIEWER)
    monkeypatch.setattr(_vertex_bench, "SIDE", 32)  # 1024 vertices a pass
    np.testing.assert_array_equal(vtk_shade(mesh, lights, SHINY, VIEWER), whole)


def test_a_million_vertices():
    mesh = cloud(seed=7, count=1_000_000)
    error = largest_error(mesh, [SUN], [SUN.vtk()], VIEWER)
    assert error <= bound(SHINY)


def test_a_single_vertex():
    assert largest_error(cloud(count=1), [SUN], [SUN.vtk()], VIEWER) <= bound(SHINY)


# --- the window -------------------------------------------------------------------------------------------------


def resources() -> tuple[int, int]:
    """Open files, and resident memory in MiB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return len(os.listdir("/proc/self/fd")), pages * os.sysconf("SC_PAGE_SIZE") // 2**20


def count_open(monkeypatch: pytest.MonkeyPatch) -> list[vtkRenderWindow]:
    """The windows that are made from here on."""
    made: list[vtkRenderWindow] = []

    def make() -> vtkRenderWindow:
        made.append(vtkRenderWindow())
        return made[-1]

    monkeypatch.setattr(_vertex_bench, "vtkRenderWindow", make)
    return made


def test_the_window_is_closed_also_after_an_error(monkeypatch):
    made = count_open(monkeypatch)
    vtk_shade(cloud(count=9), [SUN.vtk()], SHINY, VIEWER)
    monkeypatch.setattr(_vertex_bench, "_drawn", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        vtk_shade(cloud(count=9), [SUN.vtk()], SHINY, VIEWER)
    assert len(made) == 2
    for window in made:
        assert not window.GetInitialized()
        assert window.GetRenderers().GetNumberOfItems() == 0


def test_undrawn_vertices_are_noticed(monkeypatch):
    monkeypatch.setattr(_vertex_bench, "_TO_PIXEL", "//VTK::CustomEnd::Impl\n")  # all stay where they are
    with pytest.raises(RuntimeError, match=r"left \d+ of 4000 vertices undrawn"):
        vtk_shade(cloud(), [SUN.vtk()], SHINY, VIEWER)


def test_no_display_is_nothing_to_complain_about():
    hidden = {name: value for name, value in os.environ.items() if not name.endswith("DISPLAY")}
    code = "from pvphong.vtk.oracle import driver; print(driver())"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=hidden)
    assert run.stdout.strip() == driver()
    assert run.stderr == ""


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="counts resources where /proc is")
def test_a_hundred_calls_leave_nothing_behind():
    mesh, lights = cloud(count=20_000), [SUN.vtk()]
    for _ in range(5):
        vtk_shade(mesh, lights, SHINY, VIEWER)
    files, memory = resources()
    for _ in range(100):
        vtk_shade(mesh, lights, SHINY, VIEWER)
    files_after, memory_after = resources()
    assert files_after <= files
    assert memory_after - memory <= 16  # a framebuffer of each call would be 60 MiB, its mesh 100 MiB


def test_other_plotters_are_neither_needed_nor_disturbed():
    expected = vtk_shade(cloud(), [SUN.vtk()], SHINY, VIEWER)
    plotter = pv.Plotter(off_screen=True, window_size=(120, 90))
    plotter.add_mesh(pv.Sphere(), smooth_shading=True)
    plotter.show(auto_close=False)
    picture = plotter.screenshot(return_img=True)
    np.testing.assert_array_equal(vtk_shade(cloud(), [SUN.vtk()], SHINY, VIEWER), expected)
    plotter.render()
    np.testing.assert_array_equal(plotter.screenshot(return_img=True), picture)
    lights = list(plotter.renderer.GetLights())
    colors = vtk_shade(cloud(), lights, SHINY, plotter.camera)
    assert np.isfinite(colors).all()
    assert list(plotter.renderer.GetLights()) == lights
    plotter.close()


def test_driver_has_a_name_and_is_asked_once(monkeypatch):
    name = driver()
    assert name.count(",") >= 2
    assert any(character.isdigit() for character in name)
    made = count_open(monkeypatch)
    assert driver() == name
    assert made == []


# --- bad input --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"lights": vtkLight()}, r"lights must be a sequence of lights; .* Put a single light into a list"),
        ({"lights": ["sun"]}, r"lights must be pvphong lights, pyvista.Light or vtkLight objects; got sun"),
        ({"lights": [SpotLight(exponent=130.0)]}, r"exponent must be at most 128 in VTK; got 130\.0"),
        ({"property_or_material": 0.5}, r"property_or_material must be a Material, .*; got 0\.5"),
        (
            {"property_or_material": Material(emission=0.1)},
            r"emission must be 0 in VTK; got 0\.1.* ambient is the same",
        ),
        (
            {"property_or_material": Material(shininess=129.0)},
            r"shininess must be at most 128 in VTK; got 129\.0.*shininess=128",
        ),
        ({"property_or_material": pv.Property(interpolation="pbr")}, r"must be a Phong material; .*'pbr'"),
        ({"viewer": (0, 0, 1)}, r"viewer must be a Viewer, a pyvista\.Camera or a vtkCamera; got \(0, 0, 1\)"),
        ({"matrix": np.eye(3)}, r"matrix must be a 4x4 matrix"),
        ({"matrix": np.full((4, 4), np.nan)}, r"matrix must be a 4x4 matrix of finite numbers"),
        ({"mesh": "plane"}, r"mesh must be a pyvista\.DataSet; got str"),
        ({"mesh": pv.PolyData()}, r"mesh must be a mesh with faces, or points with normals; .* 0 points"),
        ({"mesh": pv.PolyData(np.eye(3))}, r"mesh must be a mesh with faces, or points with normals"),
    ],
)
def test_bad_input_is_named(arguments, message):
    good = {"mesh": cloud(count=3), "lights": [], "property_or_material": SHINY, "viewer": VIEWER, "matrix": None}
    given = good | arguments
    matrix = given.pop("matrix")
    with pytest.raises(ValueError, match=message):
        vtk_shade(*given.values(), matrix=matrix)
