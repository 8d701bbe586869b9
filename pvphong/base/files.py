"""Atomic writes of files, and locks between processes.

A file is written in a temporary folder next to its destination, and then renamed. The folder's name is `.pvphong-` and
eight characters. The folder contains a lock file. The writer keeps this file locked while it runs. So the next writer
recognizes the folders of killed processes, and removes them.
"""

from __future__ import annotations

import errno
import json
import os
import shutil
import stat
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from pvphong.base import check

if sys.platform == "win32":
    import msvcrt

    def _take(file: int) -> None:
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
else:
    import fcntl

    def _take(file: int) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


PREFIX = ".pvphong-"
"""Prefix of the names of temporary folders."""

_LOCK = "owner.lock"
_TRIES = 10  # where files cannot be locked, all tries fail; but then no process removes folders, and no lock is needed
_NO_ROOM = (errno.EFBIG, errno.ENOSPC, errno.EDQUOT)

announce: list[Callable[[Path], None]] = []
"""Functions that are called with each new temporary folder, so that a watcher can remove it if this process is
killed."""


@contextmanager
def written_aside(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path next to `path`; after the block, move the file from there to `path`.

    If anything fails, the temporary file is removed. The temporary name has the suffix of `path` in lower case, because
    writers choose their format by the suffix. An existing file is replaced atomically once the new file is on the disk.
    Its mode and owner are kept, and links to it stay valid. If `path` is a pipe or a character device, the content is
    copied into it.

    Raises
    ------
    ValueError
        If the folder does not exist or is not writable, if the existing file cannot be replaced or written to, or if
        writing fails.
    """
    target = Path(os.path.realpath(path))  # a link keeps pointing to the file
    try:
        old = os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        old = None
    except OSError as error:  # a loop of links, a name that is too long, a folder without search permission
        raise ValueError(
            f"path must be a file that can be written; got {os.fspath(path)} ({error.strerror})."
        ) from error
    is_stream = old is not None and (stat.S_ISFIFO(old.st_mode) or stat.S_ISCHR(old.st_mode))
    if not is_stream:
        _refuse_target(target, old)
    with folder_aside(Path(tempfile.gettempdir()) if is_stream else target.parent) as folder:
        written = folder / f"written{target.suffix.lower()}"  # ASCII, for writers that accept nothing else
        try:
            yield written
            if is_stream:
                with written.open("rb") as source, open(os.open(path, os.O_WRONLY), "wb") as sink:
                    shutil.copyfileobj(source, sink)
                return
            sync(written)
            if old is not None:
                with suppress(OSError):  # only an administrator can change the owner
                    if (old.st_uid, old.st_gid) != (written.stat().st_uid, written.stat().st_gid):
                        os.chown(written, old.st_uid, old.st_gid)
                written.chmod(stat.S_IMODE(old.st_mode))
            written.replace(target)
        except OSError as error:
            raise ValueError(f"path must be a file that can be written; got {target} ({error}).") from error


def _refuse_target(target: Path, old: os.stat_result | None) -> None:
    """Raise ``ValueError`` if no file can be written to the path `target`.

    The target's folder must exist. If something exists at the path, it must be a regular file that can be written.
    `old` is its status, or None if nothing exists there.
    """
    if not target.parent.is_dir():
        check.refuse("path", target, "in a folder that exists", f"Create {target.parent} first.")
    if old is None:
        return
    if stat.S_ISDIR(old.st_mode):
        check.refuse("path", target, "a file", "It is a folder.")
    if not stat.S_ISREG(old.st_mode):
        check.refuse("path", target, "a file, a pipe or a character device")
    if not os.access(target, os.W_OK):
        check.refuse("path", target, "a file that can be written", "It is write-protected.")


@contextmanager
def folder_aside(place: Path) -> Iterator[Path]:
    """Create a temporary folder in the folder `place` for the duration of the block, and yield it.

    Before that, temporary folders in `place` whose processes were killed are removed.

    Raises
    ------
    ValueError
        If the folder cannot be created.
    """
    _clear_abandoned(place)
    with ExitStack() as owned:
        for left in reversed(range(_TRIES)):
            try:
                folder = Path(tempfile.mkdtemp(prefix=PREFIX, dir=place))
            except OSError as error:
                reason = f"got {place} ({error.strerror})"
                raise ValueError(f"path must be in a folder that can be written to; {reason}.") from error
            for notify in announce:
                notify(folder)
            if owned.enter_context(locked(folder / _LOCK)) or not left:
                break
            _remove(folder)  # another writer took the lock first, and is clearing the folder
        try:
            yield folder
        finally:
            owned.close()  # some systems cannot remove a locked file
            _remove(folder)


def _clear_abandoned(place: Path) -> None:
    """Remove the temporary folders in the folder `place` whose processes have ended."""
    for folder in place.glob(PREFIX + "????????"):
        with suppress(OSError):
            if (folder / _LOCK).exists():
                with locked(folder / _LOCK, makes=False) as is_abandoned:
                    if is_abandoned:
                        _remove(folder)
                if is_abandoned:  # some systems could not remove the lock file while it was locked
                    _remove(folder)
            else:
                folder.rmdir()  # only if empty; if a writer has just created it, the writer creates another


def _remove(folder: Path) -> None:
    """Remove a temporary folder and its content.

    The lock file is removed last. So if this process is killed meanwhile, another process recognizes the folder as
    abandoned.
    """
    with suppress(OSError):
        for entry in folder.iterdir():
            if entry.is_dir():
                shutil.rmtree(entry, ignore_errors=True)
            elif entry.name != _LOCK:
                entry.unlink(missing_ok=True)
    shutil.rmtree(folder, ignore_errors=True)


def reserve(aside: Path, size: int) -> None:
    """Check that a file of `size` bytes at the path `aside` fits on the disk.

    Call this function before a writer that does not report a full disk.

    Raises
    ------
    OSError
        If the disk, a quota or the limit on file sizes does not allow it.
    """
    free = shutil.disk_usage(aside.parent).free
    if free < size:
        raise OSError(f"it needs up to {size / 2**20:.1f} MiB on its disk, and only {free / 2**20:.1f} MiB are free")
    if not hasattr(os, "posix_fallocate"):
        return
    trial = aside.with_name("room")
    try:
        with trial.open("wb") as file:
            os.posix_fallocate(file.fileno(), 0, max(size, 1))
    except OSError as error:
        if error.errno in _NO_ROOM:
            raise OSError(f"it needs up to {size / 2**20:.1f} MiB: {error.strerror}") from error
    finally:
        trial.unlink(missing_ok=True)


def sync(written: Path) -> None:
    """Flush the file at the path `written` to the disk.

    Some file systems report a full disk or quota only when they flush a file. This function then raises ``OSError``.
    """
    with written.open("rb+") as file:
        os.fsync(file.fileno())


def write_json(document: Any, path: str | os.PathLike[str]) -> None:
    """Write a value to a JSON file; raise ``ValueError`` if the file cannot be written."""
    with written_aside(path) as aside:
        aside.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")


@contextmanager
def locked(path: Path, *, makes: bool = True) -> Iterator[bool]:
    """Lock a file for the duration of the block; yield True if this process has the lock, else False.

    False means that the file is missing, cannot be created or locked, or was removed in the meantime. If `makes`, a
    missing file is created; it is not removed at the end. The system releases the lock when the process that holds it
    ends.
    """
    try:
        file = path.open("ab" if makes else "r+b")
    except OSError:
        yield False
        return
    with file:
        try:
            _take(file.fileno())
            # the previous owner may have removed the file, and another process may have created a new one
            is_taken = os.path.samestat(os.fstat(file.fileno()), path.stat())
        except OSError:
            is_taken = False
        if is_taken:
            yield True
            return
    yield False
