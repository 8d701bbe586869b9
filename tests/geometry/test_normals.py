from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pvphong.geometry.normals import implicit_normals, plane_normal, point_normals, polygon_normals

U = 2.0**-53
WEIGHTINGS = ["angle", "area", "max"]

few = settings(max_examples=60, derandomize=True, deadline=None)


def soup(faces):
    """Connectivity and offsets of faces given as tuples of indices."""
    return np.array([corner for face in faces for corner in face], int), np.cumsum([0, *map(len, faces)])


def sphere(seed=0, n=60):
    """A closed mesh of triangles whose points lie on the unit sphere: the convex hull, by its supporting planes."""
    points = np.random.default_rng(seed).normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    faces = []
    for i in range(n):
        for j in range(i + 1, n):
            normals = np.cross(points[j] - points[i], points - points[i])
            heights = np.einsum("kj,mj->km", normals, points - points[i])
            for k in np.flatnonzero((heights <= 1e-12).all(axis=1) & (np.abs(normals).max(axis=1) > 1e-9)):
                if k > i and k != j:
                    faces.append((i, j, int(k)))
                    assert normals[k] @ points[i] > 0.0
            for k in np.flatnonzero((heights >= -1e-12).all(axis=1) & (np.abs(normals).max(axis=1) > 1e-9)):
                if k > i and k != j:
                    faces.append((i, int(k), j))
    return points, sorted({min(permutation[r:] + permutation[:r] for r in range(3)) for permutation in faces})


def bumpy(n=9, seed=3):
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(n), np.arange(n))
    points = np.stack([x.ravel(), y.ravel(), rng.uniform(0, 1, n * n)], axis=1) + rng.uniform(-0.2, 0.2, (n * n, 3))
    quads = [(i, i + 1, i + n + 1, i + n) for i in range(n * (n - 1)) if i % n < n - 1]
    faces = [face for q in quads for face in ([q] if q[0] % 2 else [(q[0], q[1], q[2]), (q[0], q[2], q[3])])]
    return points, faces


# Polygons.


def test_counter_clockwise_is_the_front():
    points = [(0, 0, 0), (2, 0, 0), (0, 3, 0)]
    assert np.array_equal(polygon_normals(points, [0, 1, 2, 0, 2, 1], [0, 3, 6]), [(0, 0, 1), (0, 0, -1)])


def test_faces_of_many_sizes_keep_their_places():
    turn = np.linspace(0, 2 * np.pi, 9)[:-1]
    flat = np.stack([np.cos(turn), np.sin(turn), np.zeros(8)], axis=1)
    upright = flat[:, [2, 0, 1]]
    faces = [tuple(range(8)), (0, 2, 5), (8, 10, 12, 14), (3, 2), (15, 12, 9), (), (0, 1, 2, 3, 4, 5)]
    observed = polygon_normals(np.concatenate([flat, upright]), *soup(faces))
    expected = [(0, 0, 1), (0, 0, 1), (1, 0, 0), (0, 0, 0), (-1, 0, 0), (0, 0, 0), (0, 0, 1)]
    assert np.allclose(observed, expected, rtol=0, atol=8 * U)


@pytest.mark.parametrize("start", range(6))
def test_a_concave_polygon_has_the_normal_of_its_plane_wherever_it_starts(start):
    ell = np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 4), (0, 4)], float)
    points = np.column_stack([ell, 2 * ell[:, 0] - ell[:, 1]]) + np.array([7.0, -5.0, 1e4])
    observed = polygon_normals(points, np.roll(np.arange(6), -start), [0, 6])
    assert np.allclose(observed, [np.array([-2, 1, 1]) / np.sqrt(6)], rtol=0, atol=8 * U)


def test_a_quad_that_is_not_flat_has_the_normal_of_its_projected_areas():
    points = np.array([(0, 0, 1), (1, 0, 0), (1, 1, 1), (0, 1, 0)], float)
    assert np.array_equal(polygon_normals(points, [0, 1, 2, 3], [0, 4]), [(0, 0, 1)])


def test_a_polygon_of_a_thousand_corners():
    turn = np.linspace(0, 2 * np.pi, 1001)[:-1]
    points = np.stack([np.cos(turn), np.sin(turn), np.full(1000, 1e6)], axis=1)
    assert np.allclose(polygon_normals(points, np.arange(1000), [0, 1000]), [(0, 0, 1)], rtol=0, atol=8 * U)
    assert np.allclose(point_normals(points, np.arange(1000), [0, 1000]), [(0, 0, 1)] * 1000, rtol=0, atol=8 * U)


