"""Reports for people: lines and tables that fit a terminal, and tables for notebooks."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import fields
from html import escape
from typing import Any

WIDTH = 80
"""Columns that reports keep to."""


def wrapped(sentence: str) -> list[str]:
    """A sentence in lines that fit, those after the first indented by two more than it is; no word is broken."""
    indent = sentence[: len(sentence) - len(sentence.lstrip())]
    return textwrap.wrap(
        sentence, WIDTH, subsequent_indent=f"{indent}  ", break_long_words=False, break_on_hyphens=False
    )


def rendered(parts: Iterable[Any]) -> str:
    """Sentences and `rich` tables as lines that fit; a table is followed by an empty line."""
    from rich.console import Console

    lines: list[str] = []
    for part in parts:
        if isinstance(part, str):
            lines += wrapped(part) or [""]
            continue
        shown = io.StringIO()
        Console(file=shown, width=WIDTH, color_system=None, markup=False, emoji=False, highlight=False).print(part)
        lines += [line.rstrip() for line in shown.getvalue().rstrip().splitlines()]
        lines.append("")
    return "\n".join(lines).rstrip("\n")


def told(value: Any, without: Sequence[str] = ()) -> str:
    """The fields of a dataclass that are not at their defaults: their names and values."""
    shown = {field.name: (getattr(value, field.name), field.default) for field in fields(value)}
    return ", ".join(
        f"{name} {entry}" for name, (entry, default) in shown.items() if entry != default and name not in without
    )


def html_table(title: str, headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A small table for a notebook; all text is escaped. Without headings it has no head."""
    head = _html_row("th", headings) if headings else ""
    body = "\n".join(_html_row("td", row) for row in rows)
    return f"<table>\n<caption>{escape(title)}</caption>\n{head}\n{body}\n</table>"


def _html_row(kind: str, cells: Iterable[str]) -> str:
    inner = "".join(f'<{kind} style="text-align: left">{escape(cell)}</{kind}>' for cell in cells)
    return f"<tr>{inner}</tr>"
