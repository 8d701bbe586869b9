"""Bad calls and inputs give one line on the error output, exit status 2, and no file."""

import json
import os
import subprocess
import sys
from pathlib import Path

import fuzzing
import pytest
import pyvista as pv

from pvphong.cli.app import main

NO_MESH, NO_FACES = "mesh must be a mesh file that PyVista can read", "mesh must be a mesh with faces, or points with"
NO_FOLDER, NO_OUTPUT = " must be in a folder that exists", "--output must be a file for "
SHADE = "shade sphere.vtp -o o.vtp"
REFUSED = {
    "fit sphere.vtp": "requires an argument",
    "fit sphere.vtp --target tint --vary intensity -o o.vtp": "--output must be a file for the lights (.json)",
    "fit sphere.vtp --target tin --vary intensity -o o.json": "error: --target must be an array with a luminance or a",
    "fit sphere.vtp --target tint --vary key:intensity --vary direction -o o.json": "--vary must be a light and its",
    "fit sphere.vtp --target tint --vary kee:intensity -o o.json": "error: --vary must be a mapping",
    "fit blocks.vtm --target tin --vary intensity -o o.json": "--target must be the name of a point array of a block",
    "fit sphere.vtp --target tint --vary intensity -o o.json --plot o.txt": "--plot must be a file for a picture",
    "shado": 'Unknown command "shado". Did you mean "shade"?',
    "shade": "MESH requires an argument",
    "shade m.vtp": "--output requires an argument",
    f"{SHADE} --colour red": "Unknown option: --colour. --diffuse sets the surface's colour.",
    f"{SHADE} --precision half": 'Choose from: "float32", "float64"',
    f"{SHADE} --size ten 10": "--size",
    "shade missing.vtp -o o.vtp": "mesh must be a file that exists; got missing.vtp.",
    "shade spere.vtp -o o.vtp": "got spere.vtp. Did you mean 'sphere.vtp'?",
    "shade parts.json -o o.vtp": "got parts.json. It is a scene file; pass it as --scene.",
    "shade half.ply -o o.vtp": NO_MESH,  # VTK's reader would end the process
    "shade beyond.vtp -o o.vtp": "index 9 in face 0",
    "shade faulty.vtm -o o.vtm": f"block ['cloud']: {NO_FACES}",
    "shade sphere.vtp -o o.stl": NO_OUTPUT + "a mesh (.vtp,",
    "shade sphere.vtp -o o.vtm": NO_OUTPUT + "the colours of a single mesh",
    "shade sphere.vtp -o no/o.vtp": "--output" + NO_FOLDER,
    f"{SHADE} --tolerance 1/0": 'Invalid value for --tolerance: unable to convert "1/0" into a number',
    f"{SHADE} --scene no.json": "--scene must be a scene file that can be read; got no.json",
    f"{SHADE} --material golt": "Did you mean 'gold'?",
    f"{SHADE} --reflectance ggxx": "Did you mean 'ggx'?",
    f"{SHADE} --reflectance ggx:rough=1": "Did you mean 'roughness'?",
    f"{SHADE} --reflectance ggx": "--reflectance must be given with its roughness; got ggx.",
    f"{SHADE} --reflectance ggx:roughness": "--reflectance ggx must be followed by fields, as in",
    f"{SHADE} --tolerance=-1": "error: --tolerance must be a finite number >= 0",
    f"{SHADE} --albedo pine.png": "albedo must be a point array, or an image file that exists; got pine",
    f"{SHADE} --albedo oak.png": "albedo must be an array, its name, or a texture for a mesh with",
    f"{SHADE} --scalars heigth": "Did you mean 'height'?",
    f"{SHADE} --scalars height --cmap terain": "Did you mean 'terrain' or",
    f"{SHADE} --scalars height --clim 8,0": "clim must be two finite numbers, the smaller first",
    f"{SHADE} --scalars height --clim nan,1": "clim must be two finite numbers, the smaller first",
    f"{SHADE} --scalars height --albedo red": "--albedo must be omitted with --scalars",
    f"{SHADE} --cmap terrain": "--cmap must be used together with --scalars",
    f"{SHADE} --scene other.json": '--scene must be a scene file, a JSON object with "format": "pvphong scene"',
    f"{SHADE} --scene parts.json": "material must be one material, or a mapping with the key 'default'",
    f"{SHADE} --occluder roof.vtp": "--occluder must be used with shadows, ambient occlusion or bounces; got roof.vtp.",
    f"{SHADE} --background red": "--background must be used with a .png output only",
    f"{SHADE} --exposure 1": "--exposure must be used with a .png output only",
    f"{SHADE} --tone filmic": "--tone must be used with a .png output only",
    "shade sphere.vtp -o o.png --exposure 11": "error: --exposure must be a finite number >= -10 and <= 10",
    "shade sphere.vtp -o o.png --components": "--components must be omitted: a .png file has no named arrays",
    "shade sphere.vtp -o o.ply --array lit": "--array must be omitted: a .ply file has no named arrays",
    "shade sphere.vtp -o o.vtk --compress lz4": "--compress must be used with .vtp, .vtm, .vtmb only",
    f"{SHADE} --workers 2": "--workers must be omitted for a single mesh and an output file",
    "shade sphere.vtp cube.vtp -o lit.vtp": (
        "--output must be a folder for many meshes; got lit.vtp. -o lit.vtp/ makes a folder of that name."
    ),
    "shade *.vtp -o lit.png": "--output must be a folder for many meshes; got lit.png.",
    "shade sphere.vtp -o lit/ --workers 2 --scheduler tcp://a:1": "--workers must be omitted with --scheduler",
    f"{SHADE} --max-points 9": "--max-points must be used with --refine",
    f"{SHADE} --refine 0.1 --components": "--components must be omitted with --refine",
    f"{SHADE} --refine 0": "error: --refine must be a finite number > 0",
    f"{SHADE} --feature-angle 400": "error: --feature-angle must be a finite number >= 0 and <= 180",
    "shade blocks.vtm -o lit/ --scene bounces.json": "the light model must be without bounces for a surface in several",
    "shade sphere.vtp cube.vtp -o lit --refine 0.1": "--refine must be omitted for many files",
    "shade sphere.vtp cube.vtp -o lit --refine 0": "--refine must be omitted for many files",
    f"{SHADE} --workers 0": "--workers must be omitted for a single mesh and an output file",
    f"{SHADE} --max-points 0": "--max-points must be used with --refine",
    "shade sphere.vtp cube.vtp -o lit --occluder roof.vtp": "--occluder must be omitted for many files",
    "shade sphere.vtp cube.vtp -o lit --shadows": "--shadows must be used with --scene for many files",
    "shade sphere.vtp cube.vtp -o lit --sun 315,20": "--sun must be used with --scene for many files",
    f"{SHADE} --sun 315": "--sun must be two numbers separated by a comma; got 315.",
    f"{SHADE} --sun 315,100": "elevation must be a finite number >= -90 and <= 90",
    "shade no/*.vtp -o lit/": "paths must be a pattern that matches a file; got no/*.vtp.",
    "shade sphere.vtp -o lit/ --scheduler tcp://127.0.0.1:1": "error: --scheduler must be the address of a",
    "plan blocks.vtm --scene parts.json": "material must be a mapping with the names of all blocks",
    "validate": "MESH must be given, or --all instead",
    "validate sphere.vtp --output errors.ply": NO_OUTPUT + "a mesh with signed errors",
    "validate sphere.vtp --scene opengl.json --specular 0.5": "scene must be a scene that VTK can draw",
    "validate sphere.vtp --shadows": "The nearest scene that it can draw: none of these.\n",
    "validate blocks.vtm --output errors.vtp": NO_OUTPUT + "a mesh with signed errors (.vtm,",
    "validate sphere.vtp --report all.md": "--report must be used together with --all",
    "validate sphere.vtp --all": "--all must be used alone or with --report",
    "validate --all --shininess 4": "--all must be used alone or with --report",
    "validate --all --report all.pdf": ".md",
    "validate --all --report=no/all.md": "--report" + NO_FOLDER,
    "tradeoff sphere.vtp --tolerance 0": "tolerance must be a finite number > 0",
    "tradeoff sphere.vtp --plot no/a.png": "--plot" + NO_FOLDER,
    "tradeoff sphere.vtp --plot a.bmp": "suffix of --plot must be one of",
    "demo --folder garbage.json": "folder must be a folder that can be created; got garbage.json",
}


