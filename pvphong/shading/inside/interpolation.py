"""How far colours interpolated across triangles are from the lit ones: what is compared, where, and the errors there.

The colour inside a triangle is the linear blend of the colours at its corners. The truth is the lighting
equation at the blended point with the blended normal, made unit length: per-pixel shading, with what is seen of each
light from there.

They are compared at a fixed pattern of places, and where no fixed pattern would hit: at peaks, where a light is
brightest, and at creases, where colours bend or jump. Places are barycentric coordinates, (s, 3) or (m, s, 3).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import reduce
from itertools import chain, pairwise
from typing import Any, NamedTuple, Protocol, cast

import numpy as np

from pvphong.base import threads
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray, MatrixLike, rgb
from pvphong.base.vectors import columns, cross, dot, towards, unit, unit_vector
from pvphong.geometry.transform import normal_matrix, transform_points
from pvphong.optics.light import Light
from pvphong.optics.maps import Map, fractions
from pvphong.optics.material import Material
from pvphong.optics.roles import Aim, Angle, Power
from pvphong.scene.scene import Scene
from pvphong.shading.equation import Equation, LightTerm
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices
from pvphong.shading.visibility import VisibilityLike, checked_visibility

# Samples that a thread looks at together.
_SAMPLES = 2**17
# Triangles that are measured together.
_TRIANGLES_AT_ONCE = 2**13
# Places from which a thread casts rays at a time: what is known of them stays in the processor's caches.
_PLACES_AT_ONCE = 2**14


# --- what is compared


class SeenFromPlaces(VisibilityLike, Protocol):
    """What is seen of the lights and the sky from the vertices of a mesh, and from other places on it."""

    @property
    def behind(self) -> SeenFromPlaces | None:
        """What is seen from their other sides; None where the light model is one-sided."""

    def at(self, points: Float64Array, normals: Float64Array, origins: Float64Array) -> SeenFromPlaces:
        """What is seen from places in the world, with normals there, by rays that begin at origins; all (n, 3)."""

    def part(self, row: int) -> tuple[FloatArray, FloatArray]:
        """The part that is seen of a light, or in the row after theirs of the sky, and its standard error, (n,)."""


class Lighting:
    """What a surface is lit by, and how it reflects.

    What is seen of each light counts as one of the numbers at vertices, `seen`: of a light without a size it is 1 or 0,
    and 0 outside of a cone too, whose edge is here not the light's but one of what is seen of it. So a vertex on such
    an edge can be lit as its one side is, or as the other.

    Parameters
    ----------
    scene : Scene
        With a viewer.
    material : Material
        Its maps are not read.
    matrix : array_like or None
        (4, 4) model matrix.
    vertices : Vertices
        With the material's maps, and with a visibility that is `SeenFromPlaces` where the scene asks for rays.
    cuts : bool, default False
        Whether edges of cones are to be part of what is seen.

    Attributes
    ----------
    equation : Equation
        The whole lighting equation.
    maps : ndarray
        Shape (n, k): the maps, and tangents where the reflectance needs them, in float64, side by side.
    sharp : tuple of int
        Places among the scene's lights of those of which all or nothing is seen, and something may be in between.
    soft : tuple of int
        Places of those of which a part may be seen, which have a size; and of the sky, the number of lights.
    settled : set of int
        Those of the sharp ones whose edges run between triangles: inside of these is seen what corners agree on.
    """

    def __init__(
        self, scene: Scene, material: Material, matrix: MatrixLike | None, vertices: Vertices, *, cuts: bool
    ) -> None:
        self.scene, self.matrix = scene, matrix
        self.equation = vertices.equation(scene, material, matrix)
        self._ranges = vertices.ranges
        self._material = replace(material, tangents=None)  # they are among the maps, where anything reads them
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
        for k in self._cones:
            lights[k] = lights[k].with_values(Angle, (lights[k].values(Angle)[0] + 90.0) / 2.0)
        self.sharp = tuple(sorted(self._cones | self._blocked))
        is_shadowed = bool(self.sharp or self.soft)
        occlusion = False if is_open else model.ambient_occlusion
        model = replace(model, clamp=False, shadows=is_shadowed, ambient_occlusion=occlusion)
        self._unclamped = replace(scene, lights=lights, light_model=model)
        self.settled: set[int] = set()

    def _has_cone(self, light: int) -> bool:
        """Whether a light has a cone that can be a part of what is seen of it: its ambient colour is not."""
        given = self._lights[light]
        angles = given.values(Angle) if given.values(Aim) else []
        is_alone = self.scene.light_model.convention == "standard" and not any(rgb(given.ambient))
        return is_alone and len(angles) == 1 and angles[0] < 90.0

    def colors(self, points: FloatArray, normals: FloatArray, maps: Float64Array, seen: Float64Array) -> Float64Array:
        """(n, 3) lit colours before they are clamped, for rows of `maps` and of what is seen."""
        at = {name: maps[:, part] for name, part in self._columns.items()}
        if "tangents" in at:  # blends that cancel are no directions, nor is one along the normal
            at["tangents"] = np.where(at["tangents"].any(axis=1, keepdims=True), at["tangents"], normals)
        material = self._material.with_values({name: Map(rows) for name, rows in at.items()})
        vertices = Vertices(points, normals, material.maps, tangents=material.tangents, ranges=self._ranges)
        if seen.shape[1]:
            vertices.visibility = checked_visibility("visibility", seen.T, points, self.matrix, self._unclamped)
        plan = Plan.of(self._unclamped, material, vertices, matrix=self.matrix)
        return plan.run(vertices, precision="float64", backend="numpy").rgb

    def vertices(self, points: FloatArray, normals: FloatArray) -> LitVertices:
        """The mesh's own, which begin what is interpolated."""
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
        """`colors`, and their standard errors (n,), from those of what is seen of lights with a size and of the sky."""
        colors = self.colors(points, normals, maps, seen)
        noise = np.zeros(len(colors))
        if self.soft:
            some = errors.any(axis=1)
            others = seen[some] + np.where(seen[some] > 0.5, -errors[some], errors[some])
            off = self.colors(points[some], normals[some], maps[some], others)
            noise[some] = _difference(self.shown(off), self.shown(colors[some]))
        return colors, noise

    def in_world(self, points: Float64Array, normals: Float64Array) -> tuple[Float64Array, Float64Array]:
        """Points and normals (n, 3) of the mesh; the matrix takes the normals' lengths along."""
        if self.matrix is None:
            return points, normals
        return transform_points(points, self.matrix), normals @ normal_matrix(self.matrix).T

    def shown(self, colors: Float64Array) -> Float64Array:
        """Colours as the light model shows them, clamped or not."""
        return np.clip(colors, 0.0, 1.0) if self.scene.light_model.clamp else colors

    def seen(
        self, light: int, points: Float64Array, normals: Float64Array, level: Float64Array | None = None
    ) -> tuple[Float64Array, Float64Array]:
        """What is seen of a light from places on the mesh, and its standard error, (n,).

        Of a sharp one that is 1 where they face away from it. It is seen from the side that the viewer sees.

        Rays begin on the plane that blends the tangent planes at a triangle's corners, if that is above it. All of a
        convex mesh is below its vertices' tangent planes, and so below their blends: a ray that rises above one meets
        nothing of it, however coarse it is. See `pvphong.rays.rays` for vertices, and J. Hanika, "Hacking the shadow
        terminator" (2021), who moves places to the blend of their projections.

        Parameters
        ----------
        light : int
            Its place among the scene's lights; their number for the sky.
        points, normals : ndarray
            (n, 3), the normals with the lengths with which they are blended.
        level : ndarray, optional
            (n,): the product of normal and point, in the world, blended as `LitVertices.level`. Without, the places
            are the mesh's own vertices.
        """
        p, n = self.in_world(points, normals)
        result, error, source = np.ones(len(p)), np.zeros(len(p)), self._lights.get(light)
        if source is not None and light in self._cones:
            result[_inside_cone(source, columns(p)) < 0.0] = 0.0
        if light not in self._blocked and light not in self.soft:
            return result, error
        some, is_behind = np.ones(len(p), bool), np.zeros(len(p), bool)
        if self.equation.two_sided:
            is_behind = dot(columns(n), self.equation.toward_viewer(_to_viewer(columns(p), self.equation))) < 0.0
        if source is not None and light in self._blocked:
            facing = np.nan_to_num(dot(columns(n), source.arrival(columns(p)).to_light))
            some = (result > 0.0) & (np.where(is_behind, -facing, facing) > 0.0)
        other = self._visibility.behind
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
            result[rows], error[rows] = self._visibility.at(places, up, places + scale[:, None] * up).part(light)
        return result, error


