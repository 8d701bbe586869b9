"""What a command shows while it works."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console


@contextmanager
def busy(what: str) -> Iterator[None]:
    """A spinner on the error output, if that is a terminal."""
    with Console(stderr=True).status(what):
        yield
