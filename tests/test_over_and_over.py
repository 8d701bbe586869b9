"""Repeated windows, updates and VTK pictures, in threads and processes: no leaks, and identical results."""

import ctypes
import gc
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.vtk.oracle import vtk_shade

KIB = 1024
COLOURS_KIB = 75
"""Size of the mesh's colours: at most half of it may leak per repeat."""


def few_or_many(few, many):
    return pytest.mark.parametrize(
        "count", [pytest.param(few, id="few"), pytest.param(many, id="many", marks=pytest.mark.long)]
    )


@few_or_many(16, 10_000)
@pytest.mark.parametrize("what", ["window", "update", "vtk_shader"])
def test_nothing_is_left(what, count):
    count *= 40 if what == "update" else 1  # `undo` keeps 256 of them
    done = subprocess.run([sys.executable, __file__, what, str(count)], capture_output=True, text=True, check=True)
    (begin, objects, files), (end, objects_at_last, files_at_last) = json.loads(done.stdout)
    assert objects_at_last <= objects + count // 20
    assert files_at_last <= files
    # some 1 KiB for each window stays with VTK and the driver
    assert (end - begin) / (count // 2) < COLOURS_KIB / 2


@few_or_many(100, 1000)
def test_threads_at_once_give_the_same_bits(count):
    mesh, lamp = pv.Sphere(), ph.PointLight(position=(2, 1, 3))
    expected = mesh.phong.shade(lamp)["phong"]
    with ThreadPoolExecutor(100) as threads:
        for lit in threads.map(lambda _: mesh.phong.shade(lamp)["phong"], range(count)):
            np.testing.assert_array_equal(lit, expected)


@few_or_many(3, 20)
def test_processes_at_once_write_the_same_files(count, tmp_path):
    pv.Sphere().save(tmp_path / "ball.vtp")
    command = [sys.executable, "-m", "pvphong", "shade", "ball.vtp", "-o"]
    running = [subprocess.Popen([*command, f"{k}.vtp"], cwd=tmp_path, stdout=subprocess.DEVNULL) for k in range(count)]
    assert [process.wait() for process in running] == [0] * count
    assert {path.name for path in tmp_path.iterdir()} == {"ball.vtp", *(f"{k}.vtp" for k in range(count))}
    colors = [pv.read(tmp_path / f"{k}.vtp")["phong"] for k in range(count)]
    np.testing.assert_array_equal(colors, colors[:1] * count)


# --- the measured process


class Allocated(ctypes.Structure):
    """Result of glibc's `mallinfo2` (`man 3 mallinfo`): `uordblks` and `hblkhd` (mapped pages) are in use."""

    _NAMES = "arena ordblks smblks hblks hblkhd usmblks fsmblks uordblks fordblks keepcost"
    _fields_ = [(name, ctypes.c_size_t) for name in _NAMES.split()]


def held():
    """Return allocated KiB, the number of Python's objects, and of open files.

    Resident memory is too coarse: freed memory returns to the system only now and then, 9 MB at a time.
    """
    gc.collect()
    mallinfo2 = ctypes.CDLL(None).mallinfo2
    mallinfo2.restype = Allocated
    allocated = mallinfo2()
    kib = (allocated.uordblks + allocated.hblkhd) // KIB
    return kib, len(gc.get_objects()), len(os.listdir("/proc/self/fd"))


BALL = pv.Sphere(theta_resolution=80, phi_resolution=80)
LAMP = ph.PointLight(position=(2, 1, 3), name="lamp")


def window():
    plotter = pv.Plotter(off_screen=True, window_size=(100, 80), lighting="none")
    plotter.phong.add_light(LAMP)
    plotter.phong.add_mesh(BALL.copy(), ph.Material(specular=0.3, shininess=9))
    plotter.phong.add_gizmos()
    plotter.show(auto_close=False)
    return plotter


def main(what, count):
    pv.global_theme.multi_samples = 1  # more take a processor twice as long
    found, shown = [], window() if what == "update" else None
    for number in range(count + 1):
        if what == "window":
            window().close()
        elif what == "vtk_shader":
            vtk_shade(BALL, [LAMP], ph.Material(), ph.Viewer())
        else:
            shown.phong.set_light("lamp", replace(LAMP, position=(2, 1, 3 + 1e-4 * number)))
            shown.phong._subplot.lit.refresh()  # as before each frame
        if number in (count // 2, count):
            found.append(held())
    print(json.dumps(found))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
