"""The lighting model in exact fractions and 80 digits: the reference for the evaluators.

Written from the model's equations alone. Every stored float is taken exactly, so dot products, cofactors and the
signs and comparisons made of them are exact; roots, powers and cosines are taken once, of exact numbers, in forms
that do not cancel. That holds for exponents over the whole float64 range. (The one exception: a light given in
camera coordinates is placed in the world with 100 digits, because the eye's axes have irrational lengths.)

Symbols: n the normal, l the vector to the light, v the vector to the viewer, r = 2(n·l)n − l, h = (l + v)/|l + v|.
Raw vectors are not unit length; a cosine of raw vectors is their dot product over the root of their squares.
"""

from __future__ import annotations

import math
import pickle
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from typing import Any

import mpmath
import numpy as np

ctx = mpmath.MPContext()
ctx.dps = 80
_placing = mpmath.MPContext()
_placing.dps = 100

Exact = tuple[Fraction, Fraction, Fraction]
Real = Any  # an mpf of `ctx`
Rgb = tuple[Real, Real, Real]

ZERO = ctx.mpf(0)
ONE = ctx.mpf(1)
BLACK: Rgb = (ZERO, ZERO, ZERO)

VTK_FLOOR = ctx.mpf("1e-5")  # of the mirror cosine
VTK_HEADLIGHT_FLOOR = ctx.mpf("1e-6")  # of the diffuse factor in tier 1
VTK_LARGEST_POWER = 128.0


@dataclass(frozen=True)
class LightFacts:
    """Effect of a switched-on light at a vertex; `None` for quantities that do not exist.

    n_dot_l : cosine between normal (flipped if two-sided turned it) and the direction to the light.
    strength : intensity · attenuation · spot factor.
    distance : to a positional light.
    cone_margin : cos(angle to the axis) − cos(cone angle) of a spot; ≥ 0 is inside.
    spot_cosine : cos(angle to the axis) of a spot.
    highlight : the cosine that is raised to the shininess (r·v or n·h), before any floor.
    """

    n_dot_l: Real | None = None
    strength: Real | None = None
    distance: Real | None = None
    cone_margin: Real | None = None
    spot_cosine: Real | None = None
    highlight: Real | None = None


@dataclass(frozen=True)
class Shade:
    """One vertex: colours are triples of 80-digit numbers, `lights` has one entry per light of the scene."""

    unclamped: Rgb
    color: Rgb
    ambient: Rgb
    diffuse: Rgb
    specular: Rgb
    emission: Rgb
    per_light: tuple[Rgb, ...]
    n_dot_v: Real | None
    lights: tuple[LightFacts, ...]


def as_array(shades: Sequence[Shade], name: str) -> np.ndarray:
    """A field of every vertex, rounded to float64: (n, 3), or (n_lights, n, 3) for ``per_light``."""
    if name == "per_light":
        rows = [[[float(c) for c in rgb] for rgb in shade.per_light] for shade in shades]
        return np.array(rows, dtype=np.float64).reshape(len(shades), -1, 3).transpose(1, 0, 2)
    return np.array([[float(c) for c in getattr(shade, name)] for shade in shades], dtype=np.float64).reshape(-1, 3)


# --- exact vectors ---------------------------------------------------------------------------------------------


def exact(values: Iterable[Any]) -> Exact:
    x, y, z = (Fraction(float(value)) for value in values)  # a NaN or infinity raises
    return x, y, z


def dot(a: Exact, b: Exact) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Exact, b: Exact) -> Exact:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def minus(a: Exact, b: Exact) -> Exact:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scaled(a: Exact, factor: Fraction | int) -> Exact:
    return a[0] * factor, a[1] * factor, a[2] * factor


def real(x: Fraction) -> Real:
    return ctx.mpf(x.numerator) / ctx.mpf(x.denominator)


def root(x: Fraction) -> Real:
    return ctx.sqrt(real(x))


