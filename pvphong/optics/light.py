"""Base class of lights: the fields and checks that all lights share, and the methods that a kind of light overrides.

A new kind of light is one file in `pvphong/optics/lights/`, and an entry in `LIGHT_TYPES` there. The entry's key is the
kind's name in scene files. That package's docstring lists the steps that make it public and tested.

A kind of light declares its fields with roles (`roles.py`), and must define one of:

- `placement`: its position and falloff;
- `nodes`: lights without a size, whose sum replaces it;
- `arrival`: the light that arrives at a vertex. Usually only the readable evaluator calls it; see `Light.placement`.

All other methods have safe defaults here. `pvphong/shading/plan/lights.py` defines cheaper replacements of lights, and
`lights/conversion.py` the lights that VTK draws in their place. A kind that is not registered in these two files is
evaluated unchanged, and VTK does not draw it.
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
    """Light that arrives at a block of n points from one light, before its colour is applied."""

    to_light: FloatArray
    """Vectors towards the light, shape (3, n), or (3, 1) if constant. Not necessarily unit length; see
    `inverse_length`. The vectors decide whether the light is in front of a surface or behind it."""

    strength: Float64Array | float
    """Attenuation times spot factor, a · s in the lighting model: shape (n,), or one float if constant."""

    inverse_length: FloatArray | float = 1.0
    """Inverse lengths of the vectors `to_light`, shape (n,) or one float; 0 for a zero vector."""

    @property
    def direction(self) -> FloatArray:
        """Unit vectors l towards the light, in the shape of `to_light`; zero where `to_light` is zero."""
        return self.to_light * self.inverse_length


NODES = 64
"""Default number of lights without a size that approximate an area light if there is no closed form; see
`Light.nodes_for`."""


class Integral(NamedTuple):
    """Light that a lobe, a part of a reflectance, reflects from an area light of intensity 1.

    The integral is the limit of the sum over the light's `nodes` as their number grows.
    """

    formula: Callable[..., Any]
    """Formula with the arguments: the `numbers` below, the lobe's numbers (from `lobe_numbers`), the offset d from a
    vertex to `place`, the unit normal n, and the unit vector a around which the lobe is a power of the cosine. It reads
    numbers by index, and runs on arrays and in compiled code. It returns 0 where n or a is zero."""

    place: Vector
    """The light's centre, at which the offset d ends."""

    radius: float
    """Radius of a sphere around `place` that encloses the light. The formula is not evaluated where the sphere is below
    the horizon, or outside a lobe around the mirrored viewer: see `lobes.may_rise` and `lobes.shows`."""

    numbers: tuple[float, ...]


class Pattern(NamedTuple):
    """Table of the factors by which a light's strength depends on the direction.

    The formula `place` finds the place of a direction in the table, and the formula `value` reads the factor there.
    There are two formulas, because compiled code can vectorise `place`, which does not read the table.
    """

    place: Callable[[Any, Any], tuple[Any, Any, Any]]
    """Formula with two arguments: `parameters`, and the unit vector to the light, which is zero on the light itself. It
    returns three numbers, a place in the table."""

    value: Callable[[Any, Any, Any, Any], Any]
    """Formula with four arguments: `table`, which it reads by index, and the three numbers. It returns the factor."""

    parameters: tuple[float, ...]
    """Sixteen numbers that the formula `place` reads."""

    table: tuple[float, ...]


class PunctualParameters(NamedTuple):
    """Position and falloff of a light without a size, as `arrival` and compiled code read them."""

    position: Vector

    attenuation: Vector
    """Constant, linear and quadratic coefficients."""

    falloff: Callable[[Any, Any], tuple[Any, Any]] | None = None
    """Formula with two arguments: `parameters`, and the unit vector to the light, which is zero on the light itself.
    It returns two numbers: 1 where the light shines, else 0; and the squared chord |C|² of the angle off the light's
    axis. The strength is multiplied by `power` of this angle's cosine."""

    power: Power | None = None
    """Power of the cosine; None without a falloff."""

    parameters: tuple[float, ...] = ()
    """Numbers that the formula `falloff` reads, at most eight."""

    pattern: Pattern | None = None
    """Table of the strength by direction; a light with a pattern has no falloff."""

    most_gain: float = math.inf
    """Largest factor of a term's colours (`gain` in `pvphong.shading.equation`) with which compiled code can compute
    this light in float32. If the factor is larger, the readable evaluator lights the scene."""


def _color_or_none(name: str, value: Any) -> Any:
    return None if value is None else check.color(name, value)


