"""Many files: what is lit, what is skipped, what fails and why; and nothing half written."""

import json
import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from batch.cutting import bare, save_pieces, series, surfaces

import pvphong as ph
from pvphong.batch import worker
from pvphong.batch.pieces import paths_of, pieces_and_indices

SCENE = ph.Scene([ph.DirectionalLight(direction=(-1, -2, -3))], ph.Viewer(position=(3, 4, 5)))
GOLD = ph.Material.named("gold")


@pytest.fixture
def files():
    """Three meshes in a folder."""
    os.mkdir("in")
    for number in range(3):
        bare(pv.Sphere(center=(number, 0, 0))).save(f"in/ball_{number}.vtp")
    return sorted(Path("in").iterdir())


def everything():
    return {path: path.read_bytes() for path in Path().rglob("*") if path.is_file()}


def test_each_file_is_lit_as_by_itself(files, client):
    batch = ph.shade_files("in/*.vtp", "lit/deep", SCENE, GOLD, client=client, name="glow", components=True)
    assert (batch.done, batch.skipped, batch.failed) == (tuple(files), (), {})
    for path in files:
        lit, expected = pv.read(f"lit/deep/{path.name}"), pv.read(path).phong.shade(SCENE, GOLD, name="glow")
        np.testing.assert_array_equal(lit["glow"], expected["glow"])
        assert "glow_light_0" in lit.point_data
    assert {path.name for path in Path("lit/deep").iterdir()} == {
        name for path in files for name in (path.name, f".{path.name}.json")
    }
    assert repr(batch) == "<Batch: 3 done, 0 skipped, 0 failed>"


@pytest.mark.parametrize("scene", [None, ph.DirectionalLight()], ids=["default", "no viewer"])
def test_one_viewer_sees_all_files(files, client, scene):
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


def test_a_rig_is_told_from_another_by_all_that_colors_depend_on():
    told = worker.checksum_of
    assert told(ph.DirectionalLight()) != told(ph.PointLight(position=(0, 0, 1)))
    assert told([SCENE, {"default": GOLD}]) == told([SCENE, {"default": ph.Material.named("gold")}])
    assert told(ph.Material(diffuse=0.1)) != told(ph.Material(diffuse=np.nextafter(0.1, 1)))
    assert told(ph.Material(reflectance=ph.Phong())) != told(ph.Material(reflectance=ph.BlinnPhong()))


def test_a_file_that_cannot_be_lit_fails_alone_and_leaves_nothing(files, client):
    files[0].write_text("garbage")
    os.truncate(files[1], 2000)
    pv.PolyData([[0.0, 0, 0]]).save("in/cloud.vtp")
    pv.MultiBlock([pv.Sphere()]).save("in/blocks.vtkhdf")
    given = [*files, "in/cloud.vtp", "in/missing.vtp", "in/blocks.vtkhdf"]
    batch = ph.shade_files(given, "lit", SCENE, GOLD, client=client)
    assert batch.done == (files[2],)
    reasons = {path.name: why for path, why in batch.failed.items()}
    assert "the end tag </VTKFile> is missing" in reasons["ball_0.vtp"]
    assert "cut short" in reasons["ball_1.vtp"]
    assert "no faces and no point normals" in reasons["cloud.vtp"]
    assert "mesh must be a file that exists" in reasons["missing.vtp"]
    assert "a file with a single mesh" in reasons["blocks.vtkhdf"]
    assert sorted(os.listdir("lit")) == [".ball_2.vtp.json", "ball_2.vtp"]
    assert str(batch).startswith("1 done, 0 skipped, 5 failed.\nin/ball_0.vtp: mesh must be")


