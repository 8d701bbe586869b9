"""Functions of PyVista and VTK that the core calls through `pvphong.vtk.lights`; the core itself imports neither.

`pvphong/__init__.py` registers the function that imports `pvphong.vtk.lights`. It also imports `host` at every start,
so nothing heavy is imported here.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as in `pvphong/__init__.py`
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

_load: list[Callable[[], Any]] = []


def answered_by(load: Callable[[], Any]) -> None:
    """Register the function `load`, which imports and returns the module `pvphong.vtk.lights`; `answers` calls it."""
    _load[:] = [load]


def answers() -> Any:
    """Return the module `pvphong.vtk.lights`.

    The core calls these functions of the module:

    - `color_by_name`, `color_names` and `colormap_names`.
    - `mapped_colors`: the colours of an array through a colormap.
    - `mapper_colors`: the colours that a VTK mapper draws.
    - `to_pyvista`: converts a light to a `pyvista.Light`.
    - `from_vtk`: converts a VTK light; a camera light stays a camera light.
    - `as_light`: converts a VTK light, placed in the world for a viewer.
    """
    return _load[0]()
