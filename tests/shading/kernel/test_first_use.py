"""Calls wait for the compiler only if they request compiled code."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from itertools import count

import numpy as np
import pytest
from apart import run_apart

import pvphong as ph
from pvphong.base.files import locked
from pvphong.cli import main
from pvphong.optics.lights import PointLight
from pvphong.shading import kernel
from pvphong.shading.kernel import code as kernel_code

SCENE, MATERIAL = ph.Scene([PointLight(position=(0, 0, 3))], ph.Viewer()), ph.Material()
POINTS, NORMALS = np.zeros((2**18, 3), np.float32), np.tile(np.float32([0, 0, 1]), (2**18, 1))

USE = """
import numpy as np, pvphong as ph, sys
from pvphong.shading import kernel
from pvphong.shading.kernel import code as kernel_code
n = 2**18
lit = ph.evaluate(np.zeros((n, 3), np.float32), np.tile(np.float32([0, 0, 1]), (n, 1)),
                  ph.Scene([ph.PointLight(position=(0, 0, 3))]), ph.Material())
assert np.ptp(lit.rgb, axis=0).max() == 0.0
process = kernel_code._Compiler.process
print(kernel.has_run(), process.pid if process else None)
"""


@pytest.fixture
def without_code(monkeypatch):
    """Library without code on disk; return the list of requests."""
    library, asked = kernel_code.Library(), []
    monkeypatch.setattr(kernel_code, "store_of", lambda _: None)
    monkeypatch.setattr(kernel, "_library", lambda: library)
    monkeypatch.setattr(kernel_code, "ask_for", lambda *request: asked.append(request))
    monkeypatch.setattr(kernel_code.Library, "has_run", False)
    return asked


def light():
    return ph.evaluate(POINTS, NORMALS, SCENE, MATERIAL).rgb


def test_code_that_is_not_there_is_asked_for_and_numpy_lights(without_code):
    assert np.array_equal(light(), ph.evaluate(POINTS, NORMALS, SCENE, MATERIAL, backend="numpy").rgb)
    ((_, request, lock),) = without_code
    assert (request.stored, request.real) == ("float32", "float32")
    assert lock is None
    assert not kernel.has_run()


def test_a_window_does_not_wait_either(without_code):
    import pyvista as pv

    from pvphong.studio.lit_mesh import LitMesh

    live = LitMesh(pv.Plane(i_resolution=511, j_resolution=511), MATERIAL)
    assert live.refresh(SCENE)
    assert len(without_code) == 1


def test_normals_are_numpys_meanwhile(without_code):
    import pyvista as pv

    mesh = pv.Plane(i_resolution=400, j_resolution=400)
    assert np.array_equal(ph.pipeline.vertex_normals(mesh), ph.pipeline.vertex_normals(mesh, backend="numpy"))
    ((_, request, _),) = without_code
    assert request is None  # normals are part of what is always compiled
    assert not kernel.has_run()


def test_threads_wait_for_one_that_reads_code_and_not_for_one_that_compiles(monkeypatch):
    expected = ph.evaluate(POINTS, NORMALS, SCENE, MATERIAL, backend="numba").rgb  # its code is on disk from here on
    library, asked, in_numpy = kernel_code.Library(), [], ph.evaluate(POINTS, NORMALS, SCENE, MATERIAL, backend="numpy")
    monkeypatch.setattr(kernel, "_library", lambda: library)
    monkeypatch.setattr(kernel_code, "ask_for", lambda *request: asked.append(request))
    begun, ended, real = threading.Event(), threading.Event(), kernel_code.Code

    def slow(*arguments, compiles):
        begun.set()
        if compiles:
            ended.wait(60.0)
        else:
            time.sleep(0.1)
        return real(*arguments, compiles=compiles)

    monkeypatch.setattr(kernel_code, "Code", slow)
    with ThreadPoolExecutor(2) as pool:
        for found in [pool.submit(light) for _ in range(2)]:
            np.testing.assert_array_equal(found.result(), expected)
        assert not asked
        library._codes.clear()
        begun.clear()
        compiling = pool.submit(ph.evaluate, POINTS, NORMALS, SCENE, MATERIAL, backend="numba")
        assert begun.wait(60.0)
        np.testing.assert_array_equal(light(), in_numpy.rgb)
        assert len(asked) == 1
        ended.set()
        np.testing.assert_array_equal(compiling.result().rgb, expected)


@pytest.fixture
def compiler(monkeypatch):
    """State of a process without requests."""
    monkeypatch.setattr(kernel_code._Compiler, "asked", set())
    monkeypatch.setattr(kernel_code._Compiler, "process", None)
    return kernel_code._Compiler


def test_the_same_code_is_asked_for_once_and_not_while_another_process_compiles(compiler, monkeypatch, tmp_path):
    started, lock = [], tmp_path / "lock"
    monkeypatch.setattr(kernel_code, "_start", lambda request: started.append(request))
    assert compiler.process is None
    with locked(lock):
        kernel_code.ask_for("driver", "driver", lock)
    assert not started
    for key in ("driver", "driver", "stage"):
        kernel_code.ask_for(key, key, lock)
    assert started == ["driver", "stage"]
    kernel_code.ask_for("nowhere to keep it", "", None)
    assert len(started) == 2


def test_where_no_process_can_be_started_all_goes_on(compiler, monkeypatch, tmp_path):
    def fail(*_given, **_named):
        raise PermissionError

    monkeypatch.setattr(kernel_code.subprocess, "Popen", fail)
    kernel_code.ask_for("driver", kernel_code.Request(None, "float32", "float32"), tmp_path / "lock")
    assert compiler.process is None


def test_a_program_that_only_embeds_python_is_not_started(monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "executable", str(tmp_path / "paraview"))
    assert kernel_code._start(kernel_code.Request(None, "float32", "float32")) is None


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_from_an_empty_folder_to_compiled_code(tmp_path):
    """With several processes at once and the compiler killed and restarted, the code is finally there and used."""
    here = {"NUMBA_CACHE_DIR": str(tmp_path)}
    has_run, killed = run_apart(USE, **here).split()
    assert has_run == "False"
    os.kill(int(killed), signal.SIGKILL)
    (lock,) = wait_for(lambda: list(tmp_path.rglob("pvphong.lock")))
    wait_for(lambda: is_free(lock))
    has_run, compiler = run_apart(USE, **here).split()
    assert has_run == "False"
    try:
        wait_for(lambda: not is_free(lock))
        _, another = run_apart(USE, **here).split()
        assert another == "None"  # no second compiler beside the one that runs
        wait_for(lambda: any(tmp_path.rglob("arrive-*.pvphong")), seconds=150)
    finally:
        os.kill(int(compiler), signal.SIGKILL)
    assert run_apart(USE, **here) == "True None\n"
    assert not list(tmp_path.rglob("pvphong.lock.*"))


def is_free(lock):
    with locked(lock) as is_alone:
        return is_alone


def wait_for(what, seconds=30):
    for _ in count():
        found = what()
        if found:
            return found
        seconds -= 0.1
        assert seconds > 0
        time.sleep(0.1)
    return None


@pytest.mark.parametrize(
    ("name", "instead", "said"),
    [
        ("_library", lambda: None, "nothing can be compiled because Numba does not compile"),
        ("code.store_of", lambda _: None, "no folder for compiled code is writable"),
    ],
)
def test_the_reason_can_be_asked_for(name, instead, said, monkeypatch, capsys):
    monkeypatch.setattr(f"pvphong.shading.kernel.{name}", instead)
    assert main(["compile"]) == 1
    out, error = capsys.readouterr()
    assert "ray tracer: " in out
    assert said in error
    assert error.count("\n") == 1


def test_every_light_and_reflectance_has_its_pieces():
    from pvphong.shading.kernel.ahead import pieces
    from pvphong.shading.kernel.code import Library

    names = [piece.name for piece in pieces(Library())]
    assert {"faces", "normals, float32"} <= set(names)
    # with and without attenuation, and for each choice of lobes
    several = {name: found for name, found in Counter(names).items() if found > 1}
    assert several["point, float32"] == several["spot, float64"] == 2
    assert several["sphere, float32"] == several["disk, float64"] == 3
    assert several["ggx, float32"] == several["metal, float64"] + 1 == 7
    for real in ("float32", "float64"):
        for name in ("point", "spot", "phong", "blinn-phong", "oren-nayar", "headlight in VTK", "driver,"):
            assert any(each.startswith(name) and each.endswith(real) for each in names), (name, real)