def test_axes_of_very_different_scale_are_no_degenerate_faces():
    points = [(0, 0, 0), (1e9, 0, 0), (0, 1e-9, 0), (1e9, 1e-9, 0)]
    assert np.array_equal(polygon_normals(points, [0, 1, 2, 1, 3, 2], [0, 3, 6]), [(0, 0, 1)] * 2)
    assert np.array_equal(point_normals(points, [0, 1, 2, 1, 3, 2], [0, 3, 6]), [(0, 0, 1)] * 4)


def test_a_midpoint_collapsed_onto_an_edge_does_not_bend_the_normals_around_it():
    """A sliver of rounding alone, with 180° at its middle corner, would otherwise outweigh the real faces."""
    rng = np.random.default_rng(5)
    bent = 0
    for a, b, c in rng.normal(size=(50, 3, 3)) * np.array([1e-3, 1.0, 1.0])[:, None]:
        points = np.array([a, b, (a + b) / 2, c])
        plane = polygon_normals(points, [0, 1, 3], [0, 3])[0]
        observed = point_normals(points, *soup([(0, 2, 3), (2, 1, 3), (0, 1, 2)]))
        assert np.abs(observed - plane).max() < 1e-13
        bent += np.cross(b - a, points[2] - a).any()
    assert bent > 10, "no sliver here has an area that rounding made"


def test_a_sliver_of_rounding_alone_adds_no_weight_either():
    """By Max's weights a tiny sliver's would make the real face at its corner look like rounding."""
    rng = np.random.default_rng(6)
    for a, b in rng.normal(size=(50, 2, 3)) * np.array([1e-23, 1e-20])[:, None]:
        points = np.array([a, b, (a + b) / 2, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
        observed = point_normals(points, *soup([(0, 2, 1), (0, 3, 4)]), weighting="max")
        assert np.array_equal(observed[0], polygon_normals(points, [0, 3, 4], [0, 3])[0])


@pytest.mark.parametrize("weighting", WEIGHTINGS)
def test_edges_longer_than_the_largest_float(weighting):
    points = 1.7e308 * np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    assert np.array_equal(polygon_normals(points, [0, 1, 2, 0, 1, 2, 3], [0, 3, 7]), [(0, 0, 1)] * 2)
    assert np.array_equal(point_normals(points, [0, 1, 2, 0, 2, 3], [0, 3, 6], weighting), [(0, 0, 1)] * 4)


@pytest.mark.parametrize("evaluator", [polygon_normals, *WEIGHTINGS])
def test_no_faces_and_no_points(evaluator):
    def call(points, connectivity, offsets):
        if callable(evaluator):
            return evaluator(points, connectivity, offsets)
        return point_normals(points, connectivity, offsets, evaluator)

    assert np.array_equal(call(np.empty((0, 3)), [], [0]), np.empty((0, 3)))
    observed = call(np.eye(3), [], [0])
    assert np.array_equal(observed, np.zeros((0 if callable(evaluator) else 3, 3)))


# Points.


def test_max_weights_are_exact_on_a_sphere():
    points, faces = sphere()
    assert len(faces) == 2 * len(points) - 4
    assert np.abs(point_normals(points, *soup(faces), weighting="max") - points).max() < 1e-13
    assert np.abs(point_normals(points, *soup(faces), weighting="area") - points).max() > 1e-3


@pytest.mark.parametrize("cap", ["polygon", "triangles", "fan"])
def test_angle_weights_ignore_how_a_concave_side_is_cut(cap):
    """An upright L: at its inner edge the caps turn through 270°, so a reflex angle must count as one."""
    ell = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 4), (0, 4)]
    points = np.array([(x, y, z) for z in (0.0, 2.0) for x, y in ell])
    walls = [(i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6) for i in range(6)]
    tops = {
        "polygon": [(6, 7, 8, 9, 10, 11)],
        "triangles": [(6, 7, 8), (6, 8, 9), (6, 9, 10), (6, 10, 11)],
        "fan": [(9, 6, 7), (9, 7, 8), (9, 11, 6), (9, 10, 11)],
    }[cap]
    bottoms = [tuple(corner - 6 for corner in face[::-1]) for face in tops]
    observed = point_normals(points, *soup(walls + tops + bottoms))
    weights = {0: (-1, -1, 1), 3: (1, 1, 3)}  # ±90° of the walls, 90° or 270° of the cap
    for corner, normal in weights.items():
        assert np.allclose(observed[corner + 6], normal / np.linalg.norm(normal), rtol=0, atol=8 * U)
        assert np.allclose(observed[corner], normal * np.array([1, 1, -1]) / np.linalg.norm(normal), atol=8 * U)


