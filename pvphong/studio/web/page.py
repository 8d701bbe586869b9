"""The page: Vuetify's components around the view, filled with the document's values.

Each panel is a function of `panels`. The inputs in panels are in `inputs.py`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from trame.ui.vuetify3 import VAppLayout
from trame.widgets import client, html
from trame.widgets import vuetify3 as v

from pvphong.studio.web.inputs import CALLS, DEFAULTS, FINE, form, found_by, icon_button
from pvphong.studio.web.panels import help
from pvphong.studio.web.panels.accuracy import advanced
from pvphong.studio.web.panels.camera import camera
from pvphong.studio.web.panels.compare import OWN as COMPARE_OWN
from pvphong.studio.web.panels.compare import STYLE as COMPARE_STYLE
from pvphong.studio.web.panels.compare import compare
from pvphong.studio.web.panels.compare import over_view as comparison
from pvphong.studio.web.panels.files import files
from pvphong.studio.web.panels.histogram import STYLE as HISTOGRAM_STYLE
from pvphong.studio.web.panels.lights import lights
from pvphong.studio.web.panels.material import materials
from pvphong.studio.web.panels.mix import mix
from pvphong.studio.web.panels.over_view import awaited, start
from pvphong.studio.web.panels.panel import panel
from pvphong.studio.web.panels.picture import picture
from pvphong.studio.web.panels.probe import STYLE as PROBE_STYLE
from pvphong.studio.web.panels.probe import probe
from pvphong.studio.web.panels.stage import stage
from pvphong.studio.web.sharing import shared_view

_WIDTH, _NARROW = 400, 860
"""Width of the panels, and largest width of a window in which the panels are closed at first, in pixels."""

_IS_LOW = f"($vuetify.display.width <= {_NARROW} && $vuetify.display.height >= $vuetify.display.width)"
"""JavaScript expression for whether the panels are below the view, in a narrow upright window."""

_SIZE = (
    f"{_IS_LOW} ? Math.round(0.45 * $vuetify.display.height)"
    f" : Math.min({_WIDTH}, Math.round(0.5 * $vuetify.display.width))"
)
"""JavaScript expression for the height of the panels below the view, or for their width next to it, in pixels."""


_STYLE = """
html { overflow: hidden !important }
.v-application.v-theme--light, .v-application .v-theme--light { --v-medium-emphasis-opacity: .75 }
.studio-view { position: absolute; inset: 0; touch-action: none }
.studio-view:focus-within { outline: 2px solid rgb(var(--v-theme-primary)); outline-offset: -2px }
.v-application .v-btn:not(.v-btn--icon),
.v-overlay-container .v-btn:not(.v-btn--icon) { text-transform: none; min-width: 0; padding: 0 8px }
.studio-number { flex: 0 0 164px }
.studio-numbers { display: flex; gap: 6px }
.studio-buttons { display: flex; flex-wrap: wrap; gap: 4px }
.studio-row { display: flex; align-items: center; gap: 8px; margin-top: 10px }
.studio-head { display: flex; align-items: center; gap: 6px }
.studio-heading { font: inherit }
.studio-label { flex: 0 0 116px; font-size: 13px; line-height: 1.2; overflow-wrap: anywhere }
.studio-unit { opacity: .7; font-size: 12px }
.studio-hex { flex: 0 0 86px }
.studio-hex input, .studio-name input { padding: 0 8px !important; font-size: 14px }
.studio-color { flex-wrap: wrap }
.studio-color .v-file-input { flex: 1 0 100%; margin-top: 2px !important }
.studio-size { flex: 0 0 116px }
.studio-swatch { width: 32px; height: 40px !important; min-width: 32px !important;
  border: 1px solid rgba(128, 128, 128, .6) }
.studio-panel.v-navigation-drawer--bottom { max-height: none }
.studio-jump { display: flex; overflow-x: auto; padding: 4px 8px; border-bottom: 1px solid rgba(128, 128, 128, .3) }
.v-application .studio-jump .v-btn { padding: 0 4px; min-width: 0; letter-spacing: 0 }
.studio-light { border-color: rgba(128, 128, 128, .35) }
.studio-selected { border-color: rgb(var(--v-theme-primary)); box-shadow: 0 0 0 1px rgb(var(--v-theme-primary)) }
.studio-hovered { background: rgba(var(--v-theme-primary), .16) }
.studio-aiming, .studio-aiming * { cursor: crosshair !important }
.studio-panels .v-expansion-panel-title, .studio-panels .v-expansion-panel--active > .v-expansion-panel-title {
  min-height: 38px; padding: 6px 16px; font-weight: 500 }
