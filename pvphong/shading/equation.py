"""The lighting equation of one scene and one material, with everything in place but the vertices.

It is the same kind of value for both conventions: `assembly` makes it, and the evaluators know nothing of conventions.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import accumulate
from types import MappingProxyType

from pvphong.base.types import Float64Array, Vector
from pvphong.optics.area.lobes import CosinePower
from pvphong.optics.light import Light
from pvphong.optics.reflectance import Component, Reflectance

BLACK: Vector = (0.0, 0.0, 0.0)

NO_MAPS: Mapping[str, tuple[float, float]] = MappingProxyType({})


@dataclass(frozen=True)
class LightTerm:
    """One light that is on, in world coordinates.

    Parameters
    ----------
    light : Light
        Where it stands and how it weakens.
    index : int
        Its place among the scene's lights.
    label : str
        What names it to people.
    rides : bool
        Whether it moves with the viewer.
    ambient : tuple of float
        Its ambient colour times intensity times the material's, divided by `gain`: at most 1.
    colors : tuple of tuple of float
        The same for each lobe of the equation's reflectance.
    gain : float
        What the colours are to be multiplied by; it may be beyond float32's range, as where a light is bright because
        it is far away.
    is_shadowed : bool
        Whether what its lobes add is multiplied by the part of it that a vertex sees.
    bands : int, optional
        How many of its light's bands are kept; all if not given.
    nodes : tuple of Light, optional
        What stands in for its light's nodes where there is no closed form.
    """

    light: Light
    index: int
    label: str
    rides: bool
    ambient: Vector
    colors: tuple[Vector, ...]
    gain: float
    is_shadowed: bool = False
    bands: int | None = None
    nodes: tuple[Light, ...] | None = None

    @cached_property
    def shines(self) -> tuple[bool, ...]:
        """Whether it adds anything by each lobe."""
        return tuple(map(any, self.colors))

    @property
    def needs_normals(self) -> bool:
        """Whether its share depends on the normal."""
        return True in self.shines

    @property
    def is_black(self) -> bool:
        """Whether it adds nothing anywhere: its colours, its intensity or the material's are 0."""
        return not (True in self.shines or any(self.ambient))


