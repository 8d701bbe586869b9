"""Faults of a mesh, or of its model matrix, that spoil the lighting: `diagnose` and its result."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from textwrap import shorten
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from pvphong.base import check
from pvphong.base.text import WIDTH, html_table, wrapped
from pvphong.base.types import Float64Array, FloatArray, IntArray, MatrixLike, Vector
from pvphong.geometry.fit import MISFIT, NormalsFit, fit_of, weights_of
from pvphong.geometry.normals import Faces
from pvphong.meshes.cells import invalid_cells, refuse_wrong_sizes
from pvphong.meshes.surfaces import outer_surface, unchecked_polygons, weighted_normals
from pvphong.studies.diagnose.checks import (
    Edges,
    check_edges,
    check_faces,
    check_matrix,
    edges_of,
    finite_rows,
    first_alike,
    nonzero_rows,
    repeated_faces,
)
from pvphong.studies.diagnose.kinds import FLAGS, KINDS, WHERE
from pvphong.studies.diagnose.orientation import TurnedFaces, turned_faces
from pvphong.studies.diagnose.remedies import Case
from pvphong.studies.diagnose.shells import inside_out_faces

if TYPE_CHECKING:
    from rich.table import Table

_LINES = 5  # number of lines of a printed diagnosis
_OPPOSED = 0.9  # if normals are opposed on a larger fraction of the surface, the faces are assumed to be turned
_SHOWN = 6  # number of indices that a report lists for each finding

# Least fraction of the surface's area that counts as all of it.
_ALL = 0.99


@dataclass(frozen=True)
class Finding:
    """One kind of fault that a mesh or its matrix has.

    Attributes
    ----------
    name : str
        Name of the field of `Diagnosis` that holds all indices.
    where : str
        Kind of elements: "cells", "faces", "edges", "points", "mesh" or "matrix".
    count : int
        Number of elements; 1 for the mesh or the matrix as a whole.
    first : tuple
        First few indices; pairs of points for edges.
    share : float
        Affected fraction of the surface's area, 0 to 1. If the surface has no area, the fraction of its points or
        faces.
    spoils : bool
        True if the fault spoils the lighting. If False, the finding is a note: it may be intended, or does no harm.
    meaning, remedy : str
        Description of the fault, and how to repair it.
    code : tuple of str
        Lines of Python that repair a mesh in the variable `mesh`; empty if code cannot repair it.
    """

    name: str
    where: str
    count: int
    first: tuple[Any, ...]
    share: float
    spoils: bool
    meaning: str
    remedy: str
    code: tuple[str, ...]

    @property
    def sentence(self) -> str:
        """Text on the affected elements and the fault, such as "2 faces (1 % of the surface) ..."."""
        if self.where in ("mesh", "matrix"):
            return f"the {self.where} {self.meaning}"
        share = f" ({_percent(self.share)} of the surface)" if self.share else ""
        return f"{self.count} {self.where if self.count > 1 else self.where[:-1]}{share} {self.meaning}"

    @property
    def indices(self) -> str:
        """First few indices as text, with "…" if there are more."""
        return ", ".join(map(str, self.first)) + (", …" if self.count > len(self.first) > 0 else "")

    @property
    def label(self) -> str:
        """The word "spoils" for a fault that spoils the lighting, "note" for other faults."""
        return "spoils" if self.spoils else "note"


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis:
    """Result of `diagnose`: `print(diagnosis)` names the faults, `print(diagnosis.explain())` adds indices and
    remedies.

    Indices are sorted, and refer to the surface's points and faces.

    The surface of a PolyData is the mesh itself. For other datasets the surface's arrays ``vtkOriginalPointIds`` and
    ``vtkOriginalCellIds`` refer to the dataset. Vertices and lines are not faces; a strip has one face per triangle.
    The fields that describe faults are empty or False if there is no such fault. "A note" marks faults that never spoil
    the lighting.

    Attributes
    ----------
    n_points, n_faces : int
        Size of the surface.
    stored_normals : bool
        True if the surface has active point normals, which the lighting then uses.
    normals_fit : NormalsFit or None
        Angles between the stored normals and the faces: `.mean` and `.worst` in degrees, and `.beyond_60`, the fraction
        of the area where the angle exceeds 60. None without stored normals or without faces.
    invalid_cells : ndarray
        Cells with an index outside the points, or with too few points for their type. They are left out of all other
        checks. A dataset other than PolyData with such a cell has no surface.
    nothing_to_light : bool
        True if there are neither faces nor point normals.
    non_finite_points : ndarray
        Points with a NaN or infinity. Faces with such a point are not checked.
    zero_normals, non_finite_normals : ndarray
        Points whose stored normal is zero, or has a NaN or infinity.
    misfit_normals : ndarray
        Points whose stored normal differs from the faces around them by more than 22.5 degrees. Such normals spoil the
        lighting if `normals_fit.mean` exceeds 22.5 too: an eighth of the surface may then be turned by 180 degrees.
    unlit_points : ndarray
        Points in faces whose computed normal is zero: no face there has an area and finite points, or the normals
        cancel, as with two coincident faces of opposite fronts. Such points spoil nothing if normals are stored.
    degenerate_faces : ndarray
        Faces whose area is zero within the rounding of float64, or with a repeated corner.
    duplicate_faces : ndarray
        Faces with the same points in the same order as a face with a lower index. Repeated faces have more weight in
        the normals around them, but spoil nothing if normals are stored.
    far_faces : ndarray
        Faces so far from the origin that the rounding of coordinates may turn their normal by more than 1/255 rad. This
        changes a colour by up to about one display step.
    inconsistent_edges : ndarray
        Edges, as points of shape (m, 2), whose two faces have opposite fronts. Duplicate faces are left out.
        `Finding.share` is the area of the faces that must be turned.
    inside_out_faces : ndarray
        Faces whose fronts point inwards: those of closed parts with negative signed volume, except walls of cavities.
        Such faces spoil nothing if stored normals point outwards.
    downward_faces : ndarray
        All faces, if no vertex faces up (+z), as in a terrain that is upside down. A note: the surface may be a
        ceiling.
    singular_matrix : bool
        True if the matrix flattens space: its determinant is zero.
    non_manifold_edges : ndarray
        Edges, as points of shape (m, 2), with more than two faces. A note: normals there are a mean of all faces.
    thin_faces : ndarray
        Faces so thin that the rounding of coordinates may turn their normal by more than 1/255 rad, even at the origin.
        A note: they cover little.
    opposed_normals : ndarray
        Points whose stored normal points out of the back of their faces. A note: this may be intended.
    duplicate_points : ndarray
        Points at exactly the position of a point with a lower index. A note: seams and sharp edges have such points.
    unused_points : ndarray
        Points without a face, if there are faces. A note: they are not visible.
    nearly_singular_matrix : bool
        True if the matrix's determinant would be zero without the rounding of its entries. A note: normals are exact
        for the stored matrix.
    mirrored_matrix : bool
        True if the matrix mirrors. A note: pvphong lights the mirrored mesh correctly.
    offset : tuple of 3 floats or None
        Offset that repairs `far_faces` if it is subtracted from the coordinates. None if there are no such faces, or no
        single offset repairs all of them.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> pv.Sphere().phong.diagnose().non_manifold_edges
    array([], shape=(0, 2), dtype=int64)
    """

    FLAGS: ClassVar[dict[str, int]] = FLAGS
    """The bit of each kind of fault in the arrays of `to_mesh`."""

    n_points: int
    n_faces: int
    stored_normals: bool
    normals_fit: NormalsFit | None
    invalid_cells: IntArray
    nothing_to_light: bool
    non_finite_points: IntArray
    zero_normals: IntArray
    non_finite_normals: IntArray
    misfit_normals: IntArray
    unlit_points: IntArray
    degenerate_faces: IntArray
    duplicate_faces: IntArray
    far_faces: IntArray
    inconsistent_edges: IntArray
    inside_out_faces: IntArray
    downward_faces: IntArray
    singular_matrix: bool
    non_manifold_edges: IntArray
    thin_faces: IntArray
    opposed_normals: IntArray
    duplicate_points: IntArray
    unused_points: IntArray
    nearly_singular_matrix: bool
    mirrored_matrix: bool
    offset: Vector | None
    _shares: dict[str, float]
    _case: Case
    _points: FloatArray
    _faces: tuple[IntArray, IntArray, IntArray]  # indices, connectivity and offsets of the valid faces

    @property
    def ok(self) -> bool:
        """True if nothing spoils the lighting; notes do not count."""
        return not any(finding.spoils for finding in self.findings)

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """Faults that were found: first those that spoil the lighting, then notes."""
        found = []
        for name in KINDS:
            value, where = getattr(self, name), WHERE.get(name, name.rpartition("_")[2])
            is_whole = isinstance(value, bool)  # the mesh or the matrix
            if not (value if is_whole else len(value)):
                continue
            if name == "opposed_normals" and self._spoils("misfit_normals"):
                continue  # the same fault
            first = [] if is_whole else value[:_SHOWN].tolist()
            plain = tuple(tuple(index) if isinstance(index, list) else index for index in first)
            share, count = self._shares.get(name, 0.0), 1 if is_whole else len(value)
            (meaning, remedy), code = self._words(name), self._case.code(name)
            if code and len(self.invalid_cells):  # VTK would crash
                remedy, code = "Repair the invalid cells first.", ()
            found.append(Finding(name, where, count, plain, share, self._spoils(name), meaning, remedy, code))
        always = {name for name, kind in KINDS.items() if kind.spoils_from == 0.0}
        return tuple(sorted(found, key=lambda each: (not each.spoils, each.name not in always, -each.share)))

    def _spoils(self, name: str) -> bool:
        """Return True if a fault of this mesh spoils its lighting, False if the fault is a note.

        `name` is the field of `Diagnosis` with the fault.
        """
        least, helped, _, _ = KINDS[name]
        if name == "inside_out_faces":
            helped = self._case.normals_opposed
        if least is None or (helped and self.stored_normals):
            return False
        if name == "misfit_normals" and self.normals_fit is not None:
            return self.normals_fit.mean > MISFIT
        return self._shares.get(name, 1.0) >= least

    def _words(self, name: str) -> tuple[str, str]:
        """Return the description and the remedy of a kind of fault, adapted to this mesh.

        `name` is the field with the fault.
        """
        _, _, meaning, remedy = KINDS[name]
        case = self._case
        if name == "far_faces" and self.offset is not None:
            remedy += " The offset: ({:.17g}, {:.17g}, {:.17g}).".format(*self.offset)
        if name == "far_faces" and not self._spoils(name):
            remedy = f"They cover little and can stay. {remedy}"
        if name == "misfit_normals" and self.normals_fit is not None:
            fit = self.normals_fit
            meaning += (
                f": on average {fit.mean:.0f}° off it, at worst {fit.worst:.0f}°; {_percent(fit.beyond_60)} of the "
                "surface are off by more than 60°"
            )
            if "flip_faces" in "".join(case.code(name)):
                remedy = "The faces were turned after the normals were stored. Turn them back:"
        if name == "unlit_points" and case.unlit_have_area:
            remedy = "Give each face there its own points:"
        if name == "inconsistent_edges" and case.turned.is_one_sided:
            remedy = "The surface is one-sided and cannot be oriented; light it by LightModel(two_sided=True)."
        if name == "inside_out_faces" and self.stored_normals and case.normals_opposed:
            meaning = "of closed parts whose fronts point inwards; the stored normals point outwards and are used"
        return meaning, remedy

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
        """Return every finding with its first indices and its remedy."""
        lines = [self._summary]
        for finding in self.findings:
            lines += _lines_of(finding)
            for text in filter(None, (finding.indices, finding.remedy)):
                lines += wrapped(f"    {text}")
            lines += [f"      {line}" for line in finding.code]
        return "\n".join(lines)

    def table(self) -> Table:
        """Return the findings as a `rich.table.Table`; print it with a `rich.console.Console`."""
        from rich import box
        from rich.table import Table

        table = Table(title=self._summary, title_justify="left", box=box.SIMPLE, show_header=False, leading=1)
        table.add_column(no_wrap=True)
        table.add_column(overflow="fold")  # code in a remedy may be longer than a line
        for finding in self.findings:
            label = f"[red]{finding.label}[/red]" if finding.spoils else finding.label
            texts = filter(None, (finding.sentence, finding.indices, finding.remedy, *finding.code))
            table.add_row(f"{finding.name}\n{label}", "\n".join(texts))
        return table

    def _repr_html_(self) -> str:
        rows = [(f.label, f.name, f.sentence, f.indices, "\n".join([f.remedy, *f.code])) for f in self.findings]
        return html_table(self._summary, ("", "name", "what", "where", "remedy"), rows)

    def to_dict(self) -> dict[str, Any]:
        """Return `ok`, the numbers of points and faces, and each finding by its name, with all indices."""
        findings = {finding.name: asdict(finding) for finding in self.findings}
        for name, finding in findings.items():
            del finding["name"]
            indices = getattr(self, name)
            finding["indices"] = [] if isinstance(indices, bool) else indices.tolist()
        fit = None if self.normals_fit is None else self.normals_fit._asdict()
        counts = {"n_points": self.n_points, "n_faces": self.n_faces}
        return {"ok": self.ok, **counts, "normals_fit": fit, "findings": findings}

    def to_mesh(self) -> pv.PolyData:
        """Return a mesh that shows the findings.

        Returns
        -------
        pyvista.PolyData
            The surface without invalid faces, so that it is safe to draw. On points and cells, the active array
            ``"severity"`` is 0 without findings, 1 for a note and 2 for a fault that spoils the lighting, and the array
            ``"diagnosis"`` is the sum of the findings' `FLAGS`; edges are marked at their points. The cell array
            ``"face"`` holds each face's index.
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
        """Return the arrays "diagnosis" and "severity" of `to_mesh`, for all points or for all faces.

        `count` is the number of points or faces. A finding is marked if its `Finding.where` is one of `places`.
        """
        severity, flags = np.zeros((2, count), dtype=np.int32)
        for finding in reversed(self.findings):  # findings that spoil the lighting come last and override notes
            if finding.where in places:
                indices = np.unique(getattr(self, finding.name))
                flags[indices] |= FLAGS[finding.name]
                severity[indices] = 1 + finding.spoils
        return {"diagnosis": flags, "severity": severity}


