"""Fields of lights that vary in a fit, and their coordinates in the search.

Intensities and colours are the *linear* fields: the colours of a mesh are linear in them. All other fields that vary,
such as directions and positions, are *shapes*. A field's role (`pvphong.optics.roles`) gives its limits.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from pvphong.base import check
from pvphong.base.types import BoolArray, Float64Array, rgb
from pvphong.base.vectors import unit_vector
from pvphong.geometry.extent import Sphere
from pvphong.optics.light import Light
from pvphong.optics.lights.sized import across
from pvphong.optics.roles import Aim, Angle, Direction, Length, Place, Power, Role, Turn
from pvphong.scene.scene import Scene, light_labels

_COLORS = "diffuse", "specular", "ambient"
_BLACK, _WHITE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)


class Unit(NamedTuple):
    """A light that gives the colours for one unit of an unknown. The three channels of a colour have one such light."""

    light: Light
    """The light at intensity 1. If colours vary, one of them is white and the others are black."""
    field: str
    """Name of the field of the unknown."""


@dataclass(frozen=True)
class Variation:
    """One light of a scene, and its fields that vary.

    `index` is its place in the scene, `label` its name in the report.
    """

    index: int
    label: str
    light: Light
    linear: tuple[str, ...]
    """Names of the linear fields that vary."""
    charts: dict[str, Chart]
    """Field of a shape that varies → its coordinates."""

    @cached_property
    def colors(self) -> tuple[str, ...]:
        """Names of the colours that vary."""
        return tuple(field for field in _COLORS if field in self.linear)

    @property
    def unknowns(self) -> list[str]:
        """Names of the linear unknowns, in order: "intensity", or a colour once for each of its channels."""
        if self.colors:
            return [color for color in self.colors for _ in range(3)]
        return list(self.linear)

    @property
    def count(self) -> int:
        """Number of coordinates of all shapes."""
        return sum(chart.count for chart in self.charts.values())

    def units(self, light: Light) -> list[Unit]:
        """Return, for each intensity or colour that varies, the light that gives its colours per unit.

        `light` is this light with other shapes.
        """
        if not self.colors:
            return [Unit(replace(light, intensity=1.0), "intensity")] if self.linear else []
        dark: dict[str, Any] = {"diffuse": _BLACK, "specular": _BLACK, "ambient": _BLACK, "intensity": 1.0}
        units = []
        for color in self.colors:
            fields = dark | {color: _WHITE}
            if color == "diffuse" and light.specular is None and "specular" not in self.colors:
                fields["specular"] = None  # highlights follow the diffuse colour
            units.append(Unit(replace(light, **fields), color))
        return units

    def rest(self, light: Light) -> Light | None:
        """Return the part of `light` that no unknown scales, such as fixed colours; None if there is none."""
        if not self.linear:
            return light
        if not self.colors:
            return None
        fields: dict[str, Any] = dict.fromkeys(self.colors, _BLACK)
        if "specular" not in fields and light.specular is None and "diffuse" in fields:
            fields["specular"] = _BLACK
        rest = replace(light, **fields)
        is_black = not any((*rgb(rest.diffuse), *rest.specular_color, *rgb(rest.ambient))) or not rest.intensity
        return None if is_black else rest

    @property
    def values(self) -> Float64Array:
        """Values of the linear unknowns of the light as it was given."""
        if not self.colors:
            return np.array([self.light.intensity] * len(self.linear))
        given = [self.light.specular_color if c == "specular" else rgb(getattr(self.light, c)) for c in self.colors]
        return self.light.intensity * np.ravel(given)

    def solved(self, light: Light, values: Float64Array, is_known: BoolArray) -> Light:
        """Return `light` with the intensity and colours that the unknowns' `values` give.

        If both intensity and colours vary, only their products are known; the largest channel of the colours is then
        kept. `is_known` is False for channels that the surface does not reflect. Such channels keep their ratio to the
        others.
        """
        if not self.linear:
            return light
        if not self.colors:
            return replace(light, intensity=float(values[0]))
        given, total = self.values, float(self.values[is_known].sum())
        scale = float(values[is_known].sum()) / total if total else 1.0
        values = np.where(is_known, values, scale * given)
        intensity = light.intensity
        if "intensity" in self.linear:
            if not values.any():
                return replace(light, intensity=0.0)
            largest = given.max() / self.light.intensity if self.light.intensity else 0.0
            intensity = float(values.max()) / (largest or 1.0)
        shares = map(tuple, (values / intensity).reshape(-1, 3).tolist())
        fields: dict[str, Any] = dict(zip(self.colors, shares, strict=True))
        return replace(light, intensity=intensity, **fields)

    def moved(self, light: Light, coordinates: Float64Array) -> Light:
        """Return `light` with its shapes changed by `coordinates`, shape (count,). Coordinates of 0 change nothing."""
        fields, first = dict[str, Any](), 0
        for field, chart in self.charts.items():
            fields[field] = chart.move(getattr(light, field), coordinates[first : first + chart.count])
            first += chart.count
        return replace(light, **fields) if fields else light

    @property
    def steps(self) -> list[tuple[float, bool]]:
        """For each coordinate of the shapes: the step of finite differences, and True if colours jump as it changes."""
        jumps = any(isinstance(role, Angle) for role in self.light.roles.values())
        return [(_JUMP if jumps else _STEP, jumps)] * self.count

    def starts(self, around: Sphere, viewer: Any, count: int) -> Iterator[Light]:
        """Yield lights from which a search may start: the given light, then lights with other shapes.

        Parameters
        ----------
        around : Sphere
            Sphere around the points that count, in the world.
        viewer : Viewer
            The scene's viewer.
        count : int
            Number of directions to try.
        """
        yield self.light
        own = self.light.in_world(viewer)
        center, radius = np.array(around.center), around.radius
        roles = {field: self.light.roles[field] for field in self.charts}
        places = [field for field, role in roles.items() if isinstance(role, Place)]
        aims = [field for field, role in roles.items() if isinstance(role, Aim)]
        others = [
            [(field, value) for value in self.charts[field].samples(getattr(own, field))]
            for field in roles
            if field not in (*places, *aims)
        ]
        for direction in sphere_directions(count) if places or aims else [np.zeros(3)]:
            for distance in _DISTANCES if places else (0.0,):
                at = center - distance * radius * direction
                fields: dict[str, Any] = dict.fromkeys(places, tuple(at.tolist())) | dict.fromkeys(
                    aims, tuple(direction.tolist())
                )
                for chosen in itertools.product(*others):
                    world = replace(own, **fields, **dict(chosen))
                    there = world if self.light.frame == "world" else world.in_frame(self.light.frame, viewer)
                    yield replace(self.light, **{field: getattr(there, field) for field in roles})


# Distances of starts from the mesh's centre, in radii.
_DISTANCES = 1.15, 1.6, 2.5, 5.0
# Steps of finite differences, as coordinates. Where a cone's edge crosses vertices, colours jump: the step is then so
# long that the edge crosses many.
_STEP, _JUMP = 1e-6, 0.02
# Largest distance of a light, and largest and least size, in radii of the mesh.
_FARTHEST, _SIZES = 30.0, (1e-4, 100.0)


@dataclass(frozen=True)
class Chart:
    """Coordinates of one shape, such as a direction, relative to its value."""

    count: int
    """Number of coordinates."""
    move: Callable[[Any, Float64Array], Any]
    """Function of a value and coordinates. Returns the changed value within the field's limits; coordinates of 0 change
    nothing."""
    samples: Callable[[Any], list[Any]]
    """Function of a value; returns values from which a search may start."""
    units: Callable[[Any], tuple[float, ...]]
    """Function of a value. For each number that reports show, returns its change per unit of a coordinate."""

    def deviation(self, value: Any, variances: Float64Array) -> float | tuple[float, ...]:
        """Return the standard deviation of each number of `value`, in the field's unit.

        For a direction, return a single angle in degrees. `variances` are the variances of the coordinates.
        """
        if self.count == 2:
            return self.units(value)[0] * math.sqrt(variances.sum())
        found = tuple((np.array(self.units(value)) * np.sqrt(variances)).tolist())
        return found if self.count > 1 else found[0]


def _turned(value: Any, coordinates: Float64Array) -> tuple[float, float, float]:
    """Return the unit vector `value` turned by two angles in radians: the exponential map of the sphere."""
    angle = math.hypot(*coordinates)
    if angle == 0.0:
        return value
    axis = np.array(unit_vector(value))
    x, y, z = (math.cos(angle) * axis + math.sin(angle) / angle * (coordinates @ across(axis))).tolist()
    return x, y, z


def _chart(role: Role, around: Sphere, *, in_world: bool) -> Chart | None:
    """Return the coordinates of a field with the role `role`; None if such a field cannot vary.

    `around` is a sphere around the mesh. `in_world` is False for a light that is placed relative to the viewer.
    """
    center, radius = np.array(around.center), around.radius
    if isinstance(role, Direction):
        return Chart(2, _turned, lambda now: [now], lambda _: (math.degrees(1.0),))
    if isinstance(role, Place):

        def shifted(now: Any, by: Float64Array) -> Any:
            moved = np.array(now) + radius * by
            if in_world:  # a camera's axes and origin are others
                offset = moved - center
                moved = center + offset * min(1.0, _FARTHEST * radius / (float(np.linalg.norm(offset)) or 1.0))
            return tuple(moved.tolist()) if by.any() else now

        return Chart(3, shifted, lambda now: [now], lambda _: (radius,) * 3)
    if isinstance(role, Angle):
        least, most = max(role.least, 0.5), role.most

        def opened(now: float, by: Float64Array) -> float:
            return min(max(now + math.degrees(float(by[0])), least), most) if by.any() else now

        spread = [least + share * (most - least) for share in (0.1, 0.25, 0.5, 0.9)]
        return Chart(1, opened, lambda now: [now, *spread], lambda _: (math.degrees(1.0),))
    if isinstance(role, Length):

        def grown(now: float, by: Float64Array) -> float:
            low, high = (size * radius for size in _SIZES)
            return min(max(now * math.exp(float(by[0])), low), high) if by.any() else now

        return Chart(1, grown, lambda now: [now], lambda now: (now,))
    if isinstance(role, Turn):
        return Chart(
            1,
            lambda now, by: now + math.degrees(float(by[0])),
            lambda now: [now + turn for turn in range(0, 360, 30)],
            lambda _: (math.degrees(1.0),),
        )
    if isinstance(role, Power):
        return Chart(
            1,
            lambda now, by: max(math.expm1(math.log1p(now) + float(by[0])), 0.0) if by.any() else now,
            lambda now: [now],
            lambda now: (1.0 + now,),
        )
    return None


def sphere_directions(count: int) -> Float64Array:
    """Return unit vectors spread evenly over the sphere, shape (count, 3), on a spiral (Swinbank and Purser 2006)."""
    k = np.arange(count) + 0.5
    z, turn = 1.0 - 2.0 * k / count, k * math.pi * (1.0 + math.sqrt(5.0))
    across = np.sqrt(1.0 - z * z)
    return np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=1)


def variations(scene: Scene, vary: Any, around: Sphere) -> list[Variation]:
    """Return the lights that vary, in the order of the scene's lights.

    Parameters
    ----------
    scene : Scene
        The scene.
    vary : str or mapping
        Fields that vary in all lights that are on; or a mapping from a light's name or index to its fields.
    around : Sphere
        Sphere around the mesh, in the world: the scale of positions and sizes.

    Raises
    ------
    ValueError
        If no light varies, or a light does not exist, is off, or has no such field.
    """
    labels, lights = light_labels(scene), list(scene.lights)
    if not lights:
        check.refuse("scene", "a scene without lights", "a scene with a light to vary")
    if isinstance(vary, str | list | tuple):
        bare = next((word for word in _words("", vary) if word in labels), None)
        if bare is not None:
            remedy = f'Name the fields too, as in {{"{bare}": "intensity"}}.'
            check.refuse("vary", f"the light {bare!r} without fields", "lights with fields, or fields", remedy)
        vary = {label: vary for label, light in zip(labels, lights, strict=True) if light.on}
    allowed = 'a mapping of lights to fields, as in {"key": "intensity direction"}, or the fields of all lights'
    if not isinstance(vary, Mapping) or not vary:
        got = "no light" if isinstance(vary, Mapping) else repr(vary)
        check.refuse("vary", got, allowed, f"The lights are {', '.join(labels)}.")
    chosen: dict[int, Variation] = {}
    for key, given in vary.items():
        label = str(key)
        if label not in labels:
            named = check.meant(label, labels) or f"The lights are {', '.join(labels)}."
            check.refuse("vary", f"a light {label!r}", allowed, named)
        index = labels.index(label)
        chosen[index] = _variation(index, label, lights[index], _words(label, given), around)
    return [chosen[index] for index in sorted(chosen)]


def _words(label: str, given: Any) -> list[str]:
    """Return the names of fields in a text or a sequence of texts; `label` is the light's, or "" for all lights."""
    words = given.replace(",", " ").split() if isinstance(given, str) else given
    if not isinstance(words, Sequence) or not words or not all(isinstance(word, str) for word in words):
        check.refuse(f"vary[{label!r}]" if label else "vary", given, 'names of fields, as in "intensity direction"')
    return list(words)


