"""Report of accuracy against time: errors equal those of `evaluate`, error bounds hold, the choice is right."""

import csv
import time
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from stability.hunting import promising_case
from strategies import Dice

import pvphong as ph
from pvphong.shading.plan.effects import EFFECTS
from pvphong.studies.accuracy.measure import predicted_bounds, tradeoff
from pvphong.studies.accuracy.peers import textbook_colors
from pvphong.studies.accuracy.result import Errors
from pvphong.studies.accuracy.variants import Subject, variants

STEP = 1 / 255
SUN = ph.PointLight(position=(400, 100, 300), name="sun")
LAMP = ph.PointLight(position=(0, -1.5, 0.6), attenuation=(1, 0, 0.5), diffuse=(0.3, 0.4, 0.6), name="lamp")
GLOW = ph.PointLight(position=(0, 0, -3), diffuse=0.0005, name="glow")
SCENE = ph.Scene(lights=[SUN, LAMP, GLOW], viewer=ph.Viewer(position=(1.5, 1.2, 1.0), up=(0, 0, 1)))
SHINY = ph.Material(diffuse=(0.6, 0.5, 0.4), specular=0.4, shininess=30)


@pytest.fixture(scope="module")
def mesh():
    return pv.Sphere(theta_resolution=24, phi_resolution=24)


@pytest.fixture(scope="module")
def report(mesh):
    return tradeoff(mesh, SCENE, SHINY, seconds=4)


def row(report, name):
    (found,) = [row for row in report.rows if row.name == name]
    return found


def exact(mesh, scene, material, **options):
    normals = mesh.point_data.active_normals
    return ph.evaluate(mesh.points, normals, scene, material, precision="float64", backend="numpy", **options).rgb


def test_arithmetic_error_is_that_of_evaluate(mesh, report):
    float32 = ph.evaluate(mesh.points, mesh.point_data.active_normals, SCENE, SHINY, backend="numpy").rgb
    expected = Errors.at_vertices(float32, exact(mesh, SCENE, SHINY))
    found = row(report, "float32 NumPy").arithmetic
    assert (found.largest, found.rms, found.p99) == pytest.approx((expected.largest, expected.rms, expected.p99))
    assert 0 < found.largest < 1e-5
    assert row(report, "float64 reference").arithmetic.largest == 0.0


def test_light_model_errors_are_those_of_the_changed_scene(mesh, report):
    truth = exact(mesh, SCENE, SHINY)
    x, y, z = SUN.position  # the mesh is centred at the origin, and the lamp is near
    up = ph.DirectionalLight(direction=(0, 0, 1), diffuse=GLOW.diffuse)
    far, blinn = ph.LightModel(local_viewer=False), ph.LightModel(reflection="blinn-phong")
    changed = {
        "infinite viewer": (replace(SCENE, light_model=far), SHINY),
        "Blinn-Phong, shininess × 4": (replace(SCENE, light_model=blinn), SHINY.for_blinn_phong()),
        "no highlights": (SCENE, replace(SHINY, specular=0.0)),
        "far lights directional": (
            replace(SCENE, lights=[ph.DirectionalLight(direction=(-x, -y, -z)), LAMP, up]),
            SHINY,
        ),
    }
    for name, (scene, material) in changed.items():
        error = np.abs(exact(mesh, scene, material) - truth).max()
        assert row(report, name).light_model.largest == pytest.approx(error, rel=1e-4) != 0, name
        assert row(report, name).arithmetic.largest < 1e-5, name


@pytest.mark.parametrize(
    ("reflectance", "name", "simpler"),
    [
        (ph.OrenNayar(25), "Lambert for Oren-Nayar", ph.Material(diffuse=0.5 * 0.882449)),
        (ph.Metal(0.6, 9), "Phong for Metal", ph.Material(diffuse=0.5, specular=0.6, shininess=9)),
        (ph.GGX(0.5, 0.4), "Phong for microfacets", ph.Material(diffuse=0.3 * 23 / 28, specular=1.6, shininess=13.387)),
    ],
)
def test_simpler_reflectances_are_priced(mesh, reflectance, name, simpler):
    material = ph.Material(diffuse=0.5, reflectance=reflectance)
    subject = Subject(mesh.points, mesh.point_data.active_normals, SCENE, material, None)
    (found,) = [variant for variant in variants(subject, STEP)[0] if variant.row.name == name]
    truth, expected = exact(mesh, SCENE, material), exact(mesh, SCENE, simpler)
    np.testing.assert_allclose(
        subject.exact(found.equation), expected, rtol=0, atol=1e-3 * np.abs(expected - truth).max()
    )
    np.testing.assert_allclose(found.run(), expected, rtol=0, atol=1e-5)
    assert found.row.kind == "light model"


