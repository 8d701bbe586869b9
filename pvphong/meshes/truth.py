"""`mesh.phong.truth`: colours by path tracing. Converts meshes and materials to surfaces of the path tracer."""

from __future__ import annotations

import functools
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv

from pvphong.base import check, text
from pvphong.base.types import Float64Array, MatrixLike
from pvphong.base.vectors import unit
from pvphong.geometry.transform import transform_normals, transform_vectors
from pvphong.meshes.blocks import of_each
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.point_data import surface_and_maps, tangents_from
from pvphong.meshes.surfaces import FeatureAngle, point_normals, surface
from pvphong.meshes.visibility import checked_occluders, world_faces
from pvphong.optics.material import DEFAULT_MATERIAL, Material, as_material
from pvphong.rays.casting import Occluders, warn_of_slow_rays
from pvphong.rays.paths import LEAST_SAMPLES, MOST_SAMPLES, PathTracer, Reflector
from pvphong.rays.rays import Receiver
from pvphong.scene.scene import Scene, SceneLike
from pvphong.shading.vertices import Vertices

# Least number of paths for which a warning is given if VTK casts the rays, which is slow.
_WORTH_A_WARNING = 2**18
# Allowed excess over 1 of products of colours, due to rounding.
_ROUNDED = 1e-6


@dataclass(frozen=True, eq=False, repr=False)
class Truth:
    """Colours of n vertices from the rendering equation, linear and not clamped.

    Attributes
    ----------
    rgb : ndarray
        Shape (n, 3), float64.
    standard_error : ndarray
        Shape (n, 3), float64: standard error of each colour, from the differences between independent sets of paths.
    rays : int
        Number of rays cast.
    seconds : float
        Time in seconds.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> true = pv.Sphere().phong.truth(ph.DirectionalLight(), samples=4)
    >>> true.rgb.shape, true.standard_error.shape
    ((842, 3), (842, 3))
    """

    rgb: Float64Array
    standard_error: Float64Array
    rays: int
    seconds: float

    def __repr__(self) -> str:
        error = self.standard_error.max(initial=0.0)
        seen = f"{len(self.rgb)} vertices, standard error {error:.2g}"
        return f"<Truth of {seen}: {self.rays} rays in {self.seconds:.3g} s>"


class ReflectingSurfaces(NamedTuple):
    """Surfaces that reflect light to each other, for the path tracer.

    `own_index` is the index of one mesh among them.
    """

    reflectors: Sequence[Reflector]
    occluders: Occluders
    """Triangles of the reflectors, then those of other occluders."""
    own_index: int


def reflecting_blocks(
    blocks: pv.MultiBlock,
    scene: Scene,
    materials: Sequence[Material | str],
    *,
    occluders: Any = (),
    matrix: MatrixLike | None = None,
    feature_angle: FeatureAngle = None,
) -> Iterator[ReflectingSurfaces]:
    """Yield the surfaces that reflect light to each nonempty dataset of `blocks`, in order.

    These surfaces are those of all datasets. The results differ only in `own_index`. `materials` has a material for
    each dataset. `occluders`, `matrix` and `feature_angle` are parameters of `truth`.
    """
    of_blocks = iter(materials)
    reflectors = of_each(
        blocks, lambda block: _reflector(block, scene, as_material(next(of_blocks)), matrix, feature_angle)
    )
    together = Occluders([*(each.faces for each in reflectors), *checked_occluders(occluders)])
    return (ReflectingSurfaces(reflectors, together, index) for index in range(len(reflectors)))


def _reflector(
    mesh: pv.DataSet, scene: Scene, material: Material, matrix: MatrixLike | None, feature_angle: FeatureAngle
) -> Reflector:
    """Convert a mesh and its material, in a scene, to a surface for the path tracer.

    `matrix` is the model matrix. Edges are split if the normals of their faces differ by more than `feature_angle`, in
    degrees.
    """
    if scene.light_model.convention != "standard":
        remedy = "VTK's shader has no bounces; use LightModel()."
        check.refuse("light_model", f"{scene.light_model.convention!r}", "in the standard convention", remedy)
    source, maps, tangents = surface_and_maps(mesh, material, feature_angle)
    normals = functools.cache(lambda: point_normals(source))
    tangents = tangents_from(source, normals) if tangents is None else tangents
    vertices = Vertices(source.points, normals, maps, tangents=tangents)
    equation = vertices.equation(scene, material, matrix)
    in_world = vertices.normals if matrix is None else transform_normals(vertices.normals, matrix)
    values: dict[str, Any] = {"normal": unit(in_world.T.astype(np.float64))[0].T}
    if "tangents" in equation.reflectance.needs:
        along = vertices.tangents if matrix is None else transform_vectors(vertices.tangents, matrix)
        values["tangents"] = unit(along.T.astype(np.float64))[0].T
    values |= {name: vertices.maps[name].rows for name in equation.maps}
    tints = {name: tint.factors(np.float64).T for name, tint in vertices.tints_of(equation.tints).items()}
    if "albedo" in tints:
        tints["diffuse"] = tints.pop("albedo") * tints.get("diffuse", 1.0)
    return Reflector(world_faces(source, matrix), equation, values | tints)


