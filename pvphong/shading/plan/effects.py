"""The effects that a scene may call for, in the order in which they are left out.

A new effect is an `Effect` (see `draft.py`) in the file of what it belongs to, and one entry here. One that lights call
for and can do without is made by `lights.light_effect`, and lights name it in `Light.effects`.

What is left out early makes what follows cheaper to judge: first what adds nothing whatever the tolerance, then whole
lights, then what each light that is left can do without. A new one stands with its like.
"""

from __future__ import annotations

from pvphong.shading.plan.draft import Effect
from pvphong.shading.plan.lights import ATTENUATION, CONE, LIGHTS, POSITION, SIZE
from pvphong.shading.plan.reflection import DIFFUSE, SPECULAR
from pvphong.shading.plan.screens import OCCLUSION, SHADOW
from pvphong.shading.plan.sky import SKY
from pvphong.shading.plan.surface import AMBIENT, EMISSION, NORMAL_TRANSFORM
from pvphong.shading.plan.viewer import LOCAL_VIEWER, TWO_SIDED

EFFECTS: tuple[Effect, ...] = (
    NORMAL_TRANSFORM,
    TWO_SIDED,
    EMISSION,
    AMBIENT,
    LIGHTS,
    SIZE,
    SKY,
    CONE,
    SPECULAR,
    ATTENUATION,
    POSITION,
    LOCAL_VIEWER,
    DIFFUSE,
    SHADOW,
    OCCLUSION,
)
