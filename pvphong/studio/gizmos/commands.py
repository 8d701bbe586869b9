"""Keys: `COMMANDS`, at the end, is the table of all of them; above it stands what each does.

To add a key: write a function, as `Command.edits` says, and a row of the table, and the same row in the README's table
of keys, which a test compares. Keys in `TAKEN` are PyVista's or VTK's, and d, x and 4 are those of `pvphong view`. What
a light can do is asked of its fields' roles.
"""

from __future__ import annotations

import colorsys
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from pvphong.base import check
from pvphong.base.types import ColorLike, Vector, rgb
from pvphong.base.vectors import unit_vector
from pvphong.optics.light import Light
from pvphong.optics.lights import PointLight
from pvphong.optics.material import Material
from pvphong.optics.roles import Aim
from pvphong.studio.gizmos.gizmo import Gizmo, Gizmos, Keys, called
from pvphong.studio.gizmos.handles import comes_from_somewhere, fields, luminance
from pvphong.studio.gizmos.view import vector
from pvphong.studio.window_lights import free_name

# -- help, gizmos, selection, undo


def toggle_help(gizmos: Gizmos) -> None:
    """Show all keys, or hide them."""
    gizmos.shows_help = not gizmos.shows_help


def toggle_hidden(gizmos: Gizmos) -> None:
    """Hide all gizmos, or show them."""
    gizmos.is_hidden = not gizmos.is_hidden
    gizmos.notice = "gizmos hidden: g shows them" if gizmos.is_hidden else ""


def select_next(gizmos: Gizmos) -> None:
    """Select the next light, also one without handles: keys act on it; after the last none."""
    ring = [None, *gizmos.all]
    chosen = ring[(ring.index(gizmos.selected) + 1) % len(ring)]
    gizmos.select(chosen)
    gizmos.notice = "" if chosen else "no light selected"


def undo_or_redo(gizmos: Gizmos, step: int) -> None:
    """Take the last step back, or the last step that was undone again."""
    if step < 0:
        gizmos.notice = "undone" if gizmos.history.undo() else "nothing to undo"
    else:
        gizmos.notice = "done again" if gizmos.history.redo() else "nothing to redo"


# -- the selected light: what it becomes


def mute(_gizmos: Gizmos, gizmo: Gizmo) -> Light:
    """Off, or on."""
    return replace(gizmo.light, on=not gizmo.light.on)


def reset(_gizmos: Gizmos, gizmo: Gizmo) -> Light:
    """As it was when it got its gizmo."""
    return gizmo.first


def to_camera(gizmos: Gizmos, gizmo: Gizmo) -> Light:
    """Where the eye is, shining along the view axis."""
    light, viewer = gizmo.light, gizmos.lights.viewer
    world = replace(light, frame="headlight").in_world(viewer)
    aim: Any = tuple(viewer.distance * part for part in viewer.view_direction)  # the focal point is its target
    aimed = replace(world, **dict.fromkeys(list(fields(world, Aim))[:1], aim))
    return aimed.in_frame(light.frame, viewer)


def brighten(gizmos: Gizmos, gizmo: Gizmo, step: int) -> Light:
    """So many thirds of a stop more: three make it twice as bright."""
    light = gizmo.light
    intensity = on_scale(light.intensity, 3, step) if light.intensity else 0.0
    stops = f" = {math.log2(intensity):+.2g} stops" if intensity else ": Enter, to type one"
    gizmos.notice = f"{called(light)}: intensity {intensity:.4g}{stops}"
    return replace(light, intensity=intensity)


def on_scale(value: float, parts: int, step: int) -> float:
    """A number times 2^(step/parts); on the scale of such steps around 1 without rounding errors piling up."""
    at = parts * math.log2(value)
    if abs(at - round(at)) < 1e-9:
        return float(2.0 ** ((round(at) + step) / parts))
    return float(value * 2.0 ** (step / parts))


_HUE_STEP = 15.0  # degrees
# Below this saturation a colour has no hue to be turned, and gets one this strong.
_GREY, _TINTED = 0.01, 0.4
# Of red in one step warmer; blue is divided by it.
_WARMER = 2.0**0.25


