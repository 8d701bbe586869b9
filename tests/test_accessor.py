"""`mesh.phong`: found by PyVista itself, on every dataset with a surface and on MultiBlock."""

import inspect
import subprocess
import sys

import numpy as np
import pytest
import pyvista as pv
import vtk

import pvphong as ph
from pvphong.meshes.blocks import datasets
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.lit import shade_mesh
from pvphong.optics.lights import DirectionalLight, PointLight
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
from pvphong.studies.refine import refinement

SCENE = Scene(lights=[DirectionalLight(direction=(-1, -2, -3)), PointLight(position=(1, 1, 2))])
GRID = pv.ImageData(dimensions=(3, 3, 3))
DATASETS = [pv.Sphere(), GRID, GRID.cast_to_structured_grid(), GRID.cast_to_rectilinear_grid()]
DATASETS += [GRID.cast_to_unstructured_grid()]

USE = """
import sys
import pyvista as pv
assert "pvphong" not in sys.modules
assert "phong" in dir(pv.Sphere())
lights = [pv.Light(position=(1, 1, 1))]
shade = pv.{mesh}.phong.shade
from pvphong.scene.scene import Scene
lit = shade(Scene(lights=lights))
{check}
plotter = pv.Plotter(off_screen=True)
assert len(plotter.phong.scene.lights) == 5
plotter.close()
print("done")
"""


@pytest.mark.parametrize(
    ("mesh", "check"),
    [
        ("Sphere()", 'assert lit["phong"].shape == (lit.n_points, 3)'),
        ("ImageData(dimensions=(3, 3, 3))", 'assert lit["phong"].shape == (lit.n_points, 3)'),
        ('MultiBlock({"a": pv.Sphere(), "b": None})', 'assert lit["a"]["phong"].max() > 0'),
    ],
)
def test_works_with_nothing_imported_but_pyvista(mesh, check):
    """PyVista finds the accessor and the plotter component by their entry points."""
    code = USE.format(mesh=mesh, check=check)
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout.strip()) == (0, "done"), done.stderr


@pytest.mark.parametrize("mesh", DATASETS, ids=lambda mesh: type(mesh).__name__)
def test_every_dataset_has_what_the_functions_give(mesh):
    matrix, shiny = np.diag([1.0, 1, -1, 1]), Material(specular=0.3, shininess=4)
    assert "phong" in dir(mesh)
    lit, expected = mesh.phong.shade(SCENE, shiny, name="glow"), shade_mesh(mesh, SCENE, shiny, name="glow")
    assert lit["glow"].tobytes() == expected["glow"].tobytes()
    assert str(mesh.phong.diagnose(matrix=matrix)) == str(ph.diagnose(mesh, matrix=matrix))
    plans = mesh.phong.plan(SCENE, shiny, tolerance=0.01), ph.plan(mesh, SCENE, shiny, tolerance=0.01)
    assert plans[0].explain() == plans[1].explain()


def test_is_not_there_on_what_has_no_surface():
    assert not hasattr(pv.Table({"a": np.zeros(3)}), "phong")


def test_the_signature_is_the_documented_one():
    parameters = list(inspect.signature(type(pv.Sphere().phong).shade).parameters.values())[1:]
    assert [(p.name, p.default) for p in parameters] == [
        ("scene", None), ("material", Material()), ("name", "phong"), ("matrix", None),
        ("albedo", None), ("specular", None), ("shininess", None), ("roughness", None), ("tangents", None),
        ("components", False), ("tolerance", 0.0), ("precision", "float32"), ("backend", "auto"),
        ("feature_angle", None), ("occluders", ()), ("visibility", None),
    ]  # fmt: skip
    assert {p.kind for p in parameters[2:]} == {inspect.Parameter.KEYWORD_ONLY}


@pytest.mark.parametrize("name", ["refine", "interpolation_error"])
def test_what_a_study_takes_is_written_out_for_a_mesh_and_for_blocks(name):
    """The function's own parameters, all with its defaults but scene and material, which may be left out."""
    taken = list(inspect.signature(getattr(refinement, name)).parameters.values())[1:]
    expected = [(p.name, p.kind, p.default) for p in taken]
    for kind, material in (("scene", None), ("material", Material())):
        place = [entry[0] for entry in expected].index(kind)
        expected[place] = (kind, inspect.Parameter.POSITIONAL_OR_KEYWORD, material)
    for phong in (type(pv.Sphere().phong), type(pv.MultiBlock().phong)):
        found = list(inspect.signature(getattr(phong, name)).parameters.values())[1:]
        assert [(p.name, p.kind, p.default) for p in found] == expected, phong


