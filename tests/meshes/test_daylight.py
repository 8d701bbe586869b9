"""Daylight over many times: closed forms, pvlib, Radiance, other weathers, files and refusals."""

from __future__ import annotations

import math
import threading
import warnings

import numpy as np
import pytest
import pyvista as pv
from ray_backends import BACKENDS

import pvphong as ph
from pvphong.base import text, threads
from pvphong.meshes import daylight as module
from pvphong.optics.area.patches import Patches
from pvphong.rays import casting

pandas = pytest.importorskip("pandas")
pvlib = pytest.importorskip("pvlib")

MUNICH = ph.Place(48.14, 11.58, altitude=520)
DAY = pandas.date_range("2026-06-21T00:30", periods=24, freq="h", tz="Europe/Berlin")
YEAR = pandas.date_range("2026-01-01T00:30", "2026-12-31T23:30", freq="h", tz="Etc/GMT-1")


def points(normals, at=(0.0, 0.0, 0.0)):
    """Return points with normals and without faces."""
    normals = np.atleast_2d(np.asarray(normals, float))
    cloud = pv.PolyData(np.tile(np.asarray(at, float), (len(normals), 1)))
    cloud.point_data.active_normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return cloud


def uniform(cloud, occluders, **options):
    """Return the irradiance under a sky of radiance 1/π, and its standard error: for each, one moment of an hour.

    With the ground as bright as the sky, Perez' overcast sky and the ground are replaced by a uniform sphere.
    """
    light = cloud.phong.daylight("2026-06-21T12:00Z", MUNICH, occluders=occluders, **options)
    study = light._study
    sources = study.sources(light._weather)
    evenly = np.full(len(study.patches), 1.0 / math.pi)
    of_even = module.received(
        study.cast.coefficients, study.cast.normals, study.place.axes, study.patches,
        sources._replace(sky=evenly, ground=0.0),
    )  # fmt: skip
    return of_even.diffuse, of_even.error


# --- closed forms of the visible sky

LONG = 200.0  # longer walls would have triangles that rays resolve too coarsely


def wall(x, height, towards):
    """Return an endless wall along y at x, whose front faces along ±x; rays hit both sides."""
    return pv.Plane(center=(x, 0, height / 2), direction=(towards, 0, 0), i_size=height, j_size=2 * LONG)


@pytest.mark.parametrize("finer", [145, 577])
@pytest.mark.parametrize("height", [0.3, 1.0, 3.0])
def test_beside_an_endless_wall(height, finer):
    """A point at the distance 1 from a wall sees (1 + cos α) / 2 of a uniform sky, α the wall's elevation."""
    seen, error = uniform(points((0, 0, 1)), [wall(-1.0, height, 1)], patches=finer, samples=8)
    expected = 0.5 * (1.0 + 1.0 / math.sqrt(1.0 + height * height))
    assert 0.0 < error[0] < 0.03
    assert abs(seen[0] - expected) < 3.0 * error[0]


@pytest.mark.parametrize("height", [0.5, 1.0, 2.0])
def test_in_an_endless_canyon(height):
    """In the middle of a canyon of the width 2, the visible part is cos α."""
    walls = [wall(-1.0, height, 1), wall(1.0, height, -1)]
    seen, error = uniform(points((0, 0, 1)), walls)
    expected = 1.0 / math.sqrt(1.0 + height * height)
    assert abs(seen[0] - expected) < 3.0 * error[0] < 0.06


def test_in_a_corner():
    """Near the corner of two perpendicular, very high walls, a quarter of the sky is left."""
    walls = [wall(-1e-3, 50.0, 1), pv.Box((-1.0, LONG, -0.01, -1e-3, 0, 50.0))]
    seen, error = uniform(points((0, 0, 1)), walls)
    assert abs(seen[0] - 0.25) < 3.0 * error[0] < 0.06


