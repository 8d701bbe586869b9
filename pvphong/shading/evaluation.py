"""`pvphong.evaluate`, for arrays in memory; `chunks.py` shares out Dask's. Meshes go through `meshes/lit.py`.

All end in `Plan.run`.
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
    """Lit colours of vertices by the equation of Phong or Blinn-Phong, or the material's own reflectance.

    Sources: Phong, "Illumination for computer generated pictures" (1975); Blinn, "Models of light
    reflection for computer synthesized pictures" (1977); OpenGL 2.1 specification, section 2.14.1.

    A zero or non-finite normal is unlit: emission and ambient light only. A vertex whose point is not finite
    gets nothing from lights with a position, and no highlight if the viewer is local. A light on a vertex adds
    neither diffuse nor specular there, and an eye on a vertex sees no highlight. So every colour is finite.

    With the extra `dask`, `pvphong.evaluate` takes Dask arrays, cut along vertices as one likes, and gives a `Shading`
    of Dask arrays. Nothing is computed until `compute` is called, but shapes, types and all other arguments are checked
    at once. Each chunk is planned for by itself, within the tolerance, and lit by the thread that Dask gives it; with a
    named backend and tolerance 0 the colours are those of NumPy arrays, to the bit, but under lights with a size where
    a map of a highlight's field is one number in a chunk and not in all: it is exact there, else by nodes. NumPy arrays
    beside Dask ones are cut as those are. A scene without a viewer is framed by all points, which then are computed
    first.

    Parameters
    ----------
    points : array_like
        Shape (n, 3), in the mesh's own coordinates. Other types than float32 and float64 are widened.
    normals : array_like
        Shape (n, 3), of any length; they need not be unit vectors.
    scene : Scene, light, or sequence of lights
        Lights, viewer and light model, in world coordinates. Without a viewer, seen as PyVista's camera frames the
        points.
    material : Material or str
        The surface's reflectances, or the name of a material. Its maps and tangents are arrays with a row for each
        vertex; names and textures need a mesh, as in `mesh.phong.shade`.
    matrix : array_like, optional
        (4, 4) model matrix: points are transformed by it, normals by its inverse-transpose.
        Positions are summed in float64. Where its offset is so long that this shows in float32, it is taken out of
        lights and eye first, if every light's fields say where it is.
    precision : {"float32", "float64"}
        Of the result, and of the arithmetic after positions are subtracted. float32 errs by at most
        (4√n + 16) · 2⁻²⁴ · (1 + number of lights) for colours of size 1, n the largest of the material's
        shininess and the spot lights' exponents; a light with a size counts as 64, a sky as 256 to 1024, where it is
        summed over nodes, and where the horizon cuts one of the angular size s, a normal's rounding counts 1/s times.
        (A power between 0 and 1 errs by more where its cosine is nearly 0: it is infinitely steep there.)
    backend : {"auto", "numpy", "numba"}
        Which evaluator computes: the readable one in NumPy, or the compiled one, which needs the extra `fast`.
        "auto" takes the compiled one where its code is there and the work is worth its start. It never waits for a
        compiler: where code is missing, NumPy answers, and another process compiles it for later calls; so equal calls
        may differ within the bound above. With a name, equal calls give equal bits, and "numba" waits for what has to
        be compiled: ten seconds or more once per installation and combination of float types, and a second for each
        kind of light. What the compiled one cannot do (lights and reflectances that it has no code for, coordinates
        beyond 2¹⁰⁰) NumPy does.
    tolerance : float, default 0
        Largest absolute colour error that may be traded for time; 0 allows no approximation.
    components : bool, default False
        Whether the result has its ambient, diffuse, specular, emission, base and per-light arrays too.
    visibility : Visibility or array_like, optional
        What the vertices see of the lights and the sky, where the light model has shadows or ambient occlusion:
        `mesh.phong.visibility(scene)` of a mesh with these points. Or plain numbers, beside Dask arrays only those, of
        shape (lights + 1, n): the part of each light that each vertex sees, as `.per_light`, and of the sky in the last
        row, as `.sky`. Of a two-sided light model as many rows may follow for the other sides of the vertices, as
        `.behind` has them; without, those see the same.
    transport : Transport, optional
        How light goes between the vertices, where the light model has bounces: `mesh.phong.transport()` of a mesh with
        these points.

    Returns
    -------
    Shading
        With `.rgb` of shape (n, 3).

    Raises
    ------
    ValueError
        If an argument has the wrong shape, type or range, or `backend` is "numba" and Numba is missing; the message
        names it.

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
