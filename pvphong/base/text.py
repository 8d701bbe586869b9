"""Text output: lines and tables that fit a terminal, tables for notebooks, and the progress of long work.

Progress has three independent parts: the caller names the work (`about`), the code that divides the work counts the
finished pieces (`counting`), and a listener receives the progress (`listening`). Without a listener nothing is counted.
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
"""Width of reports in columns."""


def wrapped(sentence: str) -> list[str]:
    """Wrap a sentence to lines of `WIDTH` characters, without breaking words.

    The first line keeps its indent; the other lines are indented by two more columns.
    """
    indent = sentence[: len(sentence) - len(sentence.lstrip())]
    return textwrap.wrap(
        sentence, WIDTH, subsequent_indent=f"{indent}  ", break_long_words=False, break_on_hyphens=False
    )


def rendered(parts: Iterable[Any]) -> str:
    """Render sentences and `rich` tables as text, in lines of `WIDTH` characters; an empty line follows each table."""
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
    """Return the fields of a dataclass instance that differ from their defaults, as names and values in one line.

    Fields whose names are in `without` are omitted.
    """
    shown = {field.name: (getattr(value, field.name), field.default) for field in fields(value)}
    return ", ".join(
        f"{name} {entry}" for name, (entry, default) in shown.items() if entry != default and name not in without
    )


def html_table(title: str, headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a small HTML table for a notebook; all text is escaped.

    If `headings` is empty, the table has no header row.
    """
    body = ""
    for kind, cells in [("th", headings)] * bool(headings) + [("td", row) for row in rows]:
        inner = "".join(f'<{kind} style="text-align: left">{escape(cell)}</{kind}>' for cell in cells)
        body += f"<tr>{inner}</tr>\n"
    return f"<table>\n<caption>{escape(title)}</caption>\n{body}</table>"


Listener = Callable[[str, float], object]
"""Function that is called with the name of the work and the fraction done, in [0, 1]. Any thread may call it, but never
two at once."""

_listener: ContextVar[Listener | None] = ContextVar("listener", default=None)
_subject: ContextVar[str] = ContextVar("subject", default="")


@contextmanager
def listening(listener: Listener | None) -> Iterator[None]:
    """Within the block, report the progress of work to `listener`; None switches reports off.

    A listener is a function with two arguments: the name of the work, and the finished fraction.
    """
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)


@contextmanager
def about(what: str) -> Iterator[None]:
    """Name the work in the block for reports of progress, such as "casting rays". Unnamed work is not reported."""
    token = _subject.set(what)
    try:
        yield
    finally:
        _subject.reset(token)


@contextmanager
def stage(what: str, start: float, end: float) -> Iterator[None]:
    """Report the progress of all work in the block as one part of a longer task.

    Parameters
    ----------
    what : str
        Name that the listener receives in place of the names of the work inside.
    start, end : float
        Fractions of the longer task, 0 to 1, at which the block begins and ends. Stages can be nested.
    """
    listener = _listener.get()
    if listener is None:
        yield
        return
    with listening(lambda _, part: listener(what, start + (end - start) * part)):
        listener(what, start)
        yield
    listener(what, end)


def counting(whole: int) -> Callable[[int], None]:
    """Return a function that reports progress to the current listener, for work that consists of `whole` pieces.

    Threads call the function with the number of pieces that they have just finished.
    """
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
