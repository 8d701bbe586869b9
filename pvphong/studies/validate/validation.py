"""Comparison of pvphong's colours with VTK's shader, vertex by vertex: `validate` and its result."""

from __future__ import annotations

import math
import os
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.files import write_json
from pvphong.base.text import html_table, rendered, wrapped
from pvphong.base.types import Backend, BoolArray, Float64Array, FloatArray, IntArray, MatrixLike, Vector, rgb
from pvphong.base.vectors import is_direction
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.point_data import surface_and_maps
from pvphong.meshes.surfaces import FeatureAngle, point_normals
from pvphong.optics.lights import vtk_values
from pvphong.optics.maps import Map
from pvphong.optics.material import Material, as_material, refuse_maps_in_vtk
from pvphong.optics.reflectances.likeness import in_vtk
from pvphong.scene.scene import Scene, SceneLike
from pvphong.shading.evaluation import evaluate
from pvphong.vtk.oracle import driver, vtk_shade
from pvphong.vtk.rounding import Pose, allowed_error, limits
from pvphong.vtk.scenes import in_vtk_terms, refuse_inexpressible, seen_from_infinity, shining

if TYPE_CHECKING:
    from rich.table import Table

# If the cosine between normal and viewer is at most this, its sign is uncertain in float64.
_DOUBTFUL_FACING = 2.0**-40

# Distance from the origin, in sizes of the mesh, beyond which float32 loses digits.
_OFF_CENTER = 10.0

# Number of worst vertices that a comparison lists.
_WORST = 8

TIERS = ("unlit", "headlight", "directional lights", "positional lights")
"""Kinds of lighting code in VTK's shader. The number of a tier is an index into this tuple."""


