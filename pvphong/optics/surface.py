"""What a reflectance sees of a block of vertices."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from pvphong.base.types import Float64Array, FloatArray
from pvphong.base.vectors import cross, dot, unit
from pvphong.optics.light import Arrival

# Sums of three products have lost no bit to underflow from here on.
_LEAST_PRODUCT = {np.float32: 2.0**-100, np.float64: 2.0**-970}


@dataclass(eq=False)
class Surface:
    """A block of n vertices, ready to be lit, in the precision of the result. Vectors are columns, (3, n) or (3, 1).

    Attributes
    ----------
    raw : ndarray
        Normals before they were made unit length. The sign of n·l is decided on these and on vectors to the light, so
        that the rounding of unit vectors has no part in it.
    inverse_length : ndarray
        1/|n| of those, shape (n,); 0 where there is no normal.
    to_viewer : ndarray
        Unit vectors v.
    raw_tangents : ndarray or None
        Unit vectors along the surface, not quite across its normals; zero where there is none. Only where the
        reflectance needs them.
    maps : mapping
        Field of the reflectance → numbers, shape (n,), that replace it.
    """

    raw: FloatArray
    inverse_length: FloatArray
    to_viewer: FloatArray
    raw_tangents: FloatArray | None = None
    maps: Mapping[str, FloatArray] = field(default_factory=dict)

    @cached_property
    def tangents(self) -> FloatArray:
        """Unit tangents t across n, (n × t) × n; zero where there is none, or where it is along n."""
        assert self.raw_tangents is not None, "the reflectance's `needs` does not say tangents"
        n = self.raw * self.inverse_length
        return unit(cross(unit(cross(n, self.raw_tangents))[0], n))[0]

    @cached_property
    def facing(self) -> FloatArray:
        """The cosines n·v, shape (n,)."""
        return dot(self.raw, self.to_viewer) * self.inverse_length

    @cached_property
    def exact_normals(self) -> Float64Array:
        """Unit normals in float64, as integrals over a light need them; zero where there is none."""
        return unit(self.raw.astype(np.float64, copy=False))[0]

    @cached_property
    def mirrored(self) -> Float64Array:
        """The directions to the viewer mirrored at the normals, 2(n·v)n − v, in float64."""
        n, v = self.exact_normals, unit(self.to_viewer.astype(np.float64, copy=False))[0]
        return unit(2.0 * dot(n, v) * n - v)[0]

    def cosine(self, arrival: Arrival) -> Any:
        """The cosine n·l, shape (n,). Its sign is n·D's for the vector D to the light, exact where the products are."""
        to_light, inverse = arrival.to_light, arrival.inverse_length
        n_d = dot(self.raw, to_light)
        n_l = n_d * inverse
        if isinstance(inverse, np.ndarray):
            sizes, least = np.abs(n_d), _LEAST_PRODUCT[n_d.dtype.type]
            if sizes.min(initial=least) < least:  # the least floats round products of D, but less those of D near 1
                small = sizes < least
                exponents = np.frexp(inverse[small])[1]
                n_d = dot(self.raw[:, small], np.ldexp(to_light[:, small], exponents))
                n_l[small] = n_d * np.ldexp(inverse[small], -exponents)
        return n_l * self.inverse_length
