"""Maps: values of a material's field that vary per vertex, in place of one number or colour.

A map is an array with a row for each vertex, the name of a mesh's point array, a texture, or a scalar array through a
colormap. `FIELDS` lists the fields that may be maps; `map_values` checks an array.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from pvphong.base import check, host
from pvphong.base.formulas import BRIGHTEST
from pvphong.base.types import FloatArray, rgb
from pvphong.optics.colormap import Colormap

MOST_REFLECTED = 16.0
"""Largest reflectance. Values above 1 are allowed, but values above this limit are probably 0-255 values."""


class Field(NamedTuple):
    """Limits of a map in a field of a material or reflectance: colours or numbers, and their range."""

    is_color: bool
    least: float
    most: float
    allowed: str


FIELDS: Mapping[str, Field] = {
    "albedo": Field(True, 0.0, 1.001, "reflectances from 0 to 1"),  # computed values may exceed 1 by rounding
    "diffuse": Field(True, 0.0, MOST_REFLECTED, "reflectances from 0 to 16, where 1 is all light"),
    "specular": Field(True, 0.0, MOST_REFLECTED, "reflectances from 0 to 16, where 1 is all light"),
    "emission": Field(True, 0.0, BRIGHTEST, "finite numbers >= 0"),
    "shininess": Field(False, 0.0, float(np.finfo(float).max), "finite numbers >= 0"),
    "roughness": Field(False, float(np.nextafter(0.0, 1.0)), 1.0, "numbers > 0 and <= 1"),
    "metallic": Field(False, 0.0, 1.0, "numbers from 0 to 1"),
}
"""Name → description of the fields of materials and reflectances that may be maps."""

IMAGES = (".bmp", ".jpeg", ".jpg", ".png", ".tif", ".tiff")
"""Suffixes of image files. A string with such a suffix that does not name a point array is a path."""

SHINIEST = 128.0
"""Shininess that white in a texture stands for: OpenGL's largest (2.1 specification, table 2.10)."""

COLORS = tuple(name for name, field in FIELDS.items() if field.is_color)


class Map:
    """Array or texture in a field. Two maps are equal if they hold the same object, whatever its content.

    Parameters
    ----------
    source : array_like or pyvista.Texture
        The array or texture; it is neither copied nor modified.
    """

    __slots__ = ("source",)

    def __init__(self, source: Any) -> None:
        self.source = source

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Map) and other.source is self.source

    def __hash__(self) -> int:
        return id(self.source)

    def __repr__(self) -> str:
        shape = getattr(self.source, "shape", None)
        return f"<{type(self.source).__name__}{'' if shape is None else f' of shape {shape}'}>"

    def __reduce__(self) -> Any:
        """Pickle an array unchanged, and a texture as its image and settings. (VTK cannot pickle textures.)"""
        texture = self.source
        if not is_texture(texture):
            return Map, (texture,)
        settings = {name: getattr(texture, f"Get{name}")() for name in _LOOKED_UP_BY}
        return _unpickled, (type(texture), texture.GetInput(), settings)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        return np.array(self.source, dtype, copy=copy)


_LOOKED_UP_BY = "Wrap", "BorderColor", "Interpolate", "UseSRGBColorSpace", "ColorMode", "CubeMap"


def _unpickled(kind: Any, image: Any, settings: Mapping[str, Any]) -> Map:
    texture = kind()
    texture.SetInputData(image)
    for name, value in settings.items():
        getattr(texture, f"Set{name}")(value)
    texture.Update()
    return Map(texture)


AnyMap = Map | str | Colormap
"""Types of a map in a field: an array or a texture, a name, or scalars through a colormap."""


def map_in(name: str, value: Any) -> AnyMap | None:
    """Return the value of the field `name` as a map; None if it is a number or a colour.

    The map is a `Map` of an array or a texture, the name of an array or image file, or a `Colormap`. In a field of
    colours, a string that is a colour's name means this colour, and a sequence of three numbers is a colour too.
    """
    is_color = name in COLORS
    if isinstance(value, Map):
        return value
    if isinstance(value, Colormap):
        return value if is_color else None
    if isinstance(value, str):
        return None if is_color and is_color_name(value) else value
    if is_texture(value):
        return Map(value)
    if isinstance(value, Sequence) and not isinstance(value, bytes):
        is_map = not is_color or len(value) > 4 or any(isinstance(row, Sequence | np.ndarray) for row in value)
        return Map(value) if is_map else None
    shape: tuple[int, ...] = getattr(value, "shape", ())
    is_one = not shape or (is_color and shape in ((3,), (4,)))
    return None if is_one else Map(value)


