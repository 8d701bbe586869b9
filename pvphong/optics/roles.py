"""What a light's field means: from its role follow its check, its frame, its handle, its readout and how it is moved.

Handles and readouts by role are in `studio/gizmos/handles.py`. A light declares its fields with these::

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

    unit: ClassVar[str] = ""
    """What its numbers are measured in."""
    labels: ClassVar[tuple[str, ...]] = ()
    """What each number is called, where there are several."""

    def mapped(self, value: Any, point: Map, vector: Map) -> Any:  # noqa: ARG002 a number is the same in all frames
        """The value in another frame, which two functions take points and vectors to."""
        return value

    def of_viewer(self, value: Any, viewer: Any) -> Any:
        """The value in the world for a light that is the viewer's: by default one of eye space."""
        return self.mapped(value, viewer.point_to_world, viewer.vector_to_world)


class Place(Role):
    """Where a light is: three coordinates."""

    unit: ClassVar[str] = MESH_UNIT
    labels: ClassVar[tuple[str, ...]] = ("x", "y", "z")

    def mapped(self, value: Any, point: Map, vector: Map) -> Any:  # noqa: ARG002 it is a point
        """The point."""
        return point(value)

    def of_viewer(self, value: Any, viewer: Any) -> Any:  # noqa: ARG002 as for any role
        """The eye."""
        return viewer.position


class Direction(Role):
    """A vector of any length."""

    labels: ClassVar[tuple[str, ...]] = ("x", "y", "z")

    def mapped(self, value: Any, point: Map, vector: Map) -> Any:  # noqa: ARG002 it is a vector
        """The vector."""
        return vector(value)


class Up(Direction):
    """How a light is turned around its aim.

    The light's `axes` are unit vectors as rows: where its front is, to the right of that, and up.
    """


class Aim(Direction):
    """The direction in which a light travels."""

    def of_viewer(self, value: Any, viewer: Any) -> Any:  # noqa: ARG002 as for any role
        """Along the view axis."""
        return viewer.view_direction


class Corners(Role):
    """Where the corners of a light are: points one after the other around it."""

    unit: ClassVar[str] = MESH_UNIT
    labels: ClassVar[tuple[str, ...]] = ("x", "y", "z")

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

    unit: ClassVar[str] = MESH_UNIT


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

    unit: ClassVar[str] = "°"


class Turn(Role):
    """The degrees by which a light is turned around what is up, counter-clockwise; its front then is `axes[0]`."""

    unit: ClassVar[str] = "°"


class Falloff(Role):
    """How the light weakens: the coefficients of the distance, or as its kinds say."""

    unit: ClassVar[str] = f"1, 1/{MESH_UNIT}, 1/{MESH_UNIT}²"
    labels: ClassVar[tuple[str, ...]] = ("constant", "linear", "quadratic")


class Power(Falloff):
    """The exponent of a light that is a power of the cosine off its aim."""

    unit: ClassVar[str] = ""


def meaning(role: Role, default: Any) -> Any:
    """A field with a role."""
    return check.field(role.check, default, role=role)


def place(default: Any = (0.0, 0.0, 0.0)) -> Any:
    """A field that says where the light is."""
    return meaning(Place(check.vector, "position"), default)


def aim() -> Any:
    """A field that says in which direction the light travels."""
    return meaning(Aim(check.direction, "target"), (0.0, 0.0, -1.0))


def length(default: float, handle: str, remedy: str = "", **shown: Any) -> Any:
    """A field that holds a size > 0, shown as `Length` says."""
    return meaning(Length(partial(check.number, above=0.0, remedy=remedy), handle, **shown), default)


def angle(default: float, handle: str, **limits: Any) -> Any:
    """A field that holds an angle in degrees, within limits as `check.number` takes them."""
    least = limits.get("above", limits.get("at_least", 0.0))
    return meaning(Angle(partial(check.number, **limits), handle, least, limits.get("at_most", 180.0)), default)


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
