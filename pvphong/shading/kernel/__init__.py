"""The fused evaluator: the same equation as `reference.py`, compiled by Numba, parallel and vectorised.

Numba is an optional extra. It is imported when the kernel first runs, compiles then (seconds), and keeps what it
compiled on disk where it can. What cannot be run here is declined, cheaply, and belongs to the reference:
Numba is missing, component arrays are wanted, a light or reflectance has no stage, a scene coordinate lies beyond 2¹⁰⁰,
an attenuation or a matrix has an entry that is not between that and 2⁻¹⁰⁰, or a light is brighter than its stage takes.
Single vertices are declined too, and the reference lights those: on a light or the eye, not finite, or so far from a
light or so near it that float32 does not hold the products.

The kernel differs from the reference by rounding alone. float32 results come from float32 arithmetic, geometry
included: differences of positions have full relative precision however far the scene is from the origin, and a
highlight errs by at most (4√n + 10) · 2⁻²⁴ for shininess n.

Where to look: `driver` lights block after block and calls the stages, which lights and reflectances write with the
names in `toolkit`; `ways` has what concerns directions and distances, attenuation included; `records` is the form in
which it takes an equation; `keeping` compiles and keeps code on disk; `pool` has the threads.
"""

from __future__ import annotations

import functools
import importlib.util
import threading
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from pvphong.base.types import Float64Array, FloatArray
from pvphong.shading.albedo import reflectances
from pvphong.shading.equation import Equation
from pvphong.shading.kernel import pool, records
from pvphong.shading.kernel.rows import BLOCK, GROUP, LINE, ROWS
from pvphong.shading.reference import shade as light_by_reference
from pvphong.shading.result import Shading

if TYPE_CHECKING:
    from pvphong.shading.kernel.keeping import Library

# Vertices that are copied at a time where arrays are not in the form that compiled code takes: 24 MiB at most.
COPIED = 2**18
# Vertices that a thread lights at a time, and those that it searches for bounds.
_LIT, _SEARCHED = 16 * GROUP, 2**17
# Rows from which their bounds are found in less time than NumPy takes.
_MANY = 2**15


def obstacle() -> tuple[str, str] | None:
    """Why Numba cannot be used in this process, and what can be done about it; the first call imports it."""
    if _library() is not None:
        return None
    if importlib.util.find_spec("numba") is not None:
        return "where Numba does not compile", "Unset NUMBA_DISABLE_JIT, or see whether `import numba` fails."
    remedy = 'pip install "pvphong[fast]" installs it; backend="auto" does without where it is missing.'
    return "where Numba is not installed", remedy


def is_available() -> bool:
    """Whether Numba can be imported and used in this process; the first call imports it."""
    return _library() is not None


@functools.cache
def keeps_code() -> bool:
    """Whether compiled code is on disk after the first time: else each process would compile anew."""
    library = _library()
    return library is not None and library.keeps_code


def seconds_compiling(run: Callable[[], object]) -> float:
    """Seconds that Numba spends compiling while something runs; loading what it kept on disk does not count."""
    if not is_available():
        run()
        return 0.0
    from numba.core import event

    seconds: list[float] = []
    with event.install_timer("numba:compile", seconds.append):
        run()
    return sum(seconds)


@functools.cache
def _library() -> Library | None:
    """Compiled code; None without Numba."""
    try:
        from numba import config

        from pvphong.shading.kernel.keeping import Library
    except ImportError:
        return None
    return None if config.DISABLE_JIT else Library()


class _Process:
    """What this process has done."""

    has_run: ClassVar[bool] = False


def shade(
    points: FloatArray,
    normals: FloatArray,
    equation: Equation,
    albedo: FloatArray | None,
    result: Shading,
    whole: Equation | None = None,
) -> bool:
    """Evaluate the equation at every vertex into `result.rgb`, or decline.

    The result does not depend on the number of threads, to the bit. Arrays that are not C-contiguous are copied piece
    by piece and give the same bits; so are float32 beside float64, as float64.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3), float32 or float64, of any memory layout.
    equation : Equation
        What to evaluate.
    albedo : ndarray or None
        Shape (n, 3), as `checked_albedo` gives it; multiplies the material's ambient and diffuse.
    result : Shading
        `rgb`, C-contiguous, is filled in: float32, float64, or uint8, which is float32 arithmetic rounded to
        0-255 for display.
    whole : Equation, optional
        The equation before a plan left out what does not reach these vertices; the same if not given. It decides
        whether the kernel declines and the type in which vertices are read, for these are not to hang on where the
        other vertices are.

    Returns
    -------
    bool
        False if the equation was declined and nothing was written.
    """
    rgb, whole = result.rgb, whole or equation
    library = _library()
    if result.base is not None or not rgb.flags.c_contiguous or library is None:
        return False
    if not records.fits(whole, library.toolkit):
        return False
    real = np.dtype(np.float64 if rgb.dtype == np.float64 else np.float32)
    read = [points] * whole.needs_points + [normals] * whole.needs_normals
    stored = np.result_type(real, *read)
    has_albedo, is_display = albedo is not None, rgb.dtype == np.uint8
    options = {"is_wide": stored != real, "has_albedo": has_albedo, "is_display": is_display}
    equation_records = records.records_of(equation, library, real.name, **options)
    call = _Call(library.driver(stored.name, real.name), equation_records, real)
    vertices = [
        (points if equation.needs_points else None, stored),
        (normals if equation.needs_normals else None, stored),
    ]
    for part in _parts([*vertices, (albedo, real)], len(rgb)):
        shades = None if albedo is None else albedo[part]
        if shades is not None and shades.dtype != real:
            shades = reflectances(shades)  # the kernel clips what it gets, but this may not even fit its type
        arrays = [*(None if array is None else array[part] for array, _ in vertices), shades]
        ready = [_ready(array, dtype) for array, dtype in zip(arrays, (stored, stored, real), strict=True)]
        for rows in call.light([*ready, rgb[part]]):
            _light_declined(points[part], normals[part], shades, equation, rgb[part], rows)
    _Process.has_run = True
    return True


