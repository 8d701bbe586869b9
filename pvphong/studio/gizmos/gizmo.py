"""The gizmos of one subplot: which lights have one, which is selected, how they are drawn, what is said of them."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pvphong.base.handles import Handle
from pvphong.base.types import Vector
from pvphong.optics.light import Light
from pvphong.studio.gizmos.drawing import DARK_EDGE, LIGHT_EDGE, Drawing, Overlay, hue
from pvphong.studio.gizmos.handles import ORIGIN, LightInScene, is_movable, luminance
from pvphong.studio.gizmos.highlight import SurfacePoint, Surfaces, find_highlight
from pvphong.studio.gizmos.history import History
from pvphong.studio.gizmos.view import STANDS_OFF, Scenery, View, vector
from pvphong.studio.lit_actors import LitActors
from pvphong.studio.window_lights import RendererLight, WindowLights

HIGHLIGHT = "highlight"
"""The handle of a selected light on the surface."""

_HINT = "h: keys"

Keys = Mapping[str, tuple[str, Callable[[], str | None]]]
"""Key → what the help says, and what is done; what that gives is shown in the window."""


@dataclass(frozen=True)
class Options:
    """How gizmos behave; see `plotter.phong.add_gizmos`."""

    in_screenshots: bool
    angle_step: float
    length_step: float | None
    keys: Keys


def called(light: Light) -> str:
    """What a light is called on the screen: its name, or its kind where it has none."""
    return light.name or type(light).__name__


class Gizmo(Handle):
    """What stands for a light in the window, to be dragged.

    Parameters
    ----------
    renderer_light : RendererLight
        The light.
    gizmos : Gizmos
        All of the subplot.
    """

    renderer_light: RendererLight
    first: Light
    """The light as it was when it first got a gizmo here."""
    is_selected: bool

    def __init__(self, renderer_light: RendererLight, gizmos: Gizmos) -> None:
        self.renderer_light = renderer_light
        self.first = gizmos.firsts.setdefault(renderer_light, renderer_light.light(gizmos.lights.viewer))
        self.is_selected = False
        self._gizmos = gizmos
        self._held: tuple[Any, Scenery] | None = None

    def __repr__(self) -> str:
        return f"Gizmo({self.light!r})"

    @property
    def hovered(self) -> str | None:
        """The handle under the cursor."""
        gizmo, handle = self._gizmos.hovered or (None, None)
        return handle if gizmo is self else None

    @property
    def light(self) -> Light:
        """The light's current value, in its own frame."""
        return self.renderer_light.light(self._gizmos.lights.viewer)

    @property
    def handles(self) -> dict[str, Vector]:
        """Name of each handle that the light has → where it is in the world.

        A directional light has "target" and, at its icon, "origin"; a point light "position", and "radius" if it
        weakens; a spot light "position", "target" and "cone"; an environment "rotation"; any other those of its
        fields' roles. A headlight has none: it is where the viewer is.
        """
        view = self._gizmos.view
        return {name: vector(point) for name, point in self.in_scene(view).points(view).items()}

    @property
    def highlight(self) -> Vector | None:
        """Where its highlight is on the lit meshes, if it is selected and throws one: that can be dragged too."""
        found = self.surface_highlight(self._gizmos.view) if self.is_selected else None
        return None if found is None else found.point

    def surface_highlight(self, view: View) -> SurfacePoint | None:
        """Where the light has its highlight, for an eye."""
        return find_highlight(self.in_scene(view).light, view, self._gizmos.lit.shown)

    def in_scene(self, view: View, grabbed: str = "") -> LightInScene:
        """The light in the world, and the scene around it; a headlight is still called one.

        The icon of a light without a place is in front of the scene, or where a drag has left it: from when a handle is
        grabbed it turns around the end that is not, for as long as the scene stays.
        """
        light = self.renderer_light.light(view.viewer)
        scenery = self._gizmos.scenery
        scene = scenery, view.viewer if light.frame == "camera" else None  # the eye, if the light goes along
        if self._held is not None and self._held[0] == scene:
            scenery = self._held[1]
        placed = light.in_world(view.viewer)
        shown = LightInScene(replace(placed, frame="headlight") if light.frame == "headlight" else placed, scenery)
        if not grabbed:
            return shown
        self._held = scene, shown.held(grabbed)
        return replace(shown, scenery=self._held[1])


