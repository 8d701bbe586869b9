"""The lighting equation of one scene and one material, independent of the vertices.

`assemble` builds the equation. Only this module distinguishes the two conventions: `standard` is the model of OpenGL
and its textbooks, `vtk` follows VTK's shader (vtkOpenGLPolyDataMapper::ReplaceShaderLight). `relative_to_mesh` moves
the origin to the mesh if a matrix translates the mesh very far. `in_parts` splits an area light into the forms that
evaluators run: exact integrals, and nodes (small lights at points of the area light). A reflectance is a sum of lobes,
such as a diffuse one and a highlight. A component is "ambient", "diffuse", "specular" or "emission". A tint is a map of
colours: a colour per vertex that replaces a field of the material.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from itertools import accumulate, groupby
from types import MappingProxyType
from typing import Any, Literal, NamedTuple, cast

import numpy as np

from pvphong.base import check
from pvphong.base.formulas import BRIGHTEST, FARTHEST, add
from pvphong.base.types import ColorLike, Float64Array, FloatArray, MatrixLike, Vector, VectorLike, rgb
from pvphong.optics.area.lobes import CosinePower
from pvphong.optics.light import Light
from pvphong.optics.lights import light_from_homogeneous, light_from_values, refuse_unless_in_vtk, vtk_values
from pvphong.optics.material import Material, nearest_in_vtk
from pvphong.optics.reflectance import WHITE, Component, Lobe, Reflectance
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.optics.reflectances.likeness import in_vtk
from pvphong.optics.reflectances.vtk import HIGHEST_POWER, vtk_reflectance
from pvphong.scene.scene import Scene, light_labels
from pvphong.shading.limits import extremes, most

BLACK: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class LightTerm:
    """One light that is on, in world coordinates.

    Parameters
    ----------
    light : Light
        The light. `ambient`, `colors` and `gain` have its colours and intensity; the rest is read from it.
    index : int
        Its index among the scene's lights.
    label : str
        Its name in messages and results.
    follows_viewer : bool
        True if it moves with the viewer.
    ambient : tuple of float
        The light's ambient colour times its intensity times the material's ambient colour, divided by `gain`; it is at
        most 1.
    colors : tuple of tuple of float
        For each lobe of the equation's reflectance: the light's colour times its intensity times the material's colour
        for the lobe, divided by `gain`; at most 1.
    gain : float
        Factor that multiplies the colours. It may exceed float32's range, for example if a light is very bright because
        it is far away.
    is_shadowed : bool
        True if the visible part of the light multiplies the lobes' contributions.
    bands : int, optional
        Number of the light's bands of spherical harmonics that are kept; all by default.
    nodes : tuple of Light, optional
        For an area light, small lights whose sum replaces it, for lobes whose integral has no closed form. By default,
        the light's own nodes.
    """

    light: Light
    index: int
    label: str
    follows_viewer: bool
    ambient: Vector
    colors: tuple[Vector, ...]
    gain: float
    is_shadowed: bool = False
    bands: int | None = None
    nodes: tuple[Light, ...] | None = None

    @cached_property
    def shines(self) -> tuple[bool, ...]:
        """A flag for each lobe of the reflectance: True if the light contributes to the lobe."""
        return tuple(map(any, self.colors))

    @property
    def needs_normals(self) -> bool:
        """True if the light's contribution depends on the normal."""
        return True in self.shines

    @property
    def is_black(self) -> bool:
        """True if the light contributes nothing: its colours, its intensity or the material's colours are 0."""
        return not (True in self.shines or any(self.ambient))


