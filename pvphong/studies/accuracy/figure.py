"""Figure of a report: Pareto fronts (the rows that no other row beats in error and time), pictures, a histogram of
errors, and the costs of effects. Needs Matplotlib.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from pvphong.base.types import BoolArray, Float64Array
from pvphong.meshes.default_scene import default_scene
from pvphong.meshes.surfaces import has_only_triangles
from pvphong.studies.accuracy.interpolation import ADAPTIVE, AS_IT_IS, UNIFORM
from pvphong.studies.accuracy.physics import (
    PANEL_HEIGHT,
    Physics,
    bare_surface,
    draw_physics,
    drawn,
    figure_in,
    in_worst_channel,
)
from pvphong.studies.accuracy.result import KINDS, Kind, Result, Row, number

_HEIGHT = 13.5  # inches

_GREY, _INK, _RED, _STAR = "#9a9a9a", "#303030", "#b01030", "#e0a800"
_COLORS: dict[str, str] = {
    "arithmetic": "#1b6ca8",
    "light model": "#c2571a",
    "sampling": "#6b4c9a",
    "interpolation": "#2a7f3f",
}
_MARKERS: dict[str, str] = {"arithmetic": "o", "light model": "s", "sampling": "D", "interpolation": "^"}

# Fraction of the width of a Pareto plot for its markers. The rest, on the right, is for the names of the rows.
_DATA = 0.5

# Size of the pictures in pixels. If the mesh covers less than _LEAST_SEEN of a picture, another viewer is used.
_PICTURE, _LEAST_SEEN = (640, 480), 0.002

# Smallest error inside triangles that has a colour, as a fraction of the tolerance.
_LEAST_SHOWN = 0.01


def save_figure(report: Result, path: str | os.PathLike[str], physics: Physics | None = None) -> None:
    """Draw a report into a file. With `physics`, add a panel at the bottom that compares light models.

    Raises
    ------
    ValueError
        If the suffix is not supported, or the file cannot be written.
    """
    facts, has_physics = report.facts, physics is not None
    with figure_in(path, _HEIGHT + PANEL_HEIGHT * has_physics) as figure:
        rows: Any = figure.subfigures(3 + has_physics, 1, height_ratios=(1.1, 0.6, 0.9, 0.9)[: 3 + has_physics])
        rows[0].suptitle(f"Accuracy against time: {facts['mesh']}", fontsize=15, fontweight="bold")
        draw_fronts(rows[0], report)
        _draw_pictures(rows[1], report)
        left, right = rows[2].subplots(1, 2)
        _draw_histogram(left, report)
        _draw_ledger(right, report)
        if physics is not None:
            draw_physics(rows[3], physics)
        footnote = f"{facts['machine']}; threads: {facts['threads']}; {facts['date']}; {facts['measured']}"
        figure.supxlabel(footnote, fontsize=9, color=_INK)


# --- Pareto fronts: time against error, one marker per row, for each kind of error


def draw_fronts(part: Any, report: Result) -> None:
    """Draw a report's Pareto fronts side by side, one for each kind of error. `part` is a Matplotlib subfigure."""
    shown = [kind for kind in KINDS if any(row.kind == kind for row in report.rows)]
    for axes, kind in zip(np.atleast_1d(part.subplots(1, len(shown))), shown, strict=True):
        _draw_front(axes, report, kind)


def _how_it_falls(rows: Sequence[Row]) -> list[str]:
    """Return lines of text on how fast the RMS interpolation error falls as splitting adds points to a mesh.

    `rows` are the rows for the original mesh, uniform splitting and adaptive splitting. With uniform splitting, the
    triangles along a jump of the colour keep their errors. With n points, the area of these triangles is proportional
    to n^(-1/2), so the RMS error is proportional to n^(-1/4). Cuts along the jump remove these errors.
    """
    named = {row.name: row for row in rows if row.error.rms}
    start, lines = named.get(AS_IT_IS), list[str]()
    finest = next((named[name] for name in map(UNIFORM.format, (3, 2, 1)) if name in named), None)
    if start is not None and finest is not None:
        power = np.log(finest.error.rms / start.error.rms) / np.log(finest.points / start.points)
        lines.append(f"refined n×: RMS falls as points$^{{{power:.2f}}}$")
    if start is not None and (cut := named.get(ADAPTIVE)) is not None:
        less, more = start.error.rms / cut.error.rms, cut.points / start.points
        lines.append(f"{ADAPTIVE}: RMS {less:.3g}× less by {more:.3g}× the points")
    return lines


