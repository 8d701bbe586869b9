"""What VTK draws for `pbr=True`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from pvphong.base import check
from pvphong.base.types import FloatArray, Vector, rgb
from pvphong.optics.reflectance import HIGHLIGHT, WHITE, Lobe
from pvphong.optics.reflectances.microfacets import Facets, Microfacets, alpha_of, faded

DIELECTRIC = 0.04
"""What all but metals reflect at normal incidence, for an index of refraction of 1.5."""

# Where VTK's shader cuts off cosines, and D's denominator, which has a π in it there.
_FLOOR, _LEAST = 1e-5, math.sqrt(1e-8 / math.pi)


@dataclass(frozen=True)
class PBR(Microfacets):
    """VTK's physically based shading of a material: metal or not, and how rough.

    With a the material's `diffuse` times the albedo, F₀ = 0.04 (1 − metallic) + metallic · a, and S, D and K as
    `pvphong.optics.reflectances.microfacets` has them, for α = roughness² and, as VTK has it, β = roughness: the
    surface reflects (1 − metallic)(1 − F) a n·l + D K F, with F = F₀(1 − S) + S. The material's `specular` is not
    read. In VTK's convention (`LightModel.vtk()`) that is VTK's to the letter: over π, with cosines of at least 1e-5,
    no ambient colour, and the sum of all light raised to 1/2.2. It is reciprocal; the sum of base and highlight is
    more than all light where a white surface is seen at grazing angles, as in VTK.

    Parameters
    ----------
    metallic : float, default 0
        0 for anything but metal, 1 for metal; in between, as in VTK, for a blend.
    roughness : float, default 0.5
        0 < roughness <= 1.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.

    Notes
    -----
    Source: VTK 9.7's vtkOpenGLPolyDataMapper.cxx (ReplaceShaderLight). Its anisotropy, clear coat, edge tint, index of
    refraction other than 1.5, emissive and other textures, and light from environment textures are not here;
    `Material.from_property` and `Scene.from_plotter` refuse them by name. Nor is what VTK takes off the reflection at
    grazing angles (its `f90`) where the mean of F₀ is below 0.02: of surfaces that are nearly black and partly metal.
    """

    metallic: float = 0.0
    roughness: float = 0.5

    factors = staticmethod(faded)

    def __post_init__(self) -> None:
        object.__setattr__(self, "metallic", check.number("metallic", self.metallic, at_least=0.0, at_most=1.0))
        super().__post_init__()

    def of(self, material: Any) -> PBR:
        """With the material's diffuse colour."""
        color = rgb(material.diffuse)
        if max(color) > 1.0:
            check.refuse("diffuse", color, "at most 1 in each channel for PBR", "More is no part of the light.")
        return _Colored(self.metallic, self.roughness, color)

    def in_vtk(self) -> PBR:
        """As the shader has it; for that it must have its colour."""
        return _Shaded(self.metallic, self.roughness)

    def facets_of(self, roughness: Any) -> Facets:
        """D has the square of the roughness, the masking the roughness itself."""
        alpha = alpha_of(roughness)
        return Facets(alpha, np.sqrt(alpha))

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """The base, and the highlight in the colour of F₀ and in white."""
        return self._lobes(WHITE, 1.0)

    def _lobes(self, color: Vector, scale: float) -> tuple[Lobe, ...]:
        """Of a metal in so far as `metallic` says, whose F₀ is no multiple of the albedo in between."""
        m = self.metallic
        dielectric, metal = (1.0 - m) * DIELECTRIC, m * np.array(color)[:, None]
        f0 = dielectric + metal

        def f0_left(albedo: FloatArray) -> FloatArray:
            return np.asarray(albedo * (1.0 - (dielectric + metal * albedo)) / (1.0 - f0), albedo.dtype)

        def f0_tint(albedo: FloatArray) -> FloatArray:
            return np.asarray((dielectric + metal * albedo) / f0, albedo.dtype)

        left, tint = (f0_left, f0_tint) if 0.0 < m < 1.0 else (None, None)
        under, over = ((1.0 - m) * (1.0 - f0) * scale).ravel(), (f0 * scale).ravel()
        highlight = HIGHLIGHT._replace(is_own=True, color=(scale, scale, scale))
        return (
            Lobe("diffuse", takes_albedo=True, needs_viewer=True, color=rgb(tuple(under.tolist())), tint=left),
            highlight._replace(color=rgb(tuple(over.tolist())), takes_albedo=m > 0.0, tint=tint),
            highlight,
        )


@dataclass(frozen=True)
class _Colored(PBR):
    """With a diffuse colour."""

    color: Vector = WHITE

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """With F₀ from the colour."""
        return self._lobes(self.color, 1.0)

    def in_vtk(self) -> PBR:
        """With its colour."""
        return _Shaded(self.metallic, self.roughness, self.color)


@dataclass(frozen=True)
class _Shaded(_Colored):
    """As VTK's shader has it."""

    gamma: ClassVar[float] = 2.2
    is_physical: ClassVar[bool] = True

    def facets_of(self, roughness: Any) -> Facets:
        """With the shader's floors."""
        return super().facets_of(roughness)._replace(floor=_FLOOR, least=_LEAST)

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """Over π."""
        return self._lobes(self.color, 1.0 / math.pi)


# --- VTK's properties


def is_physical(prop: Any) -> bool:
    """Whether VTK draws a property with physically based shading."""
    return bool(prop.GetInterpolationAsString() == "Physically based rendering")


def physical_of(prop: Any) -> PBR:
    """The reflectance of such a property; ValueError naming what it uses of VTK's shading that is not here."""
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