@dataclass(frozen=True)
class Equation:
    """Lighting equation, the input of every evaluator.

    Parameters
    ----------
    terms : tuple of LightTerm
        The lights that are on.
    off : tuple of str
        Labels of the lights that are off.
    unblocked : tuple of str
        Labels of the lights that are on and cast no shadows, although the light model has shadows.
    lights : int
        Number of the scene's lights, on or off.
    ambient, emission : tuple of float
        Ambient light of the light model, and emission. The albedo multiplies `ambient`.
    reflectance : Reflectance
        Reflectance of the surface.
    eye : tuple of float or None
        Viewer's position; None if the unit vector v to the viewer is the same for all vertices.
    to_eye : tuple of float
        Unit vector towards the eye along the view axis.
    two_sided : bool
        True if vertices that face away from the viewer are lit with −n.
    local_facing : bool
        True if the position `eye` determines which side of a vertex the viewer sees, False if `to_eye` does.
    clamp : bool
        True if the sum is clamped to [0, 1].
    matrix : ndarray or None
        (4, 4) model matrix, float64 and read-only; None for the identity.
    turns_normals : bool
        True if the matrix changes the directions of normals.
    is_occluded : bool
        True if the visible part of the sky multiplies the ambient light of the light model and of the lights.
    maps : mapping
        For each field of the reflectance that has a map (a number per vertex): the least and the greatest number.
    tints : frozenset of str
        Names of the fields that have a map of colours: some of "albedo", "diffuse", "specular" and "emission".
    gamma : float
        The sum of all light is raised to 1/gamma before it is clamped.
    bounces : int
        Number of bounces from surface to surface.
    colors : tuple of tuple of float
        Material colour per lobe, applied to incident light of unit radiance.
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
    unblocked: tuple[str, ...] = ()
    is_occluded: bool = False
    gamma: float = 1.0
    bounces: int = 0
    maps: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    tints: frozenset[str] = frozenset()
    colors: tuple[Vector, ...] = ()

    @cached_property
    def extremes(self) -> tuple[Reflectance, ...]:
        """A few reflectances whose bounds hold for the reflectance of every vertex; see `limits.extremes`."""
        found: tuple[Reflectance, ...] = (self.reflectance,)
        for name, (low, high) in self.maps.items():
            found = tuple(extreme for each in found for extreme in extremes(each, name, low, high))
        return found

    @cached_property
    def largest(self) -> tuple[float, ...]:
        """Largest factor of each lobe at any vertex."""
        return tuple(max(most(each, k) for each in self.extremes) for k in range(len(self.reflectance.lobes)))

    @cached_property
    def sharpness(self) -> float:
        """Greatest sharpness of the reflectance at any vertex; a sharper reflectance has narrower highlights."""
        return max(each.sharpness for each in self.extremes)

    @property
    def forms(self) -> tuple[CosinePower | None, ...]:
        """The power of a cosine that each lobe equals, for lobes whose integral over an area light has a closed form.

        Other lobes have None. If a map varies, only diffuse lobes have a closed form.
        """
        forms, diffuse = self.reflectance.forms, self.lobes_of["diffuse"]
        varies = any(least < most for least, most in self.maps.values())
        return tuple(form if k in diffuse else None for k, form in enumerate(forms)) if varies else forms

    @cached_property
    def needs_normals(self) -> bool:
        """True if colours depend on the normal: by a light, or because the sky is partly hidden on both sides."""
        return any(term.needs_normals for term in self.terms) or (self.two_sided and self.is_occluded)

    @cached_property
    def has_highlights(self) -> bool:
        """True if any light's contribution depends on the unit vector v to the viewer."""
        return any(map(self.needs_viewer, self.terms))

    def needs_viewer(self, term: LightTerm) -> bool:
        """Return True if the contribution of a term's light depends on the unit vector v to the viewer."""
        pairs = zip(term.shines, self.reflectance.lobes, strict=True)
        return any(shines and lobe.needs_viewer for shines, lobe in pairs)

    @property
    def diffuse_needs_viewer(self) -> bool:
        """True if diffuse reflection depends on the viewer."""
        return any(self.reflectance.lobes[k].needs_viewer for k in self.lobes_of["diffuse"])

    @cached_property
    def lobes_of(self) -> dict[Component, list[int]]:
        """Component ("diffuse" or "specular") → indices of the reflectance's lobes that belong to it."""
        lobes = [lobe.component for lobe in self.reflectance.lobes]
        components: tuple[Component, ...] = ("diffuse", "specular")
        return {component: [k for k, of in enumerate(lobes) if of == component] for component in components}

    def has(self, term: LightTerm, component: Component) -> bool:
        """Return True if a term's light contributes to a component, "diffuse" or "specular"."""
        return any(map(term.shines.__getitem__, self.lobes_of[component]))

    def without(self, term: LightTerm, component: Component) -> LightTerm:
        """Return a term without its light's contribution to a component, "diffuse" or "specular"."""
        gone = self.lobes_of[component]
        return replace(term, colors=tuple(BLACK if k in gone else color for k, color in enumerate(term.colors)))

    @property
    def shares(self) -> list[Share]:
        """Parts of the colour whose sum is the colour before gamma and clamping. Black parts are left out.

        Emission and the light model's ambient light come first, then the lights in order.
        """
        lobes, index = self.reflectance.lobes, operator.attrgetter("index")
        dark = tuple(BLACK for _ in lobes)
        shares = [Share("emission", None, ())] * any(self.emission) + [Share("ambient", None, ())] * any(self.ambient)
        for light, group in groupby(sorted(self.terms, key=index), index):
            terms = tuple(group)
            of: dict[Component | Literal["ambient"], list[LightTerm]] = {
                "ambient": [replace(term, colors=dark) for term in terms],
                "diffuse": [replace(self.without(term, "specular"), ambient=BLACK) for term in terms],
                "specular": [replace(self.without(term, "diffuse"), ambient=BLACK) for term in terms],
            }
            for component, own in of.items():
                lit = tuple(term for term in own if not term.is_black)
                shares += [Share(component, light, lit)] * bool(lit)
        return shares

    @property
    def is_flipped(self) -> bool:
        """True if normals are turned towards the viewer."""
        return self.two_sided and self.needs_normals

    def toward_viewer(self, v: FloatArray) -> FloatArray:
        """Return the directions to which normals are turned in two-sided lighting.

        If `local_facing`, these are `v`, the unit vectors to the viewer, shape (3, n). Otherwise the direction is the
        view axis, shape (3, 1).
        """
        return v if self.local_facing else np.array(self.to_eye)[:, None]

    @cached_property
    def shadowed(self) -> tuple[int, ...]:
        """Indices of the scene's lights that the mesh itself or other surfaces may hide."""
        return tuple(sorted({term.index for term in self.terms if term.is_shadowed}))

    @cached_property
    def channels(self) -> dict[str, slice]:
        """Rows of `Vertices.channels`, by kind; only the kinds that the equation reads.

        "visibility" has a row for each of the scene's lights and one for the sky. If normals are turned towards the
        viewer, the same number of rows follows for the vertices' back sides. "tangents" has the rows x, y and z. Each
        map has one row, under the map's name.
        """
        sizes = {"visibility": (self.lights + 1) * (1 + self.is_flipped)} if self.needs_visibility else {}
        if any(term.needs_normals for term in self.terms):
            sizes |= {"tangents": 3} if "tangents" in self.reflectance.needs else {}
            sizes |= dict.fromkeys(self.maps, 1)
        ends = accumulate(sizes.values())
        return {kind: slice(end - size, end) for (kind, size), end in zip(sizes.items(), ends, strict=True)}

    @property
    def needed_tints(self) -> tuple[str, ...]:
        """Names of the fields whose map of colours affects the result.

        A map is not needed if it multiplies black only.
        """
        if not self.tints:
            return ()
        is_read = {
            "albedo": True,
            "diffuse": any(self.has(term, "diffuse") or self.has(term, "specular") for term in self.terms),
            "specular": any(self.has(term, "specular") for term in self.terms),
            "emission": any(self.emission),
        }
        return tuple(name for name in is_read if name in self.tints and is_read[name])

    @property
    def needs_visibility(self) -> bool:
        """True if any contribution depends on the visibility of a light or of the sky."""
        return self.is_occluded or any(term.is_shadowed for term in self.terms)

    @cached_property
    def needs_eye(self) -> bool:
        """True if the unit vector v to the viewer is computed per vertex, for highlights or for turning normals."""
        return self.eye is not None and (self.has_highlights or (self.is_flipped and self.local_facing))

    @cached_property
    def needs_points(self) -> bool:
        """True if any contribution depends on the position of the vertex."""
        return self.needs_eye or any(not term.light.is_uniform for term in self.terms)


