"""How far colours interpolated across triangles are from the lit ones: samples, and what they miss.

The colour inside a triangle is the linear blend of the colours at its corners. The truth is the lighting
equation at the blended point with the blended normal: per-pixel shading.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from pvphong._peaks import peaks
from pvphong._types import BoolArray, Float64Array, IntArray, MatrixLike
from pvphong.equation import Equation
from pvphong.evaluation import evaluate
from pvphong.material import Material
from pvphong.planning import make_plan
from pvphong.scene import Scene

# Samples that are held in memory at a time.
_SAMPLES = 2**18

# How much the ratio of two lengths of a normal may vary over a triangle without a difference in any colour.
_SAME_RATIO = 1e-4

# Halvings after which a difference that is still there is a jump.
_HALVINGS = 26


def _lattice(order: int) -> Float64Array:
    """Barycentric coordinates (s, 3) in multiples of 1/order, without the corners."""
    steps = [(i, j, order - i - j) for i in range(order + 1) for j in range(order + 1 - i)]
    return np.array([step for step in steps if max(step) < order]) / order


_CENTER = np.full((1, 3), 1.0 / 3.0)
_FIRST = np.concatenate([_lattice(2), _CENTER])
_MORE = np.array([weights for weights in _lattice(4) if (weights * 2.0 % 1.0).any()])


@dataclass(frozen=True)
class Lighting:
    """What a surface is lit by."""

    scene: Scene
    material: Material
    matrix: MatrixLike | None

    def colors(self, points: Float64Array, normals: Float64Array, shades: Float64Array | None) -> Float64Array:
        """(n, 3) lit colours."""
        how: dict[str, Any] = {"matrix": self.matrix, "albedo": shades, "precision": "float64", "backend": "numpy"}
        return evaluate(points, normals, self.unclamped, self.material, **how).rgb

    @cached_property
    def unclamped(self):
        return replace(self.scene, light_model=replace(self.scene.light_model, clamp=False))

    def clip(self, colors):
        return np.clip(colors,0,1) if self.scene.light_model.clamp else colors

    @cached_property
    def equation(self) -> Equation:
        """What of the lighting equation is needed anywhere."""
        nothing = np.empty((0, 3))
        return make_plan(nothing, None, self.scene, self.material, self.matrix, 0.0).equation


@dataclass(frozen=True)
class Vertices:
    """Points, and what is interpolated between them: float64 arrays of shape (n, 3).

    Attributes
    ----------
    points : ndarray
        Where they are.
    normals : ndarray
        Of the lengths with which they are blended.
    units : ndarray
        The same directions, of the lengths with which others will blend them.
    shades : ndarray or None
        Albedo in [0, 1].
    colors : ndarray
        The lit colours.
    """

    points: Float64Array
    normals: Float64Array
    units: Float64Array
    shades: Float64Array | None
    colors: Float64Array


def first_errors(vertices: Vertices, corners: IntArray, lighting: Lighting) -> Float64Array:
    """Largest error (m,) of each triangle (m, 3) at the middles of its sides, its centroid and its peaks."""
    result = _errors(vertices, corners, _FIRST, lighting)
    step = _SAMPLES // 8
    for start in range(0, len(corners), step):
        part = corners[start : start + step]
        for peak in peaks(vertices.points[part], vertices.normals[part], lighting.equation):
            missed = _misses(vertices, part[peak.rows], peak.weights[:, None], lighting)[:, 0]
            result[start + peak.rows] = np.maximum(result[start + peak.rows], missed)
    if lighting.scene.light_model.clamp:
        from pvphong._peaks import creases
        for channel in range(3):
            for peak in creases(vertices.colors[corners, channel] - 1.0):
                missed = _misses(vertices, corners[peak.rows], peak.weights[:, None], lighting)[:, 0]
                result[peak.rows] = np.maximum(result[peak.rows], missed)
    return result


def more_errors(vertices: Vertices, corners: IntArray, lighting: Lighting) -> Float64Array:
    """Largest error (m,) at further samples, and with the normals blended as others will blend them."""
    result = _errors(vertices, corners, _MORE, lighting)
    rows = np.flatnonzero(_blend_differently(vertices, corners))
    others = replace(vertices, normals=vertices.units)
    again = _errors(others, corners[rows], np.concatenate([_FIRST, _MORE]), lighting)
    result[rows] = np.maximum(result[rows], again)
    return result


def jumps(vertices: Vertices, corners: IntArray, lighting: Lighting, tolerance: float) -> BoolArray:
    """Whether the colour jumps within each triangle by more than a tolerance: no splitting would cure that.

    From the sample with the largest error to the corner whose colour differs most from it, the half that
    keeps more of the difference is halved again and again. What is left of it in the end is a jump.
    """
    samples = np.concatenate([_FIRST, _MORE])
    rows = np.arange(len(corners))
    near = samples[_misses(vertices, corners, samples, lighting).argmax(axis=1)]
    color = _truth(vertices, corners, near[:, None], lighting)[:, 0]
    corner = np.abs(lighting.clip(vertices.colors[corners]) - color[:, None]).max(axis=2).argmax(axis=1)
    far, far_color = np.eye(3)[corner], lighting.clip(vertices.colors[corners[rows, corner]])
    for _ in range(_HALVINGS):
        middle = (near + far) / 2.0
        between = _truth(vertices, corners, middle[:, None], lighting)[:, 0]
        nearer = (_largest(between - color) >= _largest(between - far_color))[:, None]
        far, far_color = np.where(nearer, middle, far), np.where(nearer, between, far_color)
        near, color = np.where(nearer, near, middle), np.where(nearer, color, between)
    result: BoolArray = _largest(far_color - color) > tolerance
    return result


def _errors(vertices: Vertices, corners: IntArray, samples: Float64Array, lighting: Lighting) -> Float64Array:
    result = np.zeros(len(corners))
    step = _SAMPLES // len(samples)
    for start in range(0, len(corners), step):
        part = slice(start, start + step)
        result[part] = _misses(vertices, corners[part], samples, lighting).max(axis=1)
    return result


def _misses(vertices: Vertices, corners: IntArray, weights: Float64Array, lighting: Lighting) -> Float64Array:
    """(m, s): largest channel's difference of blended and lit colours at weights (s, 3) or (m, s, 3)."""
    blended = weights @ lighting.clip(vertices.colors[corners])
    return _largest(blended - _truth(vertices, corners, weights, lighting))


def _truth(vertices: Vertices, corners: IntArray, weights: Float64Array, lighting: Lighting) -> Float64Array:
    points, normals = weights @ vertices.points[corners], weights @ vertices.normals[corners]
    shades = None if vertices.shades is None else (weights @ vertices.shades[corners]).reshape(-1, 3)
    return lighting.clip(lighting.colors(points.reshape(-1, 3), normals.reshape(-1, 3), shades).reshape(points.shape))


def _largest(colors: Float64Array) -> Float64Array:
    return np.abs(colors).max(axis=-1)


def _blend_differently(vertices: Vertices, corners: IntArray) -> BoolArray:
    """Where the two lengths of the normals are in different proportions at the corners."""
    length, other = (np.linalg.norm(normals, axis=1) for normals in (vertices.normals, vertices.units))
    ratio = np.divide(length, other, out=np.ones_like(length), where=other > 0.0)[corners]
    result: BoolArray = np.ptp(ratio, axis=1) > _SAME_RATIO * ratio.max(axis=1)
    return result
