"""The commands put together, the exit status and the line for each of their errors; and `pvphong compile`."""

from __future__ import annotations

import itertools
import os
import re
import sys
import time
import traceback
from collections.abc import Sequence
from importlib.metadata import version
from inspect import signature

from cyclopts import App, CycloptsError
from rich.console import Console
from rich.progress import Progress

from pvphong.base.processes import VERBOSE
from pvphong.cli.demo import demo
from pvphong.cli.reports import diagnose, plan, tradeoff, validate
from pvphong.cli.shade import shade
from pvphong.cli.studio import studio
from pvphong.cli.view import view
from pvphong.rays.casting import ray_backend
from pvphong.shading import kernel


def compile_code() -> int:
    """Compile the fast evaluator in advance, once per installation; it says what is in the way if that cannot be done.

    Without this, the first large mesh is lit by NumPy, while another process compiles. It also says what casts rays
    here, and why nothing faster does.
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
        finally:
            progress.stop()
            backend, why_no_faster = ray_backend()
            print(f"rays are cast by {backend.title}" + (f": {why_no_faster}" if why_no_faster else ""))
    print(f"compiled in {time.perf_counter() - began:.0f} s, kept in {folder}")
    return 0


_COMMANDS = {
    **{command.__name__: command for command in (demo, shade, view, studio, plan, validate, tradeoff, diagnose)},
    "compile": compile_code,
}
app = App(
    name="pvphong",
    help="Phong lighting of meshes as data: lit colours as arrays, in files and in pictures.",
    help_epilogue="With --verbose any command shows what libraries print on the error output.",
    version=version("pvphong"),
    suppress_keyboard_interrupt=False,
)
for name, command in _COMMANDS.items():
    app.command(command, name=name)


_SHORT = {"-o": "--output"}


def _in_its_words(reason: str, words: Sequence[str]) -> str:
    """An error in the words of the command line: of a path by its option, and of a colour where PyVista has one."""
    if re.search(r"^Unknown option: .?--colou?r\b", reason):
        return f"{reason.split('. Did')[0].removesuffix('.')}. --diffuse is the colour of what light scatters."
    argument, must, rest = reason.partition(" must be ")
    if argument in ("path", "output"):
        split = [part for word in words for part in (word.split("=", 1) if word.startswith("-") else [word])]
        for option, value in itertools.pairwise(split):
            paths = {value, os.path.abspath(value), os.path.realpath(value)}
            if option.startswith("-") and any(
                f"; got {path}{end}" in f"{reason} " for path in paths for end in (". ", " (")
            ):
                return f"{_SHORT.get(option, option)}{must}{rest}"
    return reason


def main(tokens: Sequence[str] | None = None) -> int:
    """Run the command line in this process and give the exit status."""
    words = list(sys.argv[1:] if tokens is None else tokens)
    is_verbose = VERBOSE in words
    command = next((_COMMANDS.get(word) for word in words if not word.startswith("-")), None)
    if command is None or "verbose" not in signature(command).parameters:
        words = [word for word in words if word != VERBOSE]  # the supervisor has seen it
    try:
        status = app(words, exit_on_error=False, print_error=False, result_action="return_value") or 0
        if sys.stdout is not None:
            sys.stdout.flush()
    except KeyboardInterrupt:
        return 130
    except (CycloptsError, ValueError, OSError) as error:
        reason = _in_its_words(str(error), words)
    except MemoryError:
        reason = "there is not enough memory for this."
    except Exception as error:
        if is_verbose:
            traceback.print_exc()
        reason = f"{type(error).__name__}: {error} (this should not happen; --verbose shows where)"
    else:
        return status
    print("error:", " ".join(reason.split()), file=sys.stderr)
    return 2
