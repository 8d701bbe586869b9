"""Compiles functions for use through their addresses, and keeps the code on disk where that is possible.

Numba asks only whether the file of a function itself has changed since; here all sources count that a function may
call.
"""

from __future__ import annotations

import copy
import ctypes
import functools
import inspect
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import CodeType
from typing import Any

import numba
from numba import types
from numba.core import event
from numba.core.ccallback import CFunc

from pvphong.shading.kernel import arithmetic, driver, extremes, facets
from pvphong.shading.kernel.background import Key, NotCompiled
from pvphong.shading.kernel.records import SETTINGS
from pvphong.shading.kernel.store import Store, digest
from pvphong.shading.kernel.terms import TERM

_BYTES, _FLOATS, _INDICES = map(types.CPointer, (types.uint8, types.float64, types.int64))
# Seconds until the disk is asked again for what was not there.
_PATIENCE = 0.5

_REALS = {"float32": types.float32, "float64": types.float64}
_OPTIONS = {"error_model": "numpy", "nopython": True}


class _Absent(Exception):
    """No code of a function is kept."""


class Code(CFunc):
    """A function compiled for being called by its address, from here on; or read, if that was possible before."""

    def __init__(self, function: Callable[..., Any], signature: Any, *, compiles: bool = True) -> None:
        super().__init__(function, (signature.args, signature.return_type), {}, dict(_OPTIONS))
        store = store_of(function)
        if store is not None:
            self._cache = store
        self._compiles = compiles
        arithmetic.bind_formulas()
        self.compile()
        self.where = int(self.address or 0)
        pointers = [ctypes.c_void_p] * len(signature.args)
        result = ctypes.c_bool if signature.return_type == types.boolean else ctypes.c_ssize_t
        self.call: Callable[..., int] = ctypes.CFUNCTYPE(result, *pointers)(self.where)
        """It with addresses, bytes and integers, without the interpreter's lock."""

    def _compile_uncached(self) -> Any:
        if not self._compiles:
            raise _Absent
        with event.trigger_event("numba:compile"):
            return super()._compile_uncached()  # type: ignore[misc]  # Numba has no types


def store_of(function: Callable[..., Any]) -> Store | None:
    """Where the code of a function is kept; None where Numba finds no folder to write to, or there are no sources."""
    formulas = [cell.cell_contents for cell in function.__closure__ or () if callable(cell.cell_contents)]
    try:
        return Store(function, _sources(tuple(sorted({each.__module__ for each in (function, *formulas)}))))
    except (RuntimeError, OSError):
        return None


@functools.cache
def _sources(modules: tuple[str, ...]) -> bytes:
    """A digest of all sources that functions of some modules may call; OSError if there are none.

    These are the modules', and all of this package and of those that formulas stand in.
    """
    here = Path(__file__).parent
    folders = here, here.parents[1] / "base", here.parents[1] / "optics"
    called = [source.read_text("utf-8") for folder in folders for source in sorted(folder.rglob("*.py"))]
    own = [inspect.getsource(sys.modules[module]) for module in modules if not module.startswith("pvphong.")]
    return digest("".join([*called, *own, repr((SETTINGS, TERM))]).encode())


def what_it_does(function: Callable[..., Any]) -> tuple[CodeType, tuple[Any, ...]]:
    """Equal for functions that do the same: code, and the values it was made with."""
    return function.__code__, tuple(cell.cell_contents for cell in function.__closure__ or ())


class Library:
    """What has been compiled or read from disk in this process."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._codes: dict[Key, Code] = {}
        self._looks_again: dict[Key, float] = {}
        self._compiles = True

    def __len__(self) -> int:
        return len(self._codes)

    @functools.cached_property
    def at_hand(self) -> Library:
        """The same code, but what is not there is not compiled: `NotCompiled` is raised."""
        library = copy.copy(self)
        library._compiles = False
        return library

    @property
    def folder(self) -> Path | None:
        """Where the driver's code is kept; None if there is no folder to keep code in."""
        store = store_of(driver.shade)
        return None if store is None else store.folder

    @property
    def lock(self) -> Path | None:
        """The file that is locked by the process that compiles in advance; None as for `folder`."""
        return self.folder and self.folder / "pvphong.lock"

    def light(self, function: Callable[..., Any], real: str) -> int:
        """Address of a light's stage for a type of rows."""
        return self._code(function, _stage_of_light, real).where

    def reflectance(self, function: Callable[..., Any], real: str) -> int:
        """Address of a reflectance's stage for a type of rows."""
        return self._code(function, _stage_of_reflectance, real).where

    def driver(self, stored: str, real: str) -> Callable[..., int]:
        """The driver for vertices of one type and rows of another."""
        return self._code(driver.shade, _driver, stored, real).call

    def extremes(self, stored: str) -> Callable[..., int]:
        """The search for the least and greatest entries of vectors of a type."""
        return self._code(extremes.find_extremes, _search, stored).call

    def survey(self) -> Callable[..., int]:
        """The look over a mesh's faces that comes before the search for normals."""
        return self._code(facets.survey, _survey).call

    def normals(self) -> Callable[..., int]:
        """The search for normals of points, in float32 or float64."""
        return self._code(facets.find_normals, _normals).call

    def _code(self, function: Callable[..., Any], signature: Callable[..., Any], *kinds: str) -> Code:
        """By what a function does, for lights make theirs anew each time; its signature is made of names of types."""
        key = *what_it_does(function), signature, kinds
        code = self._codes.get(key)
        if code is not None:
            return code
        if not self._compiles and time.monotonic() < self._looks_again.get(key, 0.0):
            raise NotCompiled(key)
        if not self._lock.acquire(blocking=self._compiles):
            raise NotCompiled(key)  # another thread compiles, maybe for seconds
        try:
            if key not in self._codes:
                types_of_arguments = signature(*(_REALS[kind] for kind in kinds))
                self._codes[key] = Code(function, types_of_arguments, compiles=self._compiles)
            return self._codes[key]
        except _Absent:
            self._looks_again[key] = time.monotonic() + _PATIENCE
            raise NotCompiled(key) from None
        finally:
            self._lock.release()


def _stage_of_light(real: Any) -> Any:
    return types.boolean(_FLOATS, types.CPointer(real), _FLOATS)


def _stage_of_reflectance(real: Any) -> Any:
    return types.intp(_FLOATS, types.CPointer(real), _FLOATS)


def _driver(stored: Any, real: Any) -> Any:
    vertices, reals = types.CPointer(stored), types.CPointer(real)
    arrays = vertices, vertices, reals, reals, reals, _BYTES
    equation = types.CPointer(numba.from_dtype(SETTINGS)), types.CPointer(numba.from_dtype(TERM)), _FLOATS
    scratch = reals, _FLOATS, _BYTES
    return types.intp(*arrays, *equation, _INDICES, *(types.intp,) * 4, *scratch)


def _search(stored: Any) -> Any:
    rows = types.CPointer(stored)
    return types.boolean(rows, types.intp, types.intp, rows, _FLOATS)


def _survey() -> Any:
    return types.boolean(_INDICES, _INDICES, *(types.intp,) * 3, _INDICES)


def _normals() -> Any:
    points = _FLOATS, types.CPointer(types.float32)
    mesh = *points, _INDICES, _INDICES, types.intp, _INDICES, types.intp
    return types.boolean(*mesh, types.intp, types.intp, _INDICES, _FLOATS, _FLOATS, _FLOATS)
