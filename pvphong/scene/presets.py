"""Ready-made lights: photographers' set-ups around a mesh, and the lights of the default scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from pvphong.base import check
from pvphong.base.types import Float64Array
from pvphong.base.vectors import unit_vector
from pvphong.optics.lights import DirectionalLight, EnvironmentLight, Light, PointLight, RectangleLight
from pvphong.scene.sun_by_date import SunByDate, Up
from pvphong.scene.viewer import Viewer

_AWAY = 1.0
"""Distance of the lights from the centre, in diagonals of the mesh's bounds."""
_FOR_PICTURES = 1.0 / 900.0
"""Scale of lights in W/m² for colours from 0 to 1."""
_NEARLY_ALONG_UP = 0.2  # sine of the angle between the view axis and `up`


class Surroundings:
    """Directions and lights around a mesh, by angles relative to the viewer.

    Parameters
    ----------
    mesh : pyvista.DataSet, pyvista.MultiBlock, or sequence of float
        The mesh, or its bounds (x_min, x_max, y_min, y_max, z_min, z_max).
    viewer : Viewer or None
        The viewer; None for PyVista's default view of the mesh.
    """

    def __init__(self, mesh: Any, viewer: Viewer | None) -> None:
        self.bounds = bounds = np.array(check.numbers_in("bounds", getattr(mesh, "bounds", mesh), 6))
        self.viewer = viewer or Viewer.framing(bounds.tolist())
        if not isinstance(self.viewer, Viewer):
            check.refuse("viewer", viewer, "a Viewer", "Convert a camera with Viewer.from_camera.")
        self.center = 0.5 * (bounds[::2] + bounds[1::2])
        self.size = float(np.linalg.norm(bounds[1::2] - bounds[::2]))
        """Length of the diagonal of the bounds."""
        if not (bounds[::2] <= bounds[1::2]).all() or not self.size > 0.0:
            check.refuse("bounds", bounds.tolist(), "the bounds of a mesh with at least two different points")

    def towards(self, azimuth: float, elevation: float) -> Float64Array:
        """Return a unit vector from the centre of the mesh, by its angles to the direction to the viewer.

        `azimuth` is the angle to the right as seen by the viewer, `elevation` the angle above the view axis, both in
        degrees.
        """
        across, above = math.radians(azimuth), math.radians(elevation)
        in_eye_space = math.sin(across) * math.cos(above), math.sin(above), math.cos(across) * math.cos(above)
        return np.array(self.viewer.vector_to_world(in_eye_space))

    def above_horizon(self, azimuth: float, elevation: float) -> Float64Array:
        """Return a unit vector from the centre of the mesh, by its angles to the viewer and to the horizon.

        `azimuth` is the angle to the right as seen by the viewer, `elevation` the angle above the horizon, both in
        degrees. The horizon is perpendicular to the viewer's `up`. If the viewer looks nearly along `up`, the result is
        that of `towards`.
        """
        up = np.array(unit_vector(self.viewer.up))
        _, own_up, back = self.viewer.axes
        if np.linalg.norm(back - (back @ up) * up) < _NEARLY_ALONG_UP:
            up = own_up
        ahead = self.level(up)
        across, above = math.radians(azimuth), math.radians(elevation)
        sideways = math.sin(across) * np.cross(up, ahead) + math.cos(across) * ahead
        return np.asarray(math.cos(above) * sideways + math.sin(above) * up)

    def level(self, up: Float64Array) -> Float64Array:
        """Return the horizontal unit vector towards the viewer.

        Horizontal means perpendicular to the unit vector `up`.
        """
        _, own_up, back = self.viewer.axes
        along = back - (back @ up) * up
        if np.linalg.norm(along) < _NEARLY_ALONG_UP:  # the viewer looks along `up`
            along = -own_up + (own_up @ up) * up
        return np.array(unit_vector(along.tolist()))

    def softbox(
        self, name: str, azimuth: float, elevation: float, brightness: float, width: float, height: float
    ) -> Light:
        """Return a rectangle light that faces the centre of the mesh, at an azimuth and an elevation.

        Parameters
        ----------
        name : str
            Name of the light.
        azimuth, elevation : float
            Angle to the right as seen by the viewer, and angle above the horizon, in degrees.
        brightness : float
            Brightness of a white surface at the mesh's centre that faces the light, computed as if the light were
            small.
        width, height : float
            Size, in diagonals of the mesh's bounds.
        """
        away = _AWAY * self.size * self.above_horizon(azimuth, elevation)
        return RectangleLight(
            position=self.center + away,
            direction=-away,
            up=self.viewer.up,
            width=width * self.size,
            height=height * self.size,
            intensity=brightness * (_AWAY * self.size) ** 2,
            name=name,
        )


