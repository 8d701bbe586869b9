"""Answers the core's questions to PyVista and VTK."""

from __future__ import annotations

import pyvista as pv

from pvphong.base import host
from pvphong.base.types import Vector
from pvphong.vtk.lights import as_light, from_vtk, to_pyvista


def _color_by_name(name: str) -> Vector:
    red, green, blue, opacity = pv.Color(name).float_rgba
    if opacity != 1.0:
        raise ValueError(f"{name} has an opacity")
    return float(red), float(green), float(blue)


def answer_the_core() -> None:
    """Say which functions answer; see `pvphong.base.host`."""
    host.answer(
        color_by_name=_color_by_name,
        color_names=lambda: list(pv.hex_colors),
        light_to_pyvista=to_pyvista,
        light_from_vtk=from_vtk,
        light_placed=as_light,
    )