def test_a_piece_that_cannot_be_read_leaves_the_index_unwritten_until_it_can(client):
    pieces = surfaces(bare(pv.Sphere()), 2)
    index = save_pieces(pieces, "in", ".pvtp")
    broken = Path("in/whole/part_1.vtp")
    good = broken.read_bytes()
    broken.write_text("garbage")
    batch = ph.shade_files(index, "lit", SCENE, GOLD, client=client)
    assert (len(batch.done), set(batch.failed)) == (len(pieces) - 1, {broken, index})
    assert batch.failed[index] == f"not written, for 1 of the {len(pieces)} files that it names failed"
    assert not Path("lit/whole.pvtp").exists()
    broken.write_bytes(good)
    again = ph.shade_files(index, "lit", SCENE, GOLD, client=client)
    assert len(again.done) == len(pieces) + 1, "the others had no neighbour there"
    assert Path("lit/whole.pvtp").exists()


def test_a_block_has_the_material_of_its_name(client):
    save_pieces([pv.Sphere(), pv.Cube()], "in", ".vtm")
    materials = {"part 1": GOLD, "default": ph.Material()}
    assert not ph.shade_files("in/whole.vtm", "lit", SCENE, materials, client=client).failed
    lit = pv.read("lit/whole.vtm")
    np.testing.assert_array_equal(lit["part 1"]["phong"], pv.Cube().phong.shade(SCENE, GOLD)["phong"])
    np.testing.assert_array_equal(lit["deep"][0]["phong"], pv.Sphere().phong.shade(SCENE)["phong"])


# --- where things go


def test_outputs_have_the_names_of_their_inputs_and_indices_folders_of_theirs():
    save_pieces(surfaces(bare(pv.Sphere()), 1), "in", ".pvtp")
    Path("in/steps.pvd").write_text(series(["whole.pvtp", "../../up/one.stl", "/abs/two.vtu"], [0, 1, 2]))
    pieces, indices = pieces_and_indices([Path("in/steps.pvd"), Path("in/a.stl")], Path("lit"))
    assert [str(piece.output) for piece in pieces] == [
        "lit/steps/whole/part_0.vtp",
        "lit/steps/up/one.vtp",
        "lit/steps/abs/two.vtp",
        "lit/a.vtp",
    ]
    assert [str(index.output) for index in indices] == ["lit/steps/whole.pvtp", "lit/steps.pvd"]
    assert [piece.surface for piece in pieces] == ["in/steps.pvd@0", "in/steps.pvd@1", "in/steps.pvd@2", ""]


def test_patterns_and_paths_name_each_file_once(files):
    Path("odd[1].vtp").write_bytes(files[0].read_bytes())
    assert paths_of(["in/*.vtp", "in/ball_0.vtp", "odd[1].vtp"]) == [*files, Path("odd[1].vtp")]


# --- what is refused, before anything is written


def no_such(_):
    return {"paths": "no/*.vtp"}


def one_name(files):
    os.mkdir("other")
    pv.Sphere().save("other/ball_0.stl")
    return {"paths": [*files, "other/ball_0.stl"]}


def a_circle(_):
    Path("a.pvd").write_text(series(["a.pvd"]))
    return {"paths": "a.pvd"}


def another_index(_):
    Path("a.vtm").write_text('<VTKFile type="PolyData"><PolyData/></VTKFile>')
    return {"paths": "a.vtm"}


def empty_index(_):
    Path("a.pvd").write_text(series([]))
    return {"paths": "a.pvd"}


def shadowy_pieces(_):
    save_pieces(surfaces(bare(pv.Sphere()), 2), "in/deep", ".pvtp")
    return {"paths": "in/deep/whole.pvtp", "scene": replace(SCENE, light_model=ph.LightModel(shadows=True))}


def a_file_in_the_way(_):
    Path("lit").write_text("mine")
    return {}


