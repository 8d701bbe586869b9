"""Weather: irradiances at given times, from a file, from arrays, or of a clear sky."""

from __future__ import annotations

import importlib
import math
import os
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array
from pvphong.scene.sun import Irradiances, Place, clear_sky, pvlib

_ALLOWED = (
    "the path of an EPW file, a pair (direct_normal, diffuse_horizontal) of arrays, a DataFrame with the columns dni "
    "and dhi, or None for a clear sky"
)
# pvlib's names of the irradiances.
_COLUMNS = "dni", "dhi"
_EARTH_RADIUS = 6371.0  # km
_FAR = 50.0  # km
# In EPW files, numbers from 9999 on mean that a value is missing.
_MISSING = 9999.0


def irradiances(weather: Any, index: Any, place: Place) -> Irradiances:
    """Return the irradiances at given times.

    Parameters
    ----------
    weather : path, pair of array_like, pandas.DataFrame or None
        The path of an EPW file, a pair of arrays, or a table. The pair has the direct normal and the diffuse horizontal
        irradiances, and the table has them as the columns "dni" and "dhi". None for a clear sky.
    index : pandas.DatetimeIndex
        The times, as from `moments`.
    place : Place
        The place. A file of another place causes a warning.

    Raises
    ------
    ValueError
        If a value is missing, negative or not a number, or the number of values differs from that of the times.
    """
    if weather is None:
        return clear_sky(index, place)
    if isinstance(weather, (str, os.PathLike)):
        return _of_file(Path(weather), index, place)
    if isinstance(weather, Mapping) or hasattr(weather, "columns"):
        missing = [name for name in _COLUMNS if name not in weather]
        if missing:
            check.refuse("weather", f"a table without {' and '.join(missing)}", _ALLOWED)
        return _checked([weather[name] for name in _COLUMNS], index)
    if isinstance(weather, (tuple, list, np.ndarray)) and len(weather) == 2:
        return _checked(list(weather), index)
    return check.refuse("weather", type(weather).__name__, _ALLOWED)


def _checked(columns: list[Any], index: Any) -> Irradiances:
    """Check irradiances, and return them.

    `columns` has the direct normal and the diffuse horizontal irradiances, one value for each time in `index`.
    """
    found = []
    for name, values in zip(Irradiances._fields, columns, strict=True):
        _refuse_other_times(name, getattr(values, "index", None), index)
        values = np.array(check.real_array(f"weather: {name}", values, "an array of real numbers"), np.float64)
        if values.shape != (len(index),):
            got, remedy = f"an array of shape {values.shape}", "Pass one value in W/m² for each time."
            check.refuse(f"weather: {name}", got, f"of shape ({len(index)},), like the times", remedy)
        found.append(_without_gaps(name, values, index))
    return Irradiances(*found)


def _refuse_other_times(name: str, own: Any, index: Any) -> None:
    """Raise ValueError if values have their own times, and these differ from the times in `index`.

    `own` is the index of the values, as of a DataFrame's column, or None. Times without a zone are local times. `name`
    is the name of the values in the message.
    """
    if not hasattr(own, "tz"):
        return
    expected = index.tz_localize(None) if own.tz is None else index
    if len(own) != len(expected) or not (own == expected).all():
        got = f"values from {own[0]} to {own[-1]}" if len(own) else "no values"
        check.refuse(f"weather: {name}", got, "given for the same times", "For example weather.reindex(times).")


def _without_gaps(name: str, values: Float64Array, index: Any) -> Float64Array:
    """Return irradiances unchanged; raise ValueError if a value is missing or negative.

    `name` is the name of the values in the message, and `index` has their times.
    """
    bad = np.flatnonzero(~(np.isfinite(values) & (values >= 0.0)))
    if len(bad):
        remedy = "Fill gaps first, for example with DataFrame.interpolate()."
        got = f"{values[bad[0]]:g} at {index[bad[0]].isoformat()}" + f" and {len(bad) - 1} more" * (len(bad) > 1)
        check.refuse(f"weather: {name}", got, "finite numbers >= 0 in W/m²", remedy)
    return values