def test_each_weighting_weighs_what_it_says():
    """Two right triangles at the origin, in z = 0 and x = 0: legs 1 and 2, and legs 2 and 4."""
    points = [(0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 4)]
    mesh = soup([(0, 1, 2), (0, 2, 3)])
    angle = np.arctan2(1, 2)  # at point 2 in the first, arctan 2 in the second
    for weighting, at_origin, at_two in [
        ("angle", (1, 1), (angle, np.arctan2(4, 2))),
        ("area", (2, 8), (2, 8)),
        ("max", (1 / 2, 1 / 8), (np.sin(angle) / (2 * np.sqrt(5)), (2 / np.sqrt(5)) / (2 * np.sqrt(20)))),
    ]:
        observed = point_normals(points, *mesh, weighting=weighting)
        for point, (z, x) in ((0, at_origin), (2, at_two)):
            assert np.allclose(observed[point], np.array([x, 0, z]) / np.hypot(x, z), rtol=0, atol=4 * U), weighting


def test_angle_is_the_default():
    points, faces = bumpy()
    assert np.array_equal(point_normals(points, *soup(faces)), point_normals(points, *soup(faces), weighting="angle"))


@pytest.mark.parametrize("weighting", WEIGHTINGS)
def test_renumbering_the_points_changes_no_bit(weighting):
    points, faces = bumpy()
    new = np.random.default_rng(4).permutation(len(points))
    moved = np.empty_like(points)
    moved[new] = points
    renumbered = [tuple(new[list(face)]) for face in faces]
    expected = point_normals(points, *soup(faces), weighting=weighting)
    assert np.array_equal(point_normals(moved, *soup(renumbered), weighting=weighting)[new], expected)
    assert np.array_equal(polygon_normals(moved, *soup(renumbered)), polygon_normals(points, *soup(faces)))


@pytest.mark.parametrize("weighting", WEIGHTINGS)
def test_the_order_of_the_faces_changes_no_more_than_the_last_bits(weighting):
    points, faces = bumpy()
    order = np.random.default_rng(4).permutation(len(faces))
    shuffled = soup([faces[i] for i in order])
    assert np.array_equal(polygon_normals(points, *shuffled), polygon_normals(points, *soup(faces))[order])
    difference = point_normals(points, *shuffled, weighting) - point_normals(points, *soup(faces), weighting)
    assert np.abs(difference).max() <= 8 * U


@pytest.mark.parametrize("weighting", WEIGHTINGS)
def test_blocks_of_faces_change_no_bit(weighting, monkeypatch):
    points, faces = bumpy()
    expected = point_normals(points, *soup(faces), weighting=weighting)
    monkeypatch.setattr("pvphong.geometry.faces._BLOCK_CORNERS", 7)
    assert np.array_equal(point_normals(points, *soup(faces), weighting=weighting), expected)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("integers", [np.int32, np.int64, np.uint8])
def test_layout_and_integer_type_change_no_bit_and_inputs_are_kept(dtype, integers):
    points, faces = bumpy()
    points = points.astype(dtype)
    connectivity, offsets = (array.astype(integers) for array in soup(faces[:60]))
    expected = point_normals(points.astype(np.float64), *soup(faces[:60]))
    strided = np.full((len(points), 7), np.nan, dtype)
    strided[:, ::3] = points
    read_only = points.copy()
    for array in (read_only, connectivity, offsets):
        array.flags.writeable = False
    for layout in (points, np.asfortranarray(points), strided[:, ::3], read_only, points[::-1].copy()[::-1]):
        assert np.array_equal(point_normals(layout, connectivity, offsets), expected)
        assert np.array_equal(layout, points)


