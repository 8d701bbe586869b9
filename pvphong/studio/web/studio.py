"""The studio: a web page that shows and edits a plotter's lit meshes and lights.

An edit goes from the page to a trigger of `Studio`, which calls `Document` and then requests a frame. After each frame,
the page shows all changes, including those by gizmos and code. Drawing, messages and files share one asyncio loop.
"""

from __future__ import annotations

import asyncio
import inspect
import itertools
import weakref
import webbrowser
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path, PurePath
from typing import Any, get_args

import numpy as np
import pyvista as pv
from aiohttp import web
from pyvista import examples
from trame.app import get_server

from pvphong.base import check
from pvphong.base.types import Float64Array
from pvphong.meshes import colormaps
from pvphong.meshes.blocks import map_blocks
from pvphong.meshes.pictures import TRANSPARENT, refuse_size
from pvphong.meshes.stages import Stage
from pvphong.meshes.surfaces import surface
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.material import Material
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.shading.plan.plan import Plan
from pvphong.studio.gizmos import History, commands
from pvphong.studio.subplot import Subplot
from pvphong.studio.web.access import Access, Messages, no_launcher
from pvphong.studio.web.cameras import Cameras
from pvphong.studio.web.document import Document
from pvphong.studio.web.downloads import EXAMPLES, LIT, STAGE, Downloads, Picture, reading_file
from pvphong.studio.web.exactness import exactness, plans_of, refined_text, rows_of, summary_of
from pvphong.studio.web.fields import hex_of, number_in
from pvphong.studio.web.framing import Framing
from pvphong.studio.web.instruments import Instruments
from pvphong.studio.web.messages import Remedy, in_page_words, remedies
from pvphong.studio.web.opening import OpenFile, Opening
from pvphong.studio.web.page import build
from pvphong.studio.web.panels.help import PAGE_KEYS
from pvphong.studio.web.report import Measuring, Report
from pvphong.studio.web.thumbnails import answer
from pvphong.studio.web.turntable import Turntable, pictures_in
from pvphong.studio.web.uploads import DROPPED, Uploads, refuse_file

_SHOW_AFTER, _PLAN_AFTER, _ASK_AGAIN = 0.06, 0.25, 0.1
"""Seconds from a frame until the page is updated, from then until the plan is updated, and between two polls for
background results."""

