"""Writers that are killed at any moment, or meet a limit on the size of files: there is the old file, or a new one.

`python tests/interrupting.py 500 20` kills so many of them, and sets so many limits. Each writer runs in a
process that is forked from this one.
"""

from __future__ import annotations

import json
import os
import random
import resource
import signal
import sys
import tempfile
import time
from pathlib import Path

from pvphong.base.files import PREFIX


def writers():
    """How each sort of file is written, by its name: an old one and a new one."""
    import numpy as np
    import pyvista as pv

    from pvphong import PointLight, Scene
    from pvphong.base.files import write_json
    from pvphong.meshes.files import save_lit
    from pvphong.meshes.pictures import save_picture

    def mesh(seed):
        ball = pv.Sphere(theta_resolution=40, phi_resolution=40)
        ball["phong"] = np.random.default_rng(seed).random((ball.n_points, 3))
        return ball

    def lit(name):
        return [lambda path, seed=seed: save_lit(mesh(seed), path / name, "phong") for seed in (1, 2)]

    def blocks(seed):
        return pv.MultiBlock({"one": mesh(seed), "two": mesh(seed + 10)})

    def picture(seed):
        return np.random.default_rng(seed).integers(0, 256, (200, 200, 3), np.uint8)

    def scene(seed):
        return Scene([PointLight(position=(seed, n, 0), name=f"lamp {n}") for n in range(2000)])

    numbers = [list(range(seed, 20_000 + seed)) for seed in (1, 2)]
    return {
        **{f"lit.{suffix}": lit(f"lit.{suffix}") for suffix in ("vtp", "vtk", "vtkhdf", "ply")},
        "lit.vtm": [lambda path, seed=seed: save_lit(blocks(seed), path / "lit.vtm", "phong") for seed in (1, 2)],
        "scene.json": [lambda path, seed=seed: scene(seed).save(path / "scene.json") for seed in (1, 2)],
        "picture.png": [lambda path, seed=seed: save_picture(picture(seed), path / "picture.png") for seed in (1, 2)],
        "report.json": [lambda path, each=each: write_json(each, path / "report.json") for each in numbers],
    }


def contents(path):
    """What a file holds: a mesh's points and colours, or the bytes."""
    if path.suffix not in (".vtm", ".vtkhdf"):
        return path.read_bytes()
    from pvphong.meshes.files import read_mesh

    mesh = read_mesh(path)
    parts = list(mesh) if path.suffix == ".vtm" else [mesh]
    return b"".join(part.points.tobytes() + part["phong"].tobytes() for part in parts)


def forked(work, *, until=None, limit=None):
    """Do something in a process of its own, which is killed after some seconds; gives its status."""
    process = os.fork()
    if process == 0:
        status = 1
        try:
            if limit is not None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
            work()
            status = 0
        except ValueError:
            status = 2
        finally:
            os._exit(status)
    if until is not None:
        time.sleep(until)
        os.kill(process, signal.SIGKILL)
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])


class Sort:
    """One sort of file, with an old and a new one for comparison."""

    def __init__(self, name, make, place):
        self.name, self.place = name, place / name.replace(".", "-")
        self.old, self.new = make
        self.known = []
        for write in make:
            folder = self.place / f"known-{len(self.known)}"
            folder.mkdir(parents=True)
            began = time.monotonic()
            assert forked(lambda write=write, folder=folder: write(folder)) == 0, name
            self.seconds = time.monotonic() - began
            self.known.append(self.read(folder))
        self.size = (folder / name).stat().st_size
        self.folder = self.place / "work"
        self.folder.mkdir()

    def read(self, folder):
        """In a process of its own, too: nothing of VTK may run in this one."""
        end, start = os.pipe()
        if os.fork() == 0:
            import hashlib

            os.write(start, hashlib.sha256(contents(folder / self.name)).digest())
            os._exit(0)
        os.close(start)
        os.wait()
        with os.fdopen(end, "rb") as told:
            return told.read()

    def fault(self):
        """What is wrong with the file that is there, or None."""
        found = self.read(self.folder)
        return None if found in self.known else "neither the old file nor the new one" if found else "cannot be read"

    def begin(self):
        """Have the old file there."""
        assert forked(lambda: self.old(self.folder)) == 0

    def wait(self):
        """Let a minute be over: then an empty folder is cleared too, whose writer was killed before it locked it."""
        for path in self.folder.glob(f"{PREFIX}*"):
            if not any(path.iterdir()):
                os.utime(path, (0, 0))

    def left(self):
        """What is there beside the file and its folder."""
        return sorted({path.name for path in self.folder.iterdir()} - {self.name, Path(self.name).stem})


def interrupt(count, limits):
    """Kill writers; gives how many had begun to write, and what was wrong."""
    faults, began = [], 0
    with tempfile.TemporaryDirectory() as place:
        sorts = [Sort(name, make, Path(place)) for name, make in writers().items()]
        for number in range(count):
            sort, dice = sorts[number % len(sorts)], random.Random(number)
            if not (sort.folder / sort.name).exists():
                sort.begin()
            forked(lambda sort=sort: sort.new(sort.folder), until=dice.uniform(0.0, 1.1 * sort.seconds))
            began += bool(sort.left())
            faults += [(sort.name, fault) for fault in [sort.fault()] if fault]
        for sort in sorts:
            sort.wait()
            sort.begin()  # clears what was left
            faults += [(sort.name, f"left {left}") for left in sort.left()]
            for step in range(limits):
                limit = int(1.5 * sort.size * step / limits)
                status = forked(lambda sort=sort: sort.new(sort.folder), limit=limit)
                what = sort.fault() or ("" if status in (0, 2) else f"status {status}") or sort.left()
                faults += [(sort.name, f"limit {limit}: {what}")] if what else []
    return {"kills": count, "in mid-write": began, "limits": limits * len(sorts), "faults": faults}


if __name__ == "__main__":
    print(json.dumps(interrupt(*map(int, sys.argv[1:]))))
