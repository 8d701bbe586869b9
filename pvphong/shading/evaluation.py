"""From a scene to colours: checks the arguments, puts the equation together, has it evaluated."""

from __future__ import annotations

from typing import Any, get_args

import numpy as np

from pvphong.base import check
from pvphong.base.types import Backend, ByteArray, FloatArray, MatrixLike, Precision
from pvphong.geometry.transform import normal_matrix
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
from pvphong.shading import kernel, reference
from pvphong.shading.albedo import checked_albedo
from pvphong.shading.equation import Equation, assemble
from pvphong.shading.origin import beside_the_mesh
from pvphong.shading.plan.plan import check_scene_and_material, plan_equation
from pvphong.shading.result import Shading

# Vertices times lights from which the compiled evaluator is worth the half second that it takes to load, or once per
# installation the ten or more that it takes to compile. The rule looks at nothing that has been called before, so that
# equal calls give equal bits.
_WORTH_COMPILING = 2**18
# Vertices whose float colours are held at once on their way to 0-255.
_DISPLAYED_AT_ONCE = 2**17


def evaluate(
    points: Any,
    normals: Any,
    scene: Scene,
    material: Material,
    *,
    matrix: MatrixLike | None = None,
    albedo: Any = None,
    precision: Precision = "float32",
    backend: Backend = "auto",
    tolerance: float = 0.0,
    components: bool = False,
) -> Shading:
    """Lit colours of vertices by the Phong or Blinn-Phong equation.

    Sources: Phong, "Illumination for computer generated pictures" (1975); Blinn, "Models of light
    reflection for computer synthesized pictures" (1977); OpenGL 2.1 specification, section 2.14.1.

    A zero or non-finite normal is unlit: emission and ambient light only. A vertex whose point is not finite
    gets nothing from lights with a position, and no highlight if the viewer is local. A light on a vertex adds
    neither diffuse nor specular there, and an eye on a vertex sees no highlight. So every colour is finite.

    Parameters
    ----------
    points : array_like
        Shape (n, 3), in the mesh's own coordinates. Other types than float32 and float64 are widened.
    normals : array_like
        Shape (n, 3), of any length; they need not be unit vectors.
    scene : Scene
        Lights, viewer and light model, in world coordinates.
    material : Material
        The surface's reflectances.
    matrix : array_like, optional
        (4, 4) model matrix: points are transformed by it, normals by its inverse-transpose.
        Positions are summed in float64. Where its offset is so long that this shows in float32, it is taken out of
        lights and eye first, if no light is of a kind of your own.
    albedo : array_like, optional
        Shape (n, 3): multiplies the material's ambient and diffuse. uint8 counts as 0-255; floats are
        clipped to [0, 1], a NaN counts as 0.
    precision : {"float32", "float64"}
        Of the result, and of the arithmetic after positions are subtracted. float32 errs by at most
        (4√n + 16) · 2⁻²⁴ · (1 + number of lights) for colours of size 1, n the largest of the material's
        shininess and the spot lights' exponents. (A power between 0 and 1 errs by more where its cosine is
        nearly 0: it is infinitely steep there.)
    backend : {"auto", "numpy", "numba"}
        Which evaluator computes: the readable one in NumPy, or the compiled one, which needs the extra `fast`.
        "auto" takes the compiled one where it is installed and the work is worth its start: half a second per
        process, and once per installation and combination of float types ten seconds or more to compile. What it
        cannot do (components, kinds of light of your own, coordinates beyond 2¹⁰⁰) NumPy does.
    tolerance : float, default 0
        Largest absolute colour error that may be traded for time; 0 allows no approximation.
    components : bool, default False
        Whether the result has its ambient, diffuse, specular, emission, base and per-light arrays too.

    Returns
    -------
    Shading
        With `.rgb` of shape (n, 3).

    Raises
    ------
    ValueError
        If an argument has the wrong shape, type or range, or Numba is asked for and missing; the message
        names it.
    """
    points = check.array("points", points)
    normals = check.array("normals", normals, count=len(points))
    check_scene_and_material(scene, material)
    real = np.dtype(check.choice("precision", precision, get_args(Precision)))
    check.choice("backend", backend, get_args(Backend))
    tolerance = check.number("tolerance", tolerance, at_least=0.0)
    shades = None if albedo is None else checked_albedo(albedo, len(points))
    if matrix is not None:
        normal_matrix(matrix)  # refuses what cannot light, also where the scene does not need it
    whole = beside_the_mesh(assemble(scene, material, matrix))
    left = plan_equation(whole, points, normals, scene, tolerance, kernel.find_bounds).equation
    result = _empty(len(points), len(scene.world_lights), real, check.flag("components", components))
    _run(points, normals, whole, left, shades, result, backend)
    return result


def _run(
    points: FloatArray,
    normals: FloatArray,
    whole: Equation,
    left: Equation,
    albedo: Any,
    result: Shading,
    backend: Backend,
) -> None:
    """Evaluate what a plan has left of the whole equation, by the evaluator that the whole of it chooses.

    What is left depends on where the vertices are, and no vertex is to have other bits for that.
    """
    obstacle = kernel.obstacle() if backend == "numba" else None
    if obstacle is not None:
        where, remedy = obstacle
        check.refuse("backend", backend, f"'auto' or 'numpy' {where}", remedy)
    compiled = backend == "numba" or (backend == "auto" and is_worth_compiling(len(points), whole))
    if not (compiled and kernel.shade(points, normals, left, albedo, result, whole)):
        reference.shade(points, normals, left, albedo, result)


def is_worth_compiling(count: int, equation: Equation) -> bool:
    """Whether `backend="auto"` takes the compiled evaluator: not for few vertices, nor where it would compile anew."""
    return count * len(equation.terms) >= _WORTH_COMPILING and kernel.keeps_code()


def display_colors(
    points: FloatArray, normals: FloatArray, whole: Equation, left: Equation, albedo: Any, out: ByteArray
) -> None:
    """Lit colours for a display, computed in float32 and written in place as 0-255.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3), checked.
    whole, left : Equation
        What to evaluate, and what a plan leaves of it.
    albedo : array_like or None
        As for `evaluate`.
    out : ndarray
        Shape (n, 3), uint8.
    """
    shades = None if albedo is None else checked_albedo(albedo, len(points))
    if is_worth_compiling(len(points), whole) and kernel.shade(points, normals, left, shades, Shading(out), whole):
        return
    for start in range(0, len(points), _DISPLAYED_AT_ONCE):
        part = slice(start, start + _DISPLAYED_AT_ONCE)
        shading = Shading(np.empty((len(points[part]), 3), np.float32))
        reference.shade(points[part], normals[part], left, None if shades is None else shades[part], shading)
        np.rint(np.clip(shading.rgb, 0.0, 1.0) * 255.0, out=out[part], casting="unsafe")


def _empty(count: int, lights: int, real: np.dtype[Any], components: bool) -> Shading:
    rgb = np.empty((count, 3), real)
    if not components:
        return Shading(rgb)
    ambient, diffuse, specular, emission, base = (np.zeros((count, 3), real) for _ in range(5))
    per_light = np.zeros((lights, count, 3), real)
    return Shading(rgb, ambient, diffuse, specular, emission, per_light, base)
