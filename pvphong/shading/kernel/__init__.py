"""The kernel: the same equation and the same formulas as `reference.py`, compiled by Numba, on several threads.

Numba is an optional extra. It is imported at the first use of the kernel, and compiled code is kept on disk. If a call
must not wait and code is missing, the kernel declines the equation: the reference evaluates it, and another process
compiles the code. The kernel also declines an equation that it does not support:

- a light without `placement`, or a light or reflectance whose formula is not marked by `formula`
- a scene coordinate beyond 2¹⁰⁰
- an entry of an attenuation or a matrix that is neither 0 nor between 2⁻¹⁰⁰ and 2¹⁰⁰
- a light that is too bright for its stage

The kernel declines single vertices too, and the reference lights them: a vertex on a light or the eye, a vertex that is
not finite, or a vertex so far from a light or so near it that float32 does not hold the products.

The kernel differs from the reference by rounding alone. float32 results are computed in float32, including geometry,
except integrals over area lights. Differences of positions have full relative precision at any distance from the
origin, and a highlight has an error of at most (4√n + 10) · 2⁻²⁴ for shininess n.

In reading order:

- `evaluation` runs the driver on ranges of vertices, on several threads
- `driver` lights a block of vertices, from loading to colours
- `vertices` defines the memory of a block and loads it
- `stages` puts a loop around the formula of a light or a reflectance
- `lanes` runs the formulas of area lights on eight vertices at once
- `records` packs an equation for the driver
- `arithmetic` has the operations of compiled code
- `code` compiles code and keeps it on disk, `ahead` compiles all of it in advance
- `normals` computes normals of meshes, `edges` splits their points along sharp edges
- `blends` blends vertices inside triangles
- `rays` generates and tests rays, `hits` finds their first hits
"""

from __future__ import annotations

import functools
import importlib.util
import sys
from collections.abc import Callable, Sequence
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from pvphong.base import check
from pvphong.base.types import Backend, BoolArray, Float64Array, FloatArray, IntArray, Weighting
from pvphong.optics.area.sampling import Sampling

if TYPE_CHECKING:
    from pvphong.shading.kernel.code import Library


def obstacle() -> tuple[str, str] | None:
    """Return the reason why Numba cannot be used in this process, and a remedy; None if it can be used.

    The first call imports Numba.
    """
    if _library() is not None:
        return None
    if importlib.util.find_spec("numba") is not None:
        return "because Numba does not compile", "Unset NUMBA_DISABLE_JIT, or check whether `import numba` fails."
    remedy = 'To use it, run pip install numba. backend="auto" works without it.'
    return "because Numba is not installed", remedy


def is_available() -> bool:
    """Return True if Numba can be used in this process. The first call imports Numba."""
    return _library() is not None


def check_backend(backend: Any) -> None:
    """Raise ``ValueError`` for an unknown backend, or for "numba" if Numba cannot be used."""
    reason = obstacle() if check.choice("backend", backend, get_args(Backend)) == "numba" else None
    if reason is not None:
        where, remedy = reason
        check.refuse("backend", backend, f"'auto' or 'numpy' {where}", remedy)


def has_run() -> bool:
    """Return True if compiled code has run in this process."""
    code = sys.modules.get("pvphong.shading.kernel.code")
    return code is not None and code.Library.has_run


def seconds_compiling(run: Callable[[], object]) -> float:
    """Call `run`, and return the seconds for which Numba compiled during the call. Without Numba, return 0.

    Loading code from disk does not count.
    """
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
    """Return the library of compiled code; None without Numba."""
    try:
        from numba import config

        from pvphong.shading.kernel.code import Library
    except ImportError:
        return None
    return None if config.DISABLE_JIT else Library()


class CannotCompile(Exception):
    """Raised if code cannot be compiled in advance; the message is the reason and a remedy."""


