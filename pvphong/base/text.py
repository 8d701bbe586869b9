"""What people read: lines and tables that fit a terminal, tables for notebooks, and the progress of long work.

Progress has three parties that do not know each other: the caller that names the work (`about`), the code that divides
it and counts (`counting`), and the listener (`listening`). Without a listener nothing is counted.
"""

from __future__ import annotations

import io
import textwrap
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
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


def changed_fields(value: Any, without: Sequence[str] = ()) -> str:
    """Names and values of the fields of a dataclass that differ from their defaults, as one line."""
    shown = {field.name: (getattr(value, field.name), field.default) for field in fields(value)}
    return ", ".join(
        f"{name} {entry}" for name, (entry, default) in shown.items() if entry != default and name not in without
    )


def html_table(title: str, headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A small table for a notebook; all text is escaped. Without headings it has no head."""
    body = ""
    for kind, cells in [("th", headings)] * bool(headings) + [("td", row) for row in rows]:
        inner = "".join(f'<{kind} style="text-align: left">{escape(cell)}</{kind}>' for cell in cells)
        body += f"<tr>{inner}</tr>\n"
    return f"<table>\n<caption>{escape(title)}</caption>\n{body}</table>"


Listener = Callable[[str, float], object]
"""Called with the name of the work and the part of it that is done, in [0, 1]; by any thread, but one at a time."""

_listener: ContextVar[Listener | None] = ContextVar("listener", default=None)
_subject: ContextVar[str] = ContextVar("subject", default="")


@contextmanager
def listening(listener: Listener | None) -> Iterator[None]:
    """Report the progress of all work within the block to a listener, or to nobody."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)


@contextmanager
def about(what: str) -> Iterator[None]:
    """Name the work within the block; work without a name is not reported."""
    token = _subject.set(what)
    try:
        yield
    finally:
        _subject.reset(token)


def counting(whole: int) -> Callable[[int], None]:
    """A function that any thread calls with the number of pieces that it has just done, of `whole` pieces in all."""
    listener, what = _listener.get(), _subject.get()
    if listener is None or not what:
        return lambda _: None
    lock, done = threading.Lock(), 0

    def count(more: int) -> None:
        nonlocal done
        with lock:
            done += more
            listener(what, done / whole)

    return count
