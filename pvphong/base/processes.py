"""A process that watches another, which may crash, hang or run out of memory while it reads a stranger's file.

The worker says over a pipe what it is about to do; messages end with a zero byte. The watcher has to start fast, so
this module imports nothing that takes time.
"""

import math
import os
import select
import signal
import sys
import time
from contextlib import contextmanager

TYPE_CHECKING = False  # as in `pvphong/__init__.py`
if TYPE_CHECKING:
    from collections.abc import Iterator

SECONDS, BYTES_PER_SECOND = 60.0, 1e6
"""Seconds that reading a file may take, and a second more for each megabyte; counted from when it last got anything
from a disk."""

VERBOSE = "--verbose"
"""The word with which the worker shows what libraries print, and where an error that should not happen comes from."""

watcher: int | None = None
"""Descriptor of the pipe to the process that watches this one, if one does."""

_is_reading = False


def say(what: str, more: object = "") -> None:
    """Tell the process that watches this one, if one does, what this one is about to do.

    That is a "folder" that is written in, to be removed should this process be killed; that "reading" begins, with its
    seconds and the file, and is "done", or has failed; or the exit "status": the work is over, whatever libraries do
    when they are unloaded.
    """
    if watcher is not None:
        os.write(watcher, os.fsencode(f"{what} {more}") + b"\0")


def environment() -> "dict[str, str]":
    """This process's environment for another Python that is to find the same modules."""
    return os.environ | {"PYTHONPATH": os.pathsep.join(entry or os.getcwd() for entry in sys.path)}


class Watch:
    """The process that watches: it takes a worker's messages, and kills it when reading takes too long.

    Parameters
    ----------
    end : int
        The other end of the worker's pipe.
    process : int
        The worker's process number.
    """

    def __init__(self, end: int, process: int) -> None:
        self._end, self._process = end, process
        self.folders: list[str] = []
        self.status: int | None = None
        self.file = ""
        self.limit = 0.0
        self.overdue = False

    def until_it_ends(self) -> None:
        """Listen until the worker has closed its end of the pipe, which it does when it ends."""
        rest, deadline, bytes_read = b"", math.inf, 0
        while True:
            wait = None if deadline == math.inf else max(deadline - time.monotonic(), 0.0)
            if not select.select([self._end], [], [], wait)[0]:
                before, bytes_read = bytes_read, self._count_bytes_read()
                deadline = time.monotonic() + self.limit
                if bytes_read <= before:
                    self.overdue, deadline = True, math.inf
                    os.kill(self._process, signal.SIGKILL)
                continue
            received = os.read(self._end, 2**16)
            if not received:
                return
            *messages, rest = (rest + received).split(b"\0")
            for message in messages:
                what, more = os.fsdecode(message).split(" ", 1)
                if what == "folder":
                    self.folders.append(more)
                elif what == "status":
                    self.status = int(more)
                elif what == "done":
                    self.file, deadline = "", math.inf
                elif what == "reading":
                    seconds, self.file = more.split(" ", 1)
                    self.limit, bytes_read = float(seconds), self._count_bytes_read()
                    deadline = time.monotonic() + self.limit

    def _count_bytes_read(self) -> int:
        """Bytes that the worker has read so far; 0 where the system does not report it."""
        try:
            with open(f"/proc/{self._process}/io") as counts:
                return int(counts.readline().split()[1])
        except OSError:
            return 0

    def failure(self, code: int, advice: str = "") -> str:
        """One line about the violent end of the worker, by the negative number of the signal."""
        if self.overdue:
            what = f"Reading it has come to no end, {self.limit:.0f} s after it last got anything from the disk."
        elif code == -signal.SIGKILL:
            what = "The process was killed, as the system does where memory runs out."
        else:
            try:
                name = signal.Signals(-code).name
            except ValueError:
                name = f"signal {-code}" if code < 0 else f"status {code}"
            what = f"A library has ended the process ({name}), as damaged files make them."
        line = f"mesh must be a mesh file that PyVista can read; got {self.file}. {what}" if self.file else what
        return f"{line} {advice}".rstrip()


def begin_work(end: int) -> None:
    """Make this process a worker, which ends with the one that watches it; `end` is its end of the pipe."""
    global watcher
    os.set_inheritable(end, False)
    watcher = end
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


@contextmanager
def reading(path: "str | os.PathLike[str]") -> "Iterator[None]":
    """While a file is read: the watching process knows which one, and no more memory can be had than is free.

    So what a damaged file makes this process allocate is refused before the system stalls. Within another such block,
    and in a process that nobody watches, nothing changes.
    """
    global _is_reading
    if watcher is None or _is_reading:
        yield
        return
    try:
        size = os.stat(path).st_size
    except (OSError, ValueError):
        size = 0
    if sys.platform == "linux":
        import resource

        free = _bytes_in("/proc/self/status", "VmData:") + _bytes_in("/proc/meminfo", "MemAvailable:")
        old, hard = resource.getrlimit(resource.RLIMIT_DATA)
        bounds = [limit for limit in (free, old, hard) if limit != resource.RLIM_INFINITY]
        resource.setrlimit(resource.RLIMIT_DATA, (min(bounds), hard))
    _is_reading = True
    say("reading", f"{SECONDS + size / BYTES_PER_SECOND} {os.fspath(path)}")
    try:
        yield
    finally:
        if sys.platform == "linux":
            resource.setrlimit(resource.RLIMIT_DATA, (old, hard))
        _is_reading = False
        say("done")


def available_memory() -> int | None:
    """Bytes that can be had without swapping; None where the system does not say."""
    return _bytes_in("/proc/meminfo", "MemAvailable:") if sys.platform == "linux" else None


def _bytes_in(file: str, name: str) -> int:
    with open(file) as lines:
        return next(1024 * int(line.split()[1]) for line in lines if line.startswith(name))
