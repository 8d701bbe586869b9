"""Columns of the least-squares problem: the colours that a light gives for one unit of each unknown.

The unknowns of a light are its intensity, or the channels of its colours. A column is the result of the lighting
equation with a single light. The evaluators and the plan are those of `mesh.phong.shade`. Colours are in float64 and
not clamped.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv

from pvphong.base import threads
from pvphong.base.types import Backend, Float64Array, FloatArray, IntArray, MatrixLike
from pvphong.geometry.transform import transform_points
from pvphong.meshes.visibility import triangles_of
from pvphong.optics.light import Light
from pvphong.optics.material import Material
from pvphong.rays.transport import Transport
from pvphong.rays.visibility import Tracer
from pvphong.scene.scene import Scene
from pvphong.shading import interreflection
from pvphong.shading.equation import BLACK, Equation, relative_to_mesh
from pvphong.shading.interreflection import Radiosity
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices
from pvphong.shading.visibility import GivenVisibility, VisibilityLike
from pvphong.studies.fitting.variation import Variation

# Number of triangles that a thread measures at once: their arrays stay in its caches.
_FACES_AT_ONCE = 2**14


def point_areas(source: pv.PolyData, matrix: MatrixLike | None) -> Float64Array:
    """Return the area of each point of a surface, shape (n,): a third of its triangles' area, in the world.

    The areas are in an arbitrary unit. For a surface without faces, each area is 1. Triangles with a corner that is not
    finite do not count. `matrix` is the model matrix, or None.
    """
    corners = triangles_of(source).astype(np.intp)
    if not len(corners):
        return np.ones(source.n_points)
    points = np.asarray(source.points, np.float64) if matrix is None else transform_points(source.points, matrix)
    scale = float(np.abs(points).max(initial=0.0, where=np.isfinite(points))) or 1.0  # squares must not overflow
    axes, numbers, areas = (
        np.ascontiguousarray(points.T) / scale,
        np.ascontiguousarray(corners.T),
        np.empty(len(corners)),
    )

    def measure(begin: int, end: int) -> None:
        first, second, third = numbers[:, begin:end]
        with np.errstate(all="ignore"):
            starts = [np.take(each, first) for each in axes]
            a, b, c = (
                (np.take(each, second) - start, np.take(each, third) - start)
                for each, start in zip(axes, starts, strict=True)
            )
            square = sum(np.square(u[0] * v[1] - u[1] * v[0]) for u, v in ((a, b), (b, c), (c, a)))
            areas[begin:end] = np.sqrt(square)

    threads.run(measure, len(corners), _FACES_AT_ONCE)
    areas[~np.isfinite(areas)] = 0.0
    found = sum(np.bincount(each, areas, source.n_points) for each in numbers)
    return np.asarray(found, np.float64)


@dataclass(frozen=True, eq=False)
class Subject:
    """One surface that is lit: its vertices, its material, and the tracer of its rays."""

    vertices: Vertices
    material: Material
    tracer: Tracer | None
    """Object that casts the rays of shadows and ambient occlusion. None if the light model has neither, or `seen` is
    given."""
    seen: VisibilityLike | None = None
    """Visibility that the user passed; None to cast rays."""
    matrix: MatrixLike | None = None
    """Model matrix."""

    def __len__(self) -> int:
        return len(self.vertices)

    def at(self, rows: IntArray) -> Subject:
        """Return the surface reduced to the vertices `rows` (indices).

        The result casts rays and has no given visibility.
        """
        whole = self.vertices
        maps = {name: values.rows[rows] for name, values in whole.maps.items()}
        tangents = functools.cache(lambda: whole.tangents[rows])
        some = Vertices(whole.points[rows], whole.normals[rows], maps, tangents=tangents, ranges=whole.ranges)
        tracer = None if self.tracer is None else replace(self.tracer, receiver=self.tracer.receiver.some(rows))
        return Subject(some, self.material, tracer, None, self.matrix)

    def equation(self, scene: Scene) -> Equation:
        """Return the lighting equation of the surface in a scene."""
        return self.vertices.equation(scene, self.material, self.matrix)

    @functools.cached_property
    def sky(self) -> FloatArray:
        """Visible fraction of the sky at each vertex."""
        assert self.tracer is not None
        return self.tracer.sky().part

    @functools.cached_property
    def sky_behind(self) -> FloatArray:
        """Visible fraction of the sky at each vertex, from the vertex's back side."""
        assert self.tracer is not None
        return self.tracer.turned.sky().part

    def light_seen(self, light: Light, *, behind: bool) -> list[FloatArray]:
        """Return the visible fraction of `light`, in world coordinates, for each vertex.

        If `behind` is true, a second array follows for the vertices' back sides.
        """
        assert self.tracer is not None
        return [seen.part for seen in self.tracer.light(light, behind=behind)]


Seen = list[VisibilityLike | None]
"""Visibility from each surface; None without shadows and occlusion."""


class Share(NamedTuple):
    """One light's share of the colours of n points: `offset` plus each column times its unknown."""

    columns: list[Float64Array]
    """Colours (n, 3) per unit of each unknown. Three unknowns, the channels of one colour, have one column in common.
    """
    offset: Float64Array | None
    """Colours (n, 3) that do not depend on the unknowns; None if there are none."""
    seen: Seen
    """Visibility of the light, which can be reused for small changes of the light."""


