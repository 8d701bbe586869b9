"""The panel of materials: the meshes by name, and preset, reflectance, colours, colormap and textures of each one."""

from __future__ import annotations

from trame.widgets import html
from trame.widgets import vuetify3 as v

from pvphong.studio.web.inputs import SIX_DIGITS, file_input, form, found_by, icon_button, number_input
from pvphong.studio.web.panels.panel import panel

OWN = {"chosen_mesh": ""}
"""State of each browser: the name of the mesh whose material is shown; "" shows all materials."""

_CHOSEN = "(materials.some((each) => each.name == chosen_mesh) ? chosen_mesh : '')"


def materials() -> None:
    """Add the meshes, inputs for their materials, and for sharp edges."""
    with panel("Material"):
        html.Div("No mesh is open.", v_if="!has_mesh", classes="studio-unit")
        _meshes()
        _chooser()
        of_each = html.Div(v_for="material in materials", key=("material.number",))
        with of_each, html.Div(v_if=f"{_CHOSEN} == '' || {_CHOSEN} == material.name"):
            _material()
        with html.Div(v_if="has_mesh", classes="mt-2"):
            number_input("surfaces[0]", "feature-angle", "sharp edges from, °")


def _meshes() -> None:
    """Add a row for each file if several are shown: its name, its number of points, and a button that removes it."""
    with html.Div(
        v_for="part in (parts.length > 1 ? parts : [])",
        key=("part.number",),
        classes="studio-row",
        **found_by("mesh-row", ("'Mesh ' + part.name",)),
    ):
        v.VTextField(
            key=("part.number + part.name + refusals",),
            model_value=("part.name",),
            label=("part.points.toLocaleString('en') + ' points'",),
            change="trigger('rename_mesh', [part.number, $event.target.value])",
            **found_by("mesh-name", ("'Name of the mesh ' + part.name",)),
        )
        icon_button("mdi-delete-outline", "remove-mesh", "Remove the mesh", "trigger('remove_mesh', [part.number])")


def _chooser() -> None:
    """Add a list that shows the material of one mesh, or all materials."""
    v.VSelect(
        v_if="materials.length > 1",
        model_value=(_CHOSEN,),
        items=("[{ value: '', title: 'all' }, ...materials.map(({ name }) => ({ value: name, title: name }))]",),
        label="material of",
        classes="mt-3",
        update_modelValue="chosen_mesh = $event",
        **found_by("material-of", "Mesh whose material is shown"),
    )


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
    """Add the thumbnail of a lit sphere to each entry of a list. `kind` is "material" or "reflectance"."""
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
