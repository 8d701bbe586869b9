"""A scene in VTK's terms: what to give VTK so that it draws the very same colours.

Much of the standard model can be said in VTK's shader with other words: ambient light and emission become the
material's unlit ambient, a viewer at infinity becomes an eye far away, a cone of 90° the widest that VTK still
takes for one. `pvphong.vtk.obstacles` says what cannot.

Where VTK's float32 leaves a vertex's colour open, so that no evaluator can be judged there.

Everything here is computed in float64 from the scene alone, by neither the evaluator nor VTK.

Symbols: n the unit normal, l the unit vector to a light, v to the eye, f the cosine that the highlight raises to the
power p (r·v, or n·l in VTK's first tier), φ the angle off a spot's axis. Errors are in roundings of 2⁻²⁴. float32
turns n, l and v by small angles, which grow where VTK's numbers are large against the distances that count: under
a matrix that shears or flattens, or where a light stands near the surface and the eye far off.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pvphong.base.types import BoolArray, Float64Array, Vector, rgb
from pvphong.optics.light import Light, VtkValues
from pvphong.optics.lights import light_from_values
from pvphong.optics.material import Material
from pvphong.optics.reflectances import PBR
from pvphong.optics.roles import Angle
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading.assembly import vtk_tier
from pvphong.vtk.lights import GAMMA, Cosines
from pvphong.vtk.lights import reflected as physically_reflected
from pvphong.vtk.obstacles import has_highlights, is_headlight_tier, reflected, seen_from_infinity, shining

_WIDEST_CONE = float(np.nextafter(np.float32(90.0), np.float32(0.0)))
"""VTK takes a positional light for a spot only below 90°, in float32."""

_FAR = 1e8
"""In sizes of the mesh: from here every vertex sees the eye in the same direction, to float32."""

_BLACK = light_from_values(VtkValues(False, (0.0, 0.0, -1.0)), diffuse=0.0)


@dataclass(frozen=True)
class Terms:
    """What VTK is given.

    Parameters
    ----------
    lights : tuple of Light
        All but ambient and specular colours count.
    material : Material
        Its ambient is unlit; it has no emission.
    viewer : Viewer
        Always local.
    tier : int
        Which of the shader's three tiers lights it; 0 where it draws unlit.
    conversions : tuple of str
        What was said in other words, a phrase each.
    """

    lights: tuple[Light, ...]
    material: Material
    viewer: Viewer
    tier: int
    conversions: tuple[str, ...]


def in_vtk_terms(scene: Scene, material: Material, center: Float64Array, size: float) -> Terms:
    """A scene and material that VTK draws in the colours of the given ones.

    Parameters
    ----------
    scene, material
        Nothing in them may be inexpressible; see `pvphong.vtk.obstacles.refuse_inexpressible`.
    center : ndarray
        Shape (3,): the middle of the mesh in the world.
    size : float
        The mesh's largest extent in the world.
    """
    if scene.light_model.convention == "vtk":
        lights, viewer = tuple(scene.lights), scene.viewer
        said: list[str] = []
        unlit = rgb(material.ambient)
    else:
        lights, viewer, said = _standard(scene, material, center, size)
        unlit = _times(material.ambient, scene.light_model.ambient)
        if unlit != rgb(material.ambient):
            said.append("ambient light times the material's ambient as VTK's ambient, which no light multiplies")
    if any(rgb(material.emission)):
        said.append("emission as a part of VTK's ambient")
    red, green, blue = (a + e for a, e in zip(unlit, rgb(material.emission), strict=True))
    given = replace(material, ambient=(red, green, blue), emission=0.0)
    return Terms(lights, given, viewer, vtk_tier(lights), tuple(said))


def _standard(
    scene: Scene, material: Material, center: Float64Array, size: float
) -> tuple[tuple[Light, ...], Viewer, list[str]]:
    said = []
    lights, viewer = shining(scene), scene.viewer
    narrowed = [_with_a_cone(light) for light in lights]
    if narrowed != lights:
        said.append(f"cones of 90° as {_WIDEST_CONE:.6f}°, VTK's widest")
        lights = narrowed
    if is_headlight_tier(scene):
        said.append("a headlight alone, which VTK lights by Blinn-Phong with the viewer at infinity")
        return tuple(lights), viewer, said
    if seen_from_infinity(scene) and has_highlights(scene, material):
        said.append("the viewer at infinity as an eye far away")
        lights = [light.in_world(viewer) for light in lights]
        viewer = _far_away(viewer, center, size)
    if vtk_tier(lights) < 2:
        said.append(
            "a black light added, without which VTK would " + ("draw unlit", "simplify highlights")[vtk_tier(lights)]
        )
        lights = [*lights, _BLACK]
    return tuple(lights), viewer, said


def _with_a_cone(light: Light) -> Light:
    angle = light.as_vtk().cone_angle
    if angle is None or angle <= _WIDEST_CONE:
        return light
    return light.with_values(Angle, _WIDEST_CONE)


def _far_away(viewer: Viewer, center: Float64Array, size: float) -> Viewer:
    position = center - np.array(viewer.view_direction) * _FAR * (size or 1.0)
    return Viewer(position=position.tolist(), focal_point=center.tolist(), up=viewer.up)


def _times(reflectance: Any, light: Any) -> Vector:
    red, green, blue = (k * a for k, a in zip(rgb(reflectance), rgb(light), strict=True))
    return red, green, blue


# --- limits


_ROUNDING = 2.0**-24

_FLOOR, _HEADLIGHT_FLOOR = 1e-5, 1e-6
"""VTK's least cosine f, and that in its first tier."""

