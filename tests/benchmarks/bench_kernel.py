"""How fast the compiled evaluator is: `python bench_kernel.py [vertices]`.

Every workload is measured as a ratio to `np.add(a, b, out=out)` on (n, 3) float32 arrays, which is what the memory
allows NumPy, and to the textbook's formula. All are measured in turns, so that a busy machine slows them down
alike, and the least time of each counts; processor time on one thread is what a busy machine changes least. The
targets are for two cores that have nothing else to do. Whether they had is told by how much faster two threads are
than one; a machine that is shared is at times slow for seconds, so the repeats are spread over the whole run.
"""

import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
from rich.console import Console
from rich.table import Table
from textbook import shade as textbook
from textbook import vertices

from pvphong.base import threads
from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.optics.material import Material
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading import kernel
from pvphong.shading.equation import assemble
from pvphong.shading.plan.effects import EFFECTS
from pvphong.shading.plan.plan import Plan
from pvphong.shading.reference import Shading
from pvphong.shading.vertices import Vertices

COUNT = 1_000_000
REPEATS = 200
BURSTS = 5
FEW_REPEATS = 40
TURNS = 8
SIZES = (100_000, 1_000_000, 10_000_000, 50_000_000)

DULL = Material(ambient=0.1, diffuse=(0.6, 0.5, 0.4))
SHINY = replace(DULL, specular=0.5, shininess=20)
LAMPS = (
    PointLight(position=(2.0, 1.0, 2.5), diffuse=(1.0, 0.9, 0.8)),
    PointLight(position=(-2.0, 1.5, 1.0), diffuse=(0.3, 0.4, 0.9)),
    PointLight(position=(0.5, -2.0, 2.0)),
)
SPOT = SpotLight(
    position=(2.0, 1.0, 2.5), direction=(-2.0, -1.0, -2.5), cone_angle=40, exponent=8, attenuation=(1, 0.1, 0.05)
)
SUN = DirectionalLight(direction=(-1.0, -1.0, -2.0))
VIEWER = Viewer(position=(1.0, 0.5, 4.0))

FIRST_CALL = """
import time
import numpy as np
from pvphong import Material, PointLight, Scene, evaluate
arguments = (np.ones((1000, 3), np.float32), np.ones((1000, 3), np.float32), Scene([PointLight()]), Material())
seconds = []
for _ in range(2):
    start = time.perf_counter()
    evaluate(*arguments, backend="numba")
    seconds.append(time.perf_counter() - start)
print(seconds[0] - seconds[1])
"""


# In a process of its own, because the resident size's peak never goes down; the arrays are in place before.
PEAK = """
import re, sys
import numpy as np
from pvphong import Material, PointLight, Scene, evaluate
def peak():  # not ru_maxrss, which begins with what the parent process had
    return int(re.search(r"VmHWM:\\s+(\\d+)", open("/proc/self/status").read())[1]) * 1024
count, stored = int(sys.argv[1]), np.dtype(sys.argv[2])
points, normals = (np.full((count, 3), value, stored) for value in (0.5, 1.0))
scene, material = Scene([PointLight(position=(k, 2, 3)) for k in range(3)]), Material(specular=0.5, shininess=20)
evaluate(points[:1000], normals[:1000], scene, material, backend="numba")
before = peak()
rgb = evaluate(points, normals, scene, material, backend="numba").rgb
print(peak() - before - rgb.nbytes)
"""
MANY = 10_000_000


def scene_of(*lights):
    return Scene(lights=lights, viewer=VIEWER)


BLINN_PHONG = replace(scene_of(*LAMPS), light_model=LightModel(reflection="blinn-phong"))


def compiled(arrays, scene, material, real, planned=False):
    """A call of the kernel, without its plan unless that is asked for; `.plan` tells what is expected of it."""
    points, normals = arrays
    out = Shading(np.empty(points.shape, real))
    equation = assemble(scene, material, None)

    def run():
        left = equation
        if planned:
            left = Plan.of(scene, material, Vertices(points, normals)).equation
        kernel.shade(points, normals, left, None, out)

    run.plan = Plan.of(scene, material, Vertices(points, normals))
    return run


