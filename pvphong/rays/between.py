"""Why nothing can stand between vertices and a light: what is known of it before any ray is cast."""

from __future__ import annotations

import math

import numpy as np

from pvphong.base.types import Float64Array
from pvphong.geometry.extent import ROUNDED_UP, Sphere
from pvphong.optics.light import NODES, Light
from pvphong.optics.roles import Place
from pvphong.rays.faces import Ball


def may_block(light: Light, vertices: Sphere | None, ball: Ball) -> bool:
    """Whether a part inside a ball can be between vertices inside a sphere and a light; True where too little is known.

    Parameters
    ----------
    light : Light
        In the world.
    vertices : Sphere or None
        Around them.
    ball : Ball
        Around the part.
    """
    if vertices is None:
        return True
    center, reach = np.array(vertices.center), (vertices.radius + ball.radius) * ROUNDED_UP
    nodes = light.nodes(NODES)
    if light.is_even and light.has_size:
        return True  # it comes from all sides
    if light.is_even:
        return _is_near_ray(ball.center - center, np.ravel(light.arrival(np.zeros((3, 1))).direction), reach)
    places = [node.values(Place) for node in nodes]
    if not all(len(each) == 1 for each in places):
        return True
    around = np.array([place for (place,) in places], np.float64)
    middle = around.mean(axis=0)
    size = float(np.sqrt(((around - middle) ** 2).sum(axis=1).max()))
    # nodes fill the light but for its rim: as they are inside of it, half as much again is certainly around it
    return _distance_to_segment(ball.center - center, middle - center) <= reach + 1.5 * size


def _is_near_ray(target: Float64Array, way: Float64Array, reach: float) -> bool:
    along = float(target @ way)
    across = math.sqrt(max(float(target @ target) - along * along, 0.0))
    return along >= -reach and across <= reach


def _distance_to_segment(target: Float64Array, end: Float64Array) -> float:
    square = float(end @ end)
    along = min(max(float(target @ end) / square, 0.0), 1.0) if square > 0.0 else 0.0
    return float(np.linalg.norm(target - along * end))