@dataclass(frozen=True)
class Equation:
    """What every evaluator takes.

    Parameters
    ----------
    terms : tuple of LightTerm
        The lights that are on.
    off : tuple of str
        The labels of those that are off.
    lights : int
        How many the scene has, on or off.
    ambient, emission : tuple of float
        What is there without any light; `ambient` is multiplied by the albedo.
    reflectance : Reflectance
        How the surface reflects.
    eye : tuple of float or None
        The viewer's position where v is taken at each vertex, else None.
    to_eye : tuple of float
        Unit vector towards the eye along the view axis.
    two_sided : bool
        Whether vertices that face away from the viewer are lit with −n.
    local_facing : bool
        Whether that is judged from `eye`, rather than along `to_eye`.
    clamp : bool
        Whether the sum is clamped to [0, 1].
    matrix : ndarray or None
        (4, 4) model matrix, float64 and read-only; None for the identity.
    turns_normals : bool
        Whether the matrix changes the directions of normals.
    is_occluded : bool
        Whether ambient light, the light model's and the lights', is multiplied by the open part of the sky.
    maps : mapping
        What stands vertex by vertex in place of the reflectance's field of that name, or is multiplied with specular
        colours → its least and its greatest.
    gamma : float
        The sum of all light is raised to 1/gamma before it is clamped.
    """

    terms: tuple[LightTerm, ...]
    off: tuple[str, ...]
    lights: int
    ambient: Vector
    emission: Vector
    reflectance: Reflectance
    eye: Vector | None
    to_eye: Vector
    two_sided: bool
    local_facing: bool
    clamp: bool
    matrix: Float64Array | None
    turns_normals: bool
    is_occluded: bool = False
    gamma: float = 1.0
    maps: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @cached_property
    def extremes(self) -> tuple[Reflectance, ...]:
        """What the reflectance may be at a vertex: those with the greatest bounds; see `Reflectance.extremes`."""
        found: tuple[Reflectance, ...] = (self.reflectance,)
        for name, (low, high) in self.fields_with_maps.items():
            found = tuple(extreme for each in found for extreme in each.extremes(name, low, high))
        return found

    @property
    def fields_with_maps(self) -> dict[str, tuple[float, float]]:
        """Fields of the reflectance that are given vertex by vertex, as in `maps`."""
        return {name: ends for name, ends in self.maps.items() if name != "specular"}

    @cached_property
    def largest(self) -> tuple[float, ...]:
        """The largest factor of each lobe at any vertex."""
        return tuple(max(each.most(k) for each in self.extremes) for k in range(len(self.reflectance.lobes)))

    @property
    def forms(self) -> tuple[CosinePower | None, ...]:
        """As the reflectance's; None where they are not the same at all vertices."""
        forms, diffuse = self.reflectance.forms, self.lobes_of("diffuse")
        return tuple(form if k in diffuse else None for k, form in enumerate(forms)) if self.fields_with_maps else forms

    @cached_property
    def needs_normals(self) -> bool:
        """Whether any light's share depends on the normal."""
        return any(term.needs_normals for term in self.terms)

    @cached_property
    def has_highlights(self) -> bool:
        """Whether any light's share depends on the viewer through v."""
        return any(map(self.needs_viewer, self.terms))

    def needs_viewer(self, term: LightTerm) -> bool:
        """Whether a light's share depends on the viewer through v."""
        return any(map(term.shines.__getitem__, self._seen_lobes))

    @cached_property
    def _seen_lobes(self) -> list[int]:
        return [k for k, lobe in enumerate(self.reflectance.lobes) if lobe.needs_viewer]

    def lobes_of(self, component: Component) -> list[int]:
        """Indices of the reflectance's lobes that count to a component."""
        return self._lobes[component]

    @cached_property
    def _lobes(self) -> dict[Component, list[int]]:
        lobes = [lobe.component for lobe in self.reflectance.lobes]
        components: tuple[Component, ...] = ("diffuse", "specular")
        return {component: [k for k, of in enumerate(lobes) if of == component] for component in components}

    def has(self, term: LightTerm, component: Component) -> bool:
        """Whether a light adds to a component."""
        return any(map(term.shines.__getitem__, self._lobes[component]))

    def without(self, term: LightTerm, component: Component) -> LightTerm:
        """A light's term that adds nothing to a component."""
        gone = self.lobes_of(component)
        return replace(term, colors=tuple(BLACK if k in gone else color for k, color in enumerate(term.colors)))

    @property
    def is_flipped(self) -> bool:
        """Whether normals are turned to the viewer."""
        return self.two_sided and self.needs_normals

    @cached_property
    def shadowed(self) -> tuple[int, ...]:
        """Places among the scene's lights of those that a vertex may not see all of."""
        return tuple(sorted({term.index for term in self.terms if term.is_shadowed}))

    @property
    def needs_tangents(self) -> bool:
        """Whether any light's share depends on the tangent."""
        return self.needs_normals and "tangents" in self.reflectance.needs

    @cached_property
    def channels(self) -> dict[str, slice]:
        """Which rows of `Vertices.channels` hold what, of what is read of them.

        Of "visibility" there is one for what is seen of each of the scene's lights, and one for the sky; "tangents" are
        x, y and z, and the maps have their names.
        """
        sizes = {"visibility": self.lights + 1} if self.needs_visibility else {}
        if self.needs_tangents:
            sizes["tangents"] = 3
        if self.needs_normals:
            sizes |= {name: 3 if name == "specular" else 1 for name in self.maps}
        ends = accumulate(sizes.values())
        return {kind: slice(end - size, end) for (kind, size), end in zip(sizes.items(), ends, strict=True)}

    @property
    def needs_visibility(self) -> bool:
        """Whether any share depends on what a vertex sees of a light or of the sky."""
        return self.is_occluded or any(term.is_shadowed for term in self.terms)

    @cached_property
    def needs_eye(self) -> bool:
        """Whether v is taken at each vertex, for highlights or for turning normals."""
        return self.eye is not None and (self.has_highlights or (self.is_flipped and self.local_facing))

    @cached_property
    def needs_points(self) -> bool:
        """Whether any share depends on where the vertex is."""
        return self.needs_eye or any(not term.light.is_even for term in self.terms)
