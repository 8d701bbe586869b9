"""What in a mesh, or in a model matrix for it, will not light as it should: `diagnose` and its result."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from textwrap import shorten
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from pvphong.base import check
from pvphong.base.text import WIDTH, html_table, wrapped
from pvphong.base.types import FloatArray, IntArray, MatrixLike, Vector
from pvphong.geometry import normals
from pvphong.geometry.normals import Faces
from pvphong.meshes.cells import invalid_cells, refuse_wrong_sizes
from pvphong.meshes.surfaces import outer_surface, unchecked_polygons
from pvphong.studies.diagnose.checks import (
    check_edges,
    check_faces,
    check_matrix,
    finite_rows,
    first_alike,
    repeated_faces,
)
from pvphong.studies.diagnose.shells import inside_out_faces

if TYPE_CHECKING:
    from rich.table import Table

_LINES = 5  # of a printed diagnosis
_SHOWN = 6  # indices that a report lists of each finding


class Kind(NamedTuple):
    """One kind of fault.

    Parameters
    ----------
    spoils : {"always", "without stored normals", "never"}
        When it spoils the lighting, so that `Diagnosis.ok` is False; else it is a note.
    meaning, remedy : str
        What it is and what to do about it.
    """

    spoils: Literal["always", "without stored normals", "never"]
    meaning: str
    remedy: str


KINDS: dict[str, Kind] = {
    "invalid_cells": Kind(
        "always",
        "with an index that no point has, with too few points for their type, of a type that VTK has not, or of the "
        "type convex point set",
        "Repair the file or the code that made them, and make tetrahedra of point sets: VTK would crash, so pvphong "
        "refuses the mesh.",
    ),
    "nothing_to_light": Kind(
        "always",
        "has no faces and no point normals",
        "Give it faces, or set mesh.point_data.active_normals.",
    ),
    "non_finite_points": Kind(
        "always",
        "with a NaN or infinity; their faces have no normal",
        "Remove them, for example with mesh.remove_points.",
    ),
    "zero_normals": Kind(
        "always",
        "with a stored normal of length zero, unlit",
        "Compute the normals anew: mesh.point_data.active_normals = pvphong.vertex_normals(mesh).",
    ),
    "non_finite_normals": Kind(
        "always",
        "with a NaN or infinity in the stored normal, unlit",
        "Compute the normals anew: mesh.point_data.active_normals = pvphong.vertex_normals(mesh).",
    ),
    "unlit_points": Kind(
        "without stored normals",
        "whose faces have no area, are not finite, or cancel as two coincident opposite faces do",
        "Remove such faces, and one of each coincident pair, with mesh.remove_cells.",
    ),
    "degenerate_faces": Kind(
        "without stored normals",
        "without an area or with a corner that comes twice; they have no weight in the normals",
        "Remove them, for example with mesh.remove_cells.",
    ),
    "duplicate_faces": Kind(
        "without stored normals",
        "round the same points in the same order as an earlier one: both count in the normals there",
        "Remove them, for example with mesh.remove_cells.",
    ),
    "far_faces": Kind(
        "without stored normals",
        "so far from the origin for their size that the coordinates' float type blurs their normals",
        "Subtract an offset before the coordinates are rounded to this float type (of parts far apart, each its own), "
        "or keep them in float64.",
    ),
    "inconsistent_edges": Kind(
        "without stored normals",
        "whose two faces have opposite fronts, so that their normals cancel",
        "Turn the faces: mesh.compute_normals(consistent_normals=True, auto_orient_normals=True).",
    ),
    "inside_out_faces": Kind(
        "without stored normals",
        "of closed parts whose fronts look inwards: they are lit as if seen from within",
        "Turn the faces: mesh.flip_faces(), or mesh.compute_normals(consistent_normals=True, "
        "auto_orient_normals=True) for some parts of several. Leave them if it is a room that is seen from within.",
    ),
    "singular_matrix": Kind(
        "always",
        "flattens the mesh: surfaces lose their normals",
        "Use a small scale in place of 0.",
    ),
    "non_manifold_edges": Kind(
        "never",
        "of more than two faces: their points are lit by the mean of sheets that may not belong together",
        "Split them if it shows: mesh.compute_normals(split_vertices=True, non_manifold_traversal=False).",
    ),
    "thin_faces": Kind(
        "never",
        "so thin that the rounding of their coordinates blurs their normals",
        "Remesh them, or keep the coordinates in float64.",
    ),
    "opposed_normals": Kind(
        "never",
        "with a stored normal on the back of their faces",
        "Flip the faces or the normals if light falls on the wrong side.",
    ),
    "duplicate_points": Kind(
        "never",
        "in the place of an earlier one: a seam, over which computed normals are not smooth",
        "Merge them if no seam is meant: mesh.clean().",
    ),
    "unused_points": Kind(
        "never",
        "in no face, without a computed normal",
        "Leave them, or drop them with mesh.clean().",
    ),
    "nearly_singular_matrix": Kind(
        "never",
        "flattens the mesh but for the last bits of its entries: where normals point depends on those",
        "Leave it if they are meant; else use a matrix that flattens exactly, or less.",
    ),
    "mirrored_matrix": Kind(
        "never",
        "mirrors: lit rightly here, but VTK's own shader draws it black",
        "Flip the mesh itself, if VTK is to light it.",
    ),
}
"""Fields of `Diagnosis` that hold indices → what these mean, in the order of the report.

