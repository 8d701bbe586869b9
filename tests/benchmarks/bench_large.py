"""Measured times of pieces of a city, and a simulated schedule of a cluster for 10¹² vertices.

`python bench_large.py [vertices] [pieces across]`

`shade_files` lights a scan of houses under a low sun, in square pieces, with two workers. Results are seconds, the
largest memory of a worker, and the number of pieces that each piece reads. Then one process runs each kind of task
alone, and a scheduler and a client are timed with empty tasks, in processor seconds. A queue simulates a cluster from
these times: workers take pieces, the scheduler assigns them one by one, all share the bandwidth of the storage, and
processes die at random. The work of a dead process, and the borders that it held, are computed again. The simulated
processors are like the one that runs the benchmark.
"""

import heapq
import itertools
import pickle
import tempfile
import time
import tracemalloc
from dataclasses import dataclass, replace
from pathlib import Path

import cyclopts
import numpy as np
import psutil
import pyvista as pv
from common import files_lit, new_cluster, show
from distributed import Client

import pvphong as ph
from pvphong.batch.culling import Outline, PotentialOccluders, potential_occluders, touching
from pvphong.batch.pieces import Piece
from pvphong.batch.seams import neighbours_of
from pvphong.batch.shading import ShadingJob
from pvphong.batch.worker import border_in, light, look
from pvphong.meshes.files import read_mesh

ALL = 1e12
HOUSE, ROUGH = 12, 0.02
SUN = ph.DirectionalLight(direction=(-2.0, -1.0, -1.5))
SCENE = ph.Scene([SUN], ph.Viewer(position=(50.0, 40.0, 90.0)), ph.LightModel(shadows=True))
NOTHING, FEW, OUTLINES, TURNS = 1000, 200, 20_000, 20

# --- a city in pieces


def piece_of_city(column, row, houses):
    """Return a square of houses, each 2 wide, without normals; neighbouring squares share points at their borders."""
    side, rng = houses * HOUSE, np.random.default_rng([column, row])
    z = np.zeros((side + 1, side + 1))
    z[:-1, :-1] = np.kron(4.0 * rng.random((houses, houses)) ** 3, np.pad(np.ones((HOUSE - 2, HOUSE - 2)), 1))
    z[1:-1, 1:-1] += ROUGH * rng.random((side - 1, side - 1))
    x, y = (2.0 / HOUSE * (np.arange(side + 1) + side * place) for place in (column, row))
    points = np.stack([*np.meshgrid(x, y, indexing="ij"), z], axis=2).reshape(-1, 3).astype(np.float32)
    first = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    corners = np.stack([first, first + side + 1, first + side + 2, first, first + side + 2, first + 1], axis=1)
    return pv.PolyData.from_regular_faces(points, corners.reshape(-1, 3))


def save_city(folder, vertices, across):
    """Save the pieces row by row, and return their paths."""
    houses = max(round(vertices**0.5 / across / HOUSE), 1)
    for number in range(across * across):
        piece_of_city(*divmod(number, across), houses).save(Path(folder, f"{number:05}.vtp"))
    return sorted(Path(folder).glob("*.vtp"))


# --- measurement


@dataclass(frozen=True)
class Task:
    """Cost of one kind of task for a piece."""

    name: str
    seconds: float  # of one worker, with files in the page cache
    bytes: float  # read and written
    messages: float = 1.0  # tasks that the scheduler assigns for it
    serial: float = 0.0  # additional seconds of the client
    kept: bool = False  # True if the result stays with the worker to the end


@dataclass(frozen=True)
class Measured:
    """Measured costs of a piece."""

    vertices: int
    tasks: tuple[Task, Task, Task]  # outline, border, and lighting
    blockers: float  # other pieces that are read for its shadows
    among: float
    """Seconds of the client to find the neighbours of a piece among `OUTLINES`; proportional to this number's root."""
    per_message: float  # seconds of scheduler and client per task
    held: float  # bytes that scheduler and client hold per task


def timed(call, *arguments, times=2):
    """Return a call's least processor seconds and its value."""
    seconds = []
    for _ in range(times):
        start = time.process_time()
        value = call(*arguments)
        seconds.append(time.process_time() - start)
    return min(seconds), value


