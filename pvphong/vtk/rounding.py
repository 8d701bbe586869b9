"""Vertices where float32 leaves VTK's colour uncertain, so that VTK cannot judge an evaluator there.

The colour of such a vertex, and the vertex itself, is called open. All values are computed in float64 from the scene
alone, independent of the evaluator and of VTK.

Symbols are unit vectors: n is the normal, l points to a light, v points to the eye, h is halfway between l and v, and r
is l mirrored at n. The highlight is f to the power p, where f is the cosine r·v, or n·l in the first of the three tiers
of VTK's shader. φ is the angle from a spot's axis. Symbols of physically based shading are those of
`pvphong.optics.reflectances.microfacets`.

Errors are in units of 2⁻²⁴, the rounding of float32; one such unit is called a rounding. Errors of n, l and v are the
angles by which float32 rotates them. The angles are large where VTK's numbers are large compared with the relevant
distances. This happens under a matrix that shears or flattens, or if a light is near the surface and the eye is far
away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from pvphong.base.types import BoolArray, Float64Array, Vector, rgb
from pvphong.optics.light import Light
from pvphong.optics.lights import VtkValues, vtk_values
from pvphong.optics.reflectances.likeness import in_vtk
from pvphong.optics.reflectances.pbr import PBR, fresnel_ends
from pvphong.vtk.scenes import Terms, reflected

_ROUNDING = 2.0**-24

_FLOOR, _HEADLIGHT_FLOOR = 1e-5, 1e-6
"""Lower limits, called floors, of the cosine f in VTK's shader: in general, and in its first tier."""

_DOUBT = 0.25
"""Smallest jump in colour for which a vertex is open, as a fraction of the tolerance."""

_LONGEST = 1e18
"""Largest length of a vector whose square fits in float32."""

_FLUSHED = float(np.finfo(np.float32).tiny) / _ROUNDING
"""Error in units of 2⁻²⁴ if the square of a component is below float32's least normal number, so that drivers use 0."""

_GAMMA = 2.2
"""Gamma of physically based shading, which raises the sum of all light to the power 1/2.2."""

_LEAST_DENOMINATOR = math.sqrt(1e-8 / math.pi)
"""Least denominator of the microfacets' distribution D in VTK's shader."""


class Pose(NamedTuple):
    """Vertices in object coordinates, and the matrix that transforms object coordinates to the world.

    The points are relative to the mesh's centre. The matrix is the model matrix, with the shift of the centre added.
    """

    points: Float64Array
    """Points, shape (n, 3)."""
    normals: Float64Array
    """Unit normals, shape (n, 3); turned to the viewer if the scene is two-sided."""
    matrix: Float64Array
    """Matrix to the world, shape (4, 4), with last row (0, 0, 0, 1)."""

    def in_world(self) -> tuple[Float64Array, Float64Array]:
        """Return points and unit normals in world coordinates, shape (n, 3) each."""
        linear = self.matrix[:3, :3]
        normals = self.normals @ np.linalg.inv(linear)  # a row times L⁻¹ is L⁻ᵀ times a column
        return self.points @ linear.T + self.matrix[:3, 3], normals / np.linalg.norm(normals, axis=1)[:, None]


@dataclass(frozen=True)
class Limits:
    """Limits of a comparison with VTK at n vertices.

    Parameters
    ----------
    scale : ndarray
        Shape (n,): the sum of the arriving light times the material's reflectances, or 1 if the sum is less than 1.
        float32 errors are proportional to it.
    open : dict of str to ndarray
        Reason → mask, shape (n,): True for the vertices whose colour is uncertain in float32, for this reason. A
        vertex may have several reasons.
    """

    scale: Float64Array
    open: dict[str, BoolArray]


def allowed_error(roughness: float) -> float:
    """Return the error that is allowed in colours of physically based shading. For colours above 1, it is relative.

    The error is 6 · 2⁻²⁴ / roughness⁴ + 2e-6, with roughness⁴ at least `_LEAST_DENOMINATOR`. At the peak of a
    highlight, the denominator of D, 1 − (1 − α²)(n·h)², is only α² = roughness⁴. There, five or six roundings of n·h
    and its square are magnified. D contains the square of the denominator, and the colour is D to the power 1/2.2.
    """
    return 6.0 * _ROUNDING / max(roughness**4, _LEAST_DENOMINATOR) + 2e-6


