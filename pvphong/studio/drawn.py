"""Actors for colours as they are: VTK's lighting off, nothing that would colour the mesh otherwise."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import pyvista as pv

from pvphong.base import check
from pvphong.meshes.blocks import DEFAULT, datasets, materials_of, single_material
from pvphong.meshes.point_data import is_texture
from pvphong.meshes.surfaces import FeatureAngle
from pvphong.optics.material import Material, check_material
from pvphong.studio.live import Finish, LiveMesh

# What is decided here.
_OURS = ("scalars", "rgb", "rgba", "lighting", "color", "smooth_shading", "texture", "pbr", "cmap", "copy_mesh")


def refuse_colouring(options: dict[str, Any], remedy: str) -> None:
    """Raise ValueError for options of `pyvista.Plotter.add_mesh` that colour a mesh."""
    for option in _OURS:
        if option in options:
            check.refuse("option", option, f"an option of add_mesh other than {', '.join(_OURS)}", remedy)


def live_meshes(
    mesh: Any, material: Material | Mapping[str, Material], albedo: Any, feature_angle: FeatureAngle
) -> dict[str, LiveMesh]:
    """The lit mesh, by no name, or those of all blocks, by their names: they share the material if there is but one.

    Raises
    ------
    ValueError
        If there is nothing that can be lit, or what is given as a material is none; the message names the block.
    """
    given = material if isinstance(material, Mapping) else {DEFAULT: material}
    for each in given.values():
        check_material(each)
    finishes = {name: Finish(each) for name, each in given.items()}
    if not isinstance(mesh, pv.MultiBlock):
        return {"": LiveMesh(mesh, single_material(finishes), albedo, feature_angle=feature_angle)}
    if not (isinstance(albedo, str | None) or is_texture(albedo)):
        allowed = "a texture, the name of a point array that every block has, or None"
        check.refuse("albedo", type(albedo).__name__, allowed)
    found, each_finish = {}, materials_of(mesh, finishes)
    for (path, block), finish in zip(datasets(mesh), each_finish, strict=True):
        try:
            found[path] = LiveMesh(block, finish, albedo, feature_angle=feature_angle)
        except ValueError as error:
            raise ValueError(f"block {path!r}: {error}") from error
    if not found:
        check.refuse("mesh", "blocks without any mesh", "a MultiBlock with a mesh in it")
    return found


def draw(plotter: pv.Plotter, mesh: Any, array: str, options: dict[str, Any]) -> pv.Actor:
    """Draw a mesh in the colours of one of its point arrays."""
    actor = plotter.add_mesh(mesh, scalars=array, rgb=True, lighting=False, **options)
    actor.prop.color = "white"  # VTK's exporters write it too, and glTF multiplies colours by it
    return actor


def names_of(name: str | None, paths: Iterable[str]) -> list[dict[str, str]]:
    """Options that give the actors of some blocks names of their own, from one for all."""
    return [{} if name is None else {"name": f"{name}[{path}]" if path else name} for path in paths]


def make_room(plotter: pv.Plotter, name: str | None) -> None:
    """Remove what was drawn under a name, a mesh or blocks."""
    if name is not None:
        for other in [other for other in plotter.renderer.actors if other == name or other.startswith(f"{name}[")]:
            plotter.remove_actor(other, render=False)
