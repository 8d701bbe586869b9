"""`mesh.phong.daylight`: light of the sun and the sky on a mesh, summed over many times, for any weather.

In order: the function; `Daylight`, its result; files.
"""

from __future__ import annotations

import functools
import hashlib
import importlib
import json
import os
import time
import warnings
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple, Self

import numpy as np
import pyvista as pv

from pvphong.base import check, threads
from pvphong.base.files import written_aside
from pvphong.base.processes import available_memory
from pvphong.base.text import html_table
from pvphong.base.types import Float64Array, MatrixLike
from pvphong.geometry.extent import Box
from pvphong.meshes.colormaps import scale_of_light
from pvphong.meshes.sky_study import Moments, SkyStudy, microseconds
from pvphong.meshes.surfaces import FeatureAngle, point_normals, polygons, shallow_copy, split_sharp_edges, surface
from pvphong.meshes.transport import Exchanging, transport_of
from pvphong.meshes.visibility import KnownOccluders, checked_occluders, receiver_of
from pvphong.optics.area.patches import Patches
from pvphong.rays.casting import Occluders, warn_of_slow_rays
from pvphong.rays.daylight import Coefficients, Received, SkyTracer, SunBins, received
from pvphong.rays.transport import Transport
from pvphong.scene.daylight import ALBEDO
from pvphong.scene.sun import Irradiances, Place, sun_position
from pvphong.scene.weather import irradiances

PatchCount = Literal[145, 577]
Result = Literal["total", "sun_hours", "direct", "diffuse", "reflected"]

MEMORY = 2.0e9
"""Default memory limit of daylight coefficients in bytes."""

_WORTH_A_WARNING = 2**10  # vertices
_PROBED = 2**11  # vertices that are sampled to estimate the cost of all rays


