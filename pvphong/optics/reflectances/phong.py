"""Phong's reflection: diffuse, and a highlight around the mirror direction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import ClassVar

from pvphong.base import check
from pvphong.optics.area.lobes import CosinePower
from pvphong.optics.reflectances.highlight import LIKENESS, MIRROR, Shiny, own_shininess


@dataclass(frozen=True)
class Phong(Shiny):
    """max(n·l, 0), and max(r·v, 0)ⁿ where n·l > 0, with r = 2(n·l)n − l (Phong 1975). Not reciprocal.

    Parameters
    ----------
    shininess : float, optional
        The exponent n, >= 0; the material's if not given.
    floor : float, default 0
        The cosine r·v is taken to be at least this, as VTK's shader does.

    Raises
    ------
    ValueError
        If a field is out of range.
    """

    shininess: float | None = own_shininess()
    floor: float = check.field(partial(check.number, at_least=0.0, at_most=1.0), 0.0)

    peak: ClassVar = MIRROR
    counterpart: ClassVar[tuple[str, float]] = ("blinn-phong", LIKENESS)

    @property
    def forms(self) -> tuple[CosinePower | None, ...]:
        """Lambert's cosine, and (r·v)ⁿ, which is (l·w)ⁿ for the mirrored v."""
        return super().forms[0], None if self.floor else CosinePower("mirror", self.sharpness)
