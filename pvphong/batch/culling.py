"""Culling: selects the pieces of a surface that touch a piece, and those that may block its light.

The bounding boxes of all pieces are known. A piece's normals depend on the pieces whose boxes touch its own. Its rays
to a light depend on the pieces whose boxes meet a convex hull. For a directional light, this is the hull of the piece's
own box swept towards the light; for another light, it is the hull of the own box and the light. Of these pieces, only
the triangles that may meet the hull are kept.

Rays are cast in the coordinates of the whole surface, and vertices are numbered one piece after the other. So a
piece has, to the bit, the same visibility as in a single mesh of all pieces in which points along borders are not
merged.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Generic, TypeVar

import numpy as np
import pyvista as pv

from pvphong.base.types import BoolArray, IntArray
from pvphong.geometry.extent import Box, MeshBounds
from pvphong.meshes.visibility import world_faces
from pvphong.rays.casting import BlockingFaces
from pvphong.rays.rays import BEGUN_ABOVE, may_block, may_hide
from pvphong.scene.scene import Scene

Name = TypeVar("Name")

# Consecutive triangles are mostly neighbours, so they are culled in runs. Triangles per run, and runs at once.
_RUN, _RUNS_AT_ONCE = 32, 2**11


@dataclass(frozen=True)
class Outline:
    """Bounds of a piece. The tasks that light other pieces need them.

    Attributes
    ----------
    points : (low, high) or None
        Box around its points; None if a point is not finite. For a piece without points, a box that meets no other box.
    faces : (low, high) or None
        Box around its triangles that block light; None if it has no such triangles.
    count : int
        Number of points.
    """

    points: Box | None
    faces: Box | None
    count: int


@dataclass(frozen=True)
class PotentialOccluders(Generic[Name]):
    """Other pieces that may block a piece's light, and bounds of the whole surface.

    Attributes
    ----------
    within : (low, high)
        Box around the surface.
    points : (low, high) or None
        Box around the origins of the piece's rays; None if unknown.
    first : int
        Index of the piece's first point among those of all pieces.
    blockers : tuple
        Names of the other pieces that may block its light.
    """

    within: Box
    points: Box | None
    first: int
    blockers: tuple[Name, ...]

    def may_count(self, scene: Scene, parts: Box) -> BoolArray:
        """Return a mask of m boxes: True if triangles in a box may block light, or the sky, for this piece.

        Parameters
        ----------
        scene : Scene
            The scene. Its lights are considered if it has shadows, and the sky if it has ambient occlusion.
        parts : (low, high)
            Low and high corners of the boxes, shape (m, 3) each.
        """
        model = scene.light_model
        result: BoolArray = np.zeros(len(parts[0]), bool)
        for light in scene.world_lights if model.shadows else ():
            if light.on and light.casts_shadows:
                result |= may_block(light, self.points, parts)
        if model.ambient_occlusion is not False:
            result |= may_hide(self.points, parts, model.occlusion_distance)
        return result

    def blocking(self, scene: Scene, faces: BlockingFaces) -> BlockingFaces:
        """Return the triangles of another piece that may block this piece's light in a scene.

        `faces` are all triangles of the other piece that block light. They are tested in runs of `_RUN` consecutive
        triangles; a run is kept or dropped as a whole.
        """
        kept = []
        for start in range(0, len(faces), _RUN * _RUNS_AT_ONCE):
            corners = faces.corners[start : start + _RUN * _RUNS_AT_ONCE]
            coordinates, runs = faces.points[corners.ravel()], np.arange(0, 3 * len(corners), 3 * _RUN)
            parts = np.minimum.reduceat(coordinates, runs), np.maximum.reduceat(coordinates, runs)
            kept.append(corners[np.repeat(self.may_count(scene, parts), _RUN)[: len(corners)]])
        rows = np.concatenate([*kept, faces.corners[:0]])
        used = np.zeros(len(faces.points), bool)
        used[rows] = True
        return BlockingFaces(faces.points[used], (np.cumsum(used) - 1)[rows])


def outline_of(surface: pv.PolyData) -> Outline:
    """Return the outline of a piece's surface: the boxes around its points and triangles, and the number of points."""
    if not surface.n_points:
        return Outline((np.full(3, np.inf), np.full(3, -np.inf)), None, 0)
    faces, extent = world_faces(surface), MeshBounds(surface.points, None, None)
    return Outline(extent.box, faces.box, surface.n_points)


