"""Visibility of a scene's lights and of the sky at the vertices of a mesh.

In order: `Tracer` casts a receiver's rays; `Visibility` stores the results as arrays that can be reused. Before any ray
is cast, `Visibility` tells plans whether anything can block a light or the sky.
"""

from __future__ import annotations

import json
import math
import os
import time
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from pvphong.base import check, documents, sobol, text, threads
from pvphong.base.files import written_aside
from pvphong.base.text import html_table
from pvphong.base.types import BoolArray, Float64Array, FloatArray, IntArray
from pvphong.base.vectors import dot, unit
from pvphong.geometry.extent import Box
from pvphong.optics.area.sampling import Sampling, sky_sampling
from pvphong.optics.light import Light
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.rays.casting import BYTES_PER_TRIANGLE, BlockingFaces, Occluders, warn_of_slow_rays
from pvphong.rays.rays import (
    BEFORE_LIGHT,
    Begun,
    Receiver,
    may_block,
    may_hide,
    part_by_arrays,
    place_of,
    place_or_direction,
    rays_to,
)
from pvphong.rays.sampling import Cast, Seen, look
from pvphong.scene.light_model import LightModel
from pvphong.shading import kernel
from pvphong.shading.visibility import Around

# --- casting a receiver's rays

_VERTICES_AT_ONCE = 2**16
HARD = 0
"""Number of samples that stands for hard shadows: one ray to the centre of each light with a size."""

# Least number of rays per vertex, to a light and to the sky.
_LEAST, _LEAST_OF_ALL_AROUND = 16, 64


