"""Record of a scalar array and the options of a colormap; `pvphong/meshes/colormaps.py` computes the colours."""

from __future__ import annotations

import numbers
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from pvphong.base import check, documents, host

_CMAP = "a colormap's name, a list of colours, a matplotlib colormap or a pyvista.LookupTable"
_OF_TABLE = ("clim", "n_colors", "log_scale", "nan_color", "below_color", "above_color", "flip_scalars", "categories")


def _scalars(name: str, value: Any) -> Any:
    if isinstance(value, str) and value:
        return value
    if hasattr(value, "__dask_graph__"):
        return value
    allowed = "the name of a point or cell array, or an array with a row for each point or cell"
    if value is None or isinstance(value, str | bytes | numbers.Number):
        check.refuse(name, repr(value), allowed)
    return numbers_of(name, value)


def numbers_of(name: str, values: Any) -> Any:
    """Convert `values` to a NumPy array without a copy, and check its type and shape.

    The array must contain real numbers, complex numbers or bools, and have the shape (n,) or (n, k).

    Raises
    ------
    ValueError
        If the values have another type or shape; the message begins with `name`.
    """
    allowed = "an array of numbers, shape (n,) or (n, k)"
    if np.ma.is_masked(values):
        check.refuse(name, "an array with masked entries", allowed, "Fill them with NaN: array.filled(np.nan).")
    try:
        found = values if isinstance(values, np.ndarray) else np.asarray(values)
    except ValueError:
        check.refuse(name, f"a ragged {type(values).__name__}", allowed)
    if found.dtype.kind in "SUO":
        remedy = "Number them with np.unique(array, return_inverse=True)[1], and set categories=True."
        check.refuse(name, "an array of objects" if found.dtype.kind == "O" else "an array of strings", allowed, remedy)
    if found.dtype.kind not in "fiubc" or found.ndim not in (1, 2):
        check.refuse(name, f"a {found.dtype} array of shape {found.shape}", allowed)
    return found


def _cmap(name: str, value: Any) -> Any:
    if isinstance(value, str):
        known = host.answers().colormap_names()
        if value not in known:
            listed = "See matplotlib.colormaps for a list of most names."
            check.refuse(name, repr(value), _CMAP, check.meant(value, known) or _nearest(value, known) or listed)
        return value
    if value is None or hasattr(value, "MapScalars") or (callable(value) and hasattr(value, "N")):
        return value
    if isinstance(value, np.ndarray) and value.ndim == 2:
        value = value.tolist()
    if not isinstance(value, Sequence) or isinstance(value, bytes) or not len(value):
        check.refuse(name, value, _CMAP)
    colors = tuple(each if isinstance(each, str) else tuple(check.numbers_in(name, each, 3)) for each in value)
    for index, each in enumerate(colors):
        check.color(f"{name}[{index}]", each)
        if not isinstance(each, str) and max(each) > 1.0:
            check.refuse(f"{name}[{index}]", each, "a colour's name or three numbers from 0 to 1", "Divide by 255.")
    return colors


def _nearest(value: str, known: Sequence[str]) -> str:
    """Return "Did you mean …?" if `value` differs from a name in `known` only in upper and lower case; else ""."""
    alike = [name for name in known if name.lower() == value.lower()]
    return f"Did you mean {alike[0]!r}?" if alike else ""


def _clim(name: str, value: Any) -> tuple[float, float] | None:
    if value is None:
        return None
    if isinstance(value, numbers.Real):
        most = check.number(name, value, above=0.0)
        return -most, most
    allowed = "two finite numbers, the smaller first"
    try:
        low, high = check.numbers_in(name, value, 2)
    except ValueError:
        check.refuse(name, value, allowed)
    if not low < high:
        remedy = "Reverse a colormap with flip_scalars=True." if low > high else ""
        check.refuse(name, value, allowed, remedy)
    return low, high


def _color(name: str, value: Any) -> Any:
    return None if value is None else check.color(name, value)


def _categories(name: str, value: Any) -> bool | int:
    return bool(value) if isinstance(value, bool | np.bool_) else _count(name, value)


def _count(name: str, value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, numbers.Integral) or value < 1:
        check.refuse(name, value, "a whole number >= 1")
    return int(value)


def _component(name: str, value: Any) -> int | None:
    if value is not None and (isinstance(value, bool) or not isinstance(value, numbers.Integral) or value < 0):
        check.refuse(name, value, "a whole number >= 0, or None for the length of each row")
    return None if value is None else int(value)


def _annotations(name: str, value: Any) -> Any:
    if value is None:
        return None
    pairs = value.items() if isinstance(value, Mapping) else value
    try:
        return tuple((check.number(name, number), str(label)) for number, label in pairs)
    except (TypeError, ValueError):
        check.refuse(name, value, "a mapping from numbers to texts")


def _preference(name: str, value: Any) -> Any:
    return None if value is None else check.choice(name, value, ("point", "cell"))


