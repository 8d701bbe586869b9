"""A lock between processes, which the system takes away when the process that holds it ends."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

if sys.platform == "win32":
    import msvcrt

    def _take(file: int) -> None:
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
else:
    import fcntl

    def _take(file: int) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def alone(path: Path) -> Iterator[bool]:
    """Whether no other process is within such a block for the same path; none gets into one until the end of this.

    The file is made, and stays. Where it cannot be made or locked, nobody is alone.
    """
    try:
        file = path.open("ab")
    except OSError:
        yield False
        return
    with file:
        try:
            _take(file.fileno())
        except OSError:
            yield False
            return
        yield True
