"""Compiling in advance: what an equation needs, and all that pvphong's own lights and reflectances need.

`python -m pvphong.shading.kernel.compiling`, which `background` starts, compiles both, the equation's code first.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import MISSING, fields
from functools import partial
from itertools import product
from typing import Any, NamedTuple

from pvphong.base.files import locked
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.reflectance import LAMBERT
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.optics.reflectances.vtk import VtkHeadlight
from pvphong.optics.spherical import CosinePower
from pvphong.shading.kernel import records, stages, toolkit
from pvphong.shading.kernel.background import NotCompiled, Request
from pvphong.shading.kernel.keeping import Library, what_it_does

_REALS = "float32", "float64"
_STORED_AND_REAL = ("float32", "float32"), ("float64", "float32"), ("float64", "float64")
_NO_FLAGS = {"is_wide": False, "has_albedo": False, "is_display": False}


class CompilationUnit(NamedTuple):
    """Code of one function for one combination of types."""

    name: str
    compile: Callable[[], object]


def pieces(library: Library) -> list[CompilationUnit]:
    """All code for pvphong's own lights and reflectances."""
    result = [CompilationUnit("faces", library.survey), CompilationUnit("normals", library.normals)]
    for stored, real in _STORED_AND_REAL:
        types = real if stored == real else f"{stored} to {real}"
        result.append(CompilationUnit(f"driver, {types}", partial(library.driver, stored, real)))
    for real in _REALS:
        result.append(CompilationUnit(f"bounds, {real}", partial(library.extremes, real)))
        whole = _of_lights_with_a_size() if real == "float32" else ()
        lights, reflectances = (
            (*_of_lights(), *whole),
            (*_of_reflectances(), stages.already_there),
        )
        for kind, functions in (("light", lights), ("reflectance", reflectances)):
            made = getattr(library, kind)
            for function in functions:
                name = f"{function.__name__.replace('_', ' ')}, {real}"
                result.append(CompilationUnit(name, partial(made, function, real)))
    return result


def is_kept() -> bool:
    """Whether all of it is on disk."""
    try:
        for piece in pieces(Library().at_hand):
            piece.compile()
    except NotCompiled:
        return False
    return True


def _of_lights() -> Iterable[Callable[..., Any]]:
    """Stages of all kinds of light, as they weaken with distance and as they do not."""
    placements = [_sample(kind).placement for kind in LIGHT_TYPES.values()]
    falloffs = [each.falloff for each in placements if each is not None]
    return _distinct(stages.light_stage(falloff, weakens) for falloff in falloffs for weakens in (True, False))


def _of_lights_with_a_size() -> Iterable[Callable[..., Any]]:
    """Closed stages of all kinds of light, for each choice of what Phong's reflectance has lobes for."""
    diffuse, highlight = CosinePower("normal", 1.0), CosinePower("mirror", 20.0)
    choices = (diffuse, highlight), (diffuse, None), (None, highlight)
    lights = [part for kind in LIGHT_TYPES.values() for _, part in _sample(kind).tints()]
    closed = [light.closed_stage(toolkit, forms) for light in lights for forms in choices]
    return _distinct(stage.function for stage in closed if stage is not None)


def _of_reflectances() -> Iterator[Callable[..., Any]]:
    """Stages of all reflectances, for each choice of lobes."""
    for kind in (*REFLECTANCES.values(), VtkHeadlight):
        reflectance = _sample(kind)
        choices = list(product((True, False), repeat=len(reflectance.lobes)))[:-1]
        yield from _distinct(
            stages.reflectance_stage(reflectance, wanted)
            for wanted in choices
            if any(wanted[1:]) or reflectance.lobes[0] is not LAMBERT
        )


def _sample(kind: Any) -> Any:
    """One of a kind whose fields are 1 where they have no default."""
    return kind(*(1.0 for each in fields(kind) if each.default is MISSING))


def _distinct(functions: Iterable[Callable[..., Any]]) -> Iterable[Callable[..., Any]]:
    """Functions without those that do the same."""
    return {what_it_does(each): each for each in functions}.values()


def main() -> None:
    """Compile what the standard input asks for, a pickled `Request`, and then all the rest.

    Nothing is done where another process is doing it.
    """
    with contextlib.suppress(AttributeError, OSError):  # where there are priorities
        os.nice(10)
    library = Library()
    if library.lock is None:
        return
    with locked(library.lock) as is_alone:
        if not is_alone:
            return
        request = _request()
        if request is not None:
            library.driver(request.stored, request.real)
            records.records_of(request.equation, {}, library, request.real, **_NO_FLAGS)
        for piece in pieces(library):
            piece.compile()


def _request() -> Request | None:
    """None if the equation has lights or reflectances that this process does not find, such as an interpreter's own."""
    try:
        request = pickle.load(sys.stdin.buffer)
    except (AttributeError, ImportError, EOFError):
        return None
    return request if isinstance(request, Request) else None


if __name__ == "__main__":
    main()
