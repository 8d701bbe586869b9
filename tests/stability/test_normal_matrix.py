"""Section A of the catalogue of hard cases: the normal matrix, against elimination in exact fractions."""

from __future__ import annotations

import warnings
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from stability import exact_normals as exact
from stability import naive
from stability.evaluators import EVALUATORS, UNLIT, Declined
from stability.ledger import U, held, record, same_bits

from pvphong import DirectionalLight, Material, PointLight, Scene, SpotLight, Viewer, evaluate
from pvphong.geometry.transform import SingularMatrixWarning, normal_matrix, transform_normals

SAMPLES = 60


def rotation(rng):
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def affine(linear, w=1.0):
    matrix = np.eye(4)
    matrix[:3, :3] = linear
    matrix[:3, 3] = 7.0, -3.0, 2.0
    matrix[3, 3] = w
    return matrix


def stretched(sigmas, seed=0, samples=SAMPLES):
    """Matrices rotation · diag(σ) · rotation, one in three of them a mirror."""
    rng = np.random.default_rng(seed)
    for sample in range(samples):
        mirror = -1.0 if sample % 3 == 0 else 1.0
        yield affine(rotation(rng) @ np.diag(sigmas) @ rotation(rng) * mirror), rng.normal(size=3)


def sheared(k, seed=0, samples=SAMPLES):
    rng = np.random.default_rng(seed)
    for _ in range(samples):
        shear = np.array([[1.0, k, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
        yield affine(rotation(rng) @ shear @ rotation(rng)), rng.normal(size=3)


def judged(cases, transform):
    """Errors and A-tol of a transform of normals: 4u · max(1, ‖|C|·|n|‖ / ‖C·n‖)."""
    errors, bounds = [], []
    for matrix, normal in cases:
        truth = exact.inverse_transpose(matrix)
        errors.append(exact.distance(transform(normal, matrix), exact.unit(exact.apply(truth, normal))))
        bounds.append(4 * U * max(1.0, exact.amplification(truth, normal)))
    return np.array(errors), np.array(bounds)


def ours(normal, matrix):
    return transform_normals([normal], matrix)[0]


def by_inverse(normal, matrix):
    """What everybody writes first."""
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            image = np.linalg.inv(matrix[:3, :3]).T @ normal
        except np.linalg.LinAlgError:
            return np.full(3, np.nan)
        return image / np.sqrt(image @ image)


def by_cofactors(normal, matrix):
    """Cofactors in floating point, with the sign of the determinant that they give."""
    a = matrix[:3, :3]
    with np.errstate(all="ignore"):
        cofactors = np.array([np.cross(a[1], a[2]), np.cross(a[2], a[0]), np.cross(a[0], a[1])])
        image = cofactors @ normal * np.sign(a[0] @ cofactors[0])
        return image / np.sqrt(image @ image)


def largest(powers):
    return [pytest.param(10.0**power, id=f"c=1e+{power}") for power in powers]


@pytest.mark.parametrize("c", largest([2, 4, 8, 12, 16]))
def test_row_1_one_small_singular_value(c):
    record(f"1 c={c:.0e}", "transform_normals", "float64", *judged(stretched([1.0, 1.0, 1.0 / c]), ours))


@pytest.mark.parametrize("c", largest([8, 12, 16]))
def test_row_2_graded_singular_values(c):
    record(f"2 c={c:.0e}", "transform_normals", "float64", *judged(stretched([1.0, c**-0.5, 1.0 / c]), ours))


@pytest.mark.parametrize("c", largest([8, 12, 16]))
def test_row_3_two_tiny_singular_values(c):
    cases = list(stretched([1.0, 1.0 / c, 1.0 / c]))
    record(f"3 c={c:.0e}", "transform_normals", "float64", *judged(cases, ours))
    excess = naive.least_excess(*judged(cases, by_inverse))
    assert excess > 1e-5 * c, "the inverse errs in proportion to c, in every case"


@pytest.mark.parametrize("c", largest([12, 16]))
def test_row_4_no_normal_flips(c):
    cases = list(stretched([1.0, c**-0.5, 1.0 / c], seed=4, samples=200))
    observed, flipped = [], []
    for matrix, normal in cases:
        truth = np.array([float(part) for part in exact.unit(exact.apply(exact.inverse_transpose(matrix), normal))])
        observed.append(ours(normal, matrix) @ truth < 0.0)
        flipped.append(by_cofactors(normal, matrix) @ truth < 0.0)
    record(f"4 c={c:.0e}", "transform_normals", "float64", np.sum(observed), 0.0)
    assert np.mean(flipped) > {1e12: 0.03, 1e16: 0.4}[c], "a floating determinant's sign is noise"


@pytest.mark.parametrize("k", [pytest.param(1e6, id="k=1e+6"), pytest.param(1e12, id="k=1e+12")])
def test_row_5_shear_between_rotations(k):
    cases = list(sheared(k))
    record(f"5 k={k:.0e}", "transform_normals", "float64", *judged(cases, ours))
    errors, bounds = judged(cases, by_inverse)
    assert naive.least_excess(errors, bounds) > 1e-5 * k, "the inverse errs in proportion to k, in every case"
    if k == 1e12:
        assert np.mean(errors > 1.0) > 0.1, "it is refused, or points elsewhere altogether"


@pytest.mark.parametrize("power", [-300, -200, -162, -110, 110, 200, 300], ids=lambda power: f"scale=1e{power:+}")
def test_row_6_uniform_scale_and_rotation(power):
    rng = np.random.default_rng(6)
    cases = [(affine(float(f"1e{power}") * np.eye(3)), rng.normal(size=3)) for _ in range(SAMPLES)]
    errors, bounds = judged(cases, ours)
    assert np.all(bounds == 4 * U)
    record(f"6 1e{power:+}", "transform_normals", "float64", errors, bounds)
    rotated = list(stretched([float(f"1e{power}")] * 3, seed=6))
    record(f"6 1e{power:+} rotated", "transform_normals", "float64", *judged(rotated, ours))
    excess = {transform: naive.least_excess(*judged(rotated, transform)) for transform in (by_cofactors, by_inverse)}
    assert excess[by_cofactors] > 1e15, "squares overflow or underflow: nothing is left of any normal"
    # The inverse's own entries do not overflow; from 1e±162 the squares of its images do.
    assert excess[by_inverse] > 1e15 or abs(power) == 110


@pytest.mark.parametrize("a", [1e10, 1e38, 1e100, 1e150, 1e300], ids=lambda a: f"a={a:.0e}")
def test_row_7_reciprocal_scales(a):
    rng = np.random.default_rng(7)
    normals = [*rng.normal(size=(20, 3)), *np.eye(3), (1.0 / a, 1.0, a), (a, 1.0, 1.0 / a)]
    errors, bounds = judged([(affine(np.diag([a, 1.0, 1.0 / a])), np.array(normal)) for normal in normals], ours)
    assert np.all(bounds == 4 * U)
    record(f"7 a={a:.0e}", "transform_normals", "float64", errors, bounds)


def test_row_8_a_mirror_has_the_inverse_transposes_sign():
    for axis in range(3):
        scale = np.ones(3)
        scale[axis] = -3.0
        truth = exact.inverse_transpose(affine(np.diag(scale)))
        ratios = np.diag(normal_matrix(affine(np.diag(scale)))) / [float(truth[i][i]) for i in range(3)]
        record(f"8 axis {axis}", "normal_matrix", "float64", np.count_nonzero(ratios <= 0.0), 0.0)


FLATTENED = {
    "onto-z=0": (np.diag([1.0, 1.0, 0.0]), [[0, 0, 0], [0, 0, 0], [0, 0, 1]]),
    "onto-x=0": (np.diag([0.0, 2.0, -3.0]), [[-6, 0, 0], [0, 0, 0], [0, 0, 0]]),
    "oblique": ([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]], [[-3, 6, -3], [6, -12, 6], [-3, 6, -3]]),
    "tiny": (1e-170 * np.diag([1.0, 1.0, 0.0]), [[0, 0, 0], [0, 0, 0], [0, 0, 1]]),
}


@pytest.mark.parametrize("case", FLATTENED)
@pytest.mark.parametrize("w", [1.0, -2.0])
def test_row_9_rank_2_gives_the_cofactors_and_warns(case, w):
    linear, cofactors = FLATTENED[case]
    warned = pytest.warns(SingularMatrixWarning, match="flattens space onto a plane")
    with held("warns", f"9 {case} w={w:g}", "normal_matrix", "float64"), warned:
        result = normal_matrix(affine(linear, w))
    assert 0.5 <= np.abs(result).max() <= 1.0
    expected = np.array(cofactors) * (np.abs(result).max() / np.abs(cofactors).max())
    record(f"9 {case} w={w:g}", "normal_matrix", "float64", np.abs(result - expected).max(), 0.0)


ACCEPTING = {
    "normal_matrix": normal_matrix,
    "transform_normals": lambda matrix: transform_normals(np.eye(3), matrix),
    "evaluate": lambda matrix: evaluate(np.eye(3), np.eye(3), Scene(), Material(), matrix=matrix),
}
"""What takes a model matrix and needs its normal matrix."""


@pytest.mark.parametrize(
    ("linear", "message"),
    [
        (np.zeros((3, 3)), "matrix must be a 4x4 matrix that keeps at least two dimensions; got rank <= 1"),
        (np.diag([1.0, 0.0, 0.0]), "rank <= 1"),
        (np.outer([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]), "rank <= 1"),
        (np.diag([1.0, np.nan, 1.0]), "matrix must be a 4x4 matrix of finite numbers"),
        (np.diag([1.0, np.inf, 1.0]), "matrix must be a 4x4 matrix of finite numbers"),
    ],
    ids=["rank-0", "rank-1", "rank-1-oblique", "nan", "inf"],
)
def test_row_10_rank_1_and_nan_are_refused(linear, message):
    for name, transform in ACCEPTING.items():
        with held("raises ValueError", "10", name), pytest.raises(ValueError, match=message):
            transform(affine(linear))


@pytest.mark.parametrize("c", largest([4, 8, 12]))
def test_row_11_the_product_cancels(c):
    """Normals chosen so that C·n nearly cancels: images of a vector in the short directions, pulled back."""
    rng = np.random.default_rng(11)
    cases = []
    for matrix, _ in stretched([1.0, c**-0.5, 1.0 / c], seed=11):
        cases.append((matrix, matrix[:3, :3].T @ rng.normal(size=3)))
    errors, bounds = judged(cases, ours)
    assert np.median(bounds) > 40 * U, "nothing cancels"
    record(f"11 c={c:.0e}", "transform_normals", "float64", errors, bounds)


@pytest.mark.parametrize("last", [(0.0, 0.0, -1.0, 0.0), (1e-3, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 0.0)])
def test_row_12_a_projective_last_row_is_refused(last):
    matrix = affine(np.eye(3))
    matrix[3] = last
    message = r"matrix must be an affine 4x4 matrix, .* got last row .* pass the model"
    for name, transform in ACCEPTING.items():
        with held("raises ValueError", "12", name), pytest.raises(ValueError, match=message):
            transform(matrix)


def test_row_13_a_negative_w_turns_normals_round():
    normals = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -2.0], [0.6, 0.8, 0.0]])
    unit = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.6, 0.8, 0.0]])
    matrix = np.diag([5.0, 5.0, 5.0, -2.0])
    record("13", "transform_normals", "float64", np.abs(transform_normals(normals, matrix) + unit), 0.0)
    assert np.array_equal(normal_matrix(matrix) < 0.0, np.eye(3, dtype=bool))


