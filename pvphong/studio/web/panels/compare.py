"""The panel of the snapshots, and their comparison in the view: with a movable border, or in turns."""

from __future__ import annotations

from trame.widgets import html
from trame.widgets import vuetify3 as v

from pvphong.studio.web.inputs import found_by, icon_button
from pvphong.studio.web.panels.panel import panel

STYLE = """
.studio-shot { width: 92px; height: 62px; object-fit: cover; border-radius: 3px; background: rgba(128, 128, 128, .2) }
.studio-compare { position: absolute; inset: 0; pointer-events: none }
.studio-compare > img { position: absolute; inset: 0; width: 100%; height: 100%; object-fit: contain }
.studio-compare .studio-wipe { position: absolute; top: 0; bottom: 0; width: 2px; margin-left: -1px; background: white;
  box-shadow: 0 0 3px black }
.studio-compare .studio-side { position: absolute; top: 10px; padding: 1px 9px; border-radius: 3px; color: white;
  background: rgba(0, 0, 0, .7); font-weight: 500 }
.studio-slide { position: absolute; left: 50%; bottom: 26px; width: min(420px, 80%); transform: translateX(-50%);
  pointer-events: auto }
.studio-flicker { animation: studio-flicker 1.6s steps(1) infinite }
@keyframes studio-flicker { 50% { visibility: hidden } }
"""

OWN = {"compare": "", "pair": "", "wipe": 50}
"""State that each browser has for itself. `compare` is "wipe", "flicker" or "", `pair` the compared pair, `wipe` the
border in per cent."""

_PAIR = "(snapshots.pairs.includes(pair) ? pair : snapshots.pairs[0])"
_LEFT, _RIGHT = f"{_PAIR}.split(' | ')[0]", f"{_PAIR}.split(' | ')[1]"
_IS_ON = "compare && snapshots.pairs.length"


def compare() -> None:
    """Add the snapshots, and buttons to keep, restore and compare them."""
    with panel("Compare", "snapshots of light and material"):
        with html.Div(classes="studio-buttons"):
            v.VBtn(
                "Keep a snapshot",
                prepend_icon="mdi-camera-plus-outline",
                disabled=("!has_mesh",),
                click="trigger('snapshot')",
                title="Keep lights, materials, scene and picture as A or B",
                **found_by("snapshot"),
            )
            v.VBtn(
                "{{ compare ? 'End comparing' : 'Compare' }}",
                prepend_icon="mdi-compare",
                disabled=("!snapshots.pairs.length",),
                color=(f"{_IS_ON} ? 'primary' : undefined",),
                click="compare = compare ? '' : 'wipe'",
                title="Compare two pictures in the view",
                raw_attrs=['data-test="compare"', ':aria-pressed="!!compare"'],
            )
        with html.Div(
            v_for="shot in snapshots.list",
            key=("shot.url",),
            classes="studio-row",
            **found_by("snapshot-row", ("'Snapshot ' + shot.name",)),
        ):
            html.Img(src=("shot.url",), classes="studio-shot", alt="")
            with html.Div(style="flex: 1; min-width: 0"):
                html.Div(
                    "{{ shot.name }}: {{ shot.about }}", classes="text-body-2 text-truncate", title=("shot.about",)
                )
                with html.Div(classes="studio-buttons mt-1"):
                    restore = "trigger('restore_snapshot', [shot.name])"
                    v.VBtn(
                        "Restore", click=restore, title="Set everything as it was; undo reverts it", **_of("restore")
                    )
                    look = "trigger('look_from_snapshot', [shot.name])"
                    v.VBtn("Camera", v_if="shot.moved", click=look, title="Look from where it was", **_of("camera"))
            icon_button("mdi-refresh", "replace", "Replace by the present state", "trigger('snapshot', [shot.name])")
            icon_button("mdi-close", "forget", "Delete the snapshot", "trigger('forget_snapshot', [shot.name])")
        with html.Div(v_if=_IS_ON, classes="studio-row"):
            for state, values, name in (
                ("pair", "snapshots.pairs", "compare-pair"),
                ("compare", "['wipe', 'flicker']", "compare-mode"),
            ):
                chosen = _PAIR if state == "pair" else "compare"
                with v.VBtnToggle(
                    model_value=(chosen,),
                    update_modelValue=f"{state} = $event",
                    mandatory=True,
                    density="compact",
                    variant="outlined",
                    divided=True,
                    **found_by(name, "What is compared" if state == "pair" else "Way of comparing"),
                ):
                    v.VBtn("{{ each }}", v_for=f"each in {values}", key=("each",), value=("each",))


def _of(what: str) -> dict[str, object]:
    return found_by(f"snapshot-{what}", (f"'{what.capitalize()} ' + shot.name",))


def over_view() -> None:
    """Add the pictures that are compared, over the view. The live view is visible where there is no picture."""
    with html.Div(v_if=_IS_ON, classes="studio-compare", **found_by("comparison")):
        html.Img(v_if=f"snapshots.urls[{_RIGHT}]", src=(f"snapshots.urls[{_RIGHT}]",), alt=(f"'Snapshot ' + {_RIGHT}",))
        html.Img(
            src=(f"snapshots.urls[{_LEFT}]",),
            alt=(f"'Snapshot ' + {_LEFT}",),
            classes=("compare == 'flicker' ? 'studio-flicker' : ''",),
            style=("compare == 'wipe' ? { clipPath: 'inset(0 ' + (100 - wipe) + '% 0 0)' } : {}",),
        )
        with v.Template(v_if="compare == 'wipe'"):
            html.Div(classes="studio-wipe", style=("{ left: wipe + '%' }",))
            html.Span(f"{{{{ {_LEFT} }}}}", classes="studio-side", style="left: 10px")
            html.Span(f"{{{{ {_RIGHT} }}}}", classes="studio-side", style="right: 10px")
            with html.Div(classes="studio-slide"):
                v.VSlider(
                    v_model=("wipe",),
                    min=0,
                    max=100,
                    step=1,
                    hide_details=True,
                    color="primary",
                    **found_by("wipe", "Wipe"),
                )
        with v.Template(v_if="compare == 'flicker'"):
            html.Span(f"{{{{ {_RIGHT} }}}}", classes="studio-side", style="left: 10px")
            html.Span(f"{{{{ {_LEFT} }}}}", classes="studio-side studio-flicker", style="left: 10px")
