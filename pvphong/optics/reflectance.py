"""What every reflectance is: how much of the light that arrives leaves towards the viewer.

A new reflectance is one file in `pvphong/optics/reflectances/` and its entry in `REFLECTANCES` there; what makes it
public and tested is said there. It must say its `lobes`, at most three of them if it has a `stage`, their `factors`,
and how much these `change`; everything else has an answer here. Users give it as `Material(reflectance=...)`; without
a `stage` it is evaluated in NumPy. A field without a default takes a 1, with which its stage is compiled in advance.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal, NamedTuple, Self

from pvphong.base.types import FloatArray, Vector
from pvphong.optics.light import Arrival
from pvphong.optics.spherical import CosinePower
from pvphong.optics.surface import Surface

Component = Literal["diffuse", "specular"]

WHITE: Vector = (1.0, 1.0, 1.0)


class Lobe(NamedTuple):
    """One part of a reflectance: a factor at each vertex, times a colour that is the same for all."""

    component: Component
    """Which of the light's and the material's colours it takes, and which of the results it counts to."""

    takes_albedo: bool
    """Whether its colour is multiplied by the albedo."""

    needs_viewer: bool
    """Whether its factor depends on the direction to the viewer."""

    largest: float = 1.0
    """The factor is never more."""

    color: Vector = WHITE
    """What its colour is multiplied by."""

    is_own: bool = False
    """Whether `color` stands in place of the material's colour for its component."""

    tint: Callable[[FloatArray], FloatArray] | None = None
    """Gives what the colour is multiplied by for an albedo (3, n), where that is not the albedo itself."""


class VtkSurface(NamedTuple):
    """What VTK keeps of a surface that it shades physically based."""

    metallic: float
    roughness: float


class Sightline(NamedTuple):
    """Bounds on angles over all vertices, in radians: what is known of where light, viewer and normals are."""

    theta: float
    """The least from normal to light."""
    phi: float
    """The least from normal to viewer."""
    psi: float
    """The greatest from light to viewer."""


@dataclass(frozen=True)
class Reflectance(ABC):
    """How a surface reflects.

    Symbols: n the unit normal, l the unit vector to the light, v to the viewer.
    """

    gamma: ClassVar[float] = 1.0
    """What is drawn is the sum of all light to the power 1/gamma."""

    is_physical: ClassVar[bool] = False
    """Whether it is of VTK's physically based branch, where a material has no ambient colour, and a headlight alone
    stands at the eye."""

    needs: ClassVar[frozenset[str]] = frozenset()
    """What it reads beside normals and the viewer: "tangents", in `Surface.tangents` and the rows `TX`, `TY`, `TZ`."""

    maps: ClassVar[frozenset[str]] = frozenset()
    """What may be given vertex by vertex: "specular", which evaluators multiply, or a field, in `Surface.given`."""

    counterpart: ClassVar[tuple[str, float] | None] = None
    """Name of another one that looks much the same, and how many times the shininess it needs for that."""

    @property
    @abstractmethod
    def lobes(self) -> tuple[Lobe, ...]:
        """Its parts."""

    def of(self, material: Any) -> Reflectance:  # noqa: ARG002 for those that take something
        """This reflectance with what it takes of a material, such as a shininess where it has none of its own."""
        return self

    def stand_in(self, material: Any) -> tuple[str, Any] | None:  # noqa: ARG002 nothing is simpler
        """What a cheaper reflection in its place is called, and a material that looks much the same with it."""
        return None

    def in_vtk(self) -> Reflectance | None:
        """What VTK's shader makes of it; None where VTK has no such."""
        return None

    def as_vtk(self) -> VtkSurface | None:
        """The values of the property by which VTK's shader makes that; None where VTK has no such."""
        return None

    @abstractmethod
    def factors(self, surface: Surface, arrival: Arrival, wanted: Sequence[bool]) -> tuple[Any, ...]:
        """Factor of each lobe at n vertices, a new array (n,); of a lobe that is not wanted anything.

        A vertex without a normal or without a light's direction gets 0; the evaluator takes away what needs a viewer
        where there is none.
        """

    @abstractmethod
    def change(self, lobe: int, turn: float, psi: float, *, light_moves: bool) -> float:
        """The largest change of a lobe's factor when l or v turns by `turn` radians, for any normal.

        Parameters
        ----------
        lobe : int
            Its index.
        turn : float
            In radians.
        psi : float
            The greatest angle from light to viewer before the turn.
        light_moves : bool
            Whether l turns, rather than v.
        """

    def most(self, lobe: int, sightline: Sightline) -> float:  # noqa: ARG002 nothing better is known
        """The largest factor of a lobe for vertices of which bounds are known."""
        return self.lobes[lobe].largest

    def extremes(self, field: str, low: float, high: float) -> tuple[Self, ...]:
        """Of all with a field from `low` to `high`, some of which `change` adds up to no less than any other's.

        One of them also has the largest factor of each lobe.
        """
        return replace(self, **{field: low}), replace(self, **{field: high})

    def parameters(self) -> tuple[float, ...]:
        """The numbers that its stage reads."""
        return ()

    def stage(self, toolkit: Any, wanted: Sequence[bool]) -> Callable[..., Any] | None:  # noqa: ARG002 it has none
        """What compiled code runs for it, written with the names of `pvphong.shading.kernel.toolkit`.

        It is a function (numbers, rows, points) → int that writes the factors of a block of vertices into the rows
        `FIRST`, `SECOND` and `THIRD`, one for each lobe that is wanted. It gives the lobes that are not 0 everywhere:
        the sum of 1, 2 and 4. What it closes over may be the toolkit and integers. None where the readable
        evaluator is to do it.
        """
        return None

    @property
    def forms(self) -> tuple[CosinePower | None, ...]:
        """Of each lobe, its factor as a power of a cosine; None where it is something else.

        For such there are exact integrals over lights with a size (`Light.closed`).
        """
        return (None,) * len(self.lobes)

    @property
    def sharpness(self) -> float:
        """The n of a factor that falls off as exp(−½n|C|²) around a peak at C = 0; 0 where there is no such peak."""
        return 0.0

    def chords(self, n: FloatArray, l: FloatArray, v: FloatArray) -> FloatArray:
        """Vectors C, shape (3, k), that are 0 at the factor's peak; for a `sharpness` above 0."""
        raise NotImplementedError(f"{type(self).__name__} has no peak")  # pragma: no cover a contract's other half
