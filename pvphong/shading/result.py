"""The result of an evaluation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pvphong.base.types import FloatArray


@dataclass(frozen=True, eq=False, repr=False)
class Shading:
    """Lit colours of n vertices; linear RGB, 1.0 = full, in the precision that was asked for.

    Of Dask arrays, the arrays are Dask's too; `dask.compute(shading)` gives one of NumPy arrays, in a tuple.

    Attributes
    ----------
    rgb : ndarray
        Shape (n, 3). In [0, 1], unless the light model says not to clamp.
    ambient, diffuse, specular, emission : ndarray or None
        Shape (n, 3), unclamped; they add up to the unclamped colour. `ambient` holds the light model's and
        the lights'. None unless components were asked for, as all that follow.
    per_light : ndarray or None
        Shape (n_lights, n, 3), unclamped: each light's ambient, diffuse and specular share, in the order of
        the scene's lights; a light that is off has a share of zero.
    base : ndarray or None
        Shape (n, 3), unclamped: what is there without any light: emission and the light model's ambient.
        ``base + per_light.sum(axis=0)`` is the unclamped colour.
    """

    rgb: NDArray[Any]
    ambient: FloatArray | None = None
    diffuse: FloatArray | None = None
    specular: FloatArray | None = None
    emission: FloatArray | None = None
    per_light: FloatArray | None = None
    base: FloatArray | None = None

    def __repr__(self) -> str:
        parts = "" if self.per_light is None else f", components of {len(self.per_light)} lights"
        return f"<Shading of {self.rgb.shape[0]} vertices, {self.rgb.dtype}{parts}>"

    @classmethod
    def empty(cls, count: int, lights: int, real: np.dtype[Any], *, components: bool) -> Shading:
        """Arrays for so many vertices and lights: colours to be written, components to be added to."""
        rgb = np.empty((count, 3), real)
        if not components:
            return cls(rgb)
        ambient, diffuse, specular, emission, base = (np.zeros((count, 3), real) for _ in range(5))
        per_light = np.zeros((lights, count, 3), real)
        return cls(rgb, ambient, diffuse, specular, emission, per_light, base)