def is_color_name(value: str) -> bool:
    """Return True if a string is a colour's name in PyVista."""
    try:
        host.answers().color_by_name(value)
    except ValueError:
        return False
    return True


def is_image_path(value: Any) -> bool:
    """Return True if a value is a string that ends with the suffix of an image file."""
    return isinstance(value, str) and value.lower().endswith(IMAGES)


def is_texture(value: Any) -> bool:
    """Return True if a value is a `pyvista.Texture` or a `vtkTexture`; neither class is imported."""
    return hasattr(value, "GetUseSRGBColorSpace")


class NamedColor(tuple[float, float, float]):
    """Colour given by its name. If a mesh has a point array of this name, the array is used instead."""

    name: str

    def __new__(cls, name: str, color: Sequence[float]) -> NamedColor:
        """Make a named colour from its name and three floats that `check.color` has returned."""
        made = super().__new__(cls, color)
        made.name = name
        return made

    def __getnewargs__(self) -> tuple[str, tuple[float, ...]]:
        return self.name, tuple(self)

    def __repr__(self) -> str:
        return repr(self.name)


def color_or_map(name: str, value: Any) -> Any:
    """Check the value of the field `name`, a colour or a map, and return it in canonical form.

    A map has the form that `map_in` returns. A colour that is given by its name becomes a `NamedColor`. Any other
    colour has the form that `check.color` returns.
    """
    found = value if isinstance(value, NamedColor) else map_in(name, value)
    if found is not None:
        return found
    return NamedColor(value, rgb(check.color(name, value))) if isinstance(value, str) else check.color(name, value)


def number_or_map(name: str, value: Any, **bounds: Any) -> Any:
    """Check the value of the field `name`, a number or a map, and return it in canonical form.

    A map has the form that `map_in` returns. A number must be within `bounds`, the keyword arguments of `check.number`.
    """
    found = map_in(name, value)
    return check.number(name, value, **bounds) if found is None else found


def refuse_unnamed(name: str, value: Any) -> None:
    """Raise ValueError if the value of the field `name` cannot be saved in a file.

    Arrays and textures cannot be saved, also as the scalars of a colormap. Numbers, colours, the names of arrays, the
    paths of image files, and colormaps of named arrays can.
    """
    if isinstance(value, Colormap):
        value.to_dict(name)
    if isinstance(value, Map):
        allowed = "a number, a colour, a point array's name or an image file's path to be saved in a file"
        remedy = "Store the map as a point array of the mesh, and pass its name."
        check.refuse(name, value, allowed, remedy)


class Values(NamedTuple):
    """Checked values of a map for n vertices."""

    rows: Any
    """Array of shape (n, 1), or (n, 3) for colours; uint8, float32 or float64."""
    least: float
    """Least value; 0 for colours."""
    most: float
    """Greatest value; for colours, rounded up to a power of two by `above`; for albedo, 1."""


def above(largest: float) -> float:
    """Return the least power of two that is at least `largest`, a number >= 0; for 0, return 1.

    Colours are divided by the result. Division by a power of two is exact, so that no vertex's colour depends on the
    others.
    """
    mantissa, exponent = math.frexp(largest)
    return math.ldexp(1.0, exponent - (mantissa == 0.5))


