"""Lit meshes: which points, normals and albedo are read, which arrays are written, and that inputs stay as they are."""

import dataclasses

import numpy as np
import pytest
import pyvista as pv

import pvphong  # noqa: F401 registers mesh.phong wherever PyVista's own discovery is not installed
from pvphong.meshes.lit import map_blocks, point_normals, shade_mesh
from pvphong.meshes.surfaces import vertex_normals
from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.optics.material import Material
from pvphong.scene.scene import LightModel, Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading.evaluation import evaluate

SCENE = Scene(
    lights=[
        DirectionalLight(direction=(-1, 0.5, -1), diffuse=(0.9, 0.8, 0.7), name="sun"),
        PointLight(position=(2, -1, 3), attenuation=(0.5, 0.1, 0.02)),
        SpotLight(position=(0, 4, 1), direction=(0, -1, 0), cone_angle=40, name="lamp", on=False),
    ],
    viewer=Viewer(position=(1, 2, 6)),
)
MATERIAL = Material(ambient=0.1, diffuse=(0.7, 0.6, 0.5), specular=0.4, shininess=12, emission=(0, 0.02, 0))
MATRIX = np.array([[1, 0.5, 0, 3], [0, 2, 0.1, 1], [0.2, 0, 1, -1], [0, 0, 0, 1]], float)


def bits(array):
    return np.ascontiguousarray(array).tobytes()


def ball():
    """A sphere with point normals, and some arrays."""
    mesh = pv.Sphere(theta_resolution=12, phi_resolution=9)
    mesh["height"] = mesh.points[:, 2].copy()
    mesh.cell_data["patch"] = np.arange(mesh.n_cells)
    mesh.add_field_data(np.array([1.5]), "release")
    return mesh


def bare(mesh):
    """A copy without normals."""
    mesh = mesh.copy()
    mesh.point_data.clear()
    return mesh


def grid():
    return pv.ImageData(dimensions=(4, 5, 6), spacing=(0.3, 0.2, 0.1), origin=(1, 2, 3))


MESHES = {
    "PolyData": lambda: bare(ball()),
    "UnstructuredGrid": lambda: grid().cast_to_unstructured_grid(),
    "ImageData": grid,
    "StructuredGrid": lambda: grid().cast_to_structured_grid(),
    "RectilinearGrid": lambda: grid().cast_to_rectilinear_grid(),
}
every_mesh = pytest.mark.parametrize("kind", MESHES)


def with_arrays(mesh):
    mesh = mesh.copy()
    mesh.point_data["number"] = np.arange(mesh.n_points)
    mesh.point_data["tint"] = np.random.default_rng(0).uniform(size=(mesh.n_points, 3))
    mesh.cell_data["patch"] = np.arange(mesh.n_cells)
    mesh.set_active_scalars("number")
    return mesh


def state(mesh):
    """Every bit of a mesh, and when VTK last saw it changed."""
    result = {
        "mtime": mesh.GetMTime(),
        "scalars": mesh.active_scalars_name,
        "normals": mesh.point_data.active_normals_name,
    }
    result["points"] = bits(mesh.points)
    for place in ("point_data", "cell_data", "field_data"):
        data = getattr(mesh, place)
        result[place] = {key: (str(data[key].dtype), data[key].shape, bits(data[key])) for key in data}
    if isinstance(mesh, pv.PolyData):
        result["cells"] = [bits(a) for a in (mesh.verts, mesh.lines, mesh.faces, mesh.strips)]
    if isinstance(mesh, pv.UnstructuredGrid):
        result["cells"] = [bits(mesh.cells), bits(mesh.celltypes)]
    return result


def own_colors(lit, **options):
    """What `evaluate` gives for the mesh's points and angle-weighted normals."""
    return evaluate(lit.points, vertex_normals(lit), SCENE, MATERIAL, **options).rgb


# --- every dataset with a surface ---