.studio-panels .v-expansion-panel { border-bottom: 1px solid rgba(128, 128, 128, .25) }
.studio-panels .v-expansion-panel-text__wrapper { padding: 2px 16px 14px }
.studio-code textarea { font-family: monospace; font-size: 11px; line-height: 1.35; white-space: pre; overflow-x: auto }
.studio-start { position: absolute; top: 50%; left: 50%; transform: translate(-50%, -50%); width: 90% }
.studio-awaited { position: absolute; top: 8px; left: 8px; width: 290px; max-width: calc(100% - 16px) }
@media (max-width: 480px) { .studio-head .studio-hex { display: none } }
.studio-plan td, .studio-plan th { padding: 2px 6px !important; height: auto !important; font-size: 12px;
  vertical-align: top }
"""

_KEYS = """
window.addEventListener('keydown', (event) => {
  const key = event.key.toLowerCase(), isInView = event.target.closest && event.target.closest('.studio-view');
  if (!(event.ctrlKey || event.metaKey) || isInView || !['z', 'y'].includes(key)) return;
  event.preventDefault();
  window.trame.trigger(key === 'y' || event.shiftKey ? 'redo' : 'undo');
});
"""
"""Keys for undo and redo outside the view. The view handles keys itself."""

_STEPS = """
window.addEventListener('keydown', ({ key, target: input }) => {
  const step = { ArrowUp: 1, ArrowDown: -1 }[key];
  if (!step || input.inputMode !== 'decimal' || !input.value || isNaN(input.value)) return;
  input.value = Number((Number(input.value) + step).toPrecision(6));
  ['input', 'change'].forEach((name) => input.dispatchEvent(new Event(name, { bubbles: true })));
});
"""
"""Arrow keys up and down in a number input: add or subtract 1."""


_ALT = """
(() => {
  const describe = () => document.querySelectorAll('.studio-view').forEach((view) =>
    view.querySelectorAll('img').forEach((image) => image.alt === view.dataset.alt || (image.alt = view.dataset.alt)));
  new MutationObserver(describe).observe(document.documentElement,
    { childList: true, subtree: true, attributes: true, attributeFilter: ['data-alt'] });
})();
"""
"""Gives the image of the view its alternative text, which trame's component does not."""

_ZOOM = "document.querySelector('meta[name=viewport]').content = 'width=device-width, initial-scale=1';"
"""Lets phones enlarge the page, which trame's own page forbids."""

_DRAWN = f"drawer ?? $vuetify.display.width > {_NARROW}"
"""JavaScript expression for whether the panels are open. At first, they are open if there is room next to the view."""

_PANELS = ("lights", "mix", "material", "scene", "camera", "picture", "probe", "compare", "files", "advanced")
_JUMP = (
    "open_panels = open_panels.includes({number}) ? open_panels : [...open_panels, {number}];"
    " utils.get('studioJump')('panel-{name}')"
)
"""JavaScript that opens a panel and scrolls to it."""

_JUMPS = """
window.studioJump = (id) => {
  const panel = document.getElementById(id);
  const again = new ResizeObserver(() => panel.scrollIntoView());
  again.observe(panel.parentElement);
  const stop = () => again.disconnect();
  for (const event of ['pointerdown', 'wheel', 'keydown']) addEventListener(event, stop, { once: true });
  setTimeout(stop, 2000);
};
"""
"""Scrolls to a panel, and again whenever the panels grow, because a panel that was folded unfolds slowly on a busy
machine. The user's next action ends it."""

_TEXT = ':data-alt="view_text"'


