"""Similar reflectances: counterparts, cheaper replacements, and VTK's versions.

A reflectance that is not registered here has no similar one, and VTK does not support it.
"""

from __future__ import annotations

import math
from dataclasses import asdict, replace
from functools import singledispatch
from typing import Any

from pvphong.base.formulas import BRIGHTEST
from pvphong.base.types import rgb
from pvphong.optics.reflectance import Reflectance
from pvphong.optics.reflectances.blinn_phong import BlinnPhong
from pvphong.optics.reflectances.metal import Metal
from pvphong.optics.reflectances.microfacets import COUPLED, Microfacets
from pvphong.optics.reflectances.oren_nayar import OrenNayar
from pvphong.optics.reflectances.pbr import PBR, Shaded
from pvphong.optics.reflectances.phong import Phong

LIKENESS = 4.0
"""Ratio of Blinn-Phong's shininess to Phong's for about the same highlight; see `Material.for_blinn_phong`."""


def counterpart_of(reflectance: Reflectance) -> tuple[str, Reflectance] | None:
    """Return a similar reflectance of another kind, after its description; None if there is none.

    Phong and Blinn-Phong are counterparts of each other. No other reflectance has a counterpart.
    """
    if isinstance(reflectance, Phong):
        return f"Blinn-Phong, shininess × {LIKENESS:g}", BlinnPhong(reflectance.sharpness * LIKENESS)
    if isinstance(reflectance, BlinnPhong):
        return f"Phong, shininess ÷ {LIKENESS:g}", Phong(reflectance.sharpness / LIKENESS)
    return None


@singledispatch
def stand_in(reflectance: Any, material: Any) -> tuple[str, Any] | None:  # noqa: ARG001 nothing is simpler
    """Return a description, and a material with a cheaper reflectance that looks similar; None if there is none.

    `material` is the original material, and `reflectance` its reflectance. Other fields of the material, such as the
    colours, are adapted to the cheaper reflectance.
    """
    return None


@stand_in.register
def _(reflectance: Metal, material: Any) -> tuple[str, Any]:
    """Return the description and the material in which Phong's reflection replaces `Metal`.

    The new highlight has the metal's colour at all angles.
    """
    return "Phong for Metal", replace(material, specular=reflectance.color, reflectance=Phong(reflectance.shininess))


@stand_in.register
def _(reflectance: OrenNayar, material: Any) -> tuple[str, Any]:
    """Return the description and the material in which Lambert's cosine replaces `OrenNayar`.

    Lambert's cosine gets the same total reflectance, A + B (2/3 − 64/(45π)).
    """
    a, b = reflectance.parameters({})
    whole = a + b * (2.0 / 3.0 - 64.0 / (45.0 * math.pi))
    color = tuple(channel * whole for channel in rgb(material.diffuse))
    return "Lambert for Oren-Nayar", replace(material, diffuse=color, specular=0.0, reflectance=Phong())


@stand_in.register
def _(reflectance: Microfacets, material: Any) -> tuple[str, Any]:
    """Return the description and the material in which Phong's reflection replaces microfacets.

    The new highlight has the same height and the same half width, for a light and a viewer above the surface. With α, θ
    and g as in `microfacets`, the height is g = 1/(4α²), and g has half of this height where sin² θ = (√2 − 1)α². There
    Phong's (cos 2θ)ⁿ is ½ if n = ln 4 / (4 (√2 − 1) α²). Lambert's cosine gets the total reflectance of the base in the
    formula `coupled`, 23/28.
    """
    base, tinted, _ = reflectance.lobes
    square = reflectance.alpha**2
    whole = 1.0 if reflectance.is_faded else 1.0 / COUPLED
    diffuse = tuple(a * b * whole for a, b in zip(rgb(material.diffuse), base.color, strict=True))
    specular = tuple(channel / (4.0 * square) for channel in tinted.color)
    fitted = Phong(min(math.log(4.0) / (4.0 * (math.sqrt(2.0) - 1.0) * square), BRIGHTEST))
    return "Phong for microfacets", replace(material, diffuse=diffuse, specular=specular, reflectance=fitted)


@singledispatch
def in_vtk(reflectance: Any) -> Any:  # noqa: ARG001 not in VTK
    """Return the form in which VTK's shader computes a reflectance; None if VTK does not support it."""
    return None


@in_vtk.register
def _(reflectance: PBR) -> PBR:
    """Return VTK's form of `PBR`. `reflectance` must come from `PBR.of`, so that it has the material's colour."""
    return Shaded(**asdict(reflectance))
