"""The fused evaluator: the same equation as `reference.py`, compiled by Numba, parallel and vectorised.

Numba is an optional extra. It is imported when the kernel is first asked for, and what it compiles is kept on disk. Who
does not want to wait for a compiler is declined until the code is there, and a process of its own makes it meanwhile.
What cannot be run here is declined too, cheaply, and belongs to the reference: component arrays are wanted, a light or
reflectance has no stage, a scene coordinate lies beyond 2¹⁰⁰, an attenuation or a matrix has an entry that is not
between that and 2⁻¹⁰⁰, or a light is brighter than its stage takes.
Single vertices are declined too, and the reference lights those: on a light or the eye, not finite, or so far from a
light or so near it that float32 does not hold the products.

The kernel differs from the reference by rounding alone. float32 results come from float32 arithmetic, geometry
included: differences of positions have full relative precision however far the scene is from the origin, and a
highlight errs by at most (4√n + 10) · 2⁻²⁴ for shininess n.

Where to look: `driver` lights block after block and calls the stages, which lights and reflectances write with the
names in `toolkit`; `caps` and `sides` have what they need for lights with a size; `ways` has what concerns directions
and distances, attenuation included; `records` is the form in which it takes an equation; `facets` sums the normals of
meshes, which `normals` shares out; `running` calls compiled code, on the threads of `pool`; `keeping` compiles, `store`
has the code on disk, `compiling` knows all that there is to compile, and `background` has another process do it.
"""

from __future__ import annotations

import functools
import importlib.util
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, get_args

import numpy as np
from numpy.typing import NDArray

from pvphong.base import check
from pvphong.base.types import Backend, Float64Array, FloatArray, Weighting
from pvphong.shading.albedo import reflectances
from pvphong.shading.equation import Equation
from pvphong.shading.kernel import normals as over_faces
from pvphong.shading.kernel import pool
from pvphong.shading.kernel.background import NotCompiled, Request, ask_for
from pvphong.shading.kernel.running import Call, Memory, address, is_plain, parts, ready
from pvphong.shading.reference import shade as light_by_reference
from pvphong.shading.result import Shading

if TYPE_CHECKING:
    from pvphong.shading.kernel.keeping import Library
    from pvphong.shading.kernel.terms import Codes

# Vertices that a thread searches for bounds at a time.
_SEARCHED = 2**17
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


def check_backend(backend: Any) -> None:
    """Raise ``ValueError`` for another backend, or for Numba where it cannot be used."""
    reason = obstacle() if check.choice("backend", backend, get_args(Backend)) == "numba" else None
    if reason is not None:
        where, remedy = reason
        check.refuse("backend", backend, f"'auto' or 'numpy' {where}", remedy)


def has_run() -> bool:
    """Whether compiled code has run in this process."""
    return _Process.has_run


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


class CannotCompile(Exception):
    """Why no code can be compiled in advance, and what can be done about it."""


def compile_all(report: Callable[[str, int, int], object]) -> Path:
    """Compile all code for pvphong's own lights and reflectances, or read what is there; the folder where it is kept.

    Parameters
    ----------
    report : callable
        Is given each piece's name before it is compiled, how many are done, and how many there are.

    Raises
    ------
    CannotCompile
        Without Numba, or where code cannot be kept.
    """
    library = _library()
    if library is None:
        where, remedy = obstacle() or ("", "")
        raise CannotCompile(f"nothing can be compiled {where}. {remedy}")
    from pvphong.shading.kernel.compiling import is_kept, pieces

    folder = library.folder
    if folder is None:
        remedy = "Set NUMBA_CACHE_DIR to a folder that can be written to."
        raise CannotCompile(f"there is no folder to keep compiled code in: neither pvphong's nor your own. {remedy}")
    todo = pieces(library)
    for done, piece in enumerate(todo):
        report(piece.name, done, len(todo))
        piece.compile()
    if not is_kept():
        raise CannotCompile(f"compiled code could not be written to {folder}: see whether there is room.")
    return folder


