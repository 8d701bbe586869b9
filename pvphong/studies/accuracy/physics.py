"""Light models against the rendering equation: the error of constant ambient light, and the cost of better models.

The models range from the textbook's to light with all bounces. They are compared, vertex by vertex, with path tracing
of known noise. Colours are linear and unclamped. `measure` evaluates the models one after another. `Physics` holds the
result and formats it as sentences and a table. `draw_physics` draws the panel of a report's figure.
"""

from __future__ import annotations

import os
import textwrap
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.files import written_aside
from pvphong.base.types import Float64Array, FloatArray, MatrixLike
from pvphong.geometry.transform import transform_points
from pvphong.meshes.lit import Prepared, Setting, prepare
from pvphong.meshes.pictures import draw
from pvphong.meshes.transport import Exchanging, transport_of
from pvphong.meshes.truth import Truth, truth
from pvphong.optics.material import Material
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.shading import interreflection
from pvphong.studies.accuracy.result import Result, number, seconds, table
from pvphong.studies.accuracy.timing import timed

if TYPE_CHECKING:
    from rich.table import Table

# Initial and largest number of paths per vertex.
_FIRST_PATHS, _MOST_PATHS = 16, 1024
# Number of bounces that count as all bounces: with an albedo of 0.9, further bounces add about 1 % of the direct light.
_ALL_BOUNCES = 64
# A model is about as good as the best one if its error is at most this many times the error of the best one.
_AS_GOOD = 1.25
_FORMATS = ".png", ".pdf", ".svg"
_WIDTH, PANEL_HEIGHT = 16.0, 5.5  # inches of figures, and of the panel alone
_PICTURE, _BACKGROUND = (400, 360), "#dce6f2"  # pixels, and the colour around the mesh
_TITLE_WIDTH = 18  # letters
# Quantile of the path-traced values that is displayed as white.
_BRIGHT = 0.995


@dataclass(frozen=True, eq=False)
class ModelOfLight:
    """One light model, with the time, colours and errors of lighting by it.

    Attributes
    ----------
    name : str
        Description of the model.
    seconds : float
        Lighting time, including its rays.
    colors : ndarray
        Shape (n, 3), linear and unclamped.
    error : ndarray
        Shape (n, 3): colours minus path-traced colours.
    noise : float
        Root mean square of the standard errors of the path-traced colours.
    """

    name: str
    seconds: float
    colors: FloatArray
    error: Float64Array
    noise: float

    @property
    def rms(self) -> float:
        """Root mean square of the model's error, without the noise of path tracing.

        The mean square of the noise is subtracted from the mean square of `error`.
        """
        return max(float(np.square(self.error).mean()) - self.noise**2, 0.0) ** 0.5

    @property
    def largest(self) -> float:
        """Largest absolute error of any channel."""
        return float(np.abs(self.error).max())


