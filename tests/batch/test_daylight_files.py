"""Daylight of a city in files equals, to the bit, that of one mesh; files that change are computed again."""

import os
import signal
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from batch.cutting import bare, houses, save_pieces, series, surfaces
from ray_backends import BACKENDS

import pvphong as ph
from pvphong.batch import daylight
from pvphong.rays import casting

pandas = pytest.importorskip("pandas")
pytest.importorskip("pvlib")
distributed = pytest.importorskip("distributed")

MUNICH = ph.Place(48.14, 11.58)
DAY = pandas.date_range("2026-06-21T00:30", periods=24, freq="h", tz="Europe/Berlin")
YEAR = pandas.date_range("2026-01-01T00:30", "2026-12-31T23:30", freq="h", tz="Etc/GMT-1")
RESULTS = "sun_hours", "direct", "diffuse", "reflected", "total"


def as_in_one_mesh(pieces, times, place=MUNICH, weather=None, folder="sun/whole", **options):
    """Assert that the files equal, bit for bit, the daylight of one mesh; return that mesh."""
    whole = pieces[0].append_polydata(*pieces[1:]).phong.daylight(times, place, weather, **options).mesh
    lit = [pv.read(f"{folder}/part_{number}.vtp") for number in range(len(pieces))]
    for name in RESULTS:
        np.testing.assert_array_equal(np.concatenate([piece[name] for piece in lit]), whole[name])
    return whole


@pytest.mark.parametrize("backend", BACKENDS)
def test_pieces_equal_one_mesh_to_the_bit(backend, client, monkeypatch):
    monkeypatch.setattr(casting, "ray_backend", lambda: (BACKENDS[backend], ""))
    pieces = surfaces(houses(2, 4) if backend == "vtk" else houses(4), 2)
    index = save_pieces(pieces, "in", ".pvtp")
    times = DAY[12:15] if backend == "vtk" else DAY
    weather, rays = (np.linspace(300, 900, len(times)), np.full(len(times), 90.0)), {"samples": 2, "sun_bin": 0}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", casting.SlowRaysWarning)
        batch = ph.daylight_files(index, "sun", times, MUNICH, weather, client=client, **rays)
        assert (len(batch.done), batch.failed) == (len(pieces) + 1, {})
        whole = as_in_one_mesh(pieces, times, weather=weather, **rays)
        alone = np.concatenate(
            [piece.phong.daylight(times, MUNICH, weather, **rays).mesh["diffuse"] for piece in pieces]
        )
    assert (alone > whole["diffuse"]).mean() > 0.2, "pieces do not hide the sky from each other"
    assert ph.daylight_files(index, "sun", times, MUNICH, weather, client=client, **rays).done == ()


def test_a_wall_in_another_file_hides_the_sun(client):
    """At the distance 1 east of an endless wall of height 1, the sun is hidden where it is less than 45° above west."""
    os.mkdir("in")
    pv.Plane(center=(-1, 0, 0.5), direction=(1, 0, 0), i_size=1, j_size=400).save("in/wall.vtp")
    pv.Plane(i_size=1e-3, j_size=1e-3).save("in/floor.vtp")
    assert not ph.daylight_files("in/*.vtp", "sun", YEAR, MUNICH, client=client, sun_bin=0, samples=2).failed
    sun = ph.sun_position(YEAR, MUNICH)
    x, _, z = sun.direction.T
    hours = np.count_nonzero((sun.altitude > 0.0) & (z > -x))
    assert hours < 0.8 * np.count_nonzero(sun.altitude > 0.0)
    np.testing.assert_allclose(pv.read("sun/floor.vtp")["sun_hours"], hours, atol=1.0)  # within 0.001 of the edge


