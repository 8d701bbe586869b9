"""Where inside triangles colours bend or jump: samples that no fixed pattern would hit.

Each crease is where a value changes its sign: n·l where a light's dark side begins, n·v where a two-sided surface
turns, a spot's angle at the edge of its cone, a highlight's cosine where it is cut off, a colour where it saturates.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pvphong.base.types import Float64Array, FloatArray
from pvphong.base.vectors import columns, dot
from pvphong.shading.equation import Equation
from pvphong.shading.inside.peaks import Places, chords, to_viewer

# How far beside a crease, in parts of a side, a jump's two sides are looked at.
_ASIDE = 2.0**-5

# From this shininess on, a highlight has no bend where its cosine reaches zero.
_SMOOTH = 2.0


def creases(points: Float64Array, normals: Float64Array, equation: Equation) -> Iterator[Places]:
    """Where triangles cross a crease of the lighting.

    Parameters
    ----------
    points, normals, equation
        As for `peaks`.
    """
    for values in _values(points.reshape(-1, 3), normals.reshape(-1, 3), equation):
        yield from sign_changes(values.reshape(-1, 3))


def sign_changes(values: FloatArray) -> Iterator[Places]:
    """Where a value changes its sign in triangles: on two sides, half-way between, and a little beside each.

    Parameters
    ----------
    values : ndarray
        Shape (m, 3): at each triangle's corners, and linear between.
    """
    above = values > 0.0
    rows = np.flatnonzero(above.any(axis=1) & ~above.all(axis=1) & np.isfinite(values).all(axis=1))
    values, above = values[rows], above[rows]
    alone = (above == (above.sum(axis=1) == 1)[:, None]).argmax(axis=1)  # the corner whose sign no other has
    turn = (alone[:, None] + np.arange(3)) % 3
    values = np.take_along_axis(values, turn, axis=1)
    crossing = values[:, :1] / (values[:, :1] - values[:, 1:])
    for aside in (0.0, -_ASIDE, _ASIDE):
        along = np.clip(crossing + aside, 0.0, 1.0)
        ends = np.zeros((2, len(rows), 3))
        for end in range(2):
            np.put_along_axis(ends[end], turn[:, :1], 1.0 - along[:, end : end + 1], axis=1)
            np.put_along_axis(ends[end], turn[:, end + 1 : end + 2], along[:, end : end + 1], axis=1)
        for weights in (*ends, ends.mean(axis=0)):
            yield Places(rows, weights)


def _values(points: Float64Array, normals: Float64Array, equation: Equation) -> Iterator[FloatArray]:
    """For each crease the value (k,) that changes its sign there, at points and normals (k, 3)."""
    p, n = columns(points), columns(normals)
    if equation.two_sided:
        yield dot(n, to_viewer(p, equation))
    for term in equation.terms:
        to_light = term.light.arrival(p).direction
        if term.needs_normals:
            yield dot(n, to_light)  # with the normal's length: so it is linear under a distant light
        yield from term.light.edges(to_light)
        if equation.has(term, "specular") and 0.0 < equation.reflectance.sharpness < _SMOOTH:
            chord = chords(term, equation)(points, normals)
            yield 1.0 - np.einsum("ki,ki->k", chord, chord) / 2.0
