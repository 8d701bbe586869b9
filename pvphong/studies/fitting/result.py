"""Result of a fit: the scene that was found, its errors, what no light can give, and how sure each number is."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from pvphong.base.text import WIDTH, html_table, rendered, wrapped
from pvphong.base.types import BoolArray, Float64Array
from pvphong.scene.scene import Scene
from pvphong.studies.fitting.columns import Share
from pvphong.studies.fitting.linear import Normal, Problem, Solution, normal_equations
from pvphong.studies.fitting.search import Point, Search, joined
from pvphong.studies.fitting.target import Wanted
from pvphong.studies.fitting.variation import Variation

Deviation = float | tuple[float, ...]

# An eigenvalue of the scaled normal equations below this means that unknowns cannot be told apart.
_ALIKE = 1e-9
# Share of an unknown in such a combination that counts.
_TAKES_PART = 0.1
# Differences below one step of a display are not listed as unmet.
_VISIBLE = 1.0 / 255.0
# The certificate holds for intensities up to this multiple of those found.
_MULTIPLE = 1000.0


class FitError(NamedTuple):
    """Differences between the colours that lights give and the target."""

    rms: float
    """Root mean square over points and channels, weighted by area and by the given weights."""
    largest: float
    """Largest absolute difference at any point that counts."""


class Unmet(NamedTuple):
    """A part of the target that no intensities of the lights can give."""

    what: str
    """The reason, in words."""
    points: int
    """Number of points."""
    share: float
    """The part's fraction of the weight of the whole target, 0 to 1."""
    largest: float
    """Largest difference from the target at these points."""


