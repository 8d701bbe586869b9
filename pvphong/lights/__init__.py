"""The kinds of light. A new kind is its own file beside these and one entry in `LIGHT_TYPES`."""

from __future__ import annotations

from pvphong.lights._light import Arrival, Light
from pvphong.lights.conversion import as_light, from_vtk, light_from_homogeneous
from pvphong.lights.directional import DirectionalLight
from pvphong.lights.point import PointLight
from pvphong.lights.spot import SpotLight

LIGHT_TYPES: dict[str, type[Light]] = {
    "directional": DirectionalLight,
    "point": PointLight,
    "spot": SpotLight,
}
"""Name in a scene file → class."""

__all__ = [
    "LIGHT_TYPES",
    "Arrival",
    "DirectionalLight",
    "Light",
    "PointLight",
    "SpotLight",
    "as_light",
    "from_vtk",
    "light_from_homogeneous",
]
