"""The fused evaluator: the same equation as `reference.py`, compiled by Numba, parallel and vectorised.

Numba is an optional extra. It is imported when the kernel first runs, compiles then (seconds), and keeps what it
compiled on disk where it can. What cannot be run here is declined, cheaply, and belongs to the reference:
Numba is missing, component arrays are wanted, a light is of a kind that pvphong does not have, a scene coordinate
lies beyond 2¹⁰⁰, an attenuation or a matrix has an entry further than that from 1, or a spot is brighter than that.

The kernel differs from the reference by rounding alone. float32 results come from float32 arithmetic, geometry
included: differences of positions have full relative precision however far the scene is from the origin, and a
highlight errs by at most (4√n + 10) · 2⁻²⁴ for shininess n.
"""

from __future__ import annotations

import contextlib
import functools
import importlib.util
import os
import threading
from collections.abc import Callable, Iterator
from typing import Any, ClassVar

import numpy as np

from pvphong.base.types import Float64Array, FloatArray
from pvphong.shading.albedo import reflectances
from pvphong.shading.equation import Equation
from pvphong.shading.kernel import records
from pvphong.shading.kernel.rows import GROUP
from pvphong.shading.result import Shading

# Vertices that are copied at a time where arrays are not in the form that compiled code takes: 24 MiB at most.
COPIED = 2**18
# Rows from which their bounds are found in less time than NumPy takes.
_SEARCHED = 2**15


class _Process:
    """What this process can do. Threads do not survive a fork, and the child that uses OpenMP's is aborted."""

    one_at_a_time = threading.Lock()  # Numba's own threads are not for several of Python's at once
    has_run = False
    real_types: ClassVar[dict[np.dtype[Any], np.dtype[Any]]] = {}  # of what has run, by the vertices' type
    lost_its_threads = False
    has_mended = False
    keeps_code = True

    @classmethod
    def after_fork(cls) -> None:
        cls.lost_its_threads = cls.has_run


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_Process.after_fork)


def obstacle() -> tuple[str, str] | None:
    """Why Numba cannot be used in this process, and what can be done about it; the first call imports it."""
    if _Process.lost_its_threads:
        remedy = "Start processes by spawn, or let this one's parent do without it."
        return "in a process forked from one that has used Numba's threads", remedy
    if _compiled(_Process.keeps_code) is not None:
        return None
    if importlib.util.find_spec("numba") is not None:
        return "where Numba does not compile", "Unset NUMBA_DISABLE_JIT, or see whether `import numba` fails."
    remedy = 'pip install "pvphong[fast]" installs it; backend="auto" does without where it is missing.'
    return "where Numba is not installed", remedy


def is_available() -> bool:
    """Whether Numba can be imported and used in this process; the first call imports it."""
    return obstacle() is None


def keeps_code() -> bool:
    """Whether compiled code is on disk after the first time: else each process would compile anew."""
    return is_available() and _Process.keeps_code


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


