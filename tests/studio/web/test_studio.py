"""The studio without a browser: what it does when one goes, and what it takes home of several blocks."""

import asyncio

import pytest
import pyvista as pv
from mouse import Mouse

pytest.importorskip("trame_pyvista", reason="the studio needs the extra trame")

import pvphong as ph
from pvphong.studio.web.studio import Studio


def in_a_studio(plotter, act, *, file="part.vtm", **options):
    """What a function gives for a studio of a plotter's active subplot, which is not served."""

    async def run():
        phong = plotter.phong
        if not phong.gizmos:
            phong.add_gizmos()
        return act(Studio(plotter, phong._subplot, phong._history, file=file, **options))

    return asyncio.run(run())


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