class Share(NamedTuple):
    """One component of a light's contribution; or, without a light, the emission or the light model's ambient light.

    `light` is the light's index, or None without a light.
    """

    component: Component | Literal["ambient", "emission"]
    light: int | None
    terms: tuple[LightTerm, ...]
    """The light's terms, reduced to this component, in the equation's order; none if `light` is None."""


# --- from a scene and a material


# If three factors are at most `_TAME` and their product is at least `_SMALL`, products of two are in range too.
_TAME = 2.0**300
_SMALL = _TAME / FARTHEST


def assemble(
    scene: Scene,
    material: Material,
    matrix: MatrixLike | None,
    maps: Mapping[str, tuple[float, float]] = MappingProxyType({}),
    tints: frozenset[str] = frozenset(),
) -> Equation:
    """Return the lighting equation of a scene and a material, in the scene's convention. `matrix` is copied.

    Parameters
    ----------
    scene, material, matrix
        As for `evaluate`. But in the material, a bound replaces each map; see `Vertices.without_maps`.
    maps, tints
        Least and greatest number of each map of numbers, and names of the fields with a map of colours, as in
        `Equation`.

    Raises
    ------
    ValueError
        If the reflectance does not read one of the maps, or if a map other than albedo is given in VTK's convention.
    """
    copied = None if matrix is None else check.matrix4("matrix", matrix)
    if copied is not None:
        copied.flags.writeable = False
    material = material.without_albedo()
    standard = _standard(scene, material, copied, maps)
    if maps or tints:
        _refuse_unread(standard, scene, material, (*maps, *tints))
        standard = replace(standard, maps=maps, tints=tints)
    return standard if scene.light_model.convention == "standard" else _as_vtk(standard, scene, material)


