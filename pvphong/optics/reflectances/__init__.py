"""The reflectances. A new one is its own file beside these and one entry in `REFLECTANCES`.

(`vtk.py` has none: VTK's convention chooses it, and nobody else can.)
"""

from __future__ import annotations

from typing import Any

from pvphong.optics.reflectance import Reflectance
from pvphong.optics.reflectances.blinn_phong import BlinnPhong
from pvphong.optics.reflectances.oren_nayar import OrenNayar
from pvphong.optics.reflectances.phong import Phong

REFLECTANCES: dict[str, type[Reflectance]] = {
    "phong": Phong,
    "blinn-phong": BlinnPhong,
    "oren-nayar": OrenNayar,
}
"""Name → class, for `LightModel.reflection`, one of the first two, and `counterpart`."""


def counterpart_of(reflectance: Reflectance) -> tuple[str, Reflectance] | None:
    """What is done to get another reflectance that looks much the same, and that one; None where there is none."""
    if reflectance.counterpart is None:
        return None
    name, factor = reflectance.counterpart
    said = f"× {factor:g}" if factor >= 1.0 else f"÷ {1.0 / factor:g}"
    kind: Any = REFLECTANCES[name]
    return f"{name.title()}, shininess {said}", kind(reflectance.sharpness * factor)


__all__ = ["REFLECTANCES", "BlinnPhong", "OrenNayar", "Phong", "Reflectance", "counterpart_of"]