def cosine(a: Exact, b: Exact) -> Real:
    return real(dot(a, b)) / root(dot(a, a) * dot(b, b))


def sum_of_roots(a: Fraction, big_a: Fraction, b: Fraction, big_b: Fraction) -> Real:
    """a/√A + b/√B to full relative accuracy."""
    if a * b >= 0:
        return real(a) / root(big_a) + real(b) / root(big_b)
    return real(a * a / big_a - b * b / big_b) / (real(a) / root(big_a) - real(b) / root(big_b))


def power(sin2: Any, cos2: Any, exponent: float) -> Real:
    """cosⁿ of an angle in [0°, 90°], given its squared sine and cosine, each to full relative accuracy; 0⁰ = 1."""
    if exponent == 0:
        return ONE
    if cos2 == 0:
        return ZERO
    sin2, cos2 = (real(x) if isinstance(x, Fraction) else x for x in (sin2, cos2))
    log_cos2 = ctx.log1p(-sin2) if sin2 < 0.5 else ctx.log(cos2)
    return ctx.exp(ctx.mpf(exponent) / 2 * log_cos2)


# --- colours ---------------------------------------------------------------------------------------------------


def rgb(color: Any) -> Rgb:
    if np.ndim(color) == 0:
        return (ctx.mpf(float(color)),) * 3
    red, green, blue = (ctx.mpf(float(c)) for c in color)
    return red, green, blue


def times(*colors: Rgb) -> Rgb:
    red, green, blue = (math.prod(channel, start=ONE) for channel in zip(*colors, strict=True))
    return red, green, blue


def dim(color: Rgb, factor: Real) -> Rgb:
    return color[0] * factor, color[1] * factor, color[2] * factor


def plus(*colors: Rgb) -> Rgb:
    red, green, blue = (sum(channel, ZERO) for channel in zip(*colors, strict=True))
    return red, green, blue


def clamped(color: Rgb) -> Rgb:
    red, green, blue = (min(max(c, ZERO), ONE) for c in color)
    return red, green, blue


def clean_albedo(row: Any) -> Rgb:
    red, green, blue = (
        ZERO if math.isnan(value) else ctx.mpf(min(max(value, 0.0), 1.0)) for value in (float(x) for x in row)
    )
    return red, green, blue


# --- placing: matrix, viewer, lights ---------------------------------------------------------------------------


class Placement:
    """Model to world: points by M, normals by its inverse-transpose with the right sign."""

    def __init__(self, matrix: Any) -> None:
        rows = [[Fraction(float(x)) for x in row] for row in np.asarray(matrix, dtype=np.float64)]
        if any(rows[3][:3]) or rows[3][3] == 0:
            raise ValueError("not affine")
        self.w = rows[3][3]
        self.linear: list[Exact] = [(row[0], row[1], row[2]) for row in rows[:3]]
        self.offset: Exact = (rows[0][3], rows[1][3], rows[2][3])
        x, y, z = self.linear
        self.cofactors = [cross(y, z), cross(z, x), cross(x, y)]
        determinant = dot(x, self.cofactors[0])
        if not any(any(row) for row in self.cofactors):
            raise ValueError("rank below 2")
        # The inverse-transpose of L/w is w·C/det L; a flattened mesh (det = 0) takes the cofactors' own direction.
        self.sign = -1 if determinant * self.w < 0 else 1

    def point(self, p: Exact) -> Exact:
        x, y, z = ((dot(row, p) + shift) / self.w for row, shift in zip(self.linear, self.offset, strict=True))
        return x, y, z

    def normal(self, n: Exact) -> Exact:
        x, y, z = (self.sign * dot(row, n) for row in self.cofactors)
        return x, y, z


def _fraction(x: Real) -> Fraction:
    sign, mantissa, exponent, _ = x._mpf_
    value = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    return -value if sign else value


