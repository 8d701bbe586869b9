"""The gizmos of one subplot: their lights, selection, drawing and readout."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pvphong.base.color import luminance
from pvphong.base.handles import Handle
from pvphong.base.types import Vector
from pvphong.optics.light import Light
from pvphong.studio.gizmos.drawing import DARK_EDGE, LIGHT_EDGE, Drawing, Overlay, circle, hue
from pvphong.studio.gizmos.handles import ORIGIN, LightInScene, is_movable
from pvphong.studio.gizmos.highlight import SurfacePoint, Surfaces, find_highlight
from pvphong.studio.gizmos.history import History
from pvphong.studio.gizmos.view import STANDS_OFF, USUAL_DPI, Scenery, View, vector
from pvphong.studio.lit_actors import LitActors
from pvphong.studio.window_lights import RendererLight, WindowLights

HIGHLIGHT = "highlight"
"""Name of the handle at a selected light's highlight on the surface."""

_HINT = "h: keys"
SPOT_SIZE = 0.15
"""Initial radius of a spot for which a drag asks for light, as a fraction of the scene's size."""
_SMALLEST = 0.01  # radius of the smallest spot

Keys = Mapping[str, tuple[str, Callable[[], str | None]]]
"""Key → help text and function; the window shows the text that the function returns."""


@dataclass(frozen=True)
class Options:
    """Options of `plotter.phong.add_gizmos`; its docstring describes them."""

    in_screenshots: bool
    angle_step: float
    length_step: float | None
    keys: Keys


def called(light: Light) -> str:
    """Return the name of a light in texts: its own name, or the name of its class if it has none."""
    return light.name or type(light).__name__


class Gizmo(Handle):
    """The draggable representation of a light in the window.

    Parameters
    ----------
    renderer_light : RendererLight
        The light.
    gizmos : Gizmos
        The gizmos of the subplot.
    """

    renderer_light: RendererLight
    first: Light
    """The light as it was when it first got a gizmo in this subplot."""
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
        """Name of the handle under the cursor, or None."""
        gizmo, handle = self._gizmos.hovered or (None, None)
        return handle if gizmo is self else None

    @property
    def light(self) -> Light:
        """The light's current value, in the coordinates that its `frame` names."""
        return self.renderer_light.light(self._gizmos.lights.viewer)

    @property
    def handles(self) -> dict[str, Vector]:
        """World position of each handle, by the handle's name.

        A directional light has the handles "target" and, at its icon, "origin". A point light has "position", and
        "radius" if it has attenuation. A spot light has "position", "target" and "cone". An environment has "rotation".
        The handles of other lights follow from the roles of their fields. A headlight has no handles, because it is at
        the viewer.
        """
        view = self._gizmos.view
        return {name: vector(point) for name, point in self.in_scene(view).points(view).items()}

    @property
    def highlight(self) -> Vector | None:
        """World position of the light's highlight on the lit meshes. The highlight can be dragged too.

        None if there is no highlight, or the gizmo is not selected.
        """
        found = self.surface_highlight(self._gizmos.view) if self.is_selected else None
        return None if found is None else found.point

    def surface_highlight(self, view: View) -> SurfacePoint | None:
        """Return the surface point at which the light's highlight is seen in a view; None without a highlight."""
        return find_highlight(self.in_scene(view).light, view, self._gizmos.lit.shown)

    def in_scene(self, view: View, grabbed: str = "") -> LightInScene:
        """Return the light in world coordinates, together with centre and size of the scene.

        A headlight keeps the frame "headlight". If the light has no position, its icon is in front of the scene, or at
        the place to which it was dragged.

        Parameters
        ----------
        view : View
            The subplot's view.
        grabbed : str
            Name of the handle that a drag has just grabbed; "" if no drag begins. A drag turns a light without a
            position around a point, which `LightInScene.held` chooses. This point is kept for later calls until the
            scene changes.
        """
        light = self.renderer_light.light(view.viewer)
        scenery = self._gizmos.scenery
        scene = scenery, view.viewer if light.frame == "camera" else None  # a camera light moves with the eye
        if self._held is not None and self._held[0] == scene:
            scenery = self._held[1]
        placed = light.in_world(view.viewer)
        shown = LightInScene(replace(placed, frame="headlight") if light.frame == "headlight" else placed, scenery)
        if not grabbed:
            return shown
        self._held = scene, shown.held(grabbed)
        return replace(shown, scenery=self._held[1])


