"""The kernel: the same equation and the same formulas as `reference.py`, compiled by Numba, on several threads.

Numba is an optional extra. It is imported when the kernel is first used, and the code that it compiles is kept on disk.
Where a call is not to wait, code that is missing is declined and the reference runs; another process compiles it
meanwhile. The kernel also declines what it cannot run, and the reference runs: a light has no placement, a
reflectance's formula is not marked as one, a scene coordinate lies beyond 2¹⁰⁰, an attenuation or a matrix has an entry
that is not between that and 2⁻¹⁰⁰, or a light is brighter than its stage takes.
Single vertices are declined too, and the reference lights those: on a light or the eye, not finite, or so far from a
light or so near it that float32 does not hold the products.

The kernel differs from the reference by rounding alone. float32 results come from float32 arithmetic, geometry
included, but for integrals over lights with a size: differences of positions have full relative precision however far
the scene is from the origin, and a highlight errs by at most (4√n + 10) · 2⁻²⁴ for shininess n.

In reading order: `evaluation` brings ranges of vertices to the driver, on several threads; `driver` is what happens to
a block of them, from loading to colours; `vertices` is where a block's values are and how they are loaded; `stages`
puts a loop around the formula of a light or a reflectance; `lanes` is what those of lights with a size run on, eight
vertices side by side. `records` is the form in which the driver takes an equation, `arithmetic` what compiled code
calculates with, `code` compiles and keeps the code on disk, `ahead` compiles all there is. `normals` sums the normals
of meshes, `edges` splits their sharp edges, `rays` makes rays and has them tested, and `hits` finds what they meet
first.
"""

from __future__ import annotations

import functools
import importlib.util
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from pvphong.base import check
from pvphong.base.types import Backend, BoolArray, Float64Array, FloatArray, IntArray, Weighting
from pvphong.optics.area.sampling import Sampling
from pvphong.shading.equation import Equation
from pvphong.shading.reference import Shading
from pvphong.shading.vertices import Tint

if TYPE_CHECKING:
    from pvphong.shading.kernel.code import Library


def obstacle() -> tuple[str, str] | None:
    """Why Numba cannot be used in this process, and what can be done about it; the first call imports it."""
    if _library() is not None:
        return None
    if importlib.util.find_spec("numba") is not None:
        return "where Numba does not compile", "Unset NUMBA_DISABLE_JIT, or see whether `import numba` fails."
    remedy = 'pip install numba installs it; backend="auto" does without where it is missing.'
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

        from pvphong.shading.kernel.code import Library
    except ImportError:
        return None
    return None if config.DISABLE_JIT else Library()


class _Process:
    """What this process has done."""

    has_run: ClassVar[bool] = False


class CannotCompile(Exception):
    """Why no code can be compiled in advance, and what can be done about it."""


def compile_all(report: Callable[[str, int, int], object]) -> Path:
    """Compile all code for pvphong's own lights and reflectances, by several processes; the folder where it is kept.

    Parameters
    ----------
    report : callable
        As for `ahead.compile_all`.

    Raises
    ------
    CannotCompile
        Without Numba, or where code cannot be kept.
    """
    library = _library()
    if library is None:
        where, remedy = obstacle() or ("", "")
        raise CannotCompile(f"nothing can be compiled {where}. {remedy}")
    from pvphong.shading.kernel import ahead

    folder = library.folder
    if folder is None:
        remedy = "Set NUMBA_CACHE_DIR to a folder that can be written to."
        raise CannotCompile(f"there is no folder to keep compiled code in: neither pvphong's nor your own. {remedy}")
    if not ahead.is_kept():
        try:
            ahead.compile_all(report)
        except BrokenProcessPool:
            raise CannotCompile("a process that compiles was killed: see whether there is memory.") from None
    if not ahead.is_kept():
        raise CannotCompile(f"compiled code could not be written to {folder}: see whether there is room.")
    return folder


