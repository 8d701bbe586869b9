"""Random scenes: evaluators agree with the oracle and each other, and plans keep their tolerance; see `hunting`."""

from __future__ import annotations

import re
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from judging import FIELDS, judge
from stability.evaluators import STEPS, Declined, Evaluator
from stability.hunting import (
    FLATTENING_IS_NO_FAILURE,
    Promise,
    arrays,
    hunted,
    on_every_backend,
    on_every_evaluator,
    positive_of,
    promising_case,
    rows_of,
    wide_case,
)
from strategies import Case, Dice, hard_case, hunt, moderate_case

from pvphong import Plan, SpotLight, plan
from pvphong.shading.vertices import Vertices

pytestmark = FLATTENING_IS_NO_FAILURE

# The oracle is this many times slower than an evaluator, and checks as many times fewer scenes.
EIGHTY_DIGITS = 10

in_either_convention = pytest.mark.parametrize("convention", ["standard", "vtk"])


def planned(case, tolerance=0.0):
    vertices = Vertices(case.points, case.normals)
    return Plan.of(case.scene, case.material, vertices, matrix=case.matrix, tolerance=tolerance)


@dataclass
class Tally:
    """Statistics of an evaluator's checks by the oracle; `judging` defines the bounds and the exclusions."""

    evaluator: Evaluator
    vertices: int = 0
    left_out: int = 0

    def judge(self, case: Case, **options: float) -> None:
        """Check all arrays of the evaluator. Vertices that are not finite must only leave the others unchanged."""
        finite = np.isfinite(case.points).all(axis=1) & np.isfinite(case.normals).all(axis=1)
        if not finite.any():
            return
        shading = self.evaluator(*case.arguments, **case.options, **self.evaluator.in_full)
        fields = {name: of_oracle for name, of_oracle in FIELDS.items() if getattr(shading, name) is not None}
        kept = SimpleNamespace(**{name: getattr(shading, name)[..., finite, :] for name in fields})
        judgement = judge(rows_of(case, finite), kept, self.evaluator.precision, fields=fields, **options)
        assert judgement.worst <= 1, judgement.report
        self.vertices += judgement.vertices
        self.left_out += judgement.left_out


@hunted
@on_every_evaluator
@in_either_convention
def test_ordinary_scenes_agree_with_the_oracle(evaluator: Evaluator, convention: str, examples: int) -> None:
    tally, examples = Tally(evaluator), 2 * examples // EIGHTY_DIGITS
    hunt(
        lambda dice: moderate_case(dice, convention),
        lambda case: tally.judge(case.stored_in(evaluator.real)),
        examples,
    )
    assert tally.vertices > examples
    assert tally.left_out < 0.05 * tally.vertices


@hunted
@in_either_convention
def test_hard_scenes_agree_with_the_oracle_where_they_are_well_posed(convention: str, examples: int) -> None:
    """Coordinates over 240 binary orders of magnitude, lights of ordinary strength.

    Vertices with a condition number above 10⁶, or in an undecidable band, are excluded.
    """
    tally, examples = Tally(Evaluator("numpy", "float64")), 2 * examples // EIGHTY_DIGITS

    def of_ordinary_strength(light: Any) -> Any:
        light = replace(light, intensity=1.0)
        return replace(light, attenuation=(1.0, 0.25, 0.0)) if hasattr(light, "attenuation") else light

    def throw(dice: Dice) -> Case:
        case = hard_case(dice, convention, reach=120)
        lights = [of_ordinary_strength(light) for light in case.scene.lights]
        return replace(case, scene=replace(case.scene, lights=lights))

    hunt(throw, lambda case: tally.judge(case, badly_posed=1e6), examples)
    assert tally.vertices - tally.left_out > 0.5 * examples


@hunted
@on_every_backend
def test_no_scene_exceeds_the_error_that_its_plan_promises(backend: str, examples: int) -> None:
    simplified, nearest = 0, 0.0

    def check(promise: Promise) -> None:
        nonlocal simplified, nearest
        case, tolerance = promise.case, promise.tolerance
        made = planned(case, tolerance)
        promised = made.error_bound
        assert sum(effect.bound for effect in made.effects.values()) <= promised * (1 + 1e-12)
        assert promised <= tolerance
        of_points = plan(case.points, *case.arguments[2:], matrix=case.matrix, tolerance=tolerance).error_bound
        assert of_points <= tolerance
        exact, quick = (
            Evaluator(which, "float64")(*case.arguments, **case.options, tolerance=allowed).rgb
            for which, allowed in (("numpy", 0.0), (backend, tolerance))
        )
        error = float(np.abs(quick - exact).max())
        assert error <= of_points + 1e-9
        assert error <= promised + 1e-9, f"{error} where {promised} is promised for {tolerance}\n{case!r}"
        simplified += promised > 0.0
        nearest = max(nearest, error / promised if promised > 1e-7 else 0.0)

    hunt(promising_case, check, examples)
    assert simplified > 0.5 * examples
    assert nearest > 0.1, "the bounds are never put to the test"


# --- finite results in any scene ---

# The kernel declines scenes with numbers outside 2^±100.
WITHIN_THE_KERNELS_RANGE = 100

# The only reasons to refuse a scene of finite numbers.
DOCUMENTED = re.compile(
    r"(matrix must be an affine 4x4 matrix|matrix must be a 4x4 matrix that keeps at least two dimensions"
    r"|up must be a direction not parallel to the view axis).*; got ",
    re.DOTALL,
)


@hunted
@on_every_backend
def test_any_scene_gives_finite_colours_or_is_refused(backend: str, examples: int) -> None:
    outcomes: Counter[str] = Counter()

    def throw(dice: Dice) -> tuple[Case, float]:
        reach = 900 if backend == "numpy" else WITHIN_THE_KERNELS_RANGE
        case = wide_case(dice, reach) if dice.likely(50) else hard_case(dice, dice.choice(("standard", "vtk")), reach)
        if backend != "numpy" and dice.likely(95):  # the kernel declines most spots of this brightness
            lights = [replace(s, exponent=0.0) if isinstance(s, SpotLight) else s for s in case.scene.lights]
            case = replace(case, scene=replace(case.scene, lights=lights))
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
    assert outcomes["refused"] < 0.1 * examples, outcomes
    assert outcomes["declined"] <= (0.0 if backend == "numpy" else 0.1) * examples, outcomes