REFUSED = {
    r"^paths must be a pattern that some file matches; got no/\*\.vtp\.": no_such,
    r"^paths must be files with different names; got in/ball_0\.vtp and other/ball_0\.stl, both lit": one_name,
    r"^paths must be at least one file; got none": lambda _: {"paths": []},
    r"^paths must be a pattern, a path, or a sequence of them; got 5": lambda _: {"paths": 5},
    r"^paths must be an index that does not name itself": a_circle,
    r"^paths must be a file of one of \.vtm, .* that can be read; got a\.vtm\. It holds PolyData": another_index,
    r"^paths must be a file that exists; got b\.pvtp": lambda _: {"paths": "b.pvtp"},
    r"^paths must be an index that names files": empty_index,
    r"^out must be another folder than that of the files; got in": lambda _: {"out": "in"},
    r"^out must be a folder that can be made; got lit": a_file_in_the_way,
    r"^light_model must be without shadows .* for the pieces of in/deep/whole\.pvtp": shadowy_pieces,
    r"^scene must be a Scene": lambda _: {"scene": "sun"},
    r"^material must be a Material": lambda _: {"material": "gold"},
    r"^material must be a mapping with the names of all blocks.* got a mapping with 'wheel'": lambda _: {
        "material": {"wheel": GOLD}
    },
    r"^material must be .* got a mapping without 'default'": lambda _: {"material": {}},
    r"^tolerance must be": lambda _: {"tolerance": -1},
    r"^feature_angle must be": lambda _: {"feature_angle": 200.0},
    r"^albedo must be the name of a point array": lambda _: {"albedo": 5},
    r"^seams must be one of 'merge', 'keep'": lambda _: {"seams": "weld"},
    r"^client must be a distributed\.Client, or the address .* got 5": lambda _: {"client": 5},
    r"^client must be .* got here\. It names no port\.": lambda _: {"client": "here"},
    r"^workers must be left out beside a client": lambda _: {"workers": 2},
    r"^workers must be a finite number >= 1": lambda _: {"workers": 0, "client": None},
}


@pytest.mark.parametrize("message", REFUSED)
def test_what_is_wrong_is_refused_before_anything_is_written(files, client, message):
    given = {"paths": files, "out": "lit", "scene": SCENE, "material": GOLD, "client": client} | REFUSED[message](files)
    before = everything()
    with pytest.raises(ValueError, match=message):
        ph.shade_files(**given)
    assert everything() == before


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "127.0.0.1:1", "tcp://no.such.host.invalid:8786"])
def test_a_scheduler_that_is_not_there_is_told_at_once(files, address):
    began = time.monotonic()
    with pytest.raises(ValueError, match=rf"^client must be .*; got {address}\. \[Errno"):
        ph.shade_files(files, "lit", SCENE, GOLD, client=address)
    assert time.monotonic() - began < 10
    assert not Path("lit").exists()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda workers: workers.clear(), r"got a cluster without workers\. Start workers"),
        (
            lambda workers: next(iter(workers.values()))["packages"].update(pvphong="0.0"),
            r"one whose workers have pvphong .* as here; got pvphong 0\.0 at ",
        ),
        (
            lambda workers: next(iter(workers.values()))["packages"].pop("vtk"),
            r"one whose workers have vtk .* as here; got vtk missing at ",
        ),
    ],
)
def test_workers_with_other_versions_are_refused(files, client, monkeypatch, change, message):
    found = client.get_versions(packages=["pvphong", "vtk", "pyvista"])
    change(found["workers"])
    monkeypatch.setattr(client, "get_versions", lambda **_: found)
    with pytest.raises(ValueError, match=f"^client must be .*{message}"):
        ph.shade_files(files, "lit", SCENE, GOLD, client=client)
    assert not Path("lit").exists()


def test_a_receipt_says_what_was_read(files, client):
    ph.shade_files(files[:1], "lit", SCENE, GOLD, client=client)
    told = json.loads(Path("lit/.ball_0.vtp.json").read_text())
    assert told["input"] == worker.checksum_of_file(files[0])
    assert told["output"] == worker.checksum_of_file(Path("lit/ball_0.vtp"))
    assert ["PointData", "Float32", "phong", 3] in told["arrays"]
