"""What is known at the vertices that are to be lit."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, FloatArray
from pvphong.geometry.extent import Extent
from pvphong.shading import kernel
from pvphong.shading.albedo import checked_albedo
from pvphong.shading.equation import Equation
from pvphong.shading.screen import Screen, channels_for


class Vertices:
    """One record for n vertices, checked: all that evaluators and plans read of them.

    Parameters
    ----------
    points : array_like
        Shape (n, 3), in the mesh's own coordinates. Other types than float32 and float64 are widened.
    normals : array_like, callable or None
        Shape (n, 3), of any length; or what gives them when they are first read, for computing them can cost more
        than lighting. None: they are not known, and the vertices can only be planned for.
    albedo : array_like, optional
        Shape (n, 3): multiplies the material's ambient and diffuse.
    screen : Screen, optional
        What stands before them, for scenes with shadows or ambient occlusion.

    Raises
    ------
    ValueError
        If an array has the wrong shape, type or length; the message names it.
    """

    def __init__(
        self,
        points: Any,
        normals: Any | Callable[[], Any] | None,
        albedo: Any = None,
        screen: Screen | None = None,
    ) -> None:
        self.points: FloatArray = check.array("points", points)
        self._normals = normals if normals is None or callable(normals) else self._checked(normals)
        self.albedo: Any = None if albedo is None else checked_albedo(albedo, len(self.points))
        self.screen = screen

    def __repr__(self) -> str:
        return f"<{len(self)} vertices, {self.points.dtype}>"

    def __len__(self) -> int:
        return len(self.points)

    @cached_property
    def normals(self) -> FloatArray:
        """Shape (n, 3); computed when they are first read."""
        return self._checked(self._normals()) if callable(self._normals) else self._checked(self._normals)

    def _checked(self, normals: Any) -> FloatArray:
        return check.array("normals", normals, count=len(self.points))

    def normals_if(self, needed: bool) -> FloatArray:
        """The normals; zeros in place of such as would have to be computed for an equation that reads none."""
        return (
            self.normals
            if needed or not callable(self._normals)
            else np.broadcast_to(np.zeros(3, np.float32), self.points.shape)
        )

    def channels(self, equation: Equation) -> FloatArray | None:
        """What an equation asks of `screen`, as `Screen.channels` gives it; None where it asks nothing."""
        return channels_for(equation, self.screen)

    def bounds(self, matrix: Float64Array | None) -> Float64Array:
        """x_min, x_max, y_min, y_max, z_min, z_max in the world, of those that are finite; NaN where none is."""
        found = self.extent(matrix).box
        if found is None:
            finite = self.points[np.isfinite(self.points).all(axis=1)]
            found = Extent(finite, None, matrix, kernel.find_bounds).box
        return np.full(6, np.nan) if found is None else np.column_stack(found).ravel()

    def extent(self, matrix: Float64Array | None) -> Extent:
        """Where they are in the world, and where their normals point, found when it is first asked for."""
        known = None if self._normals is None else lambda: self.normals
        return Extent(self.points, known, matrix, kernel.find_bounds)
