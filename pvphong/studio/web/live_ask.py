"""The page's tool *Ask*: a drag on the model asks for more or less light there, and lights follow.

The drag itself is the view's; see `pvphong.studio.gizmos.asking`.
"""

from __future__ import annotations

from typing import Any

from pvphong.base import check
from pvphong.studio.gizmos import Gizmos, commands
from pvphong.studio.gizmos.asking import following
from pvphong.studio.gizmos.gizmo import called
from pvphong.studio.web.document import Document
from pvphong.studio.web.fields import number_in


class LiveAsk:
    """Switches *Ask* on and off, sets the size of its spot, and chooses the lights that follow.

    Parameters
    ----------
    document : Document
        The values that the studio edits.
    """

    def __init__(self, document: Document) -> None:
        self._document = document

    @property
    def _gizmos(self) -> Gizmos:
        return self._document.gizmos

    def switch(self, on: Any) -> None:
        """Begin or end asking. At the beginning, the selected light follows, or all lights if none is selected."""
        gizmos = self._gizmos
        if check.flag("on", on) != gizmos.asks:
            gizmos.awaits_click = None
            commands.toggle_asking(gizmos)
            gizmos.notice = ""  # the page says what to do

    def resize(self, given: Any) -> None:
        """Set the radius of the spot, as a number or text, in per cent of the scene's size, from 1 to 100."""
        size = check.number("spot", number_in("spot", given), at_least=1.0, at_most=100.0)
        self._gizmos.resize_spot(size / 100.0)

    def follow(self, number: Any, on: Any) -> None:
        """Let a light follow, or stay as it is."""
        gizmos, is_on = self._gizmos, check.flag("on", on)
        present = {str(self._document.number(gizmo.renderer_light)): gizmo.renderer_light for gizmo in gizmos.all}
        chosen = present.get(str(number)) or check.refuse("light", number, "the number of an existing light")
        others = [gizmo.renderer_light for gizmo in following(gizmos) if gizmo.renderer_light is not chosen]
        gizmos.followers = [*others, chosen] if is_on else others

    def shown(self) -> dict[str, Any]:
        """Return the values for the page."""
        gizmos = self._gizmos
        follow = following(gizmos)
        lights = [
            {
                "number": self._document.number(gizmo.renderer_light),
                "called": called(gizmo.light),
                "follows": gizmo in follow,
            }
            for gizmo in gizmos.all
            if gizmo.light.on
        ]
        return {"on": gizmos.asks, "spot": round(100.0 * gizmos.spot_size, 1), "lights": lights}
