"""Report of accuracy against time: sentences, tables and files."""

from __future__ import annotations

import csv
import os
import platform
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from datetime import date
from importlib.metadata import PackageNotFoundError, version
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyvista as pv

from pvphong.base import threads
from pvphong.base.files import write_json, written_aside
from pvphong.base.text import html_table, rendered, wrapped
from pvphong.meshes.surfaces import has_only_triangles
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
from pvphong.studies.accuracy.figure import save_figure
from pvphong.studies.accuracy.physics import Physics
from pvphong.studies.accuracy.result import (
    KINDS,
    QUESTIONS,
    Errors,
    Kind,
    Question,
    Result,
    number,
    seconds,
    table,
)

if TYPE_CHECKING:
    from rich.table import Table

# Approximate overhead of `mesh.phong.shade` in seconds, without the lighting; see the times in the README.
_CALL = 1e-3

# Width in characters of the column of names, next to their explanations.
_NAMES = 24

_HEADINGS = ("", "variant", "time", "spread", "largest", "RMS", "99 %", "points")


@dataclass(frozen=True, eq=False, repr=False)
class Tradeoff(Result):
    """Accuracy against time on one mesh and scene.

    `print(report)` prints the recommendation, `print(report.explain())` everything.

    Attributes
    ----------
    tolerance : float
        Allowed colour error.
    rows : tuple of Row
        Measured variants: pvphong's ways to light the mesh, and other implementations.
    ledger : tuple of LedgerEntry
        Cost of each effect and each light, and the error without this effect or light.
    baseline : str
        Name of the row to which the ledger's costs refer: the evaluator that `evaluate` uses by default.
    predicted_bounds : tuple of PredictedBound
        Approximations that simplify the equation at the tolerance, with bounds and measured errors.
    left_out : dict of str to str
        Variants that were not measured, and the reasons.
    facts : dict of str to str
        Mesh, scene, machine, threads, versions, date, repeats.
    inside_errors, inside_areas : ndarray
        Shape (m,): the largest interpolation error in each searched triangle, and each triangle's fraction of the area
        of all searched triangles.
    surface : pyvista.PolyData
        Mesh whose points were lit.
    scene : Scene
        Scene that lit the mesh.
    matrix : array_like or None
        (4, 4) model matrix; None for the identity.
    reference_colors : ndarray
        Colours of the float64 reference, shape (n_points, 3).
    physics : Physics or None
        Light models compared with path tracing, if requested: `.models`, `.truth`, `.sentence()`, `.table()`.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> report = pv.Sphere().phong.tradeoff(ph.DirectionalLight(), seconds=0.2)
    >>> report.tolerance == 1 / 255
    True
    """

    physics: Physics | None = None

    def to_mesh(self) -> pv.PolyData:
        """Return a copy of the surface with colours and errors.

        Returns
        -------
        pyvista.PolyData
            Point arrays ``phong_reference`` with the colours of the float64 reference, ``phong_chosen`` with those of
            the recommended row, and ``phong_error`` with their difference, chosen minus reference. If all faces are
            triangles and all were searched, also the cell array ``phong_interpolation_error``.
        """
        mesh = self.surface.copy()
        mesh.point_data["phong_reference"] = self.reference_colors
        mesh.point_data["phong_chosen"] = self.chosen_colors
        mesh.point_data["phong_error"] = self.chosen_colors.astype(np.float64) - self.reference_colors
        if len(self.inside_errors) == mesh.n_cells and has_only_triangles(mesh):
            mesh.cell_data["phong_interpolation_error"] = self.inside_errors
        mesh.set_active_scalars("phong_chosen", preference="point")
        return mesh

    def __str__(self) -> str:
        return "\n".join(line for sentence in self.summary() for line in wrapped(sentence))

    def __repr__(self) -> str:
        return f"<Tradeoff of {len(self.rows)} rows: {self.name_of_chosen} within {self.tolerance:.3g}>"

    def _repr_html_(self) -> str:
        return html_table(self.summary()[0], _HEADINGS, (cells for _, cells in self._cells()))

    def _questions(self) -> list[Question]:
        """Questions that the report's rows answer. "at the vertices" is always among them."""
        return [question for question in QUESTIONS if any(self.rows_for(question))]

    def summary(self, *, with_next: bool = False) -> list[str]:
        """Return the recommendation in a few lines that fit a terminal.

        Parameters
        ----------
        with_next : bool, default False
            Add to each line the cheapest row with a smaller error, and its additional cost.
        """
        count = sum(not row.is_peer for row in self.rows)
        found = [f"Cheapest within {number(self.tolerance)}, of {count} ways to light {self.surface.n_points} points:"]
        for question in self._questions():
            chosen = self.best(question=question)
            row = chosen or min(self.rows_for(question), key=lambda row: row.decisive_error)
            error = f"{seconds(row.time.median)}, off by {number(row.decisive_error)}"
            line = f"  {question}: {'' if chosen else 'none; nearest '}{row.name}, {error}"
            following = self.next_step(row)
            if with_next and following is not None:
                more = seconds(following.time.median - row.time.median)
                times = row.decisive_error / following.decisive_error if following.decisive_error else 0.0
                bought = f"for {times:.3g}× less error" if times else "for an error of 0"
                noisy = ", within the noise" if following.time.low <= row.time.high else ""
                line += f"; next {following.name}, +{more} {bought}{noisy}"
            found.append(line)
        return [*found, *self._remarks()]

    def _remarks(self) -> Iterator[str]:
        """Yield remarks for the summary.

        They name faster implementations within the tolerance, warn of small meshes, and recommend a light model.
        """
        cheaper = []
        for question in self._questions():
            own, peer = self.best(question=question), self.best(question=question, peers=True)
            if peer is not None and (own is None or peer.time.median < own.time.median):
                cheaper.append(
                    f"{peer.name} is {'faster' if own else 'accurate enough'} {question}, {seconds(peer.time.median)}"
                )
        if cheaper:
            yield f"Of the peers, {'; '.join(cheaper)}."
        slowest = max(row.time.median for row in self.rows_for(QUESTIONS[0]))
        if slowest <= _CALL:
            yield f"The mesh is so small that everything is cheap: at most {seconds(slowest)} at the vertices."
        if self.physics is not None:
            yield self.physics.sentence()

    def explain(self) -> str:
        """Return the whole report as text: rows, costs of effects, error bounds, variants left out, circumstances."""
        title = f"Cost of each effect: time with it minus time without it, of {self.baseline}"
        ledger = table(title, "effect", "", "cost", "if dropped", "why", right=("cost", "if dropped"))
        ledger.columns[1].no_wrap = True
        for entry in self.ledger:
            error = "" if entry.error is None else number(entry.error)
            ledger.add_row(entry.effect, "on" if entry.runs else "off", entry.cost_text, error, entry.why)
        parts: list[Any] = [self.table(), *self.summary(with_next=True), "", ledger]
        if self.predicted_bounds:
            title = "Error bounds that the plan predicted, and the errors measured"
            bounds = table(title, "left out", "how", "predicted", "measured")
            for bound in self.predicted_bounds:
                bounds.add_row(bound.effect, bound.why, number(bound.predicted), number(bound.measured))
            parts.append(bounds)
        if self.physics is not None:
            parts.append(self.physics.table())
        if notes := [(row.name, row.note) for row in self.rows if row.note]:
            parts.append(_pairs_table("notes", notes))
        if self.left_out:
            names: dict[str, list[str]] = {}  # one line per reason
            for name, reason in self.left_out.items():
                names.setdefault(reason, []).append(name)
            parts.append(_pairs_table("left out", [(", ".join(some), reason) for reason, some in names.items()]))
        widest = max(self.rows, key=lambda row: row.time.spread)
        spread = f"median interquartile range of the times: {self.noise:.1%}"
        most = f"largest: {widest.time.spread:.0%}, {widest.name}"
        noise = f"{spread}; {most}; smaller differences may be noise"
        worst = ", ".join(f"{error:.2g} at vertex {index}" for index, error in self.worst())
        parts.append(_pairs_table("measured on", [*self.facts.items(), ("noise", noise), ("worst vertices", worst)]))
        return rendered(parts)

    def table(self) -> Table:
        """Return the rows as a `rich.table.Table`; print it with a `rich.console.Console`.

        The rows are sorted by kind and time. ★ marks the chosen rows, ● the other rows on the Pareto front of their
        kind.
        """
        title = "Accuracy against time: colour errors of each row's kind; ★ chosen, ● on the front"
        found = table(title, *_HEADINGS, right=_HEADINGS[2:])
        found.padding = 0  # so that every name fits
        for kind, rows in groupby(self._cells(), key=itemgetter(0)):
            found.add_section()
            found.add_row("", f"{kind}:")
            for _, (mark, name, *numbers) in rows:
                found.add_row(mark, f" {name}", *numbers)
        return found

    def _cells(self) -> Iterator[tuple[Kind, tuple[str, ...]]]:
        """Yield the kind and the table cells of each row, sorted by kind and time.

        There is a cell for each of `_HEADINGS`.
        """
        for row in sorted(self.rows, key=lambda row: (KINDS.index(row.kind), row.time.median)):
            mark, error = "★" if row in self.chosen else "●" if row.on_front else "", row.error
            name, time = f"{row.name} (peer)" if row.is_peer else row.name, row.time
            numbers = (f"{size:.2g}" for size in (error.largest, error.rms, error.p99))
            yield row.kind, (mark, name, seconds(time.median), f"{time.spread:.0%}", *numbers, f"{row.points}")

    # -- files

    def to_dict(self) -> dict[str, Any]:
        """Return the report as built-in Python types, as for JSON."""
        return {
            "tolerance": self.tolerance,
            "chosen": {row.question: row.name for row in self.chosen},
            "noise": self.noise,
            "summary": self.summary(with_next=True),
            "facts": self.facts,
            "rows": [asdict(row) for row in self.rows],
            "ledger": [asdict(entry) for entry in self.ledger],
            "baseline": self.baseline,
            "predicted_bounds": [asdict(bound) for bound in self.predicted_bounds],
            "left_out": self.left_out,
            "physics": None if self.physics is None else self.physics.to_dict(),
            "worst_vertices": [{"index": index, "error": error} for index, error in self.worst()],
        }

    def to_json(self, path: str | os.PathLike[str]) -> None:
        """Write `to_dict` to a JSON file.

        Raises
        ------
        ValueError
            If the file cannot be written.
        """
        write_json(self.to_dict(), path)

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the rows to a CSV file, one line per row, with times in seconds and absolute colour errors.

        Raises
        ------
        ValueError
            If the file cannot be written.
        """
        lines = []
        for row in self.rows:
            line: dict[str, object] = {"name": row.name, "kind": row.kind}
            line |= {f"time_{key}": value for key, value in asdict(row.time).items()}
            for kind in (name.replace(" ", "_") for name in KINDS):
                errors: Errors | None = getattr(row, kind)
                line |= {f"{kind}_{key}": getattr(errors, key, "") for key in ("largest", "rms", "p99", "count")}
            for key in ("points", "backend", "precision", "error_bound", "preparation", "is_peer", "on_front", "note"):
                line[key] = getattr(row, key)
            lines.append(line)
        with written_aside(path) as aside, aside.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(lines[0]))
            writer.writeheader()
            writer.writerows(lines)

    def plot(self, path: str | os.PathLike[str]) -> None:
        """Draw the report: Pareto fronts, pictures, histogram and ledger, into a .png, .pdf or .svg file.

        Raises
        ------
        ValueError
            If the suffix is not supported, or the file cannot be written.
        """
        save_figure(self, path, self.physics)


def _pairs_table(title: str, rows: list[tuple[str, str]]) -> Table:
    found = table(title, "", "")
    found.show_header = False
    found.columns[0].max_width = _NAMES
    for row in rows:
        found.add_row(*row)
    return found


def circumstances(mesh: pv.PolyData, scene: Scene, material: Material) -> dict[str, str]:
    """Return facts on which a report depends, as name → text, such as mesh, scene, machine and versions."""
    kinds = Counter(type(light).__name__ for light in scene.lights if light.on)
    lights = ", ".join(f"{count} {kind}" for kind, count in kinds.items()) or "no light"
    in_kernel = f", {threads.count()} in the kernel" if "numba" in sys.modules else ""
    try:  # Linux has the processor's name in a file
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    processors = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    processor = processors[0] if processors else platform.processor() or "unknown processor"
    versions = [f"Python {platform.python_version()}"]
    for package in ("numpy", "numba", "pyvista", "vtk", "pvphong"):
        with suppress(PackageNotFoundError):
            versions.append(f"{package} {version(package)}")
    return {
        "mesh": f"{mesh.n_points} points, {mesh.n_cells} faces, {mesh.points.dtype}",
        "scene": f"{lights}; {scene.light_model}",
        "material": f"{material}",
        "machine": f"{processor}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}",
        "threads": f"1 in NumPy {np.__version__}{in_kernel}",
        "versions": ", ".join(versions),
        "date": date.today().isoformat(),
    }
