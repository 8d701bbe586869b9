"""How the lights' contributions are put together: a standard model, OpenGL's, VTK's."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Self, get_args

import numpy as np

from pvphong.base import check
from pvphong.base.types import ColorLike, Convention, InitSignature, Reflection


def _flag_or_distance(name: str, value: Any) -> bool | float:
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, float, np.number)):
        return check.number(name, value, above=0.0, remedy="True is any distance.")
    return check.refuse(name, value, "True, False, or a distance > 0")


# More are not told apart from so many: what is left after n bounces falls as rⁿ.
_MOST_BOUNCES = 2.0**16


def _count(name: str, value: Any) -> int:
    number = check.number(name, value, at_least=0.0, at_most=_MOST_BOUNCES)
    return int(number) if number == int(number) else check.refuse(name, value, "a whole number >= 0")


@dataclass(frozen=True)
class LightModel:
    """How the lights' contributions are put together.

    Parameters
    ----------
    ambient : color, default 0.2
        Light that comes from everywhere, A. OpenGL's default.
    local_viewer : bool, default True
        The direction to the viewer is taken at each vertex; False: the same everywhere, towards the eye
        along the view axis (OpenGL's default).
    two_sided : bool, default False
        A vertex whose normal points away from the viewer is lit with the opposite normal, and shadows and occlusion are
        those of that side.
    reflection : {"phong", "blinn-phong"}
        Highlight by the mirror direction, (r·v)ⁿ (Phong 1975), or by the half-way direction,
        (n·h)ⁿ (Blinn 1977), which OpenGL uses.
    clamp : bool, default True
        The summed colour is clamped to [0, 1] at the end.
    convention : {"standard", "vtk"}
        "vtk" follows VTK's shader to the letter: three tiers of lighting code, a floor of 1e-5 under the
        highlight's cosine, material ambient not multiplied by any light, ambient and specular colours of
        lights ignored, a local viewer even in parallel projection, exponents of at most 128, and a scene
        without any light drawn unlit. `ambient` has no effect in it. A material with the reflectance `PBR` is
        shaded as VTK shades `pbr=True`, its last power included.
    shadows : bool, default False
        What a light adds by diffuse and specular reflection is multiplied by the part of it that a vertex sees past
        the mesh itself and other meshes. Of a light without a size that is 0 or 1; of one with a size it is the part
        that reaches a matt surface, also for highlights, which are off where something hides what they mirror:
        `tradeoff` measures by how much, `truth` is without that.
    ambient_occlusion : bool or float, default False
        Ambient light, `ambient` above and that of lights, is multiplied by the open part of the sky: of the hemisphere
        around the normal, weighted with the cosine. A number > 0 is the distance, in the mesh's unit, up to which
        something blocks it; True is any distance.
    bounces : int, default 0
        How often, up to 65,536, light is followed from surface to surface, as diffuse reflection of what each vertex
        sees. The constant ambient light then counts only for what is left after the last bounce. Sides are as the
        normals point: what is seen from behind is black.

    Raises
    ------
    ValueError
        If a field is out of range, or asks of VTK's convention what VTK does not do.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> model = ph.LightModel(ambient=0.1, shadows=True)
    >>> lit = pv.Sphere().phong.shade(ph.Scene([ph.DirectionalLight()], light_model=model))
    """

    ambient: ColorLike = check.field(check.color, 0.2)
    local_viewer: bool = check.field(check.flag, True)
    two_sided: bool = check.field(check.flag, False)
    reflection: Reflection = check.field(partial(check.choice, allowed=get_args(Reflection)), "phong")
    clamp: bool = check.field(check.flag, True)
    convention: Convention = check.field(partial(check.choice, allowed=get_args(Convention)), "standard")
    shadows: bool = check.field(check.flag, False)
    ambient_occlusion: bool | float = check.field(_flag_or_distance, False)
    bounces: int = check.field(_count, 0)

    __signature__ = InitSignature()

    def __new__(cls, *_given: Any, **fields: Any) -> Self:
        """Refuse fields that it has not, and suggest one that it has."""
        check.keywords(cls, fields)
        return super().__new__(cls)

    def __post_init__(self) -> None:
        check.fields(self)
        if self.convention == "vtk" and not self.local_viewer:
            check.refuse("local_viewer", False, "True in VTK's convention", "VTK's viewer is always local.")
        if self.convention == "vtk" and self.reflection != "phong":
            check.refuse("reflection", self.reflection, "'phong' in VTK's convention", "VTK knows no other.")
        if self.bounces and self.convention == "vtk":
            check.refuse("bounces", self.bounces, "0 in VTK's convention", "VTK's light does not bounce.")
        if self.bounces and self.two_sided:
            remedy = "A surface's two sides would send different light; LightModel(two_sided=False) has one."
            check.refuse("bounces", self.bounces, "0 where the light model is two-sided", remedy)

    @property
    def needs_rays(self) -> bool:
        """Whether it needs to know what is between vertices and lights, or the sky."""
        return self.shadows or self.ambient_occlusion is not False

    @property
    def occlusion_distance(self) -> float:
        """Up to where something hides the sky."""
        return math.inf if isinstance(self.ambient_occlusion, bool) else self.ambient_occlusion

    @property
    def is_global(self) -> bool:
        """Whether other surfaces change the light at a vertex (global illumination): shadows, occlusion, bounces."""
        return self.needs_rays or self.bounces > 0

    def without_rays(self) -> Self:
        """The same without shadows, occlusion and bounces."""
        return replace(self, shadows=False, ambient_occlusion=False, bounces=0)

    @classmethod
    def opengl(cls) -> Self:
        """OpenGL's own defaults: ambient 0.2, infinite viewer, one-sided, half-way reflection.

        Source: OpenGL 2.1 specification, table 2.10 (LIGHT_MODEL_AMBIENT and following).
        """
        return cls(ambient=0.2, local_viewer=False, two_sided=False, reflection="blinn-phong")

    @classmethod
    def vtk(cls, two_sided: bool = True) -> Self:
        """VTK's shader: two-sided as it draws surfaces, or one-sided as it draws points.

        Source: VTK's vtkOpenGLPolyDataMapper.cxx (ReplaceShaderLight).
        """
        return cls(ambient=1.0, two_sided=two_sided, convention="vtk")
