"""Cards over the view: progress of background computations, and a start without a mesh."""

from __future__ import annotations

from trame.widgets import html
from trame.widgets import vuetify3 as v

from pvphong.studio.web.inputs import found_by
from pvphong.studio.web.panels.files import open_mesh


def awaited(name: str, doing: str, cancel: str, *, paused: str = "false", go_on: str = "") -> None:
    """Add a progress card over the view for a background computation.

    Parameters
    ----------
    name : str
        State variable with the progress in per cent; null if nothing is computed.
    doing : str
        Text for the computation.
    cancel : str
        Trigger that cancels the computation.
    paused : str
        State variable that is true while the computation is paused.
    go_on : str
        Trigger that continues a paused computation; "" if it cannot pause.
    """
    with v.VCard(v_if=f"{name} !== null", classes="pl-3 pr-1 py-1 mb-1", **found_by(name)):
        with html.Div(classes="studio-row mt-0"):
            html.Span(
                f"{{{{ {paused} ? 'paused: ' : '' }}}}{doing}", classes="text-body-2", **found_by("", status=True)
            )
            html.Span(f"{{{{ {name} }}}} %", classes="text-body-2", **found_by(f"{name}-percent"))
            v.VSpacer()
            if go_on:
                more = found_by(go_on.replace("_", "-"), f"Go on: {doing}")
                v.VBtn("Go on", v_if=paused, click=f"trigger('{go_on}')", **more)
            name_of_button = cancel.replace("_", "-")
            v.VBtn(
                "Cancel", variant="text", click=f"trigger('{cancel}')", **found_by(name_of_button, f"Cancel: {doing}")
            )
        how_much = found_by("", f"Progress: {doing}")
        v.VProgressLinear(model_value=(name,), indeterminate=(f"!{name}",), height=4, **how_much)


def start() -> None:
    """Add the card that the view shows while there is no mesh."""
    with v.VCard(v_if="!has_mesh", classes="studio-start pa-4", max_width=420, **found_by("start")):
        html.H2("Light a mesh", classes="text-h6")
        html.Div("Choose an example or open a file. The studio adds lights to it.", classes="text-body-2 mb-2")
        open_mesh("first-mesh")
