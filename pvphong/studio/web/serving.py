"""Running a studio: in its own event loop until Ctrl-C, or in the event loop of a notebook."""

from __future__ import annotations

import asyncio
import os
import socket
from contextlib import suppress
from html import escape
from pathlib import Path
from typing import Any

import pyvista as pv

from pvphong.base import check
from pvphong.base.handles import Handle
from pvphong.studio.gizmos import History
from pvphong.studio.subplot import Subplot
from pvphong.studio.web.studio import Studio

_HEIGHT = 720  # height of the page in a notebook, in pixels


class StudioFrame(Handle):
    """A studio in a notebook, shown as a page below the cell.

    Parameters
    ----------
    studio : Studio
        The studio; it runs in the notebook's event loop.
    address : str
        Address of the page.
    """

    studio: Studio
    address: str

    def __init__(self, studio: Studio, address: str) -> None:
        self.studio, self.address = studio, address

    def __repr__(self) -> str:
        return f"<Studio at {self.address}>"

    def _repr_html_(self) -> str:
        style = f"width: 100%; height: {_HEIGHT}px; border: 0"
        return f'<iframe src="{escape(self.address)}" style="{style}" title="pvphong studio"></iframe>'

    async def close(self) -> None:
        """Stop serving."""
        await self.studio.close()


def serve(
    plotter: pv.Plotter,
    subplot: Subplot,
    history: History,
    *,
    port: int,
    browser: bool,
    file: str,
    host: str,
    keep: str | os.PathLike[str] | None,
) -> StudioFrame | None:
    """Serve a studio until Ctrl-C.

    If an event loop is already running, serve it there, and return a frame that shows it. The options are those of
    `plotter.phong.studio`.

    Raises
    ------
    ValueError
        If port or host is invalid, or the server cannot listen there.
    """
    check.flag("browser", browser)
    port = free_port(host, port)
    options: dict[str, Any] = {"file": check.text("file", file), "host": host}
    if keep is not None:
        if not isinstance(keep, str | os.PathLike):
            check.refuse("keep", keep, "a path, or None", "Changed lights and materials are saved there.")
        options["keep"] = Path(keep)
    if _is_in_loop():
        studio = Studio(plotter, subplot, history, **options)
        studio.start(port)
        return StudioFrame(studio, studio.access.address_at(port))

    async def run() -> None:
        await Studio(plotter, subplot, history, **options).serve(port, browser=browser)

    with suppress(KeyboardInterrupt):
        asyncio.run(run())
    return None


def _is_in_loop() -> bool:
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return False
    return True


def free_port(host: str, port: int) -> int:
    """Return the port, or a free port if `port` is 0. The port is opened for a moment as a test.

    Raises
    ------
    ValueError
        If the port or host is invalid, or the port cannot be opened.
    """
    check.text("host", host)
    if type(port) is not int or not 0 <= port < 2**16:
        check.refuse("port", port, "a whole number from 0 to 65535", "0 chooses a free port.")
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, kind, protocol, _, address = found[0]
        with socket.socket(family, kind, protocol) as trial:
            trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            trial.bind(address)
            number: int = trial.getsockname()[1]
            return number
    except OSError as error:
        allowed = f"available on this machine at {host}"
        return check.refuse("port", f"{port} ({error.strerror or error})", allowed)
