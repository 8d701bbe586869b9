"""Which vertices are left open: those whose colour float32 decides, and no others."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pvphong.optics.lights import DirectionalLight, PointLight, SpotLight
from pvphong.optics.material import Material
from pvphong.scene.viewer import Viewer
from pvphong.shading.equation import vtk_tier
from pvphong.vtk.rounding import Pose, limits
from pvphong.vtk.scenes import Terms

SHINY = Material(ambient=0.1, diffuse=0.5, specular=0.5, shininess=4.0)
EYE = Viewer(position=(3.0, 2.0, 4.0))
SUN = DirectionalLight(direction=(0.0, 0.0, -1.0))
TOLERANCE = 16.0 * 4.0 * 2.0**-24 + 1e-6


def found(
    points: Any, normals: Any, lights: list[Any], *, material: Material = SHINY, viewer: Viewer = EYE, **options: Any
) -> dict[str, list[int]]:
    """Reason → open vertices."""
    normals = np.array(normals, dtype=np.float64)
    pose = Pose(
        points=np.array(points, dtype=np.float64),
        normals=normals / np.linalg.norm(normals, axis=1)[:, None],
        matrix=options.pop("matrix", np.eye(4)),
    )
    terms = Terms(tuple(lights), material, viewer, vtk_tier(lights), ())
    known = limits(pose, terms, options.pop("tolerance", TOLERANCE), has_floors=options.pop("has_floors", True))
    return {reason: np.flatnonzero(mask).tolist() for reason, mask in known.open.items() if mask.any()}


def ring(count: int = 24) -> np.ndarray:
    """Unit vectors around the y axis, the first along z."""
    angle = 2.0 * np.pi * np.arange(count) / count
    return np.stack([np.sin(angle), np.zeros(count), np.cos(angle)], axis=1)


def test_an_ordinary_scene_leaves_nothing_open():
    rng = np.random.default_rng(3)
    lights = [SUN, PointLight(position=(2.0, -1.0, 3.0)), SpotLight(position=(0.0, 0.0, 4.0), cone_angle=20.0)]
    assert found(rng.uniform(-1.0, 1.0, (5000, 3)), rng.normal(size=(5000, 3)), lights) == {}


def test_a_grazing_light_leaves_open_where_a_highlight_begins():
    viewer = Viewer(position=(0.0, 0.0, -5.0))  # sees the light mirrored where it grazes
    normals = [[1.0, 0.0, 0.0], [1.0, 0.0, 1e-8], [1.0, 0.0, -1e-8], [1.0, 0.0, 1e-5], [1.0, 0.0, -1e-5]]
    points = np.zeros((5, 3))
    assert found(points, normals, [SUN], viewer=viewer) == {"n·l = 0": [0, 1, 2]}
    matte = replace(SHINY, specular=0.0)  # nothing begins there at once
    assert found(points, normals, [SUN], viewer=viewer, material=matte) == {}
    assert found(points, normals, [SUN], viewer=Viewer(position=(0.0, 5.0, 5.0))) == {}  # no highlight there


def test_the_edge_of_a_cone_is_left_open():
    spot = SpotLight(position=(0.0, 0.0, 1.0), cone_angle=30.0, exponent=2.0)
    radius = math.tan(math.radians(30.0)) * (1.0 + np.array([0.0, 1e-6, -1e-6, 1e-5, -1e-5, -0.5]))
    points = np.stack([radius, np.zeros(6), np.zeros(6)], axis=1)
    up = np.tile([0.0, 0.0, 1.0], (6, 1))
    assert found(points, up, [spot]) == {"edge of a cone": [0, 1, 2]}
    assert found(points, -up, [spot], material=replace(SHINY, specular=0.0)) == {}  # dark on both sides of it
    assert found(points, up, [replace(spot, on=False), SUN]) == {}


def test_floors_are_left_open_only_against_what_has_none():
    flat = replace(SHINY, shininess=0.1)
    normals = ring(360)[:90]
    with_floors = found(np.zeros((90, 3)), normals, [SUN], material=flat, tolerance=1e-4)
    assert with_floors == {}
    without = found(np.zeros((90, 3)), normals, [SUN], material=flat, tolerance=1e-4, has_floors=False)
    mirrored = 2.0 * normals[:, 2:] * normals - [0.0, 0.0, 1.0]
    cosines = mirrored @ np.array(EYE.position) / np.linalg.norm(EYE.position)
    assert without == {"VTK's floor": np.flatnonzero(cosines < 0.0).tolist()}
    sharp = found(np.zeros((90, 3)), normals, [SUN], has_floors=False)  # 1e-5 to the fourth is nothing
    assert sharp == {}


def test_vtks_first_tier_has_a_floor_of_its_own():
    headlight, normals = DirectionalLight(frame="headlight"), np.vstack([ring(36), (1.0, 0.0, 1e-4)])
    known = found(
        *(np.zeros((37, 3)), normals, [headlight]), material=replace(SHINY, shininess=0.1),
        viewer=Viewer(position=(0.0, 0.0, 5.0)), tolerance=1e-4, has_floors=False,
    )  # fmt: skip
    assert known == {"VTK's floor": np.flatnonzero(normals[:, 2] < 1e-6).tolist()}


def test_steep_powers_of_small_cosines_are_left_open():
    """At power 0.1, a step of 6e-8 in a cosine of 1e-3 shows as 3e-6."""
    flat = replace(SHINY, shininess=0.1)
    normals = ring(36000)[:9000]
    (reason, rows), *rest = found(np.zeros((9000, 3)), normals, [SUN], material=flat, tolerance=1e-6).items()
    assert (reason, rest) == ("float32", [])
    mirrored = 2.0 * normals[:, 2:] * normals - [0.0, 0.0, 1.0]
    cosines = mirrored @ np.array(EYE.position) / np.linalg.norm(EYE.position)
    assert cosines[rows].max() < 0.5
    assert set(np.flatnonzero((cosines > 1e-4) & (cosines < 1e-3))) <= set(rows)


def test_a_near_light_under_a_far_eye_is_left_open():
    light = PointLight(position=(0.0, 0.0, 1e-3))
    points, up = [[0.0, 0.0, 0.0], [0.9, 0.0, 0.0]], [[0.0, 0.0, 1.0]] * 2
    assert found(points, up, [light], viewer=Viewer(position=(0.0, 30.0, 30.0))) == {"float32": [0]}
    assert found(points, up, [light], viewer=Viewer(position=(0.0, 3e-3, 3e-3))) == {}


def test_a_strongly_sheared_normal_is_left_open():
    shear = np.eye(4)
    shear[0, 1] = 1e4
    normals = [[1.0, 0.0, 0.0], [1e-4, 1.0, 0.0]]  # the second is left with 1e-4 of its components
    points = np.zeros((2, 3))
    assert found(points, normals, [SUN, replace(SUN, direction=(1.0, 2.0, 0.0))], matrix=shear) == {"float32": [1]}


@pytest.mark.parametrize("far", [1e19, 1e25])
def test_what_float32_cannot_measure_is_left_open(far):
    light = PointLight(position=(0.0, 0.0, far))
    assert found([[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]], [light]) == {"float32": [0]}


def test_on_the_light_and_on_the_eye_is_left_open():
    points = [[0.0, 0.0, 0.5], [0.0, 0.0, 1.0], [0.2, 0.0, 0.0]]
    light, viewer = PointLight(position=(0.0, 0.0, 0.5)), Viewer(position=(0.0, 0.0, 1.0))
    assert found(points, [[0.1, 0.0, 1.0]] * 3, [light], viewer=viewer) == {"float32": [0, 1]}


def test_bright_light_is_allowed_errors_in_proportion():
    def scale(intensity: float) -> float:
        pose = Pose(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.eye(4))
        terms = Terms((replace(SUN, intensity=intensity),), SHINY, EYE, 2, ())
        return float(limits(pose, terms, TOLERANCE, has_floors=True).scale[0])

    assert scale(0.5) == 1.0
    assert scale(100.0) == pytest.approx(100.0 * (0.5 + 0.5) + 0.1)


def test_without_light_there_is_nothing_to_doubt():
    assert found([[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]], []) == {}
    assert found([[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]], [replace(SUN, on=False)]) == {}
