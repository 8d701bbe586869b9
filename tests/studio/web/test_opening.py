"""Several meshes in a studio: adding, naming and removing them with undo, and downloads that hold all of them."""

import json
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from studios import in_a_studio

pytest.importorskip("trame_pyvista", reason="the studio needs the extra trame")

import pvphong as ph
from pvphong.meshes.blocks import datasets, leaves

FLOOR = 600
"""Points of the floor, with sharp edges."""


@pytest.fixture
def ball(new_plotter, tmp_path, monkeypatch):
    """A plotter with a lamp and a ball that is read from the working directory; it is drawn once."""
    monkeypatch.chdir(tmp_path)
    pv.Sphere(theta_resolution=12, phi_resolution=12).save("ball.vtp")
    pv.Box(bounds=(-1.5, 1.5, -1.5, 1.5, -0.7, -0.6), level=8).clean().save("floor.vtp")
    pv.Plane(center=(0, 0, 0.3)).save("sheet.vtp")
    plotter = new_plotter((64, 48))
    plotter.phong.add_light(ph.PointLight((0.4, -0.4, 2.0), name="lamp"))
    plotter.phong.add_mesh(ph.read("ball.vtp"), ph.Material())
    plotter.show(auto_close=False)
    return plotter


def add(studio, file):
    """Add a file beside the others, as an upload does."""
    studio._open_upload(ph.read(file), file, True)


def names(studio):
    return list(studio.document.names().values())


def camera(plotter):
    """Return the viewer, apart from the clipping range, which fits what is drawn."""
    return replace(plotter.phong.scene.viewer, clipping_range=(1, 2))


def numbers(studio):
    return [part["number"] for part in studio._shown()["parts"]]


def test_a_mesh_is_added_beside_another_as_one_step_and_lights_and_camera_stay(ball):
    def act(studio):
        document, lights, viewer = studio.document, ball.phong.lights, camera(ball)
        (first,) = ball.phong._subplot.lit.meshes
        add(studio, "floor.vtp")
        assert names(studio) == ["ball", "floor"]
        _, floor = ball.phong._subplot.lit.meshes
        assert (ball.phong.lights, camera(ball)) == (lights, viewer)
        assert studio._shown()["title"] == f"ball, floor: {first.drawn.n_points + floor.drawn.n_points:,} points"
        assert studio._shown()["mesh_count"] == 2
        _, floor = ball.phong._subplot.lit.meshes
        assert document.undo()
        assert ball.phong._subplot.lit.meshes == (first,)
        assert not document.undo()
        assert document.redo()
        assert ball.phong._subplot.lit.meshes == (first, floor)
        studio.open(pv.Cube(), "box.stl")
        assert document.undo()
        assert names(studio) == ["ball", "floor"]
        assert camera(ball) == viewer

    in_a_studio(ball, act, file="ball.vtp")


def test_each_mesh_has_a_material_a_name_and_can_be_removed_and_all_that_is_undone(ball):
    def act(studio):
        document = studio.document
        add(studio, "floor.vtp")
        document.choose_material(1, "gold")
        assert [shared.material for shared in document.materials.values()] == [
            ph.Material(),
            ph.Material.named("gold"),
        ]
        document.rename_mesh(numbers(studio)[1], " ground ")
        assert list(document.materials) == ["ball", "ground"]
        document.remove_mesh(numbers(studio)[0])
        assert names(studio) == ["mesh 1"]
        assert studio._shown()["title"] == f"ground: {FLOOR} points"
        assert list(studio.downloads.materials.values()) == [ph.Material.named("gold")]
        assert document.undo()
        assert names(studio) == ["ball", "ground"]  # in the same order, though the ball is drawn last
        assert list(studio.downloads.meshes) == ["ball", "ground"]
        assert document.undo()
        assert names(studio) == ["ball", "floor"]
        assert document.undo()
        assert document.materials["floor"].material == ph.Material()
        for _ in range(3):
            assert document.redo()
        assert names(studio) == ["mesh 1"]
        document.remove_mesh(numbers(studio)[0])
        assert (studio._shown()["title"], studio._shown()["parts"]) == ("no mesh", [])
        studio.open_example("nut")
        assert document.undo()
        assert document.undo()
        assert studio._shown()["title"] == f"ground: {FLOOR} points"

    in_a_studio(ball, act, file="ball.vtp")


