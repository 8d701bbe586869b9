"""The files whose meshes a studio shows: one alone, or several side by side.

If another file is opened, the lights are moved to fit it. A file that is added leaves lights and camera where they are.
Undo shows again what was shown before.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.types import Float64Array, Vector
from pvphong.meshes.blocks import DEFAULT
from pvphong.meshes.default_scene import default_scene
from pvphong.meshes.pictures import aim
from pvphong.optics.light import Light
from pvphong.optics.material import DEFAULT_MATERIAL
from pvphong.optics.roles import Falloff, Length
from pvphong.scene.light_model import LightModel
from pvphong.scene.viewer import Viewer
from pvphong.studio.lit_actors import LitActors
from pvphong.studio.lit_mesh import LitMesh
from pvphong.studio.subplot import Subplot
from pvphong.studio.web.downloads import STAGE, reading_file
from pvphong.studio.window_lights import free_name

_numbers = itertools.count(1)

_LONGEST = 80  # characters of a name


@dataclass(eq=False)
class OpenFile:
    """A file whose meshes are shown. Instances are compared by identity.

    Parameters
    ----------
    stem : str
        Its name without suffix.
    reading : str
        Python expression for its mesh.
    keep : Path, optional
        File to which the rig is written after each change.
    """

    stem: str
    reading: str
    keep: Path | None = None
    number: int = field(default_factory=_numbers.__next__, init=False)
    """Number by which the page names the file."""
    meshes: dict[LitMesh, str] = field(default_factory=dict, init=False)
    """Its meshes and the names of their actors. Those of the first file are known once it has been put away."""
    viewer: Viewer | None = field(default=None, init=False)
    """The viewer when it was last put away."""


class Part(NamedTuple):
    """A file that is shown, and the name of its mesh on the page, in rigs and in the script."""

    file: OpenFile
    name: str


class Drawn(NamedTuple):
    """A part and its meshes in the view, at least one."""

    part: Part
    meshes: list[LitMesh]


class Opening:
    """The files that a studio shows.

    Parameters
    ----------
    plotter : pyvista.Plotter
        The plotter; `subplot` must be its active one when a file is opened.
    subplot : Subplot
        The subplot that shows the meshes.
    file : OpenFile
        The file that is shown at first.
    put_away : callable
        Called before the meshes of a file are removed from the view.
    """

    def __init__(self, plotter: pv.Plotter, subplot: Subplot, file: OpenFile, put_away: Callable[[], None]) -> None:
        self._plotter, self._subplot, self._before_put_away = plotter, subplot, put_away
        self._parts: tuple[Part, ...] = (Part(file, file.stem),)

    @property
    def parts(self) -> tuple[Part, ...]:
        """The files that are shown, in the order in which they were added; at least one, which may have no mesh."""
        return self._parts

    @property
    def drawn(self) -> list[Drawn]:
        """The parts that have meshes in the view. Meshes that a script has added belong to the first part."""
        meshes = [mesh for mesh in self._subplot.lit.meshes if mesh.stage is None]
        of_files = {mesh for part in self._parts for mesh in part.file.meshes}
        others = [mesh for mesh in meshes if mesh not in of_files]
        found = []
        for number, part in enumerate(self._parts):
            own = [mesh for mesh in meshes if mesh in part.file.meshes] + (others if number == 0 else [])
            found += [Drawn(part, own)] if own else []
        return found

    # -- names, for the page and for downloads

    @property
    def stem(self) -> str:
        """Beginning of the names of downloads: the name of the first part."""
        return self._shown_parts[0].name

    @property
    def title(self) -> str:
        """The names of all parts, or of the first ones."""
        names = [part.name for part in self._shown_parts]
        return ", ".join(names) if len(names) < 4 else f"{names[0]}, {names[1]} and {len(names) - 2} more"

    @property
    def reading(self) -> str:
        """Python expression for the mesh of the only part, or for a MultiBlock of all parts by their names."""
        parts = self._shown_parts
        if len(parts) == 1:
            return parts[0].file.reading
        inner = "".join(f"    {part.name!r}: {part.file.reading},\n" for part in parts)
        return f"pv.MultiBlock({{\n{inner}}})"

    @property
    def _shown_parts(self) -> list[Part]:
        return [each.part for each in self.drawn] or [*self._parts]

    def names(self) -> dict[LitMesh, str]:
        """Return unique names of all meshes, part by part, and of the stage. They are the paths in `reading`.

        With several parts, a name is the part's name, followed by "/" and the block's path if the part has blocks.
        """
        lit, drawn = self._subplot.lit, self.drawn
        names = own_names(lit, lit.meshes)
        if len(drawn) == 1:
            return names
        found = dict[LitMesh, str]()
        for part, meshes in drawn:
            is_alone = [mesh.block for mesh in meshes] == [""]
            own = own_names(lit, meshes)
            found |= {mesh: part.name if is_alone else f"{part.name}/{own[mesh]}" for mesh in meshes}
        return found | {mesh: name for mesh, name in names.items() if mesh not in found}

    def listed(self) -> list[dict[str, Any]]:
        """Return the parts for the page."""
        return [
            {"number": part.file.number, "name": part.name, "points": sum(mesh.drawn.n_points for mesh in meshes)}
            for part, meshes in self.drawn
        ]

    def kept(self) -> list[tuple[Path, dict[str, LitMesh]]]:
        """Return the files in which rigs are kept, with the meshes of each one, by the names that they have alone."""
        lit, drawn = self._subplot.lit, {each.part: each.meshes for each in self.drawn}
        return [
            (part.file.keep, {name: mesh for mesh, name in own_names(lit, drawn.get(part, [])).items()})
            for part in self._parts
            if part.file.keep is not None
        ]

    def rename(self, number: Any, name: Any) -> None:
        """Give a part another name.

        Raises
        ------
        ValueError
            If there is no such part, or the name is taken, or is not 1 to 80 printable characters without "/".
        """
        part = self._part(number)
        name = check.text("name", name).strip()
        if not name or len(name) > _LONGEST or "/" in name or not name.isprintable():
            allowed = f'1 to {_LONGEST} printable characters without "/"'
            check.refuse("name", name[:_LONGEST] or "an empty input", allowed)
        if name in _taken([each for each in self._parts if each is not part]):
            check.refuse("name", name, "different from the names of other meshes")
        self._parts = tuple(each._replace(name=name) if each is part else each for each in self._parts)

    def _part(self, number: Any) -> Part:
        known = {str(each.part.file.number): each.part for each in self.drawn}
        return known.get(str(number)) or check.refuse("mesh", number, "the number of a mesh that is shown")

    # -- opening, adding and removing

    def open(self, mesh: Any, file: OpenFile, refine: float | None) -> None:
        """Show a new file in place of all others. Lights and light model are kept and fitted to it; the first file gets
        the default scene. A stage stays as it is.

        Parameters
        ----------
        mesh : pyvista.DataSet or pyvista.MultiBlock
            Its mesh.
        file : OpenFile
            Its description.
        refine : float or None
            Tolerance of refined pictures, if the view is refined.

        Raises
        ------
        ValueError
            If the mesh cannot be lit; nothing is changed then.
        """
        lights, phong = self._subplot.lights, self._plotter.phong
        scene, before, viewer = default_scene(mesh), self.drawn, lights.viewer
        added = self._draw(mesh, file, refine)
        self._put_away(before)
        self._show_from(scene.viewer)
        self._parts = (Part(file, file.stem),)
        if not before or not lights.renderer_lights:
            lights.replace(scene.lights)
            phong.light_model = scene.light_model
            return
        fit = Fit(_box(mesh for each in before for mesh in each.meshes), _box(added), viewer, lights.viewer)
        for each in lights.renderer_lights:
            lights.set(each, fit.light(each.light(viewer)))
        phong.light_model = fit.light_model(phong.light_model, needs_both_sides=scene.light_model.two_sided)

    def add(self, mesh: Any, file: OpenFile, refine: float | None) -> None:
        """Show a new file beside those that are shown. Lights and camera stay. If none is shown, open it.

        A part whose name is taken gets the first free one: "wheel", "wheel 2". Sharp edges are as in the first mesh.
        Parameters and errors are those of `open`.
        """
        before, phong = self.drawn, self._plotter.phong
        if not before:
            self.open(mesh, file, refine)
            return
        is_open = default_scene(mesh).light_model.two_sided
        how: dict[str, Any] = {"feature_angle": before[0].meshes[0].feature_angle, "reset_camera": False}
        self._draw(mesh, file, refine, **how)
        parts = list[Part]()
        for part in (*(each.part for each in before), Part(file, file.stem)):
            parts.append(part._replace(name=free_name(part.name, _taken(parts))))
        self._parts = tuple(parts)
        self._subplot.renderer.ResetCameraClippingRange()
        phong.light_model = _with_both_sides(phong.light_model, is_open)

    def remove(self, number: Any) -> None:
        """Remove a part from the view. Lights and camera stay."""
        part = self._part(number)
        self._put_away([each for each in self.drawn if each.part is part])
        rest = tuple(each.part for each in self.drawn if each.part is not part)
        self._parts = rest or (Part(OpenFile("mesh", reading_file("mesh.vtp")), "mesh"),)

    def show(self, parts: tuple[Part, ...], refine: float | None) -> None:
        """Show parts again that were shown before. If none of them is shown now, show them as they were seen last."""
        lit, renderer, files = self._subplot.lit, self._subplot.renderer, [part.file for part in parts]
        here = {part.file for part in self._parts}
        self._put_away([each for each in self.drawn if each.part.file not in files])
        for part in parts:
            for mesh, name in part.file.meshes.items() if part.file not in here else ():
                actor: Any = mesh.actor
                renderer.add_actor(actor, name=name or None, pickable=bool(actor.GetPickable()), render=False)
                lit.add(mesh, refine)
        renderer.ResetCameraClippingRange()
        if here.isdisjoint(files):
            self._show_from(parts[0].file.viewer)
        self._parts = parts

    def _draw(self, mesh: Any, file: OpenFile, refine: float | None, **how: Any) -> list[LitMesh]:
        """Draw the mesh of a file, and return its parts that are lit."""
        lit = self._subplot.lit
        before = lit.meshes
        self._plotter.phong.add_mesh(mesh, DEFAULT_MATERIAL, refine=refine, **how)
        added = [each for each in lit.meshes if each not in before]
        file.meshes = {each: lit.name_of(each) for each in added}
        return added

    def _show_from(self, viewer: Viewer | None) -> None:
        """Move the camera. Its angle stays, because it depends on the width of the view."""
        if viewer is not None:
            angle = self._subplot.renderer.camera.GetViewAngle()
            aim(self._subplot.renderer, replace(viewer, view_angle=angle))
            self._subplot.renderer.ResetCameraClippingRange()

    def _put_away(self, parts: Sequence[Drawn]) -> None:
        """Remove the meshes of parts from the view, and remember them and the viewer."""
        if not parts:
            return
        self._before_put_away()
        for part, meshes in parts:
            part.file.meshes = {mesh: self._subplot.lit.name_of(mesh) for mesh in meshes}
            part.file.viewer = self._subplot.lights.viewer
            for mesh in meshes:
                self._subplot.renderer.remove_actor(mesh.actor, render=False)


def own_names(lit: LitActors, meshes: Sequence[LitMesh]) -> dict[LitMesh, str]:
    """Return unique names of meshes.

    The name of a block is the block's path, as in rigs and scripts, unless another mesh has the same name. Otherwise
    the name is that of the mesh's actor, which includes the path in brackets. If the actor has no name, the mesh gets
    a number.
    """
    count = Counter(mesh.block or lit.name_of(mesh) for mesh in meshes)
    return {
        mesh: mesh.block if mesh.block and count[mesh.block] == 1 else lit.name_of(mesh) or f"mesh {number}"
        for number, mesh in enumerate(meshes, 1)
    }


def _taken(parts: Iterable[Part]) -> set[str]:
    """Return the names that no further part can have. Rigs use "default" for all meshes, and scripts "stage"."""
    return {STAGE, DEFAULT, *(part.name for part in parts)}


class Fit(NamedTuple):
    """A change of scale and place, from one mesh to another."""

    then: Float64Array
    """Bounds of the first mesh in the world, shape (3, 2)."""
    now: Float64Array
    """Bounds of the second mesh."""
    viewer_then: Viewer
    viewer_now: Viewer

    @property
    def scale(self) -> float:
        """Size of the second mesh, divided by that of the first."""
        then, now = (float(np.linalg.norm(np.ptp(box, axis=1))) for box in (self.then, self.now))
        return now / then if 0.0 < then < np.inf and 0.0 < now < np.inf else 1.0

    def light(self, light: Light) -> Light:
        """Return a light whose place, size and falloff are to the second mesh what they were to the first."""
        scale, frame = self.scale, light.frame
        middles = self.then.mean(axis=1), self.now.mean(axis=1)

        def move(point: Vector) -> Vector:
            x, y, z = (middles[1] + scale * (np.array(point) - middles[0])).tolist()
            return x, y, z

        changes: dict[str, Any] = {}
        for name, role in light.roles.items():
            value = getattr(light, name)
            if isinstance(role, Length):
                changes[name] = scale * value
            elif type(role) is Falloff:
                changes[name] = tuple(each / scale**power for power, each in enumerate(value))
        if light.intensity_unit:  # an area, as the distance is squared
            changes["intensity"] = light.intensity * scale**2
        if frame == "headlight":
            light = light.moved(lambda corner: (scale * corner[0], scale * corner[1], scale * corner[2]))
        elif light.places:
            light = light.in_world(self.viewer_then).moved(move).in_frame(frame, self.viewer_now)
        return replace(light, **changes) if changes else light

    def light_model(self, model: LightModel, *, needs_both_sides: bool) -> LightModel:
        """Return the light model with its distances scaled, and two-sided if the second mesh needs it."""
        distance = model.ambient_occlusion
        occlusion = distance if isinstance(distance, bool) else self.scale * distance
        return replace(_with_both_sides(model, needs_both_sides), ambient_occlusion=occlusion)


def _with_both_sides(model: LightModel, is_open: bool) -> LightModel:
    """Return the light model, two-sided if a new mesh has open edges. With bounces, that is impossible."""
    return replace(model, two_sided=model.two_sided or (is_open and not model.bounces))


def _box(meshes: Any) -> Float64Array:
    """Return the bounds of drawn meshes in the world, shape (3, 2)."""
    boxes = np.array([mesh.actor.bounds for mesh in meshes]).reshape(-1, 3, 2)
    return np.stack([boxes[:, :, 0].min(axis=0), boxes[:, :, 1].max(axis=0)], axis=1)
