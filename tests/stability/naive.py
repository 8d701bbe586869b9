"""The textbook's formulas in one precision throughout: what the catalogue's bounds are there to catch."""

from __future__ import annotations

import math
from typing import Any

import numpy as np


def dot(a: Any, b: Any) -> Any:
    return (a * b).sum(axis=-1)


def unit(a: Any) -> Any:
    return a / np.sqrt(dot(a, a))[..., None]


def lobe(n: Any, to_light: Any, v: Any, shininess: float) -> Any:
    """max(r·v, 0)ⁿ of unit vectors, by the cosine."""
    r = 2 * dot(n, to_light)[..., None] * n - to_light
    return np.maximum(dot(r, v), 0) ** n.dtype.type(shininess)


def highlight(n: Any, to_light: Any, v: Any, shininess: float) -> Any:
    """The same of vectors of any length, rows of one float type."""
    return lobe(unit(n), unit(to_light), unit(v), shininess)


def is_in_cone(points: Any, spot: Any, real: Any) -> Any:
    """Whether a spot reaches the points, by the cosine off its axis, all in the float type `real`."""
    ray = unit(points.astype(real) - np.array(spot.position, real))
    return dot(ray, unit(np.array([spot.direction], real))) >= np.cos(real(np.radians(spot.cone_angle)))


def shade(points: Any, normals: Any, position: Any, eye: Any, material: Any, real: Any) -> Any:
    """Diffuse and specular light of one white point light without attenuation, all in the float type `real`."""
    p, n, position, eye = (np.asarray(value).astype(real) for value in (points, normals, position, eye))
    n, to_light, v = unit(n), unit(position - p), unit(eye - p)
    n_dot_l = np.maximum(dot(n, to_light), 0)
    specular = lobe(n, to_light, v, material.shininess) * (n_dot_l > 0)
    return real(material.diffuse) * n_dot_l + real(material.specular) * specular


def least_excess(errors: Any, bounds: Any) -> float:
    """Observed / bound of the sample that a naive formula does best; an error that is NaN counts as infinite."""
    assert len(errors), "nothing was measured"
    return float(np.min(np.where(np.isnan(errors), np.inf, errors) / bounds))


def in_harmonics(ways: Any, energies: Any, n: Any, bands: int, real: Any) -> Any:
    """What a white patch scatters of light from many ways, L du each, by Legendre's functions as textbooks have them.

    In three bands, with nine coefficients, it is Ramamoorthi and Hanrahan's (2001).
    """
    total = np.zeros(len(n), real)
    for l in range(bands):
        for m in range(l + 1):
            ratio = math.prod(range(l - m + 1, l + m + 1))
            scale = real(math.sqrt((2 * l + 1) / (4 * math.pi) / ratio * (2 if m else 1)))
            for wave in (np.cos, np.sin) if m else (np.cos,):
                at_ways, at_n = (
                    scale * _legendre(l, m, u[:, 2], real) * wave(real(m) * np.arctan2(u[:, 1], u[:, 0])).astype(real)
                    for u in (ways.astype(real), n.astype(real))
                )
                total += real(2 * _cosine_in_band(l)) * (at_ways * energies.astype(real)).sum(dtype=real) * at_n
    return total


def _legendre(l: int, m: int, z: Any, real: Any) -> Any:
    """P of the band l, not normalised, from (2m − 1)!! ρᵐ upward."""
    here, before = np.sqrt(1 - z * z) ** real(m), np.zeros_like(z)
    for k in range(1, m + 1):
        here = here * real(2 * k - 1)
    for k in range(m + 1, l + 1):
        here, before = (real(2 * k - 1) * z * here - real(k + m - 1) * before) / real(k - m), here
    return here


def _cosine_in_band(l: int) -> float:
    """∫ t P_l(t) dt over [0, 1]."""
    if l % 2:
        return 1 / 3 if l == 1 else 0.0
    return (-1) ** (l // 2 + 1) * math.factorial(l) / ((l + 2) * (l - 1) * 2**l * math.factorial(l // 2) ** 2)
