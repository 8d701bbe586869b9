"""Faders: each light's contribution to the colours is stored as an array, and a mix is a weighted sum of these arrays.

The colour of a vertex is the sum of a base, from ambient light and emission, and of each light's contribution, which is
called its share here. A share is proportional to the light's intensity and, in each channel, to its colours. A fader
multiplies a share, so that a mix needs no new shading. `Mix.kept` returns lights that produce the mix without faders.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy

from pvphong.base import check
from pvphong.base.display import Display
from pvphong.base.types import ByteArray, ColorLike, FloatArray, Vector, rgb
from pvphong.meshes.lit import shade_mesh
from pvphong.optics.light import Light
from pvphong.scene.scene import light_labels
from pvphong.studio.lit_mesh import ARRAY, LitMesh
from pvphong.studio.subplot import Subplot
from pvphong.studio.window_lights import RendererLight

_AFTER_LIT = 0.5  # observer priority: after lighting and gizmos
_ROUNDING = 2e-3  # largest difference between a colour and the sum of base and shares


@dataclass(frozen=True)
class Fader:
    """The weight of one light's contribution.

    Parameters
    ----------
    gain : float, default 1
        Factor of the light's contribution: 1 leaves it unchanged, 2 doubles it.
    tint : color, default (1, 1, 1)
        Factors of red, green and blue.
    muted : bool, default False
        True to leave the light out.
    """

    gain: float = check.field(partial(check.number, at_least=0.0), 1.0)
    tint: ColorLike = check.field(check.color, (1.0, 1.0, 1.0))
    muted: bool = check.field(check.flag, False)

    def __post_init__(self) -> None:
        check.fields(self)

    @property
    def factors(self) -> Vector:
        """Factors of red, green and blue."""
        red, green, blue = rgb(self.tint)
        return (0.0, 0.0, 0.0) if self.muted else (self.gain * red, self.gain * green, self.gain * blue)

    def kept(self, light: Light) -> Light:
        """Return the light with the fader applied to its intensity and colours. It is off if the fader is muted."""
        changes: dict[str, Any] = {"on": not self.muted, "intensity": light.intensity * self.gain}
        for name in ("diffuse", "specular", "ambient"):
            color = getattr(light, name)
            if color is not None:
                changes[name] = tuple(c * t for c, t in zip(rgb(color), rgb(self.tint), strict=True))
        return replace(light, **changes)


class Shares:
    """The base and each light's share of the colours of one mesh.

    Parameters
    ----------
    mesh : LitMesh
        The mesh, lit for the same scene.
    lights : sequence of RendererLight
        The scene's lights, in the scene's order.
    scene : Scene
        The scene, with all lights switched on.
    occluders : KnownOccluders or sequence
        The meshes that block light. With a sequence, the mesh itself blocks light too.

    Raises
    ------
    ValueError
        If the colours are not the sum of base and shares.
    """

    def __init__(self, mesh: LitMesh, lights: Any, scene: Any, occluders: Any) -> None:
        self.evaluations = mesh.evaluations
        self.plain: ByteArray = colors_of(mesh).copy()
        where: dict[str, Any] = {"matrix": mesh.matrix, "feature_angle": mesh.feature_angle, "occluders": occluders}
        lit = shade_mesh(mesh.mesh, scene, mesh.material, components=True, **where)
        self._base: FloatArray = np.asarray(lit["phong_base"])
        labels = light_labels(scene)
        self._shares = {
            each: np.asarray(lit[f"phong_light_{label}"]) for each, label in zip(lights, labels, strict=True)
        }
        whole = self._base + sum(self._shares.values())
        if scene.light_model.clamp:
            whole = whole.clip(0.0, 1.0)
        if np.abs(whole - lit["phong"]).max(initial=0.0) > _ROUNDING:
            check.refuse(
                "material",
                "a material with a gamma",
                "linear, so that the lights' contributions add up to the colour",
            )
        self._moved: RendererLight | None = None
        self._rest: FloatArray = self._base
        self._factors: dict[RendererLight, Vector] = {}

    def mix(self, factors: Mapping[RendererLight, Vector], out: ByteArray, display: Display) -> None:
        """Write the colours of a mix to `out`, shape (n, 3), after the display transform.

        `factors` has the factors of red, green and blue for each light. The same fader usually moves several times in a
        row. So the sum of all other shares and the base is cached.
        """
        known = {each: factors.get(each, (1.0, 1.0, 1.0)) for each in self._shares}
        changed = [each for each in known if self._factors.get(each) != known[each]]
        if any(each is not self._moved for each in changed):
            self._moved, self._rest = changed[-1], self._base.astype(np.float32)
            for each, factor in known.items():
                if each is not self._moved and any(factor):
                    self._rest += self._shares[each] * np.array(factor, np.float32)
        self._factors = known
        share = self._base if self._moved is None else self._shares[self._moved]
        scale = np.array((0.0, 0.0, 0.0) if self._moved is None else known[self._moved], np.float32)
        display(share * scale + self._rest, out)


def colors_of(mesh: LitMesh) -> ByteArray:
    """Return a view of the array of a mesh's drawn colours; writing to it changes the mesh."""
    return vtk_to_numpy(mesh.drawn.GetPointData().GetAbstractArray(ARRAY))


