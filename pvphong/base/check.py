"""Checks of arguments, and the common form of their error messages.

Every check takes the argument's name first and returns the value in its canonical form. It raises ``ValueError`` with
the name, the allowed values, the given value and, if there is one, the remedy.
"""

from __future__ import annotations

import dataclasses
import difflib
import functools
import math
import numbers
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import PurePath
from typing import Any, NoReturn

import numpy as np

from pvphong.base import host
from pvphong.base.types import Color, Float64Array, FloatArray, Vector

_LONGEST_SHOWN = 80
_MANY = 9  # if there are more options, the message lists the nearest ones first
_ROWS = "an (n, 3) array of real numbers"


def refuse(name: str, got: object, allowed: str, remedy: str = "") -> NoReturn:
    """Raise pvphong's ``ValueError`` for an invalid argument.

    Parameters
    ----------
    name : str
        The argument or field.
    got : object
        The given value. A path is shown in full. A string is shown without quotes, and any other value by its
        ``repr``; both are truncated.
    allowed : str
        The allowed values. The text completes the sentence "<name> must be …".
    remedy : str
        A sentence that tells the user what to do.
    """
    shown = " ".join((str(got) if isinstance(got, (str, PurePath)) else repr(got)).split())
    if len(shown) > _LONGEST_SHOWN and not isinstance(got, PurePath):
        shown = shown[: _LONGEST_SHOWN - 1] + "…"
    message = f"{name} must be {allowed}; got {shown}."
    raise ValueError(f"{message} {remedy}" if remedy else message)


def number(
    name: str,
    value: Any,
    *,
    at_least: float = -math.inf,
    above: float = -math.inf,
    at_most: float = math.inf,
    remedy: str = "",
) -> float:
    """Return `value` as a float if it is a finite real number within the bounds; else raise ValueError.

    The value must be >= `at_least`, > `above` and <= `at_most`. `remedy` is a sentence that ends the message.
    """
    if type(value) is float and math.isfinite(value) and at_least <= value <= at_most and value > above:
        return value  # the usual case, kept fast for files with many lights
    bounds = [f"> {above:g}"] * (above > -math.inf) + [f">= {at_least:g}"] * (at_least > -math.inf)
    bounds += [f"<= {at_most:g}"] * (at_most < math.inf)
    allowed = " ".join(["a finite number", *" and ".join(bounds).split()])
    if not isinstance(value, (numbers.Real, np.number)) or isinstance(value, (bool, np.complexfloating)):
        refuse(name, value, allowed, remedy)
    try:
        result = float(value)
    except (TypeError, ValueError, OverflowError):
        refuse(name, value, allowed)
    if not math.isfinite(result) or result < at_least or result <= above or result > at_most:
        refuse(name, value, allowed, remedy)
    return result


def whole(name: str, value: Any, *, at_least: int, at_most: float = math.inf) -> int:
    """Return `value` as an int if it is a whole number within the bounds; else raise ValueError."""
    result = number(name, value, at_least=at_least, at_most=at_most)
    if not result.is_integer():
        upper = f" and <= {at_most:g}" if at_most < math.inf else ""
        refuse(name, value, f"a whole number >= {at_least}{upper}")
    return int(result)


def flag(name: str, value: Any) -> bool:
    """Return `value` as a Python bool if it is a bool of Python or NumPy; else raise ValueError."""
    if not isinstance(value, (bool, np.bool_)):
        refuse(name, value, "True or False")
    return bool(value)


def choice(name: str, value: Any, allowed: Iterable[str]) -> str:
    """Return `value` if it is one of the allowed strings; else raise ValueError.

    The message lists the allowed strings and suggests the nearest one.
    """
    options = list(allowed)
    if isinstance(value, str) and value in options:
        return value
    remedy = meant(value, options)
    if len(options) > _MANY:
        options.sort(key=lambda option: repr(option) not in remedy)
    listed = "one of " + ", ".join(repr(o) for o in options)
    refuse(name, value, listed if options else "an existing name, but there are none", remedy)


def meant(value: Any, options: Iterable[str]) -> str:
    """Return "Did you mean …?" with the options that are most similar to `value`; "" if no option is similar."""
    close = difflib.get_close_matches(value.lower(), options) if isinstance(value, str) else ()
    return f"Did you mean {' or '.join(repr(c) for c in close)}?" if close else ""


