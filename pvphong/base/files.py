"""Files that are there whole or not at all, and locks between processes.

A file is written in a folder of its own beside its place, `.pvphong-` and eight letters, and renamed. The folder holds
a file that is locked while its writer lives, so that whoever writes there next can clear what a killed process left.
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
"""Beginning of the name of a folder that is written in."""

_LOCK = "owner.lock"
_TRIES = 10  # where files cannot be locked, nothing is ever cleared, and no lock is needed
_NO_ROOM = (errno.EFBIG, errno.ENOSPC, errno.EDQUOT)

announce: list[Callable[[Path], None]] = []
"""Called with each folder that is about to be written in, by whoever clears it should this process be killed."""


@contextmanager
def written_aside(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary path beside `path` to write to; moved there at the end, removed if anything fails.

    The temporary name keeps the suffix, in small letters, because writers choose their format by it. A file that was
    there before is replaced in one step, when the new one is on the disk; its mode and owner are kept, and links that
    lead to it. A pipe or a character device is written into.

    Raises
    ------
    ValueError
        If the folder does not exist or cannot be written to, if what is there can be neither replaced nor written
        into, or if writing fails.
    """
    target = Path(os.path.realpath(path))  # a link keeps pointing to the file
    try:
        old = os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        old = None
    except OSError as error:  # a loop of links, a name that is too long, a folder that may not be searched
        raise ValueError(
            f"path must be a file that can be written; got {os.fspath(path)} ({error.strerror})."
        ) from error
    is_stream = old is not None and (stat.S_ISFIFO(old.st_mode) or stat.S_ISCHR(old.st_mode))
    if not is_stream:
        _refuse_target(target, old)
    with folder_aside(Path(tempfile.gettempdir()) if is_stream else target.parent) as folder:
        written = folder / f"written{target.suffix.lower()}"  # a name that every writer can take
        try:
            yield written
            if is_stream:
                with written.open("rb") as source, open(os.open(path, os.O_WRONLY), "wb") as sink:
                    shutil.copyfileobj(source, sink)
                return
            sync(written)
            if old is not None:
                with suppress(OSError):  # only the system's administrator gives files away
                    if (old.st_uid, old.st_gid) != (written.stat().st_uid, written.stat().st_gid):
                        os.chown(written, old.st_uid, old.st_gid)
                written.chmod(stat.S_IMODE(old.st_mode))
            written.replace(target)
        except OSError as error:
            raise ValueError(f"path must be a file that can be written; got {target} ({error}).") from error


def _refuse_target(target: Path, old: os.stat_result | None) -> None:
    """Raise ``ValueError`` where no file can be, or where the one that is there may not be replaced."""
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
    """A new folder in another, which is removed at the end; what killed processes left of such is cleared first.

    Raises
    ------
    ValueError
        If no folder can be made there.
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
            owned.close()  # a locked file cannot be removed everywhere
            _remove(folder)


def _clear_abandoned(place: Path) -> None:
    """Remove the folders of processes that have ended."""
    for folder in place.glob(PREFIX + "????????"):
        with suppress(OSError):
            if (folder / _LOCK).exists():
                with locked(folder / _LOCK, makes=False) as is_abandoned:
                    if is_abandoned:
                        _remove(folder)
                if is_abandoned:  # but for the locked file itself, where that cannot be removed
                    _remove(folder)
            else:
                folder.rmdir()  # if it is empty: one who has just made it makes another


def _remove(folder: Path) -> None:
    """Remove a folder with what is in it, its lock last: if this process is killed meanwhile, the next goes on."""
    with suppress(OSError):
        for entry in folder.iterdir():
            if entry.is_dir():
                shutil.rmtree(entry, ignore_errors=True)
            elif entry.name != _LOCK:
                entry.unlink(missing_ok=True)
    shutil.rmtree(folder, ignore_errors=True)


def reserve(aside: Path, size: int) -> None:
    """Find out whether there is room for a file of `size` bytes, where a writer would not notice that there is none.

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


def sync(written: Path) -> None:
    """Bring a file to the disk: some disks and quotas say only now that they are full, by an ``OSError``."""
    with written.open("rb+") as file:
        os.fsync(file.fileno())


def write_json(document: Any, path: str | os.PathLike[str]) -> None:
    """Write plain values to a JSON file; ``ValueError`` if it cannot be written."""
    with written_aside(path) as aside:
        aside.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")


@contextmanager
def locked(path: Path, *, makes: bool = True) -> Iterator[bool]:
    """Whether no other process is within such a block for the same path; none gets into one until the end of this.

    The system takes the lock away when the process that holds it ends. The file is made unless `makes` is false, and
    stays. Where it is missing, cannot be made or locked, or is removed meanwhile, the result is False.
    """
    try:
        file = path.open("ab" if makes else "r+b")
    except OSError:
        yield False
        return
    with file:
        try:
            _take(file.fileno())
            # whoever had it before may have removed the file, and others may have made another one
            is_taken = os.path.samestat(os.fstat(file.fileno()), path.stat())
        except OSError:
            is_taken = False
        if is_taken:
            yield True
            return
    yield False
