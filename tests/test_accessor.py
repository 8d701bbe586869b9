"""`mesh.phong`: PyVista loads it, for every dataset with a surface and for MultiBlock."""

import ast
import inspect
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
import vtk
from apart import run_apart

import pvphong as ph
from pvphong import DirectionalLight, Material, PointLight, Scene
from pvphong.meshes.blocks import datasets
from pvphong.meshes.default_scene import scene_for
from pvphong.studies import refine

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
assert (lit if isinstance(lit, pv.DataSet) else lit["a"])["phong"].max() > 0
plotter = pv.Plotter(off_screen=True)
assert len(plotter.phong.scene.lights) == 5
plotter.close()
print("done")
"""


@pytest.mark.parametrize(
    "mesh", ["Sphere()", "ImageData(dimensions=(3, 3, 3))", 'MultiBlock({"a": pv.Sphere(), "b": None})']
)
def test_works_with_nothing_imported_but_pyvista(mesh):
    """PyVista finds the accessor and the plotter component by their entry points."""
    assert run_apart(USE.format(mesh=mesh)) == "done\n"


@pytest.mark.parametrize("mesh", DATASETS, ids=lambda mesh: type(mesh).__name__)
def test_every_dataset_has_what_the_functions_give(mesh):
    matrix, shiny = np.diag([1.0, 1, -1, 1]), Material(specular=0.3, shininess=4)
    assert "phong" in dir(mesh)
    assert not hasattr(pv.Table({"a": np.zeros(3)}), "phong")  # it has no surface
    lit = mesh.phong.shade(SCENE, shiny, name="glow")
    framed = scene_for(lit, SCENE)
    np.testing.assert_array_equal(lit["glow"], ph.evaluate(lit.points, lit.phong.normals(), framed, shiny).rgb)
    assert str(mesh.phong.diagnose(matrix=matrix)) == str(ph.diagnose(mesh, matrix=matrix))
    plans = mesh.phong.plan(SCENE, shiny, tolerance=0.01), ph.plan(mesh, SCENE, shiny, tolerance=0.01)
    assert plans[0].explain() == plans[1].explain()


def test_a_type_checker_sees_the_names_that_there_are():
    """`__init__` lists each name twice: as an import for type checkers, and in the table of lazy imports."""
    source = ast.parse(Path(ph.__file__).read_text())
    imports = [node for node in ast.walk(source) if isinstance(node, ast.ImportFrom) and node.module != "importlib"]
    seen = {alias.asname: f"{node.module}.{alias.name}" for node in imports for alias in node.names if alias.asname}
    places = {name: f"pvphong.{place}.{name}" for name, place in ph._PLACE_OF.items()}
    assert places | {"pipeline": "pvphong.pipeline"} == {name: seen[name] for name in seen if name != "_host"}
    assert dir(ph) == ph.__all__


MESH, BLOCKS = type(pv.Sphere().phong), type(pv.MultiBlock().phong)
METHODS = [name for name in vars(MESH) if not name.startswith("_")]


@pytest.mark.parametrize("name", METHODS)
def test_blocks_take_what_a_mesh_takes(name):
    """Methods of a mesh take the options of the function that they call."""
    of_mesh, of_blocks = (
        list(inspect.signature(getattr(kind, name)).parameters.values())[1:] for kind in (MESH, BLOCKS)
    )
    assert of_mesh == of_blocks
    function = {"refine": refine.refine, "interpolation_error": refine.interpolation_error}.get(name)
    function = function or getattr(ph, name, None)
    if function is not None:
        taken = list(inspect.signature(function).parameters)[1:]
        assert [p.name for p in of_mesh] == taken


OPTIONS = {"matrix", "feature_angle", "occluders", "visibility", "transport", "tolerance", "precision", "backend"}
INSIDE = "it casts rays inside of triangles too, and no visibility is of there"
IN_FLOAT64 = "errors are those of the formulas, in float64 by NumPy"
DIRECT = "it is of direct light"
NOT_VTKS = "VTK's shader has no shadows, and its light does not bounce"
MEASURED = "each of them is a row that is measured"
IN_ITSELF = "it looks at points and faces as they are, and lights nothing"
SHOWN = "it shows colours that are there already"
WITHOUT = {
    "shade": {},
    "plan": dict.fromkeys(("precision", "backend"), "nothing is computed; a plan is the same for all"),
    "refine": {"visibility": INSIDE, "backend": IN_FLOAT64},
    "interpolation_error": {"visibility": INSIDE}
    | dict.fromkeys(("precision", "backend"), IN_FLOAT64)
    | {"tolerance": "it is the error itself that is asked for"},
    "validate": dict.fromkeys(("occluders", "visibility", "transport"), NOT_VTKS)
    | {"precision": "VTK's shader computes in float32", "tolerance": "an approximation is no error of the formulas"},
    "tradeoff": dict.fromkeys(("precision", "backend"), MEASURED) | {"transport": DIRECT},
    "transport": {"transport": "it is what comes out", "visibility": "it is of all directions"}
    | dict.fromkeys(("tolerance", "precision", "backend"), "it is rays, as many as are asked for"),
    "visibility": {"visibility": "it is what comes out", "transport": "it is of lights and sky"}
    | dict.fromkeys(("precision", "backend"), "rays are cast in one way, Embree's or VTK's"),
    "truth": dict.fromkeys(("visibility", "transport"), "its rays are its own")
    | {"tolerance": "its samples say how well it is known"}
    | dict.fromkeys(("precision", "backend"), "it computes in one way, in float64"),
    "irradiance": {},
    "daylight": dict.fromkeys(("visibility", "transport"), "its coefficients are kept for other weathers")
    | {"tolerance": "it is rays, as many as are asked for"}
    | dict.fromkeys(("precision", "backend"), "it computes in one way, in float64"),
    "normals": dict.fromkeys(("occluders", "visibility", "transport", "tolerance"), "no light falls on them")
    | {"precision": "they are of the points' own"},
    "diagnose": dict.fromkeys(OPTIONS - {"matrix"}, IN_ITSELF),
    "plot": dict.fromkeys(OPTIONS, SHOWN),
    "color_view": dict.fromkeys(OPTIONS, SHOWN),
    "save": dict.fromkeys(OPTIONS, SHOWN),
    "fit": {"precision": "columns of least squares are in float64"},
}
"""Method → option that it does not take → why."""


@pytest.mark.parametrize("name", METHODS)
def test_options_are_those_of_every_call_but_for_a_reason(name):
    """Options that several functions share have the same default, except `tolerance`."""
    taken, of_shade = (inspect.signature(getattr(MESH, each)).parameters for each in (name, "shade"))
    assert OPTIONS - taken.keys() == WITHOUT[name].keys()
    for option in OPTIONS & taken.keys() - {"tolerance"}:
        assert (taken[option].default, taken[option].kind) == (of_shade[option].default, of_shade[option].kind), option


BARE = pv.Plane(i_resolution=2, j_resolution=2)
BARE.clear_data()
WRONG = [
    ("scene", "sun", "scene must be a Scene, a light, or a sequence of lights; got sun"),
    ("material", "gld", "material must be a Material or the name of a material; got gld. Did you mean 'gold'"),
    ("material", Material(albedo="no array"), "albedo must be the name of a point array .*; got 'no array'"),
    (
        "material",
        Material(albedo=np.ones((5, 3))),
        "albedo must be an array with one row per point, 9 rows; got 5 rows",
    ),
    ("material", Material(albedo=np.ones((9, 4), np.uint8)), "albedo must be .*Leave out the opacity"),
    ("matrix", np.eye(3), "matrix must be a 4x4 matrix of real numbers; got an array of shape"),
    ("feature_angle", 181, "feature_angle must be a finite number >= 0 and <= 180; got 181"),
    ("tolerance", -1, "tolerance must be a finite number >=? 0; got -1"),
    ("precision", "half", "precision must be one of 'float32', 'float64'; got half"),
    ("backend", "gpu", "backend must be one of 'auto', 'numpy', 'numba'; got gpu"),
    ("name", "", "name must be a nonempty string"),
    ("components", "yes", "components must be True or False; got yes"),
    ("seconds", 0, "seconds must be a finite number > 0; got 0"),
]
LIGHTING = [name for name in METHODS if WITHOUT[name].get("backend") != SHOWN]


@pytest.mark.parametrize("name", LIGHTING)
def test_what_is_wrong_is_refused_by_name(name):
    taken = inspect.signature(getattr(MESH, name)).parameters
    given = {"scene": Scene(SCENE.lights, ph.Viewer(position=(1, 2, 3))), "tolerance": 0.1}
    given |= {"times": "2026-06-21T10:00Z", "place": ph.Place(48.14, 11.58)}
    given |= {"material": Material(), "target": 0.5, "vary": "intensity"}
    given = {option: value for option, value in given.items() if option in taken}
    for option, bad, message in (row for row in WRONG if row[0] in taken):
        for what in (BARE, pv.MultiBlock({"a": BARE})):
            with pytest.raises(ValueError, match=rf"^(block \['a'\]: )?{message}"):
                getattr(what.phong, name)(**given | {option: bad})
    if name != "diagnose":
        with pytest.raises(ValueError, match=r"^mesh must be a mesh with faces"):
            getattr(pv.PolyData(np.eye(3)).phong, name)(**given)


def test_every_option_reaches_each_block():
    """Each block's result equals that of the mesh alone, in the common scene."""
    ball = pv.Sphere(theta_resolution=8, phi_resolution=8)
    ball["tint"], ball["rough"] = np.linspace(0.2, 1, 3 * ball.n_points).reshape(-1, 3), np.full(ball.n_points, 0.3)
    blocks, matrix = pv.MultiBlock({"ball": ball, "gap": None}), np.diag([1, 1, 2.0, 1])
    framed, rough = scene_for(blocks, SCENE, matrix), ph.GGX("rough")
    metal, tinted = Material(specular=0.5, albedo="tint", reflectance=rough), Material(albedo="tint")
    common = {"matrix": matrix, "feature_angle": 20}
    options = {
        "shade": (common | {"name": "lit", "components": True}, metal),
        "plan": (common | {"tolerance": 0.01}, metal),
        "refine": (common | {"tolerance": 0.02, "max_points": 500, "name": "lit"}, tinted),
        "interpolation_error": (common, tinted),
        "validate": (common | {"backend": "numpy"}, Material()),
    }
    options["refine"][0].update(placement="smooth", precision="float64")
    for name, (how, material) in options.items():
        found, alone = getattr(blocks.phong, name)(SCENE, material, **how), getattr(ball.phong, name)
        expected = alone(framed, material, **how)
        if isinstance(found, dict):
            assert list(found) == ["ball"]
            assert str(found["ball"]) == str(expected)
        else:
            assert (found.keys(), found["gap"]) == (["ball", "gap"], None)
            assert found["ball"] == expected
    for how in ({"matrix": matrix}, {"weighting": "area", "backend": "numpy"}):
        normals = blocks.phong.normals(**how)["ball"].point_data.active_normals
        np.testing.assert_array_equal(normals, ball.phong.normals(**how))
    shadows = Scene([*SCENE.lights, PointLight(frame="headlight")], light_model=ph.LightModel(shadows=True))
    how = {"matrix": matrix, "samples": 4, "occluders": [pv.Plane(center=(2, 2, 3))]}
    seen = blocks.phong.visibility(shadows, **how)
    lit = blocks.phong.shade(shadows, visibility=seen, matrix=matrix)
    alone = ball.phong.visibility(framed := scene_for(blocks, shadows, matrix), **how)
    assert lit["ball"] == ball.phong.shade(framed, visibility=alone, matrix=matrix)
    with pytest.raises(TypeError, match=r"^plan takes no 'rougness'\. Did you mean 'roughness'\? Use Material\("):
        blocks.phong.plan(SCENE, rougness=0.5)


