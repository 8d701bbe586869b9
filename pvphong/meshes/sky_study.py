"""A study of daylight but for its mesh: times and a place, and what the sun, the sky and the ground send then."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, IntArray
from pvphong.optics.area.patches import Patches
from pvphong.optics.sky import radiances
from pvphong.rays.daylight import Sources, SunBins, sun_bins
from pvphong.scene.sun import Irradiances, Place, checked_place, extraterrestrial, moments, sun_position

_SECONDS_PER_HOUR = 3600.0
# Number of patches → number of parts of the sides of Tregenza's patches.
_FINER = {145: 1, 577: 2}
# Number of points in each patch at which a sky's radiance is computed, and of times whose skies are computed together.
_POINTS, _TIMES_AT_ONCE = 4, 256


def microseconds(index: Any) -> IntArray:
    """Return times as microseconds since 1970 in UTC."""
    return np.asarray(index.as_unit("us").asi8)


class Moments(NamedTuple):
    """Times at a place, and the sun there."""

    index: Any
    """The t times, a pandas.DatetimeIndex."""
    hours: float
    """Hours for which each time stands."""
    to_sun: Float64Array
    """Unit vectors to the sun, shape (t, 3)."""
    is_day: Any
    """True where the sun is above the horizon, shape (t,)."""
    bins: SunBins

    @classmethod
    def of(cls, times: Any, place: Place, degrees: float) -> Self:
        """Check times, and compute the positions of the sun and their bins."""
        index = moments(times)
        steps = np.diff(microseconds(index)) / (1e6 * _SECONDS_PER_HOUR)
        hours = float(steps.min(initial=math.inf)) if len(steps) else 1.0
        if hours <= 0.0:
            got = index[int(steps.argmin()) + 1].isoformat()
            check.refuse("times", f"{got} after a later or equal time", "in ascending order", "Sort them.")
        if len(steps) and not np.allclose(steps / hours, np.rint(steps / hours), rtol=0.0, atol=1e-3):
            remedy = "For example pandas.date_range(start, end, freq='h', tz='Europe/Berlin')."
            check.refuse("times", "uneven steps", f"in steps that are multiples of the least, {hours:g} h", remedy)
        sun = sun_position(index, place)
        is_day = sun.altitude > 0.0
        return cls(index, hours, sun.direction, is_day, sun_bins(sun.direction, is_day, degrees))


@dataclass(frozen=True, eq=False)
class SkyStudy:
    """Times at a place, with the patches of the sky and the positions of the sun to which rays are cast.

    Attributes
    ----------
    moments : Moments
        The times, and the sun then.
    place : Place
        The place.
    patches : Patches
        Patches of the sky.
    samples : int
        Number of rays to each patch.
    albedo : float
        Fraction of the light that the open ground reflects.
    """

    moments: Moments
    place: Place
    patches: Patches
    samples: int
    albedo: float

    @classmethod
    def of(cls, times: Any, place: Place, *, albedo: float, patches: float, samples: int, sun_bin: float) -> SkyStudy:
        """Check the arguments, which are those of `mesh.phong.daylight`, and compute the positions of the sun."""
        place, count = checked_place(place), check.number("patches", patches)
        if count not in _FINER:
            check.refuse("patches", patches, "145 or 577")
        rays = check.whole("samples", samples, at_least=2, at_most=64)
        when = Moments.of(times, place, check.number("sun_bin", sun_bin, at_least=0.0, at_most=5.0))
        albedo = check.number("albedo", albedo, at_least=0.0, at_most=1.0)
        return SkyStudy(when, place, Patches(_FINER[int(count)]), rays, albedo)

    def sources(self, weather: Irradiances) -> Sources:
        """Return what the sun, the sky and the ground send in a weather, summed over the times."""
        index, hours, to_sun, is_day, bins = self.moments
        axes, patches = self.place.axes, self.patches
        direct, local = np.where(is_day, weather.direct_normal, 0.0), to_sun @ axes.T
        points = patches.points(_POINTS)
        level = np.repeat(patches.moments[:, 2] / points.shape[1], points.shape[1])
        lit = weather.diffuse_horizontal > 0.0
        given = local[lit], direct[lit], weather.diffuse_horizontal[lit], extraterrestrial(index)[lit]
        sky = np.zeros(len(patches) * points.shape[1])
        for some in np.array_split(np.arange(lit.sum()), max(int(lit.sum()) // _TIMES_AT_ONCE, 1)):
            sky += radiances("perez", points.reshape(-1, 3), level, *(each[some] for each in given)).sum(axis=0)
        count, of_days = len(bins.directions), bins.of_times[is_day]
        sun = [np.bincount(of_days, (direct * each)[is_day], count) for each in to_sun.T]
        on_ground = weather.diffuse_horizontal + direct * np.maximum(local[:, 2], 0.0)
        return Sources(
            hours * sky.reshape(len(patches), -1).mean(axis=1),
            hours * self.albedo / math.pi * float(on_ground.sum()),
            np.asarray(hours * np.stack(sun, axis=1).reshape(count, 3), np.float64),
            np.asarray(hours * np.bincount(of_days, minlength=count), np.float64),
        )
