"""Functions of PyVista and VTK that the core calls through `pvphong.vtk.lights`; the core itself imports neither.

`pvphong/__init__.py` registers the module. It always imports this one, so nothing heavy is imported here.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as in `pvphong/__init__.py`
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

_load: list[Callable[[], Any]] = []


def answered_by(load: Callable[[], Any]) -> None:
    """Register a function that returns the module; it is called at the first use."""
    _load[:] = [load]


def answers() -> Any:
    """Return the registered module, `pvphong.vtk.lights`.

    The core calls its functions `color_by_name`, `color_names` and `colormap_names`; `mapped_colors` and
    `mapper_colors`, for the colours of an array through a colormap, or of a mapper; `to_pyvista`, which converts a
    light to a `pyvista.Light`; and `from_vtk` and `as_light`, which convert any light to pvphong's: unchanged, or
    placed in the world for a viewer.
    """
    return _load[0]()
