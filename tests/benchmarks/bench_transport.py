"""Light that bounces, beside Mitsuba 3's path integrator and Blender's bake: time against error at the same vertices.

    python tests/benchmarks/bench_transport.py [cells] [--blender PYTHON]

A closed room of grids with a coloured wall on either side, a plate in it, and a glowing ball. All bounces are
wanted at every vertex; the judge is `mesh.phong.truth` with many paths, whose noise is taken off each error. Times are
processor times of the whole call, rays included: for `transport` also the second time, by other lights. Mitsuba sends
paths to the vertices from just above; Blender bakes vertex colours in a process of its own, and its brightness is
scaled to the judge's.
"""

import argparse
import subprocess
import time

import numpy as np
import pyvista as pv
from rich.console import Console

import pvphong as ph

try:
    from benchmarks import scene_peers as peers
    from benchmarks.common import Cast, equal_error_seconds, slope, table, timed
except ImportError:
    import scene_peers as peers
    from common import Cast, equal_error_seconds, slope, table, timed

OURS = "transport and all bounces"
JUDGE_PATHS = 1024
COLORS = {"floor": (0.7, 0.7, 0.7), "ceiling": (0.7, 0.7, 0.7), "back": (0.7, 0.7, 0.6), "front": (0.6, 0.6, 0.6)}
COLORS |= {"left": (0.7, 0.1, 0.1), "right": (0.1, 0.6, 0.1), "plate": (0.5, 0.5, 0.7)}


def grid(center, direction, cells, size=1.0):
    many = {"i_size": size, "j_size": size, "i_resolution": cells, "j_resolution": cells}
    mesh = pv.Plane(center=center, direction=direction, **many).triangulate()
    mesh.clear_data()
    mesh.point_data.active_normals = np.tile(np.float32(direction), (mesh.n_points, 1))
    return mesh


def walls(cells):
    """Blocks by name."""
    slant = np.array([0.3, -0.8, 0.5]) / np.linalg.norm([0.3, -0.8, 0.5])
    return pv.MultiBlock(
        {
            "floor": grid((0, 0, -0.5), (0, 0, 1), cells),
            "ceiling": grid((0, 0, 0.5), (0, 0, -1), cells),
            "back": grid((0, 0.5, 0), (0, -1, 0), cells),
            "front": grid((0, -0.5, 0), (0, 1, 0), cells),
            "left": grid((-0.5, 0, 0), (1, 0, 0), cells),
            "right": grid((0.5, 0, 0), (-1, 0, 0), cells),
            "plate": grid((0.05, 0.1, -0.15), tuple(slant), max(cells // 3, 1), 0.4),
        }
    )


LAMP = ph.SphereLight(position=(0.1, -0.1, 0.25), radius=0.08, intensity=0.12, name="lamp")
BULB = pv.Icosphere(radius=0.998 * LAMP.radius, center=LAMP.position, nsub=4)
"""Mitsuba's and Blender's lamps block light."""
MATERIALS = {name: ph.Material(ambient=0.0, specular=0.0, diffuse=color) for name, color in COLORS.items()}


def room(cells, bounces=peers.ALL_BOUNCES):
    model = ph.LightModel(ambient=0.0, clamp=False, shadows=True, bounces=bounces)
    scene = ph.Scene([LAMP], ph.Viewer((0, -0.4, 0), (0, 0, 0), (0, 0, 1)), model)
    return peers.Job(walls(cells), scene, MATERIALS, (BULB,))


def joined(by_block, value):
    return np.concatenate([value(each) for each in by_block])


def judged(job, paths):
    """Colours by paths of light, and their standard errors."""
    limit = None if job.bounces >= peers.ALL_BOUNCES else job.bounces
    how = {"samples": paths, "occluders": job.occluders, "max_bounces": limit}
    truth = job.blocks.phong.truth(job.scene, job.materials, **how).values()
    return joined(truth, lambda each: each.rgb), joined(truth, lambda each: each.standard_error)


# --- our ways: each gives what (rays) → (seconds, colours) does


def ours(job, again=None):
    """The seconds of lighting a second time, without a ray, go to a list."""

    def cast(rays):
        start = time.process_time()
        among = {"occluders": job.occluders}
        seen = job.blocks.phong.visibility(job.scene, samples=rays, **among)
        how = among | {"transport": job.blocks.phong.transport(samples=rays, **among), "visibility": seen}
        lit = job.blocks.phong.shade(job.scene, job.materials, **how)
        middle = time.process_time()
        if again is not None:
            job.blocks.phong.shade(job.scene, job.materials, **how)
            again.append(time.process_time() - middle)
        return Cast(middle - start, joined(lit, lambda block: block["phong"]))

    return cast


def paths(job):
    return timed(lambda rays: judged(job, rays)[0])


def compare(cells, python):
    """Rows of the table: way, rays, seconds, relative RMS error; seconds at equal error by way; what is missing; and
    our seconds for other lights."""
    job, again = room(cells), []
    true, noise = judged(job, JUDGE_PATHS)
    ways = {OURS: (lambda: ours(job, again), (16, 64, 256, 1024))}
    ways |= {"mesh.phong.truth": (lambda: paths(job), (16, 64, 256))}
    ways |= {"Mitsuba's path integrator": (lambda: peers.mitsuba(job), (16, 64, 256))}
    ways |= {"Blender's bake": (lambda: peers.blender(job, python), (16, 64))}
    rows, curves, missing = [], {}, {}
    for name, (make, counts) in ways.items():
        try:
            cast = make()
            cast(counts[0])  # compiles
            for rays in counts:
                seconds, colors = cast(rays)
                if name.startswith("Blender"):
                    colors = colors * np.vdot(colors, true) / np.vdot(colors, colors)
                square = np.square(colors - true).mean() - np.square(noise).mean()
                error = float(np.sqrt(max(square, 1e-12)) / true.mean())
                rows.append((name, rays, seconds, error))
                curves.setdefault(name, []).append((seconds, error))
        except (ImportError, FileNotFoundError, subprocess.CalledProcessError) as reason:
            missing[name] = str(reason)
    return len(true), rows, curves, missing, min(again)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cells", nargs="?", type=int, default=30)
    parser.add_argument("--blender", metavar="PYTHON", help="one that imports bpy")
    options = parser.parse_args()
    count, rows, curves, missing, again = compare(options.cells, options.blender)
    shown = table(f"all bounces at {count} vertices", "way", "rays", "seconds", "relative RMS error")
    for name, rays, seconds, error in rows:
        shown.add_row(name, str(rays), f"{seconds:.2f}", f"{error:.4f}")
    for name, reason in missing.items():
        shown.add_row(name, "", "", f"missing: {reason}"[:60])
    console = Console()
    console.print(shown)
    print(f"Other lights, by what is known: {again:.3f} s")
    own = curves[OURS]
    for name, curve in curves.items():
        numbers, errors = zip(*[(rays, error) for way, rays, _, error in rows if way == name], strict=True)
        print(f"{name}: errors as rays to the power {slope(numbers, errors):.2f}")
        if name != OURS:
            seconds, error = own[2]
            ratio = equal_error_seconds(curve, error) / seconds
            print(f"    at the error of our {rows[2][1]} rays: {ratio:.1f} times as long")


if __name__ == "__main__":
    main()
