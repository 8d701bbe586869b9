"""`mesh.phong.irradiance`: light that arrives at a mesh, in the unit of its lights, without a material.

If the irradiance of a perfectly white matte surface is E in the unit of the lights, its colour is E. For example, a
directional light of intensity 1 gives 1 to a surface that faces it, and a lamp of intensity I gives I/d² at the
distance d. So the evaluators compute irradiance as the unclamped colour of a white matte surface, without ambient
light. The radiance of that surface is E/π; correspondingly, a colour of an environment's image is π times its radiance.

In order: the function; the places where irradiance is computed; direct light; bounces. The places are vertices, or
sample points inside faces, called nodes.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple, Self, get_args

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from pvphong.base import check
from pvphong.base.types import Backend, Float64Array, FloatArray, MatrixLike, Precision, rgb
from pvphong.geometry.normals import polygon_normals
from pvphong.meshes.cells import cells
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.lit import refuse_name
from pvphong.meshes.point_data import surface_and_maps
from pvphong.meshes.surfaces import FeatureAngle, has_faces, has_normals, point_normals, polygons, shallow_copy
from pvphong.meshes.transport import Exchanging, checked_transport, transport_of
from pvphong.meshes.visibility import KnownOccluders, checked_occluders, visibility_of, world_faces
from pvphong.optics.maps import fractions
from pvphong.optics.material import Material
from pvphong.rays.casting import Occluders
from pvphong.rays.transport import Transport
from pvphong.rays.visibility import Visibility
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene, SceneLike, light_labels
from pvphong.shading.interreflection import Radiosity, bounced
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices
from pvphong.shading.visibility import VisibilityLike, checked_visibility

Per = Literal["vertex", "face"]

ALBEDO = 0.5
"""Default albedo of surfaces that light bounces from."""

_WHITE = Material(ambient=0.0, diffuse=1.0)
# Where no tolerance is given, visibility is sampled to this fraction of the typical irradiance, from so many sites.
_AS_FINE_AS_A_DISPLAY, _TYPICAL = 1.0 / 255.0, 1024


def irradiance(
    mesh: pv.DataSet,
    scene: SceneLike | None = None,
    *,
    per: Per = "vertex",
    bounces: int | None = None,
    albedo: Any = ALBEDO,
    name: str = "irradiance",
    matrix: MatrixLike | None = None,
    tolerance: float = 0.0,
    precision: Precision = "float32",
    backend: Backend = "auto",
    feature_angle: FeatureAngle = None,
    occluders: Any = (),
    visibility: Visibility | None = None,
    transport: Transport | None = None,
) -> pv.PolyData:
    """Compute the irradiance of a mesh: the light that arrives per area, whatever the surface is made of.

    The unit is that of the lights. A directional light of intensity E gives E to a surface that faces it. Another light
    of intensity I gives I/d² at the distance d, if its attenuation is (0, 0, 1) or it has a size. So with intensities
    in lux and candela, and lengths in metres, the result is in lux; with W/m² and W/sr, it is in W/m². An environment
    light whose image has the value c everywhere gives c to an open surface: c is π times its radiance. Ambient light
    is not included, because it stands for light that is not computed. Highlights and clamping do not apply.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface; it is not modified.
    scene : Scene, light, or sequence of lights, optional
        Lights and light model; by default `pvphong.default_scene`. Of the light model, `shadows`, `two_sided` and
        `bounces` are used.
    per : {"vertex", "face"}, default "vertex"
        "vertex": point arrays, with the normals of `shade`. "face": cell arrays with the mean over each face, which has
        a flat normal. The mean is computed from six sample points per triangle (Strang and Fix's rule, exact for
        polynomials of degree 4). A flat normal points to the side of the mesh's stored normals, if there are any. Cells
        without area have 0.
    bounces : int, optional
        Number of diffuse reflections between surfaces, as in `LightModel`. By default, the number in the scene's light
        model.
    albedo : float, color or map, default 0.5
        Fraction of the light that surfaces reflect, used for bounces only. A map is an array, an array's name or a
        texture, as in `Material`.
    name : str, default "irradiance"
        Name of the new array. It becomes the active scalars.
    matrix : array_like, optional
        (4, 4) model matrix of the mesh.
    tolerance : float, default 0
        Largest error that is allowed to save time, in the unit of the result; 0 allows no approximation. Shadows of
        lights with a size are sampled until the standard error is below it; for 0, until it is 1/255 of the median
        irradiance of the lit parts.
    precision : {"float32", "float64"}, default "float32"
        Precision of the arrays and the arithmetic.
    backend : {"auto", "numpy", "numba"}, default "auto"
        Evaluator, as for `pvphong.evaluate`.
    feature_angle : float, "auto" or None, default None
        An edge is sharp if the normals of its two faces differ by more than this angle, in degrees; see `shade`. With
        "face", the angle affects only the light that vertices reflect.
    occluders : sequence, optional
        Other meshes that block light, each as a mesh or a pair of a mesh and a 4x4 matrix.
    visibility : Visibility, optional
        Result of `mesh.phong.visibility`, used instead of casting rays; for "vertex" only.
    transport : Transport, optional
        Result of `mesh.phong.transport`, used instead of casting rays; for "vertex" only.

    Returns
    -------
    pyvista.PolyData
        The surface with new arrays of shape (n, 3), red, green and blue: ``NAME`` is the whole irradiance.
        ``NAME_light_LIGHT`` is the irradiance by one light, LIGHT being its name or index. If light bounces,
        ``NAME_bounced`` is the irradiance by light from other surfaces. ``NAME`` is the sum of the other arrays. For
        lights without colour, the three columns are equal.

    Raises
    ------
    ValueError
        If an argument has the wrong shape, type or range, or the mesh has nothing that can be lit.

    References
    ----------
    P. Dutré, P. Bekaert, K. Bala, "Advanced Global Illumination", 2nd edition, 2006, sections 2.3 and 2.5.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> lamp = ph.PointLight(position=(0, 0, 2), intensity=1000, attenuation=(0, 0, 1), name="lamp")  # candela
    >>> floor = pv.Plane(i_resolution=2, j_resolution=2).phong.irradiance(lamp)
    >>> float(floor["irradiance"][4, 0])  # lux under the lamp: 1000 cd / (2 m)²
    250.0
    """
    part = Receiving.of(mesh, per, albedo, feature_angle, backend)
    scene = scene_for(part.source, scene, matrix)
    how: Any = {"matrix": matrix, "tolerance": tolerance, "precision": precision, "backend": backend}
    how |= {"occluders": occluders, "visibility": [visibility], "transport": transport}
    return irradiance_together([part], scene, per=per, bounces=bounces, name=name, **how)[0]


def irradiance_together(
    parts: Sequence[Receiving],
    scene: Scene,
    *,
    per: Per = "vertex",
    bounces: int | None = None,
    name: str = "irradiance",
    matrix: MatrixLike | None = None,
    tolerance: float = 0.0,
    precision: Precision = "float32",
    backend: Backend = "auto",
    occluders: Any = (),
    visibility: Sequence[Any] = (),
    transport: Transport | None = None,
) -> list[pv.PolyData]:
    """Compute the irradiance of meshes that shadow each other and reflect light to each other.

    Parameters that are not listed here are those of `irradiance`. Return a mesh with the new arrays for each part.

    Parameters
    ----------
    parts : sequence of Receiving
        The meshes.
    scene : Scene
        Scene with a viewer.
    visibility : sequence
        For each mesh, its visibility, or None.
    """
    for part in parts:
        refuse_name(name, part.source)
    is_given = {"visibility": any(each is not None for each in visibility), "transport": transport is not None}
    for argument in [argument for argument, given in is_given.items() if given and per == "face"]:
        remedy = "With per='face', rays start inside faces, not at vertices."
        check.refuse(argument, "a result for vertices", "omitted for per='face'", remedy)
    tolerance = check.number("tolerance", tolerance, at_least=0.0)
    model = LightModel(
        ambient=0.0,
        clamp=False,
        shadows=scene.light_model.shadows,
        two_sided=scene.light_model.two_sided,
        bounces=scene.light_model.bounces if bounces is None else bounces,
    )
    surfaces = [Exchanging(part.source, part.normals, matrix) for part in parts]
    nodes = [part.nodes for part in parts if part.nodes is not None]  # of all meshes, or of none
    sites = [Exchanging(each.cloud, each.normals, matrix, index) for index, each in enumerate(nodes)] or surfaces
    together: Transport | None = None
    if model.bounces:  # nodes gather light that vertices send
        of_nodes = transport_of([*surfaces, *sites], occluders) if nodes else None
        together = of_nodes or checked_transport(transport, surfaces, occluders)
    blocking = _blocking(surfaces, together, occluders) if model.shadows else Occluders([])
    known = [KnownOccluders(blocking, index) for index in range(len(parts))]
    direct = _Direct(replace(scene, light_model=replace(model, bounces=0)), tolerance, precision, backend)
    seen = visibility or [None] * len(parts)
    shares = [direct.at(site, own, given) for site, own, given in zip(sites, known, seen, strict=True)]
    arriving: list[FloatArray | None] = [None] * len(parts)
    if together is not None:
        sums = [share.sum(axis=0) for share in shares]
        if nodes:
            sums = [direct.at(each, own, None).sum(axis=0) for each, own in zip(surfaces, known, strict=True)]
        found = _gathered(sums, [part.albedo for part in parts], together, model.bounces)
        arriving = [found[rows] for rows in together.slices[-len(parts) :]]
    labels = light_labels(scene)
    return [
        part.with_arrays(name, labels, share, bounced_light)
        for part, share, bounced_light in zip(parts, shares, arriving, strict=True)
    ]


# --- the sites


class Receiving(NamedTuple):
    """A mesh that receives light, and reflects it to other meshes."""

    mesh: pv.DataSet
    """The given mesh, or a copy that shares its arrays."""
    source: pv.PolyData
    """The mesh's surface."""
    normals: Callable[[], FloatArray]
    """Function that returns the normals of the surface's points."""
    albedo: FloatArray
    """Albedo of the surface's points, shape (n, 3) or (3,)."""
    nodes: Nodes | None
    """Nodes inside the surface's faces, if faces receive the light; None if vertices do."""

    @classmethod
    def of(cls, mesh: pv.DataSet, per: Per, albedo: Any, feature_angle: FeatureAngle, backend: Backend) -> Self:
        """Return a dataset's surface with its albedo. Nothing is computed from its faces yet.

        Parameters
        ----------
        mesh : pyvista.DataSet
            The dataset.
        per : {"vertex", "face"}
            Elements that receive the light: vertices, or faces with nodes inside.
        albedo : float, color or map
            Fraction of the light that the surface reflects.
        feature_angle : float, "auto" or None
            An edge is split if the normals of its two faces differ by more than this angle, in degrees.
        backend : {"auto", "numpy", "numba"}
            Backend that computes normals from the faces.
        """
        check.choice("per", per, get_args(Per))
        now = shallow_copy(mesh) if isinstance(mesh, pv.PolyData) else mesh
        material = Material(ambient=0.0, diffuse=1.0, albedo=albedo)
        source, maps, _ = surface_and_maps(now, material, feature_angle)
        normals = functools.cache(lambda: point_normals(source, backend=backend))
        values = Vertices(source.points, normals, maps).maps.get("albedo")
        reflects = np.array(rgb(material.albedo)) if values is None else fractions("albedo", values.rows, np.float32)
        if per == "vertex":
            return cls(now, source, normals, reflects, None)
        if not has_faces(source):
            check.refuse("mesh", f"{source.n_points} points and no faces", "a mesh with faces for per='face'")
        return cls(now, source, normals, reflects, Nodes.of(source, normals))

    def with_arrays(
        self, name: str, labels: Sequence[str], shares: FloatArray, arriving: FloatArray | None
    ) -> pv.PolyData:
        """Return a new mesh with arrays of the irradiance.

        Parameters
        ----------
        name : str
            Name of the whole irradiance.
        labels : sequence of str
            Labels of the lights.
        shares : ndarray
            Irradiance by each light at the vertices or nodes, shape (lights, n, 3).
        arriving : ndarray or None
            Irradiance by bounced light, shape (n, 3).
        """
        result = self.source if self.source is self.mesh else shallow_copy(self.source)
        parts = {f"{name}_light_{label}": share for label, share in zip(labels, shares, strict=True)}
        if arriving is not None:
            parts[f"{name}_bounced"] = arriving.astype(shares.dtype, copy=False)
        data, count = result.point_data, result.n_points
        if self.nodes is not None:
            parts = {array: self.nodes.means(values) for array, values in parts.items()}
            data, count = result.cell_data, result.n_cells
        whole = np.zeros((count, 3), shares.dtype)
        for array, values in parts.items():
            data.set_array(values, array)
            whole += values
        data.set_array(whole, name)
        result.set_active_scalars(name, preference="point" if self.nodes is None else "cell")
        return result