def _unit(a: Exact) -> Exact:
    """Normalise a vector, with an exact direction: rounding would give a light opposite to the viewer a half vector."""
    square = dot(a, a)
    return scaled(a, _fraction(_placing.sqrt(_placing.mpf(square.denominator) / _placing.mpf(square.numerator))))


class Eye:
    """The viewer: its position, view direction and orthonormal axes."""

    def __init__(self, viewer: Any) -> None:
        self.position = exact(viewer.position)
        self.looking = minus(exact(viewer.focal_point), self.position)
        self.parallel = bool(viewer.parallel)
        self._up = exact(viewer.up)

    def to_world(self, eye_vector: Exact) -> Exact:
        """A vector from eye space (x right, y up, looking down −z)."""
        right = _unit(cross(self.looking, self._up))
        up = _unit(cross(cross(self.looking, self._up), self.looking))
        back = scaled(_unit(self.looking), -1)
        x, y, z = (eye_vector[0] * right[i] + eye_vector[1] * up[i] + eye_vector[2] * back[i] for i in range(3))
        return x, y, z


def is_positional(light: Any) -> bool:
    return hasattr(light, "attenuation")


def is_spot(light: Any) -> bool:
    return hasattr(light, "cone_angle")


def placed(light: Any, eye: Eye) -> tuple[Exact | None, Exact | None]:
    """World position (positional lights) and direction of travel (directional lights and spots)."""
    has_position, has_direction = is_positional(light), is_spot(light) or not is_positional(light)
    if light.frame == "headlight":
        return eye.position if has_position else None, eye.looking if has_direction else None
    position = exact(light.position) if has_position else None
    direction = exact(light.direction) if has_direction else None
    if light.frame == "camera":
        if position is not None:
            x, y, z = (a + b for a, b in zip(eye.position, eye.to_world(position), strict=True))
            position = (x, y, z)
        direction = None if direction is None else eye.to_world(direction)
    return position, direction


# --- one light at one vertex -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Arrival:
    """Return the raw vector from a vertex to a light (`None` on the vertex itself), and attenuation · spot."""

    to_light: Exact | None
    strength: Real
    facts: LightFacts


# cos² of the cone angles (degrees) whose squared sine is rational: these edges are decided exactly.
_RATIONAL_SIN2 = {30.0: Fraction(1, 4), 45.0: Fraction(1, 2), 60.0: Fraction(3, 4), 90.0: Fraction(1)}


def _in_cone(cos_sign: Fraction, sin2: Fraction, cone_angle: float) -> bool:
    if cos_sign < 0:
        return False
    if cone_angle in _RATIONAL_SIN2:
        return sin2 <= _RATIONAL_SIN2[cone_angle]
    return bool(real(sin2) <= ctx.sin(ctx.radians(ctx.mpf(cone_angle))) ** 2)


def _spot(to_light: Exact | None, axis: Exact, cone_angle: float, exponent: float) -> tuple[Real, LightFacts]:
    """The spot factor, with the cosine taken as 0 for a light on the vertex, which has no direction."""
    edge = ZERO if cone_angle == 90 else ctx.cos(ctx.radians(ctx.mpf(cone_angle)))
    if to_light is None:
        inside = cone_angle == 90
        factor = ONE if inside and exponent == 0 else ZERO
        return factor, LightFacts(spot_cosine=ZERO, cone_margin=-edge)
    along = -dot(to_light, axis)
    cos2 = along * along / (dot(to_light, to_light) * dot(axis, axis))
    cos = ctx.sign(real(along)) * root(cos2)
    factor = power(1 - cos2, cos2, exponent) if _in_cone(along, 1 - cos2, cone_angle) else ZERO
    return factor, LightFacts(spot_cosine=cos, cone_margin=cos - edge)


