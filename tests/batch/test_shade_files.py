"""Many files: lit, skipped and failed files, the reasons of failures, and no partly written files."""

import json
import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from batch.cutting import SCENE, bare, save_pieces, series, surfaces

import pvphong as ph
from pvphong.batch import run, shading, worker
from pvphong.batch.pieces import paths_of, pieces_and_indices

GOLD = ph.Material.named("gold")


@pytest.fixture
def files():
    """Save three meshes in a folder."""
    os.mkdir("in")
    for number in range(3):
        bare(pv.Sphere(center=(number, 0, 0))).save(f"in/ball_{number}.vtp")
    return sorted(Path("in").iterdir())


def everything():
    return {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()}


def test_each_file_is_lit_as_by_itself_and_has_a_receipt(files, client):
    options = {"name": "glow", "components": True}
    batch = ph.shade_files("in/*.vtp", "lit/deep", SCENE, GOLD, client=client, compress="none", **options)
    assert (batch.done, batch.skipped, batch.failed) == (tuple(files), (), {})
    for path in files:
        output, expected = Path("lit/deep", path.name), pv.read(path).phong.shade(SCENE, GOLD, **options)
        lit = pv.read(output)
        assert set(lit.point_data) == set(expected.point_data)
        for name in expected.point_data:
            np.testing.assert_array_equal(lit[name], expected[name])
        assert b"compressor" not in output.read_bytes()
        receipt = json.loads(worker.receipt_path(output).read_text())
        assert receipt["input"] == worker.checksum_of_file(path)
        assert receipt["output"] == worker.checksum_of_file(output)
        assert {("Float32", "glow", 3), ("Float32", "Points", 3)} <= {tuple(row[1:]) for row in receipt["arrays"]}
    names = [name for path in files for name in (path.name, f".{path.name}.json")]
    assert sorted(path.name for path in Path("lit/deep").iterdir()) == sorted(names)
    assert repr(batch) == "<Batch: 3 done, 0 skipped, 0 failed>"


@pytest.mark.parametrize("scene", [None, ph.DirectionalLight()], ids=["default", "no viewer"])
def test_one_viewer_sees_all_files(files, client, scene):
    bare(pv.Plane(center=(0, 2, 0))).save("in/sheet.vtp")  # has open edges
    files = [*files, Path("in/sheet.vtp")]
    assert not ph.shade_files(files, "lit", scene, GOLD, client=client).failed
    blocks = pv.MultiBlock([pv.read(path) for path in files])
    expected = blocks.phong.shade(scene, GOLD)
    for path, block in zip(files, expected, strict=True):
        np.testing.assert_array_equal(pv.read(f"lit/{path.name}")["phong"], block["phong"])


def test_what_is_done_is_not_done_again_until_something_changes(files, client, monkeypatch):
    def run(scene=SCENE, material=GOLD, **options):
        batch = ph.shade_files(files, "lit", scene, material, client=client, **options)
        assert not batch.failed
        return [path.name for path in batch.done], [path.name for path in batch.skipped]

    names = [path.name for path in files]
    assert run() == (names, [])
    before = everything()
    assert run() == ([], names)
    assert everything() == before
    pv.Cube().save(files[1])
    assert run() == ([names[1]], [names[0], names[2]])
    os.truncate(f"lit/{names[2]}", 100)
    assert run() == ([names[2]], names[:2])
    Path(f"lit/.{names[0]}.json").write_text("garbage")
    assert run() == ([names[0]], names[1:])
    os.unlink(f"lit/{names[0]}")
    assert run() == ([names[0]], names[1:])
    assert run(replace(SCENE, lights=[replace(SCENE.lights[0], intensity=0.5)])) == (names, [])
    assert run() == (names, [])
    assert run(material=ph.Material()) == (names, [])
    assert run(material=ph.Material(), tolerance=0.1) == (names, [])
    monkeypatch.setattr(worker, "version", lambda _: "99")
    assert run(material=ph.Material(), tolerance=0.1) == (names, [])


