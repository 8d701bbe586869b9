"""What users wait for, from file to file and from drag to picture: `python bench_whole_job.py [most vertices | quick]`.

The kernel alone is in bench_kernel.py. Here are the steps around it, measured through the calls that users make: a file
read, normals, plan, light, and the file written; growth with the mesh; the first call of an installation; a
drag in a window. Comparators run in the same turns, so that a busy machine slows all of them down alike; medians count.
Growth goes up to 10 million vertices, or as many as are asked for: 100 million take 6 GB. `quick` tries all of it on
small meshes in less than a minute, without the first call of an installation; its times say little.
"""

import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from statistics import median

import numpy as np
import pyvista as pv
from common import apart, in_turns, measured_scene, table
from rich.console import Console

from pvphong import Plan, Shading
from pvphong.meshes.files import read_mesh, save_lit
from pvphong.shading import kernel
from pvphong.shading.equation import assemble
from pvphong.shading.vertices import Vertices

QUICK = sys.argv[1:] == ["quick"]
SIDE = 100 if QUICK else 1000
TURNS, FILE_TURNS, FRAMES = (3, 1, 3) if QUICK else (9, 3, 7)
FEW = 100  # shows what a call costs by itself
SIZES = (FEW, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000)
EXTRA_ALLOWED = 64  # MiB
GROWTH_ALLOWED = 1.3

# Point normals alone: making neighbours agree takes VTK twice as long again.
AS_THEY_ARE = {"cell_normals": False, "split_vertices": False, "consistent_normals": False}

# In a process of its own, whose peak is set back when everything is in place. The least time counts: memory that the
# machine has not lent out before costs more to touch than to light, once.
GROWTH = """
import gc, re, sys, time
import numpy as np
import pyvista as pv
import pvphong
from common import measured_scene
def status(field):
    return int(re.search(field + r":\\s+(\\d+)", open("/proc/self/status").read())[1]) * 1024
count = int(sys.argv[1])
few = np.random.default_rng(0).normal(size=(1000, 3)).astype(np.float32)
scene, material = measured_scene()
mesh = pv.PolyData(np.resize(few, (count, 3)))
mesh.point_data.active_normals = np.resize(few, (count, 3))
small = pv.PolyData(few)
small.point_data.active_normals = few
small.phong.shade(scene, material, backend="numba")
gc.collect()
open("/proc/self/clear_refs", "w").write("5")
before, seconds = status("VmRSS"), []
lit = mesh.phong.shade(scene, material, backend="numba")
extra = status("VmHWM") - before - lit["phong"].nbytes
for _ in range(min(1000, max(5, 5_000_000 // count))):
    start = time.perf_counter()
    lit = mesh.phong.shade(scene, material, backend="numba")
    seconds.append(time.perf_counter() - start)
print(min(seconds) / count * 1e9, extra / 2**20)
"""

FIRST = """
import sys, time
def now(what, start):
    print(f"{what}: {time.perf_counter() - start:.3f}", flush=True)
    return time.perf_counter()
start = time.perf_counter()
import pyvista as pv
start = now("import pyvista", start)
import pvphong as ph
start = now("import pvphong after it", start)
from common import measured_scene
mesh = pv.Sphere(theta_resolution=1000, phi_resolution=1000)
scene, material = measured_scene()
start = time.perf_counter()
mesh.phong.shade(scene, material)
start = now("first call, 1 M vertices", start)
mesh.phong.shade(scene, material)
start = now("second call", start)
"""


def timed(calls, turns):
    """Median seconds of each call, run in turns."""
    return {name: median(times) for name, times in in_turns(calls, turns).items()}


def sphere():
    """A million vertices in float32, without normals."""
    mesh = pv.Sphere(theta_resolution=SIDE, phi_resolution=SIDE)
    mesh.clear_data()
    return mesh


def window(mesh):
    """An offscreen window in which VTK lights a mesh."""
    plotter = pv.Plotter(off_screen=True, window_size=(1280, 800), lighting="none")
    for light in measured_scene()[0].lights:
        plotter.add_light(pv.Light(position=light.position, positional=True, cone_angle=90))
    plotter.add_mesh(mesh, color="tan", specular=0.5, specular_power=30, smooth_shading=True)
    plotter.show(auto_close=False)
    return plotter


def file_job(folder):
    """Seconds of reading, normals, plan, light and writing, and of their comparators."""
    scene, material = measured_scene()
    source, target = Path(folder, "in.vtp"), Path(folder, "out.vtp")
    sphere().save(source)
    mesh = read_mesh(str(source))
    smooth = mesh.compute_normals(**AS_THEY_ARE)
    lit = smooth.phong.shade(scene, material)
    points, normals = np.asarray(smooth.points), np.asarray(smooth.point_data.active_normals)
    total, out, equation = np.empty_like(points), Shading(np.empty_like(points)), assemble(scene, material, None)
    plotter = window(smooth)

    def frame():
        plotter.camera.azimuth += 3
        plotter.render()

    steps = {
        "normals": lambda: mesh.phong.normals(backend="numba"),
        "normals in NumPy": lambda: mesh.phong.normals(backend="numpy"),
        "plan": lambda: smooth.phong.plan(scene, material),
        "shade": lambda: smooth.phong.shade(scene, material),
        "shade, without normals": lambda: mesh.phong.shade(scene, material),
        "kernel": lambda: kernel.shade(points, normals, equation, None, out),
        "a + b": lambda: np.add(points, normals, out=total),
        "VTK's normals": lambda: mesh.compute_normals(**AS_THEY_ARE),
        "VTK's frame": frame,
    }
    files = {"read": lambda: read_mesh(str(source)), "write": lambda: save_lit(lit, target, "phong")}
    seconds = timed(steps, TURNS) | timed(files, FILE_TURNS)
    plotter.close()
    return seconds