def daylight(
    mesh: pv.DataSet,
    times: Any,
    place: Place,
    weather: Any = None,
    *,
    albedo: float = ALBEDO,
    bounces: int = 0,
    patches: PatchCount = 145,
    samples: int = 4,
    sun_bin: float = 1.0,
    occluders: Any = (),
    matrix: MatrixLike | None = None,
    feature_angle: FeatureAngle = None,
    memory: float = MEMORY,
) -> Daylight:
    """Compute the light of sun and sky on each vertex, summed over many times.

    Rays are cast once, when a result is first read: to all patches of the sky, to the ground, and to the sun at its
    positions. They give daylight coefficients. The light in any weather is a product with these: see `with_weather`. If
    nothing hides the sun or a patch, its light is exact for the given model of the sky.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface; it shadows itself. Its unit of length does not matter.
    times : datetime_like
        Moments in ascending order with a time zone, as for `sun_position`; NumPy's datetime64 is UTC. Each moment
        stands for a step of time, the least difference between moments, or one hour if there is only one moment. So
        the middles of hours suit hourly means. All differences must be multiples of the step.
    place : Place
        Place on the Earth, and the directions of its zenith and north in the mesh's coordinates.
    weather : path, pair of array_like, pandas.DataFrame or None, default None
        Irradiances in W/m²: the path of an EPW file: each moment gets the values of its hour in the file, whatever the
        year; a pair (direct_normal, diffuse_horizontal) of arrays, or a DataFrame with pvlib's columns dni and dhi,
        with one value for each moment; or None for a clear sky.
    albedo : float, default 0.2
        Fraction of the light that the open ground around the mesh reflects. With bounces, the mesh reflects the same
        fraction.
    bounces : int, default 0
        Number of diffuse reflections between the mesh's own surfaces.
    patches : {145, 577}, default 145
        Number of patches of the sky: Tregenza's 145, or Reinhart's 577.
    samples : int, default 4
        Rays to each patch of the sky, from 2 to 64.
    sun_bin : float, default 1
        Largest angle in degrees between the sun and the ray that is cast in its place, from 0 to 5. With 0, a ray is
        cast for each moment.
    occluders : sequence, optional
        Other meshes that block light, each as a mesh or a pair of a mesh and a 4x4 matrix. They do not reflect light.
    matrix : array_like, optional
        (4, 4) model matrix, as for `shade`.
    feature_angle : float, "auto" or None, default None
        As for `shade`.
    memory : float, default 2e9
        Memory limit in bytes for the coefficients, which take about 250 bytes per vertex for a year of hours.

    Returns
    -------
    Daylight
        `.sun_hours` in hours; `.direct`, `.diffuse`, `.reflected`, `.total` and `.standard_error` in Wh/m², shape (n,)
        each; `.mesh` with these arrays; `.with_weather(weather)`, `.expected_cost()`, `.save(path)`.

    Raises
    ------
    ValueError
        If an argument is invalid, weather has gaps, the coefficients exceed the memory limit, the mesh has nothing that
        can be lit, or pvlib (the extra `sun`) is not installed.

    References
    ----------
    P. Tregenza, I. Waters, "Daylight coefficients", Lighting Research & Technology 15 (1983), 65-71.

    Examples
    --------
    >>> import pandas as pd, pyvista as pv, pvphong as ph
    >>> day = pd.date_range("2026-06-21T00:30", periods=24, freq="h", tz="Europe/Berlin")
    >>> ground = pv.Plane(i_size=40, j_size=40, i_resolution=20, j_resolution=20)
    >>> house = pv.Cube(center=(0, 0, 5), x_length=10, y_length=10, z_length=10)
    >>> clear = ground.phong.daylight(day, ph.Place(48.14, 11.58), occluders=[house])
    >>> float(clear.sun_hours.max())
    16.0
    >>> gloomy = clear.with_weather(([0] * 24, [100] * 24))  # W/m², without new rays
    >>> round(float(gloomy.total.max()), -2)  # Wh/m²
    2400.0
    """
    source = split_sharp_edges(surface(mesh), feature_angle)[0].copy()  # rays are cast later; the mesh may change
    normals = functools.cache(lambda: point_normals(source))
    sky = SkyStudy.of(times, place, albedo=albedo, patches=patches, samples=samples, sun_bin=sun_bin)
    bounces = check.whole("bounces", bounces, at_least=0, at_most=100)
    memory = check.number("memory", memory, at_least=0.0)
    warn_of_degrees((source.points.min(axis=0), source.points.max(axis=0)), place, stacklevel=3)
    receiver, known = receiver_of(source, normals, matrix, 0), occluders
    if not isinstance(known, KnownOccluders):
        own = [receiver.faces] if receiver.part is not None else []
        known = KnownOccluders(Occluders([*own, *checked_occluders(occluders)]), receiver.part)
    receiver = replace(receiver, part=known.own_index)
    tracer = SkyTracer(receiver, known.occluders, place.axes, sky.patches, sky.samples, sky.moments.bins.directions)
    refuse_too_large(tracer, memory)
    among = transport_of([Exchanging(source, normals, matrix)], occluders) if bounces else None
    given = irradiances(weather, sky.moments.index, place)
    return Daylight(_Study(**vars(sky), source=source, bounces=bounces, cast=_Rays(tracer, among)), given)


def refuse_too_large(tracer: SkyTracer, memory: float) -> None:
    """Raise ValueError if the coefficients would exceed the limit or the free memory."""
    available, limit = available_memory(), memory
    if available is not None:
        limit = min(limit, float(available))
    if tracer.bytes_needed > limit:
        vertices, positions = len(tracer.receiver.points), len(tracer.to_sun)
        of = f"{vertices:,} vertices, {len(tracer.patches)} patches and {positions:,} positions of the sun"
        remedy = "Raise memory, or use 145 patches, a larger sun_bin, fewer times, or pieces of the mesh."
        check.refuse("memory", f"{limit:.3g} bytes", f"at least {tracer.bytes_needed:.3g} bytes for {of}", remedy)


