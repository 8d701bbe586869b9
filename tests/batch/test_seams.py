"""Pieces of one surface have the normals, the edges and the colours of the surface in one piece."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from batch.cutting import SCENE, bare, cut, read_whole, save_pieces, series, surfaces

import pvphong as ph
from pvphong.batch.culling import touching
from pvphong.batch.seams import border_of, neighbours_of, with_normals, without_ghosts
from pvphong.meshes.surfaces import polygons, split_sharp_edges

MESHES = {
    "ball": pv.Sphere(theta_resolution=40, phi_resolution=30),
    "cube": pv.Cube().clean().triangulate().subdivide(3),
    "quads": pv.Cylinder(resolution=24).clean(),
    "airplane": pv.examples.load_airplane(),
}
BRIGHT = ph.Material(specular=0.4, shininess=20)


def all_neighbours(pieces):
    """Return, for each piece, the neighbouring faces along its border."""
    borders = [border_of(piece) for piece in pieces]
    near = touching([border.outline for border in borders])
    return [neighbours_of(border, [borders[k] for k in others]) for border, others in zip(borders, near, strict=True)]


def at_corners(mesh, name):
    """Return the coordinates and values at each face's corners, by face number."""
    connectivity, offsets = polygons(mesh)
    faces = np.split(connectivity, offsets[1:-1])
    order = np.concatenate([faces[cell] for cell in np.argsort(mesh.cell_data["face"], kind="stable")])
    return np.asarray(mesh.cell_data["face"]), np.asarray(mesh.points)[order], np.asarray(mesh.point_data[name])[order]


def same_at_corners(pieces, whole, name, off=1e-6):
    """Assert that the pieces have exactly the faces of the whole, with equal values at their corners."""
    joined = pv.merge(pieces, merge_points=False).extract_surface(algorithm=None)
    found, expected = at_corners(joined, name), at_corners(whole, name)
    np.testing.assert_array_equal(np.sort(found[0]), np.sort(expected[0]))
    np.testing.assert_array_equal(found[1], expected[1])
    np.testing.assert_allclose(found[2], expected[2], atol=off)


@pytest.mark.parametrize("angle", [None, 30.0, 0.0], ids=str)
@pytest.mark.parametrize("mesh", MESHES)
def test_normals_and_sharp_edges_are_those_of_one_piece(mesh, angle):
    whole, _ = split_sharp_edges(bare(MESHES[mesh]), angle)
    whole.point_data["n"] = ph.pipeline.vertex_normals(whole)
    pieces = surfaces(bare(MESHES[mesh]))
    found = []
    for piece, around in zip(pieces, all_neighbours(pieces), strict=True):
        own = with_normals(piece, around, angle)
        assert own.n_points == piece.n_points or angle is not None
        own.point_data["n"] = own.point_data.active_normals
        found.append(own)
    same_at_corners(found, whole, "n")
    for piece in pieces:
        piece.point_data["n"] = ph.pipeline.vertex_normals(piece)
    if mesh == "ball" and angle is None:
        with pytest.raises(AssertionError):  # without neighbours normals along borders differ
            same_at_corners(pieces, whole, "n", 1e-2)
        apart = [piece.translate((2e-7 * k, 0, 0)) for k, piece in enumerate(pieces)]  # no points coincide
        assert not any(len(around.points) for around in all_neighbours(apart))


def test_arrays_lines_and_lonely_points_stay_with_their_piece():
    left, right = surfaces(bare(pv.Plane(i_resolution=4, j_resolution=4).triangulate()), 2)[:2]
    left = left.copy()
    left.clear_data()
    left.points = np.vstack([left.points, [(9, 9, 9)]])
    left.point_data["mark"] = np.arange(left.n_points)
    left.lines = [2, 0, 3]
    left.cell_data["kind"] = np.arange(left.n_cells)
    left.field_data["time"] = [2.5]
    around = neighbours_of(border_of(left), [border_of(right)])
    assert len(around.offsets) > 1
    own = with_normals(left, around, None)
    assert (own.n_lines, own.n_cells, own.field_data["time"].tolist()) == (1, left.n_cells, [2.5])
    for data in ("point_data", "cell_data"):
        for name, array in getattr(left, data).items():
            np.testing.assert_array_equal(getattr(own, data)[name], array)
    assert own.cell_data.keys() == left.cell_data.keys()
    assert own.point_data.active_normals.shape == left.points.shape


def test_ghost_cells_are_left_out():
    whole = bare(pv.Sphere(theta_resolution=10, phi_resolution=10))
    flags = np.zeros(whole.n_cells, np.uint8)
    flags[:30] = 1
    whole.cell_data["vtkGhostType"] = flags
    left = without_ghosts(whole)
    assert (left.n_cells, left.cell_data["face"].min()) == (whole.n_cells - 30, 30)
    assert left.n_points < whole.n_points
    assert without_ghosts(left) is left


