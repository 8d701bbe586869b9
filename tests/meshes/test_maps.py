"""A material's maps in every call: names, arrays, textures and files give the same numbers at the same points."""

from __future__ import annotations

import json
import pickle
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from PIL import Image

import pvphong as ph
from pvphong.meshes.colormaps import mapped
from pvphong.meshes.point_data import texture_colors
from pvphong.studio.lit_mesh import LitMesh

SCENE = ph.Scene(
    [ph.PointLight(position=(2, -1, 3), name="lamp"), ph.DirectionalLight(direction=(0, 1, -1), diffuse=0.4)],
    ph.Viewer((3, -4, 4)),
)
TEXTURE = pv.Texture(np.random.default_rng(3).integers(0, 256, (5, 7, 3)).astype(np.uint8))
MATERIALS = {
    "colours": ph.Material(albedo="tint", diffuse="bytes", specular="tint", emission="dim"),
    "gloss": ph.Material(specular=0.6, shininess="gloss"),
    "GGX": ph.Material(albedo="tint", reflectance=ph.GGX("rough", f0=0.3)),
    "PBR": ph.Material(albedo="tint", reflectance=ph.PBR(metallic="dim", roughness="rough")),
    "texture": ph.Material(albedo=TEXTURE),
    "colormap": ph.Material(albedo=ph.Colormap("dim", "terrain"), specular=ph.Colormap("tint", "gray", component=1)),
    "Ward": ph.Material(specular="dim", tangents="grain", reflectance=ph.Ward(0.2, 0.5)),
}


def ball():
    mesh, random = pv.Sphere(theta_resolution=12, phi_resolution=12), np.random.default_rng(4)
    mesh.active_texture_coordinates = random.random((mesh.n_points, 2))
    count = mesh.n_points
    mesh["tint"], mesh["dim"] = random.random((count, 3)), random.random(count)
    mesh["bytes"] = random.integers(0, 256, (count, 3)).astype(np.uint8)
    mesh["gloss"], mesh["rough"] = 60 * random.random(count), 0.1 + 0.9 * random.random(count)
    mesh["grain"] = random.normal(size=(count, 3))
    return mesh


def with_arrays(material, mesh):
    """Return the same material with arrays in place of names."""

    def array(given):
        if isinstance(given, ph.Colormap):
            return mapped("albedo", replace(given, scalars=mesh[given.scalars]))
        return np.asarray(mesh[given]) if isinstance(given, str) else texture_colors(TEXTURE, mesh)

    named = dict(material.maps) | ({"tangents": material.tangents} if material.tangents else {})
    return material.with_values({name: array(given) for name, given in named.items()})


def live(mesh, material):
    shown = LitMesh(mesh, material)
    shown.refresh(SCENE)
    return shown.drawn["phong"] / 255.0


def filtered(mesh, material):
    step = ph.PhongFilter()
    step.SetInputData(mesh)
    step.SetScene(SCENE)
    step.SetMaterial(material)
    step.SetOptions(precision="float64")
    step.Update()
    return pv.wrap(step.GetOutput())["phong"]


CALLS = {
    "shade": (lambda mesh, material: mesh.phong.shade(SCENE, material)["phong"], 1e-4),
    "blocks": (lambda mesh, material: pv.MultiBlock({"a": mesh}).phong.shade(SCENE, material)["a"]["phong"], 1e-4),
    "pieces of a surface": (lambda mesh, m: mesh.cast_to_unstructured_grid().phong.shade(SCENE, m)["phong"], 1e-4),
    "refine": (
        lambda mesh, material: mesh.phong.refine(SCENE, material, tolerance=0.3)["phong"][: mesh.n_points],
        1e-4,
    ),
    "filter": (filtered, 1e-9),
    "window": (live, 0.51 / 255 + 1e-4),
}


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("name", MATERIALS)
def test_every_call_has_the_colours_of_the_arrays(name, call):
    mesh, material = ball(), MATERIALS[name]
    points, normals = mesh.points, mesh.point_data.active_normals
    expected = ph.evaluate(points, normals, SCENE, with_arrays(material, mesh), precision="float64").rgb
    run, most = CALLS[call]
    assert np.abs(run(mesh, material) - expected).max() < most
    if call in ("shade", "refine", "filter", "pieces of a surface"):
        assert np.array_equal(run(mesh, with_arrays(material, mesh)), run(mesh, material))


@pytest.mark.parametrize("name", ["colours", "PBR", "Ward"])
def test_studies_read_them(name):
    mesh, material = ball(), MATERIALS[name]
    plan = mesh.phong.plan(SCENE, material, tolerance=0.05)
    assert plan.error_bound <= 0.05
    errors = mesh.phong.interpolation_error(SCENE, material)["phong_interpolation_error"]
    plain = ph.Material(diffuse=0.3, specular=0.2, shininess=10)
    assert not np.array_equal(errors, mesh.phong.interpolation_error(SCENE, plain)["phong_interpolation_error"])
    report = mesh.phong.tradeoff(SCENE, material, seconds=0.5)
    reference = mesh.phong.shade(SCENE, material, precision="float64", backend="numpy")["phong"]
    assert np.abs(report.reference_colors - reference).max() < 1e-12
    with pytest.raises(ValueError, match="for a comparison with VTK"):
        mesh.phong.validate(SCENE, material)