def test_blocks_are_refined_by_themselves_in_one_scene():
    blocks = pv.MultiBlock({"ball": pv.Sphere(theta_resolution=8, phi_resolution=8), "gap": None})
    blocks["ball"]["tint"] = np.linspace(0.2, 1, 3 * blocks["ball"].n_points).reshape(-1, 3)
    options = {"tolerance": 0.02, "max_points": 500, "name": "lit", "placement": "smooth", "albedo": "tint"}
    options |= {"matrix": np.diag([1, 1, 2.0, 1]), "precision": "float64", "feature_angle": 20}
    found = blocks.phong.refine(SCENE, **options)
    assert found.keys() == ["ball", "gap"]
    assert found["gap"] is None
    framed = scene_for(blocks, SCENE, options["matrix"])
    expected = refinement.refine(blocks["ball"], framed, Material(), **options)
    np.testing.assert_array_equal(found["ball"]["lit"], expected["lit"])
    assert expected["lit"].dtype == np.float64
    errors = blocks.phong.interpolation_error(SCENE, albedo="tint", matrix=options["matrix"], feature_angle=20)
    options = {"albedo": "tint", "matrix": options["matrix"], "feature_angle": 20}
    expected = refinement.interpolation_error(blocks["ball"], framed, Material(), **options)
    np.testing.assert_array_equal(errors["ball"].active_scalars, expected.active_scalars)


def test_every_study_of_blocks_takes_a_material_for_each():
    ball = pv.Sphere(theta_resolution=8, phi_resolution=8)
    blocks, mirror = pv.MultiBlock({"a": ball, "gap": None, "b": ball}), Material(diffuse=0.1, specular=0.9)
    given, plain = {"default": Material(), "b": mirror}, blocks.phong
    refined = plain.refine(SCENE, given, tolerance=0.2)
    alone = plain.refine(SCENE, mirror, tolerance=0.2)
    np.testing.assert_array_equal(refined["b"]["phong"], alone["b"]["phong"])
    errors = [plain.interpolation_error(SCENE, one)["b"].active_scalars for one in (given, mirror, Material())]
    np.testing.assert_array_equal(errors[0], errors[1])
    assert np.abs(errors[0] - errors[2]).max() > 1e-3
    assert [plan.effects["specular"].on for plan in plain.plan(SCENE, given).values()] == [False, True]
    compared = plain.validate(SCENE, given)
    assert [part.passed for part in compared.values()] == [True, True]
    assert not np.array_equal(compared["a"].pvphong, compared["b"].pvphong)


def test_follows_the_mesh_not_a_copy_of_it():
    mesh = pv.Sphere()
    mesh.clear_data()
    phong = mesh.phong
    before = phong.shade(SCENE)["phong"].copy()
    mesh.points += [0, 0, 5]
    assert np.abs(phong.shade(SCENE)["phong"] - before).max() > 0.1


def wheel(size):
    return pv.Plane(i_resolution=size)


def test_every_block_has_its_own_plan_and_diagnosis_where_names_are_shared_or_missing():
    car = pv.MultiBlock()
    for size in (1, 2):
        car.append(wheel(size), "wheel")
    car.append(wheel(3), "hood")
    blocks = pv.MultiBlock()
    blocks.append(car, "car")
    blocks.append(wheel(4), "car/hood")
    nameless = vtk.vtkMultiBlockDataSet()
    nameless.SetBlock(0, wheel(5))
    nameless.SetBlock(1, wheel(6))
    blocks.append(pv.wrap(nameless), "rest")
    paths = ["car/wheel [0][0]", "car/wheel [0][1]", "car/hood [0][2]", "car/hood [1]", "rest/0", "rest/1"]
    assert list(blocks.phong.plan(SCENE)) == paths
    sizes = [block.n_cells for _, block in datasets(blocks)]
    assert sizes == [10, 20, 30, 40, 50, 60]
    assert list(blocks.phong.diagnose()) == paths
    inner = pv.MultiBlock({"ball": pv.Sphere(), "gap": None})
    diagnoses = pv.MultiBlock({"inner": inner, "box": pv.Box(), "void": pv.PolyData()}).phong.diagnose()
    assert list(diagnoses) == ["inner/ball", "box"]
    assert str(diagnoses["box"]) == str(pv.Box().phong.diagnose())


# --- a material for each block ---


def blocks_of_three():
    return pv.MultiBlock(
        {"one": pv.Sphere(), "gap": None, "deep": pv.MultiBlock({"two": pv.Cube(), "three": pv.Cone()})}
    )


def test_each_block_has_the_material_of_its_name():
    red, blue, green = (Material(diffuse=name) for name in ("red", "blue", "green"))
    lit = blocks_of_three().phong.shade(SCENE, {"one": red, "deep/three": blue, "default": green})
    for block, material in [(lit["one"], red), (lit["deep"]["two"], green), (lit["deep"]["three"], blue)]:
        np.testing.assert_array_equal(block["phong"], block.phong.shade(SCENE, material)["phong"])


@pytest.mark.parametrize("names", [("one",), ("one", "deep/two", "deep/three", "four"), ("default", "two")])
def test_a_block_without_a_material_and_a_name_without_a_block_are_refused(names):
    with pytest.raises(ValueError, match=r"^material must be a mapping with the names of all blocks"):
        blocks_of_three().phong.shade(SCENE, dict.fromkeys(names, Material()))
