"""Which effects a scene needs: the plan collects what each effect decides."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Any

from pvphong import _check
from pvphong._types import FloatArray, MatrixLike
from pvphong.effects import EFFECTS, Decision, Draft, Extent, Note
from pvphong.equation import Equation, assemble
from pvphong.material import Material
from pvphong.scene import Scene


@dataclass(frozen=True, eq=False)
class Plan:
    """What will run for a scene, a material and a mesh; `print(plan.explain())` shows it.

    Attributes
    ----------
    effects : mapping of str to Decision
        Every effect that exists, in running order: whether it is on, and why.
    needs : frozenset of str
        What will be read, of "points", "normals" and "viewer".
    view_dependent : bool
        Whether the colours change when the viewer moves.
    tolerance : float
        The colour error that was allowed.
    error_bound : float
        The largest absolute colour error that was taken for it, beside rounding; at most `tolerance`.
    equation : Equation
        What is left of the lighting equation; the evaluators run this.
    """

    effects: Mapping[str, Decision]
    needs: frozenset[str]
    view_dependent: bool
    tolerance: float
    error_bound: float
    equation: Equation

    def explain(self) -> str:
        """A table of all effects: on or off, why, what they read, at what error, and about what they cost.

        Nanoseconds are those of the compiled evaluator in float32 on one core of a server's processor of 2022,
        as estimates; `tradeoff` measures what leaving out an effect saves where you are.
        """
        from rich import box
        from rich.console import Console
        from rich.table import Table

        table = Table(title=f"error bound {self.error_bound:.3g} of {self.tolerance:.3g}", box=box.SIMPLE_HEAD)
        for heading in ("effect", "", "why", "reads", "error bound", "~ ns per vertex"):
            is_number = heading in ("error bound", "~ ns per vertex")
            table.add_column(heading, justify="right" if is_number else "left", overflow="fold")
        for effect in EFFECTS:
            choice = self.effects[effect.name]
            reads = ", ".join(effect.inputs) if choice.on else ""
            bound = f"{choice.bound:.2g}" if choice.bound else ""
            spent = effect.nanoseconds(choice)
            cost = f"{spent:.1f}" if spent else ""
            table.add_row(effect.name, "on" if choice.on else "off", choice.why, reads, bound, cost)
        text = io.StringIO()
        Console(file=text, width=100, color_system=None).print(table)
        depends = "change" if self.view_dependent else "do not change"
        reads = ", ".join(sorted(self.needs)) or "nothing"
        return f"{text.getvalue()}It reads {reads}; the colours {depends} when the viewer moves.\n"


def make_plan(
    points: FloatArray,
    normals: FloatArray | None,
    scene: Scene,
    material: Material,
    matrix: MatrixLike | None,
    tolerance: float,
) -> Plan:
    """The plan for vertices whose arrays have been checked; without normals fewer highlights can be ruled out."""
    return plan_equation(assemble(scene, material, matrix), points, normals, scene, tolerance)


def plan_equation(
    equation: Equation, points: FloatArray, normals: FloatArray | None, scene: Scene, tolerance: float
) -> Plan:
    """The plan for the equation of a scene, or one that was rewritten from it."""
    draft = Draft(
        equation=equation,
        labels=_labels(scene),
        extent=Extent(points, normals, equation.matrix),
        tolerance=tolerance,
        notes=tuple(
            Note("lights", label, "switched off")
            for label, light in zip(_labels(scene), scene.world_lights, strict=True)
            if not light.on
        ),
    )
    draft = reduce(lambda so_far, effect: effect.simplify(so_far), EFFECTS, draft)
    equation = draft.equation
    return Plan(
        effects={effect.name: effect.decide(draft) for effect in EFFECTS},
        needs=_needs(equation),
        view_dependent=_is_view_dependent(equation, scene) or any(note.here for note in draft.notes),
        tolerance=tolerance,
        error_bound=draft.error_bound,
        equation=equation,
    )


def check_scene_and_material(scene: Any, material: Any) -> None:
    """Raise ValueError unless they are what their names say."""
    if not isinstance(scene, Scene):
        _check.refuse("scene", scene, "a Scene", "Put lights into Scene(lights=[...]).")
    if not isinstance(material, Material):
        _check.refuse("material", material, "a Material", "Material.from_property makes one of a pyvista.Property.")


def _labels(scene: Scene) -> tuple[str, ...]:
    return tuple(light.name or f"light {index}" for index, light in enumerate(scene.world_lights))


def _needs(equation: Equation) -> frozenset[str]:
    needs = {
        "points": equation.needs_points,
        "normals": equation.needs_normals,
        "viewer": equation.has_highlights or equation.is_flipped,
    }
    return frozenset(name for name, needed in needs.items() if needed)


def _is_view_dependent(equation: Equation, scene: Scene) -> bool:
    """Through highlights, through turned normals, or through a light that rides along with the viewer."""
    lights = tuple(scene.lights)
    rides = any(lights[term.index].frame != "world" for term in equation.terms)
    return rides or equation.has_highlights or equation.is_flipped
