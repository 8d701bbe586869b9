"""Report that compares pvphong with VTK's own lighting, scene by scene, with two images."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING

import pyvista as pv

from pvphong.base import check
from pvphong.base.files import written_aside
from pvphong.base.text import WIDTH, rendered, wrapped
from pvphong.meshes.files import refuse_suffix
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.studies.validate.cases import CASES, MATERIALS, MESHES, PICTURED, Case
from pvphong.studies.validate.images import ImageComparison, compare_images
from pvphong.studies.validate.validation import TIERS, Comparison, validate
from pvphong.vtk.oracle import driver

if TYPE_CHECKING:
    from rich.table import Table

_HEADINGS = ("scene", "mesh", "material", "VTK's tier", "vertices", "largest error", "bound", "ratio", "passed")

_TITLES = {"matte": "A matte torus in the sun", "shiny": "A shiny sphere by a lamp"}

_FORMULA = "16 · power · 2⁻²⁴ + 1e-6"


@dataclass(frozen=True)
class CaseRow:
    """A scene of the report and the comparison of its colours, as a row of the table."""

    case: Case
    comparison: Comparison

    @property
    def ratio(self) -> float:
        """The largest error divided by the bound on errors; at most 1 if the scene passes."""
        return self.comparison.max_error / self.comparison.tolerance

    def cells(self) -> tuple[str, ...]:
        """Return the row's texts, one for each column of the table."""
        case, compared = self.case, self.comparison
        counts = f"{compared.tier}, {TIERS[compared.tier]}", f"{compared.n} of {compared.n + compared.n_left_out}"
        errors = f"{compared.max_error:.2e}", f"{compared.tolerance:.2e}", f"{self.ratio:.2f}"
        return case.title, case.mesh, case.material, *counts, *errors, "yes" if compared.passed else "NO"


