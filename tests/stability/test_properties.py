"""What must hold for any scene: hunted for in a few scenes in every run, in 100,000 each by `pytest -m long`."""

from __future__ import annotations

import math
import re
import warnings
from collections import Counter
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from judging import judge
from stability.conditioning import Change, largest_power
from stability.evaluators import BACKENDS, STEPS, Declined, Evaluator
from stability.hunting import (
    FEW,
    MANY,
    Promise,
    blunt,
    hunt,
    in_either_type,
    mixed_case,
    positive_of,
    promising_case,
    smooth_case,
    wide_case,
)
from strategies import Case, Dice, moderate_case, triple

from pvphong import DirectionalLight, plan, reference
from pvphong.equation import assemble
from pvphong.planning import make_plan
from pvphong.shading import Shading
from pvphong.transform import SingularMatrixWarning

hunted = pytest.mark.parametrize(
    "examples", [pytest.param(FEW, id="few"), pytest.param(MANY, id="many", marks=pytest.mark.long)]
)
on_every_backend = pytest.mark.parametrize("backend", BACKENDS)

# The oracle's arithmetic takes as many times as long as an evaluator's: so many fewer scenes are judged by it.
EIGHTY_DIGITS = 10

# The kernel declines scenes with numbers further than 2¹⁰⁰ from 1.
WITHIN_THE_KERNELS_RANGE = 45

DOCUMENTED = re.compile(r"^[a-z_]+(\[\d\])? must be .*; got ", re.DOTALL)