def truth(
    mesh: pv.DataSet,
    scene: SceneLike | None = None,
    material: Material | str = DEFAULT_MATERIAL,
    *,
    occluders: Any = (),
    samples: int = 256,
    max_bounces: int | None = None,
    seed: int = 0,
    matrix: MatrixLike | None = None,
    feature_angle: FeatureAngle = None,
) -> Truth:
    """Compute colours from the rendering equation: with all bounces, shadows, and the sizes of lights.

    Paths of light are traced from the vertices (see `pvphong.rays.paths`), as a reference for faster methods. Constant
    ambient light, of the light model and of lights, is ignored, because it stands for bounced light. Emissive surfaces
    light others, but paths hit them only by chance; replace a small bright surface by a light. Colours are linear, in
    the units of `shade` with `clamp=False`. Without bounces and shadows they equal those of `pvphong.evaluate`.

    A surface reflects light on the side of its normals, or on both sides if the light model is two-sided. A side that
    reflects no light is black and blocks light, as `occluders` do. Blocks of a MultiBlock reflect light to each other.
    Where a path hits a surface, normals and maps are interpolated between the surface's vertices.

    Parameters
    ----------
    mesh : pyvista.DataSet
        A dataset with a surface.
    scene : Scene, light, or sequence of lights, optional
        Lights, viewer and light model; by default `pvphong.default_scene`. The light model must have the standard
        convention; its `shadows` is ignored. A light with `casts_shadows=False` is not blocked.
    material : Material or str, optional
        Material of the surface, or its name; by default OpenGL's. Its diffuse reflectance must be at most 1 in each
        channel, unless `max_bounces` is 0.
    occluders : sequence, optional
        Other meshes that block light and do not reflect it, each as a mesh or a pair of a mesh and a 4x4 matrix.
    samples : int, default 256
        Paths per vertex, rounded up to a power of two from 16 to 65536. The error falls as one over the square root of
        their number.
    max_bounces : int, optional
        Largest number of reflections by surfaces before light reaches a vertex. 0 gives only light that comes directly
        from lights, 1 also light that a surface has reflected once or emitted. By default unlimited.
    seed : int, default 0
        Seed of the paths, from 0 to 2³¹ − 1. Equal calls give equal bits.
    matrix : array_like, optional
        (4, 4) model matrix of the mesh.
    feature_angle : float, "auto" or None, default None
        Edges are split if the normals of their two faces differ by more than this angle, in degrees; see `shade`.

    Returns
    -------
    Truth
        `.rgb` and `.standard_error` (n, 3), `.rays` and `.seconds`.

    Raises
    ------
    ValueError
        If an argument is invalid, or the mesh has nothing that can be lit.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> sky = ph.EnvironmentLight()
    >>> true = pv.Sphere().phong.truth(sky, ph.Material(diffuse=0.5), samples=16)
    >>> true.rgb.shape, bool(abs(true.rgb - 0.5).max() < 0.01)
    ((842, 3), True)
    """
    count = int(check.number("samples", samples, at_least=1.0, at_most=float(MOST_SAMPLES)))
    if max_bounces is not None:
        max_bounces = int(check.number("max_bounces", max_bounces, at_least=0.0))
    seed = int(check.number("seed", seed, at_least=0.0, at_most=2.0**31 - 1.0))
    known = occluders
    if not isinstance(known, ReflectingSurfaces):
        scene = scene_for(surface(mesh), scene, matrix)
        own = _reflector(mesh, scene, as_material(material), matrix, feature_angle)
        known = ReflectingSurfaces([own], Occluders([own.faces, *checked_occluders(occluders)]), 0)
    reflector, index = known.reflectors[known.own_index], known.own_index
    for each in known.reflectors if max_bounces != 0 else ():
        _refuse_more_than_all(each)
    samples = max(LEAST_SAMPLES, 1 << (count - 1).bit_length())
    tracer = PathTracer(known.reflectors, known.occluders, max_bounces, samples, seed)
    start = time.perf_counter()
    receiver = Receiver(reflector.faces, lambda: reflector.values["normal"], index)
    receiver.turned.origins, known.occluders.casters  # noqa: B018  computed now, because threads share them
    if known.occluders.are_slow and samples * len(reflector.faces.points) >= _WORTH_A_WARNING:
        warn_of_slow_rays()
    with text.about("paths of light"):
        traced = tracer.trace(index, receiver)
    return Truth(*traced, time.perf_counter() - start)


def _refuse_more_than_all(reflector: Reflector) -> None:
    """Raise ValueError if a surface reflects more diffuse light than arrives. The sum over bounces would diverge."""
    equation = reflector.equation
    tints = reflector.values.get("diffuse", np.ones((1, 3)))
    for k in equation.lobes_of["diffuse"]:
        color = np.array(equation.colors[k]) * (tints if equation.reflectance.lobes[k].takes_albedo else 1.0)
        if np.nanmax(color, initial=0.0) > 1.0 + _ROUNDED:
            got = f"up to {np.nanmax(color):.4g} of the light"
            remedy = "The sum over bounces would diverge. Reduce diffuse, or pass max_bounces=0."
            check.refuse("diffuse", got, "at most 1 in each channel after multiplication by the albedo", remedy)