def hue_turned(color: ColorLike, degrees: float) -> Vector:
    """A colour whose hue is so many degrees further, red to yellow to green; value and saturation stay.

    Grey has no hue: it becomes a light red, or for negative degrees the light violet before it.
    """
    hue, saturation, value = colorsys.rgb_to_hsv(*rgb(color))
    if saturation < _GREY:
        hue, saturation, degrees = 0.0, _TINTED, min(degrees, 0.0)
    return colorsys.hsv_to_rgb((hue + degrees / 360.0) % 1.0, saturation, value)


def warmed(color: ColorLike, steps: float) -> Vector:
    """A colour with more red and less blue, or for negative steps the reverse, of the same luminance."""
    tinted = np.array(rgb(color)) * (_WARMER**steps, 1.0, _WARMER**-steps)
    return vector(tinted * (luminance(color) / luminance(tinted.tolist()))) if tinted.any() else rgb(color)


def turn_hue(gizmos: Gizmos, gizmo: Gizmo, step: int) -> Light:
    """Its hue so many steps further."""
    return _recolor(gizmos, gizmo, "hue", partial(hue_turned, degrees=_HUE_STEP * step))


def warm(gizmos: Gizmos, gizmo: Gizmo, step: int) -> Light:
    """Its colours so many steps warmer."""
    return _recolor(gizmos, gizmo, "warmer" if step > 0 else "cooler", partial(warmed, steps=step))


def _recolor(gizmos: Gizmos, gizmo: Gizmo, what: str, change: Callable[[ColorLike], Vector]) -> Light:
    """All colours that it has of its own changed alike."""
    light = gizmo.light
    colors = {"diffuse": light.diffuse, "specular": light.specular, "ambient": light.ambient}
    given = {field: color for field, color in colors.items() if color is not None and any(rgb(color))}
    changes: dict[str, Any] = {field: change(color) for field, color in given.items()}
    changed = replace(light, **changes)
    red, green, blue = rgb(changed.diffuse)
    color = f"colour ({red:.3g}, {green:.3g}, {blue:.3g}), luminance {luminance(changed.diffuse):.3g}"
    gizmos.notice = f"{called(light)}: {what}, {color}"
    return changed


# -- lights that come and go

# Of the scene's size: how high above a surface a new light stands, and how far beside a light its double.
_ABOVE, _BESIDE = 0.4, 0.15


def add(gizmos: Gizmos) -> None:
    """A point light above the place of a surface that the cursor points at; half of it arrives there."""
    below = gizmos.surfaces.pick(gizmos.cursor)
    if below is None:
        gizmos.notice = "new light: point at a lit mesh"
        return
    height = _ABOVE * gizmos.scenery.size
    place = vector(np.array(below.point) + height * np.array(below.normal))
    _put(gizmos, PointLight(position=place, attenuation=(1.0, 0.0, height**-2), name="point"))


def duplicate(gizmos: Gizmos, gizmo: Gizmo) -> None:
    """A light like the selected one, a little to the right of it; one without a place comes from the right."""
    light, viewer = gizmo.light, gizmos.lights.viewer
    if light.frame == "headlight" or not comes_from_somewhere(light):
        where = "is the viewer" if light.frame == "headlight" else "comes from all around"
        gizmos.notice = f"{called(light)}: a light that {where} has no double"
        return
    world, right = light.in_world(viewer), viewer.axes[0]
    if world.places:
        double = world.moved(lambda place: vector(np.array(place) + _BESIDE * gizmos.scenery.size * right))
    else:
        turned: dict[str, Any] = {
            field: vector(math.hypot(*aim) * (np.array(unit_vector(aim)) - 2.0 * _BESIDE * right))
            for field, aim in fields(world, Aim).items()
        }
        double = replace(world, **turned)
    _put(gizmos, double.in_frame(light.frame, viewer))


def _put(gizmos: Gizmos, light: Light) -> None:
    name = free_name(light.name or "light", {known.name for known in gizmos.lights.values})
    gizmos.add(replace(light, name=name))
    gizmos.notice = f"added: {name}"


def delete(gizmos: Gizmos, gizmo: Gizmo) -> None:
    """The selected light gone; `undo` brings it back."""
    gizmos.notice = f"deleted: {called(gizmo.light)}; z brings it back"
    gizmos.lights.remove(gizmo.renderer_light)