# Nodes of a rule of degree 4 on a triangle: two rings of three points with barycentric coordinates (1 − 2a, a, a), and
# the weight of each (G. Strang, G. Fix, "An Analysis of the Finite Element Method", 1973; D. Dunavant, 1985).
_RINGS = ((0.445948490915965, 0.223381589678011), (0.091576213509771, 0.109951743655322))
_BARYCENTRIC = np.array([np.roll([1.0 - 2.0 * a, a, a], turn) for a, _ in _RINGS for turn in range(3)])
_WEIGHTS = np.repeat([weight for _, weight in _RINGS], 3)
_WEIGHTS = _WEIGHTS / _WEIGHTS.sum()


class Nodes(NamedTuple):
    """Nodes, that is, sample points inside the faces of a surface, six per triangle, for means over cells."""

    cloud: pv.PolyData
    """The nodes, triangle by triangle."""
    normals: Callable[[], FloatArray]
    """Function that returns the flat normal at each node."""
    cells: NDArray[np.int64]
    """Cell of each triangle, shape (m,)."""
    shares: Float64Array
    """Fraction of its cell's area that each triangle fills, shape (m,)."""
    n_cells: int

    @classmethod
    def of(cls, source: pv.PolyData, normals: Callable[[], FloatArray]) -> Self:
        """Return the nodes, six sample points per triangle, of a surface's polygons and triangle strips.

        `normals` is a function that returns the normals of the surface's points. If the surface has stored normals,
        they decide which side of a face is its front.
        """
        triangles, numbers = _triangles_of_cells(source)
        corners = np.asarray(source.points, np.float64)[triangles]
        flat = polygon_normals(source.points, triangles.ravel(), 3 * np.arange(len(triangles) + 1))
        if has_normals(source):  # they, and not the order of the corners, decide which side is the front
            facing = np.einsum("ij,ikj->i", flat, np.asarray(normals(), np.float64)[triangles])
            flat = np.where(facing[:, None] < 0.0, -flat, flat)
        edges = corners[:, 1:] - corners[:, :1]
        edges[~np.isfinite(edges).all(axis=(1, 2))] = 0.0
        edges /= np.abs(edges).max(initial=0.0) or 1.0  # so that areas neither overflow nor vanish
        areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
        sums = np.bincount(numbers, areas, source.n_cells)[numbers]
        cloud = pv.PolyData()
        cloud.points = np.einsum("kc,mcx->mkx", _BARYCENTRIC, corners).reshape(-1, 3)
        shares = np.divide(areas, sums, out=np.zeros_like(areas), where=sums > 0.0)
        return cls(cloud, lambda: np.repeat(flat, len(_WEIGHTS), axis=0), numbers, shares, source.n_cells)

    def means(self, values: FloatArray) -> FloatArray:
        """Return the mean of values over each cell, shape (cells, 3); 0 for cells without area.

        `values` are those at the nodes.
        """
        of_triangles = np.einsum("k,mkx->mx", _WEIGHTS, values.reshape(-1, len(_WEIGHTS), 3))
        result = np.zeros((self.n_cells, 3))
        np.add.at(result, self.cells, of_triangles * self.shares[:, None])
        return result.astype(values.dtype)


