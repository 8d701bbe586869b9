"""Files that are cut short or contradict themselves are refused before VTK sees them; whole ones are not."""

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
    """But for blanks at the end; each format at hundreds of places."""
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
    block.write_bytes(block.read_bytes().replace(b'<Piece Extent="0 3', b'<Piece Extent="1 3'))
    with pytest.raises(ValueError, match=rf"Its block {block.name}: Its pieces do not fill its WholeExtent\."):
        refuse_incomplete(Path(whole))


def test_a_legacy_file_is_whole_at_the_end_of_a_section_alone(folder, tmp_path):
    """Where it is cut otherwise, VTK's reader takes it with whatever is in memory."""
    for path in sorted(folder.glob("*.vtk")):
        contents, cut = path.read_bytes(), tmp_path / path.name
        for end in range(contents.index(b"DATASET"), len(contents), 7):
            cut.write_bytes(contents[:end])
            assert refused(cut) or contents[end - 1 : end] == b"\n", (path.name, end, contents[end - 20 : end])


def everything():
    """A mesh with an array of every sort that a legacy file can hold."""
    mesh = pv.Sphere(theta_resolution=5, phi_resolution=5)
    count = mesh.n_points
    for dtype in ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8", "bool"):
        mesh[dtype] = np.zeros(count, dtype)
    mesh["tensor"] = np.zeros((count, 9))
    mesh["texture"] = np.zeros((count, 2), np.float32)
    mesh.active_texture_coordinates = mesh["texture"]
    mesh.cell_data["colors"] = np.ones((mesh.n_cells, 4), np.uint8)
    mesh.add_field_data(["some words", "", "x" * 20_000], "names")
    return mesh


@pytest.mark.parametrize("binary", [True, False])
def test_every_sort_of_array_of_a_legacy_file_is_passed_over(tmp_path, binary):
    path = tmp_path / "all.vtk"
    everything().save(path, binary=binary)
    refuse_incomplete(path)
    path.write_bytes(path.read_bytes()[:-3] + b"\n")
    with pytest.raises(ValueError, match=r"^It is cut short or damaged in its section"):
        refuse_incomplete(path)


HEAD = b"# vtk DataFile Version 3.0\nby hand\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n"
TRIANGLE = HEAD + b"0 0 0 1 0 0\n0 1 0\nPOLYGONS 1 4\n3 0 1 2"


@pytest.mark.parametrize(
    ("contents", "message"),
    [
        (TRIANGLE, None),  # hands leave out the last end of a line
        (TRIANGLE + b"\nPOINT_DATA 3\nSCALARS a float\nLOOKUP_TABLE default\n1 2 3\n", None),
        (TRIANGLE + b"\nPOINT_DATA 3\nSCALARS a float\nLOOKUP_TABLE default\n1 2\n", "SCALARS"),
        (TRIANGLE + b"\nPOINT_DATA 3\nVECTORS a float\n1 2 3 4 5 6 7 8 x\n", "VECTORS"),
        (TRIANGLE.replace(b"POINTS 3", b"POINTS 99999999999"), "POINTS"),
        (TRIANGLE.replace(b"POINTS 3", b"POINTS -3"), "POINTS"),
        (TRIANGLE.replace(b"3.0", b"x.0"), "does not begin"),
        (TRIANGLE.replace(b"by hand", b"vtk output"), "last line has no end"),
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


OBJ = "# by hand, 1/2\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 0.5\n vn 0 0 1\ng one/9\n"


@pytest.mark.parametrize(
    ("faces", "message"),
    [
        ("f 1//1 2//1 3//1\n f -3//-1 -2//-1 -1//-1", None),
        ("f 1/1/1 2/1/1 3/1/1\nf 1//1 2//1 3//1", None),  # without coordinates VTK gives (−1, −1)
        ("f 1 2 3", None),
        ("vt 0 0\nvt 1 0\nvt 0 1\nf 1/4/1 -2/-1/1 3/1/-1", None),
        ("f 1 2 9", None),  # a face of no use, which `diagnose` finds
        ("f 1//1 2//1 9//1", "it has 3 points, and a face"),
        ("f 1//1 2//1 3//9", "it has 1 normals, and a face"),
        ("f 1/1/1 2/1/1 3/2/1", "it has 1 texture coordinates, and a face"),
        ("f 1//1 2//1 3//1\nf 1 2 3", "Not all of its faces name their normals"),
        ("f 1/1 2/1 3/1", "Not all of its faces name their normals"),
    ],
)
def test_obj_files_of_which_vtk_takes_normals_from_memory(tmp_path, faces, message):
    path = tmp_path / "hand.obj"
    path.write_text(OBJ + faces)
    if message is None:
        refuse_incomplete(path)
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


@pytest.mark.parametrize("extent", ["0 3 0 2 0 1", "8 3 0 2 0 2", "0 99999999 0 2 0 2", "0 3 0 2 0", "a b c d e f"])
@pytest.mark.parametrize("name", ["image.vti", "axes.vtr"])
def test_a_grid_whose_pieces_do_not_fill_it_is_refused(folder, tmp_path, name, extent):
    contents = (folder / name).read_text(encoding="latin-1")
    assert 'Piece Extent="0 3 0 2 0 2"' in contents
    path = tmp_path / name
    for which in ("Piece Extent", "WholeExtent"):
        path.write_text(contents.replace(f'{which}="0 3 0 2 0 2"', f'{which}="{extent}"'), encoding="latin-1")
        with pytest.raises(ValueError, match="WholeExtent"):
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
    """VTK's reader would leave the rest as it was in memory."""
    path = tmp_path / "short.vtp"
    written(pv.Sphere(), path, mode="Binary", compressor=compressor, header="UInt32")
    whole = path.read_bytes()
    refuse_incomplete(path)
    start = whole.index(b'"Points"')
    middle = start + 3000
    for left in (whole[middle + 2 :], whole[middle + 4 :], b"=" + whole[middle + 1 :]):
        path.write_bytes(whole[:middle] + left)
        with pytest.raises(ValueError, match="fewer bytes than it says"):
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