def measured(files, out, client):
    """Measure each kind of task for a piece in the middle."""
    out.mkdir()
    pieces = [Piece(path, Path(out, path.name), surface="city") for path in files]
    middle = len(files) // 2 + int(len(files) ** 0.5) // 2
    piece = pieces[middle]
    job = ShadingJob(None, "phong", "", "lz4", SCENE, {"default": ph.Material()}, {"backend": "numba"})
    borders = [border_in(each) for each in pieces]
    outlines = [border.outline for border in borders]
    beside = [borders[other] for other in list(touching(outlines))[middle]]
    occluders = list(potential_occluders(SCENE, pieces, outlines))
    around = occluders[middle]
    light(replace(piece, output=Path(out, "first.vtp")), job, None, around)  # loads code
    looking, _ = timed(look, piece, job)
    bordering, _ = timed(border_in, piece)
    meeting, faces = timed(neighbours_of, borders[middle], beside)
    lighting, result = timed(light, piece, job, faces, around, "x", times=1)
    assert not result.reason, result
    size, lit = files[middle].stat().st_size, piece.output.stat().st_size
    moved = size * (1 + len(around.blockers)) + 2 * lit + sum(len(pickle.dumps(border)) for border in beside)
    tasks = (
        Task("look", looking, size),
        Task("border", bordering, size, messages=2.0, kept=True),
        Task("light", meeting + lighting, moved, messages=2.0),
    )
    blockers = float(np.mean([len(each.blockers) for each in occluders]))
    return Measured(outlines[middle].count, tasks, blockers, among(OUTLINES), *overhead(client, piece, job, around))


def among(count):
    """Return the seconds to find the pieces that touch one of `count` pieces, and those that may block its light."""
    side = round(count**0.5)
    lows = np.stack([*np.divmod(np.arange(side**2), side), np.zeros(side**2)], axis=1)
    outlines = [Outline((low, low + 1.0), (low, low + 1.0), 1) for low in lows]
    some = zip(touching(outlines), potential_occluders(SCENE, range(side**2), outlines), strict=True)
    next(some)  # builds arrays of all pieces
    start = time.process_time()
    for _ in itertools.islice(some, TURNS):
        pass
    return (time.process_time() - start) / TURNS


def overhead(client, piece, job, around: PotentialOccluders):
    """Return seconds of scheduler and client for an empty task, and the bytes that they hold for it."""
    process = psutil.Process()

    def begin(count):
        tasks = [client.submit(idle, replace(piece, label=str(k)), job, around, pure=False) for k in range(count)]
        client.gather(tasks)
        return tasks

    begin(FEW)
    busy = sum(process.cpu_times()[:2])
    begin(NOTHING)
    used = sum(process.cpu_times()[:2]) - busy
    tracemalloc.start()
    tasks = begin(FEW)
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return used / NOTHING, held / len(tasks)


def idle(*_):
    """Do nothing; an empty task for a worker."""


# --- the schedule


@dataclass(frozen=True)
class Cluster:
    """Properties of a cluster."""

    workers: int
    storage: float = 100e9  # bytes per second, for all workers
    link: float = 1e9  # bytes per second, for one worker
    per_message: float = 1e-3  # seconds of scheduler and client per task
    lives: float = 30 * 86400.0  # mean seconds until a worker dies
    restart: float = 60.0  # seconds until it is replaced


@dataclass(frozen=True)
class Schedule:
    """Result of a simulated run."""

    seconds: float
    busy: dict[str, float]
    """Utilisation of the workers, of the scheduler with its client, and of the storage."""
    deaths: int
    redone: float  # fraction of the pieces' tasks that were repeated


def simulate(tasks, pieces, cluster, seed=0):
    """Simulate lighting of `pieces` pieces: one kind of task after the other, each piece by the next free worker."""
    rng, now = np.random.default_rng(seed), 0.0
    busy, deaths, redone, kept = {"workers": 0.0, "scheduler": 0.0, "storage": 0.0}, 0, 0.0, 0.0
    for task in tasks:
        handing, moving = task.messages * cluster.per_message + task.serial, task.bytes / cluster.storage
        working = task.seconds + task.bytes / cluster.link
        handed = moved = now
        free, left = [now] * cluster.workers, float(pieces)
        while left > 0.0:
            start = heapq.heappop(free)
            handed = max(handed, start) + handing
            moved = max(moved, handed) + moving
            end = max(moved, handed + working)
            busy["scheduler"], busy["storage"] = busy["scheduler"] + handing, busy["storage"] + moving
            busy["workers"] += working
            if rng.random() < (end - start) / cluster.lives:
                deaths += 1
                # also borders that it held for pieces that are not lit yet, in tasks of this kind
                lost = kept / working / cluster.workers * left / pieces
                left, redone, end = left + lost, redone + lost + 1.0, end + cluster.restart
            else:
                left -= 1.0
            heapq.heappush(free, end)
        kept += task.kept * pieces * working
        now = max(free)
    busy["workers"] /= cluster.workers
    shares = {name: value / now for name, value in busy.items()}
    return Schedule(now, shares, deaths, redone / pieces / len(tasks))


