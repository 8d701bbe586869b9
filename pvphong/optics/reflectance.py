"""Base class of reflectances: the fraction of the arriving light that leaves towards the viewer.

A new reflectance is one file in `pvphong/optics/reflectances/` and its entry in `REFLECTANCES` there. That package's
docstring lists the steps that make it public and tested. Users pass it as `Material(reflectance=...)`.

A reflectance must define its `lobes`, at most three, and the formula of their `factors`; all other methods have
defaults here. Its fields are declared with their checks, by `check.field`. A field without a default must accept 1,
because the formula is compiled in advance with this value.

Bounds for plans are in `shading/limits.py`, similar reflectances and VTK's counterparts in `reflectances/likeness.py`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, NamedTuple

from pvphong.base import check
from pvphong.base.formulas import Power
from pvphong.base.types import FloatArray, Vector
from pvphong.optics.area.lobes import CosinePower
from pvphong.optics.directions import Directions
from pvphong.optics.surface import Surface

Component = Literal["diffuse", "specular"]

WHITE: Vector = (1.0, 1.0, 1.0)


class Geometry(NamedTuple):
    """Input of a reflectance's formula for a vertex and a light: directions and cosines.

    Numbers are floats in compiled code, and arrays (n,) in NumPy. Vectors are tuples of three floats in compiled code,
    and arrays (3, n) or (3, 1) in NumPy.
    """

    n: Any
    """Normal, of any moderate length; zero if the vertex has no normal."""
    scale: Any
    """1/|n|. It is separate so that the rounding of |n| does not affect signs."""
    n_l: Any
    """Cosine n·l, whose sign is exact."""
    n_v: Any
    """Cosine n·v."""
    l: Any
    """Unit vector to the light; zero if the direction is undefined."""
    v: Any
    """Unit vector to the viewer."""
    t: Any
    """Unit tangent orthogonal to n, for reflectances that need it; zero if the vertex has no tangent."""


class AngleBounds(NamedTuple):
    """Bounds on the angles between normal, light and viewer that hold at all vertices, in radians."""

    theta: float
    """Least angle from normal to light."""
    phi: float
    """Least angle from normal to viewer."""
    psi: float
    """Greatest angle from light to viewer."""


ANYWHERE = AngleBounds(0.0, 0.0, math.pi)
"""Bounds that hold for any geometry."""


class Peak(NamedTuple):
    """Peak of a highlight, described by a chord C: the difference of two unit vectors that are equal at the peak.

    For Phong's highlight, these are the mirror direction and the direction to the viewer. The highlight is a function
    of f = 1 − ½|C|², the cosine of the angle between them.
    """

    square: Callable[[Geometry], Any]
    """Formula of the squared chord |C|² for a `Geometry`."""
    chord: Callable[[Any, Any, Any], Any]
    """Function of arrays (3, k) or (3, 1) of unit vectors n, l and v that returns vectors with the length of C."""
    most: Callable[[AngleBounds], float]
    """Function that returns the largest f that bounds on angles allow."""
    axis: Callable[[Surface], FloatArray] | None
    """Function that returns the unit vectors, shape (3, n), float64, around which l is sampled; None if instead the
    half-way direction h is sampled around n."""
    speed: Callable[[float], float] = lambda _: 1.0
    """Function of the largest angle ψ between l and v. It returns a bound on the rotation of the highlight's axis,
    divided by the rotation of l or v."""


class Lobe(NamedTuple):
    """One part of a reflectance: a factor per vertex, times a constant colour."""

    component: Component
    """Selects the colours of the light and of the material that multiply the lobe's factor, and the result to which the
    lobe is added."""

    takes_albedo: bool
    """True if the albedo multiplies the lobe's colour."""

    needs_viewer: bool
    """True if the lobe's factor depends on the direction to the viewer."""

    color: Vector = WHITE
    """Constant factor of the lobe's colour."""

    is_own: bool = False
    """True if `color` replaces the material's colour for this component."""

    tint: Callable[[FloatArray, Mapping[str, FloatArray]], FloatArray] | None = None
    """Function of an albedo, shape (3, n), and of maps as in `Surface.maps`. It returns the factor that multiplies the
    colour in place of the albedo. None if the factor is the albedo itself."""