def _attenuation(light: Any, distance: Real) -> Real:
    constant, linear, quadratic = (ctx.mpf(float(x)) for x in light.attenuation)
    below = constant + linear * distance + quadratic * distance**2
    return ZERO if below == 0 else 1 / below  # 0 only on the vertex, with c = 0


def arrival(light: Any, position: Exact | None, axis: Exact | None, p: Exact, *, vtk: bool) -> Arrival:
    if position is None:
        assert axis is not None
        return Arrival(scaled(axis, -1), ONE, LightFacts())
    towards = minus(position, p)
    distance = root(dot(towards, towards))
    to_light = towards if distance else None
    reached = Arrival(to_light, _attenuation(light, distance), LightFacts(distance=distance))
    if axis is None or (vtk and light.cone_angle >= 90):
        return reached
    exponent = min(light.exponent, VTK_LARGEST_POWER) if vtk else light.exponent
    spot, facts = _spot(to_light, axis, light.cone_angle, exponent)
    return Arrival(to_light, reached.strength * spot, replace(facts, distance=distance))


def _mirror(n: Exact, to_light: Exact, v: Exact) -> tuple[Real, Fraction, Fraction]:
    """r·v, and its squared sine and cosine, which are rational: r·v = (2(n·l)(n·v)/n² − l·v)/√(l²v²)."""
    scale = dot(to_light, to_light) * dot(v, v)
    q = 2 * dot(n, to_light) * dot(n, v) / dot(n, n) - dot(to_light, v)
    return real(q) / root(scale), 1 - q * q / scale, q * q / scale


def phong(n: Exact, to_light: Exact, v: Exact, shininess: float) -> tuple[Real, Real]:
    """The cosine r·v, and max(r·v, 0)ⁿ."""
    cos, sin2, cos2 = _mirror(n, to_light, v)
    if cos <= 0:
        return cos, ONE if shininess == 0 else ZERO
    return cos, power(sin2, cos2, shininess)


def blinn_phong(n: Exact, to_light: Exact, v: Exact, shininess: float) -> tuple[Real, Real]:
    """The cosine n·h, and max(n·h, 0)ⁿ; the cosine counts as 0 where l = −v and h does not exist."""
    ll, vv, nn = dot(to_light, to_light), dot(v, v), dot(n, n)
    lv = dot(to_light, v)
    cos = real(lv) / root(ll * vv)
    sum2 = 2 + 2 * cos if lv >= 0 else 2 * real(1 - lv * lv / (ll * vv)) / (1 - cos)  # |l + v|² of unit vectors
    if sum2 == 0:
        return ZERO, ONE if shininess == 0 else ZERO
    n_dot_h = sum_of_roots(dot(n, to_light), nn * ll, dot(n, v), nn * vv) / ctx.sqrt(sum2)
    if n_dot_h <= 0:
        return n_dot_h, ONE if shininess == 0 else ZERO
    n_cross_l, n_cross_v = cross(n, to_light), cross(n, v)
    sines = [sum_of_roots(a, nn * ll, b, nn * vv) for a, b in zip(n_cross_l, n_cross_v, strict=True)]
    sin2 = sum((s * s for s in sines), ZERO) / sum2
    return n_dot_h, power(sin2, n_dot_h**2, shininess)


# --- a vertex --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Vertex:
    """A vertex in world space; `n` and `v` are `None` where the normal is zero or the eye is on the vertex."""

    p: Exact
    n: Exact | None
    v: Exact | None
    n_dot_v: Real | None


def _vertex(p: Exact, n: Exact, model: Any, eye: Eye) -> _Vertex:
    axis = scaled(eye.looking, -1)
    towards_eye = minus(eye.position, p)
    vtk = model.convention == "vtk"
    if vtk:
        v_light, v_flip = towards_eye, axis if eye.parallel else towards_eye
    else:
        v_light = v_flip = towards_eye if model.local_viewer and not eye.parallel else axis
    normal = n if any(n) else None
    n_dot_v = cosine(n, v_flip) if normal is not None and any(v_flip) else None
    if model.two_sided and normal is not None and dot(n, v_flip) < 0:
        normal = scaled(normal, -1)
    return _Vertex(p, normal, v_light if any(v_light) else None, n_dot_v)


