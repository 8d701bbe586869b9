from collections import namedtuple

import numpy as np
import pytest
import pyvista as pv

from pvphong.meshes import files as mesh_files
from pvphong.meshes.files import BLOCK_FORMATS, MESH_FORMATS, eight_bit, read_mesh, save_lit


@pytest.fixture
def lit():
    mesh = pv.Sphere(theta_resolution=6, phi_resolution=6)
    mesh["phong"] = np.linspace(0, 1, 3 * mesh.n_points, dtype=np.float32).reshape(-1, 3)
    return mesh


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


# -- writing


@pytest.mark.parametrize("suffix", [".vtp", ".vtk", ".vtkhdf", ".VTP"])
def test_all_arrays_come_back_bit_for_bit(tmp_path, lit, suffix):
    save_lit(lit, tmp_path / f"lit{suffix}", "phong")
    again = read_mesh(str(tmp_path / f"lit{suffix}"))
    np.testing.assert_array_equal(again["phong"], lit["phong"])
    assert again["phong"].dtype == np.float32
    np.testing.assert_array_equal(again.points, lit.points)
    assert names_in(tmp_path) == [f"lit{suffix}"]


def test_ply_has_eight_bit_vertex_colors_in_the_usual_place(tmp_path, lit):
    save_lit(lit, tmp_path / "lit.ply", "phong")
    header = (tmp_path / "lit.ply").read_bytes().split(b"end_header")[0].decode()
    assert all(f"property uchar {channel}" in header for channel in ("red", "green", "blue"))
    np.testing.assert_array_equal(read_mesh(str(tmp_path / "lit.ply"))["RGB"], np.rint(255 * lit["phong"]))


def test_saving_changes_nothing_in_the_mesh(tmp_path, lit):
    before = lit.copy()
    for suffix in MESH_FORMATS:
        save_lit(lit, tmp_path / f"lit{suffix}", "phong")
    assert lit == before


def test_eight_bit_rounds_and_clips():
    assert eight_bit([-1.0, 0.0, 0.4999 / 255, 0.5001 / 255, 0.5, 1.0, 2.0]).tolist() == [0, 0, 0, 1, 128, 255, 255]


@pytest.mark.parametrize("suffix", BLOCK_FORMATS)
def test_blocks_come_back_with_their_names(tmp_path, lit, suffix):
    blocks = pv.MultiBlock({"one": lit, "deep": pv.MultiBlock({"two": lit.copy()})})
    for _ in range(2):  # writing over an older result is allowed
        save_lit(blocks, tmp_path / f"lit{suffix}", "phong")
    again = read_mesh(str(tmp_path / f"lit{suffix}"))
    assert again.keys() == ["one", "deep"]
    np.testing.assert_array_equal(again["deep"]["two"]["phong"], lit["phong"])
    assert not [name for name in names_in(tmp_path) if name.startswith(".")]


def test_blocks_beside_a_file_with_their_folders_name_are_refused(tmp_path, lit):
    (tmp_path / "lit").write_text("in the way")
    with pytest.raises(ValueError, match=r"output needs the folder .*lit for its blocks"):
        save_lit(pv.MultiBlock([lit]), tmp_path / "lit.vtm", "phong")
    assert names_in(tmp_path) == ["lit"]