@pytest.fixture(autouse=True)
def _flattening_is_no_failure():
    """Every other warning is one: NumPy's about overflow, division by zero and invalid operations."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", SingularMatrixWarning)
        yield


def arrays(shading: Shading) -> dict[str, np.ndarray]:
    found = {name: getattr(shading, name) for name in Shading.__dataclass_fields__}
    return {name: array for name, array in found.items() if array is not None}


def assert_same_bits(got: Shading, expected: Shading, rows: Any = slice(None), of_expected: Any = slice(None)) -> None:
    for name, array in arrays(expected).items():
        ours, theirs = arrays(got)[name][..., rows, :], array[..., of_expected, :]
        assert ours.shape == theirs.shape, name
        bits = [np.ascontiguousarray(a).view(f"u{a.dtype.itemsize}") for a in (ours, theirs)]
        assert np.array_equal(*bits), (
            f"{name} is off by {np.abs(ours - theirs).max():.3g} of {np.abs(theirs).max():.3g}"
        )


# --- (a) finite, in [0, 1], or refused ---


@hunted
@on_every_backend
def test_any_finite_scene_gives_finite_colours_or_is_refused(backend: str, examples: int) -> None:
    outcomes: Counter[str] = Counter()

    def throw(dice: Dice) -> tuple[Case, float]:
        case = wide_case(dice, 1074 if backend == "numpy" else WITHIN_THE_KERNELS_RANGE)
        return case, positive_of(dice) if dice.likely(50) else 0.0

    def check(drawn: tuple[Case, float]) -> None:
        outcome = "declined"
        for precision in STEPS:
            with suppress(Declined):
                outcome = judged(Evaluator(backend, precision), *drawn)
        outcomes[outcome] += 1

    def judged(evaluator: Evaluator, case: Case, tolerance: float) -> str:
        try:
            shading = evaluator(*case.arguments, **case.options, tolerance=tolerance, **evaluator.in_full)
        except ValueError as error:
            if not DOCUMENTED.match(str(error)):
                raise
            return "refused"
        for name, array in arrays(shading).items():
            assert np.isfinite(array).all(), name
            assert (array >= 0.0).all(), name
        assert not case.scene.light_model.clamp or (shading.rgb <= 1.0).all()
        return "lit" if shading.rgb.any() else "black"

    hunt(throw, check, examples)
    assert outcomes["lit"] > 0.4 * examples, outcomes
    assert outcomes["refused"] < 0.3 * examples, outcomes
    assert outcomes["declined"] < 0.3 * examples, outcomes


# --- (b) no unit of length ---


def in_other_units(case: Case, k: int, m: int) -> Case:
    """The same scene with lengths in units of 2^-k, and normals 2^m as long."""

    def far(vector: Any) -> Any:
        return triple(np.ldexp(np.asarray(vector, dtype=float), k))

    def light(old: Any) -> Any:
        if isinstance(old, DirectionalLight):
            return replace(old, direction=triple(np.ldexp(np.array(old.direction), m)))
        constant, linear, quadratic = old.attenuation
        attenuation = (constant, math.ldexp(linear, -k), math.ldexp(quadratic, -2 * k))
        return replace(old, position=far(old.position), attenuation=attenuation)

    scene = case.scene
    viewer = replace(scene.viewer, position=far(scene.viewer.position), focal_point=far(scene.viewer.focal_point))
    matrix = case.matrix
    if matrix is not None:
        matrix = matrix.copy()
        matrix[:3, 3] = np.ldexp(matrix[:3, 3], k)
    return replace(
        case,
        points=np.ldexp(case.points, k),
        normals=np.ldexp(case.normals, m),
        scene=replace(scene, lights=[light(old) for old in scene.lights], viewer=viewer),
        matrix=matrix,
    )


def _in_range(case: Case, reach: int) -> Case:
    """Attenuations and intensities no further from 1 than 2^reach."""

    def within(value: float) -> float:
        return min(max(value, 2.0**-reach), 2.0**reach) if value else 0.0

    def light(old: Any) -> Any:
        old = replace(old, intensity=within(old.intensity))
        if isinstance(old, DirectionalLight):
            return old
        return replace(old, attenuation=tuple(within(a) for a in old.attenuation))

    return replace(case, scene=replace(case.scene, lights=[light(old) for old in case.scene.lights]))


def _with_units(dice: Dice, backend: str) -> tuple[Case, int, int, str]:
    """A case, powers of two for lengths and for normals, and a precision.

    In float32 no way from a vertex to a light is 2^100 times as long as it is along one of the axes, or the least
    floats would round it. Normals change their length only where no product with one comes near the least float.
    """
    precision = dice.choice(("float32", "float64"))
    reach = 150 if backend == "numpy" and precision == "float64" else 25
    case = _in_range(mixed_case(dice, reach), 3 * reach)
    sizes = np.abs(np.concatenate([case.points, case.normals]))
    ordinary = bool(np.isin(np.frexp(sizes[sizes != 0.0])[1], range(-20, 20)).all())
    return case, dice.randint(-reach, reach), dice.randint(-60, 60) if ordinary else 0, precision


@hunted
@on_every_backend
def test_no_unit_of_length_is_special(backend: str, examples: int) -> None:
    compared = 0

    def check(drawn: tuple[Case, int, int, str]) -> None:
        nonlocal compared
        case, k, m, precision = drawn
        evaluator = Evaluator(backend, precision)
        with suppress(Declined):
            expected = evaluator(*case.arguments, **case.options, **evaluator.in_full)
            other = in_other_units(case, k, m)
            assert_same_bits(evaluator(*other.arguments, **other.options, **evaluator.in_full), expected)
            compared += 1

    hunt(lambda dice: _with_units(dice, backend), check, examples)
    assert compared > 0.5 * examples


# --- (c) every vertex by itself ---


def _strided(a: np.ndarray) -> np.ndarray:
    wide = np.full((2 * len(a), a.shape[1] + 2), 7.0, a.dtype)
    wide[::2, 1:-1] = a
    return wide[::2, 1:-1]


def _read_only(a: np.ndarray) -> np.ndarray:
    copy = a.copy()
    copy.setflags(write=False)
    return copy


def _unaligned(a: np.ndarray) -> np.ndarray:
    return np.frombuffer(b"\0" + a.tobytes(), dtype=a.dtype, offset=1).reshape(a.shape)


LAYOUTS = {
    "by columns": np.asfortranarray,
    "strided": _strided,
    "backwards": lambda a: a[::-1].copy()[::-1],
    "read-only": _read_only,
    "unaligned": _unaligned,
    "swapped bytes": lambda a: a.astype(a.dtype.newbyteorder()),
}


def _with_rows(dice: Dice) -> tuple[Case, np.ndarray, str]:
    """A case, rows in another order with some left out and some twice, and a layout."""
    case = in_either_type(dice, mixed_case(dice))
    rows = np.array(dice.choices(range(len(case.points)), k=dice.randint(1, 60)))
    return case, rows, dice.choice(list(LAYOUTS))


@hunted
@on_every_backend
def test_order_selection_and_layout_change_no_bit(backend: str, examples: int) -> None:
    compared = 0

    def check(drawn: tuple[Case, np.ndarray, str]) -> None:
        nonlocal compared
        case, rows, layout = drawn
        evaluator = Evaluator(backend, "float32" if len(rows) % 2 else "float64")
        albedo = None if case.albedo is None else case.albedo[rows]
        some = replace(case, points=case.points[rows], normals=case.normals[rows], albedo=albedo)
        laid = replace(case, **{name: LAYOUTS[layout](getattr(case, name)) for name in ("points", "normals")})
        with suppress(Declined):
            whole = evaluator(*case.arguments, **case.options, **evaluator.in_full)
            assert_same_bits(evaluator(*laid.arguments, **laid.options, **evaluator.in_full), whole)
            assert_same_bits(evaluator(*some.arguments, **some.options, **evaluator.in_full), whole, of_expected=rows)
            compared += 1

    hunt(_with_rows, check, examples)
    assert compared > 0.5 * examples


# --- (d) rotating, translating, mirroring everything ---


class _Isometry(NamedTuple):
    """An orthogonal matrix of integers over a common denominator, an offset, and the matrix's determinant."""

    rows: list[list[int]]
    denominator: int
    offset: tuple[float, float, float]
    side: int

    def of_vector(self, vector: Any) -> tuple[float, ...]:
        return self.of_point(vector, (0.0, 0.0, 0.0))

    def of_point(self, point: Any, offset: Any = None) -> tuple[float, ...]:
        """The exact image, every coordinate rounded once: Python divides integers like that."""
        ratios = [float(x).as_integer_ratio() for x in (*point, *(self.offset if offset is None else offset))]
        common = max(below for _, below in ratios)
        x, y, z, *shifts = (above * (common // below) for above, below in ratios)
        below = self.denominator * common
        rows = zip(self.rows, shifts, strict=True)
        return tuple((a * x + b * y + c * z + self.denominator * shift) / below for (a, b, c), shift in rows)


def _isometry(dice: Dice) -> _Isometry:
    """By a quaternion of integers, and a mirror for every third."""
    a, b, c, d = (*(dice.randint(-99, 99) for _ in range(3)), dice.randint(1, 99))
    side = dice.choice((1, 1, -1))
    rows = [
        [side * (a * a + b * b - c * c - d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [side * 2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
        [side * 2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
    ]
    offset = triple(dice.vector() * dice.choice((0.0, dice.log_between(1e-3, 1e6))))
    return _Isometry(rows, a * a + b * b + c * c + d * d, offset, side)


def _moved(case: Case, motion: _Isometry) -> Case:
    """Mesh, lights and viewer in another place; a mirror swaps left and right in eye space."""

    def light(old: Any) -> Any:
        changed = {}
        for name, move in (("position", motion.of_point), ("direction", motion.of_vector)):
            if hasattr(old, name):
                x, y, z = getattr(old, name)
                changed[name] = (motion.side * x, y, z) if old.frame == "camera" else move((x, y, z))
        return replace(old, **changed)

    scene, viewer = case.scene, case.scene.viewer
    places = {name: motion.of_point(getattr(viewer, name)) for name in ("position", "focal_point")}
    viewer = replace(viewer, **places, up=motion.of_vector(viewer.up))
    return replace(
        case,
        points=np.array([motion.of_point(p) for p in case.points]),
        normals=np.array([motion.of_vector(n) for n in case.normals]),
        scene=replace(scene, lights=[light(old) for old in scene.lights], viewer=viewer),
    )


def _with_motion(dice: Dice) -> tuple[Case, Case]:
    case = smooth_case(dice)
    return case, _moved(case, _isometry(dice))


@hunted
@on_every_backend
def test_moving_everything_changes_colours_by_rounding_only(backend: str, examples: int) -> None:
    worst, vertices, left_out = Counter(dict.fromkeys(STEPS, 0.0)), 0, 0

    def check(drawn: tuple[Case, Case]) -> None:
        nonlocal vertices, left_out
        change = Change(*drawn)
        for precision, step in STEPS.items():
            here, there = (Evaluator(backend, precision)(*c.arguments).rgb.astype(float) for c in drawn)
            judged = change.decidable(step)
            ratio = np.abs(here - there).max(axis=1) / change.bound(step) * judged
            worst[precision] = max(worst[precision], float(ratio.max()))
            vertices, left_out = vertices + len(judged), left_out + int(np.count_nonzero(~judged))
            assert (ratio <= 1.0).all(), f"{ratio.max():.3g} times the bound in {precision}\n{drawn!r}"

    hunt(_with_motion, check, examples)
    assert left_out < 0.1 * vertices
    assert min(worst.values()) > 0.001, f"a bound that nothing comes near proves little: {worst}"


# --- (e) one spoiled vertex ---

SPOILS: list[tuple[str, Any]] = [
    ("points", np.nan), ("points", np.inf), ("points", -np.inf), ("points", 1e308),
    ("normals", np.nan), ("normals", np.inf), ("normals", 0.0), ("normals", 1e308), ("albedo", np.nan),
]  # fmt: skip


def _with_spoil(dice: Dice) -> tuple[Case, Case, int]:
    case = in_either_type(dice, mixed_case(dice))
    if case.albedo is None:
        case = replace(case, albedo=np.ones_like(case.points))
    row = dice.randrange(len(case.points))
    name, value = dice.choice(SPOILS)
    spoiled = np.array(getattr(case, name))
    with np.errstate(over="ignore"):
        spoiled[row, dice.choice((0, 1, 2, slice(None)))] = value
    return case, replace(case, **{name: spoiled}), row


@hunted
@on_every_backend
def test_a_spoiled_vertex_leaves_the_others_bits_alone(backend: str, examples: int) -> None:
    compared = 0

    def check(drawn: tuple[Case, Case, int]) -> None:
        nonlocal compared
        case, spoiled, row = drawn
        evaluator = Evaluator(backend, "float32" if row % 2 else "float64")
        others = np.arange(len(case.points)) != row
        with suppress(Declined):
            before, after = (evaluator(*c.arguments, **c.options, **evaluator.in_full) for c in (case, spoiled))
            assert_same_bits(after, before, others, others)
            for name, array in arrays(after).items():
                assert np.isfinite(array[..., row, :]).all(), name
            compared += 1

    hunt(_with_spoil, check, examples)
    assert compared > 0.5 * examples


# --- (f) evaluators agree ---


@hunted
@pytest.mark.parametrize("backend", BACKENDS[1:])
def test_every_backend_agrees_with_the_reference(backend: str, examples: int) -> None:
    def check(case: Case) -> None:
        exact, change = Evaluator("numpy", "float64")(*case.arguments).rgb, Change(case, case)
        for precision, step in STEPS.items():
            error = np.abs(Evaluator(backend, precision)(*case.arguments).rgb - exact).max(axis=1)
            ratio = error / (0.5 * change.bound(step)) * change.decidable(step)  # half: the bound is for two that err
            assert (ratio <= 1.0).all(), f"{ratio.max():.3g} times the bound in {precision}\n{case!r}"

    hunt(smooth_case, check, examples)


@hunted
@pytest.mark.parametrize("precision", STEPS)
@pytest.mark.parametrize("convention", ["standard", "vtk"])
@pytest.mark.parametrize("backend", BACKENDS[1:])
def test_every_backend_agrees_with_the_oracle(backend: str, convention: str, precision: str, examples: int) -> None:
    """With matrices, albedo, both conventions and low powers, which the property above leaves out."""
    judged = 0

    def check(case: Case) -> None:
        nonlocal judged
        stored = case.stored_in(evaluator.real)
        colors = evaluator(*stored.arguments, **stored.options)
        judgement = judge(stored, colors, precision, fields={"rgb": "color"})
        assert judgement.worst <= 1, judgement.report
        judged += judgement.vertices - judgement.left_out

    evaluator = Evaluator(backend, precision)
    hunt(lambda dice: moderate_case(dice, convention), check, examples // EIGHTY_DIGITS)
    assert judged > examples // EIGHTY_DIGITS


# --- (g) what a plan promises ---


@hunted
def test_no_scene_exceeds_the_error_that_its_plan_promises(examples: int) -> None:
    simplified, nearest = 0, 0.0

    def check(promise: Promise) -> None:
        nonlocal simplified, nearest
        case, tolerance = promise.case, promise.tolerance
        promised = make_plan(*case.arguments, case.matrix, tolerance).error_bound
        assert promised <= tolerance
        assert plan(case.points, *case.arguments[2:], matrix=case.matrix, tolerance=tolerance).error_bound <= tolerance
        exact, quick = (
            Evaluator("numpy", "float64")(*case.arguments, **case.options, tolerance=allowed).rgb
            for allowed in (0.0, tolerance)
        )
        error = float(np.abs(quick - exact).max())
        assert error <= promised + 1e-9, f"{error} where {promised} is promised for {tolerance}\n{case!r}"
        simplified += promised > 0.0
        nearest = max(nearest, error / promised if promised > 1e-7 else 0.0)

    hunt(promising_case, check, examples)
    assert simplified > 0.5 * examples
    assert nearest > 0.1, "the bounds are never put to the test"


@hunted
def test_a_plan_without_tolerance_changes_nothing_but_rounding(examples: int) -> None:
    rewritten = 0

    def check(promise: Promise) -> None:
        nonlocal rewritten
        case = blunt(promise.case)
        planned, unplanned = (np.empty((len(case.points), 3)) for _ in range(2))
        equation, original = (
            make_plan(*case.arguments, case.matrix, 0.0).equation,
            assemble(*case.arguments[2:], case.matrix),
        )
        for result, run in ((planned, equation), (unplanned, original)):
            reference.shade(case.points, case.normals, run, None, Shading(result))
        rewritten += replace(equation, matrix=None) != replace(original, matrix=None)
        bound = (4 * math.sqrt(largest_power(case)) + 16) * 2.0**-53 * (1 + len(case.scene.lights))
        assert np.abs(planned - unplanned).max() <= bound, f"{np.abs(planned - unplanned).max() / bound}\n{case!r}"

    hunt(promising_case, check, examples)
    assert rewritten > 0.2 * examples
