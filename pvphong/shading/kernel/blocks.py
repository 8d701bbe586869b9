"""One block of vertices through the passes that its equation calls for, and all blocks in parallel.

The equation comes as records, so that its values are arguments of compiled code: moving or tinting a light
compiles nothing. What the kernel branches on, it branches on once per block.
"""

from __future__ import annotations

import inspect
import zlib
from collections.abc import Callable
from typing import Any

import numba
import numpy as np

from pvphong.base.ranges import BRIGHTEST
from pvphong.shading.kernel import (
    ahead,
    arithmetic,
    colors,
    extremes,
    loading,
    passes,
    records,
    rescue,
    sunlight,
    vectors,
)
from pvphong.shading.kernel import rows as at
from pvphong.shading.kernel.arithmetic import inlined, plain
from pvphong.shading.kernel.records import BLINN_PHONG, HEADLIGHT, NO_HIGHLIGHT, PHONG
from pvphong.shading.kernel.rows import BLOCK, GROUP, LINE
from pvphong.shading.kernel.vectors import in_type


@numba.njit
def _scratch(length: int, like: Any) -> Any:
    """Memory that starts where a cache line starts: a vector across two lines takes twice as long."""
    memory = np.empty(length + LINE // like.itemsize, like.dtype)
    start = -memory.ctypes.data % LINE // like.itemsize
    return memory[start : start + length]


@inlined
def _load_normals(array: Any, start: int, count: int, s: Any, rows: Any, wide: Any) -> None:
    if s.turns_normals:
        loading.split(array, start, count, wide)
        loading.rotate_normals(s.normal_matrix, wide, rows)
    else:
        loading.split(array, start, count, rows[at.NX :])
    if not loading.measure_normals(rows):
        rescue.rescue_normals(array, start, count, s.normal_matrix, s.turns_normals, rows)
        loading.measure_normals(rows)


@inlined
def _load_points(array: Any, start: int, count: int, s: Any, rows: Any, wide: Any) -> None:
    if not s.is_wide:
        loading.split(array, start, count, rows[at.PX :])
        return
    loading.split(array, start, count, wide)
    if s.moves_points and not loading.transform(s.matrix, s.w, wide):
        rescue.rescue_points(array, start, count, s.matrix, s.w, wide)


@inlined
def _in_two(rows: Any, position: Any) -> Any:
    """A float64 position as a sum of two numbers of the rows' type for each coordinate."""
    real = rows.dtype.type
    x, y, z = in_type(position, rows)
    return x, y, z, real(position[0] - x), real(position[1] - y), real(position[2] - z)


@plain
def _approach(position: Any, s: Any, rows: Any, wide: Any) -> bool:
    """Rays from the vertices to a position; whether any of them was rescued."""
    x, y, z = position[0], position[1], position[2]
    if s.is_wide:
        if passes.approach_wide(wide, x, y, z, rows):
            return False
        rescue.rescue_rays(wide, x, y, z, rows)
    else:
        if passes.approach(rows, *_in_two(rows, position)):
            return False
        rescue.rescue_rays(rows[at.PX :], x, y, z, rows)
    passes.measure_rays(rows)
    return True


@plain
def _find_strength(t: Any, is_rescued: bool, rows: Any) -> None:
    real = rows.dtype.type
    passes.attenuate(rows, real(t.constant), real(t.linear), real(t.quadratic), real(t.gain))
    if is_rescued:
        rescue.mend_strength(rows, t.constant, t.linear, t.quadratic, t.gain, t.on_light)
    if t.has_cone:
        passes.find_cone(rows, *in_type(t.axis, rows), real(t.edge))
        passes.raise_shine(rows, real(t.exponent), real(-np.inf), real(t.dark))
        passes.apply_cone(rows)
    if t.has_ambient:
        passes.add_strength(rows, *in_type(t.ambient, rows))


@inlined
def _add_dull(t: Any, s: Any, rows: Any, wide: Any) -> None:
    """Add the light of one that has no highlights."""
    color = in_type(t.diffuse, rows)
    if t.is_parallel:
        passes.add_parallel(rows, *color, *in_type(t.position, rows))
        return
    is_rescued = _approach(t.position, s, rows, wide)
    if t.varies:
        _find_strength(t, is_rescued, rows)
        passes.add_weakened(rows, *color)
    else:
        passes.add_lambert(rows, *color)


@inlined
def _find_highlight(t: Any, s: Any, rows: Any, wide: Any) -> bool:
    """Factors of a light with highlights; whether any vertex has one."""
    real = rows.dtype.type
    dark = real(s.dark)
    if t.is_parallel:
        passes.fill(rows[at.DX :], *in_type(t.position, rows))
        passes.measure_rays(rows)
    else:
        is_rescued = _approach(t.position, s, rows, wide)
        if t.varies:
            _find_strength(t, is_rescued, rows)
    if t.highlight == PHONG:
        return passes.phong(rows, dark)
    if t.highlight == BLINN_PHONG:
        return passes.blinn_phong(rows, dark)
    passes.headlight(rows, real(s.floor))
    return True


@inlined
def _add_light(t: Any, s: Any, has_unseen: bool, has_albedo: bool, rows: Any, wide: Any) -> None:
    real = rows.dtype.type
    if not t.needs_normals:  # all it has is ambient light
        if t.varies:
            _find_strength(t, _approach(t.position, s, rows, wide), rows)
        return
    if t.highlight == NO_HIGHLIGHT:
        _add_dull(t, s, rows, wide)
        return
    shines = _find_highlight(t, s, rows, wide)
    if shines:
        passes.raise_shine(rows, real(s.shininess), real(s.log_floor), real(s.dark))
        if has_unseen and t.highlight != HEADLIGHT:
            rescue.hide_unseen(rows)
    if t.varies:
        passes.apply_strength(rows)
    if shines and not has_albedo:
        passes.add_both(rows, *in_type(t.diffuse, rows), *in_type(t.specular, rows))
        return
    passes.add_matt(rows, *in_type(t.diffuse, rows))
    if shines:
        passes.add_highlight(rows, *in_type(t.specular, rows))


@inlined
def _light(
    first: int,
    count: int,
    points: Any,
    normals: Any,
    albedo: Any,
    rgb: Any,
    display: Any,
    s: Any,
    terms: Any,
    rows: Any,
    wide: Any,
) -> None:
    """Colours of one block's vertices, in its rows."""
    has_albedo, has_unseen = len(albedo) > 0, False
    if s.needs_normals:
        _load_normals(normals, first, count, s, rows, wide)
    if s.needs_points:
        _load_points(points, first, count, s, rows, wide)
    if s.needs_eye:
        has_unseen = _approach(s.eye, s, rows, wide)
        passes.look(rows)
    if s.is_flipped:
        if s.has_local_facing:
            passes.turn_to_viewer(rows)
        else:
            passes.turn_to_axis(rows)
    if s.has_phong:
        passes.face(rows)
    passes.fill(rows, *in_type(s.base, rows))
    if has_albedo:
        passes.fill(rows[at.HR :], *in_type(s.emission, rows))
    for turn, t in enumerate(terms):
        ahead.ask(turn, first + BLOCK, points, normals, rgb, display)
        _add_light(t, s, has_unseen, has_albedo, rows, wide)
    if has_albedo:
        loading.split(albedo, first, count, rows[at.ALBEDO_R :])
        colors.tint(rows)


@inlined
def _store(first: int, count: int, rgb: Any, display: Any, s: Any, rows: Any) -> None:
    """Colours from one block's rows to where they are wanted."""
    real = rows.dtype.type
    if len(rgb):
        colors.join(rows, real(s.low), real(s.high), rgb, first, count)
    if len(display):
        colors.join_bytes(rows, display, first, count)


@plain
def _shade_group(
    start: int,
    stop: int,
    points: Any,
    normals: Any,
    albedo: Any,
    rgb: Any,
    display: Any,
    settings: Any,
    terms: Any,
    rows: Any,
    wide: Any,
) -> None:
    s = settings[0]
    is_sunlit = s.is_sunlit and len(rgb) > 0
    is_even = not (s.needs_normals or s.needs_points or len(albedo))
    passes.fill(rows[at.VX :], *in_type(s.to_eye, rows))
    passes.fill(rows[at.AX :], *in_type(s.to_eye, rows))
    for first in range(start, stop, BLOCK):
        count = min(stop - first, BLOCK)
        if is_sunlit and count == BLOCK and sunlight.shine_on(normals, first, s, terms[0], rgb):
            continue
        if first == start or not is_even:  # else every block is like the first one
            _light(first, count, points, normals, albedo, rgb, display, s, terms, rows, wide)
        _store(first, count, rgb, display, s, rows)


def _checksum() -> int:
    files = (at, arithmetic, vectors, loading, ahead, sunlight, passes, rescue, colors, extremes, records)
    try:
        sources = [inspect.getsource(file) for file in files]
    except OSError as error:
        raise RuntimeError("without sources there is no telling whether kept code is of today") from error
    return zlib.crc32("".join([*sources, repr(BRIGHTEST)]).encode())


def compile_shade(*, cache: bool) -> Callable[..., None]:
    """The compiled function that shades all vertices; it compiles for each combination of types on first use.

    Numba's disk cache asks only whether the file of the cached function itself has changed; the checksum makes
    the other files count too, because the values that a function closes over are part of its key.

    Parameters
    ----------
    cache : bool
        Whether compiled code is kept on disk.

    Raises
    ------
    RuntimeError
        If it is to be kept and Numba finds no folder that it can write to, or there are no sources.
    """
    checksum = _checksum() if cache else 0

    @numba.njit(parallel=True, error_model="numpy", cache=cache)
    def shade(
        points: Any,
        normals: Any,
        albedo: Any,
        rgb: Any,
        display: Any,
        settings: Any,
        terms: Any,
        count: int,
        found: Any,
    ) -> None:
        _ = checksum
        for group in numba.prange((count + GROUP - 1) // GROUP):
            start, stop = group * GROUP, min(group * GROUP + GROUP, count)
            if len(found):  # here, because this function is at hand: one of its own would take seconds to compile
                extremes.find_extremes(points, start, stop, _scratch(extremes.ROWS, points), found[6 * group :])
            else:
                rows, wide = _scratch(at.ROWS, rgb), _scratch(3 * BLOCK, np.empty(0, np.float64))
                _shade_group(start, stop, points, normals, albedo, rgb, display, settings, terms, rows, wide)

    return shade