def warn_of_degrees(box: Box, place: Place, stacklevel: int) -> None:
    """Warn if the coordinates of a mesh seem to be longitudes and latitudes.

    Parameters
    ----------
    box : (low, high)
        Least and greatest coordinates of the mesh.
    place : Place
        The place.
    stacklevel : int
        The frame to which the warning belongs, counted from the caller of this function, which is 1.
    """
    (low, high), where = box, np.array((place.longitude, place.latitude))
    if (
        (low[:2] <= where).all()
        and (where <= high[:2]).all()
        and 0.0 < (high - low)[:2].max() < 5.0 < np.abs(where).max()
    ):
        message = "The mesh's coordinates look like degrees of longitude and latitude. Project them to metres first."
        warnings.warn(message, UserWarning, stacklevel=stacklevel + 1)


# --- the result


@dataclass(frozen=True, eq=False)
class _Study(SkyStudy):
    """Everything about a study of daylight but the weather."""

    source: pv.PolyData
    bounces: int
    cast: _Rays


class DaylightCost(NamedTuple):
    """Cost of rays that are not cast yet."""

    rays: int
    seconds: float
    memory: int
    """Memory of the coefficients in bytes."""


class _Rays:
    """Coefficients that are computed when they are first used. Results for different weathers share them.

    Parameters
    ----------
    tracer : SkyTracer or None
        Object that casts the rays; None for coefficients from a file.
    transport : Transport or None
        Transport of bounced light.
    coefficients, normals : optional
        Coefficients, and the unit normals in the world, from a file.
    """

    def __init__(
        self,
        tracer: SkyTracer | None,
        transport: Transport | None,
        coefficients: Coefficients | None = None,
        normals: Float64Array | None = None,
    ) -> None:
        self.tracer, self.transport = tracer, transport
        self.kept, self._normals, self.seconds = coefficients, normals, 0.0

    @property
    def normals(self) -> Float64Array:
        """Unit normals in the world, shape (n, 3); 0 for a vertex without a normal."""
        if self._normals is None:
            assert self.tracer is not None
            return self.tracer.receiver.unit_normals
        return self._normals

    @property
    def coefficients(self) -> Coefficients:
        """The coefficients; an interrupted computation stores nothing."""
        if self.kept is None:
            assert self.tracer is not None
            start = time.perf_counter()
            if len(self.normals) >= _WORTH_A_WARNING and self.tracer.occluders.are_slow:
                warn_of_slow_rays()
            self.kept = self.tracer.cast()
            self.seconds = time.perf_counter() - start
        return self.kept


