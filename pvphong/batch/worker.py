"""Tasks of a worker: inspect a piece, or light it and write a receipt. A later run skips pieces with a valid receipt.

Each of a worker's threads lights one piece at a time. The evaluator starts no threads of its own.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pyvista as pv

from pvphong.base import check, threads
from pvphong.base.files import write_json
from pvphong.batch.culling import Outline, PotentialOccluders, outline_of
from pvphong.batch.pieces import ArrayType, Piece
from pvphong.batch.seams import NORMALS, Border, Neighbours, border_of, has_only_ghosts, with_normals, without_ghosts
from pvphong.meshes.blocks import DEFAULT, materials_of
from pvphong.meshes.cells import refuse_invalid
from pvphong.meshes.colormaps import Span, spans_in
from pvphong.meshes.files import Compression, read_mesh, save_lit
from pvphong.meshes.lit import shade_mesh
from pvphong.meshes.point_data import given_maps
from pvphong.meshes.surfaces import FeatureAngle, has_normals, outer_surface, surface
from pvphong.meshes.visibility import KnownOccluders, world_faces
from pvphong.optics.colormap import Colormap
from pvphong.optics.maps import Map, is_image_path, refuse_unnamed
from pvphong.optics.material import Material
from pvphong.rays.casting import Occluders
from pvphong.scene.scene import Scene

_TYPES = {"f": "Float{}", "i": "Int{}", "u": "UInt{}", "b": "UInt{}"}
"""Names of types in VTK's XML files, by NumPy's kind; {} stands for the number of bits."""


@dataclass(frozen=True)
class Job:
    """Settings that are common to all pieces.

    Attributes
    ----------
    scene : Scene
        Scene with a viewer.
    materials : dict
        Path of a block → material; the key "default" is for the other blocks.
    feature_angle : float, "auto" or None
        As for `shade`.
    options : dict
        Other options of `shade`.
    run : str
        Identifier of the call of `shade_files`.
    compress : {"lz4", "zlib", "none"}
        Compression of arrays in the lit files.
    """

    scene: Scene
    materials: dict[str, Material]
    feature_angle: FeatureAngle
    options: dict[str, Any]
    run: str
    compress: Compression = "lz4"

    def refuse_wrong(self, pieces: Sequence[Piece]) -> None:
        """Raise ``ValueError`` for settings with which the pieces cannot be lit. A triangle is lit as a test.

        Maps that are not names are refused. Blocks that refer to the same file must have the same material.
        """
        labels = sorted({label for piece in pieces for label in piece.labels})
        material_of = dict(zip(labels, materials_of(labels, self.materials), strict=True))
        for material in self.materials.values():
            for name, given in given_maps(material).items():
                if isinstance(given, Map):
                    check.refuse(name, given, "the name of a point array that the files have")
                refuse_unnamed(name, given)
            lit_alike = material.with_values(dict.fromkeys(material.maps, 0.5) | {"tangents": None})
            shade_mesh(pv.Triangle(), self.scene, lit_alike, feature_angle=self.feature_angle, **self.options)
        for piece in pieces:
            first, *others = piece.labels
            for other in others:
                if material_of[other] != material_of[first]:
                    got = f"different materials for {first!r} and {other!r}, which both refer to {piece.input}"
                    remedy = "Copy the file, and let one block refer to the copy."
                    check.refuse("material", got, "the same for blocks that refer to the same file", remedy)

    @property
    def checksum(self) -> str:
        """Checksum of all settings on which a lit file depends: scene, materials with their images, and options."""
        maps = [given for material in self.materials.values() for given in material.maps.values()]
        images = [Path(str(given)) for given in maps if is_image_path(given)]
        contents = [checksum_of_file(image) for image in images if image.is_file()]
        return checksum_of([self.scene, self.materials, self.feature_angle, self.options, self.compress, *contents])


def checksum_of(value: Any) -> str:
    """Return the SHA-256 of a value that consists of plain values and dataclasses.

    The names of the dataclasses are part of the checksum.
    """

    def plain(other: Any) -> Any:
        if is_dataclass(other):
            return [type(other).__name__, {field.name: getattr(other, field.name) for field in fields(other)}]
        return repr(other)

    return hashlib.sha256(json.dumps(value, default=plain, sort_keys=True).encode()).hexdigest()


# --- receipts ---


@dataclass(frozen=True)
class Receipt:
    """Record of the inputs from which a lit file was made, stored in a small file next to it.

    Attributes
    ----------
    input : str
        Checksum of the input file, or of all pieces of its surface if the piece depends on them.
    lighting : str
        Checksum of the scene, the materials and the options.
    version : str
        Version of pvphong.
    run : str
        Identifier of the call of `shade_files` that made the lit file.
    output : str
        Checksum of the lit file.
    arrays : tuple of ArrayType
        Arrays of the lit file, as an index file declares them.
    """

    input: str
    lighting: str
    version: str
    run: str
    output: str
    arrays: tuple[ArrayType, ...]


def receipt_path(output: Path) -> Path:
    """Return the path of a lit file's receipt."""
    return output.with_name(f".{output.name}.json")