@dataclass(frozen=True)
class _Term:
    """A light's ambient, diffuse and specular light at a vertex."""

    ambient: Rgb
    diffuse: Rgb
    specular: Rgb
    facts: LightFacts

    @property
    def total(self) -> Rgb:
        return plus(self.ambient, self.diffuse, self.specular)


_DARK = _Term(BLACK, BLACK, BLACK, LightFacts())


def _standard_term(light: Any, eye: Eye, vertex: _Vertex, material: Any, model: Any, albedo: Rgb) -> _Term:
    reached = arrival(light, *placed(light, eye), vertex.p, vtk=False)
    strength = reached.strength * ctx.mpf(float(light.intensity))
    ambient = dim(times(rgb(material.ambient), albedo, rgb(light.ambient)), strength)
    n, to_light, facts = vertex.n, reached.to_light, replace(reached.facts, strength=strength)
    if n is None or to_light is None:
        return _Term(ambient, BLACK, BLACK, facts)
    n_dot_l = cosine(n, to_light)
    diffuse = dim(times(rgb(material.diffuse), albedo, rgb(light.diffuse)), strength * max(n_dot_l, ZERO))
    highlight, lobe = None, ZERO
    if vertex.v is not None:
        reflect = phong if model.reflection == "phong" else blinn_phong
        highlight, lobe = reflect(n, to_light, vertex.v, material.shininess)
    light_specular = light.diffuse if light.specular is None else light.specular
    factor = strength * lobe if dot(n, to_light) > 0 else ZERO
    specular = dim(times(rgb(material.specular), rgb(light_specular)), factor)
    return _Term(ambient, diffuse, specular, replace(facts, n_dot_l=n_dot_l, highlight=highlight))


def vtk_tier(lights: Iterable[Any]) -> int:
    """Return VTK's light complexity; 0 if no light is on. A black light that is on counts.

    Measured with VTK 9.7.2: a light that is off counts as well if it has a position, or if it is no headlight and
    comes after one that is on.
    """
    listed = list(lights)
    on = [light for light in listed if light.on]
    if not on:
        return 0
    if any(is_positional(light) for light in listed):
        return 3
    behind = listed[listed.index(on[0]) :]
    return 1 if len(on) == 1 and all(light.frame == "headlight" for light in behind) else 2


def vtk_unlit(material: Any, albedo: Rgb) -> Rgb:
    """Return VTK's colour when no light is on: ambient + diffuse colour. All of it counts as the ambient component.

    Measured with VTK 9.7.2: ambient 0.3 and diffuse 0.4 on white draw 179/255 = 0.7. Which component holds it is
    not in VTK: no light's diffuse factor is in it, so it stands with what reaches a vertex whatever its normal.
    """
    return times(plus(rgb(material.ambient), rgb(material.diffuse)), albedo)


def _vtk_factors(tier: int, vertex: _Vertex, reached: Arrival, shininess: float) -> tuple[Real, Real, LightFacts]:
    """The diffuse and specular factors df and sf of a tier, and the facts behind them."""
    n, to_light, facts = vertex.n, reached.to_light, reached.facts
    if n is None or to_light is None:
        return ZERO, ZERO, facts
    exponent = min(shininess, VTK_LARGEST_POWER)
    n_dot_l = cosine(n, to_light)
    if tier == 1:  # the light shines along the view axis, so n·l is n's z in eye space
        df = max(VTK_HEADLIGHT_FLOOR, n_dot_l)
        return df, df ** ctx.mpf(exponent), replace(facts, n_dot_l=n_dot_l, highlight=n_dot_l)
    df = max(ZERO, reached.strength * n_dot_l)
    highlight, sf = None, ZERO
    if vertex.v is not None:
        highlight = _mirror(n, to_light, vertex.v)[0]
        lobe = phong(n, to_light, vertex.v, exponent)[1]
        floored = max(lobe, VTK_FLOOR ** ctx.mpf(exponent))  # cosⁿ grows with cos: floor after or before is one
        sf = reached.strength * floored if df > 0 else ZERO
    return df, sf, replace(facts, n_dot_l=n_dot_l, highlight=highlight)


