"""The effects that a scene may call for, each in its own room, in the order in which they are left out.

A new effect is its own file beside these and one entry in `EFFECTS`.
"""

from __future__ import annotations

from pvphong.geometry.extent import Extent, Search
from pvphong.shading.plan import attenuation, cone, light, position
from pvphong.shading.plan.draft import Decision, Draft, Effect, Note
from pvphong.shading.plan.reflection import DIFFUSE, SPECULAR
from pvphong.shading.plan.surface import AMBIENT, EMISSION, NORMAL_TRANSFORM
from pvphong.shading.plan.viewer import LOCAL_VIEWER, TWO_SIDED

EFFECTS: tuple[Effect, ...] = (
    NORMAL_TRANSFORM,
    TWO_SIDED,
    EMISSION,
    AMBIENT,
    light.EFFECT,
    cone.EFFECT,
    SPECULAR,
    attenuation.EFFECT,
    position.EFFECT,
    LOCAL_VIEWER,
    DIFFUSE,
)

__all__ = ["EFFECTS", "Decision", "Draft", "Effect", "Extent", "Note", "Search"]
