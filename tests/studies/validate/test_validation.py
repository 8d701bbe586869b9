"""Random scenes against VTK's shader, and planted faults that the comparison must find; see also `test_report`."""

import math
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from strategies import Dice, moderate_case

from pvphong import PBR, DirectionalLight, LightModel, Material, PointLight, Scene, SpotLight, Viewer
from pvphong.base.types import rgb
from pvphong.shading import kernel
from pvphong.shading.evaluation import evaluate
from pvphong.studies.validate import validation
from pvphong.studies.validate.validation import validate
from pvphong.vtk.oracle import vtk_shade
from pvphong.vtk.scenes import InexpressibleError, refuse_inexpressible

STANDARD, VTK = LightModel(), LightModel.vtk(two_sided=False)
SUN = DirectionalLight(direction=(-1.0, 0.5, -1.2), intensity=0.8)
HEADLIGHT = DirectionalLight(frame="headlight")
LAMP = PointLight(position=(0.8, -0.7, 1.0), attenuation=(0.2, 0.3, 0.4))
SPOT = SpotLight(position=(0.7, -0.5, 1.1), direction=(-0.7, 0.5, -1.1), cone_angle=15.0, exponent=4.0)
HALF_SPACE = SpotLight(position=(0.0, 0.0, 0.0), direction=(0.1, 0.2, 1.0), cone_angle=90.0, exponent=2.0)
SHEAR = np.eye(4) + np.diag([0.9, 0.0, 0.0], 1)
MIRROR = np.diag([-1.0, 1.0, 1.0, 1.0])
PLASTIC = Material(ambient=0.1, diffuse=(0.3, 0.4, 0.7), specular=0.4, shininess=20.0)
EYE = Viewer(position=(1.5, -1.2, 1.8), up=(0.0, 0.0, 1.0))
BALL = pv.Sphere()
HOLLOW = BALL.copy()
HOLLOW.point_data.active_normals = -BALL.point_data.active_normals


def assert_equals_vtk(comparison, *, tier=None, converted=None, share=0.9):
    """Assert equal colours; `converted` is part of the listed conversions, or empty if there are none."""
    assert comparison.passed, str(comparison)
    assert comparison.n >= share * len(comparison.pvphong), str(comparison)
    assert tier in (None, comparison.tier)
    if converted is not None:
        said = any(converted in words for words in comparison.conversions)
        assert said if converted else not comparison.conversions, comparison.conversions


# --- random scenes --------------------------------------------------------------------------------------------------

RANDOM = 200
in_blocks = pytest.mark.parametrize(
    "block", [pytest.param(block, marks=[pytest.mark.long] * (block >= 2)) for block in range(10)]
)


def drawable(seed, is_physical):
    """Draw a scene and matrix, or the nearest that VTK can draw, and a cloud with normals in all directions."""
    case = moderate_case(Dice(seed), "vtk" if is_physical else ("standard", "vtk")[seed % 2])
    scene, material = case.scene, case.material
    if is_physical:
        # as drawn with `pbr=True`, with roughnesses for which the bound is within 1e-4
        dice = Dice(f"physical {seed}")
        reflectance = PBR(dice.choice((0.0, 1.0, dice.random())), dice.uniform(0.25, 1.0))
        material = Material(diffuse=np.clip(rgb(dice.color()), 0.0, 1.0), reflectance=reflectance)
    rng = np.random.default_rng(seed)
    mesh = pv.PolyData(np.float32(np.vstack([case.points, rng.uniform(-1.0, 1.0, (200, 3))])))
    normals = rng.normal(size=(200, 3)) * 10.0 ** rng.uniform(-3.0, 3.0)
    mesh.point_data.active_normals = np.float32(np.vstack([case.normals, normals]))
    try:
        refuse_inexpressible(scene, material, case.matrix)
    except InexpressibleError as nearest:
        return mesh, nearest.scene, nearest.material, case.matrix
    return mesh, scene, material, case.matrix