TO_LIGHT = np.array([0.5, -0.625, 0.75])
MATT = Material(ambient=0.0, diffuse=1.0)
GLOSSY = Material(ambient=0.0, diffuse=0.5, specular=0.5, shininess=20.0)

SCALES = [1e-200, 1e-110, 1e-25, 1e29, 1e110, 1e200]


def reciprocally_scaled(a):
    normals = np.array([(1.0, 1.0, 1.0), *np.eye(3), (1.0 / a, 1.0, a)])
    return [(affine(np.diag([a, 1.0, 1.0 / a])), normal) for normal in normals]


TRANSFORMED = {
    "1 c=1e+16": lambda: stretched([1.0, 1.0, 1e-16], samples=20),
    "2 c=1e+16": lambda: stretched([1.0, 1e-8, 1e-16], samples=20),
    "3 c=1e+16": lambda: stretched([1.0, 1e-16, 1e-16], samples=20),
    "4 c=1e+12": lambda: stretched([1.0, 1e-6, 1e-12], seed=4),
    "4 c=1e+16": lambda: stretched([1.0, 1e-8, 1e-16], seed=4),
    "5 k=1e+12": lambda: sheared(1e12, samples=20),
    **{f"6 {scale:.0e}": partial(stretched, [scale] * 3, samples=20) for scale in SCALES},
    **{f"7 a={a:.0e}": partial(reciprocally_scaled, a) for a in (1e29, 1e38, 1e100, 1e150)},
    "8 mirror": lambda: [(affine(np.diag([1.0, -3.0, 1.0])), normal) for normal in (np.ones(3), *np.eye(3))],
    "11 c=1e+12": lambda: [(m, m[:3, :3].T @ n) for m, n in stretched([1.0, 1e-6, 1e-12], seed=11, samples=20)],
    "13": lambda: [(np.diag([5.0, 5.0, 5.0, -2.0]), normal) for normal in (np.ones(3), *np.eye(3))],
}


