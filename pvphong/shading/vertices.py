"""Per-vertex data for lighting."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, FloatArray, IntArray, MatrixLike, rgb
from pvphong.base.vectors import is_direction, unit
from pvphong.geometry.extent import MeshBounds
from pvphong.geometry.transform import transform_vectors
from pvphong.optics.maps import COLORS, Map, Values, fractions, map_values
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
from pvphong.shading.equation import Equation, assemble
from pvphong.shading.visibility import TransportLike, VisibilityAt, VisibilityLike

_TO_TANGENTS = (
    "Name a point array of vectors along the surface, or give the mesh texture coordinates whose u varies everywhere."
)

_TO_VISIBILITY = "Pass visibility=mesh.phong.visibility(scene), or call mesh.phong.shade, which casts the rays."


class Tint(NamedTuple):
    """A map of colours, as factors: the map's rows, divided by a bound on them."""

    name: str
    """Name of the field that the map replaces."""
    rows: Any
    """Shape (n, 1) or (n, 3), uint8, float32 or float64, as `pvphong.optics.maps.checked` returns them."""
    most: float
    """The bound by which the rows are divided, a power of two."""

    def at(self, part: Any) -> Tint:
        """Return the tint of some of the vertices; `part` is a slice or an index array."""
        return self._replace(rows=self.rows[part])

    def factors(self, real: Any) -> FloatArray:
        """Return the factors, shape (3, n), in the NumPy type `real`."""
        rows = fractions(self.name, self.rows, real)
        return np.asarray(np.broadcast_to(rows.T, (3, len(rows))) * real(1.0 / self.most))


