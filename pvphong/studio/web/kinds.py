"""Kinds of lights and reflectances by their names in scene files, and the fields that can have a texture."""

from __future__ import annotations

from dataclasses import MISSING
from dataclasses import fields as dataclass_fields
from typing import Any

from pvphong.base import check
from pvphong.optics.light import Light
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.maps import FIELDS
from pvphong.optics.material import Material
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.studio.web.fields import fields_of


def textured(material: Material) -> list[str]:
    """Return the fields of a material and its reflectance that can have a texture."""
    reflectance = material.reflectance
    fields = *fields_of(type(material)), *(() if reflectance is None else fields_of(type(reflectance)))
    return [field.name for field in fields if field.takes == "map" and field.name in FIELDS]


def kind_of(light: Light) -> str:
    """Return the name that scene files use for a light's kind."""
    return next((name for name, kind in LIGHT_TYPES.items() if type(light) is kind), type(light).__name__)


def new_reflectance(name: str) -> Any:
    """Return a new reflectance of the kind that scene files call `name`.

    Parameters without a default are set to the middle of their range, or to grey.
    """
    kind = REFLECTANCES[check.choice("reflectance", name, REFLECTANCES)]
    missing = {each.name for each in dataclass_fields(kind) if each.default is MISSING}
    given: dict[str, Any] = {
        field.name: 0.5 if field.kind == "color" else 0.5 * (field.least + field.most)
        for field in fields_of(kind)
        if field.name in missing
    }
    return kind(**given)
