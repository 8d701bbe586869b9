"""Lit meshes: the points, normals and albedo that are read, the arrays that are written, and unmodified inputs.

Array types and layouts are section F of the catalogue. Surfaces of datasets are tested in test_surfaces, lighting of
every kind of dataset in test_accessor, and maps in test_maps.
"""

import sys
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from pvphong import DirectionalLight, LightModel, Material, PointLight, Scene, SpotLight, Viewer, evaluate
from pvphong.geometry.transform import transform_normals
from pvphong.meshes.lit import one_surface

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


def bare():
    """The same without normals."""
    mesh = ball()
    mesh.point_data.clear()
    return mesh


def grid():
    return pv.ImageData(dimensions=(4, 5, 6), spacing=(0.3, 0.2, 0.1), origin=(1, 2, 3))


def random_rows(mesh, seed=0):
    return np.random.default_rng(seed).uniform(size=(mesh.n_points, 3))


def test_maps_of_a_volume_go_to_its_surface():
    mesh = grid()
    mesh["tint"], tints = random_rows(mesh), random_rows(mesh)
    lit, named = (mesh.phong.shade(SCENE, replace(MATERIAL, albedo=given)) for given in (tints, "tint"))
    assert set(lit.point_data) == {"tint", "vtkOriginalPointIds", "phong"}
    for found, rows in ((lit, tints), (named, mesh["tint"])):
        material = replace(MATERIAL, albedo=np.asarray(rows)[found["vtkOriginalPointIds"]])
        assert bits(found["phong"]) == bits(evaluate(found.points, found.phong.normals(), SCENE, material).rgb)
        assert (found.active_scalars_name, found["phong"].dtype) == ("phong", np.float32)


# --- refusals ---

GRIDS = [getattr(grid(), f"cast_to_{kind}_grid")() for kind in ("structured", "rectilinear", "unstructured")]
NO_ALBEDOS = [np.array([["a"] * 3] * 120), [[1, 2, 3], [4]], np.ones((120, 3, 3)), np.ones((120, 2))]
NO_ALBEDOS += [np.ones((120, 3), complex), np.ones((120, 3), object)]


def albedo(given):
    return {"material": Material(albedo=given)}


@pytest.mark.parametrize(
    ("mesh", "options", "message"),
    [
        (ball(), {"scene": Material()}, r"^scene must be a Scene, .* Did you mean material=\?"),
        (ball(), albedo("no array"), r"^albedo must be the name of a point array \(Normals, height\); got 'no array'"),
        (ball(), albedo("heigth"), "^albedo must be .* Did you mean 'height'"),
        *[(mesh, albedo(rows), f"^albedo must be .*one row per point, {mesh.n_points} rows; got {len(rows)} rows")
          for mesh in (ball(), bare(), grid(), *GRIDS) for rows in (np.ones((5, 3)), [[0.5, 0.5, 0.5]])],
        *[(grid(), albedo(bad), "^albedo must be .*; got ") for bad in NO_ALBEDOS],
    ],
)  # fmt: skip
def test_options_are_refused_by_name(mesh, options, message):
    with pytest.raises(ValueError, match=message):
        mesh.phong.shade(**{"scene": SCENE, "material": MATERIAL} | options)


# --- names, components ---


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("name", ["phong", "glow"])
@pytest.mark.parametrize("count", [0, 1, 3])
def test_components_are_named_after_the_array_and_add_up_to_it(precision, name, count):
    scene = replace(SCENE, lights=SCENE.lights[:count], light_model=LightModel(clamp=False))
    lit = ball().phong.shade(scene, MATERIAL, components=True, precision=precision, name=name)
    assert lit.active_scalars_name == name
    names = set(lit.point_data.keys()) - set(ball().point_data.keys())
    parts = [f"{name}_{part}" for part in ("ambient", "diffuse", "specular", "emission")]
    shares = [f"{name}_light_{label}" for label in ("sun", "1", "lamp")][:count]
    assert names == {name, f"{name}_base", *parts, *shares}
    assert {str(lit[each].dtype) for each in names} == {precision}
    for terms in (parts, [f"{name}_base", *shares]):
        total = sum(lit[term] for term in terms)
        np.testing.assert_allclose(total, lit[name], rtol=0, atol=8 * np.finfo(precision).eps)
    expected = evaluate(lit.points, lit["Normals"], scene, MATERIAL, components=True, precision=precision).per_light
    assert [bits(lit[share]) for share in shares] == [bits(share) for share in expected]