class Vertices:
    """Checked data of n vertices, as evaluators and plans read them.

    Parameters
    ----------
    points : array_like
        Shape (n, 3), in the mesh's own coordinates. Other types than float32 and float64 are widened.
    normals : array_like, callable or None
        Shape (n, 3), of any length; or a function that returns them, called at the first use because computing normals
        can cost more than lighting. None if unknown; such vertices can be planned for, but not lit.
    maps : mapping, optional
        Values per vertex of fields of the material or its reflectance: field → array or `Map`; see
        `pvphong.optics.maps`.
    tangents : array_like or callable, optional
        Shape (n, 3), of any length but 0: directions along the surface, for anisotropic reflectances; or a function
        that returns them, called at the first use as for normals.
    visibility : VisibilityLike, optional
        Visibility of lights and sky, for scenes with shadows or ambient occlusion.
    transport : TransportLike, optional
        Light transport between the vertices, for scenes with bounces.
    ranges : mapping, optional
        The attribute `ranges` of a larger set of vertices that includes these. The equation is then that of the larger
        set.

    Raises
    ------
    ValueError
        If an array has the wrong shape, type or length; the message names the array.
    """

    def __init__(
        self,
        points: Any,
        normals: Any | Callable[[], Any] | None,
        maps: Mapping[str, Any] = MappingProxyType({}),
        visibility: VisibilityLike | None = None,
        *,
        tangents: Any | Callable[[], Any] | None = None,
        transport: TransportLike | None = None,
        ranges: Mapping[str, tuple[float, float]] | None = None,
    ) -> None:
        self.points: FloatArray = check.array("points", points)
        self._normals = normals if callable(normals) else self._checked("normals", normals)
        self.maps: dict[str, Values] = {name: map_values(name, value, len(self.points)) for name, value in maps.items()}
        self.visibility, self.transport = visibility, transport
        self._ranges = ranges
        self._tangents = tangents if callable(tangents) else self._checked("tangents", tangents)

    @classmethod
    def of_all(cls, parts: Sequence[Vertices]) -> Vertices:
        """Concatenate the points and normals of several records. Their other data is left out."""
        points = np.concatenate([part.points for part in parts])
        return cls(points, lambda: np.concatenate([part.normals for part in parts]))

    def some(self, rows: IntArray) -> Vertices:
        """Return some of the vertices, for the plan of all. `rows` are their indices. Transport is left out."""
        seen = None if self.visibility is None else VisibilityAt(self.visibility, rows)
        how: dict[str, Any] = {"tangents": lambda: self.tangents[rows], "ranges": self.ranges}
        part = Vertices(self.points[rows], lambda: self.normals[rows], visibility=seen, **how)
        part.maps = {name: values._replace(rows=values.rows[rows]) for name, values in self.maps.items()}
        return part

    def __repr__(self) -> str:
        return f"<{len(self)} vertices, {self.points.dtype}>"

    def __len__(self) -> int:
        return len(self.points)

    @cached_property
    def normals(self) -> FloatArray:
        """Normals, shape (n, 3), computed when they are first read."""
        given = self._normals() if callable(self._normals) else self._normals
        return check.array("normals", given, count=len(self.points))

    @cached_property
    def tangents(self) -> FloatArray:
        """Tangents, shape (n, 3), computed when they are first read.

        Raises
        ------
        ValueError
            If there are no tangents, or if a vertex has a normal but its tangent is zero or not finite.
        """
        given = self._tangents() if callable(self._tangents) else self._tangents
        if given is None:
            check.refuse("tangents", None, "known for this reflectance", _TO_TANGENTS)
        tangents = check.array("tangents", given, count=len(self.points))
        is_bad = is_direction(self.normals.T) & ~is_direction(tangents.T)
        if is_bad.any():
            first = int(np.argmax(is_bad))
            got = f"{tangents[first].tolist()} at vertex {first}"
            check.refuse("tangents", got, "finite vectors other than zero", _TO_TANGENTS)
        return tangents

    def _checked(self, name: str, vectors: Any) -> Any:
        if isinstance(vectors, Map):
            vectors = vectors.source
        if isinstance(vectors, str):
            check.refuse(name, vectors, "an array of shape (n, 3), because array names need a mesh")
        return None if vectors is None else check.array(name, vectors, count=len(self.points))

    def normals_if(self, needed: bool) -> FloatArray:
        """Return the normals. If `needed` is False and the normals would have to be computed first, return zeros."""
        if needed or not callable(self._normals):
            return self.normals
        return np.broadcast_to(np.zeros(3, np.float32), self.points.shape)

    def tints(self, equation: Equation) -> dict[str, Tint]:
        """Return the maps of colours that an equation reads, by the name of the field that each replaces."""
        return self.tints_of(equation.needed_tints)

    def tints_of(self, names: Iterable[str]) -> dict[str, Tint]:
        """Return the maps of colours for the fields in `names`, by field."""
        return {name: Tint(name, self.maps[name].rows, self.maps[name].most) for name in names}

    def without_maps(self, material: Material) -> Material:
        """Return a copy of a material in which each map is replaced by a bound on its values."""
        return material.with_values({name: values.most for name, values in self.maps.items()})

    def sending(self, colors: FloatArray, material: Material) -> Vertices:
        """Return these vertices with `colors`, shape (n, 3), added to the material's emission, as a map of emission."""
        emitted = self.maps.get("emission")
        own = rgb(material.emission) if emitted is None else fractions("emission", emitted.rows)
        maps = {name: values.rows for name, values in self.maps.items()} | {"emission": colors + own}
        how: Any = {"tangents": self._tangents, "transport": self.transport, "ranges": self._ranges}
        return Vertices(self.points, self._normals, maps, self.visibility, **how)

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Least and greatest value of each map, except maps of colours."""
        own = {name: (values.least, values.most) for name, values in self.maps.items() if name not in COLORS}
        return own | dict(self._ranges or {})

    def equation(self, scene: Scene, material: Material, matrix: MatrixLike | None) -> Equation:
        """Return the whole lighting equation of a scene and a material, with the maps of these vertices.

        Raises
        ------
        ValueError
            As for `assemble`.
        """
        tints = frozenset(self.maps).intersection(COLORS)
        return assemble(scene, self.without_maps(material), matrix, self.ranges, tints)

    def channels(self, equation: Equation) -> FloatArray | None:
        """Return the numbers per vertex that an equation reads, shape (k, n), with rows as in `Equation.channels`.

        Return None if the equation reads none.
        Tangents are unit vectors in the world. They are transformed like differences of points.

        Raises
        ------
        ValueError
            If the equation needs visibility, but these vertices have none.
        """
        kinds: list[FloatArray] = []
        for kind in equation.channels:
            if kind == "visibility":
                if self.visibility is None:
                    allowed = "given for a light model with shadows or ambient occlusion"
                    check.refuse("visibility", None, allowed, _TO_VISIBILITY)
                how = {"sky": equation.is_occluded, "behind": equation.is_flipped}
                kinds.append(self.visibility.channels(equation.shadowed, **how))
            elif kind == "tangents":
                matrix = equation.matrix
                kinds.append(unit((self.tangents if matrix is None else transform_vectors(self.tangents, matrix)).T)[0])
            else:
                kinds.append(self.maps[kind].rows.T)
        return np.concatenate(kinds) if len(kinds) > 1 else next(iter(kinds), None)

    def bounds(self, matrix: MatrixLike | None) -> Float64Array:
        """Return x_min, x_max, y_min, y_max, z_min, z_max of the finite vertices in the world; NaN if none is finite.

        Raises
        ------
        ValueError
            If the matrix is not a valid model matrix.
        """
        placed = None if matrix is None else check.matrix4("matrix", matrix)
        found = self.extent(placed).box
        if found is None:
            finite = self.points[np.isfinite(self.points).all(axis=1)]
            found = MeshBounds(finite, None, placed).box
        return np.full(6, np.nan) if found is None else np.column_stack(found).ravel()

    def extent(self, matrix: Float64Array | None) -> MeshBounds:
        """Return bounds on the vertices' positions and normals in the world. They are computed when first used."""
        known = None if self._normals is None else lambda: self.normals
        return MeshBounds(self.points, known, matrix)
