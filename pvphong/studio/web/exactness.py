"""The panel "Advanced" in words: how exact the picture is, what is left out, and the table of a plan.

A plan lists the effects, such as shadows, that are computed for a mesh, and bounds the error of those left out.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

from pvphong.meshes.lit import plan
from pvphong.meshes.surfaces import shallow_copy
from pvphong.scene.scene import Scene
from pvphong.shading.plan.effects import EFFECTS
from pvphong.shading.plan.plan import Plan
from pvphong.studio.lit_actors import LitActors
from pvphong.studio.lit_mesh import LitMesh
from pvphong.studio.refining import Refining
from pvphong.studio.web.messages import Remedy
from pvphong.studio.web.settings import Accuracy

_STEP = 1.0 / 255.0
"""One step of a screen."""

_LEFT_OUT = re.compile(r"\(left out: (?P<what>.*)\)$")


class Exactness(NamedTuple):
    """A summary of the picture's accuracy.

    Parameters
    ----------
    text : str
        A sentence on the accuracy, and a second one on the lights that are left out.
    improve : Remedy
        Button that makes the picture more exact. If it is exact already, the button starts a measurement.
    """

    text: str
    improve: Remedy


def exactness(plans: Sequence[Plan], accuracy: Accuracy, *, is_refined: bool, is_paused: bool = False) -> Exactness:
    """Return the summary for the plans of all visible meshes.

    Parameters
    ----------
    plans : sequence of Plan
        The plans.
    accuracy : Accuracy
        Tolerance of the plans, and of refined pictures.
    is_refined : bool
        True if refining has reached its tolerance.
    is_paused : bool, default False
        True if refining has paused after its time limit, until a click continues it.
    """
    error = max((made.error_bound for made in plans), default=0.0)
    has_edges = any(plan.effects[name].on for plan in plans for name in ("shadow", "cone"))
    if accuracy.refine is None:
        between = " and blended between them" + (", so edges of shadows may look ragged" if has_edges else "")
    elif not is_refined:
        between = " and blended between them, as refining is not complete"
    else:
        between = f", and off by at most {_in_steps(accuracy.refine)} between them"
    at_points = f"off by at most {_in_steps(error)}" if error else "exact"
    left_out = _left_out(plans)
    text = f"Every colour is {at_points} at the points of the mesh{between}. "
    text += f"Left out: {left_out}." if left_out else "Nothing is left out."
    if accuracy.refine is None:
        improve = Remedy("Refine between the points", [["edit", ["accuracy.refine", _STEP]]])
    elif is_paused:
        improve = Remedy("Go on refining", [["go_on_refining", []]])
    elif error or accuracy.tolerance:
        improve = Remedy("Leave nothing out", [["edit", ["accuracy.tolerance", 0]]])
    else:
        improve = Remedy("Check it by a measurement", [["report", []]])
    return Exactness(text, improve)


def _in_steps(error: float) -> str:
    """Return a colour error in steps of an 8-bit screen, in words, such as "half a step of a screen"."""
    steps = error / _STEP
    if steps < 0.1:
        return "a tenth of a step of a screen"
    if steps <= 0.5:
        return "half a step of a screen"
    return "one step of a screen" if steps <= 1.0 else f"{steps:.2g} steps of a screen"


def _left_out(plans: Sequence[Plan]) -> str:
    """Return the lights and parts of lights that the plans leave out, with reasons; "" if there are none."""
    found: dict[str, None] = {}  # keeps the order
    for made in plans:
        for decision in made.effects.values():
            if match := _LEFT_OUT.search(decision.why):
                for each in match["what"].split("; "):
                    light, _, reason = each.partition(": ")
                    found[f"{light} ({reason})" if reason else light] = None
    return ", ".join(found)


def refined_text(refining: Mapping[LitMesh, Refining], *, is_mixed: bool) -> str:
    """Return a text on the refined picture that is shown; "" if nothing is refined.

    Parameters
    ----------
    refining : mapping
        The refinement of each mesh.
    is_mixed : bool
        True if the faders of a mix are on. The meshes are then shown unrefined.
    """
    if not refining:
        return ""
    awaited = [each for each in refining.values() if each.is_awaited]
    reason = next((each.reason for each in refining.values() if each.reason), "")
    if is_mixed:
        return "not refined: a mix is on"
    added = sum(mesh.actor.mapper.dataset.n_points - mesh.drawn.n_points for mesh in refining if mesh.actor)
    if not added and (awaited or reason):
        return "refining" if awaited else f"not refined: {reason}"
    said = f"refined, {added:,} points added" if added else ""
    if not awaited and not reason:
        return said
    reached = [each.reached or 0.0 for each in refining.values()]
    within = f", error up to {max(reached):.2g}" if all(reached) else ""
    return said + within + (f"; {reason}" if reason else " so far")


def plans_of(lit: LitActors, scene: Scene, tolerance: float) -> dict[LitMesh, Plan]:
    """Return the plan of each visible mesh. A mesh that cannot be lit has none; the view shows the reason."""
    found = dict[LitMesh, Plan]()
    for mesh in lit.shown:
        surface = shallow_copy(mesh.drawn)
        surface.point_data.active_normals = mesh.normals
        with suppress(ValueError):
            where: dict[str, Any] = {"matrix": mesh.matrix, "occluders": lit.others(mesh)}
            found[mesh] = plan(surface, scene, mesh.material, tolerance=tolerance, **where)
    return found


def rows_of(made: Plan) -> list[list[str]]:
    """Return a row for each effect: name, on or off, reason, error bound, nanoseconds per vertex."""
    rows = []
    for effect in EFFECTS:
        decision = made.effects[effect.name]
        bound = f"{decision.bound:.2g}" if decision.bound else ""
        cost = f"{effect.nanoseconds(decision):.1f}" if decision.on else ""
        rows.append([effect.name, "on" if decision.on else "off", decision.why, bound, cost])
    return rows


def summary_of(made: Plan) -> str:
    """Return a sentence on the error and the cost of a plan."""
    error = f"off by at most {made.error_bound:.3g}" if made.error_bound else "exact"
    cost = sum(effect.nanoseconds(made.effects[effect.name]) for effect in EFFECTS)
    depends = "change" if made.view_dependent else "do not change"
    return f"Colours are {error} and {depends} when the viewer moves. Cost: about {cost:.1f} ns per vertex."
