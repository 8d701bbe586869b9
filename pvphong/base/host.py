"""The one door from the core (floors 0 to 4) to PyVista.

The core computes without PyVista or VTK. Two conveniences of its value classes need them all the same:
PyVista's colour names, and handing a light back as a `pyvista.Light`. Both import inside the function,
so that importing the core imports neither.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pyvista as pv

    from pvphong.base.types import Vector


def color_by_name(name: str) -> Vector:
    """Red, green, blue in [0, 1] of a PyVista colour name or hex string.

    Raises
    ------
    ValueError
        If PyVista knows no such colour, or it is not opaque.
    """
    import pyvista as pv

    red, green, blue, opacity = pv.Color(name).float_rgba
    if opacity != 1.0:
        raise ValueError(f"{name} has an opacity")
    return float(red), float(green), float(blue)


def blank_light() -> pv.Light:
    """A `pyvista.Light` in its default state."""
    import pyvista as pv

    return pv.Light()
