"""The probe: the lit value of the vertex nearest to a point, and the contribution of each light to it."""

from __future__ import annotations

import weakref
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from vtkmodules.vtkCommonCore import mutable
from vtkmodules.vtkCommonDataModel import vtkGenericCell, vtkStaticCellLocator

from pvphong.base.types import Float64Array, Vector, VectorLike
from pvphong.geometry.transform import transform_points
from pvphong.scene.scene import Scene, light_labels
from pvphong.shading.reference import Shading
from pvphong.studio.lit_mesh import LitMesh


@dataclass(frozen=True, eq=False, repr=False)
class Probe:
    """The lit value of a vertex and each light's contribution (its share), from `plotter.phong.probe(point)`.

    All colours are linear RGB, where 1 is full intensity. `base`, `shares` and `bounced` are not clamped. They add up
    to the colour before clamping.

    Attributes
    ----------
    mesh : str
        Name of the actor; "" if none was given.
    point_id : int
        Index of the vertex in the drawn surface, as in `mesh.phong.shade` with the same `feature_angle`.
    position : tuple of float
        World position of the vertex.
    color : tuple of float
        Lit colour, as `mesh.phong.shade` computes it.
    base : tuple of float
        The part of the colour that does not come from the lights: emission, and ambient light of the light model.
    shares : mapping
        Name of a light, or its index if it has no name → its contribution: ambient, diffuse and specular.
    bounced : tuple of float
        Light that has bounced between surfaces; 0 without bounces.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> plotter = pv.Plotter(off_screen=True, lighting="none")
    >>> sun = plotter.phong.add_light(ph.DirectionalLight(direction=(0, 0, -1), name="sun"))
    >>> actor = plotter.phong.add_mesh(pv.Plane(), ph.Material(diffuse=0.5), name="plane")
    >>> plotter.show(auto_close=False)
    >>> found = plotter.phong.probe((0, 0, 0))
    >>> found.mesh, found.shares
    ('plane', {'sun': (0.5, 0.5, 0.5)})
    >>> plotter.close()
    """

    mesh: str
    point_id: int
    position: Vector
    color: Vector
    base: Vector
    shares: Mapping[str, Vector]
    bounced: Vector

    def __repr__(self) -> str:
        red, green, blue = self.color
        of = f" of {self.mesh!r}" if self.mesh else ""
        return f"<Probe of vertex {self.point_id}{of}: {red:.3g} {green:.3g} {blue:.3g}, {len(self.shares)} lights>"


class Place(NamedTuple):
    """A vertex of a lit mesh; `row` is its index in the drawn surface."""

    mesh: LitMesh
    row: int

    @property
    def local(self) -> Vector:
        """Position in the mesh's own coordinates."""
        x, y, z = self.mesh.drawn.points[self.row].tolist()
        return x, y, z

    @property
    def position(self) -> Vector:
        """Position in the world."""
        matrix = self.mesh.matrix
        x, y, z = transform_points(np.array([self.local]), np.eye(4) if matrix is None else matrix)[0].tolist()
        return x, y, z


class Locators:
    """Search structures, one for each lit mesh, to find the point of the meshes that is nearest to a given point.

    The structure of a mesh is kept until the mesh changes.
    """

    def __init__(self) -> None:
        self._known = weakref.WeakKeyDictionary[LitMesh, tuple[Any, vtkStaticCellLocator]]()
        self._cell = vtkGenericCell()

    def nearest(self, meshes: Sequence[LitMesh], point: VectorLike) -> Place | None:
        """Find the face of all meshes that is nearest to a point, and return its corner nearest to this point.

        Parameters
        ----------
        meshes : sequence of LitMesh
            The meshes. Meshes that are not drawn, because they cannot be lit, are skipped.
        point : sequence of float
            A point in the world.
        """
        found = [(self._in(mesh, np.array(point, np.float64)), mesh) for mesh in meshes if mesh.drawn.n_points]
        if not found:
            return None
        (_, row), mesh = min(found, key=lambda each: each[0])
        return Place(mesh, row)

    def _in(self, mesh: LitMesh, point: Float64Array) -> tuple[float, int]:
        """Return the distance between the mesh and the world point, and the index of a vertex.

        The vertex is the corner of the mesh's nearest face that is nearest to the point.
        """
        matrix = np.eye(4) if mesh.matrix is None else mesh.matrix
        try:
            inverse = np.linalg.inv(matrix)
        except np.linalg.LinAlgError:  # its actor flattens the mesh
            inverse = np.linalg.pinv(matrix)
        local = transform_points(point[None], inverse)[0]
        rows = np.arange(mesh.drawn.n_points)
        on_surface: list[float] | None = None
        if mesh.drawn.n_cells:
            on_surface, cell = [0.0, 0.0, 0.0], mutable(0)
            found: Any = self._locator(mesh).FindClosestPoint  # its stubs have no mutable numbers
            found(local, on_surface, self._cell, cell, mutable(0), mutable(0.0))
            corners = mesh.drawn.GetCell(int(cell))
            rows = np.array([corners.GetPointId(corner) for corner in range(corners.GetNumberOfPoints())])
        away = np.linalg.norm(np.asarray(mesh.drawn.points)[rows] - local, axis=1)
        row = int(rows[np.argmin(away)])
        nearest = np.array(mesh.drawn.points[row] if on_surface is None else on_surface, np.float64)
        return float(np.linalg.norm(transform_points(nearest[None], matrix)[0] - point)), row

    def _locator(self, mesh: LitMesh) -> vtkStaticCellLocator:
        stamp, known = mesh.geometry()[0], self._known.get(mesh)
        if known is None or known[0] != stamp:
            locator = vtkStaticCellLocator()
            locator.SetDataSet(mesh.drawn)
            locator.BuildLocator()
            known = self._known[mesh] = stamp, locator
        return known[1]


def read(place: Place, name: str, scene: Scene) -> Probe | None:
    """Return the current lit value of a vertex. Its mesh must be up to date.

    Return None if the mesh has not been lit yet, or was lit by other lights.

    Parameters
    ----------
    place : Place
        The vertex.
    name : str
        Name of the mesh.
    scene : Scene
        The current scene.
    """
    shading = place.mesh.shading_at(place.row)
    labels = light_labels(scene)
    if shading is None or shading.base is None or shading.per_light is None or len(labels) != len(shading.per_light):
        return None
    shares = {label: _first(share) for label, share in zip(labels, shading.per_light, strict=True)}
    color = shading.rgb.clip(0.0, 1.0) if scene.light_model.clamp else shading.rgb
    return Probe(name, place.row, place.position, _first(color), _first(shading.base), shares, _bounced(shading))


def _bounced(shading: Shading) -> Vector:
    return (0.0, 0.0, 0.0) if shading.bounced is None else _first(shading.bounced.sum(axis=0))


def _first(rows: Any) -> Vector:
    red, green, blue = rows[0].tolist()
    return red, green, blue
