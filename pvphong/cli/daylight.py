"""`pvphong daylight`: light of the sun and the sky on a mesh over a year or a day, as a file and as a picture.

A city in many files becomes a folder of files.
"""

from __future__ import annotations

import importlib
import os
import sys
import warnings
from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import Annotated, Any, Literal

import pyvista as pv
from cyclopts import Parameter

from pvphong.base import check
from pvphong.base.processes import reading
from pvphong.batch.daylight import daylight_files
from pvphong.batch.pieces import Seams, is_pattern
from pvphong.cli.options import SIZE, busy, refuse_given
from pvphong.meshes.files import read_mesh, refuse_suffix, save_lit
from pvphong.meshes.lit import one_surface
from pvphong.meshes.pictures import drawing_window, preferring, refuse_size, save_picture
from pvphong.meshes.surfaces import FeatureAngle, surface
from pvphong.scene.daylight import ALBEDO
from pvphong.scene.sun import Place, pvlib
from pvphong.scene.weather import zone_of

_FORMATS = ".vtp", ".vtk", ".vtkhdf"
_YEAR = 2026
_STEPS_PER_HOUR_OF_DAY = 6

Shown = Literal["total", "sun-hours", "direct", "diffuse", "reflected"]


def daylight(
    mesh: str,
    /,
    *more: str,
    place: Annotated[str, Parameter(allow_leading_hyphen=True)],
    output: Annotated[str | None, Parameter(name=["--output", "-o"])] = None,
    plot: Path | None = None,
    epw: Path | None = None,
    day: str | None = None,
    year: int | None = None,
    show: Shown | None = None,
    albedo: float = ALBEDO,
    bounces: int = 0,
    up: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    north: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    occluder: Annotated[tuple[str, ...], Parameter(negative="", show_default=False)] = (),
    feature_angle: Annotated[FeatureAngle, Parameter(show_choices=False)] = "auto",
    size: Annotated[tuple[int, int] | None, Parameter(negative="")] = None,
    workers: int | None = None,
    scheduler: str | None = None,
    seams: Seams | None = None,
) -> int:
    """Compute the light of sun and sky on a mesh over a year or a day: hours with sun, and Wh/m².

    Several blocks are joined into one surface. A city in many files is computed by several processes; each file shadows
    all others, and files that are finished already are skipped. Files that cannot be read are listed, and the exit
    status is then 1.

    Parameters
    ----------
    mesh
        File of any format that PyVista reads.
    more
        More files of the same city: mesh files, patterns such as "city/*.vtp", or index files (.vtm, .pvtp, .pvtu,
        .pvd).
    place
        Latitude and longitude in degrees, north and east positive, as in 48.14,11.58; a third number is the height
        above sea level in metres.
    output
        File to write: .vtp, .vtk or .vtkhdf, with the point arrays sun_hours, direct, diffuse, reflected and total. For
        many files, a folder such as sun/, in which a .vtp is written for each.
    plot
        Picture to write, a .png with a scalar bar.
    epw
        EPW file with the weather. Default: a clear sky.
    day
        One day, as in 2026-06-21, in steps of ten minutes, instead of a year in steps of an hour.
    year
        The year. Default: 2026; weather files fit every year.
    show
        The result in the picture. Default: total for a year, sun-hours for a day.
    albedo
        Fraction of the light that the ground around the mesh, and with --bounces the mesh, reflects.
    bounces
        Number of diffuse reflections between the mesh's own surfaces.
    up
        Direction to the zenith, as in 0,1,0. Default: 0,0,1.
    north
        Direction to the north. Default: 0,1,0, or 0,0,-1 if up is 0,1,0.
    occluder
        File with another mesh that casts shadows; may be repeated.
    feature_angle
        An edge is sharp if the normals of its two faces differ by more than this angle, in degrees. "auto": 30 if the
        mesh has no point normals, otherwise no sharp edges. "none": no sharp edges.
    size
        Width and height of the picture in pixels. Default: 1024 768.
    workers
        Number of local processes for many files. Default: the number of processors.
    scheduler
        Address of a Dask scheduler, such as tcp://host:8786, for many files.
    seams
        Normals of points of several files with equal coordinates: "merge" or "keep", as for the command shade.
    """
    names_folder = output is not None and (output.endswith(("/", os.sep)) or os.path.isdir(output))
    are_many = bool(more) or is_pattern(mesh) or names_folder
    if not are_many:
        allowed = "omitted for a single mesh (it applies to many files and -o FOLDER/)"
        refuse_given({"--workers": workers, "--scheduler": scheduler, "--seams": seams}, allowed)
    elif output is None or (not names_folder and Path(output).suffix.lower() in _FORMATS):
        remedy = f"-o {output or 'sun'}/ makes a folder of that name."
        check.refuse("--output", output or "no output", "a folder for many files", remedy)
    else:
        refuse_given({"--plot": plot, "--occluder": occluder}, "omitted for many files")
        if workers is not None and scheduler is not None:
            check.refuse("--workers", workers, "omitted with --scheduler, because the scheduler has workers")
    if output is None and plot is None:
        check.refuse("--output", "no output", "given, or --plot", "For example, -o sun.vtp or --plot sun.png.")
    target = None if output is None else Path(output)
    if target is not None and not are_many:
        refuse_suffix(target, "a mesh with daylight", _FORMATS)
    if plot is None:
        for option, given in {"--show": show, "--size": size}.items():
            if given is not None:
                check.refuse(option, given, "used with --plot")
    else:
        refuse_suffix(plot, "a picture", (".png",))
        refuse_size(size or SIZE)
    if day is not None and year is not None:
        check.refuse("--year", year, "omitted with --day, which names a year")
    where = _place(place, up, north)
    offset = round(where.longitude / 15.0) if epw is None else zone_of(epw)
    times = _times(day, _YEAR if year is None else year, offset)
    options: dict[str, Any] = {"albedo": albedo, "bounces": bounces, "feature_angle": feature_angle}
    if are_many and output is not None:
        options |= {"client": scheduler, "workers": workers, "seams": seams}
        return _many((mesh, *more), output, (times, where, epw), options)
    with reading(mesh):
        given = read_mesh(mesh)
        source = one_surface(given, feature_angle) if isinstance(given, pv.MultiBlock) else surface(given)
    if isinstance(given, pv.MultiBlock):
        options["feature_angle"] = None  # split already
    with busy(f"Daylight on {mesh}"), warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", UserWarning)
        occluders = [read_mesh(path) for path in occluder]
        light = source.phong.daylight(times, where, epw, occluders=occluders, **options)
        if target is not None:
            save_lit(light.mesh, target, "total")
        if plot is not None:
            chosen: Any = (show or ("total" if day is None else "sun-hours")).replace("-", "_")
            with preferring(drawing_window()):
                image = light.plot(chosen, off_screen=True, window_size=size or SIZE, return_img=True)
            save_picture(image, plot)
    _print_notes(said)
    for path in filter(None, (target, plot)):
        print(path)
    return 0