@dataclass(frozen=True, eq=False)
class Analysis:
    """The data of a fit from which its report is computed."""

    search: Search
    problem: Problem
    point: Point
    given: Search
    """The search with all lights that vary, including those that were not chosen."""
    shares: tuple[Share, ...]
    """Colours that each of these lights gives per unit of its unknowns."""
    off: Sequence[Variation]
    """Lights that were not chosen and are switched off."""

    @property
    def solution(self) -> Solution:
        """The intensities and colours."""
        return self.point.solution

    @property
    def varied(self) -> Sequence[Variation]:
        """The lights that vary."""
        return self.search.varied

    @property
    def wanted(self) -> Wanted:
        """The target."""
        return self.search.wanted

    def differences(self, colors: Float64Array) -> Float64Array:
        """Return colours minus the target, shape (n, 1) or (n, 3); NaN where the target allows any colour."""
        shown = np.minimum(colors, 1.0) if self.wanted.clamps else colors
        return np.where(self.wanted.roots > 0.0, self.wanted.seen(shown) - self.wanted.reachable, np.nan)

    def error(self, residual: Float64Array) -> FitError:
        """Return the root mean square and the largest difference for a weighted residual."""
        roots = self.wanted.roots
        off = np.divide(np.abs(residual), roots, out=np.zeros_like(roots), where=roots > 0.0)
        return FitError(math.sqrt(float(np.square(residual).sum())), float(off.max()))

    @cached_property
    def before(self) -> FitError:
        """Errors of the scene as it was given."""
        search = self.given
        shares = [
            search.columns.share(one, one.light) if one.count else share
            for one, share in zip(search.varied, self.shares, strict=True)
        ]
        problem = Problem.of(search.base, search.varied, shares, self.wanted)
        colors = problem.colors(np.concatenate([one.values for one in search.varied]))
        return self.error(problem.residual(colors, problem.clamped(colors, convex=False)))

    @cached_property
    def unmet(self) -> tuple[Unmet, ...]:
        """Parts of the target that no intensities can give, with reasons."""
        wanted, base = self.wanted, self.wanted.seen(self.problem.base)
        counts, gap = wanted.roots > 0.0, wanted.reachable - base
        reached = np.zeros(base.shape, bool)
        for colors, channel in self.problem.columns:
            lit = colors > 0.0
            if channel is not None:
                lit = lit & (np.arange(3) == channel)
            reached |= lit.any(axis=1, keepdims=True) if wanted.is_luminance else lit
        above = counts & wanted.clamps & (wanted.values > 1.0 + _VISIBLE)
        cases = (
            ("darker than ambient light, emission and fixed lights make them", counts & (gap < -_VISIBLE), gap),
            ("brighter, where none of the lights that vary arrives", counts & ~reached & (gap > _VISIBLE), gap),
            ("brighter than 1, where the light model clamps", above, wanted.values - 1.0),
        )
        found = (self._unmet(*case) for case in cases)
        return tuple(each for each in found if each.points)

    def _unmet(self, what: str, mask: BoolArray, gap: Float64Array) -> Unmet:
        share = float(np.square(self.wanted.roots[mask]).sum())
        return Unmet(what, int(mask.any(axis=1).sum()), share, float(np.abs(gap[mask]).max(initial=0.0)))

    @property
    def least_error(self) -> float:
        """Lower bound on the root mean square; 0 if there is none. See `Fit.least_error`.

        The squared error is convex, so that its tangent at the solution is a bound.
        """
        solution = self.solution
        if not solution.is_convex or self.off:
            return 0.0
        most, down = _MULTIPLE * max(float(solution.x.max(initial=0.0)), 1.0), solution.normal.right
        bound = solution.squares - 2.0 * float(np.maximum(down * (most - solution.x), -down * solution.x).sum())
        return math.sqrt(max(bound, 0.0))

    @cached_property
    def _whole(self) -> tuple[Normal, Float64Array, list[tuple[int, str, slice]]]:
        """Normal equations of all unknowns, their matrix with squared weights, and the rows of each field.

        For each field that varies, the last list has the light's number, the field's name, and the slice of its rows.
        """
        derivatives = self.search.derivatives(self.point)
        normal = joined(self.solution, derivatives)
        roots, rows = self.wanted.roots, []
        for channel, ((numbers, own), (others, more)) in enumerate(zip(self.solution.rows, derivatives, strict=True)):
            both = np.concatenate([numbers, len(self.solution.x) + others])
            rows.append((both, np.concatenate([own, more]) * roots[:, channel]))
        doubled = normal_equations(rows, self.solution.residual, len(normal.right)).matrix
        places, first = list[tuple[int, str, slice]](), 0
        for number, one in enumerate(self.varied):
            names = one.unknowns
            for field in dict.fromkeys(names):
                size = names.count(field)
                places.append((number, field, slice(first, first + size)))
                first += size
        for number, one in enumerate(self.varied):
            for field, chart in one.charts.items():
                places.append((number, field, slice(first, first + chart.count)))
                first += chart.count
        return normal, doubled, places

    @cached_property
    def covariance(self) -> Float64Array:
        """Covariance matrix of all unknowns, for noise of the target that is independent and equal at all points.

        The variance is estimated from the remaining differences. Entries are NaN for an unknown at its limit, or for an
        unknown that the target does not determine.
        """
        normal, doubled, _ = self._whole
        count, inner = len(normal.right), len(self.solution.x)
        scale = np.sqrt(np.diag(normal.matrix))
        free = (scale > 0.0) & np.concatenate([self.solution.x > 0.0, np.ones(count - inner, bool)])
        found = np.full((count, count), np.nan)
        used = np.flatnonzero(free)
        if not len(used):
            return found
        unit = np.outer(scale[used], scale[used])
        values, vectors = np.linalg.eigh(normal.matrix[np.ix_(used, used)] / unit)
        kept = values > _ALIKE * values[-1]
        inverse = (vectors[:, kept] / values[kept]) @ vectors[:, kept].T / unit
        noise = doubled[np.ix_(used, used)]
        variance = self.solution.squares / max(1.0 - float(np.trace(inverse @ noise)), np.finfo(float).tiny)
        own = inverse @ noise @ inverse * variance
        unknown = (np.abs(vectors[:, ~kept]) > _TAKES_PART).any(axis=1)
        own[unknown] = own[:, unknown] = np.nan
        found[np.ix_(used, used)] = own
        return found

    @cached_property
    def deviations(self) -> dict[str, dict[str, Deviation]]:
        """Standard deviations by light and field; see `Fit.deviations`."""
        _, _, places = self._whole
        covariance, found = self.covariance, dict[str, dict[str, Deviation]]()
        of_colors: list[slice | None] = [None] * len(self.varied)
        for number, field, place in places:
            one = self.varied[number]
            own = found.setdefault(one.label, {})
            part = covariance[place, place]
            if field in one.charts:
                value = getattr(self.point.lights[number], field)
                own[field] = one.charts[field].deviation(value, np.diag(part))
            elif one.colors:
                before = of_colors[number] or place  # a light's colours are next to each other
                of_colors[number] = slice(before.start, place.stop)
            else:
                own[field] = math.sqrt(part[0, 0])
        for one, colors in zip(self.varied, of_colors, strict=True):
            if colors is not None:
                found[one.label] |= self._of_products(one, self.solution.x[colors], covariance[colors, colors])
        return found

    @staticmethod
    def _of_products(one: Variation, products: Float64Array, covariance: Float64Array) -> dict[str, Deviation]:
        """Return standard deviations of a light's colours and, if it varies, of its intensity.

        The unknowns are `products` of intensity and colour channel, with their `covariance`. As in `Variation.solved`,
        the largest channel of all colours is constant; the intensity is the product for this channel divided by it.
        `one` is the light with the fields that vary.
        """
        found: dict[str, Deviation] = {}
        if "intensity" in one.linear:
            largest = int(np.argmax(products))
            scale = (one.values.max() / one.light.intensity if one.light.intensity else 0.0) or 1.0
            found["intensity"] = math.sqrt(covariance[largest, largest]) / scale
            units = np.eye(len(products))
            slopes = units - np.outer(products / (products[largest] or 1.0), units[largest])
            slopes *= scale / (products[largest] or 1.0)
            covariance = slopes @ covariance @ slopes.T
        else:
            covariance = covariance / one.light.intensity**2
        deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0)).reshape(-1, 3).tolist()
        return found | dict(zip(one.colors, map(tuple, deviations), strict=True))

    @cached_property
    def alike(self) -> tuple[tuple[str, ...], ...]:
        """Groups of lights that the target cannot distinguish.

        Some joint changes of a group's fields leave the colours the same.
        """
        normal, _, places = self._whole
        scale = np.sqrt(np.diag(normal.matrix))
        used = np.flatnonzero(scale > 0.0)
        if not len(used):
            return ()
        values, vectors = np.linalg.eigh(normal.matrix[np.ix_(used, used)] / np.outer(scale[used], scale[used]))
        owner = np.empty(len(scale), np.intp)
        for number, _, place in places:
            owner[place] = number
        groups = dict[tuple[str, ...], None]()
        for vector in vectors[:, values <= _ALIKE * values[-1]].T:
            numbers = sorted(set(owner[used[np.abs(vector) > _TAKES_PART]].tolist()))
            groups[tuple(self.varied[number].label for number in numbers)] = None
        return tuple(groups)


