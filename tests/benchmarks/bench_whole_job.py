"""Time of whole jobs, from file to file and from drag to picture: `python bench_whole_job.py [most vertices | quick]`.

bench_kernel.py measures the kernel alone. This benchmark measures the steps around it through public calls: reading a
file, normals, plan, light and writing the file; growth with the mesh; the first call of an installation; and dragging a
light in a window. Comparisons run in the same turns, so that a busy machine slows all of them down alike; medians
count. Growth is measured up to 10 million vertices by default; 100 million need 6 GB. `quick` runs everything on small
meshes in less than a minute, except the first call of an installation; its times are not meaningful.
"""

import gc
import itertools
import math
import tempfile
from dataclasses import replace
from pathlib import Path
from statistics import median
from timeit import repeat
from typing import Literal

import cyclopts
import numpy as np
import pyvista as pv
from common import CONSOLE, alone, apart, in_turns, measured_scene, peak, reset_peak, show

from pvphong import (
    Colormap,
    EnvironmentLight,
    LightModel,
    Material,
    Plan,
    PointLight,
    RectangleLight,
    Scene,
    Shading,
    SphereLight,
    Viewer,
)
from pvphong.meshes.files import read_mesh, save_lit
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.shading import kernel
from pvphong.shading.equation import assemble
from pvphong.shading.vertices import Vertices

FEW = 100  # shows the constant cost of a call
SIZES = (FEW, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000)
EXTRA_ALLOWED = 64  # MiB
GROWTH_ALLOWED = 1.3

# Point normals alone: VTK needs twice as long again to make neighbours consistent.
AS_THEY_ARE = {"cell_normals": False, "split_vertices": False, "consistent_normals": False}

FIRST = """
import time
def now(what, start):
    print(f"{what}: {time.perf_counter() - start:.3f}")
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
now("second call", start)
"""