def test_interpolation_errors_fall_when_the_mesh_is_refined(mesh, report):
    whole = mesh.phong.interpolation_error(SCENE, SHINY)["phong_interpolation_error"]
    assert row(report, "as it is").interpolation.largest == pytest.approx(whole.max(), rel=1e-6)
    errors = [row(report, f"refined {level}×").interpolation.largest for level in (1, 2)]
    assert whole.max() > 1.5 * errors[0] > 3 * errors[1] > 0
    assert row(report, "refined 1×").points == mesh.n_points + mesh.extract_all_edges().n_cells


def test_the_choice_is_within_the_tolerance_by_another_formula(mesh, report):
    chosen = report.best()
    assert chosen.decisive_error <= STEP
    colors = textbook_colors(mesh.points, mesh.point_data.active_normals, SCENE, SHINY)
    assert np.abs(report.chosen_colors - colors).max() <= STEP
    assert chosen.time.median == min(
        r.time.median for r in report.rows if r.kind != "interpolation" and not r.is_peer and r.decisive_error <= STEP
    )


def test_a_tolerance_of_nothing_leaves_the_reference_and_one_of_all_the_fastest(report):
    assert {row.kind for row in report.rows} == {"arithmetic", "light model", "interpolation"}
    assert all(0 < row.time.low <= row.time.median <= row.time.high for row in report.rows)
    assert report.best(0.0).name == "float64 reference"
    fastest = min((r for r in report.rows if r.kind != "interpolation" and not r.is_peer), key=lambda r: r.time.median)
    assert report.best(10.0) is fastest
    assert report.best(1e-9, "inside triangles") is None
    assert report.best(10.0, "inside triangles").kind == "interpolation"
    assert report.next_step(report.best(0.0)) is None
    assert report.next_step(fastest).decisive_error < fastest.decisive_error
    with pytest.raises(ValueError, match="tolerance must be a finite number >= 0"):
        report.best(-1.0)
    with pytest.raises(ValueError, match="question must be one of 'at the vertices'"):
        report.best(10.0, "outside")


def test_a_model_matrix_and_a_tolerance_take_part_and_the_mesh_is_left_as_it_was(mesh):
    before, matrix = mesh.copy(), np.diag([1.0, 1.0, 2.0, 1.0])
    found = mesh.phong.tradeoff(SCENE, SHINY, tolerance=0.01, seconds=1, matrix=matrix)
    np.testing.assert_array_equal(found.reference_colors, exact(mesh, SCENE, SHINY, matrix=matrix))
    assert found.tolerance == 0.01
    assert mesh == before


def test_a_cloud_has_no_inside():
    cloud = pv.PolyData(np.eye(3, dtype=np.float32))
    cloud.point_data.active_normals = np.eye(3, dtype=np.float32)
    found = tradeoff(cloud, SCENE, SHINY, seconds=1)
    assert "no triangles" in found.left_out["inside triangles"]
    assert "at the vertices" in str(found)
    assert "inside" not in str(found)
    assert not any(row.kind == "interpolation" and not row.is_peer for row in found.rows)


def test_the_plans_row_says_what_was_predicted(mesh, report):
    planned = row(report, "plan at 1/255")
    plan = mesh.phong.plan(SCENE, SHINY, tolerance=STEP)
    assert planned.error_bound == plan.error_bound > 0
    assert planned.light_model.largest <= plan.error_bound
    assert {bound.effect for bound in report.predicted_bounds} >= {"lights"}
    assert sum(bound.predicted for bound in report.predicted_bounds) == pytest.approx(plan.error_bound)


def test_no_approximation_errs_by_more_than_is_predicted():
    count = 0
    for seed in range(60):
        thrown = promising_case(Dice(seed))
        for bound in predicted_bounds(Subject(*thrown.case.arguments, thrown.case.matrix), thrown.tolerance):
            assert bound.measured <= bound.predicted + 1e-9, f"seed {seed}: {bound}"
            count += 1
    assert count > 60, "approximations are really taken"


