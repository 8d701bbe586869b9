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
        """Return the value in another frame; `point` and `vector` transform positions and vectors into this frame."""
        return value

    def of_viewer(self, value: Any, viewer: Any) -> Any:
        """Return a headlight's value in the world frame; by default, the given value is in eye space."""
        return self.mapped(value, viewer.point_to_world, viewer.vector_to_world)


class Place(Role):
    """Position of a light: three coordinates."""

    unit: ClassVar[str] = MESH_UNIT
    labels: ClassVar[tuple[str, ...]] = ("x", "y", "z")

    def mapped(self, value: Any, point: Map, vector: Map) -> Any:  # noqa: ARG002 it is a point
        """Transform the point."""
        return point(value)

    def of_viewer(self, value: Any, viewer: Any) -> Any:  # noqa: ARG002 as for any role
        """Return the eye's position."""
        return viewer.position


class Direction(Role):
    """A vector of any length."""

    labels: ClassVar[tuple[str, ...]] = ("x", "y", "z")

    def mapped(self, value: Any, point: Map, vector: Map) -> Any:  # noqa: ARG002 it is a vector
        """Transform the vector."""
        return vector(value)


class Up(Direction):
    """Orientation of a light around its aim.

    The light's `axes` are unit vectors as rows: front, right and up.
    """


class Aim(Direction):
    """The direction in which a light travels."""

    def of_viewer(self, value: Any, viewer: Any) -> Any:  # noqa: ARG002 as for any role
        """Return the direction of the view axis."""
        return viewer.view_direction


class Corners(Role):
    """Corners of a light: points in order around the light."""

    unit: ClassVar[str] = MESH_UNIT
    labels: ClassVar[tuple[str, ...]] = ("x", "y", "z")

    def mapped(self, value: Any, point: Map, vector: Map) -> Any:  # noqa: ARG002 they are points
        """Transform the points."""
        return tuple(point(corner) for corner in value)


@dataclass(frozen=True)
class Length(Role):
    """A size, in the mesh's unit.

    Parameters
    ----------
    share : float, default 1
        Distance of the size's handle from the light's middle, as a fraction of the size.
    axis : {0, 1}
        Direction from the light's middle to the handle: 0 for right, 1 for up. These are the light's own directions if
        it has an `Up`, else those of the picture.
    """

    share: float = 1.0
    axis: int = 0

    unit: ClassVar[str] = MESH_UNIT


@dataclass(frozen=True)
class Angle(Role):
    """An angle, in degrees.

    Parameters
    ----------
    least, most : float
        Bounds of the angle; `check` decides whether the bounds themselves are valid.
    """

    least: float = 0.0
    most: float = 180.0

    unit: ClassVar[str] = "°"


class Width(Role):
    """Apparent diameter of a light that is infinitely far away, in degrees; 0 for a light without a size."""

    unit: ClassVar[str] = "°"


class Turn(Role):
    """Rotation of a light around its up vector, counter-clockwise, in degrees; the light's `axes[0]` is its front."""

    unit: ClassVar[str] = "°"


class Falloff(Role):
    """Falloff of a light: the attenuation coefficients, or for a subclass another number."""

    unit: ClassVar[str] = f"1, 1/{MESH_UNIT}, 1/{MESH_UNIT}²"
    labels: ClassVar[tuple[str, ...]] = ("constant", "linear", "quadratic")


class Power(Falloff):
    """Exponent of a light whose strength is a power of the cosine off its aim."""

    unit: ClassVar[str] = ""


def meaning(role: Role, default: Any) -> Any:
    """Declare a field with a role."""
    return check.field(role.check, default, role=role)


def place(default: Any = (0.0, 0.0, 0.0)) -> Any:
    """Declare a field that holds the light's position."""
    return meaning(Place(check.vector, "position"), default)


def aim() -> Any:
    """Declare a field that holds the direction in which the light travels."""
    return meaning(Aim(check.direction, "target"), (0.0, 0.0, -1.0))


def length(default: float, handle: str, remedy: str = "", **shown: Any) -> Any:
    """Declare a field that holds a size > 0; `shown` are parameters of `Length`."""
    return meaning(Length(partial(check.number, above=0.0, remedy=remedy), handle, **shown), default)


def angle(default: float, handle: str, **limits: Any) -> Any:
    """Declare a field that holds an angle in degrees; `limits` are parameters of `check.number`."""
    least = limits.get("above", limits.get("at_least", 0.0))
    return meaning(Angle(partial(check.number, **limits), handle, least, limits.get("at_most", 180.0)), default)


def direction_from(position: Any, target: Any) -> Vector:
    """Return the vector from a position to a target.

    Raises ValueError, which names the target, if they are the same.
    """
    (x, y, z), (a, b, c) = check.vector("position", position), check.vector("target", target)
    if (x, y, z) == (a, b, c):
        check.refuse("target", target, "different from position", "The light shines from position to target.")
    return a - x, b - y, c - z


@cache
def roles_of(kind: Any) -> dict[str, Role]:
    """Return the mapping field name → role, in order, for the fields of a dataclass that have a role."""
    return {each.name: each.metadata["role"] for each in fields(kind) if "role" in each.metadata}
