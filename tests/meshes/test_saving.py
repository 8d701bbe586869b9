"""Exported lit meshes, read by trimesh, pygltflib and meshio."""

from __future__ import annotations

import inspect
import os
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.base.color import linear_from_srgb, srgb_from_linear
from pvphong.meshes.gltf import LightsWarning
from pvphong.meshes.saving import SAVED_BLOCKS, SAVED_MESHES

SCENE = ph.Scene([ph.DirectionalLight(direction=(-1, -2, -2), diffuse=(1, 0.8, 0.6))], ph.Viewer(position=(2, 2, 2)))
FAR = np.array([5e5, 4e6, 300.0])


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def lit(mesh=None):
    return (pv.Sphere() if mesh is None else mesh).phong.shade(SCENE, ph.Material(diffuse=(0.9, 0.5, 0.2)))


def blocks():
    return pv.MultiBlock({"ball": pv.Sphere(), "box": pv.Cube(center=(2, 0, 0))}).phong.shade(SCENE)


def accessor(document, at):
    """Return the rows of an array in a glTF file, as specified."""
    found = document.accessors[at]
    view, kinds = document.bufferViews[found.bufferView], {5126: np.float32, 5123: np.uint16, 5125: np.uint32}
    data = document.binary_blob() or document.get_data_from_buffer_uri(document.buffers[0].uri)
    start, width = (view.byteOffset or 0) + (found.byteOffset or 0), {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[found.type]
    rows = np.frombuffer(data, kinds[found.componentType], found.count * width, start).reshape(found.count, width)
    return rows / 65535.0 if found.normalized else rows


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
@pytest.mark.parametrize(
    "mesh", [pv.Sphere(), pv.Cube(), pv.Sphere().strip(), pv.Plane()], ids=["", "cube", "strips", "plane"]
)
def test_gltf_keeps_colours_to_16_bits_and_says_that_they_are_lit(suffix, mesh):
    pygltflib = pytest.importorskip("pygltflib")
    shaded = lit(mesh)
    shaded.phong.save(f"ball{suffix}")
    document = pygltflib.GLTF2().load(f"ball{suffix}")
    assert document.extensionsUsed == ["KHR_materials_unlit"]
    assert "KHR_materials_unlit" in document.materials[0].extensions
    (primitive,) = document.meshes[0].primitives
    attributes = primitive.attributes
    np.testing.assert_allclose(accessor(document, attributes.COLOR_0)[:, :3], shaded["phong"], atol=0.5 / 65535)
    middle = np.array(document.nodes[0].translation)
    np.testing.assert_allclose(accessor(document, attributes.POSITION) + middle, shaded.points, atol=1e-6)
    np.testing.assert_allclose(accessor(document, attributes.NORMAL), shaded.phong.normals(), atol=1e-6)
    corners = accessor(document, primitive.indices).reshape(-1, 3)
    made = pv.PolyData.from_regular_faces(shaded.points, corners.astype(int))
    assert made.area == pytest.approx(shaded.area)


def test_gltf_keeps_the_digits_of_meshes_far_from_the_origin():
    pygltflib = pytest.importorskip("pygltflib")
    ball = pv.Sphere()
    ball.points = ball.points.astype(float) + FAR
    ball.phong.shade(SCENE).phong.save("far.glb")
    document = pygltflib.GLTF2().load("far.glb")
    found = accessor(document, document.meshes[0].primitives[0].attributes.POSITION)
    np.testing.assert_allclose(found + np.array(document.nodes[0].translation), ball.points, rtol=0, atol=1e-6)


def test_blocks_are_named_parts_of_a_gltf_file():
    trimesh = pytest.importorskip("trimesh")
    shaded = blocks()
    shaded.phong.save("both.glb")
    found = trimesh.load("both.glb")
    assert sorted(found.geometry) == ["ball", "box"]
    x_y_z = np.array(found.bounds)  # with z rotated to y
    np.testing.assert_allclose(x_y_z[:, 0], np.array(shaded.bounds)[:2], atol=1e-5)
    np.testing.assert_allclose(x_y_z[:, 1], np.array(shaded.bounds)[4:], atol=1e-5)


@pytest.mark.parametrize("encoding", ["linear", "srgb"])
def test_ply_keeps_colours_to_8_bits(encoding):
    trimesh = pytest.importorskip("trimesh")
    shaded = lit()
    before = shaded.copy()
    shaded.phong.save("ball.ply", encoding=encoding)
    assert shaded == before
    found = trimesh.load("ball.ply", process=False)
    colors = found.visual.vertex_colors[:, :3] / 255.0
    if encoding == "srgb":
        np.testing.assert_allclose(colors, srgb_from_linear(shaded["phong"]), atol=0.51 / 255)
    else:
        np.testing.assert_allclose(colors, shaded["phong"], atol=0.51 / 255)
    np.testing.assert_allclose(found.vertices, shaded.points)


@pytest.mark.parametrize("encoding", ["linear", "srgb"])
def test_obj_keeps_colours_behind_positions(encoding):
    trimesh = pytest.importorskip("trimesh")
    shaded = lit(pv.Cube())
    shaded.phong.save("cube.obj", encoding=encoding)
    rows = np.array([line.split()[1:] for line in Path("cube.obj").read_text().splitlines() if line[0] == "v"], float)
    colors = rows[:, 3:] if encoding == "linear" else linear_from_srgb(rows[:, 3:])
    np.testing.assert_allclose(colors, shaded["phong"], atol=1e-5)
    assert trimesh.load("cube.obj").area == pytest.approx(6.0)


@pytest.mark.parametrize("suffix", [".vtp", ".vtk", ".vtkhdf"])
def test_vtks_formats_have_all_arrays(suffix):
    shaded = lit()
    shaded.phong.save(f"ball{suffix}")
    np.testing.assert_array_equal(ph.read(f"ball{suffix}")["phong"], shaded["phong"])


@pytest.mark.parametrize("suffix", [".vtm", ".vtmb", ".vtkhdf"])
def test_so_they_have_of_blocks(suffix):
    shaded = blocks()
    shaded.phong.save(f"both{suffix}")
    found = ph.read(f"both{suffix}")
    np.testing.assert_array_equal(found[1]["phong"], shaded[1]["phong"])


def test_there_and_back_by_meshio_and_trimesh():
    meshio, trimesh = pytest.importorskip("meshio"), pytest.importorskip("trimesh")
    source = trimesh.creation.icosphere(subdivisions=2)
    shaded = pv.wrap(source).phong.shade(SCENE)
    back = trimesh.Trimesh(
        shaded.points, shaded.regular_faces, vertex_colors=np.rint(255 * shaded["phong"]).astype(np.uint8)
    )
    np.testing.assert_allclose(back.visual.vertex_colors[:, :3] / 255, shaded["phong"], atol=0.51 / 255)
    pv.to_meshio(shaded).write("ball.vtu")
    np.testing.assert_allclose(meshio.read("ball.vtu").point_data["phong"], shaded["phong"])


@pytest.mark.parametrize("make", [lit, blocks], ids=["mesh", "blocks"])
def test_a_png_is_a_picture_of_it(make):
    make().phong.save("it.png", size=(120, 90), viewer=ph.Viewer(position=(4, 3, 2), focal_point=(0.5, 0, 0)))
    image = pv.read_texture("it.png").to_image()
    assert image.dimensions == (120, 90, 1)
    assert len(np.unique(np.asarray(image.active_scalars), axis=0)) > 50


def test_with_lights_viewers_are_given_those_and_colours_before_light():
    pygltflib = pytest.importorskip("pygltflib")
    lights = [
        ph.DirectionalLight(direction=(0, 0, -1), diffuse=(1, 0.5, 0.25), intensity=2, name="sun"),
        ph.PointLight(position=(1, 2, 3), attenuation=(0, 0, 1), name="lamp"),
        ph.SpotLight(position=(0, 0, 5), direction=(0, 1, -1), cone_angle=20, exponent=0, attenuation=(0, 0, 2)),
        ph.SphereLight(position=(5, 0, 0), radius=1, name="window"),
        ph.PointLight(position=(1, 2, 3), name="one that does not weaken"),
        ph.PointLight(position=(9, 9, 9), attenuation=(0, 0, 1), on=False),
    ]
    with pytest.warns(LightsWarning, match=r"^window, one that does not weaken cannot be stored in glTF"):
        pv.Sphere().phong.save("ball.glb", lights=lights, material=ph.Material(diffuse=(0.5, 0.25, 1.0)))
    document = pygltflib.GLTF2().load("ball.glb")
    assert document.extensionsUsed == ["KHR_lights_punctual"]
    assert not document.materials[0].extensions
    colors = accessor(document, document.meshes[0].primitives[0].attributes.COLOR_0)
    np.testing.assert_allclose(colors, np.tile([0.5, 0.25, 1.0, 1.0], (len(colors), 1)), atol=1e-4)
    sun, lamp, spot = document.extensions["KHR_lights_punctual"]["lights"]
    assert (sun["type"], lamp["type"], spot["type"]) == ("directional", "point", "spot")
    np.testing.assert_allclose(np.array(sun["color"]) * sun["intensity"], 2 * np.pi * np.array([1, 0.5, 0.25]))
    assert spot["intensity"] == pytest.approx(np.pi / 2)
    assert spot["spot"]["outerConeAngle"] == pytest.approx(np.radians(20))
    placed = [node for node in document.nodes if node.extensions]
    assert placed[1].translation == [1, 2, 3]
    for node, direction in ((placed[0], (0, 0, -1)), (placed[2], (0, 1, -1))):
        x, y, z, w = node.rotation
        turned = -np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])  # of (0, 0, -1)
        np.testing.assert_allclose(turned, np.array(direction) / np.linalg.norm(direction), atol=1e-12)


