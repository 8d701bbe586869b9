"""Plans: each effect is on if a scene needs it, off if not, and removing it does not change the colours."""

from __future__ import annotations

import copy
import pickle
import re
from dataclasses import replace
from html import escape

import numpy as np
import pytest
import pyvista as pv
import vtk

import pvphong as ph
from pvphong.shading import reference
from pvphong.shading.equation import assemble
from pvphong.shading.plan.effects import EFFECTS
from pvphong.shading.reference import Shading

SHINY = ph.Material(diffuse=(0.5, 0.6, 0.7), specular=0.5, shininess=20)
DULL = ph.Material(diffuse=(0.5, 0.6, 0.7))
SUN = ph.DirectionalLight(direction=(-1, -1, -2), name="sun")
LAMP = ph.PointLight(position=(0, 0, 3), name="lamp")
SPOT = ph.SpotLight(position=(0, 0, 3), cone_angle=15, exponent=2, name="spot")
GLOW = replace(LAMP, ambient=0.5)
BLACK, GREENISH = replace(DULL, diffuse=0.0), replace(SHINY, specular=(0.0, 1.0, 0.0))
EYE = ph.Viewer(position=(0, -4, 3))
PARALLEL, IN_VTK = replace(EYE, parallel=True), {"ambient": 1.0, "convention": "vtk"}


def scene(*lights, **light_model):
    return ph.Scene(lights=lights, viewer=EYE, light_model=ph.LightModel(**light_model))


@pytest.fixture(scope="module")
def mesh():
    return pv.Sphere()  # radius 0.5 around the origin


def shear():
    matrix = np.eye(4)
    matrix[0, 1] = 0.5
    return matrix


MATT_SUN, GLOSSY_SUN, LIT_BY_LAMP, LIT_BY_SPOT = (
    (scene(SUN), DULL),
    (scene(SUN), SHINY),
    (scene(LAMP), DULL),
    (scene(SPOT), DULL),
)
BOTH_SIDES = scene(SUN, two_sided=True), DULL
# The box's diagonal is √3, so its sphere is seen within asin(√¾ / 3) = 16.8°: 180 − 16.8 − 15.
OUTSIDE = "spot: mesh lies outside the cone by 148°"
ON_AND_OFF = {
    # effect: (a call that turns it on, one that turns it off, the reason for off)
    "emission": ((scene(SUN), replace(DULL, emission=0.1)), MATT_SUN, "black emission"),
    "ambient": (MATT_SUN, (scene(SUN, ambient=0.0), DULL), "black ambient"),
    "ambient/light": ((scene(GLOW, ambient=0.0), DULL), (scene(LAMP, ambient=0.0), DULL), "black ambient"),
    "lights": (MATT_SUN, (scene(replace(SUN, on=False)), DULL), "sun: switched off"),
    "lights/black": (MATT_SUN, (scene(replace(SUN, diffuse=0.0)), DULL), "sun: adds black"),
    "lights/intensity": (MATT_SUN, (scene(replace(SUN, intensity=0)), DULL), "adds black"),
    "lights/material": (MATT_SUN, (scene(SUN), BLACK), "adds black"),
    "lights/outside": (LIT_BY_SPOT, (scene(replace(SPOT, direction=(0, 0, 1))), DULL), OUTSIDE),
    "lights/none": (MATT_SUN, (scene(), DULL), "no light reaches the mesh"),
    "cone": (LIT_BY_SPOT, (scene(replace(SPOT, cone_angle=40, exponent=0)), DULL), "mesh lies inside the cone"),
    "cone/none": (LIT_BY_SPOT, LIT_BY_LAMP, "no spot light"),
    "specular": (GLOSSY_SUN, MATT_SUN, "black specular colour"),
    "specular/light": (GLOSSY_SUN, (scene(replace(SUN, specular=0.0)), SHINY), "black specular colour"),
    "specular/product": (GLOSSY_SUN, (scene(replace(SUN, specular="red")), GREENISH), "black specular colour"),
    "attenuation": (
        (scene(replace(LAMP, attenuation=(1, 0.1, 0))), DULL),
        (scene(replace(LAMP, attenuation=(4, 0, 0))), DULL),
        r"lamp: constant, 0\.25",
    ),
    "attenuation/one": ((scene(replace(LAMP, attenuation=(1, 0, 1))), DULL), LIT_BY_LAMP, "no light has attenuation"),
    "position": (LIT_BY_LAMP, MATT_SUN, "every light is directional"),
    "local viewer": ((scene(LAMP), SHINY), LIT_BY_LAMP, "no remaining highlight"),
    "local viewer/infinite": ((scene(LAMP), SHINY), (scene(LAMP, local_viewer=False), SHINY), "at infinity"),
    "diffuse": (GLOSSY_SUN, (scene(SUN), replace(SHINY, diffuse=0.0)), "black diffuse colour"),
    "two-sided": (BOTH_SIDES, MATT_SUN, "one-sided"),
    "two-sided/unlit": (
        BOTH_SIDES,
        (scene(replace(SUN, on=False), two_sided=True), DULL),
        "nothing depends on the normal",
    ),
}


