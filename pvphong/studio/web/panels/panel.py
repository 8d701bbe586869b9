"""A panel of the page: a heading that unfolds its inputs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from trame.widgets import html
from trame.widgets import vuetify3 as v

from pvphong.studio.web.inputs import found_by


@contextmanager
def panel(title: str, note: str = "", *, found: str = "") -> Iterator[None]:
    """Return a context whose elements are inputs of a new panel.

    `title` is the panel's heading, `note` a short text next to it, and `found` the heading's name for tests.
    """
    with v.VExpansionPanel(eager=True, id=f"panel-{title.lower()}"):
        with html.H2(classes="studio-heading"), v.VExpansionPanelTitle(title, **found_by(found)):
            if note:
                html.Span(note, classes="studio-unit ml-2")
        with v.VExpansionPanelText():
            yield
