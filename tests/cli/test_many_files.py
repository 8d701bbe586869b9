"""`pvphong shade` for many files: what is many, who lights them, and the exit status."""

from pathlib import Path

import pytest
import pyvista as pv

import pvphong as ph
from pvphong.batch.shading import Batch
from pvphong.cli import shade
from pvphong.cli.app import main

pytest.importorskip("distributed")


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("a.vtp", "b.vtp"):
        pv.Sphere().save(name)
    ph.Scene([ph.DirectionalLight()], ph.Viewer()).save("rig.json")


def test_two_files_are_lit_and_one_that_cannot_be_makes_the_status_1(capsys):
    Path("c.vtp").write_text("garbage")
    assert main(["shade", "*.vtp", "-o", "lit/", "--workers", "1", "--material", "gold"]) == 1
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("2 done, 0 skipped, 1 failed.\nc.vtp: mesh must be a mesh file that PyVista can read")
    for name in ("a.vtp", "b.vtp"):
        assert pv.read(f"lit/{name}")["phong"].shape == (842, 3)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("a.vtp b.vtp -o lit", {"paths": ("a.vtp", "b.vtp"), "out": "lit", "client": None, "workers": None}),
        ("?.vtp -o lit --scheduler tcp://there:8786", {"paths": ("?.vtp",), "client": "tcp://there:8786"}),
        ("a.vtp -o lit/ --seams keep --array glow", {"paths": ("a.vtp",), "seams": "keep", "name": "glow"}),
        ("a.vtp -o . --workers 3 --tolerance 0.1 --components", {"workers": 3, "tolerance": 0.1, "components": True}),
        ("a.vtp -o lit/ --scene rig.json --shadows", {"feature_angle": "auto", "albedo": None}),
    ],
)
def test_words_become_arguments(words, expected, monkeypatch, capsys):
    given = {}

    def lit(paths, out, scene, **options):
        given.update(options, paths=paths, out=out, scene=scene)
        return Batch((Path("a.vtp"),), (), {})

    monkeypatch.setattr(shade, "shade_files", lit)
    assert main(["shade", *words.split()]) == 0
    assert capsys.readouterr().out == "1 done, 0 skipped, 0 failed.\n"
    assert given | expected == given
    assert (given["scene"] is not None and given["scene"].light_model.shadows) == ("--shadows" in words)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("a.vtp -o lit/ --workers 2 --scheduler tcp://there:1", "--workers must be left out beside --scheduler"),
        ("a.vtp b.vtp -o lit --occluder a.vtp --shadows", "--occluder must be left out where many files are lit"),
        ("a.vtp b.vtp -o lit --shadows", "--shadows must be left out without --scene where many files are lit"),
        ("a.vtp b.vtp -o lit --size 10 10", "--size must be left out"),
        ("a.vtp -o lit.vtp --workers 2", "--workers must be left out where a single mesh is lit into a file"),
        ("a.vtp -o lit.vtp --seams keep", "--seams must be left out where a single mesh"),
        ("no/*.vtp -o lit/", "paths must be a pattern that some file matches; got no/*.vtp."),
        ("a.vtp -o lit/ --scheduler tcp://127.0.0.1:1", "got tcp://127.0.0.1:1."),
    ],
)
def test_what_does_not_fit_is_refused_in_one_line(words, says, capsys):
    assert main(["shade", *words.split()]) == 2
    told = capsys.readouterr()
    assert says in told.err
    assert told.err.startswith("error: ")
    assert told.err.count("\n") == 1
    assert not Path("lit").exists()
