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
from queue import SimpleQueue
from typing import Any, ClassVar

from pvphong.base import text


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
def single_threaded() -> Iterator[None]:
    """While it lasts, what this thread calls is done by this thread: for who shares out the processors already."""
    before, _here.is_alone = _here.is_alone, True
    try:
        yield
    finally:
        _here.is_alone = before


@functools.cache
def _waiting(_process: int, helpers: int) -> SimpleQueue[_Share]:
    """What threads wait for; a process has its own, for threads do not survive a fork.

    Waking them so takes half as long as by an executor, 20 to 40 µs, and that shows beside a million vertices.
    """
    shares: SimpleQueue[_Share] = SimpleQueue()

    def help_for_ever() -> None:
        while True:
            shares.get().take()

    for k in range(helpers):
        threading.Thread(target=help_for_ever, name=f"pvphong_{k}", daemon=True).start()
    return shares


class _Share:
    """A helper's share in a piece of work."""

    def __init__(self, work: Callable[[], Any]) -> None:
        self._work = work
        self._error: BaseException | None = None
        self._begun, self._is_done = threading.Lock(), threading.Lock()
        self._is_done.acquire()

    def take(self) -> None:
        """Do it, unless it was withdrawn."""
        if not self._begun.acquire(blocking=False):
            return
        try:
            self._work()
        except BaseException as error:
            self._error = error
        finally:
            del self._work
            self._is_done.release()

    def withdraw(self) -> bool:
        """Whether it had not begun, and now never will."""
        if not self._begun.acquire(blocking=False):
            return False
        del self._work  # it may be long until a busy helper throws this away
        return True

    def wait(self) -> None:
        """Until it is done; raises what was raised in it."""
        self._is_done.acquire()
        if self._error is not None:
            raise self._error


def together(work: Callable[[], Any], threads: int, is_done: Callable[[], bool] = lambda: False) -> None:
    """Let threads do one piece of work at once, the calling one among them: no more than `count()`.

    An exception in any of them is raised here, when all are done. If `is_done` says so once the calling one is, the
    others are not waited for.
    """
    shares = [_Share(work) for _ in range(threads - 1)]
    for share in shares:
        _waiting(os.getpid(), len(shares)).put(share)
    waits = True
    try:
        work()
        waits = not is_done()
    finally:
        for share in shares:
            if not share.withdraw() and waits:  # those that have not begun have nothing left to do
                share.wait()


def run(work: Callable[[int, int], Any], stop: int, step: int) -> None:
    """Call `work(first, last)` for all ranges of a length from 0 to `stop`.

    After an exception in any of them, or where the calling thread is interrupted, no other range is begun.
    """
    ranges, lock, note = iter(range(0, stop, step)), threading.Lock(), text.counting(stop)

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
