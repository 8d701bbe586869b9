"""Every check gives the canonical value, or a ValueError that says what, what is allowed, and how to put it right."""

import math
import re
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
import vtk
from hypothesis import given, settings
from hypothesis import strategies as st

from pvphong.base import check

QUICK = settings(max_examples=60, derandomize=True, deadline=None, database=None)


# --- the message ---


def test_refusal_names_argument_value_allowed_and_remedy():
    with pytest.raises(ValueError, match=r"^size must be a number > 0; got -1\. Double it\.$"):
        check.refuse("size", -1, "a number > 0", "Double it.")


def test_refusal_without_remedy_ends_after_the_value():
    with pytest.raises(ValueError, match=r"^size must be big; got 'small'\.$"):
        check.refuse("size", repr("small"), "big")


def test_refusal_cuts_long_values():
    with pytest.raises(ValueError, match=r"got x{79}…") as caught:
        check.refuse("name", "x" * 10_000, "short")
    assert len(str(caught.value)) < 150


def test_refusal_shows_a_path_to_its_end():
    path = Path("/home/somebody") / ("deep/" * 30) / "mesh.vtp"
    with pytest.raises(ValueError, match=f"got {re.escape(str(path))}\\."):
        check.refuse("path", path, "a file")


# --- numbers ---


@pytest.mark.parametrize(
    "value",
    [2, 2.5, Fraction(5, 2), np.float16(2.5), np.float32(0.1), np.float64(0.1), np.longdouble(2), np.uint8(7), -0.0],
)
def test_number_takes_every_real_type_and_gives_a_float(value):
    result = check.number("x", value)
    assert type(result) is float
    assert result == float(value)
    assert math.copysign(1, result) == math.copysign(1, float(value))


@given(st.floats(allow_nan=False, allow_infinity=False))
@QUICK
def test_number_keeps_every_finite_float(value):
    assert check.number("x", value).hex() == value.hex()


@pytest.mark.parametrize(
    "value",
    [
        math.nan,
        math.inf,
        -math.inf,
        np.float32("nan"),
        10**400,
        True,
        np.True_,
        "1",
        b"1",
        None,
        1j,
        np.complex128(1),
        [1],
        np.array(1.0),
        np.timedelta64(5, "s"),
        object(),
    ],
)
def test_number_refuses_what_is_no_finite_real_number(value):
    with pytest.raises(ValueError, match=r"^x must be a finite number; got "):
        check.number("x", value)


@pytest.mark.parametrize(
    ("bounds", "inside", "outside", "said"),
    [
        ({"at_least": 0}, 0.0, -5e-324, ">= 0"),
        ({"above": 0}, 5e-324, 0.0, "> 0"),
        ({"at_most": 90}, 90.0, math.nextafter(90, 91), "<= 90"),
        ({"above": 0, "at_most": 90}, 45, 0, "> 0 and <= 90"),
    ],
)
def test_number_bounds_are_exact_and_told(bounds, inside, outside, said):
    assert check.number("angle", inside, **bounds) == inside
    with pytest.raises(ValueError, match=rf"^angle must be a finite number {said}; got .* Turn it\.$"):
        check.number("angle", outside, **bounds, remedy="Turn it.")


# --- flags, choices, texts ---


@pytest.mark.parametrize("value", [True, False, np.True_, np.False_])
def test_flag_gives_a_bool(value):
    assert check.flag("on", value) is bool(value)


@pytest.mark.parametrize("value", [0, 1, "yes", None, np.array([True])])
def test_flag_takes_nothing_else_for_a_bool(value):
    with pytest.raises(ValueError, match=r"^on must be True or False; got "):
        check.flag("on", value)


def test_choice_gives_the_string():
    assert check.choice("frame", "camera", ("world", "camera")) == "camera"


@pytest.mark.parametrize("value", ["Camera", "camra", "cameras"])
def test_choice_suggests_the_nearest(value):
    with pytest.raises(
        ValueError, match=rf"^frame must be one of 'world', 'camera'; got {value}. Did you mean 'camera'"
    ):
        check.choice("frame", value, ("world", "camera"))


@pytest.mark.parametrize("value", ["zzz", "", None, 3, ["camera"]])
def test_choice_lists_what_is_allowed(value):
    with pytest.raises(ValueError, match=r"^frame must be one of 'world', 'camera'; got ") as caught:
        check.choice("frame", value, ("world", "camera"))
    assert "Did you mean" not in str(caught.value)


@pytest.mark.parametrize("value", ["", "sun", "Lämpchen ☀"])
def test_text_gives_the_string(value):
    assert check.text("name", value) == value


