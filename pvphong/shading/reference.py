"""The lighting equation in NumPy, written to be read beside the model it implements.

Symbols: p a vertex, n its unit normal, v the unit vector to the viewer, l the unit vector to a light, and
for each light a·s its attenuation times spot factor; f is the cosine that the highlight raises to the
material's shininess. Arrays hold a block of vertices as columns, (3, block).

Positions are moved and subtracted from each other in float64, whatever the precision asked for: a light's
difference to a vertex far from the origin is then exact to the last bit of the stored coordinates. What
follows is computed in the precision asked for.

The highlight is computed by chords. With D = 2(n·l)n − l − v, the difference of mirror direction and
viewer, r·v = 1 − ½|D|²; with D = h − n, n·h = 1 − ½|D|². Near the peak |D| is small and known to full
precision, while a cosine near 1 has lost the digits that a high shininess asks for. The first D is taken
apart, across n and along it: |D|² = |n × (l + v)|² + (n·(l − v))². Then nothing is left of it where n = l = v,
and a rounding of n's length does not count elsewhere.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from pvphong.base.types import Float64Array, FloatArray, Vector
from pvphong.base.vectors import columns, dot, moderate, square_of_cross, towards
from pvphong.geometry.transform import transform_normals, transform_points
from pvphong.optics.lights import Arrival
from pvphong.shading.albedo import reflectances
from pvphong.shading.equation import BRIGHTEST, Equation, LightTerm
from pvphong.shading.result import Shading

# Powers below e to this are 0 in float64: NumPy's exp takes up to fifty times as long from there on.
_DARK = -707.5

# Makes room for the square of l + v where it is less than this, for they are nearly opposite; a power of two, so that
# it changes no bit of the others.
_LARGER, _SMALL = 2.0**60, 2.0**-60

# Sums of three products have lost no bit to underflow from here on.
_LEAST_PRODUCT = {"float32": 2.0**-100, "float64": 2.0**-970}

# Vertices per block: large enough that NumPy's cost per call is small, small enough for the caches.
BLOCK = 32768


class Surface(NamedTuple):
    """A block of vertices, ready to be lit; all but the points in the precision asked for.

    What the equation does not need is not there.
    """

    points: Float64Array
    raw: FloatArray
    """Normals before they were made unit length. The sign of n·l is decided on these and on ways to the light, so that
    the rounding of unit vectors has no part in it."""
    inverse_length: FloatArray
    normals: FloatArray
    to_viewer: FloatArray
    facing: FloatArray
    """N·v of the raw normals, for Phong's highlights."""
    unseen: Any
    """Where v does not exist (the eye on the vertex, or a vertex that is not finite); False for nowhere."""
    albedo: FloatArray | None


_NOTHING: Any = np.zeros((3, 0))


def shade(
    points: FloatArray, normals: FloatArray, equation: Equation, albedo: FloatArray | None, result: Shading
) -> None:
    """Evaluate the equation at every vertex, block by block, into the arrays of `result`.

    Vertices are independent of each other, so the size of the blocks changes no bit.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3), float32 or float64, of any memory layout.
    equation : Equation
        What to evaluate.
    albedo : ndarray or None
        Shape (n, 3), as `checked_albedo` gives it; multiplies the material's ambient and diffuse.
    result : Shading
        `rgb` is filled in, the others are added to; their type is the precision.
    """
    is_even = not (equation.needs_points or equation.needs_normals or albedo is not None)
    for start in range(0, len(points), BLOCK):
        part = slice(start, start + BLOCK)
        if start and is_even:
            _repeat(result, part)
            continue
        shades = None if albedo is None else albedo[part]
        with np.errstate(divide="ignore", under="ignore", over="ignore"):
            surface = _surface(points[part], normals[part], shades, equation, result.rgb.dtype.type)
            _shade_block(surface, equation, _part(result, part))


def _repeat(result: Shading, part: slice) -> None:
    """The first block's values once more: nothing tells one vertex from another."""
    for array in vars(result).values():
        if array is not None:
            here = array[..., part, :]
            here[:] = array[..., : here.shape[-2], :]


def _part(result: Shading, part: slice) -> Shading:
    """The vertices of one block of the result, as views."""
    arrays = {name: getattr(result, name) for name in Shading.__dataclass_fields__}
    views: dict[str, Any] = {name: a if a is None else a[..., part, :] for name, a in arrays.items()}
    return Shading(**views)


