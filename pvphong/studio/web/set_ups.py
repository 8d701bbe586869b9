"""Set-ups of lights on the page, and the sun by date and place, which follows its sliders.

The sun and the sky are in W/m², so that lit values are irradiances times the material. The display's exposure makes a
picture of them. While a slider moves, the sun and the exposure follow; the sky follows when the slider rests.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from pvphong.base import check
from pvphong.base.display import Display
from pvphong.optics.light import Light
from pvphong.scene.light_model import LightModel
from pvphong.scene.presets import setups, up_of
from pvphong.scene.sun_by_date import SunByDate
from pvphong.studio.subplot import Subplot
from pvphong.studio.web.fields import form_of
from pvphong.studio.web.skies import prepared
from pvphong.studio.web.words import in_words

_SUN = "sun"
"""Name of the set-up."""

_EXPOSURES = -10.0, 10.0
_BRIGHTER = 1.0
"""Stops above the exposure at which a white surface that faces the sun is white: the filmic curve keeps it from
clipping, and surfaces in the shade are not black."""

_STEPS = 500.0
"""Steps of the picture up to the brightness of a white surface that faces the sun."""


class SunState(NamedTuple):
    """The sun by date and place."""

    sun: SunByDate
    """Place, day and hour, as set."""
    shown: SunByDate
    """The last of them by day, which the sun in the view shows."""
    sky: SunByDate
    """Those that the sky in the view shows."""
    before: tuple[LightModel, Display]
    """Light model and display before the set-up was chosen."""


class SetUps:
    """The set-ups of a subplot's lights.

    Parameters
    ----------
    phong : PlotterPhong
        The lighting of the plotter. The sun sets its light model and display.
    subplot : Subplot
        The subplot.
    """

    def __init__(self, phong: Any, subplot: Subplot) -> None:
        self._phong, self._subplot = phong, subplot
        self._is_moving = False
        self.state: SunState | None = None
        """The sun by date and place; None if another set-up was chosen, or none. It can be restored."""

    @property
    def sun(self) -> SunByDate:
        """The sun by date and place.

        Raises
        ------
        ValueError
            If the set-up "sun" is not chosen, or its sun was deleted.
        """
        if self.state is None or self._named(_SUN) is None:
            check.refuse("sun", "none", 'that of the set-up "sun by date and place"', "Choose it under set-ups.")
        return self.state.sun

    def choose(self, name: str) -> None:
        """Replace all lights by a set-up from `setups`, around the visible meshes."""
        make = setups[name]
        bounds = [mesh.actor.GetBounds() for mesh in self._subplot.lit.subjects if mesh.actor is not None]
        if not bounds:
            check.refuse("mesh", "none", "open", "Open a mesh first.")
        low, high = np.min(bounds, axis=0)[::2], np.max(bounds, axis=0)[1::2]
        viewer = self._subplot.lights.viewer
        if name == _SUN:
            self._begin(SunByDate(up=up_of(viewer)))
            return
        self.leave()
        self._subplot.lights.replace(make(np.stack([low, high], axis=1).ravel().tolist(), viewer))

    def _begin(self, sun: SunByDate) -> None:
        """Replace all lights by the sun and the sky, with shadows, and an exposure for them."""
        self._subplot.lights.replace(prepared(light) for light in sun.lights())
        model, display = before = self._phong.light_model, self._phong.display
        self._phong.light_model = replace(model, ambient=0.0, shadows=True, clamp=False)
        tone = "filmic" if display.tone == "none" else display.tone
        self._phong.display = replace(display, exposure=_exposure(sun), tone=tone)
        self.state = SunState(sun, sun, sun, before if self.state is None else self.state.before)

    def leave(self) -> None:
        """Forget the sun, if it was chosen, and restore what it set of light model and display."""
        if self.state is None:
            return
        (model, display), self.state = self.state.before, None
        own = {"ambient": model.ambient, "shadows": model.shadows, "clamp": model.clamp}
        self._phong.light_model = replace(self._phong.light_model, **own)
        self._phong.display = replace(self._phong.display, exposure=display.exposure, tone=display.tone)

    def move(self, sun: SunByDate) -> None:
        """Set place, day and hour. The sun in the view follows, except at night; the sky follows at `rest`."""
        assert self.state is not None, "`sun` was read"
        if not sun.brightest:
            self.state = self.state._replace(sun=sun)
            return
        display, before = self._phong.display, self.state.shown
        exposure = display.exposure + _exposure(sun) - _exposure(before)  # keeps the user's changes
        self._set(_SUN, sun.sun)
        self._phong.display = replace(display, exposure=min(max(exposure, _EXPOSURES[0]), _EXPOSURES[1]))
        self.state = self.state._replace(sun=sun, shown=sun)
        self._is_moving = self._subplot.lit.uses_preview_rays = True

    def rest(self) -> None:
        """Let the sky follow the sun."""
        if self._is_moving:
            self._is_moving = self._subplot.lit.uses_preview_rays = False
        if self.state is None or self.state.sky == self.state.shown:
            return
        _, sky = self.state.shown.lights()
        self._set(sky.name, sky)
        self.state = self.state._replace(sky=self.state.shown)

    @property
    def tolerance(self) -> float:
        """Colour error in W/m² that downloads may have, about one step of the picture; 0 without the sun.

        An error of 0 would need far too many rays for shadows of lights in W/m².
        """
        return 0.0 if self.state is None else float(f"{self.state.shown.brightest / _STEPS:.2g}")

    def _named(self, name: str) -> Any:
        lights = self._subplot.lights.renderer_lights
        return next((each for each in lights if each.name == name), None)

    def _set(self, name: str, light: Light) -> None:
        """Replace the light of this name; do nothing if it was deleted. Whether it is on and casts shadows is kept."""
        if (found := self._named(name)) is not None:
            before = found.light(self._subplot.lights.viewer)
            self._subplot.lights.set(found, prepared(replace(light, on=before.on, casts_shadows=before.casts_shadows)))

    def unit_of(self, light: Light, unit: str) -> str:
        """Return the unit of a light's brightness on the page: W/m² for the sun, else the given one."""
        return "W/m²" if self.state is not None and light.name == _SUN else unit

    def shown(self, middles: dict[str, float]) -> dict[str, Any] | None:
        """Return the form of the sun for the page, and a sentence on it; None without the set-up."""
        if self.state is None or self._named(_SUN) is None:
            return None
        sun = self.state.sun
        entries = {entry["name"]: entry for entry in in_words(form_of(sun, "sun", middles))}
        entries["hour"]["unit"] = f"UTC{sun.zone:+d}"
        text = sun.words
        if not sun.brightest:
            text += " The view keeps the last daylight."
        return {"fields": list(entries.values()), "text": text, "night": not sun.brightest}


def _exposure(sun: SunByDate) -> float:
    """Return the exposure in stops for a sun by day."""
    return min(max(_BRIGHTER - math.log2(sun.brightest), _EXPOSURES[0]), _EXPOSURES[1])
