"""Importance sampling of area lights and skies, by formulas of two numbers u and v in [0, 1).

Each light has three formulas:

- `frame` runs once per vertex, in float64. It reads the light's numbers, the origin p of the rays and the unit normal
  n, which is zero if the vertex has no normal. It returns first the reach, which is the unit of the distances below;
  then the factor that turns a mean of weights into a colour; then the values that the other two formulas need.
- `sample` runs once per ray, in float32. It returns three things: the unit vector to a point of the light; the distance
  to the point as a fraction of the reach; and the weight, which is the contribution to a white surface's colour divided
  by the density of such points.
- `seen` is the inverse of `sample`, for rays that hit a light by chance; it runs only in NumPy. For a unit vector, it
  returns the distance to the light as a fraction of the reach, and the density per solid angle with which `sample`
  chooses this direction. The density is 0 where the ray misses the light.

If the density is nearly proportional to the contribution, the weights are nearly equal, and visibility is the main
source of noise. The maps from the square are continuous, so well-distributed points stay well distributed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from pvphong.base.formulas import (
    HALF,
    ONE,
    TWO,
    ZERO,
    arctan2,
    as_type_of,
    cosine,
    dot,
    formula,
    index,
    maximum,
    minimum,
    multiply_add,
    select,
    sine,
    single,
    sqrt,
    subtract,
    times,
)
from pvphong.base.types import Float64Array


class Sampling(NamedTuple):
    """Importance sampling of an area light of intensity 1: its three formulas, which the module docstring describes."""

    frame: Callable[..., Any]
    """Formula with three arguments: `numbers`, the origin p of the rays, and the unit normal n there."""

    sample: Callable[..., Any]
    """Formula with four arguments: `numbers`, a tuple of the results of `frame` from the third on, u, and v."""

    seen: Callable[..., Any]
    """Formula with three arguments: the first two arguments of `sample`, and a unit vector."""

    numbers: Sequence[float] | Float64Array
    """Numbers of the light, which the formulas read by index."""


# Tolerance at a light's edge, relative to its size: directions are rounded.
_SLACK = 1e-6

# --- common formulas


@formula
def _polynomial(q: Any, coefficients: Any) -> Any:
    """Evaluate a polynomial in q. `coefficients` are constants, from the highest power to the lowest."""
    total = as_type_of(q, coefficients[0])
    for k in range(1, len(coefficients)):
        total = multiply_add(total, q, as_type_of(q, coefficients[k]))
    return total


# Taylor series of cos(πt/4) and of sin(πt/4)/t in powers of t² for |t| <= 1. Errors are below 3e-8 and 2e-9.
_COSINE = tuple((-1) ** k * (math.pi / 4) ** (2 * k) / math.factorial(2 * k) for k in range(4, -1, -1))
_SINE = tuple((-1) ** k * (math.pi / 4) ** (2 * k + 1) / math.factorial(2 * k + 1) for k in range(4, -1, -1))


@formula
def on_disk(u: Any, v: Any) -> Any:
    """Map the point (u, v) of the unit square to a point of the unit disk; return its coordinates x and y.

    Concentric squares become circles that enclose the same fraction of the area. Source: P. Shirley and K. Chiu, "A low
    distortion map between disk and square" (1997).
    """
    a, b = TWO * u - ONE, TWO * v - ONE
    is_wide = a * a > b * b
    radius = select(is_wide, a, b)
    t = select(is_wide, b, a) / select(radius == ZERO, ONE, radius)
    c, s = radius * _polynomial(t * t, _COSINE), radius * (t * _polynomial(t * t, _SINE))
    return select(is_wide, c, s), select(is_wide, s, c)


@formula
def length_and_direction(d: Any) -> Any:
    """Return the length of the vector d, and the unit vector along it; 0 and the z axis if d is zero."""
    largest = maximum(maximum(maximum(d[0], -d[0]), maximum(d[1], -d[1])), maximum(d[2], -d[2]))
    is_zero = largest == 0.0
    over = 1.0 / select(is_zero, 1.0, largest)
    x, y, z = d[0] * over, d[1] * over, select(is_zero, 1.0, d[2] * over)
    length = sqrt(x * x + y * y + z * z)
    return largest * length, (x / length, y / length, z / length)


@formula
def orthogonals(w: Any) -> Any:
    """Return two unit vectors that are orthogonal to the unit vector w and to each other.

    Source: T. Duff et al., "Building an orthonormal basis, revisited" (2017).
    """
    sign = select(w[2] < 0.0, -1.0, 1.0)
    a = -1.0 / (sign + w[2])
    b = w[0] * w[1] * a
    return (1.0 + sign * w[0] * w[0] * a, sign * b, -sign * w[0]), (b, sign + w[1] * w[1] * a, -w[1])


@formula
def combined(x: Any, a: Any, y: Any, b: Any, z: Any, c: Any) -> Any:
    """Return the vector x·a + y·b + z·c, for numbers x, y, z and vectors a, b, c."""
    return (
        multiply_add(z, c[0], multiply_add(y, b[0], x * a[0])),
        multiply_add(z, c[1], multiply_add(y, b[1], x * a[1])),
        multiply_add(z, c[2], multiply_add(y, b[2], x * a[2])),
    )


# --- spheres: evenly within the cone in which they are seen


@formula
def sphere_frame(numbers: Any, p: Any, n: Any) -> Any:
    """Compute the values by which rays from a vertex sample a sphere light (`frame` in the module docstring).

    `numbers` has the centre and the radius. p is the origin of the rays, and n the normal there. From inside, the
    sphere fills all directions. Values for `sample`:

    - 0 to 8: the unit vector to the centre, and two unit vectors across it;
    - 9 to 11: the cosines of these three with the normal;
    - 12: 1 − the cosine of the cone's half-angle;
    - 13: the sign of the root in the ray's distance, 1 from inside, else −1;
    - 14: the distance to the centre, as a fraction of the reach.
    """
    distance, w = length_and_direction((numbers[0] - p[0], numbers[1] - p[1], numbers[2] - p[2]))
    radius = numbers[3]
    is_inside = distance <= radius
    sine = radius / select(is_inside, radius, distance)
    less = select(is_inside, 2.0, sine * sine / (1.0 + sqrt(1.0 - sine * sine)))  # 1 − cos of the cone
    across, up = orthogonals(w)
    scale = 2.0 * (less / radius / radius)  # the radiance 1/πr² times the cone's 2π (1 − cos)
    reach, side = select(is_inside, radius, distance), select(is_inside, 1.0, -1.0)
    return reach, scale, *w, *across, *up, dot(n, w), dot(n, across), dot(n, up), less, side, distance / reach


@formula
def patch_frame(numbers: Any, _p: Any, n: Any) -> Any:
    """Compute the values by which rays from a vertex sample a round patch of the sky, with `sphere_sample`.

    `numbers` has the unit vector to the patch's middle, the sine of its angular radius, and the reach, which is
    infinite. n is the vertex's normal.
    """
    found = sphere_frame(numbers, (0.0, 0.0, 0.0), n)
    return numbers[4], *found[1:]


@formula
def sphere_sample(_numbers: Any, frame: Any, u: Any, v: Any) -> Any:
    """Choose a direction in which a sphere light is seen, by u and v; return direction, distance and weight.

    The ray enters the sphere at the distance. `frame` has the vertex's values from `sphere_frame`. The reach, the unit
    of distances, is the distance to the centre; for a vertex inside the sphere, it is the radius.
    """
    less, side, to_middle = frame[12], frame[13], frame[14]
    x, y = on_disk(u, v)
    inner = minimum(x * x + y * y, ONE)
    t = less * inner  # 1 − cos of the ray's angle off the middle
    across = sqrt(less * (TWO - t))
    x, y, along = x * across, y * across, ONE - t
    direction = combined(along, frame[0:3], x, frame[3:6], y, frame[6:9])
    weight = multiply_add(y, frame[11], multiply_add(x, frame[10], along * frame[9]))
    # squared radius minus the ray's squared distance from the centre, without cancellation at the edge of the cone
    apart = select(side < ZERO, less * (ONE - inner) * (TWO - less - t), ONE - to_middle * to_middle * t * (TWO - t))
    return direction, to_middle * along + side * sqrt(maximum(apart, ZERO)), maximum(weight, ZERO)


def sphere_seen(_numbers: Any, frame: Any, d: Any) -> Any:
    """Return the distance at which a ray in the direction d enters a sphere light, and the density of this direction.

    `sphere_sample` chooses d with this density. The density is 0 where the ray misses the sphere, and inside the
    sphere, because the sphere emits only to the outside. `frame` has the vertex's values from `sphere_frame`. The
    distance is in units of the reach, which is the first result of `sphere_frame`.
    """
    less, off = frame[12], subtract(d, frame[0:3])
    t = HALF * dot(off, off)  # 1 − cos of the ray's angle off the middle
    apart = (less - t) * (TWO - less - t)
    is_met = (t <= less * (ONE + _SLACK)) & (frame[13] < ZERO)
    share = frame[14] * (ONE - t) - sqrt(maximum(apart, ZERO))
    return share, select(is_met, 1.0 / (2.0 * math.pi * less), 0.0)


# --- flat lights: points on them, with a density close to their contribution

# Least weight of a corner, relative to the weight that it would have if the vertex faced it.
_LEAST_CORNER = 2.0**-5
# Least height of a vertex above the light's plane, as a fraction of the reach.
_LEAST_HEIGHT = 2.0**-10
# Below this height, in units of the radius, a disk is sampled as the square around it.
_NEAR_DISK = 0.5


@formula
def _slope(side: Any, foot: Any, height: Any) -> Any:
    """Return the five numbers by which `_on_side` samples a side of a flat light, uniformly by the angle at the vertex.

    `side` is half the side's length. `foot` is the projection of the vertex onto the side, measured from the side's
    middle. `height` is the vertex's height above the side. The density at the distance s from the foot is proportional
    to 1/(s² + height²). The numbers are the cosine and sine of the middle angle, half the range of angles, the foot,
    and the factor of the density.
    """
    low, high = arctan2(-side - foot, height), arctan2(side - foot, height)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    return cosine(middle), sine(middle), half, foot, side * height / half


@formula
def _corner(c: Any, n: Any, height: Any) -> Any:
    """Return the weight of a light's corner: the light from there divided by the density of samples, up to a factor.

    c is the offset from the vertex to the corner, and n the vertex's normal. `height` is 1 divided by the density of
    samples at the corner.
    """
    square = dot(c, c)
    return maximum(dot(n, c), _LEAST_CORNER * sqrt(square)) / maximum(square * square, 1e-30) * height


@formula
def flat_frame(numbers: Any, p: Any, n: Any) -> Any:
    """Compute the values by which rays from a vertex sample a flat light (`frame` in the module docstring).

    p is the origin of the rays, and n the normal there. `numbers` has the centre; the normal; two half sides as
    vectors; 1 if the light is two-sided, else 0; and the corner position, which is the fraction of the half sides at
    which the corners are: 1 for a rectangle, √½ for a disk. Values for `sample`, with lengths as fractions of the
    reach:

    - 0 to 2: the offset from the vertex to the light's centre;
    - 3 to 8: unit vectors along the light's sides;
    - 9 to 11: the vertex's normal;
    - 12: the vertex's height above the emitting side;
    - 13 to 16: weights of the corners;
    - 17 to 21 and 22 to 26: the results of `_slope` for each side;
    - 27 and 28: the half sides;
    - 29: the height, at least `_LEAST_HEIGHT`.
    """
    normal = numbers[3], numbers[4], numbers[5]
    sides = (numbers[6], numbers[7], numbers[8]), (numbers[9], numbers[10], numbers[11])
    distance, w = length_and_direction((numbers[0] - p[0], numbers[1] - p[1], numbers[2] - p[2]))
    first, a = length_and_direction(sides[0])
    second, b = length_and_direction(sides[1])
    reach = distance + first + second
    d, first, second = times(w, distance / reach), first / reach, second / reach
    height = -dot(normal, d)
    shown = select(numbers[12] > 0.0, maximum(height, -height), maximum(height, 0.0))
    above = maximum(maximum(height, -height), _LEAST_HEIGHT)
    foot, other_foot = -dot(a, d), -dot(b, d)
    along, across = _slope(first, foot, above), _slope(second, other_foot, above)
    x, y = numbers[13] * first, numbers[13] * second
    square = above * above
    left, right = square + (x + foot) * (x + foot), square + (x - foot) * (x - foot)
    lower, upper = square + (y + other_foot) * (y + other_foot), square + (y - other_foot) * (y - other_foot)
    corners = (
        _corner(combined(-x, a, -y, b, 1.0, d), n, left * lower),
        _corner(combined(x, a, -y, b, 1.0, d), n, right * lower),
        _corner(combined(-x, a, y, b, 1.0, d), n, left * upper),
        _corner(combined(x, a, y, b, 1.0, d), n, right * upper),
    )
    over = 4.0 / (corners[0] + corners[1] + corners[2] + corners[3])
    weights = corners[0] * over, corners[1] * over, corners[2] * over, corners[3] * over
    lengths = first, second, above
    return reach, 1.0 / reach / reach, *d, *a, *b, *n, shown, *weights, *along, *across, *lengths


@formula
def _along(u: Any, a: Any, b: Any) -> Any:
    """Map a uniform number u to a number x in [0, 1]. The density of x is proportional to a + (b − a) x."""
    root = sqrt(multiply_add(u, b * b - a * a, a * a))
    return minimum(u * (a + b) / (a + root), ONE)


# Taylor series of cos δ and sin δ / δ in powers of δ² for |δ| <= π/2. Errors are below 5e-7 and 6e-8.
_COSINE_TO_90 = tuple((-1) ** k / math.factorial(2 * k) for k in range(5, -1, -1))
_SINE_TO_90 = tuple((-1) ** k / math.factorial(2 * k + 1) for k in range(5, -1, -1))


@formula
def _on_side(u: Any, slope: Any, side: Any, height: Any) -> Any:
    """Map u to a point on a side, given as the offset from the side's middle; return the offset and the density there.

    `slope` is the result of `_slope` for the half side `side` and this `height`.
    """
    delta = (TWO * u - ONE) * slope[2]
    c, s = _polynomial(delta * delta, _COSINE_TO_90), delta * _polynomial(delta * delta, _SINE_TO_90)
    tangent = (slope[1] * c + slope[0] * s) / maximum(slope[0] * c - slope[1] * s, as_type_of(u, 1e-6))
    x = minimum(maximum(multiply_add(height, tangent, slope[3]), -side), side)
    off = x - slope[3]
    return x, slope[4] / multiply_add(off, off, height * height)


@formula
def _warped(u: Any, v: Any, corners: Any) -> Any:
    """Map u and v to a point of the unit square whose density is bilinear; return both coordinates and the density.

    `corners` has the densities at the square's corners (0, 0), (1, 0), (0, 1) and (1, 1). Source: D. Hart et al.,
    "Practical product sampling by fitting and composing warps" (2020), 4.1.
    """
    y = _along(v, corners[0] + corners[1], corners[2] + corners[3])
    left, right = corners[0] + y * (corners[2] - corners[0]), corners[1] + y * (corners[3] - corners[1])
    x = _along(u, left, right)
    return x, y, left + x * (right - left)


@formula
def _on_rectangle(frame: Any, u: Any, v: Any) -> Any:
    """Map u and v to a point of a rectangle; return its offsets from the middle along both sides, and the density.

    `frame` has the vertex's values from `flat_frame`.
    """
    x, y, density = _warped(u, v, frame[13:17])
    x, first = _on_side(x, frame[17:22], frame[27], frame[29])
    y, second = _on_side(y, frame[22:27], frame[28], frame[29])
    return x, y, density * (first * second)


@formula
def _from_flat(frame: Any, x: Any, y: Any, over_density: Any) -> Any:
    """Return the result of `sample` for a point of a flat light: direction, distance and weight.

    `frame` has the vertex's values from `flat_frame`; x and y are the point's offsets from the middle along the light's
    sides, and `over_density` is 1 divided by the density of points.
    """
    c = combined(ONE, frame[0:3], x, frame[3:6], y, frame[6:9])
    square = dot(c, c)
    length = sqrt(square)
    over = ONE / select(square > ZERO, length, ONE)
    weight = maximum(dot(frame[9:12], c), ZERO) * frame[12] * (over * over) * (over * over) * over_density
    return times(c, over), length, weight


@formula
def rectangle_sample(_numbers: Any, frame: Any, u: Any, v: Any) -> Any:
    """Choose a point of a rectangle light by u and v; return its direction, distance and weight.

    `frame` has the vertex's values from `flat_frame`.
    """
    x, y, density = _on_rectangle(frame, u, v)
    return _from_flat(frame, x, y, ONE / density)


@formula
def disk_sample(_numbers: Any, frame: Any, u: Any, v: Any) -> Any:
    """Choose a point of a disk light by u and v; return its direction, distance and weight.

    `frame` has the vertex's values from `flat_frame`. For a vertex near the disk's plane, points of the square around
    the disk are chosen; points outside the disk have weight 0.
    """
    radius = frame[27]
    x, y, density = _warped(u, v, frame[13:17])
    x, y = on_disk(x, y)
    across, up, near_density = _on_rectangle(frame, u, v)
    is_near = frame[29] < as_type_of(u, _NEAR_DISK) * radius
    x, y = select(is_near, across, radius * x), select(is_near, up, radius * y)
    is_outside = x * x + y * y > multiply_add(radius, radius * as_type_of(u, 1e-6), radius * radius)
    over_near = select(is_outside, ZERO, as_type_of(u, 4.0 / math.pi) / near_density)
    return _from_flat(frame, x, y, select(is_near, over_near, ONE / density))


def _on_plane(numbers: Any, frame: Any, d: Any) -> Any:
    """Intersect a ray in the direction d with the plane of a flat light.

    `numbers` has the light's numbers, and `frame` has the vertex's values from `flat_frame`. Return the two offsets
    from the light's middle along its sides, the distance, and the factor that turns a density per area into a density
    per solid angle. The factor is 0 where the ray misses the plane or the vertex is behind the light.
    """
    normal, c = (numbers[3], numbers[4], numbers[5]), frame[0:3]
    along = dot(normal, d)
    far = dot(normal, c) / along
    off = subtract(times(d, far), c)
    is_met = (frame[12] > ZERO) & (far > ZERO) & (far < as_type_of(far, math.inf))
    return dot(frame[3:6], off), dot(frame[6:9], off), far, select(is_met, far * far / abs(along), ZERO)


def _of_side(x: Any, slope: Any, height: Any) -> Any:
    """Return the number u that `_on_side` maps to the offset x, and the density of offsets there.

    `slope` is from `_slope`, for the same `height` of the vertex above the side.
    """
    off = x - slope[3]
    delta = arctan2(off, height) - arctan2(slope[1], slope[0])
    return HALF + HALF * delta / slope[2], slope[4] / (height * height + off * off)


def _warped_density(u: Any, v: Any, corners: Any) -> Any:
    """Return the density with which `_warped` chooses the point (u, v) of the unit square.

    `corners` has the densities at the square's corners (0, 0), (1, 0), (0, 1) and (1, 1).
    """
    u, v = minimum(maximum(u, ZERO), ONE), minimum(maximum(v, ZERO), ONE)
    left, right = corners[0] + v * (corners[2] - corners[0]), corners[1] + v * (corners[3] - corners[1])
    return left + u * (right - left)


def _rectangle_density(frame: Any, x: Any, y: Any) -> Any:
    """Return the density with which `_on_rectangle` chooses the offsets x and y, relative to uniform sampling.

    `frame` has the vertex's values from `flat_frame`.
    """
    u, first = _of_side(x, frame[17:22], frame[29])
    v, second = _of_side(y, frame[22:27], frame[29])
    return _warped_density(u, v, frame[13:17]) * (first * second)


def rectangle_seen(numbers: Any, frame: Any, d: Any) -> Any:
    """Return the distance to a rectangle light in the direction d, and the density of this direction.

    `rectangle_sample` chooses d with this density. The density is 0 where a ray misses the light. `numbers` has the
    light's numbers, and `frame` the vertex's values from `flat_frame`. The distance is in units of the reach, which is
    the first result of `flat_frame`.
    """
    x, y, far, factor = _on_plane(numbers, frame, d)
    first, second = frame[27], frame[28]
    is_met = (abs(x) <= first * (ONE + _SLACK)) & (abs(y) <= second * (ONE + _SLACK))
    return far, select(is_met, _rectangle_density(frame, x, y) * factor / (4.0 * first * second), ZERO)


def disk_seen(numbers: Any, frame: Any, d: Any) -> Any:
    """Return the distance to a disk light in the direction d, and the density of this direction.

    `disk_sample` chooses d with this density. The density is 0 where a ray misses the light. `numbers` has the light's
    numbers, and `frame` the vertex's values from `flat_frame`. The distance is in units of the reach, which is the
    first result of `flat_frame`.
    """
    x, y, far, factor = _on_plane(numbers, frame, d)
    radius = frame[27]
    distance = sqrt(x * x + y * y) / radius
    # the inverse of `on_disk`
    is_wide = abs(x) > abs(y)
    angle = 4.0 / math.pi * arctan2(minimum(abs(x), abs(y)), maximum(abs(x), abs(y)))
    a, b = select(is_wide, distance, distance * angle), select(is_wide, distance * angle, distance)
    u, v = HALF + HALF * select(x < ZERO, -a, a), HALF + HALF * select(y < ZERO, -b, b)
    near = _rectangle_density(frame, x, y) / 4.0
    density = select(frame[29] < _NEAR_DISK * radius, near, _warped_density(u, v, frame[13:17]) / math.pi)
    return far, select(distance <= ONE + _SLACK, density * factor / (radius * radius), ZERO)


# Index of the number of triangles in a polygon's numbers. For each triangle follow the cumulative fraction of the area,
# its own fraction, its first corner, and the offsets of the other two corners from it, in units of the half sides.
TRIANGLES = 14


@formula
def polygon_sample(numbers: Any, frame: Any, u: Any, v: Any) -> Any:
    """Choose a point of a polygon light by u and v, uniformly by area; return its direction, distance and weight.

    `numbers` has the polygon's numbers, with its triangles; `frame` has the vertex's values from `flat_frame`.
    """
    which = index(ZERO * u)
    for k in range(int(numbers[TRIANGLES]) - 1):
        which = which + select(u >= numbers[TRIANGLES + 1 + 8 * k], 1, 0)
    at = TRIANGLES + 1 + 8 * which
    part = maximum((u - (numbers[at] - numbers[at + 1])) / numbers[at + 1], 0.0)
    far = sqrt(minimum(part, 1.0))
    x = numbers[at + 2] + far * (numbers[at + 4] + v * (numbers[at + 6] - numbers[at + 4]))
    y = numbers[at + 3] + far * (numbers[at + 5] + v * (numbers[at + 7] - numbers[at + 5]))
    return _from_flat(frame, single(x) * frame[27], single(y) * frame[28], ONE)


def polygon_seen(numbers: Any, frame: Any, d: Any) -> Any:
    """Return the distance to a polygon light in the direction d, and the density of this direction.

    `polygon_sample` chooses d with this density. The density is 0 where a ray misses the light. `numbers` has the
    light's numbers, and `frame` the vertex's values from `flat_frame`. The distance is in units of the reach, which is
    the first result of `flat_frame`.
    """
    x, y, far, factor = _on_plane(numbers, frame, d)
    x, y, is_met = x / frame[27], y / frame[28], x != x
    for k in range(int(numbers[TRIANGLES])):
        _, share, ax, ay, bx, by, cx, cy = numbers[TRIANGLES + 1 + 8 * k : TRIANGLES + 9 + 8 * k]
        twice = bx * cy - by * cx
        u, v = ((x - ax) * cy - (y - ay) * cx) / twice, ((y - ay) * bx - (x - ax) * by) / twice
        is_met = is_met | ((u >= -_SLACK) & (v >= -_SLACK) & (u + v <= ONE + _SLACK))
        whole = 0.5 * abs(twice) / share
    return far, select(is_met, factor / (whole * frame[27] * frame[28]), ZERO)


# --- the sky: by the cosine, and by its image


@formula
def sky_frame(numbers: Any, _p: Any, n: Any) -> Any:
    """Compute the values by which rays from a vertex sample a sky (`frame` in the module docstring).

    `numbers` has the distance beyond which geometry does not occlude the sky, and the sky's brightness. Values for
    `sample`:

    - 0 to 8: two unit vectors across the normal, and the normal;
    - 9: 1 if there is a normal, else 0.
    """
    across, up = orthogonals(n)
    has_normal = select(dot(n, n) > 0.0, 1.0, 0.0)
    return numbers[0], numbers[1], *across, *up, *n, has_normal


@formula
def _by_cosine(frame: Any, u: Any, v: Any) -> Any:
    """Map u and v to a unit vector with a density proportional to the cosine to the normal.

    The vector is above a uniformly distributed point of the unit disk (Nusselt's analogue). `frame` has the vertex's
    values from `sky_frame`.
    """
    x, y = on_disk(u, v)
    z = sqrt(maximum(ONE - x * x - y * y, ZERO))
    return combined(x, frame[0:3], y, frame[3:6], z, frame[6:9])


@formula
def sky_sample(_numbers: Any, frame: Any, u: Any, v: Any) -> Any:
    """Choose a direction to a uniform sky by u and v; return direction, distance and weight.

    The density is proportional to the cosine to the normal. `frame` has the vertex's values from `sky_frame`.
    """
    return _by_cosine(frame, u, v), ONE, frame[9] + ZERO * u


def sky_seen(_numbers: Any, frame: Any, d: Any) -> Any:
    """Return the distance to a sky, always 1 reach, and the density with which `sky_sample` chooses d.

    `frame` has the vertex's values from `sky_frame`, and d is a unit vector.
    """
    return ONE, maximum(dot(frame[6:9], d), ZERO) * frame[9] / math.pi


def sky_sampling(distance: float, brightness: float) -> Sampling:
    """Return the importance sampling of a uniform sky of the given brightness.

    Geometry farther away than `distance` does not occlude the sky.
    """
    return Sampling(sky_frame, sky_sample, sky_seen, (distance, brightness))


# An image's numbers after those of `sky_frame`: the number of rows and of columns; powers of two for bisecting them;
# ∫ L dω of its radiance L; and the axes to its middle, right and up. Then follow tables: the cosine of the angle from
# the top at which each row begins; the cumulative fraction of the energy there; the cumulative fractions of the columns
# in each row; and L.
_ROWS, _COLUMNS, _HALF_ROWS, _HALF_COLUMNS, _TOTAL, _TABLES = 2, 3, 4, 5, 6, 16


@formula
def _place_in(numbers: Any, start: Any, count: Any, half: Any, share: Any) -> Any:
    """Find the interval that contains a fraction, `share`, in a table of `count` + 1 numbers that rise from 0 to 1.

    The table begins at the index `start` of `numbers`; `half` is the first step of the bisection, a power of two.
    Return the interval's index in the table, and the position of `share` within the interval, from 0 to 1.
    """
    low, step = index(share * ZERO), int(half)
    while step > 0:
        after = low + step
        inside = minimum(after, count)
        low = select((after < count) & (numbers[start + inside] <= share), inside, low)
        step //= 2
    begin, end = numbers[start + low], numbers[start + low + 1]
    return low, minimum(maximum(share - begin, 0.0) / maximum(end - begin, 1e-30), 1.0)


@formula
def _cell(numbers: Any, d: Any) -> Any:
    """Return the row and the column of the texel to which the direction d points.

    `numbers` is from `image_numbers`.
    """
    rows, columns = int(numbers[_ROWS]), int(numbers[_COLUMNS])
    ahead, right = (numbers[7], numbers[8], numbers[9]), (numbers[10], numbers[11], numbers[12])
    height = minimum(maximum(dot((numbers[13], numbers[14], numbers[15]), d), -1.0), 1.0)
    down = arctan2(sqrt(1.0 - height * height), height) * (rows / math.pi)
    around = arctan2(dot(right, d), dot(ahead, d)) * (columns / (2.0 * math.pi)) + 0.5 * columns
    return minimum(index(down), rows - 1), minimum(index(maximum(around, 0.0)), columns - 1)


@formula
def image_sample(numbers: Any, frame: Any, u: Any, v: Any) -> Any:
    """Choose a direction to a sky with an image by u and v; return direction, distance and weight.

    If u < ½, the direction is chosen by the image's energy, else by the cosine to the normal. `numbers` is from
    `image_numbers`, and `frame` has the vertex's values from `sky_frame`. Weights use the mean density of both: the
    balance heuristic (E. Veach and L. Guibas, "Optimally combining sampling techniques", 1995).
    """
    rows, columns = int(numbers[_ROWS]), int(numbers[_COLUMNS])
    ends = _TABLES + rows + 1
    shares = ends + rows + 1
    cells = shares + rows * (columns + 1)
    by_image, u = u < HALF, select(u < HALF, TWO * u, TWO * u - ONE)
    d = _by_cosine(frame, u, v)
    ahead, right = (numbers[7], numbers[8], numbers[9]), (numbers[10], numbers[11], numbers[12])
    up = numbers[13], numbers[14], numbers[15]
    row, column = _cell(numbers, d)
    chosen, far = _place_in(numbers, ends, rows, numbers[_HALF_ROWS], v)
    row = select(by_image, chosen, row)
    start = shares + row * (columns + 1)
    chosen, along = _place_in(numbers, start, columns, numbers[_HALF_COLUMNS], u)
    column = select(by_image, chosen, column)
    top = numbers[_TABLES + row]
    height = top + far * (numbers[_TABLES + row + 1] - top)
    around = (column + along) * (2.0 * math.pi / columns) - math.pi
    level = sqrt(maximum(1.0 - height * height, 0.0))
    to_image = combined(level * cosine(around), ahead, level * sine(around), right, height, up)
    direction = (
        single(select(by_image, to_image[0], d[0])),
        single(select(by_image, to_image[1], d[1])),
        single(select(by_image, to_image[2], d[2])),
    )
    cosine_here = maximum(dot(frame[6:9], direction), 0.0)
    radiance = numbers[cells + row * columns + column]
    density = math.pi * radiance / maximum(numbers[_TOTAL], 1e-300) + cosine_here
    return direction, ONE, single(2.0 * radiance * cosine_here / maximum(density, 1e-30) * frame[9])


def image_seen(numbers: Any, frame: Any, d: Any) -> Any:
    """Return the distance to a sky, always 1 reach, and the density with which `image_sample` chooses d.

    `numbers` is from `image_numbers`, `frame` has the vertex's values from `sky_frame`, and d is a unit vector.
    """
    rows, columns = int(numbers[_ROWS]), int(numbers[_COLUMNS])
    row, column = _cell(numbers, d)
    cells = _TABLES + 2 * (rows + 1) + rows * (columns + 1)
    by_image = numbers[cells + row * columns + column] / maximum(numbers[_TOTAL], 1e-300)
    return ONE, 0.5 * (by_image + maximum(dot(frame[6:9], d), ZERO) * frame[9] / math.pi)


def image_numbers(radiance: Float64Array, axes: Float64Array) -> Float64Array:
    """Return the numbers of a sky with an image, which `sky_frame`, `image_sample` and `image_seen` read.

    `radiance` has the radiance of the image's cells, shape (h, w). `axes` has unit vectors to the image's middle, to
    its right and up, as rows.
    """
    rows, columns = radiance.shape
    tops = np.cos(np.arange(rows + 1) * (math.pi / rows))
    energies = radiance * ((tops[:-1] - tops[1:]) * (2.0 * math.pi / columns))[:, None]
    sums = energies.sum(axis=1)
    sizes = rows, columns, 1 << (rows - 1).bit_length(), 1 << (columns - 1).bit_length()
    tables = tops, _shares(sums), np.apply_along_axis(_shares, 1, energies), radiance
    return np.concatenate([(math.inf, 1.0, *sizes, sums.sum()), axes.ravel(), *(table.ravel() for table in tables)])


def _shares(parts: Float64Array) -> Float64Array:
    """Return the cumulative sums of `parts`, scaled to end at 1. If all parts are 0, they count as equal."""
    ends = np.cumsum(parts if parts.any() else np.ones_like(parts))
    return np.concatenate([[0.0], ends / ends[-1]])