def _surface(
    points: FloatArray, normals: FloatArray, albedo: FloatArray | None, equation: Equation, real: Any
) -> Surface:
    p, v, unseen = _points(points, equation) if equation.needs_points else _NOTHING, _column(equation.to_eye), False
    raw = inverse_length = np.zeros((3, 0), real)
    if equation.eye is not None and equation.needs_eye:
        v, unseen = _to_viewer(p, equation.eye, real)
    if equation.needs_normals:
        raw, inverse_length = _normals(normals, equation, real)
    if equation.is_flipped:
        facing = v if equation.local_facing else _column(equation.to_eye)
        raw = np.where(dot(raw, facing) < 0.0, -raw, raw)
    v = v.astype(real, copy=False)
    return Surface(
        points=p,
        raw=raw,
        inverse_length=inverse_length,
        normals=raw * inverse_length if _needs_unit_normals(equation) else _NOTHING,
        to_viewer=v,
        facing=dot(raw, v) if equation.has_highlights and equation.reflection == "phong" else _NOTHING[0],
        unseen=unseen,
        albedo=None if albedo is None else reflectances(albedo).T.astype(real),
    )


def _needs_unit_normals(equation: Equation) -> bool:
    """Phong's chord, as n·l, takes raw normals."""
    return equation.headlight_only or (equation.has_highlights and equation.reflection == "blinn-phong")


def _points(points: FloatArray, equation: Equation) -> Float64Array:
    return columns(points if equation.matrix is None else transform_points(points, equation.matrix))


def _normals(normals: FloatArray, equation: Equation, real: Any) -> tuple[FloatArray, FloatArray]:
    if equation.turns_normals and equation.matrix is not None:
        normals = transform_normals(normals, equation.matrix)
    return moderate(normals.T, real)


def _column(vector: Vector) -> Float64Array:
    return np.array(vector)[:, None]


def _to_viewer(p: Float64Array, eye: Vector, real: Any) -> tuple[Any, Any]:
    """Unit vectors v, (3, n), and where there is none."""
    v, distance = towards(eye, p, real)
    return v, False if distance.min(initial=1.0) > 0.0 else ~(distance > 0.0)


def _shade_block(surface: Surface, equation: Equation, result: Shading) -> None:
    color = np.zeros((3, len(result.rgb)), result.rgb.dtype)
    _add(equation.emission, 1.0, None, color, result.emission, result.base)
    _add(equation.ambient, 1.0, surface.albedo, color, result.ambient, result.base)
    for term in equation.terms:
        share = None if result.per_light is None else result.per_light[term.index]
        strength, diffuse, specular = _factors(surface, equation, term)
        _add(term.ambient, strength, surface.albedo, color, result.ambient, share)
        _add(term.diffuse, diffuse, surface.albedo, color, result.diffuse, share)
        _add(term.specular, specular, None, color, result.specular, share)
    if equation.clamp:
        np.clip(color, 0.0, 1.0, out=color)
    result.rgb[:] = color.T


def _add(
    coefficients: Vector, factor: Any, albedo: FloatArray | None, color: FloatArray, *shares: FloatArray | None
) -> None:
    """Add coefficient · factor · albedo, channel by channel, to the colour and to each share that is wanted.

    The colour holds vertices as columns, the shares as rows. A black channel is left out, exactly.
    """
    for channel, coefficient in enumerate(coefficients):
        if coefficient:
            product = color.dtype.type(coefficient) * factor
            if albedo is not None:
                product = product * albedo[channel]
            color[channel] += product
            for share in shares:
                if share is not None:
                    share[:, channel] += product


