"""What all lights have in common: colours, switch, frame and name."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, Self, get_args

import numpy as np

from pvphong.base import check
from pvphong.base.host import blank_light
from pvphong.base.types import ColorLike, Float64Array, FloatArray, Frame, Vector, rgb

if TYPE_CHECKING:
    import pyvista as pv


# A focal point this many bits closer than the coordinates are large still tells the direction to 2⁻³².
_KEPT_BITS = 20


class Arrival(NamedTuple):
    """What reaches a block of n points from one light, before its colour is taken into account."""

    way: FloatArray
    """Vectors towards the light, shape (3, n), or (3, 1) where it is constant: unit vectors, or such of moderate
    length as are known better. Which side of a surface the light is on is decided on these."""

    strength: Float64Array | float
    """Attenuation times spot factor, a · s in the model: shape (n,), or one float where it is constant."""

    inverse_length: FloatArray | float = 1.0
    """Of the ways, shape (n,) or one float; 0 where a way is zero."""

    @property
    def direction(self) -> FloatArray:
        """Unit vectors towards the light, l in the model: as `way`, and zero where there is no direction."""
        return self.way * self.inverse_length


class EyeSpace(Protocol):
    """What a light needs of a viewer in order to ride along with it; `pvphong.Viewer` has it."""

    @property
    def position(self) -> Any:
        """The eye, in world coordinates."""

    @property
    def view_direction(self) -> Vector:
        """Unit vector from the eye along the view axis, in world coordinates."""

    @property
    def distance(self) -> float:
        """From the eye to the focal point."""

    def point_to_world(self, point: Vector) -> Vector:
        """A point of eye space in world coordinates."""

    def vector_to_world(self, vector: Vector) -> Vector:
        """A vector of eye space in world coordinates."""


@dataclass(frozen=True, kw_only=True)
class Light(ABC):
    """Fields and checks that every light shares.

    Parameters
    ----------
    diffuse : color, default (1, 1, 1)
        Colour of the light that matt surfaces scatter, Ld. Linear, 1.0 = full.
    specular : color, optional
        Colour of the light that highlights mirror, Ls; `diffuse` where it is not given.
    ambient : color, default (0, 0, 0)
        Colour that the light adds everywhere it reaches, whatever the normal, La.
    intensity : float, default 1
        Multiplies all three colours; >= 0.
    on : bool, default True
        Whether the light shines.
    frame : {"world", "camera", "headlight"}
        Where its coordinates stand. "camera": in eye space (eye at the origin, looking down −z, y up),
        so that the light moves with the viewer. "headlight": position and direction are the viewer's,
        and the light's own are ignored.
    name : str
        Names its array in results.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.
    """

    diffuse: ColorLike = (1.0, 1.0, 1.0)
    specular: ColorLike | None = None
    ambient: ColorLike = (0.0, 0.0, 0.0)
    intensity: float = 1.0
    on: bool = True
    frame: Frame = "world"
    name: str = ""

    def __init_subclass__(cls, **options: Any) -> None:
        """Refuse kinds of kinds: plans and the compiled evaluator know each by its class, not by its methods."""
        super().__init_subclass__(**options)
        if Light not in cls.__bases__:
            raise TypeError(f"{cls.__name__} must derive from Light itself; got {cls.__bases__[0].__name__}.")

    def __post_init__(self) -> None:
        self._set("diffuse", check.color("diffuse", self.diffuse))
        if self.specular is not None:
            self._set("specular", check.color("specular", self.specular))
        self._set("ambient", check.color("ambient", self.ambient))
        self._set("intensity", check.number("intensity", self.intensity, at_least=0.0))
        self._set("on", check.flag("on", self.on))
        self._set("frame", check.choice("frame", self.frame, get_args(Frame)))
        self._set("name", check.text("name", self.name))
        self._check_geometry()

    def _set(self, field: str, value: object) -> None:
        object.__setattr__(self, field, value)

    @cached_property
    def specular_color(self) -> Vector:
        """Red, green, blue of the light in highlights: `specular`, or `diffuse` where that is None."""
        return rgb(self.diffuse if self.specular is None else self.specular)

    @abstractmethod
    def _check_geometry(self) -> None:
        """Check the fields that only this kind of light has, and put them into canonical form."""

    @abstractmethod
    def in_world(self, viewer: EyeSpace) -> Self:
        """This light with its coordinates in the world, as `viewer` makes them."""

    @abstractmethod
    def arrival(self, points: Float64Array, real: Any = np.float64) -> Arrival:
        """What reaches points (3, n) in its own frame; ways to the light are in the float type `real`."""

    @abstractmethod
    def _place(self, light: pv.Light, distance: float) -> None:
        """Give a `pyvista.Light` of the right type this light's place and shape."""

    def to_pyvista(self, viewer: EyeSpace | None = None) -> pv.Light:
        """The same light as a new `pyvista.Light`, its floats unrounded.

        A light in the camera's frame becomes a camera light, a headlight a headlight, any other a
        scene light. VTK clamps spot exponents to 128 and has no name for a light.

        Parameters
        ----------
        viewer : Viewer, optional
            VTK measures a camera light's position in units of the distance from eye to focal point;
            it is taken from here, and is 1 without.
        """
        light = blank_light()
        self.write_to(light, viewer)
        return light

    def write_to(self, light: Any, viewer: EyeSpace | None = None) -> None:
        """Give an existing `pyvista.Light` or `vtkLight` this light's values, as `to_pyvista` does."""
        {
            "world": light.SetLightTypeToSceneLight,
            "camera": light.SetLightTypeToCameraLight,
            "headlight": light.SetLightTypeToHeadlight,
        }[self.frame]()
        light.SetTransformMatrix(None)
        light.SetDiffuseColor(rgb(self.diffuse))
        light.SetSpecularColor(self.specular_color)
        light.SetAmbientColor(rgb(self.ambient))
        light.SetIntensity(self.intensity)
        light.SetSwitch(self.on)
        self._place(light, 1.0 if viewer is None else viewer.distance)


def place_for_vtk(position: Vector, frame: Frame, distance: float) -> Vector:
    """A position in the coordinates that VTK keeps for a light of this frame.

    VTK's camera-light space has the eye at (0, 0, 1), looks at the origin and counts in units of the
    distance between the two (vtkCamera::ComputeCameraLightTransform).
    """
    if frame != "camera":
        return position
    x, y, z = position
    return x / distance, y / distance, z / distance + 1.0


def point_ahead(position: Vector, direction: Vector) -> Vector:
    """A point in some direction, far enough from the position that the direction can be told from the two."""
    reach = max(map(abs, direction))
    step = max(1.0, 2.0 ** (math.frexp(max(map(abs, position)))[1] - math.frexp(reach)[1] - _KEPT_BITS))
    x, y, z = (p + d * step for p, d in zip(position, direction, strict=True))
    return x, y, z
