"""Compilation in advance: the code for an equation, and the code for all of pvphong's own lights and reflectances.

`python -m pvphong.shading.kernel.ahead`, started by the module `code.py`, compiles both in one process at low priority,
the equation's code first. `compile_all` uses all processors, for callers that wait.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import pickle
import signal
import sys
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import MISSING, fields
from functools import cache, partial
from itertools import product
from typing import Any, NamedTuple

from pvphong.base import threads
from pvphong.base.files import locked
from pvphong.optics.area.lobes import CosinePower
from pvphong.optics.area.sampling import image_sample, sky_frame, sky_sample
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.reflectance import LAMBERT
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.optics.reflectances.vtk import VtkHeadlight
from pvphong.optics.roles import Width, roles_of
from pvphong.shading.kernel import blends, edges, hits, normals, rays, records, stages
from pvphong.shading.kernel.code import Library, NotCompiled, Request, code_identity
from pvphong.shading.kernel.evaluation import driver_code

_REALS = "float32", "float64"
_STORED_AND_REAL = ("float32", "float32"), ("float64", "float32"), ("float64", "float64")


class CompilationUnit(NamedTuple):
    """Code of one function for one combination of types; `compile` compiles it."""

    name: str
    compile: Callable[[], object]


def pieces(library: Library) -> list[CompilationUnit]:
    """Return all code to compile in advance: for meshes, for rays, and for pvphong's own lights and reflectances."""
    result = [
        CompilationUnit("faces", partial(normals.survey_code, library)),
        *(CompilationUnit(f"normals, {real}", partial(normals.normals_code, library, real)) for real in _REALS),
        CompilationUnit("blends", partial(blends.blend_code, library)),
        CompilationUnit("differences", partial(blends.compare_code, library)),
        *(CompilationUnit(f"flat normals, {real}", partial(edges.normals_code, library, real)) for real in _REALS),
        CompilationUnit("corners", partial(edges.count_code, library)),
        CompilationUnit("edges", partial(edges.fans_code, library)),
        CompilationUnit("rays", partial(rays.test_code, library)),
        CompilationUnit("rays to a point", partial(rays.point_code, library)),
        CompilationUnit("rays to an area", partial(rays.part_code, library)),
        CompilationUnit("rays over hemispheres", partial(hits.around_code, library)),
        CompilationUnit("colours that rays hit", partial(hits.gather_code, library)),
        CompilationUnit("first hits of rays", partial(hits.find_code, library)),
    ]
    result += (CompilationUnit(name, partial(library.stage, x, "float32")) for name, x in _of_samplings())
    written = ("factors already written", stages.factors_already_written)
    lit = *_of_lights(), *_of_lights_with_a_size(), *_of_reflectances(), written
    for stored, real in _STORED_AND_REAL:
        types = real if stored == real else f"{stored} to {real}"
        result.append(CompilationUnit(f"driver, {types}", partial(driver_code, library, stored, real)))
    stages_and_reals = product(lit, _REALS)
    result += (
        CompilationUnit(f"{name}, {real}", partial(library.stage, x, real)) for (name, x), real in stages_and_reals
    )
    return result


def is_kept() -> bool:
    """Return True if all code is on disk already."""
    try:
        for piece in pieces(Library().cached_only):
            piece.compile()
    except NotCompiled:
        return False
    return True


def compile_all(report: Callable[[str, int, int], object]) -> None:
    """Compile the code that is not on disk, with one process for each thread that pvphong uses.

    Parameters
    ----------
    report : callable
        Called after each piece with its name, the number of finished pieces, and the number of all pieces.

    Raises
    ------
    BrokenProcessPool
        If one of the processes is killed.
    """
    names = [piece.name for piece in pieces(Library())]
    start = multiprocessing.get_context("spawn")  # threads do not survive a fork
    pool = ProcessPoolExecutor(threads.count(), start, initializer=_leave_interrupts)
    try:
        running = {pool.submit(_compile, number): name for number, name in enumerate(names)}
        for done, future in enumerate(as_completed(running), 1):
            future.result()
            report(running[future], done, len(names))
    finally:
        pool.shutdown(cancel_futures=True)