def validate(
    mesh: pv.DataSet,
    scene: SceneLike | None,
    material: Material | str,
    *,
    matrix: MatrixLike | None = None,
    feature_angle: FeatureAngle = None,
    backend: Backend = "auto",
) -> Comparison:
    """Compare pvphong's colours with those of VTK's own shader, vertex by vertex.

    pvphong's colours are those of `evaluate` in float32, before they are clamped. VTK's colours are those of
    `pvphong.vtk.oracle.vtk_shade`. The scene is compared in its own convention, and VTK's settings are adapted to it.
    Ambient light and emission become the unlit ambient colour of VTK's material. A viewer at infinity becomes a distant
    one. For two-sided lighting, normals are turned to the viewer. The coordinates of a mesh far from the origin are
    taken relative to the mesh's middle, and the matrix moves the mesh back. `Comparison.conversions` lists these
    changes.

    Vertices where float32 leaves VTK's colour uncertain are not compared; `Comparison.left_out` lists them:

    - where a highlight begins, at n·l = 0;
    - on the edge of a spot's cone;
    - where two-sided lighting turns normals, at n·v = 0;
    - where VTK's rounding of positions and directions may exceed the bound;
    - in the standard convention, where VTK increases a cosine to its lower limit, 1e-5, and this changes the colour
      visibly.

    Parameters
    ----------
    mesh : pyvista.DataSet
        Dataset with a surface. Its active point normals are used, or computed ones if it has none.
    scene : Scene, light, sequence of lights, or None
        Lights, viewer and light model, in either convention; by default the scene of `pvphong.default_scene`.
    material : Material or str
        Material. The only map that VTK supports is an albedo of uint8, drawn as vertex colours. Ambient and diffuse
        must then be grey. For other maps, the ValueError names the map.
    matrix : array_like, optional
        (4, 4) model matrix.
    feature_angle : float, "auto" or None, default None
        An edge is sharp if the normals of its two faces differ by more than this angle, in degrees. Points are
        duplicated along sharp edges. "auto" is 30 if the mesh has no point normals, and None if it has. None splits
        nothing.
    backend : str, default "auto"
        Evaluator of pvphong's colours, as in `evaluate`.

    Returns
    -------
    Comparison
        `.passed`, `.max_error`, `.worst` and more. Print it for the verdict, or `.explain()` for all numbers.

    Raises
    ------
    InexpressibleError
        A ValueError if VTK's shader cannot draw the scene, and this changes the colours. It cannot draw lights with an
        ambient colour or with a specular colour other than diffuse, Blinn-Phong, `PBR` in the standard convention, a
        viewer at infinity with lights at a position, powers above 128, a matrix that flattens or has scales outside
        1e-18 to 1e18, and mirrored surfaces, because VTK turns their normals away from the viewer. The error holds the
        nearest scene that VTK can draw.
    ValueError
        If an argument has the wrong shape, type or range, or the mesh has nothing to light.

    See Also
    --------
    pvphong.vtk.oracle.vtk_shade : VTK's colours alone.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> ph.validate(pv.Sphere(), ph.Scene(lights=[ph.DirectionalLight()]), ph.Material()).passed
    True
    """
    material = as_material(material)
    source, maps, _ = surface_and_maps(mesh, material, feature_angle)
    material = material.with_values({name: Map(rows) for name, rows in maps.items()})
    refuse_maps_in_vtk(material)
    material = replace(material if maps else material.without_albedo(), tangents=None)  # VTK does not read them
    scene = scene_for(source, scene, matrix)
    given = None if matrix is None else check.matrix4("matrix", matrix)
    refuse_inexpressible(scene, material, given)
    points, normals = check.array("points", source.points), check.array("normals", point_normals(source))
    unclamped = replace(scene, light_model=replace(scene.light_model, clamp=False))
    own = evaluate(points, normals, unclamped, material, matrix=given, backend=backend).rgb

    lit = np.isfinite(points).all(axis=1) & is_direction(normals.T)
    rows = np.flatnonzero(lit)
    affine = np.eye(4) if given is None else given / given[3, 3]
    pose, doubtful, conversions = _pose_for_vtk(points[lit], normals[lit], scene, affine)
    positions, directions = np.full((2, len(points), 3), np.nan)
    positions[rows], directions[rows] = pose.in_world()

    # 16 · power · 2⁻²⁴ + 1e-6, see `pvphong.vtk.oracle`. For physically based shading, `allowed_error` replaces 1e-6.
    exponents = [vtk_values(light).exponent for light in shining(scene)]
    physical = in_vtk(material.reflectance)
    power = material.shininess if any(rgb(material.specular)) else 0.0
    shininess, more = (0.0, allowed_error(physical.roughness)) if physical else (power, 1e-6)
    tolerance = 16.0 * max(shininess, *exponents, 0.0) * 2.0**-24 + more

    terms = in_vtk_terms(scene, material, pose.matrix[:3, 3], _box(positions[rows])[1])
    vtk = np.full((len(points), 3), np.nan, dtype=np.float32)
    if len(rows):
        cloud = pv.PolyData(pose.points)
        cloud.point_data.active_normals = pose.normals
        drawn = terms.material.with_values({name: Map(np.asarray(values)[lit]) for name, values in maps.items()})
        vtk[rows] = vtk_shade(cloud, terms.lights, drawn, terms.viewer, matrix=pose.matrix)
    known = limits(pose, terms, tolerance, has_floors=scene.light_model.convention == "vtk")
    left_open = {"n·v = 0": doubtful} | known.open
    left_open["float32"] = known.open["float32"] | ~np.isfinite(vtk[rows]).all(axis=1)
    compared = ~np.logical_or.reduce(list(left_open.values()), axis=0)
    errors = (own[rows].astype(np.float64) - vtk[rows]) / known.scale[:, None]
    left_out = {reason: rows[mask] for reason, mask in left_open.items()}
    left_out["no position or normal"] = np.flatnonzero(~lit)
    return Comparison(
        tolerance=tolerance,
        tier=terms.tier,
        conversions=conversions + terms.conversions,
        driver=driver(),
        vertices=rows[compared],
        errors=errors[compared],
        left_out={reason: numbers for reason, numbers in left_out.items() if len(numbers)},
        pvphong=own,
        vtk=vtk,
        _surface=source,
        _positions=positions,
        _normals=directions,
    )


