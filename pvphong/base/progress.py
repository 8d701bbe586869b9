"""How far long work has come, for whoever listens.

Who begins the work says what it is (`about`), who divides it counts what is done (`counting`), and who waits for it
listens (`listening`); none of them knows the others, and where nobody listens nothing is counted.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Listener = Callable[[str, float], object]
"""Told what is being done, and which part of it is, in [0, 1]; by any thread, but by one at a time."""

_listener: ContextVar[Listener | None] = ContextVar("listener", default=None)
_subject: ContextVar[str] = ContextVar("subject", default="")


@contextmanager
def listening(listener: Listener) -> Iterator[None]:
    """Tell a listener of all work that is done meanwhile."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)


@contextmanager
def about(what: str) -> Iterator[None]:
    """Say what the work is that is counted meanwhile; work without a name is not told of."""
    token = _subject.set(what)
    try:
        yield
    finally:
        _subject.reset(token)


def counting(whole: int) -> Callable[[int], None]:
    """What to call with each count of so many pieces of work that are done, from any thread."""
    listener, what = _listener.get(), _subject.get()
    if listener is None or not what:
        return lambda _: None
    lock, done = threading.Lock(), 0

    def count(more: int) -> None:
        nonlocal done
        with lock:
            done += more
            listener(what, done / whole)

    return count
