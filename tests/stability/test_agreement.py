"""Evaluators agree, and plans keep their promise, hunted for as `properties` says."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from judging import judge
from stability.conditioning import Change, largest_power
from stability.evaluators import BACKENDS, STEPS, Evaluator
from stability.hunting import Promise, blunt, promising_case, smooth_case
from stability.properties import FLATTENING_IS_NO_FAILURE, hunted, on_every_backend
from strategies import Case, hunt, moderate_case

from pvphong import plan
from pvphong.shading import reference
from pvphong.shading.equation import assemble
from pvphong.shading.plan.plan import Plan
from pvphong.shading.result import Shading
from pvphong.shading.vertices import Vertices

pytestmark = FLATTENING_IS_NO_FAILURE

# The oracle's arithmetic takes as many times as long as an evaluator's: so many fewer scenes are judged by it.
EIGHTY_DIGITS = 10


def planned(case, tolerance=0.0):
    vertices = Vertices(case.points, case.normals)
    return Plan.of(case.scene, case.material, vertices, matrix=case.matrix, tolerance=tolerance)


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


@hunted
@on_every_backend
def test_no_scene_exceeds_the_error_that_its_plan_promises(backend: str, examples: int) -> None:
    simplified, nearest = 0, 0.0

    def check(promise: Promise) -> None:
        nonlocal simplified, nearest
        case, tolerance = promise.case, promise.tolerance
        promised = planned(case, tolerance).error_bound
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


@hunted
def test_a_plan_without_tolerance_changes_nothing_but_rounding(examples: int) -> None:
    rewritten = 0

    def check(promise: Promise) -> None:
        nonlocal rewritten
        case = blunt(promise.case)
        equation, original = planned(case).equation, assemble(*case.arguments[2:], case.matrix)
        left, whole = (np.empty((len(case.points), 3)) for _ in range(2))
        for result, run in ((left, equation), (whole, original)):
            reference.shade(case.points, case.normals, run, None, Shading(result))
        rewritten += replace(equation, matrix=None) != replace(original, matrix=None)
        bound = (4 * math.sqrt(largest_power(case)) + 16) * 2.0**-53 * (1 + len(case.scene.lights))
        assert np.abs(left - whole).max() <= bound, f"{np.abs(left - whole).max() / bound}\n{case!r}"

    hunt(promising_case, check, examples)
    assert rewritten > 0.2 * examples
