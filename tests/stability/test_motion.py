"""Rotating, translating and mirroring everything, hunted for as `properties` says."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from stability.conditioning import Change
from stability.evaluators import STEPS, Evaluator
from stability.hunting import smooth_case
from stability.properties import FLATTENING_IS_NO_FAILURE, hunted, on_every_backend
from strategies import Case, Dice, hunt, triple

pytestmark = FLATTENING_IS_NO_FAILURE


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
    assert min(worst.values()) > 0.01, f"a bound that nothing comes near proves little: {worst}"
