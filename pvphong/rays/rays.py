"""Rays from vertices to lights: their origins, their targets, and tests that rule them out.

Rays from points inside coarse faces produce a staircase at the shadow terminator (Hanika, "Hacking the shadow
terminator", 2021). But a vertex and its normal belong to the smooth surface that the mesh approximates. So a ray that
starts at a vertex of a convex surface and rises above the tangent plane hits no face, however coarse the faces are.

Rays start above the tangent plane, by the resolution of the triangles. A vertex at the foot of a wall lies in the
wall's plane, and its rays must start on the side of its own faces. So the origin is also moved by a thousandth of the
offset to the mean centroid of the vertex's faces, without the component of this offset against the normal.
`Receiver.turned` is the surface seen from its other side, with the tangent plane's sides exchanged.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pvphong.base import sobol, threads
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray, Vector
from pvphong.base.vectors import dot, unit
from pvphong.geometry.extent import Box, MeshBounds, is_convex
from pvphong.optics.area.sampling import Sampling
from pvphong.optics.light import NODES, Light
from pvphong.optics.roles import Place
from pvphong.rays.casting import BlockingFaces, Occluders

# --- ray targets

BEFORE_LIGHT = 2.0
"""Distance between the end of a ray and its light, in units of the resolution. It is not 0 because the light may lie on
a face."""


def place_of(light: Light) -> Vector | None:
    """Return the end point of rays to a light without a size; None if only the direction to the light is known."""
    places: list[Vector] = light.values(Place)
    return places[0] if len(places) == 1 and not light.is_uniform else None


def place_or_direction(light: Light) -> Float64Array:
    """Return the end point of rays to a light without a size.

    If the light has no position, return the unit vector to the light.
    """
    place = place_of(light)
    if place is None:
        return np.ravel(light.arrival(np.zeros((3, 1))).direction).astype(np.float64)
    return np.array(place, np.float64)


def rays_to(light: Light, origins: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return the unit vectors from origins to a light without a size, shape (n, 3), and the distances, shape (n,).

    `origins` has the shape (n, 3). The distances are infinite if the light has no position.
    """
    place = place_of(light)
    if place is not None:
        towards, lengths = unit(np.ascontiguousarray((np.array(place, np.float64) - origins).T))
        return towards.T, lengths
    directions = light.arrival(np.ascontiguousarray(origins.T)).direction.T
    return np.broadcast_to(directions, origins.shape), np.full(len(origins), math.inf)


def part_by_arrays(
    sampling: Sampling,
    numbers: Float64Array,
    origins: Float64Array,
    normals: Float64Array,
    seeds: NDArray[np.uint32],
    begin: int,
    end: int,
    margin: float,
    occluders: Occluders,
) -> tuple[FloatArray, FloatArray, Float64Array, int]:
    """Cast rays from m vertices to sample points of a light with NumPy, like the compiled `kernel.rays.part_seen`.

    Parameters
    ----------
    sampling : Sampling
        Formulas of the light: its sample points and their contributions.
    numbers : ndarray
        Numbers that describe the light, as the formulas read them.
    origins, normals : ndarray
        Origins of the rays, and unit normals of the vertices, shape (m, 3).
    seeds : ndarray
        Seeds of each vertex's random numbers, shape (2, m).
    begin, end : int
        Numbers of the first sample point, and of the point after the last.
    margin : float
        Distance between the end of a ray and the light.
    occluders : Occluders
        Geometry that can block the rays.

    Returns
    -------
    sent, seen : ndarray
        Weight of each ray, and the same weight or 0 if the ray is blocked, shape (end - begin, m).
    scale : ndarray
        Factor that turns a mean of weights into a colour, shape (m,).
    rays : int
        Number of rays that were cast.
    """
    count = len(origins)
    points = np.arange(begin, end)[:, None]
    u = sobol.coordinate(points.astype(np.uint32), seeds[0])
    v = sobol.coordinate(sobol.SECOND[points], seeds[1])
    with np.errstate(all="ignore"):
        reach, scale, *frame = sampling.frame(numbers, origins.T, normals.T)
        singles = tuple(np.broadcast_to(np.asarray(each, np.float32), count) for each in frame)
        chosen, share, weight = sampling.sample(numbers, singles, u, v)
        sent = np.where(weight > 0.0, weight, np.float32(0.0))
        turn, vertex = np.nonzero(sent)
        directions = np.stack([np.broadcast_to(each, sent.shape)[turn, vertex] for each in chosen], axis=1)
        lengths = (np.broadcast_to(share, sent.shape) * np.asarray(reach))[turn, vertex] - margin
    seen = sent.copy()
    seen[turn, vertex] *= ~occluders.blocked(origins[vertex], directions, lengths)
    return sent, seen, np.broadcast_to(np.asarray(scale, np.float64), count), len(turn)