class _Call:
    """One equation for the driver, which several threads may run at once."""

    def __init__(self, driver: Callable[..., int], equation: records.Records, real: np.dtype[Any]) -> None:
        self._driver, self._equation, self._real = driver, equation, real

    def light(self, arrays: list[Any]) -> list[Any]:
        """Fill in colours, the last of the arrays after points, normals and albedo where these are read.

        Gives indices of vertices that are left to the reference.
        """
        colors = arrays[-1]
        addresses = [_address(array) for array in (*arrays, colors, *self._equation)]
        left: list[Any] = []

        def work(first: int, last: int) -> None:
            memory = _Memory.of_thread()
            if not self._driver(*addresses, first, last, *memory.addresses):
                left.append(first + memory.declined())

        pool.run(work, len(colors), _LIT)
        return left


class _Memory:
    """Scratch memory of one thread."""

    _all = threading.local()

    def __init__(self) -> None:
        self._arrays = _aligned(ROWS, np.float64), _aligned(3 * BLOCK, np.float64), np.zeros(_LIT, np.uint8)
        self.addresses = tuple(map(_address, self._arrays))
        """Of rows, points in float64, and marks of vertices that are declined."""

    @classmethod
    def of_thread(cls) -> _Memory:
        """The calling thread's."""
        memory: _Memory | None = getattr(cls._all, "memory", None)
        if memory is None:
            memory = cls._all.memory = _Memory()
        return memory

    def declined(self) -> Any:
        """Indices of the marks, which are taken away."""
        marks = self._arrays[-1]
        found = np.flatnonzero(marks)
        marks[found] = 0
        return found


def _light_declined(
    points: FloatArray,
    normals: FloatArray,
    albedo: FloatArray | None,
    equation: Equation,
    rgb: Any,
    rows: Any,
) -> None:
    """Colours of some vertices by the reference."""
    shades = None if albedo is None else albedo[rows]
    lit = Shading(np.empty((len(rows), 3), np.float32 if rgb.dtype == np.uint8 else rgb.dtype))
    light_by_reference(points[rows], normals[rows], equation, shades, lit)
    rgb[rows] = np.rint(np.clip(lit.rgb, 0.0, 1.0) * 255.0) if rgb.dtype == np.uint8 else lit.rgb


def find_bounds(rows: FloatArray) -> tuple[Float64Array, Float64Array] | None:
    """Least and greatest entry of each column, shape (3,), NaN where any is not finite; or None.

    None where NumPy is to look for them: for few rows, and where compiled code has not run in this process.
    """
    library = _library() if _Process.has_run and len(rows) >= _MANY else None
    if library is None or rows.dtype not in (np.float32, np.float64) or not _is_plain(rows, rows.dtype):
        return None
    search, found = library.extremes(rows.dtype.name), np.full((-(-len(rows) // _SEARCHED), 6), np.nan)

    def work(first: int, last: int) -> None:
        low_and_high = np.empty(6)
        if search(_address(rows), first, last, _Memory.of_thread().addresses[0], _address(low_and_high)):
            found[first // _SEARCHED] = low_and_high

    pool.run(work, len(rows), _SEARCHED)
    return found[:, :3].min(axis=0), found[:, 3:].max(axis=0)


def _address(array: Any) -> int:
    return 0 if array is None else int(array.ctypes.data)


def _aligned(length: int, dtype: Any) -> Any:
    """Memory that starts where a cache line starts: a vector across two lines takes twice as long."""
    size = np.dtype(dtype).itemsize
    memory = np.empty(length + LINE // size, dtype)
    start = -memory.ctypes.data % LINE // size
    return memory[start : start + length]


def _parts(inputs: list[tuple[FloatArray | None, np.dtype[Any]]], count: int) -> Iterator[slice]:
    """All vertices at once where no array has to be copied, else pieces."""
    ready = all(array is None or _is_plain(array, dtype) for array, dtype in inputs)
    step = max(count, 1) if ready else COPIED
    return (slice(start, min(start + step, count)) for start in range(0, count, step))


def _is_plain(array: FloatArray, dtype: np.dtype[Any]) -> bool:
    return array.dtype == dtype and array.flags.c_contiguous and array.flags.aligned


def _ready(array: FloatArray | None, dtype: np.dtype[Any]) -> FloatArray | None:
    """The array itself, or a copy in the form that compiled code takes."""
    if array is None or _is_plain(array, dtype):
        return array
    return np.require(array, dtype, ["C", "A"])
