"""The page: Vuetify's components around the view, filled from the document's plain values.

Each panel is a function, in the order in which they stand on the page; their inputs are in `inputs.py`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from trame.ui.vuetify3 import VAppLayout
from trame.widgets import client, html
from trame.widgets import vuetify3 as v
from trame_pyvista.widgets import PyVistaRCAView

from pvphong.studio.web.inputs import (
    DENSE,
    color_picker,
    color_text,
    file_input,
    form,
    found_by,
    icon_button,
    number_input,
)

_WIDTH, _NARROW = 400, 860
"""Pixels of the panels, and of a window so narrow that they lie over the view."""


_STYLE = """
html { overflow: hidden !important }
.studio-view { position: absolute; inset: 0; touch-action: none }
.studio-view:focus-within { outline: 2px solid rgb(var(--v-theme-primary)); outline-offset: -2px }
.studio-number { flex: 0 0 142px }
.studio-row { display: flex; align-items: center; gap: 8px; margin-top: 10px }
.studio-label { flex: 0 0 116px; font-size: 13px; line-height: 1.2; overflow-wrap: anywhere }
.studio-unit { opacity: .7; font-size: 12px }
.studio-hex { flex: 0 0 86px }
.studio-hex input, .studio-name input { padding: 0 8px !important; font-size: 14px }
.studio-color { flex-wrap: wrap }
.studio-color .v-file-input { flex: 1 0 100%; margin-top: 2px !important }
.studio-size { flex: 0 0 116px }
.studio-swatch { width: 32px; height: 40px !important; min-width: 32px !important;
  border: 1px solid rgba(128, 128, 128, .6) }
.studio-panel { max-width: 92vw }
.studio-jump { display: flex; overflow-x: auto; padding: 4px 8px; border-bottom: 1px solid rgba(128, 128, 128, .3) }
.studio-light { border-color: rgba(128, 128, 128, .35) }
.studio-selected { border-color: rgb(var(--v-theme-primary)); box-shadow: 0 0 0 1px rgb(var(--v-theme-primary)) }
.studio-panels .v-expansion-panel-title, .studio-panels .v-expansion-panel--active > .v-expansion-panel-title {
  min-height: 38px; padding: 6px 16px; font-weight: 500 }
.studio-panels .v-expansion-panel { border-bottom: 1px solid rgba(128, 128, 128, .25) }
.studio-panels .v-expansion-panel-text__wrapper { padding: 2px 16px 14px }
.studio-panels input[type=number] { appearance: textfield; -moz-appearance: textfield }
.studio-panels input::-webkit-inner-spin-button { display: none }
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
"""Undo and redo wherever the focus is; the view has its keys for them."""


_DRAWN = f"drawer ?? utils.get('innerWidth') > {_NARROW}"
"""Whether the panels are out: at first where there is room beside the view."""

_PANELS = ("lights", "mix", "material", "scene", "plan", "accuracy", "files")
_JUMP = (
    "open_panels = open_panels.includes({number}) ? open_panels : [...open_panels, {number}];"
    " utils.get('document').getElementById('panel-{name}').scrollIntoView({{ behavior: 'smooth' }})"
)


_SHOW_SELECTED = (
    "utils.get('setTimeout')(() => utils.get('document').querySelector('.studio-selected')"
    "?.scrollIntoView({ block: 'nearest' }), 200)"
)
"""Scrolls to the row of the light that is selected, once it is there."""