@pytest.mark.parametrize("suffix", [".pvtp", ".vtm", ".pvd", ".pvtu"])
def test_an_index_is_read_as_pieces_and_written_back(suffix, client):
    mesh = bare(MESHES["ball"])
    whole = mesh.phong.shade(SCENE, BRIGHT)
    pieces = cut(mesh) if suffix == ".pvtu" else surfaces(mesh)
    pieces[0].point_data["mark"] = np.zeros(pieces[0].n_points)  # the other pieces have no such array
    index = save_pieces(pieces, "in", suffix)
    batch = ph.shade_files(index, "lit", SCENE, BRIGHT, client=client)
    assert (len(batch.done), batch.skipped, batch.failed) == (len(pieces) + 1, (), {})
    written = Path("lit", f"whole{'.pvtp' if suffix == '.pvtu' else suffix}")
    read = read_whole(written)
    leaves = list(read.recursive_iterator()) if isinstance(read, pv.MultiBlock) else [read]
    lit = [leaf for leaf in leaves if leaf is not None]
    assert len(lit) > 1 or "mark" not in lit[0].point_data
    assert sum(leaf.n_cells for leaf in lit) == mesh.n_cells
    assert all(leaf.point_data.active_normals is None for leaf in lit)
    same_at_corners(lit, whole, "phong")
    assert ph.shade_files(index, "lit", SCENE, BRIGHT, client=client).done == ()
    if suffix == ".vtm":
        assert read.keys() == ["deep", *(f"part {k}" for k in range(1, len(pieces)))]
    kept = ph.shade_files(index, "kept", SCENE, BRIGHT, client=client, seams="keep")
    assert not kept.failed
    with pytest.raises(AssertionError):
        same_at_corners([pv.read(path) for path in Path("kept").rglob("*.vtp")], whole, "phong", 1e-3)


def ghosts(mesh):
    """Return a mesh that has only ghost cells."""
    mesh = mesh.copy()
    mesh.cell_data["vtkGhostType"] = np.ones(mesh.n_cells, np.uint8)
    mesh.point_data["tint"], mesh.cell_data["color"] = np.ones((mesh.n_points, 3)), np.ones((mesh.n_cells, 3))
    if isinstance(mesh, pv.PolyData):
        mesh.point_data.active_normals = mesh.phong.normals()
    return mesh


@pytest.mark.parametrize("scene", [None, SCENE, replace(SCENE, light_model=ph.LightModel(shadows=True))])
@pytest.mark.parametrize("suffix", [".pvtp", ".vtm", ".pvtu"])
def test_pieces_without_cells_of_their_own_come_out_empty_and_leave_the_others_as_they_are(suffix, scene, client):
    mesh = bare(MESHES["ball"])
    pieces = cut(mesh, 2) if suffix == ".pvtu" else surfaces(mesh, 2)
    assert not ph.shade_files(save_pieces(pieces, "some", suffix), "alone", scene, BRIGHT, client=client).failed
    pieces = [type(pieces[0])(), *pieces, ghosts(pieces[0])]
    index = save_pieces(pieces, "in", suffix)
    batch = ph.shade_files(index, "lit", scene, BRIGHT, client=client)
    assert (len(batch.done), batch.failed) == (len(pieces) + 1, {})
    for number in range(len(pieces)):
        lit = pv.read(f"lit/whole/part_{number}.vtp")
        if number in (0, len(pieces) - 1):
            assert (lit.n_points, lit.n_cells) == (0, 0)
        else:
            assert lit == pv.read(f"alone/whole/part_{number - 1}.vtp")
    if suffix != ".vtm":
        assert read_whole("lit/whole.pvtp") == read_whole("alone/whole.pvtp")
    assert ph.shade_files(index, "lit", scene, BRIGHT, client=client).done == ()


@pytest.mark.filterwarnings("ignore::pvphong.NormalsWarning")  # constant normals do not fit a ball
def test_pieces_with_normals_are_lit_with_them(client):
    pieces = surfaces(bare(MESHES["ball"]), 2)
    for piece in pieces:
        piece.point_data.active_normals = np.tile((0.0, 0.0, 1.0), (piece.n_points, 1))
    ph.shade_files(save_pieces(pieces, "in", ".pvtp"), "lit", SCENE, BRIGHT, client=client)
    for number, piece in enumerate(pieces):
        lit, expected = pv.read(f"lit/whole/part_{number}.vtp"), piece.phong.shade(SCENE, BRIGHT)
        np.testing.assert_array_equal(lit["phong"], expected["phong"])


def test_the_cells_of_a_volume_have_the_normals_of_its_outside(client):
    grid = pv.ImageData(dimensions=(7, 6, 5)).cast_to_unstructured_grid()
    whole = grid.extract_surface(algorithm=None).phong.shade(SCENE, BRIGHT)
    index = save_pieces(cut(grid, 2), "in", ".pvtu")
    assert not ph.shade_files(index, "lit", SCENE, BRIGHT, client=client).failed
    lit = read_whole("lit/whole.pvtp")
    at = {tuple(point): color for point, color in zip(whole.points.tolist(), whole["phong"], strict=True)}
    is_outside = [tuple(point) in at for point in lit.points.tolist()]
    expected = [at[tuple(point)] for point in lit.points[is_outside].tolist()]
    np.testing.assert_allclose(lit["phong"][is_outside], expected, atol=1e-6)
    assert sum(is_outside) > whole.n_points


def test_times_of_a_series_are_not_one_surface_and_files_beside_each_other_only_if_asked(client):
    pieces = surfaces(bare(MESHES["ball"]), 2)
    index = save_pieces(pieces, "in", ".pvd")
    names = [f"whole/part_{number}.vtp" for number in range(len(pieces))]
    index.write_text(series(names, range(len(names))))
    ph.shade_files(index, "steps", SCENE, BRIGHT, client=client)
    alone = ph.shade_files("in/whole/*.vtp", "alone", SCENE, BRIGHT, client=client)
    assert 'seams="merge"' in str(alone).replace("\n", " ")
    merged = ph.shade_files("in/whole/*.vtp", "merged", SCENE, BRIGHT, client=client, seams="merge")
    assert not merged.note
    whole = bare(MESHES["ball"]).phong.shade(SCENE, BRIGHT)
    same_at_corners([pv.read(f"merged/part_{k}.vtp") for k in range(len(names))], whole, "phong")
    for number, piece in enumerate(pieces):
        expected = piece.phong.shade(SCENE, BRIGHT)["phong"]
        for folder in ("steps/whole", "alone"):
            np.testing.assert_array_equal(pv.read(f"{folder}/part_{number}.vtp")["phong"], expected)
