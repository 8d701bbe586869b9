"""Help on the page: a welcome in three steps, shown once in each browser, and a sheet of keys that can be searched."""

from __future__ import annotations

from trame.widgets import client, html
from trame.widgets import vuetify3 as v

from pvphong.studio.web.inputs import found_by

PAGE_KEYS = (
    ("?", "this sheet"),
    ("drag", "turn the model, in the view"),
    ("Shift + drag", "move the model sideways, in the view"),
    ("wheel", "zoom, in the view"),
    ("Ctrl + Z, Ctrl + Y", "undo, redo"),
    ("drop a file", "open a mesh or a rig, or add a measured lamp"),
    ("Shift + drop a mesh", "add it beside the others"),
    ("Shift + slider", "move a slider finely"),
    ("double-click on a slider", "set the default"),
    ("Up, Down in a number", "add or subtract 1"),
)
"""Keys and actions of the page itself: name → what it does. Those of gizmos come from `gizmos.commands`."""

_STEPS = (
    (
        "mdi-rotate-orbit",
        "Look around",
        "Drag in the view to turn the model, turn the wheel to zoom. Open a mesh of your own under Files.",
    ),
    (
        "mdi-lightbulb-on-outline",
        "Light it",
        "Choose a set-up or add a softbox under Lights. Then drag the white dots in the view: a light follows them, and"
        " so does its highlight. Ctrl + Z takes every step back.",
    ),
    (
        "mdi-camera-outline",
        "Take the picture",
        "Put the model on a stage under Scene, set the exposure under Picture, and save the picture, the lit mesh or a"
        " Python script under Files. The key ? lists all keys.",
    ),
)

SCRIPT = """
window.studioWelcome = {
  isNew: () => { try { return !localStorage.getItem('pvphong studio welcome') } catch { return false } },
  seen: () => { try { localStorage.setItem('pvphong studio welcome', '1') } catch { } return 0 },
};
window.addEventListener('keydown', (event) => {
  if (event.key !== '?' || event.target.closest('input, textarea')) return;
  event.preventDefault();
  window.trame.state.set('shows_keys', true);
});
"""
"""JavaScript that remembers, in the browser, that the welcome was shown, and opens the sheet of keys."""

STATE = {"welcome": 0, "shows_keys": False, "sought_key": ""}
"""State of each browser: the step of the welcome, or 0; whether the keys are shown; the text that is searched."""

_SEEN = "welcome = utils.get('studioWelcome').seen()"


def welcome() -> None:
    """Add the welcome dialog."""
    client.ClientTriggers(mounted="welcome = utils.get('studioWelcome').isNew() ? 1 : 0")
    with (
        v.VDialog(model_value=("welcome > 0",), max_width=430, update_modelValue=f"$event || ({_SEEN})", scrim="black"),
        v.VCard(classes="pa-4", **found_by("welcome", "Welcome to the studio")),
    ):
        for number, (icon, title, text) in enumerate(_STEPS, 1):
            with html.Div(v_if=f"welcome == {number}"):
                with html.Div(classes="studio-head"):
                    v.VIcon(icon, color="primary")
                    html.H2(f"{number}. {title}", classes="text-h6")
                html.Div(text, classes="text-body-2 mt-2", style="min-height: 84px")
        with html.Div(classes="studio-row"):
            html.Span(f"{{{{ welcome }}}} of {len(_STEPS)}", classes="studio-unit")
            v.VSpacer()
            v.VBtn("Skip", v_if=f"welcome < {len(_STEPS)}", variant="text", click=_SEEN, **found_by("welcome-skip"))
            v.VBtn("Back", v_if="welcome > 1", click="welcome -= 1", **found_by("welcome-back"))
            v.VBtn(
                f"{{{{ welcome < {len(_STEPS)} ? 'Next' : 'Start' }}}}",
                color="primary",
                variant="flat",
                click=f"welcome < {len(_STEPS)} ? (welcome += 1) : ({_SEEN})",
                **found_by("welcome-next"),
            )


def keys() -> None:
    """Add the dialog with the sheet of keys and a search field."""
    found = "keys.filter((row) => row.join(' ').toLowerCase().includes(sought_key.trim().toLowerCase()))"
    with (
        v.VDialog(v_model=("shows_keys",), max_width=480, scrollable=True),
        v.VCard(**found_by("keys", "Keys")),
    ):
        with html.Div(classes="pa-4 pb-2"):
            with html.Div(classes="studio-head"):
                html.H2("Keys", classes="text-h6")
                v.VSpacer()
                v.VBtn(
                    "Welcome",
                    variant="text",
                    title="Show the three steps of the welcome again",
                    click="shows_keys = false; welcome = 1",
                    **found_by("show-welcome"),
                )
            v.VTextField(
                v_model=("sought_key",),
                label="search",
                prepend_inner_icon="mdi-magnify",
                clearable=True,
                autofocus=True,
                click_clear="sought_key = ''",
                classes="mt-2",
                **found_by("search-keys"),
            )
        with v.VCardText(classes="pt-0"), v.VTable(density="compact"), html.Tbody():
            with html.Tr(v_for=f"row in {found}", key=("row.join()",), **found_by("key-row")):
                html.Td("{{ row[0] }}", style="width: 38%", classes="font-weight-medium")
                html.Td("{{ row[1] }}")
            html.Tr("<td>no key does this</td>", v_if=f"!{found}.length")
