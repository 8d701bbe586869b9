"""What the core asks of PyVista and VTK, and `pvphong.vtk.lights` answers: the core itself imports neither.

`pvphong/__init__.py` says who answers. It loads this module each time, so nothing heavy is imported here.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as in `pvphong/__init__.py`
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

_load: list[Callable[[], Any]] = []


def answered_by(load: Callable[[], Any]) -> None:
    """Say what gives the module that answers; it is called at the first question."""
    _load[:] = [load]


def answers() -> Any:
    """The module that answers: `pvphong.vtk.lights`.

    The core asks it for `color_by_name`, `color_names` and `colormap_names`; for the colours of a colormap's array
    (`mapped_colors`) or of a mapper (`mapper_colors`); for a light as a `pyvista.Light` (`to_pyvista`), and for any
    light as one of pvphong's: as it is (`from_vtk`), or where a viewer has it in the world (`as_light`).
    """
    return _load[0]()
