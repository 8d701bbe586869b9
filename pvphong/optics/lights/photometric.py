"""Light of a lamp as measured: intensities by direction, from an IES or EULUMDAT file."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, ClassVar

import numpy as np

from pvphong.base import check, documents
from pvphong.base.formulas import (
    BRIGHTEST,
    ONE,
    ZERO,
    as_type_of,
    dot,
    floor,
    formula,
    index,
    maximum,
    minimum,
    multiply_add,
    select,
    sqrt,
)
from pvphong.base.types import Float64Array, Vector, VectorLike
from pvphong.base.vectors import unit_vector
from pvphong.optics.light import Light, Pattern, PunctualParameters
from pvphong.optics.lights.aimed import Aimed
from pvphong.optics.lights.sized import across
from pvphong.optics.photometric_files import read_photometry
from pvphong.optics.photometry import Photometry
from pvphong.optics.roles import Role, Up, aim, meaning, place

_ALLOWED = "a number of candela > 0, or the path of an IES or EULUMDAT file"
# Sine of the least angle between `up` and the direction; below it, `up` is ignored.
_LEAST = 1e-9


def _photometry(name: str, value: Any) -> float | Photometry:
    if isinstance(value, Photometry):
        return value
    if isinstance(value, (str, os.PathLike)):
        return read_photometry(value)
    if isinstance(value, Mapping):
        return documents.value(name, Photometry, value)
    if isinstance(value, (int, float, np.number)):
        return check.number(name, value, above=0.0)
    return check.refuse(name, value, _ALLOWED)


# Layout of the parameters of a pattern: the three axes with the opposite sign, because light travels along −l; the
# least θ and φ; rows and columns per radian; the largest row and column; and the number of columns, with one more for
# rounding. The table begins with this number too. Then follow the intensities from 0 to 1, row by row, and two rows of
# zeros, for directions without light.
_START, _RATES, _LAST, _COLUMNS, _TABLE = 9, 11, 13, 15, 1
# Rounding at the edge of the pattern, in rows or columns.
_EDGE = 1e-3

# Coefficients of (atan t / t − 1) / t² in powers of t², by `mpmath.chebyfit`; the error of the angle is 1.1e-9.
_ARCTAN = (
    -0.064519282081204418, 0.10743731490790577, -0.14263955597984574, 0.1999954048364896, -0.3333333176116852,
)  # fmt: skip
_TAN_22_5, _EIGHTH_TURN, _TINIEST = math.sqrt(2.0) - 1.0, 0.25 * math.pi, 2.0**-100


@formula
def _angle(y: Any, x: Any) -> Any:
    """Return the angle of a point, in [−π, π], in the type of its coordinates; 0 at the origin.

    Angles are reduced to 22.5° by symmetry and a turn by 45°.
    """
    height, width = maximum(y, -y), maximum(x, -x)
    low, high = minimum(height, width), maximum(maximum(height, width), as_type_of(x, _TINIEST))
    is_steep = low > as_type_of(x, _TAN_22_5) * high
    t = select(is_steep, low - high, low) / select(is_steep, low + high, high)
    square = t * t
    rest = as_type_of(x, _ARCTAN[0])
    for k in range(1, len(_ARCTAN)):
        rest = multiply_add(rest, square, as_type_of(x, _ARCTAN[k]))
    turned = multiply_add(t * square, rest, t)
    turned = select(is_steep, turned + as_type_of(x, _EIGHTH_TURN), turned)
    turned = select(height > width, as_type_of(x, 2.0 * _EIGHTH_TURN) - turned, turned)
    turned = select(x < ZERO, as_type_of(x, 4.0 * _EIGHTH_TURN) - turned, turned)
    return select(y < ZERO, -turned, turned)


@formula
def place_of(own: Any, l: Any) -> Any:
    """Return the index of the direction −l in the table, rounded down in row and column, and both remainders."""
    along = dot((own[0], own[1], own[2]), l)
    ahead, aside = dot((own[3], own[4], own[5]), l), dot((own[6], own[7], own[8]), l)
    theta, phi = _angle(sqrt(multiply_add(ahead, ahead, aside * aside)), along), _angle(aside, ahead)
    row, column = (theta - own[_START]) * own[_RATES], (phi - own[_START + 1]) * own[_RATES + 1]
    low, left = minimum(maximum(row, ZERO), own[_LAST]), minimum(maximum(column, ZERO), own[_LAST + 1])
    outside = abs(row - low) + abs(column - left)
    row, column = select(outside < as_type_of(row, _EDGE), low, own[_LAST] + ONE), left
    whole_row, whole_column = floor(row), floor(column)
    return multiply_add(whole_row, own[_COLUMNS], whole_column), row - whole_row, column - whole_column


@formula
def value_at(table: Any, place: Any, down: Any, over: Any) -> Any:
    """Return the intensity at a place from `place_of`, by bilinear interpolation."""
    at, columns = _TABLE + index(place), index(table[0])
    a, b = as_type_of(place, table[at]), as_type_of(place, table[at + 1])
    c, d = as_type_of(place, table[at + columns]), as_type_of(place, table[at + columns + 1])
    upper, lower = multiply_add(over, b - a, a), multiply_add(over, d - c, c)
    return multiply_add(down, lower - upper, upper)


@lru_cache(maxsize=64)
def _pattern(photometry: Photometry, axes: tuple[Vector, Vector, Vector]) -> Pattern:
    """Return the pattern of a lamp with the axes d, u and r."""
    grid, own = photometry.grid, dict(zip("dur", axes, strict=True))
    signs = [1.0 if name.startswith("-") else -1.0 for name in grid.axes]
    turned = [sign * x for sign, name in zip(signs, grid.axes, strict=True) for x in own[name[-1]]]
    start, rates = np.radians(grid.start), 1.0 / np.radians(grid.step)
    last = [float(count - 1) for count in grid.candela.shape]
    table = np.pad(grid.candela * (photometry.tilt_factor(*axes) / photometry.most), ((0, 2), (0, 1)))
    columns = float(table.shape[1])
    parameters = (*turned, *start.tolist(), *rates.tolist(), *last, columns)
    return Pattern(place_of, value_at, parameters, (columns, *table.ravel().tolist()))


@dataclass(frozen=True)
class PhotometricLight(Aimed, Light):
    """Lamp as measured: its intensity by direction, in candela, from an IES or EULUMDAT file.

    A surface that faces the lamp at the distance d receives the measured intensity divided by d²: lux, if the mesh's
    unit is the metre. `intensity` is a factor, 1 for the lamp as measured; for a mesh in millimetres, it is 1e6. The
    lamp is taken as a point, which is right to 1 % from five times its size on.

    Read are IES files (ANSI/IESNA LM-63 of 1986, 1991, 1995, 2002 and 2019; types A, B and C, all symmetries, tilt,
    multiplier, ballast factors) and EULUMDAT files (the first set of lamps). Between measured angles, intensities are
    linear; angles that are not multiples of a common step of at least 0.25° are resampled. Beyond the measured angles,
    there is no light.

    Parameters
    ----------
    photometry : float or path, default 1
        The file, whose numbers are kept, also in scene files; or one intensity for all directions, in candela.
    position : sequence of float, default (0, 0, 0)
        Its position, in the mesh's unit.
    direction : sequence of float, default (0, 0, -1)
        The direction of vertical and horizontal angle 0, of any length: straight down for most lamps.
    up : sequence of float, default (1, 0, 0)
        For type C, the direction of the plane of horizontal angle 0 (C0); for types A and B, that of the vertical angle
        90. Of any length; the component along `direction` is removed. If `up` is parallel to `direction`, the
        coordinate axis farthest from it replaces it.
    **common
        The fields of every light: `diffuse`, `specular`, `ambient`, `intensity`, `on`, `frame`, `name`.

    Raises
    ------
    ValueError
        If a field is out of range, or the file cannot be read, is cut short or contradicts itself; the message names
        the field.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> bulb = ph.PhotometricLight(120.0, position=(0, 0, 2))  # 120 candela; a file is ph.PhotometricLight("lamp.ies")
    >>> floor = pv.Plane(i_resolution=2, j_resolution=2).phong.irradiance(bulb)
    >>> float(floor["irradiance"][4, 0])  # lux
    30.0
    """

    photometry: Any = meaning(Role(_photometry), 1.0)
    position: VectorLike = place()
    direction: VectorLike = aim()
    up: VectorLike = meaning(Up(check.direction), (1.0, 0.0, 0.0))

    intensity_unit: ClassVar[str] = "× measured"

    @cached_property
    def measured(self) -> Photometry:
        """The intensities by direction."""
        if isinstance(self.photometry, Photometry):
            return self.photometry
        both = np.full((1, 2), self.photometry)
        return Photometry.of("C", np.array([0.0, 180.0]), np.zeros(1), both)

    @cached_property
    def axes(self) -> Float64Array:
        """Unit vectors as rows: along `direction`, to the right, and along `up`."""
        front = np.array(unit_vector(self.direction))
        side = np.cross(front, unit_vector(self.up))
        if np.linalg.norm(side) < _LEAST:
            side = across(front)[0]
        side /= np.linalg.norm(side)
        return np.stack([front, side, np.cross(side, front)])

    @property
    def curves(self) -> tuple[Float64Array, ...]:
        """Polar curves of the intensities, as on data sheets: in the plane of `direction` and `up`, and across it."""
        d, r, u = self.axes
        turn = np.radians(np.arange(0.0, 361.0, 2.5))[:, None]
        planes = [np.cos(turn) * d + np.sin(turn) * across for across in (u, r)]
        center, radius = np.array(self.places[0])[:, None], math.sqrt(self.measured.most)
        return tuple(ways * np.reshape(self.arrival(center + radius * ways.T).strength, (-1, 1)) for ways in planes)

    @property
    def attenuation(self) -> Vector:
        """Coefficients of 1/d² times the largest measured intensity."""
        return 0.0, 0.0, 1.0 / self.measured.most

    @property
    def placement(self) -> PunctualParameters:
        """Position, attenuation, and the pattern of the intensities relative to the largest one."""
        d, r, u = ((x, y, z) for x, y, z in self.axes.tolist())
        found = PunctualParameters(self.places[0], self.attenuation, pattern=_pattern(self.measured, (d, u, r)))
        return found._replace(most_gain=BRIGHTEST)  # the pattern weakens what would be clamped
