"""What VTK draws for `pbr=True`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from pvphong.base import check
from pvphong.base.types import FloatArray, Vector, rgb
from pvphong.optics.reflectance import HIGHLIGHT, WHITE, Lobe, VtkSurface
from pvphong.optics.reflectances.microfacets import Facets, Microfacets, alpha_of, check_roughness, faded

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
    `Material.from_property` and `Scene.from_plotter` refuse them by name.
    """

    metallic: float = 0.0
    roughness: float = 0.5

    factors = staticmethod(faded)

    def __post_init__(self) -> None:
        object.__setattr__(self, "metallic", check.number("metallic", self.metallic, at_least=0.0, at_most=1.0))
        object.__setattr__(self, "roughness", check_roughness(self.roughness))

    def of(self, material: Any) -> Microfacets:
        """With the material's diffuse colour."""
        return _Colored(self.metallic, self.roughness, _at_most_white(rgb(material.diffuse)))

    def in_vtk(self) -> Microfacets | None:
        """As the shader has it; for that it must have its colour."""
        return _Shaded(self.metallic, self.roughness)

    def as_vtk(self) -> VtkSurface:
        """Its fields."""
        return VtkSurface(self.metallic, self.roughness)

    def facets_of(self, roughness: Any) -> Facets:
        """D has the square of the roughness, the masking the roughness itself."""
        alpha = alpha_of(roughness)
        return Facets(alpha, np.sqrt(alpha))

    @property
    def facets(self) -> Facets:
        """Those of its own roughness."""
        return self.facets_of(self.roughness)

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """The base, and the highlight in the colour of F₀ and in white."""
        return self._lobes_of(WHITE, 1.0)

    def _lobes_of(self, color: Vector, scale: float) -> tuple[Lobe, ...]:
        m = self.metallic
        f0 = _mapped(lambda a: (1.0 - m) * DIELECTRIC + m * a, color)
        left = _mapped(lambda f: (1.0 - m) * (1.0 - f) * scale, f0)
        is_blend = 0.0 < m < 1.0
        return self._lobes(
            Lobe("diffuse", takes_albedo=True, needs_viewer=True, color=left, tint=_left(m, f0) if is_blend else None),
            HIGHLIGHT._replace(
                is_own=True,
                color=_mapped(lambda f: f * scale, f0),
                takes_albedo=m > 0.0,
                tint=_tinted(m, f0) if is_blend else None,
            ),
            HIGHLIGHT._replace(is_own=True, color=(scale, scale, scale)),
        )


@dataclass(frozen=True)
class _Colored(PBR):
    """With a diffuse colour."""

    color: Vector = WHITE

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """With F₀ from the colour."""
        return self._lobes_of(self.color, 1.0)

    def in_vtk(self) -> Microfacets | None:
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
        return self._lobes_of(self.color, 1.0 / math.pi)


def _at_most_white(color: Vector) -> Vector:
    if max(color) > 1.0:
        check.refuse("diffuse", color, "at most 1 in each channel for PBR", "More is no part of the light.")
    return color


def _mapped(function: Callable[[float], float], color: Vector) -> Vector:
    red, green, blue = color
    return function(red), function(green), function(blue)


def _f0(metallic: float, f0: Vector, albedo: FloatArray) -> Any:
    """F₀ where the colour is multiplied by an albedo."""
    base = (1.0 - metallic) * DIELECTRIC
    return base + (np.array(f0)[:, None] - base) * albedo


def _left(metallic: float, f0: Vector) -> Callable[[FloatArray], FloatArray]:
    def tint(albedo: FloatArray) -> FloatArray:
        left = albedo * (1.0 - _f0(metallic, f0, albedo)) / (1.0 - np.array(f0)[:, None])
        return np.asarray(left, albedo.dtype)

    return tint


def _tinted(metallic: float, f0: Vector) -> Callable[[FloatArray], FloatArray]:
    def tint(albedo: FloatArray) -> FloatArray:
        return np.asarray(_f0(metallic, f0, albedo) / np.array(f0)[:, None], albedo.dtype)

    return tint
