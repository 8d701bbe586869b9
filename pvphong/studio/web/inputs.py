"""Inputs of the page: a number with its slider, a colour, a file, and a form of whatever fields there are.

What an input does is one trigger: "edit" for a value, "slide" while a slider or a picker moves, "settle" when it is let
go. While a slider moves, the browser shows its own value (`local`), for those of the server come later.
"""

from __future__ import annotations

from typing import Any

from trame.widgets import html
from trame.widgets import vuetify3 as v

DENSE = {"density": "compact", "variant": "outlined", "hide_details": True}
"""How all inputs look."""

_NUMBER = "Number(({0}).toPrecision(6))"
"""How a number is shown: with six digits."""


def found_by(name: str, label: str = "", **more: Any) -> dict[str, Any]:
    """The attributes by which tests, and screen readers where a label is given, find an element."""
    raw = [f'data-test="{name}"'] if name else []
    raw += [f'aria-label="{label}"'] if label else []
    return {"raw_attrs": raw + more.pop("raw", []), **more}


def icon_button(icon: str, name: str, label: str, click: str) -> None:
    """A small button, whose icon and label are expressions."""
    v.VBtn(
        icon=(icon,),
        size="x-small",
        variant="text",
        __events=[("click_stop", "click.stop")],
        click_stop=click,
        **found_by(name, raw=[f':aria-label="{label}"', f':title="{label}"']),
    )


def color_picker(entry: str) -> None:
    """A swatch that opens Vuetify's picker, and the linear numbers under it."""
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
                flat=True,
                color=(shown,),
                **found_by(
                    "swatch",
                    raw=[f":aria-label=\"{entry}.label + ' colour ' + {shown}\"", f':title="{entry}.help"'],
                ),
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
            with html.Div(classes="px-3 pb-3"):
                _color_numbers(entry)


def color_text(entry: str) -> None:
    """A colour's hex string, or name."""
    v.VTextField(
        key=(f"{entry}.key + 'text' + refusals",),
        model_value=(f"local[{entry}.key] ?? {entry}.hex",),
        classes="studio-hex",
        change=f"trigger('edit', [{entry}.key, $event.target.value])",
        **DENSE,
        raw_attrs=[f":aria-label=\"{entry}.label + ' colour, as #rrggbb or a name'\"", f':title="{entry}.help"'],
    )


def _color_numbers(entry: str) -> None:
    """Red, green and blue as linear numbers, which may be above 1."""
    with html.Div(style="display: flex; gap: 6px"):
        v.VTextField(
            v_for=f"(channel, k) in {entry}.value",
            key=(f"{entry}.key + k + refusals",),
            model_value=(_NUMBER.format("channel"),),
            label=("['red', 'green', 'blue'][k]",),
            type="number",
            step="any",
            change=f"trigger('edit', [{entry}.key, $event.target.value, [k]])",
            **DENSE,
        )


def number_input(entry: str, name: str = "", label: str = "") -> None:
    """A number: digits with the unit, and a slider where there are ends; by default its label is the field's."""
    called = f"'{label}'" if label else f"{entry}.label"
    moved = f"local[{entry}.key]"
    value = f"({moved} === undefined ? {entry}.value : {entry}.stops ? 2 ** {moved} : {moved})"
    with html.Div(classes="studio-row", **found_by(name or "number", raw=[f':title="{entry}.help"'])):
        v.VTextField(
            key=(f"{entry}.key + refusals",),
            model_value=(f"{value} == null ? '' : " + _NUMBER.format(value),),
            label=(f"{called} + ({entry}.unit.length > 2 ? ', ' + {entry}.unit : '')",),
            suffix=(f"{entry}.unit.length > 2 ? '' : {entry}.unit",),
            type="number",
            step="any",
            classes="studio-number",
            change=f"trigger('edit', [{entry}.key, $event.target.value === '' ? null : $event.target.value])",
            **DENSE,
        )
        v.VSlider(
            v_if=f"{entry}.to !== undefined",
            model_value=(f"{moved} ?? {entry}.slide",),
            min=(f"{entry}.from",),
            max=(f"{entry}.to",),
            step=(f"{entry}.step",),
            density="compact",
            hide_details=True,
            thumb_size=14,
            track_size=3,
            color="primary",
            update_modelValue=(f"{moved} = $event; flushState('local'); trigger('slide', [{entry}.key, $event])"),
            end=f"trigger('settle').then(() => {{ delete {moved}; flushState('local') }})",
            raw_attrs=[f":aria-label=\"{called} + ', slider'\""],
        )