class _Kind(type):
    """Metaclass of lights. For concrete lights, help() and tab completion omit the methods used for evaluation.

    For `Light` itself, help() and tab completion list all methods, for authors of new kinds.
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
    """Base class of lights: the fields and checks that every light shares.

    Parameters
    ----------
    diffuse : color, default (1, 1, 1)
        Colour of the light for diffuse reflection, Ld. Linear, 1.0 = full.
    specular : color, optional
        Colour of the light in highlights, Ls; defaults to `diffuse`.
    ambient : color, default (0, 0, 0)
        Colour that the light adds everywhere it reaches, independent of the normal, La.
    intensity : float, default 1
        Multiplies all three colours; >= 0. A light with 1/d² falloff, such as an area light, needs an intensity that
        grows with the square of its distance.
    on : bool, default True
        True if the light shines.
    casts_shadows : bool, default True
        If False, nothing blocks this light, even if the light model has shadows: it shines through walls, and no ray is
        cast to it. Light that surfaces have reflected is blocked as always. A `pyvista.Light` has `shadow_attenuation`
        0 in this case.
    frame : {"world", "camera", "headlight"}
        Coordinate system of its position and direction. "world": that of the mesh. "camera": the viewer's, with the eye
        at the origin, y up and the view along −z; the light moves with the viewer. "headlight": the light is at the
        viewer's eye and shines along the view; its own position and direction are ignored, and its `up`, if it has one,
        is in the viewer's coordinates.
    name : str
        Name of the light's array in results.

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
    casts_shadows: bool = check.field(check.flag, True)
    frame: Frame = check.field(partial(check.choice, allowed=get_args(Frame)), "world")
    name: str = check.field(check.text, "")

    is_uniform: ClassVar[bool] = False
    """True if the light that arrives is independent of the position."""

    is_all_around: ClassVar[bool] = False
    """True if the light may come from all directions at once."""

    intensity_unit: ClassVar[str] = ""
    """Unit of `intensity`; "" if, at an intensity of 1, a white patch that faces the light has the light's colour."""

    __signature__ = InitSignature()

    def __new__(cls, *_given: Any, **given: Any) -> Self:
        """Raise an error for unknown fields.

        For `color`, PyVista's name of the field, the message suggests `diffuse`.
        """
        check.refuse_color(cls, given)
        check.keywords(cls, given)
        return super().__new__(cls)

    def __init_subclass__(cls, **options: Any) -> None:
        """Forbid subclassing a concrete light: its bounds and closed forms would be wrong for the subclass."""
        super().__init_subclass__(**options)
        if Light not in cls.__bases__:
            raise TypeError(f"{cls.__name__} must derive directly from Light; got {cls.__bases__[0].__name__}.")
        if (cls.arrival, cls.nodes, cls.placement) == (Light.arrival, Light.nodes, Light.placement):
            raise TypeError(f"{cls.__name__} must override `placement`, `arrival` or `nodes`.")

    def __post_init__(self) -> None:
        if type(self) is Light:
            raise TypeError("Light is abstract. Use one of the lights in pvphong.optics.lights.")
        check.fields(self)

    def __dir__(self) -> list[str]:
        return dir(type(self))

    # -- fields

    @property
    def roles(self) -> dict[str, Role]:
        """Mapping from name to role, for the fields that this kind of light adds to the fields of `Light`."""
        kind: Any = type(self)
        return roles_of(kind)

    @cached_property
    def specular_color(self) -> Vector:
        """Red, green, blue of the light in highlights: `specular`, or `diffuse` if `specular` is None."""
        return rgb(self.diffuse if self.specular is None else self.specular)

    def values(self, kind: type[Role]) -> list[Any]:
        """Return the values of the fields whose role is an instance of `kind`."""
        return [getattr(self, field) for field, role in self.roles.items() if isinstance(role, kind)]

    def with_values(self, kind: type[Role], value: Any) -> Self:
        """Return a copy of this light, with `value` in each field whose role is an instance of `kind`."""
        return replace(self, **{field: value for field, role in self.roles.items() if isinstance(role, kind)})

    @property
    def places(self) -> list[Vector]:
        """All positions and corners in the light's fields, as a list of points."""
        return [*self.values(Place), *(corner for corners in self.values(Corners) for corner in corners)]

    def moved(self, move: Callable[[Vector], Vector]) -> Self:
        """Return a copy of this light in which the function `move` is applied to all positions and corners.

        Directions and sizes stay the same.
        """
        return self._mapped(move, lambda vector: vector, self.frame)

    def in_world(self, viewer: Any) -> Self:
        """Convert this light to the world frame, for a viewer.

        A light in the world frame is returned unchanged. A light in another frame gets the place that it has for this
        viewer.
        """
        if self.frame == "world":
            return self
        if self.frame == "camera":
            return self._mapped(viewer.point_to_world, viewer.vector_to_world, "world")
        return self._with(lambda role, value: role.of_viewer(value, viewer), frame="world")

    def in_frame(self, frame: Frame, viewer: Any) -> Self:
        """Convert this light from the world frame to the frame `frame` of a viewer; the inverse of `in_world`."""
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
        """Points around the edge of a flat light, shape (k, 3), in its own frame; None for other lights.

        The points run counter-clockwise as seen from the front. A window draws the outline.
        """
        return None

    @property
    def curves(self) -> tuple[Float64Array, ...]:
        """Curves that show the intensity by direction: for each curve an array of shape (k, 3).

        Each row is an offset from the light's position. Its direction is a direction of light, and its length is the
        intensity there, divided by the largest intensity. A window draws the curves. Lights without measured
        intensities have none.
        """
        return ()

    # -- evaluation

    @property
    def placement(self) -> PunctualParameters | None:
        """Position and falloff of a light without a size; None for a kind that defines `nodes` or `arrival` instead.

        If a kind defines only `arrival`, its `is_uniform` decides which evaluators can light scenes with it. If
        `is_uniform` is True, compiled code and the readable evaluator can. If it is False, only the readable evaluator
        can.
        """
        return None

    def arrival(self, points: Float64Array, real: Any = np.float64) -> Arrival:
        """Return the light that arrives at points; for an area light, as if all light came from its centre.

        Parameters
        ----------
        points : ndarray
            Shape (3, n), in the light's own frame.
        real : type, default float64
            Float type of the result's vectors.
        """
        placed = self.placement
        if placed is None:
            return self.nodes(1)[0].arrival(points, real)
        to_light, inverse_length, distance = directions_to(placed.position, points, real)
        strength = attenuate(distance, placed.attenuation)
        if placed.falloff and placed.power:
            # float64: a bright light compensates for a steep falloff
            l = (to_light * inverse_length).astype(np.float64, copy=False)
            inside, chord = placed.falloff(placed.parameters, l)
            strength = strength * (inside * np.asarray(chord_power(chord, placed.power.exponent), np.float64))
        if placed.pattern:
            l = (to_light * inverse_length).astype(np.float64, copy=False)
            place = placed.pattern.place(placed.pattern.parameters, l)
            strength = strength * placed.pattern.value(np.asarray(placed.pattern.table), *place)
        return Arrival(to_light, strength, inverse_length)

    @property
    def has_size(self) -> bool:
        """True if the light has a size, so that `nodes` approximate it."""
        return type(self).nodes is not Light.nodes

    def nodes(self, count: int) -> tuple[Light, ...]:  # noqa: ARG002 a light without a size has one
        """Return at most `count` lights without a size whose sum approximates this light with a colour of 1.

        A light without a size returns only itself.
        """
        return (self,)

    def nodes_for(self, sharpness: float) -> int:  # noqa: ARG002 the same for all lobes
        """Return the number of nodes that approximate the light, given the sharpness of a reflectance.

        `Reflectance.sharpness` defines the sharpness.
        """
        return NODES

    @property
    def bands(self) -> int:
        """Number of bands of spherical harmonics of an environment; 0 for other lights."""
        return 0

    def error_without_bands(self, form: CosinePower, bands: int) -> float:  # noqa: ARG002 it has none
        """Return a bound on the error of reflected light if only the first bands of an environment are used.

        The environment has intensity 1. For lights that are no environment, the result is 0.

        Parameters
        ----------
        form : CosinePower
            The lobe that reflects the light.
        bands : int
            Number of bands that are used. If these are all bands of the environment's expansion, the result is a bound
            on the error of the expansion itself.
        """
        return 0.0

    def tints(self, bands: int | None = None) -> tuple[tuple[Vector, Light], ...]:  # noqa: ARG002 it has none
        """Split the light into lights with one colour each. Such lights have closed forms.

        Parameters
        ----------
        bands : int, optional
            Number of bands of spherical harmonics to keep, for an environment; by default, all are kept.

        Returns
        -------
        tuple of (color, light)
            The light is the sum of these lights, each multiplied by its colour.
        """
        return (((1.0, 1.0, 1.0), self),)

    def analytic_integral(self, form: CosinePower) -> Integral | None:  # noqa: ARG002 there is none
        """Return the exact integral over the light, weighted by `form`, a power of a cosine; None without a formula.

        `form` is the factor of a lobe, that is, of a part of the surface's reflectance.
        """
        return None

    @property
    def sampling(self) -> Sampling | None:
        """Importance sampling of the light, for rays; None for a light that casts no soft shadows."""
        return None

    def radiance(self, directions: Float64Array) -> FloatArray:  # noqa: ARG002 it has no visible area
        """Return the radiance of an area light at intensity 1, as seen along unit vectors, shape (3, n).

        The result has the shape (3, n), or (3, 1) if the radiance is constant.
        """
        return np.zeros((3, 1))

    # -- conversion to VTK

    def to_pyvista(self, viewer: Any = None) -> pv.Light:
        """Return the light as a new `pyvista.Light`, its floats unrounded.

        If VTK has no such light, the result is the nearest light that VTK has.

        A light in the camera frame becomes a camera light, a headlight becomes a headlight, and any other light becomes
        a scene light. VTK clamps spot exponents to 128 and does not store names of lights.

        Parameters
        ----------
        viewer : Viewer, optional
            The viewer. Its distance from eye to focal point is VTK's unit for a camera light's position; without a
            viewer, this distance is taken as 1.

        Raises
        ------
        ValueError
            If VTK has no similar light.
        """
        return host.answers().to_pyvista(self, viewer)
