"""The lighting equation in NumPy, written to be read beside the model it implements.

Symbols: p a vertex, n its unit normal, v the unit vector to the viewer, l the unit vector to a light, and
for each light a·s its attenuation times spot factor. Arrays hold a block of vertices as columns, (3, block). What
arrives from a light is the light's to say (`Light.arrival`), what of it is reflected is the reflectance's
(`Reflectance.factors`). A light with a size gives both at once where it has the integral (`Light.closed`).

Positions are moved and subtracted from each other in float64, whatever the precision of the result: a light's
difference to a vertex far from the origin is then exact to the last bit of the stored coordinates. What
follows is computed in the precision of the result.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pvphong.base.formulas import BRIGHTEST, chord_power
from pvphong.base.types import Float64Array, FloatArray, Vector
from pvphong.base.vectors import columns, dot, moderate, towards
from pvphong.geometry.transform import transform_normals, transform_points
from pvphong.optics.area.lobes import CosinePower, lobe_numbers, may_rise, shows
from pvphong.optics.light import Arrival, Integral
from pvphong.optics.reflectance import LAMBERT, Geometry, Lobe, Reflectance
from pvphong.optics.surface import Surface
from pvphong.shading.equation import Equation, LightTerm
from pvphong.shading.vertices import Tint


@dataclass(frozen=True, eq=False, repr=False)
class Shading:
    """Lit colours of n vertices; linear RGB, 1.0 = full, in the precision that the caller chose.

    Of Dask arrays, the arrays are Dask's too; `dask.compute(shading)` gives one of NumPy arrays, in a tuple.

    Attributes
    ----------
    rgb : ndarray
        Shape (n, 3). In [0, 1], unless the light model says not to clamp.
    ambient, diffuse, specular, emission : ndarray or None
        Shape (n, 3), unclamped; they add up to the unclamped colour. `ambient` holds the light model's and
        the lights'. None unless components were wanted, as all that follow.
    per_light : ndarray or None
        Shape (n_lights, n, 3), unclamped: each light's ambient, diffuse and specular share, in the order of
        the scene's lights; a light that is off has a share of zero.
    base : ndarray or None
        Shape (n, 3), unclamped: what is there without any light: emission and the light model's ambient.
        ``base + per_light.sum(axis=0)`` is the unclamped colour, but for light that bounces.
    bounced : ndarray or None
        Shape (bounces, n, 3), unclamped: what has bounced once, twice and so on; the rest of the ambient light is in
        the last. Where light bounces, `ambient` and `base` have no ambient light.

    Examples
    --------
    >>> import numpy as np, pvphong as ph
    >>> shading = ph.evaluate(np.zeros((1, 3)), [[0, 0, 1]], ph.DirectionalLight(), ph.Material())
    >>> shading.rgb.shape
    (1, 3)
    """

    rgb: NDArray[Any]
    ambient: FloatArray | None = None
    diffuse: FloatArray | None = None
    specular: FloatArray | None = None
    emission: FloatArray | None = None
    per_light: FloatArray | None = None
    base: FloatArray | None = None
    bounced: FloatArray | None = None

    def __repr__(self) -> str:
        parts = "" if self.per_light is None else f", components of {len(self.per_light)} lights"
        return f"<Shading of {self.rgb.shape[0]} vertices, {self.rgb.dtype}{parts}>"

    @classmethod
    def empty(cls, count: int, lights: int, real: np.dtype[Any], *, components: bool) -> Shading:
        """Arrays for so many vertices and lights: colours to be written, components to be added to."""
        rgb = np.empty((count, 3), real)
        if not components:
            return cls(rgb)
        ambient, diffuse, specular, emission, base = (np.zeros((count, 3), real) for _ in range(5))
        per_light = np.zeros((lights, count, 3), real)
        return cls(rgb, ambient, diffuse, specular, emission, per_light, base)


# Vertices per block: large enough that NumPy's cost per call is small, small enough for the caches.
BLOCK = 32768
# Vertices that an integral over a light is taken for at a time.
_INTEGRATED = 2048


class Block(NamedTuple):
    """Vertices, ready to be lit; what the equation does not need is not there."""

    points: Float64Array
    surface: Surface
    unseen: Any
    """Where v does not exist (the eye on the vertex, or a vertex that is not finite); False for nowhere."""
    seen: FloatArray | None
    """Parts of each light, and in the last row of the sky, that nothing blocks; None where that is not needed. Where
    normals are turned to the viewer, they are those of the side that he sees."""
    tints: dict[str, FloatArray]
    """What colours are multiplied by, (3, block): "albedo" the ambient ones, "diffuse" those that take albedo,
    "specular" and "emission"."""


def shade(
    points: FloatArray,
    normals: FloatArray,
    equation: Equation,
    tints: Mapping[str, Tint],
    result: Shading,
    channels: FloatArray | None = None,
) -> None:
    """Evaluate the equation at every vertex, block by block, into the arrays of `result`.

    Vertices are independent of each other, so the size of the blocks changes no bit.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3), float32 or float64, of any memory layout.
    equation : Equation
        What to evaluate.
    tints : mapping
        What `Vertices.tints` gives.
    result : Shading
        `rgb` is filled in, the others are added to; their type is the precision.
    channels : ndarray, optional
        Shape (k, n): what `equation.channels` says.
    """
    is_even = not (equation.needs_points or equation.needs_normals or equation.is_occluded or tints)
    for start in range(0, len(points), BLOCK):
        part = slice(start, start + BLOCK)
        views: dict[str, Any] = {name: a if a is None else a[..., part, :] for name, a in vars(result).items()}
        if start and is_even:  # all vertices are alike
            for name, view in views.items():
                if view is not None:
                    view[:] = getattr(result, name)[..., : view.shape[-2], :]
            continue
        own_tints = {name: tint.at(part).factors(result.rgb.dtype.type) for name, tint in tints.items()}
        own = None if channels is None else channels[:, part].astype(result.rgb.dtype, copy=False)
        with np.errstate(divide="ignore", under="ignore", over="ignore"):
            block = _block(points[part], normals[part], own_tints, own, equation, result.rgb.dtype.type)
            _shade_block(block, equation, Shading(**views))


def _block(
    points: FloatArray,
    normals: FloatArray,
    tints: dict[str, FloatArray],
    channels: FloatArray | None,
    equation: Equation,
    real: Any,
) -> Block:
    matrix, p, v = equation.matrix, np.zeros((3, 0)), np.array(equation.to_eye)[:, None]
    unseen: Any = False
    raw = inverse_length = np.zeros((3, 0), real)
    if equation.needs_points:
        p = columns(points if matrix is None else transform_points(points, matrix))
    if equation.eye is not None and equation.needs_eye:
        v, distance = towards(equation.eye, p, real)
        unseen = False if distance.min(initial=1.0) > 0.0 else ~(distance > 0.0)
    if equation.needs_normals:
        if equation.turns_normals and matrix is not None:
            normals = transform_normals(normals, matrix)
        raw, inverse_length = moderate(normals.T, real)
    is_behind: Any = False
    if equation.is_flipped:
        is_behind = dot(raw, equation.toward_viewer(v)) < 0.0
        raw = np.where(is_behind, -raw, raw)
    if "albedo" in tints:
        tints = tints | {"diffuse": tints["albedo"] * tints.get("diffuse", real(1.0))}
    of = {} if channels is None else {kind: channels[rows] for kind, rows in equation.channels.items()}
    if equation.is_flipped and "visibility" in of:
        front, behind = np.split(of["visibility"], 2)
        of["visibility"] = np.where(is_behind, behind, front)
    maps = {name: of[name][0] for name in equation.maps if name in of}
    surface = Surface(raw, inverse_length, v.astype(real, copy=False), of.get("tangents"), maps)
    return Block(p, surface, unseen, of.get("visibility"), tints)


def seen_by_viewer(points: FloatArray, normals: FloatArray, equation: Equation, channels: FloatArray) -> FloatArray:
    """What of each light, and in the last row of the sky, the side sees that the viewer sees, shape (lights + 1, n).

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3).
    equation : Equation
        What is evaluated, with visibility among its channels.
    channels : ndarray
        Shape (k, n): what `equation.channels` says.
    """
    parts = [slice(start, start + BLOCK) for start in range(0, max(len(points), 1), BLOCK)]
    blocks = (_block(points[part], normals[part], {}, channels[:, part], equation, np.float64) for part in parts)
    with np.errstate(divide="ignore", under="ignore", over="ignore"):
        return np.concatenate([block.seen for block in blocks if block.seen is not None], axis=1)


def _shade_block(block: Block, equation: Equation, result: Shading) -> None:
    """The equation itself: emission, ambient light, and each light's share lobe by lobe."""
    real, reflectance = result.rgb.dtype.type, equation.reflectance
    color = np.zeros((3, len(result.rgb)), real)
    tints, albedo = block.tints, block.tints.get("albedo")
    _add(equation.emission, 1.0, tints.get("emission"), color, result.emission, result.base)
    sky: Any = block.seen[-1] if equation.is_occluded and block.seen is not None else 1.0
    _add(equation.ambient, sky, albedo, color, result.ambient, result.base)
    for term in equation.terms:
        share = None if result.per_light is None else result.per_light[term.index]
        wanted = [any(coefficients) for coefficients in term.colors]
        if term.light.has_size:  # with lobes alone that it has a closed form for, see `in_parts`; it has no ambient
            factors, strength = tuple(_integrals(block, reflectance, term)), real(1.0)
        else:
            arrival = term.light.arrival(block.points, real)
            strength = np.minimum(arrival.strength * term.gain, BRIGHTEST).astype(real, copy=False)
            _add(term.ambient, strength * sky, albedo, color, result.ambient, share)
            factors = lobe_factors(reflectance, block.surface, arrival, wanted) if any(wanted) else (0.0,) * len(wanted)
        if term.is_shadowed and block.seen is not None:
            strength = strength * block.seen[term.index]
        for k, lobe in enumerate(reflectance.lobes):
            if not wanted[k]:
                continue
            factor = factors[k] * strength
            if lobe.needs_viewer and block.unseen is not False:
                factor[block.unseen] = 0.0
            tint = tint_of(lobe, tints, block.surface)
            _add(term.colors[k], factor, tint, color, getattr(result, lobe.component), share)
    if equation.gamma != 1.0:
        color = np.maximum(color, 0.0) ** real(1.0 / equation.gamma)
    if equation.clamp:
        np.clip(color, 0.0, 1.0, out=color)
    result.rgb[:] = color.T


