"""`pvphong.daylight_files`: light of the sun and the sky on a city in many files, by many processes."""

from __future__ import annotations

import os
import threading
import uuid
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import repeat
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.text import about
from pvphong.base.types import Float64Array
from pvphong.batch.cluster import connected
from pvphong.batch.culling import Outline
from pvphong.batch.pieces import Piece, Seams, paths_of, pieces_and_indices
from pvphong.batch.run import Batch, Run, output_folders
from pvphong.batch.worker import Job, checksum_of, surface_of
from pvphong.geometry.extent import Box
from pvphong.meshes.daylight import MEMORY, PatchCount, refuse_too_large, warn_of_degrees
from pvphong.meshes.files import Compression
from pvphong.meshes.sky_study import SkyStudy
from pvphong.meshes.surfaces import FeatureAngle, point_normals, split_sharp_edges
from pvphong.meshes.visibility import receiver_of, world_faces
from pvphong.optics.area.patches import Patches
from pvphong.rays.casting import BlockingFaces, Occluders
from pvphong.rays.daylight import SkyTracer, Sources, received
from pvphong.scene.daylight import ALBEDO
from pvphong.scene.sun import Place
from pvphong.scene.weather import irradiances

if TYPE_CHECKING:
    from distributed import Client


def daylight_files(
    paths: Any,
    out: str | os.PathLike[str],
    times: Any,
    place: Place,
    weather: Any = None,
    *,
    albedo: float = ALBEDO,
    bounces: int = 0,
    patches: PatchCount = 145,
    samples: int = 4,
    sun_bin: float = 1.0,
    feature_angle: FeatureAngle = None,
    memory: float = MEMORY,
    client: Client | str | None = None,
    workers: int | None = None,
    seams: Seams | None = None,
    compress: Compression = "lz4",
) -> Batch:
    """Compute the light of sun and sky on a city in many files, in many processes.

    All files together are one city: each shadows all others and hides the sky from them. For each file, a .vtp file of
    the same name is written, with the point arrays ``sun_hours``, ``direct``, ``diffuse``, ``reflected`` and ``total``,
    which are those of `mesh.phong.daylight`. The weather is evaluated once, for all files.

    Files, receipts and index files are written as by `shade_files`: a finished file is complete, an interrupted call
    can be repeated, and nothing is lost if a worker is killed. Files that are finished are computed again if any file
    of the city has changed.

    Parameters
    ----------
    paths : str, path, or sequence of them
        Files, index files or patterns, as for `shade_files`. Each time step of a .pvd file is a city of its own.
    out : path
        Folder, created if missing. Workers on other machines must see it, and the input files, under the same paths.
    times, place, weather, albedo, patches, samples, sun_bin, feature_angle
        As for `mesh.phong.daylight`.
    bounces : int, default 0
        Only 0: light does not bounce between files. `reflected` is the light of the open ground around the city.
    memory : float, default 2e9
        Memory limit in bytes for the coefficients of one file. In addition, each worker keeps the triangles of all
        files, about 250 bytes for each triangle.
    client, workers
        As for `shade_files`.
    seams : {"merge", "keep"}, optional
        Normals of points of several files with equal coordinates, as for `shade_files`. By default "merge" if `paths`
        has an index file, and "keep" for separate files, such as buildings.
    compress : {"lz4", "zlib", "none"}, default "lz4"
        As for `shade_files`.

    Returns
    -------
    Batch
        `.done`, `.skipped`, and `.failed`: path → reason. A file that cannot be read shadows no other file.

    Raises
    ------
    ValueError
        If an argument is invalid, weather has gaps, pvlib (the extra `sun`) is not installed, or for the reasons of
        `shade_files`. Nothing is written then. An error in a single file is not raised, but recorded in `.failed`.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> from distributed import Client
    >>> import pandas as pd, pyvista as pv, pvphong as ph
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> pv.Plane(i_size=40, j_size=40, i_resolution=20, j_resolution=20).save(folder / "ground.vtp")
    >>> pv.Cube(center=(0, 0, 5), x_length=10, y_length=10, z_length=10).save(folder / "house.vtp")
    >>> day = pd.date_range("2026-06-21T00:30", periods=24, freq="h", tz="Europe/Berlin")
    >>> with Client(processes=False, dashboard_address=None) as client:
    ...     batch = ph.daylight_files(folder / "*.vtp", folder / "sun", day, ph.Place(48.14, 11.58), client=client)
    >>> float(pv.read(folder / "sun" / "ground.vtp")["sun_hours"].max())
    16.0
    """
    if seams is not None:
        check.choice("seams", seams, get_args(Seams))
    check.choice("compress", compress, get_args(Compression))
    if check.whole("bounces", bounces, at_least=0):
        remedy = "Join the files to one mesh for mesh.phong.daylight(times, place, bounces=...)."
        check.refuse("bounces", bounces, "0 for files, because light does not bounce between them", remedy)
    study = SkyStudy.of(times, place, albedo=albedo, patches=patches, samples=samples, sun_bin=sun_bin)
    memory = check.number("memory", memory, at_least=0.0)
    split_sharp_edges(pv.Triangle(), feature_angle)  # refuses an invalid angle
    folder = Path(out)
    pieces, indices = pieces_and_indices(paths_of(paths, folder), folder, as_one=True)
    sources = study.sources(irradiances(weather, study.moments.index, study.place))
    rays = place.axes, study.patches.finer, study.samples, study.moments.bins.directions
    job = DaylightJob(feature_angle, "total", uuid.uuid4().hex, compress, *rays, sources, memory)
    with connected(client, workers, len(pieces)) as workforce, output_folders(folder, pieces, indices), about("files"):
        run = _DaylightRun(workforce, job, pieces, indices)
        run.place = place
        run.light(merges=bool(indices) if seams is None else seams == "merge")
        run.write_indices()
    return run.batch(note="")