_SAID_FOR = 8.0
"""Seconds for which a notice is shown."""

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
        "highlight_here",
    ),
    "set_colormap",
    *("rename_mesh", "remove_mesh"),
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
        self._plans: list[Plan] = []
        self._serving: Any = None
        self._measuring = Measuring(self._measured)
        self._measured_matrix: Float64Array | None = None
        self._reports = 0
        self._uploads = Uploads(self.document, subplot, self._open_upload)
        self._cameras = Cameras(subplot)
        self._turntable = Turntable(self.show)
        self._instruments = Instruments(self.document, subplot, self._later, self.draw, self.say, self._put)
        self.server = get_server(f"pvphong studio {next(_numbers)}", client_type="vue3")
        keys = [*PAGE_KEYS, *((key, f"{what}, in the view") for key, what in commands.help_entries({}))]
        names = {"keys": keys, "example_names": list(EXAMPLES), "material_names": list(Material.names())}
        names |= {"reflectance_names": ["", *REFLECTANCES], "colormap_names": sorted(colormaps.names(), key=str.lower)}
        names["dropped"] = DROPPED
        at_first: dict[str, Any] = {"plan": {"accuracy": "", "meshes": []}, "script": ""}
        at_first["report"] = vars(Report()) | {"figure": ""}
        self.server.state.update(names | at_first | Instruments.at_first | {"marked": False} | self._shown())
        self._triggers = {name: self._trigger(name, getattr(self.document, name)) for name in _EDITS}
        self._triggers |= {name: self._trigger(name, act) for name, act in self._acts.items()}
        self._triggers["point_at"] = self._point_at
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
            "refuse_file": refuse_file,
            "set_stage": self.set_stage,
            "gizmos": lambda: commands.toggle_hidden(document.gizmos),
            "theme": self._turn_theme,
            "start_turntable": self.start_turntable,
            "cancel_turntable": self._turntable.cancel,
            **self._cameras.triggers,
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

    def _point_at(self, number: Any = None) -> None:
        """Mark the light whose row is pointed at. A message with its buttons stays, unlike after other triggers."""
        with suppress(ValueError):  # the light was deleted
            self.document.point_at(number)
            self.draw()

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
        meshes = self._subplot.lit.subjects
        points = sum(mesh.drawn.n_points for mesh in meshes)
        title = f"{self._opening.title}: {points:,} points" if meshes else "no mesh"
        of_meshes = {"title": title, "has_mesh": bool(meshes), "mesh_count": len(meshes)}
        of_meshes |= {"parts": self._opening.listed()}
        shown = self.document.shown()
        lit_by = ", ".join(light["called"] for light in shown["lights"] if light["on"]["value"]) or "no light"
        shown |= self._cameras.shown() | self._turntable.shown(self._opening.stem)
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
            "refined": refined_text(refining, is_mixed=self.document.mix.is_on),
            "exactness": self._exactness(),
        }

    def _exactness(self) -> dict[str, Any]:
        """Return the sentence on how exact the picture is, and its button."""
        is_paused = any(each.is_paused for each in self._subplot.lit.refining.values())
        how: dict[str, bool] = {"is_refined": self._is_refined, "is_paused": is_paused}
        exact = exactness(self._plans, self.document.accuracy, **how)
        return {"text": exact.text, **exact.improve._asdict()}

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
        known = (
            scene,
            [(mesh, mesh.material, mesh.geometry()) for mesh in meshes],
            self.document.accuracy,
            self._picture,
            self._is_refined,
            self._opening.parts,
        )
        if known == self._planned_for:
            return
        self._planned_for, plans = known, plans_of(self._subplot.lit, scene, tolerance)
        names = self.document.names()
        shown = [
            {"name": names[mesh], "rows": rows_of(made), "accuracy": summary_of(made)} for mesh, made in plans.items()
        ]
        try:
            script = self.downloads.script()
        except ValueError as error:
            script = f"# {error}"
        self._plans = list(plans.values())
        with self.server.state as state:
            state.exactness = self._exactness()
            state.plan = {"accuracy": shown[0]["accuracy"] if shown else "", "meshes": shown}
            state.script = script
        self._save()

    def _save(self) -> None:
        """Save the rig, if `keep` was given, with the materials of its own file's meshes."""
        for keep, meshes in self._opening.kept():
            try:
                replace(self.downloads, meshes=meshes).save_rig(keep)
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

    def open(self, mesh: Any, file: str, reading: str = "", *, beside: bool = False) -> None:
        """Show another mesh, as one undo step. Lights are kept and moved to fit; see `Opening`.

        Parameters
        ----------
        mesh : pyvista.DataSet or pyvista.MultiBlock
            A mesh with a surface.
        file : str
            Name of the mesh's file.
        reading : str
            Python expression for the mesh; by default one that reads the file.
        beside : bool, default False
            Show it beside the meshes that are there already. Lights and camera stay then.

        Raises
        ------
        ValueError
            If the mesh has no surface to light; nothing is changed then.
        """
        outside = map_blocks(mesh, surface) if isinstance(mesh, pv.MultiBlock) else surface(mesh)
        with self._active():
            self.document.open(outside, OpenFile(PurePath(file).stem, reading or reading_file(file)), beside=beside)

    def _open_upload(self, mesh: Any, file: str, beside: bool) -> str:
        """Show an uploaded mesh; return a message if it is not all in view."""
        self.open(mesh, file, beside=beside)
        part, meshes = self._opening.drawn[-1]
        is_seen = not beside or self._cameras.sees(meshes)
        return "" if is_seen else f"{part.name} is not all in view. The button “Fit” at the top shows all meshes."

    def open_example(self, name: str) -> None:
        """Show one of PyVista's example meshes."""
        function = EXAMPLES[check.choice("name", name, EXAMPLES)]
        self.open(getattr(examples, function)(), name, f"pv.examples.{function}()")

    def set_stage(self, kind: str) -> str:
        """Draw a ground, a backdrop or a plinth under the meshes, or with "" none; return a message."""
        check.choice("kind", kind, ("", *get_args(Stage)))
        with self._active():
            return self.document.set_stage(kind)

    @property
    def downloads(self) -> Downloads:
        """The downloads of the current state. While a background computation runs, they are as the view shows them."""
        subjects = set(self._subplot.lit.subjects)
        meshes = {name: mesh for mesh, name in self.document.names().items() if mesh in subjects}
        stage = next((mesh for mesh in self._subplot.lit.shown if mesh.stage is not None), None)
        tolerance = self.document.accuracy.tolerance or self.document.set_ups.tolerance
        textures = self.document.textures
        is_as_shown = self._subplot.lit.is_awaiting and not self._subplot.lit.softening.is_awaited  # which ends soon
        opening, scene = self._opening, self._subplot.scene
        if scene.viewer is not None:
            scene = replace(scene, viewer=self._framing.in_a_wide_view(scene.viewer))
        found = Downloads(
            meshes, scene, tolerance, opening.reading, opening.stem, textures, is_as_shown, stage, self._picture
        )
        if self._is_refined:
            names = {mesh: name for name, mesh in meshes.items()} | ({} if stage is None else {stage: STAGE})
            refining = self._subplot.lit.refining
            found.refined = {name: refining[mesh].result() for mesh, name in names.items()}
            found.refine = self.document.accuracy.refine
        return found

    @property
    def _is_refined(self) -> bool:
        """True if the view shows all meshes refined within the tolerance."""
        refining = self._subplot.lit.refining
        return bool(refining) and all(mesh in refining and refining[mesh].is_within for mesh in self._subplot.lit.shown)

    @property
    def _picture(self) -> Picture:
        """Options of the picture, as typed and set in the page."""
        state, display = self.server.state, self._plotter.phong.display
        background = self.document.background
        color = TRANSPARENT if background.transparent else hex_of(background.background)
        return Picture((state.width, state.height), color, display)

    async def _give(self, request: web.Request) -> web.StreamResponse:
        """Answer a request for a download."""
        self.mark_worst(False)
        what, downloads = request.match_info["what"], self.downloads
        try:
            width, height = (request.query.get(name, "0") for name in ("width", "height"))  # only for pictures
            size = _whole("width", width), _whole("height", height)
            if what in LIT and not downloads.is_as_shown:
                await asyncio.to_thread(lambda: downloads.lit)  # slow with bounces
            if what == "png":
                downloads.picture = replace(downloads.picture, size=size)
            name, content = downloads.read(what)
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

    # -- numbers outside the document, and the accuracy report

    def type_number(self, name: Any, given: Any) -> None:
        """Set a typed number: the report's "seconds", "turntable_pictures", or "width" or "height" of a picture."""
        state = self.server.state
        match check.choice("name", name, ("seconds", "turntable_pictures", "width", "height")):
            case "seconds":
                state.seconds = _seconds(given)
                return
            case "turntable_pictures":
                state.turntable_pictures = pictures_in(given)
                return
        size = {"width": state.width, "height": state.height} | {name: _whole(name, given)}
        refuse_size((size["width"], size["height"]))
        state.update(size)

    def measure(self, seconds: Any = None) -> None:
        """Start measuring accuracy against time, in the background.

        Parameters
        ----------
        seconds : float or str, optional
            Time limit, as a number or text; by default the one on the page.
        """
        seconds = _seconds(self.server.state.seconds if seconds is None else seconds)
        meshes = self._subplot.lit.subjects
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
                "tolerance": self.document.accuracy.tolerance or self.document.set_ups.tolerance or 1.0 / 255.0,
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

    def start_turntable(self, pictures: Any) -> None:
        """Start a turntable in the background. `pictures` is a number or text."""
        self._turntable.start(self.downloads, pictures_in(pictures), self._done)
        self.show()

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
        server.app.router.add_post("/paraview/", no_launcher)
        server.app.router.add_get("/take/{what}", self._give)
        server.app.router.add_get("/report/{number}.png", self._measuring.answer)
        server.app.router.add_get("/turntable/{name}.gif", self._turntable.answer)
        self._instruments.add_routes(server.app.router)
        server.app.router.add_get("/thumbnail/{kind}/{name}", answer)
        self._uploads.add_routes(server.app.router, self._done)

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
            address = self.access.address_at(self.server.port)
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
        self._turntable.release()
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