def _height(row: Row, zero: float) -> float:
    """Return the vertical position of the marker for a row: the row's largest error, or `zero` if this error is 0.

    The axis is logarithmic and has no 0.
    """
    return row.error.largest or zero


def _draw_front(axes: Any, report: Result, kind: Kind) -> None:
    rows = sorted((row for row in report.rows if row.kind == kind), key=lambda row: row.time.median)
    tolerance, chosen = report.tolerance, report.chosen
    # An error of 0 is drawn one and a half decades below the smallest other error.
    least = min([row.error.rms for row in rows if row.error.rms] + [tolerance])
    zero = float(10.0 ** (np.floor(np.log10(least)) - 1.5))
    where = "inside triangles" if kind == "interpolation" else "at the vertices"
    axes.set(xscale="log", yscale="log", title=f"{kind}, {where}")
    falls = _how_it_falls(rows) if kind == "interpolation" else []
    axes.set_xlabel("\n".join(["time in ms: median and quartiles", *falls]))
    axes.set_ylabel("colour error: largest (marker) and RMS (tick)")
    _set_limits(axes, rows, zero, tolerance)  # before drawing: Matplotlib finds no limits for a single time

    front = [row for row in rows if row.on_front]
    xs, ys = [row.time.median * 1e3 for row in front], [_height(row, zero) for row in front]
    axes.step(xs, ys, where="post", color=_COLORS[kind], alpha=0.35, linewidth=2, zorder=1)
    for row in rows:
        color = _COLORS[kind] if row.on_front else _GREY
        x, y = row.time.median * 1e3, _height(row, zero)
        spread = [[x - row.time.low * 1e3], [row.time.high * 1e3 - x]]
        axes.errorbar(x, y, xerr=spread, color=color, elinewidth=1.4, capsize=3, zorder=2)
        if row.error.rms:
            axes.plot([x, x], [row.error.rms, y], color=color, linewidth=0.8, zorder=2)
            axes.plot(x, row.error.rms, marker="_", markersize=9, color=color, zorder=2)
        if row.error_bound:
            axes.plot([x, x], [y, row.error_bound], color=color, linewidth=0.8, linestyle=":", zorder=2)
            axes.plot(x, row.error_bound, marker="v", markersize=7, color="white", markeredgecolor=color, zorder=3)
        if row in chosen:
            axes.plot(x, y, marker="*", markersize=22, color=_STAR, markeredgecolor=_INK, zorder=4)
        else:
            face = "white" if row.is_peer else color
            axes.plot(x, y, marker=_MARKERS[kind], markersize=8, color=face, markeredgecolor=color, zorder=3)
    axes.axhline(tolerance, color=_RED, linewidth=1.2, linestyle="--", zorder=0)
    axes.annotate(
        f"tolerance {tolerance * 255.0:.3g}/255", (0.01, tolerance),
        xycoords=("axes fraction", "data"), va="bottom", color=_RED, fontsize=9,
    )  # fmt: skip
    _label(axes, rows, zero)
    axes.grid(visible=True, which="major", color="#e6e6e6", zorder=0)


