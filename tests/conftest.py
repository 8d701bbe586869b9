"""The stability tests' measurements as a table, at the end of every run that took some."""

from __future__ import annotations

from itertools import groupby
from typing import Any

import pytest
from rich import box
from rich.console import Console
from rich.table import Table
from stability import ledger


def _number(entry: ledger.Entry) -> tuple[int, str]:
    """The catalogue's number of a row, for sorting; rows without one come last."""
    first = entry.row.split()[0]
    digits = first.split("/")[0]
    return (int(digits), first) if digits.isdigit() else (1000, first)


def _table(entries: list[ledger.Entry]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, title="stability: the worst of each row of the catalogue")
    for heading in ("row", "evaluator", "precision", "worst in", "bound", "observed/bound", "measured"):
        table.add_column(heading, justify="right" if heading in ("bound", "observed/bound", "measured") else "left")

    def key(entry: ledger.Entry) -> Any:
        return *_number(entry), entry.evaluator, entry.precision

    for (_, row, evaluator, precision), group in groupby(sorted(entries, key=key), key):
        measured = list(group)
        worst = max(measured, key=lambda entry: entry.ratio)
        bound = f"{worst.bound:.2g}" if worst.bound else "exact"
        table.add_row(row, evaluator, precision, worst.row, bound, f"{worst.ratio:.2f}", f"{len(measured)}")
    return table


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    if ledger.entries:
        console = Console(width=120, color_system=None)
        with console.capture() as table:
            console.print(_table(ledger.entries))
        terminalreporter.write_line(table.get())
