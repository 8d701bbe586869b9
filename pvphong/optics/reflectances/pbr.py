"""What VTK draws for `pbr=True`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar

import numpy as np

from pvphong.base import check
from pvphong.base.formulas import ONE, formula
from pvphong.base.types import FloatArray, Vector, rgb
from pvphong.optics.maps import number_or_map
from pvphong.optics.reflectance import HIGHLIGHT, WHITE, Lobe
from pvphong.optics.reflectances.microfacets import ROUGHNESS, Microfacets, alpha_of, faded

DIELECTRIC = 0.04
"""What all but metals reflect at normal incidence, for an index of refraction of 1.5."""

# Where VTK's shader cuts off cosines, and D's denominator, which has a π in it there.
_FLOOR, _LEAST = 1e-5, math.sqrt(1e-8 / math.pi)


@formula
def _half_masked(roughness: Any, own: Any) -> Any:
    """The parameters of facets whose D has the square of the roughness, and whose masking the roughness itself."""
    alpha = alpha_of(roughness)
    return alpha, alpha * alpha, ONE - alpha * alpha, alpha, ONE - alpha, own[5], own[6], own[7]


@dataclass(frozen=True)
class PBR(Microfacets):
    """VTK's physically based shading of a material: metal or not, and how rough.

    With a the material's `diffuse` times the albedo, F₀ = 0.04 (1 − metallic) + metallic · a, and S, D and K as
    `pvphong.optics.reflectances.microfacets` has them, for α = roughness² and, as VTK has it, β = roughness: the
    surface reflects (1 − metallic)(1 − F) a n·l + D K F, with F = F₀(1 − S) + F₉₀S. F₉₀ is 1, and less where surfaces
    are partly metal and nearly black, see `fresnel_ends`. The material's `specular` is not read. In VTK's convention
    (`LightModel.vtk()`) that is VTK's to the letter: over π, with cosines of at least 1e-5, no ambient colour, and the
    sum of all light raised to 1/2.2. It is reciprocal; the sum of base and highlight is more than all light where a
    white surface is seen at grazing angles, as in VTK.

    Parameters
    ----------
    metallic : float or map, default 0
        0 for anything but metal, 1 for metal; in between, as in VTK, for a blend.
    roughness : float or map, default 0.5
        0 < roughness <= 1.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.

    Notes
    -----
    Source: VTK 9.7's vtkOpenGLPolyDataMapper.cxx (ReplaceShaderLight). Its anisotropy, clear coat, edge tint, index of
    refraction other than 1.5, emissive and other textures, and light from environment textures are not here;
    `Material.from_property` and `Scene.from_plotter` refuse them by name. Where F₉₀ is below 1, its share in the base
    is taken from the brightest channel, which is within 3e-7 of what VTK draws of a light of 1, and for an albedo of 1,
    which is within 1e-4.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> material = ph.Material(reflectance=ph.PBR(metallic=1.0, roughness=0.3))
    >>> lit = pv.Sphere().phong.shade(ph.DirectionalLight(), material)
    """

    metallic: float = check.field(partial(number_or_map, at_least=0.0, at_most=1.0), 0.0)
    roughness: float = check.field(ROUGHNESS, 0.5)

    maps: ClassVar[frozenset[str]] = frozenset({"roughness", "metallic"})
    factors = staticmethod(faded)
    mapped = staticmethod(_half_masked)

    def of(self, material: Any) -> PBR:
        """A copy with the material's diffuse colour."""
        color = rgb(material.diffuse)
        if max(color) > 1.0:
            check.refuse("diffuse", color, "at most 1 in each channel for PBR", "More is no part of the light.")
        return _Colored(self.metallic, self.roughness, color)

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """The base, and the highlight in the colour of F₀ and in white."""
        return _Colored(self.metallic, self.roughness).lobes


def fresnel_ends(metallic: Any, color: Any) -> tuple[Any, Any]:
    """F₀ in each channel of a colour, shape (3, ...), and F₉₀, which all channels share, shape (...).

    As VTK and Filament (5.6.2, specular occlusion) have it, who take an F₀ below 0.02 for a crevice: the part of F₉₀
    that is not a metal's is 50 times the mean of F₀, and 1 at most; VTK takes 0.33 for a third.
    """
    f0 = (1.0 - metallic) * DIELECTRIC + metallic * color
    return f0, (1.0 - metallic) * np.minimum(50.0 * 0.33 * (f0[0] + f0[1] + f0[2]), 1.0) + metallic


