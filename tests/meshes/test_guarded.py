"""`pvphong.read`: all of a file or nothing; and through another process, whose end is one error."""

import numpy as np
import pytest
import pyvista as pv

import pvphong
from pvphong.meshes import files

DIES = "import os, sys; from pvphong.base import processes as p; p.begin_work(int(sys.argv[3])); {}"
READING = "p.say('reading', '0.3 ' + sys.argv[1]); "


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_a_mesh_comes_whole_through_another_process():
    grid = pv.ImageData(dimensions=(3, 4, 5)).cast_to_structured_grid()
    ball = pv.Sphere()
    ball.point_data["tint"] = np.linspace(0, 1, 3 * ball.n_points).reshape(-1, 3)
    blocks = pv.MultiBlock({"ball": ball, "none": None, "deep": pv.MultiBlock({"grid": grid})})
    blocks.save("blocks.vtm")
    read = pvphong.read("blocks.vtm", guarded=True)
    assert read.keys() == ["ball", "none", "deep"]
    assert read == pvphong.read("blocks.vtm") == blocks
    assert read["ball"].point_data.active_normals_name == "Normals"


def test_what_the_other_process_refuses_is_refused_in_the_same_words():
    pv.Sphere().save("half.vtp")
    with open("half.vtp", "rb+") as file:
        file.truncate(3000)
    said = []
    for how in (False, True):
        with pytest.raises(ValueError, match=r"^mesh must be .* got half\.vtp\. It is cut short") as error:
            pvphong.read("half.vtp", guarded=how)
        said.append(str(error.value))
    assert said[0] == said[1]


@pytest.mark.parametrize(
    ("work", "message"),
    [
        (READING + "os.abort()", r"^mesh must be .*; got some\.vtk\. A library has ended the process \(SIGABRT\)"),
        ("os.kill(os.getpid(), 9)", r"^The process was killed, as the system does where memory runs out\."),
        (READING + "import time; time.sleep(60)", r"got some\.vtk\. Reading it has come to no end"),
        ("sys.exit(3)", r"^A library has ended the process \(status 3\)"),
    ],
)
def test_the_end_of_the_other_process_is_an_error(monkeypatch, work, message):
    monkeypatch.setattr(files, "_CHILD", DIES.format(work))
    with pytest.raises(ValueError, match=message):
        pvphong.read("some.vtk", guarded=True)


def test_guarded_is_a_flag_and_needs_a_python_that_can_be_started(monkeypatch):
    with pytest.raises(ValueError, match=r"^guarded must be True or False"):
        pvphong.read("some.vtk", guarded="yes")
    monkeypatch.setattr(files.sys, "executable", "/opt/viewer")
    with pytest.raises(ValueError, match=r"^guarded must be False where Python cannot start itself"):
        pvphong.read("some.vtk", guarded=True)