def run(words):
    return main(words.split())


@pytest.mark.parametrize(("words", "message"), REFUSED.items(), ids=REFUSED)
def test_a_wrong_call_or_input_is_one_line_status_2_and_no_file(capfd, monkeypatch, words, message):
    if "lit" in words:
        pytest.importorskip("distributed")
    monkeypatch.setattr("pvphong.studies.accuracy.measure.interleaved", lambda *_: pytest.fail("it measured"))
    before = sorted(os.listdir())
    assert run(words) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert message in err
    assert sorted(os.listdir()) == before


@pytest.mark.parametrize(
    ("error", "status", "said"),
    [
        (KeyboardInterrupt, 130, ""),
        (OSError("disk\n full"), 2, "error: disk full\n"),
        (MemoryError, 2, "error: Not enough memory.\n"),
        (KeyError("x"), 2, "error: KeyError: 'x' (a bug in pvphong; --verbose prints the traceback)\n"),
    ],
)
def test_an_interruption_and_a_failing_machine_are_no_traceback(monkeypatch, capsys, error, status, said):
    def fail(_path):
        raise error

    monkeypatch.setattr("pvphong.cli.options.read_mesh", fail)
    assert run("shade sphere.vtp -o lit.vtp") == status
    assert capsys.readouterr().err == said


