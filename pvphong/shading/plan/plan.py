"""Which effects a scene needs: the plan collects what each effect decides."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from pvphong.base import check
from pvphong.base.types import FloatArray, MatrixLike
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene, light_labels
from pvphong.shading.equation import Equation, assemble
from pvphong.shading.origin import beside_the_mesh
from pvphong.shading.plan.effects import EFFECTS, Decision, Draft, Extent, Note, Search

if TYPE_CHECKING:
    from rich.table import Table


@dataclass(frozen=True, eq=False)
class Plan:
    """What will run for a scene, a material and a mesh; `print(plan.explain())` shows it.

    Attributes
    ----------
    effects : mapping of str to Decision
        Every effect that exists, in the order in which they are left out: whether it is on, and why.
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

    def __getstate__(self) -> dict[str, Any]:
        """For copies and other processes, which cannot take a view of a mapping."""
        return vars(self) | {"effects": dict(self.effects)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """As it was."""
        vars(self).update(state, effects=MappingProxyType(state["effects"]))

    def explain(self) -> str:
        """A table of all effects: on or off, why, what they read, at what error, and about what they cost.

        Nanoseconds are those of the compiled evaluator in float32 on one core of a server's processor of 2022,
        as estimates; `tradeoff` measures what leaving out an effect saves where you are.
        """
        from rich.console import Console

        text = io.StringIO()
        Console(file=text, width=100, color_system=None, markup=False, emoji=False).print(self._table())
        depends = "change" if self.view_dependent else "do not change"
        reads = ", ".join(sorted(self.needs)) or "nothing"
        lines = [
            *(line.rstrip() for line in text.getvalue().splitlines()),
            "ns/vertex: estimates for the compiled evaluator in float32 on one core.",
            f"It reads {reads}; the colours {depends} when the viewer moves.",
        ]
        return "\n".join(lines) + "\n"

    def _table(self) -> Table:
        from rich import box
        from rich.table import Table

        spent = {effect.name: effect.nanoseconds(self.effects[effect.name]) for effect in EFFECTS}
        title = f"error bound {self.error_bound:.3g}, tolerance {self.tolerance:.3g}"
        title = title if self.tolerance else "exact: tolerance 0"
        table = Table(title=title, box=box.SIMPLE, padding=(0, 1, 0, 0), show_footer=True, expand=True)
        table.add_column("effect", "sum", no_wrap=True)
        table.add_column("", no_wrap=True)
        table.add_column("why", ratio=1, overflow="fold")
        table.add_column("reads", no_wrap=True)
        taken = sum(choice.bound for choice in self.effects.values())
        table.add_column("bound", f"{taken:.2g}", justify="right", no_wrap=True)
        table.add_column("ns/vertex", f"{sum(spent.values()):.1f}", justify="right", no_wrap=True)
        for effect in EFFECTS:
            choice = self.effects[effect.name]
            reads = ", ".join(effect.inputs) if choice.on else ""
            bound = f"{choice.bound:.2g}" if choice.bound else ""
            cost = f"{spent[effect.name]:.1f}" if spent[effect.name] else ""
            table.add_row(effect.name, "on" if choice.on else "off", choice.why, reads, bound, cost)
        return table


def make_plan(
    points: FloatArray,
    normals: FloatArray | None,
    scene: Scene,
    material: Material,
    matrix: MatrixLike | None,
    tolerance: float,
    search: Search | None = None,
) -> Plan:
    """The plan for vertices whose arrays have been checked; without normals fewer highlights can be ruled out."""
    return plan_equation(beside_the_mesh(assemble(scene, material, matrix)), points, normals, scene, tolerance, search)


def plan_equation(
    equation: Equation,
    points: FloatArray,
    normals: FloatArray | None,
    scene: Scene,
    tolerance: float,
    search: Search | None = None,
) -> Plan:
    """The plan for the equation of a scene, or one that was rewritten from it."""
    labels = light_labels(scene, "light ")
    draft = Draft.first(
        equation=equation,
        labels=labels,
        extent=Extent(points, normals, equation.matrix, search),
        tolerance=tolerance,
        notes=tuple(
            Note("lights", label, "switched off")
            for label, light in zip(labels, scene.world_lights, strict=True)
            if not light.on
        ),
    )
    draft = reduce(lambda so_far, effect: effect.simplify(so_far), EFFECTS, draft)
    left = draft.equation
    return Plan(
        effects=MappingProxyType({effect.name: effect.decide(draft) for effect in EFFECTS}),
        needs=_needs(left),
        view_dependent=(
            left.has_highlights
            or left.is_flipped
            or any(note.here for note in draft.notes)
            or _has_riding_light(equation, scene)
        ),
        tolerance=tolerance,
        error_bound=draft.error_bound,
        equation=left,
    )


def check_scene_and_material(scene: Any, material: Any) -> None:
    """Raise ValueError unless they are what their names say."""
    if not isinstance(scene, Scene):
        check.refuse("scene", scene, "a Scene", "Put lights into Scene(lights=[...]).")
    if not isinstance(material, Material):
        check.refuse("material", material, "a Material", "Material.from_property makes one of a pyvista.Property.")


def _needs(equation: Equation) -> frozenset[str]:
    needs = {
        "points": equation.needs_points,
        "normals": equation.needs_normals,
        "viewer": equation.has_highlights or equation.is_flipped,
    }
    return frozenset(name for name, needed in needs.items() if needed)


def _has_riding_light(equation: Equation, scene: Scene) -> bool:
    """Whether a light that shines moves with the viewer: left out here, it may reach the mesh from elsewhere."""
    lights = tuple(scene.lights)
    return any(lights[term.index].frame != "world" and not term.is_black for term in equation.terms)
