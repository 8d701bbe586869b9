"""Path tracing of the rendering equation at the vertices of a mesh.

The colour of a point x seen along v is (J. Kajiya, "The rendering equation", 1986)

    B(x, v) = emission + ∫ L(x, l) · Σ color · factor(l, v) dl / π

over unit vectors l. L is the arriving light: from the lights, or the colour B(y, −l) of the first hit y. The factors of
the reflectance's lobes include the cosine. So with lights alone, the result equals the evaluators' colours. The
constant ambient light is excluded, because it stands for bounced light.

At each point of a path, rays go to all lights that cast shadows: to point-like lights, and to one random point of each
other light. Nothing blocks a light that casts no shadows, so no ray goes to it. One direction, in which the path
continues, is sampled from the reflectance. If the path hits an area light, this gives a second estimate of the light.
The power heuristic weights both estimates (E. Veach and L. Guibas, "Optimally combining sampling techniques for Monte
Carlo rendering", 1995). From the third bounce on, Russian roulette ends paths, mostly paths of low weight (J. Arvo and
D. Kirk, "Particle transport and image synthesis", 1990).

Each vertex has its own paths, in independent rounds; the standard error is computed from the rounds' means. Within a
round, the first direction and the samples on lights are points of the Sobol sequence.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pvphong.base import check, sobol, threads
from pvphong.base.formulas import BRIGHTEST
from pvphong.base.types import Float64Array, FloatArray, IntArray, Vector
from pvphong.base.vectors import cross, dot, towards, unit
from pvphong.optics.directions import Directions, around, mixed
from pvphong.optics.light import Arrival
from pvphong.optics.surface import Surface
from pvphong.rays.casting import BlockingFaces, Occluders
from pvphong.rays.rays import BEFORE_LIGHT, Receiver, rays_to
from pvphong.shading.equation import Equation, LightTerm
from pvphong.shading.reference import lobe_factors, tint_of

MOST_SAMPLES, LEAST_SAMPLES = 2**16, 16
"""Largest number of paths per vertex, a power of two; and the least number, which is one path in each round."""

# Approximate number of rays of a path.
_RAYS_OF_PATH = 4
# First bounce with Russian roulette, and the least and greatest probability of survival. With a smaller probability,
# survivors could be so rare that the standard error misses them.
_BOUNCES_FOR_SURE, _LEAST_LIKELY, _MOST_LIKELY = 3, 0.25, 0.95
# Least fraction of directions sampled by the cosine, and least fraction by the highlight; number of directions by which
# the best fractions are estimated.
_LEAST_SHARE, _TRIED = 0.125, 64


# --- reflecting surfaces


@dataclass(frozen=True, eq=False)
class Reflector:
    """Mesh whose surface reflects light.

    Parameters
    ----------
    faces : BlockingFaces
        Points and triangles of the mesh, in the world.
    equation : Equation
        Equation of the scene and the mesh's material, in the standard convention.
    values : mapping
        Values at the mesh's points, shape (n, k) each, to be interpolated. "normal" are unit vectors in the world.
        "tangents" are present if the reflectance needs them. The equation's maps are present by their names. The tints
        (colours of maps) are "emission", "specular" and "diffuse"; "diffuse" multiplies the lobes that take the albedo.
    """

    faces: BlockingFaces
    equation: Equation
    values: Mapping[str, Float64Array]

    @cached_property
    def _rows(self) -> Float64Array:
        """All values of each point, side by side in one row: shape (n, sum of the columns of all `values`)."""
        return np.concatenate(list(self.values.values()), axis=1, dtype=np.float64)

    @cached_property
    def cosine_share(self) -> float:
        """Fraction of the sampled directions that follow the cosine; the other directions follow the highlight.

        The fraction is the diffuse part of the reflected light for a viewer at 45°, within limits; 1 without a
        highlight.
        """
        reflectance, colors = self.equation.reflectance, self.equation.colors
        across, _, n = np.eye(3)[:, :, None] * np.ones(_TRIED)
        surface = Surface(n, np.ones(_TRIED), math.sqrt(0.5) * (n + across), across)
        u, w = (np.arange(_TRIED) + 0.5) / _TRIED, (np.arange(_TRIED) * 0.618 + 0.5) % 1.0

        def reflected(by: Directions, lobes: Sequence[int]) -> float:
            to_light = by.sample(u, w)
            factors = lobe_factors(reflectance, surface, Arrival(to_light, 1.0), [True] * len(colors))
            total = sum(max(colors[k]) * factors[k] for k in lobes)
            return float((total / np.maximum(math.pi * by.density(to_light), 1e-300)).mean())

        by_highlight = reflectance.directions(surface)
        if by_highlight is None:
            return 1.0
        diffuse = reflected(around(n, 1.0), self.equation.lobes_of["diffuse"])
        specular = reflected(by_highlight, self.equation.lobes_of["specular"])
        if not specular:
            return 1.0
        return min(max(diffuse / (diffuse + specular), _LEAST_SHARE), 1.0 - _LEAST_SHARE)

    def named(self, rows: Float64Array) -> dict[str, Float64Array]:
        """Split rows such as those of `_rows` into values by name, each of shape (number of columns, m)."""
        ends = np.cumsum([value.shape[1] for value in self.values.values()])
        return dict(zip(self.values, np.split(np.ascontiguousarray(rows.T), ends[:-1]), strict=True))

    def at_points(self, points: IntArray) -> dict[str, Float64Array]:
        """Return the values at the m points with the given indices, by name, each of shape (number of columns, m)."""
        return self.named(self._rows[points])

    def between(self, corners: IntArray, weights: Float64Array) -> dict[str, Float64Array]:
        """Return the values at one place in each of m triangles, by name, shape (k, m) each.

        `corners`, shape (m, 3), are the indices of the triangles' points. `weights`, shape (m, 3), are the barycentric
        coordinates of the places.
        """
        a, b, c = (weights[:, k, None] * self._rows[corners[:, k]] for k in range(3))
        return self.named(a + b + c)


class Interaction:
    """Reflection of light at n points of a reflector.

    Parameters
    ----------
    reflector : Reflector
        Surface of the points.
    points : ndarray
        The points, shape (3, n).
    origins : ndarray
        Origins of rays from the points, slightly above the surface, shape (3, n).
    v : ndarray
        Unit vectors to the viewer, shape (3, n); zero for a point at the viewer.
    values : dict
        Values at the points, by name, from `Reflector`. The normals are on the visible side. They are zero where
        nothing is reflected.
    margin : float
        Distance between the end of a ray to a light and the light.
    """

    def __init__(
        self,
        reflector: Reflector,
        points: Float64Array,
        origins: Float64Array,
        v: Float64Array,
        values: dict[str, Float64Array],
        margin: float,
    ) -> None:
        self.equation, self.points, self.origins, self.margin = reflector.equation, points, origins, margin
        self._cosine_share = reflector.cosine_share
        self.normals = values["normal"]
        has_normal, self._has_viewer = ((w != 0.0).any(axis=0) for w in (self.normals, v))
        maps = {name: values[name][0] for name in self.equation.maps}
        self.surface = Surface(self.normals, has_normal.astype(np.float64), v, values.get("tangents"), maps)
        self._lobes = self.equation.reflectance.lobes
        self._tints = [tint_of(lobe, values, self.surface) for lobe in self._lobes]
        self.emission: Float64Array = np.array(self.equation.emission)[:, None] * values.get("emission", 1.0)

    def __len__(self) -> int:
        return self.points.shape[1]

    @cached_property
    def directions(self) -> Directions:
        """Importance sampling of directions: by the cosine, and by the highlight if there is one."""
        by_cosine, share = around(self.normals, 1.0), self._cosine_share
        by_highlight = self.equation.reflectance.directions(self.surface) if share < 1.0 else None
        return by_cosine if by_highlight is None else mixed(by_cosine, by_highlight, share)

    def factors(self, arrival: Arrival) -> tuple[Any, ...]:
        """Return the factor by which each lobe multiplies light that arrives as in `arrival`, shape (n,) each.

        A lobe is a part of the reflection, such as the diffuse part or the highlight.
        """
        wanted = [any(color) for color in self.equation.colors]
        found = lobe_factors(self.equation.reflectance, self.surface, arrival, wanted)
        pairs = zip(self._lobes, found, strict=True)
        return tuple(factor * self._has_viewer if lobe.needs_viewer else factor for lobe, factor in pairs)

    def reflected(self, colors: Sequence[Vector], factors: Sequence[Any]) -> Float64Array:
        """Return the reflected light at each point, shape (3, n).

        It is the sum over the lobes of colour times factor times tint.

        `colors` has a colour for each lobe, and `factors` a number or an array (n,) for each lobe. A lobe is a part of
        the reflection, such as the highlight. A tint is a lobe's colour from a map.
        """
        total = np.zeros(self.points.shape)
        for color, tint, factor in zip(colors, self._tints, factors, strict=True):
            if any(color):
                total += np.array(color)[:, None] * (factor if tint is None else factor * tint)
        return total


class _Sight:
    """One area light, as seen from n points."""

    def __init__(self, term: LightTerm, at: Interaction) -> None:
        sampling = term.light.sampling
        if sampling is None:
            remedy = "Implement `sampling` for path tracing; see pvphong.optics.area.sampling."
            check.refuse("light", term.light, "a light with `sampling`", remedy)
        self._term, self._at, self._sampling = term, at, sampling
        self.is_blocked = term.light.casts_shadows
        """True if surfaces block the light."""
        self._numbers = np.asarray(sampling.numbers, np.float64)
        self._reach, _, *frame = sampling.frame(self._numbers, at.origins, at.normals)
        self._frame = tuple(np.broadcast_to(np.asarray(each, np.float64), len(at)) for each in frame)

    def sample(self, u: Float64Array, v: Float64Array) -> Float64Array:
        """Return unit vectors to random points of the light, shape (3, n).

        `u` and `v`, shape (n,), are the random numbers.
        """
        chosen = self._sampling.sample(self._numbers, self._frame, u, v)[0]
        return np.stack([np.broadcast_to(each, len(self._at)) for each in chosen]).astype(np.float64)

    def arriving(
        self, to_light: Float64Array, factors: Sequence[Any], *, by_chance: bool
    ) -> tuple[Float64Array, Float64Array]:
        """Return an estimate of the light's reflection from each sample, and the distances to the light.

        The estimate is the reflected light times a weight, divided by the density of samples. A direction can be
        sampled in two ways: on the light, and by the surface. The power heuristic gives the weight.

        Parameters
        ----------
        to_light : ndarray
            Unit vectors, shape (3, n), sampled on the light or by the surface.
        factors
            Result of `Interaction.factors` for light from these directions.
        by_chance : bool
            True if the surface sampled the directions, False if they were sampled on the light.

        Returns
        -------
        sent, lengths : ndarray
            Reflected light, shape (3, n), and distances to the light, shape (n,).
        """
        share, density = self._sampling.seen(self._numbers, self._frame, to_light)
        of_surface = self._at.directions.density(to_light)
        own, other = (of_surface, density) if by_chance else (density, of_surface)
        over = own * (1.0 + np.square(other / own)) * math.pi
        arrives = self._term.light.radiance(to_light) * self._term.gain / over
        arrives = np.where((density > 0.0) & np.isfinite(arrives), arrives, 0.0)
        lengths = np.broadcast_to(share * self._reach, len(self._at))
        return self._at.reflected(self._term.colors, factors) * arrives, lengths


# --- random numbers of paths


class _Numbers:
    """Pairs of random numbers in (0, 1) for paths.

    Paths are in the order of vertices, then rounds, then paths of a round.

    Parameters
    ----------
    vertices : ndarray
        Indices of the vertices, shape (n,).
    rounds, points : int
        Number of rounds per vertex, and of paths per round.
    seed : int
        Seed of the random numbers.
    purposes : int
        Number of pairs that a path may need at each of its points.
    """

    def __init__(self, vertices: IntArray, rounds: int, points: int, seed: int, purposes: int) -> None:
        own = _joined(sobol.seeds(vertices, seed))
        self._rounds = np.stack([_joined(sobol.seeds(own, number)) for number in range(rounds)], axis=1)
        self._points, self._purposes = np.arange(points, dtype=np.uint32), purposes
        self._seeds = sobol.seeds((self._rounds[:, :, None] + self._points).ravel())

    def pairs(self, paths: IntArray, bounces: int, purpose: int) -> tuple[Float64Array, Float64Array]:
        """Return a pair of random numbers for each path, as two arrays of shape (number of paths,).

        Before the first bounce, pairs for all paths are returned, and `paths` is ignored. They are points of the Sobol
        sequence, shuffled for each round and purpose.

        Parameters
        ----------
        paths : ndarray of int
            Numbers of the paths.
        bounces : int
            Number of bounces so far.
        purpose : int
            Number of the purpose, less than `purposes`. Pairs for different purposes are independent.
        """
        if bounces:
            number = np.uint32(bounces * self._purposes + purpose)
            u, v = sobol.random(number, self._seeds[0, paths]), sobol.random(number, self._seeds[1, paths])
        else:
            first, second = sobol.seeds(self._rounds, 2 * purpose + 1)[..., None]
            order = sobol.seeds(self._rounds, 2 * purpose + 2)[0, ..., None]
            points = (sobol.coordinate(self._points, order) * np.float32(len(self._points))).astype(np.uint32)
            u, v = sobol.coordinate(points, first).ravel(), sobol.coordinate(sobol.SECOND[points], second).ravel()
        return u + 2.0**-25, v + 2.0**-25  # they have 24 bits


def _joined(pairs: NDArray[np.uint32]) -> NDArray[np.uint64]:
    return pairs[0].astype(np.uint64) << np.uint64(32) | pairs[1]


# --- paths


class _Bundle(NamedTuple):
    """Paths that have reached points of the same reflector."""

    at: Interaction
    paths: IntArray
    """Indices of the paths, shape (n,)."""
    weights: Float64Array
    """Factor that multiplies light on its way from a path's current point to the path's vertex, shape (3, n)."""


class _Rays(NamedTuple):
    """Paths that continue, and the first hits of their rays."""

    paths: IntArray
    weights: Float64Array
    directions: Float64Array
    """Unit vectors, shape (3, n)."""
    triangles: IntArray
    """Indices of the triangles that are hit, shape (n,); −1 for a miss."""
    corners: FloatArray
    """Barycentric weights of the triangles' second and third corners, shape (2, n)."""