def _inside_cone(light: Light, points: Float64Array) -> FloatArray:
    """(n,): positive inside of a light's cone, negative outside, by the chord between its axis and the ray; see
    `pvphong.optics.lights.spot`.
    """
    (direction,), (angle,) = light.values(Aim), light.values(Angle)
    chord = light.arrival(points).direction + np.array(unit_vector(direction))[:, None]
    return 4.0 * math.sin(math.radians(angle) / 2.0) ** 2 - dot(chord, chord)


@dataclass(frozen=True)
class LitVertices:
    """Points, and what is interpolated between them: float64 arrays of shape (n, 3), but for those that say so.

    Attributes
    ----------
    lighting : Lighting
        What lights them, and all between them.
    points : ndarray
        Where they are.
    normals : ndarray
        Of the lengths with which they are blended.
    stored : ndarray
        The same directions, of the lengths with which whoever gets the mesh will blend them.
    maps : ndarray
        Shape (n, k), as `Lighting.maps` has them.
    seen : ndarray
        Shape (n, lights + 1), the part of each light, and of the sky, that is seen; (n, 0) where all is.
    level : ndarray
        Shape (n,): where the tangent plane is, as the product with the normal, in the world, of each of its points.
    colors : ndarray
        The lit colours before they are clamped.
    noise : ndarray
        Shape (n,): their standard errors, where what is seen was sampled.
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
        """The same, as whoever gets the mesh will blend them: planes go with the lengths of normals."""
        was, now = (np.linalg.norm(each, axis=1) for each in (self.normals, self.stored))
        return replace(self, normals=self.stored, level=self.level * now / np.where(was > 0.0, was, 1.0))


def _lit_inside(vertices: LitVertices, corners: IntArray, weights: Float64Array) -> tuple[Float64Array, Float64Array]:
    """The truth at places in triangles (m, 3), as it is shown, (m, s, 3); and its standard error, (m, s)."""
    points, normals = weights @ vertices.points[corners], weights @ vertices.normals[corners]
    maps, (seen, errors) = weights @ vertices.maps[corners], _seen_inside(vertices, corners, weights)
    rows = [each.reshape(points.size // 3, each.shape[-1]) for each in (points, normals, maps, seen, errors)]
    colors, noise = vertices.lighting.lit(*rows)
    return vertices.lighting.shown(colors).reshape(points.shape), noise.reshape(points.shape[:2])


# A place on a boundary, at the foot of a wall say, is looked at from so far inside of its triangle.
INTO_TRIANGLE = 2.0**-10


def _seen_inside(vertices: LitVertices, corners: IntArray, weights: Float64Array) -> tuple[Float64Array, Float64Array]:
    """What is seen from places in triangles, by rays where corners do not say it, and its error: (m, s, lights + 1)."""
    seen = weights @ vertices.seen[corners]
    errors = np.zeros_like(seen)
    for k in vertices.lighting.sharp + vertices.lighting.soft:
        at_corners = vertices.seen[corners, k]
        rows = np.arange(len(corners))
        if k in vertices.lighting.settled:
            rows = np.flatnonzero((at_corners[:, 1:] != at_corners[:, :1]).any(axis=1))
        if len(rows):
            inside = (weights if weights.ndim == 2 else weights[rows]) * (1.0 - INTO_TRIANGLE) + INTO_TRIANGLE / 3.0
            seen[rows, :, k], errors[rows, :, k] = seen_at(k, vertices, corners[rows], inside)
    return seen, errors


def seen_at(
    light: int, vertices: LitVertices, corners: IntArray, weights: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """`Lighting.seen` from places that are blends of vertices (m, c) with weights (s, c) or (m, s, c): (m, s)."""
    part, error = np.empty((2, len(corners), weights.shape[-2]))

    def work(first: int, last: int) -> None:
        some, w = corners[first:last], weights if weights.ndim == 2 else weights[first:last]
        with np.errstate(all="ignore"):
            points, normals = w @ vertices.points[some], w @ vertices.normals[some]
            level = (w @ vertices.level[some][..., None]).ravel()
            found = vertices.lighting.seen(light, points.reshape(-1, 3), normals.reshape(-1, 3), level)
        part[first:last], error[first:last] = (each.reshape(points.shape[:2]) for each in found)

    threads.run(work, len(corners), max(_PLACES_AT_ONCE // part.shape[1], 1))
    return part, error


def steps_at(light: int, vertices: LitVertices, corners: IntArray, weights: Float64Array) -> Float64Array:
    """(m, s): how far the colour with all of a light is from that with nothing of it, at places in triangles (m, 3)."""
    rows = [weights @ each[corners] for each in (vertices.points, vertices.normals, vertices.maps, vertices.seen)]
    shape = rows[0].shape[:2]
    rows = [each.reshape(math.prod(shape), each.shape[-1]) for each in rows]
    colors = []
    for part in (1.0, 0.0):
        rows[3][:, light] = part
        colors.append(vertices.lighting.shown(vertices.lighting.colors(*rows)))
    return _difference(*colors).reshape(shape)


def _errors_at(vertices: LitVertices, corners: IntArray, weights: Float64Array) -> Float64Array:
    """(m, s): difference of blended and lit colours at places in triangles (m, 3), in the worst channel."""
    blended = weights @ vertices.lighting.shown(vertices.colors[corners])
    truth, noise = _lit_inside(vertices, corners, weights)
    off = _difference(blended, truth)
    if not vertices.lighting.soft:
        return off
    return np.maximum(off - _SURE * (noise + (weights @ vertices.noise[corners][..., None])[..., 0]), 0.0)


# So many standard errors no sample is off: what is less is noise, which is not to be split.
_SURE = 3.0


def _difference(colors: Float64Array, others: Float64Array) -> Float64Array:
    """The difference of colours (..., 3) in the channel where it is largest."""
    return _largest(np.abs(colors - others))


def _largest(values: Float64Array) -> Float64Array:
    """The largest along the last axis, which is short: `max` takes several times as long."""
    return reduce(np.maximum, np.moveaxis(values, -1, 0))


def sizes(points: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Longest side and least height (m,) of triangles (m, 3, 3).

    The height is zero or NaN where a triangle has no area, or a point that is not finite.
    """
    longest, height = np.empty((2, len(points)))

    def measure(first: int, last: int) -> None:
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            a, b, c = points[first:last].transpose(1, 2, 0)
            sides = np.stack([b - a, c - b, a - c])
            scale = np.abs(sides).max(axis=(0, 1), initial=0.0)
            sides /= scale
            most = np.sqrt(np.square(sides).sum(axis=1).max(axis=0))
            vector = cross(sides[0], sides[1])
            longest[first:last], height[first:last] = most * scale, np.sqrt(dot(vector, vector)) / most * scale

    threads.run(measure, len(points), _TRIANGLES_AT_ONCE)
    return longest, height


