"""Shadows between pieces are bit for bit those of the surface in one piece; culling keeps every occluder."""

import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from batch.cutting import as_in_one_piece, bare, houses, save_pieces, surfaces
from ray_backends import BACKENDS

import pvphong as ph
from pvphong.batch import worker
from pvphong.batch.culling import outline_of, potential_occluders, touching
from pvphong.meshes.visibility import world_faces
from pvphong.rays import casting

LIGHTS = {
    "point": ph.PointLight(position=(3, 2, 4)),
    "sun": ph.DirectionalLight(direction=(-3, -1, -1)),
    "sphere": ph.SphereLight(position=(3, 2, 4), radius=0.7),
}
VIEWER = ph.Viewer(position=(3, 4, 9))


def scene_of(*lights, **model):
    return ph.Scene(lights, VIEWER, ph.LightModel(shadows=True, **model))


@pytest.mark.parametrize(("light", "two_sided"), [*((name, False) for name in LIGHTS), ("sphere", True)])
@pytest.mark.parametrize("backend", BACKENDS)
def test_shadows_across_pieces_are_those_of_one_piece_to_the_bit(light, two_sided, backend, client, monkeypatch):
    monkeypatch.setattr(casting, "ray_backend", lambda: (BACKENDS[backend], ""))
    pieces, scene = surfaces(houses()), scene_of(LIGHTS[light], two_sided=two_sided)
    index = save_pieces(pieces, "in", ".pvtp")
    batch = ph.shade_files(index, "lit", scene, client=client, components=True, backend="numpy")
    assert (len(batch.done), batch.failed) == (len(pieces) + 1, {})
    whole = as_in_one_piece(pieces, scene)
    assert 0.2 < whole["phong_visibility_0"].mean() < 0.8
    alone = np.concatenate([piece.phong.shade(scene)["phong"] for piece in pieces])
    assert not np.array_equal(whole["phong"], alone), "no piece shadows another"
    assert ph.shade_files(index, "lit", scene, client=client, components=True, backend="numpy").done == ()


def test_occlusion_up_to_a_distance_and_seams_that_are_kept(client):
    pieces, scene = surfaces(houses(4)), scene_of(ambient_occlusion=0.5)
    batch = ph.shade_files(
        save_pieces(pieces, "in", ".vtm"), "lit", scene, client=client, seams="keep", components=True, backend="numpy"
    )
    assert not batch.failed
    as_in_one_piece(pieces, scene)


WEST = ph.DirectionalLight(direction=(2.5, 0, -1))
IN_A_ROW = {
    "a wall of 0.45 throws a shadow of 1.1": (scene_of(WEST), (2, 1)),
    "neighbours touch": (scene_of(ph.PointLight(position=(0.5, 0, 50))), (1, 1)),
    "all in between": (scene_of(ph.PointLight(position=(-3.5, 0, 0.5))), (5, 1)),
    "off": (scene_of(replace(WEST, on=False)), (0, 0)),
    "without shadows": (scene_of(replace(WEST, casts_shadows=False)), (0, 0)),
    "the sky up to 1.5": (scene_of(ambient_occlusion=1.5), (2, 2)),
    "the sky": (scene_of(ambient_occlusion=True), (5, 5)),
}
"""Scenes, and the number of pieces on either side that may block a piece's light."""


def row_of_pieces():
    """Return six pieces of length 1 along x."""
    row = bare(pv.Plane(i_size=6, i_resolution=12, j_resolution=2).triangulate())
    row.points[::3, 2] = 0.45
    place = np.floor(row.cell_centers().points[:, 0])
    return [row.extract_cells(place == each).extract_surface(algorithm=None) for each in np.unique(place)]


@pytest.mark.parametrize("case", IN_A_ROW)
def test_what_may_block_a_piece_is_between_it_and_a_light(case):
    scene, (before, after) = IN_A_ROW[case]
    found = potential_occluders(scene, range(6), [outline_of(piece) for piece in row_of_pieces()])
    blockers = [[other for other in range(6) if other != k and -before <= other - k <= after] for k in range(6)]
    assert [list(each.blockers) for each in found] == blockers


def test_a_piece_reads_itself_and_what_may_block_it(client, monkeypatch):
    at_work, reads, lit, read_mesh = threading.local(), [], worker._lit, worker.read_mesh

    def lit_at(piece, *more):
        at_work.name = piece.input.name
        result = lit(piece, *more)
        at_work.name = ""
        return result

    def noted(path):
        reads.append((getattr(at_work, "name", ""), path))
        return read_mesh(path)

    monkeypatch.setattr(worker, "_lit", lit_at)
    monkeypatch.setattr(worker, "read_mesh", noted)
    index = save_pieces(row_of_pieces(), "in", ".pvtp")
    assert not ph.shade_files(index, "lit", scene_of(WEST), client=client).failed
    read = [sorted(Path(path).stem[-1] for name, path in reads if name == f"part_{k}.vtp") for k in range(6)]
    assert read == [list(each) for each in ("01", "012", "0123", "1234", "2345", "345")]


def test_of_a_piece_that_may_block_those_triangles_are_kept_that_may():
    pieces, scene = surfaces(houses(9), 3), scene_of(ph.DirectionalLight(direction=(0, -1, -4)))
    outlines = [outline_of(piece) for piece in pieces]
    around = list(potential_occluders(scene, range(9), outlines))[4]
    assert 7 in around.blockers  # the piece towards the sun
    faces = world_faces(pieces[7])
    kept = around.blocking(scene, faces)
    assert 0 < len(kept) < len(faces) / 2
    corners = faces.points[faces.corners]
    above = corners[:, :, 2] - 4 * (corners[:, :, 1] - outlines[4].points[1][1])  # above the shadow's border
    near = corners[(above > 1e-9).any(axis=1)]
    there = {corners.tobytes() for corners in kept.points[kept.corners]}
    assert len(near)
    assert all(corners.tobytes() in there for corners in near)


def test_a_piece_with_a_spoiled_point_takes_all_pieces_for_its_neighbours():
    pieces = row_of_pieces()
    pieces[0].points[0] = np.nan
    outlines = [outline_of(piece) for piece in pieces]
    assert next(touching(outlines)) == [1, 2, 3, 4, 5]
    assert next(potential_occluders(scene_of(WEST), range(6), outlines)).blockers == (1, 2, 3, 4, 5)


def test_what_may_block_is_there_again_when_it_can_be_read(client):
    pieces, scene = surfaces(houses(4)), scene_of(LIGHTS["sun"])
    index = save_pieces(pieces, "in", ".pvtp")
    broken = Path("in/whole/part_4.vtp")
    good = broken.read_bytes()
    how = {"client": client, "components": True, "backend": "numpy"}
    broken.write_text("garbage")
    assert set(ph.shade_files(index, "lit", scene, **how).failed) == {broken, index}
    broken.write_bytes(good)
    assert len(ph.shade_files(index, "lit", scene, **how).done) == len(pieces) + 1
    as_in_one_piece(pieces, scene)
