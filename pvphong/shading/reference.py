"""The lighting equation in NumPy, written to be read next to the model that it implements.

Symbols: p a vertex, n its unit normal, v the unit vector to the viewer, l the unit vector to a light, and a·s the
attenuation times spot factor of each light. Arrays hold a block of vertices as columns, (3, block). `Light.arrival`
computes the light that arrives, `Reflectance.factors` the part that is reflected. For an area light with a closed form,
`Light.analytic_integral` computes both at once.

Positions are transformed and subtracted in float64, for any precision of the result: the vector from a vertex to a
light is then exact to the last bit of the stored coordinates, even far from the origin. The rest is computed in the
precision of the result.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
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
    """Lit colours of n vertices; linear RGB, 1.0 = full, in the chosen precision.

    For Dask arrays, the attributes are Dask arrays too; `dask.compute(shading)` returns a tuple with a `Shading` of
    NumPy arrays.

    Attributes
    ----------
    rgb : ndarray
        Shape (n, 3). In [0, 1], unless the light model does not clamp.
    ambient, diffuse, specular, emission : ndarray or None
        Shape (n, 3), unclamped; they add up to the unclamped colour. `ambient` contains the light model's and the
        lights' ambient light. If components were not requested, these arrays and those below are None.
    per_light : ndarray or None
        Shape (n_lights, n, 3), unclamped: each light's ambient, diffuse and specular contribution, in the order of
        the scene's lights; zero for a light that is off.
    base : ndarray or None
        Shape (n, 3), unclamped: colour that is independent of lights, the emission and the light model's ambient.
        ``base + per_light.sum(axis=0)`` is the unclamped colour without bounced light.
    bounced : ndarray or None
        Shape (bounces, n, 3), unclamped: light that has bounced once, twice and so on. The last row includes the
        remaining ambient light. With bounces, `ambient` and `base` contain no ambient light.

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

    def part(self, rows: slice) -> Shading:
        """Return the lit colours of the vertices in the slice `rows`, as views of these arrays."""
        return self._of_each(lambda array: array[..., rows, :])

    def copy(self) -> Shading:
        """Return a copy of the record and its arrays."""
        return self._of_each(np.copy)

    def _of_each(self, change: Callable[[NDArray[Any]], NDArray[Any]]) -> Shading:
        changed: dict[str, Any] = {name: None if each is None else change(each) for name, each in vars(self).items()}
        return Shading(**changed)

    @classmethod
    def empty(cls, count: int, lights: int, real: np.dtype[Any], equation: Equation | None = None) -> Shading:
        """Allocate arrays for `count` vertices and `lights` lights, with the NumPy type `real`.

        Only `rgb` is allocated unless an equation is given, of which the components are to be computed. Arrays to which
        the equation adds nothing are zeros, which take no memory until they are written; so is `per_light` if a light
        adds nothing. The others are not initialised.
        """
        rgb = np.empty((count, 3), real)
        if equation is None:
            return cls(rgb)
        shares = equation.shares
        components, lit = {share.component for share in shares}, {share.light for share in shares}
        names = "ambient", "diffuse", "specular", "emission"
        of_components = {name: _new(name in components, (count, 3), real) for name in names}
        per_light = _new(lit.issuperset(range(lights)), (lights, count, 3), real)
        return cls(rgb, **of_components, per_light=per_light, base=_new(None in lit, (count, 3), real))


def _new(is_lit: bool, shape: tuple[int, ...], real: np.dtype[Any]) -> FloatArray:
    array: FloatArray = np.empty(shape, real) if is_lit else np.zeros(shape, real)
    return array


# Vertices per block: large enough that NumPy's cost per call is small, small enough for the caches.
BLOCK = 32768
# Vertices per evaluation of an integral over a light.
_INTEGRATED = 2048


class Block(NamedTuple):
    """A block of vertices, in the form that the equation reads. Fields that the equation does not need are empty."""

    points: Float64Array
    surface: Surface
    unseen: Any
    """Array (block,): True where there is no unit vector v to the viewer, because the eye is on the vertex or the
    vertex is not finite. The scalar False if v exists everywhere."""
    seen: FloatArray | None
    """Visible part of each light, and of the sky in the last row, shape (lights + 1, block); None if not needed. If
    normals are turned towards the viewer, it is the part that is visible from the side facing the viewer."""
    tints: dict[str, FloatArray]
    """Factors of colours, shape (3, block), by name. "albedo" multiplies ambient light. "diffuse", which includes the
    albedo, multiplies the lobes that take the albedo. "specular" multiplies the highlights, "emission" the emission."""


