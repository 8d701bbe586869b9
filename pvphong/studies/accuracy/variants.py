"""Variants of the lighting at the vertices: arithmetic and light models that trade accuracy for time, as runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from pvphong.base.types import Backend, FloatArray, Precision
from pvphong.optics.reflectances import counterpart_of
from pvphong.shading.equation import Equation
from pvphong.shading.parts import as_nodes
from pvphong.studies.accuracy import simplifications
from pvphong.studies.accuracy.rows import UNTIMED, Errors, Kind, Row
from pvphong.studies.accuracy.subject import Subject
from pvphong.studies.accuracy.textbook import refuse_unknown, textbook_colors

REFERENCE = "float64 reference"

_NODES = 1, 4, 16, 64
"""As so many lights without a size one that has it is tried."""

_FAR = 2.0
"""In radii of the mesh: from here the plan asks whether a light may be taken as directional."""


@dataclass(frozen=True)
class Variant:
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

    def row(self, arithmetic: Errors, light_model: Errors) -> Row:
        """Its row of the report, not timed yet."""
        return Row(
            name=self.name,
            kind=self.kind,
            time=UNTIMED,
            arithmetic=arithmetic,
            light_model=light_model,
            interpolation=None,
            points=arithmetic.count,
            backend=self.backend,
            precision=self.precision,
            promised=self.promised,
            is_peer=self.is_peer,
            note=self.note,
        )


def variants(subject: Subject, tolerance: float) -> tuple[list[Variant], dict[str, str]]:
    """Every variant of pvphong's own that the scene has a place for, and the reasons why others are left out."""
    found, left_out = list(_arithmetic(subject)), {}
    if not subject.has_kernel:
        left_out["kernel"] = "Numba is not installed, or has no code for this scene"
    for name, equation, reason in _simplified(subject):
        if reason:
            left_out[name] = reason
        else:
            found.append(_rewritten(subject, name, equation))
    found.append(_planned(subject, tolerance))
    return found, left_out


def peers(subject: Subject) -> tuple[list[Variant], dict[str, str]]:
    """Others' ways of lighting any vertices, and the reasons why some are left out."""
    try:
        refuse_unknown(subject.scene, subject.material)
    except ValueError as error:
        return [], {"textbook NumPy": str(error)}
    return [_textbook(subject)], {}


def _arithmetic(subject: Subject) -> Iterator[Variant]:
    computed: list[tuple[str, Backend, Precision]] = [
        (REFERENCE, "numpy", "float64"),
        ("float32 NumPy", "numpy", "float32"),
    ]
    if subject.has_kernel:
        computed += [("float64 kernel", "numba", "float64"), ("float32 kernel", "numba", "float32")]
    for name, backend, precision in computed:
        run = subject.runner(subject.assembled, precision, backend=backend)
        yield Variant(name, "arithmetic", run, subject.equation, backend, precision)


def _textbook(subject: Subject) -> Variant:
    def run() -> FloatArray:
        return textbook_colors(subject.points, subject.normals, subject.scene, subject.material, subject.matrix)

    note = "normalises, mirrors and raises to powers as a textbook writes it"
    return Variant(
        "textbook NumPy", "arithmetic", run, subject.equation, "textbook", "float64", is_peer=True, note=note
    )


def _simplified(subject: Subject) -> Iterator[tuple[str, Equation, str]]:
    """Name, equation, and a reason to leave it out or an empty string."""
    whole, needed, (middle, radius) = subject.assembled, subject.equation, subject.sphere
    dull = "" if needed.has_highlights else "there is no highlight that depends on the viewer"
    yield (
        "infinite viewer",
        simplifications.WITHOUT["local viewer"](whole, middle),
        dull or ("" if needed.eye is not None else "the viewer is at infinity already"),
    )
    other = counterpart_of(whole.reflectance)
    if other is not None:
        name, reflectance = other
        yield name, replace(whole, reflectance=reflectance), dull
    stand_in = None if whole.gamma != 1.0 else whole.reflectance.stand_in(subject.material)
    if stand_in is not None:
        name, material = stand_in
        yield name, replace(subject, material=material).assembled, ""
    far = any(simplifications.is_beyond(term.light, middle, _FAR * radius) for term in needed.terms)
    yield (
        "far lights directional",
        simplifications.far_lights_directional(whole, middle, _FAR * radius),
        "" if far else "no light with a position is farther away than the mesh's diameter",
    )
    has_size = any(term.light.has_size for term in whole.terms)
    for count in _NODES:
        name = f"lights with a size as {count} nodes" if count > 1 else "lights with a size as points"
        yield name, as_nodes(whole, count), "" if has_size else "no light has a size"
    shiny = any(needed.has(term, "specular") for term in needed.terms)
    yield "no highlights", simplifications.WITHOUT["specular"](whole, middle), "" if shiny else "there are none"


def _rewritten(subject: Subject, name: str, equation: Equation) -> Variant:
    backend = subject.backend_for(len(subject.points), subject.planned(equation).equation)
    return Variant(name, "light model", subject.runner(equation), equation, backend, "float32")


def plan_name(tolerance: float) -> str:
    """The plan's variant."""
    return f"plan at {in_steps(tolerance)}"


def in_steps(tolerance: float) -> str:
    """A tolerance of whole display steps by these, any other as a number."""
    steps = tolerance * 255.0
    whole = round(steps)
    return f"{whole}/255" if whole and abs(steps - whole) < 1e-9 else f"{tolerance:.3g}"


def _planned(subject: Subject, tolerance: float) -> Variant:
    plan = subject.plan(tolerance)
    backend = subject.backend_for(len(subject.points), plan.equation)

    def run() -> FloatArray:
        return subject.plan(tolerance).run(subject.vertices, backend=backend).rgb

    bound = plan.error_bound
    return Variant(plan_name(tolerance), "light model", run, plan.equation, backend, "float32", promised=bound)