@dataclass(frozen=True)
class _Colored(PBR):
    """PBR with a diffuse colour."""

    color: Vector = WHITE
    varies: bool = False
    """Whether `metallic` is a map."""

    scale: ClassVar[float] = 1.0

    def fade(self, maps: Mapping[str, Any]) -> Any:
        """The t = 1 − (1 − F₉₀)/(1 − F₀), for (1 − F₀)(1 − tS) to be 1 − F, in the brightest channel."""
        f0, f90 = fresnel_ends(maps.get("metallic", self.metallic), np.array(self.color)[:, None])
        top = f0.max(axis=0)
        fade = np.where(f90 < 1.0, (f90 - top) / np.maximum(1.0 - top, 1e-9), 1.0)
        return fade if "metallic" in maps else float(fade[0])

    def over(self, maps: Mapping[str, tuple[float, float]]) -> PBR:
        """One whose colours hold for a map of metallic too."""
        return replace(self, varies="metallic" in maps)

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """The lobes of a metal to the share `metallic`; its F₀ is no multiple of the albedo in between.

        Where `metallic` is a map, their colours are the greatest from 0 to 1, whatever the map's numbers are: that of
        the base falls with it, and F₀ is linear in it.
        """
        color, is_blend = np.array(self.color)[:, None], self.varies or 0.0 < self.metallic < 1.0
        low, high = (0.0, 1.0) if self.varies else (self.metallic, self.metallic)
        least_f0, least_f90 = fresnel_ends(low, color)
        under = (1.0 - low) * (1.0 - least_f0)
        f0 = np.maximum(least_f0, fresnel_ends(high, color)[0])
        f90 = np.ones(1) if self.varies else least_f90

        def ends(albedo: FloatArray, maps: Mapping[str, FloatArray]) -> tuple[Any, Any, Any]:
            """The metallic, F₀ and F₉₀, in the type of the albedo."""
            m = maps.get("metallic", albedo.dtype.type(low))
            return m, *fresnel_ends(m, color.astype(albedo.dtype) * albedo)

        def left(albedo: FloatArray, maps: Mapping[str, FloatArray]) -> FloatArray:
            (m, own, _), whole = ends(albedo, maps), np.where(under > 0.0, under, 1.0).astype(albedo.dtype)
            return np.asarray(albedo * ((1.0 - m) * (1.0 - own)) / whole)

        def tinted(albedo: FloatArray, maps: Mapping[str, FloatArray]) -> FloatArray:
            return np.asarray(ends(albedo, maps)[1] / np.where(f0 > 0.0, f0, 1.0).astype(albedo.dtype))

        def white(albedo: FloatArray, maps: Mapping[str, FloatArray]) -> FloatArray:
            grazing = ends(albedo, maps)[2] / f90.astype(albedo.dtype)
            return np.broadcast_to(grazing, (3, max(grazing.size, albedo.shape[1])))

        def highlight(color: Any, tint: Any, *, takes_albedo: bool) -> Lobe:
            shown = rgb(tuple(np.broadcast_to(color * self.scale, (3, 1)).ravel().tolist()))
            return HIGHLIGHT._replace(is_own=True, color=shown, takes_albedo=takes_albedo, tint=tint)

        base = rgb(tuple((under * self.scale).ravel().tolist()))
        return (
            Lobe("diffuse", takes_albedo=True, needs_viewer=True, color=base, tint=left if is_blend else None),
            highlight(f0, tinted if is_blend else None, takes_albedo=is_blend or high > 0.0),
            highlight(f90, white if is_blend else None, takes_albedo=is_blend),
        )


@dataclass(frozen=True)
class Shaded(_Colored):
    """As VTK's shader has it."""

    gamma: ClassVar[float] = 2.2
    is_physical: ClassVar[bool] = True
    scale: ClassVar[float] = 1.0 / math.pi
    """Over π."""

    cutoffs: ClassVar[tuple[float, float]] = _FLOOR, _LEAST


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
