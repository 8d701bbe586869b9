"""Colours at the vertices of a mesh and at places inside its triangles, from the same lighting equation.

The displayed colour inside a triangle is the linear blend of the colours at its corners. The exact colour is the
lighting equation at the blended point with the blended normal, normalised: per-pixel shading, with the visibility of
each light from that point. Places in triangles are barycentric coordinates, shape (m, s, 3): s places in each of m
triangles; or (s, 3) if they are the same for all triangles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import reduce
from itertools import pairwise
from typing import NamedTuple, Protocol, cast

import numpy as np

from pvphong.base import threads
from pvphong.base.types import Float64Array, FloatArray, IntArray, MatrixLike, rgb
from pvphong.base.vectors import columns, dot, towards, unit_vector
from pvphong.geometry.transform import normal_matrix, transform_points
from pvphong.optics.light import Light
from pvphong.optics.maps import Map, fractions
from pvphong.optics.material import Material
from pvphong.optics.roles import Aim, Angle
from pvphong.scene.scene import Scene
from pvphong.shading import kernel
from pvphong.shading.equation import Equation
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices
from pvphong.shading.visibility import Around, Goal, VisibilityLike, checked_visibility

# Number of places from which a thread casts rays at a time: their data stays in the processor's caches.
_PLACES_AT_ONCE = 2**14

# Approximate number of lit places per vertex: a dozen in each of two triangles.
_PLACES_PER_VERTEX = 24


class SeenFromPlaces(VisibilityLike, Protocol):
    """Visibility of the lights and the sky from the vertices of a mesh, and from other places on it."""

    @property
    def behind(self) -> SeenFromPlaces | None:
        """Visibility from the back sides of the vertices; None if the light model is one-sided."""

    def at(
        self,
        points: Float64Array,
        normals: Float64Array,
        origins: Float64Array,
        around: Around | None = None,
    ) -> SeenFromPlaces:
        """Return the visibility from places in the world, by rays from `origins`; all arrays have shape (n, 3).

        `around` holds bounds on the visibility around the places, if they are known.
        """

    def part(self, row: int) -> tuple[FloatArray, FloatArray]:
        """Return the visible part of one light, and its standard error, shape (n,) each.

        `row` is the light's index; the row after the last light is the sky.
        """


class Lighting:
    """Lights and reflectance of a surface.

    The visible part of each light is an attribute of the vertices, `LitVertices.seen`. For a light without a size it is
    1 or 0. With `cuts`, it is 0 outside a light's cone too, and the light itself has no cone. So a vertex on the edge
    of a shadow or cone can have the colour of either side.

    Parameters
    ----------
    scene : Scene
        Scene with a viewer.
    material : Material
        Material of the surface. Its maps are not read.
    matrix : array_like or None
        (4, 4) model matrix.
    vertices : Vertices
        Vertices with the material's maps. Their visibility is a `SeenFromPlaces` if the scene needs rays.
    cuts : bool
        True to move the edges of cones from the lights to the visibility.

    Attributes
    ----------
    equation : Equation
        The whole lighting equation.
    maps : ndarray
        Shape (n, k): the columns of all maps, and of tangents if the reflectance needs them, in float64.
    sharp : tuple of int
        Indices of the lights that are either fully visible or hidden at each place, and not known to be visible
        everywhere.
    soft : tuple of int
        Indices of the lights with a size, which may be partly visible. The index `equation.lights`, one past the last
        light, stands for the sky.
    settled : set of int
        Sharp lights along whose edges, of a shadow or cone, triangles have been cut. If the corners of a triangle agree
        on the visibility of such a light, the visibility is the same inside the triangle.
    """

    def __init__(
        self, scene: Scene, material: Material, matrix: MatrixLike | None, vertices: Vertices, *, cuts: bool
    ) -> None:
        self.scene, self.matrix = scene, matrix
        self.equation = vertices.equation(scene, material, matrix)
        self._ranges = vertices.ranges
        self._material = replace(material, tangents=None)  # they are in `maps` if needed
        columns = {name: fractions(name, values.rows) for name, values in vertices.maps.items()}
        if "tangents" in self.equation.channels:
            columns["tangents"] = vertices.tangents.astype(np.float64)
        ends = np.cumsum([0, *(rows.shape[1] for rows in columns.values())]).tolist()
        self._columns = {name: slice(*part) for name, part in zip(columns, pairwise(ends), strict=True)}
        self.maps = np.concatenate([np.zeros((len(vertices), 0)), *columns.values()], axis=1)
        self._visibility = cast(SeenFromPlaces, vertices.visibility)
        self._lights = {term.index: term.light for term in self.equation.terms}
        blocked = {k for k in self.equation.shadowed if not self._visibility.why_clear(k)}
        is_open = not self.equation.is_occluded or bool(self._visibility.why_open())
        self.soft = tuple(sorted(k for k in blocked if self._lights[k].has_size))
        self._blocked = frozenset(blocked.difference(self.soft))
        self.soft += () if is_open else (self.equation.lights,)
        self._cones = frozenset(filter(self._has_cone, self._lights)) if cuts else frozenset()
        lights, model = list(scene.lights), scene.light_model
        for k in self._cones:  # the visible part decides what is inside the cone, even without shadows
            wider = lights[k].with_values(Angle, (lights[k].values(Angle)[0] + 90.0) / 2.0)
            lights[k] = replace(wider, casts_shadows=True)
        self.sharp = tuple(sorted(self._cones | self._blocked))
        is_shadowed = bool(self.sharp or self.soft)
        occlusion = False if is_open else model.ambient_occlusion
        model = replace(model, clamp=False, shadows=is_shadowed, ambient_occlusion=occlusion)
        self._unclamped = replace(scene, lights=lights, light_model=model)
        self.settled: set[int] = set()
        self._among = 0

    def _has_cone(self, light: int) -> bool:
        """Return True if the edge of a light's cone can be cut like a shadow's edge.

        The light must be 0 outside a cone of less than 90°. The edge cannot be cut in VTK's convention, nor if the
        light has an ambient colour, because visibility does not affect ambient light.
        """
        given = self._lights[light]
        angles = given.values(Angle) if given.values(Aim) else []
        is_alone = self.scene.light_model.convention == "standard" and not any(rgb(given.ambient))
        return is_alone and len(angles) == 1 and angles[0] < 90.0

    def colors(self, points: FloatArray, normals: FloatArray, maps: Float64Array, seen: Float64Array) -> Float64Array:
        """Return the lit colours of n vertices, shape (n, 3), not clamped.

        `points` and `normals` have the shape (n, 3). `maps` has the rows of `Lighting.maps` for these vertices. `seen`,
        shape (n, lights + 1), is the visible part of each light and of the sky; it has the shape (n, 0) if everything
        is visible.
        """
        at = {name: maps[:, part] for name, part in self._columns.items()}
        if "tangents" in at:  # where blended tangents cancel, the normal, which counts as no tangent
            at["tangents"] = np.where(at["tangents"].any(axis=1, keepdims=True), at["tangents"], normals)
        material = self._material.with_values({name: Map(rows) for name, rows in at.items()})
        vertices = Vertices(points, normals, material.maps, tangents=material.tangents, ranges=self._ranges)
        if seen.shape[1]:
            vertices.visibility = checked_visibility("visibility", seen.T, points, self.matrix, self._unclamped)
        plan = Plan.of(self._unclamped, material, vertices, matrix=self.matrix)
        return plan.run(vertices, precision="float64", among=self._among).rgb

    def vertices(self, points: FloatArray, normals: FloatArray) -> LitVertices:
        """Light the mesh's own vertices, and return them. `points` and `normals` have the shape (n, 3)."""
        self._among = _PLACES_PER_VERTEX * len(points)
        p, n = np.asarray(points, np.float64), np.asarray(normals, np.float64)  # PyVista's arrays are slow to slice
        level = dot(*(columns(each) for each in self.in_world(p, n)))
        seen = np.ones((len(p), self.equation.lights + 1 if self.sharp or self.soft else 0))
        errors = np.zeros_like(seen)
        for k in self.sharp + self.soft:
            seen[:, k], errors[:, k] = self.seen(k, p, n)
        return LitVertices(self, p, n, n, self.maps, seen, level, *self.lit(p, n, self.maps, seen, errors))

    def lit(
        self, points: Float64Array, normals: Float64Array, maps: Float64Array, seen: Float64Array, errors: Float64Array
    ) -> tuple[Float64Array, Float64Array]:
        """Return the lit colours of n vertices, shape (n, 3), not clamped, and their standard errors, shape (n,).

        `errors` are the standard errors of the visible parts `seen`; they cause the errors of the colours. The other
        arguments are as for `colors`.
        """
        colors = self.colors(points, normals, maps, seen)
        noise = np.zeros(len(colors))
        if self.soft:
            some = errors.any(axis=1)
            others = seen[some] + np.where(seen[some] > 0.5, -errors[some], errors[some])
            off = self.colors(points[some], normals[some], maps[some], others)
            noise[some] = difference(self.shown(off), self.shown(colors[some]))
        return colors, noise

    def in_world(self, points: Float64Array, normals: Float64Array) -> tuple[Float64Array, Float64Array]:
        """Return points and normals of the mesh in the world, shape (n, 3) each.

        The matrix changes the normals' lengths too.
        """
        if self.matrix is None:
            return points, normals
        return transform_points(points, self.matrix), normals @ normal_matrix(self.matrix).T

    @property
    def limits(self) -> tuple[float, float]:
        """Least and largest value of a displayed colour; infinite if the light model does not clamp."""
        return (0.0, 1.0) if self.scene.light_model.clamp else (-math.inf, math.inf)

    def shown(self, colors: Float64Array) -> Float64Array:
        """Return the colours as they are displayed: clamped to [0, 1] if the light model clamps."""
        return np.clip(colors, *self.limits)

    def seen(
        self,
        light: int,
        points: Float64Array,
        normals: Float64Array,
        level: Float64Array | None = None,
        around: Around | None = None,
    ) -> tuple[Float64Array, Float64Array]:
        """Return the visible part of a light from n places on the mesh, and its standard error, shape (n,) each.

        The visibility is from the side of the surface that the viewer sees. If this side faces away from a light
        without a size, the light counts as visible.

        Rays begin on the blend of the tangent planes at a triangle's corners, if this blend is above the place. A
        convex mesh lies below the tangent planes of its vertices, and so below their blends. So a ray that rises above
        the blend does not hit the mesh, however coarse the mesh is. See `pvphong.rays.rays` for vertices, and J.
        Hanika, "Hacking the shadow terminator" (2021), where places are moved to the blend of their projections.

        Parameters
        ----------
        light : int
            Index among the scene's lights; `equation.lights`, one past the last light, for the sky.
        points, normals : ndarray
            Shape (n, 3). The normals are blends of the vertices' normals, not normalised.
        level : ndarray, optional
            Shape (n,): the dot product of normal and point in the world, blended from `LitVertices.level`. None if the
            places are the mesh's own vertices.
        around : Around, optional
            Known bounds on the visibility around the places.
        """
        p, n = self.in_world(points, normals)
        result, error, source = np.ones(len(p)), np.zeros(len(p)), self._lights.get(light)
        if source is not None and light in self._cones:
            result[inside_cone(source, columns(p)) < 0.0] = 0.0
        if light not in self._blocked and light not in self.soft:
            return result, error
        some, is_behind = np.ones(len(p), bool), np.zeros(len(p), bool)
        if self.equation.two_sided:
            is_behind = dot(columns(n), self.equation.toward_viewer(to_viewer(columns(p), self.equation))) < 0.0
        if source is not None and light in self._blocked:
            facing = np.nan_to_num(dot(columns(n), source.arrival(columns(p)).to_light))
            some = (result > 0.0) & (np.where(is_behind, -facing, facing) > 0.0)
        other = self._visibility.behind
        if around is not None and around.goal is not None:
            some &= around.goal.contribution.any(axis=1)  # elsewhere the visible part changes nothing
        for rows in (some & ~is_behind, some & is_behind):
            if not rows.any():
                continue
            if level is None:
                part, its_error = (self._visibility if other is None or not is_behind[rows][0] else other).part(light)
                result[rows], error[rows] = part[rows], its_error[rows]
                continue
            places, up = p[rows], np.where(is_behind[rows, None], -n[rows], n[rows])
            length = np.linalg.norm(up, axis=1)
            own = np.where(is_behind[rows], -level[rows], level[rows])
            height = np.fmax(own - np.einsum("ki,ki->k", places, up), 0.0)
            scale = np.divide(height, length * length, out=np.zeros_like(length), where=length > 0.0)
            beside = None if around is None else around.at(rows)
            looking = self._visibility.at(places, up, places + scale[:, None] * up, beside)
            result[rows], error[rows] = looking.part(light)
        return result, error


