"""Photometry of lamps: luminous intensity by direction, as goniophotometers measure it.

A lamp has a photometric zero d, the direction of the vertical angle 0; a direction u across it, the horizontal angle 0;
and r = d × u, to the right of u as seen from behind the lamp. A goniophotometer of type

- C turns around d: V is the angle from d, and H the angle around d from u towards −r;
- A turns around u: V is the elevation towards u, and H the angle around u from d towards r;
- B turns around r: V is the angle around r from d towards u, and H the elevation towards r.

(ANSI/IESNA LM-63-2002, section 3; IESNA LM-75.) So each type is a grid of polar angles θ from a pole and azimuths φ
around it. `Photometry` holds the measured numbers, and `Grid` the numbers that a light reads: rows and columns at equal
steps, between which intensities are interpolated linearly, as between the measured angles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, FloatArray, Vector

Kind = Literal["A", "B", "C"]

# Least steps of a grid in degrees, of rows and of columns; and the precision of angles.
_LEAST_STEPS, _PRECISE = (0.25, 0.5), 100


def _numbers(text: str) -> Float64Array:
    return np.array([float(word) for word in text.split()])


def _text(numbers: Any) -> str:
    return " ".join(repr(float(number)).removesuffix(".0") for number in numbers)


class Grid(NamedTuple):
    """Intensities at equal steps of the angles θ and φ, and the directions from which these angles are measured."""

    axes: tuple[str, str, str]
    """Names of the pole, of the direction φ = 0, and of φ = 90°: "d", "u", "r", or "-r" for the opposite of r."""
    start: tuple[float, float]
    """Least θ and φ, in degrees."""
    step: tuple[float, float]
    """Steps of θ and φ, in degrees."""
    candela: Float64Array
    """Intensities, shape (rows, columns), at least two of each; there is no light outside of the grid."""


@dataclass(frozen=True)
class Photometry:
    """Luminous intensities of a lamp, in candela, as a file gives them.

    Numbers are stored as text, so that scene files stay short and readable.

    Parameters
    ----------
    kind : {"A", "B", "C"}
        Type of the goniophotometer, as in the module's docstring.
    vertical, horizontal : str
        Angles in degrees, ascending. Symmetries are as in LM-63: for type C, horizontal angles end at 0, 90, 180 or
        360, or run from 90 to 270; for types A and B, angles that start at 0 hold for negative angles too.
    candela : tuple of str
        For each horizontal angle, the intensity at each vertical angle. All factors except the tilt's are included.
    tilt : str, optional
        Tilt angles in degrees, followed by the same number of factors. All intensities are multiplied by the factor at
        the lamp's tilt.
    tilt_axis : {1, 2, 3}
        Axis of the bare lamp, from whose orientation the tilt is computed: 1 along d, 2 along r, 3 along u.

    Raises
    ------
    ValueError
        If the numbers contradict each other.
    """

    kind: Kind
    vertical: str
    horizontal: str
    candela: tuple[str, ...]
    tilt: str = ""
    tilt_axis: int = 1

    def __post_init__(self) -> None:
        check.choice("kind", self.kind, ("A", "B", "C"))
        vertical, horizontal = self.angles
        for name, angles in (("vertical", vertical), ("horizontal", horizontal)):
            if not len(angles) or not np.isfinite(angles).all() or (np.diff(angles) <= 0.0).any():
                check.refuse(f"{name} angles", _short(angles), "finite and ascending")
        low, high = (0.0, 180.0) if self.kind == "C" else (-90.0, 90.0)
        if vertical[0] < low or vertical[-1] > high or len(vertical) < 2:
            check.refuse(
                "vertical angles", _short(vertical), f"two or more, from {low:g} to {high:g} for type {self.kind}"
            )
        self._refuse_horizontal(horizontal)
        rows = [_numbers(row) for row in self.candela]
        if len(rows) != len(horizontal) or any(len(row) != len(vertical) for row in rows):
            got = f"{sum(map(len, rows))} numbers in {len(rows)} rows"
            check.refuse("candela", got, f"{len(horizontal)} rows of {len(vertical)} numbers, as there are angles")
        values = np.array(rows)
        if not np.isfinite(values).all() or values.min() < 0.0:
            worst = values[~(np.isfinite(values) & (values >= 0.0))][0]
            check.refuse("candela", f"{worst:g}", "finite numbers >= 0")
        if not values.any():
            check.refuse("candela", "zeros only", "numbers that are not all 0")
        angles, factors = self.tilt_factors
        if len(angles) != len(factors) or (np.diff(angles) <= 0.0).any() or not (factors >= 0.0).all():
            check.refuse("tilt", self.tilt, "ascending angles, followed by the same number of factors >= 0")
        if self.tilt_axis not in (1, 2, 3):
            check.refuse("tilt_axis", self.tilt_axis, "1, 2 or 3")

    def _refuse_horizontal(self, angles: Float64Array) -> None:
        first, last = float(angles[0]), float(angles[-1])
        if self.kind == "C":
            allowed = "0 to 0, 90, 180 or 360 degrees, or 90 to 270, for type C"
            is_sound = (first == 0.0 and last in (0.0, 90.0, 180.0, 360.0)) or (first, last) == (90.0, 270.0)
        else:
            allowed = f"two or more, from -90 or 0 up to 90 degrees, for type {self.kind}"
            is_sound = len(angles) > 1 and -90.0 <= first <= 0.0 and last <= 90.0
        if not is_sound:
            check.refuse("horizontal angles", _short(angles), allowed)

    def __repr__(self) -> str:
        vertical, horizontal = self.angles
        return f"<photometry of type {self.kind}, {len(vertical)} x {len(horizontal)} angles, {self.most:.4g} cd>"

    @cached_property
    def angles(self) -> tuple[Float64Array, Float64Array]:
        """The vertical and horizontal angles, in degrees."""
        return _numbers(self.vertical), _numbers(self.horizontal)

    @property
    def tilt_factors(self) -> tuple[Float64Array, Float64Array]:
        """Tilt angles in degrees, and the factor of the intensities at each of them: two arrays."""
        numbers = _numbers(self.tilt)
        return numbers[: len(numbers) // 2], numbers[len(numbers) // 2 :]

    @cached_property
    def most(self) -> float:
        """Largest intensity in candela."""
        return max(float(_numbers(row).max()) for row in self.candela)

    @cached_property
    def grid(self) -> Grid:
        """Intensities in equal steps of both angles.

        Directions that the file omits because of a symmetry are included.
        """
        vertical, horizontal = self.angles
        rows = np.array([_numbers(row) for row in self.candela])  # (horizontal, vertical)
        if self.kind == "C":
            around, rows = _all_around(horizontal, rows)
            return _even(("d", "u", "-r"), vertical, around, rows.T)
        if vertical[0] == 0.0:
            vertical, rows = np.concatenate([-vertical[:0:-1], vertical]), np.hstack([rows[:, :0:-1], rows])
        if horizontal[0] == 0.0:
            horizontal, rows = np.concatenate([-horizontal[:0:-1], horizontal]), np.vstack([rows[:0:-1], rows])
        if self.kind == "A":
            return _even(("u", "d", "r"), 90.0 - vertical[::-1], horizontal, rows.T[::-1])
        return _even(("r", "d", "u"), 90.0 - horizontal[::-1], vertical, rows[::-1])

    @cached_property
    def lumens(self) -> float:
        """Luminous flux in lumens: the integral of the intensities over all directions.

        The factor of a tilt is not included.
        """
        grid = self.grid
        theta, phi = (
            np.radians(start + step * np.arange(count))
            for start, step, count in zip(grid.start, grid.step, grid.candela.shape, strict=True)
        )
        # ∫ sin θ times the hat functions of a row: exact for intensities that are linear in the angles
        width = theta[1] - theta[0]
        inner = 2.0 * np.sin(theta) * (1.0 - math.cos(width)) / width
        half = (width - math.sin(width)) / width
        ends = np.array([math.cos(theta[0]) * half, -math.cos(theta[-1]) * half])
        inner[[0, -1]] = 0.5 * inner[[0, -1]] + ends
        across = np.full(len(phi), phi[1] - phi[0])
        across[[0, -1]] *= 0.5
        return float(inner @ grid.candela @ across)

    def tilt_factor(self, d: Vector, u: Vector, r: Vector) -> float:
        """Return the factor by which the lamp's tilt changes its intensities; 1 without tilt factors.

        d, u and r are the lamp's axes, unit vectors in the world, in which up is +z. The tilt is the angle by which
        the bare lamp has turned from its orientation in a lamp that aims straight down.
        """
        angles, factors = self.tilt_factors
        if not len(angles):
            return 1.0
        if self.tilt_axis == 1:
            tilt = math.acos(min(max(-d[2], -1.0), 1.0))
        else:
            tilt = math.asin(min(abs((r if self.tilt_axis == 2 else u)[2]), 1.0))
        tilt = math.degrees(tilt)
        return float(np.interp(min(tilt, 180.0 - tilt) if angles[-1] <= 90.0 else tilt, angles, factors))

    @classmethod
    def of(
        cls,
        kind: Kind,
        vertical: FloatArray,
        horizontal: FloatArray,
        candela: FloatArray,
        tilt: tuple[int, Float64Array, Float64Array] | None = None,
    ) -> Photometry:
        """Make a photometry from arrays.

        `vertical` and `horizontal` are the angles in degrees, and `candela` the intensities, shape (horizontal,
        vertical). `tilt` has the number of the axis, the tilt angles and the factors.
        """
        rows = tuple(_text(row) for row in candela)
        axis, angles, factors = tilt or (1, np.empty(0), np.empty(0))
        return cls(kind, _text(vertical), _text(horizontal), rows, _text([*angles, *factors]), axis)


def _short(angles: Float64Array) -> str:
    return " ".join(f"{angle:g}" for angle in angles[:3]) + (f" … {angles[-1]:g}" if len(angles) > 3 else "")


def _all_around(horizontal: Float64Array, rows: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Extend the horizontal angles of type C to −180° to 180°, and return the angles and their rows of intensities.

    Angles that the file omits because of a symmetry are included.
    """
    last = horizontal[-1]
    if last == 0.0:
        return np.array([-180.0, 180.0]), np.repeat(rows, 2, axis=0)
    if last == 90.0:
        horizontal, rows = np.concatenate([horizontal, 180.0 - horizontal[-2::-1]]), np.vstack([rows, rows[-2::-1]])
    if last == 270.0:  # symmetric to the plane of 90° and 270°
        horizontal, rows = np.concatenate([180.0 - horizontal[:0:-1], horizontal]), np.vstack([rows[:0:-1], rows])
    elif horizontal[-1] == 180.0:
        horizontal, rows = np.concatenate([-horizontal[:0:-1], horizontal]), np.vstack([rows[:0:-1], rows])
    whole = np.concatenate([horizontal[:-1] - 360.0, horizontal[:-1], horizontal[:-1] + 360.0, horizontal[-1:] + 360.0])
    tiled = np.vstack([rows[:-1]] * 3 + [rows[-1:]])
    inside = np.unique(np.concatenate([[-180.0, 180.0], whole[(whole > -180.0) & (whole < 180.0)]]))
    return inside, np.stack([np.interp(inside, whole, column) for column in tiled.T], axis=1)


