"""Random tests ("hunts") and their scenes: colours from the whole range of floats, and scenes that a plan can simplify.

Each test tries a few scenes in every run, and 100,000 with `pytest -m long`. The 80-digit oracle checks a tenth as
many, because its arithmetic is much slower. Scenes are drawn with the dice of `strategies`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
import pyvista as pv
from stability.bounds import assert_bits
from stability.evaluators import BACKENDS, EVALUATORS
from strategies import MATRIX_CLASSES, Case, Dice, hard_case, matrix_of, moderate_case, rotation, triple, unit

from pvphong import DirectionalLight, LightModel, Material, PointLight, Scene, Shading, SpotLight, Viewer

FEW, MANY = 200, 100_000

FLATTENING_IS_NO_FAILURE = pytest.mark.filterwarnings("ignore::pvphong.geometry.transform.SingularMatrixWarning")
"""Turns NumPy's warnings about overflow, division by zero and invalid operations into errors."""

hunted = pytest.mark.parametrize(
    "examples", [pytest.param(FEW, id="few"), pytest.param(MANY, id="many", marks=pytest.mark.long)]
)
on_every_backend = pytest.mark.parametrize("backend", BACKENDS)
on_every_evaluator = pytest.mark.parametrize("evaluator", EVALUATORS, ids=str)


def arrays(shading: Shading) -> dict[str, np.ndarray]:
    found = {name: getattr(shading, name) for name in Shading.__dataclass_fields__}
    return {name: array for name, array in found.items() if array is not None}


def assert_same_bits(got: Shading, expected: Shading, rows: Any = slice(None), of_expected: Any = slice(None)) -> None:
    for name, array in arrays(expected).items():
        found, wanted = arrays(got)[name][..., rows, :], array[..., of_expected, :]
        assert found.shape == wanted.shape
        if wanted.size:  # a scene without lights has no shares
            assert_bits(name, found, wanted)


# --- the whole range of floats ---


def positive_of(dice: Dice) -> float:
    return 0.0 if dice.likely(8) else dice.wide()


def color_of(dice: Dice) -> Any:
    return positive_of(dice) if dice.likely(50) else tuple(positive_of(dice) for _ in range(3))


def wide_case(dice: Dice, reach: int = 900) -> Case:
    """Return a hard scene with colours and intensities of any size, and coordinate exponents from −reach to reach."""
    case = hard_case(dice, dice.choice(("standard", "standard", "vtk")), reach)
    colors = ("ambient", "diffuse", "specular")
    material = replace(case.material, emission=color_of(dice), **{name: color_of(dice) for name in colors})
    lights = [
        replace(light, intensity=positive_of(dice), **{name: color_of(dice) for name in colors})
        for light in case.scene.lights
    ]
    model = replace(case.scene.light_model, ambient=color_of(dice))
    albedo = np.array([[min(positive_of(dice), 1.0) for _ in range(3)] for _ in case.points])
    scene = replace(case.scene, lights=lights, light_model=model)
    return replace(case, scene=scene, material=material, albedo=albedo if dice.likely(30) else None)


# --- many vertices, for tests of identical bits ---


def rows_of(case: Case, rows: Any) -> Case:
    """Return the case with a selection of its vertices, in any order."""
    albedo = None if case.albedo is None else case.albedo[rows]
    return replace(case, points=case.points[rows], normals=case.normals[rows], albedo=albedo)


def mixed_case(dice: Dice, reach: int = 100) -> Case:
    """Return an ordinary or hard scene with many vertices near its own, some of them spoiled.

    Sometimes they fill the kernel's blocks, which have a loop of their own.
    """
    convention = dice.choice(("standard", "standard", "vtk"))
    case = moderate_case(dice, convention) if dice.likely(60) else hard_case(dice, convention, reach, 5.0)
    rng = np.random.default_rng(dice.getrandbits(64))
    count = dice.choice((dice.randint(30, 70), dice.randint(128, 300)))
    drawn = len(case.points)
    rows = np.concatenate([np.arange(drawn), rng.integers(0, drawn, count)])
    near = 1.0 + 0.1 * rng.normal(size=(2, len(rows), 3))
    near[:, :drawn] = 1.0  # keep lights on a vertex, and vertices on the edge of a cone
    case = rows_of(case, rows)
    with np.errstate(all="ignore"):
        return replace(case, points=case.points * near[0], normals=case.normals * near[1])


def in_either_type(dice: Dice, case: Case) -> Case:
    """Return the case with points, normals or both in float32, for which evaluators take other paths."""
    narrow = np.float32
    types = dice.choice(((float, float), (narrow, narrow), (narrow, narrow), (narrow, float), (float, narrow)))
    with np.errstate(over="ignore", under="ignore"):
        return replace(case, points=case.points.astype(types[0]), normals=case.normals.astype(types[1]))


def _strided(a: np.ndarray) -> np.ndarray:
    wide = np.full((2 * len(a), a.shape[1] + 2), 7.0, a.dtype)
    wide[::2, 1:-1] = a
    return wide[::2, 1:-1]