MixState = tuple[bool, dict[RendererLight, Fader], RendererLight | None]


class Mix:
    """The faders of a subplot's lights. While the mix is on, frames show the mixed colours.

    Parameters
    ----------
    subplot : Subplot
        The subplot. The mix does not change its lights.
    """

    def __init__(self, subplot: Subplot) -> None:
        self._subplot = subplot
        self.is_on = False
        self.faders: dict[RendererLight, Fader] = {}
        self.soloed: RendererLight | None = None
        self.evaluations = 0
        """Number of times that shares have been computed."""
        self.seconds = 0.0
        """Duration of the last mix."""
        self._shares: dict[LitMesh, Shares] = {}
        self._mixed_for: Any = None
        self._tag = subplot.renderer.AddObserver("StartEvent", lambda _renderer, _event: self.refresh(), _AFTER_LIT)

    # -- undo

    @property
    def state(self) -> MixState:
        """State of all faders, for the undo history."""
        return self.is_on, dict(self.faders), self.soloed

    @state.setter
    def state(self, state: MixState) -> None:
        self.is_on, faders, self.soloed = state
        self._subplot.lit.is_mixed = self.is_on
        self.faders = dict(faders)

    # -- faders

    def fader(self, renderer_light: RendererLight) -> Fader:
        """Return a light's fader. The initial fader of a light that is off is muted."""
        known = self.faders.get(renderer_light)
        if known is not None:
            return known
        return Fader(muted=not renderer_light.light(self._subplot.lights.viewer).on)

    def _heard(self, renderer_light: RendererLight) -> Fader:
        fader, is_there = self.fader(renderer_light), self.soloed in self._subplot.lights.renderer_lights
        return replace(fader, muted=True) if is_there and self.soloed is not renderer_light else fader

    def start(self, *, on: bool) -> None:
        """Start the mix with all faders at 1, or end it."""
        self.state = on, {}, None

    def kept(self) -> dict[RendererLight, Light]:
        """Return light → the light after its fader: intensity and colours are scaled, and a muted light is off."""
        viewer = self._subplot.lights.viewer
        lights = self._subplot.lights.renderer_lights
        return {each: self._heard(each).kept(each.light(viewer)) for each in lights}

    # -- frames

    def refresh(self) -> None:
        """Write the mix into the drawn colours, if it has changed.

        Shares are computed only if the scene has changed.
        """
        shown = self._subplot.lit.shown
        if not self.is_on:
            self._put_back()
            return
        if bounces := self._subplot.scene.light_model.bounces:
            check.refuse("bounces", bounces, "0 in a mix", "Bounced light cannot be assigned to individual lights.")
        lights = self._subplot.lights.renderer_lights
        factors = {each: self._heard(each).factors for each in lights}
        display = self._subplot.lit.display
        known = factors, [(mesh, mesh.evaluations) for mesh in shown], display
        if known == self._mixed_for:
            return
        began = time.perf_counter()
        for mesh in shown:
            known_shares = self._shares.get(mesh)
            if known_shares is None or known_shares.evaluations != mesh.evaluations:
                known_shares = self._shares[mesh] = self._evaluate(mesh, lights)
                began = time.perf_counter()
            known_shares.mix(factors, colors_of(mesh), display)
            mesh.show_colors()
        self._mixed_for, self.seconds = known, time.perf_counter() - began

    def _evaluate(self, mesh: LitMesh, lights: Any) -> Shares:
        self.evaluations += 1
        scene = self._subplot.scene
        lit = replace(scene, lights=[replace(light, on=True) for light in scene.lights])
        return Shares(mesh, lights, lit, self._subplot.lit.occluders_of(mesh, lit) or ())

    def _put_back(self) -> None:
        """Restore the colours without faders. Meshes that have been lit again since are correct already."""
        for mesh, shares in self._shares.items():
            is_current = mesh in self._subplot.lit.meshes and mesh.evaluations == shares.evaluations
            if is_current and not mesh.write_colors():
                colors_of(mesh)[:] = shares.plain
                mesh.show_colors()
        self._shares, self._mixed_for = {}, None

    def release(self) -> None:
        """Detach from the renderer and restore the colours without faders."""
        self._put_back()
        self._subplot.lit.is_mixed = False
        self._subplot.renderer.RemoveObserver(self._tag)
