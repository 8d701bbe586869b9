"""Section F of the catalogue of hard cases: inputs of odd types, empty, of the wrong length, nested or strided.

Row 31 is tested with meshes too. Rows 23, 26, 28 and 29 are in test_mesh_normals, row 21 as a mesh in studies/diagnose.
Of rows 50 and 52, meshes with nothing to light are in meshes/test_surfaces, and blocks in meshes/test_lit.
"""

import math
import textwrap
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from apart import run_apart
from stability.bounds import assert_bits
from stability.evaluators import EVALUATORS
from stability.hunting import LAYOUTS

import pvphong  # noqa: F401 registers mesh.phong if PyVista's entry point is not installed
from pvphong.geometry.transform import transform_normals, transform_points, transform_vectors
from pvphong.meshes.surfaces import face_normals, vertex_normals
from pvphong.optics.lights import DirectionalLight, PointLight
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading.evaluation import evaluate

COUNT = 40
RNG = np.random.default_rng(11)
POINTS, NORMALS = RNG.normal(size=(2, COUNT, 3))
WHOLE = np.round(RNG.normal(size=(COUNT, 3)) * 9) + 0.0
PARTS = WHOLE / 64.0  # valid as an albedo too
SCENE = Scene(
    lights=[DirectionalLight(direction=(-1, 2, -3)), PointLight(position=(2, 2, 2), attenuation=(1, 0.1, 0.01))],
    viewer=Viewer(position=(1, 2, 9)),
)
MATERIAL = Material(ambient=0.1, diffuse=(0.7, 0.6, 0.5), specular=0.4, shininess=12)
MATRIX = np.array([[1, 0.5, 0, 3], [0, 2, 0.1, 1], [0.2, 0, 1, -1], [0, 0, 0, 1]], float)


def takers(evaluator):
    """Return functions that pass an array to the evaluator as points, normals or albedo."""
    calls = {
        "points": lambda a: evaluator(a, NORMALS, SCENE, MATERIAL).rgb,
        "normals": lambda a: evaluator(POINTS, a, SCENE, MATERIAL).rgb,
        "albedo": lambda a: evaluator(POINTS, NORMALS, SCENE, replace(MATERIAL, albedo=a)).rgb,
    }
    return {f"{evaluator} {argument}": call for argument, call in calls.items()}


# Argument → function that takes an array for it and returns one.
TAKERS = {name: taker for evaluator in EVALUATORS for name, taker in takers(evaluator).items()} | {
    "transform_points points": lambda a: transform_points(a, MATRIX),
    "transform_vectors vectors": lambda a: transform_vectors(a, MATRIX),
    "transform_normals normals": lambda a: transform_normals(a, MATRIX),
}


def assert_refused(taker, array, message):
    with pytest.raises(ValueError, match=rf"^{taker.split()[-1]} must be {message}"):
        TAKERS[taker](array)


def assert_same(row, taker, array, expected):
    assert_bits(row, TAKERS[taker](array), TAKERS[taker](expected))


ALBEDOS = [name for name in TAKERS if name.endswith("albedo")]
every_taker = pytest.mark.parametrize("taker", TAKERS)
every_albedo = pytest.mark.parametrize("taker", ALBEDOS)


# row 49: types that are not float32 or float64


FLOATS = ["float16", "longdouble", ">f4", ">f8"]
INTEGERS = ["int8", "int32", "int64", "uint8", "uint16"]  # for albedos see row 53


@pytest.mark.parametrize(("taker", "kind"), [(t, k) for t in TAKERS for k in FLOATS + INTEGERS * (t not in ALBEDOS)])
def test_row_49_other_real_types_are_widened(taker, kind):
    rows = np.abs(PARTS if kind in FLOATS else WHOLE).astype(kind)
    assert_same(f"49 {kind}", taker, rows, rows.astype(np.float64))


NO_ROWS = [
    *(POINTS + 1j, POINTS.astype(str), POINTS.astype(object), POINTS.astype(bool)),
    *(POINTS[:, :2], POINTS[None], np.zeros((COUNT, 3), "datetime64[s]"), [[0.0, 0.0, 0.0], [1.0]]),
]
NO_VECTORS = [POINTS[:, 0], (1.0, 0.5, 0.5), "points", 3.5, None]  # some of them are valid albedos


@pytest.mark.parametrize(
    ("taker", "bad"),
    [(taker, bad) for taker in TAKERS for bad in NO_ROWS + NO_VECTORS * (taker not in ALBEDOS)],
    ids=lambda bad: f"{bad.dtype} {bad.shape}" if isinstance(bad, np.ndarray) else str(bad),
)
def test_row_49_what_is_no_array_of_rows_is_refused(taker, bad):
    assert_refused(taker, bad, r"[^;]*\(n, 3\)[^;]*; got ")