def test_both_sides_of_an_open_mesh_are_lit_unless_light_bounces(ball):
    def act(studio):
        add(studio, "sheet.vtp")
        assert ball.phong.light_model.two_sided
        assert studio.document.undo()
        assert not ball.phong.light_model.two_sided
        studio.document.edit("model.bounces", 1)
        add(studio, "sheet.vtp")
        studio._open_upload(ph.read("sheet.vtp"), "sheet.vtp", False)
        assert (ball.phong.light_model.two_sided, ball.phong.light_model.bounces) == (False, 1)

    in_a_studio(ball, act, file="ball.vtp")


REFUSED_NAMES = {
    "different from the names of other meshes": ["ball", "stage", "default"],
    "1 to 80 printable characters": ["", "  ", "a/b", "x" * 81, "a\nb"],
    "name must be a string": [5],
}


def test_a_name_that_another_mesh_has_or_that_is_none_is_refused(ball):
    def act(studio):
        add(studio, "floor.vtp")
        rename, remove = studio.document.rename_mesh, studio.document.remove_mesh
        for message, bad in REFUSED_NAMES.items():
            for name in bad:
                with pytest.raises(ValueError, match=message):
                    rename(numbers(studio)[1], name)
        for number in (None, 10**6, "x"):
            for change in (remove, lambda number: rename(number, "new")):
                with pytest.raises(ValueError, match="mesh must be the number of a mesh"):
                    change(number)
        assert names(studio) == ["ball", "floor"]
        assert studio.document.undo()
        assert not studio.document.undo()

    in_a_studio(ball, act, file="ball.vtp")


def test_the_same_name_twice_gets_a_number(ball):
    def act(studio):
        pv.Cube().save("stage.vtp")
        for file in ("ball.vtp", "ball.vtp", "stage.vtp"):
            add(studio, file)
        assert names(studio) == ["ball", "ball 2", "ball 3", "stage 2"]

    in_a_studio(ball, act, file="ball.vtp")


def test_what_cannot_be_lit_is_not_added(ball):
    def act(studio):
        before = studio.document.state
        for bad in (pv.PolyData(), pv.PolyData(np.eye(3)[:2]), pv.Line(), pv.MultiBlock()):
            with pytest.raises(ValueError, match=r"^mesh must be a "):
                studio._open_upload(bad, "bad.vtp", True)
            assert studio.document.state == before
        assert names(studio) == ["mesh 1"]

    in_a_studio(ball, act, file="ball.vtp")


def test_a_mesh_that_is_partly_out_of_sight_is_said_to_be(ball):
    def act(studio):
        assert studio._open_upload(pv.Sphere(radius=0.3), "small.ply", True) == ""
        assert studio._open_upload(pv.Sphere(center=(0, 0, 9)), "far.ply", True).startswith("far is not all in view.")
        assert studio._open_upload(pv.Sphere(center=(0, 0, 9)), "far.ply", False) == ""

    in_a_studio(ball, act, file="ball.vtp")


