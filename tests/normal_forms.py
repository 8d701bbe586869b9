"""Both forms in which normals of points are computed: the readable one in NumPy, and the compiled one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pvphong.base import check
from pvphong.geometry.normals import point_normals
from pvphong.shading import kernel


def compiled_normals(points: Any, connectivity: Any, offsets: Any, weighting: Any = "angle") -> Any:
    """By compiled code; what it declines, such as faces of 1e-200 and what is refused, is NumPy's."""
    rows = check.array("points", points)
    found = kernel.point_normals(rows, np.asarray(connectivity), np.asarray(offsets), weighting)
    return point_normals(points, connectivity, offsets, weighting) if found is None else found


FORMS = {"numpy": point_normals} | ({"numba": compiled_normals} if kernel.is_available() else {})

every_form = pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)