def area(points: Float64Array) -> float:
    """The area of triangles (m, 3, 3) together; those that have none, or a point that is not finite, count as 0."""
    longest, height = sizes(points)
    return float(np.nan_to_num(longest * height).sum()) / 2.0


def odd_corner(is_above: BoolArray) -> IntArray:
    """The corner of triangles (m, 3) that is alone above or below; the first one where all are alike."""
    return (is_above == (is_above.sum(axis=1) == 1)[:, None]).argmax(axis=1)


# --- where: places that no fixed pattern would hit


class Places(NamedTuple):
    """One place in each of some triangles."""

    rows: IntArray
    """(k,): the triangles."""

    weights: Float64Array
    """(k, 3): where in each, in barycentric coordinates."""


class _AtCorners:
    """What is known at the corners of some triangles (m, 3), computed once for each vertex."""

    def __init__(self, vertices: LitVertices, corners: IntArray) -> None:
        low, high = int(corners.min(initial=len(vertices.points))), int(corners.max(initial=0)) + 1
        if high - low <= corners.size:  # they are near each other in the mesh
            self._rows: slice | IntArray = slice(low, high)
            self.corners = corners - low
        else:
            self._rows, inverse = np.unique(corners, return_inverse=True)
            self.corners = inverse.reshape(corners.shape)
        points, normals = vertices.points[self._rows], vertices.normals[self._rows]
        self.points, self.normals = vertices.lighting.in_world(points, normals)
        self.p, self.n = columns(self.points), columns(self.normals)
        self.colors = vertices.colors[self._rows]

    def of(self, values: Any) -> Any:
        """Values of each vertex, of shape (n, ...) each, at the corners, (m, 3, ...)."""
        return values[self.corners]


