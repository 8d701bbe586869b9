"""Compiled code: compiled for use through addresses, kept on disk, and compiled by another process meanwhile.

On disk there is a file for each function and its types, in Numba's cache folder: `__pycache__` beside the module, or
the user's own where that cannot be written to, or one in NUMBA_CACHE_DIR if that is set. It is written aside and
renamed, and starts with a digest of all that the code depends on and one of the code itself, so that a file that is
damaged, cut short, or of another version of anything counts as absent, and is written anew. So any number of processes
may read and write at once. (Numba's own files share an index, in which two processes that write at once can give one
function the other's code; and it looks only at the file of the function itself, where here all sources count that a
function may call.)

Where a call is not to wait, another process compiles the code that is missing; it may outlive this one. This process
asks for each piece once, so that one that cannot be compiled is not tried over and over.
"""

from __future__ import annotations

import atexit
import contextlib
import copy
import ctypes
import functools
import hashlib
import inspect
import pickle
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import CodeType
from typing import Any, ClassVar, NamedTuple, TypeVar

import llvmlite
import numba
import numpy as np
from numba import types
from numba.core import event
from numba.core.caching import CompileResultCacheImpl
from numba.core.ccallback import CFunc
from numba.core.serialize import dumps

from pvphong.base.files import locked, written_aside
from pvphong.base.formulas import FORMULAS
from pvphong.base.processes import environment
from pvphong.shading.equation import Equation
from pvphong.shading.kernel import arithmetic

Key = tuple[CodeType, tuple[Any, ...], tuple[str, ...]]
"""Identifies a piece of code: a function's code, the values it closes over, names of its types."""

_MODULE = "pvphong.shading.kernel.ahead"

Found = TypeVar("Found")


class NotCompiled(Exception):
    """There is no code of a function, and the call is not to wait for it.

    Attributes
    ----------
    key : tuple
        Of the function and its types.
    """

    def __init__(self, key: Key) -> None:
        super().__init__(key)
        self.key = key


class Request(NamedTuple):
    """What is to be lit: an equation, the type in which vertices are stored, and that of the arithmetic."""

    equation: Equation
    stored: str
    real: str


# --- on disk

_DIGEST = 32
_VERSIONS = (numba.__version__, llvmlite.__version__, np.__version__, sys.version)


class Store:
    """Where the code of one function is kept, in the form in which Numba's `CFunc` asks for it.

    Parameters
    ----------
    function : callable
        What is compiled.
    sources : bytes
        A digest of all else that its code is made of.

    Raises
    ------
    RuntimeError, OSError
        If there is no folder that can be written to, or no source of the function.
    """

    def __init__(self, function: Callable[..., Any], sources: bytes) -> None:
        self._function, self._sources = function, sources
        self._form = CompileResultCacheImpl(function)

    @property
    def folder(self) -> Path:
        """Where the files are."""
        return Path(self._form.locator.get_cache_path())

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Code for a signature, or None."""
        context.refresh()
        path, key = self._path_and_key(signature, context.codegen())
        with contextlib.suppress(Exception):  # no file, or whatever pickle and Numba raise where they cannot read it
            data = path.read_bytes()
            code = data[2 * _DIGEST :]
            if data[: 2 * _DIGEST] == key + digest(code):
                return self._form.rebuild(context, pickle.loads(code))
        return None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep code, if that is possible."""
        path, key = self._path_and_key(signature, result.codegen)
        code = dumps(self._form.reduce(result))
        with contextlib.suppress(ValueError), written_aside(path) as aside:  # a full disk, a folder that is gone
            aside.write_bytes(key + digest(code) + code)

    def _path_and_key(self, signature: Any, codegen: Any) -> tuple[Path, bytes]:
        """A file's name is a digest of the function, its types, the values it closes over, the processor and Python.

        The key in the file is one of versions, sources and bytecode: all that its code was made from.
        """
        function = self._function
        cells = dumps(tuple(cell.cell_contents for cell in function.__closure__ or ()))
        place = repr((function.__module__, function.__qualname__, str(signature), codegen.magic_tuple()))
        name = digest(place.encode() + cells + sys.implementation.cache_tag.encode()).hex()[:16]
        key = digest(repr(_VERSIONS).encode() + self._sources + function.__code__.co_code)
        return self.folder / f"{function.__name__}-{name}.pvphong", key


def digest(data: bytes) -> bytes:
    """SHA-256 of some bytes: `_DIGEST` bytes."""
    return hashlib.sha256(data).digest()


# --- in this process


_FLOATS = types.CPointer(types.float64)
# Seconds until code that was not on disk is looked for there again.
_PATIENCE = 0.5

_REALS = {"float32": types.float32, "float64": types.float64}
_OPTIONS = {"error_model": "numpy", "nopython": True}


class _Absent(Exception):
    """No code of a function is kept."""


class Code(CFunc):
    """A function that is called by its address: read from disk if it is there, else compiled and written."""

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
    modules = {each.__module__ for each in (function, *formulas)}
    if not all(map(_is_own, modules)):  # a formula of the user's may call any other
        modules |= {each.__module__ for each in FORMULAS}
    try:
        return Store(function, _sources(tuple(sorted(modules))))
    except (RuntimeError, OSError, TypeError):  # inspect raises the last for what was typed into an interpreter
        return None


def _is_own(module: str) -> bool:
    return module.startswith("pvphong.")


