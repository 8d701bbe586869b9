"""Read damaged mesh files of every format that PyVista writes here, by the command line.

`python tests/fuzzing.py 10000` runs more cases than the tests do. `shade`, `diagnose` or `plan` reads each file, in a
process forked from this one, which has imported everything and run nothing. Failures are a signal, a traceback, a
second line of error, an output file or temporary file after an error, and a run that does not end.

An accepted file is read twice, in memory filled with different bytes beforehand: if the colours differ, uninitialised
memory was used. A truncated file of a format that stores its length must not be accepted with colours other than those
of the whole file.
"""

from __future__ import annotations

import ctypes
import functools
import json
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from interrupting import forked

COMMANDS = ("shade", "diagnose", "plan")
LIMIT = 5.0
"""Seconds that reading may take here, in place of a minute."""

_SLOWEST = 4 * LIMIT  # what a command may take altogether, on a machine that does other things
_MEMORY = 6 * 2**30
_PERTURB = -6  # of mallopt: malloc fills memory with a byte
_EXTREMES = [*b"-1 0 1 99999999 -2147483648 4294967295 1e999 nan inf x 1e-320".split(), b""]
_TELLS_ITS_LENGTH = {".vtp", ".vtu", ".vts", ".vtr", ".vti", ".vtm", ".vtmb", ".vtkhdf", ".ply", ".stl"}


# --- whole files ---


def write_formats(folder):
    """Write a file of every format, and variants of some formats; return their names."""
    import numpy as np
    import pyvista as pv

    ball = pv.Sphere(theta_resolution=8, phi_resolution=8)
    ball["tint"] = np.linspace(0, 1, 3 * ball.n_points).reshape(-1, 3)
    bare = ball.copy()
    bare.clear_data()
    grid = pv.ImageData(dimensions=(4, 3, 3))
    grid["v"] = np.arange(36.0)
    axes = [np.array([0.0, 1.0, 1.5, 4.0])[:n] for n in (4, 3, 3)]
    datasets = {
        "ball": (ball, ("vtp", "vtk", "vtkhdf", "ply", "stl", "obj")),  # .geo and .iv it writes, but does not read
        "bare": (bare, ("vtp", "vtk", "ply")),
        "cells": (grid.cast_to_unstructured_grid(), ("vtu", "vtk", "vtkhdf")),
        "curved": (grid.cast_to_structured_grid(), ("vts", "vtk")),
        "axes": (pv.RectilinearGrid(*axes), ("vtr", "vtk")),
        "image": (grid, ("vti", "vtk")),
        "blocks": (pv.MultiBlock({"one": ball, "two": grid, "none": None}), ("vtm", "vtmb")),
        "blocks-two": (pv.MultiBlock({"one": ball, "two": bare}), ("vtkhdf",)),
    }
    for name, (mesh, suffixes) in datasets.items():
        for suffix in suffixes:
            for form in (True, False) if suffix not in ("vtkhdf", "obj") else (True,):
                with suppress(ValueError, OSError):  # a format that this PyVista does not write
                    mesh.save(folder / f"{name}{'' if form else '-text'}.{suffix}", binary=form)
    with suppress(Exception):
        plotter = pv.Plotter(off_screen=True)
        plotter.add_mesh(ball)
        plotter.export_gltf(folder / "blocks.gltf")
        plotter.close()
    return sorted(path.name for path in folder.iterdir() if path.is_file())


# --- damage ---


def damaged(contents, dice):
    """The damage done to a file, and the damaged content."""
    a, b, c = sorted(dice.randrange(len(contents) + 1) for _ in range(3))
    at = dice.randrange(len(contents))
    kind, result = dice.choice(("cut", "bytes", "digits", "number", "repeat", "remove", "swap", "tag")), contents
    found = {"number": rb"-?\d+(\.\d+)?", "tag": rb"[A-Za-z_]{3,}", "digits": rb"\d"}.get(kind, b"")
    places = list(re.finditer(found, contents[:8192])) if found else []
    if kind == "cut" or (found and len(places) < 2):
        return "cut", contents[:at]
    if kind == "bytes":
        result, span = bytearray(contents), min(len(contents), dice.choice((64, 1024, len(contents))))
        for _ in range(dice.choice((1, 3, 20))):
            result[dice.randrange(span)] = dice.randrange(256)
    elif kind == "digits":
        result = bytearray(contents)
        for place in dice.sample(places, min(len(places), dice.choice((1, 3)))):
            result[place.start()] = 48 + dice.randrange(10)
    elif found:  # a number by an extreme one, a word by another of the same file
        one, other = dice.sample(places, 2)
        new = dice.choice(_EXTREMES) if kind == "number" else other[0]
        result = contents[: one.start()] + new + contents[one.end() :]
    elif kind == "repeat":
        result = contents[:b] + contents[a:]
    elif kind == "remove":
        result = contents[:at] + contents[at + dice.choice((1, 8, 100)) :]
    else:
        result = contents[:a] + contents[b:c] + contents[a:b] + contents[c:]
    return kind, bytes(result)


# --- runs ---


@dataclass
class Run:
    """Result of one command."""

    status: int
    out: str
    err: str
    seconds: float


