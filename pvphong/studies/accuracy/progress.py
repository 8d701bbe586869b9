"""A progress bar on the error output, if that is a terminal."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from pvphong.studies.accuracy.timing import Clock


@contextmanager
def progress(clock: Clock, what: str) -> Iterator[None]:
    """Shows how much of a clock's budget is spent, and what is being done."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(what, total=1.0)
        clock.report = lambda part, doing: bar.update(task, completed=part, description=f"{what}: {doing}")
        yield