def inside_cone(light: Light, points: Float64Array) -> FloatArray:
    """Return a value for each point that is positive inside a light's cone and negative outside, shape (n,).

    `points` has the shape (3, n). The value is the squared chord of the cone's angle minus the squared chord of the
    angle between axis and ray; see `pvphong.optics.lights.spot`.
    """
    (direction,), (angle,) = light.values(Aim), light.values(Angle)
    chord = light.arrival(points).direction + np.array(unit_vector(direction))[:, None]
    return 4.0 * math.sin(math.radians(angle) / 2.0) ** 2 - dot(chord, chord)


@dataclass(frozen=True)
class LitVertices:
    """Lit vertices. Their attributes are interpolated between them.

    The arrays are float64, and have the shape (n, 3) unless noted.

    Attributes
    ----------
    lighting : Lighting
        Lighting of the vertices and of places between them.
    points : ndarray
        Positions.
    normals : ndarray
        Normals of any length. Blends of normals use these lengths.
    stored : ndarray
        The same normals with the lengths that the resulting mesh stores. Its renderer blends these.
    maps : ndarray
        Shape (n, k): rows as in `Lighting.maps`.
    seen : ndarray
        Shape (n, lights + 1): visible part of each light and of the sky; (n, 0) if all are fully visible.
    level : ndarray
        Shape (n,): dot product of the normal with any point of the vertex's tangent plane, in the world.
    colors : ndarray
        Lit colours, not clamped.
    noise : ndarray
        Shape (n,): standard errors of the colours, from sampled visibility.
    """

    lighting: Lighting
    points: Float64Array
    normals: Float64Array
    stored: Float64Array
    maps: Float64Array
    seen: Float64Array
    level: Float64Array
    colors: Float64Array
    noise: Float64Array

    @property
    def as_stored(self) -> LitVertices:
        """The vertices with the stored normals; `level` is scaled with their lengths."""
        was, now = (np.linalg.norm(each, axis=1) for each in (self.normals, self.stored))
        return replace(self, normals=self.stored, level=self.level * now / np.where(was > 0.0, was, 1.0))