def tasks_of(found, vertices, pieces):
    """Return the tasks of a piece with `vertices` vertices. Times and bytes are proportional, except the border's."""
    larger, finding = vertices / found.vertices, found.among * (pieces / OUTLINES) ** 0.5
    *first, lit = (replace(each, seconds=each.seconds * larger, bytes=each.bytes * larger) for each in found.tasks)
    return [*first, replace(lit, serial=finding)]


CASES = (
    ("pieces of a million", 1e6, Cluster(100)),
    ("ten times the workers", 1e6, Cluster(1000)),
    ("pieces of ten million", 1e7, Cluster(1000)),
    ("ten times the workers", 1e7, Cluster(10_000)),
    ("a tenth of the storage", 1e7, Cluster(10_000, storage=1e10)),
    ("ten times the storage", 1e7, Cluster(10_000, storage=1e12)),
    ("workers that live a day", 1e7, Cluster(10_000, lives=86400.0)),
    ("workers that live an hour", 1e7, Cluster(10_000, lives=3600.0)),
)
"""Simulated cases: a name, the vertices of a piece, and the cluster."""


def main(vertices: float = 2e6, across: int = 4):
    """Run the benchmark and the simulation, and print two tables."""
    with tempfile.TemporaryDirectory() as name, new_cluster(2) as cluster:
        folder = Path(name)
        files = save_city(folder, vertices, across)
        files_lit(cluster, files[:2], folder / "first", SCENE, seams="merge")
        seconds, memory = files_lit(cluster, files, folder / "lit", SCENE, seams="merge")
        with Client(cluster) as client:
            found = measured(files, folder / "one", client)
        size, in_memory = files[0].stat().st_size, 1024 * read_mesh(str(files[0])).actual_memory_size
    looking, border, lit = found.tasks
    rows = (
        ("total", f"{seconds:.1f} s"),
        ("memory of a worker beyond its libraries", f"{memory / 1e6:.0f} MB"),
        ("the same, in pieces", f"{memory / in_memory:.1f}"),
        ("pieces that are read for a piece's shadows", f"{found.blockers:.1f}"),
        ("outline of a piece", f"{looking.seconds:.3f} s"),
        ("its border and box", f"{border.seconds:.3f} s"),
        ("its normals, shadows, colours, file", f"{lit.seconds:.3f} s"),
        ("bytes moved for these, in sizes of its file", f"{lit.bytes / size:.1f}"),
        ("scheduler and client per task", f"{1e3 * found.per_message:.2f} ms"),
        ("their memory per task", f"{found.held / 1e3:.1f} kB"),
        (f"client, neighbours of one of {OUTLINES:,} pieces", f"{1e3 * found.among:.2f} ms"),
    )
    show(f"{len(files)} pieces of {found.vertices:,} vertices, two workers, a low sun", ("what", "measured"), rows)
    headings = "", "vertices of a piece", "workers", "GB/s", "hours", "workers", "scheduler", "storage", "deaths"
    simulated = (simulated_row(found, *case) for case in CASES)
    show("10¹² vertices: simulated, with utilisation", (*headings, "repeated", "scheduler holds"), simulated)


def simulated_row(found, name, vertices, cluster):
    pieces = round(ALL / vertices)
    tasks = tasks_of(found, vertices, pieces)
    run = simulate(tasks, pieces, replace(cluster, per_message=found.per_message))
    given = f"{vertices:.0e}", f"{cluster.workers:,}", f"{cluster.storage / 1e9:.0f}"
    shares = (f"{100 * run.busy[each]:.0f} %" for each in ("workers", "scheduler", "storage"))
    holds = pieces * sum(task.messages for task in tasks) * found.held
    lost = f"{run.deaths}", f"{100 * run.redone:.2f} %"
    return name, *given, f"{run.seconds / 3600:.1f}", *shares, *lost, f"{holds / 1e9:.1f} GB"


if __name__ == "__main__":
    cyclopts.run(main)