@pytest.mark.parametrize("stage", ["", "ground"])
def test_the_script_reads_each_file_by_its_name_and_gives_the_same_bits(ball, tmp_path, stage):
    """Meshes shadow and light each other. One of the files has blocks."""
    pv.MultiBlock(
        {"rod": pv.Cylinder(radius=0.1, center=(0.9, 0, 0)), "knob": pv.Sphere(radius=0.2, center=(0, 0.9, 0))}
    ).save("parts.vtm")

    def act(studio):
        add(studio, "floor.vtp")
        alone = np.array(ball.phong._subplot.lit.meshes[1].drawn["phong"])
        studio.document.edit("model.shadows", True)
        ball.phong._subplot.lit.refresh(waits=True)
        shadowed = np.array(ball.phong._subplot.lit.meshes[1].drawn["phong"])
        assert (shadowed.astype(int) - alone).min() < -30  # the ball's shadow on the floor
        add(studio, "parts.vtm")
        studio.set_stage(stage)
        studio.document.edit("model.two_sided", False)
        studio.document.edit("model.bounces", 1)
        studio.document.choose_material(list(studio.document.materials).index("parts/rod"), "gold")
        studio.server.state.update({"width": 64, "height": 48})
        ball.phong._subplot.lit.refresh(waits=True)
        return studio.downloads

    downloads = in_a_studio(ball, act, file="ball.vtp")
    expected = ["ball", "floor", "parts/rod", "parts/knob"]
    assert list(downloads.meshes) == expected
    for what in ("vtkhdf", "glb", "png", "rig"):
        downloads.write(what, tmp_path)
    assert json.loads((tmp_path / "ball-rig.json").read_text())["materials"].keys() == set(expected)
    assert [name for name, _ in datasets(pv.read(tmp_path / "ball-lit.vtkhdf"))] == expected
    assert len(leaves(pv.read(tmp_path / "ball-lit.glb"))) == len(expected)
    drawn = pv.read(tmp_path / "ball.png").active_scalars.astype(int)
    names_in_script = {}
    script = downloads.script()
    exec(compile(script, "script", "exec"), names_in_script)
    for file in ("ball.vtp", "floor.vtp", "parts.vtm"):
        assert f"ph.read({file!r})" in script
    lit = dict(datasets(downloads.lit))
    again = dict(datasets(names_in_script["lit"]))
    assert list(again) == list(lit) == expected
    for name, mesh in lit.items():
        np.testing.assert_array_equal(again[name]["phong"], mesh["phong"])
    assert np.abs(pv.read(tmp_path / "ball.png").active_scalars.astype(int) - drawn).max() <= 1


def test_a_stage_is_put_under_all_meshes_and_back_by_undo(ball):
    def act(studio):
        lit = ball.phong._subplot.lit
        studio.set_stage("ground")
        height = lit.stage.actor.bounds[5]
        add(studio, "floor.vtp")
        assert lit.stage.actor.bounds[5] < height - 0.05
        assert names(studio) == ["ball", "floor", "stage"]
        assert list(studio.document.materials) == ["ball", "floor", "stage"]
        assert studio.document.undo()
        assert lit.stage.actor.bounds[5] == height
        studio.document.remove_mesh(numbers(studio)[0])
        assert lit.meshes == ()
        assert studio.document.undo()
        assert lit.stage.actor.bounds[5] == height

    in_a_studio(ball, act, file="ball.vtp")


def test_a_kept_rig_has_the_material_of_its_own_mesh(ball, tmp_path):
    keep = tmp_path / "ball-rig.json"

    def act(studio):
        add(studio, "floor.vtp")
        studio.document.choose_material(0, "gold")
        studio.document.choose_material(1, "ruby")
        studio._save()
        assert ph.load_materials(keep) == {"default": ph.Material.named("gold")}
        studio.downloads.save_rig(tmp_path / "both.json")
        assert ph.load_materials(tmp_path / "both.json") == {
            "ball": ph.Material.named("gold"),
            "floor": ph.Material.named("ruby"),
        }
        studio.document.remove_mesh(numbers(studio)[0])
        keep.unlink()
        studio._save()
        assert not keep.exists()

    in_a_studio(ball, act, file="ball.vtp", keep=keep)


def test_meshes_that_a_script_adds_are_in_the_studio_and_belong_to_the_first_file(ball):
    def act(studio):
        actor = ball.phong.add_mesh(pv.Cube(), "gold", name="box")
        assert names(studio) == ["mesh 1", "box"]
        assert [part["name"] for part in studio._shown()["parts"]] == ["ball"]
        assert list(studio.document.materials) == ["mesh 1", "box"]
        add(studio, "floor.vtp")
        assert names(studio) == ["ball/mesh 1", "ball/box", "floor"]
        ball.remove_actor(actor)
        assert names(studio) == ["ball", "floor"]

    in_a_studio(ball, act, file="ball.vtp")


def test_an_upload_is_added_if_its_query_says_so_and_refused_if_damaged(ball, tmp_path):
    async def act(studio):
        take = studio._uploads.take_mesh
        await take("floor.vtp", tmp_path / "floor.vtp", {"beside": "1"})
        assert names(studio) == ["ball", "floor"]
        (tmp_path / "damaged.vtp").write_bytes((tmp_path / "ball.vtp").read_bytes()[:900])
        with pytest.raises(ValueError, match=r"damaged\.vtp"):
            await take("damaged.vtp", tmp_path / "damaged.vtp", {"beside": "1"})
        assert names(studio) == ["ball", "floor"]

    in_a_studio(ball, act, file="ball.vtp")
