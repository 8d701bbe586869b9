"""Errors in VTK's callbacks fail tests."""

from __future__ import annotations

import sys
from collections.abc import Iterator

import pytest


@pytest.fixture(autouse=True)
def _errors_in_callbacks(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """What is raised in an observer VTK shows by `sys.excepthook`, and goes on."""
    raised: list[BaseException] = []
    monkeypatch.setattr(sys, "excepthook", lambda _kind, error, _trace: raised.append(error))
    yield
    for error in raised:
        raise error
