"""Blinn's form of Phong's reflection: a highlight around the half-way direction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from pvphong.optics.reflectances.highlight import HALFWAY, LIKENESS, Shiny, own_shininess


@dataclass(frozen=True)
class BlinnPhong(Shiny):
    """max(n·l, 0), and max(n·h, 0)ⁿ where n·l > 0, with h = (l + v)/|l + v| (Blinn 1977; OpenGL 2.1, 2.14.1).

    Parameters
    ----------
    shininess : float, optional
        The exponent n, >= 0; the material's if not given.

    Raises
    ------
    ValueError
        If the shininess is not such a number.
    """

    shininess: float | None = own_shininess()

    peak: ClassVar = HALFWAY
    counterpart: ClassVar[tuple[str, float]] = ("phong", 1.0 / LIKENESS)