def _to_viewer(points: Float64Array, equation: Equation) -> Float64Array:
    """Unit vectors v to the viewer, (3, k), or (3, 1) where they are all the same, from points (3, k)."""
    return np.array(equation.to_eye)[:, None] if equation.eye is None else towards(equation.eye, points)[0]


def _chords(term: LightTerm, equation: Equation, points: Float64Array, normals: Float64Array) -> Float64Array:
    """D (k, 3), whose half square is one minus the cosine that a highlight is a power of: between mirror direction and
    viewer, say. See `pvphong.shading.reference`.
    """
    p, n = columns(points), unit(columns(normals))[0]
    v, to_light = _to_viewer(p, equation), term.light.arrival(p).direction
    if equation.two_sided:
        n = np.where(dot(n, equation.toward_viewer(v)) < 0.0, -n, n)
    peak = equation.reflectance.peak
    assert peak is not None, "only reflectances with a peak are sharp"
    return np.stack(np.broadcast_arrays(*peak.chord(n, to_light, v)), axis=1)


# Nearer to a corner than this, a peak is at it.
_AT_CORNER = 2.0**-20


def _peaks(vertices: LitVertices, corners: IntArray) -> Iterator[Places]:
    """Where every light's share is largest, in triangles that do not have it at a corner.

    There a vector that varies over the triangle is shortest: the chord D for a highlight, the offset from a spot's
    axis, the offset from a light at a position.
    """
    equation, at = vertices.lighting.equation, _AtCorners(vertices, corners)
    for term in equation.terms:
        light, p, offsets = term.light, at.points, []
        for place in light.places:
            offsets.append(p - np.array(place))
        for direction in light.values(Aim) if light.values(Power) else ():
            axis, from_light = unit_vector(direction), p - np.array(light.places[0])
            offsets.append(from_light - np.outer(from_light @ axis, axis))
        found = []
        for each in offsets:
            at_corners = at.of(each)
            rows = np.flatnonzero(~_is_at_corner(at_corners))
            found.append(Places(rows, _shortest(at_corners[rows])))
        if equation.sharpness > 0.0 and equation.has(term, "specular"):
            found.append(_highlight_peaks(term, equation, at))
        for rows, weights in found:
            inside = _largest(weights) < 1.0 - _AT_CORNER
            yield Places(rows[inside], weights[inside])


