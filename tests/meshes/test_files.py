import json
import logging
import os
import re
import resource
import subprocess
import sys
import warnings
from collections import namedtuple
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import interrupting
import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong.base import files as base_files
from pvphong.base import processes
from pvphong.meshes import files as mesh_files
from pvphong.meshes.files import BLOCK_FORMATS, MESH_FORMATS, read_mesh, save_lit


@pytest.fixture
def lit(tmp_path, monkeypatch):
    """A lit mesh, in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    mesh = pv.Sphere(theta_resolution=6, phi_resolution=6)
    mesh["phong"] = np.linspace(0, 1, 3 * mesh.n_points, dtype=np.float32).reshape(-1, 3)
    return mesh


def save(mesh, name):
    save_lit(mesh, Path(name), "phong")


def names():
    return sorted(os.listdir())


# --- writing ---


@pytest.mark.parametrize("suffix", [*MESH_FORMATS, *map(str.upper, MESH_FORMATS)])
def test_what_is_saved_comes_back_and_the_mesh_is_left_alone(lit, suffix):
    """All arrays are equal bit for bit; a .ply file has only the colours, as 8-bit vertex colours."""
    lit.active_texture_coordinates = np.zeros((lit.n_points, 2))  # VTK's .ply writer crashes at float64
    before = lit.copy()
    save(lit, f"lit{suffix}")
    assert lit == before
    assert names() == [f"lit{suffix}"]
    again = read_mesh(f"lit{suffix}")
    np.testing.assert_array_equal(again.points, lit.points)
    if suffix.lower() == ".ply":
        header = Path(f"lit{suffix}").read_bytes().split(b"end_header")[0].decode()
        assert all(f"property uchar {channel}" in header for channel in ("red", "green", "blue"))
        np.testing.assert_array_equal(again["RGB"], np.rint(255 * np.clip(lit["phong"], 0, 1)))
    else:
        np.testing.assert_array_equal(again["phong"], lit["phong"])
        assert again["phong"].dtype == np.float32


def test_a_ply_file_gets_the_lit_colours_of_points_where_a_cell_array_has_their_name(lit):
    lit.cell_data["phong"] = np.zeros((lit.n_cells, 3))
    save(lit, "lit.ply")
    np.testing.assert_array_equal(read_mesh("lit.ply")["RGB"], np.rint(255 * lit.point_data["phong"]))


COMPRESSORS = {"lz4": "LZ4", "zlib": "ZLib", "none": None}


@pytest.mark.parametrize("compress", [*COMPRESSORS, None])
@pytest.mark.parametrize("suffix", [".vtp", ".vtm", ".vtmb"])
def test_xml_files_are_compressed_as_asked_and_by_lz4_otherwise(lit, suffix, compress):
    has_blocks = suffix != ".vtp"
    options = {} if compress is None else {"compress": compress}
    save_lit(pv.MultiBlock([lit]) if has_blocks else lit, Path(f"lit{suffix}"), "phong", **options)
    (written,) = Path("lit").glob("*.vtp") if has_blocks else [Path("lit.vtp")]
    found = re.search(rb'compressor="vtk(\w+)DataCompressor"', written.read_bytes())
    assert (found and found[1].decode()) == COMPRESSORS[compress or "lz4"]
    read = read_mesh(f"lit{suffix}")
    np.testing.assert_array_equal((read[0] if has_blocks else read)["phong"], lit["phong"])


@pytest.mark.parametrize("suffix", [*BLOCK_FORMATS, *map(str.upper, BLOCK_FORMATS)])
def test_blocks_come_back_with_their_names(lit, suffix):
    blocks = pv.MultiBlock({"one": lit, "deep": pv.MultiBlock({"two": lit.copy()})})
    Path("there").mkdir()
    Path(f"lit{suffix}").symlink_to(f"there/lit{suffix}")
    for _ in range(2):  # writing over an older result is allowed
        save(blocks, f"lit{suffix}")
    assert names() == [f"lit{suffix}", "there"]
    again = read_mesh(f"lit{suffix}")
    assert again.keys() == ["one", "deep"]
    np.testing.assert_array_equal(again["deep"]["two"]["phong"], lit["phong"])


def test_blocks_of_older_files_are_removed_and_those_of_a_failure_too(lit, monkeypatch):
    save(pv.MultiBlock([lit, lit.copy()]), "lit.vtm")
    save(pv.MultiBlock([lit]), "lit.vtm")
    (block,) = Path("lit").iterdir()
    replace = Path.replace

    def replace_blocks(path, target):
        if path.suffix == ".vtm":
            raise PermissionError("denied")
        return replace(path, target)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", replace_blocks)
        with pytest.raises(ValueError, match="denied"):
            save(pv.MultiBlock([lit, lit]), "lit.vtm")
    np.testing.assert_array_equal(read_mesh("lit.vtm")[0]["phong"], lit["phong"])
    assert list(Path("lit").iterdir()) == [block]


def test_files_of_others_in_the_blocks_folder_stay_and_a_file_of_its_name_is_in_the_way(lit):
    notes = Path("lit/notes.txt")
    notes.parent.mkdir()
    notes.write_text("mine")
    save(pv.MultiBlock([lit]), "lit.vtm")
    assert notes.read_text() == "mine"
    Path("other").write_text("in the way")
    with pytest.raises(ValueError, match=r"^output could not be written: its blocks need the folder .*other \("):
        save(pv.MultiBlock([lit]), "other.vtm")
    assert names() == ["lit", "lit.vtm", "other"]


@pytest.mark.parametrize(
    ("name", "has_blocks", "options", "message"),
    [
        *[(f"lit{suffix}", False, {}, r"path .* a single mesh \(\.vtp, ") for suffix in (".stl", "", ".vtm")],
        *[(f"lit{suffix}", True, {}, r"path .* a MultiBlock \(\.vtm, ") for suffix in (".vtp", ".ply")],
        ("lit.vtp", False, {"compress": "lzma"}, "compress must be one of 'lz4', 'zlib', 'none'; got lzma"),
        ("no/lit.vtp", False, {}, "path must be in a folder that exists"),
    ],
)
def test_what_cannot_be_written_is_refused_before_anything_is(lit, name, has_blocks, options, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        save_lit(pv.MultiBlock([lit]) if has_blocks else lit, Path(name), "phong", **options)
    assert names() == []


def full_disk(monkeypatch, _):
    usage = namedtuple("usage", "total used free")(2**30, 2**30, 1000)
    monkeypatch.setattr(base_files.shutil, "disk_usage", lambda _path: usage)


def failing_writer(monkeypatch, kind):
    writer, method = (pv.XMLPolyDataWriter, "write") if kind is pv.PolyData else (kind, "save")
    written = getattr(writer, method)

    def failing(self, *path, **options):
        written(self, *path, **options)
        raise OSError("VTK writer failed")

    monkeypatch.setattr(writer, method, failing)


FULL = r"^path must be .* needs up to .* MiB on its disk, and only 0\.0 MiB are free"
FAILING = r"^output could not be written: VTK writer failed"


@pytest.mark.parametrize(
    ("suffix", "mishap", "message"),
    [
        (".vtkhdf", full_disk, FULL),
        (".vtm", full_disk, FULL),
        (".vtp", failing_writer, FAILING),
        (".vtm", failing_writer, FAILING),
    ],
)
def test_a_mishap_leaves_the_old_file(lit, monkeypatch, suffix, mishap, message):
    Path(f"lit{suffix}").write_text("old")
    mesh = pv.MultiBlock([lit]) if suffix == ".vtm" else lit
    mishap(monkeypatch, type(mesh))
    with pytest.raises(ValueError, match=message):
        save(mesh, f"lit{suffix}")
    assert Path(f"lit{suffix}").read_text() == "old"
    assert names() == [f"lit{suffix}"]


@contextmanager
def files_of_at_most(size):
    """Limit the size of files, as on a nearly full disk."""
    old = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, old[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, old)


@pytest.mark.parametrize("suffix", [".vtp", ".vtk", ".ply", ".vtm"])
@pytest.mark.usefixtures("lit")
def test_a_file_needs_no_more_room_than_it_takes_and_without_it_the_old_one_stays(suffix):
    """The file of this mesh is much smaller than its memory."""
    plane = pv.Plane(i_resolution=200, j_resolution=200)
    plane["phong"], plane["flag"] = np.full((plane.n_points, 3), 0.5), np.ones(plane.n_points, bool)
    mesh = pv.MultiBlock({"one": plane, "two": plane.copy()}) if suffix == ".vtm" else plane
    save(mesh, f"lit{suffix}")
    size = max(path.stat().st_size for path in Path().rglob("*") if path.is_file())
    assert suffix in (".vtk", ".ply") or size < 512 * plane.actual_memory_size
    with files_of_at_most(size + 2**12):  # in memory, VTK leaves space between a .vtp file's attributes
        save(mesh, f"lit{suffix}")
    before = sorted(Path().rglob("*"))
    with files_of_at_most(size // 2), pytest.raises(ValueError, match=r"^(output could|path must)"):
        save(mesh, f"lit{suffix}")
    assert sorted(Path().rglob("*")) == before
    again = read_mesh(f"lit{suffix}")
    assert again.bounds == pytest.approx(plane.bounds)
    assert suffix != ".vtp" or again["flag"].dtype == bool


def test_blocks_of_all_sorts_keep_their_places(lit):
    deep = pv.MultiBlock({"grid": pv.ImageData(dimensions=(2, 2, 2)), "gap": None, "ball": lit.translate((1, 0, 0))})
    parts = {"gap": None, "hollow": pv.MultiBlock(), "deep": deep}
    blocks = pv.MultiBlock({**parts, "void": pv.PolyData(), "last": lit})
    blocks.field_data["made"] = [7.0]
    save(blocks, "lit.vtm")
    found = read_mesh("lit.vtm")
    assert found.keys() == blocks.keys()
    assert found["deep"].keys() == deep.keys()
    assert (found["deep"]["ball"], found["last"]) == (deep["ball"], lit)
    assert (found["gap"], found["deep"]["gap"], found["deep"]["grid"].n_points) == (None, None, 8)
    assert list(found.field_data["made"]) == [7]


# --- reading ---


def half_a_file(lit, name):
    lit.save(name)
    Path(name).write_bytes(Path(name).read_bytes()[: Path(name).stat().st_size // 2])


GARBAGE = [f"garbage{suffix}" for suffix in (".vtp", ".vtk", ".vtu", ".ply", ".stl", ".vtm", ".xyz", ".pkl", "")]


@pytest.mark.parametrize("name", [*GARBAGE, "half.vtp", "half.stl", "half.ply", "missing.vtp", "missing.ply"])
def test_what_is_no_whole_mesh_file_is_refused_in_silence_with_one_error(lit, capfd, name):
    if name.startswith("garbage"):
        Path(name).write_text("garbage")
    elif name.startswith("half"):
        half_a_file(lit, name)
    readable = r"mesh file that PyVista can read .*" if Path(name).exists() else "file that exists"
    message = rf"^mesh must be a {readable}; got .*{name}\." + (r" .*\S+" if Path(name).exists() else "$")
    with pytest.raises(ValueError, match=message):
        read_mesh(name)
    assert capfd.readouterr() == ("", "")


@pytest.mark.usefixtures("lit")
def test_a_name_that_no_file_can_have_is_refused():
    os.symlink("loop.vtp", "loop.vtp")
    for name, reason in (("a" * 300 + ".vtp", "File name too long"), ("loop.vtp", "Too many levels of symbolic links")):
        with pytest.raises(ValueError, match=rf"^mesh must be a file that exists; got {name}\. {reason}\."):
            ph.read(name)


def test_where_the_process_is_watched_it_is_while_a_mesh_is_read(lit, monkeypatch):
    """This holds for any reader, for example of an occluder on the command line."""
    heard = []
    monkeypatch.setattr(processes, "watcher", -1)
    monkeypatch.setattr(processes, "say", lambda what, more="": heard.append([what, *more.split()[1:]]))
    save(lit, "lit.vtp")
    half_a_file(lit, "half.vtp")
    read_mesh("lit.vtp")
    with pytest.raises(ValueError, match="cut short"):
        read_mesh("half.vtp")
    assert heard == [["reading", "lit.vtp"], ["done"], ["reading", "half.vtp"], ["done"]]


def test_a_table_is_no_mesh(monkeypatch, tmp_path):
    monkeypatch.setattr(mesh_files.pv, "read", lambda _path: pv.Table(np.zeros((2, 2))))
    monkeypatch.chdir(tmp_path)
    Path("table.vtt").touch()
    with pytest.raises(ValueError, match=r"^mesh must be a dataset or a MultiBlock; got a Table in table\.vtt"):
        read_mesh("table.vtt")


def test_threads_that_read_and_write_at_once_leave_logging_and_warnings_as_they_were(lit):
    before = logging.root.manager.disable, list(warnings.filters)

    def work(number):
        save(lit, f"{number}.vtp")
        return read_mesh(f"{number}.vtp") == lit

    with ThreadPoolExecutor(20) as threads:
        assert all(threads.map(work, range(100)))
    assert (logging.root.manager.disable, list(warnings.filters)) == before
    assert names() == sorted(f"{number}.vtp" for number in range(100))


# --- reading in another process, whose crash is a single error ---

DIES = "import os, sys; from pvphong.base import processes as p; p.begin_work(int(sys.argv[3])); {}"
READING = "p.say('reading', '0.3 ' + sys.argv[1]); "


@pytest.mark.usefixtures("lit")
def test_a_mesh_comes_whole_through_another_process():
    grid = pv.ImageData(dimensions=(3, 4, 5)).cast_to_structured_grid()
    ball = pv.Sphere()
    ball.point_data["tint"] = np.linspace(0, 1, 3 * ball.n_points).reshape(-1, 3)
    blocks = pv.MultiBlock({"ball": ball, "none": None, "deep": pv.MultiBlock({"grid": grid})})
    blocks.save("blocks.vtm")
    read = ph.read("blocks.vtm", guarded=True)
    assert read.keys() == ["ball", "none", "deep"]
    assert read == ph.read("blocks.vtm") == blocks
    assert read["ball"].point_data.active_normals_name == "Normals"


def test_what_a_reader_prints_spoils_nothing(lit, monkeypatch):
    save(lit, "lit.vtp")
    monkeypatch.setattr(mesh_files, "_CHILD", f"print('32 faces', flush=True); {mesh_files._CHILD}")
    assert ph.read("lit.vtp", guarded=True) == lit


def test_what_the_other_process_refuses_is_refused_in_the_same_words(lit):
    half_a_file(lit, "half.vtp")
    said = []
    for how in (False, True):
        with pytest.raises(ValueError, match=r"^mesh must be .* got half\.vtp\. It is cut short") as error:
            ph.read("half.vtp", guarded=how)
        said.append(str(error.value))
    assert said[0] == said[1]


@pytest.mark.parametrize(
    ("work", "message"),
    [
        (READING + "os.abort()", r"^mesh must be .*; got some\.vtk\. A library crashed \(SIGABRT\)"),
        ("os.kill(os.getpid(), 9)", r"^The process was killed, probably because memory ran out\."),
        (READING + "import time; time.sleep(60)", r"got some\.vtk\. Reading timed out"),
        ("sys.exit(3)", r"^A library crashed \(status 3\)"),
    ],
)
def test_the_end_of_the_other_process_is_an_error(monkeypatch, work, message):
    monkeypatch.setattr(mesh_files, "_CHILD", DIES.format(work))
    with pytest.raises(ValueError, match=message):
        ph.read("some.vtk", guarded=True)


def test_guarded_is_a_flag_and_needs_a_python_that_can_be_started(monkeypatch):
    with pytest.raises(ValueError, match=r"^guarded must be True or False"):
        ph.read("some.vtk", guarded="yes")
    monkeypatch.setattr(mesh_files.sys, "executable", "/opt/viewer")
    with pytest.raises(ValueError, match=r"^guarded must be False, because Python cannot start a second"):
        ph.read("some.vtk", guarded=True)


# --- atomic writes, even if the writer is killed or exceeds a limit ---


@pytest.mark.parametrize(
    ("kills", "limits"), [pytest.param(10, 3, id="few"), pytest.param(500, 20, id="many", marks=pytest.mark.long)]
)
def test_the_old_file_is_there_or_the_new_one(kills, limits):
    command = [sys.executable, "-W", "ignore", interrupting.__file__, str(kills), str(limits)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["faults"] == []
    assert report["kills"] == kills
    assert report["in mid-write"] > 0