def test_colormaps_have_the_range_of_all_files(files, client):
    meshes = [pv.read(path) for path in files]
    for number, (mesh, path) in enumerate(zip(meshes, files, strict=True)):
        mesh["height"] = mesh.points[:, 2] + 3.0 * number
        mesh.save(path)
    material = ph.Material(albedo=ph.Colormap("height", "terrain"))
    expected = pv.MultiBlock(meshes).phong.shade(SCENE, material)
    assert len(ph.shade_files(files, "lit", SCENE, material, client=client).done) == 3
    for path, block in zip(files, expected, strict=True):
        np.testing.assert_array_equal(pv.read(f"lit/{path.name}")["phong"], block["phong"])
    assert len(ph.shade_files(files, "lit", SCENE, material, client=client).skipped) == 3
    meshes[0]["height"][0] = -90.0
    meshes[0].save(files[0])
    assert len(ph.shade_files(files, "lit", SCENE, material, client=client).done) == 3, "the range is another"
    for given in (np.zeros(3), meshes[0]["height"]):
        with pytest.raises(ValueError, match=r"^albedo\.scalars must be an array's name"):
            ph.shade_files(files, "lit", SCENE, ph.Material(albedo=ph.Colormap(given)), client=client)


def test_checksums_of_lighting_differ_by_all_that_colours_depend_on():
    image = np.random.default_rng(0).random((40, 80, 3))
    other = image.copy()
    other[20, 40, 1] += 0.1
    lights = [ph.EnvironmentLight(image=image), ph.EnvironmentLight(image=other), ph.DirectionalLight()]
    materials = [ph.Material(diffuse=0.1), ph.Material(diffuse=np.nextafter(0.1, 1))]
    materials += [ph.Material(reflectance=kind()) for kind in (ph.Phong, ph.BlinnPhong)]
    assert len({worker.checksum_of(value) for value in (*lights, *materials)}) == len(lights + materials)
    assert worker.checksum_of([SCENE, {"a": GOLD, "b": 1}]) == worker.checksum_of(
        [SCENE, {"b": 1, "a": ph.Material.named("gold")}]
    )
    jobs = set()
    for content in (b"", b"oak", b"ash"):
        Path("oak.png").write_bytes(content)
        materials = {"default": ph.Material(albedo="oak.png")}
        jobs.add(shading.ShadingJob(None, "phong", "run", "lz4", SCENE, materials, {}).checksum)
    assert len(jobs) == 3, "another image is another job"


def test_a_file_that_cannot_be_lit_fails_alone_and_leaves_nothing(files, client):
    files[0].write_text("garbage")
    os.truncate(files[1], 2000)
    pv.PolyData([[0.0, 0, 0]]).save("in/cloud.vtp")
    pv.MultiBlock([pv.Sphere()]).save("in/blocks.vtkhdf")
    given = [*files, "in/cloud.vtp", "in/missing.vtp", "in/blocks.vtkhdf", "a" * 300 + ".vtp"]
    batch = ph.shade_files(given, "lit", SCENE, GOLD, client=client)
    assert batch.done == (files[2],)
    reasons = {path.name: why for path, why in batch.failed.items()}
    assert "the end tag </VTKFile> is missing" in reasons["ball_0.vtp"]
    assert "cut short" in reasons["ball_1.vtp"]
    assert "no faces and no point normals" in reasons["cloud.vtp"]
    assert "mesh must be a file that exists" in reasons["missing.vtp"]
    assert "mesh must be a file that exists" in reasons["a" * 300 + ".vtp"]
    assert "a file with a single mesh" in reasons["blocks.vtkhdf"]
    assert sorted(os.listdir("lit")) == [".ball_2.vtp.json", "ball_2.vtp"]
    assert str(batch).startswith("1 done, 0 skipped, 6 failed.\nin/ball_0.vtp: mesh must be")


@pytest.mark.parametrize("fault", ["damaged", "out of memory"])
def test_a_piece_that_cannot_be_read_leaves_the_index_unwritten_until_it_can(client, monkeypatch, fault):
    pieces = surfaces(bare(pv.Sphere()), 2)
    index = save_pieces(pieces, "in", ".pvtp")
    broken = Path("in/whole/part_1.vtp")
    good = broken.read_bytes()

    def border_in(piece):
        if piece.input.name == broken.name:
            raise MemoryError
        return worker.border_in(piece)

    with monkeypatch.context() as patch:
        if fault == "damaged":
            broken.write_text("garbage")
        else:
            patch.setattr(run, "border_in", border_in)
        batch = ph.shade_files(index, "lit", SCENE, GOLD, client=client)
    assert (len(batch.done), set(batch.failed)) == (len(pieces) - 1, {broken, index})
    assert batch.failed[index] == f"not written, because 1 of its {len(pieces)} files failed"
    assert not Path("lit/whole.pvtp").exists()
    if fault == "damaged":  # no piece can be read, so nothing is written
        only = save_pieces([pv.Sphere()] * 2, "in/both", ".pvd")
        for path in Path("in/both/whole").iterdir():
            path.write_text("garbage")
        assert len(ph.shade_files(only, "none", SCENE, GOLD, client=client).failed) == 3
    broken.write_bytes(good)
    again = ph.shade_files(index, "lit", SCENE, GOLD, client=client)
    assert len(again.done) == len(pieces) + 1, "the others had no neighbour there"
    assert Path("lit/whole.pvtp").exists()
    if fault == "out of memory":  # pieces lit from the current inputs are kept
        next(Path("lit").rglob("part_0.vtp")).unlink()
        monkeypatch.setattr(run, "border_in", border_in)
        batch = ph.shade_files(index, "lit", SCENE, GOLD, client=client)
        assert (broken in batch.skipped, batch.failed) == (True, {})


