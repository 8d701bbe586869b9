"""VTK's shader, read back per vertex, beside pvphong's evaluators: `python bench_vtk_shade.py`.

All three light the same million vertices, in turns, so that a busy machine slows all of them down alike. Times are
wall clock: VTK's includes sending the mesh to the driver and reading the colours back, and a software driver works
on the same processor.
"""

from dataclasses import replace
from statistics import median

import numpy as np
import pyvista as pv
from common import in_turns, measured_scene, table, vertices
from rich.console import Console

from pvphong import evaluate
from pvphong.shading import kernel
from pvphong.vtk.oracle import driver, vtk_shade
from pvphong.vtk.scenes import in_vtk_terms

COUNT = 1_000_000
REPEATS = 5


def variants():
    """Name → what is timed."""
    points, normals = vertices(COUNT, "float32")
    scene, material = measured_scene()
    # VTK has highlights in the diffuse colour of the light only
    scene = replace(scene, lights=[replace(light, specular=None) for light in scene.lights])
    cloud = pv.PolyData(points)
    cloud.point_data.active_normals = normals
    terms = in_vtk_terms(scene, material, np.array(cloud.center), cloud.length)

    def lit(backend):
        return lambda: evaluate(points, normals, scene, material, backend=backend).rgb

    backends = ["numpy", "numba"] if kernel.is_available() else ["numpy"]
    named = {f"evaluate, {backend}": lit(backend) for backend in backends}
    return named | {"vtk_shade": lambda: vtk_shade(cloud, terms.lights, terms.material, terms.viewer)}


def main():
    named = variants()
    seconds, colors = in_turns(named, REPEATS), {name: run() for name, run in named.items()}
    headings = "", "time", "quickest – slowest", "per vertex", "of vtk_shade's", "largest difference from VTK"
    made = table(f"{COUNT:,} vertices, median of {REPEATS} runs in turns", *headings)
    drawn, whole = np.clip(colors["vtk_shade"], 0.0, 1.0), median(seconds["vtk_shade"])
    for name, times in seconds.items():
        middle = median(times)
        made.add_row(
            name,
            f"{middle * 1e3:.0f} ms",
            f"{min(times) * 1e3:.0f} – {max(times) * 1e3:.0f} ms",
            f"{middle / COUNT * 1e9:.0f} ns",
            f"{middle / whole:.2f}",
            "" if name == "vtk_shade" else f"{np.abs(colors[name] - drawn).max():.1e}",
        )
    console = Console(width=120)
    console.print(made)
    console.print(f"VTK {pv.vtk_version_info} on {driver()}")


if __name__ == "__main__":
    main()
