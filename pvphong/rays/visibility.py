"""What the vertices of a mesh see of a scene's lights and of the sky.

In order: `Tracer` casts a receiver's rays; `Visibility` keeps what they found, as arrays to shade with again, and
answers what a plan asks before any ray is cast.
"""

from __future__ import annotations

import json
import math
import os
import time
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
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

# --- casting a receiver's rays

_VERTICES_AT_ONCE = 2**16
# So many rays every vertex gets.
_LEAST, _LEAST_OF_ALL_AROUND = 16, 64


@dataclass(frozen=True)
class Tracer:
    """Casts the rays of the vertices of one mesh.

    Parameters
    ----------
    receiver : Receiver
        Whose vertices look.
    occluders : Occluders
        What can block them.
    distance : float
        Up to where something hides the sky.
    tolerance : float
        Largest standard error of the colours of a white surface.
    samples : int or None
        So many rays for each vertex in place of that.
    ambient : float
        The sky's brightness, which that tolerance counts with.
    first : int
        Number of the first vertex, by which its rays are chosen: where it is a piece of a larger mesh.
    """

    receiver: Receiver
    occluders: Occluders
    distance: float = math.inf
    tolerance: float = 1.0 / 255.0
    samples: int | None = None
    ambient: float = 1.0
    first: int = 0

    @property
    def turned(self) -> Tracer:
        """That of the vertices' other sides."""
        return replace(self, receiver=self.receiver.turned)

    def light(self, light: Light, *, behind: bool = False) -> list[Seen]:
        """What the vertices see of a light in the world, and then what their other sides see of it.

        Parameters
        ----------
        light : Light
            In the world.
        behind : bool, default False
            Whether the latter is found too.
        """
        if not light.has_size:
            return self._all_or_nothing_of(light, behind=behind)
        return [tracer._part_of(light) for tracer in (self, *[self.turned] * behind)]

    def _origins(self, rows: Any) -> Float64Array:
        """Where rays begin at some vertices."""
        return self.receiver.above(rows, self.occluders.resolution(self.receiver.part))

    def _all_or_nothing_of(self, light: Light, *, behind: bool) -> list[Seen]:
        """A light without a size: one ray for each vertex, from the side that faces it."""
        receiver, compiled = self.receiver, self.occluders.compiled
        count, above = len(receiver.points), self.occluders.resolution(receiver.part)
        sides = [self, *[self.turned] * behind]
        parts, rays = np.zeros((len(sides), count)), list[int]()
        begin = [side.receiver.origins for side in sides]
        place = place_of(light)
        if place is None and not light.is_even:  # its direction differs from vertex to vertex
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
        """Which of some vertices face a light."""
        normals, points = self.receiver.unit_normals[some], self.receiver.points[some]
        with np.errstate(all="ignore"):
            return np.flatnonzero(dot(normals.T, light.arrival(np.ascontiguousarray(points.T)).direction) > 0.0)

    def _part_of(self, light: Light) -> Seen:
        """A light with a size: as many rays as it takes, weighted with what its points send."""
        if light.sampling is None:
            remedy = "A kind with `sampling` casts shadows; pvphong.optics.area.sampling says how."
            check.refuse("light", light, "one that says how rays to it are chosen", remedy)
        margin = BEFORE_LIGHT * self.occluders.resolution(self.receiver.part)
        brightness = light.intensity * max(np.ravel(light.diffuse).tolist())
        seen = self._look(light.sampling, margin, brightness, _LEAST_OF_ALL_AROUND if light.is_even else _LEAST)
        return seen if light.is_even else self._with_slivers(seen, light, margin)

    def _with_slivers(self, seen: Seen, light: Any, margin: float) -> Seen:
        """Where no ray has found a light that just rises above the horizon, one to its highest point decides."""
        if seen.is_unknown is None or not (light.places or light.outline is not None):
            return seen
        rows = np.flatnonzero(seen.is_unknown)
        points, normals, origins = self.receiver.points[rows], self.receiver.unit_normals[rows], self._origins(rows)
        with np.errstate(all="ignore"):  # of vertices that are not finite
            if light.outline is None:  # a sphere, or a kind of which no edge is known
                highest = np.array(light.places[0]) + getattr(light, "radius", 0.0) * normals
            else:
                highest = light.outline[(normals @ light.outline.T).argmax(axis=1)]
            to_light = highest - origins
            sent = light.arrival(np.ascontiguousarray(points.T)).strength  # nothing from a back that is dark
            is_risen = (dot(normals.T, to_light.T) > 0.0) & (sent > 0.0)
        rows, origins = rows[is_risen], origins[is_risen]
        directions, distances = unit(np.ascontiguousarray(to_light[is_risen].T))
        part = seen.part.copy()
        part[rows] = ~self.occluders.blocked(origins, directions.T, distances - margin)
        return seen._replace(part=part, rays=seen.rays + len(rows) * bool(self.occluders.casters))

    def sky(self) -> Seen:
        """What the vertices see of the hemispheres around their normals."""
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

        options: Any = {"tolerance": self.tolerance, "samples": self.samples, "brightness": brightness, "least": least}
        count, triangles = len(self.receiver.points), self.receiver.faces.corners
        return look(count, cast, triangles, rays_at_once=self.occluders.rays_at_once, **options)


