"""VTK's shader, run per vertex, against a float64 formula of it that is written here and nowhere else."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from pyvista import examples
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkCommonTransforms import vtkTransform
from vtkmodules.vtkRenderingCore import vtkCamera, vtkLight, vtkRenderWindow

from pvphong.meshes.surfaces import vertex_normals
from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.optics.material import Material
from pvphong.optics.reflectances import GGX
from pvphong.scene.viewer import Viewer
from pvphong.vtk import oracle as _vertex_bench
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


def shaded(lights: list, *, mesh: pv.PolyData | None = None, material=SHINY, viewer=VIEWER, matrix=None) -> np.ndarray:
    return vtk_shade(cloud() if mesh is None else mesh, lights, material, viewer, matrix=matrix)


def largest_error(lamps: list[Lamp], lights: list | None = None, *, mesh: pv.PolyData | None = None, **given) -> float:
    """Of VTK's colours against the formula's for the same lamps, or for lamps that stand where the lights do."""
    mesh = cloud() if mesh is None else mesh
    colors = shaded([lamp.vtk() for lamp in lamps] if lights is None else lights, mesh=mesh, **given)
    assert colors.dtype == np.float32
    assert colors.shape == (mesh.n_points, 3)
    given = {"material": SHINY, "viewer": VIEWER} | given
    return float(np.abs(colors - formula(mesh.points, vertex_normals_of(mesh), lamps, **given)).max())


def vertex_normals_of(mesh: pv.PolyData) -> np.ndarray:
    given = mesh.point_data.active_normals
    return vertex_normals(mesh) if given is None else np.asarray(given)


def in_world(point: tuple[float, float, float]) -> tuple[float, ...]:
    """A point of VIEWER's eye space."""
    return tuple(np.array(VIEWER.position) + eye_axes(VIEWER).T @ point)


# --- against the formula ----------------------------------------------------------------------------------------

MIXED = [SUN, HEADLIGHT, BULB, SPOT, DIM_BULB]
LIGHTING = {
    "one headlight (tier 1)": [HEADLIGHT],
    "headlight and a black light": [HEADLIGHT, Lamp(color=(0.0, 0.0, 0.0))],
    "one directional": [SUN],
    "two directional": [SUN, SKY],
    "headlight and directional": [HEADLIGHT, SKY],
    "point": [BULB],
    "attenuated point": [DIM_BULB],
    "spot": [SPOT],
    "positional headlight": [LAMP_ON_HEAD],
    "mixed": MIXED,
    "more than eight": [Lamp((0.1, 0.1, 0.05), position=(math.cos(k), math.sin(k), 0.2 * k)) for k in range(12)],
    "colours that 8 bits do not hold": [Lamp(color=(0.501, 0.3337, 1.75))],  # pv.Light.copy refuses 1.75
}


@pytest.mark.parametrize("matrix", [None, SHEAR, MIRROR], ids=["world", "sheared", "mirrored"])
@pytest.mark.parametrize("lamps", LIGHTING.values(), ids=LIGHTING.keys())
def test_agrees_with_the_formula_of_the_tiers(lamps, matrix):
    assert largest_error(lamps, matrix=matrix) <= bound(SHINY)


@pytest.mark.parametrize("power", [0.0, 0.5, 1.0, 8.0, 128.0])
def test_agrees_at_every_power(power):
    material = Material(ambient=0.1, diffuse=0.5, specular=0.4, shininess=power)
    # Below power 1 a float32 step of a small cosine moves its power by more: at r·v = 1e-4 by 4e-6 for 0.5.
    worse = 1.0 if power >= 1.0 or not power else 20.0
    assert largest_error([SUN, BULB], material=material) <= bound(material) * worse


@pytest.mark.parametrize(
    ("lamps", "viewer"),
    [
        *((lamps, replace(VIEWER, parallel=True)) for lamps in (MIXED, [SUN, SKY], [HEADLIGHT])),
        ([SUN, BULB], replace(VIEWER, focal_point=(6.0, -8.0, 5.0), up=(0.0, 0.0, 1.0))),
    ],
    ids=["parallel, mixed", "parallel, two", "parallel, tier 1", "mesh behind the eye"],
)
def test_parallel_projection_keeps_a_local_viewer_and_nothing_is_out_of_view(lamps, viewer):
    assert largest_error(lamps, viewer=viewer) <= bound(SHINY)


@pytest.mark.parametrize("count", [1, 1_000_000])
def test_any_number_of_vertices(count):
    assert largest_error([SUN], mesh=cloud(seed=7, count=count)) <= bound(SHINY)