def load_all():
    """Import the modules of the commands, without running VTK's code: a fork must not inherit its threads."""
    from pvphong.base import processes
    from pvphong.cli import app  # noqa: F401

    processes.SECONDS = LIMIT
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def command(words, folder, fill=0):
    """Run the command line, parent and child, in a folder; `fill` is the byte that fills new memory."""
    out, err = folder.parent / "out", folder.parent / "err"
    began = time.monotonic()
    process = os.fork()
    if process == 0:
        _become(words, folder, out, err, fill)
    status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
    said = (path.read_bytes().decode(errors="replace") for path in (out, err))
    return Run(status, *said, time.monotonic() - began)


def _become(words, folder, out, err, fill):
    from pvphong.cli import supervisor

    status = 99
    try:
        os.chdir(folder)
        for number, path in ((1, out), (2, err)):
            file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            os.dup2(file, number)
            os.close(file)
        sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w", 1)
        sys.argv = ["pvphong", *words]
        ctypes.CDLL(None).mallopt(_PERTURB, fill)
        status = supervisor.main()
    finally:
        sys.stdout.flush()
        os._exit(status)


@dataclass
class Report:
    """Results of all runs."""

    files: int = 0
    slowest: float = 0.0
    statuses: Counter = field(default_factory=Counter)
    faults: list = field(default_factory=list)
    cut_and_accepted: Counter = field(default_factory=Counter)

    def add(self, name, kind, verb, run, *, left):
        """Record a run and its faults."""
        self.slowest = max(self.slowest, run.seconds)
        self.statuses[f"{verb} {run.status}"] += 1
        said = re.sub(r"^note: [^\n]+\n", "", run.err)  # of normals that no longer fit
        is_quiet = not said if run.status != 2 else re.fullmatch(r"error: [^\n]+\n", said)
        wrong = {
            f"status {run.status}": run.status not in ((0, 1, 2) if verb == "diagnose" else (0, 2)),
            f"said {run.err[-300:]!r}": not is_quiet or "a bug in pvphong" in run.err,
            f"took {run.seconds:.0f} s": run.seconds > _SLOWEST,
            f"left {left}": left,
        }
        self.faults += [(name, kind, verb, fault) for fault, is_there in wrong.items() if is_there]


def hunt(count, seed=0):
    """Damage `count` files and run the commands on each."""
    report = Report()
    with tempfile.TemporaryDirectory(dir="/dev/shm" if os.access("/dev/shm", os.W_OK) else None) as place:
        whole, folder = Path(place, "whole"), Path(place, "work")
        whole.mkdir()
        names = json.loads(forked(lambda: json.dumps(write_formats(whole)).encode())[1])
        colors = functools.cache(lambda name: _colors(whole, name, 0))
        with suppress(KeyboardInterrupt):  # then what has been found so far is told
            for number in range(count):
                dice = random.Random(f"{seed} {number}")
                _hunt_one(report, dice, whole, folder, dice.choice(names), colors)
    return report


def _hunt_one(report, dice, whole, folder, name, colors):
    folder.mkdir()
    victim = folder / name
    shutil.copy(whole / name, victim)
    if victim.suffix in (".vtm", ".vtmb"):
        shutil.copytree(whole / victim.stem, folder / victim.stem)
    blocks = sorted(path for path in (folder / victim.stem).glob("*") if path.is_file())
    hurt = dice.choice([victim, *blocks])
    kind, contents = damaged(hurt.read_bytes(), dice)
    hurt.write_bytes(contents)
    before = sorted(os.listdir(folder))
    lit = folder / f"lit.{_output(name)}"
    verb = dice.choice(COMMANDS)
    run = command([verb, name, *(["-o", lit.name] if verb == "shade" else [])], folder, fill=0x55)
    expected = {path.name for path in (lit, lit.with_suffix("")) if not run.status}
    report.files += 1
    report.add(name, kind, verb, run, left=sorted({*os.listdir(folder)} - {*before} - expected))
    if verb == "shade" and run.status == 0:
        _judge(report, name, kind, folder, lit, colors)
    shutil.rmtree(folder)


def _judge(report, name, kind, folder, lit, colors):
    """Return True if an accepted damaged file has the colours of the whole file."""
    first = _contents(lit)
    again = _colors(folder, name, 0xAA)
    if again != first:
        report.faults.append((name, kind, "shade", "its colours are made of what was in memory"))
    elif kind == "cut" and again != colors(name) and Path(name).suffix in _TELLS_ITS_LENGTH:
        report.cut_and_accepted[name] += 1


def _output(name):
    return "vtm" if name.startswith("blocks") else "ply"


def _contents(lit):
    """Return a digest of a file's colours, independent of file and block names."""
    files = [lit] if lit.suffix == ".ply" else sorted(lit.with_suffix("").glob("*"), key=lambda path: path.name[13:])
    return [path.read_bytes() for path in files if path.exists()]


def _colors(folder, name, fill):
    lit = folder / f"again.{_output(name)}"
    command(["shade", name, "-o", lit.name], folder, fill)
    result = _contents(lit)
    lit.unlink(missing_ok=True)
    shutil.rmtree(lit.with_suffix(""), ignore_errors=True)
    return result


def main(count, seed=0):
    """Run the cases and print the results as JSON."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    load_all()
    print(json.dumps(vars(hunt(count, seed)), indent=1))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
