"""Type aliases for arrays, vectors and options in pvphong's signatures."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

Float64Array = NDArray[np.float64]
FloatArray = NDArray[np.floating[Any]]
IntArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]
ByteArray = NDArray[np.uint8]

Vector = tuple[float, float, float]
"""A point, a direction or a colour: three finite floats."""

VectorLike = Sequence[float] | NDArray[Any]

Color = float | Vector
"""A linear reflectance or light colour: one float for grey, or red, green, blue."""

ColorLike = float | str | Sequence[float] | NDArray[Any]

MatrixLike = ArrayLike
"""Anything that `check.matrix4` converts to a (4, 4) float64 array."""

Frame = Literal["world", "camera", "headlight"]
Reflection = Literal["phong", "blinn-phong"]
Convention = Literal["standard", "vtk"]
Precision = Literal["float32", "float64"]
Backend = Literal["auto", "numpy", "numba"]
Weighting = Literal["angle", "area", "max"]


def rgb(color: ColorLike) -> Vector:
    """Return red, green and blue of a colour that `check.color` has returned; a single float is a grey."""
    if isinstance(color, float):
        return color, color, color
    red, green, blue = cast("Vector", color)
    return red, green, blue


class InitSignature:
    """Descriptor for a class's `__signature__`, by which `inspect` shows the parameters of `__init__`.

    By default, `inspect` would show those of `__new__`.
    """

    def __get__(self, _instance: object, kind: type) -> inspect.Signature:
        whole = inspect.signature(getattr(kind, "__init__"))  # noqa: B009 mypy refuses `kind.__init__`
        return whole.replace(parameters=list(whole.parameters.values())[1:])
