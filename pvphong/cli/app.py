"""The commands put together, the exit status and the line for each of their errors; and `pvphong compile`."""

from __future__ import annotations

import sys
import time
import traceback
from collections.abc import Sequence
from importlib.metadata import version
from inspect import signature

from cyclopts import App, CycloptsError
from rich.console import Console
from rich.progress import Progress

from pvphong.cli.demo import demo
from pvphong.cli.reports import diagnose, plan, tradeoff, validate
from pvphong.cli.shade import shade
from pvphong.cli.view import view
from pvphong.shading import kernel

_VERBOSE = "--verbose"

app = App(
    name="pvphong",
    help="Phong lighting of meshes as data: lit colours as arrays, in files and in pictures.",
    help_epilogue="With --verbose any command shows what libraries print on the error output.",
    version=version("pvphong"),
    suppress_keyboard_interrupt=False,
)


def compile_code() -> int:
    """Compile the fast evaluator in advance, once per installation; it says what is in the way if that cannot be done.

    Without this, the first large mesh is lit by NumPy, while another process compiles.
    """
    began, console = time.perf_counter(), Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task("compiling", total=None)
        try:
            folder = kernel.compile_all(
                lambda name, done, total: progress.update(task, description=name, completed=done, total=total)
            )
        except kernel.CannotCompile as reason:
            print("error:", reason, file=sys.stderr)
            return 1
    print(f"compiled in {time.perf_counter() - began:.0f} s, kept in {folder}")
    return 0


_COMMANDS = {
    **{command.__name__: command for command in (demo, shade, view, plan, validate, tradeoff, diagnose)},
    "compile": compile_code,
}
for name, command in _COMMANDS.items():
    app.command(command, name=name)


def main(tokens: Sequence[str] | None = None) -> int:
    """Run the command line in this process and give the exit status."""
    words = list(sys.argv[1:] if tokens is None else tokens)
    verbose = _VERBOSE in words
    try:
        status = app(_for_command(words), exit_on_error=False, print_error=False, result_action="return_value") or 0
        if sys.stdout is not None:
            sys.stdout.flush()
    except (CycloptsError, ValueError, OSError) as error:
        return _refused(str(error))
    except KeyboardInterrupt:
        return 130
    except MemoryError:
        return _refused("there is not enough memory for this.")
    except Exception as error:
        if verbose:
            traceback.print_exc()
        return _refused(f"{type(error).__name__}: {error} (this should not happen; --verbose shows where)")
    return status


def _for_command(words: list[str]) -> list[str]:
    """The words without --verbose, if the command itself has no more to say; the supervisor has seen it."""
    command = next((_COMMANDS.get(word) for word in words if not word.startswith("-")), None)
    if command is not None and "verbose" in signature(command).parameters:
        return words
    return [word for word in words if word != _VERBOSE]


def _refused(why: str) -> int:
    print("error:", " ".join(why.split()), file=sys.stderr)
    return 2
