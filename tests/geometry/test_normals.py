"""Normals of polygons, points, planes and implicit surfaces; their accuracy is in stability/test_mesh_normals."""

from __future__ import annotations

from functools import partial
from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from soups import FORMS, bumpy, every_form, soup
from stability import exact_normals as exact

from pvphong.geometry.normals import polygon_normals
from pvphong.geometry.projection import implicit_normals, plane_normal

U = 2.0**-53
WEIGHTINGS = ["angle", "area", "max"]
EVALUATORS = {"polygons": polygon_normals} | {
    f"{name}-{weighting}": partial(form, weighting=weighting)
    for name, form in FORMS.items()
    for weighting in WEIGHTINGS
}
every_evaluator = pytest.mark.parametrize("evaluator", EVALUATORS.values(), ids=EVALUATORS)

few = settings(max_examples=60, derandomize=True, deadline=None)


POINTS, FACES = bumpy(9, quads=True)
MESH = soup(*FACES)


# --- polygons ---


def ring(count, height=0.0):
    turn = np.linspace(0, 2 * np.pi, count + 1)[:-1]
    return np.stack([np.cos(turn), np.sin(turn), np.full(count, height)], axis=1)


ELL = np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 4), (0, 4)], float)


POLYGONS = {
    "faces of many sizes keep their places": (
        np.concatenate([ring(8), ring(8)[:, [2, 0, 1]]]),
        [tuple(range(8)), (0, 2, 5), (8, 10, 12, 14), (3, 2), (15, 12, 9), (), (0, 1, 2, 3, 4, 5)],
    ),
    "a concave polygon wherever it starts": (
        np.column_stack([ELL, 2 * ELL[:, 0] - ELL[:, 1]]) + np.array([7.0, -5.0, 1e4]),
        [tuple(np.roll(range(6), -start).tolist()) for start in range(6)],
    ),
    "a quad that is not flat": ([(0, 0, 1), (1, 0, 0), (1, 1, 1), (0, 1, 0)], [(0, 1, 2, 3)]),
    "a thousand corners": (ring(1000, 1e6), [tuple(range(1000))]),
    "axes of very different scale": ([(0, 0, 0), (1e9, 0, 0), (0, 1e-9, 0), (1e9, 1e-9, 0)], [(0, 1, 2), (1, 3, 2)]),
    "edges longer than the largest float": (
        1.7e308 * np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]),
        [(0, 1, 2), (0, 2, 3), (0, 1, 2, 3)],
    ),
}


@pytest.mark.parametrize(("points", "faces"), POLYGONS.values(), ids=POLYGONS)
def test_a_polygon_has_the_normal_of_newells_exact_sum(points, faces):
    stored = np.asarray(points, float)
    for face, normal in zip(faces, polygon_normals(points, *soup(*faces)), strict=True):
        area = exact.area_vector(stored[list(face)])
        if len(face) > 2 and any(area):
            assert exact.distance(normal, exact.unit(area)) <= 8 * U
        else:
            assert not normal.any()


# --- points; the definitions of the weightings are tested in stability/test_mesh_normals ---


@pytest.mark.parametrize("tops", [[(6, 7, 8, 9, 10, 11)], [(9, 6, 7), (9, 7, 8), (9, 11, 6), (9, 10, 11)]])
@every_form
def test_angle_weights_ignore_how_a_concave_side_is_cut(form, tops):
    """An upright L: at its inner edge the caps turn through 270°, so a reflex angle must count as one."""
    points = np.array([(x, y, z) for z in (0.0, 2.0) for x, y in ELL])
    walls = [(i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6) for i in range(6)]
    bottoms = [tuple(corner - 6 for corner in face[::-1]) for face in tops]
    observed = form(points, *soup(*walls, *tops, *bottoms))
    weights = {0: (-1, -1, 1), 3: (1, 1, 3)}  # ±90° of the walls, 90° or 270° of the cap
    for corner, normal in weights.items():
        assert np.allclose(observed[corner + 6], normal / np.linalg.norm(normal), rtol=0, atol=8 * U)
        assert np.allclose(observed[corner], normal * np.array([1, 1, -1]) / np.linalg.norm(normal), atol=8 * U)


@every_form
def test_a_midpoint_collapsed_onto_an_edge_does_not_bend_the_normals_around_it(form):
    """A sliver that is only rounding error, with 180° at its middle corner, would outweigh the real faces."""
    rng = np.random.default_rng(5)
    bent = 0
    for a, b, c in rng.normal(size=(50, 3, 3)) * np.array([1e-3, 1.0, 1.0])[:, None]:
        points = np.array([a, b, (a + b) / 2, c])
        plane = polygon_normals(points, [0, 1, 3], [0, 3])[0]
        observed = form(points, *soup((0, 2, 3), (2, 1, 3), (0, 1, 2)))
        assert np.abs(observed - plane).max() < 1e-13
        bent += np.cross(b - a, points[2] - a).any()
    assert bent > 10, "no sliver here has an area that rounding made"


