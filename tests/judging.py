"""Error bounds of evaluators against the oracle, and cases in which two answers are right.

The bound, per vertex and channel, absolute, with u half a step of the precision at 1 (2⁻⁵³ or 2⁻²⁴):

    (4√n + 16) · u · (1 + number of lights) · κ · s  +  s · (low powers)

n is the largest power of a cosine in the case: the shininess, or a spot's exponent (both at most 128 in VTK's
convention). s is the largest product of coefficients (reflectance · light colour · intensity · attenuation · spot),
or 1 where that is less. κ ≥ 1 is the conditioning of the geometry, and 1 in a plain scene: half of ‖|C|·|n|‖ / ‖C·n‖
for the normal under the cofactor matrix C, and an eighth of the size of the numbers that a point, a light or the eye
is summed from, over their distance (whichever is largest).
Low powers: a power below 1 rises with infinite slope at 0, so a cosine f with an error δ = 16·u·κ is off by
min(δⁿ, n·fⁿ⁻¹·δ).

Undecidable cases are skipped: a light within 8·κ·u of the vertex's horizon or of its cone's edge (in cosines), and a
viewer within 8·κ·u of the horizon where a two-sided model turns the normal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from oracle import (
    VTK_LARGEST_POWER,
    Exact,
    Eye,
    LightFacts,
    Placement,
    Shade,
    as_array,
    dot,
    exact,
    is_spot,
    minus,
    placed,
    root,
    shade,
)
from strategies import Case

STEP = {"float64": 2.0**-53, "float32": 2.0**-24}
BAND = 8
FIELDS = {"rgb": "color"} | {name: name for name in ("ambient", "diffuse", "specular", "emission", "per_light")}
"""Name in a `Shading` → name in the oracle's `Shade`."""


@dataclass(frozen=True)
class Judgement:
    """Result of one case: the largest error in units of its bound, and the skipped vertices."""

    worst: float
    report: str
    vertices: int
    left_out: int


def capped(power: float, case: Case) -> float:
    return min(power, VTK_LARGEST_POWER) if case.scene.light_model.convention == "vtk" else power


def largest_power(case: Case) -> float:
    exponents = [light.exponent for light in case.scene.lights if is_spot(light)]
    return max(capped(power, case) for power in [case.material.shininess, *exponents])


def coefficient(case: Case, facts: tuple[LightFacts, ...]) -> float:
    """Return s: the largest product of coefficients at a vertex, at least 1."""
    material, products = case.material, [1.0]
    for light, fact in zip(case.scene.lights, facts, strict=True):
        if fact.strength is None:  # off
            continue
        specular = light.diffuse if light.specular is None else light.specular
        pairs = ((material.ambient, light.ambient), (material.diffuse, light.diffuse), (material.specular, specular))
        products += [float(fact.strength) * float(np.max(k)) * float(np.max(color)) for k, color in pairs]
    return max(products)


# --- conditioning ---


def _size(a: Exact) -> float:
    return float(root(dot(a, a)))


def _summed_from(placement: Placement, p: Exact) -> Exact:
    """Sum of the magnitudes of the terms of a world coordinate."""
    x, y, z = (
        (sum(abs(a * b) for a, b in zip(row, p, strict=True)) + abs(shift)) / abs(placement.w)
        for row, shift in zip(placement.linear, placement.offset, strict=True)
    )
    return x, y, z


def _ratio(above: Fraction, below: Fraction) -> float:
    """√(above/below); 1 if there is no vector to normalise."""
    return float(root(above / below)) if below else 1.0


def normal_conditioning(placement: Placement, n: Exact) -> float:
    """Factor by which rounding of the terms of C·n can turn it: ‖|C|·|n|‖ / ‖C·n‖."""
    sizes = [sum(abs(a * b) for a, b in zip(row, n, strict=True)) for row in placement.cofactors]
    turned = placement.normal(n)
    return _ratio(sum((a * a for a in sizes), Fraction(0)), dot(turned, turned))