_DOUBT = 0.25
"""A jump that is less than this part of the tolerance leaves no vertex open."""

_LONGEST = 1e18
"""Vectors whose squared length float32 can hold."""

_FLUSHED = float(np.finfo(np.float32).tiny) / _ROUNDING
"""What a component's square may lose that is below float32's least normal number; drivers make it zero."""


class Pose(NamedTuple):
    """Vertices in the mesh's own coordinates, around its middle, and where they stand."""

    points: Float64Array
    """Shape (n, 3)."""
    normals: Float64Array
    """Shape (n, 3), unit; turned to the viewer where the scene is two-sided."""
    matrix: Float64Array
    """Shape (4, 4), with last row (0, 0, 0, 1)."""

    def in_world(self) -> tuple[Float64Array, Float64Array]:
        """Points and unit normals in the world, both (n, 3)."""
        linear = self.matrix[:3, :3]
        normals = self.normals @ np.linalg.inv(linear)  # a row times L⁻¹ is L⁻ᵀ times a column
        return self.points @ linear.T + self.matrix[:3, 3], normals / np.linalg.norm(normals, axis=1)[:, None]


@dataclass(frozen=True)
class Limits:
    """What can be asked of n vertices.

    Parameters
    ----------
    scale : ndarray
        Shape (n,): the light that arrives, times the material's reflectances, where that is more than 1; else 1.
        float32 rounds in proportion to it.
    open : dict of str to ndarray
        Reason → mask, shape (n,), of the vertices whose colour it leaves open. They may overlap.
    """

    scale: Float64Array
    open: dict[str, BoolArray]


class _Surface(NamedTuple):
    """Vertices in the world, and what float32 does to them on the way to eye space."""

    points: Float64Array
    normals: Float64Array
    eye: Float64Array
    to_eye: Float64Array
    place_error: Float64Array
    normal_angle: Float64Array
    eye_angle: Float64Array


class _Arrival(NamedTuple):
    """What reaches n vertices from one light."""

    direction: Float64Array
    """l, shape (n, 3)."""
    strength: Float64Array
    """Attenuation times spot factor, the latter also outside the cone."""
    angle: Any
    """By which float32 turns l."""
    error: Any
    """Relative error of the strength."""
    lit: BoolArray
    """Inside the cone."""
    edge: BoolArray
    """So near to the cone's edge that float32 may take it for either."""


class _Peak(NamedTuple):
    """The highlight's power of f at n vertices."""

    height: Float64Array
    error: Float64Array
    floor: Float64Array
    """What VTK's floor adds where it shows, else 0."""


class _Share(NamedTuple):
    """One light's part in the colours of n vertices."""

    brightness: Float64Array
    error: Float64Array
    open: dict[str, BoolArray]