TURNS = list(product([1.0, -1.0], repeat=3))


@every_form
@pytest.mark.parametrize("weighting", WEIGHTINGS)
def test_a_mirrored_mesh_has_mirrored_normals(form, weighting):
    """This also holds at a pole, where two points of each quad coincide and their edge has no direction."""
    pole = np.array([(1.0, 2.0, 3.0), (1.0, 2.0, 3.0), (0.5, 1.0, 4.0), (0.25, 1.5, 3.5), (2.0, 1.0, 1.0)])
    faces = soup((0, 1, 2, 3), (0, 4, 1))
    upright = form(pole, *faces, weighting)
    for turn in TURNS:
        assert np.array_equal(form(pole * turn, *faces, weighting), upright * turn * np.prod(turn))
    assert weighting == "max" or upright[:2].any(axis=1).all()


# --- common properties of both ---


@every_evaluator
def test_without_faces_nothing_has_a_normal(evaluator):
    assert evaluator(np.empty((0, 3)), [], [0]).shape == (0, 3)
    observed = evaluator(np.eye(3), [], [0])
    assert observed.shape == (0 if evaluator is polygon_normals else 3, 3)
    assert not observed.any()


@every_evaluator
def test_renumbering_and_reading_in_blocks_change_no_bit_and_the_order_of_faces_only_the_last(evaluator, monkeypatch):
    rng, per_face = np.random.default_rng(4), evaluator is polygon_normals
    expected, new, order = evaluator(POINTS, *MESH), rng.permutation(len(POINTS)), rng.permutation(len(FACES))
    moved = evaluator(POINTS[np.argsort(new)], *soup(*(new[list(face)] for face in FACES)))
    assert np.array_equal(moved if per_face else moved[new], expected)
    shuffled = evaluator(POINTS, *soup(*(FACES[i] for i in order)))
    assert np.abs(shuffled - (expected[order] if per_face else expected)).max() <= (0 if per_face else 8 * U)
    monkeypatch.setattr("pvphong.geometry.normals._BLOCK_CORNERS", 7)
    monkeypatch.setattr("pvphong.shading.kernel.normals._RANGE", 7)
    assert np.array_equal(evaluator(POINTS, *MESH), expected)


coordinates = st.builds(
    lambda mantissa, exponent: float(np.ldexp(mantissa, exponent)),
    st.sampled_from([0.0, 1.0, -1.0, 0.5, -0.75, 0.6]),
    st.integers(-1074, 1023),
) | st.sampled_from([np.nan, np.inf, 0.0, 1.0])


@few
@given(
    points=st.lists(st.tuples(*[coordinates] * 3), min_size=5, max_size=5),
    faces=st.lists(st.lists(st.integers(0, 4), max_size=5), max_size=6),
)
@every_evaluator
def test_any_soup_gives_unit_normals_or_zero(evaluator, points, faces):
    lengths = np.linalg.norm(evaluator(np.array(points), *soup(*faces)), axis=1)
    assert np.all((lengths == 0.0) | (np.abs(lengths - 1.0) <= 4 * U))


FACE, RISES = [0, 1, 2], r"^offsets must be indices that rise from 0 to the connectivity's length, 3; got \[.*\]\. Give"


@pytest.mark.parametrize(
    ("points", "connectivity", "offsets", "message"),
    [
        *[(np.eye(3), FACE, offsets, RISES) for offsets in ([0, 2], [1, 3], [0, 4], [0, 2, 1, 3], [3], [])],
        *[(np.eye(3), FACE, offsets, RISES) for offsets in ([0, 2**62, 3], [0, 2**63 - 1, -(2**63), 3])],
        (
            np.eye(3),
            [0.0, 1.0, 2.0],
            [0, 3],
            r"^connectivity must be a one-dimensional array of integers; got an array of float64 with shape \(3,\)",
        ),
        (np.eye(3), np.array([0, 1, 2**63 + 1], np.uint64), [0, 3], "^connectivity must be indices of the 3 points"),
        (
            np.eye(3),
            FACE,
            [0.0, 3.0],
            r"^offsets must be a one-dimensional array of integers; got an array of float64 with shape \(2,\)",
        ),
        (
            np.eye(3),
            [FACE],
            [0, 1],
            r"^connectivity must be a one-dimensional .* got an array of int64 with shape \(1, 3\)",
        ),
        *[
            (np.eye(3), [*FACE, 2, index, 0], [0, 0, 3, 3, 3, 6], rf"got index {index} in face 4\. The faces may")
            for index in (3, -1, 2**40)
        ],  # past empty faces
        (np.empty((0, 3)), FACE, [0, 3], "^connectivity must be empty if there are no points; got index 0 in face 0"),
        (np.eye(2), FACE, [0, 3], r"^points must be an \(n, 3\) array of real numbers"),
    ],
)
@every_evaluator
def test_arrays_that_do_not_fit_together_are_refused(evaluator, points, connectivity, offsets, message):
    with pytest.raises(ValueError, match=message):
        evaluator(points, connectivity, offsets)


