"""What every light is: fields and checks that all share, and the questions that a light answers for itself.

A new light is one file in `pvphong/optics/lights/` and its entry in `LIGHT_TYPES` there, whose key scene files name
it by; what makes it public and tested is said there. It declares its fields with roles (`roles.py`) and must
say where it is and how it weakens (`placement`), or of which lights without a size it consists (`nodes`), or what
arrives at a vertex (`arrival`, which only the readable evaluator runs). Everything else has an answer here that assumes
nothing of it. Which cheaper light may replace it, `pvphong/shading/plan/lights.py` says; as what VTK draws it,
`lights/conversion.py`; a kind that these do not know runs as it is, and is not drawn.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self, cast, get_args

import numpy as np

from pvphong.base import check, host
from pvphong.base.formulas import Power, chord_power
from pvphong.base.types import ColorLike, Float64Array, FloatArray, Frame, InitSignature, Vector, rgb
from pvphong.base.vectors import directions_to
from pvphong.optics.area.lobes import CosinePower
from pvphong.optics.area.sampling import Sampling
from pvphong.optics.attenuation import attenuate
from pvphong.optics.roles import Corners, Place, Role, roles_of

if TYPE_CHECKING:
    import pyvista as pv


class Arrival(NamedTuple):
    """What reaches a block of n points from one light, before its colour is taken into account."""

    to_light: FloatArray
    """Vectors towards the light, shape (3, n), or (3, 1) where it is constant: unit vectors, or such of moderate
    length as are known better. Which side of a surface the light is on is decided on these."""

    strength: Float64Array | float
    """Attenuation times spot factor, a · s in the model: shape (n,), or one float where it is constant."""

    inverse_length: FloatArray | float = 1.0
    """One over the lengths of those vectors, shape (n,) or one float; 0 where a vector is zero."""

    @property
    def direction(self) -> FloatArray:
        """Unit vectors towards the light, l in the model: as `to_light`, and zero where there is no direction."""
        return self.to_light * self.inverse_length


NODES = 64
"""A light with a size is evaluated as so many lights without one where there is no closed form, or as `nodes_for`."""


class Integral(NamedTuple):
    """What a lobe reflects of all of a light with a size, of intensity 1: the limit of the sum over ever more nodes."""

    formula: Callable[..., Any]
    """A function of its numbers, of those of the lobe (`lobe_numbers`), of the offset d from a vertex to its place, the
    unit normal n and the unit vector a of the lobe. It reads its numbers by index, and runs on arrays and in compiled
    code. It gives 0 where n or a is zero."""

    place: Vector
    """The point to which d leads."""

    radius: float
    """All of the light is within a sphere of that radius around there. The formula is not asked where none of it is
    above the horizon, or a lobe around the mirrored viewer is 0: see `lobes.may_rise` and `lobes.shows`."""

    numbers: tuple[float, ...]


class Placement(NamedTuple):
    """Where a light without a size is and how strong it is around there: what `arrival` and compiled code run."""

    position: Vector

    attenuation: Vector
    """Constant, linear and quadratic coefficient."""

    falloff: Callable[[Any, Any], tuple[Any, Any]] | None = None
    """Formula of the parameters and of the unit vector to it, which is zero on the light itself: 1 where it shines,
    else 0; and the squared chord of whose cosine a power is a factor of its strength."""

    power: Power | None = None
    """That power, where there is a falloff."""

    parameters: tuple[float, ...] = ()
    """The formula's numbers, at most eight."""

    most_gain: float = math.inf
    """Where its colours times so much may be beyond float32, the readable evaluator is to light the scene."""


def _color_or_none(name: str, value: Any) -> Any:
    return None if value is None else check.color(name, value)


class _Kind(type):
    """The type of lights, whose kinds show users what is theirs: help() and tab leave out how a light is evaluated.

    `Light` itself shows all of it, to those who write a kind.
    """

    def __dir__(cls) -> list[str]:
        names = list(super().__dir__())
        if not any(isinstance(base, _Kind) for base in cls.__bases__):
            return names
        shown = _SHOWN | {each.name for each in fields(Light)}
        hidden = {*vars(Light), *_OF_KINDS} - shown - {each.name for each in fields(cast("Any", cls))}
        return [name for name in names if name.startswith("__") or name not in hidden]


_SHOWN = {"in_frame", "in_world", "moved", "outline", "places", "specular_color", "to_pyvista"}
_OF_KINDS = {"area", "bands", "error_without_bands", "part", "reach_radius", "sampled", "sides", "spots", "triangles"}


