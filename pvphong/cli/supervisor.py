"""Parent process of the command line. It runs the command in a child process and reports a crash in one line.

The child is forked before anything heavy is loaded; where forking is not safe, a new Python is started. On Windows
there is no child: the command runs in this process. What C libraries print on standard error is hidden, unless
--verbose is given.

The child runs the whole command, not only the reader of the file. A child that only reads would have to send the mesh
to its parent, which takes 1.2 s for a million points, four times as long as reading. Also, Ctrl-C ends C code at once.
"""

import contextlib
import functools
import os
import signal
import sys
import warnings

from pvphong.base.processes import VERBOSE, Watch, begin_work, say

TYPE_CHECKING = False  # as in pvphong
if TYPE_CHECKING:
    from collections.abc import Sequence

FORKS = sys.platform not in ("darwin", "win32")
"""True if a forked process may open windows on this platform."""

_CHANNEL = "PVPHONG_CHANNEL"
_QUIET = ("SIGINT", "SIGTERM", "SIGHUP", "SIGPIPE")
"""Signals that end the command without a message. The exit status is 128 plus the signal's number, as in shells."""


def _quiet() -> "list[signal.Signals]":
    return [signal.Signals[name] for name in _QUIET]


def main(tokens: "Sequence[str] | None" = None) -> int:
    """Run the command line and return the exit status; 2 after a crash.

    By default, the command runs in a child process with the words of `sys.argv`. If `tokens` has the words of a command
    line, the command runs in this process.
    """
    if tokens is not None:
        from pvphong.cli.app import main as run

        return run(tokens)
    end = os.environ.pop(_CHANNEL, None)
    if end is None and sys.platform != "win32":
        return _supervise()
    return _work(None if end is None else int(end))


def _supervise() -> int:
    """Run the command in a child process, wait for it, report a crash, and return the exit status."""
    # block signals until both processes have set handlers, because a signal could end the parent but not the child
    signal.pthread_sigmask(signal.SIG_BLOCK, _quiet())
    listening, speaking = os.pipe()
    if FORKS:
        process = os.fork()
        if process == 0:
            os.close(listening)
            return _work(speaking)
    else:
        os.set_inheritable(speaking, True)
        process = os.posix_spawn(sys.executable, sys.orig_argv, os.environ | {_CHANNEL: str(speaking)})
    os.close(speaking)

    def pass_on(number: int, _frame: object) -> None:
        with contextlib.suppress(ProcessLookupError):  # the child has just ended
            os.kill(process, number)

    for number in _quiet()[:3]:  # a terminal sends signals to both processes, but `kill` only to this one
        signal.signal(number, pass_on)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _quiet())
    watch = Watch(listening, process)
    watch.until_it_ends()
    code = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
    if watch.status is not None or code >= 0:
        return code if watch.status is None else watch.status
    for folder in watch.folders:  # temporary folders of unfinished files
        from shutil import rmtree

        rmtree(folder, ignore_errors=True)
    if sys.stderr is not None and sys.stderr.isatty():
        sys.stderr.write("\r\x1b[K\x1b[?25h")  # clear the spinner's line and show the cursor again
    if signal.Signals(-code).name in _QUIET:
        return 128 - code
    line = watch.failure(code, "" if watch.overdue or code == -signal.SIGKILL else f"{VERBOSE} shows its output.")
    if sys.stderr is not None:
        os.write(2, f"error: {' '.join(line.split())}\n".encode(errors="backslashreplace"))
    return 2


def _work(end: int | None) -> int:
    """Run the command in this process, and return the exit status.

    If this is a child process, `end` is the file descriptor of its end of the pipe to the parent, else None.
    """
    _set_outputs(VERBOSE in sys.argv)
    if end is not None:
        for number in _quiet():
            signal.signal(number, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _quiet())
        begin_work(end)
        from pvphong.base.files import announce

        announce.append(functools.partial(say, "folder"))
    from pvphong.cli.app import main as run

    status = run()
    say("status", status)
    return status


def _set_outputs(verbose: bool) -> None:
    """Make both standard outputs escape characters that their encoding does not have.

    If not `verbose`, also hide the output of C libraries on standard error. Python's warnings are then hidden too,
    unless the option `-W` of Python was given.
    """
    if not verbose and not sys.warnoptions:
        import logging

        warnings.simplefilter("ignore")
        logging.disable()  # PyVista logs VTK's warnings
    if not verbose and sys.stderr is not None:
        sys.stderr = os.fdopen(os.dup(2), "w", 1, errors="backslashreplace")
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 2)
        os.close(nowhere)
    for output in (sys.stdout, sys.stderr):
        if output is not None:
            output.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
