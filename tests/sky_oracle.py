"""Light from an environment image, by quadrature of `EnvironmentLight`'s definition, without spherical harmonics.

Projecting the image onto its first bands equals projecting the lobe, because ∫ (P L) f du = ∫ L (P f) du for the
projection P. The projection of a lobe f(w·u) is a polynomial in w·u, Σ (2l + 1)/2 · M P_l with M = ∫ f P_l dt. Each
texel has enough Gauss-Legendre nodes to integrate this polynomial to rounding.
"""

from __future__ import annotations

import math
from typing import Any

import mpmath as mp
import numpy as np

BANDS = 32


def _nodes(texels: int, length: float, count: int) -> tuple[Any, Any]:
    """Return the nodes along one side of an image, and their weights, by texel."""
    x, weights = np.polynomial.legendre.leggauss(count)
    half = 0.5 * length / texels
    return (2.0 * np.arange(texels)[:, None] + 1.0 + x) * half, np.tile(half * weights, (texels, 1))


def texels(light: Any, count: tuple[int, int]) -> tuple[Any, Any, Any]:
    """Return directions (k, 3) to the nodes of all texels, their solid angles (k,) and colours (k, 3)."""
    image = np.asarray(light.image.image, np.float64)
    height, width, _ = image.shape
    top = np.array(light.up) / np.linalg.norm(light.up)
    ahead = np.eye(3)[2 if top[1] == top[2] == 0.0 else 0]
    ahead = ahead - (ahead @ top) * top
    ahead /= np.linalg.norm(ahead)
    turn = math.radians(light.rotation)
    ahead = math.cos(turn) * ahead + math.sin(turn) * np.cross(top, ahead)
    right = np.cross(ahead, top)
    theta, down = (x.reshape(height, 1, -1, 1) for x in _nodes(height, math.pi, count[0]))
    phi, across = (x.reshape(1, width, 1, -1) for x in _nodes(width, 2.0 * math.pi, count[1]))
    cosines = np.sin(theta) * np.cos(phi - math.pi), np.sin(theta) * np.sin(phi - math.pi), np.cos(theta)
    directions = np.stack(np.broadcast_arrays(*cosines), axis=-1) @ np.array([ahead, right, top])
    solid = np.sin(theta) * down * across
    colors = np.broadcast_to(image[:, :, None, None], directions.shape)
    return directions.reshape(-1, 3), solid.ravel(), colors.reshape(-1, 3)


def in_bands(light: Any, w: Any, power: float) -> Any:
    """1/π · ∫ L max(w·u, 0)ᵏ du of each channel, in its first bands. Not cut off below 0."""
    height, width, _ = light.image.image.shape
    directions, solid, colors = texels(light, (24 + 64 // height, 24 + 160 // width))
    # ∫ tᵏ P_l dt from 0 to 1
    whole = mp.sqrt(mp.pi) * mp.mpf(2) ** (-power - 1) * mp.gamma(power + 1)
    moments = [whole * mp.rgamma(1 + (power - l) / 2.0) * mp.rgamma((power + l + 3) / 2.0) for l in range(BANDS)]
    lobe = np.polynomial.legendre.Legendre([(l + 0.5) * float(moment) for l, moment in enumerate(moments)])
    arriving = lobe(directions @ (np.array(w) / np.linalg.norm(w))) * solid / math.pi
    return [math.fsum(arriving * channel) for channel in colors.T]
