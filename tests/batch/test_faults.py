"""Processes killed during a run: all files are complete, none is lost, and the same call continues."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
import ray_backends
from batch.cutting import SCENE, as_in_one_piece, bare, houses, save_pieces, surfaces

import pvphong as ph
from pvphong.batch import worker

distributed = pytest.importorskip("distributed")
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="nothing is killed there")

COUNT = 12
LAMP = ph.SphereLight(position=(3, 2, 4), radius=0.7)


@pytest.fixture
def files():
    os.mkdir("in")
    ball = bare(pv.Sphere(theta_resolution=100, phi_resolution=100))
    for number in range(COUNT):
        ball.translate((number, 0, 0)).save(f"in/{number:02}.vtp")
    return sorted(Path("in").iterdir())


@pytest.fixture
def cluster(tmp_path):
    """Start a scheduler and two workers in separate processes; yield the scheduler's process and a client."""

    def begin(command, *options):
        words = [sys.executable, "-m", f"distributed.cli.dask_{command}", *options, "--no-dashboard"]
        return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    file = str(tmp_path / "scheduler.json")
    scheduler = begin("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", file)
    workers = begin("worker", "--scheduler-file", file, "--nworkers", "2", "--nthreads", "1")
    try:
        while not Path(file).exists():
            time.sleep(0.05)
        with distributed.Client(scheduler_file=file, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=60)
            yield scheduler, client
    finally:
        for process in (workers, scheduler):
            process.terminate()
            process.wait()


def killing(process):
    """Start a thread that kills a process once the first lit file exists."""

    def wait_and_kill():
        while not list(Path("lit").glob(".*.json")):
            time.sleep(0.002)
        os.kill(process, signal.SIGKILL)

    thread = threading.Thread(target=wait_and_kill)
    thread.start()
    return thread


def all_whole():
    """Return the existing lit files. Assert that each is correct and that there are no other files."""
    lit = sorted(Path("lit").glob("*.vtp"))
    for path in lit:
        found, mesh = pv.read(path), pv.read(f"in/{path.name}")
        np.testing.assert_array_equal(found.points, mesh.points)
        np.testing.assert_array_equal(found["phong"], mesh.phong.shade(SCENE)["phong"])
    assert not [name for name in os.listdir("lit") if name.startswith(".pvphong")]
    return lit


def test_a_worker_that_is_killed_loses_nothing(files, cluster):
    _, client = cluster
    victim = next(iter(client.run(os.getpid).values()))
    thread = killing(victim)
    batch = ph.shade_files(files, "lit", SCENE, client=client)
    thread.join()
    assert (batch.done, batch.skipped, batch.failed) == (tuple(files), (), {})
    assert len(all_whole()) == COUNT
    runs = {json.loads(worker.receipt_path(Path(f"lit/{path.name}")).read_text())["run"] for path in files}
    assert len(runs) == 1


def test_a_piece_that_is_lost_in_the_middle_of_a_cast_is_done_again(cluster):
    _, client = cluster
    assert ray_backends.BACKENDS  # compile ray casting first, so that all processes use the same code
    pieces, scene = surfaces(houses(4), 2), ph.Scene([LAMP], SCENE.viewer, ph.LightModel(shadows=True))
    index = save_pieces(pieces, "in", ".pvtp")

    def dies_while_it_casts():
        from pvphong.rays import visibility

        look = visibility.look

        def dying(count, cast, *more, **options):
            def last(vertices, begin, end):
                cast(vertices, begin, end)
                os.kill(os.getpid(), signal.SIGKILL)

            return look(count, last, *more, **options)

        visibility.look = dying
        return os.getpid()

    victim = next(iter(client.scheduler_info()["workers"]))
    (process,) = client.run(dies_while_it_casts, workers=[victim]).values()
    batch = ph.shade_files(index, "lit", scene, client=client, components=True, backend="numpy")
    assert process not in client.run(os.getpid).values()
    assert (len(batch.done), batch.failed) == (len(pieces) + 1, {})
    as_in_one_piece(pieces, scene)
    assert not list(Path("lit").rglob(".pvphong-*"))


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # Dask's, at the lost connection
def test_when_the_scheduler_is_killed_what_is_finished_stays_and_the_next_run_goes_on(files, cluster, client):
    scheduler, there = cluster
    thread = killing(scheduler.pid)
    began = time.monotonic()
    batch = ph.shade_files(files, "lit", SCENE, client=there)
    thread.join()
    assert time.monotonic() - began < 30
    assert batch.failed
    assert all(why.startswith("the connection to the scheduler was lost") for why in batch.failed.values())
    assert len(batch.done) + len(batch.failed) == COUNT
    again = ph.shade_files(files, "lit", SCENE, client=client)
    assert not again.failed
    assert set(batch.done) <= set(again.skipped)
    assert len(again.done) + len(again.skipped) == len(all_whole()) == COUNT
