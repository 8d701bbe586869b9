"""Tasks of a worker: inspect a piece, or light it and write a receipt. A later run skips pieces with a valid receipt.

Each of a worker's threads lights one piece at a time. The evaluator starts no threads of its own.
"""

from __future__ import annotations

import hashlib
import json
import os
from abc import ABC, abstractmethod
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pyvista as pv

from pvphong.base import check, threads
from pvphong.base.files import write_json
from pvphong.batch.culling import Outline, outline_of
from pvphong.batch.pieces import ArrayType, Piece
from pvphong.batch.seams import NORMALS, Border, Neighbours, border_of, has_only_ghosts, with_normals, without_ghosts
from pvphong.meshes.cells import refuse_invalid
from pvphong.meshes.files import Compression, read_mesh, save_lit
from pvphong.meshes.surfaces import FeatureAngle, has_normals, outer_surface, surface

_TYPES = {"f": "Float{}", "i": "Int{}", "u": "UInt{}", "b": "UInt{}"}
"""Names of types in VTK's XML files, by NumPy's kind; {} stands for the number of bits."""


@dataclass(frozen=True)
class Job(ABC):
    """Work on all pieces, with its settings.

    Attributes
    ----------
    feature_angle : float, "auto" or None
        As for `shade`.
    name : str
        Name of the point array that is active in the output files.
    run : str
        Identifier of the call that does the work.
    compress : {"lz4", "zlib", "none"}
        Compression of arrays in the output files.
    """

    feature_angle: FeatureAngle
    name: str
    run: str
    compress: Compression

    @property
    @abstractmethod
    def checksum(self) -> str:
        """Checksum of all settings on which an output file depends."""

    @property
    @abstractmethod
    def needs_rays(self) -> bool:
        """True if a piece depends on all other pieces of its surface, which may block its light."""

    @abstractmethod
    def lit(self, mesh: pv.PolyData, piece: Piece, feature_angle: FeatureAngle, around: Any) -> pv.PolyData:
        """Return a piece with its results as arrays.

        Parameters
        ----------
        mesh : pyvista.PolyData
            The surface of the piece, with the point normals to use, if `feature_angle` is None.
        piece : Piece
            The piece.
        feature_angle : float, "auto" or None
            As for `shade`.
        around : object
            The triangles of the other pieces that may block light, as the run gives them; None without others.
        """


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


def border_in(piece: Piece) -> Border:
    """Read a piece, and return the faces at its border. Neighbouring pieces need these faces for their normals."""
    outside, of_volume = surface_of(piece)
    return border_of(outside, of_volume=of_volume)


def outline_in(piece: Piece) -> Outline:
    """Read a piece, and return its outline. The outlines tell which pieces may block each other's light."""
    outside, _ = surface_of(piece)
    return outline_of(outside)


def light(
    piece: Piece,
    job: Job,
    neighbours: Neighbours | None = None,
    around: Any = None,
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
    around : object, optional
        What the job gets to know of the triangles of the other pieces of the same surface.
    made_from : str
        Checksum of all pieces of the surface; by default the checksum of the piece's file.
    """
    try:
        made_from = made_from or _checksum_of_input(piece)
        receipt = valid_receipt(piece, job)
        if receipt is None or receipt.input != made_from:
            with threads.limited(1):
                lit = _lit(piece, job, neighbours, around)
                save_lit(lit, piece.output, job.name, job.compress)
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


def surface_of(piece: Piece) -> tuple[pv.PolyData, bool]:
    """Read a piece's file; return its surface without ghost cells, and True if the file holds a volume.

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


def _lit(piece: Piece, job: Job, neighbours: Neighbours | None, around: Any) -> pv.PolyData:
    mesh, _ = surface_of(piece)
    if not mesh.n_points:
        return mesh
    has_own = has_normals(mesh) and job.feature_angle in (None, "auto")
    if neighbours is None or has_own or len(neighbours.offsets) == 1:
        return job.lit(mesh, piece, job.feature_angle, around)
    lit = job.lit(with_normals(mesh, neighbours, job.feature_angle), piece, None, around)
    del lit.point_data[NORMALS]
    return lit


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