# row 50: nothing to light


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
def test_row_50_no_vertices_give_no_colours(evaluator):
    none = np.zeros((0, 3))
    assert len(evaluator(none, none, SCENE, MATERIAL).rgb) == 0


# row 51: wrong lengths


@pytest.mark.parametrize("rows", [0, 1, COUNT - 1, COUNT + 1])
@pytest.mark.parametrize(
    "taker", [name for name in TAKERS if name.endswith(("normals", "albedo")) and "transform" not in name]
)
def test_row_51_both_lengths_are_told(taker, rows):
    assert_refused(taker, np.resize(NORMALS, (rows, 3)), rf".*{COUNT} rows; got {rows} rows\.$")


# row 53: albedos out of range


@pytest.mark.parametrize(
    ("odd", "counts_as"),
    [(math.nan, 0.0), (-1.0, 0.0), (-0.0, 0.0), (1.0 + 2**-10, 1.0), (-math.inf, 0.0), (1.0, 1.0)],
)
@pytest.mark.parametrize("stored", ["float16", "float32", "float64", "longdouble"])
@every_albedo
def test_row_53_floats_are_clipped_and_nan_is_0(taker, odd, counts_as, stored):
    albedo = RNG.uniform(size=(COUNT, 3)).astype(stored)
    clean = albedo.copy()
    albedo[5], clean[5] = odd, counts_as
    rgb = TAKERS[taker](albedo)
    assert np.isfinite(rgb).all()
    assert 0.0 <= rgb.min() <= rgb.max() <= 1.0
    assert_same(f"53 {odd}", taker, albedo, clean)


@every_albedo
def test_row_53_0_to_255_is_what_uint8_means(taker):
    steps = np.arange(3 * COUNT, dtype=np.uint8).reshape(COUNT, 3) * 2
    assert_same("53 uint8", taker, steps, steps / 255.0)


def one_is(most):
    rows = RNG.uniform(size=(COUNT, 3))
    rows[5, 1], rows[7] = most, math.nan
    return rows


NO_ALBEDOS = [
    *((one_is(most), "floats from 0 to 1; got floats up to .*Divide 0-255 values") for most in (1.01, 300.0, math.inf)),
    # 0-255 in an int64 array would be clipped to white.
    *((np.full((COUNT, 3), 120, kind), ".*(uint8|255)") for kind in INTEGERS if kind != "uint8"),
    *((np.ones((COUNT, 4), kind), ".*Leave out the opacity") for kind in (float, "uint8")),
]


@pytest.mark.parametrize(("bad", "message"), NO_ALBEDOS)
@every_albedo
def test_row_53_what_is_no_albedo_is_refused(taker, bad, message):
    assert_refused(taker, bad, message)


# row 55: memory and cell normals


@every_taker
@pytest.mark.parametrize("layout", [*LAYOUTS, "list"])
def test_row_55_memory_layout_changes_no_bit(taker, layout):
    rows = PARTS.tolist() if layout == "list" else LAYOUTS[layout](PARTS)
    np.testing.assert_array_equal(rows, PARTS)
    assert_same(f"55 {layout}", taker, rows, PARTS)


@pytest.mark.parametrize("mesh", [pv.Box().triangulate(), pv.Sphere()], ids=["box", "sphere"])
def test_row_55_cell_normals_are_not_read(mesh):
    """Vertices are lit, not faces: their normals are computed from the adjacent faces."""
    mesh = mesh.copy()
    mesh.clear_data()
    wrong = -face_normals(mesh)
    mesh.cell_data["Normals"] = wrong
    mesh.cell_data.active_normals_name = "Normals"
    expected = evaluate(mesh.points, vertex_normals(mesh), SCENE, MATERIAL).rgb
    assert_bits("55 cell normals", mesh.phong.shade(SCENE, MATERIAL)["phong"], expected)
    np.testing.assert_array_equal(mesh.cell_data["Normals"], wrong)


# rows 20 and 21 for grids with computed points


