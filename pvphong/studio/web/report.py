"""The accuracy report, measured in a separate process to keep the view responsive.

The process runs at low priority. It reads mesh and scene from a file and prints its progress. It can be cancelled.
"""

from __future__ import annotations

import asyncio
import json
import os
import pickle
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pyvista as pv
from aiohttp import web

from pvphong.base.processes import environment
from pvphong.base.text import listening
from pvphong.optics.maps import is_texture

_CHILD = "import sys; from pvphong.studio.web.report import work; work(sys.argv[1])"
_NICE = 10
_STEP = 0.01  # smallest progress between two printed lines


@dataclass(frozen=True)
class Report:
    """The result or the progress of a measurement.

    Parameters
    ----------
    running : bool
        True while the measurement is running.
    doing : str
        The current step, or the reason why there is no result.
    part : float
        Progress of the step, from 0 to 1.
    lines : list of str
        Summary of the report.
    worst : list
        Vertices with the largest errors: index, error, and position in the mesh's coordinates.
    figure : bytes
        The report's figure, a .png; empty if it could not be drawn.
    """

    running: bool = False
    doing: str = ""
    part: float = 0.0
    lines: list[str] = field(default_factory=list)
    worst: list[tuple[int, float, tuple[float, float, float]]] = field(default_factory=list)
    figure: bytes = b""


class Measuring:
    """Runs the measurements for reports, one at a time.

    Parameters
    ----------
    changed : callable
        Called after each change of `report`.
    """

    def __init__(self, changed: Callable[[], None]) -> None:
        self.report = Report()
        self._changed = changed
        self._task: asyncio.Task[None] | None = None

    def start(self, work: dict[str, Any]) -> None:
        """Start a measurement. If another is running, cancel it.

        Parameters
        ----------
        work : dict
            Arguments of `tradeoff`.
        """
        self.cancel()
        self._show(Report(running=True, doing="starting"))
        self._task = asyncio.get_running_loop().create_task(self._run(work))

    def cancel(self) -> None:
        """Cancel a running report."""
        if self._task is not None:
            self._task.cancel()
            self._task = None
        if self.report.running:
            self._show(Report(doing="cancelled"))

    async def answer(self, _request: web.Request) -> web.StreamResponse:
        """Answer an HTTP request for the report's figure."""
        figure = self.report.figure
        return web.Response(body=figure, content_type="image/png") if figure else web.Response(status=404)

    def _show(self, report: Report) -> None:
        self.report = report
        self._changed()

    async def _run(self, work: dict[str, Any]) -> None:
        try:
            await self._measure(work)
        except Exception as error:  # else an error in a task is silent, and the page would wait for ever
            self._show(Report(doing=f"The report could not be made: {error}"))

    async def _measure(self, work: dict[str, Any]) -> None:
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder)
            with (place / "work").open("wb") as file:
                _Pickler(file, protocol=5).dump(work)
            child = await asyncio.create_subprocess_exec(
                *(sys.executable, "-W", "ignore", "-c", _CHILD, folder),
                stdin=asyncio.subprocess.DEVNULL,
                stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.DEVNULL,
                env=environment(),
            )
            assert child.stdout is not None
            try:
                async for line in child.stdout:
                    doing, part = json.loads(line)
                    self._show(Report(running=True, doing=doing, part=part))
                await child.wait()
                self._show(_result(place))
            finally:
                with suppress(ProcessLookupError):
                    child.kill()
                while child.returncode is None or not child.stdout.at_eof():
                    with suppress(asyncio.CancelledError):  # cancelled again: end the process first
                        await child.communicate()


class _Pickler(pickle.Pickler):
    """A pickler that also supports textures, which VTK cannot pickle."""

    def reducer_override(self, thing: Any) -> Any:
        """Return a function and its arguments that rebuild a texture. Other objects are pickled by default."""
        if isinstance(thing, type) or not is_texture(thing) or thing.GetInput() is None:
            return NotImplemented
        settings = thing.GetWrap(), thing.GetBorderColor(), thing.GetUseSRGBColorSpace(), thing.GetColorMode()
        return _texture, (pv.wrap(thing.GetInput()), *settings)


def _texture(image: pv.ImageData, wrap: int, border: Any, is_encoded: bool, color_mode: int) -> pv.Texture:
    """Return a texture with an image and settings. `is_encoded` is true for an image in sRGB.

    These are all the settings that affect sampling.
    """
    texture = pv.Texture(image)
    texture.SetWrap(wrap)
    texture.SetBorderColor(*border)
    texture.SetUseSRGBColorSpace(is_encoded)
    texture.SetColorMode(color_mode)
    return texture


def _result(folder: Path) -> Report:
    """Return the report that the separate process has written to `folder`."""
    try:
        found = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    except OSError:
        return Report(doing="The report could not be made: its process has crashed.")
    figure = folder / "figure.png"
    return Report(**found, figure=figure.read_bytes() if figure.exists() else b"")


def work(folder: str) -> None:
    """Measure in the separate process. The files in `folder` have the arguments, and get the results."""
    with suppress(AttributeError, OSError):  # not available on all platforms
        os.nice(_NICE)
    place = Path(folder)
    given = pickle.loads((place / "work").read_bytes())
    said: tuple[str, float] = ("", -1.0)

    def say(doing: str, part: float) -> None:
        nonlocal said
        if doing != said[0] or part - said[1] >= _STEP:
            said = doing, part
            print(json.dumps(said), flush=True)

    from pvphong.studies.accuracy.measure import tradeoff  # late, as it loads VTK's rendering

    try:
        with listening(say):
            report = tradeoff(**given)
        say("drawing", 1.0)
        points = report.surface.points
        found: dict[str, Any] = {
            "lines": [line.strip() for line in report.summary()],
            "worst": [(index, error, tuple(map(float, points[index]))) for index, error in report.worst()],
        }
        with suppress(ValueError, ImportError):  # Matplotlib is optional
            report.plot(place / "figure.png")
    except ValueError as error:
        found = {"doing": str(error)}
    (place / "report.json").write_text(json.dumps(found), encoding="utf-8")