def text(name: str, value: Any) -> str:
    """Return `value` if it is a string; else raise ValueError."""
    if not isinstance(value, str):
        refuse(name, value, "a string")
    return value


def vector(name: str, value: Any) -> Vector:
    """Return `value`, three finite numbers, as a tuple of floats; raise ValueError for any other value."""
    x, y, z = numbers_in(name, value, 3)
    return x, y, z


def direction(name: str, value: Any) -> Vector:
    """Return `value`, three finite numbers that are not all zero, as a tuple of floats.

    The tuple is not normalized. Any other value raises ValueError.
    """
    result = vector(name, value)
    if not any(result):
        refuse(name, value, "a direction, three finite numbers that are not all zero")
    return result


def numbers_in(name: str, value: Any, count: int) -> tuple[float, ...]:
    """Return `value`, `count` finite numbers, as a tuple of floats; raise ValueError for any other value."""
    if _are_floats(value, count):
        return tuple(value)
    allowed = f"{count} finite numbers"
    value = getattr(value, "float_rgb", value)  # for a pyvista.Color, which has no len()
    if isinstance(value, np.ndarray) and value.ndim != 1:
        refuse(name, f"an array of shape {value.shape}", allowed)
    if isinstance(value, (str, bytes)) or not isinstance(value, (Sequence, np.ndarray)) or len(value) != count:
        refuse(name, value, allowed)
    return tuple(number(f"{name}[{index}]", item) for index, item in enumerate(value))


def _are_floats(value: Any, count: int) -> bool:
    """Return True if the value is a tuple of `count` finite floats and so needs no further checks."""
    return type(value) is tuple and len(value) == count and all(type(v) is float and math.isfinite(v) for v in value)


def color(name: str, value: Any) -> Color:
    """Return `value` as a linear colour: a float for grey, or three floats.

    The value is a number, three numbers, or one of PyVista's colour names or hex strings. Floats are kept bit for bit
    and may exceed 1 (a bright light). Integer triples with an entry above 1 are refused, because they are probably
    0-255 values.
    """
    if _are_floats(value, 3) and min(value) >= 0.0:
        red, green, blue = value
        return red, green, blue
    allowed = "a number >= 0, three numbers >= 0 (1.0 = full), or a colour name or hex string"
    if isinstance(value, str):
        try:
            return host.answers().color_by_name(value)
        except ValueError:
            listed = "PyVista's colour names are listed in pyvista.hex_colors."
            refuse(name, value, allowed, meant(value, host.answers().color_names()) or listed)
    value = getattr(value, "float_rgb", value)  # for a pyvista.Color, which has no len()
    if isinstance(value, np.ndarray) and value.ndim != 1:
        refuse(name, f"an array of shape {value.shape}", allowed)
    if not isinstance(value, (Sequence, np.ndarray)):
        return number(name, value, at_least=0.0)
    items = list(value)
    if items and all(isinstance(item, (numbers.Integral, np.integer)) for item in items) and max(items) > 1:
        refuse(name, value, allowed, "These look like 0-255 values: divide them by 255.")
    if len(items) == 4:
        refuse(name, value, allowed, "Leave out the fourth number: colours here have no opacity.")
    if len(items) != 3:
        refuse(name, value, allowed)
    red, green, blue = (number(f"{name}[{i}]", item, at_least=0.0) for i, item in enumerate(items))
    return red, green, blue


def array(name: str, value: Any, *, count: int | None = None, allowed: str = _ROWS) -> FloatArray:
    """Return `value` as an (n, 3) array of float32 or float64; other real types are converted to float64.

    Parameters
    ----------
    name : str
        The argument's name.
    value : array_like
        Shape (n, 3). float32 and float64 are copied only if their byte order is not native. float16, integers and
        long doubles become float64.
    count : int, optional
        The required number of rows; by default, any number.
    allowed : str
        Description of the allowed values, for the error message. Pass it if the argument may also be something other
        than an array.

    Raises
    ------
    ValueError
        If the shape or the number of rows is wrong, or the entries are strings, objects or complex numbers.
    """
    result = real_array(name, value, allowed)
    if result.ndim != 2 or result.shape[1] != 3:
        refuse(name, f"an array of shape {result.shape}", allowed)
    if count is not None and len(result) != count:
        refuse(name, f"{len(result)} rows", f"an array with one row per point, {count} rows")
    if result.dtype in (np.float32, np.float64):  # in native byte order
        return result
    native = result.dtype.newbyteorder("=")
    if native not in (np.float32, np.float64):
        native = np.dtype(np.float64)
    with np.errstate(over="ignore"):  # a long double beyond float64's range becomes infinite
        return result.astype(native, copy=False)


