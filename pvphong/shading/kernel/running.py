"""Compiled code run over arrays: by several threads, piece by piece where there are many vertices or copies."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from pvphong.base.types import FloatArray
from pvphong.shading.kernel import pool
from pvphong.shading.kernel.rows import AT_WORK, BEGUN, BLOCK, GROUP, LEFT, LINE, ROWS

if TYPE_CHECKING:
    from pvphong.shading.kernel.records import Records

# Vertices that are copied at a time where arrays are not in the form that compiled code takes: 24 MiB at most.
COPIED = 2**18
# Vertices that are lit at a time: between two pieces a program can be interrupted.
_LIT = 2**23
# Vertices for which it is worth waking another thread.
_WORTH_HELP = 4 * GROUP
# How often a thread that is done looks whether others are, which takes some 10 ns, before it sleeps until they are.
_PATIENCE = 5000


class Call:
    """One equation for the driver, which several threads may run at once."""

    def __init__(self, driver: Callable[..., int], equation: Records) -> None:
        self._driver, self._equation = driver, equation

    def light(self, arrays: list[Any]) -> list[Any]:
        """Fill in colours, the last of the arrays after points, normals, albedo and channels where these are read.

        Gives indices of vertices that are left to the reference.
        """
        colors = arrays[-1]
        count = len(colors)
        threads = max(1, min(pool.count(), -(-count // _WORTH_HELP)))
        shared = np.zeros(BEGUN + threads, np.int64)
        addresses = *map(address, arrays), address(colors), *self._equation, address(shared)
        left: list[Any] = []
        turns = itertools.count()

        def work() -> None:
            own, memory, _kept = next(turns), Memory.of_thread(), shared  # also where nobody waits for this thread
            patience = _PATIENCE if threading.get_ident() == caller else 0
            while (first := self._driver(*addresses, threads, own, patience, count, *memory.addresses)) >= 0:
                left.append(first + memory.declined())

        caller = threading.get_ident()
        # a thread that comes when all is done reads nothing but `shared` and the records
        pool.together(work, threads, lambda: not shared[AT_WORK] and not shared[LEFT])
        return left


class Memory:
    """Scratch memory of one thread."""

    _all = threading.local()

    def __init__(self) -> None:
        self._arrays = _aligned(ROWS, np.float64), _aligned(3 * BLOCK, np.float64), np.zeros(GROUP, np.uint8)
        self.addresses = tuple(map(address, self._arrays))
        """Of rows, points in float64, and marks of vertices that are declined."""

    @classmethod
    def of_thread(cls) -> Memory:
        """The calling thread's."""
        memory: Memory | None = getattr(cls._all, "memory", None)
        if memory is None:
            memory = cls._all.memory = Memory()
        return memory

    def declined(self) -> Any:
        """Indices of the marks, which are taken away."""
        marks = self._arrays[-1]
        found = np.flatnonzero(marks)
        marks[found] = 0
        return found


def address(array: Any) -> int:
    """Where an array's entries start; 0 for None."""
    return 0 if array is None else int(array.ctypes.data)


def _aligned(length: int, dtype: Any) -> Any:
    """Memory that starts where a cache line starts: a vector across two lines takes twice as long."""
    size = np.dtype(dtype).itemsize
    memory = np.empty(length + LINE // size, dtype)
    start = -memory.ctypes.data % LINE // size
    return memory[start : start + length]


def parts(inputs: list[tuple[FloatArray | None, np.dtype[Any]]], count: int) -> Iterator[slice]:
    """Long pieces where no array has to be copied, else shorter ones."""
    are_ready = all(array is None or is_plain(array, dtype) for array, dtype in inputs)
    step = _LIT if are_ready else COPIED
    return (slice(start, min(start + step, count)) for start in range(0, count, step))


def is_plain(array: FloatArray, dtype: np.dtype[Any]) -> bool:
    """Whether an array is in the form that compiled code takes."""
    return array.dtype == dtype and array.flags.c_contiguous and array.flags.aligned


def ready(array: FloatArray | None, dtype: np.dtype[Any]) -> FloatArray | None:
    """The array itself, or a copy in the form that compiled code takes."""
    if array is None or is_plain(array, dtype):
        return array
    return np.require(array, dtype, ["C", "A"])