def form(entries: str) -> None:
    """An input for each of some fields, as its kind needs it."""
    with html.Div(v_for=f"field in {entries}", key=("field.key",), raw_attrs=[':data-field="field.name"']):
        with html.Div(v_if="field.map", classes="studio-row", raw_attrs=[':title="field.help"']):
            html.Span("{{ field.label }}", classes="studio-label")
            v.VChip("{{ field.map }}", size="small", prepend_icon="mdi-texture")
            v.VBtn(
                "white",
                v_if="field.takes == 'image'",
                size="x-small",
                variant="text",
                click="trigger('edit', [field.key, '#ffffff'])",
            )
        with html.Div(v_else_if="field.kind == 'number'"):
            number_input("field")
        with html.Div(v_else_if="field.kind == 'numbers'"):
            html.Div(
                "{{ field.label }} <span class='studio-unit'>{{ field.unit }}</span>",
                classes="text-caption mt-2",
                raw_attrs=[':title="field.help"'],
            )
            with html.Div(style="display: flex; gap: 6px", classes="mt-1"):
                _coordinate("(number, k) in field.value", "field.key + k", "[k]", "field.labels[k]")
        with html.Div(v_else_if="field.kind == 'points'"):
            html.Div(
                "{{ field.label }} <span class='studio-unit'>{{ field.unit }}</span>",
                classes="text-caption mt-2",
                raw_attrs=[':title="field.help"'],
            )
            with html.Div(
                v_for="(point, row) in field.value", key=("row",), style="display: flex; gap: 6px", classes="mt-1"
            ):
                _coordinate(
                    "(number, k) in point",
                    "field.key + row + '.' + k",
                    "[row, k]",
                    "field.labels[k] + ' of ' + (row + 1)",
                )
        with html.Div(v_else_if="field.kind == 'color'", classes="studio-row", raw_attrs=[':title="field.help"']):
            html.Span("{{ field.label }}", classes="studio-label")
            with html.Div(v_if="field.set", style="display: flex; gap: 4px"):
                color_picker("field")
                color_text("field")
            v.VChip("as diffuse", v_if="!field.set", size="small")
            v.VSpacer()
            v.VBtn(
                "{{ field.set ? 'as diffuse' : 'own' }}",
                v_if="field.optional",
                size="x-small",
                variant="text",
                click="trigger('edit', [field.key, field.set ? null : '#ffffff'])",
            )
            file_input("sky", "image", v_if="field.takes == 'image'", more=" + '&light=' + field.key.split('.')[1]")
        with html.Div(v_else_if="field.kind == 'flag'", classes="studio-row", raw_attrs=[':title="field.help"']):
            v.VSwitch(
                key=("field.key + field.value + refusals",),
                model_value=("field.value",),
                label=("field.label",),
                density="compact",
                hide_details=True,
                color="primary",
                inset=True,
                update_modelValue="trigger('edit', [field.key, $event])",
            )
            v.VTextField(
                v_if="field.takes == 'number' && field.value",
                key=("field.key + 'number' + refusals",),
                model_value=("field.number ?? ''",),
                label="within, mesh unit",
                placeholder="any distance",
                type="number",
                step="any",
                persistent_placeholder=True,
                change="trigger('edit', [field.key, $event.target.value === '' ? true : Number($event.target.value)])",
                **DENSE,
            )
        v.VSelect(
            v_else_if="field.kind == 'choice'",
            classes="mt-3",
            model_value=("field.value",),
            items=("field.choices",),
            label=("field.label",),
            update_modelValue="trigger('edit', [field.key, $event])",
            raw_attrs=[':title="field.help"'],
            **DENSE,
        )


def _coordinate(each: str, key: str, index: str, label: str) -> None:
    v.VTextField(
        v_for=each,
        key=(f"{key} + refusals",),
        model_value=(_NUMBER.format("number"),),
        label=(label,),
        type="number",
        step="any",
        change=f"trigger('edit', [field.key, $event.target.value, {index}])",
        **DENSE,
    )


def file_input(what: str, label: str, *, name: str = "", more: str = "", **attributes: Any) -> None:
    """An input for a file, which is sent by HTTP when it has been chosen."""
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
        **DENSE,
        **attributes,
        **found_by(f"upload-{name or what}"),
    )
