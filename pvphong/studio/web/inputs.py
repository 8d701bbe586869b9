"""Inputs of the page: a number with its slider, a colour, a switch, a file, and a form for any fields.

An input sends triggers: "edit" with a new value, "slide" while a slider or a picker moves, and "settle" on release.
While a slider moves, the browser shows its own value (`local`), because the server's values arrive later.

Numbers are typed and sent as text, because a browser's number input silently turns "1,5" into 15. In the functions
below, `entry` is the JavaScript name of a form's entry: a dictionary from `fields.form_of` with key, label and value.
"""

from __future__ import annotations

from typing import Any

from trame.widgets import html
from trame.widgets import vuetify3 as v

Text = str | tuple[str]
"""A text, or a tuple with a JavaScript expression for it, as in trame."""

_DENSE = {"density": "compact", "hideDetails": True}
_OUTLINED = {**_DENSE, "variant": "outlined"}
DEFAULTS = {
    **dict.fromkeys(("VTextField", "VTextarea", "VSelect", "VAutocomplete", "VFileInput"), _OUTLINED),
    "VSwitch": {**_DENSE, "color": "primary", "inset": True},
    "VBtn": {"size": "small", "variant": "tonal"},
    "VProgressLinear": {"color": "primary", "rounded": True},
}
"""Default properties of Vuetify's components."""

FINE = """
window.studioSlider = { isFine: false, isKey: false, key: null, given: 0, value: 0 };
['pointerdown', 'pointermove', 'mousedown', 'mousemove', 'touchstart', 'keydown', 'keyup'].forEach((name) =>
  window.addEventListener(name, (event) => {
    Object.assign(window.studioSlider, { isFine: event.shiftKey, isKey: name.startsWith('key') });
    if (!event.shiftKey || name.endsWith('down')) window.studioSlider.key = null;
  }, true));
window.studioSlide = (key, given, value, step) => {
  const slider = window.studioSlider;
  if (!slider.isFine) return given;
  if (slider.isKey) return value + Math.sign(given - value) * step / 8;
  if (slider.key !== key) Object.assign(slider, { key, given, value });
  return slider.value + (given - slider.given) / 8;
};
"""
"""JavaScript for sliders: with Shift, the value moves an eighth as far as the pointer, or as a step of the keys."""

SIX_DIGITS = "Number(({0}).toPrecision(6))"
"""JavaScript expression that formats a number with six digits."""


CALLS = "{0}.calls.slice(1).reduce((before, call) => before.then(() => trigger(...call)), trigger(...{0}.calls[0]))"
"""JavaScript expression that calls the triggers of a `Remedy`, one after the other."""


def found_by(name: str, label: Text = "", *, status: bool = False) -> dict[str, Any]:
    """Return attributes by which tests find an element: `name` is its `data-test`.

    With `label`, screen readers call the element by this label. With `status`, screen readers also announce changes of
    the element's content.
    """
    raw = [f'data-test="{name}"'] if name else []
    if label:
        raw.append(f':aria-label="{label[0]}"' if isinstance(label, tuple) else f'aria-label="{label}"')
    if status:
        raw.append('role="status"')
    return {"raw_attrs": raw}


def icon_button(icon: Text, name: str, label: Text, click: str, *, size: str = "x-small", **more: Any) -> None:
    """Add a small button that shows only the icon `icon`.

    Parameters
    ----------
    icon, name, label
        The icon, the name for tests, and the label for screen readers.
    click : str
        JavaScript that a click runs.
    size : str
        Vuetify's size.
    **more
        Further attributes of the button.
    """
    v.VBtn(
        icon=icon,
        size=size,
        variant="text",
        title=label,
        __events=[("click_stop", "click.stop")],
        click_stop=click,
        **found_by(name, label),
        **more,
    )


def switch(name: str, value: str, label: Text, changed: str) -> None:
    """Add a switch with a label for the JavaScript expression `value`. A change runs the JavaScript `changed`.

    If the server refuses a change, the switch is reset.
    """
    v.VSwitch(
        key=(f"'{name}' + {value} + refusals",),
        model_value=(value,),
        label=label,
        update_modelValue=changed,
        **found_by(name),
    )