def limits(pose: Pose, terms: Terms, tolerance: float, *, has_floors: bool) -> Limits:
    """Which vertices' colours VTK's float32 leaves open.

    Parameters
    ----------
    pose : Pose
        The vertices.
    terms : Terms
        What VTK draws.
    tolerance : float
        Differences that count as agreement: a doubt smaller than that leaves no vertex open.
    has_floors : bool
        Whether what VTK is compared with has VTK's floors under small cosines; else vertices where the floor
        makes a difference are open too.
    """
    surface = _surface(pose, terms)
    physical = terms.material.reflectance and terms.material.reflectance.in_vtk()
    if physical:
        return _physical_limits(surface, terms, physical, tolerance)
    shares = [_share(surface, light, terms, tolerance) for light in terms.lights if light.on]
    brightness = max(rgb(terms.material.ambient)) + sum(share.brightness for share in shares)
    error = brightness * 2.0 + sum(share.error for share in shares)
    reasons = {
        reason: np.logical_or.reduce([share.open[reason] for share in shares], axis=0)
        for reason in ("n·l = 0", "edge of a cone", "VTK's floor")
        if shares and not (has_floors and reason == "VTK's floor")
    }
    scale = np.broadcast_to(np.maximum(1.0, brightness), len(pose.points))
    lost = ~(error * _ROUNDING <= tolerance * scale)  # NaN is lost too
    return Limits(scale, reasons | {"float32": lost})


