"""`plotter.phong`: lit meshes and lights are updated after changes, and only then."""

import base64
import gc
import json
import re
import weakref
from dataclasses import FrozenInstanceError, fields, replace

import numpy as np
import pytest
import pyvista as pv
import vtk
from views import KINDS, example

from pvphong import GGX, DirectionalLight, LightModel, Material, PhongFilter, PointLight, Scene, SpotLight, Viewer

SUN = DirectionalLight(direction=(-1, -2, -3), name="sun")
LAMP = PointLight(position=(2, 2, 2), attenuation=(1, 0.1, 0), name="lamp")
DULL = Material(ambient=0.1, diffuse=(0.6, 0.5, 0.4))
TINTED = replace(DULL, albedo="tint")
SHINY = Material(ambient=0.1, diffuse=(0.6, 0.5, 0.4), specular=0.5, shininess=20)


@pytest.fixture
def plotter(new_plotter):
    """Draw a mesh without highlights in a sun, and render once."""
    shown = new_plotter()
    shown.phong.add_light(SUN)
    return shown


def ball():
    return pv.Sphere(theta_resolution=16, phi_resolution=12)


def draw(plotter, material=DULL, mesh=None, **options):
    actor = plotter.phong.add_mesh(ball() if mesh is None else mesh, material, **options)
    plotter.camera_position = [(0, 0, 5), (0, 0, 0), (0, 1, 0)]
    plotter.show(auto_close=False)  # PyVista renders nothing before
    return actor


def drawn(actor):
    return np.asarray(actor.mapper.dataset["phong"])


def evaluations_after(plotter, change=lambda: None):
    """Count how often the next frame computes colours, over all lit meshes in all subplots."""

    def counts():
        return {mesh: mesh.evaluations for subplot in plotter.phong._subplots for mesh in subplot.lit.meshes}

    before = counts()
    change()
    plotter.render()
    return sum(count - before.get(mesh, 0) for mesh, count in counts().items())


def assert_current(plotter, actor, mesh, material, **options):
    """Assert that drawn colours equal those of `shade` for the current scene, within rounding to 8 bits."""
    matrix = actor.GetMatrix()
    options = {"feature_angle": "auto", "precision": "float64"} | options
    lit = mesh.phong.shade(plotter.phong.scene, material, matrix=matrix, **options)
    assert np.abs(drawn(actor) - 255.0 * lit["phong"]).max() <= 0.51
    assert drawn(actor).dtype == np.uint8


# --- meshes ---


GRID = pv.ImageData(dimensions=(4, 4, 4), origin=(-0.5, -0.5, -0.5), spacing=(0.3, 0.3, 0.3))
BOX = pv.Cube().clean()  # its edges are split
BOX.point_data.clear()


@pytest.mark.parametrize(("mesh", "material"), [(ball(), DULL), (ball(), SHINY), (GRID, SHINY), (BOX, DULL)])
def test_a_mesh_is_drawn_with_its_lit_colours_and_not_modified(plotter, mesh, material):
    state = mesh.GetMTime(), mesh.array_names
    actor = draw(plotter, material, mesh)
    assert plotter.phong.mesh(actor).evaluations == (1 if material is DULL else 2)  # highlights see the camera move
    assert (mesh.GetMTime(), mesh.array_names) == state
    assert_current(plotter, actor, mesh, material)
    assert np.ptp(drawn(actor)) > 50
    assert actor.prop.lighting is False


# --- blocks ---


def blocks():
    """Return blocks of two meshes and a table."""
    left, right = ball(), pv.Cube(center=(1, 0, 0)).triangulate()
    return left, right, pv.MultiBlock({"left": left, "no": None, "more": pv.MultiBlock({"right": right})})


def test_every_block_is_lit_and_followed_and_they_share_the_material(plotter):
    left, right, both = blocks()
    for mesh in (left, right):
        mesh["tint"] = np.full((mesh.n_points, 3), 0.4)
    actors = draw(plotter, TINTED, both)
    assert [type(actor) for actor in actors] == [pv.Actor, pv.Actor]
    assert evaluations_after(plotter, lambda: setattr(right, "points", right.points * 1.5)) == 1
    for material in (TINTED, SHINY):
        plotter.phong.mesh(actors[1]).material = material
        plotter.render()
        for actor, mesh in zip(actors, (left, right), strict=True):
            assert_current(plotter, actor, mesh, material)


def test_blocks_can_have_materials_of_their_own_by_name(plotter):
    left, right, both = blocks()
    both["third"] = ball().translate((0, 1, 0))
    actors = draw(plotter, {"more/right": SHINY, "default": DULL}, both)
    assert [plotter.phong.mesh(actor).material for actor in actors] == [DULL, SHINY, DULL]
    plotter.phong.mesh(actors[0]).material = Material.named("jade")
    assert plotter.phong.mesh(actors[2]).material == Material.named("jade")
    plotter.render()
    assert_current(plotter, actors[0], left, Material.named("jade"))
    assert_current(plotter, actors[1], right, SHINY)


@pytest.mark.parametrize("remove", ["all", "one"])
def test_blocks_can_be_removed(plotter, remove):
    actors = draw(plotter, DULL, blocks()[2])
    plotter.remove_actor(actors if remove == "all" else actors[0])
    left = 0 if remove == "all" else 1
    assert len(plotter.renderer.actors) == left
    assert evaluations_after(plotter, lambda: plotter.phong.set_light("sun", LAMP)) == left


