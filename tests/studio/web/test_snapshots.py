"""Snapshots without a browser."""

import asyncio
import io

import numpy as np
import pytest
import pyvista as pv

pytest.importorskip("trame_pyvista", reason="the studio needs the extra trame")

from PIL import Image

import pvphong as ph
from pvphong.studio.web.studio import Studio


@pytest.fixture
def in_a_studio(new_plotter):
    """A function that calls another one with a plotter and its studio."""
    plotter = new_plotter((64, 48))
    plotter.phong.add_light(ph.PointLight((0.8, -0.4, 0.9), name="lamp"))
    plotter.phong.add_mesh(pv.Sphere(), "gold", name="ball")
    plotter.show(auto_close=False)
    plotter.phong.add_gizmos()

    def run(act):
        async def main():
            act(plotter, Studio(plotter, plotter.phong._subplot, plotter.phong._history, file="ball.stl"))

        asyncio.run(main())

    return run


def test_a_snapshot_is_restored_after_lights_meshes_and_materials_have_changed(in_a_studio):
    def act(plotter, studio):
        phong, document, snapshots = plotter.phong, studio.document, studio._instruments.snapshots
        before, (ball,) = phong.lights, phong._subplot.lit.meshes
        snapshots.keep()
        document.act("delete", 1)
        document.add("spot")
        document.choose_material(0, "jade")
        document.edit("display.exposure", 1.5)
        document.edit("model.ambient", 0.4)
        studio.open(pv.Cube(), "cube.stl")
        changed = phong.lights, phong.display, phong.light_model
        snapshots.restore("A")
        assert phong.lights == before
        assert phong.display == ph.Display()
        assert phong.light_model == ph.LightModel()
        assert phong._subplot.lit.meshes == (ball,)
        assert ball.material == ph.Material.named("gold")
        assert document.undo()
        assert (phong.lights, phong.display, phong.light_model) == changed
        assert [mesh.mesh.n_cells for mesh in phong._subplot.lit.meshes] == [6]

    in_a_studio(act)


def test_the_older_snapshot_is_replaced_and_pictures_show_no_gizmos(in_a_studio):
    def act(plotter, studio):
        snapshots = studio._instruments.snapshots
        plotter.phong._subplot.interaction.gizmos.select(plotter.phong.gizmos[0])
        for intensity in (1.0, 0.5, 0.0):
            studio.document.edit("light.1.intensity", intensity)
            snapshots.keep()
        shown = snapshots.shown()
        assert shown["pairs"] == ["A | B", "A | now", "B | now"]
        assert shown["urls"] == {"A": "snapshot/3.jpg", "B": "snapshot/2.jpg"}
        assert [each["about"] for each in shown["list"]] == ["lamp", "lamp"]
        assert snapshots.picture("1") is None
        plotter.phong.remove_gizmos()
        studio.document.edit("light.1.intensity", 0.5)
        plotter.render()
        picture = np.asarray(Image.open(io.BytesIO(snapshots.picture("2")))).astype(int)
        assert np.abs(picture - plotter.screenshot(return_img=True)[..., :3]).mean() < 2.0

    in_a_studio(act)


def test_the_camera_is_moved_only_on_request(in_a_studio):
    def act(plotter, studio):
        snapshots, viewer = studio._instruments.snapshots, plotter.phong.scene.viewer
        snapshots.keep("B")
        plotter.camera.azimuth = 40
        plotter.render()
        moved = plotter.phong.scene.viewer
        (listed,) = snapshots.shown()["list"]
        assert listed["moved"]
        snapshots.restore("B")
        assert plotter.phong.scene.viewer == moved
        snapshots.look_from("B")
        np.testing.assert_allclose(plotter.phong.scene.viewer.position, viewer.position)
        snapshots.forget("B")
        assert snapshots.shown() == {"list": [], "pairs": [], "urls": {}}
        for act_on in (snapshots.restore, snapshots.forget, snapshots.look_from):
            with pytest.raises(ValueError, match=r"name must be"):
                act_on("B")

    in_a_studio(act)
