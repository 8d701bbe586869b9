"""What several commands do with a mesh, of one block or several, and the materials of its blocks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import pyvista as pv

from pvphong.cli.inputs import single_meshes
from pvphong.meshes.blocks import map_blocks, materials_of, single_material
from pvphong.meshes.lit import shade_mesh
from pvphong.meshes.visibility import visibility_options
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene


def with_materials(mesh: Any, materials: Mapping[str, Material]) -> Iterator[tuple[str, pv.DataSet, Material]]:
    """As `single_meshes`, each with its material."""
    for (name, single), material in zip(single_meshes(mesh), _each(mesh, materials), strict=True):
        yield name, single, material


def shaded(mesh: Any, scene: Scene, materials: Mapping[str, Material], **how: Any) -> Any:
    """The mesh with its lit colours; `how` as for `shade_mesh`."""
    each = _each(mesh, materials)
    if isinstance(mesh, pv.MultiBlock):
        rays = visibility_options(mesh, scene, how)
        return map_blocks(mesh, lambda block: shade_mesh(block, scene, next(each), **next(rays)))
    return shade_mesh(mesh, scene, next(each), **how)


def _each(mesh: Any, materials: Mapping[str, Material]) -> Iterator[Material]:
    return materials_of(mesh, materials) if isinstance(mesh, pv.MultiBlock) else iter([single_material(materials)])