def shade(
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
    """Evaluate the equation at every vertex into the arrays of a result, or decline.

    The result does not depend on the number of threads, to the bit. Arrays that are not C-contiguous are copied piece
    by piece and give the same bits; so are float32 beside float64, as float64.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3), float32 or float64, of any memory layout.
    equation : Equation
        What to evaluate.
    tints : mapping
        What `Vertices.tints` gives.
    result : Shading
        `rgb`, C-contiguous, is filled in: float32, float64, or uint8, which is float32 arithmetic rounded to
        0-255 for display. So are components where it has them, of `Shading.empty`, and not with uint8.
    whole : Equation, optional
        The equation before a plan left out what does not reach these vertices; the same if not given. It decides
        whether the kernel declines and the type in which vertices are read, so that these do not depend on where the
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
    library = _library()
    if library is None:
        return False
    from pvphong.shading.kernel import evaluation

    done = evaluation.shade(library, points, normals, equation, tints, result, whole or equation, channels, waits)
    _Process.has_run |= done
    return done


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
    from pvphong.shading.kernel import normals as of_meshes

    result = of_meshes.point_normals(
        library if waits else library.cached_only, points, connectivity, offsets, weighting
    )
    _Process.has_run |= result is not None
    return result


def split_points(
    points: FloatArray, connectivity: NDArray[Any], offsets: NDArray[Any], angle: float, *, waits: bool = True
) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
    """A mesh's faces with points of their own on either side of a sharp edge, as VTK's filter has them; or None.

    The result is that of the filter, whatever the number of threads. None without Numba, or for faces that VTK is to
    split or refuse: with more than 384 corners or fewer than three, or with an index that is none of a point's.

    Parameters
    ----------
    points, connectivity, offsets, waits
        As for `point_normals`.
    angle : float
        Degrees between the normals of two faces from which the edge between them is sharp.

    Returns
    -------
    connectivity : ndarray
        int64. New points have the numbers after those that there are.
    added : ndarray
        int64: for each new point, the point whose place it has.
    """
    library = _library()
    if library is None:
        return None
    from pvphong.shading.kernel import edges

    result = edges.split_points(library if waits else library.cached_only, points, connectivity, offsets, angle)
    _Process.has_run |= result is not None
    return result


class Casters(NamedTuple):
    """Scenes of Embree's, and how to test sixteen rays with each."""

    occluded: int
    """Address of `rtcOccluded16`."""
    intersect: int
    """Address of `rtcIntersect16`."""
    scenes: IntArray
    """Their handles."""
    numbers: Float64Array
    """Shape (scenes, 4): the middle of each, and the power of two that brings it to −1 to 1."""
    owners: Sequence[Any]
    """What keeps the scenes alive."""


def rays_obstacle() -> str:
    """Why compiled code casts no rays now; "" where it does. Code that is missing is compiled by another process."""
    library = _library()
    if library is None:
        return f"nothing can be compiled {(obstacle() or [''])[0]}"
    from pvphong.shading.kernel import code, hits, rays

    needed = rays.test_code, rays.point_code, rays.part_code, hits.around_code, hits.find_code
    is_there = all(code.if_compiled(library, each) is not None for each in needed)
    return "" if is_there else "its code is being compiled"


def stages_of(sampling: Sampling) -> tuple[int, int] | None:
    """Addresses of the code of a light's two formulas; None where it is missing, and another process compiles it."""
    from pvphong.shading.kernel import code, rays

    return code.if_compiled(_compiled(), lambda library: rays.stages_of(library, sampling))


def part_seen(*arguments: Any) -> tuple[FloatArray, FloatArray, Float64Array, int]:
    """As `rays.part_seen`, where `rays_obstacle` names none."""
    from pvphong.shading.kernel import rays

    return rays.part_seen(_compiled(), *arguments)


def point_seen(*arguments: Any) -> int:
    """As `rays.point_seen`, where `rays_obstacle` names none."""
    from pvphong.shading.kernel import rays

    return rays.point_seen(_compiled(), *arguments)


def vertices_met(*arguments: Any) -> tuple[NDArray[np.int32], int]:
    """As `hits.vertices_met`, where `rays_obstacle` names none."""
    from pvphong.shading.kernel import hits

    return hits.vertices_met(_compiled(), *arguments)


def gatherer() -> Callable[[NDArray[np.int32], FloatArray], FloatArray] | None:
    """`hits.gathered`; None without Numba, or where its code is missing, and another process compiles it."""
    library = _library()
    if library is None:
        return None
    from pvphong.shading.kernel import code, hits

    is_there = code.if_compiled(library, hits.gather_code) is not None
    return functools.partial(hits.gathered, library) if is_there else None


def ray_hits(*arguments: Any) -> tuple[IntArray, FloatArray, Float64Array]:
    """As `hits.hits`, where `rays_obstacle` names none."""
    from pvphong.shading.kernel import hits

    return hits.hits(_compiled(), *arguments)


def rays_blocked(*arguments: Any) -> BoolArray:
    """As `rays.blocked`, where `rays_obstacle` names none."""
    from pvphong.shading.kernel import rays

    return rays.blocked(_compiled(), *arguments)


def _compiled() -> Library:
    library = _library()
    assert library is not None
    return library
