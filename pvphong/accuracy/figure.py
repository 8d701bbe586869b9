"""The figure of a report: Pareto fronts, linked pictures, the histogram of errors, the ledger. Needs Matplotlib."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pvphong import _check
from pvphong._files import written_aside
from pvphong.accuracy.pictures import ABOVE, BELOW, MOST_STEPS, NONE, STEP, linked_pictures
from pvphong.accuracy.rows import Kind, Row
from pvphong.accuracy.tables import is_noise, number, seconds

if TYPE_CHECKING:
    from pvphong.accuracy.report import Tradeoff

_FORMATS = (".png", ".pdf", ".svg")
_SIZE = (16.0, 13.5)
_COLORS: dict[str, str] = {"arithmetic": "#1b6ca8", "light model": "#c2571a", "interpolation": "#2a7f3f"}
_MARKERS: dict[str, str] = {"arithmetic": "o", "light model": "s", "interpolation": "^"}
_GREY, _INK = "#9a9a9a", "#303030"
_STAR, _RED = "#e0a800", "#b01030"

_DATA = 0.5
"""The part of a front's width that markers take; names stand beside it."""


def refuse_format(path: str | os.PathLike[str]) -> None:
    """Raise ``ValueError`` unless the suffix is one that figures are drawn in, and Matplotlib is there."""
    _check.choice("suffix of path", Path(path).suffix.lower(), _FORMATS)
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError as error:
        raise ValueError('Figures need Matplotlib: pip install "pvphong[plot]".') from error


def save_figure(report: Tradeoff, path: str | os.PathLike[str]) -> None:
    """Draw a report into a file.

    Raises
    ------
    ValueError
        If Matplotlib is missing, the suffix is none that it is drawn in, or the file cannot be written.
    """
    refuse_format(path)
    from matplotlib.figure import Figure

    figure = Figure(figsize=_SIZE, layout="constrained")
    rows: Any = figure.subfigures(3, 1, height_ratios=(1.1, 0.6, 0.9))
    rows[0].suptitle(f"What accuracy costs in time: {report.facts['mesh']}", fontsize=15, fontweight="bold")
    _draw_fronts(rows[0], report)
    _draw_pictures(rows[1], report)
    left, right = rows[2].subplots(1, 2)
    _draw_histogram(left, report)
    _draw_ledger(right, report)
    figure.supxlabel(_footnote(report), fontsize=9, color=_INK)
    with written_aside(path) as aside:
        figure.savefig(aside, dpi=100)


def _footnote(report: Tradeoff) -> str:
    facts = report.facts
    return f"{facts['machine']}; threads: {facts['threads']}; {facts['date']}; {facts['measured']}"


def _draw_fronts(part: Any, report: Tradeoff) -> None:
    kinds: list[Kind] = ["arithmetic", "light model", "interpolation"]
    shown = [kind for kind in kinds if any(row.kind == kind for row in report.rows)]
    for axes, kind in zip(np.atleast_1d(part.subplots(1, len(shown))), shown, strict=True):
        _draw_front(axes, report, kind)


_TITLES: dict[str, str] = {
    "arithmetic": "arithmetic, at the vertices",
    "light model": "light model, at the vertices",
    "interpolation": "interpolation, inside triangles",
}


def _draw_front(axes: Any, report: Tradeoff, kind: Kind) -> None:
    rows = sorted((row for row in report.rows if row.kind == kind), key=lambda row: row.time.median)
    floor = _floor(rows, report.tolerance)
    chosen = [report.best(), report.best(inside=True)]
    axes.set(xscale="log", yscale="log", title=_TITLES[kind])
    axes.set_xlabel("time in ms: median and quartiles")
    axes.set_ylabel("colour error: largest (marker) and RMS (tick)")
    front = [row for row in rows if row.on_front]
    xs, ys = [row.time.median * 1e3 for row in front], [_height(row, floor) for row in front]
    axes.step(xs, ys, where="post", color=_COLORS[kind], alpha=0.35, linewidth=2, zorder=1)
    for row in rows:
        _draw_row(axes, row, floor, any(row is best for best in chosen))
    axes.axhline(report.tolerance, color=_RED, linewidth=1.2, linestyle="--", zorder=0)
    axes.annotate(
        f"tolerance {report.tolerance * 255.0:.3g}/255", (0.01, report.tolerance),
        xycoords=("axes fraction", "data"), va="bottom", color=_RED, fontsize=9,
    )  # fmt: skip
    _frame(axes, rows, floor, report.tolerance)
    _label(axes, rows, floor)
    axes.grid(visible=True, which="major", color="#e6e6e6", zorder=0)