def job_table(seconds):
    title = f"{SIDE**2 / 1e6:g} M vertices, {2 * SIDE**2 / 1e6:g} M triangles, 3 lamps with highlights"
    made = table(title, "step", "ms", "share", "over VTK's normals", "over a + b", "over VTK's frame")
    names = {
        "read": "read .vtp",
        "normals": "normals, compiled",
        "plan": "plan",
        "shade": "light",
        "write": "write .vtp",
    }
    whole = sum(seconds[name] for name in names)

    def row(label, value, share=""):
        ratios = (value / seconds[name] for name in ("VTK's normals", "a + b", "VTK's frame"))
        made.add_row(label, f"{value * 1e3:.2f}", share, *(f"{ratio:.3g}" for ratio in ratios))

    for name, label in names.items():
        row(label, seconds[name], f"{seconds[name] / whole:.1%}")
    row("all of it", whole, "100%")
    made.add_section()
    for name in ("normals in NumPy", "kernel", "shade, without normals", "VTK's normals", "a + b", "VTK's frame"):
        row(name, seconds[name])
    return made


def growth_table(most):
    title = "`shade` of points with normals, float32, each size in a process of its own"
    limits = f"over the least (<= {GROWTH_ALLOWED})", f"MiB beside input and output (<= {EXTRA_ALLOWED})"
    made = table(title, "vertices", "us a call", "ns per vertex", *limits)
    found = {count: tuple(map(float, apart(GROWTH, count).split())) for count in SIZES if count <= most}
    least = min(each for each, _ in found.values())
    for count, (each, extra) in found.items():
        ratio = "" if count == FEW else f"{each / least:.2f}" + " [red]too much[/]" * (each / least > GROWTH_ALLOWED)
        room = f"{extra:.1f}" + " [red]too much[/]" * (extra > EXTRA_ALLOWED)
        made.add_row(f"{count:,}", f"{each * count / 1e3:.0f}", f"{each:.2f}", ratio, room)
    return made


def first_table():
    made = table("Seconds in a fresh process", "what", "nothing compiled yet", "compiled code on disk")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        runs = [apart(FIRST, NUMBA_CACHE_DIR=folder).splitlines() for _ in range(2)]
    for first, second in zip(*runs, strict=True):
        made.add_row(*first.split(": "), second.split(": ")[1])
    return made


def drag_seconds():
    """A light dragged over a million vertices in a window: seconds of each part, and of a frame lit by VTK."""
    scene, material = measured_scene()
    mesh = sphere().compute_normals(**AS_THEY_ARE)
    ours, vtks = pv.Plotter(off_screen=True, window_size=(1280, 800), lighting="none"), window(mesh)
    for light in scene.lights:
        ours.phong.add_light(light)
    live = ours.phong.mesh(ours.phong.add_mesh(mesh, material))
    ours.show(auto_close=False)
    subplot, parts = ours.phong._subplot, {}
    vertices = Vertices(live.drawn.points, live.normals)
    for turn in range(FRAMES):
        ours.phong.set_light(0, replace(scene.lights[0], position=(2.0, 1.0, 2.5 + 0.05 * turn)))
        now = subplot.scene
        planned = Plan.of(now, material, Vertices(live.drawn.points, live.normals))
        calls = {
            "plan": lambda now=now: Plan.of(now, material, Vertices(live.drawn.points, live.normals)),
            "kernel, to 0-255": lambda planned=planned: planned.run_for_display(vertices, live.drawn["phong"]),
            "all of bringing colours up to date": subplot.lit.refresh,
            "frame with new colours": ours.render,
            "frame with the same colours": ours.render,
            "noticing that nothing has changed": subplot.lit.refresh,
            "frame lit by VTK": lambda: (setattr(vtks.camera, "azimuth", 3 * turn), vtks.render()),  # noqa: B023
        }
        for name, call in calls.items():
            start = time.perf_counter()
            call()
            parts.setdefault(name, []).append(time.perf_counter() - start)
    assert live.evaluations == FRAMES + 1
    ours.close()
    vtks.close()
    return {name: median(times) for name, times in parts.items()}


def drag_table(seconds):
    made = table("A light dragged in a window, 1280 x 800 pixels", "part", "ms", "over VTK's frame")
    upload = seconds["frame with new colours"] - seconds["frame with the same colours"]
    shown = {
        "noticing that something has changed": seconds["noticing that nothing has changed"],
        "plan": seconds["plan"],
        "kernel, to 0-255": seconds["kernel, to 0-255"],
        "these three and the hand-over, as they are called": seconds["all of bringing colours up to date"],
        "upload of the colours by VTK": upload,
        "VTK's drawing of them": seconds["frame with the same colours"],
        "for comparison: a frame lit by VTK": seconds["frame lit by VTK"],
    }
    for name, value in shown.items():
        made.add_row(name, f"{value * 1e3:.2f}", f"{value / seconds['frame lit by VTK']:.1%}")
    return made


def main():
    most = 100_000 if QUICK else int(float(sys.argv[1])) if len(sys.argv) > 1 else 10_000_000
    console = Console(width=120)
    with tempfile.TemporaryDirectory() as folder:
        seconds = file_job(folder)
    console.print(job_table(seconds))
    allowed = {"shade": ("kernel", 3), "normals": ("VTK's normals", 1.5), "normals in NumPy": ("VTK's normals", 1.5)}
    for name, (other, most_over) in allowed.items():
        console.print(f"{name} over {other}: {seconds[name] / seconds[other]:.2f}, allowed {most_over}")
    console.print(drag_table(drag_seconds()))
    console.print(growth_table(most))
    if not QUICK:
        console.print(first_table())


if __name__ == "__main__":
    main()