def _leave_interrupts() -> None:
    """Ignore Ctrl-C in a compiling process. The process that waits for it handles the interrupt."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@cache
def _own_pieces() -> list[CompilationUnit]:
    return pieces(Library())


def _compile(number: int) -> None:
    _own_pieces()[number].compile()


_Named = Iterable[tuple[str, Callable[..., Any]]]
"""Pairs of a name and a stage."""


def _of_lights() -> _Named:
    """Return the compiled loops (stages) of all kinds of light, with and without attenuation, each with its name."""
    placed = {name: _sample(kind).placement for name, kind in LIGHT_TYPES.items()}
    return _distinct(
        (name, stages.light_stage(placement.falloff, weakens, placement.pattern))
        for name, placement in placed.items()
        if placement is not None
        for weakens in (True, False)
    )


def _of_lights_with_a_size() -> _Named:
    """Return the stages of all area lights, each with its name.

    Each is compiled for Phong's diffuse lobe, for its highlight, and for both together.
    """
    diffuse, highlight = CosinePower("normal", 1.0), CosinePower("mirror", 20.0)
    lights = [(name, part) for name, kind in LIGHT_TYPES.items() for _, part in _sample(kind).tints()]
    return _distinct(
        (name, stages.integral_stage([form and light.analytic_integral(form) for form in forms], forms))
        for name, light in lights
        if light.analytic_integral(diffuse) is not None
        for forms in ((diffuse, highlight), (diffuse, None), (None, highlight))
    )


def _of_samplings() -> _Named:
    """Return the stages that sample rays, each with its name.

    The rays go to each kind of light with a size, to the sky, and to an image of the sky.
    """
    found = {name: _sample(kind).sampling for name, kind in LIGHT_TYPES.items()}
    by_light = [(name, each.frame, each.sample) for name, each in found.items() if each is not None]
    chosen = [*by_light, ("sky", sky_frame, sky_sample), ("image", sky_frame, image_sample)]
    return _distinct(
        (f"rays to {name}", stage)
        for name, frame, sample in chosen
        for stage in (rays.frame_stage(frame), rays.sample_stage(sample))
    )


def _of_reflectances() -> _Named:
    """Return the stages of all reflectances for each choice of lobes, each with its name."""
    kinds: dict[str, Any] = {**REFLECTANCES, "headlight in VTK": VtkHeadlight}
    samples = {name: _sample(kind) for name, kind in kinds.items()}
    return _distinct(
        (name, stages.reflectance_stage(each, wanted))
        for name, each in samples.items()
        for wanted in list(product((True, False), repeat=len(each.lobes)))[:-1]
        if any(wanted[1:]) or each.lobes[0] is not LAMBERT
    )


def _sample(kind: Any) -> Any:
    """Return an instance of `kind`, a class of lights or reflectances.

    Fields without a default, and widths, are 1, so that the instance has a size.
    """
    wide = {name: 1.0 for name, role in roles_of(kind).items() if isinstance(role, Width)}
    return kind(*(1.0 for each in fields(kind) if each.default is MISSING), **wide)


def _distinct(stages_of_all: _Named) -> _Named:
    """Return the given pairs of name and stage without duplicates.

    Of stages with the same code, the last one is kept.
    """
    return {code_identity(stage): (name, stage) for name, stage in stages_of_all}.values()


def main() -> None:
    """Read a pickled `Request` from standard input, and compile its code, then all other code.

    Do nothing if another process is compiling.
    """
    with contextlib.suppress(AttributeError, OSError):  # not on all platforms
        os.nice(10)
    library = Library()
    if library.lock is None:
        return
    with locked(library.lock) as is_alone:
        if not is_alone:
            return
        request = _request()
        codes = request and records.codes_of(request.equation, request.real)
        if request is not None and codes is not None:
            driver_code(library, request.stored, request.real)
            records.records_of(request.equation, codes, library, request.stored, request.real, {}, is_display=False)
        for piece in pieces(library):
            piece.compile()


def _request() -> Request | None:
    """Read the request from standard input.

    Return None if its lights or reflectances cannot be imported, for example if an interactive session defines them.
    """
    try:
        request = pickle.load(sys.stdin.buffer)
    except (AttributeError, ImportError, EOFError):
        return None
    return request if isinstance(request, Request) else None


if __name__ == "__main__":
    main()
