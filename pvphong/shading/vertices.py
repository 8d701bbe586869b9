"""What is known at the vertices that are to be lit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.base.types import BoolArray, Float64Array, FloatArray, MatrixLike, Vector
from pvphong.base.vectors import unit
from pvphong.geometry.extent import Extent
from pvphong.geometry.transform import transform_vectors
from pvphong.optics.material import Material
from pvphong.shading.equation import Equation
from pvphong.shading.visibility import VisibilityLike

_TO_TANGENTS = (
    "Name a point array of vectors along the surface, or give the mesh texture coordinates whose u changes everywhere."
)

_TO_VISIBILITY = "mesh.phong.shade casts the rays itself; evaluate takes visibility=mesh.phong.visibility(scene)."


def _is_direction(vectors: FloatArray) -> BoolArray:
    """Where rows are directions: finite, and not zero."""
    x, y, z = vectors.T  # by columns it takes a tenth of the time
    return np.asarray(np.isfinite(x) & np.isfinite(y) & np.isfinite(z) & ((x != 0.0) | (y != 0.0) | (z != 0.0)))


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
    tangents : array_like or callable, optional
        Shape (n, 3), of any length but 0: directions along the surface, for reflectances that are not the same in all
        of them; or what gives them, as for normals.
    maps : mapping, optional
        What of the material is given vertex by vertex, as `Maps` takes it.
    visibility : VisibilityLike, optional
        What they see of lights and sky, for scenes with shadows or ambient occlusion.

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
        visibility: VisibilityLike | None = None,
        *,
        tangents: Any | Callable[[], Any] | None = None,
        maps: Mapping[str, Any] = MappingProxyType({}),
    ) -> None:
        self.points: FloatArray = check.array("points", points)
        self._normals = normals if callable(normals) else self._checked("normals", normals)
        self.albedo: Any = None if albedo is None else checked_albedo(albedo, len(self.points))
        self.visibility = visibility
        self.maps = Maps(maps, len(self.points))
        self._tangents = tangents if callable(tangents) else self._checked("tangents", tangents)

    def __repr__(self) -> str:
        return f"<{len(self)} vertices, {self.points.dtype}>"

    def __len__(self) -> int:
        return len(self.points)

    @cached_property
    def normals(self) -> FloatArray:
        """Shape (n, 3); computed when they are first read."""
        given = self._normals() if callable(self._normals) else self._normals
        return check.array("normals", given, count=len(self.points))

    @cached_property
    def tangents(self) -> FloatArray:
        """Shape (n, 3); computed when they are first read.

        Raises
        ------
        ValueError
            If there are none, or one of a vertex that has a normal is zero or not finite.
        """
        given = self._tangents() if callable(self._tangents) else self._tangents
        if given is None:
            check.refuse("tangents", None, "known for this reflectance", _TO_TANGENTS)
        tangents = check.array("tangents", given, count=len(self.points))
        is_bad = _is_direction(self.normals) & ~_is_direction(tangents)
        if is_bad.any():
            first = int(np.argmax(is_bad))
            got = f"{tangents[first].tolist()} at vertex {first}"
            check.refuse("tangents", got, "finite vectors that are not zero", _TO_TANGENTS)
        return tangents

    def _checked(self, name: str, vectors: Any) -> Any:
        return None if vectors is None else check.array(name, vectors, count=len(self.points))

    def normals_if(self, needed: bool) -> FloatArray:
        """The normals; zeros in place of such as would have to be computed for an equation that reads none."""
        if needed or not callable(self._normals):
            return self.normals
        return np.broadcast_to(np.zeros(3, np.float32), self.points.shape)

    def channels(self, equation: Equation) -> FloatArray | None:
        """Numbers at each vertex, a kind a row, as `Equation.channels` says; None where an equation reads none.

        Tangents are unit vectors in the world, where they go as differences of points do.

        Raises
        ------
        ValueError
            If it reads what they see of lights or sky, and that is not known.
        """
        kinds: list[FloatArray] = []
        for kind in equation.channels:
            if kind == "visibility":
                if self.visibility is None:
                    allowed = "without shadows and ambient occlusion where only points are known"
                    check.refuse("light_model", "one with them", allowed, _TO_VISIBILITY)
                kinds.append(self.visibility.channels(equation.shadowed, sky=equation.is_occluded))
            elif kind == "tangents":
                matrix = equation.matrix
                kinds.append(unit((self.tangents if matrix is None else transform_vectors(self.tangents, matrix)).T)[0])
            else:
                kinds.append(self.maps.rows(kind))
        return np.concatenate(kinds) if len(kinds) > 1 else next(iter(kinds), None)

    def bounds(self, matrix: MatrixLike | None) -> Float64Array:
        """x_min, x_max, y_min, y_max, z_min, z_max in the world, of those that are finite; NaN where none is.

        Raises
        ------
        ValueError
            If the matrix is no such thing.
        """
        placed = None if matrix is None else check.matrix4("matrix", matrix)
        found = self.extent(placed).box
        if found is None:
            finite = self.points[np.isfinite(self.points).all(axis=1)]
            found = Extent(finite, None, placed).box
        return np.full(6, np.nan) if found is None else np.column_stack(found).ravel()

    def extent(self, matrix: Float64Array | None) -> Extent:
        """Where they are in the world, and where their normals point, found when it is first used."""
        known = None if self._normals is None else lambda: self.normals
        return Extent(self.points, known, matrix)


# --- what of a material is given vertex by vertex


_COLOR = "specular"
_BOUNDS = {_COLOR: (0.0, 16.0), "shininess": (0.0, np.inf), "roughness": (np.nextafter(0.0, 1.0), 1.0)}
_ALLOWED = {
    _COLOR: "reflectances from 0, of which 1 is all, to 16, shape (n,) or (n, 3)",
    "shininess": "finite numbers >= 0, shape (n,)",
    "roughness": "numbers > 0 and <= 1, shape (n,)",
}


class Maps:
    """Numbers of n vertices that replace a material's or its reflectance's.

    Parameters
    ----------
    given : mapping
        "specular", "shininess" or "roughness" → array with a number for each vertex, of "specular" a number or three;
        or None.
    count : int
        How many vertices there are.

    Raises
    ------
    ValueError
        If an array has another shape or length, or a number in it is not allowed; the message names it.
    """

    def __init__(self, given: Mapping[str, Any], count: int) -> None:
        self._rows = {k: checked_map(k, value, count).T for k, value in given.items() if value is not None}

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """The least and the greatest number of each that is given; for specular, of its `rows`."""
        found = {name: rows if rows.size else np.ones(1) for name, rows in self._rows.items()}
        return {name: (0.0, 1.0) if name == _COLOR else (float(x.min()), float(x.max())) for name, x in found.items()}

    def brightest(self, material: Material) -> Material:
        """The material with no less than any of the specular reflectances, channel by channel."""
        return replace(material, specular=self._most) if _COLOR in self._rows else material

    def rows(self, name: str) -> FloatArray:
        """Shape (1, n); of specular (3, n), as parts of the brightest."""
        rows = self._rows[name]
        if name != _COLOR:
            return rows
        most = np.array(self._most)[:, None]
        return np.divide(rows, most, out=np.zeros((3, rows.shape[1]), rows.dtype), where=most > 0.0)

    @property
    def _most(self) -> Vector:
        """Powers of two, so that no vertex's bits depend on the others'."""
        largest = np.broadcast_to(self._rows[_COLOR].max(axis=1, initial=0.0).astype(np.float64), 3)
        mantissas, exponents = np.frexp(largest)
        red, green, blue = np.ldexp(np.sign(mantissas), exponents - (mantissas == 0.5)).tolist()
        return red, green, blue


def checked_map(name: str, value: Any, count: int) -> FloatArray:
    """An (n, 1) or (n, 3) array of float32 or float64."""
    allowed = _ALLOWED[name]
    given = check.real_array(name, value, allowed)
    if name == _COLOR and given.dtype == np.uint8:
        given = given / 255.0
    numbers = given[:, None] if given.ndim == 1 else given
    if numbers.ndim != 2 or numbers.shape[1] not in ((1, 3) if name == _COLOR else (1,)):
        check.refuse(name, f"an array of shape {given.shape}", allowed)
    if len(numbers) != count:
        check.refuse(name, f"{len(numbers)} numbers", f"one per point, {count}")
    numbers = numbers if numbers.dtype in (np.float32, np.float64) else numbers.astype(np.float64)
    low, high = _BOUNDS[name]
    is_bad = ~(np.isfinite(numbers) & (numbers >= low) & (numbers <= high)).all(axis=1)
    if is_bad.any():
        first = int(np.argmax(is_bad))
        check.refuse(name, f"{numbers[first].tolist()} at vertex {first}", allowed)
    return numbers


# --- albedo: what the material's ambient and diffuse are multiplied by


# Colours that were computed may be above 1 by rounding; what is more is 0-255 in disguise.
_MOST = 1.001


def checked_albedo(value: Any, count: int) -> Any:
    """An (n, 3) array of uint8, float32 or float64, one row for each of `count` vertices; copied only if it has to be.

    Raises
    ------
    ValueError
        For another shape, another number of rows, integers other than uint8, or what is no number.
    """
    given = check.real_array("albedo", value, "an (n, 3) array of real numbers")
    if given.ndim == 2 and given.shape[1] == 4:
        check.refuse("albedo", f"an array of shape {given.shape}", "of shape (n, 3)", "Leave out the opacity: [:, :3].")
    if given.dtype.kind in "iu" and given.dtype != np.uint8:
        remedy = "Convert 0-255 to uint8, or divide it by 255."
        check.refuse("albedo", f"an array of {given.dtype}", "uint8 or floats", remedy)
    checked = check.rows if given.dtype == np.uint8 else check.array
    albedo = checked("albedo", given, count=count)
    if given.dtype != np.uint8 and len(albedo) and np.fmax.reduce(albedo, axis=None) > _MOST:
        remedy = "Divide 0-255 by 255, or convert it to uint8."
        check.refuse("albedo", f"floats up to {np.fmax.reduce(albedo, axis=None):g}", "floats from 0 to 1", remedy)
    return albedo


def reflectances(albedo: Any) -> FloatArray:
    """Rows of a checked albedo as numbers in [0, 1]: uint8 counts as 0-255, floats are clipped, a NaN counts as 0."""
    if albedo.dtype == np.uint8:
        return albedo / 255.0
    return np.fmin(np.fmax(albedo, 0.0), 1.0)  # fmax takes 0 before a NaN
