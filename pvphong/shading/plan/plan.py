"""The plan for a scene: the simplified equation, its evaluation, and an explanation of each effect.

With backend="auto", `Plan.run` uses the compiled evaluator (`kernel.evaluation`) if there is enough work, and else the
readable evaluator (`reference`). The readable evaluator also lights the vertices that the compiled evaluator declines.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, get_args

import numpy as np

from pvphong.base import check
from pvphong.base.text import html_table, rendered, wrapped
from pvphong.base.types import Backend, ByteArray, FloatArray, MatrixLike, Precision
from pvphong.geometry.extent import ANYWHERE
from pvphong.geometry.transform import normal_matrix
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading import interreflection, kernel, reference
from pvphong.shading.equation import Equation, in_parts, relative_to_mesh
from pvphong.shading.interreflection import Radiosity
from pvphong.shading.plan.effects import EFFECTS
from pvphong.shading.plan.state import Decision, PlanState
from pvphong.shading.reference import Shading
from pvphong.shading.vertices import Vertices
from pvphong.shading.visibility import known_transport

# Least product of the numbers of vertices and lights for which the compiled evaluator is worth the half second that it
# takes to load. The rule is independent of earlier calls, so that equal calls on few vertices return equal bits.
_WORTH_LOADING = 2**18
# Cost of bounces as a number of lights: the light that vertices send and their albedo are evaluated, the albedo by
# lighting the vertices with a sky.
_AS_LIGHT_THAT_BOUNCES = 32
# The corresponding product for windows, once the compiled evaluator is loaded. Here bits may depend on earlier calls,
# because displayed colours are rounded anyway.
_WORTH_STARTING = 2**13

_FACES_AWAY = (
    "Every vertex faces away from every light: only ambient light and emission remain. To light the surface, turn it "
    "with flip_faces(), including its stored normals, or light both sides with LightModel(two_sided=True)."
)


@dataclass(frozen=True, eq=False, repr=False)
class Plan:
    """Plan for a scene, a material and a mesh. `print(plan)` is a summary, `print(plan.explain())` gives the reasons.

    Attributes
    ----------
    effects : mapping of str to Decision
        Decision on every effect, in the order in which plans try to remove them.
    needs : frozenset of str
        Inputs that will be read: some of "points", "normals", "tangents" and "viewer".
    view_dependent : bool
        True if the colours change when the viewer moves.
    tolerance : float
        Colour error that was allowed.
    error_bound : float
        Bound on the absolute colour error, apart from rounding; at most `tolerance`.
    faces_away : bool
        True if every vertex faces away from every light, so that only ambient light and emission remain. Only computed
        in plans for meshes.
    equation : Equation
        The simplified equation, which evaluators run.
    whole : Equation
        The equation before simplification. This equation determines the evaluator and the types, so that no vertex's
        bits depend on the positions of other vertices.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> plan = pv.Sphere().phong.plan(ph.DirectionalLight(), ph.Material())
    >>> plan.view_dependent
    False
    """

    view_dependent: bool
    tolerance: float
    error_bound: float
    equation: Equation
    whole: Equation
    _state: PlanState
    faces_away: bool = False
    maps: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def effects(self) -> Mapping[str, Decision]:
        """Decision on every effect, computed at the first use because running a plan does not need it."""
        return MappingProxyType({effect.name: effect.decide(self._state) for effect in EFFECTS})

    @cached_property
    def needs(self) -> frozenset[str]:
        """Inputs that will be read: some of "points", "normals", "tangents" and "viewer"."""
        equation = self._state.equation
        read = {
            "points": equation.needs_points or equation.needs_visibility or equation.bounces > 0,
            "normals": equation.needs_normals or equation.needs_visibility or equation.bounces > 0,
            "tangents": "tangents" in equation.channels,
            "viewer": equation.has_highlights or equation.is_flipped,
        }
        return frozenset(name for name, is_read in read.items() if is_read)

    @classmethod
    def of(
        cls,
        scene: Scene,
        material: Material,
        vertices: Vertices,
        *,
        matrix: MatrixLike | None = None,
        tolerance: float = 0.0,
    ) -> Plan:
        """Return the plan for vertices with a material in a scene. The scene must have a viewer; `as_scene` adds one.

        The vertices' normals are read only if they may show that an effect is not needed.

        Raises
        ------
        ValueError
            If material, matrix or tolerance is invalid.
        """
        tolerance = check.number("tolerance", tolerance, at_least=0.0)
        if matrix is not None:
            normal_matrix(matrix)  # refuses singular matrices, even if the scene does not need it
        whole = vertices.equation(scene, material, matrix)
        return cls.of_equation(relative_to_mesh(whole), vertices, tolerance)

    @classmethod
    def of_equation(cls, whole: Equation, vertices: Vertices, tolerance: float = 0.0) -> Plan:
        """Return the plan for vertices and `whole`, an equation that is not simplified yet.

        `whole` is the equation of a scene, or an equation derived from it. `tolerance` is the largest allowed colour
        error.
        """
        state = PlanState.first(whole, tolerance, vertices)
        for effect in EFFECTS:
            state = effect.simplify(state)
        left = state.equation
        may_move = any(term.follows_viewer and not term.is_black for term in whole.terms)  # and may then reach the mesh
        may_return = any(note.only_for_this_viewer for note in state.simplifications)
        return cls(
            view_dependent=left.has_highlights or left.is_flipped or may_move or may_return,
            tolerance=tolerance,
            error_bound=min(state.error_bound ** (1.0 / whole.gamma), tolerance),
            equation=in_parts(left),
            whole=in_parts(whole),
            # a plan must not keep the vertices alive
            _state=replace(state, extent=ANYWHERE, visibility=None, transport=None, _reaches={}),
        )

    def run(
        self,
        vertices: Vertices,
        *,
        precision: Precision = "float32",
        backend: Backend = "auto",
        components: bool = False,
        bounced: FloatArray | None = None,
        among: int = 0,
    ) -> Shading:
        """Compute lit colours of the planned vertices, or of some of them.

        The readable evaluator lights the vertices that the compiled evaluator declines.

        Parameters
        ----------
        vertices : Vertices
            The vertices.
        precision, backend, components
            As for `pvphong.evaluate`.
        bounced : ndarray, optional
            Shape (k, n, 3): bounced light, needed if other meshes send light too; see `interreflection.bounced`. By
            default it is computed from the vertices' own transport.
        among : int, default 0
            Total number of vertices in a series of calls that this call belongs to; 0 for a single call. With
            `backend="auto"`, this number decides whether compiled code is used.

        Raises
        ------
        ValueError
            If an option has a value that `pvphong.evaluate` does not accept; if `backend` is "numba" and Numba is
            missing; if shadows are needed and `vertices` has no visibility; or if bounces are needed and `vertices` has
            no transport.
        """
        real = np.dtype(check.choice("precision", precision, get_args(Precision)))
        components = check.flag("components", components)
        kernel.check_backend(backend)
        equation = self.equation
        if equation.bounces:
            how: Any = {"precision": precision, "backend": backend}
            if bounced is None:
                transport, sent = known_transport(vertices), self.sent(vertices, **how)
                bounced = interreflection.bounced(sent, transport.gather, equation.bounces, apart=components)
            direct = replace(self, equation=interreflection.direct_light(equation))
            return _with_bounced(direct.run(vertices, components=components, **how), bounced, equation)
        result = Shading.empty(len(vertices), self.whole.lights, real, equation if components else None)
        normals, channels = vertices.normals_if(equation.needs_normals), vertices.channels(equation)
        waits = backend == "numba"
        tries_compiled = waits or (backend == "auto" and is_worth_loading(among or len(vertices), self.whole))
        compiled = kernel.evaluator() if tries_compiled else None
        arrays = vertices.points, normals, equation, vertices.tints(equation), result
        if compiled is None or not compiled(*arrays, self.whole, channels=channels, waits=waits):
            reference.shade(*arrays, channels)
        return result

    def sent(self, vertices: Vertices, *, precision: Precision = "float32", backend: Backend = "auto") -> Radiosity:
        """Return the light that the vertices send before any bounce, and their albedo.

        `precision` and `backend` are as for `pvphong.evaluate`.

        Raises
        ------
        ValueError
            As for `run`; or if a vertex reflects more light than arrives.
        """

        def lit(equation: Equation) -> FloatArray:
            return replace(self, equation=equation).run(vertices, precision=precision, backend=backend).rgb

        rewritten = interreflection.directly_lit, interreflection.ambient_alone, interreflection.under_white_sky
        direct, ambient, white = (lit(each(self.equation)) for each in rewritten)
        return Radiosity(direct, ambient, interreflection.without_gain(white, self.equation))

    def run_for_display(self, vertices: Vertices, out: ByteArray, bounced: FloatArray | None = None) -> None:
        """Compute lit colours in float32 and write them as 0-255 into `out`, shape (n, 3), uint8.

        `bounced`, shape (k, n, 3), is bounced light, needed if other meshes send light too. By default it is computed
        from the vertices' own transport.
        """
        equation, least = self.equation, _WORTH_STARTING if kernel.has_run() else _WORTH_LOADING
        if not equation.bounces and len(out) * len(self.whole.terms) >= least:
            normals, channels = vertices.normals_if(equation.needs_normals), vertices.channels(equation)
            arrays = vertices.points, normals, equation, vertices.tints(equation), Shading(out)
            compiled = kernel.evaluator()
            if compiled is not None and compiled(*arrays, self.whole, channels=channels, waits=False):
                return
        rgb = self.run(vertices, backend="auto" if equation.bounces else "numpy", bounced=bounced).rgb
        np.clip(rgb, 0.0, 1.0, out=rgb)
        rgb *= 255.0
        np.rint(rgb, out=out, casting="unsafe")

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for copying and pickling, without `effects`, whose mapping view cannot be pickled."""
        return {name: value for name, value in vars(self).items() if name != "effects"}

    def __str__(self) -> str:
        running = [name for name, decision in self.effects.items() if decision.on]
        off = [name for name, decision in self.effects.items() if not decision.on]
        runs = f"Runs: {', '.join(running) or 'nothing'}. Left out: {', '.join(off) or 'nothing'}."
        cost = f"{self._accuracy}; ~{sum(self._nanoseconds):.1f} ns per vertex. {self._names}"
        return "\n".join(line for sentence in (runs, cost.rstrip(), *self._said) for line in wrapped(sentence))

    def __repr__(self) -> str:
        running = sum(decision.on for decision in self.effects.values())
        return f"<Plan: {running} of {len(self.effects)} effects run, error bound {self.error_bound:.3g}>"

    def _repr_html_(self) -> str:
        title = f"Plan: {self._accuracy}" + (f". {_FACES_AWAY}" if self.faces_away else "")
        return html_table(title, ("effect", "", "why", "reads", "bound", "ns"), self._rows)

    def explain(self) -> str:
        """Return a table, as text, of all effects: on or off, reason, inputs, error bound and approximate cost.

        Nanoseconds are estimates for the compiled evaluator in float32 on one core of a server's processor of 2022.
        `tradeoff` measures on your machine how much time omitting an effect saves.
        """
        from rich import box
        from rich.table import Table

        taken = sum(decision.bound for decision in self.effects.values())
        table = Table(title=self._accuracy, box=box.SIMPLE, padding=(0, 1, 0, 0), show_footer=True, expand=True)
        table.add_column("effect", "sum", no_wrap=True)
        table.add_column("", no_wrap=True)
        table.add_column("why", ratio=1, overflow="fold")
        table.add_column("reads", width=len("normals,"))
        table.add_column("bound", f"{taken:.2g}", justify="right", no_wrap=True)
        table.add_column("ns", f"{sum(self._nanoseconds):.1f}", justify="right", no_wrap=True)
        for row in self._rows:
            table.add_row(*row)
        estimates = "ns: per vertex, estimated for the compiled evaluator in float32 on one core."
        return rendered([table, estimates, *[self._names] * bool(self.maps), *self._said]) + "\n"

    @property
    def _accuracy(self) -> str:
        error = f"Error at most {self.error_bound:.3g}" if self.error_bound else "Exact"
        return f"{error}, tolerance {self.tolerance:.3g}"

    @property
    def _said(self) -> tuple[str, ...]:
        """Sentences on the inputs that change the colours, and a warning if all vertices face away from all lights."""
        reads = ", ".join(sorted(self.needs)) or "nothing"
        depends = "change" if self.view_dependent else "do not change"
        dependence = f"It reads {reads}; the colours {depends} when the viewer moves."
        return (dependence, _FACES_AWAY) if self.faces_away else (dependence,)

    @property
    def _names(self) -> str:
        """A sentence on the names in the user's material: what each stands for, such as an array. "" without names."""
        listed = ", ".join(f"{name} is {what}" for name, what in self.maps.items())
        return f"By name, {listed}." if listed else ""

    @property
    def _nanoseconds(self) -> list[float]:
        """Approximate cost of each effect, in nanoseconds per vertex."""
        return [effect.nanoseconds(self.effects[effect.name]) for effect in EFFECTS]

    @property
    def _rows(self) -> list[tuple[str, ...]]:
        """Table row of each effect: name, on or off, reason, inputs, bound, nanoseconds."""
        rows: list[tuple[str, ...]] = []
        for effect, nanoseconds in zip(EFFECTS, self._nanoseconds, strict=True):
            decision = self.effects[effect.name]
            reads = ", ".join(effect.inputs) if decision.on else ""
            bound = f"{decision.bound:.2g}" if decision.bound else ""
            cost = f"{nanoseconds:.1f}" if nanoseconds else ""
            rows.append((effect.name, "on" if decision.on else "off", decision.why, reads, bound, cost))
        return rows