def test_what_changes_a_result_computes_it_again(client):
    pieces = surfaces(houses(3), 2)
    save_pieces(pieces, "in", ".pvtp")
    paths, day = sorted(Path("in/whole").glob("*.vtp")), DAY[10:14]
    gloomy = [0] * 4, [100] * 4

    def done(given=paths, place=MUNICH, weather=None, **options):
        return len(ph.daylight_files(given, "sun", day, place, weather, client=client, **options).done)

    assert [done(), done()] == [4, 0]
    assert done(weather=gloomy) == done(albedo=0.3) == done(place=ph.Place(48.14, 11.6)) == done(samples=5) == 4
    assert [done(samples=5, memory=1e9), done(samples=5, seams="merge")] == [0, 4]
    assert done(paths[:3]) == 3  # a smaller city
    moved = pieces[3].translate((0, 0, 9))
    moved.save(paths[3])
    assert [done(), done()] == [4, 0]
    as_in_one_mesh([*pieces[:3], moved], day, folder="sun")


def test_seams_merge_for_an_index_file_and_not_for_separate_files(client):
    ball = bare(pv.Sphere(radius=5, theta_resolution=24, phi_resolution=16))
    pieces = surfaces(ball, 2)
    index = save_pieces(pieces, "in", ".pvtp")
    whole = ball.phong.daylight(DAY, MUNICH).mesh
    rows = [ball.find_closest_point(point) for piece in pieces for point in piece.points]
    far = []
    for given, folder in ((index, "merged/whole"), (sorted(Path("in/whole").iterdir()), "apart")):
        batch = ph.daylight_files(given, folder.split("/")[0], DAY, MUNICH, client=client)
        assert not batch.failed
        lit = np.concatenate([pv.read(f"{folder}/part_{k}.vtp")["direct"] for k in range(len(pieces))])
        far.append(np.abs(lit - whole["direct"][rows]).max())
        assert not [name for name in pv.read(f"{folder}/part_0.vtp").array_names if "pvphong" in name]
    assert far[0] < 1e-3 * whole["direct"].max() < far[1]


def test_time_steps_do_not_shadow_each_other(client):
    os.mkdir("in")
    floor = pv.Plane(i_resolution=4, j_resolution=4)
    floor.save("in/now.vtp")
    floor.translate((0, 0, 1)).save("in/then.vtp")
    Path("in/steps.pvd").write_text(series(["now.vtp", "then.vtp"], [0, 1]))
    assert not ph.daylight_files("in/steps.pvd", "sun", DAY, MUNICH, client=client).failed
    alone = floor.phong.daylight(DAY, MUNICH)
    for name in ("now", "then"):
        np.testing.assert_array_equal(pv.read(f"sun/steps/{name}.vtp")["total"], alone.total)


def test_a_file_in_two_time_steps_is_refused(client):
    os.mkdir("in")
    pv.Plane().save("in/ground.vtp")
    Path("in/steps.pvd").write_text(series(["ground.vtp", "ground.vtp"], [0, 1]))
    with pytest.raises(ValueError, match=r"^paths must be in one time step only; got .*ground.vtp. Copy the file"):
        ph.daylight_files("in/steps.pvd", "sun", DAY, MUNICH, client=client)


def test_a_file_whose_shadow_was_missing_is_computed_again(client, monkeypatch):
    os.mkdir("in")
    pv.Plane(i_size=2, j_size=2).save("in/ground.vtp")
    pv.Plane(center=(0, 0, 1), i_size=200, j_size=200).save("in/roof.vtp")
    read = daylight.faces_in

    def fails(piece):
        if piece.input.stem == "roof":
            raise OSError("a disk that is gone for a moment")
        return read(piece)

    with monkeypatch.context() as patched:
        patched.setattr(daylight, "faces_in", fails)
        batch = ph.daylight_files("in/*.vtp", "sun", DAY, MUNICH, client=client)
    assert [path.name for path in batch.failed] == ["roof.vtp"]
    assert pv.read("sun/ground.vtp")["sun_hours"].min() > 10
    assert len(ph.daylight_files("in/*.vtp", "sun", DAY, MUNICH, client=client).done) == 2
    assert pv.read("sun/ground.vtp")["sun_hours"].max() == 0


