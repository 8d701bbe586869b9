"""The kinds of fault that `pvphong.diagnose` looks for, and which of them spoil the lighting."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Where = Literal["cells", "faces", "edges", "points", "mesh", "matrix"]


@dataclass(frozen=True)
class Kind:
    """One kind of fault.

    Attributes
    ----------
    where : str
        What is counted.
    spoils : bool
        Whether it spoils the lighting, so that `Diagnosis.ok` is False; else it is a note.
    meaning, remedy : str
        What it is and what to do about it.
    """

    where: Where
    spoils: bool
    meaning: str
    remedy: str


def _spoils(where: Where, meaning: str, remedy: str) -> Kind:
    return Kind(where, True, meaning, remedy)


def _note(where: Where, meaning: str, remedy: str) -> Kind:
    return Kind(where, False, meaning, remedy)


# By the field of `Diagnosis` that holds the indices, in the order of the report.
KINDS: dict[str, Kind] = {
    "invalid_cells": _spoils(
        "cells",
        "with an index that no point has, with too few points for their type, of a type that VTK has not, or of the "
        "type convex point set",
        "Repair the file or the code that made them, and make tetrahedra of point sets: VTK would crash, so pvphong "
        "refuses the mesh.",
    ),
    "nothing_to_light": _spoils(
        "mesh",
        "has no faces and no point normals",
        "Give it faces, or set mesh.point_data.active_normals.",
    ),
    "non_finite_points": _spoils(
        "points",
        "with a NaN or infinity; their faces have no normal",
        "Remove them, for example with mesh.remove_points.",
    ),
    "zero_normals": _spoils(
        "points",
        "with a stored normal of length zero, unlit",
        "Compute the normals anew: mesh.point_data.active_normals = pvphong.vertex_normals(mesh).",
    ),
    "non_finite_normals": _spoils(
        "points",
        "with a NaN or infinity in the stored normal, unlit",
        "Compute the normals anew: mesh.point_data.active_normals = pvphong.vertex_normals(mesh).",
    ),
    "unlit_points": _spoils(
        "points",
        "whose faces have no area, are not finite, or cancel as two coincident opposite faces do",
        "Remove such faces, and one of each coincident pair, with mesh.remove_cells.",
    ),
    "degenerate_faces": _spoils(
        "faces",
        "without an area or with a corner that comes twice; they have no weight in the normals",
        "Remove them, for example with mesh.remove_cells.",
    ),
    "duplicate_faces": _spoils(
        "faces",
        "round the same points in the same order as an earlier one: both count in the normals there",
        "Remove them, for example with mesh.remove_cells.",
    ),
    "far_faces": _spoils(
        "faces",
        "so far from the origin for their size that the coordinates' float type blurs their normals",
        "Subtract an offset before the coordinates are rounded to this float type (of parts far apart, each its own), "
        "or keep them in float64.",
    ),
    "inconsistent_edges": _spoils(
        "edges",
        "whose two faces have opposite fronts, so that their normals cancel",
        "Turn the faces: mesh.compute_normals(consistent_normals=True, auto_orient_normals=True).",
    ),
    "inside_out_faces": _spoils(
        "faces",
        "of closed parts whose fronts look inwards: they are lit as if seen from within",
        "Turn the faces: mesh.flip_faces(), or mesh.compute_normals(consistent_normals=True, "
        "auto_orient_normals=True) for some parts of several. Leave them if it is a room that is seen from within.",
    ),
    "singular_matrix": _spoils(
        "matrix",
        "flattens the mesh: surfaces lose their normals",
        "Use a small scale in place of 0.",
    ),
    "non_manifold_edges": _note(
        "edges",
        "of more than two faces: their points are lit by the mean of sheets that may not belong together",
        "Split them if it shows: mesh.compute_normals(split_vertices=True, non_manifold_traversal=False).",
    ),
    "thin_faces": _note(
        "faces",
        "so thin that the rounding of their coordinates blurs their normals",
        "Remesh them, or keep the coordinates in float64.",
    ),
    "opposed_normals": _note(
        "points",
        "with a stored normal on the back of their faces",
        "Flip the faces or the normals if light falls on the wrong side.",
    ),
    "duplicate_points": _note(
        "points",
        "in the place of an earlier one: a seam, over which computed normals are not smooth",
        "Merge them if no seam is meant: mesh.clean().",
    ),
    "unused_points": _note(
        "points",
        "in no face, without a computed normal",
        "Leave them, or drop them with mesh.clean().",
    ),
    "nearly_singular_matrix": _note(
        "matrix",
        "flattens the mesh but for the last bits of its entries: which way normals point hangs on those",
        "Leave it if they are meant; else use a matrix that flattens exactly, or less.",
    ),
    "mirrored_matrix": _note(
        "matrix",
        "mirrors: lit rightly here, but VTK's own shader draws it black",
        "Flip the mesh itself, if VTK is to light it.",
    ),
}

FLAGS: dict[str, int] = {name: 1 << place for place, name in enumerate(KINDS)}
"""The bit of each kind in the arrays of `Diagnosis.to_mesh`."""
