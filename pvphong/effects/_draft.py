"""What an effect gets to see, and what it gives back.

An effect that a scene does not call for is left out by rewriting the equation into a cheaper one: a black
term goes, a spot whose cone holds the whole mesh becomes a point light. The evaluators know nothing of plans;
they run the equation that is left.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from pvphong._types import Float64Array, FloatArray, MatrixLike, Vector
from pvphong.equation import Equation, LightTerm
from pvphong.transform import transform_points

# Bounds are computed in float64 and rounded up by this factor.
ROUNDED_UP = 1.0 + 1e-9
# Rows that are searched for extremes at once, and that are laid side by side for it.
_CHUNK, _FOLD = 2**16, 64
# Normals that are looked at first.
_SOME = 64


@dataclass(frozen=True)
class Decision:
    """Whether an effect runs, and why.

    Attributes
    ----------
    on : bool
        Whether it runs.
    why : str
        The reason, for people.
    bound : float
        The largest absolute colour error that leaving it out can cause; 0 where it is left out exactly.
    lights : int
        For how many lights it runs, of those it is about.
    """

    on: bool
    why: str
    bound: float = 0.0
    lights: int = 0


@dataclass(frozen=True)
class Note:
    """One rewriting of the equation: which effect was left out, for which light, why, at what error.

    `here`: it holds for the viewer where he is now, and not wherever he goes.
    """

    effect: str
    light: str
    why: str
    bound: float = 0.0
    here: bool = False


class Extent:
    """A sphere around all vertices, in world coordinates; computed when an effect first asks.

    Parameters
    ----------
    points : ndarray
        Shape (n, 3).
    normals : ndarray or None
        Shape (n, 3), where they are known.
    matrix : array_like or None
        Model matrix.
    """

    def __init__(self, points: FloatArray, normals: FloatArray | None, matrix: MatrixLike | None) -> None:
        self._points = points
        self._normals = normals
        self._matrix = matrix

    @cached_property
    def sphere(self) -> tuple[Vector, float] | None:
        """Centre and radius; None where there is no point, or one is not finite."""
        if not len(self._points):
            return None
        low, high = _bounds(self._points)
        if self._matrix is not None:
            corners = transform_points(_corners(low, high), self._matrix)
            low, high = corners.min(axis=0), corners.max(axis=0)
        x, y, z = centre = [a / 2 + b / 2 for a, b in zip(low.tolist(), high.tolist(), strict=True)]
        reach = (max(b - c, c - a) for a, b, c in zip(low.tolist(), high.tolist(), centre, strict=True))
        radius = math.hypot(*reach) * ROUNDED_UP
        return ((x, y, z), radius) if math.isfinite(radius) else None

    @cached_property
    def normal_cone(self) -> tuple[Vector, float] | None:
        """A unit axis, and an angle in radians within which all normals lie from it; None where none is known."""
        if self._normals is None or self._matrix is not None or not len(self._normals):
            return None
        some = self._normals[:: max(len(self._normals) // _SOME, 1)]  # where these have no cone, all hardly have one
        return None if _cone(some) is None else _cone(self._normals)


def _cone(normals: FloatArray) -> tuple[Vector, float] | None:
    """By the box around the normals: n·axis is least, and |n| greatest, at one of its corners."""
    low, high = _bounds(normals)
    largest = max(np.abs(low).max(), np.abs(high).max())
    if not 0.0 < largest < math.inf:
        return None
    low, high = (np.ldexp(bound, -np.frexp(largest)[1]) for bound in (low, high))  # so that squares can be taken
    corners = _corners(low, high)
    axis = (low + high) / 2
    length, longest = math.hypot(*axis), float(np.sqrt((corners**2).sum(axis=1)).max())
    if length == 0.0:
        return None
    x, y, z = (axis / length).tolist()
    cosine = float((corners @ (axis / length)).min()) / longest
    return ((x, y, z), math.acos(min(cosine, 1.0)) + 1e-7) if cosine > 0.0 else None


def _corners(low: Float64Array, high: Float64Array) -> Float64Array:
    """Of the box between two, shape (8, 3)."""
    return np.array(list(itertools.product(*zip(low.tolist(), high.tolist(), strict=True))))


def _bounds(rows: FloatArray) -> tuple[Float64Array, Float64Array]:
    """Least and greatest entry of each column; NaN where any is."""
    extremes = np.concatenate([_extremes(rows[start : start + _CHUNK]) for start in range(0, len(rows), _CHUNK)])
    return extremes.min(axis=0), extremes.max(axis=0)


def _extremes(rows: FloatArray) -> Float64Array:
    """A few rows with the same least and greatest entries. NumPy reduces long rows many times as fast as triples."""
    whole = len(rows) // _FOLD * _FOLD
    folded = rows[:whole].reshape(-1, 3 * _FOLD)
    parts = [rows[whole:]]
    if whole:
        parts += [folded.min(axis=0).reshape(_FOLD, 3), folded.max(axis=0).reshape(_FOLD, 3)]
    return np.concatenate(parts).astype(np.float64)


@dataclass(frozen=True)
class Draft:
    """An equation on its way to what is left of it.

    Parameters
    ----------
    equation : Equation
        As it stands.
    labels : tuple of str
        What names each light of the scene.
    extent : Extent
        Where the vertices are.
    tolerance : float
        The colour error that may be taken in all.
    notes : tuple of Note
        What has been left out so far.
    """

    equation: Equation
    labels: tuple[str, ...]
    extent: Extent
    tolerance: float
    notes: tuple[Note, ...] = ()

    @cached_property
    def error_bound(self) -> float:
        """Sum of the bounds taken so far."""
        return math.fsum(note.bound for note in self.notes) * (ROUNDED_UP if self.notes else 1.0)

    @cached_property
    def allowance(self) -> float:
        """The error that the next approximation may take: its share, or what is left of the tolerance."""
        if not self.tolerance:
            return 0.0
        share = self.tolerance / (2 * max(len(self.labels), 1))
        return min(share, max(self.tolerance - self.error_bound, 0.0) / ROUNDED_UP**2)

    def label(self, term: LightTerm) -> str:
        """What names the light of a term."""
        return self.labels[term.index]

    def because(self, effect: str) -> str:
        """The reasons noted for leaving an effect out, each with its lights."""
        reasons: dict[str, list[str]] = {}
        for note in self.notes:
            if note.effect == effect:
                reasons.setdefault(note.why, []).append(note.light)
        return "; ".join(
            f"{', '.join(filter(None, lights))}: {why}".removeprefix(": ") for why, lights in reasons.items()
        )

    def bound_of(self, effect: str) -> float:
        """Sum of the bounds taken by leaving out an effect."""
        return math.fsum(note.bound for note in self.notes if note.effect == effect)

    def labels_where(self, holds: Callable[[LightTerm], bool]) -> list[str]:
        """Names of the lights whose terms have some property."""
        return [self.label(term) for term in self.equation.terms if holds(term)]


@dataclass(frozen=True)
class Effect:
    """One effect that a scene may call for.

    Parameters
    ----------
    name : str
        Its name in a plan.
    inputs : tuple of str
        What it reads of each vertex, or of the scene: "points", "normals", "viewer".
    simplify : callable
        Draft → Draft: leaves the effect out where it can be.
    decide : callable
        Finished draft → Decision: whether it is still there.
    once, each : float
        About how many nanoseconds per vertex it takes, whatever the lights, and for each light it runs for.
    """

    name: str
    inputs: tuple[str, ...]
    simplify: Callable[[Draft], Draft]
    decide: Callable[[Draft], Decision]
    once: float = 0.0
    each: float = 0.0

    def nanoseconds(self, choice: Decision) -> float:
        """Per vertex, in the compiled evaluator and in float32 on one core: 0 where it does not run.

        Rounded differences of runs with and without it, measured on a server's processor of 2022 at 3.7 GHz.
        """
        return self.once + self.each * choice.lights if choice.on else 0.0


def unchanged(draft: Draft) -> Draft:
    """For an effect that is left out by others, or never."""
    return draft


Change = tuple[LightTerm | None, *tuple[Note, ...]] | None
"""What is left of a light's term, None for nothing, and why; or None where the term stays as it is."""