class _Boxes:
    """Boxes to search, in groups.

    A group is a run of consecutive boxes, and has a larger box around it. Groups are tested first. Consecutive pieces
    are near each other, so few boxes must then be tested one by one.

    Parameters
    ----------
    boxes : sequence of (low, high)
        Low and high corners, of at least one box.
    """

    def __init__(self, boxes: Sequence[Box]) -> None:
        self._lows, self._highs = np.transpose(boxes, (1, 0, 2))
        self._run = max(round(len(boxes) ** 0.5), 1)
        starts = np.arange(0, len(boxes), self._run)
        self._around = np.minimum.reduceat(self._lows, starts), np.maximum.reduceat(self._highs, starts)

    @property
    def whole(self) -> Box:
        """Box around all boxes: its low and high corner."""
        return self._around[0].min(axis=0), self._around[1].max(axis=0)

    def met(self, meets: Callable[[Box], BoolArray]) -> IntArray:
        """Return the indices of the boxes for which the function `meets` returns True.

        `meets` takes the low and high corners of k boxes, shape (k, 3) each, and returns a mask, shape (k,). It is
        first called for the larger boxes of the groups. If `meets` is True for a box, it must also be True for every
        larger box around this box.
        """
        runs = np.flatnonzero(meets(self._around))
        rows = (self._run * runs[:, None] + np.arange(self._run)).ravel()
        rows = rows[rows < len(self._lows)]
        return rows[meets((self._lows[rows], self._highs[rows]))]


def touching(outlines: Sequence[Outline]) -> Iterator[list[int]]:
    """Yield, for each piece in order, the indices of the other pieces whose boxes touch the piece's box.

    Only these pieces may share points with the piece.
    """
    everywhere = np.full(3, -np.inf), np.full(3, np.inf)
    boxes = [everywhere if outline.points is None else outline.points for outline in outlines]
    of_all = _Boxes(boxes)
    for number, box in enumerate(boxes):
        yield [other for other in of_all.met(partial(_touch, box)).tolist() if other != number]


def _touch(box: Box, parts: Box) -> BoolArray:
    touches: Any = (parts[0] <= box[1]) & (parts[1] >= box[0])
    return np.asarray(touches.all(axis=1))


def potential_occluders(
    scene: Scene, names: Sequence[Name], outlines: Sequence[Outline]
) -> Iterator[PotentialOccluders[Name]]:
    """Yield, for each piece in order, the other pieces that may block its light.

    Parameters
    ----------
    scene : Scene
        Scene with the lights.
    names, outlines : sequence
        Names and outlines of all pieces of the surface.
    """
    blocking = [number for number, outline in enumerate(outlines) if outline.faces is not None]
    nowhere = np.zeros(3), np.zeros(3)
    boxes = _Boxes([outline.faces for outline in outlines if outline.faces is not None] or [nowhere])
    within = boxes.whole
    above, first = BEGUN_ABOVE * float((within[1] - within[0]).max()), 0
    for number, outline in enumerate(outlines):
        points = None if outline.points is None else (outline.points[0] - above, outline.points[1] + above)
        alone: PotentialOccluders[Name] = PotentialOccluders(within, points, first, ())
        counts = boxes.met(partial(alone.may_count, scene)) if blocking and outline.count else ()
        others = tuple(names[blocking[row]] for row in counts if blocking[row] != number)
        yield replace(alone, blockers=others)
        first += outline.count
