"""How commands print what they found: a few plain lines, or all of it."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import Protocol

from pvphong.cli.inputs import NOTHING


class Report(Protocol):
    """What a study gives: its text is a few lines."""

    def explain(self) -> str:
        """All of it."""


def tell(reports: Iterable[tuple[str, Report]], verbose: bool) -> None:
    """Print reports, each after the name of its block, if it has one."""
    reports = list(reports)
    for block, report in reports:
        if block:
            print(f"{block}:")
        print(report.explain().rstrip() if verbose else report)
    if not reports:
        print(NOTHING)
    elif not verbose and sys.stdout.isatty():
        print("(--verbose tells all of it.)", file=sys.stderr)
