"""Keyboard commands: their functions, and the table `COMMANDS` of all keys at the end.

To add a key, write a function as described at `Command.edits`, and add a row to the table. Add the same row to the
table of keys in the README. A test compares the two tables. Keys in `TAKEN` belong to PyVista or VTK; d, x and 4 belong
to `pvphong view`. The roles of a light's fields define which commands apply to it. A function gets `gizmos`, the gizmos
of the subplot. If it acts on a light, it also gets `gizmo`, the light's gizmo.
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
from pvphong.base.color import luminance
from pvphong.base.types import ColorLike, Vector, rgb
from pvphong.base.vectors import unit_vector
from pvphong.optics.light import Light
from pvphong.optics.lights import PointLight
from pvphong.optics.material import Material
from pvphong.optics.roles import Aim
from pvphong.studio.gizmos.gizmo import Gizmo, Gizmos, Keys, called
from pvphong.studio.gizmos.handles import comes_from_somewhere, fields
from pvphong.studio.gizmos.highlight import mirrored_to_eye
from pvphong.studio.gizmos.view import vector
from pvphong.studio.window_lights import free_name

# -- help, gizmos, selection, undo


def toggle_help(gizmos: Gizmos) -> None:
    """Show the list of all keys, or hide it if it is shown."""
    gizmos.shows_help = not gizmos.shows_help


def toggle_hidden(gizmos: Gizmos) -> None:
    """Hide all gizmos, or show them if they are hidden."""
    gizmos.is_hidden = not gizmos.is_hidden
    gizmos.notice = "gizmos hidden: g shows them" if gizmos.is_hidden else ""


def toggle_asking(gizmos: Gizmos) -> None:
    """Switch the meaning of a drag on a mesh: it asks for more or less light on a spot, or turns the view."""
    gizmos.asks, gizmos.spot, gizmos.followers = not gizmos.asks, None, None
    follow = "the selected light follows" if gizmos.selected else "all lights follow; n selects one"
    asking = f"ask: drag a spot of a mesh up for brighter, down for darker; wheel: its size; Esc: end. {follow}"
    gizmos.notice = asking if gizmos.asks else "drags turn the view"


def select_next(gizmos: Gizmos) -> None:
    """Select the next light. After the last light, select no light.

    Lights without handles are included, because keys act on them too.
    """
    ring = [None, *gizmos.all]
    chosen = ring[(ring.index(gizmos.selected) + 1) % len(ring)]
    gizmos.select(chosen)
    gizmos.notice = "" if chosen else "no light selected"


def undo_or_redo(gizmos: Gizmos, step: int) -> None:
    """Undo the last step if `step` is −1; redo the last undone step if it is 1."""
    if step < 0:
        gizmos.notice = "undone" if gizmos.history.undo() else "nothing to undo"
    else:
        gizmos.notice = "redone" if gizmos.history.redo() else "nothing to redo"


# -- changes of the selected light


def mute(_gizmos: Gizmos, gizmo: Gizmo) -> Light:
    """Return the gizmo's light, switched off if it is on, and on if it is off."""
    return replace(gizmo.light, on=not gizmo.light.on)


def toggle_shadows(gizmos: Gizmos, gizmo: Gizmo) -> Light:
    """Return the light, casting shadows if it casts none, and casting none if it does."""
    changed = replace(gizmo.light, casts_shadows=not gizmo.light.casts_shadows)
    later = "" if gizmos.lit.scene.light_model.shadows else "; shadows are off in the light model"
    gizmos.notice = f"{called(changed)}: casts {'' if changed.casts_shadows else 'no '}shadows{later}"
    return changed


def reset(_gizmos: Gizmos, gizmo: Gizmo) -> Light:
    """Return the gizmo's light as it was when it got its gizmo."""
    return gizmo.first