def test_a_name_is_for_all_blocks_and_replaces_what_it_was_for(plotter):
    def named():
        return sorted(plotter.renderer.actors)

    draw(plotter, DULL, name="it")
    draw(plotter, DULL, blocks()[2], name="it")
    assert named() == ["it[left]", "it[more/right]"]
    draw(plotter, DULL, pv.MultiBlock({"only": ball()}), name="it")
    assert named() == ["it[only]"]
    draw(plotter, DULL, name="it")
    assert named() == ["it"]


def test_a_name_replaces_nothing_in_other_subplots(new_plotter):
    shown = new_plotter(shape=(1, 2))
    other = shown.phong.add_mesh(ball(), name="ball")
    shown.subplot(0, 1)
    for mesh in (ball(), ball(), blocks()[2]):
        shown.phong.add_mesh(mesh, name="ball")
    assert shown.renderers[0].actors == {"ball": other}
    assert sorted(shown.renderers[1].actors) == ["ball[left]", "ball[more/right]"]


@pytest.mark.parametrize("mesh", [ball(), blocks()[2]], ids=["mesh", "blocks"])
def test_an_option_that_is_refused_replaces_nothing(plotter, mesh):
    first = draw(plotter, DULL, name="ball")
    with pytest.raises(TypeError, match="opacity_"):
        plotter.phong.add_mesh(mesh, name="ball", opacity_=3)
    assert plotter.renderer.actors == {"ball": first}


TWO = blocks()[2]
UNFIT = [
    (pv.PolyData([[0.0, 0, 0]]), DULL, {}, "^mesh must be a mesh with faces"),
    (3, DULL, {}, "^mesh must be a pyvista.DataSet"),
    (ball(), "gld", {}, "^material must be a Material"),
    (ball(), TINTED, {}, r"^albedo must be the name of a point array \(Normals.*; got 'tint'"),
    (ball(), replace(DULL, albedo=np.ones((4, 3))), {}, "^albedo must be .* rows; got 4 rows"),
    (ball(), DULL, {"feature_angle": "sharp"}, "^feature_angle must be"),
    (pv.MultiBlock([None, pv.PolyData()]), DULL, {}, "^mesh must be a MultiBlock that contains a mesh"),
    (pv.MultiBlock({"dots": pv.PolyData([[0.0, 0, 0]])}), DULL, {}, "^block 'dots': mesh must be a mesh with faces"),
    (TWO, replace(DULL, albedo=np.ones((4, 3))), {}, "albedo must be .* rows; got 4 rows"),
    (TWO, TINTED, {}, "albedo must be the name of a point array"),
    (TWO, {"rigth": SHINY}, {}, "^material must be a mapping with the names of all blocks"),
]
COLOURING = {"color": "red", "scalars": "Normals", "rgb": True, "cmap": "jet", "pbr": True, "diffuse": 0.1}
UNFIT += [
    (ball(), DULL, {name: COLOURING[name]}, f"^{name} must be omitted when material= is given") for name in COLOURING
]


@pytest.mark.parametrize(("mesh", "material", "options", "message"), UNFIT)
def test_what_cannot_be_drawn_is_refused_and_changes_nothing(plotter, mesh, material, options, message):
    with pytest.raises(ValueError, match=message):
        plotter.phong.add_mesh(mesh, material, **options)
    assert not plotter.renderer.actors
    plotter.render()


# --- add_lit ---


def test_what_is_lit_already_is_drawn_as_it_is_and_stays_so(plotter):
    lit = pv.Plane(i_size=50, j_size=50).phong.shade(SUN, DULL, name="colours")
    lit["other"] = np.arange(lit.n_points)
    state = lit.active_scalars_name, lit.array_names
    actor = plotter.phong.add_lit(lit, "colours", opacity=1.0)
    plotter.camera_position = [(0, 0, 5), (0, 0, 0), (0, 1, 0)]
    plotter.show(auto_close=False)
    before = plotter.screenshot(return_img=True)
    assert np.abs(before[24, 24] - 255.0 * lit["colours"].mean(axis=0)).max() <= 2
    assert (lit.active_scalars_name, lit.array_names) == state
    assert not plotter.scalar_bars
    assert evaluations_after(plotter, lambda: plotter.phong.set_light("sun", LAMP)) == 0
    np.testing.assert_array_equal(plotter.screenshot(return_img=True), before)
    plotter.remove_actor(actor)
    assert len(plotter.phong.add_lit(blocks()[2].phong.shade(SUN))) == len(plotter.renderer.actors) == 2


@pytest.mark.parametrize(
    ("lit", "options", "message"),
    [
        (ball(), {}, r"^name must be one of 'Normals'; got phong"),
        (ball(), {"name": "Normal"}, r"^name must be one of 'Normals'; got Normal\. Did you mean 'Normals'"),
        (ball(), {"rgb": False}, r"^option must be .*; got rgb\. The colours come from the array `name`"),
        ("ball.vtp", {}, r"^lit must be a pyvista\.DataSet or a pyvista\.MultiBlock; got str"),
        (pv.MultiBlock(), {}, r"^lit must be a MultiBlock with at least one mesh"),
    ],
)
def test_what_is_not_lit_is_refused(plotter, lit, options, message):
    with pytest.raises(ValueError, match=message):
        plotter.phong.add_lit(lit, **options)
    assert not plotter.renderer.actors