def lobe_factors(
    reflectance: Reflectance, surface: Surface, arrival: Arrival, wanted: Sequence[bool]
) -> tuple[Any, ...]:
    """Factor of each lobe at n vertices, a new array (n,); of a lobe that is not wanted anything."""
    n_l = surface.cosine(arrival)
    if not any(wanted[1:]) and reflectance.lobes[0] is LAMBERT:
        return (np.maximum(n_l, n_l.dtype.type(0.0)), *(0.0,) * (len(wanted) - 1))
    tangents = surface.tangents if "tangents" in reflectance.needs else None
    to_viewer, cosine = surface.to_viewer, surface.facing
    at = Geometry(surface.raw, surface.inverse_length, n_l, cosine, arrival.direction, to_viewer, tangents)
    highlight, power = None, reflectance.power(surface.maps)
    if power is not None and reflectance.peak is not None:
        square = np.broadcast_to(reflectance.peak.square(at), n_l.shape)
        highlight = chord_power(square, power.exponent, power.floor)
    numbers = tuple(np.asarray(number, n_l.dtype) for number in reflectance.parameters(surface.maps))
    with np.errstate(invalid="ignore", divide="ignore"):  # of two sides, one of which is then chosen
        return type(reflectance).factors(numbers, at, highlight)


def tint_of(lobe: Lobe, tints: Mapping[str, FloatArray], surface: Surface) -> FloatArray | None:
    """What a lobe's colour is multiplied by; None where it is the same everywhere."""
    if lobe.takes_albedo:
        found = tints.get("diffuse")
        if lobe.tint is None or (found is None and not surface.maps):
            return found
        albedo = np.ones((3, 1), surface.raw.dtype) if found is None else found
        return np.broadcast_to(lobe.tint(albedo, surface.maps), (3, surface.raw.shape[1]))
    return None if lobe.is_own else tints.get(lobe.component)


