"""The page's probe. It reads the vertex under the cursor, and pins: vertices that stay in the list and follow edits."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.base.color import XYZ_OF_RGB
from pvphong.base.types import Vector, rgb
from pvphong.scene.scene import light_labels
from pvphong.studio.gizmos import Gizmos
from pvphong.studio.gizmos.drawing import DARK_EDGE, Drawing
from pvphong.studio.probing import Locators, Place, Probe, read
from pvphong.studio.subplot import Subplot

_MOST_PINS = 9
_CLICK = 4.0  # pixels of a usual screen that the cursor may move between press and release of a click
_BEFORE_STYLE = 0.1  # observer priority: after the gizmos, which block events on their handles

_MARK: Vector = (1.0, 0.85, 0.2)
_GREY: Vector = (0.6, 0.6, 0.6)


@dataclass(eq=False)
class _Pin:
    """A vertex that stays in the list."""

    number: int
    place: Place
    local: Vector
    """The pinned point, in the mesh's own coordinates."""
    geometry: Any
    """`LitMesh.geometry`, without the matrix, when the vertex was found."""


class LiveProbe:
    """Reads lit values in the view of a page.

    While the probe is on, the vertex under the cursor is marked and read. A click pins the vertex.

    Parameters
    ----------
    subplot : Subplot
        The subplot, with gizmos.
    name_of : callable
        Returns the page's name of a lit mesh.
    say : callable
        Shows a message.
    """

    def __init__(self, subplot: Subplot, name_of: Callable[[Any], str], say: Callable[[str], None]) -> None:
        assert subplot.interaction is not None, "a studio has gizmos"
        self._subplot, self._name_of, self._say = subplot, name_of, say
        self._gizmos: Gizmos = subplot.interaction.gizmos
        self.is_on = False
        self._under: Place | None = None
        self._pins: list[_Pin] = []
        self._pressed: tuple[float, float] | None = None
        self._is_held = False
        self._locators, self._observed = Locators(), list[tuple[Any, int]]()
        interactor = self._gizmos.interactor
        self._observe(interactor, "MouseMoveEvent", LiveProbe._moved, _BEFORE_STYLE)
        self._observe(interactor, "LeftButtonPressEvent", LiveProbe._press, _BEFORE_STYLE)
        # While the camera turns, only the style gets the interactor's events.
        self._observe(interactor, "LeftButtonReleaseEvent", LiveProbe._release, _BEFORE_STYLE)
        self._observe(interactor.GetInteractorStyle(), "EndInteractionEvent", LiveProbe._release, 0.0)
        self._gizmos.more.append(self._draw)

    def _observe(self, subject: Any, event: str, react: Callable[[LiveProbe], None], priority: float) -> None:
        probe = weakref.ref(self)

        def happened(_subject: Any, _event: str) -> None:
            if (alive := probe()) is not None:
                react(alive)

        self._observed.append((subject, subject.AddObserver(event, happened, priority)))

    # -- triggers of the page

    def switch(self, on: Any) -> None:
        """Switch the reading under the cursor on or off. Pins stay."""
        self.is_on, self._under, self._pressed = check.flag("on", on), None, None

    def unpin(self, number: Any = None) -> None:
        """Remove the pin with a number; without a number, remove all pins."""
        self._pins = [] if number is None else [pin for pin in self._pins if str(pin.number) != str(number)]

    # -- the mouse

    def _moved(self) -> None:
        """Find the vertex under the cursor, in the last frame."""
        if self.is_on and not self._is_held:
            self._under = self._pick()

    def _press(self) -> None:
        self._pressed, self._is_held = (self._gizmos.cursor if self.is_on else None), True

    def _release(self) -> None:
        """Pin the vertex under the cursor, unless the mouse has moved since the button was pressed."""
        pressed, self._pressed, self._is_held = self._pressed, None, False
        if pressed is None or not self.is_on:
            return
        away = np.hypot(*np.subtract(pressed, self._gizmos.cursor))
        if away <= _CLICK * self._gizmos.view.scale and (place := self._pick()) is not None:
            self._pin(place)

    def _pin(self, place: Place) -> None:
        if any(pin.place == place for pin in self._pins):
            return
        if len(self._pins) >= _MOST_PINS:
            self._say(f"There are {_MOST_PINS} pins already. Remove one to pin another point.")
            return
        free = min(set(range(1, _MOST_PINS + 1)) - {pin.number for pin in self._pins})
        self._pins.append(_Pin(free, place, place.local, place.mesh.geometry()[0]))

    def _pick(self) -> Place | None:
        """Return the nearest corner of the face under the cursor; None if a handle is there, or no surface."""
        renderer, gizmos = self._subplot.renderer, self._gizmos
        if not gizmos.is_pointed_at or gizmos.hovered is not None:
            return None
        x, y = (round(each) for each in gizmos.cursor)
        depth = renderer.GetZ(x, y)
        if depth >= 1.0:
            return None
        renderer.SetDisplayPoint(x, y, depth)
        renderer.DisplayToWorld()
        *point, w = renderer.GetWorldPoint()
        if not w:
            return None
        return self._locators.nearest(self._subplot.lit.shown, [each / w for each in point])

    # -- marks in the view

    def _update_pins(self) -> list[_Pin]:
        """Return the pins of visible meshes. If a mesh has changed, find the pinned vertex again."""
        shown = self._subplot.lit.shown
        here = [pin for pin in self._pins if pin.place.mesh in shown and pin.place.mesh.drawn.n_points]
        for pin in here:
            mesh = pin.place.mesh
            if pin.geometry != mesh.geometry()[0]:
                away = np.linalg.norm(np.asarray(mesh.drawn.points) - pin.local, axis=1)
                pin.place, pin.geometry = Place(mesh, int(np.argmin(away))), mesh.geometry()[0]
        return here

    def _draw(self, drawing: Drawing) -> None:
        """Mark the pins, with their numbers, and the vertex under the cursor, in a drawing."""
        drawing.color, drawing.edge = _MARK, DARK_EDGE
        for pin in self._update_pins():
            drawing.handle(np.array(pin.place.position))
            drawing.label(np.array(pin.place.position), f" {pin.number} ", 9.0)
        if self._is_read:
            assert self._under is not None
            drawing.ring(np.array(self._under.position), hovered=True)

    @property
    def _is_read(self) -> bool:
        """True if the probe is on and a vertex is under the cursor."""
        under = self._under
        is_there = under is not None and under.mesh in self._subplot.lit.shown
        return self.is_on and under is not None and is_there and under.row < under.mesh.drawn.n_points

    # -- values for the page

    def shown(self) -> dict[str, Any]:
        """Return the page's state: the readings under the cursor and of each pin."""
        under = self._entry(self._under, "") if self._is_read and self._under is not None else None
        pins = [self._entry(pin.place, str(pin.number)) for pin in self._update_pins()]
        return {"on": self.is_on, "under": under, "pins": [pin for pin in pins if pin is not None]}

    def _entry(self, place: Place, number: str) -> dict[str, Any] | None:
        scene = self._subplot.scene
        name = self._name_of(place.mesh) if len(self._subplot.lit.shown) > 1 else ""
        found = read(place, name, scene)
        if found is None:
            return None
        labels = light_labels(scene)
        names = {label: light.name or type(light).__name__ for label, light in zip(labels, scene.lights, strict=True)}
        hues = {label: rgb(light.diffuse) for label, light in zip(labels, scene.lights, strict=True)}
        return entry(found, number, names, hues, bounces=scene.light_model.bounces > 0)

    def release(self) -> None:
        """Detach from the view."""
        for subject, tag in self._observed:
            subject.RemoveObserver(tag)
        self._gizmos.more.remove(self._draw)


