"""The studio without a browser: lost connections, opening of meshes, and downloads of several blocks."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from mouse import Mouse
from studios import in_a_studio

pytest.importorskip("trame_pyvista", reason="the studio needs the extra trame")

import pvphong as ph
from pvphong.cli.app import main
from pvphong.meshes.blocks import leaves
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.studio.lit_mesh import SharedMaterial
from pvphong.studio.web.new_light import placed_before
from pvphong.studio.web.opening import Fit
from pvphong.studio.web.report import Report
from pvphong.studio.web.studio import _MARKS


def test_escape_puts_back_a_drag_after_a_connection_was_lost_in_another(new_plotter):
    plotter = new_plotter((400, 300))
    plotter.phong.add_light(ph.PointLight((0.8, -0.4, 0.9), name="lamp"))
    plotter.phong.add_mesh(pv.Sphere())
    plotter.camera_position = [(0, -5, 2.5), (0, 0, 0.2), (0, 0, 1)]
    plotter.show(auto_close=False)
    mouse = Mouse(plotter)

    def act(studio):
        before = plotter.phong.lights
        end = mouse.pull(mouse.at("lamp", "position"), (25, -9))
        assert plotter.phong.lights != before
        studio._left(True)
        assert plotter.phong.lights == before
        mouse.move(end)
        mouse.pull(mouse.at("lamp", "position"), (25, -9))
        assert plotter.phong.lights != before
        mouse.key("Escape")
        assert plotter.phong.lights == before

    in_a_studio(plotter, act)


@pytest.fixture
def lamp_and_ball(new_plotter):
    """A plotter with a lamp and a ball, drawn once."""
    plotter = new_plotter((64, 48))
    plotter.phong.add_light(ph.PointLight((0.8, -0.4, 0.9), name="lamp"))
    plotter.phong.add_mesh(pv.Sphere(), name="ball")
    plotter.show(auto_close=False)
    return plotter


def test_a_mesh_that_is_opened_while_something_is_slid_is_a_step_after_it(lamp_and_ball):
    def act(studio):
        before = lamp_and_ball.phong.lights
        studio.document.slide("light.1.intensity", 1.0)
        studio.open_example("nut")
        assert studio.document.undo()
        assert lamp_and_ball.phong.lights[0].intensity == 2.0
        assert studio.document.undo()
        assert lamp_and_ball.phong.lights == before
        assert not studio.document.undo()

    in_a_studio(lamp_and_ball, act)


def test_an_opened_mesh_keeps_the_lights_and_is_one_step_of_undo(lamp_and_ball):
    plotter = lamp_and_ball

    def act(studio):
        (ball,) = plotter.phong._subplot.lit.meshes
        before, viewer, shown = plotter.phong.lights, plotter.phong.scene.viewer, ball.drawn["phong"].copy()
        studio.document.edit("light.1.diffuse", "orange")
        studio.open(pv.Sphere(radius=5.0, center=(100, 0, 0)), "large.stl")
        (large,) = plotter.phong._subplot.lit.meshes
        assert studio._shown()["title"] == f"large: {large.drawn.n_points:,} points"
        assert 'ph.read("large.stl")' in studio.downloads.script().replace("'", '"')
        (lamp,) = plotter.phong.lights
        np.testing.assert_allclose(lamp.position, (100 + 8.0, -4.0, 9.0), rtol=1e-6)
        assert (lamp.name, lamp.intensity, lamp.diffuse) == ("lamp", 1.0, (1.0, 165 / 255, 0.0))
        plotter.render()
        assert studio.document.undo()
        assert plotter.phong._subplot.lit.meshes == (ball,)
        assert plotter.actors["ball"] is ball.actor
        assert plotter.phong.scene.viewer == viewer
        assert studio._shown()["title"] == f"part: {ball.drawn.n_points:,} points"
        assert studio.document.undo()
        plotter.render()
        assert plotter.phong.lights == before
        np.testing.assert_array_equal(ball.drawn["phong"], shown)
        assert studio.document.redo()
        assert studio.document.redo()
        assert plotter.phong._subplot.lit.meshes == (large,)
        assert plotter.phong.lights == (lamp,)

    in_a_studio(plotter, act)


LIT_ALIKE = [kind(frame=frame) for kind in LIGHT_TYPES.values() for frame in ("world", "camera", "headlight")]


@pytest.mark.parametrize("light", LIT_ALIKE, ids=lambda light: f"{type(light).__name__} {light.frame}")
def test_a_mesh_of_another_size_is_lit_alike(light):
    if isinstance(light, ph.PointLight | ph.SpotLight):
        light = replace(light, attenuation=(1.0, 0.2, 0.1))
    ball, other = pv.Sphere(center=(0, 0, -1)), pv.Sphere(radius=20.0, center=(7, 8, 9))
    viewers = [ph.Viewer.framing(each.bounds) for each in (ball, other)]
    if light.frame == "world":
        light = placed_before(light, (0, 0, -1), 0.866, viewers[0])
    fit = Fit(*(np.reshape(each.bounds, (3, 2)) for each in (ball, other)), *viewers)
    lit = ball.phong.shade(ph.Scene([light], viewers[0]))
    again = other.phong.shade(ph.Scene([fit.light(light)], viewers[1]))
    np.testing.assert_allclose(again["phong"], lit["phong"], atol=2e-4)


def test_a_message_that_says_what_the_camera_is_to_fit_is_refused(lamp_and_ball):
    def act(studio):
        before = lamp_and_ball.camera.position
        studio._triggers["fit"](True, [-1e300, 1e300, -1e300, 1e300, -1e300, 1e300])
        assert (studio.server.state.refusals, lamp_and_ball.camera.position) == (1, before)

    in_a_studio(lamp_and_ball, act)


@pytest.mark.parametrize("shape", [(1, 2), "1|1"])
def test_a_studio_acts_on_its_own_subplot_whichever_is_active(new_plotter, shape):
    plotter = new_plotter((96, 48), shape=shape)
    plotter.phong.add_light(ph.PointLight((0.8, -0.4, 0.9), name="lamp"))
    plotter.phong.add_mesh(pv.Sphere(), name="ball")
    own, other = plotter.renderers

    def act(studio):
        plotter.subplot(*([1] if shape == "1|1" else (0, 1)))
        before, camera = plotter.phong.add_mesh(pv.Cube(), name="other"), plotter.camera.copy()
        studio.open_example("nut")
        studio._measuring.report = Report(worst=[(0, 0.1, (0.0, 0.0, 0.0))])
        studio.mark_worst(True)
        assert _MARKS in own.actors
        own.camera.position = (0, 0, 1e3)
        studio._triggers["fit"]()
        assert own.camera.distance < 1e3
        assert (other.actors, other.camera, plotter.renderer) == ({"other": before}, camera, other)
        assert "ball" not in own.actors
        assert studio.document.gizmos.lights.values[0].name == "lamp"

    in_a_studio(plotter, act)


def blocks_in(path, count=2):
    """Write blocks to a file; the second one has no name."""
    blocks = pv.MultiBlock([pv.Sphere(), pv.Plane(center=(0, 0, -0.6))][:count])
    for number, name in enumerate(["bowl", ""][:count]):
        blocks.set_block_name(number, name)
    blocks.save(path)
    return pv.read(path)


GOLD = ph.Material.named("gold")


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("name", [{}, {"name": "part"}], ids=["", "named"])
def test_the_script_of_blocks_lights_them_as_the_studio_does(new_plotter, tmp_path, monkeypatch, name, count):
    plotter, blocks = new_plotter((64, 48)), blocks_in(tmp_path / "part.vtm", count)
    plotter.phong.add_light(ph.DirectionalLight((0, 0.3, -1)))
    first, *_ = plotter.phong.add_mesh(blocks, **name)
    plotter.phong.mesh(first).shared_material = SharedMaterial(GOLD)
    downloads = in_a_studio(plotter, lambda studio: studio.downloads)
    monkeypatch.chdir(tmp_path)
    exec(compile(downloads.script(), "script", "exec"), {})
    for saved, lit in zip(pv.read(tmp_path / "part-lit.vtkhdf"), leaves(downloads.lit), strict=True):
        np.testing.assert_array_equal(saved["phong"], lit["phong"])


def test_the_script_of_blocks_on_a_stage_lights_them_as_the_studio_does(new_plotter, tmp_path, monkeypatch):
    plotter, blocks = new_plotter((64, 48)), blocks_in(tmp_path / "part.vtm")
    plotter.phong.add_light(ph.DirectionalLight((0, 0.3, -1)))
    first, *_ = plotter.phong.add_mesh(blocks, name="part")
    plotter.phong.mesh(first).shared_material = SharedMaterial(GOLD)
    plotter.show(auto_close=False)

    def act(studio):
        assert "Shadows are on now" in studio.set_stage("ground")
        studio.server.state.update({"width": 64, "height": 48})
        assert list(studio.document.materials)[-1] == "stage"
        return studio.downloads

    downloads = in_a_studio(plotter, act)
    monkeypatch.chdir(tmp_path)
    drawn = pv.read(downloads.write("png", tmp_path)).active_scalars.astype(int)
    downloads.save_rig(tmp_path / "rig.json")
    (tmp_path / "part.png").unlink()
    exec(compile(downloads.script(), "script", "exec"), {})
    saved = pv.read(tmp_path / "part-lit.vtkhdf")
    assert len(saved) == len(blocks)
    for block, lit in zip(saved, leaves(downloads.lit), strict=True):
        np.testing.assert_array_equal(block["phong"], lit["phong"])
    assert np.abs(pv.read(tmp_path / "part.png").active_scalars.astype(int) - drawn).max() <= 1
    assert "stage" not in ph.load_materials(tmp_path / "rig.json")


@pytest.mark.parametrize("stage", ["", "ground"])
def test_the_picture_is_refined_as_the_view_is_and_its_script_too(new_plotter, tmp_path, monkeypatch, stage):
    ball, plotter = pv.Sphere(theta_resolution=12, phi_resolution=12), new_plotter((160, 120))
    ball.save(tmp_path / "ball.vtp")
    plotter.phong.add_light(
        ph.SpotLight.at((0.8, -2, 0.9), target=(0, -0.3, 0.1), cone_angle=8, exponent=0, intensity=3)
    )
    plotter.phong.add_mesh(ball, name="ball")
    plotter.show(auto_close=False)

    def act(studio):
        state = studio.server.state
        state.width, state.height = 160, 120
        studio.set_stage(stage)
        studio.document.edit("model.shadows", False)
        studio.document.edit("display.exposure", -1.0)
        before = pv.read(studio.downloads.write("png", tmp_path)).active_scalars.astype(int)
        studio.document.edit("accuracy.refine", 0.1)
        plotter.phong._subplot.lit.refresh(waits=True)
        return before, studio.downloads

    before, downloads = in_a_studio(plotter, act, file="ball.vtp")
    drawn = pv.read(downloads.write("png", tmp_path)).active_scalars.astype(int)
    assert np.abs(drawn - before).max() > 40  # the edge of the cone is crisp
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ball.png").unlink()
    exec(compile(downloads.script(), "script", "exec"), {})
    again = pv.read(tmp_path / "ball.png").active_scalars.astype(int)
    off = np.abs(again - drawn).max(axis=1)
    assert (off > 6).mean() < 0.003
    assert off.mean() < 0.2


def test_the_command_begins_with_a_rig_that_was_kept_of_blocks(tmp_path, monkeypatch):
    path, started = tmp_path / "part.vtm", []
    blocks_in(path)

    def studio(phong, *, keep, **_):
        started.append([lit.material for lit in phong._subplot.lit.meshes])
        phong._subplot.lit.meshes[0].shared_material = SharedMaterial(GOLD)
        in_a_studio(phong._plotter, lambda studio: studio._save(), keep=keep)

    monkeypatch.setattr("pvphong.plotter.PlotterPhong.studio", studio)
    for _ in range(2):
        assert main(["studio", str(path), "--keep", "--no-browser"]) == 0
    assert started == [[ph.Material(), ph.Material()], [GOLD, ph.Material()]]


@pytest.mark.parametrize(("count", "shown"), [(1, {"vtp", "ply"}), (2, {"vtkhdf"})])
def test_the_page_offers_files_that_hold_as_many_meshes(new_plotter, tmp_path, count, shown):
    plotter = new_plotter((64, 48))
    plotter.phong.add_light(ph.DirectionalLight())
    plotter.phong.add_mesh(pv.MultiBlock([pv.Sphere(), pv.Plane()][:count]))

    def act(studio):
        state = studio.server.state
        for what in ("vtp", "ply", "vtkhdf"):
            (button,) = re.findall(f'<VBtn data-test="download-{what}".*', state.trame__template_main)
            condition = re.search('v-if="([^"]*)"', button)[1]
            assert eval(condition, {"mesh_count": state.mesh_count}) is (what in shown)
            if what in shown:
                studio.downloads.write(what, tmp_path)
        return studio.downloads

    downloads = in_a_studio(plotter, act)
    assert {path.suffix for path in tmp_path.iterdir()} == {f".{what}" for what in shown}
    for path in tmp_path.glob("*.v*"):
        for saved, lit in zip(leaves(pv.read(path)), leaves(downloads.lit), strict=True):
            np.testing.assert_array_equal(saved["phong"], lit["phong"])


def test_an_uploaded_rig_with_a_lamp_file_changes_nothing(lamp_and_ball, tmp_path):
    rig = tmp_path / "rig.json"
    ph.Scene([ph.PhotometricLight(100.0, position=(0, 0, 3), name="lamp")]).save(rig)
    given = json.loads(rig.read_text())
    (lamp,) = given["lights"]
    assert "photometry" in json.dumps(lamp)
    rig.write_text(json.dumps({**given, "lights": [{**lamp, "photometry": "/etc/passwd"}]}))

    def act(studio):
        before = lamp_and_ball.phong.lights
        with pytest.raises(ValueError, match=r"^photometry must be the numbers of a lamp in an uploaded rig") as told:
            studio._uploads.take_rig("rig.json", rig, {}).send(None)
        assert "root" not in str(told.value)
        assert lamp_and_ball.phong.lights == before

    in_a_studio(lamp_and_ball, act)


def test_a_gradient_stays_behind_a_picture_that_becomes_transparent(lamp_and_ball):
    lamp_and_ball.set_background("white", top="blue")

    def act(studio):
        studio._triggers["edit"]("background.transparent", True)
        assert studio.document.background.transparent
        assert lamp_and_ball.renderer.GetGradientBackground()

    in_a_studio(lamp_and_ball, act)
