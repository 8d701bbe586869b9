"""Compiles functions for use through their addresses, and keeps the code on disk.

A file of kept code that is damaged is thrown away and written anew; where no folder can be written to, code is not
kept. Numba asks only whether the file of a function itself has changed since; here all sources count that a function
may call, by a checksum in the key of its code.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import inspect
import sys
import threading
import zlib
from collections.abc import Callable
from types import CodeType
from typing import Any

import numba
from numba import types
from numba.core import event
from numba.core.caching import FunctionCache
from numba.core.ccallback import CFunc

from pvphong.base import ranges
from pvphong.shading.kernel import (
    adding,
    arithmetic,
    colors,
    driver,
    extremes,
    loading,
    pointers,
    powers,
    prefetch,
    rows,
    sunlight,
    toolkit,
    vectors,
    ways,
)
from pvphong.shading.kernel.records import SETTINGS, TERM

_SOURCES = (
    *(ranges, rows, arithmetic, pointers, vectors, loading, ways, powers, adding, colors, prefetch, sunlight),
    *(toolkit, driver, extremes),
)

_Key = tuple[CodeType, tuple[Any, ...], Callable[..., Any], tuple[str, ...]]

_BYTES, _FLOATS = types.CPointer(types.uint8), types.CPointer(types.float64)
_REALS = {"float32": types.float32, "float64": types.float64}
_OPTIONS = {"error_model": "numpy", "nopython": True}


@functools.cache
def _checksum(module: str) -> int:
    """Of all sources that a function of a module may call; OSError if there are none."""
    sources = [inspect.getsource(source) for source in (*_SOURCES, sys.modules[module])]
    return zlib.crc32("".join([*sources, repr((SETTINGS, TERM))]).encode())


class Cache(FunctionCache):  # type: ignore[misc]  # Numba has no types
    """Numba's, with the checksum in its keys."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        self._checksum = _checksum(function.__module__)

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        return (*super()._index_key(sig, codegen), self._checksum)


class Code(CFunc):
    """A function compiled for being called by its address, from here on."""

    def __init__(self, function: Callable[..., Any], signature: Any, cache: Cache | None) -> None:
        super().__init__(function, (signature.args, signature.return_type), {}, dict(_OPTIONS))
        if cache is not None:
            self._cache = cache
        self.compile()
        self.where = int(self.address or 0)
        pointers = [ctypes.c_size_t] * len(signature.args)
        self.call: Callable[..., int] = ctypes.CFUNCTYPE(ctypes.c_bool, *pointers)(self.where)
        """It with addresses and integers, without the interpreter's lock."""

    def _compile_uncached(self) -> Any:
        with event.trigger_event("numba:compile"):
            return super()._compile_uncached()  # type: ignore[misc]  # as above


def cache_of(function: Callable[..., Any]) -> Cache | None:
    """Where the code of a function is kept; None where Numba finds no folder to write to, or there are no sources."""
    try:
        return Cache(function)
    except (RuntimeError, OSError):
        return None


def compiled(function: Callable[..., Any], signature: Any) -> Any:
    """A function's code from disk, or compiled and kept there if that is possible."""
    cache = cache_of(function)
    if cache is not None:
        for _ in range(2):
            try:
                return Code(function, signature, cache)
            except Exception:
                with contextlib.suppress(OSError):
                    cache.flush()
    return Code(function, signature, None)  # what is wrong with the function is wrong without kept code too


class Library:
    """What has been compiled or read from disk in this process."""

    toolkit = toolkit

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._codes: dict[_Key, Code] = {}

    def __len__(self) -> int:
        return len(self._codes)

    @property
    def keeps_code(self) -> bool:
        """Whether there is a folder to keep code in."""
        return cache_of(driver.shade) is not None

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

    def _code(self, function: Callable[..., Any], signature: Callable[..., Any], *kinds: str) -> Code:
        """By what a function does, for lights make theirs anew each time; its signature is made of names of types."""
        cells = tuple(cell.cell_contents for cell in function.__closure__ or ())
        key = function.__code__, cells, signature, kinds
        code = self._codes.get(key)
        if code is None:
            with self._lock:
                code = self._codes.get(key)
                if code is None:
                    code = self._codes[key] = compiled(function, signature(*(_REALS[kind] for kind in kinds)))
        return code


def _stage_of_light(real: Any) -> Any:
    return types.boolean(_FLOATS, types.CPointer(real), _FLOATS)


def _stage_of_reflectance(real: Any) -> Any:
    return types.intp(_FLOATS, types.CPointer(real), _FLOATS)


def _driver(stored: Any, real: Any) -> Any:
    vertices, reals = types.CPointer(stored), types.CPointer(real)
    arrays = vertices, vertices, reals, reals, _BYTES
    equation = types.CPointer(numba.from_dtype(SETTINGS)), types.CPointer(numba.from_dtype(TERM)), _FLOATS
    scratch = reals, _FLOATS, _BYTES
    return types.boolean(*arrays, *equation, types.intp, types.intp, *scratch)


def _search(stored: Any) -> Any:
    rows = types.CPointer(stored)
    return types.boolean(rows, types.intp, types.intp, rows, _FLOATS)