# --- updates ---


def moved(plotter):
    plotter.camera.position = (4.0, 1.0, 2.0)


@pytest.mark.parametrize(
    ("lighting", "material", "count"),
    [("none", DULL, 0), ("none", SHINY, 1), ("light kit", DULL, 1), ("three lights", DULL, 1)],
)
def test_the_camera_counts_where_there_are_highlights_or_lights_ride_along(new_plotter, lighting, material, count):
    shown, mesh = new_plotter(lighting=lighting), ball()
    shown.phong.add_light(SUN)
    actor = draw(shown, material, mesh)
    before = drawn(actor).copy()
    assert evaluations_after(shown, lambda: moved(shown)) == count
    assert (np.abs(drawn(actor).astype(int) - before).max() > 10) == bool(count)
    assert_current(shown, actor, mesh, material)


CHANGES = {
    "a light": lambda plotter, *_: plotter.phong.set_light("sun", replace(SUN, diffuse=0.5)),
    "a new light": lambda plotter, *_: plotter.phong.add_light(LAMP),
    "no light": lambda plotter, *_: plotter.phong.remove_light("sun"),
    "a light of VTK": lambda plotter, *_: plotter.renderer.lights[0].SetDiffuseColor(0.2, 0.9, 0.3),
    "a switch": lambda plotter, *_: plotter.renderer.lights[0].SetSwitch(False),
    "a new PyVista light": lambda plotter, *_: plotter.add_light(
        pv.Light(position=(3, 0, 1), light_type="scene light")
    ),
    "the actor's place": lambda _, actor, __: setattr(actor, "position", (0.5, 0, 0)),
    "the actor's turn": lambda _, actor, __: actor.rotate_x(40),
    "the user matrix": lambda _, actor, __: setattr(actor, "user_matrix", np.diag([1.0, -2, 1, 1])),
    "the points": lambda _, __, mesh: mesh.points.__setitem__(slice(None), mesh.points * [1, 2, 3]),
    "new points": lambda _, __, mesh: setattr(mesh, "points", mesh.points * [1, 2, 3]),
    "the normals": lambda _, __, mesh: setattr(mesh.point_data, "active_normals", -np.asarray(mesh["Normals"])),
    "the material": lambda plotter, actor, _: setattr(plotter.phong.mesh(actor), "material", Material.named("gold")),
    "the light model": lambda plotter, *_: setattr(plotter.phong, "light_model", LightModel(ambient=0.9)),
}


@pytest.mark.filterwarnings("ignore::pvphong.NormalsWarning")  # of normals that are turned
@pytest.mark.parametrize("change", CHANGES)
def test_a_change_is_seen_at_the_next_frame_once(new_plotter, change):
    shown, mesh = new_plotter(), ball()
    shown.phong.add_light(SUN)
    shown.phong.add_light(SpotLight(position=(0, 3, 3), direction=(0, -1, -1), name="spot"))
    actor = draw(shown, DULL, mesh)
    before = drawn(actor).copy()
    assert evaluations_after(shown, lambda: CHANGES[change](shown, actor, mesh)) == 1
    assert np.abs(drawn(actor).astype(int) - before).max() > 5
    assert_current(shown, actor, mesh, shown.phong.mesh(actor).material)
    assert evaluations_after(shown) == 0


def test_an_edited_albedo_is_seen_and_may_be_given(plotter):
    mesh = ball()
    mesh["tint"] = np.random.default_rng(0).integers(0, 256, (mesh.n_points, 3)).astype(np.uint8)
    actor = draw(plotter, TINTED, mesh)
    assert_current(plotter, actor, mesh, TINTED)
    assert evaluations_after(plotter, lambda: mesh["tint"].__setitem__(slice(None), 90)) == 1
    assert_current(plotter, actor, mesh, TINTED)
    assert_current(plotter, draw(plotter, replace(DULL, albedo=mesh["tint"] / 255.0), mesh), mesh, TINTED)


NO_CHANGES = {
    "nothing": lambda *_: None,
    "zooming": lambda plotter, *_: setattr(plotter.camera, "view_angle", 12),
    "another array": lambda _, __, mesh: mesh.point_data.set_array(np.arange(mesh.n_points), "number"),
    "the same light": lambda plotter, *_: plotter.phong.set_light("sun", replace(SUN)),
    "the same light model": lambda plotter, *_: setattr(plotter.phong, "light_model", LightModel()),
    "the same material": lambda plotter, actor, _: setattr(plotter.phong.mesh(actor), "material", SHINY),
    "the same place": lambda _, actor, __: setattr(actor, "position", (0, 0, 0)),
    "another actor's place": lambda plotter, *_: setattr(plotter.renderer.actors["cube"], "position", (1, 1, 1)),
    "another actor's colour": lambda plotter, *_: setattr(plotter.renderer.actors["cube"].prop, "color", "red"),
}


