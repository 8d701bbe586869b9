"""`pvphong.evaluate` for arrays in memory.

Two other modules call `Plan.run` too: `chunks.py` for Dask arrays, and `meshes/lit.py` for meshes.
"""

from __future__ import annotations

from typing import Any

from pvphong.base.types import Backend, MatrixLike, Precision
from pvphong.optics.material import Material, as_material
from pvphong.scene.options import known_options
from pvphong.scene.scene import SceneLike, as_scene
from pvphong.shading.plan.plan import Plan
from pvphong.shading.reference import Shading
from pvphong.shading.vertices import Vertices
from pvphong.shading.visibility import checked_part, checked_visibility


@known_options
def evaluate(
    points: Any,
    normals: Any,
    scene: SceneLike,
    material: Material | str,
    *,
    matrix: MatrixLike | None = None,
    precision: Precision = "float32",
    backend: Backend = "auto",
    tolerance: float = 0.0,
    components: bool = False,
    visibility: Any = None,
    transport: Any = None,
) -> Shading:
    """Compute lit colours of vertices by the Phong or Blinn-Phong model, or the material's own reflectance.

    Sources: Phong, "Illumination for computer generated pictures" (1975); Blinn, "Models of light
    reflection for computer synthesized pictures" (1977); OpenGL 2.1 specification, section 2.14.1.

    Every colour is finite. A vertex with a zero or non-finite normal has emission and ambient light only. A vertex
    whose point is not finite receives nothing from lights with a position, and has no highlight if the viewer is local.
    A light on a vertex adds neither diffuse nor specular light there, and an eye on a vertex sees no highlight.

    With the extra `dask`, `pvphong.evaluate` takes Dask arrays, chunked along vertices, and returns a `Shading` of Dask
    arrays. Shapes, types and all other arguments are checked at once, but nothing is computed until `compute` is
    called. Each chunk has its own plan, within the tolerance, and runs in one of Dask's threads. With a named backend
    and tolerance 0 the colours equal those of NumPy arrays to the bit, with one exception: if a map of a highlight's
    field is constant in one chunk but not over all vertices, area lights are exact in this chunk instead of a sum of
    nodes. NumPy arrays are chunked like the Dask arrays. A scene without a viewer is framed by all points, which are
    then computed first.

    Parameters
    ----------
    points : array_like
        Shape (n, 3), in the mesh's own coordinates. Other types than float32 and float64 are widened.
    normals : array_like
        Shape (n, 3), of any length; they need not be unit vectors.
    scene : Scene, light, or sequence of lights
        Lights, viewer and light model, in world coordinates. Without a viewer, the camera is placed as PyVista would
        place it for the points.
    material : Material or str
        Reflectances of the surface, or the name of a material. Its maps and tangents are arrays with a row per vertex;
        names and textures need a mesh, as in `mesh.phong.shade`.
    matrix : array_like, optional
        (4, 4) model matrix: it transforms points, and its inverse transpose transforms normals. Positions are added in
        float64. If the matrix's translation is so long that the rounding shows in float32, the translation is first
        subtracted from lights and eye, provided that all lights have known positions.
    precision : {"float32", "float64"}
        Precision of the result, and of the arithmetic after positions are subtracted. The error in float32 is at most
        (4√n + 16) · 2⁻²⁴ · (1 + number of lights) for colours of size 1, with n the largest of the material's shininess
        and the spot lights' exponents. An area light that is summed over nodes counts as 64 lights, a sky as 256 to
        1024. If the horizon cuts a light of angular size s, the rounding of the normal counts 1/s times. (A power
        between 0 and 1 has a larger error where its cosine is nearly 0, because it is infinitely steep there.)
    backend : {"auto", "numpy", "numba"}
        Evaluator: "numpy" is readable, "numba" is compiled and needs the extra `fast`. "auto" uses compiled code if it
        is available and the work is worth its start. It never waits for the compiler: if code is missing, NumPy runs,
        and another process compiles it for later calls. So equal calls may differ within the bound above. With a named
        backend, equal calls return equal bits. "numba" waits for compilation: ten seconds or more once per installation
        and combination of float types, and a second for each kind of light. NumPy evaluates what compiled code does not
        support (lights and reflectances without compiled code, coordinates beyond 2¹⁰⁰).
    tolerance : float, default 0
        Largest absolute colour error that may be traded for time; 0 allows no approximation.
    components : bool, default False
        True to also return ambient, diffuse, specular, emission, base and per-light arrays.
    visibility : Visibility or array_like, optional
        Visibility of the lights and the sky, for light models with shadows or ambient occlusion: the result of
        `mesh.phong.visibility(scene)` for a mesh with these points. Or numbers of shape (lights + 1, n), required with
        Dask arrays: the visible part of each light per vertex, as in `.per_light`, and of the sky in the last row, as
        in `.sky`. For a two-sided light model, as many rows may follow for the other sides, as in `.behind`; without
        them, both sides see the same.
    transport : Transport, optional
        Light transport between the vertices, for light models with bounces: the result of `mesh.phong.transport()` for
        a mesh with these points.

    Returns
    -------
    Shading
        Its `.rgb` has the shape (n, 3).

    Raises
    ------
    ValueError
        If an argument has the wrong shape, type or range, or `backend` is "numba" and Numba is missing. The
        message names the argument.

    Examples
    --------
    >>> import numpy as np, pvphong as ph
    >>> points, normals = np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]])
    >>> sun = ph.DirectionalLight(direction=(0, 0, -1))
    >>> ph.evaluate(points, normals, sun, ph.Material(diffuse=0.5, ambient=0)).rgb
    array([[0.5, 0.5, 0.5]], dtype=float32)
    """
    material = as_material(material)
    vertices = Vertices(points, normals, material.maps, tangents=material.tangents)
    scene = as_scene(scene, lambda: vertices.bounds(matrix))
    if visibility is not None:
        vertices.visibility = checked_visibility("visibility", visibility, vertices.points, matrix, scene)
    if transport is not None:
        vertices.transport = checked_part("transport", transport, len(vertices))
    plan = Plan.of(scene, material, vertices, matrix=matrix, tolerance=tolerance)
    return plan.run(vertices, precision=precision, backend=backend, components=components)