@dataclass(frozen=True, eq=False, repr=False)
class Physics:
    """Comparison of light models with path tracing on one mesh and scene.

    Attributes
    ----------
    models : tuple of ModelOfLight
        Light models from constant ambient light to all bounces.
    truth : Truth
        Reference colours by path tracing.
    surface : pyvista.PolyData
        The lit surface, in its own coordinates.
    matrix : array_like or None
        (4, 4) model matrix of the surface; None for the identity.
    viewer : Viewer
        Viewer of the scene.
    """

    models: tuple[ModelOfLight, ...]
    truth: Truth
    surface: pv.PolyData
    matrix: MatrixLike | None
    viewer: Viewer

    @property
    def noise(self) -> float:
        """Root mean square of the standard errors of the path-traced colours."""
        return _rms(self.truth.standard_error)

    @property
    def exposure(self) -> float:
        """Factor for the colours in pictures. It makes nearly all path-traced colours darker than white."""
        bright = float(np.quantile(self.truth.rgb, _BRIGHT))
        return 1.0 / bright if bright > 0.0 else 1.0

    @property
    def cheapest(self) -> ModelOfLight:
        """Fastest of the models whose RMS error is nearly the smallest."""
        least = max(min(each.rms for each in self.models), self.noise / 4.0)
        return min((each for each in self.models if each.rms <= _AS_GOOD * least), key=lambda each: each.seconds)

    def __repr__(self) -> str:
        return f"<Physics of {len(self.models)} models of light: {self.cheapest.name}>"

    def sentence(self) -> str:
        """Return a text on the recommended model: its name, its benefit and its additional cost."""
        first, best = self.models[0], self.cheapest
        begun = f"The constant is off by up to {number(first.largest)} ({number(first.rms)} RMS)"
        if best is first:
            return f"{begun}, and no other model is better; the noise of the truth is {number(self.noise)}."
        back = 1.0 - best.rms / first.rms
        price = seconds(max(best.seconds - first.seconds, 0.0))
        return f"{begun}. {best.name.capitalize()}: {back:.0%} less RMS error, for {price} more."

    def table(self) -> Table:
        """Return the models with their times and errors as a `rich.table.Table`."""
        numbers = ("time", "RMS", "largest", "mean")
        found = table(
            "Phong against the rendering equation: linear light at the vertices", "light", *numbers, right=numbers
        )
        for each in self.models:
            signed = f"{each.error.mean():+.2g}"
            found.add_row(each.name, seconds(each.seconds), number(each.rms), number(each.largest), signed)
        found.add_row(f"path tracing, ± {number(self.noise)}", seconds(self.truth.seconds))
        return found

    def to_dict(self) -> dict[str, Any]:
        """Return all numbers as built-in Python types, as for JSON."""
        models = [
            {"name": each.name, "seconds": each.seconds, "rms": each.rms, "largest": each.largest}
            for each in self.models
        ]
        truth = {"seconds": self.truth.seconds, "rays": self.truth.rays, "noise": self.noise}
        return {"models": models, "truth": truth, "sentence": self.sentence()}

    def plot(self, path: str | os.PathLike[str]) -> None:
        """Draw the panel alone, into a .png, .pdf or .svg file.

        Raises
        ------
        ValueError
            If the suffix is not supported, or the file cannot be written.
        """
        with figure_in(path, PANEL_HEIGHT) as figure:
            draw_physics(figure, self)


def _rms(values: Float64Array) -> float:
    return float(np.sqrt(np.square(values).mean()))


# --- measuring


def measure(
    mesh: pv.DataSet,
    scene: Scene,
    material: Material,
    setting: Setting,
    *,
    budget: float,
    say: Callable[[str], object],
) -> Physics:
    """Light a mesh by each light model, and by path tracing.

    If the light model is two-sided, models with bounces are left out.

    Parameters
    ----------
    mesh : pyvista.DataSet
        Dataset with a surface; it is not modified.
    scene : Scene
        Lights, viewer and light model, in the standard convention.
    material : Material
        Material of the surface.
    setting : Setting
        Matrix, feature angle and occluders. A visibility in it is ignored.
    budget : float
        Approximate seconds for path tracing, with 16 to 1024 paths per vertex.
    say : callable
        Function that is called with the name of each step.

    Raises
    ------
    ValueError
        If the surface reflects more light than arrives.
    """
    matrix, occluders = setting.matrix, setting.occluders
    bare_setting = Setting(matrix, setting.feature_angle, occluders)
    where: Any = {"matrix": matrix, "feature_angle": setting.feature_angle, "occluders": occluders}
    say("path tracing")
    found = truth(mesh, scene, material, samples=_FIRST_PATHS, **where)
    affordable = int(_FIRST_PATHS * budget / max(found.seconds, 1e-9))
    samples = min(1 << max(affordable.bit_length() - 1, 0), _MOST_PATHS)
    if samples > _FIRST_PATHS:
        found = truth(mesh, scene, material, samples=samples, **where)
    bare = replace(scene.light_model, shadows=False, ambient_occlusion=False, bounces=0, clamp=False)

    def prepared(model: LightModel, **rays: Any) -> Prepared:
        return prepare(mesh, replace(scene, light_model=model), material, replace(bare_setting, **rays))

    def lit(model: LightModel, **rays: Any) -> FloatArray:
        each = prepared(model, **rays)
        return each.plan.run(each.vertices).rgb

    models = _Models(found, say)
    models.add("a constant", lambda: lit(bare))
    ambient = _ambient_of(prepared(replace(bare, ambient=1.0)))
    with_shadows = replace(bare, shadows=True)
    seen = prepared(with_shadows).vertices.visibility
    direct = timed(lambda: lit(replace(bare, ambient=0.0)))
    constant = models.fit("fitted constant {:.2g}", direct, ambient)
    shadowed = timed(lambda: lit(replace(with_shadows, ambient=0.0), visibility=seen))
    models.fit("shadows, constant {:.2g}", shadowed, ambient)
    occluded = replace(with_shadows, ambient=1.0, ambient_occlusion=True)
    open_sky = prepared(occluded, visibility=seen)
    sky = timed(lambda: _ambient_of(open_sky))
    models.fit("shadows, {:.2g} × occlusion", (shadowed[0], shadowed[1] + sky[1]), sky[0])
    if not bare.two_sided:
        own = [Exchanging(open_sky.source, lambda: open_sky.vertices.normals, matrix)]
        transport = transport_of(own, occluders)
        _, casting = timed(lambda: transport.gather(np.ones((len(transport), 1))))
        for bounces, name in ((1, "one bounce"), (2, "two bounces"), (_ALL_BOUNCES, "all bounces")):
            model = replace(with_shadows, bounces=bounces, ambient=constant)
            run = partial(lit, model, visibility=seen, transport=transport)
            models.add(name, run, shadowed[1] + casting)
    return Physics(tuple(models.found), found, open_sky.source, matrix, scene.viewer)