def test_files_that_cannot_be_read_and_empty_ones(client):
    pieces = surfaces(houses(3), 2)
    save_pieces(pieces, "in", ".pvtp")
    pv.PolyData().save("in/whole/part_4.vtp")
    Path("in/whole/part_2.vtp").write_text("garbage")
    batch = ph.daylight_files("in/whole/*.vtp", "sun", DAY, MUNICH, client=client)
    assert [path.name for path in batch.failed] == ["part_2.vtp"]
    assert pv.read("sun/part_4.vtp").n_points == 0
    whole = pieces[0].append_polydata(pieces[1], pieces[3]).phong.daylight(DAY, MUNICH)
    lit = [pv.read(f"sun/part_{k}.vtp")["total"] for k in (0, 1, 3)]
    np.testing.assert_array_equal(np.concatenate(lit), whole.total)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"paths": "none.vtp"}, None),
        ({"paths": "*.nothing"}, "paths must be a pattern that matches a file"),
        (
            {"bounces": 1},
            "bounces must be 0 for files, because light does not bounce between them; got 1. Join the files",
        ),
        ({"place": (48, 11)}, "place must be a Place"),
        ({"weather": ([1], [2])}, "weather: direct_normal must be of shape"),
        ({"patches": 146}, "patches must be 145 or 577"),
        ({"feature_angle": 200}, "feature_angle must be"),
        ({"memory": -1}, "memory must be"),
        ({"seams": "sew"}, "seams must be"),
        ({"compress": "zip"}, "compress must be"),
        ({"workers": 1}, "workers must be omitted with a client"),
    ],
)
def test_what_is_refused(given, message, client):
    pv.Sphere().save("ball.vtp")
    options = {"paths": "ball.vtp", "out": "sun", "times": DAY, "place": MUNICH, "client": client} | given
    if message is None:
        assert [*ph.daylight_files(**options).failed] == [Path("none.vtp")]
        return
    with pytest.raises(ValueError, match=f"^{message}"):
        ph.daylight_files(**options)
    assert not Path("sun").exists()


def test_too_many_coefficients_fail_in_one_line(client):
    pv.Sphere().save("ball.vtp")
    batch = ph.daylight_files("ball.vtp", "sun", DAY, MUNICH, client=client, memory=1e4)
    assert "memory must be at least" in batch.failed[Path("ball.vtp")]
    assert not Path("sun/ball.vtp").exists()


def test_a_city_in_degrees_is_noticed(client):
    os.mkdir("in")
    for west in (11.0, 11.5):
        pv.Plane(center=(west + 0.25, 48.2, 0), i_size=0.5, j_size=1).save(f"in/{west}.vtp")
    with pytest.warns(UserWarning, match="look like degrees of longitude and latitude"):
        ph.daylight_files("in/*.vtp", "sun", DAY, MUNICH, client=client)


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="nothing is killed there")
def test_a_hundred_pieces_on_two_workers_of_which_one_is_killed():
    """A year on a hundred pieces; a worker dies after the first files. The files equal one mesh, to the bit."""
    pieces = surfaces(houses(40), 10)
    index = save_pieces(pieces, "in", ".pvtp")
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        victim = next(iter(client.run(os.getpid).values()))

        def kill_after_the_first(victim=victim):
            import threading
            import time

            def wait():
                while not list(Path("sun/whole").glob(".*.json")):
                    time.sleep(0.01)
                os.kill(victim, signal.SIGKILL)

            threading.Thread(target=wait, daemon=True).start()

        kill_after_the_first()
        batch = ph.daylight_files(index, "sun", YEAR, MUNICH, client=client)
    assert (len(batch.done), batch.failed) == (101, {})
    as_in_one_mesh(pieces, YEAR)
    assert not list(Path("sun").rglob(".pvphong-*"))
