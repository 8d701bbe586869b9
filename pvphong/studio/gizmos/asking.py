"""Ask for light: the user drags a spot of a surface brighter or darker, and the intensities of lights follow.

The intensities are the least-squares solution of `pvphong.studies.fitting` for a target: what is asked for on the spot,
and what is seen now everywhere else. The spot weighs more. Light that bounces between the meshes counts as it is shown.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from pvphong.base.types import Float64Array
from pvphong.geometry.transform import transform_points
from pvphong.scene.scene import light_labels
from pvphong.studies.fitting.columns import Columns, Subject, point_areas
from pvphong.studies.fitting.linear import Column, Problem, refuse_without_scipy, solve
from pvphong.studies.fitting.target import Wanted
from pvphong.studies.fitting.variation import Variation
from pvphong.studio.gizmos.gizmo import Gizmo, Gizmos, called
from pvphong.studio.gizmos.highlight import SurfacePoint
from pvphong.studio.window_lights import RendererLight

PIXELS_PER_STOP = 60.0
"""Distance of the cursor that asks for twice the light, in pixels of a screen without scaling."""

# Weight of the spot in multiples of the weight of everything else.
_WEIGHT = 10.0
# Luminance of a black spot, which no factor would brighten.
_BLACK = 0.02


class Follower(NamedTuple):
    """A light whose intensity follows."""

    renderer_light: RendererLight
    variation: Variation
    state: Any
    """Its state when the drag began."""


class Ask:
    """A drag of a spot on a surface, with the state at its start.

    Parameters
    ----------
    gizmos : Gizmos
        The gizmos of the subplot; see `following` for the lights that follow.
    spot : SurfacePoint
        The middle of the spot.
    radius : float
        The spot's radius in world coordinates. What is asked for falls to nothing at this distance.

    Raises
    ------
    ValueError
        If SciPy is missing, no light can follow, a mix is shown, bounced light is still being computed, or a material
        is PBR in VTK's convention.
    """

    def __init__(self, gizmos: Gizmos, spot: SurfacePoint, radius: float) -> None:
        refuse_without_scipy()
        self.gizmos, self.before = gizmos, gizmos.lights.state
        self._start = gizmos.cursor[1]
        self._followers = _followers(gizmos)
        if not self._followers:
            raise ValueError("no light follows: switch one on, or choose one that is on")
        if gizmos.lit.is_mixed:
            raise ValueError("the mix is shown, not the lights: keep or end it, then ask")
        base, columns, areas, points = _lit(gizmos, [each.variation for each in self._followers])
        inside = np.maximum(1.0 - np.square(points - spot.point).sum(axis=1) / (radius * radius), 0.0) * (areas > 0.0)
        if not inside.any():  # the triangles are larger than the spot
            inside[np.argmin(np.where(areas > 0.0, np.square(points - spot.point).sum(axis=1), np.inf))] = 1.0
        self._inside = inside > 0.0
        own, rest = areas * inside, areas
        weights = _WEIGHT * own / (own.sum() or 1.0) + rest / (rest.sum() or 1.0)
        wanted = Wanted(np.zeros((len(base), 1)), np.sqrt(weights)[:, None] / np.sqrt(weights.sum()), clamps=False)
        self._problem = Problem(base, columns, wanted)
        x = np.array([each.variation.light.intensity for each in self._followers])
        self._seen = wanted.seen(self._problem.colors(x))
        self._share = (own / (own.sum() or 1.0))[self._inside]
        self.readout = ""
        self.ask(0.0)

    @property
    def is_possible(self) -> bool:
        """True if the lights still exist."""
        present = self.gizmos.lights.renderer_lights
        return all(each.renderer_light in present for each in self._followers)

    def put_back(self) -> None:
        """Restore the lights exactly."""
        for each in self._followers:
            each.renderer_light.restore(each.state)

    def move(self) -> None:
        """Set the intensities that belong to the cursor's position, if it has moved: up is brighter."""
        stops = (self.gizmos.cursor[1] - self._start) / (PIXELS_PER_STOP * self.gizmos.view.scale)
        if stops != self._stops:
            self.ask(stops)

    def ask(self, stops: float) -> None:
        """Ask for 2 to the power of `stops` times the luminance that the spot had at the start."""
        self._stops, values = stops, self._seen.copy()
        least = _BLACK if stops > 0.0 else 0.0  # a black spot can become brighter, and a dark one darker
        values[self._inside] = np.maximum(values[self._inside], least) * 2.0**stops
        wanted = replace(self._problem.wanted, values=values)
        solution = solve(replace(self._problem, wanted=wanted))
        asked, given = (
            float(self._share @ each[:, 0])
            for each in (values[self._inside], wanted.seen(solution.colors[self._inside]))
        )
        lines = [f"{stops:+.2f} stops: luminance {given:.3g}, asked for {asked:.3g}"]
        viewer = self.gizmos.lights.viewer
        for each, intensity in zip(self._followers, solution.x.tolist(), strict=True):
            if stops == 0.0:
                each.renderer_light.restore(each.state)
            else:
                changed = replace(each.renderer_light.light(viewer), intensity=intensity)
                each.renderer_light.set(changed, viewer)
            lines.append(f"{called(each.variation.light)} {each.renderer_light.light(viewer).intensity:.3g}")
        if not any(column.colors[self._inside].any() for column in self._problem.columns):
            lines.append("none of these lights reaches the spot")
        self.readout = "\n".join(lines)