def brightness(evaluator, matrix, normal, image):
    """Error of n·l for the side of the surface that the exact, unnormalised `image` of the normal lies on."""
    cosine = exact.dot(exact.unit(image), exact.unit(exact.fractions(TO_LIGHT)))
    light = DirectionalLight(direction=-TO_LIGHT * np.sign(float(cosine)))
    scene = Scene([light], Viewer(), UNLIT)
    return abs(evaluator(np.zeros((1, 3)), normal[None], scene, MATT, matrix=matrix).rgb[0, 0] - abs(float(cosine)))


def computes(row, evaluator):
    """The kernel leaves matrices with entries beyond 2^±100 to the reference."""
    return evaluator.backend == "numpy" or row not in BEYOND_THE_KERNEL


BEYOND_THE_KERNEL = [f"6 {scale:.0e}" for scale in SCALES if not 1e-30 < scale < 1e30]
BEYOND_THE_KERNEL += ["7 a=1e+38", "7 a=1e+100", "7 a=1e+150"]


@pytest.mark.parametrize(
    ("row", "evaluator"),
    [(row, evaluator) for row in TRANSFORMED for evaluator in EVALUATORS if computes(row, evaluator)],
    ids=str,
)
def test_row_as_lit(row, evaluator):
    errors, bounds = [], []
    for matrix, normal in TRANSFORMED[row]():
        truth = exact.inverse_transpose(matrix)
        errors.append(brightness(evaluator, matrix, normal, exact.apply(truth, normal)))
        bounds.append(4 * U * max(1.0, exact.amplification(truth, normal)) + 10 * evaluator.step)
    evaluator.record(row, errors, bounds)