def test_the_error_falls_as_it_says():
    """Against many rays, at points in a street: the claim is not too small, and at most twice too large."""
    walls = [wall(-1.0, 1.5, 1), wall(1.0, 0.7, -1), pv.Box((-0.4, -0.2, 1.0, 1.4, 0.0, 1.1))]
    cloud = pv.PolyData(np.random.default_rng(7).uniform((-0.9, -1, 0), (0.9, 1, 0), (200, 3)))
    cloud.point_data.active_normals = np.tile((0.0, 0.0, 1.0), (200, 1))
    exact, _ = uniform(cloud, walls, samples=64)
    for samples in (2, 4, 8):
        seen, error = uniform(cloud, walls, samples=samples)
        off = np.sqrt(np.mean((seen - exact) ** 2))
        assert off < np.sqrt(np.mean(error**2)) < 3.0 * off


def test_a_wall_sees_half_of_the_sky_and_the_ground():
    light = points((1, 0, 0)).phong.daylight(DAY, MUNICH, (np.zeros(24), np.full(24, 100.0)), albedo=0.5)
    assert light.reflected[0] == pytest.approx(0.5 * 0.5 * 2400.0, rel=1e-9)  # form factor ½, and the albedo
    assert light.standard_error[0] == 0.0


def test_the_ground_is_hidden_by_the_mesh():
    """A floor that reaches far hides the ground below a wall's point, and is black without bounces."""
    floor = pv.Plane(i_size=LONG, j_size=LONG)
    light = points((1, 0, 0), (0, 0, 0.1)).phong.daylight(DAY, MUNICH, occluders=[floor])
    assert light.reflected[0] < 0.01 * light.diffuse[0]
    assert light.diffuse[0] > 0.0


# --- patches


@pytest.mark.parametrize("finer", [1, 2])
def test_patches_cover_the_sky(finer):
    patches = Patches(finer)
    assert len(patches) == {1: 145, 2: 577}[finer]
    assert patches.areas.sum() == pytest.approx(2.0 * math.pi)
    np.testing.assert_allclose(patches.moments.sum(axis=0), (0.0, 0.0, math.pi), atol=1e-12)
    centers = patches.moments / np.linalg.norm(patches.moments, axis=1, keepdims=True)
    assert ((patches.points(9) * centers[:, None]).sum(axis=2) > math.cos(math.radians(9.0))).all()


def test_the_irradiance_by_all_patches_is_that_of_a_tilted_plane():
    """A plane with the tilt β sees (1 + cos β) / 2 of a uniform sky; patches that it cuts are approximated."""
    random = np.random.default_rng(2).normal(size=(500, 3))
    normals = random / np.linalg.norm(random, axis=1, keepdims=True)
    for finer in (1, 2):
        found = Patches(finer).seen_from(normals).sum(axis=1) / math.pi
        np.testing.assert_allclose(found, 0.5 * (1.0 + normals[:, 2]), atol=2e-4)


# --- pvlib


@pytest.fixture(scope="module")
def clear():
    where = pvlib.location.Location(MUNICH.latitude, MUNICH.longitude, altitude=MUNICH.altitude)
    with warnings.catch_warnings():  # pvlib calls deprecated functions of pandas
        warnings.simplefilter("ignore", DeprecationWarning)
        return where.get_clearsky(YEAR)


def test_an_open_horizontal_plane_gets_the_global_irradiance(clear):
    """GHI = DNI cos Z + DHI, summed over a year, by pvlib's zenith."""
    sun = pvlib.solarposition.get_solarposition(YEAR, MUNICH.latitude, MUNICH.longitude, altitude=MUNICH.altitude)
    direct = clear["dni"] * np.maximum(np.cos(np.radians(sun["apparent_zenith"])), 0.0)
    light = points((0, 0, 1)).phong.daylight(YEAR, MUNICH, clear)
    assert light.direct[0] == pytest.approx(direct.sum(), rel=1e-9)
    assert light.diffuse[0] == pytest.approx(clear["dhi"].sum(), rel=1e-9)
    assert light.total[0] == pytest.approx((direct + clear["dhi"]).sum(), rel=1e-9)
    assert light.sun_hours[0] == (sun["apparent_elevation"] > 0.0).sum()
    assert light.standard_error[0] == 0.0
    assert points((0, 0, 1)).phong.daylight(YEAR, MUNICH).total[0] == pytest.approx(light.total[0], rel=1e-12)


