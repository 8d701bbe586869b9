"""The window of `pvphong view`: its content, and the files its keys save. No window opens in these tests."""

import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from pvphong import DirectionalLight, Display, LightModel, Material, PointLight, Scene, Viewer, load_materials
from pvphong.cli import view
from pvphong.cli.app import main
from pvphong.cli.view import show
from pvphong.meshes.files import eight_bit
from pvphong.plotter import PlotterPhong

DULL, JADE, GOLD = Material(), Material.named("jade"), Material.named("gold")
SCENE = Scene(
    lights=[
        DirectionalLight(direction=(1, -1, -1), frame="camera", name="key"),
        PointLight(position=(3, 0, 0), attenuation=(1, 0, 0.1), name="bulb"),
    ],
    viewer=Viewer(position=(4, 1, 2), up=(0, 0, 1), view_angle=25),
    light_model=LightModel(ambient=0.3, two_sided=True),
)


@pytest.fixture
def shown(monkeypatch):
    """Collect the plotters that are shown."""
    plotters = []
    monkeypatch.setattr(pv, "OFF_SCREEN", False)
    monkeypatch.setattr(view, "drawing_window", lambda: "vtkXOpenGLRenderWindow")
    monkeypatch.setattr(pv.Plotter, "show", lambda plotter: plotters.append(plotter))
    yield plotters
    for plotter in plotters:
        plotter.close()


def drawn(plotter):
    return [actor for actor in plotter.actors.values() if isinstance(actor, pv.Actor)]


def test_the_window_shows_the_mesh_in_the_scene_that_was_given(shown):
    sphere = pv.Sphere()
    show(sphere, SCENE, GOLD, title="a sphere")
    (plotter,) = shown
    assert plotter.title == "a sphere"
    assert (plotter.phong.lights, plotter.phong.light_model) == (SCENE.lights, SCENE.light_model)
    assert len(plotter.phong.gizmos) == len(SCENE.lights)
    viewer = plotter.phong.scene.viewer
    assert (viewer.position, viewer.focal_point, viewer.up) == ((4, 1, 2), (0, 0, 0), (0, 0, 1))
    (actor,) = drawn(plotter)
    colors = eight_bit(sphere.phong.shade(SCENE, GOLD)["phong"])
    np.testing.assert_allclose(actor.mapper.dataset["phong"], colors, atol=1)


def test_edges_are_sharp_and_the_background_is_dark_unless_others_are_asked_for_and_nothing_is_clipped(shown):
    box, far = pv.Cube(x_length=1000).clean(), replace(SCENE, viewer=Viewer(position=(4000, 0, 0)))
    box.point_data.clear()
    for options, points, is_dark in (({}, 24, True), ({"feature_angle": None, "background": "white"}, 8, False)):
        show(box, far, DULL, title="a box", **options)
        (actor,) = drawn(shown[-1])
        assert actor.mapper.dataset.n_points == points
        assert (max(shown[-1].background_color.float_rgb) < 0.25) == is_dark
        near, end = shown[-1].camera.clipping_range
        assert near < 3500 < 4500 < end
    with pytest.raises(ValueError, match=r"^background must be .* got whyte"):
        show(box, SCENE, DULL, title="a box", background="whyte")
    assert len(shown) == 2


def test_words_become_arguments_of_the_window(monkeypatch):
    calls = []
    monkeypatch.setattr(view, "show", lambda *args, **options: calls.append((*args, options)))
    for words in (
        "--scene red.json",
        "--scene red.json --material jade --feature-angle none --background navy --albedo tint",
        "--scene red.json --shadows --occluder roof.vtp --exposure 1/2 --tone filmic",
    ):
        assert main(["view", "sphere.vtp", *words.split()]) == 0
    (mesh, scene, red, plain), (_, _, jade, changed), (_, shadowy, _, roofed) = calls
    assert mesh.n_points == pv.read("sphere.vtp").n_points
    assert (scene, red) == (Scene.load("red.json"), load_materials("red.json")["default"])
    assert plain == {
        "title": "pvphong: sphere.vtp", "stem": "sphere", "background": view.BACKGROUND,
        "feature_angle": "auto", "occluders": [], "display": Display(),
    }  # fmt: skip
    assert jade == replace(JADE, albedo="tint")
    assert changed | {"feature_angle": None, "background": "navy"} == changed
    assert shadowy.light_model.shadows
    assert roofed["display"] == Display(0.5, "filmic")
    assert [occluder.n_points for occluder in roofed["occluders"]] == [pv.read("roof.vtp").n_points]


