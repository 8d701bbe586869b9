"""The report on accuracy and time: its errors are those of `evaluate`, its promises hold, its choice is right."""

import csv
import json
import re
import sys
import time
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.shading.plan.effects import EFFECTS
from pvphong.studies.accuracy import tradeoff
from pvphong.studies.accuracy.drops import DROPS
from pvphong.studies.accuracy.ledger import promises
from pvphong.studies.accuracy.subject import Subject
from pvphong.studies.accuracy.textbook import textbook_colors

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
    return tradeoff(mesh, SCENE, SHINY, seconds=7)


def row(report, name):
    (found,) = [row for row in report.rows if row.name == name]
    return found


def exact(mesh, scene, material, **options):
    normals = mesh.point_data.active_normals
    return ph.evaluate(mesh.points, normals, scene, material, precision="float64", backend="numpy", **options).rgb


# -- what is measured


def test_the_three_kinds_are_there(report):
    kinds = {row.kind for row in report.rows}
    assert kinds == {"arithmetic", "light model", "interpolation"}
    assert all(row.time.repeats >= 3 for row in report.rows)
    assert all(0 < row.time.low <= row.time.median <= row.time.high for row in report.rows)


def test_arithmetic_error_is_that_of_evaluate(mesh, report):
    truth = exact(mesh, SCENE, SHINY)
    float32 = ph.evaluate(mesh.points, mesh.point_data.active_normals, SCENE, SHINY, backend="numpy").rgb
    errors = row(report, "float32 NumPy").arithmetic
    assert errors.largest == pytest.approx(np.abs(float32 - truth).max(), rel=1e-12)
    assert errors.rms == pytest.approx(np.sqrt(np.mean((float32 - truth) ** 2)), rel=1e-9)
    assert 0 < errors.largest < 1e-5
    assert row(report, "float64 reference").arithmetic.largest == 0.0


def test_light_model_errors_are_those_of_the_changed_scene(mesh, report):
    truth = exact(mesh, SCENE, SHINY)
    x, y, z = SUN.position  # the mesh's middle is the origin, and the lamp is not far
    up = ph.DirectionalLight(direction=(0, 0, 1), diffuse=GLOW.diffuse)
    changed = {
        "infinite viewer": (replace(SCENE, light_model=ph.LightModel(local_viewer=False)), SHINY),
        "Blinn-Phong, shininess × 4": (
            replace(SCENE, light_model=ph.LightModel(reflection="blinn-phong")),
            SHINY.for_blinn_phong(),
        ),
        "no highlights": (SCENE, replace(SHINY, specular=0.0)),
        "far lights directional": (
            replace(SCENE, lights=[ph.DirectionalLight(direction=(-x, -y, -z)), LAMP, up]),
            SHINY,
        ),
    }
    for name, (scene, material) in changed.items():
        error = np.abs(exact(mesh, scene, material) - truth).max()
        assert row(report, name).light_model.largest == pytest.approx(error, rel=1e-4), name
        assert row(report, name).light_model.largest > 0, name
        assert row(report, name).arithmetic.largest < 1e-5, name


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
    assert report.best(0.0).name == "float64 reference"
    fastest = min((r for r in report.rows if r.kind != "interpolation" and not r.is_peer), key=lambda r: r.time.median)
    assert report.best(10.0) is fastest
    assert report.best(1e-9, inside=True) is None
    assert report.best(10.0, inside=True).kind == "interpolation"
    assert report.next_step(report.best(0.0)) is None
    following = report.next_step(report.best(10.0))
    assert following.decisive_error < report.best(10.0).decisive_error


def test_a_model_matrix_takes_part(mesh):
    matrix = np.diag([1.0, 1.0, 2.0, 1.0])
    found = tradeoff(mesh, SCENE, SHINY, seconds=1, matrix=matrix)
    np.testing.assert_array_equal(found.reference_colors, exact(mesh, SCENE, SHINY, matrix=matrix))


def test_the_input_is_not_modified(mesh):
    before = mesh.copy()
    tradeoff(mesh, SCENE, SHINY, seconds=1)
    assert mesh == before


def test_a_cloud_has_no_inside():
    cloud = pv.PolyData(np.eye(3, dtype=np.float32))
    cloud.point_data.active_normals = np.eye(3, dtype=np.float32)
    found = tradeoff(cloud, SCENE, SHINY, seconds=1)
    assert "no inside" in found.left_out["inside triangles"]
    assert "At the vertices" in str(found)
    assert not any(row.kind == "interpolation" and not row.is_peer for row in found.rows)


# -- promises


def test_the_plans_row_says_what_was_promised(mesh, report):
    planned = row(report, "plan at 1/255")
    plan = mesh.phong.plan(SCENE, SHINY, tolerance=STEP)
    assert planned.promised == plan.error_bound > 0
    assert planned.light_model.largest <= plan.error_bound
    assert {promise.effect for promise in report.promises} >= {"lights"}
    assert sum(promise.promised for promise in report.promises) == pytest.approx(plan.error_bound)


def test_no_approximation_errs_by_more_than_it_promises():
    rng = np.random.default_rng(5)
    count = 0
    for _ in range(60):
        subject = random_subject(rng)
        tolerance = 10 ** rng.uniform(-6, -1)
        found = promises(subject, tolerance)
        count += len(found)
        for promise in found:
            assert promise.measured <= promise.promised + 1e-12, (subject.scene, subject.material, tolerance)
        plan = subject.plan(tolerance)
        error = np.abs(subject.exact(plan.equation) - subject.truth).max()
        assert error <= plan.error_bound + 1e-12 <= tolerance + 2e-12
    assert count > 60, "approximations are really taken"