def shade(
    points: FloatArray,
    normals: FloatArray,
    equation: Equation,
    albedo: FloatArray | None,
    result: Shading,
    whole: Equation | None = None,
) -> bool:
    """Evaluate the equation at every vertex into `result.rgb`, or decline.

    Numba's settings choose the number of threads; the result does not depend on it, to the bit. Arrays that are
    not C-contiguous are copied piece by piece and give the same bits; so are float32 beside float64, as float64.

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
    if result.base is not None or not rgb.flags.c_contiguous or not records.fits(whole) or not is_available():
        return False
    real = np.dtype(np.float64 if rgb.dtype == np.float64 else np.float32)
    read = [points] * whole.needs_points + [normals] * whole.needs_normals
    stored = np.result_type(real, *read)
    is_wide = stored != real
    settings = records.settings(equation, is_wide=is_wide, has_albedo=albedo is not None)
    terms = records.terms(equation)
    vertices = [
        (points if equation.needs_points else None, stored),
        (normals if equation.needs_normals else None, stored),
    ]
    for part in _parts([*vertices, (albedo, real)], len(rgb)):
        arrays = [_flat(array, dtype, part) for array, dtype in vertices]
        shades = None if albedo is None else albedo[part]
        if shades is not None and shades.dtype != real:
            shades = reflectances(shades)  # the kernel clips what it gets, but this may not even fit its type
        arrays.append(_flat(shades, real, slice(None)))
        out = rgb[part].reshape(-1)
        nothing = np.empty(0, real if rgb.dtype == np.uint8 else np.uint8)
        targets = (nothing, out) if rgb.dtype == np.uint8 else (out, nothing)
        _run(*arrays, *targets, settings, terms, len(rgb[part]), np.empty(0))
    _Process.real_types[stored] = real
    return True


def find_bounds(rows: FloatArray) -> tuple[Float64Array, Float64Array] | None:
    """Least and greatest entry of each column, shape (3,), NaN where any is not finite; or None.

    None where NumPy is to look for them: for few rows, and where the code for their type has not run in this process.
    """
    real = _Process.real_types.get(rows.dtype)
    if len(rows) < _SEARCHED or real is None or not _is_plain(rows, rows.dtype) or not is_available():
        return None
    vertices, nothing = _flat(rows, rows.dtype, slice(None)), _flat(None, rows.dtype, slice(None))
    found = np.empty((-(-len(rows) // GROUP), 6))
    no_equation = np.zeros(0, records.SETTINGS), np.zeros(0, records.TERM)
    colors = np.empty(0, real), np.empty(0, np.uint8)
    _run(vertices, nothing, _flat(None, real, slice(None)), *colors, *no_equation, len(rows), found.reshape(-1))
    return found[:, :3].min(axis=0), found[:, 3:].max(axis=0)


def _parts(inputs: list[tuple[FloatArray | None, np.dtype[Any]]], count: int) -> Iterator[slice]:
    """All vertices at once where no array has to be copied, else pieces."""
    ready = all(array is None or _is_plain(array, dtype) for array, dtype in inputs)
    step = max(count, 1) if ready else COPIED
    return (slice(start, min(start + step, count)) for start in range(0, count, step))


def _is_plain(array: FloatArray, dtype: np.dtype[Any]) -> bool:
    return array.dtype == dtype and array.flags.c_contiguous and array.flags.aligned


def _flat(array: FloatArray | None, dtype: np.dtype[Any], part: slice) -> FloatArray:
    """A flat read-only view, or copy: read-only always, because Numba compiles anew for the other kind."""
    if array is None:
        return _nothing(dtype)
    rows = array[part]
    if not _is_plain(rows, dtype):
        rows = np.require(rows, dtype, ["C", "A"])
    flat = rows.reshape(-1)
    flat.flags.writeable = False
    return flat


@functools.cache
def _nothing(dtype: np.dtype[Any]) -> FloatArray:
    return _flat(np.empty((0, 3), dtype), dtype, slice(0))


def _run(*arguments: Any) -> None:
    compiled: Any = _compiled(_Process.keeps_code)
    assert compiled is not None
    _Process.has_run = True
    try:
        with _Process.one_at_a_time:
            compiled(*arguments)
    except Exception:  # of whatever kind a damaged file of kept code raises when it is read, or a full disk
        if not _Process.keeps_code:
            raise
        if _Process.has_mended:
            _Process.keeps_code = False  # what is wrong with the arguments is wrong without kept code too
        else:
            _Process.has_mended = True
            with contextlib.suppress(OSError):
                compiled._cache.flush()  # private, but Numba has no other way to forget what is on disk
        _run(*arguments)


@functools.cache
def _compiled(keeps_code: bool) -> Callable[..., None] | None:
    """The compiled function, with its code kept on disk where that is possible; None without Numba."""
    try:
        from numba import config

        from pvphong.shading.kernel.blocks import compile_shade
    except ImportError:
        return None
    if config.DISABLE_JIT:
        return None
    try:
        return compile_shade(cache=keeps_code)
    except RuntimeError:  # Numba found no folder that it can write to
        _Process.keeps_code = False
        return compile_shade(cache=False)
