"""Forms: the fields of a light, material, reflectance or light model in the studio's page, and their editing.

Forms are derived from the classes. The docstring, which help() and the command line show too, defines the type of each
field ("radius : float, default 1") and its help. The field's check defines the range, and its role or metadata the
unit. So a new kind of light needs no code in this module.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, Literal, NamedTuple

import docstring_parser

from pvphong.base import check
from pvphong.base.types import rgb
from pvphong.optics.colormap import Colormap
from pvphong.optics.maps import Map, is_image_path, is_texture

Kind = Literal["number", "numbers", "points", "color", "flag", "choice", "text", "reflectance"]

_KINDS: Mapping[str, Kind] = {
    "float": "number",
    "int": "number",
    "sequence of float": "numbers",
    "sequence of points": "points",
    "color": "color",
    "bool": "flag",
    "str": "text",
    "Reflectance": "reflectance",
}
"""Type of a field in a docstring, up to the first comma or "or" → kind of input."""

_OF_THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2}(,\d{3})+(\.\d*)?")
"""A number whose commas may separate thousands. 1,000 is ambiguous, because some languages use decimal commas."""

_STOPS = 4.0
"""Range of the slider of a number without an upper limit: this many stops up and down, a factor of 2⁴ = 16 each."""

_STEP = 2.0**-4
"""Least movement of that slider, in stops."""

_MOST_STOPS = 100.0
"""Largest position of that slider that is used, in stops."""


class Field(NamedTuple):
    """A field of a dataclass, for a form."""

    name: str
    kind: Kind
    help: str
    unit: str = ""
    labels: tuple[str, ...] = ()
    least: float = -math.inf
    most: float = math.inf
    is_whole: bool = False
    is_open: bool = False
    """True if the value must be larger than `least`; False if it may also be equal."""
    is_optional: bool = False
    """True if the value may be None."""
    takes: str = ""
    """Other kind of value that the field accepts: "map", "image" or "file"; for a flag, "number"; "" for none."""
    default: Any = None
    """Default value, or 0.5 if the field has none."""
    choices: tuple[str, ...] = ()


def fields_of(kind: Any) -> tuple[Field, ...]:
    """Return the fields of a dataclass in the order of its docstring, then those of its base class.

    Raises
    ------
    TypeError
        If a field is not documented, or forms do not support its documented type.
    """
    return _fields_of(kind)


@cache
def _fields_of(kind: Any) -> tuple[Field, ...]:
    documented = _documented(kind)
    found = {each.name: each for each in dataclasses.fields(kind)}
    if missing := found.keys() - documented.keys():
        raise TypeError(f"{kind.__name__} does not document its fields {', '.join(sorted(missing))}.")
    units = {"intensity": getattr(kind, "intensity_unit", "")}
    return tuple(_field(found[name], units.get(name, ""), *documented[name]) for name in documented if name in found)


def field_of(value: Any, name: str) -> Field:
    """Return the field `name` of a dataclass instance. Raise ``ValueError`` if it does not exist."""
    known = {each.name: each for each in fields_of(type(value))}
    return known.get(name) or check.refuse("field", name, f"one of {', '.join(known)}")


def _documented(kind: Any) -> dict[str, tuple[str, str]]:
    """Return the type and the description of each parameter in the docstrings of a class and its bases."""
    found: dict[str, tuple[str, str]] = {}
    for each in kind.__mro__:
        said = docstring_parser.parse(each.__dict__.get("__doc__") or "", docstring_parser.DocstringStyle.NUMPYDOC)
        for entry in said.params:
            text = " ".join((entry.description or "").replace("`", "").replace("*", "").split())
            for name in entry.arg_name.split(", "):
                found.setdefault(name, (entry.type_name or "", text))
    return found


def _field(field: dataclasses.Field[Any], unit: str, what: str, text: str) -> Field:
    checked, role = field.metadata.get("check"), field.metadata.get("role")
    limits = getattr(checked, "keywords", {})
    base, _, more = what.partition(", ")
    base, _, other = base.partition(" or ")
    shared: dict[str, Any] = {
        "unit": unit or getattr(role, "unit", "") or field.metadata.get("unit", ""),
        "least": limits.get("at_least", limits.get("above", -math.inf)),
        "is_open": "above" in limits,
        "is_whole": base == "int",
        "most": limits.get("at_most", math.inf),
        "is_optional": field.default is None,
        "default": 0.5 if field.default is dataclasses.MISSING else field.default,
    }
    if what.startswith("{"):
        return Field(field.name, "choice", text, choices=tuple(limits["allowed"]))
    if base not in _KINDS:
        raise TypeError(f"{field.name} is documented as {what!r}, a type that forms do not support.")
    takes = {"map": "map", "array_like": "map", "float": "number", "path": "file"}.get(other, "")
    if "pyvista.Texture" in more:
        takes = "image"
    labels = role.labels if role is not None and _KINDS[base] in ("numbers", "points") else ()
    return Field(field.name, _KINDS[base], text, labels=labels, takes=takes, **shared)


def form_of(value: Any, key: str, middles: dict[str, float], *, hidden: Sequence[str] = ()) -> list[dict[str, Any]]:
    """Return an entry for each field of a dataclass, with built-in Python types, for the page.

    Parameters
    ----------
    value : dataclass instance
        A light, material, reflectance or light model, for example.
    key : str
        Prefix of the entries' keys, which identify fields in edits.
    middles : dict
        Key → centre of a logarithmic slider, in stops (log2), for a number without an upper limit. A missing key is
        added, with the current value. Remove a key after its slider has been moved, so that the new value becomes the
        centre.
    hidden : sequence of str
        Fields to leave out.
    """
    return [
        _entry(field, getattr(value, field.name), f"{key}.{field.name}", middles)
        for field in fields_of(type(value))
        if field.name not in hidden
    ]


def _entry(field: Field, value: Any, key: str, middles: dict[str, float]) -> dict[str, Any]:
    as_they_are = ("name", "kind", "help", "unit", "labels", "takes", "default", "choices")
    entry = {name: getattr(field, name) for name in as_they_are}
    entry |= {"key": key, "label": field.name.replace("_", " "), "map": ""}
    entry |= {"optional": field.is_optional, "set": value is not None}
    if isinstance(value, Map) or (field.takes == "map" and isinstance(value, str)):
        is_of_image = isinstance(value, Map) and is_texture(value.source)
        entry["map"] = f"array {value!r}" if isinstance(value, str) else "a texture" if is_of_image else "an array"
    elif isinstance(value, Colormap):
        entry["map"] = f"array {value.scalars!r}, coloured" if isinstance(value.scalars, str) else "an array, coloured"
    elif field.takes == "image" and not isinstance(value, (float, tuple)):
        entry["map"] = "image {1} × {0}".format(*value.image.shape)
    elif field.takes == "file" and not isinstance(value, float):
        entry["map"] = repr(value)
    elif field.kind == "number":
        entry |= {"value": value} | _slider(field, value, key, middles)
    elif field.kind == "numbers":
        entry["value"] = list(value)
    elif field.kind == "points":
        entry["value"] = [list(point) for point in value]
    elif field.kind == "color" and value is not None:
        entry |= {"value": list(rgb(value)), "hex": hex_of(value)}
    elif field.kind == "flag":
        is_number = not isinstance(value, bool)
        entry |= {"value": is_number or value, "number": value if is_number else None}
    elif field.kind == "choice":
        entry["value"] = value
    elif field.kind == "text":
        entry["value"] = value or ""
    return entry


def has_stops(field: Field) -> bool:
    """Return True if a number's slider is logarithmic, in stops (log2). This holds if the number has no upper limit."""
    return field.least >= 0.0 and field.most == math.inf and not field.is_whole