def test_what_changes_nothing_costs_nothing(plotter):
    mesh = ball()
    actor = draw(plotter, SHINY, mesh)
    plotter.add_mesh(pv.Cube(), name="cube")
    plotter.render()
    for name, change in NO_CHANGES.items():
        assert evaluations_after(plotter, lambda change=change: change(plotter, actor, mesh)) == 0, name


# --- lights ---


def test_lights_are_the_plotters_own_too(new_plotter):
    shown, mesh = new_plotter(lighting="light kit"), ball()
    assert len(shown.phong.lights) == 5
    shown.add_light(pv.Light(position=(1, 2, 1), light_type="camera light", positional=True, cone_angle=40))
    draw(shown, SHINY, mesh)
    moved(shown)
    snapshots = shown.phong.scene, Scene.from_plotter(shown)
    ours, snapshot = (mesh.phong.shade(each, SHINY, precision="float64")["phong"] for each in snapshots)
    np.testing.assert_allclose(ours, snapshot, atol=1e-12)
    shown.phong.add_light(SUN)
    shown.add_light(pv.Light(position=(1, 2, 3), light_type="scene light"))
    assert len(shown.phong.lights) == 8
    assert shown.phong.lights[6] == SUN
    assert shown.phong.lights[7].direction == (-1.0, -2.0, -3.0)


@pytest.mark.parametrize("frame", ["world", "camera", "headlight"])
def test_lights_are_kept_to_the_bit(new_plotter, frame):
    lights = [example(kind, 1 / 3, frame=frame, name=kind, diffuse=(0.1, 1 / 3, 0.7), power=1000) for kind in KINDS]
    shown = new_plotter()
    for light in lights:
        shown.phong.add_light(light)
    draw(shown)
    moved(shown)
    shown.render()
    assert shown.phong.lights == tuple(lights)


def test_lights_are_named_in_many_ways(plotter):
    names = (lambda handle: handle, lambda _: 1, lambda _: -1, lambda _: "lamp", lambda handle: handle.vtk_light)
    for name in names:
        which = name(plotter.phong.add_light(LAMP))
        plotter.phong.set_light(which, replace(LAMP, intensity=2))
        assert [light.intensity for light in plotter.phong.lights] == [1.0, 2.0]
        plotter.phong.remove_light(which)
        assert plotter.phong.lights == (SUN,)
        assert len(plotter.renderer.lights) == 1


@pytest.mark.parametrize("which", ["moon", 1, -2, None, True, vtk.vtkLight()])
def test_a_light_that_is_not_there(plotter, which):
    for act in (plotter.phong.remove_light, lambda which: plotter.phong.set_light(which, LAMP)):
        with pytest.raises(ValueError, match=r"^which must be a light of this renderer: .*'sun'"):
            act(which)
    assert plotter.phong.lights == (SUN,)


def test_bad_lights_are_refused_and_change_nothing(plotter):
    for bad in ("lamp", None, vtk.vtkCamera()):
        with pytest.raises(ValueError, match=r"^light must be a pvphong light"):
            plotter.phong.add_light(bad)
    with pytest.raises(ValueError, match=r"^light must be a pvphong light; .*as_light"):
        plotter.phong.set_light("sun", pv.Light())
    twice = pv.Light()
    plotter.phong.add_light(twice)
    with pytest.raises(ValueError, match=r"^light must be a light that is not in the plotter yet"):
        plotter.phong.add_light(twice)
    assert len(plotter.phong.lights) == 2


# --- live handles ---


@pytest.mark.parametrize("kind", KINDS)
def test_every_field_of_a_light_reads_and_sets_and_the_next_frame_shows_it(new_plotter, kind):
    shown, mesh = new_plotter(), ball()
    before, after = example(kind, 1 / 3, name="it"), example(kind, 2 / 3, name="that", intensity=0.6, diffuse="tan")
    lamp = shown.phong.add_light(before)
    actor = draw(shown, SHINY, mesh)
    for field in fields(after):
        assert getattr(lamp, field.name) == getattr(before, field.name)
        assert field.name in dir(lamp)
        setattr(lamp, field.name, getattr(after, field.name))
        before = replace(before, **{field.name: getattr(after, field.name)})
        assert shown.phong.lights == (before,) == (lamp.light(),)
    assert lamp.light() == after
    shown.render()
    assert_current(shown, actor, mesh, SHINY)
    assert not shown.phong._history.can_redo


@pytest.mark.parametrize("name", ["ambient", "diffuse", "specular", "shininess", "emission", "albedo", "reflectance"])
def test_every_field_of_a_drawn_material_reads_and_sets(plotter, name):
    mesh = ball()
    mesh["tint"] = np.random.default_rng(0).random((mesh.n_points, 3))
    handle = plotter.phong.mesh(draw(plotter, SHINY, mesh))
    assert getattr(handle, name) == getattr(SHINY, name)
    value = {"shininess": 3.0, "albedo": "tint", "reflectance": GGX(roughness=0.4)}.get(name, (0.7, 0.2, 0.4))
    assert evaluations_after(plotter, lambda: setattr(handle, name, value)) == 1
    assert getattr(handle, name) == value
    assert handle.material == replace(SHINY, **{name: value})
    assert_current(plotter, handle.actor, mesh, handle.material)


