"""Places on the Earth, and the sun's position and clear-sky irradiance there, computed by pvlib (the extra `sun`).

In order: `Place`; times of any common type; the sun's position; irradiances without weather data.

Angles are in degrees. Azimuths are clockwise from north: 90 is east.
"""

from __future__ import annotations

import importlib
import importlib.util
import warnings
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property, lru_cache, partial
from typing import Any, NamedTuple, Self

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, InitSignature, VectorLike
from pvphong.base.vectors import unit_vector

_FIRST_YEAR = 1950  # pvlib's table of ΔT and its fits are for later years


@dataclass(frozen=True)
class Place:
    """Place on the Earth, and the directions of its zenith and of north in the mesh's coordinates.

    Parameters
    ----------
    latitude : float
        Degrees, from -90 to 90, north positive.
    longitude : float
        Degrees, from -180 to 180, east positive.
    altitude : float, default 0
        Height above sea level in metres, from -500 to 9000. It changes refraction and the clear sky.
    up : sequence of float, default (0, 0, 1)
        Direction to the zenith, of any length.
    north : sequence of float, default (0, 1, 0)
        Direction to the north, of any length; its part along `up` is ignored.

    Raises
    ------
    ValueError
        If a field is out of range, or `north` is parallel to `up`.

    Examples
    --------
    >>> import pvphong as ph
    >>> munich = ph.Place(48.14, 11.58, altitude=520)
    >>> turned = ph.Place(48.14, 11.58, up=(0, 1, 0), north=(0, 0, -1))  # y up, as in glTF files
    >>> (turned.axes[0] + 0.0).tolist()  # east
    [1.0, 0.0, 0.0]
    """

    latitude: float = check.field(partial(check.number, at_least=-90.0, at_most=90.0))
    longitude: float = check.field(partial(check.number, at_least=-180.0, at_most=180.0))
    altitude: float = check.field(partial(check.number, at_least=-500.0, at_most=9000.0), 0.0)
    up: VectorLike = check.field(check.direction, (0.0, 0.0, 1.0))
    north: VectorLike = check.field(check.direction, (0.0, 1.0, 0.0))

    __signature__ = InitSignature()

    def __new__(cls, *_given: Any, **fields: Any) -> Self:
        """Raise TypeError for an unknown field; the message suggests the nearest field."""
        check.keywords(cls, fields)
        return super().__new__(cls)

    def __post_init__(self) -> None:
        check.fields(self)
        if np.linalg.norm(np.cross(unit_vector(self.up), unit_vector(self.north))) < 1e-9:
            remedy = "Pass the direction in which the mesh's north lies."
            check.refuse("north", self.north, f"not parallel to up, which is {self.up}", remedy)

    @cached_property
    def axes(self) -> Float64Array:
        """Unit vectors to the east, to the north and to the zenith, as rows of a (3, 3) array."""
        up, north = np.array(unit_vector(self.up)), np.array(unit_vector(self.north))
        x, y, z = (north - (north @ up) * up).tolist()
        level = np.array(unit_vector((x, y, z)))
        return np.stack([np.cross(level, up), level, up])


def checked_place(given: Any) -> Place:
    """Return `given` unchanged; raise ValueError if it is not a Place."""
    if not isinstance(given, Place):
        remedy = "For example, place=ph.Place(latitude=48.14, longitude=11.58)."
        check.refuse("place", given, "a Place", remedy)
    return given


def pvlib(argument: str = "place") -> Any:
    """Import and return pvlib.

    Raises
    ------
    ValueError
        If pvlib is missing. `argument` is the argument that needs pvlib; the message names it.
    """
    if importlib.util.find_spec("pvlib") is None:
        check.refuse(argument, "no pvlib", "used with the package pvlib", "Run: pip install pvlib.")
    return importlib.import_module("pvlib")


# --- times


def moments(times: Any) -> Any:
    """Return times as a pandas.DatetimeIndex with a time zone.

    Parameters
    ----------
    times : datetime_like
        One time or a sequence: datetimes or pandas times with a time zone, ISO 8601 texts with a UTC offset, or NumPy's
        datetime64, which is UTC.

    Raises
    ------
    ValueError
        If times lack a zone, have several zones, are before 1950, are not times, or there are none.
    """
    pvlib("times")
    pandas = importlib.import_module("pandas")
    if isinstance(times, (np.ndarray, np.datetime64)) and times.dtype.kind == "M":
        found = pandas.DatetimeIndex(np.atleast_1d(times), tz="UTC")
    elif isinstance(times, (pandas.DatetimeIndex, pandas.Series)):
        found = _index_of(times, pandas)
    else:
        is_single = isinstance(times, (str, datetime)) or not np.iterable(times)
        stamps = [_stamp_of(time, pandas) for time in ([times] if is_single else times)]
        zones = {str(stamp.tz) for stamp in stamps}
        if len(zones) > 1:
            remedy = "Convert them with pandas.to_datetime(times, utc=True)."
            check.refuse("times", f"times in the zones {', '.join(sorted(zones))}", "in one time zone", remedy)
        found = pandas.DatetimeIndex(stamps)
    if not len(found):
        check.refuse("times", "none", "at least one time")
    if found.isna().any():
        check.refuse("times", "NaT", "times without gaps")
    if found.tz is None:
        remedy = "Add a UTC offset, as in 2026-06-21T10:00+02:00, or use times.tz_localize('Europe/Berlin')."
        check.refuse("times", str(found[0]), "times with a time zone", remedy)
    if found.year.min() < _FIRST_YEAR:
        remedy = "The Earth's rotation is tabulated from then on."
        check.refuse("times", str(found[found.year.argmin()]), f"in {_FIRST_YEAR} or later", remedy)
    return found


