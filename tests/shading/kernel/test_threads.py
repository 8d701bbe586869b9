"""Threads share the work, change no bit, and are there for every caller and after a fork."""

from __future__ import annotations

import os
import threading
import time

import pytest
from apart import EVALUATE, run_apart

from pvphong.base import threads
from pvphong.shading import kernel

needs_numba = pytest.mark.skipif(not kernel.is_available(), reason="Numba cannot run here")
needs_two = pytest.mark.skipif(not kernel.is_available() or threads.count() < 2, reason="there is a single thread")


@needs_two
def test_ranges_cover_everything_once_and_several_threads_take_them():
    taken, lock = [], threading.Lock()

    def work(first, last):
        time.sleep(0.01)
        with lock:
            taken.append((first, last, threading.get_ident()))

    threads.run(work, 1003, 50)
    assert sorted((first, last) for first, last, _ in taken) == [(k, min(k + 50, 1003)) for k in range(0, 1003, 50)]
    assert len({thread for *_, thread in taken}) > 1


@needs_numba
def test_little_work_stays_with_the_caller():
    taken = []
    threads.run(lambda *part: taken.append((*part, threading.get_ident())), 50, 50)
    threads.run(lambda *_: taken.append("nothing to do"), 0, 50)
    assert taken == [(0, 50, threading.get_ident())]


def test_after_an_exception_no_range_is_begun():
    begun = []

    def work(first, _):
        begun.append(first)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        threads.run(work, 1000, 10)
    assert len(begun) <= threads.count()


@needs_two
def test_what_goes_wrong_in_a_helper_is_raised_and_it_helps_again():
    caller, has_begun = threading.get_ident(), threading.Event()

    def work(_first, _last):
        if threading.get_ident() == caller:
            assert has_begun.wait(60)
        else:
            has_begun.set()
            raise ValueError("it went wrong")

    for _ in range(3):
        has_begun.clear()
        with pytest.raises(ValueError, match="it went wrong"):
            threads.run(work, 2, 1)


@needs_numba
def test_numbas_setting_is_the_most():
    code = "from pvphong.base import threads; print(threads.count())"
    assert run_apart(code, NUMBA_NUM_THREADS="1") == "1\n"


@needs_numba
@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_forked_child_has_its_own():
    code = f"""
{EVALUATE}
import os
assert abs(lit("numba", 300000) - 0.84).max() < 1e-6
child = os.fork()
if not child:
    os._exit(0 if abs(lit("numba", 300000) - 0.84).max() < 1e-6 else 1)
assert os.waitpid(child, 0)[1] == 0
print(lit("numba", 300000))
"""
    assert "0.84" in run_apart(code)


@needs_numba
def test_several_python_threads_may_evaluate_at_once():
    code = f"""
{EVALUATE}
from concurrent.futures import ThreadPoolExecutor
with ThreadPoolExecutor(4) as callers:
    for colour in callers.map(lambda _: lit("numba", 200000), range(12)):
        assert abs(colour - 0.84).max() < 1e-6
"""
    run_apart(code)
