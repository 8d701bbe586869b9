"""VTK's physically based shading, as with PyVista's `pbr=True`."""

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
"""Reflectance of nonmetals at normal incidence, for an index of refraction of 1.5."""

# Least cosines, and the least denominator of D, in VTK's shader, where the denominator includes π.
_FLOOR, _LEAST = 1e-5, math.sqrt(1e-8 / math.pi)


@formula
def _half_masked(roughness: Any, own: Any) -> Any:
    """Return the parameters of `Microfacets` for a roughness, with β = roughness in the masking, as in VTK.

    `own` has parameters for another roughness; those that do not depend on the roughness are copied.
    """
    alpha = alpha_of(roughness)
    return alpha, alpha * alpha, ONE - alpha * alpha, alpha, ONE - alpha, own[5], own[6], own[7]


@dataclass(frozen=True)
class PBR(Microfacets):
    """VTK's physically based shading, with the parameters metallic and roughness.

    Let a be the material's `diffuse` times the albedo, F₀ = 0.04 (1 − metallic) + metallic · a, and S, D and K as in
    `pvphong.optics.reflectances.microfacets`, for α = roughness² and, as in VTK, β = roughness. The surface reflects
    (1 − metallic)(1 − F) a n·l + D K F, with F = F₀(1 − S) + F₉₀S. F₉₀ is 1, or less for surfaces that are partly metal
    and nearly black; see `fresnel_ends`. The material's `specular` is not read. In VTK's convention
    (`LightModel.vtk()`), the result matches VTK: divided by π, with cosines of at least 1e-5, without an ambient
    colour, and with the sum of all light raised to the power 1/2.2. The reflectance is reciprocal. As in VTK, a white
    surface at grazing angles reflects more light than arrives.

    Parameters
    ----------
    metallic : float or map, default 0
        0 for a nonmetal, 1 for a metal. Numbers in between blend the two, as in VTK.
    roughness : float or map, default 0.5
        0 < roughness <= 1.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.

    Notes
    -----
    Source: VTK 9.7's vtkOpenGLPolyDataMapper.cxx (ReplaceShaderLight). VTK's anisotropy, clear coat, edge tint, index
    of refraction other than 1.5, emissive and other textures, and light from environment textures are not supported;
    `Material.from_property` and `Scene.from_plotter` refuse these features by name.

    If F₉₀ is below 1, the diffuse part uses a single F: that of the brightest channel, at an albedo of 1. For a light
    of 1, the single channel changes the result from VTK's by at most 3e-7, and the single albedo by at most 1e-4.

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
        """Return a copy that also has the diffuse colour of the material, because the lobes depend on this colour."""
        color = rgb(material.diffuse)
        if max(color) > 1.0:
            check.refuse("diffuse", color, "at most 1 in each channel for PBR", "A reflectance of 1 is all light.")
        return _Colored(self.metallic, self.roughness, color)

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """The lobe of the base, and the highlight in two lobes: in the colour F₀, and in white."""
        return _Colored(self.metallic, self.roughness).lobes


def fresnel_ends(metallic: Any, color: Any) -> tuple[Any, Any]:
    """Return the highlight's reflectance at normal incidence, F₀, and at grazing angles, F₉₀.

    F₀ has the shape (3, ...) of `color`, the diffuse colour. F₉₀ is the same for all channels, shape (...). A surface
    with an F₀ below 0.02 is taken for a crevice, as in VTK and Filament (5.6.2, specular occlusion): the nonmetallic
    part of F₉₀ is 50 times the mean of F₀, at most 1. The mean is 0.33 times the sum of the channels, as in VTK.
    """
    f0 = (1.0 - metallic) * DIELECTRIC + metallic * color
    return f0, (1.0 - metallic) * np.minimum(50.0 * 0.33 * (f0[0] + f0[1] + f0[2]), 1.0) + metallic


@dataclass(frozen=True)
class _Colored(PBR):
    """PBR together with the diffuse colour of its material: the result of `PBR.of`."""

    color: Vector = WHITE
    varies: bool = False
    """True if `metallic` is a map."""

    scale: ClassVar[float] = 1.0

    def fade(self, maps: Mapping[str, Any]) -> Any:
        """Return the number t in the factor 1 − tS of the base: t = 1 − (1 − F₉₀)/(1 − F₀).

        F₀ is that of the brightest channel. In this channel, (1 − F₀)(1 − tS) is then 1 − F. The result is one number,
        or one for each vertex if `maps` has a map of `metallic`.
        """
        f0, f90 = fresnel_ends(maps.get("metallic", self.metallic), np.array(self.color)[:, None])
        top = f0.max(axis=0)
        fade = np.where(f90 < 1.0, (f90 - top) / np.maximum(1.0 - top, 1e-9), 1.0)
        return fade if "metallic" in maps else float(fade[0])

    def over(self, maps: Mapping[str, tuple[float, float]]) -> PBR:
        """Return a copy whose lobes' colours are upper bounds if `metallic` varies.

        `maps` has the range of each field that is a map. `metallic` varies if it is one of them.
        """
        return replace(self, varies="metallic" in maps)

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """The base, and the highlight in two lobes, in the colours F₀ and F₉₀.

        In a blend of nonmetal and metal, F₀ is not a multiple of the albedo, so the lobes need a `tint`. If `metallic`
        is a map, the colours are the greatest for any value from 0 to 1: the base decreases with `metallic`, and F₀ is
        linear in `metallic`.
        """
        color, is_blend = np.array(self.color)[:, None], self.varies or 0.0 < self.metallic < 1.0
        low, high = (0.0, 1.0) if self.varies else (self.metallic, self.metallic)
        least_f0, least_f90 = fresnel_ends(low, color)
        under = (1.0 - low) * (1.0 - least_f0)
        f0 = np.maximum(least_f0, fresnel_ends(high, color)[0])
        f90 = np.ones(1) if self.varies else least_f90

        def ends(albedo: FloatArray, maps: Mapping[str, FloatArray]) -> tuple[Any, Any, Any]:
            """Return `metallic`, F₀ and F₉₀ at vertices, in the float type of their albedo, shape (3, n)."""
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
    """PBR exactly as VTK's shader computes it, including its factor 1/π, its least cosines and its gamma."""

    gamma: ClassVar[float] = 2.2
    is_physical: ClassVar[bool] = True
    scale: ClassVar[float] = 1.0 / math.pi
    """Factor of the shader, 1/π."""

    cutoffs: ClassVar[tuple[float, float]] = _FLOOR, _LEAST