def _standard(
    scene: Scene, material: Material, matrix: Float64Array | None, maps: Mapping[str, tuple[float, float]]
) -> Equation:
    model, viewer = scene.light_model, scene.viewer
    local = model.local_viewer and not viewer.parallel
    x, y, z = viewer.view_direction
    reflectance = (material.reflectance or REFLECTANCES[model.reflection]()).of(material).over(maps)
    reflectances = _Reflectances.of(material, reflectance)
    labels = light_labels(scene, "light ")
    terms, off, unblocked = [], [], []
    products: dict[Any, tuple[Vector, tuple[Vector, ...], float]] = {}  # many lights have the same colours
    for index, (given, light) in enumerate(zip(scene.lights, scene.world_lights, strict=True)):
        if not light.on:
            off.append(labels[index])
            continue
        colors = light.intensity, light.ambient, light.diffuse, light.specular_color
        if colors not in products:
            products[colors] = reflectances.times(*colors)
        is_shadowed = model.shadows and light.casts_shadows
        if model.shadows and not is_shadowed:
            unblocked.append(labels[index])
        terms.append(LightTerm(light, index, labels[index], given.frame != "world", *products[colors], is_shadowed))
    return Equation(
        terms=tuple(terms),
        off=tuple(off),
        lights=len(labels),
        ambient=_product(BRIGHTEST, rgb(material.ambient), rgb(model.ambient)),
        emission=_product(BRIGHTEST, rgb(material.emission), WHITE),
        reflectance=reflectance,
        eye=cast(Vector, viewer.position) if local else None,
        to_eye=(-x, -y, -z),
        two_sided=model.two_sided,
        local_facing=local,
        clamp=model.clamp,
        matrix=matrix,
        turns_normals=matrix is not None,
        unblocked=tuple(unblocked),
        is_occluded=model.ambient_occlusion is not False,
        bounces=model.bounces,
        colors=tuple(color for _, color in reflectances.lobes),
    )