def around_by_arrays(
    sampling: Sampling,
    numbers: Float64Array,
    origins: Float64Array,
    normals: Float64Array,
    seeds: NDArray[np.uint32],
    begin: int,
    end: int,
    occluders: Occluders,
    triangles: SendingTriangles,
) -> tuple[NDArray[np.int32], int]:
    """Cast rays from m vertices over their hemispheres with NumPy, like the compiled `kernel.hits.vertices_met`.

    Parameters
    ----------
    sampling : Sampling
        Formulas of the hemisphere's directions.
    numbers : ndarray
        Numbers that the formulas read.
    origins, normals : ndarray
        Origins of the rays, and unit normals of the vertices, shape (m, 3).
    seeds : ndarray
        Seeds of each vertex's random numbers, shape (3, m).
    begin, end : int
        Numbers of the first direction, and of the direction after the last.
    occluders : Occluders
        Geometry that rays hit.
    triangles : SendingTriangles
        Triangles of the occluders, with the vertices of those that emit light.

    Returns
    -------
    met : ndarray
        Vertex that each ray hits, shape (m, end - begin); −1 for none.
    rays : int
        Number of rays that were cast.
    """
    points = np.arange(begin, end)
    u = sobol.coordinate(points.astype(np.uint32), seeds[0][:, None])
    v = sobol.coordinate(sobol.SECOND[points], seeds[1][:, None])
    _, _, *frame = sampling.frame(numbers, origins.T, normals.T)
    singles = tuple(np.broadcast_to(np.asarray(each, np.float32), len(origins))[:, None] for each in frame)
    chosen, _, weight = sampling.sample(numbers, singles, u, v)
    directions = np.stack([np.broadcast_to(each, u.shape) for each in chosen], axis=2)
    vertex, turn = np.nonzero(np.broadcast_to(weight, u.shape) > 0.0)
    rays = directions[vertex, turn]
    hits = occluders.first(origins[vertex], rays, np.full(len(rays), math.inf))
    is_met = hits.triangles >= 0
    corners = occluders.points[occluders.triangles.corners[hits.triangles]].astype(np.float64)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    is_front = (across * rays).sum(axis=1) * triangles.sides[hits.triangles] < 0.0
    chance = sobol.random(points.astype(np.uint32), seeds[2][:, None])[vertex, turn]
    corner = np.where(chance < hits.weights[:, 0], 1, np.where(chance < hits.weights.sum(axis=1), 2, 0))
    met = np.full(u.shape, -1, np.int32)
    seen = np.where(is_front, triangles.corners[hits.triangles, corner], -1)
    met[vertex, turn] = np.where(is_met, seen, -1)
    return met, len(rays)


# --- the occlusion test: bounding boxes that rule out occlusion before any ray is cast


BEGUN_ABOVE = 2.0**-15
"""Margin of boxes, relative to their common size: rays start above the vertices, and are rounded."""