def solo(gizmos: Gizmos, gizmo: Gizmo) -> None:
    """All others off; if they are off already, all on."""
    chosen, viewer = gizmo.renderer_light, gizmos.lights.viewer
    others_on = gizmos.soloed is chosen
    for each in gizmos.lights.renderer_lights:
        each.set(replace(each.light(viewer), on=others_on or each is chosen), viewer)


# -- materials

_NAMED = {name: Material.named(name) for name in Material.names()}
_NAMED = {name: named for name, named in _NAMED.items() if named.reflectance is None or not named.reflectance.needs}
"""Without those for which a mesh needs tangents."""


def next_material(material: Material, step: int) -> Material:
    """The next of the named materials, or the one before; after or before one that has no name the first or last."""
    names, name = list(_NAMED), name_of(material)
    at = names.index(name) if name else min(-step, 0)
    chosen = replace(_NAMED[names[(at + step) % len(names)]], albedo=material.albedo, tangents=material.tangents)
    is_its_own = name and _NAMED[name].reflectance is not None
    return chosen if chosen.reflectance or is_its_own else replace(chosen, reflectance=material.reflectance)


def name_of(material: Material) -> str:
    """What a material is called, whatever its reflectance and albedo; "" if it is none of the named ones."""
    bare = replace(material, albedo=1.0, tangents=None)
    plain = replace(bare, reflectance=None)
    return next((name for name, named in _NAMED.items() if named in (bare, plain)), "")


def shine(material: Material, step: int) -> Material:
    """A narrower highlight, or a wider: √2 times the exponent, on the scale of powers of √2; below 1 is 0."""
    if "shininess" in material.maps:
        return material
    shininess = on_scale(material.shininess or 0.5**0.5, 2, step)  # 0 is one step below 1
    return replace(material, shininess=shininess if shininess >= 1.0 else 0.0)


def strengthen(material: Material, step: int) -> Material:
    """So many tenths more of specular reflectance, at most 1 in any channel."""
    if "specular" in material.maps:
        return material
    colors = rgb(material.specular)
    largest = max(colors)
    level = round(min(max(largest + 0.1 * step, 0.0), max(1.0, largest)), 10)
    return replace(material, specular=[level * c / largest for c in colors] if largest else level)


# -- the table


class Command(NamedTuple):
    """What one key does, or several that belong together."""

    keys: str
    """The keys by VTK's names, with spaces between them."""

    what: str
    """What the help says."""

    act: Callable[..., Any]
    """What each of the keys does, as `edits` says."""

    edits: str = ""
    """What it changes, as one step of undo.

    "light": from the gizmos and the selected one to what its light becomes, or None where the gizmos are told.
    "lights": a function of the gizmos, which changes their lights. "material": from a material to what that of the mesh
    under the cursor becomes, or those of all meshes. Nothing: a function of the gizmos.
    """

    steps: tuple[int, ...] = ()
    """The `step` that the act is given by each of the keys, if it takes one."""


_BACK_ON = (-1, 1)

COMMANDS = (
    Command("h", "these keys", toggle_help),
    Command("g", "hide or show the gizmos", toggle_hidden),
    Command("n", "select the next light", select_next),
    Command("z y", "undo, redo", undo_or_redo, steps=_BACK_ON),
    Command("m", "light off or on", mute, "light"),
    Command("o", "this light alone, or all", solo, "light"),
    Command("k", "light to the camera", to_camera, "light"),
    Command("0", "light as it was at first", reset, "light"),
    Command("Left Right", "dimmer, brighter by 1/3 stop", brighten, "light", _BACK_ON),
    Command("comma period", "hue back, on", turn_hue, "light", _BACK_ON),
    Command("1 2", "cooler, warmer", warm, "light", _BACK_ON),
    Command("N", "new light where the cursor points", add, "lights"),
    Command("D", "duplicate the light", duplicate, "light"),
    Command("Delete BackSpace", "delete the light", delete, "light"),
    Command("M K", "material: next, previous", next_material, "material", (1, -1)),
    Command("5 6", "less, more shiny", shine, "material", _BACK_ON),
    Command("7 8", "weaker, stronger highlight", strengthen, "material", _BACK_ON),
)
_TYPING = {"Enter": "type a value; in a drag: digits"}
_MOUSE = {
    "drag": "a handle, or the highlight",
    "Shift": "along one axis",
    "Ctrl": "in steps",
    "Esc": "put back",
}
_SHORT = {"comma": ",", "period": ".", "Delete": "Del", "BackSpace": "Backspace"}