@every_mesh
def test_a_lit_surface_of_every_dataset(kind):
    mesh = MESHES[kind]()
    lit = mesh.phong.shade(SCENE, MATERIAL)
    assert type(mesh).__name__ == kind
    assert type(lit) is pv.PolyData
    assert lit.n_cells == mesh.extract_surface(algorithm="dataset_surface").n_cells
    assert (lit["phong"].shape, lit["phong"].dtype) == ((lit.n_points, 3), np.float32)
    assert (lit["phong"].min(), lit["phong"].max()) >= (0, 0)
    assert lit["phong"].max() <= 1
    assert np.ptp(lit["phong"]) > 0.1
    assert bits(lit["phong"]) == bits(own_colors(lit))
    assert lit.active_scalars_name == "phong"


@every_mesh
def test_arrays_are_carried_along(kind):
    mesh = with_arrays(MESHES[kind]())
    lit = mesh.phong.shade(SCENE)
    np.testing.assert_allclose(mesh.points[lit["number"]], lit.points, rtol=2.0**-23)  # float32, of VTK's making
    np.testing.assert_array_equal(mesh["tint"][lit["number"]], lit["tint"])
    assert len(lit.cell_data["patch"]) == lit.n_cells
    centers = mesh.cell_centers().points[lit.cell_data["patch"]]
    assert np.linalg.norm(centers - lit.cell_centers().points, axis=1).max() < 0.3  # each beside its own cell


@every_mesh
@pytest.mark.parametrize("options", [{}, {"albedo": "tint"}, {"components": True}, {"matrix": MATRIX}], ids=str)
def test_the_input_is_not_modified(kind, options):
    mesh = with_arrays(MESHES[kind]())
    before = state(mesh)
    if "albedo" in options:
        mesh.phong.shade(SCENE, MATERIAL, albedo=mesh["tint"].copy())
    lit = mesh.phong.shade(SCENE, MATERIAL, **options)
    mesh.phong.normals()
    lit.points[:] += 1
    lit["number"][:] = 0
    lit["phong"][:] = 0
    assert state(mesh) == before


def test_the_scene_and_material_are_checked():
    with pytest.raises(ValueError, match=r"^scene must be a Scene; .*Scene\(lights"):
        ball().phong.shade([DirectionalLight()])
    with pytest.raises(ValueError, match=r"^material must be a Material"):
        ball().phong.shade(SCENE, "gold")


def test_the_default_material_is_opengls():
    assert bits(ball().phong.shade(SCENE)["phong"]) == bits(ball().phong.shade(SCENE, Material())["phong"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"name": ""}, "^name must be a string that is not empty"),
        ({"name": 3}, "^name must be a string that is not empty"),
        ({"precision": "half"}, "^precision must be one of"),
        ({"backend": "gpu"}, "^backend must be one of"),
        ({"tolerance": -1}, "^tolerance must be a finite number >= 0"),
        ({"components": "yes"}, "^components must be True or False"),
        ({"matrix": np.eye(3)}, "^matrix must be a 4x4 matrix"),
        ({"albedo": "no such array"}, "^albedo must be one of 'Normals', 'height'; got no such array"),
        ({"albedo": "heigth"}, "^albedo must be .* Did you mean 'height'"),
        ({"albedo": "height"}, r"^albedo must be an \(n, 3\) array of real numbers; got an array of shape"),
        ({"albedo": np.ones((5, 3))}, r"^albedo must be .*one row per point, 86 rows; got 5 rows"),
    ],
)
def test_options_are_refused_by_name(options, message):
    with pytest.raises(ValueError, match=message):
        ball().phong.shade(SCENE, MATERIAL, **options)


# --- names, components ---


def test_the_name_is_that_of_the_array():
    lit = ball().phong.shade(SCENE, MATERIAL, name="glow", components=True)
    assert "phong" not in lit.point_data
    assert {"glow", "glow_ambient", "glow_light_sun", "glow_base"} <= set(lit.point_data.keys())
    assert lit.active_scalars_name == "glow"


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("count", [0, 1, 3])
def test_components(precision, count):
    model = LightModel(clamp=False)
    scene = dataclasses.replace(SCENE, lights=SCENE.lights[:count], light_model=model)
    lit = ball().phong.shade(scene, MATERIAL, components=True, precision=precision)
    names = [name for name in lit.point_data if name.startswith("phong")]
    parts = ["phong_ambient", "phong_diffuse", "phong_specular", "phong_emission"]
    shares = ["phong_light_sun", "phong_light_1", "phong_light_lamp"][:count]
    assert set(names) == {"phong", "phong_base", *parts, *shares}
    assert {str(lit[name].dtype) for name in names} == {precision}
    atol = 8 * np.finfo(precision).eps
    np.testing.assert_allclose(sum(lit[part] for part in parts), lit["phong"], rtol=0, atol=atol)
    np.testing.assert_allclose(sum((lit[s] for s in shares), lit["phong_base"]), lit["phong"], rtol=0, atol=atol)