class ComparedColors(NamedTuple):
    """Colours that are compared with the exact colours at places in m triangles."""

    colors: Float64Array
    """The colours to compare, shape (m, s, 3)."""
    allowed: Float64Array
    """Difference that is allowed at each place, shape (m, s). Smaller differences need not be known accurately."""


def lit_inside(
    vertices: LitVertices, corners: IntArray, weights: Float64Array, compared: ComparedColors | None = None
) -> tuple[Float64Array, Float64Array]:
    """Return the exact displayed colours at places in triangles, and the standard errors of these colours.

    The colours have the shape (m, s, 3), and the errors (m, s).

    `corners` holds the vertices of m triangles, shape (m, 3). `weights` holds the barycentric coordinates of s places
    in each triangle, shape (m, s, 3), or (s, 3) if they are the same for all. With `compared`, a place gets no more
    rays as soon as its colour is known to be within the allowed difference.
    """
    own = vertices.points, vertices.normals, vertices.maps
    points, normals, maps = (blended(each, corners, weights) for each in own)
    found = _seen_inside(vertices, corners, weights, compared)
    seen, errors = (each.reshape(len(points), each.shape[-1]) for each in found)
    colors, noise = vertices.lighting.lit(points, normals, maps, seen, errors)
    shape = len(corners), weights.shape[-2]
    return vertices.lighting.shown(colors).reshape(*shape, 3), noise.reshape(shape)


