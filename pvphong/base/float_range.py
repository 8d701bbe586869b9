"""The ends of the floats' range: caps that keep results within it."""

from __future__ import annotations

BRIGHTEST = 2.0**100
"""Strengths, colours and exponents are capped here, so that nothing overflows float32; anything near it is white.

(The kernel caps a spot's attenuation before its falloff: where the attenuation has no constant, and so near to the
light that this matters, 2⁻⁵⁰ of the distance where it is 1, a spot may be darker outside the middle of its cone.)"""

FAINTEST = 2.0**-126
"""The least normal number of float32."""

FARTHEST = 2.0**1000
"""The most that a light's colours may be before its attenuation, which may bring them down again."""
