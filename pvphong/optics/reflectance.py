"""Base class of reflectances: the share of arriving light that leaves towards the viewer.

A new reflectance is one file in `pvphong/optics/reflectances/` and its entry in `REFLECTANCES` there. That package's
docstring lists the steps that make it public and tested. A reflectance must define its `lobes`, at most three, and the
formula of their `factors`; all other methods have defaults here. Bounds for plans are in `shading/limits.py`, similar
reflectances and VTK's counterparts in `reflectances/likeness.py`. Users pass it as `Material(reflectance=...)`.
`check.field` declares its fields with their checks. A field without a default must accept 1, with which the formula is
compiled in advance.
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
from pvphong.optics.area.sampling import Directions
from pvphong.optics.surface import Surface

Component = Literal["diffuse", "specular"]

WHITE: Vector = (1.0, 1.0, 1.0)


class Geometry(NamedTuple):
    """Arguments of a formula for a vertex and one light: numbers in compiled code, arrays of n in NumPy.

    Vectors have three entries, and are arrays (3, n) or (3, 1) in NumPy.
    """

    n: Any
    """Normal, of any moderate length; zero where there is none."""
    scale: Any
    """1/|n|. It is separate so that the rounding of |n| does not affect signs."""
    n_l: Any
    """Cosine n·l, whose sign is exact."""
    n_v: Any
    """Cosine n·v."""
    l: Any
    """Unit vector to the light; zero where there is none."""
    v: Any
    """Unit vector to the viewer."""
    t: Any
    """Unit tangent orthogonal to n, for reflectances that need it; zero where there is none."""


class AngleBounds(NamedTuple):
    """Bounds on angles between normals, light and viewer over all vertices, in radians."""

    theta: float
    """Least angle from normal to light."""
    phi: float
    """Least angle from normal to viewer."""
    psi: float
    """Greatest angle from light to viewer."""


ANYWHERE = AngleBounds(0.0, 0.0, math.pi)
"""Bounds that hold for any geometry."""


class Peak(NamedTuple):
    """Peak of a highlight: the chord C is 0 there, and the highlight is a function of f = 1 − ½|C|²."""

    square: Callable[[Geometry], Any]
    """Formula of |C|²."""
    chord: Callable[[Any, Any, Any], Any]
    """Function that returns vectors as long as C, for arrays (3, k) or (3, 1) of unit vectors n, l and v."""
    most: Callable[[AngleBounds], float]
    """Function that returns the largest f within bounds on angles."""
    axis: Callable[[Surface], FloatArray] | None
    """Function that returns the unit vectors (3, n), in float64, around which l is sampled; None if h is sampled around
    n."""
    speed: Callable[[float], float] = lambda _: 1.0
    """Bound on the rotation of the highlight's axis per rotation of l or v, for angles between them up to ψ."""


class Lobe(NamedTuple):
    """One part of a reflectance: a factor per vertex, times a constant colour."""

    component: Component
    """Colour of the light and of the material that it multiplies, and the result that it contributes to."""

    takes_albedo: bool
    """True if the albedo multiplies its colour."""

    needs_viewer: bool
    """True if its factor depends on the direction to the viewer."""

    color: Vector = WHITE
    """Factor of its colour."""

    is_own: bool = False
    """True if `color` replaces the material's colour for its component."""

    tint: Callable[[FloatArray, Mapping[str, FloatArray]], FloatArray] | None = None
    """Function of an albedo (3, n) and maps as in `Surface.maps` that returns the factor of the colour, if this is not
    the albedo itself."""


LAMBERT = Lobe("diffuse", takes_albedo=True, needs_viewer=False)
"""The factor max(n·l, 0). If only this lobe is needed, the reflectance's formula is not called."""

HIGHLIGHT = Lobe("specular", takes_albedo=False, needs_viewer=True)


@dataclass(frozen=True)
class Reflectance(ABC):
    """Base class of reflectances.

    Symbols: n the unit normal, l the unit vector to the light, v to the viewer.
    """

    def __post_init__(self) -> None:
        check.fields(self)

    gamma: ClassVar[float] = 1.0
    """Gamma of the picture: the sum of all light is drawn to the power 1/gamma."""

    is_physical: ClassVar[bool] = False
    """True for VTK's physically based branch, where a material has no ambient colour, and a single headlight is at the
    eye."""

    needs: ClassVar[frozenset[str]] = frozenset()
    """Inputs in addition to normals and the viewer: "tangents", as `Geometry.t`."""

    maps: ClassVar[frozenset[str]] = frozenset()
    """Names of fields that may be maps; also "specular", which evaluators multiply."""

    @property
    @abstractmethod
    def lobes(self) -> tuple[Lobe, ...]:
        """Parts of the reflectance."""

    def of(self, material: Any) -> Reflectance:  # noqa: ARG002 for subclasses that use it
        """Return this reflectance with unset fields, such as the shininess, taken from a material."""
        return self

    def over(self, maps: Mapping[str, tuple[float, float]]) -> Reflectance:  # noqa: ARG002 colours are the same
        """Return this reflectance for maps of its fields, given their least and greatest numbers.

        The fields have the greatest numbers. Colours that depend on the fields must be no less than at any vertex.
        """
        return self

    factors: ClassVar[staticmethod[[Any, Geometry, Any], tuple[Any, ...]]]
    """Formula of the lobes' factors, from its `parameters`, the geometry, and its highlight, if it has a `power`.

    The first factor does not depend on the highlight, which is not computed if only the first lobe is needed.

    Factors are 0 without a normal or a light's direction. Evaluators zero lobes that need a viewer where there is none.
    """

    mapped: ClassVar[Any] = None
    """Formula of the `parameters`, from the field that a map gives and the parameters without it; None without maps."""

    peak: ClassVar[Peak | None] = None
    """Peak of its highlight; None if it has no highlight."""

    def power(self, maps: Mapping[str, Any]) -> Power | None:  # noqa: ARG002 it has none
        """Return the power of the cosine around its peak that is its highlight; None for other highlights.

        Parameters
        ----------
        maps : mapping
            Numbers per vertex that replace a field, by field.
        """
        return None

    def parameters(self, maps: Mapping[str, Any]) -> tuple[Any, ...]:  # noqa: ARG002 it has none
        """Return the numbers that its formula reads, at most eight; `maps` as for `power`."""
        return ()

    def directions(self, surface: Surface) -> Directions | None:  # noqa: ARG002 it has no highlight
        """Return an importance sampling of its highlight; None to sample by the cosine.

        The density must be positive in all directions from which the highlight reflects light.
        """
        return None

    @property
    def forms(self) -> tuple[CosinePower | None, ...]:
        """Each lobe's factor as a power of a cosine; None for other factors.

        Powers of a cosine have exact integrals over area lights (`Light.analytic_integral`).
        """
        return tuple(CosinePower("normal", 1.0) if lobe is LAMBERT else None for lobe in self.lobes)

    @property
    def sharpness(self) -> float:
        """The n of a factor that falls off as exp(−½n|C|²) around a peak at C = 0; 0 if there is no such peak."""
        return 0.0