class _DaylightRun(Run):
    """State of one call of `daylight_files`."""

    place: Place

    def _around(self, pieces: Sequence[Piece], outlines: Sequence[Outline]) -> Iterable[Any]:
        """Return the task that collects the triangles of all pieces. Its value is sent once to each worker."""
        if boxes := [outline.points for outline in outlines if outline.count and outline.points is not None]:
            warn_of_degrees(_around(boxes), self.place, stacklevel=5)
        within = _around([outline.faces for outline in outlines if outline.faces is not None] or [_NOWHERE])
        faces = [task for _, task in self._each(faces_in, pieces, fetches=False)]
        return repeat(self._client.submit(city_of, faces, within, pure=False), len(pieces))


_NOWHERE = np.zeros(3), np.zeros(3)


def _around(boxes: Sequence[Box]) -> Box:
    """Return the box around some boxes."""
    lows, highs = zip(*boxes, strict=True)
    return np.min(lows, axis=0), np.max(highs, axis=0)


# --- tasks ---

_BUILDING = threading.Lock()
"""Held while the casters of a city are built, which the threads of a worker share."""


def faces_in(piece: Piece) -> BlockingFaces:
    """Read a piece, and return its triangles."""
    return world_faces(surface_of(piece)[0])


def city_of(faces: Sequence[BlockingFaces], within: Box) -> Occluders:
    """Return the triangles of all pieces as occluders. `within` is the box around them."""
    return Occluders(faces, within)


@dataclass(frozen=True)
class DaylightJob(Job):
    """Daylight on all pieces.

    Attributes
    ----------
    axes : ndarray
        Unit vectors to the east, to the north and up, as rows.
    finer : int
        Number of parts of the sides of Tregenza's patches.
    samples : int
        Number of rays to each patch.
    to_sun : ndarray
        Unit vectors to the positions of the sun to which rays are cast, shape (b, 3).
    sources : Sources
        What the sun, the sky and the ground send.
    memory : float
        Memory limit in bytes for the coefficients of a piece.
    """

    axes: Float64Array
    finer: int
    samples: int
    to_sun: Float64Array
    sources: Sources
    memory: float

    @property
    def checksum(self) -> str:
        """Checksum of the weather, the rays and the options."""
        arrays = [np.asarray(each).tobytes().hex() for each in (self.axes, self.to_sun, *self.sources)]
        return checksum_of(["daylight", self.feature_angle, self.compress, self.finer, self.samples, arrays])

    @property
    def needs_rays(self) -> bool:
        """True: each piece may hide the sky from each other."""
        return True

    def lit(
        self,
        mesh: pv.PolyData,
        piece: Piece,  # noqa: ARG002 as of the base class
        feature_angle: FeatureAngle,
        around: Occluders | None,
    ) -> pv.PolyData:
        """Return a piece with its light as arrays; `around` are the triangles of all pieces."""
        source, patches = split_sharp_edges(mesh, feature_angle)[0], Patches(self.finer)
        receiver = receiver_of(source, lambda: point_normals(source), None, 0)
        occluders = Occluders([receiver.faces]) if around is None else around
        with _BUILDING:
            occluders.casters, occluders.compiled  # noqa: B018
        tracer = SkyTracer(receiver, occluders, self.axes, patches, self.samples, self.to_sun)
        refuse_too_large(tracer, self.memory)
        found = received(tracer.cast(), receiver.unit_normals, self.axes, patches, self.sources)
        result = source.copy()
        for name in ("sun_hours", "direct", "diffuse"):
            result.point_data[name] = getattr(found, name)
        result.point_data["reflected"] = found.ground
        result.point_data["total"] = found.direct + found.diffuse + found.ground
        return result
