"""Which gizmo belongs to which kind of light. A new kind is its own file and one entry here."""

from __future__ import annotations

from types import ModuleType

from pvphong.optics.lights import DirectionalLight, Light, PointLight, SpotLight
from pvphong.studio.gizmos import directional, point, spot

KINDS: dict[type[Light], ModuleType] = {
    DirectionalLight: directional,
    PointLight: point,
    SpotLight: spot,
}
"""Each has `handles`, `drag`, `draw` and `arriving`."""


def kind_of(light: Light) -> ModuleType:
    """The module with the gizmo of a light."""
    return KINDS[type(light)]