@pytest.mark.parametrize("evaluator", [each for each in EVALUATORS if each.backend == "numba"], ids=str)
@pytest.mark.parametrize("row", BEYOND_THE_KERNEL)
def test_row_as_lit_where_the_kernel_leaves_it_to_the_reference(row, evaluator):
    scene, options = Scene([DirectionalLight(direction=-TO_LIGHT)], Viewer(), UNLIT), {"precision": evaluator.precision}
    for matrix, normal in TRANSFORMED[row]():
        vertex = np.zeros((1, 3)), normal[None], scene, MATT
        with pytest.raises(Declined):
            evaluator(*vertex, matrix=matrix)
        asked, plain = (evaluate(*vertex, matrix=matrix, backend=each, **options).rgb for each in ("numba", "numpy"))
        same_bits(row, "kernel declined", evaluator.precision, asked, plain)


SIZES = [
    (power, grown, evaluator)
    for power in (-664, -365, -97, 97, 365, 664)
    for grown in ("matrix", "points")
    for evaluator in EVALUATORS
    # Beyond 2^±100 the kernel takes neither matrices nor lamps and eyes as far out; it takes any points.
    if evaluator.backend == "numpy" or abs(power) < 100 or (grown == "points" and power < 0)
]


@pytest.mark.parametrize(("power", "grown", "evaluator"), SIZES, ids=str)
def test_row_6_the_size_of_everything_changes_no_bit(power, grown, evaluator):
    """Mesh, lamps and eye grow by a power of two, the mesh by a matrix or as stored, and normals shrink by it."""
    rng = np.random.default_rng(6)
    points, normals = rng.normal(size=(2, 200, 3))

    def lit(size):
        eye, lamp = size * np.array([0.5, -3.0, 2.0]), size * np.array([1.0, 2.0, 3.0])
        spot = SpotLight(position=-lamp, direction=lamp, cone_angle=40.0, exponent=3.0)
        scene = Scene([PointLight(position=lamp), spot], Viewer(position=eye), UNLIT)
        if grown == "points":
            return evaluator(points * size, normals / size, scene, GLOSSY).rgb
        return evaluator(points, normals / size, scene, GLOSSY, matrix=np.diag([size, size, size, 1.0])).rgb

    usual = lit(1.0)
    assert usual.max() > 0.5
    same_bits(f"6 {grown} 2^{power}", evaluator.name, evaluator.precision, lit(2.0**power), usual)


@pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)
@pytest.mark.parametrize("case", [case for case in FLATTENED if case != "tiny"])
def test_row_9_as_lit(case, evaluator):
    linear, cofactors = FLATTENED[case]
    normal = np.array([0.25, -1.0, 2.0])
    with pytest.warns(SingularMatrixWarning):
        error = brightness(evaluator, affine(linear), normal, exact.apply(exact.fractions(cofactors), normal))
    evaluator.record(f"9 {case}", error, 10 * evaluator.step)


def test_the_sign_is_right_on_both_sides_of_a_singular_matrix():
    """diag(1, 1, ε) with ε from −2⁻¹⁰⁷⁴ to 2⁻¹⁰⁷⁴: the z normal follows the sign of ε, whatever a float det says."""
    tiny = 2.0**-1074
    for below, above in pairwise([-1.0, -tiny, tiny, 1.0]):
        signs = [ours([1.0, 0.0, 0.0], affine(np.diag([1.0, 1.0, entry])))[0] for entry in (below, above)]
        assert signs == [1.0, 1.0]
        signs = [ours([0.0, 0.0, 1.0], affine(np.diag([1.0, 1.0, entry])))[2] for entry in (below, above)]
        assert signs == [np.sign(below), np.sign(above)]
