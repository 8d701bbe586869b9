"""Checks return the canonical value, or raise ValueError with the name, value, allowed values and remedy."""

import math
import re
from fractions import Fraction
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
import vtk
from hypothesis import given, settings
from hypothesis import strategies as st

from pvphong.base import check

NAN, INF = math.nan, math.inf
FRAMES = ("world", "camera")
CALLS = {
    "number": partial(check.number, "x"),
    "flag": partial(check.flag, "on"),
    "choice": partial(check.choice, "frame", allowed=FRAMES),
    "text": partial(check.text, "name"),
    "vector": partial(check.vector, "position"),
    "direction": partial(check.direction, "direction"),
    "color": partial(check.color, "diffuse"),
    "array": partial(check.array, "points"),
    "matrix4": partial(check.matrix4, "matrix"),
}


def every(table):
    """Parametrize over the single values of a table with rows of check, values and outcome."""
    rows = [(name, value, outcome) for name, values, outcome in table for value in values]
    return pytest.mark.parametrize(("name", "value", "outcome"), rows)


# --- the message ---


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("size", -1, "a number > 0", "Double it."), "size must be a number > 0; got -1. Double it."),
        (("size", repr("small"), "big"), "size must be big; got 'small'."),
        (("name", "x" * 10_000, "short"), f"name must be short; got {79 * 'x'}…."),
        (("path", Path("/home") / ("deep/" * 30), "a file"), f"path must be a file; got /home{30 * '/deep'}."),
    ],
    ids=["remedy", "no remedy", "long value", "path to its end"],
)
def test_a_refusal_names_argument_value_allowed_and_remedy(arguments, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        check.refuse(*arguments)


# --- accepted values ---

TAKEN = [
    ("number", [2, 2.5, Fraction(5, 2), np.float16(2.5), np.float32(0.1), np.longdouble(2), np.uint8(7), -0.0], float),
    ("flag", [True, False, np.True_, np.False_], bool),
    ("choice", FRAMES, str),
    ("text", ["", "sun", "Lämpchen ☀"], str),
    ("vector", [(1, 2.5, -3), [1, 2.5, -3]], (1.0, 2.5, -3.0)),
    ("vector", [wrap([1, 2.5, -3]) for wrap in (np.array, np.float16, pv.pyvista_ndarray)], (1.0, 2.5, -3.0)),
    ("direction", [(0, 0, -1e-320)], (0.0, 0.0, -1e-320)),  # of any length
    ("direction", [(3e300, 0, 4)], (3e300, 0.0, 4.0)),
    ("color", [0, 1, 2.5], float),
    ("color", ["white", (1, 1, 1)], (1.0, 1.0, 1.0)),
    ("color", ["red", "r", (1, 0, 0), pv.Color("red")], (1.0, 0.0, 0.0)),
    ("color", ["tomato"], (255 / 255, 99 / 255, 71 / 255)),  # CSS: #ff6347
    ("color", ["#804020", "0x804020"], (128 / 255, 64 / 255, 32 / 255)),
    ("color", [(1, 0.5, 0.25)], (1.0, 0.5, 0.25)),
    ("color", [np.array([0.5, 2, 3])], (0.5, 2.0, 3.0)),
    ("color", [[2.0, 300.0, 0.0]], (2.0, 300.0, 0.0)),
]


def is_just(found, expected):
    """Return True if values are equal bit for bit, including the sign of zero, with Python's own types."""
    assert repr(found) == repr(expected)
    assert type(found) is type(expected)
    if isinstance(found, tuple):
        assert {type(item) for item in found} == {float}


@every(TAKEN)
def test_what_is_allowed_comes_in_its_canonical_form(name, value, outcome):
    is_just(CALLS[name](value), outcome(value) if isinstance(outcome, type) else outcome)


@settings(max_examples=60, derandomize=True, deadline=None, database=None)
@given(st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 3))
def test_every_finite_float_is_kept_to_the_bit(values):
    is_just(check.number("x", values[0]), values[0])
    is_just(check.vector("position", list(values)), values)
    shades = tuple(map(abs, values))
    is_just(check.color("diffuse", list(shades)), shades)
    is_just(check.color("diffuse", shades[0]), shades[0])


@pytest.mark.parametrize(
    ("bounds", "inside", "outside", "said"),
    [
        ({"at_least": 0}, 0.0, -5e-324, ">= 0"),
        ({"above": 0}, 5e-324, 0.0, "> 0"),
        ({"at_most": 90}, 90.0, math.nextafter(90, 91), "<= 90"),
        ({"at_least": 0, "at_most": 90}, 90, 91, ">= 0 and <= 90"),
        ({"above": 0, "at_most": 90}, 45, 0, "> 0 and <= 90"),
    ],
)
def test_bounds_of_a_number_are_exact_and_told(bounds, inside, outside, said):
    assert check.number("angle", inside, **bounds) == inside
    with pytest.raises(ValueError, match=rf"^angle must be a finite number {said}; got .* Turn it\.$"):
        check.number("angle", outside, **bounds, remedy="Turn it.")


# --- refused values ---

