"""What a worker does: look at a file, or light one.

A worker has as many threads as Dask gave it, each with a piece of its own: the evaluator's own threads stay out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyvista as pv

from pvphong.base import check, threads
from pvphong.batch import receipts
from pvphong.batch.indices import Declared
from pvphong.batch.listing import Piece
from pvphong.batch.receipts import Receipt
from pvphong.batch.seams import Border, Neighbours, border_of, with_normals, without_ghosts
from pvphong.meshes.blocks import check_names, material_of
from pvphong.meshes.files import read_mesh, save_lit
from pvphong.meshes.lit import shade_mesh
from pvphong.meshes.surfaces import FeatureAngle, has_normals, surface
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene

_NORMALS = "_pvphong_normals"
_TYPES = {"f": "Float{}", "i": "Int{}", "u": "UInt{}", "b": "UInt{}"}
"""VTK's names of types in XML, by NumPy's kinds."""


@dataclass(frozen=True)
class Job:
    """How all pieces are lit.

    Attributes
    ----------
    scene : Scene
        With a viewer.
    materials : mapping
        By the names of blocks, "default" for those not named.
    feature_angle : float, "auto" or None
        As for `shade`.
    options : mapping
        More of `shade`'s.
    run : str
        Names the call.
    """

    scene: Scene
    materials: Mapping[str, Material]
    feature_angle: FeatureAngle
    options: dict[str, Any]
    run: str

    def refuse_wrong(self, labels: set[str]) -> None:
        """Raise ``ValueError`` for what no piece could be lit with: it is tried on a triangle."""
        check_names(self.materials, sorted(labels))
        albedo = self.options["albedo"]
        if albedo is not None and not isinstance(albedo, str):
            check.refuse("albedo", albedo, "the name of a point array that the files have")
        for material in self.materials.values():
            without = self.options | {"albedo": None}
            shade_mesh(pv.Triangle(), self.scene, material, feature_angle=self.feature_angle, **without)

    @property
    def checksum(self) -> str:
        """Of all that the colours depend on beside the mesh."""
        return receipts.checksum_of([self.scene, self.materials, self.feature_angle, self.options])


@dataclass(frozen=True)
class Outcome:
    """What came of a piece: its arrays, or the reason why there is no lit file."""

    is_new: bool = False
    arrays: tuple[Declared, ...] = ()
    reason: str = ""


def checksum_of_file(path: Path) -> str:
    """Of a file's contents.

    Raises
    ------
    ValueError
        If it is not there.
    """
    if not path.is_file():
        check.refuse("mesh", path, "a file that exists")
    return receipts.checksum(path)


def bounds_of(path: Path) -> tuple[tuple[float, ...], bool]:
    """x_min, …, z_max of a file's surface, and whether that has open edges."""
    outside = _surface(path)
    return tuple(outside.bounds), bool(outside.n_open_edges)


def standing(piece: Piece, job: Job, made_from: str) -> Outcome | None:
    """What came of a piece before, if it need not be lit again."""
    found = receipts.standing(piece.output, made_from, job.checksum)
    return None if found is None else Outcome(found.run == job.run, found.arrays)


def border_in(path: Path) -> Border:
    """What a piece's neighbours have to know of it."""
    mesh = _read(path)
    return border_of(without_ghosts(surface(mesh)), of_volume=mesh.GetMaxSpatialDimension() == 3)


def light(piece: Piece, job: Job, neighbours: Neighbours | None = None, made_from: str = "") -> Outcome:
    """Light a piece and write it, unless it is done already.

    Parameters
    ----------
    piece : Piece
        Which one.
    job : Job
        How.
    neighbours : Neighbours, optional
        Faces of other pieces of its surface, for normals across them.
    made_from : str
        Checksum of all of that surface; the file's own if not given.
    """
    try:
        with threads.limited(1):
            return _light(piece, job, neighbours, made_from)
    except Exception as error:  # one file must not stop the others, whatever is wrong with it
        return Outcome(reason=reason_of(error))


def reason_of(error: BaseException) -> str:
    """One line."""
    said = " ".join(str(error).split())
    return said if isinstance(error, ValueError) else f"{type(error).__name__}: {said}".rstrip(": ")


def _light(piece: Piece, job: Job, neighbours: Neighbours | None, made_from: str) -> Outcome:
    made_from = made_from or checksum_of_file(piece.input)
    before = standing(piece, job, made_from)
    if before is not None:
        return before  # of an earlier run, or of a worker that was killed before it could tell
    lit = _lit(_surface(piece.input), piece, job, neighbours)
    save_lit(lit, piece.output, job.options["name"])
    arrays = _declared(lit)
    output = receipts.checksum(piece.output)
    receipts.write(Receipt(made_from, job.checksum, receipts.own_version(), job.run, output, arrays), piece.output)
    return Outcome(True, arrays)


def _surface(path: Path) -> pv.PolyData:
    return without_ghosts(surface(_read(path)))


def _read(path: Path) -> pv.DataSet:
    mesh = read_mesh(str(path))
    if isinstance(mesh, pv.MultiBlock):
        check.refuse("mesh", path, "a file with a single mesh", "Save its blocks as a .vtm file.")
    return mesh


def _lit(mesh: pv.PolyData, piece: Piece, job: Job, neighbours: Neighbours | None) -> pv.PolyData:
    material = material_of(piece.label, job.materials)
    angle = job.feature_angle
    has_own = has_normals(mesh) and angle in (None, "auto")
    if neighbours is None or has_own or len(neighbours.offsets) == 1:
        return shade_mesh(mesh, job.scene, material, feature_angle=angle, **job.options)
    mesh, normals = with_normals(mesh, neighbours, angle)
    mesh.point_data[_NORMALS] = normals
    mesh.point_data.active_normals_name = _NORMALS
    lit = shade_mesh(mesh, job.scene, material, **job.options)
    del lit.point_data[_NORMALS]
    return lit


def _declared(lit: pv.PolyData) -> tuple[Declared, ...]:
    """The numeric arrays of a mesh; its points come last."""
    named = [
        *(("PointData", name, lit.point_data[name]) for name in lit.point_data),
        *(("CellData", name, lit.cell_data[name]) for name in lit.cell_data),
        ("Points", "Points", lit.points),
    ]
    return tuple(
        Declared(place, _TYPES[array.dtype.kind].format(8 * array.itemsize), name, array[:1].size)
        for place, name, array in named
        if array.dtype.kind in _TYPES
    )
