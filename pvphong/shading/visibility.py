"""Interface for visibility of lights and the sky, and for light transport; `pvphong.rays` implements it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol, cast

import numpy as np

from pvphong.base import check
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray, MatrixLike
from pvphong.geometry.transform import transform_points
from pvphong.optics.light import Light
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene, light_labels

_GIVEN = "the result of mesh.phong.visibility(scene)"
_PARTS = f"{_GIVEN}, or an array of shape (lights + 1, n)"


class VisibilityLike(Protocol):
    """Visibility of a scene's lights and of the sky from n vertices."""

    def why_clear(self, light: int) -> str:  # noqa: ARG002
        """Return the reason why nothing can block a light; "" if something may."""
        return ""

    def why_open(self) -> str:
        """Return the reason why nothing can hide the sky; "" if something may."""
        return ""

    def channels(self, lights: Sequence[int], *, sky: bool, behind: bool = False) -> FloatArray:
        """Return visible fractions in [0, 1], shape (lights + 1, n): a row for each light, and a last row for the sky.

        Only the rows of the light indices in `lights`, and with `sky` the last row, must be correct; other rows may
        hold any finite numbers. With `behind`, the same number of rows follows for the back side of each vertex.
        """

    def refuse_other(
        self, points: FloatArray, lights: Sequence[Light], labels: Sequence[str], model: LightModel
    ) -> None:
        """Raise ValueError if this visibility was computed for other points, lights or another light model.

        The arguments are in world coordinates; `model` is the light model. `labels` are the lights' names in messages.
        """


class Around(NamedTuple):
    """Bounds on the visible part of one light, or of the sky, at n places on a surface, known before rays are cast.

    They are the visible parts at the corners of each place's triangle.
    """

    least: FloatArray
    """Least visible part at the corners, shape (n,)."""
    most: FloatArray
    """Largest visible part at the corners, shape (n,)."""
    goal: Goal | None = None
    """Comparison that may end the rays from a place early. If None, only the tolerance of the rays ends them."""

    def at(self, rows: Any) -> Around:
        """Return the bounds around some of the places; `rows` is an index array, a mask or a slice."""
        return Around(self.least[rows], self.most[rows], None if self.goal is None else self.goal.at(rows))


class Goal(NamedTuple):
    """Comparison of the exact colours at places with given colours, for one light.

    The difference is a function of the light's visible part. When the difference is known to be allowed, no more rays
    are cast from the place to the light.
    """

    if_hidden: Float64Array
    """Difference from the given colours if the light is hidden, shape (..., 3)."""
    contribution: Float64Array
    """Colour that the light adds if it is fully visible, shape (..., 3)."""
    allowed: Float64Array
    """Largest difference that is allowed, shape (...)."""

    def at(self, rows: Any) -> Goal:
        """Return the comparison at some of the places; `rows` is an index array, a mask or a slice."""
        return Goal(*(each[rows] for each in self))

    @property
    def flat(self) -> Goal:
        """The comparison for s places in each of m triangles, its arrays reshaped from (m, s, ...) to (m · s, ...)."""
        return Goal(self.if_hidden.reshape(-1, 3), self.contribution.reshape(-1, 3), self.allowed.ravel())

    def is_reached(self, part: Float64Array, error: Float64Array) -> BoolArray:
        """Return True for places at which the difference of colours is surely allowed, shape (n,).

        `part` is the visible part of the light, and `error` its standard error, shape (n,) each. The difference must be
        allowed even if the part is wrong by two standard errors.
        """
        difference = np.abs(self.if_hidden + part[:, None] * self.contribution)
        uncertainty = 2.0 * error[:, None] * np.abs(self.contribution)
        reached: BoolArray = (difference + uncertainty).max(axis=1) <= self.allowed
        return reached


class VisibilityAt(VisibilityLike):
    """Visibility from some of the vertices for which a visibility is known.

    Parameters
    ----------
    whole : VisibilityLike
        Visibility from all vertices.
    rows : ndarray
        Indices of the vertices to keep.
    """

    def __init__(self, whole: VisibilityLike, rows: IntArray) -> None:
        self._whole, self._rows = whole, rows

    def channels(self, lights: Sequence[int], *, sky: bool, behind: bool = False) -> FloatArray:
        """Return the visible fractions from these vertices; arguments and shape as for `VisibilityLike.channels`."""
        return self._whole.channels(lights, sky=sky, behind=behind)[:, self._rows]

    def refuse_other(
        self, points: FloatArray, lights: Sequence[Light], labels: Sequence[str], model: LightModel
    ) -> None:
        """Raise ValueError as the visibility from all vertices does; arguments as for `VisibilityLike.refuse_other`."""
        self._whole.refuse_other(points, lights, labels, model)