def may_block(light: Light, vertices: Box | None, parts: Box) -> BoolArray:
    """Return True for each part of the occluders, usually a mesh, whose box may be between vertices and a light.

    If too little is known, return True for all parts. The space between the vertices' box and the light's box is their
    convex hull: the boxes (1 − t) a + t b with t from 0 to 1. For a light without a position, t has no upper bound.

    Parameters
    ----------
    light : Light
        Light in the world.
    vertices : (low, high) or None
        Least and greatest coordinates of the vertices, shape (3,).
    parts : (low, high)
        Least and greatest coordinates of m parts, shape (m, 3).

    Returns
    -------
    ndarray
        Shape (m,), bool.
    """
    all_of_them = np.ones(len(parts[0]), bool)
    if vertices is None or light.is_all_around:
        return all_of_them
    low, high = vertices
    if light.is_uniform:
        middle = place_or_direction(light)
        ways = np.array([place_or_direction(node) for node in light.nodes(NODES)])
        size = 1.5 * float(np.linalg.norm(ways - middle, axis=1).max())  # as below
        low_step, high_step, last = middle - size, middle + size, math.inf
    else:
        places = [place_of(node) for node in light.nodes(NODES)]
        if None in places:
            return all_of_them
        around = np.array(places, np.float64)
        middle = around.mean(axis=0)
        # nodes fill the light except its rim; 1.5 times their radius encloses it
        size = 1.5 * float(np.sqrt(((around - middle) ** 2).sum(axis=1).max()))
        low_step, high_step, last = middle - size - low, middle + size - high, 1.0
    # each face of a box is a condition, begin + t step <= 0, which holds for all t above a limit, or below one
    slack = _slack(vertices, parts)
    begin = np.concatenate([low - parts[1], parts[0] - high], axis=1) - slack
    step = np.concatenate([low_step, -high_step])
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        passed = -begin / step
    enters = np.where(step < 0.0, passed, 0.0).max(axis=1)
    leaves = np.where(step > 0.0, passed, last).min(axis=1)
    never = ((step == 0.0) & (begin > 0.0)).any(axis=1)
    return ~((np.maximum(enters, 0.0) > np.minimum(leaves, last)) | never)


def may_hide(vertices: Box | None, parts: Box, distance: float) -> BoolArray:
    """Return True for each part of the occluders that may be within `distance` of a vertex, shape (m,).

    `vertices` has the least and the greatest coordinates of the vertices. If it is None, they are unknown, and the
    result is True for all parts. `parts` has the least and the greatest coordinates of m parts, shape (m, 3) each.
    """
    if vertices is None:
        return np.ones(len(parts[0]), bool)
    low, high = vertices
    gaps = np.maximum(np.maximum(parts[0] - high, low - parts[1]), 0.0)
    return np.hypot.reduce(gaps, axis=1) <= 1.001 * distance + _slack(vertices, parts)


def _slack(vertices: Box, parts: Box) -> float:
    sizes = np.concatenate([[vertices[1]], parts[1]]).max(axis=0) - np.concatenate([[vertices[0]], parts[0]]).min(
        axis=0
    )
    return BEGUN_ABOVE * float(sizes.max())


# --- the vertices of a mesh that receive light


class Begun(NamedTuple):
    """Origins of rays from n vertices, before they are raised above the tangent planes of the vertices."""

    origins: Float64Array
    """Points moved slightly into their faces, shape (n, 3)."""
    rise: FloatArray
    """Mean height of the centroids of each vertex's faces above its tangent plane, shape (n,)."""


class SendingTriangles(NamedTuple):
    """All triangles of the occluders, for compiled code. Some of them emit light from their fronts."""

    starts: IntArray
    """Index in `numbers` at which each caster's triangles start."""
    numbers: IntArray
    """Indices of the casters' triangles among all triangles, caster after caster."""
    corners: IntArray
    """Vertex indices of each triangle's corners, shape (m, 3); −1 if the triangle does not emit."""
    sides: NDArray[np.int8]
    """Shape (m,): 1 if a triangle's corners are counter-clockwise seen from its front, −1 if clockwise, 0 without a
    front."""


# Largest number of faces for the convexity test; for more, it would take longer than the rays.
_MOST_FACES = 2**15
_NORMALS_AT_ONCE = 2**16
# Fraction of the offset from a vertex to the mean centroid of its faces by which the origin of its rays moves.
_INTO_FACES = 2.0**-10
_TRIANGLES_AT_ONCE = 2**15