def _slider(field: Field, value: float | None, key: str, middles: dict[str, float]) -> dict[str, Any]:
    """Return the position and limits of a number's slider, for the page; empty if the number has no slider.

    `key` identifies the field, and `middles` has the centres of logarithmic sliders, as for `form_of`.
    """
    if has_stops(field) and value is not None:
        stops = math.log2(value) if value > 0.0 else -math.inf
        middle = middles.setdefault(key, stops if value > 0.0 else 0.0)
        low, high = middle - _STOPS, middle + _STOPS
        return {"slide": min(max(stops, low), high), "from": low, "to": high, "step": _STEP, "stops": True}
    if value is None or not (field.least > -math.inf and field.most < math.inf):
        return {}
    step = 1.0 if field.is_whole else (field.most - field.least) / 200.0
    return {"slide": value, "from": field.least + step * field.is_open, "to": field.most, "step": step}


def hex_of(color: Any) -> str:
    """Return a colour as #rrggbb, rounded and clipped to 1."""
    return "#" + "".join(f"{round(255.0 * min(max(channel, 0.0), 1.0)):02x}" for channel in rgb(color))


def edited(value: Any, name: str, given: Any, index: Sequence[int] = ()) -> Any:
    """Return a copy of a dataclass instance with one field set to a value from the page.

    Parameters
    ----------
    value : dataclass instance
        The instance to edit; it is not changed.
    name : str
        Name of the field.
    given : object
        A number or its text, a flag, a text, or a colour as name, hex string or three numbers. None unsets the field.
    index : sequence of int
        Position of the number that changes, if the field has several: its index, or the index of a point and of its
        coordinate.

    Raises
    ------
    ValueError
        If there is no such field, or the value is not allowed; the message names the field.
    """
    field = field_of(value, name)
    before = getattr(value, name)
    if field.takes == "map" and is_image_path(given):
        check.refuse(name, given, "a value or the name of an array", "To use an image file, upload it.")
    if given is None:
        if not field.is_optional:
            check.refuse(name, "an empty input", "set", "Enter a value.")
        return dataclasses.replace(value, **{name: None})
    if field.kind == "number" or (field.takes == "number" and not isinstance(given, bool)):
        given = number_in(name, given)
        if field.is_whole and given.is_integer():
            given = int(given)
    elif field.kind in ("numbers", "points") or (field.kind == "color" and index):
        numbers = rgb(before) if field.kind == "color" else before
        given = _with_number(name, numbers, given, list(index))
        if given == numbers:
            return value  # keep a grey as a single number
    elif field.kind == "color" and isinstance(given, str):
        given = given.strip()
    if field.kind == "color" and isinstance(before, float | tuple) and given == hex_of(before):
        return value  # keep an unchanged colour exactly, since the hex string is rounded
    return dataclasses.replace(value, **{name: given})