def _set_limits(axes: Any, rows: Sequence[Row], zero: float, tolerance: float) -> None:
    """Set the limits and ticks of a front's axes, with room for labels on the right.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        The axes.
    rows : sequence of Row
        Rows that are drawn.
    zero : float
        Vertical position at which an error of 0 is drawn. It gets a tick label.
    tolerance : float
        Tolerance of the report. The limits include it.
    """
    from matplotlib.ticker import FixedLocator, LogLocator

    low, high = min(row.time.low for row in rows) * 1e3, max(row.time.high for row in rows) * 1e3
    wide = max(np.log10(high / low), 0.15)
    axes.set_xlim(low / 10 ** (0.08 * wide), high * 10 ** ((1.0 / _DATA - 1.0) * wide))
    top = max([tolerance] + [row.error.largest for row in rows])
    axes.set_ylim(zero / 3.0, top * 4.0)
    digits = (1.0, 3.0) if wide > 1.5 else (1.0, 2.0, 5.0) if wide > 0.5 else tuple(range(1, 10))
    axes.xaxis.set_major_locator(LogLocator(subs=digits))
    ticks = [tick for tick in axes.xaxis.get_major_locator()() if low * 0.9 <= tick <= high * 1.1]
    axes.xaxis.set_major_locator(FixedLocator(ticks))
    axes.xaxis.set_major_formatter("{x:.4g}")
    axes.minorticks_off()
    if any(not row.error.largest for row in rows):
        axes.axhspan(zero / 3.0, zero * 3.0, color="#f2f2f2", zorder=0)
        axes.annotate("0", (-0.012, zero), xycoords=("axes fraction", "data"), ha="right", va="center")
        axes.set_yticks([tick for tick in axes.get_yticks() if zero * 3.0 < tick <= top * 4.0])


