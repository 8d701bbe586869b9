"""Lighting of files by one and by two worker processes: `python bench_many_files.py [files] [points of each]`.

Times include reading, normals, light and writing, but not the start of the processes. One and two workers take turns on
the same files, and the least time of each counts. Further results are a worker's memory in pieces, beyond its
libraries, and the overhead per piece, from many small pieces: bytes sent to a worker and back, and the time of the
scheduler and the client, which limits the number of workers.
"""

import pickle
import tempfile
import time
from pathlib import Path

import cyclopts
import psutil
from common import files_lit, grid, measured_scene, new_cluster, show
from distributed import Client

import pvphong as ph
from pvphong.batch.pieces import Piece
from pvphong.batch.seams import border_of
from pvphong.batch.shading import ShadingJob
from pvphong.batch.worker import Result
from pvphong.meshes.files import read_mesh

TURNS, SMALL = 3, 500
FASTER_WANTED, MEMORY_ALLOWED = 1.6, 3.0


def save_sheets(folder, files, points):
    """Save sheets with about `points` points each, without normals, and return their paths."""
    folder.mkdir()
    for number in range(files):
        sheet = grid(max(int(points**0.5) - 1, 1), center=(0, 0, number))
        sheet.clear_data()
        sheet.save(folder / f"{number:03}.vtp")
    return sorted(folder.glob("*.vtp"))


def load_all(path):
    """Load all code in a worker."""
    read_mesh(path).phong.shade(*measured_scene(), backend="numba").save(Path(tempfile.mkdtemp()) / "lit.vtp")


def main(files: int = 20, points: float = 1e6):
    """Run the benchmark and print a table."""
    with tempfile.TemporaryDirectory() as name, new_cluster(1) as one, new_cluster(2) as two:
        folder, least, memory = Path(name), {}, {}
        paths = save_sheets(folder / "sheets", files, points)
        piece = read_mesh(str(paths[0]))
        size = 1024 * piece.actual_memory_size + 3 * 4 * piece.n_points
        for cluster in (one, two):
            with Client(cluster) as client:
                client.run(load_all, str(paths[0]))
        for turn in range(TURNS):
            for workers, cluster in ((1, one), (2, two)):
                seconds, taken = files_lit(cluster, paths, folder / f"lit-{turn}-{workers}", *measured_scene())
                least[workers] = min(seconds, least.get(workers, seconds))
                memory[workers] = max(taken / size, memory.get(workers, 0))
        rows = [
            (f"{files} files of {piece.n_points} points, 1 worker", f"{least[1]:.2f} s", ""),
            ("the same, 2 workers", f"{least[2]:.2f} s", f"{least[1] / least[2]:.2f} x, wanted {FASTER_WANTED}"),
            ("memory of a worker", f"{max(memory.values()):.2f} pieces", f"allowed {MEMORY_ALLOWED:.0f}"),
            *overhead(two, folder, piece),
        ]
    show("", ("what", "measured", ""), rows, texts=3)


def overhead(cluster, folder, piece):
    """Return table rows with the overhead per piece."""
    save_sheets(folder / "small", SMALL, 4)
    pattern, out = str(folder / "small" / "*.vtp"), folder / "lit-small"
    ph.shade_files(pattern, out, *measured_scene(), client=None, workers=2)
    with Client(cluster) as client:
        before, begun = psutil.Process().cpu_times().user, time.perf_counter()
        batch = ph.shade_files(pattern, out, *measured_scene(), client=client)
        wall, busy = time.perf_counter() - begun, psutil.Process().cpu_times().user - before
    assert len(batch.skipped) == SMALL
    scene, material = measured_scene()
    job = ShadingJob(None, "phong", "of three lights", "lz4", scene, {"default": material}, {})
    sent = len(pickle.dumps((Piece(Path(pattern), Path(pattern)), job)))
    back = len(pickle.dumps(Result(True, ())))
    border = len(pickle.dumps(border_of(piece)))
    return [
        ("a finished piece, checked again", f"{1e3 * wall / SMALL:.2f} ms", "2 workers"),
        ("scheduler and client for a piece", f"{1e3 * busy / SMALL:.2f} ms", "of one core"),
        ("a piece and its rig as sent, and the result", f"{sent} + {back} bytes", "without Dask's own"),
        ("its border, if seams are merged", f"{border / 1024:.0f} KiB", "from worker to worker"),
    ]


if __name__ == "__main__":
    cyclopts.run(main)