@pytest.mark.parametrize("case", ON_AND_OFF)
def test_each_effect_has_a_scene_that_turns_it_on_and_one_that_turns_it_off(case, mesh):
    effect = case.split("/")[0]
    on, off, reason = ON_AND_OFF[case]
    assert ph.plan(mesh, *on).effects[effect].on
    decision = ph.plan(mesh, *off).effects[effect]
    assert not decision.on
    assert re.search(reason, decision.why), decision.why
    assert decision.bound == 0.0


def test_what_is_off_for_want_of_a_light_says_so(mesh):
    for dark in (replace(SPOT, on=False), replace(SPOT, direction=(0, 0, 1)), replace(SPOT, diffuse=0.0)):
        plan = ph.plan(mesh, scene(replace(SUN, on=False), dark), SHINY)
        for effect in ("diffuse", "specular", "attenuation", "position"):
            assert plan.effects[effect].why == "no light reaches the mesh"


OFF_AXIS = np.arcsin(np.sqrt(0.75) / 3) + np.radians(15 + 0.4)  # the box's sphere, the cone, and a margin
SLIGHTLY_OUTSIDE = replace(SPOT, direction=(0, np.sin(OFF_AXIS), -np.cos(OFF_AXIS)))
UNNAMED = [replace(SUN, name=name, on=index != 1) for index, name in enumerate(["sun", "", "", "lamp", "light 2"])]
BALL = ph.SphereLight((0, 0, 2), name="ball")
REASONS = [
    (scene(SLIGHTLY_OUTSIDE), DULL, "lights", "spot: mesh lies outside the cone by 0.4°"),
    (scene(*UNNAMED), DULL, "lights", "sun, light 2, lamp, light 4 (left out: light 1: switched off)"),
    (scene(replace(GLOW, attenuation=(0, 0, 1)), ambient=0.0), DULL, "ambient", "from lamp"),
    (scene(replace(GLOW, attenuation=(0, 0, 1))), DULL, "ambient", "one constant for all vertices; from lamp"),
    (scene(LAMP), SHINY, "local viewer", "highlights"),
    (scene(LAMP), ph.Material(reflectance=ph.OrenNayar(25)), "local viewer", "diffuse reflection"),
    (scene(LAMP), ph.Material(specular=0.5, reflectance=ph.GGX(0.3, 0.04)), "local viewer", "highlights"),
    (scene(LAMP, two_sided=True), DULL, "local viewer", "normals are turned to it"),
    (scene(BALL, LAMP), SHINY, "size", "ball: diffuse and specular exact"),
    (scene(BALL, reflection="blinn-phong"), SHINY, "size", "ball: diffuse exact, specular by 64 nodes"),
    (scene(BALL), DULL, "size", "ball: diffuse exact"),
    (scene(BALL), ph.Material(reflectance=ph.OrenNayar(20)), "size", "ball: diffuse by 64 nodes"),
    (scene(LAMP), SHINY, "size", "no light has a size"),
    (scene(ph.RectangleLight((0, 0, 2), (0, 0, 1))), SHINY, "size", "light 0: mesh lies behind it"),
    (scene(ph.DiskLight((0, 0, 2), (0, 0, 1))), SHINY, "lights", "light 0: mesh lies behind it"),
]


@pytest.mark.parametrize(("some_scene", "material", "effect", "why"), REASONS)
def test_the_reason_names_lights_and_numbers(mesh, some_scene, material, effect, why):
    plan = ph.plan(mesh, some_scene, material)
    assert (plan.effects[effect].why, plan.error_bound) == (why, 0.0)


TURNED = np.eye(4)
TURNED[:3, :3] = np.linalg.qr(np.random.default_rng(6).normal(size=(3, 3)))[0]


