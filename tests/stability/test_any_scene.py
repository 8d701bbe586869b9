"""What any scene gives, hunted for as `hunting` says."""

from __future__ import annotations

import re
from collections import Counter
from contextlib import suppress
from dataclasses import replace

import numpy as np
from stability.evaluators import STEPS, Declined, Evaluator
from stability.hunting import FLATTENING_IS_NO_FAILURE, arrays, hunted, on_every_backend, positive_of, wide_case
from strategies import Case, Dice, hard_case, hunt

from pvphong import SpotLight

pytestmark = FLATTENING_IS_NO_FAILURE

# The kernel declines scenes with numbers further than 2¹⁰⁰ from 1.
WITHIN_THE_KERNELS_RANGE = 100

# All that a scene of finite numbers may be refused for.
DOCUMENTED = re.compile(
    r"(matrix must be an affine 4x4 matrix|matrix must be a 4x4 matrix that keeps at least two dimensions"
    r"|up must be off the view axis).*; got ",
    re.DOTALL,
)


@hunted
@on_every_backend
def test_any_scene_gives_finite_colours_or_is_refused(backend: str, examples: int) -> None:
    outcomes: Counter[str] = Counter()

    def throw(dice: Dice) -> tuple[Case, float]:
        reach = 900 if backend == "numpy" else WITHIN_THE_KERNELS_RANGE
        case = wide_case(dice, reach) if dice.likely(50) else hard_case(dice, dice.choice(("standard", "vtk")), reach)
        if backend != "numpy" and dice.likely(95):  # the kernel declines spots as bright as these mostly are
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