def limits(pose: Pose, terms: Terms, tolerance: float, *, has_floors: bool) -> Limits:
    """Find the open vertices, that is, vertices whose colour is uncertain in float32 by more than a tolerance.

    Parameters
    ----------
    pose : Pose
        The vertices.
    terms : Terms
        The scene that VTK draws.
    tolerance : float
        Largest difference that counts as agreement. A vertex with a smaller uncertainty is not open.
    has_floors : bool
        True if the compared evaluator limits cosines by VTK's floors. If False, vertices where a floor changes the
        colour are open too.
    """
    surface = _surface(pose, terms)
    physical = in_vtk(terms.material.reflectance)
    if physical:
        return _physical_limits(surface, terms, physical, tolerance)
    shares = [_phong_share(surface, light, terms, _DOUBT * tolerance) for light in terms.lights if light.on]
    brightness = max(rgb(terms.material.ambient)) + sum(share for share, _, _ in shares)
    error = brightness * 2.0 + sum(error for _, error, _ in shares)
    reasons = {
        reason: np.logical_or.reduce([is_open[reason] for _, _, is_open in shares], axis=0)
        for reason in ("n·l = 0", "edge of a cone", "VTK's floor")
        if shares and not (has_floors and reason == "VTK's floor")
    }
    scale = np.broadcast_to(np.maximum(1.0, brightness), len(pose.points))
    lost = ~(error * _ROUNDING <= tolerance * scale)  # also True for NaN
    return Limits(scale, reasons | {"float32": lost})


class _Surface(NamedTuple):
    """Vertices in world coordinates, and the float32 errors of their transformation to eye space.

    `eye` is the viewer's position. `place_error` is the error of the vertices' positions, shape (n,).
    """

    points: Float64Array
    normals: Float64Array
    eye: Float64Array
    to_eye: Float64Array
    """Unit vectors v, shape (n, 3)."""
    place_error: Float64Array
    normal_angle: Float64Array
    """Angle by which float32 rotates n, in units of 2⁻²⁴."""
    eye_angle: Float64Array
    """Angle by which float32 rotates v, in units of 2⁻²⁴."""


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
        normal_angle = cancelled / length + _unit_error(length)
        eye_angle = place_error / distance + _unit_error(distance)
        return _Surface(points, normals, eye, to_eye / distance[:, None], place_error, normal_angle, eye_angle)


class _Arrival(NamedTuple):
    """Light that arrives at n vertices from one light, and its float32 errors."""

    direction: Float64Array
    """Unit vectors l, shape (n, 3)."""
    strength: Float64Array
    """Attenuation times spot factor, shape (n,). The spot factor is not set to 0 outside the cone."""
    angle: Any
    """Angle by which float32 rotates l, in units of 2⁻²⁴."""
    error: Any
    """Relative error of the strength, in units of 2⁻²⁴."""
    lit: BoolArray
    """True inside the cone."""
    edge: BoolArray
    """True if float32 may place the vertex on either side of the cone's edge."""


def _arrival(surface: _Surface, light: VtkValues) -> _Arrival:
    """Compute the light that arrives at the vertices of `surface` from one light.

    `light` has the values that VTK's shader reads, in world coordinates.
    """
    count = len(surface.points)
    everywhere, nowhere = np.ones(count, dtype=bool), np.zeros(count, dtype=bool)
    axis = np.array(light.direction) / np.linalg.norm(light.direction)
    if not light.is_positional:
        return _Arrival(np.broadcast_to(-axis, (count, 3)), np.ones(count), 1.0, 0.0, everywhere, nowhere)
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
    cosine = -(direction @ axis)  # of φ
    limit = math.cos(math.radians(light.cone_angle))
    edge = np.abs(cosine - limit) <= _ROUNDING * (_sine(cosine) * angle + 6.0)
    falloff = np.maximum(cosine, _ROUNDING) ** light.exponent
    error = error + light.exponent * ((_sine(cosine) * angle + 3.0) / np.maximum(cosine, _ROUNDING)) + 2.0
    return _Arrival(direction, strength * falloff, angle, error, cosine >= limit, edge)