# --- VTK's properties


def is_physical(prop: Any) -> bool:
    """Return True if `prop`, a VTK property, has physically based shading."""
    return bool(prop.GetInterpolationAsString() == "Physically based rendering")


def physical_of(prop: Any) -> PBR:
    """Return the reflectance of `prop`, a VTK property with physically based shading.

    Raise ValueError if the property uses a feature that pvphong does not support.
    """
    asked = {
        "anisotropy": (prop.GetAnisotropy(), 0.0),
        "coat_strength": (prop.GetCoatStrength(), 0.0),
        "edge_tint": (tuple(prop.GetEdgeTint()), (1.0, 1.0, 1.0)),
        "base_ior": (prop.GetBaseIOR(), 1.5),
        "textures": (prop.GetNumberOfTextures(), 0),
    }
    for name, (given, only) in asked.items():
        if given != only:
            check.refuse(f"prop.{name}", given, f"{only} with pbr=True", "pvphong does not support this part of VTK.")
    if prop.GetRoughness() <= 0.0:
        remedy = "With a roughness of 0, VTK draws no highlight; use 0.05 for a near mirror."
        check.refuse("prop.roughness", prop.GetRoughness(), "above 0", remedy)
    return PBR(prop.GetMetallic(), prop.GetRoughness())