def test_each_lights_array_is_its_own_share():
    lit = ball().phong.shade(SCENE, MATERIAL, components=True)
    shares = evaluate(lit.points, lit["Normals"], SCENE, MATERIAL, components=True).per_light
    for name, share in zip(["sun", "1", "lamp"], shares, strict=True):
        assert bits(lit[f"phong_light_{name}"]) == bits(share)


# --- normals ---


def test_active_point_normals_are_used_as_they_are():
    mesh = ball()
    odd = np.random.default_rng(3).normal(size=(mesh.n_points, 3)) * 5
    mesh.point_data.active_normals = odd
    assert bits(mesh.phong.normals()) == bits(odd)
    assert bits(mesh.phong.shade(SCENE, MATERIAL)["phong"]) == bits(evaluate(mesh.points, odd, SCENE, MATERIAL).rgb)


def test_active_point_normals_of_another_name_are_used():
    mesh = ball()
    odd = np.random.default_rng(3).normal(size=(mesh.n_points, 3))
    mesh.point_data["bent"] = odd
    mesh.point_data.active_normals_name = "bent"
    assert bits(mesh.phong.shade(SCENE, MATERIAL)["phong"]) == bits(evaluate(mesh.points, odd, SCENE, MATERIAL).rgb)


def test_without_normals_they_are_weighted_by_angle():
    box = pv.Box().triangulate()  # of a cube's corner the area-weighted normal is 19° off (row 27)
    box = box.clean()
    assert box.point_data.active_normals is None
    expected = np.sign(box.points) / np.sqrt(3)
    np.testing.assert_allclose(box.phong.normals(), expected, atol=1e-15)
    colors = evaluate(box.points, expected, SCENE, MATERIAL, precision="float64").rgb
    lit = box.phong.shade(SCENE, MATERIAL, precision="float64")
    np.testing.assert_allclose(lit["phong"], colors, atol=1e-14)
    assert lit.point_data.active_normals is None


@pytest.mark.parametrize("kind", ["StructuredGrid", "UnstructuredGrid"])
def test_normals_of_a_grid_are_carried_to_its_surface(kind):
    mesh = with_arrays(MESHES[kind]())
    odd = np.random.default_rng(4).normal(size=(mesh.n_points, 3))
    mesh.point_data.active_normals = odd
    lit = mesh.phong.shade(SCENE, MATERIAL)
    assert bits(lit["phong"]) == bits(evaluate(lit.points, odd[lit["number"]], SCENE, MATERIAL).rgb)


@pytest.mark.parametrize("weighting", ["angle", "area", "max"])
def test_normals_of_a_weighting_are_computed_whatever_is_stored(weighting):
    mesh = ball()
    np.testing.assert_array_equal(mesh.phong.normals(weighting), vertex_normals(mesh, weighting))
    assert bits(point_normals(mesh)) == bits(mesh["Normals"])


def test_normals_under_a_matrix():
    mesh = bare(ball())
    cofactors = np.linalg.inv(MATRIX[:3, :3]).T
    expected = mesh.phong.normals() @ cofactors.T
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(mesh.phong.normals(matrix=MATRIX), expected, atol=1e-14)


def test_normals_refuse_another_weighting():
    with pytest.raises(
        ValueError, match=r"^weighting must be one of 'angle', 'area', 'max'; got angel. Did you mean 'angle'"
    ):
        ball().phong.normals("angel")


# --- the matrix ---


def test_the_matrix_lights_as_a_transformed_mesh_would_be():
    mesh = bare(ball())  # turned and scaled evenly, so that no angle between edges changes
    matrix = np.array([[0, -2, 0, 3], [2, 0, 0, 1], [0, 0, 2, -1], [0, 0, 0, 1]], float)
    lit = mesh.phong.shade(SCENE, MATERIAL, matrix=matrix, precision="float64")
    moved = mesh.transform(matrix, inplace=False)
    again = moved.phong.shade(SCENE, MATERIAL, precision="float64")
    assert bits(lit.points) == bits(mesh.points)
    assert np.abs(again.points - lit.points).max() > 1
    np.testing.assert_allclose(lit["phong"], again["phong"], atol=1e-5)  # moved points and their normals are float32's