# Fraction of the way to the centre of its triangle by which a ray's origin is moved. It matters for places on a
# boundary, for example at the foot of a wall.
INTO_TRIANGLE = 2.0**-10


def _seen_inside(
    vertices: LitVertices, corners: IntArray, weights: Float64Array, compared: ComparedColors | None
) -> tuple[Float64Array, Float64Array]:
    """Return the visible parts of all lights at places in triangles, and their standard errors.

    Both arrays have the shape (m, s, lights + 1): the last entry is the sky. The arguments are as for `lit_inside`.
    Rays are cast only where the corners do not determine the visibility. For a place at a corner, the corner's sampled
    visibility is used.
    """
    lighting, shape = vertices.lighting, (len(corners), weights.shape[-2], vertices.seen.shape[1])
    seen = blended(vertices.seen, corners, weights).reshape(shape)
    errors, is_shared = np.zeros_like(seen), weights.ndim == 2  # all triangles share the places
    lights = lighting.sharp + lighting.soft
    for k in lights:
        rows, places, goal = np.arange(len(corners)), np.arange(weights.shape[-2]), None
        if k in lighting.settled:
            at_corners = vertices.seen[corners, k]
            rows = np.flatnonzero((at_corners[:, 1:] != at_corners[:, :1]).any(axis=1))
        if k in lighting.soft and is_shared:
            places = np.flatnonzero(weights.max(axis=1) < 1.0)
        if not len(rows) or not len(places):
            continue
        at, some = (rows[:, None], places), weights[places] if is_shared else weights[rows]
        # The colour is known up to the last light's visibility, and without a gamma it is linear in this visibility.
        if compared is not None and k == lights[-1] and lighting.equation.gamma == 1.0:
            without, with_it = _colors_without_and_with(k, vertices, corners[rows], some, seen[at])
            goal = Goal(without - compared.colors[at], with_it - without, compared.allowed[at])
        inside = some * (1.0 - INTO_TRIANGLE) + INTO_TRIANGLE / 3.0
        seen[(*at, k)], errors[(*at, k)] = seen_at(k, vertices, corners[rows], inside, goal)
    return seen, errors


