"""What memory there is, and what reading a file may cost in a process that another watches."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from pvphong.base import processes

_STATUS, _MEMORY = "/proc/self/status", "/proc/meminfo"


@contextmanager
def reading(path: str | os.PathLike[str]) -> Iterator[None]:
    """While a file is read: the watcher knows which one, and no more memory can be had than is free.

    Elsewhere than in a worker nothing is limited.
    """
    worker = processes.worker
    if worker is None:
        yield
        return
    size = 0
    with suppress(OSError, ValueError):
        size = Path(path).stat().st_size
    worker.reading(os.fspath(path), processes.SECONDS + size / processes.BYTES_PER_SECOND)
    with _free_memory():
        yield
    worker.done()


def available_memory() -> int | None:
    """Bytes that can be had without swapping; None where the system does not say."""
    return 1024 * _kibibytes(_MEMORY, "MemAvailable:") if sys.platform == "linux" else None


@contextmanager
def _free_memory() -> Iterator[None]:
    """A limit for this process's data, so that what a damaged file asks for is refused before the system stalls."""
    if sys.platform != "linux":
        yield
        return
    import resource

    free = 1024 * (_kibibytes(_STATUS, "VmData:") + _kibibytes(_MEMORY, "MemAvailable:"))
    old, hard = resource.getrlimit(resource.RLIMIT_DATA)
    bounds = [limit for limit in (free, old, hard) if limit != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_DATA, (min(bounds), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (old, hard))


def _kibibytes(file: str, name: str) -> int:
    with open(file) as lines:
        return next(int(line.split()[1]) for line in lines if line.startswith(name))
