"""What came of comparing pvphong's colours with VTK's: numbers, worst vertices, a table, JSON and a mesh."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import pyvista as pv

from pvphong.base.files import write_json
from pvphong.base.text import html_table, rendered, wrapped
from pvphong.base.types import Float64Array, FloatArray, IntArray, Vector

if TYPE_CHECKING:
    from rich.table import Table

_WORST = 8
"""Vertices that a comparison lists."""

TIERS = ("unlit", "headlight", "directional lights", "positional lights")
"""What VTK's shader calls for, by the number of its tier."""


@dataclass(frozen=True)
class Vertex:
    """A vertex whose colours differ most, with what it takes to look into it.

    Attributes
    ----------
    index : int
        Number of the point.
    error : float
        Its largest error over the channels, without sign.
    position, normal : tuple of float
        In the world, the normal unit and turned to the viewer where the scene is two-sided.
    pvphong, vtk : tuple of float
        Both unclamped colours.
    tier : int
        The tier of VTK's shader; an index into `TIERS`.
    """

    index: int
    error: float
    position: Vector
    normal: Vector
    pvphong: Vector
    vtk: Vector
    tier: int


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """pvphong's unclamped colours against VTK's own shader.

    `print(comparison)` gives the verdict in words, `print(comparison.explain())` all numbers.

    Errors are pvphong minus VTK: absolute, and relative to the light that arrives where that, times the material's
    reflectances, is more than 1. float32 rounds in proportion to it.

    Attributes
    ----------
    tolerance : float
        The bound that applied: 16 · power · 2⁻²⁴ + 1e-6, where the power is the shininess or a spot's exponent,
        whichever is largest; for physically based shading the power is that of spots, and
        6 · 2⁻²⁴ / roughness⁴ + 1e-6 is added.
    tier : int
        Which of VTK's three tiers of lighting code drew it; 0 where it drew unlit.
    conversions : tuple of str
        What was said to VTK in other words than the scene's.
    driver : str
        The graphics driver that VTK ran on.
    vertices : ndarray
        Shape (n,): the points compared.
    errors : ndarray
        Shape (n, 3), signed, a row per point compared.
    left_out : dict of str to ndarray
        Reason → points that were not compared for it; a point may have several.
    pvphong, vtk : ndarray
        Shape (n_points, 3): all unclamped colours, VTK's NaN where it has none.
    """

    tolerance: float
    tier: int
    conversions: tuple[str, ...]
    driver: str
    vertices: IntArray
    errors: Float64Array
    left_out: dict[str, IntArray]
    pvphong: FloatArray
    vtk: FloatArray
    _surface: pv.PolyData
    _positions: Float64Array
    _normals: Float64Array

    @property
    def n(self) -> int:
        """How many vertices were compared."""
        return len(self.vertices)

    @property
    def n_left_out(self) -> int:
        """How many were not."""
        return len(self.pvphong) - self.n

    @property
    def max_error(self) -> float:
        """The largest error of any channel; NaN where nothing was compared, as for the three that follow."""
        return float(self._magnitudes.max()) if self.n else math.nan

    @property
    def rms(self) -> float:
        """The root of the mean square of all channels' errors."""
        return math.sqrt(float(np.mean(self.errors**2))) if self.n else math.nan

    @property
    def p50(self) -> float:
        """The median of the vertices' errors, each vertex's that of its worst channel."""
        return float(np.percentile(self._magnitudes, 50)) if self.n else math.nan

    @property
    def p99(self) -> float:
        """What 99 % of the vertices' errors stay below."""
        return float(np.percentile(self._magnitudes, 99)) if self.n else math.nan

    @property
    def passed(self) -> bool:
        """Whether every error is within the tolerance; False where nothing was compared."""
        return bool(self.max_error <= self.tolerance)

    @property
    def _verdict(self) -> str:
        if not self.n:
            return "nothing to compare"
        return "passed" if self.passed else "failed"

    @cached_property
    def _magnitudes(self) -> Float64Array:
        magnitudes: Float64Array = np.abs(self.errors).max(axis=1, initial=0.0)
        return magnitudes

    @cached_property
    def worst(self) -> tuple[Vertex, ...]:
        """The vertices with the largest errors, largest first."""
        order = np.argsort(-self._magnitudes, kind="stable")[:_WORST]
        return tuple(self._vertex(int(row)) for row in order)

    def _vertex(self, row: int) -> Vertex:
        index = int(self.vertices[row])
        arrays = (self._positions, self._normals, self.pvphong, self.vtk)
        position, normal, own, other = (_triple(array[index]) for array in arrays)
        return Vertex(index, float(self._magnitudes[row]), position, normal, own, other, self.tier)

    def table(self) -> Table:
        """The comparison as a `rich.table.Table`; print it with a `rich.console.Console`."""
        from rich import box
        from rich.table import Table
        from rich.text import Text

        title = Text("pvphong against VTK's shader: ")
        title.append(self._verdict, "green" if self.passed else "red")
        table = Table(title=title, box=box.SIMPLE_HEAD, show_header=False)
        table.add_column(justify="left", no_wrap=True)
        table.add_column(justify="left", overflow="fold")
        for name, value in self._rows():
            table.add_row(name, value)
        return table

    def explain(self) -> str:
        """All numbers, what was said to VTK in other words, what was left out, and the worst vertices."""
        return rendered([self.table()])

    def _rows(self) -> list[tuple[str, str]]:
        rows = [("vertices compared", f"{self.n} of {self.n + self.n_left_out}")]
        if self.n:
            rows += [
                ("largest error", f"{self.max_error:.3g}, {self.max_error / self.tolerance:.2f} of the bound"),
                ("RMS, median, 99 %", f"{self.rms:.3g}, {self.p50:.3g}, {self.p99:.3g}"),
            ]
        rows += [
            ("bound", f"{self.tolerance:.3g} (see `tolerance`)"),
            ("VTK's tier", f"{self.tier} ({TIERS[self.tier]})"),
            ("driver", self.driver),
        ]
        rows += [("in VTK's terms", conversion) for conversion in self.conversions]
        rows += [("left out", f"{len(points)}: {reason}") for reason, points in self.left_out.items()]
        rows += [(f"worst: {vertex.index}", _told(vertex)) for vertex in self.worst[: 1 if self.passed else _WORST]]
        return rows

    def __str__(self) -> str:
        return "\n".join(line for sentence in self._sentences() for line in wrapped(sentence))

    def _sentences(self) -> Iterator[str]:
        if not self.n:
            yield f"Nothing to compare: none of {self.n_left_out} vertices can be held against VTK."
            return
        within = int(np.count_nonzero(self._magnitudes <= self.tolerance))
        count = f"all {self.n}" if self.passed else f"{within} of {self.n}"
        yield f"{self._verdict.capitalize()}: {count} vertices are within {self.tolerance:.3g} of VTK's own shader."
        yield f"The largest error is {self.max_error:.3g}, {self.max_error / self.tolerance:.2f} of that bound."
        if self.left_out:
            yield f"{self.n_left_out} vertices are left out: {', '.join(self.left_out)}."
        if not self.passed:
            yield f"Worst is vertex {self.worst[0].index} at {_numbers(self.worst[0].position)}."

    def __repr__(self) -> str:
        error = f"largest error {self.max_error:.3g} of {self.tolerance:.3g}"
        return f"<Comparison {self._verdict}: {error}, {self.n} vertices>"

    def _repr_html_(self) -> str:
        return html_table(f"pvphong against VTK's shader: {self._verdict}", (), self._rows())

    def to_dict(self) -> dict[str, Any]:
        """The numbers as plain values, without the arrays; NaN as None."""
        numbers = {name: getattr(self, name) for name in ("max_error", "rms", "p50", "p99", "tolerance")}
        return {
            "passed": self.passed,
            "n": self.n,
            "n_left_out": self.n_left_out,
            **{name: None if math.isnan(number) else number for name, number in numbers.items()},
            "tier": self.tier,
            "driver": self.driver,
            "conversions": list(self.conversions),
            "left_out": {reason: len(points) for reason, points in self.left_out.items()},
            "worst": [asdict(vertex) for vertex in self.worst],
        }

    def to_json(self, path: str | os.PathLike[str]) -> None:
        """Write `to_dict` to a JSON file.

        Raises
        ------
        ValueError
            If the file cannot be written.
        """
        write_json(self.to_dict(), path)

    def to_mesh(self) -> pv.PolyData:
        """A copy of the surface with the colours and errors, to look at.

        Returns
        -------
        pyvista.PolyData
            Point arrays: ``"phong"`` and ``"vtk"``, the unclamped colours; ``"phong_error"``, the signed errors,
            NaN where none was taken; ``"phong_error_max"``, active, the largest channel's without sign.
        """
        mesh = self._surface.copy()
        errors = np.full(self.pvphong.shape, np.nan)
        errors[self.vertices] = self.errors
        mesh.point_data["phong"] = self.pvphong
        mesh.point_data["vtk"] = self.vtk
        mesh.point_data["phong_error"] = errors
        mesh.point_data["phong_error_max"] = np.abs(errors).max(axis=1)
        mesh.set_active_scalars("phong_error_max", preference="point")
        return mesh


def _triple(row: FloatArray) -> Vector:
    x, y, z = row.tolist()
    return x, y, z


def _told(vertex: Vertex) -> str:
    return (
        f"error {vertex.error:.3g} at {_numbers(vertex.position)}, normal {_numbers(vertex.normal)}, "
        f"pvphong {_numbers(vertex.pvphong)}, VTK {_numbers(vertex.vtk)}"
    )


def _numbers(triple: Vector) -> str:
    return "(" + ", ".join(f"{number:.7g}" for number in triple) + ")"