@functools.cache
def _sources(modules: tuple[str, ...]) -> bytes:
    """A digest of all sources that functions of some modules may call; OSError if there are none.

    These are the modules', and all of the packages that hold the kernel and the formulas.
    """
    here = Path(__file__).parent
    folders = here, *(here.parents[1] / package for package in ("base", "geometry", "optics"))
    called = [source.read_text("utf-8") for folder in folders for source in sorted(folder.rglob("*.py"))]
    own = [inspect.getsource(sys.modules[module]) for module in modules if not _is_own(module)]
    return digest("".join([*called, *own]).encode())


def code_identity(function: Callable[..., Any]) -> tuple[CodeType, tuple[Any, ...]]:
    """Equal for functions that do the same: code, and the values it was made with."""
    return function.__code__, tuple(cell.cell_contents for cell in function.__closure__ or ())


class Library:
    """What has been compiled or read from disk in this process."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._is_compiling = threading.Event()
        self._codes: dict[Key, Code] = {}
        self._looks_again: dict[Key, float] = {}
        self._compiles = True

    def __len__(self) -> int:
        return len(self._codes)

    @functools.cached_property
    def cached_only(self) -> Library:
        """The same library, which raises `NotCompiled` instead of compiling."""
        library = copy.copy(self)
        library._compiles = False
        return library

    @property
    def folder(self) -> Path | None:
        """Where this package's code is kept; None if there is no folder to keep code in."""
        store = store_of(store_of)
        return None if store is None else store.folder

    @property
    def lock(self) -> Path | None:
        """The file that is locked by the process that compiles in advance; None as for `folder`."""
        return self.folder and self.folder / "pvphong.lock"

    def stage(self, function: Callable[..., Any], real: str) -> int:
        """Address of a light's or reflectance's stage for a type of rows."""
        return self._code(function, stage_signature, real).where

    def call(self, function: Callable[..., Any], signature: Callable[..., Any], *kinds: str) -> Callable[..., int]:
        """Any other function; its signature is made of Numba's types of the names of some."""
        return self._code(function, signature, *kinds).call

    def _code(self, function: Callable[..., Any], signature: Callable[..., Any], *kinds: str) -> Code:
        """Looked up by `code_identity`, for lights make their stages anew each time, and the names of types."""
        key = *code_identity(function), kinds
        code = self._codes.get(key)
        if code is not None:
            return code
        if not self._compiles and time.monotonic() < self._looks_again.get(key, 0.0):
            raise NotCompiled(key)
        # another thread reads code in milliseconds, and compiles it in seconds
        waits = self._compiles or not self._is_compiling.is_set()
        if not self._lock.acquire(blocking=waits):
            raise NotCompiled(key)
        try:
            if key not in self._codes:
                if self._compiles:
                    self._is_compiling.set()
                types_of_arguments = signature(*(_REALS[kind] for kind in kinds))
                self._codes[key] = Code(function, types_of_arguments, compiles=self._compiles)
            return self._codes[key]
        except _Absent:
            self._looks_again[key] = time.monotonic() + _PATIENCE
            raise NotCompiled(key) from None
        finally:
            self._is_compiling.clear()
            self._lock.release()


def stage_signature(real: Any) -> Any:
    """Of all stages: numbers, rows and points, to an integer."""
    return types.intp(_FLOATS, types.CPointer(real), _FLOATS)


# --- by another process


class _Compiler:
    """The process that compiles, and the pieces for which this process has started one."""

    asked: ClassVar[set[Key]] = set()
    process: ClassVar[subprocess.Popen[bytes] | None] = None
    lock: ClassVar[threading.Lock] = threading.Lock()


def ask_for(missing: Key, request: Request | None, lock: Path | None) -> None:
    """Start compiling what is missing for a request, unless this process has done so before or a compiler is at work.

    Without a request, what is missing is among all that there is to compile.
    `lock` is held by the process that compiles; None if code cannot be kept.
    """
    with _Compiler.lock:
        is_running = _Compiler.process is not None and _Compiler.process.poll() is None
        if lock is None or is_running or missing in _Compiler.asked:
            return
        with locked(lock) as is_alone:
            if not is_alone:
                return
        _Compiler.asked.add(missing)
        with contextlib.suppress(OSError):  # no processes, no memory, no room: then it is not compiled
            _Compiler.process = _start(request)


def if_compiled(library: Library, find: Callable[[Library], Found]) -> Found | None:
    """What is found of code that is there; None where some is missing, and another process compiles it."""
    try:
        return find(library.cached_only)
    except NotCompiled as missing:
        ask_for(missing.key, None, library.lock)
        return None


def _start(request: Request | None) -> subprocess.Popen[bytes] | None:
    """A compiler at low priority, apart from this process's terminal; None in a program that only embeds Python."""
    if not Path(sys.executable or "").name.lower().startswith("python"):
        return None
    try:
        pickled = pickle.dumps(request)
    except Exception:  # a light of the user's may raise anything
        pickled = b""
    with tempfile.TemporaryFile() as file:
        file.write(pickled)
        file.seek(0)
        process = subprocess.Popen(
            [sys.executable, "-W", "ignore", "-m", _MODULE],
            stdin=file,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=environment(),
            start_new_session=True,
        )
    atexit.register(_leave, process)
    return process


def _leave(process: subprocess.Popen[bytes]) -> None:
    """Mark the process as ended, or Popen would warn that it still runs."""
    process.returncode = process.returncode or 0
