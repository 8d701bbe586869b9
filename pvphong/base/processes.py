"""A watcher for a worker process that may crash, hang or run out of memory while it reads an untrusted file.

The worker announces its next action over a pipe; messages end with a zero byte. The watcher must start fast, so this
module imports nothing slow.
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
"""Time limit for reading a file: `SECONDS`, and one second for every `BYTES_PER_SECOND` bytes.

When the limit expires, it starts again if the worker has read data since the last start.
"""

VERBOSE = "--verbose"
"""Option with which the worker shows the output of libraries, and the traceback of an unexpected error."""

watcher: int | None = None
"""Descriptor of the pipe to the watcher of this process, if it has one."""

_is_reading = False


def say(what: str, more: object = "") -> None:
    """Send a message about the next action to the watcher of this process, if it has one.

    Parameters
    ----------
    what : {"folder", "reading", "done", "status"}
        Kind of message. "folder": remove a temporary folder if this process is killed. "reading": reading of a file
        begins. "done": reading has ended or failed. "status": the work is complete, even if libraries crash when they
        are unloaded.
    more : object
        Content of the message; it is converted to text. "folder": the path. "reading": the allowed seconds, a space and
        the path. "done": nothing. "status": the exit status.
    """
    if watcher is not None:
        os.write(watcher, os.fsencode(f"{what} {more}") + b"\0")


def environment() -> "dict[str, str]":
    """Return the environment variables for a child process, with a PYTHONPATH by which it finds the same modules."""
    return os.environ | {"PYTHONPATH": os.pathsep.join(entry or os.getcwd() for entry in sys.path)}


class Watch:
    """The watcher: receives a worker's messages, and kills the worker when reading takes too long.

    Parameters
    ----------
    end : int
        Descriptor of the watcher's end of the pipe.
    process : int
        ID of the worker's process.
    """

    def __init__(self, end: int, process: int) -> None:
        self._end, self._process = end, process
        self.folders: list[str] = []
        self.status: int | None = None
        self.file = ""
        self.limit = 0.0
        self.overdue = False

    def until_it_ends(self) -> None:
        """Receive the worker's messages until the worker exits. If reading takes too long, kill the worker."""
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
        """Return the number of bytes that the worker process has read so far; 0 if the system does not report it."""
        try:
            with open(f"/proc/{self._process}/io") as counts:
                return int(counts.readline().split()[1])
        except OSError:
            return 0

    def failure(self, code: int, advice: str = "") -> str:
        """Describe the worker's crash in one line.

        Parameters
        ----------
        code : int
            The worker's exit status, or minus the number of the signal that ended it.
        advice : str
            Sentence that is appended.
        """
        if self.overdue:
            what = f"Reading timed out: no data from the disk for {self.limit:.0f} s."
        elif code == -signal.SIGKILL:
            what = "The process was killed, probably because memory ran out."
        else:
            try:
                name = signal.Signals(-code).name
            except ValueError:
                name = f"signal {-code}" if code < 0 else f"status {code}"
            what = f"A library crashed ({name}); an input file may be corrupt."
        line = f"mesh must be a mesh file that PyVista can read; got {self.file}. {what}" if self.file else what
        return f"{line} {advice}".rstrip()


def begin_work(end: int) -> None:
    """Make this process a worker: `say` will send its messages to the pipe with the file descriptor `end`.

    On Linux, the system kills the worker when its watcher ends.
    """
    global watcher
    os.set_inheritable(end, False)
    watcher = end
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


@contextmanager
def reading(path: "str | os.PathLike[str]") -> "Iterator[None]":
    """Announce to the watcher that the block reads the file `path`. The watcher then limits the time.

    On Linux, memory is limited to what is free: a corrupt file may request huge allocations, which then fail before the
    system stalls. In a nested block, or in a process without a watcher, the function has no effect.
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
    """Return the number of bytes that can be allocated without swapping; None if the system does not report it."""
    return _bytes_in("/proc/meminfo", "MemAvailable:") if sys.platform == "linux" else None


def _bytes_in(file: str, name: str) -> int:
    with open(file) as lines:
        return next(1024 * int(line.split()[1]) for line in lines if line.startswith(name))
