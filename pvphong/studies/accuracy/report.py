"""What accuracy costs in time, for its reader: the result of measuring, with its tables, sentences and files."""

from __future__ import annotations

import csv
import os
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pyvista as pv

from pvphong.base.files import write_json, written_aside
from pvphong.base.text import html_table, rendered, wrapped
from pvphong.studies.accuracy.figure import save_figure
from pvphong.studies.accuracy.result import Result
from pvphong.studies.accuracy.rows import Errors, Row
from pvphong.studies.accuracy.tables import HEADINGS, cells, conclusions, everything, in_order, in_short, rows_table

if TYPE_CHECKING:
    from rich.table import Table


@dataclass(frozen=True, eq=False, repr=False)
class Tradeoff(Result):
    """What accuracy costs in time on one mesh and scene.

    `print(report)` says what to choose, `print(report.explain())` all of it.

    Attributes
    ----------
    tolerance : float
        The colour error that was to be allowed.
    rows : tuple of Row
        Every variant that was measured: the ways of lighting the mesh.
    ledger : tuple of Entry
        What each effect and light costs, and what its absence would do.
    baseline : str
        The row that the ledger's costs are parts of: what `evaluate` does by itself.
    promises : tuple of Promise
        The approximations of the plan at the tolerance: bounds and what came of them.
    left_out : dict of str to str
        What was not measured, and why.
    facts : dict of str to str
        Mesh, scene, machine, threads, versions, date, repeats.
    inside_errors, inside_areas : ndarray
        Shape (m,): the largest interpolation error of each triangle that was searched, and its part of their area.
    surface : pyvista.PolyData
        The mesh whose points were lit.
    """

    def to_mesh(self) -> pv.PolyData:
        """A copy of the surface to look at.

        Returns
        -------
        pyvista.PolyData
            Point arrays ``phong_reference`` and ``phong_chosen``, the colours, and ``phong_error``, chosen minus
            reference. Where every triangle was searched and faces are triangles, the cell array
            ``phong_interpolation_error``.
        """
        mesh = self.surface.copy()
        mesh.point_data["phong_reference"] = self.reference_colors
        mesh.point_data["phong_chosen"] = self.chosen_colors
        mesh.point_data["phong_error"] = self.chosen_colors.astype(np.float64) - self.reference_colors
        if len(self.inside_errors) == mesh.n_cells and mesh.is_all_triangles:
            mesh.cell_data["phong_interpolation_error"] = self.inside_errors
        mesh.set_active_scalars("phong_chosen", preference="point")
        return mesh

    def table(self) -> Table:
        """The rows as a `rich.table.Table`; print it with a `rich.console.Console`."""
        return rows_table(self)

    def conclusions(self) -> list[str]:
        """What to choose, at what price, and what the next step would cost: a sentence or two per question."""
        return conclusions(self)

    def explain(self) -> str:
        """All of it: every row, what each effect costs, what was promised, what was left out, where it was measured."""
        return rendered(everything(self))

    def __str__(self) -> str:
        return "\n".join(line for sentence in in_short(self) for line in wrapped(sentence))

    def __repr__(self) -> str:
        chosen = self.best()
        name = "nothing" if chosen is None else chosen.name
        return f"<Tradeoff of {len(self.rows)} rows: {name} within {self.tolerance:.3g}>"

    def _repr_html_(self) -> str:
        return html_table(in_short(self)[0], HEADINGS, (cells(self, row) for row in in_order(self)))

    def to_dict(self) -> dict[str, Any]:
        """All numbers as plain values."""
        chosen, rays, inside = self.best(), self.best(rays=True), self.best(inside=True)
        return {
            "tolerance": self.tolerance,
            "chosen": None if chosen is None else chosen.name,
            "chosen_rays": None if rays is None else rays.name,
            "chosen_inside": None if inside is None else inside.name,
            "noise": self.noise,
            "conclusions": self.conclusions(),
            "facts": self.facts,
            "rows": [asdict(row) for row in self.rows],
            "ledger": [asdict(entry) for entry in self.ledger],
            "baseline": self.baseline,
            "promises": [asdict(promise) for promise in self.promises],
            "left_out": self.left_out,
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
        """Write the rows to a CSV file: one line per row, seconds and absolute colour errors.

        Raises
        ------
        ValueError
            If the file cannot be written.
        """
        flat = [_flat(row) for row in self.rows]
        with written_aside(path) as aside, aside.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(flat[0]))
            writer.writeheader()
            writer.writerows(flat)

    def plot(self, path: str | os.PathLike[str]) -> None:
        """Draw the report: Pareto fronts, pictures, histogram and ledger, into a .png, .pdf or .svg file.

        Raises
        ------
        ValueError
            If Matplotlib is missing, or the file cannot be written.
        """
        save_figure(self, path)


def _flat(row: Row) -> dict[str, object]:
    """A row without nested values."""
    result: dict[str, object] = {"name": row.name, "kind": row.kind}
    result |= {f"time_{key}": value for key, value in asdict(row.time).items()}
    for kind in ("arithmetic", "light_model", "sampling", "interpolation"):
        errors: Errors | None = getattr(row, kind)
        for key in ("largest", "rms", "p99", "count"):
            result[f"{kind}_{key}"] = "" if errors is None else getattr(errors, key)
    for key in ("points", "backend", "precision", "promised", "preparation", "is_peer", "on_front", "note"):
        value = getattr(row, key)
        result[key] = "" if value is None else value
    return result