def color_picker(entry: str) -> None:
    """Add a colour swatch that opens Vuetify's colour picker.

    Under the picker are inputs for the linear numbers, which may exceed 1. `entry` is the JavaScript name of the entry.
    """
    shown = f"(local[{entry}.key] ?? {entry}.hex)"
    picked = "$event.slice(0, 7)"
    with v.VMenu(
        close_on_content_click=False,
        update_modelValue=f"$event || (delete local[{entry}.key], flushState('local'), trigger('settle'))",
    ):
        with v.Template(v_slot_activator="{ props }"):
            v.VBtn(
                v_bind="props",
                classes="studio-swatch",
                variant="flat",
                color=(shown,),
                title=(f"{entry}.help",),
                **found_by("swatch", (f"{entry}.label + ' colour ' + {shown}",)),
            )
        with v.VCard(width=300):
            v.VColorPicker(
                model_value=(shown,),
                mode="hex",
                modes=("['hex', 'rgb']",),
                elevation=0,
                update_modelValue=(
                    f"local[{entry}.key] = {picked}; flushState('local'); trigger('slide', [{entry}.key, {picked}])"
                ),
            )
            with html.Div(classes="px-3 pb-3 studio-numbers"):
                _numbers(entry, f"{entry}.value", "[k]", "['red', 'green', 'blue'][k]")


def color_text(entry: str) -> None:
    """Add an input for a colour's hex string or name. `entry` is the JavaScript name of the entry."""
    v.VTextField(
        key=(f"{entry}.key + 'text' + refusals",),
        model_value=(f"local[{entry}.key] ?? {entry}.hex",),
        classes="studio-hex",
        change=f"trigger('edit', [{entry}.key, $event.target.value])",
        title=(f"{entry}.help",),
        **found_by("", (f"{entry}.label + ' colour, as #rrggbb or a name'",)),
    )


def number_input(entry: str, name: str = "number", label: str = "") -> None:
    """Add a number input with its unit. If the number has a slider, add the slider too.

    Parameters
    ----------
    entry : str
        JavaScript name of the form's entry, a dictionary from `fields.form_of`.
    name : str
        Name for tests.
    label : str
        Label; by default, the entry's own.
    """
    called = f"'{label}'" if label else f"{entry}.label"
    moved = f"local[{entry}.key]"
    value = f"({moved} === undefined ? {entry}.value : {entry}.stops ? 2 ** {moved} : {moved})"
    with html.Div(classes="studio-row", title=(f"{entry}.help",), **found_by(name)):
        v.VTextField(
            key=(f"{entry}.key + refusals",),
            model_value=(f"{value} == null ? '' : " + SIX_DIGITS.format(value),),
            label=(f"{called} + ({entry}.unit.length > 2 ? ', ' + {entry}.unit : '')",),
            suffix=(f"{entry}.unit.length > 2 ? '' : {entry}.unit",),
            inputmode="decimal",
            classes="studio-number",
            change=f"trigger('edit', [{entry}.key, $event.target.value.trim() || null])",
        )
        slid = f"utils.get('studioSlide')({entry}.key, $event, {moved} ?? {entry}.slide, {entry}.step)"
        v.VSlider(
            v_if=f"{entry}.to !== undefined",
            __events=["dblclick"],
            dblclick=f"trigger('edit', [{entry}.key, {entry}.default])",
            title="Shift: fine; double-click: default",
            model_value=(f"{moved} ?? {entry}.slide",),
            min=(f"{entry}.from",),
            max=(f"{entry}.to",),
            step=(f"{entry}.step",),
            density="compact",
            hide_details=True,
            thumb_size=14,
            track_size=3,
            color="primary",
            update_modelValue=f"{moved} = {slid}; flushState('local'); trigger('slide', [{entry}.key, {moved}])",
            end=f"trigger('settle').then(() => {{ delete {moved}; flushState('local') }})",
            **found_by("", (f"{called} + ', slider'",)),
        )


def typed(name: str) -> str:
    """Return the JavaScript expression for the text in the input that `typed_number` has added.

    `name` is the state variable. The server may not have accepted the text yet.
    """
    return f"(local.{name} ?? {name})"


def typed_number(name: str, unit: str, *, found: str, label: str = "", classes: str) -> None:
    """Add an input for a number of the page's state that is not part of the document.

    If the server refuses a change, the input shows the state's value again.

    Parameters
    ----------
    name : str
        Name of the state variable.
    unit : str
        Unit behind the number.
    found : str
        Name for tests.
    label : str
        Label; by default, `name`.
    classes : str
        CSS classes.
    """
    v.VTextField(
        model_value=(typed(name),),
        update_modelValue=f"local.{name} = $event; flushState('local')",
        label=label or name,
        suffix=unit,
        inputmode="decimal",
        classes=classes,
        change=(
            f"trigger('type_number', ['{name}', $event.target.value])"
            f".then(() => {{ delete local.{name}; flushState('local') }})"
        ),
        **found_by(found),
    )


