"""Meshes from and to files; whatever a reader or writer complains about becomes one `ValueError`."""

from __future__ import annotations

import logging
import re
import shutil
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.files import written_aside
from pvphong.scene.scene import is_scene_file

MESH_FORMATS = (".vtp", ".vtk", ".vtkhdf", ".ply")
"""What a lit mesh can be saved as. PyVista's other formats (.stl, .obj, …) have no room for its colours."""

BLOCK_FORMATS = (".vtm", ".vtmb", ".vtkhdf")
"""What a lit MultiBlock can be saved as."""

_PLY_TO_VTP = """
import sys
from vtkmodules.vtkIOPLY import vtkPLYReader
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter
reader, writer = vtkPLYReader(), vtkXMLPolyDataWriter()
reader.SetFileName(sys.argv[1])
writer.SetInputConnection(reader.GetOutputPort())
writer.SetFileName(sys.argv[2])
writer.SetCompressorTypeToNone()
writer.EncodeAppendedDataOff()
sys.exit(not writer.Write())
"""

_READABLE = "a mesh file that PyVista can read (.vtp, .vtu, .vtk, .ply, .stl, .obj, .vtm and many more)"

_SCENE = "It is a scene file: use it with --scene."


def read_mesh(path: str) -> pv.DataSet | pv.MultiBlock:
    """The mesh in a file of any format that PyVista reads.

    Raises
    ------
    ValueError
        If the file is not there, cannot be read to its end, or holds no mesh. A file that VTK's readers
        complain about is refused, because what they make of it is often only its first part.
    """
    if not Path(path).exists():
        check.refuse("mesh", Path(path), "a file that exists", _nearest_file(Path(path)))
    complaints: list[str] = []
    mesh = None
    with _heard(complaints):
        try:
            mesh = _read_ply(path) if Path(path).suffix.lower() == ".ply" else pv.read(path)
        except Exception as error:  # readers, VTK's and others', raise what they like
            complaints.insert(0, str(error))
    if complaints:
        check.refuse("mesh", Path(path), _READABLE, _SCENE if _is_scene(path) else _first_line(complaints))
    if not isinstance(mesh, (pv.DataSet, pv.MultiBlock)):
        check.refuse("mesh", f"a {type(mesh).__name__} in {path}", "a dataset or a MultiBlock")
    return mesh


def _nearest_file(path: Path) -> str:
    """The remedy for a file that is not there."""
    if not path.parent.is_dir():
        return f"There is no folder {path.parent}."
    return check.meant(path.name, [each.name for each in path.parent.iterdir()])


def _is_scene(path: str) -> bool:
    return Path(path).suffix.lower() == ".json" and is_scene_file(path)


def _read_ply(path: str) -> pv.DataSet:
    """A .ply file by way of a child process, because VTK's reader dies of most that are damaged or cut short."""
    with tempfile.TemporaryDirectory() as folder:
        copy = str(Path(folder, "mesh.vtp"))
        child = subprocess.run([sys.executable, "-c", _PLY_TO_VTP, path, copy], capture_output=True, check=False)
        if child.returncode != 0:
            raise ValueError("VTK's reader fails on it: it is damaged, cut short, or not a .ply file.")
        return pv.read(copy)


def save_lit(lit: pv.PolyData | pv.MultiBlock, path: Path, name: str) -> None:
    """Write a lit mesh in the format that the suffix says, whole or not at all.

    A ``.ply`` file gets the colours as 8-bit ``red green blue`` of its vertices, which is where programs
    look for them; the other formats get all arrays as they are. A ``.vtm`` file has a folder of the same
    name beside it, with the blocks: the file itself is written last.

    Parameters
    ----------
    lit : pyvista.PolyData or pyvista.MultiBlock
        Lit colours as a point array.
    path : Path
        One of `MESH_FORMATS`, or of `BLOCK_FORMATS` for a MultiBlock.
    name : str
        Name of the array with the colours.

    Raises
    ------
    ValueError
        For another suffix, or if the file cannot be written.
    """
    if isinstance(lit, pv.MultiBlock):
        refuse_suffix(path, "a MultiBlock", BLOCK_FORMATS)
    else:
        refuse_suffix(path, "a single mesh", MESH_FORMATS)
    options: dict[str, Any] = {}
    if path.suffix.lower() == ".ply":
        options = {"texture": eight_bit(lit[name]), "recompute_normals": False}
        lit = lit.copy(deep=False)  # PyVista adds the texture to the mesh that it saves
    with written_aside(path) as aside:
        _refuse_full_disk(lit, aside)
        _save(lit, aside, options)
        _move_blocks(aside, path)


def refuse_suffix(path: Path, what: str, allowed: tuple[str, ...]) -> None:
    """Raise ``ValueError`` for a path whose suffix is not among those that hold the colours of `what`."""
    if path.suffix.lower() not in allowed:
        *others, last = allowed
        listed = ", ".join([*others, f"or {last} for a picture" if others and last == ".png" else last])
        check.refuse("output", path, f"a file that holds the colours of {what}: one of {listed}")


def eight_bit(colors: Any) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Colours in [0, 1] as 0 to 255, rounded; anything outside is clipped first."""
    return np.rint(np.clip(np.asarray(colors), 0.0, 1.0) * 255.0).astype(np.uint8)


def _refuse_full_disk(lit: Any, aside: Path) -> None:
    """VTK's writers do not notice that a disk is full: they crash, or leave half a file and say nothing."""
    needed = 2048 * lit.actual_memory_size + 2**16  # twice the memory, which is counted in KiB: formats differ
    free = shutil.disk_usage(aside.parent).free
    if free < needed:
        raise ValueError(f"output needs up to {needed / 2**20:.1f} MiB on its disk, and {free / 2**20:.1f} are free.")


def _save(lit: Any, aside: Path, options: dict[str, Any]) -> None:
    complaints: list[str] = []
    with _heard(complaints):
        try:
            lit.save(aside, **options)
        except OSError as error:
            complaints.append(str(error))
    if complaints:
        shutil.rmtree(aside.with_suffix(""), ignore_errors=True)
        raise ValueError(f"output could not be written to {aside.name}: {_first_line(complaints)}")


def _move_blocks(aside: Path, path: Path) -> None:
    """Bring the folder of blocks, if the writer made one, to its place."""
    written = aside.with_suffix("")
    if not written.is_dir():
        return
    folder = path.with_suffix("")
    try:
        folder.mkdir(exist_ok=True)
        for block in written.iterdir():
            block.replace(folder / block.name)
    except OSError as error:
        raise ValueError(f"output needs the folder {folder} for its blocks ({error}).") from error
    finally:
        shutil.rmtree(written)


@contextmanager
def _heard(complaints: list[str]) -> Iterator[None]:
    """Collects VTK's errors, and PyVista's warnings of such errors, instead of letting them be printed."""
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
    """The first complaint's first line, without VTK's addresses."""
    line = complaints[0].strip().splitlines()[0]
    return re.sub(r" ?\(0x[0-9a-f]+\)", "", line)