def _ambient_of(prepared: Prepared) -> FloatArray:
    """Return the colours, shape (n, 3), that a prepared mesh has in the scene's ambient light alone."""
    plan = prepared.plan
    alone = replace(plan, equation=interreflection.ambient_alone(plan.equation))
    return alone.run(prepared.vertices).rgb


class _Models:
    """Collects the light models that have been measured, and compares each with path tracing."""

    def __init__(self, truth: Truth, say: Callable[[str], object]) -> None:
        self.found: list[ModelOfLight] = []
        self._true, self._noise, self._say = truth.rgb, _rms(truth.standard_error), say

    def add(self, name: str, run: Callable[[], FloatArray], before: float = 0.0) -> None:
        """Light the mesh by a model, and add the model with its time and colours.

        Parameters
        ----------
        name : str
            Description of the model.
        run : callable
            Function that lights the mesh by the model, and returns the colours, shape (n, 3).
        before : float
            Seconds that the model's rays took; they were cast before this call.
        """
        self._say(name)
        colors, taken = timed(run)
        self.found.append(ModelOfLight(name, before + taken, colors, colors - self._true, self._noise))

    def fit(self, name: str, direct: tuple[FloatArray, float], ambient: FloatArray) -> float:
        """Add the model "direct light plus a constant times ambient light", and return the constant.

        The constant gives the smallest mean square error.

        Parameters
        ----------
        name : str
            Name of the model, as a format string for the constant.
        direct : tuple of ndarray and float
            Colours in direct light, shape (n, 3), and the seconds that the model takes.
        ambient : ndarray
            Colours in an ambient light of 1, shape (n, 3).
        """
        power = float(np.vdot(ambient, ambient))
        constant = max(float(np.vdot(ambient, self._true - direct[0])) / power, 0.0) if power else 0.0
        colors = direct[0] + constant * ambient
        self.found.append(ModelOfLight(name.format(constant), direct[1], colors, colors - self._true, self._noise))
        return constant


# --- pictures of light models and of a whole report


def bare_surface(lit: Physics | Result) -> pv.PolyData:
    """Return a copy of the surface that `lit` holds, in world coordinates and without arrays."""
    bare = lit.surface.copy()
    bare.clear_data()
    if lit.matrix is not None:
        bare.points = transform_points(np.asarray(bare.points), lit.matrix)
    return bare


def drawn(mesh: pv.PolyData, colors: FloatArray, viewer: Viewer, size: tuple[int, int]) -> Any:
    """Draw a mesh with the given colours at its points, and return the picture.

    The colours are stored in the mesh's array "phong". `size` is width and height in pixels.
    """
    mesh.point_data["phong"] = np.clip(colors, 0.0, 1.0)
    return draw(mesh, viewer, size=size, background=_BACKGROUND)


def in_worst_channel(errors: FloatArray) -> Float64Array:
    """Return the signed error of each vertex in the channel with the largest absolute error, shape (n,).

    `errors` has the shape (n, 3).
    """
    return errors[np.arange(len(errors)), np.abs(errors).argmax(axis=1)].astype(np.float64, copy=False)


# --- figures and the panel


def refuse_format(path: str | os.PathLike[str], name: str = "path") -> None:
    """Raise ``ValueError`` unless a path ends in .png, .pdf or .svg. `name` is the argument's name in the message."""
    check.choice(f"suffix of {name}", Path(path).suffix.lower(), _FORMATS)


