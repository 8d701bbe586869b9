"""Materials of blocks: as rigs keep them."""

import pytest

from pvphong.meshes.blocks import common_or_named, materials_of


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