def test_textures_arrays_and_files_are_the_same(tmp_path):
    sheet = pv.Plane(i_resolution=7, j_resolution=7)
    grey = np.tile(np.arange(0, 256, 32, dtype=np.uint8), (8, 1))
    Image.fromarray(grey).save(tmp_path / "gloss.png")
    texture = pv.Texture(grey)
    array = sheet.phong.shade(SCENE, ph.Material(albedo=texture, ambient=1, diffuse=0, emission=0))["phong"][:, 0] / 0.2
    sheet["gloss"], sheet["rough"] = 128.0 * array, 0.2 + 0.5 * array
    materials = [ph.Material(specular=0.5, shininess=g) for g in ("gloss", texture, str(tmp_path / "gloss.png"))]
    first, *others = [sheet.phong.shade(SCENE, material)["phong"] for material in materials]
    for other in others:
        np.testing.assert_allclose(other, first, atol=1e-5)
    with pytest.raises(ValueError, match=r"^shininess must be a texture with one channel.* Select a channel"):
        sheet.phong.shade(SCENE, ph.Material(shininess=pv.Texture(np.dstack([grey, grey, 255 - grey]))))


def test_a_colour_for_each_face():
    cube = pv.Cube().clean()
    cube.point_data.clear()
    paint = np.random.default_rng(1).integers(0, 256, (6, 3)).astype(np.uint8)
    cube.cell_data["paint"] = paint
    lit = cube.phong.shade(SCENE, ph.Material(ambient=1, diffuse=0, albedo="paint"), feature_angle=0)
    corners = lit.regular_faces
    for face, color in zip(corners, paint, strict=True):
        np.testing.assert_allclose(lit["phong"][face], np.tile(0.2 * color / 255.0, (4, 1)), atol=1e-6)
    again = cube.phong.shade(SCENE, ph.Material(ambient=1, diffuse=0, albedo=paint), feature_angle=0)
    assert np.array_equal(again["phong"], lit["phong"])
    for given in ("paint", paint):
        with pytest.raises(
            ValueError, match=r"^albedo must be an array with one row per point.*faces share points.* feature_angle=0"
        ):
            cube.phong.shade(SCENE, ph.Material(albedo=given))


def test_a_colour_for_each_face_beside_vertex_and_line_cells():
    """Vertices and lines come first among a mesh's cells, and are not lit."""
    cube = pv.Cube().clean()
    cube.point_data.clear()
    paint = np.random.default_rng(1).random((6, 3))
    material = ph.Material(ambient=1, diffuse=0, albedo="paint")
    cube.cell_data["paint"] = paint
    expected = cube.phong.shade(SCENE, material, feature_angle=0)["phong"]
    cube.cell_data.clear()
    cube.SetVerts(pv.CellArray([1, 0, 1, 3]))
    cube.SetLines(pv.CellArray([2, 0, 1]))
    cube.cell_data["paint"] = np.concatenate([np.full((3, 3), 0.5), paint])
    for given in ("paint", cube.cell_data["paint"]):
        again = cube.phong.shade(SCENE, ph.Material(ambient=1, diffuse=0, albedo=given), feature_angle=0)
        np.testing.assert_array_equal(again.point_data["phong"], expected)


def test_windows_follow_colours_of_faces(new_plotter):
    """Point arrays are tested in test_plotter, textures in test_textures, and refusals in studio."""
    mesh, plotter = pv.Cube(), new_plotter(lighting="light kit")
    mesh.cell_data["paint"] = np.full((mesh.n_cells, 3), 250, np.uint8)
    actor = plotter.phong.add_mesh(mesh, ph.Material(albedo="paint"), feature_angle=0)
    plotter.show(auto_close=False)
    assert actor.mapper.dataset["phong"].max() > 0
    mesh.cell_data["paint"] = np.zeros((mesh.n_cells, 3), np.uint8)
    plotter.render()
    assert actor.mapper.dataset["phong"].max() == 0


@pytest.mark.parametrize("field", ["albedo", "diffuse", "specular", "emission"])
@pytest.mark.parametrize("name", ["c", "red", "tan"])
def test_a_string_names_an_array_first_and_a_colour_second(field, name, new_plotter):
    """In files, copies and arithmetic the string stays a colour, unless an array has its name."""
    ball = pv.Sphere()
    as_color = ph.Material(**{field: name})
    assert getattr(as_color, field) == pv.Color(name).float_rgb
    assert pickle.loads(pickle.dumps(as_color)) == ph.Material.from_dict(json.loads(json.dumps(as_color.to_dict())))
    assert repr(name) in repr(as_color)
    assert f"By name, {field} is the colour {name!r}." in " ".join(str(ball.phong.plan(SCENE, as_color)).split())
    plain = ball.phong.shade(SCENE, as_color)
    of_colour, of_array = ph.Material(**{field: pv.Color(name).float_rgb}), ph.Material(**{field: "values"})
    np.testing.assert_array_equal(plain["phong"], ball.phong.shade(SCENE, of_colour)["phong"])
    ball[name] = np.random.default_rng(5).random((ball.n_points, 3))
    ball["values"] = ball[name]
    np.testing.assert_array_equal(*(ball.phong.shade(SCENE, each)["phong"] for each in (as_color, of_array)))
    again = replace(ph.Material.from_dict(as_color.to_dict()), ambient=0.2)  # copies and files keep the name
    np.testing.assert_array_equal(*(ball.phong.shade(SCENE, each)["phong"] for each in (again, of_array)))
    assert f"By name, {field} is the array {name!r}." in " ".join(str(ball.phong.plan(SCENE, as_color)).split())
    plotter = new_plotter()
    plotter.phong.add_light(SCENE.lights[0])
    actor = plotter.phong.add_mesh(ball, as_color)
    plotter.render()
    assert len(np.unique(np.asarray(actor.mapper.dataset["phong"]), axis=0)) > 20
