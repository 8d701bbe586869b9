"""`pvphong.shade_files`: light many files by many processes."""

from __future__ import annotations

import math
import os
import uuid
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.text import about
from pvphong.base.types import Backend, Precision
from pvphong.batch.cluster import connected
from pvphong.batch.culling import Outline, PotentialOccluders, potential_occluders
from pvphong.batch.pieces import Piece, Seams, paths_of, pieces_and_indices
from pvphong.batch.run import Batch, Run, found_anywhere, output_folders
from pvphong.batch.worker import Job, checksum_of, checksum_of_file, surface_of
from pvphong.meshes.blocks import DEFAULT, materials_of
from pvphong.meshes.colormaps import Span, joined, spanned, spans_in, unspanned
from pvphong.meshes.default_scene import default_scene_of
from pvphong.meshes.files import Compression, read_mesh
from pvphong.meshes.lit import shade_mesh
from pvphong.meshes.point_data import given_maps
from pvphong.meshes.surfaces import FeatureAngle
from pvphong.meshes.visibility import KnownOccluders, world_faces
from pvphong.optics.colormap import Colormap
from pvphong.optics.maps import Map, is_image_path, refuse_unnamed
from pvphong.optics.material import DEFAULT_MATERIAL, Material, as_material
from pvphong.rays.casting import Occluders
from pvphong.scene.options import known_options
from pvphong.scene.scene import Scene, SceneLike, as_scene

if TYPE_CHECKING:
    from distributed import Client

_APART = 'Each file was lit separately; seams="merge" treats them as pieces of one surface.'


