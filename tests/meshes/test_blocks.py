"""Blocks: datasets in them, and their materials, as stored in rigs."""

import numpy as np
import pytest
import pyvista as pv

from pvphong.meshes.blocks import common_or_named, datasets, leaves, materials_of, nested


@pytest.mark.parametrize(
    ("materials", "kept"),
    [
        ({"a": "gold", "b": "gold"}, {"default": "gold"}),
        ({"a": "gold", "b": "jade"}, {"a": "gold", "b": "jade"}),
        ({}, {}),
    ],
)
def test_materials_that_are_alike_are_kept_as_one_and_give_all_blocks_theirs(materials, kept):
    assert common_or_named(materials) == kept
    assert materials_of(list(materials), kept) == list(materials.values())


def test_tables_and_what_is_empty_are_no_meshes_of_blocks():
    ball, table = pv.Sphere(), pv.Table({"x": np.zeros(3)})
    inner = pv.MultiBlock({"table": table, "ball": ball})
    blocks = pv.MultiBlock({"inner": inner, "table": table, "empty": pv.PolyData(), "none": None})
    assert leaves(blocks) == [ball]


def test_blocks_are_made_of_their_paths_again():
    blocks = pv.MultiBlock({"ball": pv.Sphere(), "car": pv.MultiBlock({"wheel": pv.Cube(), "door": pv.Plane()})})
    again = nested(dict(datasets(blocks)))
    assert [path for path, _ in datasets(again)] == ["ball", "car/wheel", "car/door"]
    assert again["car"]["door"] is blocks["car"]["door"]
    both = nested({"car": pv.Cube(), "car/wheel": pv.Sphere()})  # a dataset and a block of one name
    assert [path for path, _ in datasets(both)] == ["car", "car/wheel"]
