"""The accuracy report runs in a separate process, reports its progress, and can be cancelled."""

import asyncio
import os
import pickle
import threading
import time
from asyncio.subprocess import Process
from io import BytesIO

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.meshes.point_data import texture_colors
from pvphong.optics.material import Material
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.studio.web import report
from pvphong.studio.web.report import Measuring, Report
from pvphong.studio.web.thumbnails import thumbnail

WORK = {"mesh": pv.Sphere(), "scene": ph.three_point(pv.Sphere()), "material": Material(), "tolerance": 1 / 255}


def measured(work, until=lambda measuring: not measuring.report.running):
    """Return the reports until one meets a condition, or the last one."""
    seen = []

    async def main():
        measuring = Measuring(lambda: seen.append(measuring.report))
        measuring.start(work)
        end = time.monotonic() + 240
        while not until(measuring):
            assert time.monotonic() < end
            await asyncio.sleep(0.02)
        return measuring

    asyncio.run(main())
    return seen


WITHOUT_FIGURE = """
import sys
from pvphong.studies.accuracy.report import Tradeoff
from pvphong.studio.web import report
report._NICE = 0
Tradeoff.plot = lambda self, path: path.write_bytes(b"\\x89PNG")
report.work(sys.argv[1])
"""


def test_it_is_measured_beside_what_else_is_done(monkeypatch):
    monkeypatch.setattr(report, "_CHILD", WITHOUT_FIGURE)  # the figure is slow, and has its own test
    seen = measured(WORK | {"seconds": 1.0})
    assert seen[0] == Report(running=True, doing="starting")
    assert {each.doing for each in seen} >= {"starting", "drawing"}
    last = seen[-1]
    assert any("points" in line for line in last.lines)
    assert len(last.worst) == 5
    index, error, place = last.worst[0]
    assert 0.0 <= error < 1e-3
    np.testing.assert_allclose(place, WORK["mesh"].points[index])
    assert last.figure[:4] == b"\x89PNG"


class _Bomb:
    """An object that ends the process that unpickles it."""

    def __reduce__(self):
        return os._exit, (3,)


ENDED = "The report could not be made: its process has crashed."


@pytest.mark.parametrize(("change", "said"), [({"tolerance": -1.0}, "tolerance must be"), ({"mesh": _Bomb()}, ENDED)])
def test_why_there_is_no_report_is_said_in_one_line(change, said):
    last = measured(WORK | change)[-1]
    assert said in last.doing
    assert not last.lines


def test_what_cannot_be_sent_is_said():
    last = measured(WORK | {"mesh": lambda: None})[-1]
    assert last.doing.startswith("The report could not be made: ")


def test_a_texture_is_sent_with_all_that_lookups_in_it_depend_on():
    texture = pv.Texture(np.arange(48, dtype=np.uint8).reshape(4, 4, 3))
    texture.wrap = pv.Texture.WrapType.MIRRORED_REPEAT
    texture.SetUseSRGBColorSpace(True)
    file = BytesIO()
    report._Pickler(file, protocol=5).dump(Material(albedo=texture))
    sent = pickle.loads(file.getvalue()).albedo.source
    plane = pv.Plane(i_resolution=7, j_resolution=5)
    plane.active_texture_coordinates = 3.0 * plane.active_texture_coordinates
    np.testing.assert_array_equal(texture_colors(sent, plane), texture_colors(texture, plane))


def test_it_can_be_ended(monkeypatch):
    """Cancelling ends the process too; here it only prints its id."""
    code = "import json, os, time; print(json.dumps([str(os.getpid()), 0.5]), flush=True); time.sleep(60)"
    monkeypatch.setattr(report, "_CHILD", code)
    processes = []

    def until(measuring):
        if measuring.report.part == 0.5:
            processes.append(int(measuring.report.doing))
            measuring.cancel()
        return not measuring.report.running

    kill = Process.kill  # can be slow on a busy machine
    monkeypatch.setattr(Process, "kill", lambda process: threading.Timer(0.3, kill, [process]).start())
    seen = measured(WORK, until)
    assert seen[-1] == Report(doing="cancelled")
    with pytest.raises(ProcessLookupError):  # the loop has waited for it, despite a second cancellation
        os.kill(processes[0], 0)


@pytest.mark.parametrize("kind", ["material", "reflectance"])
def test_every_thumbnail_is_a_ball(kind):
    from PIL import Image

    names = Material.names() if kind == "material" else REFLECTANCES
    shown = {name: np.asarray(Image.open(BytesIO(thumbnail(kind, name)))) for name in names}
    for image in shown.values():
        assert image.shape == (56, 56, 4)
        assert image[0, 0, 3] == 0
        assert image[28, 28, 3] == 255
        assert image[image[..., 3] == 255, :3].std() > 2
    gold = shown.get("gold", shown.get("ggx"))
    assert gold[28, 28, 0] > gold[28, 28, 2]
    with pytest.raises(ValueError, match="must be one of"):
        thumbnail("colour", next(iter(names)))
    with pytest.raises(ValueError, match="must be one of"):
        thumbnail(kind, "cheese")
