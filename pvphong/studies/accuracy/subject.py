"""What is lit: checked arrays and what lights them, and how they are evaluated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pvphong.base.types import Backend, Float64Array, FloatArray, MatrixLike, Precision
from pvphong.geometry.extent import Sphere
from pvphong.optics.material import Material
from pvphong.rays.visibility import Visibility
from pvphong.scene.scene import Scene
from pvphong.shading import kernel, reference
from pvphong.shading.assembly import assemble
from pvphong.shading.equation import Equation
from pvphong.shading.parts import in_parts
from pvphong.shading.plan.plan import Plan, is_worth_loading
from pvphong.shading.result import Shading
from pvphong.shading.vertices import Vertices


@dataclass(frozen=True, eq=False)
class Subject:
    """What is lit, as checked arrays.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3).
    scene, material, matrix
        As for `evaluate`.
    screen : Visibility, optional
        What the points see, where the scene has shadows or ambient occlusion.
    """

    points: FloatArray
    normals: FloatArray
    scene: Scene
    material: Material
    matrix: MatrixLike | None
    screen: Visibility | None = None

    @cached_property
    def unshadowed(self) -> Subject:
        """The same without shadows and ambient occlusion: of what is inside triangles no rays are cast."""
        if not self.scene.light_model.needs_rays:
            return self
        scene = replace(self.scene, light_model=self.scene.light_model.without_rays())
        return replace(self, scene=scene, screen=None)

    def plan(self, tolerance: float = 0.0) -> Plan:
        """The plan at a tolerance."""
        return Plan.of(self.scene, self.material, self.vertices, matrix=self.matrix, tolerance=tolerance)

    @cached_property
    def vertices(self) -> Vertices:
        """Points and normals as evaluators take them."""
        return Vertices(self.points, self.normals, screen=self.screen)

    @cached_property
    def assembled(self) -> Equation:
        """The whole lighting equation."""
        return assemble(self.scene, self.material, self.matrix)

    @cached_property
    def equation(self) -> Equation:
        """The lighting equation without what adds exactly nothing."""
        return self.plan().equation

    @cached_property
    def truth(self) -> Float64Array:
        """Colours of the float64 reference."""
        return self.exact(self.equation)

    def exact(self, equation: Equation) -> Float64Array:
        """The float64 reference of any equation at the vertices."""
        result = Shading(np.empty((len(self.points), 3)))
        channels = self.vertices.channels(equation)
        reference.shade(self.points, self.normals, in_parts(equation), None, result, channels)
        return result.rgb

    @cached_property
    def sphere(self) -> Sphere:
        """Around the mesh in the world; of no size at the origin where it is not known."""
        return self.vertices.extent(self.assembled.matrix).sphere or Sphere((0.0, 0.0, 0.0), 0.0)

    @cached_property
    def has_kernel(self) -> bool:
        """Whether the kernel is there and takes the equation; asking compiles it for these types."""
        return self._takes("float32") and self._takes("float64")

    @property
    def backend(self) -> Backend:
        """The evaluator that `evaluate` takes for the vertices by itself."""
        return self.backend_for(len(self.points), self.equation)

    def backend_for(self, count: int, equation: Equation) -> Backend:
        """The evaluator that `evaluate` takes by itself for so many vertices and an equation."""
        return "numba" if self.has_kernel and is_worth_loading(count, equation) else "numpy"

    def _takes(self, precision: str) -> bool:
        result = Shading(np.empty((1, 3), precision))
        seen = self.vertices.channels(self.equation)
        one = None if seen is None else seen[:, :1]
        return kernel.shade(self.points[:1], self.normals[:1], self.equation, None, result, channels=one)

    def planned(self, equation: Equation, vertices: Vertices | None = None) -> Plan:
        """The plan of an equation that was rewritten from the whole one: without what adds exactly nothing."""
        return Plan.of_equation(equation, vertices or self.vertices)

    def runner(
        self,
        equation: Equation,
        precision: Precision = "float32",
        *,
        backend: Backend | None = None,
        scene: Scene | None = None,
    ) -> Callable[[], FloatArray]:
        """A run as `evaluate` does it: the equation of a scene is assembled, planned and evaluated.

        Parameters
        ----------
        equation : Equation
            The whole one, or one that was rewritten from it.
        precision : {"float32", "float64"}
            Of the colours.
        backend : str, optional
            What computes; what `evaluate` takes by itself, if not given.
        scene : Scene, optional
            What the equation stands for, if not the whole scene: the time counts that it takes to assemble it.
        """

        def run() -> FloatArray:
            assemble(scene or self.scene, self.material, self.matrix)
            chosen = backend or self.backend_for(len(self.points), equation)
            return self.planned(equation).run(self.vertices, precision=precision, backend=chosen).rgb

        return run
