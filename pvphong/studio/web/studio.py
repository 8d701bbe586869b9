"""The studio: a web page that shows and edits a plotter's lit meshes and lights.

An edit goes from the page to a trigger of `Studio`, which calls `Document` and then requests a frame. After each frame,
the page shows all changes, including those by gizmos and code. Drawing, messages and files share one asyncio loop.
"""

from __future__ import annotations

import asyncio
import inspect
import itertools
import socket
import weakref
import webbrowser
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path, PurePath
from typing import Any

import numpy as np
import pyvista as pv
from aiohttp import web
from pyvista import examples
from trame.app import get_server

from pvphong.base import check
from pvphong.base.types import Float64Array
from pvphong.meshes import colormaps
from pvphong.meshes.blocks import DEFAULT, map_blocks
from pvphong.meshes.files import read, read_texture
from pvphong.meshes.lit import plan
from pvphong.meshes.pictures import refuse_size
from pvphong.meshes.surfaces import shallow_copy, surface
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.maps import IMAGES, is_image_path
from pvphong.optics.material import Material
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.scene.scene import Scene, load_materials
from pvphong.shading.plan.effects import EFFECTS
from pvphong.shading.plan.plan import Plan
from pvphong.studio.gizmos import History, commands
from pvphong.studio.subplot import Subplot
from pvphong.studio.web.access import Access, Messages, upload
from pvphong.studio.web.document import Document
from pvphong.studio.web.downloads import EXAMPLES, LIT, Downloads, reading_file
from pvphong.studio.web.fields import number_in
from pvphong.studio.web.framing import Framing
from pvphong.studio.web.instruments import Instruments
from pvphong.studio.web.messages import Remedy, in_page_words, remedies
from pvphong.studio.web.opening import OpenFile, Opening
from pvphong.studio.web.page import build
from pvphong.studio.web.report import Measuring, Report
from pvphong.studio.web.thumbnails import thumbnail

_SHOW_AFTER, _PLAN_AFTER, _ASK_AGAIN = 0.06, 0.25, 0.1
"""Seconds from a frame until the page is updated, from then until the plan is updated, and between two polls for
background results."""

_SAID_FOR = 8.0
"""Seconds for which a notice is shown."""

MESHES = (".vtp", ".vtu", ".vtk", ".vti", ".vts", ".vtr", ".vtkhdf", ".ply", ".stl", ".obj", ".glb", ".gltf")
SKIES = (".hdr", ".png", ".jpg", ".jpeg")
"""Suffixes of the files that can be uploaded."""

_BUDGET = 10.0
"""Seconds after which refining pauses, until the page asks for more."""

_MARKS = "pvphong worst vertices"

_EDITS = (
    *(
        "edit",
        "slide",
        "settle",
        "add",
        "set_up",
        "set_temperature",
        "act",
        "select",
        "choose_material",
        "choose_reflectance",
    ),
    "set_colormap",
    *("start_mix", "solo_fader", "keep_mix", "cancel_bounces", "cancel_refining", "go_on_refining"),
)
"""Methods of the document that the page can trigger."""

_numbers = itertools.count(1)


