"""What a command reads: the surface of a mesh file, and the scene it is lit in."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pyvista as pv

from pvphong.base.processes import reading
from pvphong.meshes.blocks import datasets, map_blocks
from pvphong.meshes.default_scene import default_scene, scene_for
from pvphong.meshes.files import read_mesh
from pvphong.meshes.surfaces import surface
from pvphong.scene.scene import Scene

SIZE = (1024, 768)
"""Width and height in pixels of the picture or window that a scene is made for, if none are asked for."""

NOTHING = "nothing to light: no block of the file holds a mesh"
"""Printed where a file of blocks has none to work on."""


def surface_and_scene(path: str, file: Path | None, size: tuple[int, int]) -> tuple[Any, Scene]:
    """What is lit of a mesh file, and the scene: that of a file, or one made for a picture of this size."""
    given = None if file is None else Scene.load(file)
    with reading(path):
        mesh = read_mesh(path)
        outside = map_blocks(mesh, surface) if isinstance(mesh, pv.MultiBlock) else surface(mesh)
    return outside, default_scene(outside, size[0] / size[1]) if given is None else scene_for(outside, given)


def seeing(scene: Scene, mesh: Any, size: tuple[int, int]) -> Scene:
    """The scene for a picture of a mesh: a rig's viewer that sees nothing of it is moved, and that is said."""
    if scene.viewer.sees(mesh.bounds, size[0] / size[1]):
        return scene
    print("note: the scene's viewer sees nothing of this mesh, and was moved to see all of it.", file=sys.stderr)
    return replace(scene, viewer=scene.viewer.moved_to_see(mesh.bounds))


def single_meshes(mesh: Any) -> Iterator[tuple[str, pv.DataSet]]:
    """A mesh alone, or each dataset of a MultiBlock with the path of its names."""
    return datasets(mesh) if isinstance(mesh, pv.MultiBlock) else iter([("", mesh)])
