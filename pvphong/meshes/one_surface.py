"""Blocks as one surface, for studies that measure them together."""

from __future__ import annotations

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.meshes.blocks import leaves, map_blocks
from pvphong.meshes.lit import point_normals
from pvphong.meshes.surfaces import surface


def one_surface(blocks: pv.MultiBlock) -> pv.PolyData:
    """The surfaces of all blocks as one, each with the normals that it is lit with, and no other array.

    No points are merged: where blocks touch there are edges, as between the blocks.

    Raises
    ------
    ValueError
        If no block, or one of them, has nothing that can be lit; the message names it.
    """
    parts = [part for part in leaves(map_blocks(blocks, surface)) if isinstance(part, pv.PolyData)]
    if not parts:
        check.refuse("mesh", f"a MultiBlock of {blocks.n_blocks} without a mesh", "one with a mesh that can be lit")
    bare = []
    for part in parts:
        one = part.copy(deep=False)
        one.clear_data()
        bare.append(one)
    result: pv.PolyData = bare[0].append_polydata(*bare[1:]) if len(bare) > 1 else bare[0]
    result.point_data.active_normals = np.concatenate([point_normals(part) for part in parts])
    return result
