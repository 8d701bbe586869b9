"""The panel of the camera: named views, saved views, the axis cross, and the turntable."""

from __future__ import annotations

from trame.widgets import html
from trame.widgets import vuetify3 as v

from pvphong.studio.web.cameras import VIEWS
from pvphong.studio.web.inputs import found_by, switch, typed, typed_number
from pvphong.studio.web.panels.panel import panel


def camera() -> None:
    """Add buttons for views, and inputs of the turntable."""
    with panel("Camera", "views and turntable"):
        with html.Div(classes="studio-buttons", **found_by("", "Views")):
            for name in VIEWS:
                v.VBtn(
                    name,
                    click=f"trigger('look', ['{name}'])",
                    disabled=("!has_mesh",),
                    **found_by(f"view-{name}", f"View: {name}"),
                )
        with html.Div(classes="studio-buttons mt-2", **found_by("", "Views that are kept")):
            v.VBtn(
                "keep this view",
                prepend_icon="mdi-bookmark-plus-outline",
                variant="outlined",
                click="trigger('keep_view')",
                **found_by("keep-view"),
            )
            v.VChip(
                "view {{ number }}",
                v_for="number in kept_views",
                key=("number",),
                closable=True,
                __events=[("click_close", "click:close")],
                click_close="trigger('forget_view', [number])",
                click="trigger('look_kept', [number])",
                title="Show this view again",
                **found_by("kept-view"),
            )
        switch("axes", "axes", "axis cross", "trigger('show_axes', [$event])")
        html.H3("Turntable", classes="text-caption mt-2")
        with html.Div(classes="studio-row mt-1"):
            typed_number("turntable_pictures", "", label="pictures", classes="studio-size", found="turntable-pictures")
            v.VBtn(
                "Make GIF",
                v_if="turntable === null",
                prepend_icon="mdi-rotate-360",
                disabled=("!has_mesh",),
                click=f"trigger('start_turntable', [{typed('turntable_pictures')}])",
                title="A GIF for which the camera goes once around the model, from the present view",
                **found_by("turntable", "Make a turntable as GIF"),
            )
            with html.Div(v_if="turntable !== null", classes="studio-row mt-0"):
                html.Span("{{ turntable }} %", classes="text-body-2", **found_by("turntable-percent", status=True))
                v.VBtn("Cancel", click="trigger('cancel_turntable')", **found_by("cancel-turntable"))
        v.VProgressLinear(
            v_if="turntable !== null", model_value=("turntable",), height=4, **found_by("", "Progress of the turntable")
        )
        with html.Div(v_if="turntable_file", classes="mt-2"):
            html.Img(
                src=("turntable_file",),
                style="width: 100%",
                alt="The turntable",
                **found_by("turntable-picture"),
            )
            v.VBtn(
                "Save the GIF",
                href=("turntable_file",),
                prepend_icon="mdi-download",
                __properties=["download"],
                download=True,
                **found_by("download-turntable"),
            )