def _refuse_unread(standard: Equation, scene: Scene, material: Material, names: Iterable[str]) -> None:
    """Raise ValueError if a field in `names` has a map that the reflectance does not read.

    In VTK's convention, only albedo may have a map. `standard` is the equation in the standard convention.
    """
    reflectance = standard.reflectance
    for name in names:
        if name == "albedo":
            continue
        if scene.light_model.convention == "vtk":
            remedy = "VTK's shader has one value for all vertices. For maps, use LightModel()."
            check.refuse(name, "a map", "a number or colour in VTK's convention", remedy)
        if name not in ("diffuse", "emission", *reflectance.maps):
            others = ", ".join(sorted(("albedo", "diffuse", "emission", *reflectance.maps)))
            kind = type(material.reflectance or reflectance).__name__
            check.refuse(name, "a map", f"a number or colour for {kind}", f"{kind} can have maps of {others}.")


def _as_vtk(standard: Equation, scene: Scene, material: Material) -> Equation:
    """Return the equation in VTK's convention for the same scene.

    `standard` is its equation in the standard convention.
    VTK does not multiply the material's ambient by any light, and ignores the lights' ambient and specular colours.
    VTK's viewer is local even in parallel projection. VTK draws a scene without lights unlit.
    """
    is_headlight = vtk_tier(scene.lights) == 1
    reflectance: Reflectance | None
    if material.reflectance is None:
        reflectance = vtk_reflectance(material.shininess, is_headlight=is_headlight)
    else:
        reflectance = in_vtk(material.reflectance.of(material))
    if reflectance is None:
        remedy = f"LightModel() supports this reflectance. {nearest_in_vtk(material)}"
        check.refuse("reflectance", material.reflectance, "None or PBR in VTK's convention", remedy)
    reflectances = _Reflectances.of(material, reflectance)
    terms = []
    for term in standard.terms:
        refuse_unless_in_vtk(term.light, f"lights[{term.index}]", "a light that VTK supports, in VTK's convention")
        values = vtk_values(term.light)  # a cone of 90° becomes no cone
        values = values._replace(exponent=min(values.exponent, HIGHEST_POWER))
        light = light_from_values(values, diffuse=term.light.diffuse, intensity=term.light.intensity)
        if is_headlight and reflectance.is_physical:
            light = light_from_homogeneous((*scene.viewer.position, 1.0))
        diffuse = rgb(term.light.diffuse)
        ambient, colors, gain = reflectances.times(term.light.intensity, BLACK, diffuse, diffuse)
        terms.append(replace(term, light=light, ambient=ambient, colors=colors, gain=gain))
    ambient, diffuse = rgb(material.ambient), rgb(material.diffuse)
    unlit = add(ambient, diffuse)
    if reflectance.is_physical:  # black if a positional light exists, even if it is off
        unlit = BLACK if terms or any(not light.is_uniform for light in scene.lights) else unlit
    elif terms:
        unlit = ambient
    return replace(
        standard,
        terms=tuple(terms),
        ambient=_product(BRIGHTEST, unlit, WHITE),
        gamma=reflectance.gamma,
        reflectance=reflectance,
        eye=cast(Vector, scene.viewer.position),
        local_facing=not scene.viewer.parallel,
    )


def vtk_tier(lights: Iterable[Light]) -> int:
    """Return the number of the shader that VTK chooses for lights.

    It is 1 for a single headlight, 2 for directional lights, 3 for other lights, and 0 for an unlit scene. Lights that
    are off count too in two cases (vtkOpenGLRenderer::UpdateLights): if they have a position, or if they come after the
    first light that is on and are not headlights.
    """
    chosen, shine = 0, 0
    for light in lights:
        if light.on:
            shine += 1
            chosen = max(chosen, 1)
        if chosen == 1 and (shine > 1 or light.frame != "headlight"):
            chosen = 2
        if not light.is_uniform:
            chosen = 3
    return chosen if shine else 0


