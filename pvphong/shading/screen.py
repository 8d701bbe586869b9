"""What stands before vertices, as plans and evaluators ask of it; `pvphong.rays` answers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NoReturn, Protocol, cast

from pvphong.base import check
from pvphong.base.types import FloatArray, MatrixLike
from pvphong.geometry.transform import transform_points
from pvphong.optics.light import Light
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene, light_labels
from pvphong.shading.equation import Equation


class Screen(Protocol):
    """What n vertices see of a scene's lights, and of the sky."""

    def why_clear(self, light: int) -> str:
        """Why nothing can block a light; "" where something may."""

    def why_open(self) -> str:
        """Why nothing can hide the sky; "" where something may."""

    def channels(self, lights: Sequence[int], *, sky: bool) -> FloatArray:
        """Parts that are seen, in [0, 1], shape (all the scene's lights + 1, n), the sky's in the last row.

        Rows that are not asked for may hold anything finite.
        """

    def refuse_other(
        self, points: FloatArray, lights: Sequence[Light], labels: Sequence[str], model: LightModel
    ) -> None:
        """Raise ValueError unless it is of these vertices and lights in the world, and of such a light model."""


def checked_screen(name: str, given: Any, points: FloatArray, matrix: MatrixLike | None, scene: Scene) -> Screen:
    """What a user gives as what the vertices see.

    Raises
    ------
    ValueError
        If it is something else, or was made for other points or lights.
    """
    if not hasattr(given, "refuse_other"):
        check.refuse(name, given, "what mesh.phong.visibility(scene) gives")
    world = points if matrix is None else transform_points(points, matrix)
    given.refuse_other(world, scene.world_lights, light_labels(scene), scene.light_model)
    return cast(Screen, given)


def channels_for(equation: Equation, screen: Screen | None) -> FloatArray:
    """What an equation that has a screen reads of it.

    Raises
    ------
    ValueError
        If there is none.
    """
    return _refuse_unknown() if screen is None else screen.channels(equation.shadowed, sky=equation.is_occluded)


def refuse_rays(scene: Scene, where: str) -> None:
    """Raise ValueError for a scene with shadows or ambient occlusion, where nobody casts rays."""
    if scene.light_model.needs_rays:
        remedy = "scene.light_model.without_rays() is the same without them; mesh.phong.shade of the result casts them."
        check.refuse("light_model", "one with them", f"without shadows and ambient occlusion {where}", remedy)


def _refuse_unknown() -> NoReturn:
    allowed = "without shadows and ambient occlusion where only points are known"
    remedy = "mesh.phong.shade casts the rays itself; evaluate takes visibility=mesh.phong.visibility(scene)."
    check.refuse("light_model", "one with them", allowed, remedy)