@pytest.mark.parametrize("dark", [0.012, (0.06, 0.0, 0.0), 0.0])
@pytest.mark.parametrize("metallic", [0.6, 0.9])
def test_nearly_black_half_metals_are_as_vtk_draws_them(metallic, dark):
    """F₉₀ is below 1 for such materials."""
    mesh, scene, _, matrix = drawable(80, True)
    black = Material(diffuse=dark, reflectance=PBR(metallic, 0.36))
    assert validate(mesh, scene, black, matrix=matrix).passed


@pytest.mark.parametrize("is_physical", [False, True], ids=["phong", "physical"])
@in_blocks
def test_random_scenes(block, is_physical, monkeypatch):
    """Use the reference evaluator, and the compiled one if it is installed."""
    compared = count = 0
    for seed in range(block * RANDOM // 10, (block + 1) * RANDOM // 10):
        mesh, scene, material, matrix = drawable(seed, is_physical)
        comparison = validate(mesh, scene, material, matrix=matrix)
        assert comparison.passed, f"seed {seed}\n{comparison}"
        power = max([light.exponent for light in scene.lights if hasattr(light, "exponent")] + [material.shininess])
        assert comparison.tolerance <= 1e-4 + 16 * power * 2.0**-24
        compared, count = compared + comparison.n, count + mesh.n_points
        if kernel.is_available():
            with monkeypatch.context() as patch:
                patch.setattr(validation, "vtk_shade", lambda *_, drawn=comparison.vtk, **__: drawn)
                compiled = validate(mesh, scene, material, matrix=matrix, backend="numba")
            assert compiled.passed, f"seed {seed}\n{compiled}"
    assert compared > 0.8 * count


# --- planted faults --------------------------------------------------------------------------------------------------


def changed(what, **fields):
    """Return a fault that gives the evaluator other lights, material, viewer or light model than VTK."""

    def change(scene, material, **_):
        if what == "material":
            return {"material": replace(material, **fields)}
        if what == "lights":
            return {"scene": replace(scene, lights=[replace(light, **fields) for light in scene.lights])}
        return {"scene": replace(scene, **{what: replace(getattr(scene, what), **fields)})}

    return change


def float16_normals(normals, **_):
    return {"normals": normals.astype(np.float16).astype(np.float32)}


def no_inverse_transpose(points, normals, matrix, **_):
    linear = matrix[:3, :3].T
    return {"points": points @ linear + matrix[:3, 3], "normals": normals @ linear, "matrix": None}


def another_tier(scene, **_):
    return {"scene": replace(scene, lights=[*scene.lights, DirectionalLight(diffuse=0.0)])}


FAULTS = {
    "wrong sign": (lambda normals, **_: {"normals": -normals}, SUN, STANDARD, None),
    "float16 normals": (float16_normals, SUN, STANDARD, None),
    "float16 normals by a lamp": (float16_normals, LAMP, VTK, None),
    "forgotten inverse-transpose": (no_inverse_transpose, SUN, STANDARD, SHEAR),
    "forgotten inverse-transpose, two-sided": (no_inverse_transpose, SUN, LightModel(two_sided=True), SHEAR),
    "wrong tier": (another_tier, HEADLIGHT, VTK, None),
    "attenuation forgotten": (changed("lights", attenuation=(1, 0, 0)), LAMP, STANDARD, None),
    "full cone for half": (changed("lights", cone_angle=7.5), SPOT, STANDARD, None),
    "exponent forgotten": (changed("lights", exponent=0.0), SPOT, STANDARD, None),
    "camera frame forgotten": (changed("lights", frame="world"), replace(SUN, frame="camera"), STANDARD, None),
    "eye a little off": (changed("viewer", position=(1.5, -1.2, 1.8004)), SUN, STANDARD, None),
    "infinite viewer": (changed("light_model", local_viewer=False), SUN, STANDARD, None),
    "Blinn-Phong for Phong": (changed("light_model", reflection="blinn-phong"), SUN, STANDARD, None),
    "two-sided for one-sided": (changed("light_model", two_sided=True), SUN, STANDARD, None),
    "ambient light forgotten": (changed("light_model", ambient=1.0), SUN, STANDARD, None),
    "shininess off by 0.1 %": (changed("material", shininess=20.02), SUN, STANDARD, None),
}


@pytest.mark.parametrize(("fault", "light", "model", "matrix"), FAULTS.values(), ids=FAULTS.keys())
def test_a_faulty_evaluator_fails(monkeypatch, fault, light, model, matrix):
    scene = Scene([light], EYE, model)
    assert validate(BALL, scene, PLASTIC, matrix=matrix).passed

    def faulty(points, normals, scene, material, *, matrix, **_):
        given = {"points": points, "normals": normals, "scene": scene, "material": material, "matrix": matrix}
        return evaluate(**(given | fault(**given)))

    monkeypatch.setattr(validation, "evaluate", faulty)
    comparison = validate(BALL, scene, PLASTIC, matrix=matrix)
    assert not comparison.passed
    assert comparison.n > 0.9 * BALL.n_points
    assert comparison.max_error > 2.0 * comparison.tolerance


@pytest.mark.parametrize("error", [1e-3, np.nan])
def test_a_single_wrong_vertex_fails_and_is_named(monkeypatch, error):
    def faulty(*args, **options):
        shading = evaluate(*args, **options)
        shading.rgb[123, 1] += error
        return shading

    monkeypatch.setattr(validation, "evaluate", faulty)
    comparison = validate(BALL, Scene([SUN], EYE), PLASTIC)
    assert not comparison.passed
    assert comparison.n == BALL.n_points
    if np.isfinite(error):
        worst = comparison.worst[0]
        assert worst.index == 123
        assert worst.error == pytest.approx(error, rel=1e-2)
        np.testing.assert_allclose(worst.position, BALL.points[123], atol=1e-7)
        np.testing.assert_allclose(worst.normal, BALL.point_data.active_normals[123], atol=1e-6)


# --- VTK's quirks, which `tests/vtk/test_oracle.py` shows: pvphong's VTK convention has them ----------------------


OFF = replace(LAMP, on=False)
# Another light, even black or off, disables VTK's special formula of a single headlight. A single light that is off
# draws unlit. VTK ignores some colours.
QUIRKS = [HEADLIGHT, replace(SUN, diffuse=0.0)], [HEADLIGHT, OFF], [OFF], [replace(SUN, specular="lime", ambient=0.5)]


@pytest.mark.parametrize("material", [PLASTIC, replace(PLASTIC, reflectance=PBR())], ids=["phong", "physical"])
@pytest.mark.parametrize("lights", QUIRKS)
def test_quirks_of_lights(lights, material):
    assert_equals_vtk(validate(BALL, Scene(lights, EYE, VTK), material))


def test_quirk_the_floor_shows_at_powers_below_1():
    faint = Material(ambient=0.0, diffuse=0.0, specular=1.0, shininess=0.1)
    comparison = validate(BALL, Scene([SUN], EYE, VTK), faint)
    assert_equals_vtk(comparison, share=0.6)  # powers amplify float32 rounding of small cosines
    reds = comparison.pvphong[:, 0]
    assert reds[reds > 0.0].min() == pytest.approx(0.8 * 1e-5**0.1, abs=1e-4)  # .316 · .8 is the darkest


# --- physically based shading ---------------------------------------------------------------------------------


def test_physical_shading_of_a_property_is_its_materials():
    prop = pv.Property(interpolation="pbr", metallic=0.6, roughness=0.45, color="tan", ambient=0.3, diffuse=0.9)
    viewed = [LAMP, SUN], EYE
    drawn = vtk_shade(BALL, viewed[0], prop, EYE)
    own = evaluate(BALL.points, BALL.point_data.active_normals, Scene(*viewed, VTK), Material.from_property(prop))
    np.testing.assert_allclose(own.rgb, np.clip(drawn, 0, 1), atol=2e-5)


# --- conversions of the scene for VTK -----------------------------------------------------------------------

AMBIENT = Scene([SUN], EYE, LightModel(ambient=(0.5, 0.2, 0.9)))
FAR = LightModel(local_viewer=False)
OPENGL = Scene([HEADLIGHT, replace(LAMP, on=False)], EYE, LightModel.opengl())
CONVERTED = {
    "ambient light": (AMBIENT, PLASTIC, "ambient light times"),
    "emission": (AMBIENT, replace(PLASTIC, emission=(0.1, 0.0, 0.3)), "emission"),
    "white ambient light": (Scene([SUN], EYE, LightModel(ambient=1.0)), PLASTIC, ""),
    "a viewer at infinity": (Scene([SUN], EYE, FAR), PLASTIC, "viewer at infinity"),
    "parallel projection": (Scene([SUN], replace(EYE, parallel=True)), PLASTIC, "viewer at infinity"),
    "lights that ride along": (Scene([replace(SUN, frame="camera"), HEADLIGHT], EYE, FAR), PLASTIC, "at infinity"),
    "a headlight alone": (Scene([HEADLIGHT], EYE), PLASTIC, "simplify highlights"),
    "Blinn-Phong at infinity": (OPENGL, PLASTIC, "Blinn-Phong with the viewer at infinity"),
    "two-sided lighting": (Scene([SUN], EYE, LightModel(two_sided=True)), PLASTIC, "normals turned"),
    "two-sided, VTK's": (Scene([LAMP], EYE, LightModel.vtk()), PLASTIC, "normals turned"),
    "darkness": (Scene([replace(SUN, on=False)], EYE), PLASTIC, "draw unlit"),
    "a half-space of light": (Scene([HALF_SPACE], EYE), PLASTIC, "cones of 90°"),
    # settings without effect do not prevent a comparison
    "highlights of a matte material": (
        Scene([replace(LAMP, specular=(1.0, 0.0, 0.0), ambient=0.4)], EYE, replace(FAR, reflection="blinn-phong")),
        Material(ambient=0.0, diffuse=0.6),
        "",
    ),
    "powers of what is off": (
        Scene([SUN, replace(SPOT, exponent=500.0, on=False)], EYE),
        replace(PLASTIC, ambient=0),
        "",
    ),
}


@pytest.mark.parametrize(("scene", "material", "words"), CONVERTED.values(), ids=CONVERTED.keys())
def test_what_vtk_does_not_know_is_said_in_its_terms(scene, material, words):
    comparison = validate(HOLLOW if HALF_SPACE in scene.lights else BALL, scene, material)
    assert_equals_vtk(comparison, converted=words)


def test_vtk_s_floor_in_its_first_tier_is_left_out_in_the_standard_convention():
    comparison = validate(BALL, OPENGL, Material(diffuse=1.0, specular=1.0, shininess=0.3))
    assert comparison.passed
    assert comparison.tier == 1
    assert len(comparison.left_out["VTK's floor"]) > 0.3 * BALL.n_points  # vertices that face away


@pytest.mark.parametrize("local_viewer", [True, False])
def test_the_normals_of_worst_vertices_are_those_that_face_the_viewer(local_viewer):
    model = LightModel(two_sided=True, local_viewer=local_viewer)
    comparison = validate(BALL, Scene([SUN], EYE, model), PLASTIC)
    assert comparison.passed
    eye = np.array(EYE.position) * (1.0 if local_viewer else 1e9)
    assert all(np.dot(vertex.normal, eye - vertex.position) > 0.0 for vertex in comparison.worst)


@pytest.mark.parametrize("offset", [1e3, 1e9])
def test_a_mesh_far_from_the_origin_is_compared_around_its_middle(offset):
    """The scene is moved as a whole, in float64: pvphong shifts the origin, VTK does not."""
    step = np.array([offset, -offset, 0.5 * offset])
    mesh = pv.PolyData(np.float64(BALL.points) + step, BALL.faces)
    lamp = replace(LAMP, position=tuple(LAMP.position + step))
    eye = Viewer(position=tuple(EYE.position + step), focal_point=tuple(step), up=EYE.up)
    assert_equals_vtk(validate(mesh, Scene([lamp, SUN], eye), PLASTIC), converted="relative to the mesh's middle")


@pytest.mark.parametrize(
    ("scale", "w"), [(1.0, 2.0), (1.0, -0.5), (1e-16, 1.0), (1e16, 1.0)], ids=["w = 2", "w < 0", "tiny", "huge"]
)
def test_matrices_at_the_end_of_what_vtk_takes_are_compared(scale, w):
    matrix = np.diag([scale, scale, scale, w]) @ SHEAR
    eye = Viewer(position=tuple(3.0 * scale * np.array(EYE.position)))
    lights = [SUN, LAMP] if scale == 1.0 else [SUN]
    assert_equals_vtk(validate(BALL, Scene(lights, eye), PLASTIC, matrix=matrix))


@pytest.mark.parametrize("intensity", [3.0, 1e6])
@pytest.mark.parametrize("light", [SUN, LAMP])
def test_bright_light_is_compared_unclamped_and_in_proportion(light, intensity):
    comparison = validate(BALL, Scene([replace(light, intensity=intensity)], EYE), PLASTIC)
    assert_equals_vtk(comparison)
    assert comparison.pvphong.max() > 0.4 * intensity


# --- scenes that VTK cannot draw -------------------------------------------------------------------------------

REFUSED = {
    "a light's ambient": (
        Scene([replace(LAMP, ambient=0.3)], EYE),
        PLASTIC,
        r"ambient light from lights\[0\] \(ambient=0\.3\).* scene that it can draw: lights\[0\] with ambient=0",
    ),
    "a specular color": (
        Scene([SUN, replace(LAMP, specular=(1.0, 0.0, 0.0))], EYE),
        PLASTIC,
        r"highlights of lights\[1\] that differ from its diffuse colour.*lights\[1\] with specular=None",
    ),
    "Blinn-Phong": (
        Scene([SUN], EYE, LightModel(reflection="blinn-phong")),
        PLASTIC,
        r"Blinn-Phong highlights.*reflection='phong' with shininess=5 \(`\.scene` and `\.material` of this error\)",
    ),
    "Blinn-Phong of a sun at infinity": (Scene([SUN], EYE, LightModel.opengl()), PLASTIC, "Blinn-Phong highlights"),
    "OpenGL's light model": (
        Scene([LAMP], EYE, LightModel.opengl()),
        PLASTIC,
        r"Blinn-Phong.*; highlights for a viewer at infinity with positional lights",
    ),
    "parallel and positional": (
        Scene([SUN, LAMP], replace(EYE, parallel=True)),
        PLASTIC,
        r"viewer at infinity with positional lights.*local_viewer=True and parallel=False",
    ),
    "shininess": (Scene([SUN], EYE, VTK), replace(PLASTIC, shininess=200.0), r"shininess of 200 .*at most 128"),
    "PBR in the standard convention": (
        Scene([SUN], EYE),
        Material(reflectance=PBR()),
        r"PBR in the standard convention .*LightModel\.vtk\(\)",
    ),
    "emission of PBR": (
        Scene([SUN], EYE, VTK),
        Material(emission=0.2, reflectance=PBR()),
        r"emission of a physically based material.*emission=0",
    ),
    "shadows": (Scene([SUN], EYE, LightModel(shadows=True)), PLASTIC, "shadows, ambient occlusion or bounces"),
    "exponent": (Scene([SUN, replace(SPOT, exponent=129.0)], EYE), PLASTIC, r"exponent of 129 in lights\[1\]"),
}


@pytest.mark.parametrize(("scene", "material", "message"), REFUSED.values(), ids=REFUSED.keys())
def test_what_vtk_cannot_draw_is_refused_with_the_nearest_that_it_can(scene, material, message):
    with pytest.raises(InexpressibleError, match=message) as refusal:
        validate(BALL, scene, material)
    assert validate(BALL, refusal.value.scene, refusal.value.material).passed


def test_the_nearest_of_a_directional_light_s_ambient_is_the_same_picture():
    scene = Scene([replace(SUN, ambient=(0.1, 0.2, 0.0))], EYE, LightModel(ambient=0.5, clamp=False))
    with pytest.raises(InexpressibleError, match=r"LightModel\.ambient increased by .* of lights\[0\]") as refusal:
        validate(BALL, scene, PLASTIC)
    nearest = refusal.value
    given = BALL.points, BALL.point_data.active_normals
    same = evaluate(*given, nearest.scene, nearest.material, precision="float64").rgb
    np.testing.assert_allclose(same, evaluate(*given, scene, PLASTIC, precision="float64").rgb, rtol=1e-14)


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.diag([1.0, 0.0, 1.0, 1.0]), r"a matrix that flattens space.*Use a small scale in place of 0"),
        (
            np.diag([1.0, 1e-19, 1.0, 1.0]),
            r"scales by 1e-19 to 1.*Scale mesh, lights and viewer alike, so that the matrix scales by",
        ),
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
    with pytest.raises(InexpressibleError, match=r"a mirrored surface .*LightModel\.vtk\(two_sided=False\)") as refusal:
        validate(BALL, Scene([SUN], EYE, LightModel.vtk()), PLASTIC, matrix=MIRROR)
    assert validate(BALL, refusal.value.scene, refusal.value.material, matrix=MIRROR).passed
    assert validate(BALL, Scene([SUN], EYE, LightModel(two_sided=True)), PLASTIC, matrix=MIRROR).passed


