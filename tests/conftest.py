"""Errors in VTK's callbacks fail tests; plotters are closed after each and draw one sample for each pixel."""

from __future__ import annotations

import contextlib
import gc
import sys
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import pyvista as pv
from browsers import new_browser

from pvphong.shading import kernel


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes() -> None:
    """Compile before several processes run tests: they share the code, and no test has to wait for it."""
    with contextlib.suppress(kernel.CannotCompile):
        kernel.compile_all(lambda *_: None)


_LONGEST = (
    *("test_stage_in_a_browser", "test_placing_in_a_browser"),
    *("test_docstrings", "test_manual", "test_examples", "test_first_use", "test_faults", "test_over_and_over"),
    *("test_refine_far_away", "test_refine", "test_refine_shadows", "test_refusals", "test_commands", "test_sides"),
)
"""Files whose tests take long. They run first, with those in browsers, so that several processes end together."""


pv.global_theme.multi_samples = 1  # more take a processor twice as long, and images are compared with each other


def pytest_configure(config: pytest.Config) -> None:
    """Have pytest-xdist distribute files in their order. Its own order begins with the files that have most tests."""
    if hasattr(config.option, "loadscopereorder"):
        config.option.loadscopereorder = False


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with what takes longest."""
    items.sort(key=lambda item: not item.path.stem.endswith("in_a_browser") and item.path.stem not in _LONGEST)


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


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """One browser for all files, because its start takes seconds."""
    browser = new_browser(tmp_path_factory.mktemp("profile"))
    yield browser
    browser.quit()


@pytest.fixture(scope="module")
def driver(browser: Any) -> Iterator[Any]:
    """The browser, without what the file before has left."""
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    browser.get("about:blank")
    browser.get_log("browser")
    yield browser
    browser.get("about:blank")
    assert len(browser.window_handles) == 1