# Step, in barycentric coordinates, of the differences by which a highlight's chord is followed.
_STEP = 2.0**-12

# Each turn squares the distance to a highlight's peak.
_TURNS = 5

# Half of n |D|² beyond which a highlight of shininess n is below 1e-9.
_INVISIBLE = 21.0


def _highlight_peaks(term: LightTerm, equation: Equation, at: _AtCorners) -> Places:
    """Peaks by Gauss-Newton steps, in triangles that are large against the highlight; others have a fixed pattern.

    A chord's length bends by less than a quarter of the square of its spread over the triangle, so that
    triangles too far from the highlight are passed over.
    """
    sharpness = equation.sharpness
    chords = _chords(term, equation, at.points, at.normals)
    spread = _largest(_difference(at.of(chords), at.of(chords)[:, [1, 2, 0]]))
    rows = np.flatnonzero(~(spread * math.sqrt(sharpness) <= 1.0))
    at_corners, spread = at.of(chords)[rows], spread[rows]
    weights = _shortest(at_corners)
    nearest = np.linalg.norm(_blend(weights, at_corners), axis=1) - spread**2 / 4.0
    is_near = nearest < math.sqrt(2.0 * _INVISIBLE / sharpness)
    rows, weights = rows[is_near], weights[is_near]
    p, n = at.of(at.points)[rows], at.of(at.normals)[rows]
    for _ in range(_TURNS):  # shortest is the linear expansion of the chord about the last place
        here = _chords(term, equation, _blend(weights, p), _blend(weights, n))
        expanded = np.empty_like(p)
        for corner in range(3):
            aside = (1.0 - _STEP) * weights
            aside[:, corner] += _STEP
            there = _chords(term, equation, _blend(aside, p), _blend(aside, n))
            expanded[:, corner] = here + (there - here) / _STEP
        weights = _shortest(expanded)
    return Places(rows, weights)