def to_camera(gizmos: Gizmos, gizmo: Gizmo) -> Light:
    """Return the gizmo's light, moved to the viewer and aimed along the view axis."""
    light, viewer = gizmo.light, gizmos.lights.viewer
    world = replace(light, frame="headlight").in_world(viewer)
    aim: Any = tuple(viewer.distance * part for part in viewer.view_direction)  # the focal point is its target
    aimed = replace(world, **dict.fromkeys(list(fields(world, Aim))[:1], aim))
    return aimed.in_frame(light.frame, viewer)


def highlight_here(gizmos: Gizmos, gizmo: Gizmo) -> Light | None:
    """Return the gizmo's light, moved so that its highlight is at the surface point under the cursor.

    If no lit mesh is under the cursor, or the highlight cannot be moved, show a notice and return None.
    """
    light, view = gizmo.light, gizmos.view
    if light.frame == "headlight" or not comes_from_somewhere(light):
        gizmos.notice = f"{called(light)}: its highlight cannot be moved"
        return None
    target = gizmos.surfaces.pick(gizmos.cursor)
    if target is None:
        gizmos.notice = "to place the highlight, point at a lit mesh"
        return None
    moved = mirrored_to_eye(gizmo.in_scene(view).light, view, gizmo.surface_highlight(view) or target, target)
    return moved.in_frame(light.frame, view.viewer)


def brighten(gizmos: Gizmos, gizmo: Gizmo, step: int) -> Light:
    """Return the gizmo's light, brighter by `step` thirds of a photographic stop. Three steps double the intensity."""
    light = gizmo.light
    intensity = on_scale(light.intensity, 3, step) if light.intensity else 0.0
    stops = f" = {math.log2(intensity):+.2g} stops" if intensity else "; press Enter to type one"
    gizmos.notice = f"{called(light)}: intensity {intensity:.4g}{stops}"
    return replace(light, intensity=intensity)


def on_scale(value: float, parts: int, step: int) -> float:
    """Return `value` moved by `step` steps on a logarithmic scale that has `parts` steps per factor of 2.

    If `value` is a power of 2^(1/parts), up to rounding, the result is computed from the exponent, so that rounding
    errors do not accumulate.
    """
    at = parts * math.log2(value)
    if abs(at - round(at)) < 1e-9:
        return float(2.0 ** ((round(at) + step) / parts))
    return float(value * 2.0 ** (step / parts))


_HUE_STEP = 15.0  # degrees
# A colour with a saturation below _GREY has no hue that could be turned. It gets a hue with the saturation _TINTED.
_GREY, _TINTED = 0.01, 0.4
# One step warmer multiplies red by this factor and divides blue by it.
_WARMER = 2.0**0.25


def hue_turned(color: ColorLike, degrees: float) -> Vector:
    """Return a colour with its hue turned by `degrees`, from red towards yellow and green. Value and saturation stay.

    Grey has no hue. It becomes light red, or for negative degrees a light violet.
    """
    hue, saturation, value = colorsys.rgb_to_hsv(*rgb(color))
    if saturation < _GREY:
        hue, saturation, degrees = 0.0, _TINTED, min(degrees, 0.0)
    return colorsys.hsv_to_rgb((hue + degrees / 360.0) % 1.0, saturation, value)


def warmed(color: ColorLike, steps: float) -> Vector:
    """Return a colour of the same luminance with more red and less blue. Negative `steps` do the reverse."""
    tinted = np.array(rgb(color)) * (_WARMER**steps, 1.0, _WARMER**-steps)
    return vector(tinted * (luminance(color) / luminance(tinted.tolist()))) if tinted.any() else rgb(color)


def turn_hue(gizmos: Gizmos, gizmo: Gizmo, step: int) -> Light:
    """Return the gizmo's light with the hues of its colours turned by `step` steps."""
    return _recolor(gizmos, gizmo, "hue", partial(hue_turned, degrees=_HUE_STEP * step))


def warm(gizmos: Gizmos, gizmo: Gizmo, step: int) -> Light:
    """Return the gizmo's light with colours that are warmer by `step` steps. Negative steps make them cooler."""
    return _recolor(gizmos, gizmo, "warmer" if step > 0 else "cooler", partial(warmed, steps=step))


