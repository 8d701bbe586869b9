"""Writers that are killed at any moment, or meet a limit on the size of files: there is the old file, or a new one.

`python tests/interrupting.py 500 20` kills so many of them, and sets so many limits. Each writer runs in a
process that is forked from this one.
"""

from __future__ import annotations

import hashlib
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


def digest(path):
    """Of what a file holds: a mesh's points and colours, or the bytes."""
    if path.suffix not in (".vtm", ".vtkhdf"):
        return hashlib.sha256(path.read_bytes()).digest()
    from pvphong.meshes.files import read_mesh

    mesh = read_mesh(path)
    parts = list(mesh) if path.suffix == ".vtm" else [mesh]
    return hashlib.sha256(b"".join(part.points.tobytes() + part["phong"].tobytes() for part in parts)).digest()


def forked(work, *, until=None, limit=None):
    """Do something in a process of its own, which is killed after some seconds; gives its status, and its bytes."""
    end, start = os.pipe()
    process = os.fork()
    if process == 0:
        status = 1
        try:
            if limit is not None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
            os.write(start, work() or b"")
            status = 0
        except ValueError:
            status = 2
        finally:
            os._exit(status)
    os.close(start)
    if until is not None:
        time.sleep(until)
        os.kill(process, signal.SIGKILL)
    with os.fdopen(end, "rb") as pipe:
        result = pipe.read()
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]), result


class Format:
    """A folder with a file of one format, and the digests of an old and a new one. Nothing of VTK runs here."""

    def __init__(self, name, writers, place):
        self.name, self.folder = name, place / name.replace(".", "-")
        self.write_old, self.write_new = writers
        self.known = []
        for write in (self.write_new, self.write_old):
            self.folder.mkdir(parents=True, exist_ok=True)
            began = time.monotonic()
            assert self.run(write) == 0, name
            self.seconds = time.monotonic() - began
            self.known.append(self.digest())
        self.size = (self.folder / name).stat().st_size

    def run(self, write, **how):
        return forked(lambda: write(self.folder), **how)[0]

    def digest(self):
        return forked(lambda: digest(self.folder / self.name))[1]

    def fault(self):
        """What is wrong with the file that is there, or None."""
        found = self.digest()
        return None if found in self.known else "neither the old file nor the new one" if found else "cannot be read"

    def left(self):
        """What is there beside the file and its folder."""
        return sorted({path.name for path in self.folder.iterdir()} - {self.name, Path(self.name).stem})

    def clear(self):
        """Write again, a minute later: then a folder is cleared too whose writer was killed before it locked it."""
        for path in self.folder.glob(f"{PREFIX}*"):
            if not any(path.iterdir()):
                os.utime(path, (0, 0))
        assert self.run(self.write_old) == 0


def interrupt(count, limits):
    """Kill writers; gives how many were writing, and what was wrong."""
    faults, writing = [], 0
    with tempfile.TemporaryDirectory() as place:
        formats = [Format(name, pair, Path(place)) for name, pair in writers().items()]
        for number in range(count):
            each = formats[number % len(formats)]
            each.run(each.write_new, until=random.Random(number).uniform(0.0, 1.1 * each.seconds))
            writing += bool(each.left())
            faults += [(each.name, fault) for fault in [each.fault()] if fault]
        for each in formats:
            each.clear()
            faults += [(each.name, f"left {left}") for left in each.left()]
            for step in range(limits):
                limit = int(1.5 * each.size * step / limits)
                status = each.run(each.write_new, limit=limit)
                what = each.fault() or ("" if status in (0, 2) else f"status {status}") or each.left()
                faults += [(each.name, f"limit {limit}: {what}")] if what else []
    return {"kills": count, "in mid-write": writing, "limits": limits * len(formats), "faults": faults}


if __name__ == "__main__":
    print(json.dumps(interrupt(*map(int, sys.argv[1:]))))