def test_the_matrix_of_an_actor():
    actor = pv.Actor()
    actor.SetUserMatrix(pv.vtkmatrix_from_array(MATRIX))
    lit = [
        ball().phong.shade(SCENE, MATERIAL, matrix=m)["phong"] for m in (actor.user_matrix, actor.GetMatrix(), MATRIX)
    ]
    assert bits(lit[0]) == bits(lit[1]) == bits(lit[2])


# --- the albedo ---


def shades_of(mesh):
    return np.random.default_rng(9).integers(0, 256, (mesh.n_points, 3)).astype(np.uint8)


@every_mesh
def test_an_albedo_is_carried_to_the_surface(kind):
    mesh = with_arrays(MESHES[kind]())
    mesh["shade"] = shades_of(mesh)
    by_name = mesh.phong.shade(SCENE, MATERIAL, albedo="shade")
    by_array = mesh.phong.shade(SCENE, MATERIAL, albedo=shades_of(mesh))
    expected = own_colors(by_name, albedo=shades_of(mesh)[by_name["number"]])
    assert bits(by_name["phong"]) == bits(by_array["phong"]) == bits(expected)
    assert set(by_array.point_data.keys()) == set(by_name.point_data.keys())  # none left over from carrying it


@every_mesh
@pytest.mark.parametrize("bad", [np.ones((3, 3)), [[0.5, 0.5, 0.5]]])
def test_an_albedo_of_another_length_tells_both(kind, bad):
    mesh = MESHES[kind]()
    with pytest.raises(ValueError, match=rf"^albedo must be .*{mesh.n_points} rows; got {len(bad)} rows"):
        mesh.phong.shade(SCENE, albedo=bad)


@every_mesh
@pytest.mark.parametrize(
    "make",
    [
        lambda _: 0.5,
        lambda n: np.ones(n),
        lambda n: np.ones((n, 2)),
        lambda n: np.ones((n, 4)),
        lambda n: np.array([["a"] * 3] * n),
        lambda n: np.ones((n, 3), complex),
        lambda n: np.ones((n, 3), object),
        lambda _: [[1, 2, 3], [4]],
        lambda n: np.ones((n, 3, 3)),
    ],
    ids=["number", "flat", "two columns", "opacity", "strings", "complex", "objects", "ragged", "tensors"],
)
def test_an_albedo_that_is_none_is_refused_by_name(kind, make):
    mesh = MESHES[kind]()
    with pytest.raises(ValueError, match=r"^albedo must be "):
        mesh.phong.shade(SCENE, albedo=make(mesh.n_points))


@every_mesh
@pytest.mark.parametrize("stored", [np.float16, np.longdouble])
def test_an_albedo_of_another_float_is_widened(kind, stored):
    mesh = MESHES[kind]()
    shades = (np.arange(3 * mesh.n_points).reshape(-1, 3) % 9 / 8).astype(stored)
    wide = mesh.phong.shade(SCENE, albedo=shades.astype(np.float64))
    assert bits(mesh.phong.shade(SCENE, albedo=shades)["phong"]) == bits(wide["phong"])


# --- clouds, lines, nothing ---


def cloud():
    points = np.random.default_rng(2).normal(size=(30, 3))
    return pv.PolyData(points), points


@pytest.mark.parametrize("kind", [pv.PolyData, pv.PointSet])
def test_a_cloud_with_normals_is_lit(kind):
    _, points = cloud()
    mesh = kind(points)
    mesh.point_data.active_normals = -points
    lit = mesh.phong.shade(SCENE, MATERIAL)
    assert bits(lit["phong"]) == bits(evaluate(points, -points, SCENE, MATERIAL).rgb)
    np.testing.assert_array_equal(lit.points, points)