@pytest.mark.parametrize(
    ("matrix", "on", "why"),
    [
        (None, False, "no matrix"),
        (np.eye(4), False, "identity"),
        (np.diag([1.0, 1.0, 1.0, 1.0]) + np.outer([1, 2, 3, 0], [0, 0, 0, 1]), False, "a translation"),
        (np.diag([3.0, 3.0, 3.0, 1.0]), False, "a uniform scale"),
        (np.diag([-3.0, -3.0, -3.0, 1.0]), True, "similar"),
        (np.eye(4)[[1, 2, 0, 3]], True, "rigid"),
        *((np.diag([*[scale] * 3, 1]) @ TURNED, True, "rigid or similar") for scale in (1e-200, 1e-170, 1e170, 1e300)),
        (shear(), True, "general"),
    ],
)
def test_normals_are_transformed_by_the_class_of_the_matrix(mesh, matrix, on, why):
    decision = ph.plan(mesh, scene(SUN), DULL, matrix=matrix).effects["normal transform"]
    assert decision.on is on
    assert why in decision.why


def run(equation, mesh):
    result = Shading(np.empty((mesh.n_points, 3)))
    reference.shade(np.asarray(mesh.points), np.asarray(mesh.point_data.active_normals), equation, {}, result)
    return result.rgb


def bent(angle):
    """Return a patch of a sphere around the origin, with normals within an angle in degrees of z."""
    return pv.Sphere(end_phi=angle)


def assert_same_without_turning(patch, some_scene, material, matrix=None):
    """Assert that no vertex of a two-sided patch is turned, because none faces away; return the plan."""
    plan = ph.plan(patch, some_scene, material, matrix=matrix)
    assert "no vertex faces away" in plan.effects["two-sided"].why
    np.testing.assert_array_equal(run(plan.equation, patch), run(assemble(some_scene, material, matrix), patch))
    return plan


@pytest.mark.parametrize("local_viewer", [True, False])
@pytest.mark.parametrize("material", [DULL, SHINY])
def test_no_normal_is_turned_where_all_face_the_viewer(material, local_viewer):
    model = ph.LightModel(two_sided=True, local_viewer=local_viewer)
    above = ph.Scene([LAMP], ph.Viewer(position=(0, 0, 4)), model)
    plan = assert_same_without_turning(bent(40), above, material)
    assert plan.error_bound == 0.0
    assert plan.view_dependent  # from elsewhere, some may face away
    aside = ph.Scene([LAMP], ph.Viewer(position=(9, 0, 1)), model)
    assert ph.plan(bent(40), aside, material).effects["two-sided"].on
    near = ph.Scene([LAMP], ph.Viewer(position=(0, 0, 2)), model)  # seen from there, the rim faces away
    assert ph.plan(bent(80), near, material).effects["two-sided"].on is local_viewer


QUARTER_TURN = np.array([[0.0, 0, 2, 5], [0, 2, 0, 6], [-2, 0, 0, 7], [0, 0, 0, 1]])  # z to x, and twice as large


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_normals_are_known_to_face_the_viewer_where_a_matrix_turns_or_mirrors_them(side):
    matrix, patch = np.diag([side, 1.0, 1.0, 1.0]) @ QUARTER_TURN, bent(40)
    seen, behind = (
        ph.Scene([LAMP], ph.Viewer(position=(x, 6, 7)), ph.LightModel(two_sided=True)) for x in (side * 30, side * -30)
    )
    assert_same_without_turning(patch, seen, DULL, matrix)
    assert ph.plan(patch, behind, DULL, matrix=matrix).effects["two-sided"].on
    assert ph.plan(patch, seen, DULL, matrix=matrix @ shear()).effects["two-sided"].on


@pytest.mark.parametrize(
    ("some_scene", "material", "needs", "view_dependent"),
    [
        (scene(), DULL, set(), False),
        (scene(SUN), DULL, {"normals"}, False),
        (scene(LAMP), DULL, {"normals", "points"}, False),
        (scene(SUN), SHINY, {"normals", "points", "viewer"}, True),
        (scene(SUN, local_viewer=False), SHINY, {"normals", "viewer"}, True),
        (scene(SUN, two_sided=True), DULL, {"normals", "points", "viewer"}, True),
        (scene(replace(SUN, frame="headlight")), DULL, {"normals"}, True),
        (scene(replace(SUN, frame="headlight"), **IN_VTK), SHINY, {"normals"}, True),
        (scene(SUN, two_sided=True, local_viewer=False), DULL, {"normals", "viewer"}, True),
        (replace(scene(SUN), viewer=PARALLEL), SHINY, {"normals", "viewer"}, True),
        (replace(scene(SUN, **IN_VTK), viewer=PARALLEL), SHINY, {"normals", "points", "viewer"}, True),
        (scene(replace(SUN, frame="camera")), DULL, {"normals"}, True),
        (scene(replace(SUN, frame="camera", on=False), LAMP), DULL, {"normals", "points"}, False),
    ],
)
def test_a_plan_says_what_is_read_and_whether_the_view_matters(mesh, some_scene, material, needs, view_dependent):
    plan = ph.plan(mesh, some_scene, material)
    assert plan.needs == needs
    assert plan.view_dependent is view_dependent


