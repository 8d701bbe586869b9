"""The standing comparison with VTK's own shader, and proof that it can fail."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
import pytest
import pyvista as pv
from pyvista import examples

from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.optics.material import Material
from pvphong.scene.scene import LightModel, Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading import kernel
from pvphong.shading.evaluation import evaluate
from pvphong.studies.validate import validation
from pvphong.studies.validate.validation import validate
from pvphong.vtk.obstacles import InexpressibleError

# --- scenes around a mesh: everything in units of the mesh's size, from its middle --------------------------------

MESHES: dict[str, Callable[[], pv.DataSet]] = {
    "airplane": examples.load_airplane,
    "ant": examples.load_ant,
    "nut": examples.load_nut,
    "hexbeam": examples.load_hexbeam,
}
MATERIALS = {
    "matte": Material(ambient=0.2, diffuse=(0.9, 0.5, 0.3)),
    "satin": Material(ambient=(0.1, 0.0, 0.2), diffuse=0.5, specular=(0.4, 0.3, 0.2), shininess=3.0, emission=0.05),
    "gold": Material.named("gold"),
    "mirror": Material(ambient=0.0, diffuse=0.2, specular=0.8, shininess=128.0),
}
LINEAR = {
    "identity": np.eye(3),
    "rigid": np.array([[2.0, -2.0, 1.0], [1.0, 2.0, 2.0], [-2.0, -1.0, 2.0]]) / 3.0,
    "non-uniform": np.diag([0.5, 1.5, 3.0]),
    "shear": np.array([[1.0, 0.9, 0.0], [0.0, 1.0, 0.0], [-0.4, 0.3, 1.0]]),
    "mirror": np.array([[1.0, 0.0, 0.0], [0.2, -1.3, 0.0], [0.0, 0.0, 0.7]]),
}
LIGHTS = {
    "directional": lambda _size, **common: DirectionalLight(direction=(-1.0, 0.5, -1.2), **common),
    "point": lambda size, **common: PointLight(position=(0.9 * size, -0.8 * size, 0.9 * size), **common),
    "attenuated": lambda size, **common: PointLight(
        position=(-size, -size, 0.4 * size), attenuation=(0.3, 0.2 / size, 0.4 / size**2), **common
    ),
    "spot": lambda size, **common: SpotLight(
        position=(0.5 * size, -0.6 * size, 1.1 * size),
        direction=(-0.5, 0.6, -1.0),
        cone_angle=23.0,
        exponent=6.0,
        **common,
    ),
}
IN_EYE_SPACE = {
    "directional": DirectionalLight(direction=(0.4, -0.7, -1.0)),
    "point": PointLight(position=(0.5, 0.8, -0.4)),
    "attenuated": PointLight(position=(-1.0, 0.3, 0.1), attenuation=(0.2, 0.1, 0.3)),
    "spot": SpotLight(position=(0.4, 0.3, 0.0), direction=(-0.2, -0.15, -1.0), cone_angle=14.0, exponent=3.0),
}


@cache
def mesh_named(name: str) -> pv.PolyData:
    mesh = MESHES[name]()
    mesh.clear_data()  # normals are computed
    return mesh


def in_middle(mesh: pv.DataSet, light: Any) -> Any:
    """A light placed around the origin, moved along to around the mesh."""
    if not hasattr(light, "position") or light.frame != "world":
        return light
    return replace(light, position=tuple(np.add(light.position, mesh.center).tolist()))


def light_for(mesh: pv.DataSet, kind: str, frame: str, **common: Any) -> Any:
    size = mesh.length
    if frame != "camera":
        return in_middle(mesh, LIGHTS[kind](size, frame=frame, **common))
    light = IN_EYE_SPACE[kind]
    if hasattr(light, "position"):
        light = replace(light, position=tuple((np.array(light.position) * size).tolist()))
        constant, linear, quadratic = light.attenuation
        light = replace(light, attenuation=(constant, linear / size, quadratic / size**2))
    return replace(light, frame=frame, **common)


def viewer_for(mesh: pv.DataSet, *, parallel: bool = False) -> Viewer:
    eye = np.array(mesh.center) + mesh.length * np.array([0.9, -0.7, 0.8])
    return Viewer(position=eye.tolist(), focal_point=mesh.center, up=(0.1, 0.2, 1.0), parallel=parallel)


def around_middle(mesh: pv.DataSet, linear: np.ndarray) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3] = linear
    matrix[:3, 3] = np.array(mesh.center) - linear @ np.array(mesh.center) + 0.05 * mesh.length
    return matrix


def assert_equals_vtk(comparison: Any, tier: int | None = None) -> None:
    assert comparison.passed, str(comparison)
    assert comparison.n >= 0.9 * len(comparison.pvphong), str(comparison)
    assert np.nanstd(comparison.vtk) > 0.01  # there is something to see
    if tier is not None:
        assert comparison.tier == tier


# --- the standing comparison --------------------------------------------------------------------------------------

CASES = list(itertools.product(LIGHTS, ("world", "camera", "headlight"), LINEAR, (False, True), ("standard", "vtk")))


@pytest.mark.parametrize(
    ("number", "kind", "frame", "matrix", "parallel", "convention"),
    [(number, *case) for number, case in enumerate(CASES)],
    ids=["-".join([*case[:3], "parallel" if case[3] else "perspective", case[4]]) for case in CASES],
)
def test_one_light_of_every_kind_frame_matrix_and_projection(number, kind, frame, matrix, parallel, convention):
    """Meshes and materials take turns."""
    mesh = mesh_named(list(MESHES)[number % len(MESHES)])
    material = list(MATERIALS.values())[number // 2 % len(MATERIALS)]
    if convention == "standard" and parallel and kind != "directional":
        material = replace(material, specular=0.0)  # VTK cannot draw its highlights
    model = LightModel(ambient=(0.3, 0.2, 0.1)) if convention == "standard" else LightModel.vtk(two_sided=False)
    light = light_for(mesh, kind, frame, diffuse=(1.0, 0.8, 0.6), intensity=0.9)
    scene = Scene([light], viewer_for(mesh, parallel=parallel), model)
    tier = 3 if kind != "directional" else 1 if frame == "headlight" and convention == "vtk" else 2
    comparison = validate(mesh, scene, material, matrix=around_middle(mesh, LINEAR[matrix]))
    assert_equals_vtk(comparison, tier)


@pytest.mark.parametrize("convention", ["standard", "vtk"])
@pytest.mark.parametrize("matrix", LINEAR)
@pytest.mark.parametrize(("mesh", "material"), [("airplane", "gold"), ("ant", "mirror"), ("nut", "satin")])
def test_lights_of_all_kinds_together(mesh, material, matrix, convention):
    mesh = mesh_named(mesh)
    model = LightModel(two_sided=True) if convention == "standard" else LightModel.vtk(two_sided=False)
    lights = [
        light_for(mesh, kind, frame, intensity=0.3, diffuse=(1.0, 0.9, 0.5))
        for kind, frame in itertools.product(LIGHTS, ("world", "camera"))
    ]
    scene = Scene([*lights, DirectionalLight(frame="headlight", intensity=0.2)], viewer_for(mesh), model)
    transform = around_middle(mesh, LINEAR[matrix])
    assert_equals_vtk(validate(mesh, scene, MATERIALS[material], matrix=transform), tier=3)


def random_scene(seed: int) -> tuple[pv.PolyData, Scene, Material, np.ndarray | None]:
    """A cloud with normals in all directions, and anything that VTK can draw around it."""
    rng = np.random.default_rng(seed)
    convention = ("standard", "vtk")[seed % 2]
    common = {"ambient": tuple(rng.uniform(0.0, 1.0, 3)), "two_sided": bool(rng.integers(2))}
    model = LightModel(**common) if convention == "standard" else LightModel.vtk(two_sided=common["two_sided"])
    lights = [random_light(rng) for _ in range(rng.integers(1, 5))]
    parallel = bool(rng.integers(4) == 0)
    material = Material(
        ambient=tuple(rng.uniform(0.0, 0.3, 3)),
        diffuse=tuple(rng.uniform(0.0, 1.0, 3)),
        specular=0.0 if rng.integers(4) == 0 else tuple(rng.uniform(0.0, 1.0, 3)),
        shininess=float(rng.choice([0.0, rng.uniform(0.1, 1.0), rng.uniform(1.0, 128.0), 128.0])),
        emission=float(rng.choice([0.0, 0.1])),
    )
    if convention == "standard" and any(not isinstance(light, DirectionalLight) for light in lights):
        parallel = parallel and material.specular == 0.0
    viewer = Viewer(
        position=(rng.normal(size=3) * 10.0 ** rng.uniform(0.0, 1.0)).tolist(),
        focal_point=(rng.normal(size=3) * 0.2).tolist(),
        up=rng.normal(size=3).tolist(),
        parallel=parallel,
    )
    mesh = pv.PolyData(rng.uniform(-1.0, 1.0, (300, 3)).astype(np.float32))
    mesh.point_data.active_normals = (rng.normal(size=(300, 3)) * 10.0 ** rng.uniform(-3.0, 3.0)).astype(np.float32)
    keep_front = convention == "vtk" and model.two_sided
    return mesh, Scene(lights, viewer, model), material, random_matrix(rng, mirrors=not keep_front)


def random_light(rng: np.random.Generator) -> Any:
    frame = str(rng.choice(["world", "camera", "headlight"]))
    common: dict[str, Any] = {
        "frame": frame,
        "diffuse": tuple(rng.uniform(0.0, 1.0, 3)),
        "intensity": float(rng.uniform(0.2, 1.5)),
        "on": bool(rng.integers(8)),
    }
    direction = tuple(rng.normal(size=3))
    if rng.integers(3) == 0:
        return DirectionalLight(direction=direction, **common)
    position = rng.normal(size=3) * 2.0
    mixed = tuple(rng.uniform(0.1, 1.0, 3))
    common |= {"position": tuple(position), "attenuation": (1, 0, 0) if rng.integers(2) else mixed}
    if rng.integers(2):
        return PointLight(**common)
    if frame == "world":
        direction = tuple(rng.normal(size=3) * 0.3 - position)
    cone_angle = float(rng.choice([30.0, 90.0, rng.uniform(3.0, 90.0)]))
    exponent = float(rng.choice([0.0, rng.uniform(0.0, 4.0), rng.uniform(0.0, 128.0)]))
    return SpotLight(direction=direction, cone_angle=cone_angle, exponent=exponent, **common)


def random_matrix(rng: np.random.Generator, *, mirrors: bool) -> np.ndarray | None:
    kind = rng.integers(5 if mirrors else 4)
    if kind == 0:
        return None
    matrix = np.eye(4)
    linear, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    linear *= np.sign(np.linalg.det(linear))
    if kind >= 2:
        linear = linear @ np.diag(10.0 ** rng.uniform(-0.4, 0.4, 3))
    if kind == 3:
        linear = linear @ (np.eye(3) + np.triu(rng.normal(size=(3, 3)), 1))
    matrix[:3, :3] = linear * (-1.0 if kind == 4 else 1.0)
    matrix[:3, 3] = rng.normal(size=3) * 0.3
    return matrix


RANDOM = 200


@pytest.mark.parametrize("block", range(10))
def test_random_scenes(block, monkeypatch):
    """Through the readable evaluator, and through the compiled one where it is installed."""
    compared = 0
    for seed in range(block * RANDOM // 10, (block + 1) * RANDOM // 10):
        mesh, scene, material, matrix = random_scene(seed)
        comparison = validate(mesh, scene, material, matrix=matrix)
        assert comparison.passed, f"seed {seed}\n{comparison}"
        compared += comparison.n
        if kernel.is_available():
            with monkeypatch.context() as patch:
                patch.setattr(validation, "vtk_shade", lambda *_, drawn=comparison.vtk, **__: drawn)
                patch.setattr(validation, "evaluate", partial(evaluate, backend="numba"))
                compiled = validate(mesh, scene, material, matrix=matrix)
            assert compiled.passed, f"seed {seed}\n{compiled}"
    assert compared > 0.9 * 300 * RANDOM / 10


# --- it can fail --------------------------------------------------------------------------------------------------

SUN = DirectionalLight(direction=(-1.0, 0.5, -1.2), intensity=0.8)
HEADLIGHT = DirectionalLight(frame="headlight")
SHEAR = np.eye(4) + np.diag([0.9, 0.0, 0.0], 1)
PLASTIC = Material(ambient=0.1, diffuse=(0.3, 0.4, 0.7), specular=0.4, shininess=20.0)
EYE = Viewer(position=(1.5, -1.2, 1.8), up=(0.0, 0.0, 1.0))
BALL = pv.Sphere()
LAMP = PointLight(position=(0.8, -0.7, 1.0), attenuation=(0.2, 0.3, 0.4))
SPOT = SpotLight(position=(0.7, -0.5, 1.1), direction=(-0.7, 0.5, -1.1), cone_angle=15.0, exponent=4.0)

Broken = Callable[..., dict[str, Any]]


def wrong_sign(normals: np.ndarray, **_: Any) -> dict[str, Any]:
    return {"normals": -normals}


def float16_normals(normals: np.ndarray, **_: Any) -> dict[str, Any]:
    return {"normals": normals.astype(np.float16).astype(np.float32)}


def inverse_transpose_forgotten(
    points: np.ndarray, normals: np.ndarray, matrix: np.ndarray, **_: Any
) -> dict[str, Any]:
    linear = matrix[:3, :3]
    return {"points": points @ linear.T + matrix[:3, 3], "normals": normals @ linear.T, "matrix": None}


def wrong_tier(scene: Scene, **_: Any) -> dict[str, Any]:
    return {"scene": replace(scene, lights=[*scene.lights, DirectionalLight(diffuse=0.0)])}


def lights_changed(**fields: Any) -> Broken:
    def change(scene: Scene, **_: Any) -> dict[str, Any]:
        return {"scene": replace(scene, lights=[replace(light, **fields) for light in scene.lights])}

    return change


def model_changed(**fields: Any) -> Broken:
    def change(scene: Scene, **_: Any) -> dict[str, Any]:
        return {"scene": replace(scene, light_model=replace(scene.light_model, **fields))}

    return change


def material_changed(**fields: Any) -> Broken:
    def change(material: Material, **_: Any) -> dict[str, Any]:
        return {"material": replace(material, **fields)}

    return change


def viewer_moved(scene: Scene, **_: Any) -> dict[str, Any]:
    return {"scene": replace(scene, viewer=replace(scene.viewer, position=(1.5, -1.2, 1.8004)))}


STANDARD, VTK = LightModel(), LightModel.vtk(two_sided=False)
FAULTS = {
    "wrong sign": (wrong_sign, [SUN], STANDARD, None),
    "float16 normals": (float16_normals, [SUN], STANDARD, None),
    "float16 normals by a lamp": (float16_normals, [LAMP], VTK, None),
    "forgotten inverse-transpose": (inverse_transpose_forgotten, [SUN], STANDARD, SHEAR),
    "forgotten inverse-transpose, two-sided": (inverse_transpose_forgotten, [SUN], LightModel(two_sided=True), SHEAR),
    "wrong tier": (wrong_tier, [HEADLIGHT], VTK, None),
    "attenuation forgotten": (lights_changed(attenuation=(1, 0, 0)), [LAMP], STANDARD, None),
    "full cone for half": (lights_changed(cone_angle=7.5), [SPOT], STANDARD, None),
    "exponent forgotten": (lights_changed(exponent=0.0), [SPOT], STANDARD, None),
    "camera frame forgotten": (lights_changed(frame="world"), [replace(SUN, frame="camera")], STANDARD, None),
    "eye a little off": (viewer_moved, [SUN], STANDARD, None),
    "infinite viewer": (model_changed(local_viewer=False), [SUN], STANDARD, None),
    "Blinn-Phong for Phong": (model_changed(reflection="blinn-phong"), [SUN], STANDARD, None),
    "two-sided for one-sided": (model_changed(two_sided=True), [SUN], STANDARD, None),
    "ambient light forgotten": (model_changed(ambient=1.0), [SUN], STANDARD, None),
    "shininess off by 0.1 %": (material_changed(shininess=20.02), [SUN], STANDARD, None),
}


@pytest.mark.parametrize(("fault", "lights", "model", "matrix"), FAULTS.values(), ids=FAULTS.keys())
def test_a_faulty_evaluator_fails(monkeypatch, fault, lights, model, matrix):
    scene = Scene(lights, EYE, model)
    assert validate(BALL, scene, PLASTIC, matrix=matrix).passed

    def faulty(points: Any, normals: Any, scene: Any, material: Any, *, matrix: Any) -> Any:
        given = {"points": points, "normals": normals, "scene": scene, "material": material, "matrix": matrix}
        return evaluate(**(given | fault(**given)))

    monkeypatch.setattr(validation, "evaluate", faulty)
    comparison = validate(BALL, scene, PLASTIC, matrix=matrix)
    assert not comparison.passed
    assert comparison.n > 0.9 * BALL.n_points
    assert comparison.max_error > 2.0 * comparison.tolerance


def test_a_single_wrong_vertex_fails_and_is_named(monkeypatch):
    def faulty(*args: Any, **options: Any) -> Any:
        shading = evaluate(*args, **options)
        shading.rgb[123, 1] += 1e-3
        return shading

    monkeypatch.setattr(validation, "evaluate", faulty)
    comparison = validate(BALL, Scene([SUN], EYE), PLASTIC)
    assert not comparison.passed
    worst = comparison.worst[0]
    assert (worst.index, comparison.n) == (123, BALL.n_points)
    assert worst.error == pytest.approx(1e-3, rel=1e-2)
    np.testing.assert_allclose(worst.position, BALL.points[123], atol=1e-7)
    np.testing.assert_allclose(worst.normal, BALL.point_data.active_normals[123], atol=1e-6)
    assert worst.pvphong[1] - worst.vtk[1] == pytest.approx(1e-3, rel=1e-2)
    assert "worst: 123" in str(comparison)


def test_a_nan_of_the_evaluator_fails(monkeypatch):
    def faulty(*args: Any, **options: Any) -> Any:
        shading = evaluate(*args, **options)
        shading.rgb[7] = np.nan
        return shading

    monkeypatch.setattr(validation, "evaluate", faulty)
    assert not validate(BALL, Scene([SUN], EYE), PLASTIC).passed


# --- VTK's quirks, as pvphong's VTK convention has them -----------------------------------------------------------


def own_colors(lights: list[Any], material: Material = PLASTIC, *, least: float = 0.9, **options: Any) -> np.ndarray:
    """What pvphong gives in VTK's convention, once it has been found equal to VTK's."""
    model = LightModel.vtk(two_sided=False)
    comparison = validate(BALL, Scene(lights, replace(EYE, **options), model), material)
    assert comparison.passed, str(comparison)
    assert comparison.n > least * BALL.n_points
    return comparison.pvphong


def test_quirk_a_black_light_joins_a_headlight():
    alone, together = own_colors([HEADLIGHT]), own_colors([HEADLIGHT, replace(SUN, diffuse=0.0)])
    assert np.abs(alone - together).max() > 0.1


@pytest.mark.parametrize("lights", [[HEADLIGHT, replace(SUN, on=False)], [replace(LAMP, on=False), HEADLIGHT]])
def test_quirk_a_light_that_is_off_joins_a_headlight(lights):
    assert np.abs(own_colors([HEADLIGHT]) - own_colors(lights)).max() > 0.1


def test_quirk_a_light_that_is_off_before_a_headlight_does_not_matter():
    np.testing.assert_array_equal(own_colors([HEADLIGHT]), own_colors([replace(SUN, on=False), HEADLIGHT]))


@pytest.mark.parametrize("lights", [[], [replace(SUN, on=False)], [replace(LAMP, on=False)]])
def test_quirk_no_light_draws_unlit(lights):
    expected = np.add(PLASTIC.ambient, PLASTIC.diffuse)
    np.testing.assert_allclose(own_colors(lights), np.tile(expected, (BALL.n_points, 1)), atol=1e-6)


def test_quirk_specular_and_ambient_colors_of_lights_are_ignored():
    colored = replace(SUN, specular=(0.0, 1.0, 0.2), ambient=0.5)
    np.testing.assert_array_equal(own_colors([colored]), own_colors([SUN]))


def test_quirk_the_floor_shows_at_powers_below_1():
    faint = Material(ambient=0.0, diffuse=0.0, specular=1.0, shininess=0.1)
    colors = own_colors([SUN], faint, least=0.6)  # a step of float32 in a small cosine shows in its power
    lit = colors[:, 0] > 0.0
    assert colors[lit, 0].min() == pytest.approx(0.8 * 1e-5**0.1, abs=1e-4)  # .316 · .8: nothing is darker


def test_quirk_parallel_projection_keeps_a_local_viewer():
    np.testing.assert_array_equal(own_colors([SUN], parallel=True), own_colors([SUN]))


def test_quirk_a_cone_of_90_degrees_is_none():
    inside = SpotLight(position=(0.0, 0.0, 0.0), direction=(0.0, 0.0, 1.0), cone_angle=90.0, exponent=9.0)
    hollow = BALL.copy()
    hollow.point_data.active_normals = -hollow.point_data.active_normals
    model = LightModel.vtk(two_sided=False)
    comparison = validate(hollow, Scene([inside], EYE, model), PLASTIC)
    assert comparison.passed
    assert comparison.pvphong[:, 2].min() > 0.7  # lit behind the light too


def test_surfaces_turn_to_the_viewer_in_vtk_s_convention():
    comparison = validate(BALL, Scene([LAMP], EYE, LightModel.vtk(two_sided=True)), PLASTIC)
    assert comparison.passed
    assert any("normals turned" in conversion for conversion in comparison.conversions)


# --- the standard convention in VTK's terms -----------------------------------------------------------------------


def assert_converted(scene: Scene, phrase: str, material: Material = PLASTIC, tier: int | None = None) -> Any:
    comparison = validate(BALL, scene, material)
    assert_equals_vtk(comparison, tier)
    assert any(phrase in conversion for conversion in comparison.conversions), comparison.conversions
    return comparison


def test_ambient_light_and_emission_become_unlit_ambient():
    scene = Scene([SUN], EYE, LightModel(ambient=(0.5, 0.2, 0.9)))
    assert_converted(scene, "ambient light times")
    assert_converted(scene, "emission", replace(PLASTIC, emission=(0.1, 0.0, 0.3)))
    assert validate(BALL, replace(scene, light_model=LightModel(ambient=1.0)), PLASTIC).conversions == ()


def test_a_viewer_at_infinity_becomes_an_eye_far_away():
    far = assert_converted(Scene([SUN], EYE, LightModel(local_viewer=False)), "viewer at infinity")
    parallel = assert_converted(Scene([SUN], replace(EYE, parallel=True)), "viewer at infinity")
    np.testing.assert_array_equal(far.vtk, parallel.vtk)
    near = validate(BALL, Scene([SUN], EYE), PLASTIC)
    assert np.abs(near.vtk - far.vtk).max() > 0.03


def test_camera_lights_stay_where_they_are_when_the_eye_moves_away():
    lights = [replace(SUN, frame="camera"), HEADLIGHT]
    assert_converted(Scene(lights, EYE, LightModel(local_viewer=False)), "viewer at infinity", tier=2)


def test_a_scene_without_light_is_dark_in_the_standard_convention():
    comparison = validate(BALL, Scene([replace(SUN, on=False)], EYE), PLASTIC)
    assert comparison.passed
    assert any("draw unlit" in conversion for conversion in comparison.conversions)
    np.testing.assert_allclose(comparison.vtk, 0.2 * 0.1, atol=1e-7)


def test_a_headlight_alone_is_kept_from_vtk_s_first_tier():
    assert_converted(Scene([HEADLIGHT], EYE), "simplify highlights", tier=2)


def test_a_headlight_alone_is_blinn_phong_at_infinity_in_vtk_s_first_tier():
    scene = Scene([HEADLIGHT, replace(LAMP, on=False)], EYE, LightModel.opengl())
    assert_converted(scene, "Blinn-Phong with the viewer at infinity", tier=1)
    bright = Material(diffuse=1.0, specular=1.0, shininess=0.3)
    comparison = validate(BALL, scene, bright)
    assert comparison.passed
    assert len(comparison.left_out["VTK's floor"]) > 0.3 * BALL.n_points  # what faces away


def test_a_half_space_of_light_becomes_the_widest_cone():
    half = SpotLight(position=(0.0, 0.0, 0.0), direction=(0.1, 0.2, 1.0), cone_angle=90.0, exponent=2.0)
    hollow = BALL.copy()
    hollow.point_data.active_normals = -hollow.point_data.active_normals
    comparison = validate(hollow, Scene([half], EYE), PLASTIC)
    assert_equals_vtk(comparison)
    assert any("cones of 90°" in conversion for conversion in comparison.conversions)
    assert np.ptp(comparison.vtk[:, 2]) > 0.5


def test_two_sided_lighting_becomes_turned_normals():
    for model in (LightModel(two_sided=True), LightModel(two_sided=True, local_viewer=False)):
        comparison = validate(BALL, Scene([SUN], EYE, model), PLASTIC)
        assert_equals_vtk(comparison)
        turned = np.array([vertex.normal for vertex in comparison.worst])
        places = np.array([vertex.position for vertex in comparison.worst])
        eye = np.array(EYE.position) if model.local_viewer else 1e9 * np.array(EYE.position)
        assert ((turned * (eye - places)).sum(axis=1) > 0.0).all()


@pytest.mark.parametrize("offset", [1e3, 1e6, 1e9])
def test_a_mesh_far_from_the_origin_is_compared_around_its_middle(offset):
    """Moved as a whole, with lights and eye, in float64: pvphong shifts the origin, VTK by itself would not."""
    step = np.array([offset, -offset, 0.5 * offset])
    mesh = pv.PolyData(np.float64(BALL.points) + step, BALL.faces)
    lamp = replace(LAMP, position=tuple(LAMP.position + step))
    eye = Viewer(position=tuple(EYE.position + step), focal_point=tuple(step), up=EYE.up)
    comparison = validate(mesh, Scene([lamp, SUN], eye), PLASTIC)
    assert_equals_vtk(comparison)
    assert any("around its middle" in conversion for conversion in comparison.conversions)


def test_a_matrix_with_another_last_entry_is_divided_by_it():
    matrix = SHEAR.copy()
    for w in (2.0, -0.5):
        matrix[3, 3] = w
        scene = Scene([SUN, LAMP], Viewer(position=(1.5 * 3, -1.2 * 3, 1.8 * 3)))
        assert_equals_vtk(validate(BALL, scene, PLASTIC, matrix=matrix))


def test_clamped_colors_are_compared_before_they_are_clamped():
    glaring = replace(SUN, intensity=3.0)
    comparison = validate(BALL, Scene([glaring], EYE), PLASTIC)
    assert_equals_vtk(comparison)
    assert comparison.pvphong.max() > 1.5


def test_bright_light_is_compared_in_proportion():
    for intensity in (1e2, 1e6):
        comparison = validate(BALL, Scene([replace(LAMP, intensity=intensity)], EYE), PLASTIC)
        assert_equals_vtk(comparison)


def test_what_has_no_effect_is_no_obstacle():
    matte = replace(PLASTIC, specular=0.0, ambient=0.0, shininess=1.0)
    odd = replace(LAMP, specular=(1.0, 0.0, 0.0), ambient=0.4)
    off = SpotLight(exponent=500.0, specular=0.3, on=False)
    model = LightModel(reflection="blinn-phong", local_viewer=False)
    assert_equals_vtk(validate(BALL, Scene([odd, off], EYE, model), matte))


# --- what VTK cannot draw -----------------------------------------------------------------------------------------

REFUSED = {
    "a light's ambient": (
        Scene([replace(LAMP, ambient=0.3)], EYE),
        PLASTIC,
        r"ambient light of its own from lights\[0\] \(ambient=0\.3\).* nearest that it can: lights\[0\] with ambient=0",
    ),
    "a specular color": (
        Scene([SUN, replace(LAMP, specular=(1.0, 0.0, 0.0))], EYE),
        PLASTIC,
        r"highlights of lights\[1\] in another colour than its diffuse.*lights\[1\] with specular=None",
    ),
    "Blinn-Phong": (
        Scene([SUN], EYE, LightModel(reflection="blinn-phong")),
        PLASTIC,
        r"Blinn-Phong highlights.*reflection='phong' with shininess=5 \(`\.scene` and `\.material` of this error\)",
    ),
    "OpenGL's light model": (
        Scene([LAMP], EYE, LightModel.opengl()),
        PLASTIC,
        r"Blinn-Phong.*; highlights for a viewer at infinity beside lights with a position",
    ),
    "parallel and positional": (
        Scene([SUN, LAMP], replace(EYE, parallel=True)),
        PLASTIC,
        r"viewer at infinity beside lights with a position.*local_viewer=True and parallel=False",
    ),
    "shininess": (Scene([SUN], EYE), replace(PLASTIC, shininess=200.0), r"a shininess of 200 .*shininess at most 128"),
    "shininess in VTK's convention": (
        Scene([SUN], EYE, LightModel.vtk()),
        replace(PLASTIC, shininess=200.0),
        r"a shininess of 200 .*clamps",
    ),
    "exponent": (Scene([SUN, replace(SPOT, exponent=129.0)], EYE), PLASTIC, r"exponent of 129 in lights\[1\]"),
}


@pytest.mark.parametrize(("scene", "material", "message"), REFUSED.values(), ids=REFUSED.keys())
def test_what_vtk_cannot_draw_is_refused_with_the_nearest_that_it_can(scene, material, message):
    with pytest.raises(InexpressibleError, match=message) as refusal:
        validate(BALL, scene, material)
    assert refusal.value.scene is not None
    assert refusal.value.material is not None
    assert validate(BALL, refusal.value.scene, refusal.value.material).passed


def test_the_nearest_of_a_directional_light_s_ambient_is_the_same_picture():
    scene = Scene([replace(SUN, ambient=(0.1, 0.2, 0.0))], EYE, LightModel(ambient=0.5, clamp=False))
    with pytest.raises(InexpressibleError, match=r"LightModel\.ambient brighter by that of lights\[0\]") as refusal:
        validate(BALL, scene, PLASTIC)
    nearest = refusal.value
    given = BALL.points, BALL.point_data.active_normals
    same = evaluate(*given, nearest.scene, nearest.material, precision="float64").rgb
    np.testing.assert_allclose(same, evaluate(*given, scene, PLASTIC, precision="float64").rgb, rtol=1e-14)


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.diag([1.0, 0.0, 1.0, 1.0]), r"a matrix that flattens space.*Use a small scale in place of 0"),
        (np.diag([1.0, 1e-19, 1.0, 1.0]), r"scales by 1e-19 to 1.*Scale mesh, lights and viewer alike"),
        (np.diag([1e19, 1e19, 1e19, 1.0]), r"scales by 1e\+19 to 1e\+19"),
    ],
)
@pytest.mark.parametrize("model", [STANDARD, VTK], ids=["standard", "vtk"])
def test_a_matrix_that_vtk_cannot_take_is_refused(matrix, message, model):
    with pytest.raises(InexpressibleError, match=message) as refusal:
        validate(BALL, Scene([SUN], EYE, model), PLASTIC, matrix=matrix)
    assert refusal.value.scene is None
    assert refusal.value.material is None


def test_a_mirrored_surface_is_refused_in_vtk_s_convention_only():
    mirror = np.diag([-1.0, 1.0, 1.0, 1.0])
    with pytest.raises(InexpressibleError, match=r"a mirrored surface .*LightModel\.vtk\(two_sided=False\)") as refusal:
        validate(BALL, Scene([SUN], EYE, LightModel.vtk()), PLASTIC, matrix=mirror)
    assert validate(BALL, refusal.value.scene, refusal.value.material, matrix=mirror).passed
    assert validate(BALL, Scene([SUN], EYE, LightModel(two_sided=True)), PLASTIC, matrix=mirror).passed


def test_scales_at_the_end_of_vtk_s_range_are_compared():
    for scale, share in ((1e-16, 0.9), (1e16, 0.9)):
        eye = Viewer(position=tuple(scale * np.array(EYE.position)))
        matrix = np.diag([scale, scale, scale, 1.0])
        comparison = validate(BALL, Scene([SUN], eye), PLASTIC, matrix=matrix)
        assert comparison.passed, str(comparison)
        assert comparison.n >= share * BALL.n_points, str(comparison)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"mesh": pv.PolyData()}, r"mesh must be a mesh with faces, or points with normals"),
        ({"scene": "sun"}, r"scene must be"),
        ({"material": 3}, r"material must be"),
        ({"matrix": np.eye(3)}, r"matrix must be a 4x4 matrix"),
        ({"matrix": np.diag([1.0, 1.0, 1.0, 0.0])}, r"matrix must be an affine 4x4 matrix"),
        ({"matrix": np.zeros((4, 4))}, r"matrix must be an affine 4x4 matrix"),
    ],
)
def test_bad_input_is_named(arguments, message):
    given = {"mesh": BALL, "scene": Scene([SUN], EYE), "material": PLASTIC, "matrix": None} | arguments
    matrix = given.pop("matrix")
    with pytest.raises(ValueError, match=message):
        validate(*given.values(), matrix=matrix)


# --- what is left out ---------------------------------------------------------------------------------------------


def test_unlit_vertices_are_left_out_and_counted():
    mesh = BALL.copy()
    normals, points = np.array(mesh.point_data.active_normals), np.array(mesh.points)
    normals[3], normals[5, 0], points[9, 1] = 0.0, np.nan, np.inf
    mesh.points = points
    mesh.point_data.active_normals = normals
    comparison = validate(mesh, Scene([SUN], EYE), PLASTIC)
    assert comparison.passed
    assert comparison.left_out["no place or normal"].tolist() == [3, 5, 9]
    assert comparison.n == BALL.n_points - 3
    mesh.point_data.active_normals = np.zeros_like(normals)
    nothing = validate(mesh, Scene([SUN], EYE), PLASTIC)
    assert (nothing.n, nothing.passed) == (0, False)
    assert math.isnan(nothing.max_error)


def test_inputs_are_not_modified():
    mesh = BALL.copy()
    before = mesh.points.copy(), mesh.point_data.active_normals.copy(), sorted(mesh.array_names)
    validate(mesh, Scene([LAMP], EYE, LightModel(two_sided=True)), PLASTIC, matrix=SHEAR)
    np.testing.assert_array_equal(mesh.points, before[0])
    np.testing.assert_array_equal(mesh.point_data.active_normals, before[1])
    assert sorted(mesh.array_names) == before[2]
