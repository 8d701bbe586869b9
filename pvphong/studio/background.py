"""Work in a thread beside a window: it says how far it has come, and can be stopped."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

from pvphong.base import text, threads

Result = TypeVar("Result")


class Job(Generic[Result]):
    """Work that runs in a thread of its own, from now on.

    Parameters
    ----------
    name : str
        Of the thread.
    work : callable
        Gives the result, of nothing that anybody else may edit meanwhile.
    """

    def __init__(self, name: str, work: Callable[[], Result]) -> None:
        self.result: Result | None = None
        self.reason = ""
        """Why there is none, if it failed."""
        self.part = 0.0
        """How much is done of the step that it is at, from 0 to 1; 0 where nothing counts that."""
        self._work, self._stop = work, threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"pvphong {name}", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        def listen(_step: str, part: float) -> None:
            self.part = part

        try:
            with threads.stopped_by(self._stop), text.listening(listen):
                self.result = self._work()
        except threads.StoppedError:
            pass
        except Exception as error:  # of a light or an array of the user's, too: said by who asks for the result
            self.reason = str(error) or type(error).__name__

    @property
    def is_done(self) -> bool:
        """Whether it has ended."""
        return not self._thread.is_alive()

    def wait(self) -> None:
        """Until it has ended."""
        self._thread.join()

    def stop(self) -> None:
        """Have it end soon, without a result."""
        self._stop.set()