TAKEN = frozenset({*"qQeErRwWsSpPbBvVCcfFuUiI3lLjJtTaA+-", "Up", "Down", "plus", "minus"})
"""What vtkInteractorStyle::OnChar, `Plotter.reset_key_events`, PyVista's picking and VTK's widgets listen to."""

_OF_KEYS = {
    key: (command, {"step": command.steps[at]} if command.steps else {})
    for command in COMMANDS
    for at, key in enumerate(command.keys.split())
}
ENTER = frozenset({"Return", "KP_Enter"})
"""VTK's names of the keys that begin to type a value, and take it."""

OURS = frozenset({*_OF_KEYS, *ENTER})
"""The keys that have a meaning here."""


def run(gizmos: Gizmos, key: str, *, control: bool = False) -> bool:
    """Do what a key stands for, here or among the caller's own; False if it stands for nothing."""
    if control and key not in ("z", "y"):
        return False
    if key in _OF_KEYS:
        command, step = _OF_KEYS[key]
        act, edits = partial(command.act, **step), command.edits
        gizmos.notice = ""
        if not edits:
            act(gizmos)
            return True
        gizmos.history.settle()  # what is slid in a page
        with gizmos.history.edit(gizmos.lit if edits == "material" else gizmos.lights):
            if edits == "material":
                _change_material(gizmos, act)
            elif edits == "lights":
                act(gizmos)
            elif (gizmo := gizmos.selected) is None:
                gizmos.notice = "no light is selected: n, or a click on one, does"
            else:
                change_light(gizmos, gizmo, act)
        return True
    if key in gizmos.options.keys:
        gizmos.notice = gizmos.options.keys[key][1]() or ""
        return True
    return False


def change_light(gizmos: Gizmos, gizmo: Gizmo, act: Callable[[Gizmos, Gizmo], Light | None]) -> None:
    """Make a light what an act says it becomes, if that says so."""
    changed = act(gizmos, gizmo)
    if changed is not None:
        gizmo.renderer_light.set(changed, gizmos.lights.viewer)


def _change_material(gizmos: Gizmos, change: Callable[[Material], Material]) -> None:
    """Change the material of the mesh under the cursor, or of all meshes where there is none, and say what it is."""
    pointed = gizmos.surfaces.mesh(gizmos.cursor)
    materials = list(gizmos.lit.state) if pointed is None else [pointed.shared_material]
    for shared in materials:
        shared.material = change(shared.material)
    if not materials:
        gizmos.notice = "no lit mesh"
        return
    now = materials[-1].material
    specular = "by its map" if "specular" in now.maps else f"{max(rgb(now.specular)):.3g}"
    shininess = "by its map" if "shininess" in now.maps else f"{now.shininess:.4g}"
    said = name_of(now) or f"specular {specular}, shininess {shininess}"
    gizmos.notice = f"{'material' if len(materials) == 1 else 'all meshes'}: {said}"


def help_entries(more: Keys) -> list[tuple[str, str]]:
    """All keys as people call them, and what they do."""
    ours = [(" ".join(_SHORT.get(key, key) for key in command.keys.split()), command.what) for command in COMMANDS]
    return [*ours, *_TYPING.items(), *((key, what) for key, (what, _) in more.items()), *_MOUSE.items()]


def check_keys(keys: Keys) -> Keys:
    """Raise ValueError for a key that has a meaning already, or has none."""
    if not isinstance(keys, Mapping):
        check.refuse("keys", keys, "a mapping: key → (what the help says, function without arguments)")
    for key, entry in keys.items():
        if not isinstance(entry, tuple) or len(entry) != 2:
            check.refuse(f"keys[{key!r}]", entry, "what the help says, and a function without arguments")
        what, action = entry
        if check.text("keys", key) in TAKEN | OURS:
            check.refuse("keys", key, "keys that are free", "x, d, 4 and 9 are, for example.")
        check.text(f"keys[{key!r}][0]", what)
        if not callable(action):
            check.refuse(f"keys[{key!r}][1]", action, "a function without arguments")
    return keys