def _pose_for_vtk(
    points: FloatArray, normals: FloatArray, scene: Scene, matrix: Float64Array
) -> tuple[Pose, BoolArray, tuple[str, ...]]:
    """Return the vertices relative to their centre, with unit normals, so that VTK's float32 numbers are small.

    In a two-sided scene, normals are also turned to the viewer.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3), finite; the normals are not zero.
    scene : Scene
        The scene.
    matrix : ndarray
        Model matrix, shape (4, 4).

    Returns
    -------
    pose : Pose
        Points, normals and matrix.
    doubtful : ndarray
        True where it is uncertain which side of a normal faces the viewer, shape (n,).
    conversions : tuple of str
        Descriptions of the changes, one phrase each.
    """
    conversions = []
    center, size = _box(points.astype(np.float64))
    if np.abs(center).max() > _OFF_CENTER * size:
        conversions.append(f"coordinates relative to the mesh's middle, ({', '.join(f'{c:.6g}' for c in center)})")
    around = matrix.copy()
    around[:3, 3] += matrix[:3, :3] @ center
    scaled = normals / np.abs(normals).max(axis=1, keepdims=True).astype(np.float64)
    pose = Pose(points - center, scaled / np.linalg.norm(scaled, axis=1)[:, None], around)
    if not scene.light_model.two_sided:
        return pose, np.zeros(len(points), dtype=bool), tuple(conversions)
    positions, directions = pose.in_world()
    to_viewer = np.array(scene.viewer.position) - positions
    if seen_from_infinity(scene):
        to_viewer = np.broadcast_to(-np.array(scene.viewer.view_direction), positions.shape)
    facing = np.einsum("ij,ij->i", directions, to_viewer)
    away = facing < 0.0
    if away.any():
        conversions.append(f"{np.count_nonzero(away)} normals turned to the viewer")
    doubtful = np.abs(facing) <= _DOUBTFUL_FACING * np.linalg.norm(to_viewer, axis=1)
    turned = np.where(away[:, None], -pose.normals, pose.normals)
    return pose._replace(normals=turned), doubtful, tuple(conversions)


def _box(points: Float64Array) -> tuple[Float64Array, float]:
    """Return the centre of the points' bounding box, and the length of its longest edge."""
    if not len(points):
        return np.zeros(3), 0.0
    low, high = points.min(axis=0), points.max(axis=0)
    return low + 0.5 * (high - low), float((high - low).max())