def seen_at(
    light: int, vertices: LitVertices, corners: IntArray, weights: Float64Array, goal: Goal | None = None
) -> tuple[Float64Array, Float64Array]:
    """Return the visible part of a light at places between vertices, and its standard error, shape (m, s) each.

    Parameters
    ----------
    light : int
        Index among the scene's lights; `equation.lights`, one past the last light, for the sky.
    vertices : LitVertices
        Vertices of the mesh.
    corners : ndarray of int
        Shape (m, c): the vertices between which the places lie.
    weights : ndarray
        Shape (m, s, c): weights of these vertices at s places; or (s, c) if they are the same for all m.
    goal : Goal, optional
        Comparison that may end the casting of rays from a place early. The shapes of its arrays begin with (m, s).
    """
    part, error = np.empty((2, len(corners), weights.shape[-2]))

    def work(first: int, last: int) -> None:
        some, w = corners[first:last], weights if weights.ndim == 2 else weights[first:last]
        with np.errstate(all="ignore"):
            own = vertices.points, vertices.normals, vertices.level[:, None]
            points, normals, level = (blended(each, some, w) for each in own)
            at_corners = np.repeat(vertices.seen[some, light], part.shape[1], axis=0)
            its_goal = None if goal is None else goal.at(slice(first, last)).flat
            around = Around(at_corners.min(axis=1), at_corners.max(axis=1), its_goal)
            found = vertices.lighting.seen(light, points, normals, level[:, 0], around)
        part[first:last], error[first:last] = (each.reshape(last - first, -1) for each in found)

    threads.run(work, len(corners), max(_PLACES_AT_ONCE // part.shape[1], 1))
    return part, error


def steps_at(light: int, vertices: LitVertices, corners: IntArray, weights: Float64Array) -> Float64Array:
    """Return how much the colour changes if a light is fully visible instead of hidden, at each place, shape (m, s).

    The result is the largest change of a channel. The arguments are as for `seen_at`.
    """
    seen = blended(vertices.seen, corners, weights)
    colors = _colors_without_and_with(light, vertices, corners, weights, seen)
    return difference(*map(vertices.lighting.shown, colors))


def _colors_without_and_with(
    light: int, vertices: LitVertices, corners: IntArray, weights: Float64Array, seen: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Return the colours at places with a light hidden, and with the light fully visible.

    Both arrays have the shape (m, s, 3), and are not clamped. `light`, `vertices`, `corners` and `weights` are as for
    `seen_at`. `seen` has the visible parts of all lights at each place, shape (m, s, lights + 1) or (m · s, lights +
    1). Its column of this light is ignored.
    """
    own = vertices.points, vertices.normals, vertices.maps
    rows = [*(blended(each, corners, weights) for each in own), seen.reshape(-1, seen.shape[-1])]
    colors = []
    for part in (0.0, 1.0):
        rows[3][:, light] = part
        colors.append(vertices.lighting.colors(*rows).reshape(len(corners), weights.shape[-2], 3))
    return colors[0], colors[1]


def to_viewer(points: Float64Array, equation: Equation) -> Float64Array:
    """Return the unit vectors from `points`, shape (3, k), to the viewer of the equation.

    They have the shape (3, k), or (3, 1) if the viewer is at infinity.
    """
    return np.array(equation.to_eye)[:, None] if equation.eye is None else towards(equation.eye, points)[0]


def blended(
    values: Float64Array,
    corners: IntArray,
    weights: Float64Array,
    low: float = -math.inf,
    high: float = math.inf,
) -> Float64Array:
    """Clip the values of vertices to limits, and interpolate them between vertices.

    Parameters
    ----------
    values : ndarray
        Shape (n, k): a row for each vertex.
    corners : ndarray of int
        Shape (m, c): indices of vertices.
    weights : ndarray
        Shape (m, s, c), or (s, c) if they are the same for all m.
    low, high : float
        The limits.

    Returns
    -------
    ndarray
        Shape (m · s, k): the s places of the first triangle, then those of the second, and so on.
    """
    compiled = kernel.blending()
    if compiled is not None:
        return compiled.blended(values, corners, weights, low, high)
    at_corners = np.clip(values[corners], low, high)
    return (weights @ at_corners).reshape(len(corners) * weights.shape[-2], values.shape[1])


def difference(colors: Float64Array, others: Float64Array) -> Float64Array:
    """Return the largest absolute difference of any channel between each pair of colours.

    `colors` and `others` have the shape (..., 3), and the result has (...).
    """
    compiled = kernel.blending() if colors.shape == others.shape else None
    if compiled is None:
        return largest(np.abs(colors - others))
    rows = (np.require(each.reshape(-1, 3), np.float64, ["C"]) for each in (colors, others))
    return compiled.differences(*rows).reshape(colors.shape[:-1])


def largest(values: Float64Array) -> Float64Array:
    """Return the maximum along the last axis. (For a short axis, `np.max` takes several times as long.)"""
    return reduce(np.maximum, np.moveaxis(values, -1, 0))
