"""Ask for light: the user drags a spot of a surface brighter or darker, and the intensities of lights follow.

The intensities are the least-squares solution of `pvphong.studies.fitting` for a target: what is asked for on the spot,
and what is seen now everywhere else. The spot weighs more.
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
from pvphong.studio.gizmos.gizmo import Gizmos, called
from pvphong.studio.gizmos.highlight import SurfacePoint
from pvphong.studio.window_lights import RendererLight

PIXELS_PER_STOP = 60.0
"""Distance of the cursor that asks for twice the light."""

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
        The gizmos of the subplot. The selected light follows; without a selection, all lights that are on.
    spot : SurfacePoint
        The middle of the spot.
    radius : float
        The spot's radius in world coordinates. What is asked for falls to nothing at this distance.

    Raises
    ------
    ValueError
        If SciPy is missing, or no light can follow.
    """

    def __init__(self, gizmos: Gizmos, spot: SurfacePoint, radius: float) -> None:
        refuse_without_scipy()
        self.gizmos, self.before = gizmos, gizmos.lights.state
        self._start = gizmos.cursor[1]
        self._followers = _followers(gizmos)
        if not self._followers:
            raise ValueError("no light follows: switch one on, or select one that is on")
        base, columns, areas, points = _lit(gizmos, [each.variation for each in self._followers])
        inside = np.maximum(1.0 - np.square(points - spot.point).sum(axis=1) / (radius * radius), 0.0) * (areas > 0.0)
        if not inside.any():  # the triangles are larger than the spot
            inside[np.argmin(np.square(points - spot.point).sum(axis=1))] = 1.0
        self._inside = inside > 0.0
        own, rest = areas * inside, areas
        weights = _WEIGHT * own / (own.sum() or 1.0) + rest / (rest.sum() or 1.0)
        wanted = Wanted(np.zeros((len(base), 1)), np.sqrt(weights)[:, None] / np.sqrt(weights.sum()), clamps=False)
        self._problem = Problem(base, columns, wanted)
        x = np.array([each.variation.light.intensity for each in self._followers])
        self._seen = wanted.seen(self._problem.colors(x))
        self._share = own / (own.sum() or 1.0)
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
        """Set the intensities that belong to the cursor's position: up is brighter."""
        self.ask((self.gizmos.cursor[1] - self._start) / PIXELS_PER_STOP)

    def ask(self, stops: float) -> None:
        """Ask for 2 to the power of `stops` times the luminance that the spot had at the start."""
        values = self._seen.copy()
        values[self._inside] = np.maximum(values[self._inside], _BLACK) * 2.0**stops if stops else values[self._inside]
        wanted = replace(self._problem.wanted, values=values)
        solution = solve(replace(self._problem, wanted=wanted))
        asked, given = (float(self._share @ each[:, 0]) for each in (values, wanted.seen(solution.colors)))
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


def _followers(gizmos: Gizmos) -> list[Follower]:
    """Return the lights that follow: the selected one if it is on, or else all that are on."""
    viewer, chosen = gizmos.lights.viewer, gizmos.selected
    wanted = [chosen] if chosen is not None and chosen.light.on else list(gizmos.all)
    present = list(gizmos.lights.renderer_lights)
    labels = light_labels(gizmos.lit.scene)
    found = []
    for gizmo in wanted:
        each = gizmo.renderer_light
        light = each.light(viewer)
        if light.on:
            index = present.index(each)
            found.append(Follower(each, Variation(index, labels[index], light, ("intensity",), {}), each.state))
    return found


def _lit(gizmos: Gizmos, varied: list[Variation]) -> tuple[Float64Array, list[Column], Float64Array, Float64Array]:
    """Return the colours of all visible meshes without some lights, columns of these lights, areas and world points."""
    scene = gizmos.lit.scene
    direct = replace(scene, light_model=replace(scene.light_model, bounces=0))
    bases, areas, points = list[Float64Array](), list[Float64Array](), list[Float64Array]()
    shares: list[list[Float64Array]] = [[] for _ in varied]
    for mesh, vertices in gizmos.lit.vertices():
        if vertices.equation(direct, mesh.material, mesh.matrix).gamma != 1.0:
            raise ValueError("light does not add up in VTK's convention of PBR: ask for it with LightModel()")
        subject = Subject(vertices, mesh.material, None, vertices.visibility)
        columns = Columns([subject], direct, mesh.matrix, None, "auto", len(varied))
        bases.append(columns.base(varied))
        for one, found in zip(varied, shares, strict=True):
            found.append(columns.share(one, one.light).columns[0])
        areas.append(point_areas(mesh.drawn, mesh.matrix))
        world = vertices.points if mesh.matrix is None else transform_points(vertices.points, mesh.matrix)
        finite: Any = np.isfinite(world).all(axis=1, keepdims=True)
        areas[-1] *= finite[:, 0]
        points.append(np.where(finite, world, 0.0))
    joined = [Column(np.concatenate(found), None) for found in shares]
    return np.concatenate(bases), joined, np.concatenate(areas), np.concatenate(points)
