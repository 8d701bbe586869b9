"""VTK's properties with physically based shading, and what of it `PBR` has not."""

from __future__ import annotations

from typing import Any

from pvphong.base import check
from pvphong.optics.reflectances.pbr import PBR

_NAME = "Physically based rendering"


def is_physical(prop: Any) -> bool:
    """Whether VTK draws a property with physically based shading."""
    return bool(prop.GetInterpolationAsString() == _NAME)


def physical_of(prop: Any) -> PBR:
    """The reflectance of such a property; ValueError naming what of VTK's shading it asks for that is not here."""
    asked = {
        "anisotropy": (prop.GetAnisotropy(), 0.0),
        "coat_strength": (prop.GetCoatStrength(), 0.0),
        "edge_tint": (tuple(prop.GetEdgeTint()), (1.0, 1.0, 1.0)),
        "base_ior": (prop.GetBaseIOR(), 1.5),
        "textures": (prop.GetNumberOfTextures(), 0),
    }
    for name, (given, only) in asked.items():
        if given != only:
            check.refuse(f"prop.{name}", given, f"{only} with pbr=True", "Of VTK's shading that part is not here.")
    if prop.GetRoughness() <= 0.0:
        remedy = "VTK draws no highlight with a roughness of 0; 0.05 is next to a mirror."
        check.refuse("prop.roughness", prop.GetRoughness(), "above 0", remedy)
    return PBR(prop.GetMetallic(), prop.GetRoughness())