@dataclass(frozen=True, eq=False, repr=False)
class Colormap:
    """Scalar array mapped through a colormap, for fields of a material that take a map of colours.

    The colours are the same as those of `plotter.add_mesh(mesh, scalars=..., cmap=...)` before lighting: 8-bit colours
    of VTK's lookup table, for each point, or for each face if the array is a cell array. A cell array needs faces with
    their own points: `feature_angle=0`.

    Parameters
    ----------
    scalars : str or array_like
        Name of a point or cell array, or an array with a row for each of the mesh's points or cells. If rows
        have several numbers, the length of each row is mapped, or the column that `component` selects. For complex
        numbers, the real part is mapped. Bools have two colours, whatever the range.
    cmap : str, sequence of colours, matplotlib.colors.Colormap or pyvista.LookupTable, optional
        Colormap: a name that PyVista knows, or a sequence of colours, each a name or three numbers from 0 to 1;
        defaults to the colormap of PyVista's theme. A lookup table defines its own range and colours; the options that
        would set them are then refused.
    clim : (float, float) or float, optional
        Numbers that map to the first and the last colour; one number c means (-c, c). Defaults to the least and the
        greatest number of the array, over all blocks of a MultiBlock.
    n_colors : int, default 256
        Number of colours; not used if `cmap` is a list of colours.
    log_scale : bool, default False
        True for a logarithmic scale between the two numbers of `clim`. If the lower one is not positive, the least
        positive float replaces it.
    nan_color, below_color, above_color : color, optional
        Colour of NaN (by default, the theme's), of numbers below `clim` (by default, the first colour) and of numbers
        above `clim` (by default, the last colour).
    flip_scalars : bool, default False
        True to reverse the colormap.
    categories : bool or int, default False
        True for one colour per distinct number, or the number of colours.
    annotations : mapping, optional
        Mapping from numbers to texts, which the scalar bar shows at these numbers.
    component : int, optional
        Index of the column to map, for an array with several columns; by default, the lengths of the rows are mapped.
    preference : {"point", "cell"}, optional
        Kind of array to use if point data and cell data both have an array with the name `scalars`; without a
        preference, such a name is refused. If `scalars` is an array, and the mesh has as many points as cells, the
        default is "point".

    Raises
    ------
    ValueError
        If a field is not allowed; the message names the field.

    Examples
    --------
    >>> import pvphong as ph
    >>> ph.Material(albedo=ph.Colormap("Elevation", "terrain", clim=(0, 8))).albedo
    Colormap('Elevation', 'terrain', clim=(0.0, 8.0))
    """

    scalars: Any = check.field(_scalars)
    cmap: Any = check.field(_cmap, None)
    clim: Any = check.field(_clim, None)
    n_colors: int = check.field(_count, 256)
    log_scale: bool = check.field(check.flag, False)
    nan_color: Any = check.field(_color, None)
    below_color: Any = check.field(_color, None)
    above_color: Any = check.field(_color, None)
    flip_scalars: bool = check.field(check.flag, False)
    categories: bool | int = check.field(_categories, False)
    annotations: Any = check.field(_annotations, None)
    component: int | None = check.field(_component, None)
    preference: Any = check.field(_preference, None)

    def __post_init__(self) -> None:
        check.fields(self)
        if hasattr(self.cmap, "MapScalars"):
            for name in _OF_TABLE:
                if name in self.given:
                    check.refuse(name, getattr(self, name), "omitted with a lookup table: the table defines it")

    @property
    def given(self) -> dict[str, Any]:
        """Dictionary from name to value, for the field `scalars` and all fields that differ from their defaults."""
        others = {
            each.name: getattr(self, each.name) for each in fields(self)[1:] if getattr(self, each.name) != each.default
        }
        return {"scalars": self.scalars} | others

    def __repr__(self) -> str:
        given = self.given
        shown = [_shown(given.pop(name)) for name in ("scalars", "cmap") if name in given]
        return f"Colormap({', '.join([*shown, *(f'{name}={_shown(value)}' for name, value in given.items())])})"

    @property
    def _key(self) -> tuple[Any, ...]:
        """Values of all fields, by which colormaps are compared. Arrays and other objects are compared by identity."""
        values = (getattr(self, each.name) for each in fields(self))
        plain = (str, tuple, bool, int, float, type(None))
        return tuple(value if isinstance(value, plain) else (id(value), type(value)) for value in values)

    def __eq__(self, other: object) -> bool:
        return self._key == other._key if isinstance(other, Colormap) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key)

    def to_dict(self, place: str = "colormap") -> dict[str, Any]:
        """Return the colormap's fields as a dictionary for JSON; `from_dict` restores the colormap.

        Error messages begin with `place`.

        Raises
        ------
        ValueError
            If the scalars are not a name, or the colormap is neither a name nor a list of colours.
        """
        if not isinstance(self.scalars, str):
            remedy = "Store it as an array of the mesh, and pass its name."
            check.refuse(f"{place}.scalars", _shown(self.scalars), "an array's name to be saved in a file", remedy)
        if not isinstance(self.cmap, str | tuple | None):
            remedy = "Pass its name, or colours, as in cmap=[pv.Color(c).hex_rgb for c in (...)]."
            allowed = "a colormap's name or a list of colours to be saved in a file"
            check.refuse(f"{place}.cmap", _shown(self.cmap), allowed, remedy)
        return {name: list(value) if isinstance(value, tuple) else value for name, value in self.given.items()}

    @classmethod
    def from_dict(cls, given: Mapping[str, Any], place: str = "colormap") -> Colormap:
        """Restore a colormap from `given`, the result of `to_dict`.

        `place` is the colormap's name in messages.

        Raises
        ------
        ValueError
            If a field is unknown or invalid.
        """
        if "scalars" not in documents.entries(place, given):
            check.refuse(f"{place}.scalars", "nothing", "the name of a point or cell array")
        return documents.value(place, cls, given)


def _shown(value: Any) -> str:
    if isinstance(value, str | tuple | bool | int | float):
        return repr(value)
    shape = getattr(value, "shape", None)
    return f"<{type(value).__name__}{'' if shape is None else f' of shape {shape}'}>"
