"""The figure of a report: Pareto fronts, linked pictures, the histogram of errors, the ledger. Needs Matplotlib."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.base.files import written_aside
from pvphong.studies.accuracy.pareto import COLORS, GREY, INK, RED, draw_fronts
from pvphong.studies.accuracy.pictures import linked_pictures
from pvphong.studies.accuracy.result import Result
from pvphong.studies.accuracy.tables import is_noise, number, seconds

_FORMATS = (".png", ".pdf", ".svg")
_SIZE = (16.0, 13.5)


def refuse_format(path: str | os.PathLike[str]) -> None:
    """Raise ``ValueError`` unless the suffix is one that figures are drawn in, and Matplotlib is there."""
    check.choice("suffix of path", Path(path).suffix.lower(), _FORMATS)
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError as error:
        raise ValueError('Figures need Matplotlib: pip install "pvphong[plot]".') from error


def save_figure(result: Result, path: str | os.PathLike[str]) -> None:
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
    rows[0].suptitle(f"What accuracy costs in time: {result.facts['mesh']}", fontsize=15, fontweight="bold")
    draw_fronts(rows[0], result)
    _draw_pictures(rows[1], result)
    left, right = rows[2].subplots(1, 2)
    _draw_histogram(left, result)
    _draw_ledger(right, result)
    figure.supxlabel(_footnote(result), fontsize=9, color=INK)
    with written_aside(path) as aside:
        figure.savefig(aside, dpi=100)


def _footnote(result: Result) -> str:
    facts = result.facts
    return f"{facts['machine']}; threads: {facts['threads']}; {facts['date']}; {facts['measured']}"


def _draw_pictures(part: Any, result: Result) -> None:
    try:
        pictures = linked_pictures(result)
    except ValueError as error:
        part.subplots().set_axis_off()
        part.text(0.5, 0.5, str(error), ha="center", wrap=True)
        return
    reference = pictures[0].pixels
    above, below = part.subplots(2, len(pictures), height_ratios=(1.0, 0.05), squeeze=False)
    for axes, place, picture in zip(above, below, pictures, strict=True):
        axes.imshow(_cropped(picture.pixels, reference))
        axes.set_title(picture.title, fontsize=11)
        axes.set_axis_off()
        if picture.scale is None:
            place.set_axis_off()
        else:
            _draw_scale(part, place, picture.scale, result.tolerance)


def _draw_scale(part: Any, place: Any, scale: Any, tolerance: float) -> None:
    """A colour bar with its ends, or with the tolerance among the powers of ten."""
    bar = part.colorbar(scale, cax=place, orientation="horizontal")
    place.tick_params(labelsize=9)
    low, high = scale.get_clim()
    if low < 0.0:
        bar.set_ticks([low, 0.0, high], labels=[f"−{number(high)}", "0", f"+{number(high)}"])
        for label, side in zip(place.get_xticklabels(), ("left", "center", "right"), strict=True):
            label.set_ha(side)
    else:
        place.axvline(tolerance, color=INK, linewidth=1.5)


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


def _draw_histogram(axes: Any, result: Result) -> None:
    at_vertices = np.abs(result.chosen_colors - result.reference_colors).max(axis=1)
    chosen = result.best()
    name = "chosen" if chosen is None else chosen.name
    each = np.full(len(at_vertices), 1.0 / len(at_vertices))
    shown = [(f"at {len(at_vertices)} vertices: {name}", at_vertices, each, COLORS["light model"])]
    if len(result.inside_errors):
        label = f"inside {len(result.inside_errors)} triangles of the mesh as it is"
        shown.append((label, result.inside_errors, result.inside_areas, COLORS["interpolation"]))
    some = np.concatenate([values[values > 0.0] for _, values, _, _ in shown])
    low = max(float(np.percentile(some, 1.0)), 1e-17) if len(some) else 1e-17
    bins = np.geomspace(low, max(float(some.max(initial=1e-2)), result.tolerance) * 1.5, 60)
    for label, values, parts, color in shown:
        part = parts[values < low].sum()
        below = f" ({part:.0%} below {number(low)})" if part else ""
        axes.hist(values, bins=bins, weights=100.0 * parts, color=color, alpha=0.65, label=label + below)
    axes.axvline(result.tolerance, color=RED, linestyle="--", linewidth=1.2)
    axes.axvline(1.0 / 255.0, color=GREY, linestyle=":", linewidth=1.0)
    axes.set_ylim(0.05, 100.0)  # before the scale, which finds no limits where all errors are 0
    axes.set(
        xscale="log",
        yscale="log",
        title="How errors are spread",
        xlabel="colour error",
        ylabel="% of vertices, or of the area",
    )
    axes.legend(fontsize=9, frameon=False)


def _draw_ledger(axes: Any, result: Result) -> None:
    entries = [entry for entry in result.ledger if entry.cost is not None][::-1]
    axes.set_title("What each effect costs, and the largest error without it")
    axes.set_xlabel("time with it minus time without it, in ms: median and quartiles")
    for place, entry in enumerate(entries):
        cost = entry.cost
        assert cost is not None
        color = GREY if is_noise(cost) else COLORS["arithmetic"]
        spread = [[(cost.median - cost.low) * 1e3], [(cost.high - cost.median) * 1e3]]
        axes.barh(place, cost.median * 1e3, xerr=spread, color=color, ecolor=INK, capsize=2, height=0.6)
        error = "" if entry.error is None else f"error {number(entry.error)}"
        spent = "in the noise" if is_noise(cost) else seconds(cost.median)
        said = f"{spent}, {error}{'' if entry.runs else ', left out'}"
        axes.annotate(
            said, (max(cost.high, 0.0) * 1e3, place), xytext=(8, 0), textcoords="offset points", va="center", fontsize=9
        )
    axes.set_yticks(range(len(entries)), [entry.effect for entry in entries])
    axes.axvline(0.0, color=INK, linewidth=0.8)
    ends = [end * 1e3 for entry in entries if entry.cost for end in (entry.cost.low, entry.cost.high)]
    low, high = min([0.0, *ends]), max([1e-9, *ends])
    axes.set_xlim(low - 0.03 * (high - low), high + 0.45 * (high - low))