def real_array(name: str, value: Any, allowed: str) -> Any:
    """Return `value`, integers or floats in any shape, as an array.

    Ragged lists, strings, objects, complex numbers and masked entries raise ValueError; `allowed` describes the allowed
    values in the message.
    """
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        refuse(name, "an array with masked entries", allowed, "Fill them, for example with array.filled(0.0).")
    try:
        result = np.asarray(value)
    except ValueError:
        refuse(name, f"a ragged {type(value).__name__}", allowed)
    if result.dtype.kind not in "fiu":
        refuse(name, f"an array of {result.dtype}" if result.ndim else value, allowed)
    return result


def matrix4(name: str, value: Any) -> Float64Array:
    """Return a finite (4, 4) float64 copy of an array_like, a ``vtkMatrix4x4`` or a transform of VTK or PyVista.

    Raises
    ------
    ValueError
        If the shape is wrong, or an entry is NaN, infinite or not a real number.
    """
    if hasattr(value, "GetMatrix"):  # a pyvista.Transform or vtkTransform
        value = value.GetMatrix()
    if hasattr(value, "GetElement"):  # a vtkMatrix4x4, recognized without importing VTK
        value = [[value.GetElement(row, column) for column in range(4)] for row in range(4)]
    result = real_array(name, value, "a 4x4 matrix of real numbers")
    if result.shape != (4, 4):
        refuse(name, f"an array of shape {result.shape}", "a 4x4 matrix of real numbers")
    result = result.astype(np.float64)
    if not np.isfinite(result).all():
        refuse(name, str(result.tolist()), "a 4x4 matrix of finite numbers")
    return result


# --- fields of frozen dataclasses, declared with their checks

Check = Callable[[str, Any], Any]
"""Function of a field's name and its given value. It returns the canonical value, or raises a ValueError that names the
field."""


def field(checked: Check, default: Any = dataclasses.MISSING, **more: Any) -> Any:
    """Declare a dataclass field whose value is checked.

    Parameters
    ----------
    checked : callable
        Function of the field's name and value that returns the canonical value or raises ValueError. The function
        `fields` calls it.
    default : Any
        Default value of the field; by default, the field has none.
    **more
        Further entries of the field's metadata.
    """
    return dataclasses.field(default=default, metadata={"check": checked, **more})


def fields(instance: Any) -> None:
    """Check the fields of a new frozen dataclass by the checks that `field` declared; store the checked values."""
    kind: Any = type(instance)
    for name, checked in _checks(kind):
        object.__setattr__(instance, name, checked(name, getattr(instance, name)))


def keywords(kind: Any, given: Iterable[str]) -> None:
    """Raise ``TypeError`` if a name in `given` is not a field of the dataclass `kind`.

    The message suggests the nearest field.
    """
    known = [each.name for each in dataclasses.fields(kind)]
    for name in given:
        if name not in known:
            remedy = meant(name, known) or f"It has {', '.join(known)}."
            raise TypeError(f"{kind.__name__} has no {name!r}. {remedy}")


def refuse_color(kind: Any, given: Mapping[str, Any]) -> None:
    """Raise ``ValueError`` if `given` has the key "color" or "colour", but the dataclass `kind` has no such field.

    "color" is PyVista's name for the field `diffuse`. The message suggests `diffuse`.
    """
    for name in ("color", "colour"):
        if name in given and name not in kind.__dataclass_fields__:
            refuse(name, given[name], "given as diffuse=", f"Use {kind.__name__}(diffuse={given[name]!r}).")


@functools.cache
def _checks(kind: Any) -> tuple[tuple[str, Check], ...]:
    found = dataclasses.fields(kind)
    return tuple((each.name, each.metadata["check"]) for each in found if "check" in each.metadata)
