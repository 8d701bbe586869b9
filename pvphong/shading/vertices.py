"""What is known at the vertices that are to be lit."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array, FloatArray, MatrixLike, rgb
from pvphong.base.vectors import is_direction, unit
from pvphong.geometry.extent import Extent
from pvphong.geometry.transform import transform_vectors
from pvphong.optics.maps import COLORS, Map, Values, fractions, map_values
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
from pvphong.shading.equation import Equation, assemble
from pvphong.shading.visibility import TransportLike, VisibilityLike

_TO_TANGENTS = (
    "Name a point array of vectors along the surface, or give the mesh texture coordinates whose u changes everywhere."
)

_TO_VISIBILITY = "mesh.phong.shade casts the rays itself; evaluate takes visibility=mesh.phong.visibility(scene)."


class Tint(NamedTuple):
    """What colours are multiplied by at each vertex: rows of a map over the greatest of them."""

    name: str
    """The field whose map it is."""
    rows: Any
    """Shape (n, 1) or (n, 3), uint8, float32 or float64, as `pvphong.optics.maps.checked` gives them."""
    most: float
    """A power of two."""

    def at(self, part: Any) -> Tint:
        """The tint of some of the vertices."""
        return self._replace(rows=self.rows[part])

    def factors(self, real: Any) -> FloatArray:
        """Shape (3, n)."""
        rows = fractions(self.name, self.rows, real)
        return np.asarray(np.broadcast_to(rows.T, (3, len(rows))) * real(1.0 / self.most))


class Vertices:
    """One record for n vertices, checked: all that evaluators and plans read of them.

    Parameters
    ----------
    points : array_like
        Shape (n, 3), in the mesh's own coordinates. Other types than float32 and float64 are widened.
    normals : array_like, callable or None
        Shape (n, 3), of any length; or what gives them when they are first read, for computing them can cost more
        than lighting. None: they are not known, and the vertices can only be planned for.
    maps : mapping, optional
        Field of the material or its reflectance → what it is at each vertex, an array or a `Map`; see
        `pvphong.optics.maps`.
    tangents : array_like or callable, optional
        Shape (n, 3), of any length but 0: directions along the surface, for reflectances that are not the same in all
        of them; or what gives them, as for normals.
    visibility : VisibilityLike, optional
        What they see of lights and sky, for scenes with shadows or ambient occlusion.
    transport : TransportLike, optional
        What they see of each other, for scenes in which light bounces.
    ranges : mapping, optional
        As the attribute, of more vertices, of which these are some: the equation is theirs.

    Raises
    ------
    ValueError
        If an array has the wrong shape, type or length; the message names it.
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
        """The vertices of several records, one after the other; of these only points and normals count."""
        points = np.concatenate([part.points for part in parts])
        return cls(points, lambda: np.concatenate([part.normals for part in parts]))

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
        is_bad = is_direction(self.normals.T) & ~is_direction(tangents.T)
        if is_bad.any():
            first = int(np.argmax(is_bad))
            got = f"{tangents[first].tolist()} at vertex {first}"
            check.refuse("tangents", got, "finite vectors that are not zero", _TO_TANGENTS)
        return tangents

    def _checked(self, name: str, vectors: Any) -> Any:
        if isinstance(vectors, Map):
            vectors = vectors.source
        if isinstance(vectors, str):
            check.refuse(name, vectors, "an array where there is no mesh, shape (n, 3)")
        return None if vectors is None else check.array(name, vectors, count=len(self.points))

    def normals_if(self, needed: bool) -> FloatArray:
        """The normals; zeros in place of such as would have to be computed for an equation that reads none."""
        if needed or not callable(self._normals):
            return self.normals
        return np.broadcast_to(np.zeros(3, np.float32), self.points.shape)

    def tints(self, equation: Equation) -> dict[str, Tint]:
        """What is multiplied by colours at each vertex, of what an equation reads."""
        return self.tints_of(equation.needed_tints)

    def tints_of(self, names: Iterable[str]) -> dict[str, Tint]:
        """What is multiplied by colours at each vertex, of some maps of colours."""
        return {name: Tint(name, self.maps[name].rows, self.maps[name].most) for name in names}

    def without_maps(self, material: Material) -> Material:
        """The material with no less than any vertex has, in place of its maps."""
        return material.with_values({name: values.most for name, values in self.maps.items()})

    def sending(self, colors: FloatArray, material: Material) -> Vertices:
        """The same vertices; they send colours, shape (n, 3), beside what the material has them emit."""
        emitted = self.maps.get("emission")
        own = rgb(material.emission) if emitted is None else fractions("emission", emitted.rows)
        maps = {name: values.rows for name, values in self.maps.items()} | {"emission": colors + own}
        how: Any = {"tangents": self._tangents, "transport": self.transport, "ranges": self._ranges}
        return Vertices(self.points, self._normals, maps, self.visibility, **how)

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """The least and the greatest of the numbers that are no colours, of each map."""
        own = {name: (values.least, values.most) for name, values in self.maps.items() if name not in COLORS}
        return own | dict(self._ranges or {})

    def equation(self, scene: Scene, material: Material, matrix: MatrixLike | None) -> Equation:
        """The whole lighting equation of a scene and a material whose maps these are.

        Raises
        ------
        ValueError
            As `assemble`.
        """
        tints = frozenset(self.maps).intersection(COLORS)
        return assemble(scene, self.without_maps(material), matrix, self.ranges, tints)

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
                how = {"sky": equation.is_occluded, "behind": equation.is_flipped}
                kinds.append(self.visibility.channels(equation.shadowed, **how))
            elif kind == "tangents":
                matrix = equation.matrix
                kinds.append(unit((self.tangents if matrix is None else transform_vectors(self.tangents, matrix)).T)[0])
            else:
                kinds.append(self.maps[kind].rows.T)
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
