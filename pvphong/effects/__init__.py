"""The effects that a scene may call for, each in its own room, in the order in which they are left out.

A new effect is its own file beside these and one entry in `EFFECTS`.
"""

from __future__ import annotations

from pvphong.effects import attenuation, cone, light, position
from pvphong.effects._draft import Decision, Draft, Effect, Note
from pvphong.effects._extent import Extent, Search
from pvphong.effects.reflection import DIFFUSE, SPECULAR
from pvphong.effects.surface import AMBIENT, EMISSION, NORMAL_TRANSFORM
from pvphong.effects.viewer import LOCAL_VIEWER, TWO_SIDED

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