def _with_bounced(direct: Shading, bounced: FloatArray, equation: Equation) -> Shading:
    """Add bounced light, shape (k, n, 3), to direct light in place, and clamp the sum if the equation clamps.

    If components were requested, return a record that also has the bounced light.
    """
    direct.rgb[:] += bounced.sum(axis=0)
    if equation.clamp:
        np.clip(direct.rgb, 0.0, 1.0, out=direct.rgb)
    return direct if direct.base is None else replace(direct, bounced=bounced.astype(direct.rgb.dtype, copy=False))


def is_worth_loading(count: int, equation: Equation) -> bool:
    """Return True if lighting `count` vertices is enough work to load the compiled evaluator.

    `backend="auto"` then uses this evaluator, if its code has been compiled already.
    """
    lights = len(equation.terms) + (_AS_LIGHT_THAT_BOUNCES if equation.bounces else 0)
    return count * lights >= _WORTH_LOADING


def load_compiled() -> None:
    """Load the compiled evaluator, if its code has been compiled. Windows then use it for small meshes too.

    Loading takes half a second or more. This function may be called in another thread.
    """
    vertices = Vertices(np.zeros((1, 3), np.float32), np.array([[0.0, 0.0, 1.0]], np.float32))
    planned = Plan.of(Scene([LIGHT_TYPES["directional"]()], Viewer()), Material(), vertices)
    planned.run(vertices, among=_WORTH_LOADING)