NO_NUMBERS = [np.float32("nan"), 10**400, True, np.True_, "1", b"1", None, 1j, np.complex128(1), [1], np.array(1.0)]
NO_NUMBERS += [NAN, INF, -INF, np.timedelta64(5, "s"), object()]
NO_VECTORS = [(1, 2), (1, 2, 3, 4), "123", b"123", 5, None, {1, 2, 3}, np.eye(3), np.array(3.0), np.ones((1, 3)), []]
NO_COLORS = [(), (1.0,), (1.0, 0.5), (0.1,) * 5, np.eye(3), np.array(0.5), b"red"]
NO_SHADES = [-1, -1e-300, NAN, INF, None, {}, 1j]
NO_TRIPLES = [(1.0, -0.1, 0), (0, NAN, 0), (1.0, "0", "0"), (True, False, True), np.array([True] * 3)]
NO_ROWS = [np.zeros((4, 2)), np.zeros((4, 4)), np.zeros(3), np.zeros((2, 2, 3)), 5.0, [], [[1, 2, 3], [4, 5]], None]
NO_ROWS += ["points", [["a", "b", "c"]], *(np.zeros((2, 3), kind) for kind in (complex, bool, object, "datetime64[s]"))]
NO_MATRICES = [np.eye(3), np.eye(4)[:3], np.zeros(16), 1.0, None, "eye", [["a"] * 4] * 4, [[1, 2], [3]]]
NO_MATRICES += [np.eye(4, dtype=complex), np.eye(4, dtype=bool)]
NOT_FINITE = [np.diag([1, bad, 1, 1]) for bad in (NAN, INF, -INF)]
REFUSED = [
    ("number", NO_NUMBERS, "x must be a finite number; got "),
    ("flag", [0, 1, "yes", None, np.array([True])], "on must be True or False; got "),
    ("choice", ["zzz", "", None, 3, ["camera"]], r"frame must be one of 'world', 'camera'; got [^?]*$"),
    ("choice", ["Camera", "camra", "cameras"], r"frame must be one of .*; got (?i:cam)\w+\. Did you mean 'camera'\?"),
    ("text", [None, 3, b"sun", ["sun"]], "name must be a string; got "),
    ("vector", NO_VECTORS, "position must be 3 finite numbers; got "),
    ("vector", [(0, bad, 0) for bad in (NAN, INF, "x", None, True, 1j)], r"position\[1\] must be a finite number; "),
    ("direction", [(0, 0, 0), (0.0, -0.0, 0.0), np.zeros(3)], "direction must be a direction, .*not all zero; got "),
    ("color", [(255, 128, 0), [0, 0, 2], np.uint8([255, 0, 0]), (255, 0, 0, 255), (True, 5, 1)],
     r"diffuse must be .*; got .*0-255 values: divide them by 255\.$"),
    ("color", [(1.0, 0.5, 0.0, 1.0)], "diffuse must be .* Leave out the fourth number"),
    ("color", ["no such colour", "#12g456", "", "#"], r"diffuse must be .*hex string; got .*pyvista\.hex_colors"),
    ("color", ["Oragne", "ornage"], r"diffuse must be .*hex string; got .*\. Did you mean 'orange'"),
    ("color", NO_COLORS, "diffuse must be a number >= 0, three numbers"),
    ("color", NO_SHADES, "diffuse must be a finite number >= 0; got "),
    ("color", NO_TRIPLES, r"diffuse\[[01]\] must be a finite number >= 0; got "),
    ("array", NO_ROWS, r"points must be an \(n, 3\) array of real numbers; got "),
    ("matrix4", NO_MATRICES, "matrix must be a 4x4 matrix of real numbers; got "),
    ("matrix4", NOT_FINITE, "matrix must be a 4x4 matrix of finite numbers; got "),
]  # fmt: skip


@every(REFUSED)
def test_what_is_not_allowed_is_refused_by_name(name, value, outcome):
    with pytest.raises(ValueError, match=f"^{outcome}"):
        CALLS[name](value)


def test_an_array_of_another_length_tells_both():
    with pytest.raises(ValueError, match=r"^normals must be .* one row per point, 5 rows; got 4 rows\.$"):
        check.array("normals", np.zeros((4, 3)), count=5)


# --- arrays and matrices ---

NUMBERS = np.arange(12).reshape(4, 3)


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_arrays_of_floats_are_passed_on_without_a_copy(real):
    rows = NUMBERS.astype(real)[::2, ::-1]
    assert np.shares_memory(check.array("points", rows), rows)


@pytest.mark.parametrize("kind", ["f2", "longdouble", "i1", "i8", "u1", "u8", ">f8", ">f4", list])
def test_arrays_of_other_reals_are_widened_and_brought_into_this_machines_byte_order(kind):
    result = check.array("points", NUMBERS.tolist() if kind is list else NUMBERS.astype(kind))
    assert result.dtype == (np.float32 if kind == ">f4" else np.float64)
    assert result.dtype.isnative
    np.testing.assert_array_equal(result, NUMBERS)
    assert check.array("points", np.empty((0, 3), None if kind is list else kind)).shape == (0, 3)


@pytest.mark.parametrize("checked", [check.array, check.matrix4])
def test_masked_entries_are_refused_and_a_mask_of_none_is_not(checked):
    rows = np.ma.array(np.eye(4)[:, :3] if checked is not check.matrix4 else np.eye(4))
    np.testing.assert_array_equal(checked("points", rows), rows.data)
    rows[2, 1] = np.ma.masked
    with pytest.raises(ValueError, match=r"^points must be .*; got an array with masked entries\. Fill them"):
        checked("points", rows)


def vtk_matrix(rows):
    matrix = vtk.vtkMatrix4x4()
    matrix.DeepCopy(rows.ravel().tolist())
    return matrix


@pytest.mark.parametrize("wrap", [np.array, np.ndarray.tolist, np.int8, vtk_matrix])
def test_a_matrix_is_a_float64_copy(wrap):
    came = wrap(np.arange(16.0).reshape(4, 4))
    result = check.matrix4("matrix", came)
    assert (result.dtype, result.ravel().tolist()) == (np.float64, list(range(16)))
    assert not (isinstance(came, np.ndarray) and np.shares_memory(result, came))