@pytest.mark.parametrize(
    ("load", "viewer"),
    [
        (examples.load_airplane, Viewer((2500.0, -900.0, 1200.0), (900.0, 650.0, 150.0), (0, 0, 1))),
        (examples.load_ant, Viewer((40.0, 60.0, 30.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))),
        (examples.load_nut, Viewer((40.0, 30.0, 50.0), (0.0, 0.0, 0.0))),
    ],
    ids=["airplane", "ant", "nut"],
)
def test_real_meshes_with_computed_normals(load, viewer):
    mesh = load()
    mesh.clear_data()
    size, center = mesh.length, np.array(mesh.center)
    above = tuple(center + size * np.array([0.3, 0.4, 0.9]))
    spot = replace(SPOT, position=above, target=tuple(center), cone=25.3, attenuation=(1.0, 0.0, 0.3 / size**2))
    lamps = [Lamp(color=(0.8, 0.7, 0.6), position=(1.0, 1.0, 2.0)), spot]
    assert largest_error(lamps, mesh=mesh, viewer=viewer) <= bound(SHINY)
    assert shaded([lamp.vtk() for lamp in lamps], mesh=mesh, viewer=viewer)[:, 0].std() > 0.05


def camera_light() -> pv.Light:
    """The camera stands at (0, 0, 1) of camera-light space and looks at its origin."""
    light = pv.Light(light_type="camera light", position=(0.5, 0.4, 1.2), focal_point=(0.0, 0.1, 0.0))
    light.SetPositional(True)
    light.SetConeAngle(90.0)
    return light


def turned_spot() -> tuple[Lamp, vtkLight]:
    """By a transform matrix of the light's own."""
    transform = vtkTransform()
    transform.Translate(0.3, -0.2, 0.5)
    transform.RotateWXYZ(70.0, 1.0, 2.0, -1.0)
    light = SPOT.vtk()
    light.SetTransformMatrix(transform.GetMatrix())
    position, target = (transform.TransformPoint(x) for x in (SPOT.position, SPOT.target))
    return replace(SPOT, position=position, target=target), light


OWN = {
    SUN: DirectionalLight((-1.0, 2.0, -3.0), diffuse=(1.0, 0.9, 0.8)),
    BULB: PointLight((2.0, 1.5, 2.5), diffuse=(0.9, 0.7, 0.5)),
    SPOT: SpotLight((0.5, -3.0, 3.0), (-0.5, 3.0, -3.0), 24.0, 7.0, (0.8, 0.0, 0.02)),
    HEADLIGHT: DirectionalLight(frame="headlight", diffuse=(0.9, 1.0, 0.8)),
    Lamp(position=in_world((1.0, 2.0, -3.0)), positional=True): PointLight((1.0, 2.0, -3.0), frame="camera"),
}


@pytest.mark.parametrize(
    ("lamps", "lights"),
    [
        ([Lamp(position=in_world(VIEWER.distance * np.array([0.5, 0.4, 0.2])), positional=True)], [camera_light()]),
        ([turned_spot()[0], SUN], [turned_spot()[1], SUN.vtk()]),
        ([*OWN], [*OWN.values()]),
    ],
    ids=["camera light", "transform matrix", "pvphong's own"],
)
def test_lights_stand_where_vtk_puts_them(lamps, lights):
    assert largest_error(lamps, lights) <= bound(SHINY)


# --- without a formula ------------------------------------------------------------------------------------------


def test_without_any_light_vtk_draws_unlit_and_with_a_black_one_ambient():
    off, black = SUN.vtk(), SUN.vtk()
    off.SetSwitch(False)
    black.SetIntensity(0.0)
    unlit = np.add(SHINY.ambient, SHINY.diffuse)
    for lights, color in (([], unlit), ([off], unlit), ([black], SHINY.ambient)):
        np.testing.assert_allclose(shaded(lights), np.tile(color, (4000, 1)), atol=1e-6)


def tinted_bulb() -> vtkLight:
    light = BULB.vtk()
    light.SetSpecularColor(0.0, 0.5, 0.1)
    light.SetAmbientColor(0.9, 0.5, 0.1)
    return light


def vtk_viewer() -> vtkCamera:
    camera = vtkCamera()
    camera.SetPosition(VIEWER.position)
    camera.SetFocalPoint(VIEWER.focal_point)
    camera.SetViewUp(VIEWER.up)
    return camera


