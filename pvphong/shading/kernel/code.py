"""Compiled code: callable through addresses, kept on disk, and compiled by another process if a call must not wait.

On disk there is a file for each function and its types, in Numba's cache folder. If NUMBA_CACHE_DIR is set, this is a
folder in it. If not, it is `__pycache__` next to the module, or the user's cache folder if `__pycache__` is not
writable. The file is written under another name and renamed. It starts with two digests: one of everything that the
code depends on, and one of the code itself. A file that is damaged, truncated or of another version is treated as
missing and rewritten. So any number of processes may read and write at once. (Numba's own cache has two problems. Its
files share an index, in which two concurrent writers can assign one function the other's code. And it checks only the
source file of the function itself, not those of the functions that it calls.)

If a call must not wait, another process compiles the missing code; it may outlive this process. This process requests
each piece only once, so that code that cannot be compiled is not tried repeatedly.
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
    """Raised if a function is not compiled yet and the caller must not wait.

    Attributes
    ----------
    key : tuple
        Key of the function and its types.
    """

    def __init__(self, key: Key) -> None:
        super().__init__(key)
        self.key = key


class Request(NamedTuple):
    """Request for code: an equation, the type in which vertices are stored, and the type of the arithmetic."""

    equation: Equation
    stored: str
    real: str


# --- on disk

_DIGEST = 32
_VERSIONS = (numba.__version__, llvmlite.__version__, np.__version__, sys.version)


class Store:
    """Cache of the code of one function, with the interface that Numba's `CFunc` expects.

    Parameters
    ----------
    function : callable
        The function to compile.
    sources : bytes
        Digest of all source files on which the function's code depends.

    Raises
    ------
    RuntimeError, OSError
        If no folder is writable, or the function has no source file.
    """

    def __init__(self, function: Callable[..., Any], sources: bytes) -> None:
        self._function, self._sources = function, sources
        self._form = CompileResultCacheImpl(function)

    @property
    def folder(self) -> Path:
        """Folder of the files with this function's compiled code."""
        return Path(self._form.locator.get_cache_path())

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Return the function's code for a signature; None if it is not on disk, or damaged or out of date there."""
        context.refresh()
        path, key = self._path_and_key(signature, context.codegen())
        with contextlib.suppress(Exception):  # no file, or any error of pickle and Numba while reading it
            data = path.read_bytes()
            code = data[2 * _DIGEST :]
            if data[: 2 * _DIGEST] == key + digest(code):
                return self._form.rebuild(context, pickle.loads(code))
        return None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Write the function's code for a signature to disk, if possible."""
        path, key = self._path_and_key(signature, result.codegen)
        code = dumps(self._form.reduce(result))
        with contextlib.suppress(ValueError), written_aside(path) as aside:  # full disk, deleted folder
            aside.write_bytes(key + digest(code) + code)

    def _path_and_key(self, signature: Any, codegen: Any) -> tuple[Path, bytes]:
        """Return the path of the function's file for a signature, and the key at the start of the file.

        The file's name is a digest of the function, its types, the values that it closes over, the processor and
        Python. The key is a digest of versions, sources and bytecode. `codegen` is Numba's code generator.
        """
        function = self._function
        cells = dumps(tuple(cell.cell_contents for cell in function.__closure__ or ()))
        place = repr((function.__module__, function.__qualname__, str(signature), codegen.magic_tuple()))
        name = digest(place.encode() + cells + sys.implementation.cache_tag.encode()).hex()[:16]
        key = digest(repr(_VERSIONS).encode() + self._sources + function.__code__.co_code)
        return self.folder / f"{function.__name__}-{name}.pvphong", key


def digest(data: bytes) -> bytes:
    """Return the SHA-256 digest of `data`, as `_DIGEST` bytes."""
    return hashlib.sha256(data).digest()


# --- in this process


_FLOATS = types.CPointer(types.float64)
# Seconds until missing code is looked for on disk again.
_PATIENCE = 0.5

_REALS = {"float32": types.float32, "float64": types.float64}
_OPTIONS = {"error_model": "numpy", "nopython": True}


class _Absent(Exception):
    """Raised if a function's code is not on disk."""


class Code(CFunc):
    """A compiled function. Other compiled code calls it by its address, and Python by `call`.

    Its code is read from disk if it is there. If not, and `compiles` is True, the code is compiled and written to disk.
    If `compiles` is False, `_Absent` is raised.
    """

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
        """The function, which takes addresses and integers and runs without the interpreter's lock."""

    def _compile_uncached(self) -> Any:
        if not self._compiles:
            raise _Absent
        with event.trigger_event("numba:compile"):
            return super()._compile_uncached()  # type: ignore[misc]  # Numba has no types


def store_of(function: Callable[..., Any]) -> Store | None:
    """Return the cache on disk for a function's code. Return None if no folder is writable, or sources are missing."""
    formulas = [cell.cell_contents for cell in function.__closure__ or () if callable(cell.cell_contents)]
    modules = {each.__module__ for each in (function, *formulas)}
    if not all(map(_is_own, modules)):  # a user's formula may call any other
        modules |= {each.__module__ for each in FORMULAS}
    try:
        return Store(function, _sources(tuple(sorted(modules))))
    except (RuntimeError, OSError, TypeError):  # inspect raises TypeError for interactive code
        return None


