"""The panel "Advanced": how exact the picture is, what is computed, its error and its cost."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from trame.widgets import html
from trame.widgets import vuetify3 as v

from pvphong.studio.web.inputs import CALLS, found_by, number_input, switch, typed, typed_number
from pvphong.studio.web.panels.panel import panel


def advanced() -> None:
    """Add a sentence on the picture's accuracy with a button that improves it, the plan, and the inputs."""
    with panel("Advanced", "accuracy and plan", found="advanced"):
        html.Div("{{ exactness.text }}", classes="text-body-2", **found_by("exactness", status=True))
        v.VBtn(
            "{{ exactness.label }}",
            v_if="has_mesh",
            color="primary",
            classes="mt-2",
            click=f"{CALLS.format('exactness')}",
            disabled=("report.running",),
            **found_by("improve"),
        )
        _accuracy()
        _plan()


@contextmanager
def _section(title: str) -> Iterator[None]:
    """Return a context whose elements stand under the heading `title` in the panel."""
    with html.Div(classes="mt-4"):
        html.H3(title, classes="text-subtitle-2 mb-1")
        yield


def _plan() -> None:
    """Add the plan's tolerance and its tables of effects, one for each mesh."""
    with _section("Plan: effects that run, and their cost"):
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
    """Add inputs for refined pictures, and the report of accuracy against time."""
    with _section("Accuracy, and its cost in time"):
        with html.Div(classes="studio-row mt-0", title=("accuracy.refine.help",)):
            refine = "trigger('edit', ['accuracy.refine', $event ? 1 / 255 : null])"
            switch("refine", "accuracy.refine.set", "refine the view", refine)
            html.Span("{{ refined }}", classes="studio-unit", **found_by("refined", status=True))
        with html.Div(v_if="accuracy.refine.set"):
            number_input("accuracy.refine", "refine-tolerance", "largest error")
        html.H4("Report", classes="text-caption mt-3")
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