@pytest.mark.parametrize("feature_angle", [None, 30])
@pytest.mark.parametrize("name", ["shade", "plan", "refine", "interpolation_error", "validate", "tradeoff"])
def test_tangents_that_nothing_reads_change_nothing(name, feature_angle):
    cube = pv.Cube().triangulate().subdivide(1)
    cube["grain"] = np.ones((cube.n_points, 3))
    how = {"refine": {"tolerance": 0.1}, "tradeoff": {"seconds": 0.1}}.get(name, {}) | {"feature_angle": feature_angle}
    ask = getattr(cube.phong, name)
    without, *others = (
        ask(SCENE, Material(tangents=tangents), **how) for tangents in (None, "grain", np.asarray(cube["grain"]))
    )
    assert name == "tradeoff" or all(one == without or str(one) == str(without) for one in others)  # it has times


def test_a_viewer_who_frames_blocks_sees_them_where_their_matrix_puts_them():
    ball, matrix = pv.Sphere(), np.diag([2.0, 1, 1, 1])
    matrix[0, 3] = 10.0
    blocks = pv.MultiBlock({"one": ball, "gap": None, "two": ball.translate((3, 0, 0))})
    viewer = scene_for(blocks, SCENE, matrix).viewer
    assert viewer == scene_for(blocks.combine(), SCENE, matrix).viewer
    assert viewer != scene_for(blocks, SCENE).viewer


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
    for names in (("a",), ("a", "b", "four")):
        with pytest.raises(ValueError, match=r"^material must be a mapping with the names of all blocks"):
            plain.shade(SCENE, dict.fromkeys(names, mirror))
    compared = plain.validate(SCENE, given)
    assert [part.passed for part in compared.values()] == [True, True]
    assert not np.array_equal(compared["a"].pvphong, compared["b"].pvphong)


