"""Cost of rays: rows of the report for shadows and occlusion by few rays and by many."""

import numpy as np
import pytest
import pyvista as pv
from ray_backends import FASTEST

import pvphong as ph
from pvphong.optics.maps import Map
from pvphong.studies.accuracy.timing import Clock
from pvphong.studies.accuracy.variants import Subject, sampling

SUN = ph.DirectionalLight(direction=(1, 0, -1), name="sun")
BALL = ph.SphereLight(position=(0, 1, 3), radius=0.5, intensity=6, name="ball")
CLAY = ph.Material(ambient=0.8, diffuse=0.6)
VIEWER = ph.Viewer(position=(0, -4, 3))
MEASURE = "pvphong.studies.accuracy.measure"
pytestmark = pytest.mark.skipif(FASTEST == "vtk", reason="VTK's rays take longer than the budget")


def scene(*lights, **model):
    return ph.Scene(lights, VIEWER, ph.LightModel(**model))


FLOOR = pv.Plane(i_size=4, j_size=4, i_resolution=16, j_resolution=16).triangulate()
ROOF = pv.Disc(center=(0, 0, 1), inner=0.0, outer=1.0, r_res=1, c_res=40)
RIG = scene(SUN, BALL, shadows=True, ambient_occlusion=True)


def sampled(mesh, rig, *occluders):
    """Measure with enough time for all rows, even on a slow machine."""
    seen = mesh.phong.visibility(rig, occluders=occluders, tolerance=0.005)
    subject = Subject(np.asarray(mesh.points), mesh.phong.normals(), rig, CLAY, None, seen)
    return sampling(subject, seen, 0.005, Clock(3600.0))


@pytest.fixture(scope="module")
def rows():
    found = sampled(FLOOR, RIG, ROOF)
    return {row.name: row for row in found.rows}


@pytest.fixture(scope="module")
def report():
    return FLOOR.phong.tradeoff(RIG, CLAY, tolerance=0.005, seconds=3.0, occluders=[ROOF])


def rays(row):
    """Return the rays per vertex from the row's note; a time would depend on the machine."""
    return float(row.note.split()[0])


def test_some_vertices_get_the_colours_that_all_of_them_get():
    """Each vertex uses its own normal, visibility and map values."""
    random = np.random.default_rng(7)
    material = CLAY.with_values({"diffuse": Map(random.random((FLOOR.n_points, 3)))})
    seen = FLOOR.phong.visibility(RIG, occluders=[ROOF], samples=4)
    normals = FLOOR.phong.normals() + 0.3 * random.normal(size=(FLOOR.n_points, 3))
    subject = Subject(np.asarray(FLOOR.points), normals, RIG, material, None, seen)
    some = random.permutation(FLOOR.n_points)[:100]
    channels = seen.channels(subject.equation.shadowed, sky=True)[:, some]
    np.testing.assert_array_equal(subject.exact(subject.equation, some, channels), subject.truth[some])
    assert np.ptp(subject.truth[some], axis=0).min() > 0.1


def test_more_rays_err_less(rows):
    assert [*rows] == ["rays to 0.005", "4 rays", "16 rays", "64 rays", "256 rays"]
    few, some, many = (rows[f"{count} rays"] for count in (4, 16, 64))
    assert few.error.rms > some.error.rms > many.error.rms > 0.0
    assert rays(few) == 9  # one to the sun
    assert rays(few) < rays(some) < rays(many)
    assert rows["rays to 0.005"].decisive_error < 0.005
    assert few.arithmetic is few.light_model is few.interpolation is None


def test_a_rows_error_is_that_of_its_colours(rows):
    seen = {n: FLOOR.phong.visibility(RIG, occluders=[ROOF], samples=n) for n in (4, 4096)}
    few, truth = (FLOOR.phong.shade(RIG, CLAY, visibility=v, precision="float64")["phong"] for v in seen.values())
    assert rows["4 rays"].error.count == FLOOR.n_points
    assert rows["4 rays"].error.largest == pytest.approx(np.abs(few - truth).max(), rel=1e-6)
    assert rows["4 rays"].error.rms == pytest.approx(np.sqrt(np.mean((few - truth) ** 2)), rel=1e-6)