def three_point(mesh: Any, viewer: Viewer | None = None, *, ratio: float = 4.0) -> tuple[Light, ...]:
    """Return the key, fill and rim light of portrait photography, placed around a mesh.

    The key light is 45° to the left of the viewer and 30° above. The fill light is on the other side, lower and weaker.
    The rim light is behind the mesh and above, so that it shows the outline.

    Parameters
    ----------
    mesh : pyvista.DataSet, pyvista.MultiBlock, or sequence of float
        The mesh to be lit, or its bounds (x_min, x_max, y_min, y_max, z_min, z_max).
    viewer : Viewer, optional
        The viewer; by default, PyVista's default view of the mesh. The lights do not move with the viewer.
    ratio : float, default 4
        Intensity of the key light divided by that of the fill light, >= 1.

    Returns
    -------
    tuple of Light
        Point lights named "key", "fill" and "rim".

    Raises
    ------
    ValueError
        If the mesh is empty, or an argument is invalid.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> [light.name for light in ph.three_point(pv.Sphere())]
    ['key', 'fill', 'rim']
    """
    around, ratio = Surroundings(mesh, viewer), check.number("ratio", ratio, at_least=1.0)

    def light(name: str, azimuth: float, elevation: float, intensity: float) -> Light:
        away = _AWAY * around.size * around.towards(azimuth, elevation)
        return PointLight(position=around.center + away, intensity=intensity, name=name)

    return light("key", -45.0, 30.0, 0.9), light("fill", 50.0, 5.0, 0.9 / ratio), light("rim", 160.0, 50.0, 0.6)


def _product(mesh: Any, viewer: Viewer | None = None) -> tuple[Light, ...]:
    around = Surroundings(mesh, viewer)
    return (
        around.softbox("key", -45.0, 50.0, 0.7, 0.8, 0.6),
        around.softbox("fill", 60.0, 25.0, 0.2, 1.0, 0.7),
        around.softbox("rim", 165.0, 50.0, 0.45, 0.9, 0.2),
    )


def _two_softboxes(mesh: Any, viewer: Viewer | None = None) -> tuple[Light, ...]:
    around = Surroundings(mesh, viewer)
    return around.softbox("left", -50.0, 35.0, 0.55, 0.6, 0.9), around.softbox("right", 50.0, 35.0, 0.55, 0.6, 0.9)


def _rim(mesh: Any, viewer: Viewer | None = None) -> tuple[Light, ...]:
    around = Surroundings(mesh, viewer)
    return (
        around.softbox("left rim", -125.0, 35.0, 0.65, 0.2, 0.9),
        around.softbox("right rim", 125.0, 35.0, 0.65, 0.2, 0.9),
        around.softbox("fill", 0.0, 40.0, 0.08, 1.0, 0.6),
    )


def _sky(mesh: Any, viewer: Viewer | None = None) -> tuple[Light, ...]:
    around = Surroundings(mesh, viewer)
    sun = DirectionalLight(
        direction=-around.above_horizon(-50.0, 40.0), diffuse=(1.0, 0.92, 0.8), intensity=0.6, name="sun"
    )
    return sun, EnvironmentLight(image=_SKY, up=around.viewer.up, intensity=0.5, name="sky")


