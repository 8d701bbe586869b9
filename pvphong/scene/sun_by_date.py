"""A clear sky and its sun by place, day of the year and hour, for the set-up "sun" and its sliders."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import cached_property, partial
from typing import Any, Literal, get_args

from pvphong.base import check
from pvphong.base.types import VectorLike
from pvphong.optics.lights import Light
from pvphong.scene.daylight import daylight_scene, sun_light
from pvphong.scene.sun import Irradiances, Place, SunPosition, clear_sky, linke_turbidity, moments, sun_position

Up = Literal["z", "y"]

_YEAR = 2026
_DEGREES_PER_HOUR = 15.0
# W/m² from the sun and the sky below which it counts as night: the sun is about 1° high then.
_NIGHT = 1.0
_AXES: Mapping[str, tuple[VectorLike, VectorLike]] = {
    "z": ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
    "y": ((0.0, 1.0, 0.0), (0.0, 0.0, -1.0)),
}
"""Up axis → directions to the zenith and to the north."""
_QUARTERS = "north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west"


@dataclass(frozen=True)
class SunByDate:
    """Place, day and hour that define the sun and a clear sky.

    Parameters
    ----------
    latitude : float, default 48.14
        Degrees, north positive.
    longitude : float, default 11.58
        Degrees, east positive.
    day : int, default 172
        Day of the year, from 1 to 365: 80 is 21 March, 172 is 21 June, 266 is 23 September, 355 is 21 December.
    hour : float, default 10
        Time of the day in hours, in the zone of the longitude: one hour for 15 degrees. No daylight saving time.
    up : {"z", "y"}
        Axis of the mesh that points up. North is +y if z is up, and -z if y is up.

    Raises
    ------
    ValueError
        If a field is out of range.
    """

    latitude: float = check.field(partial(check.number, at_least=-90.0, at_most=90.0), 48.14, unit="°")
    longitude: float = check.field(partial(check.number, at_least=-180.0, at_most=180.0), 11.58, unit="°")
    day: int = check.field(partial(check.whole, at_least=1, at_most=365), 172)
    hour: float = check.field(partial(check.number, at_least=0.0, at_most=24.0), 10.0)
    up: Up = check.field(partial(check.choice, allowed=get_args(Up)), "z")

    def __post_init__(self) -> None:
        check.fields(self)

    @property
    def zone(self) -> int:
        """Hours by which the time is ahead of UTC."""
        return round(self.longitude / _DEGREES_PER_HOUR)

    @property
    def place(self) -> Place:
        """The place, with the directions of its zenith and north."""
        up, north = _AXES[self.up]
        return Place(self.latitude, self.longitude, up=up, north=north)

    @property
    def time(self) -> datetime:
        """The date and the time of the day, without a zone."""
        return datetime(_YEAR, 1, 1) + timedelta(days=self.day - 1, hours=self.hour)

    @cached_property
    def _index(self) -> Any:
        if importlib.util.find_spec("pvlib") is None:
            raise ValueError('The set-up "sun" needs the extra "sun". Run: pip install pvlib.')
        return moments(f"{(self.time - timedelta(hours=self.zone)).isoformat()}+00:00")

    @cached_property
    def position(self) -> SunPosition:
        """Position of the sun."""
        return sun_position(self._index, self.place)

    @cached_property
    def irradiances(self) -> Irradiances:
        """Irradiances under a clear sky."""
        day = datetime(_YEAR, 1, 1) + timedelta(days=self.day - 1)
        return clear_sky(self._index, self.place, linke_turbidity(self.latitude, self.longitude, day))

    @property
    def brightest(self) -> float:
        """Irradiance of an open surface that faces the sun, in W/m²; 0 at night."""
        found = float(self.irradiances.direct_normal[0] + self.irradiances.diffuse_horizontal[0])
        return found if self.position.altitude[0] > 0.0 and found >= _NIGHT else 0.0

    @property
    def sun(self) -> Light:
        """The sun, in W/m²; it must be day."""
        return sun_light(self.position, float(self.irradiances.direct_normal[0]))

    def lights(self, scale: float = 1.0) -> tuple[Light, ...]:
        """Return the sun and the sky, in W/m² times `scale`.

        Raises
        ------
        ValueError
            If it is night, or pvlib (the extra `sun`) is not installed.
        """
        if not self.brightest:
            night = self.words[0].lower() + self.words[1:].removesuffix(".")
            check.refuse("hour", f"{self.hour:g}, {night}", "between sunrise and sunset")
        direct, diffuse = (float(each[0]) for each in self.irradiances)
        sky: dict[str, Any] = {"direct_normal": direct, "diffuse_horizontal": diffuse, "scale": scale}
        return tuple(daylight_scene(self._index, self.place, **sky).lights)

    @property
    def words(self) -> str:
        """A sentence on the sun, with the time and its zone."""
        when = f"{self.time.day} {self.time:%B}, {self.time:%H:%M} UTC{self.zone:+d}"
        altitude = round(float(self.position.altitude[0]))
        if not self.brightest:
            return f"Night: on {when} the sun is {f'{-altitude}° below' if altitude < 0 else 'on'} the horizon."
        quarter = _QUARTERS[round(float(self.position.azimuth[0]) / 45.0) % 8]
        return f"On {when} the sun is {altitude}° high in the {quarter}."