class Studio:
    """A web page for one subplot of a plotter. It must be created within a running asyncio loop.

    Parameters
    ----------
    plotter : pyvista.Plotter
        The plotter.
    subplot : Subplot
        The plotter's active subplot, with gizmos.
    history : History
        The plotter's undo history.
    file : str
        Name of the mesh's file, for the script to download.
    host : str
        The address to listen on.
    keep : Path, optional
        File to which the rig is written after each change, while the mesh is shown.
    """

    def __init__(
        self,
        plotter: pv.Plotter,
        subplot: Subplot,
        history: History,
        *,
        file: str,
        host: str = "127.0.0.1",
        keep: Path | None = None,
    ) -> None:
        self._plotter, self._subplot, self._host = plotter, subplot, host
        shown = OpenFile(PurePath(file).stem, reading_file(file), keep)
        self._opening = Opening(plotter, subplot, shown, self._forget_report)
        self.document = Document(plotter.phong, subplot, history, self._opening)
        self.access = Access(host)
        self._loop = asyncio.get_running_loop()
        subplot.lit.is_in_a_page = True
        self._samples = plotter.render_window.GetMultiSamples()
        plotter.render_window.SetMultiSamples(0)  # on a CPU, a frame with four samples takes five times as long
        self._due: dict[Callable[[], None], asyncio.TimerHandle] = {}
        self._planned_for: Any = None
        self._serving: Any = None
        self._measuring = Measuring(self._measured)
        self._measured_matrix: Float64Array | None = None
        self._reports = 0
        self._instruments = Instruments(self.document, subplot, self._later, self.draw, self.say, self._put)
        self.server = get_server(f"pvphong studio {next(_numbers)}", client_type="vue3")
        names = {"example_names": list(EXAMPLES), "material_names": list(Material.names())}
        names |= {"reflectance_names": ["", *REFLECTANCES], "colormap_names": sorted(colormaps.names(), key=str.lower)}
        at_first = {"plan": {"accuracy": "", "meshes": []}, "script": "", "report": vars(Report()) | {"figure": ""}}
        self.server.state.update(names | at_first | Instruments.at_first | {"marked": False} | self._shown())
        self._triggers = {name: self._trigger(name, getattr(self.document, name)) for name in _EDITS}
        self._triggers |= {name: self._trigger(name, act) for name, act in self._acts.items()}
        for name, trigger in self._triggers.items():
            self.server.controller.trigger(name)(trigger)
        kinds = {name: (kind.__doc__ or "").splitlines()[0].replace("`", "") for name, kind in LIGHT_TYPES.items()}
        self._view = build(self.server, plotter, kinds)
        self.server.controller.on_server_bind.add(self._bind)
        studio = weakref.ref(self)

        def drawn(_renderer: Any, _event: str) -> None:
            if (alive := studio()) is not None and not alive._instruments.histogram.is_counting:
                alive.show()

        self._tag = subplot.renderer.AddObserver("EndEvent", drawn)
        self._framing = Framing(subplot.renderer)

    # -- triggers of the page

    @property
    def _acts(self) -> dict[str, Callable[..., Any]]:
        """Triggers that are not methods of the document, or that add a message to such a method."""
        document = self.document
        return {
            "undo": lambda: None if document.undo() else "nothing to undo",
            "redo": lambda: None if document.redo() else "nothing to redo",
            "type_number": self.type_number,
            "report": self.measure,
            "cancel_report": self._measuring.cancel,
            "mark_worst": self.mark_worst,
            "open_example": self.open_example,
            "fit": lambda: self._subplot.renderer.reset_camera(render=False),  # each trigger ends with a frame
            "gizmos": lambda: commands.toggle_hidden(document.gizmos),
            "theme": self._turn_theme,
            **self._instruments.triggers,
        }

    def _trigger(self, name: str, act: Callable[..., Any]) -> Callable[..., None]:
        """Return a trigger that calls `act`, shows its message or its error, and requests a frame."""
        signature = inspect.signature(act)

        def trigger(*args: Any) -> None:
            buttons: list[Remedy] = []
            try:
                signature.bind(*args)
                said = act(*args)
            except (ValueError, TypeError) as error:
                said = str(error)
                buttons = remedies(said, name, args)
                self.server.state.refusals += 1
            self._instruments.triggered(name)
            self._done(said, buttons)

        return trigger

    def _done(self, said: Any, buttons: Sequence[Remedy] = ()) -> None:
        """Show the message of an action, if any. Request a frame and an update of the page."""
        if isinstance(said, str) and said:
            self.say(said, buttons)
        elif self.server.state.remedies:  # the error that they belong to is out of date
            self._hush()
        self.draw()
        self.show()

    def _forget_report(self) -> None:
        """End a measurement and hide its marks, because they belong to another mesh."""
        self._measuring.cancel()
        self.mark_worst(False)

    def _turn_theme(self) -> None:
        state = self.server.state
        state.theme = "light" if state.theme == "dark" else "dark"

    # -- state of the page

    def say(self, text: str, buttons: Sequence[Remedy] = ()) -> None:
        """Show a notice for a while, in the page's words, with buttons for remedies."""
        with self.server.state as state:
            state.update({"notice": in_page_words(text), "remedies": [each._asdict() for each in buttons]})
        self._later(_SAID_FOR, self._hush)

    def _hush(self) -> None:
        with self.server.state as state:
            state.update({"notice": "", "remedies": []})

    def _later(self, seconds: float, act: Callable[[], None]) -> None:
        """Schedule a call after `seconds`. If the call is scheduled already, change its time."""
        if act in self._due:
            self._due[act].cancel()

        def do() -> None:
            del self._due[act]
            act()

        self._due[act] = self._loop.call_later(seconds, do)

    def draw(self) -> None:
        """Request a frame. Several requests before the frame is drawn result in one frame."""
        self._view.render()

    def show(self) -> None:
        """Schedule an update of the page."""
        if self._show not in self._due and not self._loop.is_closed():
            self._later(_SHOW_AFTER, self._show)

    def _shown(self) -> dict[str, Any]:
        meshes = self._subplot.lit.shown
        points = sum(mesh.drawn.n_points for mesh in meshes)
        title = f"{self._opening.file.stem}: {points:,} points" if meshes else "no mesh"
        of_meshes = {"title": title, "has_mesh": bool(meshes), "mesh_count": len(meshes)}
        shown = self.document.shown()
        lit_by = ", ".join(light["called"] for light in shown["lights"] if light["on"]["value"]) or "no light"
        of_meshes |= {"view_text": f"{title}; lit by {lit_by}"}
        return shown | self._awaited() | of_meshes | self._instruments.shown()

    def _awaited(self) -> dict[str, Any]:
        """Return the progress of background computations, and the result of refining."""
        part, refining = self._subplot.lit.gathering.part, self._subplot.lit.refining
        awaited = [each for each in refining.values() if each.is_awaited]
        return {
            "gathering": None if part is None else round(100.0 * part),
            "refining": round(100.0 * min(each.part for each in awaited)) if awaited else None,
            "refining_paused": any(each.is_paused for each in awaited),
            "refined": self._refined(),
        }

    def _refined(self) -> str:
        """Return a text on the refined picture that is shown; "" if nothing is refined."""
        refining = self._subplot.lit.refining
        if not refining:
            return ""
        awaited = [each for each in refining.values() if each.is_awaited]
        reason = next((each.reason for each in refining.values() if each.reason), "")
        if self.document.mix.is_on:
            return "not refined: a mix is on"
        added = sum(mesh.actor.mapper.dataset.n_points - mesh.drawn.n_points for mesh in refining if mesh.actor)
        if not added and (awaited or reason):
            return "refining" if awaited else f"not refined: {reason}"
        said = f"refined, {added:,} points added" if added else ""
        if not awaited and not reason:
            return said
        reached = [each.reached or 0.0 for each in refining.values()]
        within = f", error up to {max(reached):.2g}" if all(reached) else ""
        return said + within + (f"; {reason}" if reason else " so far")

    def _show(self) -> None:
        with self.server.state as state:
            state.update(self._shown())
        if self._ask not in self._due:
            self._ask()
        self._later(_PLAN_AFTER, self._show_plan)
        self._instruments.drawn()

    def _put(self, values: dict[str, Any]) -> None:
        """Set values of the page's state."""
        with self.server.state as state:
            state.update(values)

    def _ask(self) -> None:
        """Poll for background results and draw them. Repeat this while results are awaited."""
        lit = self._subplot.lit
        if lit.is_awaiting:
            for refining in lit.refining.values():
                if refining.seconds >= _BUDGET:
                    refining.pause()
            if lit.refresh():
                self.draw()
            with self.server.state as state:
                state.update(self._awaited())
            self._later(_ASK_AGAIN, self._ask)

    def _show_plan(self) -> None:
        scene, meshes, tolerance = self._subplot.scene, self._subplot.lit.shown, self.document.accuracy.tolerance
        known = scene, [(mesh, mesh.material, mesh.geometry()) for mesh in meshes], tolerance
        if known == self._planned_for:
            return
        self._planned_for, shown = known, []
        for mesh in meshes:
            lit = shallow_copy(mesh.drawn)
            lit.point_data.active_normals = mesh.normals
            with suppress(ValueError):  # the view shows why the mesh cannot be lit
                where: dict[str, Any] = {"matrix": mesh.matrix, "occluders": self._subplot.lit.others(mesh)}
                made = plan(lit, scene, mesh.material, tolerance=tolerance, **where)
                shown.append({"name": self.document.mesh_name(mesh), "rows": _rows(made), "accuracy": _accuracy(made)})
        try:
            script = self.downloads.script()
        except ValueError as error:
            script = f"# {error}"
        with self.server.state as state:
            state.plan = {"accuracy": shown[0]["accuracy"] if shown else "", "meshes": shown}
            state.script = script
        self._save()

    def _save(self) -> None:
        """Save the rig, if `keep` was given."""
        if (keep := self._opening.file.keep) is not None:
            try:
                self.downloads.save_rig(keep)
            except ValueError:  # its message contains the whole path
                self.say(f"The rig is not saved: {keep.name} cannot be written, or a map is an array without a name.")

    # -- meshes and files

    @contextmanager
    def _active(self) -> Iterator[None]:
        """Return a context in which the studio's subplot is the plotter's active one. A script may have activated
        another subplot.
        """
        renderers = self._plotter.renderers
        before, own = renderers.active_index, list(renderers).index(self._subplot.renderer)

        def activate(index: int) -> None:
            self._plotter.subplot(*np.atleast_1d(renderers.index_to_loc(index)).tolist())

        activate(own)
        try:
            yield
        finally:
            activate(before)

    def open(self, mesh: Any, file: str, reading: str = "") -> None:
        """Show another mesh, as one undo step. Lights are kept and moved to fit; see `Opening.open`.

        Parameters
        ----------
        mesh : pyvista.DataSet or pyvista.MultiBlock
            A mesh with a surface.
        file : str
            Name of the mesh's file.
        reading : str
            Python expression for the mesh; by default one that reads the file.

        Raises
        ------
        ValueError
            If the mesh has no surface to light; nothing is changed then.
        """
        outside = map_blocks(mesh, surface) if isinstance(mesh, pv.MultiBlock) else surface(mesh)
        with self._active():
            self.document.open(outside, OpenFile(PurePath(file).stem, reading or reading_file(file)))

    def open_example(self, name: str) -> None:
        """Show one of PyVista's example meshes."""
        function = EXAMPLES[check.choice("name", name, EXAMPLES)]
        self.open(getattr(examples, function)(), name, f"pv.examples.{function}()")

    @property
    def downloads(self) -> Downloads:
        """The downloads of the current state. While a background computation runs, they are as the view shows them."""
        meshes = {self.document.mesh_name(mesh): mesh for mesh in self._subplot.lit.shown}
        tolerance = self.document.accuracy.tolerance
        textures = self.document.textures
        is_as_shown = self._subplot.lit.is_awaiting and not self._subplot.lit.softening.is_awaited  # which ends soon
        file, scene = self._opening.file, self._subplot.scene
        if scene.viewer is not None:
            scene = replace(scene, viewer=self._framing.in_a_wide_view(scene.viewer))
        return Downloads(meshes, scene, tolerance, file.reading, file.stem, textures, is_as_shown)

    async def _give(self, request: web.Request) -> web.StreamResponse:
        """Answer a request for a download."""
        self.mark_worst(False)
        what, downloads = request.match_info["what"], self.downloads
        try:
            width, height = (request.query.get(name, "0") for name in ("width", "height"))  # only for pictures
            size = _whole("width", width), _whole("height", height)
            if what in LIT and not downloads.is_as_shown:
                await asyncio.to_thread(lambda: downloads.lit)  # slow with bounces
            with self._active():
                name, content = downloads.read(what, self._plotter, size)
        except ValueError as error:
            self.say(str(error))
            return web.Response(status=400, text=str(error))
        if what in LIT and downloads.is_as_shown:
            self.say(f"{name} is as the view shows it now, with 8-bit colours. {self._unfinished()}")
        heading = {"Content-Disposition": f'attachment; filename="{name}"', "Cache-Control": "no-store"}
        return web.Response(body=content, headers=heading, content_type="application/octet-stream")

    def _unfinished(self) -> str:
        """Return a sentence on the background computation that a download did not wait for."""
        is_gathering = self._subplot.lit.gathering.part is not None
        doing = "Bounced light is" if is_gathering else "The refined view is"
        return f"{doing} not complete yet; for exact colours, download it again later."

    async def _take_mesh(self, name: str, path: Path, _query: Mapping[str, str]) -> None:
        self.open(await asyncio.to_thread(read, path, guarded=True), name)

    async def _take_rig(self, _name: str, path: Path, query: Mapping[str, str]) -> None:
        scene, materials = Scene.load(path), load_materials(path)
        for material in materials.values():
            for field, given in material.maps.items():
                if is_image_path(given):
                    allowed, remedy = "a value in an uploaded rig, not an image file", "Upload the image as a texture."
                    check.refuse(field, PurePath(str(given)).name, allowed, remedy)
        if query.get("part") == "material":
            if not materials:
                check.refuse("rig", "a rig without materials", "a rig with at least one material")
            scene = self._subplot.scene
        self.document.replace_all(scene, materials, DEFAULT)

    async def _take_sky(self, _name: str, path: Path, query: Mapping[str, str]) -> None:
        image = await asyncio.to_thread(read, path, guarded=True)
        await self.document.set_image(query.get("light", ""), image)

    async def _take_texture(self, name: str, path: Path, query: Mapping[str, str]) -> None:
        field = query.get("field", "")
        texture = await asyncio.to_thread(read_texture, str(path), field)
        self.document.set_texture(query.get("material", ""), field, texture, name)

    # -- numbers outside the document, and the accuracy report

    def type_number(self, name: Any, given: Any) -> None:
        """Set a typed number: the report's "seconds", or "width" or "height" of a picture."""
        state = self.server.state
        if check.choice("name", name, ("seconds", "width", "height")) == "seconds":
            state.seconds = _seconds(given)
            return
        size = {"width": state.width, "height": state.height} | {name: _whole(name, given)}
        refuse_size((size["width"], size["height"]))
        state.update(size)

    def measure(self, seconds: Any) -> None:
        """Start measuring accuracy against time, in the background.

        Parameters
        ----------
        seconds : float or str
            Time limit, as a number or text.
        """
        seconds = _seconds(seconds)
        meshes = self._subplot.lit.shown
        if not meshes:
            check.refuse("mesh", "none", "open", "Open a mesh first.")
        self.mark_worst(False)
        measured = max(meshes, key=lambda mesh: mesh.drawn.n_points)
        self._measured_matrix = measured.matrix
        self._measuring.start(
            {
                "mesh": measured.mesh,
                "scene": self._subplot.scene,
                "material": measured.material,
                "tolerance": self.document.accuracy.tolerance or 1.0 / 255.0,
                "seconds": seconds,
                "matrix": self._measured_matrix,
                "feature_angle": measured.feature_angle,
                "occluders": self._subplot.lit.others(measured),
            }
        )

    def _measured(self) -> None:
        """Show the changed report."""
        report = self._measuring.report
        if report.figure:
            self._reports += 1
        with self.server.state as state:
            state.report = vars(report) | {"figure": f"report/{self._reports}.png" if report.figure else ""}

    async def _figure(self, _request: web.Request) -> web.StreamResponse:
        figure = self._measuring.report.figure
        return web.Response(body=figure, content_type="image/png") if figure else web.Response(status=404)

    def mark_worst(self, on: Any) -> None:
        """Show or hide marks at the vertices with the largest errors."""
        self._subplot.renderer.remove_actor(_MARKS, render=False)
        places = [place for _, _, place in self._measuring.report.worst]
        if check.flag("on", on) and places:
            look: dict[str, Any] = {"color": "magenta", "point_size": 12, "render_points_as_spheres": True}
            with self._active():
                marks = self._plotter.add_points(
                    np.array(places), name=_MARKS, lighting=False, pickable=False, reset_camera=False, **look
                )
            marks.UseBoundsOff()
            marks.user_matrix = self._measured_matrix
        self.server.state.marked = on and bool(places)

    def _left(self, in_mid_drag: bool) -> None:
        """Handle a client's disconnection. Cancel its drag in the view, if there is one."""
        self.document.settle()
        if in_mid_drag:
            if self._subplot.interaction is not None:
                self._subplot.interaction.give_up()
            self._plotter.iren.interactor.InvokeEvent("LeftButtonReleaseEvent")
            self._done("The connection was lost during a drag. The light is back at its old position.")

    # -- the server

    def _bind(self, server: Any) -> None:
        """Configure the web server before it listens."""
        messages = Messages(self.server.protocol, server, self._triggers, self._left, self._instruments.scale)

        @web.middleware
        async def to_messages(request: web.Request, handler: Any) -> web.StreamResponse:
            """Replace wslink's own handler of the WebSocket."""
            return await (messages.handleWsRequest if request.path == f"{self.access.root}ws" else handler)(request)

        self.access.guard(server.app)
        server.app.middlewares.append(to_messages)

        async def end(_app: web.Application) -> None:
            await messages.disconnectClients()

        server.app.on_shutdown.append(end)
        server.app.router.add_post("/paraview/", _no_launcher)
        server.app.router.add_get("/take/{what}", self._give)
        server.app.router.add_get("/report/{number}.png", self._figure)
        self._instruments.add_routes(server.app.router)
        server.app.router.add_get("/thumbnail/{kind}/{name}", _thumbnail)
        for what, suffixes, take in (
            ("mesh", MESHES, self._take_mesh),
            ("rig", (".json",), self._take_rig),
            ("sky", SKIES, self._take_sky),
            ("texture", IMAGES, self._take_texture),
        ):
            server.app.router.add_post(f"/bring/{what}", upload(suffixes, take, self._done))

    def address_at(self, port: int) -> str:
        """Return the address of the page on a port."""
        host = self._host
        if host in ("0.0.0.0", "::"):
            host = socket.gethostname()
            try:
                socket.getaddrinfo(host, None)
            except OSError:
                host = "127.0.0.1"
        return f"http://{f'[{host}]' if ':' in host else host}:{port}{self.access.root}"

    def start(self, port: int) -> None:
        """Start serving."""
        self._serving = self.server.start(
            port=port,
            host=self._host,
            thread=True,  # no signal handlers
            open_browser=False,
            show_connection_info=False,
            disable_logging=True,
            exec_mode="task",
            timeout=0,
        )

    async def _begun(self) -> None:
        """Wait until the server listens or fails."""
        ready = self.server.ready
        await asyncio.wait([self._serving, ready], return_when=asyncio.FIRST_COMPLETED)
        if ready.done():
            ready.exception()  # retrieve it: asyncio logs exceptions that are not retrieved

    async def serve(self, port: int, *, browser: bool) -> None:
        """Serve until cancelled. At the start, print the address on a line."""
        self.start(port)
        try:
            await self._begun()
            if self._serving.done():
                self._serving.result()  # raises the reason
            address = self.address_at(self.server.port)
            print(address, flush=True)
            if browser:
                webbrowser.open(address)
            await asyncio.shield(self._serving)
        finally:
            await self.close()

    async def close(self) -> None:
        """Stop serving and detach from the plotter."""
        self._save()
        for due in self._due.values():
            due.cancel()
        self._subplot.renderer.RemoveObserver(self._tag)
        self._framing.release()
        self._instruments.release()
        self._subplot.lit.is_in_a_page = False
        if self._plotter.render_window is not None:
            self._plotter.render_window.SetMultiSamples(self._samples)
        self._subplot.lit.stop()
        self.document.mix.release()
        self._measuring.cancel()
        await self._view.handler.close()
        await self._begun()  # a server that has not started cannot be stopped
        await self.server.stop()