def shade(
    points: FloatArray,
    normals: FloatArray,
    equation: Equation,
    tints: Mapping[str, Tint],
    result: Shading,
    channels: FloatArray | None = None,
) -> None:
    """Evaluate the equation at every vertex and write the colours into the arrays of `result`.

    This is done block by block. Vertices are independent of each other, so the block size does not change any bit.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3), float32 or float64, of any memory layout.
    equation : Equation
        The equation.
    tints : mapping
        Result of `Vertices.tints`.
    result : Shading
        Receives the colours: its arrays are overwritten. Their type determines the precision.
    channels : ndarray, optional
        Shape (k, n): further numbers per vertex, with rows as in `equation.channels`.
    """
    is_uniform = not (equation.needs_points or equation.needs_normals or equation.is_occluded or tints)
    for start in range(0, len(points), BLOCK):
        part = slice(start, start + BLOCK)
        own_result = result.part(part)
        if start and is_uniform:  # all vertices are alike
            for name, view in vars(own_result).items():
                if view is not None:
                    view[:] = getattr(result, name)[..., : view.shape[-2], :]
            continue
        own_tints = {name: tint.at(part).factors(result.rgb.dtype.type) for name, tint in tints.items()}
        own = None if channels is None else channels[:, part].astype(result.rgb.dtype, copy=False)
        with np.errstate(divide="ignore", under="ignore", over="ignore"):
            block = _block(points[part], normals[part], own_tints, own, equation, result.rgb.dtype.type)
            _shade_block(block, equation, own_result)


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
    """Return the visible part of each light, and of the sky in the last row, for the side that the viewer sees.

    The shape is (lights + 1, n).

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3).
    equation : Equation
        An equation with visibility among its channels.
    channels : ndarray
        Shape (k, n), with rows as in `equation.channels`.
    """
    parts = [slice(start, start + BLOCK) for start in range(0, max(len(points), 1), BLOCK)]
    blocks = (_block(points[part], normals[part], {}, channels[:, part], equation, np.float64) for part in parts)
    with np.errstate(divide="ignore", under="ignore", over="ignore"):
        return np.concatenate([block.seen for block in blocks if block.seen is not None], axis=1)


def _shade_block(block: Block, equation: Equation, result: Shading) -> None:
    """Evaluate the equation for a block, and write the colours into the arrays of `result`.

    The colour is the sum of the emission, the ambient light, and each light's contribution, lobe by lobe.
    """
    real, reflectance = result.rgb.dtype.type, equation.reflectance
    for array in vars(result).values():
        if array is not None:
            array[:] = 0.0
    color = np.zeros((3, len(result.rgb)), real)
    tints, albedo = block.tints, block.tints.get("albedo")
    _add(equation.emission, 1.0, tints.get("emission"), color, result.emission, result.base)
    sky: Any = block.seen[-1] if equation.is_occluded and block.seen is not None else 1.0
    _add(equation.ambient, sky, albedo, color, result.ambient, result.base)
    for term in equation.terms:
        share = None if result.per_light is None else result.per_light[term.index]
        wanted = [any(coefficients) for coefficients in term.colors]
        if term.light.has_size:  # only lobes with a closed form, and no ambient light: see `in_parts`
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
    """Return the factor of each lobe of a reflectance at n vertices, as a new array of shape (n,).

    The factor multiplies the light that arrives from one direction, `arrival`, at each vertex of `surface`. `wanted`
    has a flag for each lobe; the factors of lobes that are not wanted are arbitrary.
    """
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
    with np.errstate(invalid="ignore", divide="ignore"):  # in the branch that `where` discards
        return type(reflectance).factors(numbers, at, highlight)


def tint_of(lobe: Lobe, tints: Mapping[str, FloatArray], surface: Surface) -> FloatArray | None:
    """Return the factors, shape (3, n), by which maps multiply the colour of `lobe`; None if they are 1 everywhere.

    `tints` has the factors of colours by name, as `Block.tints`.
    """
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
    """Add the product of coefficient, factor and tint to `color`, and to each array in `shares` that is not None.

    The coefficients are a colour, `factor` is a number per vertex, and `tint` a colour per vertex, or None for 1.
    Vertices are columns in `color` and `tint`, and rows in the shares. Channels whose coefficient is 0 are skipped.
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
    """Yield the integral of each lobe over the area light of `term`, times the term's gain.

    Terms of the integral cancel, so it is computed in float64. The integral covers the whole light; the caller
    multiplies it by the visible part.
    """
    real = block.surface.raw.dtype.type
    for form, color in zip(reflectance.forms, term.colors, strict=True):
        integral = term.light.analytic_integral(form) if form is not None and any(color) else None
        if form is None or integral is None:
            yield 0.0
            continue
        found = _integrated(integral, form, block, rounded=real is np.float32)
        yield np.minimum(found * term.gain, BRIGHTEST).astype(real, copy=False)


def _integrated(integral: Integral, form: CosinePower, block: Block, *, rounded: bool) -> Float64Array:
    """Return the integral of one lobe over an area light, at each vertex of a block, shape (n,).

    `form` is the lobe as a power of a cosine. With `rounded`, float32's accuracy suffices. Few vertices are evaluated
    at a time, so that temporaries stay in the caches.
    """
    n, lobe = block.surface.exact_normals, lobe_numbers(form.power, rounded=rounded)
    a = block.surface.mirrored if form.around == "mirror" and form.power else n  # 0⁰ is 1 in the whole hemisphere
    result = np.zeros(n.shape[1])
    a, p = (np.broadcast_to(w if w.shape[1] else 0.0, n.shape) for w in (a, block.points))
    with np.errstate(all="ignore"):  # in the branch that `where` discards
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
