"""Opening of another mesh in a studio: the lights stay, moved to fit, and undo shows the old mesh again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv

from pvphong.base.types import Float64Array, Vector
from pvphong.meshes.default_scene import default_scene
from pvphong.meshes.pictures import aim
from pvphong.optics.light import Light
from pvphong.optics.material import DEFAULT_MATERIAL
from pvphong.optics.roles import Falloff, Length
from pvphong.scene.light_model import LightModel
from pvphong.scene.viewer import Viewer
from pvphong.studio.lit_mesh import LitMesh
from pvphong.studio.subplot import Subplot


@dataclass(eq=False)
class OpenFile:
    """The file whose meshes are shown. Instances are compared by identity.

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
    meshes: dict[LitMesh, str] = field(default_factory=dict)
    """Its meshes and the names of their actors, known once another file is shown."""
    viewer: Viewer | None = None
    """The viewer at that time."""


class Opening:
    """The file that a studio shows.

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
        self._plotter, self._subplot, self._file, self._before_put_away = plotter, subplot, file, put_away

    @property
    def file(self) -> OpenFile:
        """The file that is shown."""
        return self._file

    def open(self, mesh: Any, file: OpenFile, refine: float | None) -> None:
        """Show a new file. Lights and light model are kept and fitted to it; the first file gets the default scene.

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
        lit, lights, phong = self._subplot.lit, self._subplot.lights, self._plotter.phong
        scene, before, viewer = default_scene(mesh), lit.meshes, lights.viewer
        subjects = [each for each in before if each.stage is None]
        phong.add_mesh(mesh, DEFAULT_MATERIAL, refine=refine)
        added = [each for each in lit.meshes if each not in before]
        self._put_away(before)
        self._show_from(scene.viewer)
        self._file = file
        if not subjects or not lights.renderer_lights:
            lights.replace(scene.lights)
            phong.light_model = scene.light_model
            return
        fit = Fit(_box(subjects), _box(added), viewer, lights.viewer)
        for each in lights.renderer_lights:
            lights.set(each, fit.light(each.light(viewer)))
        phong.light_model = fit.light_model(phong.light_model, needs_both_sides=scene.light_model.two_sided)

    def show(self, file: OpenFile, refine: float | None) -> None:
        """Show a file again that was shown before, from where it was seen last."""
        lit, renderer = self._subplot.lit, self._subplot.renderer
        self._put_away(lit.meshes)
        for mesh, name in file.meshes.items():
            actor: Any = mesh.actor
            renderer.add_actor(actor, name=name or None, pickable=bool(actor.GetPickable()), render=False)
            lit.add(mesh, refine)
        self._show_from(file.viewer)
        self._file = file

    def _show_from(self, viewer: Viewer | None) -> None:
        """Move the camera. Its angle stays, because it depends on the width of the view."""
        if viewer is not None:
            angle = self._subplot.renderer.camera.GetViewAngle()
            aim(self._subplot.renderer, replace(viewer, view_angle=angle))
            self._subplot.renderer.ResetCameraClippingRange()

    def _put_away(self, meshes: Any) -> None:
        """Remove the meshes of the present file from the view, and remember them and the viewer."""
        self._before_put_away()
        lit = self._subplot.lit
        self._file.meshes = {mesh: lit.name_of(mesh) for mesh in meshes}
        self._file.viewer = self._subplot.lights.viewer
        for mesh in meshes:
            self._subplot.renderer.remove_actor(mesh.actor, render=False)


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
        return replace(model, two_sided=model.two_sided or needs_both_sides, ambient_occlusion=occlusion)


def _box(meshes: Any) -> Float64Array:
    """Return the bounds of drawn meshes in the world, shape (3, 2)."""
    boxes = np.array([mesh.actor.bounds for mesh in meshes]).reshape(-1, 3, 2)
    return np.stack([boxes[:, :, 0].min(axis=0), boxes[:, :, 1].max(axis=0)], axis=1)
