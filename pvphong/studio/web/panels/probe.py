"""The panel of the probe: the lit value under the cursor, pinned values, and each light's share of them as a bar."""

from __future__ import annotations

from trame.widgets import html
from trame.widgets import vuetify3 as v

from pvphong.studio.web.inputs import found_by, icon_button
from pvphong.studio.web.panels.panel import panel

STYLE = """
.studio-reading { border: 1px solid rgba(128, 128, 128, .35); border-radius: 4px; padding: 6px 8px; margin-top: 10px }
.studio-spot { flex: 0 0 20px; height: 20px; border-radius: 3px; border: 1px solid rgba(128, 128, 128, .6) }
.studio-bar { display: grid; grid-template-columns: 84px 1fr 40px 46px; gap: 6px; align-items: center; font-size: 12px;
  line-height: 1.6 }
.studio-bar > :first-child { overflow: hidden; text-overflow: ellipsis; white-space: nowrap }
.studio-bar > :nth-child(n+3) { text-align: right; font-variant-numeric: tabular-nums }
.studio-track { height: 9px; border-radius: 2px; background: rgba(128, 128, 128, .18) }
.studio-track > div { height: 100%; border-radius: 2px; box-shadow: inset 0 0 0 1px rgba(128, 128, 128, .5) }
"""


def probe() -> None:
    """Add the switch of the probe, the reading under the cursor, and the pins."""
    with panel("Probe", "each light's share of a point"):
        with html.Div(classes="studio-buttons"):
            v.VBtn(
                "{{ probe.on ? 'End probing' : 'Probe' }}",
                prepend_icon="mdi-eyedropper",
                color=("probe.on ? 'primary' : undefined",),
                click="trigger('probe', [!probe.on])",
                title="Read the point under the cursor; click to pin it",
                raw_attrs=['data-test="probe"', ':aria-pressed="probe.on"'],
            )
            v.VBtn(
                "Remove all pins",
                v_if="probe.pins.length > 1",
                variant="text",
                click="trigger('unpin')",
                **found_by("unpin-all"),
            )
        html.Div(
            "Move the cursor over the model. A click pins the point; pins follow all edits.",
            v_if="probe.on && !probe.under",
            classes="studio-unit mt-2",
            **found_by("probe-hint"),
        )
        with html.Div(v_if="probe.under", **found_by("probe-reading")):
            _reading("probe.under", is_pin=False)
        with html.Div(
            v_for="pin in probe.pins", key=("pin.number",), **found_by("probe-pin", ("'Pin ' + pin.number",))
        ):
            _reading("pin", is_pin=True)


def _reading(of: str, *, is_pin: bool) -> None:
    with html.Div(classes="studio-reading"):
        with html.Div(classes="studio-head"):
            html.Div(classes="studio-spot", style=(f"{{ background: {of}.hex }}",))
            if is_pin:
                v.VChip(f"{{{{ {of}.number }}}}", size="x-small", color="amber", variant="flat")
            html.Span(f"{{{{ {of}.title }}}}", classes="text-body-2 text-truncate")
            v.VSpacer()
            html.Span("clipped", v_if=f"{of}.is_clipped", classes="studio-clipped text-caption")
            if is_pin:
                icon_button("mdi-close", "unpin", "Remove the pin", f"trigger('unpin', [{of}.number])")
        html.Div(
            f"linear {{{{ {of}.value }}}}, luminance {{{{ {of}.luminance }}}}",
            classes="studio-unit",
            title="Red, green and blue of the lit colour; luminance before clipping. 1 is full intensity.",
            **found_by("probe-value"),
        )
        with html.Div(
            v_for=f"bar in {of}.bars",
            key=("bar.name",),
            classes="studio-bar",
            **found_by("probe-bar"),
        ):
            html.Span("{{ bar.name }}", title=("bar.name",))
            with html.Div(classes="studio-track"):
                html.Div(style=("{ width: bar.width + '%', background: bar.hex }",))
            html.Span("{{ bar.share }}")
            html.Span("{{ bar.value }}", classes="studio-unit")
