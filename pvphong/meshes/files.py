"""Reading of meshes and textures, and atomic writing of lit meshes.

`read` with `guarded=True` reads in a child process, so that a crash of the reader does not end this process.
`read_mesh` reads in this process. All errors and warnings of readers and writers become a single `ValueError`.
"""

from __future__ import annotations

import logging
import os
import pickle
import re
import subprocess
import sys
import tempfile
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.files import PREFIX, reserve, sync, written_aside
from pvphong.base.processes import Watch, begin_work, environment, reading
from pvphong.meshes.blocks import leaves, map_blocks
from pvphong.meshes.whole_files import refuse_incomplete
from pvphong.scene.scene import is_scene_file

MESH_FORMATS = (".vtp", ".vtk", ".vtkhdf", ".ply")
"""Formats for a lit mesh. PyVista's other formats (.stl, .obj, …) cannot hold its colours."""

BLOCK_FORMATS = (".vtm", ".vtmb", ".vtkhdf")
"""Formats for a lit MultiBlock."""

Compression = Literal["lz4", "zlib", "none"]
"""Compression of arrays in VTK's XML files. For a million points, LZ4 writes ten times faster than zlib and reads more
than twice as fast; its files are twice as large."""

_CHILD = "import sys; from pvphong.meshes.files import _read_for_parent; _read_for_parent(*sys.argv[1:])"

_one_at_a_time = threading.RLock()
"""Lock held while VTK reads or writes, because catching VTK's errors changes settings of the whole process."""


# --- reading ---