def test_approximations_of_physically_based_shading_are_those_that_the_plan_took(mesh):
    """Colours are light to the power 1/2.2."""
    physical = ph.Material(reflectance=ph.PBR(roughness=0.4))
    lamps = [replace(light, intensity=strength) for light, strength in ((SUN, 1.0), (GLOW, 0.01))]
    scene = replace(SCENE, lights=lamps, light_model=ph.LightModel.vtk())
    for tolerance in (STEP, 0.1):
        plan = mesh.phong.plan(scene, physical, tolerance=tolerance)
        subject = Subject(mesh.points, mesh.point_data.active_normals, scene, physical, None)
        bounds = predicted_bounds(subject, tolerance)
        assert {bound.effect for bound in bounds} == {name for name, each in plan.effects.items() if each.bound}
        light = sum(bound.predicted**2.2 for bound in bounds)
        assert light ** (1 / 2.2) == pytest.approx(plan.error_bound)
        assert all(bound.measured <= bound.predicted for bound in bounds)
    assert bounds


def test_very_far_out_the_whole_equation_is_the_one_that_evaluate_runs(mesh):
    offset = (2.0**40, 0.0, 0.0)
    matrix = np.eye(4)
    matrix[:3, 3] = offset
    lamp, viewer = replace(LAMP, position=np.add(LAMP.position, offset)), ph.Viewer(np.add((0, 0, 3), offset), offset)
    subject = Subject(mesh.points, mesh.point_data.active_normals, ph.Scene([lamp], viewer), SHINY, matrix)
    expected = exact(mesh, subject.scene, SHINY, matrix=matrix)
    np.testing.assert_allclose(subject.exact(subject.assembled), expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"truth": "yes"}, "truth must be True or False"),
        ({"truth": True}, "truth must be False in VTK's convention"),
        ({"visibility": np.ones((4, 3))}, "visibility must be a result of mesh.phong.visibility; got ndarray"),
    ],
)
def test_what_is_wrong_is_refused_before_anything_is_measured(mesh, monkeypatch, given, message):
    monkeypatch.delattr("pvphong.studies.accuracy.measure._Measurement.run")
    with pytest.raises(ValueError, match=f"^{message}"):
        tradeoff(mesh, replace(SCENE, light_model=ph.LightModel.vtk()), SHINY, **given)


def test_the_ledger_tells_error_reason_and_whether_it_runs(mesh, report):
    entries = {entry.effect: entry for entry in report.ledger}
    assert set(entries) == {effect.name for effect in EFFECTS} | {"light sun", "light lamp", "light glow"}
    plan = mesh.phong.plan(SCENE, SHINY, tolerance=STEP)
    for name, choice in plan.effects.items():
        assert (entries[name].runs, entries[name].why) == (choice.on, choice.why)
    truth = exact(mesh, SCENE, SHINY)
    without = exact(mesh, replace(SCENE, lights=[SUN, GLOW]), SHINY)
    assert entries["light lamp"].error == pytest.approx(np.abs(without - truth).max(), rel=1e-9)
    assert not entries["light glow"].runs
    assert entries["light lamp"].runs
    assert entries["cone"].cost is None
    assert entries["cone"].error is None
    assert entries["lights"].cost.median > entries["ambient"].cost.median


@pytest.mark.usefixtures("report")  # the first report of a process also loads code
def test_the_time_budget_is_kept(mesh):
    for seconds in (0.5, 3.0):
        start = time.process_time()
        found = tradeoff(mesh.subdivide(3), SCENE, SHINY, seconds=seconds)
        assert time.process_time() - start < 1.05 * seconds
        assert found.best() is not None


def test_what_there_is_no_time_for_is_said(mesh):
    found = tradeoff(mesh, SCENE, SHINY, seconds=0.05)
    assert "there was no time for it" in found.left_out.values()
    assert {"float64 reference", "float32 NumPy", "plan at 1/255"} <= {row.name for row in found.rows}
    assert "left out" in found.explain()


def test_csv_has_a_line_per_row(report, tmp_path):
    report.to_csv(tmp_path / "rows.csv")
    with open(tmp_path / "rows.csv", newline="", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    assert [line["name"] for line in lines] == [row.name for row in report.rows]
    assert float(lines[0]["time_median"]) == report.rows[0].time.median
    assert float(lines[0]["arithmetic_largest"]) == report.rows[0].arithmetic.largest
    assert lines[0]["interpolation_largest"] == ""


def test_the_mesh_carries_the_errors(mesh, report):
    lit = report.to_mesh()
    np.testing.assert_array_equal(lit["phong_reference"], exact(mesh, SCENE, SHINY))
    np.testing.assert_allclose(lit["phong_error"], lit["phong_chosen"] - lit["phong_reference"], atol=1e-12)
    assert lit["phong_interpolation_error"].shape == (mesh.n_cells,)


def test_a_figure_that_cannot_be_drawn_is_refused(report, tmp_path):
    with pytest.raises(ValueError, match=r"suffix of path must be one of '\.png', '\.pdf', '\.svg'; got \.bmp"):
        report.plot(tmp_path / "figure.bmp")