class _Reflectances(NamedTuple):
    """A material's ambient colour, and the component and colour of each lobe."""

    ambient: Vector
    lobes: tuple[tuple[Component, Vector], ...]

    @classmethod
    def of(cls, material: Material, reflectance: Reflectance) -> _Reflectances:
        colors: dict[Component, Vector] = {"diffuse": rgb(material.diffuse), "specular": rgb(material.specular)}

        def color(lobe: Lobe) -> Vector:
            return lobe.color if lobe.is_own else _product(BRIGHTEST, colors[lobe.component], lobe.color)

        return cls(rgb(material.ambient), tuple((lobe.component, color(lobe)) for lobe in reflectance.lobes))

    def times(
        self, intensity: float, ambient: ColorLike, diffuse: ColorLike, specular: ColorLike
    ) -> tuple[Vector, tuple[Vector, ...], float]:
        """Multiply the surface's colours by a light's `intensity` and colours.

        Return the ambient product, the product of each lobe, and the gain. All products are divided by the gain, a
        power of two, so that none exceeds 1.
        """
        shining: dict[Component, Vector] = {"diffuse": rgb(diffuse), "specular": rgb(specular)}
        dim = _product(FARTHEST, self.ambient, rgb(ambient), intensity)
        colors = [_product(FARTHEST, color, shining[component], intensity) for component, color in self.lobes]
        gain = 2.0 ** math.frexp(max(map(max, (dim, *colors))))[1]
        if gain != 1.0:
            (dim, *colors) = [(red / gain, green / gain, blue / gain) for red, green, blue in (dim, *colors)]
        return dim, tuple(colors), gain


def _product(most: float, reflectance: Vector, light: Vector, intensity: float = 1.0) -> Vector:
    (red, green, blue), (r, g, b) = reflectance, light
    product = red * r * intensity, green * g * intensity, blue * b * intensity
    if min(product) >= _SMALL and max(product) <= most and max(red, green, blue, r, g, b, intensity) <= _TAME:
        return product
    return _capped(most, red, r, intensity), _capped(most, green, g, intensity), _capped(most, blue, b, intensity)


def _capped(most: float, *factors: float) -> float:
    """Return the product of three numbers >= 0, or `most` if the product is larger than `most`.

    Intermediate products neither overflow nor underflow.
    """
    if 0.0 in factors:
        return 0.0
    mantissas, exponents = zip(*map(math.frexp, factors), strict=True)
    mantissa, exponent = math.prod(mantissas), sum(exponents)
    return min(math.ldexp(mantissa, min(exponent, 1023)), most)


# --- the origin, if a matrix translates the mesh very far
#
# If t in p' = (L p + t) / w is very long, the sum is rounded to the precision of t and loses digits of p. A light near
# the mesh has the same t/w in its position. So t/w is subtracted from the positions of mesh and lights before anything
# is added. Lights at a distance of about |t/w| from the mesh lose nothing either: the vectors to them are rounded to
# 2⁻⁵³ of their length as before.


# Ratio of the offset to the distance of a light. At or above it, 2⁻⁵³ of the offset is at least 2⁻²⁴ of the distance.
# Below it, the rounding is invisible even in float32, and a light at the rounded image of a vertex must stay there.
_VERY_FAR = 2.0**29