@dataclass(frozen=True)
class Vertex:
    """Vertex with one of the largest errors, and its data.

    Attributes
    ----------
    index : int
        Index of the point.
    error : float
        Largest absolute error of its channels.
    position, normal : tuple of float
        Position and unit normal in world coordinates. The normal faces the viewer if the scene is two-sided.
    pvphong, vtk : tuple of float
        The unclamped colours.
    tier : int
        Number of the kind of lighting code that VTK chose; an index into `TIERS`.
    """

    index: int
    error: float
    position: Vector
    normal: Vector
    pvphong: Vector
    vtk: Vector
    tier: int


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """Comparison of pvphong's unclamped colours with VTK's shader.

    `print(comparison)` prints the verdict, `print(comparison.explain())` all numbers.

    Errors are pvphong's colours minus VTK's. Where the arriving light times the material's reflectances exceeds 1,
    errors are divided by this product, because float32 rounds in proportion to it.

    Attributes
    ----------
    tolerance : float
        Bound on the errors: 16 · p · 2⁻²⁴ + 1e-6. The power p is the largest of the exponents of all spot lights and,
        if the material has a highlight, its shininess. With neither spots nor a highlight, p is 0. For physically based
        shading, which has no shininess, 6 · 2⁻²⁴ / roughness⁴ + 2e-6 replaces the term 1e-6.
    tier : int
        Number of the shader that VTK chose, 1 to 3; 0 if unlit.
    conversions : tuple of str
        Descriptions of changes to the scene for VTK.
    driver : str
        Graphics driver of VTK.
    vertices : ndarray
        Indices of the compared points, shape (n,).
    errors : ndarray
        Signed errors of the compared points, shape (n, 3).
    left_out : dict of str to ndarray
        Reason → indices of the points that were not compared for this reason. A point may have several reasons.
    pvphong, vtk : ndarray
        Unclamped colours, shape (n_points, 3). `vtk` is NaN where VTK has none.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> comparison = pv.Sphere().phong.validate(ph.DirectionalLight())
    >>> comparison.passed
    True
    """

    tolerance: float
    tier: int
    conversions: tuple[str, ...]
    driver: str
    vertices: IntArray
    errors: Float64Array
    left_out: dict[str, IntArray]
    pvphong: FloatArray
    vtk: FloatArray
    _surface: pv.PolyData
    _positions: Float64Array
    _normals: Float64Array

    @property
    def n(self) -> int:
        """Number of compared vertices."""
        return len(self.vertices)

    @property
    def n_left_out(self) -> int:
        """Number of vertices that were not compared."""
        return len(self.pvphong) - self.n

    @property
    def max_error(self) -> float:
        """Largest absolute error of any channel. Like `rms`, `p50` and `p99`, it is NaN if nothing was compared."""
        return float(self._magnitudes.max()) if self.n else math.nan

    @property
    def rms(self) -> float:
        """Root of the mean square of all channels' errors."""
        return math.sqrt(float(np.mean(self.errors**2))) if self.n else math.nan

    @property
    def p50(self) -> float:
        """Median of the vertices' errors. The error of a vertex is the largest of its channels."""
        return float(np.percentile(self._magnitudes, 50)) if self.n else math.nan

    @property
    def p99(self) -> float:
        """99th percentile of the vertices' errors; see `p50`."""
        return float(np.percentile(self._magnitudes, 99)) if self.n else math.nan

    @property
    def passed(self) -> bool:
        """True if every error is within the tolerance; False if nothing was compared."""
        return bool(self.max_error <= self.tolerance)

    @property
    def _verdict(self) -> str:
        if not self.n:
            return "nothing to compare"
        return "passed" if self.passed else "failed"

    @cached_property
    def _magnitudes(self) -> Float64Array:
        magnitudes: Float64Array = np.abs(self.errors).max(axis=1, initial=0.0)
        return magnitudes

    @cached_property
    def worst(self) -> tuple[Vertex, ...]:
        """The vertices with the largest errors, largest first."""
        found = []
        for row in np.argsort(-self._magnitudes, kind="stable")[:_WORST].tolist():
            index = int(self.vertices[row])
            arrays = (self._positions, self._normals, self.pvphong, self.vtk)
            position, normal, own, other = (tuple(array[index].tolist()) for array in arrays)
            found.append(Vertex(index, float(self._magnitudes[row]), position, normal, own, other, self.tier))
        return tuple(found)

    def table(self) -> Table:
        """Return the comparison as a `rich.table.Table`; print it with a `rich.console.Console`."""
        from rich import box
        from rich.table import Table
        from rich.text import Text

        title = Text("pvphong against VTK's shader: ")
        title.append(self._verdict, "green" if self.passed else "red")
        table = Table(title=title, box=box.SIMPLE_HEAD, show_header=False)
        table.add_column(justify="left", no_wrap=True)
        table.add_column(justify="left", overflow="fold")
        for name, value in self._rows():
            table.add_row(name, value)
        return table

    def explain(self) -> str:
        """Return all numbers, the changes for VTK, the vertices left out, and the worst vertices."""
        return rendered([self.table()])

    def _rows(self) -> list[tuple[str, str]]:
        rows = [("vertices compared", f"{self.n} of {self.n + self.n_left_out}")]
        if self.n:
            rows += [
                ("largest error", f"{self.max_error:.3g}, {self.max_error / self.tolerance:.2f} of the bound"),
                ("RMS, median, 99 %", f"{self.rms:.3g}, {self.p50:.3g}, {self.p99:.3g}"),
            ]
        rows += [
            ("bound", f"{self.tolerance:.3g} (see `tolerance`)"),
            ("VTK's tier", f"{self.tier} ({TIERS[self.tier]})"),
            ("driver", self.driver),
        ]
        rows += [("in VTK's terms", conversion) for conversion in self.conversions]
        rows += [("left out", f"{len(points)}: {reason}") for reason, points in self.left_out.items()]
        for vertex in self.worst[: 1 if self.passed else _WORST]:
            place = f"error {vertex.error:.3g} at {_numbers(vertex.position)}, normal {_numbers(vertex.normal)}"
            colors = f"pvphong {_numbers(vertex.pvphong)}, VTK {_numbers(vertex.vtk)}"
            rows.append((f"worst: {vertex.index}", f"{place}, {colors}"))
        return rows

    def __str__(self) -> str:
        if not self.n:
            return f"Nothing to compare: none of the {self.n_left_out} vertices can be compared with VTK."
        within = int(np.count_nonzero(self._magnitudes <= self.tolerance))
        count = f"all {self.n}" if self.passed else f"{within} of {self.n}"
        sentences = [
            f"{self._verdict.capitalize()}: {count} vertices are within {self.tolerance:.3g} of VTK's own shader.",
            f"The largest error is {self.max_error:.3g}, {self.max_error / self.tolerance:.2f} of that bound.",
        ]
        if self.left_out:
            sentences.append(f"{self.n_left_out} vertices are left out: {', '.join(self.left_out)}.")
        if not self.passed:
            sentences.append(f"Worst is vertex {self.worst[0].index} at {_numbers(self.worst[0].position)}.")
        return "\n".join(line for sentence in sentences for line in wrapped(sentence))

    def __repr__(self) -> str:
        error = f"largest error {self.max_error:.3g} of {self.tolerance:.3g}"
        return f"<Comparison {self._verdict}: {error}, {self.n} vertices>"

    def _repr_html_(self) -> str:
        return html_table(f"pvphong against VTK's shader: {self._verdict}", (), self._rows())

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers as built-in Python types, without the arrays; NaN becomes None."""
        numbers = {name: getattr(self, name) for name in ("max_error", "rms", "p50", "p99", "tolerance")}
        return {
            "passed": self.passed,
            "n": self.n,
            "n_left_out": self.n_left_out,
            **{name: None if math.isnan(number) else number for name, number in numbers.items()},
            "tier": self.tier,
            "driver": self.driver,
            "conversions": list(self.conversions),
            "left_out": {reason: len(points) for reason, points in self.left_out.items()},
            "worst": [asdict(vertex) for vertex in self.worst],
        }

    def to_json(self, path: str | os.PathLike[str]) -> None:
        """Write `to_dict` to a JSON file.

        Raises
        ------
        ValueError
            If the file cannot be written.
        """
        write_json(self.to_dict(), path)

    def to_mesh(self) -> pv.PolyData:
        """Return a copy of the surface with colours and errors.

        Returns
        -------
        pyvista.PolyData
            Point arrays: ``"phong"`` and ``"vtk"``, the unclamped colours; ``"phong_error"``, the signed errors, NaN
            where not compared; and ``"phong_error_max"``, the active array, the largest absolute error of the channels.
        """
        mesh = self._surface.copy()
        errors = np.full(self.pvphong.shape, np.nan)
        errors[self.vertices] = self.errors
        mesh.point_data["phong"] = self.pvphong
        mesh.point_data["vtk"] = self.vtk
        mesh.point_data["phong_error"] = errors
        mesh.point_data["phong_error_max"] = np.abs(errors).max(axis=1)
        mesh.set_active_scalars("phong_error_max", preference="point")
        return mesh


def _numbers(triple: Vector) -> str:
    return "(" + ", ".join(f"{number:.7g}" for number in triple) + ")"
