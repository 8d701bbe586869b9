"""Random scenes of which the lights are known, and how far found lights are from them."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pyvista as pv

import pvphong as ph


def bumpy(subdivisions):
    """A ball with bumps."""
    ball = pv.Icosphere(nsub=subdivisions)
    x, y, z = ball.points.astype(float).T
    ball.points = ball.points * (1.0 + 0.15 * np.sin(5 * x) * np.cos(4 * y) + 0.1 * np.sin(7 * z))[:, None]
    return ball.compute_normals()


MATERIAL = ph.Material(ambient=0.1, diffuse=(0.4, 0.5, 0.3), specular=0.3, shininess=15)
VIEWER = ph.Viewer(position=(3, -4, 2))


def planted(seed, count):
    """Return a scene of random directional and point lights, and the same lights at standard places."""
    random = np.random.default_rng(seed)
    lights, begins = [], []
    for number in range(count):
        direction, common = random.normal(size=3), {"intensity": random.uniform(0.2, 1.0), "name": f"light {number}"}
        direction /= np.linalg.norm(direction)
        if random.random() < 0.5:
            lights.append(ph.DirectionalLight(direction=direction, **common))
            begins.append(replace(lights[-1], direction=(0, 0, -1), intensity=1.0))
        else:
            lights.append(ph.PointLight(position=direction * random.uniform(1.5, 5.0), **common))
            begins.append(replace(lights[-1], position=(0, 0, 4), intensity=1.0))
    return [ph.Scene(each, VIEWER) for each in (lights, begins)]


def moving(scene):
    """Fields that vary: the intensity, and the direction or the position."""
    return {
        light.name: "intensity " + ("direction" if hasattr(light, "direction") else "position")
        for light in scene.lights
    }


def apart(one, other):
    """Return how far two lights are: relative intensity, degrees, and parts of the mesh's size."""
    brightness = abs(one.intensity / other.intensity - 1.0)
    if hasattr(one, "direction"):
        a, b = (np.array(light.direction) / np.linalg.norm(light.direction) for light in (one, other))
        return brightness, math.degrees(2.0 * math.asin(min(1.0, np.linalg.norm(a - b) / 2.0))), 0.0
    return brightness, 0.0, float(np.linalg.norm(np.subtract(one.position, other.position))) / 2.0


def is_found(fit, scene):
    """True if each light was found, to 1e-6, 0.01° and 1e-4 of the size; lights of one kind may change places."""
    for order in itertools.permutations(fit.scene.lights):
        pairs = list(zip(order, scene.lights, strict=True))
        if all(type(a) is type(b) for a, b in pairs):
            off = [apart(a, b) for a, b in pairs]
            if all(x < 1e-6 and y < 0.01 and z < 1e-4 for x, y, z in off):
                return True
    return False
