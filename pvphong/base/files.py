"""Files that are there whole or not at all.

A file is written in a folder of its own beside its place, `.pvphong-` and eight letters, and renamed. The folder holds
a file that is locked while its writer lives, so that whoever writes there next can clear what a killed process left.
"""

from __future__ import annotations

import errno
import json
import os
import shutil
import stat
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from pvphong.base import check
from pvphong.base.lock import locked

PREFIX = ".pvphong-"
"""What the name of a folder begins with that is written in."""

_PATTERN = PREFIX + "????????"
_LOCK = "owner.lock"
_TRIES = 10  # where files cannot be locked, nothing is ever cleared, and no lock is needed
_STRAY = 60.0  # seconds after which an empty folder has lost its maker
_WRITABLE = "a file that can be written"
_NO_ROOM = (errno.EFBIG, errno.ENOSPC, errno.EDQUOT)

announce: list[Callable[[Path], None]] = []
"""Called with each folder that is about to be written in, by whoever clears it should this process be killed."""


@contextmanager
def written_aside(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary path beside `path` to write to; moved there at the end, removed if anything fails.

    The temporary name keeps the suffix, because writers choose their format by it. A file that was there before is
    replaced in one step, when the new one is on the disk; its mode and owner are kept, and links that lead to it. A
    pipe or a character device is written into.

    Raises
    ------
    ValueError
        If the folder does not exist or cannot be written to, if what is there can be neither replaced nor written
        into, or if writing fails.
    """
    target = Path(os.path.realpath(path))  # a link keeps pointing to the file
    old = _status(path)
    poured = old is not None and (stat.S_ISFIFO(old.st_mode) or stat.S_ISCHR(old.st_mode))
    if not poured:
        _refuse_place(target, old)
    with folder_aside(Path(tempfile.gettempdir()) if poured else target.parent) as aside:
        written = aside / f"written{target.suffix}"  # a name that every writer can take
        try:
            yield written
            if poured:
                _pour(written, Path(path))
            else:
                _take_place(written, target, old)
        except OSError as error:
            raise ValueError(f"path must be {_WRITABLE}; got {target} ({error}).") from error


@contextmanager
def folder_aside(place: Path) -> Iterator[Path]:
    """A new folder in another, which is removed at the end; what killed processes left of such is cleared first.

    Raises
    ------
    ValueError
        If no folder can be made there.
    """
    try:
        _clear(place)
        with ExitStack() as held:
            aside = _owned(place, held)
            try:
                yield aside
            finally:
                held.close()  # a locked file cannot be removed everywhere
                shutil.rmtree(aside, ignore_errors=True)
    except _NoFolder as error:
        raise ValueError(f"path must be in a folder that can be written to; got {place} ({error}).") from error


def reserve(aside: Path, size: int) -> None:
    """Find out whether there is room for a file, where a writer would not notice that there is none.

    Raises
    ------
    OSError
        If the disk, a quota or a limit on the size of files does not allow it.
    """
    free = shutil.disk_usage(aside.parent).free
    if free < size:
        raise OSError(f"it needs up to {size / 2**20:.1f} MiB on its disk, and {free / 2**20:.1f} are free")
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


def settle(written: Path) -> None:
    """Bring a file to the disk: some disks and quotas say only now that they are full.

    Raises
    ------
    OSError
        If that fails.
    """
    with written.open("rb+") as file:
        os.fsync(file.fileno())


class _NoFolder(OSError):
    """No folder can be made."""


def _status(path: str | os.PathLike[str]) -> os.stat_result | None:
    """Of the file that is there; None if there is none."""
    try:
        return os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError as error:  # a loop of links, a name that is too long, a folder that may not be searched
        raise ValueError(f"path must be {_WRITABLE}; got {os.fspath(path)} ({error.strerror}).") from error


def _refuse_place(target: Path, old: os.stat_result | None) -> None:
    folder = target.parent
    if not folder.is_dir():
        check.refuse("path", target, "in a folder that exists", f"Create {folder} first.")
    if old is None:
        return
    if stat.S_ISDIR(old.st_mode):
        check.refuse("path", target, "a file", "It is a folder.")
    if not stat.S_ISREG(old.st_mode):
        check.refuse("path", target, "a file, a pipe or a character device")
    if not os.access(target, os.W_OK):
        check.refuse("path", target, _WRITABLE, "It is write-protected.")


def _owned(place: Path, held: ExitStack) -> Path:
    """A new folder in which a file stays locked for as long as `held` is open."""
    for left in reversed(range(_TRIES)):
        try:
            aside = Path(tempfile.mkdtemp(prefix=PREFIX, dir=place))
        except OSError as error:
            raise _NoFolder(error.strerror) from error
        for tell in announce:
            tell(aside)
        if held.enter_context(locked(aside / _LOCK)) or not left:
            break
        shutil.rmtree(aside, ignore_errors=True)  # another writer took the lock first, and is clearing the folder
    return aside


def _clear(place: Path) -> None:
    """Remove the folders of processes that have ended."""
    for left in place.glob(_PATTERN):
        with suppress(OSError):
            if (left / _LOCK).exists():
                with locked(left / _LOCK, makes=False) as is_left:
                    if is_left:
                        shutil.rmtree(left, ignore_errors=True)
                if is_left:  # but for the locked file itself, where that cannot be removed
                    shutil.rmtree(left, ignore_errors=True)
            elif time.time() - left.stat().st_mtime > _STRAY:
                left.rmdir()


def _take_place(written: Path, target: Path, old: os.stat_result | None) -> None:
    settle(written)
    if old is not None:
        with suppress(OSError):  # only the system's administrator gives files away
            if (old.st_uid, old.st_gid) != (written.stat().st_uid, written.stat().st_gid):
                os.chown(written, old.st_uid, old.st_gid)
        written.chmod(stat.S_IMODE(old.st_mode))
    written.replace(target)


def _pour(written: Path, target: Path) -> None:
    with written.open("rb") as source, open(os.open(target, os.O_WRONLY), "wb") as sink:
        shutil.copyfileobj(source, sink)


def write_json(document: Any, path: str | os.PathLike[str]) -> None:
    """Write plain values to a JSON file.

    Raises
    ------
    ValueError
        If the file cannot be written.
    """
    with written_aside(path) as aside:
        aside.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")
