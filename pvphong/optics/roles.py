"""Roles of a light's fields. A field's role determines its check, its handle and readout in a window, and its
transformation between frames.

The handles and readouts are in `studio/gizmos/handles.py`. A light declares its fields with functions of this module::

    position: VectorLike = place()
    direction: VectorLike = aim()
    cone_angle: float = angle(30.0, "cone", above=0.0, at_most=90.0)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cache, partial
from typing import Any, ClassVar

from pvphong.base import check
from pvphong.base.check import Check
from pvphong.base.types import Vector

Map = Callable[[Vector], Vector]

MESH_UNIT = "mesh unit"


@dataclass(frozen=True)
class Role:
    """Meaning of a light's field.

    Parameters
    ----------
    check : callable
        Function that checks a value and returns its canonical form.
    handle : str
        Name of the field's handle in a window; "" for no handle.
    """

    check: Check
    handle: str = ""

    unit: ClassVar[str] = ""
    """Unit of the field's numbers."""
    labels: ClassVar[tuple[str, ...]] = ()
    """Label of each number, for a field of several numbers."""

    def mapped(self, value: Any, point: Map, vector: Map) -> Any:  # noqa: ARG002 a number is the same in all frames
        """Return the field's value in another frame. A number, such as an angle, is the same in all frames.

        Parameters
        ----------
        value : Any
            Value of the field.
        point : callable
            Function that transforms a position into the other frame.
        vector : callable
            Function that transforms a vector, such as a direction, into the other frame.
        """
        return value

    def of_viewer(self, value: Any, viewer: Any) -> Any:
        """Convert `value`, the value of a headlight's field, to the world frame.

        This default is for values in the eye space of `viewer`. Roles with other values override it.
        """
        return self.mapped(value, viewer.point_to_world, viewer.vector_to_world)


class Place(Role):
    """Role of a field that holds the light's position: three coordinates."""

    unit: ClassVar[str] = MESH_UNIT
    labels: ClassVar[tuple[str, ...]] = ("x", "y", "z")

    def mapped(self, value: Any, point: Map, vector: Map) -> Any:  # noqa: ARG002 it is a point
        """Return the position `value` in another frame, by the function `point`; see `Role.mapped`."""
        return point(value)

    def of_viewer(self, value: Any, viewer: Any) -> Any:  # noqa: ARG002 as for any role
        """Return the position of the viewer's eye: a headlight is there, whatever its field's `value`."""
        return viewer.position


class Direction(Role):
    """Role of a field that holds a vector of any length."""

    labels: ClassVar[tuple[str, ...]] = ("x", "y", "z")

    def mapped(self, value: Any, point: Map, vector: Map) -> Any:  # noqa: ARG002 it is a vector
        """Return the vector `value` in another frame, by the function `vector`; see `Role.mapped`."""
        return vector(value)


class Up(Direction):
    """Role of a field that holds the direction of a light's height. It fixes the light's rotation around its aim.

    A light with such a field has `axes`, unit vectors as rows: front, right and up.
    """


class Aim(Direction):
    """Role of a field that holds the direction in which a light travels."""

    def of_viewer(self, value: Any, viewer: Any) -> Any:  # noqa: ARG002 as for any role
        """Return the direction of the viewer's view: a headlight shines along it, whatever its field's `value`."""
        return viewer.view_direction


class Corners(Role):
    """Role of a field that holds the corners of a light, in order around the light."""

    unit: ClassVar[str] = MESH_UNIT
    labels: ClassVar[tuple[str, ...]] = ("x", "y", "z")

    def mapped(self, value: Any, point: Map, vector: Map) -> Any:  # noqa: ARG002 they are points
        """Return the corners `value` in another frame, each by the function `point`; see `Role.mapped`."""
        return tuple(point(corner) for corner in value)


@dataclass(frozen=True)
class Length(Role):
    """Role of a field that holds a size, in the mesh's unit.

    Parameters
    ----------
    share : float, default 1
        Distance of the size's handle from the light's middle, as a fraction of the size.
    axis : {0, 1}
        Direction from the light's middle to the handle: 0 for right, 1 for up. If the light has a field with the role
        `Up`, right and up are the light's own; else they are those of the picture.
    """

    share: float = 1.0
    axis: int = 0

    unit: ClassVar[str] = MESH_UNIT


@dataclass(frozen=True)
class Angle(Role):
    """Role of a field that holds an angle, in degrees.

    Parameters
    ----------
    least, most : float
        Bounds of the angle; `check` decides whether the bounds themselves are valid.
    """

    least: float = 0.0
    most: float = 180.0

    unit: ClassVar[str] = "°"


class Width(Role):
    """Role of a field that holds the apparent diameter of an infinitely distant light, in degrees.

    0 is a light without a size.
    """

    unit: ClassVar[str] = "°"


class Turn(Role):
    """Role of a field that holds a rotation around the light's up vector, counter-clockwise, in degrees.

    A light with such a field has `axes`; `axes[0]` is its front.
    """

    unit: ClassVar[str] = "°"


class Falloff(Role):
    """Role of a field that holds a falloff: the attenuation coefficients, or in a subclass another number."""

    unit: ClassVar[str] = f"1, 1/{MESH_UNIT}, 1/{MESH_UNIT}²"
    labels: ClassVar[tuple[str, ...]] = ("constant", "linear", "quadratic")


class Power(Falloff):
    """Role of a field that holds an exponent.

    The light's strength is this power of the cosine of the angle off its aim.
    """

    unit: ClassVar[str] = ""


def meaning(role: Role, default: Any) -> Any:
    """Declare a dataclass field of a light, with a role and a default. The role's `check` checks the field's values."""
    return check.field(role.check, default, role=role)


def place(default: Any = (0.0, 0.0, 0.0)) -> Any:
    """Declare a field that holds the light's position."""
    return meaning(Place(check.vector, "position"), default)


def aim() -> Any:
    """Declare a field that holds the direction in which the light travels."""
    return meaning(Aim(check.direction, "target"), (0.0, 0.0, -1.0))


def length(default: float, handle: str, remedy: str = "", **shown: Any) -> Any:
    """Declare a field that holds a size > 0.

    Parameters
    ----------
    default : float
        Default of the field.
    handle : str
        Name of the size's handle in a window.
    remedy : str
        Sentence that ends the message for an invalid size.
    **shown
        Parameters of `Length`.
    """
    return meaning(Length(partial(check.number, above=0.0, remedy=remedy), handle, **shown), default)


def angle(default: float, handle: str, **limits: Any) -> Any:
    """Declare a field that holds an angle in degrees.

    Parameters
    ----------
    default : float
        Default of the field.
    handle : str
        Name of the angle's handle in a window.
    **limits
        Bounds of the angle and the remedy, as for `check.number`.
    """
    least = limits.get("above", limits.get("at_least", 0.0))
    return meaning(Angle(partial(check.number, **limits), handle, least, limits.get("at_most", 180.0)), default)


def direction_from(position: Any, target: Any) -> Vector:
    """Return the vector from a position to a target. If they are the same, raise a ValueError that names the target."""
    (x, y, z), (a, b, c) = check.vector("position", position), check.vector("target", target)
    if (x, y, z) == (a, b, c):
        check.refuse("target", target, "different from position", "The light shines from position to target.")
    return a - x, b - y, c - z


@cache
def roles_of(kind: Any) -> dict[str, Role]:
    """Return a mapping from name to role, for the fields of the dataclass `kind` that have a role, in order."""
    return {each.name: each.metadata["role"] for each in fields(kind) if "role" in each.metadata}
