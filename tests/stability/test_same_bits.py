"""Invariances to the bit, tested with random scenes; see `hunting`.

Colours do not depend on the unit of length, nor on order, selection, layout and values of other vertices.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
from stability.evaluators import Declined, Evaluator
from stability.hunting import (
    FLATTENING_IS_NO_FAILURE,
    LAYOUTS,
    arrays,
    assert_same_bits,
    hunted,
    in_either_type,
    mixed_case,
    on_every_backend,
    rows_of,
)
from strategies import Case, Dice, hunt, triple

from pvphong import DirectionalLight

pytestmark = FLATTENING_IS_NO_FAILURE

# --- unit of length ---


def in_other_units(case: Case, k: int, m: int) -> Case:
    """Return the scene with lengths in units of 2^-k, and normals scaled by 2^m."""

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


def _loses_no_bit(case: Case, other: Case, k: int, m: int) -> bool:
    """Return True if scaling is reversible: the smallest floats may have been rounded."""
    back = in_other_units(other, -k, -m)
    return back.scene == case.scene and all(
        np.array_equal(getattr(back, name), getattr(case, name), equal_nan=True)
        for name in ("points", "normals", "matrix")
        if getattr(case, name) is not None
    )


def _in_range(case: Case, reach: int, least: float) -> Case:
    """Limit attenuations and intensities to 2^±reach, and coordinates of lights to at least `least`.

    The limit also applies to a normal's components, relative to its largest. Subnormal numbers and their products are
    rounded to the smallest float, which may decide whether n·l is 0.
    """

    def within(value: float) -> float:
        return min(max(value, 2.0**-reach), 2.0**reach) if value else 0.0

    def light(old: Any) -> Any:
        old = replace(old, intensity=within(old.intensity))
        if isinstance(old, DirectionalLight):
            return old
        position = triple(np.where(np.abs(old.position) < least, 0.0, old.position))
        return replace(old, position=position, attenuation=tuple(within(a) for a in old.attenuation))

    sizes = np.abs(case.normals)
    with np.errstate(invalid="ignore", under="ignore"):
        normals = np.where(sizes < least * sizes.max(axis=1, keepdims=True), 0.0, case.normals)
    scene = replace(case.scene, lights=[light(old) for old in case.scene.lights])
    return replace(case, normals=normals.astype(case.normals.dtype), scene=scene)


def _with_units(dice: Dice, backend: str) -> tuple[Case, int, int, str]:
    """Draw a case, powers of two for lengths and for normals, and a precision.

    In float32 no vector from a vertex to a light is 2^100 times longer than one of its components, because the smallest
    floats would round it. Normals are scaled only if no product with them comes near the smallest float.
    """
    precision = dice.choice(("float32", "float64"))
    reach = 150 if backend == "numpy" and precision == "float64" else 25
    least = 2.0**-1000 if precision == "float64" else 2.0**-100
    case = _in_range(mixed_case(dice, reach), 3 * reach, least)
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
        evaluator, other = Evaluator(backend, precision), in_other_units(case, k, m)
        if not _loses_no_bit(case, other, k, m):
            return
        with suppress(Declined):
            expected = evaluator(*case.arguments, **case.options, **evaluator.in_full)
            assert_same_bits(evaluator(*other.arguments, **other.options, **evaluator.in_full), expected)
            compared += 1

    hunt(lambda dice: _with_units(dice, backend), check, examples)
    assert compared > 0.5 * examples


# --- independence of vertices ---


SPOILS: list[tuple[str, Any]] = [
    ("points", np.nan), ("points", np.inf), ("points", -np.inf), ("points", 1e308),
    ("normals", np.nan), ("normals", np.inf), ("normals", 0.0), ("normals", 1e308), ("albedo", np.nan),
]  # fmt: skip


def _spoiled(dice: Dice, case: Case) -> Case:
    name, value = dice.choice(SPOILS)
    if name == "albedo" and case.albedo is None:
        case = replace(case, albedo=np.ones_like(case.points))
    spoiled = np.array(getattr(case, name))
    with np.errstate(over="ignore"):
        spoiled[dice.randrange(len(spoiled)), dice.choice((0, 1, 2, slice(None)))] = value
    return replace(case, **{name: spoiled})


def _with_rows(dice: Dice) -> tuple[Case, np.ndarray, str]:
    """Draw a case, usually with a spoiled vertex, a reordered selection of rows with repetitions, and a layout."""
    case = in_either_type(dice, mixed_case(dice))
    case = _spoiled(dice, case) if dice.likely(70) else case
    rows = np.array(dice.choices(range(len(case.points)), k=dice.choice((dice.randint(1, 60), dice.randint(128, 300)))))
    return case, rows, dice.choice(list(LAYOUTS))


@hunted
@on_every_backend
def test_order_selection_and_layout_change_no_bit(backend: str, examples: int) -> None:
    compared = 0

    def check(drawn: tuple[Case, np.ndarray, str]) -> None:
        nonlocal compared
        case, rows, layout = drawn
        evaluator = Evaluator(backend, "float32" if len(rows) % 2 else "float64")
        some = rows_of(case, rows)
        given = {name: getattr(case, name) for name in ("points", "normals", "albedo")}
        laid = replace(case, **{name: LAYOUTS[layout](array) for name, array in given.items() if array is not None})
        with suppress(Declined):
            whole = evaluator(*case.arguments, **case.options, **evaluator.in_full)
            assert_same_bits(evaluator(*laid.arguments, **laid.options, **evaluator.in_full), whole)
            assert_same_bits(evaluator(*some.arguments, **some.options, **evaluator.in_full), whole, of_expected=rows)
            assert all(np.isfinite(array).all() for array in arrays(whole).values())
            compared += 1

    hunt(_with_rows, check, examples)
    assert compared > 0.5 * examples
