"""Rays from vertices to lights: where they begin, where they end, and which need not be cast.

A vertex is on the smooth surface that a mesh stands for, and its normal is that surface's; so a ray that begins there
and rises above the tangent plane meets no face of a convex surface, however coarse: there is no staircase where light
ends to reach it, which rays from inside of faces make (Hanika, "Hacking the shadow terminator", 2021).

An origin is above the tangent plane by the resolution of the triangles. It is also a thousandth of the way into the
vertex's own faces, as far as they are not below that plane: a vertex at the foot of a wall is in the plane of the wall,
and belongs on that side of it on which its faces are.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pvphong.base import threads
from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.base.vectors import dot, unit
from pvphong.geometry.extent import ROUNDED_UP, Extent, Sphere, is_convex
from pvphong.optics.light import NODES, Light
from pvphong.optics.roles import Place
from pvphong.rays.casting import Ball, BlockingFaces
from pvphong.rays.sampling import in_tree_order

_INTO_FACES = 2.0**-10
_AT_ONCE = 2**15


def into_faces(points: Float64Array, normals: Float64Array, triangles: NDArray[np.int64]) -> Float64Array:
    """The ways into the faces of each vertex, not below its tangent plane; zero where these lie evenly around it.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3), in the world; unit normals, or zero.
    triangles : ndarray
        Shape (m, 3), the points at their corners.

    Returns
    -------
    ndarray
        Shape (n, 3): a thousandth of the way to the mean of the middles of its faces, without what of it is against
        the normal.
    """
    columns = np.ascontiguousarray(points.T)
    sums, counts = np.zeros_like(columns), np.zeros(len(points))
    for start in range(0, len(triangles), _AT_ONCE):
        corners = np.ascontiguousarray(triangles[start : start + _AT_ONCE].T)  # long rows are quicker to add up
        middles = np.stack([column[corners[0]] + column[corners[1]] + column[corners[2]] for column in columns]) / 3.0
        sound = np.isfinite(middles).all(axis=0)
        if not sound.all():
            corners, middles = corners[:, sound], middles[:, sound]
        for corner in corners:
            np.add.at(counts, corner, 1.0)
            for axis in range(3):
                np.add.at(sums[axis], corner, middles[axis])
    with np.errstate(invalid="ignore"):
        ways = np.where(counts > 0, sums / np.maximum(counts, 1.0) - columns, 0.0)
        ways -= np.minimum(dot(ways, normals.T), 0.0) * normals.T
    return np.where(np.isfinite(ways), ways, 0.0).T * _INTO_FACES


# --- ray targets: places or directions of lights without a size, and what these send


class Target(NamedTuple):
    """Where rays to a light without a size end."""

    light: Light
    place: Any
    """Where it stands; None where only its direction is known."""

    @classmethod
    def of(cls, light: Light) -> Target:
        """Of a light without a size."""
        places = light.values(Place)
        return cls(light, np.array(places[0], np.float64) if len(places) == 1 and not light.is_even else None)

    @property
    def place_or_way(self) -> Float64Array:
        """Its place, or else the unit vector to it as it is seen from the origin."""
        if self.place is not None:
            return np.asarray(self.place)
        return np.ravel(self.light.arrival(np.zeros((3, 1))).direction).astype(np.float64)

    def seen_from(self, begins: Float64Array) -> tuple[Float64Array, Float64Array]:
        """Unit vectors (n, 3) and distances (n,); infinite ones where nothing says how far away a light is."""
        if self.place is not None:
            return ways_to_goals(self.place, False, begins)
        ways = self.light.arrival(np.ascontiguousarray(begins.T)).direction.T
        return np.broadcast_to(ways, begins.shape), np.full(len(begins), math.inf)


class Targets:
    """Where rays to a light with a size end: at lights without one, in the order of a tree that halves them by place.

    Parameters
    ----------
    light : Light
        With a size, in the world.
    count : int
        Into so many lights it is divided, about.
    """

    def __init__(self, light: Light, count: int) -> None:
        nodes = light.nodes(count)
        targets = [Target.of(node) for node in nodes]
        goals = np.array([target.place_or_way for target in targets])
        order = in_tree_order(goals)
        self._nodes, self._goals = [nodes[k] for k in order], goals[order]
        self._are_ways: Any = np.array([targets[k].place is None for k in order])
        self._are_alike = not self._are_ways.any() and _differ_by_place_alone(nodes)

    def __len__(self) -> int:
        return len(self._nodes)

    def seen_from(self, picked: IntArray, begins: Float64Array) -> tuple[Float64Array, Float64Array]:
        """Unit vectors (n, 3) and distances (n,) to the one that is picked for each begin."""
        return ways_to_goals(self._goals[picked], not self._are_alike and self._are_ways[picked], begins)

    def strengths(self, picked: IntArray, points: Float64Array) -> Float64Array:
        """What each point gets of the one that is picked for it: strength times intensity."""
        if self._are_alike:  # as from the first one, seen from where that is as the picked one is from here
            with np.errstate(all="ignore"):
                shifted = points - (self._goals - self._goals[0])[picked]
                strength = self._nodes[0].arrival(np.ascontiguousarray(shifted.T)).strength
                return np.broadcast_to(self._nodes[0].intensity * strength, len(picked))
        return self._one_by_one(picked, points)

    def _one_by_one(self, picked: IntArray, points: Float64Array) -> Float64Array:
        order = np.argsort(picked, kind="stable")
        bounds = np.searchsorted(picked[order], np.arange(len(self) + 1))
        columns, result = np.ascontiguousarray(points[order].T), np.empty(len(picked))
        with np.errstate(all="ignore"):
            for node, begin, end in zip(self._nodes, bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
                if begin < end:
                    result[order[begin:end]] = node.intensity * node.arrival(columns[:, begin:end]).strength
        return result


def _differ_by_place_alone(nodes: Sequence[Light]) -> bool:
    """Whether lights are the same but for where they stand."""
    first = nodes[0]
    fields = [name for name in vars(first) if name not in first.roles or not isinstance(first.roles[name], Place)]
    return all(
        type(node) is type(first) and all(getattr(node, name) == getattr(first, name) for name in fields)
        for node in nodes
    )


def ways_to_goals(goals: FloatArray, are_ways: Any, begins: Float64Array) -> tuple[Float64Array, Float64Array]:
    """To places, or along ways; and how far."""
    with np.errstate(all="ignore"):
        ways = np.where(np.reshape(are_ways, (-1, 1)), goals, goals - begins)
        directions, lengths = unit(np.ascontiguousarray(ways.T))
    return directions.T, np.where(are_ways, math.inf, lengths)


# --- the occlusion test: why nothing can stand between vertices and a light, known before any ray is cast


def may_block(light: Light, vertices: Sphere | None, ball: Ball) -> bool:
    """Whether a part inside a ball can be between vertices inside a sphere and a light; True where too little is known.

    Parameters
    ----------
    light : Light
        In the world.
    vertices : Sphere or None
        Around them.
    ball : Ball
        Around the part.
    """
    if vertices is None:
        return True
    center, reach = np.array(vertices.center), (vertices.radius + ball.radius) * ROUNDED_UP
    nodes = light.nodes(NODES)
    if light.is_even and light.has_size:
        return True  # it comes from all sides
    if light.is_even:
        return _is_near_ray(ball.center - center, np.ravel(light.arrival(np.zeros((3, 1))).direction), reach)
    places = [node.values(Place) for node in nodes]
    if not all(len(each) == 1 for each in places):
        return True
    around = np.array([place for (place,) in places], np.float64)
    middle = around.mean(axis=0)
    size = float(np.sqrt(((around - middle) ** 2).sum(axis=1).max()))
    # nodes fill the light but for its rim: as they are inside of it, half as much again is certainly around it
    return _distance_to_segment(ball.center - center, middle - center) <= reach + 1.5 * size


def _is_near_ray(target: Float64Array, way: Float64Array, reach: float) -> bool:
    along = float(target @ way)
    across = math.sqrt(max(float(target @ target) - along * along, 0.0))
    return along >= -reach and across <= reach


def _distance_to_segment(target: Float64Array, end: Float64Array) -> float:
    square = float(end @ end)
    along = min(max(float(target @ end) / square, 0.0), 1.0) if square > 0.0 else 0.0
    return float(np.linalg.norm(target - along * end))


# --- the vertices of one mesh that look at lights and at the sky


# Finding out whether a mesh of more faces is convex would take longer than its rays.
_MOST_FACES = 2**15
_NORMALS_AT_ONCE = 2**16


@dataclass(frozen=True, eq=False)
class Receiver:
    """The vertices of one mesh, in the world.

    Parameters
    ----------
    faces : BlockingFaces
        Its points, float64, and its triangles.
    normals : callable
        Gives their normals, shape (n, 3), of any length.
    part : int or None
        Which of the occluders' parts its faces are; None where they block nothing.
    starts : ndarray, optional
        Shape (n, 3): `beside`, where that is known.
    """

    faces: BlockingFaces
    normals: Callable[[], FloatArray]
    part: int | None
    starts: Float64Array | None = None

    def some(self, rows: IntArray) -> Receiver:
        """Some of its vertices, without faces; their rays begin where they begin here."""
        faces = BlockingFaces(self.points[rows], np.empty((0, 3), np.int64))
        return Receiver(faces, lambda: self.unit_normals[rows], self.part, self.beside[rows])

    @property
    def points(self) -> Float64Array:
        """Shape (n, 3)."""
        return self.faces.points.astype(np.float64, copy=False)

    @cached_property
    def unit_normals(self) -> Float64Array:
        """Shape (n, 3); zero where there is none."""
        normals = self.normals()
        result = np.empty(normals.shape)

        def work(first: int, last: int) -> None:
            result[first:last] = unit(normals[first:last].T.astype(np.float64))[0].T

        threads.run(work, len(normals), _NORMALS_AT_ONCE)
        return result

    @cached_property
    def extent(self) -> Extent:
        """Where the vertices are."""
        return Extent(self.points, None, None)

    @cached_property
    def is_convex(self) -> bool:
        """Whether no ray that leaves it meets it again."""
        return len(self.faces) <= _MOST_FACES and is_convex(self.points, self.unit_normals, self.faces.corners)

    @cached_property
    def beside(self) -> Float64Array:
        """The points, a little way into their faces."""
        if self.starts is not None:
            return self.starts
        return self.points + into_faces(self.points, self.unit_normals, self.faces.corners)
