"""New datasets that share what they have with another, as the outputs of VTK's filters do."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
import pyvista as pv

_Mesh = TypeVar("_Mesh", bound=pv.PolyData)


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
