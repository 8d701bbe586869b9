"""The kinds of fault: meaning, remedy, and the least fraction of the surface at which they spoil the lighting."""

from __future__ import annotations

from typing import NamedTuple

_BLACK = 0.01
"""Least fraction of a surface at which black areas, or areas with uncertain normals, spoil the lighting."""
_TURNED = 0.125
"""Least fraction of a surface at which reversed faces or normals spoil the lighting; see `geometry.fit.MISFIT`."""


class Kind(NamedTuple):
    """One kind of fault.

    Attributes
    ----------
    spoils_from : float or None
        Smallest affected fraction of the surface, 0 to 1, at which the fault spoils the lighting, so that
        `Diagnosis.ok` is False. If a smaller fraction is affected, the fault is only a note. With 0, the fault always
        spoils the lighting; with None, never. The fraction is not used for misfit normals: they spoil the lighting if
        the mean angle between stored normals and faces exceeds `geometry.fit.MISFIT`.
    stored_help : bool
        True if the fault is only a note in a mesh with stored normals. This is not used for inside-out faces: they are
        a note if the stored normals point out of the backs of nearly all faces.
    meaning, remedy : str
        Description of the fault and of its repair. The remedy ends with a colon if code follows.
    """

    spoils_from: float | None
    stored_help: bool
    meaning: str
    remedy: str


KINDS: dict[str, Kind] = {
    "invalid_cells": Kind(
        0.0,
        False,
        "with an index out of range, with too few points for their type, of a type unknown to VTK, or of the "
        "type convex point set",
        "Repair the file or the code that made them, and convert point sets to tetrahedra. VTK would crash, so pvphong "
        "refuses the mesh.",
    ),
    "nothing_to_light": Kind(
        0.0,
        False,
        "has no faces and no point normals",
        "Give it faces, or set mesh.point_data.active_normals.",
    ),
    "non_finite_points": Kind(
        0.0,
        False,
        "with a NaN or infinity; their faces have no normal",
        "Remove them:",
    ),
    "zero_normals": Kind(
        _BLACK,
        False,
        "with a stored normal of length zero, unlit",
        "Compute the normals from the faces:",
    ),
    "non_finite_normals": Kind(
        _BLACK,
        False,
        "with a NaN or infinity in the stored normal, unlit",
        "Compute the normals from the faces:",
    ),
    "misfit_normals": Kind(
        _TURNED,
        False,
        "with a stored normal that does not fit the faces around it",
        "The points have changed since the normals were stored, or the faces were turned. Compute the normals from the "
        "faces:",
    ),
    "unlit_points": Kind(
        _BLACK,
        True,
        "whose faces have no area, are not finite, or cancel as two coincident opposite faces do",
        "Remove the faces without an area:",
    ),
    "degenerate_faces": Kind(
        None,
        True,
        "without an area or with a repeated corner; they have no weight in the normals",
        "They are not visible. To remove them:",
    ),
    "duplicate_faces": Kind(
        _TURNED,
        True,
        "with the same points in the same order as an earlier face; both faces count in the normals there",
        "Remove them:",
    ),
    "far_faces": Kind(
        _BLACK,
        True,
        "so far from the origin for their size that the coordinates' float type blurs their normals",
        "Subtract an offset before the coordinates are rounded to this float type (a separate one for each of "
        "several distant parts), or keep them in float64.",
    ),
    "inconsistent_edges": Kind(
        _TURNED,
        True,
        "whose two faces have opposite fronts, so that their normals cancel",
        "Turn the reversed faces:",
    ),
    "inside_out_faces": Kind(
        _TURNED,
        True,
        "of closed parts whose fronts point inwards: from outside they are lit as if from within",
        "Turn the faces. Leave them if the mesh is a room seen from within.",
    ),
    "downward_faces": Kind(
        None,
        False,
        "that all point down: light from above leaves them black",
        "Turn the surface, or light both of its sides by LightModel(two_sided=True). To turn it:",
    ),
    "singular_matrix": Kind(
        0.0,
        False,
        "flattens the mesh: surfaces lose their normals",
        "Use a small scale instead of 0.",
    ),
    "non_manifold_edges": Kind(
        None,
        False,
        "of more than two faces: their points are lit with a mean of normals that may be unrelated",
        'Split them if this is visible; feature_angle="auto" splits sharp edges.',
    ),
    "thin_faces": Kind(
        None,
        False,
        "so thin that the rounding of their coordinates blurs their normals",
        "Leave them if they cover little. Otherwise remesh them, or keep the coordinates in float64.",
    ),
    "opposed_normals": Kind(
        None,
        False,
        "with a stored normal on the back of their faces",
        "Flip the faces or the normals if light falls on the wrong side.",
    ),
    "duplicate_points": Kind(
        None,
        False,
        "at the position of an earlier point: a seam, across which computed normals are not smooth",
        "Merge them if no seam is intended: mesh.clean().",
    ),
    "unused_points": Kind(
        None,
        False,
        "in no face, without a computed normal",
        "Leave them, or drop them with mesh.clean().",
    ),
    "nearly_singular_matrix": Kind(
        None,
        False,
        "flattens the mesh up to rounding: the directions of normals depend on the last bits of its entries",
        "Leave it if these bits are intended. Otherwise use a matrix that flattens exactly, or less.",
    ),
    "mirrored_matrix": Kind(
        None,
        False,
        "mirrors: pvphong lights the mirrored mesh correctly, but VTK's own shader draws it black",
        "Flip the mesh itself if VTK lights it.",
    ),
}
"""Field of `Diagnosis` that holds a fault's indices → its kind, in the order of the report.

The last word of a name is the affected element: cells, faces, edges, points or matrix. `WHERE` holds the exceptions.
"""

WHERE = {"nothing_to_light": "mesh"} | dict.fromkeys(
    ("zero_normals", "non_finite_normals", "misfit_normals", "opposed_normals"), "points"
)
"""Name of a kind of fault → affected elements, for the names that do not end with the elements."""

FLAGS: dict[str, int] = {name: 1 << place for place, name in enumerate(KINDS)}
"""The bit of each kind in the arrays of `Diagnosis.to_mesh`."""