def _phong_share(
    surface: _Surface, light: Light, terms: Terms, doubt: float
) -> tuple[Float64Array, Float64Array, dict[str, BoolArray]]:
    """Compute, for VTK's Phong shading, the light that n vertices reflect from one light, and its float32 error.

    Parameters
    ----------
    surface : _Surface
        The vertices.
    light : Light
        The light.
    terms : Terms
        The scene that VTK draws.
    doubt : float
        Smallest jump of the colour for which a vertex is open.

    Returns
    -------
    brightness : ndarray
        Arriving light times the sum of the material's diffuse and specular reflectances, shape (n,).
    error : ndarray
        Error of the reflected colour in units of 2⁻²⁴, shape (n,).
    is_open : dict of str to ndarray
        Reason → mask, shape (n,), of the vertices whose colour may jump by more than `doubt` for this reason.
    """
    matte = max(reflected(terms.material.diffuse, rgb(light.diffuse), light))
    shiny = max(reflected(terms.material.specular, rgb(light.diffuse), light))
    power, is_headlight = terms.material.shininess, terms.tier == 1
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        came = _arrival(surface, vtk_values(light.in_world(terms.viewer)))
        n_l = _dot(surface.normals, came.direction)
        if is_headlight:
            f, error, floor = n_l, surface.normal_angle + 2.0, _HEADLIGHT_FLOOR
        else:
            f = 2.0 * n_l * _dot(surface.normals, surface.to_eye) - _dot(came.direction, surface.to_eye)
            turn = 2.0 * surface.normal_angle + came.angle + surface.eye_angle
            error, floor = _sine(f) * turn + 0.5 * _ROUNDING * turn * turn + 3.0, _FLOOR
        base, height, height_error = np.maximum(f, floor), np.zeros(len(f)), np.zeros(len(f))
        if any(rgb(terms.material.specular)):
            moves = f > floor - _ROUNDING * error  # if f is well below its floor, errors of f have no effect
            height = base**power
            height_error = height * (power / base * error * moves + 2.0 * power * np.abs(np.log(base)) + 2.0)
        front = (n_l > 0.0) | is_headlight
        color = matte * np.maximum(n_l, 0.0) + shiny * front * height
        color_error = matte * (surface.normal_angle + came.angle + 2.0) + shiny * front * height_error
        inside = came.strength * came.lit
        tangent = np.abs(n_l) <= _ROUNDING * (surface.normal_angle + came.angle + 4.0)
        reached = (f < floor + _ROUNDING * error) & (power > 0.0)
        floored = front & reached & (inside * shiny * floor**power > doubt)
        if is_headlight:
            floored |= (n_l < _HEADLIGHT_FLOOR) & (matte * _HEADLIGHT_FLOOR > doubt)
        is_open = {
            "n·l = 0": tangent & (inside * shiny * height > doubt) & (terms.tier > 1),
            "edge of a cone": came.edge & (came.strength * color > doubt),
            "VTK's floor": floored,
        }
        return inside * (matte + shiny), inside * (color * came.error + color_error), is_open


