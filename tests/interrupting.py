"""Writers that are killed at any moment or hit a file size limit must leave the old file or a complete new one.

`python tests/interrupting.py 500 20` kills 500 writers and sets 20 limits. Each writer runs in a process forked from
this one.
"""

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
    """File name → writer, a function of its path and a seed."""
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

    def blocks(seed):
        return pv.MultiBlock({"one": mesh(seed), "two": mesh(seed + 10)})

    def picture(seed):
        return np.random.default_rng(seed).integers(0, 256, (200, 200, 3), np.uint8)

    def scene(seed):
        return Scene([PointLight(position=(seed, n, 0), name=f"lamp {n}") for n in range(2000)])

    def lit(path, seed):
        save_lit(mesh(seed), path, "phong")

    return dict.fromkeys(("lit.vtp", "lit.vtk", "lit.vtkhdf", "lit.ply"), lit) | {
        "lit.vtm": lambda path, seed: save_lit(blocks(seed), path, "phong"),
        "scene.json": lambda path, seed: scene(seed).save(path),
        "picture.png": lambda path, seed: save_picture(picture(seed), path),
        "report.json": lambda path, seed: write_json(list(range(seed, 20_000 + seed)), path),
    }


def is_read_as_bytes(path):
    return path.suffix not in (".vtm", ".vtkhdf")


def digest(path):
    """Return a digest of a file's content: a mesh's points and colours, or the bytes."""
    if is_read_as_bytes(path):
        return hashlib.sha256(path.read_bytes()).digest()
    from pvphong.meshes.files import read_mesh

    mesh = read_mesh(path)
    parts = list(mesh) if path.suffix == ".vtm" else [mesh]
    return hashlib.sha256(b"".join(part.points.tobytes() + part["phong"].tobytes() for part in parts)).digest()


def forked(work, *, until=None, limit=None):
    """Run a function in a separate process, killed after some seconds. Return its status and its output."""
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
    """A folder with a file of one format, and the digests of two contents, 1 and 2. VTK does not run here."""

    def __init__(self, name, writer, place):
        self.name, self.folder, self.writer = name, place / name.replace(".", "-"), writer
        self.folder.mkdir()
        self.known = []
        for seed in (2, 1):
            began = time.monotonic()
            assert self.write(seed) == 0, name
            self.seconds = time.monotonic() - began
            self.known.append(self.digest())
        self.size = (self.folder / name).stat().st_size

    def write(self, seed, **how):
        return forked(lambda: self.writer(self.folder / self.name, seed), **how)[0]

    def digest(self):
        path = self.folder / self.name
        return digest(path) if is_read_as_bytes(path) else forked(lambda: digest(path))[1]

    def fault(self):
        """Return the fault of the existing file, or None."""
        found = self.digest()
        return None if found in self.known else "neither the old file nor the new one" if found else "cannot be read"

    def left(self):
        """Return entries other than the file and its folder."""
        return sorted({path.name for path in self.folder.iterdir()} - {self.name, Path(self.name).stem})


def interrupt(count, limits):
    """Kill writers; return the number that were writing, and the faults."""
    faults, writing = [], 0
    with tempfile.TemporaryDirectory() as place:
        formats = [Format(name, writer, Path(place)) for name, writer in writers().items()]
        for number in range(count):
            each = formats[number % len(formats)]
            each.write(2, until=random.Random(number).uniform(0.0, 1.1 * each.seconds))
            writing += bool(each.left())
            faults += [(each.name, fault) for fault in [each.fault()] if fault]
        for each in formats:
            for path in each.folder.glob(f"{PREFIX}*"):
                if not any(path.iterdir()):  # killed before locking it: removed a minute later
                    os.utime(path, (0, 0))
            assert each.write(1) == 0
            faults += [(each.name, f"left {left}") for left in each.left()]
            for step in range(limits):
                limit = int(1.5 * each.size * step / limits)
                status = each.write(2, limit=limit)
                what = each.fault() or ("" if status in (0, 2) else f"status {status}") or each.left()
                faults += [(each.name, f"limit {limit}: {what}")] if what else []
    return {"kills": count, "in mid-write": writing, "limits": limits * len(formats), "faults": faults}


if __name__ == "__main__":
    print(json.dumps(interrupt(*map(int, sys.argv[1:]))))