def _add(
    coefficients: Vector, factor: Any, tint: FloatArray | None, color: FloatArray, *shares: FloatArray | None
) -> None:
    """Add coefficient · factor · tint, channel by channel, to the colour and to each share that is wanted.

    The colour holds vertices as columns, the shares as rows. A black channel is left out, exactly.
    """
    for channel, coefficient in enumerate(coefficients):
        if coefficient:
            product = color.dtype.type(coefficient) * factor
            if tint is not None:
                product = product * tint[channel]
            color[channel] += product
            for share in shares:
                if share is not None:
                    share[:, channel] += product


def _integrals(block: Block, reflectance: Reflectance, term: LightTerm) -> Iterator[Any]:
    """Each lobe's integral over all of a light with a size, times its strength; in float64, for they have differences.

    Where a part of the light is seen, that is the same part of all that it sends.
    """
    real = block.surface.raw.dtype.type
    for form, color in zip(reflectance.forms, term.colors, strict=True):
        integral = term.light.closed(form) if form is not None and any(color) else None
        if form is None or integral is None:
            yield 0.0
            continue
        found = _integrated(integral, form, block, rounded=real is np.float32)
        yield np.minimum(found * term.gain, BRIGHTEST).astype(real, copy=False)


def _integrated(integral: Integral, form: CosinePower, block: Block, *, rounded: bool) -> Float64Array:
    """Shape (n,); some vertices at a time, so that what a formula needs of them stays in the processor's caches."""
    n, lobe = block.surface.exact_normals, lobe_numbers(form.power, rounded=rounded)
    a = block.surface.mirrored if form.around == "mirror" and form.power else n  # 0⁰ is 1 all over the hemisphere
    result = np.zeros(n.shape[1])
    a, p = (np.broadcast_to(w if w.shape[1] else 0.0, n.shape) for w in (a, block.points))
    with np.errstate(all="ignore"):  # of two sides, one of which is then chosen
        d = np.array(integral.place)[:, None] - p
        is_lit = may_rise(n, d, integral.radius)
        if form.around == "mirror":
            is_lit &= shows(lobe, a, d, np.sqrt(dot(d, d)), integral.radius)
        (lit,) = np.nonzero(is_lit)
        for start in range(0, len(lit), _INTEGRATED):
            some = slice(start, start + _INTEGRATED)
            rows = some if len(lit) == len(result) else lit[some]
            result[rows] = integral.formula(integral.numbers, lobe, d[:, rows], n[:, rows], a[:, rows])
    return result