def _is_own(module: str) -> bool:
    return module.startswith("pvphong.")


@functools.cache
def _sources(modules: tuple[str, ...]) -> bytes:
    """Return a digest of all source code that functions of the named modules may call.

    This is the source of these modules, and of the packages with the kernel and the formulas. Raise OSError if a source
    file is missing.
    """
    here = Path(__file__).parent
    folders = here, *(here.parents[1] / package for package in ("base", "geometry", "optics"))
    called = [source.read_text("utf-8") for folder in folders for source in sorted(folder.rglob("*.py"))]
    own = [inspect.getsource(sys.modules[module]) for module in modules if not _is_own(module)]
    return digest("".join([*called, *own]).encode())


def code_identity(function: Callable[..., Any]) -> tuple[CodeType, tuple[Any, ...]]:
    """Return a function's bytecode and the values that it closes over.

    Two functions that do the same have equal results.
    """
    return function.__code__, tuple(cell.cell_contents for cell in function.__closure__ or ())


class Library:
    """The code that this process has compiled or read from disk."""

    has_run: ClassVar[bool] = False
    """True if compiled code has lit vertices, computed normals or split points in this process."""

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
        """The same library, but it raises `NotCompiled` instead of compiling."""
        library = copy.copy(self)
        library._compiles = False
        return library

    @property
    def folder(self) -> Path | None:
        """Folder of this package's code; None if no folder is writable."""
        store = store_of(store_of)
        return None if store is None else store.folder

    @property
    def lock(self) -> Path | None:
        """File that is locked while a process compiles in advance; None if `folder` is None."""
        return self.folder and self.folder / "pvphong.lock"

    def stage(self, function: Callable[..., Any], real: str) -> int:
        """Return the address of a compiled stage, the loop over a block for a light or reflectance.

        `function` is the stage's Python function. `real` is the type of the block's numbers, "float32" or "float64".
        """
        return self._code(function, stage_signature, real).where

    def call(self, function: Callable[..., Any], signature: Callable[..., Any], *kinds: str) -> Callable[..., int]:
        """Return a compiled function that is not a stage.

        Parameters
        ----------
        function : callable
            The Python function.
        signature : callable
            Returns the function's signature. It is called with one Numba type for each of `kinds`.
        *kinds : str
            "float32" or "float64".
        """
        return self._code(function, signature, *kinds).call

    def _code(self, function: Callable[..., Any], signature: Callable[..., Any], *kinds: str) -> Code:
        """Return a function's code for the types named in `kinds`; arguments as for `call`.

        The code is read from disk or compiled at the first call.

        The key of the cache is `code_identity`, not the function, because each use of a stage creates a new function. A
        library that does not compile raises NotCompiled if the code is not on disk, or while another thread is
        compiling.
        """
        key = *code_identity(function), kinds
        code = self._codes.get(key)
        if code is not None:
            return code
        if not self._compiles and time.monotonic() < self._looks_again.get(key, 0.0):
            raise NotCompiled(key)
        # wait for another thread that reads code, in milliseconds, but not for one that compiles, in seconds
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
    """Return Numba's signature of a stage: three pointers as arguments, and an integer as result.

    `real` is the Numba type of the rows.
    """
    return types.intp(_FLOATS, types.CPointer(real), _FLOATS)


# --- by another process


class _Compiler:
    """The process that compiles, and the pieces that this process has requested."""

    asked: ClassVar[set[Key]] = set()
    process: ClassVar[subprocess.Popen[bytes] | None] = None
    lock: ClassVar[threading.Lock] = threading.Lock()


def ask_for(missing: Key, request: Request | None, lock: Path | None) -> None:
    """Start a process that compiles missing code.

    Do nothing if this code was requested before, or a compiler is running.

    Parameters
    ----------
    missing
        Key of the missing code.
    request : Request or None
        Equation whose code is compiled first; None if the missing code belongs to the code that is always compiled.
    lock : Path or None
        File that the compiling process locks; None if code cannot be kept on disk, so that no process is started.
    """
    with _Compiler.lock:
        is_running = _Compiler.process is not None and _Compiler.process.poll() is None
        if lock is None or is_running or missing in _Compiler.asked:
            return
        with locked(lock) as is_alone:
            if not is_alone:
                return
        _Compiler.asked.add(missing)
        with contextlib.suppress(OSError):  # without processes, memory or disk space, nothing is compiled
            _Compiler.process = _start(request)


def if_compiled(library: Library, find: Callable[[Library], Found]) -> Found | None:
    """Call `find` with a library that does not compile, and return the result.

    If code is missing, let another process compile it, and return None.
    """
    try:
        return find(library.cached_only)
    except NotCompiled as missing:
        ask_for(missing.key, None, library.lock)
        return None


def _start(request: Request | None) -> subprocess.Popen[bytes] | None:
    """Start a compiling process at low priority, detached from the terminal, and return it.

    In a program that embeds Python, start no process and return None. `request` is passed to the process.
    """
    if not Path(sys.executable or "").name.lower().startswith("python"):
        return None
    try:
        pickled = pickle.dumps(request)
    except Exception:  # a user's light may raise anything
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
    """Mark the process as ended, so that Popen does not warn that it is still running."""
    process.returncode = process.returncode or 0
