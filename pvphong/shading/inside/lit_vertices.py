"""Vertices with everything that is interpolated between them, and what lights them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from pvphong.base.types import Float64Array, FloatArray, MatrixLike
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
from pvphong.shading.assembly import assemble
from pvphong.shading.equation import Equation
from pvphong.shading.evaluation import evaluate


@dataclass(frozen=True)
class Lighting:
    """What a surface is lit by."""

    scene: Scene
    material: Material
    matrix: MatrixLike | None

    def colors(self, points: FloatArray, normals: FloatArray, shades: Float64Array | None) -> Float64Array:
        """(n, 3) lit colours before they are clamped."""
        unclamped = replace(self.scene, light_model=replace(self.scene.light_model, clamp=False))
        shading = evaluate(
            points,
            normals,
            unclamped,
            self.material,
            matrix=self.matrix,
            albedo=shades,
            precision="float64",
            backend="numpy",
        )
        return shading.rgb.astype(np.float64, copy=False)

    def shown(self, colors: Float64Array) -> Float64Array:
        """Colours as the light model shows them, clamped or not."""
        return np.clip(colors, 0.0, 1.0) if self.scene.light_model.clamp else colors

    @cached_property
    def equation(self) -> Equation:
        """The whole lighting equation."""
        return assemble(self.scene, self.material, self.matrix)


@dataclass(frozen=True)
class LitVertices:
    """Points, and what is interpolated between them: float64 arrays of shape (n, 3).

    Attributes
    ----------
    points : ndarray
        Where they are.
    normals : ndarray
        Of the lengths with which they are blended.
    stored : ndarray
        The same directions, of the lengths with which whoever gets the mesh will blend them.
    shades : ndarray or None
        Albedo in [0, 1].
    colors : ndarray
        The lit colours before they are clamped.
    """

    points: Float64Array
    normals: Float64Array
    stored: Float64Array
    shades: Float64Array | None
    colors: Float64Array

    def followed_by(self, others: LitVertices) -> LitVertices:
        """These vertices and then others."""
        both = {name: (getattr(self, name), getattr(others, name)) for name in LitVertices.__dataclass_fields__}
        joined: dict[str, Any] = {name: None if b is None else np.concatenate([a, b]) for name, (a, b) in both.items()}
        return LitVertices(**joined)


def sizes(points: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Longest side and least height (m,) of triangles (m, 3, 3).

    The height is zero or NaN where a triangle has no area, or a point that is not finite.
    """
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        sides = np.roll(points, -1, axis=1) - points
        scale = np.abs(sides).max(axis=(1, 2), initial=0.0)
        sides /= scale[:, None, None]
        longest = np.linalg.norm(sides, axis=2).max(axis=1, initial=0.0)
        double_area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
        return longest * scale, double_area / longest * scale


def scaled_together(normals: FloatArray) -> tuple[Float64Array, int]:
    """Normals scaled by one power of two so that the longest is near 1, and its exponent.

    Blended, they have the same directions, and nothing overflows. A normal that is not finite becomes zero.
    """
    result = normals.astype(np.float64)
    result[~np.isfinite(result).all(axis=1)] = 0.0
    exponent = int(np.frexp(np.abs(result).max(initial=0.0))[1])
    return np.ldexp(result, -exponent), exponent
