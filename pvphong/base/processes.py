"""A process that watches another, which may crash, hang or run out of memory.

The worker says over a pipe what it is about to do: messages end with a zero byte. The watcher needs little of Python,
for it is to start fast: this module imports nothing that takes time.
"""

import os
import select
import signal
import sys
import time

SECONDS, BYTES_PER_SECOND = 60.0, 1e6
"""What reading a file may take, and a second more for each megabyte; from when it last got anything from a disk."""

_FOLDER, _READING, _DONE, _STATUS = "folder", "reading", "done", "status"

worker: "Worker | None" = None
"""This process's side of the pipe, if another watches it."""


class Worker:
    """The side of the process that is watched.

    Parameters
    ----------
    end : int
        The pipe's descriptor.
    """

    def __init__(self, end: int) -> None:
        self._end = end

    def folder(self, path: object) -> None:
        """A folder is written in, which is to be removed should this process be killed."""
        self._say(_FOLDER, str(path))

    def reading(self, path: str, seconds: float) -> None:
        """A file is read from now on, until `done`."""
        self._say(_READING, f"{seconds} {path}")

    def done(self) -> None:
        """The file has been read."""
        self._say(_DONE)

    def status(self, code: int) -> None:
        """The work is over with an exit status, whatever libraries do when they are unloaded."""
        self._say(_STATUS, str(code))

    def _say(self, what: str, more: str = "") -> None:
        os.write(self._end, os.fsencode(f"{what} {more}") + b"\0")


class Watch:
    """What a worker has said; and it is killed when reading takes too long.

    Parameters
    ----------
    end : int
        The other end of the worker's pipe.
    process : int
        Its number.
    """

    def __init__(self, end: int, process: int) -> None:
        self._end, self._process = end, process
        self.folders: list[str] = []
        self.status: int | None = None
        self.file = ""
        self.limit = 0.0
        self.overdue = False
        self._deadline = 0.0
        self._got = 0

    def until_it_ends(self) -> None:
        """Listen until the worker has closed its end, which it does when it ends."""
        rest = b""
        while True:
            wait = max(self._deadline - time.monotonic(), 0.0) if self._deadline else None
            if not select.select([self._end], [], [], wait)[0]:
                self._late()
                continue
            said = os.read(self._end, 2**16)
            if not said:
                return
            *messages, rest = (rest + said).split(b"\0")
            for message in messages:
                self._hear(*os.fsdecode(message).split(" ", 1))

    def _hear(self, what: str, more: str) -> None:
        if what == _FOLDER:
            self.folders.append(more)
        elif what == _STATUS:
            self.status = int(more)
        elif what == _DONE:
            self.file, self._deadline = "", 0.0
        elif what == _READING:
            seconds, self.file = more.split(" ", 1)
            self.limit = float(seconds)
            self._wait_on()

    def _wait_on(self) -> None:
        self._deadline, self._got = time.monotonic() + self.limit, self._got_from_files()

    def _late(self) -> None:
        if self._got_from_files() > self._got:
            self._wait_on()
        else:
            self.overdue, self._deadline = True, 0.0
            os.kill(self._process, signal.SIGKILL)

    def _got_from_files(self) -> int:
        """Bytes that the worker has read so far; 0 where the system does not tell."""
        try:
            with open(f"/proc/{self._process}/io") as counts:
                return int(counts.readline().split()[1])
        except OSError:
            return 0

    def clear_folders(self) -> None:
        """Remove what the worker has left, after it was killed."""
        for folder in self.folders:
            from shutil import rmtree

            rmtree(folder, ignore_errors=True)

    def failure(self, code: int, advice: str = "") -> str:
        """One line about the violent end of the worker, by the negative number of the signal."""
        if self.overdue:
            what = f"Reading it has come to no end, {self.limit:.0f} s after it last got anything from the disk."
        elif code == -9:
            what = "The process was killed, as the system does where memory runs out."
        else:
            what = f"A library has ended the process ({_name(-code)}), as damaged files make them."
        told = f"mesh must be a mesh file that PyVista can read; got {self.file}. {what}" if self.file else what
        return f"{told} {advice}".rstrip()


def _name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}" if number > 0 else f"status {-number}"


def begin_work(end: int) -> Worker:
    """Make this process a worker, which ends with the one that watches it."""
    global worker
    os.set_inheritable(end, False)
    worker = Worker(end)
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG
    return worker
