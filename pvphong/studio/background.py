"""Background work for a window: a thread that reports its progress, and can be paused and stopped."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

from pvphong.base import text, threads

Result = TypeVar("Result")


class Job(Generic[Result]):
    """A task in its own thread, started at once.

    Parameters
    ----------
    name : str
        Name of the thread.
    work : callable
        Function without arguments that returns the result. The data that it uses must not be edited while it runs.
    """

    def __init__(self, name: str, work: Callable[[], Result]) -> None:
        self.result: Result | None = None
        self.reason = ""
        """The error message if the task failed, else ""."""
        self.part = 0.0
        """Progress of the current step, from 0 to 1; 0 if the step does not report any."""
        self._work, self._stop, self._unpaused = work, threading.Event(), threading.Event()
        self._unpaused.set()
        self._thread = threading.Thread(target=self._run, name=f"pvphong {name}", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        def listen(_step: str, part: float) -> None:
            self.part = part

        try:
            with threads.stopped_by(self._stop, self._unpaused), text.listening(listen):
                self.result = self._work()
        except threads.StoppedError:
            pass
        except Exception as error:  # also from a user's light or array; the reader of the result reports it
            self.reason = str(error) or type(error).__name__

    @property
    def is_done(self) -> bool:
        """True if the task has ended."""
        return not self._thread.is_alive()

    def wait(self) -> None:
        """Block until the task has ended."""
        self._thread.join()

    @property
    def is_paused(self) -> bool:
        """True after `pause`, until `go_on`."""
        return not self._unpaused.is_set()

    def pause(self) -> None:
        """Pause the task; it soon uses no processor time."""
        self._unpaused.clear()

    def go_on(self) -> None:
        """Continue a paused task."""
        self._unpaused.set()

    def stop(self) -> None:
        """Cancel the task, even if it is paused. The thread soon ends without a result."""
        self._stop.set()
        self._unpaused.set()