def _vtk_term(tier: int, light: Any, eye: Eye, vertex: _Vertex, material: Any, albedo: Rgb) -> _Term:
    reached = arrival(light, *placed(light, eye), vertex.p, vtk=True)
    df, sf, facts = _vtk_factors(tier, vertex, reached, material.shininess)
    intensity = ctx.mpf(float(light.intensity))
    color = dim(rgb(light.diffuse), intensity)
    diffuse = dim(times(rgb(material.diffuse), albedo, color), df)
    specular = dim(times(rgb(material.specular), color), sf)
    return _Term(BLACK, diffuse, specular, replace(facts, strength=intensity * reached.strength))


def _terms(scene: Any, eye: Eye, vertex: _Vertex, material: Any, albedo: Rgb) -> tuple[Rgb, tuple[_Term, ...]]:
    """The ambient component that belongs to no light, then one term per light of the scene."""
    model = scene.light_model
    if model.convention == "vtk":
        tier = vtk_tier(scene.lights)
        base = times(rgb(material.ambient), albedo) if tier else vtk_unlit(material, albedo)
        terms = (_vtk_term(tier, light, eye, vertex, material, albedo) if light.on else _DARK for light in scene.lights)
        return base, tuple(terms)
    base = times(rgb(material.ambient), albedo, rgb(model.ambient))
    terms = (
        _standard_term(light, eye, vertex, material, model, albedo) if light.on else _DARK for light in scene.lights
    )
    return base, tuple(terms)


def shade(points: Any, normals: Any, scene: Any, material: Any, *, matrix: Any = None) -> list[Shade]:
    """Every vertex's colours, from the public fields of the scene's values; the albedo may be an array of rows.

    Raises ``ValueError`` or ``OverflowError`` for a NaN or infinite point or normal, and ``ValueError`` for a matrix
    that is not affine or flattens more than one dimension.
    """
    return list(_shades(pickle.dumps((points, normals, scene, material, matrix))))


@lru_cache(maxsize=1024)
def _shades(arguments: bytes) -> tuple[Shade, ...]:
    """Cached, because every evaluator is compared on the same cases."""
    points, normals, scene, material, matrix = pickle.loads(arguments)
    placement = Placement(np.eye(4) if matrix is None else matrix)
    eye = Eye(scene.viewer)
    emission = rgb(material.emission)
    albedo = np.broadcast_to(np.asarray(material.albedo), (len(points), 3))
    shades = []
    for point, normal, row in zip(np.asarray(points), np.asarray(normals), albedo, strict=True):
        tint = clean_albedo(row)
        vertex = _vertex(placement.point(exact(point)), placement.normal(exact(normal)), scene.light_model, eye)
        base, terms = _terms(scene, eye, vertex, material, tint)
        ambient = plus(base, *(term.ambient for term in terms))
        diffuse = plus(BLACK, *(term.diffuse for term in terms))
        specular = plus(BLACK, *(term.specular for term in terms))
        total = plus(ambient, diffuse, specular, emission)
        shades.append(
            Shade(
                unclamped=total,
                color=clamped(total) if scene.light_model.clamp else total,
                ambient=ambient,
                diffuse=diffuse,
                specular=specular,
                emission=emission,
                per_light=tuple(term.total for term in terms),
                n_dot_v=vertex.n_dot_v,
                lights=tuple(term.facts for term in terms),
            )
        )
    return tuple(shades)