@pytest.mark.parametrize("value", [None, 3, b"sun", ["sun"]])
def test_text_refuses_others(value):
    with pytest.raises(ValueError, match=r"^name must be a string; got "):
        check.text("name", value)


# --- vectors ---


@pytest.mark.parametrize(
    "value",
    [
        (1, 2.5, -3),
        [1, 2.5, -3],
        np.array([1, 2.5, -3]),
        np.array([1, 2.5, -3], np.float16),
        pv.pyvista_ndarray([1, 2.5, -3]),
    ],
)
def test_vector_gives_three_floats(value):
    result = check.vector("position", value)
    assert result == (1.0, 2.5, -3.0)
    assert type(result) is tuple
    assert {type(item) for item in result} == {float}


@pytest.mark.parametrize(
    "value", [(1, 2), (1, 2, 3, 4), "123", b"123", 5, None, {1, 2, 3}, np.eye(3), np.array(3.0), np.ones((1, 3)), []]
)
def test_vector_refuses_other_shapes(value):
    with pytest.raises(ValueError, match=r"^position must be 3 finite numbers; got "):
        check.vector("position", value)


@pytest.mark.parametrize("bad", [math.nan, math.inf, "x", None, True, 1j])
def test_vector_names_the_bad_entry(bad):
    with pytest.raises(ValueError, match=r"^position\[1\] must be a finite number; got "):
        check.vector("position", [0, bad, 0])


def test_direction_keeps_its_length():
    assert check.direction("direction", (0, 0, -1e-320)) == (0.0, 0.0, -1e-320)
    assert check.direction("direction", (3e300, 0, 4)) == (3e300, 0.0, 4.0)


@pytest.mark.parametrize("value", [(0, 0, 0), (0.0, -0.0, 0.0), np.zeros(3)])
def test_direction_is_not_zero(value):
    with pytest.raises(ValueError, match=r"^direction must be a direction, .*not all zero; got "):
        check.direction("direction", value)


# --- colours ---


@given(st.lists(st.floats(min_value=0, allow_infinity=False), min_size=3, max_size=3))
@QUICK
def test_color_floats_are_kept_to_the_bit(value):
    assert [c.hex() for c in check.color("diffuse", value)] == [c.hex() for c in value]
    assert check.color("diffuse", value[0]).hex() == value[0].hex()


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("white", (1.0, 1.0, 1.0)),
        ("red", (1.0, 0.0, 0.0)),
        ("tomato", (255 / 255, 99 / 255, 71 / 255)),  # CSS: #ff6347
        ("#804020", (128 / 255, 64 / 255, 32 / 255)),
        ("0x804020", (128 / 255, 64 / 255, 32 / 255)),
        ("r", (1.0, 0.0, 0.0)),
    ],
)
def test_color_strings_go_through_pyvistas_names(value, expected):
    assert check.color("diffuse", value) == expected


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (1, 1.0),
        (0, 0.0),
        (2.5, 2.5),
        ((1, 1, 1), (1.0, 1.0, 1.0)),
        ((0, 0, 1), (0.0, 0.0, 1.0)),
        ((1, 0.5, 0.25), (1.0, 0.5, 0.25)),
        (np.array([0.5, 2, 3]), (0.5, 2.0, 3.0)),
        ([2.0, 300.0, 0.0], (2.0, 300.0, 0.0)),
    ],
)
def test_color_integers_up_to_one_are_full_and_black(value, expected):
    result = check.color("diffuse", value)
    assert result == expected
    assert {type(item) for item in np.atleast_1d(result).tolist()} == {float}
    assert type(result) in (float, tuple)


@pytest.mark.parametrize(
    "value", [(255, 128, 0), [0, 0, 2], np.array([255, 0, 0], np.uint8), (255, 0, 0, 255), (True, 5, 1)]
)
def test_color_refuses_0_to_255_integers_with_the_remedy(value):
    with pytest.raises(ValueError, match=r"^diffuse must be .*; got .*0-255 values: divide them by 255\.$"):
        check.color("diffuse", value)


def test_color_refuses_opacity_with_the_remedy():
    with pytest.raises(ValueError, match=r"^diffuse must be .* Leave out the fourth number"):
        check.color("diffuse", (1.0, 0.5, 0.0, 1.0))


@pytest.mark.parametrize("value", ["no such colour", "#12g456", "", "#"])
def test_color_refuses_unknown_names(value):
    with pytest.raises(ValueError, match=r"^diffuse must be .*colour name or hex string; got .*pyvista\.hexcolors"):
        check.color("diffuse", value)