def _percent(share: float) -> str:
    """Format a fraction of the surface as a percentage with two digits."""
    return f"{float(f'{100.0 * share:.2g}'):g} %"


def _lines_of(finding: Finding) -> list[str]:
    return wrapped(f"  {finding.label}: {finding.sentence} ({finding.name})")


def diagnose(mesh: pv.DataSet, *, matrix: MatrixLike | None = None) -> Diagnosis:
    """Find faults that spoil a mesh's lighting: in faces, normals and points, and in the model matrix.

    PyVista's ``mesh.validate_mesh`` checks cells against their types (convex, planar, not inverted, arrays of the right
    length). This function checks conditions of lighting: every point has a normal, neighbours agree about their front,
    and coordinates are precise enough for normals. A face that is not convex is no fault here, and a valid mesh may be
    dark.

    No VTK algorithm runs on a mesh with an index out of range, so that a damaged file does not crash the process.

    Parameters
    ----------
    mesh : pyvista.DataSet
        Mesh to check; it is not modified. For datasets other than PolyData, the surface is extracted and checked.
    matrix : array_like or vtkMatrix4x4, optional
        (4, 4) model matrix of the mesh.

    Returns
    -------
    Diagnosis
        `.ok`, `.findings`, and an array of indices for each kind of fault; printable, with `.explain()`, `.table()` and
        `.to_mesh()`.

    Raises
    ------
    ValueError
        If `mesh` is not a DataSet, its dimensions or arrays do not fit its points, or `matrix` is not an affine 4x4
        matrix of finite numbers.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> print(ph.diagnose(pv.Sphere()))
    Diagnosis of 842 points and 1680 faces: ok
    """
    if not isinstance(mesh, pv.DataSet):
        remedy = "Convert a VTK dataset with pyvista.wrap; diagnose each block of a MultiBlock."
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
    weightless = np.concatenate([by_face.degenerate, by_face.folded])
    edges = Edges.between(*edges_of(faces), len(points))
    repeated = repeated_faces(faces, edges, weightless)
    non_manifold, inconsistent = check_edges(faces, edges, by_face.folded, repeated)
    used = np.zeros(len(points), dtype=bool)
    used[faces.connectivity] = True
    finite, first_in_place = finite_rows(points), first_alike(points)
    computed = weighted_normals(points, faces.connectivity, faces.offsets)
    with np.errstate(all="ignore"):
        along = np.einsum("ij,ij->i", computed[: len(stored)], stored.astype(np.float64))
    finite_normals = finite_rows(stored)
    areas, weights = by_face.areas, weights_of(faces, by_face.areas)
    fit, misfit = (None, np.empty(0, np.intp)) if active is None else fit_of(stored, computed, weights)
    turned = TurnedFaces(np.empty(0, np.intp), False, False)
    if len(inconsistent):
        turned = turned_faces(points, faces, areas, np.concatenate([by_face.folded, repeated]))
    is_duplicate = first_in_place != np.arange(len(points))
    inside_out, is_closed = inside_out_faces(points, faces, first_in_place, None if is_duplicate.any() else edges)
    unlit = np.flatnonzero(used & finite & ~nonzero_rows(computed))
    zero, opposed = np.flatnonzero(~nonzero_rows(stored)), np.flatnonzero(finite_normals & (along < 0))
    lit_by = computed if active is None else stored
    looks_down = bool(weights.sum()) and _share(np.flatnonzero(lit_by[:, 2] < 0.0), weights) >= _ALL
    of_points = {
        "non_finite_points": ~finite,
        "zero_normals": zero,
        "non_finite_normals": ~finite_normals,
        "misfit_normals": misfit,
        "unlit_points": unlit,
        "opposed_normals": opposed,
    }
    of_faces = {
        "duplicate_faces": repeated,
        "far_faces": by_face.far,
        "inconsistent_edges": turned.faces,
        "inside_out_faces": inside_out,
        "downward_faces": np.full(faces.count, looks_down),
        "thin_faces": by_face.thin,
    }
    shares = {name: _share(where, weights) for name, where in of_points.items()}
    shares |= {name: _share(where, areas) for name, where in of_faces.items()}
    case = Case(
        is_surface=isinstance(mesh, pv.PolyData),
        has_strips=bool(source.n_strips),
        cells_before=bool(source.n_verts or source.n_lines),
        stored_normals=active is not None,
        normals_opposed=shares["opposed_normals"] > _OPPOSED,
        is_outside_in=len(inside_out) == faces.count,
        faces_are_outward=is_closed and not len(inside_out),
        turned=turned,
        unlit_have_area=bool(weights[unlit].any()),
    )
    return Diagnosis(
        n_points=len(points),
        n_faces=n_faces,
        stored_normals=active is not None,
        normals_fit=fit,
        invalid_cells=invalid,
        nothing_to_light=not len(invalid) and not (len(points) and (n_faces or active is not None)),
        non_finite_points=np.flatnonzero(~finite),
        zero_normals=zero,
        non_finite_normals=np.flatnonzero(~finite_normals),
        misfit_normals=misfit,
        unlit_points=unlit,
        degenerate_faces=numbers[by_face.degenerate],
        duplicate_faces=numbers[repeated],
        far_faces=numbers[by_face.far],
        inconsistent_edges=inconsistent,
        inside_out_faces=numbers[inside_out],
        downward_faces=numbers if looks_down else np.empty(0, np.intp),
        singular_matrix=singular,
        non_manifold_edges=non_manifold,
        thin_faces=numbers[by_face.thin],
        opposed_normals=opposed,
        duplicate_points=np.flatnonzero(finite & is_duplicate),
        unused_points=np.flatnonzero(~used) if faces.count else np.empty(0, dtype=np.intp),
        nearly_singular_matrix=nearly,
        mirrored_matrix=mirrored,
        offset=by_face.offset,
        _shares=shares,
        _case=case,
        _points=points,
        _faces=(numbers, faces.connectivity, faces.offsets),
    )