@known_options
def shade_files(
    paths: Any,
    out: str | os.PathLike[str],
    scene: SceneLike | None = None,
    material: Material | str | Mapping[str, Material | str] = DEFAULT_MATERIAL,
    *,
    client: Client | str | None = None,
    workers: int | None = None,
    seams: Seams | None = None,
    name: str = "phong",
    components: bool = False,
    tolerance: float = 0.0,
    precision: Precision = "float32",
    backend: Backend = "auto",
    feature_angle: FeatureAngle = None,
    compress: Compression = "lz4",
) -> Batch:
    """Light many files in many processes. For each, a .vtp file of the same name is written, with the lit colours.

    A lit file is written atomically. A receipt next to it, ``.NAME.vtp.json``, holds checksums of the input and of
    scene, material and options, and pvphong's version. A file with a matching receipt is skipped, so an interrupted
    call can be repeated. If a worker is killed, Dask gives its tasks to others.

    Index files (.vtm, .pvtp, .pvtu, and .pvd, which may name any of these) name other files, the pieces. The pieces are
    lit one by one, and a new index file names the lit files; for a .pvtu it is a .pvtp, because lit meshes are
    surfaces. Ghost cells are left out. A file without points, or with ghost cells only, gives an empty lit
    file.

    Parameters
    ----------
    paths : str, path, or sequence of them
        Files of any format that PyVista reads, index files, or patterns such as `parts/*.vtp`. A mesh file holds one
        mesh. Files inside `out` that match a pattern are skipped, as results of an earlier call.
    out : path
        Folder, created if missing. Workers on other machines must see it, and the input files, under the same paths.
    scene : Scene, light, or sequence of lights, optional
        As for `mesh.phong.shade`, common to all files. If there is no viewer, PyVista's default camera frames all files
        together; for its bounds, all files are read once more. Pieces of one surface shadow each other, so a worker
        also reads the pieces that may block the light of its own piece. These are all pieces if light comes from all
        sides, or with unlimited ambient occlusion. Separate meshes shadow only themselves. Bounces are refused for
        pieces of one surface.
    material : Material or mapping, optional
        Material, or a mapping from the names of a .vtm file's blocks to materials, with the key "default" for the other
        blocks. Maps are names of point arrays of the files, colormaps of such names, or paths of image files. A
        colormap without `clim` gets the range of its array in all files; to find it, all files are read once more.
    client : distributed.Client or str, optional
        Client of a Dask cluster, or the address of its scheduler, such as ``tcp://host:8786``. By default a local
        cluster is started; a script must then call this function below ``if __name__ == "__main__":``.
    workers : int, optional
        Number of processes of the local cluster, with one thread each; by default the number of processors.
    seams : {"merge", "keep"}, optional
        With "merge", points of several pieces with equal coordinates get the normal of the whole surface, if normals
        are computed from faces. With "keep", each piece has its own normals. By default "merge" for the pieces of one
        index file at one time step, and "keep" for separate files. Coordinates must be equal to the bit; if several
        points of a piece are equal, only the first is merged.
    name, components, tolerance, precision, backend, feature_angle
        As for `mesh.phong.shade`. Each piece has its own plan, within the tolerance. Sharp edges are also found across
        merged seams.
    compress : {"lz4", "zlib", "none"}, default "lz4"
        Compression of arrays in the lit files: zlib takes about half the space of LZ4, and ten times as long to write.

    Returns
    -------
    Batch
        `.done`, `.skipped`, and `.failed`: path → reason.

    Raises
    ------
    ValueError
        If an argument is invalid, for example if no file is named, two files have the same output, the folder is not
        writable, the scheduler does not answer, or workers have other versions of packages. Nothing is written then. An
        error in a single file is not raised, but recorded in `.failed`; the other files are lit.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> from distributed import Client
    >>> import pyvista as pv, pvphong as ph
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> pv.Sphere().save(folder / "ball.vtp")
    >>> with Client(processes=False, dashboard_address=None) as client:
    ...     batch = ph.shade_files(folder / "*.vtp", folder / "lit", client=client)
    >>> [path.name for path in batch.done]
    ['ball.vtp']
    """
    if seams is not None:
        check.choice("seams", seams, get_args(Seams))
    given = None if scene is None else as_scene(scene)
    check.choice("compress", compress, get_args(Compression))
    given_materials = material if isinstance(material, Mapping) else {DEFAULT: material}
    materials = {label: as_material(each) for label, each in given_materials.items()}
    options = {
        "components": components,
        "tolerance": tolerance,
        "precision": precision,
        "backend": backend,
    }
    job = ShadingJob(feature_angle, name, uuid.uuid4().hex, compress, given or Scene(), materials, options)
    folder = Path(out)
    pieces, indices = pieces_and_indices(paths_of(paths, folder), folder, as_one=seams == "merge")
    job.refuse_wrong(pieces)
    several = [name for name, count in Counter(piece.surface for piece in pieces).items() if name and count > 1]
    if several and job.scene.light_model.bounces:  # for each bounce, light would travel between all pieces
        remedy = "Use LightModel(bounces=0), or join the pieces: pyvista.read(path)."
        got = f"bounces for the pieces of {several[0].rpartition('@')[0] or several[0]}"
        check.refuse("light_model", got, "without bounces for a surface in several pieces", remedy)
    with connected(client, workers, len(pieces)) as workforce, output_folders(folder, pieces, indices), about("files"):
        run = _ShadingRun(workforce, job, pieces, indices)
        if given is None or given.viewer is None:
            run.frame(given)
        run.span()
        run.light(merges=seams != "keep")
        run.write_indices()
    are_apart = sum(not piece.surface for piece in pieces) > 1
    return run.batch(note=_APART if are_apart and seams is None else "")


class _ShadingRun(Run):
    """State of one call of `shade_files`."""

    _job: ShadingJob

    def frame(self, given: Scene | None) -> None:
        """Give the job a scene with a viewer that frames all pieces.

        The scene is `given` with that viewer added. If `given` is None, it is the default scene.
        """
        low, high, is_open = np.full(3, np.nan), np.full(3, np.nan), False
        for _, (bounds, has_edges) in self._each(bounds_of, self._pieces):
            low, high = np.fmin(low, bounds[::2]), np.fmax(high, bounds[1::2])
            is_open = is_open or has_edges
        box = np.column_stack([low, high]).ravel()
        scene = default_scene_of(box, is_open=is_open) if given is None else given.framed(box)
        self._job = replace(self._job, scene=scene)

    def span(self) -> None:
        """Give a range to each colormap that has none.

        The range is from the least to the greatest number of the colormap's array in all pieces.
        """
        fields = [(label, name) for label, each in self._job.materials.items() for name in unspanned(each)]
        if not fields:
            return
        colormaps = [unspanned(self._job.materials[label])[name] for label, name in fields]
        of_pieces = [spans for _, spans in self._each(spans_of, self._left(self._pieces), colormaps)]
        materials = dict(self._job.materials)
        for (label, name), spans in zip(fields, zip(*of_pieces, strict=True), strict=False):
            materials[label] = spanned(materials[label], {name: joined(spans)})
        self._job = replace(self._job, materials=materials)

    def _around(self, pieces: Sequence[Piece], outlines: Sequence[Outline]) -> Iterator[PotentialOccluders[Piece]]:
        """Return, for each piece, the other pieces that may block its light."""
        return potential_occluders(self._job.scene, [*map(found_anywhere, pieces)], outlines)