@dataclass(frozen=True, eq=False)
class Receiver:
    """Vertices of a mesh that receive light, in the world.

    Parameters
    ----------
    faces : BlockingFaces
        Points of the mesh, float64, and its triangles.
    normals : callable
        Returns the normals, shape (n, 3), of any length.
    part : int or None
        Index of the mesh's faces among the occluders' parts; None if they block nothing.
    known : callable, optional
        Function that returns the origins of rays. By default, the origins are computed from the faces.
    """

    faces: BlockingFaces
    normals: Callable[[], FloatArray]
    part: int | None
    known: Callable[[], Begun] | None = None

    def some(self, rows: IntArray) -> Receiver:
        """Return a receiver with only the vertices whose indices are `rows`, and the faces between these vertices.

        The rays have the same origins as in this receiver.
        """
        places = np.full(len(self.points), -1)
        places[rows] = np.arange(len(rows))
        corners = places[self.faces.corners]
        faces = BlockingFaces(self.points[rows], corners[(corners >= 0).all(axis=1)])
        begun = Begun(self.origins[rows], self.begun.rise[rows])
        return Receiver(faces, lambda: self.unit_normals[rows], self.part, lambda: begun)

    @cached_property
    def turned(self) -> Receiver:
        """The same vertices with opposite normals. Rays start on the back side."""
        return Receiver(self.faces, lambda: -self.unit_normals, self.part, self._begun_behind)

    def _begun_behind(self) -> Begun:
        origins, rise = self.begun
        return Begun(origins - (_INTO_FACES * np.abs(rise))[:, None] * self.unit_normals, -rise)

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling.

        In this state, the results of the callables replace the callables. The origins of rays are included only if they
        are known.
        """
        normals, is_known = self.unit_normals, self.known is not None or "begun" in vars(self)
        known = partial(Begun, *self.begun) if is_known else None
        found = {"normals": partial(np.asarray, normals), "known": known, "unit_normals": normals}
        return {"faces": self.faces, "part": self.part} | found

    @property
    def points(self) -> Float64Array:
        """Points of the mesh, shape (n, 3)."""
        return self.faces.points.astype(np.float64, copy=False)

    @cached_property
    def unit_normals(self) -> Float64Array:
        """Unit normals, shape (n, 3); zero for a vertex without a normal."""
        normals = self.normals()
        result = np.empty(normals.shape)

        def work(first: int, last: int) -> None:
            result[first:last] = unit(normals[first:last].T.astype(np.float64))[0].T

        threads.run(work, len(normals), _NORMALS_AT_ONCE)
        return result

    def above(self, rows: Any, height: Any) -> Float64Array:
        """Return the rays' origins for the vertices `rows` (indices), raised by `height` along the normals."""
        return self.origins[rows] + height * self.unit_normals[rows]

    @cached_property
    def extent(self) -> MeshBounds:
        """Bounds on the positions of the vertices."""
        return MeshBounds(self.points, None, None)

    @cached_property
    def is_convex(self) -> bool:
        """True if no ray that leaves the mesh can hit the mesh again."""
        return len(self.faces) <= _MOST_FACES and is_convex(self.points, self.unit_normals, self.faces.corners)

    @property
    def origins(self) -> Float64Array:
        """Origins of rays before they are raised above the tangent plane: points moved slightly into their faces.

        The shift is a thousandth of the offset to the mean centroid of a point's faces, without its component against
        the normal. The shift is zero if the faces lie evenly around the point.
        """
        return self.begun.origins

    @cached_property
    def begun(self) -> Begun:
        """Origins of rays, and the mean height of the faces around each vertex above its tangent plane.

        The origins on the back side follow from this height.
        """
        if self.known is not None:
            return self.known()
        points, normals, triangles = self.points, self.unit_normals, self.faces.corners
        columns = np.ascontiguousarray(points.T)
        sums, counts = np.zeros_like(columns), np.zeros(len(points))
        for start in range(0, len(triangles), _TRIANGLES_AT_ONCE):
            some = triangles[start : start + _TRIANGLES_AT_ONCE]
            corners = np.ascontiguousarray(some.T)  # sums over long rows are faster
            middles = np.stack([column[corners].sum(axis=0) for column in columns]) / 3.0
            sound = np.isfinite(middles).all(axis=0)
            if not sound.all():
                corners, middles = corners[:, sound], middles[:, sound]
            for corner in corners:
                np.add.at(counts, corner, 1.0)
                for axis in range(3):
                    np.add.at(sums[axis], corner, middles[axis])
        with np.errstate(invalid="ignore"):
            inward = np.where(counts > 0, sums / np.maximum(counts, 1.0) - columns, 0.0)
            rise = dot(inward, normals.T)
            inward -= np.minimum(rise, 0.0) * normals.T
        origins = points + np.where(np.isfinite(inward), inward, 0.0).T * _INTO_FACES
        return Begun(origins, np.where(np.isfinite(rise), rise, 0.0).astype(np.float32))