def shade(
    points: FloatArray,
    normals: FloatArray,
    equation: Equation,
    albedo: FloatArray | None,
    result: Shading,
    whole: Equation | None = None,
    *,
    channels: FloatArray | None = None,
    waits: bool = True,
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
    channels : ndarray, optional
        Shape (k, n): what `equation.channels` says.
    waits : bool, default True
        Whether code that is missing is compiled now, which takes seconds. If not, the equation is declined, and another
        process compiles it for later calls.

    Returns
    -------
    bool
        False if the equation was declined and nothing was written.
    """
    rgb, whole = result.rgb, whole or equation
    library = _library()
    if result.base is not None or not rgb.flags.c_contiguous or library is None:
        return False
    from pvphong.shading.kernel import records

    real = np.dtype(np.float64 if rgb.dtype == np.float64 else np.float32)
    codes = records.codes_of(whole, _name_of(real), has_albedo=albedo is not None)
    if codes is None:
        return False
    read = [points] * whole.needs_points + [normals] * whole.needs_normals
    stored = np.result_type(real, *read)
    request = Request(equation, _name_of(stored), _name_of(real))
    if channels is not None:
        channels = np.ascontiguousarray(channels, real)
    call = _prepared(
        request,
        codes,
        library,
        waits,
        has_albedo=albedo is not None,
        is_display=rgb.dtype == np.uint8,
        channel_length=len(rgb),
    )
    if call is None:
        return False
    vertices = [
        (points if equation.needs_points else None, stored),
        (normals if equation.needs_normals else None, stored),
    ]
    for part in parts([*vertices, (albedo, real)], len(rgb)):
        shades = None if albedo is None else albedo[part]
        if shades is not None and shades.dtype != real:
            shades = reflectances(shades)  # the kernel clips what it gets, but this may not even fit its type
        arrays = [*(None if array is None else array[part] for array, _ in vertices), shades]
        plain = [ready(array, dtype) for array, dtype in zip(arrays, (stored, stored, real), strict=True)]
        seen = None if channels is None else channels[:, part]
        for rows in call.light([*plain, seen, rgb[part]]):
            _light_declined(points[part], normals[part], shades, equation, rgb[part], rows, seen)
    _Process.has_run = True
    return True


@functools.cache
def _name_of(kind: np.dtype[Any]) -> str:
    return kind.name  # NumPy takes microseconds to put it together


def _prepared(request: Request, codes: Codes, library: Library, waits: bool, **flags: Any) -> Call | None:
    """Driver and records for a request; None if there is no code, which another process then compiles."""
    source = library if waits else library.at_hand
    from pvphong.shading.kernel import records

    equation, stored, real = request
    try:
        driver = source.driver(stored, real)
        return Call(driver, records.records_of(equation, codes, source, real, is_wide=stored != real, **flags))
    except NotCompiled as missing:
        ask_for(missing.key, request, library.lock)
        return None


def _light_declined(
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
    light_by_reference(points[rows], normals[rows], equation, shades, lit, seen)
    rgb[rows] = np.rint(np.clip(lit.rgb, 0.0, 1.0) * 255.0) if rgb.dtype == np.uint8 else lit.rgb


def find_bounds(rows: FloatArray) -> tuple[Float64Array, Float64Array] | None:
    """Least and greatest entry of each column, shape (3,), NaN where any is not finite; or None.

    None where NumPy is to look for them: for few rows, and where compiled code has not run in this process.
    """
    library = _library() if _Process.has_run and len(rows) >= _MANY else None
    if library is None or rows.dtype not in (np.float32, np.float64) or not is_plain(rows, rows.dtype):
        return None
    try:
        search = library.at_hand.extremes(_name_of(rows.dtype))
    except NotCompiled as missing:
        ask_for(missing.key, None, library.lock)
        return None
    found = np.full((-(-len(rows) // _SEARCHED), 6), np.nan)

    def work(first: int, last: int) -> None:
        low_and_high = np.empty(6)
        if search(address(rows), first, last, Memory.of_thread().addresses[0], address(low_and_high)):
            found[first // _SEARCHED] = low_and_high

    pool.run(work, len(rows), _SEARCHED)
    return found[:, :3].min(axis=0), found[:, 3:].max(axis=0)


def point_normals(
    points: FloatArray, connectivity: NDArray[Any], offsets: NDArray[Any], weighting: Weighting, *, waits: bool = True
) -> Float64Array | None:
    """Unit normals of a mesh's points, as `pvphong.geometry.normals.point_normals` has them; or None.

    They differ from those by rounding alone; renumbering the points changes no bit, nor does the number of threads.
    None where NumPy is to compute them, or to refuse the mesh.

    Parameters
    ----------
    points : ndarray
        Shape (n, 3), float32 or float64, of any memory layout.
    connectivity, offsets : ndarray
        One-dimensional, of integers.
    weighting : {"angle", "area", "max"}
        As for the NumPy form.
    waits : bool, default True
        As for `shade`.
    """
    library = _library()
    if library is None:
        return None
    source = library if waits else library.at_hand
    try:
        survey, find = source.survey(), source.normals()
    except NotCompiled as missing:
        ask_for(missing.key, None, library.lock)
        return None
    result = over_faces.point_normals(points, connectivity, offsets, weighting, survey, find)
    _Process.has_run = True
    return result