BAD = {
    "suffix": (lambda: lit().phong.save("ball.stl"), r"^path must be .*\.vtp, .*\.png\); got ball\.stl"),
    "blocks": (
        lambda: blocks().phong.save("ball.ply"),
        r"^path must be .*; got ball\.ply\. Merge .* blocks\.combine\(\)",
    ),
    "unlit": (lambda: pv.Sphere().phong.save("ball.glb"), r"^mesh must be lit, .*mesh\.phong\.shade"),
    "array": (lambda: lit().phong.save("ball.glb", name="phng"), r"^name must be one of .*Did you mean 'phong'"),
    "encoding": (lambda: lit().phong.save("ball.ply", encoding="gamma"), r"^encoding must be one of 'linear', 'srgb'"),
    "encoding of glTF": (lambda: lit().phong.save("a.glb", encoding="srgb"), r"^encoding must be left out for \.glb"),
    "size": (lambda: lit().phong.save("a.glb", size=(3, 3)), r"^size must be left out for \.glb"),
    "compress": (lambda: lit().phong.save("a.ply", compress="zlib"), r"^compress must be left out for \.ply"),
    "lights": (lambda: lit().phong.save("a.ply", lights=SCENE), r"^lights must be left out for \.ply"),
    "no colours": (lambda: lit().phong.save("a.obj", name="Normals2"), r"^name must be one of"),
    "no folder": (lambda: lit().phong.save("nowhere/a.glb"), r"^path must be in a folder that exists"),
}


@pytest.mark.parametrize("what", BAD)
def test_what_cannot_be_saved_is_refused_and_leaves_nothing(what):
    save, message = BAD[what]
    with pytest.raises(ValueError, match=message) as caught:
        save()
    assert "\n" not in str(caught.value)
    assert not os.listdir()


@pytest.mark.parametrize("suffix", [".glb", ".gltf", ".obj", ".ply", ".png"])
def test_a_file_that_cannot_be_written_leaves_the_old_one(suffix, monkeypatch):
    path = Path(f"ball{suffix}")
    path.write_text("old")
    shaded = lit()

    def full(*_given, **_options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pvphong.base.files.sync", full)
    with pytest.raises(ValueError, match="No space left on device"):
        shaded.phong.save(path)
    assert path.read_text() == "old"
    assert os.listdir() == [path.name]


def test_blocks_take_what_a_mesh_takes():
    assert next(iter(inspect.signature(pv.Sphere().phong.save).parameters)) == "path"
    assert set(SAVED_BLOCKS) - set(SAVED_MESHES) == {".vtm", ".vtmb"}