@contextmanager
def figure_in(path: str | os.PathLike[str], height: float) -> Iterator[Any]:
    """Return a context with an empty Matplotlib figure that is `height` inches high. The figure is written at the end.

    The suffix of `path` must be .png, .pdf or .svg.
    """
    refuse_format(path)
    from matplotlib.figure import Figure

    figure = Figure(figsize=(_WIDTH, height), layout="constrained")
    yield figure
    with written_aside(path) as aside:
        figure.savefig(aside, dpi=100)


def draw_physics(part: Any, physics: Physics) -> None:
    """Draw a comparison of light models into the Matplotlib subfigure `part`.

    It has error against time, pictures side by side, and pictures of the signed differences.
    """
    part.suptitle(physics.sentence(), fontsize=12)
    left, right = part.subfigures(1, 2, width_ratios=(0.8, 1.7))
    axes = left.subplots()
    times = [each.seconds * 1e3 for each in physics.models]
    errors = [max(each.rms, 1e-9) for each in physics.models]
    axes.set(xscale="log", yscale="log", title="light models, at the vertices")
    axes.set_xlabel("time in ms, rays included")
    axes.set_ylabel("RMS error of linear light, without noise")
    axes.plot(times, errors, color="#b9b9b9", linewidth=1.0, zorder=1)
    axes.scatter(times, errors, color="#1b6ca8", zorder=2)
    least, noise = min(errors) / 3.0, max(physics.noise, 1e-9)
    axes.set_xlim(min(times) / 2.0, max(times) * (max(times) / min(times)) ** 0.9)  # room for the names
    axes.set_ylim(min(least, noise / 2.0), 2.0 * max(errors))
    axes.axhspan(min(least, noise / 2.0), noise, color="#6b4c9a", alpha=0.15)
    axes.annotate(
        "noise of the truth per colour", (axes.get_xlim()[1], axes.get_ylim()[0]),
        xytext=(-4, 4), textcoords="offset points", ha="right", va="bottom", fontsize=9,
    )  # fmt: skip
    for turn, (each, x, y) in enumerate(zip(physics.models, times, errors, strict=True)):
        is_valley = 0 < turn < len(errors) - 1 and y < min(errors[turn - 1], errors[turn + 1])
        place = (7, -11) if turn % 2 or is_valley else (7, 4)  # below, or above
        axes.annotate(each.name, (x, y), xytext=place, textcoords="offset points", fontsize=9)
    pictures = list(_pictures(physics))
    panes = right.subplots(2, len(pictures), squeeze=False)
    for (above, below), (title, shown, difference, scale) in zip(panes.T, pictures, strict=True):
        above.imshow(shown)
        above.set_title(textwrap.fill(title, _TITLE_WIDTH), fontsize=10)
        above.set_axis_off()
        below.set_axis_off()
        if difference is not None:
            below.imshow(difference)
            below.set_title(f"minus the truth, ± {number(scale)}", fontsize=9)
    note = f"linear light × {physics.exposure:.3g}, shown with gamma 2.2; red: too bright, blue: too dark"
    right.supxlabel(note, fontsize=9)


def _pictures(physics: Physics) -> Iterator[tuple[str, Any, Any, float]]:
    """Yield a title, a picture, a picture of differences, and the end of its colour scale, for each shown model.

    The differences are signed, from path tracing. The last entry is for path tracing itself: title, picture, None and
    0.
    """
    from matplotlib import colormaps

    bare = bare_surface(physics)

    def shown(colors: FloatArray) -> Any:
        return drawn(bare, np.maximum(colors * physics.exposure, 0.0) ** (1.0 / 2.2), physics.viewer, _PICTURE)

    wanted = [each for each in physics.models if not each.name.startswith(("fitted", "two"))]
    scale = max(float(np.quantile(np.abs(physics.models[0].error), 0.99)), 1e-9)
    for each in wanted:
        worst = in_worst_channel(each.error)
        colors = colormaps["RdBu_r"](0.5 + 0.5 * np.clip(worst / scale, -1.0, 1.0))[:, :3]
        yield each.name, shown(each.colors), drawn(bare, colors, physics.viewer, _PICTURE), scale
    yield "the truth", shown(physics.truth.rgb), None, 0.0