def read(path: str | os.PathLike[str], *, guarded: bool = False) -> pv.DataSet | pv.MultiBlock:
    """Read a mesh from a file of any format that PyVista reads, and refuse damaged files.

    For a damaged file, `pyvista.read` may return a part of the mesh and print warnings. This function raises an error.

    Parameters
    ----------
    path : path
        The file.
    guarded : bool, default False
        Read the file in a child process, because some of VTK's readers crash or hang on damaged files. This takes about
        a second longer. The child is killed if it reads no data from the disk for a minute, plus a second for each
        megabyte of the file.

    Returns
    -------
    pyvista.DataSet or pyvista.MultiBlock

    Raises
    ------
    ValueError
        If the file does not exist, is incomplete or holds no mesh; with `guarded=True` also if its reader crashes.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import pyvista as pv, pvphong as ph
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "ball.vtp"
    >>> pv.Sphere().save(path)
    >>> ph.read(path).n_points
    842
    """
    if not check.flag("guarded", guarded):
        return read_mesh(os.fspath(path))
    if os.name != "posix" or not Path(sys.executable or "").name.startswith("python"):
        check.refuse("guarded", guarded, "False, because Python cannot start a second Python process here")
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder, "mesh")
        listening, speaking = os.pipe()
        # multiprocessing would import the caller's main module, and reports neither signals nor progress
        child = subprocess.Popen(
            [sys.executable, "-W", "ignore", "-c", _CHILD, os.fspath(path), str(result), str(speaking)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,  # some readers print
            stderr=subprocess.DEVNULL,
            pass_fds=[speaking],
            env=environment(),
        )
        os.close(speaking)
        with child, os.fdopen(listening):
            watch = Watch(listening, child.pid)
            watch.until_it_ends()
        if child.returncode:
            raise ValueError(watch.failure(child.returncode))
        found: pv.DataSet | pv.MultiBlock | ValueError = pickle.loads(result.read_bytes())
        if isinstance(found, ValueError):
            raise found
        return found


def _read_for_parent(path: str, result: str, end: str) -> None:
    """Read a mesh in a child process, and write the mesh, or a ValueError, to the file `result` for the parent.

    The arguments come from the command line. `path` is the file of the mesh. `end` is the file descriptor of the pipe
    to the parent.
    """
    begin_work(int(end))
    found: Any
    with reading(path):
        try:
            found = read_mesh(path)
        except ValueError as error:
            found = error
        Path(result).write_bytes(pickle.dumps(found, protocol=5))


def read_mesh(path: str) -> pv.DataSet | pv.MultiBlock:
    """Read a mesh in this process, from a file of any format that PyVista reads.

    A parent process that watches this process gets progress reports.

    Raises
    ------
    ValueError
        If the file does not exist, cannot be read to its end, or holds no mesh; also if VTK reports an error, because
        the result is then often only the first part of the mesh.
    """
    _refuse_missing("mesh", Path(path), "a file that exists")
    complaints: list[str] = []
    mesh = None
    with _complaints_in(complaints), reading(path):
        try:
            refuse_incomplete(Path(path))
            mesh = pv.read(path)
        except Exception as error:  # readers of VTK and others may raise anything
            complaints.insert(0, str(error) or type(error).__name__)
    if complaints:
        is_scene = Path(path).suffix.lower() == ".json" and is_scene_file(path)
        reason = "It is a scene file; pass it as --scene." if is_scene else _first_line(complaints)
        readable = "a mesh file that PyVista can read (.vtp, .vtu, .vtk, .ply, .stl, .obj, .vtm and many more)"
        check.refuse("mesh", Path(path), readable, reason)
    if not isinstance(mesh, (pv.DataSet, pv.MultiBlock)):
        check.refuse("mesh", f"a {type(mesh).__name__} in {path}", "a dataset or a MultiBlock")
    return mesh


def read_texture(path: str, name: str = "albedo") -> Any:
    """Read a texture from an image file with Pillow, because VTK's readers crash on damaged files.

    `name` is the material's field, for error messages.

    Raises
    ------
    ValueError
        If the file does not exist, or cannot be read to its end.
    """
    from PIL import Image

    _refuse_missing(name, Path(path), "a point array, or an image file that exists")
    try:
        with Image.open(path) as image:
            values = np.asarray(image if image.mode[0] in "IF" else image.convert("RGB"))
    except Exception as error:  # Pillow's readers may raise anything
        check.refuse(name, Path(path), "an image file that Pillow can read", _first_line([str(error)]))
    return pv.Texture(values)


def _refuse_missing(name: str, path: Path, allowed: str) -> None:
    try:
        path.stat()
    except (FileNotFoundError, NotADirectoryError):
        remedy = f"There is no folder {path.parent}."
        if path.parent.is_dir():
            beside: list[str] = []
            with suppress(OSError):  # the folder may not be listable
                beside = os.listdir(path.parent)
            remedy = check.meant(path.name, beside)
        check.refuse(name, path, allowed, remedy)
    except OSError as error:  # a name that is too long, a loop of links, a folder without search permission
        check.refuse(name, path, allowed, f"{error.strerror}.")


# --- writing ---


def save_lit(lit: pv.PolyData | pv.MultiBlock, path: Path, name: str, compress: Compression = "lz4") -> None:
    """Write a lit mesh atomically, in the format given by the suffix.

    A ``.ply`` file stores the colours in its usual vertex properties, 8-bit ``red green blue``. The other formats store
    all arrays unchanged. A ``.vtm`` file has a folder of the same name next to it, with the blocks; the file itself is
    written last.

    Parameters
    ----------
    lit : pyvista.PolyData or pyvista.MultiBlock
        A mesh with lit colours as a point array.
    path : Path
        A path with a suffix in `MESH_FORMATS`, or in `BLOCK_FORMATS` for a MultiBlock.
    name : str
        Name of the array with the colours.
    compress : {"lz4", "zlib", "none"}, default "lz4"
        Compression of the arrays in .vtp, .vtm and .vtmb files; other formats are not compressed.

    Raises
    ------
    ValueError
        For another suffix or compression, or if the file cannot be written.
    """
    if isinstance(lit, pv.MultiBlock):
        refuse_suffix(path, "a MultiBlock", BLOCK_FORMATS)
    else:
        refuse_suffix(path, "a single mesh", MESH_FORMATS)
    check.choice("compress", compress, get_args(Compression))
    suffix = path.suffix.lower()
    options: dict[str, Any] = {"compression": None if compress == "none" else compress}
    if suffix in (".vtm", ".vtmb"):
        _save_with_folder(lit, path, options)
        return
    if suffix == ".ply":
        options |= {"texture": eight_bit(lit.point_data[name]), "recompute_normals": False}
        lit = lit.copy(deep=False)  # PyVista's writer adds the colours to it
        coordinates = lit.active_texture_coordinates
        if coordinates is not None and coordinates.dtype != np.float32:  # VTK's writer would crash
            lit.active_texture_coordinates = coordinates.astype(np.float32)
    with written_aside(path) as aside:
        if suffix == ".vtkhdf":  # its writer does not report a full disk, and the file's length does not show it
            chunks = sum(len(part.array_names) + 12 for part in leaves(lit))
            reserve(aside, sum(map(_data_size, leaves(lit))) + 2**20 * chunks)
        _save(lit, aside, options)


def refuse_suffix(path: Path, what: str, allowed: tuple[str, ...]) -> None:
    """Raise ``ValueError`` if the suffix of a path is not in `allowed`.

    `what` names the contents of the file in the message, such as "a mesh".
    """
    if path.suffix.lower() not in allowed:
        *others, last = allowed
        listed = ", ".join([*others, f"or {last} for a picture" if others and last == ".png" else last])
        check.refuse("path", path, f"a file for {what} ({listed})")


def eight_bit(colors: Any) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Convert colours in [0, 1] to integers from 0 to 255, rounded; values outside are clipped."""
    return np.rint(np.clip(np.asarray(colors), 0.0, 1.0) * 255.0).astype(np.uint8)


def _data_size(part: Any) -> int:
    """Return the size in bytes of a mesh's points, arrays and cells, with 8 bytes per index."""
    arrays = (part.GetPointData(), part.GetCellData(), part.GetFieldData())
    cells = (
        (part.GetVerts(), part.GetLines(), part.GetPolys(), part.GetStrips()) if isinstance(part, pv.PolyData) else ()
    )
    indices = sum(array.GetNumberOfConnectivityIds() + array.GetNumberOfOffsets() for array in cells)
    return 1024 * sum(data.GetActualMemorySize() for data in arrays) + 24 * part.n_points + 8 * indices


def _save(lit: Any, aside: Path, options: dict[str, Any]) -> None:
    """Write a mesh to the temporary path `aside`, and check that the file is complete; raise ValueError on failure.

    The check is needed because some of VTK's writers do not report failures. `options` are those of PyVista's `save`.
    """
    complaints: list[str] = []
    with _complaints_in(complaints):
        try:
            if aside.suffix.lower() == ".vtp":
                _write_polydata(lit, aside, options["compression"])
            else:
                lit.save(aside, **options)
        except OSError as error:
            complaints.insert(0, str(error))
    if not complaints and not (aside.is_file() and aside.stat().st_size):
        complaints.append("the file is missing or empty.")
    if complaints:
        raise ValueError(f"output could not be written: {_first_line(complaints)} The disk may be full.")
    try:
        refuse_incomplete(aside)
    except ValueError as error:
        raise ValueError(f"output could not be written. {error}") from error


def _write_polydata(lit: pv.PolyData, aside: Path, compression: Any) -> None:
    """Write a mesh to the temporary .vtp file `aside`, with its arrays appended as bytes.

    (Base64 would take three times as long and a third more space.) VTK's writer crashes the process on a full disk. So
    if the disk may be too small, the file is made in memory first, and then written to the disk. This takes twice the
    file's length in memory. `compression` is "lz4", "zlib", or None for no compression.
    """
    lit._store_metadata()  # as in PyVista's `save`, for arrays of bools and complex numbers
    writer = pv.XMLPolyDataWriter(aside, lit)
    writer.compression = compression
    writer.writer.SetDataModeToAppended()
    writer.writer.EncodeAppendedDataOff()
    try:
        reserve(aside, int(1.1 * _data_size(lit)) + 2**16)  # enough without compression; most files are much smaller
    except OSError:
        writer.writer.WriteToOutputStringOn()
        writer.write()
        aside.write_bytes(writer.writer.GetOutputString())
    else:
        writer.write()


def _save_with_folder(blocks: pv.MultiBlock, path: Path, options: dict[str, Any]) -> None:
    """Write a MultiBlock as a file that lists the files of its blocks. These are in a folder next to the file.

    The blocks are written first, under new names, so that an old file and its blocks stay valid until the new file
    replaces it. The names contain the random suffix of the temporary folder in which the files are made.

    VTK's writer of blocks crashes the process on a full disk. Therefore it only writes a copy of the MultiBlock in
    which each mesh is a single point. The meshes are written separately. `options` are those of PyVista's `save`.
    """
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():
        remedy = "The blocks are written to a folder next to the file."
        check.refuse("path", target, "a regular file or a new path", remedy)
    try:
        with written_aside(path) as aside:
            mark = "-" + aside.parent.name.removeprefix(PREFIX)
            marked = aside.with_stem(target.stem + mark)
            point = pv.PolyData(np.zeros((1, 3)))
            index = map_blocks(blocks, lambda block: point if isinstance(block, pv.PolyData) else block)
            reserve(aside, 2048 * int(index.actual_memory_size) + 2**12 * (1 + len(leaves(index))))
            _save(index, marked, options)
            for number, block in enumerate(blocks.recursive_iterator(skip_none=False, skip_empty=False)):
                if isinstance(block, pv.PolyData) and block.n_points:
                    _save(block, marked.with_suffix("") / f"{marked.stem}_{number}.vtp", options)
            aside.write_text(marked.read_text(encoding="utf-8").replace(f"{mark}/", "/"), encoding="utf-8")
            folder, files = target.with_suffix(""), sorted(marked.with_suffix("").glob("*"))
            try:
                if files:
                    folder.mkdir(exist_ok=True)
                for file in files:
                    sync(file)
                    file.replace(folder / file.name)
            except OSError as error:
                failure = f"output could not be written: its blocks need the folder {folder} ({error})."
                raise ValueError(failure) from error
    finally:
        _clear_old_blocks(target)


def _clear_old_blocks(target: Path) -> None:
    """Remove the block files that the MultiBlock file `target` no longer lists, from the folder next to `target`.

    Files of writers that are still running are kept.
    """
    marked = re.compile(re.escape(target.stem) + r"-([a-z0-9_]{8})_\d+(_\d+)*\.\w+")
    old = [(block, found[1]) for block in target.with_suffix("").glob("*") if (found := marked.fullmatch(block.name))]
    left = [(block, mark) for block, mark in old if not target.with_name(PREFIX + mark).exists()]
    with suppress(OSError):
        kept = target.read_text(encoding="utf-8")  # read last, so that it includes a writer that has just finished
        for block, mark in left:
            if f"-{mark}_" not in kept:
                block.unlink(missing_ok=True)


# --- errors and warnings of VTK ---


@contextmanager
def _complaints_in(complaints: list[str]) -> Iterator[None]:
    """Return a context that appends VTK's errors, and PyVista's warnings of them, to `complaints`, and prints none."""
    with _one_at_a_time:
        logged = logging.root.manager.disable
        logging.disable(logging.CRITICAL)
        try:
            with (
                pv.vtk_verbosity("off"),
                warnings.catch_warnings(record=True) as warned,
                pv.VtkErrorCatcher(send_to_logging=False) as caught,
            ):
                warnings.simplefilter("always")
                yield
        finally:
            logging.disable(logged)
    complaints += [event.alert for event in caught.error_events]
    complaints += [str(warning.message) for warning in warned if "raised an error" in str(warning.message)]


def _first_line(complaints: list[str]) -> str:
    """Return the first line of the first of `complaints`, without the memory addresses that VTK prints."""
    line = complaints[0].strip().splitlines()[0]
    return re.sub(r" ?\(0x[0-9a-f]+\)", "", line)