def _index_of(times: Any, pandas: Any) -> Any:
    """Convert `times`, a pandas object, to a pandas.DatetimeIndex; `pandas` is the module.

    Numbers are refused, because pandas would read them as nanoseconds.
    """
    if times.dtype.kind not in "MO":
        check.refuse("times", f"values of the type {times.dtype}", "times, such as 2026-06-21T10:00+02:00")
    return pandas.DatetimeIndex([_stamp_of(time, pandas) for time in times] if times.dtype.kind == "O" else times)


def _stamp_of(time: Any, pandas: Any) -> Any:
    """Convert one time to a pandas.Timestamp; `pandas` is the module."""
    if isinstance(time, (str, datetime, np.datetime64)):
        try:
            stamp = pandas.Timestamp(time)
        except (ValueError, OverflowError):
            stamp = pandas.NaT
        if stamp is not pandas.NaT:
            return stamp
    return check.refuse("times", time, "times, such as 2026-06-21T10:00+02:00")


# --- the sun


class SunPosition(NamedTuple):
    """Position of the sun at n times."""

    azimuth: Float64Array
    """Angle in degrees clockwise from north, from 0 to 360, shape (n,)."""
    altitude: Float64Array
    """Angle above the horizon in degrees, with refraction, shape (n,). Negative at night."""
    direction: Float64Array
    """Unit vectors to the sun in the mesh's coordinates, shape (n, 3)."""


def sun_position(times: Any, place: Place) -> SunPosition:
    """Compute the position of the sun.

    Parameters
    ----------
    times : datetime_like
        One time or n times: datetimes or pandas times with a time zone, ISO 8601 texts with a UTC offset, or NumPy's
        datetime64, which is UTC.
    place : Place
        Place on the Earth, and the directions of its zenith and north in the mesh's coordinates.

    Returns
    -------
    SunPosition
        `azimuth` and `altitude` in degrees, shape (n,), and `direction`, unit vectors to the sun, shape (n, 3). The
        altitude includes refraction at the place's mean pressure and 12 °C.

    Raises
    ------
    ValueError
        If times lack a zone, have several zones or are before 1950, or pvlib (the extra `sun`) is not installed.

    References
    ----------
    I. Reda, A. Andreas, "Solar position algorithm for solar radiation applications", NREL/TP-560-34302, 2008, as
    implemented in pvlib (W. Holmgren et al. 2018, doi:10.21105/joss.00884).

    Examples
    --------
    >>> import pvphong as ph
    >>> sun = ph.sun_position("2026-06-21T12:00+02:00", ph.Place(48.14, 11.58))
    >>> round(float(sun.azimuth[0])), round(float(sun.altitude[0]))
    (142, 61)
    """
    index, place = moments(times), checked_place(place)
    solar = pvlib().solarposition.get_solarposition(index, place.latitude, place.longitude, altitude=place.altitude)
    azimuth, altitude = (solar[name].to_numpy(np.float64) for name in ("azimuth", "apparent_elevation"))
    around, above = np.radians(azimuth), np.radians(altitude)
    level = np.cos(above)
    local = np.stack([level * np.sin(around), level * np.cos(around), np.sin(above)], axis=1)
    return SunPosition(azimuth, altitude, local @ place.axes)


# --- irradiances


class Irradiances(NamedTuple):
    """Irradiances at n times, in W/m²."""

    direct_normal: Float64Array
    """Irradiance by the sun on a surface that faces it, shape (n,)."""
    diffuse_horizontal: Float64Array
    """Irradiance by the sky on an open horizontal surface, shape (n,)."""


def clear_sky(index: Any, place: Place, turbidity: float | None = None) -> Irradiances:
    """Return the irradiances under a cloudless sky.

    `index` has the times, as from `moments`. `turbidity` is Linke's; by default it is read from pvlib's monthly map,
    which takes a third of the time. Source: P. Ineichen, R. Perez, "A new airmass independent formulation for the Linke
    turbidity coefficient", 2002.
    """
    library = pvlib("weather=None")
    where = library.location.Location(place.latitude, place.longitude, altitude=place.altitude)
    with warnings.catch_warnings():  # pvlib calls deprecated functions of pandas 3
        warnings.simplefilter("ignore", DeprecationWarning)
        found = where.get_clearsky(index, **({} if turbidity is None else {"linke_turbidity": turbidity}))
    return Irradiances(found["dni"].to_numpy(np.float64), found["dhi"].to_numpy(np.float64))


@lru_cache(maxsize=64)
def linke_turbidity(latitude: float, longitude: float, day: datetime) -> float:
    """Return the turbidity of a clear sky at noon of a day, from pvlib's monthly map."""
    library, pandas = pvlib(), importlib.import_module("pandas")
    noon = pandas.DatetimeIndex([datetime(day.year, day.month, day.day, 12)], tz="UTC")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        return float(library.clearsky.lookup_linke_turbidity(noon, latitude, longitude).iloc[0])


def extraterrestrial(index: Any) -> Float64Array:
    """Return the sun's irradiance above the atmosphere in W/m², shape (n,). It varies with the distance of the sun.

    `index` has the n times, as from `moments`.
    """
    return np.asarray(pvlib().irradiance.get_extra_radiation(np.asarray(index.day_of_year)), np.float64)