def slid(given: Any, value: Any, name: str) -> Any:
    """Return a dataclass with a field set from its slider, in stops if `has_stops`, or from its colour picker."""
    field = field_of(value, name)
    if field.kind not in ("number", "color"):
        check.refuse("field", name, "a number or a colour, to be set by a slider or picker")
    if field.kind == "number":
        given = check.number(name, given)
        if has_stops(field):
            given = 2.0 ** min(max(given, -_MOST_STOPS), _MOST_STOPS)
        given = round(given) if field.is_whole else given
    return edited(value, name, given)


def number_in(name: str, given: Any) -> float:
    """Return a number that is given as a number, or as a text with a decimal point or comma.

    `name` is the field's name for error messages.
    """
    if isinstance(given, str):
        typed = given.strip().replace("−", "-")
        if _OF_THOUSANDS.fullmatch(typed):
            check.refuse(name, given, "a number without thousands separators", "Write 1000 or 1.5, for example.")
        try:
            return float(typed.replace(",", "."))
        except ValueError:
            check.refuse(name, given.strip() or "an empty input", "a number")
    return check.number(name, given)


def _with_number(name: str, before: Any, given: Any, index: list[int]) -> Any:
    """Return the tuple `before`, or tuple of tuples, with the number at `index` replaced by `given`.

    If `index` is empty, return `given`. `name` is the field's name for error messages.
    """
    if not index:
        return given
    first, *rest = index
    if type(first) is not int or not 0 <= first < len(before):
        check.refuse(f"index of {name}", first, f"a whole number below {len(before)}")
    changed = list(before)
    changed[first] = _with_number(name, before[first], given, rest) if rest else number_in(name, given)
    return tuple(changed)