def test_a_block_has_the_material_of_its_name(client):
    save_pieces([pv.Sphere(), pv.Cube()], "in", ".vtm")
    materials = {"part 1": GOLD, "default": ph.Material()}
    assert not ph.shade_files("in/whole.vtm", "lit", SCENE, materials, client=client).failed
    lit = pv.read("lit/whole.vtm")
    np.testing.assert_array_equal(lit["part 1"]["phong"], pv.Cube().phong.shade(SCENE, GOLD)["phong"])
    np.testing.assert_array_equal(lit["deep"][0]["phong"], pv.Sphere().phong.shade(SCENE)["phong"])


def test_blocks_that_name_one_file_have_one_material(client):
    index = save_pieces([pv.Sphere(), pv.Cube()], "in", ".vtm")
    index.write_text(index.read_text().replace("part_0", "part_1"))
    other = {"part 1": GOLD, "default": ph.Material()}
    with pytest.raises(ValueError, match=r"^material must be the same .* different materials for '.*' and 'part 1'"):
        ph.shade_files(index, "lit", SCENE, other, client=client)
    alike = {"part 1": GOLD, "deep/part 0": GOLD}
    assert not ph.shade_files(index, "lit", SCENE, alike, client=client).failed
    np.testing.assert_array_equal(pv.read("lit/whole.vtm")[1]["phong"], pv.Cube().phong.shade(SCENE, GOLD)["phong"])


# --- output paths


def test_outputs_have_the_names_of_their_inputs_and_indices_folders_of_theirs():
    save_pieces(surfaces(bare(pv.Sphere()), 1), "in", ".pvtp")
    Path("in/steps.pvd").write_text(series(["whole.pvtp", "../../up/one.stl", "/abs/two.vtu"], [0, 1, 2]))
    pieces, indices = pieces_and_indices([Path("in/steps.pvd"), Path("in/a.stl")], Path("lit"))
    outputs = [str(piece.output) for piece in pieces]
    assert outputs == ["lit/steps/whole/part_0.vtp", "lit/steps/up/one.vtp", "lit/steps/abs/two.vtp", "lit/a.vtp"]
    assert [str(index.output) for index in indices] == ["lit/steps/whole.pvtp", "lit/steps.pvd"]
    assert [piece.surface for piece in pieces] == ["in/steps.pvd@0", "in/steps.pvd@1", "in/steps.pvd@2", ""]


def test_patterns_and_paths_name_each_file_once(files):
    Path("odd[1].vtp").write_bytes(files[0].read_bytes())
    given = ["in/*.vtp", "in/ball_0.vtp", files[1].absolute(), "in/../in/*_2.vtp", "odd[1].vtp"]
    assert paths_of(given, Path("lit")) == [*files, Path("odd[1].vtp")]


def test_a_call_whose_pattern_matches_its_outputs_can_be_repeated(files, client):
    for done in (len(files), 0):
        batch = ph.shade_files("**/*.vtp", "lit", SCENE, client=client)
        assert (len(batch.done), len(batch.skipped), batch.failed) == (done, 3 - done, {})


def test_a_pattern_for_files_inside_of_the_output_folder_alone_matches_them(files):
    os.chdir("in")
    assert paths_of("*.vtp", Path("..")) == [Path(path.name) for path in files]


# --- invalid arguments raise before anything is written


@pytest.fixture
def odd_files():
    os.mkdir("odd")
    save_pieces(surfaces(bare(pv.Sphere()), 2), "odd", ".pvtp")
    pv.Sphere().save("odd/ball_0.stl")
    Path("odd/circle.pvd").write_text(series(["circle.pvd"]))
    Path("odd/empty.pvd").write_text(series([]))
    Path("odd/nameless.pvd").write_text(series([""]))
    Path("odd/mesh.vtm").write_text('<VTKFile type="PolyData"><PolyData/></VTKFile>')
    Path("odd/text.pvtp").write_text("garbage")
    Path("file").write_text("mine")


