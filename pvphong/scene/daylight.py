"""The sun and the sky of one moment, as the lights of a scene."""

from __future__ import annotations

from typing import Any

from pvphong.base import check
from pvphong.optics.light import Light
from pvphong.optics.lights import DirectionalLight, EnvironmentLight
from pvphong.optics.sky import SkyModel
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene
from pvphong.scene.sun import Place, SunPosition, checked_place, clear_sky, extraterrestrial, moments, sun_position

ALBEDO = 0.2
"""Default albedo of the ground: grass, soil or old asphalt."""

_SUN_DIAMETER = 0.533  # degrees, at the mean distance


def sun_light(sun: SunPosition, direct_normal: float) -> DirectionalLight:
    """Return the sun at a position, the first of `sun`, as a light of the given intensity."""
    x, y, z = sun.direction[0].tolist()
    return DirectionalLight((-x, -y, -z), angle=_SUN_DIAMETER, intensity=direct_normal, name="sun")


def daylight_scene(
    time: Any,
    place: Place,
    *,
    direct_normal: float | None = None,
    diffuse_horizontal: float | None = None,
    model: SkyModel = "perez",
    albedo: float = ALBEDO,
    scale: float = 1.0,
) -> Scene:
    """Make the scene of one moment outdoors: the sun and the sky, in W/m².

    The lights are named "sun", 0.533° wide, and "sky". At night the sun is missing. Surfaces cast shadows. The
    colours that `shade` returns are irradiances times the material's reflectance, in W/m²: hundreds in daylight.
    Tolerances are in this unit too. So pass a `tolerance` to `shade`: the default is far too strict for such a scene,
    and takes long. For pictures, windows and the studio use a `scale` of about 1/400.

    Parameters
    ----------
    time : datetime_like
        One moment: a datetime or pandas.Timestamp with a time zone, a text in ISO 8601 with a UTC offset, or a NumPy
        datetime64, which is UTC.
    place : Place
        Place on the Earth, and the directions of its zenith and north in the mesh's coordinates.
    direct_normal : float, optional
        Irradiance by the sun on a surface that faces it, in W/m². If both irradiances are omitted, those of a clear sky
        are used (P. Ineichen, R. Perez 2002).
    diffuse_horizontal : float, optional
        Irradiance by the sky on an open horizontal surface, in W/m².
    model : {"perez", "overcast", "clear"}, default "perez"
        Distribution of the sky's radiance; `EnvironmentLight.sky` explains the three models.
    albedo : float, default 0.2
        Fraction of the light that the open ground around the mesh reflects.
    scale : float, default 1
        Factor of both lights: 1 for W/m², and about 1/400 for colours from 0 to 1.

    Returns
    -------
    Scene
        A scene for `shade`, `irradiance`, windows and the studio. It has no ambient light, does not clamp, and has no
        viewer.

    Raises
    ------
    ValueError
        If an argument is out of range, only one irradiance is given, or pvlib (the extra `sun`) is not installed.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> munich = ph.Place(48.14, 11.58)
    >>> scene = ph.daylight_scene("2026-06-21T10:00+02:00", munich, direct_normal=700, diffuse_horizontal=120)
    >>> [light.name for light in scene.lights]
    ['sun', 'sky']
    >>> lit = pv.Sphere().phong.irradiance(scene)  # W/m²
    """
    index, place = moments(time), checked_place(place)
    if len(index) != 1:
        check.refuse("time", f"{len(index)} times", "one time", "For many times use mesh.phong.daylight(times, place).")
    irradiances = {"direct_normal": direct_normal, "diffuse_horizontal": diffuse_horizontal}
    missing = [name for name, given in irradiances.items() if given is None]
    if len(missing) == 1:
        check.refuse(missing[0], "None", "given with the other irradiance", "Leave out both for a clear sky.")
    if missing:
        direct, diffuse = (float(each[0]) for each in clear_sky(index, place))
    else:
        direct, diffuse = (check.number(name, given, at_least=0.0) for name, given in irradiances.items())
    scale = check.number("scale", scale, above=0.0)
    sun = sun_position(index, place)
    x, y, z = sun.direction[0].tolist()
    lights: list[Light] = []
    if sun.altitude[0] > 0.0:
        lights.append(sun_light(sun, scale * direct))
    else:
        direct = 0.0
    of_sky: Any = {"direct_normal": direct, "diffuse_horizontal": diffuse, "model": model, "albedo": albedo}
    of_sky |= {"intensity": scale, "up": place.up, "name": "sky"}
    above = float(extraterrestrial(index)[0])
    lights.append(EnvironmentLight.sky((x, y, z), extraterrestrial=above, **of_sky))
    return Scene(lights, light_model=LightModel(ambient=0.0, shadows=True, clamp=False))
