"""Wait for threads, and run endless work in them."""

import time

from pvphong.base import threads


def until(is_so):
    for _ in range(4000):
        if is_so():
            return
        time.sleep(0.005)
    raise AssertionError("it did not come")


def endless(begun, stopped):
    """Work that ends only when cancelled; starts and cancellations are recorded in lists."""

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