LAMBERT = Lobe("diffuse", takes_albedo=True, needs_viewer=False)
"""Lobe with the factor max(n·l, 0). If only this lobe is needed, the reflectance's formula is not called."""

HIGHLIGHT = Lobe("specular", takes_albedo=False, needs_viewer=True)


@dataclass(frozen=True)
class Reflectance(ABC):
    """Base class of reflectances.

    Symbols: n the unit normal, l the unit vector to the light, v to the viewer.
    """

    def __post_init__(self) -> None:
        check.fields(self)

    gamma: ClassVar[float] = 1.0
    """Gamma of the picture: the sum of all light is raised to the power 1/gamma."""

    is_physical: ClassVar[bool] = False
    """True for VTK's physically based shader, where a material has no ambient colour, and a single headlight is at the
    eye."""

    needs: ClassVar[frozenset[str]] = frozenset()
    """Inputs that the reflectance needs in addition to normals and the viewer: "tangents" for `Geometry.t`."""

    maps: ClassVar[frozenset[str]] = frozenset()
    """Names of the fields that may be maps. The name "specular" means the material's field `specular`: evaluators
    multiply the specular lobes by its map."""

    @property
    @abstractmethod
    def lobes(self) -> tuple[Lobe, ...]:
        """Parts of the reflectance, at most three, in the order of the factors that its formula returns."""

    def of(self, material: Any) -> Reflectance:  # noqa: ARG002 for subclasses that use it
        """Return this reflectance with its unset fields, such as a shininess of None, set to those of a material."""
        return self

    def over(self, maps: Mapping[str, tuple[float, float]]) -> Reflectance:  # noqa: ARG002 colours are the same
        """Return a reflectance whose lobes' colours are at least as bright as the colours at any vertex.

        A reflectance overrides this method if one of its fields may be a map and changes the colours. The method is
        called on a copy of the reflectance in which each field with a map is set to the map's greatest number.

        Parameters
        ----------
        maps : mapping
            Name of each field that is a map → the map's least and greatest number.
        """
        return self

    factors: ClassVar[staticmethod[[Any, Geometry, Any], tuple[Any, ...]]]
    """Formula that returns the factor of each lobe. It has three arguments: the reflectance's `parameters`, the
    geometry, and the highlight. The highlight is the `power` of the cosine around the peak, if the reflectance has a
    `power`.

    The first factor must not depend on the highlight, because the highlight is not computed if only the first lobe is
    needed.

    Factors must be 0 if n or l is zero. Evaluators set lobes that need a viewer to 0 where v is undefined.
    """

    mapped: ClassVar[Any] = None
    """Formula that returns the `parameters` if a field is a map. Its arguments are the field's number at a vertex, and
    the parameters without the map. None if no field may be a map."""

    peak: ClassVar[Peak | None] = None
    """Peak of the highlight; None if the reflectance has no highlight."""

    def power(self, maps: Mapping[str, Any]) -> Power | None:  # noqa: ARG002 it has none
        """Return the highlight as a power of the cosine around its peak; None if there is no such highlight.

        Parameters
        ----------
        maps : mapping
            Name of a field → numbers per vertex, shape (n,), which replace the field.
        """
        return None

    def parameters(self, maps: Mapping[str, Any]) -> tuple[Any, ...]:  # noqa: ARG002 it has none
        """Return the numbers that the reflectance's formula reads, at most eight.

        Parameters
        ----------
        maps : mapping
            Name of a field → numbers per vertex, shape (n,), which replace the field.
        """
        return ()

    def directions(self, surface: Surface) -> Directions | None:  # noqa: ARG002 it has no highlight
        """Return an importance sampling of the light that the highlight reflects at the vertices of a block.

        None means that directions are sampled by the cosine to the normal. The density must be positive in all
        directions from which the highlight reflects light.
        """
        return None

    @property
    def forms(self) -> tuple[CosinePower | None, ...]:
        """For each lobe, its factor as a power of a cosine; None for a lobe whose factor has another form.

        Powers of a cosine have exact integrals over area lights (`Light.analytic_integral`).
        """
        return tuple(CosinePower("normal", 1.0) if lobe is LAMBERT else None for lobe in self.lobes)

    @property
    def sharpness(self) -> float:
        """Number n for which the highlight is about exp(−½n|C|²) near its peak; 0 if it has no peak.

        C is the chord to the peak, as for `Peak`.
        """
        return 0.0
