"""Where rays to lights end: at places or along directions of lights without a size, and what these send."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.base.vectors import unit
from pvphong.optics.light import Light
from pvphong.optics.roles import Place
from pvphong.rays.sampling import in_tree_order


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
            return ways_to_goals(self.place, False, begins)
        ways = self.light.arrival(np.ascontiguousarray(begins.T)).direction.T
        return np.broadcast_to(ways, begins.shape), np.full(len(begins), math.inf)


class Targets:
    """Where rays to a light with a size end: at lights without one, in the order of a tree that halves them by place.

    Parameters
    ----------
    light : Light
        With a size, in the world.
    count : int
        Into so many lights it is divided, about.
    """

    def __init__(self, light: Light, count: int) -> None:
        nodes = light.nodes(count)
        targets = [Target.of(node) for node in nodes]
        goals = np.array([target.place_or_way for target in targets])
        order = in_tree_order(goals)
        self._nodes, self._goals = [nodes[k] for k in order], goals[order]
        self._are_ways: Any = np.array([targets[k].place is None for k in order])
        self._are_alike = not self._are_ways.any() and _differ_by_place_alone(nodes)

    def __len__(self) -> int:
        return len(self._nodes)

    def seen_from(self, picked: IntArray, begins: Float64Array) -> tuple[Float64Array, Float64Array]:
        """Unit vectors (n, 3) and distances (n,) to the one that is picked for each begin."""
        return ways_to_goals(self._goals[picked], not self._are_alike and self._are_ways[picked], begins)

    def strengths(self, picked: IntArray, points: Float64Array) -> Float64Array:
        """What each point gets of the one that is picked for it: strength times intensity."""
        if self._are_alike:  # as from the first one, seen from where that is as the picked one is from here
            with np.errstate(all="ignore"):
                shifted = points - (self._goals - self._goals[0])[picked]
                strength = self._nodes[0].arrival(np.ascontiguousarray(shifted.T)).strength
                return np.broadcast_to(self._nodes[0].intensity * strength, len(picked))
        return self._one_by_one(picked, points)

    def _one_by_one(self, picked: IntArray, points: Float64Array) -> Float64Array:
        order = np.argsort(picked, kind="stable")
        bounds = np.searchsorted(picked[order], np.arange(len(self) + 1))
        columns, result = np.ascontiguousarray(points[order].T), np.empty(len(picked))
        with np.errstate(all="ignore"):
            for node, begin, end in zip(self._nodes, bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
                if begin < end:
                    result[order[begin:end]] = node.intensity * node.arrival(columns[:, begin:end]).strength
        return result


def _differ_by_place_alone(nodes: Sequence[Light]) -> bool:
    """Whether lights are the same but for where they stand."""
    first = nodes[0]
    fields = [name for name in vars(first) if name not in first.roles or not isinstance(first.roles[name], Place)]
    return all(
        type(node) is type(first) and all(getattr(node, name) == getattr(first, name) for name in fields)
        for node in nodes
    )


def ways_to_goals(goals: FloatArray, are_ways: Any, begins: Float64Array) -> tuple[Float64Array, Float64Array]:
    """To places, or along ways; and how far."""
    with np.errstate(all="ignore"):
        ways = np.where(np.reshape(are_ways, (-1, 1)), goals, goals - begins)
        directions, lengths = unit(np.ascontiguousarray(ways.T))
    return directions.T, np.where(are_ways, math.inf, lengths)
