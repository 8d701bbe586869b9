"""One block of vertices through the passes that its equation calls for, and all blocks in parallel.

The equation comes as records, so that its values are arguments of compiled code: moving or tinting a light
compiles nothing. What the kernel branches on, it branches on once per block.
"""

from __future__ import annotations

import inspect
import zlib
from collections.abc import Callable
from typing import Any, NamedTuple

import numba
import numpy as np

from pvphong import _kernel_math, _kernel_passes, _kernel_rescue
from pvphong import _kernel_passes as passes
from pvphong import _kernel_rescue as rescue
from pvphong._kernel_math import plain
from pvphong._kernel_passes import BLOCK, X
from pvphong._kernel_records import BLINN_PHONG, HEADLIGHT, NO_HIGHLIGHT, PHONG

# Vertices per unit of parallel work: enough that its scratch memory costs nothing.
GROUP = 32 * BLOCK


# Bytes in a line of the processor's caches, and in the longest vectors.
LINE = 64


class Scratch(NamedTuple):
    """The rows of one block, in the precision of the result where nothing else is said."""

    points: Any
    wide: Any
    """float64 points, where float32 would lose digits: after a transform, or from a float64 array."""
    normals: Any
    viewer: Any
    facing: Any
    ray: Any
    exponents: Any
    """int64: powers of two taken out of the rays, where any ray was rescued."""
    factors: Any
    colors: Any
    highlights: Any
    """What the albedo does not multiply; the same rows as `colors` where there is none."""
    albedo: Any