def _recolor(gizmos: Gizmos, gizmo: Gizmo, what: str, change: Callable[[ColorLike], Vector]) -> Light:
    """Return the light with changed colours, and show the new colour in the window.

    Parameters
    ----------
    gizmos : Gizmos
        The gizmos of the subplot.
    gizmo : Gizmo
        The gizmo of the light.
    what : str
        Word for the change, such as "warmer".
    change : callable
        Function of a colour. It is applied to all colours of the light that are set and not black.
    """
    light = gizmo.light
    colors = {"diffuse": light.diffuse, "specular": light.specular, "ambient": light.ambient}
    given = {field: color for field, color in colors.items() if color is not None and any(rgb(color))}
    changes: dict[str, Any] = {field: change(color) for field, color in given.items()}
    changed = replace(light, **changes)
    red, green, blue = rgb(changed.diffuse)
    color = f"colour ({red:.3g}, {green:.3g}, {blue:.3g}), luminance {luminance(changed.diffuse):.3g}"
    gizmos.notice = f"{called(light)}: {what}, {color}"
    return changed


# -- adding and deleting lights

# As fractions of the scene's size: height of a new light above a surface, and distance of a duplicate from the
# original.
_ABOVE, _BESIDE = 0.4, 0.15


def add(gizmos: Gizmos) -> None:
    """Add a point light above the surface point under the cursor.

    Half of the light's intensity arrives at this point.
    """
    below = gizmos.surfaces.pick(gizmos.cursor)
    if below is None:
        gizmos.notice = "to add a light, point at a lit mesh"
        return
    height = _ABOVE * gizmos.scenery.size
    place = vector(np.array(below.point) + height * np.array(below.normal))
    _put(gizmos, PointLight(position=place, attenuation=(1.0, 0.0, height**-2), name="point"))


def duplicate(gizmos: Gizmos, gizmo: Gizmo) -> None:
    """Add a copy of the selected light, a little to its right, and select the copy.

    If the light has no position, the copy is turned instead, so that its light comes from further right.
    """
    light, viewer = gizmo.light, gizmos.lights.viewer
    if light.frame == "headlight" or not comes_from_somewhere(light):
        where = "headlight" if light.frame == "headlight" else "light from all around"
        gizmos.notice = f"{called(light)}: a {where} cannot be duplicated"
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
    """Delete the selected light; undo restores it."""
    gizmos.notice = f"deleted: {called(gizmo.light)}; press z to undo"
    gizmos.lights.remove(gizmo.renderer_light)


def solo(gizmos: Gizmos, gizmo: Gizmo) -> None:
    """Switch the gizmo's light on and all others off. If this is so already, switch all lights on."""
    chosen, viewer = gizmo.renderer_light, gizmos.lights.viewer
    others_on = gizmos.soloed is chosen
    for each in gizmos.lights.renderer_lights:
        each.set(replace(each.light(viewer), on=others_on or each is chosen), viewer)


# -- materials

_NAMED = {name: Material.named(name) for name in Material.names()}
_NAMED = {name: named for name, named in _NAMED.items() if named.reflectance is None or not named.reflectance.needs}
"""The named materials that need no tangents."""


def next_material(material: Material, step: int) -> Material:
    """Return the next named material in the table after `material`; with `step` −1, the previous named material.

    If `material` is not in the table, the result is the table's first material, or with `step` −1 its last. The result
    has the albedo and the tangents of `material`. It also has the reflectance of `material`, except in two cases: the
    new named material defines a reflectance, or the reflectance of `material` came from the table.
    """
    names, name = list(_NAMED), name_of(material)
    at = names.index(name) if name else min(-step, 0)
    chosen = replace(_NAMED[names[(at + step) % len(names)]], albedo=material.albedo, tangents=material.tangents)
    is_its_own = name and _NAMED[name].reflectance is not None
    return chosen if chosen.reflectance or is_its_own else replace(chosen, reflectance=material.reflectance)


