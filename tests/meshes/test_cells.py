"""Cell arrays: refusals, and one check per modification of a PolyData, in bounded memory."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import pyvista as pv
from soups import faces_of
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from pvphong.meshes import cells as cells_module
from pvphong.meshes.cells import cells, invalid_cells, refuse_invalid
from pvphong.meshes.surfaces import polygons

STORAGES = ["Use32BitStorage", "Use64BitStorage", "UseFixedSize32BitStorage", "UseFixedSize64BitStorage"]
every_storage = pytest.mark.parametrize("storage", STORAGES)


def faces(storage, *triples):
    array = pv.CellArray()
    getattr(array, storage)(*[3] * ("Fixed" in storage))
    for triple in triples:
        array.InsertNextCell(3, triple)
    return array


def surface_of(array, n_points=4):
    mesh = pv.PolyData()
    mesh.points = np.random.default_rng(2).normal(size=(n_points, 3))
    mesh.SetPolys(array)
    return mesh


@every_storage
def test_faces_are_read_into_arrays_of_the_callers_own(storage):
    mesh = surface_of(faces(storage, (0, 1, 3), (1, 2, 3)))
    connectivity, offsets = polygons(mesh)
    assert connectivity.dtype == offsets.dtype == np.int64
    connectivity[:], offsets[:] = 0, 0
    assert faces_of(mesh) == [[0, 1, 3], [1, 2, 3]]


@every_storage
@pytest.mark.parametrize("index", [-1, 4, 2**31 - 1, -(2**31)])
def test_an_index_that_is_no_points_is_found_in_every_storage(storage, index):
    mesh = surface_of(faces(storage, (0, 1, 2), (1, 2, 3), (3, index, 0)))
    assert invalid_cells(mesh).tolist() == [2]
    with pytest.raises(ValueError, match=f"index {index} in face 2"):
        refuse_invalid(mesh)


@every_storage
def test_an_edition_is_checked_once_and_the_next_one_anew(storage):
    grid = pv.ImageData(dimensions=(3, 3, 3)).cast_to_unstructured_grid()
    refuse_invalid(grid)
    vtk_to_numpy(grid.GetCells().GetConnectivityArray())[1] = 99
    with pytest.raises(ValueError, match="index 99 in cell 0"):  # cells of a grid are checked each time
        refuse_invalid(grid)
    mesh = surface_of(faces(storage, (0, 1, 2), (1, 2, 3)))
    refuse_invalid(mesh)
    vtk_to_numpy(mesh.GetPolys().GetConnectivityArray())[1] = 9
    refuse_invalid(mesh)  # the change was not announced with Modified()
    mesh.GetPolys().GetConnectivityArray().Modified()
    for _ in range(2):  # errors are not remembered
        with pytest.raises(ValueError, match="index 9 in face 0"):
            refuse_invalid(mesh)
    vtk_to_numpy(mesh.GetPolys().GetConnectivityArray())[1] = 1
    refuse_invalid(mesh)


@every_storage
def test_fewer_points_other_arrays_and_more_cells_are_checked_anew(storage):
    array = faces(storage, (0, 1, 2), (1, 2, 3))
    mesh = surface_of(array)
    refuse_invalid(mesh)
    mesh.points = np.zeros((3, 3))
    with pytest.raises(ValueError, match="index 3 in face 1"):
        refuse_invalid(mesh)
    mesh.points = np.zeros((4, 3))
    array.InsertNextCell(3, (0, 1, 7))  # VTK does not count this as a modification
    with pytest.raises(ValueError, match="index 7 in face 2"):
        refuse_invalid(mesh)
    with pytest.raises(ValueError, match="index 5 in face 0"):
        refuse_invalid(surface_of(faces(storage, (0, 1, 5))))


def test_cells_of_a_type_that_vtk_has_not_are_refused():
    grid = pv.ImageData(dimensions=(3, 2, 2)).cast_to_unstructured_grid()
    kinds = grid.celltypes.copy()
    kinds[1] = 255
    grid.SetCells(pv.convert_array(kinds), grid.GetCells())
    assert cells_module.invalid_cells(grid).tolist() == [1]
    with pytest.raises(ValueError, match=r"^mesh must be .*; got cell 1 of type 255"):
        refuse_invalid(grid)


def test_coordinates_that_do_not_fit_the_dimensions_are_refused():
    grid = pv.RectilinearGrid([0.0, 1.0], [0.0, 1.0, 2.0], [0.0, 1.0])
    refuse_invalid(grid)
    grid.GetYCoordinates().SetNumberOfTuples(2)
    with pytest.raises(ValueError, match=r"got \(2, 2, 2\) coordinates in dimensions \(2, 3, 2\)"):
        refuse_invalid(grid)


@pytest.mark.parametrize("at", range(1, 8))
def test_offsets_that_fall_are_refused_wherever_it_is(at, monkeypatch):
    monkeypatch.setattr(cells_module, "_AT_ONCE", 3)
    array = faces("Use64BitStorage", *[(0, 1, 2)] * 8)
    cells(surface_of(array))
    vtk_to_numpy(array.GetOffsetsArray())[at] = 3 * at + 4
    array.Modified()
    with pytest.raises(ValueError, match="offsets"):
        cells(surface_of(array))


def test_what_is_remembered_is_bounded_and_shared_by_threads():
    def checked(_):
        refuse_invalid(surface_of(faces("Use64BitStorage", (0, 1, 2))))
        return len(cells_module._in_order)

    with ThreadPoolExecutor(4) as threads:
        sizes = list(threads.map(checked, range(2 * cells_module._REMEMBERED)))
    assert max(sizes) <= cells_module._REMEMBERED + 4  # one more for each thread that is adding its entry
    assert len(cells_module._in_order) == cells_module._REMEMBERED


@pytest.mark.parametrize(
    ("offsets", "indices", "message"),
    [
        ([3, 6], np.arange(6) % 4, r"face offsets rise from 0 to 6.* got offsets from 3 to 6"),
        ([0, 5, 10**9], np.arange(6) % 4, "face offsets rise from 0 to 6"),
        ([0, 3], np.array([0.0, 1.0, 2.0]), "face indices of type float64"),  # VTK reads these from a damaged file
    ],
)
def test_offsets_that_do_not_begin_at_0_or_reach_too_far_and_indices_that_are_no_integers_are_refused(
    offsets, indices, message
):
    array = pv.CellArray()
    array.SetData(numpy_to_vtk(np.array(offsets)), numpy_to_vtk(indices))
    with pytest.raises(ValueError, match=message):
        cells(surface_of(array))