def test_files_of_others_in_the_blocks_folder_stay(tmp_path, lit):
    (tmp_path / "lit").mkdir()
    (tmp_path / "lit" / "notes.txt").write_text("mine")
    save_lit(pv.MultiBlock([lit]), tmp_path / "lit.vtm", "phong")
    assert (tmp_path / "lit" / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize("name", ["lit.stl", "lit.obj", "lit", "lit.vtm", "lit.png"])
def test_formats_without_room_for_colors_are_refused(tmp_path, lit, name):
    with pytest.raises(ValueError, match=r"output must be .* colours of a single mesh: one of \.vtp, .* got .*lit"):
        save_lit(lit, tmp_path / name, "phong")
    assert names_in(tmp_path) == []


@pytest.mark.parametrize("name", ["lit.vtp", "lit.ply"])
def test_formats_for_one_mesh_are_refused_for_blocks(tmp_path, lit, name):
    with pytest.raises(ValueError, match=r"output must be .* colours of a MultiBlock: one of \.vtm"):
        save_lit(pv.MultiBlock([lit]), tmp_path / name, "phong")


def test_a_folder_that_is_not_there_is_refused(tmp_path, lit):
    with pytest.raises(ValueError, match="path must be in a folder that exists"):
        save_lit(lit, tmp_path / "no" / "lit.vtp", "phong")


@pytest.mark.parametrize("suffix", [".vtp", ".vtm"])
def test_a_full_disk_is_noticed_before_the_old_file_is_touched(tmp_path, lit, monkeypatch, suffix):
    (tmp_path / f"lit{suffix}").write_text("old")
    usage = namedtuple("usage", "total used free")(2**30, 2**30, 1000)
    monkeypatch.setattr(mesh_files.shutil, "disk_usage", lambda _path: usage)
    with pytest.raises(ValueError, match=r"output needs up to .* MiB on its disk, and 0\.0 are free"):
        save_lit(lit if suffix == ".vtp" else pv.MultiBlock([lit]), tmp_path / f"lit{suffix}", "phong")
    assert (tmp_path / f"lit{suffix}").read_text() == "old"
    assert names_in(tmp_path) == [f"lit{suffix}"]


@pytest.mark.parametrize("suffix", [".vtp", ".vtm"])
def test_a_writer_that_fails_leaves_the_old_file(tmp_path, lit, monkeypatch, suffix):
    (tmp_path / f"lit{suffix}").write_text("old")
    mesh = lit if suffix == ".vtp" else pv.MultiBlock([lit])
    save = type(mesh).save

    def failing(self, path, **options):
        save(self, path, **options)
        raise OSError("VTK writer failed")

    monkeypatch.setattr(type(mesh), "save", failing)
    with pytest.raises(ValueError, match=f"output could not be written to lit{suffix}: VTK writer failed"):
        save_lit(mesh, tmp_path / f"lit{suffix}", "phong")
    assert (tmp_path / f"lit{suffix}").read_text() == "old"
    assert names_in(tmp_path) == [f"lit{suffix}"]


# -- reading


def test_what_pyvista_reads_is_read(tmp_path, lit):
    lit.save(tmp_path / "a.stl")
    pv.ImageData(dimensions=(3, 3, 3)).save(tmp_path / "a.vti")
    assert isinstance(read_mesh(str(tmp_path / "a.stl")), pv.PolyData)
    assert isinstance(read_mesh(str(tmp_path / "a.vti")), pv.ImageData)


GARBAGE = [".vtp", ".vtk", ".vtu", ".ply", ".stl", ".vtm", ".xyz", ".pkl", ""]


@pytest.mark.parametrize("suffix", GARBAGE)
def test_garbage_is_refused_in_silence_with_one_error(tmp_path, capfd, suffix):
    path = tmp_path / f"garbage{suffix}"
    path.write_text("garbage")
    with pytest.raises(ValueError, match=r"mesh must be a mesh file that PyVista can read .* got .*garbage.*\. \S+"):
        read_mesh(str(path))
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", ["missing.vtp", "missing.ply"])
def test_a_file_that_is_not_there_is_refused(tmp_path, name):
    with pytest.raises(ValueError, match=rf"mesh must be .* got .*{name}.* not found"):
        read_mesh(str(tmp_path / name))


@pytest.mark.parametrize("suffix", [".vtp", ".stl", ".ply"])
def test_half_a_file_is_refused(tmp_path, lit, suffix):
    whole, half = tmp_path / f"whole{suffix}", tmp_path / f"half{suffix}"
    lit.save(whole)
    half.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    with pytest.raises(ValueError, match="mesh must be a mesh file that PyVista can read"):
        read_mesh(str(half))


def test_a_ply_file_gives_what_pyvista_reads(tmp_path, lit):
    lit.compute_normals(inplace=True)
    save_lit(lit, tmp_path / "lit.ply", "phong")
    assert read_mesh(str(tmp_path / "lit.ply")) == pv.read(tmp_path / "lit.ply")


def test_a_table_is_no_mesh(monkeypatch):
    monkeypatch.setattr(mesh_files.pv, "read", lambda _path: pv.Table(np.zeros((2, 2))))
    with pytest.raises(ValueError, match=r"mesh must be a dataset or a MultiBlock; got a Table in table\.vtt"):
        read_mesh("table.vtt")