def least_times(calls, repeats, clock=time.perf_counter):
    """Seconds of the fastest repeat of each call, all measured in turns."""
    least = dict.fromkeys(calls, float("inf"))
    for call in calls.values():
        call()
    for _ in range(repeats):
        for name, call in calls.items():
            start = clock()
            call()
            least[name] = min(least[name], clock() - start)
    return least


def least_times_alone(calls, repeats):
    """Seconds of processor time of the fastest repeat of each call on one thread."""
    with threads.limited(1):
        return least_times(calls, repeats, time.thread_time)


def workloads(count):
    """Name → call."""
    small, wide = vertices(count, np.float32), vertices(count)
    missing = [SpotLight(position=(0.0, 0.0, 50.0 + k), direction=(0, 0, 1), cone_angle=20) for k in range(60)]
    lit = [*LAMPS, replace(LAMPS[0], position=(0.0, 3.0, 0.0))]
    total = np.empty_like(small[0])
    return {
        "a + b": lambda: np.add(*small, out=total),
        "3 lamps, highlights": compiled(small, scene_of(*LAMPS), SHINY, np.float32),
        "3 lamps, highlights, Blinn-Phong": compiled(small, BLINN_PHONG, SHINY, np.float32),
        "3 lamps, highlights, 0-255": compiled(small, scene_of(*LAMPS), SHINY, np.uint8),
        "3 lamps, dull": compiled(small, scene_of(*LAMPS), DULL, np.float32),
        "1 sun, dull": compiled(small, scene_of(SUN), DULL, np.float32),
        "ambient only": compiled(small, scene_of(), DULL, np.float32),
        "1 lamp, highlights": compiled(small, scene_of(LAMPS[0]), SHINY, np.float32),
        "1 spot, highlights": compiled(small, scene_of(SPOT), SHINY, np.float32),
        "4 lamps, with plan": compiled(small, scene_of(*lit), SHINY, np.float32, planned=True),
        "64 lights, 60 miss, with plan": compiled(small, scene_of(*lit, *missing), SHINY, np.float32, planned=True),
        "3 lamps, highlights, float64": compiled(wide, scene_of(*LAMPS), SHINY, np.float64),
    }


def targets(least, book):
    """(what, measured, target, whether more is better) for each promise."""
    add = least["a + b"]
    highlights = least["3 lamps, highlights"]
    return [
        ("3 lamps, highlights: textbook over it", book / highlights, 60.0, True),
        ("3 lamps, highlights: over a + b", highlights / add, 3.5, False),
        ("3 lamps, dull: over a + b", least["3 lamps, dull"] / add, 1.5, False),
        ("1 sun, dull: over a + b", least["1 sun, dull"] / add, 0.8, False),
        ("ambient only: over a + b", least["ambient only"] / add, 0.5, False),
        ("1 spot over 1 lamp", least["1 spot, highlights"] / least["1 lamp, highlights"], 1.6, False),
        ("float64: textbook over it", book / least["3 lamps, highlights, float64"], 12.0, True),
        ("0-255 over float32", least["3 lamps, highlights, 0-255"] / highlights, 1.0, False),
        ("64 lights over 4", least["64 lights, 60 miss, with plan"] / least["4 lamps, with plan"], 1.3, False),
    ]


