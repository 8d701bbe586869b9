"""Textbook formulas in one precision throughout. The catalogue's bounds must reject them."""

from __future__ import annotations

from typing import Any

import numpy as np


def dot(a: Any, b: Any) -> Any:
    return (a * b).sum(axis=-1)


def unit(a: Any) -> Any:
    return a / np.sqrt(dot(a, a))[..., None]


def lobe(n: Any, to_light: Any, v: Any, shininess: float) -> Any:
    """Compute max(r·v, 0)ⁿ of unit vectors from the cosine."""
    r = 2 * dot(n, to_light)[..., None] * n - to_light
    return np.maximum(dot(r, v), 0) ** n.dtype.type(shininess)


def highlight(n: Any, to_light: Any, v: Any, shininess: float) -> Any:
    """Compute the same for vectors of any length, as rows of one float type."""
    return lobe(unit(n), unit(to_light), unit(v), shininess)


def shade(points: Any, normals: Any, position: Any, eye: Any, material: Any, real: Any) -> Any:
    """Compute diffuse and specular light of a white point light without attenuation, in the float type `real`."""
    p, n, position, eye = (np.asarray(value).astype(real) for value in (points, normals, position, eye))
    n, to_light, v = unit(n), unit(position - p), unit(eye - p)
    n_dot_l = np.maximum(dot(n, to_light), 0)
    specular = lobe(n, to_light, v, material.shininess) * (n_dot_l > 0)
    return real(material.diffuse) * n_dot_l + real(material.specular) * specular


def least_excess(errors: Any, bounds: Any) -> float:
    """Return the smallest observed error / bound of a naive formula; NaN counts as infinite."""
    assert len(errors), "nothing was measured"
    return float(np.min(np.where(np.isnan(errors), np.inf, errors) / bounds))
