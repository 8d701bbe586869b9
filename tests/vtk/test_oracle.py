"""VTK's shader, run per vertex, against the evaluator in VTK's convention, which `tests/oracle.py` checks."""

import math
import os
import subprocess
import sys
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import pyvista as pv
from pyvista import examples
from vtkmodules.vtkRenderingCore import vtkCamera, vtkLight, vtkRenderWindow

from pvphong import GGX, DirectionalLight, LightModel, Material, PointLight, Scene, SpotLight, Viewer, as_light
from pvphong.shading.equation import vtk_tier
from pvphong.shading.evaluation import evaluate
from pvphong.vtk import oracle
from pvphong.vtk.oracle import driver, vtk_shade

SHINY = Material(ambient=(0.05, 0.1, 0.2), diffuse=(0.6, 0.5, 0.3), specular=(0.3, 0.4, 0.5), shininess=25.0)
VIEWER = Viewer(position=(3.0, -4.0, 2.5), focal_point=(0.1, 0.2, -0.1), up=(0.0, 0.2, 1.0))
SUN = DirectionalLight((-1.0, 2.0, -3.0), diffuse=(1.0, 0.9, 0.8))
BULB = PointLight((2.0, 1.5, 2.5), diffuse=(0.9, 0.7, 0.5))
SPOT = SpotLight((0.5, -3.0, 3.0), (-0.5, 3.0, -3.0), 24.0, 7.0, (0.8, 0.0, 0.02))
HEADLIGHT = DirectionalLight(frame="headlight", diffuse=(0.9, 1.0, 0.8))
RIDER = PointLight((1.0, 2.0, -3.0), frame="camera")
UNCLAMPED = replace(LightModel.vtk(two_sided=False), clamp=False)

SHEAR = np.array([[1.0, 0.8, 0.0, 0.5], [0.0, 1.2, -0.4, 0.0], [0.3, 0.0, 0.7, -0.2], [0.0, 0.0, 0.0, 1.0]])
BOUND = 16.0 * SHINY.shininess * 2.0**-24 + 1e-6


def cloud(seed=1, count=4000):
    """Return points in a box of size 2 with unit normals in all directions."""
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(count, 3))
    mesh = pv.PolyData(rng.uniform(-1.0, 1.0, (count, 3)))
    mesh.point_data.active_normals = normals / np.linalg.norm(normals, axis=1)[:, None]
    return mesh


def shaded(lights, *, mesh=None, material=SHINY, viewer=VIEWER, matrix=None):
    return vtk_shade(cloud() if mesh is None else mesh, lights, material, viewer, matrix=matrix)


# --- against the evaluator; `validate`'s tests cover scenes, frames and matrices of all kinds ---


def with_values(thing, **values):
    """Set values of a VTK light or camera by name, such as `ConeAngle` with `SetConeAngle`."""
    for name, value in values.items():
        getattr(thing, f"Set{name}")(value)
    return thing


TURN = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
TURNED = pv.vtkmatrix_from_array(np.vstack([np.column_stack([TURN, (0.3, -0.2, 0.5)]), (0, 0, 0, 1)]))
CAMERA_LIGHT = pv.Light(light_type="camera light", position=(0.5, 0.4, 1.2), focal_point=(0.0, 0.1, 0.0))


@pytest.mark.parametrize(
    ("lights", "viewer"),
    [
        ([with_values(CAMERA_LIGHT, Positional=True, ConeAngle=90.0)], VIEWER),
        ([with_values(SPOT.to_pyvista(), TransformMatrix=TURNED), SUN.to_pyvista()], VIEWER),
        ([DirectionalLight((math.cos(k), math.sin(k), -0.2 * k), intensity=0.1) for k in range(12)], VIEWER),
        ([SUN, BULB], replace(VIEWER, focal_point=(6.0, -8.0, 5.0), up=(0.0, 0.0, 1.0))),
    ],
    ids=["VTK's camera light", "VTK's, with a matrix", "more than eight", "mesh behind the eye"],
)
def test_any_lights_and_any_view(lights, viewer):
    mesh, scene = cloud(), Scene([as_light(light, viewer) for light in lights], viewer, UNCLAMPED)
    colors = shaded(lights, mesh=mesh, viewer=viewer)
    assert (colors.dtype, colors.shape) == (np.float32, (mesh.n_points, 3))
    given = mesh.points, mesh.point_data.active_normals, scene, SHINY
    assert np.abs(colors - evaluate(*given, precision="float64", backend="numpy").rgb).max() <= BOUND


KINDS = (SUN, HEADLIGHT, DirectionalLight(frame="camera"), BULB)