def measure_growth():
    """Nanoseconds of processor time per vertex on one thread, by number of vertices; the least of some turns.

    In each turn every size shades as many vertices in all, so that a busy machine meets all of them alike.
    """
    result = dict.fromkeys(SIZES, float("inf"))
    few = vertices(SIZES[0], np.float32)
    calls = {
        count: compiled(tuple(np.resize(array, (count, 3)) for array in few), scene_of(*LAMPS), SHINY, np.float32)
        for count in SIZES
    }
    with threads.limited(1):
        for _ in range(TURNS):
            for count, call in calls.items():
                call()
                start = time.thread_time()
                for _ in range(SIZES[-1] // count):
                    call()
                result[count] = min(result[count], (time.thread_time() - start) / SIZES[-1] * 1e9)
    return result


def measure_first_call():
    """Seconds by which the first call in a process takes longer than the second, with compiled code on disk."""
    runs = (
        subprocess.run([sys.executable, "-c", FIRST_CALL], capture_output=True, text=True, check=True) for _ in range(5)
    )
    return min(float(run.stdout) for run in runs)


def estimate(call):
    """What `Plan.explain` says that a call costs, ns per vertex on one thread; the writing of colours is no effect."""
    plan = getattr(call, "plan", None)
    return plan and sum(effect.nanoseconds(plan.effects[effect.name]) for effect in EFFECTS)


def measure_peak(stored):
    """MiB of resident memory at the peak beside inputs, stored as some type, and float32 output."""
    command = [sys.executable, "-c", PEAK, str(MANY), stored]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    return float(run.stdout) / 2**20


def times_table(calls, least, alone, book, count):
    table = Table(title=f"{count / 1e6:g} M vertices, least of {REPEATS} repeats in turns")
    for heading in ("workload", "ms", "over a + b", "textbook over it", "one thread, ns", "of which plan says"):
        table.add_column(heading, justify="left" if heading == "workload" else "right")
    for name, seconds in {**least, "textbook, float64": book}.items():
        ratios = f"{seconds / least['a + b']:.2f}", f"{book / seconds:.1f}"
        single = f"{alone[name] / count * 1e9:.2f}" if name in alone else ""
        expected = estimate(calls.get(name))
        table.add_row(name, f"{seconds * 1e3:.2f}", *ratios, single, "" if expected is None else f"{expected:.1f}")
    return table


def targets_table(rows):
    table = Table(title="Targets")
    for heading in ("what", "measured", "target", "met"):
        table.add_column(heading, justify="left" if heading == "what" else "right")
    for what, measured, target, more in rows:
        met = measured >= target if more else measured <= target
        shown = f"{'>=' if more else '<='} {target:g}"
        table.add_row(what, f"{measured:.2f}", shown, "[green]yes[/]" if met else "[red]no[/]")
    return table


def main():
    count = int(float(sys.argv[1])) if len(sys.argv) > 1 else COUNT
    console = Console()
    calls, bursts = workloads(count), []

    def burst():
        bursts.append(least_times(calls, REPEATS // BURSTS))

    burst()
    alone = least_times_alone(calls, FEW_REPEATS)
    burst()
    arrays = vertices(count)
    book = least_times({"it": lambda: textbook(*arrays, scene_of(*LAMPS), SHINY)}, 3)["it"]
    burst()
    first_call = measure_first_call()
    peaks = {stored: measure_peak(stored) for stored in ("float32", "float64")}
    burst()
    growth = measure_growth()
    burst()
    least = {name: min(times[name] for times in bursts) for name in calls}
    rows = targets(least, book)
    rows.append(("first call over second, seconds", first_call, 0.6, False))
    for stored, peak in peaks.items():
        rows.append((f"peak memory, {MANY / 1e6:g} M vertices in {stored}, MiB", peak, 32.0, False))
    rows.append(("ns per vertex, largest over least", max(growth.values()) / min(growth.values()), 1.15, False))
    console.print(times_table(calls, least, alone, book, count))
    console.print("One thread: " + ", ".join(f"{n:,} vertices {ns:.2f} ns each" for n, ns in growth.items()))
    sooner = alone["3 lamps, highlights"] / least["3 lamps, highlights"]
    console.print(f"3 lamps, highlights: two threads are {sooner:.2f} times as fast as one")
    console.print(targets_table(rows))


if __name__ == "__main__":
    main()
