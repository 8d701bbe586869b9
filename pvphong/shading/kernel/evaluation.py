"""Evaluation by compiled code: the driver runs over arrays of vertices on several threads."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numba
import numpy as np
from numba import types

from pvphong.base import threads
from pvphong.base.types import BoolArray, FloatArray
from pvphong.optics.maps import COLORS, fractions
from pvphong.optics.reflectance import Lobe
from pvphong.shading.equation import Equation
from pvphong.shading.kernel import code, driver, records
from pvphong.shading.kernel.code import Library, NotCompiled, Request
from pvphong.shading.kernel.vertices import BLOCK, ROWS
from pvphong.shading.reference import Shading
from pvphong.shading.reference import shade as shade_by_reference
from pvphong.shading.vertices import Tint

# Least and greatest number of vertices per call in a thread: enough that the cost of a call is negligible, and few
# enough that converted copies of arrays are small.
SHORTEST, LONGEST = 2**14, 2**18

# Index of the diffuse map among the inputs: points, normals, then maps in the order of `COLORS`. If colours of lobes
# are blends (see `records.blends`), factors of the first two lobes take the places of diffuse and specular.
_FIRST_LOBE = 2 + COLORS.index("diffuse")

# Bytes in a cache line, and in the longest vectors.
_LINE = 64


def shade(
    library: Library,
    points: FloatArray,
    normals: FloatArray,
    equation: Equation,
    tints: Mapping[str, Tint],
    result: Shading,
    whole: Equation | None = None,
    *,
    channels: FloatArray | None = None,
    waits: bool = True,
) -> bool:
    """Evaluate the equation at every vertex, and write the colours into the arrays of `result`.

    Return False to decline.
    The bits of the result do not depend on the number of threads. Arrays that are not C-contiguous are copied piece by
    piece; this does not change the bits of the result. If only one of points and normals is float64, the other is
    converted to float64.

    Parameters
    ----------
    library : Library
        The library that keeps compiled code.
    points, normals : ndarray
        Shape (n, 3), float32 or float64, of any memory layout.
    equation : Equation
        The equation.
    tints : mapping
        Result of `Vertices.tints`: the maps of colours.
    result : Shading
        Receives the colours. `rgb` must be C-contiguous and is overwritten. Its type is float32, float64 or uint8. With
        uint8, arithmetic is in float32, and colours are rounded to 0-255 for display. Components, if present, are
        overwritten too, except that those to which the equation adds nothing must be zeros, as `Shading.empty` makes
        them; with uint8 there must be none.
    whole : Equation, optional
        The equation before a plan simplified it; by default `equation`. It determines whether the kernel declines, and
        the type in which vertices are read. So neither depends on the positions of other vertices.
    channels : ndarray, optional
        Shape (k, n): further numbers per vertex, with rows as in `equation.channels`.
    waits : bool, default True
        True to compile missing code now, which takes seconds. If False, the equation is declined, and another process
        compiles the code for later calls.

    Returns
    -------
    bool
        False if the equation was declined and nothing was written.
    """
    rgb, whole = result.rgb, whole or equation
    if not rgb.flags.c_contiguous:
        return False
    real = np.dtype(np.float64 if rgb.dtype == np.float64 else np.float32)
    codes = records.codes_of(whole, name_of(real))
    shown, apart = equation, None if result.base is None else _apart(equation, result)
    if apart is not None:
        equation = replace(equation, terms=tuple(term for share in apart.shares for term in share.terms))
    if codes is not None and equation is not whole:
        codes = records.codes_of(equation, name_of(real))
    if codes is None:
        return False
    # the equation of a white sky may read arrays that the whole equation does not
    read = [points] * (whole.needs_points or equation.needs_points)
    read += [normals] * (whole.needs_normals or equation.needs_normals)
    stored = np.result_type(real, *read)
    request = Request(equation, name_of(stored), name_of(real))
    source = library if waits else library.cached_only
    try:
        run = driver_code(source, request.stored, request.real)
        packed = records.records_of(
            equation,
            codes,
            source,
            request.stored,
            request.real,
            tints,
            is_display=rgb.dtype == np.uint8,
            channel_length=len(rgb),
            apart=apart,
        )
    except NotCompiled as missing:
        code.ask_for(missing.key, request, library.lock)
        return False
    if channels is not None:
        channels = np.ascontiguousarray(channels, real)

    is_blend = records.blends(equation, tints)
    readers = [
        _reader(points if equation.needs_points else None, stored),
        _reader(normals if equation.needs_normals else None, stored),
        *(_color_reader(tints.get(name), real) for name in COLORS),
    ]
    begin_of_channels, begin_of_rgb = address(channels), address(rgb)

    def work(first: int, last: int) -> None:
        part = slice(first, last)
        read = [reader(part) for reader in readers]
        seen = None if channels is None else channels[:, part]
        left_out = None
        if is_blend:
            rows = equation.channels.get("metallic")
            maps = {} if rows is None or seen is None else {"metallic": seen[rows][0]}
            at = {name: tint.at(part) for name, tint in tints.items()}
            *factors, left_out = _of_lobes(equation.reflectance.lobes, at, maps, last - first, real)
            read[_FIRST_LOBE : _FIRST_LOBE + 2] = [(address(rows), rows) for rows in factors]
        addresses = *(begin for begin, _ in read), begin_of_channels + first * real.itemsize
        out = begin_of_rgb + first * rgb.strides[0]
        declined, has_none = _memory.declined[: last - first], False
        try:
            has_none = bool(run(*addresses, out, out, *packed, last - first, *_memory.addresses))
            if has_none and left_out is None:
                return
            left = np.flatnonzero(declined if left_out is None else declined | left_out)
        finally:
            if not has_none:
                declined[:] = 0
        lit = Shading.empty(len(left), equation.lights, real, None if apart is None else shown)
        own_tints = {name: tint.at(part).at(left) for name, tint in tints.items()}
        seen = None if seen is None else seen[:, left]
        shade_by_reference(points[part][left], normals[part][left], shown, own_tints, lit, seen)
        if rgb.dtype == np.uint8:
            rgb[part][left] = np.rint(np.clip(lit.rgb, 0.0, 1.0) * 255.0)
            return
        for name, array in vars(lit).items():
            if array is not None:
                getattr(result, name)[..., part, :][..., left, :] = array

    with threads.shared(work, len(rgb), SHORTEST, LONGEST) as ranges:
        for first, last in ranges:
            work(first, last)
    Library.has_run = True
    return True


def _apart(equation: Equation, result: Shading) -> records.Apart | None:
    """Return the shares of an equation and the offsets at which `result` stores them.

    A share is one component of a light's contribution. Return None if the result has no components, or if the equation
    has no shares because all are black.
    """
    shares, rgb = equation.shares, result.rgb
    if result.base is None or result.per_light is None or not shares:
        return None

    def offset(array: FloatArray | None) -> int:
        return (address(array) - address(rgb)) // rgb.itemsize

    used = {share.component for share in shares}
    components = [offset(getattr(result, name)) if name in used else 0 for name in records.COMPONENTS]
    own: dict[int | None, int] = {None: offset(result.base)}
    return records.Apart(shares, own | dict(enumerate(map(offset, result.per_light))), components)


def _of_lobes(
    lobes: Sequence[Lobe], tints: Mapping[str, Tint], maps: Mapping[str, FloatArray], count: int, real: Any
) -> tuple[FloatArray, FloatArray, BoolArray | None]:
    """Return the factors by which maps multiply the colours of the first two lobes, and the vertices to leave out.

    Parameters
    ----------
    lobes
        The three lobes of the reflectance.
    tints
        Maps of colours, by field.
    maps
        Maps of the reflectance's fields, shape (n,) each.
    count : int
        Number n of vertices.
    real
        Type of the factors, a NumPy type.

    Returns
    -------
    first, second : ndarray
        Shape (n, 3). The first lobe's factors exclude the albedo, by which compiled code multiplies.
    left_out : ndarray or None
        Shape (n,): True where the third lobe's factor is not 1, so that the reference must light the vertex. None if
        there is no such vertex.
    """
    of: dict[str, Any] = {name: tints[name].factors(real.type) for name in ("albedo", "diffuse") if name in tints}
    albedo = of.get("albedo", np.ones((3, count), real.type))
    base, first, second = [
        lobe.tint(albedo * of.get("diffuse", real.type(1.0)), maps) for lobe in lobes if lobe.tint is not None
    ]
    base = np.divide(base, albedo, out=np.zeros((3, count), real), where=albedo > 0.0)
    is_left = np.broadcast_to(np.abs(second[0] - 1.0) > 8.0 * np.finfo(real).eps, count)  # grey
    return as_contiguous(base.T, real), as_contiguous(first.T, real), is_left if is_left.any() else None


def _reader(array: FloatArray | None, dtype: Any) -> Callable[[slice], tuple[int, FloatArray | None]]:
    """Return a function that makes the rows of an array in a slice readable for compiled code.

    The function takes a slice. It returns the address of these rows, C-contiguous and of the type `dtype`, and the
    object that keeps the rows alive: the array itself or a copy of the rows. If `array` is None, it returns 0 and None.
    """
    if array is None:
        return _nothing
    if array.dtype == dtype and array.flags.c_contiguous and array.flags.aligned:
        begin, step = address(array), array.strides[0]
        return lambda part: (begin + part.start * step, array)

    def copy(part: slice) -> tuple[int, FloatArray]:
        copied = as_contiguous(array[part], dtype)
        return address(copied), copied

    return copy


def _color_reader(tint: Tint | None, real: Any) -> Callable[[slice], tuple[int, FloatArray | None]]:
    """Return a function that makes the colours of a map in a slice readable for compiled code.

    The function takes a slice. It returns the address of these colours, and the array (n, 3) that holds them. If `tint`
    is None, it returns 0 and None. `real` is the type of the colours.
    """
    if tint is None:
        return _nothing

    def copy(part: slice) -> tuple[int, FloatArray]:
        colors = map_colors(tint.at(part), real)
        return address(colors), colors

    return copy


def _nothing(_part: slice) -> tuple[int, None]:
    return 0, None


def map_colors(tint: Tint, real: Any) -> FloatArray:
    """Return the colours of a map, shape (n, 3), C-contiguous and of the type `real`, as compiled code reads them.

    Albedos are not clipped to [0, 1]; compiled code does that.
    """
    rows = tint.rows if tint.rows.dtype == real else fractions(tint.name, tint.rows, real)
    return as_contiguous(rows if rows.shape[1] == 3 else np.broadcast_to(rows, (len(rows), 3)), real)


def driver_code(library: Library, stored: str, real: str) -> Callable[..., int]:
    """Return the compiled driver. `stored` is the type of the vertices, and `real` the type of the arithmetic."""

    def signature(stored: Any, real: Any) -> Any:
        vertices, reals, floats, octets = map(types.CPointer, (stored, real, types.float64, types.uint8))
        settings, terms = (types.CPointer(numba.from_dtype(kind)) for kind in (records.SETTINGS, records.TERM))
        arrays = vertices, vertices, reals, reals, reals, reals, reals, reals, octets
        return types.boolean(*arrays, settings, terms, floats, types.intp, reals, floats, octets)

    return library.call(driver.shade, signature, stored, real)


class _Memory(threading.local):
    """Scratch memory of each thread: rows, three rows in float64, and flags of declined vertices, initially 0.

    Rows are aligned to cache lines, because a vector across two lines takes twice as long.
    """

    def __init__(self) -> None:
        self._memory = np.empty(ROWS + 3 * BLOCK + _LINE // 8)
        start = address(self._memory) + -address(self._memory) % _LINE
        self.declined = np.zeros(LONGEST, np.uint8)
        self.addresses = start, start + 8 * ROWS, address(self.declined)


def address(array: Any) -> int:
    """Return the address of an array's data; 0 for None."""
    return 0 if array is None else int(array.ctypes.data)


_memory = _Memory()


@functools.cache
def name_of(kind: np.dtype[Any]) -> str:
    """Return a type's name, cached because NumPy needs microseconds to build it."""
    return kind.name


def as_contiguous(array: FloatArray, dtype: Any) -> FloatArray:
    """Return the array itself if it is C-contiguous, aligned and of the type `dtype`. If not, return a copy that is."""
    return np.require(array, dtype, ["C", "A"])