def _shown(value: Any) -> str:
    """Return the text for a number or several numbers, with four digits; "" for NaN or None."""
    if value is None:
        return ""
    numbers = np.ravel(value)
    return "" if np.isnan(numbers).all() else ", ".join(f"{number:.4g}" for number in numbers.tolist())


@dataclass(frozen=True, eq=False, repr=False)
class Fit:
    """Lights that give a mesh the colours that it should have; the result of `mesh.phong.fit`.

    Attributes
    ----------
    scene : Scene
        The scene with the lights that were found. Fields that did not vary are as given, to the bit.
    error : FitError
        Differences from the target: `.rms`, weighted by area, over points and channels; and `.largest`.
    violation : float
        Largest violation of the optimality conditions of the intensities and colours, from 0 to 1; rounding is about
        1e-12.
    least_error : float
        Proven lower bound of `error.rms` for these directions and positions. It holds for all intensities up to 1000
        times those found that clamp no colour whose target is below 1. It is 0 (no bound) if the fit clamps such
        colours, or if lights were chosen.
    is_within : bool
        True if `error.rms` is at most the tolerance.
    interrupted : bool
        True if Ctrl-C ended the search.
    seconds : float
        Duration of the fit in seconds.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> ball = pv.Sphere()
    >>> fit = ball.phong.fit(ph.DirectionalLight(name="sun"), ph.Material(), 0.4, {"sun": "intensity"})
    >>> fit.scene.lights[0].name, fit.lit["phong"].shape
    ('sun', (842, 3))
    """

    scene: Scene
    error: FitError
    violation: float
    least_error: float
    is_within: bool
    interrupted: bool
    seconds: float
    _analysis: Analysis
    _light: Callable[[Scene], Any]
    _rows: Mapping[str, slice]

    @classmethod
    def of(
        cls,
        scene: Scene,
        analysis: Analysis,
        light: Callable[[Scene], Any],
        rows: Mapping[str, slice],
        interrupted: bool,
        seconds: float,
        tolerance: float,
    ) -> Fit:
        """Return the result of a fit, made from its analysis.

        `light` lights the mesh or blocks with a scene. Entry `rows[path]` is the slice of a mesh's rows among all
        points. `interrupted` is true if Ctrl-C ended the search; `seconds` is its duration. `tolerance` is that of the
        fit.
        """
        error = analysis.error(analysis.solution.residual)
        measured = error, analysis.solution.violation, analysis.least_error, error.rms <= tolerance
        return cls(scene, *measured, interrupted, seconds, analysis, light, rows)

    @cached_property
    def lit(self) -> Any:
        """The mesh, or the blocks, lit by `scene`: the result of `mesh.phong.shade`."""
        return self._light(self.scene)

    @cached_property
    def differences(self) -> Any:
        """Colours minus the target at the points of `lit`; NaN where the target allows any colour.

        Shape (n_points, 3) for a target of colours, (n_points,) for luminances. For blocks, a dictionary from path to
        array.
        """
        return self._by_path(self._analysis.differences(self._analysis.solution.colors))

    @property
    def before(self) -> FitError:
        """Differences between the colours under the given scene and the target, computed at the first use."""
        return self._analysis.before

    @property
    def unmet(self) -> tuple[Unmet, ...]:
        """Parts of the target that no intensities can give.

        Each has `.what` (the reason), `.points`, `.share` and `.largest`.
        """
        return self._analysis.unmet

    @property
    def deviations(self) -> Mapping[str, Mapping[str, Deviation]]:
        """Standard deviations, as ``deviations[light][field]``, computed at the first use.

        The unit is the field's; for a direction, it is an angle in degrees. They assume independent noise with the same
        variance at all points, estimated from the remaining differences. NaN marks a value at its limit, or a value
        that the target does not determine.
        """
        return self._analysis.deviations

    @property
    def alike(self) -> tuple[tuple[str, ...], ...]:
        """Groups of lights that the target cannot distinguish.

        Other values of their fields that give the same sum of colours fit as well.
        """
        return self._analysis.alike

    @property
    def changes(self) -> list[tuple[str, str, str, str, str]]:
        """Rows of the report: light, field, value before, value after, standard deviation."""
        analysis, rows = self._analysis, list[tuple[str, str, str, str, str]]()
        lights = list(self.scene.lights)
        for one in analysis.varied:
            found = lights[one.index]
            for field in (each.name for each in fields(found)):
                before, after = getattr(one.light, field), getattr(found, field)
                if field in one.linear or field in one.charts:
                    sure = self.deviations[one.label].get(field, math.nan)
                    rows.append((one.label, field, _shown(before), _shown(after), _shown(sure)))
        rows += [(one.label, "on", "True", "False", "") for one in analysis.off]
        return rows

    def plot(
        self,
        *,
        off_screen: bool | None = None,
        screenshot: Any = None,
        window_size: tuple[int, int] = (1280, 460),
        background: str = "white",
    ) -> Any:
        """Show the target, the result and their difference side by side, as the scene's viewer sees them.

        Parameters
        ----------
        off_screen : bool, optional
            True to draw without a window. By default, PyVista's setting.
        screenshot : str or path, optional
            File for a picture.
        window_size : tuple of int, default (1280, 460)
            Width and height in pixels.
        background : str, default "white"
            A colour name or hex string.

        Returns
        -------
        Any
            What ``pyvista.Plotter.show`` returns.

        Examples
        --------
        >>> import pyvista as pv, pvphong as ph
        >>> fit = pv.Sphere().phong.fit(ph.DirectionalLight(), ph.Material(), 0.4, "intensity")
        >>> fit.plot(off_screen=True)
        """
        from pvphong.studies.fitting.figure import show

        return show(self, off_screen, screenshot, window_size, background)

    @property
    def asked(self) -> Any:
        """The target at the points of `lit`, in the shape of `differences`; NaN where any colour is allowed."""
        wanted = self._analysis.wanted
        return self._by_path(np.where(wanted.roots > 0.0, wanted.values, np.nan))

    def _by_path(self, rows: Float64Array) -> Any:
        """Return `rows`, the values at all points; for blocks, split into a dictionary from path to array."""
        rows = rows[:, 0] if self._analysis.wanted.is_luminance else rows
        return rows if "" in self._rows else {path: rows[part] for path, part in self._rows.items()}

    def __repr__(self) -> str:
        analysis = self._analysis
        lights, off = len(analysis.varied), f" of {len(analysis.given.varied)}" * bool(analysis.off)
        rms, before = self.error.rms, self.before.rms
        of = f"{lights}{off} light{'s' * (lights != 1 or bool(off))}"
        return f"<Fit of {of}: error {rms:.3g} (before: {before:.3g}), {self._optimum}>"

    @property
    def _optimum(self) -> str:
        return "interrupted" if self.interrupted else f"optimality violated by {self.violation:.1g}"

    @property
    def sentences(self) -> list[str]:
        """Sentences of the report."""
        analysis = self._analysis
        said = [
            f"Root mean square {self.error.rms:.3g}, largest difference {self.error.largest:.3g}; before: "
            f"{self.before.rms:.3g} and {self.before.largest:.3g}. {self.seconds:.2g} s."
        ]
        if self.interrupted:
            said.append("The search was interrupted: these are the best lights so far.")
        said.append(f"Optimality conditions of intensities and colours: violated by {self.violation:.1g}.")
        if self.least_error > _VISIBLE / 10.0:
            unless = " without clamping at 1 where less is asked for" if analysis.wanted.clamps else ""
            said.append(f"No intensities of these lights come nearer than {self.least_error:.3g}{unless}.")
        said += [
            f"The target asks for {each.points} points ({each.share:.1%} of the weight) to be {each.what}: by up to "
            f"{each.largest:.2g}."
            for each in self.unmet
        ]
        for group in self.alike:
            names = " and ".join(map(repr, group))
            said.append(
                f"The target does not tell {names} apart: other values give the same colours."
                if len(group) > 1
                else f"The target does not determine all fields of {names}."
            )
        return said

    def __str__(self) -> str:
        from rich import box
        from rich.table import Table

        table = Table(title=repr(self)[1:-1], box=box.SIMPLE, padding=(0, 1, 0, 0), width=WIDTH)
        for name in ("light", "field", "before", "found", "±"):
            table.add_column(name, overflow="fold")
        for row in self.changes:
            table.add_row(*row)
        lines = "\n".join(line for sentence in self.sentences for line in wrapped(sentence))
        return f"{rendered([table])}\n{lines}"

    def _repr_html_(self) -> str:
        return html_table(
            " ".join([repr(self)[1:-1], *self.sentences]), ("light", "field", "before", "found", "±"), self.changes
        )