def test_blocks_that_share_a_material_still_share_it(plotter):
    one, other = (plotter.phong.mesh(actor) for actor in draw(plotter, DULL, blocks()[2]))
    one.specular = 0.5
    assert one != other
    assert one.material == other.material == replace(DULL, specular=0.5)
    assert {one} == {plotter.phong.mesh(one.actor)}


WRONG = [
    ("light", "color", "'color'. Did you mean 'diffuse'"),
    ("light", "positon", "'positon'. Did you mean 'position'"),
    ("light", "direction", "'direction'. It has ambient, attenuation, casts_shadows, "),
    ("mesh", "color", "'color'. Did you mean 'diffuse'"),
    ("mesh", "specular_power", "'specular_power'. Did you mean 'shininess'"),
    ("mesh", "shinyness", "'shinyness'. Did you mean 'shininess'"),
    ("mesh", "cast_shadows", "'cast_shadows'. Did you mean 'casts_shadows'"),
]


@pytest.mark.parametrize(("which", "name", "message"), WRONG)
def test_an_attribute_that_a_handle_has_not_is_refused_by_name(plotter, which, name, message):
    handle = plotter.phong.add_light(LAMP) if which == "light" else plotter.phong.mesh(draw(plotter))
    for act in (lambda: getattr(handle, name), lambda: setattr(handle, name, 1.0)):
        with pytest.raises(AttributeError, match=re.escape(f" has no attribute {message}")):
            act()
    assert not hasattr(handle, "_nothing")


def test_what_a_handle_cannot_set_is_refused_and_changes_nothing(plotter):
    lamp, mesh = plotter.phong.add_light(LAMP), plotter.phong.mesh(draw(plotter))
    with pytest.raises(ValueError, match=r"^position must be 3 finite numbers"):
        lamp.position = (1, 2)
    with pytest.raises(AttributeError, match=r"'light' is read-only\. .*set_light"):
        lamp.light = SUN
    with pytest.raises(ValueError, match=r"^diffuse must be a number"):
        mesh.diffuse = (255, 0, 0)
    with pytest.raises(AttributeError, match=r"'matrix' of a drawn mesh is read-only"):
        mesh.matrix = np.eye(4)
    assert (lamp.light(), mesh.material) == (LAMP, DULL)


def test_a_handle_names_its_light_everywhere_until_it_is_removed(plotter):
    lamp = plotter.phong.add_light(LAMP)
    assert [gizmo.light for gizmo in plotter.phong.add_gizmos([lamp])] == [LAMP]
    plotter.phong.set_light(lamp, SUN := replace(LAMP, diffuse="red"))
    assert (lamp.light(), lamp.vtk_light) == (SUN, plotter.renderer.lights[1])
    plotter.phong.remove_light(lamp)
    assert lamp.diffuse == (1.0, 0.0, 0.0)
    with pytest.raises(
        ValueError, match=r"^light must be a light of the plotter; .* The light has been removed; add it again with "
    ):
        lamp.intensity = 2
    assert plotter.phong.undo()
    lamp.intensity = 2
    assert plotter.phong.lights[1] == replace(SUN, intensity=2)


def test_an_assignment_is_one_step_of_undo_where_gizmos_are_up(plotter):
    lamp, mesh = plotter.phong.add_light(LAMP), plotter.phong.mesh(draw(plotter))
    plotter.phong.add_gizmos()
    lamp.position, mesh.diffuse, lamp.intensity = (1, 2, 3), "red", 2
    for light, material in [
        (replace(LAMP, position=(1, 2, 3)), replace(DULL, diffuse="red")),
        (replace(LAMP, position=(1, 2, 3)), DULL),
        (LAMP, DULL),
    ]:
        assert plotter.phong.undo()
        assert (lamp.light(), mesh.material) == (light, material)
    assert not plotter.phong.undo()
    plotter.phong.remove_gizmos()
    lamp.position = (1, 2, 3)
    assert not plotter.phong.undo()


@pytest.mark.parametrize(
    ("handle", "name", "meant"),
    [
        (lambda plotter: plotter.phong, "lightmodel", "light_model"),
        (lambda plotter: plotter.phong, "shadows", "light_model"),
        (lambda plotter: plotter.phong.add_gizmos()[0], "is_selectd", "is_selected"),
        (lambda _: ball().phong, "planned", "plan"),
        (lambda _: blocks()[2].phong, "shades", "shade"),
        (lambda _: PhongFilter(), "scene", "SetScene"),
    ],
)
def test_no_handle_takes_an_attribute_that_it_has_not(plotter, handle, name, meant):
    given = handle(plotter)
    with pytest.raises(
        AttributeError, match=rf"^{type(given).__name__} has no attribute '{name}'\. Did you mean '{meant}'"
    ):
        setattr(given, name, None)


def test_set_light_changes_fields(plotter):
    plotter.phong.set_light("sun", intensity=2, diffuse="tan")
    assert plotter.phong.lights == (replace(SUN, intensity=2, diffuse="tan"),)
    for given, message in [
        ({}, "^light must be a light if no fields are given; got None"),
        ({"light": LAMP, "intensity": 2}, "^light must be omitted when fields are given"),
        ({"color": "red"}, r"^DirectionalLight has no attribute 'color'\. Did you mean 'diffuse'"),
        ({"intensity": -1}, "^intensity must be"),
    ]:
        with pytest.raises(ValueError, match=message):
            plotter.phong.set_light("sun", **given)
    assert plotter.phong.lights == (replace(SUN, intensity=2, diffuse="tan"),)


