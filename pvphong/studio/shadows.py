"""Shadows in windows: what is in the way, built again only where it has changed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pvphong.meshes.visibility import KnownOccluders, world_faces
from pvphong.rays.casting import BlockingFaces, Occluders
from pvphong.studio.live import LiveMesh


class Casting:
    """The meshes of one subplot that cast shadows, as occluders."""

    def __init__(self) -> None:
        self._faces: dict[LiveMesh, tuple[Any, BlockingFaces]] = {}
        self._occluders = Occluders(())

    def among(self, shown: Sequence[LiveMesh]) -> list[KnownOccluders]:
        """Each visible mesh among those that cast shadows; the same occluders as before while none of these changes."""
        casting = [live for live in shown if live.casts_shadows and _has_shape(live)]
        faces = {live: self._faces_of(live) for live in casting}
        is_same = list(faces) == list(self._faces) and all(faces[live] is self._faces[live] for live in faces)
        if not is_same:
            self._occluders = Occluders([each for _, each in faces.values()])
            self._faces = faces
        return [KnownOccluders(self._occluders, casting.index(live) if live in casting else None) for live in shown]

    def _faces_of(self, live: LiveMesh) -> tuple[Any, BlockingFaces]:
        state, known = live.shape(), self._faces.get(live)
        return known if known is not None and known[0] == state else (state, world_faces(live.drawn, live.matrix))


def _has_shape(live: LiveMesh) -> bool:
    """Whether it is fit to be lit; where not, whoever lights it says so."""
    try:
        live.shape()
    except ValueError:
        return False
    return True
