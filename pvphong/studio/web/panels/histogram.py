"""The histogram in the panel of the picture."""

from __future__ import annotations

from trame.widgets import html

from pvphong.studio.web.inputs import found_by
from pvphong.studio.web.live_histogram import HEIGHT, WIDTH

STYLE = """
.studio-histogram { position: relative; margin-top: 14px; border-radius: 4px; background: rgba(128, 128, 128, .14) }
.studio-histogram svg { display: block; width: 100%; height: 72px; fill: currentColor; opacity: .75 }
.studio-scale { display: flex; justify-content: space-between; font-size: 12px; min-height: 18px }
.studio-clipped { color: rgb(var(--v-theme-error)); font-weight: 500 }
"""


def histogram() -> None:
    """Add the histogram of the displayed luminance. The fractions of black and of clipped pixels are under its ends."""
    with html.Div(v_if="histogram.path", **found_by("histogram", status=False)):
        low, high = "(histogram.low || 'nothing')", "(histogram.high || 'nothing')"
        label = f"'Histogram of luminance: ' + {low} + ' black, ' + {high} + ' clipped'"
        with html.Div(classes="studio-histogram"):
            html.Svg(
                f"<path :d='histogram.path'></path><path d='M{WIDTH / 4} 0V{HEIGHT}M{WIDTH / 2} 0V{HEIGHT}"
                f"M{3 * WIDTH / 4} 0V{HEIGHT}' stroke='currentColor' stroke-opacity='.35' fill='none'></path>",
                raw_attrs=[
                    f'viewBox="0 0 {WIDTH} {HEIGHT}"',
                    'preserveAspectRatio="none"',
                    'role="img"',
                    f':aria-label="{label}"',
                ],
            )
        with html.Div(classes="studio-scale"):
            html.Span(
                "{{ histogram.low || 'nothing' }} black", classes=("histogram.low ? 'studio-clipped' : 'studio-unit'",)
            )
            html.Span("luminance", classes="studio-unit")
            html.Span(
                "{{ histogram.high || 'nothing' }} clipped",
                classes=("histogram.high ? 'studio-clipped' : 'studio-unit'",),
            )