def random_subject(rng):
    """Vertices of a patch; lights near, far and weak; a viewer near or far."""
    points = rng.normal(size=(200, 3)) * 10 ** rng.uniform(-2, 0)
    normals = points + rng.normal(size=3) * 10 ** rng.uniform(-2, 1)

    def place():
        return rng.normal(size=3) * 10 ** rng.uniform(0, 6)

    lights = []
    for _ in range(rng.integers(1, 5)):
        common = {"diffuse": 10 ** rng.uniform(-6, 0), "position": place()}
        if rng.random() < 0.5:
            common["attenuation"] = (1, 0, 10 ** rng.uniform(-14, 0))
        if rng.random() < 0.3:
            lights.append(ph.SpotLight(direction=-common["position"], exponent=rng.uniform(0, 9), **common))
        else:
            lights.append(ph.PointLight(**common))
    model = ph.LightModel(reflection=rng.choice(["phong", "blinn-phong"]), two_sided=rng.random() < 0.2)
    scene = ph.Scene(lights, ph.Viewer(position=place(), up=rng.normal(size=3)), model)
    material = ph.Material(diffuse=rng.random(), specular=rng.random(), shininess=rng.uniform(1, 100))
    return Subject(points, normals, scene, material, None)


def test_promises_name_lights_as_the_plan_does(mesh):
    lights = [replace(SUN, name=""), replace(SUN, name="twin"), replace(SUN, name="twin")]
    scene = replace(SCENE, lights=lights)
    subject = Subject(mesh.points, mesh.point_data.active_normals, scene, ph.Material(), None)
    (promise,) = promises(subject, 0.02)
    assert re.findall(r"(light \d): far away", promise.why) == ["light 0", "light 1", "light 2"]
    assert "light 0, light 1, light 2: far away" in subject.plan(0.02).effects[promise.effect].why


# -- the ledger


def test_every_effect_has_its_way_of_being_dropped():
    assert list(DROPS) == [name for name in DROPS if name in {effect.name for effect in EFFECTS}]
    assert len(DROPS) == len(EFFECTS)


def test_the_ledger_tells_error_reason_and_whether_it_runs(mesh, report):
    entries = {entry.effect: entry for entry in report.ledger}
    assert set(entries) == set(DROPS) | {"light sun", "light lamp", "light glow"}
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


# -- time


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
    assert "left out" in str(found)


# -- what comes out


def test_the_printed_report_names_everything(report):
    shown = str(report)
    for text in ("float64 reference", "plan at 1/255", "VTK per pixel", "At the vertices", "Inside triangles", "cores"):
        assert text in shown
    for heading in ("What each effect costs", "What the plan promised", "measured on", "noise"):
        assert heading in shown
    assert repr(report).startswith("<Tradeoff of ")


def test_csv_has_a_line_per_row(report, tmp_path):
    report.to_csv(tmp_path / "rows.csv")
    with open(tmp_path / "rows.csv", newline="", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    assert [line["name"] for line in lines] == [row.name for row in report.rows]
    first = lines[0]
    assert float(first["time_median"]) == report.rows[0].time.median
    assert float(first["arithmetic_largest"]) == report.rows[0].arithmetic.largest
    assert first["interpolation_largest"] == ""


def test_json_has_all_numbers(report, tmp_path):
    report.to_json(tmp_path / "report.json")
    with open(tmp_path / "report.json", encoding="utf-8") as file:
        read = json.load(file)
    assert read == json.loads(json.dumps(report.to_dict()))
    assert read["chosen"] == report.best().name
    assert len(read["rows"]) == len(report.rows)
    assert read["worst_vertices"][0]["error"] == pytest.approx(np.abs(report.to_mesh()["phong_error"]).max())


def test_the_mesh_carries_the_errors(mesh, report):
    lit = report.to_mesh()
    np.testing.assert_array_equal(lit["phong_reference"], exact(mesh, SCENE, SHINY))
    np.testing.assert_allclose(lit["phong_error"], lit["phong_chosen"] - lit["phong_reference"], atol=1e-12)
    assert lit["phong_interpolation_error"].shape == (mesh.n_cells,)


def test_the_figure_is_drawn(report, tmp_path):
    path = tmp_path / "figure.png"
    report.plot(path)
    pixels = pv.read(path).active_scalars[:, :3]
    assert len(pixels) > 1e6
    assert len(np.unique(pixels, axis=0)) > 1000
    assert [file.name for file in tmp_path.iterdir()] == ["figure.png"]


def test_a_figure_of_another_kind_is_refused(report, tmp_path):
    with pytest.raises(ValueError, match=r"suffix of path must be one of '\.png', '\.pdf', '\.svg'; got \.bmp"):
        report.plot(tmp_path / "figure.bmp")


def test_without_matplotlib_the_message_says_what_to_install(report, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(ValueError, match=r'pip install "pvphong\[plot\]"'):
        report.plot(tmp_path / "figure.png")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"tolerance": 0}, "tolerance must be a finite number > 0"),
        ({"seconds": -1}, "seconds must be a finite number > 0"),
        ({"matrix": np.eye(3)}, "matrix must be a 4x4 matrix"),
        ({"scene": "sun"}, "scene must be a Scene"),
        ({"mesh": pv.PolyData()}, "mesh must be a mesh with faces"),
    ],
)
def test_bad_input_is_refused(mesh, arguments, message):
    given = {"mesh": mesh, "scene": SCENE, "material": SHINY} | arguments
    with pytest.raises(ValueError, match=message):
        tradeoff(**given)


def test_best_refuses_a_tolerance_that_is_none(report):
    with pytest.raises(ValueError, match="tolerance must be a finite number >= 0"):
        report.best(-1.0)


def test_the_accessor_gives_the_same(mesh):
    assert mesh.phong.tradeoff(SCENE, SHINY, tolerance=0.01, seconds=0.5).tolerance == 0.01