def _triangles_of_cells(source: pv.PolyData) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the triangles of a surface's faces, as point indices, shape (m, 3), and the cell of each triangle."""
    _, _, faces, strips = cells(source)
    connectivity, offsets = polygons(source)
    of_strips = np.repeat(np.arange(strips.count), np.maximum(np.diff(strips.offsets) - 2, 0))
    numbers = np.concatenate([faces.first + np.arange(faces.count), strips.first + of_strips])
    if not (np.diff(offsets) == 3).all():
        bare = pv.PolyData()
        bare.points, bare.faces = source.points, pv.CellArray.from_arrays(offsets, connectivity)
        bare.cell_data["cell"] = numbers
        bare = bare.triangulate()
        connectivity, numbers = polygons(bare)[0], np.asarray(bare.cell_data["cell"])
    return connectivity.reshape(-1, 3), numbers


# --- direct light, and bounces


class _Direct(NamedTuple):
    """Computes the direct light of a scene at the points of surfaces."""

    scene: Scene
    """The scene, without ambient light, clamping and bounces."""
    tolerance: float
    precision: Precision
    backend: Backend

    def at(self, site: Exchanging, known: KnownOccluders, given: Any) -> FloatArray:
        """Return the irradiance by each light, shape (lights, n, 3).

        Parameters
        ----------
        site : Exchanging
            Points and normals at which the light arrives.
        known : KnownOccluders
            Geometry that blocks light, for scenes with shadows.
        given : Visibility, array_like or None
            Known visibility of the lights; None to cast rays.
        """
        source, normals, matrix, _ = site
        seen: VisibilityLike | None = None
        if given is not None:
            seen = checked_visibility("visibility", given, source.points, matrix, self.scene)
        elif self.scene.light_model.shadows:
            error = self.tolerance or _AS_FINE_AS_A_DISPLAY * self._typical(site)
            how: Any = {"occluders": known, "tolerance": error, "matrix": matrix}
            seen = visibility_of(source, normals, self.scene, **how)
        vertices = Vertices(source.points, normals, visibility=seen)
        planned = Plan.of(self.scene, _WHITE, vertices, matrix=matrix, tolerance=self.tolerance)
        found = planned.run(vertices, precision=self.precision, backend=self.backend, components=True).per_light
        assert found is not None
        return found

    def _typical(self, site: Exchanging) -> float:
        """Return the median irradiance of some lit points, without shadows; 1 if no point is lit."""
        source, normals, matrix, _ = site
        rows = np.unique(np.linspace(0, source.n_points - 1, min(source.n_points, _TYPICAL)).astype(np.intp))
        some = Vertices(np.asarray(source.points)[rows], normals()[rows])
        open_air = replace(self.scene, light_model=replace(self.scene.light_model, shadows=False))
        found = Plan.of(open_air, _WHITE, some, matrix=matrix).run(some, precision="float64", backend="numpy")
        lit = [brightest for brightest in found.rgb.max(axis=1).tolist() if brightest > 0.0]
        return float(np.median(lit)) if lit else 1.0


