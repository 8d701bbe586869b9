"""The tool *Ask* in the panel of lights: its button, what to do, the size of the spot, and the lights that follow."""

from __future__ import annotations

from trame.widgets import html
from trame.widgets import vuetify3 as v

from pvphong.studio.web.inputs import found_by

STYLE = """
.studio-ask { border: 1px solid rgb(var(--v-theme-primary)); border-radius: 4px; padding: 8px 10px; margin-top: 10px }
.studio-ask .v-checkbox { flex: 0 0 auto }
"""


def button() -> None:
    """Add the button that begins and ends asking."""
    v.VBtn(
        "{{ ask.on ? 'End asking' : 'Ask for light …' }}",
        prepend_icon="mdi-cursor-default-click-outline",
        classes="mt-2 ml-1",
        disabled=("!has_mesh",),
        color=("ask.on ? 'primary' : undefined",),
        click="trigger('ask', [!ask.on])",
        title="Drag a spot of the model brighter or darker, and lights follow (space bar in the view)",
        raw_attrs=['data-test="ask"', ':aria-pressed="ask.on"'],
    )


def options() -> None:
    """Add what to do, the size of the spot, and a checkbox for each light that is on."""
    with html.Div(v_if="ask.on", classes="studio-ask", **found_by("ask-options", "Ask for light")):
        html.Div(
            "Press on a spot of the model and drag: up for brighter, down for darker. The lights checked here follow;"
            " everything else stays as close as it can to what it is. Esc cancels a drag.",
            classes="text-body-2",
            **found_by("ask-hint"),
        )
        with html.Div(classes="studio-row", title="Radius of the spot; the wheel over the view changes it too"):
            v.VTextField(
                key=("'spot' + refusals",),
                model_value=("local.spot ?? ask.spot",),
                label="size of the spot",
                suffix="%",
                inputmode="decimal",
                classes="studio-number",
                change="trigger('ask_spot', [$event.target.value])",
                **found_by("ask-spot"),
            )
            v.VSlider(
                model_value=("local.spot ?? ask.spot",),
                min=1,
                max=100,
                step=1,
                density="compact",
                hide_details=True,
                thumb_size=14,
                track_size=3,
                color="primary",
                update_modelValue="local.spot = $event; flushState('local'); trigger('ask_spot', [$event])",
                end="delete local.spot; flushState('local')",
                **found_by("ask-spot-slider", "size of the spot, slider"),
            )
        with html.Div(classes="studio-buttons mt-1"):
            v.VCheckbox(
                v_for="light in ask.lights",
                key=("light.number",),
                model_value=("light.follows",),
                label=("light.called",),
                density="compact",
                hide_details=True,
                color="primary",
                update_modelValue="trigger('ask_light', [light.number, $event])",
                **found_by("ask-light", ("light.called + ' follows'",)),
            )
        html.Div(
            "No light follows: {{ ask.lights.length ? 'check one.' : 'switch one on.' }}",
            v_if="!ask.lights.some((light) => light.follows)",
            classes="text-body-2 text-warning",
            **found_by("ask-none", status=True),
        )
