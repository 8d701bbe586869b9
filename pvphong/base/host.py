"""What the core asks of PyVista and VTK, and `pvphong.vtk.lights` answers: the core itself imports neither.

`pvphong/__init__.py` says who answers. It loads this module each time, so nothing heavy is imported here.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as in `pvphong/__init__.py`
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from pvphong.base.types import Vector

_answers: dict[str, Callable[..., Any]] = {}
_loads: list[Callable[[], object]] = []


def answered_after(load: Callable[[], object]) -> None:
    """Say what to call before the first question, for somebody to `answer` all of them."""
    _loads[:] = [load]


def answer(**functions: Callable[..., Any]) -> None:
    """Say by which functions the questions below are answered."""
    _answers.update(functions)


def color_by_name(name: str) -> Vector:
    """Red, green, blue in [0, 1] of a PyVista colour name or hex string.

    Raises
    ------
    ValueError
        If PyVista knows no such colour, or it is not opaque.
    """
    return _ask("color_by_name", name)


def color_names() -> list[str]:
    """PyVista's colour names, without their other spellings."""
    return _ask("color_names")


def light_to_pyvista(light: Any, viewer: Any) -> Any:
    """A light of pvphong's as a new `pyvista.Light`."""
    return _ask("light_to_pyvista", light, viewer)


def light_from_vtk(light: Any, distance: float) -> Any:
    """Any light as one of pvphong's, for an eye at a distance from its focal point."""
    return _ask("light_from_vtk", light, distance)


def light_placed(light: Any, viewer: Any) -> Any:
    """Any light as one of pvphong's, where a viewer has it in the world."""
    return _ask("light_placed", light, viewer)


def _ask(question: str, *arguments: Any) -> Any:
    if question not in _answers:
        (load,) = _loads
        load()
    return _answers[question](*arguments)