def name_of(material: Material) -> str:
    """Return the name of a material in the table of named materials; "" if it is not in the table.

    Albedo and tangents are not compared. Reflectances are compared only with named materials that have one.
    """
    bare = replace(material, albedo=1.0, tangents=None)
    plain = replace(bare, reflectance=None)
    return next((name for name, named in _NAMED.items() if named in (bare, plain)), "")


def shine(material: Material, step: int) -> Material:
    """Return the material with its shininess multiplied by √2 to the power of `step`.

    Powers of √2 stay exact, and results below 1 become 0. If the shininess is a map, the material is returned
    unchanged.
    """
    if "shininess" in material.maps:
        return material
    shininess = on_scale(material.shininess or 0.5**0.5, 2, step)  # 0 is one step below 1
    return replace(material, shininess=shininess if shininess >= 1.0 else 0.0)


def strengthen(material: Material, step: int) -> Material:
    """Return the material with the largest channel of its specular reflectance changed by `step` tenths.

    The other channels keep their proportions. The largest channel stays between 0 and 1; if it exceeds 1 already, it
    does not grow. If the specular reflectance is a map, the material is returned unchanged.
    """
    if "specular" in material.maps:
        return material
    colors = rgb(material.specular)
    largest = max(colors)
    level = round(min(max(largest + 0.1 * step, 0.0), max(1.0, largest)), 10)
    return replace(material, specular=[level * c / largest for c in colors] if largest else level)


# -- the table


class Command(NamedTuple):
    """A command of the keyboard. It has one key, or several keys if `act` takes a step."""

    keys: str
    """Names of the keys in VTK, separated by spaces."""

    what: str
    """The text in the help."""

    act: Callable[..., Any]
    """The function that the keys run; its signature depends on `edits`."""

    edits: str = ""
    """The kind of object that the command changes, as one undo step.

    "light": `act` takes the gizmos and the selected gizmo, and returns the new light, or None if it has changed the
    gizmos instead. "lights": `act` takes the gizmos and changes their lights. "material": `act` takes a material and
    returns a new one, for the mesh under the cursor or else for all meshes. "": `act` takes the gizmos; no undo step.
    """

    steps: tuple[int, ...] = ()
    """For each of the keys, the step that is passed to `act`; empty if `act` takes none."""


_BACK_ON = (-1, 1)

COMMANDS = (
    Command("h", "these keys", toggle_help),
    Command("g", "hide or show the gizmos", toggle_hidden),
    Command("n", "select the next light", select_next),
    Command("space", "ask: drag a spot of a mesh brighter or darker", toggle_asking),
    Command("z y", "undo, redo", undo_or_redo, steps=_BACK_ON),
    Command("m", "light off or on", mute, "light"),
    Command("o", "solo: this light only, or all", solo, "light"),
    Command("X", "shadows of the light off or on", toggle_shadows, "light"),
    Command("k", "move the light to the camera", to_camera, "light"),
    Command("H", "put the highlight under the cursor", highlight_here, "light"),
    Command("0", "reset the light", reset, "light"),
    Command("Left Right", "dimmer, brighter by 1/3 stop", brighten, "light", _BACK_ON),
    Command("comma period", "turn the hue backwards, forwards", turn_hue, "light", _BACK_ON),
    Command("1 2", "cooler, warmer", warm, "light", _BACK_ON),
    Command("N", "new light under the cursor", add, "lights"),
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
    "Esc": "cancel the drag",
}
_NAMES = {" ": "space", ",": "comma", ".": "period"}
"""Character that a browser sends → VTK's name of its key."""
_SHORT = {"comma": ",", "period": ".", "Delete": "Del", "BackSpace": "Backspace"}

TAKEN = frozenset({*"qQeErRwWsSpPbBvVCcfFuUiI3lLjJtTaA+-", "Up", "Down", "plus", "minus"})
"""Keys that vtkInteractorStyle::OnChar, `Plotter.reset_key_events`, PyVista's picking and VTK's widgets use."""

