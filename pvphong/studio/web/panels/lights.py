"""The panel of lights: buttons that add them, set-ups, and a card for each light."""

from __future__ import annotations

from collections.abc import Mapping

from trame.widgets import html
from trame.widgets import vuetify3 as v

from pvphong.scene.presets import setups
from pvphong.studio.web.inputs import (
    color_picker,
    color_text,
    file_input,
    form,
    found_by,
    icon_button,
    number_input,
    switch,
)
from pvphong.studio.web.panels import ask
from pvphong.studio.web.panels.panel import panel
from pvphong.studio.web.words import LIGHTS, SETUPS

_SHOW_SELECTED = (
    "utils.get('setTimeout')(() => utils.get('document').querySelector('.studio-selected')"
    "?.scrollIntoView({ block: 'nearest' }), 200)"
)
"""JavaScript that scrolls to the row of the selected light, after a moment, when the row exists."""

SOLO_ICON = "{0} ? 'mdi-alpha-s-circle' : 'mdi-alpha-s-circle-outline'"


def lights(kinds: Mapping[str, str]) -> None:
    """Add buttons for new lights and set-ups, and a card for each light.

    `kinds` maps kinds of lights to their names on the page.
    """
    with panel("Lights"):
        with html.Div(classes="studio-buttons", **found_by("", "Add a light")):
            for kind, what in kinds.items():
                add, called = f"trigger('add', ['{kind}']).then(() => {_SHOW_SELECTED})", LIGHTS.get(kind, kind)
                tip = f"{kind.capitalize()} light: {what}" if called != kind else what
                v.VBtn(f"+ {called}", click=add, title=tip, **found_by(f"add-{kind}", f"Add a light: {called}"))
        with v.VMenu():
            with v.Template(v_slot_activator="{ props }"):
                v.VBtn(
                    "set-ups",
                    v_bind="props",
                    prepend_icon="mdi-lightbulb-group-outline",
                    classes="mt-2",
                    disabled=("!has_mesh",),
                    title="Replace all lights by a set-up",
                    **found_by("setups", "Set-ups of lights"),
                )
            with v.VList(density="compact"):
                for name in setups:
                    test = found_by(f"setup-{name.replace(' ', '-')}", f"Set-up: {SETUPS.get(name, name)}")
                    item = v.VListItem(SETUPS.get(name, name), click=f"trigger('set_up', ['{name}'])", **test)
                    with item, v.Template(v_slot_prepend=True):
                        html.Img(src=f"thumbnail/setup/{name}", width=40, height=40, classes="mr-3", alt="")
        file_input("lamp", "add a measured lamp: .ies .ldt", accept=".ies,.ldt", v_if="has_mesh")
        ask.button()
        ask.options()
        with v.VCard(v_if="sun", variant="outlined", classes="mt-3 pa-2", **found_by("sun", "Sun by date and place")):
            html.Div(
                "{{ sun.text }}",
                classes=("'text-body-2' + (sun.night ? ' text-warning' : '')",),
                **found_by("sun-text", status=True),
            )
            form("sun.fields")
        with v.VCard(
            v_for="light in lights",
            key=("light.number",),
            variant="outlined",
            classes=(
                "'studio-light mt-3 pa-2' + (light.selected ? ' studio-selected' : '')"
                " + (light.hovered ? ' studio-hovered' : '')",
            ),
            __events=["mouseenter", "mouseleave"],
            mouseenter="trigger('point_at', [light.number])",
            mouseleave="trigger('point_at', [null])",
            click="light.selected || trigger('select', [light.number])",
            ripple=False,
            **found_by("light-row", ("'Light ' + light.called",)),
        ):
            with html.Div(classes="studio-head"):
                _light_head()
            number_input("light.intensity", "intensity")
            with html.Div(v_if="has_shadows", title=("light.casts_shadows.help",)):
                shadowed = "light.casts_shadows"
                edit = f"trigger('edit', [{shadowed}.key, $event])"
                switch("light-shadows", f"{shadowed}.value", (f"{shadowed}.label",), edit)
            with html.Div(v_if="light.selected"):
                v.VTextField(
                    key=("light.number + 'temperature' + light.diffuse.hex + refusals",),
                    label="colour temperature, K",
                    hint="2700 is warm, 6500 white, 10000 blue",
                    inputmode="decimal",
                    classes="mt-3",
                    change="trigger('set_temperature', [light.number, $event.target.value])",
                    **found_by("temperature"),
                )
                with html.Div(classes="studio-buttons mt-3", v_if="light.placing.length"):
                    v.VBtn(
                        "shine from here",
                        prepend_icon="mdi-camera-marker-outline",
                        click="trigger('act', ['to camera', light.number])",
                        title="Move the light to the camera, and aim it at what the camera looks at (key k)",
                        **found_by("shine-from-here"),
                    )
                    v.VBtn(
                        "highlight here …",
                        prepend_icon="mdi-target",
                        color=("aiming ? 'primary' : undefined",),
                        click="trigger('highlight_here', [light.number])",
                        title="Then click in the view where the highlight should be (key H: under the cursor)",
                        raw_attrs=[
                            *found_by("highlight-here", "Put the highlight where you click next")["raw_attrs"],
                            ':aria-pressed="aiming"',
                        ],
                    )
                form("light.placing")
                form("light.fields")


def _light_head() -> None:
    """Add a light's colour and name, its buttons "on" and "solo", and a menu with more actions."""
    with html.Div(classes="studio-numbers", **found_by("colour")):
        color_picker("light.diffuse")
        color_text("light.diffuse")
    v.VTextField(
        model_value=("light.name.value",),
        key=("light.name.key + refusals",),
        label=("light.kind_label",),
        placeholder="no name",
        classes="studio-name",
        change="trigger('edit', [light.name.key, $event.target.value])",
        **found_by("light-name", ("'Name of the light, ' + light.kind_label",)),
    )
    icon_button(
        ("light.on.value ? 'mdi-lightbulb-on-outline' : 'mdi-lightbulb-off-outline'",),
        "light-on",
        "Switch the light on or off",
        "trigger('edit', [light.on.key, !light.on.value])",
    )
    icon_button(
        (SOLO_ICON.format("light.soloed"),),
        "light-solo",
        "Solo: this light only, or all",
        "trigger('act', ['solo', light.number])",
    )
    with v.VMenu():
        with v.Template(v_slot_activator="{ props }"):
            v.VBtn(
                icon="mdi-dots-vertical",
                size="x-small",
                variant="text",
                v_bind="props",
                title="Duplicate, move to camera, reset, delete",
                **found_by("light-menu", "More actions for the light"),
            )
        with v.VList(density="compact"):
            for what, icon in (
                ("duplicate", "mdi-content-copy"),
                ("to camera", "mdi-camera-outline"),
                ("reset", "mdi-restore"),
                ("delete", "mdi-delete-outline"),
            ):
                v.VListItem(
                    title=what.capitalize(),
                    prepend_icon=icon,
                    click=f"trigger('act', ['{what}', light.number])",
                    **found_by(f"light-{what.replace(' ', '-')}"),
                )