def _of_file(path: Path, index: Any, place: Place) -> Irradiances:
    """Return the irradiances in the EPW file `path` at the times of `index`.

    The file has one year with a row for each hour. A time gets the irradiances of the row with the same month, day and
    hour, in the file's time zone; the time's own year is ignored. If the file has no 29th of February, the 28th is
    used. If the file's place is far from `place`, a warning is given.
    """
    pandas, file = importlib.import_module("pandas"), _read(path)
    hours, offset = file.hours, file.offset
    distance = _distance(file.place, (place.latitude, place.longitude))
    if distance > _FAR:
        warnings.warn(
            f"{path.name} is the weather of {file.city}, {distance:.0f} km from the place at {place.latitude:g}, "
            f"{place.longitude:g}.",
            UserWarning,
            stacklevel=2,
        )
    local = index.tz_convert("UTC").tz_localize(None) + pandas.Timedelta(hours=offset)
    has_leap_day = (2, 29, 12) in hours
    is_leap_day = (local.month == 2) & (local.day == 29) & (not has_leap_day)
    wanted = pandas.MultiIndex.from_arrays([local.month, np.where(is_leap_day, 28, local.day), local.hour])
    unique = ~hours.duplicated()
    rows = np.flatnonzero(unique)[hours[unique].get_indexer(wanted)]
    is_missing = hours[unique].get_indexer(wanted) < 0
    if is_missing.any():
        got = f"{path.name} without the hour of {index[is_missing.argmax()].isoformat()}"
        check.refuse("weather", got, "an EPW file with all hours of the times")
    found = []
    for name, column in zip(Irradiances._fields, file.columns, strict=True):
        chosen = column[rows]
        chosen = np.where(chosen >= _MISSING, math.nan, chosen)
        found.append(_without_gaps(name, chosen, index))
    return Irradiances(*found)


class _Epw(NamedTuple):
    """Content of an EPW file."""

    hours: Any
    """Month, day and hour of each row, a pandas.MultiIndex."""
    columns: list[Float64Array]
    """The irradiances of each row, in the order of `Irradiances`."""
    offset: float
    """Hours by which the file's time is ahead of UTC."""
    place: tuple[float, float]
    """Latitude and longitude."""
    city: str


def _read(path: Path) -> _Epw:
    pvlib("weather")
    pandas, reader = importlib.import_module("pandas"), importlib.import_module("pvlib.iotools")
    try:
        table, header = reader.read_epw(str(path))
        hours = pandas.MultiIndex.from_arrays([table.index.month, table.index.day, table.index.hour])
        columns = [np.asarray(table[name], np.float64) for name in _COLUMNS]
        where = float(header["latitude"]), float(header["longitude"])
        return _Epw(hours, columns, float(header["TZ"]), where, str(header.get("city", "another place")))
    except OSError as error:
        return check.refuse("weather", path.name, "an EPW file that can be read", f"{error.strerror or error}.")
    except Exception as error:  # whatever pvlib and pandas raise for a damaged file
        reason = str(error).split("\n", maxsplit=1)[0]
        return check.refuse("weather", path.name, "an EPW file", f"It is damaged or of another format: {reason}.")


def zone_of(path: Path) -> float:
    """Return the number of hours by which the local time in an EPW file is ahead of UTC."""
    return _read(path).offset


def _distance(one: tuple[float, float], other: tuple[float, float]) -> float:
    """Return the distance in kilometres between two places, each a latitude and a longitude in degrees."""
    (a, b), (c, d) = np.radians([one, other]).tolist()
    chord = math.sin(0.5 * (c - a)) ** 2 + math.cos(a) * math.cos(c) * math.sin(0.5 * (d - b)) ** 2
    return 2.0 * _EARTH_RADIUS * math.asin(math.sqrt(min(chord, 1.0)))