def test_the_reasons_of_all_lights_are_kept(mesh):
    black = replace(LAMP, diffuse=0.0, specular=0.0, name="black")
    weak = ph.PointLight(position=(0, 0, 3), intensity=1e-4, name="weak")
    why = ph.plan(mesh, scene(black, weak, SUN), SHINY, tolerance=0.1).effects["lights"].why
    assert "black" in why
    assert "weak" in why


FAR = [
    (scene(ph.PointLight(position=(0, 0, 1e5), name="far")), SHINY, "position", "far: far away"),
    (scene(ph.PointLight(position=(0, 0, 3), intensity=1e-4, name="weak")), SHINY, "lights", "weak: too weak"),
    (
        scene(ph.PointLight(position=(0, 0, 1e3), attenuation=(0, 1e-3, 0))),
        DULL,
        "attenuation",
        "constant over the mesh",
    ),
    (scene(ph.SpotLight(position=(0, 0, 1e3), cone_angle=10, exponent=3)), DULL, "cone", "constant to within"),
    (replace(scene(SUN), viewer=ph.Viewer(position=(0, -1e5, 0))), SHINY, "local viewer", "far away"),
    (scene(replace(SUN, specular=1e-4)), SHINY, "specular", "at most"),
]


@pytest.mark.parametrize(("some_scene", "material", "effect", "why"), FAR)
def test_within_a_tolerance_what_hardly_matters_is_left_out_and_the_promise_kept(
    mesh, some_scene, material, effect, why
):
    tolerance = 1 / 255
    assert ph.plan(mesh, some_scene, material).effects[effect].on
    plan = ph.plan(mesh, some_scene, material, tolerance=tolerance)
    decision = plan.effects[effect]
    assert not decision.on
    assert why in decision.why
    assert 0.0 < decision.bound <= plan.error_bound <= tolerance
    error = np.abs(run(plan.equation, mesh) - run(assemble(some_scene, material, None), mesh)).max()
    assert 0.0 < error <= plan.error_bound


def test_of_a_sum_that_is_raised_to_a_power_less_can_be_left_out(mesh):
    weak = scene(ph.PointLight(position=(0, 0, 3), intensity=1e-4), **IN_VTK)
    for material, is_on in ((DULL, False), (replace(DULL, reflectance=ph.PBR()), True)):
        assert ph.plan(mesh, weak, material, tolerance=1 / 255).effects["lights"].on is is_on


def test_highlights_that_cannot_reach_a_flat_mesh_are_left_out():
    ground = pv.Plane(direction=(0, 0, 1)).compute_normals()
    sun, viewer = ph.DirectionalLight(direction=(-1, 0, -0.2)), ph.Viewer(position=(5, 0, 20))
    grazing = ph.Scene([sun], viewer, ph.LightModel(reflection="blinn-phong"))
    turned = ground.rotate_y(-90), pv.Transform().rotate_y(90).matrix
    for mesh, matrix in ((ground, None), turned):
        plan = ph.plan(mesh, grazing, replace(SHINY, shininess=100), matrix=matrix, tolerance=1 / 255)
        assert not plan.effects["specular"].on
        assert plan.needs == {"normals"}


def test_no_approximation_is_taken_where_a_point_is_not_finite(mesh):
    broken = mesh.copy()
    broken.points[7] = np.nan
    plan = ph.plan(broken, FAR[0][0], SHINY, tolerance=1 / 255)
    assert plan.effects["position"].on
    assert plan.error_bound == 0.0


def test_what_is_left_out_for_this_viewer_is_planned_anew_for_the_next_one():
    patch, sun = pv.Plane(), replace(SUN, direction=(0, 0, -1))
    aside = ph.Scene(lights=[sun], viewer=ph.Viewer(position=(9, 0, 0.1)))
    plan = ph.plan(patch, aside, replace(SHINY, shininess=300), tolerance=1 / 255)
    assert not plan.effects["specular"].on
    assert not plan.equation.has_highlights
    assert plan.view_dependent


