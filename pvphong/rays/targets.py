"""Where rays to a light end: the places or directions of lights without a size, and what these send."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.base.vectors import unit
from pvphong.optics.light import Light
from pvphong.optics.roles import Place


class Target(NamedTuple):
    """Where rays to a light without a size end."""

    light: Light
    place: Any
    """Where it stands; None where only its direction is known."""

    @classmethod
    def of(cls, light: Light) -> Target:
        """Of a light without a size."""
        places = light.values(Place)
        return cls(light, np.array(places[0], np.float64) if len(places) == 1 and not light.is_even else None)

    @property
    def place_or_way(self) -> Float64Array:
        """Its place, or else the unit vector to it as it is seen from the origin."""
        if self.place is not None:
            return np.asarray(self.place)
        return np.ravel(self.light.arrival(np.zeros((3, 1))).direction).astype(np.float64)

    def seen_from(self, begins: Float64Array) -> tuple[Float64Array, Float64Array]:
        """Unit vectors (n, 3) and distances (n,); infinite ones where nothing says how far away a light is."""
        if self.place is not None:
            return ways_to(self.place, False, begins)
        ways = self.light.arrival(np.ascontiguousarray(begins.T)).direction.T
        return np.broadcast_to(ways, begins.shape), np.full(len(begins), math.inf)


def ways_to(goals: FloatArray, are_ways: Any, begins: Float64Array) -> tuple[Float64Array, Float64Array]:
    """To places, or along ways; and how far."""
    with np.errstate(all="ignore"):
        ways = np.where(np.reshape(are_ways, (-1, 1)), goals, goals - begins)
        directions, lengths = unit(np.ascontiguousarray(ways.T))
    return directions.T, np.where(are_ways, math.inf, lengths)


def strengths(nodes: Sequence[Light], picked: IntArray, points: Float64Array) -> Float64Array:
    """What each point gets of the node that is picked for it: strength times intensity."""
    order = np.argsort(picked, kind="stable")
    bounds = np.searchsorted(picked[order], np.arange(len(nodes) + 1))
    columns, result = np.ascontiguousarray(points[order].T), np.empty(len(picked))
    with np.errstate(all="ignore"):
        for node, begin, end in zip(nodes, bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
            if begin < end:
                result[order[begin:end]] = node.intensity * node.arrival(columns[:, begin:end]).strength
    return result