def conditioning(case: Case) -> np.ndarray:
    """κ of every vertex."""
    placement = Placement(np.eye(4) if case.matrix is None else case.matrix)
    eye = Eye(case.scene.viewer)
    places = [(eye.position, (Fraction(0),) * 3)]
    for light in case.scene.lights:
        position, _ = placed(light, eye)
        if position is not None and light.on:
            added = eye.position if light.frame == "camera" else (Fraction(0),) * 3
            places.append((position, added))
    result = []
    for point, normal in zip(case.points, case.normals, strict=True):
        p, n = exact(point), exact(normal)
        world, size = placement.point(p), _size(_summed_from(placement, p))
        kappa = max(1.0, normal_conditioning(placement, n) / 2)
        for position, added in places:
            distance = _size(minus(position, world))
            if distance:
                kappa = max(kappa, (size + _size(added)) / distance / 8)
        result.append(kappa)
    return np.array(result)


# --- the bound ---


def low_power(power: float, cosine: Any, delta: float, floor: float = 0.0) -> float:
    """Bound the error of f^power for an error δ of f, for 0 < power < 1."""
    if not 0 < power < 1 or cosine is None or cosine < floor - delta:
        return 0.0
    f = max(float(cosine), floor)
    steep = power * f ** (power - 1) * delta if f > 0 else math.inf
    return min(delta**power, steep)


def _low_powers(case: Case, facts: tuple[LightFacts, ...], delta: float) -> float:
    floor = 1e-5 if case.scene.light_model.convention == "vtk" else 0.0
    extra = 0.0
    for light, fact in zip(case.scene.lights, facts, strict=True):
        extra += low_power(case.material.shininess, fact.highlight, delta, floor)
        if is_spot(light):
            extra += low_power(light.exponent, fact.spot_cosine, delta)
    return extra


def bounds(case: Case, shades: list[Shade], step: float, kappa: np.ndarray) -> np.ndarray:
    """Return the bound of every vertex, shape (n,)."""
    plain = (4 * math.sqrt(largest_power(case)) + 16) * step * (1 + len(case.scene.lights))
    return np.array(
        [
            coefficient(case, s.lights) * (plain * k + _low_powers(case, s.lights, 16 * step * k))
            for s, k in zip(shades, kappa, strict=True)
        ]
    )


def undecidable(case: Case, s: Shade, band: float) -> bool:
    """Return True for vertices with a cosine so close to a threshold that both answers are right."""
    margins = [fact.n_dot_l for fact in s.lights] + [fact.cone_margin for fact in s.lights if fact.distance != 0]
    if case.scene.light_model.two_sided:
        margins.append(s.n_dot_v)
    return any(margin is not None and abs(margin) <= band for margin in margins)


def judge(
    case: Case, shading: Any, precision: str, *, badly_posed: float = math.inf, fields: dict[str, str] = FIELDS
) -> Judgement:
    """Compare `fields` of a `Shading` with the oracle, by a precision's bound. All vertices must be finite.

    Vertices with a κ larger than `badly_posed` are skipped too.
    """
    step = STEP[precision]
    shades = shade(*case.arguments, **case.options)
    kappa = conditioning(case)
    bound = bounds(case, shades, step, kappa)
    left_out = np.array([undecidable(case, s, BAND * step * k) for s, k in zip(shades, kappa, strict=True)], dtype=bool)
    left_out |= kappa > badly_posed
    worst, report = 0.0, ""
    for name, of_oracle in fields.items():
        got, expected = np.asarray(getattr(shading, name), dtype=np.float64), as_array(shades, of_oracle)
        assert got.shape == expected.shape, (name, got.shape, expected.shape)
        ratio = np.abs(got - expected) / bound[:, None]
        ratio = np.where(np.isnan(ratio), np.inf, ratio) * ~left_out[:, None]
        if ratio.size and ratio.max() > worst:
            where = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
            worst = float(ratio[where])
            report = (
                f"{name}{[int(i) for i in where]} is {got[where]!r}, the oracle says {expected[where]!r}: "
                f"{worst:.3g} of the bound {bound[where[-2]]:.3g} (κ = {kappa[where[-2]]:.3g})\n{case!r}"
            )
    return Judgement(worst, report, len(shades), int(left_out.sum()))