PLANES = [(tilt, azimuth) for tilt in (20.0, 35.0, 60.0, 90.0) for azimuth in (90.0, 180.0, 225.0)]


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_tilted_planes_agree_with_perez_transposition(clear):
    """Perez' model of 1990 for tilted planes and his radiances of 1993 are different fits to measurements."""
    sun = pvlib.solarposition.get_solarposition(YEAR, MUNICH.latitude, MUNICH.longitude, altitude=MUNICH.altitude)
    extra = pvlib.irradiance.get_extra_radiation(YEAR)
    ghi = clear["dni"] * np.maximum(np.cos(np.radians(sun["apparent_zenith"])), 0.0) + clear["dhi"]
    mass = pvlib.atmosphere.get_relative_airmass(sun["apparent_zenith"])
    tilt, around = np.radians(np.array(PLANES).T)
    normals = np.stack([np.sin(tilt) * np.sin(around), np.sin(tilt) * np.cos(around), np.cos(tilt)], axis=1)
    light = points(normals).phong.daylight(YEAR, MUNICH, clear, albedo=0.25, sun_bin=0.0)
    for k, (slope, azimuth) in enumerate(PLANES):
        of_pvlib = pvlib.irradiance.get_total_irradiance(
            slope, azimuth, sun["apparent_zenith"], sun["azimuth"], clear["dni"], ghi, clear["dhi"],
            dni_extra=extra, model="perez", albedo=0.25, airmass=mass,
        )  # fmt: skip
        assert light.direct[k] == pytest.approx(of_pvlib["poa_direct"].sum(), rel=1e-6)
        assert light.reflected[k] == pytest.approx(of_pvlib["poa_ground_diffuse"].sum(), rel=1e-9)
        assert light.total[k] == pytest.approx(of_pvlib["poa_global"].sum(), rel=0.03), (slope, azimuth)


# --- the sun


def test_sun_hours_behind_a_wall():
    """A point north of a wall has sun while the sun is north of east and west, or above the wall."""
    times = pandas.date_range("2026-04-21T00:05", periods=144, freq="10min", tz="Etc/GMT-1")
    barrier = pv.Box((-LONG, LONG, -1.01, -1.0, 0, 2))
    light = points((0, 0, 1)).phong.daylight(times, MUNICH, sun_bin=0.0, occluders=[barrier])
    _, y, z = ph.sun_position(light.times, MUNICH).direction.T
    expected = ((z > 0.0) & ((y > 0.0) | (z > 2.0 * -y))).sum() / 6.0
    assert light.hours == pytest.approx(1.0 / 6.0)
    assert light.sun_hours[0] == pytest.approx(expected, abs=0.34)  # two moments that graze the edges
    assert 1.0 < expected < 13.0


def test_positions_are_within_the_bin():
    moments = module.Moments.of(YEAR, MUNICH, 1.0)
    day = moments.bins.of_times >= 0
    assert (day == moments.is_day).all()
    cosines = (moments.to_sun[day] * moments.bins.directions[moments.bins.of_times[day]]).sum(axis=1)
    assert cosines.min() >= math.cos(math.radians(1.0)) - 1e-12
    assert len(moments.bins.directions) < 700
    unbinned = module.Moments.of(YEAR, MUNICH, 0.0)
    assert len(unbinned.bins.directions) == unbinned.is_day.sum()


def test_polar_day_and_night():
    tromso = ph.Place(69.65, 18.96)
    day = points((0, 0, 1)).phong.daylight(pandas.date_range("2026-06-21", periods=24, freq="h", tz="UTC"), tromso)
    night = points((0, 0, 1)).phong.daylight(pandas.date_range("2026-12-21", periods=24, freq="h", tz="UTC"), tromso)
    assert day.sun_hours[0] == 24.0
    assert night.sun_hours[0] == night.total[0] == 0.0


