"""Likeness: which other reflectance looks much the same as one, what is cheaper in its place, and what VTK has.

Each question has an answer by kind; a kind that is not here is like no other, and VTK has it not.
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
"""Blinn-Phong needs about this many times the shininess for the same highlight; see `Material.for_blinn_phong`."""


def counterpart_of(reflectance: Reflectance) -> tuple[str, Reflectance] | None:
    """Describe and make the reflectance that looks most like this one; None if no other does."""
    if isinstance(reflectance, Phong):
        return f"Blinn-Phong, shininess × {LIKENESS:g}", BlinnPhong(reflectance.sharpness * LIKENESS)
    if isinstance(reflectance, BlinnPhong):
        return f"Phong, shininess ÷ {LIKENESS:g}", Phong(reflectance.sharpness / LIKENESS)
    return None


@singledispatch
def stand_in(reflectance: Any, material: Any) -> tuple[str, Any] | None:  # noqa: ARG001 nothing is simpler
    """Name a cheaper reflectance and give the material with it that looks most like this one; None if there is none."""
    return None


@stand_in.register
def _(reflectance: Metal, material: Any) -> tuple[str, Any]:
    """Phong's highlight in the metal's colour, also where light grazes it."""
    return "Phong for Metal", replace(material, specular=reflectance.color, reflectance=Phong(reflectance.shininess))


@stand_in.register
def _(reflectance: OrenNayar, material: Any) -> tuple[str, Any]:
    """Lambert's cosine, that reflects as much in all: A + B (2/3 − 64/(45π))."""
    a, b = reflectance.parameters({})
    whole = a + b * (2.0 / 3.0 - 64.0 / (45.0 * math.pi))
    color = tuple(channel * whole for channel in rgb(material.diffuse))
    return "Lambert for Oren-Nayar", replace(material, diffuse=color, specular=0.0, reflectance=Phong())


@stand_in.register
def _(reflectance: Microfacets, material: Any) -> tuple[str, Any]:
    """Phong's highlight, as high and half as high at the same angles where light and viewer are above the surface.

    Lambert's cosine under it reflects as much in all as the coupled base, which is 23/28.
    There g is 1/(4α²) at its peak and half of that where sin² θ = (√2 − 1)α², which is cos (2θ)ⁿ = ½ for
    n = ln 4 / (4 (√2 − 1) α²).
    """
    base, tinted, _ = reflectance.lobes
    square = reflectance.alpha**2
    whole = 1.0 if reflectance.is_faded else 1.0 / COUPLED
    diffuse = tuple(a * b * whole for a, b in zip(rgb(material.diffuse), base.color, strict=True))
    specular = tuple(channel / (4.0 * square) for channel in tinted.color)
    fitted = Phong(min(math.log(4.0) / (4.0 * (math.sqrt(2.0) - 1.0) * square), BRIGHTEST))
    return "Phong for microfacets", replace(material, diffuse=diffuse, specular=specular, reflectance=fitted)


@singledispatch
def in_vtk(reflectance: Any) -> Any:  # noqa: ARG001 VTK has no such
    """The reflectance as VTK's shader computes it; None if VTK does not have it."""
    return None


@in_vtk.register
def _(reflectance: PBR) -> PBR:
    """As the shader has it; for that it must have its colour."""
    return Shaded(**asdict(reflectance))
