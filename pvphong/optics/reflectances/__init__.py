"""The reflectances. A new one is its own file beside these and one entry in `REFLECTANCES`."""

from __future__ import annotations

from pvphong.optics.reflectance import Reflectance
from pvphong.optics.reflectances.blinn_phong import BlinnPhong
from pvphong.optics.reflectances.phong import Phong

REFLECTANCES: dict[str, type[Reflectance]] = {
    "phong": Phong,
    "blinn-phong": BlinnPhong,
}
"""Name → class; the light model's `reflection` is one of the first two."""

__all__ = ["REFLECTANCES", "BlinnPhong", "Phong", "Reflectance"]