def _blend(weights: Float64Array, at_corners: Float64Array) -> Float64Array:
    return np.einsum("ki,kij->kj", weights, at_corners)


def _shortest(at_corners: Float64Array) -> Float64Array:
    """Barycentric coordinates (k, 3) of the shortest among the blends of three vectors (k, 3, 3).

    The nearest point of a triangle to the origin: the foot of the perpendicular if it lies inside, else the
    nearest of the three sides' nearest points (C. Ericson: Real-Time Collision Detection (2005), section 5.1.5).
    """
    a, b, c = at_corners.transpose(1, 2, 0)
    ab, ac = b - a, c - a
    # The normal equations of |a + s ab + t ac| -> min.
    g11, g12, g22 = dot(ab, ab), dot(ab, ac), dot(ac, ac)
    h1, h2 = -dot(a, ab), -dot(a, ac)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        determinant = g11 * g22 - g12 * g12
        s, t = (g22 * h1 - g12 * h2) / determinant, (g11 * h2 - g12 * h1) / determinant
        r = 1.0 - s - t
    result = np.stack([r, s, t], axis=1)
    outside = np.flatnonzero(~((r >= 0.0) & (s >= 0.0) & (t >= 0.0)))  # a NaN is outside
    on_sides, lengths = np.zeros((3, len(outside), 3)), np.empty((3, len(outside)))
    for side in range(3):
        p, q = at_corners[outside, side], at_corners[outside, (side + 1) % 3]
        pq = q - p
        square = np.einsum("ki,ki->k", pq, pq)
        along = np.clip(np.einsum("ki,ki->k", -p, pq) / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
        on_sides[side, :, side], on_sides[side, :, (side + 1) % 3] = 1.0 - along, along
        lengths[side] = np.linalg.norm(p + along[:, None] * pq, axis=1)
    result[outside] = on_sides[lengths.argmin(axis=0), np.arange(len(outside))]
    return result


def _is_at_corner(at_corners: Float64Array) -> BoolArray:
    """Which of the shortest blends of three vectors (k, 3, 3) are one of them: that from which all sides rise."""
    a, b, c = at_corners.transpose(1, 2, 0)
    ab, bc, ca = b - a, c - b, a - c
    at_a = (dot(a, ab) >= 0.0) & (dot(a, ca) <= 0.0)
    at_b = (dot(b, bc) >= 0.0) & (dot(b, ab) <= 0.0)
    at_c = (dot(c, ca) >= 0.0) & (dot(c, bc) <= 0.0)
    return np.asarray(at_a | at_b | at_c)


# From this shininess on, a highlight has no bend where its cosine reaches zero.
_SMOOTH = 2.0


def _creases(vertices: LitVertices, corners: IntArray) -> Iterator[Places]:
    """Where triangles cross a crease of the lighting, where some value changes its sign.

    It is n·l where a light's dark side begins, n·v (or n along the view axis) where a two-sided surface turns, a
    spot's angle at the edge of its cone, a highlight's cosine where it is cut off, a colour less 1 where it saturates.
    """
    equation, at = vertices.lighting.equation, _AtCorners(vertices, corners)
    p, n = at.p, at.n
    toward = equation.toward_viewer(_to_viewer(p, equation))
    values: list[FloatArray] = [dot(n, toward)] if equation.two_sided else []
    for term in equation.terms:
        to_light = term.light.arrival(p).direction
        if term.needs_normals:
            values.append(dot(n, to_light))  # with the normal's length: so it is linear under a distant light
        if term.light.values(Aim) and term.light.values(Angle):
            values.append(_inside_cone(term.light, p))
        if equation.has(term, "specular") and 0.0 < equation.sharpness < _SMOOTH:
            chord = _chords(term, equation, at.points, at.normals)
            values.append(1.0 - np.einsum("ki,ki->k", chord, chord) / 2.0)
    if vertices.lighting.scene.light_model.clamp:
        values += [channel - 1.0 for channel in at.colors.T]
    for value in values:
        yield from _sign_changes(at.of(np.broadcast_to(value, len(at.points))))


# How far beside a crease, in parts of a side, a jump's two sides are looked at.
_ASIDE = 2.0**-5


def _sign_changes(values: FloatArray) -> Iterator[Places]:
    """Where a value changes its sign in triangles: on two sides, half-way between, and a little beside each.

    Parameters
    ----------
    values : ndarray
        Shape (m, 3): at each triangle's corners, and linear between.
    """
    above = values > 0.0
    a, b, c = above.T
    rows = np.flatnonzero((a != b) | (b != c))
    rows = rows[np.isfinite(values[rows]).all(axis=1)]
    values, above = values[rows], above[rows]
    alone = odd_corner(above)
    turn = (alone[:, None] + np.arange(3)) % 3
    values = np.take_along_axis(values, turn, axis=1)
    crossing = values[:, :1] / (values[:, :1] - values[:, 1:])
    for aside in (0.0, -_ASIDE, _ASIDE):
        along = np.clip(crossing + aside, 0.0, 1.0)
        ends = np.zeros((2, len(rows), 3))
        for end in range(2):
            np.put_along_axis(ends[end], turn[:, :1], 1.0 - along[:, end : end + 1], axis=1)
            np.put_along_axis(ends[end], turn[:, end + 1 : end + 2], along[:, end : end + 1], axis=1)
        for weights in (*ends, ends.mean(axis=0)):
            yield Places(rows, weights)


# --- the errors


def lattice(order: int) -> Float64Array:
    """Barycentric coordinates (s, 3) in multiples of 1/order, without the corners."""
    steps = [(i, j, order - i - j) for i in range(order + 1) for j in range(order + 1 - i)]
    return np.array([step for step in steps if max(step) < order]) / order


_FIRST = np.concatenate([lattice(2), np.full((1, 3), 1.0 / 3.0)])
_MORE = np.array([weights for weights in lattice(4) if (weights * 2.0 % 1.0).any()])
_ALL = np.concatenate([_FIRST, _MORE])
DENSE = lattice(8)
"""So dense that hardly anything lies between them."""

# Over a triangle, the ratio of a normal's two lengths may vary by this much and change no colour.
_SAME_RATIO = 1e-4

# Halvings of a distance after which a difference that is still there is a jump.
_HALVINGS = 20

# An error from which on triangles are searched for jumps.
_LARGE = 1.0 / 255.0


def first_errors(vertices: LitVertices, corners: IntArray) -> Float64Array:
    """Largest error (m,) of triangles (m, 3) at middles of sides, centroids, and where colours peak, bend or jump."""
    result = pattern_errors(_FIRST, vertices, corners)

    def look(part: slice) -> None:
        there = vertices, corners[part]
        rows, _, errors = _worst(chain(_peaks(*there), _creases(*there)), *there)
        result[part][rows] = np.maximum(result[part][rows], errors)

    _in_parts(look, len(corners), 8)
    return result


def more_errors(vertices: LitVertices, corners: IntArray) -> Float64Array:
    """Largest error (m,) at further samples, and with the stored normals blended."""
    result = pattern_errors(_MORE, vertices, corners)
    length, stored = (np.linalg.norm(normals, axis=1) for normals in (vertices.normals, vertices.stored))
    ratio = np.divide(length, stored, out=np.ones_like(length), where=stored > 0.0)[corners]
    most = _largest(ratio)
    rows = np.flatnonzero(most + _largest(-ratio) > _SAME_RATIO * most)  # they blend differently
    others = vertices.as_stored, corners[rows]
    errors = np.maximum(first_errors(*others), pattern_errors(_MORE, *others))
    result[rows] = np.maximum(result[rows], errors)
    return result


def all_errors(vertices: LitVertices, corners: IntArray) -> Float64Array:
    """Largest error (m,) at every sample; 0 in triangles without an area, or with a point that is not finite."""
    result = np.zeros(len(corners))
    rows = np.flatnonzero(sizes(vertices.points[corners])[1] > 0.0)
    shown = corners[rows]
    errors = np.maximum(first_errors(vertices, shown), more_errors(vertices, shown))
    large = np.flatnonzero(errors >= _LARGE)
    _, beside_jumps = jumps(vertices, shown[large])
    errors[large] = np.maximum(errors[large], beside_jumps)
    result[rows] = errors
    return result


def jumps(vertices: LitVertices, corners: IntArray) -> tuple[Float64Array, Float64Array]:
    """The largest step of the colour in each triangle, which no splitting would cure, and the error beside it: (m,).

    The search goes from the worst sample, peaks left out, to the corner whose colour differs most from it: to the half
    that keeps more of the difference, again and again. What is left of the difference is a jump.
    """
    steps, errors = np.zeros((2, len(corners)))

    def look(part: slice) -> None:
        some = corners[part]
        at_samples = _errors_at(vertices, some, _ALL)
        near = _ALL[at_samples.argmax(axis=1)]
        rows, weights, at_creases = _worst(_creases(vertices, some), vertices, some)
        is_worse = at_creases > at_samples.max(axis=1)[rows]
        near[rows[is_worse]] = weights[is_worse]
        near_color = _lit_inside(vertices, some, near[:, None])[0][:, 0]
        at_corners = vertices.lighting.shown(vertices.colors[some])
        corner = _difference(at_corners, near_color[:, None]).argmax(axis=1)
        far, far_color = np.eye(3)[corner], at_corners[np.arange(len(some)), corner]
        for _ in range(_HALVINGS):
            middle = (near + far) / 2.0
            color = _lit_inside(vertices, some, middle[:, None])[0][:, 0]
            near_half = (_difference(color, near_color) >= _difference(color, far_color))[:, None]
            far, far_color = np.where(near_half, middle, far), np.where(near_half, color, far_color)
            near, near_color = np.where(near_half, near, middle), np.where(near_half, near_color, color)
        steps[part] = _difference(far_color, near_color)
        if vertices.lighting.soft:
            noise = _lit_inside(vertices, some, np.stack([near, far], axis=1))[1].sum(axis=1)
            steps[part] = np.maximum(steps[part] - _SURE * noise, 0.0)
        errors[part] = _errors_at(vertices, some, np.stack([near, far], axis=1)).max(axis=1)

    _in_parts(look, len(corners), len(_ALL))
    return steps, errors


def pattern_errors(pattern: Float64Array, vertices: LitVertices, corners: IntArray) -> Float64Array:
    """Largest error (m,) at places (s, 3) that are the same for all triangles."""
    result = np.zeros(len(corners))

    def look(part: slice) -> None:
        result[part] = _largest(_errors_at(vertices, corners[part], pattern))

    _in_parts(look, len(corners), len(pattern))
    return result


def _worst(
    places: Iterable[Places], vertices: LitVertices, corners: IntArray
) -> tuple[IntArray, Float64Array, Float64Array]:
    """The triangles (k,) that have any of the places, with the place (k, 3) of the largest error in each, and that."""
    places = list(places)
    rows = np.concatenate([np.empty(0, dtype=np.intp), *(place.rows for place in places)])
    weights = np.concatenate([np.empty((0, 3)), *(place.weights for place in places)])
    errors = _errors_at(vertices, corners[rows], weights[:, None])[:, 0]
    order = np.lexsort([errors, rows])
    last = order[np.diff(rows[order], append=-1) != 0]  # of each row
    return rows[last], weights[last], errors[last]


def _in_parts(look: Callable[[slice], None], triangles: int, samples: int) -> None:
    """Look at so many triangles with so many samples each, part after part, on all cores."""
    ignored = np.geterr()  # a thread begins with its own

    def work(first: int, last: int) -> None:
        with np.errstate(**ignored):
            look(slice(first, last))

    threads.run(work, triangles, _SAMPLES // samples)