@dataclass(frozen=True)
class ShadingJob(Job):
    """Shading of all pieces in one scene.

    Attributes
    ----------
    scene : Scene
        Scene with a viewer.
    materials : dict
        Path of a block → material; the key "default" is for the other blocks.
    options : dict
        Other options of `shade`.
    """

    scene: Scene
    materials: dict[str, Material]
    options: dict[str, Any]

    def refuse_wrong(self, pieces: Sequence[Piece]) -> None:
        """Raise ``ValueError`` for settings with which pieces cannot be lit. The settings are tried on a triangle.

        Also refused are maps that are not names, and different materials for blocks that refer to the same file.
        """
        labels = sorted({label for piece in pieces for label in piece.labels})
        material_of = dict(zip(labels, materials_of(labels, self.materials), strict=True))
        for material in self.materials.values():
            for name, given in given_maps(material).items():
                if isinstance(given, Map):
                    check.refuse(name, given, "the name of a point array that the files have")
                refuse_unnamed(name, given)
            lit_alike = material.with_values(dict.fromkeys(material.maps, 0.5) | {"tangents": None})
            shade_mesh(pv.Triangle(), self.scene, lit_alike, feature_angle=self.feature_angle, **self._options)
        for piece in pieces:
            first, *others = piece.labels
            for other in others:
                if material_of[other] != material_of[first]:
                    got = f"different materials for {first!r} and {other!r}, which both refer to {piece.input}"
                    remedy = "Copy the file, and let one block refer to the copy."
                    check.refuse("material", got, "the same for blocks that refer to the same file", remedy)

    @property
    def _options(self) -> dict[str, Any]:
        return {"name": self.name, **self.options}

    @property
    def checksum(self) -> str:
        """Checksum of all settings on which a lit file depends: scene, materials with their images, and options."""
        maps = [given for material in self.materials.values() for given in material.maps.values()]
        images = [Path(str(given)) for given in maps if is_image_path(given)]
        contents = [checksum_of_file(image) for image in images if image.is_file()]
        return checksum_of([self.scene, self.materials, self.feature_angle, self._options, self.compress, *contents])

    @property
    def needs_rays(self) -> bool:
        """True if pieces may shadow each other, or hide the sky."""
        return self.scene.light_model.needs_rays

    def lit(self, mesh: pv.PolyData, piece: Piece, feature_angle: FeatureAngle, around: Any) -> pv.PolyData:
        """Return a piece with its lit colours; `around` is a `PotentialOccluders` or None."""
        material = self.materials.get(piece.labels[0]) or self.materials[DEFAULT]
        options = self._options
        if around is not None:
            options["occluders"] = _occluders(mesh, self.scene, around)
        return shade_mesh(mesh, self.scene, material, feature_angle=feature_angle, **options)


# --- tasks ---


def bounds_of(piece: Piece) -> tuple[tuple[float, ...], bool]:
    """Return the bounds x_min, x_max, …, z_max of a piece's surface, and True if it has open edges.

    The bounds are NaN if the piece has no points.
    """
    outside, _ = surface_of(piece)
    if not outside.n_points:
        return (math.nan,) * 6, False
    return tuple(outside.bounds), bool(outside.n_open_edges)


def spans_of(piece: Piece, colormaps: Sequence[Colormap]) -> list[Span]:
    """Return, for each colormap, the range of the colormap's array in a piece."""
    mesh = read_mesh(str(piece.input))
    return [spans_in(colormap, [mesh] if isinstance(mesh, pv.DataSet) else []) for colormap in colormaps]


def _occluders(mesh: pv.PolyData, scene: Scene, around: PotentialOccluders[Piece]) -> KnownOccluders:
    """Return the triangles that may block the light of a piece: its own, and those of the other pieces in `around`.

    `mesh` is the piece's surface, and `scene` has the lights. The files of the other pieces are read one after the
    other.
    """
    others = (around.blocking(scene, world_faces(surface_of(piece)[0])) for piece in around.blockers)
    parts = [world_faces(mesh), *others]
    return KnownOccluders(Occluders(parts, around.within), 0 if len(parts[0]) else None, around.first)