def build(server: Any, plotter: Any, kinds: Mapping[str, str]) -> Any:
    """Build the page and return its view.

    Parameters
    ----------
    server : trame_server.core.Server
        The server of the page.
    plotter : pyvista.Plotter
        The plotter in the view.
    kinds : mapping
        Name of a kind of light in scene files → description for a tooltip.
    """
    own: dict[str, Any] = {"local": {}, "drawer": None, "open_panels": list(range(len(_PANELS) - 1))}
    own |= {"busy": False, "uploads": 0} | COMPARE_OWN | help.STATE
    server.state.client_only(*own)
    server.state.update(
        own | {"refusals": 0, "notice": "", "remedies": [], "theme": "dark", "trame__title": "pvphong studio"}
    )
    server.state.update({"seconds": 20, "width": 1920, "height": 1080, "turntable_pictures": 36})
    with VAppLayout(server, vuetify_config={"defaults": DEFAULTS}, theme=("theme",)):
        client.Style(_STYLE + HISTOGRAM_STYLE + PROBE_STYLE + COMPARE_STYLE)
        client.Script(_KEYS + _STEPS + _JUMPS + FINE + _ALT + _ZOOM + help.SCRIPT)
        with v.VAppBar(density="compact", flat=True, border=True):
            with v.VAppBarTitle():
                html.H1("{{ title }}", classes="text-body-1 font-weight-medium text-truncate")
            for icon, name, label, click, more in (
                ("undo", "undo", "Undo (Ctrl+Z)", "trigger('undo')", {"disabled": ("!can_undo",)}),
                ("redo", "redo", "Redo (Ctrl+Y)", "trigger('redo')", {"disabled": ("!can_redo",)}),
                ("fit-to-screen-outline", "fit", "Fit the model into the view", "trigger('fit')", {}),
                ("vector-point-select", "gizmos", "Show or hide the gizmos", "trigger('gizmos')", {}),
                ("theme-light-dark", "theme", "Switch between dark and light theme", "trigger('theme')", {}),
                ("help-circle-outline", "help", "Keys and help (?)", "shows_keys = true", {}),
                ("dock-right", "drawer", "Show or hide the panels", f"drawer = !({_DRAWN})", {}),
            ):
                icon_button(f"mdi-{icon}", name, label, click, size="small", **more)
        with v.VNavigationDrawer(
            model_value=(_DRAWN,),
            update_modelValue="drawer = $event",
            location=(f"{_IS_LOW} ? 'bottom' : 'right'",),
            classes="studio-panel",
            width=(_SIZE,),
            mobile_breakpoint=0,  # otherwise the panels cover the view in small windows
            **found_by("panels", "Panels"),
        ):
            with v.Template(v_slot_prepend=True), html.Div(classes="studio-jump"):
                for number, name in enumerate(_PANELS):
                    jump = _JUMP.format(number=number, name=name)
                    v.VBtn(name.capitalize(), variant="text", click=jump, **found_by(f"go-{name}"))
            with v.VExpansionPanels(
                v_model=("open_panels",), multiple=True, variant="accordion", flat=True, classes="studio-panels"
            ):
                lights(kinds)
                mix()
                materials()
                with panel("Scene"):
                    stage()
                    form("model")
                camera()
                picture()
                probe()
                compare()
                files()
                advanced()
        with (
            v.VMain(style="height: 100dvh"),
            html.Div(style="position: relative; height: 100%"),
            html.Div(
                classes=("'studio-view' + (aiming ? ' studio-aiming' : '')",),
                raw_attrs=[
                    *found_by("view", "View of the model with gizmos; press h for the keys")["raw_attrs"],
                    _TEXT,
                ],
            ),
        ):
            view = shared_view(plotter)
            start()
            comparison()
            with html.Div(classes="studio-awaited"):
                awaited("gathering", "computing bounced light", "cancel_bounces")
                awaited(
                    "refining", "refining the view", "cancel_refining", paused="refining_paused", go_on="go_on_refining"
                )
        _notice()
        help.welcome()
        help.keys()
    return view


def _notice() -> None:
    """Add the message at the bottom, with buttons for remedies."""
    with v.VSnackbar(
        model_value=("!!notice",),
        timeout=-1,
        location="bottom left",
        max_width=(f"({_DRAWN}) && !{_IS_LOW} ? $vuetify.display.width - ({_SIZE}) - 24 : undefined",),
        min_width=0,
        **found_by("notice", status=True),
    ):
        html.Span("{{ notice }}")
        with v.Template(v_slot_actions=True):
            v.VBtn(
                "{{ remedy.label }}",
                v_for="remedy in remedies",
                key=("remedy.label",),
                classes="ml-1",
                click=CALLS.format("remedy"),
                **found_by("remedy"),
            )
