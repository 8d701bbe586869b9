"""What every reflectance is: how much of the light that arrives leaves towards the viewer.

A new reflectance is one file in `pvphong/optics/reflectances/` and its entry in `REFLECTANCES` there; what makes it
public and tested is said there. It must say its `lobes`, at most three, and the formula of their `factors`; everything
else has an answer here. Bounds for plans are in `shading/limits.py`, similar reflectances and VTK's counterparts in
`reflectances/likeness.py`. Users give it as `Material(reflectance=...)`. Its fields are
declared with their checks, by `check.field`; one without a default takes a 1, with which its formula is compiled in
advance.
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
    """What a formula is given of a vertex and of one light: numbers in compiled code, arrays of n in NumPy.

    Vectors have three entries, and are arrays (3, n) or (3, 1) in NumPy.
    """

    n: Any
    """The normal, of any moderate length; zero where there is none."""
    scale: Any
    """1/|n|. What |n| is rounded to should not matter, so unit normals are not given."""
    n_l: Any
    """The cosine n·l, whose sign is exact."""
    n_v: Any
    """The cosine n·v."""
    l: Any
    """Unit vector to the light; zero where there is none."""
    v: Any
    """Unit vector to the viewer."""
    t: Any
    """Unit tangent across n, for reflectances that need it; zero where there is none."""


class Sightline(NamedTuple):
    """Bounds on angles over all vertices, in radians: what is known of where light, viewer and normals are."""

    theta: float
    """The least from normal to light."""
    phi: float
    """The least from normal to viewer."""
    psi: float
    """The greatest from light to viewer."""


ANYWHERE = Sightline(0.0, 0.0, math.pi)
"""Nothing is known."""


class Peak(NamedTuple):
    """Where a highlight is brightest: the chord C is 0 there, and the highlight a function of f = 1 − ½|C|²."""

    square: Callable[[Geometry], Any]
    """Formula of |C|²."""
    chord: Callable[[Any, Any, Any], Any]
    """Gives vectors as long as C, for arrays (3, k) or (3, 1) of unit vectors n, l and v."""
    most: Callable[[Sightline], float]
    """The largest f for vertices of which bounds are known."""
    axis: Callable[[Surface], FloatArray] | None
    """Gives the unit vectors (3, n), in float64, around which l is; None where h is around n."""
    speed: Callable[[float], float] = lambda _: 1.0
    """How many times as far as l or v, whose angle is at most ψ, the direction around which f is a cosine turns."""


class Lobe(NamedTuple):
    """One part of a reflectance: a factor at each vertex, times a colour that is the same for all."""

    component: Component
    """Which of the light's and the material's colours it takes, and which of the results it counts to."""

    takes_albedo: bool
    """Whether its colour is multiplied by the albedo."""

    needs_viewer: bool
    """Whether its factor depends on the direction to the viewer."""

    color: Vector = WHITE
    """What its colour is multiplied by."""

    is_own: bool = False
    """Whether `color` replaces the material's colour for its component."""

    tint: Callable[[FloatArray, Mapping[str, FloatArray]], FloatArray] | None = None
    """Gives what the colour is multiplied by for an albedo (3, n) and maps as in `Surface.maps`, where that is not the
    albedo itself."""


LAMBERT = Lobe("diffuse", takes_albedo=True, needs_viewer=False)
"""The factor max(n·l, 0); where no more is wanted of a reflectance, its formula is not called."""

HIGHLIGHT = Lobe("specular", takes_albedo=False, needs_viewer=True)


@dataclass(frozen=True)
class Reflectance(ABC):
    """How a surface reflects.

    Symbols: n the unit normal, l the unit vector to the light, v to the viewer.
    """

    def __post_init__(self) -> None:
        check.fields(self)

    gamma: ClassVar[float] = 1.0
    """What is drawn is the sum of all light to the power 1/gamma."""

    is_physical: ClassVar[bool] = False
    """Whether it is of VTK's physically based branch, where a material has no ambient colour, and a headlight alone
    is at the eye."""

    needs: ClassVar[frozenset[str]] = frozenset()
    """What it reads beside normals and the viewer: "tangents", as `Geometry.t`."""

    maps: ClassVar[frozenset[str]] = frozenset()
    """What may be given vertex by vertex: "specular", which evaluators multiply, or a field."""

    @property
    @abstractmethod
    def lobes(self) -> tuple[Lobe, ...]:
        """Its parts."""

    def of(self, material: Any) -> Reflectance:  # noqa: ARG002 for those that take something
        """This reflectance with what it takes of a material, such as a shininess where it has none of its own."""
        return self

    def over(self, maps: Mapping[str, tuple[float, float]]) -> Reflectance:  # noqa: ARG002 colours are the same
        """This reflectance for maps of its fields, whose least and greatest numbers are given.

        Its fields have the greatest; what of its colours depends on them is to be no less than at any vertex.
        """
        return self

    factors: ClassVar[staticmethod[[Any, Geometry, Any], tuple[Any, ...]]]
    """Formula of the lobes' factors: of its `parameters`, of the geometry, and of its highlight, if it has a `power`.

    The first lobe's does not depend on the highlight, which is not computed where only that one is wanted.

    Without a normal or a light's direction they are 0; evaluators take away what needs a viewer where there is none.
    """

    mapped: ClassVar[Any] = None
    """Formula of the `parameters`, of the field that a map gives and of what they are without it; None if none may."""

    peak: ClassVar[Peak | None] = None
    """Where its highlight is; None if it has none."""

    def power(self, maps: Mapping[str, Any]) -> Power | None:  # noqa: ARG002 it has none
        """The power that its highlight is, around its peak; None if it is something else.

        Parameters
        ----------
        maps : mapping
            Field → numbers of each vertex that replace it.
        """
        return None

    def parameters(self, maps: Mapping[str, Any]) -> tuple[Any, ...]:  # noqa: ARG002 it has none
        """The numbers that its formula reads, at most eight; with `maps` as for `power`."""
        return ()

    def directions(self, surface: Surface) -> Directions | None:  # noqa: ARG002 it has no highlight
        """How directions of light are chosen that its highlight reflects much of; None: by the cosine, as for others.

        All that the highlight reflects from must have a chance.
        """
        return None

    @property
    def forms(self) -> tuple[CosinePower | None, ...]:
        """Each lobe's factor as a power of a cosine; None where it is something else.

        For such there are exact integrals over lights with a size (`Light.closed`).
        """
        return tuple(CosinePower("normal", 1.0) if lobe is LAMBERT else None for lobe in self.lobes)

    @property
    def sharpness(self) -> float:
        """The n of a factor that falls off as exp(−½n|C|²) around a peak at C = 0; 0 where there is no such peak."""
        return 0.0
