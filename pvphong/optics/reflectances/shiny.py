"""What Phong's reflection, Blinn's form of it and VTK's have in common: Lambert's cosine, and a highlight."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from pvphong.base import check
from pvphong.base.float_range import BRIGHTEST, FAINTEST
from pvphong.optics.reflectance import Lobe, Reflectance
from pvphong.optics.spherical import CosinePower

LIKENESS = 4.0
"""Blinn-Phong needs about this many times the shininess for the same highlight; see `Material.for_blinn_phong`."""

LAMBERT = Lobe("diffuse", takes_albedo=True, needs_viewer=False)
HIGHLIGHT = Lobe("specular", takes_albedo=False, needs_viewer=True)


@dataclass(frozen=True)
class Shiny(Reflectance):
    """A reflectance with a highlight that is a power of a cosine.

    Parameters
    ----------
    shininess : float, optional
        The exponent n, >= 0; the material's if not given.

    Raises
    ------
    ValueError
        If the shininess is not such a number.
    """

    shininess: float | None = None

    maps: ClassVar[frozenset[str]] = frozenset({"specular", "shininess"})

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """Lambert's, and the highlight."""
        return LAMBERT, HIGHLIGHT

    def __post_init__(self) -> None:
        if self.shininess is not None:
            object.__setattr__(self, "shininess", check.number("shininess", self.shininess, at_least=0.0))

    def of(self, material: Any) -> Self:
        """With the material's shininess, where it has none of its own."""
        return replace(self, shininess=material.shininess) if self.shininess is None else self

    def extremes(self, field: str, low: float, high: float) -> tuple[Self, ...]:
        """With the greatest of those below 1, which are infinitely steep, where none of the ends is it."""
        ends = super().extremes(field, low, high)
        return (*ends, replace(self, shininess=math.nextafter(1.0, 0.0))) if low < 1.0 <= high else ends

    @property
    def forms(self) -> tuple[CosinePower | None, ...]:
        """Lambert's cosine; the highlight's is the kind's own to say."""
        return CosinePower("normal", 1.0), None

    @property
    def sharpness(self) -> float:
        """The shininess."""
        return self.shininess or 0.0


def lambert(n_l: Any) -> Any:
    """max(n·l, 0)."""
    return np.maximum(n_l, n_l.dtype.type(0.0))


def shown(highlight: Any, n_l: Any) -> Any:
    """A highlight where n·l is positive, else 0."""
    return highlight * (n_l > 0.0)


def power_numbers(shininess: float, floor: float) -> tuple[float, float, float]:
    """For compiled code: the exponent in float32's range, log2 of the floor, and the squared chord from which on
    a highlight is 0. (The floor is on the logarithm because 1 − floor is rounded by far more than its last bit.)
    """
    exponent = shininess and max(FAINTEST, min(shininess, BRIGHTEST))
    return exponent, math.log2(floor) if floor else -math.inf, math.inf if floor or not shininess else 2.0