@pytest.mark.parametrize("kind", ["ImageData", "RectilinearGrid", "StructuredGrid"])
@pytest.mark.parametrize("offset", [1e3, 1e6, 1e8])
def test_a_grid_far_from_the_origin_is_lit_as_near_it(kind, offset):
    """A grid's coordinates are float64; in float32 its faces would collapse at 1e8."""
    sun = Scene(lights=[DirectionalLight(direction=(-1, -2, -3))], viewer=Viewer(position=(offset, offset, 2 * offset)))
    near = pv.ImageData(dimensions=(5, 5, 5), spacing=(0.25, 0.25, 0.25))
    far = near.copy()
    far.origin = (offset, offset, offset)
    if kind != "ImageData":
        cast = "cast_to_rectilinear_grid" if kind == "RectilinearGrid" else "cast_to_structured_grid"
        near, far = getattr(near, cast)(), getattr(far, cast)()
    lit, expected = (mesh.phong.shade(sun, precision="float64") for mesh in (far, near))
    assert np.ptp(expected["phong"]) > 0.3
    np.testing.assert_allclose(lit["phong"], expected["phong"], atol=1e-6)


# row 31: indices out of range

CRASHERS = {
    "face 9 of 3": ("pv.PolyData(points[:3], faces=[3, 0, 1, 9])", "index 9 in face 0"),
    "face -1": ("pv.PolyData(points[:3], faces=[3, 0, 1, 2, 3, 0, 1, -1])", "index -1 in face 1"),
    "face 1e9": ("pv.PolyData(points, faces=[3, 0, 1, 10**9])", "index 1000000000 in face 0"),
    "strip": ("pv.PolyData(points, strips=[4, 0, 1, 2, 10**9])", "index 1000000000 in strip 0"),
    "line": ("pv.PolyData(points, lines=[2, 0, 10**9])", "index 1000000000 in line 0"),
    "vertex": ("pv.PolyData(points, verts=[1, 10**9])", "index 1000000000 in vertex 0"),
    "tetrahedron": ("pv.UnstructuredGrid([4, 0, 1, 2, 10**9], [10], points)", "index 1000000000 in cell 0"),
    "too few points": ("pv.UnstructuredGrid([2, 0, 1], [10], points)", "cell 0 with 2 points, but its type needs 4"),
    "3 as a solid": ("pv.UnstructuredGrid([3, 0, 1, 2], [41], points)", "cell 0, a convex point set"),
    "5 in a plane": (
        "pv.UnstructuredGrid([5, 0, 1, 2, 3, 4], [41], points * (1, 1, 0))",
        "cell 0, a convex point set",
    ),
    "a nearly flat hull": (
        "pv.UnstructuredGrid([4, 0, 1, 2, 3], [41], np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0.3, 0.3, 0.01)]))",
        "cell 0, a convex point set",
    ),
    "polyhedron": ("polyhedron()", "index 1000000000 in polyhedron face 1"),
    "explicit grid": ("explicit()", "index 1000000000 in cell 0"),
}
DIMENSIONS = ("structured()", "got 6 points in dimensions (100, 100, 100)")

PRELUDE = """
import numpy as np, pyvista as pv
from vtkmodules.util.numpy_support import vtk_to_numpy
from pyvista import examples
from pvphong.studies.diagnose.diagnosis import diagnose
from pvphong.meshes.surfaces import surface, vertex_normals, face_normals, polygons

points = np.random.default_rng(1).random((6, 3))

def polyhedron():
    mesh = examples.cells.Polyhedron()
    vtk_to_numpy(mesh.GetPolyhedronFaces().GetConnectivityArray())[3] = 10**9
    return mesh

def explicit():
    mesh = pv.ImageData(dimensions=(3, 3, 3)).cast_to_structured_grid().cast_to_explicit_structured_grid()
    vtk_to_numpy(mesh.GetCells().GetConnectivityArray())[3] = 10**9
    return mesh

def structured():
    mesh = pv.StructuredGrid()
    mesh.points = points
    mesh.dimensions = (100, 100, 100)
    return mesh
"""


def test_row_31_every_broken_mesh_is_refused_and_diagnosed_without_a_crash():
    code = f"""
    for name, (mesh, message) in {CRASHERS!r}.items():
        mesh = eval(mesh)
        for call in (surface, vertex_normals, face_normals):
            try:
                call(mesh)
            except ValueError as error:
                assert message in str(error), (name, call, str(error))
            else:
                raise AssertionError((name, call))
        found = diagnose(mesh)
        assert found.invalid_cells.tolist() == [1 if "-1" in name else 0], (name, found.invalid_cells)
        assert not found.ok and "invalid_cells" in str(found)
        assert found.to_mesh().n_points > 0
    for call in (surface, diagnose):
        try:
            call(eval({DIMENSIONS[0]!r}))
        except ValueError as error:
            assert {DIMENSIONS[1]!r} in str(error), str(error)
        else:
            raise AssertionError(call)
    print("still alive")
    """
    assert run_apart(PRELUDE + textwrap.dedent(code)) == "still alive\n"
