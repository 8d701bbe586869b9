"""Reading a mesh through a process of its own, which a reader may crash without harm."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import tempfile
from pathlib import Path

import pyvista as pv

from pvphong.base import check
from pvphong.base.processes import Watch, begin_work, reading
from pvphong.meshes.files import read_mesh

_CHILD = "import sys; from pvphong.meshes.guarded import hand_over; hand_over(*sys.argv[1:])"


def read(path: str | os.PathLike[str], *, guarded: bool = False) -> pv.DataSet | pv.MultiBlock:
    """The mesh in a file of any format that PyVista reads, if the file is whole.

    `pyvista.read` takes what it can get of a damaged file, and prints what it thinks of it; this takes all or nothing.

    Parameters
    ----------
    path : path
        The file.
    guarded : bool, default False
        Read it in another process and hand the mesh over: some of VTK's readers crash, or come to no end, with files
        that are damaged. It takes about a second longer. The other process is killed when it has not got anything
        from a disk for a minute, and a second more for each megabyte of the file.

    Returns
    -------
    pyvista.DataSet or pyvista.MultiBlock

    Raises
    ------
    ValueError
        If the file is not there, is not whole, or holds no mesh; or if its reader crashes, where that is guarded.
    """
    if not check.flag("guarded", guarded):
        return read_mesh(os.fspath(path))
    if os.name != "posix" or not Path(sys.executable or "").name.startswith("python"):
        check.refuse("guarded", guarded, "False where Python cannot start itself in another process")
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder, "mesh")
        said = _in_a_child(os.fspath(path), result)
        if said:
            raise ValueError(said)
        mesh: pv.DataSet | pv.MultiBlock = pickle.loads(result.read_bytes())
        return mesh


def _in_a_child(path: str, result: Path) -> str:
    """Have a mesh read and put into a file; what went wrong comes back, "" for nothing."""
    listening, speaking = os.pipe()
    child = subprocess.Popen(
        [sys.executable, "-W", "ignore", "-c", _CHILD, path, str(result), str(speaking)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        pass_fds=[speaking],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(entry or os.getcwd() for entry in sys.path)},
    )
    os.close(speaking)
    with child, os.fdopen(listening):
        watch = Watch(listening, child.pid)
        watch.until_it_ends()
        said, _ = child.communicate()
    if child.returncode == 0:
        return said.decode(errors="surrogateescape")
    return watch.failure(child.returncode)


def hand_over(path: str, result: str, end: str) -> None:
    """What the child does: print why the mesh cannot be read, or put it into a file."""
    begin_work(int(end))
    try:
        with reading(path):
            mesh = read_mesh(path)
            Path(result).write_bytes(pickle.dumps(mesh, protocol=5))
    except ValueError as error:
        sys.stdout.reconfigure(errors="surrogateescape")  # type: ignore[union-attr]
        print(error, end="")
