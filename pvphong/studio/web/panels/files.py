"""The panel of files: downloads and uploads."""

from __future__ import annotations

from typing import Any

from trame.widgets import html
from trame.widgets import vuetify3 as v

from pvphong.studio.web.inputs import file_input, found_by, typed, typed_number
from pvphong.studio.web.panels.panel import panel


def files() -> None:
    """Add downloads, the script, and inputs for meshes and rigs."""
    with panel("Files"):
        html.H3("Save", classes="text-caption")
        with html.Div(classes="studio-buttons mt-1"):
            single = "mesh_count < 2"
            _take("rig", "rig", "Lights, viewer, light model and materials as .json, for pvphong --scene")
            _take("vtp", "mesh .vtp", "The lit mesh without the stage, with float colours", v_if=single)
            _take("ply", "mesh .ply", "The lit mesh without the stage, with 8-bit colours", v_if=single)
            _take("vtkhdf", "blocks .vtkhdf", "The lit meshes as blocks, with float colours", v_if="mesh_count > 1")
            _take("glb", "glTF", "The lit mesh with its colours as .glb, for other programs")
            _take("py", "Python", "The script below, as a file")
        with html.Div(classes="studio-row", style="flex-wrap: wrap"):
            for side in ("width", "height"):
                typed_number(side, "px", classes="studio-size", found=f"picture-{side}")
            width, height = (f"encodeURIComponent({typed(side)})" for side in ("width", "height"))
            size = f"?width=' + {width} + '&height=' + {height} + '"
            _take("png", "picture .png", "The view without gizmos, in this size; refined, if the view is", size)
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
            "Another mesh keeps the lights: they are moved and scaled to fit it. Undo shows the mesh before it. A mesh"
            " that is added leaves lights and camera where they are; its material and its name are under Material."
            " Files can also be dropped onto the page.",
            classes="studio-unit",
        )
        open_mesh("mesh")
        with html.Div(v_if="has_mesh", classes="studio-beside"):
            label, more = "Add a mesh beside it", " + '&beside=1'"
            file_input("mesh", label, name="beside", more=more, found="add-mesh")
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


def open_mesh(name: str) -> None:
    """Add buttons for the examples, and a file input for a mesh. `name` is the input's name for tests."""
    with html.Div(classes="studio-buttons mt-1"):
        v.VBtn(
            "{{ name }}",
            v_for="name in example_names",
            key=("name",),
            click="trigger('open_example', [name])",
            raw_attrs=[":data-test=\"'example-' + name\"", ":aria-label=\"'Open the example ' + name\""],
        )
    file_input("mesh", "mesh: .stl .ply .obj .vtp .vtu .vtk .glb …", name=name)