def relative_to_mesh(equation: Equation) -> Equation:
    """Return the equation with coordinates relative to the mesh's origin if float32 needs it, else `equation`.

    The origin is moved if the mesh's origin is very far away and a light or the eye is near it. The decision does not
    use the vertices, so that no colour depends on other vertices. For the same reason, it uses the equation before a
    plan simplifies it.
    """
    matrix = equation.matrix
    if matrix is None or matrix[3, :3].any() or not matrix[3, 3] or not matrix[:3, 3].any():
        return equation
    if not all(term.light.is_uniform or term.light.places for term in equation.terms):
        return equation  # their positions are unknown
    places: list[VectorLike] = [place for term in equation.terms for place in term.light.places]
    if equation.eye is not None:
        places.append(equation.eye)
    with np.errstate(over="ignore", invalid="ignore"):
        offset = matrix[:3, 3] / matrix[3, 3]
        distances = [float(np.abs(np.subtract(place, offset)).max()) for place in places]
    nearest = min((each for each in distances if each), default=0.0)  # a light at the offset loses nothing
    if not distances or not max(distances) < math.inf or np.abs(offset).max() < _VERY_FAR * nearest:
        return equation
    beside = matrix.copy()
    beside[:3, 3] = 0.0
    beside.flags.writeable = False
    return replace(
        equation,
        terms=tuple(
            replace(term, light=term.light.moved(lambda place: _seen_from_offset(place, matrix)))
            for term in equation.terms
        ),
        eye=None if equation.eye is None else _seen_from_offset(equation.eye, matrix),
        matrix=beside,
    )


def _seen_from_offset(place: VectorLike, matrix: Float64Array) -> Vector:
    """Return the position `place` relative to the mesh's origin t/w, rounded once.

    t is the translation in the matrix, and w is the matrix's last entry.
    """
    w = Fraction(float(matrix[3, 3]))
    x, y, z = (float(Fraction(float(a)) - Fraction(t) / w) for a, t in zip(place, matrix[:3, 3].tolist(), strict=True))
    return x, y, z


# --- area lights, split into closed forms and nodes


def in_parts(equation: Equation) -> Equation:
    """Return the equation with area lights split into the parts that evaluators run.

    For lobes with a closed form, the light itself is kept. For the other lobes, nodes (small lights at points of the
    light) replace the light. The ambient light arrives as if from the light's centre.
    """
    if not any(term.light.has_size for term in equation.terms):
        return equation
    terms = tuple(part for term in equation.terms for part in _parts(equation, term, equation.forms))
    return replace(equation, terms=terms)


def as_nodes(equation: Equation, count: int) -> Equation:
    """Return the equation with each area light replaced by `count` nodes, small lights at points of it."""
    nothing = (None,) * len(equation.reflectance.lobes)
    terms = tuple(part for term in equation.terms for part in _parts(equation, term, nothing, count))
    return replace(equation, terms=terms)


def _parts(
    equation: Equation, term: LightTerm, forms: Sequence[CosinePower | None], count: int | None = None
) -> Iterator[LightTerm]:
    light = term.light
    if not light.has_size:
        yield term
        return
    tints = light.tints(term.bands)
    exact, summed = by_closed_form(term, forms)
    if any(map(any, exact)):
        for tint, part in tints:
            yield replace(term, light=part, ambient=BLACK, colors=_tinted(exact, tint))
    if any(term.ambient):
        black = (BLACK,) * len(forms)
        for node in light.nodes(1):
            yield replace(term, light=node, colors=black)
    if any(map(any, summed)):
        count = count or light.nodes_for(equation.sharpness)
        for node in light.nodes(count) if term.nodes is None else term.nodes:
            colors = _tinted(summed, rgb(node.diffuse))
            yield replace(term, light=node, ambient=BLACK, colors=colors, gain=term.gain * node.intensity)


def by_closed_form(term: LightTerm, forms: Sequence[CosinePower | None]) -> tuple[tuple[Vector, ...], ...]:
    """Split a term's colours into the colours of lobes with a closed form, and the colours of the other lobes.

    Both results have a colour for each lobe: black for a lobe whose colour is in the other result. `forms` has the
    closed form of each lobe (see `Equation.forms`), or None.
    """
    _, light = term.light.tints(term.bands)[0]
    is_exact = [form is not None and light.analytic_integral(form) is not None for form in forms]
    return tuple(
        tuple(color if chosen is exactly else BLACK for color, chosen in zip(term.colors, is_exact, strict=True))
        for exactly in (True, False)
    )


def _tinted(colors: tuple[Vector, ...], tint: Vector) -> tuple[Vector, ...]:
    r, g, b = tint
    return colors if tint == WHITE else tuple((red * r, green * g, blue * b) for red, green, blue in colors)
