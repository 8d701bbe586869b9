"""Sphinx directive `fields`: a table of the fields of some dataclasses, from their docstrings and defaults."""

from __future__ import annotations

from dataclasses import MISSING, fields
from typing import Any

from docutils import nodes
from numpydoc.docscrape import ClassDoc
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

import pvphong as ph

COMMON = {field.name for field in fields(ph.Light)}
"""Fields of every light, which stand once."""


def rows_of(kind: type) -> list[tuple[str, str, str]]:
    """Name, default and description of each field of a dataclass; KeyError if its docstring lacks one."""
    told = {each.name: " ".join(each.desc).replace("|", "\\|") for each in ClassDoc(kind)["Parameters"]}
    shared = COMMON if issubclass(kind, ph.Light) and kind is not ph.Light else set()
    own = [field for field in fields(kind) if field.name not in shared]  # type: ignore[arg-type]
    return [(f"`{field.name}`", default_of(field.default), told[field.name]) for field in own]


def default_of(value: Any) -> str:
    """A default as a reader would type it."""
    if value is MISSING:
        return "required"
    if value is None:
        return "none"
    return f"`{value!r}`"


class Fields(SphinxDirective):
    """Tables of the fields of classes in `pvphong`."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        """Return a table with a row for each field."""
        kinds = [getattr(ph, name) for name in self.arguments[0].split()]
        header = ("field", "default", "meaning")
        rows = [header, ("---",) * 3, *(row for kind in kinds for row in rows_of(kind))]
        if len(kinds) > 1:
            classes = [f"`{kind.__name__}`" * (number == 0) for kind in kinds for number, _ in enumerate(rows_of(kind))]
            rows = [(first, *row) for first, row in zip(["class", "---", *classes], rows, strict=True)]
        lines = ["| " + " | ".join(row) + " |" for row in rows]
        return self.parse_text_to_nodes("\n".join(lines))


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("fields", Fields)
    return {"parallel_read_safe": True}
