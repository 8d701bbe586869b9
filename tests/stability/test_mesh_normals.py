"""Section C of the catalogue of hard cases: normals of faces and points, against exact fractions and mpmath.

They are computed from plain arrays; meshes/test_surfaces tests that a mesh gives the same bits.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from soups import bumpy, every_form, mesh_of, soup
from stability import exact_normals as exact
from stability import naive
from stability.bounds import U, V, assert_within

from pvphong import diagnose
from pvphong.geometry.normals import point_normals, polygon_normals
from pvphong.pipeline import vertex_normals

WEIGHTINGS = ["angle", "area", "max"]


def triangles_at(rng, samples, height=None):
    """Return random triangles, (samples, 3, 3), with longest edge L = 1 and any shape or a given height."""
    frames = np.linalg.qr(rng.normal(size=(samples, 3, 3)))[0]
    heights = rng.uniform(0.2, 0.8, samples) if height is None else np.full(samples, height)
    along = rng.uniform(0.2, 0.8, samples)
    apex = along[:, None] * frames[:, 0] + heights[:, None] * frames[:, 1]
    return np.stack([np.zeros((samples, 3)), frames[:, 0], apex], axis=1)


def separate(corners):
    """Return triangles (m, 3, 3) as points, connectivity and offsets, without shared points."""
    return corners.reshape(-1, 3), np.arange(3 * len(corners)), np.arange(0, 3 * len(corners) + 1, 3)


def face_errors(observed, corners):
    """Return errors of face normals, and L / h, of triangles with a nonzero area as stored."""
    pairs = [(normal, t) for normal, t in zip(observed, corners, strict=True) if any(exact.area_vector(t))]
    errors = [exact.distance(normal, exact.unit(exact.area_vector(t))) for normal, t in pairs]
    return np.array([errors, [exact.slenderness(t) for _, t in pairs]])


def newell_of_products(corners):
    """Compute the textbook sum of p_i × p_(i+1) in the stored precision."""
    after = np.roll(corners, -1, axis=1)
    total = np.cross(corners, after).sum(axis=1, dtype=corners.dtype)
    with np.errstate(all="ignore"):
        return total / np.sqrt((total * total).sum(axis=1, keepdims=True))


def far(offset, dtype, size=1.0, towards=(1.0, 1.0, 1.0)):
    return (size * triangles_at(np.random.default_rng(20), 150) + offset * np.array(towards)).astype(dtype)


def slivers(height):
    rng = np.random.default_rng(22)
    return triangles_at(rng, 150, height=height) + rng.uniform(-1, 1, (150, 1, 3))


OFFSETS = [(1e3, "float32"), (1e6, "float32"), (1e3, "float64"), (1e6, "float64"), (1e9, "float64")]
WORLD = {f"20 {offset:.0e} {dtype}": far(offset, dtype, towards=(1.0, -0.7, 0.4)) for offset, dtype in OFFSETS}
STORED = {f"21 {offset:.0e}": far(offset, "float32", size=4.0) for offset in (1e4, 1e6, 1e8)}
SLIVERS = {f"22 h=1e{power}": slivers(10.0**power) for power in (-3, -6, -9, -12, -13, -14, -15)}


@pytest.mark.parametrize("row", [*WORLD, *STORED, *SLIVERS])
def test_row_20_21_22_triangles_far_out_and_slivers(row):
    """Triangles that collapse when stored, in row 21 at 1e8, have no normal."""
    corners = (WORLD | STORED | SLIVERS)[row]
    observed = polygon_normals(*separate(corners))
    collapsed = np.array([not any(exact.area_vector(triangle)) for triangle in corners])
    assert collapsed.any() == (row == "21 1e+08")
    assert not observed[collapsed].any()
    if not collapsed.all():
        errors, slenderness = face_errors(observed, corners)
        bounds = (64 if row in SLIVERS else 8) * U * slenderness
        assert_within(row, errors, bounds)


@pytest.mark.parametrize(("row", "offset"), [(row, offset) for row, (offset, _) in zip(WORLD, OFFSETS, strict=True)])
def test_row_20_products_of_positions_break_the_bound_in_every_case(row, offset):
    roundoff = U if row.endswith("float64") else V
    errors, slenderness = face_errors(newell_of_products(WORLD[row]), WORLD[row])
    excess = naive.least_excess(errors, 8 * roundoff * slenderness)
    assert excess > 1e-4 * min(offset**2, 1.0 / roundoff), "products grow with the offset's square"


ROOF = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])

FLAWS = {
    "one-index-twice": (ROOF, [0, 1, 1]),
    "one-index-thrice": (ROOF, [2, 2, 2]),
    "duplicate-points": (np.array([*ROOF, [0.0, 1.0, 0.0]]), [2, 4, 1]),
    "collinear": (np.array([*ROOF, [0.1, 0.2, 0.3], [0.2, 0.4, 0.6], [0.4, 0.8, 1.2]]), [4, 5, 6]),
    "collinear-to-the-last-bit": (np.array([*ROOF, [0.1, 0.2, 0.3], [0.3, 0.6, 0.9], [0.7, 1.4, 2.1]]), [4, 5, 6]),
    "one-corner": (ROOF, [1]),
    "two-corners": (ROOF, [1, 2]),
    "bow-tie": (np.array([*ROOF, [1.0, 1.0, 0.0]]), [0, 4, 1, 2]),
    "tiny-and-collinear": (np.array([*ROOF, [1e-200, 0, 0], [2e-200, 0, 0]]), [0, 4, 5]),
    "huge-and-collinear": (np.array([*ROOF, [1e200, 0, 0], [2e200, 0, 0]]), [0, 4, 5]),
}


@every_form
@pytest.mark.parametrize("flaw", FLAWS)
@pytest.mark.parametrize("weighting", WEIGHTINGS)
def test_row_23_a_face_without_area_has_no_weight(form, flaw, weighting):
    points, face = FLAWS[flaw]
    sound, flawed = [(0, 1, 2), (0, 2, 3)], [(0, 1, 2), face, (0, 2, 3)]
    observed = polygon_normals(points, *soup(*flawed))
    assert_within(f"23 {flaw}", np.abs(observed[1]), 0.0)
    assert np.array_equal(observed[[0, 2]], polygon_normals(points, *soup(*sound)))
    assert np.array_equal(form(points, *soup(*flawed), weighting), form(points, *soup(*sound), weighting))
    found = diagnose(mesh_of(points, *flawed))
    assert found.degenerate_faces.tolist() == [1]


SIZES = [(1e-30, np.float32), (1e20, np.float32), (1e-30, np.float64), (1e-170, np.float64), (1e-300, np.float64)]
SIZES += [(1e20, np.float64), (1e160, np.float64), (1e300, np.float64)]


@every_form
@pytest.mark.parametrize(
    ("size", "dtype"), SIZES, ids=lambda value: f"24-{value:.0e}" if isinstance(value, float) else np.dtype(value).name
)
def test_row_24_25_tiny_and_huge_edges(form, size, dtype):
    rng = np.random.default_rng(24)
    corners = (triangles_at(rng, 100) * size).astype(dtype)
    mesh = separate(corners)
    errors, _ = face_errors(polygon_normals(*mesh), corners)
    if dtype == np.float32:
        rounded, _ = face_errors(polygon_normals(*mesh).astype(np.float32), corners)
        assert_within(f"24/25 {size:.0e}", rounded, 4 * V)
    assert_within(f"24/25 {size:.0e}", errors, 4 * U)
    for weighting in WEIGHTINGS:
        around, _ = face_errors(form(*mesh, weighting)[::3], corners)
        assert_within(f"24/25 {size:.0e}", around, 4 * U)


@every_form
@pytest.mark.parametrize("weighting", WEIGHTINGS)
@pytest.mark.parametrize("sizes", [(2.0**-500, 1.0, 2.0**500, 2.0**-900), (2.0**900, 2.0**-300)])
def test_faces_of_sizes_1e_300_apart_in_one_mesh(form, weighting, sizes):
    """The points of each tetrahedron have the same normals as in a mesh of their own."""
    alone = np.array([[0.1, 0.2, 0.0], [1.3, 0.1, 0.2], [0.4, 1.1, -0.1], [0.2, 0.3, 0.9]])
    faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    expected = form(alone, *soup(*faces), weighting=weighting)
    points = np.concatenate([alone * size for size in sizes])
    everywhere = [tuple(corner + 4 * copy for corner in face) for copy in range(len(sizes)) for face in faces]
    observed = form(points, *soup(*everywhere), weighting=weighting).reshape(len(sizes), 4, 3)
    bound = 0.0 if form is point_normals else 4 * U  # compiled code delegates all of them to NumPy
    assert np.abs(observed - expected).max() <= bound


@every_form
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("weighting", WEIGHTINGS)
@pytest.mark.parametrize(("size", "dtype"), [(1.0, "f4"), (1.0, "f8"), (2.0**-560, "f8"), (2.0**520, "f8")])
def test_row_26_a_bad_point_spoils_its_own_faces_only_and_is_flagged(form, bad, weighting, size, dtype):
    points, faces = bumpy(12)
    points = (points * size).astype(dtype)
    spoilt = points.copy()
    spoilt[40, 1] = bad
    touched = np.array([40 in face for face in faces])
    observed = polygon_normals(spoilt, *soup(*faces))
    assert_within(f"26 {bad}", np.abs(observed[touched]), 0.0)
    assert np.array_equal(observed[~touched], polygon_normals(points, *soup(*faces))[~touched])
    # A neighbour has the normal of the mesh without the bad faces; no other vertex is affected.
    kept = soup(*(face for face in faces if 40 not in face))
    after = form(spoilt, *soup(*faces), weighting)
    assert np.array_equal(after, form(np.nan_to_num(spoilt), *kept, weighting))
    others = np.setdiff1d(np.arange(len(points)), [corner for face in faces if 40 in face for corner in face])
    assert np.array_equal(after[others], form(points, *soup(*faces), weighting)[others])
    assert not after[40].any()
    assert np.allclose(np.linalg.norm(np.delete(after, 40, axis=0), axis=1), 1.0)
    (fault,) = diagnose(mesh_of(spoilt, *faces)).findings
    assert (fault.name, fault.first, fault.spoils) == ("non_finite_points", (40,), True)


def box(diagonals):
    """Return the unit cube with each side cut into triangles along one of its diagonals."""
    points = np.array(list(product([0.0, 1.0], repeat=3)))
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = []
    for (a, b, c, d), other in zip(sides, diagonals, strict=True):
        faces += [(a, b, d), (b, c, d)] if other else [(a, b, c), (a, c, d)]
    return points, *soup(*faces)


@every_form
def test_row_27_box_corners_however_the_sides_are_cut(form):
    by_angle, by_angle32, by_area = [], [], []
    for diagonals in product([False, True], repeat=6):
        mesh = box(diagonals)
        truth = [exact.unit(exact.exact(2.0 * point - 1.0)) for point in mesh[0]]
        observed = form(*mesh, "angle")
        by_angle += map(exact.distance, observed, truth)
        by_angle32 += map(exact.distance, observed.astype(np.float32), truth)
        by_area += map(exact.distance, form(*mesh, "area"), truth)
    assert_within("27", by_angle, 4 * U)
    assert_within("27", by_angle32, 4 * V)
    assert np.degrees(2 * np.arcsin(max(by_area) / 2)) == pytest.approx(19.47, abs=0.01)


@every_form
@pytest.mark.parametrize("other", [(0, 2, 1), (2, 1, 0), (1, 0, 2)], ids=str)
@pytest.mark.parametrize("weighting", WEIGHTINGS)
def test_row_28_coincident_opposite_faces_cancel_to_zero(form, other, weighting):
    rng = np.random.default_rng(28)
    worst = []
    for triangle in triangles_at(rng, 40) + rng.normal(size=(40, 1, 3)):
        worst.append(np.abs(form(triangle, *soup((0, 1, 2), other), weighting=weighting)).max())
    assert_within(f"28 {other}", worst, 0.0)


def test_row_29_a_non_manifold_edge_keeps_its_points():
    book = mesh_of([(0, 0, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0), (-1, -1, 0)], (0, 2, 1), (0, 3, 1), (0, 4, 1))
    observed = vertex_normals(book)
    assert_within("29", abs(len(observed) - book.n_points), 0.0)
    assert np.isfinite(observed).all()
    assert diagnose(book).non_manifold_edges.tolist() == [[0, 1]]


@every_form
@pytest.mark.parametrize("weighting", WEIGHTINGS)
def test_row_30_weights_that_sum_to_zero_are_guarded(form, weighting):
    observed = form(ROOF, *soup((0, 0, 0), (1, 2, 1)), weighting=weighting)
    assert_within("30", np.abs(observed), 0.0)
    lonely = form(ROOF, *soup((0, 1, 2)), weighting=weighting)
    assert not lonely[3].any()


@every_form
@pytest.mark.parametrize("weighting", WEIGHTINGS)
@pytest.mark.parametrize("offset", [0.0, 1e6], ids=["at-home", "far-out"])
def test_point_normals_against_the_definition(form, weighting, offset):
    """For well-shaped faces, every normal is within 4 roundings of the exact definition."""
    points, faces = bumpy(6)
    points = points + offset
    observed = form(points, *soup(*faces), weighting)
    truth = [exact.point_normal(points, faces, point, weighting) for point in range(len(points))]
    errors = list(map(exact.distance, observed, truth))
    assert_within(f"definition {offset:.0e}", errors, 4 * U)