def test_what_accuracy_costs_is_measured_on_blocks_whose_sharp_edges_are_split():
    box = pv.Cube().clean()
    box.clear_data()
    report = pv.MultiBlock([box, box.translate((2, 0, 0))]).phong.tradeoff(SCENE, seconds=0.1, feature_angle="auto")
    assert report.surface.n_points == 48


def test_a_table_among_blocks_stays_and_nothing_minds_it():
    table = pv.Table({"x": np.zeros(3)})
    blocks, dark = pv.MultiBlock({"ball": pv.Sphere(), "table": table}), ph.LightModel(shadows=True)
    lit = blocks.phong.shade()
    assert (lit["table"], lit.keys()) == (table, blocks.keys())
    np.testing.assert_array_equal(lit["ball"]["phong"], pv.Sphere().phong.shade()["phong"])
    assert list(blocks.phong.plan()) == ["ball"]
    pv.Sphere().phong.shade(Scene(SCENE.lights, light_model=dark), occluders=[blocks])
    lit.phong.plot(off_screen=True)


def test_errors_name_the_block():
    """The faulty block lacks an array that the material names, or has nothing to light."""
    plain, tinted = pv.Sphere(), pv.Sphere()
    tinted["tint"] = np.ones((tinted.n_points, 3), np.uint8)
    blocks, material = pv.MultiBlock({"a": tinted, "in": pv.MultiBlock({"b": plain})}), Material(albedo="tint")
    for name in ("shade", "plan", "truth", "validate", "refine"):
        given = {"refine": {"tolerance": 0.1}, "truth": {"samples": 16}}.get(name, {})
        with pytest.raises(ValueError, match=r"^block \['in'\]\['b'\]: albedo must be"):
            getattr(blocks.phong, name)(SCENE, material, **given)
    blocks["in"]["b"] = pv.PolyData(np.eye(3))
    for name in ("visibility", "transport", "normals"):
        with pytest.raises(ValueError, match=r"^block \['in'\]\['b'\]: mesh must be"):
            getattr(blocks.phong, name)()