def test_no_two_lights_have_one_name(plotter):
    lamp = plotter.phong.add_light(LAMP)
    for act in (
        lambda: plotter.phong.add_light(LAMP),
        lambda: plotter.phong.set_light(lamp, SUN),
        lambda: plotter.phong.set_light(lamp, name="sun"),
        lambda: setattr(lamp, "name", "sun"),
    ):
        with pytest.raises(ValueError, match=r"^name must be unique among the lights of the plotter; got (sun|lamp)"):
            act()
    assert plotter.phong.lights == (SUN, LAMP)
    for _ in range(2):
        plotter.phong.add_light(replace(LAMP, name=""))  # without a name there may be many


def test_undo_gives_no_two_lights_one_name(plotter):
    lamp, other = plotter.phong.add_light(LAMP), plotter.phong.add_light(replace(LAMP, name="other"))
    plotter.phong.remove_light(lamp)
    other.name = "lamp"  # without gizmos edits are not recorded
    assert plotter.phong.undo()
    assert [light.name for light in plotter.phong.lights] == ["sun", "lamp 2", "lamp"]
    assert plotter.phong.redo()
    assert [light.name for light in plotter.phong.lights] == ["sun", "lamp"]
    plotter.phong.set_light("sun", name="moon")
    other.name = "sun"
    assert plotter.phong.undo()
    assert [light.name for light in plotter.phong.lights] == ["sun 2", "sun"]


# --- scene and light model ---


def test_the_scene_is_a_frozen_snapshot(plotter):
    draw(plotter)
    before = plotter.phong.scene
    assert before == Scene(lights=[SUN], viewer=Viewer.from_camera(plotter.camera), light_model=LightModel())
    moved(plotter)
    plotter.phong.light_model = LightModel.opengl()
    after = plotter.phong.scene
    assert after.viewer == Viewer.from_camera(plotter.camera) != before.viewer
    assert after.light_model == LightModel.opengl()
    with pytest.raises(FrozenInstanceError):
        after.lights = ()
    with pytest.raises(ValueError, match=r"^light_model must be a LightModel; got vtk"):
        plotter.phong.light_model = "vtk"
    assert plotter.phong.scene == after


def test_subplots_have_their_own_lights_and_meshes(new_plotter):
    shown = new_plotter(shape=(1, 2))
    actors = []
    for column, light in enumerate((SUN, LAMP)):
        shown.subplot(0, column)
        shown.phong.add_light(light)
        actors.append(draw(shown))
    assert shown.phong.lights == (LAMP,)
    shown.subplot(0, 0)
    assert shown.phong.lights == (SUN,)
    assert np.abs(drawn(actors[0]).astype(int) - drawn(actors[1])).max() > 20
    before = drawn(actors[1]).copy()
    assert evaluations_after(shown, lambda: shown.phong.set_light(0, replace(SUN, diffuse=0.2))) == 1
    np.testing.assert_array_equal(drawn(actors[1]), before)
    assert shown.phong.mesh(actors[1]).actor is actors[1]  # another subplot's


# --- closing ---


@pytest.mark.parametrize("is_closed", [True, False])
def test_a_plotter_is_let_go_closed_or_not(is_closed):
    shown = pv.Plotter(off_screen=True, window_size=(48, 48))
    draw(shown, SHINY)
    gizmos = shown.phong.add_gizmos()
    shown.screenshot()
    watched = [weakref.ref(each) for each in (shown, shown.phong, *gizmos)]
    if is_closed:
        for end in (shown.deep_clean, shown.close, shown.close, shown.deep_clean):
            end()
        with pytest.raises(ValueError, match=r"^plotter must be open; got a closed plotter"):
            _ = shown.phong.lights
        del end
    else:
        pv.plotting.plotter._ALL_PLOTTERS.pop(shown._id_name)  # PyVista itself holds on to every open plotter
    del shown, gizmos
    gc.collect()
    assert [ref() for ref in watched] == [None] * len(watched)


# --- an ordinary actor ---


def test_a_hidden_actor_waits_until_it_is_shown(plotter):
    mesh = ball()
    actor = draw(plotter, DULL, mesh)
    actor.visibility = False
    assert evaluations_after(plotter, lambda: plotter.phong.set_light("sun", LAMP)) == 0
    assert evaluations_after(plotter, lambda: setattr(actor, "visibility", True)) == 1
    assert_current(plotter, actor, mesh, DULL)


def test_options_of_add_mesh_are_passed_on_and_a_name_replaces_the_actor_before(plotter):
    first = draw(plotter, DULL, name="ball")
    second = draw(plotter, SHINY, name="ball", opacity=0.5, show_edges=True)
    assert (second.prop.opacity, second.prop.show_edges) == (0.5, True)
    assert plotter.renderer.actors["ball"] is second
    with pytest.raises(ValueError, match=r"^actor must be"):
        plotter.phong.mesh(first)
    assert evaluations_after(plotter, lambda: plotter.phong.set_light("sun", LAMP)) == 1
    plotter.remove_actor("ball")
    assert evaluations_after(plotter, lambda: plotter.phong.set_light("lamp", SUN)) == 0


