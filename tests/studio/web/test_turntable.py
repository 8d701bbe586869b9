"""Turntables: the way of the camera, and what happens when one is cancelled."""

import asyncio
import threading

import numpy as np
import pytest
import pyvista as pv

pytest.importorskip("trame_pyvista", reason="the studio needs the extra trame")

import pvphong as ph
from pvphong.studio.web.downloads import Downloads, Picture
from pvphong.studio.web.turntable import Turntable, _finished, around, pictures_in


@pytest.mark.parametrize("up", [(0, 0, 1), (0, 1, 0), (-1, 0, 0), (0.1, 0.2, 0.9)])
def test_the_camera_goes_around_the_vertical_line_and_keeps_its_height(up):
    viewer, middle = ph.Viewer((3.0, 1.0, 2.0), (0.5, 0.2, 0.1), up), np.array((0.4, 0.1, 0.0))
    axis = int(np.abs(up).argmax())
    start = np.subtract(viewer.position, middle)
    for turn in np.linspace(0.1, 6.0, 5):
        turned = around(viewer, middle, turn)
        place = np.subtract(turned.position, middle)
        assert place[axis] == pytest.approx(start[axis])
        assert np.linalg.norm(place) == pytest.approx(np.linalg.norm(start))
        flat, before = np.delete(place, axis), np.delete(start, axis)
        assert flat @ before == pytest.approx(before @ before * np.cos(turn))
        assert turned.distance == pytest.approx(viewer.distance)
        assert np.dot(turned.up, turned.view_direction) == pytest.approx(np.dot(viewer.up, viewer.view_direction))
    once = around(viewer, middle, 2.0 * np.pi)
    np.testing.assert_allclose(once.position, viewer.position, atol=1e-12)


@pytest.fixture
def downloads(new_plotter):
    plotter = new_plotter((64, 48))
    plotter.phong.add_light(ph.DirectionalLight((0, 1, -1)))
    plotter.phong.add_mesh(pv.Sphere())
    plotter.phong.add_stage("backdrop")
    plotter.show(auto_close=False)
    lit = plotter.phong._subplot.lit
    meshes = {"ball": lit.subjects[0]}
    picture = Picture((64, 48), "#102030")
    return Downloads(meshes, plotter.phong.scene, 0.0, "", "ball", {}, stage=lit.stage, picture=picture)


def test_a_cancelled_turntable_says_so_and_a_released_one_says_nothing(downloads):
    async def run(end):
        changes, said = [], []
        turntable = Turntable(lambda: changes.append(turntable.part))
        turntable.start(downloads, 8, said.append)
        with pytest.raises(ValueError, match="turntable must be started after"):
            turntable.start(downloads, 8, said.append)
        while not changes:
            await asyncio.sleep(0.01)
        end(turntable)
        count = len(changes)
        await asyncio.sleep(0.3)
        return turntable, said, len(changes) - count

    turntable, said, _ = asyncio.run(run(Turntable.cancel))
    assert (turntable.part, turntable.gif, said) == (None, b"", ["The turntable is cancelled."])
    turntable, said, after = asyncio.run(run(Turntable.release))
    assert (turntable.gif, said, after) == (b"", [], 0)


def test_a_backdrop_never_hides_the_mesh(downloads):
    from io import BytesIO

    from PIL import Image

    async def run():
        turntable = Turntable(lambda: None)
        turntable.start(downloads, 8, lambda _: None)
        while turntable.part is not None:
            await asyncio.sleep(0.01)
        return turntable.gif

    with Image.open(BytesIO(asyncio.run(run()))) as gif:
        for number in range(8):
            gif.seek(number)
            picture = np.asarray(gif.convert("RGB")).astype(int)
            assert picture[20:28, 28:36].std() > 1 or np.abs(picture[24, 32] - picture[2, 2]).max() > 10, number


def test_numbers_of_pictures_are_limited():
    assert pictures_in("12") == 12
    for given in ("7", "121", "9.5", "many"):
        with pytest.raises(ValueError, match="pictures must be"):
            pictures_in(given)


def test_a_cancelled_task_ends_after_its_thread():
    async def run():
        begun, may_end, ended = threading.Event(), threading.Event(), []

        def work():
            begun.set()
            assert may_end.wait(60.0)
            ended.append(True)

        task = asyncio.ensure_future(_finished(work))
        while not begun.is_set():
            await asyncio.sleep(0.01)
        for _ in range(2):
            task.cancel()
            await asyncio.sleep(0.05)
            assert not task.done()
        may_end.set()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert ended == [True]

    asyncio.run(run())


def test_a_turntable_that_fails_is_said(downloads, monkeypatch):
    async def run():
        said = []
        turntable = Turntable(lambda: None)

        async def fail(*_):
            raise OSError("no space left")

        monkeypatch.setattr(turntable, "_write", fail)
        turntable.start(downloads, 8, said.append)
        while not said:
            await asyncio.sleep(0.01)
        assert said == ["The turntable could not be drawn: no space left"]
        assert turntable.part is None

    asyncio.run(run())