@dataclass(frozen=True)
class Tracer:
    """Casts the rays of the vertices of one mesh.

    Parameters
    ----------
    receiver : Receiver
        The mesh's vertices.
    occluders : Occluders
        Parts that can block rays.
    distance : float
        Distance beyond which geometry does not occlude the sky.
    tolerance : float
        Largest standard error of the colours of a white surface.
    samples : int or None
        Fixed number of rays per vertex, in place of the tolerance. With `HARD`, one ray goes to the centre of each
        light, and the least number to the sky.
    ambient : float
        Brightness of the sky. The errors of the sky are multiplied by it before they are compared with the tolerance.
    first : int
        Index of the mesh's first vertex, if the mesh is a piece of a larger mesh. The random numbers depend on it.
    around : Around, optional
        Known bounds on the visibility around the vertices.
    """

    receiver: Receiver
    occluders: Occluders
    distance: float = math.inf
    tolerance: float = 1.0 / 255.0
    samples: int | None = None
    ambient: float = 1.0
    first: int = 0
    around: Around | None = None

    @property
    def turned(self) -> Tracer:
        """Tracer of the rays from the vertices' back sides."""
        return replace(self, receiver=self.receiver.turned)

    def light(self, light: Light, *, behind: bool = False) -> list[Seen]:
        """Return the visibility of a light from the vertices; with `behind`, a second entry is for their back sides.

        A light that casts no shadows is fully visible everywhere. No ray is cast to it.

        Parameters
        ----------
        light : Light
            Light in the world.
        behind : bool, default False
            True to include the back sides.
        """
        if not light.casts_shadows:
            everywhere = np.ones(len(self.receiver.points))
            return [Seen(everywhere, np.zeros_like(everywhere), 0)] * (1 + behind)
        if not light.has_size:
            return self._all_or_nothing_of(light, behind=behind)
        if self.samples == HARD and not light.is_uniform:
            center = light.nodes(1)[0]
            return [seen for tracer in (self, *[self.turned] * behind) for seen in tracer._all_or_nothing_of(center)]
        return [tracer._part_of(light) for tracer in (self, *[self.turned] * behind)]

    def _origins(self, rows: Any) -> Float64Array:
        """Return the origins of the rays of the vertices `rows`, raised above the tangent planes by the resolution."""
        return self.receiver.above(rows, self.occluders.resolution(self.receiver.part))

    def _all_or_nothing_of(self, light: Light, *, behind: bool = False) -> list[Seen]:
        """Return the visibility of a light without a size, by one ray from the side of each vertex that faces the
        light.

        The result has an entry for the front sides and, with `behind`, one for the back sides. A side that faces away
        sees nothing of the light.
        """
        receiver, compiled = self.receiver, self.occluders.compiled
        count, above = len(receiver.points), self.occluders.resolution(receiver.part)
        sides = [self, *[self.turned] * behind]
        parts, rays = np.zeros((len(sides), count)), list[int]()
        begin = [side.receiver.origins for side in sides]
        place = place_of(light)
        if place is None and not light.is_uniform:  # its direction varies between vertices
            compiled = None
        known = *place_or_direction(light).tolist(), float(place is not None), float(behind), above
        numbers = np.array([*known, BEFORE_LIGHT * above])

        def work(first: int, last: int) -> None:
            some = slice(first, last)
            if compiled is not None:
                vertices = receiver.points[some], begin[0][some], begin[-1][some], receiver.unit_normals[some]
                rays.append(kernel.point_seen(*vertices, numbers, compiled, parts[0, some], parts[-1, some]))
                return
            for side, part in zip(sides, parts, strict=True):
                rows = first + side._facing(light, some)
                origins = side._origins(rows)
                directions, distances = rays_to(light, origins)
                part[rows] = ~self.occluders.blocked(origins, directions, distances - numbers[-1])
                rays.append(len(rows))

        threads.run(work, count, _VERTICES_AT_ONCE)
        cast = sum(rays) * bool(self.occluders.casters)
        return [Seen(part, np.zeros(count), cast * (index == 0)) for index, part in enumerate(parts)]

    def _facing(self, light: Light, some: slice) -> IntArray:
        """Return the vertices of the slice `some` that face a light, as indices from the start of the slice."""
        normals, points = self.receiver.unit_normals[some], self.receiver.points[some]
        with np.errstate(all="ignore"):
            return np.flatnonzero(dot(normals.T, light.arrival(np.ascontiguousarray(points.T)).direction) > 0.0)

    def _part_of(self, light: Light) -> Seen:
        """Return the visible part of an area light, by adaptive sampling.

        Each point of the light is weighted with its contribution to the vertex.
        """
        if light.sampling is None:
            remedy = "Implement `sampling` to cast shadows; see pvphong.optics.area.sampling."
            check.refuse("light", light, "a light with `sampling`", remedy)
        margin = BEFORE_LIGHT * self.occluders.resolution(self.receiver.part)
        brightness = light.intensity * max(np.ravel(light.diffuse).tolist())
        seen = self._look(light.sampling, margin, brightness, _LEAST_OF_ALL_AROUND if light.is_all_around else _LEAST)
        return seen if light.is_uniform else self._with_slivers(seen, light, margin)

    def _with_slivers(self, seen: Seen, light: Any, margin: float) -> Seen:
        """Return `seen`, completed by one more ray from each vertex to which no sample of an area light contributed.

        Such a vertex may have the light just above its horizon. The ray goes to the light's highest point, and ends
        `margin` before this point.
        """
        if seen.is_unknown is None or not (light.places or light.outline is not None):
            return seen
        rows = np.flatnonzero(seen.is_unknown)
        points, normals, origins = self.receiver.points[rows], self.receiver.unit_normals[rows], self._origins(rows)
        with np.errstate(all="ignore"):  # for vertices that are not finite
            if light.outline is None:  # a sphere, or a kind without an outline
                highest = np.array(light.places[0]) + getattr(light, "radius", 0.0) * normals
            else:
                highest = light.outline[(normals @ light.outline.T).argmax(axis=1)]
            to_light = highest - origins
            sent = light.arrival(np.ascontiguousarray(points.T)).strength  # 0 from a dark back
            is_risen = (dot(normals.T, to_light.T) > 0.0) & (sent > 0.0)
        rows, origins = rows[is_risen], origins[is_risen]
        directions, distances = unit(np.ascontiguousarray(to_light[is_risen].T))
        part = seen.part.copy()
        part[rows] = ~self.occluders.blocked(origins, directions.T, distances - margin)
        return seen._replace(part=part, rays=seen.rays + len(rows) * bool(self.occluders.casters))

    def sky(self) -> Seen:
        """Return the visible part of the sky in the hemisphere around each vertex's normal; 1 without a normal."""
        seen = self._look(sky_sampling(self.distance, 1.0), 0.0, self.ambient, _LEAST_OF_ALL_AROUND)
        has_normal: BoolArray = (self.receiver.unit_normals != 0.0).any(axis=1)
        return seen._replace(part=np.where(has_normal, seen.part, 1.0))

    def _look(self, sampling: Sampling, margin: float, brightness: float, least: int) -> Seen:
        compiled, numbers = self.occluders.compiled, np.asarray(sampling.numbers, np.float64)
        stages = None if compiled is None else kernel.stages_of(sampling)

        def cast(vertices: IntArray, begin: int, end: int) -> Cast:
            origins, normals = self._origins(vertices), self.receiver.unit_normals[vertices]
            given = numbers, origins, normals, sobol.seeds(self.first + vertices), begin, end, margin
            if stages is not None:
                return Cast(*kernel.part_seen(stages, *given, compiled))
            return Cast(*part_by_arrays(sampling, *given, self.occluders))

        samples = least if self.samples == HARD else self.samples
        options: Any = {"tolerance": self.tolerance, "samples": samples, "brightness": brightness, "least": least}
        options |= {"rays_at_once": self.occluders.rays_at_once, "around": self.around}
        return look(len(self.receiver.points), cast, self.receiver.faces.corners, **options)


