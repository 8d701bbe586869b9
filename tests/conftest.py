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
    """Before several processes run tests: they share code that would else be compiled while tests wait."""
    with contextlib.suppress(kernel.CannotCompile):
        kernel.compile_all(lambda *_: None)


def pytest_collection_finish() -> None:
    """Keep the garbage collector from looking through ten thousand collected tests each time."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def _errors_in_callbacks(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """What is raised in an observer VTK shows by `sys.excepthook`, and goes on."""
    raised: list[BaseException] = []
    monkeypatch.setattr(sys, "excepthook", lambda _kind, error, _trace: raised.append(error))
    yield
    for error in raised:
        raise error


@pytest.fixture
def new_plotter() -> Iterator[Callable[..., pv.Plotter]]:
    """Makes plotters without lights, off screen."""
    made: list[pv.Plotter] = []

    def make(size: tuple[int, int] = (48, 48), lighting: str = "none", **options: Any) -> pv.Plotter:
        made.append(pv.Plotter(off_screen=True, window_size=size, lighting=lighting, **options))
        return made[-1]

    yield make
    for each in made:
        each.close()
