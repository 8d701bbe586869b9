"""Bounced light by pvphong, Mitsuba 3's path integrator and Blender's bake: time against error at the same vertices.

    python tests/benchmarks/bench_transport.py [vertices] [--blender PYTHON]

The scene is a closed room of grids with coloured side walls, a plate and a glowing ball. All bounces are computed at
every vertex, and compared with `mesh.phong.truth` with many paths. Times are of the whole call, rays included; for
`transport` also of a second call with other lights. Mitsuba sends paths to the vertices from just above; Blender bakes
vertex colours in a separate process. `ways.py` describes the measurement.
"""

import time
from functools import partial

import cyclopts
import numpy as np
import pyvista as pv
import scene_peers as peers
from common import Cast, grid, timed
from ways import BLENDER, MITSUBA, OURS, Row, Way, show_row

import pvphong as ph

COLORS = {"floor": (0.7, 0.7, 0.7), "ceiling": (0.7, 0.7, 0.7), "back": (0.7, 0.7, 0.6), "front": (0.6, 0.6, 0.6)}
COLORS |= {"left": (0.7, 0.1, 0.1), "right": (0.1, 0.6, 0.1), "plate": (0.5, 0.5, 0.7)}


INWARD = {"floor": (0, 0, 1), "ceiling": (0, 0, -1), "back": (0, -1, 0), "front": (0, 1, 0)}
INWARD |= {"left": (1, 0, 0), "right": (-1, 0, 0)}
SLANT = tuple(np.array([0.3, -0.8, 0.5]) / np.linalg.norm([0.3, -0.8, 0.5]))


def walls(cells):
    """Return the blocks of the room by name."""
    blocks = {name: grid(cells, 1.0, -0.5 * np.array(inward), inward) for name, inward in INWARD.items()}
    return pv.MultiBlock(blocks | {"plate": grid(max(cells // 3, 1), 0.4, (0.05, 0.1, -0.15), SLANT)})


LAMP = ph.SphereLight(position=(0.1, -0.1, 0.25), radius=0.08, intensity=0.12, name="lamp")
BULB = pv.Icosphere(radius=0.998 * LAMP.radius, center=LAMP.position, nsub=4)
"""Mitsuba's and Blender's lamps block light."""
MATERIALS = {name: ph.Material(ambient=0.0, specular=0.0, diffuse=color) for name, color in COLORS.items()}


def room(cells, bounces):
    model = ph.LightModel(ambient=0.0, clamp=False, shadows=True, bounces=bounces)
    scene = ph.Scene([LAMP], ph.Viewer((0, -0.4, 0), (0, 0, 0), (0, 0, 1)), model)
    return peers.Job(walls(cells), scene, MATERIALS, (BULB,))


def judged(job, paths):
    """Return colours by path tracing."""
    limit = None if job.bounces >= peers.ALL_BOUNCES else job.bounces
    how = {"samples": paths, "occluders": job.occluders, "max_bounces": limit}
    return np.concatenate([each.rgb for each in job.blocks.phong.truth(job.scene, job.materials, **how).values()])


def ours(job, again=None):
    """Return a caster; append the seconds of a second call, which casts no rays, to the list `again`."""

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
        return Cast(middle - start, np.concatenate([block["phong"] for block in lit]))

    return cast


def row(name, bounces, python, *more, again=None):
    """Return a row with pvphong, other programs, and more ways."""

    def make(size):
        return room(max(round((size / 6.1) ** 0.5) - 1, 2), bounces)

    ways = [
        Way(OURS, partial(ours, again=again), (16, 64, 256), 100_000),
        Way(MITSUBA, peers.mitsuba, (16, 64, 256), 10_000, own_truth=2048),
        Way(BLENDER, partial(peers.blender, python=python), (16, 64), 1200, own_truth=1024),
        *more,
    ]
    return Row(name, make, lambda job: judged(job, 1024), ways, judged_at=1)


PATHS = Way("mesh.phong.truth", lambda job: timed(partial(judged, job)), (16, 64, 256))


def main(vertices: float = 6000, *, blender: str | None = None) -> None:
    sizes, again = (int(vertices),), []
    measured = row("All bounces", peers.ALL_BOUNCES, blender, PATHS, again=again)
    measured.measure(sizes)
    show_row(measured, sizes)
    print(f"Second call with other lights: {min(again):.3f} s")


if __name__ == "__main__":
    cyclopts.run(main)
