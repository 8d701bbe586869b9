"""Threads for work that holds no lock of the interpreter's: compiled code, rays, NumPy on large arrays.

Work comes in ranges, more and smaller ones than there are threads, and each thread takes the next when it is done
with one: where other programs keep the cores busy, none waits for another for long. The calling thread takes part.
"""

from __future__ import annotations

import contextlib
import functools
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextvars import ContextVar
from typing import Any

from pvphong.base import text

_limit: ContextVar[int] = ContextVar("limit", default=sys.maxsize)
_stop: ContextVar[threading.Event | None] = ContextVar("stop", default=None)


class StoppedError(Exception):
    """Work was told to stop, for nobody wants its result any more."""


@contextlib.contextmanager
def stopped_by(event: threading.Event) -> Iterator[None]:
    """While it lasts, `run` and `go_on` raise `StoppedError` in the calling thread as soon as the event is set."""
    token = _stop.set(event)
    try:
        yield
    finally:
        _stop.reset(token)


def go_on() -> None:
    """Raise `StoppedError` if the calling thread was told to stop, or helps with ranges of which one has failed."""
    event = _stop.get()
    if event is not None and event.is_set():
        raise StoppedError


def count() -> int:
    """Threads that work at once: Numba's setting, but no more than the processors that this process may use now."""
    config = getattr(sys.modules.get("numba"), "config", None)  # rays are cast without it; or it is being imported
    setting = os.environ.get("NUMBA_NUM_THREADS", sys.maxsize) if config is None else config.NUMBA_NUM_THREADS
    return max(1, min(int(setting), _processors(os.getpid(), int(time.monotonic())), _limit.get()))


@functools.lru_cache(maxsize=1)
def _processors(_process: int, _second: int) -> int:
    """Those that this process may use; read once a second, for that takes some 40 µs."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextlib.contextmanager
def limited(threads: int) -> Iterator[None]:
    """While it lasts, no more threads work at once for the calling thread: 1 where others share out the work."""
    token = _limit.set(threads)
    try:
        yield
    finally:
        _limit.reset(token)


@functools.lru_cache(maxsize=1)
def _executor(_process: int) -> ThreadPoolExecutor:
    """A process has its own, for threads do not survive a fork. It starts threads as it needs them, and keeps them."""
    return ThreadPoolExecutor(max_workers=2 * (os.cpu_count() or 1), thread_name_prefix="pvphong")


# Seconds of work for which another thread is woken: that takes 0.05 to 0.2 ms, and its end is waited for.
_WORTH_WAKING = 3e-4


def run(work: Callable[[int, int], Any], stop: int, step: int, longest: int = 0) -> None:
    """Call `work(first, last)` for all ranges of a length from 0 to `stop`, on no more than `count()` threads at once.

    After an exception in any of them, or where the calling thread is interrupted or told to stop, no other range is
    begun, nor one of work that is divided inside of a range; it is raised when all are done. The progress of that is
    not reported.

    Parameters
    ----------
    work : callable
        What is done for a range.
    stop, step : int
        Where the last range ends, and how long they are.
    longest : int, optional
        If more than a step, work may be shorter than waking a thread. Unless there is so much for each, the calling
        thread begins with a quarter of a step, and others help if the time that it took says that the rest is worth
        it. Then a thread takes its even share of what is left, a step at least and so much at most: ranges are few,
        and the last are short, so that threads end together (guided self-scheduling, Polychronopoulos and Kuck 1987).
    """
    go_on()
    begun, lock, note, has_failed = 0, threading.Lock(), text.counting(stop), threading.Event()
    most = max(1, min(count(), -(-stop // step)))

    def take_ranges() -> None:
        nonlocal begun
        try:
            while True:
                go_on()
                with lock:
                    first = begun
                    last = begun = min(first + max(step, min((stop - first) // most, longest)), stop)
                if first == last:
                    return
                work(first, last)
                note(last - first)
        except BaseException:
            with lock:
                begun = stop
            has_failed.set()
            raise

    def help_out() -> None:
        with contextlib.suppress(StoppedError), stopped_by(has_failed):
            take_ranges()

    if longest > step and most > 1 and stop < most * longest:
        start, begun = time.perf_counter(), step // 4
        work(0, begun)
        note(begun)
        if (time.perf_counter() - start) * (stop / begun - 1.0) < _WORTH_WAKING:
            most = 1
    helpers = [_executor(os.getpid()).submit(help_out) for _ in range(most - 1)]
    try:
        with text.listening(None):
            take_ranges()
    finally:
        for helper in helpers:
            if not helper.cancel():  # one that has not begun has nothing left to do
                helper.result()