def test_a_cleared_plotter_can_be_filled_again(plotter):
    draw(plotter)
    plotter.clear()
    plotter.render()
    assert plotter.phong.lights == ()
    plotter.phong.add_light(SUN)
    mesh = ball()
    assert_current(plotter, draw(plotter, SHINY, mesh), mesh, SHINY)


@pytest.mark.parametrize("is_shown", [True, False])
def test_it_is_exported_in_colours_that_are_current(plotter, tmp_path, is_shown):
    mesh = ball()
    actor = draw(plotter, DULL, mesh) if is_shown else plotter.phong.add_mesh(mesh, DULL)
    plotter.phong.set_light("sun", LAMP)  # and no frame is drawn
    plotter.export_gltf(tmp_path / "ball.gltf")
    assert_current(plotter, actor, mesh, DULL)
    scene = json.loads((tmp_path / "ball.gltf").read_text())
    part = scene["meshes"][0]["primitives"][0]
    # A glTF viewer shows COLOR_0, as unsigned bytes, times the material's base colour (glTF 2.0, 3.9.2).
    view = scene["bufferViews"][scene["accessors"][part["attributes"]["COLOR_0"]]["bufferView"]]
    data = base64.b64decode(scene["buffers"][view["buffer"]]["uri"].split(",")[1])
    base = scene["materials"][part["material"]]["pbrMetallicRoughness"]["baseColorFactor"]
    np.testing.assert_array_equal((np.frombuffer(data, np.uint8).reshape(-1, 4) * base)[:, :3], drawn(actor))
    plotter.phong.set_light("lamp", SUN)
    plotter.export_vrml(tmp_path / "ball.wrl")
    assert_current(plotter, actor, mesh, DULL)


# --- an opacity for each vertex ---

RED = Material(ambient=0, diffuse=0, emission="red")
FINE_BOX = BOX.triangulate().subdivide(2)
FINE_BOX.clear_data()


def picture(plotter, add):
    actor = add()
    plotter.set_background("white")
    plotter.camera_position = [(2, 1.5, 1.8), (0, 0, 0), (0, 0, 1)]
    plotter.show(auto_close=False)
    shown = plotter.screenshot(return_img=True).astype(int)
    plotter.remove_actor(actor)
    return shown


@pytest.mark.parametrize("mesh", [FINE_BOX, GRID, ball()], ids=["split edges", "grid", "ball"])
@pytest.mark.parametrize("of", ["points", "cells"])
@pytest.mark.parametrize("is_named", [True, False])
def test_opacities_are_drawn_as_pyvista_draws_them(plotter, mesh, of, is_named):
    mesh = mesh.copy()
    count = mesh.n_points if of == "points" else mesh.n_cells
    opacity = numbers = np.linspace(0.1, 1, count)
    if is_named:
        (mesh.point_data if of == "points" else mesh.cell_data)["glass"] = numbers
        opacity = "glass"
    angle = {"feature_angle": 0} if of == "cells" else {}
    if of == "cells" and mesh.n_cells != FINE_BOX.n_cells:
        with pytest.raises(
            ValueError, match=r"^opacity must be an array with one row per point, because faces share points"
        ):
            plotter.phong.add_mesh(mesh, RED, opacity=opacity, feature_angle=None)
        assert not plotter.renderer.actors
        return
    ours = picture(plotter, lambda: plotter.phong.add_mesh(mesh, RED, opacity=opacity, **angle))
    theirs = picture(plotter, lambda: plotter.add_mesh(mesh, color="red", lighting=False, opacity=numbers))
    assert np.abs(ours - theirs).max() <= 1
    assert np.ptp(ours[..., 1]) > 100


def test_opacities_are_followed_and_refined_too(plotter):
    mesh = FINE_BOX.copy()
    mesh["glass"] = np.linspace(0.1, 1, mesh.n_points)
    actor = plotter.phong.add_mesh(mesh, DULL, opacity="glass", refine=1 / 255)
    plotter.show(auto_close=False)
    for _ in range(2):
        plotter.screenshot()
        shown = actor.mapper.dataset
        assert shown.active_scalars.shape == (shown.n_points, 4)
        own = plotter.phong.mesh(actor).drawn
        alpha = np.rint(255 * np.asarray(mesh["glass"])[own["pvphong_original_point"]])
        np.testing.assert_array_equal(own["phong_rgba"], np.column_stack([own["phong"], alpha]))
        mesh["glass"][:] = mesh["glass"][::-1].copy()


def test_what_is_lit_already_may_have_opacities(plotter):
    lit, opacity = ball().phong.shade(SUN), np.linspace(0, 1, ball().n_points)
    ours = picture(plotter, lambda: plotter.phong.add_lit(lit, opacity=opacity))
    rgba = np.column_stack([lit["phong"], opacity])
    theirs = picture(plotter, lambda: plotter.add_mesh(ball(), scalars=rgba, rgb=True, lighting=False))
    assert np.abs(ours - theirs).max() <= 1