def vtk_shear() -> vtkMatrix4x4:
    matrix = vtkMatrix4x4()
    matrix.DeepCopy(SHEAR.ravel().tolist())
    return matrix


RIDING = {"lights": [PointLight(position=(1.0, 2.0, -3.0), frame="camera")]}
BEAM = examples.load_hexbeam()


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({"lights": [BULB.vtk()]}, {"lights": [tinted_bulb()]}),
        ({"lights": [replace(BULB, cone=90.0, exponent=50.0).vtk()]}, {"lights": [replace(BULB, cone=180.0).vtk()]}),
        (RIDING, {**RIDING, "viewer": vtk_viewer()}),
        ({"matrix": vtk_shear()}, {"matrix": SHEAR.tolist()}),
        ({"mesh": BEAM}, {"mesh": BEAM.extract_surface(algorithm=None)}),
    ],
    ids=["ambient and specular of lights", "a cone of 90 degrees", "cameras", "matrices", "a volume's surface"],
)
def test_what_makes_no_difference(one, other):
    colors = shaded(**({"lights": [SUN.vtk()]} | one))
    assert np.isfinite(colors).all()
    np.testing.assert_array_equal(colors, shaded(**({"lights": [SUN.vtk()]} | other)))


def test_what_is_passed_in_is_not_modified():
    lights = [HEADLIGHT.vtk(), SPOT.vtk(), pv.Light(light_type="camera light", position=(0.1, 0.2, 0.3))]
    camera = pv.Camera()
    camera.position, camera.focal_point, camera.clipping_range = VIEWER.position, VIEWER.focal_point, (0.5, 7.0)
    prop, mesh, matrix = pv.Property(specular=0.3), cloud(count=50), SHEAR.copy()

    def seen() -> tuple:
        counts = [light.GetReferenceCount() for light in lights]
        return [str(x) for x in (*lights, camera, prop)], counts, mesh.points.tolist(), mesh.point_data.keys()

    before = seen()
    vtk_shade(mesh, lights, prop, camera, matrix=matrix)
    assert seen() == before
    np.testing.assert_array_equal(matrix, SHEAR)


def test_of_a_property_only_the_lighting_counts():
    prop = pv.Property(ambient=0.3, diffuse=0.7, specular=0.4, specular_power=25.0)
    prop.SetAmbientColor(0.2, 0.4, 0.6)
    prop.SetDiffuseColor(0.9, 0.5, 0.1)
    prop.SetSpecularColor(1.0, 0.5, 0.5)
    prop.SetOpacity(0.3)  # and other things that are no lighting
    prop.SetInterpolationToFlat()
    prop.SetPointSize(7.0)
    prop.SetRepresentationToWireframe()
    lights = [SUN.vtk(), BULB.vtk()]
    by_material = shaded(lights, material=Material.from_property(prop))
    np.testing.assert_allclose(shaded(lights, material=prop), by_material, atol=2e-7)
    prop.SetLighting(False)
    unlit = np.add(np.multiply(0.3, prop.GetAmbientColor()), np.multiply(0.7, prop.GetDiffuseColor()))
    np.testing.assert_allclose(shaded(lights, material=prop), np.tile(unlit, (4000, 1)), atol=1e-7)


def test_a_viewer_looking_along_its_up_is_no_matter_unless_a_light_rides_with_it():
    upright, level = (Viewer(position=(0.0, 0.0, 5.0), up=up) for up in ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)))
    first, second = (shaded([SUN.vtk(), BULB.vtk()], viewer=viewer) for viewer in (upright, level))
    np.testing.assert_allclose(first, second, atol=bound(SHINY))
    with pytest.raises(ValueError, match=r"up must be off the view axis"):
        shaded(viewer=upright, **RIDING)


def test_odd_rows_are_nan_and_leave_the_others_alone():
    lights, mesh = [SUN.vtk(), BULB.vtk()], cloud(count=300)
    expected = shaded(lights, mesh=mesh)
    normals, points = np.array(mesh.point_data.active_normals), np.array(mesh.points)
    normals[3], normals[50, 1] = 0.0, np.nan
    points[120, 2], points[299, 0] = np.inf, 1e60  # more than float32 holds
    mesh.points, mesh.point_data.active_normals = points, normals
    colors, odd = shaded(lights, mesh=mesh), [3, 50, 120, 299]
    assert np.isnan(colors[odd]).all()
    np.testing.assert_array_equal(np.delete(colors, odd, axis=0), np.delete(expected, odd, axis=0))
    mesh.point_data.active_normals = np.zeros((300, 3))
    assert np.isnan(shaded(lights, mesh=mesh)).all()