class Daylight:
    """Light of the sun and the sky on each vertex of a mesh, summed over many times.

    Made by `mesh.phong.daylight`. Rays are cast when a result is first read. Results for other weathers use the same
    rays. Each result has the shape (n,) and is for the points of `mesh`.

    Examples
    --------
    >>> import pandas as pd, pyvista as pv, pvphong as ph
    >>> day = pd.date_range("2026-06-21T00:30", periods=24, freq="h", tz="Europe/Berlin")
    >>> light = pv.Sphere().phong.daylight(day, ph.Place(48.14, 11.58))
    >>> light.mesh.array_names[-4:]
    ['direct', 'diffuse', 'reflected', 'total']
    >>> light.save("day.npz")
    >>> bool((ph.Daylight.load("day.npz").total == light.total).all())
    True
    """

    def __init__(self, study: _Study, weather: Irradiances) -> None:
        self._study, self._weather = study, weather

    def __len__(self) -> int:
        return self._study.source.n_points

    def __repr__(self) -> str:
        study, cast = self._study, self._study.cast
        index, kept = study.moments.index, cast.kept
        when = f"{len(index)} times from {index[0]:%Y-%m-%d} to {index[-1]:%Y-%m-%d}"
        memory = Coefficients.bytes_for(len(self), len(study.patches), len(study.moments.bins.directions))
        rays = "rays not cast yet" if kept is None else f"{kept.rays} rays in {cast.seconds:.3g} s"
        return f"<Daylight on {len(self)} vertices, {when}: {rays}, {memory / 1e6:.3g} MB>"

    def _repr_html_(self) -> str:
        """Return a table of the results. Before rays are cast, it has only their names."""
        rows = []
        for name in RESULTS:
            unit_of = "hours" if name == "sun_hours" else "Wh/m²"
            shown = ("not computed yet", "")
            if self._study.cast.kept is not None:
                values = getattr(self, name)
                shown = (f"{values.mean():.4g}", f"{values.max(initial=0.0):.4g}")
            rows.append((name, *shown, unit_of))
        return html_table(repr(self)[1:-1], ("", "mean", "largest", "unit"), rows)

    @property
    def times(self) -> Any:
        """The times, a pandas.DatetimeIndex."""
        return self._study.moments.index

    @property
    def hours(self) -> float:
        """Length in hours of the step of time around each moment."""
        return self._study.moments.hours

    @cached_property
    def _received(self) -> Received:
        study = self._study
        return received(
            study.cast.coefficients, study.cast.normals, study.place.axes, study.patches, study.sources(self._weather)
        )

    @property
    def sun_hours(self) -> Float64Array:
        """Hours in which the sun is above the horizon, in front of the surface and not hidden.

        They do not depend on weather.
        """
        return self._received.sun_hours

    @property
    def direct(self) -> Float64Array:
        """Light of the sun, Wh/m²."""
        return self._received.direct

    @property
    def diffuse(self) -> Float64Array:
        """Light of the sky, Wh/m²."""
        return self._received.diffuse

    @cached_property
    def reflected(self) -> Float64Array:
        """Light from the open ground and, if light bounces, from the mesh's own surfaces, Wh/m²."""
        study, first = self._study, self._received
        arriving = first.ground
        if study.cast.transport is not None:
            sent = first.direct + first.diffuse + first.ground
            for _ in range(study.bounces):
                sent = study.cast.transport.gather(study.albedo * sent[:, None])[:, 0].astype(np.float64)
                arriving = arriving + sent
        return arriving

    @property
    def total(self) -> Float64Array:
        """Sum of `direct`, `diffuse` and `reflected`, Wh/m²."""
        return self.direct + self.diffuse + self.reflected

    @property
    def standard_error(self) -> Float64Array:
        """Standard error of `diffuse` plus the light of the ground in `reflected`, Wh/m², because the rays are few.

        0 where nothing hides the sky. `direct` and `sun_hours` have no random error, but use positions that are up to
        `sun_bin` degrees from the sun. The error of bounced light is not included.
        """
        return self._received.error

    @property
    def mesh(self) -> pv.PolyData:
        """The surface with the point arrays ``sun_hours``, ``direct``, ``diffuse``, ``reflected`` and ``total``."""
        result = self._study.source.copy()
        for name in RESULTS:
            result.point_data[name] = np.array(getattr(self, name))
        return result

    def plot(
        self,
        name: Result = "total",
        *,
        off_screen: bool | None = None,
        window_size: tuple[int, int] | None = None,
        screenshot: str | os.PathLike[str] | bool | None = None,
        return_img: bool = False,
        **options: Any,
    ) -> Any:
        """Show a result in colours, with a scalar bar in its unit, seen from the south.

        Parameters
        ----------
        name : {"total", "sun_hours", "direct", "diffuse", "reflected"}, default "total"
            The result. If values exceed 10,000 Wh/m², they are shown in kWh/m².
        off_screen, window_size, screenshot, return_img
            As for `pyvista.Plotter` and its method `show`.
        **options
            Options of `pyvista.Plotter.add_mesh`, such as `clim` in the shown unit, `cmap` or `show_edges`.

        Examples
        --------
        >>> import pandas as pd, pyvista as pv, pvphong as ph
        >>> day = pd.date_range("2026-06-21T00:30", periods=24, freq="h", tz="Europe/Berlin")
        >>> pv.Sphere().phong.daylight(day, ph.Place(48.14, 11.58)).plot("sun_hours", off_screen=True)
        """
        values = getattr(self, check.choice("name", name, RESULTS))
        scale, unit_of = (1.0, "h") if name == "sun_hours" else (1.0, "Wh/m²")
        if name != "sun_hours" and values.max(initial=0.0) > _MANY:
            scale, unit_of = 1e-3, "kWh/m²"
        shown, (east, north, up) = shallow_copy(self._study.source), self._study.place.axes
        shown.point_data["pvphong_shown"] = values * scale
        bar = {"title": f"{_TITLES[name]}\n({unit_of})\n", "fmt": "%.4g", "n_labels": 6, "color": "black"}
        bar |= {"vertical": True, "position_x": 0.86, "position_y": 0.1, "width": 0.06, "height": 0.72}
        bar |= {"title_font_size": 17, "label_font_size": 15}
        look = scale_of_light(float(values.max(initial=0.0)) * scale) | {"lighting": False, "scalar_bar_args": bar}
        plotter = pv.Plotter(off_screen=off_screen, window_size=window_size)
        plotter.set_background("white")
        plotter.add_mesh(shown, scalars="pvphong_shown", **look | options)
        plotter.view_vector(0.35 * east - north + 0.9 * up, viewup=up)
        plotter.camera.zoom(1.2)
        plotter.enable_anti_aliasing("ssaa")
        return plotter.show(screenshot=screenshot, return_img=return_img)

    def with_weather(self, weather: Any = None) -> Daylight:
        """Return the light in another weather at the same times, without new rays.

        Parameters
        ----------
        weather : path, pair of array_like, pandas.DataFrame or None, default None
            As for `mesh.phong.daylight`.
        """
        return Daylight(self._study, irradiances(weather, self._study.moments.index, self._study.place))

    def expected_cost(self) -> DaylightCost:
        """Estimate the cost of the rays that are not cast yet, without bounces.

        For this, rays are cast from some vertices.
        This builds the casters, which takes about a second for three million triangles.
        """
        cast, count = self._study.cast, len(self)
        if cast.tracer is None or cast.kept is not None:
            return DaylightCost(0, 0.0, 0)
        cast.tracer.receiver.origins, cast.tracer.occluders.casters  # noqa: B018  so that their time is not counted
        rows = np.unique(np.linspace(0, count - 1, min(_PROBED, count)).astype(np.int64))
        start = time.perf_counter()
        with threads.limited(1):
            rays = cast.tracer.some(rows).cast().rays
        share, at_once = count / len(rows), 1 if cast.tracer.occluders.are_slow else threads.count()
        seconds = (time.perf_counter() - start) * share / at_once
        return DaylightCost(round(rays * share), seconds, cast.tracer.bytes_needed)

    # -- files

    def save(self, path: str | os.PathLike[str]) -> None:
        """Save the surface, the coefficients and the weather to a file in NumPy's format .npz; cast missing rays first.

        A year of hours takes about 250 bytes per vertex, and hits of bounced light 1 kB more.

        Raises
        ------
        ValueError
            If the file cannot be written.
        """
        study, coefficients = self._study, self._study.cast.coefficients
        place = study.place
        header = {
            "place": [place.latitude, place.longitude, place.altitude, place.up, place.north],
            "hours": study.moments.hours,
            "albedo": study.albedo,
            "bounces": study.bounces,
            "finer": study.patches.finer,
            "samples": coefficients.samples,
            "rays": coefficients.rays,
        }
        connectivity, offsets = polygons(study.source)
        index, bins = study.moments.index, study.moments.bins
        arrays = {
            "times": microseconds(index),
            "directions": bins.directions,
            "of_times": bins.of_times,
            "points": np.asarray(study.source.points),
            "connectivity": connectivity,
            "offsets": offsets,
            "normals": study.cast.normals,
            **self._weather._asdict(),
            **{name: getattr(coefficients, name) for name in _COEFFICIENTS},
        }
        if study.cast.transport is not None:
            arrays["hits"] = study.cast.transport.hits
        text = json.dumps(header, default=list)
        kind = np.array([_FORMAT, str(_VERSION), text, _checksum(text, arrays)])
        with written_aside(path) as aside, aside.open("wb") as file:
            np.savez(file, format=kind, **arrays)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Load a file written by `save`.

        Raises
        ------
        ValueError
            If the file cannot be read, has another format or version, or its checksum shows that it is damaged.
        """
        try:
            with open(path, "rb") as opened, np.load(opened, allow_pickle=False) as file:
                arrays = {name: file[name] for name in file.files}
            kind = arrays.pop("format").tolist()
            if len(kind) != 4 or kind[0] != _FORMAT or kind[1] != str(_VERSION):
                raise ValueError(f"its format is {' '.join(map(str, kind[:2]))}")
            if kind[3] != _checksum(kind[2], arrays):
                raise ValueError("its checksum is wrong")
            return cls(*_restored(json.loads(kind[2]), arrays))
        except (OSError, ValueError, KeyError, TypeError, IndexError, EOFError, zipfile.BadZipFile) as error:
            remedy = "Recompute it with mesh.phong.daylight(times, place)."
            reason = f"{type(error).__name__}: {error}. {remedy}"
            return check.refuse("path", os.fspath(path), "a file written by Daylight.save", reason)


RESULTS = "sun_hours", "direct", "diffuse", "reflected", "total"
_TITLES = {
    "sun_hours": "Sun hours",
    "direct": "Sunlight",
    "diffuse": "Skylight",
    "reflected": "Reflected light",
    "total": "Light",
}
# Wh/m² from which pictures show kWh/m².
_MANY = 1e4
_COEFFICIENTS = "sky", "ground", "ground_error", "sun"
_FORMAT, _VERSION = "pvphong daylight", 1


def _checksum(text: str, arrays: Mapping[str, Any]) -> str:
    """Return a checksum of a file's header and arrays."""
    found = hashlib.sha256(text.encode())
    for name, values in sorted(arrays.items()):
        found.update(f"{name} {values.dtype.str} {values.shape}".encode())
        found.update(np.ascontiguousarray(values).data)
    return found.hexdigest()


