"""Matplotlib's `LightSource` as a peer: it lights height fields by one distant light, without highlights."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pvphong.base.types import Float64Array, FloatArray, IntArray, MatrixLike, Vector
from pvphong.geometry.transform import transform_normals, transform_points
from pvphong.shading.equation import Equation

# By how much of a step a coordinate may be off its place in a regular grid: rounding to float32, generously.
_OFF_PLACE = 1e-3

_NO_GRID = "it lights height fields: one point at each place of a regular grid in x and y"


class HeightField(NamedTuple):
    """Heights over a regular grid, as Matplotlib takes them: rows from north to south, columns from west to east."""

    heights: Float64Array
    """(rows, columns): z."""

    vertices: IntArray
    """(rows, columns): the number of the vertex at each place."""

    spacing: tuple[float, float]
    """Steps in x and y, > 0."""


def height_field(points: FloatArray, normals: FloatArray, matrix: MatrixLike | None = None) -> HeightField:
    """Vertices as heights over a regular grid in x and y.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3), in any order.
    matrix : array_like, optional
        (4, 4) model matrix; what it gives is the height field.

    Raises
    ------
    ValueError
        If they are none; the message says why.
    """
    placed = points.astype(np.float64) if matrix is None else transform_points(points.astype(np.float64), matrix)
    upright = normals if matrix is None else transform_normals(normals, matrix)
    if not np.isfinite(placed).all():
        raise ValueError("it lights height fields, and some points are not finite")
    (column, dx), (row, dy) = (_places(placed[:, axis]) for axis in (0, 1))
    rows, columns = int(row.max()) + 1, int(column.max()) + 1
    number = (rows - 1 - row) * columns + column
    if min(rows, columns) < 2 or rows * columns != len(points) or not (np.bincount(number) == 1).all():
        raise ValueError(_NO_GRID)
    if not (upright[:, 2] > 0.0).all():
        raise ValueError("it lights height fields from above, and not all normals point up")
    vertices = np.argsort(number).reshape(rows, columns)
    return HeightField(placed[vertices, 2], vertices, (dx, dy))


def _places(values: Float64Array) -> tuple[IntArray, float]:
    """The number of each value's place in an even row, and the step from place to place; refuses uneven ones."""
    low, high = float(values.min()), float(values.max())
    widest = float(np.diff(np.sort(values)).max(initial=0.0))
    steps = round((high - low) / widest) if widest else 0
    step = (high - low) / steps if steps else 1.0
    places: IntArray = np.rint((values - low) / step).astype(np.intp)
    if np.abs(values - (low + places * step)).max() > _OFF_PLACE * step:
        raise ValueError(_NO_GRID)
    return places, step


def the_sun(equation: Equation) -> Vector:
    """Towards the one light that Matplotlib can stand for; raises ``ValueError`` for another scene."""
    light = equation.terms[0].light if len(equation.terms) == 1 else None
    if light is None or not light.is_even or light.has_size:
        raise ValueError("it knows one directional light, no more, no other")
    if equation.has(equation.terms[0], "specular"):
        raise ValueError("it knows no highlights")
    if equation.has_screen:
        raise ValueError("it casts no shadows")
    if equation.two_sided:
        raise ValueError("it lights one side of a surface")
    x, y, z = light.arrival(np.zeros((3, 1))).direction[:, 0].tolist()
    return x, y, z


def hillshading(field: HeightField, equation: Equation) -> Callable[[], Float64Array]:
    """Colours (rows, columns, 3) of a height field: the diffuse term by Matplotlib, the rest as it is.

    `LightSource.hillshade` makes normals of its own from differences of heights, takes n·l, and stretches it so
    that the least becomes 0 and the greatest 1; a plane keeps its n·l.

    Raises
    ------
    ValueError
        If Matplotlib is not installed, or cannot stand for the scene.
    """
    east, north, up = the_sun(equation)
    try:
        from matplotlib.colors import LightSource
    except ImportError as error:
        raise ValueError('Matplotlib is not installed: pip install "pvphong[plot]"') from error
    azimuth = 90.0 - math.degrees(math.atan2(north, east))  # Matplotlib's is clockwise from north
    source = LightSource(azimuth, math.degrees(math.atan2(up, math.hypot(east, north))))
    (term,) = equation.terms
    diffuse = term.gain * np.array(term.colors[0])
    constant = np.array(equation.emission) + np.array(equation.ambient) + term.gain * np.array(term.ambient)
    dx, dy = field.spacing

    def run() -> Float64Array:
        colors: Float64Array = constant + diffuse * source.hillshade(field.heights, dx=dx, dy=dy)[:, :, None]
        return np.clip(colors, 0.0, 1.0) if equation.clamp else colors

    return run