def valid_receipt(piece: Piece, job: Job) -> Receipt | None:
    """Return the receipt of a piece's lit file; None if it is missing or no longer valid.

    A receipt is valid if three conditions hold: the lit file has not changed since the receipt was written; it was lit
    by this version of pvphong; and it was lit with the settings of `job`.
    """
    with suppress(OSError, ValueError, TypeError):
        found = json.loads(receipt_path(piece.output).read_text(encoding="utf-8"))
        receipt = Receipt(**found | {"arrays": tuple(ArrayType(*array) for array in found["arrays"])})
        is_for_this = (receipt.lighting, receipt.version) == (job.checksum, version("pvphong"))
        if is_for_this and receipt.output == checksum_of_file(piece.output):
            return receipt
    return None


def checksum_of_file(path: Path) -> str:
    """Return the SHA-256 of a file's contents."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


# --- tasks ---


@dataclass(frozen=True)
class Result:
    """Result for a piece or an index file.

    Attributes
    ----------
    is_new : bool
        True if the output file was written by this call.
    arrays : tuple of ArrayType
        Arrays of the output file, if it is a lit file.
    reason : str
        Reason for a failure; "" if there was none.
    """

    is_new: bool = False
    arrays: tuple[ArrayType, ...] = ()
    reason: str = ""


def look(piece: Piece, job: Job) -> tuple[str, Receipt | None]:
    """Return the checksum of a piece's input file, and the receipt of its lit file, or None without a valid receipt."""
    return _checksum_of_input(piece), valid_receipt(piece, job)


def bounds_of(piece: Piece) -> tuple[tuple[float, ...], bool]:
    """Return the bounds of a piece's surface, and True if the surface has open edges.

    The bounds are x_min, x_max, y_min, y_max, z_min, z_max. They are NaN if the piece has no points.
    """
    outside, _ = _surface(piece)
    if not outside.n_points:
        return (math.nan,) * 6, False
    return tuple(outside.bounds), bool(outside.n_open_edges)


def spans_of(piece: Piece, colormaps: Sequence[Colormap]) -> list[Span]:
    """Return the range of each colormap's array in a piece, in the order of `colormaps`."""
    mesh = read_mesh(str(piece.input))
    return [spans_in(colormap, [mesh] if isinstance(mesh, pv.DataSet) else []) for colormap in colormaps]


def border_in(piece: Piece) -> Border:
    """Read a piece, and return the faces at its border. Neighbouring pieces need these faces for their normals."""
    outside, of_volume = _surface(piece)
    return border_of(outside, of_volume=of_volume)


def outline_in(piece: Piece) -> Outline:
    """Read a piece, and return its outline. Outlines serve to find pieces that may block each other's light."""
    outside, _ = _surface(piece)
    return outline_of(outside)


