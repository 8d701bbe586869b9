"""The table of commands, and `main`: it runs a command, reports an error in one line and returns the exit status."""

from __future__ import annotations

import itertools
import os
import re
import sys
import traceback
from collections.abc import Sequence
from importlib.metadata import version
from inspect import signature
from typing import Any

from cyclopts import App, CycloptsError

from pvphong.base.processes import VERBOSE

_COMMANDS = {
    "demo": (
        "demo:demo",
        "Light PyVista's bundled airplane; write the mesh, a picture, the rig and a report into a folder.",
    ),
    "shade": (
        "shade:shade",
        "Light a mesh and write it with its colours, or write a picture of it; or light many meshes into a folder.",
    ),
    "irradiance": (
        "irradiance:irradiance",
        "Compute the light that arrives at a mesh, in the unit of the lights, whatever the mesh is made of.",
    ),
    "view": ("view:view", "Show a lit mesh in a window, with gizmos for its lights; press h for the list of keys."),
    "studio": (
        "studio:studio",
        "Light a mesh in the browser: panels for lights, material and scene, gizmos in the view; Ctrl-C stops it.",
    ),
    "fit": (
        "fit:fit",
        "Find the lights with which a mesh gets the colours that it should have, and write them to a rig file.",
    ),
    "plan": (
        "reports:plan",
        "Print the effects that are computed for a scene on a mesh, and those skipped; with --verbose, the reasons.",
    ),
    "validate": (
        "reports:validate",
        "Compare the lit colours with VTK's shader; the exit status is 1 if they differ too much.",
    ),
    "tradeoff": (
        "reports:tradeoff",
        "Measure accuracy against time on a mesh: evaluators, simpler light models, refined meshes, VTK.",
    ),
    "diagnose": (
        "reports:diagnose",
        "Find faults of a mesh that spoil its lighting; the exit status is 1 if there are any.",
    ),
    "daylight": (
        "daylight:daylight",
        "Compute the light of sun and sky on a mesh over a year or a day: hours with sun, and Wh/m².",
    ),
    "compile": (
        "compile:compile_code",
        "Compile the fast evaluator in advance, once per installation.",
    ),
}
"""Command → its function and summary. --help needs only this table; importing all commands takes a second."""

app = App(
    name="pvphong",
    help="Phong lighting of meshes as data: lit colours as arrays, in files and in pictures.",
    help_epilogue="With --verbose, a command also shows what libraries print on standard error.",
    version=version("pvphong"),
    suppress_keyboard_interrupt=False,
)
for name, (place, does) in _COMMANDS.items():
    app.command(f"{__package__}.{place}", name=name, help=does)


_SHORT = {"-o": "--output"}

_OPTIONS = {
    "client": ("--scheduler",),
    "weather": ("--epw",),
    "latitude": ("--place",),
    "longitude": ("--place",),
    "name": ("--array",),
    "tolerance": ("--tolerance", "--refine"),
}
"""Argument of a Python function → its options on the command line, if their names differ."""

_PHRASES = {
    "must be a distributed.Client, or the address": "must be the address",
    "light_model must be without bounces": "the light model must be without bounces",
    "Use LightModel(bounces=0), or join the pieces: pyvista.read(path).": "Pass --bounces 0.",
}
"""Words for calls in Python → words for the command line."""


def _in_its_words(reason: str, words: Sequence[str]) -> str:
    """Reword a message of a Python function for the command line: replace the argument's name by the option's.

    `reason` is the message, and `words` are the words of the command line.
    """
    if re.search(r"^Unknown option: .?--colou?r\b", reason):
        return f"{reason.split('. Did')[0].removesuffix('.')}. --diffuse sets the surface's colour."
    argument, must, rest = reason.partition(" must be ")
    if argument in ("path", "output"):
        split = [part for word in words for part in (word.split("=", 1) if word.startswith("-") else [word])]
        for option, value in itertools.pairwise(split):
            paths = {value, os.path.abspath(value), os.path.realpath(value)}
            if option.startswith("-") and any(
                f"; got {path}{end}" in f"{reason} " for path in paths for end in (". ", " (")
            ):
                return f"{_SHORT.get(option, option)}{must}{rest}"
    given = {word.partition("=")[0] for word in words}
    for option in _OPTIONS.get(argument, (f"--{argument.replace('_', '-')}",)):
        if must and option in given:
            reason = f"{option}{must}{rest}"
            break
    for phrase, ours in _PHRASES.items():
        reason = reason.replace(phrase, ours)
    return reason


def _function(command: str) -> Any:
    """Import and return the function of a command. Its docstring becomes the command's help."""
    found = app[command]
    found.help = None
    return found.default_command


def main(tokens: Sequence[str] | None = None) -> int:
    """Run the command line in this process, and return the exit status.

    `tokens` are the words of the command line; by default, those of `sys.argv`.
    """
    words = list(sys.argv[1:] if tokens is None else tokens)
    is_verbose = VERBOSE in words
    command = next((word for word in words if not word.startswith("-")), "")
    if command not in _COMMANDS or "verbose" not in signature(_function(command)).parameters:
        words = [word for word in words if word != VERBOSE]  # only the supervisor uses it
    try:
        status = app(words, exit_on_error=False, print_error=False, result_action="return_value") or 0
        if sys.stdout is not None:
            sys.stdout.flush()
    except KeyboardInterrupt:
        return 130
    except (CycloptsError, ValueError, OSError) as error:
        reason = _in_its_words(str(error), words)
    except MemoryError:
        reason = "Not enough memory."
    except Exception as error:
        if is_verbose:
            traceback.print_exc()
        reason = f"{type(error).__name__}: {error} (a bug in pvphong; --verbose prints the traceback)"
    else:
        return status
    print("error:", " ".join(reason.split()), file=sys.stderr)
    return 2