def _variation(index: int, label: str, light: Light, words: list[str], around: Sphere) -> Variation:
    name = f"vary[{label!r}]"
    if not light.on:
        check.refuse(name, "a light that is off", "a light that is on", "Set on=True, or leave it out.")
    known = {
        field: chart
        for field, role in light.roles.items()
        if light.frame != "headlight" and (chart := _chart(role, around, in_world=light.frame == "world")) is not None
    }
    fields = ["intensity", *_COLORS, *known]
    for word in words:
        if word not in fields:
            kind = "A headlight" if light.frame == "headlight" else f"This {type(light).__name__}"
            remedy = f"{check.meant(word, fields)} {kind} can vary {', '.join(fields)}.".lstrip()
            check.refuse(name, repr(word), "fields of the light that can vary", remedy)
    linear = tuple(field for field in ("intensity", *_COLORS) if field in words)
    found = Variation(index, label, light, linear, {field: known[field] for field in known if field in words})
    if found.colors and "intensity" in linear and found.rest(replace(light, intensity=1.0)) is not None:
        fixed = [color for color in _COLORS if color not in found.colors and any(rgb(getattr(light, color) or 0.0))]
        remedy = f"Vary its {' and '.join(fixed)} too, or not its intensity."
        check.refuse(name, f"{' '.join(words)!r}", "the intensity with all colours, or without colours", remedy)
    if found.colors and "intensity" not in linear and not light.intensity:
        check.refuse(name, f"{' '.join(words)!r} of a light of intensity 0", "a light that shines", "Vary intensity.")
    return found