def following(gizmos: Gizmos) -> list[Gizmo]:
    """Return the lights that follow, if they are on: those of `gizmos.followers`, or else the selected one, or all."""
    chosen = gizmos.selected
    if gizmos.followers is not None:
        wanted = [gizmo for gizmo in gizmos.all if gizmo.renderer_light in gizmos.followers]
    else:
        wanted = [chosen] if chosen is not None and chosen.light.on else list(gizmos.all)
    return [gizmo for gizmo in wanted if gizmo.light.on]


def _followers(gizmos: Gizmos) -> list[Follower]:
    viewer, present = gizmos.lights.viewer, list(gizmos.lights.renderer_lights)
    labels, found = light_labels(gizmos.lit.scene), []
    for gizmo in following(gizmos):
        each = gizmo.renderer_light
        index = present.index(each)
        varied = Variation(index, labels[index], each.light(viewer), ("intensity",), {})
        found.append(Follower(each, varied, each.state))
    return found


def _lit(gizmos: Gizmos, varied: list[Variation]) -> tuple[Float64Array, list[Column], Float64Array, Float64Array]:
    """Return the colours of all visible meshes without some lights, columns of these lights, areas and world points.

    The colours and columns include the light that bounces between the meshes.
    """
    scene, lit = gizmos.lit.scene, gizmos.lit.vertices()
    subjects, areas, points = list[Subject](), list[Float64Array](), list[Float64Array]()
    for mesh, vertices in lit:
        subject = Subject(vertices, mesh.material, None, vertices.visibility, mesh.matrix)
        if subject.equation(scene).gamma != 1.0:
            raise ValueError("light does not add up in VTK's convention of PBR: ask for it with LightModel()")
        subjects.append(subject)
        areas.append(point_areas(mesh.drawn, mesh.matrix))
        world = vertices.points if mesh.matrix is None else transform_points(vertices.points, mesh.matrix)
        finite: Any = np.isfinite(world).all(axis=1, keepdims=True)
        areas[-1] *= finite[:, 0]
        points.append(np.where(finite, world, 0.0))
    transport = gizmos.lit.gathering.transport([mesh for mesh, _ in lit]) if scene.light_model.bounces else None
    if scene.light_model.bounces and transport is None:
        raise ValueError("bounced light is still being computed: ask again when it is shown")
    columns = Columns(subjects, scene, transport, "auto", len(varied))
    shares = [Column(columns.share(one, one.light).columns[0], None) for one in varied]
    return columns.base(varied), shares, np.concatenate(areas), np.concatenate(points)