def compile_all(report: Callable[[str, int, int], object]) -> Path:
    """Compile all code for pvphong's own lights and reflectances in several processes. Return the folder of the code.

    Parameters
    ----------
    report : callable
        Called after each piece of code with its name, the number of finished pieces, and the number of all pieces.

    Raises
    ------
    CannotCompile
        If Numba is missing, or if code cannot be written to disk.
    """
    library = _library()
    if library is None:
        where, remedy = obstacle() or ("", "")
        raise CannotCompile(f"nothing can be compiled {where}. {remedy}")
    from pvphong.shading.kernel import ahead

    folder = library.folder
    if folder is None:
        remedy = "Set NUMBA_CACHE_DIR to a writable folder."
        raise CannotCompile(f"no folder for compiled code is writable, neither pvphong's nor your own. {remedy}")
    if not ahead.is_kept():
        try:
            ahead.compile_all(report)
        except BrokenProcessPool:
            raise CannotCompile("a compiling process was killed. Check whether there is enough memory.") from None
    if not ahead.is_kept():
        raise CannotCompile(f"compiled code could not be written to {folder}. Check whether there is enough space.")
    return folder


def evaluator() -> Callable[..., bool] | None:
    """Return `evaluation.shade` for this process's library of compiled code; None without Numba."""
    library = _library()
    if library is None:
        return None
    from pvphong.shading.kernel import evaluation

    return functools.partial(evaluation.shade, library)


def point_normals(
    points: FloatArray, connectivity: NDArray[Any], offsets: NDArray[Any], weighting: Weighting, *, waits: bool = True
) -> Float64Array | None:
    """Return unit normals of a mesh's points, shape (n, 3). Return None if NumPy must compute them or refuse the mesh.

    They equal those of `pvphong.geometry.normals.point_normals`, which NumPy computes, up to rounding. Neither the
    numbering of the points nor the number of threads changes any bit.

    Parameters
    ----------
    points : ndarray
        Shape (n, 3), float32 or float64, of any memory layout.
    connectivity, offsets : ndarray
        One-dimensional integer arrays: the point indices of all faces, face after face, and the index in this array at
        which each face begins, then the length of the array.
    weighting : {"angle", "area", "max"}
        As for the NumPy function.
    waits : bool, default True
        True to compile missing code now. If False, None is returned, and another process compiles it for later calls.
    """
    library = _library()
    if library is None:
        return None
    from pvphong.shading.kernel import normals as of_meshes

    result = of_meshes.point_normals(
        library if waits else library.cached_only, points, connectivity, offsets, weighting
    )
    type(library).has_run |= result is not None
    return result


def split_points(
    points: FloatArray, connectivity: NDArray[Any], offsets: NDArray[Any], angle: float, *, waits: bool = True
) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
    """Split a mesh's points along sharp edges, as VTK's vtkSplitSharpEdgesPolyData does.

    The result equals the filter's and does not depend on the number of threads. Return None without compiled code, and
    for faces that VTK divides or refuses: faces with more than 384 corners or fewer than three, or with an index
    outside the points.

    Parameters
    ----------
    points, connectivity, offsets, waits
        As for `point_normals`.
    angle : float
        Feature angle in degrees: an edge is sharp if the normals of its two faces differ by at least this angle.

    Returns
    -------
    connectivity : ndarray
        int64. New points are numbered after the existing ones.
    added : ndarray
        int64: the point from which each new point was copied.
    """
    library = _library()
    if library is None:
        return None
    from pvphong.shading.kernel import edges

    result = edges.split_points(library if waits else library.cached_only, points, connectivity, offsets, angle)
    type(library).has_run |= result is not None
    return result


class Casters(NamedTuple):
    """Embree scenes, and the addresses of the functions that test sixteen rays with a scene."""

    occluded: int
    """Address of `rtcOccluded16`."""
    intersect: int
    """Address of `rtcIntersect16`."""
    scenes: IntArray
    """Handles of the scenes."""
    numbers: Float64Array
    """Shape (scenes, 4): centre of each scene, and the power of two that scales it to [−1, 1]."""
    owners: Sequence[Any]
    """Objects that keep the scenes alive."""