def _factors(surface: Surface, equation: Equation, term: LightTerm) -> tuple[Any, Any, Any]:
    """What one light's ambient, diffuse and specular colours are multiplied by: a·s times 1, n·l and fⁿ."""
    real = surface.raw.dtype.type
    arrival = term.light.arrival(surface.points, real)
    strength = np.minimum(arrival.strength * term.gain, BRIGHTEST).astype(real, copy=False)
    if not (any(term.diffuse) or any(term.specular)):
        return strength, 0.0, 0.0
    raw_n_l = _raw_cosine(surface.raw, arrival)
    n_l = raw_n_l * surface.inverse_length
    if equation.headlight_only:
        lit = strength * (surface.inverse_length > 0.0)  # the floor is not for a normal that is not there
        diffuse = np.maximum(n_l, real(equation.cosine_floor)) * lit
        distance: FloatArray = real(0.5) * _square(surface.normals - arrival.direction)
        specular = _power(distance, equation.shininess, equation.cosine_floor)
        return strength, diffuse, specular * lit
    diffuse = np.maximum(n_l, real(0.0))
    diffuse *= strength
    if not any(term.specular):
        return strength, diffuse, 0.0
    distance = _chord_distance(surface, equation, arrival.direction, raw_n_l)
    specular = _power(distance, equation.shininess, equation.cosine_floor)
    specular = specular * strength
    specular *= n_l > 0.0
    if surface.unseen is not False:
        specular[surface.unseen] = 0.0
    return strength, diffuse, specular


def _raw_cosine(raw: FloatArray, arrival: Arrival) -> Any:
    """N·l for the raw n. Its sign is that of n·D, D the way to the light, and exact where these products are."""
    way, inverse = arrival.way, arrival.inverse_length
    n_d = dot(raw, way)
    n_l = n_d * inverse
    if isinstance(inverse, np.ndarray):
        sizes, least = np.abs(n_d), _LEAST_PRODUCT[n_d.dtype.name]
        if sizes.min(initial=least) < least:  # the least floats round products of D, but less those of D near length 1
            small = sizes < least
            exponents = np.frexp(inverse[small])[1]
            n_d = dot(raw[:, small], np.ldexp(way[:, small], exponents))
            n_l[small] = n_d * np.ldexp(inverse[small], -exponents)
    return n_l


def _square(w: FloatArray) -> FloatArray:
    return dot(w, w)


def _chord_distance(surface: Surface, equation: Equation, l: FloatArray, raw_n_l: FloatArray) -> FloatArray:
    """½|D|² = 1 − f, for f = r·v (Phong) or n·h (Blinn-Phong)."""
    real, v = surface.raw.dtype.type, surface.to_viewer
    if equation.reflection == "phong":
        along = raw_n_l - surface.facing
        along *= along
        along += square_of_cross(surface.raw, l + v)
        along *= real(0.5) * surface.inverse_length * surface.inverse_length
        return along
    h = l + v
    square = _square(h)
    least = square.min(initial=1.0)
    if least < _SMALL:
        h *= real(_LARGER)
        square = _square(h)
    h *= real(1.0) / np.sqrt(np.maximum(square, np.finfo(real).tiny))
    distance = real(0.5) * _square(h - surface.normals)
    if least < _SMALL:  # opposite l and v have no half-way direction, and no highlight
        np.copyto(distance, 1.0, where=square == 0.0)
    return distance


def _power(distance: FloatArray, shininess: float, floor: float) -> Any:
    """max(f, floor)ⁿ for f = 1 − distance; 1 for n = 0, also where f is 0."""
    real = distance.dtype.type
    if shininess == 0.0:
        return real(1.0)
    logarithm = _log1p_of_negative(np.minimum(distance, real(1.0), out=distance))
    if floor:  # here, because 1 − floor would be rounded by far more than the floor's own last bit
        np.maximum(logarithm, real(math.log(floor)), out=logarithm)
    logarithm *= real(max(float(np.finfo(real).tiny), min(shininess, BRIGHTEST)))
    if real is np.float32:
        return np.exp(logarithm, out=logarithm)
    shows = logarithm > _DARK
    np.maximum(logarithm, _DARK, out=logarithm)
    power = np.exp(logarithm, out=logarithm)
    power *= shows
    return power


def _log1p_of_negative(d: FloatArray) -> Any:
    """log(1 − d) for 0 <= d <= 1, to full precision also near 0, in place of NumPy's slower log1p.

    With f the rounded 1 − d and e = (f − 1) + d its error, log(1 − d) = log(f − e) = log f − e/f + O(e²);
    f − 1 is exact (Sterbenz), or e is far below the last bit.
    """
    f = 1.0 - d
    error = f - 1.0
    error += d
    error /= np.maximum(f, np.finfo(f.dtype).tiny)
    logarithm = np.log(f, out=f)
    logarithm -= error
    return logarithm
