"""Pieces of a surface shadow each other as it does in one piece, to the bit; each reads what may block it."""

import threading
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from batch.cutting import as_in_one_piece, bare, houses, save_pieces, surfaces

import pvphong as ph
from pvphong.batch import worker

LIGHTS = {
    "point": ph.PointLight(position=(3, 2, 4)),
    "sun": ph.DirectionalLight(direction=(-3, -1, -1)),
    "sphere": ph.SphereLight(position=(3, 2, 4), radius=0.7),
}
VIEWER = ph.Viewer(position=(3, 4, 9))


def scene_of(*lights, **model):
    return ph.Scene(lights, VIEWER, ph.LightModel(shadows=True, **model))


@pytest.mark.parametrize("light", LIGHTS)
def test_shadows_across_pieces_are_those_of_one_piece_to_the_bit(light, client):
    pieces, scene = surfaces(houses()), scene_of(LIGHTS[light])
    index = save_pieces(pieces, "in", ".pvtp")
    batch = ph.shade_files(index, "lit", scene, client=client, components=True)
    assert (len(batch.done), batch.failed) == (len(pieces) + 1, {})
    whole = as_in_one_piece(pieces, scene)
    assert 0.2 < whole["phong_visibility_0"].mean() < 0.8
    alone = np.concatenate([piece.phong.shade(scene)["phong"] for piece in pieces])
    assert not np.array_equal(whole["phong"], alone), "no piece shadows another"
    assert ph.shade_files(index, "lit", scene, client=client, components=True).done == ()


def test_occlusion_up_to_a_distance_and_seams_that_are_kept(client):
    pieces, scene = surfaces(houses(4)), scene_of(ambient_occlusion=0.5)
    batch = ph.shade_files(
        save_pieces(pieces, "in", ".vtm"), "lit", scene, client=client, seams="keep", components=True
    )
    assert not batch.failed
    as_in_one_piece(pieces, scene)


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
    row = bare(pv.Plane(i_size=6, i_resolution=12, j_resolution=2).triangulate())  # six pieces along x, 1 long
    row.points[::3, 2] = 0.45
    place = np.floor(row.cell_centers().points[:, 0])
    pieces = [row.extract_cells(place == each).extract_surface(algorithm=None) for each in np.unique(place)]
    index = save_pieces(pieces, "in", ".pvtp")

    def read_by(scene):
        reads.clear()
        assert not ph.shade_files(index, "lit", scene, client=client).failed
        return [sorted(int(Path(path).stem[-1]) for on, path in reads if on == f"part_{k}.vtp") for k in range(6)]

    west = ph.DirectionalLight(direction=(2.5, 0, -1))  # a wall of 0.45 is seen from 1.1 away
    assert read_by(scene_of(west)) == [[0], [0, 1], [0, 1, 2], [1, 2, 3], [2, 3, 4], [3, 4, 5]]
    lamp = ph.PointLight(position=(-3.5, 0, 0.5))
    assert read_by(scene_of(lamp)) == [list(range(k + 1)) for k in range(6)]
    above = ph.PointLight(position=(0.5, 0, 50))  # only those beside a piece, which touch it
    assert read_by(scene_of(above)) == [[0, 1], [0, 1, 2], [1, 2, 3], [2, 3, 4], [3, 4, 5], [4, 5]]
    assert read_by(scene_of(ambient_occlusion=True)) == [list(range(6))] * 6
    assert read_by(scene_of(ambient_occlusion=1.5)) == [list(range(max(k - 2, 0), min(k + 3, 6))) for k in range(6)]
    assert read_by(ph.Scene([west], VIEWER)) == [[k] for k in range(6)]


def test_what_may_block_is_there_again_when_it_can_be_read(client):
    pieces, scene = surfaces(houses(4)), scene_of(LIGHTS["sun"])
    index = save_pieces(pieces, "in", ".pvtp")
    broken = Path("in/whole/part_4.vtp")
    good = broken.read_bytes()
    broken.write_text("garbage")
    assert set(ph.shade_files(index, "lit", scene, client=client, components=True).failed) == {broken, index}
    broken.write_bytes(good)
    assert len(ph.shade_files(index, "lit", scene, client=client, components=True).done) == len(pieces) + 1
    as_in_one_piece(pieces, scene)