def _physical_limits(surface: _Surface, terms: Terms, values: PBR, tolerance: float) -> Limits:
    """For VTK's physically based shading: the light of all, and the power that the sum is raised to."""
    sums, errors, edges = np.zeros((3, *surface.points.shape))
    if not terms.tier:
        sums += np.array(rgb(terms.material.ambient)) + rgb(terms.material.diffuse)
    for light in terms.lights:
        if light.on:
            came = _arrival(surface, light.in_world(terms.viewer).as_vtk())
            if terms.tier == 1:
                came = came._replace(direction=surface.to_eye, angle=surface.eye_angle)
            color, error = _physical_share(surface, came, rgb(terms.material.diffuse), values)
            color *= np.array(reflected(1.0, rgb(light.diffuse), light)) * came.strength[:, None]
            sums += color * came.lit[:, None]
            errors += color * came.lit[:, None] * error
            edges += color * came.edge[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        raised = sums ** (1.0 / GAMMA)
        off = np.where(sums > 0.0, raised * (errors / sums + 4.0) / GAMMA, 0.0).max(axis=1) * _ROUNDING
    scale = np.maximum(1.0, raised.max(axis=1))
    lost = ~(off <= tolerance * scale)
    return Limits(scale, {"edge of a cone": (edges > 0.0).any(axis=1), "float32": lost})


def _physical_share(
    surface: _Surface, came: _Arrival, diffuse: Vector, values: PBR
) -> tuple[Float64Array, Float64Array]:
    middle = came.direction + surface.to_eye
    length = np.linalg.norm(middle, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        n_h = _dot(surface.normals, middle) / length
    cosines = Cosines(
        _dot(surface.normals, came.direction),
        _dot(surface.normals, surface.to_eye),
        np.nan_to_num(n_h),
        0.5 * length,
        surface.normal_angle + came.angle,
        surface.normal_angle + surface.eye_angle,
    )
    color, error = physically_reflected(values.metallic, values.roughness, diffuse, cosines)
    return color, error + np.reshape(came.error, (-1, 1))


def _surface(pose: Pose, terms: Terms) -> _Surface:
    points, normals = pose.in_world()
    linear, inverse = np.abs(pose.matrix[:3, :3]), np.linalg.inv(pose.matrix[:3, :3])
    eye = np.array(terms.viewer.position)
    to_eye = eye - points
    distance = np.linalg.norm(to_eye, axis=1)
    place_error = np.linalg.norm(np.abs(pose.points) @ linear.T, axis=1) + np.linalg.norm(pose.matrix[:3, 3] - eye)
    length = np.linalg.norm(pose.normals @ inverse, axis=1)
    cancelled = np.linalg.norm(np.abs(pose.normals) @ np.abs(inverse), axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return _Surface(
            points=points,
            normals=normals,
            eye=eye,
            to_eye=to_eye / distance[:, None],
            place_error=place_error,
            normal_angle=cancelled / length + _unit_error(length),
            eye_angle=place_error / distance + _unit_error(distance),
        )


def _share(surface: _Surface, light: Light, terms: Terms, tolerance: float) -> _Share:
    matte = max(reflected(terms.material.diffuse, rgb(light.diffuse), light))
    shiny = max(reflected(terms.material.specular, rgb(light.diffuse), light))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        came = _arrival(surface, light.in_world(terms.viewer).as_vtk())
        n_l = _dot(surface.normals, came.direction)
        peak = _peak(surface, came, n_l, terms)
        front = (n_l > 0.0) | (terms.tier == 1)
        color = matte * np.maximum(n_l, 0.0) + shiny * front * peak.height
        error = matte * (surface.normal_angle + came.angle + 2.0) + shiny * front * peak.error
        inside = came.strength * came.lit
        doubt = _DOUBT * tolerance
        tangent = np.abs(n_l) <= _ROUNDING * (surface.normal_angle + came.angle + 4.0)
        floored = front & (inside * shiny * peak.floor > doubt)
        if terms.tier == 1:
            floored |= (n_l < _HEADLIGHT_FLOOR) & (matte * _HEADLIGHT_FLOOR > doubt)
        return _Share(
            brightness=inside * (matte + shiny),
            error=inside * (color * came.error + error),
            open={
                "n·l = 0": tangent & (inside * shiny * peak.height > doubt) & (terms.tier > 1),
                "edge of a cone": came.edge & (came.strength * color > doubt),
                "VTK's floor": floored,
            },
        )


def _peak(surface: _Surface, came: _Arrival, n_l: Float64Array, terms: Terms) -> _Peak:
    power = terms.material.shininess
    f, error, floor = _cosine(surface, came, n_l, terms.tier)
    if not any(rgb(terms.material.specular)):
        return _Peak(np.zeros(len(f)), np.zeros(len(f)), np.zeros(len(f)))
    base = np.maximum(f, floor)
    height = base**power
    moves = f > floor - _ROUNDING * error  # firmly below its floor, f may err as it likes
    steepness = power / base * error * moves + 2.0 * power * np.abs(np.log(base)) + 2.0
    reached = (f < floor + _ROUNDING * error) & (power > 0.0)
    return _Peak(height, height * steepness, floor**power * reached)


def _cosine(
    surface: _Surface, came: _Arrival, n_l: Float64Array, tier: int
) -> tuple[Float64Array, Float64Array, float]:
    """f, its error, and the floor under it."""
    if tier == 1:
        return n_l, surface.normal_angle + 2.0, _HEADLIGHT_FLOOR
    f = 2.0 * n_l * _dot(surface.normals, surface.to_eye) - _dot(came.direction, surface.to_eye)
    turn = 2.0 * surface.normal_angle + came.angle + surface.eye_angle
    sine = np.sqrt(np.maximum(1.0 - f * f, 0.0))
    return f, sine * turn + 0.5 * _ROUNDING * turn * turn + 3.0, _FLOOR


def _arrival(surface: _Surface, light: VtkValues) -> _Arrival:
    """Of a light in the world."""
    count = len(surface.points)
    everywhere, nowhere = np.ones(count, dtype=bool), np.zeros(count, dtype=bool)
    if not light.is_positional:
        travel = np.array(light.direction)
        direction = np.broadcast_to(-travel / np.linalg.norm(travel), surface.points.shape)
        return _Arrival(direction, np.ones(count), 1.0, 0.0, everywhere, nowhere)
    position = np.array(light.position)
    to_light = position - surface.points
    distance = np.linalg.norm(to_light, axis=1)
    place = (surface.place_error + np.linalg.norm(position - surface.eye)) / distance
    angle = place + _unit_error(distance)
    constant, linear, quadratic = light.attenuation
    weakening = constant + distance * (linear + quadratic * distance)
    steepness = distance * (linear + 2.0 * quadratic * distance) / weakening
    direction, strength, error = to_light / distance[:, None], 1.0 / weakening, steepness * place + 4.0
    if light.cone_angle is None or light.cone_angle >= 90.0:
        return _Arrival(direction, strength, angle, error, everywhere, nowhere)
    cosine, sine = _off_axis(direction, light)
    limit = math.cos(math.radians(light.cone_angle))
    edge = np.abs(cosine - limit) <= _ROUNDING * (sine * angle + 6.0)
    falloff = np.maximum(cosine, _ROUNDING) ** light.exponent
    error = error + light.exponent * ((sine * angle + 3.0) / np.maximum(cosine, _ROUNDING)) + 2.0
    return _Arrival(direction, strength * falloff, angle, error, cosine >= limit, edge)


def _off_axis(direction: Float64Array, light: VtkValues) -> tuple[Float64Array, Float64Array]:
    """Cosine and sine of the angle between a spot's axis and the way from it to the vertices."""
    axis = np.array(light.direction) / np.linalg.norm(light.direction)
    cosine = -(direction @ axis)
    return cosine, np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))


def _unit_error(length: Float64Array) -> Float64Array:
    """By which float32 turns a vector of this length when it makes it a unit vector; NaN where it cannot."""
    return np.where(length <= _LONGEST, 1.0 + _FLUSHED / (length * length), np.nan)


def _dot(a: Float64Array, b: Float64Array) -> Float64Array:
    return np.einsum("ij,ij->i", a, b)