BOUNCING = replace(SCENE, light_model=ph.LightModel(shadows=True, bounces=1))
REFUSED = {
    r"^paths must be a pattern that matches a file; got no/\*\.vtp\.": {"paths": "no/*.vtp"},
    r"^paths must be files with different names; got in/ball_0\.vtp and odd/ball_0\.stl, both for lit": {
        "paths": ["in/*.vtp", "odd/ball_0.stl"]
    },
    r"^paths must be one or more files or patterns; got no path": {"paths": []},
    r"^paths must be a pattern, a path, or a sequence of them; got 5": {"paths": 5},
    r"^paths must be files to light; .* This index file names itself": {"paths": "odd/circle.pvd"},
    r"^paths must be a readable index file .*; got odd/mesh\.vtm\. It contains Poly": {"paths": "odd/mesh.vtm"},
    r"^paths must be a readable index file .* odd/text\.pvtp\. It cannot be parsed": {"paths": "odd/text.pvtp"},
    r"^paths must be a file that exists; got b\.pvtp": {"paths": "b.pvtp"},
    r"^paths must be a file that exists; got aaaa": {"paths": "a" * 300 + ".pvtp"},
    r"^paths must be files to light; got odd/empty\.pvd\. This index file names no files": {"paths": "odd/empty.pvd"},
    r"^paths must be files to light; .* An entry of this index file names ''": {"paths": "odd/nameless.pvd"},
    r"^out must be a folder other than that of the input; got in": {"out": "in"},
    r"^out must be a folder that can be created; got file": {"out": "file"},
    r"^light_model must be without bounces .* for the pieces of odd/whole\.pvtp": {
        "paths": "odd/whole.pvtp", "scene": BOUNCING
    },
    r"^scene must be a Scene": {"scene": "sun"},
    r"^material must be a Material": {"material": "gld"},
    r"^material must be a mapping with the names of all blocks.* with 'wheel'": {"material": {"wheel": GOLD}},
    r"^material must be .* got a mapping without 'default'": {"material": {}},
    r"^tolerance must be": {"tolerance": -1},
    r"^feature_angle must be": {"feature_angle": 200.0},
    r"^albedo must be the name of a point array that the files have": {"material": ph.Material(albedo=np.ones((9, 3)))},
    r"^seams must be one of 'merge', 'keep'": {"seams": "weld"},
    r"^compress must be one of 'lz4', 'zlib', 'none'": {"compress": "zip"},
    r"^client must be a distributed\.Client, or the address .* got 5": {"client": 5},
    r"^client must be .* got here\. The address has no port\.": {"client": "here"},
    r"^workers must be omitted with a client": {"workers": 2},
    r"^workers must be a finite number >= 1": {"workers": 0, "client": None},
}  # fmt: skip


@pytest.mark.usefixtures("odd_files")
@pytest.mark.parametrize(("message", "change"), REFUSED.items(), ids=REFUSED)
def test_what_is_wrong_is_refused_before_anything_is_written(files, client, message, change):
    given = {"paths": files, "out": "lit", "scene": SCENE, "material": GOLD, "client": client} | change
    before = everything()
    with pytest.raises(ValueError, match=message):
        ph.shade_files(**given)
    assert everything() == before


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "127.0.0.1:1", "tcp://no.such.host.invalid:8786"])
def test_a_scheduler_that_is_not_there_is_refused_at_once(files, address):
    began = time.monotonic()
    with pytest.raises(ValueError, match=rf"^client must be .*; got {address}\. \[Errno"):
        ph.shade_files(files, "lit", SCENE, GOLD, client=address)
    assert time.monotonic() - began < 10
    assert not Path("lit").exists()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda workers, _: workers.clear(), r"got a cluster without workers\. Start workers"),
        (lambda _, packages: packages.update(pvphong="0.0"), "have pvphong .*, like this process; got pvphong 0.0 at "),
        (lambda _, packages: packages.pop("vtk"), "have vtk .*, like this process; got vtk missing at "),
    ],
)
def test_workers_with_other_versions_are_refused(files, client, monkeypatch, change, message):
    found = client.get_versions(packages=["pvphong", "vtk", "pyvista"])
    change(found["workers"], next(iter(found["workers"].values()))["packages"])
    monkeypatch.setattr(client, "get_versions", lambda **_: found)
    with pytest.raises(ValueError, match=f"^client must be .*{message}"):
        ph.shade_files(files, "lit", SCENE, GOLD, client=client)
    assert not Path("lit").exists()