@pytest.mark.parametrize("off_screen", [False, True])
@pytest.mark.parametrize(("display", "got"), [(":99", ":99"), ("", "none")])
def test_where_no_window_can_open_a_picture_is_offered(shown, monkeypatch, off_screen, display, got):
    monkeypatch.setattr(pv, "OFF_SCREEN", off_screen)
    monkeypatch.setattr(view, "drawing_window", lambda: "vtkEGLRenderWindow")
    monkeypatch.setenv("DISPLAY", display)
    refused = "PYVISTA_OFF_SCREEN must be unset" if off_screen else rf"DISPLAY must be a display to open .* got {got}\."
    with pytest.raises(ValueError, match=rf"^{refused}.* A picture needs .*pvphong shade MESH -o picture\.png"):
        show(pv.Sphere(), SCENE, DULL, title="a sphere")
    assert not shown


def test_a_display_that_is_not_there_is_an_error_and_no_crash():
    command = [sys.executable, "-m", "pvphong", "view", "sphere.vtp"]
    process = subprocess.run(command, capture_output=True, text=True, check=False, env=os.environ | {"DISPLAY": ":97"})
    assert (process.returncode, process.stderr[:25]) == (2, "error: DISPLAY must be a ")


@pytest.fixture
def keys(shown, monkeypatch):
    """Return key → function of a window on a mesh."""
    taken = {}
    monkeypatch.setattr(PlotterPhong, "add_gizmos", lambda _, *, keys: taken.update(keys))

    def of(mesh, materials, scene=SCENE, **options):
        show(mesh, scene, materials, title="a mesh", stem="mine", **options)
        assert len(shown) == 1
        return {key: act for key, (_, act) in taken.items()}

    return of


def test_keys_save_the_rig_the_lit_mesh_and_a_picture(shown, keys, capsys, monkeypatch):
    sphere, image = pv.Sphere(), np.arange(60, dtype=np.uint8).reshape(4, 5, 3)
    monkeypatch.setattr(pv.Plotter, "screenshot", lambda *_, **__: image)
    saving = keys(sphere, GOLD)
    shown[0].phong.mesh(drawn(shown[0])[0]).material = JADE
    assert [saving[key]() for key in "dx4"] == ["saved mine-rig.json", "saved mine-lit.vtp", "saved mine.png"]
    assert capsys.readouterr().out.split() == ["mine-rig.json", "mine-lit.vtp", "mine.png"]
    assert Scene.load("mine-rig.json").lights == SCENE.lights
    assert load_materials("mine-rig.json") == {"default": JADE}
    expected = sphere.phong.shade(Scene.load("mine-rig.json"), JADE)
    np.testing.assert_array_equal(pv.read("mine-lit.vtp")["phong"], expected["phong"])
    assert pv.read("mine.png").dimensions == (5, 4, 1)


def test_blocks_are_shown_and_saved_with_their_materials_as_keys_have_left_them(shown, keys, capsys, tmp_path):
    ruby = Material.named("ruby")
    blocks = pv.MultiBlock({"one": pv.Sphere(), "none": None, "two": pv.MultiBlock({"deep": pv.Cube()})})
    saving = keys(blocks, {"one": JADE, "default": DULL})
    one, two = drawn(shown[0])
    assert [shown[0].phong.mesh(actor).material for actor in (one, two)] == [JADE, Material()]
    shown[0].phong.mesh(two).material = ruby
    saving["d"]()
    assert load_materials("mine-rig.json") == {"one": JADE, "two/deep": ruby}
    saving["x"]()
    lit, expected = pv.read("mine-lit.vtm"), pv.Cube().phong.shade(shown[0].phong.scene, ruby)
    np.testing.assert_array_equal(lit["two"]["deep"]["phong"], expected["phong"])
    (tmp_path / "mine-rig.json").unlink()
    (tmp_path / "mine-rig.json").mkdir()
    capsys.readouterr()
    assert saving["d"]().startswith("error: path must be a file"), "the window outlives it"
    assert "error: path must be a file" in capsys.readouterr().err


def test_other_meshes_are_shown_too_and_cast_shadows_into_what_is_saved(shown, keys):
    dark = replace(SCENE, lights=[DirectionalLight(name="sun")], light_model=LightModel(ambient=0.0, shadows=True))
    saving = keys(pv.Plane(), DULL, dark, occluders=[pv.Plane(center=(0, 0, 2), i_size=9, j_size=9)])
    assert len(drawn(shown[0])) == 2
    saving["x"]()
    assert pv.read("mine-lit.vtp")["phong"].max() == 0.0