@dataclass(frozen=True)
class VTKReport:
    """Results of `vtk_report`.

    Attributes
    ----------
    rows : tuple of CaseRow
        One comparison per scene of a fixed list.
    pictures : dict of str to ImageComparison
        File name → comparison of a mesh drawn with its lit colours and the same mesh lit by VTK.
    """

    rows: tuple[CaseRow, ...]
    pictures: dict[str, ImageComparison]

    @property
    def passed(self) -> bool:
        """True if every scene is within its bound. Pictures do not count."""
        return all(row.comparison.passed for row in self.rows)

    def summary(self) -> str:
        """Return the verdict and the largest ratio in a sentence."""
        failed = sum(not row.comparison.passed for row in self.rows)
        vertices = sum(row.comparison.n for row in self.rows)
        verdict = f"{failed} of {len(self.rows)} scenes failed" if failed else f"All {len(self.rows)} scenes passed"
        worst = f"the largest error is {self._worst.ratio:.2f} of its bound"
        return f"{verdict}: {vertices} vertices compared, {worst}."

    @property
    def _worst(self) -> CaseRow:
        return max(self.rows, key=lambda row: row.ratio)

    def __str__(self) -> str:
        failed = [row.case.title for row in self.rows if not row.comparison.passed]
        lines = [*wrapped(self.summary()), *wrapped(f"Nearest to its bound: {self._worst.case.title}.")]
        if failed:
            lines.append(shorten(f"Failed: {'; '.join(failed)}", WIDTH, placeholder=" …"))
        return "\n".join(lines)

    def explain(self) -> str:
        """Return every scene and its results as text."""
        tiers = ", ".join(f"{number} {tier}" for number, tier in enumerate(TIERS))
        return rendered([self.table(), f"VTK's tiers: {tiers}. The bound is {_FORMULA}.", self.summary()])

    def table(self) -> Table:
        """Return the rows as a `rich.table.Table`."""
        from rich import box
        from rich.table import Table

        table = Table(title="pvphong against VTK's shader", title_justify="left", box=box.SIMPLE_HEAD)
        table.add_column("scene, mesh, material", ratio=1)
        for heading in ("tier", "vertices", "error", "of bound", "passed"):
            table.add_column(heading, justify="right", no_wrap=True)
        for row in self.rows:
            scene, mesh, material, _, _, error, _, ratio, passed = row.cells()
            counts = f"{row.comparison.tier}", f"{row.comparison.n}"
            cells = (f"{scene}; {mesh}, {material}", *counts, error, ratio, passed)
            table.add_row(*cells, style="" if row.comparison.passed else "red")
        return table

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the report as Markdown, and its images into the folder ``<name>-pictures`` next to it.

        The report is written last, so that a complete report always has its images.

        Raises
        ------
        ValueError
            If the suffix is not ``.md``, or the files cannot be written.
        """
        refuse_path(path)
        target = Path(path)
        folder = target.with_name(f"{target.stem}-pictures")
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise ValueError(f"path must be in a folder that can be written to; got {target} ({error}).") from error
        for name, images in self.pictures.items():
            images.save(folder / f"{name}.png")
        with written_aside(target) as aside:
            aside.write_text("\n".join(self._markdown(folder.name)), encoding="utf-8")

    def _markdown(self, folder: str) -> Iterator[str]:
        def line(cells: Iterable[str]) -> str:
            return f"| {' | '.join(cells)} |"

        vtk = ".".join(map(str, pv.vtk_version_info))
        yield "# pvphong against VTK's own lighting\n"
        yield self.summary() + "\n"
        for what, value in (("pvphong", version("pvphong")), ("PyVista", pv.__version__), ("VTK", vtk)):
            yield f"- {what} {value}"
        yield f"- driver: {driver()}\n"
        yield "## Every vertex, in float32\n"
        yield "VTK's unmodified fragment shader runs once per vertex and is read back in float32, unclamped. Errors are"
        yield f"absolute, or relative where more light than 1 arrives. The bound is {_FORMULA}; the ratio is error over"
        yield "bound. Vertices where float32 makes VTK's colour uncertain, as on a cone's edge, are left out.\n"
        yield from map(line, (_HEADINGS, ["---"] * len(_HEADINGS), *(row.cells() for row in self.rows)))
        yield "\n## On the screen, in 8 bits\n"
        yield "Left: the lit colours, drawn without lighting. Middle: VTK lights every pixel. Right: their difference"
        yield "inside the silhouette; grey is 0, each display step is 16 levels. Differences of more than a step come"
        yield "from interpolation between vertices. The images show that the computed colours are drawn unchanged.\n"
        for name, images in self.pictures.items():
            title = _TITLES[name]
            yield f"{title}: at most {images.max_difference}/255, 99 % of the pixels {images.p99:.3g}/255.\n"
            yield f"![{title}](<{folder}/{name}.png>)\n"


def refuse_path(path: str | os.PathLike[str]) -> None:
    """Raise ``ValueError`` unless a path ends in .md and its folder exists."""
    refuse_suffix(Path(path), "a report", (".md",))
    folder = Path(path).resolve().parent
    if not folder.is_dir():
        check.refuse("path", Path(path), "in a folder that exists", f"Create {folder} first.")


def vtk_report() -> VTKReport:
    """Compare a fixed list of scenes with VTK.

    The scenes cover every kind of light, shader, coordinate frame, matrix and projection that VTK has. The meshes are
    bundled with PyVista.

    Returns
    -------
    VTKReport
        `.passed`, `.rows`, `.pictures`, `.table` and `.save`.

    Raises
    ------
    ValueError
        If VTK cannot draw on this machine.
    """
    # Images first: if VTK cannot draw, the message of their error says what is missing.
    eye = Viewer(position=(1.6, -1.2, 1.0), up=(0.0, 0.0, 1.0), view_angle=36.0)
    torus = pv.ParametricTorus(ringradius=0.35, crosssectionradius=0.15, u_res=300, v_res=200, w_res=2)
    sphere = pv.Sphere(theta_resolution=300, phi_resolution=200)
    sun, lamp = Scene([PICTURED["sun"]], eye), Scene([PICTURED["lamp"]], eye, LightModel.vtk())
    pictures = {
        "matte": compare_images(torus, sun, MATERIALS["matte"]),
        "shiny": compare_images(sphere, lamp, MATERIALS["plastic"]),
    }
    meshes = {name: load() for name, load in MESHES.items()}
    for mesh in meshes.values():
        mesh.clear_data()  # normals are computed
    rows = []
    for case in CASES:
        mesh = meshes[case.mesh]
        compared = validate(mesh, case.scene(mesh), MATERIALS[case.material], matrix=case.transform(mesh))
        rows.append(CaseRow(case, compared))
    return VTKReport(tuple(rows), pictures)
