"""Area and environment lights against Mitsuba 3: the colours of white patches under them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from pvphong import DiskLight, EnvironmentLight, LightModel, Material, RectangleLight, Scene, SphereLight, evaluate

mi = pytest.importorskip("mitsuba", reason="Mitsuba 3 is not installed (pip install mitsuba)")

COUNT, SEEDS, SAMPLES = 32, 32, 2048
# Allowed number of standard errors, and the largest relative standard error.
ERRORS, NOISE = 5.0, 0.01
# Repetitions of a texel: Mitsuba interpolates neighbouring texels, and its first and last rows are the poles.
FINENESS = 64

MIDDLE, FACING, UP = (0.4, 0.2, 1.5), (-0.2, -0.1, -1.0), (0.3, 1.0, 0.0)
COLOR = (1.0, 0.5, 0.25)
LIGHTS = [
    SphereLight(MIDDLE, 0.6, diffuse=COLOR),
    DiskLight(MIDDLE, FACING, 0.6, diffuse=COLOR),
    RectangleLight(MIDDLE, FACING, UP, 1.2, 0.7, diffuse=COLOR),
    EnvironmentLight(np.random.default_rng(2).uniform(0.0, 1.0, (4, 6, 3)), (1, 2, -2), 40.0),
]


def patches() -> tuple[Any, Any]:
    """Return positions below the lights, and normals roughly towards them."""
    rng = np.random.default_rng(7)
    normals = rng.normal(size=(COUNT, 3)) * 0.6 + (0.0, 0.0, 1.0)
    return rng.uniform((-1, -1, -1), (1, 1, 0.4), (COUNT, 3)), normals / np.linalg.norm(normals, axis=1)[:, None]


def look_at(place: Any, target: Any, up: Any) -> Any:
    """Return the transform from the frame of a Mitsuba shape, whose normal is z, to the world."""
    place, target, up = ([float(x) for x in vector] for vector in (place, target, up))
    return mi.ScalarTransform4f().look_at(origin=place, target=target, up=up)


def emitter(light: Any) -> dict[str, Any]:
    """Return a light's Mitsuba dictionary."""
    if isinstance(light, EnvironmentLight):
        return {"type": "envmap", "bitmap": mi.Bitmap(texels(light)), "to_world": around(light)}
    if isinstance(light, SphereLight):
        shape = {"type": "sphere", "center": list(light.position), "radius": light.radius}
        radiance = 1.0 / light.radius**2
    else:
        is_disk = isinstance(light, DiskLight)
        sides = (light.radius, light.radius) if is_disk else (light.width / 2.0, light.height / 2.0)
        radiance = math.pi / (math.prod(sides) * (math.pi if is_disk else 4.0))
        frame = look_at(light.position, np.add(light.position, light.direction), UP)
        shape = {"type": "disk" if is_disk else "rectangle"}
        shape["to_world"] = frame @ mi.ScalarTransform4f().scale([*sides, 1.0])
    glow = {"type": "rgb", "value": [radiance * x for x in light.diffuse]}
    return {**shape, "emitter": {"type": "area", "radiance": glow}}


def texels(light: EnvironmentLight) -> Any:
    return light.image.image.repeat(FINENESS, axis=0).repeat(FINENESS, axis=1).astype(np.float32)


def around(light: EnvironmentLight) -> Any:
    """Return the transform to the world from a frame with y up, z to the middle of the image, and x to its left."""
    up = np.array(light.up) / np.linalg.norm(light.up)
    ahead = np.array([1.0, 0.0, 0.0]) - up[0] * up
    ahead /= np.linalg.norm(ahead)
    turn = math.radians(light.rotation)
    ahead = math.cos(turn) * ahead + math.sin(turn) * np.cross(up, ahead)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([np.cross(up, ahead), up, ahead], axis=1)
    return mi.ScalarTransform4f(matrix)


def rendered(light: Any, points: Any, normals: Any) -> Any:
    """Render small white patches: colours of shape (seeds, n, 3)."""
    mi.set_variant("scalar_rgb")
    world: dict[str, Any] = {"type": "scene", "integrator": {"type": "direct"}, "light": emitter(light)}
    film = {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}, "component_format": "float32"}
    white = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 1.0}}
    for k, (p, n) in enumerate(zip(points, normals, strict=True)):
        up = np.cross(n, np.eye(3)[int(np.argmin(np.abs(n)))])
        frame = look_at(p, p + n, up) @ mi.ScalarTransform4f().scale(1e-4)
        world[f"patch{k}"] = {"type": "rectangle", "to_world": frame, "bsdf": white}
        eye = look_at(p + 1e-2 * n, p, up)
        world[f"eye{k}"] = {"type": "radiancemeter", "to_world": eye, "film": film}
    scene = mi.load_dict(world)
    return np.array(
        [
            [np.ravel(mi.render(scene, sensor=k, seed=COUNT * seed + k, spp=SAMPLES)) for k in range(len(points))]
            for seed in range(SEEDS)
        ]
    )


@pytest.mark.parametrize("light", LIGHTS, ids=lambda light: type(light).__name__)
def test_white_patches_have_the_colour_that_mitsuba_shows(light: Any) -> None:
    points, normals = patches()
    scene = Scene([light], light_model=LightModel(ambient=0.0, clamp=False))
    got = evaluate(points, normals, scene, Material(ambient=0.0, diffuse=1.0), precision="float64").rgb
    seen = rendered(light, points, normals)
    mean, error = seen.mean(axis=0), seen.std(axis=0, ddof=1) / math.sqrt(SEEDS)
    is_lit = got > 0.0
    assert is_lit.mean() > 0.75
    assert (error[is_lit] < NOISE * got[is_lit]).all()
    np.testing.assert_array_less(np.abs(got - mean), ERRORS * error + 1e-12)
