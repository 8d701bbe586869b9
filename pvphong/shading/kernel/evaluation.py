"""Vertices through compiled code: an equation's driver and records, run over arrays by several threads."""

from __future__ import annotations

import functools
import itertools
import threading
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from pvphong.base import threads
from pvphong.base.types import FloatArray
from pvphong.shading.albedo import reflectances
from pvphong.shading.equation import Equation
from pvphong.shading.kernel import code, records
from pvphong.shading.kernel.code import Library, NotCompiled, Request
from pvphong.shading.kernel.vertices import AT_WORK, BEGUN, BLOCK, GROUP, LEFT, LINE, ROWS
from pvphong.shading.reference import shade as shade_by_reference
from pvphong.shading.result import Shading

# Vertices that are copied at a time where arrays are not in the form that compiled code takes: 24 MiB at most.
COPIED = 2**18
# Vertices that are lit at a time: between two pieces a program can be interrupted.
_LIT = 2**23
# Vertices for which it is worth waking another thread.
_WORTH_HELP = 4 * GROUP
# How often a thread that is done looks whether others are, which takes some 10 ns, before it sleeps until they are.
_PATIENCE = 5000


def shade(
    library: Library,
    points: FloatArray,
    normals: FloatArray,
    equation: Equation,
    albedo: FloatArray | None,
    result: Shading,
    whole: Equation,
    channels: FloatArray | None,
    waits: bool,
) -> bool:
    """As `pvphong.shading.kernel.shade` has it."""
    rgb = result.rgb
    if result.base is not None or not rgb.flags.c_contiguous:
        return False
    real = np.dtype(np.float64 if rgb.dtype == np.float64 else np.float32)
    codes = records.codes_of(whole, name_of(real), has_albedo=albedo is not None)
    if codes is None:
        return False
    read = [points] * whole.needs_points + [normals] * whole.needs_normals
    stored = np.result_type(real, *read)
    request = Request(equation, name_of(stored), name_of(real))
    source = library if waits else library.at_hand
    try:
        driver = source.driver(request.stored, request.real)
        packed = records.records_of(
            equation,
            codes,
            source,
            request.real,
            is_wide=stored != real,
            has_albedo=albedo is not None,
            is_display=rgb.dtype == np.uint8,
            channel_length=len(rgb),
        )
    except NotCompiled as missing:
        code.ask_for(missing.key, request, library.lock)
        return False
    if channels is not None:
        channels = np.ascontiguousarray(channels, real)
    vertices = [
        (points if equation.needs_points else None, stored),
        (normals if equation.needs_normals else None, stored),
    ]
    for part in _parts([*vertices, (albedo, real)], len(rgb)):
        shades = None if albedo is None else albedo[part]
        if shades is not None and shades.dtype != real:
            shades = reflectances(shades)  # the kernel clips what it gets, but this may not even fit its type
        arrays = [*(None if array is None else array[part] for array, _ in vertices), shades]
        plain = [_ready(array, dtype) for array, dtype in zip(arrays, (stored, stored, real), strict=True)]
        seen = None if channels is None else channels[:, part]
        for declined in _run(driver, packed, [*plain, seen, rgb[part]]):
            _shade_declined(points[part], normals[part], shades, equation, rgb[part], declined, seen)
    return True


def _run(driver: Callable[..., int], equation: records.Records, arrays: list[Any]) -> list[Any]:
    """Fill in colours, the last of the arrays after points, normals, albedo and channels where these are read.

    Gives indices of vertices that are left to the reference.
    """
    colors = arrays[-1]
    count = len(colors)
    helpers = max(1, min(threads.count(), -(-count // _WORTH_HELP)))
    shared = np.zeros(BEGUN + helpers, np.int64)
    addresses = *map(address, arrays), address(colors), *equation, address(shared)
    left: list[Any] = []
    turns, caller = itertools.count(), threading.get_ident()

    def work() -> None:
        own, memory, _kept = next(turns), Memory.of_thread(), shared  # also where nobody waits for this thread
        patience = _PATIENCE if threading.get_ident() == caller else 0
        while (first := driver(*addresses, helpers, own, patience, count, *memory.addresses)) >= 0:
            left.append(first + memory.declined())

    # a thread that comes when all is done reads nothing but `shared` and the records
    threads.together(work, helpers, lambda: not shared[AT_WORK] and not shared[LEFT])
    return left


def _shade_declined(
    points: FloatArray,
    normals: FloatArray,
    albedo: FloatArray | None,
    equation: Equation,
    rgb: Any,
    rows: Any,
    channels: FloatArray | None,
) -> None:
    """Colours of some vertices by the reference."""
    shades = None if albedo is None else albedo[rows]
    lit = Shading(np.empty((len(rows), 3), np.float32 if rgb.dtype == np.uint8 else rgb.dtype))
    seen = None if channels is None else channels[:, rows]
    shade_by_reference(points[rows], normals[rows], equation, shades, lit, seen)
    rgb[rows] = np.rint(np.clip(lit.rgb, 0.0, 1.0) * 255.0) if rgb.dtype == np.uint8 else lit.rgb


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


def _aligned(length: int, dtype: Any) -> Any:
    """Memory that starts where a cache line starts: a vector across two lines takes twice as long."""
    size = np.dtype(dtype).itemsize
    memory = np.empty(length + LINE // size, dtype)
    start = -memory.ctypes.data % LINE // size
    return memory[start : start + length]


def address(array: Any) -> int:
    """Where an array's entries start; 0 for None."""
    return 0 if array is None else int(array.ctypes.data)


@functools.cache
def name_of(kind: np.dtype[Any]) -> str:
    """A type's name, which NumPy takes microseconds to put together."""
    return kind.name


def is_plain(array: FloatArray, dtype: np.dtype[Any]) -> bool:
    """Whether an array is in the form that compiled code takes."""
    return array.dtype == dtype and array.flags.c_contiguous and array.flags.aligned


def _parts(inputs: list[tuple[FloatArray | None, np.dtype[Any]]], count: int) -> Iterator[slice]:
    """Long pieces where no array has to be copied, else shorter ones."""
    are_ready = all(array is None or is_plain(array, dtype) for array, dtype in inputs)
    step = _LIT if are_ready else COPIED
    return (slice(start, min(start + step, count)) for start in range(0, count, step))


def _ready(array: FloatArray | None, dtype: np.dtype[Any]) -> FloatArray | None:
    """The array itself, or a copy in the form that compiled code takes."""
    if array is None or is_plain(array, dtype):
        return array
    return np.require(array, dtype, ["C", "A"])