def _seconds(given: Any) -> float:
    """Return the seconds for a report, from a number or text."""
    return check.number("seconds", number_in("seconds", given), at_least=1.0, at_most=600.0)


def _whole(name: str, given: Any) -> int:
    """Return a whole number, from a number or text."""
    number = number_in(name, given)
    return int(number) if number.is_integer() else check.refuse(name, given, "a whole number")


async def _no_launcher(_request: web.Request) -> web.StreamResponse:
    """Answer trame's page, which asks at the start whether a launcher has a session for it: there is no launcher.

    The page then connects to the server that it comes from. An error would have the same effect, but browsers log it.
    """
    return web.Response(status=204)


async def _thumbnail(request: web.Request) -> web.StreamResponse:
    """Answer a request for the thumbnail of a material or reflectance."""
    try:
        image = await asyncio.to_thread(thumbnail, request.match_info["kind"], request.match_info["name"])
    except ValueError:
        return web.Response(status=404)
    return web.Response(body=image, content_type="image/png", headers={"Cache-Control": "max-age=3600"})


def _rows(made: Plan) -> list[list[str]]:
    """Return a row for each effect: name, on or off, reason, error bound, nanoseconds per vertex."""
    rows = []
    for effect in EFFECTS:
        decision = made.effects[effect.name]
        bound = f"{decision.bound:.2g}" if decision.bound else ""
        cost = f"{effect.nanoseconds(decision):.1f}" if decision.on else ""
        rows.append([effect.name, "on" if decision.on else "off", decision.why, bound, cost])
    return rows


def _accuracy(made: Plan) -> str:
    """Return a sentence on the error and the cost of a plan."""
    error = f"off by at most {made.error_bound:.3g}" if made.error_bound else "exact"
    cost = sum(effect.nanoseconds(made.effects[effect.name]) for effect in EFFECTS)
    depends = "change" if made.view_dependent else "do not change"
    return f"Colours are {error} and {depends} when the viewer moves. Cost: about {cost:.1f} ns per vertex."