def _floor(rows: Sequence[Row], tolerance: float) -> float:
    """Where an error of 0 is drawn: a decade and a half below the least that is not."""
    least = min([row.error.rms for row in rows if row.error.rms] + [tolerance])
    return float(10.0 ** (np.floor(np.log10(least)) - 1.5))


def _height(row: Row, floor: float) -> float:
    return row.error.largest or floor


def _draw_row(axes: Any, row: Row, floor: float, is_chosen: bool) -> None:
    color = _COLORS[row.kind] if row.on_front else _GREY
    x, y = row.time.median * 1e3, _height(row, floor)
    spread = [[x - row.time.low * 1e3], [row.time.high * 1e3 - x]]
    axes.errorbar(x, y, xerr=spread, color=color, elinewidth=1.4, capsize=3, zorder=2)
    if row.error.rms:
        axes.plot([x, x], [row.error.rms, y], color=color, linewidth=0.8, zorder=2)
        axes.plot(x, row.error.rms, marker="_", markersize=9, color=color, zorder=2)
    if row.promised:
        axes.plot([x, x], [y, row.promised], color=color, linewidth=0.8, linestyle=":", zorder=2)
        axes.plot(x, row.promised, marker="v", markersize=7, color="white", markeredgecolor=color, zorder=3)
    face = "white" if row.is_peer else color
    if is_chosen:
        axes.plot(x, y, marker="*", markersize=22, color=_STAR, markeredgecolor=_INK, zorder=4)
    else:
        axes.plot(x, y, marker=_MARKERS[row.kind], markersize=8, color=face, markeredgecolor=color, zorder=3)