def test_the_unit_of_length_and_the_orientation_do_not_matter():
    ground, box = pv.Plane(i_size=40, j_size=40, i_resolution=6, j_resolution=6), pv.Box((3, 9, -3, 3, 0, 8))
    metres = ground.phong.daylight(DAY, MUNICH, occluders=[box])
    millimetres = ground.scale(1000.0).phong.daylight(DAY, MUNICH, occluders=[box.scale(1000.0)])
    np.testing.assert_allclose(millimetres.direct, metres.direct, rtol=1e-5)
    np.testing.assert_allclose(millimetres.diffuse, metres.diffuse, rtol=0.02)
    turned = ph.Place(48.14, 11.58, altitude=520, up=(0, 1, 0), north=(0, 0, -1))
    lying = [each.rotate_x(-90.0) for each in (ground, box)]
    y_up = lying[0].phong.daylight(DAY, turned, occluders=[lying[1]])
    np.testing.assert_allclose(y_up.direct, metres.direct, rtol=1e-4)
    by_matrix = ground.phong.daylight(DAY, turned, occluders=[lying[1]], matrix=pv.Transform().rotate_x(-90.0))
    np.testing.assert_allclose(by_matrix.direct, y_up.direct, rtol=1e-4)


# --- weather

TOWN = [pv.Box((x, x + 6, y, y + 5, 0, h)) for x, y, h in ((-12, -8, 9), (3, -9, 6), (-4, 4, 12))]
GROUND = pv.Plane(i_size=40, j_size=40, i_resolution=12, j_resolution=12)
RESULTS = "sun_hours", "direct", "diffuse", "reflected", "total", "standard_error"


def test_another_weather_needs_no_rays(monkeypatch):
    weather = np.linspace(0.0, 600.0, 24), np.linspace(100.0, 0.0, 24)
    light = GROUND.phong.daylight(DAY, MUNICH, occluders=TOWN)
    assert light.total.any()
    monkeypatch.setattr(module.SkyTracer, "cast", None)
    other = light.with_weather(weather)
    cast = {name: getattr(other, name) for name in RESULTS}
    monkeypatch.undo()
    fresh = GROUND.phong.daylight(DAY, MUNICH, weather, occluders=TOWN)
    for name, values in cast.items():
        np.testing.assert_array_equal(values, getattr(fresh, name))
    assert (other.sun_hours == light.sun_hours).all()
    assert not np.array_equal(other.total, light.total)


def test_a_data_frame_is_weather():
    frame = pandas.DataFrame({"ghi": 1.0, "dni": np.arange(24.0), "dhi": 50.0}, index=DAY)
    one, other = (points((0, 0, 1)).phong.daylight(DAY, MUNICH, each) for each in (frame, (frame.dni, frame.dhi)))
    assert one.total[0] == other.total[0] > 1200.0


def test_a_data_frame_of_other_times_is_refused():
    frame = pandas.DataFrame({"dni": 1.0, "dhi": 50.0}, index=DAY + pandas.Timedelta("1h"))
    with pytest.raises(
        ValueError, match=r"weather: direct_normal must be given for the same times; .*reindex\(times\)"
    ):
        points((0, 0, 1)).phong.daylight(DAY, MUNICH, frame)
    local = frame.set_index(DAY.tz_localize(None))
    in_utc = frame.set_index(DAY.tz_convert("UTC"))
    one, other = (points((0, 0, 1)).phong.daylight(DAY, MUNICH, each).total[0] for each in (local, in_utc))
    assert one == other > 0.0