def _sun(
    mesh: Any,
    viewer: Viewer | None = None,
    *,
    latitude: float = 48.14,
    longitude: float = 11.58,
    day: int = 172,
    hour: float = 10.0,
    up: Up | None = None,
    scale: float = _FOR_PICTURES,
) -> tuple[Light, ...]:
    around = Surroundings(mesh, viewer)
    at = SunByDate(latitude, longitude, day, hour, up or up_of(around.viewer))
    return at.lights(check.number("scale", scale, above=0.0))


def up_of(viewer: Viewer) -> Up:
    """Return the axis of a mesh, y or z, that is nearer to a viewer's `up`."""
    _, y, z = viewer.up
    return "y" if abs(y) > abs(z) else "z"


_ZENITH, _HORIZON, _GROUND = (0.45, 0.62, 0.95), (0.95, 0.97, 1.0), (0.3, 0.27, 0.23)
_SKY = np.array([[np.add(np.multiply(t, _ZENITH), np.multiply(1.0 - t, _HORIZON))] * 2 for t in np.linspace(1, 0, 8)])
_SKY = np.concatenate([_SKY, np.broadcast_to(_GROUND, (8, 2, 3))]).astype(np.float32)
"""A clear sky over brown ground, from the zenith down."""


class Setups(Mapping[str, Callable[..., tuple[Light, ...]]]):
    """Set-ups of lights, as a mapping from names to functions.

    Each function takes a mesh, or its bounds, and optionally a viewer. It returns the lights.

    - "three-point": key, fill and rim light without a size; see `three_point`.
    - "product": a large softbox above, a weak one opposite, and a narrow one behind the mesh.
    - "two softboxes": equal softboxes on both sides, for surfaces without harsh shadows.
    - "rim": narrow softboxes behind the mesh, for outlines and glass.
    - "sky": a low sun, and a blue sky over brown ground.
    - "sun": the sun and the clear sky of a place, a day and an hour; needs the extra `sun`. Options: `latitude` and
      `longitude` in degrees (default: Munich); `day` of the year (172, 21 June); `hour` (10), in the zone of the
      longitude without daylight saving time; `up`, the mesh's axis "z" or "y" (default: that of the viewer), with north
      along +y or -z; and `scale` (1/900), 1 for lights in W/m². It raises ``ValueError`` at night.

    The viewer defaults to PyVista's default view of the mesh. The lights do not move with the viewer.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> mesh = pv.Sphere()
    >>> [light.name for light in ph.setups["product"](mesh)]
    ['key', 'fill', 'rim']
    >>> evening = ph.Scene(ph.setups["sun"](mesh, hour=18), light_model=ph.LightModel(shadows=True))
    """

    def __getitem__(self, name: str) -> Callable[..., tuple[Light, ...]]:
        return _SETUPS[check.choice("name", name, _SETUPS)]

    def __contains__(self, name: object) -> bool:
        return name in _SETUPS

    def __iter__(self) -> Iterator[str]:
        return iter(_SETUPS)

    def __len__(self) -> int:
        return len(_SETUPS)

    def __repr__(self) -> str:
        return f"<set-ups of lights: {', '.join(self)}>"


_SETUPS: Mapping[str, Callable[..., tuple[Light, ...]]] = {
    "three-point": three_point,
    "product": _product,
    "two softboxes": _two_softboxes,
    "rim": _rim,
    "sky": _sky,
    "sun": _sun,
}

setups = Setups()


def key_fill_rim() -> tuple[Light, ...]:
    """Return three lights that move with the camera and suit any mesh: the lights of the default scene.

    Returns
    -------
    tuple of Light
        "key" is warm, from the upper left. "fill" is weaker and cool, from the right, and lights all surfaces that face
        the viewer. "rim" comes from behind.
    """
    return (
        DirectionalLight(direction=(1.0, -1.0, -1.4), diffuse=(0.95, 0.93, 0.9), frame="camera", name="key"),
        DirectionalLight(direction=(-0.5, 0.1, -1.0), diffuse=(0.36, 0.4, 0.46), frame="camera", name="fill"),
        DirectionalLight(direction=(-0.4, -1.0, 0.9), diffuse=(0.35, 0.35, 0.35), frame="camera", name="rim"),
    )
