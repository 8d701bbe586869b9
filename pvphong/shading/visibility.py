"""What vertices see of lights, the sky and each other, as plans and evaluators ask for it; `pvphong.rays` finds it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol, cast

import numpy as np

from pvphong.base import check
from pvphong.base.types import BoolArray, Float64Array, FloatArray, MatrixLike
from pvphong.geometry.transform import transform_points
from pvphong.optics.light import Light
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene, light_labels

_GIVEN = "what mesh.phong.visibility(scene) gives"
_PARTS = f"{_GIVEN}, or an array of shape (lights + 1, n)"


class VisibilityLike(Protocol):
    """What n vertices see of a scene's lights, and of the sky."""

    def why_clear(self, light: int) -> str:  # noqa: ARG002
        """Why nothing can block a light; "" where something may."""
        return ""

    def why_open(self) -> str:
        """Why nothing can hide the sky; "" where something may."""
        return ""

    def channels(self, lights: Sequence[int], *, sky: bool, behind: bool = False) -> FloatArray:
        """Parts that are seen, in [0, 1], shape (all the scene's lights + 1, n), the sky's in the last row.

        Rows that are not wanted may hold anything finite. If `behind` is wanted, as many rows follow: what the other
        side of each vertex sees.
        """

    def refuse_other(
        self, points: FloatArray, lights: Sequence[Light], labels: Sequence[str], model: LightModel
    ) -> None:
        """Raise ValueError unless it is of these vertices and lights in the world, and of such a light model."""


class Around(NamedTuple):
    """What is known of n places before rays are cast from them, of one light with a size or of the sky."""

    least: FloatArray
    """Shape (n,): the least part of it that is seen around each place."""
    most: FloatArray
    """Shape (n,): the largest."""
    goal: Goal | None = None
    """When the part that is seen from a place is known well enough; None where the rays' own tolerance says that."""

    def at(self, rows: Any) -> Around:
        """Some of the places."""
        return Around(self.least[rows], self.most[rows], None if self.goal is None else self.goal.at(rows))


class Goal(NamedTuple):
    """Places whose colours are compared with others, and how far they may be off."""

    off: Float64Array
    """Shape (..., 3): the colour where nothing is seen of a light, minus that with which it is compared."""
    step: Float64Array
    """Shape (..., 3): what is added where all of it is seen."""
    allowed: Float64Array
    """Shape (...,): what the largest difference may be."""

    def at(self, rows: Any) -> Goal:
        """Those of some of the places."""
        return Goal(*(each[rows] for each in self))

    def is_reached(self, part: Float64Array, error: Float64Array) -> BoolArray:
        """(n,): whether the colour is within what is allowed, and two standard errors of the part change nothing."""
        off = np.abs(self.off + part[:, None] * self.step) + 2.0 * error[:, None] * np.abs(self.step)
        reached: BoolArray = off.max(axis=1) <= self.allowed
        return reached


class TransportLike(Protocol):
    """What the vertices of a mesh see of each other, or also of those of other meshes."""

    @property
    def is_shared(self) -> bool:
        """Whether there are other meshes, whose vertices send light too."""

    def most(self) -> float:
        """The largest part of the hemisphere, weighted with the cosine, in which a vertex sees lit surfaces."""

    def why_nothing(self) -> str:
        """Why no vertex sees any; "" where one may."""

    def gather(self, colors: FloatArray) -> FloatArray:
        """The mean colours that all vertices see, weighted with the cosine, of what they send; (n, k) both."""


class GivenVisibility(VisibilityLike):
    """A visibility of plain numbers: it is not known why anything is clear, or where the vertices were.

    Parameters
    ----------
    name : str
        The argument's name.
    given : array_like
        Shape (lights + 1, n), the part of each light that each vertex sees, and of the sky in the last row; clipped to
        [0, 1], a NaN counts as 0. As many rows may follow for the vertices' other sides; without, these see the same.
    """

    def __init__(self, name: str, given: Any) -> None:
        self._name = name
        parts = check.real_array(name, given, _PARTS)
        real = parts if parts.dtype in (np.float32, np.float64) else parts.astype(np.float64)
        self._parts: FloatArray = np.fmin(np.fmax(real, 0.0), 1.0)  # fmax takes 0 before a NaN
        self._sides = 1

    def channels(self, lights: Sequence[int], *, sky: bool, behind: bool = False) -> FloatArray:  # noqa: ARG002
        """All of them."""
        if self._sides == 2:
            return self._parts if behind else self._parts[: len(self._parts) // 2]
        return np.concatenate([self._parts] * 2) if behind else self._parts

    def refuse_other(
        self,
        points: FloatArray,
        lights: Sequence[Light],
        labels: Sequence[str],  # noqa: ARG002 the protocol's
        model: LightModel,  # noqa: ARG002 the protocol's
    ) -> None:
        """Raise ValueError unless there are so many vertices and lights."""
        rows = len(lights) + 1
        self._sides = 1 + (self._parts.shape == (2 * rows, len(points)))
        if self._parts.shape != (self._sides * rows, len(points)):
            remedy = "One row for each light, on or off, and one for the sky; one column for each vertex."
            allowed = f"{_GIVEN}, or an array of shape {(len(lights) + 1, len(points))}"
            check.refuse(self._name, f"an array of shape {self._parts.shape}", allowed, remedy)


def checked_visibility(
    name: str, given: Any, points: FloatArray, matrix: MatrixLike | None, scene: Scene
) -> VisibilityLike:
    """What a user gives as what the vertices see: a `Visibility`, or its numbers as `GivenVisibility` takes them.

    Raises
    ------
    ValueError
        If it is something else, or was made for other points or lights.
    """
    if not hasattr(given, "refuse_other"):
        given = GivenVisibility(name, given)
    world = points if matrix is None else transform_points(points, matrix)
    given.refuse_other(world, scene.world_lights, light_labels(scene), scene.light_model)
    return cast(VisibilityLike, given)


def checked_part(name: str, given: Any, count: int) -> TransportLike:
    """The only part of a `Transport` that a user gives for so many vertices.

    Raises
    ------
    ValueError
        If it is something else, or of other vertices.
    """
    allowed = "what mesh.phong.transport() gives"
    parts = getattr(given, "parts", None)
    if parts is None:
        check.refuse(name, type(given).__name__, allowed)
    if len(parts) != 1 or len(given) != count:
        check.refuse(name, repr(given), f"{allowed} of a mesh with these {count} points")
    return cast(TransportLike, parts[0])


def known_transport(vertices: Any) -> TransportLike:
    """What vertices see of each other.

    Raises
    ------
    ValueError
        If that is not known.
    """
    if vertices.transport is None:
        remedy = "mesh.phong.shade casts the rays itself; evaluate takes transport=mesh.phong.transport()."
        check.refuse("light_model", "one with them", "without bounces where only points are known", remedy)
    return cast(TransportLike, vertices.transport)


def refuse_rays(scene: Scene, where: str) -> None:
    """Raise ValueError for a scene with shadows, ambient occlusion or bounces, where no rays are cast."""
    if scene.light_model.is_global:
        remedy = "scene.light_model.without_rays() is the same without them; mesh.phong.shade of the result casts them."
        allowed = f"without shadows, ambient occlusion and bounces {where}"
        check.refuse("light_model", "one with them", allowed, remedy)
