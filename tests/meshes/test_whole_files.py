"""Truncated or inconsistent files are refused before VTK reads them; complete files are not."""

import random
import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from fuzzing import write_formats
from vtkmodules import vtkIOXML

from pvphong.meshes.whole_files import refuse_incomplete

ENDS = (".vtp", ".vtu", ".vts", ".vtr", ".vti", ".vtm", ".vtmb", ".vtkhdf", ".ply", ".stl")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("whole")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        write_formats(place)
    return place


def test_whole_files_pass(folder):
    paths = list(folder.rglob("*.*"))
    assert {path.suffix for path in paths} >= {".vtp", ".vtu", ".vti", ".vtk", ".vtkhdf", ".ply", ".stl", ".obj"}
    for path in paths:
        refuse_incomplete(path)


def refused(path):
    try:
        refuse_incomplete(path)
    except ValueError:
        return True
    return False


def test_files_that_are_cut_anywhere_are_refused(folder, tmp_path):
    """Each format is cut at hundreds of places, except within trailing white space."""
    for path in sorted(folder.iterdir()):
        if path.suffix in ENDS:
            contents = path.read_bytes().rstrip() if "text" in path.stem or path.suffix != ".ply" else path.read_bytes()
            for end in random.Random(1).sample(range(1, len(contents)), 100):
                cut = tmp_path / path.name
                cut.write_bytes(contents[:end])
                assert refused(cut), (path.name, end)


def test_a_file_that_names_others_is_whole_if_they_are(folder, tmp_path):
    shutil.copytree(folder / "blocks", tmp_path / "blocks")
    whole = shutil.copy(folder / "blocks.vtm", tmp_path)
    refuse_incomplete(Path(whole))
    (block,) = (tmp_path / "blocks").glob("*.vti")
    block.write_bytes(block.read_bytes()[:-20])
    with pytest.raises(ValueError, match=rf"Its block {block.name}: It is cut short"):
        refuse_incomplete(Path(whole))


HEAD = b"# vtk DataFile Version 3.0\nby hand\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n"
TRIANGLE = HEAD + b"0 0 0 1 0 0\n0 1 0\nPOLYGONS 1 4\n3 0 1 2"


@pytest.mark.parametrize(
    ("contents", "message"),
    [
        (TRIANGLE, None),  # files written by hand may lack the last line break
        (TRIANGLE + b"\nPOINT_DATA 3\nSCALARS a float\nLOOKUP_TABLE default\n1 2 3\n", None),
        (TRIANGLE.replace(b"3.0", b"x.0"), "does not begin"),
        (TRIANGLE.replace(b"by hand", b"vtk output"), "last line has no line break"),
    ],
)
def test_legacy_files_by_hand(tmp_path, contents, message):
    path = tmp_path / "hand.vtk"
    path.write_bytes(contents)
    if message is None:
        refuse_incomplete(path)
        assert pv.read(path).n_cells == 1
    else:
        with pytest.raises(ValueError, match=message):
            refuse_incomplete(path)


PLY = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
PLY += "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2"


def test_a_ply_file_by_hand_and_one_of_mixed_faces(tmp_path):
    path = Path(tmp_path, "hand.ply")
    path.write_text(PLY)
    refuse_incomplete(path)
    path.write_text(PLY.replace("\n3 0 1 2", ""))
    with pytest.raises(ValueError, match="declares 4 lines"):
        refuse_incomplete(path)
    faces = [3, 0, 1, 2, 4, 0, 1, 3, 2, 3, 1, 2, 3]
    pv.PolyData(np.random.default_rng(1).random((4, 3)), faces).save(path)
    refuse_incomplete(path)
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(ValueError, match="cut short"):
        refuse_incomplete(path)


def written(mesh, path, *, mode, compressor, header):
    kind = {".vtp": "PolyData", ".vtu": "UnstructuredGrid", ".vti": "ImageData"}[path.suffix]
    writer = getattr(vtkIOXML, f"vtkXML{kind}Writer")()
    writer.SetInputData(mesh)
    writer.SetFileName(str(path))
    getattr(writer, f"SetDataModeTo{mode}")()
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    getattr(writer, f"SetHeaderTypeTo{header}")()
    writer.EncodeAppendedDataOff()
    assert writer.Write()


@pytest.mark.parametrize("header", ["UInt32", "UInt64"])
@pytest.mark.parametrize("compressor", ["None", "ZLib", "LZ4"])
@pytest.mark.parametrize("mode", ["Binary", "Appended", "Ascii"])
def test_xml_files_of_every_layout_pass(tmp_path, mode, compressor, header):
    empty = pv.Sphere()
    empty["none"] = np.zeros((empty.n_points, 3), bool)
    grid = pv.ImageData(dimensions=(20, 20, 20))
    grid["v"] = np.arange(8000.0)
    for mesh, suffix in (
        (empty, ".vtp"),
        (grid, ".vti"),
        (grid.cast_to_unstructured_grid(), ".vtu"),
        (pv.PolyData(), ".vtp"),
    ):
        path = tmp_path / f"layout{suffix}"
        written(mesh, path, mode=mode, compressor=compressor, header=header)
        refuse_incomplete(path)


@pytest.mark.parametrize("compressor", ["None", "ZLib"])
def test_an_array_with_fewer_bytes_than_it_says_is_refused(tmp_path, compressor):
    """VTK's reader would leave the rest of the memory uninitialized."""
    path = tmp_path / "short.vtp"
    written(pv.Sphere(), path, mode="Appended", compressor=compressor, header="UInt32")
    whole = path.read_bytes()
    refuse_incomplete(path)
    middle = whole.index(b"<AppendedData") + 3000
    for removed in (2, 400):
        path.write_bytes(whole[:middle] + whole[middle + removed :])
        with pytest.raises(ValueError, match="fewer bytes than it declares"):
            refuse_incomplete(path)


@pytest.mark.parametrize("change", [str, str.upper], ids=["small", "capitals"])
def test_a_text_stl_is_whole_in_small_letters_and_capitals(tmp_path, change):
    path = tmp_path / "a.stl"
    pv.Tetrahedron().save(path, binary=False)
    text = change(path.read_text())
    path.write_text(text)
    refuse_incomplete(path)
    path.write_text(text[: len(text) // 2])
    with pytest.raises(ValueError, match="endsolid"):
        refuse_incomplete(path)
