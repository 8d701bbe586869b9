"""The panel of the picture: exposure, tone curve and overlays."""

from __future__ import annotations

from trame.widgets import vuetify3 as v

from pvphong.studio.web.inputs import form, found_by, number_input, switch
from pvphong.studio.web.panels.histogram import histogram
from pvphong.studio.web.panels.panel import panel


def picture() -> None:
    """Add inputs for exposure, tone curve and overlay, and the histogram. None of them affects downloaded meshes."""
    with panel("Picture", "exposure and tone curve"):
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
        form("backing")
        histogram()
