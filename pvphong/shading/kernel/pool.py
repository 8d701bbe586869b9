"""Threads of our own for compiled code that holds no lock of the interpreter's: several callers may use them at once.

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
from typing import Any, ClassVar

from pvphong.base import progress


class _Limit:
    threads: ClassVar[int | None] = None


class _Here(threading.local):
    is_alone = False


_here = _Here()


def _most() -> int:
    """Numba's setting, NUMBA_NUM_THREADS, which is by default the processors that this process may use."""
    numba = sys.modules.get("numba")  # rays are cast without it
    return int(os.environ.get("NUMBA_NUM_THREADS", sys.maxsize) if numba is None else numba.config.NUMBA_NUM_THREADS)


def count() -> int:
    """Threads that work at once: Numba's setting, but no more than the processors that this process may use now."""
    if _here.is_alone:
        return 1
    here = _processors(os.getpid(), int(time.monotonic()))
    return max(1, min(_most(), here, _Limit.threads or here))


@functools.lru_cache(maxsize=1)
def _processors(_process: int, _second: int) -> int:
    """Those that this process may use; asked for once a second, for the answer takes some 40 µs."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextlib.contextmanager
def limited(threads: int) -> Iterator[None]:
    """While it lasts, no more threads than that work at once, in the whole process."""
    before, _Limit.threads = _Limit.threads, threads
    try:
        yield
    finally:
        _Limit.threads = before


@contextlib.contextmanager
def alone() -> Iterator[None]:
    """While it lasts, what this thread calls is done by this thread: for who shares out the processors already."""
    before, _here.is_alone = _here.is_alone, True
    try:
        yield
    finally:
        _here.is_alone = before


@functools.cache
def _helpers(_process: int, threads: int) -> ThreadPoolExecutor:
    """A process has its own, for threads do not survive a fork."""
    return ThreadPoolExecutor(threads, thread_name_prefix="pvphong")


def together(work: Callable[[], Any], threads: int, is_done: Callable[[], bool] = lambda: False) -> None:
    """Let threads do one piece of work at once, the calling one among them: no more than `count()`.

    An exception in any of them is raised here, when all are done. If `is_done` says so once the calling one is, the
    others are not waited for.
    """
    helpers = threads - 1
    futures = [_helpers(os.getpid(), helpers).submit(work) for _ in range(helpers)]
    waits = True
    try:
        work()
        waits = not is_done()
    finally:
        for future in futures:
            if not future.cancel() and waits:  # those that have not begun have nothing left to do
                future.result()


def run(work: Callable[[int, int], Any], stop: int, step: int) -> None:
    """Call `work(first, last)` for all ranges of a length from 0 to `stop`.

    After an exception in any of them, or where the calling thread is interrupted, no other range is begun.
    """
    ranges, lock, note = iter(range(0, stop, step)), threading.Lock(), progress.counting(stop)

    @contextlib.contextmanager
    def ending_for_all() -> Iterator[None]:
        nonlocal ranges
        try:
            yield
        except BaseException:
            ranges = iter(range(0))
            raise

    def help_out() -> None:
        with ending_for_all():
            while True:
                with lock:
                    first = next(ranges, stop)
                if first >= stop:
                    return
                last = min(first + step, stop)
                work(first, last)
                note(last - first)

    with ending_for_all():
        together(help_out, min(count(), -(-stop // step)))