def _label(axes: Any, rows: Sequence[Row], zero: float) -> None:
    """Draw the rows' names in a column on the right, in the order of their errors. Thin lines lead to the markers.

    `zero` is the vertical position at which an error of 0 is drawn. `axes` are the axes to draw on.
    """
    low, high = np.log10(axes.get_ylim())
    ordered = sorted(rows, key=lambda row: (_height(row, zero), row.time.median))
    places: list[float] = []  # heights of the names in [0, 1]: near their markers, without overlap
    least, ceiling = 0.062, 0.97
    for row in ordered:
        height = (np.log10(_height(row, zero)) - low) / (high - low)
        places.append(max(height, 0.04, places[-1] + least if places else 0.0))
    for index in reversed(range(len(places))):
        places[index] = min(places[index], ceiling)
        ceiling = places[index] - least
    for row, place in zip(ordered, places, strict=True):
        text = f"{row.name}{' (peer)' if row.is_peer else ''}"
        if row.kind == "interpolation" and row.backend != "VTK":
            count = row.points
            short = f"{count}" if count < 10_000 else f"{count / 1e3:.0f}k" if count < 1e6 else f"{count / 1e6:.1f}M"
            text += f", {short} points"
        axes.annotate(
            text, (row.time.median * 1e3, _height(row, zero)), xytext=(_DATA + 0.06, place),
            textcoords="axes fraction", va="center", fontsize=8.5, color=_INK if row.on_front else _GREY, zorder=2,
            bbox={"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.85},
            arrowprops={"arrowstyle": "-", "color": "#c9c9c9", "linewidth": 0.7, "relpos": (0.0, 0.5)},
        )  # fmt: skip


# --- pictures from one viewer: reference, chosen colours and errors


class Picture(NamedTuple):
    """A picture of the mesh's colours, or of their errors.

    Parameters
    ----------
    title : str
        Title of the picture.
    pixels : ndarray
        Shape (height, width, 3), uint8.
    scale : matplotlib.cm.ScalarMappable or None
        Colour scale of a picture of errors, for its colour bar. None for a picture of the mesh's colours.
    """

    title: str
    pixels: NDArray[np.uint8]
    scale: Any = None


def linked_pictures(report: Result) -> list[Picture]:
    """Draw the mesh from one viewer, in three or four pictures.

    The first shows the reference colours. The second shows the colours of the row that the report recommends. The third
    shows that row's signed errors at the vertices. The fourth shows the interpolation errors inside triangles, and is
    drawn only if all triangles were searched. The scene's viewer is used if it sees the mesh; otherwise, a viewer that
    frames the mesh. The colour scale of errors at the vertices is symmetric and ends at the largest error. The scale of
    errors inside triangles is logarithmic.

    Raises
    ------
    ValueError
        If VTK cannot draw on this machine.
    """
    mesh, viewer = bare_surface(report), report.scene.viewer
    pixels = drawn(mesh, report.reference_colors, viewer, _PICTURE)
    if _covered(pixels).mean() < _LEAST_SEEN:
        viewer = default_scene(mesh).viewer
        pixels = drawn(mesh, report.reference_colors, viewer, _PICTURE)
    errors = in_worst_channel(report.chosen_colors - report.reference_colors)
    scale = error_scale(errors)
    pictures = [
        Picture("reference", pixels),
        Picture(f"chosen: {report.name_of_chosen}", drawn(mesh, report.chosen_colors, viewer, _PICTURE)),
        Picture("its signed error at the vertices", drawn(mesh, _scaled(errors, scale), viewer, _PICTURE), scale),
    ]
    if len(report.inside_errors) == mesh.n_cells and has_only_triangles(mesh):
        scale = error_scale(report.inside_errors, report.tolerance)
        corners = mesh.regular_faces  # triangles do not share points, so that each has one colour
        apart = pv.PolyData.from_regular_faces(mesh.points[corners.ravel()], np.arange(corners.size).reshape(-1, 3))
        colors = np.repeat(_scaled(report.inside_errors, scale), 3, axis=0)
        pictures.append(Picture("interpolation error inside triangles", drawn(apart, colors, viewer, _PICTURE), scale))
    return pictures


def _covered(pixels: NDArray[np.uint8]) -> BoolArray:
    """Return the mask of an image's pixels that show the mesh, shape (height, width).

    The top left pixel shows the background. Pixels of any other colour show the mesh.
    """
    covered: BoolArray = (pixels != pixels[0, 0]).any(axis=2)
    return covered


def error_scale(errors: Float64Array, tolerance: float | None = None) -> Any:
    """Return a colour scale for errors, as a `matplotlib.cm.ScalarMappable`.

    Without a tolerance, the scale is linear, for signed errors. Errors of 0 are white, positive errors red, negative
    errors blue. It ends at the largest absolute error, or at one display step if all errors are 0. With a tolerance,
    the scale is logarithmic, for absolute errors. It begins at a hundredth of the tolerance (white), and ends at the
    tolerance or the largest error, whichever is larger.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm, Normalize

    largest = float(np.abs(errors).max(initial=0.0))
    if tolerance is not None:
        return ScalarMappable(LogNorm(_LEAST_SHOWN * tolerance, max(largest, tolerance), clip=True), "Reds")
    largest = largest or 1.0 / 255.0
    return ScalarMappable(Normalize(-largest, largest), "RdBu_r")


def _scaled(errors: Float64Array, scale: Any) -> Float64Array:
    """Return the colours that a colour scale gives to n errors, shape (n, 3), from 0 to 1."""
    return np.asarray(scale.to_rgba(np.maximum(errors, scale.norm.vmin)))[:, :3]  # a logarithmic scale masks 0


def _draw_pictures(part: Any, report: Result) -> None:
    try:
        pictures = linked_pictures(report)
    except ValueError as error:
        part.subplots().set_axis_off()
        part.text(0.5, 0.5, str(error), ha="center", wrap=True)
        return
    # Crop all pictures to the mesh, with a margin.
    seen = _covered(pictures[0].pixels)
    cut = [slice(None), slice(None)]
    if seen.any():
        for axis in (0, 1):
            places = np.flatnonzero(seen.any(axis=1 - axis))
            cut[axis] = slice(max(places[0] - 15, 0), places[-1] + 16)
    above, below = part.subplots(2, len(pictures), height_ratios=(1.0, 0.05), squeeze=False)
    for axes, place, (title, pixels, scale) in zip(above, below, pictures, strict=True):
        axes.imshow(pixels[cut[0], cut[1]])
        axes.set_title(title, fontsize=11)
        axes.set_axis_off()
        if scale is None:
            place.set_axis_off()
            continue
        bar = part.colorbar(scale, cax=place, orientation="horizontal")
        place.tick_params(labelsize=9)
        low, high = scale.get_clim()
        if low < 0.0:
            bar.set_ticks([low, 0.0, high], labels=[f"−{number(high)}", "0", f"+{number(high)}"])
            for label, side in zip(place.get_xticklabels(), ("left", "center", "right"), strict=True):
                label.set_ha(side)
        else:
            place.axvline(report.tolerance, color=_INK, linewidth=1.5)


# --- the histogram and the ledger


def _draw_histogram(axes: Any, report: Result) -> None:
    at_vertices = np.abs(report.chosen_colors - report.reference_colors).max(axis=1)
    each = np.full(len(at_vertices), 1.0 / len(at_vertices))
    shown = [(f"at {len(at_vertices)} vertices: {report.name_of_chosen}", at_vertices, each, _COLORS["light model"])]
    if len(report.inside_errors):
        label = f"inside {len(report.inside_errors)} triangles of the original mesh"
        shown.append((label, report.inside_errors, report.inside_areas, _COLORS["interpolation"]))
    some = np.concatenate([values[values > 0.0] for _, values, _, _ in shown])
    low = max(float(np.percentile(some, 1.0)), 1e-17) if len(some) else 1e-17
    bins = np.geomspace(low, max(float(some.max(initial=1e-2)), report.tolerance) * 1.5, 60)
    for label, values, parts, color in shown:
        part = parts[values < low].sum()
        below = f" ({part:.0%} below {number(low)})" if part else ""
        axes.hist(values, bins=bins, weights=100.0 * parts, color=color, alpha=0.65, label=label + below)
    axes.axvline(report.tolerance, color=_RED, linestyle="--", linewidth=1.2)
    axes.axvline(1.0 / 255.0, color=_GREY, linestyle=":", linewidth=1.0)
    axes.set_ylim(0.05, 100.0)  # before the logarithmic scale, which finds no limits if all errors are 0
    axes.set(xscale="log", yscale="log", title="Distribution of errors")
    axes.set(xlabel="colour error", ylabel="% of vertices, or of the area")
    axes.legend(fontsize=9, frameon=False)


def _draw_ledger(axes: Any, report: Result) -> None:
    measured = [
        (entry, entry.cost, entry.error)
        for entry in reversed(report.ledger)
        if entry.cost is not None and entry.error is not None
    ]
    axes.set_title("Cost of each effect, and the largest error without it")
    axes.set_xlabel("time with it minus time without it, in ms: median and quartiles")
    for place, (entry, cost, error) in enumerate(measured):
        color = _GREY if cost.is_noise else _COLORS["arithmetic"]
        spread = [[(cost.median - cost.low) * 1e3], [(cost.high - cost.median) * 1e3]]
        axes.barh(place, cost.median * 1e3, xerr=spread, color=color, ecolor=_INK, capsize=2, height=0.6)
        text = f"{entry.cost_text}, error {number(error)}{'' if entry.runs else ', left out'}"
        at = (max(cost.high, 0.0) * 1e3, place)
        axes.annotate(text, at, xytext=(8, 0), textcoords="offset points", va="center", fontsize=9)
    axes.set_yticks(range(len(measured)), [entry.effect for entry, _, _ in measured])
    axes.axvline(0.0, color=_INK, linewidth=0.8)
    ends = [end * 1e3 for _, cost, _ in measured for end in (cost.low, cost.high)]
    low, high = min([0.0, *ends]), max([1e-9, *ends])
    axes.set_xlim(low - 0.03 * (high - low), high + 0.45 * (high - low))
