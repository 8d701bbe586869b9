"""Waiting for threads, and work for them that has no end."""

import time

from pvphong.base import threads


def until(is_so):
    for _ in range(4000):
        if is_so():
            return
        time.sleep(0.005)
    raise AssertionError("it did not come")


def endless(begun, stopped):
    """Work that never ends by itself; who began it and who was told to stop goes to lists."""

    def work(surface, *_, **__):
        begun.append(surface)
        try:
            while True:
                threads.go_on()
                time.sleep(0.001)
        except threads.StoppedError:
            stopped.append(surface)
            raise

    return work
