"""The effects that a scene may call for, each in its own room, in the order in which they are left out.

A new effect is its own file beside these and one entry in `EFFECTS`.
"""

from __future__ import annotations

from pvphong.shading.plan.draft import Effect
from pvphong.shading.plan.lights import ATTENUATION, CONE, LIGHTS, POSITION
from pvphong.shading.plan.reflection import DIFFUSE, SPECULAR
from pvphong.shading.plan.surface import AMBIENT, EMISSION, NORMAL_TRANSFORM
from pvphong.shading.plan.viewer import LOCAL_VIEWER, TWO_SIDED

EFFECTS: tuple[Effect, ...] = (
    NORMAL_TRANSFORM,
    TWO_SIDED,
    EMISSION,
    AMBIENT,
    LIGHTS,
    CONE,
    SPECULAR,
    ATTENUATION,
    POSITION,
    LOCAL_VIEWER,
    DIFFUSE,
)