def _blocking(surfaces: Sequence[Exchanging], together: Transport | None, occluders: Any) -> Occluders:
    """Return the geometry that blocks light: first the surfaces in order, then the occluders.

    A surface without faces has no triangles there. `together` is the transport of light between the surfaces, None
    without bounces. If it is given, its geometry is returned.
    """
    known = None if together is None else together.parts[0].blocking
    if known is not None and all(has_faces(each.source) for each in surfaces):
        return known[0]
    return Occluders([*(world_faces(each.source, each.matrix) for each in surfaces), *checked_occluders(occluders)])


def _gathered(
    direct: Sequence[FloatArray], albedos: Sequence[FloatArray], together: Transport, count: int
) -> FloatArray:
    """Return the irradiance by light that has bounced 1 to `count` times, at all points of the transport `together`.

    Parameters
    ----------
    direct : sequence of ndarray
        Direct irradiance of the points of each surface that reflects light. These points are the first points of the
        transport.
    albedos : sequence of ndarray
        Albedo of these points.
    """
    scattered, sent = np.zeros((2, len(together), 3), np.float32)
    for rows, own, albedo in zip(together.slices, direct, albedos, strict=False):  # further points only gather
        scattered[rows], sent[rows] = albedo, albedo * own
    # the last bounce is not reflected again: what arrives is gathered from one reflection fewer
    before = bounced(Radiosity(sent, np.zeros_like(sent), scattered), together.gather, count - 1, apart=False)[0]
    return together.gather(sent + before)