_OF_KEYS = {
    key: (command, {"step": command.steps[at]} if command.steps else {})
    for command in COMMANDS
    for at, key in enumerate(command.keys.split())
}
ENTER = frozenset({"Return", "KP_Enter"})
"""Names in VTK of the keys that start the typing of a value, and that accept the typed value."""

OURS = frozenset({*_OF_KEYS, *ENTER})
"""All keys that gizmos use."""


def run(gizmos: Gizmos, key: str, *, control: bool = False) -> bool:
    """Run the command of a key. Return False if the key has no command.

    The command is one of pvphong or one of the user. `control` is True while the control key is down; then, only z and
    y have a command.
    """
    if control and key not in ("z", "y"):
        return False
    key = _NAMES.get(key, key)
    if key in _OF_KEYS:
        command, step = _OF_KEYS[key]
        act, edits = partial(command.act, **step), command.edits
        gizmos.notice = ""
        if not edits:
            act(gizmos)
            return True
        gizmos.history.settle()  # ends a slider's movement in the page
        with gizmos.history.edit(gizmos.lit if edits == "material" else gizmos.lights):
            if edits == "material":
                _change_material(gizmos, act)
            elif edits == "lights":
                act(gizmos)
            elif (gizmo := gizmos.selected) is None:
                gizmos.notice = "no light is selected: press n, or click a light"
            else:
                change_light(gizmos, gizmo, act)
        return True
    if key in gizmos.options.keys:
        gizmos.notice = gizmos.options.keys[key][1]() or ""
        return True
    return False


def change_light(gizmos: Gizmos, gizmo: Gizmo, act: Callable[[Gizmos, Gizmo], Light | None]) -> None:
    """Call `act` with the gizmos and the gizmo. If `act` returns a light, set the gizmo's light to it."""
    changed = act(gizmos, gizmo)
    if changed is not None:
        gizmo.renderer_light.set(changed, gizmos.lights.viewer)


def _change_material(gizmos: Gizmos, change: Callable[[Material], Material]) -> None:
    """Apply `change` to the material of the mesh under the cursor, or of all meshes if no mesh is there.

    Show the result.
    """
    pointed = gizmos.surfaces.mesh(gizmos.cursor)
    materials = list(gizmos.lit.state) if pointed is None else [pointed.shared_material]
    for shared in materials:
        shared.material = change(shared.material)
    if not materials:
        gizmos.notice = "no lit mesh"
        return
    now = materials[-1].material
    specular = "from a map" if "specular" in now.maps else f"{max(rgb(now.specular)):.3g}"
    shininess = "from a map" if "shininess" in now.maps else f"{now.shininess:.4g}"
    said = name_of(now) or f"specular {specular}, shininess {shininess}"
    gizmos.notice = f"{'material' if len(materials) == 1 else 'all meshes'}: {said}"


def help_entries(more: Keys) -> list[tuple[str, str]]:
    """Return a common name and a description for all keys and mouse actions; `more` are the user's keys."""
    ours = [(" ".join(_SHORT.get(key, key) for key in command.keys.split()), command.what) for command in COMMANDS]
    return [*ours, *_TYPING.items(), *((key, what) for key, (what, _) in more.items()), *_MOUSE.items()]


def check_keys(keys: Keys) -> Keys:
    """Check a user's keys, and return them.

    Raise ``ValueError`` if a key is already used, or an entry is not a pair of a text and a function.
    """
    if not isinstance(keys, Mapping):
        check.refuse("keys", keys, "a mapping of key → (help text, function without arguments)")
    for key, entry in keys.items():
        if not isinstance(entry, tuple) or len(entry) != 2:
            check.refuse(f"keys[{key!r}]", entry, "a tuple (help text, function without arguments)")
        what, action = entry
        if check.text("keys", key) in TAKEN | OURS:
            check.refuse("keys", key, "keys that are not used already", "For example, x, d, 4 and 9 are free.")
        check.text(f"keys[{key!r}][0]", what)
        if not callable(action):
            check.refuse(f"keys[{key!r}][1]", action, "a function without arguments")
    return keys
