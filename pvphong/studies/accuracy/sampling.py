"""What rays cost: shadows and occlusion by so many rays for each vertex, and by as many as the tolerance asks for."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from pvphong.base.types import Float64Array, FloatArray, IntArray
from pvphong.rays.sampling import MOST_RAYS
from pvphong.rays.visibility import Visibility
from pvphong.shading import reference
from pvphong.shading.parts import in_parts
from pvphong.shading.result import Shading
from pvphong.shading.vertices import Vertices
from pvphong.studies.accuracy.rows import NO_ERROR, Row, Timing, vertex_errors
from pvphong.studies.accuracy.subject import Subject
from pvphong.studies.accuracy.timing import Clock, timed
from pvphong.studies.accuracy.variants import in_steps

_COUNTS = 4, 16, 64, 256
# Rays to a tolerance are no fewer.
_FIRST = 16

# The part of the time budget that the truth may take, and vertices at which it is found in any case.
_FOR_TRUTH, _FEWEST_JUDGED = 0.2, 100
# A row is cast so often at most, as long as that takes no more than a part of what is left.
_REPEATS, _FOR_REPEATS = 5, 0.1


class Sampling(NamedTuple):
    """What was found.

    Parameters
    ----------
    rows : list of Row
        By few rays and by many, timed.
    costs : dict of str to float
        Seconds of casting to the tolerance, by effect.
    left_out : dict of str to str
        What is left out, and why.
    """

    rows: list[Row]
    costs: dict[str, float]
    left_out: dict[str, str]


class _Judge(NamedTuple):
    """Some vertices, and their colours by all rays."""

    rows: IntArray
    truth: Float64Array


def sampling(subject: Subject, screen: Visibility, tolerance: float, clock: Clock) -> Sampling:
    """Rows for what the vertices see, by few rays and many, and by as many as the tolerance asks for.

    A row's time is that of casting its rays and lighting the vertices by them. What is done once for all rays, such as
    the tree of the occluders' triangles, is not counted.

    Parameters
    ----------
    subject : Subject
        What is lit.
    screen : Visibility
        What it sees, cast to the tolerance before.
    tolerance : float
        The largest standard error of its colours.
    clock : Clock
        Its budget is what this may take.
    """
    equation, effects = subject.equation, subject.plan().effects
    if not equation.has_screen:
        why = dict.fromkeys(effects[name].why for name in ("shadow", "occlusion"))
        return Sampling([], {}, {"rays": "; ".join(why)})
    clock.say("casting rays")
    costs, seen = {}, screen.afresh()
    if equation.shadowed:
        _, costs["shadow"] = timed(lambda: seen.channels(equation.shadowed, sky=False))
    if equation.is_occluded:
        _, costs["occlusion"] = timed(lambda: seen.channels((), sky=True))
    many = equation.is_occluded + len({t.index for t in equation.terms if t.is_shadowed and t.light.has_size})
    if not many:
        return Sampling([_row(subject, screen, "one ray for each light", None, None, clock)], costs, {})
    per_vertex = MOST_RAYS * many * sum(costs.values()) / max(seen.rays, 1)
    judge = _judge(subject, screen, int(_FOR_TRUTH * clock.left / per_vertex))
    rows, left_out = [_row(subject, screen, f"rays to {in_steps(tolerance)}", None, judge, clock)], {}
    for count in _COUNTS:
        name = f"{count} rays"
        if rows[-1].time.low * (1 if count <= _FIRST else 4) > clock.left:
            left_out[name] = "there was no time for it"
            continue
        rows.append(_row(subject, screen, name, count, judge, clock))
    return Sampling(rows, costs, left_out)


def _judge(subject: Subject, screen: Visibility, affordable: int) -> _Judge:
    count = len(subject.points)
    some = min(max(affordable, _FEWEST_JUDGED), count)
    rows = np.sort(np.random.default_rng(0).choice(count, some, replace=False))
    return _Judge(rows, _colors(subject, screen.afresh(samples=MOST_RAYS, rows=rows), rows, slice(None)))


def _row(
    subject: Subject, screen: Visibility, name: str, samples: int | None, judge: _Judge | None, clock: Clock
) -> Row:
    """What so many rays cost, and how far colours are off; without a judge they are exact."""
    clock.say(name)
    count, seconds, most = len(subject.points), list[float](), _FOR_REPEATS * clock.left
    backend = subject.backend_for(count, subject.equation)
    while not seconds or (len(seconds) < _REPEATS and sum(seconds) < most):
        seen = screen.afresh(samples=samples)
        vertices = Vertices(subject.points, subject.normals, screen=seen)
        plan = subject.planned(subject.equation, vertices)
        seconds.append(timed(partial(plan.run, vertices, backend=backend))[1])
    errors, note = NO_ERROR, f"{seen.rays / count:.3g} rays a vertex"
    if judge is not None:
        errors = vertex_errors(_colors(subject, seen, judge.rows, judge.rows), judge.truth)
        note += f"; held against all {MOST_RAYS} at {len(judge.rows)} of {count} vertices"
    return Row(
        name, "sampling", Timing.of(seconds), None, None, None, count, backend, "float32", note=note, sampling=errors
    )


def _colors(subject: Subject, seen: Visibility, rows: IntArray, among: IntArray | slice) -> Float64Array:
    """The float64 reference at some of the subject's vertices, by what these see `among` all that looked."""
    equation, result = subject.equation, Shading(np.empty((len(rows), 3)))
    channels: FloatArray = seen.channels(equation.shadowed, sky=equation.is_occluded)[:, among]
    reference.shade(subject.points[rows], subject.normals[rows], in_parts(equation), None, result, channels)
    return result.rgb