class Gizmos:
    """The gizmos of one renderer, and what commands and drags change of it.

    Parameters
    ----------
    renderer, interactor
        VTK's.
    render : callable
        Draws a frame, wherever it is seen: `plotter.render`.
    lights : WindowLights
        The renderer's lights.
    lit : LitActors
        The renderer's lit meshes.
    history : History
        Where finished drags and edits go.
    only : sequence of RendererLight, optional
        The lights that get a gizmo; all, also those added later, if not given.
    options : Options
        How they behave.
    """

    def __init__(
        self,
        renderer: Any,
        interactor: Any,
        render: Callable[[], None],
        lights: WindowLights,
        lit: LitActors,
        history: History,
        only: Sequence[RendererLight] | None,
        options: Options,
    ) -> None:
        self.renderer, self.interactor, self.render = renderer, interactor, render
        self.lights, self.lit, self.history, self.options = lights, lit, history, options
        self.hovered: tuple[Gizmo, str] | None = None
        """The handle under the cursor, and whose it is."""
        self.is_hidden, self.shows_help, self.notice = False, False, ""
        self.firsts = weakref.WeakKeyDictionary[RendererLight, Light]()
        """Lights as they were when they got a gizmo, for those that are deleted and come back too."""
        self._only = None if only is None else list(only)
        self.overlay = Overlay()
        self._all: list[Gizmo] = []

    @property
    def all(self) -> tuple[Gizmo, ...]:
        """A gizmo for each light that is there now."""
        present = [each for each in self.lights.renderer_lights if self._only is None or each in self._only]
        known = {gizmo.renderer_light: gizmo for gizmo in self._all}
        self._all = [known.get(each) or Gizmo(each, self) for each in present]
        return tuple(self._all)

    @property
    def selected(self) -> Gizmo | None:
        """The gizmo that keys act on: the one grabbed last."""
        return next((gizmo for gizmo in self._all if gizmo.is_selected), None)

    def select(self, chosen: Gizmo | None) -> None:
        """Select a gizmo, or none."""
        for gizmo in self._all:
            gizmo.is_selected = gizmo is chosen

    def add(self, light: Light) -> None:
        """Add a light, give it a gizmo, and select it."""
        self.select(self.of(self.lights.add(light)))

    def of(self, renderer_light: RendererLight) -> Gizmo:
        """The gizmo of a light, which gets one if it has none."""
        if self._only is not None and renderer_light not in self._only:
            self._only.append(renderer_light)
        return next(gizmo for gizmo in self.all if gizmo.renderer_light is renderer_light)

    @property
    def soloed(self) -> RendererLight | None:
        """The light that is on while all others of several are off, if there is such a one."""
        viewer, present = self.lights.viewer, self.lights.renderer_lights
        shining = [each for each in present if each.light(viewer).on]
        return shining[0] if len(shining) == 1 < len(present) else None

    # -- the subplot around them

    @property
    def view(self) -> View:
        """The subplot as it is now."""
        width, height = self.renderer.GetSize()
        x, y = self.renderer.GetOrigin()
        return View(self.lights.viewer, (max(width, 1), max(height, 1)), (x, y))

    @property
    def scenery(self) -> Scenery:
        """What is drawn, or without that what the camera looks at; icons without a place stand before its middle."""
        bounds = np.array(self.renderer.ComputeVisiblePropBounds()).reshape(3, 2)
        size = 0.5 * float(np.linalg.norm(bounds[:, 1] - bounds[:, 0]))
        if (bounds[:, 0] > bounds[:, 1]).any() or not 0.0 < size < np.inf:
            viewer = self.lights.viewer
            center, size = vector(viewer.focal_point), 0.5 * viewer.distance
        else:
            center = vector(bounds.mean(axis=1))
        return Scenery(center, size, center, STANDS_OFF * size)

    @property
    def surfaces(self) -> Surfaces:
        """The lit meshes as they are now, to be asked what is under a cursor."""
        self.lit.show_own_vertices()  # what is hit is a triangle of a mesh's own
        return Surfaces(self.renderer, self.view, self.lit.shown)

    @property
    def cursor(self) -> tuple[float, float]:
        """Where the pointer is, in pixels of the window."""
        x, y = self.interactor.GetEventPosition()
        return float(x), float(y)

    @property
    def is_pointed_at(self) -> bool:
        """Whether the pointer is in the subplot."""
        return bool(self.renderer.IsInViewport(*self.interactor.GetEventPosition()))

    @property
    def is_another_pointed_at(self) -> bool:
        """Whether the pointer is in the window, but in another subplot: what is pressed there is that one's."""
        (x, y), (width, height) = self.interactor.GetEventPosition(), self.renderer.GetRenderWindow().GetSize()
        return 0 <= x < width and 0 <= y < height and not self.is_pointed_at

    # -- drawing

    def draw(
        self,
        view: View,
        highlights: Mapping[Gizmo, Vector | None],
        active: tuple[Gizmo, str] | None,
        readout: str,
        help_text: str,
    ) -> None:
        """Draw them as they are now.

        Parameters
        ----------
        view : View
            The subplot.
        highlights : mapping
            Each gizmo that is shown → where its highlight is to be shown.
        active : tuple of Gizmo and str, optional
            The handle that is hovered or changed.
        readout : str
            What stands beside the cursor.
        help_text : str
            All keys, shown where the help is on.
        """
        drawing, soloed = Drawing(view), self.soloed

        def mark(gizmo: Gizmo) -> str:
            is_on = gizmo.renderer_light.light(view.viewer).on
            return "solo" if gizmo.renderer_light is soloed else "" if is_on else "off"

        for gizmo, highlight in highlights.items():
            shown, handle = gizmo.in_scene(view), active[1] if active and active[0] is gizmo else None
            light = shown.light
            drawing.color, drawing.edge = hue(light), DARK_EDGE if light.on else LIGHT_EDGE
            shown.draw(drawing, gizmo.is_selected or handle is not None, handle)
            if mark(gizmo) and is_movable(light):
                drawing.label(shown.origin, mark(gizmo), 18.0)
            for name, point in shown.points(view).items():
                if name not in ("position", ORIGIN) or handle == name:  # an icon is there
                    drawing.handle(point, hovered=name == handle)
            if highlight is not None:
                drawing.ring(np.array(highlight), hovered=handle == HIGHLIGHT)
        self.overlay.put(drawing)
        has_room = self.overlay.help(help_text if self.shows_help else "", view.size)
        lines = [self.notice, "" if self.shows_help else _HINT]
        if (chosen := self.selected) is not None:
            light = chosen.renderer_light.light(view.viewer)
            kind, bright = type(light).__name__, light.intensity * luminance(light.diffuse)
            parts = [f"{light.name}: {kind}" if light.name else kind, f"intensity {light.intensity:.3g}"]
            lines[1] = ", ".join([*parts, f"luminance {bright:.3g}", *filter(None, [mark(chosen)])])
        self.overlay.status("\n".join(filter(None, lines)) if has_room else "", view.size)
        x, y = self.cursor
        self.overlay.readout(readout, (x - view.origin[0], y - view.origin[1]), view.size)
        self.overlay.attach(self.renderer)
