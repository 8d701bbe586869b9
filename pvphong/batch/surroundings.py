"""Which pieces of one surface are around one: those that touch it, and those that may block light for it.

What is known of all pieces are boxes around them. A piece's normals need the pieces whose boxes touch its own. Between
its box and a light is the hull of both, or its box swept towards a sun; only pieces whose boxes meet that are read for
its rays. Rays are cast in the coordinates of the whole surface, and vertices are numbered one piece after the other:
so a piece sees, to the bit, what it sees as a part of one mesh.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
import pyvista as pv

from pvphong.base.types import BoolArray
from pvphong.geometry.extent import Box, Extent
from pvphong.meshes.visibility import world_faces
from pvphong.rays.rays import may_block, may_hide
from pvphong.scene.scene import Scene

Name = TypeVar("Name")


@dataclass(frozen=True)
class Outline:
    """What other pieces have to know of a piece.

    Attributes
    ----------
    points : (low, high) or None
        Around its points; None where one is not finite.
    faces : (low, high) or None
        Around the triangles that block light; None where there is none.
    count : int
        How many points it has.
    """

    points: Box | None
    faces: Box | None
    count: int


@dataclass(frozen=True)
class Surroundings(Generic[Name]):
    """The surface around a piece.

    Attributes
    ----------
    within : (low, high)
        Around all of it.
    first : int
        Number of the piece's first point among those of all pieces.
    blockers : tuple
        Names of the other pieces that may block light for it.
    """

    within: Box
    first: int
    blockers: tuple[Name, ...]


def outline_of(surface: pv.PolyData) -> Outline:
    """Where a surface is."""
    faces, extent = world_faces(surface), Extent(surface.points, None, None)
    return Outline(extent.box, faces.box if len(faces.sound) else None, surface.n_points)


def touching(outlines: Sequence[Outline]) -> Iterator[list[int]]:
    """For each piece the numbers of the others that may have points in common with it."""
    everywhere = np.full(3, -np.inf), np.full(3, np.inf)
    boxes = [everywhere if outline.points is None else outline.points for outline in outlines]
    lows, highs = np.transpose(boxes, (1, 0, 2))
    for number, (low, high) in enumerate(boxes):
        is_near = ((lows <= high) & (highs >= low)).all(axis=1)
        yield [other for other in np.flatnonzero(is_near).tolist() if other != number]


def surroundings_of(scene: Scene, names: Sequence[Name], outlines: Sequence[Outline]) -> Iterator[Surroundings[Name]]:
    """For each piece what is around it, in their order.

    Parameters
    ----------
    scene : Scene
        Whose light may be blocked.
    names, outlines : sequence
        Of all pieces of the surface.
    """
    blocking = [number for number, outline in enumerate(outlines) if outline.faces is not None]
    boxes = [outline.faces for outline in outlines if outline.faces is not None]
    lows, highs = np.transpose(boxes, (1, 0, 2)) if boxes else np.zeros((2, 0, 3))
    within = (lows.min(axis=0), highs.max(axis=0)) if boxes else (np.zeros(3), np.zeros(3))
    model, first = scene.light_model, 0
    lights = [light for light in scene.world_lights if light.on and model.shadows]
    for number, outline in enumerate(outlines):
        counts: BoolArray = np.zeros(len(blocking), bool)
        for light in lights:
            counts |= may_block(light, outline.points, (lows, highs))
        if model.ambient_occlusion is not False:
            counts |= may_hide(outline.points, (lows, highs), model.occlusion_distance)
        others = (names[blocking[row]] for row in np.flatnonzero(counts) if blocking[row] != number)
        yield Surroundings(within, first, tuple(others))
        first += outline.count
