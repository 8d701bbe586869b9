"""The command line's light parent: the work is done in a child, of which even a crash comes to one line.

The child is forked before anything heavy is loaded; where forking is not safe, another Python is started. What C
libraries print on the error output is not shown, unless --verbose is given.
"""

import contextlib
import os
import signal
import sys
import warnings

from pvphong.base.processes import Watch, begin_work

TYPE_CHECKING = False  # as in pvphong
if TYPE_CHECKING:
    from collections.abc import Sequence

FORKS = sys.platform not in ("darwin", "win32")
"""Whether a process that has been forked may open windows."""

_CHANNEL = "PVPHONG_CHANNEL"
_VERBOSE = "--verbose"
_ADVICE = f"{_VERBOSE} shows what it says."
_QUIET = ("SIGINT", "SIGTERM", "SIGHUP", "SIGPIPE")
"""What ends the work without a word, with the status that shells give: 128 and the signal's number."""


def main(tokens: "Sequence[str] | None" = None) -> int:
    """Run the command line and give the exit status; 2 if the work crashes.

    Words that are given in place of the command line's own are run in this process, unsupervised.
    """
    if tokens is not None:
        from pvphong.cli.app import main as run

        return run(tokens)
    end = os.environ.pop(_CHANNEL, None)
    if end is not None:
        return _work(int(end))
    if sys.platform == "win32":
        return _work(None)
    return _supervise()


def _supervise() -> int:
    listening, speaking = os.pipe()
    process = _forked(listening) if FORKS else _spawned(speaking)
    if process == 0:
        return _work(speaking)
    os.close(speaking)
    for name in _QUIET[:3]:  # a terminal's come to both
        signal.signal(getattr(signal, name), lambda number, _frame: _pass_on(process, number))
    watch = Watch(listening, process)
    watch.until_it_ends()
    code = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
    if watch.status is not None:
        return watch.status
    return code if code >= 0 else _after_crash(watch, code)


def _forked(listening: int) -> int:
    process = os.fork()
    if process == 0:
        os.close(listening)
    return process


def _spawned(speaking: int) -> int:
    os.set_inheritable(speaking, True)
    return os.posix_spawn(sys.executable, sys.orig_argv, os.environ | {_CHANNEL: str(speaking)})


def _pass_on(process: int, number: int) -> None:
    with contextlib.suppress(ProcessLookupError):  # it has just ended
        os.kill(process, number)


def _after_crash(watch: Watch, code: int) -> int:
    watch.clear_folders()
    if sys.stderr is not None and sys.stderr.isatty():
        sys.stderr.write("\r\x1b[K\x1b[?25h")  # a spinner's line, and the cursor that it hides
    if signal.Signals(-code).name in _QUIET:
        return 128 - code
    line = watch.failure(code, "" if watch.overdue or code == -signal.SIGKILL else _ADVICE)
    _print_error(line)
    return 2


def _print_error(line: str) -> None:
    if sys.stderr is not None:
        os.write(2, f"error: {' '.join(line.split())}\n".encode(errors="backslashreplace"))


def _work(end: int | None) -> int:
    """What the child does."""
    _set_outputs(_VERBOSE in sys.argv)
    if end is None:
        from pvphong.cli.app import main as run

        return run()
    for name in _QUIET:
        signal.signal(getattr(signal, name), signal.SIG_DFL)
    worker = begin_work(end)
    from pvphong.base.files import announce
    from pvphong.cli.app import main as run

    announce.append(worker.folder)
    status = run()
    worker.status(status)
    return status


def _set_outputs(verbose: bool) -> None:
    """Leave the error output to Python alone, without its warnings, and let both take any name of a file."""
    if not verbose and not sys.warnoptions:
        import logging

        warnings.simplefilter("ignore")
        logging.disable()  # PyVista logs what VTK complains of
    if not verbose and sys.stderr is not None:
        sys.stderr = os.fdopen(os.dup(2), "w", 1, errors="backslashreplace")
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 2)
        os.close(nowhere)
    for output in (sys.stdout, sys.stderr):
        if output is not None:
            output.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