# --- stored results

# Least number of triangles for which the repr includes the memory of their casters.
_MANY = 2_000_000
# Least number of vertices for a warning about VTK's slow rays.
_WORTH_A_WARNING = 2**15


_FORMAT, _VERSION = "pvphong visibility", 1
# Fields of a tracer that files store.
_NUMBERS = "distance", "tolerance", "samples", "ambient", "first"

# Number of faces that are sampled to estimate the cost of all rays.
_PROBED = 256


class Cost(NamedTuple):
    """Estimated cost of rays.

    `rays` is their number, and `seconds` the time that they take.
    """

    rays: int
    seconds: float


class StandardError(NamedTuple):
    """Standard errors of sampled values. They are 0 where one ray is exact."""

    per_light: FloatArray
    """Standard errors of lights, shape (lights, n)."""
    sky: FloatArray
    """Standard errors of the sky, shape (n,)."""


class Visibility:
    """Visibility of each light and of the sky at every vertex of a mesh, as arrays that can be reused.

    Each array is computed when it is first read, and stored; an interrupted computation stores nothing. Lights may then
    change in brightness and colour, be switched on and off, or stop casting shadows, without new rays. If a light has
    moved, or casts shadows now but cast none before, lighting with this visibility raises an error.

    Vertices see the side to which their normals point. With a two-sided light model, `behind` is the visibility from
    the back side. A viewer sees one of these two sides of a vertex.

    Parameters
    ----------
    tracer : Tracer
        Object that casts the rays.
    lights : sequence of Light
        Lights of the scene, in the world, including those that are off.
    labels : sequence of str
        Names of the lights.
    two_sided : bool, default False
        True to include `behind`.
    memory : tuple of ndarray, optional
        Two float32 arrays of shape (lights + 1, n), for the visible parts and for their standard errors; if
        `two_sided`, they have twice as many rows. Parts that are not computed yet must be 1, and their errors 0.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> seen = pv.Sphere().phong.visibility(ph.DirectionalLight())
    >>> seen.per_light.shape
    (1, 842)
    """

    def __init__(
        self,
        tracer: Tracer,
        lights: Sequence[Light],
        labels: Sequence[str],
        *,
        two_sided: bool = False,
        memory: tuple[FloatArray, FloatArray] | None = None,
    ) -> None:
        self._tracer, self._receiver, self._lights = tracer, tracer.receiver, tuple(lights)
        self.lights = tuple(labels)
        """Names of the lights, in the order of `per_light`."""
        rows, count = len(self.lights) + 1, len(self._receiver.points)
        if memory is None:  # both sides in one array, for the evaluators
            shape = rows * (1 + two_sided), count
            memory = np.ones(shape, np.float32), np.zeros(shape, np.float32)
        self._of_all_sides, (self._parts, self._errors) = memory[0], (each[:rows] for each in memory)
        self.behind: Visibility | None = None
        """Visibility from the other sides of the vertices, in the same arrays; None if the light model is one-sided."""
        if two_sided:
            other, errors = (each[rows:] for each in memory)
            self.behind = Visibility(tracer.turned, lights, labels, memory=(other, errors))
        self._done: dict[int, int | None] = {}  # row → `Tracer.samples` of its rays
        self._rays, self._seconds = 0, 0.0

    @property
    def _sides(self) -> tuple[Visibility, ...]:
        return (self,) if self.behind is None else (self, self.behind)

    @property
    def rays(self) -> int:
        """Number of rays cast so far, from both sides."""
        return sum(side._rays for side in self._sides)

    @property
    def seconds(self) -> float:
        """Time that the rays took."""
        return sum(side._seconds for side in self._sides)

    def __repr__(self) -> str:
        seen = f"{len(self.lights)} lights from {self._parts.shape[1]} vertices"
        count = sum(self._tracer.occluders.counts)
        memory = count * BYTES_PER_TRIANGLE / 1e9
        much = f"; {count:,} occluding triangles take about {memory:.2g} GB" if count >= _MANY else ""
        return f"<Visibility of {seen}: {self.rays} rays in {self.seconds:.3g} s{much}>"

    def _repr_html_(self) -> str:
        """Return a table of the results so far, without casting rays."""
        rows = []
        for side, where in zip(self._sides, ("", ", from behind"), strict=False):
            for row, name in enumerate((*self.lights, "the sky")):
                part, error = "not computed yet", ""
                if row in side._done:
                    part = f"{side._parts[row].mean(dtype=np.float64):.3f}"
                    error = f"{side._errors[row].max(initial=0.0):.4f}"
                rows.append((name + where, part, error))
        return html_table(repr(self)[1:-1], ("seen", "mean part", "largest standard error"), rows)

    @property
    def per_light(self) -> FloatArray:
        """Visible part of each light at each vertex, in [0, 1], shape (lights, n), float32.

        The value is 0 if a vertex faces away from the light. The part of an area light is weighted with its
        contribution. For a light that casts no shadows, the value is 1 everywhere.
        """
        return self.channels(range(len(self.lights)), sky=False)[:-1]

    @property
    def sky(self) -> FloatArray:
        """Unoccluded part of the hemisphere around each normal, in [0, 1], shape (n,), float32.

        The hemisphere is weighted with the cosine; the result is 1 where there is no normal.
        """
        return self.channels((), sky=True)[-1]

    @property
    def standard_error(self) -> StandardError:
        """Standard errors of the arrays `per_light` and `sky`, which are computed if they are missing."""
        self.channels(range(len(self.lights)), sky=True)
        return StandardError(self._errors[:-1], self._errors[-1])

    @property
    def blocking(self) -> tuple[Occluders, int | None]:
        """The occluders, and the index of the mesh's own faces among their parts. The index is None if these faces
        block nothing.
        """
        return self._tracer.occluders, self._receiver.part

    def expected_cost(self) -> Cost:
        """Estimate the cost of all results that are not computed yet, by casting rays from some of the vertices.

        This builds the casters, which takes about a second for three million triangles.
        """
        corners, count = self._receiver.faces.corners, len(self._receiver.points)
        picked = corners if len(corners) else np.arange(count)
        rows = np.unique(picked[:: max(len(picked) // _PROBED, 1)])
        probe = self.afresh(samples=self._tracer.samples, rows=rows)
        for mine, its in zip(self._sides, probe._sides, strict=True):
            for done in mine._done:
                its._keep(done, mine._parts[done, rows], mine._errors[done, rows], mine._done[done])
        self._receiver.origins, self._tracer.occluders.casters  # noqa: B018  so that their time is not counted
        probe.channels(range(len(self.lights)), sky=True, behind=self.behind is not None)
        share = count / max(len(rows), 1)
        return Cost(round(probe.rays * share), probe.seconds * share)

    def for_lights(self, lights: Sequence[Light], labels: Sequence[str], samples: int | None = None) -> Visibility:
        """Return the visibility for other lights. Results of lights that have not moved are kept.

        Parameters
        ----------
        lights, labels
            Lights in the world, and their names.
        samples : int, optional
            Number of rays per vertex for results that are not computed yet. By default, the error of each vertex sets
            the number.
        """
        tracer, two_sided = replace(self._tracer, samples=samples), self.behind is not None
        result = Visibility(tracer, lights, labels, two_sided=two_sided)
        before = {geometry: index for index, geometry in enumerate(self.geometry)}
        places = [(index, before.get(geometry)) for index, geometry in enumerate(result.geometry)]
        places.append((len(result._lights), len(self._lights)))  # the sky
        for mine, its in zip(self._sides, result._sides, strict=True):
            for index, place in places:
                if place in mine._done and (not result._is_sampled(index) or mine._done[place] in (None, samples)):
                    its._keep(index, mine._parts[place], mine._errors[place], mine._done[place])
        return result

    @cached_property
    def geometry(self) -> tuple[str, ...]:
        """A key for each light. It changes with everything on which rays to the light depend."""
        return tuple(_geometry_of(light) for light in self._lights)

    def _is_sampled(self, row: int) -> bool:
        """Return True if several rays per vertex are needed: for a light with a size, or the sky.

        `row` is the light's index.
        """
        return row == len(self._lights) or self._lights[row].has_size

    def is_final(self, lights: Sequence[int], *, sky: bool, behind: bool = False) -> bool:
        """Return True if no rays are missing to the lights with these indices and, with `sky`, to the sky.

        With `behind`, this must hold for both sides of the vertices.
        """
        rows, sides = (*lights, *[len(self._lights)] * sky), self._sides if behind else (self,)
        return all(row in s._done and (s._done[row] is None or not s._is_sampled(row)) for s in sides for row in rows)

    def afresh(self, *, samples: int | None = None, rows: IntArray | None = None) -> Visibility:
        """Return a copy without results. The copy shares the occluders, which take time to prepare.

        Parameters
        ----------
        samples : int, optional
            Number of rays per vertex. By default, the error of each vertex sets the number.
        rows : ndarray, optional
            Vertices to keep, with the faces between them, shape (m,). Adaptive sampling may then cast more rays per
            vertex.
        """
        receiver = self._receiver if rows is None else self._receiver.some(rows)
        tracer, two_sided = replace(self._tracer, receiver=receiver, samples=samples), self.behind is not None
        return Visibility(tracer, self._lights, self.lights, two_sided=two_sided)

    def part(self, row: int) -> tuple[FloatArray, FloatArray]:
        """Return the visible part of one light, and its standard error, shape (n,) each.

        `row` is the light's index; the row after the last light is the sky.
        """
        is_sky = row == len(self.lights)
        return self.channels(() if is_sky else (row,), sky=is_sky)[row], self._errors[row]

    def at(
        self,
        points: Float64Array,
        normals: FloatArray,
        origins: Float64Array,
        around: Around | None = None,
    ) -> Visibility:
        """Return the visibility of the same lights, with the same occluders, at other points of the mesh.

        Parameters
        ----------
        points, normals, origins : ndarray
            Shape (n, 3), in the world. Rays start at the origins, raised along the normals by `Occluders.resolution`,
            the smallest length that the ray caster resolves.
        around : Around, optional
            Known bounds on the visibility around the points.
        """
        nowhere = BlockingFaces(points, np.zeros((0, 3), np.int64))
        begun = Begun(origins, np.zeros(len(origins)))
        receiver = Receiver(nowhere, lambda: normals, self._receiver.part, lambda: begun)
        return Visibility(replace(self._tracer, receiver=receiver, around=around), self._lights, self.lights)

    # -- files and pickling

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle both sides in one array, with all that is needed to compute missing results later."""
        return _restored, (self._state,)

    @property
    def _state(self) -> _State:
        errors = np.concatenate([side._errors for side in self._sides])
        done = tuple(sorted(side._done) for side in self._sides)
        lights = self._tracer, self._lights, self.lights
        return _State(*lights, done, self._of_all_sides, errors, self.rays, self.seconds)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Save the results so far to a file in NumPy's format .npz, without casting rays.

        The file includes the inputs of missing results, which are computed after loading when they are first read. The
        file also includes the occluding triangles, about 36 bytes each.

        Raises
        ------
        ValueError
            If the file cannot be written, or files do not support a kind of light.
        """
        with_lights = [documents.with_type(f"lights[{k}]", light, LIGHT_TYPES) for k, light in enumerate(self._lights)]
        state, tracer, receiver = self._state, self._tracer, self._receiver
        header = {
            "lights": with_lights,
            "labels": self.lights,
            "done": state.done,
            "part": receiver.part,
            "cast": [state.rays, state.seconds],
            "parts": len(tracer.occluders.parts),
            "within": tracer.occluders.within,
            **{name: getattr(tracer, name) for name in _NUMBERS},
        }
        described = json.dumps(header, default=lambda given: np.asarray(given).tolist())
        faces = [*tracer.occluders.parts, *[receiver.faces] * (receiver.part is None)]
        arrays = {
            "format": np.array([_FORMAT, str(_VERSION), described]),
            "seen": state.seen,
            "errors": state.errors,
            "normals": receiver.unit_normals,
            **receiver.begun._asdict(),
            **{f"points_{index}": np.asarray(each.points) for index, each in enumerate(faces)},
            **{f"corners_{index}": each.corners for index, each in enumerate(faces)},
        }
        with written_aside(path) as aside, aside.open("wb") as file:
            np.savez(file, **arrays)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Visibility:
        """Load a file written by `save`.

        Raises
        ------
        ValueError
            If the file cannot be read, has another format or version, or is damaged.
        """
        allowed = "a file written by Visibility.save"
        try:
            with open(path, "rb") as opened, np.load(opened, allow_pickle=False) as file:
                arrays = {name: file[name] for name in file.files}
                kind = arrays.pop("format").tolist()
            if len(kind) != 3 or kind[0] != _FORMAT or kind[1] != str(_VERSION):
                raise ValueError(f"its format is {' '.join(map(str, kind[:2]))}")
            return _restored(_state_of(json.loads(kind[2]), arrays))
        except (OSError, ValueError, KeyError, TypeError, IndexError, EOFError, zipfile.BadZipFile) as error:
            remedy = "Recompute the visibility with mesh.phong.visibility(scene)."
            check.refuse("path", os.fspath(path), allowed, f"{type(error).__name__}: {error}. {remedy}")

    def _keep(self, row: int, part: FloatArray, error: FloatArray, samples: int | None) -> None:
        self._parts[row], self._errors[row] = part, error
        self._done[row] = samples

    def channels(self, lights: Sequence[int], *, sky: bool, behind: bool = False) -> FloatArray:
        """Return the visibility as an array of shape (lights + 1, n): the rows of `per_light`, then the row `sky`.

        Missing rows are computed for the lights with the indices `lights` and, with `sky`, for the sky. Other rows may
        be missing. With `behind`, rows for the vertices' back sides follow in the same order.
        """
        if behind and self.behind is None:
            self._refuse_one_side()
        for index in (*lights, *[len(self.lights)] * sky):
            if index not in self._done:
                start, is_sky = time.perf_counter(), index == len(self.lights)
                if is_sky or self._lights[index].casts_shadows:
                    self._receiver.origins, self._tracer.occluders.casters  # noqa: B018  threads will share them
                    if len(self._receiver.points) >= _WORTH_A_WARNING and self._tracer.occluders.are_slow:
                        warn_of_slow_rays()
                with text.about(f"rays to {'the sky' if is_sky else self.lights[index]}"):
                    # for a light without a size, one ray gives the visibility from both sides
                    both = self.behind is not None and not is_sky and not self._lights[index].has_size
                    tracer = self._tracer
                    found = [tracer.sky()] if is_sky else tracer.light(self._lights[index], behind=both)
                for side, seen in zip(self._sides, found, strict=False):
                    side._keep(index, seen.part, seen.error, self._tracer.samples)
                    side._rays += seen.rays
                self._seconds += time.perf_counter() - start
        if behind and self.behind is not None:
            self.behind.channels(lights, sky=sky)
        result = (self._of_all_sides if behind else self._parts).view()
        result.flags.writeable = False
        return result

    def why_clear(self, light: int) -> str:
        """Return the reason why nothing can block a light; "" if something may."""
        seen_from = self._receiver.extent.box
        return self._why_nothing(lambda parts: may_block(self._lights[light], seen_from, parts), "stands between")

    def why_open(self) -> str:
        """Return the reason why nothing can occlude the sky; "" if something may."""
        seen_from, distance = self._receiver.extent.box, self._tracer.distance
        nothing = "is around it" if math.isinf(distance) else "is near enough"
        return self._why_nothing(lambda parts: may_hide(seen_from, parts, distance), nothing)

    def _why_nothing(self, may_count: Callable[[Box], BoolArray], nothing: str) -> str:
        own, boxes = self._receiver.part, [part.box for part in self._tracer.occluders.parts]
        others = [box for index, box in enumerate(boxes) if box and index != own]
        if others:
            low, high = np.transpose(others, (1, 0, 2))
            if may_count((low, high)).any():
                return ""
        if own is None or boxes[own] is None:
            return f"nothing {nothing}"
        if self.behind is not None or not self._receiver.is_convex:
            return ""
        return f"nothing {nothing}, and the mesh is convex" if others else "the mesh is convex, and alone"

    def _refuse_one_side(self) -> None:
        remedy = "Recompute it with mesh.phong.visibility(scene)."
        check.refuse("visibility", "one for a one-sided model", "computed for a two-sided light model", remedy)

    def refuse_other(
        self, points: FloatArray, lights: Sequence[Light], labels: Sequence[str], model: LightModel
    ) -> None:
        """Raise ValueError if this visibility was computed for other points, other lights or another light model.

        The arguments are in world coordinates. `labels` are the lights' names in messages.
        """
        if len(points) != self._parts.shape[1]:
            check.refuse(
                "visibility", f"one for {self._parts.shape[1]} points", f"computed for the mesh's {len(points)} points"
            )
        remedy = "Recompute it with mesh.phong.visibility(scene)."
        if tuple(labels) != self.lights:
            check.refuse(
                "visibility", f"one for the lights {self.lights}", f"computed for the lights {tuple(labels)}", remedy
            )
        if not np.array_equal(points, self._receiver.points, equal_nan=True):
            check.refuse("visibility", "one for other points", "computed for the mesh's current points", remedy)
        for label, now, then in zip(labels, lights, self._lights, strict=True):
            if now.casts_shadows and _geometry_of(now) != _geometry_of(then):  # other lights are not looked up
                got = f"one from before {label} {'moved or changed size' if then.casts_shadows else 'cast shadows'}"
                check.refuse("visibility", got, "computed for the current lights", remedy)
        if model.two_sided and self.behind is None:
            self._refuse_one_side()
        if model.ambient_occlusion is not False and model.occlusion_distance != self._tracer.distance:
            got = f"one with occlusion up to {self._tracer.distance:g}"
            check.refuse("visibility", got, f"computed with occlusion up to {model.occlusion_distance:g}", remedy)


class _State(NamedTuple):
    """State of a visibility for pickling. `done` has, for each side of the vertices, the rows that are computed."""

    tracer: Tracer
    lights: tuple[Light, ...]
    labels: tuple[str, ...]
    done: tuple[list[int], ...]
    seen: FloatArray
    errors: FloatArray
    rays: int
    seconds: float


def _restored(state: _State) -> Visibility:
    """Restore a visibility from its state."""
    memory, two_sided = (state.seen, state.errors), len(state.done) == 2
    result = Visibility(state.tracer, state.lights, state.labels, two_sided=two_sided, memory=memory)
    for side, done in zip(result._sides, state.done, strict=True):
        side._done.update(dict.fromkeys(done, state.tracer.samples))
    result._rays, result._seconds = state.rays, state.seconds
    return result


def _state_of(header: dict[str, Any], arrays: dict[str, Any]) -> _State:
    """Return the state that a file stores as a header and arrays; raise ValueError if the file is damaged."""
    labels, sides = tuple(map(str, header["labels"])), tuple(sorted(map(int, done)) for done in header["done"])
    lights = tuple(
        documents.value_of_type(f"lights[{k}]", entry, LIGHT_TYPES) for k, entry in enumerate(header["lights"])
    )
    part, parts = header["part"], int(header["parts"])
    faces = [BlockingFaces(arrays[f"points_{k}"], arrays[f"corners_{k}"]) for k in range(parts + (part is None))]
    own = faces[parts if part is None else int(part)]
    count, rows = len(own.points), len(labels) + 1
    shapes = {"seen": (len(sides) * rows, count), "errors": (len(sides) * rows, count), "rise": (count,)}
    shapes |= dict.fromkeys(("normals", "origins"), (count, 3))
    is_sound = (
        len(lights) == len(labels)
        and len(sides) in (1, 2)
        and all(set(done) <= set(range(rows)) for done in sides)
        and all(arrays[name].shape == shape and arrays[name].dtype.kind == "f" for name, shape in shapes.items())
        and all(each.is_well_formed for each in faces)
    )
    if not is_sound:
        raise ValueError("the file is damaged")
    begun = Begun(arrays["origins"], arrays["rise"])
    receiver = Receiver(own, partial(np.asarray, arrays["normals"]), part, lambda: begun)
    within = None if header["within"] is None else (np.array(header["within"][0]), np.array(header["within"][1]))
    tracer = Tracer(receiver, Occluders(faces[:parts], within), **{name: header[name] for name in _NUMBERS})
    seen, errors = (np.array(arrays[name], np.float32) for name in ("seen", "errors"))
    return _State(tracer, lights, labels, sides, seen, errors, *header["cast"])


def _geometry_of(light: Light) -> str:
    """Return a key that is equal for lights with the same rays: their nodes, or none if they cast no shadows."""
    nodes = light.nodes(4) if light.casts_shadows else ()
    places = [(place_or_direction(node).tolist(), light.has_size and node.intensity) for node in nodes]
    return repr((places, light.is_uniform))