def light(
    piece: Piece,
    job: Job,
    neighbours: Neighbours | None = None,
    around: PotentialOccluders[Piece] | None = None,
    made_from: str = "",
) -> Result:
    """Light a piece and write its lit file.

    Nothing is done if a valid lit file exists, for example from a worker that was killed before it reported.

    Parameters
    ----------
    piece : Piece
        Piece to light.
    job : Job
        Settings that are common to all pieces.
    neighbours : Neighbours, optional
        Faces of other pieces of the same surface, for normals across seams.
    around : PotentialOccluders, optional
        Other pieces of the same surface that may block light of this piece.
    made_from : str
        Checksum of all pieces of the surface; by default the checksum of the piece's file.
    """
    try:
        made_from = made_from or _checksum_of_input(piece)
        receipt = valid_receipt(piece, job)
        if receipt is None or receipt.input != made_from:
            with threads.limited(1):
                lit = _lit(piece, job, neighbours, around)
                save_lit(lit, piece.output, job.options["name"], job.compress)
            output = checksum_of_file(piece.output)
            receipt = Receipt(made_from, job.checksum, version("pvphong"), job.run, output, _array_types(lit))
            write_json(vars(receipt), receipt_path(piece.output))
        return Result(receipt.run == job.run, receipt.arrays)
    except Exception as error:  # a bad file must not stop the others
        return Result(reason=reason_of(error))


def reason_of(error: BaseException) -> str:
    """Format an error in one line.

    For a ValueError, the line is the message. For any other error, it is the error's type, a colon and the message.
    """
    message = " ".join(str(error).split())
    return message if isinstance(error, ValueError) else f"{type(error).__name__}: {message}".rstrip(": ")


def _checksum_of_input(piece: Piece) -> str:
    if not os.path.isfile(piece.input):  # also False for a name that is too long
        check.refuse("mesh", piece.input, "a file that exists")
    return checksum_of_file(piece.input)


def _surface(piece: Piece) -> tuple[pv.PolyData, bool]:
    """Read a piece's file; return its surface without ghost cells, and True if the file contains a volume.

    A file without points, or with ghost cells only, gives an empty surface. Parallel simulations write such a file for
    a process that has no cells.
    """
    mesh = read_mesh(str(piece.input))
    if isinstance(mesh, pv.MultiBlock):
        check.refuse("mesh", piece.input, "a file with a single mesh", "Save the blocks as a .vtm file.")
    if mesh.n_points and not has_only_ghosts(mesh):
        outside = surface(mesh)
    else:
        refuse_invalid(mesh)
        outside = outer_surface(mesh)
    return without_ghosts(outside), mesh.GetMaxSpatialDimension() == 3


def _lit(
    piece: Piece, job: Job, neighbours: Neighbours | None, around: PotentialOccluders[Piece] | None
) -> pv.PolyData:
    mesh, _ = _surface(piece)
    if not mesh.n_points:
        return mesh
    material, angle = job.materials.get(piece.labels[0]) or job.materials[DEFAULT], job.feature_angle
    options = job.options if around is None else job.options | {"occluders": _occluders(mesh, job.scene, around)}
    has_own = has_normals(mesh) and angle in (None, "auto")
    if neighbours is None or has_own or len(neighbours.offsets) == 1:
        return shade_mesh(mesh, job.scene, material, feature_angle=angle, **options)
    lit = shade_mesh(with_normals(mesh, neighbours, angle), job.scene, material, **options)
    del lit.point_data[NORMALS]
    return lit


def _occluders(mesh: pv.PolyData, scene: Scene, around: PotentialOccluders[Piece]) -> KnownOccluders:
    """Return the triangles that may block the light of a piece: its own, and those of the other pieces in `around`.

    `mesh` is the piece's surface, and `scene` has the lights. The files of the other pieces are read one after the
    other.
    """
    others = (around.blocking(scene, world_faces(_surface(piece)[0])) for piece in around.blockers)
    parts = [world_faces(mesh), *others]
    return KnownOccluders(Occluders(parts, around.within), 0 if len(parts[0]) else None, around.first)


def _array_types(lit: pv.PolyData) -> tuple[ArrayType, ...]:
    """Describe the numeric arrays of a lit mesh, followed by its points; return () for a mesh without points."""
    if not lit.n_points:
        return ()
    named = [
        *(("PointData", name, lit.point_data[name]) for name in lit.point_data),
        *(("CellData", name, lit.cell_data[name]) for name in lit.cell_data),
        ("Points", "Points", lit.points),
    ]
    return tuple(
        ArrayType(place, _TYPES[array.dtype.kind].format(8 * array.itemsize), name, array[:1].size)
        for place, name, array in named
        if array.dtype.kind in _TYPES
    )
