"""Code of remedies: lines of Python that use PyVista to repair the mesh in the variable `mesh`."""

from __future__ import annotations

from dataclasses import dataclass

from pvphong.studies.diagnose.orientation import TurnedFaces

_FROM_FACES = 'mesh.point_data.active_normals = mesh.phong.normals("angle")'
_FLIP = "mesh = mesh.flip_faces()"
_ORIENT = "mesh = mesh.compute_normals(auto_orient_normals=True)"
_OUTSIDE = 'mesh = mesh.extract_surface(algorithm="dataset_surface")'


@dataclass(frozen=True)
class Case:
    """Conditions on which remedies depend.

    Parameters
    ----------
    is_surface : bool
        True if the mesh is a PolyData; otherwise its surface is repaired.
    has_strips : bool
        True if faces are in triangle strips, which cannot be turned or removed individually.
    cells_before : bool
        True if vertex or line cells come before the faces.
    stored_normals : bool
        True if the mesh has stored normals, which are flipped with the faces.
    normals_opposed : bool
        True if nearly all stored normals point out of the back of their faces.
    is_outside_in : bool
        True if all faces belong to closed parts with inward fronts.
    faces_are_outward : bool
        True if the surface is closed and no face points inwards.
    turned : TurnedFaces
        Faces to turn so that neighbours agree about their front.
    unlit_have_area : bool
        True if faces with an area meet at points without a computed normal.
    """

    is_surface: bool
    has_strips: bool
    cells_before: bool
    stored_normals: bool
    normals_opposed: bool
    is_outside_in: bool
    faces_are_outward: bool
    turned: TurnedFaces
    unlit_have_area: bool

    def code(self, name: str) -> tuple[str, ...]:
        """Return lines of Python that repair the kind of fault `name`; empty if code cannot repair it."""
        lines = self._lines(name)
        if not lines:
            return ()
        if not self.is_surface:
            lines = (_OUTSIDE, *lines)
        elif self.has_strips and name not in ("zero_normals", "non_finite_normals", "misfit_normals"):
            lines = ("mesh = mesh.triangulate()", *lines)
        return lines

    def _lines(self, name: str) -> tuple[str, ...]:
        if name == "non_finite_points":
            keep = "keep = np.isfinite(mesh.points).all(axis=1)"
            return "import numpy as np", keep, "mesh = mesh.extract_points(keep, adjacent_cells=False)", _OUTSIDE
        if name in ("zero_normals", "non_finite_normals"):
            return (_FROM_FACES,)
        if name == "misfit_normals":
            return (_FLIP,) if self.normals_opposed and not self.faces_are_outward else (_FROM_FACES,)
        if name == "unlit_points" and self.unlit_have_area:
            return ("mesh = mesh.compute_normals(consistent_normals=False, split_vertices=True)",)
        if name in ("unlit_points", "degenerate_faces", "duplicate_faces"):
            kind = "duplicate_faces" if name == "duplicate_faces" else "degenerate_faces"
            after = " + mesh.n_verts + mesh.n_lines" if self.cells_before else ""
            return f"faces = mesh.phong.diagnose().{kind}", f"mesh = mesh.remove_cells(faces{after})"
        if name == "inconsistent_edges" and not self.turned.is_one_sided:
            if self.turned.is_closed:
                return (_ORIENT,)
            # VTK orients an open part like its first face
            flip = "flip_normals=True" if self.turned.faces[:1].tolist() == [0] else ""
            return (f"mesh = mesh.compute_normals({flip})",)
        if name == "inside_out_faces" and not self.is_outside_in:
            return (_ORIENT,)
        if name == "downward_faces" or name == "inside_out_faces":
            follow = self.stored_normals and not self.normals_opposed
            return (_FLIP, _FROM_FACES) if follow else (_FLIP,)
        return ()