@pytest.mark.parametrize("on", list(product((True, False), repeat=2)))
@pytest.mark.parametrize("kinds", list(product(KINDS, repeat=2)))
def test_the_tier_is_the_one_that_vtk_draws(kinds, on):
    """Detected at a vertex that faces away, with a diffuse of 1e6: tier 1 has a floor, unlit has full diffuse."""
    mesh = pv.PolyData([[0.0, 0.0, 0.0]])
    mesh.point_data.active_normals = [[0.0, 0.0, -1.0]]
    lights = [replace(light, on=shines, diffuse=1.0) for light, shines in zip(kinds, on, strict=True)]
    color = shaded(lights, mesh=mesh, material=Material(ambient=0.0, diffuse=1e6), viewer=Viewer((0.0, 0.0, 5.0)))
    assert round(float(color[0, 0]), 3) == {0: 1e6, 1: 1.0}.get(vtk_tier(lights), 0.0)


# --- against itself ---------------------------------------------------------------------------------------------

TINTED = with_values(BULB.to_pyvista(), SpecularColor=(0.0, 0.5, 0.1), AmbientColor=(0.9, 0.5, 0.1))
CAMERA = with_values(vtkCamera(), Position=VIEWER.position, FocalPoint=VIEWER.focal_point, ViewUp=VIEWER.up)
CONES = [with_values(BULB.to_pyvista(), ConeAngle=angle, Exponent=50.0) for angle in (90.0, 180.0)]
BEAM = examples.load_hexbeam()


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({"lights": [BULB]}, {"lights": [TINTED]}),
        ({"lights": CONES[:1]}, {"lights": CONES[1:]}),
        ({"lights": [RIDER]}, {"lights": [RIDER], "viewer": CAMERA}),
        ({"lights": [BULB, SpotLight(exponent=130.0, on=False)]}, {"lights": [BULB]}),
        ({"matrix": pv.vtkmatrix_from_array(SHEAR)}, {"matrix": SHEAR.tolist()}),
        ({"mesh": BEAM}, {"mesh": BEAM.extract_surface(algorithm=None)}),
    ],
    ids=["colours of lights", "a cone of 90 degrees", "cameras", "a light that is off", "matrices", "a surface"],
)
def test_what_makes_no_difference(one, other):
    colors = shaded(**({"lights": [SUN]} | one))
    assert np.isfinite(colors).all()
    np.testing.assert_array_equal(colors, shaded(**({"lights": [SUN]} | other)))


def test_what_is_passed_in_is_not_modified():
    lights = [HEADLIGHT.to_pyvista(), SPOT.to_pyvista(), pv.Light(light_type="camera light", position=(0.1, 0.2, 0.3))]
    camera = pv.Camera()
    camera.position, camera.focal_point, camera.clipping_range = VIEWER.position, VIEWER.focal_point, (0.5, 7.0)
    prop, mesh, matrix = pv.Property(specular=0.3), cloud(count=50), SHEAR.copy()

    def seen():
        counts = [light.GetReferenceCount() for light in lights]
        return [str(x) for x in (*lights, camera, prop)], counts, mesh.points.tolist(), mesh.point_data.keys()

    before = seen()
    vtk_shade(mesh, lights, prop, camera, matrix=matrix)
    assert seen() == before
    np.testing.assert_array_equal(matrix, SHEAR)


def test_of_a_property_only_the_lighting_counts():
    prop = pv.Property(ambient=0.3, diffuse=0.7, specular=0.4, specular_power=25.0, opacity=0.3, point_size=7.0)
    with_values(prop, AmbientColor=(0.2, 0.4, 0.6), DiffuseColor=(0.9, 0.5, 0.1), SpecularColor=(1.0, 0.5, 0.5))
    prop.SetInterpolationToFlat()
    prop.SetRepresentationToWireframe()
    lights = [SUN, BULB]
    by_material = shaded(lights, material=Material.from_property(prop))
    np.testing.assert_allclose(shaded(lights, material=prop), by_material, atol=2e-7)
    prop.SetLighting(False)
    unlit = np.add(np.multiply(0.3, prop.GetAmbientColor()), np.multiply(0.7, prop.GetDiffuseColor()))
    np.testing.assert_allclose(shaded(lights, material=prop), np.tile(unlit, (4000, 1)), atol=1e-7)