def test_the_other_kinds_take_what_is_seen_as_known(report):
    exact = next(row for row in report.rows if row.name == "float64 reference")
    assert exact.arithmetic.largest == 0.0


def test_without_time_for_rays_inside_triangles_there_is_no_shadow(monkeypatch):
    monkeypatch.setattr(f"{MEASURE}.seconds_of_rays", lambda *_: 1e9)
    found = FLOOR.phong.tradeoff(scene(SUN, shadows=True), CLAY, seconds=2.0, occluders=[ROOF])
    assert "no time for rays" in found.left_out["shadows and occlusion inside triangles"]
    assert found.inside_errors.max(initial=0.0) < 1e-6


def test_rays_inside_triangles_are_cast_if_the_part_of_the_time_that_they_get_is_enough(monkeypatch):
    monkeypatch.setattr(f"{MEASURE}._Measurement._left", lambda *_: 10.0)
    monkeypatch.setattr(f"{MEASURE}.seconds_of_rays", lambda *_: 1e3)
    monkeypatch.setattr(f"{MEASURE}.least_seconds", lambda _, seconds: 6.0 if seconds > 1e2 else 1e-3)
    found = FLOOR.phong.tradeoff(scene(SUN, shadows=True), CLAY, seconds=2.0, occluders=[ROOF])
    assert "no time for rays" in found.left_out["shadows and occlusion inside triangles"]


def test_the_ledger_prices_shadows_and_occlusion_with_their_rays(report):
    entries = {entry.effect: entry for entry in report.ledger}
    for name, error in (("shadow", 0.3), ("occlusion", 0.02)):
        assert entries[name].runs
        assert entries[name].error > error
        assert entries[name].cost.median > entries["diffuse"].cost.median


def test_it_is_shown_with_the_other_kinds(report):
    text = report.explain()
    assert "sampling:" in text
    assert "casting rays" in text
    chosen = report.best(question="casting rays").name
    assert chosen in str(report)
    assert report.to_dict()["chosen"]["casting rays"] == chosen


def test_one_ray_says_all_of_lights_without_a_size():
    (row,) = sampled(FLOOR, scene(SUN, shadows=True), ROOF).rows
    assert (row.name, row.error.largest) == ("one ray for each light", 0.0)


def test_where_nothing_is_in_the_way_no_ray_is_priced():
    found = sampled(pv.Sphere(), scene(SUN, shadows=True))
    assert not found.rows
    assert "sun: the mesh is convex, and alone" in found.left_out["rays"]


@pytest.mark.parametrize("reflectance", [ph.Phong(40.0), ph.Ward(0.2, 0.4)])
@pytest.mark.parametrize("two_sided", [False, True])
def test_highlights_of_partly_hidden_lights_are_off_by_what_paths_say(reflectance, two_sided):
    """A screen hides half of an area light, and the highlight reflects the visible or the hidden half."""
    floor, screen = FLOOR.copy(), pv.Plane(center=(1, 0, 1.5), i_size=2, j_size=9)
    floor["along"] = np.tile([1.0, 0.0, 0.0], (floor.n_points, 1))
    panel = ph.RectangleLight(position=(0, 0, 3), direction=(0, 0, -1), width=1.5, height=1.5, intensity=6.0)
    glossy = ph.Material(diffuse=0.2, specular=0.6, reflectance=reflectance, tangents=floor["along"])
    rig = scene(panel, shadows=True, two_sided=two_sided, ambient=0.0, clamp=False)
    seen, rows = floor.phong.visibility(rig, occluders=[screen], samples=4096), np.arange(0, floor.n_points, 7)
    subject = Subject(np.asarray(floor.points), floor.phong.normals(), rig, glossy, None, seen)
    found = subject.highlights_beyond_shares(seen.afresh(samples=4096, rows=rows), rows)
    true = floor.phong.truth(rig, glossy, occluders=[screen], samples=1024, max_bounces=0)
    off = true.rgb[rows] - floor.phong.shade(rig, glossy, visibility=seen)["phong"][rows]
    assert np.abs(off).max() > 0.02
    np.testing.assert_allclose(found, off, atol=0.15 * np.abs(off).max() + 5 * true.standard_error.max())
