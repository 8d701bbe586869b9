"""The page's histogram.

It is counted again when the picture changes, but counting takes at most a fifth of the time.
"""

from __future__ import annotations

import time
from typing import Any

from pvphong.studio.histogram import Histogram, displayed, histogram_of
from pvphong.studio.subplot import Subplot

WIDTH, HEIGHT = 256, 72
"""Size of the drawn histogram."""

_REST = 4.0  # times the duration of a count, until the next one
_SOONEST = 0.1  # seconds


class LiveHistogram:
    """Histogram of the displayed luminance of a subplot.

    Parameters
    ----------
    subplot : Subplot
        The subplot.
    """

    def __init__(self, subplot: Subplot) -> None:
        self._subplot = subplot
        self.is_counting = False
        """True while a frame is drawn only to be counted."""
        self.wait = _SOONEST
        """Seconds to wait until the next count."""
        self._counted_for: Any = None

    def count(self) -> dict[str, Any] | None:
        """Return the histogram for the page; None if the picture is the same as at the last count."""
        picture = self._picture
        if picture == self._counted_for:
            return None
        began = time.perf_counter()
        self.is_counting = True
        try:
            colors = displayed(self._subplot.renderer, self._subplot.lit, self._subplot.interaction)
        finally:
            self.is_counting = False
        found = histogram_of(colors)
        self.wait = max(_SOONEST, _REST * (time.perf_counter() - began))
        self._counted_for = self._picture
        return shown(found)

    @property
    def _picture(self) -> Any:
        """A value that changes with the picture, apart from gizmos; cheap to compare."""
        renderer = self._subplot.renderer
        drawn = tuple((id(actor), actor.GetRedrawMTime(), actor.GetVisibility()) for actor in renderer.GetActors())
        return renderer.GetActiveCamera().GetMTime(), renderer.GetSize(), self._subplot.lit.display, drawn


def shown(found: Histogram) -> dict[str, Any]:
    """Return the page's state for a histogram: its outline as an SVG path, and the clipped fractions as texts.

    The height is the square root of the count, so that a large background hides nothing.
    """
    heights = (found.counts / max(found.counts.max(initial=0), 1)) ** 0.5
    step = WIDTH / len(heights)
    bars = (f"L{k * step:g} {HEIGHT * (1 - h):.1f}H{(k + 1) * step:g}" for k, h in enumerate(heights.tolist()))
    return {
        "path": f"M0 {HEIGHT}{''.join(bars)}L{WIDTH} {HEIGHT}Z",
        "low": percent(found.clipped_low),
        "high": percent(found.clipped_high),
    }


def percent(share: float) -> str:
    """Return a fraction as a text in per cent; "" if it is 0."""
    return "" if share == 0.0 else "< 0.1 %" if share < 1e-3 else f"{100.0 * share:.1f} %"