@pytest.mark.parametrize(
    "mesh",
    [
        cloud()[0],
        pv.PointSet(cloud()[1]),
        pv.Line(),
        pv.MultipleLines([[0, 0, 0], [1, 0, 0], [1, 1, 0]]),
        pv.UnstructuredGrid(np.array([2, 0, 1]), np.array([pv.CellType.LINE]), np.eye(3)),
    ],
    ids=["cloud", "point set", "line", "lines", "line grid"],
)
def test_without_faces_and_normals_there_is_nothing_to_light(mesh):
    with pytest.raises(ValueError, match=r"^mesh must be a mesh with faces, or points with normals; .*active_normals"):
        mesh.phong.shade(SCENE)


@pytest.mark.parametrize(
    "mesh", [pv.PolyData(), pv.UnstructuredGrid(), pv.StructuredGrid()], ids=lambda m: type(m).__name__
)
def test_an_empty_mesh_is_refused(mesh):
    with pytest.raises(
        ValueError, match=r"^mesh must be a mesh with faces, or points with normals; got .* with 0 points"
    ):
        mesh.phong.shade(SCENE)


def test_lines_with_normals_are_lit():
    line = pv.Line(resolution=5)
    line.point_data.active_normals = np.tile([0.0, 0, 1], (6, 1))
    assert line.phong.shade(SCENE)["phong"].shape == (6, 3)
    assert line.phong.shade(SCENE).n_lines == 1


@pytest.mark.parametrize("bad", [None, "mesh.vtp", pv.MultiBlock(), pv.Table({"a": np.zeros(3)})])
def test_what_is_no_dataset_is_refused(bad):
    with pytest.raises(ValueError, match=r"^mesh must be a pyvista\.DataSet; got .*"):
        shade_mesh(bad, SCENE, MATERIAL)


# --- what clipping makes of lit colours ---


def test_clipped_colours_are_linear_along_the_cut_edges():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    triangle = pv.PolyData(points, faces=[3, 0, 1, 2])
    triangle.point_data.active_normals = np.array([[0.0, 0, 1], [1, 0, 1], [0, 1, 1]])
    lit = triangle.phong.shade(SCENE, MATERIAL, precision="float64")
    start, end = lit["phong"][:2]
    assert np.abs(start - end).max() > 0.05
    cut = lit.clip("x", origin=(0.4, 0, 0))  # 40 % along the edge from point 0 to point 1
    new = np.flatnonzero(np.linalg.norm(cut.points - (0.4, 0, 0), axis=1) < 1e-7)
    assert len(new) == 1
    np.testing.assert_allclose(cut["phong"][new[0]], 0.6 * start + 0.4 * end, atol=1e-7)


def test_clipped_colours_of_a_sphere_lie_between_their_neighbours():
    lit = ball().phong.shade(SCENE, MATERIAL, precision="float64")
    edges = lit.extract_all_edges()
    cut = lit.clip("z", origin=(0, 0, 0.1), invert=False)
    fresh = np.flatnonzero(np.abs(cut.points[:, 2] - 0.1) < 1e-6)
    assert len(fresh) > 8
    ends = edges.lines.reshape(-1, 3)[:, 1:]
    a, b = edges.points[ends[:, 0]].astype(float), edges.points[ends[:, 1]].astype(float)
    colors = [edges["phong"][ends[:, side]] for side in (0, 1)]
    for index in fresh:
        p = cut.points[index].astype(float)
        along = ((p - a) * (b - a)).sum(axis=1) / ((b - a) ** 2).sum(axis=1)
        off = np.linalg.norm(a + along[:, None] * (b - a) - p, axis=1) + 9 * ((along < -1e-6) | (along > 1 + 1e-6))
        edge = int(np.argmin(off))
        assert off[edge] < 1e-6
        mixed = (1 - along[edge]) * colors[0][edge] + along[edge] * colors[1][edge]
        np.testing.assert_allclose(cut["phong"][index], mixed, atol=1e-5)


# --- blocks ---


def family():
    inner = pv.MultiBlock()
    inner.append(ball(), "deep")
    inner.append(None, "gap")
    inner.append(pv.PolyData(), "void")
    blocks = pv.MultiBlock()
    blocks.append(bare(ball()), "first")
    blocks.append(None, "nothing")
    blocks.append(inner, "inner")
    blocks.append(pv.MultiBlock(), "hollow")
    blocks.append(grid(), "grid")
    blocks.append(pv.UnstructuredGrid(), "empty grid")
    return blocks