def _physical_limits(surface: _Surface, terms: Terms, values: PBR, tolerance: float) -> Limits:
    """Find the open vertices in VTK's physically based shading: the vertices whose colour is uncertain in float32.

    The colour is the sum of all light to the power 1/2.2, so errors of the sum are converted to errors of this power.

    Parameters
    ----------
    surface : _Surface
        The vertices.
    terms : Terms
        The scene that VTK draws.
    values : PBR
        The reflectance, as VTK's shader computes it.
    tolerance : float
        Largest difference that counts as agreement.
    """
    sums, errors, edges = np.zeros((3, *surface.points.shape))
    if not terms.tier:
        sums += np.array(rgb(terms.material.ambient)) + rgb(terms.material.diffuse)
    for light in terms.lights:
        if light.on:
            came = _arrival(surface, vtk_values(light.in_world(terms.viewer)))
            if terms.tier == 1:
                came = came._replace(direction=surface.to_eye, angle=surface.eye_angle)
            color, error = _physical_share(surface, came, rgb(terms.material.diffuse), values)
            color *= np.array(reflected(1.0, rgb(light.diffuse), light)) * came.strength[:, None]
            sums += color * came.lit[:, None]
            errors += color * came.lit[:, None] * error
            edges += color * came.edge[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        raised = sums ** (1.0 / _GAMMA)
        off = np.where(sums > 0.0, raised * (errors / sums + 4.0) / _GAMMA, 0.0).max(axis=1) * _ROUNDING
    scale = np.maximum(1.0, raised.max(axis=1))
    lost = ~(off <= tolerance * scale)
    return Limits(scale, {"edge of a cone": (edges > 0.0).any(axis=1), "float32": lost})


def _physical_share(
    surface: _Surface, came: _Arrival, diffuse: Vector, values: PBR
) -> tuple[Float64Array, Float64Array]:
    """Compute the fraction of white light that the vertices reflect to the eye in VTK's physically based shading.

    Parameters
    ----------
    surface : _Surface
        The n vertices.
    came : _Arrival
        Light that arrives from one light.
    diffuse : tuple of float
        The material's diffuse colour.
    values : PBR
        The reflectance.

    Returns
    -------
    light, error : ndarray
        Shape (n, 3): the fraction, and its relative error in units of 2⁻²⁴.
    """
    middle = came.direction + surface.to_eye
    length = np.linalg.norm(middle, axis=1)
    n_l, n_v, h_l = _dot(surface.normals, came.direction), _dot(surface.normals, surface.to_eye), 0.5 * length
    with np.errstate(divide="ignore", invalid="ignore"):
        n_h = np.maximum(np.nan_to_num(_dot(surface.normals, middle) / length), 0.0)
    light_turn, eye_turn = surface.normal_angle + came.angle, surface.normal_angle + surface.eye_angle
    half_turn = (light_turn + eye_turn) / (2.0 * np.maximum(h_l, 1e-9))
    # as in VTK's shader: Schlick's F, GGX's D, and Smith's correlated G
    x, y, a, m = np.maximum(n_l, _FLOOR), np.maximum(n_v, _FLOOR), np.array(diffuse), values.metallic
    r2 = values.roughness**2
    f0, f90 = fresnel_ends(m, a)
    grazing = (1.0 - np.clip(h_l, _FLOOR, 1.0))[:, None]
    f = f0 + (f90 - f0) * grazing**5
    denominator = np.maximum(1.0 - (1.0 - r2 * r2) * n_h**2, _LEAST_DENOMINATOR)
    masked = x * np.sqrt(r2 + (1.0 - r2) * y * y) + y * np.sqrt(r2 + (1.0 - r2) * x * x)
    shine = ((r2 / denominator) ** 2 * x / (2.0 * masked))[:, None]
    base = (1.0 - m) * (1.0 - f) * a * x[:, None]
    light = base + shine * f
    # errors of the factors, because of rotated directions
    of_x, of_y = _error_above_floor(n_l, light_turn), _error_above_floor(n_v, eye_turn)
    of_f = 5.0 * grazing**4 * (1.0 - f0) * (_sine(h_l) * half_turn + 3.0)[:, None]
    of_n_h = 2.0 * n_h * (_sine(n_h) * half_turn + 2.0) + 1.5
    of_shine = (of_x + of_y + 2.0 * of_n_h / denominator + 12.0)[:, None]
    error = base * (of_x[:, None] + 8.0) + (1.0 - m) * a * x[:, None] * of_f + shine * (f * of_shine + of_f)
    return light / math.pi, error / np.maximum(light, np.finfo(np.float64).tiny) + np.reshape(came.error, (-1, 1))


def _error_above_floor(cosine: Float64Array, turn: Any) -> Float64Array:
    """Return the relative error, in units of 2⁻²⁴, of a cosine that VTK's shader limits to at least `_FLOOR`.

    `turn` is the sum of the angles by which float32 rotates the cosine's two vectors, in units of 2⁻²⁴. The error is 0
    if the cosine is so far below the floor that rounding cannot lift it above the floor.
    """
    lost = _sine(cosine) * turn + 3.0
    return np.where(cosine > _FLOOR - lost * _ROUNDING, lost / np.maximum(cosine, _FLOOR), 0.0)


def _sine(cosine: Float64Array) -> Float64Array:
    return np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))


def _unit_error(length: Float64Array) -> Float64Array:
    """Return the error of a vector's direction, an angle in units of 2⁻²⁴, after the vector was normalized in float32.

    `length` is the vector's length before the normalization, shape (n,). The error is NaN if the squared length
    overflows float32.
    """
    return np.where(length <= _LONGEST, 1.0 + _FLUSHED / (length * length), np.nan)


def _dot(a: Float64Array, b: Float64Array) -> Float64Array:
    return np.einsum("ij,ij->i", a, b)
