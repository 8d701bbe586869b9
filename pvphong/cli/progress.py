"""What a command shows while it works."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, SpinnerColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text

from pvphong.base.text import listening

_LONG = 1.0
"""Seconds after which work is long enough for a bar."""


@contextmanager
def busy(what: str) -> Iterator[None]:
    """A spinner on the error output, if that is a terminal; with a bar where long work says how far it has come."""
    console, begun = Console(stderr=True), time.perf_counter()
    columns = SpinnerColumn(), TextColumn("{task.description}"), _IfLong(BarColumn()), _IfLong(TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as shown:
        task = shown.add_task(what, total=None)

        def update(doing: str, part: float) -> None:
            if time.perf_counter() - begun > _LONG:
                shown.update(task, description=f"{what}: {doing}", completed=part, total=1.0)

        with listening(update):
            yield


class _IfLong(ProgressColumn):
    """A column that is shown once the end is known."""

    def __init__(self, column: ProgressColumn) -> None:
        super().__init__()
        self._column = column

    def render(self, task: Task) -> Any:
        return Text("") if task.total is None else self._column(task)