def entry(
    found: Probe, number: str, names: dict[str, str], hues: dict[str, Vector], *, bounces: bool
) -> dict[str, Any]:
    """Return the page's entry for a reading: its vertex, its colour, and a bar for each part of the light.

    Parameters
    ----------
    found : Probe
        The reading.
    number : str
        Number of the pin; "" under the cursor.
    names, hues : dict
        Name of each light on the page, and its colour; the keys are those of `found.shares`.
    bounces : bool
        True to include a bar for bounced light.
    """
    parts = [("ambient", found.base, _GREY), *((names[k], share, hues[k]) for k, share in found.shares.items())]
    parts += [("bounced", found.bounced, _GREY)] * bounces
    bright = [luminance(share) for _, share, _ in parts]
    whole, largest = sum(bright), max(bright)
    bars = [
        {
            "name": name,
            "share": f"{each / whole:.0%}" if whole > 0.0 else "0%",
            "value": f"{each:.3g}",
            "width": round(100.0 * each / largest, 1) if largest > 0.0 else 0.0,
            "hex": _hex(_fullest(hue)),
        }
        for (name, _, hue), each in zip(parts, bright, strict=True)
    ]
    return {
        "number": number,
        "title": f"{found.mesh}, vertex {found.point_id}" if found.mesh else f"vertex {found.point_id}",
        "value": "  ".join(f"{channel:.3f}" for channel in found.color),
        "hex": _hex(found.color),
        "luminance": f"{whole:.3g}",
        "is_clipped": max(np.sum([share for _, share, _ in parts], axis=0).tolist()) > 1.0,
        "bars": bars,
    }


def luminance(color: Vector) -> float:
    """Return the luminance of a linear colour; 1 for white."""
    return float(XYZ_OF_RGB[1] @ color)


def _fullest(color: Vector) -> Vector:
    red, green, blue = (each / max(*color, 1e-9) for each in color)
    return red, green, blue


def _hex(color: Vector) -> str:
    return "#" + "".join(f"{round(255 * min(max(each, 0.0), 1.0)):02x}" for each in color)