def for_each_term(rule: Callable[[Draft, LightTerm], Change]) -> Callable[[Draft], Draft]:
    """A simplification that looks at one light's term after the other; each rule sees the notes of those before."""

    def simplify(draft: Draft) -> Draft:
        before, terms = draft.equation.terms, list[LightTerm]()
        for term in before:
            left, *notes = rule(draft, term) or (term,)
            if notes:
                draft = replace(draft, notes=(*draft.notes, *notes))
            if left is not None:
                terms.append(left)
        kept = tuple(terms)
        return draft if kept == before else replace(draft, equation=replace(draft.equation, terms=kept))

    return simplify


def decision(draft: Draft, name: str, lights: Sequence[str], off: str) -> Decision:
    """On where some lights have the effect; else off, for the reasons noted or `off`."""
    noted = draft.because(name)
    if lights:
        why = ", ".join(lights) + (f" (left out: {noted})" if noted else "")
        return Decision(True, why, draft.bound_of(name), len(lights))
    return Decision(False, noted or off, draft.bound_of(name))


def sight(target: Any, draft: Draft) -> tuple[Vector, float, float] | None:
    """From the vertices' sphere to a target: unit direction at the centre, distance from it, and radius."""
    if draft.extent.sphere is None:
        return None
    centre, radius = draft.extent.sphere
    x, y, z = (a - b for a, b in zip(target, centre, strict=True))
    distance = math.hypot(x, y, z)
    if not 0.0 < distance < math.inf:
        return None
    return (x / distance, y / distance, z / distance), distance, radius


def turn(distance: float, radius: float) -> float:
    """The largest angle in radians between the directions to a target from the centre and from the sphere."""
    return math.pi if distance <= radius else math.asin(min(radius / distance, 1.0)) * ROUNDED_UP


def peak(color: Vector) -> float:
    """The largest channel."""
    return max(color)
