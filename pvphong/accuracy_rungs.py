"""The rungs at the vertices: arithmetic and light models that trade accuracy for time, each as a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from pvphong import accuracy_effects as effects
from pvphong import kernel, reference
from pvphong._types import Float64Array, FloatArray, MatrixLike, Precision
from pvphong.accuracy_rows import Kind
from pvphong.effects import Extent
from pvphong.equation import Equation
from pvphong.evaluation import _is_worth_compiling as is_worth_compiling
from pvphong.lights import PointLight, SpotLight
from pvphong.material import Material
from pvphong.planning import Plan, make_plan
from pvphong.scene import Scene
from pvphong.shading import Shading
from pvphong.textbook import refuse_unknown, textbook_colors

REFERENCE = "float64 reference"

_FAR = 2.0
"""In radii of the mesh: from here the plan asks whether a light may be taken as directional."""


@dataclass(frozen=True, eq=False)
class Subject:
    """What is lit, as checked arrays.

    Parameters
    ----------
    points, normals : ndarray
        Shape (n, 3).
    scene, material, matrix
        As for `evaluate`.
    """

    points: FloatArray
    normals: FloatArray
    scene: Scene
    material: Material
    matrix: MatrixLike | None

    def plan(self, tolerance: float = 0.0) -> Plan:
        """The plan at a tolerance."""
        return make_plan(self.points, self.normals, self.scene, self.material, self.matrix, tolerance)

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
        return colors(self.points, self.normals, equation, "numpy", "float64")

    @cached_property
    def sphere(self) -> tuple[Float64Array, float]:
        """Middle and radius of the mesh in the world; around the origin where they are not known."""
        return Extent(self.points, self.normals, self.matrix).sphere or (np.zeros(3), 0.0)

    @cached_property
    def has_kernel(self) -> bool:
        """Whether the kernel is there and takes the equation; asking compiles it for these types."""
        return self._takes("float32") and self._takes("float64")

    @property
    def backend(self) -> str:
        """The evaluator that `evaluate` takes for as many vertices by itself."""
        return self.backend_for(len(self.points))

    def backend_for(self, count: int) -> str:
        """The evaluator that `evaluate` takes for so many vertices."""
        return "numba" if self.has_kernel and is_worth_compiling(count, self.equation) else "numpy"

    def _takes(self, precision: str) -> bool:
        result = Shading(np.empty((1, 3), precision))
        return kernel.shade(self.points[:1], self.normals[:1], self.equation, None, result)

    def runner(
        self, equation: Equation, backend: str, precision: Precision, scene: Scene | None = None
    ) -> Callable[[], FloatArray]:
        """A run of an equation as `evaluate` does it: the plan first, of another scene if one is given."""
        planned = self if scene is None else replace(self, scene=scene)

        def run() -> FloatArray:
            planned.plan()
            return colors(self.points, self.normals, equation, backend, precision)

        return run


def colors(points: FloatArray, normals: FloatArray, equation: Equation, backend: str, precision: Precision) -> Any:
    """Colours (n, 3) of an equation; what the kernel declines goes to the reference."""
    result = Shading(np.empty((len(points), 3), precision))
    if backend != "numba" or not kernel.shade(points, normals, equation, None, result):
        reference.shade(points, normals, equation, None, result)
    return result.rgb


@dataclass(frozen=True)
class Rung:
    """One way of lighting the vertices.

    Parameters
    ----------
    name : str
        What is done.
    kind : {"arithmetic", "light model"}
        What it trades for time.
    run : callable
        Gives the colours (n, 3).
    equation : Equation
        What it evaluates.
    backend, precision : str
        What computes.
    promised : float, optional
        The plan's bound.
    is_peer : bool
        Whether it is not pvphong's own.
    note : str
        Beside the name.
    """

    name: str
    kind: Kind
    run: Callable[[], FloatArray]
    equation: Equation
    backend: str
    precision: str
    promised: float | None = None
    is_peer: bool = False
    note: str = ""


def rungs(subject: Subject, tolerance: float) -> tuple[list[Rung], dict[str, str]]:
    """Every rung that the scene has a place for, and the reasons why others are left out."""
    found, left_out = list(_arithmetic(subject)), {}
    if not subject.has_kernel:
        left_out["kernel"] = "Numba is not installed, or declines this scene"
    try:
        refuse_unknown(subject.scene)
    except ValueError as error:
        left_out["textbook NumPy"] = str(error)
    else:
        found.append(_textbook(subject))
    for name, equation, reason in _simplified(subject):
        if reason:
            left_out[name] = reason
        else:
            found.append(_rewritten(subject, name, equation))
    found.append(_planned(subject, tolerance))
    return found, left_out


def _arithmetic(subject: Subject) -> Iterator[Rung]:
    variants: list[tuple[str, str, Precision]] = [
        (REFERENCE, "numpy", "float64"),
        ("float32 NumPy", "numpy", "float32"),
    ]
    if subject.has_kernel:
        variants += [("float64 kernel", "numba", "float64"), ("float32 kernel", "numba", "float32")]
    for name, backend, precision in variants:
        run = subject.runner(subject.equation, backend, precision)
        yield Rung(name, "arithmetic", run, subject.equation, backend, precision)


def _textbook(subject: Subject) -> Rung:
    def run() -> FloatArray:
        return textbook_colors(subject.points, subject.normals, subject.scene, subject.material, subject.matrix)

    note = "normalises, mirrors and raises to powers as a textbook writes it"
    return Rung("textbook NumPy", "arithmetic", run, subject.equation, "textbook", "float64", is_peer=True, note=note)


def _simplified(subject: Subject) -> Iterator[tuple[str, Equation, str]]:
    """Name, equation, and a reason to leave it out or an empty string."""
    whole, (middle, radius) = subject.equation, subject.sphere
    dull = "" if whole.has_highlights else "there is no highlight that depends on the viewer"
    yield (
        "infinite viewer",
        effects.with_infinite_viewer(whole, middle),
        dull or ("" if whole.eye is not None else "the viewer is at infinity already"),
    )
    other, sign = ("Blinn-Phong", "× 4") if whole.reflection == "phong" else ("Phong", "÷ 4")
    yield f"{other}, shininess {sign}", effects.with_other_reflection(whole, middle), dull
    far = any(
        isinstance(term.light, (PointLight, SpotLight)) and math.dist(term.light.position, middle) > _FAR * radius
        for term in whole.terms
    )
    yield (
        "far lights directional",
        effects.with_directional_lights(whole, middle, farther_than=_FAR * radius),
        "" if far else "no light with a position is farther away than the mesh's diameter",
    )
    shiny = any(any(term.specular) for term in whole.terms)
    yield "no highlights", effects.without_highlights(whole, middle), "" if shiny else "there are none"


def _rewritten(subject: Subject, name: str, equation: Equation) -> Rung:
    run = subject.runner(equation, subject.backend, "float32")
    return Rung(name, "light model", run, equation, subject.backend, "float32")


def plan_name(tolerance: float) -> str:
    """The plan's rung; a tolerance of whole display steps is named by them."""
    steps = tolerance * 255.0
    whole = round(steps)
    return f"plan at {whole}/255" if whole and abs(steps - whole) < 1e-9 else f"plan at {tolerance:.3g}"


def _planned(subject: Subject, tolerance: float) -> Rung:
    plan = subject.plan(tolerance)

    def run() -> FloatArray:
        equation = subject.plan(tolerance).equation
        return colors(subject.points, subject.normals, equation, subject.backend, "float32")

    bound = plan.error_bound
    return Rung(plan_name(tolerance), "light model", run, plan.equation, subject.backend, "float32", promised=bound)