@few
@given(power=st.integers(-960, 1000), weighting=st.sampled_from(WEIGHTINGS))
def test_powers_of_two_change_no_bit(power, weighting):
    points, faces = bumpy()
    mesh = soup(faces)
    scaled = np.ldexp(points, power)
    assert np.array_equal(point_normals(scaled, *mesh, weighting), point_normals(points, *mesh, weighting))
    assert np.array_equal(polygon_normals(scaled, *mesh), polygon_normals(points, *mesh))


coordinates = st.builds(
    lambda mantissa, exponent: float(np.ldexp(mantissa, exponent)),
    st.sampled_from([0.0, 1.0, -1.0, 0.5, -0.75, 0.6]),
    st.integers(-1074, 1023),
)


@few
@given(
    points=st.lists(
        st.tuples(*[coordinates | st.sampled_from([np.nan, np.inf, 0.0, 1.0])] * 3), min_size=5, max_size=5
    ),
    faces=st.lists(st.lists(st.integers(0, 4), max_size=5), max_size=6),
    weighting=st.sampled_from(WEIGHTINGS),
)
def test_any_soup_gives_unit_normals_or_zero(points, faces, weighting):
    points = np.array(points)
    for observed in (polygon_normals(points, *soup(faces)), point_normals(points, *soup(faces), weighting)):
        lengths = np.linalg.norm(observed, axis=1)
        assert np.all((lengths == 0.0) | (np.abs(lengths - 1.0) <= 4 * U))


# What is refused.


@pytest.mark.parametrize("evaluator", [polygon_normals, point_normals])
def test_arrays_that_do_not_fit_together_are_refused(evaluator):
    points = np.eye(3)
    rises = r"^offsets must be indices that rise from 0 to the connectivity's length, 3; got \[.*\]\. One starts"
    for offsets in ([0, 2], [1, 3], [0, 4], [0, 2, 1, 3], [3], []):
        with pytest.raises(ValueError, match=rises):
            evaluator(points, [0, 1, 2], offsets)
    with pytest.raises(
        ValueError, match=r"offsets must be a one-dimensional array of integers; got shape \(2,\) of fl"
    ):
        evaluator(points, [0, 1, 2], [0.0, 3.0])
    with pytest.raises(ValueError, match=r"connectivity must be a one-dimensional .* got shape \(1, 3\) of int"):
        evaluator(points, [[0, 1, 2]], [0, 1])
    with pytest.raises(ValueError, match=r"connectivity must be empty without points; got index 0 in face 0"):
        evaluator(np.empty((0, 3)), [0, 1, 2], [0, 3])
    with pytest.raises(ValueError, match=r"points must be an \(n, 3\) array of real numbers"):
        evaluator(np.eye(2), [0, 1, 2], [0, 3])


def test_the_face_with_a_bad_index_is_named_past_empty_faces():
    with pytest.raises(ValueError, match=r"got index 3 in face 4\. The file"):
        polygon_normals(np.eye(3), [0, 1, 2, 2, 3, 0], [0, 0, 3, 3, 3, 6])


def test_another_weighting_is_refused_with_the_allowed_ones():
    with pytest.raises(ValueError, match=r"weighting must be one of 'angle', 'area', 'max'; got angel. Did you mean"):
        point_normals(np.eye(3), [0, 1, 2], [0, 3], "angel")


# Planes.


def test_a_plane_from_its_coefficients():
    expected = [2 / 3, -1 / 3, 2 / 3]
    for call in ((2, -1, 2), (2, -1, 2, 5), ((2, -1, 2),), ((2, -1, 2, -7.5),), (np.array([4.0, -2.0, 4.0]),)):
        assert np.array_equal(plane_normal(*call), expected)


def test_a_plane_from_three_points_counter_clockwise():
    p, q, r = (1, 0, 0), (0, 1, 0), (0, 0, 1)
    expected = np.full(3, 3**-0.5)
    for call in ((p, q, r), ((p, q, r),), (np.eye(3),), (q, r, p)):
        assert np.allclose(plane_normal(*call), expected, rtol=0, atol=U)
    assert np.array_equal(plane_normal(p, r, q), -plane_normal(p, q, r))


@pytest.mark.parametrize("power", [-1000, -170, 0, 160, 1000])
def test_planes_of_every_size(power):
    scale = 2.0**power
    assert np.array_equal(plane_normal(0.0, 3.0 * scale, -4.0 * scale), [0.0, 0.6, -0.8])
    assert np.array_equal(plane_normal(scale * np.eye(3)), plane_normal(np.eye(3)))


