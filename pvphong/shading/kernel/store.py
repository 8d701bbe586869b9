"""Compiled code on disk: a file for each function, with its types, where Numba would keep it.

A file is written aside and renamed. It starts with a digest of all that the code depends on and one of the code itself,
so that what is damaged, cut short, or of another version of anything is as if it were not there, and is written anew.
So any number of processes may read and write at once. (Numba's own files share an index, in which two processes that
write at once can give one function the other's code.)
"""

from __future__ import annotations

import contextlib
import hashlib
import pickle
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core.caching import CompileResultCacheImpl
from numba.core.serialize import dumps

from pvphong.base.files import written_aside

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
        with contextlib.suppress(OSError):
            kept = path.read_bytes()
            code = kept[2 * _DIGEST :]
            if kept[: 2 * _DIGEST] == key + digest(code):
                return self._form.rebuild(context, pickle.loads(code))
        return None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep code, if that is possible."""
        path, key = self._path_and_key(signature, result.codegen)
        code = dumps(self._form.reduce(result))
        with contextlib.suppress(ValueError), written_aside(path) as aside:  # a full disk, a folder that is gone
            aside.write_bytes(key + digest(code) + code)

    def _path_and_key(self, signature: Any, codegen: Any) -> tuple[Path, bytes]:
        """A file's name says for what the code is, the key of what it was made."""
        function = self._function
        cells = dumps(tuple(cell.cell_contents for cell in function.__closure__ or ()))
        place = repr((function.__module__, function.__qualname__, str(signature), codegen.magic_tuple()))
        name = digest(place.encode() + cells + sys.implementation.cache_tag.encode()).hex()[:16]
        key = digest(repr(_VERSIONS).encode() + self._sources + function.__code__.co_code)
        return self.folder / f"{function.__name__}-{name}.pvphong", key


def digest(data: bytes) -> bytes:
    """Of `_DIGEST` bytes."""
    return hashlib.sha256(data).digest()
