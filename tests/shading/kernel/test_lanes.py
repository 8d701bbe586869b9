"""Operations of formulas on eight numbers side by side: those of NumPy, to the last bits."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from pvphong.base import formulas
from pvphong.shading import kernel

numba = pytest.importorskip("numba", reason="the extra `fast` is not installed")
if not kernel.is_available():
    pytest.skip("Numba cannot run here", allow_module_level=True)

from numba.core import types  # noqa: E402

from pvphong.shading.kernel.lanes import WIDTH, load, store  # noqa: E402

RANDOM = np.random.default_rng(4)
COUNT = 512 * WIDTH
ANY = RANDOM.normal(size=COUNT) * 10.0 ** RANDOM.integers(-12, 4, COUNT)
OTHER = RANDOM.normal(size=COUNT)
SMALL = RANDOM.uniform(0.0, 1.0, COUNT) ** RANDOM.choice((1, 20), COUNT)
TURNS = RANDOM.uniform(-9.0, 9.0, COUNT)
POWERS = RANDOM.choice((0.0, 0.3, 1.0, 21.0, 1e4), COUNT)
EDGES = np.resize((0.0, 1.0, -1.0, 2.0), COUNT)
# Units in the last place that an operation may be off, or absolute where that is given.
CASES = {
    "sqrt": (formulas.sqrt, (np.abs(ANY),), 0, 0.0),
    "minimum": (formulas.minimum, (ANY, OTHER), 0, 0.0),
    "maximum": (formulas.maximum, (ANY, OTHER), 0, 0.0),
    "nearest": (formulas.nearest, (TURNS,), 0, 0.0),
    "over its size": (formulas.over_its_size, (np.abs(ANY),), 0, 0.0),
    "arctan2": (formulas.arctan2, (ANY, OTHER), 4, 0.0),
    "arctan2 on axes": (formulas.arctan2, (EDGES, np.roll(EDGES, 1)), 1, 0.0),
    "sine": (formulas.sine, (TURNS,), 2, 2.0**-52),
    "cosine": (formulas.cosine, (TURNS,), 2, 2.0**-52),
    "log1p": (formulas.log1p, (SMALL - 0.5 * (SMALL > 0.5),), 4, 0.0),
    "power": (formulas.power_less_one, (SMALL, POWERS), 8, 0.0),
    "power at its ends": (formulas.power_less_one, (np.abs(EDGES), POWERS), 4, 0.0),
}


def on_lanes(operation, *numbers):
    result, pointer = np.empty(COUNT), types.CPointer(types.float64)

    def one(x, out):
        for i in range(0, COUNT, WIDTH):
            store(out, i, operation(load(x, i)))

    def two(x, y, out):
        for i in range(0, COUNT, WIDTH):
            store(out, i, operation(load(x, i), load(y, i)))

    arrays = [*map(np.ascontiguousarray, numbers), result]
    signature = types.void(*(pointer for _ in arrays))
    code = numba.cfunc(signature, nopython=True, error_model="numpy", _nrt=False)(one if len(arrays) == 2 else two)
    ctypes.CFUNCTYPE(None, *(ctypes.c_void_p for _ in arrays))(code.address)(*(x.ctypes.data for x in arrays))
    return result


@pytest.mark.parametrize("case", CASES)
def test_an_operation_on_lanes_is_numpys(case):
    operation, numbers, ulps, absolute = CASES[case]
    with np.errstate(all="ignore"):
        exact = operation(*numbers)
    got = on_lanes(operation, *numbers)
    assert (np.abs(got - exact) <= ulps * np.spacing(np.abs(exact)) + absolute).all()


def test_a_condition_holds_lane_by_lane_and_what_no_lane_needs_is_left_out():
    def halves(x, y):
        found = formulas.where((x < 0.0) | ~(y > 0.0), x, -y)
        if formulas.any_of((x > 1.0) & (y > 1.0)):
            found = found + 1.0
        return found * formulas.largest(abs(y) + 1.0)

    compiled = numba.njit(_nrt=False, error_model="numpy")(halves)
    blocks = [(a, b) for a, b in zip(OTHER.reshape(-1, WIDTH), TURNS.reshape(-1, WIDTH), strict=True)]
    expected = np.concatenate([halves(a, b) for a, b in blocks])
    np.testing.assert_array_equal(on_lanes(compiled, OTHER, TURNS), expected)