# --- planes ---

P, Q, R = (1, 0, 0), (0, 1, 0), (0, 0, 1)
# The third point is 2⁻⁵³ off the line through the others; the cross product is exact a million away from the origin.
BARELY = (1e6, 1e6, 0.0), (1e6 + 1, 1e6 + 1, 0.0), (1e6 + 2, np.nextafter(1e6 + 2, np.inf), 0.0)


@pytest.mark.parametrize(
    ("calls", "direction"),
    [
        ([(2, -1, 2), (2, -1, 2, 5), ((2, -1, 2, -7.5),), (np.array([4.0, -2.0, 4.0]),)], (2, -1, 2)),
        ([(P, Q, R), ((P, Q, R),), (np.eye(3),), (Q, R, P)], (1, 1, 1)),
        ([(P, R, Q)], (-1, -1, -1)),  # clockwise
        ([BARELY], (0, 0, 1)),
        ([BARELY[::-1]], (0, 0, -1)),
        ([(0.0, 3.0 * size, -4.0 * size) for size in (2.0**-1000, 2.0**1000)], (0, 3, -4)),
        ([(size * np.eye(3),) for size in (2.0**-1000, 2.0**-170, 2.0**160, 2.0**1000)], (1, 1, 1)),
    ],
)
def test_a_plane_has_the_exact_normal_rounded_once(calls, direction):
    expected = [float(part) for part in exact.unit(exact.exact(direction))]
    for call in calls:
        assert np.array_equal(plane_normal(*call), expected)


COLLINEAR = list(permutations([(0.0, 0.0, 1.0), (1.0, 2.0, 3.0), (2.0, 4.0, 5.0)]))
ZEROS = [(0, 0, 0), (0, 0, 0, 1), ((0, 0, 0),)]
NO_PLANES = [(), (1, 2), (7.0,), ("abc",), ((1, 0, 0), (0, 1, 0)), ((1, 0, 0), 2, 3), (np.eye(4),)]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        *[(points, r"^plane must be three points that are not collinear; got p=\(") for points in COLLINEAR],
        *[(zero, r"^plane must be coefficients with a, b and c not all zero; got \(0.0, 0.0") for zero in ZEROS],
        *[(call, r"^plane must be \(a, b, c\), \(a, b, c, d\) or three points; got ") for call in NO_PLANES],
        (((1, 0), (0, 1), (1, 1)), "^p must be 3 finite numbers"),
        ((1, np.nan, 0), r"^plane\[1\] must be a finite number"),
        (((1, 0, 0), (0, np.inf, 0), (0, 0, 1)), r"^q\[1\] must be a finite number"),
        (("1", "2", "3"), r"^plane\[0\] must be a finite number"),
    ],
)
def test_what_is_no_plane_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        plane_normal(*call)


# --- implicit surfaces; gradients of any length are tested in stability/test_normalising ---


def test_gradients_come_from_a_function_or_as_an_array_and_without_a_direction_give_zero():
    gradients = [(0, 0, 2), (3, 0, 4), (0, 0, 0), (np.nan, 0, 1)]
    points = np.ones((4, 3), np.float32)

    def gradient(p):
        assert p.dtype == np.float64
        p *= -2.0
        return gradients

    for given_as in (gradients, gradient):
        observed = implicit_normals(given_as, points)
        assert np.array_equal(observed, [(0, 0, 1), (0.6, 0, 0.8), (0, 0, 0), (0, 0, 0)])
    assert (points == 1).all()
    for wrong, message in ((lambda p: p[:2], "gradient must be .* 4 rows; got 2 rows"), (None, "gradient must be")):
        with pytest.raises(ValueError, match=f"^{message}"):
            implicit_normals(wrong, points)
    with pytest.raises(ValueError, match=r"^points must be"):
        implicit_normals(gradient, np.ones(3))