def test_vertices_over_several_passes_are_the_same(monkeypatch):
    mesh, lights = cloud(count=5000), [SUN.vtk(), SPOT.vtk()]
    whole = shaded(lights, mesh=mesh)
    monkeypatch.setattr(_vertex_bench, "SIDE", 32)  # 1024 vertices a pass
    np.testing.assert_array_equal(shaded(lights, mesh=mesh), whole)


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
    shaded([SUN.vtk()], mesh=cloud(count=9))
    monkeypatch.setattr(_vertex_bench, "_drawn", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        shaded([SUN.vtk()], mesh=cloud(count=9))
    assert len(made) == 2
    for window in made:
        assert not window.GetInitialized()
        assert window.GetRenderers().GetNumberOfItems() == 0


def test_undrawn_vertices_are_noticed(monkeypatch):
    monkeypatch.setattr(_vertex_bench, "_TO_PIXEL", "//VTK::CustomEnd::Impl\n")  # all stay where they are
    with pytest.raises(RuntimeError, match=r"left \d+ of 4000 vertices undrawn"):
        shaded([SUN.vtk()])


def test_no_display_is_nothing_to_complain_about():
    hidden = {name: value for name, value in os.environ.items() if not name.endswith("DISPLAY")}
    code = "from pvphong.vtk.oracle import driver; print(driver())"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=hidden)
    assert run.stdout.strip() == driver()
    assert run.stderr == ""


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="counts resources where /proc is")
def test_calls_over_and_over_leave_nothing_behind():
    mesh, lights = cloud(count=20_000), [SUN.vtk()]
    found = []
    for count in (5, 12, 12, 12, 12):
        for _ in range(count):
            shaded(lights, mesh=mesh)
        found.append(resources())
    files, memory = np.diff(found, axis=0).min(axis=0)  # a leak is in every round
    assert files <= 0
    assert memory <= 2  # a framebuffer of each call would be 15 MiB, its mesh 25 MiB


def test_other_plotters_are_neither_needed_nor_disturbed():
    expected = shaded([SUN.vtk()])
    plotter = pv.Plotter(off_screen=True, window_size=(120, 90))
    plotter.add_mesh(pv.Sphere(), smooth_shading=True)
    plotter.show(auto_close=False)
    picture = plotter.screenshot(return_img=True)
    np.testing.assert_array_equal(shaded([SUN.vtk()]), expected)
    plotter.render()
    np.testing.assert_array_equal(plotter.screenshot(return_img=True), picture)
    lights = list(plotter.renderer.GetLights())
    assert np.isfinite(shaded(lights, viewer=plotter.camera)).all()
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


COATED = pv.Property(interpolation="pbr")
COATED.SetCoatStrength(0.5)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"lights": vtkLight()}, r"lights must be a sequence of lights; .* Put a single light into a list"),
        ({"lights": ["sun"]}, r"lights must be pvphong lights, pyvista.Light or vtkLight objects; got sun"),
        ({"lights": [SpotLight(exponent=130.0)]}, r"exponent must be at most 128 in VTK; got 130\.0"),
        ({"material": 0.5}, r"property_or_material must be a Material, .*; got 0\.5"),
        ({"material": Material(emission=0.1)}, r"emission must be 0 in VTK; got 0\.1.* ambient is the same"),
        ({"material": Material(shininess=129.0)}, r"shininess must be at most 128 in VTK; got 129\.0.*shininess=128"),
        ({"material": COATED}, r"prop\.coat_strength must be 0\.0 with pbr=True; got 0\.5"),
        ({"material": Material(reflectance=GGX(0.5))}, r"reflectance must be None or PBR in VTK; got GGX"),
        ({"viewer": (0, 0, 1)}, r"viewer must be a Viewer, a pyvista\.Camera or a vtkCamera; got \(0, 0, 1\)"),
        ({"matrix": np.eye(3)}, r"matrix must be a 4x4 matrix"),
        ({"matrix": np.full((4, 4), np.nan)}, r"matrix must be a 4x4 matrix of finite numbers"),
        ({"mesh": "plane"}, r"mesh must be a pyvista\.DataSet; got str"),
        ({"mesh": pv.PolyData()}, r"mesh must be a mesh with faces, or points with normals; .* 0 points"),
        ({"mesh": pv.PolyData(np.eye(3))}, r"mesh must be a mesh with faces, or points with normals"),
    ],
)
def test_bad_input_is_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        shaded(**({"lights": [], "mesh": cloud(count=3)} | arguments))
