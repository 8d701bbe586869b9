"""Lights with a size in an equation, in the parts that evaluators run: closed forms, and nodes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from pvphong.base.types import Vector, rgb
from pvphong.optics.area.lobes import CosinePower
from pvphong.optics.light import NODES
from pvphong.shading.equation import BLACK, Equation, LightTerm

_WHITE = (1.0, 1.0, 1.0)


def in_parts(equation: Equation) -> Equation:
    """The equation with every light that has a size in the parts that evaluators run.

    Lobes that it has a closed form for stay its own, the others are the sum of its nodes, and
    its ambient colour arrives as from its centre.
    """
    if not any(term.light.has_size for term in equation.terms):
        return equation
    terms = tuple(part for term in equation.terms for part in _parts(term, equation.forms))
    return replace(equation, terms=terms)


def as_nodes(equation: Equation, count: int) -> Equation:
    """The equation with every light that has a size as the sum of so many nodes, whatever it has a closed form for."""
    nothing = (None,) * len(equation.reflectance.lobes)
    terms = tuple(part for term in equation.terms for part in _parts(term, nothing, count))
    return replace(equation, terms=terms)


def _parts(term: LightTerm, forms: Sequence[CosinePower | None], most: int = NODES) -> Iterator[LightTerm]:
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
        for node in light.nodes(most) if term.nodes is None else term.nodes:
            colors = _tinted(summed, rgb(node.diffuse))
            yield replace(term, light=node, ambient=BLACK, colors=colors, gain=term.gain * node.intensity)


def by_closed_form(term: LightTerm, forms: Sequence[CosinePower | None]) -> tuple[tuple[Vector, ...], ...]:
    """A term's colours of the lobes that its light has closed forms for, and of the others; black in place of each."""
    _, light = term.light.tints(term.bands)[0]
    is_exact = [form is not None and light.closed(form) is not None for form in forms]
    return tuple(
        tuple(color if chosen is exactly else BLACK for color, chosen in zip(term.colors, is_exact, strict=True))
        for exactly in (True, False)
    )


def _tinted(colors: tuple[Vector, ...], tint: Vector) -> tuple[Vector, ...]:
    r, g, b = tint
    return colors if tint == _WHITE else tuple((red * r, green * g, blue * b) for red, green, blue in colors)
