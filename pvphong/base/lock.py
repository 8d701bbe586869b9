"""A lock between processes, which the system takes away when the process that holds it ends."""

from __future__ import annotations

import os
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
def locked(path: Path, *, makes: bool = True) -> Iterator[bool]:
    """Whether no other process is within such a block for the same path; none gets into one until the end of this.

    The file is made unless `makes` is false, and stays. Where it is missing, or cannot be made or locked, or somebody
    removes it meanwhile, nobody is alone.
    """
    try:
        file = path.open("ab" if makes else "r+b")
    except OSError:
        yield False
        return
    with file:
        if _is_taken(file.fileno(), path):
            yield True
            return
    yield False


def _is_taken(file: int, path: Path) -> bool:
    """Whether an open file could be locked, and is still the one that is there."""
    try:
        _take(file)
        # Who had it before may have removed it, and others may have made another one.
        return os.path.samestat(os.fstat(file), path.stat())
    except OSError:
        return False
