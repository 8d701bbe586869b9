"""Threads of one process: few are kept, and a limit holds for the thread that asked for it."""

import threading

import pytest

from pvphong.base import threads


def test_however_many_are_asked_for_few_are_kept(monkeypatch):
    monkeypatch.setattr(threads.os, "cpu_count", lambda: 2)
    threads._executor.cache_clear()
    before = threading.active_count()
    for count in (2, 3, 5, 8, 16, 5):
        monkeypatch.setattr(threads, "count", lambda count=count: count)
        threads.run(lambda first, last: sum(range(first, 1000 * last)), 64, 1)
    assert threading.active_count() <= before + 4  # twice as many as processors
    threads._executor(threads.os.getpid()).shutdown()
    threads._executor.cache_clear()


def test_a_limit_is_the_calling_threads_own():
    counts = []
    with threads.limited(1):
        other = threading.Thread(target=lambda: counts.append(threads.count()))
        other.start()
        other.join()
        counts.append(threads.count())
    assert counts == [threads.count(), 1]


def test_who_is_told_to_stop_in_the_middle_ends_there_and_so_do_the_helpers():
    stop, begun = threading.Event(), []

    def work(first, _last):
        begun.append(first)
        stop.set()

    with threads.stopped_by(stop), pytest.raises(threads.StoppedError):
        threads.run(work, 10_000, 1)
    assert len(begun) < 10_000


def test_who_is_told_to_stop_begins_nothing_more_and_others_go_on():
    stop, done = threading.Event(), []
    with threads.stopped_by(stop):
        threads.run(lambda first, _: done.append(first), 2, 1)
        stop.set()
        other = threading.Thread(target=lambda: threads.run(lambda *_: done.append("other"), 1, 1))
        other.start()
        other.join()
        with pytest.raises(threads.StoppedError):
            threads.run(lambda first, _: done.append(first), 2, 1)
        with pytest.raises(threads.StoppedError):
            threads.go_on()
    threads.go_on()
    assert sorted(done, key=str) == [0, 1, "other"]
