"""Meshes cut into pieces, and index files that name the pieces, as VTK writes them."""

from functools import partial
from pathlib import Path

import numpy as np
import pyvista as pv
from vtkmodules.vtkIOXML import vtkXMLPPolyDataReader

import pvphong as ph

SCENE = ph.Scene([ph.DirectionalLight(direction=(-1, -2, -3))], ph.Viewer(position=(3, 4, 5)))


def bare(mesh):
    """Return a surface whose only array numbers its faces."""
    surface = mesh.extract_surface(algorithm=None)
    surface.clear_data()
    surface.cell_data["face"] = np.arange(surface.n_cells)
    return surface


def cut(mesh, across=3):
    """Cut a mesh into a grid of pieces by its cells' centres; some pieces meet at corners only."""
    centers = mesh.cell_centers().points
    low, size = centers.min(axis=0), np.ptp(centers, axis=0) * 1.001
    place = (across * (centers - low) / np.where(size, size, 1)).astype(int)
    piece = place[:, 0] + across * place[:, 1]
    return [mesh.extract_cells(np.flatnonzero(piece == each)) for each in np.unique(piece)]


def surfaces(mesh, across=3):
    return [part.extract_surface(algorithm=None) for part in cut(mesh, across)]


def houses(across=6, cells=6):
    """Return a sheet with flat roofs of different heights and with stored normals."""
    side = across * cells
    heights = np.kron(np.random.default_rng(1).random((across, across)), np.pad(np.ones((cells - 2,) * 2), 1))
    sheet = bare(pv.Plane(i_size=across, j_size=across, i_resolution=side, j_resolution=side).triangulate())
    column, row = np.rint((sheet.points[:, :2] + across / 2) * cells).astype(int).T
    sheet.points[:, 2] = 1.5 * np.pad(heights, (0, 1))[row, column]
    sheet.point_data.active_normals = sheet.phong.normals()
    return sheet


def save_pieces(pieces, folder, suffix):
    """Save pieces and an index that names them; return the path of the index."""
    folder = Path(folder)
    (folder / "whole").mkdir(parents=True, exist_ok=True)
    kind = ".vtp" if isinstance(pieces[0], pv.PolyData) else ".vtu"
    names = [f"whole/part_{number}{kind}" for number in range(len(pieces))]
    for name, piece in zip(names, pieces, strict=True):
        piece.save(folder / name)
    index = folder / f"whole{suffix}"
    index.write_text(INDICES[suffix](names))
    return index


def read_whole(path):
    """Read an index with its pieces. PyVista has no reader for .pvtp, so VTK's is used."""
    if Path(path).suffix != ".pvtp":
        return pv.read(path)
    reader = vtkXMLPPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    return pv.wrap(reader.GetOutput())


def as_in_one_piece(pieces, scene, folder="lit/whole"):
    """Assert that lit pieces equal, bit for bit, the mesh lit in one piece by NumPy; return that mesh."""
    whole = pieces[0].append_polydata(*pieces[1:]).phong.shade(scene, components=True, backend="numpy")
    lit = [pv.read(f"{folder}/part_{number}.vtp") for number in range(len(pieces))]
    for name in ("phong", *(name for name in whole.point_data if "visibility" in name or "sky" in name)):
        np.testing.assert_array_equal(np.concatenate([piece[name] for piece in lit]), whole[name])
    return whole


def _file(kind, inner):
    return f'<?xml version="1.0"?>\n<VTKFile type="{kind}" version="1.0">{inner}</VTKFile>\n'


def _pieces(kind, names):
    named = "".join(f'<Piece Source="{name}"/>' for name in names)
    return _file(kind, f'<{kind} GhostLevel="0"><PPoints/>{named}</{kind}>')


def _blocks(names):
    named = [f'<DataSet index="{k}" name="part {k}" file="{name}"/>' for k, name in enumerate(names)]
    deep = f'<Block index="0" name="deep">{named[0]}<DataSet index="9"/></Block>'
    return _file("vtkMultiBlockDataSet", f"<vtkMultiBlockDataSet>{deep}{''.join(named[1:])}</vtkMultiBlockDataSet>")


def series(names, times=None):
    """Return the text of a .pvd file, by default with a single time step."""
    times = times or [0.5] * len(names)
    named = [f'<DataSet timestep="{time}" file="{name}"/>' for name, time in zip(names, times, strict=True)]
    return _file("Collection", f"<Collection>{''.join(named)}</Collection>")


INDICES = {
    ".pvtp": partial(_pieces, "PPolyData"),
    ".pvtu": partial(_pieces, "PUnstructuredGrid"),
    ".vtm": _blocks,
    ".pvd": series,
}