class TransportLike(Protocol):
    """Light transport between the vertices of a mesh, and possibly from the vertices of other meshes."""

    @property
    def is_shared(self) -> bool:
        """True if vertices of other meshes send light too."""

    def most(self) -> float:
        """Return the largest fraction of any vertex's hemisphere that lit surfaces fill, weighted by the cosine."""

    def why_nothing(self) -> str:
        """Return the reason why no vertex sees lit surfaces; "" if a vertex may see one."""

    def gather(self, colors: FloatArray) -> FloatArray:
        """Return the mean colour that each vertex sees, weighted by the cosine, shape (n, k).

        `colors` are the colours that the vertices send.
        """


class GivenVisibility(VisibilityLike):
    """Visibility that a user passes as an array.

    The array does not say for which positions it was computed, so the positions are not checked. Plans get no reasons
    for omitting shadows from it.

    Parameters
    ----------
    name : str
        The argument's name.
    given : array_like
        Shape (lights + 1, n): visible part of each light per vertex, and of the sky in the last row; clipped to [0, 1],
        and NaN counts as 0. The same number of rows may follow for the vertices' back sides; without them, both sides
        see the same.
    """

    def __init__(self, name: str, given: Any) -> None:
        self._name = name
        parts = check.real_array(name, given, _PARTS)
        real = parts if parts.dtype in (np.float32, np.float64) else parts.astype(np.float64)
        self._parts: FloatArray = np.fmin(np.fmax(real, 0.0), 1.0)  # fmax prefers 0 to NaN
        self._sides = 1

    def channels(self, lights: Sequence[int], *, sky: bool, behind: bool = False) -> FloatArray:  # noqa: ARG002
        """Return the given rows of all lights and of the sky, including rows that are not requested.

        With `behind`, the same number of rows follows for the vertices' back sides.
        """
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
        """Raise ValueError if the number of vertices or lights is another than in the given array.

        `labels` and `model` are not used.
        """
        rows = len(lights) + 1
        self._sides = 1 + (self._parts.shape == (2 * rows, len(points)))
        if self._parts.shape != (self._sides * rows, len(points)):
            remedy = (
                "Give a row for each light, on or off, then a row for the sky, and a column for each vertex. For a "
                "two-sided light model, the same number of rows may follow for the back sides."
            )
            allowed = f"{_GIVEN}, or an array of shape {(len(lights) + 1, len(points))}"
            check.refuse(self._name, f"an array of shape {self._parts.shape}", allowed, remedy)


def checked_visibility(
    name: str, given: Any, points: FloatArray, matrix: MatrixLike | None, scene: Scene
) -> VisibilityLike:
    """Check the visibility that a user passes for points and a scene, and return it.

    Parameters
    ----------
    name : str
        The argument's name, for messages.
    given
        A `Visibility`, or an array as for `GivenVisibility`.
    points : ndarray
        Shape (n, 3), in the mesh's own coordinates.
    matrix : array_like or None
        (4, 4) model matrix.
    scene : Scene
        The scene.

    Raises
    ------
    ValueError
        If `given` is neither a `Visibility` nor such an array, or was computed for other points or lights.
    """
    if not hasattr(given, "refuse_other"):
        given = GivenVisibility(name, given)
    world = points if matrix is None else transform_points(points, matrix)
    given.refuse_other(world, scene.world_lights, light_labels(scene), scene.light_model)
    return cast(VisibilityLike, given)


def checked_part(name: str, given: Any, count: int) -> TransportLike:
    """Check the transport that a user passes for one mesh of `count` vertices, and return it.

    `name` is the argument's name for messages.

    Raises
    ------
    ValueError
        If `given` is not a `Transport`, or is a transport for several meshes or for another number of vertices.
    """
    allowed = "the result of mesh.phong.transport()"
    parts = getattr(given, "parts", None)
    if parts is None:
        check.refuse(name, type(given).__name__, allowed)
    if len(parts) != 1 or len(given) != count:
        check.refuse(name, repr(given), f"{allowed} for a mesh with these {count} points")
    return cast(TransportLike, parts[0])


def known_transport(vertices: Any) -> TransportLike:
    """Return the light transport between vertices.

    Raises
    ------
    ValueError
        If the vertices have no transport.
    """
    if vertices.transport is None:
        remedy = "Pass transport=mesh.phong.transport(), or call mesh.phong.shade, which casts the rays."
        check.refuse("transport", None, "given for a light model with bounces", remedy)
    return cast(TransportLike, vertices.transport)


def refuse_rays(scene: Scene, where: str) -> None:
    """Raise ValueError for a scene with shadows, ambient occlusion or bounces.

    `where` is a phrase for the message that names the use, such as "for the textbook formula".
    """
    if scene.light_model.is_global:
        remedy = "scene.light_model.without_rays() removes them; mesh.phong.shade supports them."
        allowed = f"without shadows, ambient occlusion and bounces {where}"
        check.refuse("light_model", "one with shadows, ambient occlusion or bounces", allowed, remedy)