def write_epw(path, direct, diffuse, *, latitude=48.14, longitude=11.58, zone=1.0):
    """Write an EPW file of 8760 hours from mixed years, with two columns of irradiances."""
    hours = pandas.date_range("2001-01-01T00:30", periods=8760, freq="h")
    head = f"LOCATION,Munich,BY,DEU,TEST,108660,{latitude},{longitude},{zone},520.0"
    other = ["DESIGN CONDITIONS,0", "TYPICAL/EXTREME PERIODS,0", "GROUND TEMPERATURES,0", "HOLIDAYS,No,0,0,0"]
    lines = [head, *other, "COMMENTS 1,", "COMMENTS 2,", "DATA PERIODS,1,1,Data,Sunday,1/1,12/31"]
    for k, when in enumerate(hours):
        before = f"{1990 + when.month},{when.month},{when.day},{when.hour + 1},60,A7,5.0,1.0,80,96000,0,1400,300"
        rest = "0,0,0,0,180,2.0,5,5,20.0,77777,9,999999999,10,0.1,0,88,0.2,0.0,0.0"
        lines.append(f"{before},{direct[k] + diffuse[k]},{direct[k]},{diffuse[k]},{rest}")
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture(scope="module")
def epw(tmp_path_factory):
    hours = np.arange(8760)
    return write_epw(tmp_path_factory.mktemp("epw") / "munich.epw", 10 * (hours % 24), hours // 24)


def test_an_epw_file_gives_the_hour_that_contains_the_moment(epw):
    """The zone of the file is UTC+1: 10:30 in summer time in Berlin is in the hour from 9:00."""
    times = pandas.DatetimeIndex(["2026-06-21T10:30"]).tz_localize("Europe/Berlin")
    light = points((0, 0, 1)).phong.daylight(times, MUNICH, epw)
    height = ph.sun_position(times, MUNICH).direction[0, 2]
    assert light.direct[0] == pytest.approx(90.0 * height)
    assert light.diffuse[0] == pytest.approx(31 + 28 + 31 + 30 + 31 + 20)
    leap = points((0, 0, 1)).phong.daylight("2028-02-29T12:30+01:00", MUNICH, epw)
    assert leap.diffuse[0] == pytest.approx(31 + 27)  # as on the 28th


def test_weather_of_another_place_is_said(epw):
    with pytest.warns(
        UserWarning, match=r"munich.epw is the weather of Munich, \d\d\d km from the place at 52.5, 13.4"
    ):
        points((0, 0, 1)).phong.daylight(DAY, ph.Place(52.5, 13.4), epw)


def test_a_gap_in_an_epw_file_is_refused(tmp_path):
    direct = np.full(8760, 100.0)
    direct[24 * 171 + 9] = 9999.0
    path = write_epw(tmp_path / "gap.epw", direct, np.ones(8760))
    message = "weather: direct_normal must be finite numbers >= 0 in W/m²; got nan at 2026-06-21"
    with pytest.raises(ValueError, match=message):
        points((0, 0, 1)).phong.daylight(DAY, MUNICH, path)


def test_a_damaged_epw_file_is_refused(epw, tmp_path):
    lines = epw.read_text().splitlines()
    cut = {"short": "\n".join(lines[:4000]), "header": "\n".join(lines[8:]), "binary": "\x00\x01" * 100, "empty": ""}
    for name, content in cut.items():
        path = tmp_path / f"{name}.epw"
        path.write_text(content)
        with pytest.raises(ValueError, match="weather must be an EPW file"):
            points((0, 0, 1)).phong.daylight(YEAR, MUNICH, path)
    with pytest.raises(ValueError, match=r"weather must be an EPW file that can be read; got .*missing.epw"):
        points((0, 0, 1)).phong.daylight(DAY, MUNICH, tmp_path / "missing.epw")


@pytest.mark.parametrize(
    ("weather", "message"),
    [
        (([1.0] * 23, [1.0] * 24), r"weather: direct_normal must be of shape \(24,\), like the times"),
        (([1.0] * 24, [-1.0] * 24), "weather: diffuse_horizontal must be finite numbers >= 0 .* -1 at .* and 23 more"),
        (([1.0] * 24, [math.nan] + [1.0] * 23), "weather: diffuse_horizontal must be finite numbers .*interpolate"),
        ((["a"] * 24, [1.0] * 24), "weather: direct_normal must be an array of real numbers"),
        ({"dni": [1.0] * 24}, "weather must be the path .*; got a table without dhi"),
        (7, "weather must be the path of an EPW file, .*; got int"),
    ],
)
def test_weather_that_is_refused(weather, message):
    with pytest.raises(ValueError, match=message):
        points((0, 0, 1)).phong.daylight(DAY, MUNICH, weather)


# --- bounces, blocks, files


def test_bounced_light_is_the_mean_of_what_surfaces_reflect():
    courtyard = pv.Cube(x_length=4, y_length=4, z_length=4).triangulate().subdivide(3).flip_faces()
    courtyard = courtyard.remove_cells(courtyard.cell_centers().points[:, 2] > 1.99)  # open to the sky
    plain, once, twice = (
        courtyard.phong.daylight(DAY, MUNICH, feature_angle=30, albedo=0.6, bounces=bounces) for bounces in (0, 1, 2)
    )
    transport = courtyard.phong.transport(feature_angle=30)
    expected = plain.reflected + transport.gather(0.6 * plain.total[:, None])[:, 0]
    np.testing.assert_allclose(once.reflected, expected, rtol=1e-5)
    assert (once.reflected > plain.reflected).mean() > 0.9
    assert twice.reflected.sum() > once.reflected.sum()


def test_blocks_hide_each_other():
    blocks = pv.MultiBlock({"ground": GROUND, **{f"house {k}": each for k, each in enumerate(TOWN)}})
    found = blocks.phong.daylight(DAY, MUNICH)
    assert found.keys() == set(blocks.keys())
    alone = GROUND.phong.daylight(DAY, MUNICH, occluders=TOWN)
    np.testing.assert_array_equal(found["ground"].sun_hours, alone.sun_hours)
    with pytest.raises(ValueError, match="bounces must be 0 for blocks; got 1"):
        blocks.phong.daylight(DAY, MUNICH, bounces=1)


@pytest.mark.parametrize("bounces", [0, 1])
def test_a_file_keeps_everything(tmp_path, bounces):
    town = pv.MultiBlock([GROUND.triangulate(), *TOWN]).combine().extract_surface(algorithm="dataset_surface")
    light = town.phong.daylight(DAY, MUNICH, feature_angle=30, bounces=bounces)
    light.save(tmp_path / "town.npz")
    loaded = ph.Daylight.load(tmp_path / "town.npz")
    gloomy = np.zeros(24), np.full(24, 70.0)
    for before, after in ((light, loaded), (light.with_weather(gloomy), loaded.with_weather(gloomy))):
        for name in RESULTS:
            np.testing.assert_array_equal(getattr(after, name), getattr(before, name))
    assert loaded.mesh.n_cells == light.mesh.n_cells
    assert (loaded.times == light.times).all()
    assert loaded.expected_cost().rays == 0


def test_files_that_are_refused(tmp_path):
    light = points((0, 0, 1)).phong.daylight(DAY, MUNICH)
    light.save(tmp_path / "whole.npz")
    with np.load(tmp_path / "whole.npz") as file:
        arrays = dict(file.items())
    changes = {"sky": {"sky": arrays["sky"] - 1}, "format": {"format": np.array(["pvphong transport", "3", "", ""])}}
    for name, change in changes.items():
        np.savez(tmp_path / f"{name}.npz", **arrays | change)
        with pytest.raises(ValueError, match=r"path must be a file written by Daylight.save; got .*\. Recompute it"):
            ph.Daylight.load(tmp_path / f"{name}.npz")
    (tmp_path / "cut.npz").write_bytes((tmp_path / "whole.npz").read_bytes()[:500])
    for name in ("cut.npz", "missing.npz"):
        with pytest.raises(ValueError, match=r"path must be a file written by Daylight.save"):
            ph.Daylight.load(tmp_path / name)


@pytest.mark.parametrize("backend", BACKENDS)
def test_all_backends_agree(monkeypatch, backend):
    monkeypatch.setattr(casting, "ray_backend", lambda: (BACKENDS[backend], ""))
    few = pv.Plane(i_size=30, j_size=30, i_resolution=3, j_resolution=3)
    light = few.phong.daylight(DAY[8:12], MUNICH, occluders=TOWN)
    monkeypatch.undo()
    best = few.phong.daylight(DAY[8:12], MUNICH, occluders=TOWN)
    np.testing.assert_array_equal(light.sun_hours, best.sun_hours)
    np.testing.assert_allclose(light.diffuse, best.diffuse, rtol=0.01)  # rays that graze an edge


# --- cost, progress, refusals


def test_the_cost_is_told_first():
    light = GROUND.phong.daylight(DAY, MUNICH, occluders=TOWN)
    expected = light.expected_cost()
    assert "rays not cast yet" in repr(light)
    assert light.total.any()
    kept = light._study.cast.coefficients
    assert expected.rays == pytest.approx(kept.rays, rel=0.05)
    assert expected.memory == sum(getattr(kept, name).nbytes for name in ("sky", "ground", "ground_error", "sun"))


def test_progress_and_interruption():
    heard, stop = [], threading.Event()
    light = GROUND.phong.daylight(DAY, MUNICH, occluders=TOWN)
    with text.listening(lambda what, part: heard.append((what, part))):
        assert light.total.any()
    parts = [part for what, part in heard if what.startswith("rays")]
    assert parts == sorted(parts)
    assert parts[-1] == 1.0
    other = GROUND.phong.daylight(DAY, MUNICH, occluders=TOWN)
    stop.set()
    with threads.stopped_by(stop), pytest.raises(threads.StoppedError):
        other.total  # noqa: B018
    assert other._study.cast.kept is None
    np.testing.assert_array_equal(other.total, light.total)


def test_inputs_are_not_modified():
    before = GROUND.copy()
    GROUND.phong.daylight(DAY, MUNICH, occluders=TOWN).mesh["total"][:] = 0.0
    assert before == GROUND


def test_vertices_that_are_not_finite_harm_no_other():
    spoiled = GROUND.copy()
    spoiled.points[5] = math.nan
    light, sound = (each.phong.daylight(DAY, MUNICH, occluders=TOWN) for each in (spoiled, GROUND))
    far = np.linalg.norm(GROUND.points - GROUND.points[5], axis=1) > 12.0
    assert np.isfinite(light.total).all()
    np.testing.assert_allclose(light.sun_hours[far], sound.sun_hours[far])


def test_coordinates_in_degrees_are_said():
    map_of_munich = pv.Plane(center=(11.58, 48.14, 0), i_size=0.2, j_size=0.2)
    with pytest.warns(UserWarning, match="look like degrees of longitude and latitude"):
        map_of_munich.phong.daylight(DAY, MUNICH)


UNEVEN = DAY[[0, 1]].append(DAY[[3]] + pandas.Timedelta("20min"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"times": DAY[::-1]}, "times must be in ascending order"),
        ({"times": DAY[[0, 1, 1, 2]]}, "times must be in ascending order"),
        ({"times": UNEVEN}, "times must be in steps that are multiples"),
        ({"place": None}, "place must be a Place"),
        ({"patches": 144}, "patches must be 145 or 577; got 144"),
        ({"samples": 0}, "samples must be a finite number >= 2"),
        ({"sun_bin": 6}, "sun_bin must be"),
        ({"albedo": 1.5}, "albedo must be"),
        ({"bounces": -1}, "bounces must be"),
        ({"memory": 1e4}, "memory must be at least .* bytes for 169 vertices, 145 patches and .* positions .*; got 1e"),
        ({"occluders": GROUND}, "occluders must be a sequence"),
    ],
)
def test_options_that_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        GROUND.phong.daylight(**{"times": DAY, "place": MUNICH} | options)