@plain
def _aligned(length: int, like: Any) -> Any:
    """Memory that starts where a cache line starts: a vector across two lines takes twice as long."""
    memory = np.empty(length + LINE // like.itemsize, like.dtype)
    start = -memory.ctypes.data % LINE // like.itemsize
    return memory[start : start + length]


@plain
def _scratch(like: Any, has_albedo: bool) -> Scratch:
    rows = _aligned(29 * BLOCK, like)
    colors = rows[: 3 * BLOCK]
    return Scratch(
        colors=colors,
        highlights=rows[3 * BLOCK : 6 * BLOCK] if has_albedo else colors,
        factors=rows[6 * BLOCK : 9 * BLOCK],
        points=rows[9 * BLOCK : 12 * BLOCK],
        normals=rows[12 * BLOCK : 17 * BLOCK],
        viewer=rows[17 * BLOCK : 20 * BLOCK],
        facing=rows[20 * BLOCK : 23 * BLOCK],
        ray=rows[23 * BLOCK : 26 * BLOCK],
        albedo=rows[26 * BLOCK : 29 * BLOCK],
        wide=_aligned(3 * BLOCK, np.empty(0, np.float64)),
        exponents=np.empty(BLOCK, np.int64),
    )


@plain
def _load_normals(array: Any, s: Any, b: Scratch) -> None:
    if s.has_matrix:
        passes.split(array, b.wide)
        passes.rotate(s.normal_matrix, b.wide)
        passes.copy(b.wide, b.normals)
    else:
        passes.split(array, b.normals)
    if passes.measure(b.normals):
        rescue.rescue_normals(array, s.normal_matrix, s.has_matrix, b.normals)
        passes.measure(b.normals)


@plain
def _load_points(array: Any, s: Any, b: Scratch) -> None:
    if not s.is_wide:
        passes.split(array, b.points)
        return
    passes.split(array, b.wide)
    if s.has_matrix and passes.transform(s.matrix, s.w, b.wide):
        rescue.rescue_points(array, s.matrix, s.w, b.wide)


@plain
def _approach(position: Any, s: Any, b: Scratch, ray: Any) -> bool:
    """Rays from the vertices to a position; whether any of them was rescued."""
    x, y, z = position[0], position[1], position[2]
    if s.is_wide:
        if passes.approach_wide(b.wide, x, y, z, ray):
            rescue.rescue_rays(b.wide, x, y, z, ray, b.exponents)
            return True
    elif passes.approach(b.points, x, y, z, ray):
        rescue.rescue_rays(b.points, x, y, z, ray, b.exponents)
        return True
    return False


@plain
def _find_strength(t: Any, is_rescued: bool, b: Scratch) -> None:
    real = b.ray.dtype.type
    passes.attenuate(b.ray, real(t.constant), real(t.linear), real(t.quadratic), real(t.gain), b.factors)
    if is_rescued:
        rescue.mend_strength(b.ray, b.exponents, t.constant, t.linear, t.quadratic, t.gain, b.factors)
    if t.has_cone:
        axis = t.axis
        passes.cone(b.ray, real(axis[0]), real(axis[1]), real(axis[2]), real(t.edge), b.factors)
        passes.raise_shine(b.factors, real(t.exponent), real(1.0), real(t.dark))
        passes.narrow(b.factors)
    if t.has_ambient:
        ambient = t.ambient
        passes.add_strength(b.factors, real(ambient[0]), real(ambient[1]), real(ambient[2]), b.colors)


@plain
def _find_cosines(t: Any, s: Any, has_unseen: bool, b: Scratch) -> None:
    real = b.ray.dtype.type
    if t.highlight == NO_HIGHLIGHT:
        if t.is_parallel:
            l = t.position
            passes.lambert_parallel(b.normals, real(l[0]), real(l[1]), real(l[2]), b.factors)
        else:
            passes.lambert(b.normals, b.ray, b.factors)
        return
    if t.is_parallel:
        l = t.position
        passes.fill(b.ray, l[0], l[1], l[2])
    if t.highlight == PHONG:
        passes.phong(b.normals, b.viewer, b.ray, b.factors)
    elif t.highlight == BLINN_PHONG:
        passes.blinn_phong(b.normals, b.viewer, b.ray, b.factors)
    elif t.highlight == HEADLIGHT:
        passes.headlight(b.normals, b.ray, real(s.floor), b.factors)
    passes.raise_shine(b.factors, real(s.shininess), real(1.0) - real(s.floor), real(s.dark))
    if has_unseen and t.highlight != HEADLIGHT:
        rescue.hide_unseen(b.viewer, b.factors)


@plain
def _add_light(t: Any, s: Any, has_unseen: bool, has_albedo: bool, b: Scratch) -> None:
    real = b.ray.dtype.type
    if not t.is_parallel:
        is_rescued = _approach(t.position, s, b, b.ray)
        if t.varies:
            _find_strength(t, is_rescued, b)
    if not t.needs_normals:
        return
    _find_cosines(t, s, has_unseen, b)
    if t.varies:
        passes.dim(b.factors)
    d, k = t.diffuse, t.specular
    red, green, blue = real(d[0]), real(d[1]), real(d[2])
    if t.highlight == NO_HIGHLIGHT:
        passes.add_matt(b.factors, red, green, blue, b.colors)
    elif has_albedo:
        passes.add_matt(b.factors, red, green, blue, b.colors)
        passes.add_shiny(b.factors, real(k[0]), real(k[1]), real(k[2]), b.highlights)
    else:
        passes.add_both(b.factors, red, green, blue, real(k[0]), real(k[1]), real(k[2]), b.colors)


@plain
def _shade_block(points: Any, normals: Any, albedo: Any, rgb: Any, display: Any, s: Any, terms: Any, b: Any) -> None:
    """Arguments are the block's part of each array; one that is not needed may be empty."""
    real = b.ray.dtype.type
    has_albedo, has_unseen = len(albedo) > 0, False
    if s.needs_normals:
        _load_normals(normals, s, b)
    if s.needs_points:
        _load_points(points, s, b)
    if s.needs_eye:
        has_unseen = _approach(s.eye, s, b, b.viewer)
        passes.make_unit(b.viewer)
    if s.is_flipped:
        passes.turn(b.normals, b.viewer if s.has_local_facing else b.facing)
    base = s.base
    passes.fill(b.colors, base[0], base[1], base[2])
    if has_albedo:
        emission = s.emission
        passes.fill(b.highlights, emission[0], emission[1], emission[2])
    for t in terms:
        _add_light(t, s, has_unseen, has_albedo, b)
    if has_albedo:
        passes.split(albedo, b.albedo)
        passes.tint(b.colors, b.albedo, b.highlights)
    if len(rgb):
        passes.join(b.colors, real(s.low), real(s.high), rgb)
    if len(display):
        passes.join_bytes(b.colors, display)


@plain
def _shade_group(
    start: int, stop: int, points: Any, normals: Any, albedo: Any, rgb: Any, display: Any, settings: Any, terms: Any
) -> None:
    s = settings[0]
    b = _scratch(rgb, len(albedo) > 0)
    to_eye = s.to_eye
    passes.fill(b.viewer, to_eye[0], to_eye[1], to_eye[2])
    passes.fill(b.facing, to_eye[0], to_eye[1], to_eye[2])
    for first in range(start, stop, BLOCK):
        part = slice(3 * first, 3 * min(first + BLOCK, stop))
        _shade_block(points[part], normals[part], albedo[part], rgb[part], display[part], s, terms, b)


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
        If it is to be kept and Numba finds no folder that it can write to.
    """
    files = (_kernel_math, _kernel_passes, _kernel_rescue)
    checksum = zlib.crc32("".join(map(inspect.getsource, files)).encode())

    @numba.njit(parallel=True, error_model="numpy", cache=cache)
    def shade(
        points: Any, normals: Any, albedo: Any, rgb: Any, display: Any, settings: Any, terms: Any, count: int
    ) -> None:
        _ = checksum
        for group in numba.prange((count + GROUP - 1) // GROUP):
            start, stop = group * GROUP, min(group * GROUP + GROUP, count)
            _shade_group(start, stop, points, normals, albedo, rgb, display, settings, terms)

    return shade