@dataclass(frozen=True, eq=False)
class Columns:
    """Evaluates the colours that lights of a scene give to the vertices of some surfaces.

    Parameters
    ----------
    subjects : sequence of Subject
        The surfaces.
    scene : Scene
        The scene, with a viewer.
    transport : Transport or None
        Transport of light between all surfaces, if light bounces.
    backend : {"auto", "numpy", "numba"}
        Evaluator: compiled code, NumPy, or a choice between them.
    expected : int
        Expected number of evaluations, for "auto".
    """

    subjects: Sequence[Subject]
    scene: Scene
    transport: Transport | None = None
    backend: Backend = "auto"
    expected: int = 1
    _known: dict[tuple[int, str], list[Equation]] = field(default_factory=dict)

    def __len__(self) -> int:
        return sum(map(len, self.subjects))

    def at(self, rows: IntArray) -> Columns:
        """Return the evaluator for the vertices `rows` only, without bounces.

        `rows` are indices of vertices, counted through all surfaces in order.
        """
        ends = np.cumsum([len(each) for each in self.subjects])
        parts = [
            each.at(rows[(rows >= end - len(each)) & (rows < end)] - (end - len(each)))
            for each, end in zip(self.subjects, ends.tolist(), strict=True)
        ]
        model = replace(self.scene.light_model, bounces=0)
        return Columns(parts, replace(self.scene, light_model=model), None, self.backend, self.expected)

    def base(self, varied: Sequence[Variation]) -> Float64Array:
        """Return the colours (n, 3) without the lights that vary; `varied` are these lights."""
        gone = {each.index for each in varied}
        whole = [each.equation(self.scene) for each in self.subjects]
        kept = [tuple(term for term in equation.terms if term.index not in gone) for equation in whole]
        equations = [replace(each, terms=terms, clamp=False) for each, terms in zip(whole, kept, strict=True)]
        return self._run(equations, self.seen(self.scene))

    def share(self, one: Variation, light: Light, seen: Seen | None = None) -> Share:
        """Return the colours from one light that varies.

        Parameters
        ----------
        one : Variation
            The light in the scene, and its fields that vary.
        light : Light
            The same light with other directions, positions or sizes.
        seen : list, optional
            The light's visibility from each surface. By default, rays are cast.
        """
        if seen is None:
            seen = self.seen(self._with(one.index, light), one.index)
        rest = one.rest(light)
        columns = [self._alone(one.index, unit.light, unit.field, seen) for unit in one.units(light)]
        return Share(columns, None if rest is None else self._alone(one.index, rest, "", seen), seen)

    def _with(self, index: int, light: Light) -> Scene:
        lights = list(self.scene.lights)
        lights[index] = light
        return replace(self.scene, lights=lights)

    def _alone(self, index: int, light: Light, of: str, seen: Seen) -> Float64Array:
        """Return the colours (n, 3) from `light` alone, which replaces the scene's light `index`.

        `of` is the field whose colours are wanted, such as "diffuse"; equations are kept for each field. `seen` is the
        light's visibility from each surface.
        """
        equations = self._known.get((index, of))
        if equations is None or self.scene.light_model.convention == "vtk":
            # in VTK's convention, the shader depends on all lights
            scene = self._with(index, light)
            equations = [each.equation(scene) for each in self.subjects]
            for number, equation in enumerate(equations):
                terms = tuple(term for term in equation.terms if term.index == index)
                occluded = equation.is_occluded and any(any(term.ambient) for term in terms)
                dark: dict[str, Any] = {"ambient": BLACK, "emission": BLACK, "clamp": False, "is_occluded": occluded}
                equations[number] = replace(equation, terms=terms, **dark)
            self._known[index, of] = equations
        else:  # the same colours from another place
            moved = light.in_world(self.scene.viewer)
            equations = [
                replace(equation, terms=tuple(replace(term, light=moved) for term in equation.terms))
                for equation in equations
            ]
        return self._run(equations, seen)

    def seen(self, scene: Scene, index: int | None = None) -> Seen:
        """Return the visibility of the lights of `scene`, and of the sky with ambient occlusion, from each surface.

        With `index`, only this light's rays are cast. Rays are cast where the light model has shadows.
        """
        model, lights = scene.light_model, scene.world_lights
        found: Seen = []
        for subject in self.subjects:
            if subject.tracer is None:
                found.append(subject.seen)
                continue
            sides = 1 + model.two_sided
            rows = np.ones((sides, len(lights) + 1, len(subject)))
            for k, light in enumerate(lights) if model.shadows else ():
                if index in (None, k) and light.on:
                    rows[:, k] = subject.light_seen(light, behind=model.two_sided)
            if model.ambient_occlusion is not False:
                rows[:, -1] = [subject.sky, subject.sky_behind] if model.two_sided else [subject.sky]
            given = GivenVisibility("visibility", rows.reshape(-1, len(subject)))
            given.refuse_other(subject.vertices.points, lights, (), model)
            found.append(given)
        return found

    def _run(self, equations: Sequence[Equation], seen: Seen) -> Float64Array:
        """Evaluate one equation for each surface, and return the colours (n, 3) of all vertices.

        `seen` is the visibility from each surface.
        """
        how: dict[str, Any] = {"precision": "float64", "backend": self.backend}
        plans = []
        for subject, equation, visible in zip(self.subjects, equations, seen, strict=True):
            subject.vertices.visibility = visible
            plans.append(Plan.of_equation(relative_to_mesh(equation), subject.vertices))
        among, bounced = len(self) * self.expected, None
        if self.transport is not None:
            sent = [plan.sent(each.vertices, **how) for plan, each in zip(plans, self.subjects, strict=True)]
            count = self.scene.light_model.bounces
            bounced = interreflection.bounced(Radiosity.of_all(sent), self.transport.gather, count, apart=False)
        found, first = [], 0
        for plan, subject in zip(plans, self.subjects, strict=True):
            last = first + len(subject)
            own = None if bounced is None else bounced[:, first:last]
            found.append(plan.run(subject.vertices, bounced=own, among=among, **how).rgb)
            first = last
        return np.asarray(found[0] if len(found) == 1 else np.concatenate(found), np.float64)
