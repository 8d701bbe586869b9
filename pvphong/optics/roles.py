"""What a light's field means: from its role follow its check, its frame, its handle, its readout and how it is moved.

Handles and readouts by role are in `studio/gizmos/handles.py`. A light declares its fields with these::

    position: VectorLike = place()
    direction: VectorLike = aim()
    cone_angle: float = angle(30.0, "cone", above=0.0, at_most=90.0)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cache
from typing import Any

from pvphong.base import check
from pvphong.base.types import Vector

Check = Callable[[str, Any], Any]
"""From a field's name and what was given for it to its canonical value; ValueError that names the field."""

Map = Callable[[Vector], Vector]


@dataclass(frozen=True)
class Role:
    """What a field means.

    Parameters
    ----------
    check : callable
        Checks a value and puts it into canonical form.
    handle : str
        The name of its handle in a window, "" where it has none.
    """

    check: Check
    handle: str = ""

    def mapped(self, value: Any, point: Map, vector: Map) -> Any:  # noqa: ARG002 a number is the same in all frames
        """The value in another frame, which two functions take points and vectors to."""
        return value

    def of_viewer(self, value: Any, viewer: Any) -> Any:
        """The value in the world for a light that is the viewer's: by default one of eye space."""
        return self.mapped(value, viewer.point_to_world, viewer.vector_to_world)


class Place(Role):
    """Where a light is: three coordinates."""

    def mapped(self, value: Any, point: Map, vector: Map) -> Any:  # noqa: ARG002 it is a point
        """The point."""
        return point(value)

    def of_viewer(self, value: Any, viewer: Any) -> Any:  # noqa: ARG002 as for any role
        """The eye."""
        return viewer.position


class Up(Role):
    """A direction that says how a light is turned around its aim, of any length.

    The light's `axes` are unit vectors as rows: where its front is, to the right of that, and up.
    """

    def mapped(self, value: Any, point: Map, vector: Map) -> Any:  # noqa: ARG002 it is a vector
        """The vector."""
        return vector(value)


class Aim(Role):
    """The direction in which a light travels, of any length."""

    def mapped(self, value: Any, point: Map, vector: Map) -> Any:  # noqa: ARG002 it is a vector
        """The vector."""
        return vector(value)

    def of_viewer(self, value: Any, viewer: Any) -> Any:  # noqa: ARG002 as for any role
        """Along the view axis."""
        return viewer.view_direction


class Corners(Role):
    """Where the corners of a light are: points one after the other around it."""

    def mapped(self, value: Any, point: Map, vector: Map) -> Any:  # noqa: ARG002 they are points
        """The points."""
        return tuple(point(corner) for corner in value)


@dataclass(frozen=True)
class Length(Role):
    """A size, in the mesh's unit.

    Parameters
    ----------
    share : float, default 1
        So much of it lies between the light's middle and the size's handle.
    axis : {0, 1}
        Whether this is to the right of the middle, or above it: of the light, if it has an `Up`, or of the picture.
    """

    share: float = 1.0
    axis: int = 0


@dataclass(frozen=True)
class Angle(Role):
    """An angle, in degrees.

    Parameters
    ----------
    least, most : float
        Between which values it lies; whether they belong to it, `check` knows.
    """

    least: float = 0.0
    most: float = 180.0


class Turn(Role):
    """By how many degrees a light is turned around what is up, counter-clockwise; its front then is `axes[0]`."""


class Falloff(Role):
    """How the light weakens."""


class Power(Falloff):
    """As a power of the cosine off its aim: the exponent."""


def place(default: Any = (0.0, 0.0, 0.0)) -> Any:
    """A field that says where the light is."""
    return _field(default, Place(check.vector, "position"))


def aim(default: Any = (0.0, 0.0, -1.0)) -> Any:
    """A field that says in which direction the light travels."""
    return _field(default, Aim(check.direction, "target"))


def upward(default: Any = (0.0, 1.0, 0.0)) -> Any:
    """A field that says how the light is turned around its aim."""
    return _field(default, Up(check.direction))


def turned(default: float = 0.0) -> Any:
    """A field that says by how many degrees the light is turned around what is up."""
    return _field(default, Turn(_number(), "rotation"))


def imaged(default: Any, checked: Check) -> Any:
    """A field that holds an image of the light."""
    return _field(default, Role(checked))


def cornered(default: Any, checked: Check) -> Any:
    """A field that holds the light's corners, checked as a whole."""
    return _field(default, Corners(checked, "position"))


def switch(default: bool) -> Any:
    """A field that is on or off."""
    return _field(default, Role(check.flag))


def length(default: float, handle: str, remedy: str = "", **shown: Any) -> Any:
    """A field that holds a size > 0, shown as `Length` says."""
    return _field(default, Length(_number(above=0.0, remedy=remedy), handle, **shown))


def angle(default: float, handle: str, **limits: Any) -> Any:
    """A field that holds an angle in degrees, within limits as `check.number` takes them."""
    least = limits.get("above", limits.get("at_least", 0.0))
    return _field(default, Angle(_number(**limits), handle, least, limits.get("at_most", 180.0)))


def falloff(default: Any, checked: Check, handle: str = "") -> Any:
    """A field that says how the light weakens."""
    return _field(default, Falloff(checked, handle))


def power(default: float) -> Any:
    """A field that holds the exponent >= 0 of a falloff."""
    return _field(default, Power(_number(at_least=0.0)))


def direction_from(position: Any, target: Any) -> Vector:
    """From a place to a target; ValueError, which names the target, if they are the same."""
    (x, y, z), (a, b, c) = check.vector("position", position), check.vector("target", target)
    if (x, y, z) == (a, b, c):
        check.refuse("target", target, "another place than position", "The light must shine somewhere.")
    return a - x, b - y, c - z


@cache
def roles_of(kind: Any) -> dict[str, Role]:
    """Name of each field of a dataclass with a role → the role, in the fields' order."""
    return {each.name: each.metadata["role"] for each in fields(kind) if "role" in each.metadata}


def _field(default: Any, role: Role) -> Any:
    return field(default=default, metadata={"role": role})


def _number(**limits: Any) -> Check:
    return lambda name, value: check.number(name, value, **limits)
