"""The kinds of fault: what each means, when it spoils the lighting, and what to do about it."""

from __future__ import annotations

from typing import NamedTuple

_BLACK = 0.01
"""The share of a surface from which black or blurred places spoil it."""
_TURNED = 0.125
"""The share of a surface from which faces or normals that look the wrong way spoil it: see `geometry.fit.MISFIT`."""


class Kind(NamedTuple):
    """One kind of fault.

    Attributes
    ----------
    spoils_from : float or None
        The share of the surface, 0 to 1, from which it spoils the lighting, so that `Diagnosis.ok` is False; below that
        it is a note. 0 spoils whatever the share, None never.
    stored_help : bool
        Whether stored normals make up for it: where there are some it is a note.
    meaning, remedy : str
        What it is and what to do about it; the remedy ends with a colon where code follows.
    """

    spoils_from: float | None
    stored_help: bool
    meaning: str
    remedy: str


KINDS: dict[str, Kind] = {
    "invalid_cells": Kind(
        0.0,
        False,
        "with an index that no point has, with too few points for their type, of a type that VTK has not, or of the "
        "type convex point set",
        "Repair the file or the code that made them, and make tetrahedra of point sets: VTK would crash, so pvphong "
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
        "without an area or with a corner that comes twice; they have no weight in the normals",
        "Nothing shows of them; to remove them:",
    ),
    "duplicate_faces": Kind(
        _TURNED,
        True,
        "round the same points in the same order as an earlier one: both count in the normals there",
        "Remove them:",
    ),
    "far_faces": Kind(
        _BLACK,
        True,
        "so far from the origin for their size that the coordinates' float type blurs their normals",
        "Subtract an offset before the coordinates are rounded to this float type (of parts far apart, each its own), "
        "or keep them in float64.",
    ),
    "inconsistent_edges": Kind(
        _TURNED,
        True,
        "whose two faces have opposite fronts, so that their normals cancel",
        "Turn the faces that look the wrong way:",
    ),
    "inside_out_faces": Kind(
        _TURNED,
        True,
        "of closed parts whose fronts look inwards: seen from outside they are lit as if from within",
        "Turn the faces. Leave them if it is a room that is seen from within.",
    ),
    "downward_faces": Kind(
        None,
        False,
        "that all look down: light from above leaves them black",
        "Turn the surface, or light both of its sides by LightModel(two_sided=True). To turn it:",
    ),
    "singular_matrix": Kind(
        0.0,
        False,
        "flattens the mesh: surfaces lose their normals",
        "Use a small scale in place of 0.",
    ),
    "non_manifold_edges": Kind(
        None,
        False,
        "of more than two faces: their points are lit by the mean of sheets that may not belong together",
        'Split them if it shows: feature_angle="auto" does where they are sharp.',
    ),
    "thin_faces": Kind(
        None,
        False,
        "so thin that the rounding of their coordinates blurs their normals",
        "Leave them if they cover little. Else remesh them, or keep the coordinates in float64.",
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
        "in the place of an earlier one: a seam, over which computed normals are not smooth",
        "Merge them if no seam is meant: mesh.clean().",
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
        "flattens the mesh but for the last bits of its entries: where normals point depends on those",
        "Leave it if they are meant; else use a matrix that flattens exactly, or less.",
    ),
    "mirrored_matrix": Kind(
        None,
        False,
        "mirrors: lit rightly here, but VTK's own shader draws it black",
        "Flip the mesh itself, if VTK is to light it.",
    ),
}
"""Fields of `Diagnosis` that hold indices → what these mean, in the order of the report.

What is counted is the last word of a name, cells, faces, edges, points or the matrix, but for those in `WHERE`.
"""

WHERE = {"nothing_to_light": "mesh"} | dict.fromkeys(
    ("zero_normals", "non_finite_normals", "misfit_normals", "opposed_normals"), "points"
)
"""What is counted of the kinds whose name does not say it."""

FLAGS: dict[str, int] = {name: 1 << place for place, name in enumerate(KINDS)}
"""The bit of each kind in the arrays of `Diagnosis.to_mesh`."""
