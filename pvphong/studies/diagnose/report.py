"""What a diagnosis says: the findings as values, as text, as a table and as a mesh to look at."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from textwrap import shorten
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from pvphong.base.text import WIDTH, html_table, wrapped
from pvphong.base.types import FloatArray, IntArray, Vector
from pvphong.studies.diagnose.kinds import FLAGS, KINDS

if TYPE_CHECKING:
    from rich.table import Table

_LINES = 5  # of a printed diagnosis
_SHOWN = 6  # indices that a report lists of each finding
# Harmless where normals are stored.
_OF_COMPUTED_NORMALS = (
    "unlit_points",
    "duplicate_faces",
    "degenerate_faces",
    "far_faces",
    "inconsistent_edges",
    "inside_out_faces",
)


@dataclass(frozen=True)
class Finding:
    """One kind of fault that a mesh or its matrix has.

    Attributes
    ----------
    name : str
        The field of `Diagnosis` that holds all of its indices.
    where : str
        What is counted: "cells", "faces", "edges", "points", "mesh" or "matrix".
    count : int
        How many there are; 1 for the mesh or the matrix as a whole.
    first : tuple
        The first few indices; pairs of points for edges.
    spoils : bool
        Whether it spoils the lighting; else it is a note.
    meaning, remedy : str
        What it is and what to do about it.
    """

    name: str
    where: str
    count: int
    first: tuple[Any, ...]
    spoils: bool
    meaning: str
    remedy: str


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis:
    """What `diagnose` found: `print(diagnosis)` names it, `print(diagnosis.explain())` has indices and remedies.

    Indices rise, and number the surface's points and faces.

    Of a PolyData the surface is the mesh itself; of another dataset the surface's arrays
    ``vtkOriginalPointIds`` and ``vtkOriginalCellIds`` lead back to the whole. Faces are counted as
    `pvphong.meshes.surfaces.polygons` does: vertices and lines are none, a strip is one per triangle. All fields but
    the first three are empty or False where there is no such fault.

    Attributes
    ----------
    n_points, n_faces : int
        Size of the surface.
    stored_normals : bool
        Whether it has active point normals, which then are what is lit.
    invalid_cells : ndarray
        Cells of the mesh, faces or not, with an index that no point has or with too few points for their type.
        They are left out of everything else; any in another dataset than PolyData leave no surface.
    nothing_to_light : bool
        There are neither faces nor point normals.
    non_finite_points : ndarray
        Points with a NaN or infinity. Faces with one are left out of the checks of faces.
    zero_normals, non_finite_normals : ndarray
        Points whose stored normal is zero, or has a NaN or infinity.
    unlit_points : ndarray
        Points in faces whose computed normal is zero: no face there has an area and finite points, or their normals
        cancel as those of two coincident opposite faces do. It spoils nothing where normals are stored.
    degenerate_faces : ndarray
        Faces whose area is zero to float64's rounding, or with a corner that comes twice.
    duplicate_faces : ndarray
        Faces round the same points in the same order as one with a lower index. Normals lean to what counts
        twice; it spoils nothing where normals are stored.
    far_faces : ndarray
        Faces whose normal the coordinates' rounding may turn by more than 1/255 rad, about one display step,
        only because they lie far from the origin.
    inconsistent_edges : ndarray
        (m, 2) points of the edges whose two faces have opposite fronts; duplicate faces are left out.
    inside_out_faces : ndarray
        Faces of closed parts whose signed volume is negative, but for the walls of cavities within other parts: their
        fronts look inwards. It spoils nothing where normals are stored.
    singular_matrix : bool
        The matrix flattens space: its determinant is zero.
    non_manifold_edges : ndarray
        (m, 2) points of the edges with more than two faces. A note: the normals there are a mean of all.
    thin_faces : ndarray
        Slivers whose normal the coordinates' rounding may turn by more than 1/255 rad wherever they lie.
        A note: it is in their nature, and they cover little.
    opposed_normals : ndarray
        Points whose stored normal is on the back of their faces. A note: it may be meant.
    duplicate_points : ndarray
        Points exactly in the place of one with a lower index. A note: seams and sharp edges are made so.
    unused_points : ndarray
        Points in no face, where there are faces. A note: nothing shows of them.
    nearly_singular_matrix : bool
        The matrix's determinant is not zero, but of the size of its entries' rounding. A note: normals are exact
        for the matrix as it is stored.
    mirrored_matrix : bool
        The matrix mirrors. A note: pvphong lights it rightly.
    offset : tuple of 3 floats or None
        What to subtract from the coordinates to cure `far_faces`; None where there are none, or where no single
        offset helps all of them.
    """

    FLAGS: ClassVar[dict[str, int]] = FLAGS
    """The bit of each kind of fault in the arrays of `to_mesh`."""

    n_points: int
    n_faces: int
    stored_normals: bool
    invalid_cells: IntArray
    nothing_to_light: bool
    non_finite_points: IntArray
    zero_normals: IntArray
    non_finite_normals: IntArray
    unlit_points: IntArray
    degenerate_faces: IntArray
    duplicate_faces: IntArray
    far_faces: IntArray
    inconsistent_edges: IntArray
    inside_out_faces: IntArray
    singular_matrix: bool
    non_manifold_edges: IntArray
    thin_faces: IntArray
    opposed_normals: IntArray
    duplicate_points: IntArray
    unused_points: IntArray
    nearly_singular_matrix: bool
    mirrored_matrix: bool
    offset: Vector | None
    _points: FloatArray
    _faces: tuple[IntArray, IntArray, IntArray]  # numbers, connectivity and offsets of the valid ones

    @property
    def ok(self) -> bool:
        """Whether nothing spoils the lighting; notes do not count."""
        return not any(finding.spoils for finding in self.findings)

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """The faults that there are: first what spoils the lighting, then the notes."""
        found = [self._finding(name) for name in KINDS]
        return tuple(sorted((finding for finding in found if finding.count), key=lambda finding: not finding.spoils))

    def _finding(self, name: str) -> Finding:
        kind, value = KINDS[name], getattr(self, name)
        count = int(value) if isinstance(value, bool) else len(value)
        first = () if isinstance(value, bool) else tuple(_plain(index) for index in value[:_SHOWN].tolist())
        spoils = kind.spoils and not (name in _OF_COMPUTED_NORMALS and self.stored_normals)
        remedy = kind.remedy
        if name == "far_faces" and self.offset is not None:
            remedy += " The offset: ({:.17g}, {:.17g}, {:.17g}).".format(*self.offset)
        return Finding(name, kind.where, count, first, spoils, kind.meaning, remedy)

    def table(self) -> Table:
        """The findings as a `rich.table.Table`; print it with a `rich.console.Console`."""
        from rich import box
        from rich.table import Table

        table = Table(title=self._summary(), title_justify="left", box=box.SIMPLE, show_header=False, leading=1)
        table.add_column(no_wrap=True)
        table.add_column(overflow="fold")  # code in a remedy may be longer than a line
        for finding in self.findings:
            kind = "[red]spoils[/red]" if finding.spoils else "note"
            said = (f"{_named(finding)} {finding.meaning}", _listed(finding), finding.remedy)
            table.add_row(f"{finding.name}\n{kind}", "\n".join(filter(None, said)))
        return table

    def explain(self) -> str:
        """Every finding with the first of its indices and its remedy."""
        lines = [self._summary()]
        for finding in self.findings:
            lines += wrapped(f"  {_told(finding)}")
            if finding.first:
                lines += wrapped(f"    {_listed(finding)}")
            lines += wrapped(f"    {finding.remedy}")
        return "\n".join(lines)

    def __str__(self) -> str:
        lines, rest = [self._summary()], list(self.findings)
        while rest and len(lines) + len(told := wrapped(f"  {_told(rest[0])}")) < _LINES:
            lines += told
            del rest[0]
        if rest:
            names = ", ".join(finding.name for finding in rest)
            lines.append(f"  {shorten(f'and {names}', WIDTH - 2, placeholder=' …')}")
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<{self._summary()}>"

    def _repr_html_(self) -> str:
        rows = [
            ("spoils" if f.spoils else "note", f.name, f"{_named(f)} {f.meaning}", _listed(f), f.remedy)
            for f in self.findings
        ]
        return html_table(self._summary(), ("", "name", "what", "where", "remedy"), rows)

    def _summary(self) -> str:
        spoiled = sum(finding.spoils for finding in self.findings)
        notes = len(self.findings) - spoiled
        verdict = "ok" if self.ok else f"{spoiled} kind{'s' * (spoiled > 1)} of fault"
        more = f", {notes} note{'s' * (notes > 1)}" if notes else ""
        return f"Diagnosis of {self.n_points} points and {self.n_faces} faces: {verdict}{more}"

    def to_mesh(self) -> pv.PolyData:
        """A mesh to look at the findings on.

        Returns
        -------
        pyvista.PolyData
            The surface's points, and its faces without the invalid ones, so that it is safe to draw. On points
            and cells, the array ``"severity"``, active, is 0 where all is well, 1 for a note and 2 for what
            spoils the lighting, and the array ``"diagnosis"`` is the sum of the findings' `FLAGS`; an edge is
            noted at its two points. The cell array ``"face"`` holds each face's number.
        """
        numbers, connectivity, offsets = self._faces
        mesh = pv.PolyData(self._points.copy())
        if len(numbers):
            mesh.SetVerts(None)
            mesh.SetPolys(pv.CellArray.from_arrays(offsets, connectivity, deep=True))
            mesh.cell_data["face"] = numbers
            for name, flags in self._flagged(self.n_faces, "faces").items():
                mesh.cell_data[name] = flags[numbers]
        for name, flags in self._flagged(self.n_points, "points", "edges").items():
            mesh.point_data[name] = flags
        mesh.set_active_scalars("severity")
        return mesh

    def _flagged(self, count: int, *places: str) -> dict[str, NDArray[np.int32]]:
        """The arrays of `to_mesh` over all points or all faces."""
        severity, flags = np.zeros(count, dtype=np.int32), np.zeros(count, dtype=np.int32)
        for finding in reversed(self.findings):  # what spoils comes last and overrides
            if finding.where in places:
                indices = np.unique(getattr(self, finding.name))
                flags[indices] |= FLAGS[finding.name]
                severity[indices] = 1 + finding.spoils
        return {"diagnosis": flags, "severity": severity}


def _plain(index: int | list[int]) -> int | tuple[int, ...]:
    return index if isinstance(index, int) else tuple(index)


def _named(finding: Finding) -> str:
    """What has the fault: the mesh, the matrix, 1 face, 2 faces."""
    if finding.where in ("mesh", "matrix"):
        return f"the {finding.where}"
    return f"{finding.count} {finding.where if finding.count > 1 else finding.where[:-1]}"


def _told(finding: Finding) -> str:
    """A finding in a sentence."""
    return f"{'spoils' if finding.spoils else 'note'}: {_named(finding)} {finding.meaning} ({finding.name})"


def _listed(finding: Finding) -> str:
    """The first indices, and whether there are more."""
    return ", ".join(map(str, finding.first)) + (", …" if finding.count > len(finding.first) > 0 else "")