def _share(where: Any, weights: Float64Array) -> float:
    """Return the fraction of the surface's area that some of its points or faces cover.

    If all areas are 0, return the fraction of the number of points or faces.

    Parameters
    ----------
    where : ndarray
        Indices or mask of the points or faces.
    weights : ndarray
        Shape (n,): areas of all points or faces.
    """
    total = float(weights.sum())
    if total > 0.0:
        return float(weights[where].sum()) / total
    return float(np.count_nonzero(where) if where.dtype == bool else len(where)) / max(len(weights), 1)


def _valid_faces(source: pv.PolyData, points: FloatArray) -> tuple[int, IntArray, Faces]:
    """Return the faces of a surface `source` with `points`, without the faces that have an index out of range.

    Returns
    -------
    count : int
        Number of all faces.
    numbers : ndarray
        Indices of the valid faces.
    faces : Faces
        The valid faces.
    """
    connectivity, offsets = (np.array(each, np.int64) for each in unchecked_polygons(source))  # a diagnosis keeps them
    sizes = np.diff(offsets)
    in_range = (connectivity >= 0) & (connectivity < len(points))
    if in_range.all():
        return len(sizes), np.arange(len(sizes)), Faces(points, connectivity, offsets)
    owners = np.repeat(np.arange(len(sizes)), sizes)
    valid = np.ones(len(sizes), dtype=bool)
    valid[owners[~in_range]] = False
    kept = np.concatenate([[0], np.cumsum(sizes[valid])])
    return len(sizes), np.flatnonzero(valid), Faces(points, connectivity[valid[owners]], kept)