def shape(blocks):
    """Names and kinds of blocks, nested as they are."""
    result = []
    for index, block in enumerate(blocks):
        kind = "none" if block is None else shape(block) if isinstance(block, pv.MultiBlock) else bool(block.n_points)
        result.append((blocks.get_block_name(index), kind))
    return result


def test_structure_and_names_of_blocks_are_kept():
    blocks = family()
    lit = blocks.phong.shade(SCENE, MATERIAL)
    assert shape(lit) == shape(blocks) == [
        ("first", True), ("nothing", "none"), ("inner", [("deep", True), ("gap", "none"), ("void", False)]),
        ("hollow", []), ("grid", True), ("empty grid", False),
    ]  # fmt: skip
    for name, mesh in (("first", blocks["first"]), ("grid", blocks["grid"])):
        assert bits(lit[name]["phong"]) == bits(mesh.phong.shade(SCENE, MATERIAL)["phong"])
    assert bits(lit["inner"]["deep"]["phong"]) == bits(ball().phong.shade(SCENE, MATERIAL)["phong"])


def test_blocks_without_names_and_with_the_same_name():
    nameless = pv.MultiBlock([ball(), None, ball()])
    assert shape(nameless.phong.shade(SCENE)) == shape(nameless)
    twins = pv.MultiBlock()
    twins.append(ball(), "twin")
    twins.append(ball(), "twin")
    assert shape(twins.phong.shade(SCENE)) == shape(twins)


def test_nothing_but_empty_blocks():
    assert shape(pv.MultiBlock().phong.shade(SCENE)) == []
    assert shape(pv.MultiBlock({"a": None}).phong.shade(SCENE)) == [("a", "none")]


def test_blocks_are_not_modified():
    blocks = family()
    before = [state(blocks["first"]), state(blocks["inner"]["deep"]), state(blocks["grid"]), blocks.GetMTime()]
    lit = blocks.phong.shade(SCENE, MATERIAL, components=True)
    assert [state(blocks["first"]), state(blocks["inner"]["deep"]), state(blocks["grid"]), blocks.GetMTime()] == before
    lit["inner"]["deep"].points[:] = 0
    assert state(blocks["inner"]["deep"]) == before[1]


def test_options_reach_every_block():
    blocks = pv.MultiBlock({"a": with_arrays(ball()), "b": with_arrays(grid())})
    lit = blocks.phong.shade(SCENE, MATERIAL, name="glow", albedo="tint", precision="float64", matrix=MATRIX)
    for name in ("a", "b"):
        alone = blocks[name].phong.shade(SCENE, MATERIAL, albedo="tint", precision="float64", matrix=MATRIX)
        assert bits(lit[name]["glow"]) == bits(alone["phong"])


def test_an_error_names_the_block():
    blocks = family()
    blocks["inner"].append(cloud()[0], "dust")
    with pytest.raises(ValueError, match=r"^block \['inner'\]\['dust'\]: mesh must be a mesh with faces"):
        blocks.phong.shade(SCENE)
    with pytest.raises(ValueError, match=r"^block \['grid'\]: albedo must be"):
        pv.MultiBlock({"grid": grid()}).phong.shade(SCENE, albedo="tint")


def test_normals_of_blocks():
    blocks = family()
    normals = blocks.phong.normals("area")
    assert shape(normals) == shape(blocks)
    np.testing.assert_array_equal(normals["first"].point_data.active_normals, blocks["first"].phong.normals("area"))


def test_a_table_among_the_blocks_is_refused_by_name_or_kept():
    """A file of blocks may bring a table along; there is nothing on it to light."""
    blocks = pv.MultiBlock({"mesh": ball()})
    blocks.append(pv.Table({"a": np.zeros(3)}), "table")
    try:
        lit = blocks.phong.shade(SCENE)
    except ValueError as error:
        assert "'table'" in str(error)  # noqa: PT017 either is right
    else:
        assert isinstance(lit["table"], pv.Table)


def test_map_blocks_applies_any_operation():
    doubled = map_blocks(family(), lambda mesh: mesh.scale(2, inplace=False))
    np.testing.assert_allclose(doubled["first"].points, 2 * family()["first"].points)
