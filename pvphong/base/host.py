"""What the core asks of PyVista and VTK, and `pvphong.vtk.lights` answers: the core itself imports neither.

`pvphong/__init__.py` says who answers. It loads this module each time, so nothing heavy is imported here.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as in `pvphong/__init__.py`
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from pvphong.base.types import Vector

_load: list[Callable[[], Any]] = []


def answered_by(load: Callable[[], Any]) -> None:
    """Say what gives the module that answers; it is called at the first question."""
    _load[:] = [load]


def color_by_name(name: str) -> Vector:
    """Red, green, blue in [0, 1] of a PyVista colour name or hex string.

    Raises
    ------
    ValueError
        If PyVista knows no such colour, or it is not opaque.
    """
    return _load[0]().color_by_name(name)


def color_names() -> list[str]:
    """PyVista's colour names, without their other spellings."""
    return _load[0]().color_names()


def light_to_pyvista(light: Any, viewer: Any) -> Any:
    """A light of pvphong's as a new `pyvista.Light`."""
    return _load[0]().to_pyvista(light, viewer)


def light_from_vtk(light: Any, distance: float) -> Any:
    """Any light as one of pvphong's, for an eye at a distance from its focal point."""
    return _load[0]().from_vtk(light, distance)


def light_placed(light: Any, viewer: Any) -> Any:
    """Any light as one of pvphong's, where a viewer has it in the world."""
    return _load[0]().as_light(light, viewer)