@dataclass(frozen=True, kw_only=True)
class Light(metaclass=_Kind):
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
        Multiplies all three colours; >= 0. A light that weakens with 1/d², as those with a size do, needs as much more
        as its distance squared.
    on : bool, default True
        Whether the light shines.
    frame : {"world", "camera", "headlight"}
        What its coordinates are relative to. "camera": in eye space (eye at the origin, looking down −z, y up),
        so that the light moves with the viewer. "headlight": position and direction are the viewer's,
        and the light's own are ignored; its `up`, if it has one, is in eye space, where (0, 1, 0) is the viewer's.
    name : str
        Names its array in results.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.

    Examples
    --------
    >>> import pvphong as ph
    >>> sun = ph.DirectionalLight()
    >>> isinstance(sun, ph.Light), sun.intensity
    (True, 1.0)
    """

    diffuse: ColorLike = check.field(check.color, (1.0, 1.0, 1.0))
    specular: ColorLike | None = check.field(_color_or_none, None)
    ambient: ColorLike = check.field(check.color, (0.0, 0.0, 0.0))
    intensity: float = check.field(partial(check.number, at_least=0.0), 1.0)
    on: bool = check.field(check.flag, True)
    frame: Frame = check.field(partial(check.choice, allowed=get_args(Frame)), "world")
    name: str = check.field(check.text, "")

    is_even: ClassVar[bool] = False
    """Whether it arrives at every vertex alike."""

    intensity_unit: ClassVar[str] = ""
    """What `intensity` is measured in; "" where a facing white patch gets so much of a colour."""

    __signature__ = InitSignature()

    def __new__(cls, *_given: Any, **given: Any) -> Self:
        """Refuse a colour by the name that PyVista's lights have for it, and fields that it has not."""
        check.refuse_color(cls, given)
        check.keywords(cls, given)
        return super().__new__(cls)

    def __init_subclass__(cls, **options: Any) -> None:
        """Refuse kinds of kinds: what one says of itself need not hold for another whose arrival differs."""
        super().__init_subclass__(**options)
        if Light not in cls.__bases__:
            raise TypeError(f"{cls.__name__} must derive from Light itself; got {cls.__bases__[0].__name__}.")
        if (cls.arrival, cls.nodes, cls.placement) == (Light.arrival, Light.nodes, Light.placement):
            raise TypeError(f"{cls.__name__} must say what arrives from it, by `placement`, `arrival` or `nodes`.")

    def __post_init__(self) -> None:
        if type(self) is Light:
            raise TypeError("Light is abstract; its kinds are in pvphong.optics.lights.")
        check.fields(self)

    def __dir__(self) -> list[str]:
        return dir(type(self))

    # -- what it says of its fields

    @property
    def roles(self) -> dict[str, Role]:
        """Name of each field that only this kind of light has → what it means."""
        kind: Any = type(self)
        return roles_of(kind)

    @cached_property
    def specular_color(self) -> Vector:
        """Red, green, blue of the light in highlights: `specular`, or `diffuse` where that is None."""
        return rgb(self.diffuse if self.specular is None else self.specular)

    def values(self, kind: type[Role]) -> list[Any]:
        """The values of its fields with a role."""
        return [getattr(self, field) for field, role in self.roles.items() if isinstance(role, kind)]

    def with_values(self, kind: type[Role], value: Any) -> Self:
        """This light with another value in each of its fields with a role."""
        return replace(self, **{field: value for field, role in self.roles.items() if isinstance(role, kind)})

    @property
    def places(self) -> list[Vector]:
        """The points that its fields place it at."""
        return [*self.values(Place), *(corner for corners in self.values(Corners) for corner in corners)]

    def moved(self, move: Callable[[Vector], Vector]) -> Self:
        """This light with every place moved, and no direction or size."""
        return self._mapped(move, lambda vector: vector, self.frame)

    def in_world(self, viewer: Any) -> Self:
        """This light with its coordinates in the world, as `viewer` makes them."""
        if self.frame == "world":
            return self
        if self.frame == "camera":
            return self._mapped(viewer.point_to_world, viewer.vector_to_world, "world")
        return self._with(lambda role, value: role.of_viewer(value, viewer), frame="world")

    def in_frame(self, frame: Frame, viewer: Any) -> Self:
        """A light of the world with its coordinates in another frame: the inverse of `in_world`."""
        if frame == "camera":
            return self._mapped(viewer.point_to_eye, viewer.vector_to_eye, frame)
        return replace(self, frame=frame)

    def _mapped(self, point: Callable[[Vector], Vector], vector: Callable[[Vector], Vector], frame: Frame) -> Self:
        return self._with(lambda role, value: role.mapped(value, point, vector), frame=frame)

    def _with(self, change: Callable[[Role, Any], Any], **fields: Any) -> Self:
        changed = {field: change(role, getattr(self, field)) for field, role in self.roles.items()}
        return replace(self, **changed, **fields)

    @property
    def outline(self) -> Float64Array | None:
        """Points around its edge, shape (k, 3), in its own frame, as a window shows it; None where it has none.

        They are in a plane, and run counter-clockwise as its front is seen.
        """
        return None

    # -- what it does to vertices

    @property
    def placement(self) -> Placement | None:
        """Where it is and how strong it is around there, for a light without a size that has a place.

        None where `arrival` says what arrives; then only the readable evaluator lights a scene with it, unless it is
        even.
        """
        return None

    def arrival(self, points: Float64Array, real: Any = np.float64) -> Arrival:
        """What reaches points (3, n) in its own frame; vectors to the light are in the float type `real`.

        Of an extended light this is what its centre sends.
        """
        placed = self.placement
        if placed is None:
            return self.nodes(1)[0].arrival(points, real)
        to_light, inverse_length, distance = directions_to(placed.position, points, real)
        strength = attenuate(distance, placed.attenuation)
        if placed.falloff and placed.power:
            # in float64, for light may be as bright as its falloff is steep
            l = (to_light * inverse_length).astype(np.float64, copy=False)
            inside, chord = placed.falloff(placed.parameters, l)
            strength = strength * (inside * np.asarray(chord_power(chord, placed.power.exponent), np.float64))
        return Arrival(to_light, strength, inverse_length)

    @property
    def has_size(self) -> bool:
        """Whether it is a sum of nodes."""
        return type(self).nodes is not Light.nodes

    def nodes(self, count: int) -> tuple[Light, ...]:  # noqa: ARG002 a light without a size has one
        """The lights without a size, at most `count`, as whose sum it is evaluated; their intensities are parts of it.

        A light without a size is its own only node.
        """
        return (self,)

    def nodes_for(self, sharpness: float) -> int:  # noqa: ARG002 lobes that are sharper than its nodes are close
        """How many nodes it is evaluated as for a lobe of a sharpness, as `Reflectance.sharpness` has it."""
        return NODES

    @property
    def bands(self) -> int:
        """The number of bands of spherical harmonics that a light from all around is divided into; 0 for others."""
        return 0

    def error_without_bands(self, form: CosinePower, bands: int) -> float:  # noqa: ARG002 it has none
        """The largest error in the light that a lobe reflects of it, at intensity 1, with only the first bands.

        With all of its `bands`: the largest error of the evaluation with all of them.
        """
        return 0.0

    def tints(self, bands: int | None = None) -> tuple[tuple[Vector, Light], ...]:  # noqa: ARG002 it has none
        """The lights of one colour each as whose sum its closed forms are evaluated.

        Parameters
        ----------
        bands : int, optional
            How many are kept, of those that have bands; all if not given.
        """
        return (((1.0, 1.0, 1.0), self),)

    def closed(self, form: CosinePower) -> Integral | None:  # noqa: ARG002 there is none
        """What a lobe reflects of all of it, exactly; None where its `nodes` are to do."""
        return None

    @property
    def sampling(self) -> Sampling | None:
        """How rays to it are chosen, for a light with a size; None where it casts no shadows."""
        return None

    def radiance(self, directions: Float64Array) -> FloatArray:  # noqa: ARG002 it has no area that could be seen
        """The colours as which a light with a size shows itself, at intensity 1, along unit vectors (3, n) from it.

        Of shape (3, n), or (3, 1) where they are the same.
        """
        return np.zeros((3, 1))

    # -- what VTK knows of it

    def to_pyvista(self, viewer: Any = None) -> pv.Light:
        """The same light as a new `pyvista.Light`, its floats unrounded; of a light that VTK has not, the nearest.

        A light in the camera's frame becomes a camera light, a headlight a headlight, any other a
        scene light. VTK clamps spot exponents to 128 and has no name for a light.

        Parameters
        ----------
        viewer : Viewer, optional
            VTK measures a camera light's position in units of the distance from eye to focal point;
            it is taken from here, and is 1 without.

        Raises
        ------
        ValueError
            If VTK has nothing like it.
        """
        return host.answers().to_pyvista(self, viewer)