def _frame(axes: Any, rows: Sequence[Row], floor: float, tolerance: float) -> None:
    """Room for the column of labels on the right, ticks that can be read, and a word for 0."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullLocator

    low, high = min(row.time.low for row in rows) * 1e3, max(row.time.high for row in rows) * 1e3
    wide = max(np.log10(high / low), 0.15)
    axes.set_xlim(low / 10 ** (0.08 * wide), high * 10 ** ((1.0 / _DATA - 1.0) * wide))
    top = max([tolerance] + [row.error.largest for row in rows])
    axes.set_ylim(floor / 3.0, top * 4.0)
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if wide > 0.5 else tuple(range(1, 10))))
    ticks = [tick for tick in axes.xaxis.get_major_locator()() if low * 0.9 <= tick <= high * 1.1]
    axes.xaxis.set_major_locator(FixedLocator(ticks))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.4g}"))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_minor_locator(NullLocator())
    if any(not row.error.largest for row in rows):
        axes.axhspan(floor / 3.0, floor * 3.0, color="#f2f2f2", zorder=0)
        axes.annotate("0", (-0.012, floor), xycoords=("axes fraction", "data"), ha="right", va="center")
        axes.set_yticks([tick for tick in axes.get_yticks() if floor * 3.0 < tick <= top * 4.0])


def _label(axes: Any, rows: Sequence[Row], floor: float) -> None:
    """A column of names on the right, in the order of the errors, each with a thin line to its marker."""
    low, high = np.log10(axes.get_ylim())
    ordered = sorted(rows, key=lambda row: (_height(row, floor), row.time.median))
    heights = [(np.log10(_height(row, floor)) - low) / (high - low) for row in ordered]
    for row, place in zip(ordered, _spread(heights, least=0.062), strict=True):
        text = f"{row.name}{' (peer)' if row.is_peer else ''}"
        if row.kind == "interpolation" and row.backend != "VTK":
            text += f", {_short(row.points)} points"
        axes.annotate(
            text, (row.time.median * 1e3, _height(row, floor)), xytext=(_DATA + 0.06, place),
            textcoords="axes fraction", va="center", fontsize=8.5, color=_INK if row.on_front else _GREY, zorder=2,
            bbox={"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.85},
            arrowprops={"arrowstyle": "-", "color": "#c9c9c9", "linewidth": 0.7, "relpos": (0.0, 0.5)},
        )  # fmt: skip


def _spread(heights: Sequence[float], least: float) -> list[float]:
    """Sorted places in [0, 1] near the wanted ones, apart from each other."""
    places: list[float] = []
    for height in heights:
        places.append(max(height, 0.04, places[-1] + least if places else 0.0))
    ceiling = 0.97
    for index in reversed(range(len(places))):
        places[index] = min(places[index], ceiling)
        ceiling = places[index] - least
    return places


def _short(count: int) -> str:
    return f"{count}" if count < 10_000 else f"{count / 1e3:.0f}k" if count < 1_000_000 else f"{count / 1e6:.1f}M"


def _draw_pictures(part: Any, report: Tradeoff) -> None:
    try:
        pictures = linked_pictures(report)
    except ValueError as error:
        part.subplots().set_axis_off()
        part.text(0.5, 0.5, str(error), ha="center", wrap=True)
        return
    chosen = report.best()
    all_axes = np.atleast_1d(part.subplots(1, len(pictures)))
    for axes, (name, picture) in zip(all_axes, pictures.items(), strict=True):
        axes.imshow(_cropped(picture, pictures["reference"]))
        axes.set_title(f"chosen: {chosen.name}" if name == "chosen" and chosen else name, fontsize=11)
        axes.set_axis_off()
    _draw_scale(part, all_axes)


def _cropped(picture: Any, guide: Any) -> Any:
    """The same part of every picture: where the mesh is, with a margin."""
    seen = (guide != guide[0, 0]).any(axis=2)
    if not seen.any():
        return picture
    ranges = []
    for axis in (1, 0):
        places = np.flatnonzero(seen.any(axis=axis))
        ranges.append(slice(max(places[0] - 15, 0), places[-1] + 16))
    return picture[ranges[0], ranges[1]]


def _draw_scale(part: Any, all_axes: Any) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import BoundaryNorm, LinearSegmentedColormap

    colors = LinearSegmentedColormap.from_list("steps", [BELOW, NONE, ABOVE], N=2 * MOST_STEPS + 1)
    edges = np.arange(-MOST_STEPS, MOST_STEPS + 2) - 0.5
    bar = part.colorbar(
        ScalarMappable(BoundaryNorm(edges, colors.N), colors), ax=list(all_axes), shrink=0.85, extend="both",
        ticks=range(-MOST_STEPS, MOST_STEPS + 1), extendfrac=0.06,
    )  # fmt: skip
    bar.set_label("error in steps of 1/255", fontsize=9)


def _draw_histogram(axes: Any, report: Tradeoff) -> None:
    at_vertices = np.abs(report.chosen_colors - report.reference_colors).max(axis=1)
    chosen = report.best()
    name = "chosen" if chosen is None else chosen.name
    shown = [(f"at {len(at_vertices)} vertices: {name}", at_vertices, _COLORS["light model"])]
    if len(report.inside_errors):
        label = f"inside {len(report.inside_errors)} triangles of the mesh as it is"
        shown.append((label, report.inside_errors, _COLORS["interpolation"]))
    some = np.concatenate([values[values > 0.0] for _, values, _ in shown])
    low = max(float(np.percentile(some, 1.0)), 1e-17) if len(some) else 1e-17
    bins = np.geomspace(low, max(float(some.max(initial=1e-2)), report.tolerance) * 1.5, 60)
    for label, values, color in shown:
        part = np.mean(values < low)
        below = f" ({part:.0%} below {number(low)})" if part else ""
        weights = np.full(len(values), 100.0 / len(values))
        axes.hist(values, bins=bins, weights=weights, color=color, alpha=0.65, label=label + below)
    axes.axvline(report.tolerance, color=_RED, linestyle="--", linewidth=1.2)
    axes.axvline(STEP, color=_GREY, linestyle=":", linewidth=1.0)
    axes.set(xscale="log", yscale="log", title="How errors are spread", xlabel="colour error", ylabel="% of places")
    axes.set_ylim(0.05, 100.0)
    axes.legend(fontsize=9, frameon=False)


def _draw_ledger(axes: Any, report: Tradeoff) -> None:
    entries = [entry for entry in report.ledger if entry.cost is not None][::-1]
    axes.set_title("What each effect costs, and the largest error without it")
    axes.set_xlabel("time with it minus time without it, in ms: median and quartiles")
    for place, entry in enumerate(entries):
        cost = entry.cost
        assert cost is not None
        color = _GREY if is_noise(cost) else _COLORS["arithmetic"]
        spread = np.array([[cost.median - cost.low], [cost.high - cost.median]]) * 1e3
        axes.barh(place, cost.median * 1e3, xerr=spread, color=color, ecolor=_INK, capsize=2, height=0.6)
        error = "" if entry.error is None else f"error {number(entry.error)}"
        said = f"{seconds(cost.median)}, {error}{'' if entry.runs else ', left out'}"
        axes.annotate(
            said, (max(cost.high, 0.0) * 1e3, place), xytext=(8, 0), textcoords="offset points", va="center", fontsize=9
        )
    axes.set_yticks(range(len(entries)), [entry.effect for entry in entries])
    axes.axvline(0.0, color=_INK, linewidth=0.8)
    ends = [end * 1e3 for entry in entries if entry.cost for end in (entry.cost.low, entry.cost.high)]
    low, high = min([0.0, *ends]), max([1e-9, *ends])
    axes.set_xlim(low - 0.03 * (high - low), high + 0.45 * (high - low))
