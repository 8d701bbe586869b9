"""Threads: the number that a process keeps, limits per calling thread, and cancellation."""

import threading
import time

import pytest

from pvphong.base import text, threads

needs_two = pytest.mark.skipif(threads.count() < 2, reason="there is a single thread")


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
        time.sleep(1e-3)  # else a helper might do all of it before the calling thread runs again

    with threads.stopped_by(stop), pytest.raises(threads.StoppedError):
        threads.run(work, 10_000, 1)
    assert len(begun) < 10_000


@needs_two
def test_paused_work_waits_in_all_threads_and_can_be_cancelled():
    stop, unpaused, done, ended = threading.Event(), threading.Event(), [], []

    def work(first, _last):
        done.append(first)
        time.sleep(1e-3)

    def run():
        with threads.stopped_by(stop, unpaused):
            try:
                threads.run(work, 10_000, 1)
            except threads.StoppedError:
                ended.append(True)

    unpaused.set()
    runner = threading.Thread(target=run)
    runner.start()
    for _ in range(2):
        unpaused.clear()
        time.sleep(0.05)
        before = len(done)
        time.sleep(0.05)
        assert len(done) == before
        unpaused.set()
        time.sleep(0.05)
        assert len(done) > before
    unpaused.clear()
    stop.set()
    unpaused.set()
    runner.join()
    assert ended
    assert len(done) < 10_000


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


def test_little_work_stays_with_the_caller():
    taken = []
    threads.run(lambda *part: taken.append((*part, threading.get_ident())), 50, 50)
    threads.run(lambda *_: taken.append("nothing to do"), 0, 50)
    assert taken == [(0, 50, threading.get_ident())]


@needs_two
@pytest.mark.parametrize(("seconds", "is_shared"), [(0.0, True), (1e9, False)])
def test_work_that_may_be_short_is_shared_where_that_is_worth_it(monkeypatch, seconds, is_shared):
    """Ranges get shorter towards the end."""
    monkeypatch.setattr(threads, "_WORTH_WAKING", seconds)
    taken = []

    def work(first, last):
        time.sleep(0.01)
        taken.append((first, last, threading.get_ident()))

    def run(longest):
        with threads.shared(work, 1003, 60, longest) as ranges:
            for each in ranges:
                work(*each)

    run(1000)
    taken.sort()
    assert [first for first, *_ in taken] == [0, *(last for _, last, _ in taken[:-1])]
    assert taken[-1][1] == 1003
    lengths = [last - first for first, last, _ in taken]
    assert lengths[0] == 15
    assert lengths[1] == (988 // threads.count() if is_shared else 988)
    assert lengths[1:] == sorted(lengths[1:], reverse=True)
    assert (len({thread for *_, thread in taken}) > 1) == is_shared

    taken.clear()
    run(1003 // threads.count())  # each thread gets a longest range: none is timed first
    assert max(last - first for first, last, _ in taken) == 1003 // threads.count()
    assert len({thread for *_, thread in taken}) > 1


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


@needs_two
def test_work_within_a_range_of_a_helper_ends_too_where_another_range_fails():
    caller, has_begun, begun = threading.get_ident(), threading.Event(), []

    def inner(first, _last):
        begun.append(first)
        has_begun.set()
        time.sleep(0.001)

    def work(_first, _last):
        if threading.get_ident() != caller:
            threads.run(inner, 60_000, 1)
        else:
            assert has_begun.wait(60)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        threads.run(work, 2, 1)
    assert len(begun) < 60_000
    assert not has_begun.clear()
    threads.run(inner, 10, 1)
    assert has_begun.is_set()  # nobody is stopped any more


def test_the_progress_of_work_within_a_range_is_not_told():
    heard = []
    with text.listening(lambda *told: heard.append(told)), text.about("all"):
        threads.run(lambda *_: threads.run(lambda *_: None, 10, 1), 5, 1)
        threads.run(lambda *_: None, 1, 1)
    assert heard == [*(("all", part / 5) for part in range(1, 6)), ("all", 1.0)]