def growth(count):
    """Return nanoseconds per vertex and MiB beyond input and output; run it in a separate process.

    The least time counts, because the first access to newly allocated memory costs more than lighting.
    """
    few = np.random.default_rng(0).normal(size=(1000, 3)).astype(np.float32)
    small, mesh = pv.PolyData(few), pv.PolyData(np.resize(few, (count, 3)))
    small.point_data.active_normals, mesh.point_data.active_normals = few, np.resize(few, (count, 3))
    lighting, how = measured_scene(), {"backend": "numba"}
    small.phong.shade(*lighting, **how)
    gc.collect()
    before = reset_peak()
    lit = mesh.phong.shade(*lighting, **how)
    extra = peak() - before - lit["phong"].nbytes
    times = min(1000, max(5, 5_000_000 // count))
    least = min(repeat(lambda: mesh.phong.shade(*lighting, **how), number=1, repeat=times))
    return least / count * 1e9, extra / 2**20


def sphere(side):
    """Return a sphere in float32, without normals."""
    mesh = pv.Sphere(theta_resolution=side, phi_resolution=side)
    mesh.clear_data()
    return mesh


def window(mesh):
    """Return an off-screen window in which VTK lights a mesh."""
    plotter = pv.Plotter(off_screen=True, window_size=(1280, 800), lighting="none")
    for light in measured_scene()[0].lights:
        plotter.add_light(pv.Light(position=light.position, positional=True, cone_angle=90))
    plotter.add_mesh(mesh, color="tan", specular=0.5, specular_power=30, smooth_shading=True)
    plotter.show(auto_close=False)
    return plotter


def file_job(folder, side, turns, file_turns):
    """Return seconds of reading, normals, plan, light and writing, and of their comparisons."""
    scene, material = measured_scene()
    source, target = Path(folder, "in.vtp"), Path(folder, "out.vtp")
    sphere(side).save(source)
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
        "normals, compiled": lambda: mesh.phong.normals(backend="numba"),
        "normals in NumPy": lambda: mesh.phong.normals(backend="numpy"),
        "plan": lambda: smooth.phong.plan(scene, material),
        "light": lambda: smooth.phong.shade(scene, material),
        "shade, without normals": lambda: mesh.phong.shade(scene, material),
        "kernel": lambda: kernel.evaluator()(points, normals, equation, {}, out),
        "a + b": lambda: np.add(points, normals, out=total),
        "VTK's normals": lambda: mesh.compute_normals(**AS_THEY_ARE),
        "VTK's frame": frame,
    }
    files = {"read .vtp": lambda: read_mesh(str(source)), "write .vtp": lambda: save_lit(lit, target, "phong")}
    seconds = in_turns(steps, turns, of=median) | in_turns(files, file_turns, of=median)
    plotter.close()
    return seconds


def show_job(seconds, side):
    steps = "read .vtp", "normals, compiled", "plan", "light", "write .vtp"
    others = "normals in NumPy", "kernel", "shade, without normals", "VTK's normals", "a + b", "VTK's frame"
    whole = sum(seconds[name] for name in steps)

    def row(name, value, share=""):
        ratios = (value / seconds[other] for other in ("VTK's normals", "a + b", "VTK's frame"))
        return name, f"{value * 1e3:.2f}", share, *(f"{ratio:.3g}" for ratio in ratios)

    rows = [row(name, seconds[name], f"{seconds[name] / whole:.1%}") for name in steps]
    rows += [row("total", whole, "100%"), (), *(row(name, seconds[name]) for name in others)]
    title = f"{side**2 / 1e6:g} M vertices, {2 * side**2 / 1e6:g} M triangles, 3 lamps with highlights"
    show(title, ("step", "ms", "share", "over VTK's normals", "over a + b", "over VTK's frame"), rows)
    allowed = ("light", "kernel", 3), ("normals, compiled", "VTK's normals", 1.5)
    for name, other, most in (*allowed, ("normals in NumPy", "VTK's normals", 1.5)):
        CONSOLE.print(f"{name} over {other}: {seconds[name] / seconds[other]:.2f}, allowed {most}")


def show_growth(most):
    found, rows = {count: alone(growth, count) for count in SIZES if count <= most}, []
    least = min(each for each, _ in found.values())
    for count, (each, extra) in found.items():
        ratio = "" if count == FEW else f"{each / least:.2f}" + " [red]too much[/]" * (each / least > GROWTH_ALLOWED)
        room = f"{extra:.1f}" + " [red]too much[/]" * (extra > EXTRA_ALLOWED)
        rows.append((f"{count:,}", f"{each * count / 1e3:.0f}", f"{each:.2f}", ratio, room))
    limits = f"over the least (<= {GROWTH_ALLOWED})", f"MiB beyond input and output (<= {EXTRA_ALLOWED})"
    title = "`shade` of points with normals, float32, each size in a separate process"
    show(title, ("vertices", "us per call", "ns per vertex", *limits), rows)


def show_first():
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        runs = [apart(FIRST, NUMBA_CACHE_DIR=folder).splitlines() for _ in range(2)]
    rows = [(*first.split(": "), second.split(": ")[1]) for first, second in zip(*runs, strict=True)]
    show("Seconds in a fresh process", ("what", "nothing compiled yet", "compiled code on disk"), rows)


def drag(side, frames):
    """Drag a light over a mesh in a window; return seconds of each part, and of a frame lit by VTK."""
    scene, material = measured_scene()
    mesh = sphere(side).compute_normals(**AS_THEY_ARE)
    ours, vtks = pv.Plotter(off_screen=True, window_size=(1280, 800), lighting="none"), window(mesh)
    for light in scene.lights:
        ours.phong.add_light(light)
    live = ours.phong.mesh(ours.phong.add_mesh(mesh, material))
    ours.show(auto_close=False)
    subplot, heights = ours.phong._subplot, itertools.count(2.5, 0.05)
    vertices = Vertices(live.drawn.points, live.normals)

    def plan():
        return Plan.of(subplot.scene, material, Vertices(live.drawn.points, live.normals))

    def move():
        nonlocal planned
        ours.phong.set_light(0, replace(scene.lights[0], position=(2.0, 1.0, next(heights))))
        planned = plan()

    def frame():
        vtks.camera.azimuth += 3
        vtks.render()

    planned = plan()
    parts = {
        "moving": move,
        "plan": plan,
        "kernel, to 0-255": lambda: planned.run_for_display(vertices, live.drawn["phong"]),
        "whole update of colours": subplot.lit.refresh,
        "frame with new colours": ours.render,
        "frame with the same colours": ours.render,
        "detecting that nothing has changed": subplot.lit.refresh,
        "frame lit by VTK": frame,
    }
    seconds = in_turns(parts, frames, of=median)
    assert live.evaluations == frames + 2
    ours.close()
    vtks.close()
    return seconds


def show_drag(seconds):
    parts = {
        "detecting that something has changed": seconds["detecting that nothing has changed"],
        "plan": seconds["plan"],
        "kernel, to 0-255": seconds["kernel, to 0-255"],
        "these three and the hand-over": seconds["whole update of colours"],
        "upload of the colours by VTK": seconds["frame with new colours"] - seconds["frame with the same colours"],
        "drawing of the colours by VTK": seconds["frame with the same colours"],
        "for comparison: a frame lit by VTK": seconds["frame lit by VTK"],
    }
    rows = [(name, f"{each * 1e3:.2f}", f"{each / seconds['frame lit by VTK']:.1%}") for name, each in parts.items()]
    show("A light dragged in a window, 1280 x 800 pixels", ("part", "ms", "over VTK's frame"), rows)


# --- outliers among public calls

LAMP = PointLight(position=(0.3, 0.2, 1.5))
SHINY = Material(specular=0.5, shininess=30)
EYE = Viewer(position=(0.0, 0.0, 4.0))
OTHERS = "blinn-phong", "modified-phong", "retro", "pbr"
BYTES_OF_A_POINT = 12 + 12 + 2 * 4 * 8 + 12  # point, normal, two triangles with an offset each, and a colour
GROWTH_OF_CALLS, MEMORY_OF_CALLS = 1.1, 4.0


def public_calls(side, folder):
    """Return public calls by name, on planes of `side` by `side` points; those with rays on a ninth of the points."""
    rng = np.random.default_rng(0)
    plane = pv.Plane(i_resolution=side - 1, j_resolution=side - 1).triangulate()
    textured = plane.copy()
    plane.clear_data()
    plane.point_data.active_normals = np.tile(np.float32((0, 0, 1)), (plane.n_points, 1))
    bare, few = plane.copy(), pv.Plane(i_resolution=side // 3, j_resolution=side // 3).triangulate()
    bare.clear_data()
    ball = pv.Sphere(theta_resolution=side, phi_resolution=side)
    plane["tint"], plane["height"] = rng.random((plane.n_points, 3)), rng.random(plane.n_points)
    lights = [replace(LAMP, position=(np.cos(k), np.sin(k), 1.5)) for k in range(8)]
    one, three, eight = (Scene(lights[:count], EYE) for count in (1, 3, 8))
    texture = pv.Texture(rng.integers(0, 256, (512, 512, 3), np.uint8))
    sky = Scene([EnvironmentLight(rng.random((64, 128, 3)))], EYE)
    hard, soft = (Scene([light], EYE, LightModel(shadows=True)) for light in (LAMP, SphereLight((0.3, 0.2, 1.5), 0.2)))
    lit, seen = plane.phong.shade(three, SHINY), few.phong.visibility(hard)
    small = pv.MultiBlock([pv.Sphere() for _ in range(max(side * side // 2000, 1))])
    seen.per_light  # noqa: B018 casts the rays

    def shade(scene, material=SHINY, mesh=plane, **how):
        return lambda: mesh.phong.shade(scene, material, **how)

    return {
        "a lamp": shade(one),
        "3 lamps": shade(three),
        "8 lamps": shade(eight),
        "shares of 3 lamps": shade(three, components=True),
        "shares of 8 lamps": shade(eight, components=True),
        "float64": shade(one, precision="float64"),
        "no normals": shade(one, mesh=bare),
        "feature_angle=30": shade(one, mesh=bare, feature_angle=30),
        "sky with an image": shade(sky),
        "sphere light": shade(Scene([SphereLight((0.3, 0.2, 1.5), 0.2)], EYE)),
        "rectangle light": shade(Scene([RectangleLight((0.3, 0.2, 1.5))], EYE)),
        **{name: shade(one, replace(SHINY, reflectance=REFLECTANCES[name]())) for name in OTHERS},
        "map of albedo": shade(one, replace(SHINY, albedo="tint")),
        "colormap": shade(one, replace(SHINY, albedo=Colormap("height"))),
        "texture": shade(one, replace(SHINY, albedo=texture), textured),
        "blocks of 842 points": lambda: small.phong.shade(one, SHINY),
        "plan": lambda: plane.phong.plan(one, SHINY),
        "normals": lambda: bare.phong.normals(),
        "color_view": lambda: lit.phong.color_view("hsv"),
        "save .vtp": lambda: lit.phong.save(Path(folder, "lit.vtp")),
        "diagnose": lambda: plane.phong.diagnose(),
        "diagnose, poles": lambda: ball.phong.diagnose(),
        "interpolation_error": lambda: plane.phong.interpolation_error(one, SHINY),
        "interpolation_error, poles": lambda: ball.phong.interpolation_error(one, SHINY),
        "refine, a ninth": lambda: few.phong.refine(one, SHINY, tolerance=0.01),
        "relight, a ninth": lambda: few.phong.shade(hard, SHINY, visibility=seen),
        "hard shadows, a ninth": lambda: few.phong.visibility(hard).per_light,
        "soft shadows, a ninth": lambda: few.phong.visibility(soft).per_light,
    }


def outliers(side, folder):
    """Return seconds and peak memory in bytes of calls by name."""
    found = {}
    for name, call in public_calls(side, folder).items():
        call()
        gc.collect()
        before = reset_peak()
        call()
        held = peak() - before
        turns = 9 if side < 500 else 3
        found[name] = median(repeat(call, number=1, repeat=turns)), held
    return found


def show_outliers(sides):
    """Print calls in multiples of one lamp, with the exponent of growth, and memory relative to input and result."""
    with tempfile.TemporaryDirectory() as folder:
        found = {side * side: alone(outliers, side, folder) for side in sides}
    counts, rows = sorted(found), []
    most = found[counts[-1]]
    for name, (seconds, held) in most.items():
        times = [found[count][name][0] for count in counts[-2:]]
        power = math.log(times[1] / times[0], counts[-1] / counts[-2])
        share = held / (counts[-1] * BYTES_OF_A_POINT)
        marks = "[red]grows too fast[/]" * (power > GROWTH_OF_CALLS) + " [red]holds much[/]" * (share > MEMORY_OF_CALLS)
        multiple = f"{seconds / most['a lamp'][0]:.1f}"
        rows.append((name, f"{seconds * 1e3:.2f}", multiple, f"{power:.2f}", f"{share:.2f}", marks))
    columns = "call", "ms", "x a lamp", f"power (<= {GROWTH_OF_CALLS})", f"memory (<= {MEMORY_OF_CALLS})", ""
    title = f"{counts[-1]:,} points; memory beyond input, in multiples of points, normals, faces and colours"
    show(title, columns, rows)


def main(most: float | Literal["quick"] = 10_000_000):
    quick = most == "quick"
    side, turns, file_turns, frames = (100, 3, 1, 3) if quick else (1000, 9, 3, 7)
    with tempfile.TemporaryDirectory() as folder:
        show_job(file_job(folder, side, turns, file_turns), side)
    show_drag(drag(side, frames))
    show_outliers((30, 100) if quick else (316, 1000))
    show_growth(100_000 if quick else most)
    if not quick:
        show_first()


if __name__ == "__main__":
    cyclopts.run(main)
