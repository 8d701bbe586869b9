"""Tools of a studio's view: histogram, probe, snapshots and *Ask*; and how the view is drawn for them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from pvphong.shading.plan.plan import load_compiled
from pvphong.studio.background import Job
from pvphong.studio.gizmos.view import USUAL_DPI
from pvphong.studio.subplot import Subplot
from pvphong.studio.web.document import Document
from pvphong.studio.web.hurry import TRIGGERS, Hurry
from pvphong.studio.web.live_ask import LiveAsk
from pvphong.studio.web.live_histogram import LiveHistogram
from pvphong.studio.web.live_probe import LiveProbe
from pvphong.studio.web.snapshots import Snapshots, pictures


class Instruments:
    """Histogram, probe, snapshots, *Ask* and coarse pictures of a studio's view.

    Parameters
    ----------
    document : Document
        The values that the studio edits.
    subplot : Subplot
        The subplot, with gizmos.
    later : callable
        Function that schedules a call. It takes the delay in seconds and the function to call. If this call is
        scheduled already, its time changes.
    draw : callable
        Requests a frame.
    say : callable
        Shows a message.
    put : callable
        Sets values of the page's state: takes a dictionary.
    """

    at_first: ClassVar[dict[str, Any]] = {"histogram": {"path": "", "low": "", "high": ""}}
    """State of the page at the start, apart from `shown`."""

    def __init__(
        self,
        document: Document,
        subplot: Subplot,
        later: Callable[[float, Callable[[], None]], None],
        draw: Callable[[], None],
        say: Callable[[str], None],
        put: Callable[[dict[str, Any]], None],
    ) -> None:
        self.histogram, self.hurry = LiveHistogram(subplot), Hurry(subplot, later, draw)
        self.snapshots = Snapshots(document, subplot)
        self.probe, self.ask = LiveProbe(subplot, document.mesh_name, say), LiveAsk(document)
        self._subplot, self._later, self._draw, self._put = subplot, later, draw, put
        self._is_due = False
        self._dpi = subplot.renderer.GetRenderWindow().GetDPI()
        Job("loading", load_compiled)

    @property
    def triggers(self) -> dict[str, Callable[..., Any]]:
        """Functions that the page can trigger, by name."""
        return {
            "snapshot": self._keep,
            "restore_snapshot": self.snapshots.restore,
            "look_from_snapshot": self.snapshots.look_from,
            "forget_snapshot": self.snapshots.forget,
            "probe": self._probe,
            "ask": self._ask,
            "ask_spot": self.ask.resize,
            "ask_light": self.ask.follow,
            "unpin": self.probe.unpin,
        }

    def _probe(self, on: Any) -> None:
        """Switch the probe. It and asking use the same clicks, so one ends the other."""
        self.probe.switch(on)
        if on:
            self.ask.switch(False)

    def _ask(self, on: Any) -> None:
        """Switch asking."""
        self.ask.switch(on)
        if on:
            self.probe.switch(False)

    def _keep(self, *given: Any) -> Any:
        """Store a snapshot in which all triangles are drawn, even right after an edit.

        `given` are the trigger's arguments.
        """
        self.hurry.end()
        return self.snapshots.keep(*given)

    def shown(self) -> dict[str, Any]:
        """Return the part of the page's state that changes with a frame."""
        if self.probe.is_on and self.ask.shown()["on"]:  # the space bar, pressed in the view
            self.probe.switch(False)
        return {"probe": self.probe.shown(), "ask": self.ask.shown(), "snapshots": self.snapshots.shown()}

    def triggered(self, name: str) -> None:
        """Draw large meshes coarsely if the trigger `name` changes the picture."""
        if name in TRIGGERS:
            self.hurry.begin()

    def drawn(self) -> None:
        """Schedule a new histogram. This is called after each frame."""
        if not self._is_due:
            self._is_due = True
            self._later(self.histogram.wait, self._count)

    def _count(self) -> None:
        """Update the page's histogram if the picture has changed."""
        self._is_due = False
        found, is_awaiting = self.histogram.count(), self._subplot.lit.is_awaiting
        if found is not None:
            self._put({"histogram": found})
            if is_awaiting:  # the counted frame may have taken a background result, and no client has it
                self._draw()

    def scale(self, ratio: float) -> None:
        """Set the number of device pixels per CSS pixel, `ratio`, so that gizmos and texts keep their size."""
        self._subplot.renderer.GetRenderWindow().SetDPI(round(USUAL_DPI * ratio))

    def add_routes(self, router: Any) -> None:
        """Add the handlers of HTTP requests to the server's router."""
        router.add_get("/snapshot/{number}.jpg", pictures(self.snapshots))

    def release(self) -> None:
        """Detach from the view."""
        self.probe.release()
        self.hurry.release()
        if (window := self._subplot.renderer.GetRenderWindow()) is not None:
            window.SetDPI(self._dpi)
