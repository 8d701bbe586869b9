"""What of a material is given vertex by vertex: specular reflectance, shininess, roughness."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.base.types import FloatArray, Vector
from pvphong.optics.material import Material

_COLOR = "specular"
_BOUNDS = {_COLOR: (0.0, 16.0), "shininess": (0.0, np.inf), "roughness": (np.nextafter(0.0, 1.0), 1.0)}
_ALLOWED = {
    _COLOR: "reflectances from 0, of which 1 is all, to 16, shape (n,) or (n, 3)",
    "shininess": "finite numbers >= 0, shape (n,)",
    "roughness": "numbers > 0 and <= 1, shape (n,)",
}


class Maps:
    """Numbers of n vertices that stand in place of a material's or its reflectance's.

    Parameters
    ----------
    given : mapping
        "specular", "shininess" or "roughness" → array with a number for each vertex, of "specular" a number or three;
        or None.
    count : int
        How many vertices there are.

    Raises
    ------
    ValueError
        If an array has another shape or length, or a number in it is not allowed; the message names it.
    """

    def __init__(self, given: Mapping[str, Any], count: int) -> None:
        self._rows = {k: checked_map(k, value, count).T for k, value in given.items() if value is not None}

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Of each that is given, the least and the greatest number; of specular those of its `rows`."""
        found = {}
        for name, rows in self._rows.items():
            numbers = rows if rows.size and name != _COLOR else np.array((0.0, 1.0) if name == _COLOR else 1.0)
            found[name] = float(numbers.min()), float(numbers.max())
        return found

    def brightest(self, material: Material) -> Material:
        """The material with no less than any of the specular reflectances, channel by channel."""
        return replace(material, specular=self._most) if _COLOR in self._rows else material

    def rows(self, name: str) -> FloatArray:
        """Shape (1, n); of specular (3, n), as parts of the brightest."""
        rows = self._rows[name]
        if name != _COLOR:
            return rows
        most = np.array(self._most)[:, None]
        return np.divide(rows, most, out=np.zeros((3, rows.shape[1]), rows.dtype), where=most > 0.0)

    @property
    def _most(self) -> Vector:
        """Powers of two, so that no vertex's bits depend on the others'."""
        largest = np.broadcast_to(self._rows[_COLOR].max(axis=1, initial=0.0).astype(np.float64), 3)
        mantissas, exponents = np.frexp(largest)
        red, green, blue = np.ldexp(np.sign(mantissas), exponents - (mantissas == 0.5)).tolist()
        return red, green, blue


def checked_map(name: str, value: Any, count: int) -> FloatArray:
    """An (n, 1) or (n, 3) array of float32 or float64."""
    allowed = _ALLOWED[name]
    given = check.real_array(name, value, allowed)
    if name == _COLOR and given.dtype == np.uint8:
        given = given / 255.0
    numbers = given[:, None] if given.ndim == 1 else given
    if numbers.ndim != 2 or numbers.shape[1] not in ((1, 3) if name == _COLOR else (1,)):
        check.refuse(name, f"an array of shape {given.shape}", allowed)
    if len(numbers) != count:
        check.refuse(name, f"{len(numbers)} numbers", f"one per point, {count}")
    numbers = numbers if numbers.dtype in (np.float32, np.float64) else numbers.astype(np.float64)
    low, high = _BOUNDS[name]
    is_bad = ~(np.isfinite(numbers) & (numbers >= low) & (numbers <= high)).all(axis=1)
    if is_bad.any():
        first = int(np.argmax(is_bad))
        check.refuse(name, f"{numbers[first].tolist()} at vertex {first}", allowed)
    return numbers
