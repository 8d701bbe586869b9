"""Threads for work that releases the interpreter lock: compiled code, rays, NumPy on large arrays.

Work is divided into more ranges than threads, and a thread that has finished a range takes the next one. So no thread
waits long for another, even when other programs use the cores. The calling thread takes part.
"""

from __future__ import annotations

import contextlib
import functools
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextvars import ContextVar
from typing import Any, TypeAlias

from pvphong.base import text

Range: TypeAlias = tuple[int, int]
"""Range of items: the number of the first item, and the number of the item after the last."""

_limit: ContextVar[int] = ContextVar("limit", default=sys.maxsize)
_stop: ContextVar[threading.Event | None] = ContextVar("stop", default=None)
_unpaused: ContextVar[threading.Event | None] = ContextVar("unpaused", default=None)


class StoppedError(Exception):
    """Raised in work that has been cancelled, by setting the event of `stopped_by`."""


@contextlib.contextmanager
def stopped_by(event: threading.Event, unpaused: threading.Event | None = None) -> Iterator[None]:
    """Make the work in the block cancellable: once `event` is set, `run` and `go_on` raise `StoppedError`.

    `unpaused` makes the work pausable too: `run` and `go_on` wait while this event is not set. To cancel paused work,
    set `event` and then `unpaused`.
    """
    token, pause = _stop.set(event), _unpaused.set(unpaused)
    try:
        yield
    finally:
        _stop.reset(token)
        _unpaused.reset(pause)


def go_on() -> None:
    """Wait while the calling thread's work is paused; raise `StoppedError` if it is cancelled. See `stopped_by`."""
    unpaused = _unpaused.get()
    if unpaused is not None:
        unpaused.wait()
    event = _stop.get()
    if event is not None and event.is_set():
        raise StoppedError


def count() -> int:
    """Return the number of threads to use.

    The result is the least of three numbers: Numba's setting (``NUMBA_NUM_THREADS``), if there is one; the number of
    processors available to this process; and the number that was passed to `limited`, if `limited` is in effect.
    """
    config = getattr(sys.modules.get("numba"), "config", None)  # None if Numba is not loaded, or only partly yet
    setting = os.environ.get("NUMBA_NUM_THREADS", sys.maxsize) if config is None else config.NUMBA_NUM_THREADS
    return max(1, min(int(setting), _processors(os.getpid(), int(time.monotonic())), _limit.get()))


@functools.lru_cache(maxsize=1)
def _processors(_process: int, _second: int) -> int:
    """Return the number of processors available to this process.

    The result is cached for each process ID and each second, because reading it takes about 40 µs.
    """
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextlib.contextmanager
def limited(threads: int) -> Iterator[None]:
    """Within the block, let the calling thread's work use at most the given number of threads.

    Pass 1 for work that already runs in several threads.
    """
    token = _limit.set(threads)
    try:
        yield
    finally:
        _limit.reset(token)


@functools.lru_cache(maxsize=1)
def _executor(_process: int) -> ThreadPoolExecutor:
    """Return the thread pool of the process with this ID. After a fork, a child needs its own pool.

    The pool starts threads when they are needed, and keeps them.
    """
    return ThreadPoolExecutor(max_workers=2 * (os.cpu_count() or 1), thread_name_prefix="pvphong")


# Seconds of work that justify another thread. Waking it and waiting for its end take 0.05 to 0.2 ms.
_WORTH_WAKING = 3e-4


def run(work: Callable[[int, int], Any], stop: int, step: int) -> None:
    """Call `work(first, last)` for consecutive ranges of `step` items from 0 to `stop`, on at most `count()` threads.

    `first` is the first item of a range, and `last` the item after the range. The last range may be shorter. If a call
    raises, no more ranges start, and the exception is raised when all running ranges have ended.
    """
    with shared(work, stop, step) as ranges:
        for first, last in ranges:
            work(first, last)


@contextlib.contextmanager
def shared(work: Callable[[int, int], Any], stop: int, step: int, longest: int = 0) -> Iterator[Iterator[Range]]:
    """Divide the items from 0 to `stop` into ranges for several threads, and yield the calling thread's ranges.

    The block must do the work of the ranges that it receives. Meanwhile other threads call `work` for theirs.

    After an exception, an interrupt or a cancellation in the calling thread, no more ranges start. The exception is
    raised when all running ranges have ended.

    Parameters
    ----------
    work : callable
        Function that the other threads call with the first item of a range and the item after its last.
    stop : int
        Number of items.
    step : int
        Length of the ranges, or their least length if `longest` is greater than `step`. The last range may be shorter.
    longest : int, optional
        Greatest length of a range. By default, or if `longest` is at most `step`, all ranges have the length `step`.
        Pass a larger value if the work may take less time than waking a thread.

        With a larger value, a range's length is the number of remaining items divided by the number of threads, but at
        least `step` and at most `longest`. So there are few ranges, and the last ones are short, so that all threads
        end together (guided self-scheduling, Polychronopoulos and Kuck 1987). If there are fewer items than `longest`
        times the number of threads, the calling thread first does a quarter of a step and measures the time. Other
        threads join only if the remaining work takes long enough.
    """
    go_on()
    begun, lock, note, has_failed = 0, threading.Lock(), text.counting(stop), threading.Event()
    most, unpaused = max(1, min(count(), -(-stop // step))), _unpaused.get()
    helpers: list[Future[None]] = []

    def take_ranges() -> Iterator[Range]:
        nonlocal begun
        while True:
            go_on()
            with lock:
                first = begun
                last = begun = min(first + max(step, min((stop - first) // most, longest)), stop)
            if first == last:
                return
            yield first, last
            note(last - first)

    def end() -> None:
        nonlocal begun
        with lock:
            begun = stop
        has_failed.set()

    def help_out() -> None:
        with contextlib.suppress(StoppedError), stopped_by(has_failed, unpaused):
            try:
                for first, last in take_ranges():
                    work(first, last)
            except BaseException:
                end()
                raise

    def own_ranges() -> Iterator[Range]:
        nonlocal begun, most
        if longest > step and most > 1 and stop < most * longest:
            start, begun = time.perf_counter(), step // 4
            yield 0, begun
            note(begun)
            if (time.perf_counter() - start) * (stop / begun - 1.0) < _WORTH_WAKING:
                most = 1
        helpers.extend(_executor(os.getpid()).submit(help_out) for _ in range(most - 1))
        yield from take_ranges()

    try:
        with text.listening(None):
            yield own_ranges()
    except BaseException:
        end()
        raise
    finally:
        for helper in helpers:
            if not helper.cancel():  # a helper that has not started has nothing left to do
                helper.result()