# --- normals ---


@pytest.mark.filterwarnings("ignore::pvphong.NormalsWarning")
@pytest.mark.filterwarnings("ignore::pvphong.NormalsWarning")  # of random ones
@pytest.mark.parametrize("name", ["Normals", "bent"])
def test_active_point_normals_are_used_as_they_are(name):
    mesh = ball()
    odd = random_rows(mesh, 3) * 5 - 2
    mesh.point_data[name] = odd
    mesh.point_data.active_normals_name = name
    assert bits(mesh.phong.normals()) == bits(odd)
    assert bits(mesh.phong.normals(matrix=MATRIX)) == bits(transform_normals(odd, MATRIX))
    assert bits(mesh.phong.shade(SCENE, MATERIAL)["phong"]) == bits(evaluate(mesh.points, odd, SCENE, MATERIAL).rgb)


@pytest.mark.parametrize("backend", ["auto", "numpy"])
def test_a_backend_goes_for_the_normals_too(monkeypatch, backend):
    asked = []

    def computed(mesh, _weighting, *, backend):
        asked.append(backend)
        return np.full(mesh.points.shape, (0.0, 0.0, 1.0))

    monkeypatch.setattr("pvphong.meshes.surfaces.vertex_normals", computed)
    bare().phong.shade(SCENE, MATERIAL, backend=backend)
    bare().phong.normals(backend=backend)
    assert asked == [backend] * 2


# --- the matrix ---


def test_the_matrix_lights_as_a_transformed_mesh_would_be():
    mesh = bare()  # turned and scaled evenly, so that no angle between edges changes
    matrix = np.array([[0, -2, 0, 3], [2, 0, 0, 1], [0, 0, 2, -1], [0, 0, 0, 1]], float)
    lit = mesh.phong.shade(SCENE, MATERIAL, matrix=matrix, precision="float64")
    again = mesh.transform(matrix, inplace=False).phong.shade(SCENE, MATERIAL, precision="float64")
    assert bits(lit.points) == bits(mesh.points)
    assert np.abs(again.points - lit.points).max() > 1
    np.testing.assert_allclose(lit["phong"], again["phong"], atol=1e-5)  # moved points and their normals are float32's


# --- blocks ---


def family():
    """Blocks of all kinds: two with the same name, some without a name, and a table, which cannot be lit."""
    inner, blocks = pv.MultiBlock({"deep": ball(), "gap": None, "void": pv.PolyData()}), pv.MultiBlock()
    parts = [bare(), None, inner, pv.MultiBlock(), grid(), pv.UnstructuredGrid(), pv.Table({"a": np.zeros(3)}), ball()]
    for part, name in zip(
        parts, ["first", "nothing", "inner", "hollow", "grid", "empty", "table", "first"], strict=True
    ):
        blocks.append(part, name)
    blocks.append(pv.MultiBlock([bare(), None]), "nameless")
    blocks.field_data["made"] = [7]
    return blocks


def shape(blocks):
    """Return the names and kinds of blocks, nested like the blocks."""
    kinds = [shape(b) if isinstance(b, pv.MultiBlock) else type(b).__name__ if b else None for b in blocks]
    return [(blocks.get_block_name(index), kind) for index, kind in enumerate(kinds)]


def test_structure_and_names_of_blocks_are_kept_and_the_blocks_not_modified():
    blocks = family()
    before = blocks.copy()
    lit, normals = blocks.phong.shade(SCENE, MATERIAL, components=True), blocks.phong.normals()
    inside = [("deep", "PolyData"), ("gap", None), ("void", "PolyData")]
    assert shape(lit) == shape(normals) == [
        ("first", "PolyData"), ("nothing", None), ("inner", inside), ("hollow", []), ("grid", "PolyData"),
        ("empty", "UnstructuredGrid"), ("table", "Table"), ("first", "PolyData"),
        ("nameless", [("Block-00", "PolyData"), ("Block-01", None)]),
    ]  # fmt: skip
    assert lit.field_data["made"].tolist() == [7]
    for index in (0, 4, 7):
        assert bits(lit[index]["phong"]) == bits(blocks[index].phong.shade(SCENE, MATERIAL)["phong"])
    assert bits(lit["inner"]["deep"]["phong"]) == bits(ball().phong.shade(SCENE, MATERIAL)["phong"])
    lit["inner"]["deep"].points = np.zeros_like(lit["inner"]["deep"].points)
    assert blocks == before
    assert shape(pv.MultiBlock().phong.shade(SCENE)) == []


