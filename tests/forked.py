"""Runs scripts in processes that are forked from one that has loaded everything and run nothing: they begin at once."""

import multiprocessing
import os
import runpy
import sys
import tempfile
import warnings
from pathlib import Path

HAS_FORKS = "forkserver" in multiprocessing.get_all_start_methods()
_CONTEXT = multiprocessing.get_context("forkserver" if HAS_FORKS else "spawn")
if HAS_FORKS:
    _CONTEXT.set_forkserver_preload(["pyvista", "matplotlib.pyplot", "embreex.rtcore_scene", "pvphong.shading.kernel"])


def run_script(path, *arguments, folder, off_screen=False, seconds=300):
    """What it prints, where it ends well; warnings are errors."""
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        given = str(path), list(map(str, arguments)), str(folder), off_screen, sys.path
        process = _CONTEXT.Process(target=_script, args=(*given, _handed(out), _handed(err)))
        process.start()
        process.join(seconds)
        if process.exitcode is None:
            process.kill()
            process.join()
        out.seek(0)
        err.seek(0)
        assert process.exitcode == 0, err.read()
        return out.read()


def run_code(code, folder):
    """The same of lines."""
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "lines.py"
        path.write_text(code, encoding="utf-8")
        return run_script(path, folder=folder, off_screen=True)


def _handed(file):
    from multiprocessing.reduction import DupFd

    return DupFd(file.fileno())


def _script(path, arguments, folder, off_screen, search, out, err):
    import pyvista as pv

    os.dup2(out.detach(), 1)
    os.dup2(err.detach(), 2)
    os.chdir(folder)
    pv.OFF_SCREEN = pv.OFF_SCREEN or off_screen
    sys.argv, sys.path = [path, *arguments], [str(Path(path).parent), *search]
    warnings.simplefilter("error")
    runpy.run_path(path, run_name="__main__")
    sys.stdout.flush()