# --- what they found, kept

# From so many triangles on the representation says what memory their rays take.
_MANY = 2_000_000
# From so many vertices on VTK's rays are worth a warning.
_WORTH_A_WARNING = 2**15


_FORMAT, _VERSION = "pvphong visibility", 1
# A tracer's, in files.
_NUMBERS = "distance", "tolerance", "samples", "ambient", "first"

# So many faces are picked to find out what rays from all vertices will take.
_PROBED = 256


class Cost(NamedTuple):
    """What rays take."""

    rays: int
    seconds: float


class StandardError(NamedTuple):
    """Standard errors of what was sampled; 0 where one ray is exact."""

    per_light: FloatArray
    """Shape (lights, n)."""
    sky: FloatArray
    """Shape (n,)."""


class Visibility:
    """What every vertex of a mesh sees of each light, and of the sky: arrays to keep, and to shade with again.

    Each is computed when it is first read, and kept; nothing is kept of one that is interrupted. Lights may then be
    dimmed, tinted and switched without a ray; one that has moved is refused.

    Vertices see what is on the side to which their normals point. Of a two-sided light model `behind` is what they see
    on the other side; wherever the viewer is, one of the two is what the side sees that he sees.

    Parameters
    ----------
    tracer : Tracer
        Casts the rays.
    lights : sequence of Light
        The scene's, in the world, those that are off too.
    labels : sequence of str
        Their names.
    two_sided : bool, default False
        Whether there is `behind`.
    memory : tuple of ndarray, optional
        Two of shape (lights + 1, n), float32, for parts, all 1, and their errors, all 0.

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
        if memory is None:  # both sides in one array, as evaluators read them
            shape = rows * (1 + two_sided), count
            memory = np.ones(shape, np.float32), np.zeros(shape, np.float32)
        self._of_all_sides, (self._parts, self._errors) = memory[0], (each[:rows] for each in memory)
        self.behind: Visibility | None = None
        """What the other sides of the vertices see, in the same arrays; None where the light model is one-sided."""
        if two_sided:
            other, errors = (each[rows:] for each in memory)
            self.behind = Visibility(tracer.turned, lights, labels, memory=(other, errors))
        self._done: set[int] = set()
        self._rays, self._seconds = 0, 0.0

    @property
    def _sides(self) -> tuple[Visibility, ...]:
        return (self,) if self.behind is None else (self, self.behind)

    @property
    def rays(self) -> int:
        """How many rays have been cast, from both sides."""
        return sum(side._rays for side in self._sides)

    @property
    def seconds(self) -> float:
        """How long that took."""
        return sum(side._seconds for side in self._sides)

    def __repr__(self) -> str:
        seen = f"{len(self.lights)} lights from {self._parts.shape[1]} vertices"
        count = sum(self._tracer.occluders.counts)
        memory = count * BYTES_PER_TRIANGLE / 1e9
        much = f"; {count:,} triangles that block light take about {memory:.2g} GB" if count >= _MANY else ""
        return f"<Visibility of {seen}: {self.rays} rays in {self.seconds:.3g} s{much}>"

    def _repr_html_(self) -> str:
        """Showing it casts no ray."""
        rows = []
        for side, where in zip(self._sides, ("", ", from behind"), strict=False):
            for row, name in enumerate((*self.lights, "the sky")):
                part, error = "not asked for yet", ""
                if row in side._done:
                    part = f"{side._parts[row].mean(dtype=np.float64):.3f}"
                    error = f"{side._errors[row].max(initial=0.0):.4f}"
                rows.append((name + where, part, error))
        return html_table(repr(self)[1:-1], ("seen", "mean part", "largest standard error"), rows)

    @property
    def per_light(self) -> FloatArray:
        """Shape (lights, n), float32, in [0, 1]: the part of each light that reaches each vertex.

        0 where a vertex faces away from it; the part of a light that has a size is weighted with what it sends.
        """
        return self.channels(range(len(self.lights)), sky=False)[:-1]

    @property
    def sky(self) -> FloatArray:
        """Shape (n,), float32, in [0, 1]: the open part of the hemisphere around the normal.

        Each part of it is weighted with the cosine; 1 where there is no normal.
        """
        return self.channels((), sky=True)[-1]

    @property
    def standard_error(self) -> StandardError:
        """The standard errors of `per_light` and `sky`."""
        self.channels(range(len(self.lights)), sky=True)
        return StandardError(self._errors[:-1], self._errors[-1])

    @property
    def blocking(self) -> tuple[Occluders, int | None]:
        """What can block the rays, and which part of it the mesh's own faces are, if they are one."""
        return self._tracer.occluders, self._receiver.part

    def expected_cost(self) -> Cost:
        """What all that is not computed yet will take, by rays from some vertices; roughly.

        Building what rays are tested with, which takes about a second for three million triangles, is done here.
        """
        corners, count = self._receiver.faces.corners, len(self._receiver.points)
        picked = corners if len(corners) else np.arange(count)
        rows = np.unique(picked[:: max(len(picked) // _PROBED, 1)])
        probe = self.afresh(samples=self._tracer.samples, rows=rows)
        for mine, its in zip(self._sides, probe._sides, strict=True):
            for done in mine._done:
                its._keep(done, mine._parts[done, rows], mine._errors[done, rows])
        self._receiver.origins, self._tracer.occluders.casters  # noqa: B018  they are not to be counted
        probe.channels(range(len(self.lights)), sky=True, behind=self.behind is not None)
        share = count / max(len(rows), 1)
        return Cost(round(probe.rays * share), probe.seconds * share)

    def for_lights(self, lights: Sequence[Light], labels: Sequence[str], samples: int | None = None) -> Visibility:
        """The same vertices, for a scene's lights now: what is known of those that have not moved is kept.

        Parameters
        ----------
        lights, labels
            As for the class.
        samples : int, optional
            Of what is not known yet.
        """
        tracer, two_sided = replace(self._tracer, samples=samples), self.behind is not None
        result = Visibility(tracer, lights, labels, two_sided=two_sided)
        is_as_good = self._tracer.samples in (None, samples)
        before = {_geometry_of(light): index for index, light in enumerate(self._lights)}
        places = [(index, before.get(_geometry_of(light))) for index, light in enumerate(result._lights)]
        for mine, its in zip(self._sides, result._sides, strict=True):
            for index, place in places:
                if place in mine._done and (is_as_good or not result._lights[index].has_size):
                    its._keep(index, mine._parts[place], mine._errors[place])
            if len(self._lights) in mine._done and is_as_good:
                its._keep(len(result._lights), mine._parts[-1], mine._errors[-1])
        return result

    def afresh(self, *, samples: int | None = None, rows: IntArray | None = None) -> Visibility:
        """A copy with nothing known yet; the occluders, which take time to prepare, are shared.

        Parameters
        ----------
        samples : int, optional
            As for the tracer.
        rows : ndarray, optional
            Shape (m,): of these vertices alone, and the faces between them, so that adaptive rays may be more.
        """
        receiver = self._receiver if rows is None else self._receiver.some(rows)
        tracer, two_sided = replace(self._tracer, receiver=receiver, samples=samples), self.behind is not None
        return Visibility(tracer, self._lights, self.lights, two_sided=two_sided)

    def part(self, row: int) -> tuple[FloatArray, FloatArray]:
        """The part that is seen of a light, or in the row after theirs of the sky, and its standard error, (n,)."""
        is_sky = row == len(self.lights)
        return self.channels(() if is_sky else (row,), sky=is_sky)[row], self._errors[row]

    def at(self, points: Float64Array, normals: FloatArray, origins: Float64Array) -> Visibility:
        """What is seen of the same lights, past the same occluders, from other places on the mesh.

        Parameters
        ----------
        points, normals, origins : ndarray
            Shape (n, 3), in the world; rays begin at the origins, above them by the resolution of the triangles.
        """
        nowhere = BlockingFaces(points, np.zeros((0, 3), np.int64))
        begun = Begun(origins, np.zeros(len(origins)))
        receiver = Receiver(nowhere, lambda: normals, self._receiver.part, lambda: begun)
        return Visibility(replace(self._tracer, receiver=receiver), self._lights, self.lights)

    # -- files, and other processes

    def __reduce__(self) -> tuple[Any, ...]:
        """Both sides in one array again; what is not known yet is cast there, past the same triangles."""
        return _restored, (self._state,)

    @property
    def _state(self) -> _State:
        errors = np.concatenate([side._errors for side in self._sides])
        done = tuple(sorted(side._done) for side in self._sides)
        lights = self._tracer, self._lights, self.lights
        return _State(*lights, done, self._of_all_sides, errors, self.rays, self.seconds)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write it to a file, by NumPy's format .npz: what is known, and all that rays are cast by.

        So what is not known yet can be asked for when it is read again; no ray is cast now. The triangles that block
        light are in the file, about 36 bytes for each.

        Raises
        ------
        ValueError
            If the file cannot be written, or a light is of a kind that files do not know.
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
        """What `save` has written.

        Raises
        ------
        ValueError
            If the file cannot be read, is none of such, is damaged, or of another version.
        """
        allowed = "a file that Visibility.save has written"
        try:
            with open(path, "rb") as opened, np.load(opened, allow_pickle=False) as file:
                arrays = {name: file[name] for name in file.files}
                kind = arrays.pop("format").tolist()
            if len(kind) != 3 or kind[0] != _FORMAT or kind[1] != str(_VERSION):
                raise ValueError(f"it is {' '.join(map(str, kind[:2]))}")
            return _restored(_state_of(json.loads(kind[2]), arrays))
        except (OSError, ValueError, KeyError, TypeError, IndexError, EOFError, zipfile.BadZipFile) as error:
            remedy = "mesh.phong.visibility(scene) makes a new one."
            check.refuse("path", os.fspath(path), allowed, f"{type(error).__name__}: {error}. {remedy}")

    def _keep(self, row: int, part: FloatArray, error: FloatArray) -> None:
        self._parts[row], self._errors[row] = part, error
        self._done.add(row)

    def channels(self, lights: Sequence[int], *, sky: bool, behind: bool = False) -> FloatArray:
        """Shape (lights + 1, n): `per_light` with `sky` in the last row; other rows may not be computed yet.

        If `behind` is asked for too, as many rows follow of it.
        """
        if behind and self.behind is None:
            self._refuse_one_side()
        for index in (*lights, *[len(self.lights)] * sky):
            if index not in self._done:
                start, is_sky = time.perf_counter(), index == len(self.lights)
                self._receiver.origins, self._tracer.occluders.casters  # noqa: B018  found now: threads share them
                if len(self._receiver.points) >= _WORTH_A_WARNING and self._tracer.occluders.are_slow:
                    warn_of_slow_rays()
                with text.about(f"rays to {'the sky' if is_sky else self.lights[index]}"):
                    # one ray tells what both sides see of a light without a size
                    both = self.behind is not None and not is_sky and not self._lights[index].has_size
                    tracer = self._tracer
                    found = [tracer.sky()] if is_sky else tracer.light(self._lights[index], behind=both)
                for side, seen in zip(self._sides, found, strict=False):
                    side._keep(index, seen.part, seen.error)
                    side._rays += seen.rays
                self._seconds += time.perf_counter() - start
        if behind and self.behind is not None:
            self.behind.channels(lights, sky=sky)
        result = (self._of_all_sides if behind else self._parts).view()
        result.flags.writeable = False
        return result

    def why_clear(self, light: int) -> str:
        """Why nothing can block a light; "" where something may."""
        seen_from = self._receiver.extent.box
        return self._why_nothing(lambda parts: may_block(self._lights[light], seen_from, parts), "stands between")

    def why_open(self) -> str:
        """Why nothing can hide the sky; "" where something may."""
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
        remedy = "mesh.phong.visibility(scene) makes one."
        check.refuse("visibility", "one of a one-sided light model", "one of a two-sided one", remedy)

    def refuse_other(
        self, points: FloatArray, lights: Sequence[Light], labels: Sequence[str], model: LightModel
    ) -> None:
        """Raise ValueError if it is not of these vertices in the world, of these lights, or of such a light model."""
        if len(points) != self._parts.shape[1]:
            check.refuse("visibility", f"one of {self._parts.shape[1]} vertices", f"one of the mesh's {len(points)}")
        remedy = "mesh.phong.visibility(scene) makes one."
        if tuple(labels) != self.lights:
            check.refuse("visibility", f"one of the lights {self.lights}", f"one of {tuple(labels)}", remedy)
        if not np.array_equal(points, self._receiver.points, equal_nan=True):
            check.refuse("visibility", "one of other points", "one of the mesh where it is now", remedy)
        for label, now, then in zip(labels, lights, self._lights, strict=True):
            if _geometry_of(now) != _geometry_of(then):
                check.refuse("visibility", f"one from before {label} moved", "one of the lights where they are", remedy)
        if model.two_sided and self.behind is None:
            self._refuse_one_side()
        if model.ambient_occlusion is not False and model.occlusion_distance != self._tracer.distance:
            got = f"one with occlusion up to {self._tracer.distance:g}"
            check.refuse("visibility", got, f"one up to {model.occlusion_distance:g}", remedy)


class _State(NamedTuple):
    """What a visibility is made of again; of both sides, as `done` has an entry for each."""

    tracer: Tracer
    lights: tuple[Light, ...]
    labels: tuple[str, ...]
    done: tuple[list[int], ...]
    seen: FloatArray
    errors: FloatArray
    rays: int
    seconds: float


def _restored(state: _State) -> Visibility:
    """The visibility of a state."""
    memory, two_sided = (state.seen, state.errors), len(state.done) == 2
    result = Visibility(state.tracer, state.lights, state.labels, two_sided=two_sided, memory=memory)
    for side, done in zip(result._sides, state.done, strict=True):
        side._done.update(done)
    result._rays, result._seconds = state.rays, state.seconds
    return result


def _state_of(header: dict[str, Any], arrays: dict[str, Any]) -> _State:
    """The state in a file; an exception if it is damaged."""
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
        and all(map(_is_sound, faces))
    )
    if not is_sound:
        raise ValueError("it is damaged")
    begun = Begun(arrays["origins"], arrays["rise"])
    receiver = Receiver(own, partial(np.asarray, arrays["normals"]), part, lambda: begun)
    within = None if header["within"] is None else (np.array(header["within"][0]), np.array(header["within"][1]))
    tracer = Tracer(receiver, Occluders(faces[:parts], within), **{name: header[name] for name in _NUMBERS})
    seen, errors = (np.array(arrays[name], np.float32) for name in ("seen", "errors"))
    return _State(tracer, lights, labels, sides, seen, errors, *header["cast"])


def _is_sound(faces: BlockingFaces) -> bool:
    """Whether its corners are numbers of its points."""
    points, corners = faces.points, faces.corners
    has_shapes = points.ndim == 2 and points.shape[1] == 3 and corners.ndim == 2 and corners.shape[1] == 3
    is_typed = points.dtype.kind == "f" and corners.dtype == np.int64
    return has_shapes and is_typed and (not corners.size or 0 <= corners.min() <= corners.max() < len(points))


def _geometry_of(light: Light) -> str:
    """What rays to a light depend on: its place, direction, size and parts."""
    nodes = [(place_or_direction(node).tolist(), light.has_size and node.intensity) for node in light.nodes(4)]
    return repr((nodes, light.is_even))
