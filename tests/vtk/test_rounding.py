"""Vertices that are left open: exactly those whose colour float32 decides."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pvphong import PBR, DirectionalLight, Material, PointLight, SpotLight, Viewer
from pvphong.shading.equation import vtk_tier
from pvphong.vtk.rounding import Pose, limits
from pvphong.vtk.scenes import Terms

SHINY = Material(ambient=0.1, diffuse=0.5, specular=0.5, shininess=4.0)
MATTE, FLAT = replace(SHINY, specular=0.0), replace(SHINY, shininess=0.1)
EYE = Viewer(position=(3.0, 2.0, 4.0))
SUN = DirectionalLight(direction=(0.0, 0.0, -1.0))
HEADLIGHT = DirectionalLight(frame="headlight")
SPOT = SpotLight(position=(0.0, 0.0, 1.0), cone_angle=30.0, exponent=2.0)
NEAR = PointLight(position=(0.0, 0.0, 1e-3))
ORIGIN, UP = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
TOLERANCE = 16.0 * 4.0 * 2.0**-24 + 1e-6


def found(points, normals, lights, *, material=SHINY, eye=EYE.position, tolerance=TOLERANCE, matrix=None, floors=True):
    """Return open vertices by reason; points and normals are broadcast."""
    points, normals = np.broadcast_arrays(np.atleast_2d(points).astype(float), np.atleast_2d(normals))
    normals = normals / np.linalg.norm(normals, axis=1)[:, None]
    terms = Terms(tuple(lights), material, Viewer(position=eye), vtk_tier(lights), ())
    pose = Pose(points, normals, np.eye(4) if matrix is None else matrix)
    known = limits(pose, terms, tolerance, has_floors=floors)
    return {reason: np.flatnonzero(mask).tolist() for reason, mask in known.open.items() if mask.any()}


def turned(count, part):
    """Return unit normals in the xz plane, a part of a circle that starts at z."""
    angle = 2.0 * np.pi * np.arange(int(count * part)) / count
    return np.stack([np.sin(angle), np.zeros(len(angle)), np.cos(angle)], axis=1)


def mirrored(normals):
    """Return cosines between the eye and the mirrored sun, at the origin."""
    return (2.0 * normals[:, 2:] * normals - UP) @ np.array(EYE.position) / np.linalg.norm(EYE.position)


GRAZING = [[1.0, 0.0, tilt] for tilt in (0.0, 1e-8, -1e-8, 1e-5, -1e-5)]
AGAINST = (0.0, 0.0, -5.0)  # sees the mirrored light at grazing angles
RIM = math.tan(math.radians(30.0)) * (1.0 + np.array([0.0, 1e-6, -1e-6, 1e-5, -1e-5, -0.5]))
RIM = np.stack([RIM, np.zeros(6), np.zeros(6)], axis=1)
SHEAR = np.eye(4) + np.diag([1e4, 0.0, 0.0], 1)
AROUND, PASSED = turned(360, 0.25), np.vstack([turned(36, 1), (1.0, 0.0, 1e-4)])
CASES = {
    "a grazing light": (ORIGIN, GRAZING, [SUN], {"eye": AGAINST}, {"n·l = 0": [0, 1, 2]}),
    "where nothing begins at once": (ORIGIN, GRAZING, [SUN], {"eye": AGAINST, "material": MATTE}, {}),
    "where there is no highlight": (ORIGIN, GRAZING, [SUN], {"eye": (0.0, 5.0, 5.0)}, {}),
    "the edge of a cone": (RIM, UP, [SPOT], {}, {"edge of a cone": [0, 1, 2]}),
    "dark on both sides of it": (RIM, (0.0, 0.0, -1.0), [SPOT], {"material": MATTE}, {}),
    "a spot that is off": (RIM, UP, [replace(SPOT, on=False), SUN], {}, {}),
    "floors in both": (ORIGIN, AROUND, [SUN], {"material": FLAT, "tolerance": 1e-4}, {}),
    "floors in one": (ORIGIN, AROUND, [SUN], {"material": FLAT, "tolerance": 1e-4, "floors": False},
                      {"VTK's floor": np.flatnonzero(mirrored(AROUND) < 0.0).tolist()}),
    "floors that powers hide": (ORIGIN, AROUND, [SUN], {"floors": False}, {}),
    "the first tier's floor": (
        ORIGIN, PASSED, [HEADLIGHT],
        {"material": FLAT, "tolerance": 1e-4, "floors": False, "eye": (0.0, 0.0, 5.0)},
        {"VTK's floor": np.flatnonzero(PASSED[:, 2] < 1e-6).tolist()}),
    "a near light under a far eye": ([[0.0, 0, 0], [0.9, 0, 0]], UP, [NEAR], {"eye": (0.0, 30.0, 30.0)},
                                     {"float32": [0]}),
    "a near light under a near eye": ([[0.0, 0, 0], [0.9, 0, 0]], UP, [NEAR], {"eye": (0.0, 3e-3, 3e-3)}, {}),
    "the light's place errs as the vertex's does": (ORIGIN, UP, [NEAR], {"eye": (0.0, 0.04, 0.04)}, {"float32": [0]}),
    "a near light that weakens": (ORIGIN, UP, [replace(NEAR, attenuation=(0.0, 0.0, 1.0))],
                                  {"eye": (0.0, 0.015, 0.015), "material": MATTE}, {"float32": [0]}),
    "a headlight seen in a mirror": ([5.0, 0, 0], (-2.0, 2.0, 4.0), [HEADLIGHT],
                                     {"material": replace(MATTE, reflectance=PBR(0.0, 0.1).of(MATTE))},
                                     {"float32": [0]}),
    # The shear cancels the second normal to 1e-4 of its components.
    "a strong shear": (ORIGIN, [[1.0, 0, 0], [1e-4, 1, 0]], [SUN, replace(SUN, direction=(1.0, 2.0, 0.0))],
                       {"matrix": SHEAR}, {"float32": [1]}),
    "a far light": (ORIGIN, UP, [PointLight(position=(0.0, 0.0, 1e19))], {}, {"float32": [0]}),
    "one still farther": (ORIGIN, UP, [PointLight(position=(0.0, 0.0, 1e25))], {}, {"float32": [0]}),
    "on the light and on the eye": ([[0, 0, 0.5], [0, 0, 1], [0.2, 0, 0]], (0.1, 0, 1),
                                    [PointLight(position=(0.0, 0.0, 0.5))], {"eye": UP}, {"float32": [0, 1]}),
    "no light": (ORIGIN, UP, [], {}, {}),
    "lights that are off": (ORIGIN, UP, [replace(SUN, on=False)], {}, {}),
}  # fmt: skip


@pytest.mark.parametrize(("points", "normals", "lights", "options", "expected"), CASES.values(), ids=CASES)
def test_what_float32_decides_is_left_open_and_nothing_else(points, normals, lights, options, expected):
    assert found(points, normals, lights, **options) == expected


def test_steep_powers_of_small_cosines_are_left_open():
    """At power 0.1, a step of 6e-8 in a cosine of 1e-3 changes the colour by 3e-6."""
    normals = turned(36000, 0.25)
    (reason, rows), *rest = found(ORIGIN, normals, [SUN], material=FLAT, tolerance=1e-6).items()
    assert (reason, rest) == ("float32", [])
    cosines = mirrored(normals)
    assert cosines[rows].max() < 0.5
    assert set(np.flatnonzero((cosines > 1e-4) & (cosines < 1e-3))) <= set(rows)


def test_bright_light_is_allowed_errors_in_proportion():
    for intensity, scale in ((0.5, 1.0), (100.0, 100.0 * (0.5 + 0.5) + 0.1)):
        terms = Terms((replace(SUN, intensity=intensity),), SHINY, EYE, 2, ())
        known = limits(Pose(np.zeros((1, 3)), np.array([UP]), np.eye(4)), terms, TOLERANCE, has_floors=True)
        assert known.scale[0] == pytest.approx(scale)