def _many(meshes: Sequence[str], output: str, study: tuple[Any, Place, Path | None], options: dict[str, Any]) -> int:
    """Write the daylight of many files into the folder `output`, print the results, and return the exit status.

    `study` has the times, the place and the weather, and `options` has further arguments of `daylight_files`.
    """
    with busy("Daylight on many files"), warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", UserWarning)
        batch = daylight_files(meshes, output, *study, **options)
    _print_notes(said)
    print(batch, file=sys.stderr if batch.failed else sys.stdout)
    return 1 if batch.failed else 0


def _print_notes(said: Sequence[warnings.WarningMessage]) -> None:
    for each in said:
        print(f"note: {each.message}", file=sys.stderr)


def _place(text: str, up: str | None, north: str | None) -> Place:
    """Make the place of the mesh from the options --place, --up and --north.

    The arguments are the texts of these options; None for an option that is not given.
    """
    numbers = _numbers("--place", text, (2, 3), "48.14,11.58")
    axes: dict[str, Any] = {
        name: _numbers(f"--{name}", each, (3,), "0,1,0") for name, each in (("up", up), ("north", north)) if each
    }
    if axes.get("up") == [0.0, 1.0, 0.0] and north is None:
        axes["north"] = [0.0, 0.0, -1.0]
    latitude, longitude, *height = numbers
    return Place(latitude, longitude, height[0] if height else 0.0, **axes)


def _numbers(option: str, text: str, counts: tuple[int, ...], example: str) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts:
        allowed = f"{' or '.join(map(str, counts))} numbers separated by commas"
        check.refuse(option, text, allowed, f"For example, {option} {example}.")
    return numbers


def _times(day: str | None, year: int, offset: float) -> Any:
    """Return the times for which light is computed: the middles of equal steps of a year or a day.

    Without `day`, the steps are the hours of `year`; else they are the ten minutes of the date `day`. `offset` is the
    time zone, in hours ahead of UTC.
    """
    pvlib("place")
    pandas = importlib.import_module("pandas")
    if day is None:
        first, last, steps = date(int(check.number("--year", year, at_least=1950, at_most=2200)), 1, 1), None, 1
        last = date(year, 12, 31)
    else:
        try:
            first = last = date.fromisoformat(day)
        except ValueError:
            check.refuse("--day", day, "a date such as 2026-06-21")
        steps = _STEPS_PER_HOUR_OF_DAY
    step = pandas.Timedelta(hours=1) / steps
    begin = pandas.Timestamp(first, tz="UTC") - pandas.Timedelta(hours=offset) + 0.5 * step
    count = ((last - first).days + 1) * 24 * steps
    return pandas.date_range(begin, periods=count, freq=step)