def _even(axes: tuple[str, str, str], theta: Float64Array, phi: Float64Array, rows: Float64Array) -> Grid:
    """Interpolate intensities to a grid with equal steps.

    Parameters
    ----------
    axes : tuple of str
        Axes of the grid.
    theta, phi : ndarray
        Measured angles in degrees, shapes (a,) and (b,).
    rows : ndarray
        Intensities at these angles, shape (a, b).

    Returns
    -------
    Grid
        Its steps are from `_step_of`: all measured angles are on the grid, unless the steps would be too small.
    """
    steps = tuple(map(_step_of, (theta, phi), _LEAST_STEPS))
    counts = [round((angles[-1] - angles[0]) / step) + 1 for angles, step in zip((theta, phi), steps, strict=True)]
    new_theta, new_phi = (np.linspace(a[0], a[-1], count) for a, count in zip((theta, phi), counts, strict=True))
    by_theta = np.stack([np.interp(new_theta, theta, column) for column in rows.T], axis=1)
    values = np.stack([np.interp(new_phi, phi, row) for row in by_theta])
    start = float(theta[0]), float(phi[0])
    return Grid(axes, start, (float(new_theta[1] - new_theta[0]), float(new_phi[1] - new_phi[0])), values)


def _step_of(angles: Float64Array, least: float) -> float:
    """Return the greatest step in degrees that divides all differences of the angles.

    If it is smaller than `least`, return a step of about `least` that divides the whole range.
    """
    differences = np.rint(np.diff(angles) * _PRECISE).astype(np.int64)
    step = float(np.gcd.reduce(differences)) / _PRECISE
    if step >= least:
        return step
    length = float(angles[-1] - angles[0])
    return length / max(round(length / least), 1)