def _numbers(entry: str, values: str, index: str, label: str) -> None:
    """Add inputs for several numbers side by side. Each input sends its index with its value.

    All arguments are JavaScript expressions: the form's entry, its numbers, and index and label of number `k`.
    """
    v.VTextField(
        v_for=f"(number, k) in {values}",
        key=(f"{entry}.key + {index} + refusals",),
        model_value=(SIX_DIGITS.format("number"),),
        label=(label,),
        inputmode="decimal",
        change=f"trigger('edit', [{entry}.key, $event.target.value, {index}])",
    )


def form(entries: str) -> None:
    """Add an input for each entry of the JavaScript list `entries`.

    The input depends on the kind of the entry's field.
    """
    with html.Div(v_for=f"field in {entries}", key=("field.key",), raw_attrs=[':data-field="field.name"']):
        with html.Div(v_if="field.map", classes="studio-row", title=("field.help",)):
            html.Span("{{ field.label }}", classes="studio-label")
            v.VChip("{{ field.map }}", size="small", prepend_icon="mdi-texture")
            v.VBtn(
                "{{ field.takes == 'image' ? 'white' : 'remove' }}",
                size="x-small",
                variant="text",
                click="trigger('edit', [field.key, field.default])",
                **found_by("remove-map", ("'Remove the map of ' + field.label",)),
            )
        with html.Div(v_else_if="field.kind == 'number'"):
            number_input("field")
        for kind, rows, index, label in (
            ("numbers", "[field.value]", "[k]", "field.labels[k]"),
            ("points", "field.value", "[row, k]", "field.labels[k] + ' of ' + (row + 1)"),
        ):
            with html.Div(v_else_if=f"field.kind == '{kind}'"):
                html.Div(
                    "{{ field.label }} <span class='studio-unit'>{{ field.unit }}</span>",
                    classes="text-caption mt-2",
                    title=("field.help",),
                )
                with html.Div(v_for=f"(values, row) in {rows}", key=("row",), classes="studio-numbers mt-2"):
                    _numbers("field", "values", index, label)
        with html.Div(v_else_if="field.kind == 'color'", classes="studio-row studio-color", title=("field.help",)):
            html.Span("{{ field.label }}", classes="studio-label")
            with html.Div(v_if="field.set", classes="studio-numbers"):
                color_picker("field")
                color_text("field")
            v.VChip("same as diffuse", v_if="!field.set", size="small")
            v.VSpacer()
            v.VBtn(
                "{{ field.set ? 'same as diffuse' : 'set colour' }}",
                v_if="field.optional",
                variant="text",
                click="trigger('edit', [field.key, field.set ? null : '#ffffff'])",
            )
            to_light = " + '&light=' + field.key.split('.')[1]"
            file_input("sky", "image: .hdr .png .jpg", more=to_light, v_if="field.takes == 'image'")
        with html.Div(v_else_if="field.kind == 'flag'", classes="studio-row", title=("field.help",)):
            switch("flag", "field.value", ("field.label",), "trigger('edit', [field.key, $event])")
            v.VTextField(
                v_if="field.takes == 'number' && field.value",
                key=("field.key + 'number' + refusals",),
                model_value=("field.number ?? ''",),
                label="distance, mesh units",
                placeholder="unlimited",
                inputmode="decimal",
                persistent_placeholder=True,
                change="trigger('edit', [field.key, $event.target.value.trim() || true])",
            )
        v.VSelect(
            v_else_if="field.kind == 'choice'",
            classes="mt-3",
            model_value=("field.value",),
            items=("field.items ?? field.choices",),
            label=("field.label",),
            update_modelValue="trigger('edit', [field.key, $event])",
            title=("field.help",),
        )


def file_input(what: str, label: str, *, name: str = "", more: str = "", found: str = "", **attributes: Any) -> None:
    """Add an input for a file, which is uploaded by HTTP.

    Parameters
    ----------
    what : str
        Kind of file, the last folder of the upload's address.
    label : str
        Label of the input.
    name : str
        Name for tests; by default, `what`.
    more : str
        JavaScript that continues the address.
    found : str
        The input's `data-test`; by default "upload-", followed by `name`.
    **attributes
        Further attributes of the input.
    """
    sent = f"'bring/{what}?name=' + encodeURIComponent([].concat($event)[0].name){more}"
    v.VFileInput(
        key=(f"'{name or what}' + uploads",),
        label=label,
        classes="mt-2",
        prepend_icon="",
        prepend_inner_icon="mdi-upload",
        loading=("busy",),
        disabled=("busy",),
        update_modelValue=(
            f"[].concat($event)[0] && (busy = true, utils.get('fetch')({sent},"
            " { method: 'POST', body: [].concat($event)[0] }).finally(() => { busy = false; uploads += 1 }))"
        ),
        **attributes,
        **found_by(found or f"upload-{name or what}"),
    )
