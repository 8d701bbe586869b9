"""`pvphong irradiance` writes the arrays of `mesh.phong.irradiance`, and a picture with a scalar bar in units."""

import re

import numpy as np
import pytest
import pyvista as pv
from PIL import Image

import pvphong as ph
from pvphong.cli.app import main
from pvphong.meshes.blocks import leaves


def run(words):
    return main(words.split())


LAMP = ph.PointLight((0, 0, 3), (0, 0, 1), intensity=900.0, name="lamp")


@pytest.fixture(autouse=True)
def _files(_in_a_folder_of_its_own):
    ph.Scene([LAMP], ph.Viewer(position=(0, -6, 6), up=(0, 0, 1))).save("lamps.json")
    pv.Plane(i_size=4, j_size=4, i_resolution=20, j_resolution=20).save("floor.vtp")


WAYS = {
    "floor.vtp": {},
    "floor.vtp --per face": {"per": "face"},
    "floor.vtp --shadows --occluder roof.vtp --array lux": {"shadows": True, "name": "lux", "occluders": ["roof.vtp"]},
    "cube.vtp --bounces 1 --albedo 0.9,0.5,0.1 --feature-angle 30": {"bounces": 1, "albedo": (0.9, 0.5, 0.1)},
    "blocks.vtm --per face": {"per": "face"},
}


@pytest.mark.parametrize("words", WAYS)
def test_it_writes_what_the_method_gives(words, capsys):
    options = dict(WAYS[words])
    source = words.split()[0]
    output = "out.vtm" if "blocks" in words else "out.vtp"
    assert run(f"irradiance {words} --scene lamps.json -o {output}") == 0
    assert capsys.readouterr() == (f"{output}\n", "")
    model = ph.LightModel(shadows=options.pop("shadows", False))
    options["occluders"] = [pv.read(path) for path in options.get("occluders", ())]
    scene = ph.Scene([LAMP], ph.Viewer(position=(0, -6, 6), up=(0, 0, 1)), model)
    wanted = pv.read(source).phong.irradiance(scene, feature_angle=30 if "30" in words else "auto", **options)
    for one, other in zip(leaves(pv.read(output)), leaves(wanted), strict=True):
        assert set(one.array_names) == set(other.array_names)
        for name in other.array_names:
            np.testing.assert_array_equal(one[name], other[name])


def test_the_picture_has_a_bar_in_units_and_lines(capsys):
    assert run("irradiance floor.vtp --scene lamps.json --plot out.png --size 400 300") == 0
    assert (
        run("irradiance floor.vtp --scene lamps.json --plot lines.png --size 400 300 --isolines 50,90 --most 99") == 0
    )
    assert capsys.readouterr() == ("out.png\nlines.png\n", "")
    plain, lines = (np.asarray(Image.open(name).convert("RGB")).astype(int) for name in ("out.png", "lines.png"))
    assert plain.shape == (300, 400, 3)
    bar = plain[80:, 340:]
    assert (bar[:40, :, 0] - bar[:40, :, 2]).max() > 150  # red above
    assert (bar[-40:, :, 2] - bar[-40:, :, 0]).max() > 50  # blue below
    on_floor = slice(60, 240), slice(60, 280)
    assert (plain[on_floor].max(axis=2) < 60).sum() == 0
    assert (lines[on_floor].max(axis=2) < 60).sum() > 100  # black lines and labels
    assert (lines != plain).any()


def test_a_wall_seen_from_behind_has_neither_faces_nor_lines():
    room = pv.Box((-2, 2, -2, 2, 0, 2.9), level=10).flip_faces()
    room.clear_data()
    room.save("room.vtp")
    assert run("irradiance room.vtp --scene lamps.json --plot out.png --size 400 300 --isolines 60") == 0
    pixels = np.asarray(Image.open("out.png").convert("RGB")).astype(int)
    assert (np.ptp(pixels[100:200, 60:280], axis=2) > 20).mean() > 0.7  # one looks in


WRONG = [
    ("floor.vtp --scene lamps.json", r"--output must be given, or --plot; got no output\."),
    ("floor.vtp --scene lamps.json -o out.ply", r"--output must be a file for a mesh with irradiance"),
    ("floor.vtp --scene lamps.json --plot out.jpg", r"--plot must be a file for a picture \(\.png\)"),
    ("floor.vtp --scene lamps.json -o out.vtp --isolines 3", r"--isolines must be used with --plot; got 3"),
    ("floor.vtp --scene lamps.json --plot a.png --isolines 3,x", r"--isolines must be one to 20 numbers > 0"),
    ("floor.vtp --scene lamps.json --plot a.png --most 0", r"--most must be a finite number > 0; got 0"),
    ("floor.vtp --scene lamps.json -o out.vtk --compress lz4", r"--compress must be used with \.vtp"),
    ("floor.vtp --scene lamps.json -o out.vtp --occluder roof.vtp", r"--occluder must be used with shadows or bounces"),
    ("floor.vtp --scene none.json -o out.vtp", r"--scene must be a scene file that can be read; got none\.json"),
    ("floor.vtp --scene lamps.json -o out.vtp --albedo 1.5", r"--albedo must be .*; got 1\.5"),
    ("floor.vtp --scene lamps.json -o out.vtp --per cell", r"Invalid value .*per"),
    ("floor.vtp -o out.vtp", r".*--scene"),
]


@pytest.mark.parametrize(("words", "message"), WRONG, ids=[words for words, _ in WRONG])
def test_what_is_wrong_gets_one_line(words, message, capsys, tmp_path):
    before = set(tmp_path.iterdir())
    assert run(f"irradiance {words}") == 2
    out, error = capsys.readouterr()
    assert out == ""
    assert error.count("\n") == 1
    assert re.match(f"error: {message}", error), error
    assert set(tmp_path.iterdir()) == before
