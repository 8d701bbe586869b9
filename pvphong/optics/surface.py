"""Input of a reflectance for a block of vertices."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from pvphong.base.types import Float64Array, FloatArray
from pvphong.base.vectors import cross, dot, unit
from pvphong.optics.light import Arrival

# Sums of three products that are at least this large have lost no bit to underflow.
_LEAST_PRODUCT = {np.float32: 2.0**-100, np.float64: 2.0**-970}


@dataclass(eq=False)
class Surface:
    """Block of n vertices to be lit, in the precision of the result. Vectors are columns, (3, n) or (3, 1).

    Attributes
    ----------
    raw : ndarray
        Normals before normalisation. The sign of n·l is computed from these normals and from unnormalized vectors to
        the light. So the rounding of unit vectors does not affect the sign.
    inverse_length : ndarray
        1/|n| of `raw`, shape (n,); 0 where there is no normal.
    to_viewer : ndarray
        Unit vectors v.
    raw_tangents : ndarray or None
        Unit vectors along the surface, only roughly orthogonal to the normals; zero where a vertex has no tangent. None
        if the reflectance does not need tangents.
    maps : mapping
        Name of a field → numbers per vertex, shape (n,), that replace the field of the reflectance.
    """

    raw: FloatArray
    inverse_length: FloatArray
    to_viewer: FloatArray
    raw_tangents: FloatArray | None = None
    maps: Mapping[str, FloatArray] = field(default_factory=dict)

    @cached_property
    def tangents(self) -> FloatArray:
        """Unit tangents t orthogonal to n: (n × t) × n, normalized; zero if a raw tangent is zero or parallel to n."""
        assert self.raw_tangents is not None, "the reflectance's `needs` does not contain tangents"
        n = self.raw * self.inverse_length
        return unit(cross(unit(cross(n, self.raw_tangents))[0], n))[0]

    @cached_property
    def facing(self) -> FloatArray:
        """Cosines n·v of the angle between normal and direction to the viewer, shape (n,)."""
        return dot(self.raw, self.to_viewer) * self.inverse_length

    @cached_property
    def exact_normals(self) -> Float64Array:
        """Unit normals in float64, shape (3, n), for integrals over a light; zero for a vertex without a normal."""
        return unit(self.raw.astype(np.float64, copy=False))[0]

    @cached_property
    def mirrored(self) -> Float64Array:
        """Directions to the viewer mirrored at the normals, 2(n·v)n − v, as float64 unit vectors, shape (3, n)."""
        n, v = self.exact_normals, unit(self.to_viewer.astype(np.float64, copy=False))[0]
        return unit(2.0 * dot(n, v) * n - v)[0]

    def cosine(self, arrival: Arrival) -> Any:
        """Return the cosines n·l of the angle between normal and direction to a light, shape (n,).

        `arrival` is the light that arrives at the vertices. With D the unnormalized vector to the light, the sign of
        the cosine is that of n·D, which is exact if its products are exact.
        """
        to_light, inverse = arrival.to_light, arrival.inverse_length
        n_d = dot(self.raw, to_light)
        n_l = n_d * inverse
        if isinstance(inverse, np.ndarray):
            sizes, least = np.abs(n_d), _LEAST_PRODUCT[n_d.dtype.type]
            if sizes.min(initial=least) < least:  # tiny products round; scale D to a length near 1
                small = sizes < least
                exponents = np.frexp(inverse[small])[1]
                n_d = dot(self.raw[:, small], np.ldexp(to_light[:, small], exponents))
                n_l[small] = n_d * np.ldexp(inverse[small], -exponents)
        return n_l * self.inverse_length
