"""`pvphong daylight`: files and pictures of sun and sky over a year or a day."""

from __future__ import annotations

import numpy as np
import pytest
import pyvista as pv
from PIL import Image

import pvphong as ph
from pvphong.cli.app import main

pandas = pytest.importorskip("pandas")
pytest.importorskip("pvlib")

MUNICH = ph.Place(48.14, 11.58)


@pytest.fixture
def town(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ground = pv.Plane(i_size=60, j_size=60, i_resolution=12, j_resolution=12).triangulate()
    house = pv.Box((-8, 8, -6, 6, 0, 12)).triangulate()
    ground.append_polydata(house).save("town.vtp")
    pv.MultiBlock({"ground": ground, "house": house}).save("town.vtm")
    house.save("house.vtp")
    ground.save("ground.vtp")
    return tmp_path


def run(words):
    return main(words.split())


@pytest.mark.usefixtures("town")
def test_a_day_is_written_and_drawn(capsys):
    command = "daylight town.vtp --place 48.14,11.58 --day 2026-06-21 -o sun.vtp --plot sun.png --size 320 240"
    assert run(command) == 0
    assert capsys.readouterr().out.split() == ["sun.vtp", "sun.png"]
    times = pandas.date_range("2026-06-21T00:05", periods=144, freq="10min", tz="Etc/GMT-1")
    expected = pv.read("town.vtp").phong.daylight(times, MUNICH, feature_angle="auto").mesh
    found = pv.read("sun.vtp")
    for name in ("sun_hours", "direct", "diffuse", "reflected", "total"):
        np.testing.assert_allclose(found[name], expected[name], rtol=1e-12, atol=1e-9)
    assert 15.0 < found["sun_hours"].max() < 17.0
    picture = np.asarray(Image.open("sun.png"))
    assert picture.shape == (240, 320, 3)
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 50


@pytest.mark.usefixtures("town")
def test_a_year_of_blocks_and_of_occluders():
    assert run("daylight town.vtm --place=-33.9,18.4 -o blocks.vtp") == 0
    assert run("daylight ground.vtp --place=-33.9,18.4 --occluder house.vtp -o ground.vtk") == 0
    joined, ground = pv.read("blocks.vtp"), pv.read("ground.vtk")
    assert joined.n_points > ground.n_points
    np.testing.assert_allclose(joined["sun_hours"][: ground.n_points], ground["sun_hours"])
    assert 4300.0 < ground["sun_hours"].max() < 4500.0
    # the house's shadow is in the south
    x, y, _ = ground.points.T
    north, south = (ground["direct"][(np.abs(x) < 5) & (side * y > 8) & (side * y < 16)] for side in (1, -1))
    assert north.mean() > 1.2 * south.mean()


@pytest.mark.usefixtures("town")
def test_y_up():
    pv.read("town.vtp").rotate_x(-90).save("lying.vtp")
    assert run("daylight lying.vtp --place 48.14,11.58 --day 2026-06-21 --up 0,1,0 -o lying-sun.vtp") == 0
    assert run("daylight town.vtp --place 48.14,11.58 --day 2026-06-21 -o town-sun.vtp") == 0
    np.testing.assert_allclose(pv.read("lying-sun.vtp")["direct"], pv.read("town-sun.vtp")["direct"], rtol=2e-3, atol=5)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--place 48.14,11.58", "--output must be given, or --plot"),
        ("--place 95,11 -o a.vtp", "--place must be a finite number >= -90 and <= 90; got 95"),
        ("--place Munich -o a.vtp", "--place must be 2 or 3 numbers separated by commas; got Munich"),
        ("--place 48,11 -o a.obj", "--output must be a file for a mesh with daylight (.vtp, .vtk, .vtkhdf); got a.obj"),
        ("--place 48,11 --plot a.jpg", "--plot must be a file for a picture (.png); got a.jpg"),
        ("--place 48,11 -o a.vtp --day noon", "--day must be a date such as 2026-06-21; got noon"),
        ("--place 48,11 -o a.vtp --day 2026-06-21 --year 2020", "--year must be omitted with --day"),
        ("--place 48,11 -o a.vtp --year 1900", "--year must be a finite number >= 1950 and <= 2200; got 1900"),
        ("--place 48,11 -o a.vtp --show direct", "--show must be used with --plot; got direct"),
        ("--place 48,11 -o a.vtp --epw none.epw", "--epw must be an EPW file that can be read; got none.epw"),
        ("--place 48,11 -o a.vtp --albedo 2", "--albedo must be a finite number >= 0 and <= 1; got 2"),
        ("--place 48,11 -o a.vtp --north 0,0,1", "--north must be not parallel to up"),
        ("--place 48,11 -o a.vtp --workers 2", "--workers must be omitted for a single mesh"),
        ("house.vtp --place 48,11", "--output must be a folder for many files; got no output. -o sun/ makes"),
        ("house.vtp --place 48,11 -o a.vtp", "--output must be a folder for many files; got a.vtp. -o a.vtp/ makes"),
        ("house.vtp --place 48,11 -o a --plot a.png", "--plot must be omitted for many files; got a.png"),
        ("house.vtp --place 48,11 -o a --occluder house.vtp", "--occluder must be omitted for many files"),
        ("house.vtp --place 48,11 -o a --bounces 1", "--bounces must be 0 for files, because light does not bounce"),
        ("house.vtp --place 48,11 -o a --workers 1 --scheduler b", "--workers must be omitted with --scheduler"),
    ],
)
def test_what_is_refused(town, words, message, capsys):
    assert run(f"daylight town.vtp {words}") == 2
    said = capsys.readouterr().err
    assert said.startswith(f"error: {message}"), said
    assert said.count("\n") == 1
    assert not (town / "a.vtp").exists()
    assert not (town / "a").exists()


def test_a_city_in_many_files(town, monkeypatch, capsys):
    from distributed import Client

    from pvphong.cli import daylight as command

    with Client(processes=False, n_workers=1, threads_per_worker=2, dashboard_address=None) as client:
        files = command.daylight_files
        monkeypatch.setattr(
            command, "daylight_files", lambda *given, **options: files(*given, **options | {"client": client})
        )
        words = "daylight ground.vtp hou*.vtp --place 48.14,11.58 --day 2026-06-21 -o sun"
        for counts in ("2 done, 0 skipped", "0 done, 2 skipped"):
            assert run(words) == 0
            assert counts in capsys.readouterr().out
        (town / "house.vtp").write_text("garbage")
        assert run(words) == 1
        assert "house.vtp: mesh must be" in capsys.readouterr().err
    # the ground alone now, as far as it can be read
    assert run("daylight ground.vtp --place 48.14,11.58 --day 2026-06-21 -o alone.vtp") == 0
    for name in ("sun_hours", "total"):
        np.testing.assert_array_equal(pv.read("sun/ground.vtp")[name], pv.read("alone.vtp")[name])