# --- what the result shares with nobody


def test_a_vertex_without_a_normal_gets_no_light():
    plane = pv.Plane(i_resolution=4, j_resolution=4).triangulate()
    bare = pv.PolyData(np.vstack([plane.points, [[5.0, 5.0, 5.0]]]), plane.faces)
    light = bare.phong.daylight(DAY, MUNICH)
    assert light.total[-1] == light.standard_error[-1] == 0.0
    assert light.diffuse[0] > 100.0


def test_results_share_no_memory_with_what_others_edit():
    plane, weather = pv.Plane(i_resolution=4, j_resolution=4).triangulate(), (np.full(24, 500.0), np.full(24, 90.0))
    expected = plane.phong.daylight(DAY, MUNICH, weather)
    direct = expected.direct.copy()
    light = plane.phong.daylight(DAY, MUNICH, weather)
    weather[0][:] = 0.0
    points = plane.points.copy()
    plane.points[:] = 0.0
    plane["Normals"][:] = (0.0, 0.0, -1.0)
    np.testing.assert_array_equal(light.direct, direct)
    np.testing.assert_array_equal(light.mesh.points, points)
    light.mesh["direct"][:] = 0.0
    light.mesh.points[:] = 0.0
    np.testing.assert_array_equal(light.direct, direct)
    np.testing.assert_array_equal(light.mesh.points, points)


@pytest.mark.parametrize("option", [{"patches": 145.5}, {"samples": 2.5}, {"bounces": 1.5}])
def test_fractions_are_not_rounded_to_whole_numbers(option):
    ((name, value),) = option.items()
    with pytest.raises(ValueError, match=rf"^{name} must be .*; got {value}"):
        pv.Plane().phong.daylight(DAY, MUNICH, **option)
