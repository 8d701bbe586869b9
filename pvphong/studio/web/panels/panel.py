"""A panel of the page: a heading that unfolds its inputs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from trame.widgets import html
from trame.widgets import vuetify3 as v


@contextmanager
def panel(title: str, note: str = "") -> Iterator[None]:
    """Return a context whose elements are inputs of a new panel."""
    with v.VExpansionPanel(eager=True, id=f"panel-{title.lower()}"):
        with html.H2(classes="studio-heading"), v.VExpansionPanelTitle(title):
            if note:
                html.Span(note, classes="studio-unit ml-2")
        with v.VExpansionPanelText():
            yield
