"""Has code compiled by a process of its own, for which nobody waits and which outlives this one if need be.

It is asked once for each piece of code that is missing, so that one that cannot be compiled is not tried over and over.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import pickle
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from pathlib import Path
from types import CodeType
from typing import Any, ClassVar, NamedTuple

from pvphong.base.files import locked
from pvphong.shading.equation import Equation

Key = tuple[CodeType, tuple[Any, ...], Callable[..., Any], tuple[str, ...]]
"""Of a piece of code: a function's code, the values it was made with, its signature, and the names of its types."""

_MODULE = "pvphong.shading.kernel.compiling"


class NotCompiled(Exception):
    """There is no code of a function, and compiling it is not to be waited for.

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


class _Compiler:
    """What this process has asked for."""

    asked: ClassVar[set[Key]] = set()
    process: ClassVar[subprocess.Popen[bytes] | None] = None
    lock: ClassVar[threading.Lock] = threading.Lock()


def ask_for(missing: Key, request: Request | None, lock: Path | None) -> None:
    """Start compiling what is missing for a request, unless it was asked for before or a compiler is at work.

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


def _start(request: Request | None) -> subprocess.Popen[bytes] | None:
    """A compiler at low priority, apart from this process's terminal; None in a program that only embeds Python."""
    if not Path(sys.executable or "").name.lower().startswith("python"):
        return None
    try:
        said = pickle.dumps(request)
    except Exception:  # a light of the user's may raise anything
        said = b""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(path or os.getcwd() for path in sys.path)}
    with tempfile.TemporaryFile() as file:
        file.write(said)
        file.seek(0)
        process = subprocess.Popen(
            [sys.executable, "-W", "ignore", "-m", _MODULE],
            stdin=file,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=environment,
            start_new_session=True,
        )
    atexit.register(_leave, process)
    return process


def _leave(process: subprocess.Popen[bytes]) -> None:
    """Tell Popen that it has ended, or it would warn of a process that goes on."""
    process.returncode = process.returncode or 0