def build(server: Any, plotter: Any, kinds: Mapping[str, str]) -> Any:
    """Lay the page out, and give its view.

    Parameters
    ----------
    server : trame_server.core.Server
        Whose page it is.
    plotter : pyvista.Plotter
        What the view shows.
    kinds : mapping
        Each kind of light that can be added, by its name in files → what it is, for a tooltip.
    """
    server.state.client_only("local", "drawer", "open_panels", "busy", "uploads", "picture", "seconds")
    server.state.update({"seconds": 20})
    server.state.update({"busy": False, "uploads": 0, "picture": {"width": 1920, "height": 1080}})
    server.state.update({"local": {}, "drawer": None, "open_panels": list(range(len(_PANELS)))})
    server.state.update({"refusals": 0, "notice": "", "theme": "dark", "trame__title": "pvphong studio"})
    with VAppLayout(server, theme=("theme",)):
        client.Style(_STYLE)
        client.Script(_KEYS)
        _bar()
        with v.VNavigationDrawer(
            model_value=(_DRAWN,),
            update_modelValue="drawer = $event",
            location="right",
            classes="studio-panel",
            width=_WIDTH,
            mobile_breakpoint=_NARROW,  # Vuetify's own would lay the panels over the view below 1280 pixels
            temporary=(f"utils.get('innerWidth') <= {_NARROW}",),
            **found_by("panels", "Panels"),
        ):
            with v.Template(v_slot_prepend=True), html.Div(classes="studio-jump"):
                for number, name in enumerate(_PANELS):
                    v.VBtn(
                        name.capitalize(),
                        size="small",
                        variant="text",
                        classes="text-none px-1",
                        min_width=0,
                        click=_JUMP.format(number=number, name=name),
                        **found_by(f"go-{name}"),
                    )
            with v.VExpansionPanels(
                v_model=("open_panels",), multiple=True, variant="accordion", flat=True, classes="studio-panels"
            ):
                _lights(kinds)
                _mix()
                _materials()
                _scene()
                _plan()
                _accuracy()
                _files()
        with (
            v.VMain(style="height: 100vh"),
            html.Div(style="position: relative; height: 100%"),
            html.Div(classes="studio-view", **found_by("view", "View of the model, with gizmos: h lists the keys")),
        ):
            view = PyVistaRCAView(plotter, send_mouse_move=True, style="width: 100%; height: 100%")
            _start()
            with html.Div(classes="studio-awaited"):
                for condition, name, doing, cancel in (
                    ("gathering !== null", "gathering", "gathering light that bounces", "cancel_bounces"),
                    ("refining", "refining", "refining the view", "cancel_refining"),
                ):
                    _awaited(condition, name, doing, cancel)
        v.VSnackbar(
            "{{ notice }}",
            model_value=("!!notice",),
            timeout=-1,
            location="bottom left",
            **found_by("notice", raw=['role="status"']),
        )
    return view


# --- parts


def _bar() -> None:
    with v.VAppBar(density="compact", flat=True, border=True):
        v.VAppBarTitle("{{ title }}", classes="text-body-1 font-weight-medium")
        _button("mdi-undo", "undo", "Undo (Ctrl+Z)", "trigger('undo')", disabled=("!can_undo",))
        _button("mdi-redo", "redo", "Redo (Ctrl+Y)", "trigger('redo')", disabled=("!can_redo",))
        _button("mdi-fit-to-screen-outline", "fit", "Show all of the model", "trigger('fit')")
        _button("mdi-vector-point-select", "gizmos", "Show or hide the gizmos", "trigger('gizmos')")
        _button("mdi-theme-light-dark", "theme", "Dark or light page", "trigger('theme')")
        _button("mdi-dock-right", "drawer", "Show or hide the panels", f"drawer = !({_DRAWN})")


def _button(icon: str, name: str, label: str, click: str, **more: Any) -> None:
    v.VBtn(
        icon=icon, size="small", variant="text", click=click, **found_by(name, label, raw=[f'title="{label}"']), **more
    )


@contextmanager
def _panel(title: str, note: str = "") -> Iterator[None]:
    with v.VExpansionPanel(eager=True, id=f"panel-{title.lower()}"):
        with v.VExpansionPanelTitle(title):
            html.Span(note, classes="studio-unit ml-2") if note else None
        with v.VExpansionPanelText():
            yield


