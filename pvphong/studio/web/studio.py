"""The studio: a plotter's lit meshes and lights in a web page, and edited there.

What is edited goes from the page to `Document`, and a frame is asked for; whatever has changed, by gizmos and by code
too, is shown on the page when a frame has been drawn. Drawing, messages and files are one asyncio loop's.
"""

from __future__ import annotations

import asyncio
import inspect
import itertools
import socket
import weakref
import webbrowser
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import pyvista as pv
from aiohttp import web
from trame.app import get_server

from pvphong.meshes.lit import plan
from pvphong.meshes.surfaces import shallow_copy
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.material import Material
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.shading.plan.effects import EFFECTS
from pvphong.shading.plan.plan import Plan
from pvphong.studio.gizmos import History, commands
from pvphong.studio.subplot import Subplot
from pvphong.studio.web.document import Document
from pvphong.studio.web.door import Door, Messages
from pvphong.studio.web.page import build

_SHOW_AFTER, _PLAN_AFTER = 0.06, 0.25
"""Seconds from a frame until the page shows what has changed, and from then until the plan is made again."""

_SAID_FOR = 8.0
"""Seconds for which a line is shown."""

_numbers = itertools.count(1)


class Studio:
    """A page for one subplot of a plotter. It is made, and runs, within a running asyncio loop.

    Parameters
    ----------
    plotter : pyvista.Plotter
        What is shown.
    subplot : Subplot
        Its active subplot, which has gizmos.
    history : History
        The plotter's.
    title : str
        What the page is called.
    host : str
        The address to listen on.
    """

    def __init__(
        self, plotter: pv.Plotter, subplot: Subplot, history: History, *, title: str, host: str = "127.0.0.1"
    ) -> None:
        self._plotter, self._subplot, self._host = plotter, subplot, host
        self.document = Document(plotter.phong, subplot, history)
        self.door = Door(host)
        self._loop = asyncio.get_running_loop()
        self._show_soon: asyncio.TimerHandle | None = None
        self._plan_soon: asyncio.TimerHandle | None = None
        self._hush_soon: asyncio.TimerHandle | None = None
        self._planned_for: Any = None
        self.server = get_server(f"pvphong studio {next(_numbers)}", client_type="vue3")
        state = self.server.state
        state.title = title
        state.material_names = list(Material.names())
        state.reflectance_names = [{"title": "the light model's", "value": ""}, *REFLECTANCES]
        state.plan = {"accuracy": "", "meshes": []}
        state.update(self.document.shown())
        self._triggers = {name: self._trigger(act) for name, act in self._acts.items()}
        for name, trigger in self._triggers.items():
            self.server.controller.trigger(name)(trigger)
        kinds = {name: (kind.__doc__ or "").splitlines()[0] for name, kind in LIGHT_TYPES.items()}
        self._view = build(self.server, plotter, kinds)
        self.server.controller.on_server_bind.add(self._bind)
        studio = weakref.ref(self)

        def drawn(_renderer: Any, _event: str) -> None:
            if (alive := studio()) is not None:
                alive.show()

        self._tag = subplot.renderer.AddObserver("EndEvent", drawn)

    # -- what the page may trigger

    @property
    def _acts(self) -> dict[str, Callable[..., Any]]:
        document = self.document
        return {
            "edit": document.edit,
            "slide": document.slide,
            "settle": document.settle,
            "add": document.add,
            "act": document.act,
            "select": document.select,
            "choose_material": document.choose_material,
            "choose_reflectance": document.choose_reflectance,
            "undo": lambda: None if document.undo() else "nothing to undo",
            "redo": lambda: None if document.redo() else "nothing to redo",
            "fit": self._plotter.reset_camera,
            "gizmos": lambda: commands.toggle_hidden(document.gizmos),
            "theme": self._turn_theme,
        }

    def _trigger(self, act: Callable[..., Any]) -> Callable[..., None]:
        """What does one of the acts, says what comes of it, and has a frame drawn; what is refused changes nothing."""
        signature = inspect.signature(act)

        def trigger(*args: Any) -> None:
            try:
                signature.bind(*args)
                said = act(*args)
            except (ValueError, TypeError) as error:
                said = str(error)
                self.server.state.refusals += 1
            if isinstance(said, str) and said:
                self.say(said)
            self.draw()
            self.show()

        return trigger

    def _turn_theme(self) -> None:
        state = self.server.state
        state.theme = "light" if state.theme == "dark" else "dark"

    # -- what the page shows

    def say(self, text: str) -> None:
        """Show one line for a while."""
        with self.server.state as state:
            state.notice = text
        if self._hush_soon is not None:
            self._hush_soon.cancel()
        self._hush_soon = self._loop.call_later(_SAID_FOR, self._hush)

    def _hush(self) -> None:
        with self.server.state as state:
            state.notice = ""

    def draw(self) -> None:
        """Ask for a frame; several that are asked for before one is drawn are one."""
        self._view.render()

    def show(self) -> None:
        """Show soon what has changed."""
        if self._show_soon is None and not self._loop.is_closed():
            self._show_soon = self._loop.call_later(_SHOW_AFTER, self._show)

    def _show(self) -> None:
        self._show_soon = None
        with self.server.state as state:
            state.update(self.document.shown())
        if self._plan_soon is not None:
            self._plan_soon.cancel()
        self._plan_soon = self._loop.call_later(_PLAN_AFTER, self._show_plan)

    def _show_plan(self) -> None:
        self._plan_soon = None
        scene, meshes, tolerance = self._subplot.scene, self._subplot.lit.shown, self.document.accuracy.tolerance
        known = scene, [(mesh, mesh.material, mesh.geometry()) for mesh in meshes], tolerance
        if known == self._planned_for:
            return
        self._planned_for, shown = known, []
        for mesh in meshes:
            lit = shallow_copy(mesh.drawn)
            lit.point_data.active_normals = mesh.normals
            others = [(other.drawn, other.matrix) for other in meshes if other is not mesh and other.casts_shadows]
            with suppress(ValueError):  # the view says why it cannot be lit
                options: dict[str, Any] = {"matrix": mesh.matrix, "tolerance": tolerance, "occluders": others}
                made = plan(lit, scene, mesh.material, **options)
                shown.append({"name": self.document.mesh_name(mesh), "rows": _rows(made), "accuracy": _accuracy(made)})
        with self.server.state as state:
            state.plan = {"accuracy": shown[0]["accuracy"] if shown else "", "meshes": shown}

    # -- the server

    def _bind(self, server: Any) -> None:
        """The web server has been made, and does not listen yet."""
        messages = Messages(self.server.protocol, server, self._triggers, self.document.settle)

        @web.middleware
        async def to_messages(request: web.Request, handler: Any) -> web.StreamResponse:
            """In place of wslink's own end of the WebSocket."""
            return await (messages.handleWsRequest if request.path == "/ws" else handler)(request)

        self.door.guard(server.app)
        server.app.middlewares.append(to_messages)

        async def end(_app: web.Application) -> None:
            await messages.disconnectClients()

        server.app.on_shutdown.append(end)

    def address_at(self, port: int) -> str:
        """Where the page is, served on a port."""
        host = self._host
        if host in ("0.0.0.0", "::"):
            host = socket.gethostname()
            try:
                socket.getaddrinfo(host, None)
            except OSError:
                host = "127.0.0.1"
        return f"http://{f'[{host}]' if ':' in host else host}:{port}/{self.door.query}"

    def start(self, port: int) -> Any:
        """Begin to serve; gives the task that ends with the server."""
        return self.server.start(
            port=port,
            host=self._host,
            thread=True,  # without handlers of signals
            open_browser=False,
            show_connection_info=False,
            disable_logging=True,
            exec_mode="task",
            timeout=0,
        )

    async def serve(self, port: int, *, browser: bool) -> None:
        """Serve until cancelled; the address is printed on a line of its own."""
        task = self.start(port)
        await asyncio.wait([task, self.server.ready], return_when=asyncio.FIRST_COMPLETED)
        if task.done():
            task.result()
        address = self.address_at(self.server.port)
        print(address, flush=True)
        if browser:
            webbrowser.open(address)
        try:
            await asyncio.shield(task)
        finally:
            await self.close()

    async def close(self) -> None:
        """Stop serving, and let go of the plotter."""
        for soon in (self._show_soon, self._plan_soon, self._hush_soon):
            if soon is not None:
                soon.cancel()
        self._subplot.renderer.RemoveObserver(self._tag)
        await self._view.handler.close()
        await self.server.stop()


def _rows(made: Plan) -> list[list[str]]:
    """A row for each effect: name, on or off, why, its error bound, nanoseconds a vertex."""
    rows = []
    for effect in EFFECTS:
        decision = made.effects[effect.name]
        bound = f"{decision.bound:.2g}" if decision.bound else ""
        cost = f"{effect.nanoseconds(decision):.1f}" if decision.on else ""
        rows.append([effect.name, "on" if decision.on else "off", decision.why, bound, cost])
    return rows


def _accuracy(made: Plan) -> str:
    """What a plan's colours may be off by, and what it costs."""
    error = f"off by at most {made.error_bound:.3g}" if made.error_bound else "exact"
    cost = sum(effect.nanoseconds(made.effects[effect.name]) for effect in EFFECTS)
    depends = "change" if made.view_dependent else "do not change"
    return f"Colours are {error}; about {cost:.1f} ns a vertex; they {depends} when the viewer moves."
