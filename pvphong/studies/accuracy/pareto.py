"""Pareto fronts: time against error, one marker a row, for each kind of error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pvphong.studies.accuracy.result import Result
from pvphong.studies.accuracy.rows import KINDS, Kind, Row

COLORS: dict[str, str] = {
    "arithmetic": "#1b6ca8",
    "light model": "#c2571a",
    "sampling": "#6b4c9a",
    "interpolation": "#2a7f3f",
}
GREY, INK, RED = "#9a9a9a", "#303030", "#b01030"

_MARKERS: dict[str, str] = {"arithmetic": "o", "light model": "s", "sampling": "D", "interpolation": "^"}
_STAR = "#e0a800"

_DATA = 0.5
"""The part of a front's width that markers take; names stand beside it."""


def draw_fronts(part: Any, result: Result) -> None:
    """Every kind of row beside the others, in a part of a Matplotlib figure."""
    shown = [kind for kind in KINDS if any(row.kind == kind for row in result.rows)]
    for axes, kind in zip(np.atleast_1d(part.subplots(1, len(shown))), shown, strict=True):
        _draw_front(axes, result, kind)


_TITLES: dict[str, str] = {
    "arithmetic": "arithmetic, at the vertices",
    "light model": "light model, at the vertices",
    "sampling": "sampling, at the vertices",
    "interpolation": "interpolation, inside triangles",
}


def _draw_front(axes: Any, result: Result, kind: Kind) -> None:
    rows = sorted((row for row in result.rows if row.kind == kind), key=lambda row: row.time.median)
    floor = _floor(rows, result.tolerance)
    chosen = result.chosen
    axes.set(xscale="log", yscale="log", title=_TITLES[kind])
    axes.set_xlabel("time in ms: median and quartiles")
    axes.set_ylabel("colour error: largest (marker) and RMS (tick)")
    _frame(axes, rows, floor, result.tolerance)  # first, for Matplotlib finds no limits of its own around one time
    front = [row for row in rows if row.on_front]
    xs, ys = [row.time.median * 1e3 for row in front], [_height(row, floor) for row in front]
    axes.step(xs, ys, where="post", color=COLORS[kind], alpha=0.35, linewidth=2, zorder=1)
    for row in rows:
        _draw_row(axes, row, floor, any(row is best for best in chosen))
    axes.axhline(result.tolerance, color=RED, linewidth=1.2, linestyle="--", zorder=0)
    axes.annotate(
        f"tolerance {result.tolerance * 255.0:.3g}/255", (0.01, result.tolerance),
        xycoords=("axes fraction", "data"), va="bottom", color=RED, fontsize=9,
    )  # fmt: skip
    _label(axes, rows, floor)
    axes.grid(visible=True, which="major", color="#e6e6e6", zorder=0)


def _floor(rows: Sequence[Row], tolerance: float) -> float:
    """Where an error of 0 is drawn: a decade and a half below the least that is not."""
    least = min([row.error.rms for row in rows if row.error.rms] + [tolerance])
    return float(10.0 ** (np.floor(np.log10(least)) - 1.5))


def _height(row: Row, floor: float) -> float:
    return row.error.largest or floor


def _draw_row(axes: Any, row: Row, floor: float, is_chosen: bool) -> None:
    color = COLORS[row.kind] if row.on_front else GREY
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
        axes.plot(x, y, marker="*", markersize=22, color=_STAR, markeredgecolor=INK, zorder=4)
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
    digits = (1.0, 3.0) if wide > 1.5 else (1.0, 2.0, 5.0) if wide > 0.5 else tuple(range(1, 10))
    axes.xaxis.set_major_locator(LogLocator(subs=digits))
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
            textcoords="axes fraction", va="center", fontsize=8.5, color=INK if row.on_front else GREY, zorder=2,
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
