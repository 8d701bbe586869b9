"""Box tests for parts that may be between vertices and a light, against linear programs."""

import numpy as np
import pytest

import pvphong as ph
from pvphong.rays.rays import may_block, may_hide

optimize = pytest.importorskip("scipy.optimize")


def boxes(rng, count):
    low = rng.normal(size=(count, 3))
    return low, low + rng.random((count, 3)) * rng.choice([0.0, 1.0, 4.0], (count, 1))


def corners_of(low, high):
    return np.array([np.where(np.unravel_index(k, (2, 2, 2)), high, low) for k in range(8)])


def least_gap(corners, ends, way, low, high):
    """Return the gap, along an axis, between a box and the hull of points extended along a direction; 0 inside."""
    points = np.concatenate([corners, ends])
    # unknowns: a share of each point, a length along the direction, a point in the box, and the gap between both
    count = len(points) + 1
    columns = np.concatenate([points, way[None]]).T
    upper = np.block([[s * columns, -s * np.eye(3), -np.ones((3, 1))] for s in (1.0, -1.0)])
    whole = np.concatenate([np.ones(len(points)), np.zeros(5)])[None]
    bounds = [(0, None)] * count + list(zip(low, high, strict=True)) + [(0, None)]
    found = optimize.linprog([0.0] * (count + 3) + [1.0], upper, np.zeros(6), whole, [1.0], bounds)
    return found.fun


NOWHERE = np.zeros((0, 3))
UP = np.array([0.0, 0.0, 1.0])
LIGHTS = {
    "point": lambda at: (ph.PointLight(position=at), at[None], np.zeros(3)),
    "sun": lambda at: (ph.DirectionalLight(direction=-at), NOWHERE, at / np.linalg.norm(at)),
    "sun overhead": lambda _: (ph.DirectionalLight(direction=-UP), NOWHERE, UP),
}


@pytest.mark.parametrize("light", LIGHTS)
def test_a_part_may_block_where_its_box_meets_the_hull_of_vertices_and_light(light):
    rng, said = np.random.default_rng(4), []
    for _ in range(12):
        (low, high), parts = boxes(rng, 1), boxes(rng, 5)
        shines, *ends = LIGHTS[light](rng.normal(size=3) * 4.0)
        found = may_block(shines, (low[0], high[0]), parts)
        for may, *part in zip(found, *parts, strict=True):
            gap = least_gap(corners_of(low[0], high[0]), *ends, *part)
            assert may == (gap < 1e-9) or gap < 1e-2, "except for the slack of rounding"
            said.append(may)
    assert 0.1 < np.mean(said) < 0.9


def test_a_light_with_a_size_is_met_anywhere_and_what_is_unknown_may_block():
    vertices = np.zeros(3), np.ones(3)
    parts = np.array([[9.5, 0, 0], [12, 0, 0]]), np.array([[9.6, 1, 1], [13, 1, 1]])
    assert may_block(ph.PointLight(position=(9, 0, 0)), vertices, parts).tolist() == [False, False]
    assert may_block(ph.SphereLight(position=(9, 0, 0), radius=0.8), vertices, parts).tolist() == [True, False]
    assert may_block(ph.PointLight(position=(9, 0, 0)), None, parts).all()
    assert may_block(ph.EnvironmentLight(), vertices, parts).all()


def test_what_is_near_enough_may_hide_the_sky():
    vertices = np.zeros(3), np.ones(3)
    parts = np.array([[4.0, 5, 0], [0.5, 0, 0]]), np.array([[5.0, 6, 1], [3, 1, 1]])  # the first is 5 away
    for distance, expected in ((4.9, [False, True]), (5.1, [True, True]), (np.inf, [True, True])):
        assert may_hide(vertices, parts, distance).tolist() == expected
    assert may_hide(None, parts, 0.1).all()