# --- vertices left out ---------------------------------------------------------------------------------------------


def test_unlit_vertices_are_left_out_and_counted():
    mesh = BALL.copy()
    normals, points = np.array(mesh.point_data.active_normals), np.array(mesh.points)
    normals[3], normals[5, 0], points[9, 1] = 0.0, np.nan, np.inf
    mesh.points = points
    mesh.point_data.active_normals = normals
    comparison = validate(mesh, Scene([SUN], EYE), PLASTIC)
    assert comparison.passed
    assert comparison.left_out["no position or normal"].tolist() == [3, 5, 9]
    assert comparison.n == BALL.n_points - 3
    mesh.point_data.active_normals = np.zeros_like(normals)
    nothing = validate(mesh, Scene([SUN], EYE), PLASTIC)
    assert (nothing.n, nothing.passed) == (0, False)
    assert math.isnan(nothing.max_error)


@pytest.mark.parametrize("model", [LightModel(), LightModel.vtk(), LightModel(two_sided=True)])
def test_an_albedo_of_bytes_is_what_vtk_draws_as_vertex_colours(model):
    ball = pv.Sphere()
    ball["paint"] = np.random.default_rng(0).integers(0, 256, (ball.n_points, 3)).astype(np.uint8)
    lights = [PointLight(position=(1, 2, 3)), DirectionalLight(direction=(0, 0, -1), diffuse=(0.5, 0.6, 0.2))]
    scene, material = Scene(lights, light_model=model), Material(albedo="paint", specular=0.4, shininess=20)
    found = ball.phong.validate(scene, material)
    assert found.passed
    white = ball.phong.validate(scene, replace(material, albedo=1.0))
    assert np.abs(found.vtk - white.vtk).max() > 0.3
    for wrong, message in {
        "diffuse": "^diffuse must be grey if albedo is a map and the result is compared with VTK",
        "emission": "^emission must be left out if albedo is a map and the result is compared with VTK",
    }.items():
        with pytest.raises(ValueError, match=message):
            ball.phong.validate(scene, replace(material, **{wrong: (0.1, 0.2, 0.3)}))
    with pytest.raises(ValueError, match=r"^albedo must be uint8.* Convert it with np\.rint"):
        ball.phong.validate(scene, replace(material, albedo=ball["paint"] / 255))
