"""Meshes from and to files; whatever a reader or writer complains about becomes one `ValueError`."""

from __future__ import annotations

import logging
import os
import re
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
from pvphong.meshes.blocks import leaves
from pvphong.meshes.truncation import refuse_parts
from pvphong.scene.scene import is_scene_file

MESH_FORMATS = (".vtp", ".vtk", ".vtkhdf", ".ply")
"""What a lit mesh can be saved as. PyVista's other formats (.stl, .obj, …) have no room for its colours."""

BLOCK_FORMATS = (".vtm", ".vtmb", ".vtkhdf")
"""What a lit MultiBlock can be saved as."""

Compression = Literal["lz4", "zlib", "none"]
"""How arrays in VTK's XML files are compressed. Of a million points, LZ4 writes ten times as fast as zlib and reads
more than twice as fast; its files are twice as large."""

_WITH_FOLDER = (".vtm", ".vtmb")
_alone = threading.RLock()

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
            refuse_parts(Path(path))
            mesh = pv.read(path)
        except Exception as error:  # readers, VTK's and others', raise what they like
            complaints.insert(0, str(error) or type(error).__name__)
    if complaints:
        check.refuse("mesh", Path(path), _READABLE, _SCENE if _is_scene(path) else _first_line(complaints))
    if not isinstance(mesh, (pv.DataSet, pv.MultiBlock)):
        check.refuse("mesh", f"a {type(mesh).__name__} in {path}", "a dataset or a MultiBlock")
    return mesh


def read_texture(path: str) -> Any:
    """The texture in an image file of any format that Pillow reads; VTK's readers would crash on damaged ones.

    Raises
    ------
    ValueError
        If the file is not there, or cannot be read to its end.
    """
    from PIL import Image

    if not Path(path).exists():
        check.refuse("albedo", Path(path), "a point array, or an image file that exists", _nearest_file(Path(path)))
    try:
        with Image.open(path) as image:
            values = np.asarray(image if image.mode[0] in "IF" else image.convert("RGB"))
    except Exception as error:  # its readers raise what they like
        check.refuse("albedo", Path(path), "an image file that Pillow can read", _first_line([str(error)]))
    return pv.Texture(values)


def _nearest_file(path: Path) -> str:
    """The remedy for a file that is not there."""
    if not path.parent.is_dir():
        return f"There is no folder {path.parent}."
    return check.meant(path.name, [each.name for each in path.parent.iterdir()])


def _is_scene(path: str) -> bool:
    return Path(path).suffix.lower() == ".json" and is_scene_file(path)


def save_lit(lit: pv.PolyData | pv.MultiBlock, path: Path, name: str, compress: Compression = "lz4") -> None:
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
    compress : {"lz4", "zlib", "none"}, default "lz4"
        How the arrays of .vtp, .vtm and .vtmb files are compressed; the other formats are not.

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
    options: dict[str, Any] = {"compression": None if compress == "none" else compress}
    if path.suffix.lower() == ".ply":
        options = {"texture": eight_bit(lit[name]), "recompute_normals": False}
        lit = _for_ply(lit)
    target = Path(os.path.realpath(path)) if path.suffix.lower() in _WITH_FOLDER else None
    try:
        with written_aside(path) as aside:
            reserve(aside, _room(lit, path.suffix.lower()))
            if target is None:
                _save(lit, aside, options)
            else:
                _save_with_folder(lit, aside, target, options)
    finally:
        if target is not None:
            _clear_old_blocks(target)


def refuse_suffix(path: Path, what: str, allowed: tuple[str, ...]) -> None:
    """Raise ``ValueError`` for a path whose suffix is not among those that hold the colours of `what`."""
    if path.suffix.lower() not in allowed:
        *others, last = allowed
        listed = ", ".join([*others, f"or {last} for a picture" if others and last == ".png" else last])
        check.refuse("output", path, f"a file that holds the colours of {what}: one of {listed}")


def eight_bit(colors: Any) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Colours in [0, 1] as 0 to 255, rounded; anything outside is clipped first."""
    return np.rint(np.clip(np.asarray(colors), 0.0, 1.0) * 255.0).astype(np.uint8)


def _room(lit: Any, suffix: str) -> int:
    """More bytes than a file will have: twice the memory, and in a .vtkhdf a whole chunk for each array, at least."""
    chunks = sum(len(part.array_names) + 12 for part in leaves(lit)) if suffix == ".vtkhdf" else 0
    return 2048 * int(lit.actual_memory_size) + 2**16 + 2**20 * chunks


def _for_ply(lit: pv.PolyData) -> pv.PolyData:
    """A copy to which PyVista can add the colours, with texture coordinates as VTK's writer takes them."""
    copy = lit.copy(deep=False)
    coordinates = copy.active_texture_coordinates
    if coordinates is not None and coordinates.dtype != np.float32:
        copy.active_texture_coordinates = coordinates.astype(np.float32)
    return copy


def _save(lit: Any, aside: Path, options: dict[str, Any]) -> None:
    """Write a file, and look whether all of it is there: some of VTK's writers do not."""
    complaints: list[str] = []
    with _heard(complaints):
        try:
            lit.save(aside, **options)
        except OSError as error:
            complaints.append(str(error))
    if not complaints and not aside.is_file():
        complaints.append("there is no file.")
    if complaints:
        raise ValueError(f"output could not be written: {_first_line(complaints)}")
    try:
        refuse_parts(aside)
    except ValueError as error:
        raise ValueError(f"output could not be written. {error}") from error


def _save_with_folder(lit: pv.MultiBlock, aside: Path, target: Path, options: dict[str, Any]) -> None:
    """Write a file that names others in a folder: these are brought to their place first, under names that are new.

    So the old file and its blocks are whole until the new one takes its place. A name is that of the folder that is
    written in, behind the stem.
    """
    if target.exists() and not target.is_file():
        check.refuse("path", target, "a file: the blocks need a folder beside it")
    mark = "-" + aside.parent.name.removeprefix(PREFIX)
    marked = aside.with_stem(target.stem + mark)
    _save(lit, marked, options)
    aside.write_text(marked.read_text(encoding="utf-8").replace(f"{mark}/", "/"), encoding="utf-8")
    folder, blocks = target.with_suffix(""), sorted(marked.with_suffix("").glob("*"))
    try:
        if blocks:
            folder.mkdir(exist_ok=True)
        for block in blocks:
            sync(block)
            block.replace(folder / block.name)
    except OSError as error:
        raise ValueError(f"output needs the folder {folder} for its blocks ({error}).") from error


def _clear_old_blocks(target: Path) -> None:
    """Remove the blocks of earlier files of this name, but for those of writers that are still at it."""
    marked = re.compile(re.escape(target.stem) + r"-([a-z0-9_]{8})_\d+(_\d+)*\.\w+")
    old = [(block, found[1]) for block in target.with_suffix("").glob("*") if (found := marked.fullmatch(block.name))]
    left = [(block, mark) for block, mark in old if not target.with_name(PREFIX + mark).exists()]
    with suppress(OSError):
        kept = target.read_text(encoding="utf-8")  # read last: a writer that has just ended is in it, or is replaced
        for block, mark in left:
            if f"-{mark}_" not in kept:
                block.unlink(missing_ok=True)


@contextmanager
def _heard(complaints: list[str]) -> Iterator[None]:
    """Collects VTK's errors, and PyVista's warnings of such errors, instead of letting them be printed.

    One thread at a time: what is changed for that, and put back, is the whole process's.
    """
    with _alone:
        yield from _listened(complaints)


def _listened(complaints: list[str]) -> Iterator[None]:
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
