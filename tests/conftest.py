"""Errors in VTK's callbacks fail tests; plotters are closed after each."""

from __future__ import annotations

import contextlib
import gc
import sys
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import pyvista as pv

from pvphong.shading import kernel


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes() -> None:
    """Compile before several processes run tests: they share the code, and no test has to wait for it."""
    with contextlib.suppress(kernel.CannotCompile):
        kernel.compile_all(lambda *_: None)


def pytest_collection_finish() -> None:
    """Exclude the ten thousand collected tests from garbage collection."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def _errors_in_callbacks(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Fail for exceptions in observers, which VTK only passes to `sys.excepthook`."""
    raised: list[BaseException] = []
    monkeypatch.setattr(sys, "excepthook", lambda _kind, error, _trace: raised.append(error))
    yield
    for error in raised:
        raise error


@pytest.fixture
def new_plotter() -> Iterator[Callable[..., pv.Plotter]]:
    """Return a function that makes off-screen plotters without lights."""
    made: list[pv.Plotter] = []

    def make(size: tuple[int, int] = (48, 48), lighting: str = "none", **options: Any) -> pv.Plotter:
        made.append(pv.Plotter(off_screen=True, window_size=size, lighting=lighting, **options))
        return made[-1]

    yield make
    for each in made:
        each.close()
