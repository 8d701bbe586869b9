from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from pvphong import DirectionalLight, LightModel, Material, PointLight, Scene, Viewer, load_materials
from pvphong.cli import view
from pvphong.cli.view import show
from pvphong.meshes.files import eight_bit
from pvphong.meshes.lit import shade_mesh
from pvphong.plotter import PlotterPhong

DULL, JADE = {"default": Material()}, Material.named("jade")
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
    """The plotters that were shown; nothing opens."""
    plotters = []
    monkeypatch.setattr(pv, "OFF_SCREEN", False)
    monkeypatch.setattr(view, "drawing_window", lambda: "vtkXOpenGLRenderWindow")
    monkeypatch.setattr(pv.Plotter, "show", lambda plotter: plotters.append(plotter))
    yield plotters
    for plotter in plotters:
        plotter.close()


def test_the_window_shows_the_mesh_in_the_scene_that_was_given(shown):
    sphere, gold = pv.Sphere(), Material.named("gold")
    show(sphere, SCENE, {"default": gold}, title="a sphere")
    (plotter,) = shown
    assert plotter.title == "a sphere"
    assert plotter.phong.lights == SCENE.lights
    assert len(plotter.phong.gizmos) == len(SCENE.lights)
    assert plotter.phong.light_model == SCENE.light_model
    viewer = plotter.phong.scene.viewer
    assert (viewer.position, viewer.focal_point, viewer.up) == ((4, 1, 2), (0, 0, 0), (0, 0, 1))
    (actor,) = (a for a in plotter.actors.values() if isinstance(a, pv.Actor))
    drawn = actor.mapper.dataset  # its colours are 8 bits
    np.testing.assert_allclose(drawn["phong"], eight_bit(shade_mesh(sphere, SCENE, gold)["phong"]), atol=1)


def test_every_block_is_shown(shown):
    show(pv.MultiBlock([pv.Sphere(), None, pv.MultiBlock([pv.Cube()])]), SCENE, DULL, title="blocks")
    assert len([a for a in shown[0].actors.values() if isinstance(a, pv.Actor)]) == 2


def test_other_meshes_are_shown_too_and_cast_shadows_into_what_is_saved(shown, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    dark = replace(SCENE, lights=[DirectionalLight(name="sun")], light_model=LightModel(ambient=0.0, shadows=True))
    roof, handed = pv.Plane(center=(0, 0, 2), i_size=9, j_size=9), {}
    monkeypatch.setattr(PlotterPhong, "add_gizmos", lambda _, keys: handed.update(keys))
    show(pv.Plane(), dark, DULL, title="a roof", stem="mine", occluders=[roof])
    assert len([a for a in shown[0].actors.values() if isinstance(a, pv.Actor)]) == 2
    handed["x"][1]()
    assert pv.read("mine-lit.vtp")["phong"].max() == 0.0


def test_edges_are_sharp_and_the_background_is_dark_unless_others_are_asked_for(shown):
    box = pv.Cube().clean()
    box.point_data.clear()
    for options, points, is_dark in (({}, 24, True), ({"feature_angle": None, "background": "white"}, 8, False)):
        show(box, SCENE, DULL, title="a box", **options)
        (actor,) = (a for a in shown[-1].actors.values() if isinstance(a, pv.Actor))
        assert actor.mapper.dataset.n_points == points
        assert (max(shown[-1].background_color.float_rgb) < 0.25) == is_dark
    with pytest.raises(ValueError, match=r"^background must be .* got whyte"):
        show(box, SCENE, DULL, title="a box", background="whyte")
    assert len(shown) == 2


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


@pytest.fixture
def keys(shown, monkeypatch, tmp_path):
    """Key → function of a window on a mesh, in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    taken = {}
    monkeypatch.setattr(PlotterPhong, "add_gizmos", lambda _, *, keys: taken.update(keys))

    def of(mesh, materials=None):
        show(mesh, SCENE, materials or {"default": Material.named("gold")}, title="a mesh", stem="mine")
        assert len(shown) == 1
        return {key: act for key, (_, act) in taken.items()}

    return of


def test_keys_save_the_rig_the_lit_mesh_and_a_picture(shown, keys, capsys, monkeypatch):
    sphere, image = pv.Sphere(), np.arange(60, dtype=np.uint8).reshape(4, 5, 3)
    monkeypatch.setattr(pv.Plotter, "screenshot", lambda *_, **__: image)
    saving = keys(sphere)
    shown[0].phong.mesh(next(a for a in shown[0].actors.values() if isinstance(a, pv.Actor))).material = JADE
    assert [saving[key]() for key in "dx4"] == ["saved mine-rig.json", "saved mine-lit.vtp", "saved mine.png"]
    assert capsys.readouterr().out.split() == ["mine-rig.json", "mine-lit.vtp", "mine.png"]
    assert Scene.load("mine-rig.json").lights == SCENE.lights
    assert load_materials("mine-rig.json") == {"default": JADE}
    expected = shade_mesh(sphere, Scene.load("mine-rig.json"), JADE)
    np.testing.assert_array_equal(pv.read("mine-lit.vtp")["phong"], expected["phong"])
    assert pv.read("mine.png").dimensions == (5, 4, 1)


def test_blocks_are_saved_as_blocks_and_a_failure_leaves_the_window_open(keys, capsys, tmp_path):
    saving = keys(pv.MultiBlock({"one": pv.Sphere()}))
    saving["x"]()
    assert capsys.readouterr().out.split() == ["mine-lit.vtm"]
    assert "phong" in pv.read("mine-lit.vtm")["one"].array_names
    (tmp_path / "mine-rig.json").mkdir()
    assert saving["d"]().startswith("error: path must be a file")
    assert "error: path must be a file" in capsys.readouterr().err


def test_materials_of_blocks_are_saved_by_their_names_as_keys_have_left_them(shown, keys):
    ruby = Material.named("ruby")
    saving = keys(pv.MultiBlock({"one": pv.Sphere(), "two": pv.Sphere(), "three": pv.Cube()}), {"one": JADE} | DULL)
    one, two, three = (a for a in shown[0].actors.values() if isinstance(a, pv.Actor))
    assert [shown[0].phong.mesh(actor).material for actor in (one, two, three)] == [JADE, Material(), Material()]
    shown[0].phong.mesh(two).material = ruby
    saving["d"]()
    assert load_materials("mine-rig.json") == {"one": JADE, "two": ruby, "three": ruby}


def test_a_mesh_far_from_the_viewer_is_not_clipped_away(shown):
    show(
        pv.Sphere(radius=500),
        replace(SCENE, viewer=Viewer(position=(4000, 0, 0))),
        DULL,
        title="far away",
    )
    near, far = shown[0].camera.clipping_range
    assert near < 3500
    assert far > 4500