def map_values(name: str, value: Any, count: int) -> Values:
    """Check that the map of a material's field fits a mesh, and return its values with their range.

    Parameters
    ----------
    name : str
        Name of the field, a key of `FIELDS`.
    value : Map, Colormap or array_like
        The map.
    count : int
        Number of vertices.

    Raises
    ------
    ValueError
        For a wrong shape or length, integers other than uint8 as colours, or numbers out of range. For albedo, only
        numbers above 1 raise: NaN and negative numbers become 0 when the map is used.
    """
    field = FIELDS[name]
    allowed = f"{field.allowed}, shape (n,){' or (n, 3)' if field.is_color else ''}"
    if isinstance(value, str):
        check.refuse(name, repr(value), f"an array of {allowed}", "The name of an array needs a mesh.")
    if isinstance(value, Colormap):
        value = host.answers().mapped_colors(name, value)
    given = check.real_array(name, value.source if isinstance(value, Map) else value, allowed)
    if field.is_color and given.ndim == 2 and given.shape[1] == 4:
        check.refuse(name, f"an array of shape {given.shape}", allowed, "Leave out the opacity: [:, :3].")
    if given.ndim not in (1, 2) or (given.ndim == 2 and given.shape[1] not in ((1, 3) if field.is_color else (1,))):
        check.refuse(name, f"an array of shape {given.shape}", allowed)
    if len(given) != count:
        check.refuse(name, f"{len(given)} rows", f"an array with one row per point, {count} rows")
    numbers = given[:, None] if given.ndim == 1 else given
    if field.is_color and numbers.dtype == np.uint8:
        return Values(numbers, 0.0, 1.0)
    if field.is_color and numbers.dtype.kind in "iu":
        remedy = "Convert 0-255 values to uint8, or divide them by 255."
        check.refuse(name, f"an array of {numbers.dtype}", "uint8 or floats", remedy)
    if numbers.dtype not in (np.float32, np.float64) or not numbers.dtype.isnative:
        with np.errstate(over="ignore"):
            numbers = numbers.astype(np.float32 if numbers.dtype.kind == "f" and numbers.itemsize == 4 else np.float64)
    if not numbers.size:
        return Values(numbers, 1.0, 1.0)
    least, most = _range_of(numbers)
    if name == "albedo":
        if not most <= field.most:  # too large, or NaN
            most = float(np.fmax.reduce(numbers, axis=None))
        if most > field.most:
            remedy = "Divide 0-255 values by 255, or convert them to uint8."
            check.refuse(name, f"floats up to {most:g}", "floats from 0 to 1", remedy)
        return Values(numbers, 0.0, 1.0)
    if not (least >= field.least and most <= field.most):  # also if there is a NaN
        wide = numbers.astype(np.float64)
        is_bad = ~((wide >= field.least) & (wide <= field.most)).all(axis=1)
        first = int(np.argmax(is_bad))
        is_255 = field.is_color and field.most < numbers[first].max() <= 255.0
        remedy = "Divide 0-255 values by 255, or convert them to uint8." if is_255 else ""
        check.refuse(name, f"{numbers[first].tolist()} at vertex {first}", allowed, remedy)
    return Values(numbers, 0.0, above(most)) if field.is_color else Values(numbers, least, most)


def _range_of(numbers: Any) -> tuple[float, float]:
    """Return the least and the greatest number of an (n, 1) or (n, 3) array of floats; NaN if the array contains a NaN.

    If an array of colours has no negative number, the least may be returned as 0. One pass then suffices: read as
    unsigned integers, floats >= 0 keep their order, and negative floats are larger than all others. So if the greatest
    integer belongs to a float >= 0, no number is negative.
    """
    if numbers.shape[1] == 3 and numbers.flags.c_contiguous:
        bits = numbers.view(np.uint32 if numbers.itemsize == 4 else np.uint64).max()
        most = float(bits.view(numbers.dtype))
        if most >= 0.0 and not math.copysign(1.0, most) < 0.0:
            return 0.0, most
    return float(numbers.min()), float(numbers.max())


def fractions(name: str, rows: Any, real: Any = np.float64) -> FloatArray:
    """Convert `rows`, the checked values of a map of colours, to floats of the type `real`.

    `name` is the field of the map. uint8 values are divided by 255. For the field "albedo", floats are clipped to [0,
    1], and NaN become 0.
    """
    if rows.dtype == np.uint8:
        return np.divide(rows, 255.0, dtype=real)
    if name == "albedo":
        rows = np.fmin(np.fmax(rows, 0.0), 1.0)  # fmax prefers 0 to NaN
    return np.asarray(rows, real)