def _restored(header: dict[str, Any], arrays: dict[str, Any]) -> tuple[_Study, Irradiances]:
    """Return the study and the weather that a file's header and arrays describe."""
    latitude, longitude, altitude, up, north = header["place"]
    place = Place(latitude, longitude, altitude, tuple(up), tuple(north))
    pandas = importlib.import_module("pandas")
    index = pandas.DatetimeIndex(arrays["times"].astype("datetime64[us]"), tz="UTC")
    sun = sun_position(index, place)
    bins = SunBins(arrays["directions"], arrays["of_times"])
    source = pv.PolyData()
    source.points = arrays["points"]
    if len(arrays["offsets"]) > 1:
        source.faces = pv.CellArray.from_arrays(arrays["offsets"], arrays["connectivity"])
    counts = {name: header[name] for name in ("samples", "rays")}
    coefficients = Coefficients(**{name: arrays[name] for name in _COEFFICIENTS}, **counts)
    among = None if "hits" not in arrays else Transport.of_hits(arrays["hits"])
    cast = _Rays(None, among, coefficients, arrays["normals"])
    when = Moments(index, header["hours"], sun.direction, sun.altitude > 0.0, bins)
    sky = SkyStudy(when, place, Patches(header["finer"]), header["samples"], header["albedo"])
    study = _Study(**vars(sky), source=source, bounces=header["bounces"], cast=cast)
    return study, Irradiances(*(arrays[name] for name in Irradiances._fields))