@pytest.mark.parametrize(
    ("opacity", "message"),
    [
        (
            "glas",
            r"^opacity must be a number, an array, or an array's name \(.*glass.*\); got 'glas'\. Did you mean 'glass'",
        ),
        (
            np.ones(7),
            r"^opacity must be a number, or an array with one for each point \(162\) or cell \(320\); got an array of",
        ),
        (np.full(162, 255.0), r"^opacity must be numbers from 0 to 1; .*Divide 0-255"),
        (np.full(162, np.nan), r"^opacity must be numbers from 0 to 1"),
    ],
)
def test_bad_opacities_are_refused_and_draw_nothing(plotter, opacity, message):
    mesh = ball()
    mesh["glass"] = np.ones(mesh.n_points)
    for add in (
        lambda mesh, **options: plotter.phong.add_mesh(mesh, DULL, **options),
        lambda mesh, **options: plotter.phong.add_lit(mesh.phong.shade(SUN), **options),
    ):
        with pytest.raises(ValueError, match=message):
            add(mesh, opacity=opacity)
        with pytest.raises(ValueError, match=r"^use_transparency must be False"):
            add(mesh, opacity=opacity, use_transparency=True)
    assert not plotter.renderer.actors


NO_VTK_SHADOWS = (
    r"^VTK's shadows cannot be combined .* plotter\.phong\.light_model = pvphong\.LightModel\(shadows=True\)"
)


def test_vtks_shadows_are_refused_where_they_cannot_be_drawn(plotter, capfd):
    for add in (lambda: draw(plotter), lambda: plotter.phong.add_lit(ball().phong.shade(SUN))):
        actor = add()
        for enable in (plotter.enable_shadows, plotter.renderer.enable_shadows):
            with pytest.raises(ValueError, match=NO_VTK_SHADOWS):
                enable()
        plotter.remove_actor(actor)
        plotter.enable_shadows()
        with pytest.raises(ValueError, match=NO_VTK_SHADOWS):
            add()
        assert not plotter.renderer.actors
        plotter.add_mesh(ball())  # VTK lights it
        plotter.screenshot()
        plotter.disable_shadows()
        plotter.clear_actors()
    assert "shader" not in "".join(capfd.readouterr())
    plotter.close()
    assert "enable_shadows" not in vars(plotter.renderers[0])


# --- against VTK ---


def test_what_is_on_the_screen_is_validated(plotter):
    actor = draw(plotter, SHINY)
    actor.rotate_x(30)
    moved(plotter)
    plotter.phong.light_model = LightModel.vtk(two_sided=False)
    comparison = plotter.phong.validate()
    assert comparison.passed
    assert comparison.n > 100
    lit = ball().phong.shade(plotter.phong.scene, SHINY, matrix=actor.GetMatrix(), precision="float64")["phong"]
    np.testing.assert_allclose(np.clip(comparison.pvphong, 0, 1), lit, atol=1e-5)


def test_of_several_meshes_the_worst_is_shown(plotter):
    draw(plotter, DULL)
    shiny = draw(plotter, SHINY)
    each = plotter.phong.validate(shiny), plotter.phong.validate(next(iter(plotter.renderer.actors.values())))
    worst = plotter.phong.validate()
    assert worst.max_error / worst.tolerance == max(one.max_error / one.tolerance for one in each)


def test_what_cannot_be_validated(plotter):
    with pytest.raises(ValueError, match=r"^plotter must be a plotter whose active subplot shows a lit mesh"):
        plotter.phong.validate()
    mesh = ball()
    draw(plotter, replace(DULL, albedo=np.ones((mesh.n_points, 3))), mesh)
    with pytest.raises(ValueError, match=r"^albedo must be uint8, as VTK's .*; got a map of floats"):
        plotter.phong.validate()
    with pytest.raises(ValueError, match=r"^actor must be"):
        plotter.phong.validate(pv.Actor())


def test_edits_are_undone_and_redone_to_the_bit(new_plotter):
    phong = new_plotter(lighting="light kit").phong
    states = [phong.lights]
    for edit in (
        lambda: phong.add_light(SUN),
        lambda: phong.set_light("sun", replace(SUN, diffuse=(0.9, 0.1, 1 / 3))),
        lambda: phong.set_light(2, replace(phong.lights[2], intensity=1 / 3)),
        lambda: phong.remove_light(0),
    ):
        edit()
        states.append(phong.lights)
    for step, expected in [(phong.undo, states[-2::-1]), (phong.redo, states[1:])]:
        for lights in expected:
            assert step()
            assert phong.lights == lights
        assert not step()
    assert phong.undo()
    phong.set_light("sun", LAMP)  # a new edit clears the redo steps
    assert not phong.redo()
    with pytest.raises(ValueError, match=r"^light must be"):
        phong.add_light("lamp")  # a rejected edit is no step
    assert phong.undo()
    assert phong.lights == states[-2]


def test_a_stage_replaces_no_actor_of_ones_own(new_plotter):
    plotter = new_plotter()
    plotter.phong.add_mesh(pv.Sphere(), name="stage")
    with pytest.raises(ValueError, match=r"^plotter must be without another actor 'stage'; got one that has it. Add"):
        plotter.phong.add_stage("ground")
    assert "stage" in plotter.actors
    plotter.remove_actor("stage")
    plotter.phong.add_mesh(pv.Sphere(), name="ball")
    plotter.phong.add_stage("ground")
    plotter.phong.add_stage("plinth")  # a stage replaces a stage
    assert set(plotter.actors) == {"ball", "stage"}