def test_a_viewer_looking_along_its_up_is_no_matter_unless_a_light_rides_with_it():
    upright, level = (Viewer(position=(0.0, 0.0, 5.0), up=up) for up in ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)))
    first, second = (shaded([SUN, BULB], viewer=viewer) for viewer in (upright, level))
    np.testing.assert_allclose(first, second, atol=BOUND)
    with pytest.raises(ValueError, match=r"up must be a direction not parallel to the view axis"):
        shaded([RIDER], viewer=upright)


def test_odd_rows_are_nan_and_leave_the_others_alone():
    lights, mesh = [SUN, BULB], cloud(count=300)
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
    mesh, lights = cloud(count=5000), [SUN, SPOT]
    whole = shaded(lights, mesh=mesh)
    monkeypatch.setattr(oracle, "SIDE", 32)  # 1024 vertices per pass
    np.testing.assert_array_equal(shaded(lights, mesh=mesh), whole)


# --- the window -------------------------------------------------------------------------------------------------


def count_open(monkeypatch):
    """Count the windows that are created from now on."""
    made = []

    def make():
        made.append(vtkRenderWindow())
        return made[-1]

    monkeypatch.setattr(oracle, "vtkRenderWindow", make)
    return made


def test_the_window_is_closed_also_after_an_error(monkeypatch):
    made = count_open(monkeypatch)
    shaded([SUN], mesh=cloud(count=9))
    monkeypatch.setattr(oracle, "_drawn", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        shaded([SUN], mesh=cloud(count=9))
    assert len(made) == 2
    for window in made:
        assert not window.GetInitialized()
        assert window.GetRenderers().GetNumberOfItems() == 0


def test_undrawn_vertices_are_noticed(monkeypatch):
    monkeypatch.setattr(oracle, "_TO_PIXEL", "//VTK::CustomEnd::Impl\n")  # no vertex is moved to its pixel
    with pytest.raises(RuntimeError, match=r"left \d+ of 4000 vertices undrawn"):
        shaded([SUN])


def test_other_plotters_are_neither_needed_nor_disturbed():
    expected = shaded([SUN])
    plotter = pv.Plotter(off_screen=True, window_size=(120, 90))
    plotter.add_mesh(pv.Sphere(), smooth_shading=True)
    plotter.show(auto_close=False)
    picture = plotter.screenshot(return_img=True)
    np.testing.assert_array_equal(shaded([SUN]), expected)
    plotter.render()
    np.testing.assert_array_equal(plotter.screenshot(return_img=True), picture)
    lights = list(plotter.renderer.GetLights())
    assert np.isfinite(shaded(lights, viewer=plotter.camera)).all()
    assert list(plotter.renderer.GetLights()) == lights
    plotter.close()


def test_the_driver_has_a_name_and_is_asked_once_and_without_a_display_nothing_is_complained_about(monkeypatch):
    hidden = {name: value for name, value in os.environ.items() if not name.endswith("DISPLAY")}
    code = "from pvphong.vtk.oracle import driver; print(driver())"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=hidden)
    assert (run.stdout.strip(), run.stderr) == (driver(), "")
    assert driver().count(",") >= 2
    made = count_open(monkeypatch)
    driver()
    assert made == []


COATED = pv.Property(interpolation="pbr")
COATED.SetCoatStrength(0.5)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"lights": vtkLight()}, r"lights must be a sequence of lights; .* Put a single light into a list"),
        ({"lights": ["sun"]}, r"lights must be pvphong lights, pyvista.Light or vtkLight objects; got sun"),
        ({"lights": [SpotLight(exponent=130.0)]}, r"exponent must be at most 128 in VTK; got 130\.0"),
        ({"material": 0.5}, r"property_or_material must be a Material, .*; got 0\.5"),
        ({"material": Material(emission=0.1)}, r"emission must be 0 in VTK; got 0\.1.* add it to ambient"),
        ({"material": Material(shininess=129.0)}, r"shininess must be at most 128 in VTK; got 129\.0.*shininess=128"),
        ({"material": COATED}, r"prop\.coat_strength must be 0\.0 with pbr=True; got 0\.5"),
        ({"material": Material(reflectance=GGX(0.5))}, r"reflectance must be None or PBR in VTK; got GGX"),
        ({"viewer": (0, 0, 1)}, r"viewer must be a Viewer, a pyvista\.Camera or a vtkCamera; got \(0, 0, 1\)"),
        ({"matrix": np.full((4, 4), np.nan)}, r"matrix must be a 4x4 matrix of finite numbers"),
        ({"mesh": pv.PolyData(np.eye(3))}, r"mesh must be a mesh with faces, or points with normals"),
    ],
)
def test_bad_input_is_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        shaded(**({"lights": [], "mesh": cloud(count=3)} | arguments))