@dataclass(frozen=True)
class PathTracer:
    """Traces paths between reflectors.

    Parameters
    ----------
    reflectors : sequence of Reflector
        Reflectors with the same lights. The first parts of the occluders are the reflectors, in the same order. The
        other parts are black.
    occluders : Occluders
        All parts that block light.
    max_bounces : int or None
        Largest number of reflections before light reaches a vertex, not counting the vertex's own; None for no limit.
    samples : int
        Number of paths per vertex, a power of two.
    seed : int
        Seed of the random numbers.
    """

    reflectors: Sequence[Reflector]
    occluders: Occluders
    max_bounces: int | None
    samples: int
    seed: int

    def trace(self, part: int, receiver: Receiver) -> tuple[Float64Array, Float64Array, int]:
        """Trace the paths of one reflector's vertices. Return the vertices' colours as the scene's viewer sees them.

        `part` is the reflector's index, and `receiver` has its vertices. Three results are returned: the unclamped
        colours, their standard errors, and the number of rays. Colours and errors have the shape (n, 3).
        """
        count, terms = len(receiver.points), self.reflectors[part].equation.terms
        rgb, error, rays = np.zeros((count, 3)), np.zeros((count, 3)), list[int]()
        rounds = max(LEAST_SAMPLES, 1 << (self.samples.bit_length() - 1) // 2)
        is_sampled = self.max_bounces != 0 or any(term.light.has_size for term in terms)

        def work(first: int, last: int) -> None:
            vertices = np.arange(first, last)
            with np.errstate(all="ignore"):  # both sides are computed, then one is selected
                at = self._seen_by_viewer(part, receiver, vertices)
                rgb[first:last] = (at.emission + self._of_points(at, rays)).T
                vertices = vertices[np.isfinite(at.points).all(axis=0) & (at.normals != 0.0).any(axis=0)]
                if not is_sampled or not len(vertices):
                    return
                numbers = _Numbers(vertices, rounds, self.samples // rounds, self.seed, len(terms) + 2)
                at = self._seen_by_viewer(part, receiver, np.repeat(vertices, self.samples))
                light = self._along_paths(at, numbers, rays).reshape(3, len(vertices), rounds, -1).mean(axis=3)
            rgb[vertices] += light.mean(axis=2).T
            error[vertices] = light.std(axis=2, ddof=1).T / math.sqrt(rounds)

        threads.run(work, count, max(self.occluders.rays_at_once // (_RAYS_OF_PATH * self.samples), 1))
        return rgb, error, sum(rays)

    def _seen_by_viewer(self, part: int, receiver: Receiver, vertices: IntArray) -> Interaction:
        """Return the reflection of light at some vertices of one reflector, towards the scene's viewer.

        `part` is the reflector's index, and `receiver` has its vertices. `vertices` are indices of some of these.
        """
        reflector, resolution = self.reflectors[part], self.occluders.resolution(part)
        equation, values = reflector.equation, reflector.at_points(vertices)
        points, to_eye = np.ascontiguousarray(receiver.points[vertices].T), np.array(equation.to_eye)[:, None]
        v = np.broadcast_to(to_eye, points.shape) if equation.eye is None else towards(equation.eye, points)[0]
        n, begun = values["normal"], receiver.origins[vertices].T
        if equation.two_sided:
            is_behind = dot(n, equation.toward_viewer(v)) < 0.0
            n, begun = np.where(is_behind, -n, n), np.where(is_behind, receiver.turned.origins[vertices].T, begun)
        origins = np.ascontiguousarray(begun) + resolution * n
        return Interaction(reflector, points, origins, v, values | {"normal": n}, BEFORE_LIGHT * resolution)

    def _along_paths(self, at: Interaction, numbers: _Numbers, rays: list[int]) -> Float64Array:
        """Return the light that each path carries to its first point, shape (3, n). `at` are the first points.

        The emission of the first points, and light from point-like lights there, are not included, because they are not
        random. The numbers of rays that are cast are appended to `rays`.
        """
        light, bounces = np.zeros(at.points.shape), 0
        bundles = [_Bundle(at, np.arange(len(at)), np.ones(at.points.shape))]
        while bundles:
            onward = []
            for bundle in bundles:
                if bounces:
                    light[:, bundle.paths] += bundle.weights * (bundle.at.emission + self._of_points(bundle.at, rays))
                found, leaving = self._scattered(bundle, numbers, bounces, rays)
                light[:, bundle.paths] += bundle.weights * found
                onward.append(leaving)
            if bounces == self.max_bounces:
                break
            bounces += 1
            together = _Rays(*(np.concatenate(parts, axis=-1) for parts in zip(*onward, strict=True)))
            bundles = list(self._met(together, numbers, bounces))
        return light

    def _of_points(self, at: Interaction, rays: list[int]) -> Float64Array:
        """Return the reflection of all lights without a size, at each point, shape (3, n).

        One ray goes from each point to each of these lights that casts shadows. The number of rays is appended to
        `rays`, light by light.
        """
        total = np.zeros(at.points.shape)
        for term in at.equation.terms:
            if not term.light.has_size and term.needs_normals:
                arrival = term.light.arrival(at.points)
                strength = np.minimum(arrival.strength * term.gain, BRIGHTEST)
                sent = at.reflected(term.colors, at.factors(arrival)) * strength
                if term.light.casts_shadows:
                    directions, distances = rays_to(term.light, at.origins.T)
                    sent = self._unblocked(at, sent, directions.T, distances, rays)
                total += sent
        return total

    def _unblocked(
        self, at: Interaction, sent: Float64Array, to_light: Float64Array, lengths: Float64Array, rays: list[int]
    ) -> Float64Array:
        """Return `sent`, the light that each point reflects from one light, with 0 where a ray to the light is blocked.

        `sent` has the shape (3, n). The rays start at the points `at`. They have the directions `to_light`, shape (3,
        n), and the lengths `lengths`, shape (n,), minus the margin. Their number is appended to `rays`.
        """
        rows = np.flatnonzero(sent.any(axis=0))
        blocked = self.occluders.blocked(at.origins[:, rows].T, to_light[:, rows].T, lengths[rows] - at.margin)
        rays.append(len(rows))
        result = np.zeros(sent.shape)
        result[:, rows] = sent[:, rows] * ~blocked
        return result

    def _scattered(
        self, bundle: _Bundle, numbers: _Numbers, bounces: int, rays: list[int]
    ) -> tuple[Float64Array, _Rays]:
        """Return the reflection of all area lights, shape (3, n), and the rays that continue the paths of a bundle.

        Each light is estimated in two ways: by rays to samples on the light, and by the rays that continue the paths.
        `bounces` is the number of bounces so far. The numbers of rays that are cast are appended to `rays`.
        """
        at, paths = bundle.at, bundle.paths
        total = np.zeros(at.points.shape)
        sights = [_Sight(term, at) for term in at.equation.terms if term.light.has_size and term.needs_normals]
        for purpose, sight in enumerate(sights):
            to_light = sight.sample(*numbers.pairs(paths, bounces, purpose + 2))
            sent, lengths = sight.arriving(to_light, at.factors(Arrival(to_light, 1.0)), by_chance=False)
            total += self._unblocked(at, sent, to_light, lengths, rays) if sight.is_blocked else sent
        to_light = at.directions.sample(*numbers.pairs(paths, bounces, 1))
        factors, density = at.factors(Arrival(to_light, 1.0)), at.directions.density(to_light)
        weights = at.reflected(at.equation.colors, factors) / np.where(density > 0.0, math.pi * density, math.inf)
        is_looking = bounces != self.max_bounces or any(sight.is_blocked for sight in sights)
        rows = np.flatnonzero(weights.any(axis=0)) if is_looking else np.zeros(0, np.int64)
        hits = self.occluders.first(at.origins[:, rows].T, to_light[:, rows].T, np.full(len(rows), math.inf))
        rays.append(len(rows))
        for sight in sights:
            sent, lengths = sight.arriving(to_light, factors, by_chance=True)
            if sight.is_blocked:
                total[:, rows] += sent[:, rows] * (hits.distances >= lengths[rows] - at.margin)
            else:
                total += sent
        weights = bundle.weights[:, rows] * weights[:, rows]
        return total, _Rays(paths[rows], weights, to_light[:, rows], hits.triangles, hits.weights.T)

    def _met(self, rays: _Rays, numbers: _Numbers, bounces: int) -> Iterator[_Bundle]:
        """Yield the paths that continue after a hit, as one bundle for each reflector.

        `rays` are the paths' rays with their first hits, and `bounces` is the number of bounces so far. A path ends if
        its ray misses, or hits a back face or an occluder that is no reflector. Russian roulette ends other paths.
        """
        weights, goes_on = rays.weights, rays.triangles >= 0
        if bounces >= _BOUNCES_FOR_SURE:
            chance = np.clip(weights.max(axis=0, initial=0.0), _LEAST_LIKELY, _MOST_LIKELY)
            weights, goes_on = weights / chance, goes_on & (numbers.pairs(rays.paths, bounces, 0)[0] < chance)
        first = 0
        for part, reflector in enumerate(self.reflectors):
            faces, own, two_sided = reflector.faces, rays.triangles - first, reflector.equation.two_sided
            first += len(faces)
            rows = np.flatnonzero(goes_on & (own >= 0) & (own < len(faces)))
            corners, shares, d = faces.corners[own[rows]], rays.corners[:, rows], rays.directions[:, rows]
            a, b, c = (np.ascontiguousarray(faces.points[corners[:, k]].T) for k in range(3))
            values = reflector.between(corners, np.stack([1.0 - shares[0] - shares[1], *shares], axis=1))
            n, across = unit(values["normal"])[0], unit(cross(b - a, c - a))[0]
            facing = -dot(across, d)
            side = np.sign(dot(across, n) * facing)
            seen = np.flatnonzero(side != 0.0 if two_sided else side > 0.0)
            if not len(seen):
                continue
            points, resolution = a + shares[0] * (b - a) + shares[1] * (c - a), self.occluders.resolution(part)
            origins = points + resolution * np.sign(facing) * across
            values |= {"normal": side * n}
            at = Interaction(
                reflector,
                points[:, seen],
                origins[:, seen],
                -d[:, seen],
                {name: value[:, seen] for name, value in values.items()},
                BEFORE_LIGHT * resolution,
            )
            yield _Bundle(at, rays.paths[rows[seen]], weights[:, rows[seen]])
