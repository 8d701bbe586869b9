"""Buttons for the stage under the meshes, in the panel of the scene."""

from __future__ import annotations

from typing import get_args

from trame.widgets import html
from trame.widgets import vuetify3 as v

from pvphong.meshes.stages import Stage
from pvphong.studio.web.inputs import found_by, icon_button

_TIPS = {
    "backdrop": "A floor that bends up into a wall behind the model, opposite to the camera",
    "ground": "A flat floor",
    "plinth": "A round pedestal on a floor",
}


def stage() -> None:
    """Add a button for each stage, which adds or removes it, and one that turns the backdrop towards the camera."""
    with html.Div(classes="studio-row mt-0", **found_by("", "Stage under the model")):
        html.Span("stage", classes="studio-label", style="flex-basis: 44px")
        for kind in get_args(Stage):
            is_on = f"stage == '{kind}'"
            v.VBtn(
                kind,
                color=(f"{is_on} ? 'primary' : undefined",),
                disabled=("!has_mesh",),
                click=f"trigger('set_stage', [{is_on} ? '' : '{kind}'])",
                title=_TIPS[kind],
                raw_attrs=[*found_by(f"stage-{kind}", f"Stage: {kind}")["raw_attrs"], f':aria-pressed="{is_on}"'],
            )
        icon_button(
            "mdi-rotate-3d-variant",
            "stage-turn",
            "Turn the wall of the backdrop away from the camera",
            "trigger('set_stage', ['backdrop'])",
            v_if="stage == 'backdrop'",
        )
    html.Div(
        "The stage has a material of its own, below Material. It is in pictures and in the script; files of meshes"
        " leave it out.",
        v_if="stage",
        classes="studio-unit mt-1",
    )