def _lights(kinds: Mapping[str, str]) -> None:
    with _panel("Lights"):
        with html.Div(style="display: flex; flex-wrap: wrap; gap: 4px", **found_by("", "Add a light")):
            for kind, what in kinds.items():
                v.VBtn(
                    f"+ {kind}",
                    size="small",
                    variant="tonal",
                    classes="text-none px-2",
                    min_width=0,
                    click=f"trigger('add', ['{kind}']).then(() => {_SHOW_SELECTED})",
                    **found_by(f"add-{kind}", f"Add a light: {kind}", raw=[f'title="{what}"']),
                )
        with v.VCard(
            v_for="light in lights",
            key=("light.number",),
            variant="outlined",
            classes=("'studio-light mt-3 pa-2' + (light.selected ? ' studio-selected' : '')",),
            click="light.selected || trigger('select', [light.number])",
            ripple=False,
            **found_by("light-row", raw=[":aria-label=\"'Light ' + light.called\""]),
        ):
            _light_row()


def _light_row() -> None:
    with html.Div(style="display: flex; align-items: center; gap: 6px", classes="studio-head"):
        with html.Div(style="display: flex; gap: 4px", **found_by("colour")):
            color_picker("light.diffuse")
            color_text("light.diffuse")
        v.VTextField(
            model_value=("light.name.value",),
            key=("light.name.key + refusals",),
            label=("light.kind",),
            placeholder="without a name",
            classes="studio-name",
            change="trigger('edit', [light.name.key, $event.target.value])",
            **DENSE,
            **found_by("light-name", raw=[":aria-label=\"'Name of the light, ' + light.kind\""]),
        )
        icon_button(
            "light.on.value ? 'mdi-lightbulb-on-outline' : 'mdi-lightbulb-off-outline'",
            "light-on",
            "'Light off or on'",
            "trigger('edit', [light.on.key, !light.on.value])",
        )
        icon_button(
            "light.soloed ? 'mdi-alpha-s-circle' : 'mdi-alpha-s-circle-outline'",
            "light-solo",
            "'Solo: this light alone, or all'",
            "trigger('act', ['solo', light.number])",
        )
        with v.VMenu():
            with v.Template(v_slot_activator="{ props }"):
                v.VBtn(
                    icon="mdi-dots-vertical",
                    size="x-small",
                    variant="text",
                    v_bind="props",
                    **found_by(
                        "light-menu",
                        "More that can be done with the light",
                        raw=['title="Duplicate, to camera, reset, delete"'],
                    ),
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
    number_input("light.intensity", "intensity")
    with html.Div(v_if="light.selected"):
        form("light.fields")


def _mix() -> None:
    with _panel("Mix", "faders: no light is evaluated again"):
        with html.Div(classes="studio-row mt-0"):
            v.VSwitch(
                key=("'mixing' + mixing + refusals",),
                model_value=("mixing",),
                label="mix the lights' shares",
                density="compact",
                hide_details=True,
                color="primary",
                inset=True,
                update_modelValue="trigger('start_mix', [$event])",
                **found_by("mix"),
            )
            v.VSpacer()
            v.VBtn(
                "Keep this mix",
                v_if="mixing",
                size="small",
                variant="tonal",
                classes="text-none",
                click="trigger('keep_mix')",
                **found_by("keep-mix", raw=['title="Write it into the lights\' intensities and colours"']),
            )
        with html.Div(v_if="mixing"):
            with html.Div(
                v_for="light in lights",
                key=("light.number",),
                classes="mt-2",
                **found_by("fader", raw=[":aria-label=\"'Fader of ' + light.called\""]),
            ):
                with html.Div(style="display: flex; align-items: center; gap: 4px", v_if="light.fader.length"):
                    color_picker("light.fader[1]")
                    html.Span("{{ light.called }}", classes="studio-label ml-1")
                    v.VSpacer()
                    icon_button(
                        "light.fader[2].value ? 'mdi-volume-off' : 'mdi-volume-high'",
                        "fader-mute",
                        "'Mute: leave this share out, or not'",
                        "trigger('edit', [light.fader[2].key, !light.fader[2].value])",
                    )
                    icon_button(
                        "light.fader_soloed ? 'mdi-alpha-s-circle' : 'mdi-alpha-s-circle-outline'",
                        "fader-solo",
                        "'Solo: this share alone, or all'",
                        "trigger('solo_fader', [light.number])",
                    )
                with html.Div(v_if="light.fader.length"):
                    number_input("light.fader[0]", "fader-gain")
            html.Div(
                "Lights evaluated: {{ evaluations }} times since the start; the last mix took {{ mix_ms }} ms.",
                classes="studio-unit mt-2",
                **found_by("evaluations"),
            )


def _materials() -> None:
    with _panel("Material"):
        html.Div("No mesh is open.", v_if="!has_mesh", classes="studio-unit")
        with html.Div(v_for="material in materials", key=("material.number",)):
            _material()
        with html.Div(v_if="has_mesh", classes="mt-2"):
            number_input("surfaces[0]", "feature-angle")


def _material() -> None:
    html.Div("{{ material.name }}", v_if="materials.length > 1", classes="text-subtitle-2 mt-3")
    with v.VAutocomplete(
        model_value=("material.preset || null",),
        items=("material_names",),
        label="preset",
        placeholder="none of these",
        persistent_placeholder=True,
        classes="mt-2",
        update_modelValue="$event && trigger('choose_material', [material.number, $event])",
        **DENSE,
        **found_by("material", "Named materials"),
    ):
        _balls("material")
    with v.VSelect(
        model_value=("material.reflectance",),
        items=("reflectance_names.map((name) => ({ value: name, title: name || 'the reflection in Scene' }))",),
        label="reflectance",
        classes="mt-3",
        update_modelValue="trigger('choose_reflectance', [material.number, $event])",
        **DENSE,
        **found_by("reflectance", "How it reflects"),
    ):
        _balls("reflectance")
    form("material.reflectance_fields")
    form("material.fields")
    with html.Div(v_if="material.textured.length", classes="studio-row mt-2"):
        chosen = "(local['texture ' + material.number] ?? 'albedo')"
        v.VSelect(
            model_value=(chosen,),
            items=("material.textured",),
            label="texture of",
            classes="mt-2",
            update_modelValue="local['texture ' + material.number] = $event; flushState('local')",
            **DENSE,
            **found_by("texture-of", "Which field a texture is laid on"),
        )
        more = f" + '&material=' + material.number + '&field=' + {chosen}"
        file_input("texture", "image", more=more)


def _balls(kind: str) -> None:
    """The entries of a list, each with its thumbnail."""
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


def _scene() -> None:
    with _panel("Scene"):
        form("model")


def _plan() -> None:
    with _panel("Plan", "what runs, and what is left out"):
        number_input("accuracy.tolerance", "tolerance")
        html.Div("{{ plan.accuracy }}", classes="text-caption mt-2")
        with v.VTable(density="compact", classes="studio-plan mt-1", v_for="mesh in plan.meshes", key=("mesh.name",)):
            html.Caption("{{ mesh.name }}", v_if="plan.meshes.length > 1")
            with html.Thead(), html.Tr():
                for heading in ("effect", "run", "why", "bound", "ns"):
                    html.Th(heading, raw_attrs=['scope="col"'])
            with html.Tbody(), html.Tr(v_for="row in mesh.rows", key=("row[0]",), **found_by("plan-row")):
                html.Td("{{ row[0] }}")
                html.Td("{{ row[1] }}", classes=("row[1] == 'on' ? 'text-primary font-weight-bold' : ''",))
                html.Td("{{ row[2] }}")
                html.Td("{{ row[3] }}")
                html.Td("{{ row[4] }}")
        html.Div(
            "bound: largest colour error, of 1 = full; "
            "ns: nanoseconds a vertex of the compiled evaluator, on one core.",
            classes="studio-unit mt-1",
        )


def _accuracy() -> None:
    with _panel("Accuracy", "what it costs in time"):
        with html.Div(classes="studio-row mt-0", raw_attrs=[':title="accuracy.refine.help"']):
            v.VSwitch(
                key=("'refine' + accuracy.refine.set + refusals",),
                model_value=("accuracy.refine.set",),
                label="refine the view",
                density="compact",
                hide_details=True,
                color="primary",
                inset=True,
                update_modelValue="trigger('edit', ['accuracy.refine', $event ? 1 / 255 : null])",
                **found_by("refine"),
            )
            html.Span("{{ refined }}", classes="studio-unit", **found_by("refined", raw=['role="status"']))
        with html.Div(v_if="accuracy.refine.set"):
            number_input("accuracy.refine", "refine-tolerance", "largest error")
        html.Div("Report", classes="text-caption mt-3")
        with html.Div(classes="studio-row"):
            v.VTextField(
                model_value=("seconds",),
                update_modelValue="seconds = $event",
                label="time",
                suffix="s",
                type="number",
                classes="studio-number",
                **DENSE,
                **found_by("report-seconds"),
            )
            v.VBtn(
                "Measure",
                v_if="!report.running",
                size="small",
                variant="tonal",
                classes="text-none",
                disabled=("!has_mesh",),
                click="trigger('report', [Number(seconds)])",
                **found_by("report", "Measure what accuracy costs in time"),
            )
            v.VBtn(
                "Cancel",
                v_if="report.running",
                size="small",
                variant="tonal",
                classes="text-none",
                click="trigger('cancel_report')",
                **found_by("cancel-report"),
            )
        html.Div("{{ report.doing }}", v_if="report.doing", classes="text-caption mt-2", **found_by("report-doing"))
        v.VProgressLinear(
            v_if="report.running",
            model_value=("report.percent",),
            indeterminate=("!report.percent",),
            color="primary",
            height=6,
            rounded=True,
            raw_attrs=['aria-label="How much of this is done"'],
        )
        html.Div(
            "{{ line }}",
            v_for="line in report.lines",
            key=("line",),
            classes="text-body-2 mt-2",
            **found_by("report-line"),
        )
        with html.Div(v_if="report.worst && report.worst.length"):
            v.VSwitch(
                key=("'marked' + marked",),
                model_value=("marked",),
                label="mark the worst vertices in the view",
                density="compact",
                hide_details=True,
                color="primary",
                inset=True,
                update_modelValue="trigger('mark_worst', [$event])",
                **found_by("mark-worst"),
            )
            html.Div(
                "Colour error, of 1 = full: "
                "{{ report.worst.map(([index, error]) => `vertex ${index}: ${error}`).join(', ') }}",
                classes="studio-unit",
            )
        with html.A(
            v_if="report.figure", href=("report.figure",), target="_blank", raw_attrs=['title="Open in full size"']
        ):
            html.Img(
                src=("report.figure",),
                style="width: 100%",
                classes="mt-2",
                alt="Error against time",
                **found_by("report-figure"),
            )


def _files() -> None:
    with _panel("Files"):
        html.Div("Take home", classes="text-caption")
        with html.Div(style="display: flex; flex-wrap: wrap; gap: 4px", classes="mt-1"):
            for what, label, tip in (
                ("rig", "rig", "Lights, viewer, light model and materials, .json: for pvphong --scene"),
                ("vtp", "mesh .vtp", "The lit mesh, colours as floats"),
                ("ply", "mesh .ply", "The lit mesh, colours of 8 bits"),
                ("gltf", "glTF", "The lit mesh for other programs, with its colours"),
                ("py", "Python", "The script below, as a file"),
            ):
                _take(
                    label,
                    tip,
                    what,
                    f"'take/{what}'",
                    v_if={"vtp": "materials.length < 2", "ply": "materials.length < 2"}.get(what, "true"),
                )
        with html.Div(classes="studio-row", style="flex-wrap: wrap"):
            for side in ("width", "height"):
                v.VTextField(
                    model_value=(f"picture.{side}",),
                    update_modelValue=f"picture.{side} = $event; flushState('picture')",
                    label=side,
                    suffix="px",
                    type="number",
                    classes="studio-size",
                    **DENSE,
                    **found_by(f"picture-{side}"),
                )
            _take(
                "picture .png",
                "What the view shows at the mesh's vertices, of that size, without gizmos",
                "png",
                "'take/png?width=' + picture.width + '&height=' + picture.height",
            )
        html.Div("Python that makes it, to the bit", classes="text-caption mt-3")
        v.VTextarea(
            model_value=("script",),
            readonly=True,
            rows=8,
            no_resize=True,
            classes="studio-code mt-1",
            **DENSE,
            **found_by("script", "Python that lights the mesh as it is lit here"),
        )
        v.VBtn(
            "Copy",
            size="small",
            variant="tonal",
            prepend_icon="mdi-content-copy",
            classes="text-none mt-1",
            click="utils.get('navigator').clipboard.writeText(script)",
            **found_by("copy-script"),
        )
        html.Div("Open another mesh, or take over a rig", classes="text-caption mt-4")
        html.Div(
            "Another mesh begins with lights of its own: take the rig home first, to take it over again.",
            classes="studio-unit",
        )
        _examples()
        file_input("mesh", "mesh: .stl .ply .obj .vtp .vtu .vtk .glb …")
        file_input("rig", "rig: .json", accept=".json")
        only, more = "only the materials of a rig: .json", " + '&part=material'"
        file_input("rig", only, name="material", more=more, accept=".json")


def _take(label: str, tip: str, what: str, address: str, **more: Any) -> None:
    v.VBtn(
        label,
        size="small",
        variant="tonal",
        classes="text-none px-2",
        min_width=0,
        href=(address,),
        prepend_icon="mdi-download",
        disabled=("!has_mesh",),
        **found_by(f"download-{what}", f"Download: {label}", raw=["download", f'title="{tip}"']),
        **more,
    )


def _examples() -> None:
    with html.Div(style="display: flex; flex-wrap: wrap; gap: 4px", classes="mt-1"):
        v.VBtn(
            "{{ name }}",
            v_for="name in example_names",
            key=("name",),
            size="small",
            variant="tonal",
            classes="text-none px-2",
            min_width=0,
            click="trigger('open_example', [name])",
            raw_attrs=[":data-test=\"'example-' + name\"", ":aria-label=\"'Open the example ' + name\""],
        )


def _awaited(condition: str, name: str, doing: str, cancel: str) -> None:
    """What stands in the view while something is computed in the background."""
    with v.VCard(v_if=condition, classes="pl-3 pr-1 py-1 mb-1", **found_by(name)):
        with html.Div(style="display: flex; align-items: center; gap: 8px"):
            html.Span(doing, classes="text-body-2", raw_attrs=['role="status"'])
            v.VSpacer()
            v.VBtn(
                "Cancel",
                size="small",
                variant="text",
                classes="text-none",
                click=f"trigger('{cancel}')",
                **found_by(cancel.replace("_", "-"), f"Cancel: {doing}"),
            )
        v.VProgressLinear(
            model_value=("gathering",) if name == "gathering" else 0,
            indeterminate=("!gathering",) if name == "gathering" else True,
            color="primary",
            height=4,
            rounded=True,
            raw_attrs=[f'aria-label="How much is done: {doing}"'],
        )


def _start() -> None:
    """What stands in the view as long as there is no mesh."""
    with v.VCard(v_if="!has_mesh", classes="studio-start pa-4", max_width=420, **found_by("start")):
        html.Div("Light a mesh", classes="text-h6")
        html.Div("Take one of these, or a file of yours; lights and scene begin with it.", classes="text-body-2 mb-2")
        _examples()
        file_input("mesh", "mesh: .stl .ply .obj .vtp .vtu .vtk .glb …", name="first-mesh")
