"""Light models, which combine the contributions of lights, in the standard convention or in VTK's.

`LightModel.opengl` returns OpenGL's defaults, in the standard convention.
"""

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
        return check.number(name, value, above=0.0, remedy="True means any distance.")
    return check.refuse(name, value, "True, False, or a distance > 0")


# More bounces make no difference: the light that is left after n bounces falls as rⁿ, with a reflectance r < 1.
_MOST_BOUNCES = 2.0**16


def _count(name: str, value: Any) -> int:
    number = check.number(name, value, at_least=0.0, at_most=_MOST_BOUNCES)
    return int(number) if number == int(number) else check.refuse(name, value, "a whole number >= 0")


@dataclass(frozen=True)
class LightModel:
    """Model that combines the contributions of lights.

    Parameters
    ----------
    ambient : color, default 0.2
        Ambient light A, which arrives from all directions; the default is OpenGL's.
    local_viewer : bool, default True
        If True, compute the direction to the viewer at each vertex. If False, the direction is the same everywhere:
        along the view axis, towards the eye (OpenGL's default).
    two_sided : bool, default False
        If True, a vertex whose normal points away from the viewer is lit with the opposite normal, and with the shadows
        and the occlusion on the side of the opposite normal.
    reflection : {"phong", "blinn-phong"}
        Formula of the highlight, with the shininess s. "phong": (r·v)ˢ, with the mirror direction r (Phong 1975).
        "blinn-phong": (n·h)ˢ, with the half-way direction h, as in OpenGL (Blinn 1977).
    clamp : bool, default True
        If True, clamp the summed colour to [0, 1].
    convention : {"standard", "vtk"}
        "vtk" reproduces VTK's shader: three tiers of lighting code, a floor of 1e-5 under the highlight's cosine,
        material ambient not multiplied by any light, ambient and specular colours of lights ignored, a local viewer
        even in parallel projection, exponents of at most 128, and scenes without lights drawn unlit. `ambient` then has
        no effect. A material with the reflectance `PBR` is shaded as with VTK's `pbr=True`, including a final gamma of
        2.2.
    shadows : bool, default False
        If True, multiply the diffuse and specular light of each light by its visibility from the vertex. The mesh
        itself and other meshes may hide the light. Lights with `casts_shadows=False` are not multiplied. Visibility is
        0 or 1 for a light without a size. For a light with a size, it is the fraction of its light that reaches a matt
        surface. Highlights use the same fraction; they are wrong where geometry hides the part of the light that they
        mirror. `tradeoff` measures this error; `truth` does not have it.
    ambient_occlusion : bool or float, default False
        If not False, multiply ambient light (`ambient`, and the ambient colours of lights) by the visible fraction of
        the sky: of the hemisphere around the normal, weighted by the cosine. A number > 0 is the distance, in the
        mesh's unit, up to which geometry occludes the sky; True means any distance.
    bounces : int, default 0
        Number of diffuse reflections between surfaces to compute, up to 65,536. `ambient` stands for the reflections
        that are not computed: for all reflections if `bounces` is 0, else for the reflections after the last computed
        one. Surfaces reflect on the side to which their normals point; their other sides are black.

    Raises
    ------
    ValueError
        If a field is out of range, or has a value that VTK's convention does not support.

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
        """Raise TypeError for an unknown field; the message suggests the nearest field."""
        check.keywords(cls, fields)
        return super().__new__(cls)

    def __post_init__(self) -> None:
        check.fields(self)
        if self.convention == "vtk" and not self.local_viewer:
            check.refuse("local_viewer", False, "True in VTK's convention", "VTK's viewer is always local.")
        if self.convention == "vtk" and self.reflection != "phong":
            check.refuse("reflection", self.reflection, "'phong' in VTK's convention", "VTK has no other.")
        if self.bounces and self.convention == "vtk":
            check.refuse("bounces", self.bounces, "0 in VTK's convention", "VTK's light does not bounce.")
        if self.bounces and self.two_sided:
            remedy = "The two sides of a surface would reflect different light; set two_sided=False."
            check.refuse("bounces", self.bounces, "0 if the light model is two-sided", remedy)

    @property
    def needs_rays(self) -> bool:
        """True if shadows or ambient occlusion are on, for which rays must be cast to lights or the sky."""
        return self.shadows or self.ambient_occlusion is not False

    @property
    def occlusion_distance(self) -> float:
        """Distance up to which geometry occludes the sky.

        It is `ambient_occlusion` if this is a number, and infinite if it is True or False.
        """
        return math.inf if isinstance(self.ambient_occlusion, bool) else self.ambient_occlusion

    @property
    def is_global(self) -> bool:
        """True if other surfaces affect the light at a vertex, by shadows, ambient occlusion or bounces."""
        return self.needs_rays or self.bounces > 0

    def without_rays(self) -> Self:
        """Return the same model without shadows, occlusion and bounces."""
        return replace(self, shadows=False, ambient_occlusion=False, bounces=0)

    @classmethod
    def opengl(cls) -> Self:
        """Return OpenGL's defaults: ambient 0.2, infinite viewer, one-sided, half-way reflection.

        Source: OpenGL 2.1 specification, table 2.10 (LIGHT_MODEL_AMBIENT and following).
        """
        return cls(ambient=0.2, local_viewer=False, two_sided=False, reflection="blinn-phong")

    @classmethod
    def vtk(cls, two_sided: bool = True) -> Self:
        """Return the model of VTK's shader.

        VTK lights both sides of surfaces (`two_sided` is True), but only one side of points (`two_sided` is False).

        Source: VTK's vtkOpenGLPolyDataMapper.cxx (ReplaceShaderLight).
        """
        return cls(ambient=1.0, two_sided=two_sided, convention="vtk")