def _read_only(a: np.ndarray) -> np.ndarray:
    copy = a.copy()
    copy.setflags(write=False)
    return copy


LAYOUTS: dict[str, Callable[[np.ndarray], Any]] = {
    "by columns": np.asfortranarray,
    "strided": _strided,
    "upside down": lambda a: a[::-1].copy()[::-1],
    "backwards": lambda a: a[::-1, ::-1].copy()[::-1, ::-1],
    "read-only": _read_only,
    "unaligned": lambda a: np.frombuffer(b"\0" + a.tobytes(), dtype=a.dtype, offset=1).reshape(a.shape),
    "swapped bytes": lambda a: a.astype(a.dtype.newbyteorder()),
    "pyvista": pv.pyvista_ndarray,
}
"""Memory layouts of an array that keep its values."""


# --- scenes that a plan can simplify ---


@dataclass(frozen=True)
class Promise:
    """A case and the tolerance of its plan."""

    case: Case
    tolerance: float


def _far_light(dice: Dice, centre: np.ndarray, radius: float, aim: np.ndarray) -> Any:
    """Return a light that is far, weak or nearly uniform over the mesh, or has the mesh near the edge of its cone."""
    away = unit(aim + dice.vector() * dice.choice((0.0, 0.1, 1.0)))
    distance = radius * dice.log_between(1.5, 1e7)
    common: dict[str, Any] = {
        "diffuse": dice.color(),
        "specular": None if dice.likely(50) else dice.color(),
        "ambient": 0.0 if dice.likely(60) else dice.color(),
        "intensity": dice.log_between(1e-7, 1.0) if dice.likely(40) else 1.0,
    }
    kind = dice.choice(("directional", "point", "point", "spot", "spot"))
    if kind == "directional":
        frame = "headlight" if dice.likely(30) else "world"
        return DirectionalLight(direction=triple(-away), frame=frame, **common)
    position = centre + away * distance
    attenuation = dice.choice(
        ((1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, 0.0, 0.0), (0.0, 1.0 / distance, 0.0), (0.0, 0.0, distance**-2))
    )
    common |= {"position": triple(position), "attenuation": attenuation}
    if kind == "point":
        return PointLight(**common)
    seen = math.degrees(math.asin(min(radius / distance, 1.0)))
    cone_angle = min(90.0, max(1e-5, dice.choice((dice.uniform(1.0, 90.0), seen * dice.uniform(0.3, 3.0)))))
    side = unit(np.cross(away, dice.unit_vector() + 1e-3))
    tilt = math.radians(dice.choice((0.0, seen, cone_angle, cone_angle + seen)) * dice.uniform(0.0, 1.1))
    axis = rotation(side, tilt) @ -away
    exponent = dice.choice((0.0, dice.random(), 1.0, dice.log_between(1.0, 1e3)))
    return SpotLight(direction=triple(axis), cone_angle=cone_angle, exponent=exponent, **common)


def promising_case(dice: Dice) -> Promise:
    """Return a cluster of vertices with a narrow or wide cone of normals, and viewer and lights at any distance."""
    radius, centre = dice.log_between(1e-3, 1e3), dice.vector() * dice.choice((0.0, 1.0, 1e3))
    vtk = dice.likely(25)
    n, shininess = dice.unit_vector(), dice.shininess() if dice.likely(30) else dice.log_between(1.0, 1e4)
    v = unit(n + dice.vector() * dice.choice((0.1, 0.7, 2.0)))
    mirrored = 2.0 * float(n @ v) * n - v
    width = dice.log_between(1e-4, 1.0)
    rng = np.random.default_rng(dice.getrandbits(64))
    points = centre + radius * np.clip(rng.normal(size=(24, 3)), -1, 1)
    # Some normals are where the highlight is steepest, about 1/√n from the mirror direction.
    spread = np.where(rng.uniform(size=(24, 1)) < 0.5, width, 0.5 / math.sqrt(1.0 + shininess))
    normals = n + spread * rng.normal(size=(24, 3))
    eye = centre + v * radius * dice.log_between(1.5, 1e7)
    fields: dict[str, Any] = {"ambient": dice.color(), "clamp": dice.likely(30), "two_sided": dice.likely(20)}
    if not vtk:
        fields |= {"local_viewer": dice.likely(75), "reflection": dice.choice(("phong", "blinn-phong"))}
    model = replace(LightModel.vtk() if vtk else LightModel(), **fields)
    lights = [_far_light(dice, centre, radius, mirrored) for _ in range(dice.randint(1, 4))]
    material = Material(**{name: dice.color() for name in ("ambient", "diffuse", "specular")}, shininess=shininess)
    matrix = None if dice.likely(70) else matrix_of(dice, dice.choice(MATRIX_CLASSES))
    viewer = Viewer(triple(eye), triple(centre), triple(dice.unit_vector()), parallel=dice.likely(10))
    case = Case(points, normals, Scene(lights, viewer, model), material, matrix)
    return Promise(case, dice.log_between(1e-6, 0.1))
