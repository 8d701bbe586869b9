"""From a scene and a material to their equation.

Here the two conventions part: `standard` is the model that OpenGL and its textbooks share, `vtk` follows VTK's shader
(vtkOpenGLPolyDataMapper::ReplaceShaderLight).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from pvphong.base import check
from pvphong.base.float_range import BRIGHTEST, FARTHEST
from pvphong.base.types import ColorLike, Float64Array, MatrixLike, Vector, VectorLike, rgb
from pvphong.optics.light import Light
from pvphong.optics.lights import light_from_homogeneous, light_from_values, refuse_unless_in_vtk
from pvphong.optics.material import Material, nearest_in_vtk
from pvphong.optics.reflectance import Component, Lobe, Reflectance
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.optics.reflectances.vtk import HIGHEST_POWER, vtk_reflectance
from pvphong.scene.scene import Scene, light_labels
from pvphong.shading.equation import BLACK, NO_MAPS, Equation, LightTerm

_WHITE = (1.0, 1.0, 1.0)

# Three factors of at most `_TAME`, whose product is at least `_SMALL`, have products of two within range too.
_TAME = 2.0**300
_SMALL = _TAME / FARTHEST


def assemble(
    scene: Scene, material: Material, matrix: MatrixLike | None, maps: Mapping[str, tuple[float, float]] = NO_MAPS
) -> Equation:
    """The equation of a scene and a material, in the scene's convention; the matrix is copied.

    Raises
    ------
    ValueError
        If the reflectance does not read one of the maps, or in VTK's convention, which has none.
    """
    copied = None if matrix is None else check.matrix4("matrix", matrix)
    if copied is not None:
        copied.flags.writeable = False
    standard = _standard(scene, material, copied)
    if maps:
        standard = _with_maps(standard, scene, material, maps)
    return standard if scene.light_model.convention == "standard" else _as_vtk(standard, scene, material)


def _standard(scene: Scene, material: Material, matrix: Float64Array | None) -> Equation:
    model, viewer = scene.light_model, scene.viewer
    local = model.local_viewer and not viewer.parallel
    x, y, z = viewer.view_direction
    reflectance = (material.reflectance or REFLECTANCES[model.reflection]()).of(material)
    reflectances = _Reflectances.of(material, reflectance)
    labels = light_labels(scene, "light ")
    return Equation(
        terms=tuple(_terms(scene, labels, reflectances)),
        off=tuple([labels[index] for index, light in enumerate(scene.lights) if not light.on]),
        lights=len(labels),
        ambient=_product(BRIGHTEST, rgb(material.ambient), rgb(model.ambient)),
        emission=_product(BRIGHTEST, rgb(material.emission), _WHITE),
        reflectance=reflectance,
        eye=_vector(viewer.position) if local else None,
        to_eye=(-x, -y, -z),
        two_sided=model.two_sided,
        local_facing=local,
        clamp=model.clamp,
        matrix=matrix,
        turns_normals=matrix is not None,
        is_occluded=model.ambient_occlusion is not False,
    )


def _terms(scene: Scene, labels: Sequence[str], reflectances: _Reflectances) -> Iterator[LightTerm]:
    """Of the lights that are on."""
    products: dict[Any, tuple[Vector, tuple[Vector, ...], float]] = {}  # many lights have the same colours
    for index, (given, light) in enumerate(zip(scene.lights, scene.world_lights, strict=True)):
        if light.on:
            colors = light.intensity, light.ambient, light.diffuse, light.specular_color
            if colors not in products:
                products[colors] = reflectances.times(*colors)
            rides = given.frame != "world"
            yield LightTerm(
                light, index, labels[index], rides, *products[colors], is_shadowed=scene.light_model.shadows
            )


def _with_maps(
    standard: Equation, scene: Scene, material: Material, maps: Mapping[str, tuple[float, float]]
) -> Equation:
    """The reflectance has the greatest of the numbers that are given for its fields."""
    reflectance = standard.reflectance
    for name in maps:
        if scene.light_model.convention == "vtk":
            remedy = "VTK's shader knows but one for all vertices: give it to the Material, or take LightModel()."
            check.refuse(name, "an array", "None in VTK's convention", remedy)
        if name not in reflectance.maps:
            others = ", ".join(sorted(reflectance.maps))
            remedy = f"It reads {others} of each vertex." if others else "It reads nothing of each vertex but albedo."
            check.refuse(name, "an array", f"None for {type(material.reflectance or reflectance).__name__}", remedy)
    equation = replace(standard, maps=maps)
    greatest: dict[str, Any] = {name: high for name, (_, high) in equation.fields_with_maps.items()}
    return replace(equation, reflectance=replace(reflectance, **greatest))


def _as_vtk(standard: Equation, scene: Scene, material: Material) -> Equation:
    """VTK's reading of the same scene.

    The material's ambient is not multiplied by any light; the lights' ambient and specular colours are
    ignored; the viewer is local even in parallel projection; a scene without any light is drawn unlit.
    """
    is_headlight = vtk_tier(scene.lights) == 1
    reflectance: Reflectance | None = vtk_reflectance(material.shininess, is_headlight=is_headlight)
    if material.reflectance is not None:
        reflectance = material.reflectance.of(material).in_vtk()
    if reflectance is None:
        remedy = f"LightModel() has it. {nearest_in_vtk(material)}"
        check.refuse("reflectance", material.reflectance, "None or PBR in VTK's convention", remedy)
    reflectances = _Reflectances.of(material, reflectance)
    terms = tuple(_as_vtk_lights(term, reflectances) for term in standard.terms)
    if is_headlight and reflectance.is_physical:
        at_the_eye = light_from_homogeneous((*scene.viewer.position, 1.0))
        terms = tuple(replace(term, light=at_the_eye) for term in terms)
    ambient, diffuse = rgb(material.ambient), rgb(material.diffuse)
    unlit = ambient[0] + diffuse[0], ambient[1] + diffuse[1], ambient[2] + diffuse[2]
    if reflectance.is_physical:  # a light with a position that is off leaves it black
        unlit = BLACK if terms or any(not light.is_even for light in scene.lights) else unlit
    elif terms:
        unlit = ambient
    return replace(
        standard,
        terms=terms,
        ambient=_product(BRIGHTEST, unlit, _WHITE),
        gamma=reflectance.gamma,
        reflectance=reflectance,
        eye=_vector(scene.viewer.position),
        local_facing=not scene.viewer.parallel,
    )


def vtk_tier(lights: Iterable[Light]) -> int:
    """Which tier of its shader VTK chooses: 1 a headlight alone, 2 directional lights, 3 any light; 0 draws unlit.

    A light that is off counts too if it has a position, or if it is no headlight and stands behind the first
    that is on (vtkOpenGLRenderer::UpdateLights).
    """
    chosen, shine = 0, 0
    for light in lights:
        if light.on:
            shine += 1
            chosen = max(chosen, 1)
        if chosen == 1 and (shine > 1 or light.frame != "headlight"):
            chosen = 2
        if not light.is_even:
            chosen = 3
    return chosen if shine else 0


def _as_vtk_lights(term: LightTerm, reflectances: _Reflectances) -> LightTerm:
    """A light as VTK takes it: a cone of 90° is none, exponents end at 128, highlights have the diffuse colour."""
    light = term.light
    refuse_unless_in_vtk(light, f"lights[{term.index}]", "one that VTK has, in VTK's convention")
    values = light.as_vtk()
    values = values._replace(exponent=min(values.exponent, HIGHEST_POWER))
    shape = light_from_values(values, diffuse=light.diffuse, intensity=light.intensity)
    diffuse = rgb(light.diffuse)
    ambient, colors, gain = reflectances.times(shape.intensity, BLACK, diffuse, diffuse)
    return replace(term, light=shape, ambient=ambient, colors=colors, gain=gain)


class _Reflectances(NamedTuple):
    """A material's colours, and which of them each lobe takes."""

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
        """A term's ambient colour, its lobes' colours, and their gain, for a light of these colours and intensity."""
        shining: dict[Component, Vector] = {"diffuse": rgb(diffuse), "specular": rgb(specular)}
        dim = _product(FARTHEST, self.ambient, rgb(ambient), intensity)
        colors = tuple([_product(FARTHEST, color, shining[component], intensity) for component, color in self.lobes])
        gain = 2.0 ** math.frexp(max(map(max, (dim, *colors))))[1]
        return (dim, colors, gain) if gain == 1.0 else (_over(dim, gain), tuple([_over(c, gain) for c in colors]), gain)


def _over(color: Vector, gain: float) -> Vector:
    return color[0] / gain, color[1] / gain, color[2] / gain


def _product(most: float, reflectance: Vector, light: Vector, intensity: float = 1.0) -> Vector:
    if light == _WHITE and intensity == 1.0 and max(reflectance) <= most:
        return reflectance
    if BLACK in (reflectance, light):
        return BLACK
    (red, green, blue), (r, g, b) = reflectance, light
    product = red * r * intensity, green * g * intensity, blue * b * intensity
    if min(product) >= _SMALL and max(product) <= most and max(red, green, blue, r, g, b, intensity) <= _TAME:
        return product
    return _capped(most, red, r, intensity), _capped(most, green, g, intensity), _capped(most, blue, b, intensity)


def _capped(most: float, *factors: float) -> float:
    """A product of three numbers >= 0, at most `most`; only the whole of it may leave the range of floats."""
    if 0.0 in factors:
        return 0.0
    mantissas, exponents = zip(*map(math.frexp, factors), strict=True)
    mantissa, exponent = math.prod(mantissas), sum(exponents)
    return min(math.ldexp(mantissa, min(exponent, 1023)), most)


def _vector(value: VectorLike) -> Vector:
    x, y, z = value
    return x, y, z