def test_points_that_are_collinear_but_for_the_last_bit():
    """r is 2⁻⁵³ off the line through p and q, and a million away from the origin the cross product is exact."""
    p, q, r = (1e6, 1e6, 0.0), (1e6 + 1, 1e6 + 1, 0.0), (1e6 + 2, np.nextafter(1e6 + 2, np.inf), 0.0)
    assert np.array_equal(plane_normal(p, q, r), [0.0, 0.0, 1.0])
    assert np.array_equal(plane_normal(p, r, q), [0.0, 0.0, -1.0])
    third = (0.1, 0.2, 0.3)
    almost = (0.3, 0.6, np.nextafter(0.9, 1.0))
    assert np.linalg.norm(plane_normal((0, 0, 0), third, almost)) == pytest.approx(1.0, abs=4 * U)


def test_collinear_points_and_a_plane_without_a_direction_are_refused():
    for order in permutations([(0.0, 0.0, 1.0), (1.0, 2.0, 3.0), (2.0, 4.0, 5.0)]):
        with pytest.raises(ValueError, match=r"plane must be three points that are not collinear; got p=\("):
            plane_normal(*order)
    for zero in ((0, 0, 0), (0, 0, 0, 1), ((0, 0, 0),)):
        with pytest.raises(ValueError, match=r"plane must be coefficients with a, b, c not all zero; got \(0.0, 0.0"):
            plane_normal(*zero)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ((), r"plane must be \(a, b, c\), \(a, b, c, d\) or three points; got \(\)"),
        ((1, 2), "or three points"),
        ((7.0,), "or three points"),
        (("abc",), "or three points"),
        (((1, 0, 0), (0, 1, 0)), "or three points"),
        (((1, 0, 0), 2, 3), "or three points"),
        ((np.eye(4),), "or three points"),
        (((1, 0), (0, 1), (1, 1)), "p must be 3 finite numbers"),
        ((1, np.nan, 0), r"plane\[1\] must be a finite number"),
        (((1, 0, 0), (0, np.inf, 0), (0, 0, 1)), r"q\[1\] must be a finite number"),
        (("1", "2", "3"), r"plane\[0\] must be a finite number"),
    ],
)
def test_what_is_no_plane_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        plane_normal(*call)


# Implicit surfaces.


def test_the_normal_of_a_sphere_is_its_point():
    points, _ = sphere(n=20)
    assert np.abs(implicit_normals(lambda p: p, points) - points).max() <= 4 * U
    assert np.array_equal(implicit_normals(lambda p: 2 * p, 1e200 * np.eye(3)), np.eye(3))


def test_gradients_may_come_as_an_array():
    assert np.array_equal(implicit_normals([(0, 0, 2), (3, 0, 4)], np.ones((2, 3))), [(0, 0, 1), (0.6, 0, 0.8)])


def test_a_zero_or_bad_gradient_gives_zero():
    gradients = [(0, 0, 0), (np.nan, 0, 1), (0, 0, 3)]
    assert np.array_equal(implicit_normals(gradients, np.ones((3, 3))), [(0, 0, 0), (0, 0, 0), (0, 0, 1)])


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_gradient_gets_float64_points_of_its_own(dtype):
    points = np.eye(3, dtype=dtype)

    def gradient(p):
        assert p.dtype == np.float64
        p *= -2.0
        return p

    assert np.array_equal(implicit_normals(gradient, points), -np.eye(3))
    assert np.array_equal(points, np.eye(3))


@pytest.mark.parametrize(
    ("gradient", "message"),
    [
        (lambda p: p[:, 0], r"gradient must be an \(n, 3\) array of real numbers; got an array of shape \(3,\)"),
        (lambda p: p[:2], "gradient must be an array with one row per point, 3 rows; got 2 rows"),
        (lambda p: p + 1j, "gradient must be an .* got an array of complex128"),
        (np.eye(2), "gradient must be"),
        (None, "gradient must be"),
    ],
)
def test_gradients_of_another_shape_are_refused(gradient, message):
    with pytest.raises(ValueError, match=message):
        implicit_normals(gradient, np.eye(3))


def test_points_of_another_shape_are_refused():
    with pytest.raises(ValueError, match="points must be"):
        implicit_normals(lambda p: p, np.ones(3))