class Gizmos:
    """The gizmos of one renderer, and the objects that commands and drags change.

    Parameters
    ----------
    renderer : pyvista.Renderer
        The renderer of the subplot.
    interactor : vtkRenderWindowInteractor
        VTK's interactor, which reports the events of the window.
    render : callable
        Draws a frame, usually `plotter.render`.
    lights : WindowLights
        The renderer's lights.
    lit : LitActors
        The renderer's lit meshes.
    history : History
        Undo history, which records finished drags and edits.
    only : sequence of RendererLight, optional
        The lights that get a gizmo; by default all, including those added later.
    options : Options
        Behaviour of the gizmos.
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
        """The gizmo under the cursor and the name of its handle."""
        self.listed: Gizmo | None = None
        """The gizmo whose row is pointed at in a list of lights, outside of the view."""
        self.awaits_click: Gizmo | None = None
        """The gizmo whose highlight the next click on a lit mesh places."""
        self.is_hidden, self.shows_help, self.notice = False, False, ""
        self.asks = False
        """True if a drag on a mesh asks for more or less light there."""
        self.spot_size = SPOT_SIZE
        """Radius of the spot that is asked for, as a fraction of the scene's size."""
        self.followers: list[RendererLight] | None = None
        """Lights that follow what is asked for; None for the selected light, or all if none is selected."""
        self.spot: tuple[SurfacePoint, float] | None = None
        """The spot that was asked for last, and its radius."""
        self.more: list[Callable[[Drawing], None]] = []
        """Functions that add marks to each drawing; they are hidden together with the gizmos in pictures."""
        self.firsts = weakref.WeakKeyDictionary[RendererLight, Light]()
        """The lights' values when they got a gizmo; kept for lights that are deleted and restored."""
        self._only = None if only is None else list(only)
        self.overlay = Overlay()
        self._all: list[Gizmo] = []

    @property
    def all(self) -> tuple[Gizmo, ...]:
        """Gizmos of all current lights; with `only`, gizmos of these lights."""
        present = [each for each in self.lights.renderer_lights if self._only is None or each in self._only]
        known = {gizmo.renderer_light: gizmo for gizmo in self._all}
        self._all = [known.get(each) or Gizmo(each, self) for each in present]
        return tuple(self._all)

    @property
    def selected(self) -> Gizmo | None:
        """The gizmo that keys act on, or None."""
        return next((gizmo for gizmo in self._all if gizmo.is_selected), None)

    def select(self, chosen: Gizmo | None) -> None:
        """Select a gizmo; None deselects all."""
        for gizmo in self._all:
            gizmo.is_selected = gizmo is chosen

    def add(self, light: Light) -> None:
        """Add a light to the renderer, give it a gizmo, and select the gizmo."""
        self.select(self.of(self.lights.add(light)))

    def resize_spot(self, size: float) -> None:
        """Set the radius of the spot that is asked for, as a fraction of the scene's size, from 0.01 to 1."""
        self.spot_size = min(max(size, _SMALLEST), 1.0)
        if self.spot is not None:
            self.spot = self.spot[0], self.spot_size * self.scenery.size

    def of(self, renderer_light: RendererLight) -> Gizmo:
        """Return the gizmo of a light. If there is none yet, create it."""
        if self._only is not None and renderer_light not in self._only:
            self._only.append(renderer_light)
        return next(gizmo for gizmo in self.all if gizmo.renderer_light is renderer_light)

    @property
    def soloed(self) -> RendererLight | None:
        """The only light that is on; None if several lights or no lights are on, or there is only one light."""
        viewer, present = self.lights.viewer, self.lights.renderer_lights
        shining = [each for each in present if each.light(viewer).on]
        return shining[0] if len(shining) == 1 < len(present) else None

    # -- the subplot

    @property
    def view(self) -> View:
        """The current view of the subplot."""
        width, height = self.renderer.GetSize()
        x, y = self.renderer.GetOrigin()
        scale = self.renderer.GetRenderWindow().GetDPI() / USUAL_DPI
        return View(self.lights.viewer, (max(width, 1), max(height, 1)), (x, y), scale)

    @property
    def scenery(self) -> Scenery:
        """Centre and size of the drawn objects without a stage (ground or backdrop), used to place icons.

        If nothing is drawn, the result is centre and size of the camera's view.
        """
        with self.lit.without_bounds_of_stage():
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
        """The lit meshes in their current state, prepared for picking."""
        self.lit.show_own_vertices()  # picking must hit a mesh's own triangles
        return Surfaces(self.renderer, self.view, self.lit.shown)

    @property
    def cursor(self) -> tuple[float, float]:
        """Position of the pointer, in pixels of the window."""
        x, y = self.interactor.GetEventPosition()
        return float(x), float(y)

    @property
    def is_pointed_at(self) -> bool:
        """True if the pointer is in the subplot."""
        return bool(self.renderer.IsInViewport(*self.interactor.GetEventPosition()))

    @property
    def is_another_pointed_at(self) -> bool:
        """True if the pointer is in another subplot of the window. That subplot then handles the pointer's events."""
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
        """Draw the gizmos.

        Parameters
        ----------
        view : View
            The subplot's view.
        highlights : mapping
            Visible gizmo → world position of its light's highlight; None if there is no highlight.
        active : tuple of Gizmo and str, optional
            The gizmo and the name of its handle that is hovered or edited.
        readout : str
            Text next to the cursor.
        help_text : str
            List of keys, shown while the help is on.
        """
        self.overlay.scale, view = view.scale, view.in_usual_pixels
        drawing, soloed = Drawing(view), self.soloed

        def mark(gizmo: Gizmo) -> str:
            is_on = gizmo.renderer_light.light(view.viewer).on
            return "solo" if gizmo.renderer_light is soloed else "" if is_on else "off"

        for gizmo, highlight in highlights.items():
            shown, handle = gizmo.in_scene(view), active[1] if active and active[0] is gizmo else None
            light, is_pointed_at = shown.light, handle is not None or gizmo is self.listed
            drawing.color, drawing.edge = hue(light), DARK_EDGE if light.on else LIGHT_EDGE
            shown.draw(drawing, gizmo.is_selected or is_pointed_at, handle)
            label = ", ".join(filter(None, [called(light) if is_pointed_at else "", mark(gizmo)]))
            if label and is_movable(light):
                drawing.label(shown.origin, label, 18.0)
            for name, point in shown.points(view).items():
                if name not in ("position", ORIGIN) or handle == name:  # the icon marks it
                    drawing.handle(point, hovered=name == handle)
            if highlight is not None:
                drawing.ring(np.array(highlight), hovered=handle == HIGHLIGHT)
        if self.asks and self.spot is not None:
            drawing.color = (1.0, 1.0, 1.0)
            middle, normal = np.array(self.spot[0].point), np.array(self.spot[0].normal)
            drawing.line(circle(middle + 0.02 * self.spot[1] * normal, normal, self.spot[1]))
        for add in self.more:
            add(drawing)
        self.overlay.put(drawing)
        has_room = self.overlay.help(help_text if self.shows_help else "", view.size)
        lines = [self.notice, "" if self.shows_help else _HINT]
        if (chosen := self.selected) is not None:
            light = chosen.renderer_light.light(view.viewer)
            kind, bright = type(light).__name__, light.intensity * luminance(light.diffuse)
            parts = [f"{light.name}: {kind}" if light.name else kind, f"intensity {light.intensity:.3g}"]
            lines[1] = ", ".join([*parts, f"luminance {bright:.3g}", *filter(None, [mark(chosen)])])
        self.overlay.status("\n".join(filter(None, lines)) if has_room else "", view.size)
        x, y = (each / self.overlay.scale for each in self.cursor)
        self.overlay.readout(readout, (x - view.origin[0], y - view.origin[1]), view.size)
        self.overlay.attach(self.renderer)