def test_an_error_names_the_block():
    blocks = family()
    blocks["inner"].append(pv.PolyData(np.eye(3)), "dust")
    with pytest.raises(ValueError, match=r"^block \['inner'\]\['dust'\]: mesh must be a mesh with faces"):
        blocks.phong.shade(SCENE)
    with pytest.raises(ValueError, match=r"^block \['grid'\]: albedo must be"):
        pv.MultiBlock({"grid": grid()}).phong.shade(SCENE, Material(albedo="tint"))


def test_a_mesh_that_another_thread_edits_meanwhile_is_lit_as_it_was_or_refused():
    """Edits happen between all pairs of steps, which stands for edits within the steps too."""
    small, large = pv.Sphere(theta_resolution=8, phi_resolution=8), pv.Sphere(theta_resolution=30, phi_resolution=30)
    mesh, lit = large.copy(), []

    def edit(frame, event, _argument):
        if event == "call" and "pvphong" in frame.f_code.co_filename:
            sys.setprofile(None)
            mesh.copy_from(small if mesh.n_points == large.n_points else large)
            sys.setprofile(edit)

    for material in (MATERIAL, Material(specular=0.5, shininess=20)):
        sys.setprofile(edit)
        try:
            lit.append(mesh.phong.shade(SCENE, material))
        finally:
            sys.setprofile(None)
    for result in lit:
        whole = small if result.n_points == small.n_points else large
        assert result.faces.tolist() == whole.faces.tolist()
        assert bits(result.points) == bits(whole.points)
        assert len(result["phong"]) == whole.n_points


@pytest.mark.parametrize(("name", "of"), [("Normals", "normals"), ("uv", "texture coordinates")])
def test_colours_take_no_name_of_what_the_mesh_is_lit_by(name, of):
    plane = pv.Plane(i_resolution=2, j_resolution=2)
    plane.point_data["uv"] = plane.active_texture_coordinates
    plane.point_data.active_texture_coordinates_name = "uv"
    with pytest.raises(ValueError, match=f"^name must be different from .* got '{name}', the name of the mesh's {of}"):
        plane.phong.shade(name=name)


# --- blocks as one surface ---


def test_all_surfaces_are_one_with_the_normals_that_they_are_lit_with_and_a_broken_block_is_named():
    odd, box = ball(), pv.Box((2, 3, 0, 1, 0, 1))
    odd.point_data.active_normals = -odd.point_data.active_normals  # its own, which faces would not give
    given = pv.MultiBlock({"ball": odd, "gap": None, "inner": pv.MultiBlock({"box": box, "grid": grid()})})
    before, whole, lit = given.copy(), one_surface(given), given.phong.normals()
    parts = [lit["ball"], lit["inner"]["box"], lit["inner"]["grid"]]
    assert (whole.n_cells, whole.array_names) == (sum(part.n_cells for part in parts), ["Normals"])
    np.testing.assert_array_equal(whole.points, np.concatenate([part.points for part in parts]))
    normals = np.concatenate([part.point_data.active_normals for part in parts])
    np.testing.assert_array_equal(whole.point_data.active_normals, normals)
    assert (given["ball"], given["inner"]) == (before["ball"], before["inner"])
    with pytest.raises(
        ValueError,
        match="mesh must be a MultiBlock that contains a mesh to light; got a MultiBlock of 1 blocks, none with a mesh",
    ):
        one_surface(pv.MultiBlock({"gap": None}))
    with pytest.raises(ValueError, match=r"block \['cloud'\]: mesh must be a mesh with faces"):
        one_surface(pv.MultiBlock({"ball": pv.Sphere(), "cloud": pv.PolyData(np.eye(3))}))


@pytest.mark.parametrize("angle", [None, 30.0, "auto"])
def test_sharp_edges_of_blocks_that_are_one_surface_are_split_as_when_each_is_lit(angle):
    """The angle "auto" must see only the blocks' own normals."""
    box = pv.Cube().clean()
    box.clear_data()
    blocks = pv.MultiBlock({"box": box, "ball": ball()})
    whole, lit = one_surface(blocks, angle), blocks.phong.shade(feature_angle=angle)
    assert whole.n_points == lit["box"].n_points + lit["ball"].n_points
    assert (lit["box"].n_points == 8) == (angle is None)
