"""Run scripts in processes forked from one that has imported everything, so that they start at once."""

import multiprocessing
import os
import runpy
import sys
import tempfile
import warnings
from pathlib import Path

_LOADED = [
    *("pyvista", "matplotlib.pyplot", "embreex.rtcore_scene", "pvphong.shading.kernel", "pvphong.accessor"),
    *("pvphong.plotter", "pvphong.meshes.blocks", "pvphong.meshes.daylight", "pvphong.studies.fitting.fitting"),
]
"""Modules that most scripts import, and that take half a second of theirs."""


def run_script(path, *arguments, folder, off_screen=False, seconds=300):
    """Run a script and return its output; assert that it succeeds. Warnings are errors."""
    has_forks = "forkserver" in multiprocessing.get_all_start_methods()
    context = multiprocessing.get_context("forkserver" if has_forks else "spawn")
    if has_forks:
        context.set_forkserver_preload(_LOADED)
    with tempfile.TemporaryDirectory() as place:
        out, errors = Path(place, "out"), Path(place, "errors")
        given = str(path), list(map(str, arguments)), str(folder), off_screen, sys.path, out, errors
        process = context.Process(target=_script, args=given)
        process.start()
        process.join(seconds)
        if process.exitcode is None:
            process.kill()
            process.join()
        assert process.exitcode == 0, errors.read_text(encoding="utf-8")
        return out.read_text(encoding="utf-8")


def run_code(code, folder):
    """Run lines of code off screen, and return the output."""
    with tempfile.TemporaryDirectory() as place:
        path = Path(place, "lines.py")
        path.write_text(code, encoding="utf-8")
        return run_script(path, folder=folder, off_screen=True)


def _script(path, arguments, folder, off_screen, search, out, errors):
    for number, file in ((1, out), (2, errors)):  # includes VTK's output
        os.dup2(os.open(file, os.O_WRONLY | os.O_CREAT), number)
    import pyvista as pv

    os.chdir(folder)
    pv.OFF_SCREEN = pv.OFF_SCREEN or off_screen
    pv.global_theme.multi_samples = 1  # more take a processor twice as long
    sys.argv, sys.path = [path, *arguments], [str(Path(path).parent), *search]
    warnings.simplefilter("error")
    runpy.run_path(path, run_name="__main__")
    sys.stdout.flush()