@pytest.mark.parametrize(
    "value",
    [
        -1,
        -1e-300,
        math.nan,
        math.inf,
        None,
        (),
        (1.0,),
        (1.0, 0.5),
        (0.1,) * 5,
        (1.0, -0.1, 0),
        (math.nan, 0, 0),
        ("1", "0", "0"),
        (True, False, True),
        np.eye(3),
        {},
        1j,
        np.array(0.5),
        b"red",
        np.array([True] * 3),
    ],
)
def test_color_refuses_the_rest_by_name(value):
    with pytest.raises(ValueError, match=r"^diffuse"):
        check.color("diffuse", value)


# --- arrays ---


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_array_passes_floats_on_without_a_copy(real):
    rows = np.arange(12, dtype=real).reshape(4, 3)
    assert np.shares_memory(check.array("points", rows), rows)
    assert check.array("points", rows[::2, ::-1]).dtype == real


@pytest.mark.parametrize("kind", [np.float16, np.longdouble, np.int8, np.int64, np.uint8, np.uint64, ">f8"])
def test_array_widens_other_reals(kind):
    rows = np.arange(12).reshape(4, 3).astype(kind)
    result = check.array("points", rows)
    assert result.dtype == np.float64
    assert result.dtype.isnative
    np.testing.assert_array_equal(result, np.arange(12).reshape(4, 3))


def test_array_keeps_float32_in_another_byte_order():
    result = check.array("points", np.arange(12).reshape(4, 3).astype(">f4"))
    assert result.dtype == np.float32
    assert result.dtype.isnative
    np.testing.assert_array_equal(result, np.arange(12).reshape(4, 3))


def test_array_takes_lists():
    assert check.array("points", [[1, 2, 3], [4, 5, 6]]).shape == (2, 3)
    assert check.array("points", np.empty((0, 3))).shape == (0, 3)


@pytest.mark.parametrize(
    "value",
    [
        np.zeros((4, 2)),
        np.zeros((4, 4)),
        np.zeros(3),
        np.zeros((2, 2, 3)),
        5.0,
        [],
        [[1, 2, 3], [4, 5]],
        None,
        "points",
        [["a", "b", "c"]],
        np.zeros((2, 3), complex),
        np.zeros((2, 3), bool),
        np.zeros((2, 3), object),
        np.zeros((2, 3), "datetime64[s]"),
    ],
)
def test_array_refuses_other_shapes_and_kinds(value):
    with pytest.raises(ValueError, match=r"^points must be an \(n, 3\) array of real numbers; got "):
        check.array("points", value)


def test_array_tells_both_lengths():
    with pytest.raises(ValueError, match=r"^normals must be .* one row per point, 5 rows; got 4 rows\.$"):
        check.array("normals", np.zeros((4, 3)), count=5)


# --- matrices ---


def test_matrix_is_a_float64_copy():
    given_matrix = np.arange(16, dtype=np.float64).reshape(4, 4)
    result = check.matrix4("matrix", given_matrix)
    assert result.dtype == np.float64
    assert not np.shares_memory(result, given_matrix)
    np.testing.assert_array_equal(result, given_matrix)
    np.testing.assert_array_equal(check.matrix4("matrix", given_matrix.astype(np.int8).tolist()), given_matrix)


def test_matrix_of_vtk():
    matrix = vtk.vtkMatrix4x4()
    matrix.SetElement(0, 3, 0.1)
    matrix.SetElement(2, 1, 7)
    expected = np.eye(4)
    expected[0, 3], expected[2, 1] = 0.1, 7
    np.testing.assert_array_equal(check.matrix4("matrix", matrix), expected)


@pytest.mark.parametrize(
    "value",
    [
        np.eye(3),
        np.eye(4)[:3],
        np.zeros(16),
        1.0,
        None,
        "eye",
        np.eye(4, dtype=complex),
        np.eye(4, dtype=bool),
        [["a"] * 4] * 4,
        [[1, 2], [3]],
    ],
)
def test_matrix_refuses_other_shapes_and_kinds(value):
    with pytest.raises(ValueError, match=r"^matrix must be a 4x4 matrix of real numbers; got "):
        check.matrix4("matrix", value)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_matrix_is_finite(bad):
    matrix = np.eye(4)
    matrix[1, 2] = bad
    with pytest.raises(ValueError, match=r"^matrix must be a 4x4 matrix of finite numbers; got "):
        check.matrix4("matrix", matrix)
