"""Errors in VTK's callbacks fail tests; the stability tests' measurements are a table at the end of a run."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import astuple
from itertools import groupby
from typing import Any

import pytest
from rich import box
from rich.console import Console
from rich.table import Table
from stability import ledger


@pytest.fixture(autouse=True)
def _errors_in_callbacks(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """What is raised in an observer VTK shows by `sys.excepthook`, and goes on."""
    raised: list[BaseException] = []
    monkeypatch.setattr(sys, "excepthook", lambda _kind, error, _trace: raised.append(error))
    yield
    for error in raised:
        raise error


def _number(entry: ledger.Entry) -> tuple[int, str]:
    """The catalogue's number of a row, for sorting; rows without one come last."""
    first = entry.row.split()[0]
    digits = first.split("/")[0]
    return (int(digits), first) if digits.isdigit() else (1000, first)


def _ratio(entry: ledger.Entry) -> float:
    """Observed / bound, for comparing; a promise that was kept is below every measurement."""
    return -1.0 if entry.ratio is None else entry.ratio


def _cells(group: list[ledger.Entry]) -> tuple[str, ...]:
    """One line of the table: the worst of some measurements, or of tests of one promise."""
    worst = max(group, key=_ratio)
    bound = worst.bound if isinstance(worst.bound, str) else f"{worst.bound:.2g}" if worst.bound else "exact"
    ratio = "held" if worst.ratio is None else f"{worst.ratio:.2f}"
    return worst.row, worst.evaluator, worst.precision, bound, ratio, f"{len(group)}"


def _table(entries: list[ledger.Entry]) -> Table:
    title = "stability: observed / bound, the worst of each row"
    table = Table(box=box.SIMPLE_HEAD, title=title, pad_edge=False, padding=(0, 1, 0, 0))
    for heading in ("row", "evaluator", "precision", "bound", "ratio", "times"):
        right = heading in ("bound", "ratio", "times")
        table.add_column(heading, justify="right" if right else "left", overflow="fold")

    def key(entry: ledger.Entry) -> Any:
        promise = entry.bound if isinstance(entry.bound, str) else ""
        return *_number(entry), entry.evaluator, entry.precision, promise

    for _, group in groupby(sorted(entries, key=key), key):
        table.add_row(*_cells(list(group)))
    return table


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Where several processes share the tests, each hands over what it measured."""
    output = getattr(session.config, "workeroutput", None)
    if output is not None:
        output["ledger"] = [astuple(entry) for entry in ledger.entries]


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any) -> None:
    """A process of pytest-xdist has ended."""
    ledger.entries += [ledger.Entry(*values) for values in getattr(node, "workeroutput", {}).get("ledger", ())]


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    if ledger.entries:
        console = Console(width=90, color_system=None)
        with console.capture() as table:
            console.print(_table(ledger.entries))
        terminalreporter.write_line(table.get())