def test_what_cannot_be_printed_is_an_error(monkeypatch, capsys):
    def flush():
        raise OSError("no space left")

    with monkeypatch.context() as patch:
        patch.setattr(sys.stdout, "flush", flush)
        assert run("plan sphere.vtp") == 2
    assert capsys.readouterr().err == "error: no space left\n"


@pytest.mark.parametrize("count", [pytest.param(16, id="few"), pytest.param(10_000, id="many", marks=pytest.mark.long)])
def test_damaged_files_are_refused_or_read_as_they_are(count):
    command = [sys.executable, "-W", "ignore", fuzzing.__file__, str(count)]
    report = json.loads(subprocess.run(command, capture_output=True, text=True, check=False).stdout)
    assert (report["files"], report["faults"], report["cut_and_accepted"]) == (count, [], {})
    assert {"0", "2"} <= {words.split()[1] for words in report["statuses"]}  # some are rejected, some are read


def test_of_many_files_one_that_cannot_be_lit_makes_the_status_1(capsys):
    pytest.importorskip("distributed")
    assert run("shade sphere.vtp half.ply cube.vtp -o lit/ --workers 1 --material gold --compress none") == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("2 done, 0 skipped, 1 failed.\nhalf.ply: mesh must be a mesh file that PyVista can read")
    for name in ("sphere.vtp", "cube.vtp"):
        assert "phong" in pv.read(f"lit/{name}").point_data
        assert b"compressor" not in Path("lit", name).read_bytes()


GIVEN = {
    "sphere.vtp cube.vtp -o a": {"paths": ("sphere.vtp", "cube.vtp"), "out": "a", "client": None, "workers": None},
    "?ube.vtp -o a --scheduler tcp://there:8786": {"paths": ("?ube.vtp",), "client": "tcp://there:8786"},
    "cube.vtp -o a/ --seams keep --array glow": {"paths": ("cube.vtp",), "seams": "keep", "name": "glow"},
    "cube.vtp -o . --workers 3 --tolerance 0.1 --components": {"workers": 3, "tolerance": 0.1, "components": True},
    "cube.vtp -o a/ --scene sun.json --shadows": {"feature_angle": "auto", "compress": "lz4"},
}


@pytest.mark.parametrize(("words", "expected"), GIVEN.items())
def test_words_become_arguments_of_shade_files(words, expected, monkeypatch, capsys):
    from pvphong.batch.run import Batch
    from pvphong.cli import shade

    given = {}

    def lit(paths, out, scene, material, **options):
        given.update(options, paths=paths, out=out, scene=scene, material=material)
        return Batch((Path("a.vtp"),), (), {})

    monkeypatch.setattr(shade, "shade_files", lit)
    assert run(f"shade {words}") == 0
    assert capsys.readouterr().out == "1 done, 0 skipped, 0 failed.\n"
    assert given | expected == given
    assert (given["scene"] is not None and given["scene"].light_model.shadows) == ("--shadows" in words)


def test_a_remark_on_many_files_names_the_option(monkeypatch, capsys):
    from pvphong.batch.run import Batch
    from pvphong.batch.shading import _APART
    from pvphong.cli import shade

    monkeypatch.setattr(shade, "shade_files", lambda *_, **__: Batch((Path("a.vtp"),), (), {}, _APART))
    assert run("shade sphere.vtp cube.vtp -o a/") == 0
    out = capsys.readouterr().out.replace("\n ", "")
    assert "--seams merge treats them as pieces of one surface." in out
    assert "seams=" not in out


def test_a_tolerance_may_be_a_quotient(capsys):
    assert run("plan sphere.vtp --tolerance 1/255") == 0
    assert "tolerance 0.00392;" in capsys.readouterr().out


def test_one_file_is_lit_into_a_folder_without_dask_and_several_are_not(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "distributed", None)
    for counts in ("1 done, 0 skipped", "0 done, 1 skipped"):
        assert run("shade sphere.vtp -o lit/ --material gold") == 0
        assert counts in capsys.readouterr().out
    assert pv.read("lit/sphere.vtp")["phong"].shape == (pv.read("sphere.vtp").n_points, 3)
    assert run("shade half.ply -o lit/") == 1
    assert "half.ply: " in capsys.readouterr().err
    assert run("shade sphere.vtp cube.vtp -o lit/") == 2
    assert "Without Dask, light each file by its own call." in capsys.readouterr().err