def rays_obstacle() -> str:
    """Return the reason why compiled code cannot cast rays now; "" if it can.

    If code is missing, another process compiles it for later calls.
    """
    library = _library()
    if library is None:
        return f"nothing can be compiled {(obstacle() or [''])[0]}"
    from pvphong.shading.kernel import code, hits, rays

    needed = rays.test_code, rays.point_code, rays.part_code, hits.around_code, hits.find_code
    is_there = all(code.if_compiled(library, each) is not None for each in needed)
    return "" if is_there else "its code is being compiled"


def stages_of(sampling: Sampling) -> tuple[int, int] | None:
    """Return the addresses of the compiled functions `frame` and `sample`, which sample the rays to a light.

    Return None if they are not compiled yet; another process then compiles them.
    """
    from pvphong.shading.kernel import code, rays

    return code.if_compiled(_compiled(), lambda library: rays.stages_of(library, sampling))


def part_seen(*arguments: Any) -> tuple[FloatArray, FloatArray, Float64Array, int]:
    """Call `rays.part_seen` with this process's library, followed by `arguments`.

    Call it only if `rays_obstacle()` returns "".
    """
    from pvphong.shading.kernel import rays

    return rays.part_seen(_compiled(), *arguments)


def point_seen(*arguments: Any) -> int:
    """Call `rays.point_seen` with this process's library, followed by `arguments`.

    Call it only if `rays_obstacle()` returns "".
    """
    from pvphong.shading.kernel import rays

    return rays.point_seen(_compiled(), *arguments)


def vertices_met(*arguments: Any) -> tuple[NDArray[np.int32], int]:
    """Call `hits.vertices_met` with this process's library, followed by `arguments`.

    Call it only if `rays_obstacle()` returns "".
    """
    from pvphong.shading.kernel import hits

    return hits.vertices_met(_compiled(), *arguments)


def gatherer() -> Callable[[NDArray[np.int32], FloatArray], FloatArray] | None:
    """Return `hits.gathered` for this process's library.

    Return None without Numba, or if code must be compiled first.
    """
    library = _library()
    if library is None:
        return None
    from pvphong.shading.kernel import code, hits

    is_there = code.if_compiled(library, hits.gather_code) is not None
    return functools.partial(hits.gathered, library) if is_there else None


class Blends(NamedTuple):
    """The functions `blended` and `differences` of the module `blends`, for this process's library."""

    blended: Callable[..., Float64Array]
    differences: Callable[[Float64Array, Float64Array], Float64Array]


def blending() -> Blends | None:
    """Return the functions of the module `blends`. Return None without Numba, or if code must be compiled first."""
    library = _library()
    if library is None:
        return None
    from pvphong.shading.kernel import blends, code

    is_there = all(code.if_compiled(library, each) is not None for each in (blends.blend_code, blends.compare_code))
    own = functools.partial(blends.blended, library), functools.partial(blends.differences, library)
    return Blends(*own) if is_there else None


def ray_hits(*arguments: Any) -> tuple[IntArray, FloatArray, Float64Array]:
    """Call `hits.hits` with this process's library, followed by `arguments`.

    Call it only if `rays_obstacle()` returns "".
    """
    from pvphong.shading.kernel import hits

    return hits.hits(_compiled(), *arguments)


def rays_blocked(*arguments: Any) -> BoolArray:
    """Call `rays.blocked` with this process's library, followed by `arguments`.

    Call it only if `rays_obstacle()` returns "".
    """
    from pvphong.shading.kernel import rays

    return rays.blocked(_compiled(), *arguments)


def _compiled() -> Library:
    library = _library()
    assert library is not None
    return library
