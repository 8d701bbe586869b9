"""The panel of faders, which scale the contribution of each light."""

from __future__ import annotations

from trame.widgets import html
from trame.widgets import vuetify3 as v

from pvphong.studio.web.inputs import color_picker, found_by, icon_button, number_input, switch
from pvphong.studio.web.panels.lights import SOLO_ICON
from pvphong.studio.web.panels.panel import panel


def mix() -> None:
    """Add a fader for each light."""
    with panel("Mix", "instant faders for the lights"):
        with html.Div(classes="studio-row mt-0"):
            switch("mix", "mixing", "mix the lights", "trigger('start_mix', [$event])")
            v.VSpacer()
            v.VBtn(
                "Apply to lights",
                v_if="mixing",
                click="trigger('keep_mix')",
                title="Write the mix into the lights' intensities and colours",
                **found_by("keep-mix"),
            )
        with html.Div(v_if="mixing"):
            with (
                html.Div(
                    v_for="light in lights",
                    key=("light.number",),
                    classes="mt-2",
                    **found_by("fader", ("'Fader of ' + light.called",)),
                ),
                v.Template(v_if="light.fader.length"),
            ):
                with html.Div(classes="studio-head"):
                    color_picker("light.fader[1]")
                    html.Span("{{ light.called }}", classes="studio-label ml-1")
                    v.VSpacer()
                    icon_button(
                        ("light.fader[2].value ? 'mdi-volume-off' : 'mdi-volume-high'",),
                        "fader-mute",
                        "Mute this light",
                        "trigger('edit', [light.fader[2].key, !light.fader[2].value])",
                    )
                    icon_button(
                        (SOLO_ICON.format("light.fader_soloed"),),
                        "fader-solo",
                        "Solo: this light only, or all",
                        "trigger('solo_fader', [light.number])",
                    )
                number_input("light.fader[0]", "fader-gain")
            html.Div(
                "Lighting computed {{ evaluations }} times since the start. The last mix took {{ mix_ms }} ms.",
                classes="studio-unit mt-2",
                **found_by("evaluations"),
            )