What is counted is the last word of a name, cells, faces, edges, points or the matrix, but for those in `_WHERE`.
"""

_WHERE = {"nothing_to_light": "mesh"} | dict.fromkeys(
    ("zero_normals", "non_finite_normals", "opposed_normals"), "points"
)

FLAGS: dict[str, int] = {name: 1 << place for place, name in enumerate(KINDS)}
"""The bit of each kind in the arrays of `Diagnosis.to_mesh`."""


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

    @property
    def sentence(self) -> str:
        """What has the fault, and which: the mesh, the matrix, 1 face, 2 faces."""
        if self.where in ("mesh", "matrix"):
            return f"the {self.where} {self.meaning}"
        return f"{self.count} {self.where if self.count > 1 else self.where[:-1]} {self.meaning}"

    @property
    def indices(self) -> str:
        """The first indices, and whether there are more."""
        return ", ".join(map(str, self.first)) + (", …" if self.count > len(self.first) > 0 else "")

    @property
    def label(self) -> str:
        """Whether it spoils the lighting, in a word."""
        return "spoils" if self.spoils else "note"


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
        found = []
        for name, (when, meaning, remedy) in KINDS.items():
            value, where = getattr(self, name), _WHERE.get(name, name.rpartition("_")[2])
            is_whole = isinstance(value, bool)  # the mesh or the matrix
            if not (value if is_whole else len(value)):
                continue
            first = [] if is_whole else value[:_SHOWN].tolist()
            plain = tuple(tuple(index) if isinstance(index, list) else index for index in first)
            spoils = when == "always" or (when != "never" and not self.stored_normals)
            if name == "far_faces" and self.offset is not None:
                remedy += " The offset: ({:.17g}, {:.17g}, {:.17g}).".format(*self.offset)
            found.append(Finding(name, where, 1 if is_whole else len(value), plain, spoils, meaning, remedy))
        return tuple(sorted(found, key=lambda finding: not finding.spoils))

    @property
    def _summary(self) -> str:
        spoiled = sum(finding.spoils for finding in self.findings)
        notes = len(self.findings) - spoiled
        verdict = "ok" if self.ok else f"{spoiled} kind{'s' * (spoiled > 1)} of fault"
        more = f", {notes} note{'s' * (notes > 1)}" if notes else ""
        return f"Diagnosis of {self.n_points} points and {self.n_faces} faces: {verdict}{more}"

    def __str__(self) -> str:
        lines, rest = [self._summary], list(self.findings)
        while rest and len(lines) + len(sentence := _lines_of(rest[0])) < _LINES:
            lines += sentence
            del rest[0]
        if rest:
            names = ", ".join(finding.name for finding in rest)
            lines.append(f"  {shorten(f'and {names}', WIDTH - 2, placeholder=' …')}")
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<{self._summary}>"

    def explain(self) -> str:
        """Every finding with the first of its indices and its remedy."""
        lines = [self._summary]
        for finding in self.findings:
            lines += _lines_of(finding)
            for text in filter(None, (finding.indices, finding.remedy)):
                lines += wrapped(f"    {text}")
        return "\n".join(lines)

    def table(self) -> Table:
        """The findings as a `rich.table.Table`; print it with a `rich.console.Console`."""
        from rich import box
        from rich.table import Table

        table = Table(title=self._summary, title_justify="left", box=box.SIMPLE, show_header=False, leading=1)
        table.add_column(no_wrap=True)
        table.add_column(overflow="fold")  # code in a remedy may be longer than a line
        for finding in self.findings:
            label = f"[red]{finding.label}[/red]" if finding.spoils else finding.label
            texts = filter(None, (finding.sentence, finding.indices, finding.remedy))
            table.add_row(f"{finding.name}\n{label}", "\n".join(texts))
        return table

    def _repr_html_(self) -> str:
        rows = [(f.label, f.name, f.sentence, f.indices, f.remedy) for f in self.findings]
        return html_table(self._summary, ("", "name", "what", "where", "remedy"), rows)

    def to_dict(self) -> dict[str, Any]:
        """Whether it is `ok`, how many points and faces there are, and each finding by its name with all indices."""
        findings = {finding.name: asdict(finding) for finding in self.findings}
        for name, finding in findings.items():
            del finding["name"]
            indices = getattr(self, name)
            finding["indices"] = [] if isinstance(indices, bool) else indices.tolist()
        return {"ok": self.ok, "n_points": self.n_points, "n_faces": self.n_faces, "findings": findings}

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
            mesh.cell_data.update({name: flags[numbers] for name, flags in self._flags(self.n_faces, "faces").items()})
        mesh.point_data.update(self._flags(self.n_points, "points", "edges"))
        mesh.set_active_scalars("severity")
        return mesh

    def _flags(self, count: int, *places: str) -> dict[str, NDArray[np.int32]]:
        """The arrays of `to_mesh` over all points or all faces."""
        severity, flags = np.zeros((2, count), dtype=np.int32)
        for finding in reversed(self.findings):  # what spoils comes last and overrides
            if finding.where in places:
                indices = np.unique(getattr(self, finding.name))
                flags[indices] |= FLAGS[finding.name]
                severity[indices] = 1 + finding.spoils
        return {"diagnosis": flags, "severity": severity}


def _lines_of(finding: Finding) -> list[str]:
    return wrapped(f"  {finding.label}: {finding.sentence} ({finding.name})")


def diagnose(mesh: pv.DataSet, *, matrix: MatrixLike | None = None) -> Diagnosis:
    """Look for what will spoil a mesh's lighting: faces, normals and points, and the model matrix.

    PyVista's ``mesh.validate_mesh`` asks whether cells are what their types promise (convex, planar, not
    inverted, arrays of the right length). This asks what a light will make of them: whether every point gets a
    normal, whether neighbours agree about their front, whether the coordinates are fine enough for normals. A
    face that is not convex is no fault here; a mesh that is valid there may be dark here.

    No VTK algorithm sees a mesh with an index out of range, so that the worst file is reported, not fatal.

    Parameters
    ----------
    mesh : pyvista.DataSet
        Looked at, not changed. Of another than PolyData it is the extracted surface that is looked at.
    matrix : array_like or vtkMatrix4x4, optional
        (4, 4) model matrix that the mesh will be lit with.

    Returns
    -------
    Diagnosis
        `.ok`, `.findings`, an array of indices for each kind of fault; printable, `.explain()`, `.table()`,
        `.to_mesh()`.

    Raises
    ------
    ValueError
        If `mesh` is no DataSet, its dimensions or arrays do not fit its points, or `matrix` is not an affine
        4x4 matrix of finite numbers.
    """
    if not isinstance(mesh, pv.DataSet):
        remedy = "pyvista.wrap turns VTK's datasets into one; of a MultiBlock diagnose each block."
        check.refuse("mesh", type(mesh).__name__, "a pyvista.DataSet", remedy)
    singular, nearly, mirrored = (False, False, False) if matrix is None else check_matrix(matrix)
    refuse_wrong_sizes(mesh)
    invalid = invalid_cells(mesh)
    has_surface = isinstance(mesh, pv.PolyData) or not len(invalid)
    source = outer_surface(mesh) if has_surface else pv.PolyData(np.asarray(mesh.points))
    points = check.array("mesh.points", np.asarray(source.points))
    active = source.point_data.active_normals
    stored = np.empty((0, 3)) if active is None else np.asarray(active)
    n_faces, numbers, faces = _valid_faces(source, points)

    by_face = check_faces(points, faces)
    repeated = repeated_faces(faces, np.concatenate([by_face.degenerate, by_face.folded]))
    non_manifold, inconsistent = check_edges(faces, by_face.folded, repeated)
    used = np.zeros(len(points), dtype=bool)
    used[faces.connectivity] = True
    finite, first_in_place = finite_rows(points), first_alike(points)
    computed = normals.point_normals(points, faces.connectivity, faces.offsets)
    with np.errstate(all="ignore"):
        along = np.einsum("ij,ij->i", computed[: len(stored)], stored.astype(np.float64))
    finite_normals = finite_rows(stored)
    return Diagnosis(
        n_points=len(points),
        n_faces=n_faces,
        stored_normals=active is not None,
        invalid_cells=invalid,
        nothing_to_light=not len(invalid) and not (len(points) and (n_faces or active is not None)),
        non_finite_points=np.flatnonzero(~finite),
        zero_normals=np.flatnonzero(~stored.any(axis=1)),
        non_finite_normals=np.flatnonzero(~finite_normals),
        unlit_points=np.flatnonzero(used & finite & ~computed.any(axis=1)),
        degenerate_faces=numbers[by_face.degenerate],
        duplicate_faces=numbers[repeated],
        far_faces=numbers[by_face.far],
        inconsistent_edges=inconsistent,
        inside_out_faces=numbers[inside_out_faces(points, faces, first_in_place)],
        singular_matrix=singular,
        non_manifold_edges=non_manifold,
        thin_faces=numbers[by_face.thin],
        opposed_normals=np.flatnonzero(finite_normals & (along < 0)),
        duplicate_points=np.flatnonzero(finite & (first_in_place != np.arange(len(points)))),
        unused_points=np.flatnonzero(~used) if faces.count else np.empty(0, dtype=np.intp),
        nearly_singular_matrix=nearly,
        mirrored_matrix=mirrored,
        offset=by_face.offset,
        _points=points,
        _faces=(numbers, faces.connectivity, faces.offsets),
    )


def _valid_faces(source: pv.PolyData, points: FloatArray) -> tuple[int, IntArray, Faces]:
    """How many faces there are, and the numbers and the corners of those whose indices are points."""
    connectivity, offsets = (np.array(each, np.int64) for each in unchecked_polygons(source))
    sizes = np.diff(offsets)
    in_range = (connectivity >= 0) & (connectivity < len(points))
    if in_range.all():
        return len(sizes), np.arange(len(sizes)), Faces(points, connectivity, offsets)
    owners = np.repeat(np.arange(len(sizes)), sizes)
    valid = np.ones(len(sizes), dtype=bool)
    valid[owners[~in_range]] = False
    kept = np.concatenate([[0], np.cumsum(sizes[valid])])
    return len(sizes), np.flatnonzero(valid), Faces(points, connectivity[valid[owners]], kept)
