"""One view for several browsers. It has the size of the largest browser view.

The other browsers show all of it, with bars at the sides.
So no browser changes another's picture. Positions of the mouse are converted from each browser's view to the shared
one.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from trame_pyvista.widgets import PyVistaRCAView

Size = Mapping[str, float]
"""Size of a browser's view: width "w" and height "h" in CSS pixels, and device pixels per CSS pixel "p"."""


def shared_view(plotter: Any) -> Any:
    """Add the view to the page. A browser with another shape also shows the whole picture."""
    whole = "{ width: '100%', height: '100%', objectFit: 'contain' }"
    return PyVistaRCAView(plotter, send_mouse_move=True, image_style=(whole,), style="width: 100%; height: 100%")


class SharedSize:
    """Sizes of all browsers' views, and the size of the shared view."""

    def __init__(self) -> None:
        self._sizes: dict[str, Size] = {}

    @property
    def size(self) -> Size | None:
        """Size of the shared view: that of the browser's view with the largest area. None without browsers."""
        return max(self._sizes.values(), key=lambda size: size["w"] * size["h"], default=None)

    def put(self, client_id: str, size: Size) -> None:
        """Set the size of a client's view."""
        self._sizes[client_id] = size

    def remove(self, client_id: str) -> bool:
        """Forget a client. Return True if this changes the size of the shared view."""
        before = self.size
        self._sizes.pop(client_id, None)
        return self.size != before

    def converted(self, event: dict[str, Any], client_id: str) -> dict[str, Any]:
        """Return an event of a client's view with its positions converted to the shared view.

        The client shows the shared view as large as possible in the middle of its own view. Positions on the bars are
        outside the shared view. `event` comes from `view_event`.
        """
        own, shared = self._sizes.get(client_id), self.size
        if own is None or shared is None or own == shared or not (own["w"] and own["h"]):
            return event
        scale = min(own["w"] / shared["w"], own["h"] / shared["h"])
        margins = {"x": 0.5 * (own["w"] - scale * shared["w"]), "y": 0.5 * (own["h"] - scale * shared["h"])}

        def place(at: Mapping[str, float]) -> dict[str, float]:
            return {axis: (at[axis] - margin) / scale for axis, margin in margins.items() if axis in at}

        converted = event | place(event) | {side: shared[side] for side in "wh" if side in event}
        if "translation" in event:
            converted["translation"] = [each / scale for each in event["translation"]]
        if "positions" in event:
            converted["positions"] = {finger: place(at) for finger, at in event["positions"].items()}
        return converted