def test_a_plan_cannot_be_changed_by_its_reader_or_by_the_matrix_it_was_made_for(mesh):
    matrix = shear()
    plan = ph.plan(mesh, scene(SUN), DULL, matrix=matrix)
    with pytest.raises(TypeError):
        plan.effects["ambient"] = None
    matrix[0, 1] = 7.0
    np.testing.assert_array_equal(plan.equation.matrix, shear())


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda plan: pickle.loads(pickle.dumps(plan))])
def test_a_plan_can_be_copied_and_sent(copied, mesh):
    plan = mesh.phong.plan(scene(SUN, SPOT), SHINY, matrix=shear())
    other = copied(plan)
    assert other.explain() == plan.explain()
    assert list(other.effects.items()) == [(effect.name, plan.effects[effect.name]) for effect in EFFECTS]
    with pytest.raises(TypeError):
        other.effects["cone"] = None


def test_explain_is_a_table_with_sums_and_with_names_as_they_are(mesh):
    text = mesh.phong.plan(scene(SUN, replace(SPOT, direction=(0, 0, 1))), DULL).explain()
    for part in (
        "Exact, tolerance 0",
        "off black specular colour",
        "sun (left out: spot: mesh lies outside",
        "estimated for the compiled evaluator in float32 on one core",
        "It reads normals",
        "do not change",
    ):
        assert part in " ".join(text.split())
    # one sun without highlights: 0.5 to read the normals and 0.2 for the light
    assert re.search(r"diffuse +on .*normals +0\.7", text)
    assert re.search(r"sum +0 +0\.7\n", text)
    assert text == "".join(f"{line.rstrip()}\n" for line in text.splitlines())
    plan = mesh.phong.plan(FAR[0][0], SHINY, tolerance=0.004)
    assert f"Error at most {plan.error_bound:.3g}, tolerance 0.004\n" in plan.explain()
    costs = [effect.nanoseconds(plan.effects[effect.name]) for effect in EFFECTS]
    assert re.search(rf"sum +{plan.error_bound:.2g} +{sum(costs):.1f}\n", plan.explain())
    assert "[b]lamp :sun:" in mesh.phong.plan(scene(replace(LAMP, name="[b]lamp :sun:")), DULL).explain()


def test_a_printed_plan_is_a_few_plain_lines_and_a_notebooks_has_all_reasons(mesh):
    lights = [SUN, replace(SPOT, direction=(0, 0, 1), name="<b>spot"), replace(LAMP, frame="camera")]
    for given, material, tolerance in ((scene(*lights), SHINY, 0.0), (FAR[0][0], SHINY, 0.004), (scene(), DULL, 0.0)):
        plan = mesh.phong.plan(given, material, tolerance=tolerance)
        lines = str(plan).splitlines()
        assert len(lines) <= 5
        assert max(map(len, lines)) <= 80
        said = " ".join(str(plan).split())
        runs, out = re.match(r"Runs: (.*?)\. Left out: (.*?)\. (?:Exact|Error at most)", said).groups()
        assert runs.split(", ") == [name for name, choice in plan.effects.items() if choice.on]
        assert out.split(", ") == [name for name, choice in plan.effects.items() if not choice.on]
        assert (f"Error at most {plan.error_bound:.3g}" in said) is (plan.error_bound > 0)
        assert re.fullmatch(rf"<Plan: {len(runs.split(', '))} of \d+ effects run, error bound \S+>", repr(plan))
        html = plan._repr_html_()
        assert all(f">{escape(choice.why)}<" in html for choice in plan.effects.values())
    assert "<b>" not in mesh.phong.plan(scene(*lights), SHINY)._repr_html_()


MESH_OR_POINTS = r"^mesh_or_points must be a mesh or an \(n, 3\) array of real numbers"


@pytest.mark.parametrize(
    ("bad", "got"),
    [
        ([1, 2, 3], r"an array of shape \(3,\)"),
        (None, "None"),
        ("mesh.vtp", "mesh.vtp"),
        (pv.MultiBlock([pv.Sphere(), None]), r"a MultiBlock of 2 blocks\. Use blocks\.phong\.plan"),
        (vtk.vtkPolyData(), r"a vtkPolyData\. Convert a VTK dataset with pyvista\.wrap"),
    ],
)
def test_what_is_neither_a_mesh_nor_points_is_refused(bad, got):
    with pytest.raises(ValueError, match=rf"{MESH_OR_POINTS}; got {got}"):
        ph.plan(bad, scene(), DULL)


@pytest.mark.parametrize(
    "option",
    [{"feature_angle": 30}, {"occluders": [pv.Sphere()]}, {"occluders": 5}, {"visibility": 3}, {"transport": 3}],
)
def test_what_only_a_mesh_has_is_refused_beside_bare_points(option):
    with pytest.raises(ValueError, match=rf"^{next(iter(option))} must be left out for bare points; got an? "):
        ph.plan(np.eye(3), scene(), DULL, **option)
