"""New datasets that share what they have with another, as the outputs of VTK's filters do."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
import pyvista as pv

_Mesh = TypeVar("_Mesh", bound=pv.PolyData)


def in_range(mesh: pv.DataSet, name: str) -> pv.DataSet:
    """A mesh whose colours can be drawn: VTK draws what is above 1 as something else altogether, so that is clipped.

    Parameters
    ----------
    mesh : pyvista.DataSet
        It has colours as the point array `name`; it is not modified, and shares all else with the result.
    name : str
        Of floats, or of uint8, which stay as they are.
    """
    result, colors = mesh.copy(deep=False), np.asarray(mesh.point_data[name])
    if colors.dtype != np.uint8:
        result.point_data[name] = np.clip(np.nan_to_num(colors), 0.0, 1.0)
    return result


def sharing(mesh: _Mesh) -> _Mesh:
    """A new mesh with the points, cells and arrays of another, none of them copied.

    Arrays that are added, replaced or removed, and points, cells and active arrays that are set, are the one mesh's
    alone. What is written into an array that both have is seen in both, and so is its name.
    """
    result = type(mesh)()
    result.shallow_copy(mesh)
    result.copy_meta_from(mesh, deep=True)  # not by `copy`: an array that is set would end another's being of bools
    # PyVista sets points inside of VTK's object, which is therefore not to be the same one; nor is its array, for that
    # would count as modified by being put into another.
    result.SetPoints(pv.vtk_points(np.asarray(result.points), deep=False, force_float=False))
    return result
