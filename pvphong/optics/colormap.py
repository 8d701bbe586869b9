"""A scalar array as colours, as a plain record: what maps it is in `pvphong/meshes/colormaps.py`."""

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
    """An array of shape (n,) or (n, k) of real numbers, complex numbers or bools, not copied.

    Raises
    ------
    ValueError
        If it is something else; the message begins with the name.
    """
    allowed = "an array of numbers, shape (n,) or (n, k)"
    if np.ma.is_masked(values):
        check.refuse(name, "an array with masked entries", allowed, "Fill them with NaN, as with array.filled(nan).")
    try:
        found = values if isinstance(values, np.ndarray) else np.asarray(values)
    except ValueError:
        check.refuse(name, f"a ragged {type(values).__name__}", allowed)
    if found.dtype.kind in "SUO":
        remedy = "np.unique(array, return_inverse=True)[1] numbers them; with categories=True each has its colour."
        check.refuse(name, "an array of objects" if found.dtype.kind == "O" else "an array of strings", allowed, remedy)
    if found.dtype.kind not in "fiubc" or found.ndim not in (1, 2):
        check.refuse(name, f"an array of {found.dtype} of shape {found.shape}", allowed)
    return found


def _cmap(name: str, value: Any) -> Any:
    if isinstance(value, str):
        known = host.answers().colormap_names()
        if value not in known:
            listed = "matplotlib.colormaps lists most of them."
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
    """A remedy for a name whose capitals are others."""
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
        remedy = "flip_scalars=True turns a colormap around." if low > high else ""
        check.refuse(name, value, allowed, remedy)
    return low, high


def _color(name: str, value: Any) -> Any:
    return None if value is None else check.color(name, value)


def _categories(name: str, value: Any) -> bool | int:
    return bool(value) if isinstance(value, bool | np.bool_) else _count(name, value)


def _count(name: str, value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, numbers.Integral) or value < 1:
        check.refuse(name, value, "a whole number from 1")
    return int(value)


def _component(name: str, value: Any) -> int | None:
    if value is not None and (isinstance(value, bool) or not isinstance(value, numbers.Integral) or value < 0):
        check.refuse(name, value, "a whole number from 0, or None for the length of each row")
    return None if value is None else int(value)


def _annotations(name: str, value: Any) -> Any:
    if value is None:
        return None
    pairs = value.items() if isinstance(value, Mapping) else value
    try:
        return tuple((check.number(name, number), str(label)) for number, label in pairs)
    except (TypeError, ValueError):
        check.refuse(name, value, "a mapping of numbers to texts")


def _preference(name: str, value: Any) -> Any:
    return None if value is None else check.choice(name, value, ("point", "cell"))


@dataclass(frozen=True, eq=False, repr=False)
class Colormap:
    """A scalar array through a colormap, for fields of a material that take a map of colours.

    Colours are those of `plotter.add_mesh(mesh, scalars=..., cmap=...)`, before light: 8-bit colours of VTK's lookup
    table at each point, or of each face where the array is one of cells. That takes faces with points of their own:
    `feature_angle=0`.

    Parameters
    ----------
    scalars : str or array_like
        The name of a point or cell array, or an array with a row for each of the mesh's points or cells. Of several
        columns the length of each row counts, of complex numbers the real part. Bools have two colours, whatever the
        range.
    cmap : str, sequence of colours, matplotlib.colors.Colormap or pyvista.LookupTable, optional
        The colormap: a name that PyVista knows, or colours, each a name or three numbers from 0 to 1; that of PyVista's
        theme if not given. A lookup table has a range and colours of its own, and other options are refused.
    clim : (float, float) or float, optional
        The numbers that have the first and the last colour; one number c is (-c, c). The least and the greatest of the
        array if not given, of all blocks of a MultiBlock.
    n_colors : int, default 256
        How many colours there are; of a list of colours, as many as it has.
    log_scale : bool, default False
        Takes logarithms of numbers and range; a lower end of `clim` that is not positive is the least positive float.
    nan_color, below_color, above_color : color, optional
        Of NaN, the theme's if not given, and of numbers outside of `clim`, which else have the colours at its ends.
    flip_scalars : bool, default False
        Turns the colormap around.
    categories : bool or int, default False
        True: as many colours as there are different numbers; a number: so many colours.
    annotations : mapping, optional
        Number → text on the scalar bar.
    component : int, optional
        The column of an array of several, in place of its rows' lengths.
    preference : {"point", "cell"}, optional
        Which array is meant where both have the name or the length. Without it, two arrays of one name are refused, and
        a length that both have is that of points.

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
                    check.refuse(name, getattr(self, name), "left out beside a lookup table, which has its own")

    @property
    def given(self) -> dict[str, Any]:
        """The fields that are not their defaults."""
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
        """What two that are equal have in common: objects such as arrays are the same, whatever is in them."""
        values = (getattr(self, each.name) for each in fields(self))
        plain = (str, tuple, bool, int, float, type(None))
        return tuple(value if isinstance(value, plain) else (id(value), type(value)) for value in values)

    def __eq__(self, other: object) -> bool:
        return self._key == other._key if isinstance(other, Colormap) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key)

    def to_dict(self, place: str = "colormap") -> dict[str, Any]:
        """Its fields as JSON can hold them; `from_dict` gives the colormap back.

        Raises
        ------
        ValueError
            If the scalars are no name, or the colormap is neither a name nor a list of colours.
        """
        if not isinstance(self.scalars, str):
            remedy = "Store it as an array of the mesh, and give its name."
            check.refuse(
                f"{place}.scalars", _shown(self.scalars), "an array's name, where it is kept in a file", remedy
            )
        if not isinstance(self.cmap, str | tuple | None):
            remedy = "Give its name, or colours, as in cmap=[pv.Color(c).hex_rgb for c in (...)]."
            allowed = "a colormap's name or a list of colours, where it is kept in a file"
            check.refuse(f"{place}.cmap", _shown(self.cmap), allowed, remedy)
        return {name: list(value) if isinstance(value, tuple) else value for name, value in self.given.items()}

    @classmethod
    def from_dict(cls, given: Mapping[str, Any], place: str = "colormap") -> Colormap:
        """The colormap that `to_dict` gave; ValueError, which begins with the place, if a field is not allowed."""
        if "scalars" not in documents.entries(place, given):
            check.refuse(f"{place}.scalars", "nothing", "the name of a point or cell array")
        return documents.value(place, cls, given)


def _shown(value: Any) -> str:
    if isinstance(value, str | tuple | bool | int | float):
        return repr(value)
    shape = getattr(value, "shape", None)
    return f"<{type(value).__name__}{'' if shape is None else f' of shape {shape}'}>"
