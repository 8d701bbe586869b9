"""The page: Vuetify's components around the view, filled with the document's values.

Each panel is a function, in the order of the page. The inputs in panels are in `inputs.py`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from trame.ui.vuetify3 import VAppLayout
from trame.widgets import client, html
from trame.widgets import vuetify3 as v

from pvphong.scene.presets import setups
from pvphong.studio.web.inputs import (
    DEFAULTS,
    FINE,
    SIX_DIGITS,
    color_picker,
    color_text,
    file_input,
    form,
    found_by,
    icon_button,
    number_input,
    switch,
    typed,
    typed_number,
)
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
.studio-view { position: absolute; inset: 0; touch-action: none }
.studio-view:focus-within { outline: 2px solid rgb(var(--v-theme-primary)); outline-offset: -2px }
.v-application .v-btn:not(.v-btn--icon),
.v-overlay-container .v-btn:not(.v-btn--icon) { text-transform: none; min-width: 0; padding: 0 8px }
.studio-number { flex: 0 0 142px }
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

_DRAWN = f"drawer ?? $vuetify.display.width > {_NARROW}"
"""JavaScript expression for whether the panels are open. At first, they are open if there is room next to the view."""

_PANELS = ("lights", "mix", "material", "picture", "scene", "plan", "accuracy", "files")
_JUMP = (
    "open_panels = open_panels.includes({number}) ? open_panels : [...open_panels, {number}];"
    " utils.get('document').getElementById('panel-{name}').scrollIntoView({{ behavior: 'smooth' }})"
)


_TEXT = ':data-alt="view_text"'

_SHOW_SELECTED = (
    "utils.get('setTimeout')(() => utils.get('document').querySelector('.studio-selected')"
    "?.scrollIntoView({ block: 'nearest' }), 200)"
)
"""JavaScript that scrolls to the row of the selected light, after a moment, when the row exists."""

_SOLO_ICON = "{0} ? 'mdi-alpha-s-circle' : 'mdi-alpha-s-circle-outline'"


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
    own: dict[str, Any] = {"local": {}, "drawer": None, "open_panels": list(range(len(_PANELS)))}
    own |= {"busy": False, "uploads": 0}
    server.state.client_only(*own)
    server.state.update(
        own | {"refusals": 0, "notice": "", "remedies": [], "theme": "dark", "trame__title": "pvphong studio"}
    )
    server.state.update({"seconds": 20, "width": 1920, "height": 1080})
    with VAppLayout(server, vuetify_config={"defaults": DEFAULTS}, theme=("theme",)):
        client.Style(_STYLE)
        client.Script(_KEYS + _STEPS + FINE + _ALT)
        with v.VAppBar(density="compact", flat=True, border=True):
            with v.VAppBarTitle():
                html.H1("{{ title }}", classes="text-body-1 font-weight-medium text-truncate")
            for icon, name, label, click, more in (
                ("undo", "undo", "Undo (Ctrl+Z)", "trigger('undo')", {"disabled": ("!can_undo",)}),
                ("redo", "redo", "Redo (Ctrl+Y)", "trigger('redo')", {"disabled": ("!can_redo",)}),
                ("fit-to-screen-outline", "fit", "Fit the model into the view", "trigger('fit')", {}),
                ("vector-point-select", "gizmos", "Show or hide the gizmos", "trigger('gizmos')", {}),
                ("theme-light-dark", "theme", "Switch between dark and light theme", "trigger('theme')", {}),
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
                _lights(kinds)
                _mix()
                _materials()
                _picture()
                with _panel("Scene"):
                    form("model")
                _plan()
                _accuracy()
                _files()
        with (
            v.VMain(style="height: 100dvh"),
            html.Div(style="position: relative; height: 100%"),
            html.Div(
                classes="studio-view",
                raw_attrs=[
                    *found_by("view", "View of the model with gizmos; press h for the keys")["raw_attrs"],
                    _TEXT,
                ],
            ),
        ):
            view = shared_view(plotter)
            _start()
            with html.Div(classes="studio-awaited"):
                _awaited("gathering", "computing bounced light", "cancel_bounces")
                _awaited(
                    "refining", "refining the view", "cancel_refining", paused="refining_paused", go_on="go_on_refining"
                )
        _notice()
    return view


# --- parts


@contextmanager
def _panel(title: str, note: str = "") -> Iterator[None]:
    with v.VExpansionPanel(eager=True, id=f"panel-{title.lower()}"):
        with html.H2(classes="studio-heading"), v.VExpansionPanelTitle(title):
            if note:
                html.Span(note, classes="studio-unit ml-2")
        with v.VExpansionPanelText():
            yield


def _lights(kinds: Mapping[str, str]) -> None:
    with _panel("Lights"):
        with html.Div(classes="studio-buttons", **found_by("", "Add a light")):
            for kind, what in kinds.items():
                add = f"trigger('add', ['{kind}']).then(() => {_SHOW_SELECTED})"
                v.VBtn(f"+ {kind}", click=add, title=what, **found_by(f"add-{kind}", f"Add a light: {kind}"))
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
                    test = found_by(f"setup-{name.replace(' ', '-')}", f"Set-up: {name}")
                    item = v.VListItem(name, click=f"trigger('set_up', ['{name}'])", **test)
                    with item, v.Template(v_slot_prepend=True):
                        html.Img(src=f"thumbnail/setup/{name}", width=40, height=40, classes="mr-3", alt="")
        with v.VCard(
            v_for="light in lights",
            key=("light.number",),
            variant="outlined",
            classes=("'studio-light mt-3 pa-2' + (light.selected ? ' studio-selected' : '')",),
            click="light.selected || trigger('select', [light.number])",
            ripple=False,
            **found_by("light-row", ("'Light ' + light.called",)),
        ):
            with html.Div(classes="studio-head"):
                _light_head()
            number_input("light.intensity", "intensity")
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
                form("light.fields")


def _light_head() -> None:
    """Add a light's colour and name, its buttons "on" and "solo", and a menu with more actions."""
    with html.Div(classes="studio-numbers", **found_by("colour")):
        color_picker("light.diffuse")
        color_text("light.diffuse")
    v.VTextField(
        model_value=("light.name.value",),
        key=("light.name.key + refusals",),
        label=("light.kind",),
        placeholder="no name",
        classes="studio-name",
        change="trigger('edit', [light.name.key, $event.target.value])",
        **found_by("light-name", ("'Name of the light, ' + light.kind",)),
    )
    icon_button(
        ("light.on.value ? 'mdi-lightbulb-on-outline' : 'mdi-lightbulb-off-outline'",),
        "light-on",
        "Switch the light on or off",
        "trigger('edit', [light.on.key, !light.on.value])",
    )
    icon_button(
        (_SOLO_ICON.format("light.soloed"),),
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


def _mix() -> None:
    with _panel("Mix", "instant faders for the lights"):
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
                        (_SOLO_ICON.format("light.fader_soloed"),),
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


def _materials() -> None:
    with _panel("Material"):
        html.Div("No mesh is open.", v_if="!has_mesh", classes="studio-unit")
        with html.Div(v_for="material in materials", key=("material.number",)):
            _material()
        with html.Div(v_if="has_mesh", classes="mt-2"):
            number_input("surfaces[0]", "feature-angle", "sharp edges, °")


def _material() -> None:
    html.Div("{{ material.name }}", v_if="materials.length > 1", classes="text-subtitle-2 mt-3")
    with v.VAutocomplete(
        model_value=("material.preset || null",),
        items=("material_names",),
        label="preset",
        placeholder="custom",
        persistent_placeholder=True,
        classes="mt-2",
        update_modelValue="$event && trigger('choose_material', [material.number, $event])",
        **found_by("material", "Named materials"),
    ):
        _balls("material")
    with v.VSelect(
        model_value=("material.reflectance",),
        items=("reflectance_names.map((name) => ({ value: name, title: name || 'as set in Scene' }))",),
        label="reflectance",
        classes="mt-3",
        update_modelValue="trigger('choose_reflectance', [material.number, $event])",
        **found_by("reflectance", "Reflectance"),
    ):
        _balls("reflectance")
    form("material.reflectance_fields")
    form("material.fields")
    _colormap()
    with html.Div(v_if="material.textured.length", classes="studio-row mt-2"):
        chosen = "(local['texture ' + material.number] ?? 'albedo')"
        v.VSelect(
            model_value=(chosen,),
            items=("material.textured",),
            label="texture of",
            classes="mt-2",
            update_modelValue="local['texture ' + material.number] = $event; flushState('local')",
            **found_by("texture-of", "Field that gets the texture"),
        )
        more = f" + '&material=' + material.number + '&field=' + {chosen}"
        file_input("texture", "image", more=more)


def _colormap() -> None:
    """Add inputs that choose an array for the albedo, its colormap and its range."""
    shown = "material.colormap"
    given = f"{shown}.scalars, {shown}.cmap"
    with html.Div(v_if=f"{shown}.arrays.length", classes="mt-2"):
        v.VSelect(
            model_value=(f"{shown}.scalars || null",),
            items=(f"{shown}.arrays",),
            label="colour by",
            placeholder="none",
            persistent_placeholder=True,
            clearable=True,
            classes="mt-2",
            update_modelValue="trigger('set_colormap', [material.number, $event])",
            **found_by("colour-by", "Array that colours the mesh, as albedo"),
        )
        with html.Div(v_if=f"{shown}.scalars"):
            v.VAutocomplete(
                model_value=(f"{shown}.cmap || null",),
                items=("colormap_names",),
                label="colormap",
                placeholder="custom",
                persistent_placeholder=True,
                classes="mt-3",
                update_modelValue=f"$event && trigger('set_colormap', [material.number, {shown}.scalars, $event])",
                **found_by("colormap", "Colormap"),
            )
            html.Div(style=(f"'height: 14px; border-radius: 3px; background: ' + {shown}.gradient",), classes="mt-2")
            with html.Div(classes="studio-numbers mt-2"):
                for end, ends in (
                    ("low", f"$event.target.value, {shown}.high"),
                    ("high", f"{shown}.low, $event.target.value"),
                ):
                    v.VTextField(
                        key=(f"'{end}' + material.number + refusals",),
                        model_value=(SIX_DIGITS.format(f"{shown}.{end}"),),
                        label=end,
                        inputmode="decimal",
                        change=f"trigger('set_colormap', [material.number, {given}, {ends}])",
                        **found_by(f"colormap-{end}"),
                    )
                v.VBtn(
                    "whole range",
                    variant="text",
                    click=f"trigger('set_colormap', [material.number, {given}])",
                    title="Use the smallest and largest value of the array",
                    **found_by("colormap-range"),
                )


def _balls(kind: str) -> None:
    """Add thumbnails to the entries of a list."""
    with v.Template(v_slot_item="{ props, item }"), v.VListItem(v_bind="props"), v.Template(v_slot_prepend=True):
        html.Img(
            v_if="item.value",
            src=(f"'thumbnail/{kind}/' + item.value",),
            width=32,
            height=32,
            classes="mr-3",
            alt="",
            loading="lazy",
        )


def _picture() -> None:
    """Add inputs for exposure, tone curve and overlay. Downloaded meshes do not depend on them."""
    with _panel("Picture", "exposure and tone curve"):
        number_input("display.exposure", "exposure")
        v.VSelect(
            model_value=("display.tone.value",),
            items=("display.tone.choices",),
            label="tone curve",
            classes="mt-3",
            update_modelValue="trigger('edit', ['display.tone', $event])",
            title=("display.tone.help",),
            **found_by("tone", "Tone curve"),
        )
        for overlay, label in (("clipping", "mark clipped colours"), ("false color", "luminance in false colours")):
            is_on = f"display.overlay.value == '{overlay}'"
            edit = f"trigger('edit', ['display.overlay', $event ? '{overlay}' : 'none'])"
            switch(overlay.replace(" ", "-"), is_on, label, edit)


def _plan() -> None:
    with _panel("Plan", "effects that run, and their cost"):
        number_input("accuracy.tolerance", "tolerance")
        html.Div("{{ plan.accuracy }}", classes="text-caption mt-2")
        with v.VTable(density="compact", classes="studio-plan mt-1", v_for="mesh in plan.meshes", key=("mesh.name",)):
            html.Caption("{{ mesh.name }}", v_if="plan.meshes.length > 1")
            with html.Thead(), html.Tr():
                for heading in ("effect", "run", "why", "bound", "ns"):
                    html.Th(heading, raw_attrs=['scope="col"'])
            with html.Tbody(), html.Tr(v_for="row in mesh.rows", key=("row[0]",), **found_by("plan-row")):
                is_on = "k == 1 && cell == 'on'"
                is_marked = f"{is_on} ? 'text-primary font-weight-bold' : ''"
                html.Td("{{ cell }}", v_for="(cell, k) in row", key=("k",), classes=(is_marked,))
        html.Div(
            "bound: largest colour error, where 1 is full intensity; ns: nanoseconds per vertex on one core, compiled.",
            classes="studio-unit mt-1",
        )


def _accuracy() -> None:
    with _panel("Accuracy", "and its cost in time"):
        with html.Div(classes="studio-row mt-0", title=("accuracy.refine.help",)):
            refine = "trigger('edit', ['accuracy.refine', $event ? 1 / 255 : null])"
            switch("refine", "accuracy.refine.set", "refine the view", refine)
            html.Span("{{ refined }}", classes="studio-unit", **found_by("refined", status=True))
        with html.Div(v_if="accuracy.refine.set"):
            number_input("accuracy.refine", "refine-tolerance", "largest error")
        html.H3("Report", classes="text-caption mt-3")
        with html.Div(classes="studio-row"):
            typed_number("seconds", "s", label="time", classes="studio-number", found="report-seconds")
            v.VBtn(
                "Measure",
                v_if="!report.running",
                disabled=("!has_mesh",),
                click=f"trigger('report', [{typed('seconds')}])",
                **found_by("report", "Measure accuracy against time"),
            )
            v.VBtn("Cancel", v_if="report.running", click="trigger('cancel_report')", **found_by("cancel-report"))
        html.Div("{{ report.doing }}", v_if="report.doing", classes="text-caption mt-2", **found_by("report-doing"))
        v.VProgressLinear(
            v_if="report.running",
            model_value=("100 * report.part",),
            indeterminate=("!report.part",),
            height=6,
            **found_by("", "Progress of the report"),
        )
        html.Div(
            "{{ line }}",
            v_for="line in report.lines",
            key=("line",),
            classes="text-body-2 mt-2",
            **found_by("report-line"),
        )
        with html.Div(v_if="report.worst.length"):
            mark = "mark the worst vertices in the view"
            switch("mark-worst", "marked", mark, "trigger('mark_worst', [$event])")
            html.Div(
                "Colour error, where 1 is full intensity: "
                "{{ report.worst.map(([index, error]) => `vertex ${index}: ${error.toPrecision(2)}`).join(', ') }}",
                classes="studio-unit",
            )
        with html.A(v_if="report.figure", href=("report.figure",), target="_blank", title="Open in full size"):
            html.Img(
                src=("report.figure",),
                style="width: 100%",
                classes="mt-2",
                alt="Error against time",
                **found_by("report-figure"),
            )


def _files() -> None:
    with _panel("Files"):
        html.H3("Save", classes="text-caption")
        with html.Div(classes="studio-buttons mt-1"):
            single = "mesh_count < 2"
            _take("rig", "rig", "Lights, viewer, light model and materials as .json, for pvphong --scene")
            _take("vtp", "mesh .vtp", "The lit mesh, with float colours", v_if=single)
            _take("ply", "mesh .ply", "The lit mesh, with 8-bit colours", v_if=single)
            _take("vtkhdf", "blocks .vtkhdf", "The lit meshes as blocks, with float colours", v_if="mesh_count > 1")
            _take("glb", "glTF", "The lit mesh with its colours as .glb, for other programs")
            _take("py", "Python", "The script below, as a file")
        with html.Div(classes="studio-row", style="flex-wrap: wrap"):
            for side in ("width", "height"):
                typed_number(side, "px", classes="studio-size", found=f"picture-{side}")
            width, height = (f"encodeURIComponent({typed(side)})" for side in ("width", "height"))
            size = f"?width=' + {width} + '&height=' + {height} + '"
            _take("png", "picture .png", "The view without gizmos and refinement, in this size", size)
        html.H3("Python script that reproduces the colours exactly", classes="text-caption mt-3")
        v.VTextarea(
            model_value=("script",),
            readonly=True,
            rows=8,
            no_resize=True,
            classes="studio-code mt-1",
            **found_by("script", "Python script that lights the mesh as shown"),
        )
        v.VBtn(
            "Copy",
            prepend_icon="mdi-content-copy",
            classes="mt-1",
            click="utils.get('navigator').clipboard.writeText(script)",
            **found_by("copy-script"),
        )
        html.H3("Open another mesh or a rig", classes="text-caption mt-4")
        html.Div(
            "Another mesh keeps the lights: they are moved and scaled to fit it. Undo shows the mesh before it.",
            classes="studio-unit",
        )
        _open("mesh")
        file_input("rig", "rig: .json", accept=".json")
        only, more = "rig, materials only: .json", " + '&part=material'"
        file_input("rig", only, name="material", more=more, accept=".json")


def _take(what: str, label: str, tip: str, query: str = "", **more: Any) -> None:
    v.VBtn(
        label,
        href=(f"'take/{what}{query}'",),
        prepend_icon="mdi-download",
        disabled=("!has_mesh",),
        title=tip,
        __properties=["download"],
        download=True,
        **found_by(f"download-{what}", f"Download: {label}"),
        **more,
    )


def _open(name: str) -> None:
    """Add buttons for the examples, and a file input for a mesh."""
    with html.Div(classes="studio-buttons mt-1"):
        v.VBtn(
            "{{ name }}",
            v_for="name in example_names",
            key=("name",),
            click="trigger('open_example', [name])",
            raw_attrs=[":data-test=\"'example-' + name\"", ":aria-label=\"'Open the example ' + name\""],
        )
    file_input("mesh", "mesh: .stl .ply .obj .vtp .vtu .vtk .glb …", name=name)


def _awaited(name: str, doing: str, cancel: str, *, paused: str = "false", go_on: str = "") -> None:
    """Add a progress card over the view for a background computation.

    The state variable `name` is its percentage, or null if nothing is computed. `paused` is the state variable for
    whether it has paused, and `go_on` the trigger that continues it.
    """
    with v.VCard(v_if=f"{name} !== null", classes="pl-3 pr-1 py-1 mb-1", **found_by(name)):
        with html.Div(classes="studio-row mt-0"):
            html.Span(f"{{{{ {paused} ? 'paused' : '{doing}' }}}}", classes="text-body-2", **found_by("", status=True))
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
            then = "(before, call) => before.then(() => trigger(...call))"
            calls = f"remedy.calls.slice(1).reduce({then}, trigger(...remedy.calls[0]))"
            v.VBtn(
                "{{ remedy.label }}",
                v_for="remedy in remedies",
                key=("remedy.label",),
                classes="ml-1",
                click=calls,
                **found_by("remedy"),
            )


def _start() -> None:
    """Add the card that the view shows while there is no mesh."""
    with v.VCard(v_if="!has_mesh", classes="studio-start pa-4", max_width=420, **found_by("start")):
        html.H2("Light a mesh", classes="text-h6")
        html.Div("Choose an example or open a file. The studio adds lights to it.", classes="text-body-2 mb-2")
        _open("first-mesh")
