"""Equal rows, edges and connected parts, against dictionaries and sets."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from pvphong.geometry.normals import Faces
from pvphong.studies.diagnose import checks
from pvphong.studies.diagnose.checks import Edges, edges_of, first_alike, owners_of
from pvphong.studies.diagnose.shells import connected


def by_a_dictionary(rows):
    """Return the index of the first equal tuple; a tuple with a NaN equals no other."""
    first, seen = [], {}
    for index, row in enumerate(map(tuple, rows.tolist())):
        first.append(index if any(x != x for x in row) else seen.setdefault(row, index))
    return first


@pytest.mark.parametrize("clash", [False, True], ids=["hashed", "all with one hash"])
@pytest.mark.parametrize("kind", [np.float32, np.float64, np.int32, np.int64])
def test_rows_are_alike_that_a_dictionary_takes_for_one(kind, clash, monkeypatch):
    if clash:
        monkeypatch.setattr(checks, "_hashes", lambda rows: np.zeros(len(rows), np.uint64))
    rng = np.random.default_rng(4)
    for width, values in ((3, 3), (3, 50), (4, 2), (1, 5)):
        rows = rng.integers(-values, values, (300, width)).astype(kind)
        if rows.dtype.kind == "f":
            rows[rng.integers(0, 300, 20)] *= -0.0
            rows[rng.integers(0, 300, 20), 0] = np.nan
        assert first_alike(rows).tolist() == by_a_dictionary(rows)
    assert first_alike(np.zeros((0, 3), kind)).tolist() == []


@pytest.mark.parametrize("sizes", [(3,), (4,), (1, 2, 3, 5)])
def test_edges_are_counted_each_way(sizes):
    rng = np.random.default_rng(len(sizes))
    polygons = [rng.integers(0, 12, rng.choice(sizes)).tolist() for _ in range(40)]
    faces = Faces(np.zeros((12, 3)), np.concatenate(polygons), np.cumsum([0, *map(len, polygons)]))
    counted = Counter((a, b) for face in polygons for a, b in zip(face, face[1:] + face[:1], strict=True) if a != b)
    begin, end = edges_of(faces)
    assert owners_of(faces).tolist() == [number for number, face in enumerate(polygons) for _ in face]
    edges = Edges.between(begin, end, 12)
    got = {(a, b): (forth, back) for a, b, forth, back in zip(*(each.tolist() for each in edges), strict=True)}
    assert got == {(a, b): (counted[a, b], counted[b, a]) for a, b in {tuple(sorted(edge)) for edge in counted}}


@pytest.mark.parametrize("count", [0, 1, 40, 60, 100])
def test_parts_have_the_number_of_their_lowest_point(count):
    rng = np.random.default_rng(count)
    begin, end = rng.integers(0, 100, (2, count))
    parts = [{k} for k in range(100)]
    for a, b in zip(begin.tolist(), end.tolist(), strict=True):
        joined = parts[a] | parts[b]
        for k in joined:
            parts[k] = joined
    assert connected(100, begin, end).tolist() == [min(part) for part in parts]


def test_a_long_chain_is_one_part_however_it_is_numbered():
    order = np.random.default_rng(0).permutation(5000)
    assert not connected(5000, order[:-1], order[1:]).any()
