"""Lit meshes in a picture, as their accessors draw them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pyvista as pv

from pvphong.base import check
from pvphong.meshes.surfaces import drawable


def refuse_unlit(mesh: pv.DataSet, name: str) -> None:
    """Raise ``ValueError`` for a mesh that has no array of lit colours."""
    if name == "phong" and name not in mesh.point_data:
        allowed = "lit, with colours in its point array 'phong' or that of `name`"
        remedy = "mesh.phong.shade(...).phong.plot() lights it first."
        check.refuse("mesh", "one that has no colours yet", allowed, remedy)
    check.choice("name", name, mesh.point_data.keys())


def draw_colors(mesh: pv.DataSet, name: str, options: Mapping[str, Any]) -> Any:
    """Show the colours of a point array as they are, clipped to [0, 1], by PyVista's `plot` with some options."""
    return drawable(mesh, name).plot(rgb=True, lighting=False, scalars=name, **options)