def test_every_block_has_its_own_plan_and_diagnosis_where_names_are_shared_or_missing():
    car = pv.MultiBlock()
    planes = [pv.Plane(i_resolution=size) for size in range(1, 7)]
    for plane, name in zip(planes, ("wheel", "wheel", "hood"), strict=False):
        car.append(plane, name)
    blocks = pv.MultiBlock()
    blocks.append(car, "car")
    blocks.append(planes[3], "car/hood")
    nameless = vtk.vtkMultiBlockDataSet()
    nameless.SetBlock(0, planes[4])
    nameless.SetBlock(1, planes[5])
    blocks.append(pv.wrap(nameless), "rest")
    paths = ["car/wheel [0][0]", "car/wheel [0][1]", "car/hood [0][2]", "car/hood [1]", "rest/0", "rest/1"]
    assert list(blocks.phong.plan(SCENE)) == paths
    sizes = [block.n_cells for _, block in datasets(blocks)]
    assert sizes == [10, 20, 30, 40, 50, 60]
    assert list(blocks.phong.diagnose()) == paths


@pytest.mark.parametrize("bounces", [0, 1])
@pytest.mark.parametrize("call", ["shade", "plan", "visibility", "truth", "refine", "validate", "tradeoff"])
def test_an_option_that_no_block_takes_is_refused_before_anything_is_computed(call, bounces):
    blocks = pv.MultiBlock([pv.Sphere(), pv.Cube()])
    scene = ph.Scene([ph.DirectionalLight()], light_model=ph.LightModel(bounces=bounces))
    with pytest.raises(TypeError, match=rf"^{call} takes no 'tolerence'\."):
        getattr(blocks.phong, call)(scene, tolerence=None)
